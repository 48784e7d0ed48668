/* How far a fit can be trusted: intervals, neighbours whose errors go together, resampling, comparison of models, outliers, values
 * that are known from one side. */
#include "scan_samples.h"
#include "data_formats/interpolation/resample_struct.h"
#include "fit/trust/trust_struct.h"
#include "base/internal_statistics.h"
#include "warnings.h"

/* ---- a measurement with its problem and one fit ---------------------------------------------- */

typedef struct measured {
    ff_table t;
    ff_problem *p;
    ff_places places;
    ff_fit_options o;
    ff_fit_result fit;
} measured;

static int measure(const char *what, ff_table t, const ff_model *m, const ff_fit_options *o, measured *out)
{
    ff_error err = {0};
    *out = (measured){.t = t, .o = *o};
    ff_status status = ff_problem_make(&t, m, 1, o, &out->p, &err);
    if (!status) status = ff_places_init(out->p, &t, &out->places, &err);
    if (!status && o->robust != FF_ROBUST_NONE && o->robust_scale == 0) status = ff_problem_estimate_scale(out->p, m, o, &err);
    if (!status) status = ff_problem_fit_into(out->p, m, o, &out->fit, &err);
    FF_CHECK(status == FF_OK, "%s: %s", what, err.message);
    return status == FF_OK;
}

static void forget(measured *m)
{
    ff_fit_result_clear(&m->fit);
    ff_places_clear(&m->places);
    ff_problem_free(m->p);
    ff_table_clear(&m->t);
}

static const char *const plain_surface = "alpha=0.25 f0=0.5 kd=0.1";

static const scan_sampling usual_scan = {.n_theta = 8, .n_phi = 4, .n_exit = 120, .max_theta = 80, .noise = 0.05, .seed = 3};

static int scan(const char *what, const char *model, const char *words, scan_sampling how, const ff_fit_options *o, measured *out)
{
    const fit_surface s = fit_surface_make(model, 1, words);
    return measure(what, scan_measure(&s, &how), &s.model, o, out);
}

/* ---- distributions --------------------------------------------------------------------------- */

/* Tables of the distributions (Abramowitz and Stegun 1964, tables 26.7, 26.8, 26.10). */
static void quantiles(void)
{
    FF_CHECK_CLOSE(ff_student_quantile(0.95, 1), 12.706204736, 1e-9, 0);
    FF_CHECK_CLOSE(ff_student_quantile(0.95, 4), 2.776445105, 1e-9, 0);
    FF_CHECK_CLOSE(ff_student_quantile(0.90, 10), 1.812461123, 1e-9, 0);
    FF_CHECK_CLOSE(ff_student_quantile(0.95, 120), 1.979930405, 1e-9, 0);
    FF_CHECK_CLOSE(ff_student_quantile(0.95, INFINITY), FF_NORMAL_975, 1e-12, 0);
    FF_CHECK_CLOSE(ff_student_quantile(0.95, 1e9), FF_NORMAL_975, 1e-8, 0);
    FF_CHECK_CLOSE(ff_student_degrees(0.95, 2.776445105), 4, 1e-7, 0);
    FF_CHECK_CLOSE(ff_student_degrees(0.95, 12.706204736), 1, 1e-7, 0);
    FF_CHECK(isinf(ff_student_degrees(0.95, FF_NORMAL_975)) && isinf(ff_student_degrees(0.95, 0)), "known errors");
    FF_CHECK_CLOSE(ff_f_tail(3.0, 2, 10), pow(1 + 2 * 3.0 / 10, -5), 1e-12,
                   0); /* of 2 degrees of freedom: (1 + 2 x / m)^(-m / 2) */
    FF_CHECK_CLOSE(ff_f_tail(5.192167773, 3, 4), ff_f_tail(1 / 5.192167773, 4, 3) * -1 + 1, 1e-12, 0);
    FF_CHECK_CLOSE(ff_f_tail(4.964602744, 1, 10), 0.05, 1e-8, 0); /* t^2 */
    FF_CHECK_CLOSE(ff_f_tail(2.5, 3, INFINITY), ff_chi2_tail(7.5, 3), 1e-12, 0);
    FF_CHECK(ff_f_tail(0, 3, 5) == 1, "end of the tail");
    FF_CHECK_CLOSE(ff_chi2_tail(3.841458821, 1), 0.05, 1e-8, 0);
    FF_CHECK_CLOSE(ff_chi2_tail(18.307038053, 10), 0.05, 1e-8, 0);
    FF_CHECK_CLOSE(ff_chi2_tail(0.5, 4), 0.973500979, 1e-8, 0); /* (1 + x/2) exp(-x/2) */
    FF_CHECK_CLOSE(ff_normal_two_sided(FF_NORMAL_975), 0.05, 1e-12, 0);
    FF_CHECK(ff_chi2_tail(0, 3) == 1 && ff_chi2_tail(INFINITY, 3) == 0, "ends of the tail");
}

/* ---- neighbours ------------------------------------------------------------------------------ */

/* Noise that falls to 1/e over L samples makes (1 - r) / (1 + r), r = exp(-1/L), of n samples independent, for a Jacobian that does
 * not change along the scan: that of kd under the plain loss. Independent noise leaves the count. */
static void effective_number(void)
{
    ff_fit_options o = fit_options();
    const double reach[] = {0, 4, 16};
    o.loss = FF_LOSS_PLAIN;
    for (int k = 0; k < 3; k++) {
        double mean = 0;
        int fewer = 0;
        enum { REPEATS = 40 }; /* the effective number of one scatters by a third */
        for (int i = 0; i < REPEATS; i++) {
            measured m;
            scan_sampling how = usual_scan;
            how.n_exit = 400;
            how.reach = reach[k];
            how.seed = (uint64_t)(100 * k + i);
            if (!scan("effective number", "lambert", "kd=0.5", how, &o, &m)) continue;
            mean += m.fit.effective_samples / (double)m.places.n / REPEATS;
            fewer += k == 0 && m.fit.effective_samples < 0.7 * (double)m.places.n;
            forget(&m);
        }
        FF_CHECK(fewer <= 2, "independent errors seem to go together in %d of %d", fewer, REPEATS);
        const double r = reach[k] > 0 ? exp(-1 / reach[k]) : 0, expected = (1 - r) / (1 + r);
        printf("errors over %g samples: %.3f of the samples are independent, expected %.3f\n", reach[k], mean, expected);
        FF_CHECK(mean > 0.75 * expected && mean < 1.35 * expected, "%.3f, expected %.3f", mean, expected);
    }
}

/* A scan with standard deviations and noise of the relative size 0.1 that goes together over `reach` samples; 0: over none. The
 * standard error of alpha. */
static double error_of_known_noise(double reach)
{
    const fit_surface s = fit_surface_make("ggx+lambert", 1, plain_surface);
    scan_sampling how = usual_scan;
    uint64_t state = ff_test_stream("known noise");
    const double keep = reach > 0 ? exp(-1 / reach) : 0;
    double e = 0;
    ff_fit_options o = fit_options();
    measured m;
    how.noise = 0;
    ff_table t = scan_measure(&s, &how);
    t.sigma = malloc(t.n * sizeof *t.sigma);
    if (!t.sigma) exit(1);
    for (size_t i = 0; i < t.n; i++) {
        e = keep * e + sqrt(1 - keep * keep) * fit_normal(&state);
        t.sigma[i] = 0.1 * t.value[i];
        t.value[i] += t.sigma[i] * e;
    }
    o.weighting = FF_WEIGHT_SIGMA;
    if (!measure("known noise", t, &s.model, &o, &m)) return NAN;
    const double error = m.fit.shape_value[0].std_error;
    FF_CHECK((reach > 0) == (m.fit.correlated_over > 1), "errors go together over %zu samples", (size_t)m.fit.correlated_over);
    forget(&m);
    return error;
}

/* The standard deviations are believed, and so the inverse of the information; not that neighbours err independently. Over 8
 * samples they say less by about (1 + keep) / (1 - keep) = 16 in the variance, where all of them look at one parameter. */
static void known_noise_that_goes_together(void)
{
    const double alone = error_of_known_noise(0), together = error_of_known_noise(8);
    printf("standard error %.3g of independent errors, %.3g of errors that reach over 8 samples\n", alone, together);
    FF_CHECK(together > 1.5 * alone && together < 6 * alone, "%.3g times as large", together / alone);
}

