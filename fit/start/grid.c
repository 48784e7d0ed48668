/* Where the search for a start looks: shapes on a grid, ellipses about the best of them, and other places for one lobe among the
 * others. The channel parameters are solved for at each. The same data give the same candidates. */
#include "internal_start.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- many shapes ----------------------------------------------------------------------------- */

/* Evaluates a list of shapes, spread over the pool. */
typedef struct scan {
    const ff_plan *plan;
    const ff_layout *l; /* the plan's                                        */
    ff_candidate *candidate;
    double *channel;   /* [threads][n_channels n_channel + 1]            */
    ff_status *status; /* [threads]                                      */
    uint32_t off;      /* bit set of lobes that are not there; l frees nothing of theirs */
} scan;

static void scan_one(void *context, size_t i, int worker)
{
    const scan *s = context;
    const size_t size = s->l->n_channels * s->l->m->n_channel;
    double *channel = s->channel + (size_t)worker * (size + 1);
    if (ff_plan_cancelled(s->plan)) {
        s->status[worker] = FF_ERR_CANCELLED;
        return;
    }
    ff_layout_channel_defaults(s->l, channel); /* those that are held */
    for (uint32_t lobe = 0; lobe < s->l->m->n_lobes; lobe++)
        for (size_t c = 0; c < s->l->n_channels && (s->off >> lobe & 1); c++)
            channel[c * s->l->m->n_channel + s->l->m->lobe[lobe].channel0 + s->l->m->lobe[lobe].n_channel - 1] = 0;
    const ff_status status = ff_start_channels(s->plan, s->candidate[i].shape, channel, &s->candidate[i].cost2);
    if (status) s->status[worker] = status;
}

static ff_status scan_all(const scan *s, ff_candidate *candidate, size_t n)
{
    scan here = *s;
    here.candidate = candidate;
    const int threads = ff_pool_threads(s->plan->p->pool);
    for (int t = 0; t < threads; t++) s->status[t] = FF_OK;
    ff_pool_run(s->plan->p->pool, n, scan_one, &here);
    for (int t = 0; t < threads; t++)
        if (s->status[t]) return s->status[t];
    return FF_OK;
}

/* Ties are broken by the shape itself, so that the order does not depend on the sort. */
static int by_cost(const void *a, const void *b)
{
    const ff_candidate *x = a, *y = b;
    if (x->cost2 != y->cost2) return x->cost2 < y->cost2 ? -1 : 1;
    // NOLINTNEXTLINE(bugprone-suspicious-memory-comparison): any order will do
    return memcmp(x->shape, y->shape, sizeof x->shape);
}

static void sort(ff_candidate *c, size_t n)
{
    qsort(c, n, sizeof *c, by_cost);
}

static void scan_free(scan *s)
{
    free(s->channel);
    free(s->status);
}

static ff_status scan_new(const ff_plan *plan, scan *s)
{
    const ff_layout *l = &plan->l;
    const size_t threads = (size_t)ff_pool_threads(plan->p->pool);
    *s = (scan){.plan = plan, .l = l};
    s->channel = malloc(threads * (l->n_channels * l->m->n_channel + 1) * sizeof *s->channel);
    s->status = malloc(threads * sizeof *s->status);
    if (s->channel && s->status) return FF_OK;
    scan_free(s);
    return FF_ERR_MEMORY;
}

/* ---- grids ----------------------------------------------------------------------------------- */

/* Is it a lobe's roughness, of which a measurement resolves no less than 0.002? */
static int is_roughness(const ff_model *m, uint32_t shape)
{
    const ff_model_param *p = &m->shape[shape];
    return p->lobe < m->n_lobes && shape == m->lobe[p->lobe].shape0 && ff_ndf_at(m->lobe[p->lobe].ndf)->alpha_own >= 0 &&
           strncmp(p->info->name, "alpha", 5) == 0;
}

static void search_range(const ff_layout *l, uint32_t k, double lowest, double *lo, double *hi)
{
    const ff_model_param *p = &l->m->shape[l->free.shape[k]];
    *lo = ff_coordinate(p->info, p->lo);
    *hi = ff_coordinate(p->info, p->hi);
    if (is_roughness(l->m, l->free.shape[k]) && *hi > log(lowest)) *lo = fmax(*lo, log(lowest));
}

