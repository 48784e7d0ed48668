/* ordering_test [all]: which distribution follows the MERL materials best? Bagher, Soler and Holzschuch 2012 answer: the SGD before
 * GGX before Beckmann, for most of them. Their own fits are simulated here as measurements, without noise, and fitted by the
 * distributions of this program; all else of the models is the same, so that the distribution alone makes the difference.
 *
 *   simulated  (rho_d + rho_s D F G / (iz oz)) / pi with every parameter of their table per channel, their masking included,
 *              by the formula written out below
 *   fitted     ks D F G / (4 iz oz) + kd / pi, each channel by itself, G separable Smith of that D; F the SGD's or Schlick's
 *   where      on nodes of the MERL grid: every one of theta_h, every few of theta_d and phi_d; up to 80 degrees from the normal
 *
 * Before that, and where their table is not there, surfaces whose distribution is known.
 *
 * SGD data are what an SGD fits best, by construction: that it comes first says only that the fits work, and its residual how far
 * the published masking, itself a fit, is from Smith's. What is found out is how GGX compares with Beckmann, and how far both are
 * from the SGD. The measurements themselves are not in it: where the SGD misses them, this test cannot know. */
#include "published_sheet.h"

enum { CHANNELS = 3, SEED = 12 };
static const double pi = 3.14159265358979323846;

/* ---- what is fitted, and by which criterion ---------------------------------------------------- */

enum { SGD = 0, GGX, BECKMANN, STUDENT_T, ABC, GTR, DISTRIBUTIONS };
static const char *const distribution[DISTRIBUTIONS] = {"sgd", "ggx", "beckmann", "student-t", "abc", "gtr"};

enum { OWN = 0, SCHLICK, FRESNELS };
static const char *const fresnel[FRESNELS] = {"sgd", "schlick"};

/* What is minimised, and what it finds of GGX and Beckmann: that GGX is over Beckmann for most (1) or for few (-1) of the
 * materials; 0: near one half, not asked. It depends on what is weighed: the samples of a MERL grid are densest at the peak, whose
 * shoulders GGX follows; over solid angle, and relative to the value, the faint tail counts, where the SGD falls off like
 * Beckmann's exp(-tan^2) in the end and GGX does not. The source shows differences of images in Lab (figure 1), which is none of
 * these. */
typedef struct criterion {
    ff_loss loss;
    ff_weighting weighting;
    int ggx_leads;
} criterion;
static const criterion criteria[] = {
    {FF_LOSS_COSINE, FF_WEIGHT_SAMPLE, 1},         {FF_LOSS_LOG, FF_WEIGHT_SAMPLE, 1},
    {FF_LOSS_CUBE_ROOT, FF_WEIGHT_SAMPLE, 1},      {FF_LOSS_COSINE, FF_WEIGHT_SOLID_ANGLE, 1},
    {FF_LOSS_LOG, FF_WEIGHT_SOLID_ANGLE, 0},       {FF_LOSS_CUBE_ROOT, FF_WEIGHT_SOLID_ANGLE, -1},
    {FF_LOSS_RELATIVE, FF_WEIGHT_SOLID_ANGLE, -1},
};
enum { CRITERIA = sizeof criteria / sizeof *criteria };

/* How much is done: the ordinary run takes seconds, the long one everything. */
typedef struct tier {
    size_t materials, distributions, fresnels, criteria;
    size_t step_d, step_phi; /* of the nodes of theta_d and phi_d */
} tier;
static const tier ordinary = {12, 4, 1, 2, 15, 30}, whole = {SHEET_ROWS, DISTRIBUTIONS, FRESNELS, CRITERIA, 6, 6};
static tier extent;

/* ---- their formula ------------------------------------------------------------------------------ */

/* One channel of a row, by the names of the source. */
typedef struct sgd_set {
    double rho_d, rho_s, alpha, p, f0, f1, K, lambda, c, k, theta0;
} sgd_set;

