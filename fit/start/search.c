/* From the data to a start: a search through the shapes, the best of it minimised on fewer samples, and most of the way to the
 * optimum. Nothing is random: the same data give the same start. */
#include "fit/internal_fit.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* A problem that stands for another need not be minimised further than the two differ; and to see where a candidate leads takes
 * less. */
#define FF_ROUGH   1e-7
#define FF_ROUGHER 1e-3
enum { FF_STEPS = 40, FF_FIRST_STEPS = 10 };

enum {
    FF_CANDIDATES_OF_ONE = 4, /* of the grid over one parameter                                         */
    FF_CANDIDATES = 10,       /* over several, where minima are more; of those that are minimised to the end */
    FF_OPTIMA = 3,            /* optima of the stand-in that lead on to the model                            */
    FF_MOVED = 2,             /* optima whose lobes are moved                                                */
    FF_ROUNDS = 4,            /* times that they are at most                                                 */
    FF_MOST = FF_MOVED * FF_MAX_LOBES * FF_MOVES,
    FF_POINTS =
        FF_OPTIMA + (FF_MOST > FF_CANDIDATES + FF_MAX_LOBES * FF_SEQUENCES ? FF_MOST : FF_CANDIDATES + FF_MAX_LOBES * FF_SEQUENCES)
};

/* ---- points and their minima ----------------------------------------------------------------- */

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
    const point *from; /* optima of the stand-in that lead to `to`, points of the model */
    point *to;
} polish;

static ff_status minimise(const polish *p, const ff_layout *l, double tolerance, int steps, point *at)
{
    ff_solution solution;
    int *at_bound = malloc((l->P + 1) * sizeof *at_bound);
    if (!at_bound) return FF_ERR_MEMORY;
    const ff_status s = ff_solve(l, p->p->thin, p->o, 0, 0, tolerance, steps, at->shape, at->channel, at_bound, &solution, NULL);
    if (!s) at->cost2 = solution.cost2;
    free(at_bound);
    return s;
}

/* A candidate of the stand-in: its channel parameters and a few steps. */
static void polish_first(void *context, size_t i, int worker)
{
    const polish *p = context;
    const ff_layout *l = &p->standin->layout;
    point *at = &p->to[i];
    (void)worker;
    ff_layout_channel_defaults(l, at->channel);
    at->status = ff_start_channels(l, p->p, p->o, at->shape, at->channel, &at->cost2);
    if (!at->status) at->status = minimise(p, l, FF_ROUGHER, FF_FIRST_STEPS, at);
}

static void polish_to_end(void *context, size_t i, int worker)
{
    const polish *p = context;
    (void)worker;
    p->to[i].status = minimise(p, &p->standin->layout, FF_ROUGH, FF_STEPS, &p->to[i]);
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
    if (!at->status) at->status = minimise(p, l, FF_ROUGH, FF_STEPS, at);
}

/* Those that failed last. */
static int by_cost(const void *a, const void *b)
{
    const point *x = a, *y = b;
    if (!x->status != !y->status) return x->status ? 1 : -1;
    return x->status ? 0 : (x->cost2 > y->cost2) - (x->cost2 < y->cost2);
}

/* Exchanges two, since each has its own channel parameters. */
static void exchange(point *a, point *b)
{
    const point here = *a;
    *a = *b;
    *b = here;
}

/* Best first, without those that failed; the status when all have, or when it is not the points' own. */
static ff_status sort_points(point *points, size_t *n)
{
    if (*n == 0) return FF_ERR_INTERNAL;
    for (size_t i = 0; i < *n; i++)
        if (points[i].status == FF_ERR_CANCELLED || points[i].status == FF_ERR_MEMORY) return points[i].status;
    qsort(points, *n, sizeof *points, by_cost);
    if (points[0].status) return points[0].status;
    while (points[*n - 1].status) --*n;
    return FF_OK;
}

/* Of sorted points those that ended in the same minimum once, at most max. */
static size_t distinct_minima(point *points, size_t n, size_t max)
{
    size_t kept = 0;
    for (size_t i = 0; i < n && kept < max; i++) {
        if (kept && points[i].cost2 - points[kept - 1].cost2 <= 10 * FF_ROUGH * points[i].cost2) continue;
        exchange(&points[kept++], &points[i]);
    }
    return kept;
}

/* Have the two come to the same place? */
static int is_same(const ff_layout *l, const point *a, const point *b)
{
    for (uint32_t k = 0; k < l->free.n_shape; k++) {
        const uint32_t at = l->free.shape[k];
        const ff_param *info = l->m->shape[at].info;
        if (fabs(ff_coordinate(info, a->shape[at]) - ff_coordinate(info, b->shape[at])) > 0.01) return 0;
    }
    return 1;
}

/* Of sorted points, those that differ from each other and from the `known` ones before them; at most max. */
static size_t distinct_places(const ff_layout *l, point *points, size_t n, size_t known, size_t max)
{
    size_t kept = 0;
    for (size_t i = 0; i < n && kept < max; i++) {
        int same = 0;
        for (size_t k = 0; k < known + kept && !same; k++) same = is_same(l, points - known + k, &points[i]);
        if (!same) exchange(&points[kept++], &points[i]);
    }
    return kept;
}

/* ---- the search ------------------------------------------------------------------------------ */

/* Points of the stand-in: the first n of them are optima, best first. */
typedef struct search {
    polish work;
    size_t n;
    point points[FF_POINTS];
} search;

