/* Which parameters are free, and the coordinates they are searched in. */
#include "internal_layout.h"
#include <math.h>
#include <string.h>

double ff_coordinate(const ff_param *info, double value)
{
    if (info->flags & FF_PARAM_LOG) return log(value + info->offset);
    return info->flags & FF_PARAM_ATANH ? atanh(value) : value;
}

double ff_coordinate_value(const ff_param *info, double coordinate)
{
    double v = coordinate;
    if (info->flags & FF_PARAM_LOG) v = exp(coordinate) - info->offset;
    if (info->flags & FF_PARAM_ATANH) v = tanh(coordinate);
    return fmin(fmax(v, info->lo), info->hi); /* rounding at the box */
}

double ff_coordinate_slope(const ff_param *info, double value)
{
    if (info->flags & FF_PARAM_LOG) return value + info->offset;
    return info->flags & FF_PARAM_ATANH ? 1 - value * value : 1;
}

/* ---- what is free ---------------------------------------------------------------------------- */

static int is_slope(const char *name)
{
    return strcmp(name, "slope_x") == 0 || strcmp(name, "slope_y") == 0;
}

static int is_free(const ff_model_param *p, ff_shape shape, int mean_slope)
{
    const char *name = p->info->name;
    if (strcmp(name, "alpha_y") == 0 && shape == FF_SHAPE_ISOTROPIC) return 0;
    if (strcmp(name, "r_xy") == 0 && shape != FF_SHAPE_CORRELATED) return 0;
    return !(p->flags & FF_PARAM_HELD) || (mean_slope && is_slope(name));
}

ff_stretch_mode ff_layout_mode(const ff_model *m, ff_shape shape, int mean_slope)
{
    int tilted = 0, centred = shape != FF_SHAPE_ISOTROPIC;
    for (uint32_t k = 0; k < m->n_shape; k++) {
        const ff_model_param *p = &m->shape[k];
        tilted |= is_slope(p->info->name) && (is_free(p, shape, mean_slope) || p->init != 0);
        centred |= strcmp(p->info->name, "r_xy") == 0 && p->init != 0;
    }
    return tilted ? FF_TILTED_MODE : centred ? FF_CENTRED_MODE : FF_ISOTROPIC_MODE;
}

ff_shape ff_layout_shape(const ff_model *m, int isotropic_table, ff_shape asked, int mean_slope)
{
    int isotropic = m->n_lobes == 0 || (isotropic_table && !mean_slope);
    for (uint32_t k = 0; k < m->n_lobes; k++) isotropic |= m->lobe[k].isotropic;
    return asked != FF_SHAPE_AUTO ? asked : isotropic ? FF_SHAPE_ISOTROPIC : FF_SHAPE_CORRELATED;
}

static ff_status check_shape(const ff_model *m, ff_shape shape, int mean_slope, ff_stretch_mode mode, ff_error *err)
{
    for (uint32_t k = 0; k < m->n_lobes; k++) {
        const ff_lobe *lobe = &m->lobe[k];
        const ff_term *ndf = &ff_ndf_at(lobe->ndf)->term, *masking = &ff_masking_at(lobe->masking)->term;
        const char *which = ndf->name;
        if (masking->claims & FF_ISOTROPIC) which = masking->name;
        for (uint32_t b = 0; b < m->n_bases; b++) {
            const ff_diffuse *base = ff_diffuse_at(m->base[b].diffuse);
            if (base->couples & FF_COUPLES_ISOTROPIC) which = base->term.name;
        }
        if (shape != FF_SHAPE_ISOTROPIC && lobe->isotropic)
            return ff_error_set(err, FF_ERR_UNSUPPORTED, NULL, 0, -1, "%s is isotropic: it cannot be fitted with the shape '%s'",
                                which, ff_shape_name((int)shape));
        if (mode == FF_TILTED_MODE && (masking->claims & FF_NEEDS_CENTRED))
            return ff_error_set(err, FF_ERR_UNSUPPORTED, NULL, 0, -1, "%s is undefined with a mean slope", masking->name);
        if ((mean_slope || mode == FF_TILTED_MODE) && lobe->isotropic)
            return ff_error_set(err, FF_ERR_UNSUPPORTED, NULL, 0, -1, "%s has no mean slope", which);
    }
    return FF_OK;
}

