/* The same answer from every instruction set, up to rounding, and the same bits from any number of threads and in every run. */
#include "model_samples.h"
#include "warnings.h"

static const ff_isa isas[] = {FF_ISA_SCALAR, FF_ISA_AVX2, FF_ISA_AVX512, FF_ISA_BEST};
enum { ISAS = sizeof isas / sizeof *isas };

static void names(void)
{
    FF_CHECK(ff_isa_available(FF_ISA_BEST) == 1 && ff_isa_available(FF_ISA_SCALAR) == 1, "the baseline is always there");
    FF_CHECK(ff_isa_find("best") == FF_ISA_BEST && ff_isa_find("sse9") == -1 && ff_isa_find("") == -1, "names");
    FF_CHECK(ff_isa_available((ff_isa)99) == 0 && ff_isa_available((ff_isa)-1) == 0, "a set that does not exist");
    for (int isa = FF_ISA_SCALAR; isa <= FF_ISA_AVX512; isa++)
        FF_CHECK(ff_isa_find(ff_isa_name((ff_isa)isa)) == isa, "%s", ff_isa_name((ff_isa)isa));
    const int best = ff_isa_find(ff_isa_name(FF_ISA_BEST));
    FF_CHECK(best > FF_ISA_BEST && ff_isa_available((ff_isa)best), "the best is '%s'", ff_isa_name(FF_ISA_BEST));
    for (int isa = best + 1; isa <= FF_ISA_AVX512; isa++)
        FF_CHECK(!ff_isa_available((ff_isa)isa), "%s is wider than the best", ff_isa_name((ff_isa)isa));
    printf("  best: %s\n", ff_isa_name(FF_ISA_BEST));
}

static void unavailable_sets_are_refused(void)
{
    const fit_surface s = fit_surface_make("ggx", 1, "");
    const double up = 1, zero = 0;
    const ff_dirs w = {&zero, &zero, &up, &zero, &zero, &up};
    for (int isa = FF_ISA_SCALAR; isa <= 9; isa++) {
        double f = 4711, d = 4711;
        const ff_terms terms = {.d = &d};
        const ff_status expected = ff_isa_available((ff_isa)isa) ? FF_OK : FF_ERR_UNSUPPORTED;
        FF_CHECK(ff_model_eval(&s.model, (ff_isa)isa, 1, s.shape, s.channel, &w, 1, &f, NULL, 1) == expected, "set %d", isa);
        FF_CHECK(ff_model_terms(&s.model, (ff_isa)isa, 1, s.shape, s.channel, 0, 0, &w, 1, &terms) == expected, "set %d", isa);
        FF_CHECK(expected == FF_OK || (f == 4711 && d == 4711), "set %d was refused, yet wrote its output", isa);
    }
}

/* ---- evaluation ------------------------------------------------------------------------------ */

enum { CHANNELS = 2, PARAMS = FF_MAX_SHAPE + FF_MAX_CHANNEL_PARAMS };

/* Largest deviation of a from b relative to |b| + floor, floor = scale[i mod period] or 0; infinite where one is NaN. */
static double deviation(const double *a, const double *b, const double *scale, size_t n, size_t period)
{
    double worst = 0;
    for (size_t i = 0; i < n; i++) {
        const double floor = scale ? scale[i % period] : 0, d = a[i] == b[i] ? 0 : fabs(a[i] - b[i]) / (fabs(b[i]) + floor);
        if (isnan(d)) return HUGE_VAL;
        worst = fmax(worst, d);
    }
    return worst;
}

