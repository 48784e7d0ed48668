/* What the rooms share below the public headers: one distribution's kernels, the geometry planes, and a pass of one lobe over a
 * block of samples. Compiled code of this header exists once per instruction set; see isa.c for the choice. */
#ifndef FF_INTERNAL_KERNEL_H
#define FF_INTERNAL_KERNEL_H
#include "internal_isa.h"

/* Samples of a block. All planes of a pass over a block stay in the first-level cache. */
enum { FF_BLOCK = 128 };

/* ---- a distribution: one 1D profile p(q2) and one 1D Lambda(a) ------------------------------- */

enum { FF_POLY = 44 };

/* Constants of a distribution for one set of its own parameters; filled by prepare, read by the kernels. */
typedef struct ff_ndf_pass {
    double own;              /* gamma, ... : the parameter beyond the stretch   */
    double c[8];             /* whatever the model wants to keep                */
    double poly[2][FF_POLY]; /* polynomial coefficients by rising power        */
} ff_ndf_pass;

/* How the parameters of a distribution stretch its 1D profile. */
typedef struct ff_stretch {
    double ax, ay, r, x0, y0, own;
} ff_stretch;

/* Order of the derivatives inside the kernels: first those of ff_stretch that the mode has, then `own`. */
enum { FF_D_AX = 0, FF_D_AY = 1, FF_D_R = 2, FF_D_X0 = 3, FF_D_Y0 = 4, FF_D_OWN = 5, FF_D_COUNT = 6 };

typedef struct ff_ndf {
    ff_term term;
    /* Parameters [term.n_params] -> stretch. NULL: alpha_x, alpha_y, r_xy, slope_x, slope_y and, where there is a sixth, own.
     * jac [n_params][FF_D_COUNT] = d stretch / d parameter. */
    void (*stretch)(const double *params, ff_stretch *s, double jac[][FF_D_COUNT]);
    /* 1 when the distribution has a parameter `own`, so that the kernels' own derivatives exist. */
    int has_own;
    void (*prepare)(ff_ndf_pass *pass);
    /* The kernels see at most FF_BLOCK samples a call. */
    /* p(q2) and d ln p / d q2, d ln p / d own (dlnp_own may be NULL). q2 in [0, 1e300]. */
    void (*profile)(const ff_ndf_pass *pass, size_t n, const double *restrict q2, double *restrict p, double *restrict dlnp,
                    double *restrict dlnp_own);
    /* Smith's Lambda of v = 1/a^2 = (alpha_o tan theta_o)^2 in [FF_V_MIN, 1e60], with d Lambda / d v and d Lambda / d own (may be
     * NULL). */
    void (*lambda)(const ff_ndf_pass *pass, size_t n, const double *restrict v, double *restrict lam, double *restrict dlam,
                   double *restrict dlam_own);
} ff_ndf;
#define FF_V_MIN 1e-60 /* stands for normal incidence, where a is infinite */

/* The parameters of a stretched distribution, for its term: alpha_x, alpha_y, r_xy, slope_x, slope_y. */
#define FF_STRETCH_PARAMS                                                                                                          \
    {"alpha_x", "1", "roughness along the tangent, alpha_x", 1e-4, 4, 0.3, FF_PARAM_LOG, 0},                                       \
        {"alpha_y", "1", "roughness across the tangent, alpha_y", 1e-4, 4, 0.3, FF_PARAM_LOG, 0},                                  \
        {"r_xy", "1", "correlation of the slopes, r_xy", -0.999, 0.999, 0, FF_PARAM_ATANH, 0},                                     \
        {"slope_x", "1", "mean slope of the surface along x", -1, 1, 0, FF_PARAM_HELD, 0},                                         \
    {                                                                                                                              \
        "slope_y", "1", "mean slope of the surface along y", -1, 1, 0, FF_PARAM_HELD, 0                                            \
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
    FF_G_COS_I,   /* wi.z                                                                    */
    FF_G_VCAVITY, /* G2 of the V-cavity                                                      */
    FF_G_KPHI,    /* van Ginneken's 4.41 phi / (4.41 phi + 1)                                */
    FF_G_COUNT
};