/* Is the model affine in the free parameters of a channel, or would it be in their products with free scales? Not when a base
 * depends on the lobes. */
static int is_linear(const ff_layout *l, uint32_t *scaled)
{
    const ff_model *m = l->m;
    uint32_t scales = 0, others = 0; /* bit sets of lobes */
    int linear = 1;
    for (uint32_t k = 0; k < l->free.n_channel; k++) {
        const ff_model_param *p = &m->channel[l->free.channel[k]];
        linear &= (p->flags & FF_PARAM_LINEAR) != 0;
        if (p->lobe >= m->n_lobes) continue;
        const int is_scale = l->free.channel[k] + 1 == m->lobe[p->lobe].channel0 + m->lobe[p->lobe].n_channel;
        *(is_scale ? &scales : &others) |= 1u << p->lobe;
    }
    for (uint32_t b = 0; b < m->n_bases; b++) linear &= !(ff_diffuse_at(m->base[b].diffuse)->couples & FF_COUPLES_CURVED);
    *scaled = scales & others;
    return linear;
}

ff_status ff_layout_init(const ff_model *m, size_t n_channels, ff_shape shape, int mean_slope, ff_layout *out, ff_error *err)
{
    ff_layout l = {.m = m, .mode = ff_layout_mode(m, shape, mean_slope), .n_channels = n_channels, .pinned = FF_NOT_PINNED};
    const ff_status status = check_shape(m, shape, mean_slope, l.mode, err);
    if (status) return status;
    for (uint32_t k = 0; k < m->n_shape; k++) {
        if (!is_free(&m->shape[k], shape, mean_slope)) continue;
        l.free.tied[l.free.n_shape] = shape == FF_SHAPE_ISOTROPIC && strcmp(m->shape[k].info->name, "alpha_x") == 0;
        l.free.shape[l.free.n_shape++] = k;
    }
    for (uint32_t k = 0; k < m->n_channel; k++)
        if (!(m->channel[k].flags & FF_PARAM_HELD)) l.free.channel[l.free.n_channel++] = k;
    for (uint32_t k = 0; k < FF_MAX_SHAPE; k++) l.shape_follows[k] = -1;
    for (uint32_t k = 0; k < FF_MAX_CHANNEL_PARAMS; k++) l.channel_follows[k] = -1;
    ff_layout_number(&l);
    l.linear = is_linear(&l, &l.scaled);
    *out = l;
    return FF_OK;
}

/* ---- coordinates ----------------------------------------------------------------------------- */

void ff_layout_number(ff_layout *l)
{
    uint32_t shared = 0, own = 0;
    for (uint32_t k = 0; k < l->free.n_shape; k++)
        if (l->shape_follows[k] < 0) l->shape_at[k] = shared++;
    for (uint32_t k = 0; k < l->free.n_channel; k++)
        if (l->channel_follows[k] < 0) l->channel_at[k] = l->channel_shared[k] ? shared++ : own++;
    for (uint32_t k = 0; k < l->free.n_shape; k++)
        if (l->shape_follows[k] >= 0) l->shape_at[k] = l->shape_at[l->shape_follows[k]];
    for (uint32_t k = 0; k < l->free.n_channel; k++) {
        if (l->channel_follows[k] < 0) continue;
        l->channel_at[k] = l->channel_at[l->channel_follows[k]];
        l->channel_shared[k] = l->channel_shared[l->channel_follows[k]];
    }
    l->n_shared = shared;
    l->n_own = own;
    l->n_columns = l->free.n_shape + l->n_channels * l->free.n_channel;
    l->P = l->n_shared + l->n_channels * l->n_own;
    l->tied = l->P < l->n_columns;
}

