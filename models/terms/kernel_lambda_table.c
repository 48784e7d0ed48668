/* See internal_lambda_table.h. Compiled once per instruction set. */
#include "internal_lambda_table.h"
#include "base/internal_vector_math.h"

/* ---- the lattice ----------------------------------------------------------------------------- */

/* Nodes: the mu = 2^(k / STEPS). The points t of a lattice are `refine` times as dense. The sums over t begin AROUND points before
 * a node; from 2 octaves behind it on (mu / t < 1/4) the kernels are their series. */
enum { STEPS = 16, FINE = 1024 / STEPS, AROUND = 5, OCTAVES_NEAR = 2, OCTAVE_TOP = 34, TERMS = 8 };
enum { NODE_MIN = -FF_LAMBDA_OCTAVE_HI / 2 * STEPS, NODE_MAX = -FF_LAMBDA_OCTAVE_LO / 2 * STEPS, NODES = NODE_MAX - NODE_MIN + 1 };
/* most points of a lattice, and points of a lattice that a node asks one by one */
#define LATTICE(refine) ((OCTAVE_TOP * STEPS - NODE_MIN) * (refine) + AROUND + 1)
#define REACH(refine)   (AROUND + OCTAVES_NEAR * STEPS * (refine) + 1)

#define LN2  0.69314718055994530942
#define STEP (LN2 / STEPS) /* of nodes, in ln mu */

/* The kernels of Lambda, Lambda + Q and mu P2. */
enum { OF_LAMBDA, OF_SUM, OF_P2, KERNELS };

/* What the trapezoidal rule lacks at the AROUND points to either side of y = 0: the generalised Euler-Maclaurin formula, with the
 * Hurwitz zeta function at -3/2 - m, -1/2 - m, 1/2 - m and the derivatives of g from differences of 11 points; made with 40 digits.
 * For lattices as dense as the nodes, and FINE times so. */
static const double correction[KERNELS][2 * AROUND + 1] = {
    {7.3601056425261237e-09, -8.7267486943847132e-08, 4.7662114118019953e-07, -1.5530510679976617e-06, 2.6790620848801498e-06,
     2.4651490157181006e-05, -9.8778977841432353e-06, 3.0309388431040064e-06, -7.5099112917904984e-07, 1.2315118904781423e-07,
     -9.7098474729165681e-09},
    {-7.2615117444323238e-07, 9.1966099114144399e-06, -5.6162304874879034e-05, 0.00022963861527976865, -0.00080322393915519181,
     0.0056855175234738608, 0.00036630738783202758, -0.00014984159504860171, 4.1912716853003757e-05, -7.3646206486186831e-06,
     6.0725294215766022e-07},
    {-5.0038066207712053e-05, 0.00061983358647387291, -0.0036616696036961328, 0.014183344507109995, -0.045010370091321611,
     0.41670985629515506, 0.058725249841040286, -0.016412768860064004, 0.0040460376198555399, -0.00066852592341695694,
     5.3174808458673274e-05}};

static const double correction_fine[KERNELS][2 * AROUND + 1] = {
    {2.2187075414027204851e-13, -2.6283809763098412639e-12, 1.433363940407783151e-11, -4.6554878088583509272e-11,
     7.9211327589560929837e-11, 7.5661583651458259587e-10, -3.0118621639660778546e-10, 9.2183446590739587681e-11,
     -2.2808769078523522762e-11, 3.7370509508553843858e-12, -2.944761396638625523e-13},
    {-1.4289363733884516341e-9, 1.8088705394142995762e-8, -1.1038369098536024405e-7, 4.5076959686718453103e-7,
     -1.5727112608876579869e-6, 1.1069066539190125669e-5, 7.2969152796683756907e-7, -2.9703528605376223119e-7,
     8.2945551161602559627e-8, -1.4561957954522072856e-8, 1.2000719505731993705e-9},
    {-6.2772931883148857327e-6, 7.7764445998623897936e-5, -4.5944918368688743993e-4, 1.7800240829747831965e-3,
     -5.6510775767613527966e-3, 5.2262964384204259594e-2, 7.3521915389201721509e-3, -2.0562876549644456001e-3,
     5.0706441423826987191e-4, -8.3795641642979548907e-5, 6.6657961105349297523e-6}};

