/* Analytic derivatives against extrapolated differences: of every registered distribution, masking, Fresnel and diffuse term, and
 * of the objective and its normal equations for every loss, robust loss and weighting. The checkers are themselves shown wrong
 * derivatives. */
#include "model_samples.h"
#include "pass_of.h"
#include "loss_samples.h"

#define TOLERANCE 1e-8  /* of the natural scale of a product of the normal equations */
#define ROUNDING  1e-15 /* relative error of what is differenced, at least */

typedef struct tally {
    long checked, wrong, unresolved;
    double worst;                 /* largest deviation in units of the scale */
    char what[MODEL_LABEL + 256]; /* where the first wrong one was, or the worst */
} tally;

/* One analytic value against its extrapolated differences. scale > 0. */
static void compare(const model_ridders *r, double analytic, double scale, double accuracy, tally *t, const char *label,
                    const char *name, size_t where)
{
    const model_verdict verdict = model_judge_to(r, analytic, scale, accuracy);
    if (verdict == MODEL_UNRESOLVED) {
        t->unresolved++;
        return;
    }
    const double deviation = fabs(analytic - r->value) / scale;
    const int wrong = verdict == MODEL_WRONG;
    t->checked++;
    if (t->wrong == 0 && (wrong || deviation > t->worst))
        snprintf(t->what, sizeof t->what, "%s: d/d %s at %zu: %.15g, by differences %.15g +- %.1g, scale %.3g", label, name, where,
                 analytic, r->value, r->error, scale);
    if (!(deviation <= t->worst)) t->worst = deviation;
    t->wrong += wrong;
}

/* ---- the referee ----------------------------------------------------------------------------- */

/* Three functions of three variables, of which the second is nearly flat: it varies by billionths of its value. */
static void example(const double *x, double *y)
{
    y[0] = exp(x[0]) * x[1] + 3 * x[2];
    y[1] = 1 + 3e-9 * sin(2 * x[0]) + 2e-9 * x[1] * x[2];
    y[2] = sqrt(1 + x[0] * x[1]) + x[2] * x[2] * x[2];
}

static void example_jacobian(const double *x, double J[3][3])
{
    const double root = sqrt(1 + x[0] * x[1]);
    const double right[3][3] = {{exp(x[0]) * x[1], exp(x[0]), 3},
                                {6e-9 * cos(2 * x[0]), 2e-9 * x[2], 2e-9 * x[1]},
                                {x[1] / (2 * root), x[0] / (2 * root), 3 * x[2] * x[2]}};
    memcpy(J, right, sizeof right);
}

/* A Jacobian [row][column] judged entry by entry: how many were of each verdict. */
static void judge_all(const double *x, double J[3][3], int *counts)
{
    memset(counts, 0, 3 * sizeof *counts);
    for (int k = 0; k < 3; k++) {
        model_ridders r[3];
        double moved[3], low[3], high[3], at[3], step = 0.1;
        example(x, at);
        for (int i = 0; i < 3; i++) model_ridders_start(&r[i]);
        for (int level = 0; level < MODEL_LEVELS; level++, step /= MODEL_RATIO) {
            memcpy(moved, x, sizeof moved);
            moved[k] = x[k] - step;
            example(moved, low);
            moved[k] = x[k] + step;
            example(moved, high);
            for (int i = 0; i < 3; i++) model_ridders_add(&r[i], (high[i] - low[i]) / (2 * step), ROUNDING * fabs(at[i]) / step);
        }
        for (int i = 0; i < 3; i++) counts[model_judge(&r[i], J[i][k], fabs(at[i]) + fabs(r[i].value))]++;
    }
}

static void the_referee_is_right(void)
{
    for (int trial = 0; trial < 50; trial++) {
        uint64_t state = ff_test_stream("referee %d", trial);
        double x[3], J[3][3];
        int n[3];
        for (int k = 0; k < 3; k++) x[k] = 0.1 + 0.6 * fit_uniform(&state);
        example_jacobian(x, J);
        judge_all(x, J, n);
        FF_CHECK(n[MODEL_RIGHT] == 9, "right: %d wrong, %d not resolved", n[MODEL_WRONG], n[MODEL_UNRESOLVED]);
        for (int i = 0; i < 3; i++)
            for (int k = 0; k < 3; k++) {
                const double was = J[i][k];
                J[i][k] = was * (1 + 1e-6);
                judge_all(x, J, n);
                /* of a plateau this is a change of 1e-15 of the value, which no difference shows */
                FF_CHECK(n[MODEL_WRONG] == (i != 1), "(%d, %d) off by a millionth: %d wrong", i, k, n[MODEL_WRONG]);
                J[i][k] = 0;
                judge_all(x, J, n);
                FF_CHECK(n[MODEL_WRONG] == 1, "a zero at (%d, %d): %d wrong", i, k, n[MODEL_WRONG]);
                J[i][k] = was;
            }
        for (int k = 0; k < 2; k++) { /* every row of two columns */
            for (int i = 0; i < 3; i++) {
                const double swap = J[i][k];
                J[i][k] = J[i][k + 1], J[i][k + 1] = swap;
            }
            judge_all(x, J, n);
            FF_CHECK(n[MODEL_WRONG] >= 4, "columns %d and %d swapped: %d wrong", k, k + 1, n[MODEL_WRONG]);
            example_jacobian(x, J);
        }
    }
}

/* A narrow lobe on a broad one: the first steps leap over it to both sides and see nothing. */
static void lobes_are_not_leapt_over(void)
{
    const double at = 0.301, middle = 0.3, width = 2e-3;
    model_ridders r;
    double step = 0.1;
    model_ridders_start(&r);
    for (int level = 0; level < MODEL_LEVELS; level++, step /= MODEL_RATIO) {
        const double low = (at - step - middle) / width, high = (at + step - middle) / width;
        model_ridders_add(&r, (exp(-high * high) - exp(-low * low)) / (2 * step), ROUNDING / step);
    }
    const double x = (at - middle) / width, derivative = -2 * x / width * exp(-x * x);
    FF_CHECK(model_judge(&r, derivative, 1 / width) == MODEL_RIGHT, "%g, by differences %g +- %g", derivative, r.value, r.error);
    FF_CHECK(model_judge(&r, 0, 1 / width) == MODEL_WRONG, "0 where a lobe is");
}

