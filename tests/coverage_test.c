/* Do the standard errors mean what they say? Of many noisy measurements of one surface, the true value of each parameter must lie
 * in the 95 % interval in 95 % of them, and the mean square of error over standard error must be 1: both within four standard
 * deviations of what so many repeats show, which of 25 parameters one passes in a seed of 500. $FACETFIT_REPEATS sets their number
 * (120; of the long tier 500). */
#include "fit_samples.h"

enum { MAX_PARAMETERS = 32 };

typedef struct coverage {
    int inside[MAX_PARAMETERS], count[MAX_PARAMETERS];
    double sum_z2[MAX_PARAMETERS];
    double sum_zz[MAX_PARAMETERS][MAX_PARAMETERS], sum_correlation[MAX_PARAMETERS][MAX_PARAMETERS]; /* by column */
} coverage;

static void add_fit(const fit_surface *s, const ff_fit_result *r, coverage *c)
{
    double column_z[MAX_PARAMETERS] = {0};
    for (size_t k = 0; k < fit_parameter_count(r); k++) {
        char name[64];
        double truth;
        const ff_fit_value *v = fit_parameter(r, k, s, &truth, name);
        if (!v) continue;
        const double z = (v->value - truth) / v->std_error;
        c->count[k]++;
        c->inside[k] += fabs(z) <= 1.959964;
        c->sum_z2[k] += z * z;
        if (v->column >= 0) column_z[v->column] = z;
    }
    for (size_t a = 0; a < r->n_columns; a++)
        for (size_t b = 0; b <= a; b++) {
            c->sum_zz[a][b] += column_z[a] * column_z[b];
            c->sum_correlation[a][b] += r->correlation[a * r->n_columns + b];
        }
}

static void report(const char *what, const ff_fit_result *r, const coverage *c, int n)
{
    const double around = 4 * sqrt(0.95 * 0.05 / n), around_square = 4 * sqrt(2.0 / n);
    char line[MAX_PARAMETERS * 32] = "";
    for (size_t k = 0; k < fit_parameter_count(r); k++) {
        char name[64];
        double truth;
        if (!fit_parameter(r, k, NULL, &truth, name)) continue;
        const double share = (double)c->inside[k] / n;
        snprintf(line + strlen(line), sizeof line - strlen(line), " %s %.1f %%", name, 100 * share);
        FF_CHECK(c->count[k] == n, "%s: %s has a standard error in %d of %d fits", what, name, c->count[k], n);
        FF_CHECK(fabs(share - 0.95) <= around, "%s: %s lies in its interval in %.1f %% of the fits, expected 95 +- %.1f", what,
                 name, 100 * share, 100 * around);
        FF_CHECK(fabs(c->sum_z2[k] / n - 1) <= around_square, "%s: %s: mean square of error / standard error %.3f", what, name,
                 c->sum_z2[k] / n);
    }
    printf("%s, %d repeats:\n   %s\n", what, n, line);
}

/* The errors of two parameters go together as their correlation says: within 4 standard deviations of a correlation of n pairs. */
static void check_correlations(const char *what, const ff_fit_result *r, const coverage *c, int n)
{
    double worst = 0;
    for (size_t a = 0; a < r->n_columns; a++)
        for (size_t b = 0; b < a; b++) {
            const double seen = c->sum_zz[a][b] / sqrt(c->sum_zz[a][a] * c->sum_zz[b][b]), said = c->sum_correlation[a][b] / n;
            worst = fmax(worst, fabs(seen - said));
            FF_CHECK(fabs(seen - said) <= 4 / sqrt(n), "%s: parameters %zu and %zu: correlation %.2f of the errors, %.2f reported",
                     what, a, b, seen, said);
        }
    printf("    correlations of the errors within %.2f of the reported ones\n", worst);
}

static void cover(const char *what, const fit_surface *s, fit_sampling how, const ff_fit_options *o)
{
    coverage c;
    ff_fit_result last = {0};
    const int n = fit_repeats(120, 500);
    const uint64_t seed = how.seed;
    memset(&c, 0, sizeof c);
    for (int i = 0; i < n; i++) {
        how.seed = 1000 * seed + (uint64_t)i;
        ff_table t = fit_measure(s, &how);
        ff_fit_result r;
        ff_error err = {0};
        const ff_status status = fit_table(&t, &s->model, o, &r, NULL, &err);
        FF_CHECK(status == FF_OK && r.outcome == FF_CONVERGED, "%s, repeat %d: %s", what, i,
                 status ? err.message : ff_outcome_name((int)r.outcome));
        ff_table_clear(&t);
        if (status) continue;
        add_fit(s, &r, &c);
        ff_fit_result_clear(&last);
        last = r;
    }
    if (last.shape_value) report(what, &last, &c, n);
    if (last.shape_value) check_correlations(what, &last, &c, n);
    ff_fit_result_clear(&last);
}

static const fit_sampling sampling = {.n = 4000, .max_theta = 75, .noise = 0.05, .seed = 1};

static void correlated(void)
{
    const fit_surface s = fit_surface_make("ggx+lambert", 3, "alpha_x=0.2 alpha_y=0.45 r_xy=0.4 f0=0.9:0.6:0.3 kd=0.1:0.05:0.02");
    const ff_fit_options o = fit_options();
    cover("correlated", &s, sampling, &o);
}

static void isotropic(void)
{
    const fit_surface s = fit_surface_make("ggx+lambert", 3, "alpha=0.3 f0=0.9:0.6:0.3 kd=0.1:0.05:0.02");
    ff_fit_options o = fit_options();
    o.shape = FF_SHAPE_ISOTROPIC;
    cover("isotropic", &s, sampling, &o);
}

static void sigma_columns(void)
{
    const fit_surface s = fit_surface_make("ggx+lambert", 3, "alpha_x=0.2 alpha_y=0.45 r_xy=0.4 f0=0.9:0.6:0.3 kd=0.1:0.05:0.02");
    fit_sampling how = sampling;
    how.sigma = 1;
    const ff_fit_options o = fit_options(); /* AUTO takes the sigmas */
    cover("correlated with sigma columns", &s, how, &o);
}

FF_TEST_MAIN(FF_TEST(correlated), FF_TEST(isotropic), FF_TEST(sigma_columns))
