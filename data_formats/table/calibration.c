/* From the signals of an instrument to reflectance: less the dark, over a standard. */
#include "ff_calibration.h"
#include "internal_table.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

static const double pi = 3.14159265358979323846;

/* ---- pairs of directions, as keys -------------------------------------------------------------- */

/* Angles nearer than this are the same, degrees: what goniometers reach and return to. */
#define TOLERANCE 0.05
enum { ANGLES = 4 };

/* A pair: theta_i, theta_o, and two azimuths, of which the isotropic ones have the difference alone. */
typedef struct pair {
    double at[ANGLES];
} pair;

static double turned(double phi)
{
    const double full = fmod(phi, 360);
    return full < 0 ? full + 360 : full;
}

static pair pair_at(const ff_table *t, size_t i, int isotropic)
{
    double a[4];
    double *const out[4] = {&a[0], &a[1], &a[2], &a[3]};
    ff_table_angles(t, pi / 180, i, 1, out);
    const double difference = turned(a[3] - a[1]);
    if (isotropic && (a[0] < TOLERANCE || a[2] < TOLERANCE)) return (pair){{a[0], a[2], 0, 0}};
    if (isotropic) return (pair){{a[0], a[2], difference > 180 ? 360 - difference : difference, 0}};
    return (pair){{a[0], a[2], a[0] < TOLERANCE ? 0 : turned(a[1]), a[2] < TOLERANCE ? 0 : turned(a[3])}};
}

static int same_angle(double a, double b, int is_azimuth)
{
    const double apart = fabs(a - b);
    return apart <= TOLERANCE || (is_azimuth && 360 - apart <= TOLERANCE);
}

static int same_pair(const pair *a, const pair *b)
{
    int same = 1;
    for (int k = 0; k < ANGLES; k++) same &= same_angle(a->at[k], b->at[k], k >= 2);
    return same;
}

/* Samples of a table by the cell of 2 TOLERANCE that their pair lies in: chains of a hash. */
typedef struct finder {
    size_t n, n_heads;
    pair *pair;
    size_t *next, *head; /* 1 + sample, 0 at the end */
} finder;

static void finder_free(finder *f)
{
    free(f->pair);
    free(f->next);
    free(f->head);
}

static size_t hashed(const long cell[ANGLES], size_t n_heads)
{
    uint64_t h = UINT64_C(0xcbf29ce484222325);
    for (int k = 0; k < ANGLES; k++) h = (h ^ (uint64_t)cell[k]) * UINT64_C(0x100000001b3), h ^= h >> 29;
    return (size_t)(h % n_heads);
}

static long cell_of(double angle, int is_azimuth)
{
    const long cells = lround(360 / (2 * TOLERANCE)), cell = (long)floor(angle / (2 * TOLERANCE));
    return is_azimuth ? (cell % cells + cells) % cells : cell;
}

static ff_status finder_make(const ff_table *t, int isotropic, finder *f, ff_error *err)
{
    *f = (finder){.n = t->n, .n_heads = 2 * t->n + 1};
    f->pair = malloc(t->n * sizeof *f->pair);
    f->next = malloc(t->n * sizeof *f->next);
    f->head = calloc(f->n_heads, sizeof *f->head);
    if (!f->pair || !f->next || !f->head) {
        finder_free(f);
        return ff_error_set(err, FF_ERR_MEMORY, NULL, 0, -1, "no memory for the directions of %zu samples", t->n);
    }
    for (size_t i = t->n; i-- > 0;) {
        long cell[ANGLES];
        f->pair[i] = pair_at(t, i, isotropic);
        for (int k = 0; k < ANGLES; k++) cell[k] = cell_of(f->pair[i].at[k], k >= 2);
        size_t *head = &f->head[hashed(cell, f->n_heads)];
        f->next[i] = *head;
        *head = i + 1;
    }
    return FF_OK;
}

/* The samples at a pair, at most FOUND of them, into out: in its cell or, as it may lie near a border, in those beside it. Their
 * number. */
