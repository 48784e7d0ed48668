/* Distributions without a formula: the curve and its sums against closed forms and differences, known distributions from simulated
 * measurements with and without noise, and what is said of data that do not determine one. */
#include "fit_samples.h"
#include "fit/ndf/ndf_struct.h"
#include "fit/ndf/internal_ndf.h"
#include "warnings.h"

static const double pi = 3.14159265358979323846;

/* ---- surfaces whose D is known --------------------------------------------------------------- */

/* The density of slopes is a sum of student-t's (gamma 2: ggx; infinite: beckmann) with these shares. */
typedef struct known {
    const char *name, *expression, *set;
    double alpha[2], gamma[2], share;
} known;

static double student_t_d(double alpha, double gamma, double theta)
{
    const double q2 = pow(tan(theta) / alpha, 2), p = isinf(gamma) ? exp(-q2) : pow(1 + q2 / (gamma - 1), -gamma);
    return p / (pi * alpha * alpha * pow(cos(theta), 4));
}

static double known_d(const known *k, double theta)
{
    return (1 - k->share) * student_t_d(k->alpha[0], k->gamma[0], theta) +
           (k->share > 0 ? k->share * student_t_d(k->alpha[1], k->gamma[1], theta) : 0);
}

/* Two surfaces are one distribution only with one masking: a mixture goes through a fine table of its D. */
static void known_table(const known *k, ff_profile_table *out)
{
    enum { N = 2000 };
    static double theta[N], d[N];
    for (int i = 0; i < N; i++) {
        theta[i] = atan(0.02 * k->alpha[0] * sinh(i * 12.0 / N));
        d[i] = known_d(k, theta[i]);
    }
    ff_error err = {0};
    if (ff_profile_make(FF_PROFILE_D, N, theta, d, out, NULL, &err)) {
        printf("the test itself is wrong: %s\n", err.message);
        exit(1);
    }
}

static ff_table known_measure(const known *k, const fit_sampling *how, size_t every)
{
    static ff_profile_table table;
    fit_surface s = fit_surface_make(k->expression, 1, k->set);
    if (k->share > 0) {
        known_table(k, &table);
        ff_model_set_table(&s.model, &table);
    }
    ff_table t = fit_measure(&s, how);
    for (size_t i = 0; i < t.n; i++)
        if (i % every) t.valid[i] = 0;
    return t;
}

/* ---- retrievals ------------------------------------------------------------------------------ */

static ff_fit_options fits; /* of the options that were made last */

static ff_ndf_options ndf_options(void)
{
    ff_ndf_options o;
    ff_ndf_options_init(&o);
    ff_fit_options_init(&fits);
    fits.shape = FF_SHAPE_ISOTROPIC;
    fits.threads = 2;
    o.fit = &fits;
    return o;
}

static ff_status retrieve(const ff_table *t, const ff_ndf_options *o, ff_ndf_result *r, ff_error *err)
{
    ff_model models[FF_NDF_MODELS];
    ff_problem *p;
    ff_status status = ff_ndf_models(o->masking, models, err);
    if (!status) status = ff_problem_make(t, models, FF_NDF_MODELS, o->fit, &p, err);
    if (status) return status;
    status = ff_ndf_retrieve_into(p, o, r, err);
    ff_problem_free(p);
    return status;
}

/* Largest relative error of D between the first and the last half vector, where D is above `floor` of its peak. */
static double worst_error_to(const known *k, const ff_ndf_result *r, double floor, double reach)
{
    double worst = 0;
    for (size_t i = 0; i < r->n_rows; i++) {
        const double d = known_d(k, r->row[i].theta);
        if (r->row[i].theta < r->first || r->row[i].theta > reach || d < floor * known_d(k, 0)) continue;
        worst = fmax(worst, fabs(r->row[i].d / d - 1));
    }
    return worst;
}

static double worst_error(const known *k, const ff_ndf_result *r, double floor)
{
    return worst_error_to(k, r, floor, r->reach);
}

/* What noise moves D by in some measurement is told by its error: the largest by which D is off beyond five of them. */
static double worst_beyond_errors(const known *k, const ff_ndf_result *r, double floor)
{
    const double scale = isnan(r->channel[0].scale_error) ? 0 : r->channel[0].scale_error / r->channel[0].f0;
    double worst = 0;
    for (size_t i = 0; i < r->n_rows; i++) {
        const double d = known_d(k, r->row[i].theta), off = fabs(r->row[i].d / d - 1);
        if (r->row[i].theta < r->first || r->row[i].theta > r->reach || d < floor * known_d(k, 0)) continue;
        if (off > 5 * hypot(r->row[i].error, scale)) worst = fmax(worst, off);
    }
    return worst;
}

static int rises(const ff_ndf_result *r)
{
    for (size_t i = 1; i < r->n_rows; i++)
        if (r->row[i].d > r->row[i - 1].d * (1 + 1e-9)) return 1;
    return 0;
}

