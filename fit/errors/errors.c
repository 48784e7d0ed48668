/* The stage between minimisation and result: the pass that errors and statistics are made of. Of a whole H it is a pass like the
 * others, with sums of the score; of an arrowhead the influences of the samples are summed, which needs H before. */
#include "internal_errors.h"
#include "fit/pass/internal_evaluate.h"
#include "fit/information/internal_storage.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

void ff_influence_chunk_scalar(const ff_pass *pass, const ff_arrowhead *arrowhead, size_t first_block, size_t n_blocks,
                               const ff_influence_sums *sums);
#ifdef FF_HAVE_AVX2
void ff_influence_chunk_avx2(const ff_pass *pass, const ff_arrowhead *arrowhead, size_t first_block, size_t n_blocks,
                             const ff_influence_sums *sums);
#endif
#ifdef FF_HAVE_AVX512
void ff_influence_chunk_avx512(const ff_pass *pass, const ff_arrowhead *arrowhead, size_t first_block, size_t n_blocks,
                               const ff_influence_sums *sums);
#endif

/* ---- the pass over influences ---------------------------------------------------------------- */

typedef struct run {
    const ff_pass *pass;
    const ff_arrowhead *arrowhead;
    ff_influence_chunk_fn kernel;
    size_t n_sums, n_score;
    double *lanes;              /* [threads][n_sums * 8 + n_score] */
    ff_influence_scratch *work; /* [threads]                       */
    double *result;             /* [chunks][n_sums]                */
    double *runs;
} run;

/* Products of influences: of the shape, then of the channels. */
static size_t products(const ff_arrowhead *a)
{
    return a ? a->S * (a->S + 1) / 2 + a->C * ff_influence_channel(a) : 0;
}

/* Sums of a pass: statistics, products, own, whole. */
static size_t all_sums(const ff_arrowhead *a)
{
    return FF_STAT_COUNT + products(a) + (a ? a->P + a->S : 0);
}

static void run_chunk(void *context, size_t chunk, int worker)
{
    const run *r = context;
    const struct ff_problem *p = r->pass->p;
    double *lanes = r->lanes + (size_t)worker * (r->n_sums * 8 + r->n_score);
    ff_influence_sums sums = {.stat = lanes, .shape = lanes + FF_STAT_COUNT * 8, .runs = r->runs, .work = r->work + worker};
    sums.channel = sums.shape + (r->arrowhead ? r->arrowhead->S * (r->arrowhead->S + 1) / 2 * 8 : 0);
    sums.own = sums.shape + products(r->arrowhead) * 8;
    sums.whole = sums.own + (r->arrowhead ? r->arrowhead->P * 8 : 0);
    sums.score = lanes + r->n_sums * 8;
    memset(lanes, 0, r->n_sums * 8 * sizeof *lanes);
    const size_t share = ff_problem_share(p), first = chunk * share, left = p->n_blocks - first;
    r->kernel(r->pass, r->arrowhead, first, left < share ? left : share, &sums);
    double *out = r->result + chunk * r->n_sums;
    for (size_t k = 0; k < r->n_sums; k++) {
        double sum = lanes[k * 8];
        for (size_t i = 1; i < 8; i++) {
            const double v = lanes[k * 8 + i];
            sum = k == FF_STAT_MAX ? fmax(sum, v) : sum + v;
        }
        out[k] = sum;
    }
}

/* The sums of all chunks, merged in their order, into out [all_sums], and those over runs of samples. */
static ff_status influence_pass(const ff_pass *pass, const ff_arrowhead *arrowhead, double *runs, double *out)
{
    const struct ff_problem *p = pass->p;
    const size_t share = ff_problem_share(p), chunks = (p->n_blocks + share - 1) / share,
                 threads = (size_t)ff_pool_threads(p->pool), n_sums = all_sums(arrowhead);
    run r = {
        .pass = pass, .arrowhead = arrowhead, .n_sums = n_sums, .n_score = arrowhead ? arrowhead->P * FF_BLOCK : 0, .runs = runs};
    r.kernel = ff_isa_available(p->isa) ? FF_ISA_PICK(p->isa, ff_influence_chunk) : NULL;
    r.lanes = aligned_alloc(64, (threads * (n_sums * 8 + r.n_score) * sizeof(double) + 63) / 64 * 64);
    r.work = aligned_alloc(64, threads * sizeof *r.work);
    r.result = malloc(chunks * n_sums * sizeof(double));
    ff_average_work **average = NULL;
    ff_status status = !r.kernel ? FF_ERR_UNSUPPORTED : r.lanes && r.work && r.result ? FF_OK : FF_ERR_MEMORY;
    if (!status) status = ff_evaluate_works(pass, threads, &average);
    for (size_t i = 0; i < threads && !status; i++) r.work[i].average = average ? average[i] : NULL;
    if (!status) ff_pool_run(p->pool, chunks, run_chunk, &r);
    memset(out, 0, n_sums * sizeof *out);
    for (size_t c = 0; c < chunks && !status; c++)
        for (size_t k = 0; k < n_sums; k++) {
            const double v = r.result[c * n_sums + k];
            out[k] = k == FF_STAT_MAX ? fmax(out[k], v) : out[k] + v;
        }
    ff_average_works_free(average);
    free(r.lanes);
    free(r.work);
    free(r.result);
    return status;
}

/* ---- the whole ------------------------------------------------------------------------------- */

