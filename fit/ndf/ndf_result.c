/* What is said of a retrieved distribution: rows with errors, channels, measures of roughness, warnings. */
#include "internal_ndf.h"
#include "fit/noise/internal_noise.h"
#include <math.h>
#include <stdlib.h>

static const double pi = 3.14159265358979323846;

static double degrees(double radians)
{
    return radians * (180 / pi);
}

/* ---- errors ---------------------------------------------------------------------------------- */

/* Its variance: row^T cov row. */
static double variance_of(const double *row, const double *cov, size_t P)
{
    double sum = 0;
    for (size_t a = 0; a < P; a++)
        for (size_t b = 0; b < P; b++) sum += row[a] * cov[a * P + b] * row[b];
    return fmax(sum, 0);
}

/* The larger of what residuals say and what the noise does. */
typedef struct covariances {
    double *by[2];
    size_t n;
} covariances;

static double error_of(const double *row, const covariances *cov, size_t P)
{
    double most = 0;
    for (size_t i = 0; i < cov->n; i++) most = fmax(most, variance_of(row, cov->by[i], P));
    return sqrt(most);
}

/* Relative standard errors at tan theta = q: of D, whose area the tails share in, and of a D, a that of the brightest channel.
 * work [P]. */
static void errors_at(const ff_ndf_fit *f, const covariances *cov, double q, double *work, ff_ndf_row *out)
{
    const ff_stencil s = ff_curve_stencil(f->curve, q);
    const size_t P = f->P, top = (size_t)f->curve->top;
    size_t brightest = top;
    for (size_t k = top; k < P; k += 2)
        if (f->u[k] > f->u[brightest]) brightest = k;
    for (size_t k = 0; k < P; k++) {
        work[k] = 0;
        for (size_t i = 0; i < 4; i++) work[k] += s.w[i] * f->X[((size_t)s.first + i) * P + k];
    }
    out->d_error = error_of(work, cov, P);
    work[brightest] += 1 / f->u[brightest];
    out->error = error_of(work, cov, P);
}

/* Of parameter k; NaN on a bound. */
static double error_of_parameter(const ff_ndf_fit *f, const covariances *cov, size_t k)
{
    double most = 0;
    for (size_t i = 0; i < cov->n; i++) most = fmax(most, cov->by[i][k * f->P + k]);
    return f->held[k] ? NAN : sqrt(most);
}

static ff_status fill_channels(const ff_ndf_fit *f, const covariances *cov, ff_ndf_result *r)
{
    r->n_channels = f->n_channels;
    r->channel = malloc(f->n_channels * sizeof *r->channel);
    if (!r->channel) return FF_ERR_MEMORY;
    for (size_t c = 0; c < f->n_channels; c++) {
        const size_t a = (size_t)f->curve->top + 2 * c, kd = a + 1;
        r->channel[c] = (ff_ndf_channel){.f0 = f->scaled ? 1 : f->u[a],
                                         .ks = f->scaled ? f->u[a] : 1,
                                         .kd = f->u[kd],
                                         .scale_error = error_of_parameter(f, cov, a),
                                         .kd_error = error_of_parameter(f, cov, kd)};
    }
    return FF_OK;
}

/* ---- rows and measures ----------------------------------------------------------------------- */

enum { PER_STEP = 4 }; /* rows between nodes: the cubics of a profile's table follow the spline to 1e-5 then */

/* tan theta of row i of n. */
static double slope_of_row(const ff_curve *curve, size_t i, size_t n)
{
    return curve->scale * sinh((i + 2 < n ? (double)i / PER_STEP : curve->end) * curve->step);
}

/* Angles from the normal to the reach, on to where D is level, and one behind that says so. */
ff_status ff_ndf_rows(const ff_ndf_fit *f, ff_ndf_result *r)
{
    const ff_curve *curve = f->curve;
    const size_t n = (size_t)ceil(curve->end * PER_STEP - 1e-6) + 2;
    r->row = malloc(n * sizeof *r->row);
    if (!r->row) return FF_ERR_MEMORY;
    for (size_t i = 0; i < n; i++) {
        const double q = slope_of_row(curve, i, n), theta = i + 1 < n ? atan(q) : 0.5 * (FF_NDF_END + pi / 2);
        r->row[i] = (ff_ndf_row){.theta = theta, .d = exp(ff_curve_ln_d(curve, &f->state, q))};
    }
    r->n_rows = n;
    r->n_nodes = (size_t)curve->top + 1;
    return FF_OK;
}

