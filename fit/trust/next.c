/* Which incidences to measure next: those that would best tell two models apart, or that would say most of the parameter that is
 * known worst (its variance by the information of all samples).
 *
 * Two models differ by what parameters of the rival cannot make up for, here by their first derivatives (T-optimality: Atkinson and
 * Fedorov 1975). A comparison sums that over whole incidences and asks whether the mean is beyond its scatter from one to the next
 * (versus.c), so that a difference at one of them is no proof: what is to be large is the z that it will find. Samples count by the
 * noise of the data; a new incidence is measured in the exit directions of the old ones. Incidences are taken one by one, then
 * exchanged as long as that is better (Fedorov 1972). */
#include "internal_trust.h"
#include "fit/linalg/internal_linalg.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { EXITS = 400, OLD_SAMPLES = 8000, GROUPS = 64, STEP_DEG = 5, AZIMUTHS = 8, MOST_COLUMNS = 512, EXCHANGES = 20 };
#define NEAR_DEG    2.0  /* of an incidence that is there already                                      */
#define RIDGE       1e-9 /* of the diagonal of a scaled information                                     */
#define LEAST_SD    1e-3 /* of a value, of the largest of its channel: no measurement is better than that */
#define FLOOR_SHAPE 0.05 /* a parameter below that is known well where its error is small beside this   */

static const double degree = 3.14159265358979323846 / 180;

/* What some samples say: the information of the columns [P][P], J^T d and d^2 of the difference d of the two models, all in
 * standard deviations. */
typedef struct says {
    double *G, *b, c;
} says;

/* A pair of directions with the number of samples that it stands for. */
typedef struct pairs {
    size_t n;
    double *w[6], *weight; /* [n] */
    unsigned char *group;  /* [n] */
} pairs;

typedef struct search {
    const ff_problem *p;
    const ff_fit_options *o;
    const ff_fit_result *fit, *rival; /* rival NULL: a parameter is wanted */
    const ff_noise *noise;
    size_t P, column; /* of the rival, or of fit; the column that is wanted */
    int *of;          /* [n_shape + C n_channel] column of each parameter, -1 = none */
    double *most;     /* [C] largest value of fit at the old samples */
    size_t n_old;     /* incidences that there are, or GROUPS of them */
    says old[GROUPS];
    size_t n; /* candidates */
    double *theta, *phi;
    says *each;   /* [n] */
    double *work; /* [2 P P + 5 P] */
} search;

static const ff_fit_result *moved(const search *s)
{
    return s->rival ? s->rival : s->fit;
}

/* ---- columns --------------------------------------------------------------------------------- */

static const ff_fit_value *value_at(const ff_fit_result *f, size_t k)
{
    return k < f->model.n_shape ? &f->shape_value[k] : &f->channel_value[k - f->model.n_shape];
}

/* The place of the parameter that a tied one follows. */
static size_t leader_of(const ff_fit_result *f, const ff_fit_value *v)
{
    if (v->follows.kind == FF_PARAM_SHAPE) return v->follows.index;
    return f->model.n_shape + v->follows_channel * f->model.n_channel + v->follows.index;
}

/* Numbers what can still move. */
static size_t number_columns(const ff_fit_result *f, int *of)
{
    const size_t n = f->model.n_shape + f->n_channels * f->model.n_channel;
    size_t P = 0;
    for (size_t k = 0; k < n; k++) {
        const ff_fit_value *v = value_at(f, k);
        of[k] = v->held || v->tied || v->at_bound || v->weightless ? -1 : (int)P++;
    }
    for (size_t k = 0; k < n; k++)
        if (value_at(f, k)->tied) of[k] = of[leader_of(f, value_at(f, k))];
    return P;
}

/* The free parameter with the largest error beside its value. */
static size_t worst_column(const ff_fit_result *f, const int *of, size_t *place)
{
    const size_t n = f->model.n_shape + f->n_channels * f->model.n_channel;
    double worst = -1;
    *place = n;
    for (size_t k = 0; k < n; k++) {
        const ff_fit_value *v = value_at(f, k);
        const double relative = v->std_error / fmax(fabs(v->value), FLOOR_SHAPE);
        if (of[k] < 0 || v->tied || !(relative > worst)) continue;
        worst = relative;
        *place = k;
    }
    return *place < n ? (size_t)of[*place] : 0;
}

