/* Words and numbers of free-form text. */
#define _GNU_SOURCE
#include "internal_tokens.h"
#include "internal_number.h"
#include <math.h>
#include <string.h>

ff_status ff_tokens_open(const char *path, ff_tokens *t, ff_error *err)
{
    ff_tokens opened = {.err = err};
    const ff_status status = ff_lines_open(path, &opened.lines, err);
    if (status == FF_OK) *t = opened;
    return status;
}

void ff_tokens_close(ff_tokens *t)
{
    ff_lines_close(&t->lines);
}

static int is_blank(char c)
{
    return c == ' ' || c == '\t' || c == ',' || c == '\r';
}

/* 1 where a number or word may end. */
static int ends(char c)
{
    return c == '\0' || is_blank(c);
}

static char *skip_blanks(char *p)
{
    while (is_blank(*p)) p++;
    return p;
}

ff_status ff_tokens_line(ff_tokens *t, char **text)
{
    size_t length;
    for (;;) {
        const ff_status status = ff_lines_next(&t->lines, text, &length, t->err);
        t->at = NULL;
        if (status != FF_OK || !*text) return status;
        t->at = *text = skip_blanks(*text);
        if (**text && **text != '#') return FF_OK;
    }
}

/* Moves to the start of the next word; t->at is NULL at the end of the file. */
static ff_status seek_word(ff_tokens *t)
{
    char *text;
    if (t->at) t->at = skip_blanks(t->at);
    if (t->at && *t->at && *t->at != '#') return FF_OK;
    return ff_tokens_line(t, &text);
}

ff_status ff_tokens_word(ff_tokens *t, char **word)
{
    const ff_status status = seek_word(t);
    *word = NULL;
    if (status != FF_OK || !t->at) return status;
    char *end = *word = t->at;
    while (!ends(*end)) end++;
    t->at = *end ? end + 1 : end;
    *end = '\0';
    return FF_OK;
}

ff_status ff_tokens_at_end(ff_tokens *t, int *end)
{
    const ff_status status = seek_word(t);
    *end = t->at == NULL;
    return status;
}

static size_t word_length(const char *p)
{
    size_t n = 0;
    while (!ends(p[n])) n++;
    return n;
}

/* One number at p; where it ends, NULL with an error when it is none. */
static const char *number_at(const char *p, double *value, const char *path, long line, const char *what, ff_error *err)
{
    const char *end = ff_number_read(p, value);
    if (end && ends(*end) && isfinite(*value)) return end;
    char found[FF_QUOTE];
    ff_error_set(err, FF_ERR_DATA, path, line, -1, "found %s, expected a finite number of %s", ff_quote(p, word_length(p), found),
                 what);
    return NULL;
}

ff_status ff_tokens_numbers(ff_tokens *t, double *out, size_t n, const char *what)
{
    for (size_t k = 0; k < n; k++) {
        const ff_status status = seek_word(t);
        if (status != FF_OK) return status;
        if (!t->at)
            return ff_error_set(t->err, FF_ERR_READ, t->lines.path, t->lines.line, -1,
                                "found the end of the file after %zu numbers, expected %zu of %s", k, n, what);
        const char *end = number_at(t->at, &out[k], t->lines.path, t->lines.line, what, t->err);
        if (!end) return FF_ERR_DATA;
        t->at += end - t->at;
    }
    return FF_OK;
}

ff_status ff_line_numbers(const char *text, double *out, size_t most, size_t *n, const char *path, long line, const char *what,
                          ff_error *err)
{
    size_t count = 0;
    for (const char *p = text;;) {
        while (is_blank(*p)) p++;
        if (!*p || *p == '#') break;
        if (count == most)
            return ff_error_set(err, FF_ERR_FORMAT, path, line, -1, "found more than %zu numbers, expected %s", most, what);
        p = number_at(p, &out[count], path, line, what, err);
        if (!p) return FF_ERR_DATA;
        count++;
    }
    *n = count;
    return FF_OK;
}

int ff_whole_number(const char *word, uint64_t most, uint64_t *out)
{
    uint64_t n = 0;
    if (!*word) return 0;
    for (; *word; word++) {
        const unsigned digit = (unsigned)(*word - '0');
        if (digit > 9 || digit > most || n > (most - digit) / 10) return 0;
        n = 10 * n + digit;
    }
    *out = n;
    return 1;
}