static ff_status fill_errors(const ff_ndf_fit *f, const covariances *cov, ff_ndf_result *r)
{
    double *work = malloc(f->P * sizeof *work);
    if (!work) return FF_ERR_MEMORY;
    for (size_t i = 0; i < r->n_rows; i++) {
        ff_ndf_row *row = &r->row[i];
        errors_at(f, cov, slope_of_row(f->curve, i, r->n_rows), work, row);
        row->known = row->theta <= r->reach * (1 + 1e-9) && row->error <= FF_NDF_KNOWN && row->d_error <= FF_NDF_KNOWN;
    }
    free(work);
    return FF_OK;
}

static size_t first_row(const ff_ndf_result *r, size_t from, int known)
{
    while (from < r->n_rows && r->row[from].known != known) from++;
    return from;
}

/* The end of the first angles at which D is known. */
static double find_sure(const ff_ndf_result *r)
{
    const size_t first = first_row(r, 0, 1);
    return first < r->n_rows ? r->row[first_row(r, first, 0) - 1].theta : NAN;
}

static double half_width(const ff_ndf_result *r)
{
    for (size_t i = 1; i < r->n_rows; i++) {
        const ff_ndf_row *a = &r->row[i - 1], *b = &r->row[i];
        if (b->d > 0.5 * r->row[0].d) continue;
        return a->theta + (b->theta - a->theta) * log(2 * a->d / r->row[0].d) / log(a->d / b->d);
    }
    return r->row[r->n_rows - 1].theta;
}

static void fill_measures(const ff_ndf_fit *f, ff_ndf_result *r)
{
    const ff_curve *curve = f->curve;
    double area = 0, inside = 0, first = 0, second = 0;
    for (size_t l = 0; l < curve->n_slopes; l++) {
        const double weight = curve->measure[l] * f->state.exp_psi[l], q = curve->slope[l];
        area += weight;
        first += weight * q;
        if (q > tan(r->reach)) continue;
        inside += weight;
        second += weight * q * q;
    }
    const double mean = first / area;
    r->measures = (ff_ndf_measures){.half_width = half_width(r),
                                    .mean_slope = mean,
                                    .rms_slope = sqrt(second / inside),
                                    .beyond = 1 - inside / area,
                                    .alpha_peak = 1 / sqrt(pi * r->row[0].d),
                                    .beckmann_mean = 2 * mean / sqrt(pi),
                                    .ggx_mean = 2 * mean / pi};
}

/* ---- warnings -------------------------------------------------------------------------------- */

/* Runs of nodes where what must not rise does not fall: it would rise. */
static ff_status warn_level(const ff_ndf_fit *f, ff_ndf_monotone monotone, ff_ndf_result *r)
{
    const int top = f->curve->top;
    const ff_warning_code code = monotone == FF_NDF_MONOTONE_D ? FF_WARNING_D_KEPT_LEVEL : FF_WARNING_SLOPES_KEPT_LEVEL;
    ff_status status = FF_OK;
    for (int k = 0, end; k < top && !status; k = end + 1) {
        for (end = k; end < top && f->held[end] && f->u[end] <= f->lower[end];) end++;
        const double value[] = {degrees(atan(ff_curve_node(f->curve, k))), degrees(atan(ff_curve_node(f->curve, end)))};
        if (end - k >= 3) status = ff_warnings_say(&r->warnings, code, value);
    }
    return status;
}

static ff_status warn_of_start(ff_ndf_result *r)
{
    const double samples = (double)r->back_samples;
    ff_status status = FF_OK;
    if (r->outcome != FF_CONVERGED) status = ff_warnings_say(&r->warnings, FF_WARNING_RETRIEVAL_NOT_CONVERGED, NULL);
    if (!status && !r->from_back_scatter) status = ff_warnings_say(&r->warnings, FF_WARNING_PARAMETRIC_START, &samples);
    return status;
}

