/* Smith's random walk: order 1 against the model and its albedo, the total where nothing is lost, higher orders against a walk of
 * another make (heights of a Gaussian surface, Lambda, visible normals by rejection), values against counts, reciprocity, facets of
 * every kind, threads and instruction sets. Deviations are in standard errors; a right walk fails one of the checks by chance in
 * one of 10^5 runs at most, and the same checks are shown to fail on what is wrong. */
#include "model_samples.h"
#include "ff_albedo.h"
#include "simulate/simulate_struct.h"
#include "simulate/walk/internal_walk.h"

#define SMITH "/smith-height-correlated"
enum { CHANNELS = 2 };
static const double most_off = 5.7; /* standard errors: 1.2e-8 to be beyond it, of 500 checks and more */

typedef struct scene {
    ff_model model;
    double shape[FF_MAX_SHAPE], channel[CHANNELS * FF_MAX_CHANNEL_PARAMS];
    ff_walk_options o;
    ff_walk *walk;
} scene;

/* set: assignments with blanks between; of CHANNELS channels. */
static void scene_make(scene *s, const char *expression, const char *set, uint64_t paths)
{
    ff_error err = {0};
    char words[200];
    *s = (scene){.walk = NULL};
    FF_CHECK(ff_model_parse(expression, &s->model, &err) == FF_OK, "%s", err.message);
    ff_model_defaults(&s->model, CHANNELS, s->shape, s->channel);
    snprintf(words, sizeof words, "%s", set);
    for (char *word = strtok(words, " "); word; word = strtok(NULL, " "))
        FF_CHECK(ff_model_set(&s->model, CHANNELS, word, s->shape, s->channel, &err) == FF_OK, "%s", err.message);
    ff_walk_options_init(&s->o);
    s->o.paths = paths;
    s->o.seed = ff_test_stream("%s %s", expression, set);
}

static void scene_orders(scene *s, const char *orders)
{
    ff_error err = {0};
    FF_CHECK(ff_orders_parse(orders, s->o.orders, &s->o.n_orders, &err) == FF_OK, "%s", err.message);
}

static void scene_open(scene *s)
{
    ff_error err = {0};
    const ff_status status = ff_walk_new(&s->model, CHANNELS, s->shape, s->channel, &s->o, &s->walk, &err);
    if (!FF_CHECK(status == FF_OK, "%s", err.message)) exit(1);
}

static void scene_close(scene *s)
{
    ff_walk_free(s->walk);
}

/* Light from theta (degrees), azimuth 40. lobe [n_orders][CHANNELS] */
static double lobes(const scene *s, double theta, ff_lobe_mean *lobe)
{
    double wi[3], lost = NAN;
    ff_error err = {0};
    model_direction(theta * FIT_DEGREE, 40 * FIT_DEGREE, wi);
    FF_CHECK(ff_walk_lobe(s->walk, wi, lobe, &lost, &err) == FF_OK, "%s", err.message);
    return lost;
}

static double off(double value, double error, double reference)
{
    return fabs(value - reference) / fmax(error, 1e-12);
}

/* ---- order 1 --------------------------------------------------------------------------------- */

static double albedo_of(const scene *s, double theta, size_t channel)
{
    ff_integral value[CHANNELS];
    ff_error err = {0};
    double wo[3];
    model_direction(theta * FIT_DEGREE, 40 * FIT_DEGREE, wo);
    FF_CHECK(ff_albedo_directional(&s->model, FF_ISA_BEST, CHANNELS, s->shape, s->channel, wo, value, &err) == FF_OK, "%s",
             err.message);
    return value[channel].value;
}

static const char *const surfaces[][2] = {
    {"ggx" SMITH "/none", "alpha=1"},
    {"ggx" SMITH "/none", "alpha=0.2"},
    {"ggx", "alpha_x=0.1 alpha_y=0.7 r_xy=-0.6 f0=0.3:0.9"},
    {"ggx" SMITH "/dielectric", "alpha=0.5 eta=1.5:2.5"},
    {"beckmann" SMITH "/none", "alpha=1"},
    {"beckmann" SMITH "/conductor", "alpha_x=0.3 alpha_y=0.6 r_xy=0.5 eta=0.2:1 k=3:5"},
    {"student-t" SMITH "/none", "alpha=0.7 gamma=1.7"},
    {"student-t", "alpha_x=0.5 alpha_y=0.25 gamma=4 f0=0.1:1"},
    {"phong" SMITH "/none", "n=3"},
    {"gtr" SMITH "/none", "alpha=0.5 gamma=3"},
};
enum { SURFACES = sizeof surfaces / sizeof surfaces[0] };

