/* What the Jacobian at the optimum says of each parameter: its 95 % interval, and how well the parameters can be told from each
 * other. */
#include "fit/internal_fit.h"
#include "base/internal_statistics.h"
#include <math.h>
#include <stdlib.h>

static double clamp(const ff_param *info, double v)
{
    return fmin(fmax(v, info->lo), info->hi);
}

/* Symmetric in the coordinate that the parameter is fitted in: a roughness by a factor, F0 by a difference. */
void ff_interval_around(const ff_param *info, double half_width, ff_interval kind, ff_fit_value *v)
{
    const double x = ff_coordinate(info, v->value), dx = half_width / ff_coordinate_slope(info, v->value);
    v->interval = kind;
    v->low = ff_coordinate_value(info, x - dx);
    v->high = ff_coordinate_value(info, x + dx);
}

void ff_interval_from_bound(const ff_param *info, double slope, double inverse, double allowed, ff_fit_value *v)
{
    const double inside = v->at_bound < 0 ? 1 : -1, down = fmax(slope * inside, 0), h = inverse > 0 ? 1 / inverse : 0;
    double d = INFINITY;
    if (h > 0) d = (sqrt(down * down + 2 * h * allowed) - down) / h;
    if (!(h > 0) && down > 0) d = allowed / down;
    const double end = clamp(info, v->value + inside * d);
    v->interval = FF_INTERVAL_ONE_SIDED;
    v->low = fmin(v->value, end);
    v->high = fmax(v->value, end);
}

/* Parameters on a bound: the objective rises from there by its slope and, all others following, its curvature. */
static ff_status fill_one_sided(const ff_layout *l, const struct ff_problem *p, const ff_normal *n, const int *at_bound,
                                ff_fit_result *r)
{
    const size_t P = l->P;
    ff_uncertainty u;
    int *use = malloc((P + 1) * sizeof *use);
    double *H = malloc((P * P + P + 1) * sizeof *H), *g = H + P * P;
    ff_status st = use && H ? FF_OK : FF_ERR_MEMORY;
    for (size_t k = 0; k < P && !st; k++) use[k] = 1;
    if (!st) st = ff_uncertainty_new(l, p, n, use, p->n, &u);
    if (!st) {
        ff_normal_assemble(l, n, NULL, H, g);
        for (size_t k = 0; k < P; k++) {
            const double inverse = u.inverse[k * P + k], cov = u.cov[k * P + k];
            if (!at_bound[k]) continue;
            const double t = ff_student_quantile(0.9, u.dof[k]);
            ff_fit_value *v = ff_result_value(l, r, k);
            ff_interval_from_bound(ff_layout_param(l, k, NULL)->info, g[k], u.determined[k] ? inverse : 0,
                                   0.5 * t * t * (u.determined[k] && inverse > 0 ? cov / inverse : INFINITY), v);
        }
        ff_uncertainty_free(&u);
    }
    free(use);
    free(H);
    return st;
}

ff_status ff_intervals_fill(const ff_layout *l, const struct ff_problem *p, const ff_normal *n, const int *at_bound,
                            const ff_uncertainty *u, ff_fit_result *r)
{
    int any = 0;
    for (size_t k = 0; k < l->P; k++) {
        ff_fit_value *v = ff_result_value(l, r, k);
        any |= at_bound[k];
        if (isnan(v->std_error)) continue;
        ff_interval_around(ff_layout_param(l, k, NULL)->info, ff_student_quantile(0.95, u->dof[k]) * v->std_error, FF_INTERVAL_WALD,
                           v);
    }
    return any ? fill_one_sided(l, p, n, at_bound, r) : FF_OK;
}

/* ---- what can be told apart ------------------------------------------------------------------ */

/* A direction in which the objective is this much flatter than along the parameters themselves is worth a word. */
#define FF_FLAT 1e-4
/* And in one that is flatter than this nothing is determined. */
#define FF_NOTHING 1e-12
/* Share that a parameter has in it at least to be named. */
#define FF_SHARE 0.25

/* Of eigenvector V, the first column: the parameters that have a share in it trade off. */
static ff_status warn_of_flat_direction(const ff_layout *l, const size_t *index, const double *V, size_t n, double value,
                                        ff_fit_result *r)
{
    const int nothing = value <= FF_NOTHING;
    ff_warning_parameter *named = malloc((n + 1) * sizeof *named);
    ff_warning w = {.code = nothing ? FF_WARNING_COMBINATION_NOT_DETERMINED : FF_WARNING_TRADE_OFF,
                    .parameter = named,
                    .value = {nothing ? 0 : 1 / sqrt(value)}};
    for (size_t i = 0; i < n && named; i++)
        if (fabs(V[i * n]) >= FF_SHARE) named[w.n_parameters++] = ff_layout_warned(l, index[i]);
    ff_status s = named ? FF_OK : FF_ERR_MEMORY;
    if (!s && w.n_parameters > (nothing ? 1 : 2)) s = ff_warnings_add(&r->warnings, &w); /* pairs are warned of as correlated */
    free(named);
    return s;
}

ff_status ff_condition_fill(const ff_layout *l, const ff_normal *normal, const int *use, ff_fit_result *r)
{
    const size_t P = l->P;
    double *work = malloc((3 * P * P + 2 * P + 1) * sizeof *work), *H = work, *A = H + P * P, *V = A + P * P, *g = V + P * P,
           *w = g + P;
    size_t *index = malloc((P + 1) * sizeof *index), n = 0;
    if (!work || !index) {
        free(work);
        free(index);
        return FF_ERR_MEMORY;
    }
    ff_normal_assemble(l, normal, NULL, H, g);
    for (size_t k = 0; k < P; k++)
        if (use[k]) index[n++] = k;
    for (size_t i = 0; i < n; i++)
        for (size_t j = 0; j < n; j++) {
            const double scale = sqrt(H[index[i] * P + index[i]]) * sqrt(H[index[j] * P + index[j]]);
            A[i * n + j] = scale > 0 ? H[index[i] * P + index[j]] / scale : 0;
        }
    ff_symmetric_eigen(A, n, w, V);
    r->rank = 0;
    for (size_t i = 0; i < n; i++) r->rank += w[i] > FF_NOTHING;
    r->condition = n == 0 ? 1 : w[0] > FF_NOTHING ? sqrt(w[n - 1] / w[0]) : INFINITY;
    ff_status s = n > 1 && w[0] < FF_FLAT ? warn_of_flat_direction(l, index, V, n, w[0], r) : FF_OK;
    free(work);
    free(index);
    return s;
}
