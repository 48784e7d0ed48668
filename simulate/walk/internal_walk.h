/* Paths on Smith's surface: what a walk keeps, and the kernel that runs a number of them. Compiled code of the kernel exists once
 * per instruction set; see base/internal_isa.h. */
#ifndef FF_INTERNAL_WALK_H
#define FF_INTERNAL_WALK_H
#include "ff_walk.h"
#include "models/internal_model.h"

enum { FF_WALK_BINS = 1024, FF_WALK_MOST = 4096 }; /* MOST: facets of a path */
#define FF_WALK_T     24.                          /* the tables reach from t = -24 to 24 */
#define FF_WALK_LEAST 1e-9                         /* what a path must carry to go on     */

/* Radii q of the unit surface by the fraction u of a mass inside: ln q as a function of t = ln(u / (1 - u)), cubic between equal
 * steps of t. c[k][bin] are coefficients by rising power of the place in the bin. */
typedef struct ff_walk_radial {
    double c[4][FF_WALK_BINS];
} ff_walk_radial;

/* The masses 2 pi q p dq, and the same times q; *mean is that of q over pi: what the unit surface shows of itself to a ray along
 * it. FF_ERR_UNSUPPORTED when that has no end. */
ff_status ff_walk_radial_make(const ff_ndf *ndf, const ff_ndf_pass *pass, ff_walk_radial out[2], double *mean);

/* What does not change between paths. */
typedef struct ff_walk_setting {
    const ff_ndf *ndf;
    const ff_ndf_pass *pass;
    const ff_fresnel *fresnel;
    double l11, l21, l22; /* s = L u: slopes of the surface from those of the unit surface */
    double mean;
    ff_walk_radial radial[2];
    size_t n_channels;
    const double *channel; /* [n_channels][stride], that of the Fresnel term first */
    size_t stride;
    ff_facets facets;
    ff_walk_descent descent;
    const double *kd, *share; /* [n_channels]: of FF_FACETS_LAMBERT and COUPLED; share: 1 / (1 - Fa) */
    uint64_t seed, paths;
    size_t n_orders;
    ff_orders orders[FF_WALK_ORDERS];
    uint32_t last; /* the last order that counts, FF_WALK_MOST at most */
} ff_walk_setting;

/* Sums over the paths of one direction. */
enum {
    FF_WALK_W,
    FF_WALK_WW,
    FF_WALK_WR,
    FF_WALK_WWR = FF_WALK_WR + 3,
    FF_WALK_WWRR = FF_WALK_WWR + 3,
    FF_WALK_SUMS = FF_WALK_WWRR + 3
};

/* Some paths of some pairs, or of one direction. */
typedef struct ff_walk_item {
    size_t pair, n_pairs; /* the first one, and how many                                   */
    uint64_t path, n_paths;
    uint64_t number;    /* of pair 0                                                         */
    const ff_dirs *w;   /* wo planes NULL: of one direction                                  */
    double *sum, *sum2; /* of pairs: [n_orders][n_channels][n_pairs of the item], added to  */
    double *moments;    /* of one direction: [n_orders][n_channels][FF_WALK_SUMS], added to  */
    double *lost;       /* [n_channels], added to                                            */
    /* For tests: every path that leaves; of one direction only. */
    void (*leaves)(void *context, uint32_t order, const double r[3], const double *weight);
    void *context;
} ff_walk_item;

/* Paths on their way, as planes. */
typedef struct ff_walk_lanes {
    size_t n;
    double w[3][FF_BLOCK];  /* where the ray comes from: minus its direction  */
    double depth[FF_BLOCK]; /* ln C, <= 0                                    */
    double *weight;         /* [n_channels][FF_BLOCK]                        */
    double *sum;            /* [n_orders][n_channels][FF_BLOCK] of the path  */
    uint64_t id[FF_BLOCK];
    uint32_t step[FF_BLOCK], order[FF_BLOCK];
    size_t pair[FF_BLOCK];
    /* of a step */
    double u[4][FF_BLOCK], lx[FF_BLOCK], ly[FF_BLOCK], len[FF_BLOCK], up[FF_BLOCK], rate[FF_BLOCK], next[FF_BLOCK], q[FF_BLOCK];
    double sx[FF_BLOCK], sy[FF_BLOCK], met[FF_BLOCK], v[FF_BLOCK], lam[FF_BLOCK], dlam[FF_BLOCK];
    size_t bin[FF_BLOCK];
    /* of the facets that were met, one after the other */
    size_t n_met, lane[FF_BLOCK];
    double from[3][FF_BLOCK], h[3][FF_BLOCK], c[FF_BLOCK], F[FF_BLOCK], g[FF_BLOCK], to[3][FF_BLOCK];
    double q2[FF_BLOCK], p[FF_BLOCK], dlnp[FF_BLOCK], leave[FF_BLOCK], mirrored[FF_BLOCK], chance[FF_BLOCK];
    /* of the pairs of an item */
    double lambda_o[FF_BLOCK];
} ff_walk_lanes;

/* Room for the lanes of n_channels and n_orders; NULL when out of memory. Release with free. */
ff_walk_lanes *ff_walk_lanes_new(size_t n_channels, size_t n_orders);

/* Runs the paths of an item. At most FF_BLOCK pairs. */
typedef void ff_walk_kernel(const ff_walk_setting *s, const ff_walk_item *item, ff_walk_lanes *lanes);
ff_walk_kernel ff_walk_run_scalar;
#ifdef FF_HAVE_AVX2
ff_walk_kernel ff_walk_run_avx2, ff_walk_run_avx512;
#endif

struct ff_walk {
    ff_model model;
    double *channel;
    ff_prepared prepared;
    ff_walk_options o;
    ff_walk_setting setting;
    ff_walk_kernel *run;
    double *kd;
};
#endif
