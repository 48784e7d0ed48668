/* What a fit is about: the samples and their subsamples, which parameters are free in which coordinates, what is known of
 * them besides the data, and the two things that every stage takes: the plan and the point. */
#ifndef FF_INTERNAL_PROBLEM_H
#define FF_INTERNAL_PROBLEM_H
#include "fit/interface/internal_interface.h"
#include "fit/layout/internal_layout.h"

/* ---- samples --------------------------------------------------------------------------------- */

/* A smaller problem that stands for p: the samples with the largest weighted values, all of them, and every k-th of the rest with k
 * times the weight; some `wanted` in all. size [n]: the magnitudes |w g(y)|. linear: with the loss replaced by its linearisation
 * about the data. Shares the pool; goes with p. */
ff_status ff_problem_subsample(const struct ff_problem *p, const float *size, size_t wanted, int linear, struct ff_problem **out);
void ff_problem_subsample_free(struct ff_problem *p);

/* How many samples of `whole` sample i of p, one of its smaller problems, stands for; of the whole 1. */
double ff_problem_stands_for(const struct ff_problem *p, const struct ff_problem *whole, size_t i);

/* Takes the aperture of the options, NULL or a point for none: values are means over it from now on. FF_ERR_RANGE, FF_ERR_MEMORY.
 */
ff_status ff_problem_see_through(struct ff_problem *p, const ff_aperture *a, ff_error *err);

/* Puts the directions of a block, six planes of FF_BLOCK, where means find them. */
void ff_problem_put_directions(struct ff_problem *p, size_t block, const ff_dirs *w);

/* Is a plan's objective made of means? */
#define ff_plan_averages(plan) ((plan)->p->rules && !(plan)->as_points)

/* Memory for blocks, aligned, in large pages where the system has them; NULL when there is none. Released with free. */
double *ff_block_memory(size_t bytes);

/* Targets of a channel's values in a block, and the weights of a loss that weighs by the datum; x [FF_BLOCK]: cos(theta_i). */
void ff_problem_aim(const struct ff_problem *p, size_t block, size_t c, const double *x);

/* Do the samples that share the very largest value lie at several half vectors and difference angles? A detector that saturates
 * makes such a plateau, a surface does not; data that are nearly all the same have none. index [n]: places in the table. */
int ff_problem_looks_saturated(const struct ff_problem *p, const ff_table *t, const uint32_t *index);

/* Angle, radians, from the exit nearest to the mirror direction to its next neighbour, the median of incident directions; NaN where
 * these do not repeat, as those of pixels and of grids of half vectors, and of very many. index [n]: places in the table. */
double ff_problem_spacing_of(const ff_table *t, const uint32_t *index, size_t n);

/* Leaves out of index [*n] what only repeats an earlier sample, unless the table is a grid or has weights; copies: how many.
 * FF_ERR_MEMORY. */
ff_status ff_copies_leave_out(const ff_table *t, uint32_t *index, size_t *n, size_t *copies);

/* Puts the used samples of a table, index [n], in an order in which neighbours are alike, unless they come on axes or in scans of
 * one incident direction, or are very many. FF_ERR_MEMORY. */
ff_status ff_order_by_place(const ff_table *t, ff_pool *pool, uint32_t *index, size_t n);

/* ---- the plan and the point -------------------------------------------------------------------- */

/* Terms of the objective that no sample has: priors, and the penalty on albedos above 1. */
typedef struct ff_penalties ff_penalties;

/* Everything about a fit that is known before it begins, and constant from then on: the request of the caller (model, options,
 * constraints by name) resolved once. Nothing below reads the options again. A plan may be copied, to be used on other samples
 * (ff_plan_on) or with fewer free parameters; a copy lives no longer than the plan that it is of. */
