/* apertures_test [REPEATS]: fits to what detectors of a size measure. Lobes from alpha .003 to .3, round and stretched, through
 * apertures of .1, .75 and 3 degrees, near the normal and at grazing incidence, with noise of 2 %: over REPEATS measurements the
 * mean of every parameter is the truth to a third of an error (or, of fewer than 200, as well as so many show), and 95 % intervals
 * hold it in at least 93 % of a thousand; of fewer, the band is as many standard deviations wide. Too wide intervals are not looked
 * for. */
#include "base/internal_pool.h"
#include "fit_samples.h"
#include "data_formats/interpolation/resample_struct.h"

enum { STEPS = 6, ACROSS = 3, COARSE = 9, INCIDENCES = 3, PARAMETERS = 6, ENOUGH = 200, MAX_REPEATS = 10000 };
#define NOISE 0.02

typedef struct design {
    const char *set;
    double half, theta[INCIDENCES]; /* degrees */
} design;

static const design designs[] = {
    {"alpha=0.003 f0=0.5 kd=0.05", 0.1, {5, 20, 40}},
    {"alpha=0.003 f0=0.5 kd=0.05", 0.75, {5, 20, 40}},
    {"alpha=0.02 f0=0.5 kd=0.05", 0.75, {5, 20, 40}},
    {"alpha=0.02 f0=0.5 kd=0.05", 0.75, {60, 68, 74}},
    {"alpha=0.02 f0=0.5 kd=0.05", 3, {5, 20, 40}},
    {"alpha=0.1 f0=0.5 kd=0.05", 3, {30, 60, 70}},
    {"alpha=0.3 f0=0.5 kd=0.05", 3, {5, 30, 60}},
    {"alpha=0.3 f0=0.5 kd=0.05", 0.1, {5, 30, 60}},
    {"alpha_x=0.01 alpha_y=0.05 f0=0.5 kd=0.05", 0.75, {5, 30, 60}},
    {"alpha_x=0.01 alpha_y=0.05 f0=0.5 kd=0.05", 3, {40, 60, 70}},
};
enum { DESIGNS = sizeof designs / sizeof *designs };

typedef struct trial {
    const design *d;
    const fit_surface *s;
    const ff_table *exact; /* values without noise */
    const ff_aperture *aperture;
    int *inside; /* [repeats][PARAMETERS] 1 inside, 0 outside, -1 no interval */
    double *z;   /* [repeats][PARAMETERS] (value - truth) / error             */
} trial;

/* Exits about the mirror direction, a third of what is seen of the lobe apart, and a coarse scan of the rest; of a stretched lobe
 * at four azimuths. */
static ff_table exact_values(const design *d, const fit_surface *s, const ff_aperture *a)
{
    const int stretched = s->shape[0] != s->shape[1], turns = stretched ? 4 : 1;
    const double wide = fmax(d->half, 1.3 * fmax(s->shape[0], s->shape[1]) / FIT_DEGREE),
                 fine = fmax(d->half, 1.3 * fmin(s->shape[0], s->shape[1]) / FIT_DEGREE) / 3;
    const size_t scan = (2 * STEPS + 1) * (2 * ACROSS + 1) + COARSE, n = scan * INCIDENCES * (size_t)turns;
    double *w = malloc(6 * n * sizeof *w), *planes[6];
    ff_table t;
    size_t i = 0;
    if (!w || ff_table_init(n, 1, NULL, 0, 0, &t, NULL)) exit(1);
    t.radians_per_unit = FIT_DEGREE;
    t.isotropic = 0;
    for (int turn = 0; turn < turns; turn++)
        for (int k = 0; k < INCIDENCES; k++)
            for (size_t q = 0; q < scan; q++, i++) {
                const int at = (int)q, along = at % (2 * STEPS + 1) - STEPS, over = at / (2 * STEPS + 1) - ACROSS;
                const int fine_scan = over <= ACROSS;
                const double theta = d->theta[k],
                             out = fine_scan ? theta + (stretched ? (along % 2 ? wide / 2 : fine) : fine) * along
                                             : 8.0 * (at - (int)scan + COARSE),
                             across = fine_scan ? (stretched ? wide / 2 : fine) * over / sin(fmax(theta, 2) * FIT_DEGREE) : 60;
                t.angle[0][i] = theta, t.angle[1][i] = 45.0 * turn;
                t.angle[2][i] = fmin(fabs(out), 79), t.angle[3][i] = 45.0 * turn + (out < 0 ? 0 : 180) + across;
                t.valid[i] = 1;
            }
    for (size_t k = 0; k < 6; k++) planes[k] = w + k * n;
    ff_table_directions(&t, 0, n, planes);
    const ff_dirs dirs = {planes[0], planes[1], planes[2], planes[3], planes[4], planes[5]};
    if (ff_aperture_eval(a, &s->model, FF_ISA_BEST, 1, s->shape, s->channel, &dirs, n, t.value, NULL, NULL, n)) exit(1);
    free(w);
    return t;
}

