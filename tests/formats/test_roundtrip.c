/* Every measured file through every format that can be written: what is written is what is read again, to the bit where the format
 * says so and within its stated loss elsewhere, and writing that again gives the same bytes. Without measured data, one simulated
 * by hand, through all. Of measured files one format each is drawn (but MERL's), and all are tried with
 *   test_formats_roundtrip all
 * (the long tier; full-size grids of a million samples are made of every tenth file only). */
#include "check_table.h"
#include "data_formats/interpolation/resample_struct.h"
#include "data_formats/analysis/spectral_struct.h"

enum { PATH = 1024, FILES = 256, WRITERS = 32, DRAWN = 1 };

static int every_format; /* of every measured file, not DRAWN of them */
static long n_trips, n_exact;
static double worst_loss;

/* The valid samples, in their order. A format whose only mark for "not measured" is 0 loses measured zeros. */
static size_t *measured(const ff_table *t, int zero_is_lost, size_t *n)
{
    size_t *index = malloc(t->n * sizeof *index);
    if (!index) exit(1);
    *n = 0;
    for (size_t i = 0; i < t->n; i++) {
        int lost = zero_is_lost;
        for (size_t c = 0; c < t->n_channels; c++) lost &= t->value[c * t->n + i] == 0;
        if (t->valid[i] && !lost) index[(*n)++] = i;
    }
    return index;
}

/* Largest relative difference of values and standard deviations, 0 where all bits are the same; of directions, the absolute one. */
static void differences(const ff_table *a, const size_t *ia, const ff_table *b, const size_t *ib, size_t n, double *values,
                        double *directions)
{
    *values = *directions = 0;
    for (size_t k = 0; k < n; k++) {
        double x[6], y[6], u[2] = {0, 0}, v[2] = {0, 0};
        double *const px[6] = {x, x + 1, x + 2, x + 3, x + 4, x + 5}, *const py[6] = {y, y + 1, y + 2, y + 3, y + 4, y + 5};
        ff_table_directions(a, ia[k], 1, px);
        ff_table_directions(b, ib[k], 1, py);
        for (int j = 0; j < 6; j++) *directions = fmax(*directions, fabs(x[j] - y[j]));
        for (size_t c = 0; c < a->n_channels; c++) {
            ff_table_values(a, c, ia[k], 1, &u[0]);
            ff_table_values(b, c, ib[k], 1, &v[0]);
            if (a->sigma) ff_table_sigmas(a, c, ia[k], 1, &u[1]);
            if (b->sigma) ff_table_sigmas(b, c, ib[k], 1, &v[1]);
            for (int j = 0; j < 2; j++)
                if (!check_same_bits(&u[j], &v[j], 1)) *values = fmax(*values, fabs(u[j] - v[j]) / fmax(fabs(u[j]), 1e-30));
        }
    }
}

static void compare(const char *label, const ff_format *f, const ff_table *a, const ff_table *b)
{
    size_t na, nb;
    const int zero_is_lost = strcmp(f->name, "zemax") == 0 || strcmp(f->name, "lighttools") == 0;
    size_t *ia = measured(a, zero_is_lost, &na), *ib = measured(b, 0, &nb);
    double values = 0, directions = 0;
    if (FF_CHECK(na == nb && a->n_channels == b->n_channels, "%s: %zu x %zu measured, %zu x %zu read again", label, na,
                 a->n_channels, nb, b->n_channels)) {
        differences(a, ia, b, ib, na, &values, &directions);
        FF_CHECK(directions < 1e-12, "%s: directions differ by %g", label, directions);
        if (f->holds & FF_HOLDS_DOUBLE) {
            FF_CHECK(values == 0, "%s: values differ by %g", label, values);
            n_exact++;
        } else {
            FF_CHECK(values <= 6e-8, "%s: values differ by %g, more than '%s'", label, values, f->precision);
            worst_loss = fmax(worst_loss, values);
        }
    }
    FF_CHECK(!(f->holds & FF_HOLDS_SIGMA) || !a->sigma == !b->sigma, "%s: standard deviations", label);
    FF_CHECK(a->isotropic == b->isotropic || strcmp(f->name, "utia") == 0 || strcmp(f->name, "merl") == 0 || f->layout == NULL,
             "%s: isotropic %d, read again %d", label, a->isotropic, b->isotropic);
    for (size_t c = 0; c < a->n_channels && (f->holds & FF_HOLDS_NAMES) && a->n_channels == b->n_channels; c++)
        FF_CHECK(strcmp(a->channels[c].name, b->channels[c].name) == 0, "%s: channel '%s', read again '%s'", label,
                 a->channels[c].name, b->channels[c].name);
    for (size_t c = 0; c < a->n_channels && (f->holds & FF_HOLDS_NM) && a->n_channels == b->n_channels; c++)
        FF_CHECK(!isfinite(a->channels[c].wavelength_nm) || a->channels[c].wavelength_nm == b->channels[c].wavelength_nm,
                 "%s: %g nm, read again %g", label, a->channels[c].wavelength_nm, b->channels[c].wavelength_nm);
    free(ia);
    free(ib);
}

