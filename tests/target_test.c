/* Renderers as targets: every material makes its model, its controls go there and back, their derivatives are those of differences,
 * and data simulated from them give the controls back within their errors. */
#include "fit/controls/internal_controls.h"
#include "model_samples.h"
#include "pass_of.h"

enum { CHANNELS = 3, DRAWN = 20 };

/* Calls `look` for every material. */
static void each_material(void (*look)(const ff_target *, const ff_material *, const ff_model *))
{
    for (size_t i = 0; i < ff_target_count(); i++) {
        const ff_target *t = ff_target_at(i);
        for (size_t k = 0; k < t->n_materials; k++) {
            ff_model m;
            ff_error err = {0};
            if (FF_CHECK(ff_material_model(&t->material[k], &m, &err) == FF_OK, "%s: %s", t->name, err.message))
                look(t, &t->material[k], &m);
        }
    }
}

/* ---- the registry ---------------------------------------------------------------------------- */

static void look_at_names(const ff_target *t, const ff_material *m, const ff_model *model)
{
    FF_CHECK(ff_material_find(t, m->name, strlen(m->name)) == m, "%s:%s", t->name, m->name);
    double shape[FF_MAX_SHAPE], channel[CHANNELS * FF_MAX_CHANNEL_PARAMS];
    ff_model_defaults(model, CHANNELS, shape, channel);
    for (uint32_t k = 1; k < model->n_shape; k++)
        if (model->shape[k].flags & FF_PARAM_SHARED) shape[k] = shape[k - 1];
    FF_CHECK(ff_material_of_model(t, model, CHANNELS, shape, channel) == m, "%s:%s: its model is another material's", t->name,
             m->name);
    for (uint32_t k = 0; k < model->n_channel; k++) {
        const double kept = channel[k];
        channel[k] *= 0.75;
        const int fixed = (model->channel[k].flags & (FF_PARAM_HELD | FF_PARAM_SHARED)) != 0;
        FF_CHECK((ff_material_of_model(t, model, CHANNELS, shape, channel) == m) == !fixed, "%s:%s with another %s in one channel",
                 t->name, m->name, model->channel[k].name);
        channel[k] = kept;
    }
    FF_CHECK(ff_control_count(m) >= 2, "%s:%s has %zu controls", t->name, m->name, ff_control_count(m));
    for (size_t k = 0; k < ff_control_count(m); k++) {
        const ff_control *c = &m->control[k];
        FF_CHECK(c->lo < c->hi && c->unit, "%s:%s: the range of %s", t->name, m->name, c->made.name);
        for (size_t i = 0; i < FF_FORMULA_INPUTS && c->made.of[i]; i++)
            FF_CHECK(ff_model_param_find(model, c->made.of[i]).kind != FF_PARAM_NONE, "%s:%s: %s is made of %s, which is none",
                     t->name, m->name, c->made.name, c->made.of[i]);
    }
    for (size_t k = 0; k < FF_TARGET_PARAMETERS && m->parameter[k].name; k++)
        FF_CHECK(ff_model_param_find(model, m->parameter[k].name).kind != FF_PARAM_NONE, "%s:%s: no parameter %s", t->name, m->name,
                 m->parameter[k].name);
}

static void names(void)
{
    for (size_t i = 0; i < ff_target_count(); i++) {
        const ff_target *t = ff_target_at(i);
        FF_CHECK(ff_target_find(t->name) == t, "%s", t->name);
        for (size_t k = 0; k < FF_TARGET_ALIASES && t->alias[k]; k++) FF_CHECK(ff_target_find(t->alias[k]) == t, "%s", t->alias[k]);
        FF_CHECK(t->title && t->version && t->source && t->lacks && t->n_materials, "%s is not described", t->name);
    }
    FF_CHECK(!ff_target_find("") && !ff_target_find("blende") && !ff_target_at(ff_target_count()),
             "something is found that is not there");
    each_material(look_at_names);
}

