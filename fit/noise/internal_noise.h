/* The noise of the data from what a fit leaves, and the errors that follow from it. */
#ifndef FF_INTERNAL_FIT_NOISE_H
#define FF_INTERNAL_FIT_NOISE_H
#include "fit/information/internal_information.h"
#include "fit/minimise/internal_minimise.h"
#include "models/noise/noise_struct.h"

/* ---- the variance as a function of value and angles -------------------------------------------- */

/* Squared errors and what they depend on, of C channels with n values each: [C][n], but for the angles, [n]. */
typedef struct ff_scatter {
    size_t n, C;
    const double *value;         /* of the model, 1/sr                                                       */
    const double *square;        /* (datum - model)^2 over what the fit has left of it                       */
    const double *weight;        /* 0 = left out                                                             */
    const double *log_i, *log_o; /* of the cosines                                                           */
} ff_scatter;

/* The quasi-likelihood estimate: squares of normal errors have a variance of twice the square of their mean (a gamma family;
 * Davidian and Carroll 1987), so it minimises the sum of w (u / s + ln s). Levels for each channel where they are worth their
 * number (Schwarz 1978), else for all. Values are in units of the largest. first: from nothing, else from what noise is; final:
 * with what is not asked for left out, and how well the numbers are known. Correlations are left as they are. noise was made for C
 * levels. FF_ERR_MEMORY. */
ff_status ff_scatter_fit(const ff_scatter *s, int first, int final, ff_noise *noise);

/* ---- the standardised fit ---------------------------------------------------------------------- */

/* The samples that a start is searched on, with residuals f - y in standard deviations. Shares everything else with the problem
 * that it was made from, and lives no longer. */
typedef struct ff_standardised {
    struct ff_problem problem;
    float *factor; /* [n_channels][n_blocks FF_BLOCK] */
} ff_standardised;
ff_status ff_standardised_new(const struct ff_problem *p, ff_standardised *out);
void ff_standardised_free(ff_standardised *s);

/* Rows of the Jacobian by coordinate, [n_shared + n_own], columns of one coordinate added up. */
void ff_noise_rows(const ff_layout *l, const ff_visited *v, double (*row)[FF_BLOCK]);

/* The noise of the data about a fit that has ended at `at`: weights from the model, a fit with these weights, its residuals, and
 * again until nothing changes (Carroll and Ruppert 1988, chapter 2), on the samples that noise is estimated on. `where` is moved
 * to the optimum of that fit. *out NULL where residuals are nothing but rounding. FF_ERR_MEMORY, FF_ERR_CANCELLED. */
ff_status ff_noise_estimate(const ff_plan *plan, const ff_point *at, ff_point *where, ff_noise **out);

/* Standard deviations of the data where the model is that of `at`, of the samples of p, plan's problem or one of its smaller ones,
 * [n_channels][n_blocks FF_BLOCK]; FF_ERR_MEMORY. */
ff_status ff_noise_deviations(const ff_plan *plan, const struct ff_problem *p, const ff_point *at, const ff_noise *noise,
                              float *out);

/* ---- errors ------------------------------------------------------------------------------------ */

/* What single values have to do with the errors of the parameters, [P] each. */
typedef struct ff_carriers {
    double *number;  /* of values that carry the parameter: (sum v)^2 / sum v^2 of their shares v of its variance    */
    double *error;   /* its standard error by the noise, all values independent                                      */
    double *hc2;     /* its standard error by the residuals alone, right on average (MacKinnon and White 1985)       */
    double *hc3;     /* and rather too large, as if each value had been left out                                     */
    double *sway;    /* variance of the logarithm of its variance: the noise model is itself not known                */
    double *along;   /* factor on its standard error: errors go together along scans                                 */
    double *between; /* and between channels                                                                         */
} ff_carriers;

enum { FF_CARRIER_ARRAYS = 7 };
/* memory [FF_CARRIER_ARRAYS P] */
void ff_carriers_lay_out(double *memory, size_t P, ff_carriers *out);

/* Of every parameter at a fit's optimum; deviation [n_channels][n_blocks FF_BLOCK] of the samples that noise is estimated on.
 * Before the covariance of info is made anew. FF_ERR_MEMORY. */
ff_status ff_carriers_find(const ff_plan *plan, const ff_point *at, const ff_noise *noise, const float *deviation,
                           const ff_information *info, ff_carriers *out);

/* The same of the difference between the estimates from a part of the samples and from all: the values in both have the difference
 * of their influences. all, of_part: of the samples that noise is estimated on, and of those of them whose part [n_blocks FF_BLOCK
 * of the whole problem] is above 0. */
ff_status ff_carriers_of_difference(const ff_plan *plan, const ff_point *at, const ff_noise *noise, const float *deviation,
                                    const ff_information *all, const ff_information *of_part, const float *part, ff_carriers *out);

/* ---- what a fit keeps --------------------------------------------------------------------------- */

/* The noise of the data of a fit, and where the standardised fit ended. One piece of memory, released with free. */
typedef struct ff_noise_found {
    size_t bytes;
    double shape[FF_MAX_SHAPE], *channel; /* of the standardised fit; [n_channels][n_channel] */
    ff_carriers carriers;                 /* of the fit's parameters                          */
    ff_noise *noise;
} ff_noise_found;

/* Are the errors of this fit by the noise of its data? */
int ff_noise_is_wanted(const ff_plan *plan);

/* The one given, or the estimate; *out NULL where there is nothing but rounding. FF_ERR_MEMORY, FF_ERR_CANCELLED. */
ff_status ff_noise_find(const ff_plan *plan, const ff_point *at, ff_noise_found **out);
/* NULL without memory, and of NULL. */
ff_noise_found *ff_noise_found_copy(const ff_noise_found *found);

/* Replaces the covariance and the degrees of freedom of info by those of the noise: H^-1 J' S J H^-1, moderated by the residuals.
 * carriers: what it found of them; NULL = not asked for. FF_ERR_MEMORY. */
ff_status ff_noise_errors(const ff_plan *plan, const ff_point *at, const ff_noise_found *found, ff_information *info,
                          ff_carriers *carriers);

/* Standard error of the difference between the estimates from the samples whose part [n_blocks FF_BLOCK] is above 0 and from all,
 * and its degrees of freedom, for each parameter, [P]; the plan is that of all samples. FF_ERR_MEMORY. */
ff_status ff_noise_difference(const ff_plan *plan, const ff_point *at, const ff_noise_found *found, const float *part, double *out,
                              double *dof);
#endif
