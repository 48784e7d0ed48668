/* What a fit does with too little, unusable or odd data, with wrong options, and when it is told to stop. */
#include "fit_samples.h"
#include "fit/losses/internal_loss.h"
#include "warnings.h"
#include <pthread.h>
#include <time.h>

static const char *const surface_words = "alpha_x=0.2 alpha_y=0.45 r_xy=0.4 f0=0.9:0.6:0.3 kd=0.1:0.05:0.02";

static fit_surface surface_of(const char *model)
{
    return fit_surface_make(model, 3, surface_words);
}

static ff_table table_of(const fit_surface *s, size_t n, double noise)
{
    const fit_sampling how = {.n = n, .max_theta = 80, .noise = noise, .seed = 12};
    return fit_measure(s, &how);
}

/* A failing call leaves its result alone and says something. */
static void check_refused(const char *what, const ff_table *t, const ff_model *m, const ff_fit_options *o, ff_status expected,
                          const char *word)
{
    ff_fit_result r, untouched;
    ff_error err = {0};
    memset(&r, 0x5a, sizeof r);
    memset(&untouched, 0x5a, sizeof untouched);
    const ff_status status = fit_table(t, m, o, &r, NULL, &err);
    FF_CHECK(status == expected && err.code == expected, "%s: status %s, error %s, expected %s", what, ff_status_str(status),
             ff_status_str(err.code), ff_status_str(expected));
    FF_CHECK(strstr(err.message, word) != NULL, "%s: '%s' does not say '%s'", what, err.message, word);
    FF_CHECK(memcmp(&r, &untouched, sizeof r) == 0, "%s: the result was written", what);
    if (!status) ff_fit_result_clear(&r);
    const ff_status quiet = fit_table(t, m, o, &r, NULL, NULL);
    FF_CHECK(quiet == expected, "%s: another status without an error object", what);
    if (!quiet) ff_fit_result_clear(&r);
}

/* Every number of a result is finite and in its box; NaN only where it is documented. */
static void check_sane(const char *what, const ff_fit_result *r)
{
    for (size_t k = 0; k < fit_parameter_count(r); k++) {
        char name[64];
        double truth;
        const ff_fit_value *v = fit_parameter(r, k, NULL, &truth, name);
        const ff_param *info =
            k < r->model.n_shape ? r->model.shape[k].info : r->model.channel[(k - r->model.n_shape) % r->model.n_channel].info;
        if (!v) continue;
        FF_CHECK(v->value >= info->lo && v->value <= info->hi, "%s: %s = %g", what, name, v->value);
        FF_CHECK(v->at_bound ? isnan(v->std_error) : !(v->std_error < 0) && !isinf(v->std_error),
                 "%s: %s has standard error %g, bound %d", what, name, v->std_error, v->at_bound);
        FF_CHECK((v->column < 0) == isnan(v->std_error), "%s: %s has column %d and standard error %g", what, name, v->column,
                 v->std_error);
    }
    const ff_residual *e = &r->residual;
    FF_CHECK(e->objective >= 0 && e->rmse >= 0 && e->cosine_rmse >= 0 && e->log_rmse >= 0 && e->cube_root_rmse >= 0 &&
                 e->max_abs >= 0,
             "%s: residuals", what);
    FF_CHECK(isfinite(e->objective + e->rmse + e->cosine_rmse + e->log_rmse + e->cube_root_rmse + e->max_abs),
             "%s: residuals are not finite", what);
    FF_CHECK(isfinite(r->aic) && isfinite(r->bic), "%s: aic %g, bic %g", what, r->aic, r->bic);
}

/* ---- too little ------------------------------------------------------------------------------ */

static void fewer_values_than_parameters(void)
{
    const fit_surface s = surface_of("ggx+lambert");
    ff_table t = table_of(&s, 10, 0);
    ff_fit_options o = fit_options();
    for (size_t n = 1; n < 3; n++) { /* 3 and 6 values, 9 parameters */
        t.n = n;
        ff_table few = table_of(&s, n, 0);
        char counts[64];
        snprintf(counts, sizeof counts, "%zu values", 3 * n);
        check_refused("too few", &few, &s.model, &o, FF_ERR_DATA, counts);
        ff_table_clear(&few);
    }
    ff_table_clear(&t);
    /* as many values as parameters, and a little more: an answer, and no claim to know its error out of nothing */
    for (size_t n = 3; n < 8; n++) {
        ff_table few = table_of(&s, n, 0.02);
        ff_fit_result r;
        ff_error err = {0};
        const ff_status status = fit_table(&few, &s.model, &o, &r, NULL, &err);
        FF_CHECK(status == FF_OK, "%zu samples: %s", n, err.message);
        if (!status) check_sane("few samples", &r);
        if (!status && n == 3)
            for (size_t k = 0; k < fit_parameter_count(&r); k++) {
                char name[64];
                double truth;
                const ff_fit_value *v = fit_parameter(&r, k, NULL, &truth, name);
                if (v && !v->at_bound)
                    FF_CHECK(isnan(v->std_error) || v->std_error > 1e-3 * v->value, "9 values, 9 parameters: %s = %g +- %g", name,
                             v->value, v->std_error);
            }
        if (!status) ff_fit_result_clear(&r);
        ff_table_clear(&few);
    }
}

