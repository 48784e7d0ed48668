/* Every loss and robust loss of the registry, whichever these are: the parts of a descriptor against each other for every
 * instruction set, what a problem and the retrieval of a distribution make of them, and the tables of docs/fitting-reference.md.
 * What each of them should be is worked out by hand in loss_test.c. */
#include "fit_samples.h"
#include "pass_of.h"
#include "fit/ndf/internal_ndf.h"
#include "loss_samples.h"

/* ---- what there is to read ------------------------------------------------------------------- */

/* Lower case letters, digits and hyphens between them. */
static int is_name(const char *name)
{
    if (!(name[0] >= 'a' && name[0] <= 'z')) return 0;
    for (const char *c = name; *c; c++)
        if (!((*c >= 'a' && *c <= 'z') || (*c >= '0' && *c <= '9') || (*c == '-' && c[1] && c[1] != '-'))) return 0;
    return 1;
}

static int is_line(const char *text)
{
    return text && text[0] && !strchr(text, '\n');
}

static void names(void)
{
    static const char *const losses[] = {"cosine", "log", "cube-root", "relative", "plain"};
    static const char *const robusts[] = {"none", "huber", "cauchy", "tukey"};
    const int numbers[] = {FF_LOSS_COSINE, FF_LOSS_LOG, FF_LOSS_CUBE_ROOT, FF_LOSS_RELATIVE, FF_LOSS_PLAIN},
              robust_numbers[] = {FF_ROBUST_NONE, FF_ROBUST_HUBER, FF_ROBUST_CAUCHY, FF_ROBUST_TUKEY};
    /* numbers and names that programs and files already use */
    for (int k = 0; k < 5; k++) FF_CHECK(numbers[k] == k && !strcmp(ff_loss_name(k), losses[k]), "%s is not %d", losses[k], k);
    for (int k = 0; k < 4; k++)
        FF_CHECK(robust_numbers[k] == k && !strcmp(ff_robust_name(k), robusts[k]), "%s is not %d", robusts[k], k);
    FF_CHECK(ff_loss_count() == FF_LOSS_COUNT && ff_robust_count() == FF_ROBUST_COUNT, "the counts differ");
    for (int k = 0; k < FF_LOSS_COUNT; k++) {
        const ff_loss_info *info = ff_loss_at(k);
        FF_CHECK(is_name(info->name) && strcmp(info->name, "auto") && ff_loss_find(info->name) == k, "'%s'", info->name);
        FF_CHECK(is_line(info->help) && is_line(info->compares) && info->source && !strchr(info->source, '\n'), "%s", info->name);
    }
    for (int k = 0; k < FF_ROBUST_COUNT; k++) {
        const ff_robust_info *info = ff_robust_at(k);
        FF_CHECK(is_name(info->name) && ff_robust_find(info->name) == k, "'%s'", info->name);
        FF_CHECK(is_line(info->help) && is_line(info->rho) && info->source && !strchr(info->source, '\n'), "%s", info->name);
    }
    FF_CHECK(!ff_loss_at(-1) && !ff_loss_at(FF_LOSS_COUNT) && !ff_loss_name(-1) && !ff_loss_name(FF_LOSS_COUNT), "no such loss");
    FF_CHECK(!ff_robust_at(-1) && !ff_robust_at(FF_ROBUST_COUNT) && !ff_robust_name(-1), "no such robust loss");
    FF_CHECK(ff_loss_find("Cosine") == -1 && ff_loss_find("") == -1 && ff_robust_find("Huber") == -1,
             "names are found as they are");
}

/* ---- the documentation ----------------------------------------------------------------------- */

/* Appends text to a page with what Markdown would read escaped. */
static void put(char *page, size_t size, const char *text)
{
    size_t n = strlen(page);
    for (; *text && n + 3 < size; text++) {
        if (*text == '|' || *text == '*') page[n++] = '\\';
        page[n++] = *text;
    }
    page[n] = '\0';
}

