/* The Cook-Torrance numbers of Ngan, Durand and Matusik 2005 for the MERL materials, found again in their convention.
 *
 *   theirs  rho_d / pi + rho_s / pi D F G / (n.l n.v), D = exp(-tan^2 / m^2) / (m^2 cos^4), F = F0 + (1 - F0)(1 - v.h)^5,
 *           G of V-grooves; rho_d and rho_s per channel, F0 and m shared (Cook and Torrance 1981 with Schlick's F)
 *   here    kd / pi + ks D' F G / (4 n.l n.v), D' = D / pi: kd = rho_d, ks = 4 rho_s, f0 = F0, alpha = m
 *
 * That is the preset ngan-2005 with ks freed. Measurements are made by the formula written out below, not by the models. */
#include "fit_samples.h"

enum { CHANNELS = 3, SAMPLES = 20000, NAME = 48, DRAWN = 12 };
static const double pi = 3.14159265358979323846, tolerance = 1e-5;
static const char *const preset = "ngan-2005";

typedef struct material {
    char name[NAME];
    double rho_d[CHANNELS], rho_s[CHANNELS], F0, m;
} material;

/* Four of the published sets: two metals, a metallic paint, a fabric. */
static const material examples[] = {
    {"nickel", {0.0342, 0.0256, 0.014}, {0.16, 0.124, 0.0798}, 0.733, 0.0424},
    {"alum-bronze", {0.0886, 0.0602, 0.0299}, {0.118, 0.0698, 0.0371}, 0.203, 0.0367},
    {"gold-metallic-paint", {0.0657, 0.0312, 0.00247}, {0.231, 0.135, 0.0387}, 0.663, 0.241},
    {"beige-fabric", {0.228, 0.133, 0.0798}, {0.175, 0.11, 0.0622}, 0.158, 0.741},
};
enum { EXAMPLES = sizeof examples / sizeof *examples };

/* ---- their formula --------------------------------------------------------------------------- */

/* a: theta_i, phi_i, theta_o, phi_o in radians. */
static double as_published(const material *s, size_t c, const double a[4])
{
    const double l[3] = {sin(a[0]) * cos(a[1]), sin(a[0]) * sin(a[1]), cos(a[0])};
    const double v[3] = {sin(a[2]) * cos(a[3]), sin(a[2]) * sin(a[3]), cos(a[2])};
    const double sum[3] = {l[0] + v[0], l[1] + v[1], l[2] + v[2]};
    const double length = sqrt(sum[0] * sum[0] + sum[1] * sum[1] + sum[2] * sum[2]);
    const double nl = l[2], nv = v[2], nh = sum[2] / length, vh = (v[0] * sum[0] + v[1] * sum[1] + v[2] * sum[2]) / length;
    const double tan2 = (1 - nh * nh) / (nh * nh);
    const double D = exp(-tan2 / (s->m * s->m)) / (s->m * s->m * pow(nh, 4));
    const double F = s->F0 + (1 - s->F0) * pow(1 - vh, 5);
    const double G = fmin(1, fmin(2 * nh * nv / vh, 2 * nh * nl / vh));
    return s->rho_d[c] / pi + s->rho_s[c] / pi * D * F * G / (nl * nv);
}

static ff_table measure(const material *s)
{
    ff_table t;
    uint64_t state = ff_test_stream("material %s", s->name);
    const fit_sampling how = {.n = SAMPLES, .max_theta = 80, .glossy = 0.5};
    if (ff_table_init(how.n, CHANNELS, NULL, 0, 0, &t, NULL)) {
        printf("out of memory for the test's samples\n");
        exit(1);
    }
    fit_directions(&how, &t, &state);
    for (size_t i = 0; i < t.n; i++) {
        const double a[4] = {t.angle[0][i], t.angle[1][i], t.angle[2][i], t.angle[3][i]};
        for (size_t c = 0; c < CHANNELS; c++) t.value[c * t.n + i] = as_published(s, c, a);
    }
    return t;
}

/* ---- found again ----------------------------------------------------------------------------- */

static ff_fit_options isotropic(void)
{
    ff_fit_options o = fit_options();
    o.shape = FF_SHAPE_ISOTROPIC;
    return o;
}

/* A parameter of a result by name, channel c. */
static const ff_fit_value *found(const ff_fit_result *r, const char *name, size_t c)
{
    const ff_fit_value *v = ff_fit_result_find(r, name, c);
    if (!v) {
        printf("the test itself is wrong: no parameter %s\n", name);
        exit(1);
    }
    return v;
}

/* Counts one number and returns its relative error. */
static double compare(const char *what, const char *name, double value, double published, double scale)
{
    const double error = fabs(value - published) / scale;
    FF_CHECK(error <= tolerance, "%s: %s is %.9g, published %.9g", what, name, value, published);
    return error;
}

