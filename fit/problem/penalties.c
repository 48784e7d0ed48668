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
#include "models/tools/internal_albedo.h"
#include "fit/internal_fit.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define PI 3.14159265358979323846

typedef struct prior_term {
    size_t coordinate;
    uint32_t lobe, apart; /* of the parameter that it names, and the lobes that it tells it apart from, bits */
    double mean, sd;
    double noise, weight; /* s2, s2 / sd^2; 0 until the data have been seen       */
    double alone, error;  /* value and standard error by the data alone           */
    double value;         /* with the prior                                       */
} prior_term;

/* A prior and a parameter that it was given to, as ff_model_param_find says; is_free: it has a term. */
typedef struct named_prior {
    int at, is_free;
    double mean, sd;
} named_prior;

enum { VIEWS = 64, LEVELS = 24, ORDER = 6 };
#define ENOUGH 5e-5 /* violation that is left                                                       */
#define STIFF  1e4  /* of the constraint in the covariance, relative to the data's own stiffness    */

typedef struct energy {
    int wanted, binds;
    size_t n, C;
    double wo[VIEWS][3];
    double *shift;          /* [VIEWS][C] */
    double weight;          /* K; 0 = off */
    double scale;           /* what the data oppose to a change of the albedo: their part of cost2 by its square */
    double alone, alone_mu; /* largest albedo by the data alone, and where                      */
    size_t alone_channel;
    double alone_cost2;
    double left; /* violation at the end                                                  */
    size_t n_rows;
    double *row; /* [n_rows][P] gradients of what binds, by parameters of the coordinates   */
} energy;

struct ff_extras {
    size_t n_priors, n_named;
    prior_term *prior;
    named_prior *named;
    energy energy;
};

/* ---- making ---------------------------------------------------------------------------------- */

/* Place of a model's parameter among the free ones, -1 when it is held. */
static int free_place(const ff_layout *l, int at)
{
    const uint32_t *index = at >= 0 ? l->free.shape : l->free.channel, n = at >= 0 ? l->free.n_shape : l->free.n_channel;
    for (uint32_t k = 0; k < n; k++)
        if (index[k] == (uint32_t)(at >= 0 ? at : -1 - at)) return (int)k;
    return -1;
}

/* Of one word there is one term for a coordinate. */
static void add_term(ff_extras *e, size_t from, const prior_term *term)
{
    for (size_t i = from; i < e->n_priors; i++)
        if (e->prior[i].coordinate == term->coordinate) return;
    e->prior[e->n_priors++] = *term;
}

/* Is parameter `at` of a lobe tied to that in its place in another one? */
static int is_tied_across(const ff_layout *l, int at, uint32_t lobe, uint32_t other)
{
    const ff_lobe *from = &l->m->lobe[lobe], *to = &l->m->lobe[other];
    const int shift = at >= 0 ? (int)to->shape0 - (int)from->shape0 : (int)from->channel0 - (int)to->channel0;
    const int i = free_place(l, at), k = free_place(l, at + shift);
    const size_t columns = at >= 0 ? 0 : l->free.n_shape;
    return i >= 0 && k >= 0 && ff_layout_coordinate(l, 0, columns + (size_t)i) == ff_layout_coordinate(l, 0, columns + (size_t)k);
}

static void add_prior(ff_extras *e, const ff_layout *l, ff_shape shape, const ff_prior *p)
{
    int at[2];
    const int n = ff_constraints_named(l->m, shape, p->name, at);
    const size_t from = e->n_priors;
    for (int i = 0; i < n; i++) {
        const int k = free_place(l, at[i]);
        e->named[e->n_named++] = (named_prior){at[i], k >= 0, p->mean, p->sd};
        prior_term t = {.mean = p->mean, .sd = p->sd, .alone = NAN, .error = NAN};
        t.lobe = at[i] >= 0 ? l->m->shape[at[i]].lobe : l->m->channel[-1 - at[i]].lobe;
        for (uint32_t other = 0; other < l->m->n_lobes && t.lobe < l->m->n_lobes; other++)
            t.apart |= (uint32_t)(other != t.lobe && !is_tied_across(l, at[i], t.lobe, other)) << other;
        for (size_t c = 0; c < (at[i] >= 0 ? 1 : l->n_channels) && k >= 0; c++) {
            t.coordinate = ff_layout_coordinate(l, c, (size_t)k + (at[i] >= 0 ? 0 : l->free.n_shape));
            add_term(e, from, &t);
        }
    }
}

