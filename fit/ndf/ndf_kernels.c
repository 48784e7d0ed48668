/* The samples of a range of blocks with a curve for their distribution: residuals, and the outer products of their derivatives.
 * Compiled once per instruction set.
 *
 *   f = F P22 G K + kd / pi,  K = 1 / (4 iz oz hz^4),  P22 = e^psi hz^4 / A
 *
 * With S = P22 G K a raw column's d f is F S times its entry in the stencil of ln P22 or, through ln G, in those of Lambda. */
#include "fit/losses/internal_loss_block.h"
#include "internal_ndf.h"
#include "base/internal_vector_math.h"
#include "models/noise/noise_struct.h"

#define LEAST_COSINE 1e-3 /* as the noise was estimated */

/* ---- the lobe over a block ------------------------------------------------------------------- */

/* Where each sample lies between nodes: the first of four, and what they weigh. */
typedef struct stencils {
    int first[FF_BLOCK];
    double w[4][FF_BLOCK];
} stencils;

typedef struct lobe_block {
    stencils curve, i, o;
    double li[FF_BLOCK], lo[FF_BLOCK], G[FF_BLOCK], gi[FF_BLOCK], go[FF_BLOCK];
    double S[FF_BLOCK], m[FF_BLOCK]; /* P22 G K; (1 - c)^5 */
} lobe_block;

/* asinh of the root of a plane, in steps of a lattice, at most `end`. */
static void places(const double *restrict x2, double scale, double step, double end, double *restrict u)
{
    const double inv_scale2 = 1 / (scale * scale), inv_step = 1 / step;
    for (int i = 0; i < FF_BLOCK; i++) {
        const double x = x2[i] * inv_scale2, at = ff_log(sqrt(x) + sqrt(1 + x)) * inv_step;
        u[i] = at < end ? at : end;
    }
}

/* ln of the value, by the stencils of nodes c. */
static void apply(const stencils *s, const double *restrict c, double *restrict out)
{
    for (int i = 0; i < FF_BLOCK; i++) {
        const double *restrict node = c + s->first[i];
        out[i] = s->w[0][i] * node[0] + s->w[1][i] * node[1] + s->w[2][i] * node[2] + s->w[3][i] * node[3];
    }
}

/* P22 of a block, into S. */
static void block_curve(const ff_ndf_place *at, const ff_geometry *g, lobe_block *b)
{
    double u[FF_BLOCK];
    const double *restrict s2 = g->plane[FF_G_S2], norm = 1 / at->state->area;
    const int top = at->curve->top;
    places(s2, at->curve->scale, at->curve->step, at->curve->end, u);
    for (int i = 0; i < FF_BLOCK; i++) {
        const ff_stencil s = ff_curve_stencil_at(top, u[i]);
        b->curve.first[i] = s.first;
        for (int k = 0; k < 4; k++) b->curve.w[k][i] = s.w[k];
    }
    apply(&b->curve, at->state->c, u);
    for (int i = 0; i < FF_BLOCK; i++) {
        const double inv = ff_recip(1 + s2[i]);
        b->S[i] = ff_exp(u[i]) * inv * inv * norm;
    }
}

/* Lagrange's cubic through four neighbouring nodes; below 0 the table is its mirror image: nodes 1, 0, 1, 2. Beyond the last node
 * Lambda + 1/2 goes as the tangent, as it does for every distribution in the end. A cubic may undershoot 0. */
static void block_lambda(const ff_ndf_place *at, const double *restrict tan2, stencils *s, double *restrict lambda)
{
    double u[FF_BLOCK], ratio[FF_BLOCK];
    const int last = at->curve->n_lambda - 4;
    const double end = at->curve->n_lambda - 1, inv_tan = 1 / at->curve->lambda_tan;
    places(tan2, 1, at->curve->lambda_step, end, u);
    for (int i = 0; i < FF_BLOCK; i++) {
        const double r = sqrt(tan2[i]) * inv_tan;
        ratio[i] = r > 1 ? r : 1;
    }
    for (int i = 0; i < FF_BLOCK; i++) {
        const int k = (int)u[i] - 1, low = k < last ? k : last, folded = low < 0;
        const double a = u[i] - low, b = a - 1, c = a - 2, d = a - 3;
        const double wa = b * c * d * (-1. / 6), wb = a * c * d * 0.5, wc = a * b * d * -0.5, wd = a * b * c * (1. / 6);
        s->first[i] = folded ? 0 : low;
        s->w[0][i] = ratio[i] * (folded ? wb : wa);
        s->w[1][i] = ratio[i] * (folded ? wa + wc : wb);
        s->w[2][i] = ratio[i] * (folded ? wd : wc);
        s->w[3][i] = ratio[i] * (folded ? 0 : wd);
    }
    apply(s, at->state->lambda, lambda);
    for (int i = 0; i < FF_BLOCK; i++) {
        const double l = lambda[i] + 0.5 * (ratio[i] - 1);
        lambda[i] = l > 0 ? l : 0;
    }
}

