/* The retrieval of a distribution of normals from beginning to end: the parametric fits it is measured by, the lattice, the start,
 * how smooth, all samples, and what is said of the result. */
#define _GNU_SOURCE /* clock_gettime */
#include "internal_ndf.h"
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

static const double pi = 3.14159265358979323846;

#define NODE_STEP  0.15  /* of the lattice, in y: about 15 nodes per factor of 10 in tan theta               */
#define LEAST_GAIN 0.05  /* of what lambert leaves, that a lobe has to explain to be one                     */
#define LEAST_VARIANCE 1e-14 /* of the mean square of the data: rounding, and what the lattice itself leaves    */
enum { LEAST_FILLED = 8 }; /* intervals of the lattice with half vectors in them */

/* ---- options and models ---------------------------------------------------------------------- */

void ff_ndf_options_init(ff_ndf_options *o)
{
    memset(o, 0, sizeof *o);
    o->size = sizeof *o;
    ff_fit_options_init(&o->fit);
    o->fit.shape = FF_SHAPE_ISOTROPIC;
    o->masking = ff_term_find(FF_MASKING, "smith-height-correlated");
    o->smooth = NAN;
}

ff_status ff_ndf_models(int masking, ff_model out[FF_NDF_MODELS], ff_error *err)
{
    static const char *const ndf[FF_NDF_FITS] = {"beckmann", "ggx", "student-t", "tabulated"};
    const int fresnel = ff_term_find(FF_FRESNEL, "schlick"), diffuse = ff_term_find(FF_DIFFUSE, "lambert");
    ff_status s = FF_OK;
    for (size_t i = 0; i < FF_NDF_FITS && !s; i++)
        s = ff_model_compose(ff_term_find(FF_NDF, ndf[i]), masking, fresnel, diffuse, &out[i], err);
    if (!s) s = ff_model_hold(&out[FF_NDF_TABULATED], "alpha", 1, err);
    return s ? s : ff_model_parse("lambert", &out[FF_NDF_FITS], err);
}

static ff_status check_options(const struct ff_problem *p, const ff_ndf_options *o, ff_error *err)
{
    if (o->size != sizeof *o)
        return ff_error_set(err, FF_ERR_RANGE, NULL, 0, -1, "the options were not initialised by ff_ndf_options_init");
    const ff_status s = ff_fit_options_check(&o->fit, err);
    if (s) return s;
    if (o->fit.robust != FF_ROBUST_NONE)
        return ff_error_set(err, FF_ERR_UNSUPPORTED, NULL, 0, -1, "a distribution is retrieved without a robust loss");
    if (o->smooth < 0 || isinf(o->smooth))
        return ff_error_set(err, FF_ERR_RANGE, NULL, 0, -1, "the weight of smoothness must not be negative, found %g", o->smooth);
    if (o->nodes && (o->nodes < FF_NDF_NODES_MIN || o->nodes > FF_NDF_NODES_MAX))
        return ff_error_set(err, FF_ERR_RANGE, NULL, 0, -1, "a lattice has %d to %d nodes, found %d", FF_NDF_NODES_MIN,
                            FF_NDF_NODES_MAX, o->nodes);
    if (p->geometry[FF_G_S2] < 0 || p->geometry[FF_G_C] < 0 || p->geometry[FF_G_K] < 0)
        return ff_error_set(err, FF_ERR_UNSUPPORTED, NULL, 0, -1,
                            "the problem was not made for the models of ff_ndf_models and an isotropic shape");
    return FF_OK;
}

/* ---- parametric fits ------------------------------------------------------------------------- */

static int is_scaled(const ff_fit_result *r)
{
    for (size_t c = 0; c < r->n_channels; c++)
        if (r->channel_value[c * r->model.n_channel].at_bound > 0) return 1;
    return 0;
}

