/* One pass over a range of blocks that sums what the uncertainty of many channels is made of: information/arrowhead.c has the
 * formulas. Compiled once per instruction set. The scores of a block are kept, since the influences on the channels need those on
 * the shape, and these all channels. */
#include "internal_block.h"
#include "internal_evaluate.h"
#include "internal_influence.h"

/* out += factor * v */
static void add_scaled(double factor, const double *restrict v, double *restrict out)
{
    for (int i = 0; i < FF_BLOCK; i++) out[i] += factor * v[i];
}

/* lanes[i mod 8] += a[i] b[i] */
static void add_product(const double *restrict a, const double *restrict b, double *restrict lanes)
{
    v8 sum = *(const v8 *)lanes;
    for (int i = 0; i < FF_BLOCK; i += 8) sum += *(const v8 *)(a + i) * *(const v8 *)(b + i);
    *(v8 *)lanes = sum;
}

/* Adds channel c to the shape's scores [S] and keeps its own [K]; squares [P][8] of the scores of single values. Columns of one
 * parameter are added up. */
static void channel_scores(const ff_arrowhead *a, size_t c, ff_influence_scratch *s, double (*restrict shape)[FF_BLOCK],
                           double (*restrict own)[FF_BLOCK], double *squares)
{
    memset(s->local, 0, (a->S + a->K) * sizeof *s->local);
    for (size_t k = 0; k < a->n_columns; k++) {
        const size_t at = a->place[k];
        const double *restrict column = s->column[k], scale = a->scale[at < a->S ? at : at + c * a->K];
        double *restrict score = s->local[at];
        for (int i = 0; i < FF_BLOCK; i++) score[i] += scale * column[i] * s->r[i];
    }
    for (size_t k = 0; k < a->S + a->K; k++) {
        add_product(s->local[k], s->local[k], squares + (k < a->S ? k : k + c * a->K) * 8);
        if (k < a->S)
            add_scaled(1, s->local[k], shape[k]);
        else
            memcpy(own[k - a->S], s->local[k], sizeof *own);
    }
}

/* Sums of the scores [P] over runs of the block: runs [FF_BLOCK / length][P]. */
static void sum_runs(size_t P, size_t length, double (*restrict score)[FF_BLOCK], double *restrict runs)
{
    for (size_t k = 0; k < P; k++)
        for (size_t run = 0; run < FF_BLOCK / length; run++) {
            double sum = 0;
            for (size_t i = run * length; i < (run + 1) * length; i++) sum += score[k][i];
            runs[run * P + k] = sum;
        }
}

/* The influences of the block's samples, and their products. */
static void influences(const ff_arrowhead *a, double (*restrict score)[FF_BLOCK], ff_influence_scratch *s,
                       const ff_influence_sums *sums)
{
    const size_t S = a->S, K = a->K;
    double(*left)[FF_BLOCK] = s->column; /* of the shape's scores by what the channels take up */
    for (size_t k = 0; k < S; k++) {
        add_product(score[k], score[k], sums->whole + k * 8);
        memcpy(left[k], score[k], sizeof *left);
        for (size_t q = 0; q < a->C * K; q++) add_scaled(-a->follow[q * S + k], score[S + q], left[k]);
    }
    for (size_t k = 0; k < S; k++) {
        memset(s->on_shape[k], 0, sizeof s->on_shape[k]);
        for (size_t q = 0; q < S; q++) add_scaled(a->inverse[k * S + q], left[q], s->on_shape[k]);
    }
    for (size_t k = 0; k < S; k++)
        for (size_t q = 0; q <= k; q++) add_product(s->on_shape[k], s->on_shape[q], sums->shape + ff_tri(k, q) * 8);
    for (size_t c = 0; c < a->C; c++) {
        double(*own)[FF_BLOCK] = score + S + c * K, *lanes = sums->channel + c * ff_influence_channel(a) * 8;
        for (size_t k = 0; k < K; k++) {
            memset(s->on_channel[k], 0, sizeof s->on_channel[k]);
            for (size_t q = 0; q < K; q++) add_scaled(a->own[(c * K + k) * K + q], own[q], s->on_channel[k]);
            for (size_t q = 0; q < S; q++) add_scaled(-a->follow[(c * K + k) * S + q], s->on_shape[q], s->on_channel[k]);
        }
        for (size_t k = 0; k < K; k++) {
            for (size_t q = 0; q < S; q++) add_product(s->on_channel[k], s->on_shape[q], lanes + (k * S + q) * 8);
            for (size_t q = 0; q <= k; q++) add_product(s->on_channel[k], s->on_channel[q], lanes + (K * S + ff_tri(k, q)) * 8);
        }
    }
}

void FF_ISA_NAME(ff_influence_chunk)(const ff_pass *pass, const ff_arrowhead *arrowhead, size_t first, size_t n_blocks,
                                     const ff_influence_sums *sums);
void FF_ISA_NAME(ff_influence_chunk)(const ff_pass *pass, const ff_arrowhead *arrowhead, size_t first, size_t n_blocks,
                                     const ff_influence_sums *sums)
{
    const struct ff_problem *p = pass->p;
    double(*score)[FF_BLOCK] = (double(*)[FF_BLOCK])sums->score, robust[8] __attribute__((aligned(64))) = {0};
    ff_influence_scratch *s = sums->work;
    s->model.d = &s->slopes;
    for (size_t block = first; block < first + n_blocks; block++) {
        ff_geometry g;
        for (int k = 0; k < FF_G_COUNT; k++) g.plane[k] = p->geometry[k] < 0 ? NULL : ff_problem_plane(p, block, p->geometry[k]);
        cosines(&g, s->x);
        const double centre = ff_evaluate_begin(pass, block, &g, &s->model, s->average);
        if (arrowhead) memset(score, 0, arrowhead->S * sizeof *score);
        for (size_t c = 0; c < p->n_channels; c++) {
            ff_evaluate_value(pass, &g, c, centre, &s->model, s->average, s->f);
            statistics(s->f, ff_problem_plane(p, block, p->value + (int)c), s->x, ff_problem_plane(p, block, p->sample_weight),
                       sums->stat);
            if (!arrowhead) continue;
            weighted_residuals(pass, block, c, s->x, s->f, s->r, s->j, robust);
            ff_evaluate_columns(pass, c, s->j, centre, &s->model, s->average, s->column);
            channel_scores(arrowhead, c, s, score, score + arrowhead->S + c * arrowhead->K, sums->own);
        }
        if (!arrowhead) continue;
        influences(arrowhead, score, s, sums);
        const size_t length = ff_run_length(p);
        sum_runs(arrowhead->P, length, score, sums->runs + block * (FF_BLOCK / length) * arrowhead->P);
    }
}
