#include "simulate_struct.h"
#include "internal_sampling.h"
#include "internal_simulated.h"
#include "base/internal_options.h"
#include "data_formats/table/internal_table.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { BLOCK = 1024 };

void ff_simulate_options_init_size(ff_simulate_options *o, size_t size)
{
    const ff_simulate_options defaults = {.sampling = {FF_SAMPLING_GONIOMETER, 5, 1, 0}, .seed = 1};
    ff_options_init(o, size, &defaults, sizeof defaults);
}

/* Channel c of n colours. */
static void name_colour(size_t n, size_t c, char out[FF_CHANNEL_NAME / 2])
{
    static const char *const rgb[] = {"r", "g", "b"};
    if (n == 3)
        snprintf(out, FF_CHANNEL_NAME / 2, "%s", rgb[c]);
    else if (n == 1)
        snprintf(out, FF_CHANNEL_NAME / 2, "f");
    else
        snprintf(out, FF_CHANNEL_NAME / 2, "c%zu", c);
}

/* With several groups of orders their names, and before those of colours where there are any: "2+", "2+_r". */
static void name_channels(const ff_simulate_options *o, ff_table *t)
{
    size_t n_orders;
    const ff_orders *orders = ff_simulated_orders(o, &n_orders);
    const size_t n = t->n_channels / n_orders;
    for (size_t c = 0; c < t->n_channels; c++) {
        char order[FF_CHANNEL_NAME / 4] = "", colour[FF_CHANNEL_NAME / 2];
        name_colour(n, c % n, colour);
        if (n_orders > 1) ff_orders_name(orders[c / n], order, sizeof order);
        snprintf(t->channels[c].name, FF_CHANNEL_NAME, "%s%s%s", order, n_orders > 1 && n > 1 ? "_" : "",
                 n_orders > 1 && n == 1 ? "" : colour);
    }
}

/* Standard deviation of a value, 1/sr. */
static double deviation(const ff_simulate_options *o, double f, size_t channel, double cos_i, double cos_o)
{
    return o->noise ? ff_noise_sd(o->noise, channel, f, cos_i, cos_o) : hypot(o->relative * f, o->floor);
}

static double noisy(const ff_simulate_options *o, double f, double sd, size_t sample, size_t channel)
{
    double y = f;
    if (o->noise) return f + sd * ff_random_normal(o->seed, (uint32_t)channel, 2 * (uint64_t)sample);
    if (o->relative > 0) y *= 1 + o->relative * ff_random_normal(o->seed, (uint32_t)channel, 2 * (uint64_t)sample);
    if (o->floor > 0) y += o->floor * ff_random_normal(o->seed, (uint32_t)channel, 2 * (uint64_t)sample + 1);
    return y;
}

/* Stores one block of one channel; f in 1/sr and its standard error, NULL where it has none, w its directions. The count of values
 * that were below 0 and are not any more. */
static size_t store(const ff_simulate_options *o, ff_table *t, size_t c, size_t first, size_t n, const ff_dirs *w, const double *f,
                    const double *error)
{
    double *value = t->value + c * t->n + first, *sigma = t->sigma ? t->sigma + c * t->n + first : NULL;
    size_t raised = 0;
    for (size_t i = 0; i < n; i++) {
        if (!t->valid[first + i]) continue;
        const double sd = deviation(o, f[i], c, w->wiz[i], w->woz[i]);
        double y = noisy(o, f[i], sd, first + i, c);
        if (o->nonnegative && y < 0) {
            y = 0;
            raised++;
        }
        value[i] = y;
        if (sigma) sigma[i] = error ? hypot(sd, error[i]) : sd;
    }
    return raised;
}

static void mark_below_horizon(ff_table *t, size_t first, size_t n, const double *iz, const double *oz)
{
    for (size_t i = 0; i < n; i++) {
        if (iz[i] > FF_COS_MIN && oz[i] > FF_COS_MIN) continue;
        t->valid[first + i] = 0;
        t->n_invalid++;
    }
}