static void one_facet_is_the_model(void)
{
    static const double thetas[] = {0, 30, 72.5, 87};
    for (size_t k = 0; k < SURFACES; k++) {
        scene s;
        ff_lobe_mean lobe[CHANNELS];
        scene_make(&s, surfaces[k][0], surfaces[k][1], 200000);
        scene_orders(&s, "1");
        scene_open(&s);
        for (size_t v = 0; v < sizeof thetas / sizeof thetas[0]; v++) {
            lobes(&s, thetas[v], lobe);
            for (size_t c = 0; c < CHANNELS; c++) {
                const double want = albedo_of(&s, thetas[v], c);
                FF_CHECK(off(lobe[c].albedo, lobe[c].albedo_error, want) < most_off, "%s %s, %g: %.6f +- %.6f, not %.6f",
                         surfaces[k][0], surfaces[k][1], thetas[v], lobe[c].albedo, lobe[c].albedo_error, want);
                FF_CHECK(off(lobe[c].albedo, lobe[c].albedo_error, want * 1.02) > most_off || want < 0.6,
                         "two percent are not seen");
            }
        }
        scene_close(&s);
    }
}

/* ggx, alpha = 1, seen from the normal: 1 - ln 2. */
static void known_albedo(void)
{
    scene s;
    ff_lobe_mean lobe[CHANNELS];
    scene_make(&s, "ggx" SMITH "/none", "alpha=1", 4000000);
    scene_orders(&s, "1");
    scene_open(&s);
    lobes(&s, 0, lobe);
    FF_CHECK(off(lobe[0].albedo, lobe[0].albedo_error, 1 - log(2)) < most_off, "%.6f +- %.6f", lobe[0].albedo,
             lobe[0].albedo_error);
    FF_CHECK(lobe[0].albedo_error < 3e-4, "%g", lobe[0].albedo_error);
    scene_close(&s);
}

static void values_of_one_facet(void)
{
    for (size_t k = 0; k < SURFACES; k++) {
        scene s;
        model_pairs p = {0};
        enum { PAIRS = 60 };
        double f[CHANNELS][PAIRS], error[CHANNELS][PAIRS], want[CHANNELS][PAIRS], d[2][3], square = 0;
        ff_error err = {0};
        uint64_t state = ff_test_stream("pairs");
        scene_make(&s, surfaces[k][0], surfaces[k][1], 1500);
        scene_orders(&s, "1");
        scene_open(&s);
        while (p.n < PAIRS) {
            model_random_direction(&state, d[0]);
            model_random_direction(&state, d[1]);
            model_pairs_add(&p, d[0], d[1]);
        }
        const ff_dirs w = model_dirs(&p);
        FF_CHECK(ff_walk_values(s.walk, &w, PAIRS, 0, f[0], error[0], PAIRS, &err) == FF_OK, "%s", err.message);
        FF_CHECK(ff_model_eval(&s.model, FF_ISA_BEST, CHANNELS, s.shape, s.channel, &w, PAIRS, want[0], NULL, PAIRS) == FF_OK,
                 "eval");
        for (size_t i = 0; i < PAIRS; i++) {
            FF_CHECK(off(f[1][i], error[1][i], want[1][i]) < most_off, "%s %s: %g +- %g, not %g", surfaces[k][0], surfaces[k][1],
                     f[1][i], error[1][i], want[1][i]);
            square += pow((f[1][i] - want[1][i]) / error[1][i], 2) / PAIRS;
        }
        /* the errors are those of the values: 60 numbers of variance 1, but for those that are seen along the normal */
        FF_CHECK(square > 0.3 && square < 2.5, "%s %s: %g", surfaces[k][0], surfaces[k][1], square);
        scene_close(&s);
    }
}

/* ---- directions that paths leave in ---------------------------------------------------------- */

enum { THETAS = 9, PHIS = 12, CELLS = THETAS * PHIS };
typedef struct histogram {
    double count[CELLS], lost;
} histogram;