ff_status ff_extras_new(const ff_constraints *c, const ff_layout *l, ff_shape shape, ff_extras **out)
{
    *out = NULL;
    if (!c || (c->n_priors == 0 && !c->energy_conserving)) return FF_OK;
    ff_extras *e = calloc(1, sizeof *e);
    if (!e) return FF_ERR_MEMORY;
    e->prior = calloc(2 * c->n_priors * l->n_channels + 1, sizeof *e->prior);
    e->named = calloc(2 * c->n_priors + 1, sizeof *e->named);
    e->energy = (energy){.wanted = c->energy_conserving && l->m->n_lobes + l->m->n_bases > 0, .C = l->n_channels};
    if (e->energy.wanted) e->energy.shift = calloc(VIEWS * l->n_channels, sizeof *e->energy.shift);
    if (!e->prior || !e->named || (e->energy.wanted && !e->energy.shift)) {
        ff_extras_free(e);
        return FF_ERR_MEMORY;
    }
    for (size_t i = 0; i < c->n_priors; i++) add_prior(e, l, shape, &c->prior[i]);
    *out = e;
    return FF_OK;
}

void ff_extras_free(ff_extras *e)
{
    if (!e) return;
    free(e->prior);
    free(e->named);
    free(e->energy.shift);
    free(e->energy.row);
    free(e);
}

int ff_extras_tell_apart(const ff_layout *l, uint32_t a, uint32_t b)
{
    for (size_t i = 0; l->extras && i < l->extras->n_priors; i++) {
        const prior_term *t = &l->extras->prior[i];
        if ((t->lobe == a && t->apart >> b & 1) || (t->lobe == b && t->apart >> a & 1)) return 1;
    }
    return 0;
}

int ff_extras_prior(const ff_extras *e, int at, double *mean, double *sd)
{
    for (size_t i = 0; e && i < e->n_named; i++)
        if (e->named[i].at == at) {
            *mean = e->named[i].mean;
            *sd = e->named[i].sd;
            return 1;
        }
    return 0;
}

/* ---- albedos --------------------------------------------------------------------------------- */

static void view_at(double mu, double phi, double wo[3])
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
    size_t stride; /* doubles of a view */
} albedo_work;

static void one_view(void *context, size_t i, int worker)
{
    const albedo_work *w = context;
    (void)worker;
    ff_albedo_parts_at(w->parts, ORDER, w->wo[i], w->out + i * w->stride);
}

/* out [n][C][1 + columns]; wanted NULL: values alone. */
static ff_status albedos(const ff_layout *l, const struct ff_problem *p, int parallel, const double *shape, const double *channel,
                         const ff_wanted *wanted, size_t n, const double (*wo)[3], double *out)
{
    const ff_wanted none = {.n_shape = 0}, *w = wanted ? wanted : &none;
    albedo_work work = {.wo = wo, .out = out, .stride = l->n_channels * (1 + w->n_shape + w->n_channel)};
    ff_albedo_parts *parts;
    const ff_status s = ff_albedo_parts_make(l->m, ff_kernels_get(p->isa), l->mode, l->n_channels, shape, channel, w, &parts);
    if (s) return s;
    work.parts = parts;
    if (parallel)
        ff_pool_run(p->pool, n, one_view, &work);
    else
        for (size_t i = 0; i < n; i++) one_view(&work, i, 0);
    ff_albedo_parts_free(parts);
    return FF_OK;
}

/* Gradient [P] of an albedo of channel c by coordinates, or by their parameters for slope NULL, from its columns. */
static void fold_gradient(const ff_layout *l, size_t c, const double *column, const double *slope, double *gradient)
{
    memset(gradient, 0, l->P * sizeof *gradient);
    for (size_t k = 0; k < (size_t)l->free.n_shape + l->free.n_channel; k++) {
        const size_t i = ff_layout_coordinate(l, c, k);
        gradient[i] += column[k] * (slope ? slope[i] : 1);
    }
}