static void evaluations(void)
{
    static model_pairs w;
    static double f[2][CHANNELS * MODEL_PAIRS], df[2][CHANNELS * PARAMS * MODEL_PAIRS], terms[2][5][MODEL_PAIRS];
    double worst[2] = {0, 0};
    for (size_t k = 0; k < model_combination_count(); k++) {
        char label[MODEL_LABEL];
        fit_surface s = {.n_channels = CHANNELS};
        s.model = model_combination(k, label);
        const size_t n_params = s.model.n_shape + s.model.n_channel;
        uint64_t state = ff_test_stream("instruction sets %s", label);
        model_random_parameters(&s.model, CHANNELS, (model_freedom)model_turn(label, 3), 0.4, &state, s.shape, s.channel);
        w.n = 0;
        model_pairs_random(&s.model, s.shape, &state, 301, &w);
        const ff_dirs dirs = model_dirs(&w);
        const double floor = model_floor(&s.model);
        for (int i = 0; i < ISAS; i++) {
            const int to = i > 0;
            if (!ff_isa_available(isas[i])) continue;
            const ff_terms out = {terms[to][0], terms[to][1], terms[to][2], terms[to][3], terms[to][4]};
            FF_CHECK(ff_model_eval(&s.model, isas[i], CHANNELS, s.shape, s.channel, &dirs, w.n, f[to], df[to], w.n) == FF_OK, "%s",
                     label);
            FF_CHECK(ff_model_terms(&s.model, isas[i], CHANNELS, s.shape, s.channel, 0, 1, &dirs, w.n, &out) == FF_OK, "%s", label);
            if (!to) continue;
            const double of_f = deviation(f[1], f[0], &floor, CHANNELS * w.n, 1);
            for (size_t q = 0; q < CHANNELS * w.n; q++) f[0][q] += floor;
            FF_CHECK(of_f <= 1e-12, "%s: f of %s deviates by %.3g", label, ff_isa_name(isas[i]), of_f);
            for (size_t c = 0; c < CHANNELS; c++) { /* a derivative may vanish: f is the scale that it is small against */
                const double of_df =
                    deviation(df[1] + c * n_params * w.n, df[0] + c * n_params * w.n, f[0] + c * w.n, n_params * w.n, w.n);
                FF_CHECK(of_df <= 1e-11, "%s: df of %s deviates by %.3g", label, ff_isa_name(isas[i]), of_df);
                worst[1] = fmax(worst[1], of_df);
            }
            for (size_t q = 0; q < CHANNELS * w.n; q++) f[0][q] -= floor;
            for (int t = 0; t < 5; t++) { /* a Lambda is small against the 1 beside it */
                double ones[MODEL_PAIRS];
                for (size_t q = 0; q < w.n; q++) ones[q] = t == 1 || t == 2 ? 1 : 0;
                const double of_term = deviation(terms[1][t], terms[0][t], ones, w.n, w.n);
                FF_CHECK(of_term <= 1e-12, "%s: factor %d of %s deviates by %.3g", label, t, ff_isa_name(isas[i]), of_term);
            }
            worst[0] = fmax(worst[0], of_f);
        }
    }
    printf("  worst: f %.1e, df %.1e\n", worst[0], worst[1]);
}

/* The comparison above sees a difference in the twelfth digit. */
static void differences_are_seen(void)
{
    const double a[] = {1, 2e-200, 0}, b[] = {1 + 2e-12, 2e-200, 0}, c[] = {1, 2.1e-200, 0}, d[] = {1, 2e-200, 1e-300},
                 e[] = {1, NAN, 0};
    FF_CHECK(deviation(a, a, NULL, 3, 1) == 0 && deviation(b, a, NULL, 3, 1) > 1e-12 && deviation(c, a, NULL, 3, 1) > 1e-12,
             "values");
    FF_CHECK(deviation(d, a, NULL, 3, 1) > 1e-12 && deviation(e, a, NULL, 3, 1) > 1e-12, "zero and NaN");
}

/* ---- fits ------------------------------------------------------------------------------------ */

typedef struct trial {
    const char *expression, *truth;
    size_t n;
    ff_loss loss;
    ff_robust robust;
    ff_shape shape;
} trial;

static const trial trials[] = {
    {"ggx+lambert", "alpha_x=0.2 alpha_y=0.45 r_xy=0.4 f0=0.9:0.6:0.3 kd=0.1:0.05:0.02", 20000, FF_LOSS_COSINE, FF_ROBUST_NONE,
     FF_SHAPE_CORRELATED},
    {"student-t/smith-separable+lambert", "alpha=0.3 gamma=2.6 f0=0.5 kd=0.1", 9000, FF_LOSS_LOG, FF_ROBUST_CAUCHY,
     FF_SHAPE_ISOTROPIC},
    {"phong/v-cavity+lambert", "n=30 f0=0.5:0.3:0.6 kd=0.2", 9000, FF_LOSS_CUBE_ROOT, FF_ROBUST_HUBER, FF_SHAPE_ISOTROPIC},
};
enum { TRIALS = sizeof trials / sizeof *trials };

static ff_fit_options options_of(const trial *t)
{
    ff_fit_options o = fit_options();
    o.loss = t->loss;
    o.robust = t->robust;
    o.robust_scale = 0.05;
    o.shape = t->shape;
    return o;
}

static ff_table measured(const trial *t, ff_model *m)
{
    const fit_surface s = fit_surface_make(t->expression, 3, t->truth);
    const fit_sampling how = {.n = t->n, .max_theta = 80, .glossy = 0.5, .noise = 0.05, .seed = 52};
    *m = s.model;
    return fit_measure(&s, &how);
}

static ff_fit_result fitted(const ff_table *t, const ff_model *m, const ff_fit_options *o)
{
    ff_fit_result r;
    ff_error err = {0};
    memset(&r, 0, sizeof r);
    FF_CHECK(fit_table(t, m, o, &r, NULL, &err) == FF_OK, "%s", err.message);
    return r;
}

static int same_value(const ff_fit_value *a, const ff_fit_value *b)
{
    return memcmp(&a->value, &b->value, sizeof a->value) == 0 && memcmp(&a->std_error, &b->std_error, sizeof a->std_error) == 0 &&
           a->at_bound == b->at_bound && a->held == b->held && a->tied == b->tied && a->column == b->column;
}

