/* noise_designs_test [REPEATS [WORD [residuals]]]: do 95 % intervals hold the truth on designs that people have? Coarse grids,
 * in-plane scans, few incidences, scattered pairs, anisotropic samples; noise in proportion, of the detector, of both, and of other
 * kinds than the model of the noise knows. Only those whose line has WORD. A table: share of REPEATS simulated measurements whose
 * interval holds the truth, and behind it the median half-width over 1.96 standard deviations of the estimates. Independent noise
 * of the model's form must lie in 92.5 to 97.5 % with a half-width of 0.7 to 1.3; other noise in 91 to 98 %; of fewer repeats than
 * a thousand the bands are as many standard deviations wider. The seeds are 1 .. REPEATS. */
#include "fit_samples.h"
#include "base/internal_pool.h"
#include "base/internal_statistics.h"
#include "simulate/simulate_struct.h"

enum { MAX_PARAMETERS = 16, MAX_REPEATS = 100000, MAX_SAMPLES = 20000, MANY = 1000 };

typedef enum kind { MULTIPLICATIVE, ADDITIVE, MIXED, BY_INCIDENCE, BY_COSINE, STUDENT_5, ALONG_SCAN } kind;
static const char *const kind_name[] = {"relative", "additive", "mixed", "by incidence", "by cosine", "t of 5", "AR .7"};

typedef struct design {
    const char *name, *grid, *expression, *words; /* grid NULL: by name, see directions */
    ff_shape shape;
    kind noise;
    double relative, floor;
} design;

#define GGX       "ggx+lambert", "alpha=0.2 f0=0.5 kd=0.1"
#define BECKMANN  "beckmann+lambert", "alpha=0.2 f0=0.5 kd=0.1"
#define STUDENT_T "student-t/v-cavity+lambert", "alpha=0.2 gamma=2.5 f0=0.4 kd=0.1"
#define GLOSSY    "ggx+lambert", "alpha=0.15 f0=0.04 kd=0.3"
#define ROUGH     "ggx+lambert", "alpha=0.3 f0=0.5 kd=0.1"
#define BRUSHED   "ggx+lambert", "alpha_x=0.25 alpha_y=0.15 r_xy=-0.3 f0=0.5 kd=0.1"
static const design designs[] = {{"goniometer:10", "goniometer:10", GGX, FF_SHAPE_ISOTROPIC, MULTIPLICATIVE, 0.05, 0},
                                 {"goniometer:10", "goniometer:10", BECKMANN, FF_SHAPE_ISOTROPIC, MULTIPLICATIVE, 0.05, 0},
                                 {"goniometer:10", "goniometer:10", GGX, FF_SHAPE_ISOTROPIC, ADDITIVE, 0, 0.02},
                                 {"goniometer:10", "goniometer:10", GGX, FF_SHAPE_ISOTROPIC, MIXED, 0.03, 0.01},
                                 {"goniometer:5", "goniometer:5", GGX, FF_SHAPE_ISOTROPIC, MULTIPLICATIVE, 0.02, 0},
                                 {"ten in plane", NULL, GGX, FF_SHAPE_ISOTROPIC, MULTIPLICATIVE, 0.05, 0},
                                 {"plane, 4", NULL, STUDENT_T, FF_SHAPE_ISOTROPIC, MULTIPLICATIVE, 0.05, 0},
                                 {"plane, 4", NULL, GGX, FF_SHAPE_ISOTROPIC, ADDITIVE, 0, 0.02},
                                 {"plane, 7", NULL, GGX, FF_SHAPE_ISOTROPIC, MULTIPLICATIVE, 0.05, 0},
                                 {"plane, 7", NULL, BECKMANN, FF_SHAPE_ISOTROPIC, MULTIPLICATIVE, 0.05, 0},
                                 {"572 at 4", NULL, ROUGH, FF_SHAPE_ISOTROPIC, MULTIPLICATIVE, 0.05, 0},
                                 {"572 at 4", NULL, ROUGH, FF_SHAPE_ISOTROPIC, ADDITIVE, 0, 0.02},
                                 {"scattered:300", "scattered:300:0.5", GLOSSY, FF_SHAPE_ISOTROPIC, MULTIPLICATIVE, 0.05, 0},
                                 {"brushed", NULL, BRUSHED, FF_SHAPE_CORRELATED, MULTIPLICATIVE, 0.1, 0},
                                 {"572 at 4", NULL, ROUGH, FF_SHAPE_ISOTROPIC, BY_INCIDENCE, 0, 0},
                                 {"572 at 4", NULL, ROUGH, FF_SHAPE_ISOTROPIC, BY_COSINE, 0, 0.02},
                                 {"572 at 4", NULL, ROUGH, FF_SHAPE_ISOTROPIC, STUDENT_5, 0.05, 0},
                                 {"572 at 4", NULL, ROUGH, FF_SHAPE_ISOTROPIC, ALONG_SCAN, 0.05, 0},
                                 {"goniometer:10", "goniometer:10", GGX, FF_SHAPE_ISOTROPIC, ALONG_SCAN, 0.05, 0},
                                 {"plane, 7", NULL, GGX, FF_SHAPE_ISOTROPIC, ALONG_SCAN, 0.05, 0},
                                 {"goniometer:10", "goniometer:10", GGX, FF_SHAPE_ISOTROPIC, BY_INCIDENCE, 0, 0}};