static void one_sample(void)
{
    const fit_surface s = fit_surface_make("lambert", 3, "kd=0.1:0.5:0.9");
    ff_table t = table_of(&s, 1, 0);
    const ff_fit_options o = fit_options();
    ff_fit_result r;
    ff_error err = {0};
    const ff_status status = fit_table(&t, &s.model, &o, &r, NULL, &err);
    FF_CHECK(status == FF_OK, "%s", err.message);
    for (size_t c = 0; c < 3 && !status; c++) FF_CHECK_CLOSE(r.channel_value[c].value, s.channel[c], 1e-12, 0);
    if (!status) check_sane("one sample", &r);
    if (!status) ff_fit_result_clear(&r);
    ff_table_clear(&t);
}

static void nothing_usable(void)
{
    const fit_surface s = surface_of("ggx+lambert");
    const ff_fit_options o = fit_options();
    ff_table t = table_of(&s, 300, 0);
    memset(t.valid, 0, t.n);
    check_refused("all invalid", &t, &s.model, &o, FF_ERR_DATA,
                  "of 300, 300 are not valid measurements, 0 lie at or below the horizon, 0 beyond 80 degrees");
    memset(t.valid, 1, t.n);
    for (size_t i = 0; i < t.n; i++) t.angle[2][i] = 100 * FIT_DEGREE;
    check_refused("below the horizon", &t, &s.model, &o, FF_ERR_DATA,
                  "0 are not valid measurements, 300 lie at or below the horizon");
    for (size_t i = 0; i < t.n; i++) t.angle[2][i] = 85 * FIT_DEGREE;
    check_refused("grazing", &t, &s.model, &o, FF_ERR_DATA, "0 lie at or below the horizon, 300 beyond 80 degrees");
    t.valid[0] = 0;
    t.angle[2][1] = 91 * FIT_DEGREE;
    check_refused("all of it", &t, &s.model, &o, FF_ERR_DATA,
                  "1 are not valid measurements, 1 lie at or below the horizon, 298 beyond 80 degrees");
    ff_table_clear(&t);
}

/* ---- odd values ------------------------------------------------------------------------------ */

static void zero_channels(void)
{
    const fit_surface s = surface_of("ggx+lambert");
    const ff_fit_options o = fit_options();
    for (int all = 0; all < 2; all++) {
        ff_table t = table_of(&s, 3000, 0);
        memset(t.value + (all ? 0 : t.n), 0, (all ? 3 : 1) * t.n * sizeof *t.value);
        for (int loss = 0; loss < FF_LOSS_COUNT; loss++) {
            ff_fit_options with = o;
            ff_fit_result r;
            ff_error err = {0};
            with.loss = (ff_loss)loss;
            const ff_status status = fit_table(&t, &s.model, &with, &r, NULL, &err);
            if (!ff_loss_has_value((ff_loss)loss, 0, 1)) { /* every sample has a channel of 0 */
                FF_CHECK(status == FF_ERR_DATA && strstr(err.message, ff_loss_name(loss)), "%s: %s", ff_loss_name(loss),
                         err.message);
                if (!status) ff_fit_result_clear(&r);
                continue;
            }
            FF_CHECK(status == FF_OK, "%s: %s", ff_loss_name(loss), err.message);
            if (status) continue;
            FF_CHECK(r.outcome == FF_CONVERGED || all, "%s: %s", ff_loss_name(loss), ff_outcome_name((int)r.outcome));
            check_sane(ff_loss_name(loss), &r);
            for (size_t c = all ? 0 : 1; c < (all ? 3 : 2); c++)
                FF_CHECK(r.channel_value[3 * c].at_bound == -1 && r.channel_value[3 * c + 2].at_bound == -1,
                         "%s, channel %zu: f0 = %g, kd = %g", ff_loss_name(loss), c, r.channel_value[3 * c].value,
                         r.channel_value[3 * c + 2].value);
            const size_t said = count_warnings(&r.warnings, FF_WARNING_DARK_CHANNEL);
            FF_CHECK(said == (all ? 3 : 1), "%s: %zu of the dark channels are named", ff_loss_name(loss), said);
            /* Schlick's law reflects at grazing even with f0 = 0, so a channel of zeros does pull the shape; the bright ones hold
             * it */
            if (!all && loss == FF_LOSS_COSINE)
                for (size_t k = 0; k < 3; k++) FF_CHECK_CLOSE(r.shape_value[k].value, s.shape[k], 0.1, 0);
            ff_fit_result_clear(&r);
        }
        ff_table_clear(&t);
    }
}