/* The lattice that the rows were made on, four of them from a node to the next: nodes at tan = scale sinh(k step). */
static ff_curve lattice_of(const ff_ndf_result *r)
{
    const double q1 = tan(r->row[4].theta), step = acosh(tan(r->row[8].theta) / (2 * q1));
    ff_curve curve;
    if (ff_curve_new(q1 / sinh(step), step, (int)r->n_nodes - 1, 0, 1, &curve)) exit(1);
    return curve;
}

/* Does the density of slopes D cos^4 rise? The fit holds the coefficients of ln D below those of the cubic through 2 ln(1 + q^2) at
 * the nodes, q the slope, so that ln D minus that cubic falls between the nodes as at them. D itself may rise. */
static int slopes_rise(const ff_ndf_result *r)
{
    ff_curve curve = lattice_of(r);
    double value[FF_NDF_MOST_TOP + 1], c[FF_NDF_MOST_TOP + 1], before = INFINITY;
    int up = 0;
    for (int k = 0; k <= curve.top; k++) value[k] = 2 * log1p(pow(ff_curve_node(&curve, k), 2));
    ff_curve_interpolate(&curve, value, c);
    for (size_t i = 0; i + 1 < r->n_rows; i++) { /* the last row repeats what is at the end of the curve */
        const ff_stencil s = ff_curve_stencil(&curve, tan(r->row[i].theta));
        const double ln_p = log(r->row[i].d) - ff_stencil_apply(&s, c);
        up |= ln_p > before + 1e-9;
        before = ln_p;
    }
    ff_curve_free(&curve);
    return up;
}

/* What holds for every retrieval: the table is the curve, D has the area 1, the density of slopes does not rise. */
static void check_whole(const char *what, const ff_ndf_result *r)
{
    double area = 0;
    for (size_t i = 1; i < r->n_rows; i++) {
        const ff_ndf_row *a = &r->row[i - 1], *b = &r->row[i];
        area += 0.5 * pi * (a->d + b->d) * (pow(sin(b->theta), 2) - pow(sin(a->theta), 2));
    }
    FF_CHECK(r->outcome == FF_CONVERGED, "%s: %s", what, ff_outcome_name((int)r->outcome));
    FF_CHECK(fabs(area - 1) < 5e-3, "%s: the area is %.6f", what, area);
    FF_CHECK(!slopes_rise(r), "%s: the density of slopes rises", what);
    FF_CHECK_CLOSE(r->fit[FF_NDF_TABULATED].residual.objective, r->objective, 2e-4, 1e-6);
}

/* ---- the curve ------------------------------------------------------------------------------- */

/* The curve of ggx: its area and its Lambda, (sqrt(1 + alpha^2 tan^2) - 1) / 2, and what stencils make of nodes. */
static void area_and_lambda(void)
{
    static const double alphas[] = {0.05, 0.3, 0.9};
    for (size_t i = 0; i < 3; i++) {
        const double alpha = alphas[i], scale = alpha / 4;
        double ln_d[FF_NDF_MOST_TOP + 1];
        ff_curve curve;
        ff_curve_state state;
        const double tan_max = tan(85 * FIT_DEGREE), step = asinh(tan(89 * FIT_DEGREE) / scale) / 60;
        if (ff_curve_new(scale, step, 60, 1, tan_max, &curve) || ff_curve_state_new(&curve, &state)) exit(1);
        for (int k = 0; k <= curve.top; k++) ln_d[k] = log(student_t_d(alpha, 2, atan(ff_curve_node(&curve, k))));
        ff_curve_interpolate(&curve, ln_d, state.c);
        ff_curve_evaluate(&curve, &state);
        FF_CHECK_CLOSE(state.area, 1, 1e-4, 0);
        for (int j = 0; j < curve.n_lambda; j++) {
            const double t = sinh(j * curve.lambda_step), v = alpha * alpha * t * t;
            FF_CHECK_CLOSE(state.lambda[j], 0.5 * (sqrt(1 + v) - 1), 1e-4, 1e-6);
        }
        for (int k = 0; k <= 4 * curve.top; k++) {
            const double q = scale * sinh(0.25 * k * step);
            FF_CHECK_CLOSE(ff_curve_ln_d(&curve, &state, q), log(student_t_d(alpha, 2, atan(q)) / state.area), 0, 1e-3);
        }
        ff_curve_state_free(&state);
        ff_curve_free(&curve);
    }
}

/* ---- sums over the samples ------------------------------------------------------------------- */

/* A curve that is none of the models, and samples of two channels that are it, with noise or without. */
typedef struct bench {
    ff_problem *p;
    ff_curve curve;
    ff_ndf_fit f;
    ff_fit_options o;
} bench;

enum { BENCH_TOP = 30 };

