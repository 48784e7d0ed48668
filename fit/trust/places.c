/* Where samples lie: the groups that are resampled together, and bands of angles. */
#include "internal_trust.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { PLACE_SLAB = 2048, MOST_DIRECTIONS = 512, FEWEST_GROUPS = 10, RUNS_WANTED = 48 };
#define FF_SAME_DIRECTION 1e-3 /* radians */

static const double degree = 3.14159265358979323846 / 180;

const char *ff_grouping_name(int kind)
{
    static const char *const names[] = {"incident directions", "cells of incident directions", "runs of consecutive samples",
                                        "values"};
    return kind >= 0 && kind < 4 ? names[kind] : NULL;
}

const char *ff_place_name(int place)
{
    static const char *const names[FF_PLACE_COUNT] = {"theta_i", "theta_h", "theta_d"};
    return place >= 0 && place < FF_PLACE_COUNT ? names[place] : NULL;
}

const uint32_t *ff_problem_index(const ff_problem *p)
{
    return p->index;
}

/* ---- angles ---------------------------------------------------------------------------------- */

typedef struct look {
    const struct ff_problem *p;
    const ff_table *t;
    ff_places *out;
    float *theta, *phi; /* [n] of wi, radians; phi in [0, 2 pi), 0 where the data are isotropic */
} look;

static unsigned char band_of(double radians)
{
    const int band = (int)(radians / (FF_BAND_DEGREES * degree));
    return (unsigned char)(band < 0 ? 0 : band >= FF_BANDS ? FF_BANDS - 1 : band);
}

static void look_at(void *context, size_t slab, int worker)
{
    const look *l = context;
    const size_t first = slab * PLACE_SLAB, end = first + PLACE_SLAB < l->p->n ? first + PLACE_SLAB : l->p->n;
    double w[6], *const planes[6] = {w, w + 1, w + 2, w + 3, w + 4, w + 5};
    (void)worker;
    for (size_t i = first; i < end; i++) {
        ff_table_directions(l->t, l->p->index[i], 1, planes);
        const double io = w[0] * w[3] + w[1] * w[4] + w[2] * w[5], length = sqrt(fmax(2 + 2 * io, 1e-300));
        const double theta = atan2(hypot(w[0], w[1]), w[2]), phi = atan2(w[1], w[0]);
        l->theta[i] = (float)theta;
        l->phi[i] = l->t->isotropic || theta < FF_SAME_DIRECTION ? 0 : (float)(phi < 0 ? phi + 360 * degree : phi);
        l->out->band[FF_PLACE_THETA_I][i] = band_of(theta);
        l->out->band[FF_PLACE_THETA_H][i] = band_of(acos(fmin((w[2] + w[5]) / length, 1)));
        l->out->band[FF_PLACE_THETA_D][i] = band_of(acos(fmin(0.5 * length, 1)));
    }
}

/* ---- groups ---------------------------------------------------------------------------------- */

/* Directions seen so far, by open addressing; key + 1, so that 0 is an empty place. */
typedef struct directions {
    size_t n;
    uint64_t key[4 * MOST_DIRECTIONS];
    uint32_t number[4 * MOST_DIRECTIONS];
} directions;

static uint64_t key_of(const look *l, size_t i)
{
    const uint64_t turn = (uint64_t)llround(360 * degree / FF_SAME_DIRECTION);
    const uint64_t theta = (uint64_t)llround((double)l->theta[i] / FF_SAME_DIRECTION),
                   phi = (uint64_t)llround((double)l->phi[i] / FF_SAME_DIRECTION) % turn;
    return theta << 32 | phi;
}

/* Number of the direction; MOST_DIRECTIONS when there are too many. */
static uint32_t find_direction(directions *d, uint64_t key)
{
    const size_t mask = sizeof d->key / sizeof *d->key - 1;
    size_t at = (size_t)(key * UINT64_C(0x9e3779b97f4a7c15) >> 40) & mask;
    while (d->key[at] && d->key[at] != key + 1) at = (at + 1) & mask;
    if (d->key[at]) return d->number[at];
    if (d->n == MOST_DIRECTIONS) return MOST_DIRECTIONS;
    d->key[at] = key + 1;
    d->number[at] = (uint32_t)d->n++;
    return d->number[at];
}

static int by_key(const void *a, const void *b)
{
    const uint64_t x = *(const uint64_t *)a, y = *(const uint64_t *)b;
    return (x > y) - (x < y);
}

/* Numbers by theta_i, then phi_i, instead of by appearance. number_of [d->n] */
static void order_directions(const directions *d, uint64_t *pairs, uint32_t *number_of)
{
    size_t n = 0;
    for (size_t at = 0; at < sizeof d->key / sizeof *d->key; at++) {
        if (!d->key[at]) continue;
        pairs[2 * n] = d->key[at];
        pairs[2 * n++ + 1] = d->number[at];
    }
    qsort(pairs, n, 2 * sizeof *pairs, by_key);
    for (size_t k = 0; k < n; k++) number_of[pairs[2 * k + 1]] = (uint32_t)k;
}

