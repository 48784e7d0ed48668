/* Pictures of lit spheres: the light of a pixel against albedos and quadrature, the error that is said against that of twenty
 * seeds, symmetries, and bits that depend on nothing but the seed. render_numbers_test.py has formulas of its own. */
#include "ff_test.h"
#include "ff_albedo.h"
#include "ff_render.h"
#include "ff_simulate.h"
#include "ff_spectral.h"
#include "data_formats/table/table_struct.h"

static const double pi = 3.14159265358979323846;

enum { SIZE = 24, PIXELS = SIZE * SIZE, SEEDS = 20, NX = 48, NY = 24 };

/* ---- what the tests share -------------------------------------------------------------------- */

typedef struct surface {
    ff_model *m;
    size_t n_channels;
    double shape[32], channel[3 * 16];
} surface;

static surface make(const char *expression, size_t n_channels, const char *const *set)
{
    surface s = {.n_channels = n_channels};
    ff_error err = {0};
    FF_CHECK(ff_model_new(expression, &s.m, &err) == FF_OK, "%s", err.message);
    ff_model_defaults(s.m, n_channels, s.shape, s.channel);
    for (; *set; set++) FF_CHECK(ff_model_set(s.m, n_channels, *set, s.shape, s.channel, &err) == FF_OK, "%s", err.message);
    return s;
}

static ff_render_summary render(const surface *s, const ff_render_options *o, float *rgba)
{
    ff_render_summary out = {0};
    ff_error err = {0};
    const ff_status status = ff_render_model(s->m, s->n_channels, s->shape, s->channel, o, rgba, &out, &err);
    FF_CHECK(status == FF_OK, "%s", err.message);
    return out;
}

static ff_render_options options(void)
{
    ff_render_options o;
    ff_render_options_init(&o);
    o.pixels = SIZE;
    o.threads = 1;
    return o;
}

static ff_environment *uniform(void)
{
    ff_environment *e = NULL;
    FF_CHECK(ff_environment_new(1, 1, (const float[]){1, 1, 1}, 0, &e, NULL) == FF_OK, "uniform");
    return e;
}

/* Smooth, coloured, one side much brighter. */
static ff_environment *coloured(void)
{
    ff_environment *e = NULL;
    float rgb[3 * NX * NY];
    for (size_t k = 0; k < 3 * NX * NY; k++) {
        const double t = pi * ((double)(k / 3 / NX) + 0.5) / NY, a = 2 * pi * (double)(k / 3 % NX) / NX;
        rgb[k] = (float)(0.2 + exp(6 * (sin(t) * sin(a + (double)(k % 3)) - 1)) * 5);
    }
    FF_CHECK(ff_environment_new(NX, NY, rgb, 0.3, &e, NULL) == FF_OK, "coloured");
    return e;
}

/* x, y of the middle of a pixel, the normal there; 0 where the pixel is not all of the sphere. */
static int normal_at(size_t k, size_t size, double n[3])
{
    n[0] = (2 * (double)(k % size) + 1) / (double)size - 1;
    n[1] = 1 - (2 * (double)(k / size) + 1) / (double)size;
    const double z2 = 1 - n[0] * n[0] - n[1] * n[1];
    n[2] = sqrt(fmax(z2, 0));
    return z2 > 0.05;
}

static void to_surface(const double n[3], const double v[3], double out[3])
{
    const double s = hypot(n[0], n[2]), t[3] = {n[2] / s, 0, -n[0] / s},
                 b[3] = {n[1] * t[2] - n[2] * t[1], n[2] * t[0] - n[0] * t[2], n[0] * t[1] - n[1] * t[0]};
    const double *const axis[3] = {t, b, n};
    for (int k = 0; k < 3; k++) out[k] = axis[k][0] * v[0] + axis[k][1] * v[1] + axis[k][2] * v[2];
}

/* ---- environments ---------------------------------------------------------------------------- */

