/* What a figure is made of: files, results and models that the command line names, told apart and read. */
#include "internal_plotting.h"
#include "internal_rendering.h"
#include <stdlib.h>
#include <string.h>

enum { SHOWN_FITS = 7 };

/* "measured data, the result of a fit, or a model" */
static const char *wanted(const ff_plot_kind *kind, char *out, size_t size)
{
    const unsigned t = kind->takes;
    snprintf(out, size, "%s%s%s", t & (FF_PLOT_DATA | FF_PLOT_FITS) ? "a file of measured data" : "",
             t & (FF_PLOT_RESULTS | FF_PLOT_MODELS) && !(t & FF_PLOT_FRESH) ? (t & (FF_PLOT_DATA | FF_PLOT_FITS) ? ", or " : "")
                                                                            : "",
             t & FF_PLOT_FRESH     ? ""
             : t & FF_PLOT_MODELS  ? "models as ggx+lambert, or the JSON of 'fit'"
             : t & FF_PLOT_RESULTS ? "the JSON of 'fit' or 'compare'"
                                   : "");
    return out;
}

/* ---- models ---------------------------------------------------------------------------------- */

static int room_for(cli_subject *s, size_t models)
{
    s->model = calloc(models + 1, sizeof *s->model);
    s->label = calloc(models + 1, sizeof *s->label);
    return s->model && s->label ? EXIT_DONE : cli_failed(FF_ERR_MEMORY, NULL);
}

static ff_plot_model *new_model(cli_subject *s, const char *label)
{
    const size_t k = s->subject.n_models++;
    snprintf(s->label[k], sizeof s->label[k], "%s", label);
    s->model[k].label = s->label[k];
    s->subject.model = s->model;
    return &s->model[k];
}

static void add_fitted(cli_subject *s, ff_fitted *f, const char *label)
{
    if (s->tables.profile) ff_model_set_table(&f->model, s->tables.profile);
    ff_plot_model *m = new_model(s, label);
    *m = (ff_plot_model){m->label, &f->model,  f->n_channels, f->shape, f->channel, (const char(*)[FF_CHANNEL_NAME])f->channel_name,
                         f->noise, f->outcome, s->aperture};
}

/* The best, or with `all` the best seven. */
static int add_document(const cli_args *args, cli_subject *s, ff_fit_document *d, int all)
{
    if (cli_aperture(args, &d->aperture, &s->aperture) != EXIT_DONE) return EXIT_USAGE;
    int status = s->tables.profile ? EXIT_DONE : cli_tables_read(args, &s->tables);
    if (status != EXIT_DONE || (status = room_for(s, d->n_fits)) != EXIT_DONE) return status;
    for (size_t k = 0; k < d->n_fits && k < (all ? SHOWN_FITS : 1u); k++) {
        ff_fitted *f = &d->fit[d->rank[k]];
        ff_error err = {0};
        cli_tables own = s->tables;
        const ff_status failed = cli_tables_give(&own, &f->model, &err);
        if (failed != FF_OK) return cli_failed(failed, &err);
        add_fitted(s, f, f->expression);
    }
    s->subject.document = d;
    s->subject.max_theta = d->max_theta;
    return EXIT_DONE;
}

/* alpha of the first lobe, where it has one. */
static int set_roughness(cli_scene *scene, double alpha)
{
    char word[64], number[FF_REPORT_NUMBER];
    ff_error err = {0};
    snprintf(word, sizeof word, "alpha=%s", ff_report_number(alpha, number));
    const ff_status status = ff_model_set(&scene->model, scene->n_channels, word, scene->shape, scene->channel, &err);
    return status == FF_OK || status == FF_ERR_UNKNOWN ? EXIT_DONE : cli_failed(status, &err);
}

static int has_alpha(const ff_model *m)
{
    ff_model copy = *m;
    return ff_model_vary(&copy, "alpha", NULL) == FF_OK;
}

/* Models that a figure is of, by their words. */
typedef struct described {
    const char *expression, *own, *label;
    const ff_model *all; /* of the figure */
    size_t n_all;
} described;

/* The model once for each roughness; its label says what was varied. */
static int add_scenes(const cli_args *args, const ff_plot_choice *c, const described *of, cli_subject *s)
{
    const size_t n = c->n_roughness ? c->n_roughness : 1;
    if (!s->scene) return cli_failed(FF_ERR_MEMORY, NULL);
    for (size_t k = 0; k < n; k++) {
        cli_scene *scene = &s->scene[s->n_scenes];
        char text[FF_FIGURE_TEXT], number[FF_REPORT_NUMBER];
        int status = cli_scene_make_among(args, of->expression, of->own, of->all, of->n_all, scene);
        if (status != EXIT_DONE) return status;
        s->n_scenes++;
        const int varied = c->n_roughness && has_alpha(&scene->model);
        if (varied && (status = set_roughness(scene, c->roughness[k])) != EXIT_DONE) return status;
        if (varied)
            snprintf(text, sizeof text, "%s, α = %s", of->label, ff_report_number(c->roughness[k], number));
        else
            snprintf(text, sizeof text, "%s", of->label);
        ff_plot_model *m = new_model(s, text);
        *m = (ff_plot_model){.label = m->label,
                             .model = &scene->model,
                             .n_channels = scene->n_channels,
                             .shape = scene->shape,
                             .channel = scene->channel,
                             .aperture = s->aperture};
        if (c->n_roughness && !varied) return EXIT_DONE;
    }
    return EXIT_DONE;
}

