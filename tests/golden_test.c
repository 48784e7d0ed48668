/* D, Lambda, G, F and f against values from other sources: the golden files (quadrature; one made by golden/make_golden.py, one
 * elsewhere), Smith's Lambda by quadrature of its definition, the area of the distributions, and the identities between them. The
 * golden files also through the program. */
#include "model_samples.h"

/* ---- the golden files ------------------------------------------------------------------------ */

#define MADE FF_TEST_SOURCE_DIR "/golden/specular.csv"

enum {
    NDF,
    MASKING,
    ALPHA_X,
    ALPHA_Y,
    R_XY,
    SLOPE_X,
    SLOPE_Y,
    GAMMA,
    F0,
    THETA_I,
    PHI_I,
    THETA_O,
    PHI_O,
    D,
    LAMBDA_I,
    LAMBDA_O,
    G,
    FRESNEL,
    F,
    COLUMNS
};
static const char *const header =
    "ndf,masking,alpha_x,alpha_y,r_xy,slope_x,slope_y,gamma,f0,theta_i,phi_i,theta_o,phi_o,d,lambda_i,lambda_o,g,fresnel,f";

#define GOLDEN 1e-7
/* A few published Lambdas of student-t below 1e-14 were cut short by the quadrature that made them: at 30 digits the kernels'
 * values are right and the file's are off by more than 1e-7 of theirs. Such a Lambda has no effect on G; it is held to this
 * absolute floor. */
#define LAMBDA_FLOOR 1e-20

enum { ROW = 1024, ROWS = 4096 };

typedef struct row {
    char line[ROW];
    char *cell[COLUMNS];
} row;

/* Cuts line in place; 0 when the number of cells is wrong. */
static int cut(char *line, char **cell, int n)
{
    int k = 0;
    line[strcspn(line, "\r\n")] = 0;
    for (char *c = line; c; k++) {
        if (k == n) return 0;
        cell[k] = c;
        c = strchr(c, ',');
        if (c) *c++ = 0;
    }
    return k == n;
}

static double number(const row *r, int column)
{
    return strtod(r->cell[column], NULL);
}

static size_t golden_read(const char *path, row *rows)
{
    char line[ROW];
    size_t n = 0;
    FILE *file = fopen(path, "r");
    if (!file) return 0;
    if (!fgets(line, sizeof line, file) || strncmp(line, header, strlen(header)) != 0) {
        FF_CHECK(0, "%s has other columns than this test knows: %s", path, line);
    } else {
        while (n < ROWS && fgets(rows[n].line, ROW, file)) {
            FF_CHECK(cut(rows[n].line, rows[n].cell, COLUMNS), "%s, row %zu", path, n + 2);
            n++;
        }
    }
    fclose(file);
    return n;
}

static void expression_of(const row *r, char *out, size_t size)
{
    snprintf(out, size, "%s/%s/schlick", r->cell[NDF], r->cell[MASKING]);
}

/* "alpha_x=...,alpha_y=..." with the given separator. */
static void assignments_of(const row *r, const char *separator, char *out, size_t size)
{
    static const char *const names[] = {"alpha_x", "alpha_y", "r_xy", "slope_x", "slope_y", "gamma", "f0"};
    out[0] = 0;
    for (int k = 0; k < 7; k++) {
        const size_t used = strlen(out);
        if (r->cell[ALPHA_X + k][0])
            snprintf(out + used, size - used, "%s%s=%s", used ? separator : "", names[k], r->cell[ALPHA_X + k]);
    }
}