static void selection_is(const char *what, const ff_table *t, const ff_fit_options *o, size_t used, size_t invalid, size_t below,
                         size_t grazing, size_t negative)
{
    const fit_surface s = surface_of("ggx+lambert");
    ff_fit_result r;
    ff_selection sel = {0};
    ff_error err = {0};
    const ff_status status = fit_table(t, &s.model, o, &r, &sel, &err);
    FF_CHECK(status == FF_OK, "%s: %s", what, err.message);
    FF_CHECK(sel.samples == t->n && sel.used == used && sel.invalid == invalid && sel.below_horizon == below &&
                 sel.grazing == grazing && sel.negative == negative,
             "%s: of %zu used %zu, invalid %zu, below %zu, grazing %zu, negative %zu", what, sel.samples, sel.used, sel.invalid,
             sel.below_horizon, sel.grazing, sel.negative);
    if (status) return;
    check_sane(what, &r);
    for (size_t k = 0; k < 3; k++) FF_CHECK_CLOSE(r.shape_value[k].value, s.shape[k], 1e-2, 0);
    ff_fit_result_clear(&r);
}

static void values_that_are_none(void)
{
    const fit_surface s = surface_of("ggx+lambert");
    ff_fit_options o = fit_options();
    ff_table t = table_of(&s, 5000, 0);
    selection_is("clean", &t, &o, 5000, 0, 0, 0, 0);
    t.value[7] = NAN;
    t.value[t.n + 7] = NAN; /* the same sample: counted once */
    t.value[2 * t.n + 4999] = INFINITY;
    t.value[100] = -INFINITY;
    selection_is("NaN and infinities", &t, &o, 4997, 3, 0, 0, 0);
    t.valid[200] = 0;
    t.angle[0][201] = 95 * FIT_DEGREE;
    t.angle[2][202] = 81 * FIT_DEGREE;
    t.value[t.n + 300] = t.value[2 * t.n + 300] = -1e-4; /* negative: noise, kept */
    t.value[301] = -1e-4;
    selection_is("all kinds", &t, &o, 4994, 4, 1, 1, 2);
    t.value[301] = -50;
    o.loss = FF_LOSS_LOG; /* has no value at or below -1 / cos */
    selection_is("a datum that the log loss cannot take", &t, &o, 4993, 5, 1, 1, 1);
    o.loss = FF_LOSS_COSINE;
    o.only_channel = 2;
    ff_fit_result r;
    ff_selection sel = {0};
    ff_error err = {0};
    FF_CHECK(fit_table(&t, &s.model, &o, &r, &sel, &err) == FF_OK && sel.invalid == 2, "channel 2 alone: %zu invalid, %s",
             sel.invalid, err.message);
    ff_fit_result_clear(&r);
    ff_table_clear(&t);
}

static void sigmas_that_are_none(void)
{
    const fit_surface s = surface_of("ggx+lambert");
    const fit_sampling how = {.n = 5000, .max_theta = 80, .noise = 0.02, .seed = 2, .sigma = 1};
    ff_fit_options o = fit_options();
    ff_table t = fit_measure(&s, &how);
    t.sigma[0] = 0;
    t.sigma[t.n + 1] = -1;
    t.sigma[2 * t.n + 2] = NAN;
    t.sigma[3] = INFINITY;
    selection_is("sigma weights by default", &t, &o, 4996, 4, 0, 0, 0);
    o.weighting = FF_WEIGHT_SAMPLE;
    selection_is("sigmas not asked for", &t, &o, 5000, 0, 0, 0, 0);
    o.weighting = FF_WEIGHT_SOLID_ANGLE;
    check_refused("solid angles of scattered samples", &t, &s.model, &o, FF_ERR_UNSUPPORTED, "solid-angle");
    free(t.sigma);
    t.sigma = NULL;
    o.weighting = FF_WEIGHT_SIGMA;
    check_refused("no sigmas", &t, &s.model, &o, FF_ERR_UNSUPPORTED, "standard deviations");
    ff_table_clear(&t);
}

/* Samples that say one thing 100 times: some parameters are not determined, and the fit says which instead of inventing errors. */
static void the_same_sample_again_and_again(void)
{
    const fit_surface s = surface_of("ggx+lambert");
    const ff_fit_options o = fit_options();
    ff_table t = table_of(&s, 100, 0);
    for (size_t i = 1; i < t.n; i++) {
        for (size_t k = 0; k < 4; k++) t.angle[k][i] = t.angle[k][0];
        for (size_t c = 0; c < 3; c++) t.value[c * t.n + i] = t.value[c * t.n] * (1 + 1e-12 * (double)i); /* no mere copies */
    }
    ff_fit_result r;
    ff_error err = {0};
    const ff_status status = fit_table(&t, &s.model, &o, &r, NULL, &err);
    FF_CHECK(status == FF_OK, "%s", err.message);
    if (!status) {
        check_sane("one direction", &r);
        FF_CHECK(r.n_columns < r.n_free, "9 parameters from 3 numbers: %zu of %zu have a standard error", r.n_columns, r.n_free);
        FF_CHECK(has_warning(&r, FF_WARNING_NOT_DETERMINED, NULL), "%zu warnings, none of an undetermined parameter", r.warnings.n);
        ff_fit_result_clear(&r);
    }
    ff_table_clear(&t);
}