/* A value of exactly 0 under multiplicative noise has no standard deviation, and a weight of 1/0 is no weight. */
static void drop_without_sigma(ff_table *t)
{
    for (size_t c = 0; t->sigma && c < t->n_channels; c++)
        for (size_t i = 0; i < t->n; i++) {
            if (!t->valid[i] || t->sigma[c * t->n + i] > 0) continue;
            t->valid[i] = 0;
            t->n_invalid++;
        }
}

static void count_negative(ff_table *t)
{
    for (size_t i = 0; i < t->n; i++) {
        int negative = 0;
        for (size_t c = 0; c < t->n_channels; c++) negative |= t->valid[i] && t->value[c * t->n + i] < 0;
        t->n_negative += (size_t)negative;
    }
}

/* The model at a block of directions; what is not known well enough of means over an aperture is counted. */
typedef struct apertures {
    double error[BLOCK], worst;
    size_t rough;
} apertures;

static ff_status evaluate(const ff_model *m, size_t n_channels, const double *shape, const double *channel,
                          const ff_simulate_options *o, const ff_dirs *w, size_t n, double *f, apertures *a, ff_error *err)
{
    const ff_aperture point = {.outline = FF_APERTURE_DISC};
    const ff_status status =
        ff_aperture_eval(o->aperture ? o->aperture : &point, m, o->isa, n_channels, shape, channel, w, n, f, NULL, a->error, BLOCK);
    for (size_t i = 0; i < n && status == FF_OK; i++) {
        a->rough += a->error[i] > FF_APERTURE_TOLERANCE;
        a->worst = fmax(a->worst, a->error[i]);
    }
    return status ? ff_error_set(err, status, NULL, 0, -1, "the model cannot be evaluated") : FF_OK;
}

static void say(ff_table *t, size_t raised, const apertures *a)
{
    if (raised > 0)
        ff_table_note(t, "%zu values fell below 0 by noise and are stored as 0, since the file can hold no negative measurement",
                      raised);
    if (a->rough > 0)
        ff_table_note(t, "%zu means over the aperture are not known to %g of their value; the worst to %.1g", a->rough,
                      FF_APERTURE_TOLERANCE, a->worst);
}

/* known: values that were simulated, of as many channels as the table or of fewer, the last of which stands for the others; f NULL:
 * those of the model. */
static ff_status fill(const ff_model *m, const double *shape, const double *channel, const ff_simulate_options *o,
                      const ff_simulated *known, ff_table *t, ff_error *err)
{
    double *f = malloc((t->n_channels + 6) * BLOCK * sizeof *f), *planes[6];
    apertures *a = calloc(1, sizeof *a);
    ff_status status =
        f && a ? FF_OK : ff_error_set(err, FF_ERR_MEMORY, NULL, 0, -1, "no memory for a block of %zu channels", t->n_channels);
    size_t raised = 0;
    for (size_t k = 0; k < 6 && f; k++) planes[k] = f + (t->n_channels + k) * BLOCK;
    for (size_t first = 0; first < t->n && status == FF_OK; first += BLOCK) {
        const size_t n = t->n - first < BLOCK ? t->n - first : BLOCK;
        const ff_dirs w = {planes[0], planes[1], planes[2], planes[3], planes[4], planes[5]};
        if (o->cancel && *o->cancel) {
            status = ff_error_set(err, FF_ERR_CANCELLED, NULL, 0, -1, "cancelled at sample %zu of %zu", first, t->n);
            break;
        }
        ff_table_directions(t, first, n, planes);
        mark_below_horizon(t, first, n, planes[2], planes[5]);
        if (!known->f) status = evaluate(m, t->n_channels, shape, channel, o, &w, n, f, a, err);
        for (size_t c = 0; c < t->n_channels && status == FF_OK; c++) {
            const size_t from = (c < known->n_planes ? c : known->n_planes - 1) * t->n + first;
            raised +=
                store(o, t, c, first, n, &w, known->f ? known->f + from : f + c * BLOCK, known->f ? known->error + from : NULL);
        }
    }
    if (status == FF_OK) say(t, raised, a);
    free(a);
    free(f);
    drop_without_sigma(t);
    return status;
}

