/* channels_test [REPEATS [WORD]]: are the shapes of channels said to differ in 5 % of measurements where they do not, and as often
 * as they should where one does? Three channels of one surface, of another brightness each, whose noise is independent; each is
 * fitted alone. Only designs whose line has WORD. A table: share of REPEATS simulated measurements in which p is below 0.05, first
 * of one shape, then of a last channel whose roughness is three standard deviations of the difference away from that of the others,
 * and what chi^2 of that noncentrality gives. The first must lie in 2 to 8 %, the second within 10 % of what it should be; of fewer
 * repeats than MANY the bands are as many standard deviations wider. Not judged: the power where errors rest on six incidences,
 * which allow for more than chi^2 does; and two shape parameters that two or three values carry, whose errors are 8 % too small.
 * The seeds are 1 .. REPEATS. */
#include "fit_samples.h"
#include "base/internal_pool.h"
#include "base/internal_statistics.h"
#include "simulate/simulate_struct.h"
#include "fit/problem/internal_problem.h"
#include "fit/trust/trust_struct.h"

enum { CHANNELS = 3, MAX_Q = 8, MANY = 1000, MAX_REPEATS = 100000 };
#define AWAY 3.0 /* standard deviations of the difference */

typedef struct design {
    const char *grid, *expression, *words;
    double noise;
    ff_shape shape;
    int by_incidences; /* 1: weights by the noise, errors by leaving out incidences, of which there are six */
    int shown;         /* 1: the power is not judged; 2: neither is the size                                */
} design;

#define UNLIKE " f0=0.9:0.6:0.3 kd=0.1:0.05:0.02"
static const design designs[] = {
    {"goniometer:10", "ggx+lambert", "alpha=0.2" UNLIKE, 0.05, FF_SHAPE_ISOTROPIC, 0, 0},
    {"goniometer:5", "ggx+lambert", "alpha=0.2" UNLIKE, 0.02, FF_SHAPE_ISOTROPIC, 0, 0},
    {"scattered:300:0.5", "ggx+lambert", "alpha=0.2" UNLIKE, 0.05, FF_SHAPE_ISOTROPIC, 0, 0},
    {"goniometer:5", "ggx/v-cavity+lambert", "alpha=0.45" UNLIKE, 0.02, FF_SHAPE_ISOTROPIC, 0, 0}, /* that of ./setup demo */
    {"scattered:600:0.5", "ggx+lambert", "alpha_x=0.25 alpha_y=0.15 r_xy=-0.3" UNLIKE, 0.05, FF_SHAPE_CORRELATED, 0, 0},
    {"goniometer:10", "ggx+lambert", "alpha=0.2" UNLIKE, 0.05, FF_SHAPE_ISOTROPIC, 1, 1},
    {"goniometer:10", "student-t/v-cavity+lambert", "alpha=0.2 gamma=2.5" UNLIKE, 0.05, FF_SHAPE_ISOTROPIC, 0, 2}};

typedef struct trial {
    const design *d;
    double factor;             /* roughness of the last channel over that of the others     */
    double *p, *F, *error_dof; /* [repeats] */
    double *shape;             /* [repeats][CHANNELS][MAX_Q]: shape parameters in the coordinates of the fit */
    size_t q;                  /* that are free                                                             */
} trial;

/* ---- one measurement ------------------------------------------------------------------------- */

/* Without noise: the last channel of its own roughness. */
static ff_table clean(const trial *t, uint64_t seed)
{
    fit_surface s = fit_surface_make(t->d->expression, CHANNELS, t->d->words);
    ff_simulate_options o;
    ff_table table, other;
    ff_error err = {0};
    ff_simulate_options_init(&o);
    o.seed = seed;
    ff_status status = ff_sampling_parse(t->d->grid, &o.sampling, &err);
    if (!status) status = ff_simulate_into(&s.model, CHANNELS, s.shape, s.channel, &o, &table, &err);
    s.shape[0] *= t->factor;
    if (t->d->shape == FF_SHAPE_ISOTROPIC) s.shape[1] = s.shape[0];
    if (!status) status = ff_simulate_into(&s.model, CHANNELS, s.shape, s.channel, &o, &other, &err);
    if (status) {
        printf("the test itself is wrong: %s\n", err.message);
        exit(1);
    }
    memcpy(table.value + (CHANNELS - 1) * table.n, other.value + (CHANNELS - 1) * table.n, table.n * sizeof *table.value);
    ff_table_clear(&other);
    return table;
}

static ff_status fit_by_incidences(const ff_table *table, const ff_problem *p, const ff_fit_options *o, ff_fit_result *fit)
{
    ff_places places = {.n = 0};
    ff_status status = ff_places_init(p, table, &places, NULL);
    if (!status) status = ff_trust_jackknife(p, &places, o, fit, NULL);
    ff_places_clear(&places);
    return status;
}

