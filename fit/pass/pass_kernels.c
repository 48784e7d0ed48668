/* One pass over a range of blocks: model, residuals, Jacobian columns, and their outer products summed in eight lanes.
 * Compiled once per instruction set. The lanes are the same for each, so that the sums differ by the rounding of fused products
 * only. */
#include "internal_block.h"
#include "internal_evaluate.h"

/* ---- outer products -------------------------------------------------------------------------- */

/* Sums of the products of M columns into the packed triangle, all of it in registers. M is a constant at each call. */
static inline __attribute__((always_inline)) void gram_small(const int M, double (*restrict column)[FF_BLOCK], v8 *restrict acc)
{
    v8 sum[28];
#pragma GCC unroll 28
    for (int k = 0; k < M * (M + 1) / 2; k++) sum[k] = acc[k];
    for (int i = 0; i < FF_BLOCK; i += 8) {
        v8 x[7];
        int k = 0;
#pragma GCC unroll 7
        for (int a = 0; a < M; a++) x[a] = *(const v8 *)&column[a][i];
#pragma GCC unroll 7
        for (int a = 0; a < M; a++)
#pragma GCC unroll 7
            for (int b = 0; b <= a; b++) sum[k++] += x[a] * x[b];
    }
#pragma GCC unroll 28
    for (int k = 0; k < M * (M + 1) / 2; k++) acc[k] = sum[k];
}

/* The same for any number of columns, in tiles of 4 x 4. */
static void gram_tiled(size_t m, double (*restrict column)[FF_BLOCK], v8 *restrict acc)
{
    for (size_t a0 = 0; a0 < m; a0 += 4)
        for (size_t b0 = 0; b0 <= a0; b0 += 4) {
            const double *restrict ca[4], *restrict cb[4];
            for (size_t k = 0; k < 4; k++) { /* beyond the last column the first stands in; its products are not stored */
                ca[k] = column[a0 + k < m ? a0 + k : 0];
                cb[k] = column[b0 + k < m ? b0 + k : 0];
            }
            v8 sum[16];
#pragma GCC unroll 16
            for (int k = 0; k < 16; k++) sum[k] = (v8){0};
            for (int i = 0; i < FF_BLOCK; i += 8) {
                v8 x[4], y[4];
#pragma GCC unroll 4
                for (int k = 0; k < 4; k++) {
                    x[k] = *(const v8 *)&ca[k][i];
                    y[k] = *(const v8 *)&cb[k][i];
                }
#pragma GCC unroll 16
                for (int k = 0; k < 16; k++) sum[k] += x[k / 4] * y[k % 4];
            }
            for (size_t k = 0; k < 16; k++) {
                const size_t a = a0 + k / 4, b = b0 + k % 4;
                if (a < m && b <= a) acc[ff_tri(a, b)] += sum[k];
            }
        }
}

static void gram(size_t m, double (*restrict column)[FF_BLOCK], double *restrict lanes)
{
    v8 *acc = (v8 *)lanes;
    switch (m) {
    case 1:
        gram_small(1, column, acc);
        break;
    case 2:
        gram_small(2, column, acc);
        break;
    case 3:
        gram_small(3, column, acc);
        break;
    case 4:
        gram_small(4, column, acc);
        break;
    case 5:
        gram_small(5, column, acc);
        break;
    case 6:
        gram_small(6, column, acc);
        break;
    case 7:
        gram_small(7, column, acc);
        break;
    default:
        gram_tiled(m, column, acc);
    }
}

/* ---- a block --------------------------------------------------------------------------------- */

/* Adds column * r to the score of a parameter, and its square to own [8]. */
static void add_score(const double *restrict column, const double *restrict r, double *restrict score, double *restrict own)
{
    v8 sum = *(const v8 *)own;
    for (int i = 0; i < FF_BLOCK; i += 8) {
        const v8 v = *(const v8 *)(column + i) * *(const v8 *)(r + i);
        *(v8 *)(score + i) += v;
        sum += v * v;
    }
    *(v8 *)own = sum;
}