static void count_one(void *context, uint32_t order, const double r[3], const double *weight)
{
    histogram *h = context;
    const double turn = atan2(r[1], r[0]) / (2 * MODEL_PI);
    const int t = (int)(THETAS * (1 - r[2])), p = (int)(PHIS * (turn < 0 ? turn + 1 : turn));
    if (order == 1) h->count[(t < THETAS ? t : THETAS - 1) * PHIS + (p < PHIS ? p : 0)] += *weight;
}

/* The part of the light from wi in a cell of the histogram: cells of equal solid angle, 30 x 30 midpoints. */
static double cell_of_model(const scene *s, const double wi[3], int t, int p)
{
    enum { EDGE = 30, ROOM = EDGE * EDGE };
    static double w[6][ROOM], f[CHANNELS * ROOM];
    double sum = 0;
    for (int a = 0; a < EDGE; a++)
        for (int b = 0; b < EDGE; b++) {
            double d[3];
            model_direction(acos(1 - (t + (a + 0.5) / EDGE) / THETAS), 2 * MODEL_PI * (p + (b + 0.5) / EDGE) / PHIS, d);
            for (int j = 0; j < 3; j++) w[j][a * EDGE + b] = wi[j], w[3 + j][a * EDGE + b] = d[j];
        }
    const ff_dirs dirs = {w[0], w[1], w[2], w[3], w[4], w[5]};
    FF_CHECK(ff_model_eval(&s->model, FF_ISA_BEST, CHANNELS, s->shape, s->channel, &dirs, ROOM, f, NULL, ROOM) == FF_OK, "eval");
    for (int i = 0; i < ROOM; i++) sum += f[i] * w[5][i];
    return sum * 2 * MODEL_PI / CELLS / ROOM;
}

/* D F G2 / (4 iz oz) times oz per solid angle: the paths that left after one facet, cell by cell. */
static void directions_of_one_facet(void)
{
    static const char *const cases[][2] = {{"ggx" SMITH "/none", "alpha=0.5"},
                                           {"beckmann" SMITH "/none", "alpha_x=0.4 alpha_y=0.9 r_xy=0.4"}};
    for (size_t k = 0; k < 2; k++) {
        scene s;
        histogram h = {{0}, 0};
        double wi[3];
        enum { PATHS = 2000000 };
        scene_make(&s, cases[k][0], cases[k][1], PATHS);
        scene_open(&s);
        ff_walk_lanes *lanes = ff_walk_lanes_new(CHANNELS, 1);
        model_direction(50 * FIT_DEGREE, 20 * FIT_DEGREE, wi);
        const ff_dirs dirs = {&wi[0], &wi[1], &wi[2], NULL, NULL, NULL};
        const ff_walk_item item = {.n_pairs = 1, .n_paths = PATHS, .w = &dirs, .leaves = count_one, .context = &h};
        s.walk->run(&s.walk->setting, &item, lanes);
        double worst = 0, shifted = 0;
        for (int t = 0; t < THETAS; t++)
            for (int p = 0; p < PHIS; p++) {
                const double want = PATHS * cell_of_model(&s, wi, t, p), wrong = PATHS * cell_of_model(&s, wi, t, (p + 1) % PHIS);
                worst = fmax(worst, off(h.count[t * PHIS + p], sqrt(want + 1), want));
                shifted = fmax(shifted, off(h.count[t * PHIS + p], sqrt(wrong + 1), wrong));
            }
        FF_CHECK(worst < most_off, "%s: %g", cases[k][1], worst);
        FF_CHECK(shifted > 10 * most_off, "%s: the next cell would do as well: %g", cases[k][1], shifted);
        free(lanes);
        scene_close(&s);
    }
}

/* ---- all orders ------------------------------------------------------------------------------ */

static void nothing_is_lost(void)
{
    static const double thetas[] = {0, 60, 89};
    for (size_t k = 0; k < SURFACES; k++) {
        scene s;
        ff_lobe_mean lobe[4 * CHANNELS];
        if (!strstr(surfaces[k][0], "/none")) continue;
        scene_make(&s, surfaces[k][0], surfaces[k][1], 20000);
        scene_orders(&s, "all,1,2,3+");
        scene_open(&s);
        for (size_t v = 0; v < 3; v++) {
            const double lost = lobes(&s, thetas[v], lobe);
            FF_CHECK_CLOSE(lobe[0].albedo + lost, 1, 1e-12, 0);
            FF_CHECK_CLOSE(lobe[CHANNELS].albedo + lobe[2 * CHANNELS].albedo + lobe[3 * CHANNELS].albedo, lobe[0].albedo, 1e-12, 0);
            FF_CHECK(lost < 1e-3, "%s: %g lost", surfaces[k][0], lost);
        }
        scene_close(&s);
    }
}