/* The three fits. Where the data ask for F0 > 1, all of them with F0 = 1 and a scale ks instead. */
static ff_status fit_parametric(struct ff_problem *p, const ff_fit_options *o, ff_model *models, ff_ndf_result *r, ff_error *err)
{
    ff_status s = ff_problem_fit(p, &models[FF_NDF_STUDENT_T], o, &r->fit[FF_NDF_STUDENT_T], err);
    if (s) return s;
    r->scaled = is_scaled(&r->fit[FF_NDF_STUDENT_T]);
    if (r->scaled) {
        for (int i = 0; i < FF_NDF_FITS && !s; i++) {
            s = ff_model_hold(&models[i], "f0", 1, err);
            if (!s) s = ff_model_free(&models[i], "ks", err);
        }
        ff_fit_result_free(&r->fit[FF_NDF_STUDENT_T]);
        if (!s) s = ff_problem_fit(p, &models[FF_NDF_STUDENT_T], o, &r->fit[FF_NDF_STUDENT_T], err);
    }
    if (!s) s = ff_problem_fit(p, &models[FF_NDF_BECKMANN], o, &r->fit[FF_NDF_BECKMANN], err);
    if (!s) s = ff_problem_fit(p, &models[FF_NDF_GGX], o, &r->fit[FF_NDF_GGX], err);
    return s;
}

/* Is there a lobe at all? */
static ff_status check_peak(struct ff_problem *p, const ff_fit_options *o, const ff_model *lambert, const ff_ndf_result *r,
                            ff_error *err)
{
    ff_fit_result alone;
    const ff_status s = ff_problem_fit(p, lambert, o, &alone, err);
    if (s) return s;
    const double left = r->fit[FF_NDF_STUDENT_T].residual.objective, whole = alone.residual.objective;
    ff_fit_result_free(&alone);
    if (left < (1 - LEAST_GAIN) * whole) return FF_OK;
    return ff_error_set(err, FF_ERR_DATA, NULL, 0, -1,
                        "no specular peak: a lobe on top of a diffuse surface explains %.2g %% of what the diffuse surface alone "
                        "leaves, expected more than %g %%",
                        whole > 0 ? 100 * fmax(1 - left / whole, 0) : 0., 100 * LEAST_GAIN);
}

/* ---- the lattice ----------------------------------------------------------------------------- */

typedef struct range {
    double q_lo, q_hi;   /* tan theta of the half vectors                       */
    double tan_max;      /* of the directions                                   */
    double mean_square;  /* of the weighted data                                */
} range;

static range range_of(const struct ff_problem *p)
{
    const double most = tan(89.5 * pi / 180);
    double lo = INFINITY, hi = 0, sum = 0;
    for (size_t i = 0; i < p->n; i++) {
        const size_t block = i / FF_BLOCK, lane = i % FF_BLOCK;
        const double s2 = ff_problem_plane(p, block, p->geometry[FF_G_S2])[lane];
        lo = fmin(lo, s2);
        hi = fmax(hi, s2);
        for (int c = 0; c < (int)p->n_channels; c++) {
            const double v = ff_problem_plane(p, block, p->weight + p->weight_stride * c)[lane] *
                             ff_problem_plane(p, block, p->target + c)[lane];
            sum += v * v;
        }
    }
    return (range){sqrt(lo), fmin(sqrt(hi), most), fmin(sqrt(p->tan2_hi) * (1 + 1e-9), most), sum / (double)(p->n * p->n_channels)};
}

static double parameter(const ff_fit_result *r, const char *name)
{
    return r->shape_value[ff_model_param_find(&r->model, name)].value;
}

/* p = (1 + q^2 / core2)^-gamma */
typedef struct student_t {
    double core2, gamma;
} student_t;

static student_t student_t_of(const ff_fit_result *r)
{
    const double alpha = parameter(r, "alpha_x"), gamma = parameter(r, "gamma");
    return (student_t){(gamma - 1) * alpha * alpha, gamma};
}

/* The nodes begin to be even in ln tan theta at a quarter of where the distribution begins to be a power, or of 2.5 half widths. */
static double scale_of(student_t t)
{
    const double half2 = t.core2 * (exp2(1 / t.gamma) - 1);
    return 0.25 * sqrt(fmin(t.core2, 6.25 * half2));
}