/* ---- terms ----------------------------------------------------------------------------------- */

static double value_of(const ff_layout *l, size_t coordinate, const double *shape, const double *channel)
{
    size_t c;
    const ff_model_param *p = ff_layout_param(l, coordinate, &c);
    return coordinate < l->n_shared && p >= l->m->shape && p < l->m->shape + l->m->n_shape
               ? shape[p - l->m->shape]
               : channel[c * l->m->n_channel + (size_t)(p - l->m->channel)];
}

double ff_extras_mismatch(const ff_layout *l, const double *shape, const double *channel)
{
    double sum = 0;
    for (size_t i = 0; l->extras && i < l->extras->n_priors; i++) {
        const prior_term *t = &l->extras->prior[i];
        sum += pow((value_of(l, t->coordinate, shape, channel) - t->mean) / t->sd, 2);
    }
    return sum;
}

static void add_row(size_t P, double weight, double residual, const double *gradient, double *cost2, double *H, double *g)
{
    *cost2 += weight * residual * residual;
    for (size_t i = 0; i < P; i++) {
        if (gradient[i] == 0) continue;
        g[i] += weight * residual * gradient[i];
        for (size_t j = 0; j < P; j++) H[i * P + j] += weight * gradient[i] * gradient[j];
    }
}

static ff_status add_energy(const energy *e, const ff_layout *l, const struct ff_problem *p, int parallel, const double *shape,
                            const double *channel, const double *slope, double *cost2, double *H, double *g)
{
    const size_t size = 1 + l->free.n_shape + l->free.n_channel;
    double *a = malloc((e->n * e->C * size + l->P) * sizeof *a);
    if (!a) return FF_ERR_MEMORY;
    double *gradient = a + e->n * e->C * size;
    const ff_status s = albedos(l, p, parallel, shape, channel, &l->free, e->n, e->wo, a);
    for (size_t i = 0; i < e->n * e->C && !s; i++) {
        const double over = a[i * size] - 1 + e->shift[i];
        if (over <= 0) continue;
        fold_gradient(l, i % e->C, a + i * size + 1, slope, gradient);
        add_row(l->P, e->weight, over, gradient, cost2, H, g);
    }
    free(a);
    return s;
}

ff_status ff_extras_add(const ff_layout *l, const struct ff_problem *p, int parallel, const double *shape, const double *channel,
                        const double *slope, double *cost2, double *H, double *g)
{
    const ff_extras *e = l->extras;
    if (!e) return FF_OK;
    for (size_t i = 0; i < e->n_priors; i++) {
        const prior_term *t = &e->prior[i];
        if (t->weight == 0) continue;
        const double off = value_of(l, t->coordinate, shape, channel) - t->mean, d = slope[t->coordinate];
        *cost2 += t->weight * off * off;
        g[t->coordinate] += t->weight * off * d;
        H[t->coordinate * l->P + t->coordinate] += t->weight * d * d;
    }
    return e->energy.weight > 0 ? add_energy(&e->energy, l, p, parallel, shape, channel, slope, cost2, H, g) : FF_OK;
}

void ff_extras_covariance(const ff_layout *l, double factor, double *H, double *M)
{
    const ff_extras *e = l->extras;
    const size_t P = l->P;
    if (!e) return;
    for (size_t i = 0; i < e->n_priors; i++) {
        const size_t at = e->prior[i].coordinate;
        if (H) H[at * P + at] += e->prior[i].weight;
        if (M) M[ff_tri(at, at)] += factor * e->prior[i].weight * e->prior[i].noise;
    }
    for (size_t r = 0; r < e->energy.n_rows && H; r++) /* so stiff that nothing moves across the constraint */
        for (size_t i = 0; i < P; i++)
            for (size_t j = 0; j < P; j++)
                H[i * P + j] += STIFF * e->energy.scale * e->energy.row[r * P + i] * e->energy.row[r * P + j];
}

double ff_extras_weight(const ff_layout *l, size_t k)
{
    double sum = 0;
    for (size_t i = 0; l->extras && i < l->extras->n_priors; i++)
        if (l->extras->prior[i].coordinate == k) sum += l->extras->prior[i].weight;
    return sum;
}

