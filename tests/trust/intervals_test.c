/* intervals_test [REPEATS [DISTRIBUTION,...]]: 95 % intervals of simulated goniometer measurements. For every distribution (all
 * without a list) with its usual masking, Schlick's term and Lambert's: REPEATS measurements in scans over 40 incident directions,
 * with noise of 5 %. Noise that is independent: the intervals of a plain fit. Noise that goes together along each scan over 5
 * samples: those of the bootstrap over incident directions, and beside them those of the plain fit, whose errors know of
 * neighbours. The truth of every parameter must lie in its interval in 93 to 97 % of a thousand repeats; of fewer, the band is as
 * many standard deviations wide. */
#include "base/internal_pool.h"
#include "scan_samples.h"
#include "fit/trust/trust_struct.h"

enum { MAX_PARAMETERS = 12, REFITS = 200, MAX_REPEATS = 100000 };
#define REACH 5

typedef struct tally {
    int n, inside[MAX_PARAMETERS], boot_inside[MAX_PARAMETERS], at_bound[MAX_PARAMETERS];
    double z2[MAX_PARAMETERS];
} tally;

typedef struct trial {
    const fit_surface *s;
    int correlated;
    int *inside, *boot_inside; /* [repeats][MAX_PARAMETERS]: 1 inside, 0 outside, -1 no interval */
    double *z;
} trial;

static const scan_sampling sampling = {.n_theta = 40, .n_phi = 1, .n_exit = 60, .max_theta = 75, .noise = 0.05};

static int covers(const ff_fit_value *v, double truth)
{
    return v->interval == FF_INTERVAL_NONE ? -1 : truth >= v->low && truth <= v->high;
}

static void one_repeat(void *context, size_t repeat, int worker)
{
    const trial *t = context;
    scan_sampling how = sampling;
    (void)worker;
    how.seed = 1 + repeat;
    how.reach = t->correlated ? REACH : 0;
    ff_table table = scan_measure(t->s, &how);
    ff_fit_options o = fit_options();
    o.threads = 1;
    ff_problem *p = NULL;
    ff_places places = {0};
    ff_fit_result fit;
    ff_bootstrap b;
    ff_status status = ff_problem_make(&table, &t->s->model, 1, &o, &p, NULL);
    if (!status) status = ff_places_init(p, &table, &places, NULL);
    if (!status) status = ff_problem_fit_into(p, &t->s->model, &o, &fit, NULL);
    for (size_t k = 0; k < MAX_PARAMETERS; k++)
        t->inside[repeat * MAX_PARAMETERS + k] = t->boot_inside[repeat * MAX_PARAMETERS + k] = -1;
    for (int pass = 0; pass < (t->correlated ? 2 : 1) && !status; pass++) {
        if (pass) o.errors = FF_ERRORS_INCIDENCES;
        if (pass) status = ff_trust_bootstrap_into(p, &places, &o, REFITS, repeat, &fit, &b, NULL);
        for (size_t k = 0; k < fit_parameter_count(&fit) && k < MAX_PARAMETERS && !status; k++) {
            char name[64];
            double truth;
            const ff_fit_value *v = fit_parameter(&fit, k, t->s, &truth, name);
            if (!v) continue;
            (pass ? t->boot_inside : t->inside)[repeat * MAX_PARAMETERS + k] = covers(v, truth);
            if (!pass) t->z[repeat * MAX_PARAMETERS + k] = (v->value - truth) / v->std_error;
        }
    }
    if (!status) ff_fit_result_clear(&fit);
    ff_places_clear(&places);
    ff_problem_free(p);
    ff_table_clear(&table);
}

