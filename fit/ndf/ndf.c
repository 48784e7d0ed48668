/* The retrieval of a distribution of normals from beginning to end: the parametric fits it is measured by, the lattice, the start,
 * how smooth, all samples, and the result as a model of its own.
 *
 * Minimised is the objective of a fit and the penalty of ndf_solve.c, over D on a lattice, F0 and kd per channel. The penalty draws
 * to the best of the fits of beckmann, ggx and student-t: that is what D follows where the data say nothing. Its weight goes from
 * 1e4 downwards; the last one stays that lowers the residual of samples left out one at a time, as their leverages estimate it,
 * which is cross-validation that does not take the noise to be the same everywhere. */
#define _GNU_SOURCE /* clock_gettime */
#include "internal_ndf.h"
#include "base/internal_options.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#define NODE_STEP 0.15       /* of the lattice, in y: about 15 nodes per factor of 10 in tan theta               */
enum { BEYOND = 2 };         /* nodes behind the last half vector: straight ends would bend the curve before it */
#define LEAST_GAIN     0.05  /* of what lambert leaves, that a lobe has to explain to be one                     */
#define LEAST_VARIANCE 1e-12 /* of the mean square of the data: rounding, and what the lattice itself leaves    */
#define MOST_RISE      0.8   /* power of tan theta by which D may go on beyond the data: the slopes keep a mean         */
enum { LEAST_FILLED = 8 };   /* intervals of the lattice with half vectors in them */

/* ---- options and models ---------------------------------------------------------------------- */

static const char *const monotones[FF_NDF_MONOTONE_COUNT] = {"slopes", "d"};

const char *ff_ndf_monotone_name(int monotone)
{
    return monotone >= 0 && monotone < FF_NDF_MONOTONE_COUNT ? monotones[monotone] : NULL;
}

int ff_ndf_monotone_find(const char *name)
{
    for (int i = 0; i < FF_NDF_MONOTONE_COUNT; i++)
        if (strcmp(monotones[i], name) == 0) return i;
    return -1;
}

void ff_ndf_options_init_size(ff_ndf_options *o, size_t size)
{
    const ff_ndf_options defaults = {.masking = ff_term_find(FF_MASKING, "smith-height-correlated"), .smooth = NAN};
    ff_options_init(o, size, &defaults, sizeof defaults);
}

ff_status ff_ndf_models(int masking, ff_model out[FF_NDF_MODELS], ff_error *err)
{
    static const char *const ndf[FF_NDF_FITS] = {"beckmann", "ggx", "student-t", "tabulated"};
    const int fresnel = ff_term_find(FF_FRESNEL, "schlick"), diffuse = ff_term_find(FF_DIFFUSE, "lambert");
    ff_status status = FF_OK;
    for (size_t i = 0; i < FF_NDF_FITS && !status; i++)
        status = ff_model_compose(ff_term_find(FF_NDF, ndf[i]), masking, fresnel, diffuse, &out[i], err);
    if (!status) status = ff_model_hold(&out[FF_NDF_TABULATED], "alpha", 1, err);
    return status ? status : ff_model_parse("lambert", &out[FF_NDF_FITS], err);
}

ff_status ff_ndf_options_check(const ff_ndf_options *o, ff_error *err)
{
    if (o->size != sizeof *o)
        return ff_error_set(err, FF_ERR_RANGE, NULL, 0, -1, "the options were not initialised by ff_ndf_options_init");
    const ff_status status = ff_fit_options_check(o->fit, err);
    if (status) return status;
    if (o->fit->robust != FF_ROBUST_NONE)
        return ff_error_set(err, FF_ERR_UNSUPPORTED, NULL, 0, -1, "a distribution is retrieved without a robust loss");
    if (o->smooth < 0 || isinf(o->smooth))
        return ff_error_set(err, FF_ERR_RANGE, NULL, 0, -1, "the weight of smoothness must not be negative, found %g", o->smooth);
    if (!ff_ndf_monotone_name((int)o->monotone))
        return ff_error_set(err, FF_ERR_RANGE, NULL, 0, -1, "the option of what must not rise names neither D nor the slopes");
    if (o->nodes && (o->nodes < FF_NDF_NODES_MIN || o->nodes > FF_NDF_NODES_MAX))
        return ff_error_set(err, FF_ERR_RANGE, NULL, 0, -1, "a lattice has %d to %d nodes, found %d", FF_NDF_NODES_MIN,
                            FF_NDF_NODES_MAX, o->nodes);
    return FF_OK;
}

