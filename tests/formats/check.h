/* Checks and files of the format tests. A test program counts its failures and returns check_result(). */
#ifndef FF_FORMATS_CHECK_H
#define FF_FORMATS_CHECK_H
#define _GNU_SOURCE
#include "data_formats/table/table_struct.h"
#include <dirent.h>
#include <math.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

enum { CHECK_SKIP = 77 };
static int check_failures, check_count;
static char check_dir[64];

#define CHECK(condition, ...) check_that((condition) != 0, __FILE__, __LINE__, #condition, __VA_ARGS__)

__attribute__((format(printf, 5, 6), unused)) static int check_that(int ok, const char *file, int line, const char *what,
                                                                    const char *fmt, ...)
{
    check_count++;
    if (ok) return 1;
    if (++check_failures > 40) return 0; /* the first ones tell enough */
    va_list args;
    va_start(args, fmt);
    fprintf(stderr, "%s:%d: %s: ", file, line, what);
    vfprintf(stderr, fmt, args);
    fprintf(stderr, "\n");
    va_end(args);
    return 0;
}

__attribute__((unused)) static void check_remove_dir(void)
{
    char command[96];
    snprintf(command, sizeof command, "rm -rf '%s'", check_dir);
    if (system(command) != 0) fprintf(stderr, "%s is left behind\n", check_dir);
}

/* Path of a file in a directory that goes away with the program; one of a few rotating buffers. */
__attribute__((unused)) static const char *check_path(const char *name)
{
    static char paths[8][160];
    static int next;
    if (!check_dir[0]) {
        strcpy(check_dir, "/tmp/facetfit-test-XXXXXX");
        if (!mkdtemp(check_dir)) {
            perror(check_dir);
            exit(1);
        }
        atexit(check_remove_dir);
    }
    char *path = paths[next++ % 8];
    snprintf(path, sizeof paths[0], "%s/%s", check_dir, name);
    return path;
}

__attribute__((unused)) static void check_write(const char *path, const void *bytes, size_t n)
{
    FILE *f = fopen(path, "wb");
    if (!f || fwrite(bytes, 1, n, f) != n || fclose(f) != 0) {
        perror(path);
        exit(1);
    }
}

/* The whole file, malloc'ed and '\0'-terminated. */
__attribute__((unused)) static char *check_slurp(const char *path, size_t *n)
{
    FILE *f = fopen(path, "rb");
    if (!f) {
        perror(path);
        exit(1);
    }
    fseek(f, 0, SEEK_END);
    *n = (size_t)ftell(f);
    rewind(f);
    char *bytes = malloc(*n + 1);
    if (!bytes || fread(bytes, 1, *n, f) != *n) exit(1);
    bytes[*n] = '\0';
    fclose(f);
    return bytes;
}

/* Number of names in the tests' directory that contain ".part-": unfinished files. */
__attribute__((unused)) static int check_leftovers(void)
{
    int n = 0;
    DIR *d = opendir(check_dir);
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
    CHECK(status == code && err.code == code, "%s: status %d (%s), expected %d: %s", label, status, ff_status_str(status), code,
          all);
    if (status == FF_OK) {
        ff_table_clear(&t);
        return;
    }
    unsigned char first;
    memcpy(&first, &t, 1);
    CHECK(first == 0x5A, "%s: the table was touched on failure", label);
    CHECK(strcmp(err.path, path) == 0, "%s: path '%s'", label, err.path);
    CHECK(err.line == line, "%s: line %ld, expected %ld: %s", label, err.line, line, all);
    for (; *words; words++) CHECK(strstr(all, *words), "%s: no '%s' in: %s", label, *words, all);
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
    const char *path = check_path("whole"), *fifo = check_path("fifo");
    check_write(path, bytes, n);
    for (size_t k = 0; k < 3; k++) {
        char command[800];
        snprintf(command, sizeof command, "rm -f '%s'; mkfifo '%s'; (%s) < '%s' > '%s' &", fifo, fifo, cases[k].filter, path, fifo);
        if (system(command) != 0) exit(1);
        ff_table t;
        ff_error err = {0};
        ff_status s = ff_table_read_into(fifo, format, &t, &err);
        CHECK(s == cases[k].status && (s == FF_OK || err.byte == cases[k].byte), "%s: %d at %lld %s", cases[k].filter, s,
              (long long)err.byte, err.message);
        if (s == FF_OK) ff_table_clear(&t);
    }
}

/* Same numbers in both tables, bit for bit; values and sigmas as 1/sr, of valid samples. */
__attribute__((unused)) static int check_same_bits(const double *a, const double *b, size_t n)
{
    return memcmp(a, b, n * sizeof *a) == 0;
}
__attribute__((unused)) static void check_same_tables(const char *label, const ff_table *a, const ff_table *b)
{
    if (!CHECK(a->n == b->n && a->n_channels == b->n_channels, "%s: %zu x %zu and %zu x %zu", label, a->n, a->n_channels, b->n,
               b->n_channels))
        return;
    CHECK(memcmp(a->valid, b->valid, a->n) == 0, "%s: validity", label);
    CHECK(!a->sigma == !b->sigma, "%s: sigma", label);
    CHECK(a->isotropic == b->isotropic, "%s: isotropic %d %d", label, a->isotropic, b->isotropic);
    CHECK(a->n_invalid == b->n_invalid && a->n_negative == b->n_negative, "%s: counts", label);
    for (size_t c = 0; c < a->n_channels; c++) {
        CHECK(strcmp(a->channels[c].name, b->channels[c].name) == 0, "%s: channel '%s' '%s'", label, a->channels[c].name,
              b->channels[c].name);
        for (size_t i = 0; i < a->n; i++) {
            double u, v;
            if (!a->valid[i]) continue;
            ff_table_values(a, c, i, 1, &u);
            ff_table_values(b, c, i, 1, &v);
            if (!CHECK(check_same_bits(&u, &v, 1), "%s: sample %zu channel %zu: %.17g %.17g", label, i, c, u, v)) return;
            if (!a->sigma || !b->sigma) continue;
            ff_table_sigmas(a, c, i, 1, &u);
            ff_table_sigmas(b, c, i, 1, &v);
            if (!CHECK(check_same_bits(&u, &v, 1), "%s: sigma %zu channel %zu: %.17g %.17g", label, i, c, u, v)) return;
        }
    }
}
__attribute__((unused)) static void check_same_angles(const char *label, const ff_table *a, const ff_table *b)
{
    CHECK(a->radians_per_unit == b->radians_per_unit, "%s: unit", label);
    for (int k = 0; k < 4; k++) CHECK(check_same_bits(a->angle[k], b->angle[k], a->n), "%s: angle %d", label, k);
}

/* xorshift: the same numbers everywhere. */
static uint64_t check_state = 88172645463325252u;
__attribute__((unused)) static uint64_t check_random(void)
{
    check_state ^= check_state << 13;
    check_state ^= check_state >> 7;
    check_state ^= check_state << 17;
    return check_state;
}
__attribute__((unused)) static double check_uniform(void)
{
    return (double)(check_random() >> 11) * 0x1p-53;
}

__attribute__((unused)) static int check_result(void)
{
    printf("%d checks, %d failures\n", check_count, check_failures);
    return check_failures ? 1 : 0;
}
#endif
