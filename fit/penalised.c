/* From the optimum of the data alone to that with what is known besides them: the weights of priors, which need the errors of the
 * data, and the augmented Lagrangian of albedos that must not exceed 1 (problem/penalties.c has the terms). */
#include "fit/errors/internal_errors.h"
#include "fit/minimise/internal_minimise.h"
#include "fit/problem/internal_penalties.h"
#include "fit/start/internal_start.h"
#include "internal_stages.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

#define PI 3.14159265358979323846

/* ---- priors ---------------------------------------------------------------------------------- */

/* Weights by what the data alone say. */
static void weigh_priors(ff_penalties *e, const ff_plan *plan, const ff_point *at, double cost2)
{
    const struct ff_problem *p = plan->p;
    const int sigma = p->selection.weighting == FF_WEIGHT_SIGMA;
    const double n = (double)(p->n * p->n_channels), P = (double)plan->l.P, mean = n > P ? cost2 / (n - P) : cost2 / n;
    for (size_t i = 0; i < e->n_priors; i++) {
        ff_prior_term *t = &e->prior[i];
        const ff_information *u = at->information;
        const size_t k = t->coordinate;
        const int known = u->determined[k] && u->variance[k] > 0 && u->inverse[k] > 0;
        t->noise = known ? u->variance[k] / u->inverse[k] : sigma ? 1 : mean;
        t->weight = t->noise / (t->sd * t->sd);
        if (known) t->error = sqrt(u->variance[k]);
    }
}

/* Puts the point where the priors are, with the channel parameters that the data ask for there. */
static ff_status go_to_means(const ff_penalties *e, const ff_plan *plan, ff_point *at)
{
    const ff_layout *l = &plan->l;
    double *x = malloc((l->P + 1) * sizeof *x), cost2;
    if (!x) return FF_ERR_MEMORY;
    ff_layout_pack(l, at->shape, at->channel, x);
    for (size_t i = 0; i < e->n_priors; i++) {
        const ff_param *info = ff_layout_param(l, e->prior[i].coordinate, NULL)->info;
        double lo, hi;
        ff_layout_range(l, e->prior[i].coordinate, &lo, &hi);
        x[e->prior[i].coordinate] = ff_coordinate(info, fmin(fmax(e->prior[i].mean, lo), hi));
    }
    ff_layout_unpack(l, x, at->shape, at->channel);
    free(x);
    return ff_start_channels(plan, at->shape, at->channel, &cost2);
}

/* The other place to start from: that of the priors. It is tried on the subsample and taken where it leads lower; else the point
 * stays. */
static ff_status try_prior_means(const ff_penalties *e, const ff_plan *plan, ff_point *at)
{
    static const ff_effort effort = {.tolerance = 1e-7, .max_iterations = 40};
    const ff_plan subsample = ff_plan_on(plan, plan->p->subsample);
    ff_point stayed = {0}, moved = {0};
    ff_status status = ff_point_new(plan, &stayed);
    if (!status) status = ff_point_new(plan, &moved);
    if (!status) {
        ff_point_set(plan, at->shape, at->channel, &stayed);
        ff_point_set(plan, at->shape, at->channel, &moved);
        status = go_to_means(e, plan, &moved);
    }
    if (!status) status = ff_solve(&subsample, &effort, &stayed, NULL);
    if (!status) status = ff_solve(&subsample, &effort, &moved, NULL);
    if (!status && moved.cost2 < stayed.cost2 * (1 - 1e-6)) ff_point_set(plan, moved.shape, moved.channel, at);
    ff_point_free(&stayed);
    ff_point_free(&moved);
    return status;
}

/* ---- energy ---------------------------------------------------------------------------------- */

/* A peak of the albedo of one channel. */
typedef struct peak {
    double level, phi, albedo; /* level = cos(theta)^(1/3), which spreads the grazing views */
    size_t channel;
} peak;