/* Angles at which D is not known, but for those behind the last at which it is. */
static ff_status warn_of_gaps(ff_ndf_result *r)
{
    ff_status status = FF_OK;
    for (size_t from = first_row(r, 0, 0), to; from < r->n_rows && !status; from = first_row(r, to, 0)) {
        to = first_row(r, from, 1);
        const int tail = to == r->n_rows;
        if (tail && from > 0) break;
        const double value[] = {degrees(from ? r->row[from - 1].theta : 0), degrees(tail ? r->reach : r->row[to].theta)};
        status = ff_warnings_say(&r->warnings, FF_WARNING_D_NOT_KNOWN, value);
    }
    return status;
}

/* The last angle at which D is known; 0: none. */
static double last_known(const ff_ndf_result *r)
{
    size_t n = r->n_rows;
    while (n > 0 && !r->row[n - 1].known) n--;
    return n > 0 ? r->row[n - 1].theta : 0;
}

/* Where D is more the continuation's than the data's. */
static ff_status warn_of_reach(const ff_ndf_fit *f, ff_ndf_result *r)
{
    const double power = 0 - f->u[f->curve->top - 1] / f->curve->step, first = degrees(r->first), last = last_known(r),
                 known = degrees(last), beyond = r->measures.beyond, tail[] = {degrees(r->reach), power, beyond};
    const int ends = r->reach < FF_NDF_END;
    ff_status status = FF_OK;
    if (r->first > 0.5 * r->measures.half_width) status = ff_warnings_say(&r->warnings, FF_WARNING_PEAK_CONTINUED, &first);
    if (!status) status = warn_of_gaps(r);
    if (!status && last > 0 && last < r->reach * (1 - 1e-9))
        status = ff_warnings_say(&r->warnings, FF_WARNING_TAIL_UNCERTAIN, &known);
    if (!status && ends) status = ff_warnings_say(&r->warnings, FF_WARNING_TAIL_CONTINUED, tail);
    if (!status && ends && beyond > 0.01) status = ff_warnings_say(&r->warnings, FF_WARNING_AREA_BEYOND_DATA, &beyond);
    return status;
}

static ff_status fill_warnings(const ff_ndf_fit *f, const struct ff_problem *p, ff_ndf_monotone monotone, ff_ndf_result *r)
{
    ff_status status = warn_of_start(r);
    if (!status) status = warn_of_reach(f, r);
    if (!status) status = warn_level(f, monotone, r);
    if (!status && r->scaled) status = ff_warnings_say(&r->warnings, FF_WARNING_SCALE_ABOVE_ONE, NULL);
    if (!status && !p->selection.isotropic) status = ff_warnings_say(&r->warnings, FF_WARNING_DIRECTION_AVERAGED, NULL);
    return status;
}

/* ---- the whole ------------------------------------------------------------------------------- */

static ff_status find_covariances(ff_ndf_fit *f, const struct ff_problem *p, const ff_fit_result *fit, covariances *cov)
{
    const size_t n = f->P * f->P;
    cov->by[0] = malloc(2 * n * sizeof *cov->by[0]);
    if (!cov->by[0]) return FF_ERR_MEMORY;
    cov->by[1] = cov->by[0] + n;
    cov->n = 1;
    ff_status status = ff_ndf_covariance(f, cov->by[0]);
    if (status || !fit->noise) return status;
    cov->n = 2;
    status = ff_ndf_take_noise(f, p, fit->noise->noise);
    return status ? status : ff_ndf_covariance(f, cov->by[1]);
}

ff_status ff_ndf_result_fill(ff_ndf_fit *f, const struct ff_problem *p, ff_ndf_monotone monotone, ff_ndf_result *r)
{
    covariances cov = {.n = 0};
    ff_status status = find_covariances(f, p, &r->fit[FF_NDF_TABULATED], &cov);
    if (!status) status = fill_errors(f, &cov, r);
    if (!status) status = fill_channels(f, &cov, r);
    free(cov.by[0]);
    if (status) return status;
    r->effective = ff_ndf_effective(f);
    r->smooth = f->smooth;
    r->objective = 0.5 * f->sums.cost2;
    r->iterations = f->iterations;
    r->passes = f->passes;
    r->sure = find_sure(r);
    fill_measures(f, r);
    return fill_warnings(f, p, monotone, r);
}
