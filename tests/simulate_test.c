/* Simulated data: the generator against published vectors, moments of the noise, values equal to the model's, seeds, files. */
#include "ff_test.h"
#include "simulate/simulate_struct.h"
#include "base/internal_philox.h"
#include <stdint.h>

typedef struct scene {
    ff_model model;
    size_t n_channels;
    double shape[FF_MAX_SHAPE], channel[8 * FF_MAX_CHANNEL_PARAMS];
    ff_simulate_options o;
} scene;

static scene scene_make(const char *expression, size_t n_channels, const char *grid)
{
    scene s = {.n_channels = n_channels};
    ff_error err = {0};
    FF_CHECK(ff_model_parse(expression, &s.model, &err) == FF_OK, "%s", err.message);
    ff_model_defaults(&s.model, n_channels, s.shape, s.channel);
    ff_simulate_options_init(&s.o);
    FF_CHECK(ff_sampling_parse(grid, &s.o.sampling, &err) == FF_OK, "%s", err.message);
    return s;
}

static void set(scene *s, const char *assignment)
{
    ff_error err = {0};
    FF_CHECK(ff_model_set(&s->model, s->n_channels, assignment, s->shape, s->channel, &err) == FF_OK, "%s", err.message);
}

static ff_table simulate(const scene *s)
{
    ff_table t = {.n = 0};
    ff_error err = {0};
    FF_CHECK(ff_simulate_into(&s->model, s->n_channels, s->shape, s->channel, &s->o, &t, &err) == FF_OK, "%s", err.message);
    if (t.n == 0) exit(1);
    return t;
}

/* ---- the generator --------------------------------------------------------------------------- */

/* Known answers of the authors' Random123 distribution (kat_vectors, philox4x32 10). */
static void philox_known_answers(void)
{
    static const uint32_t known[3][10] = {
        {0, 0, 0, 0, 0, 0, 0x6627e8d5, 0xe169c58d, 0xbc57ac4c, 0x9b00dbd8},
        {0xffffffff, 0xffffffff, 0xffffffff, 0xffffffff, 0xffffffff, 0xffffffff, 0x408f276d, 0x41c83b0e, 0xa20bc7c6, 0x6d5451fd},
        {0x243f6a88, 0x85a308d3, 0x13198a2e, 0x03707344, 0xa4093822, 0x299f31d0, 0xd16cfe09, 0x94fdcceb, 0x5001e420, 0x24126ea1}};
    for (int i = 0; i < 3; i++) {
        uint32_t out[4];
        ff_philox(known[i], known[i] + 4, out);
        for (int j = 0; j < 4; j++) FF_CHECK(out[j] == known[i][6 + j], "vector %d word %d: %08x", i, j, out[j]);
    }
}

/* The uniform numbers are the generator's first two words, of all 64 bits of seed and index. */
static void uniform_is_the_generator(void)
{
    static const uint64_t halves[] = {0, 1, 7, UINT64_C(1) << 32, (UINT64_C(1) << 32) + 7, UINT64_C(0xfedcba9876543210)};
    enum { HALVES = sizeof halves / sizeof halves[0] };
    for (size_t a = 0; a < HALVES; a++)
        for (size_t b = 0; b < HALVES; b++)
            for (uint32_t stream = 0; stream < 3; stream++) {
                const uint64_t seed = halves[a], index = halves[b];
                const uint32_t counter[4] = {(uint32_t)(index & 0xffffffff), (uint32_t)(index >> 32), stream, 0},
                               key[2] = {(uint32_t)(seed & 0xffffffff), (uint32_t)(seed >> 32)};
                uint32_t word[4];
                ff_philox(counter, key, word);
                const double want = (floor(ldexp((double)word[0], 20)) + floor(ldexp((double)word[1], -12)) + 0.5) * 0x1p-52;
                FF_CHECK(ff_random_uniform(seed, stream, index) == want, "seed %zu, index %zu, stream %u", a, b, stream);
            }
}