static ff_status check_options(const ff_simulate_options *o, size_t n_channels, ff_error *err)
{
    if (o->size != sizeof *o) return ff_error_set(err, FF_ERR_INTERNAL, NULL, 0, -1, "ff_simulate_options of another version");
    if (!(o->relative >= 0 && isfinite(o->relative)))
        return ff_error_set(err, FF_ERR_RANGE, NULL, 0, -1, "relative noise %g, expected a number >= 0", o->relative);
    if (!(o->floor >= 0 && isfinite(o->floor)))
        return ff_error_set(err, FF_ERR_RANGE, NULL, 0, -1, "noise floor %g 1/sr, expected a number >= 0", o->floor);
    if (o->noise && (o->relative > 0 || o->floor > 0))
        return ff_error_set(err, FF_ERR_RANGE, NULL, 0, -1, "a noise model takes the place of relative noise and a noise floor");
    if (o->noise && ff_noise_level_count(o->noise) != 1 && ff_noise_level_count(o->noise) != n_channels)
        return ff_error_set(err, FF_ERR_RANGE, NULL, 0, -1, "a noise model of %zu channels, expected one of %zu",
                            ff_noise_level_count(o->noise), n_channels);
    if (o->sigma && !o->noise && o->relative == 0 && o->floor == 0 && !o->walk && !o->surface)
        return ff_error_set(err, FF_ERR_RANGE, NULL, 0, -1,
                            "without noise there is no sigma to write: give a relative noise, a noise floor or a noise model");
    if (o->walk && o->surface) return ff_error_set(err, FF_ERR_RANGE, NULL, 0, -1, "a walk and a surface, expected one of them");
    if ((o->walk || o->surface) && o->aperture && (o->aperture->half > 0 || o->aperture->source > 0))
        return ff_error_set(err, FF_ERR_UNSUPPORTED, NULL, 0, -1,
                            "paths of light go from point to point, or to the cones of a surface, through no other aperture");
    if (!ff_isa_available(o->isa))
        return ff_error_set(err, FF_ERR_UNSUPPORTED, NULL, 0, -1, "this processor has no %s", ff_isa_name(o->isa));
    return FF_OK;
}

ff_status ff_simulate_into(const ff_model *m, size_t n_channels, const double *shape, const double *channel,
                           const ff_simulate_options *o, ff_table *out, ff_error *err)
{
    ff_table t;
    ff_simulated known = {0};
    size_t n_orders;
    (void)ff_simulated_orders(o, &n_orders);
    ff_status status = check_options(o, n_channels * n_orders, err);
    if (status == FF_OK) status = ff_model_check(m, n_channels, shape, channel, err);
    if (status != FF_OK) return status;
    const int isotropic = (ff_model_claims(m, shape) & FF_ISOTROPIC) != 0;
    status = ff_sampling_table(&o->sampling, o->seed, isotropic, n_channels * n_orders, o->sigma, &t, err);
    if (status != FF_OK) return status;
    name_channels(o, &t);
    status = ff_simulated_values(m, n_channels, shape, channel, o, &t, &known, err);
    if (status == FF_OK) status = fill(m, shape, channel, o, &known, &t, err);
    free(known.f);
    if (status != FF_OK) {
        ff_table_clear(&t);
        return status;
    }
    count_negative(&t);
    *out = t;
    return FF_OK;
}

ff_status ff_simulate(const ff_model *m, size_t n_channels, const double *shape, const double *channel,
                      const ff_simulate_options *o, ff_table **out, ff_error *err)
{
    ff_simulate_options own;
    ff_table made;
    ff_simulate_options_init(&own);
    ff_status status = ff_options_take("ff_simulate_options", o, FF_END_OF(ff_simulate_options, cancel), &own, sizeof own, err);
    if (!status) status = ff_simulate_into(m, n_channels, shape, channel, &own, &made, err);
    return status ? status : ff_table_move(&made, out, err);
}

/* ---- in the layout of a file ----------------------------------------------------------------- */

