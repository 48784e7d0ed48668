/* A finished fit looked at again: values at the samples, residuals by angle, values that stand out. */
#include "fit/losses/internal_loss.h"
#include "fit/losses/robust/internal_robust.h"
#include "fit/pass/internal_evaluate.h"
#include "fit/internal_stages.h"
#include "internal_trust.h"
#include "data_formats/interpolation/resample_struct.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

ff_status ff_trust_evaluate(const ff_problem *p, const ff_fit_options *o, const ff_fit_result *fit, double *model, double *residual,
                            double *cost, ff_error *err)
{
    ff_fit_options own;
    ff_finished f;
    o = ff_fit_options_take(o, &own, err);
    if (!o) return FF_ERR_RANGE;
    ff_status status = ff_finished_open(p, o, fit, &f, err);
    if (status) return status;
    status = ff_point_evaluate(&f.plan, &f.at, 1, model, residual, cost);
    ff_finished_close(&f);
    return status ? ff_error_set(err, status, NULL, 0, -1, "the model could not be evaluated: %s", ff_status_str(status)) : FF_OK;
}

/* ---- by angle -------------------------------------------------------------------------------- */

/* Sums of one band. */
typedef struct band_sums {
    double weight, signed_sum, square, data;
    size_t n;
} band_sums;

typedef struct chunk_bands {
    band_sums band[FF_PLACE_COUNT][FF_BANDS];
} chunk_bands;

typedef struct banding {
    const ff_pass *pass;
    ff_average_work **works; /* [threads], NULL: samples are points */
    const ff_places *places;
    chunk_bands *chunk; /* [chunks], merged in their order */
} banding;

/* Of the samples of one block, all channels: sums [FF_BLOCK]. */
static void sample_sums(const ff_pass *pass, size_t block, ff_average_work *work, band_sums *sums)
{
    const struct ff_problem *p = pass->p;
    ff_block scratch;
    ff_geometry g;
    double f[FF_BLOCK] __attribute__((aligned(64))), x[FF_BLOCK];
    const double *root = ff_problem_plane(p, block, p->sample_weight);
    scratch.d = NULL;
    for (int k = 0; k < FF_G_COUNT; k++) g.plane[k] = p->geometry[k] < 0 ? NULL : ff_problem_plane(p, block, p->geometry[k]);
    ff_problem_cosines(&g, x);
    const double centre = ff_evaluate_begin(pass, block, &g, &scratch, work);
    memset(sums, 0, FF_BLOCK * sizeof *sums);
    for (size_t c = 0; c < p->n_channels; c++) {
        const double *y = ff_problem_plane(p, block, p->value + (int)c);
        ff_evaluate_value(pass, &g, c, centre, &scratch, work, f);
        for (size_t i = 0; i < FF_BLOCK; i++) {
            const double w = root[i] * root[i], e = (f[i] - y[i]) * x[i];
            sums[i].weight += w;
            sums[i].signed_sum += w * e;
            sums[i].square += w * e * e;
            sums[i].data += w * fabs(y[i]) * x[i];
        }
    }
}

static void add_to_band(band_sums *to, const band_sums *from, size_t n)
{
    to->weight += from->weight;
    to->signed_sum += from->signed_sum;
    to->square += from->square;
    to->data += from->data;
    to->n += n;
}

static void band_chunk(void *context, size_t chunk, int worker)
{
    const banding *b = context;
    const struct ff_problem *p = b->pass->p;
    band_sums sums[FF_BLOCK];
    for (size_t block = chunk * FF_CHUNK; block < (chunk + 1) * FF_CHUNK && block < p->n_blocks; block++) {
        const size_t first = block * FF_BLOCK, n = p->n - first < FF_BLOCK ? p->n - first : FF_BLOCK;
        sample_sums(b->pass, block, b->works ? b->works[worker] : NULL, sums);
        for (int k = 0; k < FF_PLACE_COUNT; k++)
            for (size_t i = 0; i < n; i++) add_to_band(&b->chunk[chunk].band[k][b->places->band[k][first + i]], &sums[i], 1);
    }
}

ff_status ff_trust_bands_into(const ff_problem *p, const ff_places *places, const ff_fit_options *o, const ff_fit_result *fit,
                              ff_bands *out, ff_error *err)
{
    const size_t chunks = (p->n_blocks + FF_CHUNK - 1) / FF_CHUNK;
    ff_bands bands = {0};
    ff_finished f;
    ff_pass pass;
    ff_status status = ff_finished_open(p, o, fit, &f, err);
    if (status) return status;
    banding work = {&pass, NULL, places, calloc(chunks, sizeof *work.chunk)};
    f.plan.l.free = (ff_wanted){0}; /* values alone */
    status = work.chunk ? ff_plan_pass(&f.plan, f.at.shape, f.at.channel, &pass) : FF_ERR_MEMORY;
    if (!status) {
        status = ff_evaluate_works(&pass, (size_t)ff_pool_threads(p->pool), &work.works);
        if (!status) ff_pool_run(p->pool, chunks, band_chunk, &work);
        ff_average_works_free(work.works);
        ff_pass_free(&pass);
    }
    for (int k = 0; k < FF_PLACE_COUNT && !status; k++)
        for (int b = 0; b < FF_BANDS; b++) {
            band_sums s = {0};
            for (size_t c = 0; c < chunks; c++) add_to_band(&s, &work.chunk[c].band[k][b], work.chunk[c].band[k][b].n);
            bands.band[k][b] =
                (ff_band){s.n, s.data > 0 ? s.signed_sum / s.data : NAN, s.data > 0 ? sqrt(s.square * s.weight) / s.data : NAN};
        }
    free(work.chunk);
    ff_finished_close(&f);
    if (status) return ff_error_set(err, status, NULL, 0, -1, "out of memory");
    *out = bands;
    return FF_OK;
}