static ff_status check_options(const struct ff_problem *p, const ff_ndf_options *o, ff_error *err)
{
    const ff_status status = ff_ndf_options_check(o, err);
    if (status) return status;
    if (p->geometry[FF_G_S2] < 0 || p->geometry[FF_G_C] < 0 || p->geometry[FF_G_K] < 0)
        return ff_error_set(err, FF_ERR_UNSUPPORTED, NULL, 0, -1,
                            "the problem was not made for the models of a retrieval and an isotropic shape");
    return FF_OK;
}

/* ---- parametric fits ------------------------------------------------------------------------- */

static int is_scaled(const ff_fit_result *r)
{
    for (size_t c = 0; c < r->n_channels; c++)
        if (r->channel_value[c * r->model.n_channel].at_bound > 0) return 1;
    return 0;
}

static ff_status fit_one(const struct ff_problem *p, const ff_model *m, const ff_fit_options *o, ff_fit_result *out, ff_error *err)
{
    const ff_status status = ff_problem_fit_into(p, m, o, out, err);
    if (status || out->outcome != FF_CANCELLED) return status;
    ff_fit_result_clear(out);
    return ff_error_set(err, FF_ERR_CANCELLED, NULL, 0, -1, "cancelled");
}

/* The three fits. Where the data ask for F0 > 1, all of them with F0 = 1 and a scale ks instead. */
static ff_status fit_parametric(const struct ff_problem *p, const ff_fit_options *o, ff_model *models, ff_ndf_result *r,
                                ff_error *err)
{
    ff_fit_result *widest = &r->fit[FF_NDF_STUDENT_T];
    ff_status status = fit_one(p, &models[FF_NDF_STUDENT_T], o, widest, err);
    if (status) return status;
    r->scaled = is_scaled(widest);
    for (int i = 0; i < FF_NDF_FITS && r->scaled && !status; i++) {
        status = ff_model_hold(&models[i], "f0", 1, err);
        if (!status) status = ff_model_vary(&models[i], "ks", err);
    }
    if (r->scaled) {
        ff_fit_result_clear(widest);
        if (!status) status = fit_one(p, &models[FF_NDF_STUDENT_T], o, widest, err);
    }
    for (int i = FF_NDF_BECKMANN; i <= FF_NDF_GGX && !status; i++) status = fit_one(p, &models[i], o, &r->fit[i], err);
    for (int i = FF_NDF_BECKMANN; i <= FF_NDF_STUDENT_T && !status; i++)
        if (r->fit[i].residual.objective < r->fit[r->reference].residual.objective) r->reference = i;
    return status;
}

/* Is there a lobe at all? */
static ff_status check_peak(const struct ff_problem *p, const ff_fit_options *o, const ff_model *lambert, const ff_ndf_result *r,
                            ff_error *err)
{
    ff_fit_result alone;
    const ff_status status = fit_one(p, lambert, o, &alone, err);
    if (status) return status;
    const double left = r->fit[FF_NDF_STUDENT_T].residual.objective, whole = alone.residual.objective;
    ff_fit_result_clear(&alone);
    if (left < (1 - LEAST_GAIN) * whole) return FF_OK;
    return ff_error_set(err, FF_ERR_DATA, NULL, 0, -1,
                        "no specular peak: a lobe on top of a diffuse surface explains %.2g %% of what the diffuse surface alone "
                        "leaves, expected more than %g %%",
                        whole > 0 ? 100 * fmax(1 - left / whole, 0) : 0., 100 * LEAST_GAIN);
}

/* ---- the lattice ----------------------------------------------------------------------------- */

typedef struct range {
    double q_lo, q_hi;  /* tan theta of the half vectors                       */
    double tan_max;     /* of the directions                                   */
    double mean_square; /* of the weighted data                                */
} range;

static range range_of(const struct ff_problem *p)
{
    const double most = tan(FF_NDF_END);
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
    return ff_fit_result_find(r, name, 0)->value;
}

/* The density of slopes of a parametric fit: (1 + q^2 / core2)^-gamma, or e^(-q^2 / core2) with gamma infinite. */
typedef struct reference {
    double core2, gamma;
} reference;