/* Differences that are noise, and a derivative that is 0: neither right nor wrong. */
static void noise_is_not_resolved(void)
{
    model_ridders r = {.value = 3e-13, .error = 2e-13};
    FF_CHECK(model_judge(&r, 0, 1) == MODEL_UNRESOLVED, "0 against noise");
    r.value = 0;
    FF_CHECK(model_judge(&r, 0, 1) == MODEL_RIGHT, "what does not vary at all has the derivative 0");
    r.value = 1, r.error = 1e-8;
    FF_CHECK(model_judge(&r, 1, 1) == MODEL_UNRESOLVED, "differences that say nothing");
    FF_CHECK(model_judge(&r, NAN, 1) == MODEL_UNRESOLVED && (r.error = 0, model_judge(&r, NAN, 1)) == MODEL_WRONG, "NaN");
    r.value = NAN;
    FF_CHECK(model_judge(&r, 1, 1) == MODEL_WRONG, "differences of NaN");
}

/* ---- models ---------------------------------------------------------------------------------- */

enum { PAIRS = 40, CHANNELS = 2 };

/* Something that is done to a plane of derivatives before it is checked. */
typedef void (*fault)(const model_pairs *w, double *df);

static void evaluate(const fit_surface *s, const model_pairs *w, double *f, double *df)
{
    const ff_dirs dirs = model_dirs(w);
    const ff_status status = ff_model_eval(&s->model, FF_ISA_BEST, s->n_channels, s->shape, s->channel, &dirs, w->n, f, df, w->n);
    FF_CHECK(status == FF_OK, "%s", ff_status_str(status));
}

/* Adds to parameter k (shape, then per channel: that of every channel, in its box: a step may be too long for one that is not
 * looked at). */
static void move(fit_surface *s, uint32_t k, const double *base, double step)
{
    const uint32_t n = s->model.n_shape;
    if (k < n) s->shape[k] = base[0] + step;
    for (size_t c = 0; k >= n && c < s->n_channels; c++) {
        const ff_param *p = s->model.channel[k - n].info;
        s->channel[c * s->model.n_channel + k - n] = fmin(fmax(base[c] + step, p->lo), p->hi);
    }
}

/* Differences of f at one step; a sample where f changes by more than a third, or vanishes, has to wait for shorter ones.
 */
static void add_differences(const double *f, const double *low, const double *high, double step, size_t n, double floor,
                            model_ridders *r)
{
    for (size_t i = 0; i < n; i++) {
        const double lesser = fmin(low[i], high[i]), greater = fmax(low[i], high[i]);
        if (lesser > 0.75 * f[i] && greater < 1.33 * f[i])
            model_ridders_add(&r[i], (high[i] - low[i]) / (2 * step), ROUNDING * (f[i] + floor) / step);
        else
            model_ridders_drop(&r[i]);
    }
}

/* Differences by parameter k of all samples, at steps from first on. base [CHANNELS]: its values. */
/* f(x - step), f(x + step); of one side f and f + side (4 f(x + step) - f(x + 2 step) - 3 f), steps to that side: their difference
 * over 2 steps is the derivative to second order. */
static void values_about(const fit_surface *s, const model_pairs *w, uint32_t k, const double *base, double step, int side,
                         const double *f, double *low, double *high)
{
    const size_t all = CHANNELS * w->n;
    fit_surface moved = *s;
    move(&moved, k, base, side ? 2 * side * step : -step);
    evaluate(&moved, w, low, NULL);
    move(&moved, k, base, side ? side * step : step);
    evaluate(&moved, w, high, NULL);
    for (size_t i = 0; i < all && side; i++) {
        high[i] = f[i] + side * (4 * high[i] - low[i] - 3 * f[i]);
        low[i] = f[i];
    }
}

/* side 0: central ones; -1, 1: of one side alone, which a kink on the other does not touch. */
static void take_differences(const fit_surface *s, const model_pairs *w, uint32_t k, const double *base, double first, int side,
                             const double *f, model_ridders *r)
{
    const size_t all = CHANNELS * w->n;
    static double low[CHANNELS * PAIRS], high[CHANNELS * PAIRS];
    const double floor = model_floor(&s->model);
    double step = first;
    for (size_t i = 0; i < all; i++) model_ridders_start(&r[i]);
    for (int level = 0; level < MODEL_LEVELS; level++, step /= MODEL_RATIO) {
        int open = level < MODEL_TABLEAU;
        values_about(s, w, k, base, step, side, f, low, high);
        add_differences(f, low, high, step, all, floor, r);
        for (size_t i = 0; i < all; i++) open |= f[i] > 0 && !(r[i].error <= 1e-11 * fabs(r[i].value));
        if (!open) break;
    }
}

/* What a derivative is measured by: the value by the size of the parameter, and the differences. */
static double scale_of(const model_ridders *r, double f, double floor, double size)
{
    return (f + floor) / size + (isnan(r->value) ? 0 : fabs(r->value));
}

/* The smallest width among the shape parameters: what a mean slope is measured in. */
static double narrowest(const fit_surface *s)
{
    double least = 1;
    for (uint32_t k = 0; k < s->model.n_shape; k++) {
        const ff_param *p = s->model.shape[k].info;
        if (p->flags & FF_PARAM_LOG) least = fmin(least, s->shape[k] + p->offset);
    }
    return least;
}

/* Further questions where an answer is wrong: by other steps, and by those of one side. */
enum { QUESTIONS = 3 };
static const struct {
    double first; /* step, of the usual one */
    int side;
} questions[QUESTIONS] = {{0.77, 0}, {0.05, -1}, {0.05, 1}};

static model_verdict judge(const model_ridders *r, const ff_model *m, double analytic, double scale)
{
    return model_judge_to(r, analytic, scale, model_accuracy(m));
}

/* Checks d f / d p_k in df [CHANNELS][params][n] at s. The error of extrapolated differences is an estimate: where a kink of the
 * second derivative lies between the steps (the bins of a table, the edge of a masking) two extrapolations agree by chance. So one
 * that looks wrong is asked about again by steps that fall elsewhere and by those of either side; it is wrong unless one of them
 * resolves it and finds it right. */
