/* The channel parameters of a start. For given shape parameters the linear ones (f0, kd of every channel) follow from a small
 * bounded least-squares problem, so that only the shape is searched (grid.c), exact in the rest. */
#include "internal_start.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Is free channel parameter k multiplied by a free scale? */
static int is_scaled(const ff_layout *l, uint32_t k)
{
    const uint32_t at = l->free.channel[k], lobe = l->m->channel[at].lobe;
    return lobe < l->m->n_lobes && (l->scaled >> lobe & 1) && at + 1 < l->m->lobe[lobe].channel0 + l->m->lobe[lobe].n_channel;
}

/* The bounded minimum of all channels by the gram of their columns at `at`; out may be at. products: out gets the products with the
 * free scales, which have no upper bound. Returns the sum of the minima. */
static double step_channels(const ff_layout *l, const ff_normal *normal, const double *at, int products, double *out)
{
    const size_t n = l->free.n_channel, stride = l->m->n_channel, tri = normal->m1 * (normal->m1 + 1) / 2;
    double sum = 0;
    if (l->tied) return ff_tied_least_squares(l, normal, at, out);
    for (size_t c = 0; c < normal->n_channels; c++) {
        const double *gram = normal->gram + c * tri;
        double lo[FF_MAX_CHANNEL_PARAMS], hi[FF_MAX_CHANNEL_PARAMS], step[FF_MAX_CHANNEL_PARAMS] = {0};
        for (size_t k = 0; k < n; k++) {
            const uint32_t i = l->free.channel[k];
            const int product = products && is_scaled(l, (uint32_t)k);
            const double lowest = ff_layout_lo(l, c, i);
            lo[k] = (!product ? lowest : lowest < 0 ? -INFINITY : 0) - at[c * stride + i];
            hi[k] = (product ? INFINITY : ff_layout_hi(l, c, i)) - at[c * stride + i];
        }
        sum += n ? ff_bounded_least_squares(gram, n, lo, hi, step) : gram[0];
        for (size_t k = 0; k < n; k++) {
            const uint32_t own = l->free.channel[k];
            const size_t i = c * stride + own;
            out[i] = at[i] + step[k];
            if (!(products && is_scaled(l, (uint32_t)k)))
                out[i] = fmin(fmax(out[i], ff_layout_lo(l, c, own)), ff_layout_hi(l, c, own));
        }
    }
    return sum;
}

/* From the products with the free scales to the parameters themselves; a scale is at least what brings these into their box. */
static void divide_by_scales(const ff_layout *l, double *channel)
{
    for (size_t c = 0; c < l->n_channels; c++)
        for (uint32_t lobe = 0; lobe < l->m->n_lobes; lobe++) {
            if (!(l->scaled >> lobe & 1)) continue;
            const uint32_t scale = l->m->lobe[lobe].channel0 + l->m->lobe[lobe].n_channel - 1;
            double *ks = &channel[c * l->m->n_channel + scale];
            for (int pass = 0; pass < 2; pass++)
                for (uint32_t k = 0; k < l->free.n_channel; k++) {
                    const ff_model_param *p = &l->m->channel[l->free.channel[k]];
                    double *v = &channel[c * l->m->n_channel + l->free.channel[k]];
                    if (p->lobe != lobe || !is_scaled(l, k)) continue;
                    const double lo = ff_layout_lo(l, c, l->free.channel[k]), hi = ff_layout_hi(l, c, l->free.channel[k]);
                    if (pass == 0)
                        *ks = fmax(*ks, fmax(hi > 0 ? *v / hi : 0, lo < 0 ? *v / lo : 0));
                    else
                        *v = *ks > 0 ? fmin(fmax(*v / *ks, lo), hi) : fmin(fmax(p->init, lo), hi);
                }
            *ks = fmin(fmax(*ks, ff_layout_lo(l, c, scale)), ff_layout_hi(l, c, scale));
        }
}

/* A pass over a subsample that leaves the gram of the channel columns. plain: without the robust loss, whose weights mean
 * nothing far from the data. */
static ff_status channel_pass(const ff_plan *plan, const double *shape, const double *channel, int plain, ff_normal *normal)
{
    ff_pass pass;
    ff_status status = ff_plan_pass(plan, shape, channel, &pass);
    if (status) return status;
    if (plain) pass.robust = FF_ROBUST_NONE;
    status = ff_pass_run(&pass, 0, normal);
    ff_pass_free(&pass);
    return status;
}

/* Gauss-Newton steps from trial on the subsample, each halved until it helps. The best point goes to channel. */
static ff_status improve_channels(const ff_plan *plan, const double *shape, int steps, double *trial, double *channel,
                                  double *cost2, ff_normal *normal)
{
    const ff_layout *l = &plan->l;
    const ff_plan subsample = ff_plan_on(plan, plan->p->subsample);
    const size_t size = l->n_channels * l->m->n_channel;
    *cost2 = INFINITY;
    for (int step = 0; step <= steps; step++) {
        const ff_status status = channel_pass(&subsample, shape, trial, 0, normal);
        if (status && (status != FF_ERR_INTERNAL || *cost2 == INFINITY)) return status;
        if (!status && normal->cost2 < *cost2) { /* go on from here */
            const int enough = normal->cost2 > *cost2 * (1 - 1e-4);
            *cost2 = normal->cost2;
            memcpy(channel, trial, size * sizeof *trial);
            if (enough) break;
            step_channels(l, normal, channel, 0, trial);
        } else /* too far: half way back */
            for (size_t k = 0; k < size; k++) trial[k] = 0.5 * (trial[k] + channel[k]);
    }
    return FF_OK;
}

ff_status ff_start_channels(const ff_plan *plan, const double *shape, double *channel, double *cost2)
{
    const ff_layout *l = &plan->l;
    const struct ff_problem *p = plan->p;
    enum { STEPS = 4, CURVED_STEPS = 12 };
    const size_t size = l->n_channels * l->m->n_channel;
    const int exact = l->linear && !l->scaled && !p->subsample_linear->linearised && plan->robust == FF_ROBUST_NONE;
    const ff_plan channels = ff_plan_of_channels(plan), linear = ff_plan_on(&channels, p->subsample_linear);
    ff_normal normal = {0};
    ff_status status = ff_layout_normal(&channels.l, &normal);
    double *trial = malloc((size + 1) * sizeof *trial);
    if (!trial) status = status ? status : FF_ERR_MEMORY;
    if (!status) memcpy(trial, channel, size * sizeof *trial);
    if (!status && l->linear) {
        for (size_t c = 0; c < l->n_channels; c++)
            for (uint32_t k = 0; k < l->free.n_channel; k++) {
                const uint32_t at = l->free.channel[k];
                const uint32_t lobe = l->m->channel[at].lobe;
                /* a scale of 1: the columns are then those of the products */
                trial[c * l->m->n_channel + at] = lobe < l->m->n_lobes && (l->scaled >> lobe & 1) && !is_scaled(l, k);
            }
        status = channel_pass(&linear, shape, trial, 1, &normal);
        if (!status) *cost2 = step_channels(&channels.l, &normal, trial, 1, channel);
        if (!status) divide_by_scales(l, channel);
        if (!status) memcpy(trial, channel, size * sizeof *trial);
    }
    if (!status && !exact)
        status = improve_channels(&channels, shape, l->linear ? STEPS : CURVED_STEPS, trial, channel, cost2, &normal);
    ff_normal_free(&normal);
    free(trial);
    return status;
}
