/* From the data to a start: a search through the shapes, the best of it minimised on fewer samples, and most of the way to the
 * optimum. Nothing is random: the same data give the same start. */
#include "internal_fit.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* A problem that stands for another need not be minimised further than the two differ. */
#define FF_ROUGH 1e-7

/* ---- from a search to a start ---------------------------------------------------------------- */

/* Candidates that are minimised: of a search along one parameter, and of one through several, where minima are more; and how many
 * optima of a stand-in lead on to the model. */
enum {
    FF_CANDIDATES_OF_ONE = 4,
    FF_CANDIDATES = 10,
    FF_OPTIMA = 3,
    FF_MOVES = 3,
    FF_ROUNDS = 4,
    FF_POINTS = FF_OPTIMA + 2 * FF_MAX_LOBES * FF_MOVES
};

/* A point that is minimised on the thin problem: shape and channel parameters, of the stand-in or of the model. */
typedef struct point {
    double cost2, shape[FF_MAX_SHAPE], *channel;
    ff_status status;
} point;

/* Several at once, each on its own thread. */
typedef struct polish {
    const ff_layout *l;
    const ff_standin *standin;
    const struct ff_problem *p;
    const ff_fit_options *o;
    const point *from; /* optima of the stand-in; NULL: `to` are candidates of it */
    point *to;
} polish;

static ff_status minimise(const polish *p, const ff_layout *l, point *at)
{
    ff_solution solution;
    int *at_bound = malloc((l->P + 1) * sizeof *at_bound);
    if (!at_bound) return FF_ERR_MEMORY;
    const ff_status s = ff_solve(l, p->p->thin, p->o, 0, 0, FF_ROUGH, 40, at->shape, at->channel, at_bound, &solution, NULL);
    if (!s) at->cost2 = solution.cost2;
    free(at_bound);
    return s;
}

static void polish_candidate(void *context, size_t i, int worker)
{
    const polish *p = context;
    const ff_layout *l = &p->standin->layout;
    point *at = &p->to[i];
    (void)worker;
    ff_model_defaults(l->m, l->n_channels, NULL, at->channel);
    at->status = ff_start_channels(l, p->p, p->o, at->shape, at->channel, &at->cost2);
    if (!at->status) at->status = minimise(p, l, at);
}

/* From an optimum of the stand-in to one of the model, by the best of the ways between them. */
static void polish_optimum(void *context, size_t i, int worker)
{
    const polish *p = context;
    const ff_layout *l = p->l;
    const size_t size = l->n_channels * l->m->n_channel;
    point *at = &p->to[i];
    double *channel = malloc((size + 1) * sizeof *channel), cost2;
    (void)worker;
    at->cost2 = INFINITY;
    at->status = channel ? FF_OK : FF_ERR_MEMORY;
    for (uint32_t v = 0; v < ff_standin_variants(l) && !at->status; v++) {
        ff_standin_start(l, p->standin, v, p->from[i].shape, p->from[i].channel, at->shape, channel);
        at->status = ff_start_channels(l, p->p, p->o, at->shape, channel, &cost2);
        if (at->status || !(cost2 < at->cost2)) continue;
        at->cost2 = cost2;
        memcpy(at->channel, channel, size * sizeof *channel);
    }
    free(channel);
    if (!at->status) at->status = minimise(p, l, at);
}

/* Those that failed last. */
static int by_cost(const void *a, const void *b)
{
    const point *x = a, *y = b;
    if (!x->status != !y->status) return x->status ? 1 : -1;
    return x->status ? 0 : (x->cost2 > y->cost2) - (x->cost2 < y->cost2);
}

/* Best first; what ended in the same minimum once. Returns how many are left, at most max; the status when none is. */
static ff_status sort_points(point *points, size_t *n, size_t max)
{
    size_t kept = 0;
    if (*n == 0) return FF_ERR_INTERNAL;
    for (size_t i = 0; i < *n; i++)
        if (points[i].status == FF_ERR_CANCELLED || points[i].status == FF_ERR_MEMORY) return points[i].status;
    qsort(points, *n, sizeof *points, by_cost);
    if (points[0].status) return points[0].status;
    for (size_t i = 0; i < *n && kept < max && !points[i].status; i++) {
        if (kept && points[i].cost2 - points[kept - 1].cost2 <= 10 * FF_ROUGH * points[i].cost2) continue;
        const point here = points[i]; /* exchanged, since each has its own channel parameters */
        points[i] = points[kept];
        points[kept++] = here;
    }
    *n = kept;
    return FF_OK;
}

/* What a search works with: points of the stand-in, the first n of them optima, best first. */
typedef struct search {
    polish work;
    size_t n;
    point points[FF_POINTS];
} search;