static reference reference_of(const ff_ndf_result *r)
{
    const ff_fit_result *fit = &r->fit[r->reference];
    const double alpha = parameter(fit, "alpha_x"), alpha2 = alpha * alpha;
    if (r->reference == FF_NDF_BECKMANN) return (reference){alpha2, INFINITY};
    const double gamma = r->reference == FF_NDF_GGX ? 2 : parameter(fit, "gamma");
    return (reference){(gamma - 1) * alpha2, gamma};
}

static double reference_ln_d(reference t, double q2)
{
    return 2 * log1p(q2) - (isinf(t.gamma) ? q2 / t.core2 : t.gamma * log1p(q2 / t.core2));
}

/* The nodes begin to be even in ln tan theta at a quarter of where the distribution begins to be a power, or of 2.5 half widths. */
static double scale_of(reference t)
{
    const double half2 = t.core2 * (isinf(t.gamma) ? log(2) : exp2(1 / t.gamma) - 1);
    return 0.25 * (isinf(t.gamma) ? 2.5 * sqrt(half2) : sqrt(fmin(t.core2, 6.25 * half2)));
}

static ff_status make_lattice(const struct ff_problem *p, const ff_ndf_options *o, reference t, const range *range, ff_curve *out,
                              ff_error *err)
{
    const double scale = scale_of(t), wanted = ceil(asinh(range->q_hi / scale) / NODE_STEP) + BEYOND;
    const int top = o->nodes ? o->nodes - 1 : (int)fmin(fmax(wanted, FF_NDF_LEAST_TOP), FF_NDF_MOST_TOP);
    unsigned char filled[FF_NDF_MOST_TOP + 1] = {0};
    int n = 0;
    if (p->n * p->n_channels < (size_t)top + 1 + 2 * p->n_channels)
        return ff_error_set(err, FF_ERR_DATA, NULL, 0, -1,
                            "%zu values (%zu samples of %zu channels) cannot determine a distribution at %d angles",
                            p->n * p->n_channels, p->n, p->n_channels, top + 1);
    const double step = asinh(range->q_hi / scale) / (top - BEYOND);
    for (size_t i = 0; i < p->n; i++) {
        const double s2 = ff_problem_plane(p, i / FF_BLOCK, p->geometry[FF_G_S2])[i % FF_BLOCK];
        filled[(int)fmin(asinh(sqrt(s2) / scale) / step, top)] = 1;
    }
    for (int k = 0; k <= top; k++) n += filled[k];
    if (n < LEAST_FILLED)
        return ff_error_set(err, FF_ERR_DATA, NULL, 0, -1,
                            "the half vectors of the samples lie at %d of the %d angles of a distribution, expected at least %d", n,
                            top + 1, LEAST_FILLED);
    if (ff_curve_new(scale, step, top, ff_masking_at(o->masking)->uses_lambda, range->tan_max, out))
        return ff_error_set(err, FF_ERR_MEMORY, NULL, 0, -1, "out of memory");
    return FF_OK;
}

/* ---- the start ------------------------------------------------------------------------------- */

/* Falls of 2 ln (1 + q^2): what D may rise by where the density of slopes must not. */
static void fill_box(ff_ndf_fit *f, ff_ndf_monotone monotone)
{
    const size_t top = (size_t)f->curve->top;
    double rise[FF_NDF_MOST_TOP + 1], *falls = f->work;
    for (size_t k = 0; k <= top; k++) {
        const double q = ff_curve_node(f->curve, (int)k);
        rise[k] = monotone == FF_NDF_MONOTONE_SLOPES ? 2 * log1p(q * q) : 0;
    }
    ff_ndf_falls(f->curve, rise, falls);
    falls[top - 1] = fmax(falls[top - 1], -MOST_RISE * f->curve->step);
    for (size_t k = 0; k < f->P; k++) {
        f->lower[k] = fmin(falls[k], 0);
        f->upper[k] = k < top ? 1e3 : (k - top) % 2 == 0 && f->scaled ? INFINITY : 1;
    }
}

