/* Files for LightTools: the grid of theta_o and phi_o about the normal, and the text. format_lighttools.c has the conventions. */
#ifndef FF_INTERNAL_LIGHTTOOLS_H
#define FF_INTERNAL_LIGHTTOOLS_H
#include "base/internal_output.h"
#include "data_formats/table/internal_scatter_plan.h"

#define FF_LIGHTTOOLS_LIGHT 90 /* azimuth of the light, degrees */

/* Axes theta_i, phi_i, theta_o, phi_o in degrees: is there a cell about each node? */
int ff_lighttools_has_cells(const size_t n[4], const double *const node[4]);

/* Solid angles of the cells of a table on such axes. mirrored: azimuths of half a circle stand for both. FF_ERR_MEMORY. */
ff_status ff_lighttools_weigh(ff_table *t, int mirrored, ff_error *err);

/* Has the table the axes of a file: one plane of incidence, the light at FF_LIGHTTOOLS_LIGHT, azimuths from 0 to 360 degrees? */
int ff_lighttools_is_layout(const ff_table *t);

/* Are the channels named X, Y and Z? */
int ff_lighttools_is_xyz(const ff_table *t);

/* FF_ERR_UNSUPPORTED for channels that a file of this format cannot name. */
ff_status ff_lighttools_check_channels(const ff_table *t, const char *path, ff_error *err);

/* See ff_format.layout; a grid like "incidence:20,azimuth:5,radial:0/2/5/10". */
ff_status ff_lighttools_layout(const ff_table *t, const char *grid, ff_table *out, ff_error *err);

/* See ff_format.write. */
ff_status ff_lighttools_write(const char *path, const ff_table *t, ff_outputs *with, ff_error *err);
#endif
