/* Weak white furnace of every distribution and masking that claims it, and albedo against published and closed values. Both run
 * through the kernels, so that a wrong D, Lambda, G or projected area shows here. */
#include "ff_test.h"
#include "ff_albedo.h"

#define PI 3.14159265358979323846
enum { SETTINGS = 512 };

typedef struct lobe {
    ff_model model;
    double shape[FF_MAX_SHAPE], channel[4 * FF_MAX_CHANNEL_PARAMS];
    size_t n_channels;
} lobe;

/* The model of an expression with "name=value name=value ..." applied; parameters that it lacks are an error. */
static lobe lobe_make(const char *expression, size_t n_channels, const char *settings)
{
    lobe l = {.n_channels = n_channels};
    ff_error err = {0};
    char text[SETTINGS], *rest = text;
    snprintf(text, sizeof text, "%s", settings);
    FF_CHECK(ff_model_parse(expression, &l.model, &err) == FF_OK, "%s: %s", expression, err.message);
    ff_model_defaults(&l.model, n_channels, l.shape, l.channel);
    for (char *one = strtok_r(rest, " ", &rest); one; one = strtok_r(NULL, " ", &rest))
        FF_CHECK(ff_model_set(&l.model, n_channels, one, l.shape, l.channel, &err) == FF_OK, "%s: %s", one, err.message);
    return l;
}

static void view(double theta_deg, double phi_deg, double wo[3])
{
    const double t = theta_deg * PI / 180, p = phi_deg * PI / 180;
    wo[0] = sin(t) * cos(p);
    wo[1] = sin(t) * sin(p);
    wo[2] = cos(t);
}

static ff_integral albedo(const lobe *l, double mu, double phi)
{
    const double s = sqrt(1 - mu * mu), wo[3] = {s * cos(phi), s * sin(phi), mu};
    ff_integral out[4] = {{NAN, NAN}};
    ff_error err = {0};
    FF_CHECK(ff_albedo_directional(&l->model, FF_ISA_BEST, l->n_channels, l->shape, l->channel, wo, out, &err) == FF_OK, "%s",
             err.message);
    return out[0];
}

/* ---- weak white furnace ---------------------------------------------------------------------- */

static double furnace_worst;
static long furnace_count;

static void check_furnace(const lobe *l, const char *what)
{
    static const double thetas[] = {0, 45, 70, 88}, phis[] = {37, 250};
    for (size_t t = 0; t < sizeof thetas / sizeof thetas[0]; ++t)
        for (size_t p = 0; p < sizeof phis / sizeof phis[0]; ++p) {
            double wo[3];
            ff_integral out = {NAN, NAN};
            ff_error err = {0};
            if (t == 0 && p > 0) continue;
            view(thetas[t], phis[p], wo);
            const int x = ff_model_param_find(&l->model, "slope_x"), y = ff_model_param_find(&l->model, "slope_y");
            const double seen = wo[2] - (x >= 0 ? l->shape[x] * wo[0] : 0) - (y >= 0 ? l->shape[y] * wo[1] : 0);
            const ff_status status = ff_albedo_weak_furnace(&l->model, FF_ISA_BEST, l->shape, 0, wo, &out, &err);
            if (seen <= 0) { /* the mesosurface is seen from below: refused */
                FF_CHECK(status == FF_ERR_RANGE, "%s: theta %g phi %g", what, thetas[t], phis[p]);
                continue;
            }
            FF_CHECK(status == FF_OK, "%s: %s", what, err.message);
            FF_CHECK(fabs(out.value - 1) <= 1e-6, "%s: theta %g phi %g: %.10f", what, thetas[t], phis[p], out.value);
            if (!(fabs(out.value - 1) <= furnace_worst)) furnace_worst = fabs(out.value - 1);
            ++furnace_count;
        }
}

static void furnace_of(const ff_term *ndf, const ff_term *masking, const char *settings)
{
    char expression[FF_MODEL_NAME], what[FF_MODEL_NAME + SETTINGS + 64];
    snprintf(expression, sizeof expression, "%s/%s/none", ndf->name, masking->name);
    const lobe l = lobe_make(expression, 1, settings);
    snprintf(what, sizeof what, "%s %s", expression, settings);
    check_furnace(&l, what);
}

