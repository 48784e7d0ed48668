/* Figures of the papers that the models come from: every curve against one computed independently from the paper's definitions
 * (figures/make_figures.py), and what the paper says about it. */
#include "fit_samples.h"
#include "ff_albedo.h"
#include "models/model_struct.h"

#define PI 3.14159265358979323846

/* ---- curves ---------------------------------------------------------------------------------- */

enum { COLUMNS = 7, ROWS = 1024 };
typedef struct figure {
    size_t n;
    double row[ROWS][COLUMNS];
} figure;

/* A CSV of figures/: comments, a line of names, rows of `columns` numbers. */
static const figure *figure_read(const char *name, size_t columns)
{
    static figure f;
    char path[512], line[512];
    snprintf(path, sizeof path, "%s/figures/%s", FF_TEST_SOURCE_DIR, name);
    FILE *in = fopen(path, "r");
    f.n = 0;
    FF_CHECK(in != NULL, "%s cannot be read", path);
    for (int named = 0; in && fgets(line, sizeof line, in);) {
        char *text = line;
        if (line[0] == '#') continue;
        if (!named) {
            named = 1;
            continue;
        }
        FF_CHECK(f.n < ROWS, "%s: too many rows", name);
        if (f.n == ROWS) break;
        for (size_t k = 0; k < columns; k++) {
            char *end;
            f.row[f.n][k] = strtod(text, &end);
            FF_CHECK(end != text && (k + 1 < columns ? *end == ',' : *end == '\n'), "%s: row %zu", name, f.n + 1);
            text = end + 1;
        }
        f.n++;
    }
    if (in) fclose(in);
    return &f;
}

static void direction(double theta_deg, double phi, double w[3])
{
    w[0] = sin(theta_deg * FIT_DEGREE) * cos(phi);
    w[1] = sin(theta_deg * FIT_DEGREE) * sin(phi);
    w[2] = cos(theta_deg * FIT_DEGREE);
}

static double albedo(const fit_surface *s, double theta_deg)
{
    double wo[3];
    ff_integral out = {NAN, NAN};
    ff_error err = {0};
    direction(theta_deg, 0, wo);
    FF_CHECK(ff_albedo_directional(&s->model, FF_ISA_BEST, 1, s->shape, s->channel, wo, &out, &err) == FF_OK, "%s", err.message);
    return out.value;
}

static double value(const fit_surface *s, const double wi[3], const double wo[3])
{
    const ff_dirs w = {&wi[0], &wi[1], &wi[2], &wo[0], &wo[1], &wo[2]};
    double f = NAN;
    FF_CHECK(ff_model_eval(&s->model, FF_ISA_BEST, 1, s->shape, s->channel, &w, 1, &f, NULL, 1) == FF_OK, "eval");
    return f;
}

/* A surface "terms" with one parameter set to a number. */
static fit_surface surface(const char *expression, const char *parameter, double x)
{
    char text[64];
    snprintf(text, sizeof text, "%s=%.17g", parameter, x);
    return fit_surface_make(expression, 1, text);
}

/* ---- Kelemen and Szirmay-Kalos 2001 ---------------------------------------------------------- */

/* Figure 3: albedos of the two densities, of Beckmann's with the same masking, and of Cook and Torrance. */
static void kelemen_figure_3(void)
{
    const figure *f = figure_read("kelemen_figure_3.csv", 7);
    double apart[2] = {0, 0};
    FF_CHECK(f->n == 36, "%zu rows", f->n);
    for (size_t i = 0; i < f->n; i++) {
        const double *r = f->row[i], theta = r[2];
        const fit_surface ward = surface("kelemen-ward/kelemen/none", "m", r[1]),
                          phong = surface("kelemen-phong/kelemen/none", "n", r[0]),
                          beckmann = surface("beckmann/kelemen/none", "alpha", r[1]),
                          cook_torrance = surface("beckmann/v-cavity/none", "alpha", r[1]);
        FF_CHECK_CLOSE(albedo(&ward, theta), r[3], 0, 3e-6);
        FF_CHECK_CLOSE(albedo(&phong, theta), r[4], 0, 3e-6);
        FF_CHECK_CLOSE(albedo(&beckmann, theta), r[5], 0, 3e-6);
        FF_CHECK_CLOSE(albedo(&cook_torrance, theta), r[6], 0, 3e-6);
        /* energy is conserved, and the new masking is always below the geometric factor that it replaces */
        FF_CHECK(r[3] < 1 && r[4] < 1 && r[5] < r[6] && r[6] < 1, "theta %g", theta);
        apart[r[1] < 0.5] = fmax(apart[r[1] < 0.5], fabs(r[3] - r[4]));
        /* the lobe's volume grows towards grazing incidence: all the way for the rough surface, in the end for the smoother one */
        if (i % 18 > 0 && (r[1] > 0.5 || theta > 75))
            FF_CHECK(r[3] > f->row[i - 1][3] && r[4] > f->row[i - 1][4], "theta %g", theta);
    }
    FF_CHECK(apart[0] < 0.075 && apart[1] < 0.036, "ward and phong differ by %g and %g", apart[0], apart[1]);
    printf("  ward and phong differ by at most %.3f (m = 0.8), %.3f (m = 0.4)\n", apart[0], apart[1]);
}