static ff_status make_lattice(const struct ff_problem *p, const ff_ndf_options *o, student_t t, const range *range, ff_curve *out,
                              ff_error *err)
{
    const double scale = scale_of(t), wanted = ceil(asinh(range->q_hi / scale) / NODE_STEP);
    const int top = o->nodes ? o->nodes - 1 : (int)fmin(fmax(wanted, FF_NDF_LEAST_TOP), FF_NDF_MOST_TOP);
    unsigned char filled[FF_NDF_MOST_TOP + 1] = {0};
    int n = 0;
    if (p->n * p->n_channels < (size_t)top + 1 + 2 * p->n_channels)
        return ff_error_set(err, FF_ERR_DATA, NULL, 0, -1,
                            "%zu values (%zu samples of %zu channels) cannot determine a distribution at %d angles",
                            p->n * p->n_channels, p->n, p->n_channels, top + 1);
    const double step = asinh(range->q_hi / scale) / top;
    for (size_t i = 0; i < p->n; i++) {
        const double s2 = ff_problem_plane(p, i / FF_BLOCK, p->geometry[FF_G_S2])[i % FF_BLOCK];
        filled[(int)fmin(asinh(sqrt(s2) / scale) / step, top)] = 1;
    }
    for (int k = 0; k <= top; k++) n += filled[k];
    if (n < LEAST_FILLED)
        return ff_error_set(err, FF_ERR_DATA, NULL, 0, -1,
                            "the half vectors of the samples lie at %d of the %d angles of a distribution, expected at least %d", n,
                            top + 1, LEAST_FILLED);
    if (ff_curve_new(scale, range->q_hi, top, ff_masking_at(o->masking)->uses_lambda, range->tan_max, out))
        return ff_error_set(err, FF_ERR_MEMORY, NULL, 0, -1, "out of memory");
    return FF_OK;
}

/* ---- the start ------------------------------------------------------------------------------- */

static void fill_box(ff_ndf_fit *f)
{
    const size_t top = (size_t)f->curve->top;
    for (size_t k = 0; k < f->P; k++) {
        f->lower[k] = 0;
        f->upper[k] = k < top ? 60 : (k - top) % 2 == 0 && f->scaled ? 1e6 : 1;
    }
}

/* Falls of the reference and a start: student-t's where nothing better is known. */
static void fill_start(const struct ff_problem *p, student_t t, const ff_fit_result *from, ff_ndf_fit *f, ff_ndf_result *r)
{
    const ff_curve *curve = f->curve;
    const size_t C = p->n_channels, top = (size_t)curve->top, stride = from->model.n_channel;
    double ln_d[FF_NDF_MOST_TOP + 1], *channel = f->u + top, *kd = f->work;
    for (int k = 0; k <= curve->top; k++) {
        const double q = ff_curve_node(curve, k), q2 = q * q;
        ln_d[k] = 2 * log1p(q2) - t.gamma * log1p(q2 / t.core2);
    }
    ff_ndf_falls(curve, ln_d, f->reference);
    const int ks = -1 - ff_model_param_find(&from->model, "ks"), at_kd = -1 - ff_model_param_find(&from->model, "kd");
    for (size_t c = 0; c < C; c++) {
        const ff_fit_value *v = from->channel_value + c * stride;
        channel[2 * c] = f->scaled ? v[ks].value : v[0].value;
        kd[c] = channel[2 * c + 1] = v[at_kd].value;
    }
    r->from_back_scatter = ff_ndf_back_scatter(p, curve, kd, f->u, r);
    if (!r->from_back_scatter) memcpy(f->u, f->reference, top * sizeof *f->u);
    for (size_t k = 0; k < f->P; k++) f->u[k] = fmin(fmax(f->u[k], f->lower[k]), f->upper[k]);
}

/* ---- how smooth ------------------------------------------------------------------------------ */

#define SMOOTHEST 1e4
#define ROUGHEST  1e-2
#define ROUGH_TOLERANCE 1e-5
#define FINE_TOLERANCE  1e-8

