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

/* The minimum over the free parameters (state 2) with the others at their lower (0) or upper (1) bound; x [n]. */
static void minimise_free(const double *gram, size_t n, const double *lo, const double *hi, const int *state, double *x)
{
    size_t free_index[FF_MAX_CHANNEL_PARAMS], k = 0;
    double A[FF_MAX_CHANNEL_PARAMS * FF_MAX_CHANNEL_PARAMS], b[FF_MAX_CHANNEL_PARAMS], y[FF_MAX_CHANNEL_PARAMS];
    for (size_t i = 0; i < n; i++) {
        x[i] = state[i] == 0 ? lo[i] : hi[i];
        if (state[i] == 2) free_index[k++] = i;
    }
    for (size_t r = 0; r < k; r++) {
        b[r] = -gram[ff_tri(n, free_index[r])];
        for (size_t i = 0; i < n; i++)
            if (state[i] != 2) b[r] -= gram[ff_tri(free_index[r], i)] * x[i];
        for (size_t c = 0; c < k; c++) A[r * k + c] = gram[ff_tri(free_index[r], free_index[c])];
    }
    solve_small(A, b, k, y);
    for (size_t r = 0; r < k; r++) x[free_index[r]] = y[r];
}

/* How far from q towards x all stay in the box, at most 1; the parameter that stops it, and at which bound. */
static double way_to_wall(size_t n, const double *lo, const double *hi, const double *q, const double *x, size_t *which, int *bound)
{
    double step = 1;
    for (size_t i = 0; i < n; i++) {
        const int up = x[i] > hi[i];
        if (!up && !(x[i] < lo[i])) continue;
        const double s = ((up ? hi[i] : lo[i]) - q[i]) / (x[i] - q[i]);
        if (s >= step) continue;
        step = fmax(s, 0);
        *which = i;
        *bound = up;
    }
    return step;
}

/* The parameter at a bound that the objective pulls inside the most, -1 when none does. */
static int pulled_inside(const double *gram, size_t n, const double *q, const int *state)
{
    int which = -1;
    double most = 1e-12;
    for (size_t i = 0; i < n; i++) {
        double slope = gram[ff_tri(n, i)];
        for (size_t k = 0; k < n; k++) slope += gram[ff_tri(i, k)] * q[k];
        const double scale = sqrt(gram[ff_tri(i, i)] * gram[ff_tri(n, n)]);
        const double pull = state[i] == 2 || !(scale > 0) ? 0 : (state[i] ? slope : -slope) / scale;
        if (pull > most) most = pull, which = (int)i;
    }
    return which;
}

/* Active sets: from a point in the box to the minimum over what is free, as far as the walls allow, until no bound is worth leaving
 * (Lawson and Hanson 1974, chapter 23; Stark and Parker 1995). Convex, so that the end is the minimum. */
double ff_bounded_least_squares(const double *gram, size_t n, const double *lo, const double *hi, double *q)
{
    int state[FF_MAX_CHANNEL_PARAMS] = {0};
    double x[FF_MAX_CHANNEL_PARAMS];
    for (size_t i = 0; i < n; i++) {
        state[i] = 2;
        q[i] = fmin(fmax(0, lo[i]), hi[i]);
    }
    for (size_t step = 0; step < 8 * n + 8; step++) {
        size_t wall = 0;
        int bound = 0;
        minimise_free(gram, n, lo, hi, state, x);
        const double way = way_to_wall(n, lo, hi, q, x, &wall, &bound);
        for (size_t i = 0; i < n; i++) q[i] = state[i] == 2 ? fmin(fmax(q[i] + way * (x[i] - q[i]), lo[i]), hi[i]) : x[i];
        if (way < 1) {
            state[wall] = bound;
            q[wall] = bound ? hi[wall] : lo[wall];
            continue;
        }
        const int leave = pulled_inside(gram, n, q, state);
        if (leave < 0) break;
        state[leave] = 2;
    }
    return quadratic(gram, n, q);
}