/* A model that is not the surface leaves residuals that go together; samples in random order do not hide it. */
static void misfit_of_scattered_samples(void)
{
    const fit_surface s = fit_surface_make("ggx+lambert", 1, plain_surface);
    const fit_sampling how = {.n = 8000, .max_theta = 80, .noise = 0.03, .seed = 15};
    const char *const expressions[2] = {"ggx+lambert", "beckmann+lambert"};
    double right = 0;
    for (int k = 0; k < 2; k++) {
        ff_fit_options o = fit_options();
        ff_model model;
        measured m;
        o.shape = FF_SHAPE_ISOTROPIC;
        FF_CHECK(!ff_model_parse(expressions[k], &model, NULL), "%s", expressions[k]);
        if (!measure("misfit", fit_measure(&s, &how), &model, &o, &m)) return;
        printf("%s on scattered ggx data: %zu values count as %.0f, together over %zu\n", expressions[k], m.places.n,
               m.fit.effective_samples, m.fit.correlated_over);
        if (k == 0) right = m.fit.effective_samples;
        FF_CHECK(k == 0 ? m.fit.effective_samples > 0.7 * (double)m.places.n
                        : m.fit.effective_samples < 0.8 * right && m.fit.correlated_over > 8,
                 "%s: %.0f of %zu", expressions[k], m.fit.effective_samples, m.places.n);
        forget(&m);
    }
}

static void places_of_samples(void)
{
    const ff_fit_options o = fit_options();
    const fit_surface s = fit_surface_make("ggx+lambert", 1, plain_surface);
    measured m;
    if (scan("places", "ggx+lambert", plain_surface, usual_scan, &o, &m)) {
        FF_CHECK(m.places.kind == FF_GROUP_DIRECTIONS && m.places.n_groups == 32, "%zu %s", m.places.n_groups,
                 ff_grouping_name((int)m.places.kind));
        for (size_t i = 0; i < m.places.n; i++) {
            const size_t at = ff_problem_index(m.p)[i];
            FF_CHECK(m.places.direction[i] == at / 120, "sample %zu of direction %u", at, m.places.direction[i]);
            FF_CHECK(m.places.band[FF_PLACE_THETA_I][i] == (unsigned char)(m.t.angle[0][at] / (10 * FIT_DEGREE)),
                     "band of sample %zu", at);
        }
        forget(&m);
    }
    scan_sampling few = usual_scan;
    few.n_theta = 4, few.n_phi = 1;
    if (scan("few directions", "ggx+lambert", plain_surface, few, &o, &m)) {
        FF_CHECK(m.places.kind == FF_GROUP_RUNS && m.places.n_directions == 4 && m.places.n_groups >= 40,
                 "%zu groups, %zu directions", m.places.n_groups, m.places.n_directions);
        for (size_t i = 1; i < m.places.n; i++) /* no run goes from one direction into another */
            if (m.places.group[i] == m.places.group[i - 1])
                FF_CHECK(m.places.direction[i] == m.places.direction[i - 1], "run %u", m.places.group[i]);
        forget(&m);
    }
    const fit_sampling scattered = {.n = 3000, .max_theta = 80, .noise = 0.05, .seed = 5};
    if (measure("scattered", fit_measure(&s, &scattered), &s.model, &o, &m)) {
        FF_CHECK(m.places.kind == FF_GROUP_CELLS && m.places.n_groups >= 30 && m.places.n_groups < 300, "%zu %s", m.places.n_groups,
                 ff_grouping_name((int)m.places.kind));
        forget(&m);
    }
}

/* ---- intervals ------------------------------------------------------------------------------- */

/* Without a lobe the objective is a parabola in kd: the profile is the interval of the standard error. With F0 and kd at 0 the
 * one-sided interval starts at the bound and the profile agrees. */
static void profiles(void)
{
    const ff_fit_options o = fit_options();
    ff_error err = {0};
    measured m;
    if (scan("a parabola", "lambert", "kd=0.4", usual_scan, &o, &m)) {
        const ff_fit_value wald = m.fit.channel_value[0];
        FF_CHECK(wald.interval == FF_INTERVAL_WALD && fabs(wald.value - 0.4) < 4.5 * wald.std_error, "%g to %g", wald.low,
                 wald.high);
        FF_CHECK(ff_trust_profile(m.p, &o, &m.fit, &err) == FF_OK, "%s", err.message);
        const ff_fit_value *v = &m.fit.channel_value[0];
        const double width = wald.high - wald.low;
        FF_CHECK(v->interval == FF_INTERVAL_PROFILE, "interval by %s", ff_interval_name((int)v->interval));
        FF_CHECK_CLOSE(v->low, wald.low, 0, 0.02 * width);
        FF_CHECK_CLOSE(v->high, wald.high, 0, 0.02 * width);
        forget(&m);
    }
    if (scan("errors by incidences", "lambert", "kd=0.4", usual_scan, &o, &m)) { /* its parabola is as wide as they say */
        FF_CHECK(ff_trust_jackknife(m.p, &m.places, &o, &m.fit, &err) == FF_OK, "%s", err.message);
        const ff_fit_value by_incidences = m.fit.channel_value[0];
        const double width = by_incidences.high - by_incidences.low;
        FF_CHECK(ff_trust_profile(m.p, &o, &m.fit, &err) == FF_OK, "%s", err.message);
        const ff_fit_value *v = &m.fit.channel_value[0];
        FF_CHECK(by_incidences.interval == FF_INTERVAL_JACKKNIFE && v->interval == FF_INTERVAL_PROFILE, "interval by %s",
                 ff_interval_name((int)v->interval));
        FF_CHECK_CLOSE(v->low, by_incidences.low, 0, 0.02 * width);
        FF_CHECK_CLOSE(v->high, by_incidences.high, 0, 0.02 * width);
        forget(&m);
    }
    if (scan("no diffuse part", "ggx+lambert", "alpha=0.25 f0=0.5 kd=0", usual_scan, &o, &m)) {
        const ff_fit_value *kd = &m.fit.channel_value[m.fit.model.n_channel - 1], before = *kd;
        if (kd->at_bound) {
            FF_CHECK(kd->interval == FF_INTERVAL_ONE_SIDED && kd->low == 0 && kd->high > 0 && kd->high < 0.1, "%g to %g by %s",
                     kd->low, kd->high, ff_interval_name((int)kd->interval));
            FF_CHECK(ff_trust_profile(m.p, &o, &m.fit, &err) == FF_OK, "%s", err.message);
            FF_CHECK(kd->low == 0, "the profile of kd begins at %g", kd->low);
            FF_CHECK_CLOSE(kd->high, before.high, 0.1, 0);
        }
        FF_CHECK(kd->at_bound || kd->value < 0.02, "kd = %g", kd->value);
        forget(&m);
    }
}

/* Two parameters pressed against their bounds, neither of which moves while the other's interval is looked for: each ends where the
 * profile does, in which the other one stays where it is. */
static void two_on_their_bounds(void)
{
    static const ff_bound bounds[] = {{.name = "f0", .lo = 0, .hi = 0.45}, {.name = "kd", .lo = 0, .hi = 0.12}};
    const ff_constraints c = {.n_bounds = 2, .bound = bounds};
    ff_fit_options o = fit_options();
    ff_error err = {0};
    measured m;
    o.constraints = &c;
    if (!scan("two on their bounds", "ggx+lambert", "alpha=0.25 f0=0.5 kd=0.1", usual_scan, &o, &m)) return;
    const ff_fit_value *v = m.fit.channel_value;
    const size_t K = m.fit.model.n_channel;
    double low[4], high[4];
    FF_CHECK(v[0].at_bound > 0 && v[K - 1].at_bound > 0, "f0 %d, kd %d", v[0].at_bound, v[K - 1].at_bound);
    for (size_t k = 0; k < K; k++) low[k] = v[k].low, high[k] = v[k].high;
    FF_CHECK(ff_trust_profile(m.p, &o, &m.fit, &err) == FF_OK, "%s", err.message);
    for (size_t k = 0; k < K; k += K - 1) {
        printf("%s: %.5f to %.5f, by the profile %.5f to %.5f\n", m.fit.model.channel[k].name, low[k], high[k], v[k].low,
               v[k].high);
        FF_CHECK_CLOSE(high[k] - low[k], v[k].high - v[k].low, 0.1, 0);
    }
    forget(&m);
}

/* Near a profile's end the objective, with all others free, is where it should be: checked by a fit with the parameter held there.
 */
