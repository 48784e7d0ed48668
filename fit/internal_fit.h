/* The inside of the fit: the samples as blocks of planes, a pass over them, and the small normal equations it leaves behind. */
#ifndef FF_INTERNAL_FIT_H
#define FF_INTERNAL_FIT_H
#include "ff_fit.h"
#include "models/internal_model.h"
#include "base/internal_pool.h"
#include <math.h>

/* ---- samples --------------------------------------------------------------------------------- */

enum { FF_CHUNK = 32 }; /* blocks that are summed before their sums are merged, in their order: the sums do not know of threads */

/* One sample per lane. A chunk keeps each plane in one piece, so that the processor sees a few long streams and fetches ahead of
 * them; the pieces start a little more than a whole page apart, or they would contend for the same lines of the first-level cache.
 * Lanes beyond n hold some pair of directions with weight 0. */
enum { FF_PLANE_STRIDE = FF_CHUNK * FF_BLOCK + FF_BLOCK + 8 };
struct ff_problem {
    size_t n, n_blocks, n_planes, n_channels;
    double *data;
    /* Position of each plane inside a block, -1 = absent. */
    int geometry[FF_G_COUNT];
    int weight;        /* square root of the loss's weight, everything that multiplies g(f) - g(y)        */
    int weight_stride; /* 0: one plane for all channels; 1: plane weight + c                              */
    int target;        /* plane target + c: g(y); for linear losses y                                     */
    int value;         /* plane value + c: y                                                              */
    int sample_weight; /* square root of the sample's weight alone                                        */
    int side;          /* plane side + c, -1 = absent: +1 where the datum is only known to be at or above the target, -1 at or
                          below, else 0 */
    ff_loss loss;
    int surrogate;           /* 1: a linear stand-in for the loss, for the search of a start                     */
    double tan2_lo, tan2_hi; /* range of tan^2 theta over the samples' directions                       */
    ff_selection selection;
    char (*channel_name)[FF_CHANNEL_NAME];
    double *channel_mean;    /* [n_channels] of |y| over the used samples */
    uint32_t *index;         /* [n] place of each sample in the table, or in the problem that a smaller one stands for */
    float *lowest;           /* [n_blocks FF_BLOCK] the lower of the cosines of both directions; NULL in a smaller problem */
    const float *multiplier; /* [n_blocks FF_BLOCK] borrowed, NULL = 1: root of the weight of each sample when they are resampled */
    /* [n_channels][n_blocks FF_BLOCK], NULL = 1: standard deviation of each residual, which the scale of a robust loss multiplies.
     */
    const float *unit;
    ff_pool *pool;
    ff_isa isa;
    /* What starts are searched on, and what they are then refined on before all samples are: see ff_problem_thin. The last is
     * NULL where there are too few samples to make it worth while. */
    struct ff_problem *thin, *thin_linear, *middle;
};

static inline double *ff_problem_plane(const struct ff_problem *p, size_t block, int plane)
{
    return p->data + (block / FF_CHUNK * p->n_planes + (size_t)plane) * FF_PLANE_STRIDE + block % FF_CHUNK * FF_BLOCK;
}

/* Blocks whose sums a pass over the pool makes in one go: a chunk, or less where there are so many channels that a few chunks would
 * be all the work there is to share out. */
static inline size_t ff_problem_share(const struct ff_problem *p)
{
    const size_t share = 8 * FF_CHUNK / p->n_channels;
    return share > FF_CHUNK ? FF_CHUNK : share < 4 ? 4 : share;
}

/* Doubles that the planes of a problem take. */
static inline size_t ff_problem_doubles(const struct ff_problem *p)
{
    return (p->n_blocks + FF_CHUNK - 1) / FF_CHUNK * p->n_planes * FF_PLANE_STRIDE;
}

/* A smaller problem that stands for p: the samples with the largest weighted values, all of them, and every k-th of the rest with k
 * times the weight; some `wanted` in all. size [n]: the magnitudes |w g(y)|. linear: with the loss replaced by its linearisation
 * about the data. Shares the pool; goes with p. */
