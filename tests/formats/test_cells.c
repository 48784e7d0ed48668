/* Values that are constant over cells: Klems' patches and tensor trees, made here with known reflectances; what interpolation,
 * `info` and `resample` make of them; measured files against sums over patches by another program. */
#include "square.h"
#include "check_table.h"
#include "data_formats/analysis/survey_struct.h"
#include "data_formats/interpolation/ff_interpolate.h"
#include "data_formats/interpolation/internal_reflectance.h"
#include "data_formats/interpolation/resample_struct.h"
#include <unistd.h>

static const double pi = 3.14159265358979323846;

enum { PATCHES = 41 };

/* ---- files ----------------------------------------------------------------------------------- */

static FILE *begin(const char *path, const char *structure, const char *face, int tree)
{
    FILE *f = fopen(path, "w");
    if (!f) exit(1);
    fprintf(f,
            "<?xml version=\"1.0\"?>\n<WindowElement><Optical><Layer><DataDefinition><IncidentDataStructure>%s"
            "</IncidentDataStructure></DataDefinition>\n<WavelengthData><Wavelength>Visible</Wavelength><WavelengthDataBlock>"
            "<WavelengthDataDirection>Reflection %s</WavelengthDataDirection>",
            structure, face);
    if (tree)
        fprintf(f, "<AngleBasis>LBNL/Shirley-Chiu</AngleBasis>");
    else
        fprintf(f, "<ColumnAngleBasis>LBNL/Klems Quarter</ColumnAngleBasis><RowAngleBasis>LBNL/Klems Quarter</RowAngleBasis>");
    fprintf(f, "<ScatteringData>\n");
    return f;
}

static void end(FILE *f)
{
    fprintf(f, "\n</ScatteringData></WavelengthDataBlock></WavelengthData></Layer></Optical></WindowElement>\n");
    fclose(f);
}

static int reads(const char *path, const char *part, ff_table *t)
{
    ff_error err = {0};
    ff_read_options o;
    ff_read_options_init(&o);
    o.part = part;
    return FF_CHECK(ff_table_read_with_into(path, &o, t, &err) == FF_OK, "%s: %s", path, err.message);
}

/* ---- patches, computed independently --------------------------------------------------------- */

static const double upper[] = {0, 9, 27, 45, 63, 90}; /* degrees */
static const int around[] = {1, 8, 12, 12, 8};

/* Patch of a direction of the sheet. */
static int patch_of(double theta, double phi)
{
    int first = 0, ring = 0;
    while (theta * 180 / pi >= upper[ring + 1]) first += around[ring++];
    return first + (int)lround(phi / (2 * pi) * around[ring] + 4 * around[ring]) % around[ring];
}

/* Projected solid angle. */
static double projected(int patch)
{
    int ring = 0;
    for (; patch >= around[ring]; ring++) patch -= around[ring];
    return pi / around[ring] * (pow(sin(upper[ring + 1] * pi / 180), 2) - pow(sin(upper[ring] * pi / 180), 2));
}

static void unit(double theta, double phi, double w[3])
{
    w[0] = sin(theta) * cos(phi), w[1] = sin(theta) * sin(phi), w[2] = cos(theta);
}

/* f at a pair, as interpolated. */
static double at(const ff_interpolant *p, const double wi[3], const double wo[3], unsigned char *found)
{
    double value = NAN;
    const double *const w[6] = {wi, wi + 1, wi + 2, wo, wo + 1, wo + 2};
    ff_interpolant_eval(p, w, 1, &value, found);
    return value;
}

static double value[PATCHES][PATCHES]; /* of exit, incident */

/* Random values, and a peak in the mirror direction. */
static const char *make_matrix(int rows, int front)
{
    const char *path = ff_test_path("cells.xml");
    FILE *f = begin(path, rows ? "Rows" : "Columns", front ? "Front" : "Back", 0);
    for (int o = 0; o < PATCHES; o++)
        for (int i = 0; i < PATCHES; i++) value[o][i] = round(1e6 * (ff_test_uniform() + 5.0 * (i == o))) / 1e6;
    for (int a = 0; a < PATCHES; a++)
        for (int b = 0; b < PATCHES; b++) fprintf(f, "%.6f,\n", rows ? value[b][a] : value[a][b]);
    end(f);
    return path;
}