static void check_parameter(const fit_surface *s, const model_pairs *w, uint32_t k, const double *f, const double *df, tally *t,
                            const char *label)
{
    const ff_model *m = &s->model;
    const size_t n = w->n, n_params = m->n_shape + m->n_channel;
    const ff_model_param *param = k < m->n_shape ? &m->shape[k] : &m->channel[k - m->n_shape];
    static model_ridders r[CHANNELS * PAIRS], again[QUESTIONS][CHANNELS * PAIRS];
    const double floor = model_floor(m);
    /* a step over a narrow lobe beside a broad one sees nothing of it, and shorter ones the rounding of the broad one */
    const double widest = k < m->n_shape && model_is_slope(param->info) ? 0.1 * narrowest(s) : HUGE_VAL;
    double base[CHANNELS], step = 0;
    unsigned asked = 0;
    for (size_t c = 0; c < CHANNELS; c++) {
        base[c] = k < m->n_shape ? s->shape[k] : s->channel[c * m->n_channel + k - m->n_shape];
    }
    for (size_t c = 0; c < CHANNELS; c++) { /* of values of very different sizes each has steps of its own */
        const double own = model_first_step(param->info, base[c]);
        if (own != step) take_differences(s, w, k, base, step = own, 0, f, r), asked = 0;
        const double size = fmax(fabs(base[c]), param->info->flags & FF_PARAM_LOG ? 0 : 1);
        for (size_t i = 0; i < n; i++) {
            const double *plane = df + (c * n_params + k) * n, value = f[c * n + i];
            model_ridders *ri = &r[c * n + i];
            if (!(value > 1e-250)) { /* below it the differences are of subnormal numbers */
                FF_CHECK(isfinite(plane[i]), "%s: d/d %s is %g where f is %g", label, param->name, plane[i], value);
                continue;
            }
            for (int q = 0; q < QUESTIONS && judge(ri, m, plane[i], scale_of(ri, value, floor, size)) == MODEL_WRONG; q++) {
                if (!(asked >> q & 1))
                    take_differences(s, w, k, base, questions[q].first * fmin(step, widest), questions[q].side, f, again[q]);
                asked |= 1u << q;
                if (judge(&again[q][c * n + i], m, plane[i], scale_of(&again[q][c * n + i], value, floor, size)) ==
                    MODEL_UNRESOLVED)
                    continue;
                ri = &again[q][c * n + i];
            }
            compare(ri, plane[i], scale_of(ri, value, floor, size), model_accuracy(m), t, label, param->name, i);
        }
    }
}

/* All derivatives of a model. spoil, when not NULL, is done to those of parameter `which`, which then is checked alone. */
static void check_surface(const fit_surface *s, uint64_t *state, const char *label, fault spoil, uint32_t which, tally *t)
{
    static double f[CHANNELS * PAIRS], alone[CHANNELS * PAIRS], df[CHANNELS * (FF_MAX_SHAPE + FF_MAX_CHANNEL_PARAMS) * PAIRS];
    static model_pairs w;
    const ff_model *m = &s->model;
    const uint32_t n_params = m->n_shape + m->n_channel;
    w.n = 0;
    model_pairs_random(m, s->shape, state, PAIRS, &w);
    for (size_t i = 0; i < sizeof df / sizeof *df; i++) df[i] = NAN;
    evaluate(s, &w, f, df);
    evaluate(s, &w, alone, NULL);
    FF_CHECK(memcmp(f, alone, sizeof f) == 0, "%s: f has other bits without derivatives", label);
    for (uint32_t k = 0; k < n_params; k++) {
        if (spoil && k != which) continue;
        for (size_t c = 0; spoil && c < CHANNELS; c++) spoil(&w, df + (c * n_params + k) * w.n);
        /* where a mean slope has no meaning there is nothing to take a difference of */
        if (k < m->n_shape && model_is_slope(m->shape[k].info) && model_needs_centred(m)) continue;
        check_parameter(s, &w, k, f, df, t, label);
    }
}

/* The same at random parameters. */
static void check_model(const ff_model *m, model_freedom freedom, double reach, uint64_t *state, const char *label, fault spoil,
                        uint32_t which, tally *t)
{
    fit_surface s = {.model = *m, .n_channels = CHANNELS};
    model_random_parameters(m, CHANNELS, freedom, reach, state, s.shape, s.channel);
    check_surface(&s, state, label, spoil, which, t);
}

/* Prints what a tally found; most differences must have been resolved. */
static void report(const tally *t, const char *of)
{
    FF_CHECK(t->wrong == 0, "%ld of %ld derivatives of %s are wrong; %s", t->wrong, t->checked, of, t->what);
    FF_CHECK(t->checked > 0 && t->unresolved <= t->checked / 50, "%s: %ld differences resolved, %ld not", of, t->checked,
             t->unresolved);
}

static void every_combination(void)
{
    tally all = {0};
    for (size_t k = 0; k < model_combination_count(); k++) {
        char label[MODEL_LABEL];
        const ff_model m = model_combination(k, label);
        tally t = {0};
        if (!ff_test_drawn(3, "combination %s", label)) continue;
        uint64_t state = ff_test_stream("combination %s", label);
        check_model(&m, MODEL_ROUND, 0.5, &state, label, NULL, 0, &t);
        check_model(&m, m.n_bases ? MODEL_CENTRED : MODEL_TILTED, 0.5, &state, label, NULL, 0, &t); /* half of them each */
        report(&t, label);
        all.checked += t.checked, all.unresolved += t.unresolved, all.worst = fmax(all.worst, t.worst);
    }
    printf("  %ld derivatives, worst %.1e of the scale, %ld not resolved\n", all.checked, all.worst, all.unresolved);
}

/* The whole box, corners nearly: roughness from 1e-4 to 4, correlation to 0.99. */
static void wide_boxes(void)
{
    for (size_t ndf = 0; ndf < ff_term_count(FF_NDF); ndf++) {
        ff_model m;
        tally t = {0};
        const char *name = ff_term_at(FF_NDF, ndf)->name;
        if (!model_lobe(ndf, ff_ndf_at((int)ndf)->lambda ? "smith-height-correlated" : "kelemen", "schlick", &m)) exit(1);
        uint64_t state = ff_test_stream("wide box %s", name);
        for (int k = 0; k < 12; k++) check_model(&m, (model_freedom)(k % 3), 1, &state, name, NULL, 0, &t);
        report(&t, name);
        printf("  %-15s %ld derivatives, worst %.1e of the scale, %ld not resolved\n", name, t.checked, t.worst, t.unresolved);
    }
}

