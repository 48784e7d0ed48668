/* facetfit selftest: does what the library claims hold on this machine? Each check says what it looked at. */
#define _GNU_SOURCE /* mkdtemp */
#include "internal_cli.h"
#include "ff_albedo.h"
#include "simulate/simulate_struct.h"
#include <math.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { PAIRS = 96, MOST = 64 };

typedef struct selftest {
    int checks, failures, quiet;
} selftest;

static void say(selftest *t, int holds, const char *format, ...) __attribute__((format(printf, 3, 4)));
static void say(selftest *t, int holds, const char *format, ...)
{
    va_list args;
    t->checks++;
    t->failures += !holds;
    if (holds && t->quiet) return;
    fputs(holds ? "ok      " : "FAILED  ", stdout);
    va_start(args, format);
    vprintf(format, args);
    va_end(args);
    fputc('\n', stdout);
    fflush(stdout);
}

/* ---- models ---------------------------------------------------------------------------------- */

/* Pairs of directions above the horizon, as planes. */
static ff_dirs directions(double plane[6][PAIRS])
{
    for (uint64_t i = 0; i < PAIRS; i++)
        for (uint32_t side = 0; side < 2; side++) {
            const double z = 0.05 + 0.95 * ff_random_uniform(1, side, i), phi = 6.28 * ff_random_uniform(1, 2 + side, i),
                         r = sqrt(1 - z * z);
            plane[3 * side][i] = r * cos(phi);
            plane[3 * side + 1][i] = r * sin(phi);
            plane[3 * side + 2][i] = z;
        }
    return (ff_dirs){plane[0], plane[1], plane[2], plane[3], plane[4], plane[5]};
}

/* "NDF+lambert"; 0 where it takes a table. */
static int model_of(size_t ndf, ff_model *m)
{
    char expression[FF_MODEL_NAME];
    const ff_term *term = ff_term_at(FF_NDF, ndf);
    const char *masking = term->claims & FF_UNIT_AREA ? "smith-height-correlated" : "v-cavity";
    snprintf(expression, sizeof expression, "%s/%s+lambert", term->name, masking);
    return strcmp(term->name, "tabulated") && ff_model_parse(expression, m, NULL) == FF_OK;
}

/* The largest difference between derivatives and central differences, relative to the largest value. */
static double derivative_error(const ff_model *m, const ff_dirs *w)
{
    static double f[2][PAIRS], value[PAIRS], df[MOST][PAIRS];
    double shape[FF_MAX_SHAPE], channel[FF_MAX_CHANNEL_PARAMS], worst = 0, most = 0;
    ff_model_defaults(m, 1, shape, channel);
    if (ff_model_eval(m, FF_ISA_BEST, 1, shape, channel, w, PAIRS, value, df[0], PAIRS)) return INFINITY;
    for (size_t i = 0; i < PAIRS; i++) most = fmax(most, value[i]);
    for (uint32_t k = 0; k < m->n_shape; k++) {
        const double at = shape[k], step = 1e-6 * fmax(1, fabs(at));
        if (m->shape[k].flags & FF_PARAM_HELD) continue;
        for (int s = 0; s < 2; s++) {
            shape[k] = at + (s ? step : -step);
            if (ff_model_eval(m, FF_ISA_BEST, 1, shape, channel, w, PAIRS, f[s], NULL, PAIRS)) return INFINITY;
        }
        shape[k] = at;
        for (size_t i = 0; i < PAIRS; i++) worst = fmax(worst, fabs((f[1][i] - f[0][i]) / (2 * step) - df[k][i]) / most);
    }
    return worst;
}

static void check_derivatives(selftest *t)
{
    static double plane[6][PAIRS];
    const ff_dirs w = directions(plane);
    double worst = 0;
    size_t n = 0;
    ff_model m;
    for (size_t i = 0; i < ff_term_count(FF_NDF); i++)
        if (model_of(i, &m)) worst = fmax(worst, derivative_error(&m, &w)), n++;
    say(t, n > 8 && worst < 1e-5, "models: derivatives of %zu distributions are differences, to %.0e", n, worst);
}