/* Another walk on ggx: height h of a Gaussian surface, free paths by Lambda (Heitz et al. 2016, section 4.2), visible normals by
 * rejection among those of D cos. The part of each order that leaves. */
static double gaussian_below(double h)
{
    return 0.5 * erfc(-h / sqrt(2));
}

static double height_of(double below)
{
    double lo = -40, hi = 9;
    for (int i = 0; i < 80; i++) {
        const double mid = 0.5 * (lo + hi);
        if (gaussian_below(mid) < below)
            lo = mid;
        else
            hi = mid;
    }
    return 0.5 * (lo + hi);
}

static double ggx_lambda(double alpha, const double r[3])
{
    const double tan2 = (r[0] * r[0] + r[1] * r[1]) / (r[2] * r[2]), root = sqrt(1 + alpha * alpha * tan2);
    return r[2] > 0 ? 0.5 * (root - 1) : -0.5 * (root + 1);
}

static void facet_met(uint64_t *state, double alpha, const double r[3], double m[3])
{
    const double most =
        fmax(-r[2], 0) + sqrt(r[0] * r[0] + r[1] * r[1]) * 60; /* V of slopes up to 60; what is steeper is left out */
    for (;;) {
        const double u = fit_uniform(state), q = alpha * sqrt(u / (1 - u)), phi = 2 * MODEL_PI * fit_uniform(state);
        const double shown = -(r[0] * q * cos(phi) + r[1] * q * sin(phi) + r[2]);
        if (q > 60 || fit_uniform(state) * most > shown) continue;
        const double length = sqrt(1 + q * q);
        m[0] = q * cos(phi) / length, m[1] = q * sin(phi) / length, m[2] = 1 / length;
        return;
    }
}

static void other_walk(double alpha, double theta, int paths, double part[4])
{
    uint64_t state = ff_test_stream("the other walk, %g, %g", alpha, theta);
    for (int k = 0; k < 4; k++) part[k] = 0;
    for (int n = 0; n < paths; n++) {
        double r[3] = {-sin(theta), 0, -cos(theta)}, h = 8.5, m[3];
        for (int order = 0; order < 100; order++) {
            const double below = gaussian_below(h), lambda = ggx_lambda(alpha, r), u = 1 - fit_uniform(&state);
            const double next = below * pow(u, -1 / lambda); /* C^Lambda u = C'^Lambda on the way up, -1 - Lambda on the way down */
            if (r[2] > 0 && next >= 1) {
                part[order < 4 ? order - 1 : 3] += 1.0 / paths;
                break;
            }
            h = height_of(next);
            facet_met(&state, alpha, r, m);
            const double c = r[0] * m[0] + r[1] * m[1] + r[2] * m[2];
            for (int j = 0; j < 3; j++) r[j] -= 2 * c * m[j];
        }
    }
}

static void another_walk_agrees(void)
{
    static const double cases[][2] = {{0.5, 20}, {1, 60}};
    for (size_t k = 0; k < 2; k++) {
        enum { PATHS = 60000 };
        char set[40];
        scene s;
        ff_lobe_mean lobe[4 * CHANNELS];
        double part[4], most = 0;
        snprintf(set, sizeof set, "alpha=%g", cases[k][0]);
        scene_make(&s, "ggx" SMITH "/none", set, 2000000);
        scene_orders(&s, "1,2,3,4+");
        scene_open(&s);
        lobes(&s, cases[k][1], lobe);
        other_walk(cases[k][0], cases[k][1] * FIT_DEGREE, PATHS, part);
        for (int g = 0; g < 4; g++) {
            const double p = lobe[g * CHANNELS].albedo, error = sqrt(p * (1 - p) / PATHS) + lobe[g * CHANNELS].albedo_error;
            FF_CHECK(off(part[g], error, p) < most_off, "alpha %g, order %d: %g, and the other walk has %g", cases[k][0], g + 1, p,
                     part[g]);
        }
        scene_close(&s);
        s.o.descent = FF_DESCENT_SYMMETRIC; /* is seen to be another */
        scene_open(&s);
        lobes(&s, cases[k][1], lobe);
        for (int g = 0; g < 4; g++)
            most = fmax(most, off(part[g], sqrt(part[g] / PATHS) + lobe[g * CHANNELS].albedo_error, lobe[g * CHANNELS].albedo));
        FF_CHECK(most > most_off, "alpha %g: the two descents cannot be told apart: %g", cases[k][0], most);
        scene_close(&s);
    }
}

