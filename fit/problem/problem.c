/* From a table to blocks of planes: which samples are used, their weights and targets, and the geometry that no parameter changes.
 */
#include "internal_problem.h"
#include "fit/losses/internal_loss.h"
#include "base/internal_order.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum {
    FF_SUBSAMPLE = 12000,   /* samples that a start is searched on              */
    FF_SPARSE = 3000,       /* that the noise of the data is estimated on       */
    FF_MIDDLE_FROM = 200000 /* problems that have a middle have more than these */
};
enum { FF_SLAB = 2048 }; /* samples of a table looked at in one go; its directions fit in the second-level cache */

/* ---- selection ------------------------------------------------------------------------------- */

enum { FF_USED = 0, FF_INVALID, FF_BELOW, FF_GRAZING, FF_NEGATIVE, FF_STATES };

typedef struct slab_result {
    size_t count[FF_STATES], negative;
    double weight;         /* of the used samples                   */
    double cos_lo, cos_hi; /* of both directions of the used samples */
} slab_result;

/* Of a block: values that are known from one side; the largest value and how many samples have it; the datum that weighs most. */
typedef struct block_result {
    size_t saturated, below_noise, at_top;
    double top;
    double most; /* |weight * target|; infinite also where that is not a number */
    size_t most_sample, most_channel;
} block_result;

/* Everything the building needs; read by all threads. */
typedef struct build {
    const ff_table *t;
    const ff_fit_options *o;
    struct ff_problem *p;
    ff_weighting weighting;
    const size_t *channel; /* [n_from] table channels that are read */
    size_t n_from;
    double cos_max;  /* cos(max_theta) */
    uint32_t *index; /* [table n]; the used samples of slab s from index + s FF_SLAB, then packed */
    slab_result *slab;
    block_result *block;
    double *channel_sum; /* [slabs][n_channels] of |y| over used samples */
    double weight_scale; /* 1 / mean weight */
    double *buffer;      /* [threads][per_thread] */
    float *size;         /* [used] largest weighted value of each sample */
    size_t per_thread;
    int needs_sigma; /* for the weights or for the noise floor */
} build;

/* Values of problem channel c for table samples first .. first+n-1. scratch [n]. */
static void values_of(const build *b, size_t c, size_t first, size_t n, double *out, double *scratch)
{
    if (b->p->n_channels == b->n_from) {
        ff_table_values(b->t, b->channel[c], first, n, out);
        return;
    }
    memset(out, 0, n * sizeof *out); /* the mean of all */
    for (size_t k = 0; k < b->n_from; k++) {
        ff_table_values(b->t, b->channel[k], first, n, scratch);
        for (size_t i = 0; i < n; i++) out[i] += scratch[i] / (double)b->n_from;
    }
}

static void sigmas_of(const build *b, size_t c, size_t first, size_t n, double *out, double *scratch)
{
    if (b->p->n_channels == b->n_from) {
        ff_table_sigmas(b->t, b->channel[c], first, n, out);
        return;
    }
    memset(out, 0, n * sizeof *out);
    for (size_t k = 0; k < b->n_from; k++) {
        ff_table_sigmas(b->t, b->channel[k], first, n, scratch);
        for (size_t i = 0; i < n; i++) out[i] += scratch[i] * scratch[i];
    }
    for (size_t i = 0; i < n; i++) out[i] = sqrt(out[i]) / (double)b->n_from;
}

static void weights_of(const build *b, size_t first, size_t n, double *out)
{
    if (b->weighting == FF_WEIGHT_SOLID_ANGLE)
        ff_table_weights(b->t, first, n, out);
    else
        for (size_t i = 0; i < n; i++) out[i] = 1;
}

/* What lies below the noise floor is only known to be at most that. */
static int acceptable(const build *b, double y, double x)
{
    return isfinite(y) && ff_loss_has_value(b->o->loss, fmax(y, b->o->noise_floor), x);
}

