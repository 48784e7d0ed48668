/* From a table to blocks of planes: which samples are used, their weights and targets, and the geometry that no parameter changes.
 */
#define _GNU_SOURCE /* madvise */
#include "internal_fit.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>

enum { FF_THIN = 12000, FF_MIDDLE_FROM = 200000 }; /* samples that a start is searched on; problems that have a middle */
enum { FF_SLAB = 2048 }; /* samples of a table looked at in one go; its directions fit in the second-level cache */

/* Memory of the blocks, in large pages where the system has them: a pass walks through all of it. */
static double *block_memory(size_t bytes)
{
    const size_t page = (size_t)1 << 21, size = (bytes + page - 1) / page * page;
    if (bytes < page) return aligned_alloc(64, (bytes + 63) / 64 * 64);
    double *data = aligned_alloc(page, size);
    if (data) madvise(data, size, MADV_HUGEPAGE); /* a hint: nothing depends on it */
    return data;
}

/* ---- losses as the samples see them
 * ---------------------------------------------------------------------------------------------- */

#define FF_CUBE_ROOT_E2   1e-16 /* as in pass_kernels.c */
#define FF_RELATIVE_FLOOR 1e-3

/* g(y) of a loss; linear losses keep y. x = cos(theta_i). */
static double target_of(ff_loss loss, double y, double x)
{
    if (loss == FF_LOSS_LOG) return log1p(y * x);
    if (loss == FF_LOSS_CUBE_ROOT) return y * x / cbrt(y * x * y * x + FF_CUBE_ROOT_E2);
    return y;
}

static int is_curved(ff_loss loss)
{
    return loss == FF_LOSS_LOG || loss == FF_LOSS_CUBE_ROOT;
}

/* d g / d f at f = y of a curved loss. */
static double slope_of(ff_loss loss, double y, double x)
{
    const double u = y * x, s = u * u + FF_CUBE_ROOT_E2;
    return loss == FF_LOSS_LOG ? x / (1 + u) : x * (u * u / 3 + FF_CUBE_ROOT_E2) / (s * cbrt(s));
}

/* What multiplies g(f) - g(y) for a sample of unit weight: for linear losses their factor, for the others 1. */
static double loss_factor(ff_loss loss, double y, double x, double floor)
{
    if (loss == FF_LOSS_COSINE) return x;
    if (loss == FF_LOSS_RELATIVE) return 1 / fmax(y, floor);
    return 1;
}

/* ---- selection
 * --------------------------------------------------------------------------------------------------------------------- */

enum { FF_USED = 0, FF_INVALID, FF_BELOW, FF_GRAZING };

typedef struct slab_result {
    size_t count[4], negative;
    double weight; /* of the used samples */
} slab_result;

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
    double *channel_sum; /* [slabs][n_channels] of |y| over used samples */
    double weight_scale; /* 1 / mean weight */
    double *floors;      /* [n_channels] */
    double *buffer;      /* [threads][per_thread] */
    float *size;         /* [used] largest weighted value of each sample */
    size_t per_thread;
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

/* A loss that needs 1 + y cos > 0 cannot use a datum below -1/cos. */
static int acceptable(const build *b, double y, double x)
{
    return isfinite(y) && (b->o->loss != FF_LOSS_LOG || y * x > -0.999);
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
    slab_result r = {{0}, 0, 0};
    for (size_t i = 0; i < n; i++) {
        r.count[state[i]]++;
        if (state[i] != FF_USED) continue;
        b->index[first + r.count[FF_USED] - 1] = (uint32_t)(first + i);
        r.negative += negative[i];
        r.weight += weight[i];
    }
    b->slab[s] = r;
}

/* ---- blocks
 * ------------------------------------------------------------------------------------------------------------------------ */

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

