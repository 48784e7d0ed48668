/* What is known besides the data, as terms of the objective that no sample has.
 *
 * A prior p = mean +- sd is one more datum. Its residual is sqrt(w) (p - mean) with w = s2 / sd^2, where s2 is the variance of one
 * unit of the objective: 1 with sigma weights, else what the data alone show. For noise of unequal variance that is a different
 * number for every parameter, V_pp / (H^-1)_pp with V the sandwich: then, to first order, the estimate is the mean of data and
 * prior by their inverse variances, 1/V_pp and 1/sd^2. Where the data do not determine the parameter, s2 is that of the mean
 * sample, 2 objective / (values - parameters).
 *
 * Energy: K max(0, a - 1 + t)^2 for the directional albedo a of each channel at some views. That is the augmented Lagrangian of a
 * <= 1 (Hestenes 1969, Powell 1969, Rockafellar 1973): after each minimisation the shifts t grow by what is left of the violation,
 * and K with them while that does not fall. The views are those where the albedo of the last minimum has a peak above 1. */
#include "internal_penalties.h"
#include "models/tools/internal_albedo.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

#define PI       3.14159265358979323846
#define FF_STIFF 1e4 /* of the constraint in the covariance, relative to the data's own stiffness */

/* ---- making ---------------------------------------------------------------------------------- */

/* Place of a model's parameter among the free ones, -1 when it is held. */
static int free_place(const ff_layout *l, ff_param_ref at)
{
    const int is_shape = at.kind == FF_PARAM_SHAPE;
    const uint32_t *index = is_shape ? l->free.shape : l->free.channel, n = is_shape ? l->free.n_shape : l->free.n_channel;
    for (uint32_t k = 0; k < n; k++)
        if (index[k] == at.index) return (int)k;
    return -1;
}

/* The first column of the parameters of its kind. */
static size_t first_column(const ff_layout *l, ff_param_ref at)
{
    return at.kind == FF_PARAM_SHAPE ? 0 : l->free.n_shape;
}

/* Of one word there is one term for a coordinate. */
static void add_term(ff_penalties *e, size_t from, const ff_prior_term *term)
{
    for (size_t i = from; i < e->n_priors; i++)
        if (e->prior[i].coordinate == term->coordinate) return;
    e->prior[e->n_priors++] = *term;
}

/* Is parameter `at` of a lobe tied to that in its place in another one? */
static int is_tied_across(const ff_layout *l, ff_param_ref at, uint32_t lobe, uint32_t other)
{
    const ff_lobe *from = &l->m->lobe[lobe], *to = &l->m->lobe[other];
    const uint32_t shift = at.kind == FF_PARAM_SHAPE ? to->shape0 - from->shape0 : to->channel0 - from->channel0;
    const int i = free_place(l, at), k = free_place(l, (ff_param_ref){at.kind, at.index + shift});
    const size_t columns = first_column(l, at);
    return i >= 0 && k >= 0 && ff_layout_coordinate(l, 0, columns + (size_t)i) == ff_layout_coordinate(l, 0, columns + (size_t)k);
}

/* channel: the one that it names, -1 = all. */
static void add_prior(ff_penalties *e, const ff_layout *l, ff_shape shape, const ff_prior *p, int channel)
{
    ff_param_ref at[2];
    const int n = ff_constraints_named(l->m, shape, p->name, at);
    const size_t from = e->n_priors;
    for (int i = 0; i < n; i++) {
        const int k = free_place(l, at[i]);
        e->named[e->n_named++] = (ff_named_prior){at[i], k >= 0, channel, p->mean, p->sd};
        ff_prior_term t = {.mean = p->mean, .sd = p->sd, .alone = NAN, .error = NAN};
        t.lobe = ff_model_param_at(l->m, at[i])->lobe;
        for (uint32_t other = 0; other < l->m->n_lobes && t.lobe < l->m->n_lobes; other++)
            t.apart |= (uint32_t)(other != t.lobe && !is_tied_across(l, at[i], t.lobe, other)) << other;
        for (size_t c = 0; c < (at[i].kind == FF_PARAM_SHAPE ? 1 : l->n_channels) && k >= 0; c++) {
            if (channel >= 0 && c != (size_t)channel) continue;
            t.coordinate = ff_layout_coordinate(l, c, first_column(l, at[i]) + (size_t)k);
            add_term(e, from, &t);
        }
    }
}