/* Free parameters that a search goes through point by point: the scale of each lobe and what shapes its profile. Aspect,
 * correlation, mean slope and the rest come after. */
static int is_searched(const ff_layout *l, uint32_t k)
{
    const ff_model *m = l->m;
    const uint32_t at = l->free.shape[k], lobe = m->shape[at].lobe;
    if (lobe >= m->n_lobes || l->shape_follows[k] >= 0) return 0;
    const ff_ndf *ndf = ff_ndf_at(m->lobe[lobe].ndf);
    const uint32_t i = at - m->lobe[lobe].shape0; /* first the scale, last the own parameters, between them the stretch */
    const uint32_t own = ndf->stretch ? 0 : m->lobe[lobe].isotropic ? 1 : FF_STRETCH_COUNT;
    return i == 0 || (i >= own && i < own + (uint32_t)ndf->n_own);
}

uint32_t ff_start_searched(const ff_layout *l)
{
    uint32_t n = 0;
    for (uint32_t k = 0; k < l->free.n_shape; k++) n += (uint32_t)is_searched(l, k);
    return n;
}

/* Is it the parameter that orders the lobes? */
static int is_scale(const ff_layout *l, uint32_t k)
{
    return l->free.shape[k] == l->m->lobe[l->m->shape[l->free.shape[k]].lobe].shape0;
}

/* Sets parameter k of a shape, and alpha_y with alpha_x unless it is held. */
static void set_point(const ff_layout *l, uint32_t k, double coordinate, double *shape)
{
    const uint32_t i = l->free.shape[k];
    const ff_param *info = l->m->shape[i].info;
    shape[i] = ff_coordinate_value(info, coordinate);
    if (strcmp(info->name, "alpha_x") != 0) return;
    if (l->free.tied[k] || !(l->m->shape[i + 1].flags & FF_PARAM_HELD)) shape[i + 1] = shape[i];
}

/* Points along each free shape parameter; the first runs fastest. A parameter of one point stays where it is. */
typedef struct grid {
    size_t size[FF_MAX_SHAPE], total;
    double lowest; /* roughness */
} grid;

/* Over all lobes, so that the whole stays near a thousand and never exceeds max. */
static grid grid_of_all(const ff_layout *l, size_t max)
{
    const size_t for_lobes[FF_MAX_LOBES + 1] = {1, 22, 13, 8};
    grid g = {.total = 1, .lowest = 0.002};
    for (uint32_t k = 0; k < l->free.n_shape; k++) {
        g.size[k] = !is_searched(l, k) ? 1 : is_scale(l, k) ? for_lobes[l->m->n_lobes] : l->m->n_lobes > 1 ? 3 : 7;
        g.total *= g.size[k];
    }
    while (g.total > max) { /* the finest becomes coarser */
        uint32_t most = 0;
        for (uint32_t k = 1; k < l->free.n_shape; k++)
            if (g.size[k] > g.size[most]) most = k;
        g.total = g.total / g.size[most] * (g.size[most] - 1);
        g.size[most]--;
    }
    return g;
}

/* Over the shape of one lobe. */
static grid grid_of_lobe(const ff_layout *l, uint32_t lobe)
{
    grid g = {.total = 1, .lowest = 1e-4};
    for (uint32_t k = 0; k < l->free.n_shape; k++) {
        const int here = is_searched(l, k) && l->m->shape[l->free.shape[k]].lobe == lobe;
        g.size[k] = !here ? 1 : is_scale(l, k) ? 24 : 4;
        g.total *= g.size[k];
    }
    return g;
}

enum { FF_ENDS_FROM = 7 };

static void grid_point(const ff_layout *l, const grid *g, size_t code, double *shape)
{
    for (uint32_t k = 0; k < l->free.n_shape; k++) {
        if (g->size[k] <= 1) continue;
        const size_t step = code % g->size[k];
        code /= g->size[k];
        double lo, hi;
        search_range(l, k, g->lowest, &lo, &hi);
        /* in the middles of cells; what shapes a profile, where its points are many, at the ends too: a simpler one is there */
        const int ends = !is_scale(l, k) && g->size[k] >= FF_ENDS_FROM;
        const double at = ends ? (double)step / (double)(g->size[k] - 1) : ((double)step + 0.5) / (double)g->size[k];
        set_point(l, k, lo + (hi - lo) * at, shape);
    }
}