/* ---- priors ---------------------------------------------------------------------------------- */

/* Weights by what the data alone say: V, inverse [P][P] the sandwich and H^-1, determined [P]. */
static void weigh_priors(ff_extras *e, const ff_layout *l, const struct ff_problem *p, const int *at_bound, const int *determined,
                         const double *V, const double *inverse, double cost2)
{
    const int sigma = p->selection.weighting == FF_WEIGHT_SIGMA;
    const double n = (double)(p->n * p->n_channels), P = (double)l->P, mean = n > P ? cost2 / (n - P) : cost2 / n;
    for (size_t i = 0; i < e->n_priors; i++) {
        prior_term *t = &e->prior[i];
        const size_t k = t->coordinate, kk = k * (l->P + 1);
        const int known = at_bound[k] == 0 && determined[k] && V[kk] > 0 && inverse[kk] > 0;
        t->noise = known ? V[kk] / inverse[kk] : sigma ? 1 : mean;
        t->weight = t->noise / (t->sd * t->sd);
        if (known) t->error = sqrt(V[kk]);
    }
}

/* The other place to start from: where the priors are, with the channel parameters that the data ask for there. It is tried on the
 * thin problem and taken where it leads lower; else shape and channel stay. */
static ff_status try_prior_means(const ff_extras *e, const ff_layout *l, const struct ff_problem *p, const ff_fit_options *o,
                                 double *shape, double *channel)
{
    const size_t size = l->n_channels * l->m->n_channel;
    double *x = malloc((l->P + 2 * size + 1) * sizeof *x), *moved = x + l->P, *stayed = moved + size;
    double moved_shape[FF_MAX_SHAPE], stayed_shape[FF_MAX_SHAPE], cost2;
    int *at_bound = malloc((l->P + 1) * sizeof *at_bound);
    ff_solution here, there;
    ff_status s = x && at_bound ? FF_OK : FF_ERR_MEMORY;
    if (!s) {
        memcpy(stayed, channel, size * sizeof *channel);
        memcpy(moved, channel, size * sizeof *channel);
        memcpy(stayed_shape, shape, l->m->n_shape * sizeof *shape);
        memcpy(moved_shape, shape, l->m->n_shape * sizeof *shape);
        ff_layout_pack(l, shape, channel, x);
        for (size_t i = 0; i < e->n_priors; i++) {
            const ff_model_param *info = ff_layout_param(l, e->prior[i].coordinate, NULL);
            x[e->prior[i].coordinate] = ff_coordinate(info->info, fmin(fmax(e->prior[i].mean, info->lo), info->hi));
        }
        ff_layout_unpack(l, x, moved_shape, moved);
        s = ff_start_channels(l, p, o, moved_shape, moved, &cost2);
    }
    if (!s) s = ff_solve(l, p->thin, o, 0, 0, 1e-7, 40, stayed_shape, stayed, at_bound, &here, NULL);
    if (!s) s = ff_solve(l, p->thin, o, 0, 0, 1e-7, 40, moved_shape, moved, at_bound, &there, NULL);
    if (!s && there.cost2 < here.cost2 * (1 - 1e-6)) {
        memcpy(shape, moved_shape, l->m->n_shape * sizeof *shape);
        memcpy(channel, moved, size * sizeof *channel);
    }
    free(x);
    free(at_bound);
    return s;
}

/* ---- energy ---------------------------------------------------------------------------------- */

/* A peak of the albedo of one channel. */
typedef struct peak {
    double level, phi, albedo; /* level = cos(theta)^(1/3), which spreads the grazing views */
    size_t channel;
} peak;

/* The views of a scan: levels by azimuths. */
typedef struct scan {
    size_t turns;
    double step_level, step_phi;
    double (*wo)[3], *a; /* [LEVELS turns]; [..][C] */
} scan;

static double level_at(const scan *s, size_t i)
{
    return 0.1 + s->step_level * (double)i; /* from cos(theta) = 0.001 to 1 */
}

