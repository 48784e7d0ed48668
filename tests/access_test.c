/* What programs of others read by functions is what the project reads in its structs: the same fits, comparisons and tables through
 * both doors. Correlations are read from two storages, the whole matrix and that of many channels, which have to agree. */
#include "fit_samples.h"
#include "data_formats/analysis/spectral_struct.h"
#include "data_formats/interpolation/resample_struct.h"
#include "fit/picture/picture_struct.h"
#include "fit/trust/trust_struct.h"

enum { CHANNELS = 4 };

static fit_surface surface(void)
{
    fit_surface s = fit_surface_make("ggx+lambert", CHANNELS, "alpha=0.3 f0=0.4");
    const uint32_t kd = ff_model_param_find(&s.model, "kd").index;
    for (size_t c = 0; c < CHANNELS; c++) s.channel[c * s.model.n_channel + kd] = 0.1 + 0.1 * (double)c;
    return s;
}

static ff_table measured(const fit_surface *s)
{
    const fit_sampling how = {.n = 3000, .max_theta = 75, .glossy = 0.4, .noise = 0.02, .seed = 11};
    return fit_measure(s, &how);
}

static ff_fit_options isotropic(void)
{
    ff_fit_options o = fit_options();
    o.shape = FF_SHAPE_ISOTROPIC;
    return o;
}

/* A fit with its problem, as others make them. */
typedef struct made {
    ff_problem *problem;
    ff_fit_result *fit;
} made;

static made fit_of(const ff_table *t, const ff_model *m, const ff_fit_options *o)
{
    made f = {NULL, NULL};
    ff_error err = {0};
    const ff_model *models[] = {m};
    ff_status status = ff_problem_new(t, models, 1, o, &f.problem, &err);
    if (!status) status = ff_problem_fit(f.problem, m, o, &f.fit, &err);
    FF_CHECK(status == FF_OK, "%s", err.message);
    if (status) exit(1);
    return f;
}

static void free_made(made *f)
{
    ff_fit_result_free(f->fit);
    ff_problem_free(f->problem);
}

/* ---- results --------------------------------------------------------------------------------- */

static void numbers_of_a_result(void)
{
    const fit_surface s = surface();
    ff_table t = measured(&s);
    const ff_fit_options o = isotropic();
    made f = fit_of(&t, &s.model, &o);
    const ff_fit_result *r = f.fit;
    double shape[FF_MAX_SHAPE], channel[CHANNELS * FF_MAX_CHANNEL_PARAMS];
    ff_fit_result_values(r, shape, channel);
    ff_fit_result_values(r, NULL, NULL);
    for (uint32_t k = 0; k < s.model.n_shape; k++) {
        const ff_param_ref at = {FF_PARAM_SHAPE, k};
        FF_CHECK(ff_fit_result_at(r, at, 99) == &r->shape_value[k] && shape[k] == r->shape_value[k].value, "shape %u", k);
        FF_CHECK(ff_fit_result_find(r, s.model.shape[k].name, 0) == &r->shape_value[k], "%s", s.model.shape[k].name);
    }
    for (size_t i = 0; i < CHANNELS * s.model.n_channel; i++) {
        const ff_param_ref at = {FF_PARAM_CHANNEL, (uint32_t)(i % s.model.n_channel)};
        const size_t c = i / s.model.n_channel;
        FF_CHECK(ff_fit_result_at(r, at, c) == &r->channel_value[i] && channel[i] == r->channel_value[i].value, "channel value %zu",
                 i);
    }
    FF_CHECK(!ff_fit_result_at(r, (ff_param_ref){FF_PARAM_CHANNEL, 0}, CHANNELS), "a channel too many");
    FF_CHECK(!ff_fit_result_at(r, (ff_param_ref){FF_PARAM_SHAPE, s.model.n_shape}, 0), "a parameter too many");
    FF_CHECK(!ff_fit_result_at(r, (ff_param_ref){FF_PARAM_NONE, 0}, 0) && !ff_fit_result_find(r, "alpha_z", 0), "no parameter");
    FF_CHECK(ff_fit_result_rmse(r) == r->residual.rmse && ff_fit_result_max_abs(r) == r->residual.max_abs, "residuals");
    for (int loss = 0; loss < FF_LOSS_COUNT; loss++) {
        const double known = r->residual.loss_rmse[loss], said = ff_fit_result_loss_rmse(r, (ff_loss)loss);
        FF_CHECK(known == said || (isnan(known) && isnan(said)), "%s", ff_loss_name(loss));
    }
    FF_CHECK(isnan(ff_fit_result_loss_rmse(r, (ff_loss)FF_LOSS_COUNT)), "a loss too many");
    FF_CHECK(ff_fit_result_aic(r) == r->aic && ff_fit_result_bic(r) == r->bic && ff_fit_result_rank(r) == r->rank &&
                 ff_fit_result_condition(r) == r->condition && ff_fit_result_effective_samples(r) == r->effective_samples,
             "what the data can tell");
    FF_CHECK(ff_problem_selected(f.problem)->used == 3000 && ff_problem_selected(f.problem)->n_channels == CHANNELS, "selection");
    free_made(&f);
    ff_table_clear(&t);
}