/* ---- what samples say ------------------------------------------------------------------------ */

static void says_free(says *s)
{
    free(s->G);
    *s = (says){.G = NULL};
}

static int says_new(size_t P, says *s)
{
    s->G = calloc(P * P + P + 1, sizeof *s->G);
    s->b = s->G ? s->G + P * P : NULL;
    s->c = 0;
    return s->G != NULL;
}

static void values_of(const ff_fit_result *f, double *shape, double *channel)
{
    for (uint32_t k = 0; k < f->model.n_shape; k++) shape[k] = f->shape_value[k].value;
    for (size_t k = 0; k < f->n_channels * f->model.n_channel; k++) channel[k] = f->channel_value[k].value;
}

/* Adds sample i of channel c: derivatives row [P] by column, all over sd. */
static void add_sample(const search *s, const double *row, double d, double weight, says *out)
{
    for (size_t a = 0; a < s->P; a++) {
        if (row[a] == 0) continue;
        for (size_t b = 0; b <= a; b++) out->G[a * s->P + b] += weight * row[a] * row[b];
        out->b[a] += weight * row[a] * d;
    }
    out->c += weight * d * d;
}

/* out: by the pairs' groups. */
static ff_status add_pairs(const search *s, const pairs *p, says *out)
{
    const ff_fit_result *m = moved(s);
    const size_t C = m->n_channels, K = m->model.n_shape + m->model.n_channel, N = s->fit->n_channels * s->fit->model.n_channel;
    const ff_dirs w = {p->w[0], p->w[1], p->w[2], p->w[3], p->w[4], p->w[5]};
    const size_t size = FF_MAX_SHAPE + C * m->model.n_channel + N + C * p->n * (K + 2) + s->P + 1;
    double *memory = malloc(size * sizeof *memory);
    if (!memory) return FF_ERR_MEMORY;
    double *shape = memory, *channel = shape + FF_MAX_SHAPE, *other = channel + C * m->model.n_channel, *f = other + N,
           *g = f + C * p->n, *df = g + C * p->n, *row = df + C * p->n * K;
    values_of(m, shape, channel);
    ff_status status = ff_model_eval(&m->model, s->o->isa, C, shape, channel, &w, p->n, f, df, p->n);
    values_of(s->fit, shape, other);
    if (!status) status = ff_model_eval(&s->fit->model, s->o->isa, C, shape, other, &w, p->n, g, NULL, p->n);
    for (size_t c = 0; c < C && !status; c++)
        for (size_t i = 0; i < p->n; i++) {
            const double truth = fmax(g[c * p->n + i], 0);
            if (!(p->w[2][i] > 0 && p->w[5][i] > 0) || !(p->weight[i] > 0)) continue;
            const double sd = fmax(ff_noise_sd(s->noise, c, truth, p->w[2][i], p->w[5][i]), LEAST_SD * s->most[c]);
            memset(row, 0, s->P * sizeof *row);
            for (size_t k = 0; k < K; k++) {
                const size_t place = k < m->model.n_shape ? k : m->model.n_shape + c * m->model.n_channel + k - m->model.n_shape;
                if (s->of[place] >= 0) row[s->of[place]] += df[(c * K + k) * p->n + i] / sd;
            }
            add_sample(s, row, (truth - f[c * p->n + i]) / sd, p->weight[i], &out[p->group[i]]);
        }
    free(memory);
    return status;
}

/* ---- candidates ------------------------------------------------------------------------------ */

static int pairs_new(size_t n, pairs *p)
{
    double *memory = malloc((7 * n + 1) * sizeof *memory);
    p->n = n;
    for (int k = 0; k < 6; k++) p->w[k] = memory ? memory + (size_t)k * n : NULL;
    p->weight = memory ? memory + 6 * n : NULL;
    p->group = calloc(n + 1, sizeof *p->group);
    return memory && p->group;
}

static void pairs_free(pairs *p)
{
    free(p->w[0]);
    free(p->group);
    *p = (pairs){.n = 0};
}

