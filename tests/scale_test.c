/* Data of any magnitude: raw counts, scattered light of a millionth of a reflectance. Where the model is linear in a scale, a
 * factor on the data is one on that scale and on its error, and changes nothing else: what "near a bound" or "small" means is
 * measured by the data. */
#include "fit_samples.h"

/* ---- one fit --------------------------------------------------------------------------------- */

static ff_fit_result fitted(const char *what, const ff_table *t, const ff_model *m, const ff_fit_options *o)
{
    ff_fit_result r = {0};
    ff_error err = {0};
    const ff_status status = fit_table(t, m, o, &r, NULL, &err);
    FF_CHECK(status == FF_OK, "%s: %s", what, err.message);
    if (status) exit(1);
    FF_CHECK(r.outcome == FF_CONVERGED, "%s: %s", what, ff_outcome_name((int)r.outcome));
    return r;
}

static void multiply(ff_table *t, double factor)
{
    for (size_t i = 0; i < t->n * t->n_channels; i++) t->value[i] *= factor;
}

/* Equal to a hundredth of the standard error, with the same error and on the same side of the same bound. */
static void check_scaled(const char *what, const char *name, const ff_fit_value *v, double unit, const ff_fit_value *plain)
{
    const double sd = plain->std_error;
    FF_CHECK(v->at_bound == plain->at_bound, "%s: %s is %g, bound %d instead of %d", what, name, v->value, v->at_bound,
             plain->at_bound);
    FF_CHECK(isnan(sd) == isnan(v->std_error), "%s: %s has the error %g instead of %g", what, name, v->std_error, sd * unit);
    if (isnan(sd) || isnan(v->std_error)) return;
    FF_CHECK(fabs(v->value / unit - plain->value) <= 0.01 * sd, "%s: %s is %.12g instead of %.12g, error %g", what, name,
             v->value / unit, plain->value, sd);
    FF_CHECK_CLOSE(v->std_error / unit, sd, 1e-3, 0);
    FF_CHECK(fabs(v->low / unit - plain->low) <= 0.02 * (plain->high - plain->low), "%s: %s from %g instead of %g", what, name,
             v->low / unit, plain->low);
}

/* Is parameter k multiplied when the data are? */
static int has_their_unit(const ff_model *m, size_t k)
{
    const size_t i = k - m->n_shape;
    if (k < m->n_shape) return 0;
    const char *name = m->channel[i % m->n_channel].info->name;
    return strcmp(name, "ks") == 0 || strcmp(name, "kd") == 0;
}

static void check_same(const char *what, const ff_fit_result *r, double unit, const ff_fit_result *plain)
{
    char name[64];
    double truth;
    for (size_t k = 0; k < fit_parameter_count(r); k++) {
        const ff_fit_value *v = fit_parameter(r, k, NULL, &truth, name), *p = fit_parameter(plain, k, NULL, &truth, name);
        if (v) check_scaled(what, name, v, has_their_unit(&r->model, k) ? unit : 1, p);
    }
}

/* ---- ten samples of a dark surface ----------------------------------------------------------- */

static ff_table ten_samples(void)
{
    static const double f[10] = {3.34e-6, 5.82e-6, 1.092e-5, 2.005e-5, 3.243e-5, 3.957e-5, 3.572e-5, 2.447e-5, 1.501e-5, 9.25e-6};
    ff_table t;
    if (ff_table_init(10, 1, NULL, 0, 0, &t, NULL)) exit(1);
    t.radians_per_unit = FIT_DEGREE;
    for (size_t i = 0; i < 10; i++) {
        const double a[4] = {45, 0, 20 + 5 * (double)i, 180};
        for (int k = 0; k < 4; k++) t.angle[k][i] = a[k];
        t.value[i] = f[i];
        t.valid[i] = 1;
    }
    return t;
}

