/* noise_designs_test [REPEATS [METHOD [WORD]]]: do 95 % intervals hold the truth on designs that people have? Coarse grids,
 * in-plane scans, few incidences, scattered pairs, anisotropic samples; noise in proportion, of the detector, of both, and of other
 * kinds than the model of the noise knows. METHOD: noise, the errors of a fit; weights, a fit with weights by the noise and errors
 * by leaving out incidences; bootstrap, profile, and both with weights by the noise; residuals, shown and not judged. Only lines
 * that have WORD. A table: share of REPEATS simulated measurements whose interval holds the truth, and behind it the median
 * half-width over 1.96 standard deviations of the estimates. Independent noise of the model's form must lie in 92.5 to 97.5 %, the
 * mean of a design in 94 to 96 %, with a half-width of 0.7 to 1.3 (of errors by incidences times Student's t of their number less
 * one over 1.96, and a quarter more below twenty); other noise in 91 to 98 %; of fewer repeats than a thousand the bands are as
 * many standard deviations wider. A model that is not that of the surface is shown: what its parameters would be on data without
 * noise stands for the truth. The seeds are 1 .. REPEATS. */
#include "fit_samples.h"
#include "base/internal_pool.h"
#include "base/internal_statistics.h"
#include "simulate/simulate_struct.h"
#include "trust_struct.h"

enum { MAX_PARAMETERS = 16, MAX_REPEATS = 100000, MAX_SAMPLES = 20000, MANY = 1000, MANY_CHANNELS = 31 };

typedef enum kind { MULTIPLICATIVE, ADDITIVE, MIXED, BY_INCIDENCE, BY_COSINE, STUDENT_5, ALONG_SCAN, GAIN } kind;
static const char *const kind_name[] = {"relative", "additive", "mixed", "by incidence", "by cosine", "t of 5", "AR .7", "gain"};

typedef enum method { NOISE, WEIGHTS, RESIDUALS, BOOTSTRAP, PROFILE, WEIGHTS_PROFILE, WEIGHTS_BOOTSTRAP, METHODS } method;
static const char *const method_name[METHODS] = {"noise",   "weights",         "residuals",        "bootstrap",
                                                 "profile", "weights-profile", "weights-bootstrap"};

typedef struct geometry {
    const char *name, *grid; /* grid NULL: by name, see directions */
    ff_shape shape;
    double relative, floor; /* of its noise */
} geometry;

static const geometry geometries[] = {{"goniometer:10", "goniometer:10", FF_SHAPE_ISOTROPIC, 0.05, 0.02},
                                      {"goniometer:5", "goniometer:5", FF_SHAPE_ISOTROPIC, 0.02, 0.02},
                                      {"plane, 4", NULL, FF_SHAPE_ISOTROPIC, 0.05, 0.02},
                                      {"plane, 7", NULL, FF_SHAPE_ISOTROPIC, 0.05, 0.02},
                                      {"572 at 4", NULL, FF_SHAPE_ISOTROPIC, 0.05, 0.02},
                                      {"scattered:300", "scattered:300:0.5", FF_SHAPE_ISOTROPIC, 0.05, 0.02},
                                      {"brushed", NULL, FF_SHAPE_CORRELATED, 0.1, 0.02}};
enum { GEOMETRIES = sizeof geometries / sizeof *geometries };

typedef struct surface {
    const char *expression, *fitted; /* NULL: the same */
    const char *words;               /* without the roughness of a stretched surface */
    const char *round;               /* its roughness where it is not stretched */
    size_t channels;
} surface;

#define GGX                                                                                                                        \
    {                                                                                                                              \
        "ggx+lambert", NULL, "f0=0.5 kd=0.1", "alpha=0.2", 1                                                                       \
    }
#define BECKMANN                                                                                                                   \
    {                                                                                                                              \
        "beckmann+lambert", NULL, "f0=0.5 kd=0.1", "alpha=0.2", 1                                                                  \
    }
#define STUDENT_T                                                                                                                  \
    {                                                                                                                              \
        "student-t/v-cavity+lambert", NULL, "gamma=2.5 f0=0.4 kd=0.1", "alpha=0.2", 1                                              \
    }
