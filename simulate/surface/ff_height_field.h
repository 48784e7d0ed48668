/** @file ff_height_field.h  Rough surfaces whose every height is known, and what they do with light, by tracing rays.
 *
 *  A surface is a periodic map of heights with flat facets between them: one of a random process with Gaussian heights and a given
 *  spectrum, or a measured map. Rays come down evenly over it, are reflected by the facets that they meet, and leave. Nothing is
 *  assumed about masking: that is what comes out.
 *
 *  Spectra   of correlation length l, by |k| l: Gaussian e^(-k^2 l^2 / 4), exponential (1 + k^2 l^2)^(-3/2), power law
 *            (1 + k^2 l^2)^-(1 + H); the last two, whose slopes have no variance of their own, end at waves of 8 cells. The surface
 * is stretched so that its slopes have the covariances of beckmann's alpha_x, alpha_y, r_xy (rms alpha / sqrt(2) along an axis;
 * Heitz 2014, section 5.3); after that each realisation is scaled so that its rms slopes along x and y are exactly these. l is that
 * of the axis in which it is shortest, in cells. Maps      heights and pitch in one unit; the mean plane is taken out, and the last
 * sixteenth of each axis is faded into the first, so that the map can be repeated. Slopes are what they are: no roughness of the
 * model is looked at. Errors    of values are standard errors from the differences between realisations; of a map between parts of
 * its paths, which know nothing of other places of the sample. Values    f cos(theta_o) counted in the cone of half angle
 * `aperture` about wo, over its solid angle and cos(theta_o) of its centre: what a detector of that size reads (ff_aperture.h), and
 * what a fit with that aperture takes them for. Cones may overlap. Frame     as ff_model.h. The Fresnel term of the model's lobe
 * acts at every facet. Numbers   as ff_walk.h: the bits do not depend on the number of threads. Module    Embree and FFTW are in
 * facetfit_rays.so, opened by the first surface; FF_ERR_UNSUPPORTED where it is not there. Threads   a surface does not change
 * after it was made; every function may be called from many threads at once. */
