/* What the uncertainties of an instrument add to a fit, against fits to data that are off by as much. */
#include "fit_samples.h"
#include "fit/trust/trust_struct.h"

/* A goniometer in the plane of incidence: settings of the light, and of the detector from the light's side (below 0) to the other.
 */
enum { SETTINGS = 5, READINGS = 57, N = SETTINGS * READINGS, CHANNELS = 2, PARAMETERS = 1 + 2 * CHANNELS };
static const double setting[SETTINGS] = {10, 25, 40, 55, 65};

static double reading(int k)
{
    return -70 + 2.5 * k;
}

/* By how much each angle, degrees, all values and the aperture are off. */
typedef struct fault {
    double incidence[SETTINGS], detector[N], scale, aperture;
} fault;

static void put_angles(ff_table *t, const fault *off)
{
    double *theta_i = ff_table_angle_plane(t, 0), *phi_i = ff_table_angle_plane(t, 1), *theta_o = ff_table_angle_plane(t, 2),
           *phi_o = ff_table_angle_plane(t, 3);
    for (int k = 0; k < N; k++) {
        const double at = reading(k % READINGS) + off->detector[k];
        theta_i[k] = setting[k / READINGS] + off->incidence[k / READINGS];
        phi_i[k] = 0;
        theta_o[k] = fabs(at);
        phi_o[k] = at > 0 ? 180 : 0;
    }
}

/* What is measured, with noise of 0.5 %. */
static ff_table measure(const fit_surface *s, const ff_aperture *a, uint64_t seed)
{
    static const fault none;
    ff_table t;
    double w[6][N], *const planes[6] = {w[0], w[1], w[2], w[3], w[4], w[5]};
    uint64_t state = ff_test_seeded(seed);
    if (ff_table_init(N, CHANNELS, NULL, 0, 0, &t, NULL)) exit(1);
    t.radians_per_unit = FIT_DEGREE;
    t.isotropic = 1;
    put_angles(&t, &none);
    ff_table_directions(&t, 0, N, planes);
    const ff_dirs dirs = {w[0], w[1], w[2], w[3], w[4], w[5]};
    if (ff_aperture_eval(a, &s->model, FF_ISA_BEST, CHANNELS, s->shape, s->channel, &dirs, N, t.value, NULL, NULL, N)) exit(1);
    for (size_t k = 0; k < N * CHANNELS; k++) t.value[k] *= 1 + 0.005 * fit_normal(&state);
    return t;
}

typedef struct bench {
    fit_surface s;
    ff_aperture a;
    ff_table t;
    ff_problem *p;
    ff_places *places;
    ff_fit_options o;
    ff_fit_result fit;
    double shape[FF_MAX_SHAPE], channel[CHANNELS * FF_MAX_CHANNEL_PARAMS];
} bench;

static void values_of(const ff_fit_result *fit, double out[PARAMETERS])
{
    out[0] = ff_fit_result_find(fit, "alpha_x", 0)->value;
    for (size_t c = 0; c < CHANNELS; c++) {
        out[1 + 2 * c] = ff_fit_result_find(fit, "f0", c)->value;
        out[2 + 2 * c] = ff_fit_result_find(fit, "kd", c)->value;
    }
}

static const ff_fit_value *parameter(const ff_fit_result *fit, int k)
{
    return k == 0 ? ff_fit_result_find(fit, "alpha_x", 0) : ff_fit_result_find(fit, k % 2 ? "f0" : "kd", (size_t)(k - 1) / 2);
}