/* Values of two and more facets, both ways round: deviation in standard errors, the most of some pairs. */
static double reciprocity(scene *s)
{
    enum { PAIRS = 6 };
    static const double angles[PAIRS][4] = {{10, 0, 70, 180},  {30, 0, 75, 0},   {0, 0, 60, 90},
                                            {20, 30, 80, 200}, {60, 0, 85, 180}, {45, 90, 78, 300}};
    double w[6][2 * PAIRS], f[CHANNELS][2 * PAIRS], error[CHANNELS][2 * PAIRS], most = 0;
    ff_error err = {0};
    for (int i = 0; i < PAIRS; i++) {
        double d[2][3];
        model_direction(angles[i][0] * FIT_DEGREE, angles[i][1] * FIT_DEGREE, d[0]);
        model_direction(angles[i][2] * FIT_DEGREE, angles[i][3] * FIT_DEGREE, d[1]);
        for (int j = 0; j < 3; j++) {
            w[j][2 * i] = w[3 + j][2 * i + 1] = d[0][j];
            w[3 + j][2 * i] = w[j][2 * i + 1] = d[1][j];
        }
    }
    const ff_dirs dirs = {w[0], w[1], w[2], w[3], w[4], w[5]};
    scene_orders(s, "2+");
    scene_open(s);
    FF_CHECK(ff_walk_values(s->walk, &dirs, 2 * PAIRS, 0, f[0], error[0], 2 * PAIRS, &err) == FF_OK, "%s", err.message);
    for (int i = 0; i < 2 * PAIRS; i += 2) /* far out in a tail too few paths arrive for an error to be known */
        if (fmin(f[0][i], f[0][i + 1]) > 1e-3) most = fmax(most, off(f[0][i], hypot(error[0][i], error[0][i + 1]), f[0][i + 1]));
    scene_close(s);
    return most;
}

static void light_goes_both_ways(void)
{
    static const char *const cases[][2] = {{"ggx" SMITH "/none", "alpha=0.7"},
                                           {"beckmann", "alpha_x=0.4 alpha_y=1 r_xy=0.3 f0=0.6"},
                                           {"ggx+lambert", "alpha=0.8 f0=0.1 kd=0.8"}};
    scene s;
    for (int k = 0; k < 3; k++) {
        scene_make(&s, cases[k][0], cases[k][1], 100000);
        if (k == 2) s.o.facets = FF_FACETS_COUPLED;
        const double most = reciprocity(&s);
        FF_CHECK(most < most_off, "%s %s: %g", cases[k][0], cases[k][1], most);
    }
    scene_make(&s, "ggx" SMITH "/none", "alpha=0.7", 100000);
    s.o.descent = FF_DESCENT_SYMMETRIC;
    const double most = reciprocity(&s);
    FF_CHECK(most > 2 * most_off, "a walk that is not reciprocal passes: %g", most);
}