static void look_at_slab(void *context, size_t s, int worker)
{
    const build *b = context;
    const struct ff_problem *p = b->p;
    const size_t first = s * FF_SLAB, n = b->t->n - first < FF_SLAB ? b->t->n - first : FF_SLAB, C = p->n_channels;
    double *buffer = b->buffer + (size_t)worker * b->per_thread, *w[6], *weight = buffer + 6 * FF_SLAB, *y = weight + FF_SLAB,
           *scratch = y + FF_SLAB;
    unsigned char state[FF_SLAB], negative[FF_SLAB];
    for (int k = 0; k < 6; k++) w[k] = buffer + k * FF_SLAB;
    ff_table_directions(b->t, first, n, w);
    weights_of(b, first, n, weight);
    for (size_t i = 0; i < n; i++) {
        const double iz = w[2][i], oz = w[5][i];
        negative[i] = 0;
        if (!b->t->valid[first + i] || !(weight[i] >= 0) || !isfinite(weight[i]))
            state[i] = FF_INVALID;
        else if (!(iz > FF_COS_MIN && oz > FF_COS_MIN))
            state[i] = FF_BELOW;
        else
            state[i] = iz < b->cos_max || oz < b->cos_max ? FF_GRAZING : FF_USED;
    }
    for (size_t c = 0; c < C; c++) {
        double *sum = &b->channel_sum[s * C + c];
        values_of(b, c, first, n, y, scratch);
        for (size_t i = 0; i < n; i++) {
            if (state[i] != FF_USED) continue;
            if (!acceptable(b, y[i], w[2][i])) state[i] = FF_INVALID;
            if (y[i] < 0) negative[i] = 1;
            if (y[i] < 0 && b->o->drop_negative) state[i] = FF_NEGATIVE;
        }
        if (b->weighting == FF_WEIGHT_SIGMA) {
            sigmas_of(b, c, first, n, scratch, buffer + 9 * FF_SLAB);
            for (size_t i = 0; i < n; i++)
                if (state[i] == FF_USED && !(scratch[i] > 0 && isfinite(scratch[i]))) state[i] = FF_INVALID;
        }
        *sum = 0;
        for (size_t i = 0; i < n; i++)
            if (state[i] == FF_USED) *sum += fabs(y[i]);
    }
    slab_result r = {.cos_lo = 1};
    for (size_t i = 0; i < n; i++) {
        r.count[state[i]]++;
        if (state[i] != FF_USED) continue;
        b->index[first + r.count[FF_USED] - 1] = (uint32_t)(first + i);
        r.cos_lo = fmin(r.cos_lo, fmin(w[2][i], w[5][i]));
        r.cos_hi = fmax(r.cos_hi, fmax(w[2][i], w[5][i]));
        r.negative += negative[i];
        r.weight += weight[i];
    }
    b->slab[s] = r;
}

/* ---- blocks ---------------------------------------------------------------------------------- */

/* Directions, weights and channel values of the samples of one block, gathered from their places in the table. */
typedef struct gathered {
    double w[6][FF_BLOCK], weight[FF_BLOCK];
} gathered;

/* Runs fn over maximal ranges of consecutive table indices inside index[0..n). */
static size_t run_length(const uint32_t *index, size_t i, size_t n)
{
    size_t k = i + 1;
    while (k < n && index[k] == index[k - 1] + 1) k++;
    return k - i;
}

static void gather(const build *b, const uint32_t *index, size_t n, gathered *g)
{
    for (size_t i = 0, count; i < n; i += count) {
        count = run_length(index, i, n);
        double *const planes[6] = {g->w[0] + i, g->w[1] + i, g->w[2] + i, g->w[3] + i, g->w[4] + i, g->w[5] + i};
        ff_table_directions(b->t, index[i], count, planes);
        weights_of(b, index[i], count, g->weight + i);
    }
    for (size_t i = n; i < FF_BLOCK; i++) { /* padding: below the horizon, weight 0 */
        for (int k = 0; k < 6; k++) g->w[k][i] = k % 3 == 2 ? -1 : 0;
        g->weight[i] = 0;
    }
}