/* ---- sizes and scales ------------------------------------------------------------------------ */

/* The residuals once more, from the fitted parameters and the table. */
static void residuals_of(const ff_table *t, const ff_fit_result *r, ff_residual *out)
{
    fit_surface s = {.model = r->model, .n_channels = 3};
    ff_table model;
    double n = 0;
    *out = (ff_residual){0};
    for (size_t k = 0; k < r->model.n_shape; k++) s.shape[k] = r->shape_value[k].value;
    for (size_t k = 0; k < 3 * r->model.n_channel; k++) s.channel[k] = r->channel_value[k].value;
    if (ff_table_init(t->n, 3, NULL, 0, 0, &model, NULL)) exit(1);
    for (size_t k = 0; k < 4; k++) memcpy(model.angle[k], t->angle[k], t->n * sizeof(double));
    model.radians_per_unit = t->radians_per_unit;
    fit_evaluate(&s, &model);
    for (size_t c = 0; c < 3; c++)
        for (size_t i = 0; i < t->n; i++) {
            const double x = cos(t->angle[0][i]), f = model.value[c * t->n + i], y = t->value[c * t->n + i], e = f - y;
            const double log_e = log1p(f * x) - log1p(y * x), root_e = cbrt(f * x) - cbrt(y * x);
            if (!t->valid[i]) continue;
            n++;
            out->rmse += e * e;
            out->cosine_rmse += e * x * e * x;
            out->log_rmse += log_e * log_e;
            out->cube_root_rmse += root_e * root_e;
            out->max_abs = fmax(out->max_abs, fabs(e));
        }
    out->objective = 0.5 * out->cosine_rmse;
    out->rmse = sqrt(out->rmse / n);
    out->cosine_rmse = sqrt(out->cosine_rmse / n);
    out->log_rmse = sqrt(out->log_rmse / n);
    out->cube_root_rmse = sqrt(out->cube_root_rmse / n);
    ff_table_clear(&model);
}

static void every_size_of_a_last_block(void)
{
    static const size_t sizes[] = {9, 127, 128, 129, 255, 256, 257, 2047, 2048, 2049, 4095, 4096, 4097, 12000, 12001, 30011};
    const fit_surface s = surface_of("ggx+lambert");
    const ff_fit_options o = fit_options();
    for (size_t i = 0; i < sizeof sizes / sizeof *sizes; i++)
        for (int holes = 0; holes < 2; holes++) {
            ff_table t = table_of(&s, sizes[i], 0.05);
            for (size_t k = 3; k < t.n && holes; k += 7) t.valid[k] = 0;
            t.value[t.n - 1] += 1; /* the last sample counts: it is the largest residual */
            ff_fit_result r;
            ff_residual e;
            ff_error err = {0};
            t.valid[t.n - 1] = 1;
            const ff_status status = fit_table(&t, &s.model, &o, &r, NULL, &err);
            FF_CHECK(status == FF_OK, "%zu samples: %s", t.n, err.message);
            if (!status) {
                residuals_of(&t, &r, &e);
                check_sane("sizes", &r);
                FF_CHECK_CLOSE(r.residual.objective, e.objective, 1e-9, 0);
                FF_CHECK_CLOSE(r.residual.rmse, e.rmse, 1e-9, 0);
                FF_CHECK_CLOSE(r.residual.cosine_rmse, e.cosine_rmse, 1e-9, 0);
                FF_CHECK_CLOSE(r.residual.log_rmse, e.log_rmse, 1e-9, 0);
                FF_CHECK_CLOSE(r.residual.cube_root_rmse, e.cube_root_rmse, 1e-6, 0); /* the loss is smoothed at 0 */
                FF_CHECK_CLOSE(r.residual.max_abs, e.max_abs, 1e-9, 0);
                FF_CHECK(t.n < 100 || r.residual.max_abs > 0.5, "%zu samples: the last one does not count", t.n);
                ff_fit_result_clear(&r);
            }
            ff_table_clear(&t);
        }
}

/* What is fitted to data times a factor: with a free scale of the lobe, which the factor multiplies; or without. */
static ff_fit_result fitted_to_scaled(const char *expression, const fit_surface *s, int scaled_lobe, double factor, double noise,
                                      ff_loss loss)
{
    ff_model m = s->model;
    ff_table t = table_of(s, 3000, noise);
    ff_fit_options o = fit_options();
    ff_fit_result r = {0};
    ff_error err = {0};
    if (scaled_lobe) ff_model_vary(&m, "ks", NULL);
    for (size_t i = 0; i < 3 * t.n; i++) t.value[i] *= factor;
    o.loss = loss;
    o.shape = FF_SHAPE_ISOTROPIC; /* an ellipse fitted to what no surface does would crawl along its valley for long */
    const ff_status status = fit_table(&t, &m, &o, &r, NULL, &err);
    FF_CHECK(status == FF_OK, "%s, %s, values x %g: %s", expression, ff_loss_name((int)loss), factor, err.message);
    if (status) exit(1);
    check_sane(expression, &r);
    ff_table_clear(&t);
    return r;
}