/* The kernels for small z = mu / t = e^-y, coefficients of z^-1, 1, z, z^3, z^5, z^7, z^9, z^11. */
static const double power[TERMS] = {-1, 0, 1, 3, 5, 7, 9, 11};
static const double series[KERNELS][TERMS] = {
    {1, -FF_PI / 2, 1. / 2, 1. / 24, 1. / 80, 5. / 896, 7. / 2304, 21. / 11264},
    {1, 0, -1. / 2, -1. / 8, -1. / 16, -5. / 128, -7. / 256, -21. / 1024},
    {0, 0, 1, 1. / 2, 3. / 8, 5. / 16, 35. / 128, 63. / 256},
};

/* How g on a lattice is summed. */
typedef struct rule {
    int refine;
    size_t reach;
    double *near[KERNELS];                    /* [reach] of the points from -AROUND on of a node              */
    double far[TERMS][KERNELS], ratio[TERMS]; /* of the sums of g z^power over the points behind those        */
} rule;

/* storage [KERNELS * REACH(refine)] */
static rule rule_make(int refine, const double (*corrections)[2 * AROUND + 1], double *storage)
{
    const double step = STEP / refine;
    rule w = {.refine = refine, .reach = (size_t)REACH(refine)};
    for (int k = 0; k < KERNELS; k++) w.near[k] = storage + (size_t)k * w.reach;
    double *restrict a = w.near[OF_LAMBDA], *restrict b = w.near[OF_SUM], *restrict c = w.near[OF_P2];
    const int n = (int)w.reach;
    for (int j = 0; j < n; j++) b[j] = sqrt(ff_exp(2 * step * (j > AROUND ? j - AROUND : 1)) - 1); /* s */
    for (int j = 0; j < n; j++) {
        const double behind = j > AROUND ? 2 * step : 0;
        a[j] = behind * (b[j] - ff_angle(b[j], 1));
        c[j] = behind / b[j];
        b[j] *= behind;
    }
    for (int k = 0; k < KERNELS; k++)
        for (int j = 0; j <= 2 * AROUND; j++) w.near[k][j] += corrections[k][j];
    for (int p = 0; p < TERMS; p++) {
        const double first = 2 * step * ff_exp(-step * power[p] * (n - AROUND));
        w.ratio[p] = ff_exp(-step * power[p]);
        for (int k = 0; k < KERNELS; k++) w.far[p][k] = first * series[k][p];
    }
    return w;
}

typedef void profile_kernel(const ff_ndf_pass *pass, size_t n, const double *restrict q2, double *restrict p, double *restrict dlnp,
                            double *const *dlnp_own);

/* g, then its derivatives by the own parameters, at the n points of a lattice from j0 on. */
static void lattice_fill(const ff_ndf_pass *pass, int n_own, profile_kernel *profile, int refine, int j0, size_t n,
                         double *const *g)
{
    double q2[FF_BLOCK], p[FF_BLOCK], dlnp[FF_BLOCK], own[FF_MAX_OWN][FF_BLOCK], *planes[FF_MAX_OWN];
    const double step = 2 * STEP / refine;
    for (int k = 0; k < FF_MAX_OWN; k++) planes[k] = own[k];
    for (size_t begin = 0; begin < n; begin += FF_BLOCK) {
        const size_t m = n - begin < FF_BLOCK ? n - begin : FF_BLOCK;
        for (size_t i = 0; i < m; i++) q2[i] = ff_exp(step * (j0 + (int)(begin + i)));
        profile(pass, m, q2, p, dlnp, n_own ? planes : NULL);
        for (size_t i = 0; i < m; i++) g[0][begin + i] = q2[i] * p[i];
        for (int k = 0; k < n_own; k++)
            for (size_t i = 0; i < m; i++) g[1 + k][begin + i] = q2[i] * p[i] * own[k][i];
    }
    for (int k = 0; k <= n_own; k++) g[k][n - 1] *= 0.5; /* the end of the trapezoidal rule */
}

