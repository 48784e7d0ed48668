/* Lists of angles, blocks of values, cells. */
#define _GNU_SOURCE
#include "internal_scatter_grid.h"
#include "base/internal_number.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

enum { MOST_ANGLES = 1 << 20, FIRST_CAPACITY = 64 };
static const double degree = 3.14159265358979323846 / 180;

/* ---- numbers --------------------------------------------------------------------------------- */

static ff_status make_room(ff_tokens *t, size_t n, ff_values *v)
{
    if (v->capacity - v->n >= n) return FF_OK;
    size_t capacity = v->capacity ? 2 * v->capacity : FIRST_CAPACITY;
    if (capacity < v->n + n) capacity = v->n + n;
    double *larger = realloc(v->value, capacity * sizeof *larger);
    if (!larger)
        return ff_error_set(t->err, FF_ERR_MEMORY, t->lines.path, t->lines.line, -1, "no memory for %zu numbers", capacity);
    v->value = larger;
    v->capacity = capacity;
    return FF_OK;
}

/* In pieces: the count may be anything, the numbers are there. */
ff_status ff_values_read(ff_tokens *t, size_t count, const char *what, ff_values *v)
{
    for (size_t done = 0; done < count;) {
        const size_t n = count - done < 512 ? count - done : 512;
        ff_status status = make_room(t, n, v);
        if (status == FF_OK) status = ff_tokens_numbers(t, v->value + v->n, n, what);
        if (status != FF_OK) return status;
        v->n += n;
        done += n;
    }
    return FF_OK;
}

static ff_status comes_twice(ff_tokens *t, const char *keyword)
{
    return ff_error_set(t->err, FF_ERR_FORMAT, t->lines.path, t->lines.line, -1, "found %s twice, expected it once", keyword);
}

/* The word after the keyword; an error at the end of the file. */
static ff_status word_after(ff_tokens *t, const char *keyword, const char *expected, char **word)
{
    const ff_status status = ff_tokens_word(t, word);
    if (status != FF_OK || *word) return status;
    return ff_error_set(t->err, FF_ERR_READ, t->lines.path, t->lines.line, -1, "found the end of the file after %s, expected %s",
                        keyword, expected);
}

static ff_status read_count(ff_tokens *t, const char *keyword, uint64_t *n)
{
    char *word, found[FF_QUOTE];
    const ff_status status = word_after(t, keyword, "the number of its angles", &word);
    if (status != FF_OK || (ff_whole_number(word, MOST_ANGLES, n) && *n > 0)) return status;
    return ff_error_set(t->err, FF_ERR_FORMAT, t->lines.path, t->lines.line, -1,
                        "%s: found %s, expected a whole number from 1 to %d", keyword, ff_quote(word, strlen(word), found),
                        MOST_ANGLES);
}

static ff_status read_angle(ff_tokens *t, const char *keyword, uint64_t k, uint64_t n, double *v)
{
    char *word, found[FF_QUOTE];
    const ff_status status = ff_tokens_word(t, &word);
    if (status != FF_OK) return status;
    if (!word)
        return ff_error_set(t->err, FF_ERR_READ, t->lines.path, t->lines.line, -1,
                            "%s: found the end of the file after %llu angles, expected %llu", keyword, (unsigned long long)k,
                            (unsigned long long)n);
    const char *end = ff_number_read(word, v);
    if (end && !*end && isfinite(*v)) return FF_OK;
    return ff_error_set(t->err, FF_ERR_DATA, t->lines.path, t->lines.line, -1, "%s: found %s, expected angle %llu of %llu", keyword,
                        ff_quote(word, strlen(word), found), (unsigned long long)k + 1, (unsigned long long)n);
}

