/* Directional albedo and the weak white furnace, of every distribution under every masking, and the albedo curves that coupled
 * terms read. Everything runs through the kernels, so that a wrong D, Lambda, G or projected area shows here. */
#include "model_samples.h"
#include "ff_albedo.h"
#include "models/internal_model.h"

#define PI MODEL_PI
enum { SETTINGS = 512 };

typedef fit_surface lobe;

static lobe lobe_make(const char *expression, size_t n_channels, const char *settings)
{
    return fit_surface_make(expression, n_channels, settings);
}

static void view(double theta_deg, double phi_deg, double wo[3])
{
    model_direction(theta_deg * FIT_DEGREE, phi_deg * FIT_DEGREE, wo);
}

static ff_integral albedo(const lobe *l, double mu, double phi)
{
    const double s = sqrt((1 - mu) * (1 + mu)), wo[3] = {s * cos(phi), s * sin(phi), mu};
    ff_integral out[FIT_CHANNELS] = {{NAN, NAN}};
    ff_error err = {0};
    FF_CHECK(ff_albedo_directional(&l->model, FF_ISA_BEST, l->n_channels, l->shape, l->channel, wo, out, &err) == FF_OK, "%s",
             err.message);
    return out[0];
}

/* ---- weak white furnace ---------------------------------------------------------------------- */

/* What the furnace integrals of one pair of terms came to. */
typedef struct tally {
    long count;
    double worst; /* largest distance from 1 */
} tally;

static void furnace(const lobe *l, tally *t, const char *what)
{
    static const double thetas[] = {0, 45, 70, 88}, phis[] = {37, 250};
    const double tolerance =
        ff_ndf_at(l->model.lobe[0].ndf)->needs_values ? 3e-6 : 1e-7; /* cubics of a table meet all along a ray */
    for (size_t i = 0; i < sizeof thetas / sizeof thetas[0]; i++)
        for (size_t p = 0; p < sizeof phis / sizeof phis[0]; p++) {
            double wo[3];
            ff_integral out = {NAN, NAN};
            ff_error err = {0};
            const ff_param_ref x = ff_model_param_find(&l->model, "slope_x"), y = ff_model_param_find(&l->model, "slope_y");
            const int directed = ff_model_param_find(&l->model, "alpha_x").kind != FF_PARAM_NONE;
            if (p > 0 && (i == 0 || !directed)) continue;
            view(thetas[i], phis[p], wo);
            const double seen = wo[2] - (x.kind ? l->shape[x.index] * wo[0] : 0) - (y.kind ? l->shape[y.index] * wo[1] : 0);
            const ff_status status = ff_albedo_weak_furnace(&l->model, FF_ISA_BEST, l->shape, 0, wo, &out, &err);
            if (seen <= 0) { /* the mesosurface is seen from below: refused */
                FF_CHECK(status == FF_ERR_RANGE, "%s: theta %g phi %g", what, thetas[i], phis[p]);
                continue;
            }
            FF_CHECK(status == FF_OK, "%s: %s", what, err.message);
            if (ff_albedo_weak_furnace_claimed(&l->model, 0)) { /* off by what the quadrature says of itself, which is little */
                FF_CHECK(fabs(out.value - 1) <= fmax(tolerance, out.error), "%s: theta %g phi %g: %.10f (%.1e)", what, thetas[i],
                         phis[p], out.value, out.error);
                FF_CHECK(out.error <= 1e-4, "%s: theta %g phi %g: within %.1e alone", what, thetas[i], phis[p], out.error);
            }
            if (!(fabs(out.value - 1) <= t->worst)) t->worst = fabs(out.value - 1);
            t->count++;
        }
}

static void furnace_of(const lobe *base, const char *settings, tally *t)
{
    char expression[MODEL_LABEL], what[MODEL_LABEL + SETTINGS];
    ff_model_expression(&base->model, expression, sizeof expression);
    snprintf(what, sizeof what, "%s %s", expression, settings);
    const lobe l = lobe_make(expression, 1, settings);
    furnace(&l, t, what);
}

