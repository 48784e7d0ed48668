/* A distribution of normals without a formula: the curve it is, sums over the samples, and the minimisation.
 *
 * The curve is psi = ln D as a cubic spline of y = asinh(tan theta / scale), nodes 0 .. top at y = k step. It is even, so that D is
 * smooth at the normal, and its last coefficients go on in a straight line: D becomes a power of tan theta, up to FF_NDF_END, where
 * it is level. D does not rise when the coefficients do not. The slopes' density is P22 = e^psi / ((1 + q^2)^2 A), q = tan theta,
 * with the area A that makes integral D cos = 1. */
#ifndef FF_INTERNAL_NDF_H
#define FF_INTERNAL_NDF_H
#include "ndf_struct.h"
#include "fit/problem/internal_problem.h"

/* ---- the curve ------------------------------------------------------------------------------- */

enum { FF_NDF_LEAST_TOP = 30, FF_NDF_MOST_TOP = 99 };
#define FF_NDF_END 1.5620696805349925 /* 89.5 degrees */

/* Four neighbouring nodes and what they weigh at a place between them. */
typedef struct ff_stencil {
    int first;
    double w[4];
} ff_stencil;

/* Cubic B-splines at u steps of the lattice. Below 0 the curve is its mirror image, beyond the last node the coefficients go on in
 * a straight line. u at most ff_curve.end. */
static inline ff_stencil ff_curve_stencil_at(int top, double u)
{
    const int k = u < top ? (int)u : top - 1;
    const double x = u - k, y = 1 - x, past = u - top;
    const double b0 = y * y * y * (1. / 6), b1 = 2. / 3 - x * x * (1 - 0.5 * x), b2 = 2. / 3 - y * y * (1 - 0.5 * y),
                 b3 = x * x * x * (1. / 6);
    ff_stencil s = {k - 1, {b0, b1, b2, b3}};
    if (k == 0) s = (ff_stencil){0, {b1, b0 + b2, b3, 0}};
    if (k == top - 1) s = (ff_stencil){top - 3, {0, b0, b1 - b3, b2 + 2 * b3}};
    if (u >= top) s = (ff_stencil){top - 3, {0, 0, -past, 1 + past}};
    return s;
}

/* Lattices of a retrieval: nodes of the curve, slopes of its quadratures, directions at which Lambda is integrated. Between those
 * Lambda is a cubic of z = asinh(tan theta). */
typedef struct ff_curve {
    int top;
    double scale, step, end; /* end: FF_NDF_END in steps                                               */
    size_t n_slopes;
    double *slope;                  /* [n_slopes] even in ln q                                                    */
    double *measure;                /* [n_slopes] A = sum of measure e^psi                                        */
    ff_stencil *stencil;            /* [n_slopes] of the curve                                                    */
    int n_lambda;                   /* 0 where the masking uses none                                              */
    double lambda_step, lambda_tan; /* of its lattice, and tan theta at the last node                     */
    double *kernel;                 /* [n_lambda][n_slopes] Lambda = sum of kernel e^psi / A                      */
} ff_curve;

/* lambda: 1 when the masking wants it, for directions up to tan_max. FF_ERR_MEMORY. */
ff_status ff_curve_new(double scale, double step, int top, int lambda, double tan_max, ff_curve *out);
void ff_curve_free(ff_curve *curve);

double ff_curve_node(const ff_curve *curve, int k);           /* tan theta of a node */
ff_stencil ff_curve_stencil(const ff_curve *curve, double q); /* at tan theta = q    */
static inline double ff_stencil_apply(const ff_stencil *s, const double *c)
{
    return s->w[0] * c[s->first] + s->w[1] * c[s->first + 1] + s->w[2] * c[s->first + 2] + s->w[3] * c[s->first + 3];
}
/* Coefficients [top + 1] of the curve through the values at the nodes. */
void ff_curve_interpolate(const ff_curve *curve, const double *value, double *c);

/* What follows from coefficients c. */
typedef struct ff_curve_state {
    double *c;        /* [top + 1]                                            */
    double area;      /* A                                                    */
    double *d_area;   /* [top + 1] d ln A / d c                               */
    double *lambda;   /* [n_lambda]                                           */
    double *d_lambda; /* [n_lambda][top + 1]                                  */
    double *exp_psi;  /* [n_slopes]                                           */
} ff_curve_state;
ff_status ff_curve_state_new(const ff_curve *curve, ff_curve_state *out);
void ff_curve_state_free(ff_curve_state *state);
void ff_curve_evaluate(const ff_curve *curve, ff_curve_state *state);

/* ln D at tan theta = q, the area being 1. */
double ff_curve_ln_d(const ff_curve *curve, const ff_curve_state *state, double q);

/* ---- sums over the samples ------------------------------------------------------------------- */

/* A sample's derivatives by the coefficients are few numbers: its stencil in the curve, and those of its directions in the table of
 * Lambda, whose entries depend on all coefficients in the same way for every sample. So the outer products are summed in these
 * `raw` columns: top + 1 coefficients, n_lambda values of Lambda; then two for each channel: what multiplies the lobe, and kd. The
 * area needs no column, since the weights of a stencil have the sum 1. */
typedef struct ff_ndf_sums {
    size_t n_curve, n_raw, n_channels, n; /* n = n_raw + 2 n_channels */
    double cost2;
    double *gradient;                    /* [n] J^T r                                                     */
    double *gram;                        /* [n][n] J^T J                                                  */
    double *score_products;              /* [n][n] sum over samples of (J^T r)(J^T r)^T, where asked for  */
    double *gram_cross, *products_cross; /* [n_raw][n] while they are being summed            */
} ff_ndf_sums;