static sgd_set sgd_of(const sheet *s, size_t row, size_t c)
{
    return (sgd_set){.rho_d = sheet_channel(s, row, "rhoD", c),
                     .rho_s = sheet_channel(s, row, "rhoS", c),
                     .alpha = sheet_channel(s, row, "alpha", c),
                     .p = sheet_channel(s, row, "p", c),
                     .f0 = sheet_channel(s, row, "f0", c),
                     .f1 = sheet_channel(s, row, "f1", c),
                     .K = sheet_channel(s, row, "kap", c),
                     .lambda = sheet_channel(s, row, "lambda", c),
                     .c = sheet_channel(s, row, "c", c),
                     .k = sheet_channel(s, row, "k", c),
                     .theta0 = sheet_channel(s, row, "theta0", c)};
}

static double sgd_masking(const sgd_set *s, double theta)
{
    const double g = 1 + s->lambda * (1 - exp(s->c * pow(fmax(0, theta - s->theta0), s->k)));
    return fmin(fmax(g, 0), 1);
}

/* a: theta_i, phi_i, theta_o, phi_o in radians. */
static double sgd_value(const sgd_set *s, const double a[4])
{
    const double i[3] = {sin(a[0]) * cos(a[1]), sin(a[0]) * sin(a[1]), cos(a[0])};
    const double o[3] = {sin(a[2]) * cos(a[3]), sin(a[2]) * sin(a[3]), cos(a[2])};
    const double sum[3] = {i[0] + o[0], i[1] + o[1], i[2] + o[2]};
    const double square = sum[0] * sum[0] + sum[1] * sum[1] + sum[2] * sum[2];
    const double hz = sum[2] / sqrt(square), cosine = sqrt(square) / 2; /* i.h = |i + o| / 2 */
    const double tan2 = (sum[0] * sum[0] + sum[1] * sum[1]) / (sum[2] * sum[2]), x = s->alpha + tan2 / s->alpha;
    const double D = s->K * exp(-x) / (pi * pow(x, s->p) * pow(hz, 4));
    const double F = s->f0 - s->f1 * cosine + (1 - s->f0) * pow(1 - cosine, 5);
    const double G = sgd_masking(s, a[0]) * sgd_masking(s, a[2]);
    return (s->rho_d + s->rho_s * D * F * G / (i[2] * o[2])) / pi;
}

/* ---- the measurement ---------------------------------------------------------------------------- */

/* Sample i of the table from cell `cell` of the MERL grid. */
static void set_node(ff_table *t, size_t i, size_t cell)
{
    double w[6], *const planes[6] = {&w[0], &w[1], &w[2], &w[3], &w[4], &w[5]};
    ff_grid_merl.directions(cell, 1, planes);
    ff_grid_merl.weights(cell, 1, &t->weight[i]);
    for (int side = 0; side < 2; side++) {
        const double *v = w + 3 * side;
        t->angle[2 * side][i] = atan2(hypot(v[0], v[1]), v[2]);
        t->angle[2 * side + 1][i] = atan2(v[1], v[0]);
    }
    t->valid[i] = w[2] > FF_COS_MIN && w[5] > FF_COS_MIN;
    t->n_invalid += !t->valid[i];
}

/* Nodes of the MERL grid as a table of one channel with the weights of their cells; without values. */
static ff_table grid_nodes(void)
{
    enum { THETA_H = 90, THETA_D = 90, PHI_D = 180 };
    const size_t first_d = extent.step_d / 2, first_phi = extent.step_phi / 2;
    const size_t n_d = (THETA_D - first_d + extent.step_d - 1) / extent.step_d,
                 n_phi = (PHI_D - first_phi + extent.step_phi - 1) / extent.step_phi;
    ff_table t;
    size_t i = 0;
    if (ff_table_init(THETA_H * n_d * n_phi, 1, NULL, 0, 1, &t, NULL)) {
        printf("out of memory for the test's samples\n");
        exit(1);
    }
    t.radians_per_unit = 1;
    t.isotropic = 1;
    for (size_t h = 0; h < THETA_H; h++)
        for (size_t d = first_d; d < THETA_D; d += extent.step_d)
            for (size_t phi = first_phi; phi < PHI_D; phi += extent.step_phi) set_node(&t, i++, phi + PHI_D * (d + THETA_D * h));
    return t;
}