/* Sums of the scores [P][FF_BLOCK] over runs of the block, of one vector each or of all: runs [FF_BLOCK / length][P]. */
static void sum_runs(size_t P, size_t length, const double *restrict score, double *restrict runs)
{
    _Static_assert(FF_SHORT_RUN == 8 && (int)FF_LONG_RUN == (int)FF_BLOCK, "a run is a vector, or a block");
    for (size_t k = 0; k < P; k++) {
        v8 sum = {0};
        for (size_t i = 0; i < FF_BLOCK / 8; i++) {
            const v8 s = *(const v8 *)(score + k * FF_BLOCK + 8 * i);
            sum += s;
            if (length == FF_SHORT_RUN) runs[i * P + k] = ((s[0] + s[4]) + (s[1] + s[5])) + ((s[2] + s[6]) + (s[3] + s[7]));
        }
        if (length == FF_LONG_RUN) runs[k] = ((sum[0] + sum[4]) + (sum[1] + sum[5])) + ((sum[2] + sum[6]) + (sum[3] + sum[7]));
    }
}

/* x: the cosines, NULL where they are not needed. centre: as ff_evaluate_begin has it. */
static void channel_block(const ff_pass *pass, size_t block, size_t c, const ff_geometry *g, const double *x, double centre,
                          const ff_chunk_sums *sums)
{
    ff_pass_scratch *s = sums->work;
    const ff_prepared *prepared = &pass->prepared;
    const struct ff_problem *p = pass->p;
    const uint32_t n_shape = prepared->wanted.n_shape, n_channel = prepared->wanted.n_channel;
    ff_evaluate_value(pass, g, c, centre, &s->model, s->average, s->f);
    weighted_residuals(pass, block, c, x, s->f, s->r, s->j, sums->cost2);
    ff_evaluate_columns(pass, c, s->j, centre, &s->model, s->average, s->column);
    const size_t n = n_shape + n_channel, m1 = n + 1;
    memcpy(s->column[n], s->r, sizeof s->r);
    gram(m1, s->column, sums->gram + c * (m1 * (m1 + 1) / 2) * 8);
    if (!pass->final) return;
    statistics(s->f, ff_problem_plane(p, block, p->value + (int)c), x, ff_problem_plane(p, block, p->sample_weight), sums->stat);
    for (uint32_t k = 0; pass->errors && k < n; k++) {
        const size_t of = k < n_shape ? k : k + c * n_channel;
        add_score(s->column[k], s->r, sums->score + of * FF_BLOCK, sums->own + of * 8);
    }
}

void FF_ISA_NAME(ff_pass_chunk)(const ff_pass *pass, size_t first, size_t n_blocks, const ff_chunk_sums *sums);
void FF_ISA_NAME(ff_pass_chunk)(const ff_pass *pass, size_t first, size_t n_blocks, const ff_chunk_sums *sums)
{
    const struct ff_problem *p = pass->p;
    const ff_prepared *prepared = &pass->prepared;
    const size_t P = prepared->wanted.n_shape + p->n_channels * prepared->wanted.n_channel;
    const int errors = pass->final && pass->errors;
    const int needs_x = pass->final || (!p->linearised && FF_ISA_NAME(ff_losses)[p->loss]->reads_cosine);
    ff_pass_scratch *s = sums->work;
    s->model.d = &s->slopes;
    for (size_t block = first; block < first + n_blocks; block++) {
        ff_geometry g;
        for (int k = 0; k < FF_G_COUNT; k++) g.plane[k] = p->geometry[k] < 0 ? NULL : ff_problem_plane(p, block, p->geometry[k]);
        if (needs_x) cosines(&g, s->x);
        const double centre = ff_evaluate_begin(pass, block, &g, &s->model, s->average);
        if (errors) memset(sums->score, 0, P * FF_BLOCK * sizeof(double));
        for (size_t c = 0; c < p->n_channels; c++) channel_block(pass, block, c, &g, needs_x ? s->x : NULL, centre, sums);
        if (!errors || !P) continue;
        gram(P, (double(*)[FF_BLOCK])sums->score, sums->score_products);
        const size_t length = ff_run_length(p);
        sum_runs(P, length, sums->score, sums->runs + block * (FF_BLOCK / length) * P);
    }
}