/* Values d .. f of a row: out[k] is column D + k. */
static void check_row(const row *r, const double out[6], size_t line, const char *by)
{
    static const char *const names[] = {"d", "lambda_i", "lambda_o", "g", "fresnel", "f"};
    for (int k = 0; k < 6; k++) {
        const int is_lambda = D + k == LAMBDA_I || D + k == LAMBDA_O;
        if (is_lambda && !r->cell[D + k][0]) {
            FF_CHECK(out[k] == 0, "row %zu by %s: %s is %g, the masking has none", line, by, names[k], out[k]);
            continue;
        }
        const double expected = number(r, D + k), error = fabs(out[k] - expected);
        FF_CHECK(error <= fmax(GOLDEN * fabs(expected), is_lambda ? LAMBDA_FLOOR : 0), "row %zu by %s: %s is %.15g, expected %.15g",
                 line, by, names[k], out[k], expected);
    }
}

static row rows[ROWS];

static void check_by_the_library(const char *path)
{
    const size_t n = golden_read(path, rows);
    FF_CHECK(n >= 300, "%s has %zu rows", path, n);
    for (int isa = FF_ISA_BEST; isa <= FF_ISA_AVX512; isa++) {
        if (!ff_isa_available((ff_isa)isa)) continue;
        for (size_t i = 0; i < n; i++) {
            char expression[64], assignments[256];
            double w[6], out[6];
            expression_of(&rows[i], expression, sizeof expression);
            assignments_of(&rows[i], " ", assignments, sizeof assignments);
            const fit_surface s = fit_surface_make(expression, 1, assignments);
            model_direction(number(&rows[i], THETA_I) * FIT_DEGREE, number(&rows[i], PHI_I) * FIT_DEGREE, w);
            model_direction(number(&rows[i], THETA_O) * FIT_DEGREE, number(&rows[i], PHI_O) * FIT_DEGREE, w + 3);
            const ff_dirs dirs = {w, w + 1, w + 2, w + 3, w + 4, w + 5};
            const ff_terms terms = {out, out + 1, out + 2, out + 3, out + 4};
            FF_CHECK(ff_model_terms(&s.model, (ff_isa)isa, 1, s.shape, s.channel, 0, 0, &dirs, 1, &terms) == FF_OK, "row %zu",
                     i + 2);
            FF_CHECK(ff_model_eval(&s.model, (ff_isa)isa, 1, s.shape, s.channel, &dirs, 1, out + 5, NULL, 1) == FF_OK, "row %zu",
                     i + 2);
            check_row(&rows[i], out, i + 2, isa ? ff_isa_name((ff_isa)isa) : "best");
        }
    }
}

static void golden_by_the_library(void)
{
    char path[1024];
    if (!ff_test_shared("golden/specular.csv", path, sizeof path)) FF_SKIP("%s is not there", path);
    check_by_the_library(path);
}

static void made_by_the_library(void)
{
    check_by_the_library(MADE);
}

/* Writes the directions of rows first .. last-1 as a file of the program; its name into path. */
static void write_directions(size_t first, size_t last, char *path)
{
    const int descriptor = mkstemp(path);
    FILE *file = descriptor < 0 ? NULL : fdopen(descriptor, "w");
    FF_CHECK(file != NULL, "no temporary file %s", path);
    if (!file) return;
    fprintf(file, "theta_i,phi_i,theta_o,phi_o\n");
    for (size_t i = first; i < last; i++)
        fprintf(file, "%s,%s,%s,%s\n", rows[i].cell[THETA_I], rows[i].cell[PHI_I], rows[i].cell[THETA_O], rows[i].cell[PHI_O]);
    FF_CHECK(fclose(file) == 0, "%s", path);
}