enum { FOUND = 64 };
static size_t finder_find(const finder *f, const ff_table *t, const pair *p, size_t out[FOUND])
{
    size_t n = 0;
    for (unsigned side = 0; side < 1u << ANGLES; side++) {
        long cell[ANGLES];
        int again = 0;
        for (int k = 0; k < ANGLES; k++) {
            const double in_cells = p->at[k] / (2 * TOLERANCE), to = in_cells - floor(in_cells) < 0.5 ? -TOLERANCE : TOLERANCE;
            const long own = cell_of(p->at[k], k >= 2), beside = cell_of(p->at[k] + to, k >= 2);
            cell[k] = side >> k & 1 ? beside : own;
            again |= (side >> k & 1) && beside == own; /* a cell that was looked at */
        }
        for (size_t at = again ? 0 : f->head[hashed(cell, f->n_heads)]; at; at = f->next[at - 1])
            if (n < FOUND && same_pair(&f->pair[at - 1], p) && ff_table_is_measured(t, at - 1)) out[n++] = at - 1;
    }
    return n;
}

/* ---- what the second measurement says of every sample of the first ----------------------------- */

/* signal and variance [n_channels][n] of the first table's samples and channels. */
typedef struct signals {
    double *signal, *variance,
        *common; /* variance of a pair's own readings, standard deviation of a mean that many share; or NULL */
    ff_matched how;
} signals;

static void signals_free(signals *s)
{
    free(s->signal);
    free(s->variance);
    free(s->common);
    *s = (signals){.how = FF_MATCHED_NOT};
}

/* Which channel of `other` stands for each of t. */
static ff_status match_channels(const ff_table *t, const ff_table *other, const char *what, size_t *channel, ff_error *err)
{
    int named = 1;
    for (size_t c = 0; c < t->n_channels; c++) {
        channel[c] = other->n_channels;
        for (size_t k = 0; k < other->n_channels; k++)
            if (!strcmp(t->channels[c].name, other->channels[k].name)) channel[c] = k;
        named &= channel[c] < other->n_channels;
    }
    if (named) return FF_OK;
    if (t->n_channels != other->n_channels)
        return ff_error_set(err, FF_ERR_DATA, NULL, 0, -1, "%s has %zu channels of other names, the data have %zu", what,
                            other->n_channels, t->n_channels);
    for (size_t c = 0; c < t->n_channels; c++) channel[c] = c;
    return FF_OK;
}

/* Every pair of t in `other`, the mean where it was read several times; 0 when one is missing. */
static int by_pairs(const ff_table *t, const ff_table *other, const finder *f, const size_t *channel, int isotropic, signals *s)
{
    for (size_t i = 0; i < t->n; i++) {
        size_t at[FOUND];
        if (!t->valid[i]) continue;
        const pair p = pair_at(t, i, isotropic);
        const size_t n = finder_find(f, other, &p, at);
        if (n == 0) return 0;
        for (size_t c = 0; c < t->n_channels; c++) {
            double sum = 0, variance = 0;
            for (size_t k = 0; k < n; k++) {
                const size_t from = channel[c] * other->n + at[k];
                sum += other->value[from];
                if (s->variance) variance += other->sigma[from] * other->sigma[from];
            }
            s->signal[c * t->n + i] = sum / (double)n;
            if (s->variance) s->variance[c * t->n + i] = variance / (double)(n * n);
        }
    }
    s->how = FF_MATCHED_PAIRS;
    return 1;
}

/* ---- means at incidences ------------------------------------------------------------------------ */

/* A sample that was measured, by its incidence. */
typedef struct reading {
    double theta_i;
    size_t sample;
} reading;

/* Readings [from, to) of a sorted list, whose incidences are one. */
typedef struct incidence {
    double lo, hi;
    size_t from, to;
} incidence;

static int by_theta(const void *a, const void *b)
{
    const reading *x = a, *y = b;
    if (x->theta_i != y->theta_i) return x->theta_i < y->theta_i ? -1 : 1;
    return x->sample < y->sample ? -1 : x->sample > y->sample;
}