ff_status ff_problem_thin(const struct ff_problem *p, const float *size, size_t wanted, int linear, struct ff_problem **out);
void ff_problem_thin_free(struct ff_problem *p);

/* cos(theta_i) of a block from whichever of its planes has it. */
static inline void ff_problem_cosines(const ff_geometry *g, double *x)
{
    const double *t2 = g->plane[FF_G_TI2], *tx = g->plane[FF_G_TIX], *ty = g->plane[FF_G_TIY], *cosine = g->plane[FF_G_COS_I];
    for (int i = 0; i < FF_BLOCK; i++)
        x[i] = cosine ? cosine[i] : t2 ? 1 / sqrt(1 + t2[i]) : 1 / sqrt(1 + tx[i] * tx[i] + ty[i] * ty[i]);
}

/* Memory for blocks, aligned, in large pages where the system has them; NULL when there is none. Released with free. */
double *ff_block_memory(size_t bytes);

/* Puts the used samples of a table, index [n], in an order in which neighbours are alike, unless they come on axes or in scans of
 * one incident direction, or are very many. FF_ERR_MEMORY. */
ff_status ff_order_by_place(const ff_table *t, ff_pool *pool, uint32_t *index, size_t n);

/* FF_ERR_RANGE for an option that names nothing or lies outside its range, whatever the data. */
ff_status ff_fit_options_check(const ff_fit_options *o, ff_error *err);

/* The scale of a robust loss, in standard deviations of normal residuals, at which it loses 5 % of their information. */
double ff_robust_tuning(ff_robust robust);

/* Has the caller asked to stop? */
int ff_fit_cancelled(const ff_fit_options *o);

/* ---- one pass -------------------------------------------------------------------------------- */

enum { FF_MAX_COLUMNS = FF_MAX_SHAPE + FF_MAX_CHANNEL_PARAMS + 1 };

/* What one pass evaluates. Columns of a channel: the free shape parameters, the channel's free ones, and the residual. */
typedef struct ff_pass {
    ff_prepared prepared;
    const struct ff_problem *p;
    ff_robust robust;
    double robust_scale;
    int final;  /* 1: also the residual statistics                                    */
    int errors; /* 1: and what standard errors need: outer products and sums of the score */
} ff_pass;

/* Sums of the residual statistics, over samples and channels, by sample weight. */
enum { FF_STAT_WEIGHT = 0, FF_STAT_PLAIN, FF_STAT_COSINE, FF_STAT_LOG, FF_STAT_CUBE_ROOT, FF_STAT_MAX, FF_STAT_COUNT };

/* Samples of a run: residuals of neighbours go together, and sums over runs show how much. Many samples have long ones, so that
 * what is done with the sums stays short beside a pass. */
enum { FF_SHORT_RUN = 8, FF_LONG_RUN = FF_BLOCK, FF_LONG_RUNS_FROM = 100000 };
static inline size_t ff_run_length(const struct ff_problem *p)
{
    return p->n >= FF_LONG_RUNS_FROM ? FF_LONG_RUN : FF_SHORT_RUN;
}

/* What a pass leaves. m1 = columns of a channel and the residual, P = columns of the layout, tied ones apart (until
 * ff_normal_fold). */
typedef struct ff_normal {
    size_t m1, P, n_channels;
    double cost2; /* sum of rho(r^2): twice the objective                                    */
    double *gram; /* [n_channels][m1 (m1+1) / 2], lower triangle by rows: J^T J, J^T r, r^T r */
    double *meat; /* [P (P+1) / 2]: sum over samples of score score^T; only of a final pass. Of an arrow [P]: its diagonal */
    int diagonal; /* 1: meat is [P], its diagonal alone: of an arrow, whose score is scaled by ff_arrow.scale */
    double *own;  /* [P]: sum over samples and channels of the squared score of one value     */
    size_t n_runs;
    double *runs; /* [n_runs][P]: sums of the score over runs of consecutive samples; NULL unless of a final pass */
    double stat[FF_STAT_COUNT];
} ff_normal;