static void put_row(char *page, size_t size, const char *name, const char *note, size_t n, const char *const *cell)
{
    snprintf(page + strlen(page), size - strlen(page), "| `%s`%s |", name, note);
    for (size_t k = 0; k < n; k++) {
        put(page, size, " ");
        put(page, size, cell[k]);
        snprintf(page + strlen(page), size - strlen(page), cell[k][0] ? " |" : "|");
    }
    put(page, size, "\n");
}

/* Are the rows that follow the line `head` those wanted? Shows them where not. */
static void check_table(const char *page, const char *head, const char *rows)
{
    const char *at = strstr(page, head);
    FF_CHECK(at != NULL, "docs/fitting-reference.md has no table that begins with\n%s", head);
    if (!at) return;
    const char *end = at + strlen(head) + strlen(rows);
    FF_CHECK(!strncmp(at + strlen(head), rows, strlen(rows)) && *end != '|',
             "the table of docs/fitting-reference.md is not the registry's, which is\n%s%s", head, rows);
}

static void page(void)
{
    enum { SIZE = 1 << 17 };
    char *text = calloc(1, SIZE), rows[1 << 14] = "";
    FILE *f = fopen(FF_TEST_SOURCE_DIR "/../docs/fitting-reference.md", "r");
    if (!text || !f || fread(text, 1, SIZE - 1, f) == 0) {
        printf("docs/fitting-reference.md cannot be read\n");
        exit(1);
    }
    fclose(f);
    ff_fit_options o;
    ff_fit_options_init(&o);
    for (int k = 0; k < FF_LOSS_COUNT; k++) {
        const ff_loss_info *info = ff_loss_at(k);
        const char *const cells[] = {info->compares, info->source};
        put_row(rows, sizeof rows, info->name, (int)o.loss == k ? " (default)" : "", 2, cells);
    }
    static const char *const automatic[] = {"whichever of them looks best", "see \"Which loss: auto\""};
    put_row(rows, sizeof rows, "auto", "", 2, automatic);
    check_table(text, "| `--loss` | g(f) | from |\n|---|---|---|\n", rows);
    rows[0] = '\0';
    for (int k = 1; k < FF_ROBUST_COUNT; k++) {
        const ff_robust_info *info = ff_robust_at(k);
        char b[32];
        snprintf(b, sizeof b, "%g", info->tuning);
        const char *const cells[] = {info->rho, b, info->source};
        put_row(rows, sizeof rows, info->name, "", 3, cells);
    }
    check_table(text, "| `--robust` | rho(s), s = r^2 | b where it is estimated | from |\n|---|---|---|---|\n", rows);
    free(text);
}

/* ---- kernels --------------------------------------------------------------------------------- */

/* A block of samples: values over many decades, a few of them 0 or, data alone, negative. */
typedef struct samples {
    double w[FF_BLOCK], t[FF_BLOCK], x[FF_BLOCK], f[FF_BLOCK], y[FF_BLOCK], r[FF_BLOCK], j[FF_BLOCK];
} samples;

static void fill(ff_loss loss, uint64_t *state, samples *s)
{
    for (int i = 0; i < FF_BLOCK; i++) {
        s->w[i] = 0.1 + fit_uniform(state);
        s->x[i] = i % 5 == 3 ? 1e-3 * fit_uniform(state) + 1e-6 : fit_uniform(state);
        s->f[i] = i % 17 == 4 ? 0 : 1e-8 * pow(1e12, fit_uniform(state));
        s->y[i] = i % 3 == 0 ? s->f[i] : i % 19 == 5 ? 0 : i % 7 == 6 ? -fit_uniform(state) : 1e-8 * pow(1e12, fit_uniform(state));
        if (!ff_loss_has_value(loss, s->y[i], s->x[i])) s->y[i] = s->f[i] + 1;
        if (!ff_loss_has_value(loss, s->f[i], s->x[i])) s->f[i] = s->y[i];
    }
    ff_loss_targets(loss, FF_BLOCK, s->y, s->x, s->t);
}

