/* Infinities and NaNs in a table, where a program has put them: not measured, and as if marked so. They reach no other sample, by
 * no method of interpolation and in no format. */
#include "data_formats/analysis/survey_struct.h"
#include "data_formats/interpolation/ff_interpolate.h"
#include "data_formats/interpolation/resample_struct.h"
#include "simulate/simulate_struct.h"
#include "fit_samples.h"

/* ---- tables ---------------------------------------------------------------------------------- */

static ff_table simulated(const char *grid, size_t channels)
{
    const fit_surface s = fit_surface_make("ggx+lambert", channels, "alpha=0.3 f0=0.5 kd=0.2");
    ff_simulate_options o;
    ff_table t;
    ff_error err = {0};
    ff_simulate_options_init(&o);
    if (ff_sampling_parse(grid, &o.sampling, &err) || ff_simulate_into(&s.model, channels, s.shape, s.channel, &o, &t, &err)) {
        printf("%s: %s\n", grid, err.message);
        exit(1);
    }
    return t;
}

/* On the axes of a format, along which it is linear. */
static ff_table on_axes_of(const char *format)
{
    ff_table t = simulated("goniometer:5", 1), made;
    ff_resample_options o;
    ff_resample_report r;
    ff_resample_options_init(&o);
    o.beyond = 1;
    ff_error err = {0};
    if (ff_resample_into(&t, ff_format_find(format), &o, &made, &r, &err)) {
        printf("%s: %s\n", format, err.message);
        exit(1);
    }
    ff_table_clear(&t);
    return made;
}

/* 41 patches (Klems' quarter basis), or the 16^3 cells of a tensor tree. */
static ff_table cells(int tree)
{
    const char *path = ff_test_path("cells.xml"), *basis = tree ? "<AngleBasis>LBNL/Shirley-Chiu</AngleBasis>"
                                                                : "<ColumnAngleBasis>LBNL/Klems Quarter</ColumnAngleBasis>"
                                                                  "<RowAngleBasis>LBNL/Klems Quarter</RowAngleBasis>";
    FILE *f = fopen(path, "w");
    ff_table t;
    ff_read_options o;
    ff_error err = {0};
    if (!f) exit(1);
    fprintf(f,
            "<?xml version=\"1.0\"?>\n<WindowElement><Optical><Layer><DataDefinition><IncidentDataStructure>%s"
            "</IncidentDataStructure></DataDefinition>\n<WavelengthData><Wavelength>Visible</Wavelength><WavelengthDataBlock>"
            "<WavelengthDataDirection>Reflection Front</WavelengthDataDirection>%s<ScatteringData>\n%s",
            tree ? "TensorTree3" : "Columns", basis, tree ? "{" : "");
    for (int i = 0; i < (tree ? 4096 : 41 * 41); i++) fprintf(f, "%.6f%s", 0.1 + ff_test_uniform(), tree ? " " : ",\n");
    fprintf(f, "%s</ScatteringData></WavelengthDataBlock></WavelengthData></Layer></Optical></WindowElement>\n", tree ? "}" : "");
    fclose(f);
    ff_read_options_init(&o);
    if (ff_table_read_with_into(path, &o, &t, &err)) {
        printf("%s\n", err.message);
        exit(1);
    }
    return t;
}

/* ---- with holes, and with what is no number in them -------------------------------------------- */

static int is_hole(size_t i)
{
    return i * 2654435761u % 97 < 9;
}

static ff_table copy(const ff_table *t, int marked)
{
    static const double none[3] = {INFINITY, -INFINITY, NAN};
    ff_table c;
    if (ff_table_copy_into(t, &c, NULL)) exit(1);
    for (size_t i = 0; i < c.n; i++) {
        if (!is_hole(i)) continue;
        if (marked)
            c.valid[i] = 0;
        else
            c.value[(size_t)(i % c.n_channels) * c.n + i] = none[i % 3];
    }
    return c;
}

static void check_same(const char *what, const ff_table *a, const ff_table *b)
{
    size_t differ = 0, no_numbers = 0;
    if (!FF_CHECK(a->n == b->n, "%s: %zu samples, %zu", what, a->n, b->n)) return;
    for (size_t i = 0; i < a->n; i++) {
        if (a->valid[i] != b->valid[i]) differ++;
        for (size_t c = 0; c < a->n_channels && a->valid[i] && b->valid[i]; c++) {
            const double x = a->value[c * a->n + i], y = b->value[c * b->n + i];
            if (!isfinite(y)) no_numbers++;
            if (x != y) differ++; /* to the bit */
        }
    }
    FF_CHECK(!differ && !no_numbers, "%s: %zu differ, %zu are no numbers", what, differ, no_numbers);
}