static void one_repeat(void *context, size_t repeat, int worker)
{
    const trial *t = context;
    uint64_t state = ff_test_seeded((repeat + 1) * UINT64_C(0xd1342543de82ef95) + (uint64_t)(t->d - designs));
    ff_table table;
    ff_fit_result fit;
    ff_fit_options o = fit_options();
    (void)worker;
    o.threads = 1;
    o.loss = FF_LOSS_LOG;
    o.aperture = t->aperture;
    o.shape = t->s->shape[0] == t->s->shape[1] ? FF_SHAPE_ISOTROPIC : FF_SHAPE_AXIS;
    for (size_t k = 0; k < PARAMETERS; k++) t->inside[repeat * PARAMETERS + k] = -1;
    if (ff_table_copy_into(t->exact, &table, NULL)) return;
    for (size_t i = 0; i < table.n; i++) table.value[i] *= 1 + NOISE * fit_normal(&state);
    const ff_status status = fit_table(&table, &t->s->model, &o, &fit, NULL, NULL);
    for (size_t k = 0, n = 0; !status && k < fit_parameter_count(&fit); k++) {
        char name[64];
        double truth;
        const ff_fit_value *v = fit_parameter(&fit, k, t->s, &truth, name);
        if (!v || n == PARAMETERS) continue;
        t->inside[repeat * PARAMETERS + n] = v->interval == FF_INTERVAL_NONE ? -1 : truth >= v->low && truth <= v->high;
        t->z[repeat * PARAMETERS + n++] = (v->value - truth) / v->std_error;
    }
    if (!status) ff_fit_result_clear(&fit);
    ff_table_clear(&table);
}

/* Where intervals are none in more than a part of the repeats, or z has no mean, nothing is shown. */
static void judge(const trial *t, size_t parameter, int repeats)
{
    double sum = 0, square = 0;
    int n = 0, inside = 0;
    for (int r = 0; r < repeats; r++) {
        const size_t at = (size_t)r * PARAMETERS + parameter;
        if (t->inside[at] < 0 || !isfinite(t->z[at])) continue;
        n++;
        inside += t->inside[at];
        sum += t->z[at];
        square += t->z[at] * t->z[at];
    }
    if (n == 0) return;
    const double bias = sum / n, spread = sqrt(square / n - bias * bias), share = (double)inside / n,
                 half = 0.02 * sqrt(1000.0 / n);
    printf("    %d: bias %+.2f, spread %.2f, inside %.1f %% of %d\n", (int)parameter, bias, spread, 100 * share, n);
    FF_CHECK(n >= 0.9 * repeats, "%s, %g degrees: parameter %d has an interval in %d of %d", t->d->set, t->d->half, (int)parameter,
             n, repeats);
    FF_CHECK(fabs(bias) <= 1 / 3.0 + (repeats < ENOUGH ? 3.5 / sqrt(n) : 0), "%s, %g degrees: parameter %d is off by %.2f errors",
             t->d->set, t->d->half, (int)parameter, bias);
    FF_CHECK(share >= 0.95 - half, "%s, %g degrees: %.1f %% of %d intervals of parameter %d hold the truth", t->d->set, t->d->half,
             100 * share, n, (int)parameter);
}

static int run(const design *d, int repeats, ff_pool *pool)
{
    const fit_surface s = fit_surface_make("ggx+lambert", 1, d->set);
    const ff_aperture a = {.outline = FF_APERTURE_DISC, .half = d->half * FIT_DEGREE};
    const size_t size = (size_t)repeats * PARAMETERS;
    ff_table exact = exact_values(d, &s, &a);
    trial t = {d, &s, &exact, &a, malloc(size * sizeof *t.inside), calloc(size, sizeof *t.z)};
    if (!t.inside || !t.z) return 1;
    printf("  %s, %g degrees, incidence up to %g, %zu samples\n", d->set, d->half, d->theta[INCIDENCES - 1], exact.n);
    ff_pool_run(pool, (size_t)repeats, one_repeat, &t);
    for (size_t k = 0; k < PARAMETERS; k++) judge(&t, k, repeats);
    free(t.inside);
    free(t.z);
    ff_table_clear(&exact);
    return 0;
}

int main(int argc, char **argv)
{
    const int repeats = argc > 1 ? atoi(argv[1]) : 3;
    ff_pool *pool = ff_pool_new(2);
    if (repeats < 2 || repeats > MAX_REPEATS || !pool) return 2;
    for (size_t k = 0; k < DESIGNS; k++)
        if (run(&designs[k], repeats, pool)) return 2;
    ff_pool_free(pool);
    printf("%ld checks, %ld failures\n", ff_test_count.checks, ff_test_count.failures);
    return ff_test_count.failures ? 1 : 0;
}
