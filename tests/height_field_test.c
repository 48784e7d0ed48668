/* Rays on height fields: slopes that were asked for, light that is neither lost nor made, masking against Smith's where it is known
 * to hold, maps whose light goes where geometry says, every format of a map, threads. Skipped where the module of Embree is not
 * built. */
#include "model_samples.h"
#include "ff_albedo.h"
#include "ff_height_field.h"
#include "simulate/surface/rays_bridge.h"

#define SMITH "/smith-height-correlated"
static const double most_off = 5.5; /* errors of 12 realisations and more: wide tails */

typedef struct scene {
    ff_model model;
    double shape[FF_MAX_SHAPE], channel[FF_MAX_CHANNEL_PARAMS];
    ff_height_field_options o;
    ff_height_field *field;
} scene;

#define NEEDS_THE_MODULE                                                                                                           \
    const ff_rays *rays;                                                                                                           \
    ff_error missing = {0};                                                                                                        \
    if (ff_rays_get(&rays, &missing)) FF_SKIP("%s", missing.message)

static void scene_make(scene *s, const char *expression, const char *set)
{
    ff_error err = {0};
    char words[200];
    *s = (scene){.field = NULL};
    FF_CHECK(ff_model_parse(expression, &s->model, &err) == FF_OK, "%s", err.message);
    ff_model_defaults(&s->model, 1, s->shape, s->channel);
    snprintf(words, sizeof words, "%s", set);
    for (char *word = strtok(words, " "); word; word = strtok(NULL, " "))
        FF_CHECK(ff_model_set(&s->model, 1, word, s->shape, s->channel, &err) == FF_OK, "%s", err.message);
    ff_height_field_options_init(&s->o);
    s->o.cells = 256;
    s->o.realisations = 12;
    s->o.paths = 240000;
    s->o.seed = ff_test_stream("%s %s", expression, set);
}

static void scene_open(scene *s)
{
    ff_error err = {0};
    if (!FF_CHECK(ff_height_field_new(&s->model, 1, s->shape, s->channel, &s->o, &s->field, &err) == FF_OK, "%s", err.message))
        exit(1);
}

static ff_lobe_mean lobe_of(const scene *s, double theta, double phi, double *lost)
{
    ff_lobe_mean lobe[FF_WALK_ORDERS] = {{0}};
    ff_error err = {0};
    double wi[3];
    model_direction(theta * FIT_DEGREE, phi * FIT_DEGREE, wi);
    FF_CHECK(ff_height_field_lobes(s->field, wi, 1, lobe, lost, &err) == FF_OK, "%s", err.message);
    return lobe[0];
}

/* ---- surfaces of a spectrum ------------------------------------------------------------------ */

static void slopes_as_asked(void)
{
    static const char *const sets[] = {"alpha=0.3", "alpha_x=0.2 alpha_y=0.5 r_xy=0.6", "alpha_x=1 alpha_y=0.4 r_xy=-0.4"};
    NEEDS_THE_MODULE;
    for (int spectrum = 0; spectrum < 3; spectrum++)
        for (int k = 0; k < 3; k++) {
            scene s;
            ff_slopes a;
            ff_error err = {0};
            enum { RINGS = 30 };
            double d[RINGS], error[RINGS], area = 0;
            scene_make(&s, "beckmann", sets[k]);
            s.o.spectrum = (ff_spectrum)spectrum;
            scene_open(&s);
            FF_CHECK(ff_height_field_slopes(s.field, &a, RINGS, d, error, &err) == FF_OK, "%s", err.message);
            FF_CHECK_CLOSE(a.alpha_x, s.shape[0], 1e-9, 0);
            FF_CHECK_CLOSE(a.alpha_y, s.shape[1], 1e-9, 0);
            FF_CHECK(fabs(a.r_xy - s.shape[2]) < most_off * a.r_xy_error + (spectrum ? 0.03 : 0) && a.r_xy_error < 0.05,
                     "r_xy %g +- %g, not %g", a.r_xy, a.r_xy_error, s.shape[2]);
            FF_CHECK(fabs(a.kurtosis - 3) < 0.2, "kurtosis %g", a.kurtosis);
            /* the projected area of all normals: 1, but for the width of the rings */
            for (int i = 0; i < RINGS; i++)
                area += d[i] * MODEL_PI * (pow(sin((i + 1) * 3 * FIT_DEGREE), 2) - pow(sin(i * 3 * FIT_DEGREE), 2));
            FF_CHECK_CLOSE(area, 1, 5e-3, 0);
            ff_height_field_free(s.field);
        }
}