/* dg/df by differences of the target, Richardson's twice. */
static double target_slope(ff_loss loss, double y, double x)
{
    double slope[3];
    for (int k = 0; k < 3; k++) {
        const double h = 4e-3 * fabs(y) / (1 << k), at[2] = {y + h, y - h}, xs[2] = {x, x};
        double g[2];
        ff_loss_targets(loss, 2, at, xs, g);
        slope[k] = (g[0] - g[1]) / (at[0] - at[1]);
    }
    const double a = (4 * slope[1] - slope[0]) / 3, b = (4 * slope[2] - slope[1]) / 3;
    return (16 * b - a) / 15;
}

/* The kernel of an instruction set is w (g(f) - g(y)) and its derivative, by target and slope and by differences of the target. */
static void check_kernel(ff_isa isa, ff_loss loss, uint64_t *state)
{
    const ff_loss_descriptor *d = ff_loss_of(isa, loss);
    const char *name = d->info.name, *of = ff_isa_name(isa);
    samples s;
    double g[FF_BLOCK], slope[FF_BLOCK];
    fill(loss, state, &s);
    for (int i = 0; i < FF_BLOCK && !d->reads_cosine; i++) s.x[i] = NAN; /* a fit has none to give */
    const ff_loss_planes planes = {s.w, s.t, s.x};
    d->residuals(&planes, s.f, s.r, s.j);
    ff_loss_targets(loss, FF_BLOCK, s.f, planes.x, g);
    ff_loss_slopes(loss, FF_BLOCK, s.f, planes.x, slope);
    for (int i = 0; i < FF_BLOCK; i++) {
        const double size = s.w[i] * (fabs(g[i]) + fabs(s.t[i]));
        FF_CHECK(fabs(s.r[i] - s.w[i] * (g[i] - s.t[i])) <= 1e-14 * size, "%s, %s: f = %g, x = %g: residual %.17g, expected %.17g",
                 name, of, s.f[i], s.x[i], s.r[i], s.w[i] * (g[i] - s.t[i]));
        FF_CHECK(fabs(s.j[i] - s.w[i] * slope[i]) <= 1e-14 * s.w[i] * fabs(slope[i]),
                 "%s, %s: f = %g, x = %g: derivative %.17g, expected %.17g", name, of, s.f[i], s.x[i], s.j[i], s.w[i] * slope[i]);
        const double by_differences = s.f[i] > 0 ? target_slope(loss, s.f[i], s.x[i]) : slope[i];
        FF_CHECK(fabs(slope[i] - by_differences) <= 1e-9 * fabs(slope[i]) + 1e-11 * fabs(g[i] / fmax(s.f[i], 1e-300)),
                 "%s: f = %g, x = %g: slope %.12g, by differences %.12g", name, s.f[i], s.x[i], slope[i], by_differences);
    }
}

static void kernels(void)
{
    int curved = 0;
    for (int loss = 0; loss < FF_LOSS_COUNT; loss++)
        for (int isa = FF_ISA_SCALAR; isa <= FF_ISA_AVX512; isa++) {
            const ff_loss_descriptor *d = ff_isa_available((ff_isa)isa) ? ff_loss_of((ff_isa)isa, (ff_loss)loss) : NULL;
            uint64_t state = ff_test_stream("kernel %s", ff_loss_name(loss));
            if (!d) continue;
            FF_CHECK(!strcmp(d->info.name, ff_loss_name(loss)), "%s is called %s with %s", ff_loss_name(loss), d->info.name,
                     ff_isa_name((ff_isa)isa));
            FF_CHECK((!d->residuals) == (!d->target) && (!d->residuals) == (!d->slope), "%s is curved in part", d->info.name);
            FF_CHECK(d->residuals || (!d->reads_cosine && !d->has_value), "%s is linear, and reads what it does not need",
                     d->info.name);
            FF_CHECK(!d->factor || !d->factor_of_datum, "%s has two factors", d->info.name);
            curved += d->residuals != NULL;
            for (int k = 0; k < 50 && d->residuals; k++) check_kernel((ff_isa)isa, (ff_loss)loss, &state);
        }
    FF_CHECK(curved > 0, "no curved loss");
}

