/* The model at every sample of a point, the residual there, and what each sample adds to the objective. */
#include "fit/losses/internal_loss.h"
#include "fit/losses/robust/internal_robust.h"
#include "fit/pass/internal_evaluate.h"
#include "internal_problem.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

static double half_rho(ff_robust robust, double b, double residual, double unit)
{
    return 0.5 * ff_robust_rho(robust, b, residual / unit) * unit * unit;
}

typedef struct evaluation {
    const ff_pass *pass;
    ff_average_work **works; /* [threads], NULL: samples are points */
    double *model, *residual, *cost;
} evaluation;

/* w (g - t), or 0 where the datum is known from one side only and the model is there. */
static double residual_of(const struct ff_problem *p, size_t block, size_t c, size_t i, double g)
{
    const double w = ff_problem_plane(p, block, p->weight + p->weight_stride * (int)c)[i],
                 t = ff_problem_plane(p, block, p->target + (int)c)[i], r = w * (g - t);
    if (p->side < 0) return r;
    return ff_problem_plane(p, block, p->side + (int)c)[i] * r > 0 ? 0 : r;
}

static double factor_of(const struct ff_problem *p, size_t c, size_t i)
{
    return p->factor ? (double)p->factor[c * p->n_blocks * FF_BLOCK + i] : 1;
}

static void evaluate_block(void *context, size_t block, int worker)
{
    const evaluation *e = context;
    const struct ff_problem *p = e->pass->p;
    ff_average_work *work = e->works ? e->works[worker] : NULL;
    const size_t first = block * FF_BLOCK, n = p->n - first < FF_BLOCK ? p->n - first : FF_BLOCK;
    ff_block scratch;
    ff_geometry g;
    double f[FF_BLOCK] __attribute__((aligned(64))), x[FF_BLOCK], of_f[FF_BLOCK];
    scratch.d = NULL;
    for (int k = 0; k < FF_G_COUNT; k++) g.plane[k] = p->geometry[k] < 0 ? NULL : ff_problem_plane(p, block, p->geometry[k]);
    ff_problem_cosines(&g, x);
    const double centre = ff_evaluate_begin(e->pass, block, &g, &scratch, work);
    if (e->cost) memset(e->cost + first, 0, n * sizeof *e->cost);
    for (size_t c = 0; c < p->n_channels; c++) {
        ff_evaluate_value(e->pass, &g, c, centre, &scratch, work, f);
        ff_loss_targets(p->loss, n, f, x, of_f);
        for (size_t i = 0; i < n; i++) {
            const double r = residual_of(p, block, c, i, of_f[i]) * factor_of(p, c, first + i);
            const double unit = p->unit ? (double)p->unit[c * p->n_blocks * FF_BLOCK + first + i] : 1;
            if (e->model) e->model[c * p->n + first + i] = f[i];
            if (e->residual) e->residual[c * p->n + first + i] = r;
            if (e->cost) e->cost[first + i] += half_rho(e->pass->robust, e->pass->robust_scale, r, unit);
        }
    }
}

ff_status ff_point_evaluate(const ff_plan *plan, const ff_point *at, int parallel, double *model, double *residual, double *cost)
{
    const struct ff_problem *p = plan->p;
    ff_plan values = *plan;
    ff_pass pass;
    values.l.free = (ff_wanted){0};
    ff_status status = ff_plan_pass(&values, at->shape, at->channel, &pass);
    if (status) return status;
    evaluation e = {&pass, NULL, model, residual, cost};
    status = ff_evaluate_works(&pass, parallel ? (size_t)ff_pool_threads(p->pool) : 1, &e.works);
    if (parallel && !status)
        ff_pool_run(p->pool, p->n_blocks, evaluate_block, &e);
    else
        for (size_t block = 0; block < p->n_blocks && !status; block++) evaluate_block(&e, block, 0);
    ff_average_works_free(e.works);
    ff_pass_free(&pass);
    return status;
}

/* ---- rows of the Jacobian -------------------------------------------------------------------- */

/* dr/df of channel c where the model is f, [n]. */
static void derivatives(const struct ff_problem *p, size_t block, size_t c, size_t n, const double *f, const double *x, double *j)
{
    const double *w = ff_problem_plane(p, block, p->weight + p->weight_stride * (int)c);
    ff_loss_slopes(p->loss, n, f, x, j);
    for (size_t i = 0; i < n; i++) {
        j[i] *= w[i] * factor_of(p, c, block * FF_BLOCK + i) * (p->multiplier ? (double)p->multiplier[block * FF_BLOCK + i] : 1);
        if (p->side >= 0 && ff_problem_plane(p, block, p->side + (int)c)[i] != 0) j[i] = 0;
    }
    for (size_t i = n; i < FF_BLOCK; i++) j[i] = 0;
}

ff_status ff_point_visit(const ff_plan *plan, const ff_point *at, ff_visitor visit, void *context)
{
    const struct ff_problem *p = plan->p;
    double f[FF_BLOCK] __attribute__((aligned(64))), j[FF_BLOCK] __attribute__((aligned(64))), x[FF_BLOCK];
    ff_pass pass;
    ff_block_work *work = ff_block_work_new(1);
    ff_average_work **works = NULL;
    ff_status status = work ? ff_plan_pass(plan, at->shape, at->channel, &pass) : FF_ERR_MEMORY;
    if (status) {
        free(work);
        return status;
    }
    status = ff_evaluate_works(&pass, 1, &works);
    ff_average_work *average = works ? works[0] : NULL;
    for (size_t block = 0; block < p->n_blocks && !status; block++) {
        const size_t first = block * FF_BLOCK, n = p->n - first < FF_BLOCK ? p->n - first : FF_BLOCK;
        ff_geometry g;
        for (int k = 0; k < FF_G_COUNT; k++) g.plane[k] = p->geometry[k] < 0 ? NULL : ff_problem_plane(p, block, p->geometry[k]);
        ff_problem_cosines(&g, x);
        const double centre = ff_evaluate_begin(&pass, block, &g, &work->block, average);
        for (size_t c = 0; c < p->n_channels; c++) {
            ff_evaluate_value(&pass, &g, c, centre, &work->block, average, f);
            derivatives(p, block, c, n, f, x, j);
            ff_evaluate_columns(&pass, c, j, centre, &work->block, average, work->column);
            visit(context, &(ff_visited){first, n, c, f, j, ff_problem_plane(p, block, p->value + (int)c), work->column});
        }
    }
    free(work);
    ff_average_works_free(works);
    ff_pass_free(&pass);
    return status;
}