void ff_normal_free(ff_normal *n);

/* Position in the packed lower triangle. */
static inline size_t ff_tri(size_t row, size_t col)
{
    return row >= col ? row * (row + 1) / 2 + col : col * (col + 1) / 2 + row;
}

/* Runs the pass. parallel = 0: on the calling thread alone, for callers that are themselves spread over the pool.
 * FF_ERR_MEMORY; FF_ERR_INTERNAL when a sum is not finite. */
ff_status ff_pass_run(const ff_pass *pass, int parallel, ff_normal *out);

/* The kernel of one chunk of blocks: adds to the lane sums [8] each. acc: cost2 lanes, gram lanes, stat lanes, meat lanes; see
 * pass.c. */
typedef struct ff_chunk_sums {
    double *cost2; /* [8]                                   */
    double *gram;  /* [n_channels][m1 (m1+1)/2][8]          */
    double *stat;  /* [FF_STAT_COUNT][8]                    */
    double *meat;  /* [P (P+1)/2][8]                        */
    double *own;   /* [P][8]                                */
    double *score; /* scratch [P][FF_BLOCK], with errors     */
    double *runs;  /* [n_runs][P] of the whole problem, with errors */
} ff_chunk_sums;
typedef void (*ff_pass_chunk_fn)(const ff_pass *pass, size_t first_block, size_t n_blocks, const ff_chunk_sums *sums);
ff_pass_chunk_fn ff_pass_chunk_get(ff_isa isa);

/* ---- the full set of parameters of a fit ----------------------------------------------------- */

#define FF_NOT_PINNED SIZE_MAX

/* What is free and in which coordinates (log, atanh or as they are). Columns, those of a pass: the free shape parameters, then the
 * free ones of every channel. Coordinates, what a solver moves and a covariance is of: one for each set of columns that are tied to
 * one value, without ties the columns themselves; first those that all channels share, then the own ones of every channel. */
typedef struct ff_layout {
    const ff_model *m;
    ff_stretch_mode mode;
    size_t n_channels;
    ff_wanted free;
    int linear;             /* 1: the model is affine in the free parameters of a channel, once scales are multiplied out */
    uint32_t scaled;        /* lobes whose free ks multiplies free parameters: affine in ks and in their products with it */
    size_t n_columns;       /* free.n_shape + n_channels free.n_channel                                              */
    size_t P;               /* coordinates: n_shared + n_channels n_own                                              */
    size_t n_shared, n_own; /* free.n_shape and free.n_channel without ties                                          */
    int tied;               /* 1: some coordinate has several columns                                                */
    uint32_t shape_at[FF_MAX_SHAPE];            /* coordinate of a free shape parameter                              */
    uint32_t channel_at[FF_MAX_CHANNEL_PARAMS]; /* of a free channel parameter: among the shared ones, or the n_own  */
    int channel_shared[FF_MAX_CHANNEL_PARAMS];  /* 1: the former                                                     */
    int shape_follows[FF_MAX_SHAPE];            /* the free parameter of its kind that it is equal to, -1 = none     */
    int channel_follows[FF_MAX_CHANNEL_PARAMS]; /* in its channel                                                    */
    const struct ff_extras *extras;             /* terms of the objective that are not of the data, NULL = none      */
    int arrow;     /* 1: many channels, nothing of size P^2 is made; see internal_arrow.h. Set by ff_layout_many */
    size_t pinned; /* coordinate that ff_solve leaves where it is; FF_NOT_PINNED */
} ff_layout;

/* Makes a layout of more than `dense` channels an arrow, unless ties or terms of the objective of their own join channels. */
static inline void ff_layout_many(ff_layout *l, size_t dense)
{
    l->arrow = l->n_channels > dense && l->free.n_channel > 0 && !l->tied && !l->extras;
}

