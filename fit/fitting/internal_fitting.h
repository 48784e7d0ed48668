/* A data set, the models that are fitted to it, and what is asked of the fits when they are done. What `fit` and `compare` do, and
 * a program that is linked to the library, is done here. */
#ifndef FF_INTERNAL_FITTING_H
#define FF_INTERNAL_FITTING_H
#include "fit/trust/trust_struct.h"

/* The data, and the problems that were made of them: one for all channels, or one for each. Borrowed. */
typedef struct ff_fitting {
    const char *path; /* of the data: errors name it                                         */
    const ff_table *table;
    const ff_fit_options *options;
    size_t n_problems;
    ff_problem *const *problem;
    int keeps_samples; /* 1: the table still has its samples                                    */
    int errors_given;  /* 1: the options' errors were asked for: what cannot be had is an error */
    /* Makes one fit; NULL: ff_fitting_run. label: of the model, for a person who waits. */
    ff_status (*run)(void *context, size_t problem, const ff_model *m, const char *label, ff_fit_result *out, ff_error *err);
    /* What a person should know though nothing failed: a sentence without a full stop. NULL: nobody is told. */
    void (*note)(void *context, const char *sentence);
    /* What is being done, "" at its end. NULL: nobody is told. */
    void (*busy)(void *context, const char *what);
    void *context;
} ff_fitting;

/* ---- fits ------------------------------------------------------------------------------------ */

/* Problems of t for these models, one for all channels or one for each as the options say; *n of them are to be freed whatever the
 * status is, and the array. */
ff_status ff_fitting_problems(const ff_table *t, const ff_model *models, size_t n_models, const ff_fit_options *o,
                              ff_problem ***problem, size_t *n, ff_error *err);

/* The options of one problem: each alone has one channel. */
ff_fit_options ff_fitting_options_of(const ff_fitting *d, size_t problem);

/* One fit. Data that cannot be fitted are named in err. */
ff_status ff_fitting_run(const ff_fitting *d, size_t problem, const ff_model *m, ff_fit_result *out, ff_error *err);

/* Where the scale of a robust loss is to be estimated: by m, for all fits to this problem. */
ff_status ff_fitting_scale(const ff_fitting *d, size_t problem, const ff_model *m, ff_error *err);

/* Weighs a problem by the noise that a fit to it has found; *weighed 0: there is none, which is said. */
ff_status ff_fitting_weigh(const ff_fitting *d, size_t problem, const ff_fit_result *by, int *weighed, ff_error *err);

/* Fits m to a problem, once more where the weights are those of the noise that the first fit has found. */
ff_status ff_fitting_fit(const ff_fitting *d, size_t problem, const ff_model *m, ff_fit_result *out, ff_error *err);

/* Fits every model to every problem, by one objective: fit [n_problems n_models], of which *n are made, and of each the number of
 * its model in which, NULL = not needed. A model that the options rule out (V-cavity with a mean slope) is left out, with a note;
 * FF_ERR_UNSUPPORTED where none is left. *n fits are to be cleared whatever the status is. */
ff_status ff_fitting_fit_all(const ff_fitting *d, const ff_model *model, size_t n_models, ff_fit_result *fit, size_t *which,
                             size_t *n, ff_error *err);

/* ---- ranks ----------------------------------------------------------------------------------- */

/* Objectives that are no further apart, relative to the lower, are equal. Those of two instruction sets differ by up to 4e-13 of
 * it; of models that differ, by 1e-7 and more. */
#define FF_FITS_TIE 1e-9

/* Indices of the n fits to p by rising objective, into rank [n]. Of those equal to the best of them, but for FF_FITS_TIE, the one
 * with fewer parameters goes first, then the one whose name does. Fits that leave residuals of less than FF_FITS_TIE of the
 * largest value are all equal: exact. */
void ff_fits_rank(const ff_problem *p, const ff_fit_result *fit, size_t n, size_t *rank);

/* The one with the lowest objective, the simpler of two that are equal: the number of one of n >= 1. */
size_t ff_fits_best(const ff_problem *p, const ff_fit_result *fit, size_t n);

/* ---- what is known of fits beyond their results ---------------------------------------------- */

/* A part that is not there was not asked for. */
typedef struct ff_fit_trust {
    int has_bands, has_versus, has_cut_off, has_bootstrap, has_outliers, has_explained, has_next, has_budget;
    ff_bands bands;
    ff_versus versus; /* against the best of its problem: all 0 for that one      */
    ff_cut_off cut_off;
    ff_bootstrap bootstrap;
    ff_outliers outliers;
    ff_explained explained;
    ff_next next;      /* of the best fit of its problem                              */
    size_t next_rival; /* the fit that it is to be told from; itself: none            */
    ff_budget budget;
    ff_budget_options uncertainties; /* that it is of                                                */
} ff_fit_trust;

/* What is asked, and what came of it. Zero is a legal one to clear. */
typedef struct ff_looks {
    size_t bootstrap, folds; /* 0: none                                                            */
    uint64_t seed;
    int profile;
    double cut_off;               /* radians; 0: none                                                   */
    int cut_off_given;            /* 1: asked for; else it is made where it can be                        */
    double reach;                 /* radians; below 0: nobody asks what to measure next                   */
    int by_angle;                 /* 1: residuals by angle of a fit, where the samples are kept           */
    int places_wanted;            /* 1: the places of the samples are needed for something else           */
    ff_budget_options instrument; /* its uncertainties                                           */
    int has_instrument;           /* 1: some were stated                                         */
    size_t n_fits, n_places;
    ff_fit_trust *each; /* [n_fits]                                                           */
    ff_places *places;  /* [n_places] one for each problem                                    */
    int has_difference;
    ff_difference difference; /* between the channels, each fitted alone                            */
} ff_looks;

/* Fit i belongs to problem i; its errors and intervals are replaced as the looks ask. */
ff_status ff_fitting_look(ff_looks *l, const ff_fitting *d, ff_fit_result *fit, size_t n_fits, ff_error *err);

/* The same of compared fits: best [n_problems] is the number of the best fit of each problem. FF_ERR_RANGE for folds that the data
 * do not have. */
ff_status ff_fitting_compare(ff_looks *l, const ff_fitting *d, ff_fit_result *fit, size_t n_fits, const size_t *best,
                             ff_error *err);
void ff_looks_clear(ff_looks *l);

#endif