/* The curve as a surface: the table of its D under a masking; scaled: F = ks. */
static fit_surface bench_surface(const ff_ndf_fit *f, const char *masking, ff_profile_table *table)
{
    enum { N = 1500 };
    static double theta[N], d[N];
    char expression[128], set[128];
    const double *channel = f->u + BENCH_TOP;
    ff_curve_state state;
    if (ff_curve_state_new(f->curve, &state)) exit(1);
    state.c[0] = 0;
    for (int k = 0; k < BENCH_TOP; k++) state.c[k + 1] = state.c[k] - f->u[k];
    ff_curve_evaluate(f->curve, &state);
    for (int i = 0; i < N; i++) {
        const double q = f->curve->scale * sinh(f->curve->end * f->curve->step * i / (N - 2));
        theta[i] = i + 1 < N ? atan(q) : 89.8 * FIT_DEGREE;
        d[i] = exp(ff_curve_ln_d(f->curve, &state, q));
    }
    ff_curve_state_free(&state);
    snprintf(expression, sizeof expression, "tabulated/%s/%s+lambert", masking, f->scaled ? "none" : "schlick");
    snprintf(set, sizeof set, "%s=%.17g:%.17g kd=%.17g:%.17g", f->scaled ? "ks" : "f0", channel[0], channel[2], channel[1],
             channel[3]);
    fit_surface s = fit_surface_make(expression, 2, set);
    if (ff_profile_make(FF_PROFILE_D, N, theta, d, table, NULL, NULL)) exit(1);
    ff_model_set_table(&s.model, table);
    return s;
}

static void bench_open(bench *b, const char *masking, ff_loss loss, int scaled, double noise)
{
    static ff_profile_table profile;
    static const double channel[4] = {0.5, 0.12, 0.35, 0.15};
    const int term = ff_term_find(FF_MASKING, masking);
    const ff_masking *m = ff_masking_at(term);
    ff_model models[FF_NDF_MODELS];
    ff_fit_options_init(&b->o);
    b->o.shape = FF_SHAPE_ISOTROPIC;
    b->o.loss = loss;
    b->o.threads = 1;
    if (ff_ndf_models(term, models, NULL) ||
        ff_curve_new(0.07, asinh(6 / 0.07) / BENCH_TOP, BENCH_TOP, m->uses_lambda, tan(80 * FIT_DEGREE), &b->curve) ||
        ff_ndf_fit_new(&b->curve, &b->o, term, m->term.n_params ? m->term.params[0].init : 0, scaled, 2, &b->f))
        exit(1);
    for (size_t k = 0; k < b->f.P; k++) b->f.lower[k] = -1e9, b->f.upper[k] = 1e9;
    for (int k = 0; k < BENCH_TOP; k++) {
        const double d0 = student_t_d(0.3, 2.3, atan(ff_curve_node(&b->curve, k))),
                     d1 = student_t_d(0.3, 2.3, atan(ff_curve_node(&b->curve, k + 1)));
        b->f.u[k] = log(d0 / d1) + 0.05 * cos(k);
        b->f.reference[k] = log(d0 / d1);
        b->f.variance[k] = 0.1 + 0.01 * k;
    }
    memcpy(b->f.u + BENCH_TOP, channel, sizeof channel);
    const fit_surface s = bench_surface(&b->f, masking, &profile);
    const fit_sampling how = {.n = 700, .max_theta = 80, .glossy = 0.5, .noise = noise, .seed = 3};
    ff_table t = fit_measure(&s, &how);
    if (ff_problem_make(&t, models, FF_NDF_MODELS, &b->o, &b->p, NULL)) exit(1);
    ff_table_clear(&t);
}

static void bench_close(bench *b)
{
    ff_ndf_fit_free(&b->f);
    ff_curve_free(&b->curve);
    ff_problem_free(b->p);
}

/* The objective at u + h d. */
static double objective_along(bench *b, const double *d, double h)
{
    double u[64];
    memcpy(u, b->f.u, b->f.P * sizeof *u);
    for (size_t k = 0; k < b->f.P; k++) b->f.u[k] += h * d[k];
    if (ff_ndf_look(&b->f, b->p)) exit(1);
    const double v = 0.5 * (b->f.sums.cost2 + ff_ndf_penalty2(&b->f));
    memcpy(b->f.u, u, b->f.P * sizeof *u);
    return v;
}

/* The gradient of the objective against differences of fourth order, by every parameter. */
static void check_gradient(const char *masking, ff_loss loss, int scaled)
{
    bench b;
    bench_open(&b, masking, loss, scaled, 0.3);
    b.f.smooth = 0.02;
    double d[64] = {0}, g[64], worst = 0;
    const double whole = objective_along(&b, d, 0), h = 1e-3;
    memcpy(g, b.f.g, b.f.P * sizeof *g);
    for (size_t k = 0; k < b.f.P; k++) {
        memset(d, 0, sizeof d);
        d[k] = 1;
        const double near = objective_along(&b, d, h) - objective_along(&b, d, -h),
                     far = objective_along(&b, d, 2 * h) - objective_along(&b, d, -2 * h);
        worst = fmax(worst, fabs((8 * near - far) / (12 * h) - g[k]) / (fabs(g[k]) + 1e-5 * whole));
    }
    FF_CHECK(worst < 1e-5, "%s, %s, scaled %d: the gradient is off by %.2g", masking, ff_loss_name((int)loss), scaled, worst);
    bench_close(&b);
}

static void gradients(void)
{
    for (size_t i = 0; i < ff_term_count(FF_MASKING); i++)
        if (!ff_masking_at((int)i)->only) check_gradient(ff_term_at(FF_MASKING, i)->name, FF_LOSS_COSINE, 0);
    for (int loss = 0; loss < FF_LOSS_COUNT; loss++) check_gradient("smith-separable", (ff_loss)loss, loss % 2);
}