/* The integral of the values over the hemisphere of wo is what is counted. */
static void values_add_up(void)
{
    enum { PAIRS = 6000 };
    static double w[6][PAIRS], f[2][CHANNELS][PAIRS], error[2][CHANNELS][PAIRS];
    static const char *const cases[][2] = {{"ggx", "alpha_x=0.4 alpha_y=0.8 f0=0.5:1"},
                                           {"ggx+lambert", "alpha=0.6 f0=0.05:0.5 kd=0.9"}};
    for (int k = 0; k < 4; k++) {
        scene s;
        ff_lobe_mean lobe[2 * CHANNELS];
        ff_error err = {0};
        double wi[3];
        scene_make(&s, cases[k > 0][0], cases[k > 0][1], 200000);
        if (k > 0) s.o.facets = k == 1 ? FF_FACETS_COUPLED : FF_FACETS_LAMBERT;
        if (k == 3) s.o.descent = FF_DESCENT_SYMMETRIC;
        scene_orders(&s, "1,2+");
        scene_open(&s);
        lobes(&s, 55, lobe);
        scene_close(&s);
        s.o.paths = 60;
        scene_open(&s);
        uint64_t state = ff_test_stream("directions of %d", k);
        model_direction(55 * FIT_DEGREE, 40 * FIT_DEGREE, wi);
        for (int i = 0; i < PAIRS; i++) {
            double d[3];
            model_direction(acos(fmax(1 - (i + fit_uniform(&state)) / PAIRS, 1e-3)), 2 * MODEL_PI * fit_uniform(&state), d);
            for (int j = 0; j < 3; j++) w[j][i] = wi[j], w[3 + j][i] = d[j];
        }
        const ff_dirs dirs = {w[0], w[1], w[2], w[3], w[4], w[5]};
        FF_CHECK(ff_walk_values(s.walk, &dirs, PAIRS, 0, f[0][0], error[0][0], PAIRS, &err) == FF_OK, "%s", err.message);
        for (int g = 0; g < 2; g++)
            for (int c = 0; c < CHANNELS; c++) {
                const ff_lobe_mean *l = &lobe[g * CHANNELS + c];
                double sum = 0, square = 0;
                for (int i = 0; i < PAIRS; i++) {
                    const double x = 2 * MODEL_PI * f[g][c][i] * w[5][i];
                    sum += x / PAIRS;
                    square += x * x / PAIRS;
                }
                const double spread = hypot(sqrt((square - sum * sum) / PAIRS), l->albedo_error);
                FF_CHECK(off(sum, spread, l->albedo) < most_off, "%d, orders %d: %g +- %g, counted %g", k, g, sum, spread,
                         l->albedo);
                FF_CHECK(spread < 0.1 * l->albedo, "%g of %g says little", spread, l->albedo);
            }
        scene_close(&s);
    }
}

/* ---- facets ---------------------------------------------------------------------------------- */

static void matte_facets(void)
{
    scene s;
    ff_lobe_mean lobe[3 * CHANNELS];
    scene_make(&s, "ggx+lambert", "alpha=0.6 kd=1:0.5 f0=0.04", 200000);
    s.o.facets = FF_FACETS_LAMBERT;
    scene_orders(&s, "all,1,2");
    scene_open(&s);
    double lost = lobes(&s, 40, lobe);
    FF_CHECK_CLOSE(lobe[0].albedo + lost, 1, 1e-12, 0);
    FF_CHECK_CLOSE(lobe[CHANNELS + 1].albedo, 0.5 * lobe[CHANNELS].albedo, 1e-12, 0); /* kd once, and twice */
    FF_CHECK_CLOSE(lobe[2 * CHANNELS + 1].albedo, 0.25 * lobe[2 * CHANNELS].albedo, 1e-12, 0);
    scene_close(&s);
    s.o.facets = FF_FACETS_COUPLED; /* what enters a facet of kd = 1 comes out */
    scene_open(&s);
    lost = lobes(&s, 40, lobe);
    FF_CHECK(off(lobe[0].albedo + lost, lobe[0].albedo_error, 1) < most_off, "%g +- %g", lobe[0].albedo, lobe[0].albedo_error);
    FF_CHECK(lobe[1].albedo < 0.9 && lobe[0].albedo_error < 0.01, "%g", lobe[1].albedo);
    scene_close(&s);
}

/* A nearly flat surface of such facets is Lambert's, and that of Shirley et al. with a mirror on it. */
static void flat_facets(void)
{
    enum { PAIRS = 4 };
    static const double thetas[PAIRS][2] = {{0, 40}, {30, 60}, {70, 20}, {50, 80}};
    for (int coupled = 0; coupled < 2; coupled++) {
        scene s;
        double w[6][PAIRS], f[CHANNELS][PAIRS], error[CHANNELS][PAIRS];
        ff_error err = {0};
        scene_make(&s, "ggx+lambert", "alpha=0.001 kd=0.8 f0=0.3", 100000);
        s.o.facets = coupled ? FF_FACETS_COUPLED : FF_FACETS_LAMBERT;
        scene_open(&s);
        for (int i = 0; i < PAIRS; i++) {
            double d[2][3];
            for (int e = 0; e < 2; e++) model_direction(thetas[i][e] * FIT_DEGREE, 0, d[e]);
            for (int j = 0; j < 3; j++) w[j][i] = d[0][j], w[3 + j][i] = d[1][j];
        }
        const ff_dirs dirs = {w[0], w[1], w[2], w[3], w[4], w[5]};
        FF_CHECK(ff_walk_values(s.walk, &dirs, PAIRS, 0, f[0], error[0], PAIRS, &err) == FF_OK, "%s", err.message);
        for (int i = 0; i < PAIRS; i++) {
            const double in = 1 - pow(1 - w[2][i], 5), out = 1 - pow(1 - w[5][i], 5);
            const double want = coupled ? 1.05 * 0.8 * 0.7 * in * out / MODEL_PI : 0.8 / MODEL_PI;
            FF_CHECK(fabs(f[0][i] - want) < most_off * error[0][i] + 0.01 * want, "%d: %g +- %g, not %g", i, f[0][i], error[0][i],
                     want);
            FF_CHECK(error[0][i] < 0.02 * want, "%g of %g", error[0][i], want);
        }
        scene_close(&s);
    }
}