/* In a white furnace every pixel is the albedo of its view: the deviations are what the error says, and their mean is 0. */
static void furnace(const char *expression, const char *const *set)
{
    enum { LARGE = 96 };
    surface s = make(expression, 1, set);
    float *rgba = malloc(4 * LARGE * LARGE * sizeof *rgba);
    ff_environment *e = uniform();
    ff_render_options o = options();
    double n[3], sum = 0, squares = 0, count = 0;
    o.pixels = LARGE;
    o.environment = e;
    o.seed = ff_test_seed() + 7;
    const ff_render_summary summary = render(&s, &o, rgba);
    for (size_t k = 0; k < LARGE * LARGE; k += 3) {
        ff_integral albedo;
        if (!normal_at(k, LARGE, n) || n[2] < 0.4) continue;
        const double wo[3] = {0, -sqrt(1 - n[2] * n[2]), n[2]};
        FF_CHECK(ff_albedo_directional(s.m, FF_ISA_BEST, 1, s.shape, s.channel, wo, &albedo, NULL) == FF_OK, "albedo");
        const double d = (double)rgba[4 * k] - albedo.value;
        sum += d;
        squares += d * d;
        count++;
    }
    const double rms = sqrt(squares / count);
    FF_CHECK(summary.samples == 256 && summary.error > 0, "%zu samples, error %g", summary.samples, summary.error);
    FF_CHECK(fabs(sum / count) < 5 * rms / sqrt(count) + 2e-5, "%s: mean deviation %g +- %g", expression, sum / count,
             rms / sqrt(count));
    FF_CHECK(rms < 2 * summary.error, "%s: deviations of %g, error %g", expression, rms, summary.error);
    ff_environment_free(e);
    ff_model_free(s.m);
    free(rgba);
}

static void furnaces_give_albedos(void)
{
    furnace("ggx+lambert", (const char *const[]){"alpha=0.3", "f0=0.2", "kd=0.4", NULL});
    furnace("beckmann", (const char *const[]){"alpha=0.15", "f0=0.9", NULL});
    furnace("gtr", (const char *const[]){"alpha=0.4", NULL});
    furnace("lambert", (const char *const[]){"kd=1", NULL});
    furnace("ggx", (const char *const[]){"alpha=0.02", "f0=0.5", NULL});
}

/* The light of a point by quadrature over the environment: midpoints of many cells. */
static void quadrature(const surface *s, const ff_environment *e, const double n[3], double out[3])
{
    enum { ROWS = 500, COLUMNS = 1000 };
    static const double view[3] = {0, 0, 1};
    double w[3][COLUMNS], L[3][COLUMNS], wi[3][COLUMNS], wo[3][COLUMNS], f[3 * COLUMNS], o[3];
    to_surface(n, view, o);
    memset(out, 0, 3 * sizeof *out);
    for (size_t r = 0; r < ROWS; r++) {
        const double t0 = pi * (double)r / ROWS, t = t0 + 0.5 * pi / ROWS,
                     omega = 2 * pi / COLUMNS * (cos(t0) - cos(t0 + pi / ROWS));
        for (size_t c = 0; c < COLUMNS; c++) {
            const double a = 2 * pi * ((double)c + 0.5) / COLUMNS, v[3] = {sin(t) * sin(a), cos(t), -sin(t) * cos(a)};
            double local[3];
            to_surface(n, v, local);
            for (int k = 0; k < 3; k++) w[k][c] = v[k], wi[k][c] = local[k], wo[k][c] = o[k];
        }
        ff_environment_look(e, COLUMNS, w[0], L[0], NULL, COLUMNS);
        const ff_dirs dirs = {wi[0], wi[1], wi[2], wo[0], wo[1], wo[2]};
        FF_CHECK(ff_model_eval(s->m, FF_ISA_BEST, s->n_channels, s->shape, s->channel, &dirs, COLUMNS, f, NULL, COLUMNS) == FF_OK,
                 "f");
        for (size_t c = 0; c < COLUMNS; c++)
            for (size_t k = 0; k < 3; k++) out[k] += f[k * COLUMNS + c] * fmax(wi[2][c], 0) * L[k][c] * omega;
    }
}

/* Of twenty pictures of different seeds: mean and spread of every pixel. */
typedef struct seeds {
    double mean[PIXELS][3], variance[PIXELS][3], error; /* error: what the pictures said, root mean square */
    size_t n_sphere;
} seeds;

