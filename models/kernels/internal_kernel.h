/* What the rooms share below the public headers: one distribution's kernels, the geometry planes, and a pass of one lobe over a
 * block of samples. Compiled code of this header exists once per instruction set; see isa.c for the choice. */
#ifndef FF_INTERNAL_KERNEL_H
#define FF_INTERNAL_KERNEL_H
#include "ff_profile.h"
#include "base/internal_isa.h"

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

/* ---- one lobe over a block ------------------------------------------------------------------- */

/* Which derivatives a lobe's pass makes: ISOTROPIC needs S2 TI2 TO2 and gives alpha (as FF_D_AX); CENTRED and TILTED need the
 * vector planes; CENTRED gives AX AY R, TILTED also X0 Y0. Those that a mode lacks are not written. */
typedef enum ff_stretch_mode {
    FF_ISOTROPIC_MODE = 0,
    FF_CENTRED_MODE = 1,
    FF_TILTED_MODE = 2,
    FF_CHEAPEST_MODE = 3 /* for ff_prepare: of each lobe the first that gives its value */
} ff_stretch_mode;

typedef struct ff_lobe_pass {
    ff_stretch_mode mode;
    int ndf, masking;
    ff_stretch s;
    double masking_own; /* the masking's own parameter, where it has one */
    ff_ndf_pass ndf_pass;
} ff_lobe_pass;

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
    /* Parameters whose F is like that of Schlick with this F0: where a fit starts. NULL where they are solved for (linear). */
    void (*like_schlick)(double f0, double *params);
} ff_fresnel;

/* What a diffuse term may read of the lobes below it. */
enum {
    FF_COUPLE_ALPHA = 1u << 0,  /* roughness of the first lobe                                                   */
    FF_COUPLE_F0 = 1u << 1,     /* F of the first lobe at normal incidence                                       */
    FF_COUPLE_ALBEDO = 1u << 2, /* directional albedo of all lobes                                               */
    FF_COUPLE_LOSS = 1u << 3    /* for each lobe by itself: its albedo with F = 1 and the average of its Fresnel  */
};

/* Inputs of a diffuse term for one channel: its own parameters in their order, then one value for each coupling of the lobes. */
typedef struct ff_diffuse_input {
    double params[8];      /* shared and per-channel ones, in the order of term.params                       */
    double alpha, f0;      /* FF_COUPLE_ALPHA, FF_COUPLE_F0                                                  */
    const double *ai, *ao; /* [n] directional albedos of wi and wo: FF_COUPLE_ALBEDO, FF_COUPLE_LOSS          */
    double mean;           /* their cosine-weighted mean over the hemisphere                                 */
    double f_average;      /* FF_COUPLE_LOSS: 2 integral F(mu) mu dmu                                        */
} ff_diffuse_input;

/* Derivatives of a diffuse term: by its own parameters, then these. */
enum { FF_DD_ALPHA = 8, FF_DD_F0, FF_DD_AI, FF_DD_AO, FF_DD_MEAN, FF_DD_F_AVERAGE, FF_DD_COUNT };

typedef struct ff_diffuse {
    ff_term term;
    uint32_t planes;
    uint32_t couples; /* FF_COUPLE_... */
    /* f in 1/sr (the caller zeroes what is below the horizon) and d f / d input, d[FF_DD_COUNT] planes, each or d itself NULL
     * where it is not wanted. */
    void (*eval)(const ff_diffuse_input *in, const ff_geometry *g, size_t n, double *restrict f, double *const *d);
} ff_diffuse;

/* ---- a model made ready for its samples ------------------------------------------------------ */

/* Which derivatives are wanted: a column for each, shared parameters first, then those of the channel. */
typedef struct ff_wanted {
    uint32_t n_shape, n_channel;
    uint32_t shape[FF_MAX_SHAPE]; /* indices into the model's shape parameters                      */
    int tied[FF_MAX_SHAPE];       /* 1: alpha_y of the same lobe moves with it                      */
    uint32_t channel[FF_MAX_CHANNEL_PARAMS];
} ff_wanted;