static void fill_targets(const build *b, size_t block, const uint32_t *index, size_t n, const gathered *g)
{
    struct ff_problem *p = b->p;
    double scratch[FF_BLOCK], sigma[FF_BLOCK], y[FF_BLOCK];
    double *sample_weight = ff_problem_plane(p, block, p->sample_weight);
    for (int i = 0; i < FF_BLOCK; i++) sample_weight[i] = sqrt(g->weight[i] * b->weight_scale);
    for (size_t c = 0; c < p->n_channels; c++) {
        for (size_t i = 0, count; i < n; i += count) {
            count = run_length(index, i, n);
            values_of(b, c, index[i], count, y + i, scratch);
            if (b->weighting == FF_WEIGHT_SIGMA) sigmas_of(b, c, index[i], count, sigma + i, scratch);
        }
        double *weight = ff_problem_plane(p, block, p->weight + p->weight_stride * (int)c),
               *target = ff_problem_plane(p, block, p->target + (int)c);
        double *value = ff_problem_plane(p, block, p->value + (int)c);
        for (size_t i = 0; i < FF_BLOCK; i++) {
            const int in = i < n;
            const double x = in ? g->w[2][i] : 1, v = in ? y[i] : 0;
            value[i] = v;
            target[i] = target_of(p->loss, v, x);
            if (b->weighting == FF_WEIGHT_SIGMA) /* the residual in standard deviations: those of y pass through g */
                weight[i] = in ? 1 / (sigma[i] * (is_curved(p->loss) ? slope_of(p->loss, v, x) : 1)) : 0;
            else
                weight[i] = in ? sample_weight[i] * loss_factor(p->loss, v, x, b->floors[c]) : 0;
        }
    }
}

static void build_block(void *context, size_t block, int worker)
{
    const build *b = context;
    struct ff_problem *p = b->p;
    (void)worker;
    const size_t first = block * FF_BLOCK, n = p->n - first < FF_BLOCK ? p->n - first : FF_BLOCK;
    gathered g;
    gather(b, b->index + first, n, &g);
    const ff_dirs w = {g.w[0], g.w[1], g.w[2], g.w[3], g.w[4], g.w[5]};
    ff_geometry planes;
    for (int k = 0; k < FF_G_COUNT; k++) planes.plane[k] = p->geometry[k] < 0 ? NULL : ff_problem_plane(p, block, p->geometry[k]);
    ff_kernels_get(p->isa)->geometry(&w, FF_BLOCK, &planes);
    if (planes.plane[FF_G_COS_I])
        for (size_t i = n; i < FF_BLOCK; i++) planes.plane[FF_G_COS_I][i] = 1;
    fill_targets(b, block, b->index + first, n, &g);
    for (size_t i = 0; i < n; i++) {
        double largest = 0;
        for (size_t c = 0; c < p->n_channels; c++) {
            const double w = ff_problem_plane(p, block, p->weight + p->weight_stride * (int)c)[i];
            largest = fmax(largest, fabs(w * ff_problem_plane(p, block, p->target + (int)c)[i]));
        }
        b->size[first + i] = (float)largest;
    }
}

/* ---- the thin problem
 * -------------------------------------------------------------------------------------------------------------- */

/* Bins of magnitudes: exponent and four bits of the mantissa of a positive float. */
enum { FF_BINS = 0x1000 };

static size_t bin_of(float m)
{
    uint32_t bits;
    memcpy(&bits, &m, sizeof bits);
    return (size_t)(bits >> 19) & 0xfff;
}

/* The smallest bin such that no more than `count` samples lie in it or above. */
static size_t threshold_bin(const size_t *histogram, size_t count)
{
    size_t sum = 0, bin = FF_BINS;
    while (bin > 0 && sum + histogram[bin - 1] <= count) sum += histogram[--bin];
    return bin;
}

/* A stride that shares no factor with the usual periods of grids. */
static size_t stride_for(size_t rest, size_t wanted)
{
    size_t s = rest / wanted;
    if (s < 2) return 1;
    while (s % 2 == 0 || s % 3 == 0 || s % 5 == 0) s++;
    return s;
}

/* The samples of a thin problem and what each stands for. */
typedef struct thinning {
    const struct ff_problem *from;
    struct ff_problem *to;
    uint32_t *index;     /* [to->n]                                          */
    double rest_weight;  /* root weight of those with rest[k] = 1            */
    unsigned char *rest; /* [to->n]                                          */
} thinning;

static int is_weight_plane(const struct ff_problem *p, size_t plane)
{
    const int n_weights = p->weight_stride ? (int)p->n_channels : 1, k = (int)plane;
    return (k >= p->weight && k < p->weight + n_weights) || k == p->sample_weight;
}

