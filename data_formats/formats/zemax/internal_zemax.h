/* The grid of a Zemax file about the specular direction: its axes, the cells that its nodes stand for, and its layout for given
 * data. */
#ifndef FF_INTERNAL_ZEMAX_H
#define FF_INTERNAL_ZEMAX_H
#include "data_formats/table/internal_scatter_plan.h"

enum {
    FF_ZEMAX_ROTATION = FF_SCATTER_ROTATION,
    FF_ZEMAX_INCIDENCE = FF_SCATTER_INCIDENCE,
    FF_ZEMAX_AZIMUTH = FF_SCATTER_AZIMUTH,
    FF_ZEMAX_RADIAL = FF_SCATTER_RADIAL,
    FF_ZEMAX_AXES = FF_SCATTER_AXES
};
enum { FF_ZEMAX_PLANE_SYMMETRICAL, FF_ZEMAX_ASYMMETRICAL, FF_ZEMAX_ASYMMETRICAL_4D };
extern const double ff_zemax_axis_most[FF_ZEMAX_AXES]; /* degrees */
extern const char *const ff_zemax_xyz[3];              /* names of three channels */

/* ---- zemax_cells.c --------------------------------------------------------------------------- */

typedef struct ff_zemax_cells {
    double *of[FF_ZEMAX_AXES], *cosine[FF_ZEMAX_AXES], *sine[FF_ZEMAX_AXES]; /* per node; cosine and sine of its angle */
    double *memory;
} ff_zemax_cells;

/* Is there a cell about each node: are neighbouring azimuths (degrees) near enough for the space between them to be one? */
int ff_zemax_has_cells(const size_t n[FF_ZEMAX_AXES], const double *const node[FF_ZEMAX_AXES]);

/* node: degrees. c->memory is the caller's to free. FF_ERR_MEMORY. */
ff_status ff_zemax_cells_make(const size_t n[FF_ZEMAX_AXES], const double *const node[FF_ZEMAX_AXES], int symmetry,
                              ff_zemax_cells *c, ff_error *err);

/* Integral of v cos(theta_o) over the directions above the horizon, of incidence i; v [azimuth][radial], valid likewise. */
double ff_zemax_block_integral(const ff_zemax_cells *c, const size_t n[FF_ZEMAX_AXES], size_t i, const double *v,
                               const unsigned char *valid);

/* ---- zemax_layout.c -------------------------------------------------------------------------- */

/* The symmetry that the angles of a table on such axes have. */
int ff_zemax_symmetry_of(const ff_table *t);

/* FF_ERR_UNSUPPORTED for channels that a file of this format cannot name. */
ff_status ff_zemax_check_channels(const ff_table *t, const char *path, ff_error *err);

/* See ff_format.layout; a grid like "rotation:0/90,incidence:20,azimuth:10,radial:0/2/5/10". */
ff_status ff_zemax_layout(const ff_table *t, const char *grid, ff_table *out, ff_error *err);
#endif
