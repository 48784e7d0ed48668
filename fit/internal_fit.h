/* The inside of the fit: the samples as blocks of planes, a pass over them, and the small normal equations it leaves behind. */
#ifndef FF_INTERNAL_FIT_H
#define FF_INTERNAL_FIT_H
#include "ff_fit.h"
#include "internal_kernel.h"
#include "internal_pool.h"

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
    ff_loss loss;
    int surrogate;           /* 1: a linear stand-in for the loss, for the search of a start                     */
    double tan2_lo, tan2_hi; /* range of tan^2 theta over the samples' directions                       */
    ff_selection selection;
    char (*channel_name)[FF_CHANNEL_NAME];
    double *channel_mean; /* [n_channels] of |y| over the used samples */
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

/* Memory for blocks, aligned, in large pages where the system has them; NULL when there is none. Released with free. */
double *ff_block_memory(size_t bytes);

/* FF_ERR_RANGE for an option that names nothing or lies outside its range, whatever the data. */
ff_status ff_fit_options_check(const ff_fit_options *o, ff_error *err);

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
    int final; /* 1: also the outer products of the score and the residual statistics */
} ff_pass;

/* Sums of the residual statistics, over samples and channels, by sample weight. */
enum { FF_STAT_WEIGHT = 0, FF_STAT_PLAIN, FF_STAT_COSINE, FF_STAT_LOG, FF_STAT_CUBE_ROOT, FF_STAT_MAX, FF_STAT_COUNT };

/* What a pass leaves. m1 = columns of a channel and the residual, P = parameters of the layout. */
typedef struct ff_normal {
    size_t m1, P, n_channels;
    double cost2; /* sum of rho(r^2): twice the objective                                    */
    double *gram; /* [n_channels][m1 (m1+1) / 2], lower triangle by rows: J^T J, J^T r, r^T r */
    double *meat; /* [P (P+1) / 2]: sum over samples of score score^T; only of a final pass   */
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
    double *score; /* scratch [P][FF_BLOCK], of a final pass */
} ff_chunk_sums;
typedef void (*ff_pass_chunk_fn)(const ff_pass *pass, size_t first_block, size_t n_blocks, const ff_chunk_sums *sums);
ff_pass_chunk_fn ff_pass_chunk_get(ff_isa isa);

/* ---- the full set of parameters of a fit ----------------------------------------------------- */

/* What is free and in which coordinates. Coordinates: the free shape parameters (log, atanh or as they are), then the free ones of
 * every channel. */
typedef struct ff_layout {
    const ff_model *m;
    ff_stretch_mode mode;
    size_t n_channels;
    ff_wanted free;
    int linear;      /* 1: the model is affine in the free parameters of a channel, once scales are multiplied out */
    uint32_t scaled; /* lobes whose free ks multiplies free parameters: affine in ks and in their products with it */
    size_t P;        /* free.n_shape + n_channels free.n_channel                   */
} ff_layout;

/* Chooses the free parameters for a shape. FF_ERR_UNSUPPORTED where the model cannot take it. */
ff_status ff_layout_init(const ff_model *m, size_t n_channels, ff_shape shape, int mean_slope, ff_layout *out, ff_error *err);

/* What FF_SHAPE_AUTO stands for; others as they are. */
ff_shape ff_layout_shape(const ff_model *m, int isotropic_table, ff_shape asked, int mean_slope);

/* The mode of the model's stretched lobes for a shape. */
ff_stretch_mode ff_layout_mode(const ff_model *m, ff_shape shape, int mean_slope);

/* Parameter k < P, and the channel it belongs to (0 for a shared one); c may be NULL. */
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

/* Initial values as ff_model_defaults (channel may be NULL), with one roughness for both axes of an isotropic shape. */
void ff_layout_defaults(const ff_layout *l, double *shape, double *channel);

/* Makes pass ready for these parameters, which must outlive it. FF_ERR_MEMORY. Release it with ff_pass_free. */
ff_status ff_layout_pass(const ff_layout *l, const struct ff_problem *p, const ff_fit_options *o, const double *shape,
                         const double *channel, ff_pass *pass);
void ff_pass_free(ff_pass *pass);

/* Puts lobes of one kind into the order of their widths, narrowest first, with everything that belongs to them: a sum has no order,
 * its parameters need one. Returns whether anything moved. */
int ff_lobes_order(const ff_model *m, size_t n_channels, double *shape, double *channel);

/* ---- start and solve ------------------------------------------------------------------------- */

/* A candidate for the optimum. */
typedef struct ff_candidate {
    double cost2;
    double shape[FF_MAX_SHAPE];
} ff_candidate;

/* Bounded least squares: q in [lo, hi] minimising |r + L q|^2 from the packed gram of [L r], n <= FF_MAX_CHANNEL_PARAMS columns.
 * Returns the minimum. */
double ff_bounded_least_squares(const double *gram, size_t n, const double *lo, const double *hi, double *q);

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
} ff_solution;

/* Minimises from shape, channel (in and out) until a step would lower the objective by less than `tolerance` of itself.
 * speculate: passes that look like being the last are made final ones. at_bound [P]: -1, 0, +1 in coordinates. */
ff_status ff_solve(const ff_layout *l, const struct ff_problem *p, const ff_fit_options *o, int parallel, int speculate,
                   double tolerance, int max_iterations, double *shape, double *channel, int *at_bound, ff_solution *out,
                   ff_error *err);

/* ---- result ---------------------------------------------------------------------------------- */

/* Everything that is said of an optimum whose final pass is solution->normal; shape_value and channel_value are allocated. */
ff_status ff_result_fill(const ff_layout *l, const struct ff_problem *p, const ff_fit_options *o, const double *shape,
                         const double *channel, const int *at_bound, const ff_solution *solution, ff_fit_result *r);

/* ---- covariance ------------------------------------------------------------------------------ */

/* Full J^T J [P][P] and J^T r [P] from the channels' grams. slope [P]: d parameter / d coordinate, or NULL for the parameters
 * themselves. */
void ff_normal_assemble(const ff_layout *l, const ff_normal *n, const double *slope, double *H, double *g);

/* Cholesky factor of a symmetric positive semidefinite A [n][n] after scaling its diagonal to 1: A = D L L^T D, L [n][n] lower, D
 * [n]. A pivot at or below `tolerance` leaves a zero column: that parameter is a combination of the ones before it. Returns the
 * rank. */
size_t ff_scaled_cholesky(const double *A, size_t n, double tolerance, double *L, double *D);

/* Covariance [P][P] of the parameters (not coordinates) whose `use` is not 0, zero elsewhere; determined [P]: 0 where the data say
 * nothing. sandwich: heteroscedasticity-consistent with samples as clusters (HC1, MacKinnon and White 1985; clusters as in Liang
 * and Zeger 1986), else H^-1. n_samples clusters of n_channels residuals. FF_ERR_MEMORY. */
ff_status ff_covariance(const ff_layout *l, const ff_normal *n, const int *use, int sandwich, size_t n_samples, double *cov,
                        int *determined);

#endif