typedef struct ff_plan {
    ff_layout l;                /* what is free, in which coordinates; its model is `model`, or that of a surrogate */
    const struct ff_problem *p; /* the samples                                                                     */
    ff_shape shape;             /* never AUTO                                                                      */
    ff_robust robust;
    double robust_scale;          /* b: the one given, or that in standard deviations of an estimated scale                  */
    int errors;                   /* 1: standard errors are wanted                                                          */
    int by_residuals;             /* 1: by the residuals alone, not by the noise of the data                                */
    const struct ff_noise *noise; /* of the data, where it is given; NULL: it is estimated                         */
    int max_iterations;           /* of the solver on all samples                                                           */
    const volatile int *cancel;
    void (*progress)(void *context, int iteration, double objective);
    void *progress_context;
    const ff_penalties *penalties;             /* NULL = none                                                                  */
    const double *start_shape, *start_channel; /* NULL: to be searched for                                         */
    int as_points;           /* 1: samples are taken as points, whatever their aperture: where a start is searched         */
    const ff_levels *levels; /* of p's samples, held; NULL: each block chooses its own                                  */
    int bounded;             /* 1: there are constraints, which a given start is brought into                                  */
    /* of a plan made by ff_plan_new, which owns them */
    ff_model *model; /* bounds and what is held applied */
    ff_penalties *own_penalties;
    ff_limits *own_limits;
} ff_plan;

/* From the request. FF_ERR_RANGE, FF_ERR_UNKNOWN, FF_ERR_UNSUPPORTED, FF_ERR_DATA (fewer values than parameters), FF_ERR_MEMORY, as
 * ff_problem_fit. Release it with ff_plan_free. */
ff_status ff_plan_new(const struct ff_problem *p, const ff_model *m, const ff_fit_options *o, ff_plan *out, ff_error *err);
void ff_plan_free(ff_plan *plan);

/* The plan that a finished fit had, without penalties: its model has bounds and what is held, which are tied is said again.
 * FF_ERR_RANGE for a fit of other channels than those of p. */
ff_status ff_plan_of_result(const struct ff_problem *p, const ff_fit_options *o, const ff_fit_result *fit, ff_plan *out,
                            ff_error *err);

/* A plan of a layout whose model and constraints are seen to already. */
ff_plan ff_plan_with(const ff_layout *l, const struct ff_problem *p, const ff_fit_options *o);

/* The same on other samples. */
static inline ff_plan ff_plan_on(const ff_plan *plan, const struct ff_problem *p)
{
    ff_plan other = *plan;
    if (p != plan->p) other.levels = NULL;
    other.p = p;
    return other;
}

/* The plan of the channel parameters alone: no shape columns. */
ff_plan ff_plan_of_channels(const ff_plan *plan);

/* Has the caller asked to stop? */
static inline int ff_plan_cancelled(const ff_plan *plan)
{
    return plan->cancel && __atomic_load_n(plan->cancel, __ATOMIC_RELAXED);
}

/* Makes a pass ready for these parameters, which must outlive it. FF_ERR_MEMORY. Release it with ff_pass_free. */
ff_status ff_plan_pass(const ff_plan *plan, const double *shape, const double *channel, ff_pass *pass);
void ff_pass_free(ff_pass *pass);

/* Where a fit is, and what is known there: parameters, what rests on a bound, how it came there, and the sums that the last pass
 * left. The stages of a fit take a plan and move or complete a point. */
typedef struct ff_point {
    double shape[FF_MAX_SHAPE];
    double *channel; /* [n_channels][n_channel]                                     */
    int *at_bound;   /* [P] -1, 0, +1 in coordinates                                */
    ff_outcome outcome;
    int iterations, passes;
    int open;         /* 1: a channel that is dark beside the others has not converged     */
    double cost2;     /* twice the objective                                        */
    ff_normal normal; /* of a final pass here, where one was made (has_final)        */
    int has_final;
    struct ff_information *information; /* where errors are wanted: what the sums say of the parameters; one piece of memory */
    struct ff_noise_found *noise;       /* what the residuals say of the data; stays when the point moves; one piece of memory */
} ff_point;

/* At the defaults. FF_ERR_MEMORY. Release with ff_point_free, which also frees what later stages left in it. */
ff_status ff_point_new(const ff_plan *plan, ff_point *out);
void ff_point_free(ff_point *at);
/* Parameters alone. */
void ff_point_set(const ff_plan *plan, const double *shape, const double *channel, ff_point *at);
/* Forgets the sums: the point is about to move. */
void ff_point_forget(ff_point *at);

/* Where a finished fit ended. FF_ERR_MEMORY. */
ff_status ff_point_of_result(const ff_plan *plan, const ff_fit_result *fit, ff_point *out);

