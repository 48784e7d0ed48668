/* Integrals over the half vectors of one view: what the directional albedo, its derivatives and the weak white furnace share. The
 * method and the notation are at the head of albedo_integral.c. */
#ifndef FF_INTERNAL_INTEGRAL_H
#define FF_INTERNAL_INTEGRAL_H
#include "ff_albedo.h"
#include "internal_albedo.h"
#include "models/internal_model.h"

enum {
    FF_INTEGRAL_GROUP = 4, /* colour channels evaluated at once                                    */
    FF_INTEGRAL_CUTS = 24  /* places on a ray at which panels of x end                             */
};

typedef struct ff_vec2 {
    double x, y;
} ff_vec2;

static inline double ff_dot2(ff_vec2 a, ff_vec2 b)
{
    return a.x * b.x + a.y * b.y;
}

typedef enum ff_integral_kind { FF_INTEGRAL_LOBES, FF_INTEGRAL_BASES, FF_INTEGRAL_FURNACE } ff_integral_kind;

typedef struct ff_integrand {
    ff_integral_kind kind;
    const ff_prepared *p;
    ff_prepared lobes; /* FF_INTEGRAL_BASES: p without its bases */
    size_t n_channels;
    double o[3];          /* view                                               */
    double l11, l21, l22; /* L                                                  */
    double det;           /* det(L)                                             */
    double width;         /* w                                                  */
    ff_vec2 s0, oxy;
    double v0;  /* V at q = 0, the projected view cosine ozp                */
    int own_g1; /* furnace: V-cavity's G1 instead of the constant g1        */
    double g1;
    double far, p_far, nu; /* furnace: P = p_far (q / far)^-nu beyond far   */
    /* points that wait for their evaluation: directions, weights */
    size_t n;
    double plane[6][FF_BLOCK], w[FF_BLOCK];
    double sum[FF_INTEGRAL_GROUP];
    ff_block_work *work; /* borrowed */
    size_t n_columns;    /* of p->wanted: derivatives that are summed too */
    double column_sum[FF_INTEGRAL_GROUP][FF_ALBEDO_COLUMNS];
} ff_integrand;

/* One lobe, taken out of a larger model, with its parameters; FF_INTEGRAL_GROUP channels at most. */
typedef struct ff_albedo_part {
    ff_model model;
    double shape[FF_MAX_SHAPE], channel[FF_INTEGRAL_GROUP * FF_MAX_CHANNEL_PARAMS];
    size_t n_channels;
    ff_prepared prepared; /* for all directions */
} ff_albedo_part;

/* ---- albedo_integral.c ----------------------------------------------------------------------- */

/* Makes an integral of p (its first lobe, or its bases) ready for the unit vector wo; p and work must
 * outlive it. Its own_g1 and g1 are those of a Smith form that masks nothing. */
void ff_integrand_make(ff_integral_kind kind, const ff_prepared *p, const double wo[3], ff_block_work *work, ff_integrand *k);

/* Adds everything up with one Gauss-Legendre order: k->sum and, where p has columns, k->column_sum. */
void ff_integrand_sum(ff_integrand *k, int order);

/* Doubles the order until two agree; out [k->n_channels]. */
void ff_integrand_integrate(ff_integrand *k, ff_integral out[FF_INTEGRAL_GROUP]);

/* Before a furnace integral: k->far, p_far and nu of P = D hz^4 far out, where it is a power law q^-nu or has vanished. It is the
 * same along every ray. */
void ff_integrand_tail(ff_integrand *k);

/* ---- albedo_cuts.c --------------------------------------------------------------------------- */

/* Places on a ray at which the integrand is not smooth. */
typedef struct ff_cuts {
    int n;
    double q[FF_INTEGRAL_CUTS];
} ff_cuts;

/* Real roots of a2 q^2 + a1 q + a0, ascending, without cancellation; the count. */
int ff_quadratic_roots(double a0, double a1, double a2, double root[2]);

/* Adds those inside (lo, hi) of the ray e; and brings all into ascending order. */
void ff_cuts_branches(const ff_integrand *k, ff_vec2 e, double lo, double hi, ff_cuts *c);
void ff_cuts_sort(ff_cuts *c);
#endif