static void take_old(const search *s, const ff_table *t, const ff_places *places, pairs *out)
{
    for (size_t i = 0; i < out->n; i++) {
        double *const planes[6] = {out->w[0] + i, out->w[1] + i, out->w[2] + i, out->w[3] + i, out->w[4] + i, out->w[5] + i};
        const size_t at = i * s->p->n / out->n;
        ff_table_directions(t, s->p->index[at], 1, planes);
        out->group[i] = (unsigned char)(places->direction[at] % s->n_old);
        out->weight[i] = (double)s->p->n / (double)out->n;
    }
}

/* Incident direction of each candidate, the exit directions of the incidence with the most samples turned with it. */
static void turn(const pairs *pattern, double theta, double phi, double from_phi, pairs *out)
{
    const double c = cos(phi - from_phi), s = sin(phi - from_phi);
    for (size_t i = 0; i < pattern->n; i++) {
        out->w[0][i] = sin(theta) * cos(phi);
        out->w[1][i] = sin(theta) * sin(phi);
        out->w[2][i] = cos(theta);
        out->w[3][i] = c * pattern->w[3][i] - s * pattern->w[4][i];
        out->w[4][i] = s * pattern->w[3][i] + c * pattern->w[4][i];
        out->w[5][i] = pattern->w[5][i];
        out->weight[i] = pattern->weight[i];
    }
}

/* The exit directions of the incident direction with the most samples, in a few of them; its azimuth. */
static ff_status take_pattern(const search *s, const ff_table *t, const ff_places *places, pairs *out, double *phi)
{
    size_t *count = calloc(places->n_directions + 1, sizeof *count), most = 0, seen = 0, taken = 0;
    if (!count) return FF_ERR_MEMORY;
    for (size_t i = 0; i < s->p->n; i++) count[places->direction[i]]++;
    for (size_t d = 1; d < places->n_directions; d++)
        if (count[d] > count[most]) most = d;
    const size_t all = count[most], n = all < EXITS ? all : EXITS;
    free(count);
    if (!pairs_new(n, out)) return FF_ERR_MEMORY;
    for (size_t i = 0; i < s->p->n && taken < n; i++) {
        if (places->direction[i] != most || seen++ * n / all < taken) continue;
        double *const planes[6] = {out->w[0] + taken, out->w[1] + taken, out->w[2] + taken,
                                   out->w[3] + taken, out->w[4] + taken, out->w[5] + taken};
        ff_table_directions(t, s->p->index[i], 1, planes);
        out->weight[taken++] = (double)all / (double)n;
    }
    out->n = taken;
    *phi = taken && hypot(out->w[0][0], out->w[1][0]) > 1e-6 ? atan2(out->w[1][0], out->w[0][0]) : 0;
    return FF_OK;
}

/* Azimuths of the incident directions, in radians; one of data that are isotropic or in one plane. */
static size_t azimuths_of(const search *s, const ff_table *t, double phi[AZIMUTHS])
{
    size_t n = 0;
    for (size_t i = 0; i < s->p->n && n < AZIMUTHS; i++) {
        double w[6], *const planes[6] = {w, w + 1, w + 2, w + 3, w + 4, w + 5};
        int known = 0;
        ff_table_directions(t, s->p->index[i], 1, planes);
        const double one = atan2(w[1], w[0]);
        if (hypot(w[0], w[1]) < 1e-6) continue;
        for (size_t k = 0; k < n; k++) known |= fabs(remainder(one - phi[k], 360 * degree)) < 1 * degree;
        if (!known) phi[n++] = one;
        if (t->isotropic) break;
    }
    if (n == 0) phi[n++] = 0;
    return n;
}

/* Is there an incidence so near that nothing new would be learnt? */
static int is_there(const search *s, const ff_table *t, double theta, double phi)
{
    const float low = (float)cos(theta + NEAR_DEG * degree), high = (float)cos(fmax(theta - NEAR_DEG * degree, 0));
    for (size_t i = 0; i < s->p->n; i++) {
        double w[6], *const planes[6] = {w, w + 1, w + 2, w + 3, w + 4, w + 5};
        if (s->p->cosine[0][i] < low || s->p->cosine[0][i] > high) continue;
        if (t->isotropic || theta < NEAR_DEG * degree) return 1;
        ff_table_directions(t, s->p->index[i], 1, planes);
        if (fabs(remainder(atan2(w[1], w[0]) - phi, 360 * degree)) < NEAR_DEG * degree) return 1;
    }
    return 0;
}