/* ---- one shape ------------------------------------------------------------------------------- */

/* Is free channel parameter k multiplied by a free scale? */
static int is_scaled(const ff_layout *l, uint32_t k)
{
    const uint32_t at = l->free.channel[k], lobe = l->m->channel[at].lobe;
    return lobe < l->m->n_lobes && (l->scaled >> lobe & 1) && at + 1 < l->m->lobe[lobe].channel0 + l->m->lobe[lobe].n_channel;
}

/* The bounded minimum of all channels by the gram of their columns at `at`; out may be at. products: out gets the products with the
 * free scales, which have no upper bound. Returns the sum of the minima. */
static double step_channels(const ff_layout *l, const ff_normal *normal, const double *at, int products, double *out)
{
    const size_t n = l->free.n_channel, stride = l->m->n_channel, tri = normal->m1 * (normal->m1 + 1) / 2;
    double sum = 0;
    if (l->tied) return ff_tied_least_squares(l, normal, at, out);
    for (size_t c = 0; c < normal->n_channels; c++) {
        const double *gram = normal->gram + c * tri;
        double lo[FF_MAX_CHANNEL_PARAMS], hi[FF_MAX_CHANNEL_PARAMS], step[FF_MAX_CHANNEL_PARAMS] = {0};
        for (size_t k = 0; k < n; k++) {
            const ff_model_param *p = &l->m->channel[l->free.channel[k]];
            const int product = products && is_scaled(l, (uint32_t)k);
            lo[k] = (!product ? p->lo : p->lo < 0 ? -1e9 : 0) - at[c * stride + l->free.channel[k]];
            hi[k] = (product ? 1e9 : p->hi) - at[c * stride + l->free.channel[k]];
        }
        sum += n ? ff_bounded_least_squares(gram, n, lo, hi, step) : gram[0];
        for (size_t k = 0; k < n; k++) {
            const ff_model_param *p = &l->m->channel[l->free.channel[k]];
            const size_t i = c * stride + l->free.channel[k];
            out[i] = at[i] + step[k];
            if (!(products && is_scaled(l, (uint32_t)k))) out[i] = fmin(fmax(out[i], p->lo), p->hi);
        }
    }
    return sum;
}

/* From the products with the free scales to the parameters themselves; a scale is at least what brings these into their box. */
static void divide_by_scales(const ff_layout *l, double *channel)
{
    for (size_t c = 0; c < l->n_channels; c++)
        for (uint32_t lobe = 0; lobe < l->m->n_lobes; lobe++) {
            if (!(l->scaled >> lobe & 1)) continue;
            const uint32_t scale = l->m->lobe[lobe].channel0 + l->m->lobe[lobe].n_channel - 1;
            double *ks = &channel[c * l->m->n_channel + scale];
            for (int pass = 0; pass < 2; pass++)
                for (uint32_t k = 0; k < l->free.n_channel; k++) {
                    const ff_model_param *p = &l->m->channel[l->free.channel[k]];
                    double *v = &channel[c * l->m->n_channel + l->free.channel[k]];
                    if (p->lobe != lobe || !is_scaled(l, k)) continue;
                    if (pass == 0)
                        *ks = fmax(*ks, fmax(p->hi > 0 ? *v / p->hi : 0, p->lo < 0 ? *v / p->lo : 0));
                    else
                        *v = *ks > 0 ? fmin(fmax(*v / *ks, p->lo), p->hi) : p->init;
                }
            *ks = fmin(fmax(*ks, l->m->channel[scale].lo), l->m->channel[scale].hi);
        }
}

/* A pass over a thin problem that leaves the gram of the channel columns. plain: without the robust loss, whose weights mean
 * nothing far from the data. */
static ff_status channel_pass(const ff_layout *l, const struct ff_problem *p, const ff_fit_options *o, const double *shape,
                              const double *channel, int plain, ff_normal *normal)
{
    ff_pass pass;
    ff_status s = ff_layout_pass(l, p, o, shape, channel, &pass);
    if (s) return s;
    if (plain) pass.robust = FF_ROBUST_NONE;
    s = ff_pass_run(&pass, 0, normal);
    ff_pass_free(&pass);
    return s;
}