/* At data that are the curve nothing is left, and the second derivative of the objective is that of Gauss and Newton. */
static void check_exact(const char *masking, int scaled)
{
    bench b;
    uint64_t state = ff_test_stream("exact %s %d", masking, scaled);
    double zero[64] = {0}, d[64], gram = 0, data = 0;
    const double h = 2e-3;
    bench_open(&b, masking, FF_LOSS_COSINE, scaled, 0);
    for (size_t i = 0; i < b.p->n; i++)
        for (int c = 0; c < 2; c++)
            data += pow(ff_problem_plane(b.p, i / FF_BLOCK, b.p->weight)[i % FF_BLOCK] *
                            ff_problem_plane(b.p, i / FF_BLOCK, b.p->target + c)[i % FF_BLOCK],
                        2);
    for (int turn = 0; turn < 4; turn++) {
        for (size_t k = 0; k < b.f.P; k++) d[k] = fit_normal(&state) * (k < BENCH_TOP ? 1 : 0.3);
        const double bend = objective_along(&b, d, h) + objective_along(&b, d, -h), here = objective_along(&b, zero, 0);
        FF_CHECK(2 * here < 1e-9 * data, "%s, scaled %d: %.2g of the data is left", masking, scaled, 2 * here / data);
        gram = 0;
        for (size_t i = 0; i < b.f.P; i++)
            for (size_t j = 0; j < b.f.P; j++) gram += d[i] * b.f.H[i * b.f.P + j] * d[j];
        FF_CHECK_CLOSE((bend - 2 * here) / (h * h), gram, 2e-3, 0);
    }
    bench_close(&b);
}

static void values_and_second_derivatives(void)
{
    for (size_t i = 0; i < ff_term_count(FF_MASKING); i++)
        if (!ff_masking_at((int)i)->only) check_exact(ff_term_at(FF_MASKING, i)->name, 0);
    check_exact("smith-height-correlated", 1);
}

/* ---- known distributions --------------------------------------------------------------------- */

typedef struct margin {
    double exact, noisy; /* of D where it is above 1e-3 of its peak */
} margin;

/* Noise may turn the tail of D upwards, where no half vector is: not when asked to keep it level. */
static void check_level(const char *what, const ff_table *t)
{
    ff_ndf_options o = ndf_options();
    ff_ndf_result r;
    ff_error err = {0};
    o.monotone = FF_NDF_MONOTONE_D;
    if (!FF_CHECK(retrieve(t, &o, &r, &err) == FF_OK, "%s: %s", what, err.message)) return;
    FF_CHECK(!rises(&r), "%s: D rises", what);
    ff_ndf_result_clear(&r);
}

/* Scattered samples, and a part of a MERL grid. */
static void check_known(const known *k, margin scattered, margin grid)
{
    for (int on_grid = 0; on_grid < 2; on_grid++)
        for (int noisy = 0; noisy < 2; noisy++) {
            const fit_sampling how = {.n = 12000,
                                      .max_theta = 80,
                                      .glossy = 0.5,
                                      .noise = noisy ? 0.02 : 0,
                                      .seed = 7,
                                      .grid = on_grid ? &ff_grid_merl : NULL};
            const ff_ndf_options o = ndf_options();
            const margin m = on_grid ? grid : scattered;
            char what[80];
            ff_error err = {0};
            ff_ndf_result r;
            ff_table t = known_measure(k, &how, on_grid ? 67 : 1);
            snprintf(what, sizeof what, "%s, %s, %s", k->name, on_grid ? "grid" : "scattered", noisy ? "2 % noise" : "exact");
            const ff_status status = retrieve(&t, &o, &r, &err);
            FF_CHECK(status == FF_OK, "%s: %s", what, err.message);
            if (noisy) check_level(what, &t);
            ff_table_clear(&t);
            if (status) continue;
            const double worst = worst_error(k, &r, 1e-3), allowed = noisy ? m.noisy : m.exact;
            double best = INFINITY;
            for (int i = 0; i <= FF_NDF_STUDENT_T; i++) best = fmin(best, r.fit[i].residual.objective);
            if (getenv("FF_NDF_SHOW"))
                printf("  %-40s D %.2g  f0 %.5f +- %.2g  kd %.5f +- %.2g  objective %.4g, parametric %.4g\n", what, worst,
                       r.channel[0].f0, r.channel[0].scale_error, r.channel[0].kd, r.channel[0].kd_error, r.objective, best);
            check_whole(what, &r);
            FF_CHECK(noisy || !rises(&r), "%s: D rises, that of the surface does not", what);
            FF_CHECK(worst < allowed || (noisy && worst_beyond_errors(k, &r, 1e-3) < allowed), "%s: D is off by %.2g", what, worst);
            FF_CHECK_CLOSE(r.channel[0].f0, 0.6, noisy ? 0.015 : 2e-4, 0);
            FF_CHECK_CLOSE(r.channel[0].kd, 0.1, 0, noisy ? 0.01 : 2e-4);
            FF_CHECK(r.objective < best * 1.001 + (noisy ? 0 : 1e-5), "%s: objective %.6g, the best fit has %.6g", what,
                     r.objective, best);
            FF_CHECK(r.from_back_scatter && r.back_samples >= 12, "%s: %zu samples look back", what, r.back_samples);
            FF_CHECK(!noisy || fabs(r.channel[0].f0 - 0.6) < 5 * r.channel[0].scale_error, "%s: f0 %.4f +- %.2g", what,
                     r.channel[0].f0, r.channel[0].scale_error);
            ff_ndf_result_clear(&r);
        }
}