static void set_up(bench *b, double alpha, double half)
{
    ff_error err = {0};
    char words[64];
    snprintf(words, sizeof words, "alpha=%g f0=0.5 kd=0.1", alpha);
    b->s = fit_surface_make("ggx+lambert", CHANNELS, words);
    b->a = (ff_aperture){.outline = FF_APERTURE_DISC, .half = half * FIT_DEGREE};
    b->t = measure(&b->s, &b->a, 11);
    b->o = fit_options();
    b->o.aperture = &b->a;
    if (ff_problem_make(&b->t, &b->s.model, 1, &b->o, &b->p, &err) ||
        ff_problem_fit_into(b->p, &b->s.model, &b->o, &b->fit, &err) || ff_places_new(b->p, &b->t, &b->places, &err)) {
        printf("the fit failed: %s\n", err.message);
        exit(1);
    }
    ff_fit_result_values(&b->fit, b->shape, b->channel);
}

static void take_down(bench *b)
{
    ff_fit_result_clear(&b->fit);
    ff_places_free(b->places);
    ff_problem_free(b->p);
    ff_table_clear(&b->t);
}

/* The fit to the same values, where the instrument says what it says with a fault. */
static void refit(bench *b, const fault *off, double out[PARAMETERS])
{
    static const fault none;
    ff_fit_options o = b->o;
    ff_aperture a = b->a;
    ff_problem *p = NULL;
    ff_fit_result fit;
    a.half += off->aperture * FIT_DEGREE;
    o.aperture = &a;
    o.std_errors = 0;
    o.start_shape = b->shape;
    o.start_channel = b->channel;
    put_angles(&b->t, off);
    for (size_t k = 0; k < N * CHANNELS; k++) b->t.value[k] *= 1 + off->scale;
    if (ff_problem_make(&b->t, &b->s.model, 1, &o, &p, NULL) || ff_problem_fit_into(p, &b->s.model, &o, &fit, NULL)) exit(1);
    for (size_t k = 0; k < N * CHANNELS; k++) b->t.value[k] /= 1 + off->scale;
    put_angles(&b->t, &none);
    values_of(&fit, out);
    ff_fit_result_clear(&fit);
    ff_problem_free(p);
}

/* ---- every source by itself -------------------------------------------------------------------- */

/* A fault of source s by `by`: of setting or reading `one`, where these are meant by themselves. */
static fault fault_of(int s, int one, double by)
{
    fault off = {.scale = s == FF_BUDGET_SCALE ? by : 0, .aperture = s == FF_BUDGET_APERTURE ? by : 0};
    for (int k = 0; k < SETTINGS; k++)
        if (s == FF_BUDGET_INCIDENCE_OFFSET || (s == FF_BUDGET_INCIDENCES && k == one)) off.incidence[k] = by;
    for (int k = 0; k < N; k++)
        if (s == FF_BUDGET_DETECTOR_OFFSET || (s == FF_BUDGET_READINGS && k == one)) off.detector[k] = by;
    return off;
}

/* The root of the sum of squares of what each fault moves the optimum by. */
static void by_refits(bench *b, int s, double by, double out[PARAMETERS])
{
    const int n = s == FF_BUDGET_INCIDENCES ? SETTINGS : s == FF_BUDGET_READINGS ? N : 1;
    memset(out, 0, PARAMETERS * sizeof *out);
    for (int one = 0; one < n; one++) {
        double less[PARAMETERS], more[PARAMETERS];
        const fault down = fault_of(s, one, -by), up = fault_of(s, one, by);
        refit(b, &down, less);
        refit(b, &up, more);
        for (int k = 0; k < PARAMETERS; k++) out[k] += 0.25 * (more[k] - less[k]) * (more[k] - less[k]);
    }
    for (int k = 0; k < PARAMETERS; k++) out[k] = sqrt(out[k]);
}

static const double stated[FF_BUDGET_SOURCES] = {0.02, 0.05, 0.05, 0.05, 0.05, 0.02};

static ff_budget_options uncertainties(int aperture)
{
    ff_budget_options u;
    ff_budget_options_init(&u);
    u.scale = stated[FF_BUDGET_SCALE];
    u.offset = stated[FF_BUDGET_DETECTOR_OFFSET] * FIT_DEGREE;
    u.angle = stated[FF_BUDGET_READINGS] * FIT_DEGREE;
    u.aperture = aperture ? stated[FF_BUDGET_APERTURE] * FIT_DEGREE : 0;
    return u;
}