static void ends_of_profiles(void)
{
    const ff_fit_options o = fit_options();
    ff_error err = {0};
    measured m;
    scan_sampling how = usual_scan;
    how.n_theta = 24, how.n_phi = 1; /* isotropic: one alpha */
    if (!scan("ends", "beckmann+lambert", plain_surface, how, &o, &m)) return;
    const double se = m.fit.shape_value[0].std_error, alpha = m.fit.shape_value[0].value;
    FF_CHECK(ff_trust_profile(m.p, &o, &m.fit, &err) == FF_OK, "%s", err.message);
    double rise[3];
    const double at[3] = {m.fit.shape_value[0].low, alpha + 1e-3 * se, m.fit.shape_value[0].high};
    for (int k = 0; k < 3; k++) {
        ff_model held = m.fit.model;
        ff_fit_result r;
        FF_CHECK(!ff_model_hold(&held, "alpha", at[k], &err) && !ff_problem_fit_into(m.p, &held, &o, &r, &err), "%s", err.message);
        rise[k] = r.residual.objective - m.fit.residual.objective;
        ff_fit_result_clear(&r);
    }
    printf("profile of alpha: %.5f to %.5f, rises %.3g and %.3g; standard error %.5f\n", at[0], at[2], rise[0], rise[2], se);
    FF_CHECK(rise[1] >= 0 && rise[1] < 1e-3 * rise[0], "rise beside the optimum %g", rise[1]);
    FF_CHECK_CLOSE(rise[0], rise[2], 0.05, 0);
    FF_CHECK(at[0] < alpha && alpha < at[2] && at[2] - at[0] > 2 * se && at[2] - at[0] < 6 * se, "%g to %g", at[0], at[2]);
    forget(&m);
}

/* F0 without a Fresnel effect to see trades off with ks: the profile runs into the box, and the warning names what trades off.
 * Noise that looks like a Fresnel effect by more than its error, one time in 40, leaves F0 small and known. */
static void not_determined(void)
{
    enum { MEASUREMENTS = 8, MOST_MISLED = 2 };
    ff_fit_options o = fit_options();
    fit_surface s = fit_surface_make("ggx", 1, "alpha=0.1 f0=0.5");
    int misled = 0;
    FF_CHECK(!ff_model_vary(&s.model, "ks", NULL), "ks is not to be varied");
    o.loss = FF_LOSS_RELATIVE; /* of which the noise is the same everywhere */
    for (int i = 0; i < MEASUREMENTS; i++) {
        ff_error err = {0};
        scan_sampling narrow = usual_scan;
        narrow.max_theta = 25;
        narrow.seed = (uint64_t)(200 + i);
        measured m;
        if (!measure("ks and f0", scan_measure(&s, &narrow), &s.model, &o, &m)) return;
        const ff_warning *pair = find_warning(&m.fit, FF_WARNING_CORRELATED, "f0");
        FF_CHECK((pair && warning_names(&m.fit, pair, "ks")) || has_warning(&m.fit, FF_WARNING_COMBINATION_NOT_DETERMINED, "ks"),
                 "no warning of f0 and ks; f0 %g, condition %g", m.fit.channel_value[0].value, m.fit.condition);
        FF_CHECK(m.fit.channel_value[0].at_bound || m.fit.condition > 30, "condition %g", m.fit.condition);
        FF_CHECK(ff_trust_profile(m.p, &o, &m.fit, &err) == FF_OK, "%s", err.message);
        const ff_fit_value *f0 = &m.fit.channel_value[0];
        misled += !(f0->high - f0->low > 0.5);
        forget(&m);
    }
    printf("f0 is said to be known in %d of %d\n", misled, MEASUREMENTS);
    FF_CHECK(misled <= MOST_MISLED, "in %d of %d f0 is said to be known", misled, MEASUREMENTS);
}

/* Errors by refits and by the formula are of one size in the mean of several measurements. With values drawn anew a fit is as good
 * as linear here: that of 100 refits scatters by .07, the mean of 12 by .02. With weights of groups: of the 32 of one some ten say
 * much: its error by refits scatters by a quarter, that of 100 refits by .07 more, the mean of 12 by .08; refits take errors for
 * larger by up to sqrt(2). */
static void errors_by_refits(void)
{
    enum { MEASUREMENTS = 12 };
    ff_fit_options o = fit_options();
    double ratio[2][2] = {{0}};
    for (int i = 0; i < 2 * MEASUREMENTS; i++) {
        const int way = i % 2;
        ff_error err = {0};
        measured m;
        ff_bootstrap b;
        scan_sampling how = usual_scan;
        how.seed = (uint64_t)(100 + i / 2);
        o.errors = way ? FF_ERRORS_INCIDENCES : FF_ERRORS_NOISE;
        if (!scan("errors by refits", "ggx+lambert", plain_surface, how, &o, &m)) return;
        const double formula[2] = {m.fit.shape_value[0].std_error, m.fit.channel_value[0].std_error};
        FF_CHECK(ff_trust_bootstrap_into(m.p, &m.places, &o, 100, 7, &m.fit, &b, &err) == FF_OK, "%s", err.message);
        ratio[way][0] += m.fit.shape_value[0].std_error / formula[0] / MEASUREMENTS;
        ratio[way][1] += m.fit.channel_value[0].std_error / formula[1] / MEASUREMENTS;
        forget(&m);
    }
    for (int way = 0; way < 2; way++) {
        printf("errors by refits: %.2f and %.2f times those by the formula\n", ratio[way][0], ratio[way][1]);
        for (int k = 0; k < 2; k++)
            FF_CHECK(ratio[way][k] > (way ? 0.7 : 0.9) && ratio[way][k] < (way ? 1.7 : 1.1), "%.3g times the error by the formula",
                     ratio[way][k]);
    }
}

/* groups: what is resampled. */
static void bootstrap_by(ff_error_source errors, size_t groups, ff_grouping kind)
{
    ff_fit_options o = fit_options();
    ff_error err = {0};
    measured m;
    ff_bootstrap b;
    o.errors = errors;
    if (!scan("bootstrap", "ggx+lambert", plain_surface, usual_scan, &o, &m)) return;
    const ff_fit_value formula[2] = {m.fit.shape_value[0], m.fit.channel_value[0]};
    FF_CHECK(ff_trust_bootstrap_into(m.p, &m.places, &o, 10, 1, &m.fit, &b, &err) == FF_ERR_RANGE, "10 refits: %s", err.message);
    FF_CHECK(m.fit.shape_value[0].std_error == formula[0].std_error, "a refused bootstrap changed the fit");
    FF_CHECK(ff_trust_bootstrap_into(m.p, &m.places, &o, 400, 7, &m.fit, &b, &err) == FF_OK, "%s", err.message);
    FF_CHECK(b.repeats == 400 && b.failed == 0 && b.n_groups == groups && b.kind == kind, "%zu refits, %zu failed, %zu %s",
             b.repeats, b.failed, b.n_groups, ff_grouping_name((int)b.kind));
    const ff_fit_value boot[2] = {m.fit.shape_value[0], m.fit.channel_value[0]};
    for (int k = 0; k < 2; k++) {
        printf("standard error %.6f, by 400 refits %.6f\n", formula[k].std_error, boot[k].std_error);
        FF_CHECK(boot[k].interval == FF_INTERVAL_BOOTSTRAP && boot[k].low < boot[k].value && boot[k].high > boot[k].value,
                 "interval %d", k);
    }
    FF_CHECK(ff_trust_bootstrap_into(m.p, &m.places, &o, 400, 7, &m.fit, &b, &err) == FF_OK, "%s", err.message);
    FF_CHECK(m.fit.shape_value[0].std_error == boot[0].std_error, "the same seed, another error");
    FF_CHECK(ff_trust_bootstrap_into(m.p, &m.places, &o, 400, 8, &m.fit, &b, &err) == FF_OK, "%s", err.message);
    FF_CHECK(m.fit.shape_value[0].std_error != boot[0].std_error, "another seed, the same error");
    measured one;
    o.threads = 1;
    if (scan("one thread", "ggx+lambert", plain_surface, usual_scan, &o, &one)) {
        FF_CHECK(ff_trust_bootstrap_into(one.p, &one.places, &o, 400, 7, &one.fit, &b, &err) == FF_OK, "%s", err.message);
        FF_CHECK(one.fit.shape_value[0].std_error == boot[0].std_error, "%.17g with one thread, %.17g with two",
                 one.fit.shape_value[0].std_error, boot[0].std_error);
        forget(&one);
    }
    forget(&m);
}

static void bootstraps(void)
{
    bootstrap_by(FF_ERRORS_NOISE, 3840, FF_GROUP_VALUES);
    bootstrap_by(FF_ERRORS_INCIDENCES, 32, FF_GROUP_DIRECTIONS);
    bootstrap_by(FF_ERRORS_RESIDUALS, 32, FF_GROUP_DIRECTIONS);
}

/* Every loss draws its targets, and its weights where these follow the datum: the mean of the refits is the fit, whose errors they
 * have. 200 refits: their standard deviation scatters by .05; where weights follow the datum an error is not the whole story. */
