/* Fits to values that are means over an aperture: those of an independent program, and what is asked of a fit afterwards. */
#include "fit_samples.h"
#include "fit/trust/trust_struct.h"
#include "fit/problem/internal_problem.h"

typedef struct fitted {
    ff_table t;
    ff_problem *p;
    ff_fit_options o;
    ff_fit_result fit;
} fitted;

static void fit_to(const ff_model *m, const ff_aperture *a, fitted *f)
{
    ff_error err = {0};
    f->o = fit_options();
    f->o.aperture = a;
    if (ff_problem_make(&f->t, m, 1, &f->o, &f->p, &err) || ff_problem_fit_into(f->p, m, &f->o, &f->fit, &err)) {
        printf("the fit failed: %s\n", err.message);
        exit(1);
    }
}

static void release(fitted *f)
{
    ff_fit_result_clear(&f->fit);
    ff_problem_free(f->p);
    ff_table_clear(&f->t);
}

static double distance(const fitted *f, const char *name, double truth)
{
    const ff_fit_value *v = ff_fit_result_find(&f->fit, name, 0);
    return fabs(v->value - truth) / v->std_error;
}

/* alpha .02, F0 .5, kd .05 through a disc of .75 degrees. As points they are something else. */
static void of_another_program(void)
{
    const fit_surface s = fit_surface_make("ggx+lambert", 1, "");
    const ff_aperture disc = {.outline = FF_APERTURE_DISC, .half = 0.75 * FIT_DEGREE};
    fitted f;
    if (!FF_CHECK(ff_table_read_into(FF_TESTS "/aper02.csv", NULL, &f.t, NULL) == FF_OK, "aper02.csv is not there")) return;
    fit_to(&s.model, &disc, &f);
    FF_CHECK(f.fit.outcome == FF_CONVERGED, "outcome %d", (int)f.fit.outcome);
    FF_CHECK(distance(&f, "alpha_x", 0.02) < 3, "alpha is %g errors off", distance(&f, "alpha_x", 0.02));
    FF_CHECK(distance(&f, "f0", 0.5) < 3, "f0 is %g errors off", distance(&f, "f0", 0.5));
    FF_CHECK(distance(&f, "kd", 0.05) < 3, "kd is %g errors off", distance(&f, "kd", 0.05));
    FF_CHECK_CLOSE(ff_fit_result_find(&f.fit, "alpha_x", 0)->value, 0.02, 1e-4, 0);
    release(&f);
    if (!FF_CHECK(ff_table_read_into(FF_TESTS "/aper02.csv", NULL, &f.t, NULL) == FF_OK, "aper02.csv is not there")) return;
    fit_to(&s.model, NULL, &f);
    FF_CHECK(ff_fit_result_find(&f.fit, "alpha_x", 0)->value > 0.021, "alpha %g of points",
             ff_fit_result_find(&f.fit, "alpha_x", 0)->value);
    release(&f);
}

/* Noise of 1 % on scattered samples, most about the mirror direction, as an aperture sees them. */
static ff_table measure(const fit_surface *s, const ff_aperture *a, size_t n)
{
    const fit_sampling how = {.n = n, .max_theta = 70, .glossy = 0.8, .seed = 5};
    ff_table t = fit_measure(s, &how);
    double *w = malloc(6 * n * sizeof *w), *planes[6];
    uint64_t state = ff_test_seeded(77);
    if (!w) exit(1);
    for (size_t k = 0; k < 6; k++) planes[k] = w + k * n;
    ff_table_directions(&t, 0, n, planes);
    const ff_dirs dirs = {planes[0], planes[1], planes[2], planes[3], planes[4], planes[5]};
    if (ff_aperture_eval(a, &s->model, FF_ISA_BEST, s->n_channels, s->shape, s->channel, &dirs, n, t.value, NULL, NULL, n)) exit(1);
    for (size_t k = 0; k < n * s->n_channels; k++) t.value[k] *= 1 + 0.01 * fit_normal(&state);
    free(w);
    return t;
}

/* The values of a finished fit are the means of its model, to what fits take for one; and profiles, leaving out an incidence and
 * residuals know them. */