/* As a measure of any fit: factor (g(f) - g(y)), in the units that it says. */
static void measures(void)
{
    for (int k = 0; k < FF_LOSS_COUNT; k++)
        for (int isa = FF_ISA_SCALAR; isa <= FF_ISA_AVX512; isa++) {
            const ff_loss loss = (ff_loss)k;
            const ff_loss_descriptor *d = ff_isa_available((ff_isa)isa) ? ff_loss_of((ff_isa)isa, loss) : NULL;
            uint64_t state = ff_test_stream("measure %s", ff_loss_name(k));
            samples s;
            if (!d) continue;
            FF_CHECK((!d->deviations) == (!d->info.rmse_unit), "%s: a measure without unit, or a unit without measure",
                     d->info.name);
            if (!d->deviations || !d->info.rmse_unit) continue;
            FF_CHECK(!d->factor_of_datum, "%s: a measure of its own for every datum", d->info.name);
            fill(loss, &state, &s);
            d->deviations(s.f, s.y, s.x, s.r);
            for (int i = 0; i < FF_BLOCK; i++) {
                const double g = loss_g(loss, s.f[i], s.x[i]), t = loss_g(loss, s.y[i], s.x[i]),
                             by = loss_factor(loss, s.y[i], s.x[i], 0.001);
                const double size = by * (fabs(g) + fabs(t)) + !strcmp(d->info.rmse_unit, "1"); /* ln of a quotient near 1 */
                FF_CHECK(fabs(s.r[i] - by * (g - t)) <= 1e-14 * size, "%s, %s: f = %g, y = %g, x = %g: %.17g, expected %.17g",
                         d->info.name, ff_isa_name((ff_isa)isa), s.f[i], s.y[i], s.x[i], s.r[i], by * (g - t));
            }
        }
}

/* rho and its slope of every instruction set; no more than the square, and less the farther out. */
static void check_robust(ff_isa isa, ff_robust robust, double b)
{
    const ff_robust_descriptor *d = ff_robust_of(isa, robust);
    const char *name = d->info.name;
    double r[FF_BLOCK], rho[FF_BLOCK], slope[FF_BLOCK];
    for (int i = 0; i < FF_BLOCK; i++) r[i] = (i % 2 ? -1 : 1) * b * (i < 2 ? 0 : 1e-3 * pow(1e5, (i - 2) / (FF_BLOCK - 3.)));
    d->block(b, r, rho, slope);
    for (int i = 0; i < FF_BLOCK; i++) {
        const double s = r[i] * r[i], h = 1e-4 * s, expected = ff_robust_rho(robust, b, r[i]);
        FF_CHECK(fabs(rho[i] - expected) <= 1e-14 * b * b + 1e-14 * expected && rho[i] <= s * (1 + 1e-14),
                 "%s, %s: rho(%g) = %.17g, %.17g", name, ff_isa_name(isa), s, rho[i], expected);
        FF_CHECK(fabs(expected - loss_rho(robust, s, b)) <= 1e-13 * b * b + 1e-14 * expected, "%s: rho(%g)", name, s);
        FF_CHECK(slope[i] >= 0 && slope[i] <= 1 + 1e-14 && (i < 2 || slope[i] <= slope[i - 2] + 1e-14), "%s: slope %g at %g", name,
                 slope[i], r[i]);
        if (i < 2) FF_CHECK(rho[i] == 0 && slope[i] == 1, "%s: at 0", name);
        if (i < 2 || fabs(s / (b * b) - 1) < 1e-3) continue; /* some are bent at the scale */
        const double difference = (ff_robust_rho(robust, b, sqrt(s + h)) - ff_robust_rho(robust, b, sqrt(s - h))) / (2 * h);
        FF_CHECK(fabs(slope[i] - difference) <= 1e-7 + 1e-15 * b * b / h, "%s, %s: slope at %g: %.12g, by differences %.12g", name,
                 ff_isa_name(isa), r[i], slope[i], difference);
    }
}

/* Information about the mean of normal residuals that is kept at the scale b, (E psi')^2 / E psi^2 with psi = r rho'(r^2), by the
 * trapezoidal rule; E psi' = E r psi. */