/* Beyond five standard deviations, where the quantile has polynomials of its own: numbers that were looked for. */
static void quantile_of_the_tails(void)
{
    static const uint64_t indices[] = {8418514, 10781009, 16902731};
    for (size_t k = 0; k < sizeof indices / sizeof indices[0]; k++) {
        const double u = ff_random_uniform(1, 0, indices[k]), x = ff_random_normal(1, 0, indices[k]);
        FF_CHECK(fmin(u, 1 - u) < 1.1e-7, "%.17g is not in a tail", u);
        FF_CHECK_CLOSE(0.5 * erfc(fabs(x) / sqrt(2)), fmin(u, 1 - u), 1e-13, 0);
    }
}

/* The quantile must invert the normal distribution: erfc is the second source. */
static void normal_is_the_quantile_of_uniform(void)
{
    const uint64_t seed = ff_test_stream("quantile");
    double worst = 0;
    for (uint64_t i = 0; i < 200000; i++) {
        const double u = ff_random_uniform(seed, 3, i), x = ff_random_normal(seed, 3, i);
        FF_CHECK(u > 0 && u < 1, "uniform %g", u);
        const double p = x < 0 ? 0.5 * erfc(-x / sqrt(2)) : 0.5 * erfc(x / sqrt(2)), want = x < 0 ? u : 1 - u;
        worst = fmax(worst, fabs(p - want) / want);
    }
    FF_CHECK(worst < 1e-13, "quantile and erfc differ by %g", worst);
}

static void normal_moments(void)
{
    enum { N = 1000000 };
    const uint64_t seed = ff_test_stream("moments");
    double m[5] = {0}, lag = 0, before = 0, across = 0;
    for (uint64_t i = 0; i < N; i++) {
        const double x = ff_random_normal(seed, 0, i);
        for (int k = 1; k <= 4; k++) m[k] += pow(x, k) / N;
        lag += x * before / N;
        across += x * ff_random_normal(seed, 1, i) / N;
        before = x;
    }
    /* five standard errors of each: a right generator fails one of the six in 3e-6 of all seeds */
    FF_CHECK_CLOSE(m[1], 0, 0, 5 * sqrt(1.0 / N));
    FF_CHECK_CLOSE(m[2], 1, 0, 5 * sqrt(2.0 / N));
    FF_CHECK_CLOSE(m[3], 0, 0, 5 * sqrt(15.0 / N));
    FF_CHECK_CLOSE(m[4], 3, 0, 5 * sqrt(96.0 / N));
    FF_CHECK_CLOSE(lag, 0, 0, 5 * sqrt(1.0 / N));
    FF_CHECK_CLOSE(across, 0, 0, 5 * sqrt(1.0 / N));
}

/* ---- tables ---------------------------------------------------------------------------------- */

/* Without noise the values are those of ff_model_eval, bit for bit, whatever the blocks. */
static void check_exact(const scene *s, const ff_table *t)
{
    enum { BLOCK = 777 };
    double plane[6][BLOCK], *const planes[6] = {plane[0], plane[1], plane[2], plane[3], plane[4], plane[5]};
    double f[8 * BLOCK], value[BLOCK];
    size_t different = 0, invalid = 0;
    for (size_t first = 0; first < t->n; first += BLOCK) {
        const size_t n = t->n - first < BLOCK ? t->n - first : BLOCK;
        const ff_dirs w = {plane[0], plane[1], plane[2], plane[3], plane[4], plane[5]};
        ff_table_directions(t, first, n, planes);
        FF_CHECK(ff_model_eval(&s->model, s->o.isa, s->n_channels, s->shape, s->channel, &w, n, f, NULL, BLOCK) == FF_OK, "eval");
        for (size_t c = 0; c < s->n_channels; c++) {
            ff_table_values(t, c, first, n, value);
            for (size_t i = 0; i < n; i++) {
                const int above = plane[2][i] > FF_COS_MIN && plane[5][i] > FF_COS_MIN;
                if (t->valid[first + i] != above) different++;
                if (above && value[i] != f[c * BLOCK + i]) different++;
                if (c == 0) invalid += !above;
            }
        }
    }
    FF_CHECK(different == 0, "%zu values differ from the model's", different);
    FF_CHECK(invalid == t->n_invalid, "%zu below the horizon, %zu marked", invalid, t->n_invalid);
}