static void thin_plane(void *context, size_t plane, int worker)
{
    const thinning *t = context;
    const double factor = is_weight_plane(t->from, plane) ? t->rest_weight : 1;
    (void)worker;
    for (size_t k = 0; k < t->to->n; k++) {
        const size_t i = t->index[k];
        const double v = ff_problem_plane(t->from, i / FF_BLOCK, (int)plane)[i % FF_BLOCK];
        ff_problem_plane(t->to, k / FF_BLOCK, (int)plane)[k % FF_BLOCK] = t->rest[k] ? v * factor : v;
    }
}

/* Replaces loss by its tangent at the data: w g'(y) (f - y). A datum near 0, where the cube root is steep, counts as 1 % of the
 * mean. */
static void linearise(struct ff_problem *p)
{
    const struct ff_problem old = *p;
    double mean = 0;
    for (size_t i = 0; i < p->n; i++) mean += fabs(ff_problem_plane(p, i / FF_BLOCK, p->value)[i % FF_BLOCK]) / (double)p->n;
    for (size_t b = 0; b < p->n_blocks; b++) {
        const double *x = ff_problem_plane(p, b, p->geometry[FF_G_COS_I]);
        /* the planes of g(y) become weights per channel; their former place is taken by the values */
        for (size_t c = 0; c < p->n_channels; c++) {
            const double *w = ff_problem_plane(&old, b, old.weight + old.weight_stride * (int)c),
                         *y = ff_problem_plane(&old, b, old.value + (int)c);
            double *target = ff_problem_plane(&old, b, old.target + (int)c);
            for (int i = 0; i < FF_BLOCK; i++) target[i] = w[i] * slope_of(p->loss, fmax(fabs(y[i]), 0.01 * mean), x[i]);
        }
    }
    p->weight = old.target;
    p->weight_stride = 1;
    p->target = old.value;
    p->surrogate = 1;
}

ff_status ff_problem_thin(const struct ff_problem *p, const float *size, size_t wanted, int linear, struct ff_problem **out)
{
    struct ff_problem *t = malloc(sizeof *t);
    size_t histogram[FF_BINS] = {0};
    if (!t) return FF_ERR_MEMORY;
    *t = *p;
    t->channel_name = NULL;
    t->thin = t->thin_linear = t->middle = NULL;
    for (size_t i = 0; i < p->n; i++) histogram[bin_of(size[i])]++;
    const size_t bin = p->n > wanted ? threshold_bin(histogram, wanted / 3) : 0;
    size_t large = 0;
    for (size_t b = bin; b < FF_BINS; b++) large += histogram[b];
    const size_t rest = p->n - large, stride = rest ? stride_for(rest, wanted - wanted / 3) : 1;
    const size_t kept = rest ? (rest + stride - 1) / stride : 0;
    t->n = large + kept;
    t->n_blocks = (t->n + FF_BLOCK - 1) / FF_BLOCK;
    t->data = block_memory(ff_problem_doubles(t) * sizeof *t->data);
    thinning work = {p, t, malloc(t->n * sizeof(uint32_t)), kept ? sqrt((double)rest / (double)kept) : 1, malloc(t->n)};
    const int failed = !t->data || !work.index || !work.rest;
    if (!failed) {
        memset(t->data, 0, ff_problem_doubles(t) * sizeof *t->data);
        for (size_t i = 0, k = 0, skipped = 0; i < p->n; i++) {
            const int is_rest = bin_of(size[i]) < bin;
            if (is_rest && skipped++ % stride != 0) continue;
            work.index[k] = (uint32_t)i;
            work.rest[k++] = (unsigned char)is_rest;
        }
        ff_pool_run(p->pool, p->n_planes, thin_plane, &work);
        if (linear && is_curved(p->loss)) linearise(t);
    }
    free(work.index);
    free(work.rest);
    if (failed) {
        free(t->data);
        free(t);
        return FF_ERR_MEMORY;
    }
    *out = t;
    return FF_OK;
}

static void thin_free(struct ff_problem *p)
{
    if (!p) return;
    free(p->data);
    free(p);
}

/* ---- the whole
 * --------------------------------------------------------------------------------------------------------------------- */