static void bootstrap_of_losses(void)
{
    static const ff_loss losses[] = {FF_LOSS_PLAIN, FF_LOSS_COSINE, FF_LOSS_LOG, FF_LOSS_CUBE_ROOT, FF_LOSS_RELATIVE, FF_LOSS_LN};
    for (size_t k = 0; k < sizeof losses / sizeof *losses; k++) {
        ff_fit_options o = fit_options();
        ff_error err = {0};
        measured m;
        ff_bootstrap b;
        o.loss = losses[k];
        if (!scan(ff_loss_name((int)o.loss), "ggx+lambert", plain_surface, usual_scan, &o, &m)) return;
        const double formula = m.fit.shape_value[0].std_error;
        FF_CHECK(ff_trust_bootstrap_into(m.p, &m.places, &o, 200, 3, &m.fit, &b, &err) == FF_OK, "%s", err.message);
        const double ratio = m.fit.shape_value[0].std_error / formula;
        printf("loss %s: standard error of alpha %.6f, by refits %.2f of it\n", ff_loss_name((int)o.loss), formula, ratio);
        FF_CHECK(b.kind == FF_GROUP_VALUES && b.failed == 0 && ratio > 0.8 && ratio < 1.25, "%s: %.3g of the error, %zu failed",
                 ff_loss_name((int)o.loss), ratio, b.failed);
        forget(&m);
    }
}

/* Refits of a parameter on its bound: the 95 % quantile of their distances from it. The data are shifted so that kd would be half
 * its error below 0 were it free to: three of ten refits leave the bound, and the quantile is 1.645 - 0.5 of
 * their errors away from it; those of the interval are taken for larger by up to sqrt(2). */
static void bootstrap_on_a_bound(void)
{
    const fit_surface s = fit_surface_make("ggx+lambert", 1, plain_surface);
    ff_fit_options o = fit_options();
    ff_error err = {0};
    ff_bootstrap b;
    measured m;
    o.errors = FF_ERRORS_INCIDENCES;
    if (!measure("inside", scan_measure(&s, &usual_scan), &s.model, &o, &m)) return;
    const uint32_t kd = (uint32_t)ff_model_param_find(&s.model, "kd").index;
    FF_CHECK(ff_trust_bootstrap_into(m.p, &m.places, &o, 200, 3, &m.fit, &b, &err) == FF_OK, "%s", err.message);
    const double error = m.fit.channel_value[kd].std_error, shift = m.fit.channel_value[kd].value + 0.5 * error;
    forget(&m);
    ff_table t = scan_measure(&s, &usual_scan);
    for (size_t i = 0; i < t.n; i++) t.value[i] -= shift / 3.14159265358979323846;
    if (!measure("on the bound", t, &s.model, &o, &m)) return;
    const ff_fit_value *v = &m.fit.channel_value[kd];
    FF_CHECK(v->at_bound < 0 && v->value == 0, "kd is %g, bound %d", v->value, v->at_bound);
    FF_CHECK(ff_trust_bootstrap_into(m.p, &m.places, &o, 400, 4, &m.fit, &b, &err) == FF_OK, "%s", err.message);
    printf("kd up to %.3g, %.2f errors from its bound\n", v->high, v->high / error);
    FF_CHECK(v->interval == FF_INTERVAL_BOOTSTRAP && v->low == 0, "from %g", v->low);
    FF_CHECK(v->high > 0.4 * error && v->high < 2 * error, "up to %g, of an error of %g", v->high, error);
    forget(&m);
}

/* ---- cut-off --------------------------------------------------------------------------------- */

/* A goniometer that loses light beyond 70 degrees moves the parameters; one that does not leaves them. */
static void cut_offs(void)
{
    const ff_fit_options o = fit_options();
    const fit_surface s = fit_surface_make("ggx+lambert", 1, plain_surface);
    for (int loses = 0; loses < 2; loses++) {
        ff_error err = {0};
        ff_cut_off c;
        measured m;
        double most = 0;
        ff_table t = scan_measure(&s, &usual_scan);
        for (size_t i = 0; i < t.n && loses; i++)
            if (fmax(t.angle[0][i], fabs(t.angle[2][i])) > 70 * FIT_DEGREE) t.value[i] *= 0.6;
        if (!measure("cut-off", t, &s.model, &o, &m)) return;
        FF_CHECK(ff_trust_cut_off_into(m.p, &o, &m.fit, 70 * FIT_DEGREE, &c, &err) == FF_OK, "%s", err.message);
        FF_CHECK(c.n_columns == m.fit.n_columns && c.used < m.places.n && c.used > m.places.n / 2, "%zu of %zu", c.used,
                 m.places.n);
        for (size_t k = 0; k < c.n_columns; k++) most = fmax(most, fabs(c.move[k]));
        printf("%s: largest move %.1f errors\n", loses ? "light lost beyond 70 degrees" : "nothing lost", most);
        FF_CHECK(loses ? most > 10 : most < 2 * c.limit, "largest move %g, limit %g", most, c.limit);
        /* the values are those of a fit to the smaller data */
        ff_fit_options lower = o;
        ff_fit_result r;
        lower.max_theta = 70 * FIT_DEGREE;
        FF_CHECK(!fit_table(&t, &s.model, &lower, &r, NULL, &err), "%s", err.message);
        /* one step where little moves: to a small part of an error */
        FF_CHECK_CLOSE(c.value[m.fit.shape_value[0].column], r.shape_value[0].value, 1e-5,
                       loses ? 0 : 0.1 * m.fit.shape_value[0].std_error);
        ff_fit_result_clear(&r);
        ff_cut_off_clear(&c);
        FF_CHECK(ff_trust_cut_off_into(m.p, &o, &m.fit, 0.01 * FIT_DEGREE, &c, &err) == FF_ERR_DATA, "a cut-off of 0.01 degrees");
        forget(&m);
    }
}

/* Errors and comparisons by the residuals alone. */
static ff_fit_options by_residuals(void)
{
    ff_fit_options o = fit_options();
    o.errors = FF_ERRORS_RESIDUALS;
    return o;
}

/* ---- comparison ------------------------------------------------------------------------------ */

enum { VERSUS = 3 };

/* The data's own model, one that hardly differs, one that does. */
static void comparisons(void)
{
    const char *const expressions[VERSUS] = {"ggx/smith-height-correlated+lambert", "ggx/smith-separable+lambert",
                                             "beckmann+lambert"};
    const fit_surface s = fit_surface_make(expressions[0], 1, "alpha=0.08 f0=0.5 kd=0.1");
    ff_model models[VERSUS];
    ff_fit_result fits[VERSUS];
    ff_versus v[VERSUS];
    ff_error err = {0};
    const ff_fit_options o = fit_options();
    ff_table t = scan_measure(&s, &usual_scan);
    ff_problem *p = NULL;
    ff_places places;
    for (int k = 0; k < VERSUS; k++) FF_CHECK(!ff_model_parse(expressions[k], &models[k], &err), "%s", err.message);
    FF_CHECK(!ff_problem_make(&t, models, VERSUS, &o, &p, &err) && !ff_places_init(p, &t, &places, &err), "%s", err.message);
    for (int k = 0; k < VERSUS; k++) FF_CHECK(!ff_problem_fit_into(p, &models[k], &o, &fits[k], &err), "%s", err.message);
    FF_CHECK(ff_trust_compare_into(p, &places, &o, fits, VERSUS, 0, 1, v, &err) == FF_ERR_RANGE, "one fold");
    FF_CHECK(ff_trust_compare_into(p, &places, &o, fits, VERSUS, 0, 33, v, &err) == FF_ERR_RANGE, "more folds than directions");
    FF_CHECK(ff_trust_compare_into(p, &places, &o, fits, VERSUS, 0, 8, v, &err) == FF_OK, "%s", err.message);
    for (int k = 1; k < VERSUS; k++) {
        printf("%s: objective +%.3g, AIC %+.1f, z %.2f, held out %.3g +- %.2g, %s\n", expressions[k], v[k].objective, v[k].aic,
               v[k].vuong_z, v[k].validation, v[k].validation_error, v[k].told_apart ? "worse" : "not told apart");
        FF_CHECK_CLOSE(v[k].objective, fits[k].residual.objective - fits[0].residual.objective, 1e-12, 1e-15);
        /* a model that hardly differs is another one all the same: it may be told apart, where its p says so */
        FF_CHECK(k == 2 ? v[k].told_apart : !v[k].told_apart || v[k].vuong_p < 0.05, "%s: p %g", expressions[k], v[k].vuong_p);
        FF_CHECK(v[k].has_validation && v[k].validation_error > 0, "held out");
    }
    FF_CHECK(v[2].validation > 3 * v[2].validation_error, "beckmann on held-out directions: %g +- %g", v[2].validation,
             v[2].validation_error);
    FF_CHECK_CLOSE(v[2].bic, v[2].aic, 1e-12, 1e-12); /* as many parameters */
    for (int k = 0; k < VERSUS; k++) ff_fit_result_clear(&fits[k]);
    ff_places_clear(&places);
    ff_problem_free(p);
    ff_table_clear(&t);
}