/* Everything that a fit says but the time it took: 1 when all bits are the same. */
static int same_fit(const ff_fit_result *a, const ff_fit_result *b)
{
    const size_t n_channel = a->n_channels * a->model.n_channel;
    int same = a->outcome == b->outcome && a->iterations == b->iterations && a->passes == b->passes &&
               a->n_columns == b->n_columns && a->n_free == b->n_free;
    for (size_t k = 0; k < a->model.n_shape; k++) same &= same_value(&a->shape_value[k], &b->shape_value[k]);
    for (size_t k = 0; k < n_channel; k++) same &= same_value(&a->channel_value[k], &b->channel_value[k]);
    same = same && memcmp(a->correlation, b->correlation, a->n_columns * a->n_columns * sizeof *a->correlation) == 0;
    same = same && memcmp(&a->residual, &b->residual, sizeof a->residual) == 0 && memcmp(&a->aic, &b->aic, sizeof a->aic) == 0;
    same = same && memcmp(&a->bic, &b->bic, sizeof a->bic) == 0 && a->warnings.n == b->warnings.n;
    for (size_t k = 0; same && k < a->warnings.n; k++) same &= same_warning(&a->warnings.item[k], &b->warnings.item[k]);
    return same;
}

static void threads_do_not_matter(void)
{
    for (int k = 0; k < TRIALS; k++) {
        ff_model m;
        ff_table t = measured(&trials[k], &m);
        ff_fit_options o = options_of(&trials[k]);
        o.threads = 1;
        ff_fit_result one = fitted(&t, &m, &o);
        for (int threads = 1; threads <= 3; threads++) { /* 1: the same run again */
            o.threads = threads;
            ff_fit_result r = fitted(&t, &m, &o);
            FF_CHECK(same_fit(&one, &r), "%s: other bits with %d threads", trials[k].expression, threads);
            ff_fit_result_clear(&r);
        }
        /* a fit that differs in one bit is seen */
        ff_fit_result r = fitted(&t, &m, &o);
        r.channel_value[0].std_error = nextafter(r.channel_value[0].std_error, HUGE_VAL);
        FF_CHECK(!same_fit(&one, &r), "%s: a changed standard error was not seen", trials[k].expression);
        ff_fit_result_clear(&r);
        ff_fit_result_clear(&one);
        ff_table_clear(&t);
    }
}

/* The larger problem takes a middle step on a part of its samples. */
static void threads_do_not_matter_for_many_samples(void)
{
    const trial many = {"ggx+lambert", "alpha=0.3 f0=0.7 kd=0.1", 210000, FF_LOSS_COSINE, FF_ROBUST_NONE, FF_SHAPE_ISOTROPIC};
    ff_model m;
    ff_table t = measured(&many, &m);
    ff_fit_options o = options_of(&many);
    o.threads = 1;
    ff_fit_result one = fitted(&t, &m, &o);
    for (int threads = 2; threads <= 3; threads++) {
        o.threads = threads;
        ff_fit_result r = fitted(&t, &m, &o);
        FF_CHECK(same_fit(&one, &r), "other bits with %d threads", threads);
        ff_fit_result_clear(&r);
    }
    ff_fit_result_clear(&one);
    ff_table_clear(&t);
}

static void fits_of_every_set(void)
{
    double worst = 0, worst_error = 0;
    for (int k = 0; k < TRIALS; k++) {
        ff_model m;
        ff_table t = measured(&trials[k], &m);
        ff_fit_options o = options_of(&trials[k]);
        o.isa = FF_ISA_SCALAR;
        ff_fit_result scalar = fitted(&t, &m, &o);
        for (int i = 1; i < ISAS; i++) {
            if (!ff_isa_available(isas[i])) continue;
            o.isa = isas[i];
            ff_fit_result r = fitted(&t, &m, &o);
            for (size_t q = 0; q < fit_parameter_count(&r); q++) {
                double truth;
                char name[64];
                const ff_fit_value *a = fit_parameter(&r, q, NULL, &truth, name),
                                   *b = fit_parameter(&scalar, q, NULL, &truth, name);
                if (!a || !b) continue;
                const double d = fabs(a->value - b->value) / fabs(b->value), e = fabs(a->std_error - b->std_error) / b->std_error;
                FF_CHECK(d <= 1e-9, "%s, %s: %s is %.15g, by scalar %.15g", trials[k].expression, ff_isa_name(isas[i]), name,
                         a->value, b->value);
                FF_CHECK(e <= 1e-7, "%s, %s: standard error of %s is %.15g, by scalar %.15g", trials[k].expression,
                         ff_isa_name(isas[i]), name, a->std_error, b->std_error);
                worst = fmax(worst, d), worst_error = fmax(worst_error, e);
            }
            FF_CHECK_CLOSE(r.residual.objective, scalar.residual.objective, 1e-12, 0);
            ff_fit_result_clear(&r);
        }
        ff_fit_result_clear(&scalar);
        ff_table_clear(&t);
    }
    printf("  worst: values %.1e, standard errors %.1e\n", worst, worst_error);
}

FF_TEST_MAIN(FF_TEST(names), FF_TEST(unavailable_sets_are_refused), FF_TEST(evaluations), FF_TEST(differences_are_seen),
             FF_TEST(threads_do_not_matter), FF_TEST(threads_do_not_matter_for_many_samples), FF_TEST(fits_of_every_set))