/* Priors of channels that the problem has; where it is one of several, those of the others are not its own. */
static ff_status add_priors(ff_penalties *e, const ff_constraints *c, const ff_layout *l, const struct ff_problem *p,
                            ff_shape shape, ff_error *err)
{
    for (size_t i = 0; i < c->n_priors; i++) {
        const ff_prior *prior = &c->prior[i];
        int channel = -1;
        const ff_status status = prior->channel ? ff_channel_find(p, prior->name, prior->channel, &channel, err) : FF_OK;
        if (status) return status;
        if (channel >= 0 || !prior->channel) add_prior(e, l, shape, prior, channel);
    }
    return FF_OK;
}

ff_status ff_penalties_new(const ff_constraints *c, const ff_layout *l, const struct ff_problem *p, ff_shape shape,
                           ff_penalties **out, ff_error *err)
{
    *out = NULL;
    if (!c || (c->n_priors == 0 && !c->energy_conserving)) return FF_OK;
    ff_penalties *e = calloc(1, sizeof *e);
    if (!e) return ff_error_set(err, FF_ERR_MEMORY, NULL, 0, -1, "out of memory");
    e->prior = calloc(2 * c->n_priors * l->n_channels + 1, sizeof *e->prior);
    e->named = calloc(2 * c->n_priors + 1, sizeof *e->named);
    e->energy = (ff_energy){.wanted = c->energy_conserving && l->m->n_lobes + l->m->n_bases > 0, .C = l->n_channels};
    if (e->energy.wanted) e->energy.shift = calloc(FF_VIEWS * l->n_channels, sizeof *e->energy.shift);
    if (!e->prior || !e->named || (e->energy.wanted && !e->energy.shift)) {
        ff_penalties_free(e);
        return ff_error_set(err, FF_ERR_MEMORY, NULL, 0, -1, "out of memory");
    }
    const ff_status status = add_priors(e, c, l, p, shape, err);
    if (status)
        ff_penalties_free(e);
    else
        *out = e;
    return status;
}

void ff_penalties_free(ff_penalties *e)
{
    if (!e) return;
    free(e->prior);
    free(e->named);
    free(e->energy.shift);
    free(e->energy.row);
    free(e->energy.row_channel);
    free(e);
}

int ff_penalties_tell_apart(const ff_plan *plan, uint32_t a, uint32_t b)
{
    const ff_penalties *e = plan->penalties;
    for (size_t i = 0; e && i < e->n_priors; i++) {
        const ff_prior_term *t = &e->prior[i];
        if ((t->lobe == a && t->apart >> b & 1) || (t->lobe == b && t->apart >> a & 1)) return 1;
    }
    return 0;
}

int ff_penalties_prior(const ff_penalties *e, ff_param_ref at, size_t c, double *mean, double *sd)
{
    for (size_t i = 0; e && i < e->n_named; i++)
        if (ff_param_is(e->named[i].at, at) && (e->named[i].channel < 0 || (size_t)e->named[i].channel == c)) {
            *mean = e->named[i].mean;
            *sd = e->named[i].sd;
            return 1;
        }
    return 0;
}

/* ---- albedos --------------------------------------------------------------------------------- */

void ff_view_at(double mu, double phi, double wo[3])
{
    const double side = sqrt((1 - mu) * (1 + mu));
    wo[0] = side * cos(phi);
    wo[1] = side * sin(phi);
    wo[2] = mu;
}

typedef struct albedo_work {
    const ff_albedo_parts *parts;
    const double (*wo)[3];
    double *out;
    size_t stride;       /* doubles of a view */
    ff_block_work *work; /* [threads] */
} albedo_work;

static void one_view(void *context, size_t i, int worker)
{
    const albedo_work *w = context;
    ff_albedo_parts_at(w->parts, FF_ALBEDO_ORDER, w->wo[i], &w->work[worker], w->out + i * w->stride);
}

