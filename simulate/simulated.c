#include "internal_simulated.h"
#include <stdlib.h>
#include <string.h>

/* Pairs of a table that lie above the horizon: their samples, and their directions as planes. */
typedef struct pairs {
    size_t n, *sample;
    double *w[6];
} pairs;

static void pairs_free(pairs *p)
{
    free(p->sample);
    free(p->w[0]);
}

static ff_status pairs_of(const ff_table *t, pairs *out, ff_error *err)
{
    double *planes = malloc(6 * t->n * sizeof *planes), *w[6];
    *out = (pairs){.sample = malloc(t->n * sizeof *out->sample)};
    out->w[0] = planes;
    if (!planes || !out->sample) {
        pairs_free(out);
        return ff_error_set(err, FF_ERR_MEMORY, NULL, 0, -1, "no memory for the directions of %zu samples", t->n);
    }
    for (size_t k = 0; k < 6; k++) out->w[k] = w[k] = planes + k * t->n;
    ff_table_directions(t, 0, t->n, w);
    for (size_t i = 0; i < t->n; i++) {
        if (!(w[2][i] > FF_COS_MIN && w[5][i] > FF_COS_MIN)) continue;
        for (size_t k = 0; k < 6; k++) w[k][out->n] = w[k][i];
        out->sample[out->n++] = i;
    }
    return FF_OK;
}

/* values [2 n_planes][t->n] from the first pairs of each plane to the samples that they belong to; from the last on, lest one be
 * overwritten. */
static void spread(const pairs *p, size_t n_samples, size_t n_planes, double *values)
{
    for (size_t k = 0; k < 2 * n_planes; k++) {
        double *plane = values + k * n_samples;
        size_t end = n_samples;
        for (size_t i = p->n; i-- > 0; end = p->sample[i]) {
            const double x = plane[i];
            memset(plane + p->sample[i], 0, (end - p->sample[i]) * sizeof *plane);
            plane[p->sample[i]] = x;
        }
        memset(plane, 0, end * sizeof *plane);
    }
}

const ff_orders *ff_simulated_orders(const ff_simulate_options *o, size_t *n)
{
    *n = o->walk ? o->walk->n_orders : o->surface ? o->surface->n_orders : 1;
    return o->walk ? o->walk->orders : o->surface ? o->surface->orders : NULL;
}

/* f [2 n_planes][t->n]: values, then errors, of the pairs in a row. */
static ff_status by_walk(const ff_model *m, size_t n_channels, const double *shape, const double *channel, const ff_walk_options *o,
                         const ff_dirs *w, size_t n, double *f, double *error, size_t ld, ff_error *err)
{
    ff_walk *walk;
    ff_status status = ff_walk_new(m, n_channels, shape, channel, o, &walk, err);
    if (status) return status;
    status = ff_walk_values(walk, w, n, 0, f, error, ld, err);
    ff_walk_free(walk);
    return status;
}

static ff_status by_rays(const ff_model *m, size_t n_channels, const double *shape, const double *channel,
                         const ff_height_field_options *o, const ff_dirs *w, size_t n, int isotropic, double *f, double *error,
                         size_t ld, ff_error *err)
{
    ff_height_field *surface;
    ff_status status = ff_height_field_new(m, n_channels, shape, channel, o, &surface, err);
    if (status) return status;
    status = ff_height_field_values(surface, w, n, isotropic, f, error, ld, err);
    ff_height_field_free(surface);
    return status;
}

ff_status ff_simulated_values(const ff_model *m, size_t n_channels, const double *shape, const double *channel,
                              const ff_simulate_options *o, const ff_table *t, ff_simulated *out, ff_error *err)
{
    pairs p;
    size_t n_orders;
    if (!ff_simulated_orders(o, &n_orders)) return FF_OK;
    const size_t n_planes = n_channels * n_orders;
    ff_status status = pairs_of(t, &p, err);
    if (status) return status;
    double *f = malloc(2 * n_planes * t->n * sizeof *f), *error = f ? f + n_planes * t->n : NULL;
    const ff_dirs w = {p.w[0], p.w[1], p.w[2], p.w[3], p.w[4], p.w[5]};
    if (!f)
        status = ff_error_set(err, FF_ERR_MEMORY, NULL, 0, -1, "no memory for %zu values", n_planes * t->n);
    else if (o->walk)
        status = by_walk(m, n_channels, shape, channel, o->walk, &w, p.n, f, error, t->n, err);
    else
        status = by_rays(m, n_channels, shape, channel, o->surface, &w, p.n, t->isotropic, f, error, t->n, err);
    if (!status) {
        spread(&p, t->n, n_planes, f);
        *out = (ff_simulated){n_planes, f, error};
    } else {
        free(f);
    }
    pairs_free(&p);
    return status;
}