/* Small whole numbers and the initial values, where a series may end early or a function has a branch of its own. */
static void whole_numbers(void)
{
    for (size_t ndf = 0; ndf < ff_term_count(FF_NDF); ndf++) {
        ff_model m;
        tally t = {0};
        const char *name = ff_term_at(FF_NDF, ndf)->name;
        if (!model_lobe(ndf, ff_ndf_at((int)ndf)->lambda ? "smith-separable" : "kelemen", "schlick", &m)) exit(1);
        uint64_t state = ff_test_stream("whole numbers %s", name);
        check_model(&m, MODEL_ROUND, 0, &state, name, NULL, 0, &t);
        for (int value = 0; value <= 20; value++) {
            fit_surface s = {.model = m, .n_channels = CHANNELS};
            int used = 0;
            ff_model_defaults(&m, CHANNELS, s.shape, s.channel);
            for (uint32_t k = 0; k < m.n_shape; k++) {
                const ff_param *p = m.shape[k].info;
                if (!(value > p->lo && value < p->hi)) continue;
                s.shape[k] = value;
                used = 1;
            }
            if (used) check_surface(&s, &state, name, NULL, 0, &t);
        }
        report(&t, name);
    }
}

/* A distribution under a masking beside what others there are; 1 when it is a model. */
static int check_sum(const char *ndf, const char *masking, const char *rest, model_freedom freedom)
{
    char expression[MODEL_LABEL];
    tally t = {0};
    ff_model m;
    snprintf(expression, sizeof expression, "%s/%s+%s", ndf, masking, rest);
    if (ff_model_parse(expression, &m, NULL)) return 0; /* these do not go together */
    ff_model_set_table(&m, fit_profile());
    uint64_t state = ff_test_stream("sum %s", expression);
    check_model(&m, freedom, 0.5, &state, expression, NULL, 0, &t);
    report(&t, expression);
    return 1;
}

/* Sums of lobes: every distribution, and every masking, before others. The companions are named, not the next in the registry. */
static void several_lobes(void)
{
    static const char *const rests[] = {"beckmann/smith-separable", "student-t/v-cavity+ggx+lambert",
                                        "phong/smith-height-correlated+ggx"};
    const size_t n = ff_term_count(FF_NDF), n_masking = ff_term_count(FF_MASKING);
    size_t distributions = 0, maskings = 0;
    for (size_t k = 0; k < n; k++) {
        int sums = 0;
        for (int i = 0; i < 3; i++)
            sums += check_sum(ff_term_at(FF_NDF, k)->name, ff_ndf_at((int)k)->lambda ? "smith-direction-correlated" : "kelemen",
                              rests[i], (model_freedom)i);
        distributions += sums > 0;
    }
    for (size_t g = 0; g < n_masking; g++) {
        int sums = 0;
        for (int i = 0; i < 3; i++)
            sums += check_sum(i == 2 ? "beckmann" : "ggx", ff_term_at(FF_MASKING, g)->name, rests[i], (model_freedom)i);
        maskings += sums > 0;
    }
    FF_CHECK(distributions == n, "only %zu of %zu distributions were summed", distributions, n);
    FF_CHECK(maskings + 3 >= n_masking, "only %zu of %zu maskings", maskings, n_masking);
}

/* Lobes that share a Fresnel term, more than one base, free scales, and everything that is coupled at once. */
static void shared_and_coupled(void)
{
    static const char *const expressions[] = {
        "ggx+beckmann/v-cavity/shared",
        "ggx+ggx/smith-separable/shared+student-t/smith-height-correlated/shared+lambert",
        "ggx/v-cavity/dielectric+phong/v-cavity/shared+mikkelsen-coupled",
        "ggx/smith-height-correlated/conductor+ggx/smith-separable/shared+kulla-conty+lambert",
        "beckmann+ggx/smith-separable/schlick-f82+kelemen-matte+kulla-conty",
        "ggx/hammon+hammon+eon",
        "ggx/smith-height-correlated/conductor+multiple-scattering+lambert",
        "gtr+vmf/v-cavity/dielectric+mikkelsen-coupled",
        "ggx/smith-height-direction-correlated/sgd+shirley-coupled+oren-nayar",
        "cook-torrance",
        "ngan-2005",
        "kelemen-2001",
        "mikkelsen-2009",
        "disney-2012",
        "hammon-2017",
        "torrance-sparrow",
        "walter-2007"};
    for (size_t k = 0; k < sizeof expressions / sizeof *expressions; k++) {
        const ff_model m = model_parse(expressions[k]);
        tally t = {0};
        uint64_t state = ff_test_stream("shared and coupled %s", expressions[k]);
        for (int i = 0; i < 3; i++)
            if (ff_test_turn(3, (size_t)i, expressions[k]))
                check_model(&m, (model_freedom)(i % 2), 0.5, &state, expressions[k], NULL, 0, &t);
        report(&t, expressions[k]);
    }
}

/* ---- deliberately wrong derivatives are caught ----------------------------------------------- */

static void as_it_is(const model_pairs *w, double *df)
{
    (void)w, (void)df;
}

static void by_hz3(const model_pairs *w, double *df)
{
    for (size_t i = 0; i < w->n; i++) {
        const double h[3] = {w->w[0][i] + w->w[3][i], w->w[1][i] + w->w[4][i], w->w[2][i] + w->w[5][i]};
        df[i] *= pow(h[2] / sqrt(h[0] * h[0] + h[1] * h[1] + h[2] * h[2]), 3);
    }
}

static void by_sign(const model_pairs *w, double *df)
{
    for (size_t i = 0; i < w->n; i++) df[i] = -df[i];
}

static void by_a_millionth(const model_pairs *w, double *df)
{
    for (size_t i = 0; i < w->n; i++) df[i] *= 1 + 1e-6;
}

/* Counted from the last; that of one sample may be one of the few that differences do not resolve. */
static size_t spoiled;
static void by_one_sample(const model_pairs *w, double *df)
{
    df[w->n - 1 - spoiled] = df[0];
}