/* Largest first. */
static int by_albedo(const void *a, const void *b)
{
    const peak *x = a, *y = b;
    return (x->albedo < y->albedo) - (x->albedo > y->albedo);
}

/* Is view (i, j) no lower than its neighbours, for channel c? */
static int is_peak(const scan *s, size_t C, size_t i, size_t j, size_t c)
{
    const double here = s->a[(i * s->turns + j) * C + c];
    for (int side = -1; side <= 1; side += 2) {
        const size_t around = (j + s->turns + (size_t)side) % s->turns;
        if ((side > 0 ? i + 1 < LEVELS : i > 0) && s->a[((size_t)((int)i + side) * s->turns + j) * C + c] > here) return 0;
        if (s->a[(i * s->turns + around) * C + c] > here) return 0;
    }
    return 1;
}

/* Top of the parabola through three points at -1, 0, 1, within them. */
static double vertex(double below, double here, double above)
{
    const double bend = below - 2 * here + above;
    return bend < 0 ? fmin(fmax(0.5 * (below - above) / bend, -1), 1) : above > below ? 1 : -1;
}

/* Moves a peak of the scan towards the true one: twice along the level and, where there are several, the azimuth. */
static ff_status refine(const ff_layout *l, const struct ff_problem *p, const double *shape, const double *channel, const scan *s,
                        double *scratch, peak *t)
{
    double h_level = s->step_level, h_phi = s->turns > 1 ? s->step_phi : 0;
    for (int round = 0; round < 2; round++, h_level *= 0.3, h_phi *= 0.3)
        for (int axis = 0; axis < 1 + (s->turns > 1); axis++) {
            double wo[3][3];
            for (int i = -1; i <= 1; i++) {
                const double level = t->level + (axis ? 0 : i * h_level);
                view_at(fmin(pow(level, 3), 1), t->phi + (axis ? i * h_phi : 0), wo[1 + i]);
            }
            const int at_edge = axis == 0 && t->level + h_level > 1; /* normal incidence: one side alone */
            if (at_edge) view_at(1, t->phi, wo[2]);
            const ff_status status = albedos(l, p, 1, shape, channel, NULL, 3, wo, scratch);
            if (status) return status;
            const double a[3] = {scratch[t->channel], scratch[l->n_channels + t->channel], scratch[2 * l->n_channels + t->channel]};
            const double move = at_edge && a[2] >= a[0] ? 1 : vertex(a[0], a[1], a[2]);
            if (axis)
                t->phi += move * h_phi;
            else
                t->level = fmin(fmax(t->level + move * h_level, 0.1), 1);
            double best[1][3];
            view_at(pow(t->level, 3), t->phi, best[0]);
            const ff_status again = albedos(l, p, 0, shape, channel, NULL, 1, best, scratch);
            if (again) return again;
            t->albedo = scratch[t->channel];
        }
    return FF_OK;
}

/* The highest peaks over all views and channels, at most max, those above 1 - 2e-3 refined. */
static ff_status find_peaks(const ff_layout *l, const struct ff_problem *p, const double *shape, const double *channel, size_t max,
                            peak *out, size_t *n_out)
{
    const size_t C = l->n_channels;
    scan s = {.turns = l->mode == FF_ISOTROPIC_MODE ? 1 : l->mode == FF_CENTRED_MODE ? 6 : 12, .step_level = 0.9 / (LEVELS - 1)};
    s.step_phi = (l->mode == FF_TILTED_MODE ? 2 : 1) * PI / (double)s.turns;
    peak *found = malloc(LEVELS * s.turns * C * sizeof *found);
    s.wo = malloc(LEVELS * s.turns * sizeof *s.wo);
    s.a = malloc((LEVELS * s.turns + 3) * C * sizeof *s.a);
    ff_status status = found && s.wo && s.a ? FF_OK : FF_ERR_MEMORY;
    size_t n = 0;
    for (size_t i = 0; i < LEVELS * s.turns && !status; i++)
        view_at(fmin(pow(level_at(&s, i / s.turns), 3), 1), s.step_phi * (double)(i % s.turns), s.wo[i]);
    if (!status) status = albedos(l, p, 1, shape, channel, NULL, LEVELS * s.turns, (const double(*)[3])s.wo, s.a);
    for (size_t i = 0; i < LEVELS * s.turns && !status; i++)
        for (size_t c = 0; c < C; c++)
            if (is_peak(&s, C, i / s.turns, i % s.turns, c))
                found[n++] = (peak){level_at(&s, i / s.turns), s.step_phi * (double)(i % s.turns), s.a[i * C + c], c};
    if (!status) qsort(found, n, sizeof *found, by_albedo);
    if (n > max) n = max;
    for (size_t i = 0; i < n && !status; i++)
        if (found[i].albedo > 1 - 2e-3) status = refine(l, p, shape, channel, &s, s.a + LEVELS * s.turns * C, &found[i]);
    if (!status) {
        qsort(found, n, sizeof *found, by_albedo);
        memcpy(out, found, n * sizeof *out);
        *n_out = n;
    }
    free(found);
    free(s.wo);
    free(s.a);
    return status;
}