ff_status ff_penalties_albedos(const ff_plan *plan, int parallel, const double *shape, const double *channel,
                               const ff_wanted *wanted, size_t n, const double (*wo)[3], double *out)
{
    const ff_layout *l = &plan->l;
    const struct ff_problem *p = plan->p;
    const ff_wanted none = {.n_shape = 0}, *w = wanted ? wanted : &none;
    albedo_work work = {.wo = wo, .out = out, .stride = l->n_channels * (1 + w->n_shape + w->n_channel)};
    ff_albedo_parts *parts;
    const ff_status status = ff_albedo_parts_make(l->m, ff_kernels_get(p->isa), l->mode, l->n_channels, shape, channel, w, &parts);
    if (status) return status;
    work.parts = parts;
    work.work = ff_block_work_new(parallel ? (size_t)ff_pool_threads(p->pool) : 1);
    if (!work.work) {
        ff_albedo_parts_free(parts);
        return FF_ERR_MEMORY;
    }
    if (parallel)
        ff_pool_run(p->pool, n, one_view, &work);
    else
        for (size_t i = 0; i < n; i++) one_view(&work, i, 0);
    free(work.work);
    ff_albedo_parts_free(parts);
    return FF_OK;
}

void ff_penalties_gradient(const ff_layout *l, size_t c, const double *column, const double *slope, double *row)
{
    memset(row, 0, (l->n_shared + l->n_own) * sizeof *row);
    for (size_t k = 0; k < (size_t)l->free.n_shape + l->free.n_channel; k++)
        row[ff_layout_coordinate(l, 0, k)] += column[k] * (slope ? slope[ff_layout_coordinate(l, c, k)] : 1);
}

/* ---- terms ----------------------------------------------------------------------------------- */

double ff_layout_value(const ff_layout *l, size_t coordinate, const double *shape, const double *channel)
{
    size_t c;
    const ff_model_param *p = ff_layout_param(l, coordinate, &c);
    return coordinate < l->n_shared && p >= l->m->shape && p < l->m->shape + l->m->n_shape
               ? shape[p - l->m->shape]
               : channel[c * l->m->n_channel + (size_t)(p - l->m->channel)];
}

double ff_penalties_mismatch(const ff_plan *plan, const double *shape, const double *channel)
{
    const ff_penalties *e = plan->penalties;
    double sum = 0;
    for (size_t i = 0; e && i < e->n_priors; i++) {
        const ff_prior_term *t = &e->prior[i];
        sum += pow((ff_layout_value(&plan->l, t->coordinate, shape, channel) - t->mean) / t->sd, 2);
    }
    return sum;
}

static ff_status add_energy(const ff_energy *e, const ff_plan *plan, int parallel, const double *shape, const double *channel,
                            const double *slope, ff_gram *g)
{
    const ff_layout *l = &plan->l;
    const size_t size = 1 + l->free.n_shape + l->free.n_channel;
    double *a = malloc((e->n * e->C * size + 1) * sizeof *a), row[FF_MAX_COLUMNS];
    if (!a) return FF_ERR_MEMORY;
    const ff_status status = ff_penalties_albedos(plan, parallel, shape, channel, &l->free, e->n, e->wo, a);
    for (size_t i = 0; i < e->n * e->C && !status; i++) {
        const double over = a[i * size] - 1 + e->shift[i];
        if (over <= 0) continue;
        ff_penalties_gradient(l, i % e->C, a + i * size + 1, slope, row);
        ff_gram_add_row(g, i % e->C, e->weight, over, row);
    }
    free(a);
    return status;
}

/* A datum of one coordinate, d = the derivative of its parameter. What all channels share counts with the first. */
static void add_prior_row(const ff_prior_term *t, double weight, double off, double d, ff_gram *g)
{
    const size_t k = t->coordinate, c = k < g->S ? 0 : (k - g->S) / g->K;
    double row[FF_MAX_COLUMNS] = {0};
    row[k - c * g->K] = d;
    ff_gram_add_row(g, c, weight, off, row);
}