/* "to make the maximum of the lobes equal at perpendicular illumination": n = 2 / m^2 - 1, which the figure rounds to 2 and 11. */
static void kelemen_equal_peaks(void)
{
    static const double ms[] = {0.8, 0.4, 0.1}, up[3] = {0, 0, 1};
    for (size_t i = 0; i < 3; i++) {
        const double n = 2 / (ms[i] * ms[i]) - 1;
        const fit_surface ward = surface("kelemen-ward/kelemen/none", "m", ms[i]),
                          phong = surface("kelemen-phong/kelemen/none", "n", n);
        FF_CHECK_CLOSE(value(&ward, up, up), value(&phong, up, up), 1e-12, 0);
        FF_CHECK_CLOSE(value(&ward, up, up), 1 / (4 * PI * ms[i] * ms[i]), 1e-12, 0);
    }
    FF_CHECK_CLOSE(2 / (0.8 * 0.8) - 1, 2, 0, 0.2);
    FF_CHECK_CLOSE(2 / (0.4 * 0.4) - 1, 11, 0, 0.6);
}

/* Section 2.1.3 and figure 2, m = 0.1: f in the mirror direction goes as 1 / cos^2(theta), and the largest f lies below that
 * direction. */
static void kelemen_off_specular_peak(void)
{
    static const double thetas[] = {22.5, 45, 67.5}, up[3] = {0, 0, 1};
    const fit_surface ward = surface("kelemen-ward/kelemen/none", "m", 0.1);
    for (size_t i = 0; i < 3; i++) {
        double wi[3], wo[3], best = 0, where = 0;
        direction(thetas[i], 0, wi);
        direction(thetas[i], PI, wo);
        FF_CHECK_CLOSE(value(&ward, wi, wo) * wi[2] * wi[2], value(&ward, up, up), 1e-12, 0);
        for (double theta = 0; theta < 89.5; theta += 0.01) {
            direction(theta, PI, wo);
            const double f = value(&ward, wi, wo);
            if (f > best) best = f, where = theta;
        }
        FF_CHECK(where > thetas[i] + 0.1 && where < thetas[i] + 5, "light at %g, peak at %g degrees", thetas[i], where);
        printf("  light at %.1f degrees, peak at %.2f\n", thetas[i], where);
    }
}

/* Figure 5, m = 0.8 and k = 1: the matte part gives back what the specular one does not reflect. */
static void kelemen_figure_5(void)
{
    const figure *f = figure_read("kelemen_figure_3.csv", 7);
    for (size_t i = 0; i < f->n; i++) {
        const double *r = f->row[i];
        const fit_surface both = fit_surface_make(r[1] > 0.5 ? "kelemen-ward/kelemen/none+kelemen-matte"
                                                             : "kelemen-phong/kelemen/none+kelemen-matte",
                                                  1, r[1] > 0.5 ? "m=0.8 kd=1" : "n=11 kd=1"),
                          half = fit_surface_make("kelemen-ward/kelemen/none+kelemen-matte", 1, "m=0.8 kd=0.5");
        FF_CHECK_CLOSE(albedo(&both, r[2]), 1, 0, 1e-5);
        if (r[1] > 0.5) FF_CHECK_CLOSE(albedo(&half, r[2]), r[3] + 0.5 * (1 - r[3]), 0, 1e-5);
    }
}

/* ---- Mikkelsen 2009 -------------------------------------------------------------------------- */

static fit_surface mikkelsen(double eta, double k, double kappa)
{
    char text[96];
    snprintf(text, sizeof text, k > 0 ? "kappa=%g eta=%g k=%g" : "kappa=%g eta=%g", kappa, eta, k);
    return fit_surface_make(k > 0 ? "vmf/v-cavity/conductor" : "vmf/v-cavity/dielectric", 1, text);
}