/* The largest theta_i of the data, to the next step of the candidates. */
static double reach_of_data(const search *s)
{
    float least = 1;
    for (size_t i = 0; i < s->p->n; i++) least = fminf(least, s->p->cosine[0][i]);
    const double own = acos(fmin((double)least, 1)) / degree;
    return fmin(ceil((own - 0.01) / STEP_DEG) * STEP_DEG, 89) * degree;
}

static ff_status add_candidates(search *s, const ff_table *t, const ff_places *places, double reach)
{
    double azimuth[AZIMUTHS], own_phi;
    pairs pattern = {.n = 0}, turned = {.n = 0};
    const size_t n_phi = azimuths_of(s, t, azimuth);
    const size_t n_theta = (size_t)(reach / degree / STEP_DEG + 1e-9) + 1;
    s->theta = malloc(2 * n_theta * n_phi * sizeof *s->theta);
    s->phi = s->theta ? s->theta + n_theta * n_phi : NULL;
    s->each = calloc(n_theta * n_phi, sizeof *s->each);
    ff_status status = s->theta && s->each ? take_pattern(s, t, places, &pattern, &own_phi) : FF_ERR_MEMORY;
    if (!status && !pairs_new(pattern.n, &turned)) status = FF_ERR_MEMORY;
    for (size_t k = 0; k < n_theta * n_phi && !status; k++) {
        const size_t ring = k / n_phi;
        const double theta = (double)ring * STEP_DEG * degree, phi = azimuth[k % n_phi];
        if ((theta == 0 && k % n_phi) || is_there(s, t, theta, phi)) continue;
        says *one = &s->each[s->n];
        s->theta[s->n] = theta;
        s->phi[s->n] = phi;
        if (!says_new(s->P, one)) status = FF_ERR_MEMORY;
        if (status) break;
        s->n++;
        turn(&pattern, theta, phi, own_phi, &turned);
        status = add_pairs(s, &turned, one);
    }
    pairs_free(&pattern);
    pairs_free(&turned);
    return status;
}

/* ---- the choice ------------------------------------------------------------------------------ */

/* The k-th incidence of the old ones and of candidates at [n]. */
static const says *incidence_at(const search *s, const size_t *at, size_t k)
{
    return k < s->n_old ? &s->old[k] : &s->each[at[k - s->n_old]];
}

/* What an incidence adds to the difference when the columns of the rival have moved by x. */
static double left_at(const says *one, const double *x, size_t P)
{
    double sum = one->c;
    for (size_t i = 0; i < P; i++) {
        double row = one->G[i * P + i] * x[i];
        for (size_t k = 0; k < i; k++) row += 2 * one->G[i * P + k] * x[k];
        sum += x[i] * (row - 2 * one->b[i]);
    }
    return fmax(sum, 0);
}

/* The z of the comparison: the sum over incidences against their scatter, which is that of the noise (a difference of squares of
 * mean m has the variance 4 m) and that of the means. */
static double z_of(const search *s, const size_t *at, size_t n, const double *x)
{
    const size_t all = s->n_old + n;
    double sum = 0, squares = 0;
    for (size_t k = 0; k < all; k++) {
        const double one = left_at(incidence_at(s, at, k), x, s->P);
        sum += one;
        squares += one * one;
    }
    const double spread = all > 1 ? (squares - sum * sum / (double)all) / (double)(all - 1) : 0;
    const double variance = 4 * sum + (double)all * fmax(spread, 0);
    return variance > 0 ? sum / sqrt(variance) : 0;
}

/* The larger the better, of the old samples and those of candidates at [n]: that z; or what is known of the wanted column, one over
 * its variance. */
