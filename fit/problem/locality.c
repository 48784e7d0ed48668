/* Samples in no order of their own are put into one in which neighbours are alike, since errors of neighbours are looked for
 * (clusters.c): along Morton's curve through theta_h and theta_d and, where the data show directions, phi_h. */
#include "internal_problem.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* More samples than this are left as they are: gathering them from all over the table takes several times as long as all else. */
enum { MOST_ORDERED = 100000, LOOK_SLAB = 2048, CODE_BITS = 18, DIGIT_BITS = 9, DIGITS = 1 << DIGIT_BITS };
static const double pi = 3.14159265358979323846;

/* The bits of `dims` numbers of CODE_BITS / dims bits, in turn. */
static uint32_t interleave(const uint32_t *v, int dims)
{
    uint32_t code = 0;
    for (int bit = CODE_BITS / dims - 1; bit >= 0; bit--)
        for (int k = 0; k < dims; k++) code = code << 1 | (v[k] >> bit & 1);
    return code;
}

/* x in [0, 1] to a number of `bits` bits. */
static uint32_t quantise(double x, int bits)
{
    const double top = (double)((1u << bits) - 1);
    return (uint32_t)lround(fmin(fmax(x, 0), 1) * top);
}

static uint32_t code_of(const double w[6], int isotropic)
{
    const double hx = w[0] + w[3], hy = w[1] + w[4], hz = w[2] + w[5], length = sqrt(fmax(hx * hx + hy * hy + hz * hz, 1e-300));
    const int dims = isotropic ? 2 : 3, bits = CODE_BITS / dims;
    const uint32_t v[3] = {quantise(sqrt(acos(fmin(hz / length, 1)) / (pi / 2)), bits), /* finer towards the normal, as lobes are */
                           quantise(acos(fmin(0.5 * length, 1)) / (pi / 2), bits), quantise(0.5 + atan2(hy, hx) / (2 * pi), bits)};
    return interleave(v, dims);
}

typedef struct look {
    const ff_table *t;
    const uint32_t *index;
    size_t n;
    uint32_t *code;       /* [n] */
    unsigned char *moved; /* [n] 1: the incident direction is not that of the sample before */
} look;

static void look_at(void *context, size_t slab, int worker)
{
    const look *l = context;
    const size_t first = slab * LOOK_SLAB, end = first + LOOK_SLAB < l->n ? first + LOOK_SLAB : l->n;
    double w[6], before[3] = {0}, *const planes[6] = {w, w + 1, w + 2, w + 3, w + 4, w + 5};
    (void)worker;
    for (size_t i = first; i < end; i++) {
        ff_table_directions(l->t, l->index[i], 1, planes);
        const double d = fabs(w[0] - before[0]) + fabs(w[1] - before[1]) + fabs(w[2] - before[2]);
        l->moved[i] = d > 1e-6;
        memcpy(before, w, sizeof before);
        l->code[i] = code_of(w, l->t->isotropic);
    }
}

/* The samples by a digit of their codes, those of one digit in the order that they have (Knuth, volume 3, 5.2.5). */
static void sort_by_digit(const uint32_t *code, int shift, const uint32_t *from, uint32_t *to, size_t n)
{
    size_t start[DIGITS + 1] = {0};
    for (size_t i = 0; i < n; i++) start[(code[from[i]] >> shift & (DIGITS - 1)) + 1]++;
    for (size_t d = 0; d < DIGITS; d++) start[d + 1] += start[d];
    for (size_t i = 0; i < n; i++) to[start[code[from[i]] >> shift & (DIGITS - 1)]++] = from[i];
}

ff_status ff_order_by_place(const ff_table *t, ff_pool *pool, uint32_t *index, size_t n)
{
    if (t->grid || t->axes.kind != FF_AXES_NONE || n < 2 || n > MOST_ORDERED) return FF_OK;
    look l = {t, index, n, malloc(n * sizeof *l.code), malloc(n)};
    uint32_t *place = malloc(n * sizeof *place), *half = malloc(n * sizeof *half);
    size_t moved = 0;
    const ff_status status = l.code && l.moved && place && half ? FF_OK : FF_ERR_MEMORY;
    if (!status) {
        ff_pool_run(pool, (n + LOOK_SLAB - 1) / LOOK_SLAB, look_at, &l);
        for (size_t i = 0; i < n; i++) moved += l.moved[i];
    }
    if (!status && moved > n / 2) { /* no scans; what is in one place keeps the file's order */
        for (size_t i = 0; i < n; i++) place[i] = (uint32_t)i;
        sort_by_digit(l.code, 0, place, half, n);
        sort_by_digit(l.code, DIGIT_BITS, half, place, n);
        for (size_t i = 0; i < n; i++) half[i] = index[place[i]];
        memcpy(index, half, n * sizeof *index);
    }
    free(l.code);
    free(l.moved);
    free(place);
    free(half);
    return status;
}
