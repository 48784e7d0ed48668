/* The descriptors of the terms: what a distribution, a masking, a Fresnel term and a diffuse term compute over a block of samples,
 * and the planes of geometry they read. Compiled code of this header exists once per instruction set; see base/internal_isa.h. */
#ifndef FF_INTERNAL_TERM_H
#define FF_INTERNAL_TERM_H
#include "profile_table_struct.h"
#include "ff_term.h"
#include "base/internal_isa.h"
#include <stddef.h>

/* Samples of a block. All planes of a pass over a block stay in the first-level cache. */
enum { FF_BLOCK = 128 };

/* ---- a distribution: one 1D profile p(q2) and one 1D Lambda(a) ------------------------------- */

enum { FF_MAX_OWN = 3 }; /* parameters of a distribution beyond the stretch: gamma, kappa, ... */

/* Constants of a distribution for one set of its own parameters; filled by prepare, read by the kernels. */
typedef struct ff_ndf_pass {
    double own[FF_MAX_OWN]; /* the parameters beyond the stretch                                */
    double v_lo, v_hi;      /* lambda will be asked for these v and for FF_V_MIN, nothing else; not at all when v_lo > v_hi */
    const ff_profile_table *values; /* of `tabulated`, else NULL                                        */
    double c[16];                   /* whatever the model wants to keep                                 */
    double *table;                  /* [ff_ndf.table_size] of the pass's own, NULL when that is 0       */
} ff_ndf_pass;

/* How the parameters of a distribution stretch its 1D profile. One that is not shape-invariant leaves ax = ay = 1, so that q2 is
 * tan^2 of the normal's angle and v that of the direction's, and has its width among its own parameters. */
typedef struct ff_stretch {
    double ax, ay, r, x0, y0, own[FF_MAX_OWN];
} ff_stretch;

/* Order of the derivatives inside the kernels: those of ff_stretch that the mode has, the own parameters, that of the masking. */
enum {
    FF_D_AX = 0,
    FF_D_AY = 1,
    FF_D_R = 2,
    FF_D_X0 = 3,
    FF_D_Y0 = 4,
    FF_D_OWN = 5,
    FF_D_MASKING = FF_D_OWN + FF_MAX_OWN,
    FF_D_COUNT
};

typedef struct ff_ndf {
    ff_term term;
    /* Parameters [term.n_params] -> stretch. NULL: alpha_x, alpha_y, r_xy, slope_x, slope_y, then the own ones.
     * jac [n_params][FF_D_COUNT] = d stretch / d parameter, zeroed by the caller; may be NULL. */
    void (*stretch)(const double *params, ff_stretch *s, double jac[][FF_D_COUNT]);
    int n_own;         /* how many of ff_stretch.own count                                          */
    int alpha_own;     /* where its roughness is: 0 ax, k > 0 own[k - 1], -1 nowhere                */
    int needs_values;  /* 1: takes its profile from ff_ndf_pass.values                              */
    size_t table_size; /* doubles that prepare and the kernels want in ff_ndf_pass.table            */
    void (*prepare)(ff_ndf_pass *pass);
    /* The kernels see at most FF_BLOCK samples a call; dlnp_own and dlam_own are NULL or n_own planes, none of them NULL.
     * p(q2) and d ln p / d q2, d ln p / d own. q2 in [0, 1e300]. */
    void (*profile)(const ff_ndf_pass *pass, size_t n, const double *restrict q2, double *restrict p, double *restrict dlnp,
                    double *const *dlnp_own);
    /* Smith's Lambda of v = 1/a^2 = (alpha_o tan theta_o)^2 in [FF_V_MIN, 1e60], with d Lambda / d v and d Lambda / d own. NULL:
     * the density is none of normals over a unit area, and Smith's masking has no meaning for it. */
    void (*lambda)(const ff_ndf_pass *pass, size_t n, const double *restrict v, double *restrict lam, double *restrict dlam,
                   double *const *dlam_own);
} ff_ndf;
#define FF_V_MIN 1e-60 /* stands for normal incidence, where a is infinite */

/* The parameters of a stretched distribution, for its term: alpha_x, alpha_y, r_xy, slope_x, slope_y. */
enum { FF_STRETCH_COUNT = 5 };
#define FF_STRETCH_PARAMS                                                                                                          \
    {"alpha_x", "1", "roughness along the tangent, alpha_x", 1e-4, 4, 0.3, FF_PARAM_LOG, 0},                                       \
        {"alpha_y", "1", "roughness across the tangent, alpha_y", 1e-4, 4, 0.3, FF_PARAM_LOG, 0},                                  \
        {"r_xy", "1", "correlation of the slopes, r_xy", -0.999, 0.999, 0, FF_PARAM_ATANH, 0},                                     \
        {"slope_x",     "1", "mean slope of the surface along x; where it is not 0 the model is not reciprocal", -1, 1, 0,         \
         FF_PARAM_HELD, 0},                                                                                                        \
    {                                                                                                                              \
        "slope_y", "1", "mean slope of the surface along y; where it is not 0 the model is not reciprocal", -1, 1, 0,              \
            FF_PARAM_HELD, 0                                                                                                       \
    }

/* ---- geometry: what no parameter changes ----------------------------------------------------- */

enum {
    FF_G_S2 = 0, /* |s|^2, s the slope of h                                                 */
    FF_G_TI2,    /* tan^2 theta_i                                                           */
    FF_G_TO2,
    FF_G_SX, /* slope of h                                                              */
    FF_G_SY,
    FF_G_TIX, /* wi.x / wi.z                                                             */
    FF_G_TIY,
    FF_G_TOX,
    FF_G_TOY,
    FF_G_K,       /* 1 / (4 iz oz hz^4); 0 marks a pair at or below the horizon              */
    FF_G_C,       /* wi.h                                                                    */
    FF_G_COS_I,   /* wi.z; 1 at or below the horizon                                         */
    FF_G_COS_O,   /* wo.z; 1 at or below the horizon                                         */
    FF_G_VCAVITY, /* G2 of the V-cavity                                                      */
    FF_G_PHI,     /* azimuth difference in [0, pi]; 0 where one direction is the normal      */
    FF_G_COUNT
};