static void dark_surface(void)
{
    static const double scales[] = {1, 1e-12, 1e-9, 1e-4, 1e4, 1e9, 1e12};
    const fit_surface s = fit_surface_make("ggx/smith-height-correlated/none", 1, "");
    ff_model m = s.model;
    ff_fit_options o = fit_options();
    double by_noise[2] = {0};
    ff_model_vary(&m, "ks", NULL);
    o.shape = FF_SHAPE_ISOTROPIC;
    for (size_t i = 0; i < sizeof scales / sizeof *scales; i++) {
        ff_table t = ten_samples();
        multiply(&t, scales[i]);
        o.errors = FF_ERRORS_NOISE;
        ff_fit_result n = fitted("ten samples", &t, &m, &o);
        const double now[2] = {n.shape_value[0].std_error, n.channel_value[0].std_error / scales[i]};
        for (int k = 0; k < 2 && i == 0; k++) by_noise[k] = now[k];
        for (int k = 0; k < 2; k++) FF_CHECK_CLOSE(now[k], by_noise[k], 1e-3, 0);
        FF_CHECK(now[0] > 0.0025 && now[0] < 0.006, "x %g: alpha +- %g", scales[i], now[0]);
        ff_fit_result_clear(&n);
        o.errors = FF_ERRORS_RESIDUALS;
        ff_fit_result r = fitted("ten samples", &t, &m, &o);
        const ff_fit_value *alpha = &r.shape_value[0], *ks = &r.channel_value[0];
        FF_CHECK_CLOSE(alpha->value, 0.1390, 0, 5e-5);
        FF_CHECK_CLOSE(alpha->std_error, 0.0036, 0, 5e-5);
        FF_CHECK(ks->at_bound == 0, "x %g: ks = %g is on its bound", scales[i], ks->value);
        FF_CHECK_CLOSE(ks->value / scales[i], 4.91e-6, 0, 5e-9);
        FF_CHECK_CLOSE(ks->std_error / scales[i], 2.3e-7, 0, 5e-9);
        ff_fit_result_clear(&r);
        ff_table_clear(&t);
    }
}

/* ---- factors --------------------------------------------------------------------------------- */

/* A set of data and what is fitted to it. */
typedef struct scale_case {
    const char *what, *truth, *set, *model, *free, *tie;
    size_t n_channels;
    ff_loss loss;
    ff_robust robust;
    const char *from; /* where the fit starts, NULL: where a search says */
} scale_case;

#define NONE      "ggx/smith-height-correlated/none"
#define LOBE      "ggx/smith-height-correlated/"
#define FEW       "0.2:0.1:0.4"
#define MANY      "0.2:0.1:0.4:0.3:0.15:0.25:0.35:0.45:0.12:0.22:0.32:0.5"
#define MANY_DARK "0.03:0.01:0.02:0.03:0.015:0.025:0.035:0.045:0.012:0.022:0.032:0.05"