static void twenty(const surface *s, ff_render_options o, seeds *out)
{
    float rgba[4 * PIXELS];
    memset(out, 0, sizeof *out);
    for (uint64_t k = 0; k < SEEDS; k++) {
        o.seed = 1000 * ff_test_seed() + k;
        const ff_render_summary summary = render(s, &o, rgba);
        out->error += summary.error * summary.error / SEEDS;
        for (size_t p = 0; p < PIXELS; p++)
            for (size_t c = 0; c < 3; c++) {
                out->mean[p][c] += (double)rgba[4 * p + c] / SEEDS;
                out->variance[p][c] += (double)rgba[4 * p + c] * (double)rgba[4 * p + c] / (SEEDS - 1);
            }
    }
    out->error = sqrt(out->error);
    for (size_t p = 0; p < PIXELS; p++) {
        out->n_sphere += rgba[4 * p + 3] > 0;
        for (size_t c = 0; c < 3; c++) out->variance[p][c] -= out->mean[p][c] * out->mean[p][c] * SEEDS / (SEEDS - 1.0);
    }
}

static void pictures_are_quadratures(void)
{
    surface s = make("ggx+lambert", 3, (const char *const[]){"alpha=0.25", "f0=0.3:0.6:0.9", "kd=0.5:0.3:0.1", NULL});
    ff_environment *e = coloured();
    ff_render_options o = options();
    static seeds got;
    double n[3], want[3];
    o.environment = e;
    twenty(&s, o, &got);
    size_t looked_at = 0;
    for (size_t k = 0; k < PIXELS; k += ff_test_is_thorough() ? 7 : 23) {
        /* a pixel is a mean over its area: of small ones, near enough to their middle */
        if (!normal_at(k, SIZE, n) || n[2] < 0.5) continue;
        double area[3] = {0};
        for (int q = 0; q < 9; q++) {
            double m[3] = {n[0] + (q % 3 - 1) * 2.0 / 3 / SIZE, n[1] + (q / 3 - 1) * 2.0 / 3 / SIZE};
            m[2] = sqrt(1 - m[0] * m[0] - m[1] * m[1]);
            quadrature(&s, e, m, want);
            for (int c = 0; c < 3; c++) area[c] += want[c] / 9;
        }
        looked_at++;
        for (size_t c = 0; c < 3; c++) {
            const double error = sqrt(got.variance[k][c] / SEEDS);
            FF_CHECK(fabs(got.mean[k][c] - area[c]) < 5.5 * error + 1e-3 * area[c],
                     "pixel %zu, channel %zu: %g +- %g, by quadrature %g", k, c, got.mean[k][c], error, area[c]);
        }
    }
    FF_CHECK(looked_at > 10, "%zu pixels", looked_at);
    ff_environment_free(e);
    ff_model_free(s.m);
}

/* The root mean square over the sphere of the spread of twenty seeds is the error that each picture says, within what so many
 * pixels leave to chance: 19 degrees of freedom of some 450 pixels. */
static void errors_are_right(void)
{
    surface s = make("ggx+lambert", 3, (const char *const[]){"alpha=0.25", "f0=0.3:0.6:0.9", "kd=0.5:0.3:0.1", NULL});
    ff_environment *e = coloured();
    static const size_t samples[] = {1, 30, 64, 256};
    static seeds got;
    for (size_t q = 0; q < sizeof samples / sizeof *samples; q++) {
        ff_render_options o = options();
        double sum = 0;
        o.environment = e;
        o.samples = samples[q];
        twenty(&s, o, &got);
        for (size_t p = 0; p < PIXELS; p++)
            for (size_t c = 0; c < 3; c++) sum += got.variance[p][c];
        const double spread = sqrt(sum / (3 * (double)got.n_sphere));
        printf("%zu samples: error %.5f, spread of %d seeds %.5f\n", samples[q], got.error, (int)SEEDS, spread);
        FF_CHECK(fabs(got.error / spread - 1) < 0.1, "%zu samples: error %g, spread %g", samples[q], got.error, spread);
    }
    ff_environment_free(e);
    ff_model_free(s.m);
}

/* ---- lights ---------------------------------------------------------------------------------- */

