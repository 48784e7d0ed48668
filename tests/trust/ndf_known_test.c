/* ndf_known_test [REPEATS]: is a retrieved D known where it says so? Grids that people have (goniometers of 5 and 10 degrees, in
 * plane, few incidences, scattered pairs), glossy and rough surfaces whose D is a formula, 2 to 5 % noise. At every node of a
 * design the truth lies outside of D (1 +- 1.96 errors) in at most 5 % of REPEATS measurements (binomial: exceeded by chance in 1
 * of 10^4 at a node), in 5 % on average; D is never called known where it is off by a factor of 2.5; and in every design something
 * is known. The seeds are 1 .. REPEATS. */
#include "fit_samples.h"
#include "fit/ndf/ndf_struct.h"
#include "simulate/simulate_struct.h"

static const double pi = 3.14159265358979323846;

typedef enum part { ALL, IN_PLANE, AT_30_AND_60 } part;

typedef struct surface {
    const char *expression, *set;
    double alpha, gamma, wide, share; /* student-t (infinite: beckmann), and a share of ggx of roughness `wide` */
} surface;

static const surface glossy = {"ggx+lambert", "alpha=0.1 f0=0.04 kd=0.3", 0.1, 2, 0, 0};
static const surface narrow = {"beckmann+lambert", "alpha=0.1 f0=0.04 kd=0.3", 0.1, INFINITY, 0, 0};
static const surface rough = {"ggx+lambert", "alpha=0.5 f0=0.04 kd=0.3", 0.5, 2, 0, 0};
static const surface metal = {"beckmann+lambert", "alpha=0.3 f0=0.3 kd=0.1", 0.3, INFINITY, 0, 0};
static const surface tailed = {"student-t+lambert", "alpha=0.2 gamma=1.7 f0=0.6 kd=0.1", 0.2, 1.7, 0, 0};
static const surface haze = {"tabulated+lambert", "f0=0.05 kd=0.3", 0.08, 2, 0.4, 0.3};

typedef struct design {
    const char *name, *grid;
    part part;
    double noise;
    const surface *s;
} design;

static const design designs[] = {
    {"goniometer:5, glossy", "goniometer:5", ALL, 0.03, &glossy},
    {"goniometer:5, narrow", "goniometer:5", ALL, 0.05, &narrow},
    {"goniometer:5, metal", "goniometer:5", ALL, 0.02, &metal},
    {"goniometer:5, haze", "goniometer:5", ALL, 0.03, &haze},
    {"goniometer:10, glossy", "goniometer:10", ALL, 0.05, &glossy},
    {"goniometer:10, rough", "goniometer:10", ALL, 0.02, &rough},
    {"goniometer:10, metal", "goniometer:10", ALL, 0.03, &metal},
    {"goniometer:10, tailed", "goniometer:10", ALL, 0.03, &tailed},
    {"plane, glossy", "goniometer:2.5", IN_PLANE, 0.03, &glossy},
    {"plane, metal", "goniometer:2.5", IN_PLANE, 0.05, &metal},
    {"plane, tailed", "goniometer:2.5", IN_PLANE, 0.02, &tailed},
    {"two incidences, glossy", "goniometer:5", AT_30_AND_60, 0.02, &glossy},
    {"two incidences, haze", "goniometer:5", AT_30_AND_60, 0.05, &haze},
    {"scattered, rough", "scattered:1500:0.5", ALL, 0.05, &rough},
};
enum { DESIGNS = sizeof designs / sizeof *designs, BINS = 64 };

/* ---- surfaces -------------------------------------------------------------------------------- */

static double student_t(double alpha, double gamma, double theta)
{
    const double q2 = pow(tan(theta) / alpha, 2), p = isinf(gamma) ? exp(-q2) : pow(1 + q2 / (gamma - 1), -gamma);
    return p / (pi * alpha * alpha * pow(cos(theta), 4));
}

static double true_d(const surface *s, double theta)
{
    const double d = (1 - s->share) * student_t(s->alpha, s->gamma, theta);
    return s->share > 0 ? d + s->share * student_t(s->wide, 2, theta) : d;
}

static void set_table(const surface *s, ff_model *m)
{
    enum { N = 2000 };
    static ff_profile_table table;
    static double theta[N], d[N];
    for (int i = 0; i < N; i++) {
        theta[i] = atan(0.002 * sinh(i * 12.0 / N));
        d[i] = true_d(s, theta[i]);
    }
    if (ff_profile_make(FF_PROFILE_D, N, theta, d, &table, NULL, NULL)) exit(1);
    ff_model_set_table(m, &table);
}

/* ---- measurements ---------------------------------------------------------------------------- */

static int is_measured(part part, const double w[6])
{
    const double theta = acos(fmin(w[2], 1)) / FIT_DEGREE;
    if (part == IN_PLANE) return fabs(w[0] * w[4] - w[1] * w[3]) < 1e-9;
    return part == ALL || fabs(theta - 30) < 1e-6 || fabs(theta - 60) < 1e-6;
}