/* Fits from the default start and compares every number; the largest error of F0 and m. */
static double recover_from(const material *s, const ff_table *t)
{
    ff_error err = {0};
    ff_fit_result r;
    ff_model model;
    double worst = 0;
    const ff_fit_options o = isotropic();
    if (ff_model_parse(preset, &model, &err) || ff_model_vary(&model, "ks", &err)) {
        FF_CHECK(0, "%s: %s", preset, err.message);
        return 1;
    }
    const ff_status status = fit_table(t, &model, &o, &r, NULL, &err);
    FF_CHECK(status == FF_OK, "%s: %s", s->name, err.message);
    if (status) return 1;
    FF_CHECK(r.outcome == FF_CONVERGED, "%s: %s", s->name, ff_outcome_name((int)r.outcome));
    worst = compare(s->name, "m", found(&r, "alpha_x", 0)->value, s->m, s->m);
    for (size_t c = 0; c < CHANNELS; c++) {
        worst = fmax(worst, compare(s->name, "F0", found(&r, "f0", c)->value, s->F0, s->F0));
        compare(s->name, "rho_s", found(&r, "ks", c)->value / 4, s->rho_s[c], s->rho_s[c]);
        compare(s->name, "rho_d", found(&r, "kd", c)->value, s->rho_d[c], fmax(s->rho_d[c], 1e-3));
    }
    ff_fit_result_clear(&r);
    return worst;
}

/* The same of a simulated measurement. */
static double recover(const material *s)
{
    ff_table t = measure(s);
    const double worst = recover_from(s, &t);
    ff_table_clear(&t);
    return worst;
}

static void examples_come_back(void)
{
    for (size_t i = 0; i < EXAMPLES; i++) printf("  %-24s worst error of F0 and m %.1e\n", examples[i].name, recover(&examples[i]));
}

/* "NAME = Aggregate(Lambertian(albedo = [r, g, b]), NganCookTorrance(albedo = [r, g, b], eta = F0, roughness = m))" */
static int read_line(const char *line, material *out)
{
    const int n =
        sscanf(line,
               "%47s = Aggregate(Lambertian(albedo = [%lf, %lf, %lf]), NganCookTorrance(albedo = [%lf, %lf, %lf], eta = %lf, "
               "roughness = %lf))",
               out->name, &out->rho_d[0], &out->rho_d[1], &out->rho_d[2], &out->rho_s[0], &out->rho_s[1], &out->rho_s[2], &out->F0,
               &out->m);
    return n == 9;
}

/* Every material of their supplement, and the examples above as they stand there. */
static void the_whole_table_comes_back(void)
{
    char path[1024], line[1024];
    material s;
    double worst = 0;
    size_t n = 0, seen = 0;
    FILE *f = ff_test_shared("data/tables/ngan_cooktorrance.fit", path, sizeof path) ? fopen(path, "r") : NULL;
    /* not part of the project: without the supplement beside it there is no table to convert */
    if (!f) FF_SKIP("data/tables/ngan_cooktorrance.fit is not there");
    while (fgets(line, sizeof line, f)) {
        if (line[0] == '#' || line[0] == '\n') continue;
        const int whole = read_line(line, &s);
        FF_CHECK(whole, "not understood: %s", line);
        if (!whole) continue;
        for (size_t i = 0; i < EXAMPLES; i++) {
            if (strcmp(examples[i].name, s.name) != 0) continue;
            FF_CHECK(examples[i].F0 == s.F0 && examples[i].m == s.m && memcmp(examples[i].rho_s, s.rho_s, sizeof s.rho_s) == 0 &&
                         memcmp(examples[i].rho_d, s.rho_d, sizeof s.rho_d) == 0,
                     "%s is not as in the table", s.name);
            seen++;
        }
        worst = fmax(worst, recover(&s));
        n++;
    }
    fclose(f);
    FF_CHECK(n > 80 && seen == EXAMPLES, "%zu materials, %zu of the examples", n, seen);
    printf("  %zu materials, worst error of F0 and m %.1e\n", n, worst);
}

/* ---- found again where there is no supplement -------------------------------------------------- */

/* Sets over the range of the supplement's. */
static material drawn(size_t k)
{
    material s;
    uint64_t state = ff_test_stream("drawn %zu", k);
    snprintf(s.name, sizeof s.name, "drawn-%zu", k);
    s.F0 = 0.03 + 0.9 * fit_uniform(&state);
    s.m = 0.01 * pow(60, fit_uniform(&state));
    for (size_t c = 0; c < CHANNELS; c++) {
        s.rho_d[c] = 0.01 + 0.3 * fit_uniform(&state);
        s.rho_s[c] = 0.02 + 0.25 * fit_uniform(&state);
    }
    return s;
}

