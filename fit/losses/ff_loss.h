/** @file ff_loss.h  The losses that a fit can minimise, and their robust forms: numbers, names, and what they are.
 *
 *  A loss says which difference between model and data counts. Least squares of the reflectance itself see little but the peak of
 *  a glossy surface; those of its logarithm see the dark parts as well. Formally: the residual of a sample is
 *  r = sqrt(w) (g(f) - g(y)), f the model and y the datum, both in 1/sr, and a loss is its g. A robust loss rho(r^2), of which half
 *  is summed, lets large residuals, those of outliers, count less than their squares.
 *
 *  Lists   ff_losses.def and ff_robusts.def; each entry is one file of fit/losses/. Loop from 0 to FF_LOSS_COUNT.
 *  Memory  everything is constant and static.
 *  Threads any number. */
#ifndef FF_LOSS_H
#define FF_LOSS_H
#ifdef __cplusplus
extern "C" {
#endif

/** FF_LOSS_COSINE = 0, FF_LOSS_LOG = 1, FF_LOSS_CUBE_ROOT = 2, FF_LOSS_RELATIVE = 3, FF_LOSS_PLAIN = 4, and what came later. A
 *  number keeps its meaning for good. */
typedef enum ff_loss {
#define FF_LOSS_ENTRY(NAME, id) FF_LOSS_##NAME,
#include "ff_api.h"
#include "ff_losses.def"
} ff_loss;
enum {
    FF_LOSS_COUNT = 0
#define FF_LOSS_ENTRY(NAME, id) +1
#include "ff_losses.def"
};

/** FF_ROBUST_NONE = 0, FF_ROBUST_HUBER = 1, FF_ROBUST_CAUCHY = 2, FF_ROBUST_TUKEY = 3, and what came later. */
typedef enum ff_robust {
#define FF_ROBUST_ENTRY(NAME, id) FF_ROBUST_##NAME,
#include "ff_robusts.def"
} ff_robust;
enum {
    FF_ROBUST_COUNT = 0
#define FF_ROBUST_ENTRY(NAME, id) +1
#include "ff_robusts.def"
};

/** What there is to say of a loss. Strings are in one line of plain text. */
typedef struct ff_loss_info {
    const char *name;      /**< as on the command line: "cube-root"                                                */
    const char *help;      /**< what it is good for, a line of --help                                              */
    const char *compares;  /**< g(f) as a formula of f, y and x = cos(theta_i): "ln(1 + f x)"                      */
    const char *source;    /**< author and year, "" where there is none                                            */
    const char *rmse_unit; /**< unit of its root mean square as a measure of any fit (ff_residual.loss_rmse); NULL: it is not one */
} ff_loss_info;

/** What there is to say of a robust loss. */
typedef struct ff_robust_info {
    const char *name;   /**< as on the command line: "huber"                                                       */
    const char *help;   /**< what it is good for, a line of --help                                                 */
    const char *rho;    /**< rho(s) as a formula of s = r^2 and the scale b                                        */
    const char *source; /**< author and year, "" where there is none                                               */
    double tuning;      /**< b, in standard deviations of the residuals, at which 95 % of the information of normal ones is kept */
} ff_robust_info;

/** FF_LOSS_COUNT and FF_ROBUST_COUNT of the library that is linked, which may know more than these headers. */
FF_API int ff_loss_count(void);
FF_API int ff_robust_count(void);

/** NULL for a number that is none. */
FF_API const ff_loss_info *ff_loss_at(int loss);
FF_API const ff_robust_info *ff_robust_at(int robust);

/** The name alone; NULL for a number that is none. */
FF_API const char *ff_loss_name(int loss);
FF_API const char *ff_robust_name(int robust);

/** The number of a name; -1 when it is unknown. Case counts. */
FF_API int ff_loss_find(const char *name);
FF_API int ff_robust_find(const char *name);

#ifdef __cplusplus
}
#endif
#endif