/* Share inside and its number; checks it against the band where `must`. */
static void judge(const char *what, const char *name, const int *inside, int repeats, int must)
{
    int n = 0, in = 0;
    for (int i = 0; i < repeats; i++) {
        n += inside[i * MAX_PARAMETERS] >= 0;
        in += inside[i * MAX_PARAMETERS] > 0;
    }
    const double share = n ? (double)in / n : 0, sd = sqrt(0.95 * 0.05 / (n ? n : 1)), half = 0.02 / sqrt(0.95 * 0.05 / 1000) * sd;
    printf("  %s %.1f", name, 100 * share);
    if (!must) return;
    FF_CHECK(n >= 0.99 * repeats, "%s: %s has an interval in %d of %d fits", what, name, n, repeats);
    FF_CHECK(share >= 0.95 - half - 1e-9 && share <= fmin(0.95 + half, 1) + 1e-9, "%s: %s inside in %.1f %%, expected %.1f to %.1f",
             what, name, 100 * share, 100 * (0.95 - half), 100 * fmin(0.95 + half, 1));
}

static void try_model(const char *expression, const char *words, int repeats, ff_pool *pool)
{
    const fit_surface s = fit_surface_make(expression, 1, words);
    const size_t size = (size_t)repeats * MAX_PARAMETERS;
    trial t = {.s = &s,
               .inside = malloc(size * sizeof(int)),
               .boot_inside = malloc(size * sizeof(int)),
               .z = calloc(size, sizeof(double))};
    if (!t.inside || !t.boot_inside || !t.z) exit(1);
    for (t.correlated = 0; t.correlated < 2; t.correlated++) {
        ff_pool_run(pool, (size_t)repeats, one_repeat, &t);
        for (int boot = 0; boot <= t.correlated; boot++) {
            char what[160];
            snprintf(what, sizeof what, "%-11s %-16s %-9s", ff_term_at(FF_NDF, (size_t)s.model.lobe[0].ndf)->name,
                     t.correlated ? "noise in scans," : "independent,", boot ? "bootstrap" : "plain");
            printf("%s", what);
            for (size_t k = 0; k < s.model.n_shape + s.model.n_channel && k < MAX_PARAMETERS; k++) {
                const ff_model_param *p = k < s.model.n_shape ? &s.model.shape[k] : &s.model.channel[k - s.model.n_shape];
                int any = 0;
                for (int i = 0; i < repeats; i++) any |= t.inside[i * MAX_PARAMETERS + (int)k] >= 0;
                if (any) judge(what, p->name, (boot ? t.boot_inside : t.inside) + k, repeats, boot == t.correlated);
            }
            printf("\n");
        }
    }
    free(t.inside);
    free(t.boot_inside);
    free(t.z);
}

static int is_asked_for(const char *list, const char *name)
{
    const size_t n = strlen(name);
    if (!list) return 1;
    for (const char *at = list; (at = strstr(at, name)); at += n)
        if ((at == list || at[-1] == ',') && (at[n] == ',' || at[n] == '\0')) return 1;
    return 0;
}

int main(int argc, char **argv)
{
    const int repeats = argc > 1 ? atoi(argv[1]) : 40;
    ff_pool *pool = ff_pool_new(2);
    if (repeats < 1 || repeats > MAX_REPEATS || !pool) return 2;
    printf("share of %d measurements whose 95 %% interval holds the truth, per cent\n", repeats);
    for (size_t k = 0; k < ff_term_count(FF_NDF); k++) {
        const char *name = ff_term_at(FF_NDF, k)->name;
        char expression[128], words[128] = "f0=0.5 kd=0.1";
        ff_model m;
        snprintf(expression, sizeof expression, "%s+lambert", name);
        if (!is_asked_for(argc > 2 ? argv[2] : NULL, name) || ff_model_parse(expression, &m, NULL)) continue;
        if (ff_model_param_find(&m, "alpha_x").kind == FF_PARAM_SHAPE || ff_model_param_find(&m, "alpha").kind == FF_PARAM_SHAPE)
            snprintf(words, sizeof words, "alpha=0.3 f0=0.5 kd=0.1");
        try_model(expression, words, repeats, pool);
    }
    ff_pool_free(pool);
    printf("%ld checks, %ld failures\n", ff_test_count.checks, ff_test_count.failures);
    return ff_test_count.failures ? 1 : 0;
}
