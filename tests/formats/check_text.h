/* What the tests of text formats share: files written from strings, and damage to them. */
#ifndef FF_FORMATS_CHECK_TEXT_H
#define FF_FORMATS_CHECK_TEXT_H
#include "check_table.h"

static const double check_pi = 3.14159265358979323846;

/* Writes text and reads it back with the options (NULL: none), found by content; 1 when it is of this format. */
__attribute__((unused)) static int check_reads_with(const char *label, const char *format, const char *text,
                                                    const ff_read_options *o, ff_table *t)
{
    const char *path = ff_test_path("content");
    ff_test_write(path, text, strlen(text));
    ff_error err = {0};
    char all[FF_ERROR_PATH + FF_ERROR_MESSAGE + 64];
    ff_status status = ff_table_read_with_into(path, o, t, &err);
    ff_error_format(&err, all, sizeof all);
    if (!FF_CHECK(status == FF_OK, "%s: %s", label, all)) return 0;
    if (FF_CHECK(strcmp(t->format, format) == 0, "%s: read as %s", label, t->format)) return 1;
    ff_table_clear(t);
    return 0;
}

__attribute__((unused)) static int check_reads(const char *label, const char *format, const char *text, ff_table *t)
{
    return check_reads_with(label, format, text, NULL, t);
}

/* With the part of a file that --part chooses (NULL: the default). */
__attribute__((unused)) static int check_reads_part(const char *label, const char *format, const char *text, const char *part,
                                                    ff_table *t)
{
    ff_read_options o;
    ff_read_options_init(&o);
    o.part = part;
    return check_reads_with(label, format, text, &o, t);
}

__attribute__((unused)) static void check_refuses(const char *format, const char *text, ff_status code, long line,
                                                  const char *const *words)
{
    const char *path = ff_test_path("bad");
    ff_test_write(path, text, strlen(text));
    check_fails(text, path, format, code, line, words);
}

/* The text behind a UTF-8 byte-order mark, as some editors save it, is found by content and read the same. */
__attribute__((unused)) static void check_byte_order_mark(const char *format, const char *text)
{
    ff_table plain, marked;
    if (!check_reads("without a byte-order mark", format, text, &plain)) return;
    char *bytes = malloc(strlen(text) + 4);
    if (!bytes) exit(1);
    strcat(strcpy(bytes, "\xEF\xBB\xBF"), text);
    if (check_reads("behind a byte-order mark", format, bytes, &marked)) {
        check_same_tables("behind a byte-order mark", &plain, &marked);
        ff_table_clear(&marked);
    }
    free(bytes);
    ff_table_clear(&plain);
}

static void check_well_formed(const char *label, size_t at, const ff_table *t)
{
    FF_CHECK(t->n > 0 && t->n_channels > 0 && t->n_invalid < t->n, "%s %zu: %zu samples, %zu invalid", label, at, t->n,
             t->n_invalid);
    for (size_t i = 0; i < t->n; i++) {
        for (int k = 0; k < 4; k++) FF_CHECK(isfinite(t->angle[k][i]), "%s %zu: angle %d of sample %zu", label, at, k, i);
        for (size_t c = 0; c < t->n_channels && t->valid[i]; c++)
            FF_CHECK(isfinite(t->value[c * t->n + i]), "%s %zu: value of sample %zu", label, at, i);
    }
}

/* What reading these bytes gives: an error that says something, or a table that is well-formed. Returns 1 for a table. */
static int check_survives(const char *label, size_t at, const char *format, const char *bytes, size_t n, ff_table *t)
{
    const char *path = ff_test_path("damaged");
    ff_test_write(path, bytes, n);
    ff_error err = {0};
    if (ff_table_read_into(path, format, t, &err) != FF_OK) {
        FF_CHECK(strcmp(err.path, path) == 0 && err.message[0], "%s %zu: no message", label, at);
        return 0;
    }
    check_well_formed(label, at, t);
    return 1;
}

/* Every prefix is an error, or a table that says that its last line may be cut, or, cut between two rows of a file whose format
 * does not count them (may_end_early), a shorter one. The whole text has n samples. */
__attribute__((unused)) static void check_prefixes(const char *format, const char *text, size_t n, int may_end_early)
{
    const size_t length = strlen(text);
    for (size_t k = 0; k <= length; k++) {
        ff_table t;
        if (!check_survives("prefix", k, format, text, k, &t)) {
            FF_CHECK(k < length, "%s: the whole text is not read", format);
            continue;
        }
        FF_CHECK(t.n <= n && (k < length || t.n == n), "prefix %zu: %zu samples", k, t.n);
        const int between = text[k - 1] == '\n';
        FF_CHECK(k == length || (between && may_end_early) || strstr(t.note, "cut"), "prefix %zu was taken as whole", k);
        ff_table_clear(&t);
    }
}

/* Every single bit of the text, flipped. */
__attribute__((unused)) static void check_flips(const char *format, const char *text)
{
    const size_t length = strlen(text);
    char *bytes = strdup(text);
    size_t read = 0;
    for (size_t k = 0; k < 8 * length; k++) {
        ff_table t;
        bytes[k / 8] ^= (char)(1 << k % 8);
        if (check_survives("flip", k, format, bytes, length, &t)) {
            read++;
            ff_table_clear(&t);
        }
        bytes[k / 8] ^= (char)(1 << k % 8);
    }
    free(bytes);
    FF_CHECK(read > 0 && read < 8 * length, "%s: %zu of %zu damaged files were read", format, read, 8 * length);
}

__attribute__((unused)) static const char *check_data_dir(void)
{
    const char *set = getenv("FACETFIT_DATA");
    return set ? set : FF_SOURCE_DIR "/../shared/data";
}

/* Path of a real file, in a static buffer; NULL where it is not there. */
__attribute__((unused)) static const char *check_data(const char *name)
{
    static char path[900];
    snprintf(path, sizeof path, "%s/%s", check_data_dir(), name);
    return access(path, R_OK) == 0 ? path : NULL;
}

/* Unit vectors of sample i: wi, wo. */
__attribute__((unused)) static void check_directions(const ff_table *t, size_t i, double w[6])
{
    double *const planes[6] = {w, w + 1, w + 2, w + 3, w + 4, w + 5};
    ff_table_directions(t, i, 1, planes);
}
#endif