/* +1: the value is only known to be at least *y, which becomes the saturation; -1: at most, the noise floor; else 0. */
static int known_side(const ff_fit_options *o, double sigma, double *y)
{
    const double floor = o->noise_sigmas > 0 ? fmax(o->noise_floor, o->noise_sigmas * sigma) : o->noise_floor;
    const int side = *y >= o->saturation ? 1 : *y < floor ? -1 : 0;
    if (side) *y = side > 0 ? o->saturation : floor;
    return side;
}

void ff_problem_aim(const struct ff_problem *p, size_t block, size_t c, const double *x)
{
    const double *value = ff_problem_plane(p, block, p->value + (int)c),
                 *sample_weight = ff_problem_plane(p, block, p->sample_weight);
    double *weight = ff_problem_plane(p, block, p->weight + p->weight_stride * (int)c), factor[FF_BLOCK];
    ff_loss_targets(p->loss, FF_BLOCK, value, x, ff_problem_plane(p, block, p->target + (int)c));
    ff_loss_factors(p->loss, FF_BLOCK, value, x, p->least[c], factor);
    for (size_t i = 0; i < FF_BLOCK; i++) weight[i] = sample_weight[i] > 0 ? sample_weight[i] * factor[i] : 0;
}

static void fill_targets(const build *b, size_t block, const uint32_t *index, size_t n, const gathered *g)
{
    struct ff_problem *p = b->p;
    double scratch[FF_BLOCK], sigma[FF_BLOCK] = {0}, y[FF_BLOCK], x[FF_BLOCK];
    double *sample_weight = ff_problem_plane(p, block, p->sample_weight);
    for (size_t i = 0; i < FF_BLOCK; i++) x[i] = i < n ? g->w[2][i] : 1;
    for (int i = 0; i < FF_BLOCK; i++) sample_weight[i] = sqrt(g->weight[i] * b->weight_scale);
    for (size_t c = 0; c < p->n_channels; c++) {
        for (size_t i = 0, count; i < n; i += count) {
            count = run_length(index, i, n);
            values_of(b, c, index[i], count, y + i, scratch);
            if (b->needs_sigma) sigmas_of(b, c, index[i], count, sigma + i, scratch);
        }
        double *value = ff_problem_plane(p, block, p->value + (int)c), *sides = NULL;
        if (p->side >= 0) sides = ff_problem_plane(p, block, p->side + (int)c);
        for (size_t i = 0; i < FF_BLOCK; i++) {
            const int in = i < n;
            double v = in ? y[i] : 0;
            if (sides) {
                const int side = in ? known_side(b->o, sigma[i], &v) : 0;
                sides[i] = side;
                b->block[block].saturated += side > 0;
                b->block[block].below_noise += side < 0;
            }
            value[i] = v;
        }
        ff_problem_aim(p, block, c, x);
        if (b->weighting == FF_WEIGHT_SIGMA) { /* the residual in standard deviations: those of y pass through g */
            double *weight = ff_problem_plane(p, block, p->weight + p->weight_stride * (int)c);
            ff_loss_slopes(p->loss, FF_BLOCK, value, x, scratch);
            for (size_t i = 0; i < FF_BLOCK; i++) weight[i] = i < n ? 1 / (sigma[i] * scratch[i]) : 0;
        }
    }
}

static void note_most(block_result *r, double weighted, size_t sample, size_t channel)
{
    const double size = weighted <= INFINITY ? weighted : INFINITY;
    if (size <= r->most) return;
    r->most = size;
    r->most_sample = sample;
    r->most_channel = channel;
}

