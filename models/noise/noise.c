/* A model of the errors of measured values. */
#include "noise_struct.h"
#include "base/internal_number.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

ff_noise *ff_noise_make(size_t n_levels)
{
    ff_noise *n = calloc(1, sizeof *n + n_levels * sizeof *n->level);
    if (!n) return NULL;
    n->n_levels = n_levels;
    n->along_scan[0] = 1;
    return n;
}

static int is_level(const ff_noise_level *l)
{
    return l->constant >= 0 && l->linear >= 0 && l->square >= 0 && isfinite(l->constant) && isfinite(l->linear) &&
           isfinite(l->square) && l->constant + l->linear + l->square > 0;
}

ff_status ff_noise_new(const ff_noise_level *level, size_t n_levels, double cos_i, double cos_o, ff_noise **out, ff_error *err)
{
    if (n_levels == 0) return ff_error_set(err, FF_ERR_RANGE, NULL, 0, -1, "a noise model needs at least one level");
    for (size_t k = 0; k < n_levels; k++)
        if (!is_level(&level[k]))
            return ff_error_set(err, FF_ERR_RANGE, NULL, 0, -1,
                                "the levels of a noise model are at or above 0, and not all 0; found %g, %g, %g", level[k].constant,
                                level[k].linear, level[k].square);
    if (!isfinite(cos_i) || !isfinite(cos_o))
        return ff_error_set(err, FF_ERR_RANGE, NULL, 0, -1, "the powers of the cosines of a noise model are finite numbers");
    ff_noise *n = ff_noise_make(n_levels);
    if (!n) return ff_error_set(err, FF_ERR_MEMORY, NULL, 0, -1, "out of memory");
    memcpy(n->level, level, n_levels * sizeof *level);
    n->cos_i = cos_i;
    n->cos_o = cos_o;
    *out = n;
    return FF_OK;
}

void ff_noise_free(ff_noise *n)
{
    free(n);
}

size_t ff_noise_level_count(const ff_noise *n)
{
    return n->n_levels;
}

static int has_channel(const ff_noise *n, size_t channel)
{
    return n->n_levels == 1 || channel < n->n_levels;
}

ff_noise_level ff_noise_level_at(const ff_noise *n, size_t channel)
{
    return has_channel(n, channel) ? *ff_noise_of(n, channel) : (ff_noise_level){0, 0, 0};
}

double ff_noise_cos_i(const ff_noise *n)
{
    return n->cos_i;
}

double ff_noise_cos_o(const ff_noise *n)
{
    return n->cos_o;
}

double ff_noise_along_scan(const ff_noise *n, size_t lag)
{
    return lag <= FF_NOISE_LAGS ? n->along_scan[lag] : 0;
}

double ff_noise_between_channels(const ff_noise *n)
{
    return n->between_channels;
}

double ff_noise_sd(const ff_noise *n, size_t channel, double f, double cos_i, double cos_o)
{
    if (!has_channel(n, channel)) return NAN;
    return sqrt(ff_noise_variance(ff_noise_of(n, channel), f) * pow(cos_i, n->cos_i) * pow(cos_o, n->cos_o));
}

/* ---- as text --------------------------------------------------------------------------------- */

static const char *const words[] = {"relative", "floor", "counts", "cos_i", "cos_o"};
enum { WORDS = sizeof words / sizeof words[0], RELATIVE = 0, FLOOR = 1, COUNTS = 2, COS_I = 3, COS_O = 4 };

/* "name=number" of length n: its word and value. */
static ff_status read_word(const char *text, size_t n, double value[WORDS], ff_error *err)
{
    const char *equals = memchr(text, '=', n);
    const size_t length = equals ? (size_t)(equals - text) : n;
    size_t k = 0;
    while (k < WORDS && (strlen(words[k]) != length || memcmp(words[k], text, length) != 0)) k++;
    if (k == WORDS)
        return ff_error_set(err, FF_ERR_UNKNOWN, NULL, 0, -1,
                            "'%.*s' is no part of a noise model; these are relative, floor, counts, cos_i, cos_o", (int)length,
                            text);
    const char *end = equals ? ff_number_read(equals + 1, &value[k]) : NULL;
    if (!end || end != text + n || !isfinite(value[k]))
        return ff_error_set(err, FF_ERR_SYNTAX, NULL, 0, -1, "'%.*s' of a noise model: expected %s=NUMBER", (int)n, text, words[k]);
    if (k < COS_I && value[k] < 0)
        return ff_error_set(err, FF_ERR_RANGE, NULL, 0, -1, "%s of a noise model is at or above 0, found %g", words[k], value[k]);
    return FF_OK;
}

ff_status ff_noise_parse(const char *text, ff_noise **out, ff_error *err)
{
    double value[WORDS] = {0};
    for (const char *at = text;;) {
        const size_t n = strcspn(at, ",");
        const ff_status status = read_word(at, n, value, err);
        if (status) return status;
        if (!at[n]) break;
        at += n + 1;
    }
    const ff_noise_level level = {value[FLOOR] * value[FLOOR], value[COUNTS], value[RELATIVE] * value[RELATIVE]};
    if (!is_level(&level))
        return ff_error_set(err, FF_ERR_RANGE, NULL, 0, -1,
                            "'%s' is no noise: one of relative, floor and counts is above 0, and the squares of none overflow",
                            text);
    return ff_noise_new(&level, 1, value[COS_I], value[COS_O], out, err);
}
