/* Real measurements: every goniometer file of data/astm and three MERL materials give finite, plausible parameters under every
 * distribution and masking. Prints what came out. Two files made here, with a goniometer's grid and faults, are asked the same. */
#include "instrument.h"
#include "models/internal_model.h"
#include <dirent.h>

enum { MAX_TERMS = 16, MAX_FILES = 64 };

/* A line of the table, and what is asked of a file. */
typedef struct material {
    char name[64], path[1024];
    int glossy; /* a metal or a glossy paint: its roughness must be off the bounds */
} material;

/* ---- one result ------------------------------------------------------------------------------ */

static void check_fit(const char *what, const ff_fit_result *r)
{
    FF_CHECK(r->outcome == FF_CONVERGED, "%s: %s after %d iterations", what, ff_outcome_name((int)r->outcome), r->iterations);
    for (size_t k = 0; k < fit_parameter_count(r); k++) {
        char name[64];
        double truth;
        const ff_fit_value *v = fit_parameter(r, k, NULL, &truth, name);
        const ff_param *info =
            k < r->model.n_shape ? r->model.shape[k].info : r->model.channel[(k - r->model.n_shape) % r->model.n_channel].info;
        if (!v) continue;
        FF_CHECK(v->value >= info->lo && v->value <= info->hi, "%s: %s = %g is outside its box", what, name, v->value);
        if (k >= r->model.n_shape) FF_CHECK(v->value >= 0 && v->value <= 1, "%s: %s = %g", what, name, v->value);
        if (v->at_bound)
            FF_CHECK(isnan(v->std_error), "%s: %s is on its bound and has an error", what, name);
        else
            FF_CHECK(isfinite(v->std_error) && v->std_error > 0, "%s: %s = %g has standard error %g", what, name, v->value,
                     v->std_error);
    }
    const ff_residual *e = &r->residual;
    const double all[] = {e->objective, e->rmse, e->cosine_rmse, e->log_rmse, e->cube_root_rmse, e->max_abs, r->aic, r->bic};
    for (size_t k = 0; k < sizeof all / sizeof *all; k++)
        FF_CHECK(isfinite(all[k]) && (k > 5 || all[k] > 0), "%s: residual %zu is %g", what, k, all[k]);
}

static void print_fit(const material *file, const ff_fit_result *r, const ff_selection *sel)
{
    char roughness[128] = "";
    for (uint32_t k = 0; k < r->model.n_shape; k++) {
        const ff_fit_value *v = &r->shape_value[k];
        if (!v->held && !v->tied)
            snprintf(roughness + strlen(roughness), sizeof roughness - strlen(roughness), " %s %.4f +- %.4f",
                     r->model.shape[k].name, v->value, v->std_error);
    }
    printf("%-22s %7zu used,%s", file->name, sel->used, roughness);
    for (uint32_t k = 0; k < r->model.n_channel; k++) {
        printf(", %s", r->model.channel[k].name);
        for (size_t c = 0; c < r->n_channels; c++)
            printf(" %.3f%s", r->channel_value[c * r->model.n_channel + k].value,
                   r->channel_value[c * r->model.n_channel + k].at_bound ? "*" : "");
    }
    printf(", log rmse %.3g, %.0f ms\n", r->residual.log_rmse, 1e3 * r->time_s);
}

/* ---- one file -------------------------------------------------------------------------------- */

enum { DISTRIBUTIONS = 4 };

static size_t all_models(ff_model *out, size_t *n_maskings)
{
    size_t n = 0;
    *n_maskings = 0;
    for (size_t d = 0; d < ff_term_count(FF_NDF); d++)
        for (size_t m = 0; m < ff_term_count(FF_MASKING); m++) {
            const ff_term *masking = ff_term_at(FF_MASKING, m);
            /* those that go with every distribution of normals; and not every distribution: a file takes seconds already */
            if ((masking->claims & (FF_FURNACE_ONLY | FF_ISOTROPIC)) || ff_masking_at((int)m)->only || d >= DISTRIBUTIONS) continue;
            const ff_status status = ff_model_compose((int)d, (int)m, ff_term_find(FF_FRESNEL, "schlick"),
                                                      ff_term_find(FF_DIFFUSE, "lambert"), &out[n], NULL);
            n += status == FF_OK;
            FF_CHECK(status == FF_OK, "distribution %zu, masking %zu: %s", d, m, ff_status_str(status));
            if (d == 0) (*n_maskings)++;
        }
    return n;
}