static void build_block(void *context, size_t block, int worker)
{
    const build *b = context;
    struct ff_problem *p = b->p;
    (void)worker;
    const size_t first = block * FF_BLOCK, n = p->n - first < FF_BLOCK ? p->n - first : FF_BLOCK;
    block_result *result = &b->block[block];
    gathered g;
    gather(b, b->index + first, n, &g);
    const ff_dirs w = {g.w[0], g.w[1], g.w[2], g.w[3], g.w[4], g.w[5]};
    ff_geometry planes;
    for (int k = 0; k < FF_G_COUNT; k++) planes.plane[k] = p->geometry[k] < 0 ? NULL : ff_problem_plane(p, block, p->geometry[k]);
    ff_kernels_get(p->isa)->geometry(&w, FF_BLOCK, &planes);
    if (p->rules) ff_problem_put_directions(p, block, &w);
    fill_targets(b, block, b->index + first, n, &g);
    for (size_t i = 0; i < FF_BLOCK; i++) {
        p->cosine[0][first + i] = (float)g.w[2][i];
        p->cosine[1][first + i] = (float)g.w[5][i];
    }
    for (size_t i = 0; i < n; i++) {
        double largest = 0, value = -INFINITY;
        for (size_t c = 0; c < p->n_channels; c++) {
            const double w = ff_problem_plane(p, block, p->weight + p->weight_stride * (int)c)[i];
            const double weighted = fabs(w * ff_problem_plane(p, block, p->target + (int)c)[i]);
            note_most(result, weighted, b->index[first + i], c);
            largest = fmax(largest, weighted);
            value = fmax(value, ff_problem_plane(p, block, p->value + (int)c)[i]);
        }
        b->size[first + i] = (float)largest;
        if (i == 0 || value > result->top) result->at_top = 0, result->top = value;
        result->at_top += value == result->top;
    }
}

/* ---- the whole ------------------------------------------------------------------------------- */

static ff_status check_options(const ff_table *t, const ff_fit_options *o, ff_error *err)
{
    const ff_status status = ff_fit_options_check(o, err);
    if (status) return status;
    if (o->only_channel >= 0 && (size_t)o->only_channel >= t->n_channels)
        return ff_error_set(err, FF_ERR_RANGE, NULL, 0, -1, "channel %d does not exist: the data have %zu", o->only_channel,
                            t->n_channels);
    if (!ff_isa_available(o->isa))
        return ff_error_set(err, FF_ERR_UNSUPPORTED, NULL, 0, -1, "this processor does not have the instruction set asked for");
    if (t->n == 0 || t->n_channels == 0) return ff_error_set(err, FF_ERR_DATA, NULL, 0, -1, "the data have no samples");
    if (t->n > UINT32_MAX)
        return ff_error_set(err, FF_ERR_UNSUPPORTED, NULL, 0, -1, "more than %u samples in one table", UINT32_MAX);
    return FF_OK;
}

static ff_status check_noise(const ff_table *t, const ff_fit_options *o, ff_error *err)
{
    if (o->noise_sigmas > 0 && !t->sigma)
        return ff_error_set(err, FF_ERR_UNSUPPORTED, NULL, 0, -1,
                            "the data have no standard deviations to tell what is below the noise");
    return FF_OK;
}

static ff_status choose_weighting(const ff_table *t, ff_weighting asked, ff_weighting *out, ff_error *err)
{
    if (asked == FF_WEIGHT_SOLID_ANGLE && !ff_table_has_weights(t))
        return ff_error_set(err, FF_ERR_UNSUPPORTED, NULL, 0, -1,
                            "these samples are not a grid and have no weight column: solid-angle weights are not defined");
    if (asked == FF_WEIGHT_SIGMA && !t->sigma)
        return ff_error_set(err, FF_ERR_UNSUPPORTED, NULL, 0, -1, "the data have no standard deviations to weight by");
    *out = asked;
    if (asked == FF_WEIGHT_AUTO)
        *out = ff_table_has_weights(t) ? FF_WEIGHT_SOLID_ANGLE : t->sigma ? FF_WEIGHT_SIGMA : FF_WEIGHT_SAMPLE;
    if (asked == FF_WEIGHT_NOISE) /* until a fit has shown the noise */
        *out = ff_table_has_weights(t) ? FF_WEIGHT_SOLID_ANGLE : FF_WEIGHT_SAMPLE;
    return FF_OK;
}