/* Where the lobe has a scale, the data times any factor are those of a surface: the fit converges, and without noise to that one.
 */
static void check_scaled_surface(const char *expression, const char *words, double factor, double noise, ff_loss loss)
{
    const fit_surface s = fit_surface_make(expression, 3, words);
    ff_fit_result r = fitted_to_scaled(expression, &s, s.model.n_lobes > 0, factor, noise, loss);
    FF_CHECK(r.outcome == FF_CONVERGED, "%s, %s, values x %g: %s", expression, ff_loss_name((int)loss), factor,
             ff_outcome_name((int)r.outcome));
    for (size_t k = 0; k < fit_parameter_count(&r) && noise == 0; k++) {
        char name[64];
        double truth;
        const ff_fit_value *v = fit_parameter(&r, k, &s, &truth, name);
        if (!v) continue;
        if (strncmp(name, "ks", 2) == 0 || strncmp(name, "kd", 2) == 0) truth *= factor;
        FF_CHECK(v->at_bound == 0 && fabs(v->value - truth) <= 1e-6 * truth, "%s, %s, values x %g: %s = %.10g, not %g", expression,
                 ff_loss_name((int)loss), factor, name, v->value, truth);
    }
    ff_fit_result_clear(&r);
}

static void extreme_scales(void)
{
    static const char *const models[] = {"ggx+lambert", "beckmann/v-cavity+lambert", "student-t/smith-separable+lambert",
                                         "phong+lambert", "lambert"};
    for (size_t m = 0; m < sizeof models / sizeof *models; m++)
        for (int loss = 0; loss < FF_LOSS_COUNT; loss++) {
            const char *words = m == 4 ? "kd=0.1:0.05:0.02" : "f0=0.9:0.6:0.3 kd=0.1:0.05:0.02";
            const fit_surface s = fit_surface_make(models[m], 3, words);
            check_scaled_surface(models[m], words, 1e-6, 0.02, (ff_loss)loss);
            check_scaled_surface(models[m], words, 1e-12, 0.02, (ff_loss)loss);
            check_scaled_surface(models[m], words, 1e-6, 0, (ff_loss)loss);
            ff_fit_result bright = fitted_to_scaled(models[m], &s, 0, 1e6, 0.02, (ff_loss)loss);
            FF_CHECK(bright.outcome == FF_CONVERGED, "%s, %s: %s", models[m], ff_loss_name(loss),
                     ff_outcome_name((int)bright.outcome));
            for (size_t c = 0; c < 3 && m == 4; c++)
                FF_CHECK(bright.channel_value[c].at_bound == 1, "kd = %g", bright.channel_value[c].value);
            ff_fit_result_clear(&bright);
        }
}

/* A lobe without a scale reflects all at grazing, whatever f0 is: to data of a millionth it can only be made so narrow, or so
 * broad, that the samples miss it, and where it hides f0 and the width trade off without end (Schlick's edge is 1; at a hundredth
 * of these data's scale it is the same). That is no optimum that a solver could find: the fit may end at its limit, and says so. */
static void values_of_no_surface(void)
{
    static const char *const models[] = {"ggx+lambert", "beckmann/v-cavity+lambert", "student-t/smith-separable+lambert",
                                         "phong+lambert"};
    for (size_t m = 0; m < sizeof models / sizeof *models; m++)
        for (int loss = 0; loss < FF_LOSS_COUNT; loss++) {
            const fit_surface s = fit_surface_make(models[m], 3, "f0=0.9:0.6:0.3 kd=0.1:0.05:0.02");
            ff_fit_result r = fitted_to_scaled(models[m], &s, 0, 1e-6, 0.02, (ff_loss)loss);
            FF_CHECK(r.outcome == FF_CONVERGED || r.outcome == FF_LIMIT, "%s, %s: %s", models[m], ff_loss_name(loss),
                     ff_outcome_name((int)r.outcome));
            FF_CHECK(has_warning(&r, FF_WARNING_ITERATION_LIMIT, NULL) == (r.outcome == FF_LIMIT), "%s, %s: the limit is not said",
                     models[m], ff_loss_name(loss));
            ff_fit_result_clear(&r);
        }
}

/* ---- options --------------------------------------------------------------------------------- */