/* ---- there and back -------------------------------------------------------------------------- */

static double between(uint64_t *state, double lo, double hi)
{
    return lo + (hi - lo) * fit_uniform(state);
}

/* A value of a control that people set. */
static double drawn(const ff_control *k, uint64_t *state)
{
    static const struct {
        const char *name;
        double lo, hi;
    } own[] = {{"alpha_u", 0.3, 0.5},
               {"alpha_v", 0.1, 0.25},
               {"uroughness", 0.3, 0.5},
               {"vroughness", 0.1, 0.25},
               {"rotation", 20, 160},
               {"eta", 0.3, 1.5},
               {"k", 1, 4},
               {"clearcoat", 0.6, 0.9},
               {"clearcoatGloss", 0.2, 0.6},
               {"alpha", 0.1, 0.4},
               {"Anisotropy", 0.2, 0.6},
               {"reflectance", 0.4, 0.8},
               {"Specular Tint", 0.6, 0.95},
               {"specular_color", 0.6, 0.95}};
    const int one = !strcmp(k->unit, "1");
    if (!strcmp(k->unit, "turns")) return between(state, 0.05, 0.45);
    if (!strcmp(k->unit, "rad")) return between(state, 0.3, 2.8);
    if (one && k->lo >= 1) return between(state, 1.3, 1.9);
    for (size_t i = 0; i < sizeof own / sizeof *own; i++)
        if (!strcmp(own[i].name, k->made.name)) return between(state, own[i].lo, own[i].hi);
    return k->is_of_axis ? between(state, 0.3, 0.6) : between(state, 0.35, 0.65);
}

/* Controls [n][CHANNELS], and what they make of a surface. */
static void draw(const ff_material *m, const ff_model *model, uint64_t *state, double *control, fit_surface *s)
{
    memset(s, 0, sizeof *s);
    s->model = *model;
    s->n_channels = CHANNELS;
    ff_model_defaults(model, CHANNELS, s->shape, s->channel);
    for (size_t k = 0; k < ff_control_count(m); k++)
        for (size_t c = 0; c < CHANNELS; c++)
            control[k * CHANNELS + c] = c == 0 || m->control[k].is_color ? drawn(&m->control[k], state) : control[k * CHANNELS];
    ff_material_parameters(m, model, CHANNELS, control, s->shape, s->channel);
}

typedef struct control_probe {
    const ff_control *k;
    double x[FF_FORMULA_INPUTS];
    size_t input;
} control_probe;

static long judged[3]; /* derivatives of each verdict */

static double probe(const control_probe *p, double x)
{
    double at[FF_FORMULA_INPUTS];
    memcpy(at, p->x, sizeof at);
    at[p->input] = x;
    return p->k->made.value(at, NULL);
}

static void check_slopes(const char *what, const ff_control *k, const fit_surface *s, size_t c)
{
    ff_param_ref ref[FF_FORMULA_INPUTS];
    double d[FF_FORMULA_INPUTS];
    control_probe p = {.k = k};
    ff_control_value(k, &s->model, s->shape, s->channel, c, ref, d);
    for (size_t i = 0; i < FF_FORMULA_INPUTS && k->made.of[i]; i++)
        p.x[i] = ref[i].kind == FF_PARAM_SHAPE ? s->shape[ref[i].index] : s->channel[c * s->model.n_channel + ref[i].index];
    for (p.input = 0; p.input < FF_FORMULA_INPUTS && k->made.of[p.input]; p.input++) {
        const double x = p.x[p.input], at = probe(&p, x);
        double step = 0.05 * fmax(fabs(x), 0.1);
        model_ridders r;
        model_ridders_start(&r);
        for (int level = 0; level < MODEL_LEVELS; level++, step /= MODEL_RATIO)
            model_ridders_add(&r, (probe(&p, x + step) - probe(&p, x - step)) / (2 * step), 1e-15 * fabs(at) / fabs(step));
        const model_verdict verdict = model_judge(&r, d[p.input], fabs(at) / fmax(fabs(x), 0.1) + fabs(r.value));
        judged[verdict]++;
        FF_CHECK(verdict != MODEL_WRONG, "%s: d %s / d %s = %.12g, by differences %.12g +- %.1g", what, k->made.name,
                 k->made.of[p.input], d[p.input], r.value, r.error);
    }
}

