/* From the data to a start: a search through the shapes, the best of it minimised on fewer samples, and most of the way to the
 * optimum. Nothing is random: the same data give the same start. */
#include "internal_start.h"
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
    FF_OPTIMA = 5,            /* optima of the surrogate that lead on to the model                            */
    FF_MOVED = 2,             /* optima whose lobes are moved                                                */
    FF_ROUNDS = 4,            /* times that they are at most                                                 */
    FF_MOST = FF_MOVED * FF_MAX_LOBES * FF_MOVES,
    FF_POINTS =
        FF_OPTIMA + (FF_MOST > FF_CANDIDATES + FF_MAX_LOBES * FF_SEQUENCES ? FF_MOST : FF_CANDIDATES + FF_MAX_LOBES * FF_SEQUENCES)
};

/* ---- points and their minima ----------------------------------------------------------------- */

/* A point that is minimised on the subsample, of the surrogate or of the model. */
typedef struct trial {
    ff_point at;
    ff_status status;
} trial;

/* Several at once, each on its own thread. */
typedef struct polish {
    const ff_plan *plan;
    const ff_surrogate *surrogate;
    const trial *from; /* optima of the surrogate that lead to `to`, points of the model */
    trial *to;
} polish;

static ff_status minimise(const ff_plan *plan, double tolerance, int steps, ff_point *at)
{
    const ff_plan subsample = ff_plan_on(plan, plan->p->subsample);
    const ff_effort effort = {.tolerance = tolerance, .max_iterations = steps};
    return ff_solve(&subsample, &effort, at, NULL);
}

/* A candidate of the surrogate: its channel parameters and a few steps. */
static void polish_first(void *context, size_t i, int worker)
{
    const polish *p = context;
    const ff_plan *plan = &p->surrogate->plan;
    trial *t = &p->to[i];
    (void)worker;
    ff_layout_channel_defaults(&plan->l, t->at.channel);
    t->status = ff_start_channels(plan, t->at.shape, t->at.channel, &t->at.cost2);
    if (!t->status) t->status = minimise(plan, FF_ROUGHER, FF_FIRST_STEPS, &t->at);
}

static void polish_to_end(void *context, size_t i, int worker)
{
    const polish *p = context;
    (void)worker;
    p->to[i].status = minimise(&p->surrogate->plan, FF_ROUGH, FF_STEPS, &p->to[i].at);
}

/* From an optimum of the surrogate to one of the model, by the best of the ways between them. */
static void polish_optimum(void *context, size_t i, int worker)
{
    const polish *p = context;
    const ff_layout *l = &p->plan->l;
    const size_t size = l->n_channels * l->m->n_channel;
    trial *t = &p->to[i];
    double *channel = malloc((size + 1) * sizeof *channel), cost2;
    (void)worker;
    t->at.cost2 = INFINITY;
    t->status = channel ? FF_OK : FF_ERR_MEMORY;
    for (uint32_t v = 0; v < ff_surrogate_variants(l) && !t->status; v++) {
        ff_surrogate_start(l, p->surrogate, v, p->from[i].at.shape, p->from[i].at.channel, t->at.shape, channel);
        t->status = ff_start_channels(p->plan, t->at.shape, channel, &cost2);
        if (t->status || !(cost2 < t->at.cost2)) continue;
        t->at.cost2 = cost2;
        memcpy(t->at.channel, channel, size * sizeof *channel);
    }
    free(channel);
    if (!t->status) t->status = minimise(p->plan, FF_ROUGH, FF_STEPS, &t->at);
}

/* Those that failed last. */
static int by_cost(const void *a, const void *b)
{
    const trial *x = a, *y = b;
    if (!x->status != !y->status) return x->status ? 1 : -1;
    return x->status ? 0 : (x->at.cost2 > y->at.cost2) - (x->at.cost2 < y->at.cost2);
}

/* Exchanges two, since each has its own channel parameters. */
static void exchange(trial *a, trial *b)
{
    const trial here = *a;
    *a = *b;
    *b = here;
}