static const known ggx = {"ggx", "ggx+lambert", "alpha=0.2 f0=0.6 kd=0.1", {0.2}, {2}, 0};
static const known beckmann = {"beckmann", "beckmann+lambert", "alpha=0.25 f0=0.6 kd=0.1", {0.25}, {INFINITY}, 0};
static const known student_t = {"student-t", "student-t+lambert", "alpha=0.15 gamma=2.5 f0=0.6 kd=0.1", {0.15}, {2.5}, 0};
static const known mixture = {"mixture", "tabulated+lambert", "f0=0.6 kd=0.1", {0.08, 0.4}, {2, 2}, 0.5};

static void ggx_comes_back(void)
{
    check_known(&ggx, (margin){0.005, 0.05}, (margin){0.005, 0.05});
}

static void beckmann_comes_back(void)
{
    check_known(&beckmann, (margin){0.005, 0.05}, (margin){0.005, 0.05});
}

static void student_t_comes_back(void)
{
    check_known(&student_t, (margin){0.005, 0.05}, (margin){0.005, 0.05});
}

static void mixture_comes_back(void)
{
    check_known(&mixture, (margin){0.005, 0.1}, (margin){0.005, 0.05});
}

/* ---- errors ---------------------------------------------------------------------------------- */

/* Over several measurements of the same surface the errors are what the result is off by. */
static void errors_are_as_said(void)
{
    enum { MEASUREMENTS = 8 };
    double d2 = 0, f02 = 0, kd2 = 0;
    int n = 0;
    for (int i = 0; i < MEASUREMENTS; i++) {
        const fit_sampling how = {.noise = 0.02, .seed = 100 + (uint64_t)i, .grid = &ff_grid_merl};
        const ff_ndf_options o = ndf_options();
        ff_table t = known_measure(&mixture, &how, 67);
        ff_ndf_result r;
        ff_error err = {0};
        FF_CHECK(retrieve(&t, &o, &r, &err) == FF_OK, "%s", err.message);
        f02 += pow((r.channel[0].f0 - 0.6) / r.channel[0].scale_error, 2);
        kd2 += pow((r.channel[0].kd - 0.1) / r.channel[0].kd_error, 2);
        for (size_t k = 0; k < r.n_rows && r.row[k].theta < 60 * FIT_DEGREE; k += 4, n++) /* at the nodes */
            d2 += pow(log(r.row[k].d * r.channel[0].f0 / (0.6 * known_d(&mixture, r.row[k].theta))) / r.row[k].error, 2);
        ff_ndf_result_clear(&r);
        ff_table_clear(&t);
    }
    const double d = sqrt(d2 / n), f0 = sqrt(f02 / MEASUREMENTS), kd = sqrt(kd2 / MEASUREMENTS);
    FF_CHECK(d > 0.6 && d < 1.6, "D is off by %.2f of its errors", d);
    FF_CHECK(f0 > 0.4 && f0 < 2 && kd > 0.4 && kd < 2, "f0 is off by %.2f, kd by %.2f of their errors", f0, kd);
}

static double error_at_degrees(const ff_ndf_result *r, double degrees)
{
    size_t i = 0;
    while (i + 1 < r->n_rows && r->row[i].theta < degrees * FIT_DEGREE) i++;
    return r->row[i].error;
}

/* Half vectors of 12 to 40 degrees are missing from data without noise, and the masking knows nothing of D: D is what the
 * smoothness makes of it there, and its error says so. */
static void errors_grow_in_a_gap(void)
{
    known k = mixture;
    k.expression = "tabulated/v-cavity+lambert";
    const fit_sampling how = {.n = 12000, .max_theta = 80, .glossy = 0.5, .seed = 6};
    ff_table t = known_measure(&k, &how, 1);
    double *planes[6], *w = malloc(6 * t.n * sizeof *w);
    for (size_t i = 0; i < 6; i++) planes[i] = w + i * t.n;
    ff_table_directions(&t, 0, t.n, planes);
    for (size_t i = 0; i < t.n; i++) {
        const double x = planes[0][i] + planes[3][i], y = planes[1][i] + planes[4][i], z = planes[2][i] + planes[5][i];
        const double theta = atan(hypot(x, y) / z) / FIT_DEGREE;
        t.valid[i] = theta < 12 || theta > 40;
    }
    free(w);
    ff_ndf_options o = ndf_options();
    o.smooth = 0.1;
    o.masking = ff_term_find(FF_MASKING, "v-cavity");
    ff_ndf_result r;
    ff_error err = {0};
    FF_CHECK(retrieve(&t, &o, &r, &err) == FF_OK, "%s", err.message);
    FF_CHECK(error_at_degrees(&r, 5) < 1e-3 && error_at_degrees(&r, 60) < 1e-3, "errors %.2g and %.2g beside the gap",
             error_at_degrees(&r, 5), error_at_degrees(&r, 60));
    FF_CHECK(error_at_degrees(&r, 22) > 0.02, "the error in the gap is %.2g", error_at_degrees(&r, 22));
    ff_ndf_result_clear(&r);
    ff_table_clear(&t);
}