static void print_objectives(const ff_model *models, size_t n, size_t n_maskings, const double *objective)
{
    size_t best = 0;
    for (size_t i = 1; i < n; i++)
        if (objective[i] < objective[best]) best = i;
    for (size_t i = 0; i < n; i += n_maskings) {
        printf("    %-10s", ff_term_at(FF_NDF, (size_t)models[i].lobe[0].ndf)->name);
        for (size_t k = i; k < i + n_maskings; k++) printf(" %9.4f%c", objective[k] / objective[best], k == best ? '<' : ' ');
        printf("\n");
    }
}

static void fit_file(const material *file, const ff_table *t)
{
    ff_model models[MAX_TERMS * MAX_TERMS];
    double objective[MAX_TERMS * MAX_TERMS];
    size_t n_maskings;
    const size_t n = all_models(models, &n_maskings);
    const ff_fit_options o = fit_options();
    ff_problem *p = NULL;
    ff_selection sel;
    ff_error err = {0};
    ff_status status = ff_problem_make(t, models, n, &o, &p, &err);
    FF_CHECK(status == FF_OK, "%s: %s", file->name, err.message);
    if (status) return;
    ff_problem_selection(p, &sel);
    FF_CHECK(sel.used > 0 && sel.used + sel.invalid + sel.below_horizon + sel.grazing == sel.samples,
             "%s: the counts do not add up", file->name);
    for (size_t i = 0; i < n; i++) {
        char what[FF_MODEL_NAME + 80], expression[FF_MODEL_NAME];
        ff_fit_result r;
        ff_model_expression(&models[i], expression, sizeof expression);
        snprintf(what, sizeof what, "%s, %s", file->name, expression);
        status = ff_problem_fit_into(p, &models[i], &o, &r, &err);
        FF_CHECK(status == FF_OK, "%s: %s", what, err.message);
        objective[i] = INFINITY;
        if (status) continue;
        objective[i] = r.residual.objective;
        check_fit(what, &r);
        if (strcmp(expression, "ggx/smith-height-correlated/schlick+lambert") == 0) {
            print_fit(file, &r, &sel);
            FF_CHECK(!file->glossy || r.shape_value[0].at_bound == 0, "%s: alpha %g is on its bound", what, r.shape_value[0].value);
            FF_CHECK(!file->glossy || (r.shape_value[0].value > 0.01 && r.shape_value[0].value < 1), "%s: alpha is %g", what,
                     r.shape_value[0].value);
        }
        ff_fit_result_clear(&r);
    }
    print_objectives(models, n, n_maskings, objective);
    ff_problem_free(p);
}

static void read_and_fit(const material *file)
{
    ff_table t;
    ff_error err = {0};
    const ff_status status = ff_table_read_into(file->path, NULL, &t, &err);
    FF_CHECK(status == FF_OK, "%s: %s", file->path, err.message);
    if (status) return;
    fit_file(file, &t);
    ff_table_clear(&t);
}

/* ---- is the start good enough? --------------------------------------------------------------- */

