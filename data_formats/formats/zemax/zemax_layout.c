/* The grid of a Zemax file to be written: what the person asks for, else what the data have. */
#include "internal_zemax.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

static const double degree = 3.14159265358979323846 / 180;
const double ff_zemax_axis_most[FF_ZEMAX_AXES] = {360, 90, 360, 180};
const char *const ff_zemax_xyz[3] = {"X", "Y", "Z"};

int ff_zemax_symmetry_of(const ff_table *t)
{
    const double *azimuth = t->axes.node[FF_ZEMAX_AZIMUTH], half = 180 * degree / t->radians_per_unit;
    if (t->axes.n[FF_ZEMAX_ROTATION] > 1) return FF_ZEMAX_ASYMMETRICAL_4D;
    return azimuth[0] >= 0 && azimuth[t->axes.n[FF_ZEMAX_AZIMUTH] - 1] <= half ? FF_ZEMAX_PLANE_SYMMETRICAL : FF_ZEMAX_ASYMMETRICAL;
}

ff_status ff_zemax_check_channels(const ff_table *t, const char *path, ff_error *err)
{
    int same = t->n_channels == 3;
    for (size_t c = 0; c < 3 && same; c++) same = strcmp(t->channels[c].name, ff_zemax_xyz[c]) == 0;
    if (t->n_channels == 1 || same) return FF_OK;
    return ff_error_set(err, FF_ERR_UNSUPPORTED, path, 0, -1,
                        "found %zu channels ('%s' first), but a file of this format has one, or the tristimulus values X, Y and Z; "
                        "write one file per channel, or csv",
                        t->n_channels, t->channels[0].name);
}

enum { MOST_SAMPLES = 200000000 };

/* Of isotropic data and one rotation the azimuths of half a circle. */
static const ff_scatter_limits whole = {15, {360, 89.9, 360, 180}, {360, 85, 360, 175}},
                               half = {15, {360, 89.9, 180, 180}, {360, 85, 180, 175}};

static ff_status plan_radial(ff_scatter_plan *p, ff_error *err)
{
    static const double from[] = {0, 2, 5, 10, 20, 60}, step[] = {0.5, 1, 2.5, 5, 5, 10}, to[] = {1.5, 4, 7.5, 15, 55, 170};
    ff_status status = FF_OK;
    for (int k = 0; k < 6 && status == FF_OK; k++)
        status = ff_scatter_plan_steps(&p->axis[FF_ZEMAX_RADIAL], from[k], to[k], step[k], err);
    return status;
}

/* Data of this layout keep their own angles. */
static ff_status plan_like(const ff_table *t, ff_scatter_plan *p, ff_error *err)
{
    ff_status status = FF_OK;
    for (int k = 0; k < FF_ZEMAX_AXES && status == FF_OK; k++)
        if (!p->axis[k].n)
            status = ff_scatter_plan_copy(&p->axis[k], t->axes.n[k], t->axes.node[k], t->radians_per_unit / degree, err);
    return status;
}

static ff_status fill_plan(const ff_table *t, const char *grid, const ff_scatter_limits *limits, ff_scatter_plan *p, ff_error *err)
{
    ff_values *const axis = p->axis;
    ff_status status = grid ? ff_scatter_plan_parse(grid, limits, p, err) : FF_OK;
    if (status == FF_OK && t->axes.kind == FF_AXES_SPECULAR) status = plan_like(t, p, err);
    if (status == FF_OK && !axis[FF_ZEMAX_ROTATION].n)
        status = t->isotropic ? ff_scatter_plan_add(&axis[FF_ZEMAX_ROTATION], 0, err)
                              : ff_scatter_plan_from_data(t, FF_ZEMAX_ROTATION, p, err);
    if (status == FF_OK && !axis[FF_ZEMAX_INCIDENCE].n) status = ff_scatter_plan_from_data(t, FF_ZEMAX_INCIDENCE, p, err);
    if (status == FF_OK && !axis[FF_ZEMAX_AZIMUTH].n)
        status = ff_scatter_plan_steps(&axis[FF_ZEMAX_AZIMUTH], 0, limits->end[FF_ZEMAX_AZIMUTH], 10, err);
    if (status == FF_OK && !axis[FF_ZEMAX_RADIAL].n) status = plan_radial(p, err);
    return status;
}

static ff_status make_layout(const ff_table *t, const ff_scatter_plan *p, int symmetry, ff_table *out, ff_error *err)
{
    ff_zemax_cells c;
    size_t n[FF_ZEMAX_AXES];
    const double *node[FF_ZEMAX_AXES];
    double samples = (double)t->n_channels;
    for (int k = 0; k < FF_ZEMAX_AXES; k++) n[k] = p->axis[k].n, node[k] = p->axis[k].value, samples *= (double)n[k];
    if (samples > MOST_SAMPLES)
        return ff_error_set(err, FF_ERR_RANGE, NULL, 0, -1, "grid: found %.0f values, expected at most %d: take larger steps",
                            samples, MOST_SAMPLES);
    ff_status status = ff_zemax_cells_make(n, node, symmetry, &c, err);
    if (status != FF_OK) return status;
    status = ff_table_init_axes(FF_AXES_SPECULAR, n, node, degree, t->n_channels, ff_zemax_has_cells(n, node), out, err);
    if (status == FF_OK) {
        const double *const of[FF_ZEMAX_AXES] = {c.of[0], c.of[1], c.of[2], c.of[3]};
        if (out->weight) ff_table_product_weights(out, of);
        out->isotropic = n[FF_ZEMAX_ROTATION] == 1;
        ff_table_name_channels_like(out, t);
    }
    free(c.memory);
    return status;
}

/* Several rotations are a file of the full circle, whatever the data: between two of them readers need both sides of the plane. */
static ff_status choose_limits(const ff_table *t, const char *grid, const ff_scatter_limits **out, ff_error *err)
{
    ff_scatter_plan p = {0};
    const ff_status status = grid && t->isotropic ? ff_scatter_plan_parse(grid, &whole, &p, err) : FF_OK;
    int halves = t->isotropic && p.axis[FF_ZEMAX_ROTATION].n < 2;
    if (t->axes.kind == FF_AXES_SPECULAR) halves &= ff_zemax_symmetry_of(t) == FF_ZEMAX_PLANE_SYMMETRICAL;
    *out = halves ? &half : &whole;
    ff_scatter_plan_clear(&p);
    return status;
}

ff_status ff_zemax_layout(const ff_table *t, const char *grid, ff_table *out, ff_error *err)
{
    ff_scatter_plan p = {0};
    const ff_scatter_limits *limits = NULL;
    ff_status status = ff_zemax_check_channels(t, NULL, err);
    if (status == FF_OK) status = choose_limits(t, grid, &limits, err);
    if (status == FF_OK) status = fill_plan(t, grid, limits, &p, err);
    if (status == FF_OK)
        status = make_layout(t, &p, limits == &half ? FF_ZEMAX_PLANE_SYMMETRICAL : FF_ZEMAX_ASYMMETRICAL, out, err);
    ff_scatter_plan_clear(&p);
    return status;
}