/* A directional albedo a(mu), mu = cos theta in [0, 1], and its derivatives by columns of the model: three polynomials in functions
 * of x = mu^(1/3), one after the other. How they are made: coupling.c. Functions: 0 the albedo, 1 + k its derivative by wanted
 * column k. */
enum { FF_ALBEDO_PIECES = 3, FF_ALBEDO_PIECE_0 = 24, FF_ALBEDO_PIECE_1 = 20, FF_ALBEDO_PIECE_2 = 12 }; /* coefficients of each */
enum { FF_ALBEDO_COEFFICIENTS = FF_ALBEDO_PIECE_0 + FF_ALBEDO_PIECE_1 + FF_ALBEDO_PIECE_2 };
#define FF_ALBEDO_X_0 0.0046415888336127789 /* where the pieces begin: mu = 1e-7, below which a is taken as there, ... */
#define FF_ALBEDO_X_1 0.46415888336127789   /* ... mu = 0.1, ...                                                       */
#define FF_ALBEDO_X_2 0.89089871814033930   /* ... and 1/sqrt(2), where the albedo of V-cavities is not smooth         */
typedef struct ff_albedo_curve {
    uint32_t n_functions;
    int over_cosine;     /* 1: the polynomials are of mu a(mu), since a itself grows without bound                  */
    double *coefficient; /* [n_functions][FF_ALBEDO_COEFFICIENTS], piece after piece, by rising power of t in [-1, 1] */
    double *mean;        /* [n_functions] 2 integral a mu dmu                                                        */
} ff_albedo_curve;

/* What the curves of a plane of cosines share: mu^(1/3), and the variables of the later pieces. */
typedef struct ff_albedo_place {
    double x[FF_BLOCK], middle[FF_BLOCK], last[FF_BLOCK];
} ff_albedo_place;

/* Half vectors of one view, for the sums of coupling.c: slopes q (cos psi, sin psi), psi = 0 towards the view, and weights of
 * q dq dpsi. */
typedef struct ff_albedo_points {
    size_t n;
    double q[FF_BLOCK], cos_psi[FF_BLOCK], sin_psi[FF_BLOCK], weight[FF_BLOCK];
} ff_albedo_points;

/* One column of shared parameters: either a sum of the kernels' derivatives of a lobe, or a change of the lobes' weights, or an own
 * parameter of a base. */
typedef struct ff_shape_column {
    int lobe;                    /* -1: none                                              */
    double d[FF_D_COUNT];        /* already times the lobe's weight                       */
    int moves_weights;           /* 1: weight[] counts                                    */
    double weight[FF_MAX_LOBES]; /* d weight of each lobe                                 */
    double alpha;                /* d roughness of the first lobe                         */
    int base;                    /* -1: none                                              */
    uint32_t base_param;
} ff_shape_column;

/* One column of a channel: a parameter of a Fresnel term, the scale ks that goes with it, or a parameter of a base. */
typedef struct ff_channel_column {
    int group; /* lobe that has the Fresnel term, -1: none  */
    int is_scale;
    int base; /* -1: none                                   */
    uint32_t param;
} ff_channel_column;

/* What a base contributes: itself, or one term for each lobe (FF_COUPLE_LOSS). */
enum { FF_MAX_PARTS = FF_MAX_BASES + FF_MAX_LOBES, FF_FRESNEL_PARAMS = 4, FF_BASE_PARAMS = 8 };
typedef struct ff_part {
    uint32_t base;
    int lobe; /* -1: not for a lobe */
} ff_part;

