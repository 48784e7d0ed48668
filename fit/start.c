/* Where to start. For given shape parameters the linear ones (f0, kd of every channel) follow from a small bounded least-squares
 * problem, so that only the shape is searched: a grid over it, exact in the rest. The same data give the same candidates. */
#include "internal_fit.h"
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- bounded least squares ------------------------------------------------------------------- */

/* Solves the k x k system A x = b, symmetric positive semidefinite, by elimination with diagonal pivots; a vanishing pivot gives 0.
 */
static void solve_small(double *A, double *b, size_t k, double *x)
{
    double diagonal[FF_MAX_CHANNEL_PARAMS];
    for (size_t i = 0; i < k; i++) diagonal[i] = A[i * k + i];
    for (size_t i = 0; i < k; i++) {
        if (!(A[i * k + i] > 1e-13 * diagonal[i])) {
            A[i * k + i] = 0;
            continue;
        }
        for (size_t r = i + 1; r < k; r++) {
            const double f = A[r * k + i] / A[i * k + i];
            for (size_t c = i; c < k; c++) A[r * k + c] -= f * A[i * k + c];
            b[r] -= f * b[i];
        }
    }
    for (size_t i = k; i-- > 0;) {
        double sum = b[i];
        for (size_t c = i + 1; c < k; c++) sum -= A[i * k + c] * x[c];
        x[i] = A[i * k + i] > 0 ? sum / A[i * k + i] : 0;
    }
}

/* |r + L q|^2 from the packed gram of [L r]. */
static double quadratic(const double *gram, size_t n, const double *q)
{
    double sum = gram[ff_tri(n, n)];
    for (size_t a = 0; a < n; a++) {
        sum += 2 * q[a] * gram[ff_tri(n, a)];
        for (size_t b = 0; b < n; b++) sum += q[a] * q[b] * gram[ff_tri(a, b)];
    }
    return sum;
}

/* The minimum with parameter k at its lower bound (state 0), upper bound (1) or free (2); 0 when it leaves the box. */
static int try_states(const double *gram, size_t n, const double *lo, const double *hi, const int *state, double *q)
{
    size_t free_index[FF_MAX_CHANNEL_PARAMS], k = 0;
    double A[FF_MAX_CHANNEL_PARAMS * FF_MAX_CHANNEL_PARAMS], b[FF_MAX_CHANNEL_PARAMS], x[FF_MAX_CHANNEL_PARAMS];
    for (size_t i = 0; i < n; i++) {
        q[i] = state[i] == 0 ? lo[i] : hi[i];
        if (state[i] == 2) free_index[k++] = i;
    }
    for (size_t r = 0; r < k; r++) {
        b[r] = -gram[ff_tri(n, free_index[r])];
        for (size_t i = 0; i < n; i++)
            if (state[i] != 2) b[r] -= gram[ff_tri(free_index[r], i)] * q[i];
        for (size_t c = 0; c < k; c++) A[r * k + c] = gram[ff_tri(free_index[r], free_index[c])];
    }
    solve_small(A, b, k, x);
    for (size_t r = 0; r < k; r++) {
        if (!(x[r] >= lo[free_index[r]] && x[r] <= hi[free_index[r]])) return 0;
        q[free_index[r]] = x[r];
    }
    return 1;
}

double ff_bounded_least_squares(const double *gram, size_t n, const double *lo, const double *hi, double *q)
{
    int state[FF_MAX_CHANNEL_PARAMS], count = 1;
    double best = INFINITY, trial[FF_MAX_CHANNEL_PARAMS];
    for (size_t i = 0; i < n; i++) count *= 3;
    for (int code = count - 1; code >= 0; code--) { /* all free first: mostly that is the answer */
        for (size_t i = 0, c = (size_t)code; i < n; i++, c /= 3) state[i] = (int)(c % 3);
        if (!try_states(gram, n, lo, hi, state, trial)) continue;
        const double value = quadratic(gram, n, trial);
        if (value < best) {
            best = value;
            memcpy(q, trial, n * sizeof *q);
        }
        if (code == count - 1) break; /* the free minimum lies inside: no bound can do better */
    }
    return best;
}

/* ---- one shape ------------------------------------------------------------------------------- */