/* Every pair of parameters that is stored both ways. */
static void correlations_of_two_storages(void)
{
    const fit_surface s = surface();
    ff_table t = measured(&s);
    ff_fit_options whole = isotropic(), by_channel = isotropic();
    whole.dense_channels = 1000;
    by_channel.dense_channels = 0;
    made a = fit_of(&t, &s.model, &whole), b = fit_of(&t, &s.model, &by_channel);
    FF_CHECK(!a.fit->channel_correlation && b.fit->channel_correlation, "the storages are the same");
    const ff_param_ref alpha = ff_model_param_find(&s.model, "alpha_x"), f0 = ff_model_param_find(&s.model, "f0"),
                       kd = ff_model_param_find(&s.model, "kd"), ks = ff_model_param_find(&s.model, "ks");
    const struct {
        ff_param_ref one, other;
    } pair[] = {{alpha, alpha}, {alpha, f0}, {f0, alpha}, {alpha, kd}, {kd, alpha}, {f0, kd}, {kd, f0}, {kd, kd}};
    for (size_t c = 0; c < CHANNELS; c++)
        for (size_t k = 0; k < sizeof pair / sizeof *pair; k++) {
            const double x = ff_fit_result_correlation(a.fit, pair[k].one, c, pair[k].other, c),
                         y = ff_fit_result_correlation(b.fit, pair[k].one, c, pair[k].other, c);
            FF_CHECK(fabs(x) <= 1 + 1e-9 && fabs(x - y) < 1e-4, "channel %zu, pair %zu: %g and %g", c, k, x, y);
        }
    FF_CHECK(fabs(ff_fit_result_correlation(a.fit, f0, 1, f0, 1) - 1) < 1e-9, "a parameter with itself");
    FF_CHECK(isfinite(ff_fit_result_correlation(a.fit, f0, 0, f0, 2)), "between channels: they are in the whole matrix");
    FF_CHECK(isnan(ff_fit_result_correlation(b.fit, f0, 0, f0, 2)), "between channels: not formed");
    for (int k = 0; k < 2; k++) {
        const ff_fit_result *r = k ? b.fit : a.fit;
        FF_CHECK(isnan(ff_fit_result_correlation(r, ks, 0, f0, 0)) && isnan(ff_fit_result_correlation(r, alpha, 0, ks, 0)),
                 "one that is held");
        FF_CHECK(isnan(ff_fit_result_correlation(r, (ff_param_ref){FF_PARAM_NONE, 0}, 0, f0, 0)), "one that there is not");
    }
    free_made(&a);
    free_made(&b);
    ff_table_clear(&t);
}

/* ---- what is told of fits -------------------------------------------------------------------- */

