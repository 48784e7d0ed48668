/* comparisons_test [REPEATS [WORD]]: are models ruled out that are wrong, and only these? Maskings of one distribution on designs
 * that people have, and a distribution that contains another one. Only designs whose line has WORD. A table: share of REPEATS
 * simulated measurements in which the truth, a masking of another family (V-cavities for Smith's, or the other way) and the other
 * form of Smith's masking are told apart from the best. The truth may be at most 5 %, the wrong family at least 95 % where noise is
 * independent; the larger distribution is told apart in 3 to 8 % where it is no better, and in 90 % or more where its parameter is
 * not that of the smaller. Of fewer repeats than MANY the bounds are as many standard deviations wider. The seeds are 1 .. REPEATS.
 */
#include "fit_samples.h"
#include "fit/trust/trust_struct.h"

enum { MAX_SAMPLES = 1000, MODELS = 3, MOST_MODELS = 12, MANY = 200 };
static const char *const masking[MODELS] = {"v-cavity", "smith-height-correlated", "smith-separable"};

typedef enum kind { INDEPENDENT, ALONG_SCAN, GAIN } kind;
static const char *const kind_name[] = {"independent", "AR .8", "gain 3 %"};

typedef struct design {
    const char *name;
    double alpha;
    kind noise;
    int powerful; /* 1: the wrong family has to be seen */
} design;

static const design designs[] = {{"goniometer, 8", 0.3, INDEPENDENT, 1},
                                 {"goniometer, 8", 0.1, INDEPENDENT, 1},
                                 {"plane, 7", 0.3, INDEPENDENT, 1},
                                 {"plane, 7", 0.1, INDEPENDENT, 1},
                                 {"plane, 5", 0.3, INDEPENDENT, 1},
                                 {"plane, 5", 0.1, INDEPENDENT, 1},
                                 {"plane, 4", 0.3, INDEPENDENT, 1},
                                 {"goniometer, 8", 0.3, ALONG_SCAN, 0},
                                 {"goniometer, 8", 0.3, GAIN, 0},
                                 {"plane, 7", 0.3, ALONG_SCAN, 0},
                                 {"plane, 7", 0.3, GAIN, 0}};

/* ---- measurements ---------------------------------------------------------------------------- */

typedef struct pairs {
    size_t n;
    double angle[MAX_SAMPLES][4]; /* degrees */
} pairs;

static void add(pairs *p, double theta_i, double theta_o, double phi_o)
{
    const double angle[4] = {theta_i, 0, theta_o, phi_o};
    if (p->n < MAX_SAMPLES) memcpy(p->angle[p->n++], angle, sizeof angle);
}

static void directions(const char *name, pairs *p)
{
    static const int five[] = {10, 25, 40, 55, 70}, four[] = {15, 30, 45, 60};
    p->n = 0;
    for (int i = 0; i < 80 && strcmp(name, "goniometer, 8") == 0; i += 10)
        for (int o = 0; o <= 80; o += 10)
            for (int phi = 0; phi <= 180; phi += 20) add(p, i, o, phi);
    for (int scan = -78; scan <= 78; scan += 3) {
        for (int i = 10; i <= 70 && strcmp(name, "plane, 7") == 0; i += 10) add(p, i, abs(scan), scan >= 0 ? 180 : 0);
        for (int k = 0; k < 5 && strcmp(name, "plane, 5") == 0; k++) add(p, five[k], abs(scan), scan >= 0 ? 180 : 0);
        for (int k = 0; k < 4 && strcmp(name, "plane, 4") == 0; k++) add(p, four[k], abs(scan), scan >= 0 ? 180 : 0);
    }
}

/* By incidence, as a scan has them. */
static int by_incidence(const void *a, const void *b)
{
    const double *x = a, *y = b;
    return (x[0] > y[0]) - (x[0] < y[0]);
}