static void wrong_options(void)
{
    const fit_surface s = surface_of("ggx+lambert");
    ff_table t = table_of(&s, 500, 0);
    ff_fit_options o;
    memset(&o, 0, sizeof o);
    check_refused("not initialised", &t, &s.model, &o, FF_ERR_RANGE, "ff_fit_options_init");
#define REFUSE(field, bad, word)                                                                                                   \
    do {                                                                                                                           \
        o = fit_options();                                                                                                         \
        o.field = bad;                                                                                                             \
        check_refused(#field " = " #bad, &t, &s.model, &o, FF_ERR_RANGE, word);                                                    \
    } while (0)
    REFUSE(threads, -1, "threads");
    REFUSE(max_iterations, -1, "iterations");
    REFUSE(max_theta, 0, "largest angle");
    REFUSE(max_theta, -1, "largest angle");
    REFUSE(max_theta, 1.6, "largest angle");
    REFUSE(max_theta, NAN, "largest angle");
    REFUSE(loss, (ff_loss)99, "option");
    REFUSE(robust, (ff_robust)99, "option");
    REFUSE(weighting, (ff_weighting)99, "option");
    REFUSE(shape, (ff_shape)99, "option");
    REFUSE(channels, (ff_channel_mode)99, "option");
    REFUSE(only_channel, 3, "channel 3");
#undef REFUSE
    for (int robust = FF_ROBUST_HUBER; robust < FF_ROBUST_COUNT; robust++)
        for (int k = 0; k < 3; k++) {
            const double bad[] = {-1, NAN, INFINITY};
            o = fit_options();
            o.robust = (ff_robust)robust;
            o.robust_scale = bad[k];
            check_refused("scale of a robust loss", &t, &s.model, &o, FF_ERR_RANGE, "scale");
        }
    ff_problem *p = NULL;
    ff_error err = {0};
    o = fit_options();
    FF_CHECK(ff_problem_make(&t, &s.model, 0, &o, &p, &err) == FF_ERR_RANGE && p == NULL, "no model: %s", err.message);
    ff_table none = {0};
    FF_CHECK(ff_problem_make(&none, &s.model, 1, &o, &p, &err) == FF_ERR_DATA && p == NULL, "no samples: %s", err.message);
    ff_table_clear(&t);
}

/* The fit takes options too: what concerns it alone is checked there. */
static void wrong_options_of_the_fit(void)
{
    const fit_surface s = surface_of("ggx+lambert");
    ff_table t = table_of(&s, 500, 0);
    ff_fit_options o = fit_options();
    ff_problem *p = NULL;
    ff_error err = {0};
    FF_CHECK(ff_problem_make(&t, &s.model, 1, &o, &p, &err) == FF_OK, "%s", err.message);
    for (int k = 0; k < 5 && p; k++) {
        ff_fit_options bad = o;
        ff_fit_result r = {0};
        if (k == 0) memset(&bad, 0, sizeof bad);
        if (k == 1) bad.max_iterations = -1;
        if (k == 2) bad.robust = FF_ROBUST_HUBER, bad.robust_scale = -1;
        if (k == 3) bad.robust = (ff_robust)99;
        if (k == 4) bad.shape = (ff_shape)99;
        const ff_status status = ff_problem_fit_into(p, &s.model, &bad, &r, &err);
        FF_CHECK(status == FF_ERR_RANGE, "wrong option %d of the fit: %s", k, ff_status_str(status));
        ff_fit_result_clear(&r);
    }
    ff_problem_free(p);
    ff_table_clear(&t);
}

static void combinations_without_meaning(void)
{
    const fit_surface s = surface_of("ggx+lambert");
    ff_table t = table_of(&s, 500, 0);
    ff_fit_options o = fit_options();
    const fit_surface phong = fit_surface_make("phong+lambert", 3, ""), cavity = fit_surface_make("ggx/v-cavity+lambert", 3, "");
    o.shape = FF_SHAPE_CORRELATED;
    check_refused("phong, correlated", &t, &phong.model, &o, FF_ERR_UNSUPPORTED, "phong");
    o.shape = FF_SHAPE_AXIS;
    check_refused("phong, axis", &t, &phong.model, &o, FF_ERR_UNSUPPORTED, "phong");
    o.shape = FF_SHAPE_AUTO;
    o.mean_slope = 1;
    check_refused("v-cavity with a mean slope", &t, &cavity.model, &o, FF_ERR_UNSUPPORTED, "v-cavity");
    check_refused("phong with a mean slope", &t, &phong.model, &o, FF_ERR_UNSUPPORTED, "phong");
    ff_table_clear(&t);
}

static void model_that_the_problem_was_not_made_for(void)
{
    static const struct {
        const char *made_for, *asked;
        ff_shape shape;
    } cases[] = {{"lambert", "ggx+lambert", FF_SHAPE_ISOTROPIC},
                 {"ggx/none/none", "ggx/none/schlick", FF_SHAPE_ISOTROPIC},
                 {"ggx/smith-separable", "ggx/v-cavity", FF_SHAPE_ISOTROPIC},
                 {"phong", "ggx", FF_SHAPE_CORRELATED}};
    const fit_surface s = surface_of("ggx+lambert");
    ff_table t = table_of(&s, 500, 0);
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
        const fit_surface made_for = fit_surface_make(cases[k].made_for, 3, ""), asked = fit_surface_make(cases[k].asked, 3, "");
        ff_fit_options o = fit_options();
        ff_problem *p = NULL;
        ff_fit_result r = {0};
        ff_error err = {0};
        o.shape = FF_SHAPE_ISOTROPIC;
        FF_CHECK(ff_problem_make(&t, &made_for.model, 1, &o, &p, &err) == FF_OK, "%s: %s", cases[k].made_for, err.message);
        o.shape = cases[k].shape;
        if (p) {
            const ff_status status = ff_problem_fit_into(p, &asked.model, &o, &r, &err);
            FF_CHECK(status == FF_ERR_UNSUPPORTED && strstr(err.message, "ff_problem_new"),
                     "%s fitted to a problem made for %s: %s", cases[k].asked, cases[k].made_for, ff_status_str(status));
        }
        ff_fit_result_clear(&r);
        ff_problem_free(p);
    }
    ff_table_clear(&t);
}