/* A few steps from each candidate show where it leads; what leads somewhere else is minimised and joins the optima. */
static ff_status add_candidates(search *s, const ff_candidate *candidate, size_t n)
{
    polish *w = &s->work;
    for (size_t i = 0; i < n; i++) memcpy(s->points[s->n + i].shape, candidate[i].shape, sizeof candidate[i].shape);
    w->to = s->points + s->n;
    ff_pool_run(w->p->pool, n, polish_first, w);
    ff_status st = sort_points(w->to, &n);
    if (st) return st;
    n = distinct_places(&w->standin->layout, w->to, n, s->n, FF_CANDIDATES);
    ff_pool_run(w->p->pool, n, polish_to_end, w);
    s->n += n;
    st = sort_points(s->points, &s->n);
    if (!st) s->n = distinct_minima(s->points, s->n, FF_OPTIMA);
    return st;
}

/* Candidates of the grid over all lobes and, where there are several, of one lobe after the other. */
static ff_status first_candidates(search *s)
{
    const polish *w = &s->work;
    const ff_layout *l = &w->standin->layout;
    ff_candidate candidate[FF_POINTS];
    size_t n = 0;
    ff_status st = ff_start_search(l, w->p, w->o, candidate, ff_start_searched(l) > 1 ? FF_CANDIDATES : FF_CANDIDATES_OF_ONE, &n);
    for (uint32_t first = 0; first < l->m->n_lobes && l->m->n_lobes > 1 && !l->tied && !st; first++) {
        size_t more = 0;
        st = ff_start_sequence(l, w->p, w->o, first, candidate + n, &more);
        n += more;
    }
    return st ? st : add_candidates(s, candidate, n);
}

/* Lobes of the best optima are put elsewhere, one at a time, as long as that leads to a better one. A round lobe that is alone has
 * been everywhere already. */
static ff_status move_lobes(search *s)
{
    const polish *w = &s->work;
    const ff_layout *l = &w->standin->layout;
    const int moves = l->m->n_lobes > 1 || (l->m->n_lobes == 1 && l->mode != FF_ISOTROPIC_MODE);
    ff_status st = FF_OK;
    for (int round = 0; round < FF_ROUNDS && moves && !st; round++) {
        ff_candidate candidate[FF_MOST];
        const double before = s->points[0].cost2;
        size_t n = 0;
        for (size_t i = 0; i < s->n && i < FF_MOVED; i++)
            for (uint32_t lobe = 0; lobe < l->m->n_lobes && !st; lobe++) {
                size_t more = 0;
                st = ff_start_moves(l, w->p, w->o, s->points[i].shape, lobe, candidate + n, &more);
                n += more;
            }
        if (!st) st = add_candidates(s, candidate, n);
        if (!(s->points[0].cost2 < before * (1 - 10 * FF_ROUGH))) break;
    }
    return st == FF_ERR_CANCELLED || st == FF_ERR_MEMORY ? st : FF_OK; /* whatever else fails here, the optima are there */
}

/* A minimisation creeps along the valley of a conductor and may not come to its end: whether one of the ends is lower is seen from
 * there. spare: a point to work with. */
static ff_status try_valleys(const search *s, point *best, point *spare)
{
    const ff_layout *l = s->work.l;
    const size_t size = l->n_channels * l->m->n_channel;
    ff_status st = FF_OK;
    for (uint32_t lobe = 0; lobe < l->m->n_lobes; lobe++)
        for (size_t end = 0; end < 2 * l->n_channels && !st; end++) {
            memcpy(spare->shape, best->shape, sizeof best->shape);
            memcpy(spare->channel, best->channel, size * sizeof *best->channel);
            if (!ff_standin_end_of_valley(l, lobe, end / 2, end % 2, spare->channel)) continue;
            st = minimise(&s->work, l, FF_ROUGH, FF_STEPS, spare);
            if (!st && spare->cost2 < best->cost2) exchange(best, spare);
        }
    return st;
}

/* The best optimum of the model; `optima` has room for those that the stand-in's lead to and for one more. */
static ff_status best_of_model(search *s, point *optima, const point **best)
{
    *best = s->points;
    if (s->work.l->linear) return FF_OK;
    size_t n = s->n;
    s->work.from = s->points;
    s->work.to = optima;
    ff_pool_run(s->work.p->pool, n, polish_optimum, &s->work);
    *best = optima;
    const ff_status st = sort_points(optima, &n);
    return st ? st : try_valleys(s, optima, optima + FF_OPTIMA);
}

ff_status ff_search(const ff_layout *l, struct ff_problem *p, const ff_fit_options *o, double *shape, double *channel,
                    ff_error *err)
{
    search s = {.n = 0};
    point optima[FF_OPTIMA + 1];
    const point *best = NULL;
    ff_standin standin = {.limits = NULL};
    const size_t size = l->n_channels * FF_MAX_CHANNEL_PARAMS; /* of either model */
    double *channels = calloc((FF_POINTS + FF_OPTIMA + 1) * size + 1, sizeof *channels);
    ff_status st = channels ? ff_standin_make(l, &standin) : FF_ERR_MEMORY;
    for (size_t i = 0; i < FF_POINTS; i++) s.points[i].channel = channels + i * size;
    for (size_t i = 0; i < FF_OPTIMA + 1; i++) optima[i].channel = channels + (FF_POINTS + i) * size;
    s.work = (polish){.l = l, .standin = &standin, .p = p, .o = o};
    if (!st) st = first_candidates(&s);
    if (!st) st = move_lobes(&s);
    if (!st) st = best_of_model(&s, optima, &best);
    if (!st) {
        memcpy(shape, best->shape, l->m->n_shape * sizeof *shape);
        memcpy(channel, best->channel, l->n_channels * l->m->n_channel * sizeof *channel);
    }
    ff_standin_free(&standin);
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
