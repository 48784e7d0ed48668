/* A pass of a composed model over a block of samples: its lobes, its columns, and the kernels of an instruction set. */
#ifndef FF_INTERNAL_KERNEL_H
#define FF_INTERNAL_KERNEL_H
#include "composition_struct.h"
#include "models/terms/internal_term.h"

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
    double *f0;              /* FF_COUPLE_F0: [n_channels][n_lobes][1 + FF_FRESNEL_PARAMS], F and derivatives at c = 1        */
    double *f_average;       /* FF_COUPLE_LOSS: [n_channels][n_lobes][1 + FF_FRESNEL_PARAMS], 2 integral F(mu) mu dmu         */
    ff_albedo_curve *albedo; /* FF_COUPLE_ALBEDO: [n_channels], of all lobes, by all columns                                  */
    ff_albedo_curve *loss;   /* FF_COUPLE_LOSS: [n_lobes], of one lobe with F = 1, by the shape columns                       */
    uint32_t planes;         /* bit set (1u << FF_G_...) of the planes that the kernels read, for these modes of the lobes        */
    double *storage;         /* what the pointers above and the lobes' tables point into                                      */
} ff_prepared;

/* Planes between the stages of a lobe. */
typedef struct ff_lobe_work {
    double q2[FF_BLOCK], p[FF_BLOCK], dlnp[FF_BLOCK];
    double vi[FF_BLOCK], vo[FF_BLOCK], inv_deni[FF_BLOCK], inv_deno[FF_BLOCK];
    double li[FF_BLOCK], lo[FF_BLOCK], dli[FF_BLOCK], dlo[FF_BLOCK];
    double G[FF_BLOCK], gi[FF_BLOCK], go[FF_BLOCK], gx[FF_BLOCK], seen[FF_BLOCK];
} ff_lobe_work;

/* The same of its derivatives. */
typedef struct ff_lobe_slopes {
    double dlnp_own[FF_MAX_OWN][FF_BLOCK], dli_own[FF_MAX_OWN][FF_BLOCK], dlo_own[FF_MAX_OWN][FF_BLOCK];
    double ei[FF_BLOCK], eo[FF_BLOCK]; /* d ln G / d vi, d ln G / d vo */
} ff_lobe_slopes;

/* Planes of the derivatives of one block of samples: seven times as many as those of the values, and too many for a stack. They
 * are allocated once, by whoever goes over many blocks. */
typedef struct __attribute__((aligned(64))) ff_block_slopes {
    double dS[FF_MAX_LOBES][FF_D_COUNT][FF_BLOCK];
    double combined[FF_MAX_SHAPE][FF_BLOCK]; /* columns that are a sum of several kernel derivatives    */
    const double *shape[FF_MAX_SHAPE];       /* column planes before the Fresnel term; NULL: none       */
    /* of the channel at hand */
    double dF[FF_MAX_CHANNEL_PARAMS][FF_BLOCK]; /* of ks F, by each channel parameter of the model */
    double d_part[FF_MAX_PARTS][FF_DD_COUNT][FF_BLOCK];
    ff_lobe_slopes lobe; /* of the lobe at hand */
} ff_block_slopes;

/* Planes of one block of samples. */
typedef struct __attribute__((aligned(64))) ff_block {
    ff_block_slopes *d; /* NULL where no derivative is wanted */
    double S[FF_MAX_LOBES][FF_BLOCK];
    double sum[FF_MAX_LOBES][FF_BLOCK]; /* of weight S over the lobes that share a Fresnel term    */
    const double *group[FF_MAX_LOBES];  /* S or sum, by the lobe that has the Fresnel term         */
    double scale[FF_MAX_PARTS];         /* weight ks of the lobe a part belongs to, else 1         */
    union {
        ff_lobe_work lobe; /* of the lobe at hand, before there are channels: a block must fit on the stack of whoever evaluates */
        struct {
            ff_albedo_place place_i, place_o; /* of wi and wo, where a part has a curve */
            /* of the channel at hand */
            double F[FF_MAX_LOBES][FF_BLOCK];    /* ks F                                      */
            double part[FF_MAX_PARTS][FF_BLOCK]; /* before the scale                          */
            double ai[FF_BLOCK], ao[FF_BLOCK];   /* albedos of wi and wo, of the part at hand */
            double lobe_value[FF_BLOCK];         /* of the lobe that it belongs to            */
        };
    };
} ff_block;