static double kept(ff_robust robust, double b)
{
    double square = 0, mean = 0;
    for (int block = -16; block < 16; block++) {
        double r[FF_BLOCK], rho[FF_BLOCK], slope[FF_BLOCK];
        for (int i = 0; i < FF_BLOCK; i++) r[i] = 10. * (block * FF_BLOCK + i) / (16 * FF_BLOCK);
        ff_robust_of(FF_ISA_SCALAR, robust)->block(b, r, rho, slope);
        for (int i = 0; i < FF_BLOCK; i++) {
            const double psi = r[i] * slope[i], weight = 10. / (16 * FF_BLOCK) * exp(-0.5 * r[i] * r[i]) / sqrt(360 * FIT_DEGREE);
            square += weight * psi * psi;
            mean += weight * r[i] * psi;
        }
    }
    return mean * mean / square;
}

static void robusts(void)
{
    for (int robust = 0; robust < FF_ROBUST_COUNT; robust++) {
        FF_CHECK((robust == FF_ROBUST_NONE) == !ff_robust_of(FF_ISA_SCALAR, (ff_robust)robust)->block, "%s",
                 ff_robust_name(robust));
        if (robust == FF_ROBUST_NONE) continue;
        const double left = kept((ff_robust)robust, ff_robust_at(robust)->tuning);
        FF_CHECK(fabs(left - 0.95) < 2e-4, "%s at %g keeps %.5f of the information, expected 0.95", ff_robust_name(robust),
                 ff_robust_at(robust)->tuning, left);
        for (int isa = FF_ISA_SCALAR; isa <= FF_ISA_AVX512; isa++)
            for (double b = 1e-3; b < 10 && ff_isa_available((ff_isa)isa); b *= 7) check_robust((ff_isa)isa, (ff_robust)robust, b);
    }
}

/* ---- problems -------------------------------------------------------------------------------- */

/* Data of two channels with standard deviations, a few of them dark; the second is a hundred times as bright. */
static ff_table measurement(size_t n)
{
    const fit_surface s = fit_surface_make("ggx+lambert", 2, "alpha=0.3 f0=0.5:0.4 kd=0.1:0.3");
    const fit_sampling how = {.n = n, .max_theta = 80, .noise = 0.1, .glossy = 0.3, .sigma = 1, .seed = 4};
    ff_table t = fit_measure(&s, &how);
    for (size_t i = 0; i < n; i++) {
        if (i % 11 == 3) t.value[i] *= 1e-4;
        t.value[n + i] *= 100;
        t.sigma[n + i] *= 100;
    }
    return t;
}

static ff_problem *problem_of(const ff_table *t, ff_isa isa, ff_loss loss, ff_weighting weighting)
{
    ff_model models[FF_NDF_MODELS];
    ff_fit_options o;
    ff_problem *p = NULL;
    ff_error err = {0};
    ff_fit_options_init(&o);
    o.loss = loss, o.isa = isa, o.weighting = weighting, o.threads = 1, o.shape = FF_SHAPE_ISOTROPIC;
    if (ff_ndf_models(ff_term_find(FF_MASKING, "v-cavity"), models, &err) ||
        ff_problem_make(t, models, FF_NDF_MODELS, &o, &p, &err)) {
        printf("no problem: %s\n", err.message);
        exit(1);
    }
    return p;
}

/* Number i of a plane of p. */
static double plane_at(const struct ff_problem *p, int plane, size_t i)
{
    return ff_problem_plane(p, i / FF_BLOCK, plane)[i % FF_BLOCK];
}

/* j of the kernel at f = y, and the weight and cosine it was made with. */
static double slope_at_datum(const struct ff_problem *p, size_t c, size_t i)
{
    const ff_loss_descriptor *d = ff_loss_of(p->isa, p->loss);
    const int curved = d->residuals != NULL;
    const double y = plane_at(p, p->value + (int)c, i), w = plane_at(p, p->weight + p->weight_stride * (int)c, i);
    samples s;
    if (!curved) return w;
    for (int k = 0; k < FF_BLOCK; k++) {
        s.w[k] = w, s.f[k] = y, s.t[k] = plane_at(p, p->target + (int)c, i);
        s.x[k] = d->reads_cosine ? plane_at(p, p->geometry[FF_G_COS_I], i) : NAN;
    }
    const ff_loss_planes planes = {s.w, s.t, s.x};
    d->residuals(&planes, s.f, s.r, s.j);
    FF_CHECK(fabs(s.r[0]) <= 1e-14 * w * fabs(s.t[0]) + 1e-300, "%s: residual %g of its own datum", d->info.name, s.r[0]);
    return s.j[0];
}