ff_status ff_angles_read(ff_tokens *t, const char *keyword, double least, double most, ff_values *out)
{
    uint64_t n = 0;
    if (out->n) return comes_twice(t, keyword);
    ff_status status = read_count(t, keyword, &n);
    for (uint64_t k = 0; k < n && status == FF_OK; k++) {
        double v = 0;
        status = read_angle(t, keyword, k, n, &v);
        if (status == FF_OK && !(v >= least && v <= most))
            status = ff_error_set(t->err, FF_ERR_DATA, t->lines.path, t->lines.line, -1,
                                  "%s: found %g, expected degrees from %g to %g", keyword, v, least, most);
        else if (status == FF_OK && k > 0 && v <= out->value[k - 1])
            status = ff_error_set(t->err, FF_ERR_DATA, t->lines.path, t->lines.line, -1,
                                  "%s: found %g after %g, expected ascending angles", keyword, v, out->value[k - 1]);
        else if (status == FF_OK && (status = make_room(t, 1, out)) == FF_OK)
            out->value[out->n++] = v;
    }
    return status;
}

static ff_status no_choice(ff_tokens *t, const char *keyword, const char *word, const char *const *choices)
{
    char list[160] = "", found[FF_QUOTE];
    for (; *choices; choices++) {
        if (list[0]) strncat(list, choices[1] ? ", " : " or ", sizeof list - strlen(list) - 1);
        strncat(list, *choices, sizeof list - strlen(list) - 1);
    }
    return ff_error_set(t->err, FF_ERR_FORMAT, t->lines.path, t->lines.line, -1, "%s: found %s, expected %s", keyword,
                        ff_quote(word, strlen(word), found), list);
}

ff_status ff_choice_read(ff_tokens *t, const char *keyword, const char *const *choices, int *index)
{
    char *word;
    if (*index >= 0) return comes_twice(t, keyword);
    const ff_status status = word_after(t, keyword, "a word", &word);
    if (status != FF_OK) return status;
    for (int k = 0; choices[k]; k++)
        if (strcasecmp(word, choices[k]) == 0) {
            *index = k;
            return FF_OK;
        }
    return no_choice(t, keyword, word, choices);
}

/* ---- recognising ----------------------------------------------------------------------------- */

static int starts_with(const char *p, const char *stop, const char *keyword)
{
    const size_t n = strlen(keyword);
    if ((size_t)(stop - p) < n || strncasecmp(p, keyword, n) != 0) return 0;
    return p + n == stop || strchr(" \t\r\n", p[n]) != NULL;
}

unsigned ff_keywords_in(const unsigned char *head, size_t n, const char *const *keywords)
{
    unsigned found = 0;
    if (n == 0 || memchr(head, '\0', n)) return 0;
    const char *p = (const char *)head, *stop = p + n;
    while (p && p < stop) {
        while (p < stop && (*p == ' ' || *p == '\t')) p++;
        for (int k = 0; keywords[k]; k++)
            if (starts_with(p, stop, keywords[k])) found |= 1u << k;
        p = memchr(p, '\n', (size_t)(stop - p));
        if (p) p++;
    }
    return found;
}

/* ---- cells ----------------------------------------------------------------------------------- */

double ff_largest_gap(const double *node, size_t n)
{
    double gap = 0;
    for (size_t k = 1; k < n; k++) gap = fmax(gap, node[k] - node[k - 1]);
    return gap;
}

static double middle(const double *node, size_t k)
{
    return (node[k - 1] + node[k]) / 2;
}

void ff_cells_circle(const double *node, size_t n, int mirrored, double *cell)
{
    if (n == 1) {
        cell[0] = 360 * degree;
        return;
    }
    const double span = node[n - 1] - node[0];
    const int half = mirrored && span <= 180 + 1e-9;
    double wrap = 360 - span;
    if (half || !(wrap > 0 && wrap <= 2 * ff_largest_gap(node, n))) wrap = 0;
    for (size_t k = 0; k < n; k++) {
        const double low = k > 0 ? middle(node, k) : node[0] - wrap / 2,
                     high = k + 1 < n ? middle(node, k + 1) : node[n - 1] + wrap / 2;
        cell[k] = (half ? 2 : 1) * (high - low) * degree;
    }
}

void ff_cells_polar(const double *node, size_t n, double end, double *cell)
{
    if (end < 0) end = n > 1 ? fmin(180, node[n - 1] + (node[n - 1] - node[n - 2]) / 2) : 90;
    for (size_t k = 0; k < n; k++) {
        const double low = k > 0 ? middle(node, k) : 0, high = k + 1 < n ? middle(node, k + 1) : fmax(end, node[k]);
        cell[k] = cos(low * degree) - cos(high * degree);
    }
}