/* The incidences of the measured samples, ascending; `all` [n] and `out` [n] have room for one each. Their number. */
static size_t incidences_of(const ff_table *other, const finder *f, reading *all, incidence *out)
{
    size_t n = 0, count = 0;
    for (size_t i = 0; i < other->n; i++)
        if (ff_table_is_measured(other, i)) all[n++] = (reading){f->pair[i].at[0], i};
    qsort(all, n, sizeof *all, by_theta);
    for (size_t k = 0; k < n; k++) {
        if (count == 0 || all[k].theta_i - out[count - 1].hi > TOLERANCE) out[count++] = (incidence){all[k].theta_i, 0, k, 0};
        out[count - 1].hi = all[k].theta_i;
        out[count - 1].to = k + 1;
    }
    return count;
}

/* Where an incidence is among n; n when nowhere. */
static size_t incidence_at(const incidence *x, size_t n, double theta_i)
{
    size_t lo = 0, hi = n;
    while (lo < hi) { /* the first that does not end below */
        const size_t middle = lo + (hi - lo) / 2;
        if (x[middle].hi + TOLERANCE < theta_i)
            lo = middle + 1;
        else
            hi = middle;
    }
    return lo < n && x[lo].lo - TOLERANCE <= theta_i ? lo : n;
}

/* Mean of a channel of `other` at an incidence, and its standard deviation: by the scatter, and no less than by the file's; NaN of
 * one reading of which the file says nothing. */
static void mean_at(const ff_table *other, const reading *all, const incidence *x, size_t channel, double *mean, double *sd)
{
    const double n = (double)(x->to - x->from);
    double sum = 0, squares = 0, variance = 0;
    for (size_t k = x->from; k < x->to; k++) {
        const size_t at = channel * other->n + all[k].sample;
        sum += other->value[at];
        if (other->sigma) variance += other->sigma[at] * other->sigma[at];
    }
    *mean = sum / n;
    for (size_t k = x->from; k < x->to; k++) {
        const double off = other->value[channel * other->n + all[k].sample] - *mean;
        squares += off * off;
    }
    const double by_scatter = n > 1 ? sqrt(squares / (n - 1) / n) : other->sigma ? 0 : NAN;
    *sd = fmax(by_scatter, other->sigma ? sqrt(variance) / n : by_scatter);
}

/* The means [n][n_channels], then their standard deviations, as said. */
static void all_means(const ff_table *t, const ff_table *other, const reading *all, const incidence *x, size_t n,
                      const size_t *channel, double *mean)
{
    for (size_t k = 0; k < n; k++)
        for (size_t c = 0; c < t->n_channels; c++)
            mean_at(other, all, &x[k], channel[c], &mean[k * t->n_channels + c], &mean[(n + k) * t->n_channels + c]);
}

static ff_status take_means(const ff_table *t, const incidence *x, size_t n, const double *mean, const char *what, int isotropic,
                            signals *s, ff_error *err)
{
    if (n == 0) return ff_error_set(err, FF_ERR_DATA, NULL, 0, -1, "%s has no measured sample", what);
    s->how = n == 1 ? FF_MATCHED_ALL : FF_MATCHED_INCIDENCE;
    for (size_t i = 0; i < t->n; i++) {
        if (!t->valid[i]) continue;
        const double theta_i = pair_at(t, i, isotropic).at[0];
        const size_t k = n == 1 ? 0 : incidence_at(x, n, theta_i);
        if (k == n)
            return ff_error_set(err, FF_ERR_DATA, NULL, 0, -1,
                                "%s was not measured at theta_i = %g degrees, as sample %zu was; expected all incidences of the "
                                "data, or one alone",
                                what, theta_i, i + 1);
        for (size_t c = 0; c < t->n_channels; c++) {
            s->signal[c * t->n + i] = mean[k * t->n_channels + c];
            s->common[c * t->n + i] = mean[(n + k) * t->n_channels + c];
        }
    }
    return FF_OK;
}