/* Adds the view of a peak unless there is one near it. Returns whether it did. */
static int add_view(energy *e, const peak *t)
{
    double wo[3];
    view_at(fmin(pow(t->level, 3), 1), t->phi, wo);
    for (size_t i = 0; i < e->n; i++) {
        const double d2 = pow(wo[0] - e->wo[i][0], 2) + pow(wo[1] - e->wo[i][1], 2);
        if (d2 < 1e-6 && fabs(cbrt(wo[2]) - cbrt(e->wo[i][2])) < 2e-3) return 0;
    }
    if (e->n == VIEWS) return 0;
    memcpy(e->wo[e->n], wo, sizeof wo);
    memset(e->shift + e->n * e->C, 0, e->C * sizeof *e->shift);
    e->n++;
    return 1;
}

/* The largest violation at the views; with update, the shifts take it up. */
static ff_status violation(energy *e, const ff_layout *l, const struct ff_problem *p, const double *shape, const double *channel,
                           int update, double *worst)
{
    double *a = malloc((e->n * e->C + 1) * sizeof *a);
    if (!a) return FF_ERR_MEMORY;
    const ff_status s = albedos(l, p, 1, shape, channel, NULL, e->n, (const double(*)[3])e->wo, a);
    *worst = 0;
    for (size_t i = 0; i < e->n * e->C && !s; i++) {
        *worst = fmax(*worst, a[i] - 1);
        if (update) e->shift[i] = fmax(0, e->shift[i] + a[i] - 1);
    }
    free(a);
    return s;
}

/* Gradients of all albedos at the views, by parameters: rows [n C][P], values [n C]. */
static ff_status gradients(const energy *e, const ff_layout *l, const struct ff_problem *p, const double *shape,
                           const double *channel, double *rows, double *values)
{
    const size_t size = 1 + l->free.n_shape + l->free.n_channel;
    double *a = malloc((e->n * e->C * size + 1) * sizeof *a);
    if (!a) return FF_ERR_MEMORY;
    const ff_status s = albedos(l, p, 1, shape, channel, &l->free, e->n, (const double(*)[3])e->wo, a);
    for (size_t i = 0; i < e->n * e->C && !s; i++) {
        values[i] = a[i * size];
        fold_gradient(l, i % e->C, a + i * size + 1, NULL, rows + i * l->P);
    }
    free(a);
    return s;
}

/* What it costs the data to lower the first view's largest albedo by 1, in cost2 and for small steps: 1 / (gradient H^-1 gradient).
 */
static ff_status measure_scale(energy *e, const ff_layout *l, const struct ff_problem *p, const double *shape,
                               const double *channel, const double *inverse, double cost2)
{
    const size_t P = l->P, n = e->n * e->C;
    double *rows = malloc((n * (P + 1) + 1) * sizeof *rows), *values = rows + n * P;
    const ff_status s = rows ? gradients(e, l, p, shape, channel, rows, values) : FF_ERR_MEMORY;
    if (!s) {
        size_t worst = 0;
        double ease = 0;
        for (size_t i = 0; i < n; i++)
            if (values[i] > values[worst]) worst = i;
        for (size_t i = 0; i < P; i++)
            for (size_t j = 0; j < P; j++) ease += rows[worst * P + i] * inverse[i * P + j] * rows[worst * P + j];
        e->scale = ease > 0 && isfinite(1 / ease) ? 1 / ease : fmax(cost2, 1e-30);
    }
    free(rows);
    return s;
}