static void values_of_patches(const ff_table *t, int front)
{
    ff_interpolant *p = NULL;
    if (!FF_CHECK(ff_interpolant_new(t, 0, &p, NULL) == FF_OK, "no interpolant")) return;
    for (int k = 0; k < 3000; k++) {
        /* where the light goes and where it is seen, in the sheet's x and y */
        const double a = 1.57 * ff_test_uniform(), b = 2 * pi * ff_test_uniform(), c = 1.57 * ff_test_uniform(),
                     d = 2 * pi * ff_test_uniform(), x = front ? -1 : 1;
        double vi[3], vo[3];
        unsigned char found;
        unit(a, b, vi), unit(c, d, vo);
        const double wi[3] = {-x * vi[0], -vi[1], vi[2]}, wo[3] = {x * vo[0], vo[1], vo[2]};
        const double f = at(p, wi, wo, &found), expected = value[patch_of(c, d)][patch_of(a, b)];
        if (!FF_CHECK(f == expected && found == FF_FOUND_BETWEEN, "pair %d: %g (%d), expected %g", k, f, found, expected)) break;
    }
    ff_interpolant_free(p);
}

static void reflectances_of_patches(const ff_table *t)
{
    ff_survey s;
    if (!FF_CHECK(ff_survey_init(t, &s, NULL) == FF_OK, "no survey")) return;
    FF_CHECK(s.n_reflectances == 5, "%zu incidences", s.n_reflectances);
    for (int ring = 0, i = 0; ring < 5; ring++) {
        double mean = 0, least = INFINITY, most = -INFINITY;
        for (int k = 0; k < around[ring]; k++, i++) {
            double sum = 0;
            for (int o = 0; o < PATCHES; o++) sum += value[o][i] * projected(o);
            mean += sum / around[ring], least = fmin(least, sum), most = fmax(most, sum);
        }
        const double theta = ring ? (upper[ring] + upper[ring + 1]) / 2 : 0;
        FF_CHECK(s.reflectance[ring].theta_i == theta && fabs(s.reflectance[ring].covered - 1) < 1e-12, "ring %d at %g, covered %g",
                 ring, s.reflectance[ring].theta_i, s.reflectance[ring].covered);
        FF_CHECK(fabs(s.albedo[ring] - mean) < 1e-12 * mean, "ring %d: %.15g, expected %.15g", ring, s.albedo[ring], mean);
        FF_CHECK(s.azimuths_of[ring] == (size_t)around[ring] && isnan(s.reflectance[ring].phi_i) == (ring > 0), "ring %d: %zu",
                 ring, s.azimuths_of[ring]);
        FF_CHECK(fabs(s.over_azimuths[ring][0] - least) < 1e-12 && fabs(s.over_azimuths[ring][1] - most) < 1e-12,
                 "ring %d: %g to %g, expected %g to %g", ring, s.over_azimuths[ring][0], s.over_azimuths[ring][1], least, most);
    }
    ff_survey_clear(&s);
}

static void patches(void)
{
    for (int k = 0; k < 4; k++) {
        ff_table t, copy;
        if (!reads(make_matrix(k % 2, k / 2), NULL, &t)) continue;
        values_of_patches(&t, k / 2);
        reflectances_of_patches(&t);
        FF_CHECK(ff_table_copy_into(&t, &copy, NULL) == FF_OK, "no copy");
        ff_table_clear(&t);
        values_of_patches(&copy, k / 2); /* the copy has them still */
        ff_table_clear(&copy);
    }
}

/* ---- trees ----------------------------------------------------------------------------------- */

/* Cells of a tree that is divided at random, their values, and the file's text. */
typedef struct leaf {
    double corner[4], w, f;
} leaf;

typedef struct tree {
    FILE *file;
    int rank, n;
    leaf at[20000];
} tree;

static void grow(tree *t, const double *corner, double w, int levels)
{
    double c[4] = {0};
    const int divide = levels > 0 && (w == 1 || ff_test_random() % 3);
    fprintf(t->file, "{ ");
    for (int b = 0; b < 1 << t->rank && divide; b++) {
        for (int j = 0; j < t->rank; j++) c[j] = corner[j] + (b >> j & 1) * w / 2;
        grow(t, c, w / 2, levels - 1);
    }
    if (!divide) {
        leaf *l = &t->at[t->n++];
        *l = (leaf){.w = w, .f = round(1e6 * (0.1 + pow(ff_test_uniform(), 8) * 20)) / 1e6};
        memcpy(l->corner, corner, (size_t)t->rank * sizeof *corner);
        fprintf(t->file, "%.6f", l->f);
    }
    fprintf(t->file, " }");
}