/* ---- what D must not do ---------------------------------------------------------------------- */

/* The tails of this student-t make D rise towards grazing: one retrieval keeps it level, the other follows. */
static void rising_tails(void)
{
    const fit_surface s = fit_surface_make("student-t+lambert", 1, "alpha=0.2 gamma=1.6 f0=0.6 kd=0.1");
    const fit_sampling how = {.n = 12000, .max_theta = 80, .glossy = 0.3, .seed = 2};
    ff_table t = fit_measure(&s, &how);
    ff_ndf_result level = {0}, free = {0};
    ff_error err = {0};
    ff_ndf_options o = ndf_options();
    FF_CHECK(retrieve(&t, &o, &free, &err) == FF_OK, "%s", err.message);
    o.monotone = FF_NDF_MONOTONE_D;
    FF_CHECK(retrieve(&t, &o, &level, &err) == FF_OK, "%s", err.message);
    FF_CHECK(!rises(&level) && count_warnings(&level.warnings, FF_WARNING_D_KEPT_LEVEL),
             "D rises, or nobody is told that it would");
    FF_CHECK(rises(&free), "D does not rise");
    FF_CHECK(free.objective < 1e-3 * level.objective, "objectives %g and %g", free.objective, level.objective);
    for (size_t i = 0; i < free.n_rows && free.row[i].theta < 70 * FIT_DEGREE; i++)
        FF_CHECK_CLOSE(free.row[i].d, student_t_d(0.2, 1.6, free.row[i].theta), 0.03, 0);
    ff_ndf_result_clear(&level);
    ff_ndf_result_clear(&free);
    ff_table_clear(&t);
}

/* ---- starts ---------------------------------------------------------------------------------- */

/* With G1 alone the equation of the power iteration holds exactly: its D and its F0 are the surface's, up to the lattice. */
static void power_iteration(void)
{
    const known k = {"", "ggx/smith-masking-only+lambert", "alpha=0.3 f0=0.7 kd=0.2", {0.3}, {2}, 0};
    const fit_sampling how = {.grid = &ff_grid_merl};
    const int masking = ff_term_find(FF_MASKING, "smith-masking-only");
    const ff_ndf_options o = ndf_options();
    ff_table t = known_measure(&k, &how, 1);
    ff_model models[FF_NDF_MODELS];
    ff_problem *p;
    ff_curve curve;
    ff_ndf_result r = {0};
    double falls[FF_NDF_MOST_TOP + 1], ln_d = 0;
    const double scale = 0.075, kd = 0.2;
    if (ff_ndf_models(masking, models, NULL) || ff_problem_make(&t, models, FF_NDF_MODELS, o.fit, &p, NULL) ||
        ff_curve_new(scale, asinh(tan(79 * FIT_DEGREE) / scale) / 40, 40, 1, 5, &curve))
        exit(1);
    FF_CHECK(ff_ndf_back_scatter(p, &curve, &kd, falls, &r) == FF_OK && r.from_back_scatter, "%zu samples look back",
             r.back_samples);
    FF_CHECK_CLOSE(r.back_f0, 0.7, 0.03, 0);
    const double peak = student_t_d(0.3, 2, 0);
    for (int i = 1; i <= 36; i++) {
        const double theta = atan(ff_curve_node(&curve, i));
        ln_d -= falls[i - 1];
        if (student_t_d(0.3, 2, theta) > 0.01 * peak) FF_CHECK_CLOSE(ln_d, log(student_t_d(0.3, 2, theta) / peak), 0, 0.06);
    }
    ff_curve_free(&curve);
    ff_problem_free(p);
    ff_table_clear(&t);
}

/* Without samples that look back it says so and starts from a parametric fit; the result is the same surface. */
static void no_back_scatter(void)
{
    const fit_sampling how = {.n = 8000, .max_theta = 75, .glossy = 0.5, .seed = 4};
    ff_table t = known_measure(&ggx, &how, 1);
    double *planes[6], *w = malloc(6 * t.n * sizeof *w);
    for (size_t i = 0; i < 6; i++) planes[i] = w + i * t.n;
    ff_table_directions(&t, 0, t.n, planes);
    for (size_t i = 0; i < t.n; i++)
        t.valid[i] = planes[0][i] * planes[3][i] + planes[1][i] * planes[4][i] + planes[2][i] * planes[5][i] < 0.9;
    free(w);
    const ff_ndf_options o = ndf_options();
    ff_ndf_result r;
    ff_error err = {0};
    FF_CHECK(retrieve(&t, &o, &r, &err) == FF_OK, "%s", err.message);
    FF_CHECK(!r.from_back_scatter && count_warnings(&r.warnings, FF_WARNING_PARAMETRIC_START) == 1, "start %d",
             r.from_back_scatter);
    FF_CHECK(worst_error(&ggx, &r, 1e-3) < 0.005, "D is off by %.2g", worst_error(&ggx, &r, 1e-3));
    check_whole("no back-scatter", &r);
    ff_ndf_result_clear(&r);
    ff_table_clear(&t);
}