/* Numbers the planes of a block. */
static void lay_out(struct ff_problem *p, const ff_model *models, size_t n_models, const ff_fit_options *o, int isotropic_table,
                    ff_weighting weighting)
{
    uint32_t need = 0;
    for (size_t i = 0; i < n_models; i++) {
        const ff_shape shape = ff_layout_shape(&models[i], isotropic_table, o->shape, o->mean_slope);
        need |= ff_model_planes(&models[i], ff_layout_mode(&models[i], shape, o->mean_slope));
    }
    const int curved = ff_loss_is_curved(p->loss);
    if (ff_loss_reads_cosine(p->loss) || !(need & (1u << FF_G_TI2 | 1u << FF_G_TIX))) need |= 1u << FF_G_COS_I;
    int next = 0;
    const int C = (int)p->n_channels;
    for (int k = 0; k < FF_G_COUNT; k++) p->geometry[k] = need & 1u << k ? next++ : -1;
    p->weight_stride = ff_loss_weighs_data(p->loss) || weighting == FF_WEIGHT_SIGMA;
    p->weight = next;
    next += p->weight_stride ? C : 1;
    p->sample_weight = next++;
    p->value = next;
    next += C;
    p->target = p->value;
    if (curved) {
        p->target = next;
        next += C;
    }
    p->direction = -1;
    if (p->rules) {
        p->direction = next;
        next += 6;
    }
    p->side = -1;
    if (isfinite(o->saturation) || isfinite(o->noise_floor) || o->noise_sigmas > 0) {
        p->side = next;
        next += C;
    }
    p->n_planes = (size_t)next;
}

static ff_status name_channels(const ff_table *t, struct ff_problem *p, const ff_fit_options *o, const size_t *channel)
{
    p->channel_name = calloc(p->n_channels, sizeof *p->channel_name);
    p->channel_mean = calloc(p->n_channels, sizeof *p->channel_mean);
    p->table_channel = calloc(t->n_channels, sizeof *p->table_channel);
    if (!p->channel_name || !p->channel_mean || !p->table_channel) return FF_ERR_MEMORY;
    for (size_t c = 0; c < t->n_channels; c++) strcpy(p->table_channel[c], t->channels[c].name);
    for (size_t c = 0; c < p->n_channels; c++)
        strcpy(p->channel_name[c],
               o->channels == FF_CHANNELS_MEAN && o->only_channel < 0 && t->n_channels > 1 ? "mean" : t->channels[channel[c]].name);
    return FF_OK;
}

static void pack_index(build *b, size_t slabs)
{
    size_t n = 0;
    for (size_t s = 0; s < slabs; s++) {
        memmove(b->index + n, b->index + s * FF_SLAB, b->slab[s].count[FF_USED] * sizeof *b->index);
        n += b->slab[s].count[FF_USED];
    }
}

/* Squares of residuals are summed, products of their derivatives too: all of them stay numbers up to here. */
#define MOST_WEIGHTED 1e140

static ff_status check_size(const build *b, ff_error *err)
{
    const double degree = 3.14159265358979323846 / 180;
    const block_result *most = b->block;
    double w[6], y, scratch, *const planes[6] = {w, w + 1, w + 2, w + 3, w + 4, w + 5};
    for (size_t k = 1; k < b->p->n_blocks; k++)
        if (b->block[k].most > most->most) most = &b->block[k];
    if (most->most <= MOST_WEIGHTED) return FF_OK;
    ff_table_directions(b->t, most->most_sample, 1, planes);
    values_of(b, most->most_channel, (uint32_t)most->most_sample, 1, &y, &scratch);
    return ff_error_set(err, FF_ERR_DATA, NULL, 0, -1,
                        "sample %zu, theta_i = %.6g and theta_o = %.6g degrees, channel %s: the value %g weighs %.3g, expected at "
                        "most %g: its square cannot be summed; is the value or its standard deviation in another unit?",
                        most->most_sample, acos(fmin(w[2], 1)) / degree, acos(fmin(w[5], 1)) / degree,
                        b->p->channel_name[most->most_channel], y, most->most, MOST_WEIGHTED);
}

