/* The order of lobes of one kind. */
#include "internal_problem.h"
#include <math.h>
#include <string.h>

/* What orders them: the width of a stretched lobe, else the first parameter. */
static double order_key(const ff_model *m, uint32_t l, const double *shape)
{
    ff_lobe_pass pass;
    const ff_lobe *lobe = &m->lobe[l];
    if (lobe->n_shape == 0 || ff_ndf_at(lobe->ndf)->stretch) return lobe->n_shape ? shape[lobe->shape0] : 0;
    ff_model_lobe(m, l, shape, &pass, NULL);
    return pass.s.ax * pass.s.ay * sqrt(1 - pass.s.r * pass.s.r);
}

static int held_alike(const ff_model_param *a, const ff_model_param *b)
{
    const uint32_t held = a->flags & FF_PARAM_HELD;
    return held == (b->flags & FF_PARAM_HELD) && (!held || a->init == b->init) && a->lo == b->lo && a->hi == b->hi;
}

/* Would the sum be the same with the two lobes exchanged, and nothing that is held move? */
static int same_kind(const ff_model *m, uint32_t a, uint32_t b)
{
    const ff_lobe *x = &m->lobe[a], *y = &m->lobe[b];
    const int shared = ff_model_group(m, a) == ff_model_group(m, b);
    if (x->ndf != y->ndf || x->masking != y->masking || x->table != y->table || !(shared || x->fresnel == y->fresnel)) return 0;
    for (uint32_t k = 0; k < x->n_shape && k < y->n_shape; k++)
        if (!held_alike(&m->shape[x->shape0 + k], &m->shape[y->shape0 + k])) return 0;
    for (uint32_t k = 0; !shared && k < x->n_channel; k++)
        if (!held_alike(&m->channel[x->channel0 + k], &m->channel[y->channel0 + k])) return 0;
    return 1;
}

static void swap(double *a, double *b, size_t n)
{
    for (size_t i = 0; i < n; i++) {
        const double t = a[i];
        a[i] = b[i];
        b[i] = t;
    }
}

/* Exchanges what belongs to lobes a and b but for the weights. */
static void exchange(const ff_model *m, uint32_t a, uint32_t b, size_t n_channels, double *shape, double *channel)
{
    const ff_lobe *x = &m->lobe[a], *y = &m->lobe[b];
    const size_t n = x->n_shape < y->n_shape ? x->n_shape : y->n_shape; /* `weight` is the last of a lobe that shares */
    swap(shape + x->shape0, shape + y->shape0, n - (size_t)(x->fresnel == FF_FRESNEL_SHARED && y->fresnel == FF_FRESNEL_SHARED));
    if (ff_model_group(m, a) == ff_model_group(m, b)) return;
    for (size_t c = 0; c < n_channels; c++)
        swap(channel + c * m->n_channel + x->channel0, channel + c * m->n_channel + y->channel0, x->n_channel);
}

/* Shares that give these weights; see ff_model_weights. */
static void set_weights(const ff_model *m, const double *weight, double *shape)
{
    double up_to = weight[0];
    for (uint32_t l = 1; l < m->n_lobes; l++) {
        if (m->lobe[l].fresnel != FF_FRESNEL_SHARED) continue;
        up_to += weight[l];
        shape[m->lobe[l].shape0 + m->lobe[l].n_shape - 1] = up_to > 0 ? weight[l] / up_to : 0;
    }
}

/* ---- what tells lobes apart ------------------------------------------------------------------ */

/* Where parameter i goes when the slices [a0, a0 + n) and [b0, b0 + n) change places. */
static uint32_t exchanged(uint32_t i, uint32_t a0, uint32_t b0, uint32_t n)
{
    if (i >= a0 && i < a0 + n) return i - a0 + b0;
    return i >= b0 && i < b0 + n ? i - b0 + a0 : i;
}

/* The free parameter that parameter i stands for among n of them: itself or what it follows. -1 when it is not free. */
static int leader_of(const uint32_t *index, const int *follows, uint32_t n, uint32_t i)
{
    for (uint32_t k = 0; k < n; k++)
        if (index[k] == i) return follows[k] < 0 ? (int)k : follows[k];
    return -1;
}

/* Are the same parameters tied after the exchange? */
static int ties_alike(const uint32_t *index, const int *follows, uint32_t n, uint32_t a0, uint32_t b0, uint32_t size)
{
    for (uint32_t i = 0; i < n; i++)
        for (uint32_t k = 0; k < i; k++) {
            const int before = leader_of(index, follows, n, index[i]) == leader_of(index, follows, n, index[k]);
            const uint32_t x = exchanged(index[i], a0, b0, size), y = exchanged(index[k], a0, b0, size);
            if (before != (leader_of(index, follows, n, x) == leader_of(index, follows, n, y))) return 0;
        }
    return 1;
}