/* Where Smith's masking is known to hold the light of one facet is that of the model; all light leaves. */
static void light_of_a_gaussian_surface(void)
{
    static const struct {
        const char *set;
        double theta, near;
    } cases[] = {{"alpha=0.4", 0, 0.01}, {"alpha=0.4", 60, 0.01}, {"alpha_x=0.2 alpha_y=0.6 r_xy=0.5", 50, 0.015}};
    NEEDS_THE_MODULE;
    for (int k = 0; k < 3; k++) {
        scene s;
        double lost = 1, wo[3];
        ff_integral want;
        ff_error err = {0};
        scene_make(&s, "beckmann" SMITH "/none", cases[k].set);
        scene_open(&s);
        const ff_lobe_mean all = lobe_of(&s, cases[k].theta, 30, &lost);
        FF_CHECK(fabs(all.albedo + lost - 1) < 1e-9 && lost < 1e-4, "%g leaves, %g is lost", all.albedo, lost);
        ff_height_field_free(s.field);
        s.o.orders[0] = (ff_orders){1, 1};
        scene_open(&s);
        const ff_lobe_mean one = lobe_of(&s, cases[k].theta, 30, NULL);
        model_direction(cases[k].theta * FIT_DEGREE, 30 * FIT_DEGREE, wo);
        FF_CHECK(ff_albedo_directional(&s.model, FF_ISA_BEST, 1, s.shape, s.channel, wo, &want, &err) == FF_OK, "%s", err.message);
        FF_CHECK(fabs(one.albedo - want.value) < cases[k].near + most_off * one.albedo_error && one.albedo_error < 0.01,
                 "%s, %g: %g +- %g, the model has %g", cases[k].set, cases[k].theta, one.albedo, one.albedo_error, want.value);
        ff_height_field_free(s.field);
    }
}

static void what_is_seen(void)
{
    NEEDS_THE_MODULE;
    scene s;
    ff_seen seen[3];
    ff_error err = {0};
    double w[9];
    scene_make(&s, "beckmann", "alpha=0.5");
    scene_open(&s);
    for (int k = 0; k < 3; k++) {
        double d[3];
        model_direction((const double[]){0.001, 60, 80}[k] * FIT_DEGREE, 0, d);
        for (int j = 0; j < 3; j++) w[3 * j + k] = d[j];
    }
    FF_CHECK(ff_height_field_seen(s.field, w, 3, seen, &err) == FF_OK, "%s", err.message);
    FF_CHECK(seen[0].g1 > 0.9999 && seen[0].g2 > 0.9999, "from above %g, %g", seen[0].g1, seen[0].g2);
    for (int k = 1; k < 3; k++) { /* Smith's G1 of facets that face w; both are seen of no more than either */
        const double tan_w = tan((k == 1 ? 60 : 80) * FIT_DEGREE), a = 1 / (0.5 * tan_w);
        const double lambda = 0.5 * (erf(a) - 1 + exp(-a * a) / (a * sqrt(MODEL_PI))), g1 = 1 / (1 + lambda);
        FF_CHECK(fabs(seen[k].g1 - g1) < 0.05 && seen[k].g1_error < 0.01, "%g +- %g, Smith has %g", seen[k].g1, seen[k].g1_error,
                 g1);
        FF_CHECK(seen[k].g2 <= seen[k].g1 + 0.02 && seen[k].g2 >= 2 * seen[k].g1 - 1 - 0.02, "%g, %g", seen[k].g2, seen[k].g1);
    }
    ff_height_field_free(s.field);
}