/* ---- measurements ---------------------------------------------------------------------------- */

typedef struct pairs {
    size_t n;
    double angle[MAX_SAMPLES][4]; /* degrees */
} pairs;

static void add(pairs *p, double theta_i, double phi_i, double theta_o, double phi_o)
{
    const double angle[4] = {theta_i, phi_i, theta_o, phi_o};
    if (p->n < MAX_SAMPLES) memcpy(p->angle[p->n++], angle, sizeof angle);
}

/* In the plane of incidence the detector goes from behind the light to the mirror side. */
static void directions(const char *name, pairs *p)
{
    static const int four[] = {15, 35, 55, 70};
    p->n = 0;
    for (int k = 0; k < 4 && strcmp(name, "plane, 4") == 0; k++)
        for (int scan = -75; scan <= 75; scan += 5) add(p, four[k], 0, abs(scan), scan >= 0 ? 180 : 0);
    for (int scan = 20; scan <= 65 && strcmp(name, "ten in plane") == 0; scan += 5) add(p, 45, 0, scan, 180);
    for (int i = 10; i <= 70 && strcmp(name, "plane, 7") == 0; i += 10)
        for (int scan = -78; scan <= 78; scan += 3) add(p, i, 0, abs(scan), scan >= 0 ? 180 : 0);
    for (int i = 10; i <= 70 && strcmp(name, "572 at 4") == 0; i += 20)
        for (int o = 0; o <= 80; o += 8)
            for (int phi = 0; phi <= 180; phi += 15) add(p, i, 0, o, phi);
    for (int i = 0; i <= 75 && strcmp(name, "brushed") == 0; i += 15)
        for (int turn = 0; turn < 180; turn += 45)
            for (int o = 0; o <= 80; o += 10)
                for (int phi = 0; phi < 360; phi += 10) add(p, i, turn, o, phi);
}

/* Without noise. */
static ff_table clean(const design *d, const fit_surface *s, uint64_t seed)
{
    ff_table t;
    ff_error err = {0};
    ff_status status = FF_OK;
    if (d->grid) {
        ff_simulate_options o;
        ff_simulate_options_init(&o);
        o.seed = seed;
        status = ff_sampling_parse(d->grid, &o.sampling, &err);
        if (!status) status = ff_simulate_into(&s->model, s->n_channels, s->shape, s->channel, &o, &t, &err);
    } else {
        pairs *p = malloc(sizeof *p);
        if (!p) exit(1);
        directions(d->name, p);
        status = ff_table_init(p->n, s->n_channels, NULL, 0, 0, &t, &err);
        for (size_t i = 0; i < p->n && !status; i++)
            for (int k = 0; k < 4; k++) t.angle[k][i] = p->angle[i][k] * FIT_DEGREE;
        free(p);
        if (!status) {
            t.radians_per_unit = 1;
            t.isotropic = d->shape == FF_SHAPE_ISOTROPIC;
            fit_evaluate(s, &t);
        }
    }
    if (status) {
        printf("the test itself is wrong: %s\n", err.message);
        exit(1);
    }
    return t;
}