static void exact_without_noise(void)
{
    static const char *const grids[] = {"merl",        "goniometer",        "goniometer:2.5", "scattered:10001",
                                        "scattered:1", "scattered:5000:0.5"};
    for (size_t g = 0; g < sizeof grids / sizeof grids[0]; g++) {
        scene s = scene_make("ggx+lambert", 3, grids[g]);
        if (g > 0) set(&s, "alpha_x=0.2"), set(&s, "alpha_y=0.45"), set(&s, "r_xy=0.4");
        set(&s, "f0=0.9:0.6:0.3");
        ff_table t = simulate(&s);
        check_exact(&s, &t);
        FF_CHECK(t.n_negative == 0 && !strcmp(t.channels[1].name, "g") && t.note[0] == 0, "%s: %s", grids[g], t.note);
        ff_table_clear(&t);
    }
}

static void instruments(void)
{
    scene s = scene_make("ggx", 1, "goniometer");
    ff_table t = simulate(&s); /* isotropic: 6 theta_i, theta_o 0 and 17 x 37 */
    FF_CHECK(t.n == 6 * (1 + 17 * 37) && t.isotropic, "%zu samples, isotropic %d", t.n, t.isotropic);
    ff_table_clear(&t);
    set(&s, "alpha_x=0.1");
    t = simulate(&s); /* phi_i 0 45 90 135 but at normal incidence, phi_o the whole turn */
    FF_CHECK(t.n == (1 + 5 * 4) * (1 + 17 * 72) && !t.isotropic, "%zu samples, isotropic %d", t.n, t.isotropic);
    ff_table_clear(&t);

    enum { N = 200000 };
    s = scene_make("lambert", 1, "scattered:200000");
    t = simulate(&s);
    double mean_i = 0, mean_o = 0, plane[6][1000], *const planes[6] = {plane[0], plane[1], plane[2], plane[3], plane[4], plane[5]},
           x = 0;
    for (size_t first = 0; first < N; first += 1000) {
        ff_table_directions(&t, first, 1000, planes);
        for (int i = 0; i < 1000; i++) {
            mean_i += plane[2][i] / N;
            mean_o += plane[5][i] / N;
            x += (plane[0][i] + plane[3][i]) / N;
            FF_CHECK(plane[2][i] > 0.0871 && plane[5][i] > 0.0871, "beyond 85 degrees");
        }
    }
    const double lo = cos(85 * acos(-1) / 180), mean = (1 + lo) / 2, error = 5 * (1 - lo) / sqrt(12.0 * N);
    FF_CHECK_CLOSE(mean_i, mean, 0, error); /* uniform in solid angle: the cosine is uniform */
    FF_CHECK_CLOSE(mean_o, mean, 0, error);
    FF_CHECK_CLOSE(x, 0, 0, 5 / sqrt(1.0 * N));
    ff_table_clear(&t);
}

/* Fraction of pairs whose half vector is within 5 degrees of the normal. */
static double near_specular(const char *grid)
{
    scene s = scene_make("lambert", 1, grid);
    ff_table t = simulate(&s);
    size_t near = 0;
    for (size_t i = 0; i < t.n; i++) {
        double d[6], *const planes[6] = {d, d + 1, d + 2, d + 3, d + 4, d + 5};
        ff_table_directions(&t, i, 1, planes);
        near += hypot(d[0] + d[3], d[1] + d[4]) < tan(5 * acos(-1) / 180) * (d[2] + d[5]);
    }
    const double fraction = (double)near / (double)t.n;
    ff_table_clear(&t);
    return fraction;
}