/* ---- as a table ------------------------------------------------------------------------------ */

ff_status ff_trust_residual_table_into(const ff_problem *p, const ff_table *t, const ff_fit_options *o, const ff_fit_result *fit,
                                       ff_table *out, ff_error *err)
{
    const size_t n = p->n, C = p->n_channels;
    ff_table made, view = *t; /* as many channels as the problem has, and the values alone */
    view.n_channels = C;
    view.sigma = NULL;
    view.kept = NULL;
    view.note[0] = '\0';
    view.quantity = FF_BRDF;
    view.n_negative = 0;
    double *model = malloc((C * n + 1) * sizeof *model);
    if (!model) return ff_error_set(err, FF_ERR_MEMORY, NULL, 0, -1, "out of memory");
    ff_status status = ff_trust_evaluate(p, o, fit, model, NULL, NULL, err);
    if (!status) status = ff_table_copy_into(&view, &made, err);
    if (status) {
        free(model);
        return status;
    }
    memset(made.valid, 0, made.n);
    memset(made.value, 0, made.n * C * sizeof *made.value);
    made.n_invalid = made.n - n;
    for (size_t c = 0; c < C; c++) {
        made.channels[c].scale = 1;
        snprintf(made.channels[c].name, sizeof made.channels[c].name, "%s", p->channel_name[c]);
        for (size_t i = 0; i < n; i++) {
            const double y = ff_problem_plane(p, i / FF_BLOCK, p->value + (int)c)[i % FF_BLOCK];
            made.value[c * made.n + p->index[i]] = model[c * n + i] - y;
        }
    }
    for (size_t i = 0; i < n; i++) made.valid[p->index[i]] = 1;
    free(model);
    *out = made;
    return FF_OK;
}

/* ---- values that stand out ------------------------------------------------------------------- */

static void keep_worst(ff_outliers *out, uint32_t sample, uint32_t channel, double ratio)
{
    if (out->n_worst == FF_WORST && fabs(out->worst[FF_WORST - 1].ratio) >= fabs(ratio)) return;
    size_t at = out->n_worst < FF_WORST ? out->n_worst++ : FF_WORST - 1;
    for (; at > 0 && fabs(out->worst[at - 1].ratio) < fabs(ratio); at--) out->worst[at] = out->worst[at - 1];
    out->worst[at].sample = sample;
    out->worst[at].channel = channel;
    out->worst[at].ratio = ratio;
}

ff_status ff_trust_outliers_into(const ff_problem *p, const ff_places *places, const ff_fit_options *o, const ff_fit_result *fit,
                                 ff_outliers *out, ff_error *err)
{
    ff_outliers found = {.size = sizeof found};
    if (o->robust == FF_ROBUST_NONE)
        return ff_error_set(err, FF_ERR_UNSUPPORTED, NULL, 0, -1, "only a robust loss has a scale that tells outliers");
    const size_t values = p->n_channels * p->n;
    double *residual = malloc((2 * values + 1) * sizeof *residual);
    if (!residual) return ff_error_set(err, FF_ERR_MEMORY, NULL, 0, -1, "out of memory");
    double *model = residual + values;
    const ff_status status = ff_trust_evaluate(p, o, fit, model, residual, NULL, err);
    const int by_noise = o->noise && !(o->robust_scale > 0); /* about this fit; the units are those about the one before it */
    const double given = o->robust_scale > 0 ? o->robust_scale / ff_robust_tuning(o->robust) : 1;
    for (size_t i = 0; i < p->n && !status; i++) {
        int any = 0;
        for (size_t c = 0; c < p->n_channels; c++) {
            const double unit = by_noise  ? ff_residual_deviation(p, o->noise, model, c, i)
                                : p->unit ? (double)p->unit[c * p->n_blocks * FF_BLOCK + i]
                                          : given,
                         ratio = residual[c * p->n + i] / unit;
            if (!(fabs(ratio) > FF_OUTLIER)) continue;
            any = 1;
            found.values++;
            keep_worst(&found, p->index[i], (uint32_t)c, ratio);
        }
        found.samples += (size_t)any;
        for (int k = 0; k < FF_PLACE_COUNT && any; k++) found.in_band[k][places->band[k][i]]++;
    }
    free(residual);
    if (status) return status;
    *out = found;
    return FF_OK;
}