/* Coordinate of column k of channel c: free shape parameters first. */
static inline size_t ff_layout_coordinate(const ff_layout *l, size_t c, size_t k)
{
    if (k < l->free.n_shape) return l->shape_at[k];
    k -= l->free.n_shape;
    return l->channel_shared[k] ? l->channel_at[k] : l->n_shared + c * l->n_own + l->channel_at[k];
}

/* Chooses the free parameters for a shape. FF_ERR_UNSUPPORTED where the model cannot take it. */
ff_status ff_layout_init(const ff_model *m, size_t n_channels, ff_shape shape, int mean_slope, ff_layout *out, ff_error *err);

/* Numbers the coordinates after shape_follows, channel_follows or channel_shared of free parameters were set. */
void ff_layout_number(ff_layout *l);

/* The layout of the channel parameters alone: no shape columns. */
ff_layout ff_layout_of_channels(const ff_layout *l);

/* Which parameters of a model are equal: the one that each follows, itself where it follows none. shared: one value for all
 * channels.
 */
typedef struct ff_ties {
    uint32_t n; /* as many as were asked for */
    uint32_t shape[FF_MAX_SHAPE], channel[FF_MAX_CHANNEL_PARAMS];
    int shared[FF_MAX_CHANNEL_PARAMS];
} ff_ties;

/* Bounds and ties of c (NULL = none) for a fit of m with a shape that is not AUTO: narrows, holds and frees the parameters of m and
 * says which are equal. Errors as ff_constraints_check, m may then be changed in part. */
ff_status ff_constraints_apply(const ff_constraints *c, ff_shape shape, ff_model *m, ff_ties *ties, ff_error *err);

/* Ties of l's model: before anything is made of l's coordinates. */
void ff_layout_tie(ff_layout *l, const ff_ties *ties);

/* What a name of the constraints stands for: one or two parameters as ff_model_param_find says, "alpha" for both axes, which an
 * isotropic shape has one of. The count; 0 when m has none of that name. */
int ff_constraints_named(const ff_model *m, ff_shape shape, const char *name, int at[2]);

/* Moves free parameters into their bounds and tied ones to what they follow; channel may be NULL. */
void ff_layout_project(const ff_layout *l, double *shape, double *channel);

/* Makes a shape of a search one of the layout: what is held at its value, what is free in its bounds and tied. */
void ff_layout_candidate(const ff_layout *l, double *shape);

/* What FF_SHAPE_AUTO stands for; others as they are. */
ff_shape ff_layout_shape(const ff_model *m, int isotropic_table, ff_shape asked, int mean_slope);

/* The mode of the model's stretched lobes for a shape. */
ff_stretch_mode ff_layout_mode(const ff_model *m, ff_shape shape, int mean_slope);

/* The parameter of coordinate k < P that others may follow, and the channel it belongs to (0 for a shared one); c may be NULL. */
const ff_model_param *ff_layout_param(const ff_layout *l, size_t k, size_t *c);

double ff_coordinate(const ff_param *info, double value);
double ff_coordinate_value(const ff_param *info, double coordinate);
/* d value / d coordinate */
double ff_coordinate_slope(const ff_param *info, double value);

/* shape [m->n_shape], channel [n_channels][m->n_channel] -> x [P], and back (held parameters are left alone). */
void ff_layout_pack(const ff_layout *l, const double *shape, const double *channel, double *x);
void ff_layout_unpack(const ff_layout *l, const double *x, double *shape, double *channel);
/* d parameter / d coordinate, [P] */
void ff_layout_slope(const ff_layout *l, const double *shape, const double *channel, double *slope);

ff_status ff_normal_new(const ff_layout *l, ff_normal *out);

/* Initial values as ff_model_defaults (channel may be NULL), with one roughness for both axes of an isotropic shape and tied
 * parameters equal. */
void ff_layout_defaults(const ff_layout *l, double *shape, double *channel);

