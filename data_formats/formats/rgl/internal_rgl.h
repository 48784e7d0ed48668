/** @file internal_rgl.h  An RGL file in memory, shared by the evaluator, the reader and the writer. */
#ifndef FF_INTERNAL_RGL_H
#define FF_INTERNAL_RGL_H
#include "data_formats/table/table_struct.h"
#include "ff_rgl.h"
#include "internal_tensor_file.h"
#include "internal_warp2d.h"
#include <math.h>

struct ff_rgl {
    ff_tensor_file file; /**< owned                                                                */
    _Atomic int owners;  /**< beyond the first                                                     */
    size_t n_phi, n_theta, n_channels, width, height;
    double *phi, *theta; /**< [n_phi], [n_theta], radians                                          */
    int isotropic;       /**< azimuths of the half vector are relative to that of the incidence    */
    int jacobian;        /**< 1: colours are to be multiplied by ndf / (4 sigma)                   */
    int reduction;       /**< 1, 2, 4: so many parts of the circle of phi_i are alike by symmetry  */
    float *ndf, *sigma;
    size_t ndf_width, ndf_height, sigma_width, sigma_height;
    ff_warp2d vndf;
    const ff_tensor *colour;    /**< [n_phi][n_theta][n_channels][height][width] float32                  */
    const ff_tensor *luminance; /**< [n_phi][n_theta][height][width] float32                              */
    ff_channel *channels;       /**< [n_channels]                                                         */
    int spectral;               /**< channels are wavelengths                                             */
    char *description;
};

/** Makes *out of a file, which it takes over, also on failure. with_inverse: for ff_rgl_eval. */
ff_status ff_rgl_of_file(ff_tensor_file *file, const char *path, int with_inverse, ff_rgl **out, ff_error *err);

/** f cos(theta_o) per colour of a half vector at u for light from theta_i, phi_i: ndf / (4 sigma), or 1; 0 where not defined. */
double ff_rgl_factor(const ff_rgl *r, double theta_i, double phi_i, const double u[2]);

/** What colours are relative to, 4 sigma apart: the density of normals at u, or 1. */
double ff_rgl_density(const ff_rgl *r, const double u[2]);

/** Samples of one node of incidence, [height width] each: the directions seen (radians; beyond pi/2 below the horizon), f per
 * colour (0 where not defined) and the density of normals. row: scratch [2 vndf.width]. */
typedef struct ff_rgl_slice {
    double *theta_o, *phi_o, *factor, *density;
} ff_rgl_slice;
void ff_rgl_sample_slice(const ff_rgl *r, size_t p, size_t t, double *row, const ff_rgl_slice *out);

/** The direction seen at a point s of the unit square of a node of incidence, and f per colour there (0 where not defined). row:
 * scratch as above. */
void ff_rgl_place(const ff_rgl *r, size_t p, size_t t, const double s[2], double *row, double wo[3], double *factor);

/** What the samples of r weigh (rgl_weights.c): tables that serve all nodes of incidence, and scratch. One thread at a time. NULL:
 *  no memory. */
typedef struct ff_rgl_weights ff_rgl_weights;
ff_rgl_weights *ff_rgl_weights_new(const ff_rgl *r);
void ff_rgl_weights_free(ff_rgl_weights *w);

/** mass [height width] of the samples of one node: the integral of the sample's share in the function, 1 at the sample and 0 at its
 *  neighbours, times the density of normals, over the solid angle above the horizon. The sum over all samples of colour times
 *  mass / (4 sigma) is the reflectance. */
void ff_rgl_weigh(const ff_rgl *r, ff_rgl_weights *w, size_t p, size_t t, double *mass);

/** Solid angle of the node of incidence. They add up to 2 pi. */
double ff_rgl_incidence_weight(const ff_rgl *r, size_t p, size_t t);

/** A file without colours for a table like t; grid as in ff_format.layout. rgl_layout.c says how it is made. */
ff_status ff_rgl_make(const ff_table *t, const char *grid, ff_tensor_file *out, ff_error *err);

/** Directions of half vectors as numbers of the unit square, and back. */
static const double ff_rgl_pi = 3.14159265358979323846;
static inline double ff_rgl_theta(double u)
{
    return u * u * (ff_rgl_pi / 2);
}
static inline double ff_rgl_u_of_theta(double theta)
{
    return sqrt(2 / ff_rgl_pi * theta);
}
static inline double ff_rgl_phi(double u)
{
    return (2 * u - 1) * ff_rgl_pi;
}
#endif