static int shared_alike(const ff_layout *l, uint32_t a0, uint32_t b0, uint32_t size)
{
    for (uint32_t k = 0; k < l->free.n_channel; k++)
        for (uint32_t j = 0; j < l->free.n_channel; j++)
            if (l->free.channel[j] == exchanged(l->free.channel[k], a0, b0, size) && l->channel_shared[j] != l->channel_shared[k])
                return 0;
    return 1;
}

/* Do bounds and ties of lobes of one kind leave it open which is which? */
static int is_symmetric(const ff_layout *l, uint32_t a, uint32_t b)
{
    const ff_model *m = l->m;
    const ff_lobe *x = &m->lobe[a], *y = &m->lobe[b];
    for (uint32_t k = 0; k < l->free.n_shape; k++) { /* weights are not exchanged but set anew */
        const ff_model_param *p = &m->shape[l->free.shape[k]];
        if (strcmp(p->info->name, "weight") != 0) continue;
        if (l->shape_follows[k] >= 0 || p->lo != p->info->lo || p->hi != p->info->hi) return 0;
    }
    for (size_t c = 0; c < l->n_channels && l->limits && ff_model_group(m, a) != ff_model_group(m, b); c++)
        for (uint32_t k = 0; k < x->n_channel; k++)
            if (ff_layout_lo(l, c, x->channel0 + k) != ff_layout_lo(l, c, y->channel0 + k) ||
                ff_layout_hi(l, c, x->channel0 + k) != ff_layout_hi(l, c, y->channel0 + k))
                return 0;
    if (!l->tied) return 1;
    const uint32_t n_shape = x->n_shape < y->n_shape ? x->n_shape : y->n_shape,
                   n_channel = x->n_channel < y->n_channel ? x->n_channel : y->n_channel;
    const int scale = leader_of(l->free.shape, l->shape_follows, l->free.n_shape, x->shape0);
    if (scale >= 0 && scale == leader_of(l->free.shape, l->shape_follows, l->free.n_shape, y->shape0))
        return 0; /* no order in it */
    return ties_alike(l->free.shape, l->shape_follows, l->free.n_shape, x->shape0, y->shape0, n_shape) &&
           ties_alike(l->free.channel, l->channel_follows, l->free.n_channel, x->channel0, y->channel0, n_channel) &&
           shared_alike(l, x->channel0, y->channel0, n_channel);
}

int ff_plan_exchangeable(const ff_plan *plan, uint32_t a, uint32_t b)
{
    return same_kind(plan->l.m, a, b) && !ff_penalties_tell_apart(plan, a, b) && is_symmetric(&plan->l, a, b);
}

/* Would the parameters be nearer to their priors with the lobes exchanged? */
static int nearer_priors(const ff_plan *plan, uint32_t a, uint32_t b, double *shape, double *channel)
{
    const double before = ff_penalties_mismatch(plan, shape, channel);
    exchange(plan->l.m, a, b, plan->l.n_channels, shape, channel);
    const double after = ff_penalties_mismatch(plan, shape, channel);
    exchange(plan->l.m, a, b, plan->l.n_channels, shape, channel);
    return after < before;
}

/* ---- the order ------------------------------------------------------------------------------- */

/* Exchanges lobes of one kind; plan NULL: whatever was said of their parameters. Where priors say which is which, they decide. */
static int order(const ff_model *m, const ff_plan *plan, size_t n_channels, double *shape, double *channel)
{
    double weight[FF_MAX_LOBES];
    int moved = 0;
    ff_model_weights(m, shape, weight, NULL);
    for (uint32_t pass = 1; pass < m->n_lobes; pass++)
        for (uint32_t a = 0; a < m->n_lobes; a++)
            for (uint32_t b = a + 1; b < m->n_lobes; b++) {
                const int named = plan && ff_penalties_tell_apart(plan, a, b);
                if (!same_kind(m, a, b) || (plan && !is_symmetric(&plan->l, a, b))) continue;
                if (!named && order_key(m, a, shape) <= order_key(m, b, shape)) continue;
                if (named && (ff_model_group(m, a) == ff_model_group(m, b) || !nearer_priors(plan, a, b, shape, channel))) continue;
                exchange(m, a, b, n_channels, shape, channel);
                if (ff_model_group(m, a) == ff_model_group(m, b)) swap(&weight[a], &weight[b], 1);
                moved = 1;
            }
    if (moved) set_weights(m, weight, shape);
    return moved;
}

int ff_lobes_order(const ff_model *m, size_t n_channels, double *shape, double *channel)
{
    return order(m, NULL, n_channels, shape, channel);
}

int ff_plan_order(const ff_plan *plan, double *shape, double *channel)
{
    return order(plan->l.m, plan, plan->l.n_channels, shape, channel);
}
