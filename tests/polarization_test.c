/* Polarized light: the reflectances of s and p light against Fresnel's equations in complex numbers, the turn of a facet's plane of
 * incidence against fields that are projected as vectors, and files whose channels are both. */
#include "fit_samples.h"
#include "data_formats/analysis/ff_polarization.h"
#include <complex.h>

static const double pi = 3.14159265358979323846;

/* Amplitudes of a medium of the index N, by Fresnel's equations. */
static double reflectance(double complex N, double c, int s)
{
    const double complex inside = csqrt(1 - (1 - c * c) / (N * N));
    const double complex r = s ? (c - N * inside) / (c + N * inside) : (N * c - inside) / (N * c + inside);
    return creal(r) * creal(r) + cimag(r) * cimag(r);
}

/* What a detector takes of light that is s or p polarized with regard to the sample: its field is split at the facet. */
static double by_vectors(const double wi[3], const double wo[3], double complex N, int s)
{
    double h[3], field[3], across[3];
    for (int k = 0; k < 3; k++) h[k] = wi[k] + wo[k];
    const double length = sqrt(h[0] * h[0] + h[1] * h[1] + h[2] * h[2]), c = length / 2, t = hypot(wi[0], wi[1]);
    for (int k = 0; k < 3; k++) h[k] /= length;
    const double x[3] = {t > 0 ? wi[0] / t : 1, t > 0 ? wi[1] / t : 0, 0}, s_hat[3] = {-x[1], x[0], 0};
    for (int k = 0; k < 3; k++) {
        const int a = (k + 1) % 3, b = (k + 2) % 3;
        field[k] = s ? s_hat[k] : s_hat[a] * wi[b] - s_hat[b] * wi[a];
        across[k] = h[a] * wi[b] - h[b] * wi[a];
    }
    const double n = sqrt(across[0] * across[0] + across[1] * across[1] + across[2] * across[2]);
    const double along = (field[0] * across[0] + field[1] * across[1] + field[2] * across[2]) / n;
    return along * along * reflectance(N, c, 1) + (1 - along * along) * reflectance(N, c, 0);
}

static double F_of(const char *expression, const char *set, const double wi[3], const double wo[3])
{
    const fit_surface s = fit_surface_make(expression, 1, set);
    const ff_dirs w = {&wi[0], &wi[1], &wi[2], &wo[0], &wo[1], &wo[2]};
    double f, plain;
    const fit_surface none = fit_surface_make("ggx/v-cavity/none", 1, "alpha=0.4");
    if (ff_model_eval(&s.model, FF_ISA_BEST, 1, s.shape, s.channel, &w, 1, &f, NULL, 1)) exit(1);
    if (ff_model_eval(&none.model, FF_ISA_BEST, 1, none.shape, none.channel, &w, 1, &plain, NULL, 1)) exit(1);
    return f / plain;
}

static const struct {
    double eta, k;
} media[] = {{1.5, 0}, {1.33, 0}, {2.4, 0}, {0.2, 3.9}, {1.4, 7.6}, {3.1, 3.3}};

static void model_of(size_t m, double share, char expression[64], char set[96])
{
    snprintf(expression, 64, "ggx/v-cavity/%s-polarized", media[m].k > 0 ? "conductor" : "dielectric");
    if (media[m].k > 0)
        snprintf(set, 96, "alpha=0.4 eta=%.17g k=%.17g s_share=%.17g", media[m].eta, media[m].k, share);
    else
        snprintf(set, 96, "alpha=0.4 eta=%.17g s_share=%.17g", media[m].eta, share);
}

static void fresnel_by_vectors(void)
{
    double worst = 0;
    for (size_t m = 0; m < sizeof media / sizeof *media; m++)
        for (int i = 0; i < 300; i++) {
            double w[2][3];
            char expression[64], set[96];
            for (int k = 0; k < 2; k++) {
                const double phi = 2 * pi * ff_test_uniform(), z = 0.02 + 0.98 * ff_test_uniform(), t = sqrt(1 - z * z);
                /* along the normal, nearly so, anywhere; and in the plane of incidence */
                const double scale = k == 0 && i % 10 == 0 ? 0 : k == 0 && i % 10 == 1 ? 1e-4 : 1, at = k && i % 10 < 5 ? 0.3 : phi;
                w[k][0] = scale * t * cos(i % 10 < 5 && k == 0 ? 0.3 + pi : at),
                w[k][1] = scale * t * sin(i % 10 < 5 && k == 0 ? 0.3 + pi : at);
                w[k][2] = sqrt(1 - w[k][0] * w[k][0] - w[k][1] * w[k][1]);
            }
            for (int s = 0; s < 2; s++) {
                model_of(m, s, expression, set);
                const double expected = by_vectors(w[0], w[1], media[m].eta + I * media[m].k, s),
                             F = F_of(expression, set, w[0], w[1]);
                worst = fmax(worst, fabs(F - expected));
                FF_CHECK(fabs(F - expected) < 1e-12, "eta %g, k %g, %c, pair %d: %.10g, by vectors %.10g", media[m].eta, media[m].k,
                         s ? 's' : 'p', i, F, expected);
            }
        }
    printf("    worst %.1e\n", worst);
}