/* Makes pass ready for these parameters, which must outlive it. FF_ERR_MEMORY. Release it with ff_pass_free. */
ff_status ff_layout_pass(const ff_layout *l, const struct ff_problem *p, const ff_fit_options *o, const double *shape,
                         const double *channel, ff_pass *pass);
void ff_pass_free(ff_pass *pass);

/* Puts lobes of one kind into the order of their widths, narrowest first, with everything that belongs to them: a sum has no order,
 * its parameters need one. Returns whether anything moved. */
int ff_lobes_order(const ff_model *m, size_t n_channels, double *shape, double *channel);

/* The same where bounds and ties do not tell the lobes apart; priors that name one decide in place of the width. */
int ff_layout_order(const ff_layout *l, double *shape, double *channel);

/* May lobes a and b be ordered by their widths? */
int ff_layout_exchangeable(const ff_layout *l, uint32_t a, uint32_t b);

/* ---- start and solve ------------------------------------------------------------------------- */

/* A candidate for the optimum. */
typedef struct ff_candidate {
    double cost2;
    double shape[FF_MAX_SHAPE];
} ff_candidate;

/* Bounded least squares: q in [lo, hi] minimising |r + L q|^2 from the packed gram of [L r], n <= FF_MAX_CHANNEL_PARAMS columns.
 * Returns the minimum. */
double ff_bounded_least_squares(const double *gram, size_t n, const double *lo, const double *hi, double *q);

/* The same for all channels of a layout of channel parameters alone of which some are tied: from the parameters `at` [n_channels]
 * [n_channel], where tied ones are equal, to the minimum out (may be at) of the quadratic that the grams are of. Returns it;
 * INFINITY and out = at without memory. */
double ff_tied_least_squares(const ff_layout *l, const ff_normal *normal, const double *at, double *out);

/* A model that is linear in its channel parameters and has the lobes of l's: its start leads to that of l's (ff_standin_start). For
 * a layout that is linear itself that is the layout. FF_ERR_INTERNAL cannot happen for models that parsed. */
typedef struct ff_standin {
    ff_model model;
    ff_layout layout;
} ff_standin;
ff_status ff_standin_make(const ff_layout *l, ff_standin *out);

/* From an optimum of the stand-in: shape, channel of l's model. There are ff_standin_variants ways where it does not say enough. */
uint32_t ff_standin_variants(const ff_layout *l);
void ff_standin_start(const ff_layout *l, const ff_standin *s, uint32_t variant, const double *from_shape,
                      const double *from_channel, double *shape, double *channel);

/* Data far from grazing incidence determine F0 of a conductor, and leave a valley of (eta, k) that ends at k = 0 on either side,
 * where the slope by k vanishes. Puts channel c of a lobe at the end with the higher or the lower eta; 0 when it has no such term.
 */
int ff_standin_end_of_valley(const ff_layout *l, uint32_t lobe, size_t c, int high, double *channel);

/* Shape parameters that the search goes through point by point. */
uint32_t ff_start_searched(const ff_layout *l);

/* The best starting points of a linear layout on the thin problem of p, best first, at most max; channel parameters by
 * ff_start_channels. */
ff_status ff_start_search(const ff_layout *l, const struct ff_problem *p, const ff_fit_options *o, ff_candidate *out, size_t max,
                          size_t *n_out);

/* Other places for one lobe of a linear layout, the others staying where they are in the shape `from`: best first, at most
 * FF_MOVES, the best of the narrowest among them. */
enum { FF_MOVES = 4 };
ff_status ff_start_moves(const ff_layout *l, const struct ff_problem *p, const ff_fit_options *o, const double *from, uint32_t lobe,
                         ff_candidate *out, size_t *n_out);

/* One lobe after the other on a grid of its own, from lobe `first` on, the later ones not there yet: best first, at most
 * FF_SEQUENCES. */