static void comparisons(void)
{
    enum { FITS = 2 };
    const fit_surface s = surface();
    ff_table t = measured(&s);
    const ff_fit_options o = isotropic();
    ff_error err = {0};
    ff_model models[FITS];
    ff_fit_result fit[FITS];
    ff_versus by_value[FITS], by_pointer[FITS];
    ff_problem *p;
    ff_places *places;
    if (ff_model_parse("ggx+lambert", &models[0], &err) || ff_model_parse("beckmann+lambert", &models[1], &err) ||
        ff_problem_new(&t, (const ff_model *const[]){&models[0], &models[1]}, FITS, &o, &p, &err) ||
        ff_problem_fit_into(p, &models[0], &o, &fit[0], &err) || ff_problem_fit_into(p, &models[1], &o, &fit[1], &err) ||
        ff_places_new(p, &t, &places, &err)) {
        FF_CHECK(0, "%s", err.message);
        return;
    }
    const ff_fit_result *fits[] = {&fit[0], &fit[1]};
    FF_CHECK(ff_trust_compare_into(p, places, &o, fit, FITS, 0, 0, by_value, &err) == FF_OK, "%s", err.message);
    FF_CHECK(ff_trust_compare(p, places, &o, fits, FITS, 0, 0, by_pointer, &err) == FF_OK, "%s", err.message);
    FF_CHECK(by_value[1].objective == by_pointer[1].objective && by_value[1].vuong_z == by_pointer[1].vuong_z &&
                 by_pointer[1].objective > 0,
             "%g and %g", by_value[1].objective, by_pointer[1].objective);
    FF_CHECK(ff_places_group_count(places) == places->n_groups && ff_places_direction_count(places) == places->n_directions &&
                 ff_places_grouping(places) == places->kind,
             "places");
    ff_cut_off *cut;
    FF_CHECK(ff_trust_cut_off(p, &o, &fit[0], 60 * FIT_DEGREE, &cut, &err) == FF_OK && cut->used < 3000 &&
                 cut->n_columns == fit[0].n_columns,
             "%s", err.message);
    ff_cut_off_free(cut);
    ff_difference difference;
    /* the mean of two equal vectors is off by a few roundings, 1e-14 of a value that is up to 1e5 of its errors */
    FF_CHECK(ff_trust_channels_differ((const ff_fit_result *const[]){&fit[0], &fit[0]}, 2, &difference, &err) == FF_OK &&
                 fabs(difference.chi2) < 1e-18,
             "a fit differs from itself: chi2 %g", difference.chi2);
    ff_outliers outliers = {.size = sizeof outliers};
    FF_CHECK(ff_trust_outliers(p, places, &o, &fit[0], &outliers, &err) == FF_ERR_UNSUPPORTED, "outliers without a robust loss");
    outliers.size = 5;
    FF_CHECK(ff_trust_outliers(p, places, &o, &fit[0], &outliers, &err) == FF_ERR_RANGE, "five bytes of outliers");
    for (size_t k = 0; k < FITS; k++) ff_fit_result_clear(&fit[k]);
    ff_places_free(places);
    ff_problem_free(p);
    ff_table_clear(&t);
}

static void losses_by_pictures(void)
{
    const fit_surface s = surface();
    ff_table t = measured(&s);
    const ff_fit_options o = isotropic();
    ff_adaptive *a;
    ff_error err = {0};
    FF_CHECK(ff_fit_adaptive(&t, &s.model, &o, &a, &err) == FF_OK, "%s", err.message);
    if (err.message[0]) return;
    const size_t chosen = ff_adaptive_chosen(a);
    FF_CHECK(ff_adaptive_count(a) == a->n && chosen < a->n && ff_adaptive_fit(a, chosen) == &a->candidate[chosen].fit &&
                 ff_adaptive_loss(a, chosen) == a->candidate[chosen].loss && ff_adaptive_problem(a) == a->problem &&
                 ff_adaptive_coverage(a).pixels == a->coverage.pixels,
             "the chosen one");
    for (size_t k = 0; k < ff_adaptive_count(a); k++)
        FF_CHECK(ff_adaptive_difference(a, k) >= ff_adaptive_difference(a, chosen) - FF_PICTURE_SAME, "candidate %zu is better", k);
    ff_adaptive_free(a);
    ff_table_clear(&t);
}

/* ---- tables ---------------------------------------------------------------------------------- */