/* The surrogate of a curved loss is its tangent at the data; a linear loss is its own. */
static void surrogates(void)
{
    ff_table t = measurement(400);
    for (int k = 0; k < FF_LOSS_COUNT; k++) {
        struct ff_problem *p = problem_of(&t, FF_ISA_BEST, (ff_loss)k, FF_WEIGHT_SAMPLE), *l = p->subsample_linear;
        double mean = 0;
        int compared = 0;
        FF_CHECK((l == p->subsample) == !ff_loss_is_curved(p->loss), "%s", ff_loss_name(k));
        for (size_t i = 0; i < p->n; i++) mean += fabs(plane_at(p, p->value, i)) / (double)p->n;
        for (size_t c = 0; c < 2 && l != p->subsample; c++)
            for (size_t i = 0; i < l->n; i++) {
                const double y = plane_at(l, l->target + (int)c, i), w = plane_at(l, l->weight + l->weight_stride * (int)c, i),
                             expected = slope_at_datum(p, c, l->index[i]);
                FF_CHECK(y == plane_at(p, p->value + (int)c, l->index[i]), "%s: another datum", ff_loss_name(k));
                if (y < 0.01 * mean) continue; /* taken as brighter */
                FF_CHECK_CLOSE(w, expected, 1e-13, 0);
                compared++;
            }
        FF_CHECK(!ff_loss_is_curved(p->loss) || compared > 600, "%s: %d values compared", ff_loss_name(k), compared);
        ff_problem_free(p);
    }
    ff_table_clear(&t);
}

/* With sigma weights the residual of every loss counts in standard deviations of the datum: j = 1/sigma there. */
static void deviations(void)
{
    ff_table t = measurement(400);
    for (int k = 0; k < FF_LOSS_COUNT; k++) {
        struct ff_problem *p = problem_of(&t, FF_ISA_BEST, (ff_loss)k, FF_WEIGHT_SIGMA);
        for (size_t c = 0; c < 2; c++)
            for (size_t i = 0; i < p->n; i++) FF_CHECK_CLOSE(slope_at_datum(p, c, i) * t.sigma[c * t.n + p->index[i]], 1, 1e-13, 0);
        ff_problem_free(p);
    }
    ff_table_clear(&t);
}

/* The weights of every channel are its own where they depend on the data. */
static void weights(void)
{
    ff_table t = measurement(400);
    for (int k = 0; k < FF_LOSS_COUNT; k++) {
        struct ff_problem *p = problem_of(&t, FF_ISA_BEST, (ff_loss)k, FF_WEIGHT_SAMPLE);
        for (size_t c = 0; c < 2; c++) {
            double *values = malloc(p->n * sizeof *values);
            if (!values) exit(1);
            for (size_t i = 0; i < p->n; i++) values[i] = plane_at(p, p->value + (int)c, i);
            const double least = loss_least(values, p->n);
            free(values);
            for (size_t i = 0; i < p->n; i++) {
                const double x = cos(t.angle[0][p->index[i]] * t.radians_per_unit), y = plane_at(p, p->value + (int)c, i);
                FF_CHECK_CLOSE(plane_at(p, p->weight + p->weight_stride * (int)c, i), loss_factor((ff_loss)k, y, x, least), 1e-13,
                               0);
                FF_CHECK_CLOSE(plane_at(p, p->target + (int)c, i), loss_g((ff_loss)k, y, x), 1e-13, 0);
            }
        }
        ff_problem_free(p);
    }
    ff_table_clear(&t);
}

/* ---- the retrieval of a distribution --------------------------------------------------------- */

enum { TOP = 30 };

/* cost2, J^T r and J^T J by kd / pi of channel c at f = kd / pi, from a pass of a fit and from one of the retrieval. */
typedef struct sums {
    double cost2, score[2], square[2];
} sums;