/* The channels of the model as a layout has them: of one all are copies. Freed by the caller; NULL without memory. */
static double *channels_for(const ff_model *m, size_t n_channels, const double *channel, size_t n)
{
    double *made = malloc((n * m->n_channel + 1) * sizeof *made);
    for (size_t c = 0; made && c < n; c++)
        memcpy(made + c * m->n_channel, channel + (c < n_channels ? c : n_channels - 1) * m->n_channel,
               m->n_channel * sizeof *made);
    return made;
}

/* A plane of standard deviations, where they are asked for; what the format cannot hold its writer says. */
static ff_status add_sigma(const ff_simulate_options *o, ff_table *t, ff_error *err)
{
    if (!o->sigma || t->sigma) return FF_OK;
    t->sigma = calloc(t->n * t->n_channels, sizeof *t->sigma);
    if (t->sigma) return FF_OK;
    return ff_error_set(err, FF_ERR_MEMORY, NULL, 0, -1, "no memory for %zu standard deviations", t->n * t->n_channels);
}

static ff_status fill_layout(const ff_model *m, size_t n_channels, const double *shape, const double *channel,
                             const ff_simulate_options *o, ff_table *t, ff_error *err)
{
    ff_simulated known = {0};
    double *channels = channels_for(m, n_channels, channel, t->n_channels);
    if (!channels) return ff_error_set(err, FF_ERR_MEMORY, NULL, 0, -1, "no memory for %zu channels", t->n_channels);
    ff_status status = add_sigma(o, t, err);
    if (status == FF_OK) status = ff_simulated_values(m, n_channels, shape, channel, o, t, &known, err);
    if (status == FF_OK) status = fill(m, shape, channels, o, &known, t, err);
    free(known.f);
    for (size_t c = 0; c < t->n_channels && status == FF_OK; c++)
        for (size_t i = 0; i < t->n; i++) {
            t->value[c * t->n + i] /= t->channels[c].scale;
            if (t->sigma) t->sigma[c * t->n + i] /= t->channels[c].scale;
        }
    free(channels);
    if (status == FF_OK) count_negative(t);
    return status;
}

/* The model in as many channels as the orders of a walk make of it. */
static ff_status simulate_plain(const ff_model *m, size_t n_channels, const double *shape, const double *channel, size_t n_planes,
                                const ff_simulate_options *o, ff_table *out, ff_error *err)
{
    double *all = malloc((n_planes * m->n_channel + 1) * sizeof *all);
    if (!all) return ff_error_set(err, FF_ERR_MEMORY, NULL, 0, -1, "no memory for %zu channels", n_planes);
    for (size_t c = 0; c < n_planes; c++)
        memcpy(all + c * m->n_channel, channel + c % n_channels * m->n_channel, m->n_channel * sizeof *all);
    const ff_status status = ff_simulate_into(m, n_planes, shape, all, o, out, err);
    free(all);
    return status;
}

ff_status ff_simulate_layout_into(const ff_model *m, size_t n_channels, const double *shape, const double *channel,
                                  const ff_format *to, const char *grid, const ff_simulate_options *o, ff_table *out, ff_error *err)
{
    ff_simulate_options plain_options;
    ff_table plain, made = {0};
    size_t n_orders;
    (void)ff_simulated_orders(o, &n_orders);
    const size_t n_planes = n_channels * n_orders;
    if (!to->layout) return ff_simulate_into(m, n_channels, shape, channel, o, out, err);
    ff_status status = check_options(o, n_planes, err);
    if (status != FF_OK) return status;
    ff_simulate_options_init(&plain_options);
    plain_options.isa = o->isa;
    status = simulate_plain(m, n_channels, shape, channel, n_planes, &plain_options, &plain, err);
    if (status != FF_OK) return status;
    name_channels(o, &plain);
    status = to->layout(&plain, grid, &made, err);
    if (status != FF_OK || made.n == 0) { /* none: the format takes any directions */
        ff_table_clear(&plain);
        return status != FF_OK ? status : ff_simulate_into(m, n_channels, shape, channel, o, out, err);
    }
    ff_table_clear(&plain);
    status = fill_layout(m, n_channels, shape, channel, o, &made, err);
    if (status == FF_OK)
        *out = made;
    else
        ff_table_clear(&made);
    return status;
}