static int same_bytes(const char *one, const char *other)
{
    size_t n, m;
    char *a = ff_test_slurp(one, &n), *b = ff_test_slurp(other, &m);
    const int same = n == m && memcmp(a, b, n) == 0;
    free(a);
    free(b);
    return same;
}

/* Values that are stored times a factor, and scaled again on reading, differ in their last bit. */
static int is_scaled(const ff_format *f)
{
    return f->precision && strncmp(f->precision, "scaled", 6) == 0;
}

/* Formats whose samples are not those of the table, in its order: window keeps means over patches, fred and openmaterial sort, and
 * leave out what lies below the horizon. Their own tests write and read them. */
static int keeps_samples(const ff_format *f)
{
    return strcmp(f->name, "window") != 0 && strcmp(f->name, "fred") != 0 && strcmp(f->name, "openmaterial") != 0;
}

/* Writes `made`, reads it, writes that, and compares. */
static void there_and_back(const char *label, const ff_format *f, const ff_table *made)
{
    char first[200], second[200];
    ff_table again;
    ff_error err = {0};
    snprintf(first, sizeof first, "%s", ff_test_path("first"));
    snprintf(second, sizeof second, "%s", ff_test_path("second"));
    if (!FF_CHECK(f->write(first, made, NULL, &err) == FF_OK, "%s: %s", label, err.message)) return;
    if (!FF_CHECK(ff_table_read_into(first, f->name, &again, &err) == FF_OK, "%s: %s", label, err.message)) return;
    compare(label, f, made, &again);
    if (FF_CHECK(f->write(second, &again, NULL, &err) == FF_OK, "%s, again: %s", label, err.message))
        FF_CHECK(is_scaled(f) || same_bytes(first, second), "%s: written again, the file is another", label);
    n_trips++;
    ff_table_clear(&again);
}

static void trip(const char *name, const ff_table *t, const ff_format *f)
{
    char label[256];
    ff_resample_options o;
    ff_resample_report report;
    ff_table made, mean = {0};
    ff_error err = {0};
    ff_resample_options_init(&o);
    snprintf(label, sizeof label, "%s to %s", name, f->name);
    ff_status status = ff_resample_into(t, f, &o, &made, &report, &err);
    if (status == FF_ERR_UNSUPPORTED && t->n_channels > 1) { /* fewer channels are held, for which the message asks */
        FF_CHECK(err.message[0], "%s: refused without a word", label);
        status = ff_table_reduce_into(t, "mean", &mean, &err);
        if (status == FF_OK) status = ff_resample_into(&mean, f, &o, &made, &report, &err);
    }
    if (status == FF_ERR_DATA) { /* one incidence, where the format has others */
        FF_CHECK(strstr(err.message, "extrapolated") != NULL, "%s: %s", label, err.message);
        o.beyond = 1;
        status = ff_resample_into(t, f, &o, &made, &report, &err);
    }
    if (FF_CHECK(status == FF_OK, "%s: %s", label, err.message)) {
        there_and_back(label, f, &made);
        ff_table_clear(&made);
    }
    ff_table_clear(&mean);
}

/* The formats that can be written; MERL's million and a half of samples take seconds. */
static size_t writers(int merl, const ff_format *writer[WRITERS])
{
    size_t n = 0;
    for (size_t k = 0; k < ff_format_count() && n < WRITERS; k++) {
        const ff_format *f = ff_format_at(k);
        if (f->write && keeps_samples(f) && (strcmp(f->name, "merl") != 0 || merl)) writer[n++] = f;
    }
    return n;
}

static void all_formats(const char *name, const ff_table *t, size_t number)
{
    const ff_format *writer[WRITERS];
    const size_t n = writers(number % 10 == 0, writer);
    for (size_t k = 0; k < n; k++) trip(name, t, writer[k]);
}

static void some_formats(const char *name, const ff_table *t)
{
    const ff_format *writer[WRITERS];
    const size_t n = writers(0, writer);
    uint64_t random = ff_test_stream("writers of %s", name);
    for (size_t k = 0; k < n && k < DRAWN; k++) { /* drawn without putting back */
        const size_t other = k + ff_test_next(&random) % (n - k);
        const ff_format *f = writer[other];
        writer[other] = writer[k];
        trip(name, t, f);
    }
}