/* ---- units, weights, options ----------------------------------------------------------------- */

/* Data in a unit of their own: the scale is said as ks. */
static void scale_of_the_data(void)
{
    known k = ggx;
    k.expression = "ggx/smith-height-correlated/none";
    k.set = "alpha=0.2 ks=25";
    const fit_sampling how = {.n = 8000, .max_theta = 75, .glossy = 0.5, .noise = 0.01, .seed = 4};
    ff_table t = known_measure(&k, &how, 1);
    const ff_ndf_options o = ndf_options();
    ff_ndf_result r;
    ff_error err = {0};
    FF_CHECK(retrieve(&t, &o, &r, &err) == FF_OK, "%s", err.message);
    FF_CHECK(r.scaled && r.channel[0].f0 == 1, "scaled %d, f0 %g", r.scaled, r.channel[0].f0);
    FF_CHECK_CLOSE(r.channel[0].ks, 25, 0.01, 0);
    FF_CHECK(worst_error(&k, &r, 1e-2) < 0.03, "D is off by %.2g", worst_error(&k, &r, 1e-2));
    check_whole("scaled", &r);
    ff_ndf_result_clear(&r);
    ff_table_clear(&t);
}

/* Directions down to the horizon, beyond the last at which Lambda is integrated. */
static void to_the_horizon(void)
{
    const fit_sampling how = {.n = 12000, .max_theta = 89.99, .glossy = 0.5, .seed = 4};
    ff_table t = known_measure(&ggx, &how, 1);
    ff_ndf_options o = ndf_options();
    ff_ndf_result r;
    ff_error err = {0};
    fits.max_theta = 90 * FIT_DEGREE;
    o.monotone = FF_NDF_MONOTONE_D;
    FF_CHECK(retrieve(&t, &o, &r, &err) == FF_OK, "%s", err.message);
    /* of the half vectors one in 250 lies beyond 85 degrees, and the last nodes have a few samples each */
    FF_CHECK(worst_error_to(&ggx, &r, 1e-3, 80 * FIT_DEGREE) < 0.005, "D is off by %.2g up to 80 degrees",
             worst_error_to(&ggx, &r, 1e-3, 80 * FIT_DEGREE));
    FF_CHECK(worst_error(&ggx, &r, 1e-3) < 0.03, "D is off by %.2g", worst_error(&ggx, &r, 1e-3));
    FF_CHECK(r.objective < 1e-5 * r.fit[FF_NDF_BECKMANN].residual.objective, "objective %g", r.objective);
    FF_CHECK(r.outcome == FF_CONVERGED && !rises(&r), "%s", ff_outcome_name((int)r.outcome));
    ff_ndf_result_clear(&r);
    ff_table_clear(&t);
}

static void smoothness_as_asked(void)
{
    const fit_sampling how = {.n = 6000, .max_theta = 80, .glossy = 0.5, .noise = 0.02, .seed = 9};
    ff_table t = known_measure(&mixture, &how, 1);
    double before = INFINITY, objective = 0;
    static const double weights[] = {0, 1, 1e3, 1e6};
    for (size_t i = 0; i < 4; i++) {
        ff_ndf_options o = ndf_options();
        ff_ndf_result r;
        ff_error err = {0};
        o.smooth = weights[i];
        o.nodes = 40;
        FF_CHECK(retrieve(&t, &o, &r, &err) == FF_OK, "%s", err.message);
        FF_CHECK(r.smooth == weights[i] && r.n_nodes == 40, "smooth %g, %zu nodes", r.smooth, r.n_nodes);
        FF_CHECK(r.effective < before && r.objective > objective, "smooth %g: %g effective parameters, objective %g", r.smooth,
                 r.effective, r.objective);
        before = r.effective;
        objective = r.objective;
        ff_ndf_result_clear(&r);
    }
    ff_table_clear(&t);
}