/* ---- maps ------------------------------------------------------------------------------------ */

enum { NX = 96, NY = 64 };
static const double slope = 0.3;

/* Ridges along y, whose sides have slopes of +-0.3 along x; a slight tilt, which is taken out. */
static double ridge(int i, int j)
{
    const int t = i % 12;
    return slope * 2 * (t < 6 ? t : 12 - t) + 0.01 * i + 0.02 * j;
}

static void map_write(const char *path, int kind)
{
    FILE *out = fopen(path, "w");
    if (!out) exit(1);
    if (kind == 1) fprintf(out, "ncols %d\nnrows %d\nxllcorner 0\nyllcorner 0\ncellsize 2\nNODATA_value -9999\n", NX, NY);
    if (kind == 2)
        fprintf(out, "aBCR-1.0\nManufacID = TEST\nNumPoints = %d\nNumProfiles = %d\nXscale = 2\nYscale = 2\nZscale = 0.5\n*\n", NX,
                NY);
    for (int j = NY - 1; j >= 0; j--)
        for (int i = 0; i < NX; i++)
            fprintf(out, "%.17g%s", ridge(i, j) * (kind == 2 ? 2 : 1), i + 1 < NX ? (kind ? " " : ",") : "\n");
    if (kind == 2) fprintf(out, "*\n");
    fclose(out);
}

/* Light from above goes along (+-sin 2t, 0, cos 2t), tan t = 0.3; but for the part of the map that is faded. */
static void light_of_ridges(void)
{
    static const char *const names[] = {"map.csv", "map.asc", "map.sdf"};
    NEEDS_THE_MODULE;
    ff_lobe_mean first = {0};
    char folder[] = "/tmp/ff_map_XXXXXX", path[64];
    FF_CHECK(mkdtemp(folder) != NULL, "no folder");
    for (int kind = 0; kind < 3; kind++) {
        scene s;
        const double turn = 2 * atan(slope);
        double w[6][3], f[3], error[3], lost;
        ff_error err = {0};
        snprintf(path, sizeof path, "%s/%s", folder, names[kind]);
        map_write(path, kind);
        scene_make(&s, "ggx" SMITH "/none", "");
        s.o.seed = 1;
        s.o.map = path;
        if (kind == 0) s.o.pitch[0] = s.o.pitch[1] = 2;
        scene_open(&s);
        unlink(path);
        const ff_lobe_mean all = lobe_of(&s, 0, 0, &lost);
        if (kind == 0) first = all;
        FF_CHECK(!memcmp(&all, &first, sizeof all), "%s: not the light of the same map as rows of numbers", names[kind]);
        FF_CHECK(fabs(all.albedo + lost - 1) < 1e-9, "%g", all.albedo);
        FF_CHECK(fabs(all.mean[2] - cos(turn)) < 0.05, "mean %g, not %g", all.mean[2], cos(turn));
        for (int k = 0; k < 3; k++) { /* the two sides, and where no light goes */
            double d[3];
            model_direction(k < 2 ? turn : turn, k < 2 ? k * MODEL_PI : 0.5 * MODEL_PI, d);
            for (int j = 0; j < 3; j++) w[j][k] = j == 2, w[3 + j][k] = d[j];
        }
        const ff_dirs dirs = {w[0], w[1], w[2], w[3], w[4], w[5]};
        FF_CHECK(ff_height_field_values(s.field, &dirs, 3, 0, f, error, 3, &err) == FF_OK, "%s", err.message);
        const double solid = 2 * MODEL_PI * (1 - cos(s.o.aperture));
        for (int k = 0; k < 2; k++)
            FF_CHECK(fabs(f[k] * solid * cos(turn) - 0.5) < 0.06, "%g of the light goes to side %d", f[k] * solid * cos(turn), k);
        FF_CHECK(f[2] < 0.01 * f[0], "%g beside, %g", f[2], f[0]);
        ff_height_field_free(s.field);
    }
    rmdir(folder);
}