static void planes_of_a_table(void)
{
    ff_table *t, *copy, *merl;
    ff_error err = {0};
    char text[64];
    ff_hint hint;
    FF_CHECK(ff_table_new(0, 1, 0, 0, &t, &err) == FF_ERR_RANGE, "a table of nothing");
    FF_CHECK(ff_table_new(7, 2, 1, 1, &t, &err) == FF_OK, "%s", err.message);
    for (size_t c = 0; c < 2; c++)
        FF_CHECK(ff_table_value_plane(t, c) == t->value + 7 * c && ff_table_sigma_plane(t, c) == t->sigma + 7 * c, "channel %zu",
                 c);
    for (int k = 0; k < 4; k++) FF_CHECK(ff_table_angle_plane(t, k) == t->angle[k] && t->angle[k], "angle %d", k);
    FF_CHECK(!ff_table_value_plane(t, 2) && !ff_table_sigma_plane(t, 2) && !ff_table_angle_plane(t, 4) &&
                 !ff_table_angle_plane(t, -1) && !ff_table_channel(t, 2),
             "planes that there are not");
    FF_CHECK(ff_table_set_channel(t, 1, "465nm", 465, 2) == FF_OK && ff_table_channel_find(t, "465nm") == 1, "channel");
    FF_CHECK(ff_table_set_channel(t, 2, "r", NAN, 1) == FF_ERR_RANGE && ff_table_set_channel(t, 0, "r", NAN, 0) == FF_ERR_RANGE &&
                 ff_table_set_angle_unit(t, 0) == FF_ERR_RANGE && ff_table_set_angle_unit(t, NAN) == FF_ERR_RANGE,
             "what makes no sense");
    ff_table_value_plane(t, 1)[3] = 0.5;
    ff_table_sigma_plane(t, 1)[3] = 0.25;
    ff_table_weight_plane(t)[3] = 4;
    ff_table_valid_plane(t)[2] = 0;
    double value, sigma, weight;
    unsigned char valid[2];
    ff_table_values(t, 1, 3, 1, &value);
    ff_table_sigmas(t, 1, 3, 1, &sigma);
    ff_table_weights(t, 3, 1, &weight);
    ff_table_valid(t, 2, 2, valid);
    FF_CHECK(value == 1 && sigma == 0.5 && weight == 4 && !valid[0] && valid[1], "%g +- %g, weight %g", value, sigma, weight);
    FF_CHECK(ff_table_has_sigmas(t) && ff_table_has_weights(t) && !ff_table_grid(t) && !ff_table_is_isotropic(t), "what it has");
    FF_CHECK(!ff_table_assumption(t, 0, text, sizeof text, &hint), "an assumption of nobody");
    FF_CHECK(ff_table_copy(t, &copy, &err) == FF_OK && ff_table_samples(copy) == 7 && ff_table_channel_count(copy) == 2 &&
                 ff_table_value_plane(copy, 1)[3] == 0.5,
             "copy");
    const ff_grid *grid = ff_grid_find("merl");
    FF_CHECK(grid == &ff_grid_merl && !ff_grid_find("goniometer") && ff_grid_samples(grid) == 1458000, "grids");
    FF_CHECK(ff_table_new_on_grid(grid, 1, 0, &merl, &err) == FF_OK && ff_table_grid(merl) == grid &&
                 !ff_table_angle_plane(merl, 0) && !ff_table_sigma_plane(merl, 0) && ff_table_is_isotropic(merl),
             "a table on a grid");
    ff_table_free(merl);
    ff_table_free(copy);
    ff_table_free(t);
    ff_table_free(NULL);
}

static void formats_by_functions(void)
{
    for (size_t i = 0; i < ff_format_count(); i++) {
        const ff_format *f = ff_format_at(i);
        FF_CHECK(ff_format_find(ff_format_name(f)) == f && ff_format_title(f)[0] && ff_format_source(f)[0], "%s", f->name);
        FF_CHECK(ff_format_can_write(f) == (f->write != NULL) && ff_format_reads(f) == f->reads, "%s", f->name);
        FF_CHECK(ff_format_holds(f) == (f->write ? f->holds : 0) && ff_format_precision(f) == f->precision, "%s", f->name);
        FF_CHECK(ff_format_extensions(f) == f->extensions, "%s", f->name);
    }
}

/* ---- models ---------------------------------------------------------------------------------- */

static void models_on_the_heap(void)
{
    ff_model *m = NULL, *copy;
    ff_error err = {0};
    FF_CHECK(ff_model_new("gxg", &m, &err) == FF_ERR_UNKNOWN && !m && err.message[0], "an unknown model");
    FF_CHECK(ff_model_new("ggx+beckmann+lambert", &m, &err) == FF_OK && ff_model_lobe_count(m) == 2, "%s", err.message);
    FF_CHECK(ff_model_hold(m, "lobe2.alpha", 0.5, &err) == FF_OK && ff_model_copy(m, &copy, &err) == FF_OK, "%s", err.message);
    FF_CHECK(ff_model_vary(m, "lobe2.alpha", &err) == FF_OK, "%s", err.message);
    const ff_param_ref at = ff_model_param_find(m, "lobe2.alpha_x");
    FF_CHECK(ff_model_param_at(copy, at)->flags & FF_PARAM_HELD && ff_model_param_at(copy, at)->init == 0.5, "held in the copy");
    FF_CHECK(!(ff_model_param_at(m, at)->flags & FF_PARAM_HELD), "free in the first");
    FF_CHECK(ff_model_param_count(m, FF_PARAM_SHAPE) == m->n_shape && ff_model_param_count(m, FF_PARAM_CHANNEL) == m->n_channel &&
                 ff_model_param_count(m, FF_PARAM_NONE) == 0,
             "counts");
    ff_model_free(copy);
    ff_model_free(m);
    ff_model_free(NULL);
}

FF_TEST_MAIN(FF_TEST(numbers_of_a_result), FF_TEST(correlations_of_two_storages), FF_TEST(comparisons), FF_TEST(losses_by_pictures),
             FF_TEST(planes_of_a_table), FF_TEST(formats_by_functions), FF_TEST(models_on_the_heap))