static ff_status plain_pass(const ff_plan *plan, ff_point *at)
{
    ff_pass pass;
    ff_status status = ff_layout_normal(&plan->l, &at->normal);
    if (!status) status = ff_plan_pass(plan, at->shape, at->channel, &pass);
    if (status) return status;
    at->passes++;
    status = ff_pass_run(&pass, 1, &at->normal);
    ff_pass_free(&pass);
    return status;
}

/* The sums of the score that clusters are chosen by, scaled and in coordinates. */
static ff_status make_room_for_scores(const ff_plan *plan, ff_normal *n)
{
    n->diagonal = 1;
    n->P = plan->l.P;
    n->n_runs = plan->p->n_blocks * (FF_BLOCK / ff_run_length(plan->p));
    free(n->runs);
    n->runs = malloc((n->n_runs * n->P + 1) * sizeof *n->runs);
    return n->runs ? FF_OK : FF_ERR_MEMORY;
}

/* The columns of a pass by the coordinates that they are of. */
static void place_columns(const ff_layout *l, ff_arrowhead *a)
{
    a->n_columns = (size_t)l->free.n_shape + l->free.n_channel;
    for (size_t k = 0; k < a->n_columns; k++) a->place[k] = ff_layout_coordinate(l, 0, k);
}

/* The sums [all_sums] at the point for an arrowhead, which is told where its columns are; NULL: the statistics alone. */
static ff_status sum_influences(const ff_plan *plan, ff_point *at, ff_arrowhead *a, double *sums)
{
    ff_pass pass;
    ff_status status = a ? make_room_for_scores(plan, &at->normal) : FF_OK;
    if (!status) status = ff_plan_pass(plan, at->shape, at->channel, &pass);
    if (status) return status;
    if (a) place_columns(&plan->l, a);
    at->passes++;
    status = influence_pass(&pass, a, at->normal.runs, sums);
    ff_pass_free(&pass);
    return status;
}

/* What the point and the information, NULL: none, keep of the sums. */
static ff_status take_sums(const ff_plan *plan, ff_point *at, ff_information *info, const double *sums)
{
    ff_normal *n = &at->normal;
    memcpy(n->stat, sums, sizeof n->stat);
    if (!info) return FF_OK;
    const ff_arrowhead *a = &info->arrowhead;
    const double *own = sums + FF_STAT_COUNT + products(a);
    memcpy(n->own, own, a->P * sizeof *own);
    memcpy(n->score_products, own + a->P, a->S * sizeof *own); /* a parameter of a channel has one value a sample */
    memcpy(n->score_products + a->S, own + a->S, (a->P - a->S) * sizeof *own);
    return ff_information_finish(info, plan, n, plan->p->n, sums + FF_STAT_COUNT);
}

/* Of an arrowhead: at->normal holds the sums of the plain pass there, or is empty, and is made then. */
static ff_status influences(const ff_plan *plan, ff_point *at)
{
    ff_normal *n = &at->normal;
    ff_status status = n->gram ? FF_OK : plain_pass(plan, at);
    if (!status && plan->errors) status = ff_information_new(plan, n, at->at_bound, &at->information);
    if (status) return status;
    ff_arrowhead *a = plan->errors ? &at->information->arrowhead : NULL;
    double *sums = malloc(all_sums(a) * sizeof *sums);
    status = sums ? sum_influences(plan, at, a, sums) : FF_ERR_MEMORY;
    if (!status) status = take_sums(plan, at, at->information, sums);
    at->has_final = !status;
    free(sums);
    return status;
}

static ff_status scores(const ff_plan *plan, ff_point *at)
{
    ff_status status = at->has_final ? FF_OK : ff_point_pass(plan, at);
    if (status || !plan->errors) return status;
    status = ff_information_new(plan, &at->normal, at->at_bound, &at->information);
    return status ? status : ff_information_finish(at->information, plan, &at->normal, plan->p->n, NULL);
}

ff_status ff_errors(const ff_plan *plan, ff_point *at)
{
    if (at->information) return FF_OK;
    ff_status status = plan->l.arrowhead ? influences(plan, at) : scores(plan, at);
    if (status || !plan->errors || !ff_noise_is_wanted(plan)) return status;
    if (!at->noise) status = ff_noise_find(plan, at, &at->noise);
    return status || !at->noise ? status : ff_noise_errors(plan, at, at->noise, at->information, &at->noise->carriers);
}

/* The products of influences that ff_errors has summed are of the parameters that are not on a bound; of all they are others. */
static ff_status arrowhead_of_all(const ff_plan *plan, ff_point *at, ff_information **out)
{
    ff_information *info = NULL;
    ff_status status = ff_information_new(plan, &at->normal, NULL, &info);
    double *sums = status ? NULL : malloc(all_sums(&info->arrowhead) * sizeof *sums);
    if (!status) status = sums ? sum_influences(plan, at, &info->arrowhead, sums) : FF_ERR_MEMORY;
    if (!status) status = take_sums(plan, at, info, sums);
    free(sums);
    if (status)
        free(info);
    else
        *out = info;
    return status;
}

ff_status ff_errors_of_all(const ff_plan *plan, ff_point *at, ff_information **out)
{
    ff_information *info = NULL;
    ff_status status = plan->l.arrowhead ? arrowhead_of_all(plan, at, &info) : ff_information_new(plan, &at->normal, NULL, &info);
    if (!status && !plan->l.arrowhead) status = ff_information_finish(info, plan, &at->normal, plan->p->n, NULL);
    if (!status && at->noise) status = ff_noise_errors(plan, at, at->noise, info, NULL);
    if (status)
        free(info);
    else
        *out = info;
    return status;
}