/* Values of the distribution's own parameter beyond the stretch, "" where it has none. */
static void furnace_own(const ff_term *ndf, const ff_term *masking, const char *settings)
{
    static const char *const gammas[] = {"gamma=1.6", "gamma=3.7", "gamma=12"};
    char all[SETTINGS + 16];
    if (strcmp(ndf->name, "student-t")) {
        furnace_of(ndf, masking, settings);
        return;
    }
    for (size_t i = 0; i < sizeof gammas / sizeof gammas[0]; ++i) {
        snprintf(all, sizeof all, "%s %s", gammas[i], settings);
        furnace_of(ndf, masking, all);
    }
}

static void furnace_stretched(const ff_term *ndf, const ff_term *masking)
{
    static const double alphas[][2] = {{0.05, 0.05}, {0.05, 1.5}, {1.5, 0.05}, {0.4, 0.2}, {1.5, 1.5}}, rs[] = {0, 0.9, -0.9};
    static const double slopes[][2] = {{0, 0}, {0.2, -0.1}, {-0.3, 0.25}};
    for (size_t a = 0; a < sizeof alphas / sizeof alphas[0]; ++a)
        for (size_t r = 0; r < sizeof rs / sizeof rs[0]; ++r)
            for (size_t s = 0; s < (masking->claims & FF_NEEDS_CENTRED ? 1 : sizeof slopes / sizeof slopes[0]); ++s) {
                char settings[SETTINGS];
                snprintf(settings, sizeof settings, "alpha_x=%g alpha_y=%g r_xy=%g slope_x=%g slope_y=%g", alphas[a][0],
                         alphas[a][1], rs[r], slopes[s][0], slopes[s][1]);
                furnace_own(ndf, masking, settings);
            }
}

static void furnace_exponent(const ff_term *ndf, const ff_term *masking)
{
    static const double ns[] = {0.1, 1, 7, 100, 800};
    for (size_t i = 0; i < sizeof ns / sizeof ns[0]; ++i) {
        char settings[SETTINGS];
        snprintf(settings, sizeof settings, "n=%g", ns[i]);
        furnace_own(ndf, masking, settings);
    }
}

static void weak_furnace_is_one(void)
{
    int maskings = 0;
    for (size_t m = 0; m < ff_term_count(FF_MASKING); ++m) {
        const ff_term *masking = ff_term_at(FF_MASKING, m);
        if (!(masking->claims & FF_WEAK_FURNACE)) continue;
        ++maskings;
        if (strcmp(masking->name, "smith-masking-only") && strcmp(masking->name, "v-cavity"))
            continue; /* they share the G1 of the first */
        for (size_t d = 0; d < ff_term_count(FF_NDF); ++d) {
            const ff_term *ndf = ff_term_at(FF_NDF, d);
            if (ndf->n_params > 1) {
                furnace_stretched(ndf, masking);
            } else {
                furnace_exponent(ndf, masking);
            }
        }
    }
    FF_CHECK(maskings >= 2, "%d maskings claim the weak furnace", maskings);
    FF_CHECK(furnace_count > 1500, "only %ld settings were integrated", furnace_count);
    printf("  weak furnace: %ld settings, worst deviation %.2e\n", furnace_count, furnace_worst);
}

static void weak_furnace_takes_every_smith_form(void)
{
    static const char *const forms[] = {"smith-masking-only", "smith-separable", "smith-height-correlated",
                                        "smith-direction-correlated", "smith-height-direction-correlated"};
    double wo[3];
    view(70, 30, wo);
    for (size_t i = 0; i < sizeof forms / sizeof forms[0]; ++i) {
        char expression[FF_MODEL_NAME];
        ff_integral out = {NAN, NAN};
        snprintf(expression, sizeof expression, "ggx/%s+lambert", forms[i]);
        const lobe l = lobe_make(expression, 1, "alpha_x=0.3 alpha_y=0.8 r_xy=0.5");
        FF_CHECK(ff_albedo_weak_furnace(&l.model, FF_ISA_SCALAR, l.shape, 0, wo, &out, NULL) == FF_OK, "%s", expression);
        FF_CHECK_CLOSE(out.value, 1, 0, 1e-8);
    }
}