/* Runs the program on rows first .. last-1, which share their model, and checks what it prints. */
static void check_program(size_t first, size_t last)
{
    static const char *const wanted[] = {"d", "lambda_i", "lambda_o", "g", "fresnel", "f"};
    char path[] = "/tmp/facetfit-golden-XXXXXX", expression[64], assignments[256], command[2048], line[ROW], *cell[64];
    int column[6] = {-1, -1, -1, -1, -1, -1}, n_columns = 1;
    expression_of(&rows[first], expression, sizeof expression);
    assignments_of(&rows[first], ",", assignments, sizeof assignments);
    write_directions(first, last, path);
    snprintf(command, sizeof command, "'%s' eval '%s' --set '%s' --terms < %s", FF_PROGRAM, expression, assignments, path);
    FILE *out = popen(command, "r");
    FF_CHECK(out && fgets(line, sizeof line, out), "%s: nothing came out", command);
    for (const char *c = line; *c; c++) n_columns += *c == ',';
    const int readable = out && n_columns <= 64 && cut(line, cell, n_columns);
    FF_CHECK(readable, "%s: header %s", command, line);
    for (int k = 0; readable && k < n_columns; k++)
        for (int q = 0; q < 6; q++)
            if (strcmp(cell[k], wanted[q]) == 0) column[q] = k;
    for (int q = 0; q < 6; q++) FF_CHECK(column[q] >= 0, "%s: no column %s", command, wanted[q]);
    for (size_t i = first; readable && i < last; i++) {
        double values[6];
        FF_CHECK(fgets(line, sizeof line, out) && cut(line, cell, n_columns), "%s: row %zu is missing", command, i - first + 1);
        for (int q = 0; q < 6; q++) values[q] = column[q] < 0 ? NAN : strtod(cell[column[q]], NULL);
        check_row(&rows[i], values, i + 2, "the program");
    }
    FF_CHECK(out && !fgets(line, sizeof line, out), "%s: more rows than went in", command);
    FF_CHECK(out && pclose(out) == 0, "%s: failed", command);
    unlink(path);
}

static void check_by_the_program(const char *path)
{
    FF_CHECK(access(FF_PROGRAM, X_OK) == 0, "%s has not been built", FF_PROGRAM);
    if (access(FF_PROGRAM, X_OK) != 0) return;
    const size_t n = golden_read(path, rows);
    for (size_t first = 0, last; first < n; first = last) {
        for (last = first + 1; last < n; last++) {
            int differs = 0;
            for (int k = NDF; k <= F0; k++) differs |= strcmp(rows[first].cell[k], rows[last].cell[k]) != 0;
            if (differs) break;
        }
        check_program(first, last);
    }
}

static void golden_by_the_program(void)
{
    char path[1024];
    if (!ff_test_shared("golden/specular.csv", path, sizeof path)) FF_SKIP("%s is not there", path);
    check_by_the_program(path);
}

static void made_by_the_program(void)
{
    check_by_the_program(MADE);
}

/* ---- Smith's Lambda by quadrature of its definition ------------------------------------------ */

enum { NODES = 16 };

/* Gauss-Legendre nodes and weights on [0, 1]. */
typedef struct rule {
    double x[NODES], w[NODES];
} rule;

static rule gauss(void)
{
    rule g;
    for (int i = 0; i < NODES; i++) {
        double t = cos(MODEL_PI * (i + 0.75) / (NODES + 0.5)), slope = 1;
        for (int step = 0; step < 20; step++) {
            double p = t, before = 1;
            for (int k = 2; k <= NODES; k++) {
                const double next = ((2 * k - 1) * t * p - (k - 1) * before) / k;
                before = p;
                p = next;
            }
            slope = NODES * (t * p - before) / (t * t - 1);
            t -= p / slope;
        }
        g.x[i] = (1 + t) / 2;
        g.w[i] = 1 / ((1 - t * t) * slope * slope);
    }
    return g;
}

/* A distribution with its own parameter fixed: what the kernels make of it. */
typedef struct profile {
    rule rule;
    double width; /* of p, which is 1 but for distributions that keep their width to themselves */
    const ff_ndf *ndf;
    ff_ndf_pass pass;
} profile;

typedef double (*integrand)(const void *context, double x);

/* Integral of f from 0 to infinity over panels that double: the first as long as `start`; ends when the panels no longer count,
 * or at `end`. */