/* The views of a scan: levels by azimuths. */
enum { LEVELS = 24 };

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
static ff_status refine(const ff_plan *plan, const ff_point *at, const scan *s, double *scratch, peak *t)
{
    const size_t C = plan->l.n_channels;
    double h_level = s->step_level, h_phi = s->turns > 1 ? s->step_phi : 0;
    for (int round = 0; round < 2; round++, h_level *= 0.3, h_phi *= 0.3)
        for (int axis = 0; axis < 1 + (s->turns > 1); axis++) {
            double wo[3][3];
            for (int i = -1; i <= 1; i++) {
                const double level = t->level + (axis ? 0 : i * h_level);
                ff_view_at(fmin(pow(level, 3), 1), t->phi + (axis ? i * h_phi : 0), wo[1 + i]);
            }
            const int at_edge = axis == 0 && t->level + h_level > 1; /* normal incidence: one side alone */
            if (at_edge) ff_view_at(1, t->phi, wo[2]);
            const ff_status status = ff_penalties_albedos(plan, 1, at->shape, at->channel, NULL, 3, wo, scratch);
            if (status) return status;
            const double a[3] = {scratch[t->channel], scratch[C + t->channel], scratch[2 * C + t->channel]};
            const double move = at_edge && a[2] >= a[0] ? 1 : vertex(a[0], a[1], a[2]);
            if (axis)
                t->phi += move * h_phi;
            else
                t->level = fmin(fmax(t->level + move * h_level, 0.1), 1);
            double best[1][3];
            ff_view_at(pow(t->level, 3), t->phi, best[0]);
            const ff_status again = ff_penalties_albedos(plan, 0, at->shape, at->channel, NULL, 1, best, scratch);
            if (again) return again;
            t->albedo = scratch[t->channel];
        }
    return FF_OK;
}