/* Best first, without those that failed; the status when all have, or when it is not the points' own. */
static ff_status sort_points(trial *points, size_t *n)
{
    if (*n == 0) return FF_ERR_INTERNAL;
    for (size_t i = 0; i < *n; i++)
        if (points[i].status == FF_ERR_CANCELLED || points[i].status == FF_ERR_MEMORY) return points[i].status;
    qsort(points, *n, sizeof *points, by_cost);
    if (points[0].status) return points[0].status;
    while (points[*n - 1].status) (*n)--;
    return FF_OK;
}

/* Of sorted points those that ended in the same minimum once, at most max. */
static size_t distinct_minima(trial *points, size_t n, size_t max)
{
    size_t kept = 0;
    for (size_t i = 0; i < n && kept < max; i++) {
        if (kept && points[i].at.cost2 - points[kept - 1].at.cost2 <= 10 * FF_ROUGH * points[i].at.cost2) continue;
        exchange(&points[kept++], &points[i]);
    }
    return kept;
}

/* Have the two come to the same place? */
static int is_same(const ff_layout *l, const trial *a, const trial *b)
{
    for (uint32_t k = 0; k < l->free.n_shape; k++) {
        const uint32_t at = l->free.shape[k];
        const ff_param *info = l->m->shape[at].info;
        if (fabs(ff_coordinate(info, a->at.shape[at]) - ff_coordinate(info, b->at.shape[at])) > 0.01) return 0;
    }
    return 1;
}

/* Of sorted points, those that differ from each other and from the `known` ones before them; at most max. */
static size_t distinct_places(const ff_layout *l, trial *points, size_t n, size_t known, size_t max)
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

/* Points of the surrogate: the first n of them are optima, best first. */
typedef struct search {
    ff_surrogate surrogate;
    polish work;
    size_t n;
    trial points[FF_POINTS];
    trial optima[FF_OPTIMA + 1]; /* of the model: those that the surrogate's lead to, and one more */
    ff_candidate candidate[FF_POINTS];
} search;

/* A few steps from each candidate show where it leads; what leads somewhere else is minimised and joins the optima. */
static ff_status add_candidates(search *s, const ff_candidate *candidate, size_t n)
{
    polish *w = &s->work;
    for (size_t i = 0; i < n; i++) memcpy(s->points[s->n + i].at.shape, candidate[i].shape, sizeof candidate[i].shape);
    w->to = s->points + s->n;
    ff_pool_run(w->plan->p->pool, n, polish_first, w);
    ff_status status = sort_points(w->to, &n);
    if (status) return status;
    n = distinct_places(&w->surrogate->plan.l, w->to, n, s->n, FF_CANDIDATES);
    ff_pool_run(w->plan->p->pool, n, polish_to_end, w);
    s->n += n;
    status = sort_points(s->points, &s->n);
    if (!status) s->n = distinct_minima(s->points, s->n, FF_OPTIMA);
    return status;
}

/* Candidates of the grid over all lobes and, where there are several, of one lobe after the other. */
static ff_status first_candidates(search *s)
{
    const ff_plan *plan = &s->work.surrogate->plan;
    const ff_layout *l = &plan->l;
    ff_candidate *candidate = s->candidate;
    size_t n = 0;
    ff_status status = ff_start_search(plan, candidate, ff_start_searched(l) > 1 ? FF_CANDIDATES : FF_CANDIDATES_OF_ONE, &n);
    for (uint32_t first = 0; first < l->m->n_lobes && l->m->n_lobes > 1 && !l->tied && !status; first++) {
        size_t more = 0;
        status = ff_start_sequence(plan, first, candidate + n, &more);
        n += more;
    }
    return status ? status : add_candidates(s, candidate, n);
}

/* Lobes of the best optima are put elsewhere, one at a time, as long as that leads to a better one. A round lobe that is alone has
 * been everywhere already. */