/* The bounded minimum of all channels by the gram of their linear columns at `at`; out may be at. Returns the sum of the minima. */
static double step_channels(const ff_model *m, const ff_normal *normal, const double *at, double *out)
{
    const size_t nl = m->n_channel, tri = normal->m1 * (normal->m1 + 1) / 2;
    double sum = 0;
    for (size_t c = 0; c < normal->n_channels; c++) {
        const double *gram = normal->gram + c * tri;
        double lo[FF_MAX_CHANNEL_PARAMS], hi[FF_MAX_CHANNEL_PARAMS], step[FF_MAX_CHANNEL_PARAMS] = {0};
        for (size_t k = 0; k < nl; k++) {
            lo[k] = m->channel[k].info->lo - at[c * nl + k];
            hi[k] = m->channel[k].info->hi - at[c * nl + k];
        }
        sum += nl ? ff_bounded_least_squares(gram, nl, lo, hi, step) : gram[0];
        for (size_t k = 0; k < nl; k++)
            out[c * nl + k] = fmin(fmax(at[c * nl + k] + step[k], m->channel[k].info->lo), m->channel[k].info->hi);
    }
    return sum;
}

/* A pass over a thin problem that leaves the gram of the linear columns. plain: without the robust loss, whose weights mean nothing
 * far from the data. */
static ff_status linear_pass(const ff_layout *l, const struct ff_problem *p, const ff_fit_options *o, const double *shape,
                             const double *channel, int plain, ff_normal *normal)
{
    ff_layout linear = *l; /* no shape columns */
    ff_pass pass;
    linear.n_free = 0;
    ff_layout_pass(&linear, p, o, shape, channel, &pass);
    if (plain) pass.robust = FF_ROBUST_NONE;
    return ff_pass_run(&pass, 0, normal);
}

ff_status ff_start_channels(const ff_layout *l, const struct ff_problem *p, const ff_fit_options *o, const double *shape,
                            double *channel, double *cost2)
{
    enum { STEPS = 4 };
    const size_t size = l->n_channels * l->m->n_channel;
    const int exact = !p->thin_linear->surrogate && o->robust == FF_ROBUST_NONE;
    ff_normal normal = {0};
    ff_status s = ff_normal_new(l->m, 0, l->n_channels, &normal);
    double *trial = calloc(size + 1, sizeof *trial);
    if (!trial) s = s ? s : FF_ERR_MEMORY;
    if (!s) s = linear_pass(l, p->thin_linear, o, shape, trial, 1, &normal);
    if (!s) *cost2 = step_channels(l->m, &normal, trial, channel);
    if (!s && !exact) {
        memcpy(trial, channel, size * sizeof *trial);
        *cost2 = INFINITY;
        for (int step = 0; step <= STEPS && !s; step++) {
            s = linear_pass(l, p->thin, o, shape, trial, 0, &normal);
            if (s) break;
            if (normal.cost2 < *cost2) { /* go on from here */
                *cost2 = normal.cost2;
                memcpy(channel, trial, size * sizeof *trial);
                step_channels(l->m, &normal, channel, trial);
            } else /* too far: half way back */
                for (size_t k = 0; k < size; k++) trial[k] = 0.5 * (trial[k] + channel[k]);
        }
    }
    ff_normal_free(&normal);
    free(trial);
    return s;
}

/* ---- the search ------------------------------------------------------------------------------ */

/* Evaluates a list of shapes, spread over the pool. */
typedef struct scan {
    const ff_layout *l;
    const struct ff_problem *p;
    const ff_fit_options *o;
    ff_candidate *candidate;
    double *channel;   /* [threads][n_channels n_channel] */
    ff_status *status; /* [threads] */
} scan;

static void scan_one(void *context, size_t i, int worker)
{
    const scan *s = context;
    const size_t size = s->l->n_channels * s->l->m->n_channel;
    if (ff_fit_cancelled(s->o)) {
        s->status[worker] = FF_ERR_CANCELLED;
        return;
    }
    const ff_status st = ff_start_channels(s->l, s->p, s->o, s->candidate[i].shape, s->channel + (size_t)worker * (size + 1),
                                           &s->candidate[i].cost2);
    if (st) s->status[worker] = st;
}