/* Figures 6c and 6d: 1 - rho of methanol and aluminium, and the Fresnel transmittance that it approaches as kappa grows. */
static void mikkelsen_figure_6(void)
{
    const figure *f = figure_read("mikkelsen_figure_6.csv", 6);
    double far[2][3] = {{0}}; /* methanol, aluminium; kappa = 17, 1024, 30000: up to 80 degrees */
    FF_CHECK(f->n == 36, "%zu rows", f->n);
    for (size_t i = 0; i < f->n; i++) {
        const double *r = f->row[i];
        const fit_surface broad = mikkelsen(r[0], r[1], 17), subsample = mikkelsen(r[0], r[1], 1024),
                          thinner = mikkelsen(r[0], r[1], 30000);
        FF_CHECK_CLOSE(1 - albedo(&broad, r[2]), r[4], 0, 3e-6);
        FF_CHECK_CLOSE(1 - albedo(&subsample, r[2]), r[5], 0, 3e-6);
        if (r[2] > 80) continue;
        double *of = far[r[1] > 0];
        of[0] = fmax(of[0], fabs(r[4] - r[3]));
        of[1] = fmax(of[1], fabs(r[5] - r[3]));
        of[2] = fmax(of[2], fabs(1 - albedo(&thinner, r[2]) - r[3]));
    }
    for (int i = 0; i < 2; i++) {
        FF_CHECK(far[i][1] < 0.06 * far[i][0] && far[i][2] < 0.06 * far[i][1], "%g, %g, %g", far[i][0], far[i][1], far[i][2]);
        printf("  %s: off the transmittance by up to %.4f (kappa = 17), %.4f (1024), %.5f (30000)\n", i ? "aluminium" : "methanol",
               far[i][0], far[i][1], far[i][2]);
    }
}

/* What the text reads off the figures. That kappa = 17 "stays above 60 %" holds up to half a degree from the horizon; the limit
 * is 58 %. */
static void mikkelsen_text(void)
{
    const fit_surface broad = mikkelsen(1.329, 0, 17), subsample = mikkelsen(1.329, 0, 1024), metal = mikkelsen(0.769, 6.08, 1024);
    FF_CHECK(1 - albedo(&subsample, 73) > 0.8 && 1 - albedo(&subsample, 77) < 0.8, "above 80 %% until about 75 degrees");
    FF_CHECK_CLOSE(1 - albedo(&subsample, 89.99), 0.14, 0, 0.005);
    FF_CHECK(1 - albedo(&broad, 89.5) > 0.6, "%g", 1 - albedo(&broad, 89.5));
    FF_CHECK_CLOSE(1 - albedo(&broad, 89.99), 0.58, 0, 0.005);
    FF_CHECK(1 - albedo(&metal, 0) < 0.08 && 1 - albedo(&subsample, 0) > 0.97, "the diffuse term of a metal is marginal");
}

/* ---- masking --------------------------------------------------------------------------------- */

static void terms_of(const fit_surface *s, double iz, double oz, double *lambda, double *g)
{
    const double wi[3] = {sqrt(1 - iz * iz), 0, iz}, wo[3] = {-sqrt(1 - oz * oz), 0, oz};
    const ff_dirs w = {&wi[0], &wi[1], &wi[2], &wo[0], &wo[1], &wo[2]};
    const ff_terms t = {.lambda_o = lambda, .g = g};
    FF_CHECK(ff_model_terms(&s->model, FF_ISA_BEST, 1, s->shape, s->channel, 0, 0, &w, 1, &t) == FF_OK, "terms");
}

static double g2(const char *masking, double alpha, double iz, double oz)
{
    char expression[64];
    double lambda, g;
    snprintf(expression, sizeof expression, "ggx/%s/none", masking);
    const fit_surface s = surface(expression, "alpha", alpha);
    terms_of(&s, iz, oz, &lambda, &g);
    return g;
}

static double g1(const fit_surface *s, double theta_deg)
{
    double lambda, g;
    terms_of(s, 1, cos(theta_deg * FIT_DEGREE), &lambda, &g);
    return 1 / (1 + lambda);
}