static void drawn_ones_come_back(void)
{
    double worst = 0;
    for (size_t k = 0; k < DRAWN; k++) {
        const material s = drawn(k);
        worst = fmax(worst, recover(&s));
    }
    printf("  %d materials, worst error of F0 and m %.1e\n", DRAWN, worst);
}

/* A file in the database's layout that a script writes by the published formula: read, fitted, compared. */
static void made_file_comes_back(void)
{
    char command[2048], path[512];
    const material *s = &examples[2];
    ff_table t;
    ff_error err = {0};
    snprintf(path, sizeof path, "%s", ff_test_path("made.binary"));
    snprintf(command, sizeof command, "'%s' '%s/made/make_merl.py' '%s' %.17g %.17g %.17g %.17g %.17g %.17g %.17g %.17g",
             FF_PYTHON3, FF_TEST_SOURCE_DIR, path, s->F0, s->m, s->rho_d[0], s->rho_d[1], s->rho_d[2], s->rho_s[0], s->rho_s[1],
             s->rho_s[2]);
    const int exited = system(command);
    /* the writer of MERL files is a script of its own, which says by 77 that it lacks numpy */
    if (exited == 77 << 8) FF_SKIP("%s has no numpy", FF_PYTHON3);
    FF_CHECK(exited == 0, "%s: %d", command, exited);
    const ff_status status = ff_table_read_into(path, NULL, &t, &err);
    FF_CHECK(status == FF_OK && strcmp(t.format, "merl") == 0 && t.n == 90 * 90 * 180, "%s", err.message);
    if (status) return;
    recover_from(s, &t);
    ff_table_clear(&t);
}

/* ---- the mapping itself ---------------------------------------------------------------------- */

/* The preset is their formula for rho_s = 1, value by value. */
static void preset_is_their_formula(void)
{
    enum { N = 500 };
    for (size_t e = 0; e < EXAMPLES; e++) {
        material s = examples[e];
        char values[256];
        for (size_t c = 0; c < CHANNELS; c++) s.rho_s[c] = 1;
        snprintf(values, sizeof values, "alpha=%.17g f0=%.17g kd=%.17g:%.17g:%.17g", s.m, s.F0, s.rho_d[0], s.rho_d[1], s.rho_d[2]);
        const fit_surface here = fit_surface_make(preset, CHANNELS, values);
        const fit_sampling how = {.n = N, .max_theta = 89, .glossy = 0.5, .seed = e};
        ff_table t = fit_measure(&here, &how);
        for (size_t i = 0; i < t.n; i++) {
            const double a[4] = {t.angle[0][i], t.angle[1][i], t.angle[2][i], t.angle[3][i]};
            for (size_t c = 0; c < CHANNELS; c++) FF_CHECK_CLOSE(t.value[c * t.n + i], as_published(&s, c, a), 1e-9, 1e-12);
        }
        ff_table_clear(&t);
    }
}

/* Why ks must be free: with ks = 1 Schlick's term reaches 1 at grazing angles where theirs reaches 4 rho_s, and F0 and m give way.
 */
static void with_ks_held_at_one(void)
{
    ff_error err = {0};
    ff_fit_result r;
    ff_model model;
    const material *s = &examples[0];
    const ff_fit_options o = isotropic();
    ff_table t = measure(s);
    ff_status status = ff_model_parse("beckmann/v-cavity/schlick+lambert", &model, &err);
    if (!status) status = fit_table(&t, &model, &o, &r, NULL, &err);
    ff_table_clear(&t);
    FF_CHECK(status == FF_OK, "%s", err.message);
    if (status) return;
    const double m = found(&r, "alpha_x", 0)->value, f0 = found(&r, "f0", 0)->value;
    printf("  %s with ks = 1: alpha %.4f (m %.4f), f0 of red %.3f (4 rho_s F0 = %.3f)\n", s->name, m, s->m, f0,
           4 * s->rho_s[0] * s->F0);
    FF_CHECK(fabs(m / s->m - 1) > 0.1 && fabs(f0 / (4 * s->rho_s[0] * s->F0) - 1) > 0.1,
             "alpha %g and f0 %g come back without the scale: then it need not be free", m, f0);
    ff_fit_result_clear(&r);
}

FF_TEST_MAIN(FF_TEST(preset_is_their_formula), FF_TEST(examples_come_back), FF_TEST(drawn_ones_come_back),
             FF_TEST(made_file_comes_back), FF_TEST(the_whole_table_comes_back), FF_TEST(with_ks_held_at_one))
