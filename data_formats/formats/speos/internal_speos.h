/** @file internal_speos.h  What the two formats of Ansys Speos share: blocks of values over polar angle and azimuth, each
 * proportional to the BSDF or to the intensity, of which the reflectance is known. */
#ifndef FF_INTERNAL_SPEOS_H
#define FF_INTERNAL_SPEOS_H
#include "base/internal_tokens.h"
#include "data_formats/table/internal_table.h"
#include <stdio.h>

typedef struct ff_speos {
    ff_tokens t;
    ff_error *err;
    const char *path;
    int reflects, transmits, is_bsdf; /**< flags of the file                       */
} ff_speos;

/** One block: values [n_theta][n_phi] above the horizon, angles in degrees, ascending. */
typedef struct ff_speos_block {
    size_t n_theta, n_phi;
    double *theta, *phi, *value; /**< into one allocation, which is theta's         */
} ff_speos_block;

/** 1 when head begins with the title of a format: "brdf surface file" or "Anisotropic BSDF surface file". */
int ff_speos_probe(const unsigned char *head, size_t n, const char *title);

/** Reads title, mode, comment and description: what both formats begin with. FF_ERR_FORMAT, FF_ERR_UNSUPPORTED (binary),
 * FF_ERR_READ. */
ff_status ff_speos_begin(ff_speos *s, const char *title);
/** Reads whether it reflects and transmits, and what its values are. FF_ERR_UNSUPPORTED where it only transmits. */
ff_status ff_speos_kinds(ff_speos *s);

/** A count from 1 to most, and n ascending numbers from lo to hi. FF_ERR_DATA, FF_ERR_MEMORY; *out is the caller's to free. */
ff_status ff_speos_count(ff_speos *s, const char *what, size_t most, size_t *out);
ff_status ff_speos_list(ff_speos *s, const char *what, size_t n, double lo, double hi, double **out);

/** "91 361", the azimuths, and a row for each polar angle. A last azimuth of a whole turn is left out. */
ff_status ff_speos_block_read(ff_speos *s, ff_speos_block *out);
void ff_speos_block_clear(ff_speos_block *b);

/** Makes a BSDF of intensities, where that is what the file has; 0 where the cosine is. */
void ff_speos_block_to_bsdf(const ff_speos *s, ff_speos_block *b);

/** Integral of v cos(theta), by the trapezoidal rule of the file's maker, the turn closed. */
double ff_speos_block_integral(const ff_speos_block *b);

/** Adds a row for each node of a block whose values, of n channels, are value[c] * scale[c]. Angles: the specular direction is at
 * the azimuth 90 - rotation, from which those of the block are counted, counter-clockwise (see format_speos.c). band: the solid
 * angle of light that the incidence stands for. Samples at and below the horizon were not measured. */
ff_status ff_speos_rows_add(ff_speos *s, double rotation, double incidence, double band, const ff_speos_block *b, size_t n,
                            double *const *value, const double *scale, ff_rows *rows);

/* ---- writing: the blocks that a table has ------------------------------------------------------------ */

typedef struct ff_speos_grid {
    size_t n_rotations, n_incidences, n_theta, n_phi;
    double *rotation, *incidence, *theta, *phi; /**< degrees; into one allocation, which is rotation's */
} ff_speos_grid;

/** Finds the blocks of a table whose samples run over rotation, incidence, polar angle and azimuth, the last fastest.
 * FF_ERR_UNSUPPORTED for a table that is none such, FF_ERR_MEMORY. */
ff_status ff_speos_grid_of(const ff_table *t, const char *path, ff_speos_grid *out, ff_error *err);

/** The layout of a file to be written for data like t: their incidences and (anisotropic) rotations where they are few. */
ff_status ff_speos_layout(const ff_table *t, int anisotropic, const char *grid, ff_table *out, ff_error *err);

/** Writes the block of channel c that begins at sample `first`. */
void ff_speos_block_write(const ff_table *t, const ff_speos_grid *g, size_t c, size_t first, FILE *file);
/** Its reflectance, per cent, by the rule that a reader has. */
double ff_speos_block_percent(const ff_table *t, const ff_speos_grid *g, size_t c, size_t first, ff_error *err);
void ff_speos_put(FILE *file, double v, char after);

#endif