static ff_status nothing_left(const ff_selection *s, const ff_fit_options *o, ff_error *err)
{
    char dropped[64] = "", positive[64] = "";
    if (!ff_loss_has_value(o->loss, 0, 1))
        snprintf(positive, sizeof positive, "; the loss %s has no value at or below 0", ff_loss_name((int)o->loss));
    if (s->dropped) snprintf(dropped, sizeof dropped, "%zu are negative", s->dropped);
    return ff_error_set(err, FF_ERR_DATA, NULL, 0, -1,
                        "no sample is left to fit: of %zu, %zu are not valid measurements, %zu lie at or below the horizon, %zu "
                        "beyond %g degrees%s%s%s",
                        s->samples, s->invalid, s->below_horizon, s->grazing, o->max_theta * (180 / 3.14159265358979323846),
                        s->dropped ? ", " : "", dropped, positive);
}

#define LEAST_OF_MEAN 1e-3
#define LEAST_SHARE   0.05 /* of the values above 0 that may lie below it */
enum { LEAST_LOOKED_AT = 20000 };

/* What a datum counts as at least where a loss divides by it: little beside the mean, but of data that span many decades no more
 * than what is among their darkest. v [LEAST_LOOKED_AT]. */
static double least_of_channel(const build *b, size_t c, double *v)
{
    const size_t n = b->p->selection.used, step = n / LEAST_LOOKED_AT + 1;
    size_t count = 0;
    double one, scratch;
    for (size_t i = 0; i < n; i += step) {
        values_of(b, c, b->index[i], 1, &one, &scratch);
        if (one != 0) v[count++] = fabs(one);
    }
    const double mean = LEAST_OF_MEAN * b->p->channel_mean[c];
    if (count == 0) return mean;
    qsort(v, count, sizeof *v, ff_ascending);
    return fmin(mean, v[(size_t)(LEAST_SHARE * (double)count)]);
}

static ff_status find_least(build *b)
{
    const int looks = ff_loss_weighs_data(b->p->loss);
    double *v = looks ? malloc(LEAST_LOOKED_AT * sizeof *v) : NULL;
    b->p->least = calloc(b->p->n_channels, sizeof *b->p->least);
    if (!b->p->least || (looks && !v)) {
        free(v);
        return FF_ERR_MEMORY;
    }
    for (size_t c = 0; c < b->p->n_channels && looks; c++) b->p->least[c] = least_of_channel(b, c, v);
    free(v);
    return FF_OK;
}