static void afterwards(void)
{
    const fit_surface s = fit_surface_make("ggx+lambert", 2, "alpha=0.02 f0=0.5 kd=0.05");
    const ff_aperture a = {FF_APERTURE_RECTANGLE, 0.8 * FIT_DEGREE, 0.5 * FIT_DEGREE, 0.3 * FIT_DEGREE};
    enum { N = 240 };
    fitted f = {.t = measure(&s, &a, N)};
    double *values = malloc(2 * 2 * N * sizeof *values), *w = malloc(6 * N * sizeof *w), *planes[6], shape[FF_MAX_SHAPE],
           channel[2 * FF_MAX_CHANNEL_PARAMS];
    if (!values || !w) exit(1);
    fit_to(&s.model, &a, &f);
    FF_CHECK(distance(&f, "alpha_x", 0.02) < 4, "alpha is %g errors off", distance(&f, "alpha_x", 0.02));
    FF_CHECK(!ff_trust_evaluate(f.p, &f.o, &f.fit, values, NULL, NULL, NULL), "evaluation");
    for (size_t k = 0; k < 6; k++) planes[k] = w + k * N;
    ff_fit_result_values(&f.fit, shape, channel);
    const size_t used = ff_problem_selected(f.p)->used;
    ff_table_directions(&f.t, 0, N, planes);
    const ff_dirs dirs = {planes[0], planes[1], planes[2], planes[3], planes[4], planes[5]};
    double *exact = values + 2 * N;
    FF_CHECK(!ff_aperture_eval(&a, &f.fit.model, FF_ISA_BEST, 2, shape, channel, &dirs, N, exact, NULL, NULL, N), "aperture");
    for (size_t i = 0; i < used; i++)
        for (size_t c = 0; c < 2; c++) FF_CHECK_CLOSE(values[c * used + i], exact[c * N + f.p->index[i]], FF_APERTURE_OF_FITS, 0);
    const double before = ff_fit_result_find(&f.fit, "alpha_x", 0)->high;
    FF_CHECK(!ff_trust_profile(f.p, &f.o, &f.fit, NULL), "profile");
    const ff_fit_value *v = ff_fit_result_find(&f.fit, "alpha_x", 0);
    FF_CHECK(v->interval == FF_INTERVAL_PROFILE && v->low < v->value && v->high > v->value, "a profile from %g to %g", v->low,
             v->high);
    FF_CHECK_CLOSE(v->high - v->value, before - v->value, 0.5, 0);
    free(values);
    free(w);
    release(&f);
}

/* A source widens a lobe as an aperture does, and is told from it by nobody: with it left out alpha is too large, with it right. */
static void source(void)
{
    const fit_surface s = fit_surface_make("beckmann+lambert", 1, "alpha=0.02 f0=0.5 kd=0.05");
    const ff_aperture a = {.outline = FF_APERTURE_DISC, .half = 0.3 * FIT_DEGREE, .source = 0.9 * FIT_DEGREE},
                      without = {.outline = FF_APERTURE_DISC, .half = 0.3 * FIT_DEGREE};
    fitted f = {.t = measure(&s, &a, 300)}, g = {.t = measure(&s, &a, 300)};
    fit_to(&s.model, &a, &f);
    fit_to(&s.model, &without, &g);
    FF_CHECK(distance(&f, "alpha_x", 0.02) < 4, "alpha is %g errors off", distance(&f, "alpha_x", 0.02));
    FF_CHECK(ff_fit_result_find(&g.fit, "alpha_x", 0)->value > 0.0203, "alpha %g without",
             ff_fit_result_find(&g.fit, "alpha_x", 0)->value);
    release(&f);
    release(&g);
}

/* What is no aperture is refused; a point is none. */
static void refusals(void)
{
    const fit_surface s = fit_surface_make("ggx", 1, "");
    const ff_aperture wrong[] = {{.half = -1},
                                 {.half = 0.6},
                                 {.half = NAN},
                                 {.source = 0.6},
                                 {FF_APERTURE_RECTANGLE, 0.1, -1, 0},
                                 {.outline = (ff_aperture_outline)2}};
    const ff_aperture point = {.outline = FF_APERTURE_DISC};
    ff_table t = measure(&s, &point, 200);
    ff_fit_options o = fit_options();
    ff_error err = {0};
    ff_problem *p = NULL;
    for (size_t k = 0; k < sizeof wrong / sizeof *wrong; k++) {
        o.aperture = &wrong[k];
        FF_CHECK(ff_problem_make(&t, &s.model, 1, &o, &p, &err) == FF_ERR_RANGE && !p, "aperture %zu: %s", k, err.message);
    }
    o.aperture = &point;
    FF_CHECK(!ff_problem_make(&t, &s.model, 1, &o, &p, &err) && !p->rules, "a point");
    ff_problem_free(p);
    ff_table_clear(&t);
}

/* Words, there and back. */
static void words(void)
{
    static const char *const text[] = {"0.75", "0.75:square", "0.5x1", "3", "12.5"};
    static const char *const wrong[] = {"", "x", "0.75:round", "1x", "1x2x3", "-1", "29", "nan", "1:square:disc"};
    ff_aperture a = {.source = 0.1};
    char back[FF_APERTURE_TEXT];
    for (size_t k = 0; k < sizeof text / sizeof *text; k++) {
        FF_CHECK(!ff_aperture_parse(text[k], &a) && a.source == 0.1, "%s", text[k]);
        FF_CHECK(!strcmp(ff_aperture_text(&a, back), text[k]), "%s came back as %s", text[k], back);
    }
    for (size_t k = 0; k < sizeof wrong / sizeof *wrong; k++) FF_CHECK(ff_aperture_parse(wrong[k], &a), "%s", wrong[k]);
}

FF_TEST_MAIN(FF_TEST(of_another_program), FF_TEST(afterwards), FF_TEST(source), FF_TEST(refusals), FF_TEST(words))