static ff_table measure(const design *d, const fit_surface *s, uint64_t seed)
{
    pairs *p = malloc(sizeof *p);
    ff_table t;
    uint64_t state = ff_test_stream(d->name) + seed * 7919;
    double e = 0, gain = 0;
    if (!p) exit(1);
    directions(d->name, p);
    qsort(p->angle, p->n, sizeof *p->angle, by_incidence);
    if (ff_table_init(p->n, 1, NULL, 0, 0, &t, NULL)) exit(1);
    for (size_t i = 0; i < p->n; i++)
        for (int k = 0; k < 4; k++) t.angle[k][i] = p->angle[i][k] * FIT_DEGREE;
    t.radians_per_unit = 1;
    t.isotropic = 1;
    fit_evaluate(s, &t);
    for (size_t i = 0; i < t.n; i++) {
        const int first = i == 0 || p->angle[i][0] > p->angle[i - 1][0];
        const double now = fit_normal(&state);
        e = d->noise == ALONG_SCAN && !first ? 0.8 * e + 0.6 * now : now;
        if (first) gain = d->noise == GAIN ? 0.03 * fit_normal(&state) : 0;
        t.value[i] *= (1 + 0.05 * e) * (1 + gain);
    }
    free(p);
    return t;
}

/* ---- one comparison --------------------------------------------------------------------------- */

/* Fits of n models to t against the best of them. 0: it could not be done. */
static int compare(const ff_table *t, const ff_model *model, size_t n, ff_versus *v)
{
    ff_fit_options o = fit_options();
    ff_error err = {0};
    ff_problem *p = NULL;
    ff_places places = {0};
    ff_fit_result fits[MOST_MODELS];
    size_t made = 0, best = 0;
    o.shape = FF_SHAPE_ISOTROPIC;
    ff_status status = ff_problem_make(t, model, n, &o, &p, &err);
    if (!status) status = ff_places_init(p, t, &places, &err);
    for (; made < n && !status; made += !status) {
        status = ff_problem_fit_into(p, &model[made], &o, &fits[made], &err);
        if (!status && fits[made].residual.objective < fits[best].residual.objective) best = made;
    }
    if (!status) status = ff_trust_compare_into(p, &places, &o, fits, n, best, 0, v, &err);
    FF_CHECK(status == FF_OK, "%s", err.message);
    while (made > 0) ff_fit_result_clear(&fits[--made]);
    ff_places_clear(&places);
    ff_problem_free(p);
    return status == FF_OK;
}

/* As many per cent of n as a share of `percent` may show by chance, three standard deviations; of MANY none. */
static double slack(double percent, int n)
{
    return n >= MANY ? 0 : 3 * sqrt(percent * (100 - percent) / n) + 100.0 / n;
}

/* ---- maskings --------------------------------------------------------------------------------- */

static void maskings(const design *d, int repeats)
{
    ff_model model[MODELS];
    for (size_t truth = 0; truth < MODELS; truth++) {
        char expression[80], words[80];
        double truth_out = 0, family_out = 0, sister_out = 0;
        for (size_t k = 0; k < MODELS; k++) {
            snprintf(expression, sizeof expression, "ggx/%s+lambert", masking[k]);
            if (ff_model_parse(expression, &model[k], NULL)) exit(1);
        }
        snprintf(expression, sizeof expression, "ggx/%s+lambert", masking[truth]);
        snprintf(words, sizeof words, "alpha=%g f0=0.5 kd=0.1", d->alpha);
        const fit_surface s = fit_surface_make(expression, 1, words);
        for (int seed = 1; seed <= repeats; seed++) {
            ff_table t = measure(d, &s, (uint64_t)seed);
            ff_versus v[MODELS];
            int all = 1;
            if (compare(&t, model, MODELS, v)) {
                truth_out += v[truth].told_apart * 100.0 / repeats;
                for (size_t k = 0; k < MODELS; k++)
                    if ((k == 0) != (truth == 0)) all &= v[k].told_apart;
                family_out += all * 100.0 / repeats;
                if (truth) sister_out += v[3 - truth].told_apart * 100.0 / repeats;
            }
            ff_table_clear(&t);
        }
        printf("| %-13s | %.1f | %-11s | %-23s | %5.1f | %5.1f | %5.1f |\n", d->name, d->alpha, kind_name[d->noise], masking[truth],
               truth_out, family_out, truth ? sister_out : NAN);
        fflush(stdout);
        FF_CHECK(truth_out <= 5 + slack(5, repeats), "%s %g %s: %s is told apart from the best in %.1f %%", d->name, d->alpha,
                 kind_name[d->noise], masking[truth], truth_out);
        FF_CHECK(!d->powerful || family_out >= 95 - slack(95, repeats), "%s %g: of %s the wrong family is told apart in %.1f %%",
                 d->name, d->alpha, masking[truth], family_out);
    }
}

/* ---- a distribution in another ---------------------------------------------------------------- */