static void specular_fraction(void)
{
    const double plain = near_specular("scattered:20000"), half = near_specular("scattered:20000:0.5");
    FF_CHECK(plain < 0.02, "%g of uniform pairs", plain);
    /* slope below tan 5 degrees: ln(0.0875/0.002) / ln(500) = 0.608 of the half that is drawn so, and more, since half vectors that
     * would send wo out of range are drawn again */
    FF_CHECK(half > 0.5 * 0.608 && half < 0.5 * 0.75, "%g of pairs, expected 0.30 to 0.38", half);
}

/* ---- noise ----------------------------------------------------------------------------------- */

static void check_noise(double relative, double floor)
{
    scene s = scene_make("ggx/smith-separable/schlick+lambert", 3, "scattered:60000");
    set(&s, "alpha=0.4");
    ff_table clean = simulate(&s);
    s.o.relative = relative;
    s.o.floor = floor;
    s.o.sigma = 1;
    ff_table t = simulate(&s);
    double sum = 0, square = 0;
    const size_t n = t.n * 3;
    for (size_t i = 0; i < n; i++) {
        const double sigma = hypot(relative * clean.value[i], floor), z = (t.value[i] - clean.value[i]) / sigma;
        FF_CHECK_CLOSE(t.sigma[i], sigma, 1e-15, 0);
        sum += z / (double)n;
        square += z * z / (double)n;
    }
    FF_CHECK_CLOSE(sum, 0, 0, 5 / sqrt((double)n));
    FF_CHECK_CLOSE(square, 1, 0, 5 * sqrt(2 / (double)n));
    ff_table_clear(&clean);
    ff_table_clear(&t);
}

/* Its standard deviation follows the value and both angles, and that of a channel is its own. */
static void noise_of_a_model(void)
{
    const ff_noise_level level[3] = {{1e-4, 0, 0.01}, {0, 1e-3, 0}, {4e-4, 0, 0}};
    ff_error err = {0};
    ff_noise *noise = NULL;
    FF_CHECK(ff_noise_new(level, 3, -1, 0.5, &noise, &err) == FF_OK, "%s", err.message);
    scene s = scene_make("ggx/smith-separable/schlick+lambert", 3, "scattered:60000");
    set(&s, "alpha=0.4");
    ff_table clean = simulate(&s);
    s.o.noise = noise;
    s.o.sigma = 1;
    ff_table t = simulate(&s);
    for (size_t c = 0; c < 3; c++) {
        double sum = 0, square = 0;
        for (size_t i = 0; i < t.n; i++) {
            double w[6], *const planes[6] = {w, w + 1, w + 2, w + 3, w + 4, w + 5};
            ff_table_directions(&t, i, 1, planes);
            const double f = clean.value[c * t.n + i],
                         sd = sqrt((level[c].constant + level[c].linear * f + level[c].square * f * f) * sqrt(w[5]) / w[2]),
                         z = (t.value[c * t.n + i] - f) / sd;
            FF_CHECK_CLOSE(t.sigma[c * t.n + i], sd, 1e-12, 0);
            sum += z / (double)t.n;
            square += z * z / (double)t.n;
        }
        FF_CHECK_CLOSE(sum, 0, 0, 5 / sqrt((double)t.n));
        FF_CHECK_CLOSE(square, 1, 0, 5 * sqrt(2 / (double)t.n));
    }
    ff_table_clear(&clean);
    ff_table_clear(&t);
    s.o.floor = 0.1;
    FF_CHECK(ff_simulate_into(&s.model, 3, s.shape, s.channel, &s.o, &t, &err) == FF_ERR_RANGE, "a floor beside a noise model");
    s.o.floor = 0;
    FF_CHECK(ff_simulate_into(&s.model, 2, s.shape, s.channel, &s.o, &t, &err) == FF_ERR_RANGE && strstr(err.message, "3 channels"),
             "three levels for two channels: %s", err.message);
    ff_noise_free(noise);
}