/* ---- files ----------------------------------------------------------------------------------- */

static void real_file(const char *path, size_t *number)
{
    ff_read_options o;
    ff_table t;
    ff_error err = {0};
    const ff_format *f = NULL;
    if (ff_format_detect(path, &f, &err) != FF_OK) return; /* a description, a licence */
    const char *name = strrchr(path, '/') + 1;
    if (!every_format && !ff_test_drawn(3, "file %s", name)) return;
    ff_read_options_init(&o);
    if (strcmp(f->name, "pgii") == 0) o.scale = 1e-3;
    if (ff_table_read_with_into(path, &o, &t, &err) != FF_OK) return; /* a table of parameters */
    if (every_format)
        all_formats(name, &t, *number);
    else
        some_formats(name, &t);
    *number += 1;
    ff_table_clear(&t);
}

static int by_name(const void *a, const void *b)
{
    return strcmp(a, b);
}

static size_t real_files(const char *data)
{
    static char path[FILES][PATH];
    size_t n = 0, number = 0;
    DIR *d = opendir(data);
    for (struct dirent *e; d && (e = readdir(d));) {
        char folder[PATH / 2];
        snprintf(folder, sizeof folder, "%.300s/%.100s", data, e->d_name);
        DIR *inner = e->d_name[0] == '.' ? NULL : opendir(folder);
        for (struct dirent *g; inner && n < FILES && (g = readdir(inner));)
            if (g->d_name[0] != '.') snprintf(path[n++], PATH, "%.400s/%.255s", folder, g->d_name);
        if (inner) closedir(inner);
    }
    if (d) closedir(d);
    qsort(path, n, sizeof path[0], by_name);
    for (size_t k = 0; k < n; k++) real_file(path[k], &number);
    return number;
}

/* A glossy lobe on a goniometer's directions, two channels with wavelengths, standard deviations, a negative value and one that was
 * not measured. */
static void made_file(void)
{
    enum { INCIDENCES = 4, THETAS = 17, PHIS = 13, N = INCIDENCES * THETAS * PHIS };
    ff_table t;
    if (ff_table_init(N, 2, NULL, 1, 0, &t, NULL) != FF_OK) exit(1);
    t.radians_per_unit = 3.14159265358979323846 / 180;
    t.isotropic = 1;
    for (size_t i = 0; i < N; i++) {
        const double theta_i = 20.0 * (double)(i / (THETAS * PHIS)), theta_o = 5.0 * (double)(i / PHIS % THETAS),
                     phi = 15.0 * (double)(i % PHIS);
        const double apart =
            pow(theta_o * cos(phi / 57.29577951308232) + theta_i, 2) + pow(theta_o * sin(phi / 57.29577951308232), 2);
        t.angle[0][i] = theta_i;
        t.angle[2][i] = theta_o;
        t.angle[3][i] = phi;
        for (size_t c = 0; c < 2; c++) {
            t.value[c * N + i] = 0.1 + (1 + (double)c) * exp(-apart / 300) / 3;
            t.sigma[c * N + i] = 0.01 * t.value[c * N + i];
        }
    }
    for (size_t c = 0; c < 2; c++) {
        snprintf(t.channels[c].name, FF_CHANNEL_NAME, "%dnm", c ? 620 : 450);
        t.channels[c].wavelength_nm = c ? 620 : 450;
    }
    t.value[100] = -1e-3;
    t.valid[200] = 0;
    t.n_invalid = t.n_negative = 1;
    all_formats("made", &t, 0);
    ff_table_clear(&t);
}

static void measured_files(void)
{
    char usual[PATH];
    snprintf(usual, sizeof usual, "%s/../shared/data", FF_SOURCE_DIR);
    const char *data = getenv("FACETFIT_DATA") ? getenv("FACETFIT_DATA") : usual;
    const size_t files = real_files(data);
    if (files == 0) FF_SKIP("no measured files at %s: only the made one was tried", data);
    printf("%zu measured files, %ld round trips, %ld of them to the bit, the others within %.2g\n", files, n_trips, n_exact,
           worst_loss);
}

static const ff_test_case cases[] = {FF_TEST(made_file), FF_TEST(measured_files)};

int main(int argc, char **argv)
{
    every_format = argc == 2 && strcmp(argv[1], "all") == 0;
    return ff_test_main(cases, sizeof cases / sizeof *cases, every_format ? 1 : argc, argv);
}