/* With every limit below what a fit takes. Values that no surface has: it would mostly follow a narrow valley for long. */
static void limit_of_iterations(void)
{
    int limits[] = {0, 1, 0};
    const fit_surface s = surface_of("ggx+lambert");
    ff_table t = table_of(&s, 3000, 0.02);
    for (size_t i = 0; i < 3 * t.n; i++) t.value[i] *= 1e6;
    ff_fit_options o = fit_options();
    ff_fit_result r;
    ff_error err = {0};
    FF_CHECK(fit_table(&t, &s.model, &o, &r, NULL, &err) == FF_OK, "%s", err.message);
    FF_CHECK(r.iterations > 1, "a fit of %d iterations has no limit to be tried", r.iterations);
    limits[2] = r.iterations - 1;
    ff_fit_result_clear(&r);
    for (size_t k = 0; k < sizeof limits / sizeof *limits; k++) {
        o.max_iterations = limits[k];
        const ff_status status = fit_table(&t, &s.model, &o, &r, NULL, &err);
        FF_CHECK(status == FF_OK, "%s", err.message);
        if (status) continue;
        const ff_warning *said = find_warning(&r, FF_WARNING_ITERATION_LIMIT, NULL);
        FF_CHECK(r.outcome == FF_LIMIT && r.iterations == limits[k] && said && said->value[0] == limits[k], "limit %d: %s after %d",
                 limits[k], ff_outcome_name((int)r.outcome), r.iterations);
        check_sane("limit", &r);
        ff_fit_result_clear(&r);
    }
    ff_table_clear(&t);
}

static void no_standard_errors(void)
{
    const fit_surface s = surface_of("ggx+lambert");
    ff_table t = table_of(&s, 3000, 0.05);
    ff_fit_options o = fit_options();
    ff_fit_result r;
    ff_error err = {0};
    o.std_errors = 0;
    const ff_status status = fit_table(&t, &s.model, &o, &r, NULL, &err);
    FF_CHECK(status == FF_OK, "%s", err.message);
    if (!status) {
        check_sane("no standard errors", &r);
        FF_CHECK(r.correlation == NULL && r.n_columns == 0 && isnan(r.shape_value[0].std_error),
                 "standard errors that nobody asked for");
        ff_fit_result_clear(&r);
    }
    ff_table_clear(&t);
}

/* ---- progress and cancellation --------------------------------------------------------------- */

typedef struct watcher {
    int calls, cancel_at;
    double last;
    volatile int cancel;
} watcher;

static void watch(void *context, int iteration, double objective)
{
    watcher *w = context;
    FF_CHECK(iteration >= 0 && objective >= 0 && isfinite(objective), "progress: iteration %d, objective %g", iteration, objective);
    w->last = objective;
    if (++w->calls == w->cancel_at) w->cancel = 1;
}

static void progress_is_called(void)
{
    const fit_surface s = surface_of("ggx+lambert");
    ff_table t = table_of(&s, 60000, 0.05);
    ff_fit_options o = fit_options();
    watcher w = {0};
    ff_fit_result r;
    ff_error err = {0};
    o.progress = watch;
    o.progress_context = &w;
    const ff_status status = fit_table(&t, &s.model, &o, &r, NULL, &err);
    FF_CHECK(status == FF_OK, "%s", err.message);
    if (!status) {
        FF_CHECK(w.calls > r.iterations, "%d calls in %d iterations", w.calls, r.iterations);
        FF_CHECK_CLOSE(w.last, r.residual.objective, 1e-6, 0);
        ff_fit_result_clear(&r);
    }
    ff_table_clear(&t);
}

static void cancelled_by_the_callback(void)
{
    const fit_surface s = surface_of("ggx+lambert");
    ff_table t = table_of(&s, 3000, 0.02);
    for (size_t i = 0; i < 3 * t.n; i++) t.value[i] *= 1e6; /* a fit of many steps, as for the limit */
    ff_fit_options o = fit_options();
    for (int at = 1; at < 4; at++) {
        watcher w = {.cancel_at = at};
        o.progress = watch;
        o.progress_context = &w;
        o.cancel = &w.cancel;
        ff_fit_result r = {0};
        ff_error err = {0};
        const ff_status status = fit_table(&t, &s.model, &o, &r, NULL, &err);
        FF_CHECK(status == FF_ERR_CANCELLED && err.code == FF_ERR_CANCELLED && w.calls == at,
                 "cancelled at call %d: %s after %d calls", at, ff_status_str(status), w.calls);
        FF_CHECK(r.shape_value == NULL, "the result was written");
    }
    ff_table_clear(&t);
}