/* The point of the cube of a pair of directions of the table. */
static void point_of(const tree *t, int front, const double wi[3], const double wo[3], double c[4])
{
    const double x = front ? -1 : 1, s = hypot(wi[0], wi[1]);
    if (t->rank == 4) {
        square_of(-x * wi[0], -wi[1], &c[0], &c[1]);
        square_of(x * wo[0], wo[1], &c[2], &c[3]);
        return;
    }
    /* turned until the light comes from -x of the sheet, that is from +x of a front and -x of a back */
    const double turn = (front ? 0 : pi) - (s > 0 ? atan2(wi[1], wi[0]) : 0);
    c[0] = 0.5 - 0.5 * s;
    square_of(x * (cos(turn) * wo[0] - sin(turn) * wo[1]), sin(turn) * wo[0] + cos(turn) * wo[1], &c[1], &c[2]);
}

static const leaf *leaf_at(const tree *t, const double c[4])
{
    for (int i = 0; i < t->n; i++) {
        int inside = 1;
        for (int k = 0; k < t->rank; k++) inside &= c[k] >= t->at[i].corner[k] && c[k] < t->at[i].corner[k] + t->at[i].w;
        if (inside) return &t->at[i];
    }
    return NULL;
}

static void values_of_leaves(const tree *t, const ff_table *table, int front)
{
    ff_interpolant *p = NULL;
    if (!FF_CHECK(ff_interpolant_new(table, 0, &p, NULL) == FF_OK, "no interpolant")) return;
    for (int k = 0; k < 1000; k++) {
        double wi[3], wo[3], c[4] = {0};
        unsigned char found;
        unit(1.57 * ff_test_uniform(), 2 * pi * ff_test_uniform(), wi);
        unit(1.57 * ff_test_uniform(), 2 * pi * ff_test_uniform(), wo);
        point_of(t, front, wi, wo, c);
        const leaf *l = leaf_at(t, c);
        const double f = at(p, wi, wo, &found);
        if (!FF_CHECK(l && f == l->f, "pair %d: %g, expected %g", k, f, l ? l->f : NAN)) break;
    }
    ff_interpolant_free(p);
}

/* The integral of the tree over the hemisphere, in polar angles: another way than that of the program. */
static double integral(const tree *t, int front, double theta_i, double phi_i)
{
    const int thetas = t->rank == 3 ? 240 : 60, phis = 2 * thetas;
    double wi[3], wo[3], c[4] = {0}, sum = 0;
    unit(theta_i, phi_i, wi);
    for (int a = 0; a < thetas; a++)
        for (int b = 0; b < phis; b++) {
            const double z2 = (a + 0.5) / thetas; /* of equal projected solid angle */
            unit(acos(sqrt(z2)), 2 * pi * (b + 0.5) / phis, wo);
            point_of(t, front, wi, wo, c);
            const leaf *l = leaf_at(t, c);
            sum += l ? l->f * pi / (thetas * phis) : 0;
        }
    return sum;
}

static void reflectances_of_leaves(const tree *t, const ff_table *table, int front)
{
    ff_survey s;
    if (!FF_CHECK(ff_survey_init(table, &s, NULL) == FF_OK, "no survey")) return;
    FF_CHECK(s.n_reflectances == 7, "%zu incidences", s.n_reflectances);
    for (size_t k = 0; k < s.n_reflectances; k += 3) {
        const size_t n = s.azimuths_of[k];
        const double theta = s.reflectance[k].theta_i * pi / 180;
        double expected = 0;
        FF_CHECK(n == (t->rank == 3 ? 1 : 24), "%zu azimuths", n);
        for (size_t j = 0; j < n; j++)
            expected += integral(t, front, theta, n == 1 ? 0 : 2 * pi * ((double)j + 0.5) / (double)n) / (double)n;
        FF_CHECK(fabs(s.albedo[k] - expected) < 0.01 * expected, "rank %d at %g degrees: %g, expected %g", t->rank,
                 s.reflectance[k].theta_i, s.albedo[k], expected);
    }
    ff_survey_clear(&s);
}

