/* Interpolation, conversion and survey of tables: against models, symmetries and hand-made samples. */
#include "ff_albedo.h"
#include "ff_interpolate.h"
#include "data_formats/interpolation/resample_struct.h"
#include "simulate/simulate_struct.h"
#include "data_formats/analysis/survey_struct.h"
#include "ff_test.h"
#include "fit_samples.h"
#include "data_formats/interpolation/internal_neighbours.h"
#include "data_formats/table/internal_table.h"

static const double pi = 3.14159265358979323846;

/* ---- tables from a model --------------------------------------------------------------------- */

static fit_surface make_surface(double alpha_x, double alpha_y)
{
    char words[128];
    snprintf(words, sizeof words, "alpha_x=%g alpha_y=%g f0=0.9:0.6:0.3 kd=0.1", alpha_x, alpha_y);
    return fit_surface_make("ggx+lambert", 3, words);
}

static ff_table simulate(const fit_surface *s, const char *grid, uint64_t seed)
{
    ff_simulate_options o;
    ff_table t;
    ff_error err = {0};
    ff_simulate_options_init(&o);
    o.seed = ff_test_seeded(seed);
    if (ff_sampling_parse(grid, &o.sampling, &err) || ff_simulate_into(&s->model, 3, s->shape, s->channel, &o, &t, &err)) {
        printf("%s: %s\n", grid, err.message);
        exit(1);
    }
    return t;
}

typedef struct directions {
    size_t n;
    double *w[6];
} directions;

static directions directions_of(const ff_table *t)
{
    directions d = {.n = t->n};
    for (int k = 0; k < 6; k++) d.w[k] = malloc(t->n * sizeof(double));
    ff_table_directions(t, 0, t->n, d.w);
    return d;
}

static void directions_free(directions *d)
{
    for (int k = 0; k < 6; k++) free(d->w[k]);
}