enum { FF_SEQUENCES = 4 };
ff_status ff_start_sequence(const ff_layout *l, const struct ff_problem *p, const ff_fit_options *o, uint32_t first,
                            ff_candidate *out, size_t *n_out);

/* The free channel parameters that minimise the thin problem of p for a shape: exact where the residual is linear in them, else by
 * Gauss-Newton steps, from the linear stand-in of the loss or, in a layout that is not linear, from channel as it comes. channel
 * [n_channels][n_channel] in and out. On the calling thread. */
ff_status ff_start_channels(const ff_layout *l, const struct ff_problem *p, const ff_fit_options *o, const double *shape,
                            double *channel, double *cost2);

/* Where to start on all samples: shape, channel (out) by a search on the thin problem. */
ff_status ff_search(const ff_layout *l, struct ff_problem *p, const ff_fit_options *o, double *shape, double *channel,
                    ff_error *err);

/* Most of the way is gone on fewer samples: from a given start on the thin problem, then on the middle one. */
ff_status ff_approach(const ff_layout *l, struct ff_problem *p, const ff_fit_options *o, double *shape, double *channel,
                      ff_error *err);

/* What the iteration of ff_solve leaves. */
typedef struct ff_solution {
    ff_outcome outcome;
    int iterations, passes;
    double cost2;
    ff_normal normal; /* of a final pass at the solution, where one was made (has_final); else zero. The caller's to free */
    int has_final;
    struct ff_arrow *arrow; /* the covariance of an arrow, whose normal holds the sums of a plain pass and the statistics; the
                               caller's to free */
} ff_solution;

/* Minimises from shape, channel (in and out) until a step would lower the objective by less than `tolerance` of itself.
 * speculate: passes that look like being the last are made final ones. at_bound [P]: -1, 0, +1 in coordinates. */
ff_status ff_solve(const ff_layout *l, const struct ff_problem *p, const ff_fit_options *o, int parallel, int speculate,
                   double tolerance, int max_iterations, double *shape, double *channel, int *at_bound, ff_solution *out,
                   ff_error *err);

/* ---- what is known besides the data ----------------------------------------------------------- */

/* Terms of the objective that no sample has: priors, and the penalty on albedos above 1. */
typedef struct ff_extras ff_extras;

/* Those of c (NULL = none) for a layout that has its ties; *out = NULL when there are none. FF_ERR_MEMORY. The terms weigh nothing
 * until ff_extras_solve gives them their weights. */
ff_status ff_extras_new(const ff_constraints *c, const ff_layout *l, ff_shape shape, ff_extras **out);
void ff_extras_free(ff_extras *e);

/* Does a prior name a parameter of one of these lobes that is not tied to that in its place in the other? */
int ff_extras_tell_apart(const ff_layout *l, uint32_t a, uint32_t b);

/* Sum of squares of the distances to the priors, in their standard deviations. */
double ff_extras_mismatch(const ff_layout *l, const double *shape, const double *channel);

/* Adds the terms of l at these parameters to twice the objective and to J^T J, J^T r in coordinates; slope as ff_normal_assemble.
 * parallel as ff_pass_run. Without terms it does nothing. FF_ERR_MEMORY. */
ff_status ff_extras_add(const ff_layout *l, const struct ff_problem *p, int parallel, const double *shape, const double *channel,
                        const double *slope, double *cost2, double *H, double *g);

/* What the terms say of the parameters: added to the information H [P][P] and, times factor, to the packed outer products of the
 * scores M; either may be NULL. */
void ff_extras_covariance(const ff_layout *l, double factor, double *H, double *M);

/* The information that priors give of coordinate k by itself, in the units of J^T J. */
double ff_extras_weight(const ff_layout *l, size_t k);

/* From the optimum of the data alone, with its final pass in *solution, to that with the terms of e, which are l's. */
ff_status ff_extras_solve(ff_extras *e, const ff_layout *l, const struct ff_problem *p, const ff_fit_options *o, double *shape,
                          double *channel, int *at_bound, ff_solution *solution, ff_error *err);