/* From smooth to rough, each from the one before; the variances follow the residuals. The best by cross-validation stays in f. */
static ff_status choose_smooth(ff_ndf_fit *f, const struct ff_problem *p, double least_variance)
{
    enum { WORSE = 4 };
    const size_t P = f->P;
    double *best = malloc(2 * P * sizeof *best), least = INFINITY, smooth = 0;
    int converged, worse = 0;
    ff_status s = best ? ff_ndf_look(f, p) : FF_ERR_MEMORY;
    for (double next = SMOOTHEST; !s && next >= ROUGHEST && worse < WORSE; next /= sqrt(10)) {
        ff_ndf_variances(f, least_variance);
        f->smooth = next;
        s = ff_ndf_solve(f, p, ROUGH_TOLERANCE, 50, &converged);
        if (!s) s = ff_ndf_look(f, p);
        if (s) break;
        const double cost2 = ff_ndf_left_out(f);
#ifdef NDF_TRACE
        fprintf(stderr, "smooth %g cost2 %g left out %g passes %d conv %d\n", next, f->sums.cost2, cost2, f->passes, converged);
#endif
        worse = cost2 < least ? 0 : worse + 1;
        if (worse) continue;
        least = cost2;
        smooth = next;
        memcpy(best, f->u, P * sizeof *best);
        memcpy(best + P, f->variance, P * sizeof *best);
    }
    if (!s) {
        f->smooth = smooth;
        memcpy(f->u, best, P * sizeof *best);
        memcpy(f->variance, best + P, P * sizeof *best);
    }
    free(best);
    return s;
}

/* The same way to a given weight. */
static ff_status approach_smooth(ff_ndf_fit *f, const struct ff_problem *p, double least_variance, double wanted)
{
    int converged;
    ff_status s = ff_ndf_look(f, p);
    for (double next = fmax(SMOOTHEST, wanted);; next = fmax(next / 10, wanted)) {
        if (s) return s;
        ff_ndf_variances(f, least_variance);
        f->smooth = next;
        s = ff_ndf_solve(f, p, ROUGH_TOLERANCE, 50, &converged);
        if (!s) s = ff_ndf_look(f, p);
        if (next <= wanted || next < ROUGHEST * 1e-6) break;
    }
    f->smooth = wanted;
    return s;
}

/* ---- what is said of the result -------------------------------------------------------------- */

static void warn(ff_ndf_result *r, const char *fmt, ...) __attribute__((format(printf, 2, 3)));
static void warn(ff_ndf_result *r, const char *fmt, ...)
{
    if (r->n_warnings == FF_MAX_WARNINGS) return;
    va_list args;
    va_start(args, fmt);
    vsnprintf(r->warning[r->n_warnings++], FF_WARNING_LENGTH, fmt, args);
    va_end(args);
}

static double degrees(double radians)
{
    return radians * (180 / pi);
}

/* Relative standard error of D at tan theta = q, the area counted in. work [P]. */
static double error_at(const ff_ndf_fit *f, const double *cov, double q, double *work)
{
    const ff_stencil s = ff_curve_stencil(f->curve, q);
    const size_t P = f->P;
    double variance = 0;
    for (size_t k = 0; k < P; k++) {
        work[k] = -f->X[f->sums.n_curve * P + k];
        for (size_t i = 0; i < 4; i++) work[k] += s.w[i] * f->X[((size_t)s.first + i) * P + k];
    }
    for (size_t a = 0; a < P; a++)
        for (size_t b = 0; b < P; b++) variance += work[a] * cov[a * P + b] * work[b];
    return sqrt(fmax(variance, 0));
}

enum { PER_STEP = 4 }; /* rows between nodes: the cubics of a profile's table follow the spline to 1e-5 then */