/* Everything that does not change between blocks of samples. */
typedef struct ff_prepared {
    const struct ff_kernels *kernels;
    const ff_model *m;
    size_t n_channels;
    const double *channel; /* [n_channels][m->n_channel] */
    ff_lobe_pass lobe[FF_MAX_LOBES];
    double weight[FF_MAX_LOBES];
    uint32_t needs[FF_MAX_LOBES]; /* bit set of the FF_D_... that some column reads */
    ff_wanted wanted;
    ff_shape_column shape[FF_MAX_SHAPE];
    ff_channel_column column[FF_MAX_CHANNEL_PARAMS];
    uint32_t n_parts, couples; /* couples: of all bases */
    ff_part part[FF_MAX_PARTS];
    double base_param[FF_MAX_BASES][FF_BASE_PARAMS]; /* the shared ones of each base, in their places    */
    double alpha;                                    /* roughness of the first lobe                      */
    double *f0;              /* FF_COUPLE_F0: [n_channels][1 + FF_FRESNEL_PARAMS], F and derivatives at c = 1 */
    double *f_average;       /* FF_COUPLE_LOSS: [n_channels][n_lobes][1 + FF_FRESNEL_PARAMS], 2 integral F(mu) mu dmu         */
    ff_albedo_curve *albedo; /* FF_COUPLE_ALBEDO: [n_channels], of all lobes, by all columns                                  */
    ff_albedo_curve *loss;   /* FF_COUPLE_LOSS: [n_lobes], of one lobe with F = 1, by the shape columns                       */
    double *storage;         /* what the pointers above and the lobes' tables point into                                      */
} ff_prepared;

/* Makes m ready. shape, channel as ff_model_eval, checked before; mode for the lobes that are not isotropic; wanted NULL: the value
 * alone. tan2_lo, tan2_hi: range of tan^2 theta over all directions to come, 0 and INFINITY when unknown. channel and m must
 * outlive it. FF_ERR_MEMORY. */
ff_status ff_prepare(const ff_model *m, const struct ff_kernels *k, ff_stretch_mode mode, size_t n_channels, const double *shape,
                     const double *channel, const ff_wanted *wanted, double tan2_lo, double tan2_hi, ff_prepared *out);
void ff_prepared_free(ff_prepared *p);

/* Fills the curves that the couplings of p need (albedo, loss, f_average); p is otherwise ready. */
void ff_coupling_fill(ff_prepared *p);

/* Bit set (1u << FF_G_...) of the planes that its kernels read. */
uint32_t ff_prepared_planes(const ff_prepared *p);

/* Planes of one block of samples. */
typedef struct __attribute__((aligned(64))) ff_block {
    double S[FF_MAX_LOBES][FF_BLOCK];
    double dS[FF_MAX_LOBES][FF_D_COUNT][FF_BLOCK];
    double sum[FF_MAX_LOBES][FF_BLOCK];      /* of weight S over the lobes that share a Fresnel term    */
    double combined[FF_MAX_SHAPE][FF_BLOCK]; /* columns that are a sum of several kernel derivatives    */
    const double *group[FF_MAX_LOBES];       /* S or sum, by the lobe that has the Fresnel term         */
    const double *shape[FF_MAX_SHAPE];       /* column planes before the Fresnel term; NULL: none       */
    /* of the channel at hand */
    double F[FF_MAX_LOBES][FF_BLOCK];           /* ks F                                                      */
    double dF[FF_MAX_CHANNEL_PARAMS][FF_BLOCK]; /* its derivative by each channel parameter of the model */
    double scale[FF_MAX_PARTS];                 /* weight ks of the lobe a part belongs to, else 1           */
    double part[FF_MAX_PARTS][FF_BLOCK];        /* before the scale                                          */
    double d_part[FF_MAX_PARTS][FF_DD_COUNT][FF_BLOCK];
    double ai[FF_MAX_PARTS][FF_BLOCK], ao[FF_MAX_PARTS][FF_BLOCK];
    ff_albedo_place place_i, place_o; /* of wi and wo, where a part has a curve */
} ff_block;

/* ---- the kernels of one instruction set ------------------------------------------------------ */