static ff_status move_lobes(search *s)
{
    const ff_plan *plan = &s->work.surrogate->plan;
    const ff_layout *l = &plan->l;
    const int moves = l->m->n_lobes > 1 || (l->m->n_lobes == 1 && l->mode != FF_ISOTROPIC_MODE);
    ff_status status = FF_OK;
    for (int round = 0; round < FF_ROUNDS && moves && !status; round++) {
        ff_candidate *candidate = s->candidate;
        const double before = s->points[0].at.cost2;
        size_t n = 0;
        for (size_t i = 0; i < s->n && i < FF_MOVED; i++)
            for (uint32_t lobe = 0; lobe < l->m->n_lobes && !status; lobe++) {
                size_t more = 0;
                status = ff_start_moves(plan, s->points[i].at.shape, lobe, candidate + n, &more);
                n += more;
            }
        if (!status) status = add_candidates(s, candidate, n);
        if (!(s->points[0].at.cost2 < before * (1 - 10 * FF_ROUGH))) break;
    }
    return status == FF_ERR_CANCELLED || status == FF_ERR_MEMORY ? status
                                                                 : FF_OK; /* whatever else fails here, the optima are there */
}

/* A minimisation creeps along the valley of a conductor and may not come to its end: whether one of the ends is lower is seen from
 * there. spare: a point to work with. */
static ff_status try_valleys(const ff_plan *plan, trial *best, trial *spare)
{
    const ff_layout *l = &plan->l;
    ff_status status = FF_OK;
    for (uint32_t lobe = 0; lobe < l->m->n_lobes; lobe++)
        for (size_t end = 0; end < 2 * l->n_channels && !status; end++) {
            ff_point_set(plan, best->at.shape, best->at.channel, &spare->at);
            if (!ff_surrogate_end_of_valley(l, lobe, end / 2, end % 2, spare->at.channel)) continue;
            status = minimise(plan, FF_ROUGH, FF_STEPS, &spare->at);
            if (!status && spare->at.cost2 < best->at.cost2) exchange(best, spare);
        }
    return status;
}

/* The best optimum of the model. */
static ff_status best_of_model(search *s, const trial **best)
{
    trial *optima = s->optima;
    *best = s->points;
    if (s->work.plan->l.linear) return FF_OK;
    size_t n = s->n;
    s->work.from = s->points;
    s->work.to = optima;
    ff_pool_run(s->work.plan->p->pool, n, polish_optimum, &s->work);
    *best = optima;
    const ff_status status = sort_points(optima, &n);
    return status ? status : try_valleys(s->work.plan, optima, optima + FF_OPTIMA);
}

/* Room for trials of the model and of its surrogate. */
static ff_status make_trials(const ff_plan *plan, trial *t, size_t n)
{
    ff_status status = FF_OK;
    for (size_t i = 0; i < n && !status; i++) status = ff_point_new(plan, &t[i].at);
    return status;
}

static void free_trials(trial *t, size_t n)
{
    for (size_t i = 0; i < n; i++) ff_point_free(&t[i].at);
}

static ff_status search_shapes(search *s, const ff_plan *plan, ff_point *at)
{
    const trial *best = NULL;
    ff_status status = make_trials(&s->work.surrogate->plan, s->points, FF_POINTS);
    if (!status) status = make_trials(plan, s->optima, FF_OPTIMA + 1);
    if (!status) status = first_candidates(s);
    if (!status) status = move_lobes(s);
    if (!status) status = best_of_model(s, &best);
    if (!status) {
        ff_point_set(plan, best->at.shape, best->at.channel, at);
        at->cost2 = best->at.cost2;
    }
    free_trials(s->points, FF_POINTS);
    free_trials(s->optima, FF_OPTIMA + 1);
    return status;
}