static void measure(const sgd_set *s, ff_table *t)
{
    for (size_t i = 0; i < t->n; i++) {
        const double a[4] = {t->angle[0][i], t->angle[1][i], t->angle[2][i], t->angle[3][i]};
        t->value[i] = t->valid[i] ? sgd_value(s, a) : 0;
    }
}

/* g(y) of a loss, y in 1/sr, mean the mean of |y| (see ff_loss). */
static double loss_of(ff_loss loss, double y, double cosine, double mean)
{
    const double u = y * cosine;
    if (loss == FF_LOSS_COSINE) return u;
    if (loss == FF_LOSS_LOG) return log1p(u);
    if (loss == FF_LOSS_CUBE_ROOT) return cbrt(u);
    return y / fmax(fmax(y, 0.001 * mean), 1e-12); /* FF_LOSS_RELATIVE */
}

/* The objective of a model that is 0 everywhere, which residuals are divided by. */
static double objective_of_nothing(const ff_table *t, const criterion *by, double max_theta)
{
    double sum = 0, weights = 0, mean = 0, used = 0;
    for (int pass = 0; pass < 2; pass++)
        for (size_t i = 0; i < t->n; i++) {
            if (!t->valid[i] || t->angle[0][i] > max_theta || t->angle[2][i] > max_theta) continue;
            const double w = by->weighting == FF_WEIGHT_SAMPLE ? 1 : t->weight[i];
            if (pass == 0) {
                mean += fabs(t->value[i]), weights += w, used++;
            } else {
                const double g = loss_of(by->loss, t->value[i], cos(t->angle[0][i]), mean / used);
                sum += w * g * g;
            }
        }
    return sum * used / weights / 2;
}

/* ---- fits ---------------------------------------------------------------------------------------- */

/* Residuals of one material: mean over its channels of objective / objective of nothing. */
typedef struct verdict {
    double residual[FRESNELS][CRITERIA][DISTRIBUTIONS];
} verdict;

static long fits, not_converged;

static void compose(size_t f, ff_model model[DISTRIBUTIONS])
{
    for (size_t d = 0; d < extent.distributions; d++) {
        char expression[64];
        ff_error err = {0};
        snprintf(expression, sizeof expression, "%s/smith-separable/%s+lambert", distribution[d], fresnel[f]);
        if (ff_model_parse(expression, &model[d], &err) || ff_model_vary(&model[d], "ks", &err)) {
            printf("the test itself is wrong: %s: %s\n", expression, err.message);
            exit(1);
        }
    }
}

/* Every distribution to the channel that t holds, by one criterion: adds to the verdict. */
static void fit_all(const char *what, const ff_table *t, size_t f, size_t k, verdict *v)
{
    ff_model model[DISTRIBUTIONS];
    ff_problem *p = NULL;
    ff_error err = {0};
    ff_fit_options o = fit_options();
    o.loss = criteria[k].loss;
    o.weighting = criteria[k].weighting;
    o.shape = FF_SHAPE_ISOTROPIC;
    o.std_errors = 0;
    compose(f, model);
    ff_status status = ff_problem_make(t, model, extent.distributions, &o, &p, &err);
    const double nothing = objective_of_nothing(t, &criteria[k], o.max_theta);
    for (size_t d = 0; d < extent.distributions && !status; d++) {
        ff_fit_result r;
        status = ff_problem_fit_into(p, &model[d], &o, &r, &err);
        if (status) break;
        fits++;
        not_converged += r.outcome != FF_CONVERGED;
        v->residual[f][k][d] += r.residual.objective / nothing / CHANNELS;
        ff_fit_result_clear(&r);
    }
    FF_CHECK(status == FF_OK, "%s, loss %s: %s", what, ff_loss_name((int)o.loss), err.message);
    ff_problem_free(p);
}