static ff_status build_all(build *b, const ff_model *models, size_t n_models, ff_error *err)
{
    struct ff_problem *p = b->p;
    const ff_table *t = b->t;
    const size_t slabs = (t->n + FF_SLAB - 1) / FF_SLAB, C = p->n_channels, threads = (size_t)ff_pool_threads(p->pool);
    b->per_thread = 10 * FF_SLAB;
    b->index = malloc(slabs * FF_SLAB * sizeof *b->index);
    b->slab = calloc(slabs, sizeof *b->slab);
    b->channel_sum = calloc(slabs * C, sizeof *b->channel_sum);
    b->buffer = malloc(threads * b->per_thread * sizeof *b->buffer);
    if (!b->index || !b->slab || !b->channel_sum || !b->buffer)
        return ff_error_set(err, FF_ERR_MEMORY, NULL, 0, -1, "out of memory");
    ff_pool_run(p->pool, slabs, look_at_slab, b);
    ff_selection *sel = &p->selection;
    double weight = 0, cos_lo = 1, cos_hi = FF_COS_MIN;
    for (size_t s = 0; s < slabs; s++) {
        cos_lo = fmin(cos_lo, b->slab[s].cos_lo);
        cos_hi = fmax(cos_hi, b->slab[s].cos_hi);
        sel->used += b->slab[s].count[FF_USED];
        sel->invalid += b->slab[s].count[FF_INVALID];
        sel->below_horizon += b->slab[s].count[FF_BELOW];
        sel->grazing += b->slab[s].count[FF_GRAZING];
        sel->dropped += b->slab[s].count[FF_NEGATIVE];
        sel->negative += b->slab[s].negative;
        weight += b->slab[s].weight;
        for (size_t c = 0; c < C; c++) p->channel_mean[c] += b->channel_sum[s * C + c];
    }
    if (sel->used == 0 || !(weight > 0)) return nothing_left(sel, b->o, err);
    for (size_t c = 0; c < C; c++) p->channel_mean[c] /= (double)sel->used;
    b->weight_scale = (double)sel->used / weight;
    p->tan2_hi = fmax(1 / (cos_lo * cos_lo) - 1, 1e-12);
    p->tan2_lo = cos_hi < 1 - 1e-12 ? 1 / (cos_hi * cos_hi) - 1 : 0;
    ff_status status = ff_problem_see_through(p, b->o->aperture, err);
    if (status) return status;
    pack_index(b, slabs);
    if (ff_copies_leave_out(t, b->index, &sel->used, &sel->copies))
        return ff_error_set(err, FF_ERR_MEMORY, NULL, 0, -1, "out of memory");
    if (find_least(b)) return ff_error_set(err, FF_ERR_MEMORY, NULL, 0, -1, "out of memory");
    if (ff_order_by_place(t, p->pool, b->index, sel->used)) return ff_error_set(err, FF_ERR_MEMORY, NULL, 0, -1, "out of memory");
    p->n = sel->used;
    p->n_blocks = (p->n + FF_BLOCK - 1) / FF_BLOCK;
    lay_out(p, models, n_models, b->o, t->isotropic, b->weighting);
    p->data = ff_block_memory(ff_problem_doubles(p) * sizeof *p->data);
    if (!p->data) return ff_error_set(err, FF_ERR_MEMORY, NULL, 0, -1, "out of memory for %zu samples", p->n);
    b->size = malloc(p->n * sizeof *b->size);
    b->block = calloc(p->n_blocks, sizeof *b->block);
    p->cosine[0] = malloc(2 * p->n_blocks * FF_BLOCK * sizeof *p->cosine[0]);
    if (p->cosine[0]) p->cosine[1] = p->cosine[0] + p->n_blocks * FF_BLOCK;
    if (!b->size || !b->block || !p->cosine[0]) return ff_error_set(err, FF_ERR_MEMORY, NULL, 0, -1, "out of memory");
    ff_pool_run(p->pool, p->n_blocks, build_block, b);
    sel->top = -INFINITY;
    for (size_t k = 0; k < p->n_blocks; k++) {
        sel->saturated += b->block[k].saturated;
        sel->below_noise += b->block[k].below_noise;
        if (b->block[k].top > sel->top) sel->at_top = 0, sel->top = b->block[k].top;
        if (b->block[k].top == sel->top) sel->at_top += b->block[k].at_top;
    }
    status = check_size(b, err);
    if (status) return status;
    if (sel->saturated || !ff_problem_looks_saturated(p, t, b->index)) sel->at_top = 0;
    p->spacing = ff_problem_spacing_of(t, b->index, p->n);
    p->index = b->index; /* the problem's from here on */
    b->index = NULL;
    status = ff_problem_subsample(p, b->size, FF_SUBSAMPLE, 0, &p->subsample);
    p->sparse = p->subsample;
    if (!status && p->n > FF_SPARSE && b->o->errors != FF_ERRORS_RESIDUALS)
        status = ff_problem_subsample(p, b->size, FF_SPARSE, 0, &p->sparse);
    p->subsample_linear = p->subsample; /* a linear loss is its own surrogate */
    if (!status && ff_loss_is_curved(p->loss)) status = ff_problem_subsample(p, b->size, FF_SUBSAMPLE, 1, &p->subsample_linear);
    if (!status && p->n > FF_MIDDLE_FROM) status = ff_problem_subsample(p, b->size, p->n / 8, 0, &p->middle);
    return status ? ff_error_set(err, status, NULL, 0, -1, "out of memory") : FF_OK;
}