/* Ellipses, with the parameter of the tails where there is one. */
static void furnace_stretched(const lobe *base, int centred, tally *t)
{
    static const double alphas[][2] = {{0.05, 0.05}, {0.05, 1.5}, {1.5, 0.05}, {0.4, 0.2}, {1.5, 1.5}}, rs[] = {0, 0.9, -0.9};
    static const double slopes[][2] = {{0, 0}, {0.2, -0.1}, {-0.3, 0.25}};
    static const char *const gammas[] = {"gamma=1.6 ", "gamma=3.7 ", "gamma=12 "};
    const int tails = ff_model_param_find(&base->model, "gamma").kind != FF_PARAM_NONE;
    for (size_t a = 0; a < sizeof alphas / sizeof alphas[0]; a++)
        for (size_t r = 0; r < sizeof rs / sizeof rs[0]; r++) {
            const size_t s = centred ? 0 : (a + r) % 3;
            char settings[SETTINGS];
            snprintf(settings, sizeof settings, "%salpha_x=%g alpha_y=%g r_xy=%g slope_x=%g slope_y=%g", tails ? gammas[a % 3] : "",
                     alphas[a][0], alphas[a][1], rs[r], slopes[s][0], slopes[s][1]);
            furnace_of(base, settings, t);
        }
}

/* Initial values, and a few anywhere in the box. */
static void furnace_anywhere(const lobe *base, int settings, uint64_t *state, tally *t)
{
    char what[MODEL_LABEL];
    ff_model_expression(&base->model, what, sizeof what);
    for (int i = 0; i <= settings; i++) {
        lobe l = *base;
        if (i > 0) model_random_parameters(&l.model, 1, MODEL_TILTED, 0.9, state, l.shape, l.channel);
        furnace(&l, t, what);
    }
}

/* 1 where it is claimed; where it is not, it must be seen not to be. The forms of Smith's masking share one G1: ellipses and tilts
 * are for the first of them. */