static void go_there_and_back(const ff_target *t, const ff_material *m, const ff_model *model)
{
    char what[128];
    snprintf(what, sizeof what, "%s:%s", t->name, m->name);
    uint64_t state = ff_test_stream("controls of %s", what);
    for (int i = 0; i < DRAWN; i++) {
        double control[FF_TARGET_CONTROLS * CHANNELS];
        fit_surface s;
        ff_error err = {0};
        draw(m, model, &state, control, &s);
        FF_CHECK(ff_model_check(&s.model, CHANNELS, s.shape, s.channel, &err) == FF_OK, "%s: %s", what, err.message);
        for (size_t k = 0; k < ff_control_count(m); k++)
            for (size_t c = 0; c < (m->control[k].is_color ? CHANNELS : 1); c++) {
                const double back = ff_control_value(&m->control[k], &s.model, s.shape, s.channel, c, NULL, NULL);
                FF_CHECK(fabs(back - control[k * CHANNELS + c]) < 1e-9 * (1 + fabs(back)), "%s: %s is %.12g, set was %.12g", what,
                         m->control[k].made.name, back, control[k * CHANNELS + c]);
                check_slopes(what, &m->control[k], &s, c);
            }
    }
}

static void there_and_back(void)
{
    each_material(go_there_and_back);
    FF_CHECK(judged[MODEL_UNRESOLVED] <= judged[MODEL_RIGHT] / 50, "%ld resolved, %ld not", judged[MODEL_RIGHT],
             judged[MODEL_UNRESOLVED]);
}

/* ---- recovery -------------------------------------------------------------------------------- */

/* Those of a surface that has no direction of its own. */
static int is_round(const ff_model *m)
{
    return ff_model_param_find(m, "alpha").kind != FF_PARAM_NONE;
}

static double worst;
static size_t compared;

static void check_estimates(const char *what, const ff_material *m, const ff_fit_result *fit, const double *control)
{
    /* as recovery_test: the noise of seed 0 is known; 5.5 errors are passed by chance once in 26 million */
    const double most = ff_test_seed() ? 5.5 : 3;
    for (size_t k = 0; k < ff_control_count(m); k++)
        for (size_t c = 0; c < (m->control[k].is_color ? CHANNELS : 1); c++) {
            const ff_control_estimate e = ff_control_estimate_of(&m->control[k], fit, c);
            const double truth = control[k * CHANNELS + c], off = fabs(e.value - truth) / e.std_error;
            FF_CHECK(off <= most, "%s: %s is %.6g +- %.2g, set was %.6g", what, m->control[k].made.name, e.value, e.std_error,
                     truth);
            FF_CHECK(e.low < e.value && e.value < e.high && !e.beyond, "%s: %s = %g, interval %g to %g", what,
                     m->control[k].made.name, e.value, e.low, e.high);
            FF_CHECK(e.std_error < 0.25 * (1 + fabs(truth)), "%s: the error of %s says nothing: %g", what, m->control[k].made.name,
                     e.std_error);
            worst = fmax(worst, off);
            compared++;
        }
}

/* What is one number there came out as one. */
static void check_shared(const char *what, const ff_model *model, const ff_fit_result *fit)
{
    for (uint32_t k = 0; k < model->n_channel; k++)
        for (size_t c = 1; c < CHANNELS && (model->channel[k].flags & FF_PARAM_SHARED); c++)
            FF_CHECK(fit->channel_value[c * model->n_channel + k].value == fit->channel_value[k].value, "%s: %s of channel %zu",
                     what, model->channel[k].name, c);
    for (uint32_t k = 1; k < model->n_shape; k++)
        if (model->shape[k].flags & FF_PARAM_SHARED)
            FF_CHECK(fit->shape_value[k].value == fit->shape_value[k - 1].value, "%s: %s", what, model->shape[k].name);
}