/* What is left out is of second order: 2 % of a contribution, or 1e-3 of the whole where others are that much larger. It is more
 * for one seed of twenty, where H misses what the residuals times the model's second derivatives add (reports/seeds.md). Fits know
 * means over an aperture to FF_APERTURE_OF_FITS, and so their parameters. */
static void compare_with_refits(double alpha, double half)
{
    bench b;
    ff_budget *budget = NULL;
    set_up(&b, alpha, half);
    const ff_budget_options u = uncertainties(half > 0);
    if (FF_CHECK(ff_trust_budget(b.p, &b.t, b.places, &b.o, &b.fit, &u, &budget, NULL) == FF_OK, "budget"))
        for (int s = 0; s < FF_BUDGET_SOURCES; s++) {
            double expected[PARAMETERS];
            FF_CHECK((budget->by[s] != NULL) == (half > 0 || s != FF_BUDGET_APERTURE), "source %d", s);
            if (!budget->by[s]) continue;
            by_refits(&b, s, stated[s], expected);
            for (int k = 0; k < PARAMETERS; k++) {
                const int column = parameter(&b.fit, k)->column;
                const double rough = half > 0 ? FF_APERTURE_OF_FITS * parameter(&b.fit, k)->value : 0;
                FF_CHECK(fabs(budget->by[s][column] - expected[k]) < 0.02 * expected[k] + 1e-3 * budget->combined[column] + rough,
                         "alpha %g, aperture %g, %s, parameter %d: %g, by refits %g", alpha, half, ff_budget_source_name(s), k,
                         budget->by[s][column], expected[k]);
            }
        }
    ff_budget_free(budget);
    take_down(&b);
}

static void of_points(void)
{
    compare_with_refits(0.1, 0);
    compare_with_refits(0.4, 0);
}

static void of_apertures(void)
{
    compare_with_refits(0.1, 1);
    compare_with_refits(0.04, 2);
}

/* The whole is the root of the sum of squares, readings left out; with nothing stated it is the random error. */
static void sums(void)
{
    bench b;
    ff_budget *budget = NULL, *nothing = NULL;
    ff_budget_options u = uncertainties(0), none;
    set_up(&b, 0.2, 0);
    ff_budget_options_init(&none);
    if (FF_CHECK(!ff_trust_budget(b.p, &b.t, b.places, &b.o, &b.fit, &u, &budget, NULL) &&
                     !ff_trust_budget(b.p, &b.t, b.places, &b.o, &b.fit, &none, &nothing, NULL),
                 "budget"))
        for (int k = 0; k < PARAMETERS; k++) {
            const ff_fit_value *v = parameter(&b.fit, k);
            double sum = v->std_error * v->std_error;
            for (int s = 0; s < FF_BUDGET_SOURCES; s++)
                if (budget->by[s] && s != FF_BUDGET_READINGS) sum += budget->by[s][v->column] * budget->by[s][v->column];
            FF_CHECK_CLOSE(budget->combined[v->column], sqrt(sum), 1e-14, 0);
            FF_CHECK(budget->combined[v->column] > budget->random[v->column], "parameter %d", k);
            FF_CHECK_CLOSE(nothing->combined[v->column], v->std_error, 1e-14, 0);
        }
    ff_budget_free(budget);
    ff_budget_free(nothing);
    take_down(&b);
}

/* ---- all at once ------------------------------------------------------------------------------- */

/* Normal faults of all sources together: the optima scatter by the root of the sum of squares of the contributions.
 * $FACETFIT_REPEATS sets their number; what a standard deviation of so many scatters by, five times. */