#define TWO_LOBES                                                                                                                  \
    {                                                                                                                              \
        "ggx+ggx+lambert", NULL, "f0=0.4 lobe2.alpha=0.5 lobe2.f0=0.2 kd=0.1", "alpha=0.12", 1                                     \
    }
#define SPECTRUM                                                                                                                   \
    {                                                                                                                              \
        "ggx+lambert", NULL, "f0=0.5 kd=0.1", "alpha=0.2", MANY_CHANNELS                                                           \
    }
#define REST "f0=0.5 kd=0.1"
/* that of ./setup demo, on its grid */
#define DEMO                                                                                                                       \
    {                                                                                                                              \
        "ggx/v-cavity+lambert", NULL, "f0=0.9:0.6:0.3 kd=0.1:0.05:0.02", "alpha=0.45", 3                                           \
    }
#define WRONG                                                                                                                      \
    {                                                                                                                              \
        "student-t+lambert", "ggx+lambert", "gamma=3 f0=0.5 kd=0.1", "alpha=0.2", 1                                                \
    }

typedef struct design {
    const geometry *at;
    surface s;
    kind noise;
} design;

/* ---- which ----------------------------------------------------------------------------------- */

typedef struct list {
    size_t n;
    design d[256];
} list;

static void add_design(list *l, size_t geometry, surface s, kind noise)
{
    if (l->n < sizeof l->d / sizeof *l->d) l->d[l->n++] = (design){&geometries[geometry], s, noise};
}

static size_t geometry_of(const char *name)
{
    size_t k = 0;
    while (k < GEOMETRIES - 1 && strcmp(geometries[k].name, name) != 0) k++;
    return k;
}