/* A pass at the point with statistics and, as the plan wants them, errors, into at->normal, columns of one coordinate added up. */
ff_status ff_point_pass(const ff_plan *plan, ff_point *at);

/* At the point, for channel c and used sample i: model and residual [n_channels][n], the residual as it was minimised; what each
 * sample adds to the objective, cost [n]. Each may be NULL. parallel as ff_pass_run. FF_ERR_MEMORY. */
ff_status ff_point_evaluate(const ff_plan *plan, const ff_point *at, int parallel, double *model, double *residual, double *cost);

/* A block of a channel at a point: samples first .. first + n, [n] each; f the model, j = dr/df of the residual that is minimised
 * (before a robust loss; 0 where the datum is known from one side only), y the datum, column[k] = dr/d of pass column k. */
typedef struct ff_visited {
    size_t first, n, c;
    const double *f, *j, *y;
    double (*column)[FF_BLOCK];
} ff_visited;
typedef void (*ff_visitor)(void *context, const ff_visited *v);
/* Shows every block of every channel to visit, in order, on the calling thread. FF_ERR_MEMORY. */
ff_status ff_point_visit(const ff_plan *plan, const ff_point *at, ff_visitor visit, void *context);

/* Puts lobes of one kind into the order of their widths, narrowest first, with everything that belongs to them: a sum has no order,
 * its parameters need one. Returns whether anything moved. */
int ff_lobes_order(const ff_model *m, size_t n_channels, double *shape, double *channel);

/* The same where bounds and ties do not tell the lobes apart; priors that name one decide in place of the width. */
int ff_plan_order(const ff_plan *plan, double *shape, double *channel);

/* May lobes a and b be ordered by their widths? */
int ff_plan_exchangeable(const ff_plan *plan, uint32_t a, uint32_t b);

/* ---- what is known besides the data ----------------------------------------------------------- */

/* Those of c (NULL = none) for a layout that has its ties; *out = NULL when there are none. FF_ERR_MEMORY, FF_ERR_UNKNOWN for a
 * channel that p does not have. The terms weigh nothing until ff_penalised_solve gives them their weights. */
ff_status ff_penalties_new(const ff_constraints *c, const ff_layout *l, const struct ff_problem *p, ff_shape shape,
                           ff_penalties **out, ff_error *err);
void ff_penalties_free(ff_penalties *e);

/* Does a prior name a parameter of one of these lobes that is not tied to that in its place in the other? */
int ff_penalties_tell_apart(const ff_plan *plan, uint32_t a, uint32_t b);

/* Sum of squares of the distances to the priors, in their standard deviations. */
double ff_penalties_mismatch(const ff_plan *plan, const double *shape, const double *channel);

/* Adds the terms of plan at these parameters to the normal equations in coordinates; slope as ff_gram_fill. parallel as
 * ff_pass_run. Without terms it does nothing. FF_ERR_MEMORY. */
ff_status ff_penalties_add(const ff_plan *plan, int parallel, const double *shape, const double *channel, const double *slope,
                           ff_gram *g);

/* Adds what the terms say of the parameters to the information. */
void ff_penalties_inform(const ff_plan *plan, ff_gram *g);

/* What priors add to the outer product of the score of coordinate k. */
double ff_penalties_noise(const ff_plan *plan, size_t k);

/* The information that priors give of coordinate k by itself, in the units of J^T J. */
double ff_penalties_weight(const ff_plan *plan, size_t k);

/* The prior of a parameter in channel c; 0 when it has none. */
int ff_penalties_prior(const ff_penalties *e, ff_param_ref at, size_t c, double *mean, double *sd);

/* What the priors add to the objective at the optimum. */
double ff_penalties_penalty(const ff_penalties *e);

/* Warnings of the terms of plan where the data's objective is this. FF_ERR_MEMORY. */
ff_status ff_penalties_warnings(const ff_plan *plan, double objective, ff_warnings *out);

/* ---- warnings -------------------------------------------------------------------------------- */

/* Error and interval of alpha_x to the alpha_y that moves with it. */
void ff_result_copy_tied(const ff_layout *l, ff_fit_result *r);
#endif