/* Variance of a sum from the sums of its parts. */
static double spread_by_hand(const double *part, size_t n)
{
    double mean = 0, square = 0;
    for (size_t k = 0; k < n; k++) mean += part[k] / (double)n;
    for (size_t k = 0; k < n; k++) square += (part[k] - mean) * (part[k] - mean);
    return square * (double)n / (double)(n - 1);
}

/* Models with different numbers of parameters: the criteria by their formulas, each with the values that count, and the statistic
 * from what every sample adds to the objective, with the penalty of a parameter in its units. */
static void comparison_by_hand(void)
{
    const char *const expressions[2] = {"ggx+lambert", "ggx"};
    const fit_surface s = fit_surface_make(expressions[0], 1, "alpha=0.25 f0=0.5 kd=0.02");
    const ff_fit_options o = by_residuals(); /* by common weights: comparisons_test */
    ff_table t = scan_measure(&s, &usual_scan);
    ff_problem *p = NULL;
    ff_places places;
    ff_model models[2];
    ff_fit_result fits[2];
    ff_versus v[2];
    ff_error err = {0};
    for (int k = 0; k < 2; k++) FF_CHECK(!ff_model_parse(expressions[k], &models[k], &err), "%s", err.message);
    FF_CHECK(!ff_problem_make(&t, models, 2, &o, &p, &err) && !ff_places_init(p, &t, &places, &err), "%s", err.message);
    for (int k = 0; k < 2; k++) FF_CHECK(!ff_problem_fit_into(p, &models[k], &o, &fits[k], &err), "%s", err.message);
    FF_CHECK(!ff_trust_compare_into(p, &places, &o, fits, 2, 0, 0, v, &err), "%s", err.message);
    const size_t n = places.n, run[2] = {fits[0].correlated_over, fits[1].correlated_over}, longer = run[run[1] > run[0]],
                 length = longer > 1 ? longer : 1;
    const double N = (double)n, effective = fits[0].effective_samples, extra = (double)fits[1].n_free - (double)fits[0].n_free,
                 qw = fits[0].residual.objective, qo = fits[1].residual.objective;
    FF_CHECK(extra == -1, "%g parameters more", extra);
    FF_CHECK_CLOSE(v[1].aic, effective * log(qo / qw) + 2 * extra, 1e-9, 0);
    FF_CHECK_CLOSE(v[1].bic, effective * log(qo / qw) + extra * log(effective), 1e-9, 0);
    double *cost = malloc(2 * n * sizeof *cost), *of_run = calloc(n, sizeof *of_run), *of_group = calloc(n, sizeof *of_group),
           sum = 0;
    if (!cost || !of_run || !of_group) exit(1);
    for (int k = 0; k < 2; k++)
        FF_CHECK(!ff_trust_evaluate(p, &o, &fits[k], NULL, NULL, cost + (size_t)k * n, &err), "%s", err.message);
    for (size_t i = 0; i < n; i++) {
        const double more = cost[n + i] - cost[i];
        sum += more;
        of_run[i / length] += more;
        of_group[places.group[i]] += more;
    }
    FF_CHECK_CLOSE(sum, qo - qw, 1e-9, 0);
    const double penalised = sum + extra * (2 * qw / N) * N / effective,
                 by_run = penalised / sqrt(spread_by_hand(of_run, (n + length - 1) / length)),
                 by_group = penalised / sqrt(spread_by_hand(of_group, places.n_groups));
    printf("z %.6f; by hand %.6f over runs, %.6f over groups\n", v[1].vuong_z, by_run, by_group);
    FF_CHECK(fabs(v[1].vuong_z - by_run) < 1e-9 * fabs(by_run) || fabs(v[1].vuong_z - by_group) < 1e-9 * fabs(by_group),
             "z is %.12g", v[1].vuong_z);
    free(cost);
    free(of_run);
    free(of_group);
    for (int k = 0; k < 2; k++) ff_fit_result_clear(&fits[k]);
    ff_places_clear(&places);
    ff_problem_free(p);
    ff_table_clear(&t);
}

/* Measurements of a surface between two models: (1 - w) of one and w of the other, noise of 10 %, in scans over 20 directions,
 * every other one with noise that goes together over 4 samples. In how many are the two models told apart? The mean of z. */
static int told_apart_of_blend(double w, int repeats, double *mean_z)
{
    const char *const expressions[2] = {"ggx+lambert", "beckmann+lambert"}, *const words = "alpha=0.25 f0=0.5 kd=0.1";
    const fit_surface s[2] = {fit_surface_make(expressions[0], 1, words), fit_surface_make(expressions[1], 1, words)};
    const ff_model models[2] = {s[0].model, s[1].model};
    const ff_fit_options o = by_residuals();
    int told = 0;
    *mean_z = 0;
    for (int i = 0; i < repeats; i++) {
        scan_sampling how = usual_scan;
        uint64_t state = ff_test_stream("noise along scans %d", i);
        double e = 0;
        const double keep = i % 2 ? exp(-1 / 4.0) : 0;
        how.n_theta = 20, how.n_phi = 1, how.n_exit = 60, how.noise = 0;
        ff_table t = scan_measure(&s[0], &how), u = scan_measure(&s[1], &how);
        for (size_t k = 0; k < t.n; k++) {
            e = keep * e + sqrt(1 - keep * keep) * fit_normal(&state);
            t.value[k] = ((1 - w) * t.value[k] + w * u.value[k]) * (1 + 0.1 * e);
        }
        ff_table_clear(&u);
        ff_problem *p = NULL;
        ff_places places = {0};
        ff_fit_result fits[2] = {0};
        ff_versus v[2];
        ff_status status = ff_problem_make(&t, models, 2, &o, &p, NULL);
        if (!status) status = ff_places_init(p, &t, &places, NULL);
        for (int k = 0; k < 2 && !status; k++) status = ff_problem_fit_into(p, &models[k], &o, &fits[k], NULL);
        if (!status) status = ff_trust_compare_into(p, &places, &o, fits, 2, 0, 0, v, NULL);
        FF_CHECK(status == FF_OK, "measurement %d: %s", i, ff_status_str(status));
        if (!status) told += v[1].told_apart, *mean_z += v[1].vuong_z / repeats;
        for (int k = 0; k < 2; k++) ff_fit_result_clear(&fits[k]);
        ff_places_clear(&places);
        ff_problem_free(p);
        ff_table_clear(&t);
    }
    return told;
}

/* Half way between them the test errs in about one of twenty measurements; where one model is the truth it finds that out. */
static void size_and_power_of_the_test(void)
{
    enum { REPEATS = 200 };
    double z, half_way = 0.45;
    const int wrongly = told_apart_of_blend(half_way, REPEATS, &z);
    printf("half way between ggx and beckmann: told apart in %.1f %% of %d measurements, mean z %.2f\n", 100.0 * wrongly / REPEATS,
           REPEATS, z);
    FF_CHECK(fabs(z) < 0.5, "%g is not half way: mean z %g", half_way, z);
    FF_CHECK(wrongly <= REPEATS / 10, "told apart in %d of %d", wrongly, REPEATS);
    for (int which = 0; which < 2; which++) {
        const int rightly = told_apart_of_blend(which, REPEATS / 4, &z);
        printf("%s is the truth: told apart in %d of %d, mean z %.2f\n", which ? "beckmann" : "ggx", rightly, REPEATS / 4, z);
        FF_CHECK(rightly >= REPEATS / 5 && (which ? z < -2 : z > 2), "told apart in %d of %d, mean z %g", rightly, REPEATS / 4, z);
    }
}

