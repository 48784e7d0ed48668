/* The order of lobes of one kind. */
#include "internal_fit.h"
#include <math.h>
#include <string.h>

/* What orders them: the width of a stretched lobe, else the first parameter. */
static double order_key(const ff_model *m, uint32_t l, const double *shape)
{
    ff_lobe_pass pass;
    const ff_lobe *lobe = &m->lobe[l];
    if (lobe->n_shape == 0 || ff_ndf_at(lobe->ndf)->stretch) return lobe->n_shape ? shape[lobe->shape0] : 0;
    ff_model_lobe(m, l, shape, &pass, NULL);
    return pass.s.ax * pass.s.ay * sqrt(1 - pass.s.r * pass.s.r);
}

static int held_alike(const ff_model_param *a, const ff_model_param *b)
{
    const uint32_t held = a->flags & FF_PARAM_HELD;
    return held == (b->flags & FF_PARAM_HELD) && (!held || a->init == b->init);
}

/* Would the sum be the same with the two lobes exchanged, and nothing that is held move? */
static int same_kind(const ff_model *m, uint32_t a, uint32_t b)
{
    const ff_lobe *x = &m->lobe[a], *y = &m->lobe[b];
    const int shared = ff_model_group(m, a) == ff_model_group(m, b);
    if (x->ndf != y->ndf || x->masking != y->masking || x->table != y->table || !(shared || x->fresnel == y->fresnel)) return 0;
    for (uint32_t k = 0; k < x->n_shape && k < y->n_shape; k++)
        if (!held_alike(&m->shape[x->shape0 + k], &m->shape[y->shape0 + k])) return 0;
    for (uint32_t k = 0; !shared && k < x->n_channel; k++)
        if (!held_alike(&m->channel[x->channel0 + k], &m->channel[y->channel0 + k])) return 0;
    return 1;
}

static void swap(double *a, double *b, size_t n)
{
    for (size_t i = 0; i < n; i++) {
        const double t = a[i];
        a[i] = b[i];
        b[i] = t;
    }
}

/* Exchanges what belongs to lobes a and b but for the weights. */
static void exchange(const ff_model *m, uint32_t a, uint32_t b, size_t n_channels, double *shape, double *channel)
{
    const ff_lobe *x = &m->lobe[a], *y = &m->lobe[b];
    const size_t n = x->n_shape < y->n_shape ? x->n_shape : y->n_shape; /* `weight` is the last of a lobe that shares */
    swap(shape + x->shape0, shape + y->shape0, n - (size_t)(x->fresnel == FF_FRESNEL_SHARED && y->fresnel == FF_FRESNEL_SHARED));
    if (ff_model_group(m, a) == ff_model_group(m, b)) return;
    for (size_t c = 0; c < n_channels; c++)
        swap(channel + c * m->n_channel + x->channel0, channel + c * m->n_channel + y->channel0, x->n_channel);
}

/* Shares that give these weights; see ff_model_weights. */
static void set_weights(const ff_model *m, const double *weight, double *shape)
{
    double up_to = weight[0];
    for (uint32_t l = 1; l < m->n_lobes; l++) {
        if (m->lobe[l].fresnel != FF_FRESNEL_SHARED) continue;
        up_to += weight[l];
        shape[m->lobe[l].shape0 + m->lobe[l].n_shape - 1] = up_to > 0 ? weight[l] / up_to : 0;
    }
}

int ff_lobes_order(const ff_model *m, size_t n_channels, double *shape, double *channel)
{
    double weight[FF_MAX_LOBES];
    int moved = 0;
    ff_model_weights(m, shape, weight, NULL);
    for (uint32_t pass = 1; pass < m->n_lobes; pass++)
        for (uint32_t a = 0; a < m->n_lobes; a++)
            for (uint32_t b = a + 1; b < m->n_lobes; b++) {
                if (!same_kind(m, a, b) || order_key(m, a, shape) <= order_key(m, b, shape)) continue;
                exchange(m, a, b, n_channels, shape, channel);
                if (ff_model_group(m, a) == ff_model_group(m, b)) swap(&weight[a], &weight[b], 1);
                moved = 1;
            }
    if (moved) set_weights(m, weight, shape);
    return moved;
}