static verdict judge(const sheet *s, size_t row, ff_table *t)
{
    verdict v = {{{{0}}}};
    for (size_t c = 0; c < CHANNELS; c++) {
        const sgd_set set = sgd_of(s, row, c);
        measure(&set, t);
        for (size_t f = 0; f < extent.fresnels; f++)
            for (size_t k = 0; k < extent.criteria; k++) fit_all(s->cell[row][0], t, f, k, &v);
    }
    return v;
}

/* ---- what the materials say together --------------------------------------------------------------- */

typedef struct counts {
    size_t n, sgd_first, sgd_over_ggx, ggx_over_beckmann, as_published;
} counts;

/* Distributions by rising residual. */
static void rank(const double residual[DISTRIBUTIONS], size_t order[DISTRIBUTIONS])
{
    for (size_t i = 0; i < extent.distributions; i++) {
        size_t at = i;
        for (; at > 0 && residual[order[at - 1]] > residual[i]; at--) order[at] = order[at - 1];
        order[at] = i;
    }
}

static counts count(const verdict *v, size_t n, size_t f, size_t k)
{
    counts c = {.n = n};
    for (size_t i = 0; i < n; i++) {
        const double *r = v[i].residual[f][k];
        size_t order[DISTRIBUTIONS];
        rank(r, order);
        c.sgd_first += order[0] == SGD;
        c.sgd_over_ggx += r[SGD] < r[GGX];
        c.ggx_over_beckmann += r[GGX] < r[BECKMANN];
        c.as_published += r[SGD] < r[GGX] && r[GGX] < r[BECKMANN];
    }
    return c;
}

/* By how many of the criteria GGX is over Beckmann for a material. */
static size_t votes_for_ggx(const verdict *v, size_t f)
{
    size_t votes = 0;
    for (size_t k = 0; k < extent.criteria; k++) votes += v->residual[f][k][GGX] < v->residual[f][k][BECKMANN];
    return votes;
}