static double integral(const rule *g, integrand f, const void *context, double start, double end)
{
    double sum = 0, length = start;
    int quiet = 0;
    for (double from = 0; from < end && quiet < 4; from += length, length = fmax(start, from)) {
        double panel = 0;
        const double h = fmin(length, end - from);
        for (int i = 0; i < NODES; i++) panel += g->w[i] * f(context, from + g->x[i] * h);
        sum += panel * h;
        quiet = panel * h <= 1e-17 * sum ? quiet + 1 : 0;
        if (sum == 0 && from > 1e3) break;
    }
    return sum;
}

static double p_at(const profile *q, double q2)
{
    double p, dlnp;
    q->ndf->profile(&q->pass, 1, &q2, &p, &dlnp, NULL);
    return p;
}

typedef struct at {
    const profile *q;
    double t, a;
} at;

static double across(const void *context, double s)
{
    const at *c = context;
    return p_at(c->q, c->t * c->t + s * s);
}

/* The density of one slope: the marginal of p. Its scale is about 1/t for Gaussian tails, t for algebraic ones, 1 near the centre.
 */
static double marginal(const profile *q, double t)
{
    const at c = {q, t, 0};
    return 2 * integral(&q->rule, across, &c, 0.25 * q->width, 1e60);
}

static double beyond(const void *context, double x)
{
    const at *c = context;
    return x * marginal(c->q, c->a + x);
}

/* Where an algebraic tail p ~ q^-m is cut off, and m (infinite where the tail falls faster): beyond it, P2 is a power of t. */
#define CUT 1e7
static double tail_power(const profile *q)
{
    const double near = p_at(q, CUT * CUT), far = p_at(q, 1e6 * CUT * CUT);
    return far > 1e-300 ? -log(far / near) / log(1e3) : HUGE_VAL;
}

/* Lambda(a) = 1/a integral_a^inf (t - a) P2(t) dt */
static double lambda_by_definition(const profile *q, double a)
{
    const at c = {q, 0, a};
    const double m = tail_power(q);
    double sum = integral(&q->rule, beyond, &c, q->width * fmin(0.25, 0.5 * q->width / a), CUT - a);
    if (isfinite(m)) sum += marginal(q, CUT) * CUT * (CUT / (m - 3) - a / (m - 2)); /* P2 = P2(CUT) (t / CUT)^(1 - m) */
    return sum / a;
}

/* Where p has fallen to a quarter of what it is at 0. */
static double width_of(const profile *q)
{
    double lo = 1e-6, hi = 1e3;
    const double quarter = 0.25 * p_at(q, 0);
    for (int i = 0; i < 60; i++) {
        const double mid = sqrt(lo * hi);
        *(p_at(q, mid * mid) > quarter ? &lo : &hi) = mid;
    }
    return lo;
}

static double lambda_of(const profile *q, double a)
{
    const double v = 1 / (a * a);
    double lambda, slope;
    q->ndf->lambda(&q->pass, 1, &v, &lambda, &slope, NULL);
    return lambda;
}

/* Sets the parameters of a distribution to their initial values, and parameter k >= 0 to `own`. */
static profile profile_make(size_t ndf, int k, double own)
{
    ff_model m;
    double shape[FF_MAX_SHAPE];
    profile q;
    ff_lobe_pass lobe;
    if (ff_model_compose((int)ndf, 0, 0, -1, &m, NULL)) exit(1);
    ff_model_set_table(&m, fit_profile());
    ff_model_defaults(&m, 1, shape, NULL);
    if (k >= 0) shape[k] = own;
    ff_model_lobe(&m, 0, shape, &lobe, NULL);
    memset(&q, 0, sizeof q);
    q.rule = gauss();
    q.ndf = ff_ndf_at((int)ndf);
    q.pass = lobe.ndf_pass;
    memcpy(q.pass.own, lobe.s.own, sizeof lobe.s.own);
    q.pass.v_lo = FF_V_MIN, q.pass.v_hi = 1e60;
    q.pass.table = malloc((q.ndf->table_size + 1) * sizeof *q.pass.table);
    if (!q.pass.table) exit(1);
    if (q.ndf->prepare) q.ndf->prepare(&q.pass);
    q.width = q.ndf->alpha_own == 0 ? 1 : width_of(&q);
    return q;
}

