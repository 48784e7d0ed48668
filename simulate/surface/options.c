/* How a surface is made and asked: defaults, and what is in range. */
#include "internal_surface.h"
#include "base/internal_options.h"
#include "base/internal_vector_math.h"
#include "simulate/walk/internal_walk.h"
#include <math.h>

void ff_height_field_options_init_size(ff_height_field_options *o, size_t size)
{
    const ff_height_field_options defaults = {.hurst = 0.8,
                                              .correlation = 16,
                                              .cells = 512,
                                              .realisations = 16,
                                              .pitch = {NAN, NAN},
                                              .height_unit = 1,
                                              .aperture = 2.5 * FF_PI / 180,
                                              .seed = 1,
                                              .paths = 1000000,
                                              .n_orders = 1,
                                              .orders = {{1, 0}}};
    ff_options_init(o, size, &defaults, sizeof defaults);
}

static ff_status range(ff_error *err, const char *what, double found, const char *expected)
{
    return ff_error_set(err, FF_ERR_RANGE, NULL, 0, -1, "%s %g, expected %s", what, found, expected);
}

static ff_status check_orders(const ff_height_field_options *o, ff_error *err)
{
    if (o->n_orders < 1 || o->n_orders > FF_WALK_ORDERS) return range(err, "groups of orders", (double)o->n_orders, "1 to 16");
    for (size_t k = 0; k < o->n_orders; k++)
        if (o->orders[k].first < 1 || o->orders[k].first > FF_WALK_MOST ||
            (o->orders[k].last && o->orders[k].last < o->orders[k].first))
            return range(err, "orders from", o->orders[k].first, "1 to 4096, and none backwards");
    return FF_OK;
}

ff_status ff_height_field_check(const ff_height_field_options *o, ff_error *err)
{
    if ((unsigned)o->spectrum > FF_SPECTRUM_POWER_LAW) return range(err, "a spectrum of number", (double)o->spectrum, "0 to 2");
    if (!(o->hurst > 0 && o->hurst <= 1)) return range(err, "an exponent of", o->hurst, "above 0, up to 1");
    if (!(o->correlation >= 2 && o->correlation <= 1024))
        return range(err, "a correlation length of", o->correlation, "2 to 1024 cells");
    if (o->cells < 16 || o->cells > 8192) return range(err, "cells along an axis:", (double)o->cells, "16 to 8192");
    if (o->realisations < 2 || o->realisations > 100000) return range(err, "realisations:", (double)o->realisations, "2 to 100000");
    for (int k = 0; k < 2; k++)
        if (!isnan(o->pitch[k]) && !(o->pitch[k] > 0 && isfinite(o->pitch[k])))
            return range(err, "a pitch of", o->pitch[k], "a number above 0");
    if (!(o->height_unit > 0 && isfinite(o->height_unit)))
        return range(err, "a unit of heights of", o->height_unit, "a number above 0");
    if (o->facets != FF_FACETS_MIRROR && o->facets != FF_FACETS_LAMBERT)
        return range(err, "facets of number", (double)o->facets, "0 or 1");
    if (!(o->aperture >= 0.001 && o->aperture <= FF_PI / 6))
        return range(err, "a half angle of", o->aperture, "0.001 to 0.5 radians");
    if (o->paths < o->realisations || o->paths > UINT64_C(1000000000000))
        return range(err, "paths:", (double)o->paths, "one for each realisation, up to 1e12");
    if (o->threads < 0 || o->threads > 1024) return range(err, "threads:", o->threads, "0 to 1024");
    return check_orders(o, err);
}