static void nested(const char *name, double gamma, int repeats)
{
    const design d = {name, 0.3, INDEPENDENT, 1};
    char words[80];
    ff_model model[2];
    double out = 0, larger_out = 0;
    if (ff_model_parse("ggx+lambert", &model[0], NULL) || ff_model_parse("student-t+lambert", &model[1], NULL)) exit(1);
    snprintf(words, sizeof words, "alpha=0.3 gamma=%g f0=0.5 kd=0.1", gamma);
    const fit_surface s = fit_surface_make("student-t+lambert", 1, words);
    for (int seed = 1; seed <= repeats; seed++) {
        ff_table t = measure(&d, &s, (uint64_t)(1000 + seed));
        ff_versus v[2];
        if (compare(&t, model, 2, v)) {
            out += v[0].told_apart * 100.0 / repeats;
            larger_out += v[1].told_apart * 100.0 / repeats;
        }
        ff_table_clear(&t);
    }
    printf("| %-13s | student-t, gamma %.1f | ggx told apart in %.1f %%, student-t in %.1f %% |\n", name, gamma, out, larger_out);
    fflush(stdout);
    FF_CHECK(larger_out == 0, "%s, gamma %g: the larger model is told apart in %.1f %%", name, gamma, larger_out);
    if (gamma == 2)
        FF_CHECK(out >= 3 - slack(3, repeats) && out <= 8 + slack(8, repeats), "%s: told apart without reason in %.1f %%", name,
                 out);
    else
        FF_CHECK(out >= 90 - slack(90, repeats), "%s: told apart in %.1f %%", name, out);
}

/* Lobes without masking leave many times as much as the truth, at every incidence: they are told apart in every measurement,
 * however many models lead, and though most of it is at grazing incidence. */
static void hopeless(const char *name, int repeats)
{
    static const char *const candidate[] = {"ggx",      "ggx/smith-separable", "student-t", "student-t/smith-separable",
                                            "gtr",      "gtr/smith-separable", "abc",       "ggx/smith-direction-correlated",
                                            "gtr/none", "student-t/none",      "abc/none",  "sgd/none"};
    enum { WRONG = 8, ALL = sizeof candidate / sizeof *candidate };
    const design d = {name, 0.3, INDEPENDENT, 1};
    const fit_surface s = fit_surface_make("ggx+lambert", 1, "alpha=0.3 f0=0.5 kd=0.1");
    ff_model model[ALL];
    int missed = 0;
    for (int m = 0; m < ALL; m++) {
        char expression[80];
        snprintf(expression, sizeof expression, "%s+lambert", candidate[m]);
        model[m] = fit_surface_make(expression, 1, "").model;
    }
    for (int r = 1; r <= repeats; r++) {
        ff_versus v[ALL] = {{0}};
        ff_table t = measure(&d, &s, (uint64_t)r);
        if (compare(&t, model, ALL, v))
            for (int m = WRONG; m < ALL; m++) missed += !v[m].told_apart;
        ff_table_clear(&t);
    }
    printf("| %-13s | no masking | not told apart: %d of %d |\n", name, missed, (ALL - WRONG) * repeats);
    FF_CHECK(missed == 0, "%s: lobes without masking are not told apart in %d of %d", name, missed, (ALL - WRONG) * repeats);
}

int main(int argc, char **argv)
{
    const int repeats = argc > 1 ? atoi(argv[1]) : 10;
    const char *word = argc > 2 ? argv[2] : "";
    if (repeats < 1) return 2;
    printf("%d measurements each, seeds 1 to %d\n\n| design | alpha | noise | truth | truth out, %% | wrong family out, %% | other "
           "Smith out, "
           "%% |\n|---|---|---|---|---:|---:|---:|\n",
           repeats, repeats);
    for (size_t i = 0; i < sizeof designs / sizeof *designs; i++)
        if (strstr(designs[i].name, word)) maskings(&designs[i], repeats);
    printf("\n| design | truth | |\n|---|---|---|\n");
    static const char *const names[] = {"goniometer, 8", "plane, 7"};
    static const double gammas[] = {2, 2.1, 1.9};
    for (int k = 0; k < 2; k++)
        for (int which = 0; which < 3; which++)
            if (strstr(names[k], word)) nested(names[k], gammas[which], repeats);
    for (int k = 0; k < 2; k++)
        if (strstr(names[k], word)) hopeless(names[k], repeats);
    printf("%ld checks, %ld failures\n", ff_test_count.checks, ff_test_count.failures);
    return ff_test_count.failures ? 1 : 0;
}