/* Lobes of the same kind are ordered by their scale, narrowest first. */
static int is_ordered(const ff_plan *plan, const double *shape)
{
    const ff_layout *l = &plan->l;
    for (uint32_t a = 1; a < l->m->n_lobes; a++) {
        const ff_lobe *x = &l->m->lobe[a - 1], *y = &l->m->lobe[a];
        if (shape[x->shape0] >= shape[y->shape0] && ff_plan_exchangeable(plan, a - 1, a)) return 0;
    }
    return 1;
}

/* Is no neighbour of a point lower, diagonal ones included? cost2 [g->total], infinite where there is no point. */
static int is_minimum(const ff_layout *l, const grid *g, const double *cost2, size_t code)
{
    size_t around = 1, n = l->free.n_shape;
    for (size_t k = 0; k < n; k++) around *= g->size[k] > 1 ? 3 : 1;
    for (size_t a = 0; a < around; a++) {
        size_t rest = code, turn = a, stride = 1, at = 0;
        int inside = 1;
        for (size_t k = 0; k < n; k++) {
            if (g->size[k] <= 1) continue;
            const size_t step = rest % g->size[k];
            rest /= g->size[k];
            const size_t to = step + turn % 3; /* one more than the neighbour's */
            turn /= 3;
            inside &= to >= 1 && to <= g->size[k];
            at += (to - 1) * stride;
            stride *= g->size[k];
        }
        if (inside && (at < code ? cost2[at] <= cost2[code] : cost2[at] < cost2[code])) return 0;
    }
    return 1;
}

/* The local minima of a grid about `from`, best first, and where there are fewer than `fill` the best of the others; at most max.
 */
static ff_status grid_minima(const scan *s, const grid *g, const double *from, int ordered, ff_candidate *out, size_t fill,
                             size_t max, size_t *n_out)
{
    const ff_layout *l = s->l;
    ff_candidate *c = malloc((g->total + 1) * sizeof *c);
    double *cost2 = malloc((g->total + 1) * sizeof *cost2);
    size_t *place = malloc((g->total + 1) * sizeof *place), n = 0, kept = 0;
    ff_status status = c && cost2 && place ? FF_OK : FF_ERR_MEMORY;
    for (size_t code = 0; code < g->total && !status; code++) {
        memset(&c[n], 0, sizeof c[n]);
        memcpy(c[n].shape, from, l->m->n_shape * sizeof *from);
        grid_point(l, g, code, c[n].shape);
        ff_layout_candidate(l, c[n].shape);
        cost2[code] = INFINITY;
        if (ordered && !is_ordered(s->plan, c[n].shape)) continue;
        place[n++] = code;
    }
    if (!status) status = scan_all(s, c, n);
    for (size_t i = 0; i < n && !status; i++) cost2[place[i]] = c[i].cost2;
    for (size_t i = 0; i < n && !status; i++)
        if (is_minimum(l, g, cost2, place[i])) { /* to the front */
            const ff_candidate here = c[i];
            c[i] = c[kept];
            c[kept++] = here;
        }
    if (!status) {
        sort(c, kept);
        sort(c + kept, n - kept);
        *n_out = kept < max ? kept : max;
        memcpy(out, c, *n_out * sizeof *c);
        for (size_t i = kept; i < n && *n_out < fill; i++) out[(*n_out)++] = c[i];
    }
    free(c);
    free(cost2);
    free(place);
    return status;
}

/* ---- ellipses -------------------------------------------------------------------------------- */

enum { FF_ASPECTS = 4, FF_TURNS = 8, FF_ELLIPSES = FF_ASPECTS * FF_TURNS };

/* Ellipses of the same area about a candidate: aspect ratios and, when correlated, orientations. Other areas come with the other
 * candidates. */