static void scatter(void)
{
    const int repeats = fit_repeats(150, 600);
    bench b;
    ff_budget *budget = NULL;
    uint64_t state = ff_test_seeded(5);
    double sum[PARAMETERS] = {0}, square[PARAMETERS] = {0};
    set_up(&b, 0.1, 1);
    const ff_budget_options u = uncertainties(1);
    if (!FF_CHECK(!ff_trust_budget(b.p, &b.t, b.places, &b.o, &b.fit, &u, &budget, NULL), "budget")) exit(1);
    for (int r = 0; r < repeats; r++) {
        double found[PARAMETERS], zero_i = stated[FF_BUDGET_INCIDENCE_OFFSET] * fit_normal(&state),
                                  zero_o = stated[FF_BUDGET_DETECTOR_OFFSET] * fit_normal(&state);
        fault off = {.scale = stated[FF_BUDGET_SCALE] * fit_normal(&state),
                     .aperture = stated[FF_BUDGET_APERTURE] * fit_normal(&state)};
        for (int k = 0; k < SETTINGS; k++) off.incidence[k] = zero_i + stated[FF_BUDGET_INCIDENCES] * fit_normal(&state);
        for (int k = 0; k < N; k++) off.detector[k] = zero_o + stated[FF_BUDGET_READINGS] * fit_normal(&state);
        refit(&b, &off, found);
        for (int k = 0; k < PARAMETERS; k++) {
            const double d = found[k] - parameter(&b.fit, k)->value;
            sum[k] += d;
            square[k] += d * d;
        }
    }
    for (int k = 0; k < PARAMETERS; k++) {
        const double mean = sum[k] / repeats, deviation = sqrt((square[k] - repeats * mean * mean) / (repeats - 1));
        double expected = 0;
        for (int s = 0; s < FF_BUDGET_SOURCES; s++) {
            const double one = budget->by[s][parameter(&b.fit, k)->column];
            expected += one * one;
        }
        printf("parameter %d: %g, the budget says %g\n", k, deviation, sqrt(expected));
        FF_CHECK_CLOSE(deviation, sqrt(expected), 5 / sqrt(2.0 * repeats), 0);
    }
    ff_budget_free(budget);
    take_down(&b);
}

/* What is no uncertainty is refused, and what nobody can find. */
static void refusals(void)
{
    bench b;
    ff_budget *budget = NULL;
    ff_error err;
    set_up(&b, 0.2, 0);
    const double wrong[] = {-0.1, 2, NAN, INFINITY};
    for (size_t k = 0; k < 4 * sizeof wrong / sizeof *wrong; k++) {
        ff_budget_options u;
        ff_budget_options_init(&u);
        *(k % 4 == 0 ? &u.scale : k % 4 == 1 ? &u.offset : k % 4 == 2 ? &u.angle : &u.aperture) = wrong[k / 4];
        FF_CHECK(ff_trust_budget(b.p, &b.t, b.places, &b.o, &b.fit, &u, &budget, &err) == FF_ERR_RANGE && !budget, "%zu: %s", k,
                 err.message);
    }
    ff_budget_options u = uncertainties(1);
    FF_CHECK(ff_trust_budget(b.p, &b.t, b.places, &b.o, &b.fit, &u, &budget, &err) == FF_ERR_UNSUPPORTED, "of a point");
    b.o.robust = FF_ROBUST_HUBER;
    b.o.robust_scale = 1;
    u.aperture = 0;
    FF_CHECK(ff_trust_budget(b.p, &b.t, b.places, &b.o, &b.fit, &u, &budget, &err) == FF_ERR_UNSUPPORTED, "robust");
    FF_CHECK(ff_budget_source_name(-1) == NULL && ff_budget_source_name(FF_BUDGET_SOURCES) == NULL, "names");
    take_down(&b);
}

FF_TEST_MAIN(FF_TEST(of_points), FF_TEST(of_apertures), FF_TEST(sums), FF_TEST(scatter), FF_TEST(refusals))