/* Ties are broken by the shape itself, so that the order does not depend on the sort. */
static int by_cost(const void *a, const void *b)
{
    const ff_candidate *x = a, *y = b;
    if (x->cost2 != y->cost2) return x->cost2 < y->cost2 ? -1 : 1;
    return memcmp(x->shape, y->shape, sizeof x->shape);
}

static ff_status scan_all(const scan *s, size_t n)
{
    const int threads = ff_pool_threads(s->p->pool);
    for (int t = 0; t < threads; t++) s->status[t] = FF_OK;
    ff_pool_run(s->p->pool, n, scan_one, (void *)s);
    for (int t = 0; t < threads; t++)
        if (s->status[t]) return s->status[t];
    qsort(s->candidate, n, sizeof *s->candidate, by_cost);
    return FF_OK;
}

/* The range that is searched: below alpha = 0.002 a fit may go, no measurement resolves it. */
static void search_range(const ff_param *info, double *lo, double *hi)
{
    *lo = ff_coordinate(info, info->lo);
    *hi = ff_coordinate(info, info->hi);
    if (strcmp(info->name, "alpha_x") == 0) *lo = log(0.002);
}

/* Free parameters that a search goes through point by point: the scale of each lobe and what shapes its profile. Aspect,
 * correlation and mean slope come after. */
static int is_searched(const ff_layout *l, uint32_t k)
{
    const ff_param *info = l->m->shape[l->index[k]].info;
    return (info->flags & FF_PARAM_LOG) && strcmp(info->name, "alpha_y") != 0;
}

/* Is it the parameter that orders the lobes? */
static int is_scale(const ff_layout *l, uint32_t k)
{
    return l->index[k] == l->m->lobe[l->m->shape[l->index[k]].lobe].shape0;
}

/* Sets parameter k of a shape, and alpha_y with alpha_x. */
static void set_point(const ff_layout *l, uint32_t k, double coordinate, double *shape)
{
    const ff_param *info = l->m->shape[l->index[k]].info;
    shape[l->index[k]] = ff_coordinate_value(info, coordinate);
    if (strcmp(info->name, "alpha_x") == 0) shape[l->index[k] + 1] = shape[l->index[k]];
}

/* Points per searched parameter, so that the whole grid stays near a thousand. */
static void grid_sizes(const ff_layout *l, size_t *size)
{
    const size_t for_lobes[FF_MAX_LOBES + 1] = {1, 22, 13, 8};
    for (uint32_t k = 0; k < l->n_free; k++)
        size[k] = !is_searched(l, k) ? 1 : is_scale(l, k) ? for_lobes[l->m->n_lobes] : l->m->n_lobes > 1 ? 3 : 7;
}

/* Lobes of the same kind are ordered by their scale, narrowest first. */
static int is_ordered(const ff_layout *l, const double *shape)
{
    for (uint32_t a = 1; a < l->m->n_lobes; a++) {
        const ff_lobe *x = &l->m->lobe[a - 1], *y = &l->m->lobe[a];
        if (x->ndf == y->ndf && x->masking == y->masking && shape[x->shape0] >= shape[y->shape0]) return 0;
    }
    return 1;
}

static size_t fill_grid(const ff_layout *l, const double *defaults, ff_candidate *out, size_t max)
{
    size_t size[FF_MAX_SHAPE], total = 1, n = 0;
    grid_sizes(l, size);
    for (uint32_t k = 0; k < l->n_free; k++) total *= size[k];
    for (size_t code = 0; code < total && n < max; code++) {
        ff_candidate *c = &out[n];
        memset(c, 0, sizeof *c);
        memcpy(c->shape, defaults, l->m->n_shape * sizeof *defaults);
        size_t rest = code;
        for (uint32_t k = 0; k < l->n_free; k++) {
            const size_t step = rest % size[k];
            rest /= size[k];
            if (size[k] == 1) continue;
            double lo, hi;
            search_range(l->m->shape[l->index[k]].info, &lo, &hi);
            set_point(l, k, lo + (hi - lo) * ((double)step + 0.5) / (double)size[k], c->shape);
        }
        n += (size_t)is_ordered(l, c->shape);
    }
    return n;
}