/* The prior of a parameter, as ff_model_param_find says; 0 when it has none. */
int ff_extras_prior(const ff_extras *e, int at, double *mean, double *sd);

/* What the priors add to the objective at the optimum. */
double ff_extras_penalty(const ff_extras *e);

/* The k-th thing to say of the terms of l where the data's objective is this; 0 when there are no more. */
int ff_extras_warning(const ff_layout *l, const struct ff_problem *p, double objective, size_t k, char out[FF_WARNING_LENGTH]);

/* ff_solve on all samples, lobes in their order. */
ff_status ff_solve_in_order(const ff_layout *l, const struct ff_problem *p, const ff_fit_options *o, double *shape, double *channel,
                            int *at_bound, ff_solution *solution, ff_error *err);

/* ---- result ---------------------------------------------------------------------------------- */

/* Everything that is said of an optimum whose final pass is solution->normal; shape_value and channel_value are allocated. */
ff_status ff_result_fill(const ff_layout *l, const struct ff_problem *p, const ff_fit_options *o, const double *shape,
                         const double *channel, const int *at_bound, const ff_solution *solution, ff_fit_result *r);

/* Of parameter k < P: its place in a result, and "f0 (r)" or "alpha_x". */
ff_fit_value *ff_result_value(const ff_layout *l, ff_fit_result *r, size_t k);
/* Error and interval of alpha_x to the alpha_y that moves with it. */
void ff_result_copy_tied(const ff_layout *l, ff_fit_result *r);
void ff_result_label(const ff_layout *l, const struct ff_problem *p, size_t k, char *out, size_t size);
void ff_result_warn(ff_fit_result *r, const char *fmt, ...) __attribute__((format(printf, 2, 3)));

/* ---- covariance ------------------------------------------------------------------------------ */

/* Full J^T J [P][P] and J^T r [P] from the channels' grams, columns of one coordinate added up. slope [P]: d parameter / d
 * coordinate, or NULL for the parameters themselves. */
void ff_normal_assemble(const ff_layout *l, const ff_normal *n, const double *slope, double *H, double *g);

/* Adds up the columns of one coordinate in what a final pass left for the errors (meat, own, runs): n->P is then l->P, and no pass
 * may be run into n again. FF_ERR_MEMORY. */
ff_status ff_normal_fold(const ff_layout *l, ff_normal *n);

/* Cholesky factor of a symmetric positive semidefinite A [n][n] after scaling its diagonal to 1: A = D L L^T D, L [n][n] lower, D
 * [n]. A pivot at or below `tolerance` leaves a zero column: that parameter is a combination of the ones before it. Returns the
 * rank. */
size_t ff_scaled_cholesky(const double *A, size_t n, double tolerance, double *L, double *D);

/* Runs of neighbouring samples whose errors go together. */
typedef struct ff_clusters {
    size_t run;  /* samples of a cluster; 1: they are independent, as far as can be seen            */
    size_t n;    /* clusters                                                                        */
    int settled; /* 0: the errors reach further than the longest runs of which there are enough     */
} ff_clusters;
/* Residuals that are nothing but rounding have no errors that could go together. */
ff_status ff_clusters_choose(const struct ff_problem *p, const ff_normal *n, size_t n_samples, ff_clusters *out);

/* Outer products of the score summed over runs of `run` samples (1, or ff_run_length 2^k), packed as ff_normal.meat. FF_ERR_MEMORY.
 */
ff_status ff_clusters_meat(const struct ff_problem *p, const ff_normal *n, size_t n_samples, size_t run, double *meat);

/* Clusters are as good as equal ones of a smaller number where some have more to say of a parameter than others (Carter, Schnepel
 * and Steigerwald 2017): number [P], for the degrees of freedom of its error. cluster [p->n] of each sample, NULL: n_clusters of
 * equal length in the order of the samples; inverse [P][P] of J^T J, 0 for parameters that are not in use, or arrow instead.
 * FF_ERR_MEMORY. */