/* Held-out directions are held out: what cross-validation reports is what fits by hand to the rest give. */
static void validation_by_hand(void)
{
    enum { FOLDS = 4 };
    const char *const expressions[2] = {"ggx+lambert", "beckmann+lambert"};
    const fit_surface s = fit_surface_make("ggx+lambert", 1, plain_surface);
    const ff_fit_options o = fit_options();
    ff_table t = scan_measure(&s, &usual_scan);
    ff_error err = {0};
    double held_out[2] = {0};
    ff_model models[2];
    for (int k = 0; k < 2; k++) FF_CHECK(!ff_model_parse(expressions[k], &models[k], &err), "%s", err.message);
    for (int k = 0; k < 2; k++)
        for (size_t fold = 0; fold < FOLDS; fold++) {
            ff_table part;
            ff_fit_result r;
            FF_CHECK(!ff_table_copy_into(&t, &part, &err), "%s", err.message);
            for (size_t i = 0; i < t.n; i++)
                if (i / usual_scan.n_exit % FOLDS == fold) part.valid[i] = 0;
            FF_CHECK(!fit_table(&part, &models[k], &o, &r, NULL, &err), "%s", err.message);
            fit_surface fitted = {.model = models[k], .n_channels = 1};
            for (uint32_t q = 0; q < r.model.n_shape; q++) fitted.shape[q] = r.shape_value[q].value;
            for (uint32_t q = 0; q < r.model.n_channel; q++) fitted.channel[q] = r.channel_value[q].value;
            fit_evaluate(&fitted, &part);
            for (size_t i = 0; i < t.n; i++) {
                const double x = cos(t.angle[0][i]), e = (part.value[i] - t.value[i]) * x;
                if (i / usual_scan.n_exit % FOLDS == fold) held_out[k] += 0.5 * e * e;
            }
            ff_fit_result_clear(&r);
            ff_table_clear(&part);
        }
    ff_problem *p = NULL;
    ff_places places;
    ff_fit_result fits[2];
    ff_versus v[2];
    FF_CHECK(!ff_problem_make(&t, models, 2, &o, &p, &err) && !ff_places_init(p, &t, &places, &err), "%s", err.message);
    for (int k = 0; k < 2; k++) FF_CHECK(!ff_problem_fit_into(p, &models[k], &o, &fits[k], &err), "%s", err.message);
    FF_CHECK(!ff_trust_compare_into(p, &places, &o, fits, 2, 0, FOLDS, v, &err), "%s", err.message);
    printf("held out by hand: %.6f against %.6f\n", held_out[1] - held_out[0], v[1].validation);
    FF_CHECK_CLOSE(v[1].validation, held_out[1] - held_out[0], 1e-4, 0);
    for (int k = 0; k < 2; k++) ff_fit_result_clear(&fits[k]);
    ff_places_clear(&places);
    ff_problem_free(p);
    ff_table_clear(&t);
}

/* Mean cos(theta_o) of what leaves from light beyond 70 degrees: of the data, or of a fit. */
static double lobe_height(const measured *m, const ff_fit_result *fit)
{
    double *f = malloc(m->places.n * sizeof *f), sum = 0, total = 0;
    if (!f || (fit && ff_trust_evaluate(m->p, &m->o, fit, f, NULL, NULL, NULL))) exit(1);
    for (size_t i = 0; i < m->places.n; i++) {
        const size_t at = ff_problem_index(m->p)[i];
        const double value = fit ? f[i] : m->t.value[at], oz = cos(m->t.angle[2][at]);
        if (m->t.angle[0][at] < 70 * FIT_DEGREE) continue;
        sum += value * oz * oz;
        total += value * oz;
    }
    free(f);
    return sum / total;
}

/* The band of theta_i from 10 k degrees on, from the values of the fit and the weights of the table: the mean of the residuals and
 * the root of that of their squares, relative to the mean of the data. */
static void band_by_hand(const measured *m, size_t k, const ff_band *found)
{
    ff_error err = {0};
    double *f = malloc(m->places.n * sizeof *f), weights = 0, sum = 0, square = 0, data = 0;
    size_t n = 0;
    FF_CHECK(f && !ff_trust_evaluate(m->p, &m->o, &m->fit, f, NULL, NULL, &err), "%s", err.message);
    for (size_t i = 0; i < m->places.n; i++) {
        const size_t at = ff_problem_index(m->p)[i];
        const double theta = m->t.angle[0][at], e = (f[i] - m->t.value[at]) * cos(theta), w = m->t.weight ? m->t.weight[at] : 1;
        if (theta < 10 * (double)k * FIT_DEGREE || theta >= 10 * (double)(k + 1) * FIT_DEGREE) continue;
        weights += w;
        sum += w * e;
        square += w * e * e;
        data += w * fabs(m->t.value[at]) * cos(theta);
        n++;
    }
    free(f);
    FF_CHECK(n > 100 && n == found->n, "%zu samples, %zu", n, found->n);
    FF_CHECK_CLOSE(found->mean, sum / data, 1e-9, 1e-12);
    FF_CHECK_CLOSE(found->rms, sqrt(square / weights) / (data / weights), 1e-9, 1e-12);
}

/* Samples that count differently: those with few in their band too. */
static void bands_of_weighted_samples(void)
{
    const fit_surface s = fit_surface_make("ggx/v-cavity+lambert", 1, plain_surface);
    const fit_sampling how = {.n = 4000, .max_theta = 80, .noise = 0.1, .seed = 5};
    ff_fit_options o = fit_options();
    ff_error err = {0};
    ff_bands b;
    measured m;
    ff_table t = fit_measure(&s, &how);
    t.weight = malloc(t.n * sizeof *t.weight);
    if (!t.weight) exit(1);
    for (size_t i = 0; i < t.n; i++) t.weight[i] = 1 + 0.5 * (double)(i % 7);
    o.weighting = FF_WEIGHT_SOLID_ANGLE;
    if (!measure("weighted bands", t, &s.model, &o, &m)) return;
    FF_CHECK(!ff_trust_bands_into(m.p, &m.places, &o, &m.fit, &b, &err), "%s", err.message);
    for (size_t k = 2; k < 7; k++) band_by_hand(&m, k, &b.band[FF_PLACE_THETA_I][k]);
    forget(&m);
}

/* Smith's masking seen through V-cavities: for light from grazing directions the lobe of V-cavities leaves too low, towards the
 * horizon (Heitz 2014, section 6.2 and figure 8): too much at large theta_d, too little at small ones, and the mean height of what
 * is reflected too small. */
static void bands_of_angles(void)
{
    const fit_surface s = fit_surface_make("ggx/smith-height-correlated", 1, "alpha=0.5 f0=1");
    const fit_sampling how = {.n = 20000, .max_theta = 85, .seed = 2};
    ff_fit_options o = fit_options();
    o.max_theta = 85 * FIT_DEGREE;
    ff_error err = {0};
    ff_model v_cavity;
    ff_bands b;
    measured m;
    FF_CHECK(!ff_model_parse("ggx/v-cavity", &v_cavity, &err), "%s", err.message);
    if (!measure("bands", fit_measure(&s, &how), &v_cavity, &o, &m)) return;
    FF_CHECK(!ff_trust_bands_into(m.p, &m.places, &o, &m.fit, &b, &err), "%s", err.message);
    printf("v-cavity on Smith data, alpha %.3f, mean by theta_i:", m.fit.shape_value[0].value);
    for (int k = 0; k < FF_BANDS; k++) printf(" %+.1f%%", 100 * b.band[FF_PLACE_THETA_I][k].mean);
    printf("\n");
    band_by_hand(&m, 4, &b.band[FF_PLACE_THETA_I][4]);
    printf("                                      by theta_d:");
    for (int k = 0; k < FF_BANDS; k++) printf(" %+.1f%%", 100 * b.band[FF_PLACE_THETA_D][k].mean);
    printf("\n");
    FF_CHECK(b.band[FF_PLACE_THETA_D][1].mean < -0.1 && b.band[FF_PLACE_THETA_D][7].mean > 0.05,
             "V-cavities do not show by theta_d");
    FF_CHECK(b.band[FF_PLACE_THETA_I][1].mean < -0.1 && b.band[FF_PLACE_THETA_I][8].mean > 0.05,
             "V-cavities do not show by theta_i");
    FF_CHECK(lobe_height(&m, NULL) > 1.05 * lobe_height(&m, &m.fit), "the lobe from grazing light has the height %g, the data's %g",
             lobe_height(&m, &m.fit), lobe_height(&m, NULL));
    forget(&m);
}

static void residual_tables(void)
{
    const ff_fit_options o = fit_options();
    ff_error err = {0};
    measured m;
    ff_table r;
    if (!scan("residual table", "ggx+lambert", plain_surface, usual_scan, &o, &m)) return;
    double *f = malloc(m.places.n * sizeof *f);
    FF_CHECK(f && !ff_trust_evaluate(m.p, &o, &m.fit, f, NULL, NULL, &err), "%s", err.message);
    FF_CHECK(!ff_trust_residual_table_into(m.p, &m.t, &o, &m.fit, &r, &err), "%s", err.message);
    FF_CHECK(r.n == m.t.n && r.n_invalid == m.t.n - m.places.n, "%zu samples, %zu invalid", r.n, r.n_invalid);
    size_t valid = 0;
    for (size_t i = 0; i < r.n; i++) valid += r.valid[i];
    FF_CHECK(valid == m.places.n, "%zu valid, %zu used", valid, m.places.n);
    for (size_t i = 0; i < m.places.n; i++) {
        const size_t at = ff_problem_index(m.p)[i];
        FF_CHECK_CLOSE(r.value[at], f[i] - m.t.value[at], 1e-12, 1e-14);
        FF_CHECK(r.angle[0][at] == m.t.angle[0][at] && r.angle[3][at] == m.t.angle[3][at], "directions of sample %zu", at);
    }
    free(f);
    ff_table_clear(&r);
    forget(&m);
}