static void wrong_derivatives_are_caught(void)
{
    static const fault faults[] = {by_hz3, by_sign, by_a_millionth, by_one_sample};
    for (size_t ndf = 0; ndf < ff_term_count(FF_NDF); ndf++) {
        ff_model m;
        const char *name = ff_term_at(FF_NDF, ndf)->name;
        char expression[MODEL_LABEL];
        snprintf(expression, sizeof expression, "%s/%s+lambert", name, ff_ndf_at((int)ndf)->lambda ? "smith-separable" : "kelemen");
        m = model_parse(expression);
        for (uint32_t k = 0; k < m.n_shape + m.n_channel; k++) {
            const char *param = k < m.n_shape ? m.shape[k].name : m.channel[k - m.n_shape].name;
            tally right = {0};
            const uint64_t start = ff_test_stream("faults %s %s", name, param);
            uint64_t state = start, again = start;
            check_model(&m, MODEL_TILTED, 0.3, &state, name, as_it_is, k, &right);
            FF_CHECK(right.wrong == 0 && right.checked > PAIRS, "%s", right.what);
            for (size_t f = 0; f < sizeof faults / sizeof *faults; f++, again = start) {
                /* the diffuse term has one derivative for all samples: taking another sample's is no fault */
                if (faults[f] == by_one_sample && k + 1 == m.n_shape + m.n_channel) continue;
                tally t = {0};
                const size_t places = faults[f] == by_one_sample ? 3 : 1;
                for (spoiled = 0; spoiled < places && t.wrong == 0; spoiled++, again = start)
                    check_model(&m, MODEL_TILTED, 0.3, &again, name, faults[f], k, &t);
                FF_CHECK(t.wrong > 0, "%s: fault %zu of d/d %s was not seen", name, f, param);
            }
        }
    }
}

/* ---- the objective --------------------------------------------------------------------------- */

enum { MAX_COORDINATES = 24 };

/* A problem, the point it is looked at, and what the test knows of it without asking the fit. */
typedef struct objective {
    fit_surface s; /* where */
    ff_fit_options o;
    ff_table t;
    model_pairs w;
    ff_problem *p;
    ff_layout l;
    ff_normal normal;
    double *weight; /* [n], of mean 1 */
    char label[MODEL_LABEL + 96];
} objective;

typedef struct setting {
    const char *expression, *truth, *point;
    ff_shape shape;
    int mean_slope;
    int dark; /* 1: some data are far below the others, some negative */
} setting;

static double *doubles(size_t n)
{
    double *p = calloc(n, sizeof *p);
    if (!p) exit(1);
    return p;
}

/* A measurement of `truth` with noise and outliers, every kind of weight in its table. */
static ff_table measurement(const setting *g, const model_pairs *w, size_t n_channels, uint64_t *state)
{
    const fit_surface truth = fit_surface_make(g->expression, n_channels, g->truth);
    ff_table t;
    if (ff_table_init(w->n, n_channels, NULL, 1, 1, &t, NULL)) exit(1);
    t.radians_per_unit = 1;
    t.isotropic = g->shape == FF_SHAPE_ISOTROPIC;
    for (size_t i = 0; i < w->n; i++) {
        for (int side = 0; side < 2; side++) {
            t.angle[2 * side][i] = acos(w->w[3 * side + 2][i]);
            t.angle[2 * side + 1][i] = atan2(w->w[3 * side + 1][i], w->w[3 * side][i]);
        }
        t.weight[i] = 0.2 + fit_uniform(state);
    }
    fit_evaluate(&truth, &t);
    for (size_t k = 0; k < t.n * n_channels; k++) {
        t.value[k] *= k % 9 == 4 ? 4 : 1 + 0.05 * fit_normal(state);
        if (g->dark && k % 9 == 7) t.value[k] *= k % 2 ? 1e-6 : -1e-3;
        t.sigma[k] = (0.02 + 0.1 * fit_uniform(state)) * fabs(t.value[k]);
    }
    return t;
}

static void objective_make(const setting *g, size_t n_channels, size_t n, ff_loss loss, ff_robust robust, ff_weighting weighting,
                           objective *b)
{
    ff_error err = {0};
    memset(b, 0, sizeof *b);
    b->s = fit_surface_make(g->expression, n_channels, g->point);
    snprintf(b->label, sizeof b->label, "%s, %s, robust %s, weight %s", g->expression, ff_loss_name((int)loss),
             ff_robust_name((int)robust), ff_weighting_name((int)weighting));
    uint64_t state = ff_test_stream("objective %s", b->label);
    model_pairs_random(&b->s.model, b->s.shape, &state, n, &b->w);
    b->t = measurement(g, &b->w, n_channels, &state);
    ff_fit_options_init(&b->o);
    b->o.loss = loss, b->o.robust = robust, b->o.weighting = weighting;
    b->o.shape = g->shape, b->o.mean_slope = g->mean_slope;
    b->o.robust_scale = 1;
    b->o.max_theta = 89 * FIT_DEGREE;
    b->o.threads = 1;
    FF_CHECK(ff_problem_make(&b->t, &b->s.model, 1, &b->o, &b->p, &err) == FF_OK, "%s: %s", b->label, err.message);
    FF_CHECK(ff_layout_init(&b->s.model, n_channels, g->shape, g->mean_slope, &b->l, &err) == FF_OK, "%s: %s", b->label,
             err.message);
    FF_CHECK(ff_layout_normal(&b->l, &b->normal) == FF_OK, "%s", b->label);
    if (!b->p || b->l.P > MAX_COORDINATES) exit(1);
    b->weight = doubles(n);
    double sum = 0;
    for (size_t i = 0; i < n; i++) sum += weighting == FF_WEIGHT_SOLID_ANGLE ? b->t.weight[i] : 1;
    for (size_t i = 0; i < n; i++) b->weight[i] = (weighting == FF_WEIGHT_SOLID_ANGLE ? b->t.weight[i] : 1) * (double)n / sum;
}

static void objective_free(objective *b)
{
    ff_problem_free(b->p);
    ff_normal_free(&b->normal);
    ff_table_clear(&b->t);
    free(b->weight);
}

/* Coordinates of where it is looked at, [P]. */
static void coordinates(const objective *b, double *x)
{
    ff_layout_pack(&b->l, b->s.shape, b->s.channel, x);
}

static fit_surface surface_at(const objective *b, const double *x)
{
    fit_surface s = b->s;
    ff_layout_unpack(&b->l, x, s.shape, s.channel);
    return s;
}

/* A pass of the fit at x: b->normal. */
static void pass_at(objective *b, const double *x, int final)
{
    const fit_surface s = surface_at(b, x);
    ff_pass pass;
    ff_status status = pass_of(&b->l, b->p, &b->o, s.shape, s.channel, &pass);
    if (status) exit(1);
    pass.final = final;
    status = ff_pass_run(&pass, 0, &b->normal);
    ff_pass_free(&pass);
    FF_CHECK(status == FF_OK, "%s: %s", b->label, ff_status_str(status));
}

