/* Directional albedos of a model with their derivatives; see internal_albedo.h. */
#include "internal_integral.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* One group of channels. What is made ready points into `lobe` and to the caller's channels. */
typedef struct channel_group {
    size_t n;
    ff_albedo_part lobe[FF_MAX_LOBES];
    ff_prepared whole; /* where there are bases */
} channel_group;

struct ff_albedo_parts {
    const ff_model *m;
    ff_wanted wanted;
    size_t n_channels, n_groups;
    double weight[FF_MAX_LOBES], dw[FF_MAX_LOBES][FF_MAX_LOBES];
    size_t column[FF_MAX_LOBES][FF_ALBEDO_COLUMNS]; /* of the model, by that of the lobe alone */
    channel_group group[];
};

/* The columns of the model that lobe l has by itself, and which they are. */
static ff_wanted columns_of_lobe(const ff_model *m, const ff_model *alone, uint32_t l, const ff_wanted *all, size_t *column)
{
    const ff_lobe *lobe = &m->lobe[l], *group = &m->lobe[ff_model_group(m, l)];
    ff_wanted w = {.n_shape = 0};
    for (uint32_t k = 0; k < all->n_shape; k++) {
        const uint32_t at = all->shape[k] - lobe->shape0;
        if (m->shape[all->shape[k]].lobe != l || at >= alone->n_shape) continue; /* the last may be the weight */
        column[w.n_shape] = k;
        w.tied[w.n_shape] = all->tied[k];
        w.shape[w.n_shape++] = at;
    }
    for (uint32_t k = 0; k < all->n_channel; k++) {
        if (m->channel[all->channel[k]].lobe != ff_model_group(m, l)) continue;
        column[w.n_shape + w.n_channel] = all->n_shape + k;
        w.channel[w.n_channel++] = all->channel[k] - group->channel0;
    }
    return w;
}

ff_status ff_albedo_parts_make(const ff_model *m, const ff_kernels *kernels, ff_stretch_mode mode, size_t n_channels,
                               const double *shape, const double *channel, const ff_wanted *wanted, ff_albedo_parts **out)
{
    const size_t n_groups = (n_channels + FF_INTEGRAL_GROUP - 1) / FF_INTEGRAL_GROUP;
    ff_albedo_parts *a = calloc(1, sizeof *a + n_groups * sizeof *a->group);
    ff_status status = a ? FF_OK : FF_ERR_MEMORY;
    if (a) *a = (ff_albedo_parts){.m = m, .wanted = *wanted, .n_channels = n_channels, .n_groups = n_groups};
    if (a) ff_model_weights(m, shape, a->weight, a->dw);
    for (size_t g = 0; g < n_groups && status == FF_OK; g++) {
        channel_group *group = &a->group[g];
        const double *of_group = channel + g * FF_INTEGRAL_GROUP * m->n_channel;
        group->n = n_channels - g * FF_INTEGRAL_GROUP < FF_INTEGRAL_GROUP ? n_channels - g * FF_INTEGRAL_GROUP : FF_INTEGRAL_GROUP;
        for (uint32_t l = 0; l < m->n_lobes && status == FF_OK; l++) {
            ff_albedo_part *p = &group->lobe[l];
            ff_model_lobe_alone(m, l, group->n, shape, of_group, &p->model, p->shape, p->channel);
            const ff_wanted own = columns_of_lobe(m, &p->model, l, wanted, a->column[l]);
            status = ff_prepare(&p->model, kernels, mode, group->n, p->shape, p->channel, &own, 0, INFINITY, &p->prepared);
        }
        if (m->n_bases && status == FF_OK)
            status = ff_prepare(m, kernels, mode, group->n, shape, of_group, wanted, 0, INFINITY, &group->whole);
    }
    if (status != FF_OK) {
        ff_albedo_parts_free(a);
        return status;
    }
    *out = a;
    return FF_OK;
}

void ff_albedo_parts_free(ff_albedo_parts *a)
{
    if (!a) return;
    for (size_t g = 0; g < a->n_groups; g++) {
        for (uint32_t l = 0; l < a->m->n_lobes; l++) ff_prepared_free(&a->group[g].lobe[l].prepared);
        ff_prepared_free(&a->group[g].whole);
    }
    free(a);
}

/* Adds lobe l, times its weight, and what the weights change. */
static void add_lobe_columns(const ff_albedo_parts *a, uint32_t l, const ff_integrand *k, size_t c, double *out)
{
    out[0] += a->weight[l] * k->sum[c];
    for (size_t j = 0; j < k->n_columns; j++) out[1 + a->column[l][j]] += a->weight[l] * k->column_sum[c][j];
    for (uint32_t j = 0; j < a->wanted.n_shape; j++) {
        const uint32_t at = a->wanted.shape[j], other = a->m->shape[at].lobe;
        if (other >= a->m->n_lobes || a->m->lobe[other].fresnel != FF_FRESNEL_SHARED) continue;
        if (at + 1 == a->m->lobe[other].shape0 + a->m->lobe[other].n_shape) out[1 + j] += a->dw[other][l] * k->sum[c];
    }
}

void ff_albedo_parts_at(const ff_albedo_parts *a, int order, const double wo[3], ff_block_work *work, double *out)
{
    const size_t stride = 1 + a->wanted.n_shape + a->wanted.n_channel;
    ff_integrand k;
    memset(out, 0, a->n_channels * stride * sizeof *out);
    for (size_t g = 0; g < a->n_groups; g++) {
        const channel_group *group = &a->group[g];
        double *of_group = out + g * FF_INTEGRAL_GROUP * stride;
        for (uint32_t l = 0; l < a->m->n_lobes; l++) {
            ff_integrand_make(FF_INTEGRAL_LOBES, &group->lobe[l].prepared, wo, work, &k);
            ff_integrand_sum(&k, order);
            for (size_t c = 0; c < group->n; c++) add_lobe_columns(a, l, &k, c, of_group + c * stride);
        }
        if (a->m->n_bases == 0) continue;
        ff_integrand_make(FF_INTEGRAL_BASES, &group->whole, wo, work, &k);
        ff_integrand_sum(&k, order);
        for (size_t c = 0; c < group->n; c++) {
            of_group[c * stride] += k.sum[c];
            for (size_t j = 0; j < k.n_columns; j++) of_group[c * stride + 1 + j] += k.column_sum[c][j];
        }
    }
}