/* ---- how it is run --------------------------------------------------------------------------- */

static void threads_and_instruction_sets(void)
{
    enum { PAIRS = 7, KINDS = 5 };
    static const int threads[KINDS] = {1, 2, 5, 1, 1};
    static double f[KINDS][2][CHANNELS][PAIRS], error[KINDS][2][CHANNELS][PAIRS];
    ff_lobe_mean lobe[KINDS][2 * CHANNELS];
    double w[6][PAIRS];
    ff_error err = {0};
    for (int i = 0; i < PAIRS; i++) {
        double d[2][3];
        model_direction(12 * i * FIT_DEGREE, 0, d[0]);
        model_direction(80 * FIT_DEGREE, i, d[1]);
        for (int j = 0; j < 3; j++) w[j][i] = d[0][j], w[3 + j][i] = d[1][j];
    }
    const ff_dirs dirs = {w[0], w[1], w[2], w[3], w[4], w[5]};
    for (int k = 0; k < KINDS; k++) {
        scene s;
        scene_make(&s, "ggx", "alpha=0.6 f0=0.5:0.9", k == 3 ? 20001 : 20000);
        s.o.seed = k == 4 ? 2 : 1;
        s.o.threads = threads[k];
        scene_orders(&s, "1,2+");
        scene_open(&s);
        FF_CHECK(ff_walk_values(s.walk, &dirs, PAIRS, 3, f[k][0][0], error[k][0][0], PAIRS, &err) == FF_OK, "%s", err.message);
        lobes(&s, 33, lobe[k]);
        scene_close(&s);
    }
    for (int k = 1; k < KINDS; k++) {
        const int same = !memcmp(f[0], f[k], sizeof f[0]) && !memcmp(error[0], error[k], sizeof error[0]) &&
                         !memcmp(lobe[0], lobe[k], sizeof lobe[0]);
        FF_CHECK(same == (k < 3), "%d threads, seed %d: %s", threads[k], k == 4 ? 2 : 1, same ? "the same" : "other bits");
    }
    for (int isa = FF_ISA_SCALAR; isa <= FF_ISA_AVX512; isa++) {
        scene s;
        if (!ff_isa_available((ff_isa)isa)) continue;
        scene_make(&s, "ggx", "alpha=0.6 f0=0.5:0.9", 20000);
        s.o.seed = 1;
        s.o.isa = (ff_isa)isa;
        scene_orders(&s, "1,2+");
        scene_open(&s);
        lobes(&s, 33, lobe[1]);
        for (int g = 0; g < 2 * CHANNELS; g++) /* a path in many may turn off where a number is rounded the other way */
            FF_CHECK(off(lobe[1][g].albedo, lobe[0][g].albedo_error, lobe[0][g].albedo) < 0.5, "%s: %g, %g",
                     ff_isa_name((ff_isa)isa), lobe[1][g].albedo, lobe[0][g].albedo);
        scene_close(&s);
    }
}

static void calls(void *context, double done)
{
    double *last = context;
    FF_CHECK(done >= *last && done <= 1, "%g after %g", done, *last);
    *last = done;
}