/* Weighted residuals [n_channels][n] before the robust loss, from ff_model_eval and the definitions alone. */
static void residuals(const objective *b, const double *x, double *r)
{
    const fit_surface s = surface_at(b, x);
    const size_t n = b->w.n;
    evaluate(&s, &b->w, r, NULL);
    for (size_t c = 0; c < s.n_channels; c++) {
        const double least = loss_least(&b->t.value[c * n], n);
        for (size_t i = 0; i < n; i++) {
            const double y = b->t.value[c * n + i], cos_i = b->w.w[2][i];
            double *ri = &r[c * n + i];
            *ri = loss_g(b->o.loss, *ri, cos_i) - loss_g(b->o.loss, y, cos_i);
            if (b->o.weighting == FF_WEIGHT_SIGMA) /* standard deviations, whatever the loss is scaled by */
                *ri /= b->t.sigma[c * n + i] * loss_slope(b->o.loss, y, cos_i);
            else
                *ri *= sqrt(b->weight[i]) * loss_factor(b->o.loss, y, cos_i, least);
        }
    }
}

static int by_size(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* The scale of the robust loss: in the widest gap of the residuals' upper half, so that both branches are taken. */
static void choose_scale(objective *b, const double *x)
{
    const size_t n = b->w.n * b->l.n_channels;
    double *r = doubles(n), best = 0;
    residuals(b, x, r);
    for (size_t i = 0; i < n; i++) r[i] = fabs(r[i]);
    qsort(r, n, sizeof *r, by_size);
    for (size_t i = n / 2; i + n / 10 + 2 < n; i++)
        if (r[i + 1] / r[i] > best) best = r[i + 1] / r[i], b->o.robust_scale = sqrt(r[i] * r[i + 1]);
    free(r);
}

/* Is the objective what its definition says? */
static void check_cost(const objective *b, const double *x)
{
    const size_t n = b->w.n * b->l.n_channels;
    double *r = doubles(n), cost2 = 0;
    residuals(b, x, r);
    for (size_t i = 0; i < n; i++) cost2 += loss_rho(b->o.robust, r[i] * r[i], b->o.robust_scale);
    FF_CHECK(fabs(b->normal.cost2 - cost2) <= 1e-11 * cost2, "%s: cost2 %.15g, by definition %.15g", b->label, b->normal.cost2,
             cost2);
    free(r);
}

/* d value / d coordinate of all coordinates. */
static void slopes(const objective *b, const double *x, double *slope)
{
    const fit_surface s = surface_at(b, x);
    ff_layout_slope(&b->l, s.shape, s.channel, slope);
}

static const char *coordinate_name(const objective *b, size_t k)
{
    return ff_layout_param(&b->l, k, NULL)->name;
}

/* A profile by values has a second derivative that jumps at each of them. Steps h below which rounding leaves nothing, about 1e-6,
 * still cross some for a few of the samples; each moves a difference quotient by h times its jump, so that 1e-7 of the scale is
 * what differences of a sum over samples can be asked. */
static double objective_accuracy(const objective *b)
{
    const ff_model *m = &b->s.model;
    for (uint32_t k = 0; k < m->n_lobes; k++)
        if (ff_ndf_at(m->lobe[k].ndf)->needs_values) return 1e-7;
    return model_accuracy(m);
}

/* Differences of cost2 / 2 by coordinate k about x, from a first step on; side as take_differences. */
static void objective_differences(objective *b, double *x, size_t k, double step, int side, double scale, model_ridders *r)
{
    const double middle = x[k];
    double here = 0;
    model_ridders_start(r);
    if (side) {
        pass_at(b, x, 0);
        here = b->normal.cost2;
    }
    for (int level = 0; level < 20 && !(r->error < 1e-12 * scale); level++, step /= MODEL_RATIO) {
        x[k] = middle + (side ? side * step : step);
        pass_at(b, x, 0);
        const double high = b->normal.cost2;
        x[k] = middle + (side ? 2 * side * step : -step);
        pass_at(b, x, 0);
        const double low = b->normal.cost2, rise = side ? side * (4 * high - low - 3 * here) : high - low;
        model_ridders_add(r, rise / (4 * step), (side ? 4 : 1) * ROUNDING * high / step);
    }
    x[k] = middle;
}

/* J^T r of a pass against differences of its cost2 / 2, scale sqrt(H_kk cost2). spoil > 0: scales component `which` by 1 + spoil.
 */
static void check_gradient(objective *b, double spoil, size_t which, tally *t)
{
    const size_t P = b->l.P;
    double x[MAX_COORDINATES], slope[MAX_COORDINATES], g[MAX_COORDINATES], H[MAX_COORDINATES * MAX_COORDINATES],
        scale[MAX_COORDINATES];
    coordinates(b, x);
    if (b->o.robust != FF_ROBUST_NONE) choose_scale(b, x);
    pass_at(b, x, 0);
    check_cost(b, x);
    slopes(b, x, slope);
    assemble(&b->l, &b->normal, slope, H, g);
    for (size_t k = 0; k < P; k++) scale[k] = sqrt(H[k * P + k] * b->normal.cost2);
    if (spoil != 0) g[which] += spoil * scale[which];
    for (size_t k = 0; k < P; k++) {
        enum { FIRST_STEP = 50 }; /* its inverse */
        const double accuracy = objective_accuracy(b);
        model_ridders r, other;
        if (spoil != 0 && k != which) continue;
        objective_differences(b, x, k, 1.0 / FIRST_STEP, 0, scale[k], &r);
        for (int q = 0; q < QUESTIONS && model_judge_to(&r, g[k], scale[k], accuracy) == MODEL_WRONG; q++) {
            objective_differences(b, x, k, questions[q].first / FIRST_STEP, questions[q].side, scale[k], &other);
            if (model_judge_to(&other, g[k], scale[k], accuracy) != MODEL_UNRESOLVED) r = other;
        }
        compare(&r, g[k], scale[k], accuracy, t, b->label, coordinate_name(b, k), k);
    }
}

static const setting settings[] = {
    {"ggx+lambert", "alpha=0.3 f0=0.5 kd=0.2", "alpha=0.4 f0=0.6 kd=0.15", FF_SHAPE_ISOTROPIC, 0, 0},
    {"beckmann/smith-separable+lambert", "alpha_x=0.4 alpha_y=0.6 r_xy=0.3 f0=0.5 kd=0.2",
     "alpha_x=0.5 alpha_y=0.55 r_xy=-0.2 f0=0.6 kd=0.15", FF_SHAPE_CORRELATED, 0, 0},
    {"student-t+lambert", "alpha_x=0.3 alpha_y=0.5 r_xy=0.3 gamma=2.5 f0=0.5 kd=0.2",
     "alpha_x=0.4 alpha_y=0.45 r_xy=-0.2 slope_x=0.1 slope_y=-0.05 gamma=3 f0=0.6 kd=0.15", FF_SHAPE_CORRELATED, 1, 0},
    {"phong/v-cavity/schlick+lambert", "n=20 f0=0.5 kd=0.2", "n=12 f0=0.6 kd=0.15", FF_SHAPE_ISOTROPIC, 0, 0},
    {"ggx/smith-separable+beckmann/v-cavity+lambert", "alpha_x=0.2 alpha_y=0.3 lobe2.alpha=0.6 f0=0.5 lobe2.f0=0.1 kd=0.2",
     "alpha_x=0.25 alpha_y=0.35 lobe2.alpha=0.7 f0=0.6 lobe2.f0=0.2 kd=0.15", FF_SHAPE_AXIS, 0, 0},
};
enum { SETTINGS = sizeof settings / sizeof *settings };
static const ff_weighting weightings[] = {FF_WEIGHT_SOLID_ANGLE, FF_WEIGHT_SAMPLE, FF_WEIGHT_SIGMA};

static void every_objective(void)
{
    tally t = {0};
    for (size_t k = 0; k < SETTINGS; k++)
        for (int loss = 0; loss < FF_LOSS_COUNT; loss++)
            for (int robust = 0; robust < FF_ROBUST_COUNT; robust++)
                for (size_t w = 0; w < 3; w++) {
                    objective b;
                    objective_make(&settings[k], 3, 300, (ff_loss)loss, (ff_robust)robust, weightings[w], &b);
                    check_gradient(&b, 0, 0, &t);
                    objective_free(&b);
                }
    report(&t, "the objective");
    printf("  %ld components, worst %.1e of the scale, %ld not resolved\n", t.checked, t.worst, t.unresolved);
}

/* Data near 0 and below it, where the relative loss has a floor and the cube root is steep. */
static void dark_data(void)
{
    for (int loss = 0; loss < FF_LOSS_COUNT; loss++)
        for (int robust = 0; robust < FF_ROBUST_COUNT; robust++)
            for (size_t w = 0; w < 3; w++) {
                setting g = settings[1];
                objective b;
                double x[MAX_COORDINATES];
                if (!ff_loss_has_value((ff_loss)loss, 0, 1)) continue; /* it leaves dark data out */
                g.dark = 1;
                objective_make(&g, 3, 300, (ff_loss)loss, (ff_robust)robust, weightings[w], &b);
                coordinates(&b, x);
                if (robust) choose_scale(&b, x);
                pass_at(&b, x, 0);
                check_cost(&b, x);
                objective_free(&b);
            }
}

/* The fit composes the kernels by itself: every distribution and masking, in each layout that it can take. */
static void every_term_in_the_fit(void)
{
    static const struct {
        ff_shape shape;
        int mean_slope;
    } layouts[] = {
        {FF_SHAPE_ISOTROPIC, 0}, {FF_SHAPE_AXIS, 0}, {FF_SHAPE_CORRELATED, 0}, {FF_SHAPE_CORRELATED, 1}, {FF_SHAPE_ISOTROPIC, 1}};
    tally t = {0};
    for (size_t k = 0; k < model_combination_count(); k++) {
        char label[MODEL_LABEL];
        const ff_model m = model_combination(k, label);
        for (size_t i = 0; i < sizeof layouts / sizeof *layouts; i++) {
            ff_layout l;
            objective b;
            const setting g = {label, "", "", layouts[i].shape, layouts[i].mean_slope, 0};
            if (ff_layout_init(&m, 1, g.shape, g.mean_slope, &l, NULL)) continue; /* it cannot */
            objective_make(&g, 1, 60, FF_LOSS_COSINE, FF_ROBUST_NONE, FF_WEIGHT_SAMPLE, &b);
            for (uint32_t q = 0; q < l.free.n_shape; q++) { /* away from where derivatives vanish by symmetry */
                const ff_param *p = m.shape[l.free.shape[q]].info;
                double *v = &b.s.shape[l.free.shape[q]];
                *v = ff_coordinate_value(p, ff_coordinate(p, *v) + 0.1 * (1 + q));
                if (l.free.tied[q]) v[1] = v[0];
            }
            check_gradient(&b, 0, 0, &t);
            objective_free(&b);
        }
    }
    report(&t, "the terms in the fit");
    printf("  %ld components, worst %.1e of the scale, %ld not resolved\n", t.checked, t.worst, t.unresolved);
}

/* J of the robust residuals sqrt(rho') r' [P][n_channels n] by differences with what they may be off by, and sqrt(rho') r into rr.
 */
static void numeric_jacobian(const objective *b, const double *at, double *J, double *error, double *rr)
{
    const size_t n = b->w.n * b->l.n_channels;
    double x[MAX_COORDINATES], *low = doubles(n), *high = doubles(n);
    model_ridders *r = malloc(2 * n * sizeof *r);
    if (!r) exit(1);
    memcpy(x, at, b->l.P * sizeof *x);
    residuals(b, x, rr);
    for (size_t k = 0; k < b->l.P; k++) {
        for (size_t i = 0; i < 2 * n; i++) model_ridders_start(&r[i]);
        for (int series = 0; series < 2; series++) { /* where a long step passes an edge of the model, a short one does not */
            double step = series ? 0.002 : 0.05;
            for (int level = 0; level < 16; level++, step /= MODEL_RATIO) {
                x[k] = at[k] + step;
                residuals(b, x, high);
                x[k] = at[k] - step;
                residuals(b, x, low);
                for (size_t i = 0; i < n; i++)
                    model_ridders_add(&r[(size_t)series * n + i], (high[i] - low[i]) / (2 * step), ROUNDING * fabs(high[i]) / step);
            }
        }
        x[k] = at[k];
        for (size_t i = 0; i < n; i++)
            if (!(r[i].error <= r[n + i].error)) r[i] = r[n + i];
        for (size_t i = 0; i < n; i++) {
            const double root = sqrt(loss_rho_slope(b->o.robust, rr[i] * rr[i], b->o.robust_scale));
            J[k * n + i] = r[i].value * root;
            error[k * n + i] = 10 * r[i].error * root;
        }
    }
    for (size_t i = 0; i < n; i++) rr[i] *= sqrt(loss_rho_slope(b->o.robust, rr[i] * rr[i], b->o.robust_scale));
    free(low);
    free(high);
    free(r);
}

/* The larger one, or NaN where one of them is. */
static double worse(double a, double b)
{
    return isnan(a) || isnan(b) ? NAN : fmax(a, b);
}

/* How far a difference is beyond what the numbers that it is of may be off by. */
static double beyond(double difference, double off)
{
    return isnan(difference) || isnan(off) ? NAN : fmax(fabs(difference) - off, 0);
}

/* J^T J, J^T r and the outer products of the samples' scores of a final pass against products of numeric residuals and Jacobian.
 * Returns the largest deviation in units of the scales. */
static double normal_deviation(const objective *b, const double *x)
{
    const size_t P = b->l.P, n = b->w.n, N = n * b->l.n_channels;
    double slope[MAX_COORDINATES], g[MAX_COORDINATES], H[MAX_COORDINATES * MAX_COORDINATES], worst = 0;
    double *J = doubles(P * N), *error = doubles(P * N), *r = doubles(N), *score = doubles(P * n), norm2 = 0;
    numeric_jacobian(b, x, J, error, r);
    slopes(b, x, slope);
    assemble(&b->l, &b->normal, slope, H, g);
    for (size_t i = 0; i < N; i++) norm2 += r[i] * r[i];
    for (size_t k = 0; k < P; k++)
        for (size_t i = 0; i < N; i++) score[k * n + i % n] += J[k * N + i] * r[i];
    for (size_t k = 0; k < P; k++) {
        double gradient = 0, own = 0, off = 0;
        for (size_t i = 0; i < N; i++) {
            gradient += J[k * N + i] * r[i];
            own += J[k * N + i] * J[k * N + i];
            off += error[k * N + i] * fabs(r[i]);
        }
        worst = worse(worst, beyond(gradient - g[k], off) / sqrt(own * norm2));
        for (size_t q = 0; q <= k; q++) {
            double h = 0, h_off = 0, score_products = 0, products_off = 0, hk = 0, hq = 0, sk = 0, sq = 0;
            for (size_t i = 0; i < N; i++) {
                const double both = error[k * N + i] * fabs(J[q * N + i]) + error[q * N + i] * fabs(J[k * N + i]);
                h += J[k * N + i] * J[q * N + i];
                h_off += both;
                hk += J[k * N + i] * J[k * N + i], hq += J[q * N + i] * J[q * N + i];
            }
            for (size_t i = 0; i < N; i++)
                products_off +=
                    fabs(r[i]) * (error[k * N + i] * fabs(score[q * n + i % n]) + error[q * N + i] * fabs(score[k * n + i % n]));
            for (size_t i = 0; i < n; i++) {
                score_products += score[k * n + i] * score[q * n + i];
                sk += score[k * n + i] * score[k * n + i], sq += score[q * n + i] * score[q * n + i];
            }
            worst = worse(worst, beyond(h - H[k * P + q], h_off) / sqrt(hk * hq));
            worst = worse(worst, beyond(h - H[q * P + k], h_off) / sqrt(hk * hq));
            const double products = b->normal.score_products[ff_tri(k, q)] * slope[k] * slope[q];
            worst = worse(worst, beyond(score_products - products, products_off) / sqrt(sk * sq));
        }
    }
    free(J);
    free(error);
    free(r);
    free(score);
    return worst;
}

static void normal_equations(void)
{
    double worst = 0;
    for (size_t k = 0; k < SETTINGS; k++)
        for (int loss = 0; loss < FF_LOSS_COUNT; loss++)
            for (int robust = 0; robust < FF_ROBUST_COUNT; robust++) {
                objective b;
                double x[MAX_COORDINATES];
                objective_make(&settings[k], 2, 30, (ff_loss)loss, (ff_robust)robust, weightings[(k + (size_t)loss) % 3], &b);
                coordinates(&b, x);
                if (robust) choose_scale(&b, x);
                pass_at(&b, x, 1);
                check_cost(&b, x);
                const double deviation = normal_deviation(&b, x);
                FF_CHECK(deviation <= TOLERANCE, "%s: deviates by %.2g of the scale", b.label, deviation);
                worst = fmax(worst, deviation);
                /* a wrong one is caught: one entry of the gram, one of the scores' products */
                const double gram = b.normal.gram[0], score_products = b.normal.score_products[0];
                b.normal.gram[0] *= 1 + 1e-6;
                FF_CHECK(!(normal_deviation(&b, x) <= TOLERANCE), "%s: a wrong J^T J was not seen", b.label);
                b.normal.gram[0] = gram;
                b.normal.score_products[0] = score_products * (1 + 1e-6);
                FF_CHECK(!(normal_deviation(&b, x) <= TOLERANCE), "%s: wrong products of scores were not seen", b.label);
                objective_free(&b);
            }
    printf("  worst %.1e of the scale\n", worst);
}

static void wrong_gradients_are_caught(void)
{
    for (size_t k = 0; k < SETTINGS; k++)
        for (int robust = 0; robust < FF_ROBUST_COUNT; robust++) {
            objective b;
            objective_make(&settings[k], 3, 300, FF_LOSS_LOG, (ff_robust)robust, FF_WEIGHT_SAMPLE, &b);
            for (size_t which = 0; which < b.l.P; which++) {
                tally t = {0};
                check_gradient(&b, 3e-8, which, &t);
                FF_CHECK(t.wrong == 1, "%s: a gradient wrong by 3e-8 of its scale in %s was not seen", b.label,
                         coordinate_name(&b, which));
            }
            objective_free(&b);
        }
}

FF_TEST_MAIN(FF_TEST(the_referee_is_right), FF_TEST(lobes_are_not_leapt_over), FF_TEST(noise_is_not_resolved),
             FF_TEST(every_combination), FF_TEST(wide_boxes), FF_TEST(whole_numbers), FF_TEST(several_lobes),
             FF_TEST(shared_and_coupled), FF_TEST(wrong_derivatives_are_caught), FF_TEST(every_objective), FF_TEST(dark_data),
             FF_TEST(every_term_in_the_fit), FF_TEST(normal_equations), FF_TEST(wrong_gradients_are_caught))