static void maps_that_are_none(void)
{
    static const struct {
        const char *text, *said;
    } cases[] = {{"", "empty"},
                 {"1,2,3\n4,5\n", "expected 3"},
                 {"1,2,x\n", "expected a height"},
                 {"1,2,3\n4,5,6\n", "expected 16"},
                 {"ncols 20\nnrows 20\ncellsize 1\n1 2 3\n", "expected 20 x 20"},
                 {"ncols 1e9\nnrows 20\ncellsize 1\n1 2 3\n", "expected 16"},
                 {"aBCR-1.0\nNumPoints = 20\n", "expected 16"},
                 {"ncols 16\nnrows 16\nNODATA_value -9999\ncellsize 1\n-9999 1\n", "missing"}};
    NEEDS_THE_MODULE;
    char path[] = "/tmp/ff_map_XXXXXX";
    const int fd = mkstemp(path);
    FF_CHECK(fd >= 0, "no file");
    close(fd);
    for (size_t k = 0; k < sizeof cases / sizeof cases[0]; k++) {
        scene s;
        ff_error err = {0};
        FILE *out = fopen(path, "w");
        fputs(cases[k].text, out);
        fclose(out);
        scene_make(&s, "ggx" SMITH "/none", "");
        s.o.map = path;
        s.o.pitch[0] = s.o.pitch[1] = 1;
        const ff_status status = ff_height_field_new(&s.model, 1, s.shape, s.channel, &s.o, &s.field, &err);
        FF_CHECK((status == FF_ERR_DATA || status == FF_ERR_FORMAT) && strstr(err.message, cases[k].said), "%s: %d, %s",
                 cases[k].text, (int)status, err.message);
    }
    unlink(path);
}

/* ---- how it is run --------------------------------------------------------------------------- */

static void threads_facets_and_refusals(void)
{
    static const char *const refused[][2] = {
        {"ggx", "beckmann"}, {"beckmann+ggx", "one lobe"}, {"beckmann/v-cavity", "masking"}, {"beckmann+lambert", "nothing under"}};
    NEEDS_THE_MODULE;
    scene s;
    ff_lobe_mean one[3];
    double lost;
    for (int k = 0; k < 3; k++) {
        scene_make(&s, "beckmann", "alpha=0.7 f0=0.5");
        s.o.cells = 64;
        s.o.correlation = 6;
        s.o.seed = k < 2 ? 1 : 2;
        s.o.threads = k + 1;
        scene_open(&s);
        one[k] = lobe_of(&s, 50, 0, NULL);
        ff_height_field_free(s.field);
    }
    FF_CHECK(!memcmp(&one[0], &one[1], sizeof one[0]), "other bits with other threads");
    FF_CHECK(memcmp(&one[0], &one[2], sizeof one[0]) != 0, "the same bits with another seed");
    FF_CHECK(one[0].albedo > 0.45 && one[0].albedo < 0.65, "%g", one[0].albedo);
    scene_make(&s, "beckmann+lambert", "alpha=0.7 kd=1");
    s.o.facets = FF_FACETS_LAMBERT;
    scene_open(&s);
    one[0] = lobe_of(&s, 50, 0, &lost);
    FF_CHECK(fabs(one[0].albedo + lost - 1) < 1e-9 && lost < 1e-3, "%g leaves, %g is lost", one[0].albedo, lost);
    ff_height_field_free(s.field);
    for (size_t k = 0; k < sizeof refused / sizeof refused[0]; k++) {
        ff_error err = {0};
        scene_make(&s, refused[k][0], "");
        const ff_status status = ff_height_field_new(&s.model, 1, s.shape, s.channel, &s.o, &s.field, &err);
        FF_CHECK(status == FF_ERR_UNSUPPORTED && strstr(err.message, refused[k][1]), "%s: %s", refused[k][0], err.message);
    }
}