static void progress_and_cancelling(void)
{
    scene s;
    ff_lobe_mean lobe[CHANNELS];
    ff_error err = {0};
    double last = 0, f[CHANNELS], error[CHANNELS];
    volatile int cancel = 1;
    const double up[3] = {0, 0, 1}, down[3] = {0, 0, -1};
    scene_make(&s, "ggx", "alpha=0.6", 5000000);
    s.o.progress = calls;
    s.o.progress_context = &last;
    s.o.threads = 1;
    scene_open(&s);
    lobes(&s, 33, lobe);
    FF_CHECK(last == 1, "%g", last);
    FF_CHECK(ff_walk_lobe(s.walk, down, lobe, NULL, &err) == FF_ERR_RANGE, "%s", err.message);
    const ff_dirs under = {&up[0], &up[1], &up[2], &down[0], &down[1], &down[2]};
    FF_CHECK(ff_walk_values(s.walk, &under, 1, 0, f, error, 1, &err) == FF_ERR_RANGE, "%s", err.message);
    FF_CHECK(ff_walk_values(s.walk, &under, 1, 0, f, error, 0, &err) == FF_ERR_RANGE, "%s", err.message);
    scene_close(&s);
    s.o.cancel = &cancel;
    scene_open(&s);
    FF_CHECK(ff_walk_lobe(s.walk, up, lobe, NULL, &err) == FF_ERR_CANCELLED, "%s", err.message);
    scene_close(&s);
}

static void refusals(void)
{
    static const struct {
        const char *expression, *set, *said;
        ff_facets facets;
    } cases[] = {{"ggx+beckmann", "", "one lobe", FF_FACETS_MIRROR},
                 {"lambert", "", "one lobe", FF_FACETS_MIRROR},
                 {"ggx/v-cavity", "", "masking", FF_FACETS_MIRROR},
                 {"ggx", "slope_x=0.1", "mean slope", FF_FACETS_MIRROR},
                 {"ggx", "ks=2", "ks", FF_FACETS_MIRROR},
                 {"vmf", "", "vmf", FF_FACETS_MIRROR},
                 {"ggx+lambert", "", "nothing under", FF_FACETS_MIRROR},
                 {"ggx", "", "lambert", FF_FACETS_LAMBERT},
                 {"ggx+oren-nayar", "", "lambert", FF_FACETS_COUPLED},
                 {"student-t", "gamma=1.51", "too steep", FF_FACETS_MIRROR}};
    for (size_t k = 0; k < sizeof cases / sizeof cases[0]; k++) {
        scene s;
        ff_error err = {0};
        scene_make(&s, cases[k].expression, cases[k].set, 100);
        s.o.facets = cases[k].facets;
        const ff_status status = ff_walk_new(&s.model, CHANNELS, s.shape, s.channel, &s.o, &s.walk, &err);
        FF_CHECK(status == FF_ERR_UNSUPPORTED && strstr(err.message, cases[k].said), "%s %s: %d, %s", cases[k].expression,
                 cases[k].set, (int)status, err.message);
    }
}

static void words_of_orders(void)
{
    static const struct {
        const char *text, *name;
        ff_orders o;
    } good[] = {{"all", "all", {1, 0}}, {"1+", "all", {1, 0}}, {"2+", "2+", {2, 0}}, {"3", "3", {3, 3}}, {"2-5", "2-5", {2, 5}}};
    static const char *const bad[] = {
        "",           "0", "x", "2-1", "1,", "1 ", "-1", "2-", "2++", "5000", "alll", "1,,2", "1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1",
        "99999999999"};
    ff_orders o[FF_WALK_ORDERS];
    ff_error err;
    char name[32];
    size_t n = 0;
    for (size_t k = 0; k < sizeof good / sizeof good[0]; k++) {
        FF_CHECK(ff_orders_parse(good[k].text, o, &n, &err) == FF_OK && n == 1, "%s", good[k].text);
        FF_CHECK(o->first == good[k].o.first && o->last == good[k].o.last, "%s", good[k].text);
        ff_orders_name(*o, name, sizeof name);
        FF_CHECK(!strcmp(name, good[k].name), "%s: %s", good[k].text, name);
    }
    for (size_t k = 0; k < sizeof bad / sizeof bad[0]; k++)
        FF_CHECK(ff_orders_parse(bad[k], o, &n, &err) != FF_OK, "'%s' is taken", bad[k]);
}

FF_TEST_MAIN(FF_TEST(one_facet_is_the_model), FF_TEST(known_albedo), FF_TEST(values_of_one_facet), FF_TEST(directions_of_one_facet),
             FF_TEST(nothing_is_lost), FF_TEST(another_walk_agrees), FF_TEST(light_goes_both_ways), FF_TEST(values_add_up),
             FF_TEST(matte_facets), FF_TEST(flat_facets), FF_TEST(threads_and_instruction_sets), FF_TEST(progress_and_cancelling),
             FF_TEST(refusals), FF_TEST(words_of_orders))