static void noise_has_its_moments(void)
{
    check_noise(0.05, 0);
    check_noise(0, 0.01);
    check_noise(0.1, 0.02);
}

static void seeds_reproduce(void)
{
    scene s = scene_make("ggx+lambert", 3, "scattered:3000:0.3");
    s.o.relative = 0.05;
    s.o.isa = FF_ISA_SCALAR;
    ff_table a = simulate(&s), b = simulate(&s);
    s.o.seed = 2;
    ff_table c = simulate(&s);
    size_t same = 0;
    for (size_t i = 0; i < a.n; i++) same += a.value[i] == c.value[i];
    FF_CHECK(memcmp(a.value, b.value, 3 * a.n * sizeof *a.value) == 0, "two runs differ");
    FF_CHECK(memcmp(a.angle[2], b.angle[2], a.n * sizeof(double)) == 0, "two runs look elsewhere");
    FF_CHECK(same < 10, "%zu values do not depend on the seed", same);
    /* the same sample in a longer table, and the channels draw independently */
    s.o.seed = 1;
    s.o.sampling.n = 5000;
    ff_table d = simulate(&s);
    FF_CHECK(memcmp(a.value, d.value, a.n * sizeof(double)) == 0, "a sample depends on how many follow");
    FF_CHECK(a.value[0] / a.value[a.n] != b.value[1] / b.value[b.n + 1], "channels share their noise");
    ff_table_clear(&a);
    ff_table_clear(&b);
    ff_table_clear(&c);
    ff_table_clear(&d);
}

static void negative_values(void)
{
    scene s = scene_make("lambert", 3, "merl");
    set(&s, "kd=0.01");
    s.o.floor = 0.01;
    ff_table t = simulate(&s);
    size_t below = 0;
    for (size_t i = 0; i < t.n; i++) below += t.valid[i] && (t.value[i] < 0 || t.value[t.n + i] < 0 || t.value[2 * t.n + i] < 0);
    FF_CHECK(below > 1000 && below == t.n_negative, "%zu and %zu", below, t.n_negative);
    s.o.nonnegative = 1;
    ff_table u = simulate(&s);
    size_t wrong = 0;
    for (size_t i = 0; i < 3 * t.n; i++) wrong += u.valid[i % t.n] && u.value[i] != fmax(t.value[i], 0);
    FF_CHECK(wrong == 0 && u.n_negative == 0, "%zu values, %zu negative", wrong, u.n_negative);
    FF_CHECK(strstr(u.note, "stored as 0") != NULL, "%s", u.note);
    ff_table_clear(&t);
    ff_table_clear(&u);
}

/* ---- files ----------------------------------------------------------------------------------- */

static void check_file(const char *grid, const char *name, const char *format, double rel)
{
    char path[64];
    snprintf(path, sizeof path, "/tmp/ff-simulate-%ld-%s", (long)getpid(), name);
    scene s = scene_make("ggx+lambert", 3, grid);
    if (strcmp(grid, "merl")) set(&s, "alpha_x=0.1");
    s.o.relative = 0.02;
    ff_table t = simulate(&s), back = {.n = 0};
    ff_error err = {0};
    FF_CHECK(ff_table_write(path, format, &t, &err) == FF_OK, "%s", err.message);
    FF_CHECK(ff_table_read_into(path, NULL, &back, &err) == FF_OK, "%s", err.message);
    FF_CHECK(back.n == t.n && back.n_channels == 3 && back.n_invalid == t.n_invalid && back.isotropic == t.isotropic,
             "%zu samples of %zu", back.n, t.n);
    double worst = 0, a, b;
    for (size_t i = 0; i < t.n && back.n == t.n; i++) {
        if (t.valid[i] != back.valid[i]) worst = INFINITY;
        for (size_t c = 0; t.valid[i] && c < 3; c++) {
            ff_table_values(&t, c, i, 1, &a);
            ff_table_values(&back, c, i, 1, &b);
            worst = fmax(worst, fabs(a - b) / fabs(a));
        }
    }
    FF_CHECK(worst <= rel, "%s: values differ by %g", name, worst);
    remove(path);
    ff_table_clear(&t);
    ff_table_clear(&back);
}