/* One parameter: Welch's (1951) formulae of channels whose errors have four degrees of freedom each, as by five incidences. */
static void channels_by_welch(void)
{
    enum { N = 3 };
    static const double off[N] = {0, 0.3, -0.2}, error[N] = {0.05, 0.1, 0.2};
    const double degrees = 4, t = ff_student_quantile(0.95, degrees);
    const ff_fit_options o = fit_options();
    ff_fit_result fits[N];
    ff_difference d;
    ff_error err = {0};
    const fit_surface s = fit_surface_make("ggx/v-cavity+lambert", 1, plain_surface);
    ff_table table = scan_measure(&s, &usual_scan);
    double x[N], weight[N], sum = 0, mean = 0, square = 0, A = 0;
    for (int i = 0; i < N; i++) {
        ff_fit_options isotropic = o;
        isotropic.shape = FF_SHAPE_ISOTROPIC;
        FF_CHECK(!fit_table(&table, &s.model, &isotropic, &fits[i], NULL, &err), "%s", err.message);
        ff_fit_value *v = &fits[i].shape_value[0];
        v->value = 0.2 * exp(off[i]); /* alpha is fitted by its logarithm */
        v->std_error = error[i] * v->value;
        v->student_t = t;
        x[i] = log(v->value), weight[i] = 1 / (error[i] * error[i]);
        sum += weight[i], mean += weight[i] * x[i];
    }
    mean /= sum;
    for (int i = 0; i < N; i++) {
        square += weight[i] * (x[i] - mean) * (x[i] - mean);
        A += (1 - weight[i] / sum) * (1 - weight[i] / sum) / degrees;
    }
    const double k = N, f = square / (k - 1) / (1 + 2 * (k - 2) / (k * k - 1) * A), of_error = (k * k - 1) / (3 * A);
    FF_CHECK(!ff_trust_channels_differ_into(fits, N, &d, &err), "%s", err.message);
    FF_CHECK_CLOSE(d.chi2, square, 1e-9, 0);
    FF_CHECK_CLOSE(d.f, f, 1e-9, 0);
    FF_CHECK_CLOSE(d.error_dof, of_error, 1e-6, 0);
    FF_CHECK(d.dof == N - 1, "%zu", d.dof);
    FF_CHECK_CLOSE(d.p, ff_f_tail(f, k - 1, of_error), 1e-6, 0);
    for (int i = 0; i < N; i++) fits[i].shape_value[0].student_t = 0; /* known errors */
    FF_CHECK(!ff_trust_channels_differ_into(fits, N, &d, &err), "%s", err.message);
    FF_CHECK_CLOSE(d.p, ff_chi2_tail(square, k - 1), 1e-9, 0);
    FF_CHECK(isinf(d.error_dof), "%g", d.error_dof);
    for (int i = 0; i < N; i++) ff_fit_result_clear(&fits[i]);
    ff_table_clear(&table);
}

static void channels_that_differ(void)
{
    const ff_fit_options o = fit_options();
    for (int differ = 0; differ < 2; differ++) {
        ff_fit_result fits[3];
        ff_error err = {0};
        ff_difference d;
        for (int c = 0; c < 3; c++) {
            char words[80];
            scan_sampling how = usual_scan;
            how.seed = (uint64_t)(40 + c);
            snprintf(words, sizeof words, "alpha=%g f0=%g kd=0.1", c == 2 && differ ? 0.27 : 0.25, 0.3 + 0.2 * c);
            const fit_surface s = fit_surface_make("ggx+lambert", 1, words);
            ff_table t = scan_measure(&s, &how);
            FF_CHECK(!fit_table(&t, &s.model, &o, &fits[c], NULL, &err), "%s", err.message);
            ff_table_clear(&t);
        }
        FF_CHECK(!ff_trust_channels_differ_into(fits, 3, &d, &err), "%s", err.message);
        printf("channels of %s roughness: chi^2 %.2f with %zu degrees of freedom, p %.3g\n", differ ? "different" : "one", d.chi2,
               d.dof, d.p);
        FF_CHECK(d.dof == 6, "%zu degrees of freedom of three shapes of three parameters", d.dof);
        FF_CHECK_CLOSE(d.p, ff_f_tail(d.f, (double)d.dof, d.error_dof), 1e-12, 0);
        FF_CHECK(d.error_dof > 20 && d.error_dof < 1e5, "%g degrees of freedom of the errors", d.error_dof);
        FF_CHECK(differ ? d.p < 1e-6 : d.p > 1e-3, "p = %g", d.p);
        for (int c = 0; c < 3; c++) ff_fit_result_clear(&fits[c]);
    }
}

/* ---- outliers -------------------------------------------------------------------------------- */

/* 2 % of the values are three times too large: a robust loss with an estimated scale finds them all and the parameters; least
 * squares does not. The specular peak, where residuals are largest, is not taken for outliers. */
static void outliers(void)
{
    const fit_surface s = fit_surface_make("ggx+lambert", 1, plain_surface);
    ff_error err = {0};
    size_t planted = 0;
    ff_table t = scan_measure(&s, &usual_scan);
    for (size_t i = 25; i < t.n; i += 50) {
        if (!t.valid[i] || fmax(t.angle[0][i], fabs(t.angle[2][i])) > 79.9 * FIT_DEGREE) continue;
        t.value[i] *= 3;
        planted++;
    }
    for (int robust = FF_ROBUST_NONE; robust < FF_ROBUST_COUNT; robust++) {
        ff_fit_options o = fit_options();
        o.robust = (ff_robust)robust;
        o.robust_scale = 0;
        measured m;
        ff_table copy;
        FF_CHECK(!ff_table_copy_into(&t, &copy, &err), "%s", err.message);
        if (!measure("outliers", copy, &s.model, &o, &m)) return;
        const ff_fit_value *alpha = &m.fit.shape_value[0], *f0 = &m.fit.channel_value[0];
        const double off = fmax(fabs(alpha->value - 0.25) / alpha->std_error, fabs(f0->value - 0.5) / f0->std_error);
        printf("%s: alpha %.4f, f0 %.4f, off by %.1f of their errors", ff_robust_name(robust), alpha->value, f0->value, off);
        if (robust == FF_ROBUST_NONE) {
            ff_outliers out;
            FF_CHECK(ff_trust_outliers_into(m.p, &m.places, &o, &m.fit, &out, &err) == FF_ERR_UNSUPPORTED,
                     "outliers without a scale");
            FF_CHECK(fabs(f0->value - 0.5) > 0.01, "least squares is not misled: f0 = %g", f0->value);
            printf("\n");
        } else {
            ff_outliers out;
            size_t inside = 0;
            FF_CHECK(!ff_trust_outliers_into(m.p, &m.places, &o, &m.fit, &out, &err), "%s", err.message);
            printf(", %zu outliers of %zu planted\n", out.samples, planted);
            FF_CHECK(out.samples >= planted * 97 / 100 && out.samples <= planted + 3, "%zu found, %zu planted", out.samples,
                     planted);
            /* a loss whose influence does not fall to 0 keeps a part of what misleads */
            const double part = robust == FF_ROBUST_TUKEY ? 0 : 0.005;
            FF_CHECK(fabs(f0->value - 0.5) < part + 4 * f0->std_error &&
                         fabs(alpha->value - 0.25) < 0.5 * part + 4 * alpha->std_error,
                     "misled: f0 %g +- %g, alpha %g +- %g", f0->value, f0->std_error, alpha->value, alpha->std_error);
            for (int b = 0; b < FF_BANDS; b++) inside += out.in_band[FF_PLACE_THETA_I][b];
            FF_CHECK(inside == out.samples && out.n_worst == FF_WORST, "%zu in bands, %zu worst", inside, out.n_worst);
            for (size_t k = 0; k < out.n_worst; k++)
                FF_CHECK(out.worst[k].sample % 50 == 25 && out.worst[k].ratio < -FF_OUTLIER &&
                             (k == 0 || fabs(out.worst[k].ratio) <= fabs(out.worst[k - 1].ratio)),
                         "worst %zu: sample %u, %g", k, out.worst[k].sample, out.worst[k].ratio);
        }
        forget(&m);
    }
    ff_table_clear(&t);
}

