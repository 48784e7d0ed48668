/* What the notes of models say does not hold in some use: computed here, so that the notes are right and stay so. */
#include "fit_samples.h"
#include "models/internal_model.h"
#include "models/tools/ff_albedo.h"

/* The largest |f(wi, wo) - f(wo, wi)| / f over random pairs of directions. */
static double asymmetry(const fit_surface *s)
{
    enum { N = 400 };
    double w[6][N], one[N], other[N], most = 0;
    for (size_t i = 0; i < N; i++)
        for (size_t d = 0; d < 2; d++) {
            const double z = 0.2 + 0.8 * ff_test_uniform(), phi = 360 * FIT_DEGREE * ff_test_uniform(), r = sqrt(1 - z * z);
            w[3 * d][i] = r * cos(phi), w[3 * d + 1][i] = r * sin(phi), w[3 * d + 2][i] = z;
        }
    const ff_dirs forth = {w[0], w[1], w[2], w[3], w[4], w[5]}, back = {w[3], w[4], w[5], w[0], w[1], w[2]};
    const ff_status status = ff_model_eval(&s->model, FF_ISA_BEST, 1, s->shape, s->channel, &forth, N, one, NULL, N);
    FF_CHECK(!status && !ff_model_eval(&s->model, FF_ISA_BEST, 1, s->shape, s->channel, &back, N, other, NULL, N), "no value");
    for (size_t i = 0; i < N && !status; i++) most = fmax(most, fabs(one[i] - other[i]) / fmax(one[i], 1e-9));
    return most;
}

/* With a mean slope light and detector cannot be exchanged, and the parameter's meaning says so; without they can. */
static void mean_slope(void)
{
    static const char *const expressions[] = {"ggx", "beckmann", "student-t"};
    for (size_t k = 0; k < sizeof expressions / sizeof *expressions; k++) {
        const fit_surface level = fit_surface_make(expressions[k], 1, "alpha=0.4 f0=0.5"),
                          tilted = fit_surface_make(expressions[k], 1, "alpha=0.4 f0=0.5 slope_x=0.2");
        FF_CHECK(asymmetry(&level) < 1e-12, "%s: %g without a slope", expressions[k], asymmetry(&level));
        FF_CHECK(asymmetry(&tilted) > 0.01, "%s: %g with a slope", expressions[k], asymmetry(&tilted));
        FF_CHECK(!(ff_model_claims(&tilted.model, tilted.shape) & FF_RECIPROCAL), "%s claims it", expressions[k]);
        const ff_model_param *p = ff_model_param_at(&tilted.model, ff_model_param_find(&tilted.model, "slope_x"));
        FF_CHECK(strstr(p->info->meaning, "not reciprocal") != NULL, "'%s' does not say so", p->info->meaning);
    }
}

/* shirley-coupled counts the light of a lobe as that of a smooth one: above a rough one the sum is more than arrives. */
static void shirley_coupled(void)
{
    const fit_surface s = fit_surface_make("beckmann+shirley-coupled", 1, "alpha=0.2 f0=0.04 kd=1");
    const double wo[3] = {0.8, 0, 0.6};
    ff_integral albedo;
    ff_error err = {0};
    const ff_status status = ff_albedo_directional(&s.model, FF_ISA_BEST, 1, s.shape, s.channel, wo, &albedo, &err);
    FF_CHECK(status == FF_OK, "%s", err.message);
    FF_CHECK_CLOSE(albedo.value, 1.0044, 0, 5e-5);
    FF_CHECK(!(ff_model_claims(&s.model, s.shape) & FF_PASSIVE), "the sum claims to be passive");
    const ff_term *t = ff_term_at(FF_DIFFUSE, (size_t)ff_term_find(FF_DIFFUSE, "shirley-coupled"));
    FF_CHECK(strstr(t->note, "not passive") && strstr(t->note, "1.0044"), "'%s' does not say so", t->note);
}

FF_TEST_MAIN(FF_TEST(mean_slope), FF_TEST(shirley_coupled))