typedef struct ff_kernels {
    const ff_ndf *const *ndf; /* [ff_term_count(kind)] each, in the order of models.def */
    const ff_masking *const *masking;
    const ff_fresnel *const *fresnel;
    const ff_diffuse *const *diffuse;
    /* The planes that are not NULL in g, from n <= FF_BLOCK pairs of directions. */
    void (*geometry)(const ff_dirs *w, size_t n, const ff_geometry *g);
    /* S = D G / (4 iz oz) (with the projected view cosine when tilted) and its derivatives dS[FF_D_...], where the pointer is
     * not NULL. dS itself may be NULL. */
    void (*lobe)(const ff_lobe_pass *pass, const ff_geometry *g, size_t n, double *restrict S, double *const *dS);
    /* D, both Lambdas and G of a TILTED pass, for ff_model_terms; no plane may be NULL. */
    void (*lobe_terms)(const ff_lobe_pass *pass, const ff_geometry *g, size_t n, double *d, double *li, double *lo, double *gg);
    /* The composed model over a block, in three steps: what all channels share; f of channel c; then df = j d f / d column for
     * that channel's columns, in the order of `wanted`. Nothing here looks at the horizon: at or below it lanes hold finite
     * numbers. */
    void (*block_shape)(const ff_prepared *p, const ff_geometry *g, size_t n, ff_block *b);
    void (*block_value)(const ff_prepared *p, const ff_geometry *g, size_t n, size_t c, ff_block *b, double *restrict f);
    void (*block_columns)(const ff_prepared *p, size_t n, size_t c, const double *restrict j, ff_block *b,
                          double (*restrict df)[FF_BLOCK]);
    /* Adds the albedo that comes from `points`, seen at the cosine mu, to number `at` of the coefficients (still values at nodes)
     * of every function of the curves of p, which has no parts. */
    void (*albedo_add)(const ff_prepared *p, double mu, const ff_albedo_points *points, uint32_t at);
    /* A function of an albedo curve at the cosines mu. */
    void (*albedo_at)(const ff_albedo_curve *curve, uint32_t function, size_t n, const double *restrict mu, double *restrict out);
} ff_kernels;

/* The kernels of an instruction set; NULL when it is not available here. */
const ff_kernels *ff_kernels_get(ff_isa isa);

/* Bit set (1u << FF_G_...) of the planes that a model's kernels read in a mode; isotropic lobes stay in theirs. */
uint32_t ff_model_planes(const ff_model *m, ff_stretch_mode mode);

/* Parameters of lobe l for the shape parameters [n_shape] of m: ndf, masking, s and masking_own of the pass are set. jac [n_shape
 * of the lobe][FF_D_COUNT] = d (stretch, own, masking) / d parameter of the lobe; may be NULL. */
void ff_model_lobe(const ff_model *m, uint32_t l, const double *shape, ff_lobe_pass *pass, double jac[][FF_D_COUNT]);

/* Weight of each lobe [n_lobes], and its derivatives by the lobes' parameters `weight`, dw[parameter's lobe][lobe]; may be NULL. */
void ff_model_weights(const ff_model *m, const double *shape, double *weight, double dw[][FF_MAX_LOBES]);

/* Lobe l of m as a model of its own, without the lobe's weight; out_shape [FF_MAX_SHAPE], out_channel [n_channels][out->n_channel].
 */
void ff_model_lobe_alone(const ff_model *m, uint32_t l, size_t n_channels, const double *shape, const double *channel,
                         ff_model *out, double *out_shape, double *out_channel);

/* FF_ERR_UNKNOWN with the names that exist. */
ff_status ff_model_unknown_param(const ff_model *m, const char *name, ff_error *err);

/* Is name "alpha" or "lobe2.alpha", standing for two axes that the model has? Then their names go to x, y. 0 also for a parameter
 * that is called so itself. */
int ff_model_alpha_axes(const ff_model *m, const char *name, char x[FF_PARAM_NAME], char y[FF_PARAM_NAME]);

/* The lobe whose Fresnel term lobe l uses: its own index, or 0. */
uint32_t ff_model_group(const ff_model *m, uint32_t l);

/* Descriptors by index in models.def; the range is the caller's matter. */
const ff_ndf *ff_ndf_at(int ndf);
const ff_masking *ff_masking_at(int masking);
const ff_fresnel *ff_fresnel_at(int fresnel);
const ff_diffuse *ff_diffuse_at(int diffuse);

#endif