/* The scale is that of a noise model where one is given: what lies beyond FF_OUTLIER of its standard deviations is an outlier. */
static void scale_of_a_noise_model(void)
{
    const fit_surface s = fit_surface_make("ggx+lambert", 1, plain_surface);
    for (int loss = FF_LOSS_COSINE; loss <= FF_LOSS_LOG; loss++) {
        ff_noise *noise = NULL;
        ff_fit_options o = fit_options();
        ff_error err = {0};
        measured m;
        FF_CHECK(ff_noise_parse("relative=0.05,floor=0.001,cos_o=-0.5", &noise, &err) == FF_OK, "%s", err.message);
        o.loss = (ff_loss)loss;
        o.robust = FF_ROBUST_TUKEY;
        o.noise = noise;
        ff_table t = scan_measure(&s, &usual_scan);
        size_t planted = 0;
        double expected = 0, w[6], *const planes[6] = {w, w + 1, w + 2, w + 3, w + 4, w + 5};
        while (planted < 500 || !t.valid[planted] || t.value[planted] < 0.05) planted++;
        ff_table_directions(&t, planted, 1, planes);
        t.value[planted] *= 1.5;
        const double y = t.value[planted];
        if (!measure("the scale of a noise model", t, &s.model, &o, &m)) return;
        ff_outliers out = {.size = sizeof out};
        ff_selection chosen;
        ff_problem_selection(m.p, &chosen);
        double *model = malloc(chosen.used * sizeof *model);
        FF_CHECK(model && !ff_trust_evaluate(m.p, &o, &m.fit, model, NULL, NULL, &err), "%s", err.message);
        for (size_t i = 0; i < chosen.used && model; i++)
            if (ff_problem_index(m.p)[i] == planted) {
                const double f = model[i], sd = ff_noise_sd(noise, 0, f, w[2], w[5]);
                expected = loss == FF_LOSS_COSINE ? (f - y) / sd : log1p(f * w[2]) - log1p(y * w[2]);
                if (loss == FF_LOSS_LOG) expected *= (1 + f * w[2]) / (w[2] * sd);
            }
        FF_CHECK(!ff_trust_outliers_into(m.p, &m.places, &o, &m.fit, &out, &err), "%s", err.message);
        FF_CHECK(out.n_worst > 0 && out.worst[0].sample == planted, "the worst is %u", out.n_worst ? out.worst[0].sample : 0);
        FF_CHECK_CLOSE(out.worst[0].ratio, expected, 1e-4, 0);
        free(model);
        forget(&m);
        ff_noise_free(noise);
    }
}

/* A scale given by hand: the units are those of the weighted residual. */
static void given_scale(void)
{
    ff_fit_options o = fit_options();
    o.robust = FF_ROBUST_HUBER;
    o.robust_scale = 1e9; /* none is ever beyond it */
    measured plain, wide;
    const ff_fit_options none = fit_options();
    if (scan("plain", "ggx+lambert", plain_surface, usual_scan, &none, &plain) &&
        scan("wide", "ggx+lambert", plain_surface, usual_scan, &o, &wide)) {
        FF_CHECK_CLOSE(wide.fit.residual.objective, plain.fit.residual.objective, 1e-10, 0);
        forget(&plain);
        forget(&wide);
    }
}

/* ---- known from one side --------------------------------------------------------------------- */

static void check_recovers(const char *what, const fit_surface *s, const ff_table *t, const ff_fit_options *o, int should)
{
    ff_fit_result r;
    ff_selection sel;
    ff_error err = {0};
    FF_CHECK(!fit_table(t, &s->model, o, &r, &sel, &err), "%s: %s", what, err.message);
    const double alpha = r.shape_value[0].value, f0 = r.channel_value[0].value;
    const double off = fmax(fabs(alpha / s->shape[0] - 1), fabs(f0 / s->channel[0] - 1));
    printf("%s: alpha %.4f, f0 %.4f; %zu saturated, %zu below the noise, %zu at the top\n", what, alpha, f0, sel.saturated,
           sel.below_noise, sel.at_top);
    FF_CHECK(should ? off < 0.02 : off > 0.03, "%s: off by %.3f", what, off);
    ff_fit_result_clear(&r);
}

/* A detector that stops at 2 /sr: with the saturation said, the parameters are found; without it the fit warns that something is
 * cut. */
static void saturation(void)
{
    const fit_surface s = fit_surface_make("ggx+lambert", 1, "alpha=0.12 f0=0.5 kd=0.1");
    scan_sampling how = usual_scan;
    how.noise = 0.02;
    ff_table t = scan_measure(&s, &how);
    ff_fit_options o = fit_options();
    ff_selection sel;
    ff_problem *p = NULL;
    check_recovers("not cut", &s, &t, &o, 1);
    FF_CHECK(!ff_problem_make(&t, &s.model, 1, &o, &p, NULL), "problem");
    ff_problem_selection(p, &sel);
    FF_CHECK(sel.at_top == 0, "%zu samples at the top of data that are not cut", sel.at_top);
    ff_problem_free(p);
    for (size_t i = 0; i < t.n; i++) t.value[i] = fmin(t.value[i], 2);
    check_recovers("cut at 2 /sr", &s, &t, &o, 0);
    FF_CHECK(!ff_problem_make(&t, &s.model, 1, &o, &p, NULL), "problem");
    ff_problem_selection(p, &sel);
    FF_CHECK(sel.at_top > 20 && sel.top == 2, "%zu samples at %g", sel.at_top, sel.top);
    ff_problem_free(p);
    o.saturation = 2;
    check_recovers("cut at 2 /sr, and said so", &s, &t, &o, 1);
    ff_table_clear(&t);
}

/* Relative residuals of values that are lost in an offset of the detector: a noise floor keeps them from deciding. */
static void noise_floor(void)
{
    const fit_surface s = fit_surface_make("ggx", 1, "alpha=0.12 f0=0.5");
    scan_sampling how = usual_scan;
    how.noise = 0.02;
    ff_table t = scan_measure(&s, &how);
    ff_fit_options o = fit_options();
    o.loss = FF_LOSS_RELATIVE;
    for (size_t i = 0; i < t.n; i++) t.value[i] += 0.004;
    check_recovers("an offset of 0.004 /sr", &s, &t, &o, 0);
    o.noise_floor = 0.2;
    check_recovers("an offset, and a noise floor of 0.2 /sr", &s, &t, &o, 1);
    ff_table_clear(&t);
}

static void negative_samples(void)
{
    const fit_surface s = fit_surface_make("ggx+lambert", 1, plain_surface);
    ff_table t = scan_measure(&s, &usual_scan);
    ff_fit_options o = fit_options();
    ff_selection kept, dropped;
    ff_problem *p = NULL;
    for (size_t i = 0; i < t.n; i += 97) t.value[i] = -0.001;
    FF_CHECK(!ff_problem_make(&t, &s.model, 1, &o, &p, NULL), "problem");
    ff_problem_selection(p, &kept);
    ff_problem_free(p);
    o.drop_negative = 1;
    FF_CHECK(!ff_problem_make(&t, &s.model, 1, &o, &p, NULL), "problem");
    ff_problem_selection(p, &dropped);
    ff_problem_free(p);
    FF_CHECK(kept.negative > 10 && kept.dropped == 0, "%zu negative, %zu dropped", kept.negative, kept.dropped);
    FF_CHECK(dropped.dropped == kept.negative && dropped.used + dropped.dropped == kept.used, "%zu dropped of %zu, %zu used of %zu",
             dropped.dropped, kept.negative, dropped.used, kept.used);
    ff_table_clear(&t);
}

static void wrong_options(void)
{
    const fit_surface s = fit_surface_make("ggx+lambert", 1, plain_surface);
    ff_table t = scan_measure(&s, &usual_scan);
    ff_problem *p = NULL;
    ff_error err = {0};
    for (int k = 0; k < 4; k++) {
        ff_fit_options o = fit_options();
        if (k == 0) o.saturation = NAN;
        if (k == 1) o.noise_floor = 3, o.saturation = 2;
        if (k == 2) o.noise_sigmas = -1;
        if (k == 3) o.noise_sigmas = 2; /* no standard deviations there */
        FF_CHECK(ff_problem_make(&t, &s.model, 1, &o, &p, &err) == (k == 3 ? FF_ERR_UNSUPPORTED : FF_ERR_RANGE) && !p, "%d: %s", k,
                 err.message);
    }
    ff_table_clear(&t);
}

FF_TEST_MAIN(FF_TEST(quantiles), FF_TEST(effective_number), FF_TEST(misfit_of_scattered_samples),
             FF_TEST(known_noise_that_goes_together), FF_TEST(places_of_samples), FF_TEST(profiles), FF_TEST(two_on_their_bounds),
             FF_TEST(ends_of_profiles), FF_TEST(not_determined), FF_TEST(errors_by_refits), FF_TEST(bootstraps),
             FF_TEST(bootstrap_of_losses), FF_TEST(bootstrap_on_a_bound), FF_TEST(cut_offs), FF_TEST(comparisons),
             FF_TEST(comparison_by_hand), FF_TEST(size_and_power_of_the_test), FF_TEST(validation_by_hand),
             FF_TEST(bands_of_angles), FF_TEST(bands_of_weighted_samples), FF_TEST(residual_tables), FF_TEST(channels_by_welch),
             FF_TEST(channels_that_differ), FF_TEST(outliers), FF_TEST(given_scale), FF_TEST(scale_of_a_noise_model),
             FF_TEST(saturation), FF_TEST(noise_floor), FF_TEST(negative_samples), FF_TEST(wrong_options))