static void profile_free(profile *q)
{
    free(q->pass.table);
}

static void check_lambda(const profile *q, const char *what)
{
    static const double as[] = {0.01, 0.02, 0.05, 0.1, 0.2, 0.3, 0.5, 0.7, 1, 1.3, 1.6, 2, 2.5, 3, 4, 6, 10, 17, 26, 30};
    long checked = 0;
    double worst = 0;
    for (size_t i = 0; i < sizeof as / sizeof *as; i++) {
        const double expected = lambda_by_definition(q, as[i] * q->width), lambda = lambda_of(q, as[i] * q->width);
        FF_CHECK(lambda >= 0, "%s: Lambda(%g) is %g", what, as[i], lambda);
        if (expected < 1e-290) continue; /* of subnormal numbers there is nothing to compare */
        /* a table keeps 1e-9 of 1 + Lambda, closed forms keep their digits */
        const double floor = q->ndf->table_size > 1000 || q->ndf->needs_values ? 1 + expected : expected;
        const double error = fabs(lambda - expected) / floor;
        /* the panels of the definition do not know where the pieces of a table's profile meet */
        const double allowed = q->ndf->needs_values ? 1e-6 : 1e-9;
        FF_CHECK(error <= allowed, "%s: Lambda(%g) is %.15g, by its definition %.15g", what, as[i], lambda, expected);
        worst = fmax(worst, error);
        checked++;
    }
    FF_CHECK(checked >= 11, "%s: only %ld values of Lambda could be compared", what, checked);
    printf("  %-24s %ld values of Lambda, worst %.1e\n", what, checked, worst);
}

/* Every distribution that has a Lambda, at its initial values and across the box of each parameter beyond the stretch. */
static void lambda_is_its_definition(void)
{
    static const double gammas[] = {1.51, 1.6, 2, 3, 8, 40, 100}, ns[] = {0, 1, 20, 1000, 1e5, 2e6};
    for (size_t ndf = 0; ndf < ff_term_count(FF_NDF); ndf++) {
        const ff_term *t = ff_term_at(FF_NDF, ndf);
        char what[64];
        if (!(t->claims & FF_WEAK_FURNACE)) continue; /* it has none, or a fit in its place */
        profile initial = profile_make(ndf, -1, 0);
        check_lambda(&initial, t->name);
        profile_free(&initial);
        const uint32_t first = ff_ndf_at((int)ndf)->stretch ? 0 : FF_STRETCH_COUNT;
        for (uint32_t i = first; i < t->n_params; i++) {
            const ff_param *own = &t->params[i];
            const int is_gamma = strcmp(t->name, "student-t") == 0, is_n = strcmp(t->name, "phong") == 0;
            for (int k = 0; k < 7; k++) {
                const double x = ff_coordinate(own, own->lo) + (ff_coordinate(own, own->hi) - ff_coordinate(own, own->lo)) * k / 6;
                if (is_n && k == 6) break;
                const double v = is_gamma ? gammas[k] : is_n ? ns[k] : ff_coordinate_value(own, x);
                profile q = profile_make(ndf, (int)i, v);
                snprintf(what, sizeof what, "%s, %s = %g", t->name, own->name, v);
                if (ff_test_drawn(3, "%s", what)) check_lambda(&q, what);
                profile_free(&q);
            }
        }
    }
}

/* ---- the area of the distributions ----------------------------------------------------------- */