/* An isotropic sphere under lights that are turned about the view is the same picture turned. */
static void turned_lights_turn_the_picture(void)
{
    surface s = make("ggx+lambert", 1, (const char *const[]){"alpha=0.2", NULL});
    float one[4 * PIXELS], other[4 * PIXELS];
    const double light[2][3] = {{0.3, 0.8, 0.2}, {-0.5, 0.1, 2}}, turned[2][3] = {{-0.8, 0.3, 0.2}, {-0.1, -0.5, 2}};
    for (int perspective = 0; perspective < 2; perspective++) {
        ff_render_options o = options();
        o.perspective = 0.9 * perspective;
        o.n_lights = 2;
        o.light = light;
        render(&s, &o, one);
        o.light = turned;
        render(&s, &o, other);
        for (size_t k = 0; k < PIXELS; k++) { /* (x, y) goes to (-y, x) */
            const size_t i = k % SIZE, j = k / SIZE, to = (SIZE - 1 - i) * SIZE + j;
            FF_CHECK(fabs((double)one[4 * k] - (double)other[4 * to]) < 1e-5 * (1 + (double)one[4 * k]), "pixel %zu: %g, turned %g",
                     k, (double)one[4 * k], (double)other[4 * to]);
            FF_CHECK(one[4 * k + 3] == other[4 * to + 3], "coverage of pixel %zu", k);
        }
    }
    ff_model_free(s.m);
}

static void lights_add_up(void)
{
    surface s = make("beckmann+lambert", 3, (const char *const[]){"kd=0.1:0.2:0.3", NULL});
    float both[4 * PIXELS], first[4 * PIXELS], second[4 * PIXELS];
    const double light[2][3] = {{0.3, 0.8, 0.2}, {-5, 1, 20}};
    ff_render_options o = options();
    o.n_lights = 2;
    o.light = light;
    render(&s, &o, both);
    o.n_lights = 1;
    render(&s, &o, first);
    o.light = light + 1;
    render(&s, &o, second);
    for (size_t k = 0; k < 4 * PIXELS; k++)
        if (k % 4 < 3)
            FF_CHECK(fabs((double)both[k] - (double)first[k] - (double)second[k]) < 1e-6 * (1 + (double)both[k]), "number %zu", k);
    ff_environment *e = uniform();
    o.environment = e;
    render(&s, &o, both);
    o.n_lights = 0;
    render(&s, &o, first);
    for (size_t k = 0; k < 4 * PIXELS; k++)
        if (k % 4 < 3)
            FF_CHECK(fabs((double)both[k] - (double)first[k] - (double)second[k]) < 1e-6 * (1 + (double)both[k]),
                     "surrounded, number %zu", k);
    ff_environment_free(e);
    ff_model_free(s.m);
}

/* Rough along the tangent, which is the parallel: the highlight of a light behind the viewer is wide from left to right; turned to
 * the bitangent it is tall. */
static void brushed_surfaces_lie_as_they_should(void)
{
    const double light[1][3] = {{0, 0, 1}};
    for (int along_y = 0; along_y < 2; along_y++) {
        surface s =
            make("ggx", 1,
                 (const char *const[]){along_y ? "alpha_x=0.05" : "alpha_x=0.5", along_y ? "alpha_y=0.5" : "alpha_y=0.05", NULL});
        float rgba[4 * PIXELS];
        ff_render_options o = options();
        o.n_lights = 1;
        o.light = light;
        render(&s, &o, rgba);
        const size_t middle = SIZE / 2, side = SIZE / 6;
        const float right = rgba[4 * (middle * SIZE + middle + side)], above = rgba[4 * ((middle - side) * SIZE + middle)];
        FF_CHECK(along_y ? above > 3 * right : right > 3 * above, "alpha along %c: %g to the right, %g above", along_y ? 'y' : 'x',
                 (double)right, (double)above);
        ff_model_free(s.m);
    }
}

/* Seen from very far away by perspective is seen from far away; from near, less of the sphere is seen. */
static void perspective_has_its_limit(void)
{
    surface s = make("lambert", 1, (const char *const[]){"kd=1", NULL});
    float far_away[4 * PIXELS], nearly[4 * PIXELS], near_by[4 * PIXELS];
    const double light[1][3] = {{0, 0, 1}};
    ff_render_options o = options();
    o.n_lights = 1;
    o.light = light;
    render(&s, &o, far_away);
    o.perspective = 1e-5;
    render(&s, &o, nearly);
    o.perspective = 1.2;
    render(&s, &o, near_by);
    for (size_t k = 0; k < PIXELS; k++) {
        FF_CHECK(fabs((double)far_away[4 * k] - (double)nearly[4 * k]) < 2e-4, "pixel %zu: %g, %g", k, (double)far_away[4 * k],
                 (double)nearly[4 * k]);
        FF_CHECK(near_by[4 * k] >= far_away[4 * k] - 1e-6f, "pixel %zu of a near sphere is turned away", k);
    }
    /* at its edge the normal is at 90 - 0.6 rad from the light */
    const double edge = (double)near_by[4 * (SIZE / 2 * SIZE + SIZE - 1)];
    FF_CHECK(edge > sin(0.6) && edge < sin(0.6) + 0.2, "edge %g", edge);
    ff_model_free(s.m);
}