/* A search through the shapes, and the best of it minimised on fewer samples; at->cost2 is what it came to. */
static ff_status look_with_f0(const ff_plan *plan, double f0_in_common, ff_point *at)
{
    search *s = calloc(1, sizeof *s);
    if (!s) return FF_ERR_MEMORY;
    ff_status status = ff_surrogate_make(plan, f0_in_common, &s->surrogate);
    s->work = (polish){.plan = plan, .surrogate = &s->surrogate};
    if (!status) {
        status = search_shapes(s, plan, at);
        ff_surrogate_free(&s->surrogate);
    }
    free(s);
    return status;
}

/* Mean over the channels of the Fresnel reflectance of the first lobe at normal incidence. */
static ff_status mean_f0(const ff_plan *plan, const ff_point *at, double *f0)
{
    const double zero = 0, one = 1;
    const ff_dirs up = {&zero, &zero, &one, &zero, &zero, &one};
    ff_status status = FF_OK;
    *f0 = 0;
    for (size_t c = 0; c < plan->l.n_channels && !status; c++) {
        double fresnel = 0;
        status = ff_model_terms(plan->l.m, plan->p->isa, plan->l.n_channels, at->shape, at->channel, 0, c, &up, 1,
                                &(ff_terms){.fresnel = &fresnel});
        *f0 += fresnel / (double)plan->l.n_channels;
    }
    return status;
}

#define USUAL_F0 0.04 /* of a dielectric */

/* Where the surrogate's lobes have one F0 that stays what it is, once more with the one that was found. */
static ff_status look_for_start(const ff_plan *plan, ff_point *at)
{
    ff_point other;
    double f0 = USUAL_F0;
    ff_status status = look_with_f0(plan, f0, at);
    if (status || !ff_surrogate_has_f0_in_common(&plan->l)) return status;
    status = mean_f0(plan, at, &f0);
    if (status || !(f0 > 0 && f0 < 1) || fabs(log(f0 / USUAL_F0)) < log(1.5)) return status;
    status = ff_point_new(plan, &other);
    if (status) return status;
    status = look_with_f0(plan, f0, &other);
    if (!status && other.cost2 < at->cost2) ff_point_set(plan, other.shape, other.channel, at);
    ff_point_free(&other);
    return status == FF_ERR_CANCELLED || status == FF_ERR_MEMORY ? status : FF_OK; /* there is one already */
}

/* Most of the way is gone on fewer samples: from a given start on the subsample, then on the middle one. */
static ff_status approach(const ff_plan *plan, ff_point *at, ff_error *err)
{
    const struct ff_problem *const levels[2] = {plan->start_shape ? plan->p->subsample : NULL, plan->p->middle};
    ff_status status = FF_OK;
    for (int k = 0; k < 2 && !status; k++) {
        if (!levels[k]) continue;
        const ff_plan fewer = ff_plan_on(plan, levels[k]);
        const ff_effort effort = {.parallel = k == 1, .tolerance = FF_ROUGH, .max_iterations = 100};
        status = ff_solve(&fewer, &effort, at, err);
    }
    return status;
}

ff_status ff_start(const ff_plan *plan, ff_point *at, ff_error *err)
{
    if (plan->start_shape) {
        ff_point_set(plan, plan->start_shape, plan->start_channel, at);
        if (plan->bounded) ff_layout_project(&plan->l, at->shape, at->channel);
    } else {
        ff_plan points = *plan; /* one search serves any aperture: what it makes of the lobes is seen to afterwards */
        points.as_points = 1;
        const ff_status status = look_for_start(&points, at);
        if (status == FF_ERR_CANCELLED) return ff_error_set(err, status, NULL, 0, -1, "cancelled");
        if (status == FF_ERR_INTERNAL)
            return ff_error_set(err, FF_ERR_DATA, NULL, 0, -1,
                                "no start has a finite sum of squares above 0: the values are too large or too small to be fitted");
        if (status) return ff_error_set(err, status, NULL, 0, -1, "the search for a start failed: %s", ff_status_str(status));
    }
    ff_status status = plan->start_shape ? FF_OK : ff_start_through(plan, at, err);
    if (!status) status = approach(plan, at, err);
    at->iterations = at->passes = 0; /* those on all samples count */
    return status;
}