/* In the plane of incidence, at the angle whose tangent is the index: no p light, and ((eta^2 - 1) / (eta^2 + 1))^2 of the s light.
 */
static void brewster(void)
{
    for (double eta = 1.1; eta < 4; eta += 0.1) {
        const double theta = atan(eta), wi[3] = {sin(theta), 0, cos(theta)}, wo[3] = {-sin(theta), 0, cos(theta)};
        const double root = (eta * eta - 1) / (eta * eta + 1);
        char set[96];
        snprintf(set, sizeof set, "alpha=0.4 eta=%.17g s_share=0", eta);
        const double p = F_of("ggx/v-cavity/dielectric-polarized", set, wi, wo);
        snprintf(set, sizeof set, "alpha=0.4 eta=%.17g s_share=1", eta);
        const double s = F_of("ggx/v-cavity/dielectric-polarized", set, wi, wo);
        FF_CHECK(fabs(p) < 1e-15, "eta %g: %g of the p light at Brewster's angle", eta, p);
        FF_CHECK_CLOSE(s, root * root, 1e-13, 0);
    }
}

/* Half of each is the term of unpolarized light, and so is the mean of both, to the last bits; on every instruction set. */
static void mean_is_unpolarized(void)
{
    enum { N = 500 };
    static double w[6][N], f[4][N];
    for (size_t i = 0; i < N; i++)
        for (int k = 0; k < 2; k++) {
            const double phi = 2 * pi * ff_test_uniform(), z = 0.01 + 0.99 * ff_test_uniform(), t = sqrt(1 - z * z);
            w[3 * k][i] = t * cos(phi), w[3 * k + 1][i] = t * sin(phi), w[3 * k + 2][i] = z;
        }
    const ff_dirs dirs = {w[0], w[1], w[2], w[3], w[4], w[5]};
    for (int isa = FF_ISA_SCALAR; isa <= FF_ISA_AVX512; isa++)
        for (size_t m = 0; m < sizeof media / sizeof *media; m++) {
            static const double share[] = {0, 0.5, 1};
            if (!ff_isa_available((ff_isa)isa)) continue;
            char expression[64], set[96];
            for (int k = 0; k < 4; k++) {
                model_of(m, share[k % 3], expression, set);
                if (k == 3) *strstr(expression, "-polarized") = '\0', *strstr(set, " s_share") = '\0';
                const fit_surface s = fit_surface_make(expression, 1, set);
                const ff_status status = ff_model_eval(&s.model, (ff_isa)isa, 1, s.shape, s.channel, &dirs, N, f[k], NULL, N);
                if (!FF_CHECK(status == FF_OK, "%s", expression)) return;
                if (k < 3) continue;
                for (size_t i = 0; i < N; i++) {
                    FF_CHECK(fabs(f[1][i] - f[3][i]) <= 1e-15 * f[3][i], "%s: half of each %.17g, unpolarized %.17g", expression,
                             f[1][i], f[3][i]);
                    FF_CHECK(fabs((f[0][i] + f[2][i]) / 2 - f[3][i]) <= 1e-15 * f[3][i], "%s: mean %.17g, unpolarized %.17g",
                             expression, (f[0][i] + f[2][i]) / 2, f[3][i]);
                }
            }
        }
}

static void names(void)
{
    static const struct {
        const char *name;
        double share;
    } cases[] = {{"s", 1},           {"P", 0},        {"633nm s", 1},       {"532nm_p", 0},
                 {"TE", 1},          {"tm", 0},       {"s-pol", 1},         {"Ppol", 0},
                 {"perp", 1},        {"parallel", 0}, {"pol_senkrecht", 1}, {"unpolarised", 0.5},
                 {"red", NAN},       {"", NAN},       {"s/p", NAN},         {"sp", NAN},
                 {"polarized", NAN}, {"450nm", NAN}};
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
        const double said = ff_polarization_of_name(cases[k].name);
        FF_CHECK(said == cases[k].share || (isnan(said) && isnan(cases[k].share)), "'%s' says %g", cases[k].name, said);
    }
}