/* Falls of the reference, and a start. */
static ff_status fill_start(const struct ff_problem *p, reference t, const ff_fit_result *from, ff_ndf_fit *f, ff_ndf_result *r)
{
    const ff_curve *curve = f->curve;
    const size_t C = p->n_channels, top = (size_t)curve->top;
    double ln_d[FF_NDF_MOST_TOP + 1], *channel = f->u + top, *kd = f->work;
    for (int k = 0; k <= curve->top; k++) ln_d[k] = reference_ln_d(t, pow(ff_curve_node(curve, k), 2));
    ff_ndf_falls(curve, ln_d, f->reference);
    for (size_t c = 0; c < C; c++) {
        channel[2 * c] = ff_fit_result_find(from, f->scaled ? "ks" : "f0", c)->value;
        kd[c] = channel[2 * c + 1] = ff_fit_result_find(from, "kd", c)->value;
    }
    const ff_status status = ff_ndf_back_scatter(p, curve, kd, f->u, r);
    if (status) return status;
    if (!r->from_back_scatter) memcpy(f->u, f->reference, top * sizeof *f->u);
    for (size_t k = 0; k < f->P; k++) f->u[k] = fmin(fmax(f->u[k], f->lower[k]), f->upper[k]);
    return FF_OK;
}

/* ---- how smooth ------------------------------------------------------------------------------ */

#define SMOOTHEST       1e4
#define ROUGHEST        1e-2
#define NEGLIGIBLE      3e-4 /* a gain less than this is not worth a rougher curve                          */
#define ROUGH_TOLERANCE 1e-5
#define FINE_TOLERANCE  1e-8

/* From smooth to rough, each from the one before; the variances follow the residuals. The best by cross-validation stays in f. */
static ff_status choose_smooth(ff_ndf_fit *f, const struct ff_problem *p, double least_variance)
{
    enum { WORSE = 3 };
    const size_t P = f->P;
    double *best = malloc((2 * P + 1) * sizeof *best), least = INFINITY, smooth = 0;
    ff_outcome outcome;
    int worse = 0;
    ff_status status = best ? ff_ndf_look(f, p) : FF_ERR_MEMORY;
    for (double next = SMOOTHEST; !status && next >= ROUGHEST && (worse < WORSE || next >= 1); next /= sqrt(10)) {
        ff_ndf_variances(f, least_variance);
        f->smooth = next;
        status = ff_ndf_solve(f, p, ROUGH_TOLERANCE, 50, &outcome);
        if (!status) status = ff_ndf_look(f, p);
        if (status) break;
        const double cost2 = ff_ndf_left_out(f);
        worse = cost2 < (1 - NEGLIGIBLE) * least ? 0 : worse + 1;
        if (worse) continue;
        least = cost2;
        smooth = next;
        memcpy(best, f->u, P * sizeof *best);
        memcpy(best + P, f->variance, P * sizeof *best);
    }
    if (!status) {
        f->smooth = smooth;
        memcpy(f->u, best, P * sizeof *best);
        memcpy(f->variance, best + P, P * sizeof *best);
    }
    free(best);
    return status;
}

/* The same way to a given weight. */
static ff_status approach_smooth(ff_ndf_fit *f, const struct ff_problem *p, double least_variance, double wanted)
{
    ff_outcome outcome;
    ff_status status = ff_ndf_look(f, p);
    for (double next = fmax(SMOOTHEST, wanted);; next = fmax(next / 10, wanted)) {
        if (status) return status;
        ff_ndf_variances(f, least_variance);
        f->smooth = next;
        status = ff_ndf_solve(f, p, ROUGH_TOLERANCE, 50, &outcome);
        if (!status) status = ff_ndf_look(f, p);
        if (next <= wanted || next < ROUGHEST * 1e-6) break;
    }
    f->smooth = wanted;
    return status;
}

/* ---- the retrieved distribution as a model --------------------------------------------------- */

static ff_status fit_profile(const struct ff_problem *p, const ff_fit_options *o, ff_model *m, ff_ndf_result *r, ff_error *err)
{
    double *theta = malloc(2 * r->n_rows * sizeof *theta), *d = theta + r->n_rows;
    r->profile = malloc(sizeof *r->profile);
    ff_status status = theta && r->profile ? FF_OK : ff_error_set(err, FF_ERR_MEMORY, NULL, 0, -1, "out of memory");
    for (size_t i = 0; i < r->n_rows && !status; i++) {
        theta[i] = r->row[i].theta;
        d[i] = r->row[i].d;
    }
    if (!status) status = ff_profile_make(FF_PROFILE_D, r->n_rows, theta, d, r->profile, NULL, err);
    free(theta);
    if (status) return status;
    ff_model_set_table(m, r->profile);
    return fit_one(p, m, o, &r->fit[FF_NDF_TABULATED], err);
}