static void recover(const ff_target *t, const ff_material *m, const ff_model *model)
{
    char what[128];
    snprintf(what, sizeof what, "%s:%s", t->name, m->name);
    uint64_t state = ff_test_stream("recovery of %s", what);
    double control[FF_TARGET_CONTROLS * CHANNELS];
    fit_surface s;
    ff_table table;
    ff_fit_result fit;
    ff_error err = {0};
    ff_fit_options o = fit_options();
    draw(m, model, &state, control, &s);
    o.shape = is_round(model) ? FF_SHAPE_ISOTROPIC : FF_SHAPE_CORRELATED;
    o.loss = FF_LOSS_LOG;
    table = fit_measure(&s, &(fit_sampling){.n = 4000, .max_theta = 80, .glossy = 0.5, .noise = 0.02, .seed = fit_random(&state)});
    if (FF_CHECK(fit_table(&table, &s.model, &o, &fit, NULL, &err) == FF_OK, "%s: %s", what, err.message)) {
        FF_CHECK(fit.outcome == FF_CONVERGED, "%s: %s", what, ff_outcome_name((int)fit.outcome));
        check_estimates(what, m, &fit, control);
        check_shared(what, model, &fit);
        ff_fit_result_clear(&fit);
    }
    ff_table_clear(&table);
}

static void recovery(void)
{
    each_material(recover);
    printf("  %zu controls, worst %.2f of their errors\n", compared, worst);
    FF_CHECK(compared > 100, "%zu controls", compared);
}

/* ---- errors ---------------------------------------------------------------------------------- */

/* The stated error of controls first .. first + 2 of a material against their scatter over measurements. */
static void check_scatter(const char *target, const char *material, size_t first, ff_shape shape)
{
    enum { SHOWN = 3 };
    const int repeats = fit_repeats(60, 240);
    const double known_to = 5 / sqrt(2.0 * repeats); /* five standard deviations of the standard deviation of so many */
    const ff_material *m = ff_material_find(ff_target_find(target), material, strlen(material));
    double control[FF_TARGET_CONTROLS * CHANNELS], sum[SHOWN] = {0}, squares[SHOWN] = {0}, stated[SHOWN] = {0};
    ff_model model;
    fit_surface s;
    if (!FF_CHECK(ff_material_model(m, &model, NULL) == FF_OK, "the material has no model")) return;
    uint64_t state = ff_test_stream("scatter of controls of %s", target);
    draw(m, &model, &state, control, &s);
    for (int i = 0; i < repeats; i++) {
        ff_fit_result fit;
        ff_error err = {0};
        ff_fit_options o = fit_options();
        o.loss = FF_LOSS_LOG;
        o.shape = shape;
        ff_table table =
            fit_measure(&s, &(fit_sampling){.n = 1200, .max_theta = 80, .glossy = 0.5, .noise = 0.02, .seed = fit_random(&state)});
        if (FF_CHECK(fit_table(&table, &s.model, &o, &fit, NULL, &err) == FF_OK, "%s", err.message)) {
            for (size_t k = 0; k < SHOWN; k++) {
                const ff_control_estimate e = ff_control_estimate_of(&m->control[first + k], &fit, 0);
                const double off = e.value - control[(first + k) * CHANNELS];
                sum[k] += off, squares[k] += off * off, stated[k] += e.std_error;
            }
            ff_fit_result_clear(&fit);
        }
        ff_table_clear(&table);
    }
    for (size_t k = 0; k < SHOWN; k++) {
        const double sd = sqrt((squares[k] - sum[k] * sum[k] / repeats) / (repeats - 1)), ratio = stated[k] / repeats / sd;
        printf("  %s: scatter %.2g, stated %.2f times that\n", m->control[first + k].made.name, sd, ratio);
        FF_CHECK(fabs(log(ratio)) < log1p(known_to), "%s: stated %.3f times the scatter", m->control[first + k].made.name, ratio);
    }
}