/* Their scales up to 1e-3 of these are inside every box; where kd is not fitted, so are those above. */
static const scale_case cases[] = {
    {"a lobe", NONE, "alpha=0.3 ks=0.2", NONE, "ks", NULL, 1, 0, 0, NULL},
    {"an ellipse", NONE, "alpha_x=0.2 alpha_y=0.3 r_xy=0.3 ks=0.2", NONE, "ks", NULL, 1, 0, 0, NULL},
    {"two lobes", NONE "+" NONE, "alpha=0.1 lobe2.alpha=0.5 ks=0.1 lobe2.ks=0.5", NONE "+" NONE, "ks lobe2.ks", NULL, 1, 0, 0,
     NULL},
    {"with a base", NONE "+lambert", "alpha=0.3 ks=" FEW " kd=0.1", NONE "+lambert", "ks", NULL, 3, 0, 0, NULL},
    {"a base alone", "lambert", "kd=" FEW, "lambert", "", NULL, 3, 0, 0, NULL},
    {"a base that wants to be negative", NONE, "alpha=0.3 ks=0.2", "ggx/smith-separable/none+lambert", "ks", NULL, 1, 0, 0, NULL},
    {"many channels", NONE "+lambert", "alpha=0.3 ks=" MANY " kd=" MANY_DARK, NONE "+lambert", "ks", NULL, 12, 0, 0, NULL},
    {"many channels without a base", NONE, "alpha=0.3 ks=" MANY, "ggx/smith-separable/none+lambert", "ks", NULL, 12, 0, 0, NULL},
    {"many channels and F0", LOBE "schlick", "alpha=0.3 f0=0.1 ks=" MANY, LOBE "schlick", "ks", NULL, 12, 0, 0, NULL},
    {"one scale for all", NONE, "alpha=0.3 ks=0.2", NONE, "ks", "ks", 3, 0, 0, NULL},
    {"one base for all", NONE "+lambert", "alpha=0.3 ks=" FEW " kd=0.1", NONE "+lambert", "ks", "kd", 3, 0, 0, NULL},
    {"Schlick", LOBE "schlick", "alpha=0.3 f0=0.1 ks=0.7", LOBE "schlick", "ks", NULL, 1, 0, 0, NULL},
    {"a dielectric", LOBE "dielectric", "alpha=0.3 eta=1.5 ks=0.7", LOBE "dielectric", "ks", NULL, 1, 0, 0, NULL},
    {"many channels of a dielectric", LOBE "dielectric", "alpha=0.3 eta=1.5 ks=" MANY, LOBE "dielectric", "ks", NULL, 12, 0, 0,
     NULL},
    {"a Fresnel term of two lobes", LOBE "dielectric+" LOBE "shared", "alpha=0.1 lobe2.alpha=0.5 eta=1.5 ks=0.7 lobe2.weight=0.4",
     LOBE "dielectric+" LOBE "shared", "ks", NULL, 1, 0, 0, NULL},
    {"by relative differences", NONE, "alpha=0.3 ks=" FEW, NONE, "ks", NULL, 3, FF_LOSS_RELATIVE, 0, NULL},
    {"robust", NONE "+lambert", "alpha=0.3 ks=0.2 kd=0.1", NONE "+lambert", "ks", NULL, 1, 0, FF_ROBUST_TUKEY, NULL},
    {"from afar", LOBE "schlick", "alpha=0.3 f0=0.1 ks=" FEW, LOBE "schlick", "ks", NULL, 3, 0, 0, "alpha=0.9 f0=0.6 ks=3"},
    {"many channels from afar", LOBE "schlick", "alpha=0.3 f0=0.1 ks=" MANY, LOBE "schlick", "ks", NULL, 12, 0, 0,
     "alpha=0.9 f0=0.6 ks=3"},
    {"many channels of a dielectric from afar", LOBE "dielectric", "alpha=0.3 eta=1.5 ks=" MANY, LOBE "dielectric", "ks", NULL, 12,
     0, 0, "alpha=0.9 eta=1.2 ks=3"},
};

static void check_case(const scale_case *k)
{
    static const double scales[] = {1e-12, 1e-9, 1e-6, 1e-3, 1e6, 1e12};
    const fit_surface s = fit_surface_make(k->truth, k->n_channels, k->set);
    const fit_sampling how = {.n = 1200, .max_theta = 75, .glossy = 0.5, .noise = 0.03, .seed = 5};
    ff_model m;
    char words[64], *save = NULL, what[160];
    ff_fit_options o = fit_options();
    const ff_tie tie = {k->tie, NULL};
    const ff_constraints constraints = {.n_ties = k->tie != NULL, .tie = &tie};
    if (ff_model_parse(k->model, &m, NULL)) exit(1);
    snprintf(words, sizeof words, "%s", k->free);
    for (char *word = strtok_r(words, " ", &save); word; word = strtok_r(NULL, " ", &save)) ff_model_vary(&m, word, NULL);
    o.shape = strstr(k->set, "r_xy") ? FF_SHAPE_CORRELATED : FF_SHAPE_ISOTROPIC;
    o.loss = k->loss;
    o.robust = k->robust;
    o.constraints = &constraints;
    fit_surface from = fit_surface_make(k->model, k->n_channels, k->from ? k->from : "");
    if (k->from) o.start_shape = from.shape, o.start_channel = from.channel;
    ff_table t = fit_measure(&s, &how);
    ff_fit_result plain = fitted(k->what, &t, &m, &o);
    for (size_t i = 0; i < sizeof scales / sizeof *scales; i++) {
        if (scales[i] > 1 && ff_model_param_find(&m, "kd").kind != FF_PARAM_NONE) continue;
        ff_table scaled = fit_measure(&s, &how);
        multiply(&scaled, scales[i]);
        from = fit_surface_make(k->model, k->n_channels, k->from ? k->from : "");
        for (size_t j = 0; j < k->n_channels * m.n_channel; j++)
            if (has_their_unit(&m, m.n_shape + j)) from.channel[j] *= scales[i];
        snprintf(what, sizeof what, "%s x %g", k->what, scales[i]);
        ff_fit_result r = fitted(what, &scaled, &m, &o);
        check_same(what, &r, scales[i], &plain);
        FF_CHECK(!k->from || abs(r.iterations - plain.iterations) <= 2, "%s: %d iterations instead of %d", what, r.iterations,
                 plain.iterations);
        ff_fit_result_clear(&r);
        ff_table_clear(&scaled);
    }
    ff_fit_result_clear(&plain);
    ff_table_clear(&t);
}