/* Without masking the integral is 1 + Lambda: for ggx at alpha 1, theta 45, (1 + sqrt 2) / 2. The test above can thus fail. */
static void without_masking_it_is_not_one(void)
{
    const lobe l = lobe_make("ggx/none", 1, "alpha=1");
    double wo[3];
    ff_integral out = {NAN, NAN};
    view(45, 0, wo);
    FF_CHECK(ff_albedo_weak_furnace(&l.model, FF_ISA_BEST, l.shape, 0, wo, &out, NULL) == FF_OK, "ggx/none");
    FF_CHECK_CLOSE(out.value, (1 + sqrt(2)) / 2, 1e-9, 0);
}

/* ---- albedo ---------------------------------------------------------------------------------- */

static void closed_forms(void)
{
    static const char *const smith[] = {"separable", "height-correlated", "direction-correlated", "height-direction-correlated"};
    for (size_t i = 0; i < sizeof smith / sizeof smith[0]; ++i) {
        char expression[FF_MODEL_NAME];
        snprintf(expression, sizeof expression, "ggx/smith-%s/none", smith[i]);
        const lobe l = lobe_make(expression, 1, "alpha=1");
        FF_CHECK_CLOSE(albedo(&l, 1, 0).value, 1 - log(2), 0, 1e-10);
    }
    const lobe cavity = lobe_make("ggx/v-cavity/none", 1, "alpha=1"), diffuse = lobe_make("lambert", 1, "kd=0.37");
    FF_CHECK_CLOSE(albedo(&cavity, 1, 0).value, 3.0 / 8, 0, 1e-10);
    FF_CHECK_CLOSE(albedo(&diffuse, 0.2, 1).value, 0.37, 0, 1e-12);
}

static void published_values(void)
{
    static const struct {
        const char *expression, *settings;
        double mu, albedo;
    } known[] = {
        {"ggx/smith-separable/none", "alpha=0.5", 0.3, 0.71415},
        {"ggx/smith-height-correlated/none", "alpha=0.5", 0.3, 0.74527},
        {"ggx/smith-height-direction-correlated/none", "alpha=0.5", 0.3, 0.75300},
        {"ggx/v-cavity/none", "alpha=0.5", 0.3, 0.88321},
        {"beckmann/smith-separable/none", "alpha=0.5", 0.3, 0.89230},
        {"beckmann/smith-height-correlated/none", "alpha=0.5", 0.3, 0.89594},
        {"beckmann/v-cavity/none", "alpha=0.5", 0.3, 0.92490},
        {"ggx/smith-height-correlated/none", "alpha=1", 0.7, 0.37889},
        {"ggx/smith-height-correlated/none", "alpha=1", 0.5, 0.45069},
        {"ggx/smith-height-correlated/none", "alpha=1", 0.3, 0.56010},
        {"ggx/smith-height-correlated/none", "alpha=1", 0.1, 0.76022},
        {"ggx/v-cavity/none", "alpha=1", 0.7, 0.51505},
        {"ggx/v-cavity/none", "alpha=1", 0.5, 0.65306},
        {"ggx/v-cavity/none", "alpha=1", 0.3, 0.79265},
        {"ggx/v-cavity/none", "alpha=1", 0.1, 0.93105},
    };
    for (size_t i = 0; i < sizeof known / sizeof known[0]; ++i) {
        const lobe l = lobe_make(known[i].expression, 1, known[i].settings);
        const ff_integral a = albedo(&l, known[i].mu, 0), turned = albedo(&l, known[i].mu, 2.1);
        FF_CHECK(fabs(a.value - known[i].albedo) < 1e-4, "%s %s mu %g: %.8f", known[i].expression, known[i].settings, known[i].mu,
                 a.value);
        FF_CHECK(a.error < 1e-6, "%s: error %g", known[i].expression, a.error);
        FF_CHECK_CLOSE(turned.value, a.value, 0, 1e-6); /* isotropic: the azimuth does not matter */
    }
}