static double worth_of(search *s, const size_t *at, size_t n)
{
    const size_t P = s->P;
    double *G = s->work, *L = G + P * P, *b = L + P * P, *scale = b + P, *D = scale + P, *x = D + P, *solved = x + P;
    memset(G, 0, P * P * sizeof *G);
    memset(b, 0, P * sizeof *b);
    for (size_t k = 0; k < s->n_old + n; k++) {
        const says *one = incidence_at(s, at, k);
        for (size_t i = 0; i < P * P; i++) G[i] += one->G[i];
        for (size_t i = 0; i < P; i++) b[i] += one->b[i];
    }
    for (size_t i = 0; i < P; i++) scale[i] = G[i * P + i] > 0 ? 1 / sqrt(G[i * P + i]) : 0;
    for (size_t i = 0; i < P; i++)
        for (size_t k = 0; k <= i; k++) G[k * P + i] = G[i * P + k] = G[i * P + k] * scale[i] * scale[k] + (i == k ? RIDGE : 0);
    ff_scaled_cholesky(G, P, 1e-14, L, D);
    for (size_t i = 0; i < P; i++) x[i] = s->rival ? b[i] * scale[i] : i == s->column;
    ff_factored_solve(L, D, P, x, 1, solved);
    for (size_t i = 0; i < P; i++) solved[i] *= scale[i];
    if (s->rival) return z_of(s, at, n, solved);
    const double variance = solved[s->column] * scale[s->column];
    return variance > 0 ? 1 / variance : 0;
}

static int is_chosen(const size_t *at, size_t n, size_t candidate)
{
    for (size_t k = 0; k < n; k++)
        if (at[k] == candidate) return 1;
    return 0;
}

/* Puts at[k] where it is worth most, the others staying; whether it moved. */
static int place_one(search *s, size_t *at, size_t n, size_t k)
{
    const size_t before = at[k];
    size_t best = before;
    double most = before < s->n ? worth_of(s, at, n) : -1;
    for (size_t candidate = 0; candidate < s->n; candidate++) {
        if (is_chosen(at, n, candidate)) continue;
        at[k] = candidate;
        const double worth = worth_of(s, at, n);
        if (!(worth > most * (1 + 1e-9))) {
            at[k] = best;
            continue;
        }
        most = worth;
        best = candidate;
    }
    at[k] = best;
    return best != before;
}

static void choose(search *s, size_t *at, size_t n)
{
    for (size_t k = 0; k < n; k++) {
        at[k] = SIZE_MAX;
        size_t best = 0;
        double most = -1;
        for (size_t candidate = 0; candidate < s->n; candidate++) {
            if (is_chosen(at, k, candidate)) continue;
            at[k] = candidate;
            const double worth = worth_of(s, at, k + 1);
            if (worth > most) most = worth, best = candidate;
        }
        at[k] = best;
    }
    int any = 1;
    for (int round = 0; round < EXCHANGES && any; round++) {
        any = 0;
        for (size_t k = 0; k < n; k++) any |= place_one(s, at, n, k);
    }
}

/* ---- the whole ------------------------------------------------------------------------------- */

static void search_free(search *s)
{
    for (size_t k = 0; k < s->n; k++) says_free(&s->each[k]);
    for (size_t k = 0; k < s->n_old; k++) says_free(&s->old[k]);
    free(s->each);
    free(s->theta);
    free(s->of);
    free(s->most);
    free(s->work);
}

static ff_status look_at_old(search *s, const ff_table *t, const ff_places *places)
{
    pairs old = {.n = 0};
    s->n_old = places->n_directions < GROUPS ? places->n_directions : GROUPS;
    int made = 1;
    for (size_t k = 0; k < s->n_old && made; k++) made = says_new(s->P, &s->old[k]);
    made = pairs_new(s->p->n < OLD_SAMPLES ? s->p->n : OLD_SAMPLES, &old) && made;
    if (!made) {
        pairs_free(&old);
        return FF_ERR_MEMORY;
    }
    for (size_t c = 0; c < s->fit->n_channels; c++)
        for (size_t i = 0; i < s->p->n; i++)
            s->most[c] = fmax(s->most[c], ff_problem_plane(s->p, i / FF_BLOCK, s->p->value + (int)c)[i % FF_BLOCK]);
    take_old(s, t, places, &old);
    const ff_status status = add_pairs(s, &old, s->old);
    pairs_free(&old);
    return status;
}