/* ---- tables ---------------------------------------------------------------------------------- */

static ff_table *simulate(const surface *s, const char *grid)
{
    ff_simulate_options o;
    ff_table *t = NULL;
    ff_error err = {0};
    ff_simulate_options_init(&o);
    FF_CHECK(ff_sampling_parse(grid, &o.sampling, &err) == FF_OK, "%s", err.message);
    FF_CHECK(ff_simulate(s->m, s->n_channels, s->shape, s->channel, &o, &t, &err) == FF_OK, "%s", err.message);
    return t;
}

/* A table that is exact makes the model's picture, and with the model's directions what differs is interpolation alone: far less
 * than the noise of either. */
static void tables_make_the_picture_of_their_model(void)
{
    surface s = make("ggx+lambert", 3, (const char *const[]){"alpha=0.4", "f0=0.3:0.2:0.1", "kd=0.2:0.4:0.6", NULL});
    ff_table *t = simulate(&s, "merl");
    ff_environment *e = coloured();
    float data[4 * PIXELS], model[4 * PIXELS], own[4 * PIXELS];
    const double light[1][3] = {{-0.4, 0.5, 0.8}};
    ff_render_options o = options();
    ff_render_summary summary, alone;
    ff_error err = {0};
    o.n_lights = 1;
    o.light = light;
    o.environment = e;
    const ff_render_summary said = render(&s, &o, model);
    FF_CHECK(ff_render_table(t, s.m, 3, s.shape, s.channel, &o, data, &summary, &err) == FF_OK, "%s", err.message);
    FF_CHECK(ff_render_table(t, NULL, 0, NULL, NULL, &o, own, &alone, &err) == FF_OK, "%s", err.message);
    double squares = 0, n = 0;
    for (size_t k = 0; k < 4 * PIXELS; k++) {
        double v[3];
        if (k % 4 == 3 || !normal_at(k / 4, SIZE, v)) continue;
        const double d = (double)data[k] - (double)model[k];
        squares += d * d;
        n++;
        FF_CHECK(fabs((double)own[k] - (double)model[k]) < 7 * (alone.error + said.error) + 0.02, "number %zu: %g, model %g", k,
                 (double)own[k], (double)model[k]);
    }
    FF_CHECK(sqrt(squares / n) < 0.5 * said.error, "data and model differ by %g, errors are %g", sqrt(squares / n), said.error);
    FF_CHECK(summary.unknown == 0 && summary.guessed < 0.05, "%g guessed, %g unknown", summary.guessed, summary.unknown);
    ff_table_free(t);
    ff_environment_free(e);
    ff_model_free(s.m);
}

/* ---- threads, and what is refused ------------------------------------------------------------ */

static void bits_are_those_of_the_seed(void)
{
    surface s = make("ggx/v-cavity+lambert", 3, (const char *const[]){"alpha=0.4", NULL});
    ff_table *t = simulate(&s, "goniometer:15");
    ff_environment *e = coloured();
    float one[4 * PIXELS], many[4 * PIXELS];
    ff_render_options o = options();
    ff_render_summary a, b;
    o.environment = e;
    o.samples = 40;
    o.seed = ff_test_seed() + 5;
    for (int data = 0; data < 2; data++)
        for (int threads = 2; threads < 6; threads++) {
            ff_error err = {0};
            for (int pass = 0; pass < 2; pass++) {
                o.threads = pass ? threads : 1;
                float *to = pass ? many : one;
                ff_render_summary *out = pass ? &b : &a;
                if (data)
                    FF_CHECK(ff_render_table(t, NULL, 0, NULL, NULL, &o, to, out, &err) == FF_OK, "%s", err.message);
                else
                    *out = render(&s, &o, to);
            }
            FF_CHECK(!memcmp(one, many, sizeof one), "%d threads make another picture", threads);
            FF_CHECK(!memcmp(&a, &b, sizeof a), "%d threads make another summary", threads);
        }
    o.seed++;
    render(&s, &o, one);
    FF_CHECK(memcmp(one, many, sizeof one) != 0, "another seed makes the same picture");
    ff_table_free(t);
    ff_environment_free(e);
    ff_model_free(s.m);
}