static ff_table measure(const design *d, uint64_t seed)
{
    fit_surface s = fit_surface_make(d->s->expression, 1, d->s->set);
    ff_simulate_options o;
    ff_table t;
    ff_simulate_options_init(&o);
    o.relative = d->noise;
    o.seed = seed;
    if (d->s->share > 0) set_table(d->s, &s.model);
    if (ff_sampling_parse(d->grid, &o.sampling, NULL) || ff_simulate_into(&s.model, 1, s.shape, s.channel, &o, &t, NULL)) exit(1);
    for (size_t i = 0; i < t.n; i++) {
        double w[6], *const plane[6] = {&w[0], &w[1], &w[2], &w[3], &w[4], &w[5]};
        ff_table_directions(&t, i, 1, plane);
        if (!is_measured(d->part, w)) t.valid[i] = 0;
    }
    return t;
}

static ff_status retrieve(const ff_table *t, ff_ndf_result *r, ff_error *err)
{
    ff_ndf_options o;
    ff_fit_options fit;
    ff_model models[FF_NDF_MODELS];
    ff_problem *p;
    ff_ndf_options_init(&o);
    ff_fit_options_init(&fit);
    fit.shape = FF_SHAPE_ISOTROPIC;
    o.fit = &fit;
    ff_status status = ff_ndf_models(o.masking, models, err);
    if (!status) status = ff_problem_make(t, models, FF_NDF_MODELS, &fit, &p, err);
    if (status) return status;
    status = ff_ndf_retrieve_into(p, &o, r, err);
    ff_problem_free(p);
    return status;
}

/* ---- the judgement --------------------------------------------------------------------------- */

/* The nodes of different measurements lie at different angles: counted by the root of theta, which is about as even. */
typedef struct tally {
    int n[BINS], known[BINS], outside[BINS]; /* measurements in which a node of the bin was known, or known and wrong */
    long nodes, all_known, all_outside;
    double worst, worst_theta;
} tally;

static void count(const design *d, const ff_ndf_result *r, tally *t)
{
    unsigned char known[BINS] = {0}, outside[BINS] = {0};
    for (size_t i = 0; i < r->n_rows; i += 4) {
        const ff_ndf_row *row = &r->row[i];
        const int bin = (int)(6 * sqrt(row->theta / FIT_DEGREE));
        if (row->theta > r->reach) break;
        t->nodes++;
        if (!row->known) continue;
        const double ratio = true_d(d->s, row->theta) / row->d, off = fabs(log(ratio));
        const int wrong = fabs(ratio - 1) > 1.96 * row->d_error;
        known[bin] = 1;
        outside[bin] |= (unsigned char)wrong;
        t->all_known++;
        t->all_outside += wrong;
        if (off > t->worst) {
            t->worst = off;
            t->worst_theta = row->theta / FIT_DEGREE;
        }
    }
    for (int b = 0; b < BINS; b++) {
        t->known[b] += known[b];
        t->outside[b] += outside[b];
    }
}

/* Above this many of n with a chance of 1 in 20 each there are by a chance below 1e-4. */
static int most_of(int n)
{
    const double p = 0.05;
    double term = pow(1 - p, n), sum = term;
    int k = 0;
    while (sum < 1 - 1e-4 && k < n) {
        term *= (double)(n - k) / (k + 1) * p / (1 - p);
        sum += term;
        k++;
    }
    return k;
}

static void try_design(const design *d, int repeats)
{
    tally t = {.nodes = 0};
    for (int i = 1; i <= repeats; i++) {
        ff_ndf_result r;
        ff_error err = {0};
        ff_table data = measure(d, (uint64_t)i);
        const ff_status status = retrieve(&data, &r, &err);
        ff_table_clear(&data);
        if (!FF_CHECK(status == FF_OK, "%s: %s", d->name, err.message)) continue;
        count(d, &r, &t);
        ff_ndf_result_clear(&r);
    }
    const double share = t.all_known ? (double)t.all_outside / (double)t.all_known : 1;
    printf(
        "  %-24s known at %3.0f %% of the nodes that are reached, outside %.1f %%, off by at most a factor %.2f (%.3g degrees)\n",
        d->name, 100. * (double)t.all_known / (double)t.nodes, 100 * share, exp(t.worst), t.worst_theta);
    FF_CHECK(share <= 0.05, "%s: outside of the interval at %.3g of the nodes", d->name, share);
    FF_CHECK(exp(t.worst) < 2.5, "%s: D is off by a factor of %.2f at %.3g degrees", d->name, exp(t.worst), t.worst_theta);
    FF_CHECK((double)t.all_known > 0.1 * (double)t.nodes, "%s: known at %ld of %ld nodes", d->name, t.all_known, t.nodes);
    for (int b = 0; b < BINS; b++)
        FF_CHECK(t.outside[b] <= most_of(repeats), "%s: outside at %.3g degrees in %d of %d measurements, known in %d", d->name,
                 pow((b + 0.5) / 6, 2), t.outside[b], repeats, t.known[b]);
}

int main(int argc, char **argv)
{
    const int repeats = argc > 1 ? atoi(argv[1]) : 12;
    if (repeats < 1) return 2;
    for (size_t k = 0; k < DESIGNS; k++) try_design(&designs[k], repeats);
    printf("%ld checks, %ld failures\n", ff_test_count.checks, ff_test_count.failures);
    return ff_test_count.failures ? 1 : 0;
}