static int by_theta(const void *a, const void *b)
{
    const ff_incidence *x = a, *y = b;
    return x->theta_i != y->theta_i ? (x->theta_i > y->theta_i) - (x->theta_i < y->theta_i)
                                    : (x->phi_i > y->phi_i) - (x->phi_i < y->phi_i);
}

static void report(search *s, size_t place, ff_next *out)
{
    const ff_fit_result *f = s->fit;
    size_t at[FF_NEXT] = {0};
    const double now = worth_of(s, NULL, 0);
    out->n = s->n < FF_NEXT ? s->n : FF_NEXT;
    choose(s, at, out->n);
    const double then = worth_of(s, at, out->n);
    out->now = s->rival ? now : now > 0 ? 1 / sqrt(now) : INFINITY;
    out->then = s->rival ? then : then > 0 ? 1 / sqrt(then) : INFINITY;
    for (size_t k = 0; k < out->n; k++) out->at[k] = (ff_incidence){s->theta[at[k]], s->phi[at[k]]};
    qsort(out->at, out->n, sizeof *out->at, by_theta);
    out->parameter = (ff_param_ref){FF_PARAM_NONE, 0};
    if (s->rival) return;
    const int of_shape = place < f->model.n_shape;
    const size_t own = of_shape ? place : place - f->model.n_shape;
    out->parameter.kind = of_shape ? FF_PARAM_SHAPE : FF_PARAM_CHANNEL;
    out->parameter.index = (uint32_t)(of_shape ? own : own % f->model.n_channel);
    out->channel = of_shape ? 0 : own / f->model.n_channel;
}

ff_status ff_trust_next_into(const ff_problem *p, const ff_table *t, const ff_places *places, const ff_fit_options *o,
                             const ff_fit_result *fit, const ff_fit_result *rival, double reach, ff_next *out, ff_error *err)
{
    search s = {.p = p, .o = o, .fit = fit, .rival = rival, .noise = ff_fit_result_noise(fit)};
    const ff_fit_result *m = moved(&s);
    ff_next made = {.size = sizeof made};
    size_t place = 0;
    if (!(reach >= 0 && reach < 90 * degree))
        return ff_error_set(err, FF_ERR_RANGE, NULL, 0, -1, "reach %g: expected at least 0 and less than pi/2", reach);
    if (fit->n_channels != p->n_channels || (rival && rival->n_channels != p->n_channels))
        return ff_error_set(err, FF_ERR_RANGE, NULL, 0, -1, "a fit of other channels than those of the problem");
    if (!s.noise)
        return ff_error_set(err, FF_ERR_UNSUPPORTED, NULL, 0, -1,
                            "the fit has found no noise: nothing says what a new sample tells");
    s.of = malloc((m->model.n_shape + m->n_channels * m->model.n_channel + 1) * sizeof *s.of);
    s.most = calloc(fit->n_channels + 1, sizeof *s.most);
    ff_status status = s.of && s.most ? FF_OK : FF_ERR_MEMORY;
    if (!status) s.P = number_columns(m, s.of);
    if (!status && (s.P == 0 || s.P > MOST_COLUMNS)) {
        search_free(&s);
        return ff_error_set(err, FF_ERR_UNSUPPORTED, NULL, 0, -1, "%zu free parameters: expected 1 to %d", s.P, MOST_COLUMNS);
    }
    if (!status) s.column = worst_column(m, s.of, &place);
    s.work = status ? NULL : malloc((2 * s.P * s.P + 6 * s.P + 1) * sizeof *s.work);
    if (!status && !s.work) status = FF_ERR_MEMORY;
    if (!status) status = look_at_old(&s, t, places);
    made.reach = status || reach > 0 ? reach : reach_of_data(&s);
    if (!status) status = add_candidates(&s, t, places, made.reach);
    if (!status) report(&s, place, &made);
    search_free(&s);
    if (status) return ff_error_set(err, status, NULL, 0, -1, "the incidences could not be looked at: %s", ff_status_str(status));
    *out = made;
    return FF_OK;
}