static void factors(void)
{
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) check_case(&cases[i]);
}

/* ---- priors and bounds ----------------------------------------------------------------------- */

/* What is said of a scale besides the data goes with it. */
static void known_besides(void)
{
    static const double scales[] = {1, 1e-6, 1e-12};
    const fit_surface s = fit_surface_make(NONE "+lambert", 1, "alpha=0.3 ks=0.2 kd=0.1");
    const fit_sampling how = {.n = 1200, .max_theta = 75, .glossy = 0.5, .noise = 0.03, .seed = 6};
    ff_model m = s.model;
    ff_fit_options o = fit_options();
    ff_fit_result plain[3];
    ff_model_vary(&m, "ks", NULL);
    o.shape = FF_SHAPE_ISOTROPIC;
    for (int kind = 0; kind < 3; kind++) /* a prior, a lower and an upper bound that bind */
        for (size_t i = 0; i < sizeof scales / sizeof *scales; i++) {
            const ff_prior prior = {"kd", 0.12 * scales[i], 0.001 * scales[i], NULL};
            const ff_bound bound = kind == 1 ? (ff_bound){"kd", 0.11 * scales[i], 0.2 * scales[i], NULL}
                                             : (ff_bound){"ks", 0.01 * scales[i], 0.19 * scales[i], NULL};
            const ff_constraints c = {.n_priors = kind == 0, .prior = &prior, .n_bounds = kind > 0, .bound = &bound};
            o.constraints = &c;
            ff_table t = fit_measure(&s, &how);
            multiply(&t, scales[i]);
            ff_fit_result r = fitted("known besides the data", &t, &m, &o);
            if (i == 0) plain[kind] = r;
            check_same("known besides the data", &r, scales[i], &plain[kind]);
            if (kind) FF_CHECK(r.channel_value[kind == 1].at_bound == (kind == 1 ? -1 : 1), "the bound does not bind");
            if (i) ff_fit_result_clear(&r);
            ff_table_clear(&t);
        }
    for (int kind = 0; kind < 3; kind++) ff_fit_result_clear(&plain[kind]);
}

/* ---- dim reflectances ------------------------------------------------------------------------ */

/* F0 has a scale of its own in Schlick's term, whose edge at grazing angles is always 1: near the normal a small F0 is found. */
static void dim_reflectance(void)
{
    static const char *const sets[] = {"alpha=0.1 f0=1e-6 kd=1e-6", "alpha=0.1 f0=1e-11 kd=1e-11"};
    for (size_t i = 0; i < 2; i++) {
        const fit_surface s = fit_surface_make("ggx+lambert", 1, sets[i]);
        const fit_sampling how = {.n = 3000, .max_theta = i ? 3 : 10, .noise = 0.001, .seed = 7};
        ff_table t = fit_measure(&s, &how);
        ff_fit_options o = fit_options();
        o.shape = FF_SHAPE_ISOTROPIC;
        ff_fit_result r = fitted(sets[i], &t, &s.model, &o);
        for (int k = 0; k < 2; k++) {
            const ff_fit_value *v = &r.channel_value[k == 0 ? 0 : r.model.n_channel - 1];
            FF_CHECK(v->at_bound == 0 && fabs(v->value - s.channel[0]) < 5 * v->std_error, "%s: %g +- %g, bound %d", sets[i],
                     v->value, v->std_error, v->at_bound);
        }
        ff_fit_result_clear(&r);
        ff_table_clear(&t);
    }
}

