/** @file ff_resample.h  A table on the directions that another format needs.
 *
 *  Where the format takes any directions, or the table has those of its layout already, nothing is interpolated. Elsewhere values
 * are those of ff_interpolant_eval_reciprocal, of values that are means over cells those averaged over what each new sample stands
 * for: a pair beyond the data takes the value of light and detector exchanged, where that
 * is known. What interpolation is worth on these data is measured by predicting samples from the others; narrow peaks between
 * samples are where it fails. What the format cannot hold (standard deviations, negative values, ...) is dropped. The report
 * counts, the note of the new table says so. Errors   ff_status and ff_error; outputs are written only on FF_OK. Threads  no global
 * state. */
#ifndef FF_RESAMPLE_H
#define FF_RESAMPLE_H
#include "ff_api.h"
#include "ff_table.h"
#ifdef __cplusplus
extern "C" {
#endif

/** Options; fill with ff_resample_options_init, then change. */
typedef struct ff_resample_options {
    size_t size;      /**< sizeof(ff_resample_options)                                                               */
    const char *grid; /**< passed to the format's layout; NULL = the usual                                           */
    int beyond;       /**< samples beyond the data: 0 are invalid where the format can say so, else the nearest values; 1 are
                           always the nearest values                                                                 */
    int threads;      /**< 0 = as many as the system lets run; the result does not depend on it                     */
    const volatile int *cancel; /**< polled; not NULL and != 0 ends with FF_ERR_CANCELLED                              */
} ff_resample_options;

/** Writes the defaults into options of `size` bytes, the caller's sizeof, and nothing beyond. */
FF_API void ff_resample_options_init_size(ff_resample_options *o, size_t size);
static inline void ff_resample_options_init(ff_resample_options *o)
{
    ff_resample_options_init_size(o, sizeof *o);
}

/** Samples predicted from others: |ln(predicted / measured)| of channel means; NaN where n is 0. Of what is beyond the data nothing
 * can be said. */
typedef struct ff_prediction {
    size_t n;
    double median, most, largest; /**< most: of 95 percent */
} ff_prediction;

/** What became of the samples. */
typedef struct ff_resample_report {
    size_t size;  /**< sizeof(ff_resample_report), set by the caller                               */
    int as_it_is; /**< 1: the directions are the table's own, nothing was interpolated             */
    size_t n;     /**< samples of the result                                                       */
    size_t at_sample, between, reciprocal, beyond, below_horizon; /**< they add up to n; as ff_found             */
    size_t invalid;             /**< of them, marked as not measured                                             */
    size_t raised;              /**< negative values that became 0                                               */
    char method[96];            /**< of interpolation; "" when as_it_is                                          */
    ff_prediction near, across; /**< what interpolation is worth at a measured incidence, and between incidences */
    size_t incidences;          /**< at which reflectances were compared; 0: as it is and no cells, or none      */
    double lost;                /**< 1 - (reflectance of the result / of the data) over the directions that the data cover, of all
                                     these incidences; negative: gained; NaN: not compared                       */
    double lost_most, lost_at;  /**< the same where it is furthest from 0, and that theta_i, degrees             */
    size_t missed;              /**< further incidences of the data of which the result has nothing                          */
    int in_plane;               /**< 1: all samples lie in the plane of incidence; those of the result beside it are beyond    */
} ff_resample_report;

/** A loss or gain above this is worth a warning. */
#define FF_RESAMPLE_LOSS 0.02

/** Makes *out from t for the format `to`, which must be writable. *out is written only on FF_OK; release it with ff_table_free.
 *  @param o       NULL: the defaults
 *  @param report  out; its size is set. NULL: not wanted
 *  FF_ERR_UNSUPPORTED when the format cannot hold such data, FF_ERR_SYNTAX, FF_ERR_RANGE for a grid that is none, FF_ERR_DATA when
 *  nothing can be interpolated, FF_ERR_MEMORY, FF_ERR_CANCELLED. */
FF_API ff_status ff_resample(const ff_table *t, const ff_format *to, const ff_resample_options *o, ff_table **out,
                             ff_resample_report *report, ff_error *err);

#ifdef __cplusplus
}
#endif
#endif