/* Angles from the normal to the reach, then on to where hardly any area is left. */
static ff_status fill_rows(const ff_ndf_fit *f, const double *cov, ff_ndf_result *r)
{
    const ff_curve *curve = f->curve;
    const double q_end = tan(89.5 * pi / 180), step = curve->step / PER_STEP;
    const size_t inside = (size_t)curve->top * PER_STEP + 1;
    const size_t beyond = (size_t)fmax(0, ceil(asinh(q_end / curve->scale) / curve->step - curve->top));
    r->row = malloc((inside + beyond) * sizeof *r->row);
    double *work = malloc(f->P * sizeof *work);
    if (r->row && work)
        for (size_t i = 0; i < inside + beyond; i++) {
            const size_t steps = i < inside ? i : inside - 1 + PER_STEP * (i - inside + 1);
            const double q = curve->scale * sinh((double)steps * step);
            r->row[i] = (ff_ndf_row){atan(q), exp(ff_curve_ln_d(curve, &f->state, q)), error_at(f, cov, q, work)};
            if (i < inside && (i == 0 || r->sure == r->row[i - 1].theta) && r->row[i].error < 0.5) r->sure = r->row[i].theta;
        }
    free(work);
    r->n_rows = inside + beyond;
    r->n_nodes = (size_t)curve->top + 1;
    return r->row ? FF_OK : FF_ERR_MEMORY;
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

/* Runs of nodes where D does not fall though it is free to: it would rise. */
static void warn_level(const ff_ndf_fit *f, ff_ndf_result *r)
{
    const int top = f->curve->top;
    for (int k = 0, end; k < top; k = end + 1) {
        for (end = k; end < top && f->held[end] && f->u[end] <= 0;) end++;
        if (end - k < 3) continue;
        warn(r, "the data would have D rise from %.3g to %.3g degrees; it is kept level there", degrees(atan(ff_curve_node(f->curve, k))),
             degrees(atan(ff_curve_node(f->curve, end))));
    }
}

static void fill_warnings(const ff_ndf_fit *f, const struct ff_problem *p, ff_ndf_result *r)
{
    const ff_ndf_measures *m = &r->measures;
    const double power = f->u[f->curve->top - 1] / f->curve->step;
    if (r->outcome != FF_CONVERGED) warn(r, "the minimisation stopped before it converged: D may not be the best one");
    if (!r->from_back_scatter)
        warn(r, "these data have %zu samples that look back along the light, too few for the power iteration: the start is the best "
                "fit of student-t", r->back_samples);
    if (r->first > 0.5 * m->half_width)
        warn(r, "no half vector is nearer to the normal than %.3g degrees: the peak of D is the smooth continuation to there",
             degrees(r->first));
    if (r->sure < r->reach)
        warn(r, "beyond %.3g degrees the data say little: D follows student-t there as far as they let it", degrees(r->sure));
    if (r->reach < 89 * pi / 180)
        warn(r, "no half vector lies beyond %.3g degrees: D goes on from there as tan(theta)^-%.3g%s", degrees(r->reach), power,
             m->beyond > 0.01 ? "" : ", with less than 1 % of the area");
    if (r->reach < 89 * pi / 180 && m->beyond > 0.01)
        warn(r, "%.2g %% of the projected area lies beyond the data: F0 and the masking depend on that continuation", 100 * m->beyond);
    warn_level(f, r);
    if (r->scaled)
        warn(r, "the data ask for F0 > 1: F = 1 and a scale ks instead, in all fits; are the data in 1/sr?");
    if (!p->selection.isotropic)
        warn(r, "these data may show a direction; D is isotropic, the mean over the azimuths as the samples have them");
}

/* ---- the retrieved distribution as a model --------------------------------------------------- */

static ff_status fit_profile(struct ff_problem *p, const ff_fit_options *o, ff_model *m, ff_ndf_result *r, ff_error *err)
{
    double *theta = malloc(2 * r->n_rows * sizeof *theta), *d = theta + r->n_rows;
    r->profile = malloc(sizeof *r->profile);
    ff_status s = theta && r->profile ? FF_OK : ff_error_set(err, FF_ERR_MEMORY, NULL, 0, -1, "out of memory");
    for (size_t i = 0; i < r->n_rows && !s; i++) {
        theta[i] = r->row[i].theta;
        d[i] = r->row[i].d;
    }
    if (!s) s = ff_profile_make(FF_PROFILE_D, r->n_rows, theta, d, r->profile, NULL, err);
    free(theta);
    if (s) return s;
    ff_model_set_table(m, r->profile);
    return ff_problem_fit(p, m, o, &r->fit[FF_NDF_TABULATED], err);
}

/* ---- the whole ------------------------------------------------------------------------------- */

static double seconds(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static ff_status failed(ff_status s, ff_error *err)
{
    if (s == FF_OK) return FF_OK;
    return ff_error_set(err, s, NULL, 0, -1, s == FF_ERR_CANCELLED ? "cancelled" : "the retrieval failed: %s", ff_status_str(s));
}

/* From the start to the optimum on all samples, with what is said of it. */
static ff_status refine(ff_ndf_fit *f, const struct ff_problem *p, const ff_ndf_options *o, double least_variance, ff_ndf_result *r)
{
    const struct ff_problem *fewer = p->middle ? p->middle : p;
    int converged = 0;
    ff_status s = isnan(o->smooth) ? choose_smooth(f, fewer, least_variance) : approach_smooth(f, fewer, least_variance, o->smooth);
    if (!s && fewer != p) {
        s = ff_ndf_look(f, p);
        if (!s) ff_ndf_variances(f, least_variance);
    }
    if (!s) s = ff_ndf_solve(f, p, FINE_TOLERANCE, o->fit.max_iterations, &converged);
    if (!s) s = ff_ndf_look(f, p);
    double *cov = malloc(f->P * f->P * sizeof *cov);
    if (!s) s = cov ? ff_ndf_covariance(f, cov) : FF_ERR_MEMORY;
    if (!s) s = fill_rows(f, cov, r);
    free(cov);
    if (s) return s;
    r->effective = ff_ndf_effective(f);
    r->smooth = f->smooth;
    r->objective = 0.5 * f->sums.cost2;
    r->outcome = converged ? FF_CONVERGED : f->iterations >= o->fit.max_iterations ? FF_LIMIT : FF_STALLED;
    r->iterations = f->iterations;
    r->passes = f->passes;
    fill_measures(f, r);
    fill_warnings(f, p, r);
    return FF_OK;
}

static ff_status retrieve(struct ff_problem *p, const ff_ndf_options *o, ff_ndf_result *r, ff_error *err)
{
    ff_model models[FF_NDF_MODELS];
    ff_curve curve = {.top = 0};
    ff_ndf_fit f = {.P = 0};
    ff_status s = ff_ndf_models(o->masking, models, err);
    if (!s) s = fit_parametric(p, &o->fit, models, r, err);
    if (!s) s = check_peak(p, &o->fit, &models[FF_NDF_FITS], r, err);
    if (s) return s;
    const student_t t = student_t_of(&r->fit[FF_NDF_STUDENT_T]);
    const range range = range_of(p);
    const ff_term *masking = ff_term_at(FF_MASKING, (size_t)o->masking);
    r->first = atan(range.q_lo);
    r->reach = atan(range.q_hi);
    s = make_lattice(p, o, t, &range, &curve, err);
    if (s) return s;
    s = ff_ndf_fit_new(&curve, &o->fit, o->masking, masking->n_params ? masking->params[0].init : 0, r->scaled, p->n_channels, &f);
    if (!s) {
        fill_box(&f);
        fill_start(p, t, &r->fit[FF_NDF_STUDENT_T], &f, r);
        s = refine(&f, p, o, LEAST_VARIANCE * range.mean_square, r);
    }
    ff_ndf_fit_free(&f);
    ff_curve_free(&curve);
    return s ? failed(s, err) : fit_profile(p, &o->fit, &models[FF_NDF_TABULATED], r, err);
}

ff_status ff_ndf_retrieve(ff_problem *p, const ff_ndf_options *o, ff_ndf_result *out, ff_error *err)
{
    const double began = seconds();
    ff_ndf_result *r = calloc(1, sizeof *r);
    if (!r) return ff_error_set(err, FF_ERR_MEMORY, NULL, 0, -1, "out of memory");
    ff_status s = check_options(p, o, err);
    if (!s) s = retrieve(p, o, r, err);
    if (s) {
        ff_ndf_result_free(r);
    } else {
        r->time_s = seconds() - began;
        *out = *r;
    }
    free(r);
    return s;
}

void ff_ndf_result_free(ff_ndf_result *r)
{
    if (!r) return;
    for (int i = 0; i < FF_NDF_FITS; i++) ff_fit_result_free(&r->fit[i]);
    free(r->row);
    free(r->profile);
    memset(r, 0, sizeof *r);
}