/* ---- nodes ----------------------------------------------------------------------------------- */

/* Lambda and its first two derivatives by ln mu, or the same of d Lambda / d own; and the sums that they are made of. */
typedef struct nodes {
    double lam[NODES], d[NODES], dd[NODES];
    double sum[KERNELS][NODES];
} nodes;

/* The sums over the points behind the reach of a node, for the first n nodes. */
static void sum_far(const rule *w, const double *restrict g, size_t n_lattice, size_t n, double sum[KERNELS][NODES])
{
    double moment[TERMS] = {0};
    const size_t refine = (size_t)w->refine;
    for (size_t j = n_lattice; j-- > w->reach;) {
        const size_t node = (j - w->reach) / refine;
        for (int p = 0; p < TERMS; p++) moment[p] = g[j] + w->ratio[p] * moment[p];
        if (node >= n || node * refine != j - w->reach) continue;
        for (int k = 0; k < KERNELS; k++) {
            double s = 0;
            for (int p = 0; p < TERMS; p++) s += w->far[p][k] * moment[p];
            sum[k][node] = s;
        }
    }
}

/* The sums over the points within reach, added; the nodes are the lattice's points. */
static void sum_near(const rule *w, const double *restrict g, size_t n, double sum[KERNELS][NODES])
{
    double *restrict a = sum[OF_LAMBDA], *restrict b = sum[OF_SUM], *restrict c = sum[OF_P2];
    for (size_t j = 0; j < w->reach; j++) {
        const double wa = w->near[OF_LAMBDA][j], wb = w->near[OF_SUM][j], wc = w->near[OF_P2][j];
        for (size_t i = 0; i < n; i++) {
            a[i] += wa * g[i + j];
            b[i] += wb * g[i + j];
            c[i] += wc * g[i + j];
        }
    }
}

/* The same on a lattice that is denser. */
static void sum_near_fine(const rule *w, const double *restrict g, size_t n, double sum[KERNELS][NODES])
{
    for (size_t i = 0; i < n; i++)
        for (int k = 0; k < KERNELS; k++) {
            double s = 0;
            for (size_t j = 0; j < w->reach; j++) s += w->near[k][j] * g[i * (size_t)w->refine + j];
            sum[k][i] += s;
        }
}

/* The first n nodes; that of index i lies at the lattice's point AROUND + refine i. */
static void integrate(const rule *w, const double *restrict g, size_t n_lattice, size_t n, nodes *out)
{
    sum_far(w, g, n_lattice, n, out->sum);
    if (w->refine == 1)
        sum_near(w, g, n, out->sum);
    else
        sum_near_fine(w, g, n, out->sum);
    for (size_t i = 0; i < n; i++) {
        out->lam[i] = out->sum[OF_LAMBDA][i];
        out->d[i] = -out->sum[OF_SUM][i];
        out->dd[i] = out->sum[OF_SUM][i] + out->sum[OF_P2][i];
    }
}

/* ---- bins ------------------------------------------------------------------------------------ */

/* A function at a point with its first two derivatives. */
typedef struct jet {
    double f, d, dd;
} jet;

/* Coefficients of the polynomial in [0, 1] with these ends. */
static void quintic(jet a, jet b, double c[6])
{
    const double rise = b.f - a.f;
    c[0] = a.f;
    c[1] = a.d;
    c[2] = 0.5 * a.dd;
    c[3] = 10 * rise - 6 * a.d - 4 * b.d - 1.5 * a.dd + 0.5 * b.dd;
    c[4] = -15 * rise + 8 * a.d + 7 * b.d + 1.5 * a.dd - b.dd;
    c[5] = 6 * rise - 3 * (a.d + b.d) - 0.5 * (a.dd - b.dd);
}