/* Options beyond their ranges, directions that are none. Looked at before the module is. */
static void ranges(void)
{
    static const double beyond[][2] = {{NAN, NAN}, {INFINITY, -INFINITY}, {0, -1}, {1e9, 1e9}};
    for (size_t k = 0; k < sizeof beyond / sizeof beyond[0]; k++)
        for (int member = 0; member < 5; member++) {
            scene s;
            ff_error err = {0};
            scene_make(&s, "beckmann", "");
            double *const of[] = {&s.o.hurst, &s.o.correlation, &s.o.aperture, &s.o.height_unit, &s.o.pitch[1]};
            for (int sign = 0; sign < 2; sign++) {
                const double x = beyond[k][sign];
                if ((member == 4 && isnan(x)) || (member >= 3 && x == 1e9)) continue; /* these are legal */
                *of[member] = x;
                FF_CHECK(ff_height_field_new(&s.model, 1, s.shape, s.channel, &s.o, &s.field, &err) == FF_ERR_RANGE,
                         "member %d, %g", member, x);
            }
        }
    for (int k = 0; k < 12; k++) {
        scene s;
        ff_error err = {0};
        scene_make(&s, "beckmann", "");
        if (k == 0) s.o.spectrum = (ff_spectrum)3;
        if (k == 1) s.o.cells = 15;
        if (k == 2) s.o.cells = 8193;
        if (k == 3) s.o.realisations = 1;
        if (k == 4) s.o.realisations = 100001;
        if (k == 5) s.o.facets = FF_FACETS_COUPLED;
        if (k == 6) s.o.paths = 11;
        if (k == 7) s.o.paths = UINT64_C(1000000000001);
        if (k == 8) s.o.threads = -1;
        if (k == 9) s.o.threads = 1025;
        if (k == 10) s.o.n_orders = 17;
        if (k == 11) s.o.orders[0].first = 0;
        FF_CHECK(ff_height_field_new(&s.model, 1, s.shape, s.channel, &s.o, &s.field, &err) == FF_ERR_RANGE, "%d: %s", k,
                 err.message);
    }
    NEEDS_THE_MODULE;
    scene s;
    ff_error err = {0};
    ff_lobe_mean lobe;
    ff_seen seen;
    const double down[3] = {0, 0, -1}, longer[3] = {0, 0, 1.1};
    double f, error;
    scene_make(&s, "beckmann", "");
    scene_open(&s);
    const ff_dirs dirs = {&down[0], &down[1], &down[2], &longer[0], &longer[1], &longer[2]};
    FF_CHECK(ff_height_field_lobes(s.field, down, 1, &lobe, NULL, &err) == FF_ERR_RANGE, "%s", err.message);
    FF_CHECK(ff_height_field_seen(s.field, longer, 1, &seen, &err) == FF_ERR_RANGE, "%s", err.message);
    FF_CHECK(ff_height_field_values(s.field, &dirs, 1, 0, &f, &error, 1, &err) == FF_ERR_RANGE, "%s", err.message);
    FF_CHECK(ff_height_field_values(s.field, &dirs, 1, 0, &f, &error, 0, &err) == FF_ERR_RANGE, "%s", err.message);
    ff_height_field_free(s.field);
}

FF_TEST_MAIN(FF_TEST(slopes_as_asked), FF_TEST(light_of_a_gaussian_surface), FF_TEST(what_is_seen), FF_TEST(light_of_ridges),
             FF_TEST(maps_that_are_none), FF_TEST(threads_facets_and_refusals), FF_TEST(ranges))