static void what_cannot_be_rendered_is_refused(void)
{
    surface s = make("ggx", 1, (const char *const[]){NULL}), two = make("lambert", 2, (const char *const[]){NULL});
    ff_table *t = simulate(&two, "goniometer:30");
    float rgba[4 * PIXELS];
    const volatile int stop = 1;
    const double bad[][3] = {{0, 0, 0}, {NAN, 0, 1}, {0, INFINITY, 1}};
    ff_render_options o = options();
    ff_error err = {0};
    for (size_t k = 0; k < 3; k++) {
        o.n_lights = 1;
        o.light = bad + k;
        FF_CHECK(ff_render_model(s.m, 1, s.shape, s.channel, &o, rgba, NULL, &err) == FF_ERR_RANGE, "light %zu", k);
    }
    o = options();
    FF_CHECK(ff_render_table(t, NULL, 0, NULL, NULL, &o, rgba, NULL, &err) == FF_OK, "two channels are grey: %s", err.message);
    FF_CHECK(ff_render_model(two.m, 2, two.shape, two.channel, &o, rgba, NULL, &err) == FF_ERR_UNSUPPORTED, "two channels");
    o.samples = 0;
    FF_CHECK(ff_render_model(s.m, 1, s.shape, s.channel, &o, rgba, NULL, &err) == FF_ERR_RANGE, "no samples");
    o = options();
    o.pixels = 0;
    FF_CHECK(ff_render_model(s.m, 1, s.shape, s.channel, &o, rgba, NULL, &err) == FF_ERR_RANGE, "no pixels");
    o = options();
    o.cancel = &stop;
    FF_CHECK(ff_render_model(s.m, 1, s.shape, s.channel, &o, rgba, NULL, &err) == FF_ERR_CANCELLED, "cancelled");
    o = options(); /* and without light all is black, which is a picture */
    FF_CHECK(ff_render_model(s.m, 1, s.shape, s.channel, &o, rgba, NULL, &err) == FF_OK, "%s", err.message);
    for (size_t k = 0; k < 4 * PIXELS; k++) FF_CHECK(k % 4 == 3 || rgba[k] == 0, "number %zu: %g", k, (double)rgba[k]);
    ff_table_free(t);
    ff_model_free(s.m);
    ff_model_free(two.m);
}

/* Which channel is what colour: as they are named, by their wavelengths, else grey. */
static void check_colours(size_t n, const ff_channel *channel, const double *expected)
{
    double matrix[3 * 31];
    ff_error err = {0};
    FF_CHECK(ff_spectral_colours(n, channel, matrix, &err) == FF_OK, "%s", err.message);
    for (size_t k = 0; k < 3 * n; k++) FF_CHECK_CLOSE(matrix[k], expected[k], 1e-15, 0);
}