/* Roughness, Anisotropic, Anisotropic Rotation are functions of three parameters each, Specular Tint is one of F0 and F82. */
static void errors_are_the_scatter(void)
{
    check_scatter("blender", "metal", 1, FF_SHAPE_CORRELATED);
    check_scatter("blender-4", "metal", 1, FF_SHAPE_CORRELATED);
}

/* What follows another parameter counts once: of an isotropic surface both roughnesses are one number. */
static void tied_parameters_count_once(void)
{
    const ff_material *m = ff_material_find(ff_target_find("gltf"), "metal", 5);
    ff_model model;
    if (!FF_CHECK(ff_material_model(m, &model, NULL) == FF_OK, "the material has no model")) return;
    fit_surface s = {.model = model, .n_channels = 1};
    ff_table table;
    ff_fit_result fit;
    ff_error err = {0};
    ff_fit_options o = fit_options();
    ff_model_defaults(&model, 1, s.shape, s.channel);
    s.shape[0] = s.shape[1] = 0.16;
    o.shape = FF_SHAPE_ISOTROPIC;
    table = fit_measure(&s, &(fit_sampling){.n = 1000, .max_theta = 80, .glossy = 0.5, .noise = 0.02, .seed = 3});
    if (FF_CHECK(fit_table(&table, &model, &o, &fit, NULL, &err) == FF_OK, "%s", err.message)) {
        const ff_control_estimate e = ff_control_estimate_of(&m->control[1], &fit, 0);
        const ff_fit_value *alpha = &fit.shape_value[0];
        FF_CHECK_CLOSE(e.value, sqrt(alpha->value), 1e-12, 0);
        FF_CHECK_CLOSE(e.std_error, alpha->std_error / (2 * sqrt(alpha->value)), 1e-9, 0);
        FF_CHECK_CLOSE(e.low, sqrt(alpha->low), 1e-12, 0);
        FF_CHECK_CLOSE(e.high, sqrt(alpha->high), 1e-12, 0);
        ff_fit_result_clear(&fit);
    }
    ff_table_clear(&table);
}

/* Bands in which the one is worse by more than is asked, worst first. */
static void shortfalls(void)
{
    static ff_bands fit, other;
    ff_shortfall at[2];
    fit.band[FF_PLACE_THETA_H][2] = (ff_band){10, -0.1, 0.2};
    other.band[FF_PLACE_THETA_H][2] = (ff_band){10, 0, 0.15};
    fit.band[FF_PLACE_THETA_I][5] = (ff_band){10, 0.3, 0.4};
    other.band[FF_PLACE_THETA_I][5] = (ff_band){10, 0, 0.1};
    fit.band[FF_PLACE_THETA_I][6] = (ff_band){10, 0.3, 0.2};
    other.band[FF_PLACE_THETA_I][6] = (ff_band){10, 0, 0.1};
    FF_CHECK(ff_shortfalls_find(&fit, &other, 0.01, 2, at) == 2, "two are asked for");
    FF_CHECK(at[0].place == FF_PLACE_THETA_I && at[0].band == 5 && at[1].band == 6, "bands %d and %d", at[0].band, at[1].band);
    FF_CHECK(ff_shortfalls_find(&fit, &other, 0.07, 2, at) == 2 && ff_shortfalls_find(&fit, &other, 0.2, 2, at) == 1 &&
                 ff_shortfalls_find(&fit, &other, 0.5, 2, at) == 0 && ff_shortfalls_find(&other, &fit, 0, 2, at) == 0,
             "by how much");
}

FF_TEST_MAIN(FF_TEST(names), FF_TEST(there_and_back), FF_TEST(recovery), FF_TEST(errors_are_the_scatter),
             FF_TEST(tied_parameters_count_once), FF_TEST(shortfalls))