/* D(m) mz^4 in the slope s: D of ff_model_terms with wi = wo = m. */
static double slope_density(const fit_surface *s, const double slope[2])
{
    const double mz = 1 / sqrt(1 + slope[0] * slope[0] + slope[1] * slope[1]), m[3] = {-slope[0] * mz, -slope[1] * mz, mz};
    const ff_dirs w = {m, m + 1, m + 2, m, m + 1, m + 2};
    double d = NAN;
    const ff_terms terms = {.d = &d};
    FF_CHECK(ff_model_terms(&s->model, FF_ISA_BEST, 1, s->shape, s->channel, 0, 0, &w, 1, &terms) == FF_OK, "terms");
    return d * mz * mz * mz * mz;
}

typedef struct ring {
    const fit_surface *s;
    ff_stretch l;
    double root; /* sqrt(1 - r^2) */
} ring;

/* The density times the area element, summed around the ellipse of radius q. */
static double around(const void *context, double q)
{
    enum { ANGLES = 8 };
    const ring *c = context;
    double sum = 0;
    for (int k = 0; k < ANGLES; k++) {
        const double phi = 2 * MODEL_PI * (k + 0.3) / ANGLES, u = q * cos(phi), v = q * sin(phi);
        const double slope[2] = {c->l.x0 + c->l.ax * u, c->l.y0 + c->l.ay * (c->l.r * u + c->root * v)};
        sum += slope_density(c->s, slope) / ANGLES;
    }
    return sum * 2 * MODEL_PI * q * c->l.ax * c->l.ay * c->root;
}

/* integral D mz dm = 1: over slopes, dm = mz^3 ds. */
static void area_is_one(void)
{
    const rule g = gauss();
    for (size_t ndf = 0; ndf < ff_term_count(FF_NDF); ndf++)
        for (int k = 0; k < 12; k++) {
            fit_surface s = {.n_channels = 1};
            ring c = {.s = &s};
            const char *name = ff_term_at(FF_NDF, ndf)->name;
            if (!(ff_term_at(FF_NDF, ndf)->claims & FF_UNIT_AREA)) continue;
            if (!model_lobe(ndf, "none", "schlick", &s.model)) exit(1);
            uint64_t state = ff_test_stream("area %s %d", name, k);
            model_random_parameters(&s.model, 1, (model_freedom)(k % 3), 0.6, &state, s.shape, s.channel);
            if (k == 0) ff_model_defaults(&s.model, 1, s.shape, s.channel);
            ff_lobe_pass pass;
            ff_model_lobe(&s.model, 0, s.shape, &pass, NULL);
            c.l = pass.s;
            c.root = sqrt(1 - c.l.r * c.l.r);
            const double end = 1e6, last = around(&c, end) * end, before = around(&c, end / 10) * end / 10;
            double area = integral(&g, around, &c, ff_ndf_at((int)ndf)->alpha_own == 0 ? 0.25 : 1e-4, end);
            const double rest = last > 1e-300 ? last / (log(before / last) / log(10)) : 0; /* a power of q, nearly */
            const double allowed = ff_ndf_at((int)ndf)->needs_values ? 1e-6 : 1e-9; /* the panels do not know a table's pieces */
            area += rest;
            FF_CHECK(fabs(area - 1) <= allowed, "%s, setting %d: area %.12g", name, k, area);
        }
}

/* ---- identities ------------------------------------------------------------------------------ */