/* Keeps the gradients of what binds. */
static ff_status keep_rows(energy *e, const ff_layout *l, const struct ff_problem *p, const double *shape, const double *channel)
{
    const size_t P = l->P, n = e->n * e->C;
    double *values = malloc((n + 1) * sizeof *values);
    e->row = malloc((n * P + 1) * sizeof *e->row);
    const ff_status s = values && e->row ? gradients(e, l, p, shape, channel, e->row, values) : FF_ERR_MEMORY;
    e->n_rows = 0;
    for (size_t i = 0; i < n && !s; i++)
        if (values[i] - 1 + e->shift[i] > 0) memmove(e->row + e->n_rows++ * P, e->row + i * P, P * sizeof *e->row);
    free(values);
    return s;
}

/* ---- the whole ------------------------------------------------------------------------------- */

/* A minimum that replaces the one in *solution; rough: on the way to another one. */
static ff_status solve_again(const ff_layout *l, const struct ff_problem *p, const ff_fit_options *o, int rough, double *shape,
                             double *channel, int *at_bound, ff_solution *solution, ff_error *err)
{
    const ff_solution before = *solution;
    ff_normal_free(&solution->normal);
    *solution = (ff_solution){.outcome = FF_CONVERGED};
    const ff_status s = rough ? ff_solve(l, p, o, 1, 0, 1e-5, o->max_iterations, shape, channel, at_bound, solution, err)
                              : ff_solve_in_order(l, p, o, shape, channel, at_bound, solution, err);
    solution->iterations += before.iterations;
    solution->passes += before.passes;
    return s;
}

/* A larger weight, with the same pull K t. */
static void stiffen(energy *e)
{
    e->weight *= 10;
    for (size_t i = 0; i < e->n * e->C; i++) e->shift[i] /= 10;
}

static ff_status conserve_energy(ff_extras *x, const ff_layout *l, const struct ff_problem *p, const ff_fit_options *o,
                                 double *shape, double *channel, const double *inverse, double cost2, int *at_bound,
                                 ff_solution *solution, ff_error *err)
{
    enum { ROUNDS = 30, PEAKS = 6 };
    energy *e = &x->energy;
    peak peaks[PEAKS];
    size_t n = 0;
    double last = INFINITY;
    int rough = 0;
    ff_status s = FF_OK;
    for (int round = 0; round < ROUNDS && !s; round++) {
        double worst = 0;
        int added = 0;
        s = find_peaks(l, p, shape, channel, PEAKS, peaks, &n);
        if (!s) s = violation(e, l, p, shape, channel, 1, &worst);
        if (s) break;
        if (n) worst = fmax(worst, peaks[0].albedo - 1);
        e->left = worst;
        if (round == 0) e->alone_cost2 = cost2;
        if (round == 0 && n) e->alone = peaks[0].albedo, e->alone_mu = pow(peaks[0].level, 3), e->alone_channel = peaks[0].channel;
        if ((worst <= ENOUGH && !rough) || solution->outcome != FF_CONVERGED) break;
        for (size_t i = 0; i < n; i++)
            if (peaks[i].albedo > 1 + 0.2 * ENOUGH) added += add_view(e, &peaks[i]);
        if (e->weight == 0) {
            e->binds = 1;
            s = measure_scale(e, l, p, shape, channel, inverse, cost2);
            e->weight = 10 * e->scale;
        } else if (!added && worst > 0.5 * last)
            stiffen(e);
        if (!added) last = worst;
        rough = worst > 20 * ENOUGH;
        if (!s) s = solve_again(l, p, o, rough, shape, channel, at_bound, solution, err);
    }
    if (!s && e->binds) s = keep_rows(e, l, p, shape, channel);
    return s;
}