static int add_expressions(const cli_args *args, const ff_plot_choice *c, cli_subject *s)
{
    const int aperture = cli_aperture(args, NULL, &s->aperture);
    if (aperture != EXIT_DONE) return aperture;
    const size_t n = args->n_words - 1, each = c->n_roughness ? c->n_roughness : 1;
    char expression[FF_MODEL_NAME];
    described d = {.expression = expression, .n_all = n};
    int status = room_for(s, n * each);
    ff_model *all = calloc(n, sizeof *all);
    s->scene = calloc(n * each, sizeof *s->scene);
    if (!s->scene || !all) status = cli_failed(FF_ERR_MEMORY, NULL);
    d.all = all;
    for (size_t k = 0; k < n && status == EXIT_DONE; k++) {
        const ff_status parsed = cli_model_parse(args->word[1 + k], expression, &d.own, &all[k], NULL);
        if (parsed != FF_OK) status = cli_failed(parsed, NULL);
    }
    for (size_t k = 0; k < n && status == EXIT_DONE; k++) {
        cli_model_parse(args->word[1 + k], expression, &d.own, &all[k], NULL);
        d.label = args->word[1 + k];
        status = add_scenes(args, c, &d, s);
    }
    free(all);
    return status;
}

/* Terms of the registry by --ndf and --masking, those that need a table left out where there is none. */
static int add_terms(const cli_args *args, const ff_plot_kind *kind, const ff_plot_choice *c, cli_subject *s)
{
    cli_combinations all = {.model = NULL};
    const int masks = (kind->takes & FF_PLOT_MASKINGS) != 0, by_flag = cli_given(args, FLAG_NDF) > 0;
    const size_t each = c->n_roughness ? c->n_roughness : 1;
    int status = cli_tables_read(args, &s->tables);
    ff_profile_table *stand_in = s->tables.profile ? NULL : calloc(1, sizeof *stand_in);
    if (status == EXIT_DONE && !s->tables.profile && !stand_in) status = cli_failed(FF_ERR_MEMORY, NULL);
    cli_tables some = {s->tables.profile ? s->tables.profile : stand_in};
    if (status == EXIT_DONE)
        status = cli_combine(args, &some, masks ? "ggx" : "all", masks ? "all" : "smith-height-correlated", &all);
    if (status == EXIT_DONE) status = room_for(s, all.n * each);
    s->scene = status == EXIT_DONE ? calloc(all.n * each + 1, sizeof *s->scene) : NULL;
    if (status == EXIT_DONE && !s->scene) status = cli_failed(FF_ERR_MEMORY, NULL);
    for (size_t k = 0; k < all.n && status == EXIT_DONE; k++) {
        char expression[FF_MODEL_NAME], label[FF_MODEL_NAME];
        const ff_lobe *lobe = &all.model[k].lobe[0];
        const char *ndf = ff_term_at(FF_NDF, (size_t)lobe->ndf)->name,
                   *masking = ff_term_at(FF_MASKING, (size_t)lobe->masking)->name;
        if (lobe->ndf == ff_term_find(FF_NDF, "tabulated") && !s->tables.profile && !by_flag) continue;
        snprintf(expression, sizeof expression, "%s/%s", ndf, masking);
        snprintf(label, sizeof label, "%s%s%s", masks && !by_flag ? "" : ndf, masks && by_flag ? ", " : "", masks ? masking : "");
        status = add_scenes(args, c, &(described){.expression = expression, .own = "", .label = label}, s);
    }
    free(stand_in);
    free(all.model);
    return status;
}

/* ---- data ------------------------------------------------------------------------------------ */

static int fit_data(const cli_args *args, const ff_plot_kind *kind, const char *path, cli_subject *s)
{
    const unsigned t = kind->takes;
    int status = cli_fits_draw(args, path, kind, &s->fits);
    if (status != EXIT_DONE) return status;
    cli_drawn_fits *d = &s->fits;
    s->tables.profile = d->tables.profile; /* borrowed: taken back in cli_subject_free */
    status = add_document(args, s, d->document, (t & FF_PLOT_COMPARES) != 0);
    s->subject.table = &d->f.table;
    s->subject.max_theta = d->f.options.max_theta;
    s->subject.problem = d->f.problem[0];
    s->subject.options = &d->f.options;
    s->subject.fit = &d->fit[0];
    s->subject.places = d->trust.looks.n_places ? &d->trust.looks.places[0] : NULL;
    for (size_t i = 0; i < d->n; i++) {
        const int outcome = cli_fitting_say_outcome(&d->fit[i]);
        if (d->n == 1 || i == d->document->best) s->outcome = outcome;
    }
    return status;
}