/* Fits from starts spread over the roughness: none may end lower than the search for a start did. */
static void no_start_does_better(const material *file, const ff_table *t, const char *expression)
{
    static const double alpha[] = {0.003, 0.01, 0.03, 0.1, 0.3, 0.8};
    for (int loss = 0; loss < FF_LOSS_COUNT; loss++) {
        fit_surface from = fit_surface_make(expression, t->n_channels, "f0=0.04");
        ff_fit_options o = fit_options();
        ff_problem *p = NULL;
        ff_fit_result r;
        ff_error err = {0};
        o.loss = (ff_loss)loss;
        o.std_errors = 0;
        ff_status status = ff_problem_make(t, &from.model, 1, &o, &p, &err);
        if (!status) status = ff_problem_fit_into(p, &from.model, &o, &r, &err);
        FF_CHECK(status == FF_OK, "%s, %s, %s: %s", file->name, expression, ff_loss_name(loss), err.message);
        double searched = 0, best = INFINITY, best_from = 0, best_alpha = 0, searched_alpha = 0;
        if (!status) {
            searched = r.residual.objective;
            searched_alpha = r.shape_value[0].value;
            ff_fit_result_clear(&r);
        }
        o.start_shape = from.shape;
        o.start_channel = from.channel;
        for (size_t k = 0; k < sizeof alpha / sizeof *alpha && !status; k++) {
            from.shape[0] = from.shape[1] = alpha[k];
            if (ff_problem_fit_into(p, &from.model, &o, &r, &err)) continue;
            if (r.residual.objective < best) {
                best = r.residual.objective;
                best_from = alpha[k];
                best_alpha = r.shape_value[0].value;
            }
            ff_fit_result_clear(&r);
        }
        FF_CHECK(status || searched <= best * (1 + 1e-6),
                 "%s, %s, %s: the search leads to alpha %g, objective %.6g; a start at alpha = %g leads to alpha %g, objective "
                 "%.6g (%.3f of it)",
                 file->name, expression, ff_loss_name(loss), searched_alpha, searched, best_from, best_alpha, best,
                 best / searched);
        ff_problem_free(p);
    }
}

/* Of a full grid every 37th valid sample is enough here. */
static void thin_out(ff_table *t)
{
    size_t valid = 0;
    for (size_t i = 0; i < t->n && t->n > 100000; i++)
        if (t->valid[i]) t->valid[i] = valid++ % 37 == 0;
}

static void read_and_restart(const material *file)
{
    static const char *const models[] = {"ggx+lambert", "beckmann/v-cavity+lambert"};
    ff_table t;
    ff_error err = {0};
    const ff_status status = ff_table_read_into(file->path, NULL, &t, &err);
    FF_CHECK(status == FF_OK, "%s: %s", file->path, err.message);
    if (status) return;
    thin_out(&t);
    for (size_t k = 0; k < sizeof models / sizeof *models; k++) no_start_does_better(file, &t, models[k]);
    ff_table_clear(&t);
}

/* ---- the files ------------------------------------------------------------------------------- */

static void print_heading(void)
{
    printf("ggx+lambert of each file (* on a bound), then the objective of every distribution over the best, maskings:\n           "
           "   ");
    for (size_t m = 0; m < ff_term_count(FF_MASKING); m++)
        if (!(ff_term_at(FF_MASKING, m)->claims & FF_FURNACE_ONLY)) printf(" %s", ff_term_at(FF_MASKING, m)->name);
    printf("\n");
}

static int by_name(const void *a, const void *b)
{
    return strcmp(((const material *)a)->name, ((const material *)b)->name);
}

/* The goniometer files, by name; their number. */
static size_t astm_files(material *file)
{
    static const char *const metals[] = {"C10_Copper.astm", "C8_Silver.astm", "C9_Gold.astm", "Metal_Blue.astm"};
    char folder[512];
    size_t n = 0;
    DIR *d = ff_test_shared("data/astm", folder, sizeof folder) ? opendir(folder) : NULL;
    if (!d) return 0;
    for (const struct dirent *e = readdir(d); e && n < MAX_FILES; e = readdir(d)) {
        const size_t length = strlen(e->d_name);
        if (length < 6 || strcmp(e->d_name + length - 5, ".astm") != 0) continue;
        file[n] = (material){.glossy = 0};
        snprintf(file[n].name, sizeof file[n].name, "%.63s", e->d_name);
        snprintf(file[n].path, sizeof file[n].path, "%s/%s", folder, e->d_name);
        for (size_t k = 0; k < sizeof metals / sizeof *metals; k++) file[n].glossy |= strcmp(e->d_name, metals[k]) == 0;
        n++;
    }
    closedir(d);
    qsort(file, n, sizeof *file, by_name);
    return n;
}