/* The point at which a pass is made. */
typedef struct ff_ndf_place {
    const struct ff_problem *p;
    const ff_curve *curve;
    const ff_curve_state *state;
    int masking;
    double masking_own;
    int scaled;                   /* 0: F = a + (1 - a) (1 - c)^5; 1: F = a, a scale without Fresnel's rise   */
    const double *channel;        /* [n_channels][2] a, kd                                                    */
    const struct ff_noise *noise; /* NULL, or: residuals are one standard deviation each, all of one sign    */
} ff_ndf_place;

/* Of one channel over a block: the scores J r of its columns a and kd, and their products with what multiplies the lobe's. */
typedef struct ff_ndf_channel_planes {
    double a_score[FF_BLOCK], kd_score[FF_BLOCK], a_lobe[FF_BLOCK], kd_lobe[FF_BLOCK];
} ff_ndf_channel_planes;

ff_status ff_ndf_sums_new(const ff_curve *curve, size_t n_channels, ff_ndf_sums *out);
void ff_ndf_sums_free(ff_ndf_sums *s);
/* with_products: also score_products. FF_ERR_MEMORY; FF_ERR_INTERNAL when a sum is not finite. */
ff_status ff_ndf_sum(const ff_ndf_place *at, int with_products, ff_ndf_sums *out);

/* ---- minimisation ---------------------------------------------------------------------------- */

/* A curve, what multiplies its lobe, and kd, as a point of the penalised least squares; see ndf_solve.c. Parameters: the falls
 * c[k] - c[k+1] >= 0 of the coefficients for k = 0 .. top - 1, then a and kd of each channel. */
typedef struct ff_ndf_fit {
    const ff_curve *curve;
    const ff_fit_options *o;
    int masking, scaled; /* as in ff_ndf_place */
    double masking_own;
    size_t n_channels, P;
    double *u, *lower, *upper; /* [P] where it is, and its box                                             */
    double *reference;         /* [top] falls of the curve that the penalty draws to                       */
    double *variance;          /* [top] of the residuals near each node, as the penalty takes them         */
    double smooth;             /* weight of the penalty                                                    */
    ff_curve_state state;      /* at the last pass                                                         */
    ff_ndf_sums sums;
    double *X;     /* [2][n][P] d raw column / d parameter, and work                               */
    double *H, *g; /* [P][P], [P] of the samples and the penalty                                   */
    double *A, *L, *D, *step, *trial, *work;
    int *held; /* [P] 1: on its bound, and pressed against it */
    size_t *index;
    int passes, iterations;
} ff_ndf_fit;

ff_status ff_ndf_fit_new(const ff_curve *curve, const ff_fit_options *o, int masking, double masking_own, int scaled,
                         size_t n_channels, ff_ndf_fit *out);
void ff_ndf_fit_free(ff_ndf_fit *f);
/* Minimises from f->u until a step would lower the objective by less than `tolerance` of itself. FF_ERR_CANCELLED,
 * FF_ERR_MEMORY. */
ff_status ff_ndf_solve(ff_ndf_fit *f, const struct ff_problem *p, double tolerance, int max_iterations, ff_outcome *outcome);
/* A pass at f->u, with score_products; H and held follow it. */
ff_status ff_ndf_look(ff_ndf_fit *f, const struct ff_problem *p);
/* After ff_ndf_look: the variances of the residuals near each node, at least `least`. */
void ff_ndf_variances(ff_ndf_fit *f, double least);
/* After ff_ndf_look: the cost2 that samples left out one at a time would have had. */
double ff_ndf_left_out(ff_ndf_fit *f);
/* After ff_ndf_look: trace of (H + penalty)^-1 H, the parameters that the samples determine. */
double ff_ndf_effective(ff_ndf_fit *f);
/* After ff_ndf_look: the covariance [P][P] of u, by score_products. */
ff_status ff_ndf_covariance(ff_ndf_fit *f, double *cov);
/* score_products of the noise instead of the residuals, which tell little where a few samples carry a node. FF_ERR_CANCELLED,
 * FF_ERR_MEMORY. */
ff_status ff_ndf_take_noise(ff_ndf_fit *f, const struct ff_problem *p, const struct ff_noise *noise);
/* Twice the penalty at f->u. */
double ff_ndf_penalty2(const ff_ndf_fit *f);

/* ---- starts ---------------------------------------------------------------------------------- */

/* Falls [top] of the curve through ln D [top + 1] at the nodes. */
void ff_ndf_falls(const ff_curve *curve, const double *ln_d, double *falls);
/* Falls [top] by the power iteration, kd [n_channels] taken off before; fills the back_... of out.
 * from_back_scatter is 0 when the data have too few samples that look back: falls are not written then. FF_ERR_MEMORY. */
ff_status ff_ndf_back_scatter(const struct ff_problem *p, const ff_curve *curve, const double *kd, double *falls,
                              ff_ndf_result *out);

/* ---- result ---------------------------------------------------------------------------------- */

/* The rows of the curve as ff_ndf_look has looked at it, without errors. */
ff_status ff_ndf_rows(const ff_ndf_fit *f, ff_ndf_result *out);
/* What follows from an optimum that ff_ndf_look has looked at; out has its rows, fits, first, reach and outcome already. */
ff_status ff_ndf_result_fill(ff_ndf_fit *f, const struct ff_problem *p, ff_ndf_monotone monotone, ff_ndf_result *out);

#endif