static ff_status fit_channel(const design *d, const ff_table *table, int c, ff_fit_result *fit)
{
    const fit_surface s = fit_surface_make(d->expression, 1, "");
    ff_problem *p = NULL;
    ff_fit_options o;
    ff_fit_options_init(&o);
    o.threads = 1;
    o.shape = d->shape;
    o.only_channel = c;
    ff_status status = ff_problem_make(table, &s.model, 1, &o, &p, NULL);
    if (!status) status = ff_problem_fit_into(p, &s.model, &o, fit, NULL);
    if (!status && d->by_incidences) {
        status = ff_problem_weigh_by_noise(p, &o, fit, NULL);
        ff_fit_result_clear(fit);
        if (!status) status = ff_problem_fit_into(p, &s.model, &o, fit, NULL);
        if (!status) status = fit_by_incidences(table, p, &o, fit);
    }
    ff_problem_free(p);
    return status;
}

static ff_status fit_each(const design *d, const ff_table *table, ff_fit_result *fits)
{
    ff_status status = FF_OK;
    for (int c = 0; c < CHANNELS && !status; c++) status = fit_channel(d, table, c, &fits[c]);
    return status;
}

static void one_repeat(void *context, size_t repeat, int worker)
{
    const trial *t = context;
    ff_fit_result fits[CHANNELS] = {{.n_channels = 0}};
    ff_difference difference = {.p = NAN};
    uint64_t state = ff_test_seeded((1 + repeat) * UINT64_C(0xd1342543de82ef95));
    ff_table table = clean(t, 1 + repeat);
    (void)worker;
    for (size_t i = 0; i < table.n * CHANNELS; i++) table.value[i] *= 1 + t->d->noise * fit_normal(&state);
    ff_status status = fit_each(t->d, &table, fits);
    if (!status) status = ff_trust_channels_differ_into(fits, CHANNELS, &difference, NULL);
    t->p[repeat] = status ? NAN : difference.p;
    t->F[repeat] = difference.f;
    t->error_dof[repeat] = difference.error_dof;
    for (size_t c = 0; c < CHANNELS; c++) {
        double *x = &t->shape[(repeat * CHANNELS + c) * MAX_Q];
        for (size_t k = 0; k < fits[c].model.n_shape && !status; k++) {
            const ff_fit_value *v = &fits[c].shape_value[k];
            if (!v->held && !v->tied) *x++ = ff_coordinate(fits[c].model.shape[k].info, v->value);
        }
        ff_fit_result_clear(&fits[c]);
    }
    ff_table_clear(&table);
}

/* ---- one design ------------------------------------------------------------------------------ */

static double share_below(const double *p, size_t n, double limit)
{
    size_t below = 0;
    for (size_t i = 0; i < n; i++) below += p[i] < limit;
    return (double)below / (double)n;
}

/* Covariance [q][q] of the shape parameters of a channel, in the coordinates of the fit. */
static void covariance(const trial *t, size_t n, size_t c, double *C)
{
    const size_t q = t->q;
    double mean[MAX_Q] = {0};
    for (size_t i = 0; i < n; i++)
        for (size_t a = 0; a < q; a++) mean[a] += t->shape[(i * CHANNELS + c) * MAX_Q + a] / (double)n;
    memset(C, 0, q * q * sizeof *C);
    for (size_t i = 0; i < n; i++)
        for (size_t a = 0; a < q; a++)
            for (size_t b = 0; b < q; b++) {
                const double *x = &t->shape[(i * CHANNELS + c) * MAX_Q];
                C[a * q + b] += (x[a] - mean[a]) * (x[b] - mean[b]) / (double)(n - 1);
            }
}

/* A^-1 in place, by Gauss and Jordan; A is positive definite. */
static void invert(double *A, size_t q)
{
    for (size_t k = 0; k < q; k++) {
        const double pivot = 1 / A[k * q + k];
        A[k * q + k] = 1;
        for (size_t j = 0; j < q; j++) A[k * q + j] *= pivot;
        for (size_t i = 0; i < q; i++) {
            const double f = A[i * q + k];
            if (i == k) continue;
            A[i * q + k] = 0;
            for (size_t j = 0; j < q; j++) A[i * q + j] -= f * A[k * q + j];
        }
    }
}

/* Standard deviation of the difference of the last channel's first parameter and the weighted mean of the others', all other
 * parameters being the same: 1 / sqrt of its place in the inverse of C_last + (sum of the others' C^-1)^-1. */