/* Standard t of five degrees of freedom, of variance 1. */
static double student_5(uint64_t *state)
{
    double squares = 0;
    const double z = fit_normal(state);
    for (int k = 0; k < 5; k++) {
        const double x = fit_normal(state);
        squares += x * x;
    }
    return z / sqrt(squares / 5) / sqrt(5.0 / 3);
}

static void disturb(const design *d, ff_table *t, uint64_t *state)
{
    double along = 0, before = -1;
    for (size_t i = 0; i < t->n; i++) {
        double w[6], *const planes[6] = {w, w + 1, w + 2, w + 3, w + 4, w + 5}, *y = &t->value[i];
        ff_table_directions(t, i, 1, planes);
        const double theta = acos(fmin(w[2], 1)) / FIT_DEGREE;
        const int starts = fabs(theta - before) > 1e-6;
        before = theta;
        switch (d->noise) {
        case MULTIPLICATIVE:
            *y *= 1 + d->relative * fit_normal(state);
            break;
        case ADDITIVE:
            *y += d->floor * fit_normal(state);
            break;
        case MIXED:
            *y += *y * d->relative * fit_normal(state) + d->floor * fit_normal(state);
            break;
        case BY_INCIDENCE:
            *y *= 1 + (0.02 + 0.08 * theta / 75) * fit_normal(state);
            break;
        case BY_COSINE:
            *y += d->floor / fmax(0.17, w[2]) * fit_normal(state);
            break;
        case STUDENT_5:
            *y *= 1 + d->relative * student_5(state);
            break;
        case ALONG_SCAN:
            along = starts ? fit_normal(state) : 0.7 * along + sqrt(1 - 0.49) * fit_normal(state);
            *y *= 1 + d->relative * along;
            break;
        }
    }
}

/* ---- one design ------------------------------------------------------------------------------ */

typedef struct trial {
    const design *d;
    ff_error_source errors; /* those by residuals are shown and not judged */
    const fit_surface *s;
    double *value, *half; /* [repeats][MAX_PARAMETERS]; half-width NaN: no interval */
    char *inside;
} trial;

static void one_repeat(void *context, size_t repeat, int worker)
{
    const trial *t = context;
    (void)worker;
    ff_table table = clean(t->d, t->s, 1 + repeat);
    uint64_t state = ff_test_seeded((1 + repeat) * UINT64_C(0xd1342543de82ef95));
    disturb(t->d, &table, &state);
    ff_fit_options o;
    ff_fit_options_init(&o);
    o.threads = 1;
    o.shape = t->d->shape;
    o.errors = t->errors;
    ff_problem *p = NULL;
    ff_fit_result fit = {.n_channels = 0};
    ff_status status = ff_problem_make(&table, &t->s->model, 1, &o, &p, NULL);
    if (!status) status = ff_problem_fit_into(p, &t->s->model, &o, &fit, NULL);
    for (size_t k = 0; k < MAX_PARAMETERS; k++) t->half[repeat * MAX_PARAMETERS + k] = NAN;
    for (size_t k = 0; k < fit_parameter_count(&fit) && k < MAX_PARAMETERS && !status; k++) {
        char name[64];
        double truth;
        const size_t at = repeat * MAX_PARAMETERS + k;
        const ff_fit_value *v = fit_parameter(&fit, k, t->s, &truth, name);
        if (!v || v->interval == FF_INTERVAL_NONE) continue;
        t->value[at] = v->value;
        t->half[at] = 0.5 * (v->high - v->low);
        t->inside[at] = truth >= v->low && truth <= v->high;
    }
    if (!status) ff_fit_result_clear(&fit);
    ff_problem_free(p);
    ff_table_clear(&table);
}