/* Makes a material's file once, beside the test. 0 when numpy or the network's weights are missing. */
static int make_merl(const char *tool, const char *name, const char *path)
{
    static const char *const pythons[] = {"python3", "/usr/bin/python3"};
    char command[2048];
    for (size_t k = 0; k < 2 && access(path, R_OK) != 0; k++) {
        snprintf(command, sizeof command, "%s '%s' %s %s 2>/dev/null", pythons[k], tool, name, path);
        if (system(command) != 0) continue;
    }
    return access(path, R_OK) == 0;
}

/* The three MERL materials; fewer when they cannot be made. */
static size_t merl_files(material *file)
{
    static const char *const names[] = {"gold-metallic-paint", "red-fabric", "blue-acrylic"};
    char tool[512];
    size_t n = 0;
    if (!ff_test_shared("tools/make_merl.py", tool, sizeof tool)) return 0;
    for (size_t i = 0; i < 3; i++) {
        file[n] = (material){.glossy = i != 1};
        snprintf(file[n].name, sizeof file[n].name, "%s", names[i]);
        snprintf(file[n].path, sizeof file[n].path, "made-%s.binary", names[i]);
        n += (size_t)make_merl(tool, names[i], file[n].path);
    }
    return n;
}

static material file[MAX_FILES];

/* A metal and a matte paint as a goniometer would see them; 2. */
static size_t made_files(material *file)
{
    static const char *const names[] = {"metal", "paint"}, *const sets[] = {"alpha=0.15 f0=0.9:0.7:0.4 kd=0.01",
                                                                            "alpha=0.45 f0=0.04 kd=0.3:0.2:0.1"};
    for (size_t i = 0; i < 2; i++) {
        const fit_surface s = fit_surface_make("ggx+lambert", 3, sets[i]);
        char base[32];
        snprintf(base, sizeof base, "%s.astm", names[i]);
        file[i] = (material){.glossy = i == 0};
        snprintf(file[i].name, sizeof file[i].name, "%s", names[i]);
        snprintf(file[i].path, sizeof file[i].path, "%s", ff_test_path(base));
        instrument_write(file[i].path, &s, &(instrument_faults){.noise = 0.05, .offset = 5e-4, .horizon = 82}, names[i]);
    }
    return 2;
}

static void made(void)
{
    const size_t n = made_files(file);
    print_heading();
    for (size_t i = 0; i < n; i++) read_and_fit(&file[i]);
}

static void made_starts(void)
{
    const size_t n = made_files(file);
    for (size_t i = 0; i < n; i++) read_and_restart(&file[i]);
}

static void astm(void)
{
    const size_t n = astm_files(file);
    if (n == 0) FF_SKIP("no .astm file in data/astm");
    print_heading();
    for (size_t i = 0; i < n; i++)
        if (ff_test_turn(2, i, "fit")) read_and_fit(&file[i]);
}

static void merl(void)
{
    const size_t n = merl_files(file);
    if (n < 3) FF_SKIP("tools/make_merl.py made %zu of 3 files: it needs python3 with numpy and data/merl", n);
    print_heading();
    for (size_t i = 0; i < n; i++)
        if (ff_test_turn(3, i, "fit")) read_and_fit(&file[i]);
}

static void astm_starts(void)
{
    const size_t n = astm_files(file);
    if (n == 0) FF_SKIP("no .astm file in data/astm");
    for (size_t i = 0; i < n; i++)
        if (ff_test_turn(2, i, "starts")) read_and_restart(&file[i]);
}

static void merl_starts(void)
{
    const size_t n = merl_files(file);
    if (n < 3) FF_SKIP("tools/make_merl.py made %zu of 3 files: it needs python3 with numpy and data/merl", n);
    for (size_t i = 0; i < n; i++)
        if (ff_test_turn(3, i, "starts")) read_and_restart(&file[i]);
}

FF_TEST_MAIN(FF_TEST(made), FF_TEST(made_starts), FF_TEST(astm), FF_TEST(merl), FF_TEST(astm_starts), FF_TEST(merl_starts))