static void trees(void)
{
    static const double origin[4] = {0};
    tree *t = malloc(sizeof *t);
    if (!t) exit(1);
    for (int k = 0; k < 4; k++) {
        const int front = k / 2;
        const char *path = ff_test_path("tree.xml");
        ff_table table;
        t->rank = 3 + k % 2, t->n = 0;
        t->file = begin(path, t->rank == 3 ? "TensorTree3" : "TensorTree4", front ? "Front" : "Back", 1);
        grow(t, origin, 1, t->rank == 3 ? 4 : 2);
        end(t->file);
        if (!reads(path, NULL, &table)) continue;
        values_of_leaves(t, &table, front);
        reflectances_of_leaves(t, &table, front);
        ff_table_clear(&table);
    }
    free(t);
}

/* A white of .3 / pi with one cell of exit, of 1/32 the width, that is 40: integrals in closed form. */
static void peak_of_a_tree(void)
{
    const char *path = ff_test_path("peak.xml");
    FILE *f = begin(path, "TensorTree3", "Back", 1);
    for (int b = 0; b < 1 << 15; b++) fprintf(f, "%s%.12g ", b ? "" : "{", b % 1024 == 517 ? 40 : 0.3 / pi);
    fprintf(f, "}");
    end(f);
    ff_table t;
    ff_survey s;
    if (!reads(path, NULL, &t)) return;
    if (FF_CHECK(ff_survey_init(&t, &s, NULL) == FF_OK, "no survey")) {
        const double expected = 0.3 + (40 - 0.3 / pi) * pi / 1024;
        for (size_t k = 0; k < s.n_reflectances; k++)
            FF_CHECK(fabs(s.albedo[k] - expected) < 1e-9, "at %g degrees: %.12g, expected %.12g", s.reflectance[k].theta_i,
                     s.albedo[k], expected);
        ff_survey_clear(&s);
    }
    ff_table_clear(&t);
}

/* ---- conversion ------------------------------------------------------------------------------ */

/* The energy of the same patches in a format, as the survey of the result has it. */
static void check_energy(const ff_table *t, const char *format, const char *grid, double most)
{
    ff_resample_options o;
    ff_resample_report r;
    ff_table made;
    ff_error err = {0};
    ff_resample_options_init(&o);
    o.grid = grid;
    if (!FF_CHECK(ff_resample_into(t, ff_format_find(format), &o, &made, &r, &err) == FF_OK, "%s: %s", format, err.message)) return;
    FF_CHECK(r.incidences >= 3, "%s: %zu incidences compared", format, r.incidences);
    FF_CHECK(fabs(r.lost_most) >= fabs(r.lost) && fabs(r.lost_most) < most, "%s: %g lost, %g at %g degrees", format, r.lost,
             r.lost_most, r.lost_at);
    printf("  %s: %.2g of the energy lost, %.2g at %g degrees\n", format, r.lost, r.lost_most, r.lost_at);
    ff_table_clear(&made);
}

/* A mirror peak in every patch, the same with light and detector exchanged, and not. */
static void energy_of_patches(void)
{
    ff_table t;
    const char *path = ff_test_path("white.xml");
    FILE *f = begin(path, "Columns", "Back", 0);
    for (int k = 0; k < PATCHES * PATCHES; k++) fprintf(f, "%g ", k % (PATCHES + 1) ? 0.01 : 5.0);
    end(f);
    if (!reads(path, NULL, &t)) return;
    if (ff_test_drawn(3, "patches to merl")) check_energy(&t, "merl", NULL, 0.02); /* takes as long as all others */
    check_energy(&t, "zemax", NULL, 0.02);
    check_energy(&t, "rgl", NULL, 0.02);
    ff_table_clear(&t);
    if (!reads(make_matrix(0, 0), NULL, &t)) return;
    check_energy(&t, "zemax", NULL, 0.02);
    check_energy(&t, "rgl", NULL, 0.02);
    check_energy(&t, "exr", "incident-exit:5x24x31x48", 0.25); /* read by regression, which does not follow edges */
    ff_table_clear(&t);
}

/* Trees with cells of a quarter to a sixteenth, at incidences and azimuths that the new grid has. */
static void energy_of_leaves(void)
{
    static const double origin[4] = {0};
    tree *t = malloc(sizeof *t);
    if (!t) exit(1);
    for (int rank = 3; rank <= 4; rank++) {
        const char *path = ff_test_path("tree.xml");
        ff_table table;
        t->rank = rank, t->n = 0;
        t->file = begin(path, rank == 3 ? "TensorTree3" : "TensorTree4", "Back", 1);
        grow(t, origin, 1, rank == 3 ? 4 : 2);
        end(t->file);
        if (!reads(path, NULL, &table)) continue;
        check_energy(&table, "zemax", "rotation:82.5/172.5/262.5/352.5,incidence:5/15/25/45/60/75/82.5,radial:5", 0.02);
        check_energy(&table, "rgl", NULL, 0.02); /* its incidences lie on borders between cells: both sides count */
        ff_table_clear(&table);
    }
    free(t);
}