/* The same integral by a plain sum over the hemisphere of wi, which shares nothing with the quadrature but the kernels. */
static double by_hemisphere(const lobe *l, const double wo[3])
{
    enum { NZ = 1200, NP = 1200 };
    double sum = 0;
    for (int i = 0; i < NZ; ++i) {
        double x[NP], y[NP], z[NP], ox[NP], oy[NP], oz[NP], f[NP];
        const double c = (i + 0.5) / NZ, s = sqrt(1 - c * c);
        for (int j = 0; j < NP; ++j) {
            const double phi = 2 * PI * (j + 0.5) / NP;
            x[j] = s * cos(phi), y[j] = s * sin(phi), z[j] = c;
            ox[j] = wo[0], oy[j] = wo[1], oz[j] = wo[2];
        }
        const ff_dirs w = {x, y, z, ox, oy, oz};
        FF_CHECK(ff_model_eval(&l->model, FF_ISA_BEST, 1, l->shape, l->channel, &w, NP, f, NULL, NP) == FF_OK, "eval");
        for (int j = 0; j < NP; ++j) sum += f[j] * c * 2 * PI / NP / NZ;
    }
    return sum;
}

static void against_a_plain_sum(void)
{
    static const char *const settings[] = {
        "alpha_x=0.3 alpha_y=0.7 r_xy=0.6", "alpha_x=0.3 alpha_y=0.7 r_xy=-0.6 slope_x=0.3 slope_y=-0.2",
        "alpha_x=0.6 alpha_y=0.3 slope_x=-0.5 slope_y=0.1", "alpha_x=0.5 alpha_y=0.5 slope_x=0.8 slope_y=0.4"};
    static const char *const expressions[] = {"ggx", "beckmann/smith-separable/schlick",
                                              "student-t/smith-height-direction-correlated/none"};
    for (size_t e = 0; e < sizeof expressions / sizeof expressions[0]; ++e)
        for (size_t i = 0; i < sizeof settings / sizeof settings[0]; ++i)
            for (int v = 0; v < 2; ++v) {
                double wo[3];
                ff_integral out = {NAN, NAN};
                ff_error err = {0};
                const lobe l = lobe_make(expressions[e], 1, settings[i]);
                view(v ? 60 : 25, v ? 160 : 20, wo);
                FF_CHECK(ff_albedo_directional(&l.model, FF_ISA_BEST, 1, l.shape, l.channel, wo, &out, &err) == FF_OK, "%s",
                         err.message);
                FF_CHECK_CLOSE(out.value, by_hemisphere(&l, wo), 0, 2e-5);
                FF_CHECK(out.error < 1e-5, "%s %s: error %g", expressions[e], settings[i], out.error);
            }
}

static void sums_and_channels(void)
{
    const lobe both = lobe_make("ggx+beckmann/v-cavity+lambert", 3,
                                "alpha=0.3 lobe2.alpha=0.1 f0=0.9:0.5:0.1 lobe2.f0=0.04:0.05:0.06 kd=0.1:0.2:0.3");
    double wo[3], expected[3];
    ff_integral sum[3], one;
    view(50, 10, wo);
    FF_CHECK(ff_albedo_directional(&both.model, FF_ISA_BEST, 3, both.shape, both.channel, wo, sum, NULL) == FF_OK,
             "three channels");
    for (int c = 0; c < 3; ++c) {
        static const char *const first[] = {"alpha=0.3 f0=0.9", "alpha=0.3 f0=0.5", "alpha=0.3 f0=0.1"};
        static const char *const second[] = {"alpha=0.1 f0=0.04", "alpha=0.1 f0=0.05", "alpha=0.1 f0=0.06"};
        const lobe a = lobe_make("ggx", 1, first[c]), b = lobe_make("beckmann/v-cavity", 1, second[c]);
        expected[c] = 0.1 * (c + 1);
        FF_CHECK(ff_albedo_directional(&a.model, FF_ISA_BEST, 1, a.shape, a.channel, wo, &one, NULL) == FF_OK, "first");
        expected[c] += one.value;
        FF_CHECK(ff_albedo_directional(&b.model, FF_ISA_BEST, 1, b.shape, b.channel, wo, &one, NULL) == FF_OK, "second");
        expected[c] += one.value;
        FF_CHECK_CLOSE(sum[c].value, expected[c], 1e-9, 0);
    }
}