/* Planes of a block; those that nobody needs are NULL. */
typedef struct ff_geometry {
    double *plane[FF_G_COUNT];
} ff_geometry;

/* ---- masking, Fresnel, diffuse --------------------------------------------------------------- */

typedef struct ff_masking {
    ff_term term;     /* at most one parameter                                                        */
    int uses_lambda;  /* 0: li, lo are not read and gi, go are not written                            */
    int uses_alpha;   /* 1: reads the roughness of the lobe, which is isotropic then                  */
    uint32_t planes;  /* extra geometry planes, 1u << FF_G_...                                        */
    const char *only; /* the one distribution it is made for, NULL = any                              */
    /* G and d ln G / d Lambda_i, d ln G / d Lambda_o. x is the lobe's alpha (uses_alpha) or the masking's own parameter, gx = d ln
     * G / d x, NULL when it is not wanted; neither is touched when the masking has none. */
    void (*eval)(double x, const ff_geometry *g, size_t n, const double *restrict li, const double *restrict lo, double *restrict G,
                 double *restrict gi, double *restrict go, double *restrict gx);
} ff_masking;

/* A Fresnel term F(c), c = wi.h. All its parameters are per channel. */
typedef struct ff_fresnel {
    ff_term term;
    uint32_t planes;
    /* Value and derivatives by the term's parameters, d[k] planes; d may be NULL. */
    void (*eval)(const double *params, const ff_geometry *g, size_t n, double *restrict f, double *const *d);
    /* Parameters whose F is like that of Schlick with this F0: where a fit starts; those that are held stay. NULL where they are
     * solved for (linear). */
    void (*like_schlick)(double f0, double *params);
} ff_fresnel;

/* What a diffuse term may read of the lobes below it. */
enum {
    FF_COUPLE_ALPHA = 1u << 0,   /* roughness of the first lobe                                                   */
    FF_COUPLE_F0 = 1u << 1,      /* F of the first lobe at normal incidence                                       */
    FF_COUPLE_ALBEDO = 1u << 2,  /* directional albedo of all lobes                                               */
    FF_COUPLE_LOSS = 1u << 3,    /* for each lobe by itself: its albedo with F = 1 and the average of its Fresnel  */
    FF_COUPLE_FRESNEL = 1u << 4, /* ks F of the first lobe at the half vector                                     */
    FF_COUPLE_LOBE = 1u << 5     /* with LOSS: the value of that lobe, and its F at normal incidence in place of the first one's */
};

/* Of these the lobes must be isotropic; with these the model is not affine in the channel parameters. */
enum {
    FF_COUPLES_ISOTROPIC = FF_COUPLE_ALPHA | FF_COUPLE_ALBEDO | FF_COUPLE_LOSS,
    FF_COUPLES_CURVED = FF_COUPLE_F0 | FF_COUPLE_ALBEDO | FF_COUPLE_LOSS | FF_COUPLE_FRESNEL | FF_COUPLE_LOBE
};

/* Inputs of a diffuse term for one channel: its own parameters in their order, then one value for each coupling of the lobes. */
typedef struct ff_diffuse_input {
    double params[8];      /* shared and per-channel ones, in the order of term.params                       */
    double alpha, f0;      /* FF_COUPLE_ALPHA, FF_COUPLE_F0                                                  */
    const double *ai, *ao; /* [n] directional albedos of wi and wo: FF_COUPLE_ALBEDO, FF_COUPLE_LOSS          */
    double mean;           /* their cosine-weighted mean over the hemisphere                                 */
    double f_average;      /* FF_COUPLE_LOSS: 2 integral F(mu) mu dmu                                        */
    const double *fresnel; /* [n] FF_COUPLE_FRESNEL: ks F of the first lobe                                  */
    const double *lobe;    /* [n] FF_COUPLE_LOBE: ks F D G / (4 iz oz) of the lobe                           */
    const ff_ndf *ndf;     /* of the lobe, or of the first one; NULL without lobes                           */
} ff_diffuse_input;

/* Derivatives of a diffuse term: by its own parameters, then these. */
enum { FF_DD_ALPHA = 8, FF_DD_F0, FF_DD_AI, FF_DD_AO, FF_DD_MEAN, FF_DD_F_AVERAGE, FF_DD_FRESNEL, FF_DD_LOBE, FF_DD_COUNT };

typedef struct ff_diffuse {
    ff_term term;
    uint32_t planes;
    uint32_t couples;        /* FF_COUPLE_... */
    const char *const *only; /* distributions that it is made for, NULL after the last: of one lobe, whose masking is
                                smith-height-correlated. NULL: any */
    /* f in 1/sr (the caller zeroes what is below the horizon) and d f / d input, d[FF_DD_COUNT] planes, each or d itself NULL
     * where it is not wanted. */
    void (*eval)(const ff_diffuse_input *in, const ff_geometry *g, size_t n, double *restrict f, double *const *d);
    /* Of a term with a peak in the mirror direction, else NULL: the curve (1 + (d / width)^2)^-power of the difference d of
     * direction cosines that f is like, up to a factor between bounds. params are the shared ones, in their places. Samples and
     * the panels of integrals follow it. */
    void (*peak)(const double *params, double *width, double *power);
} ff_diffuse;

#endif