static void weak_furnace_is_one(void)
{
    tally claimed = {0, 0};
    int pairs = 0, refused = 0;
    for (size_t d = 0; d < ff_term_count(FF_NDF); d++)
        for (size_t m = 0; m < ff_term_count(FF_MASKING); m++) {
            const ff_term *masking = ff_term_at(FF_MASKING, m);
            lobe l = {.n_channels = 1};
            tally t = {0, 0};
            ff_integral out = {4711, 0};
            if (!model_lobe(d, masking->name, "none", &l.model)) continue;
            ff_model_defaults(&l.model, 1, l.shape, l.channel);
            if (ff_albedo_weak_furnace(&l.model, FF_ISA_BEST, l.shape, 0, (const double[]){0, 0, 1}, &out, NULL) ==
                FF_ERR_UNSUPPORTED) { /* no masking of one direction */
                FF_CHECK(!ff_albedo_weak_furnace_claimed(&l.model, 0) && out.value == 4711, "%s is refused", masking->name);
                refused++;
                continue;
            }
            uint64_t state = ff_test_stream("weak furnace %s/%s", ff_term_at(FF_NDF, d)->name, masking->name);
            const int first = (masking->claims & FF_WEAK_FURNACE) != 0;
            if (first && ff_model_param_find(&l.model, "alpha_x").kind != FF_PARAM_NONE)
                furnace_stretched(&l, (masking->claims & FF_NEEDS_CENTRED) != 0, &t);
            furnace_anywhere(&l, first ? (ff_test_is_thorough() ? 3 : 1) : 0, &state, &t);
            pairs++;
            if (ff_albedo_weak_furnace_claimed(&l.model, 0)) {
                claimed.count += t.count;
                claimed.worst = fmax(claimed.worst, t.worst);
            } else {
                FF_CHECK(!(t.worst < 1e-4), "%s/%s claims nothing, and the furnace integral is 1 to %.1e",
                         ff_term_at(FF_NDF, d)->name, masking->name, t.worst);
                printf("  not claimed: %s/%s, off by up to %.2g\n", ff_term_at(FF_NDF, d)->name, masking->name, t.worst);
            }
        }
    FF_CHECK(pairs > 80 && refused > 0, "%d pairs, %d refused", pairs, refused);
    FF_CHECK(claimed.count > 1000, "only %ld settings were integrated", claimed.count);
    printf("  claimed: %ld settings, worst deviation %.2e\n", claimed.count, claimed.worst);
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

/* Hammon's Lambda = (alpha / cos + 1 - alpha) / 2 - 1/2 in place of ggx's: the integral is the ratio of 1 + Lambda. */
static void approximate_g1_shows_its_error(void)
{
    static const char *const forms[] = {"hammon", "schlick-smith"};
    double wo[3];
    view(70, 10, wo);
    for (size_t i = 0; i < 2; i++) {
        char expression[MODEL_LABEL];
        ff_integral out = {NAN, NAN};
        snprintf(expression, sizeof expression, "ggx/%s", forms[i]);
        const lobe l = lobe_make(expression, 1, "alpha=0.4");
        const double tangent = tan(70 * FIT_DEGREE), exact = (1 + sqrt(1 + 0.16 * tangent * tangent)) / 2;
        FF_CHECK(ff_albedo_weak_furnace(&l.model, FF_ISA_BEST, l.shape, 0, wo, &out, NULL) == FF_OK, "%s", expression);
        FF_CHECK_CLOSE(out.value, exact / (0.5 * (0.4 / wo[2] + 2 - 0.4)), 1e-9, 0);
    }
}

/* Normals near the horizon of a von Mises-Fisher distribution have no finite area. */
static void infinite_facets(void)
{
    const lobe l = lobe_make("vmf", 1, "kappa=20");
    double wo[3];
    ff_integral out = {NAN, NAN};
    view(45, 0, wo);
    FF_CHECK(ff_albedo_weak_furnace(&l.model, FF_ISA_BEST, l.shape, 0, wo, &out, NULL) == FF_OK, "vmf");
    FF_CHECK(isinf(out.value) && out.value > 0, "%g", out.value);
}

/* ---- albedo ---------------------------------------------------------------------------------- */

static void closed_forms(void)
{
    static const char *const smith[] = {"separable", "height-correlated", "direction-correlated", "height-direction-correlated"};
    for (size_t i = 0; i < sizeof smith / sizeof smith[0]; i++) {
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
    for (size_t i = 0; i < sizeof known / sizeof known[0]; i++) {
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
    for (int i = 0; i < NZ; i++) {
        double x[NP], y[NP], z[NP], ox[NP], oy[NP], oz[NP], f[NP];
        const double c = (i + 0.5) / NZ, s = sqrt(1 - c * c);
        for (int j = 0; j < NP; j++) {
            const double phi = 2 * PI * (j + 0.5) / NP;
            x[j] = s * cos(phi), y[j] = s * sin(phi), z[j] = c;
            ox[j] = wo[0], oy[j] = wo[1], oz[j] = wo[2];
        }
        const ff_dirs w = {x, y, z, ox, oy, oz};
        FF_CHECK(ff_model_eval(&l->model, FF_ISA_BEST, 1, l->shape, l->channel, &w, NP, f, NULL, NP) == FF_OK, "eval");
        for (int j = 0; j < NP; j++) sum += f[j] * c * 2 * PI / NP / NZ;
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
    for (size_t e = 0; e < sizeof expressions / sizeof expressions[0]; e++)
        for (size_t i = 0; i < sizeof settings / sizeof settings[0]; i++)
            for (int v = 0; v < 2; v++) {
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
    for (int c = 0; c < 3; c++) {
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

/* Lobes that share a Fresnel term weigh 1 - w and w. */
static void weights(void)
{
    const lobe both = lobe_make("ggx+beckmann/v-cavity/shared", 1, "alpha=0.3 lobe2.alpha=0.1 lobe2.weight=0.3 f0=0.4 ks=0.9"),
               a = lobe_make("ggx", 1, "alpha=0.3 f0=0.4 ks=0.9"), b = lobe_make("beckmann/v-cavity", 1, "alpha=0.1 f0=0.4 ks=0.9");
    FF_CHECK_CLOSE(albedo(&both, 0.4, 1).value, 0.7 * albedo(&a, 0.4, 1).value + 0.3 * albedo(&b, 0.4, 1).value, 1e-9, 0);
}

/* One that keeps its width among its own parameters is integrated at any of them: what a narrow lobe reflects is F(mu). */
static void narrow_lobes(void)
{
    static const char *const lobes[][2] = {
        {"vmf/v-cavity/schlick", "kappa=1e6"},         {"kelemen-ward/kelemen/schlick", "m=2e-4"},
        {"sgd/smith-separable/schlick", "alpha=1e-6"}, {"abc/v-cavity/schlick", "B=1e8 C=8"},
        {"gaussian/v-cavity/schlick", "sigma=1e-3"},   {"phong/v-cavity/schlick", "n=2e6"}};
    for (size_t i = 0; i < sizeof lobes / sizeof lobes[0]; i++) {
        const lobe l = lobe_make(lobes[i][0], 1, lobes[i][1]);
        for (double mu = 0.3; mu <= 1; mu += 0.35) {
            const ff_integral a = albedo(&l, mu, 0.3);
            FF_CHECK_CLOSE(a.value, 0.5 + 0.5 * pow(1 - mu, 5), 0, 2e-5);
            FF_CHECK(a.error < 1e-6, "%s: error %g", lobes[i][0], a.error);
        }
    }
}

/* At most 1 where it is claimed. Of the rest, lobes without masking are known to reflect more than they receive. */
static void passive_models_reflect_at_most_one(void)
{
    static const double mus[] = {0.02, 0.3, 0.8};
    long claimed = 0;
    double most = 0;
    for (size_t d = 0; d < ff_term_count(FF_NDF); d++)
        for (size_t m = 0; m < ff_term_count(FF_MASKING); m++) {
            double beyond = 0;
            uint64_t state = ff_test_stream("passive %s/%s", ff_term_at(FF_NDF, d)->name, ff_term_at(FF_MASKING, m)->name);
            lobe l = {.n_channels = 1};
            if (!model_lobe(d, ff_term_at(FF_MASKING, m)->name, "none", &l.model)) continue;
            for (int i = 0; i < 2; i++) {
                ff_model_defaults(&l.model, 1, l.shape, l.channel);
                if (i > 0) model_random_parameters(&l.model, 1, MODEL_CENTRED, 0.6, &state, l.shape, l.channel);
                l.channel[0] = 1; /* ks */
                for (size_t k = 0; k < (i ? 1 : 3); k++) {
                    const ff_integral a = albedo(&l, mus[k], 0.4);
                    if (ff_model_claims(&l.model, l.shape) & FF_PASSIVE) {
                        FF_CHECK(a.value > 0 && a.value <= 1 + 1e-9 + a.error, "%s/%s at mu %g: %.10f", ff_term_at(FF_NDF, d)->name,
                                 ff_term_at(FF_MASKING, m)->name, mus[k], a.value);
                        most = fmax(most, a.value);
                        claimed++;
                    } else
                        beyond = fmax(beyond, a.value);
                }
            }
            if (strcmp(ff_term_at(FF_MASKING, m)->name, "none") == 0)
                FF_CHECK(beyond > 1.01, "%s without masking: %g", ff_term_at(FF_NDF, d)->name, beyond);
            if (beyond > 1)
                printf("  not claimed: %s/%s, up to %.4g\n", ff_term_at(FF_NDF, d)->name, ff_term_at(FF_MASKING, m)->name, beyond);
        }
    FF_CHECK(claimed > 250, "only %ld albedos", claimed);
    printf("  claimed: %ld albedos, largest %.10f\n", claimed, most);
}

/* ---- terms that are coupled to the lobes ----------------------------------------------------- */

static const double some_mu[] = {1, 0.8, 0.5, 0.2, 0.05, 0.004};
enum { SOME_MU = sizeof some_mu / sizeof some_mu[0] };

/* What the lobes leave over, and all of it, comes back. */
static void nothing_is_lost(void)
{
    static const char *const surfaces[][2] = {
        {"ggx/smith-height-correlated/none+kelemen-matte", "alpha=0.3 kd=1"},
        {"ggx/smith-height-correlated/none+kulla-conty", "alpha=1"},
        {"beckmann/v-cavity/dielectric+kelemen-matte", "alpha=0.02 eta=1.4 kd=1"},
        {"kelemen-phong/kelemen/none+kelemen-matte", "n=2 kd=1"},
        {"vmf/v-cavity/conductor+kelemen-matte", "kappa=17 eta=0.769 k=6.08 kd=1"},
        {"ggx/smith-separable/none+beckmann/smith-separable/shared+kulla-conty", "alpha=0.5 lobe2.alpha=0.2 lobe2.weight=0.4"}};
    for (size_t i = 0; i < sizeof surfaces / sizeof surfaces[0]; i++) {
        const lobe l = lobe_make(surfaces[i][0], 1, surfaces[i][1]);
        for (int k = 0; k < SOME_MU; k++) FF_CHECK_CLOSE(albedo(&l, some_mu[k], 0.3).value, 1, 0, 2e-6);
    }
}

/* f_d = kd (1 - a_i)(1 - a_o) / pi reflects kd (1 - a)(1 - mean). */
static void mikkelsen_loses_the_mean(void)
{
    const lobe both = lobe_make("vmf/v-cavity/dielectric+mikkelsen-coupled", 1, "kappa=17 eta=1.329 kd=0.6"),
               alone = lobe_make("vmf/v-cavity/dielectric", 1, "kappa=17 eta=1.329");
    enum { N = 32 };
    double mean = 0;
    for (int i = 1; i <= N; i++) { /* 2 integral a mu dmu = integral 4 a v^3 dv, mu = v^2, by Simpson's rule */
        const double v = (double)i / N, weight = (i == N ? 1 : i % 2 ? 4 : 2) / (3.0 * N);
        mean += weight * 4 * v * v * v * albedo(&alone, v * v, 0).value;
    }
    for (int k = 0; k < SOME_MU; k++) {
        const double a = albedo(&alone, some_mu[k], 0).value;
        FF_CHECK_CLOSE(albedo(&both, some_mu[k], 0).value - a, 0.6 * (1 - a) * (1 - mean), 0, 1e-6);
    }
}

static ff_prepared prepare(const lobe *l, const ff_wanted *wanted)
{
    ff_prepared p;
    const ff_kernels *kernels = ff_kernels_get(FF_ISA_BEST);
    if (ff_prepare(&l->model, kernels, FF_CHEAPEST_MODE, l->n_channels, l->shape, l->channel, wanted, 0, 1, &p)) exit(1);
    return p;
}

/* The curves against the adaptive quadrature: 1e-5 is what they promise between alpha = 0.01 and 1. */
static void curves_follow_the_albedo(void)
{
    static const char *const lobes[][2] = {{"beckmann", "alpha=0.01"}, {"beckmann", "alpha=0.05"},
                                           {"beckmann", "alpha=1"},    {"ggx", "alpha=0.01"},
                                           {"ggx", "alpha=0.3"},       {"ggx", "alpha=1"},
                                           {"vmf", "kappa=200"},       {"kelemen-phong", "n=11"},
                                           {"abc", "B=1e3 C=0.8"},     {"student-t", "alpha=0.1 gamma=1.6"}};
    double worst = 0;
    long count = 0;
    for (size_t i = 0; i < sizeof lobes / sizeof lobes[0]; i++)
        for (size_t m = 0; m < ff_term_count(FF_MASKING); m++) {
            ff_model composed;
            char text[MODEL_LABEL];
            const char *masking = ff_term_at(FF_MASKING, m)->name;
            if (!model_lobe((size_t)ff_term_find(FF_NDF, lobes[i][0]), masking, "schlick", &composed)) continue;
            snprintf(text, sizeof text, "%s/%s+kelemen-matte", lobes[i][0], masking);
            const lobe coupled = lobe_make(text, 1, lobes[i][1]);
            snprintf(text, sizeof text, "%s/%s", lobes[i][0], masking);
            const lobe alone = lobe_make(text, 1, lobes[i][1]);
            ff_prepared p = prepare(&coupled, NULL);
            for (int k = 0; k < SOME_MU; k++) {
                double a = NAN;
                p.kernels->albedo_at(&p.albedo[0], 0, 1, &some_mu[k], &a);
                const double exact = albedo(&alone, some_mu[k], 0).value, off = fabs(a - exact) / fmax(1, exact);
                FF_CHECK(off < 1e-5, "%s %s at mu %g: %.9f, not %.9f", text, lobes[i][1], some_mu[k], a, exact);
                worst = fmax(worst, off);
                count++;
            }
            ff_prepared_free(&p);
        }
    printf("  %ld values, worst %.2e\n", count, worst);
}

/* The curve of each lobe by itself has neither its weight nor its Fresnel term, and the derivatives of all are those of the values.
 */
static void curves_have_derivatives(void)
{
    const lobe l = lobe_make("ggx/smith-separable/schlick+student-t/v-cavity/shared+kulla-conty+kelemen-matte", 1,
                             "alpha=0.4 lobe2.alpha=0.15 lobe2.gamma=2.5 lobe2.weight=0.3 f0=0.6 ks=0.8 kd=0.5");
    const ff_wanted wanted = {.n_shape = 4, .n_channel = 2, .shape = {0, 1, 2, 3}, .channel = {0, 1}};
    ff_prepared p = prepare(&l, &wanted);
    double mu[SOME_MU], alone[SOME_MU];
    memcpy(mu, some_mu, sizeof mu);
    const lobe first = lobe_make("ggx/smith-separable/none", 1, "alpha=0.4"),
               second = lobe_make("student-t/v-cavity/none", 1, "alpha=0.15 gamma=2.5");
    for (int lobe_at = 0; lobe_at < 2; lobe_at++) {
        p.kernels->albedo_at(&p.loss[lobe_at], 0, SOME_MU, mu, alone);
        for (int i = 0; i < SOME_MU; i++) FF_CHECK_CLOSE(alone[i], albedo(lobe_at ? &second : &first, mu[i], 0).value, 0, 2e-6);
    }
    for (uint32_t k = 0; k < 6; k++) {
        const double h = 1e-4;
        double d[3][SOME_MU], low[3][SOME_MU], high[3][SOME_MU], mean[3], mean_low[3], mean_high[3];
        for (int side = 0; side < 3; side++) {
            lobe moved = l;
            double *x = k < 4 ? &moved.shape[k] : &moved.channel[k - 4];
            *x += (side - 1) * h;
            ff_prepared q = prepare(&moved, &wanted);
            for (int c = 0; c < 3; c++) {
                const ff_albedo_curve *curve = c ? &q.loss[c - 1] : &q.albedo[0];
                const uint32_t function = side == 1 ? 1 + k : 0;
                if (c && k >= 4) continue;
                q.kernels->albedo_at(curve, function, SOME_MU, mu, side == 0 ? low[c] : side == 1 ? d[c] : high[c]);
                *(side == 0 ? &mean_low[c] : side == 1 ? &mean[c] : &mean_high[c]) = curve->mean[function];
            }
            ff_prepared_free(&q);
        }
        for (int c = 0; c < (k < 4 ? 3 : 1); c++) {
            FF_CHECK_CLOSE(mean[c], (mean_high[c] - mean_low[c]) / (2 * h), 0, 2e-7);
            for (int i = 0; i < SOME_MU; i++) FF_CHECK_CLOSE(d[c][i], (high[c][i] - low[c][i]) / (2 * h), 0, 2e-6);
        }
    }
    ff_prepared_free(&p);
}

/* One value on both sides of where polynomials join, and hardly a kink. */
static void curves_join(void)
{
    static const char *const lobes[] = {"beckmann", "ggx", "beckmann/v-cavity", "ggx/v-cavity"};
    const double join[] = {pow(FF_ALBEDO_X_1, 3), pow(FF_ALBEDO_X_2, 3)};
    for (size_t i = 0; i < sizeof lobes / sizeof lobes[0]; i++)
        for (int a = 0; a < 3; a++) {
            char text[MODEL_LABEL], settings[SETTINGS];
            snprintf(text, sizeof text, "%s+kelemen-matte", lobes[i]);
            snprintf(settings, sizeof settings, "alpha=%g", pow(10, -a));
            const lobe l = lobe_make(text, 1, settings);
            ff_prepared p = prepare(&l, NULL);
            for (int k = 0; k < 2; k++) {
                const double h = 1e-5 * join[k], mu[4] = {join[k] - h, join[k] - 1e-15, join[k] + 1e-15, join[k] + h};
                double v[4];
                p.kernels->albedo_at(&p.albedo[0], 0, 4, mu, v);
                FF_CHECK_CLOSE(v[1], v[2], 0, 1e-8);
                FF_CHECK_CLOSE((v[1] - v[0]) / h, (v[3] - v[2]) / h, 0, 2e-3);
            }
            ff_prepared_free(&p);
        }
}

/* Only isotropic lobes have an albedo that depends on the angle alone: a term that reads it must make them so. */
static void coupled_terms_make_lobes_isotropic(void)
{
    int coupled = 0;
    for (size_t i = 0; i < ff_term_count(FF_DIFFUSE); i++) {
        if (!(ff_diffuse_at((int)i)->couples & (FF_COUPLE_ALBEDO | FF_COUPLE_LOSS))) continue;
        FF_CHECK(ff_term_at(FF_DIFFUSE, i)->claims & FF_ISOTROPIC, "%s", ff_term_at(FF_DIFFUSE, i)->name);
        coupled++;
    }
    FF_CHECK(coupled >= 3, "%d coupled terms", coupled);
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

FF_TEST_MAIN(FF_TEST(weak_furnace_is_one), FF_TEST(without_masking_it_is_not_one), FF_TEST(approximate_g1_shows_its_error),
             FF_TEST(infinite_facets), FF_TEST(closed_forms), FF_TEST(published_values), FF_TEST(against_a_plain_sum),
             FF_TEST(sums_and_channels), FF_TEST(weights), FF_TEST(narrow_lobes), FF_TEST(passive_models_reflect_at_most_one),
             FF_TEST(nothing_is_lost), FF_TEST(mikkelsen_loses_the_mean), FF_TEST(curves_follow_the_albedo),
             FF_TEST(curves_have_derivatives), FF_TEST(curves_join), FF_TEST(coupled_terms_make_lobes_isotropic), FF_TEST(refusals))
