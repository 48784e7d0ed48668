/* Which masking made these data? The one they were simulated under must have the lowest objective of all. */
#include "fit_samples.h"

enum { MAX_MASKINGS = 16 };

/* Every masking that goes with the distribution and the shape, but those that exist for the furnace test: indices into the
 * registry. */
static size_t maskings(const char *ndf, ff_shape shape, int *out)
{
    size_t n = 0;
    for (size_t m = 0; m < ff_term_count(FF_MASKING); m++) {
        const ff_term *t = ff_term_at(FF_MASKING, m);
        ff_model model;
        if ((t->claims & FF_FURNACE_ONLY) || n == MAX_MASKINGS) continue;
        if ((t->claims & FF_ISOTROPIC) && shape != FF_SHAPE_ISOTROPIC) continue;
        if (ff_model_compose(ff_term_find(FF_NDF, ndf), (int)m, 0, -1, &model, NULL) == FF_OK) out[n++] = (int)m;
    }
    return n;
}

/* Objectives of the same samples under every masking. */
static void compare(const ff_table *t, const int *masking, size_t n, const char *ndf, ff_shape shape, double *objective)
{
    ff_model model[MAX_MASKINGS];
    ff_problem *p = NULL;
    ff_error err = {0};
    ff_fit_options o = fit_options();
    o.shape = shape;
    o.std_errors = 0;
    for (size_t i = 0; i < n; i++) {
        const ff_status status = ff_model_compose(ff_term_find(FF_NDF, ndf), masking[i], ff_term_find(FF_FRESNEL, "schlick"),
                                                  ff_term_find(FF_DIFFUSE, "lambert"), &model[i], &err);
        FF_CHECK(status == FF_OK, "%s", err.message);
        objective[i] = INFINITY;
    }
    const ff_status status = ff_problem_make(t, model, n, &o, &p, &err);
    FF_CHECK(status == FF_OK, "%s", err.message);
    if (status) return;
    for (size_t i = 0; i < n; i++) {
        ff_fit_result r;
        const ff_status fitted = ff_problem_fit_into(p, &model[i], &o, &r, &err);
        FF_CHECK(fitted == FF_OK, "%s", err.message);
        if (fitted) continue;
        FF_CHECK(r.outcome == FF_CONVERGED, "%s: %s", ff_term_at(FF_MASKING, (size_t)masking[i])->name,
                 ff_outcome_name((int)r.outcome));
        objective[i] = r.residual.objective;
        ff_fit_result_clear(&r);
    }
    ff_problem_free(p);
}

static void identify(const char *ndf, const char *set, ff_shape shape, size_t samples)
{
    int masking[MAX_MASKINGS];
    double objective[MAX_MASKINGS];
    const size_t n = maskings(ndf, shape, masking);
    for (size_t truth = 0; truth < n; truth++) {
        char expression[128];
        snprintf(expression, sizeof expression, "%s/%s+lambert", ndf, ff_term_at(FF_MASKING, (size_t)masking[truth])->name);
        const fit_surface s = fit_surface_make(expression, 3, set);
        const fit_sampling how = {.n = samples, .max_theta = 80, .noise = 0.02, .seed = 7 + truth};
        ff_table t = fit_measure(&s, &how);
        compare(&t, masking, n, ndf, shape, objective);
        ff_table_clear(&t);
        size_t best = 0, next = n;
        for (size_t i = 1; i < n; i++)
            if (objective[i] < objective[best]) best = i;
        for (size_t i = 0; i < n; i++)
            if (i != truth && (next == n || objective[i] < objective[next])) next = i;
        const char *name = ff_term_at(FF_MASKING, (size_t)masking[truth])->name,
                   *found = ff_term_at(FF_MASKING, (size_t)masking[best])->name,
                   *second = ff_term_at(FF_MASKING, (size_t)masking[next])->name;
        FF_CHECK(best == truth, "%s %s: simulated under %s, lowest objective under %s", ndf, set, name, found);
        printf("%-9s %-46.46s %-34s next: %-34s objective x %.4g\n", ndf, set, name, second, objective[next] / objective[truth]);
    }
}

static void ggx(void)
{
    identify("ggx", "alpha=0.4 f0=0.9:0.6:0.3 kd=0.1:0.05:0.02", FF_SHAPE_ISOTROPIC, 20000);
    identify("ggx", "alpha=0.8 f0=0.9:0.6:0.3 kd=0.1:0.05:0.02", FF_SHAPE_ISOTROPIC, 20000);
}

static void beckmann(void)
{
    /* Within 80 degrees a Beckmann surface of alpha 0.4 hides little from any Smith form: 20,000 samples name the wrong one in one
     * of six. */
    identify("beckmann", "alpha=0.4 f0=0.9:0.6:0.3 kd=0.1:0.05:0.02", FF_SHAPE_ISOTROPIC, 100000);
    identify("beckmann", "alpha=0.8 f0=0.9:0.6:0.3 kd=0.1:0.05:0.02", FF_SHAPE_ISOTROPIC, 20000);
}

static void correlated(void)
{
    identify("ggx", "alpha_x=0.4 alpha_y=0.6 r_xy=0.3 f0=0.9:0.6:0.3", FF_SHAPE_CORRELATED, 20000);
    identify("beckmann", "alpha_x=0.4 alpha_y=0.6 r_xy=0.3 f0=0.9:0.6:0.3", FF_SHAPE_CORRELATED, 20000);
}

FF_TEST_MAIN(FF_TEST(ggx), FF_TEST(beckmann), FF_TEST(correlated))