static ff_status by_means(const ff_table *t, const ff_table *other, const finder *f, const char *what, const size_t *channel,
                          int isotropic, signals *s, ff_error *err)
{
    reading *all = malloc(other->n * sizeof *all);
    incidence *x = malloc(other->n * sizeof *x);
    const size_t n = all && x ? incidences_of(other, f, all, x) : 0;
    double *mean = malloc((2 * n + 1) * t->n_channels * sizeof *mean);
    s->common = calloc(t->n * t->n_channels, sizeof *s->common);
    ff_status status = FF_ERR_MEMORY;
    if (all && x && mean && s->common) {
        all_means(t, other, all, x, n, channel, mean);
        status = take_means(t, x, n, mean, what, isotropic, s, err);
    } else
        ff_error_set(err, FF_ERR_MEMORY, NULL, 0, -1, "no memory for the incidences of %zu samples", other->n);
    free(all);
    free(x);
    free(mean);
    return status;
}

static ff_status signals_of(const ff_table *t, const ff_table *other, const char *what, signals *s, ff_error *err)
{
    const int isotropic = t->isotropic && other->isotropic;
    finder f;
    *s = (signals){.how = FF_MATCHED_NOT};
    if (other->quantity != t->quantity)
        return ff_error_set(err, FF_ERR_UNSUPPORTED, NULL, 0, -1, "%s holds %s, the data hold %s: expected the same of both", what,
                            ff_quantity_name((int)other->quantity), ff_quantity_name((int)t->quantity));
    size_t *channel = malloc(t->n_channels * sizeof *channel);
    s->signal = calloc(t->n * t->n_channels, sizeof *s->signal);
    s->variance = other->sigma ? calloc(t->n * t->n_channels, sizeof *s->variance) : NULL;
    ff_status status = channel && s->signal && (s->variance || !other->sigma)
                           ? match_channels(t, other, what, channel, err)
                           : ff_error_set(err, FF_ERR_MEMORY, NULL, 0, -1, "no memory for the signals of %zu samples", t->n);
    if (status == FF_OK && (status = finder_make(other, isotropic, &f, err)) == FF_OK) {
        if (!by_pairs(t, other, &f, channel, isotropic, s)) {
            free(s->variance);
            s->variance = NULL;
            status = by_means(t, other, &f, what, channel, isotropic, s, err);
        }
        finder_free(&f);
    }
    free(channel);
    if (status) signals_free(s);
    return status;
}

/* ---- the values -------------------------------------------------------------------------------- */

static double at_or(const double *x, size_t k, double otherwise)
{
    return x ? x[k] : otherwise;
}

/* Value k of t: f = (s - d) / (r - d) R / pi; df/ds = R / pi / (r - d), df/dr = -f / (r - d), df/dd = (f - R / pi) / (r - d).
 * 0: the standard reads no more than the dark. */
static int calibrate_one(double scale, const signals *reference, const signals *dark, double dark_signal, size_t k, ff_table *t)
{
    const double s = t->value[k], d = at_or(dark->signal, k, dark_signal), vd = at_or(dark->variance, k, 0);
    const double vs = t->sigma ? t->sigma[k] * t->sigma[k] : 0;
    if (!reference->signal) {
        t->value[k] = s - d;
        if (t->sigma) t->sigma[k] = sqrt(vs + vd);
        return 1;
    }
    const double above = reference->signal[k] - d, f = scale * (s - d) / above, by_dark = f - scale;
    if (!(above > 0)) return 0;
    t->value[k] = f;
    if (t->sigma)
        t->sigma[k] = sqrt(scale * scale * vs + f * f * at_or(reference->variance, k, 0) + by_dark * by_dark * vd) / above;
    return 1;
}