static int by_value(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static double median(double *x, size_t n)
{
    qsort(x, n, sizeof *x, by_value);
    return n % 2 ? x[n / 2] : (x[n / 2 - 1] + x[n / 2]) / 2;
}

/* ---- the report ---------------------------------------------------------------------------------- */

static double percent(double residual)
{
    return 100 * sqrt(residual);
}

static double beckmann_over_ggx(const double residual[DISTRIBUTIONS])
{
    return sqrt(residual[BECKMANN] / residual[GGX]);
}

static void print_names(const char *before)
{
    printf("%s", before);
    for (size_t d = 0; d < extent.distributions; d++) printf(" %9s", distribution[d]);
    printf("  beck/ggx\n");
}

static void print_material(const char *name, const double residual[DISTRIBUTIONS])
{
    size_t order[DISTRIBUTIONS];
    rank(residual, order);
    printf("  %-26s", name);
    for (size_t d = 0; d < extent.distributions; d++) printf(" %9.3f", percent(residual[d]));
    printf("  %8.2f ", beckmann_over_ggx(residual));
    for (size_t i = 0; i < extent.distributions; i++) printf("%s%s", i ? " < " : " ", distribution[order[i]]);
    printf("\n");
}

static void print_materials(const sheet *s, const size_t *row, const verdict *v, size_t n, size_t f, size_t k)
{
    char head[64];
    printf("\nloss %s, weights by %s, Fresnel term %s: root mean square residual in %% of the data's, Beckmann's over GGX's,"
           " ordering\n",
           ff_loss_name((int)criteria[k].loss), ff_weighting_name((int)criteria[k].weighting), fresnel[f]);
    snprintf(head, sizeof head, "  %-26s", "material");
    print_names(head);
    for (size_t i = 0; i < n; i++) print_material(s->cell[row[i]][0], v[i].residual[f][k]);
}

static void print_summary(const verdict *v, size_t n, size_t f, size_t k, const counts *c)
{
    static double x[SHEET_ROWS];
    printf("  %-10s %-11s %-8s %9zu %9zu %9zu %9zu ", ff_loss_name((int)criteria[k].loss),
           ff_weighting_name((int)criteria[k].weighting), fresnel[f], c->sgd_first, c->sgd_over_ggx, c->ggx_over_beckmann,
           c->as_published);
    for (size_t d = 0; d < extent.distributions; d++) {
        for (size_t i = 0; i < n; i++) x[i] = percent(v[i].residual[f][k][d]);
        printf(" %9.3f", median(x, n));
    }
    for (size_t i = 0; i < n; i++) x[i] = beckmann_over_ggx(v[i].residual[f][k]);
    printf("  %8.2f\n", median(x, n));
}

static void print_votes(const verdict *v, size_t n, size_t f)
{
    size_t all = 0, none = 0;
    for (size_t i = 0; i < n; i++) {
        const size_t votes = votes_for_ggx(&v[i], f);
        all += votes == extent.criteria;
        none += votes == 0;
    }
    printf("Fresnel term %s: GGX is over Beckmann by all %zu criteria for %zu materials, by some for %zu, by none for %zu\n",
           fresnel[f], extent.criteria, all, n - all - none, none);
}

/* ---- the checks ---------------------------------------------------------------------------------- */

/* student-t and gtr contain ggx (gamma = 2): they cannot be worse, or a search has failed. gtr's alpha ends at 1, which none of
 * these materials needs. */
static void check_nesting(const char *what, const double residual[DISTRIBUTIONS])
{
    const double allowed = residual[GGX] * (1 + 1e-6) + 1e-14;
    for (size_t d = 0; d < extent.distributions; d++)
        if (d == STUDENT_T || d == GTR)
            FF_CHECK(residual[d] <= allowed, "%s: %s %.9g, ggx %.9g", what, distribution[d], residual[d], residual[GGX]);
}

/* With its own Fresnel term the SGD can follow the data; with Schlick's it cannot, and GGX may do better by chance. */
static void check_counts(const counts *c, size_t f, size_t k)
{
    const double n = (double)c->n, least = f == OWN ? 0.95 : 0.85;
    const char *loss = ff_loss_name((int)criteria[k].loss), *weights = ff_weighting_name((int)criteria[k].weighting);
    FF_CHECK((double)c->sgd_over_ggx >= least * n, "%s, %s, %s: the SGD is over GGX for %zu of %zu", loss, weights, fresnel[f],
             c->sgd_over_ggx, c->n);
    FF_CHECK(criteria[k].ggx_leads * ((double)c->ggx_over_beckmann - n / 2) > 0 || criteria[k].ggx_leads == 0,
             "%s, %s, %s: GGX is over Beckmann for %zu of %zu", loss, weights, fresnel[f], c->ggx_over_beckmann, c->n);
}

static void as_published(void)
{
    static sheet s;
    static verdict v[SHEET_ROWS];
    size_t row[SHEET_ROWS];
    /* not part of the project: without the table beside it there is nothing to compare with */
    if (!sheet_read("data/tables/bagher2012_sgd.csv", &s)) FF_SKIP("data/tables/bagher2012_sgd.csv is not there");
    const size_t all = sheet_shuffle(&s, SEED, row), n = extent.materials < all ? extent.materials : all;
    ff_table t = grid_nodes();
    for (size_t i = 0; i < n; i++) v[i] = judge(&s, row[i], &t);
    for (size_t f = 0; f < extent.fresnels; f++)
        for (size_t k = 0; k < extent.criteria; k++) {
            if (f == OWN) print_materials(&s, row, v, n, f, k);
            for (size_t i = 0; i < n; i++) check_nesting(s.cell[row[i]][0], v[i].residual[f][k]);
        }
    printf("\n%zu materials, %zu nodes of the MERL grid, %ld fits, %ld not converged\n"
           "materials that follow what was published, and medians over the materials of the numbers above\n",
           n, t.n - t.n_invalid, fits, not_converged);
    print_names("  loss       weights     Fresnel  sgd first   sgd<ggx  ggx<beck published ");
    for (size_t f = 0; f < extent.fresnels; f++)
        for (size_t k = 0; k < extent.criteria; k++) {
            const counts c = count(v, n, f, k);
            print_summary(v, n, f, k, &c);
            check_counts(&c, f, k);
        }
    for (size_t f = 0; f < extent.fresnels; f++) print_votes(v, n, f);
    FF_CHECK(not_converged <= fits / 1000, "%ld of %ld fits did not converge", not_converged, fits);
    ff_table_clear(&t);
}

/* Where it is known who is right: of surfaces that have one of the distributions that one comes first, by every criterion and by
 * far; student-t and gtr may come with ggx, which they contain, the SGD with beckmann, which it is for p = 0. */
static void known(void)
{
    static const struct {
        size_t d;
        const char *words;
    } surface[] = {{SGD, "alpha=0.02 p=0.5 f0=0.5 f1=0.3 kd=0.1"},
                   {GGX, "alpha=0.2 f0=0.5 f1=0.3 kd=0.1"},
                   {BECKMANN, "alpha=0.25 f0=0.4 f1=0.2 kd=0.05"}};
    ff_table t = grid_nodes();
    double *w = malloc(6 * t.n * sizeof *w), *planes[6];
    if (!w) exit(1);
    for (size_t k = 0; k < 6; k++) planes[k] = w + k * t.n;
    ff_table_directions(&t, 0, t.n, planes);
    const ff_dirs dirs = {planes[0], planes[1], planes[2], planes[3], planes[4], planes[5]};
    printf("surfaces of a known distribution\n");
    for (size_t i = 0; i < sizeof surface / sizeof *surface; i++) {
        char expression[64];
        const size_t d = surface[i].d;
        snprintf(expression, sizeof expression, "%s/smith-separable/sgd+lambert", distribution[d]);
        const fit_surface s = fit_surface_make(expression, 1, surface[i].words);
        FF_CHECK(ff_model_eval(&s.model, FF_ISA_BEST, 1, s.shape, s.channel, &dirs, t.n, t.value, NULL, t.n) == FF_OK, "%s",
                 expression);
        for (size_t k = 0; k < t.n; k++)
            if (!t.valid[k]) t.value[k] = 0;
        verdict v = {{{{0}}}};
        for (size_t k = 0; k < extent.criteria; k++) {
            const double *r = v.residual[OWN][k];
            fit_all(expression, &t, OWN, k, &v);
            print_material(expression, r);
            check_nesting(expression, r);
            for (size_t other = 0; other < extent.distributions; other++) {
                const int contains = (d == GGX && (other == STUDENT_T || other == GTR)) || (d == BECKMANN && other == SGD);
                FF_CHECK(other == d || contains || r[d] < 1e-6 * r[other], "%s, %s: its own distribution leaves %.3g, %s %.3g",
                         expression, ff_loss_name((int)criteria[k].loss), r[d], distribution[other], r[other]);
            }
        }
    }
    free(w);
    ff_table_clear(&t);
}

static const ff_test_case cases[] = {FF_TEST(known), FF_TEST(as_published)};

int main(int argc, char **argv)
{
    const int all = argc == 2 && strcmp(argv[1], "all") == 0;
    extent = all ? whole : ordinary;
    return ff_test_main(cases, sizeof cases / sizeof *cases, all ? 1 : argc, argv);
}