ff_layout ff_layout_of_channels(const ff_layout *l)
{
    ff_layout channels = *l;
    channels.free.n_shape = 0;
    ff_layout_number(&channels);
    return channels;
}

const ff_model_param *ff_layout_param(const ff_layout *l, size_t k, size_t *c)
{
    const int shared = k < l->n_shared;
    if (c) *c = shared ? 0 : (k - l->n_shared) / l->n_own;
    for (uint32_t i = 0; i < l->free.n_shape && shared; i++)
        if (l->shape_follows[i] < 0 && l->shape_at[i] == k) return &l->m->shape[l->free.shape[i]];
    const size_t at = shared ? k : (k - l->n_shared) % l->n_own;
    for (uint32_t i = 0; i < l->free.n_channel; i++)
        if (l->channel_follows[i] < 0 && l->channel_shared[i] == shared && l->channel_at[i] == at)
            return &l->m->channel[l->free.channel[i]];
    return NULL; /* not of a layout that was numbered */
}

void ff_layout_range(const ff_layout *l, size_t k, double *lo, double *hi)
{
    size_t c;
    const ff_model_param *p = ff_layout_param(l, k, &c);
    const int of_channel = p >= l->m->channel && p < l->m->channel + l->m->n_channel;
    *lo = of_channel ? ff_layout_lo(l, c, (uint32_t)(p - l->m->channel)) : p->lo;
    *hi = of_channel ? ff_layout_hi(l, c, (uint32_t)(p - l->m->channel)) : p->hi;
}

int ff_layout_is_fixed(const ff_layout *l, size_t k)
{
    double lo = 0, hi = 1;
    if (l->limits) ff_layout_range(l, k, &lo, &hi);
    return lo == hi;
}

/* ---- between parameters and coordinates ------------------------------------------------------ */

void ff_layout_pack(const ff_layout *l, const double *shape, const double *channel, double *x)
{
    for (uint32_t k = 0; k < l->free.n_shape; k++)
        if (l->shape_follows[k] < 0) x[l->shape_at[k]] = ff_coordinate(l->m->shape[l->free.shape[k]].info, shape[l->free.shape[k]]);
    for (size_t c = l->n_channels; c-- > 0;) /* the first channel last: what all share is its value */
        for (uint32_t k = 0; k < l->free.n_channel; k++)
            if (l->channel_follows[k] < 0)
                x[ff_layout_coordinate(l, c, l->free.n_shape + k)] =
                    ff_coordinate(l->m->channel[l->free.channel[k]].info, channel[c * l->m->n_channel + l->free.channel[k]]);
}

void ff_layout_unpack(const ff_layout *l, const double *x, double *shape, double *channel)
{
    for (uint32_t k = 0; k < l->free.n_shape; k++) {
        const uint32_t i = l->free.shape[k];
        shape[i] = ff_coordinate_value(l->m->shape[i].info, x[l->shape_at[k]]);
        if (l->free.tied[k]) shape[i + 1] = shape[i]; /* alpha_y follows alpha_x */
    }
    for (size_t c = 0; c < l->n_channels; c++)
        for (uint32_t k = 0; k < l->free.n_channel; k++)
            channel[c * l->m->n_channel + l->free.channel[k]] =
                ff_coordinate_value(l->m->channel[l->free.channel[k]].info, x[ff_layout_coordinate(l, c, l->free.n_shape + k)]);
}

void ff_layout_slope(const ff_layout *l, const double *shape, const double *channel, double *slope)
{
    for (uint32_t k = 0; k < l->free.n_shape; k++)
        slope[l->shape_at[k]] = ff_coordinate_slope(l->m->shape[l->free.shape[k]].info, shape[l->free.shape[k]]);
    for (size_t c = 0; c < l->n_channels; c++)
        for (uint32_t k = 0; k < l->free.n_channel; k++)
            slope[ff_layout_coordinate(l, c, l->free.n_shape + k)] =
                ff_coordinate_slope(l->m->channel[l->free.channel[k]].info, channel[c * l->m->n_channel + l->free.channel[k]]);
}