static void block_lobe(const ff_ndf_place *at, const ff_masking *masking, const ff_geometry *g, lobe_block *b)
{
    const double *restrict K = g->plane[FF_G_K], *restrict cos_h = g->plane[FF_G_C], rise = at->scaled ? 0 : 1;
    block_curve(at, g, b);
    if (at->curve->n_lambda) {
        block_lambda(at, g->plane[FF_G_TI2], &b->i, b->li);
        block_lambda(at, g->plane[FF_G_TO2], &b->o, b->lo);
    }
    masking->eval(at->masking_own, g, FF_BLOCK, b->li, b->lo, b->G, b->gi, b->go, NULL);
    for (int i = 0; i < FF_BLOCK; i++) {
        const double x = 1 - cos_h[i], x2 = x * x;
        b->S[i] *= b->G[i] * K[i];
        b->m[i] = rise * x2 * x2 * x;
    }
}

/* Derivatives of ln S by the raw columns: where each stencil begins, and its four entries. */
typedef struct lobe_row {
    int n; /* stencils: 1, or 3 with Lambda */
    int curve, i, o;
    double of_curve[4], of_i[4], of_o[4];
} lobe_row;

static void row_of(const ff_ndf_place *at, const lobe_block *b, int i, lobe_row *row)
{
    row->curve = b->curve.first[i];
    row->n = at->curve->n_lambda ? 3 : 1;
    for (int k = 0; k < 4; k++) row->of_curve[k] = b->curve.w[k][i];
    if (row->n == 1) return;
    row->i = at->curve->top + 1 + b->i.first[i];
    row->o = at->curve->top + 1 + b->o.first[i];
    for (int k = 0; k < 4; k++) {
        row->of_i[k] = b->gi[i] * b->i.w[k][i];
        row->of_o[k] = b->go[i] * b->o.w[k][i];
    }
}

/* ---- channels -------------------------------------------------------------------------------- */

/* Sums over the channels: what the lobe's outer product and its gradient are multiplied by. */
typedef struct channel_sums {
    double square[FF_BLOCK], score[FF_BLOCK];
} channel_sums;

/* Instead of residuals: what one standard deviation of the noise makes of them. */
static void block_noise(const ff_ndf_place *at, size_t block, size_t channel, const double *restrict f, const double *restrict j,
                        double *restrict r)
{
    const ff_noise *n = at->noise;
    const ff_noise_level *level = ff_noise_of(n, channel);
    const float *restrict cos_i = at->p->cosine[0] + block * FF_BLOCK, *restrict cos_o = at->p->cosine[1] + block * FF_BLOCK;
    for (int i = 0; i < FF_BLOCK; i++) {
        const double ci = cos_i[i] > LEAST_COSINE ? (double)cos_i[i] : LEAST_COSINE,
                     co = cos_o[i] > LEAST_COSINE ? (double)cos_o[i] : LEAST_COSINE;
        const double angles = ff_exp(n->cos_i * ff_log(ci) + n->cos_o * ff_log(co));
        r[i] = j[i] * sqrt(ff_noise_variance(level, f[i]) * angles);
    }
}

/* Adds the products of a channel's two columns, d f / d a and d f / d kd, among themselves; those with the lobe's come later. */
static void block_channel(const ff_ndf_place *at, size_t block, size_t c, const double *x, const lobe_block *b, channel_sums *all,
                          ff_ndf_channel_planes *of, ff_ndf_sums *sums)
{
    const struct ff_problem *p = at->p;
    const ff_loss_planes l = {ff_problem_plane(p, block, p->weight + p->weight_stride * (int)c),
                              ff_problem_plane(p, block, p->target + (int)c), x};
    const double a = at->channel[2 * c], kd = at->channel[2 * c + 1] * (1 / FF_PI);
    double F[FF_BLOCK], f[FF_BLOCK], r[FF_BLOCK], j[FF_BLOCK], cost2 = 0, aa = 0, ad = 0, dd = 0, ga = 0, gd = 0;
    for (int i = 0; i < FF_BLOCK; i++) {
        F[i] = a + (1 - a) * b->m[i];
        f[i] = F[i] * b->S[i] + kd;
    }
    ff_loss_residuals(p->loss, p->linearised, &l, f, r, j);
    if (at->noise) block_noise(at, block, c, f, j, r);
    for (int i = 0; i < FF_BLOCK; i++) {
        const double ja = j[i] * b->S[i] * (1 - b->m[i]), jd = j[i] * (1 / FF_PI), jl = j[i] * b->S[i] * F[i];
        of->a_score[i] = ja * r[i];
        of->kd_score[i] = jd * r[i];
        of->a_lobe[i] = ja * jl;
        of->kd_lobe[i] = jd * jl;
        all->square[i] += jl * jl;
        all->score[i] += jl * r[i];
        cost2 += r[i] * r[i];
        aa += ja * ja;
        ad += ja * jd;
        dd += jd * jd;
        ga += ja * r[i];
        gd += jd * r[i];
    }
    const size_t at_a = sums->n_raw + 2 * c, n = sums->n;
    sums->cost2 += cost2;
    sums->gram[at_a * n + at_a] += aa;
    sums->gram[(at_a + 1) * n + at_a] += ad;
    sums->gram[(at_a + 1) * n + at_a + 1] += dd;
    sums->gradient[at_a] += ga;
    sums->gradient[at_a + 1] += gd;
}

