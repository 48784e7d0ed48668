/* Pairs of directions of a table that is to become an OpenEXR image. The grid text:
 *
 *     [own | list | merl | half-difference:N | incident-exit:N][,double]       nothing and "own": the table's own directions
 *
 *   half-difference:HxDxP        theta_h at 90 (i + 1/2)^2 / H^2 degrees, dense about the normal as MERL has it; theta_d at
 *                                90 (i + 1/2) / D; phi_d at 180 (i + 1/2) / P, as reciprocity folds the rest; phi_h = 0
 *   half-difference:HxAxDxP      the same with A azimuths of the half vector, 360 i / A
 *   incident-exit:IxOxP          theta_i at 90 (i + 1/2) / I degrees, theta_o likewise, phi_o at 360 i / P; phi_i = 0
 *   incident-exit:IxAxOxP        the same with A azimuths of the light, 360 i / A
 *   double                       values, standard deviations and weights as doubles */
#define _GNU_SOURCE
#include "internal_exr.h"
#include "base/internal_input.h"
#include "data_formats/table/internal_table.h"
#include <stdlib.h>
#include <string.h>

static const double degree = 3.14159265358979323846 / 180;

/* theta_h of MERL; middles of cells; borders of cells. */
typedef enum spacing { SQUARED, MIDDLES, STARTS } spacing;

static double node_at(spacing s, size_t i, size_t n, double span)
{
    const double middle = ((double)i + 0.5) / (double)n;
    return span * (s == SQUARED ? middle * middle : s == MIDDLES ? middle : (double)i / (double)n);
}

static ff_status bad_grid(const char *grid, ff_error *err)
{
    char found[FF_QUOTE];
    return ff_error_set(err, FF_ERR_SYNTAX, NULL, 0, -1,
                        "found the grid %s, expected own, list, merl, half-difference:HxDxP, half-difference:HxAxDxP, "
                        "incident-exit:IxOxP or incident-exit:IxAxOxP, and perhaps ',double'",
                        ff_quote(grid, strlen(grid), found));
}

/* "90x90x180" up to the end or a comma; the number of counts, 0 when it is none. */
static int read_counts(const char *text, size_t n[4])
{
    int count = 0;
    for (;; text++) {
        if (count == 4 || *text < '1' || *text > '9') return 0;
        size_t v = 0;
        for (; *text >= '0' && *text <= '9'; text++) {
            v = 10 * v + (size_t)(*text - '0');
            if (v > INT32_MAX) return 0;
        }
        n[count++] = v;
        if (*text == '\0') return count;
        if (*text != 'x') return 0;
    }
}

static ff_status new_product(ff_axes_kind kind, const size_t n[4], const ff_table *t, ff_table *out, ff_error *err)
{
    static const spacing spaced[2][4] = {{SQUARED, STARTS, MIDDLES, MIDDLES}, {MIDDLES, STARTS, MIDDLES, STARTS}};
    static const double span[2][4] = {{90, 360, 90, 180}, {90, 360, 90, 360}};
    const int which = kind == FF_AXES_INCIDENT_EXIT;
    double samples = 1, *node[4] = {NULL};
    for (int k = 0; k < 4; k++) samples *= (double)n[k];
    if (samples > INT32_MAX)
        return ff_error_set(err, FF_ERR_RANGE, NULL, 0, -1, "found a grid of %.0f samples, expected at most %ld", samples,
                            (long)INT32_MAX);
    ff_status status = FF_OK;
    for (int k = 0; k < 4; k++) {
        node[k] = malloc(n[k] * sizeof(double));
        if (!node[k]) status = ff_error_set(err, FF_ERR_MEMORY, NULL, 0, -1, "no memory for an axis of %zu nodes", n[k]);
        for (size_t i = 0; node[k] && i < n[k]; i++) node[k][i] = node_at(spaced[which][k], i, n[k], span[which][k]);
    }
    if (status == FF_OK) status = ff_table_init_axes(kind, n, (const double *const *)node, degree, t->n_channels, 0, out, err);
    for (int k = 0; k < 4; k++) free(node[k]);
    return status;
}

static ff_status product(const char *shape, const ff_table *t, ff_table *out, ff_error *err)
{
    const ff_axes_kind kind = *shape == 'h' ? FF_AXES_HALF_DIFFERENCE : FF_AXES_INCIDENT_EXIT;
    const char *colon = strchr(shape, ':');
    size_t n[4];
    const int counts = read_counts(colon + 1, n);
    if (counts < 3) return bad_grid(shape, err);
    if (counts == 3) {
        n[3] = n[2];
        n[2] = n[1];
        n[1] = 1;
    }
    const ff_status status = new_product(kind, n, t, out, err);
    if (status == FF_OK) out->isotropic = counts == 3 || t->isotropic;
    return status;
}

/* The directions as they are: on a grid, on axes, or in a list. */
static ff_status own(const ff_table *t, int as_list, ff_table *out, ff_error *err)
{
    if (t->grid && t->grid != &ff_grid_merl)
        return ff_error_set(err, FF_ERR_UNSUPPORTED, NULL, 0, -1, "found the grid '%s', expected 'merl', axes or directions",
                            t->grid->name);
    const int axes = t->axes.kind != FF_AXES_NONE && !as_list;
    ff_status status;
    if (axes)
        status = ff_table_init_axes(t->axes.kind, t->axes.n, (const double *const *)t->axes.node, t->radians_per_unit,
                                    t->n_channels, t->weight != NULL, out, err);
    else
        status = ff_table_init(t->n, t->n_channels, as_list ? NULL : t->grid, 0, t->weight != NULL, out, err);
    if (status != FF_OK) return status;
    if (!axes && !out->grid) {
        out->radians_per_unit = t->grid ? degree : t->radians_per_unit;
        ff_table_angles(t, out->radians_per_unit, 0, t->n, out->angle);
    }
    if (out->weight && t->weight) memcpy(out->weight, t->weight, t->n * sizeof *t->weight);
    out->isotropic = t->isotropic;
    return FF_OK;
}

ff_status ff_exr_layout(const ff_table *t, const char *grid, ff_table *out, ff_error *err)
{
    char shape[128] = "own";
    const char *asked = grid ? grid : "own", *comma = strchrnul(asked, ',');
    const size_t length = (size_t)(comma - asked);
    const int only_double = strcmp(asked, "double") == 0;
    if (length >= sizeof shape || (*comma && strcmp(comma, ",double") != 0)) return bad_grid(asked, err);
    if (!only_double) {
        memcpy(shape, asked, length);
        shape[length] = '\0';
    }
    ff_table made;
    ff_status status;
    if (strcmp(shape, "own") == 0 || strcmp(shape, "list") == 0)
        status = own(t, *shape == 'l', &made, err);
    else if (strcmp(shape, "merl") == 0)
        status = ff_table_init(ff_grid_merl.n, t->n_channels, &ff_grid_merl, 0, 0, &made, err);
    else if (strncmp(shape, "half-difference:", 16) == 0 || strncmp(shape, "incident-exit:", 14) == 0)
        status = product(shape, t, &made, err);
    else
        status = bad_grid(asked, err);
    if (status != FF_OK) return status;
    ff_table_name_channels_like(&made, t);
    const ff_exr_kept *kept = ff_exr_kept_of(t);
    status =
        ff_exr_keep(&made, only_double || *comma == ',' || (!grid && kept && kept->doubles), kept ? kept->source : t->format, err);
    if (status == FF_OK)
        *out = made;
    else
        ff_table_clear(&made);
    return status;
}
