/* The error object: what it keeps, how it is cut, how it is printed. */
#include "check_table.h"

static void names(void)
{
    for (ff_status status = FF_OK; status <= FF_ERR_INTERNAL; status++) {
        FF_CHECK(strcmp(ff_status_str(status), ff_status_str(99)) != 0, "status %d has no name", status);
        for (ff_status r = FF_OK; r < status; r++)
            FF_CHECK(strcmp(ff_status_str(status), ff_status_str(r)) != 0, "%d and %d share a name", status, r);
    }
    FF_CHECK(ff_status_str(-1)[0] && ff_status_str(INT32_MAX)[0], "numbers that are no status");
}

static void format(void)
{
    static const struct {
        const char *path;
        long line;
        int64_t byte;
        const char *text;
    } cases[] = {{"a.csv", 7, -1, "a.csv:7: found 1"},
                 {"a.bin", 0, 12, "a.bin: byte 12: found 1"},
                 {"a.bin", 0, 0, "a.bin: byte 0: found 1"},
                 {"a", 0, -1, "a: found 1"},
                 {NULL, 3, 4, "found 1"}};
    for (size_t k = 0; k < sizeof cases / sizeof cases[0]; k++) {
        ff_error err = {0};
        char out[64];
        ff_status status = ff_error_set(&err, FF_ERR_DATA, cases[k].path, cases[k].line, cases[k].byte, "found %d", 1);
        FF_CHECK(status == FF_ERR_DATA && err.code == FF_ERR_DATA, "code %d", status);
        ff_error_format(&err, out, sizeof out);
        FF_CHECK(strcmp(out, cases[k].text) == 0, "'%s', expected '%s'", out, cases[k].text);
        ff_error_format(&err, out, 5);
        FF_CHECK(strlen(out) == 4, "'%s' is not cut to 4", out);
        ff_error_format(&err, out, 0);
    }
    FF_CHECK(ff_error_set(NULL, FF_ERR_READ, "x", 1, 1, "x") == FF_ERR_READ, "no error object");
}

static void cuts(void)
{
    char longer[2000];
    memset(longer, 'x', sizeof longer - 1);
    longer[sizeof longer - 1] = '\0';
    for (size_t k = FF_ERROR_MESSAGE - 8; k < FF_ERROR_MESSAGE; k++)
        longer[k] = k % 2 ? (char)0xA9 : (char)0xC3; /* two-byte characters */
    ff_error err;
    ff_error_set(&err, FF_ERR_OPEN, longer, 0, -1, "%s", longer);
    FF_CHECK(strlen(err.path) == FF_ERROR_PATH - 1, "path of %zu", strlen(err.path));
    size_t n = strlen(err.message);
    FF_CHECK(n < FF_ERROR_MESSAGE && n > FF_ERROR_MESSAGE - 8 && strcmp(err.message + n - 3, "...") == 0, "message of %zu", n);
    FF_CHECK(err.message[n - 4] != (char)0xC3, "half a character at the cut");
    ff_error_set(&err, FF_ERR_OPEN, "p", 1, -1, "inner");
    ff_error_set(&err, FF_ERR_DATA, err.path, 2, -1, "outer: %s", err.message);
    FF_CHECK(strcmp(err.message, "outer: inner") == 0 && strcmp(err.path, "p") == 0, "arguments of its own: '%s' '%s'", err.path,
             err.message);
}

FF_TEST_MAIN(FF_TEST(names), FF_TEST(format), FF_TEST(cuts))