static void cancelled_before(void)
{
    static const char *const models[] = {"ggx+lambert", "phong", "lambert"};
    for (size_t k = 0; k < 3; k++) {
        const fit_surface s = fit_surface_make(models[k], 3, "");
        ff_table t = table_of(&s, 2000, 0);
        const volatile int cancel = 1;
        ff_fit_options o = fit_options();
        o.cancel = &cancel;
        check_refused(models[k], &t, &s.model, &o, FF_ERR_CANCELLED, "cancelled");
        o.start_shape = s.shape; /* without the search of a start */
        o.start_channel = s.channel;
        check_refused(models[k], &t, &s.model, &o, FF_ERR_CANCELLED, "cancelled");
        ff_table_clear(&t);
    }
}

/* As a signal handler or another thread would: at any moment, by one store. */
static void *set_later(void *context)
{
    const struct timespec delay = {.tv_nsec = 15000000};
    nanosleep(&delay, NULL);
    __atomic_store_n((int *)context, 1, __ATOMIC_RELAXED);
    return NULL;
}

static void cancelled_by_another_thread(void)
{
    const fit_surface s = surface_of("student-t+lambert");
    ff_table t = table_of(&s, 50000, 0.05);
    for (int round = 0; round < 4; round++) {
        int cancel = 0;
        pthread_t thread;
        ff_fit_options o = fit_options();
        ff_fit_result r;
        ff_error err = {0};
        ff_problem *p = NULL;
        ff_status status = ff_problem_make(&t, &s.model, 1, &o, &p, &err);
        FF_CHECK(status == FF_OK, "%s", err.message);
        o.cancel = &cancel;
        if (status || pthread_create(&thread, NULL, set_later, &cancel)) break;
        for (int fits = 0; fits < 1000 && (status = ff_problem_fit_into(p, &s.model, &o, &r, &err)) == FF_OK;
             fits++) /* until the store is seen */
            ff_fit_result_clear(&r);
        pthread_join(thread, NULL);
        FF_CHECK(status == FF_ERR_CANCELLED, "%s: %s", ff_status_str(status), err.message);
        /* the problem is as good as before */
        o.cancel = NULL;
        status = ff_problem_fit_into(p, &s.model, &o, &r, &err);
        FF_CHECK(status == FF_OK && r.outcome == FF_CONVERGED, "after a cancelled fit: %s", ff_status_str(status));
        if (!status) ff_fit_result_clear(&r);
        ff_problem_free(p);
    }
    ff_table_clear(&t);
}

/* ---- several models, several problems -------------------------------------------------------- */

/* A problem made for many models gives each what a problem of its own gives. */
static void many_models_on_one_problem(void)
{
    static const char *const names[] = {"ggx+lambert", "beckmann/v-cavity+lambert", "phong/smith-separable+lambert",
                                        "student-t/none", "lambert"};
    enum { N = sizeof names / sizeof *names };
    const fit_surface s = surface_of("ggx+lambert");
    ff_table t = table_of(&s, 5000, 0.05);
    ff_model models[N];
    ff_fit_options o = fit_options();
    ff_problem *p = NULL;
    ff_error err = {0};
    for (size_t k = 0; k < N; k++) models[k] = fit_surface_make(names[k], 3, "").model;
    ff_status status = ff_problem_make(&t, models, N, &o, &p, &err);
    FF_CHECK(status == FF_OK, "%s", err.message);
    for (size_t k = 0; k < N && !status; k++) {
        ff_fit_result a = {0}, b = {0};
        const ff_status together = ff_problem_fit_into(p, &models[k], &o, &a, &err),
                        alone = fit_table(&t, &models[k], &o, &b, NULL, &err);
        FF_CHECK(together == FF_OK && alone == FF_OK, "%s: %s", names[k], err.message);
        if (!together && !alone) FF_CHECK_CLOSE(a.residual.objective, b.residual.objective, 1e-9, 0);
        ff_fit_result_clear(&a);
        ff_fit_result_clear(&b);
    }
    ff_problem_free(p);
    ff_table_clear(&t);
}

FF_TEST_MAIN(FF_TEST(fewer_values_than_parameters), FF_TEST(one_sample), FF_TEST(nothing_usable), FF_TEST(zero_channels),
             FF_TEST(values_that_are_none), FF_TEST(sigmas_that_are_none), FF_TEST(the_same_sample_again_and_again),
             FF_TEST(every_size_of_a_last_block), FF_TEST(extreme_scales), FF_TEST(values_of_no_surface), FF_TEST(wrong_options),
             FF_TEST(wrong_options_of_the_fit), FF_TEST(combinations_without_meaning),
             FF_TEST(model_that_the_problem_was_not_made_for), FF_TEST(limit_of_iterations), FF_TEST(no_standard_errors),
             FF_TEST(progress_is_called), FF_TEST(cancelled_by_the_callback), FF_TEST(cancelled_before),
             FF_TEST(cancelled_by_another_thread), FF_TEST(many_models_on_one_problem))