/* Planes of a block; those that nobody needs are NULL. */
typedef struct ff_geometry {
    double *plane[FF_G_COUNT];
} ff_geometry;

/* ---- one lobe over a block ------------------------------------------------------------------- */

/* Which derivatives a lobe's pass makes: ISOTROPIC needs S2 TI2 TO2 and gives alpha (as FF_D_AX); CENTRED and TILTED need the
 * vector planes; CENTRED gives AX AY R, TILTED also X0 Y0. Those that a mode lacks are not written. */
typedef enum ff_stretch_mode { FF_ISOTROPIC_MODE = 0, FF_CENTRED_MODE = 1, FF_TILTED_MODE = 2 } ff_stretch_mode;

typedef struct ff_lobe_pass {
    ff_stretch_mode mode;
    int ndf, masking;
    ff_stretch s;
    ff_ndf_pass ndf_pass;
} ff_lobe_pass;

/* ---- masking, Fresnel, diffuse --------------------------------------------------------------- */

typedef struct ff_masking {
    ff_term term;
    int uses_lambda; /* 0: li, lo are not read and the derivatives are 0, not written */
    uint32_t planes; /* extra geometry planes, 1u << FF_G_...                         */
    /* G and d ln G / d Lambda_i, d ln G / d Lambda_o. */
    void (*eval)(const ff_geometry *g, size_t n, const double *restrict li, const double *restrict lo, double *restrict G,
                 double *restrict gi, double *restrict go);
} ff_masking;

/* Fresnel (F) or a diffuse term (f, 1/sr; the caller zeroes what is below the horizon). */
typedef struct ff_optics {
    ff_term term;
    uint32_t planes;
    /* Value and derivatives by the term's own parameters, d[k] planes; d may be NULL. */
    void (*eval)(const double *params, const ff_geometry *g, size_t n, double *restrict f, double *const *d);
} ff_optics;

/* ---- the kernels of one instruction set ------------------------------------------------------ */

typedef struct ff_kernels {
    const ff_ndf *const *ndf; /* [ff_term_count(kind)] each, in the order of models.def */
    const ff_masking *const *masking;
    const ff_optics *const *fresnel;
    const ff_optics *const *diffuse;
    /* The planes that are not NULL in g, from n <= FF_BLOCK pairs of directions. */
    void (*geometry)(const ff_dirs *w, size_t n, const ff_geometry *g);
    /* S = D G / (4 iz oz) (with the projected view cosine when tilted) and its derivatives dS[FF_D_...], where the pointer is
     * not NULL. dS itself may be NULL. */
    void (*lobe)(const ff_lobe_pass *pass, const ff_geometry *g, size_t n, double *restrict S, double *const *dS);
    /* D, both Lambdas and G of a TILTED pass, for ff_model_terms; no plane may be NULL. */
    void (*lobe_terms)(const ff_lobe_pass *pass, const ff_geometry *g, size_t n, double *d, double *li, double *lo, double *gg);
} ff_kernels;

/* The kernels of an instruction set; NULL when it is not available here. */
const ff_kernels *ff_kernels_get(ff_isa isa);

/* Chooses mode-independent constants of a pass: ndf, masking, mode and s are set, ndf_pass is filled. */
void ff_lobe_pass_prepare(const ff_kernels *k, ff_lobe_pass *pass);

/* Bit set (1u << FF_G_...) of the planes that a model's kernels read in a mode. */
uint32_t ff_model_planes(const ff_model *m, ff_stretch_mode mode);

/* Stretch of lobe l for the shape parameters [n_shape] of m; jac [n_params of the lobe][FF_D_COUNT], may be NULL. */
void ff_model_stretch(const ff_model *m, uint32_t l, const double *shape, ff_stretch *s, double jac[][FF_D_COUNT]);

/* Descriptors by index in models.def; the range is the caller's matter. */
const ff_ndf *ff_ndf_at(int ndf);
const ff_masking *ff_masking_at(int masking);
const ff_optics *ff_fresnel_at(int fresnel);
const ff_optics *ff_diffuse_at(int diffuse);

#endif