static sums sums_of_pass(const struct ff_problem *p, const double kd[2])
{
    const fit_surface s = fit_surface_make("lambert", 2, "");
    ff_fit_options o;
    ff_layout l;
    ff_normal n = {0};
    ff_pass pass;
    double H[4], g[2];
    ff_fit_options_init(&o);
    o.loss = p->loss;
    if (ff_layout_init(&s.model, 2, FF_SHAPE_ISOTROPIC, 0, &l, NULL) || ff_layout_normal(&l, &n) ||
        pass_of(&l, p, &o, s.shape, kd, &pass) || ff_pass_run(&pass, 0, &n))
        exit(1);
    assemble(&l, &n, NULL, H, g);
    const sums out = {n.cost2, {g[0], g[1]}, {H[0], H[3]}};
    ff_pass_free(&pass);
    ff_normal_free(&n);
    return out;
}

static sums sums_of_ndf(const struct ff_problem *p, const double kd[2])
{
    const double channel[4] = {0, kd[0], 0, kd[1]}; /* a lobe of no strength */
    ff_curve curve;
    ff_curve_state state;
    ff_ndf_sums s;
    if (ff_curve_new(0.07, asinh(6 / 0.07) / TOP, TOP, 0, tan(80 * FIT_DEGREE), &curve) || ff_curve_state_new(&curve, &state) ||
        ff_ndf_sums_new(&curve, 2, &s))
        exit(1);
    for (int k = 0; k <= TOP; k++) state.c[k] = -0.2 * k;
    ff_curve_evaluate(&curve, &state);
    const ff_ndf_place at = {
        .p = p, .curve = &curve, .state = &state, .masking = ff_term_find(FF_MASKING, "v-cavity"), .scaled = 1, .channel = channel};
    if (ff_ndf_sum(&at, 0, &s)) exit(1);
    sums out = {.cost2 = s.cost2};
    for (size_t c = 0; c < 2; c++) {
        const size_t k = s.n_raw + 2 * c + 1;
        out.score[c] = s.gradient[k];
        out.square[c] = s.gram[k * s.n + k];
    }
    ff_ndf_sums_free(&s);
    ff_curve_state_free(&state);
    ff_curve_free(&curve);
    return out;
}

/* At the same model both minimise the same objective. */
static void retrieval(void)
{
    static const ff_weighting weightings[] = {FF_WEIGHT_SAMPLE, FF_WEIGHT_SIGMA};
    static const double kd[2] = {0.4, 30};
    ff_table t = measurement(700);
    for (int loss = 0; loss < FF_LOSS_COUNT; loss++)
        for (int isa = FF_ISA_SCALAR; isa <= FF_ISA_AVX512; isa++)
            for (int w = 0; w < 2 && ff_isa_available((ff_isa)isa); w++) {
                struct ff_problem *p = problem_of(&t, (ff_isa)isa, (ff_loss)loss, weightings[w]);
                const sums a = sums_of_pass(p, kd), b = sums_of_ndf(p, kd);
                FF_CHECK(fabs(a.cost2 - b.cost2) <= 1e-13 * a.cost2, "%s, %s: cost2 %.17g of a fit, %.17g of ndf",
                         ff_loss_name(loss), ff_isa_name((ff_isa)isa), a.cost2, b.cost2);
                for (int c = 0; c < 2; c++) {
                    FF_CHECK(fabs(a.score[c] - b.score[c]) <= 1e-12 * sqrt(a.square[c] * a.cost2),
                             "%s: J^T r %.17g of a fit, %.17g of ndf", ff_loss_name(loss), a.score[c], b.score[c]);
                    FF_CHECK_CLOSE(a.square[c], b.square[c], 1e-13, 0);
                }
                ff_problem_free(p);
            }
    ff_table_clear(&t);
}

FF_TEST_MAIN(FF_TEST(names), FF_TEST(page), FF_TEST(kernels), FF_TEST(measures), FF_TEST(robusts), FF_TEST(surrogates),
             FF_TEST(deviations), FF_TEST(weights), FF_TEST(retrieval))