/* The highest peaks over all views and channels, at most max, those above 1 - 2e-3 refined. */
static ff_status find_peaks(const ff_plan *plan, const ff_point *at, size_t max, peak *out, size_t *n_out)
{
    const ff_layout *l = &plan->l;
    const size_t C = l->n_channels;
    scan s = {.turns = l->mode == FF_ISOTROPIC_MODE ? 1 : l->mode == FF_CENTRED_MODE ? 6 : 12, .step_level = 0.9 / (LEVELS - 1)};
    s.step_phi = (l->mode == FF_TILTED_MODE ? 2 : 1) * PI / (double)s.turns;
    peak *found = malloc(LEVELS * s.turns * C * sizeof *found);
    s.wo = malloc(LEVELS * s.turns * sizeof *s.wo);
    s.a = malloc((LEVELS * s.turns + 3) * C * sizeof *s.a);
    ff_status status = found && s.wo && s.a ? FF_OK : FF_ERR_MEMORY;
    size_t n = 0;
    for (size_t i = 0; i < LEVELS * s.turns && !status; i++)
        ff_view_at(fmin(pow(level_at(&s, i / s.turns), 3), 1), s.step_phi * (double)(i % s.turns), s.wo[i]);
    if (!status)
        status = ff_penalties_albedos(plan, 1, at->shape, at->channel, NULL, LEVELS * s.turns, (const double(*)[3])s.wo, s.a);
    for (size_t i = 0; i < LEVELS * s.turns && !status; i++)
        for (size_t c = 0; c < C; c++)
            if (is_peak(&s, C, i / s.turns, i % s.turns, c))
                found[n++] = (peak){level_at(&s, i / s.turns), s.step_phi * (double)(i % s.turns), s.a[i * C + c], c};
    if (!status) qsort(found, n, sizeof *found, by_albedo);
    if (n > max) n = max;
    for (size_t i = 0; i < n && !status; i++)
        if (found[i].albedo > 1 - 2e-3) status = refine(plan, at, &s, s.a + LEVELS * s.turns * C, &found[i]);
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
static int add_view(ff_energy *e, const peak *t)
{
    double wo[3];
    ff_view_at(fmin(pow(t->level, 3), 1), t->phi, wo);
    for (size_t i = 0; i < e->n; i++) {
        const double d2 = pow(wo[0] - e->wo[i][0], 2) + pow(wo[1] - e->wo[i][1], 2);
        if (d2 < 1e-6 && fabs(cbrt(wo[2]) - cbrt(e->wo[i][2])) < 2e-3) return 0;
    }
    if (e->n == FF_VIEWS) return 0;
    memcpy(e->wo[e->n], wo, sizeof wo);
    memset(e->shift + e->n * e->C, 0, e->C * sizeof *e->shift);
    e->n++;
    return 1;
}

/* The largest violation at the views; with update, the shifts take it up. */
static ff_status violation(ff_energy *e, const ff_plan *plan, const ff_point *at, int update, double *worst)
{
    double *a = malloc((e->n * e->C + 1) * sizeof *a);
    if (!a) return FF_ERR_MEMORY;
    const ff_status status = ff_penalties_albedos(plan, 1, at->shape, at->channel, NULL, e->n, (const double(*)[3])e->wo, a);
    *worst = 0;
    for (size_t i = 0; i < e->n * e->C && !status; i++) {
        *worst = fmax(*worst, a[i] - 1);
        if (update) e->shift[i] = fmax(0, e->shift[i] + a[i] - 1);
    }
    free(a);
    return status;
}

/* Gradients of all albedos at the views, by parameters: rows [n C][n_shared + n_own], values [n C]. */
static ff_status gradients(const ff_energy *e, const ff_plan *plan, const ff_point *at, double *rows, double *values)
{
    const ff_layout *l = &plan->l;
    const size_t size = 1 + l->free.n_shape + l->free.n_channel;
    double *a = malloc((e->n * e->C * size + 1) * sizeof *a);
    if (!a) return FF_ERR_MEMORY;
    const ff_status status = ff_penalties_albedos(plan, 1, at->shape, at->channel, &l->free, e->n, (const double(*)[3])e->wo, a);
    for (size_t i = 0; i < e->n * e->C && !status; i++) {
        values[i] = a[i * size];
        ff_penalties_gradient(l, i % e->C, a + i * size + 1, NULL, rows + i * (l->n_shared + l->n_own));
    }
    free(a);
    return status;
}

/* gradient H^-1 gradient of the row of a channel. */
static ff_status ease_of(const ff_plan *plan, const ff_information *info, size_t c, const double *row, double *out)
{
    const ff_layout *l = &plan->l;
    double *gradient = calloc(2 * l->P + 1, sizeof *gradient);
    if (!gradient) return FF_ERR_MEMORY;
    double *moved = gradient + l->P;
    for (size_t i = 0; i < l->n_shared + l->n_own; i++) gradient[i < l->n_shared ? i : i + c * l->n_own] = row[i];
    const ff_status status = ff_information_solve(info, gradient, moved);
    *out = 0;
    for (size_t k = 0; k < l->P && !status; k++) *out += gradient[k] * moved[k];
    free(gradient);
    return status;
}

/* What it costs the data to lower the largest albedo at the views by 1, in cost2 and for small steps: 1 / (gradient H^-1 gradient).
 */
static ff_status measure_scale(ff_energy *e, const ff_plan *plan, const ff_information *info, const ff_point *at, double cost2)
{
    const size_t m = plan->l.n_shared + plan->l.n_own, n = e->n * e->C;
    double *rows = malloc((n * (m + 1) + 1) * sizeof *rows), *values = rows + n * m, ease = 0;
    ff_status status = rows ? gradients(e, plan, at, rows, values) : FF_ERR_MEMORY;
    size_t worst = 0;
    for (size_t i = 0; i < n && !status; i++)
        if (values[i] > values[worst]) worst = i;
    if (!status) status = ease_of(plan, info, worst % e->C, rows + worst * m, &ease);
    if (!status) e->scale = ease > 0 && isfinite(1 / ease) ? 1 / ease : fmax(cost2, 1e-30);
    free(rows);
    return status;
}

/* Keeps the gradients of what binds. */
static ff_status keep_rows(ff_energy *e, const ff_plan *plan, const ff_point *at)
{
    const size_t m = plan->l.n_shared + plan->l.n_own, n = e->n * e->C;
    double *values = malloc((n + 1) * sizeof *values);
    e->row = malloc((n * m + 1) * sizeof *e->row);
    e->row_channel = malloc((n + 1) * sizeof *e->row_channel);
    const ff_status status = values && e->row && e->row_channel ? gradients(e, plan, at, e->row, values) : FF_ERR_MEMORY;
    e->n_rows = 0;
    for (size_t i = 0; i < n && !status; i++) {
        if (!(values[i] - 1 + e->shift[i] > 0)) continue;
        e->row_channel[e->n_rows] = i % e->C;
        memmove(e->row + e->n_rows++ * m, e->row + i * m, m * sizeof *e->row);
    }
    free(values);
    return status;
}

/* ---- the whole ------------------------------------------------------------------------------- */

/* A minimum that replaces the one at the point; rough: on the way to another one. */
static ff_status solve_again(const ff_plan *plan, int rough, ff_point *at, ff_error *err)
{
    const ff_effort effort = {.parallel = 1, .tolerance = 1e-5, .max_iterations = plan->max_iterations};
    return rough ? ff_solve(plan, &effort, at, err) : ff_minimise(plan, at, err);
}

/* A larger weight, with the same pull K t. */
static void stiffen(ff_energy *e)
{
    e->weight *= 10;
    for (size_t i = 0; i < e->n * e->C; i++) e->shift[i] /= 10;
}

static ff_status conserve_energy(ff_energy *e, const ff_plan *plan, const ff_information *info, double cost2, ff_point *at,
                                 ff_error *err)
{
    enum { ROUNDS = 30, PEAKS = 6 };
    peak peaks[PEAKS];
    size_t n = 0;
    double last = INFINITY;
    int rough = 0;
    ff_status status = FF_OK;
    for (int round = 0; round < ROUNDS && !status; round++) {
        double worst = 0;
        int added = 0;
        status = find_peaks(plan, at, PEAKS, peaks, &n);
        if (!status) status = violation(e, plan, at, 1, &worst);
        if (status) break;
        if (n) worst = fmax(worst, peaks[0].albedo - 1);
        e->left = worst;
        if (round == 0) e->alone_cost2 = cost2;
        if (round == 0 && n) e->alone = peaks[0].albedo, e->alone_mu = pow(peaks[0].level, 3), e->alone_channel = peaks[0].channel;
        if ((worst <= FF_ALBEDO_LEFT && !rough) || at->outcome != FF_CONVERGED) break;
        for (size_t i = 0; i < n; i++)
            if (peaks[i].albedo > 1 + 0.2 * FF_ALBEDO_LEFT) added += add_view(e, &peaks[i]);
        if (e->weight == 0) {
            e->binds = 1;
            status = measure_scale(e, plan, info, at, cost2);
            e->weight = 10 * e->scale;
        } else if (!added && worst > 0.5 * last)
            stiffen(e);
        if (!added) last = worst;
        rough = worst > 20 * FF_ALBEDO_LEFT;
        if (!status) status = solve_again(plan, rough, at, err);
    }
    if (!status && e->binds) status = keep_rows(e, plan, at);
    return status;
}

/* info: by the data alone, whose objective was cost2 / 2. */
static ff_status solve_penalised(ff_penalties *e, const ff_plan *plan, const ff_information *info, double cost2, ff_point *at,
                                 ff_error *err)
{
    ff_status status = FF_OK;
    if (e->n_priors) {
        status = try_prior_means(e, plan, at);
        if (!status) status = solve_again(plan, 0, at, err);
    }
    if (!status && e->energy.wanted) status = conserve_energy(&e->energy, plan, info, cost2, at, err);
    if (!status && e->energy.left > 2 * FF_ALBEDO_LEFT && at->outcome == FF_CONVERGED) at->outcome = FF_STALLED;
    for (size_t i = 0; i < e->n_priors && !status; i++)
        e->prior[i].value = ff_layout_value(&plan->l, e->prior[i].coordinate, at->shape, at->channel);
    return status ? status : ff_errors(plan, at);
}

ff_status ff_penalised_solve(ff_plan *plan, ff_point *at, ff_error *err)
{
    ff_penalties *e = plan->own_penalties;
    const double cost2 = at->normal.cost2;
    if (!e) return FF_OK;
    for (size_t i = 0; i < e->n_priors; i++)
        e->prior[i].alone = ff_layout_value(&plan->l, e->prior[i].coordinate, at->shape, at->channel);
    weigh_priors(e, plan, at, cost2);
    ff_information *info = at->information; /* kept while the point moves on */
    at->information = NULL;
    const ff_status status = solve_penalised(e, plan, info, cost2, at, err);
    free(info);
    if (status == FF_ERR_CANCELLED) return ff_error_set(err, status, NULL, 0, -1, "cancelled");
    return status ? ff_error_set(err, status, NULL, 0, -1, "the fit with what is known besides the data failed: %s",
                                 ff_status_str(status))
                  : status;
}