static void passive_models_reflect_at_most_one(void)
{
    for (size_t d = 0; d < ff_term_count(FF_NDF); ++d)
        for (size_t m = 0; m < ff_term_count(FF_MASKING); ++m)
            for (double mu = 0.05; mu < 1; mu += 0.3) {
                char expression[FF_MODEL_NAME];
                snprintf(expression, sizeof expression, "%s/%s/none", ff_term_at(FF_NDF, d)->name, ff_term_at(FF_MASKING, m)->name);
                const lobe l = lobe_make(expression, 1, "");
                if (!(ff_model_claims(&l.model, l.shape) & FF_PASSIVE)) continue;
                const ff_integral a = albedo(&l, mu, 0.4);
                FF_CHECK(a.value > 0 && a.value <= 1 + 1e-6, "%s at mu %g: %.9f", expression, mu, a.value);
            }
}

static void refusals(void)
{
    const lobe l = lobe_make("ggx+lambert", 1, ""), diffuse = lobe_make("lambert", 1, ""),
               tilted = lobe_make("ggx", 1, "slope_x=0.5");
    const double below[3] = {1, 0, 0}, longer[3] = {0, 0, 2}, nan[3] = {0, NAN, 1}, up[3] = {0, 0, 1};
    double grazing[3], bad[FF_MAX_SHAPE];
    ff_integral out = {4711, 4711};
    ff_error err = {0};
    view(80, 0, grazing);
    memcpy(bad, l.shape, sizeof bad);
    bad[0] = NAN;
    FF_CHECK(ff_albedo_directional(&l.model, FF_ISA_BEST, 1, l.shape, l.channel, below, &out, &err) == FF_ERR_RANGE, "horizon");
    FF_CHECK(ff_albedo_directional(&l.model, FF_ISA_BEST, 1, l.shape, l.channel, longer, &out, &err) == FF_ERR_RANGE, "length 2");
    FF_CHECK(ff_albedo_directional(&l.model, FF_ISA_BEST, 1, l.shape, l.channel, nan, &out, &err) == FF_ERR_RANGE, "NaN");
    FF_CHECK(ff_albedo_directional(&l.model, FF_ISA_BEST, 1, bad, l.channel, up, &out, &err) == FF_ERR_RANGE, "NaN roughness");
    FF_CHECK(ff_albedo_weak_furnace(&l.model, FF_ISA_BEST, l.shape, 1, up, &out, &err) == FF_ERR_UNSUPPORTED, "lobe 2 of one");
    FF_CHECK(ff_albedo_weak_furnace(&diffuse.model, FF_ISA_BEST, diffuse.shape, 0, up, &out, &err) == FF_ERR_UNSUPPORTED,
             "no lobe");
    FF_CHECK(ff_albedo_weak_furnace(&tilted.model, FF_ISA_BEST, tilted.shape, 0, grazing, &out, &err) == FF_ERR_RANGE,
             "from below");
    FF_CHECK(strstr(err.message, "mean slope") != NULL, "%s", err.message);
    FF_CHECK(out.value == 4711 && out.error == 4711, "a refusal wrote its output");
}

FF_TEST_MAIN(FF_TEST(weak_furnace_is_one), FF_TEST(weak_furnace_takes_every_smith_form), FF_TEST(without_masking_it_is_not_one),
             FF_TEST(closed_forms), FF_TEST(published_values), FF_TEST(against_a_plain_sum), FF_TEST(sums_and_channels),
             FF_TEST(passive_models_reflect_at_most_one), FF_TEST(refusals))