ff_status ff_extras_solve(ff_extras *e, const ff_layout *l, const struct ff_problem *p, const ff_fit_options *o, double *shape,
                          double *channel, int *at_bound, ff_solution *solution, ff_error *err)
{
    const double cost2 = solution->normal.cost2;
    int *use = malloc((l->P + 1) * sizeof *use);
    ff_uncertainty u = {0};
    ff_status s = use ? FF_OK : FF_ERR_MEMORY;
    for (size_t k = 0; k < l->P && !s; k++) use[k] = at_bound[k] == 0;
    if (!s) s = ff_uncertainty_new(l, p, &solution->normal, use, p->n, &u);
    free(use);
    for (size_t i = 0; i < e->n_priors && !s; i++) e->prior[i].alone = value_of(l, e->prior[i].coordinate, shape, channel);
    if (!s && e->n_priors) {
        weigh_priors(e, l, p, at_bound, u.determined, u.cov, u.inverse, cost2);
        s = try_prior_means(e, l, p, o, shape, channel);
        if (!s) s = solve_again(l, p, o, 0, shape, channel, at_bound, solution, err);
    }
    if (!s && e->energy.wanted) s = conserve_energy(e, l, p, o, shape, channel, u.inverse, cost2, at_bound, solution, err);
    if (!s && e->energy.left > 2 * ENOUGH && solution->outcome == FF_CONVERGED) solution->outcome = FF_STALLED;
    for (size_t i = 0; i < e->n_priors && !s; i++) e->prior[i].value = value_of(l, e->prior[i].coordinate, shape, channel);
    ff_uncertainty_free(&u);
    if (s == FF_ERR_CANCELLED) return ff_error_set(err, s, NULL, 0, -1, "cancelled");
    return s ? ff_error_set(err, s, NULL, 0, -1, "the fit with what is known besides the data failed: %s", ff_status_str(s)) : s;
}

/* ---- what is said of them -------------------------------------------------------------------- */

double ff_extras_penalty(const ff_extras *e)
{
    double sum = 0;
    for (size_t i = 0; e && i < e->n_priors; i++) sum += 0.5 * e->prior[i].weight * pow(e->prior[i].value - e->prior[i].mean, 2);
    return sum;
}

static ff_status warn_of_held(const named_prior *n, ff_warnings *out)
{
    const ff_warning_parameter parameter = {n->at, FF_NO_CHANNEL};
    const ff_warning w = {.code = FF_WARNING_PRIOR_WITHOUT_EFFECT, .n_parameters = 1, .parameter = &parameter};
    return n->is_free ? FF_OK : ff_warnings_add(out, &w);
}

static ff_status warn_of_disagreement(const ff_layout *l, const prior_term *t, ff_warnings *out)
{
    const double moved = fabs(t->value - t->alone), rounding = 1e-6 * t->sd; /* of data without noise */
    if (!(moved > 3 * t->error) || moved < rounding) return FF_OK;           /* also where the data do not determine it */
    const double value[] = {t->alone, t->error, t->mean, t->sd};
    return ff_layout_warn(l, t->coordinate, FF_WARNING_PRIOR_DISAGREES, value, out);
}

static ff_status warn_of_energy(const energy *e, double objective, ff_warnings *out)
{
    const double theta = acos(fmin(e->alone_mu, 1)) * 180 / PI, ratio = 2 * objective / fmax(e->alone_cost2, 1e-300);
    const ff_warning w = {.code = FF_WARNING_ALBEDO_ABOVE_ONE,
                          .n_channels = e->C > 1,
                          .channel = &e->alone_channel,
                          .value = {e->alone, theta, ratio}};
    const ff_status s = e->binds ? ff_warnings_add(out, &w) : FF_OK;
    return s || !(e->left > 2 * ENOUGH) ? s : ff_warnings_say(out, FF_WARNING_ENERGY_NOT_CONSERVED, &e->left);
}

ff_status ff_extras_warnings(const ff_layout *l, double objective, ff_warnings *out)
{
    const ff_extras *e = l->extras;
    ff_status s = FF_OK;
    if (!e) return s;
    for (size_t i = 0; i < e->n_named && !s; i++) s = warn_of_held(&e->named[i], out);
    for (size_t i = 0; i < e->n_priors && !s; i++) s = warn_of_disagreement(l, &e->prior[i], out);
    return s ? s : warn_of_energy(&e->energy, objective, out);
}