ff_status ff_fit_options_check(const ff_fit_options *o, ff_error *err)
{
    if (o->size != sizeof *o)
        return ff_error_set(err, FF_ERR_RANGE, NULL, 0, -1, "the options were not initialised by ff_fit_options_init");
    if (!ff_loss_name((int)o->loss) || !ff_robust_name((int)o->robust) || !ff_weighting_name((int)o->weighting) ||
        !ff_shape_name((int)o->shape) || !ff_channel_mode_name((int)o->channels))
        return ff_error_set(err, FF_ERR_RANGE, NULL, 0, -1,
                            "an option names no known loss, robust loss, weighting, shape or mode of channels");
    if (!(o->max_theta > 0 && o->max_theta <= 1.5707963267948968))
        return ff_error_set(err, FF_ERR_RANGE, NULL, 0, -1, "the largest angle must lie in (0, 90] degrees, found %g",
                            o->max_theta * (180 / 3.14159265358979323846));
    if (o->robust != FF_ROBUST_NONE && !(o->robust_scale > 0 && isfinite(o->robust_scale)))
        return ff_error_set(err, FF_ERR_RANGE, NULL, 0, -1, "the scale of a robust loss must be positive, found %g",
                            o->robust_scale);
    if (o->threads < 0 || o->max_iterations < 0)
        return ff_error_set(err, FF_ERR_RANGE, NULL, 0, -1,
                            "the options for the number of threads and of iterations must not be negative");
    return FF_OK;
}

static ff_status check_options(const ff_table *t, const ff_fit_options *o, ff_error *err)
{
    const ff_status s = ff_fit_options_check(o, err);
    if (s) return s;
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
    return FF_OK;
}

static int is_isotropic(const ff_table *t, const ff_fit_options *o)
{
    return (o->shape == FF_SHAPE_ISOTROPIC || (o->shape == FF_SHAPE_AUTO && t->isotropic)) && !o->mean_slope;
}

/* Numbers the planes of a block. */
static void lay_out(struct ff_problem *p, const ff_model *models, size_t n_models, int isotropic, ff_weighting weighting)
{
    uint32_t need = 0;
    for (size_t i = 0; i < n_models; i++) {
        for (uint32_t l = 0; l < models[i].n_lobes; l++)
            if (ff_ndf_at(models[i].lobe[l].ndf)->term.claims & FF_ISOTROPIC)
                need |= ff_model_planes(&models[i], FF_ISOTROPIC_MODE);
        need |= ff_model_planes(&models[i], isotropic ? FF_ISOTROPIC_MODE : FF_CENTRED_MODE);
    }
    const int curved = is_curved(p->loss);
    if (curved || !(need & (1u << FF_G_TI2 | 1u << FF_G_TIX))) need |= 1u << FF_G_COS_I;
    int next = 0;
    const int C = (int)p->n_channels;
    for (int k = 0; k < FF_G_COUNT; k++) p->geometry[k] = need & 1u << k ? next++ : -1;
    p->weight_stride = p->loss == FF_LOSS_RELATIVE || weighting == FF_WEIGHT_SIGMA;
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
    p->n_planes = (size_t)next;
}