static size_t fill_ellipses(const ff_layout *l, const ff_candidate *from, uint32_t lobe, int correlated, ff_candidate *out)
{
    static const double aspects[FF_ASPECTS] = {1.6, 2.8, 6, 40};
    const int turns = correlated ? FF_TURNS : 2;
    size_t n = 0;
    const uint32_t ix = l->m->lobe[lobe].shape0;
    const double alpha = from->shape[ix], highest = l->m->shape[ix].hi;
    for (size_t a = 0; a < FF_ASPECTS; a++)
        for (int t = 0; t < turns; t++) {
            const double phi = 3.14159265358979323846 * t / turns, c = cos(phi), d = sin(phi);
            const double major2 = alpha * alpha * aspects[a], minor2 = alpha * alpha / aspects[a];
            const double xx = major2 * c * c + minor2 * d * d, yy = major2 * d * d + minor2 * c * c;
            ff_candidate *o = &out[n++];
            *o = *from;
            o->shape[ix] = fmin(sqrt(xx), highest);
            o->shape[ix + 1] = fmin(sqrt(yy), highest);
            if (correlated) o->shape[ix + 2] = (major2 - minor2) * c * d / sqrt(xx * yy);
            ff_layout_candidate(l, o->shape);
        }
    return n;
}

/* 0: the lobe is round, or an axis is held; 1: the axes are free; 2: so is their direction. */
static int ellipse_freedom(const ff_layout *l, uint32_t lobe)
{
    int is_free[3] = {0};
    for (uint32_t k = 0; k < l->free.n_shape; k++)
        for (uint32_t j = 0; j < 3; j++) is_free[j] |= l->free.shape[k] == l->m->lobe[lobe].shape0 + j;
    return l->mode == FF_ISOTROPIC_MODE || l->m->lobe[lobe].isotropic || !is_free[0] || !is_free[1] ? 0 : 1 + is_free[2];
}

/* Each of the n candidates becomes the best of itself and its ellipses. */
static ff_status stretch(const scan *s, uint32_t lobe, ff_candidate *c, size_t n)
{
    const int freedom = ellipse_freedom(s->l, lobe);
    if (!freedom || n == 0) return FF_OK;
    ff_candidate *e = malloc(n * FF_ELLIPSES * sizeof *e);
    if (!e) return FF_ERR_MEMORY;
    size_t each = 0;
    for (size_t i = 0; i < n; i++) each = fill_ellipses(s->l, &c[i], lobe, freedom > 1, e + i * each);
    const ff_status status = scan_all(s, e, n * each);
    for (size_t i = 0; i < n * each && !status; i++)
        if (by_cost(&e[i], &c[i / each]) < 0) c[i / each] = e[i];
    free(e);
    return status;
}

/* ---- the searches ---------------------------------------------------------------------------- */

ff_status ff_start_search(const ff_plan *plan, ff_candidate *out, size_t max, size_t *n_out)
{
    const ff_layout *l = &plan->l;
    enum { MAX_GRID = 4096 };
    double defaults[FF_MAX_SHAPE];
    scan s;
    size_t n = 0;
    ff_status status = scan_new(plan, &s);
    if (status) return status;
    ff_layout_defaults(l, defaults, NULL);
    const grid g = grid_of_all(l, MAX_GRID);
    status = grid_minima(&s, &g, defaults, 1, out, max, max, &n);
    for (uint32_t lobe = 0; lobe < l->m->n_lobes && !status; lobe++) status = stretch(&s, lobe, out, n);
    scan_free(&s);
    if (status) return status;
    sort(out, n);
    *n_out = n;
    return FF_OK;
}

/* D of a lobe at the normal: the narrower the lobe, the higher. */
static double peak(const ff_layout *l, const double *shape, uint32_t lobe)
{
    static const double none = 0, one = 1;
    double channel[FF_MAX_CHANNEL_PARAMS], d = 0;
    ff_model_defaults(l->m, 1, NULL, channel);
    const ff_dirs normal = {&none, &none, &one, &none, &none, &one};
    const ff_terms terms = {.d = &d};
    return ff_model_terms(l->m, FF_ISA_BEST, 1, shape, channel, lobe, 0, &normal, 1, &terms) ? 0 : d;
}

/* The best of the narrowest shapes of a lobe: it may lie between the samples, which then see its tails alone. Not a minimum of the
 * grid, since the narrower the lobe the less changes. */
