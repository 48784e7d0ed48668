/* What the caller knows of the parameters, by name, in terms of a model: bounds, and which parameters are equal. */
#include "internal_layout.h"
#include <math.h>
#include <string.h>

/* ---- names ----------------------------------------------------------------------------------- */

int ff_constraints_named(const ff_model *m, ff_shape shape, const char *name, ff_param_ref at[2])
{
    char x[FF_PARAM_NAME], y[FF_PARAM_NAME];
    const int axes = ff_model_alpha_axes(m, name, x, y), isotropic = shape == FF_SHAPE_ISOTROPIC;
    at[0] = ff_model_param_find(m, axes ? x : name);
    if (at[0].kind == FF_PARAM_NONE) return 0;
    if (isotropic && strcmp(ff_model_param_at(m, at[0])->info->name, "alpha_y") == 0) at[0].index--; /* it is alpha_x */
    if (!axes || isotropic) return 1;
    at[1] = ff_model_param_find(m, y);
    return 2;
}

/* ---- bounds ---------------------------------------------------------------------------------- */

static ff_status disjoint(const char *one, const char *other, ff_error *err)
{
    return ff_error_set(err, FF_ERR_RANGE, NULL, 0, -1, "%s and %s are to be equal, and their bounds do not overlap", one, other);
}

/* Gives both the bounds that they have in common, at least where something is free. */
static ff_status share_bounds(ff_model_param *a, ff_model_param *b, ff_error *err)
{
    const double lo = fmax(a->lo, b->lo), hi = fmin(a->hi, b->hi);
    if (!(lo < hi)) return disjoint(a->name, b->name, err);
    a->lo = b->lo = lo;
    a->hi = b->hi = hi;
    if (!(a->flags & FF_PARAM_HELD)) a->init = fmin(fmax(a->init, lo), hi);
    return FF_OK;
}

/* A value or a bound of its channels is one of a parameter that has such. */
static ff_status check_per_channel(const ff_model *m, const char *name, ff_error *err)
{
    if (ff_model_param_find(m, name).kind == FF_PARAM_CHANNEL) return FF_OK;
    return ff_error_set(err, FF_ERR_UNSUPPORTED, NULL, 0, -1, "%s has one value for all channels", name);
}

/* A channel that may go beyond the box takes the parameter there; the others have their bounds. */
static void take_box(const ff_model *from, const char *name, ff_model *m)
{
    const ff_param_ref at = ff_model_param_find(from, name);
    if (at.kind == FF_PARAM_CHANNEL) m->channel[at.index].info = from->channel[at.index].info;
}

/* Holds m where every channel is held, and nothing where that is one of them. All values have to lie in the box and in the bounds.
 */
static ff_status apply_fixed(const ff_constraints *c, ff_model *m, ff_error *err)
{
    ff_status status = FF_OK;
    for (size_t i = 0; i < c->n_fixed && !status; i++) {
        const ff_fixed *f = &c->fixed[i];
        const int known = ff_model_param_find(m, f->name).kind != FF_PARAM_NONE;
        if (!known && c->where_present) continue;
        ff_model one = *m;
        for (size_t k = f->n; k-- > 0 && !status;) status = ff_model_hold(&one, f->name, f->value[k], err);
        if (!status && f->channel) take_box(&one, f->name, m);
        if (!status) status = check_per_channel(m, f->name, err);
        if (!status && !f->channel) *m = one;
    }
    return status;
}

/* Is a value outside the bounds of its parameter? */
static ff_status check_fixed(const ff_constraints *c, const ff_model *m, ff_error *err)
{
    for (size_t i = 0; i < c->n_fixed; i++) {
        const ff_param_ref at = ff_model_param_find(m, c->fixed[i].name);
        if (at.kind != FF_PARAM_CHANNEL) continue;
        const ff_model_param *p = &m->channel[at.index];
        const double hi = p->hi == ff_param_box_end(p->info) ? p->info->hi : p->hi;
        for (size_t k = 0; k < c->fixed[i].n; k++)
            if (!(c->fixed[i].value[k] >= p->lo && c->fixed[i].value[k] <= hi))
                return ff_error_set(err, FF_ERR_RANGE, NULL, 0, -1, "%s is held at %g, outside its bounds [%g, %g]", p->name,
                                    c->fixed[i].value[k], p->lo, p->hi);
    }
    return FF_OK;
}

static ff_status apply_bounds(const ff_constraints *c, ff_shape shape, ff_model *m, ff_error *err)
{
    ff_status status = FF_OK;
    for (size_t i = 0; i < c->n_bounds && !status; i++) {
        ff_model one = *m; /* a bound of one channel is not the model's, but has to make sense all the same */
        const int named = c->bound[i].channel != NULL;
        status = ff_model_bound(named ? &one : m, c->bound[i].name, c->bound[i].lo, c->bound[i].hi, err);
        if (!status && named) status = check_per_channel(m, c->bound[i].name, err);
        if (!status && named) take_box(&one, c->bound[i].name, m);
        if (status == FF_ERR_UNKNOWN && c->where_present) status = FF_OK;
    }
    for (uint32_t k = 0; k < m->n_shape && !status && shape == FF_SHAPE_ISOTROPIC; k++)
        if (strcmp(m->shape[k].info->name, "alpha_x") == 0) status = share_bounds(&m->shape[k], &m->shape[k + 1], err);
    return status;
}