static void check_format(const char *what, const ff_table *marked, const ff_table *t, const char *format)
{
    char name[96];
    ff_table a, b;
    ff_resample_report ra, rb;
    ff_resample_options o;
    ff_error err = {0};
    ff_resample_options_init(&o);
    snprintf(name, sizeof name, "%s, to %s", what, format);
    const ff_status sa = ff_resample_into(marked, ff_format_find(format), &o, &a, &ra, &err),
                    sb = ff_resample_into(t, ff_format_find(format), &o, &b, &rb, &err);
    if (!FF_CHECK(sa == sb, "%s: %s", name, err.message)) return;
    if (sa) return;
    check_same(name, &a, &b);
    FF_CHECK(ra.beyond == rb.beyond && ra.invalid == rb.invalid && ra.near.n == rb.near.n && ra.raised == rb.raised,
             "%s: %zu and %zu beyond, %zu and %zu predicted", name, ra.beyond, rb.beyond, ra.near.n, rb.near.n);
    FF_CHECK((isnan(ra.lost) && isnan(rb.lost)) || fabs(ra.lost - rb.lost) < 1e-12, "%s: lost %g and %g", name, ra.lost, rb.lost);
    FF_CHECK((isnan(ra.near.most) && isnan(rb.near.most)) || fabs(ra.near.most - rb.near.most) < 1e-12, "%s: error %g and %g", name,
             ra.near.most, rb.near.most);
    ff_table_clear(&a);
    ff_table_clear(&b);
}

static void check_survey(const char *what, const ff_table *marked, const ff_table *t)
{
    ff_survey a, b;
    if (!FF_CHECK(!ff_survey_init(marked, &a, NULL) && !ff_survey_init(t, &b, NULL), "%s: no survey", what)) return;
    FF_CHECK(a.n_reflectances == b.n_reflectances, "%s: %zu and %zu reflectances", what, a.n_reflectances, b.n_reflectances);
    for (size_t k = 0; k < a.n_reflectances * t->n_channels; k++)
        FF_CHECK((isnan(a.albedo[k]) && isnan(b.albedo[k])) || fabs(a.albedo[k] - b.albedo[k]) < 1e-12, "%s: reflectance %g and %g",
                 what, a.albedo[k], b.albedo[k]);
    ff_survey_clear(&a);
    ff_survey_clear(&b);
}

/* Interpolated by the method that begins with these words. */
static void check_table(const char *what, ff_table *t, int scattered, const char *method)
{
    ff_table marked = copy(t, 1), holes = copy(t, 0);
    ff_interpolant *p = NULL, *q = NULL;
    if (ff_interpolant_new(&marked, scattered, &p, NULL) || ff_interpolant_new(&holes, scattered, &q, NULL)) exit(1);
    FF_CHECK(strncmp(ff_interpolant_method(p), method, strlen(method)) == 0, "%s: %s", what, ff_interpolant_method(p));
    for (int k = 0; k < 4000; k++) {
        double w[6], f[2][64];
        unsigned char found[2];
        for (int j = 0; j < 2; j++) {
            const double theta = 1.5 * ff_test_uniform(), phi = 360 * FIT_DEGREE * ff_test_uniform();
            w[3 * j] = sin(theta) * cos(phi), w[3 * j + 1] = sin(theta) * sin(phi), w[3 * j + 2] = cos(theta);
        }
        const size_t i = (size_t)k * t->n / 4000;
        double *const here[6] = {w, w + 1, w + 2, w + 3, w + 4, w + 5};
        if (k % 2) ff_table_directions(t, i, 1, here); /* also at the holes themselves */
        const double *const planes[6] = {w, w + 1, w + 2, w + 3, w + 4, w + 5};
        ff_interpolant_eval_reciprocal(p, planes, 1, f[0], found);
        ff_interpolant_eval_reciprocal(q, planes, 1, f[1], found + 1);
        FF_CHECK(found[0] == found[1], "%s: found %d and %d", what, found[0], found[1]);
        for (size_t c = 0; c < t->n_channels; c++)
            FF_CHECK(isfinite(f[1][c]) && fabs(f[0][c] - f[1][c]) <= 1e-12 * f[0][c], "%s: %g and %g", what, f[0][c], f[1][c]);
    }
    ff_interpolant_free(p);
    ff_interpolant_free(q);
    static const char *const formats[] = {"zemax", "csv", "rgl"}; /* not merl, which takes minutes */
    const size_t n = t->grid ? 1 : sizeof formats / sizeof *formats;
    for (size_t k = 0; k < n && !scattered; k++) check_format(what, &marked, &holes, formats[k]);
    check_survey(what, &marked, &holes);
    ff_table_clear(&marked);
    ff_table_clear(&holes);
    ff_table_clear(t);
}

static void in_slices(void)
{
    ff_table t = simulated("goniometer:10", 3);
    check_table("goniometer", &t, 0, "local regression over half vectors");
    t = simulated("goniometer:10", 3);
    check_table("goniometer, as scattered", &t, 1, "local regression");
}

static void scattered(void)
{
    ff_table t = simulated("scattered:2000:0.3", 1);
    check_table("scattered", &t, 0, "local regression over the nearest");
}

static void along_axes(void)
{
    ff_table t = on_axes_of("zemax");
    check_table("about the specular direction", &t, 0, "linear along the axes");
    t = simulated("merl", 3);
    check_table("MERL", &t, 0, "linear along the axes");
}

static void over_cells(void)
{
    ff_table t = cells(0);
    check_table("patches", &t, 0, "constant over each cell");
    t = cells(1);
    check_table("tree", &t, 0, "constant over each cell");
}

FF_TEST_MAIN(FF_TEST(in_slices), FF_TEST(scattered), FF_TEST(along_axes), FF_TEST(over_cells))