static ff_status name_channels(const ff_table *t, struct ff_problem *p, const ff_fit_options *o, const size_t *channel)
{
    p->channel_name = calloc(p->n_channels, sizeof *p->channel_name);
    if (!p->channel_name) return FF_ERR_MEMORY;
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

static ff_status nothing_left(const ff_selection *s, const ff_fit_options *o, ff_error *err)
{
    return ff_error_set(
        err, FF_ERR_DATA, NULL, 0, -1,
        "no sample is left to fit: of %zu, %zu are not valid measurements, %zu lie at or below the horizon, %zu beyond %g degrees",
        s->samples, s->invalid, s->below_horizon, s->grazing, o->max_theta * (180 / 3.14159265358979323846));
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
    b->floors = calloc(C, sizeof *b->floors);
    b->buffer = malloc(threads * b->per_thread * sizeof *b->buffer);
    if (!b->index || !b->slab || !b->channel_sum || !b->floors || !b->buffer)
        return ff_error_set(err, FF_ERR_MEMORY, NULL, 0, -1, "out of memory");
    ff_pool_run(p->pool, slabs, look_at_slab, b);
    ff_selection *sel = &p->selection;
    double weight = 0;
    for (size_t s = 0; s < slabs; s++) {
        sel->used += b->slab[s].count[FF_USED];
        sel->invalid += b->slab[s].count[FF_INVALID];
        sel->below_horizon += b->slab[s].count[FF_BELOW];
        sel->grazing += b->slab[s].count[FF_GRAZING];
        sel->negative += b->slab[s].negative;
        weight += b->slab[s].weight;
        for (size_t c = 0; c < C; c++) b->floors[c] += b->channel_sum[s * C + c];
    }
    if (sel->used == 0 || !(weight > 0)) return nothing_left(sel, b->o, err);
    for (size_t c = 0; c < C; c++) b->floors[c] = fmax(FF_RELATIVE_FLOOR * b->floors[c] / (double)sel->used, 1e-12);
    b->weight_scale = (double)sel->used / weight;
    pack_index(b, slabs);
    p->n = sel->used;
    p->n_blocks = (p->n + FF_BLOCK - 1) / FF_BLOCK;
    lay_out(p, models, n_models, is_isotropic(t, b->o), b->weighting);
    p->data = block_memory(ff_problem_doubles(p) * sizeof *p->data);
    if (!p->data) return ff_error_set(err, FF_ERR_MEMORY, NULL, 0, -1, "out of memory for %zu samples", p->n);
    b->size = malloc(p->n * sizeof *b->size);
    if (!b->size) return ff_error_set(err, FF_ERR_MEMORY, NULL, 0, -1, "out of memory");
    ff_pool_run(p->pool, p->n_blocks, build_block, b);
    ff_status st = ff_problem_thin(p, b->size, FF_THIN, 0, &p->thin);
    if (!st) st = ff_problem_thin(p, b->size, FF_THIN, 1, &p->thin_linear);
    if (!st && p->n > FF_MIDDLE_FROM) st = ff_problem_thin(p, b->size, p->n / 8, 0, &p->middle);
    return st ? ff_error_set(err, st, NULL, 0, -1, "out of memory") : FF_OK;
}

ff_status ff_problem_new(const ff_table *t, const ff_model *models, size_t n_models, const ff_fit_options *o, ff_problem **out,
                         ff_error *err)
{
    build b = {.t = t, .o = o};
    ff_status s = check_options(t, o, err);
    if (!s && n_models == 0) s = ff_error_set(err, FF_ERR_RANGE, NULL, 0, -1, "a problem needs at least one model");
    if (!s) s = choose_weighting(t, o->weighting, &b.weighting, err);
    if (s) return s;
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
    b.p = p;
    b.cos_max = o->max_theta >= 1.5707963267948966 ? 0 : cos(o->max_theta) * (1 - 1e-12); /* a sample at exactly max_theta is in */
    p->n_channels = o->channels == FF_CHANNELS_MEAN ? 1 : b.n_from;
    p->loss = o->loss;
    p->isa = o->isa;
    p->selection =
        (ff_selection){.samples = t->n, .n_channels = p->n_channels, .weighting = b.weighting, .isotropic = t->isotropic};
    s = name_channels(t, p, o, channel) ? ff_error_set(err, FF_ERR_MEMORY, NULL, 0, -1, "out of memory")
                                        : build_all(&b, models, n_models, err);
    free(b.index);
    free(b.slab);
    free(b.channel_sum);
    free(b.floors);
    free(b.buffer);
    free(b.size);
    free(channel);
    if (s) {
        ff_problem_free(p);
        return s;
    }
    *out = p;
    return FF_OK;
}

void ff_problem_free(ff_problem *p)
{
    if (!p) return;
    thin_free(p->thin);
    thin_free(p->thin_linear);
    thin_free(p->middle);
    ff_pool_free(p->pool);
    free(p->data);
    free(p->channel_name);
    free(p);
}

void ff_problem_selection(const ff_problem *p, ff_selection *out)
{
    *out = p->selection;
}

const char *ff_problem_channel_name(const ff_problem *p, size_t c)
{
    return c < p->n_channels ? p->channel_name[c] : NULL;
}