static void energy_as_it_is(void)
{
    ff_table t;
    /* a file of samples forgets how far each reaches, and says so */
    ff_table made;
    ff_resample_report r;
    ff_resample_options o;
    ff_resample_options_init(&o);
    if (!reads(make_matrix(0, 0), NULL, &t)) return;
    if (FF_CHECK(ff_resample_into(&t, ff_format_find("csv"), &o, &made, &r, NULL) == FF_OK, "csv")) {
        FF_CHECK(r.as_it_is && r.incidences == 5 && fabs(r.lost_most) > 0.05 && strstr(made.note, "means over cells"),
                 "csv: %zu incidences, %g lost, %s", r.incidences, r.lost_most, made.note);
        ff_table_clear(&made);
    }
    ff_table_clear(&t);
}

/* A loss that is known: every second value of the result taken away. */
static void a_loss_is_seen(void)
{
    ff_table t, made;
    ff_resample_report r;
    ff_resample_options o;
    ff_energy e;
    ff_interpolant *p = NULL;
    ff_resample_options_init(&o);
    if (!reads(make_matrix(0, 0), NULL, &t)) return;
    if (FF_CHECK(ff_resample_into(&t, ff_format_find("zemax"), &o, &made, &r, NULL) == FF_OK, "zemax")) {
        for (size_t i = 0; i < made.n * made.n_channels; i++) made.value[i] *= 0.9;
        FF_CHECK(ff_interpolant_new(&t, 0, &p, NULL) == FF_OK && ff_energy_compare(&t, p, &made, &e, NULL) == FF_OK, "no energy");
        FF_CHECK(fabs((1 - e.lost) - 0.9 * (1 - r.lost)) < 1e-9, "lost %g, before %g", e.lost, r.lost);
        ff_interpolant_free(p);
        ff_table_clear(&made);
    }
    ff_table_clear(&t);
}

/* ---- measured files -------------------------------------------------------------------------- */

/* Sums over patches by Radiance's own library, at 0 and 82.5 degrees. */
static void measured(void)
{
    static const struct {
        const char *name, *part;
        double normal, grazing;
    } file[] = {{"diffuse_glass.xml", "reflection-front", 0.1976, 0.7662},
                {"diffuse_glass.xml", "reflection-back", 0.1981, 0.7042},
                {"2011-SA1.XML", "reflection-front", 0.4825, 0.6414},
                {"2011-SA1.XML", "reflection-back", 0.5600, 0.7102},
                {"frads_klems_aniso_high.xml", "reflection-front", 0.4006, 0.5990},
                {"frads_klems_aniso_high.xml", "reflection-back", 0.2178, 0.3317}};
    const char *set = getenv("FACETFIT_DATA");
    for (size_t k = 0; k < sizeof file / sizeof file[0]; k++) {
        char path[700];
        ff_table t;
        ff_survey s;
        snprintf(path, sizeof path, "%s/klems/%s", set ? set : FF_SOURCE_DIR "/../shared/data", file[k].name);
        /* measured files are not part of the project: matrices and trees that the cases above write stand for them */
        if (access(path, R_OK) != 0) FF_SKIP("there is no %s", path);
        if (!reads(path, file[k].part, &t)) continue;
        if (FF_CHECK(ff_survey_init(&t, &s, NULL) == FF_OK && s.n_reflectances == 8, "%s: no survey", path)) {
            FF_CHECK(fabs(s.albedo[0] / file[k].normal - 1) < 0.001 && fabs(s.albedo[7] / file[k].grazing - 1) < 0.001,
                     "%s, %s: %.5g and %.5g, expected %g and %g", path, file[k].part, s.albedo[0], s.albedo[7], file[k].normal,
                     file[k].grazing);
            ff_survey_clear(&s);
        }
        ff_table_clear(&t);
    }
}

FF_TEST_MAIN(FF_TEST(patches), FF_TEST(trees), FF_TEST(peak_of_a_tree), FF_TEST(energy_of_patches), FF_TEST(energy_of_leaves),
             FF_TEST(energy_as_it_is), FF_TEST(a_loss_is_seen), FF_TEST(measured))