/* A block with room for its derivatives and for the columns made of them. */
typedef struct __attribute__((aligned(64))) ff_block_work {
    ff_block block;
    ff_block_slopes slopes;
    double column[FF_MAX_SHAPE + FF_MAX_CHANNEL_PARAMS][FF_BLOCK];
    double planes[FF_G_COUNT][FF_BLOCK]; /* of geometry, for whoever has none */
} ff_block_work;

/* [count], for as many threads, each ready for block_shape; NULL when out of memory. Release with free. */
ff_block_work *ff_block_work_new(size_t count);

/* The lobe whose Fresnel term lobe l uses: its own index, or 0. */
static inline uint32_t ff_model_group(const ff_model *m, uint32_t l)
{
    return m->lobe[l].fresnel == FF_FRESNEL_SHARED ? 0 : l;
}

/* ---- the kernels of one instruction set ------------------------------------------------------ */

typedef struct ff_kernels {
    const ff_ndf *const *ndf; /* [ff_term_count(kind)] each, in the order of models.def */
    const ff_masking *const *masking;
    const ff_fresnel *const *fresnel;
    const ff_diffuse *const *diffuse;
    /* The planes that are not NULL in g, from n <= FF_BLOCK pairs of directions. */
    void (*geometry)(const ff_dirs *w, size_t n, const ff_geometry *g);
    /* S = D G / (4 iz oz) (with the projected view cosine when tilted) and its derivatives dS[FF_D_...], where the pointer is
     * not NULL. dS itself may be NULL, and then d. */
    void (*lobe)(const ff_lobe_pass *pass, const ff_geometry *g, size_t n, ff_lobe_work *restrict t, ff_lobe_slopes *restrict d,
                 double *restrict S, double *const *dS);
    /* D, both Lambdas and G of a TILTED pass, for ff_model_terms; no plane may be NULL. */
    void (*lobe_terms)(const ff_lobe_pass *pass, const ff_geometry *g, size_t n, ff_lobe_work *t, double *d, double *li, double *lo,
                       double *gg);
    /* The composed model over a block, in three steps: what all channels share; f of channel c; then df = j d f / d column for
     * that channel's columns, in the order of `wanted`. Nothing here looks at the horizon: at or below it lanes hold finite
     * numbers. */
    void (*block_shape)(const ff_prepared *p, const ff_geometry *g, size_t n, ff_block *b);
    void (*block_value)(const ff_prepared *p, const ff_geometry *g, size_t n, size_t c, ff_block *b, double *restrict f);
    void (*block_columns)(const ff_prepared *p, size_t n, size_t c, const double *restrict j, ff_block *b,
                          double (*restrict df)[FF_BLOCK]);
    /* Adds the albedo that comes from `points`, seen at the cosine mu, to number `at` of the coefficients (still values at nodes)
     * of every function of the curves of p, which has no parts. */
    void (*albedo_add)(const ff_prepared *p, double mu, const ff_albedo_points *points, uint32_t at, ff_block_work *work);
    /* A function of an albedo curve at the cosines mu. */
    void (*albedo_at)(const ff_albedo_curve *curve, uint32_t function, size_t n, const double *restrict mu, double *restrict out);
} ff_kernels;

/* The kernels of an instruction set; NULL when it is not available here. */
const ff_kernels *ff_kernels_get(ff_isa isa);

#endif