ff_status ff_problem_make(const ff_table *t, const ff_model *models, size_t n_models, const ff_fit_options *o, ff_problem **out,
                          ff_error *err)
{
    build b = {.t = t, .o = o};
    ff_status status = check_options(t, o, err);
    if (!status && n_models == 0) status = ff_error_set(err, FF_ERR_RANGE, NULL, 0, -1, "a problem needs at least one model");
    if (!status) status = check_noise(t, o, err);
    if (!status) status = choose_weighting(t, o->weighting, &b.weighting, err);
    if (status) return status;
    struct ff_problem *p = calloc(1, sizeof *p);
    size_t *channel = calloc(t->n_channels, sizeof *channel);
    if (p) p->pool = ff_pool_new(o->threads ? o->threads : ff_threads_default());
    if (!p || !channel || !p->pool) {
        free(channel);
        ff_problem_free(p);
        return ff_error_set(err, FF_ERR_MEMORY, NULL, 0, -1, "out of memory");
    }
    b.n_from = o->only_channel >= 0 ? 1 : t->n_channels;
    for (size_t c = 0; c < b.n_from; c++) channel[c] = o->only_channel >= 0 ? (size_t)o->only_channel : c;
    b.channel = channel;
    b.needs_sigma = b.weighting == FF_WEIGHT_SIGMA || o->noise_sigmas > 0;
    b.p = p;
    b.cos_max = o->max_theta >= 1.5707963267948966 ? 0 : cos(o->max_theta) * (1 - 1e-12); /* a sample at exactly max_theta is in */
    p->n_channels = o->channels == FF_CHANNELS_MEAN ? 1 : b.n_from;
    p->n_table_channels = t->n_channels;
    p->only_channel = o->only_channel;
    p->loss = o->loss;
    p->isa = o->isa;
    p->selection =
        (ff_selection){.samples = t->n, .n_channels = p->n_channels, .weighting = b.weighting, .isotropic = t->isotropic};
    status = name_channels(t, p, o, channel) ? ff_error_set(err, FF_ERR_MEMORY, NULL, 0, -1, "out of memory")
                                             : build_all(&b, models, n_models, err);
    if (!status && ff_brightest_find(t, o->max_theta, &p->selection.brightest))
        status = ff_error_set(err, FF_ERR_MEMORY, NULL, 0, -1, "out of memory");
    free(b.index);
    free(b.slab);
    free(b.block);
    free(b.channel_sum);
    free(b.buffer);
    free(b.size);
    free(channel);
    if (status) {
        ff_problem_free(p);
        return status;
    }
    *out = p;
    return FF_OK;
}

void ff_problem_free(ff_problem *p)
{
    if (!p) return;
    if (p->subsample_linear != p->subsample) ff_problem_subsample_free(p->subsample_linear);
    if (p->sparse != p->subsample) ff_problem_subsample_free(p->sparse);
    ff_problem_subsample_free(p->subsample);
    ff_problem_subsample_free(p->middle);
    ff_pool_free(p->pool);
    free(p->data);
    free(p->channel_name);
    free(p->table_channel);
    free(p->channel_mean);
    free(p->least);
    free(p->index);
    free((float *)(uintptr_t)p->unit);
    free((float *)(uintptr_t)p->own_factor);
    free(p->cosine[0]);
    free((ff_rules *)(uintptr_t)p->rules);
    free(p);
}

void ff_problem_selection(const ff_problem *p, ff_selection *out)
{
    *out = p->selection;
}

const ff_selection *ff_problem_selected(const ff_problem *p)
{
    return &p->selection;
}

const char *ff_problem_channel_name(const ff_problem *p, size_t c)
{
    return c < p->n_channels ? p->channel_name[c] : NULL;
}
