/* What is said of a retrieved distribution: rows with errors, channels, measures of roughness, warnings. */
#include "internal_ndf.h"
#include <math.h>
#include <stdlib.h>

static const double pi = 3.14159265358979323846;

static double degrees(double radians)
{
    return radians * (180 / pi);
}

/* ---- errors ---------------------------------------------------------------------------------- */

/* Relative standard error of a D at tan theta = q, a that of the brightest channel. work [P]. */
static double error_at(const ff_ndf_fit *f, const double *cov, double q, double *work)
{
    const ff_stencil s = ff_curve_stencil(f->curve, q);
    const size_t P = f->P, top = (size_t)f->curve->top;
    size_t brightest = top;
    double variance = 0;
    for (size_t k = top; k < P; k += 2)
        if (f->u[k] > f->u[brightest]) brightest = k;
    for (size_t k = 0; k < P; k++) {
        work[k] = k == brightest ? 1 / f->u[k] : 0;
        for (size_t i = 0; i < 4; i++) work[k] += s.w[i] * f->X[((size_t)s.first + i) * P + k];
    }
    for (size_t a = 0; a < P; a++)
        for (size_t b = 0; b < P; b++) variance += work[a] * cov[a * P + b] * work[b];
    return sqrt(fmax(variance, 0));
}

static ff_status fill_channels(const ff_ndf_fit *f, const double *cov, ff_ndf_result *r)
{
    r->n_channels = f->n_channels;
    r->channel = malloc(f->n_channels * sizeof *r->channel);
    if (!r->channel) return FF_ERR_MEMORY;
    for (size_t c = 0; c < f->n_channels; c++) {
        const size_t a = (size_t)f->curve->top + 2 * c, kd = a + 1;
        r->channel[c] = (ff_ndf_channel){.f0 = f->scaled ? 1 : f->u[a],
                                         .ks = f->scaled ? f->u[a] : 1,
                                         .kd = f->u[kd],
                                         .scale_error = f->held[a] ? NAN : sqrt(fmax(cov[a * f->P + a], 0)),
                                         .kd_error = f->held[kd] ? NAN : sqrt(fmax(cov[kd * f->P + kd], 0))};
    }
    return FF_OK;
}

/* ---- rows and measures ----------------------------------------------------------------------- */

enum { PER_STEP = 4 }; /* rows between nodes: the cubics of a profile's table follow the spline to 1e-5 then */

/* Angles from the normal to the reach, on to where D is level, and one behind that says so. */
static ff_status fill_rows(const ff_ndf_fit *f, const double *cov, ff_ndf_result *r)
{
    const ff_curve *curve = f->curve;
    const size_t n = (size_t)ceil(curve->end * PER_STEP - 1e-6) + 2;
    r->row = malloc(n * sizeof *r->row);
    double *work = malloc(f->P * sizeof *work);
    for (size_t i = 0; i < n && r->row && work; i++) {
        const double q = curve->scale * sinh((i + 2 < n ? (double)i / PER_STEP : curve->end) * curve->step);
        const double theta = i + 1 < n ? atan(q) : 0.5 * (FF_NDF_END + pi / 2);
        r->row[i] = (ff_ndf_row){theta, exp(ff_curve_ln_d(curve, &f->state, q)), error_at(f, cov, q, work)};
        if (theta <= r->reach * (1 + 1e-9) && r->row[i].error < 0.5) r->sure = theta;
    }
    const int complete = r->row && work;
    free(work);
    r->n_rows = n;
    r->n_nodes = (size_t)curve->top + 1;
    return complete ? FF_OK : FF_ERR_MEMORY;
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

/* Where D is more the continuation's than the data's. */
static ff_status warn_of_reach(const ff_ndf_fit *f, ff_ndf_result *r)
{
    const double power = 0 - f->u[f->curve->top - 1] / f->curve->step, first = degrees(r->first), sure = degrees(r->sure),
                 beyond = r->measures.beyond, tail[] = {degrees(r->reach), power, beyond};
    const int ends = r->reach < FF_NDF_END;
    ff_status status = FF_OK;
    if (r->first > 0.5 * r->measures.half_width) status = ff_warnings_say(&r->warnings, FF_WARNING_PEAK_CONTINUED, &first);
    if (!status && r->sure < r->reach) status = ff_warnings_say(&r->warnings, FF_WARNING_TAIL_UNCERTAIN, &sure);
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

ff_status ff_ndf_result_fill(ff_ndf_fit *f, const struct ff_problem *p, ff_ndf_monotone monotone, ff_ndf_result *r)
{
    double *cov = malloc(f->P * f->P * sizeof *cov);
    ff_status status = cov ? ff_ndf_covariance(f, cov) : FF_ERR_MEMORY;
    if (!status) status = fill_rows(f, cov, r);
    if (!status) status = fill_channels(f, cov, r);
    free(cov);
    if (status) return status;
    r->effective = ff_ndf_effective(f);
    r->smooth = f->smooth;
    r->objective = 0.5 * f->sums.cost2;
    r->iterations = f->iterations;
    r->passes = f->passes;
    fill_measures(f, r);
    return fill_warnings(f, p, monotone, r);
}