/* ---- ties ------------------------------------------------------------------------------------ */

static uint32_t root_of(const uint32_t *follows, uint32_t i)
{
    while (follows[i] != i) i = follows[i];
    return i;
}

/* Do both mean the same where they have the same value? */
static int alike(const ff_param *a, const ff_param *b)
{
    const uint32_t kind = FF_PARAM_PER_CHANNEL | FF_PARAM_LOG | FF_PARAM_ATANH;
    return (a->flags & kind) == (b->flags & kind) && (!(a->flags & FF_PARAM_LOG) || a->offset == b->offset);
}

static ff_status tie_two(const ff_model *m, ff_param_ref a, ff_param_ref b, ff_ties *ties, ff_error *err)
{
    const ff_model_param *x = ff_model_param_at(m, a), *y = ff_model_param_at(m, b);
    if (a.kind != b.kind)
        return ff_error_set(err, FF_ERR_UNSUPPORTED, NULL, 0, -1,
                            "%s and %s cannot be tied: one has a value for each channel, the other one for all", x->name, y->name);
    if (!alike(x->info, y->info))
        return ff_error_set(err, FF_ERR_UNSUPPORTED, NULL, 0, -1,
                            "%s and %s cannot be tied: they are fitted in different coordinates", x->name, y->name);
    uint32_t *follows = a.kind == FF_PARAM_CHANNEL ? ties->channel : ties->shape;
    const uint32_t i = root_of(follows, a.index), k = root_of(follows, b.index);
    follows[i] = k;
    if (a.kind == FF_PARAM_CHANNEL) ties->shared[k] |= ties->shared[i];
    return FF_OK;
}

static ff_status tie_channels(const ff_model *m, ff_param_ref at, ff_ties *ties, ff_error *err)
{
    if (at.kind == FF_PARAM_SHAPE)
        return ff_error_set(err, FF_ERR_UNSUPPORTED, NULL, 0, -1,
                            "%s has one value for all channels as it is; a tie needs another name", m->shape[at.index].name);
    ties->shared[root_of(ties->channel, at.index)] = 1;
    return FF_OK;
}

static ff_status add_tie(const ff_constraints *c, const ff_tie *tie, ff_shape shape, const ff_model *m, ff_ties *ties,
                         ff_error *err)
{
    ff_param_ref a[2], b[2];
    const int n = ff_constraints_named(m, shape, tie->name, a), n_to = tie->to ? ff_constraints_named(m, shape, tie->to, b) : n;
    if (n == 0 || n_to == 0) return c->where_present ? FF_OK : ff_model_unknown_param(m, n ? tie->to : tie->name, err);
    if (n != n_to)
        return ff_error_set(err, FF_ERR_UNSUPPORTED, NULL, 0, -1, "%s and %s cannot be tied: one has two axes, the other one",
                            tie->name, tie->to);
    ff_status status = FF_OK;
    ties->n++;
    for (int i = 0; i < n && !status; i++) status = tie->to ? tie_two(m, a[i], b[i], ties, err) : tie_channels(m, a[i], ties, err);
    return status;
}

/* Was it held by someone, at a value that is its own? */
static int is_fixed(const ff_model_param *p)
{
    return (p->flags & FF_PARAM_HELD) && !((p->info->flags & FF_PARAM_HELD) && p->init == p->info->init);
}

/* A parameter is held, free and bounded as the one that it follows. */
static ff_status follow(ff_model_param *p, ff_model_param *leader, ff_error *err)
{
    const int held = (leader->flags & FF_PARAM_HELD) != 0;
    if (is_fixed(p) && !(held && p->init == leader->init))
        return ff_error_set(err, FF_ERR_UNSUPPORTED, NULL, 0, -1, "%s is held at %g: it cannot follow %s, which is %s", p->name,
                            p->init, leader->name, held ? "held at another value" : "free");
    const ff_status status = share_bounds(leader, p, err);
    if (status) return status;
    if (held && !(leader->init >= p->lo && leader->init <= p->hi))
        return ff_error_set(err, FF_ERR_RANGE, NULL, 0, -1, "%s follows %s, which is held at %g, outside its bounds [%g, %g]",
                            p->name, leader->name, leader->init, p->lo, p->hi);
    p->flags = (p->flags & ~(uint32_t)FF_PARAM_HELD) | (leader->flags & FF_PARAM_HELD);
    p->init = leader->init;
    return FF_OK;
}

static ff_status follow_all(ff_model_param *p, uint32_t n, uint32_t *follows, ff_error *err)
{
    ff_status status = FF_OK;
    for (uint32_t i = 0; i < n; i++) follows[i] = root_of(follows, i);
    for (int round = 0; round < 2; round++) /* the second time with the bounds that all have in common */
        for (uint32_t i = 0; i < n && !status; i++)
            if (follows[i] != i) status = follow(&p[i], &p[follows[i]], err);
    return status;
}