/* Gauss-Newton steps from trial on the thin problem, each halved until it helps. The best point goes to channel. */
static ff_status improve_channels(const ff_layout *l, const struct ff_problem *p, const ff_fit_options *o, const double *shape,
                                  int steps, double *trial, double *channel, double *cost2, ff_normal *normal)
{
    const size_t size = l->n_channels * l->m->n_channel;
    *cost2 = INFINITY;
    for (int step = 0; step <= steps; step++) {
        const ff_status s = channel_pass(l, p->thin, o, shape, trial, 0, normal);
        if (s && (s != FF_ERR_INTERNAL || *cost2 == INFINITY)) return s;
        if (!s && normal->cost2 < *cost2) { /* go on from here */
            const int enough = normal->cost2 > *cost2 * (1 - 1e-4);
            *cost2 = normal->cost2;
            memcpy(channel, trial, size * sizeof *trial);
            if (enough) break;
            step_channels(l, normal, channel, 0, trial);
        } else /* too far: half way back */
            for (size_t k = 0; k < size; k++) trial[k] = 0.5 * (trial[k] + channel[k]);
    }
    return FF_OK;
}

ff_status ff_start_channels(const ff_layout *l, const struct ff_problem *p, const ff_fit_options *o, const double *shape,
                            double *channel, double *cost2)
{
    enum { STEPS = 4, CURVED_STEPS = 12 };
    const size_t size = l->n_channels * l->m->n_channel;
    const int exact = l->linear && !l->scaled && !p->thin_linear->surrogate && o->robust == FF_ROBUST_NONE;
    const ff_layout channels = ff_layout_of_channels(l);
    ff_normal normal = {0};
    ff_status s = ff_normal_new(&channels, &normal);
    double *trial = malloc((size + 1) * sizeof *trial);
    if (!trial) s = s ? s : FF_ERR_MEMORY;
    if (!s) memcpy(trial, channel, size * sizeof *trial);
    if (!s && l->linear) {
        for (size_t c = 0; c < l->n_channels; c++)
            for (uint32_t k = 0; k < l->free.n_channel; k++) {
                const uint32_t at = l->free.channel[k];
                const uint32_t lobe = l->m->channel[at].lobe;
                /* a scale of 1: the columns are then those of the products */
                trial[c * l->m->n_channel + at] = lobe < l->m->n_lobes && (l->scaled >> lobe & 1) && !is_scaled(l, k);
            }
        s = channel_pass(&channels, p->thin_linear, o, shape, trial, 1, &normal);
        if (!s) *cost2 = step_channels(&channels, &normal, trial, 1, channel);
        if (!s) divide_by_scales(l, channel);
        if (!s) memcpy(trial, channel, size * sizeof *trial);
    }
    if (!s && !exact)
        s = improve_channels(&channels, p, o, shape, l->linear ? STEPS : CURVED_STEPS, trial, channel, cost2, &normal);
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
    double *channel = s->channel + (size_t)worker * (size + 1);
    if (ff_fit_cancelled(s->o)) {
        s->status[worker] = FF_ERR_CANCELLED;
        return;
    }
    ff_model_defaults(s->l->m, s->l->n_channels, NULL, channel); /* those that are held */
    const ff_status st = ff_start_channels(s->l, s->p, s->o, s->candidate[i].shape, channel, &s->candidate[i].cost2);
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

/* Is it a lobe's roughness, of which a measurement resolves no less than 0.002? */
static int is_roughness(const ff_model *m, uint32_t shape)
{
    const ff_model_param *p = &m->shape[shape];
    return p->lobe < m->n_lobes && shape == m->lobe[p->lobe].shape0 && ff_ndf_at(m->lobe[p->lobe].ndf)->alpha_own >= 0 &&
           strncmp(p->info->name, "alpha", 5) == 0;
}

static void search_range(const ff_layout *l, uint32_t k, double *lo, double *hi)
{
    const ff_model_param *p = &l->m->shape[l->free.shape[k]];
    *lo = ff_coordinate(p->info, p->lo);
    *hi = ff_coordinate(p->info, p->hi);
    if (is_roughness(l->m, l->free.shape[k]) && *hi > log(0.002)) *lo = fmax(*lo, log(0.002));
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

/* Sets parameter k of a shape, and alpha_y with alpha_x. */
static void set_point(const ff_layout *l, uint32_t k, double coordinate, double *shape)
{
    const uint32_t i = l->free.shape[k];
    const ff_param *info = l->m->shape[i].info;
    shape[i] = ff_coordinate_value(info, coordinate);
    if (strcmp(info->name, "alpha_x") == 0) shape[i + 1] = shape[i];
}

/* Points per searched parameter, so that the whole grid stays near a thousand and never exceeds max. */
static void grid_sizes(const ff_layout *l, size_t max, size_t *size)
{
    const size_t for_lobes[FF_MAX_LOBES + 1] = {1, 22, 13, 8};
    size_t total = 1;
    for (uint32_t k = 0; k < l->free.n_shape; k++) {
        size[k] = !is_searched(l, k) ? 1 : is_scale(l, k) ? for_lobes[l->m->n_lobes] : l->m->n_lobes > 1 ? 3 : 7;
        total *= size[k];
    }
    while (total > max) { /* the finest becomes coarser */
        uint32_t most = 0;
        for (uint32_t k = 1; k < l->free.n_shape; k++)
            if (size[k] > size[most]) most = k;
        total = total / size[most] * (size[most] - 1);
        size[most]--;
    }
}

/* Lobes of the same kind are ordered by their scale, narrowest first. */
static int is_ordered(const ff_layout *l, const double *shape)
{
    for (uint32_t a = 1; a < l->m->n_lobes; a++) {
        const ff_lobe *x = &l->m->lobe[a - 1], *y = &l->m->lobe[a];
        if (shape[x->shape0] >= shape[y->shape0] && ff_layout_exchangeable(l, a - 1, a)) return 0;
    }
    return 1;
}

static size_t fill_grid(const ff_layout *l, const double *defaults, ff_candidate *out, size_t max)
{
    size_t size[FF_MAX_SHAPE], total = 1, n = 0;
    grid_sizes(l, max, size);
    for (uint32_t k = 0; k < l->free.n_shape; k++) total *= size[k];
    for (size_t code = 0; code < total && n < max; code++) {
        ff_candidate *c = &out[n];
        memset(c, 0, sizeof *c);
        memcpy(c->shape, defaults, l->m->n_shape * sizeof *defaults);
        size_t rest = code;
        for (uint32_t k = 0; k < l->free.n_shape; k++) {
            const size_t step = rest % size[k];
            rest /= size[k];
            if (size[k] == 1) continue;
            double lo, hi;
            search_range(l, k, &lo, &hi);
            set_point(l, k, lo + (hi - lo) * ((double)step + 0.5) / (double)size[k], c->shape);
        }
        ff_layout_candidate(l, c->shape);
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
    const double alpha = from->shape[ix], highest = l->m->shape[ix].hi;
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
            ff_layout_candidate(l, o->shape);
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
            for (uint32_t j = 0; j < l->free.n_shape; j++) {
                const uint32_t at = l->free.shape[j];
                const ff_param *info = l->m->shape[at].info;
                const double d = ff_coordinate(info, c[i].shape[at]) - ff_coordinate(info, c[k].shape[at]);
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
    ff_layout_defaults(l, defaults, NULL);
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
            for (uint32_t k = 0; k < l->free.n_shape; k++) {
                free_y |= l->free.shape[k] == m->lobe[lobe].shape0 + 1;
                free_r |= l->free.shape[k] == m->lobe[lobe].shape0 + 2;
            }
            if (!free_y || m->lobe[lobe].isotropic) continue;
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