#ifndef FF_HEIGHT_FIELD_H
#define FF_HEIGHT_FIELD_H
#include "ff_api.h"
#include "ff_model.h"
#include "ff_walk.h"
#ifdef __cplusplus
extern "C" {
#endif

typedef enum ff_spectrum { FF_SPECTRUM_GAUSSIAN = 0, FF_SPECTRUM_EXPONENTIAL = 1, FF_SPECTRUM_POWER_LAW = 2 } ff_spectrum;

/** Options; fill with ff_height_field_options_init, then change. */
typedef struct ff_height_field_options {
    size_t size;          /**< sizeof(ff_height_field_options)                                                            */
    ff_spectrum spectrum; /**< FF_SPECTRUM_GAUSSIAN; not looked at with a map                                        */
    double hurst;         /**< H of FF_SPECTRUM_POWER_LAW, in (0, 1]; 0.8                                            */
    double correlation;   /**< l in cells, 2 .. 1024; 16                                                             */
    size_t cells;         /**< along each axis, 16 .. 8192; 512. A realisation takes about 300 bytes for each cell   */
    size_t realisations;  /**< 2 .. 100000; 16. Of a map: the parts of its paths                                     */
    const char *map;      /**< file of a measured map, borrowed while the surface is made; NULL: a spectrum          */
    double pitch[2];      /**< of the map along x and y, in the unit of its heights, > 0; NaN: what the file says    */
    double height_unit;   /**< factor on the heights of the map, > 0; 1                                              */
    ff_facets facets;     /**< FF_FACETS_MIRROR or FF_FACETS_LAMBERT                                                 */
    double aperture;      /**< half angle of the cone of a value, radians, 0.001 .. 0.5; 2.5 degrees                 */
    uint64_t seed;        /**< 1                                                                                     */
    uint64_t paths;       /**< from each direction, over all realisations, >= realisations, <= 1e12; 1000000         */
    size_t n_orders;      /**< 1 .. FF_WALK_ORDERS; 1                                                                */
    ff_orders orders[FF_WALK_ORDERS];             /**< {1, 0}: all                                                               */
    int threads;                                  /**< 0 .. 1024; 0: as many as the system lets run                              */
    const volatile int *cancel;                   /**< polled; not NULL and != 0 ends with FF_ERR_CANCELLED                      */
    void (*progress)(void *context, double done); /**< called by the caller's thread, done in [0, 1]; NULL: not      */
    void *progress_context;
} ff_height_field_options;

/** Writes the defaults into options of `size` bytes, the caller's sizeof, and nothing beyond. */
FF_API void ff_height_field_options_init_size(ff_height_field_options *o, size_t size);
static inline void ff_height_field_options_init(ff_height_field_options *o)
{
    ff_height_field_options_init_size(o, sizeof *o);
}

typedef struct ff_height_field ff_height_field;

/** Makes a surface. It keeps copies, but borrows the cancel flag and the context of the progress. Release with
 * ff_height_field_free.
 *  @param shape    [n_shape]                 see ff_model_check; alpha_x, alpha_y, r_xy of a spectrum
 *  @param channel  [n_channels][n_channel]
 *  *out is written only on FF_OK. FF_ERR_RANGE, FF_ERR_UNSUPPORTED as ff_model_check; FF_ERR_UNSUPPORTED without the module, for a
 *  model that is not one lobe of ks = 1 without a mean slope (of beckmann where a spectrum is asked for) and of lambert facets with
 *  +lambert; FF_ERR_RANGE for options; what reading the map may end with; FF_ERR_MEMORY. */
FF_API ff_status ff_height_field_new(const ff_model *m, size_t n_channels, const double *shape, const double *channel,
                                     const ff_height_field_options *o, ff_height_field **out, ff_error *err);
FF_API void ff_height_field_free(ff_height_field *s); /**< NULL is allowed */

/** 1 where the surface has no direction of its own. */
FF_API int ff_height_field_is_isotropic(const ff_height_field *s);

/** Values at n pairs of directions; pairs that follow each other and have the same wi share their paths.
 *  @param w          unit vectors above the horizon
 *  @param isotropic  1: light comes from all azimuths alike, the pairs being turned along
 *  @param f, error   [n_orders][n_channels][ld] out, 1/sr
 *  FF_ERR_RANGE, FF_ERR_MEMORY, FF_ERR_CANCELLED. */
FF_API ff_status ff_height_field_values(const ff_height_field *s, const ff_dirs *w, size_t n, int isotropic, double *f,
                                        double *error, size_t ld, ff_error *err);

/** Reflectance and mean direction of light from each of n directions.
 *  @param wi    [3][n] unit vectors above the horizon
 *  @param lobe  [n][n_orders][n_channels] out
 *  @param lost  [n] out: paths that slipped through the mesh, or met more than 4096 facets, as a part of all. NULL: not wanted */
FF_API ff_status ff_height_field_lobes(const ff_height_field *s, const double *wi, size_t n, ff_lobe_mean *lobe, double *lost,
                                       ff_error *err);

/** What is seen of the facets that face a direction: the part of their area (of D dm over m, not of D <w, m> dm) that nothing
 * hides. */
typedef struct ff_seen {
    double g1, g1_error; /**< from w                                                                      */
    double g2, g2_error; /**< from w and from its opposite, at the same theta and half a turn away, at once */
} ff_seen;

/** @param w     [3][n] unit vectors above the horizon
 *  @param seen  [n] out. Of `paths` points for each. */
FF_API ff_status ff_height_field_seen(const ff_height_field *s, const double *w, size_t n, ff_seen *seen, ff_error *err);

/** The slopes that a surface has, and its normals. Errors are standard errors. */
typedef struct ff_slopes {
    double alpha_x, alpha_x_error, alpha_y, alpha_y_error; /**< sqrt(2) times the rms slope along the axis */
    double r_xy, r_xy_error;
    double kurtosis; /**< of the slope along x; 3 of a Gaussian one */
} ff_slopes;

/** @param d, d_error  [n] out: the distribution of normals D, 1/sr, in n rings of equal width in theta from 0 to 90 degrees; n in
 *  1 .. 900. NULL: not wanted */
FF_API ff_status ff_height_field_slopes(const ff_height_field *s, ff_slopes *slopes, size_t n, double *d, double *d_error,
                                        ff_error *err);

#ifdef __cplusplus
}
#endif
#endif