static jet quintic_at(const double c[6], double x)
{
    return (jet){((((c[5] * x + c[4]) * x + c[3]) * x + c[2]) * x + c[1]) * x + c[0],
                 (((5 * c[5] * x + 4 * c[4]) * x + 3 * c[3]) * x + 2 * c[2]) * x + c[1],
                 ((20 * c[5] * x + 12 * c[4]) * x + 6 * c[3]) * x + 2 * c[2]};
}

/* A node, its derivatives by steps of the lattice. */
static jet node_at(const nodes *nd, int i)
{
    return (jet){nd->lam[i], STEP * nd->d[i], STEP * STEP * nd->dd[i]};
}

/* f, v df/dv and v^2 d^2f/dv^2 at the lower end of bin b, from the nodes that begin at lattice point j0: with y = ln mu,
 * df/dy = -2 v df/dv. `before` is 8 log2(1 + k/16), the points of the lattice from v = 2^e (1 + k/16) to v = 2^e. */
static jet edge_at(const nodes *nd, int j0, int b, const double before[16])
{
    const int e = FF_LAMBDA_OCTAVE_LO + b / 16, steps = (int)before[b % 16] + (b % 16 != 0), at = -STEPS / 2 * e - steps - j0;
    double c[6];
    jet x = node_at(nd, at);
    if (b % 16) {
        quintic(x, node_at(nd, at + 1), c);
        x = quintic_at(c, steps - before[b % 16]);
    }
    const double dy = x.d / STEP, ddy = x.dd / (STEP * STEP);
    return (jet){x.f, -0.5 * dy, 0.25 * (ddy + 2 * dy)};
}

/* Bins first .. first + n - 1 into six rows of n coefficients. */
static void bins_fill(const nodes *nd, int j0, int first, int n, double *table)
{
    double before[16], c[6];
    for (int k = 0; k < 16; k++) before[k] = 0.5 * STEPS / LN2 * ff_log1p(k / 16.);
    jet lower = edge_at(nd, j0, first, before);
    for (int i = 0; i < n; i++) {
        const jet upper = edge_at(nd, j0, first + i + 1, before);
        const double w0 = 1. / (16 + (first + i) % 16),
                     w1 = 1. / (17 + (first + i) % 16); /* the width of the bin over v at its ends */
        quintic((jet){lower.f, w0 * lower.d, w0 * w0 * lower.dd}, (jet){upper.f, w1 * upper.d, w1 * w1 * upper.dd}, c);
        for (int k = 0; k < 6; k++) table[k * n + i] = c[k];
        lower = upper;
    }
}

/* ---- the table ------------------------------------------------------------------------------- */

/* pass->c: the ends of the table, the high bits of the v of its first bin, the number of bins, that of own parameters */
enum { C_LO = FF_LAMBDA_C, C_HI, C_FIRST, C_BINS, C_OWN };

/* 2^e */
static double two_to(int e)
{
    return ff_from_bits((uint64_t)(1023 + e) << 52);
}

/* The bits of v above those that place it within its bin. */
static inline int64_t bin_bits(double v)
{
    return (int64_t)(ff_bits(v) >> 48);
}

static int bin_of(double v)
{
    const double least = two_to(FF_LAMBDA_OCTAVE_LO), most = two_to(FF_LAMBDA_OCTAVE_HI);
    if (!(v > least)) return 0;
    return v < most ? (int)(bin_bits(v) - bin_bits(least)) : FF_LAMBDA_BINS - 1;
}

/* Lower end of bin b. */
static double bin_v(int b)
{
    return (1 + b % 16 / 16.) * two_to(FF_LAMBDA_OCTAVE_LO + b / 16);
}

/* Points of a lattice from the node j0 on, with those before it. */
static size_t lattice_points(int j0, int refine)
{
    return (size_t)(OCTAVE_TOP * STEPS - j0) * (size_t)refine + AROUND + 1;
}