/* Ellipses of the same area about an isotropic candidate: aspect ratios and, when correlated, orientations. Other areas come with
 * the other candidates. */
static size_t fill_ellipses(const ff_layout *l, const ff_candidate *from, uint32_t lobe, int correlated, ff_candidate *out)
{
    const double aspects[] = {1.6, 2.8, 6};
    const int turns = correlated ? 8 : 2;
    size_t n = 0;
    const uint32_t ix = l->m->lobe[lobe].shape0;
    const double alpha = from->shape[ix], highest = l->m->shape[ix].info->hi;
    for (size_t a = 0; a < 3; a++)
        for (int t = 0; t < turns; t++) {
            const double phi = 3.14159265358979323846 * t / turns, c = cos(phi), d = sin(phi);
            const double major2 = alpha * alpha * aspects[a], minor2 = alpha * alpha / aspects[a];
            const double xx = major2 * c * c + minor2 * d * d, yy = major2 * d * d + minor2 * c * c;
            ff_candidate *o = &out[n++];
            *o = *from;
            o->shape[ix] = fmin(sqrt(xx), highest);
            o->shape[ix + 1] = fmin(sqrt(yy), highest);
            o->shape[ix + 2] = correlated ? (major2 - minor2) * c * d / sqrt(xx * yy) : 0;
        }
    return n;
}

/* Keeps the best `max` candidates that differ from each other by more than a step of the grid in some parameter. */
static size_t keep_distinct(const ff_layout *l, ff_candidate *c, size_t n, size_t max)
{
    size_t kept = 0;
    for (size_t i = 0; i < n && kept < max; i++) {
        int near = 0;
        for (size_t k = 0; k < kept && !near; k++) {
            near = 1;
            for (uint32_t j = 0; j < l->n_free; j++) {
                const ff_param *info = l->m->shape[l->index[j]].info;
                const double d = ff_coordinate(info, c[i].shape[l->index[j]]) - ff_coordinate(info, c[k].shape[l->index[j]]);
                if (fabs(d) > 0.2) near = 0;
            }
        }
        if (!near) c[kept++] = c[i];
    }
    return kept;
}

ff_status ff_start_search(const ff_layout *l, const struct ff_problem *p, const ff_fit_options *o, ff_candidate *out, size_t max,
                          size_t *n_out)
{
    enum { MAX_GRID = 4096, SEEDS = 4 };
    const ff_model *m = l->m;
    const int threads = ff_pool_threads(p->pool), correlated = l->mode != FF_ISOTROPIC_MODE;
    double defaults[FF_MAX_SHAPE];
    ff_model_defaults(m, 1, defaults, NULL);
    ff_candidate *grid = malloc(MAX_GRID * sizeof *grid);
    double *channel = malloc((size_t)threads * (l->n_channels * m->n_channel + 1) * sizeof *channel);
    ff_status *status = malloc((size_t)threads * sizeof *status), s = FF_ERR_MEMORY;
    if (grid && channel && status) {
        const scan sc = {l, p, o, grid, channel, status};
        size_t n = fill_grid(l, defaults, grid, MAX_GRID);
        s = scan_all(&sc, n);
        /* ellipses grow from the best isotropic candidates, lobe by lobe */
        for (uint32_t lobe = 0; lobe < m->n_lobes && !s && correlated; lobe++) {
            int free_y = 0, free_r = 0;
            for (uint32_t k = 0; k < l->n_free; k++) {
                free_y |= l->index[k] == m->lobe[lobe].shape0 + 1;
                free_r |= l->index[k] == m->lobe[lobe].shape0 + 2;
            }
            if (!free_y) continue;
            size_t seeds = keep_distinct(l, grid, n, SEEDS);
            n = seeds;
            for (size_t i = 0; i < seeds; i++) n += fill_ellipses(l, &grid[i], lobe, free_r, grid + n);
            s = scan_all(&sc, n);
        }
        if (!s) {
            n = keep_distinct(l, grid, n, max);
            memcpy(out, grid, n * sizeof *out);
            *n_out = n;
        }
    }
    free(grid);
    free(channel);
    free(status);
    return s;
}