struct ff_arrow;
ff_status ff_clusters_informative(const struct ff_problem *p, const ff_normal *n, size_t n_samples, const uint32_t *cluster,
                                  size_t n_clusters, const double *inverse, const struct ff_arrow *arrow, double *number);

/* Sums of the score over the runs, less their mean: it is 0 for a parameter at its optimum, and for one that rests on its bound a
 * slope, which is no error. n_samples of the samples of p count. sums [runs][P], mean [P] out; returns the number of runs. */
size_t ff_clusters_centred(const struct ff_problem *p, const ff_normal *n, size_t n_samples, double *sums, double *mean);
/* Joins pairs of neighbours; a last one without partner stays. Returns how many are left. */
size_t ff_clusters_join(double *sums, size_t n, size_t P);

/* Number of independent values that would say as much as the n_values; meat of the clusters. */
double ff_clusters_effective(const ff_normal *n, const double *meat, size_t n_shape, double n_values);

/* The two sides of what is known at an optimum, of the parameters (not coordinates) in use; [P][P], 0 elsewhere. */
typedef struct ff_uncertainty {
    double *inverse; /* H^-1                                                                       */
    double *cov;     /* covariance                                                                 */
    int *determined; /* [P]: 0 where the data say nothing                                          */
    ff_clusters clusters;
    double effective; /* number of independent values                                               */
    double *dof;      /* [P] degrees of freedom that the error of each is estimated from            */
    double *storage;
} ff_uncertainty;
void ff_uncertainty_free(ff_uncertainty *u);

/* Number of equal clusters that n of unequal variance are as good as, from squares q of normal variables: all = {sum q, sum q^2},
 * squares = sum over clusters of (sum q)^2 - 2/3 sum q^2. */
double ff_clusters_count(const double all[2], double squares, double n);

/* Share of the variance that is seen when the error of a parameter is estimated from a number of clusters, by a fit of so many
 * parameters to a channel. */
double ff_clusters_share_seen(double parameters, double number);
double ff_clusters_seen(const ff_layout *l, const ff_uncertainty *u, double number);

/* Of the parameters whose `use` is not 0, from a pass over n_samples samples of p. The covariance is H^-1 M H^-1 with M over
 * clusters (heteroscedasticity-consistent, HC1: MacKinnon and White 1985); with weights by the data's standard deviations it is
 * H^-1, its errors larger by what the clusters say. FF_ERR_MEMORY. */
ff_status ff_uncertainty_new(const ff_layout *l, const struct ff_problem *p, const ff_normal *n, const int *use, size_t n_samples,
                             ff_uncertainty *out);

/* 95 % intervals of all parameters: by their standard errors, which r has, or one-sided on a bound (at_bound [P]). FF_ERR_MEMORY.
 */
ff_status ff_intervals_fill(const ff_layout *l, const struct ff_problem *p, const ff_normal *n, const int *at_bound,
                            const ff_uncertainty *u, ff_fit_result *r);
/* Interval of v->value +- half_width, symmetric in the coordinate. */
void ff_interval_around(const ff_param *info, double half_width, ff_interval kind, ff_fit_value *v);
/* From the bound of v inside to where slope d + d^2 / (2 inverse) has risen by allowed; no curvature: to the other bound. */
void ff_interval_from_bound(const ff_param *info, double slope, double inverse, double allowed, ff_fit_value *v);

/* Rank and condition of the Jacobian of the parameters in use; warns of several that trade off. FF_ERR_MEMORY. */
ff_status ff_condition_fill(const ff_layout *l, const struct ff_problem *p, const ff_normal *normal, const int *use,
                            ff_fit_result *r);

/* Eigenvalues [n], ascending, and eigenvectors (columns of V [n][n]) of a symmetric A [n][n], which is destroyed: Jacobi's
 * rotations. */
void ff_symmetric_eigen(double *A, size_t n, double *values, double *V);

#endif