/* Instruction sets differ by rounding alone. */
static void check_sets(selftest *t)
{
    static double plane[6][PAIRS], f[PAIRS], g[PAIRS];
    const ff_dirs w = directions(plane);
    double shape[FF_MAX_SHAPE], channel[FF_MAX_CHANNEL_PARAMS];
    ff_model m;
    for (int isa = FF_ISA_AVX2; isa <= FF_ISA_AVX512; isa++) {
        double worst = 0;
        if (!ff_isa_available((ff_isa)isa)) continue;
        for (size_t i = 0; i < ff_term_count(FF_NDF); i++) {
            if (!model_of(i, &m)) continue;
            ff_model_defaults(&m, 1, shape, channel);
            const int failed = ff_model_eval(&m, FF_ISA_SCALAR, 1, shape, channel, &w, PAIRS, f, NULL, PAIRS) ||
                               ff_model_eval(&m, (ff_isa)isa, 1, shape, channel, &w, PAIRS, g, NULL, PAIRS);
            for (size_t k = 0; k < PAIRS; k++) worst = fmax(worst, failed ? INFINITY : fabs(f[k] - g[k]) / fmax(fabs(f[k]), 1e-3));
        }
        say(t, worst < 1e-11, "instruction set %s: values of the scalar ones, to %.0e", ff_isa_name((ff_isa)isa), worst);
    }
}

/* Integrals whose values are known: Smith's weak white furnace, and 1 - ln 2 for ggx with alpha 1 along the normal. */
static void check_integrals(selftest *t)
{
    const double up[3] = {0, 0, 1}, view[3] = {0.8, 0, 0.6};
    double shape[FF_MAX_SHAPE], channel[FF_MAX_CHANNEL_PARAMS], worst = 0;
    size_t n = 0;
    ff_integral found = {NAN, NAN};
    ff_model m;
    for (size_t i = 0; i < ff_term_count(FF_NDF); i++) {
        if (!model_of(i, &m) || !ff_albedo_weak_furnace_claimed(&m, 0)) continue;
        ff_model_defaults(&m, 1, shape, channel);
        if (ff_albedo_weak_furnace(&m, FF_ISA_BEST, shape, 0, view, &found, NULL)) found.value = INFINITY;
        worst = fmax(worst, fabs(found.value - 1));
        n++;
    }
    say(t, n > 5 && worst < 1e-6, "integrals: the weak white furnace of %zu distributions is 1, to %.0e", n, worst);
    found.value = NAN;
    if (!ff_model_parse("ggx", &m, NULL)) {
        ff_model_defaults(&m, 1, shape, channel);
        const int failed = ff_model_set(&m, 1, "alpha=1", shape, channel, NULL) ||
                           ff_model_set(&m, 1, "f0=1", shape, channel, NULL) ||
                           ff_albedo_directional(&m, FF_ISA_BEST, 1, shape, channel, up, &found, NULL);
        if (failed) found.value = NAN;
    }
    say(t, fabs(found.value - (1 - log(2))) < 1e-7, "integrals: the albedo of ggx, alpha 1, along the normal is 1 - ln 2: %.9f",
        found.value);
}

/* ---- fits ------------------------------------------------------------------------------------ */

static const double truth[] = {0.3, 0.05, 0.2};
static const char *const name_of_truth[] = {"alpha_x", "f0", "kd"};

static ff_status simulated(const ff_model *m, ff_table *out)
{
    double shape[FF_MAX_SHAPE], channel[FF_MAX_CHANNEL_PARAMS];
    ff_simulate_options o;
    ff_simulate_options_init(&o);
    o.sampling.step_deg = 10;
    o.relative = 0.02;
    ff_model_defaults(m, 1, shape, channel);
    ff_status status = ff_model_set(m, 1, "alpha=0.3", shape, channel, NULL);
    if (!status) status = ff_model_set(m, 1, "f0=0.05", shape, channel, NULL);
    if (!status) status = ff_model_set(m, 1, "kd=0.2", shape, channel, NULL);
    return status ? status : ff_simulate_into(m, 1, shape, channel, &o, out, NULL);
}

static ff_status fitted(const ff_table *t, const ff_model *m, int threads, ff_fit_result *out)
{
    ff_problem *p;
    ff_fit_options o;
    ff_fit_options_init(&o);
    o.threads = threads;
    o.shape = FF_SHAPE_ISOTROPIC;
    ff_status status = ff_problem_make(t, m, 1, &o, &p, NULL);
    if (status) return status;
    status = ff_problem_fit_into(p, m, &o, out, NULL);
    ff_problem_free(p);
    return status;
}

