/* The order of fits to one problem. */
#include "internal_fitting.h"
#include <math.h>
#include <string.h>

typedef struct ranked {
    const ff_problem *p;
    const ff_fit_result *fit;
} ranked;

/* What fits are ranked by: the objective, or 0 where the fit leaves nothing but rounding. */
static double rank_objective(const ranked *r, size_t i)
{
    const ff_residual *left = &r->fit[i].residual;
    return left->rmse <= FF_FITS_TIE * fabs(ff_problem_selected(r->p)->top) ? 0 : left->objective;
}

/* NaN, of a fit that never came to an end, goes last. */
static int is_better(const ranked *r, size_t i, size_t k)
{
    const double a = rank_objective(r, i), b = rank_objective(r, k);
    return a < b || (!isnan(a) && isnan(b));
}

/* Numbers that the fit could move, those that ended on a bound among them. */
static size_t count_parameters(const ff_fit_result *f)
{
    size_t n = 0;
    for (size_t k = 0; k < f->model.n_shape; k++) n += !f->shape_value[k].held && !f->shape_value[k].tied;
    for (size_t k = 0; k < f->n_channels * f->model.n_channel; k++) n += !f->channel_value[k].held && !f->channel_value[k].tied;
    return n;
}

/* Of two whose objectives are equal but for rounding: fewer parameters, then the name. */
static int is_simpler(const ranked *r, size_t i, size_t k)
{
    const size_t n[2] = {count_parameters(&r->fit[i]), count_parameters(&r->fit[k])};
    char name[2][FF_MODEL_NAME];
    if (n[0] != n[1]) return n[0] < n[1];
    ff_model_expression(&r->fit[i].model, name[0], FF_MODEL_NAME);
    ff_model_expression(&r->fit[k].model, name[1], FF_MODEL_NAME);
    return strcmp(name[0], name[1]) < 0;
}

/* What is neither before the other keeps its order. */
static void sort(const ranked *r, size_t *rank, size_t n, int (*is_before)(const ranked *, size_t, size_t))
{
    for (size_t i = 1; i < n; i++) {
        const size_t one = rank[i];
        size_t at = i;
        for (; at > 0 && is_before(r, one, rank[at - 1]); at--) rank[at] = rank[at - 1];
        rank[at] = one;
    }
}

/* How many of the sorted fits from the first on are tied with it; 1 of a fit that never came to an end. */
static size_t count_tied(const ranked *r, const size_t *rank, size_t n)
{
    const double most = rank_objective(r, rank[0]) * (1 + FF_FITS_TIE);
    size_t tied = 1;
    while (tied < n && rank_objective(r, rank[tied]) <= most) tied++;
    return tied;
}

void ff_fits_rank(const ff_problem *p, const ff_fit_result *fit, size_t n, size_t *rank)
{
    const ranked r = {p, fit};
    for (size_t i = 0; i < n; i++) rank[i] = i;
    sort(&r, rank, n, is_better);
    for (size_t i = 0, tied; i < n; i += tied) {
        tied = count_tied(&r, rank + i, n - i);
        sort(&r, rank + i, tied, is_simpler);
    }
}

size_t ff_fits_best(const ff_problem *p, const ff_fit_result *fit, size_t n)
{
    const ranked r = {p, fit};
    size_t best = 0;
    for (size_t i = 1; i < n; i++) {
        const double least = rank_objective(&r, best), own = rank_objective(&r, i);
        const int tied = own <= least * (1 + FF_FITS_TIE) && least <= own * (1 + FF_FITS_TIE);
        if (tied ? is_simpler(&r, i, best) : is_better(&r, i, best)) best = i;
    }
    return best;
}