static ff_status polish_new(search *s, const ff_candidate *candidate, size_t n)
{
    for (size_t i = 0; i < n; i++) memcpy(s->points[s->n + i].shape, candidate[i].shape, sizeof candidate[i].shape);
    s->work.to = s->points + s->n;
    ff_pool_run(s->work.p->pool, n, polish_candidate, &s->work);
    s->n += n;
    return sort_points(s->points, &s->n, FF_OPTIMA);
}

/* Lobes of the best optima are put elsewhere, one at a time, as long as that leads to a better one. */
static ff_status move_lobes(search *s)
{
    const polish *w = &s->work;
    const ff_layout *l = &w->standin->layout;
    ff_status st = FF_OK;
    if (l->m->n_lobes < 2) return FF_OK;
    for (int round = 0; round < FF_ROUNDS && !st; round++) {
        ff_candidate candidate[FF_POINTS - FF_OPTIMA];
        const double before = s->points[0].cost2;
        size_t n = 0;
        for (size_t i = 0; i < s->n && i < 2; i++)
            for (uint32_t lobe = 0; lobe < l->m->n_lobes && !st; lobe++) {
                size_t more = 0;
                st = ff_start_moves(l, w->p, w->o, s->points[i].shape, lobe, candidate + n, FF_MOVES, &more);
                n += more;
            }
        if (!st) st = polish_new(s, candidate, n);
        if (!st && !(s->points[0].cost2 < before * (1 - 10 * FF_ROUGH))) break;
    }
    return st;
}

ff_status ff_search(const ff_layout *l, struct ff_problem *p, const ff_fit_options *o, double *shape, double *channel,
                    ff_error *err)
{
    ff_candidate candidate[FF_CANDIDATES];
    search s;
    point optima[FF_OPTIMA];
    ff_standin standin;
    size_t n = 0;
    const size_t size = l->n_channels * FF_MAX_CHANNEL_PARAMS; /* of either model */
    double *channels = calloc((FF_POINTS + FF_OPTIMA) * size + 1, sizeof *channels);
    ff_status st = channels ? ff_standin_make(l, &standin) : FF_ERR_MEMORY;
    const size_t wanted = ff_start_searched(l) > 1 ? FF_CANDIDATES : FF_CANDIDATES_OF_ONE;
    if (!st) st = ff_start_search(&standin.layout, p, o, candidate, wanted, &n);
    if (!st) {
        for (size_t i = 0; i < FF_POINTS; i++) s.points[i].channel = channels + i * size;
        for (size_t i = 0; i < FF_OPTIMA; i++) optima[i].channel = channels + (FF_POINTS + i) * size;
        s.n = 0;
        s.work = (polish){l, &standin, p, o, NULL, NULL};
        st = polish_new(&s, candidate, n);
    }
    for (uint32_t first = 0; first < standin.model.n_lobes && standin.model.n_lobes > 1 && !st; first++) {
        st = ff_start_sequence(&standin.layout, p, o, first, candidate, &n);
        if (!st) st = polish_new(&s, candidate, n);
    }
    if (!st) st = move_lobes(&s);
    if (!st) {
        const point *best = s.points;
        n = s.n;
        if (!l->linear) {
            s.work.from = s.points;
            s.work.to = optima;
            ff_pool_run(p->pool, n, polish_optimum, &s.work);
            st = sort_points(optima, &n, 1);
            best = optima;
        }
        if (!st) {
            memcpy(shape, best->shape, l->m->n_shape * sizeof *shape);
            memcpy(channel, best->channel, l->n_channels * l->m->n_channel * sizeof *channel);
        }
    }
    free(channels);
    if (st == FF_ERR_CANCELLED) return ff_error_set(err, st, NULL, 0, -1, "cancelled");
    return st ? ff_error_set(err, st, NULL, 0, -1, "the search for a start failed: %s", ff_status_str(st)) : FF_OK;
}

ff_status ff_approach(const ff_layout *l, struct ff_problem *p, const ff_fit_options *o, double *shape, double *channel,
                      ff_error *err)
{
    const struct ff_problem *const levels[2] = {o->start_shape ? p->thin : NULL, p->middle};
    ff_solution solution;
    int *at_bound = malloc((l->P + 1) * sizeof *at_bound);
    ff_status st = at_bound ? FF_OK : ff_error_set(err, FF_ERR_MEMORY, NULL, 0, -1, "out of memory");
    for (int k = 0; k < 2 && !st; k++)
        if (levels[k]) st = ff_solve(l, levels[k], o, k == 1, 0, FF_ROUGH, 100, shape, channel, at_bound, &solution, err);
    free(at_bound);
    return st;
}
