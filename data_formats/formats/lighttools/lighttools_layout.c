/* The grid of a LightTools file to be written, and the cells about its nodes. */
#include "internal_lighttools.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

static const double degree = 3.14159265358979323846 / 180;
enum { THETA_I, PHI_I, THETA_O, PHI_O, AXES, MOST_SAMPLES = 200000000 };

int ff_lighttools_has_cells(const size_t n[AXES], const double *const node[AXES])
{
    return n[PHI_O] > 1 && ff_largest_gap(node[PHI_O], n[PHI_O]) <= 45 && n[THETA_O] > 1;
}

ff_status ff_lighttools_weigh(ff_table *t, int mirrored, ff_error *err)
{
    const size_t *n = t->axes.n;
    double *cell = malloc((n[0] + n[1] + n[2] + n[3]) * sizeof *cell), *of[AXES];
    if (!cell) return ff_error_set(err, FF_ERR_MEMORY, NULL, 0, -1, "no memory for the cells of %zu samples", t->n);
    for (int k = 0; k < AXES; k++) of[k] = k ? of[k - 1] + n[k - 1] : cell;
    ff_cells_polar(t->axes.node[THETA_I], n[THETA_I], 90, of[THETA_I]);
    ff_cells_circle(t->axes.node[PHI_I], n[PHI_I], 0, of[PHI_I]);
    ff_cells_polar(t->axes.node[THETA_O], n[THETA_O], 90, of[THETA_O]);
    ff_cells_circle(t->axes.node[PHI_O], n[PHI_O], mirrored, of[PHI_O]);
    const double *const factor[AXES] = {of[0], of[1], of[2], of[3]};
    ff_table_product_weights(t, factor);
    free(cell);
    return FF_OK;
}

/* ---- channels -------------------------------------------------------------------------------- */

int ff_lighttools_is_xyz(const ff_table *t)
{
    static const char *const xyz[3] = {"X", "Y", "Z"};
    int same = t->n_channels == 3;
    for (size_t c = 0; c < 3 && same; c++) same = strcmp(t->channels[c].name, xyz[c]) == 0;
    return same;
}

/* One value for each incidence, or several that a block can name. */
ff_status ff_lighttools_check_channels(const ff_table *t, const char *path, ff_error *err)
{
    int named = t->n_channels > 1;
    for (size_t c = 0; c < t->n_channels && named; c++) named = t->channels[c].wavelength_nm > 0;
    for (size_t c = 1; c < t->n_channels && named; c++)
        for (size_t b = 0; b < c && named; b++) named = t->channels[b].wavelength_nm != t->channels[c].wavelength_nm;
    if (t->n_channels == 1 || named || ff_lighttools_is_xyz(t)) return FF_OK;
    return ff_error_set(err, FF_ERR_UNSUPPORTED, path, 0, -1,
                        "found %zu channels ('%s' first), but a file of this format has one, the tristimulus values X, Y and Z, or "
                        "wavelengths, each another; write one file per channel, or csv",
                        t->n_channels, t->channels[0].name);
}

/* ---- for data -------------------------------------------------------------------------------- */

static const ff_scatter_limits limits = {
    1u << FF_SCATTER_INCIDENCE | 1u << FF_SCATTER_AZIMUTH | 1u << FF_SCATTER_RADIAL, {0, 89.9, 360, 90}, {0, 85, 360, 87.5}};

int ff_lighttools_is_layout(const ff_table *t)
{
    if (t->axes.kind != FF_AXES_INCIDENT_EXIT || t->axes.n[PHI_I] != 1) return 0;
    const double unit = t->radians_per_unit, *azimuth = t->axes.node[PHI_O];
    return fabs(t->axes.node[PHI_I][0] * unit - FF_LIGHTTOOLS_LIGHT * degree) < 1e-12 && azimuth[0] >= 0 &&
           azimuth[t->axes.n[PHI_O] - 1] * unit <= (360 + 1e-9) * degree;
}

/* Data of this layout keep their own angles. */
static ff_status plan_like(const ff_table *t, ff_scatter_plan *p, ff_error *err)
{
    static const int of[FF_SCATTER_AXES] = {PHI_I, THETA_I, PHI_O, THETA_O};
    ff_status status = FF_OK;
    for (int k = FF_SCATTER_INCIDENCE; k < FF_SCATTER_AXES && status == FF_OK; k++)
        if (!p->axis[k].n)
            status = ff_scatter_plan_copy(&p->axis[k], t->axes.n[of[k]], t->axes.node[of[k]], t->radians_per_unit / degree, err);
    return status;
}

static ff_status fill_plan(const ff_table *t, const char *grid, ff_scatter_plan *p, ff_error *err)
{
    ff_status status = grid ? ff_scatter_plan_parse(grid, &limits, p, err) : FF_OK;
    if (status == FF_OK && ff_lighttools_is_layout(t)) status = plan_like(t, p, err);
    if (status == FF_OK && !p->axis[FF_SCATTER_INCIDENCE].n) status = ff_scatter_plan_from_data(t, FF_SCATTER_INCIDENCE, p, err);
    for (int k = FF_SCATTER_AZIMUTH; k < FF_SCATTER_AXES && status == FF_OK; k++)
        if (!p->axis[k].n) status = ff_scatter_plan_steps(&p->axis[k], 0, limits.end[k], k == FF_SCATTER_AZIMUTH ? 5 : 2.5, err);
    return status;
}

static ff_status make_layout(const ff_table *t, const ff_scatter_plan *p, ff_table *out, ff_error *err)
{
    static const double light = FF_LIGHTTOOLS_LIGHT;
    const ff_values *incidence = &p->axis[FF_SCATTER_INCIDENCE], *azimuth = &p->axis[FF_SCATTER_AZIMUTH],
                    *radial = &p->axis[FF_SCATTER_RADIAL];
    const size_t n[AXES] = {incidence->n, 1, radial->n, azimuth->n};
    const double *const node[AXES] = {incidence->value, &light, radial->value, azimuth->value};
    const double samples = (double)n[0] * (double)n[2] * (double)n[3] * (double)t->n_channels;
    if (samples > MOST_SAMPLES)
        return ff_error_set(err, FF_ERR_RANGE, NULL, 0, -1, "grid: found %.0f values, expected at most %d: take larger steps",
                            samples, MOST_SAMPLES);
    ff_status status =
        ff_table_init_axes(FF_AXES_INCIDENT_EXIT, n, node, degree, t->n_channels, ff_lighttools_has_cells(n, node), out, err);
    if (status != FF_OK) return status;
    out->isotropic = 1;
    ff_table_name_channels_like(out, t);
    if (out->weight) status = ff_lighttools_weigh(out, 0, err);
    if (status != FF_OK) ff_table_clear(out);
    return status;
}

ff_status ff_lighttools_layout(const ff_table *t, const char *grid, ff_table *out, ff_error *err)
{
    ff_scatter_plan p = {0};
    ff_status status = ff_lighttools_check_channels(t, NULL, err);
    if (status == FF_OK) status = fill_plan(t, grid, &p, err);
    if (status == FF_OK) status = make_layout(t, &p, out, err);
    ff_scatter_plan_clear(&p);
    return status;
}