/* A channel that is dark beside the others has the scale of its own data. */
static void dark_channel(void)
{
    static const char *const sets[] = {"alpha=0.3 ks=1:1e-9 kd=0.1:1e-11", "alpha=0.3 kd=0.1:1e-11:0.1:0.2:0.1:0.2:0.1:0.2:0.1:0.2"
                                                                           " ks=1:1e-9:1:1:1:1:1:1:1:1"};
    for (size_t i = 0; i < 2; i++) {
        const fit_surface s = fit_surface_make(NONE "+lambert", i ? 10 : 2, sets[i]);
        const fit_sampling how = {.n = 3000, .max_theta = 75, .glossy = 0.5, .noise = 0.01, .seed = 8};
        ff_table t = fit_measure(&s, &how);
        ff_model m = s.model;
        ff_fit_options o = fit_options();
        ff_model_vary(&m, "ks", NULL);
        o.shape = FF_SHAPE_ISOTROPIC;
        ff_fit_result r = fitted(sets[i], &t, &m, &o);
        for (size_t k = 2; k < 4; k++) {
            const ff_fit_value *v = &r.channel_value[k];
            FF_CHECK(v->at_bound == 0 && fabs(v->value - s.channel[k]) < 5 * v->std_error, "%s: %g +- %g, bound %d", sets[i],
                     v->value, v->std_error, v->at_bound);
        }
        ff_fit_result_clear(&r);
        ff_table_clear(&t);
    }
}

/* ---- true bounds ----------------------------------------------------------------------------- */

/* Values x factor of a surface, and a model that wants parameter `at` of every channel below 0, alpha held. */
static void check_on_bound(const char *truth, const char *set, const char *model, const char *scale, size_t n_channels,
                           double factor, uint32_t at)
{
    const fit_surface s = fit_surface_make(truth, n_channels, set);
    const fit_sampling how = {.n = 1200, .max_theta = 75, .glossy = 0.5, .noise = 0.01, .seed = 9};
    ff_table t = fit_measure(&s, &how);
    ff_model m;
    ff_fit_options o = fit_options();
    if (ff_model_parse(model, &m, NULL) || ff_model_hold(&m, "alpha", 0.3, NULL)) exit(1);
    if (scale) ff_model_vary(&m, scale, NULL);
    o.shape = FF_SHAPE_ISOTROPIC;
    multiply(&t, factor);
    ff_fit_result r = fitted(model, &t, &m, &o);
    for (size_t k = 0; k < n_channels * m.n_channel; k++) {
        const ff_fit_value *v = &r.channel_value[k];
        if (v->held || (scale == NULL && k % m.n_channel != at)) continue;
        const int wanted = k % m.n_channel == at ? -1 : 0;
        FF_CHECK(v->at_bound == wanted && isnan(v->std_error) == (wanted != 0), "%s x %g: %s = %g, bound %d", model, factor,
                 m.channel[k % m.n_channel].name, v->value, v->at_bound);
        if (wanted) FF_CHECK(v->value == 0 && v->low == 0 && v->high > 0, "%g, from %g to %g", v->value, v->low, v->high);
    }
    ff_fit_result_clear(&r);
    ff_table_clear(&t);
}

/* 0 where the data want less: on the bound at any scale, with few channels or many; what is not 0 is not. */
static void true_bounds(void)
{
    static const double scales[] = {1, 1e-6, 1e-12};
    for (size_t channels = 1; channels <= 12; channels += 11)
        for (size_t i = 0; i < sizeof scales / sizeof *scales; i++) {
            check_on_bound(NONE, "alpha=0.3 ks=0.2", "ggx/smith-separable/none+lambert", "ks", channels, scales[i], 1);
            check_on_bound("lambert", "kd=0.2", "ggx+lambert", NULL, channels, scales[i],
                           0); /* the lobe has an edge, they have none */
        }
}

FF_TEST_MAIN(FF_TEST(dark_surface), FF_TEST(factors), FF_TEST(known_besides), FF_TEST(dim_reflectance), FF_TEST(dark_channel),
             FF_TEST(true_bounds))