/* All factors and f of two models at the same random pairs. */
static void check_same(const char *a, const char *b, const char *set_a, const char *set_b, double tolerance)
{
    const fit_surface sa = fit_surface_make(a, 1, set_a), sb = fit_surface_make(b, 1, set_b);
    static model_pairs w;
    static double ta[6][MODEL_PAIRS], tb[6][MODEL_PAIRS];
    uint64_t state = ff_test_stream("same %s %s", a, set_a);
    w.n = 0;
    model_pairs_random(&sa.model, sa.shape, &state, 500, &w);
    const ff_dirs dirs = model_dirs(&w);
    const ff_terms out_a = {ta[0], ta[1], ta[2], ta[3], ta[4]}, out_b = {tb[0], tb[1], tb[2], tb[3], tb[4]};
    FF_CHECK(ff_model_terms(&sa.model, FF_ISA_BEST, 1, sa.shape, sa.channel, 0, 0, &dirs, w.n, &out_a) == FF_OK, "%s", a);
    FF_CHECK(ff_model_terms(&sb.model, FF_ISA_BEST, 1, sb.shape, sb.channel, 0, 0, &dirs, w.n, &out_b) == FF_OK, "%s", b);
    FF_CHECK(ff_model_eval(&sa.model, FF_ISA_BEST, 1, sa.shape, sa.channel, &dirs, w.n, ta[5], NULL, w.n) == FF_OK, "%s", a);
    FF_CHECK(ff_model_eval(&sb.model, FF_ISA_BEST, 1, sb.shape, sb.channel, &dirs, w.n, tb[5], NULL, w.n) == FF_OK, "%s", b);
    for (int t = 0; t < 6; t++)
        for (size_t i = 0; i < w.n; i++)
            FF_CHECK(fabs(ta[t][i] - tb[t][i]) <= tolerance * fabs(tb[t][i]), "%s %s and %s %s: factor %d is %.15g and %.15g", a,
                     set_a, b, set_b, t, ta[t][i], tb[t][i]);
}

static void identities(void)
{
    check_same("ggx", "student-t", "alpha_x=0.2 alpha_y=0.5 r_xy=0.4", "alpha_x=0.2 alpha_y=0.5 r_xy=0.4 gamma=2", 1e-12);
    check_same("ggx", "student-t", "alpha=0.3 slope_x=0.1 slope_y=-0.2", "alpha=0.3 slope_x=0.1 slope_y=-0.2 gamma=2", 1e-12);
    check_same("student-t", "ggx", "alpha=1.5 gamma=2", "alpha=1.5", 1e-12);
    static const double ns[] = {0, 0.5, 1, 2, 20, 196};
    for (size_t k = 0; k < sizeof ns / sizeof *ns; k++) {
        char phong[64], student[128];
        snprintf(phong, sizeof phong, "n=%g", ns[k]);
        snprintf(student, sizeof student, "alpha=%.17g gamma=%.17g", sqrt(2 / (ns[k] + 2)), ns[k] / 2 + 2);
        check_same("phong", "student-t", phong, student, 1e-12);
    }
}

/* D = (n + 2) / (2 pi) mz^n and the closed forms of the other distributions at a point, by the C library. */
static void closed_forms_of_d(void)
{
    const double slope[2] = {0.31, -0.17}, s2 = slope[0] * slope[0] + slope[1] * slope[1], mz = 1 / sqrt(1 + s2), a2 = 0.09;
    const fit_surface phong = fit_surface_make("phong", 1, "n=7.5"), ggx = fit_surface_make("ggx", 1, "alpha=0.3"),
                      beckmann = fit_surface_make("beckmann", 1, "alpha=0.3"),
                      t = fit_surface_make("student-t", 1, "alpha=0.3 gamma=3.7");
    FF_CHECK_CLOSE(slope_density(&phong, slope), 9.5 / (2 * MODEL_PI) * pow(mz, 11.5), 1e-13, 0);
    FF_CHECK_CLOSE(slope_density(&ggx, slope), 1 / (MODEL_PI * a2 * pow(1 + s2 / a2, 2)), 1e-13, 0);
    FF_CHECK_CLOSE(slope_density(&beckmann, slope), exp(-s2 / a2) / (MODEL_PI * a2), 1e-13, 0);
    FF_CHECK_CLOSE(slope_density(&t, slope), pow(1 + s2 / a2 / 2.7, -3.7) / (MODEL_PI * a2), 1e-13, 0);
}

FF_TEST_MAIN(FF_TEST(made_by_the_library), FF_TEST(made_by_the_program), FF_TEST(golden_by_the_library),
             FF_TEST(golden_by_the_program), FF_TEST(lambda_is_its_definition), FF_TEST(area_is_one), FF_TEST(identities),
             FF_TEST(closed_forms_of_d))
