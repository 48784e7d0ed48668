/* What the format tests share: tables compared, files that must be refused, pipes. */
#ifndef FF_FORMATS_CHECK_TABLE_H
#define FF_FORMATS_CHECK_TABLE_H
#include "ff_test.h"
#include "data_formats/table/table_struct.h"
#include <dirent.h>
#include <sys/stat.h>

/* Number of names in the tests' directory that contain ".part-": unfinished files. */
__attribute__((unused)) static int check_leftovers(void)
{
    int n = 0;
    DIR *d = opendir(ff_test_dir);
    for (struct dirent *e; d && (e = readdir(d));) n += strstr(e->d_name, ".part-") != NULL;
    if (d) closedir(d);
    return n;
}

/* Expects that reading fails with this code, leaves the table alone, names the path and line (0 = none), and that the message has
 * each of the words (a NULL-terminated list: what was found, what was expected). */
__attribute__((unused)) static void check_fails(const char *label, const char *path, const char *format, ff_status code, long line,
                                                const char *const *words)
{
    ff_table t;
    memset(&t, 0x5A, sizeof t);
    ff_error err = {0};
    char all[FF_ERROR_PATH + FF_ERROR_MESSAGE + 64];
    ff_status status = ff_table_read_into(path, format, &t, &err);
    ff_error_format(&err, all, sizeof all);
    FF_CHECK(status == code && err.code == code, "%s: status %d (%s), expected %d: %s", label, status, ff_status_str(status), code,
             all);
    if (status == FF_OK) {
        ff_table_clear(&t);
        return;
    }
    unsigned char first;
    memcpy(&first, &t, 1);
    FF_CHECK(first == 0x5A, "%s: the table was touched on failure", label);
    FF_CHECK(strcmp(err.path, path) == 0, "%s: path '%s'", label, err.path);
    FF_CHECK(err.line == line, "%s: line %ld, expected %ld: %s", label, err.line, line, all);
    for (; *words; words++) FF_CHECK(strstr(all, *words), "%s: no '%s' in: %s", label, *words, all);
}
#define WORDS(...) ((const char *const[]){__VA_ARGS__, NULL})

/* The n bytes through a pipe, which has no size to look at first: whole, ended after `cut` bytes, and with a byte too many. */
__attribute__((unused)) static void check_pipe(const char *format, const unsigned char *bytes, size_t n, size_t cut)
{
    char ended[40];
    snprintf(ended, sizeof ended, "head -c %zu", cut);
    const struct {
        const char *filter;
        ff_status status;
        int64_t byte;
    } cases[] = {{"cat", FF_OK, -1}, {ended, FF_ERR_READ, (int64_t)cut}, {"cat - /dev/null; echo", FF_ERR_FORMAT, (int64_t)n}};
    const char *path = ff_test_path("whole"), *fifo = ff_test_path("fifo");
    ff_test_write(path, bytes, n);
    for (size_t k = 0; k < 3; k++) {
        char command[800];
        snprintf(command, sizeof command, "rm -f '%s'; mkfifo '%s'; (%s) < '%s' > '%s' &", fifo, fifo, cases[k].filter, path, fifo);
        if (system(command) != 0) exit(1);
        ff_table t;
        ff_error err = {0};
        ff_status status = ff_table_read_into(fifo, format, &t, &err);
        FF_CHECK(status == cases[k].status && (status == FF_OK || err.byte == cases[k].byte), "%s: %d at %lld %s", cases[k].filter,
                 status, (long long)err.byte, err.message);
        if (status == FF_OK) ff_table_clear(&t);
    }
}

/* Same numbers in both tables, bit for bit; values and sigmas as 1/sr, of valid samples. */
__attribute__((unused)) static int check_same_bits(const double *a, const double *b, size_t n)
{
    return memcmp(a, b, n * sizeof *a) == 0;
}
__attribute__((unused)) static void check_same_tables(const char *label, const ff_table *a, const ff_table *b)
{
    if (!FF_CHECK(a->n == b->n && a->n_channels == b->n_channels, "%s: %zu x %zu and %zu x %zu", label, a->n, a->n_channels, b->n,
                  b->n_channels))
        return;
    FF_CHECK(memcmp(a->valid, b->valid, a->n) == 0, "%s: validity", label);
    FF_CHECK(!a->sigma == !b->sigma, "%s: sigma", label);
    FF_CHECK(a->isotropic == b->isotropic, "%s: isotropic %d %d", label, a->isotropic, b->isotropic);
    FF_CHECK(a->n_invalid == b->n_invalid && a->n_negative == b->n_negative, "%s: counts", label);
    for (size_t c = 0; c < a->n_channels; c++) {
        FF_CHECK(strcmp(a->channels[c].name, b->channels[c].name) == 0, "%s: channel '%s' '%s'", label, a->channels[c].name,
                 b->channels[c].name);
        for (size_t i = 0; i < a->n; i++) {
            double u, v;
            if (!a->valid[i]) continue;
            ff_table_values(a, c, i, 1, &u);
            ff_table_values(b, c, i, 1, &v);
            if (!FF_CHECK(check_same_bits(&u, &v, 1), "%s: sample %zu channel %zu: %.17g %.17g", label, i, c, u, v)) return;
            if (!a->sigma || !b->sigma) continue;
            ff_table_sigmas(a, c, i, 1, &u);
            ff_table_sigmas(b, c, i, 1, &v);
            if (!FF_CHECK(check_same_bits(&u, &v, 1), "%s: sigma %zu channel %zu: %.17g %.17g", label, i, c, u, v)) return;
        }
    }
}
__attribute__((unused)) static void check_same_angles(const char *label, const ff_table *a, const ff_table *b)
{
    FF_CHECK(a->radians_per_unit == b->radians_per_unit, "%s: unit", label);
    for (int k = 0; k < 4; k++) FF_CHECK(check_same_bits(a->angle[k], b->angle[k], a->n), "%s: angle %d", label, k);
}
#endif