/* Whether the samples come in few enough incident directions; then their groups are filled in. */
static ff_status group_by_direction(const look *l, int *done)
{
    ff_places *out = l->out;
    directions *d = calloc(1, sizeof *d);
    uint64_t *pairs = malloc(2 * MOST_DIRECTIONS * sizeof *pairs);
    uint32_t *number = malloc(MOST_DIRECTIONS * sizeof *number);
    *done = 0;
    const ff_status status = d && pairs && number ? FF_OK : FF_ERR_MEMORY;
    if (!status) {
        size_t i = 0;
        for (; i < out->n; i++) {
            out->group[i] = find_direction(d, key_of(l, i));
            if (out->group[i] == MOST_DIRECTIONS) break;
        }
        if (i == out->n && d->n * 4 <= out->n) {
            order_directions(d, pairs, number);
            for (i = 0; i < out->n; i++) out->group[i] = number[out->group[i]];
            out->kind = FF_GROUP_DIRECTIONS;
            out->n_groups = out->n_directions = d->n;
            *done = 1;
        }
    }
    free(d);
    free(pairs);
    free(number);
    return status;
}

/* Cells of incident directions: rings of theta_i; with directions of their own, each ring in sectors of about a ring's width. */
static ff_status group_by_cell(const look *l)
{
    enum { RINGS_ALONE = 64, RINGS = 9, MOST_CELLS = 1024 };
    ff_places *out = l->out;
    const size_t rings = l->t->isotropic ? RINGS_ALONE : RINGS;
    double highest = 0;
    size_t sectors[RINGS_ALONE], first[RINGS_ALONE], cells = 0;
    uint32_t number[MOST_CELLS] = {0};
    for (size_t i = 0; i < out->n; i++) highest = fmax(highest, (double)l->theta[i]);
    highest = fmax(highest * (1 + 1e-6), FF_SAME_DIRECTION);
    for (size_t r = 0; r < rings; r++) {
        const double middle = ((double)r + 0.5) / (double)rings * highest;
        sectors[r] = l->t->isotropic ? 1 : (size_t)lround(fmax(360 * degree * sin(middle) / (highest / (double)rings), 1));
        first[r] = cells;
        cells += sectors[r];
    }
    if (cells > MOST_CELLS) return FF_ERR_INTERNAL;
    for (size_t i = 0; i < out->n; i++) {
        const size_t r = (size_t)((double)l->theta[i] / highest * (double)rings);
        const size_t s = (size_t)((double)l->phi[i] / (360 * degree) * (double)sectors[r]);
        out->group[i] = (uint32_t)(first[r] + (s < sectors[r] ? s : sectors[r] - 1));
        number[out->group[i]] = 1;
    }
    out->n_groups = 0;
    for (size_t c = 0; c < cells; c++) /* those that are empty are none */
        if (number[c]) number[c] = (uint32_t)out->n_groups++;
    for (size_t i = 0; i < out->n; i++) out->group[i] = number[out->group[i]];
    out->kind = FF_GROUP_CELLS;
    out->n_directions = out->n_groups;
    return FF_OK;
}

/* Parts of groups: every `length` consecutive samples of one start a new one. */
static ff_status split_into_runs(ff_places *out)
{
    const size_t length = out->n / RUNS_WANTED > 1 ? out->n / RUNS_WANTED : 1;
    uint32_t *now = malloc(out->n_groups * sizeof *now), next = 0;
    size_t *left = calloc(out->n_groups, sizeof *left);
    if (now && left)
        for (size_t i = 0; i < out->n; i++) {
            const uint32_t g = out->group[i];
            if (left[g] == 0) {
                now[g] = next++;
                left[g] = length;
            }
            left[g]--;
            out->group[i] = now[g];
        }
    const ff_status status = now && left ? FF_OK : FF_ERR_MEMORY;
    free(now);
    free(left);
    out->n_groups = next;
    out->kind = FF_GROUP_RUNS;
    return status;
}

ff_status ff_places_init(const ff_problem *p, const ff_table *t, ff_places *out, ff_error *err)
{
    ff_places places = {
        .n = p->n, .group = malloc(p->n * sizeof *places.group), .direction = malloc(p->n * sizeof *places.direction)};
    look l = {p, t, &places, malloc(p->n * sizeof *l.theta), malloc(p->n * sizeof *l.phi)};
    int failed = !places.group || !places.direction || !l.theta || !l.phi, done = 0;
    for (int k = 0; k < FF_PLACE_COUNT; k++) failed |= !(places.band[k] = malloc(p->n));
    ff_status status = failed ? FF_ERR_MEMORY : FF_OK;
    if (!status) {
        ff_pool_run(p->pool, (p->n + PLACE_SLAB - 1) / PLACE_SLAB, look_at, &l);
        status = group_by_direction(&l, &done);
    }
    if (!status && !done) status = group_by_cell(&l);
    if (!status) memcpy(places.direction, places.group, p->n * sizeof *places.group);
    if (!status && places.n_groups < FEWEST_GROUPS) status = split_into_runs(&places);
    free(l.theta);
    free(l.phi);
    if (status) {
        ff_places_clear(&places);
        return ff_error_set(err, status, NULL, 0, -1, "the samples could not be grouped: %s", ff_status_str(status));
    }
    *out = places;
    return FF_OK;
}

void ff_places_clear(ff_places *places)
{
    free(places->group);
    free(places->direction);
    for (int k = 0; k < FF_PLACE_COUNT; k++) free(places->band[k]);
    memset(places, 0, sizeof *places);
}