/* Every geometry with five surfaces; every distribution at two; all kinds of noise at four. */
static void all_designs(list *l)
{
    static const surface everywhere[] = {GGX, BECKMANN, STUDENT_T, TWO_LOBES, SPECTRUM}, wrong = WRONG, ggx = GGX, demo = DEMO;
    static const surface distributions[] = {{"phong+lambert", NULL, REST, "n=60", 1},
                                            {"gtr+lambert", NULL, REST, "alpha=0.2 gamma=2.5", 1},
                                            {"vmf+lambert", NULL, REST, "kappa=60", 1},
                                            {"gaussian+lambert", NULL, REST, "sigma=0.15", 1},
                                            {"sgd+lambert", NULL, REST, "alpha=0.04 p=0.5", 1},
                                            {"abc+lambert", NULL, REST, "B=50 C=2", 1},
                                            {"kelemen-ward/v-cavity+lambert", NULL, REST, "m=0.2", 1},
                                            {"kelemen-phong/v-cavity+lambert", NULL, REST, "n=60", 1},
                                            {"beckmann-walter+lambert", NULL, REST, "alpha=0.2", 1},
                                            {"phong-walter+lambert", NULL, REST, "n=60", 1}};
    static const char *const by_kind[] = {"goniometer:10", "plane, 4", "plane, 7", "572 at 4"};
    l->n = 0;
    for (size_t k = 0; k < sizeof everywhere / sizeof *everywhere; k++)
        for (size_t g = 0; g < GEOMETRIES; g++) add_design(l, g, everywhere[k], MULTIPLICATIVE);
    add_design(l, geometry_of("goniometer:5"), demo, MULTIPLICATIVE);
    for (int kind = ADDITIVE; kind <= GAIN; kind++)
        for (size_t k = 0; k < sizeof by_kind / sizeof *by_kind; k++) add_design(l, geometry_of(by_kind[k]), ggx, (enum kind)kind);
    for (size_t k = 0; k < sizeof distributions / sizeof *distributions; k++) {
        add_design(l, geometry_of("572 at 4"), distributions[k], MULTIPLICATIVE);
        add_design(l, geometry_of("plane, 7"), distributions[k], MULTIPLICATIVE);
    }
    for (size_t g = 0; g < GEOMETRIES; g++) add_design(l, g, wrong, MULTIPLICATIVE);
}

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
    const geometry *g = d->at;
    ff_table t;
    ff_error err = {0};
    ff_status status = FF_OK;
    if (g->grid) {
        ff_simulate_options o;
        ff_simulate_options_init(&o);
        o.seed = seed;
        status = ff_sampling_parse(g->grid, &o.sampling, &err);
        if (!status) status = ff_simulate_into(&s->model, s->n_channels, s->shape, s->channel, &o, &t, &err);
    } else {
        pairs *p = malloc(sizeof *p);
        if (!p) exit(1);
        directions(g->name, p);
        status = ff_table_init(p->n, s->n_channels, NULL, 0, 0, &t, &err);
        for (size_t i = 0; i < p->n && !status; i++)
            for (int k = 0; k < 4; k++) t.angle[k][i] = p->angle[i][k] * FIT_DEGREE;
        free(p);
        if (!status) {
            t.radians_per_unit = 1;
            t.isotropic = g->shape == FF_SHAPE_ISOTROPIC;
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

/* One value. along: of its channel, so far along the scan; gain: of its incidence. */
static double disturbed(const design *d, double y, double theta, double cosine, double along, double gain, uint64_t *state)
{
    const geometry *g = d->at;
    switch (d->noise) {
    case MULTIPLICATIVE:
        return y * (1 + g->relative * fit_normal(state));
    case ADDITIVE:
        return y + g->floor * fit_normal(state);
    case MIXED:
        return y * (1 + 0.6 * g->relative * fit_normal(state)) + 0.5 * g->floor * fit_normal(state);
    case BY_INCIDENCE:
        return y * (1 + (0.02 + 0.08 * theta / 75) * fit_normal(state));
    case BY_COSINE:
        return y + g->floor / fmax(0.17, cosine) * fit_normal(state);
    case STUDENT_5:
        return y * (1 + g->relative * student_5(state));
    case ALONG_SCAN:
        return y * (1 + g->relative * along);
    case GAIN:
        return y * (1 + 0.03 * gain) * (1 + g->relative * fit_normal(state));
    }
    return y;
}

static void disturb(const design *d, ff_table *t, uint64_t *state)
{
    double along[MANY_CHANNELS] = {0}, before = -1, gain = 0;
    for (size_t i = 0; i < t->n; i++) {
        double w[6], *const planes[6] = {w, w + 1, w + 2, w + 3, w + 4, w + 5};
        ff_table_directions(t, i, 1, planes);
        const double theta = acos(fmin(w[2], 1)) / FIT_DEGREE;
        const int starts = fabs(theta - before) > 1e-6;
        before = theta;
        if (starts && d->noise == GAIN) gain = fit_normal(state);
        for (size_t c = 0; c < t->n_channels; c++) {
            double *y = &t->value[c * t->n + i];
            if (d->noise == ALONG_SCAN) along[c] = starts ? fit_normal(state) : 0.7 * along[c] + sqrt(1 - 0.49) * fit_normal(state);
            *y = disturbed(d, *y, theta, w[2], along[c], gain, state);
        }
    }
}

/* ---- one design ------------------------------------------------------------------------------ */

typedef struct trial {
    const design *d;
    method by;
    const fit_surface *s;  /* what is measured                        */
    const ff_model *model; /* what is fitted                          */
    const double *truth;   /* [MAX_PARAMETERS] of the model's parameters */
    double *value, *half;  /* [repeats][MAX_PARAMETERS]; half-width NaN: no interval */
    char *inside;
    double widest; /* Student's t over 1.96 */
} trial;

enum { REFITS = 50 };

static int is_by_weights(method by)
{
    return by == WEIGHTS || by == WEIGHTS_PROFILE || by == WEIGHTS_BOOTSTRAP;
}

/* The same fit in standard deviations of the noise that it has found. */
static ff_status fit_again(const trial *t, ff_problem *p, const ff_fit_options *o, ff_fit_result *fit)
{
    ff_fit_result first = *fit;
    if (!fit->noise) return FF_OK;
    *fit = (ff_fit_result){.n_channels = 0};
    ff_status status = ff_problem_weigh_by_noise(p, o, &first, NULL);
    if (!status) status = ff_problem_fit_into(p, t->model, o, fit, NULL);
    ff_fit_result_clear(&first);
    return status;
}

static ff_status replace_errors(const trial *t, const ff_table *table, const ff_problem *p, ff_fit_options *o, uint64_t seed,
                                ff_fit_result *fit)
{
    ff_places places = {.n = 0};
    ff_bootstrap made = {.size = sizeof made};
    ff_status status = ff_places_init(p, table, &places, NULL);
    if (t->by == WEIGHTS_BOOTSTRAP) o->errors = FF_ERRORS_INCIDENCES;
    if (!status && (t->by == WEIGHTS || t->by == WEIGHTS_PROFILE)) status = ff_trust_jackknife(p, &places, o, fit, NULL);
    if (!status && (t->by == BOOTSTRAP || t->by == WEIGHTS_BOOTSTRAP))
        status = ff_trust_bootstrap_into(p, &places, o, REFITS, seed, fit, &made, NULL);
    if (!status && (t->by == PROFILE || t->by == WEIGHTS_PROFILE)) status = ff_trust_profile(p, o, fit, NULL);
    ff_places_clear(&places);
    return status;
}

/* A fit of the model to a table, by the method. */
static ff_status fit_by(const trial *t, const ff_table *table, uint64_t seed, ff_fit_result *fit)
{
    ff_fit_options o;
    ff_problem *p = NULL;
    ff_fit_options_init(&o);
    o.threads = 1;
    o.shape = t->d->at->shape;
    if (t->by == RESIDUALS) o.errors = FF_ERRORS_RESIDUALS;
    ff_status status = ff_problem_make(table, t->model, 1, &o, &p, NULL);
    if (!status) status = ff_problem_fit_into(p, t->model, &o, fit, NULL);
    if (!status && is_by_weights(t->by)) status = fit_again(t, p, &o, fit);
    if (!status && fit->noise) status = replace_errors(t, table, p, &o, seed, fit);
    ff_problem_free(p);
    return status;
}

static void one_repeat(void *context, size_t repeat, int worker)
{
    const trial *t = context;
    (void)worker;
    ff_table table = clean(t->d, t->s, 1 + repeat);
    uint64_t state = ff_test_seeded((1 + repeat) * UINT64_C(0xd1342543de82ef95));
    disturb(t->d, &table, &state);
    ff_fit_result fit = {.n_channels = 0};
    const ff_status status = fit_by(t, &table, 1 + repeat, &fit);
    for (size_t k = 0; k < MAX_PARAMETERS; k++) t->half[repeat * MAX_PARAMETERS + k] = NAN;
    for (size_t k = 0; !status && k < fit_parameter_count(&fit) && k < MAX_PARAMETERS; k++) {
        char name[64];
        double ignored;
        const size_t at = repeat * MAX_PARAMETERS + k;
        const ff_fit_value *v = fit_parameter(&fit, k, NULL, &ignored, name);
        if (!v || v->interval == FF_INTERVAL_NONE) continue;
        t->value[at] = v->value;
        t->half[at] = 0.5 * (v->high - v->low);
        t->inside[at] = t->truth[k] >= v->low && t->truth[k] <= v->high;
    }
    ff_fit_result_clear(&fit);
    ff_table_clear(&table);
}

/* Student's t of the incidences of a table less one, over 1.96; and CR3 itself errs on the large side, by a quarter of so few. */
static double widening(const trial *t, const ff_table *table)
{
    ff_fit_options o;
    ff_problem *p = NULL;
    ff_places places;
    ff_fit_options_init(&o);
    if (ff_problem_make(table, t->model, 1, &o, &p, NULL) || ff_places_init(p, table, &places, NULL)) exit(1);
    const double few = places.n_directions < 20 ? 1.25 : 1,
                 widest = few * ff_student_quantile(0.95, (double)(places.n_directions - 1)) / FF_NORMAL_975;
    ff_places_clear(&places);
    ff_problem_free(p);
    return widest;
}

/* The parameters of the surface, or where another model is fitted what it would find without noise, with the weights of one noise.
 */
static void find_truth(trial *t, double *truth)
{
    ff_fit_result fit = {.n_channels = 0};
    trial exact = *t;
    exact.by = NOISE;
    ff_table table = clean(t->d, t->s, 1);
    const int wrong = t->d->s.fitted != NULL;
    const ff_status status = fit_by(wrong && is_by_weights(t->by) ? t : &exact, &table, 1, &fit);
    if (status) exit(1);
    for (size_t k = 0; k < fit_parameter_count(&fit) && k < MAX_PARAMETERS; k++) {
        char name[64];
        double own;
        const ff_fit_value *v = fit_parameter(&fit, k, t->s, &own, name);
        truth[k] = wrong ? (v ? v->value : NAN) : own;
    }
    t->widest = is_by_weights(t->by) ? widening(t, &table) : 1;
    ff_fit_result_clear(&fit);
    ff_table_clear(&table);
}

static int ascending(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* Two lobes with the weights of the loss: the wide one drowns in the noise of the few values that these look at, and its errors are
 * not linear. What falls short is shown by a short run, and said in the manual with its figures; the long run is red. */
static int falls_short(const design *d, method by, size_t repeats)
{
    return repeats < MANY && strstr(d->s.words, "lobe2") && !is_by_weights(by);
}

static double standard_deviation(const trial *t, size_t k, size_t repeats)
{
    double n = 0, mean = 0, square = 0;
    for (size_t at = k; at < repeats * MAX_PARAMETERS; at += MAX_PARAMETERS) {
        if (isnan(t->half[at])) continue;
        const double d = t->value[at] - mean;
        n++;
        mean += d / n;
        square += d * (t->value[at] - mean);
    }
    return sqrt(fmax(square / n, 1e-300));
}

/* Prints the cell of parameter k and checks it; adds to the sums of a line. */
static void judge(const trial *t, const char *line, const char *name, size_t k, size_t repeats, double *half, double *sum_of_line)
{
    double n = 0, in = 0;
    size_t widths = 0;
    for (size_t i = 0; i < repeats; i++) {
        const size_t at = i * MAX_PARAMETERS + k;
        if (isnan(t->half[at])) continue;
        n++;
        in += t->inside[at];
        half[widths++] = t->half[at];
    }
    if (n < 0.5 * (double)repeats) {
        if (n > 0) printf("  %s - (%.0f of %zu)", name, n, repeats);
        return;
    }
    qsort(half, widths, sizeof *half, ascending);
    const double share = in / n, wide = half[widths / 2] / (FF_NORMAL_975 * standard_deviation(t, k, repeats)),
                 scatter = sqrt(0.95 * 0.05 / n), more = fmax(5 * (scatter - sqrt(0.95 * 0.05 / 1000)), 0);
    const int known = t->d->noise <= MIXED;
    printf("  %s %.1f (%.2f)", name, 100 * share, wide);
    sum_of_line[0] += share;
    sum_of_line[1]++;
    if (t->by == RESIDUALS || t->d->s.fitted || falls_short(t->d, t->by, repeats)) return;
    if (t->d->noise == GAIN && !is_by_weights(t->by)) return; /* what a whole incidence has in common it does not see: shown */
    FF_CHECK(share >= (known ? 0.925 : 0.91) - more && share <= (known ? 0.975 : 0.98) + more, "%s: %s inside in %.1f %%", line,
             name, 100 * share);
    if (is_by_weights(t->by) && t->d->noise == ADDITIVE) return; /* one incidence has most to say: the errors are twice too large */
    if (known)
        FF_CHECK(wide > 0.7 - more && wide < (1.3 + more) * t->widest, "%s: the half-width of %s is %.2f of what it is", line, name,
                 wide);
}

static void try_design(const design *d, method by, const char *line, size_t repeats, ff_pool *pool, double *of_geometry)
{
    const surface *u = &d->s;
    char words[256];
    double truth[MAX_PARAMETERS] = {0}, of_line[2] = {0};
    const int stretched = d->at->shape != FF_SHAPE_ISOTROPIC && strncmp(u->round, "alpha=", 6) == 0;
    snprintf(words, sizeof words, "%s %s", stretched ? "alpha_x=0.25 alpha_y=0.15 r_xy=-0.3" : u->round, u->words);
    const fit_surface s = fit_surface_make(u->expression, u->channels, words);
    fit_surface fitted = s;
    if (u->fitted) fitted = fit_surface_make(u->fitted, u->channels, "");
    trial t = {.d = d,
               .by = by,
               .s = &s,
               .model = &fitted.model,
               .truth = truth,
               .value = calloc(repeats * MAX_PARAMETERS, sizeof(double)),
               .half = calloc(repeats * MAX_PARAMETERS, sizeof(double)),
               .inside = calloc(repeats * MAX_PARAMETERS, 1)};
    double *half = malloc(repeats * sizeof *half);
    if (!t.value || !t.half || !t.inside || !half) exit(1);
    find_truth(&t, truth);
    ff_pool_run(pool, repeats, one_repeat, &t);
    printf("%-66s", line);
    for (size_t k = 0; k < fitted.model.n_shape + fitted.model.n_channel && k < MAX_PARAMETERS; k++) {
        const ff_model_param *p =
            k < fitted.model.n_shape ? &fitted.model.shape[k] : &fitted.model.channel[k - fitted.model.n_shape];
        if (strstr(p->name, "alpha_y") && d->at->shape == FF_SHAPE_ISOTROPIC) continue;
        judge(&t, line, p->name, k, repeats, half, of_line);
    }
    printf("\n");
    fflush(stdout);
    if (d->noise <= MIXED && !u->fitted && !falls_short(d, by, repeats)) of_geometry[0] += of_line[0], of_geometry[1] += of_line[1];
    free(t.value);
    free(t.half);
    free(t.inside);
    free(half);
}

/* The mean of all cells of a design with independent noise. */
static void judge_geometry(const geometry *g, const double *sum, method by, int repeats)
{
    const double mean = sum[0] / sum[1], more = fmax(5 * (sqrt(0.95 * 0.05 / repeats) - sqrt(0.95 * 0.05 / 1000)), 0);
    if (!(sum[1] > 0)) return;
    printf("%-14s mean of %2.0f cells %.1f\n", g->name, sum[1], 100 * mean);
    if (by != RESIDUALS)
        FF_CHECK(mean >= 0.94 - more && mean <= 0.96 + more, "%s: inside in %.1f %% on average", g->name, 100 * mean);
}

/* A few of them. */
static int is_in_short_run(const list *l, size_t k, method by)
{
    return k % 4 == 0 && !falls_short(&l->d[k], by, 0);
}

static method method_of(const char *word)
{
    for (int k = NOISE; k < METHODS; k++)
        if (strcmp(word, method_name[k]) == 0) return (method)k;
    exit(2);
}

int main(int argc, char **argv)
{
    const int repeats = argc > 1 ? atoi(argv[1]) : 40;
    const method by = argc > 2 ? method_of(argv[2]) : NOISE;
    double of_geometry[GEOMETRIES][2] = {{0}};
    static list l;
    ff_pool *pool = ff_pool_new(2);
    if (repeats < 10 || repeats > MAX_REPEATS || !pool) return 2;
    all_designs(&l);
    printf("share of %d measurements whose 95 %% interval holds the truth, per cent; its half-width over 1.96 standard deviations; "
           "errors by %s\n",
           repeats, method_name[by]);
    for (size_t k = 0; k < l.n; k++) {
        const design *d = &l.d[k];
        char line[160];
        char channels[32] = "";
        if (d->s.channels > 1) snprintf(channels, sizeof channels, "x %zu", d->s.channels);
        snprintf(line, sizeof line, "%-14s %-26s%-5s %-12s%s%s", d->at->name, d->s.expression, channels, kind_name[d->noise],
                 d->s.fitted ? " as " : "", d->s.fitted ? d->s.fitted : "");
        if (argc > 3 ? !strstr(line, argv[3]) : !is_in_short_run(&l, k, by) && repeats < MANY) continue;
        try_design(d, by, line, (size_t)repeats, pool, of_geometry[d->at - geometries]);
    }
    for (size_t g = 0; g < GEOMETRIES; g++) judge_geometry(&geometries[g], of_geometry[g], by, repeats);
    ff_pool_free(pool);
    printf("%ld checks, %ld failures\n", ff_test_count.checks, ff_test_count.failures);
    return ff_test_count.failures ? 1 : 0;
}