/* ---- outer products -------------------------------------------------------------------------- */

typedef double v4 __attribute__((vector_size(32), aligned(8), may_alias));

static inline void add_four(double weight, const double *v, double *to)
{
    *(v4 *)to += weight * *(const v4 *)v;
}

/* to[columns of the row] += weight v */
static inline void add_row(const lobe_row *row, double weight, double *restrict to)
{
    add_four(weight, row->of_curve, to + row->curve);
    if (row->n == 1) return;
    add_four(weight, row->of_i, to + row->i);
    add_four(weight, row->of_o, to + row->o); /* may be the same columns */
}

/* matrix += weight v v^T: the squares of the stencils and, below the diagonal, the products of Lambda's with the curve's. Those of
 * the two directions' with each other, whose order differs from sample to sample, go to `cross` with the row of wo. */
static void add_square(const lobe_row *row, double weight, size_t n, double *restrict matrix, double *restrict cross)
{
    for (int k = 0; k < 4; k++) {
        const double c = weight * row->of_curve[k];
        add_four(c, row->of_curve, matrix + (size_t)(row->curve + k) * n + row->curve);
    }
    if (row->n == 1) return;
    for (int k = 0; k < 4; k++) {
        const double c = weight * row->of_i[k];
        double *restrict to = matrix + (size_t)(row->i + k) * n;
        add_four(c, row->of_curve, to + row->curve);
        add_four(c, row->of_i, to + row->i);
    }
    for (int k = 0; k < 4; k++) {
        const double c = weight * row->of_o[k];
        double *restrict to = matrix + (size_t)(row->o + k) * n;
        add_four(c, row->of_curve, to + row->curve);
        add_four(c, row->of_o, to + row->o);
        add_four(c, row->of_i, cross + (size_t)(row->o + k) * n + row->i);
    }
}

static void add_score_products(const lobe_row *row, double score, const ff_ndf_channel_planes *channel, int i, ff_ndf_sums *sums)
{
    const size_t n = sums->n, raw = sums->n_raw;
    add_square(row, score * score, n, sums->score_products, sums->products_cross);
    for (size_t c = 0; c < sums->n_channels; c++) {
        const double of[2] = {channel[c].a_score[i], channel[c].kd_score[i]};
        for (size_t k = 0; k < 2; k++) {
            double *to = sums->score_products + (raw + 2 * c + k) * n;
            add_row(row, score * of[k], to);
            for (size_t d = 0; d <= c; d++) {
                to[raw + 2 * d] += of[k] * channel[d].a_score[i];
                to[raw + 2 * d + 1] += of[k] * channel[d].kd_score[i];
            }
        }
    }
}

void FF_ISA_NAME(ff_ndf_blocks)(const ff_ndf_place *at, size_t first, size_t end, int with_products, ff_ndf_channel_planes *channel,
                                ff_ndf_sums *sums);
void FF_ISA_NAME(ff_ndf_blocks)(const ff_ndf_place *at, size_t first, size_t end, int with_products, ff_ndf_channel_planes *channel,
                                ff_ndf_sums *sums)
{
    const struct ff_problem *p = at->p;
    const ff_masking *masking = ff_kernels_get(p->isa)->masking[at->masking];
    lobe_block b;
    lobe_row row;
    ff_geometry g;
    for (size_t block = first; block < end; block++) {
        channel_sums all = {{0}, {0}};
        for (int k = 0; k < FF_G_COUNT; k++) g.plane[k] = p->geometry[k] < 0 ? NULL : ff_problem_plane(p, block, p->geometry[k]);
        block_lobe(at, masking, &g, &b);
        for (size_t c = 0; c < p->n_channels; c++) block_channel(at, block, c, g.plane[FF_G_COS_I], &b, &all, &channel[c], sums);
        for (int i = 0; i < FF_BLOCK; i++) {
            row_of(at, &b, i, &row);
            add_square(&row, all.square[i], sums->n, sums->gram, sums->gram_cross);
            add_row(&row, all.score[i], sums->gradient);
            for (size_t c = 0; c < p->n_channels; c++) {
                double *to = sums->gram + (sums->n_raw + 2 * c) * sums->n;
                add_row(&row, channel[c].a_lobe[i], to);
                add_row(&row, channel[c].kd_lobe[i], to + sums->n);
            }
            if (with_products) add_score_products(&row, all.score[i], channel, i, sums);
        }
    }
}