static int ascending(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* ---- the tree -------------------------------------------------------------------------------- */

static double uniform(void)
{
    static uint64_t state;
    if (!state) state = ff_test_seeded(88172645463325252u);
    state ^= state << 13, state ^= state >> 7, state ^= state << 17;
    return (double)(state >> 11) * 0x1p-53;
}

/* Points of which many are equal: a lattice. Distances of distinct places by looking at all of them. */
static void neighbours_are_the_nearest(void)
{
    for (int trial = 0; trial < 60; trial++) {
        const int dim = 2 + trial % 3, lattice = trial % 4 == 0;
        const size_t n = 1 + (size_t)(uniform() * 3000), k = 1 + (size_t)(uniform() * 31);
        double *p = malloc(n * (size_t)dim * sizeof *p), *copy = malloc(n * (size_t)dim * sizeof *copy), *d = malloc(n * sizeof *d);
        uint32_t *sample = malloc(n * sizeof *sample);
        for (size_t i = 0; i < n * (size_t)dim; i++) p[i] = lattice ? floor(4 * uniform()) : uniform();
        memcpy(copy, p, n * (size_t)dim * sizeof *p);
        for (size_t i = 0; i < n; i++) sample[i] = (uint32_t)i;
        ff_neighbours *tree = ff_neighbours_new(dim, n, p, sample);
        FF_CHECK(tree != NULL, "no tree of %zu points", n);
        for (int q = 0; q < 20 && tree; q++) {
            const uint32_t without = q % 2 ? (uint32_t)(uniform() * (double)n) : UINT32_MAX;
            double x[4];
            ff_neighbour near[FF_NEIGHBOURS_MOST];
            size_t m = 0;
            for (int j = 0; j < dim; j++) x[j] = 1.4 * uniform() - 0.2;
            for (size_t i = 0; i < n; i++) {
                int first = i != without;
                for (size_t e = 0; e < i && lattice && first; e++)
                    first = e == without || memcmp(copy + e * (size_t)dim, copy + i * (size_t)dim, (size_t)dim * sizeof *copy) != 0;
                double sum = 0;
                for (int j = 0; j < dim; j++) sum += pow(copy[i * (size_t)dim + (size_t)j] - x[j], 2);
                if (first) d[m++] = sum;
            }
            qsort(d, m, sizeof *d, ascending);
            const size_t found = ff_neighbours_find(tree, x, k, without, near), expected = k < m ? k : m;
            FF_CHECK(found == expected, "%zu neighbours of %zu", found, expected);
            for (size_t j = 0; j < found && j < expected; j++) {
                FF_CHECK(fabs(near[j].distance2 - d[j]) < 1e-12, "neighbour %zu at %g, by search of all at %g", j,
                         near[j].distance2, d[j]);
                for (size_t e = 0; e < near[j].n_samples; e++)
                    FF_CHECK(memcmp(near[j].point, copy + near[j].sample[e] * (size_t)dim, (size_t)dim * sizeof *copy) == 0,
                             "a point with another's number");
            }
        }
        ff_neighbours_free(tree);
        free(copy);
        free(d);
    }
}

/* ---- axes ------------------------------------------------------------------------------------ */

static void unit(const double theta, const double phi, double w[3])
{
    w[0] = sin(theta) * cos(phi);
    w[1] = sin(theta) * sin(phi);
    w[2] = cos(theta);
}

static void points_of_axes_and_back(void)
{
    for (int kind = FF_AXES_HALF_DIFFERENCE; kind <= FF_AXES_SPECULAR; kind++)
        for (int trial = 0; trial < 2000; trial++) {
            double wi[3], wo[3], q[4], a[4], vi[3], vo[3];
            unit(1.5 * uniform(), 2 * pi * uniform(), wi);
            unit(1.5 * uniform(), 2 * pi * uniform(), wo);
            ff_axes_point((ff_axes_kind)kind, wi, wo, q);
            ff_axes_angles((ff_axes_kind)kind, 1, q, a);
            unit(a[0], a[1], vi);
            unit(a[2], a[3], vo);
            for (int k = 0; k < 3; k++)
                FF_CHECK(fabs(vi[k] - wi[k]) < 1e-12 && fabs(vo[k] - wo[k]) < 1e-12, "kind %d: component %d of wi %g %g, wo %g %g",
                         kind, k, wi[k], vi[k], wo[k], vo[k]);
        }
}

/* ---- interpolation --------------------------------------------------------------------------- */

static void samples_give_themselves(const char *label, const ff_table *t, size_t step)
{
    ff_interpolant *p = NULL;
    ff_error err = {0};
    const ff_status status = ff_interpolant_new(t, 0, &p, &err);
    FF_CHECK(status == FF_OK, "%s: %s", label, err.message);
    if (status) return;
    for (size_t i = 0; i < t->n; i += step) {
        double w[6], *const planes[6] = {w, w + 1, w + 2, w + 3, w + 4, w + 5}, value[3], y;
        unsigned char found;
        ff_table_directions(t, i, 1, planes);
        if (!t->valid[i]) continue;
        ff_interpolant_eval(p, (const double *const *)planes, 1, value, &found);
        FF_CHECK(found == FF_FOUND_SAMPLE, "%s: sample %zu was found as %d", label, i, found);
        for (size_t c = 0; c < 3; c++) {
            ff_table_values(t, c, i, 1, &y);
            FF_CHECK_CLOSE(value[c], y, 1e-7, 0);
        }
    }
    ff_interpolant_free(p);
}

static void at_samples(void)
{
    const fit_surface glossy = make_surface(0.1, 0.1), brushed = make_surface(0.1, 0.3);
    ff_table t = simulate(&glossy, "merl", 1);
    samples_give_themselves("merl", &t, 997);
    ff_table_clear(&t);
    t = simulate(&glossy, "goniometer:5", 1);
    samples_give_themselves("goniometer", &t, 1);
    ff_table_clear(&t);
    t = simulate(&brushed, "goniometer:5", 1);
    samples_give_themselves("anisotropic goniometer", &t, 7);
    ff_table_clear(&t);
    t = simulate(&brushed, "scattered:5000", 1);
    samples_give_themselves("scattered", &t, 1);
    ff_table_clear(&t);
}

/* Relative errors at scattered directions, by their rank: median and 95 %. Directions beyond 75 degrees are left out. */
static void errors_of(const ff_table *from, const ff_table *at, double *half, double *most, double *inside)
{
    ff_interpolant *p = NULL;
    ff_error err = {0};
    directions d = directions_of(at);
    double *value = malloc(3 * at->n * sizeof *value), *e = malloc(at->n * sizeof *e);
    unsigned char *found = malloc(at->n);
    size_t n = 0, seen = 0;
    FF_CHECK(ff_interpolant_new(from, 0, &p, &err) == FF_OK, "%s", err.message);
    ff_interpolant_eval(p, (const double *const *)d.w, at->n, value, found);
    for (size_t i = 0; i < at->n; i++) {
        double y;
        if (d.w[2][i] < cos(75 * pi / 180) || d.w[5][i] < cos(75 * pi / 180)) continue;
        seen++;
        if (found[i] != FF_FOUND_BETWEEN && found[i] != FF_FOUND_SAMPLE) continue;
        ff_table_values(at, 1, i, 1, &y);
        e[n++] = fabs(value[at->n + i] / y - 1);
    }
    qsort(e, n, sizeof *e, ascending);
    *half = n ? e[n / 2] : NAN;
    *most = n ? e[n * 95 / 100] : NAN;
    *inside = (double)n / (double)seen;
    ff_interpolant_free(p);
    directions_free(&d);
    free(value);
    free(e);
    free(found);
}

static void between_samples(void)
{
    static const struct {
        const char *grid;
        double alpha_x, alpha_y, half, most, inside;
    } all[] = {
        {"merl", 0.1, 0.1, 1e-3, 6e-3, 1},
        {"merl", 0.3, 0.3, 1e-3, 3e-3, 1},
        {"goniometer:5", 0.3, 0.3, 0.022, 0.09, 0.99},
        {"goniometer:2", 0.1, 0.1, 0.018, 0.13, 0.99},
        {"goniometer:5", 0.3, 0.5, 0.042, 0.14, 0.35}, /* four azimuths of incidence, 135 of 360 degrees */
        {"scattered:20000:0.5", 0.3, 0.3, 0.029, 0.125, 0.95},
    };
    for (size_t k = 0; k < sizeof all / sizeof all[0]; k++) {
        const fit_surface s = make_surface(all[k].alpha_x, all[k].alpha_y);
        ff_table from = simulate(&s, all[k].grid, 1), at = simulate(&s, "scattered:4000:0.5", 2);
        double half, most, inside;
        errors_of(&from, &at, &half, &most, &inside);
        printf("  %-20s alpha %g, %g: relative error median %.4f, 95 %% %.4f, %.1f %% between samples\n", all[k].grid,
               all[k].alpha_x, all[k].alpha_y, half, most, 100 * inside);
        FF_CHECK(half < all[k].half && most < all[k].most && inside >= all[k].inside, "%s, alpha %g: %g, %g, %g", all[k].grid,
                 all[k].alpha_x, half, most, inside);
        ff_table_clear(&from);
        ff_table_clear(&at);
    }
}

/* A goniometer that went to 30 degrees of incidence knows nothing of 60, nor of exits that it did not visit. */
static void beyond_the_data(void)
{
    const fit_surface s = make_surface(0.3, 0.3);
    ff_table t = simulate(&s, "goniometer:5", 1);
    for (size_t i = 0; i < t.n; i++) t.valid[i] = t.angle[0][i] * t.radians_per_unit < 31 * pi / 180;
    ff_interpolant *p = NULL;
    FF_CHECK(ff_interpolant_new(&t, 0, &p, NULL) == FF_OK, "no interpolant");
    const double in[3][4] = {{20, 0, 40, 170}, {60, 0, 20, 90}, {60, 0, 70, 90}};
    const ff_found direct[3] = {FF_FOUND_BETWEEN, FF_FOUND_BEYOND, FF_FOUND_BEYOND},
                   exchanged[3] = {FF_FOUND_BETWEEN, FF_FOUND_RECIPROCAL, FF_FOUND_BEYOND};
    for (int k = 0; k < 3; k++) {
        double wi[3], wo[3], value[3];
        unsigned char found;
        unit(in[k][0] * pi / 180, in[k][1] * pi / 180, wi);
        unit(in[k][2] * pi / 180, in[k][3] * pi / 180, wo);
        const double *const w[6] = {&wi[0], &wi[1], &wi[2], &wo[0], &wo[1], &wo[2]};
        ff_interpolant_eval(p, w, 1, value, &found);
        FF_CHECK(found == direct[k], "pair %d: %d, expected %d", k, found, direct[k]);
        ff_interpolant_eval_reciprocal(p, w, 1, value, &found);
        FF_CHECK(found == exchanged[k], "pair %d with reciprocity: %d, expected %d", k, found, exchanged[k]);
        FF_CHECK(value[0] > 0, "pair %d: value %g", k, value[0]);
        wo[2] = -wo[2];
        ff_interpolant_eval(p, w, 1, value, &found);
        FF_CHECK(found == FF_FOUND_BELOW && value[0] == 0, "below the horizon: %d, %g", found, value[0]);
    }
    ff_interpolant_free(p);
    for (size_t i = 0; i < t.n; i++) t.valid[i] = 0;
    ff_error err = {0};
    FF_CHECK(ff_interpolant_new(&t, 0, &p, &err) == FF_ERR_DATA && err.message[0], "a table without a valid sample");
    ff_table_clear(&t);
}

/* At normal incidence every azimuth of the light is the same pair of directions, and what was measured twice is averaged. */
static void the_same_pair_many_times(void)
{
    const fit_surface s = make_surface(0.3, 0.3);
    ff_table t = simulate(&s, "goniometer:5", 1), many;
    const size_t times = 48;
    FF_CHECK(ff_table_init(times * t.n, 3, NULL, 0, 0, &many, NULL) == FF_OK, "no table");
    many.radians_per_unit = t.radians_per_unit;
    for (size_t i = 0; i < many.n; i++) {
        const size_t j = i / times;
        for (int k = 0; k < 4; k++) many.angle[k][i] = t.angle[k][j];
        if (t.angle[0][j] == 0) many.angle[1][i] = 7.5 * (double)(i % times);
        for (size_t c = 0; c < 3; c++) many.value[c * many.n + i] = t.value[c * t.n + j] * (i % 2 ? 1.25 : 0.75);
    }
    const double in[2][4] = {{0, 33, 22, 41}, {37, 0, 21, 160}};
    for (int isotropic = 0; isotropic < 2; isotropic++) {
        ff_interpolant *p = NULL, *one = NULL;
        many.isotropic = isotropic;
        FF_CHECK(!ff_interpolant_new(&many, 0, &p, NULL) && !ff_interpolant_new(&t, 0, &one, NULL), "no interpolant");
        for (int k = 0; k <= isotropic; k++) {
            double wi[3], wo[3], a[3], b[3];
            unsigned char found;
            unit(in[k][0] * pi / 180, in[k][1] * pi / 180, wi);
            unit(in[k][2] * pi / 180, in[k][3] * pi / 180, wo);
            const double *const w[6] = {&wi[0], &wi[1], &wi[2], &wo[0], &wo[1], &wo[2]};
            ff_interpolant_eval(p, w, 1, a, &found);
            FF_CHECK(found == FF_FOUND_BETWEEN, "isotropic %d, pair %d: found %d", isotropic, k, found);
            ff_interpolant_eval(one, w, 1, b, NULL);
            FF_CHECK_CLOSE(a[1], b[1], 1e-9, 0);
        }
        ff_interpolant_free(p);
        ff_interpolant_free(one);
    }
    ff_table_clear(&t);
    ff_table_clear(&many);
}

/* Isotropic samples at random on one side of the plane of incidence stand for the other side as well. */
static void one_side_of_the_plane(void)
{
    const fit_surface s = make_surface(0.3, 0.3);
    ff_table t = simulate(&s, "scattered:20000:0.5", 1), at = simulate(&s, "scattered:2000:0.5", 2);
    directions d = directions_of(&t);
    t.isotropic = 1;
    for (size_t i = 0; i < t.n; i++) t.valid[i] = d.w[0][i] * d.w[4][i] - d.w[1][i] * d.w[3][i] > 0;
    directions_free(&d);
    double half, most, inside;
    errors_of(&t, &at, &half, &most, &inside); /* the model does not care about the side either */
    FF_CHECK(half < 0.03 && most < 0.15 && inside > 0.95, "%g, %g, %g", half, most, inside);
    ff_table_clear(&t);
    ff_table_clear(&at);
}

/* A difference azimuth that goes half around is closed by reciprocity, and one that goes around by itself. */
static void azimuths_are_closed(void)
{
    for (int whole = 0; whole < 2; whole++) {
        double theta[18], phi[36], none = 0;
        for (int k = 0; k < 18; k++) theta[k] = 5 * k + 2.5;
        for (int k = 0; k < 36; k++) phi[k] = 10 * k + 5;
        const size_t n[4] = {18, 1, 18, whole ? 36 : 18};
        const double *const node[4] = {theta, &none, theta, phi};
        ff_table t;
        ff_interpolant *p = NULL;
        FF_CHECK(ff_table_init_axes(FF_AXES_HALF_DIFFERENCE, n, node, pi / 180, 1, 0, &t, NULL) == FF_OK, "no table");
        t.isotropic = 1;
        for (size_t i = 0; i < t.n; i++) t.value[i] = 2 + cos(2 * phi[i % n[3]] * pi / 180);
        FF_CHECK(ff_interpolant_new(&t, 0, &p, NULL) == FF_OK, "no interpolant");
        for (int k = 0; k < 36; k++) {
            const double q[4] = {20, 0, 30, 10 * k}, in[4] = {20 * pi / 180, 0.3, 30 * pi / 180, 10 * k * pi / 180};
            double a[4], wi[3], wo[3], v;
            unsigned char found;
            ff_axes_angles(FF_AXES_HALF_DIFFERENCE, 1, in, a);
            unit(a[0], a[1], wi);
            unit(a[2], a[3], wo);
            const double *const w[6] = {&wi[0], &wi[1], &wi[2], &wo[0], &wo[1], &wo[2]};
            ff_interpolant_eval(p, w, 1, &v, &found);
            FF_CHECK(found == FF_FOUND_BETWEEN, "phi_d = %g: found %d", q[3], found);
            FF_CHECK_CLOSE(v, 2 + cos(2 * in[3]) * cos(10 * pi / 180), 1e-9, 0); /* the mean of two neighbours */
        }
        ff_interpolant_free(p);
        ff_table_clear(&t);
    }
}

/* Left out, a sample does not speak for itself, not even where another was taken at the same place. */
static void without_a_sample(void)
{
    const fit_surface s = make_surface(0.3, 0.3);
    ff_table t = simulate(&s, "goniometer:5", 1), twice;
    ff_interpolant *p = NULL;
    double value[3], y;
    FF_CHECK(ff_table_init(t.n + 1, 3, NULL, 0, 0, &twice, NULL) == FF_OK, "no table");
    twice.radians_per_unit = t.radians_per_unit;
    twice.isotropic = 1;
    const size_t i = 2000;
    for (size_t j = 0; j < twice.n; j++)
        for (int k = 0; k < 4; k++) twice.angle[k][j] = t.angle[k][j < t.n ? j : i];
    for (size_t j = 0; j < twice.n; j++)
        for (size_t c = 0; c < 3; c++) twice.value[c * twice.n + j] = j < t.n ? t.value[c * t.n + j] : 77;
    FF_CHECK(ff_interpolant_new(&twice, 0, &p, NULL) == FF_OK, "no interpolant");
    FF_CHECK(ff_interpolant_without(p, i, value) == FF_FOUND_SAMPLE, "the other one stands there");
    FF_CHECK_CLOSE(value[1], 77, 1e-12, 0);
    ff_interpolant_free(p);
    FF_CHECK(ff_interpolant_new(&t, 0, &p, NULL) == FF_OK, "no interpolant");
    FF_CHECK(ff_interpolant_without(p, i, value) == FF_FOUND_BETWEEN, "it is found among its neighbours");
    ff_table_values(&t, 1, i, 1, &y);
    FF_CHECK(value[1] != y && fabs(value[1] / y - 1) < 0.05, "%g, without it %g", y, value[1]);
    ff_interpolant_free(p);
    ff_table_clear(&t);
    ff_table_clear(&twice);
}

/* No value leaves the range of the samples, whatever they are. */
static void within_range(void)
{
    const fit_surface s = make_surface(0.05, 0.05);
    ff_table t = simulate(&s, "goniometer:5", 1), at = simulate(&s, "scattered:4000:0.8", 3);
    double lo = INFINITY, hi = -INFINITY;
    for (size_t i = 0; i < 3 * t.n; i++) {
        if (i % 11 == 0) t.value[i] = -t.value[i];
        lo = fmin(lo, t.value[i]);
        hi = fmax(hi, t.value[i]);
    }
    ff_interpolant *p = NULL;
    directions d = directions_of(&at);
    double *value = malloc(3 * at.n * sizeof *value);
    FF_CHECK(ff_interpolant_new(&t, 0, &p, NULL) == FF_OK, "no interpolant");
    ff_interpolant_eval(p, (const double *const *)d.w, at.n, value, NULL);
    for (size_t i = 0; i < 3 * at.n; i++) FF_CHECK(value[i] >= lo && value[i] <= hi, "%g is outside %g .. %g", value[i], lo, hi);
    ff_interpolant_free(p);
    directions_free(&d);
    free(value);
    ff_table_clear(&t);
    ff_table_clear(&at);
}

/* ---- conversion ------------------------------------------------------------------------------ */

static void to_merl(void)
{
    const fit_surface s = make_surface(0.3, 0.3);
    ff_table t = simulate(&s, "goniometer:5", 1), exact = simulate(&s, "merl", 1), made;
    ff_resample_options o;
    ff_resample_report r;
    ff_error err = {0};
    ff_resample_options_init(&o);
    const ff_status status = ff_resample_into(&t, ff_format_find("merl"), &o, &made, &r, &err);
    FF_CHECK(status == FF_OK, "%s", err.message);
    if (status) return;
    FF_CHECK(!r.as_it_is && made.grid == &ff_grid_merl && made.n == exact.n, "not the MERL grid");
    FF_CHECK(r.at_sample + r.between + r.reciprocal + r.beyond + r.below_horizon == r.n, "the counts do not add up");
    FF_CHECK(r.invalid == r.beyond + r.below_horizon && made.n_invalid == r.invalid, "%zu invalid", r.invalid);
    double sum = 0, reference = 0;
    for (size_t i = 0; i < made.n; i++) {
        double a, b;
        if (!made.valid[i] || !exact.valid[i]) continue;
        ff_table_values(&made, 0, i, 1, &a);
        ff_table_values(&exact, 0, i, 1, &b);
        sum += pow(a - b, 2);
        reference += b * b;
    }
    printf("  goniometer of 5 degrees to MERL: rms error %.3f of the rms value\n", sqrt(sum / reference));
    FF_CHECK(sqrt(sum / reference) < 0.1, "rms error %g", sqrt(sum / reference));
    ff_table_clear(&t);

    /* and what has the grid already is not touched */
    FF_CHECK(ff_resample_into(&exact, ff_format_find("merl"), &o, &t, &r, &err) == FF_OK, "%s", err.message);
    FF_CHECK(r.as_it_is && memcmp(t.value, exact.value, 3 * t.n * sizeof *t.value) == 0, "MERL to MERL is not the same");
    ff_table_clear(&t);
    ff_table_clear(&made);
    ff_table_clear(&exact);
}

static void what_is_dropped(void)
{
    const fit_surface s = make_surface(0.3, 0.3);
    ff_simulate_options so;
    ff_table t, made;
    ff_resample_options o;
    ff_resample_report r;
    ff_error err = {0};
    ff_simulate_options_init(&so);
    so.relative = 0.1;
    so.floor = 0.1;
    so.sigma = 1;
    FF_CHECK(ff_simulate_into(&s.model, 3, s.shape, s.channel, &so, &t, &err) == FF_OK, "%s", err.message);
    FF_CHECK(t.sigma && t.n_negative > 0, "the data have neither sigma nor negative values");
    ff_resample_options_init(&o);
    FF_CHECK(ff_resample_into(&t, ff_format_find("csv"), &o, &made, &r, &err) == FF_OK, "%s", err.message);
    FF_CHECK(r.as_it_is && made.sigma && r.raised == 0 && !made.note[0], "csv drops nothing: %s", made.note);
    ff_table_clear(&made);
    FF_CHECK(ff_resample_into(&t, ff_format_find("astm"), &o, &made, &r, &err) == FF_OK, "%s", err.message);
    FF_CHECK(r.as_it_is && !made.sigma && strstr(made.note, "standard deviations"), "astm has no sigma: %s", made.note);
    ff_table_clear(&made);
    FF_CHECK(ff_resample_into(&t, ff_format_find("merl"), &o, &made, &r, &err) == FF_OK, "%s", err.message);
    FF_CHECK(!r.as_it_is && !made.sigma && strstr(made.note, "standard deviations"), "interpolated values have no sigma: %s",
             made.note);
    for (size_t i = 0; i < 3 * made.n; i++)
        FF_CHECK(!(made.valid[i % made.n] && made.value[i] < 0), "a negative value in a MERL table");
    ff_table_clear(&made);
    o.grid = "5";
    FF_CHECK(ff_resample_into(&t, ff_format_find("csv"), &o, &made, &r, &err) == FF_ERR_UNSUPPORTED, "csv has no grid to choose");
    FF_CHECK(ff_resample_into(&t, ff_format_find("merl"), &o, &made, &r, &err) == FF_ERR_SYNTAX, "nor has merl");
    ff_table_clear(&t);
}

/* ---- survey ---------------------------------------------------------------------------------- */

static void albedo_of(const fit_surface *s, double theta, double albedo[3])
{
    double wo[3];
    ff_integral out[3];
    ff_error err = {0};
    unit(theta * pi / 180, 0, wo);
    FF_CHECK(ff_albedo_directional(&s->model, FF_ISA_BEST, 3, s->shape, s->channel, wo, out, &err) == FF_OK, "%s", err.message);
    for (int c = 0; c < 3; c++) albedo[c] = out[c].value;
}

static void reflectance_of(const char *grid, double alpha, double tolerance)
{
    const fit_surface s = make_surface(alpha, alpha);
    ff_table t = simulate(&s, grid, 1);
    ff_survey v;
    ff_error err = {0};
    FF_CHECK(ff_survey_init(&t, &v, &err) == FF_OK, "%s", err.message);
    FF_CHECK(v.n_reflectances >= 5, "%s: %zu incidences", grid, v.n_reflectances);
    for (size_t k = 0; k < v.n_reflectances; k++) {
        if (v.reflectance[k].theta_i > 61) continue; /* the goniometer ends at 85 degrees */
        double albedo[3];
        albedo_of(&s, v.reflectance[k].theta_i, albedo);
        for (size_t c = 0; c < 3; c++) FF_CHECK_CLOSE(v.albedo[3 * k + c], albedo[c], tolerance, 0);
        FF_CHECK(v.reflectance[k].covered > 0.98, "%s at %g: covers %g", grid, v.reflectance[k].theta_i, v.reflectance[k].covered);
    }
    FF_CHECK(ff_survey_cosine(&v) == 0, "%s: a cosine is suspected (%g, %g, %g)", grid, v.reciprocity.deviation, v.with_cosine,
             v.without_cosine);
    ff_survey_clear(&v);
    ff_table_clear(&t);
}

static void reflectances(void)
{
    reflectance_of("merl", 0.1, 0.01);
    reflectance_of("merl", 0.3, 0.005);
    reflectance_of("goniometer:2", 0.2, 0.03);
    reflectance_of("goniometer:5", 0.3, 0.03);
}

/* Multiplies every value by cos(theta_o)^power. */
static void times_cosine(ff_table *t, double power)
{
    directions d = directions_of(t);
    for (size_t c = 0; c < t->n_channels; c++)
        for (size_t i = 0; i < t->n; i++) t->value[c * t->n + i] *= pow(d.w[5][i], power);
    directions_free(&d);
}

static void cosines_are_noticed(void)
{
    static const double power[3] = {1, 0, -1};
    static const char *const grids[] = {"goniometer:5", "scattered:20000:0.3"};
    for (size_t g = 0; g < 2; g++)
        for (int k = 0; k < 3; k++)
            for (int brushed = 0; brushed < 2; brushed++) {
                const fit_surface s = make_surface(0.3, brushed ? 0.4 : 0.3);
                ff_table t = simulate(&s, grids[g], 1);
                ff_survey v;
                times_cosine(&t, power[k]);
                FF_CHECK(ff_survey_init(&t, &v, NULL) == FF_OK, "no survey");
                FF_CHECK(ff_survey_cosine(&v) == (int)power[k],
                         "%s, cos^%g, %d: found %d; deviations %.3f (%.3f, %.3f), %zu pairs, alone %.3f", grids[g], power[k],
                         brushed, ff_survey_cosine(&v), v.reciprocity.deviation, v.with_cosine, v.without_cosine,
                         v.reciprocity.pairs, v.reciprocity.interpolation);
                ff_survey_clear(&v);
                ff_table_clear(&t);
            }
}

static void isotropy_is_measured(void)
{
    for (int k = 0; k < 2; k++) {
        const fit_surface s = make_surface(0.2, k ? 0.2 : 0.5);
        ff_table t = simulate(&s, k ? "scattered:40000:0.5" : "goniometer:5", 1);
        ff_survey v;
        t.isotropic = 0;
        FF_CHECK(ff_survey_init(&t, &v, NULL) == FF_OK, "no survey");
        FF_CHECK(!v.isotropy.given && v.isotropy.pairs > 200, "%zu pairs", v.isotropy.pairs);
        if (k)
            FF_CHECK(v.isotropy.deviation < 1.5 * v.isotropy.interpolation, "an isotropic surface: %g, interpolation %g",
                     v.isotropy.deviation, v.isotropy.interpolation);
        else
            FF_CHECK(v.isotropy.deviation > 5 * v.isotropy.interpolation && v.isotropy.deviation > 0.2, "a brushed one: %g, %g",
                     v.isotropy.deviation, v.isotropy.interpolation);
        ff_survey_clear(&v);
        ff_table_clear(&t);
    }
}

static void coverage(void)
{
    ff_table t;
    ff_survey v;
    FF_CHECK(ff_table_init(3, 1, NULL, 0, 0, &t, NULL) == FF_OK, "no table");
    t.radians_per_unit = pi / 180;
    const double angle[3][4] = {{30, 10, 30, 190}, {60, 0, 42, 10}, {0, 0, 100, 0}};
    for (int i = 0; i < 3; i++)
        for (int k = 0; k < 4; k++) t.angle[k][i] = angle[i][k];
    for (int i = 0; i < 3; i++) t.value[i] = 1;
    FF_CHECK(ff_survey_init(&t, &v, NULL) == FF_OK, "no survey");
    FF_CHECK(v.below_horizon == 1, "%zu below the horizon", v.below_horizon);
    FF_CHECK_CLOSE(v.theta_i[0], 30, 1e-12, 0);
    FF_CHECK_CLOSE(v.theta_i[1], 60, 1e-12, 0);
    FF_CHECK_CLOSE(v.theta_o[1], 42, 1e-12, 0);
    int met = 0;
    for (int i = 0; i < FF_SURVEY_ROWS; i++)
        for (int o = 0; o < FF_SURVEY_COLUMNS; o++) met += v.azimuths[i][o];
    FF_CHECK(met == 2 && v.azimuths[3][6] == 1 && v.azimuths[6][8] == 1, "%d cells", met);
    FF_CHECK(v.near_mirror[0] == 1 && v.near_mirror[3] == 1, "%zu near the mirror direction", v.near_mirror[0]);
    ff_survey_clear(&v);
    ff_table_clear(&t);
}

FF_TEST_MAIN(FF_TEST(neighbours_are_the_nearest), FF_TEST(points_of_axes_and_back), FF_TEST(at_samples), FF_TEST(between_samples),
             FF_TEST(beyond_the_data), FF_TEST(the_same_pair_many_times), FF_TEST(one_side_of_the_plane),
             FF_TEST(azimuths_are_closed), FF_TEST(without_a_sample), FF_TEST(within_range), FF_TEST(to_merl),
             FF_TEST(what_is_dropped), FF_TEST(reflectances), FF_TEST(cosines_are_noticed), FF_TEST(isotropy_is_measured),
             FF_TEST(coverage))