static int read_data(const cli_args *args, const char *path, cli_subject *s)
{
    const int status = cli_read(args, path, 1, &s->table);
    s->has_table = status == EXIT_DONE;
    if (status == EXIT_DONE) s->subject.table = &s->table;
    return status;
}

static int read_document(const cli_args *args, const char *path, int all, cli_subject *s)
{
    ff_error err = {0};
    const ff_status failed = ff_fit_document_read(path, &s->document, &err);
    if (failed == FF_OK) return add_document(args, s, s->document, all);
    if (!err.path[0]) snprintf(err.path, sizeof err.path, "%s", path);
    return cli_failed(failed, &err);
}

static int add_file(const cli_args *args, const ff_plot_kind *kind, const char *path, cli_subject *s)
{
    const char *from = cli_value(args, FLAG_FROM, NULL);
    const int shows_model = (kind->takes & (FF_PLOT_FITS | FF_PLOT_MODELS | FF_PLOT_RESULTS)) != 0;
    s->subject.path = path;
    if (!shows_model) return read_data(args, path, s);
    if (!from) return fit_data(args, kind, path, s);
    if (kind->takes & FF_PLOT_FRESH) return cli_usage(args, "'%s' fits the data itself: leave out --from", kind->name);
    const int status = read_data(args, path, s);
    return status == EXIT_DONE ? read_document(args, from, 0, s) : status;
}

/* ---- all ------------------------------------------------------------------------------------- */

static int add_sources(const cli_args *args, const ff_plot_kind *kind, const ff_plot_choice *c, cli_subject *s)
{
    char what[256];
    cli_source first = CLI_SOURCE_MODEL;
    for (size_t k = 1; k < args->n_words; k++) {
        cli_source one;
        const int status = cli_source_of(args->word[k], &one);
        if (status != EXIT_DONE) return status;
        if (k == 1) first = one;
        if (k > 1 && (one != CLI_SOURCE_MODEL || first != CLI_SOURCE_MODEL))
            return cli_usage(args, "'%s' is drawn of one file, or of models: '%s' is too much", kind->name, args->word[k]);
    }
    if (first != CLI_SOURCE_MODEL && (cli_given(args, FLAG_SET) || c->n_roughness))
        return cli_usage(args, "--%s is of models, and %s is a file", c->n_roughness ? "roughness" : "set", args->word[1]);
    if (args->n_words > 2 && !(kind->uses & FF_PLOT_SEVERAL))
        return cli_usage(args, "'%s' shows one model: '%s' is too much", kind->name, args->word[2]);
    const int draws_models = (kind->takes & FF_PLOT_MODELS) != 0, draws_results = (kind->takes & FF_PLOT_RESULTS) != 0;
    if (first == CLI_SOURCE_TABLE) return add_file(args, kind, args->word[1], s);
    if (first == CLI_SOURCE_MODEL && draws_models) return add_expressions(args, c, s);
    if (first == CLI_SOURCE_DOCUMENT && (draws_models || draws_results))
        return read_document(args, args->word[1],
                             draws_results || kind->takes & (FF_PLOT_COMPARES | FF_PLOT_TERMS) || !(kind->takes & FF_PLOT_DATA), s);
    return cli_usage(args, "'%s' is drawn of %s, not of %s %s", kind->name, wanted(kind, what, sizeof what),
                     first == CLI_SOURCE_MODEL ? "the model" : "a result,", args->word[1]);
}

int cli_subject_gather(const cli_args *args, const ff_plot_kind *kind, const ff_plot_choice *c, cli_subject *s)
{
    char what[256];
    s->subject.max_theta = 1.5707963267948966;
    if (args->n_words > 1) return add_sources(args, kind, c, s);
    if (kind->takes & FF_PLOT_TERMS) return add_terms(args, kind, c, s);
    return cli_usage(args, "SOURCE is missing: '%s' is drawn of %s", kind->name, wanted(kind, what, sizeof what));
}

void cli_subject_free(cli_subject *s)
{
    if (s->fits.tables.profile == s->tables.profile) s->tables.profile = NULL;
    for (size_t k = 0; k < s->n_scenes; k++) cli_scene_free(&s->scene[k]);
    free(s->scene);
    free(s->model);
    free(s->label);
    if (s->has_table) ff_table_clear(&s->table);
    ff_fit_document_free(s->document);
    cli_fits_free(&s->fits);
    cli_tables_free(&s->tables);
}