static void same_for_every_number_of_threads(void)
{
    const fit_sampling how = {.n = 12000, .max_theta = 80, .glossy = 0.5, .noise = 0.02, .seed = 11};
    ff_table t = known_measure(&mixture, &how, 1);
    ff_ndf_result first = {0}, r;
    for (int threads = 1; threads <= 3; threads++) {
        ff_ndf_options o = ndf_options();
        ff_error err = {0};
        fits.threads = threads;
        FF_CHECK(retrieve(&t, &o, threads > 1 ? &r : &first, &err) == FF_OK, "%s", err.message);
        if (threads == 1) continue;
        FF_CHECK(r.n_rows == first.n_rows && !memcmp(r.row, first.row, r.n_rows * sizeof *r.row) && r.passes == first.passes,
                 "another result with %d threads", threads);
        ff_ndf_result_clear(&r);
    }
    for (int isa = FF_ISA_SCALAR; isa <= FF_ISA_AVX512; isa++) {
        ff_ndf_options o = ndf_options();
        ff_error err = {0};
        if (!ff_isa_available((ff_isa)isa)) continue;
        fits.isa = (ff_isa)isa;
        FF_CHECK(retrieve(&t, &o, &r, &err) == FF_OK, "%s", err.message);
        FF_CHECK_CLOSE(r.objective, first.objective, 1e-6, 0);
        for (size_t i = 0; i < r.n_rows && r.row[i].theta < r.reach; i++) FF_CHECK_CLOSE(r.row[i].d, first.row[i].d, 1e-3, 0);
        ff_ndf_result_clear(&r);
    }
    ff_ndf_result_clear(&first);
    ff_table_clear(&t);
}

/* ---- data that determine nothing ------------------------------------------------------------- */

static void check_refused(const char *what, ff_table *t, const ff_ndf_options *o, ff_status expected, const char *words)
{
    ff_ndf_result r;
    ff_error err = {0};
    const ff_status status = retrieve(t, o, &r, &err);
    FF_CHECK(status == expected && strstr(err.message, words), "%s: status %d, '%s'", what, (int)status, err.message);
    if (status == FF_OK) ff_ndf_result_clear(&r);
    ff_table_clear(t);
}

static ff_table measured(const char *expression, const char *set, size_t n, double noise)
{
    const fit_surface s = fit_surface_make(expression, 1, set);
    const fit_sampling how = {.n = n, .max_theta = 80, .noise = noise, .seed = 1};
    return fit_measure(&s, &how);
}

static void bad_data(void)
{
    ff_ndf_options o = ndf_options();
    ff_table t = measured("lambert", "kd=0.4", 2000, 0.02);
    check_refused("diffuse", &t, &o, FF_ERR_DATA, "no specular peak");
    t = measured("lambert", "kd=0.4", 2000, 0);
    check_refused("diffuse, exact", &t, &o, FF_ERR_DATA, "no specular peak");
    t = measured("ggx+lambert", "alpha=0.3 kd=0.1", 20, 0);
    check_refused("twenty samples", &t, &o, FF_ERR_DATA, "cannot determine");
    t = measured("ggx+lambert", "alpha=0.3 kd=0.1", 500, 0.01);
    for (size_t i = 0; i < t.n; i++) {
        static const double one[4] = {0.5, 0, 0.7, 3};
        for (int k = 0; k < 4; k++) t.angle[k][i] = one[k];
        t.value[i] = i % 2 ? 1 : 1.1;
    }
    t.value[0] = 40;
    check_refused("one pair of directions", &t, &o, FF_ERR_DATA, "");
    t = measured("ggx+lambert", "alpha=0.3 kd=0.1", 500, 0);
    memset(t.value, 0, t.n * sizeof *t.value);
    check_refused("zeros", &t, &o, FF_ERR_DATA, "no specular peak");
    t = measured("ggx+lambert", "alpha=0.3 kd=0.1", 500, 0);
    fits.robust = FF_ROBUST_HUBER;
    check_refused("a robust loss", &t, &o, FF_ERR_UNSUPPORTED, "robust");
    o = ndf_options();
    t = measured("ggx+lambert", "alpha=0.3 kd=0.1", 500, 0);
    o.nodes = 7;
    check_refused("seven nodes", &t, &o, FF_ERR_RANGE, "nodes");
    o = ndf_options();
    t = measured("ggx+lambert", "alpha=0.3 kd=0.1", 500, 0);
    fits.shape = FF_SHAPE_CORRELATED;
    check_refused("a problem of another shape", &t, &o, FF_ERR_UNSUPPORTED, "isotropic shape");
    o = ndf_options();
    t = measured("ggx+lambert", "alpha=0.3 kd=0.1", 5000, 0);
    const int stop = 1;
    fits.cancel = &stop;
    check_refused("cancelled", &t, &o, FF_ERR_CANCELLED, "cancelled");
    ff_model models[FF_NDF_MODELS];
    FF_CHECK(ff_ndf_models(ff_term_find(FF_MASKING, "hammon"), models, NULL) == FF_ERR_UNSUPPORTED, "a masking for ggx alone");
}

FF_TEST_MAIN(FF_TEST(area_and_lambda), FF_TEST(gradients), FF_TEST(values_and_second_derivatives), FF_TEST(ggx_comes_back),
             FF_TEST(beckmann_comes_back), FF_TEST(student_t_comes_back), FF_TEST(mixture_comes_back), FF_TEST(errors_are_as_said),
             FF_TEST(errors_grow_in_a_gap), FF_TEST(rising_tails), FF_TEST(power_iteration), FF_TEST(no_back_scatter),
             FF_TEST(scale_of_the_data), FF_TEST(to_the_horizon), FF_TEST(smoothness_as_asked),
             FF_TEST(same_for_every_number_of_threads), FF_TEST(bad_data))
