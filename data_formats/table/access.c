/* Tables for programs that do not see inside: on the heap, filled and read by functions. */
#include "table_struct.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- making ---------------------------------------------------------------------------------- */

ff_status ff_table_move(ff_table *t, ff_table **out, ff_error *err)
{
    ff_table *made = malloc(sizeof *made);
    if (!made) {
        ff_table_clear(t);
        return ff_error_set(err, FF_ERR_MEMORY, NULL, 0, -1, "out of memory");
    }
    *made = *t;
    memset(t, 0, sizeof *t);
    *out = made;
    return FF_OK;
}

ff_status ff_table_new(size_t n, size_t n_channels, int with_sigma, int with_weight, ff_table **out, ff_error *err)
{
    ff_table t;
    const ff_status status = ff_table_init(n, n_channels, NULL, with_sigma, with_weight, &t, err);
    return status ? status : ff_table_move(&t, out, err);
}

ff_status ff_table_new_on_grid(const ff_grid *grid, size_t n_channels, int with_sigma, ff_table **out, ff_error *err)
{
    ff_table t;
    const ff_status status = ff_table_init(grid->n, n_channels, grid, with_sigma, 0, &t, err);
    return status ? status : ff_table_move(&t, out, err);
}

void ff_table_free(ff_table *t)
{
    ff_table_clear(t);
    free(t);
}

const ff_grid *ff_grid_find(const char *name)
{
    return strcmp(name, ff_grid_merl.name) == 0 ? &ff_grid_merl : NULL;
}

size_t ff_grid_samples(const ff_grid *grid)
{
    return grid->n;
}

/* ---- planes ---------------------------------------------------------------------------------- */

double *ff_table_value_plane(ff_table *t, size_t c)
{
    return c < t->n_channels ? t->value + c * t->n : NULL;
}

double *ff_table_sigma_plane(ff_table *t, size_t c)
{
    return t->sigma && c < t->n_channels ? t->sigma + c * t->n : NULL;
}

double *ff_table_angle_plane(ff_table *t, int k)
{
    return k >= 0 && k < 4 ? t->angle[k] : NULL;
}

double *ff_table_weight_plane(ff_table *t)
{
    return t->weight;
}

unsigned char *ff_table_valid_plane(ff_table *t)
{
    return t->valid;
}

ff_status ff_table_set_angle_unit(ff_table *t, double radians)
{
    if (!(radians > 0 && isfinite(radians))) return FF_ERR_RANGE;
    t->radians_per_unit = radians;
    return FF_OK;
}

void ff_table_set_isotropic(ff_table *t, int isotropic)
{
    t->isotropic = isotropic != 0;
}

ff_status ff_table_set_channel(ff_table *t, size_t c, const char *name, double wavelength_nm, double scale)
{
    if (c >= t->n_channels || !(scale > 0 && isfinite(scale))) return FF_ERR_RANGE;
    if (!isnan(wavelength_nm) && !(wavelength_nm > 0 && isfinite(wavelength_nm))) return FF_ERR_RANGE;
    snprintf(t->channels[c].name, sizeof t->channels[c].name, "%s", name);
    t->channels[c].wavelength_nm = wavelength_nm;
    t->channels[c].scale = scale;
    return FF_OK;
}

/* ---- what is in it --------------------------------------------------------------------------- */

size_t ff_table_samples(const ff_table *t)
{
    return t->n;
}

size_t ff_table_channel_count(const ff_table *t)
{
    return t->n_channels;
}

const ff_channel *ff_table_channel(const ff_table *t, size_t c)
{
    return c < t->n_channels ? &t->channels[c] : NULL;
}

const char *ff_table_format(const ff_table *t)
{
    return t->format;
}

const ff_grid *ff_table_grid(const ff_table *t)
{
    return t->grid;
}

int ff_table_is_isotropic(const ff_table *t)
{
    return t->isotropic;
}

double ff_table_angle_unit(const ff_table *t)
{
    return t->radians_per_unit;
}

ff_quantity ff_table_quantity(const ff_table *t)
{
    return t->quantity;
}

int ff_table_assumption(const ff_table *t, size_t k, char *out, size_t size, ff_hint *hint)
{
    const char *line = t->note;
    for (size_t i = 0; i < k && line; i++) line = (line = strchr(line, '\n')) ? line + 1 : NULL;
    if (!line || !line[0] || !size) return 0;
    snprintf(out, size, "%.*s", (int)strcspn(line, "\n"), line);
    if (hint) *hint = k < FF_TABLE_NOTES ? (ff_hint)t->note_hint[k] : FF_HINT_NONE;
    return 1;
}

void ff_table_valid(const ff_table *t, size_t first, size_t count, unsigned char *out)
{
    count = ff_table_there(t, first, count);
    for (size_t i = 0; i < count; i++) out[i] = t->valid[first + i] != 0;
}

int ff_table_has_sigmas(const ff_table *t)
{
    return t->sigma != NULL;
}