/* ---- the whole ------------------------------------------------------------------------------- */

static double seconds(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static ff_status failed(ff_status status, ff_error *err)
{
    if (status == FF_OK) return FF_OK;
    return ff_error_set(err, status, NULL, 0, -1, status == FF_ERR_CANCELLED ? "cancelled" : "the retrieval failed: %s",
                        ff_status_str(status));
}

/* From the start to the optimum on all samples, with what is said of it. */
static ff_status refine(ff_ndf_fit *f, const struct ff_problem *p, const ff_ndf_options *o, double least_variance, ff_ndf_result *r)
{
    const struct ff_problem *fewer = p->middle ? p->middle : p;
    ff_status status =
        isnan(o->smooth) ? choose_smooth(f, fewer, least_variance) : approach_smooth(f, fewer, least_variance, o->smooth);
    if (!status && fewer != p) {
        status = ff_ndf_look(f, p);
        if (!status) ff_ndf_variances(f, least_variance);
    }
    if (!status) status = ff_ndf_solve(f, p, FINE_TOLERANCE, o->fit->max_iterations, &r->outcome);
    if (!status) status = ff_ndf_look(f, p);
    return status ? status : ff_ndf_rows(f, r);
}

static ff_status retrieve_with(ff_model *models, const struct ff_problem *p, const ff_ndf_options *o, ff_ndf_result *r,
                               ff_error *err)
{
    ff_curve curve = {.top = 0};
    ff_ndf_fit f = {.P = 0};
    ff_status status = fit_parametric(p, o->fit, models, r, err);
    if (!status) status = check_peak(p, o->fit, &models[FF_NDF_FITS], r, err);
    if (status) return status;
    const reference t = reference_of(r);
    const range range = range_of(p);
    const ff_term *masking = ff_term_at(FF_MASKING, (size_t)o->masking);
    r->first = atan(range.q_lo);
    r->reach = atan(range.q_hi);
    status = make_lattice(p, o, t, &range, &curve, err);
    if (status) return status;
    status =
        ff_ndf_fit_new(&curve, o->fit, o->masking, masking->n_params ? masking->params[0].init : 0, r->scaled, p->n_channels, &f);
    if (!status) {
        fill_box(&f, o->monotone);
        status = fill_start(p, t, &r->fit[r->reference], &f, r);
        if (!status) status = refine(&f, p, o, LEAST_VARIANCE * range.mean_square, r);
    }
    status = status ? failed(status, err) : fit_profile(p, o->fit, &models[FF_NDF_TABULATED], r, err);
    if (!status) status = failed(ff_ndf_result_fill(&f, p, o->monotone, r), err);
    ff_ndf_fit_free(&f);
    ff_curve_free(&curve);
    return status;
}

static ff_status retrieve(const struct ff_problem *p, const ff_ndf_options *o, ff_ndf_result *r, ff_error *err)
{
    ff_model *models = malloc(FF_NDF_MODELS * sizeof *models);
    ff_status status = models ? ff_ndf_models(o->masking, models, err) : failed(FF_ERR_MEMORY, err);
    if (!status) status = retrieve_with(models, p, o, r, err);
    free(models);
    return status;
}

ff_status ff_ndf_retrieve_into(const ff_problem *p, const ff_ndf_options *o, ff_ndf_result *out, ff_error *err)
{
    const double began = seconds();
    ff_ndf_result *r = calloc(1, sizeof *r);
    if (!r) return ff_error_set(err, FF_ERR_MEMORY, NULL, 0, -1, "out of memory");
    ff_status status = check_options(p, o, err);
    if (!status) status = retrieve(p, o, r, err);
    if (status) {
        ff_ndf_result_clear(r);
    } else {
        r->time_s = seconds() - began;
        *out = *r;
    }
    free(r);
    return status;
}

void ff_ndf_result_clear(ff_ndf_result *r)
{
    if (!r) return;
    for (int i = 0; i < FF_NDF_FITS; i++) ff_fit_result_clear(&r->fit[i]);
    free(r->row);
    free(r->channel);
    free(r->profile);
    ff_warnings_clear(&r->warnings);
    memset(r, 0, sizeof *r);
}
