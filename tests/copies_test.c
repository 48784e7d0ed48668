/* Samples that are there twice: the fit is that of the file without them, errors and all; measurements that are repeated count. */
#include "fit_samples.h"
#include "warnings.h"

enum { N = 400 };

/* The first n samples of t, n_times over, the copies moved apart or together; values of copies times 1 + noise. */
static ff_table repeated(const ff_table *t, size_t times, int together, double noise)
{
    ff_table out;
    if (ff_table_init(times * t->n, t->n_channels, NULL, 0, 0, &out, NULL)) exit(1);
    out.radians_per_unit = t->radians_per_unit;
    for (size_t i = 0; i < out.n; i++) {
        const size_t from = together ? i / times : i % t->n, copy = together ? i % times : i / t->n;
        for (int k = 0; k < 4; k++) out.angle[k][i] = t->angle[k][from];
        for (size_t c = 0; c < t->n_channels; c++)
            out.value[c * out.n + i] = t->value[c * t->n + from] * (1 + (copy ? noise * (double)copy : 0));
    }
    return out;
}

static ff_fit_result fit(const ff_table *t, ff_selection *s)
{
    ff_model m;
    ff_error err = {0};
    ff_fit_result r;
    const ff_fit_options o = fit_options();
    if (ff_model_parse("ggx+lambert", &m, &err) || fit_table(t, &m, &o, &r, s, &err)) {
        printf("the test itself is wrong: %s\n", err.message);
        exit(1);
    }
    return r;
}

static ff_table measured(void)
{
    const fit_surface s = fit_surface_make("ggx+lambert", 2, "alpha=0.25 f0=0.3:0.5 kd=0.2");
    const fit_sampling how = {.n = N, .max_theta = 70, .glossy = 0.4, .noise = 0.05, .seed = 11};
    return fit_measure(&s, &how);
}

static void same_answer(void)
{
    ff_table once = measured();
    ff_selection s;
    ff_fit_result r = fit(&once, &s);
    FF_CHECK(s.copies == 0 && !has_warning(&r, FF_WARNING_COPIES, NULL), "%zu copies of nothing", s.copies);
    for (int together = 0; together < 2; together++)
        for (size_t times = 2; times < 5; times++) {
            ff_table more = repeated(&once, times, together, 0);
            ff_selection many;
            ff_fit_result q = fit(&more, &many);
            const ff_warning *w = find_warning(&q, FF_WARNING_COPIES, NULL);
            FF_CHECK(many.used == s.used && many.copies == (times - 1) * s.used && w && w->value[0] == (double)many.copies,
                     "%zu used, %zu copies", many.used, many.copies);
            for (size_t k = 0; k < r.model.n_shape; k++) {
                FF_CHECK_CLOSE(q.shape_value[k].value, r.shape_value[k].value, 1e-12, 1e-12);
                if (r.shape_value[k].std_error > 0) FF_CHECK_CLOSE(q.shape_value[k].std_error, r.shape_value[k].std_error, 1e-9, 0);
            }
            ff_fit_result_clear(&q);
            ff_table_clear(&more);
        }
    ff_fit_result_clear(&r);
    ff_table_clear(&once);
}

static void measured_again(void)
{
    ff_table once = measured(), more = repeated(&once, 3, 0, 0.01);
    ff_selection s;
    ff_fit_result r = fit(&more, &s);
    FF_CHECK(s.copies == 0 && s.used == 3 * N, "%zu of %d measurements are called copies", s.copies, 3 * N);
    ff_fit_result_clear(&r);
    /* one of them agrees with the first: a measurement all the same, since a third one does not */
    memcpy(more.value + N, more.value, N * sizeof *more.value);
    memcpy(more.value + more.n + N, more.value + more.n, N * sizeof *more.value);
    r = fit(&more, &s);
    FF_CHECK(s.copies == 0, "%zu measurements are called copies", s.copies);
    ff_fit_result_clear(&r);
    ff_table_clear(&more);
    ff_table_clear(&once);
}

FF_TEST_MAIN(FF_TEST(same_answer), FF_TEST(measured_again))