static void check_fit(selftest *t)
{
    ff_model m;
    ff_table table;
    ff_fit_result fit[2];
    double worst = 0;
    int same = 1, made = 0;
    if (ff_model_parse("ggx+lambert", &m, NULL) || simulated(&m, &table)) {
        say(t, 0, "fit: no data could be made");
        return;
    }
    while (made < 2 && !fitted(&table, &m, made ? 3 : 1, &fit[made])) made++;
    for (int k = 0; k < 3 && made == 2; k++) {
        const ff_fit_value *a = ff_fit_result_find(&fit[0], name_of_truth[k], 0),
                           *b = ff_fit_result_find(&fit[1], name_of_truth[k], 0);
        worst = fmax(worst, fabs(a->value - truth[k]) / a->std_error);
        same &= !memcmp(&a->value, &b->value, sizeof a->value) && !memcmp(&a->std_error, &b->std_error, sizeof a->std_error);
    }
    say(t, made == 2 && fit[0].outcome == FF_CONVERGED && worst < 5,
        "fit: simulated data give their parameters back, within %.1f standard errors", worst);
    say(t, made == 2 && same, "fit: one thread and three give the same bits");
    while (made-- > 0) ff_fit_result_clear(&fit[made]);
    ff_table_clear(&table);
}

/* ---- files ----------------------------------------------------------------------------------- */

/* The largest difference between what was written and what is read, relative to the largest value; NaN: it cannot be read. */
static double file_error(const ff_format *format, const ff_model *m, const char *path, int *same_samples)
{
    double shape[FF_MAX_SHAPE], channel[3 * FF_MAX_CHANNEL_PARAMS], worst = 0, most = 0;
    ff_table made, read;
    ff_simulate_options o;
    ff_simulate_options_init(&o);
    o.sampling.step_deg = 10;
    const size_t channels = strcmp(format->name, "merl") ? 1 : 3;
    ff_model_defaults(m, channels, shape, channel);
    if (ff_simulate_layout_into(m, channels, shape, channel, format, NULL, &o, &made, NULL)) return NAN;
    const int failed = ff_table_write(path, format->name, &made, NULL) || ff_table_read_into(path, NULL, &read, NULL);
    if (!failed) {
        const size_t n = made.n == read.n ? made.n : 0;
        *same_samples = n > 0;
        for (size_t i = 0; i < n; i++) {
            const double a = made.value[i] * made.channels[0].scale, b = read.value[i] * read.channels[0].scale;
            if (!made.valid[i] || !read.valid[i]) continue;
            most = fmax(most, fabs(a));
            worst = fmax(worst, fabs(a - b));
        }
        ff_table_clear(&read);
    }
    ff_table_clear(&made);
    return failed ? NAN : most > 0 ? worst / most : 0;
}

static void check_files(selftest *t)
{
    char folder[] = "/tmp/facetfit.XXXXXX", path[64], bad[256] = "";
    double worst = 0;
    size_t n = 0, compared = 0;
    ff_model m;
    if (ff_model_parse("ggx+lambert", &m, NULL) || !mkdtemp(folder)) {
        say(t, 0, "files: no folder can be made in /tmp");
        return;
    }
    for (size_t i = 0; i < ff_format_count(); i++) {
        const ff_format *format = ff_format_at(i);
        if (!format->write) continue;
        snprintf(path, sizeof path, "%s/file", folder);
        int same_samples = 0;
        const double error = file_error(format, &m, path, &same_samples);
        if (isnan(error)) snprintf(bad + strlen(bad), sizeof bad - strlen(bad), " %s", format->name);
        worst = fmax(worst, error);
        unlink(path);
        n++;
        compared += (size_t)same_samples;
    }
    rmdir(folder);
    say(t, compared > 5 && !*bad && worst < 1e-3, "files: %zu formats are read back, %zu sample by sample, to %.0e%s%s", n,
        compared, worst, *bad ? "; not so:" : "", bad);
}

int cmd_selftest(const cli_args *args)
{
    selftest t = {.quiet = cli_given(args, FLAG_QUIET)};
    check_derivatives(&t);
    check_sets(&t);
    check_integrals(&t);
    check_fit(&t);
    check_files(&t);
    printf("%d checks, %d failed; facetfit %s, instruction set %s\n", t.checks, t.failures, args->head.version,
           ff_isa_name(FF_ISA_BEST));
    return t.failures ? EXIT_ANSWER_IS_NO : EXIT_DONE;
}
