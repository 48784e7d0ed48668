/** @file ff_rgl.h  The reflectance function inside a file of the RGL material database (Dupuy and Jakob 2018).
 *
 *  Such a file does not list samples: it holds a function of two directions, a measurement in coordinates that follow the lobe. The
 *  reader of the format `rgl` (ff_table.h) hands out the measured grid; this evaluates the function anywhere, as the database's own
 *  loader does, but without its clipping of negative colours and without its cosine.
 *  Frame, angles: as ff_model.h. An isotropic file is evaluated at phi_o - phi_i.
 *  Errors   ff_status and a caller-owned ff_error with path and byte.
 *  Threads  one open file may be evaluated from many threads at once. */
#ifndef FF_RGL_H
#define FF_RGL_H
#include "ff_api.h"
#include "ff_table.h"
#ifdef __cplusplus
extern "C" {
#endif

typedef struct ff_rgl ff_rgl;

/** What an open file holds; valid until ff_rgl_free. */
typedef struct ff_rgl_info {
    size_t n_channels;                        /**< 3 of an RGB file, else one per wavelength                         */
    const ff_channel *channels;               /**< [n_channels]; scale 1                                             */
    const char *description;                  /**< the file's own words, "" when it has none                         */
    int isotropic;                            /**< 1: depends on the difference of the azimuths only                 */
    size_t n_phi_i, n_theta_i, width, height; /**< measured: incidences, half vectors for each */
} ff_rgl_info;

/** Opens path ("-" is standard input). FF_ERR_OPEN, FF_ERR_READ, FF_ERR_FORMAT, FF_ERR_DATA, FF_ERR_UNSUPPORTED, FF_ERR_MEMORY.
 *  *out is written only on success; release with ff_rgl_free. */
FF_API ff_status ff_rgl_open(const char *path, ff_rgl **out, ff_error *err);

/** Closes; NULL is legal. */
FF_API void ff_rgl_free(ff_rgl *r);

/** What is in it. */
FF_API ff_rgl_info ff_rgl_about(const ff_rgl *r);

/** f in 1/sr, cosine not included, at n pairs of directions.
 *  @param w      six planes [n] of unit vectors: wix wiy wiz wox woy woz
 *  @param f      [n_channels][ld] out, f[c*ld + i]; 0 where the function is not defined. May be negative: a colour outside the
 * gamut
 *  @param ld     stride of a channel, >= n
 *  @param valid  [n] out: 0 where a direction is not above the horizon or the file holds no density there; NULL = not needed */
FF_API void ff_rgl_eval(const ff_rgl *r, const double *const w[6], size_t n, double *f, size_t ld, unsigned char *valid);

#ifdef __cplusplus
}
#endif
#endif