static void models_become_polarized(void)
{
    static const struct {
        const char *plain, *polarized; /* NULL: refused */
    } cases[] = {{"ggx/v-cavity/dielectric+lambert", "ggx/v-cavity/dielectric-polarized+lambert"},
                 {"ggx/smith-separable/conductor+beckmann/v-cavity/dielectric",
                  "ggx/smith-separable/conductor-polarized+beckmann/v-cavity/dielectric-polarized"},
                 {"ggx/smith-separable/dielectric+ggx/smith-separable/shared",
                  "ggx/smith-separable/dielectric-polarized+ggx/smith-separable/shared"},
                 {"cook-torrance", "beckmann/v-cavity/dielectric-polarized+lambert"},
                 {"ggx+lambert", NULL},
                 {"lambert", NULL}};
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
        ff_model m;
        char name[FF_MODEL_NAME];
        ff_error err = {0};
        if (ff_model_parse(cases[k].plain, &m, NULL)) exit(1);
        const ff_model before = m;
        const ff_status status = ff_model_polarize(&m, 0.25, &err);
        if (!cases[k].polarized) {
            FF_CHECK(status == FF_ERR_UNSUPPORTED && memcmp(&before, &m, sizeof m) == 0, "%s: %s", cases[k].plain, err.message);
            continue;
        }
        ff_model_expression(&m, name, sizeof name);
        FF_CHECK(status == FF_OK && !strcmp(name, cases[k].polarized), "%s becomes %s: %s", cases[k].plain, name, err.message);
        const ff_param_ref share = ff_model_param_find(&m, "s_share"), ks = ff_model_param_find(&m, "ks");
        const ff_model_param *p = ff_model_param_at(&m, share);
        FF_CHECK(p && p->init == 0.25 && (p->flags & FF_PARAM_HELD), "%s: the share is not held", name);
        FF_CHECK(ff_model_param_at(&m, ks)->init == ff_model_param_at(&before, ff_model_param_find(&before, "ks"))->init, "%s: ks",
                 name);
        FF_CHECK(ff_model_polarize(&m, 2, NULL) == FF_ERR_RANGE && ff_model_polarize(&m, NAN, NULL) == FF_ERR_RANGE,
                 "a share of 2");
        FF_CHECK(ff_model_polarize(&m, 1, NULL) == FF_OK && ff_model_param_at(&m, share)->init == 1, "once more");
    }
}

/* s and p light of one metal tell its index, which light of both kinds hardly does. */
static void index_of_a_metal(void)
{
    const fit_surface s = fit_surface_make("ggx/smith-height-correlated/conductor-polarized+lambert", 2,
                                           "alpha=0.25 eta=1.4 k=4 kd=0.02 s_share=1:0");
    const fit_sampling how = {.n = 1500, .max_theta = 80, .glossy = 0.5, .noise = 0.01, .seed = ff_test_seeded(4)};
    ff_table t = fit_measure(&s, &how);
    const ff_tie tie[] = {{"eta", NULL}, {"k", NULL}};
    const double share[] = {1, 0};
    const ff_fixed fixed = {"s_share", 2, share, NULL};
    const ff_constraints c = {.n_ties = 2, .tie = tie, .n_fixed = 1, .fixed = &fixed};
    ff_fit_options o = fit_options();
    ff_fit_result r;
    ff_error err = {0};
    o.shape = FF_SHAPE_ISOTROPIC;
    o.constraints = &c;
    if (FF_CHECK(fit_table(&t, &s.model, &o, &r, NULL, &err) == FF_OK, "%s", err.message)) {
        for (size_t k = 0; k < 2; k++) {
            const ff_fit_value *v = &r.channel_value[k];
            const double truth = s.channel[k];
            FF_CHECK(fabs(v->value - truth) < 4.5 * v->std_error && v->std_error < 0.1 * truth, "%s: %g +- %g, is %g",
                     k ? "k" : "eta", v->value, v->std_error, truth);
        }
        ff_fit_result_clear(&r);
    }
    ff_table_clear(&t);
}

FF_TEST_MAIN(FF_TEST(fresnel_by_vectors), FF_TEST(brewster), FF_TEST(mean_is_unpolarized), FF_TEST(names),
             FF_TEST(models_become_polarized), FF_TEST(index_of_a_metal))