static int ascending(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* Prints the cell of parameter k and checks it. */
static void judge(const trial *t, const char *line, const char *name, size_t k, size_t repeats, double *half)
{
    double n = 0, in = 0, sum = 0, square = 0;
    size_t widths = 0;
    for (size_t i = 0; i < repeats; i++) {
        const size_t at = i * MAX_PARAMETERS + k;
        if (isnan(t->half[at])) continue;
        n++;
        in += t->inside[at];
        sum += t->value[at];
        square += t->value[at] * t->value[at];
        half[widths++] = t->half[at];
    }
    if (n < 0.5 * (double)repeats) return;
    qsort(half, widths, sizeof *half, ascending);
    const double share = in / n, wide = half[widths / 2] / (FF_NORMAL_975 * sqrt(fmax(square / n - sum * sum / n / n, 1e-300))),
                 scatter = sqrt(0.95 * 0.05 / n),
                 more = 3 * (scatter - sqrt(0.95 * 0.05 / 1000)) > 0 ? 3 * (scatter - sqrt(0.95 * 0.05 / 1000)) : 0;
    const int known = t->d->noise <= MIXED;
    printf("  %s %.1f (%.2f)", name, 100 * share, wide);
    if (t->errors == FF_ERRORS_RESIDUALS) return;
    FF_CHECK(share >= (known ? 0.925 : 0.91) - more && share <= (known ? 0.975 : 0.98) + more, "%s: %s inside in %.1f %%", line,
             name, 100 * share);
    if (known) FF_CHECK(wide > 0.7 - more && wide < 1.3 + more, "%s: the half-width of %s is %.2f of what it is", line, name, wide);
}

static void try_design(const design *d, ff_error_source errors, const char *line, size_t repeats, ff_pool *pool)
{
    const fit_surface s = fit_surface_make(d->expression, 1, d->words);
    trial t = {.d = d,
               .errors = errors,
               .s = &s,
               .value = calloc(repeats * MAX_PARAMETERS, sizeof(double)),
               .half = calloc(repeats * MAX_PARAMETERS, sizeof(double)),
               .inside = calloc(repeats * MAX_PARAMETERS, 1)};
    double *half = malloc(repeats * sizeof *half);
    if (!t.value || !t.half || !t.inside || !half) exit(1);
    ff_pool_run(pool, repeats, one_repeat, &t);
    printf("%-58s", line);
    for (size_t k = 0; k < s.model.n_shape + s.model.n_channel && k < MAX_PARAMETERS; k++) {
        const ff_model_param *p = k < s.model.n_shape ? &s.model.shape[k] : &s.model.channel[k - s.model.n_shape];
        if (strcmp(p->name, "alpha_y") == 0 && d->shape == FF_SHAPE_ISOTROPIC) continue;
        judge(&t, line, p->name, k, repeats, half);
    }
    printf("\n");
    fflush(stdout);
    free(t.value);
    free(t.half);
    free(t.inside);
    free(half);
}

int main(int argc, char **argv)
{
    const int repeats = argc > 1 ? atoi(argv[1]) : 40;
    const ff_error_source errors = argc > 3 && strcmp(argv[3], "residuals") == 0 ? FF_ERRORS_RESIDUALS : FF_ERRORS_NOISE;
    ff_pool *pool = ff_pool_new(2);
    if (repeats < 10 || repeats > MAX_REPEATS || !pool) return 2;
    printf(
        "share of %d measurements whose 95 %% interval holds the truth, per cent; its half-width over 1.96 standard deviations\n",
        repeats);
    for (size_t k = 0; k < sizeof designs / sizeof *designs; k++) {
        const design *d = &designs[k];
        char line[160];
        snprintf(line, sizeof line, "%-14s %-28s %s", d->name, d->expression, kind_name[d->noise]);
        if (argc > 2 && !strstr(line, argv[2])) continue;
        if (repeats < MANY && strcmp(d->name, "ten in plane") == 0) continue;
        try_design(d, errors, line, (size_t)repeats, pool);
    }
    ff_pool_free(pool);
    printf("%ld checks, %ld failures\n", ff_test_count.checks, ff_test_count.failures);
    return ff_test_count.failures ? 1 : 0;
}