static void files_round_trip(void)
{
    check_file("merl", "a.binary", "merl", 4e-16);
    check_file("goniometer", "a.csv", "csv", 0);
    check_file("scattered:2000", "b.csv", "csv", 0);
    check_file("goniometer", "a.astm", "astm", 1e-15);
}

/* ---- refusals -------------------------------------------------------------------------------- */

static void refusals(void)
{
    static const struct {
        const char *grid;
        ff_status status;
    } bad[] = {{"", FF_ERR_UNKNOWN},
               {"merl:2", FF_ERR_UNKNOWN},
               {"gonio", FF_ERR_UNKNOWN},
               {"goniometer:", FF_ERR_SYNTAX},
               {"goniometer:0.1", FF_ERR_RANGE},
               {"goniometer:5x", FF_ERR_SYNTAX},
               {"scattered", FF_ERR_RANGE},
               {"scattered:1.5", FF_ERR_RANGE},
               {"scattered:-1", FF_ERR_RANGE},
               {"scattered:1e12", FF_ERR_RANGE},
               {"scattered:10:2", FF_ERR_RANGE},
               {"scattered:10:0.5:1", FF_ERR_SYNTAX}};
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++) {
        ff_sampling s = {.n = 4711};
        ff_error err = {0};
        FF_CHECK(ff_sampling_parse(bad[i].grid, &s, &err) == bad[i].status && *err.message, "'%s': %d %s", bad[i].grid, err.code,
                 err.message);
        FF_CHECK(s.n == 4711, "a refusal wrote its output");
    }
    scene s = scene_make("ggx", 1, "scattered:10");
    ff_table t = {.n = 4711};
    ff_error err = {0};
    const volatile int cancel = 1;
#define REFUSED(change, expected, restore)                                                                                         \
    change;                                                                                                                        \
    FF_CHECK(ff_simulate_into(&s.model, 1, s.shape, s.channel, &s.o, &t, &err) == expected, #change ": %s", err.message);          \
    FF_CHECK(t.n == 4711, "a refusal wrote its output");                                                                           \
    restore
    REFUSED(s.o.sigma = 1, FF_ERR_RANGE, s.o.sigma = 0);
    REFUSED(s.o.relative = -0.1, FF_ERR_RANGE, s.o.relative = 0);
    REFUSED(s.o.floor = NAN, FF_ERR_RANGE, s.o.floor = 0);
    REFUSED(s.o.cancel = &cancel, FF_ERR_CANCELLED, s.o.cancel = NULL);
    REFUSED(s.shape[0] = -1, FF_ERR_RANGE, s.shape[0] = 0.3);
    REFUSED(s.o.size = 1, FF_ERR_INTERNAL, s.o.size = sizeof s.o);
}

FF_TEST_MAIN(FF_TEST(philox_known_answers), FF_TEST(uniform_is_the_generator), FF_TEST(quantile_of_the_tails),
             FF_TEST(normal_is_the_quantile_of_uniform), FF_TEST(normal_moments), FF_TEST(exact_without_noise),
             FF_TEST(instruments), FF_TEST(specular_fraction), FF_TEST(noise_has_its_moments), FF_TEST(noise_of_a_model),
             FF_TEST(seeds_reproduce), FF_TEST(negative_values), FF_TEST(files_round_trip), FF_TEST(refusals))