static double scatter_of_difference(const trial *t, size_t n)
{
    double others[MAX_Q * MAX_Q] = {0}, C[MAX_Q * MAX_Q];
    for (size_t c = 0; c + 1 < CHANNELS; c++) {
        covariance(t, n, c, C);
        invert(C, t->q);
        for (size_t k = 0; k < t->q * t->q; k++) others[k] += C[k];
    }
    invert(others, t->q);
    covariance(t, n, CHANNELS - 1, C);
    for (size_t k = 0; k < t->q * t->q; k++) C[k] += others[k];
    invert(C, t->q);
    return 1 / sqrt(C[0]);
}

/* P(X > x) of the noncentral chi^2: a Poisson mixture of central ones (Johnson, Kotz and Balakrishnan 1995, eq. 29.4). */
static double noncentral_tail(double x, double dof, double noncentrality)
{
    double sum = 0, weight = exp(-0.5 * noncentrality);
    for (int k = 0; k < 200; k++) {
        sum += weight * ff_chi2_tail(x, dof + 2 * k);
        weight *= 0.5 * noncentrality / (k + 1);
    }
    return sum;
}

static double chi2_quantile(double tail, double dof)
{
    double lo = 0, hi = 1000;
    for (int k = 0; k < 100; k++) {
        const double mid = 0.5 * (lo + hi);
        if (ff_chi2_tail(mid, dof) > tail)
            lo = mid;
        else
            hi = mid;
    }
    return lo;
}

static int ascending(const void *a, const void *b)
{
    const double *x = a, *y = b;
    return (*x > *y) - (*x < *y);
}

static void try_design(const design *d, size_t n, ff_pool *pool)
{
    trial t = {.d = d, .factor = 1};
    double *memory = calloc(n * (3 + CHANNELS * MAX_Q), sizeof *memory);
    if (!memory) exit(1);
    t.p = memory, t.F = t.p + n, t.error_dof = t.F + n, t.shape = t.error_dof + n;
    t.q = d->shape == FF_SHAPE_CORRELATED ? 3 : strstr(d->words, "gamma") ? 2 : 1;
    const double dof = (double)(t.q * (CHANNELS - 1));
    ff_pool_run(pool, n, one_repeat, &t);
    const double size = share_below(t.p, n, 0.05), away = scatter_of_difference(&t, n);
    double mean = 0;
    for (size_t i = 0; i < n; i++) mean += t.F[i] / (double)n;
    qsort(t.error_dof, n, sizeof *t.error_dof, ascending);
    const double of_errors = t.error_dof[n / 2];
    printf("%-18s %-27s %3.0f %%  %-10s %3.0f %5.0f %7.2f %10.1f", d->grid, d->expression, 100 * d->noise,
           d->by_incidences ? "incidences" : "noise", dof, of_errors, mean, 100 * size);
    t.factor = exp(AWAY * away);
    ff_pool_run(pool, n, one_repeat, &t);
    const double power = share_below(t.p, n, 0.05), theory = noncentral_tail(chi2_quantile(0.05, dof), dof, AWAY * AWAY);
    printf("   %7.4f %6.1f %6.1f\n", t.factor, 100 * power, 100 * theory);
    fflush(stdout);
    const double more = fmax(1 / sqrt((double)n) - 1 / sqrt((double)MANY), 0);
    if (d->shown < 2)
        FF_CHECK(size > 0.02 - 5 * more * sqrt(0.05 * 0.95) && size < 0.08 + 5 * more * sqrt(0.05 * 0.95),
                 "%s %s: shapes that are the same differ in %.1f %%", d->grid, d->expression, 100 * size);
    if (!d->shown)
        FF_CHECK(fabs(power - theory) < 0.1 + 5 * more * sqrt(theory * (1 - theory)), "%s %s: %.1f %% are found of %.1f %%",
                 d->grid, d->expression, 100 * power, 100 * theory);
    free(memory);
}

int main(int argc, char **argv)
{
    const int repeats = argc > 1 ? atoi(argv[1]) : 40;
    ff_pool *pool = ff_pool_new(2);
    if (repeats < 10 || repeats > MAX_REPEATS || !pool) return 2;
    printf(
        "three channels of independent noise, %d measurements: share, per cent, in which their shapes are said to differ, and as "
        "it should be\n"
        "grid               model                       noise  errors by  dof error  mean F  one shape    factor  power    chi^2\n",
        repeats);
    for (size_t k = 0; k < sizeof designs / sizeof *designs; k++) {
        char line[160];
        snprintf(line, sizeof line, "%s %s", designs[k].grid, designs[k].expression);
        if (argc > 2 && !strstr(line, argv[2])) continue;
        try_design(&designs[k], (size_t)repeats, pool);
    }
    ff_pool_free(pool);
    printf("%ld checks, %ld failures\n", ff_test_count.checks, ff_test_count.failures);
    return ff_test_count.failures ? 1 : 0;
}
