/* The two ways of keeping an information: as a whole, [P][P], and as an arrowhead, linear in the number of channels. */
#ifndef FF_INTERNAL_STORAGE_H
#define FF_INTERNAL_STORAGE_H
#include "internal_errors.h"

/* Everything is scaled. Products of influences are those of a packed triangle: of all parameters, or of an arrowhead of those that
 * it keeps. */
typedef struct ff_storage {
    size_t (*doubles)(size_t S, size_t K, size_t C); /* that it needs of the information's memory */
    void (*lay_out)(ff_information *info, double *memory);
    ff_status (*invert)(ff_information *info, const ff_gram *g); /* H^-1 of the parameters in use */
    double (*inverse_at)(const ff_information *info, size_t k);
    void (*apply)(const ff_information *info, const double *score, double *influence); /* H^-1 s */
    size_t (*products)(const ff_information *info);
    void (*add_products)(const ff_information *info, const double *influence, double factor, double *sums);
    double (*product_at)(const ff_information *info, const double *sums, size_t k);
    /* Products of the influences of single samples about their mean score [P], from what the pass has left. FF_ERR_MEMORY. */
    ff_status (*of_single)(const ff_information *info, const ff_normal *n, size_t n_samples, const double *mean,
                           const double *of_samples, double *sums);
    void (*take_products)(ff_information *info, const double *sums); /* as the covariance */
    void (*take_inverse)(ff_information *info);
    void (*multiply)(ff_information *info, const double *factor); /* [P], of both parameters */
    double (*covariance)(const ff_information *info, size_t i, size_t j);
    ff_status (*condition)(const ff_information *info, const ff_gram *g, size_t *rank, double *condition, double *curvature,
                           double *share);
} ff_storage;

extern const ff_storage ff_storage_whole, ff_storage_arrowhead;

/* A ridge of this size on the scaled H keeps its inverse finite; a parameter whose variance it sets is not determined. */
#define FF_RIDGE        1e-13
#define FF_UNDETERMINED 1e10
#endif