static ff_status narrowest(const scan *s, const grid *g, const double *from, uint32_t lobe, ff_candidate *out)
{
    enum { WIDTHS = 3 };
    const ff_layout *l = s->l;
    const size_t width = l->m->lobe[lobe].shape0;
    size_t n = 1; /* points along the width, which runs fastest */
    for (uint32_t k = 0; k < l->free.n_shape; k++)
        if (l->free.shape[k] == width) n = g->size[k];
    const size_t middle = n * (g->total / n / 2);
    double low[FF_MAX_SHAPE], high[FF_MAX_SHAPE];
    memcpy(low, from, l->m->n_shape * sizeof *from);
    memcpy(high, from, l->m->n_shape * sizeof *from);
    grid_point(l, g, middle, low);
    grid_point(l, g, middle + n - 1, high);
    const int rises = peak(l, low, lobe) > peak(l, high, lobe);
    ff_candidate c[WIDTHS];
    memset(c, 0, sizeof c);
    for (size_t k = 0; k < WIDTHS; k++) {
        const size_t step = 2 * k < n ? 2 * k : n - 1;
        memcpy(c[k].shape, from, l->m->n_shape * sizeof *from);
        grid_point(l, g, middle + (rises ? step : n - 1 - step), c[k].shape);
        ff_layout_candidate(l, c[k].shape);
    }
    ff_status status = scan_all(s, c, WIDTHS);
    if (!status) status = stretch(s, lobe, c, WIDTHS);
    if (status) return status;
    sort(c, WIDTHS);
    *out = c[0];
    return FF_OK;
}

ff_status ff_start_moves(const ff_plan *plan, const double *from, uint32_t lobe, ff_candidate *out, size_t *n_out)
{
    const ff_layout *l = &plan->l;
    double round[FF_MAX_SHAPE];
    scan s;
    size_t n = 0;
    ff_status status = scan_new(plan, &s);
    if (status) return status;
    memcpy(round, from, l->m->n_shape * sizeof *from);
    if (ellipse_freedom(l, lobe) > 1) round[l->m->lobe[lobe].shape0 + 2] = 0;
    const grid g = grid_of_lobe(l, lobe);
    status = grid_minima(&s, &g, round, 0, out, 0, FF_MOVES - 1, &n);
    if (!status) status = stretch(&s, lobe, out, n);
    if (!status) status = narrowest(&s, &g, round, lobe, &out[n++]);
    scan_free(&s);
    if (status) return status;
    sort(out, n);
    *n_out = n;
    return FF_OK;
}

/* The plan, which has no ties, without what is free of the lobes in `off`. */
static ff_plan without(const ff_plan *plan, uint32_t off)
{
    const ff_layout *l = &plan->l;
    ff_plan without = *plan;
    ff_layout some = *l;
    some.free.n_channel = 0;
    some.scaled &= ~off;
    for (uint32_t k = 0; k < l->free.n_channel; k++) {
        const uint32_t at = l->free.channel[k], lobe = l->m->channel[at].lobe;
        if (lobe < l->m->n_lobes && (off >> lobe & 1)) continue;
        some.free.channel[some.free.n_channel++] = at;
    }
    ff_layout_number(&some);
    without.l = some;
    return without;
}

ff_status ff_start_sequence(const ff_plan *plan, uint32_t first, ff_candidate *out, size_t *n_out)
{
    const ff_layout *l = &plan->l;
    const uint32_t lobes = l->m->n_lobes;
    ff_candidate from[FF_SEQUENCES];
    scan s;
    size_t n = 1;
    ff_status status = scan_new(plan, &s);
    if (status) return status;
    memset(out, 0, sizeof *out);
    ff_layout_defaults(l, out->shape, NULL);
    s.off = (1u << lobes) - 1;
    for (uint32_t k = 0; k < lobes && !status; k++) {
        const uint32_t lobe = (first + k) % lobes;
        s.off &= ~(1u << lobe);
        const ff_plan some = without(plan, s.off);
        const grid g = grid_of_lobe(l, lobe);
        s.plan = &some;
        s.l = &some.l;
        memcpy(from, out, n * sizeof *from);
        size_t all = 0;
        for (size_t i = 0; i < n && !status && all < FF_SEQUENCES; i++) {
            size_t more = 0;
            const size_t left = FF_SEQUENCES - all;
            status = grid_minima(&s, &g, from[i].shape, 0, out + all, 0, left < 2 ? left : 2, &more);
            if (!status) status = stretch(&s, lobe, out + all, more);
            all += more;
        }
        n = all;
    }
    s.plan = plan;
    s.l = l;
    scan_free(&s);
    if (status) return status;
    sort(out, n);
    *n_out = n;
    return FF_OK;
}