/* The largest relative standard deviation of the standard's means above the dark; NaN where one is not known, and of pairs. */
static double error_of_means(const ff_table *t, const ff_calibration *c, const signals *reference, const signals *dark)
{
    double most = 0;
    if (!reference->common) return NAN;
    for (size_t k = 0; k < t->n * t->n_channels; k++) {
        const double above = reference->signal[k] - at_or(dark->signal, k, c->dark_signal);
        if (!t->valid[k % t->n] || !(above > 0)) continue;
        if (isnan(reference->common[k])) return NAN;
        most = fmax(most, reference->common[k] / above);
    }
    return most;
}

static ff_status calibrate(ff_table *t, const ff_calibration *c, const signals *reference, const signals *dark, size_t *n_lost,
                           ff_error *err)
{
    size_t left = 0;
    *n_lost = 0;
    for (size_t i = 0; i < t->n; i++) { /* first whether it can be done: t is changed only then */
        int sound = t->valid[i];
        for (size_t ch = 0; ch < t->n_channels && reference->signal; ch++) {
            const size_t k = ch * t->n + i;
            sound = sound && reference->signal[k] - at_or(dark->signal, k, c->dark_signal) > 0;
        }
        left += sound != 0;
    }
    if (left == 0) return ff_error_set(err, FF_ERR_DATA, NULL, 0, -1, "the standard reads no more than the dark at any sample");
    for (size_t i = 0; i < t->n; i++) {
        int sound = t->valid[i];
        for (size_t ch = 0; ch < t->n_channels && sound; ch++)
            sound = calibrate_one(c->reflectance / pi, reference, dark, c->dark_signal, ch * t->n + i, t);
        if (sound || !t->valid[i]) continue;
        t->valid[i] = 0;
        for (size_t ch = 0; ch < t->n_channels; ch++) t->value[ch * t->n + i] = 0;
        (*n_lost)++;
    }
    if (reference->signal) t->quantity = FF_BRDF;
    if (t->kept && t->kept_free) t->kept_free(t->kept); /* a file of the same kind would have the signals again */
    t->kept = NULL, t->kept_free = NULL, t->kept_share = NULL;
    return FF_OK;
}

static void count_again(ff_table *t)
{
    t->n_invalid = t->n_negative = 0;
    for (size_t i = 0; i < t->n; i++) {
        int negative = 0;
        for (size_t c = 0; c < t->n_channels; c++) negative |= t->value[c * t->n + i] < 0;
        t->n_invalid += !t->valid[i];
        t->n_negative += t->valid[i] && negative;
    }
}

ff_status ff_table_calibrate(ff_table *t, const ff_calibration *c, ff_calibrated *out, ff_error *err)
{
    signals reference = {.how = FF_MATCHED_NOT}, dark = {.how = FF_MATCHED_NOT};
    size_t n_lost = 0;
    if (c->reference && !(c->reflectance > 0 && isfinite(c->reflectance)))
        return ff_error_set(err, FF_ERR_RANGE, NULL, 0, -1, "a standard of reflectance %g; expected one above 0", c->reflectance);
    if (!isfinite(c->dark_signal)) return ff_error_set(err, FF_ERR_RANGE, NULL, 0, -1, "a dark signal of %g", c->dark_signal);
    if (c->dark_signal != 0 && !c->dark && t->quantity == FF_BRDF_COS)
        return ff_error_set(
            err, FF_ERR_UNSUPPORTED, NULL, 0, -1,
            "the values were divided by the cosine of theta_o, which one dark signal was not; expected values as they "
            "were read, or a file of the dark");
    ff_status status = c->reference ? signals_of(t, c->reference, "the standard", &reference, err) : FF_OK;
    if (!status && c->dark) status = signals_of(t, c->dark, "the dark", &dark, err);
    const double error = status ? NAN : error_of_means(t, c, &reference, &dark);
    if (!status) status = calibrate(t, c, &reference, &dark, &n_lost, err);
    if (!status) count_again(t);
    if (!status && out) *out = (ff_calibrated){reference.how, dark.how, error, n_lost};
    signals_free(&reference);
    signals_free(&dark);
    return status;
}