static void channels_have_their_colours(void)
{
    const double third = 1.0 / 3;
    check_colours(1, (const ff_channel[]){{"c0", NAN, 1}}, (const double[]){1, 1, 1});
    check_colours(2, (const ff_channel[]){{"s", 633, 1}, {"p", 633, 1}}, (const double[]){0.5, 0.5, 0.5, 0.5, 0.5, 0.5});
    check_colours(3, (const ff_channel[]){{"c0", NAN, 1}, {"c1", NAN, 1}, {"c2", NAN, 1}},
                  (const double[]){1, 0, 0, 0, 1, 0, 0, 0, 1});
    check_colours(3, (const ff_channel[]){{"b", 465, 1}, {"g", 525, 1}, {"r", 630, 1}},
                  (const double[]){0, 0, 1, 0, 1, 0, 1, 0, 0});
    check_colours(4, (const ff_channel[]){{"nir", 850, 1}, {"r", NAN, 1}, {"g", NAN, 1}, {"b", NAN, 1}},
                  (const double[]){0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1});
    check_colours(3, (const ff_channel[]){{"a", 900, 1}, {"b", 1000, 1}, {"c", 1100, 1}},
                  (const double[]){third, third, third, third, third, third, third, third, third});
    /* wavelengths, in any order: white is white, and the longest of three makes most of red */
    ff_channel spectrum[31];
    double matrix[3 * 31];
    for (size_t n = 3; n <= 31; n += 28) {
        for (size_t c = 0; c < n; c++)
            spectrum[c] = (ff_channel){.wavelength_nm = 700 - 250.0 * (double)c / (double)(n - 1), .scale = 1};
        FF_CHECK(ff_spectral_colours(n, spectrum, matrix, NULL) == FF_OK, "%zu wavelengths", n);
        for (size_t k = 0; k < 3; k++) {
            double sum = 0, middle = 0, all = 0;
            for (size_t c = 0; c < n; c++) {
                sum += matrix[k * n + c];
                all += fabs(matrix[k * n + c]);
                middle += fabs(matrix[k * n + c]) * spectrum[c].wavelength_nm;
            }
            FF_CHECK_CLOSE(sum, 1, 1e-14, 0);
            FF_CHECK(middle / all > (k == 0   ? 560
                                     : k == 1 ? 500
                                              : 440) &&
                         middle / all < (k == 0   ? 660
                                         : k == 1 ? 600
                                                  : 520),
                     "colour %zu of %zu wavelengths is about %g nm", k, n, middle / all);
        }
    }
}

/* Gold, measured from the blue to the red: its picture is golden, and so is that of its model. */
static void wavelengths_make_the_colour_of_a_picture(void)
{
    surface s = make("lambert", 3, (const char *const[]){"kd=0.2:0.5:0.9", NULL});
    ff_table *t = simulate(&s, "goniometer:15");
    const ff_channel channel[3] = {{"465nm", 465, 1}, {"525nm", 525, 1}, {"630nm", 630, 1}};
    const double light[1][3] = {{0, 0, 1}};
    double matrix[9], expected[3] = {0};
    float rgba[4 * PIXELS];
    ff_render_options o = options();
    ff_render_summary out;
    ff_error err = {0};
    o.n_lights = 1;
    o.light = light;
    for (size_t c = 0; c < 3; c++) t->channels[c] = channel[c];
    FF_CHECK(ff_spectral_colours(3, channel, matrix, &err) == FF_OK, "%s", err.message);
    for (size_t k = 0; k < 3; k++)
        for (size_t c = 0; c < 3; c++) expected[k] += matrix[3 * k + c] * (const double[]){0.2, 0.5, 0.9}[c];
    FF_CHECK(expected[0] > expected[1] && expected[1] > expected[2], "%g %g %g", expected[0], expected[1], expected[2]);
    FF_CHECK(ff_render_table(t, NULL, 0, NULL, NULL, &o, rgba, &out, &err) == FF_OK, "%s", err.message);
    for (size_t k = 0; k < 3; k++) FF_CHECK_CLOSE(out.mean[k] / out.mean[0], expected[k] / expected[0], 1e-4, 0);
    o.colours = matrix;
    FF_CHECK(ff_render_model(s.m, 3, s.shape, s.channel, &o, rgba, &out, &err) == FF_OK, "%s", err.message);
    for (size_t k = 0; k < 3; k++) FF_CHECK_CLOSE(out.mean[k] / out.mean[0], expected[k] / expected[0], 1e-6, 0);
    ff_table_free(t);
    ff_model_free(s.m);
}

FF_TEST_MAIN(FF_TEST(channels_have_their_colours), FF_TEST(wavelengths_make_the_colour_of_a_picture),
             FF_TEST(furnaces_give_albedos), FF_TEST(pictures_are_quadratures), FF_TEST(errors_are_right),
             FF_TEST(turned_lights_turn_the_picture), FF_TEST(lights_add_up), FF_TEST(brushed_surfaces_lie_as_they_should),
             FF_TEST(perspective_has_its_limit), FF_TEST(tables_make_the_picture_of_their_model),
             FF_TEST(bits_are_those_of_the_seed), FF_TEST(what_cannot_be_rendered_is_refused))