/* What a table is made from. */
typedef struct workshop {
    double lattice[1 + FF_MAX_OWN][LATTICE(1)], weights[KERNELS * REACH(1)];
    nodes nodes;
} workshop;
_Static_assert(FF_LAMBDA_ROOM * sizeof(double) >= sizeof(workshop), "room behind the table");

void ff_lambda_table_build(ff_ndf_pass *pass, int n_own, profile_kernel *profile)
{
    if (pass->v_lo > pass->v_hi) return;
    const int first = bin_of(pass->v_lo), n = bin_of(pass->v_hi) - first + 1;
    /* the nodes around the ends: mu falls by half a step of the lattice's for each step of v */
    const int node0 = -STEPS / 2 * (FF_LAMBDA_OCTAVE_LO + (first + n) / 16 + ((first + n) % 16 != 0));
    const int node1 = -STEPS / 2 * (FF_LAMBDA_OCTAVE_LO + first / 16);
    workshop *made = (workshop *)(void *)(pass->table + FF_LAMBDA_ROWS(n_own));
    double *g[1 + FF_MAX_OWN];
    const rule w = rule_make(1, correction, made->weights);
    for (int k = 0; k <= FF_MAX_OWN; k++) g[k] = made->lattice[k];
    lattice_fill(pass, n_own, profile, 1, node0 - AROUND, lattice_points(node0, 1), g);
    for (int k = 0; k <= n_own; k++) {
        integrate(&w, g[k], lattice_points(node0, 1), (size_t)(node1 - node0) + 1, &made->nodes);
        bins_fill(&made->nodes, node0, first, n, pass->table + (size_t)k * 6 * (size_t)n);
    }
    pass->c[C_LO] = bin_v(first);
    pass->c[C_HI] = ff_from_bits(ff_bits(bin_v(first + n)) - 1);
    pass->c[C_FIRST] = (double)bin_bits(bin_v(first));
    pass->c[C_BINS] = n;
    pass->c[C_OWN] = n_own;
}

enum { NODES_AT = LATTICE(FINE) + KERNELS * REACH(FINE) };
_Static_assert(FF_LAMBDA_FINE * sizeof(double) >= NODES_AT * sizeof(double) + sizeof(nodes), "room for lattice, weights, nodes");

void ff_lambda_table_fine(const ff_ndf_pass *pass, profile_kernel *profile, double *storage, double *rows)
{
    double *g[1] = {storage};
    nodes *nd = (nodes *)(void *)(storage + NODES_AT);
    const rule w = rule_make(FINE, correction_fine, storage + LATTICE(FINE));
    lattice_fill(pass, 0, profile, FINE, NODE_MIN * FINE - AROUND, LATTICE(FINE), g);
    integrate(&w, g[0], LATTICE(FINE), NODES, nd);
    bins_fill(nd, NODE_MIN, 0, FF_LAMBDA_BINS, rows);
}

void ff_lambda_table_whole(ff_ndf_pass *pass)
{
    pass->c[C_LO] = bin_v(0);
    pass->c[C_HI] = ff_from_bits(ff_bits(bin_v(FF_LAMBDA_BINS)) - 1);
    pass->c[C_FIRST] = (double)bin_bits(bin_v(0));
    pass->c[C_BINS] = FF_LAMBDA_BINS;
    pass->c[C_OWN] = 0;
}

/* Where samples lie: bin, and place u in it from 0 to 1. */
typedef struct places {
    int64_t bin[FF_BLOCK];
    double u[FF_BLOCK];
} places;

/* The polynomials of six rows of coefficients and their derivatives by u. */
static void interpolate(const double *restrict rows, size_t bins, size_t n, places *restrict at, double *restrict f,
                        double *restrict d)
{
    const double *restrict c0 = rows, *restrict c1 = c0 + bins, *restrict c2 = c1 + bins, *restrict c3 = c2 + bins,
                           *restrict c4 = c3 + bins, *restrict c5 = c4 + bins;
    for (size_t i = 0; i < n; i++) {
        const int64_t b = at->bin[i];
        const double x = at->u[i];
        const double s5 = c5[b], s4 = s5 * x + c4[b], s3 = s4 * x + c3[b], s2 = s3 * x + c2[b], s1 = s2 * x + c1[b];
        f[i] = s1 * x + c0[b];
        d[i] = (((s5 * x + s4) * x + s3) * x + s2) * x + s1;
    }
}

