/* Which parameters are free in which coordinates, what the caller's constraints make of them, and sums over the samples in these
 * coordinates. */
#ifndef FF_INTERNAL_LAYOUT_H
#define FF_INTERNAL_LAYOUT_H
#include "fit/pass/internal_pass.h"
#include "fit/warning/internal_warning.h"

/* ---- the layout ------------------------------------------------------------------------------- */

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
    const struct ff_limits *limits;             /* where channels differ in their bounds or held values, NULL = nowhere          */
    int arrowhead; /* 1: many channels: nothing of size P^2 is made                                                  */
    size_t pinned; /* coordinate that ff_solve leaves where it is; FF_NOT_PINNED */
} ff_layout;

/* Bounds and initial values of the channel parameters of a model, [n_channels][n_channel] each. Where lo = hi, the parameter is
 * held there in that channel. */
typedef struct ff_limits {
    double *lo, *hi, *init;
} ff_limits;

static inline double ff_layout_lo(const ff_layout *l, size_t c, uint32_t k)
{
    return l->limits ? l->limits->lo[c * l->m->n_channel + k] : l->m->channel[k].lo;
}

static inline double ff_layout_hi(const ff_layout *l, size_t c, uint32_t k)
{
    return l->limits ? l->limits->hi[c * l->m->n_channel + k] : l->m->channel[k].hi;
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

/* Is it one of so many channels that nothing of the size of all their parameters squared should be made? */
static inline int ff_layout_is_arrowhead(const ff_layout *l, size_t dense)
{
    return l->n_channels > dense && l->n_own > 0;
}

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

/* What c says of single channels of a problem, for a model that ff_constraints_apply has changed; *out = NULL when that is nothing.
 * FF_ERR_UNKNOWN for a channel that is none, FF_ERR_RANGE for another number of values than channels, FF_ERR_UNSUPPORTED for a
 * parameter that is tied, FF_ERR_MEMORY. Release it with ff_limits_free. */
ff_status ff_limits_of(const ff_constraints *c, const struct ff_problem *p, const ff_model *m, const ff_ties *ties, ff_limits **out,
                       ff_error *err);
/* Those of a model alone; NULL without memory. And those of parameter from_k of from_n to parameter k of n, in all channels. */
ff_limits *ff_limits_new(const ff_model *m, size_t n_channels);
void ff_limits_copy(const ff_limits *from, size_t from_n, size_t from_k, size_t n_channels, ff_limits *to, size_t n, size_t k);
void ff_limits_free(ff_limits *limits);
/* Index of the channel that is named beside parameter `name`; -1 where the problem is another channel of the same table.
 * FF_ERR_UNKNOWN for one that the table lacks, FF_ERR_UNSUPPORTED where its channels are averaged. */
ff_status ff_channel_find(const struct ff_problem *p, const char *name, const char *channel, int *out, ff_error *err);

/* Ties of l's model: before anything is made of l's coordinates. */
void ff_layout_tie(ff_layout *l, const ff_ties *ties);

/* What a name of the constraints stands for: one or two parameters, "alpha" for both axes, which an isotropic shape has one of. The
 * count; 0 when m has none of that name. */
int ff_constraints_named(const ff_model *m, ff_shape shape, const char *name, ff_param_ref at[2]);

/* Moves free parameters into their bounds and tied ones to what they follow; channel may be NULL. */
void ff_layout_project(const ff_layout *l, double *shape, double *channel);

/* Makes a shape of a search one of the layout: what is held at its value, what is free in its bounds and tied. */
void ff_layout_candidate(const ff_layout *l, double *shape);

/* What FF_SHAPE_AUTO stands for; others as they are. */
ff_shape ff_layout_shape(const ff_model *m, int isotropic_table, ff_shape asked, int mean_slope);

/* The mode of the model's stretched lobes for a shape. */
ff_stretch_mode ff_layout_mode(const ff_model *m, ff_shape shape, int mean_slope);

/* Bounds of the parameter of coordinate k < P; is it held there, the two being one? */
void ff_layout_range(const ff_layout *l, size_t k, double *lo, double *hi);
int ff_layout_is_fixed(const ff_layout *l, size_t k);

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

/* Initial values as ff_model_defaults (channel may be NULL), with one roughness for both axes of an isotropic shape and tied
 * parameters equal. */
void ff_layout_defaults(const ff_layout *l, double *shape, double *channel);
/* Those of the channels alone, before ties. */
void ff_layout_channel_defaults(const ff_layout *l, double *channel);

/* Bounds of all coordinates, [P] each. */
void ff_layout_bounds(const ff_layout *l, double *lower, double *upper);

/* Room for a pass over the columns of l. FF_ERR_MEMORY. */
ff_status ff_layout_normal(const ff_layout *l, ff_normal *out);

/* J^T J, J^T r and r^T r of every channel in coordinates, penalties on top: an arrowhead, since a parameter of one channel meets
 * what all share and its own channel, no other one. A channel has its shared coordinates first, [S], then its own, [K], then the
 * residual. */
typedef struct ff_gram {
    size_t S, K, C, tri; /* shared, own, channels; doubles of a channel's packed triangle */
    double cost2;        /* twice the objective                                           */
    double *local;       /* [C][tri]                                                      */
} ff_gram;

/* FF_ERR_MEMORY; release with ff_gram_free. */
ff_status ff_gram_new(const ff_layout *l, ff_gram *out);
void ff_gram_free(ff_gram *g);

/* The coordinate that is number i of channel c. */
static inline size_t ff_gram_coordinate(const ff_gram *g, size_t c, size_t i)
{
    return i < g->S ? i : i + c * g->K;
}

/* From the sums of a pass; slope [P]: d parameter / d coordinate, or NULL for the parameters themselves. */
void ff_gram_fill(const ff_layout *l, const ff_normal *n, const double *slope, ff_gram *out);

/* As a whole: H = J^T J [P][P], gradient = J^T r [P]; and that alone. */
void ff_gram_dense(const ff_gram *g, double *H, double *gradient);
void ff_gram_gradient(const ff_gram *g, double *gradient);

/* One more datum of channel c: weight residual^2 with the derivatives row [S + K]. */
void ff_gram_add_row(ff_gram *g, size_t c, double weight, double residual, const double *row);

/* Adds up the columns of one coordinate in what a final pass left for the errors (score_products, own, runs): n->P is then l->P,
 * and no pass may be run into n again. FF_ERR_MEMORY. */
ff_status ff_normal_fold(const ff_layout *l, ff_normal *n);

/* ---- by the places of results and warnings ------------------------------------------------------ */

/* Parameter k < P as a warning of several names it: with its channel where it is one of several channels' own. */
ff_warning_parameter ff_layout_warned(const ff_layout *l, size_t k);

/* A warning of parameter k < P alone; value [those the code has]. FF_ERR_MEMORY. */
ff_status ff_layout_warn(const ff_layout *l, size_t k, ff_warning_code code, const double *value, ff_warnings *out);

/* ---- results by coordinate -------------------------------------------------------------------- */

/* Of parameter k < P: its place in a result. */
ff_fit_value *ff_result_value(const ff_layout *l, ff_fit_result *r, size_t k);
/* Is p one of m's parameters that every channel has? */
int ff_is_of_channel(const ff_model *m, const ff_model_param *p);
#endif
