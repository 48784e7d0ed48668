/* Numbers that stand for "not measured": instruments and programs write one far below, or above, everything they can measure. */
#include "base/internal_number.h"
#include "internal_table.h"
#include <math.h>
#include <string.h>
#include <strings.h>

static const double codes[] = {-99, -999, -999.25, -9999, -32768, -99999, -999999, -1e30, 1e30};
enum { CODES = sizeof codes / sizeof codes[0] };

/* Which code a value is, CODES for none. Files round to the digits they have. */
static size_t code_of(double v)
{
    size_t k = 0;
    if (v > -98 && v < 1e29) return CODES;
    while (k < CODES && !(fabs(v - codes[k]) <= 1e-6 * fabs(codes[k]))) k++;
    return k;
}

int ff_table_is_code(double v)
{
    return code_of(v) < CODES;
}

int ff_table_is_missing_word(const char *cell, size_t length)
{
    static const char *const words[] = {"nan",   "na",      "n/a",  "n.a.", "#n/a",     "-",         "--",      "---",     "*",
                                        "?",     "null",    "none", "nil",  "missing",  "k.a.",      "nd",      "n.d.",    "n/d",
                                        "inval", "invalid", "-nan", "+nan", "nan(ind)", "-nan(ind)", "1.#qnan", "-1.#ind", "."};
    if (length && *cell == '#') return 1; /* #DIV/0!, #WERT! */
    for (size_t k = 0; k < sizeof words / sizeof words[0]; k++)
        if (strlen(words[k]) == length && strncasecmp(cell, words[k], length) == 0) return 1;
    return 0;
}

/* Counts the cells of a channel that are codes; its least value that is none. */
static double look_for(const ff_table *t, size_t c, size_t *count)
{
    double least = INFINITY;
    for (size_t i = 0; i < t->n; i++) {
        const double v = t->value[c * t->n + i];
        const size_t k = t->valid[i] ? code_of(v) : CODES;
        if (!t->valid[i]) continue;
        if (k < CODES)
            count[k]++;
        else
            least = fmin(least, v);
    }
    return least;
}

static void leave_out(ff_table *t, size_t c, size_t code)
{
    for (size_t i = 0; i < t->n; i++)
        if (code_of(t->value[c * t->n + i]) == code) t->valid[i] = 0;
}

/* Noise goes below 0, too, but not in one step down to a round number. */
static int stands_alone(double code, double least)
{
    return code > 0 || least > 0.1 * code;
}

void ff_table_leave_out_codes(ff_table *t)
{
    size_t found[CODES] = {0};
    for (size_t c = 0; c < t->n_channels; c++) {
        size_t count[CODES] = {0};
        const double least = look_for(t, c, count);
        for (size_t k = 0; k < CODES; k++)
            if (count[k] && stands_alone(codes[k], least)) found[k] += count[k];
    }
    for (size_t k = 0; k < CODES; k++) {
        char number[FF_NUMBER_TEXT + 1];
        if (!found[k]) continue;
        for (size_t c = 0; c < t->n_channels; c++) leave_out(t, c, k);
        number[ff_number_write(codes[k], number)] = '\0';
        ff_table_note(t, "%zu %s %s, a code for what was not measured: left out", found[k],
                      found[k] == 1 ? "value is" : "values are", number);
    }
    for (size_t i = 0; i < t->n; i++)
        for (size_t c = 0; c < t->n_channels && !t->valid[i]; c++)
            if (code_of(t->value[c * t->n + i]) < CODES) t->value[c * t->n + i] = 0;
}