/* ---- the whole ------------------------------------------------------------------------------- */

/* A lobe that no masking darkens reflects without bound at grazing incidence, whatever its parameters. */
static ff_status check_energy(const ff_model *m, ff_error *err)
{
    for (uint32_t l = 0; l < m->n_lobes; l++) {
        const ff_masking *masking = ff_masking_at(m->lobe[l].masking);
        if (!masking->uses_lambda && !masking->uses_alpha && !masking->planes)
            return ff_error_set(err, FF_ERR_UNSUPPORTED, NULL, 0, -1,
                                "with the masking %s a lobe reflects without bound at grazing incidence: it cannot conserve energy",
                                masking->term.name);
    }
    return FF_OK;
}

static ff_status check_priors(const ff_constraints *c, const ff_model *m, ff_shape shape, ff_error *err)
{
    ff_param_ref at[2];
    for (size_t i = 0; i < c->n_priors; i++) {
        const ff_prior *p = &c->prior[i];
        if (!isfinite(p->mean) || !(p->sd > 0) || !isfinite(p->sd))
            return ff_error_set(err, FF_ERR_RANGE, NULL, 0, -1,
                                "the prior of %s is %g +- %g: expected finite numbers, the second above 0", p->name, p->mean,
                                p->sd);
        if (ff_constraints_named(m, shape, p->name, at) == 0 && !c->where_present) return ff_model_unknown_param(m, p->name, err);
        if (p->channel && ff_constraints_named(m, shape, p->name, at)) {
            const ff_status status = check_per_channel(m, p->name, err);
            if (status) return status;
        }
        for (size_t k = 0; k < i; k++)
            if (strcmp(p->name, c->prior[k].name) == 0 &&
                (!p->channel || !c->prior[k].channel || strcmp(p->channel, c->prior[k].channel) == 0))
                return ff_error_set(err, FF_ERR_UNSUPPORTED, NULL, 0, -1, "%s has two priors", p->name);
    }
    return FF_OK;
}

ff_status ff_constraints_apply(const ff_constraints *c, ff_shape shape, ff_model *m, ff_ties *ties, ff_error *err)
{
    ff_status status = FF_OK;
    *ties = (ff_ties){.n = 0};
    for (uint32_t k = 0; k < FF_MAX_SHAPE; k++) ties->shape[k] = k;
    for (uint32_t k = 0; k < FF_MAX_CHANNEL_PARAMS; k++) ties->channel[k] = k;
    for (uint32_t k = 0; k < m->n_channel; k++)
        if (m->channel[k].flags & FF_PARAM_SHARED) ties->shared[k] = 1, ties->n++;
    for (uint32_t k = 1; k < m->n_shape; k++) /* alpha_y, which stands behind alpha_x */
        if (m->shape[k].flags & FF_PARAM_SHARED) ties->shape[k] = k - 1, ties->n++;
    if (!c) return follow_all(m->shape, m->n_shape, ties->shape, err);
    status = check_priors(c, m, shape, err);
    if (!status && c->energy_conserving) status = check_energy(m, err);
    if (!status) status = apply_fixed(c, m, err);
    if (!status) status = apply_bounds(c, shape, m, err);
    if (!status) status = check_fixed(c, m, err);
    for (size_t i = 0; i < c->n_ties && !status; i++) status = add_tie(c, &c->tie[i], shape, m, ties, err);
    if (!status) status = follow_all(m->shape, m->n_shape, ties->shape, err);
    if (!status) status = follow_all(m->channel, m->n_channel, ties->channel, err);
    for (uint32_t k = 0; k < m->n_channel && !status; k++) ties->shared[k] |= ties->shared[ties->channel[k]];
    return status;
}

ff_status ff_constraints_check(const ff_constraints *c, const ff_model *m, ff_error *err)
{
    ff_model copy = *m;
    ff_ties ties;
    return ff_constraints_apply(c, ff_layout_shape(m, 0, FF_SHAPE_AUTO, 0), &copy, &ties, err);
}

/* Place of a model's parameter among the free ones of its kind, -1 when it is not. */
static int free_place(const uint32_t *index, uint32_t n, uint32_t at)
{
    for (uint32_t k = 0; k < n; k++)
        if (index[k] == at) return (int)k;
    return -1;
}

void ff_layout_tie(ff_layout *l, const ff_ties *ties)
{
    for (uint32_t k = 0; k < l->free.n_shape; k++) {
        const uint32_t at = l->free.shape[k];
        if (ties->shape[at] != at) l->shape_follows[k] = free_place(l->free.shape, l->free.n_shape, ties->shape[at]);
    }
    for (uint32_t k = 0; k < l->free.n_channel; k++) {
        const uint32_t at = l->free.channel[k];
        l->channel_shared[k] = l->n_channels > 1 && ties->shared[at];
        if (ties->channel[at] != at) l->channel_follows[k] = free_place(l->free.channel, l->free.n_channel, ties->channel[at]);
    }
    ff_layout_number(l);
    if (l->scaled && ff_layout_of_channels(l).tied) l->linear = 0; /* products with scales are not tied as their factors are */
}