/* The values alone. */
static void interpolate_value(const double *restrict rows, size_t bins, size_t n, places *restrict at, double *restrict f)
{
    const double *restrict c0 = rows, *restrict c1 = c0 + bins, *restrict c2 = c1 + bins, *restrict c3 = c2 + bins,
                           *restrict c4 = c3 + bins, *restrict c5 = c4 + bins;
    for (size_t i = 0; i < n; i++) {
        const int64_t b = at->bin[i];
        const double x = at->u[i];
        f[i] = ((((c5[b] * x + c4[b]) * x + c3[b]) * x + c2[b]) * x + c1[b]) * x + c0[b];
    }
}

void ff_lambda_table(const ff_ndf_pass *pass, size_t n, const double *restrict v, double *restrict lam, double *restrict dlam,
                     double *const *dlam_own)
{
    ff_lambda_table_at(pass, pass->table, n, v, lam, dlam, dlam_own);
}

void ff_lambda_table_at(const ff_ndf_pass *pass, const double *restrict rows, size_t n, const double *restrict v,
                        double *restrict lam, double *restrict dlam, double *const *dlam_own)
{
    const double lo = pass->c[C_LO], hi = pass->c[C_HI], inv_lo = 1 / lo;
    const size_t bins = (size_t)pass->c[C_BINS];
    const int64_t first = (int64_t)pass->c[C_FIRST];
    places at;
    double below[FF_BLOCK], inv_width[FF_BLOCK], f[FF_BLOCK], d[FF_BLOCK];
    int64_t above = 0;
    for (size_t i = 0; i < n; i++) {
        const double x = v[i] < lo ? lo : v[i] > hi ? hi : v[i];
        const uint64_t b = ff_bits(x);
        at.bin[i] = (int64_t)(b >> 48) - first;
        at.u[i] = ff_from_bits((b << 4 & UINT64_C(0x000fffffffffffff)) | UINT64_C(0x3ff0000000000000)) - 1;
        inv_width[i] = ff_from_bits((UINT64_C(2050) - (b >> 52)) << 52); /* 16 / 2^e */
        below[i] = v[i] < lo ? v[i] * inv_lo : 1;
        above += v[i] > hi ? 1 : 0;
    }
    interpolate(rows, bins, n, &at, f, d);
    for (size_t i = 0; i < n; i++) {
        lam[i] = (f[i] > 0 ? f[i] : 0) * below[i]; /* a Lambda of 1e-10 may have been interpolated to one below 0 */
        dlam[i] = v[i] < lo ? f[i] * inv_lo : d[i] * inv_width[i];
    }
    const int n_own = dlam_own ? (int)pass->c[C_OWN] : 0;
    for (int k = 0; k < n_own; k++) {
        double *restrict own = dlam_own[k];
        interpolate_value(rows + (size_t)(k + 1) * 6 * bins, bins, n, &at, f);
        for (size_t i = 0; i < n; i++) own[i] = f[i] * below[i];
    }
    if (above == 0) return;
    for (size_t i = 0; i < n; i++) {
        const double ratio = v[i] > hi ? v[i] / hi : 1, root = sqrt(ratio);
        lam[i] = v[i] > hi ? (lam[i] + 0.5) * root - 0.5 : lam[i]; /* mu Lambda = A - mu / 2 where mu is small */
        dlam[i] = v[i] > hi ? 0.5 * (lam[i] + 0.5) / v[i] : dlam[i];
        for (int k = 0; k < n_own; k++) dlam_own[k][i] *= root;
    }
}