/* Hammon 2017: the approximations against the exact forms, which are by quadrature of the facets' visible area. */
static void hammon_g2(void)
{
    const figure *f = figure_read("hammon_g2.csv", 7);
    enum { DIRECTIONS = 9 };
    double dark = 0, product = 0, where[3] = {0};
    FF_CHECK(f->n == 8 * DIRECTIONS * DIRECTIONS, "%zu rows", f->n);
    for (size_t i = 0; i < f->n; i++) {
        const double *r = f->row[i], brighter = r[3] / r[4];
        FF_CHECK_CLOSE(g2("smith-height-correlated", r[0], r[1], r[2]), r[3], 0, 1e-7);
        FF_CHECK_CLOSE(g2("smith-separable", r[0], r[1], r[2]), r[4], 0, 1e-7);
        FF_CHECK_CLOSE(g2("hammon", r[0], r[1], r[2]), r[5], 0, 1e-7);
        FF_CHECK_CLOSE(g2("schlick-smith", r[0], r[1], r[2]), r[6], 0, 1e-7);
        /* "uncorrelated G's error: bigger for rougher surfaces, bigger when L and V more glancing": the rows before have a smaller
         * alpha, and a smaller N.L */
        if (i >= DIRECTIONS * DIRECTIONS) {
            const double *smoother = f->row[i - DIRECTIONS * DIRECTIONS];
            FF_CHECK(brighter >= smoother[3] / smoother[4] - 1e-7, "alpha %g at %g, %g", r[0], r[1], r[2]);
        }
        if (i >= DIRECTIONS && f->row[i - DIRECTIONS][0] == r[0]) {
            const double *glancing = f->row[i - DIRECTIONS];
            FF_CHECK(brighter <= glancing[3] / glancing[4] + 1e-7, "alpha %g at %g, %g", r[0], r[1], r[2]);
        }
        FF_CHECK(r[3] >= r[4] - 1e-7, "uncorrelated masking and shadowing take too much");
        if (r[1] == 1 || r[2] == 1) FF_CHECK_CLOSE(r[3], r[4], 0, 1e-7); /* "no error if L = N and/or V = N" */
        FF_CHECK(r[5] <= r[3] + 1e-7 && r[6] <= r[4] + 1e-7, "\"a little too dark\": alpha %g at %g, %g", r[0], r[1], r[2]);
        if (r[0] == 1) FF_CHECK_CLOSE(r[5], r[3], 0, 1e-7);
        if (r[3] - r[5] > dark) dark = r[3] - r[5], memcpy(where, r, sizeof where);
        product = fmax(product, r[4] - r[6]);
    }
    /* "medium angles and roughness", and not at alpha = 1 */
    FF_CHECK(dark > 0.15 && dark < 0.24 && where[0] < 0.5, "darkest by %g at alpha %g, %g, %g", dark, where[0], where[1], where[2]);
    FF_CHECK(product < 0.27, "%g", product);
    printf("  hammon too dark by up to %.4f (alpha %g, N.L %g, N.V %g), the product form by %.4f\n", dark, where[0], where[1],
           where[2], product);
}

/* Walter et al. 2007: the rational G1 over a, which exceeds 1 by 6e-5 just below a = 1.6. */
static void walter_g1(void)
{
    const figure *f = figure_read("walter_g1.csv", 3);
    const fit_surface exact = surface("beckmann", "alpha", 1), rational = surface("beckmann-walter", "alpha", 1);
    double off = 0;
    FF_CHECK(f->n == 24, "%zu rows", f->n);
    for (size_t i = 0; i < f->n; i++) {
        const double *r = f->row[i], theta = atan(1 / r[0]) / FIT_DEGREE;
        FF_CHECK_CLOSE(g1(&exact, theta), r[1], 0, 1e-7);
        FF_CHECK_CLOSE(g1(&rational, theta), r[2], 0, 1e-7);
        off = fmax(off, fabs(r[1] - r[2]));
    }
    FF_CHECK(off > 0.002 && off < 0.0032, "%g", off);
    printf("  off by up to %.5f\n", off);
}

/* Heitz 2014, section 7: the masking of phong, which has a closed form, and what is commonly used for it. */
static void phong_g1(void)
{
    static const struct {
        double n, off;
    } known[] = {{1, 0.125}, {5, 0.046}, {20, 0.014}, {100, 0.0037}};
    const figure *f = figure_read("phong_g1.csv", 4);
    FF_CHECK(f->n == 72, "%zu rows", f->n);
    for (size_t k = 0; k < sizeof known / sizeof known[0]; k++) {
        const fit_surface exact = surface("phong", "n", known[k].n), rational = surface("phong-walter", "n", known[k].n);
        double off = 0;
        for (size_t i = 0; i < f->n; i++) {
            const double *r = f->row[i];
            if (r[0] != known[k].n) continue;
            FF_CHECK_CLOSE(g1(&exact, r[1]), r[2], 0, 1e-7);
            FF_CHECK_CLOSE(g1(&rational, r[1]), r[3], 0, 1e-7);
        }
        for (double theta = 1; theta < 90; theta += 0.5) off = fmax(off, fabs(g1(&exact, theta) - g1(&rational, theta)));
        FF_CHECK_CLOSE(off, known[k].off, 0.02, 5e-4);
        printf("  n = %g: off by up to %.4f\n", known[k].n, off);
    }
}

FF_TEST_MAIN(FF_TEST(kelemen_figure_3), FF_TEST(kelemen_equal_peaks), FF_TEST(kelemen_off_specular_peak), FF_TEST(kelemen_figure_5),
             FF_TEST(mikkelsen_figure_6), FF_TEST(mikkelsen_text), FF_TEST(hammon_g2), FF_TEST(walter_g1), FF_TEST(phong_g1))