static void into_bounds(double lo, double hi, double *v)
{
    *v = fmin(fmax(*v, lo), hi);
}

/* What is held at a value by channel is there too. */
static void project_channel(const ff_layout *l, size_t c, double *own)
{
    for (uint32_t k = 0; k < l->m->n_channel && l->limits; k++) into_bounds(ff_layout_lo(l, c, k), ff_layout_hi(l, c, k), &own[k]);
    for (uint32_t k = 0; k < l->free.n_channel && !l->limits; k++) {
        const ff_model_param *p = &l->m->channel[l->free.channel[k]];
        into_bounds(p->lo, p->hi, &own[l->free.channel[k]]);
    }
}

void ff_layout_project(const ff_layout *l, double *shape, double *channel)
{
    for (uint32_t k = 0; k < l->free.n_shape; k++) {
        const ff_model_param *p = &l->m->shape[l->free.shape[k]];
        into_bounds(p->lo, p->hi, &shape[l->free.shape[k]]);
    }
    for (uint32_t k = 0; k < l->free.n_shape; k++) {
        const uint32_t i = l->free.shape[k];
        if (l->shape_follows[k] >= 0) shape[i] = shape[l->free.shape[l->shape_follows[k]]];
        if (l->free.tied[k]) shape[i + 1] = shape[i];
    }
    for (size_t c = 0; c < l->n_channels && channel; c++) {
        double *own = channel + c * l->m->n_channel;
        project_channel(l, c, own);
        for (uint32_t k = 0; k < l->free.n_channel; k++) {
            const uint32_t leader = l->free.channel[l->channel_follows[k] < 0 ? k : (uint32_t)l->channel_follows[k]];
            own[l->free.channel[k]] = (l->channel_shared[k] ? channel : own)[leader];
        }
    }
}

void ff_layout_candidate(const ff_layout *l, double *shape)
{
    double held[FF_MAX_SHAPE];
    ff_layout_defaults(l, held, NULL);
    for (uint32_t k = 0; k < l->free.n_shape; k++) held[l->free.shape[k]] = shape[l->free.shape[k]];
    for (uint32_t k = 0; k < l->m->n_shape && l->mode == FF_ISOTROPIC_MODE; k++)
        if (strcmp(l->m->shape[k].info->name, "alpha_x") == 0) held[k + 1] = held[k];
    memcpy(shape, held, l->m->n_shape * sizeof *shape);
    ff_layout_project(l, shape, NULL);
}

void ff_layout_channel_defaults(const ff_layout *l, double *channel)
{
    const size_t size = l->n_channels * l->m->n_channel;
    ff_model_defaults(l->m, l->n_channels, NULL, channel);
    if (l->limits) memcpy(channel, l->limits->init, size * sizeof *channel);
}

void ff_layout_defaults(const ff_layout *l, double *shape, double *channel)
{
    ff_model_defaults(l->m, l->n_channels, shape, NULL);
    if (channel) ff_layout_channel_defaults(l, channel);
    for (uint32_t k = 0; k < l->m->n_shape && l->mode == FF_ISOTROPIC_MODE; k++) /* one roughness, also where it is held */
        if (strcmp(l->m->shape[k].info->name, "alpha_x") == 0) shape[k + 1] = shape[k];
    if (l->tied) ff_layout_project(l, shape, channel);
}

ff_status ff_layout_normal(const ff_layout *l, ff_normal *out)
{
    return ff_normal_new(l->free.n_shape, l->free.n_channel, l->n_channels, l->arrowhead, out);
}

void ff_layout_bounds(const ff_layout *l, double *lower, double *upper)
{
    for (size_t k = 0; k < l->P; k++) {
        const ff_param *info = ff_layout_param(l, k, NULL)->info;
        double lo, hi;
        ff_layout_range(l, k, &lo, &hi);
        lower[k] = ff_coordinate(info, lo);
        upper[k] = ff_coordinate(info, hi);
    }
}