ff_status ff_penalties_add(const ff_plan *plan, int parallel, const double *shape, const double *channel, const double *slope,
                           ff_gram *g)
{
    const ff_penalties *e = plan->penalties;
    const ff_layout *l = &plan->l;
    if (!e) return FF_OK;
    for (size_t i = 0; i < e->n_priors; i++) {
        const ff_prior_term *t = &e->prior[i];
        if (t->weight == 0) continue;
        add_prior_row(t, t->weight, ff_layout_value(l, t->coordinate, shape, channel) - t->mean, slope[t->coordinate], g);
    }
    return e->energy.weight > 0 ? add_energy(&e->energy, plan, parallel, shape, channel, slope, g) : FF_OK;
}

void ff_penalties_inform(const ff_plan *plan, ff_gram *g)
{
    const ff_penalties *e = plan->penalties;
    if (!e) return;
    for (size_t i = 0; i < e->n_priors; i++) add_prior_row(&e->prior[i], e->prior[i].weight, 0, 1, g);
    for (size_t r = 0; r < e->energy.n_rows; r++) /* so stiff that nothing moves across the constraint */
        ff_gram_add_row(g, e->energy.row_channel[r], FF_STIFF * e->energy.scale, 0, e->energy.row + r * (g->S + g->K));
}

double ff_penalties_noise(const ff_plan *plan, size_t k)
{
    const ff_penalties *e = plan->penalties;
    double sum = 0;
    for (size_t i = 0; e && i < e->n_priors; i++)
        if (e->prior[i].coordinate == k) sum += e->prior[i].weight * e->prior[i].noise;
    return sum;
}

double ff_penalties_weight(const ff_plan *plan, size_t k)
{
    const ff_penalties *e = plan->penalties;
    double sum = 0;
    for (size_t i = 0; e && i < e->n_priors; i++)
        if (e->prior[i].coordinate == k) sum += e->prior[i].weight;
    return sum;
}

/* ---- what is said of them -------------------------------------------------------------------- */

double ff_penalties_penalty(const ff_penalties *e)
{
    double sum = 0;
    for (size_t i = 0; e && i < e->n_priors; i++) sum += 0.5 * e->prior[i].weight * pow(e->prior[i].value - e->prior[i].mean, 2);
    return sum;
}

static ff_status warn_of_held(const ff_named_prior *n, ff_warnings *out)
{
    const ff_warning_parameter parameter = {n->at, FF_NO_CHANNEL};
    const ff_warning w = {.code = FF_WARNING_PRIOR_WITHOUT_EFFECT, .n_parameters = 1, .parameter = &parameter};
    return n->is_free ? FF_OK : ff_warnings_add(out, &w);
}

static ff_status warn_of_disagreement(const ff_layout *l, const ff_prior_term *t, ff_warnings *out)
{
    const double apart = fabs(t->alone - t->mean), joint = hypot(t->error, t->sd);
    if (!(apart > 3 * joint)) return FF_OK; /* also where the data do not determine it */
    const double value[] = {t->alone, t->error, t->mean, t->sd};
    return ff_layout_warn(l, t->coordinate, FF_WARNING_PRIOR_DISAGREES, value, out);
}

static ff_status warn_of_energy(const ff_energy *e, double objective, ff_warnings *out)
{
    const double theta = acos(fmin(e->alone_mu, 1)) * 180 / PI, ratio = 2 * objective / fmax(e->alone_cost2, 1e-300);
    const ff_warning w = {.code = FF_WARNING_ALBEDO_ABOVE_ONE,
                          .n_channels = e->C > 1,
                          .channel = &e->alone_channel,
                          .value = {e->alone, theta, ratio}};
    const ff_status status = e->binds ? ff_warnings_add(out, &w) : FF_OK;
    return status || !(e->left > 2 * FF_ALBEDO_LEFT) ? status : ff_warnings_say(out, FF_WARNING_ENERGY_NOT_CONSERVED, &e->left);
}

ff_status ff_penalties_warnings(const ff_plan *plan, double objective, ff_warnings *out)
{
    const ff_penalties *e = plan->penalties;
    ff_status status = FF_OK;
    if (!e) return status;
    for (size_t i = 0; i < e->n_named && !status; i++) status = warn_of_held(&e->named[i], out);
    for (size_t i = 0; i < e->n_priors && !status; i++) status = warn_of_disagreement(&plan->l, &e->prior[i], out);
    return status ? status : warn_of_energy(&e->energy, objective, out);
}
