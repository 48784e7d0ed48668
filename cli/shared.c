/* Models with parameters, outputs. */
#define _GNU_SOURCE
#include "internal_cli.h"
#include "report/ff_fit_document.h"
#include "data_formats/table/profile_file_struct.h"
#include "base/internal_number.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- choices --------------------------------------------------------------------------------- */

int cli_isa(const cli_args *args, ff_isa *out)
{
    const ff_isa isa = (ff_isa)cli_word(args, FLAG_ISA, FF_ISA_BEST);
    if (!ff_isa_available(isa))
        return cli_usage(args, "--isa %s: this processor or this build does not have it", cli_value(args, FLAG_ISA, "best"));
    *out = isa;
    return EXIT_DONE;
}

int cli_aperture(const cli_args *args, const ff_aperture *otherwise, ff_aperture *out)
{
    const char *text = cli_value(args, FLAG_APERTURE, NULL);
    *out = otherwise ? *otherwise : (ff_aperture){.outline = FF_APERTURE_DISC};
    if (text && ff_aperture_parse(text, out))
        return cli_usage(args,
                         "--aperture %s: expected a half angle of 0 to %.3g degrees, as in 0.75, 0.75:disc or 0.75:square, or two "
                         "as in 0.5x1",
                         text, FF_APERTURE_MOST / 0.017453292519943295);
    if (cli_given(args, FLAG_SOURCE)) out->source = cli_number(args, FLAG_SOURCE, 0) * 0.017453292519943295;
    return EXIT_DONE;
}

const char *cli_param_nearest(const ff_model *model, size_t n, const char *name)
{
    for (size_t i = 0; i < n; i++) {
        const char *names[1 + FF_MAX_SHAPE + FF_MAX_CHANNEL_PARAMS], *nearest;
        size_t count = 0;
        ff_model m = model[i];
        if (ff_model_vary(&m, "alpha", NULL) == FF_OK) names[count++] = "alpha";
        for (uint32_t k = 0; k < m.n_shape; k++) names[count++] = model[i].shape[k].name;
        for (uint32_t k = 0; k < m.n_channel; k++) names[count++] = model[i].channel[k].name;
        if ((nearest = cli_nearest(name, names, count))) return nearest;
    }
    return NULL;
}

/* ---- tables ---------------------------------------------------------------------------------- */

int cli_tables_read(const cli_args *args, cli_tables *out)
{
    const char *path = cli_value(args, FLAG_NDF_TABLE, NULL);
    ff_error err = {0};
    *out = (cli_tables){NULL};
    if (!path) return EXIT_DONE;
    ff_profile_table *profile = malloc(sizeof *profile);
    const ff_status status = profile ? ff_profile_read_into(path, profile, &err) : FF_ERR_MEMORY;
    if (status == FF_OK) {
        out->profile = profile;
        return EXIT_DONE;
    }
    free(profile);
    return cli_failed(status, &err);
}

void cli_tables_free(cli_tables *tables)
{
    free(tables->profile);
    tables->profile = NULL;
}

ff_status cli_tables_give(const cli_tables *tables, ff_model *m, ff_error *err)
{
    if (ff_model_set_table(m, tables->profile) == 0 || tables->profile) return FF_OK;
    return ff_error_set(err, FF_ERR_UNSUPPORTED, NULL, 0, -1, "tabulated needs the table of its profile: --ndf-table FILE");
}

/* ---- scenes ---------------------------------------------------------------------------------- */

static int count_channels(const cli_args *args, const char *word, void *context)
{
    size_t n = 1, *most = context;
    (void)args;
    for (const char *p = word; *p && *p != ','; p++) n += *p == ':';
    if (n > *most) *most = n;
    return EXIT_DONE;
}

static int is_of_another(const cli_scene *s, const char *name)
{
    for (size_t k = 0; k < s->n_others; k++) {
        ff_model other = s->others[k];
        if (ff_model_vary(&other, name, NULL) == FF_OK) return 1;
    }
    return 0;
}

static int assign(const cli_args *args, const char *word, void *context)
{
    cli_scene *s = context;
    cli_assignment a;
    ff_error err = {0};
    const int read = cli_assignment_read(word, &a);
    if (read && a.rest && cli_is_list(a.rest))
        return cli_usage(args, "--set %s: a list of values has no meaning here; expected one value, or v1:v2:... for the channels",
                         word);
    if (read && *a.channel)
        return cli_usage(args, "--set %s: channels have no names here; expected one value, or v1:v2:... for all", word);
    const ff_status status = ff_model_set(&s->model, s->n_channels, word, s->shape, s->channel, &err);
    if (status == FF_OK || (status == FF_ERR_UNKNOWN && is_of_another(s, a.name))) return EXIT_DONE;
    const char *nearest = status == FF_ERR_UNKNOWN ? cli_param_nearest(&s->model, 1, a.name) : NULL;
    cli_error("--set %s: %s%s%s%s", word, err.message, nearest ? "; did you mean '" : "", nearest ? nearest : "",
              nearest ? "'?" : "");
    return cli_exit_status(status);
}

/* Room for the parameters of s, at their defaults, in as many channels as the assignments have, s->n_channels at least. */
static int scene_room(const cli_args *args, cli_scene *s)
{
    cli_each_word(args, FLAG_SET, count_channels, &s->n_channels);
    s->channel = malloc((s->n_channels * s->model.n_channel + 1) * sizeof *s->channel);
    if (!s->channel) return cli_failed(FF_ERR_MEMORY, NULL);
    ff_model_defaults(&s->model, s->n_channels, s->shape, s->channel);
    return EXIT_DONE;
}

static int scene_of_expression(const cli_args *args, const char *expression, cli_scene *s)
{
    ff_error err = {0};
    ff_status status = ff_model_parse(expression, &s->model, &err);
    if (status != FF_OK) return cli_failed(status, &err);
    const int code = cli_tables_read(args, &s->tables);
    if (code != EXIT_DONE) return code;
    status = cli_tables_give(&s->tables, &s->model, &err);
    return status == FF_OK ? scene_room(args, s) : cli_failed(status, &err);
}

/* A model of one channel serves as many as the command has. */
static int scene_of_document(const cli_args *args, cli_scene *s)
{
    ff_fit_document *d;
    ff_error err = {0};
    ff_status status = ff_fit_document_read(cli_value(args, FLAG_FROM, NULL), &d, &err);
    if (status != FF_OK) return cli_failed(status, &err);
    const ff_fitted *f = &d->fit[d->best];
    const size_t K = f->model.n_channel, C = f->n_channels;
    s->model = f->model;
    s->aperture = d->aperture;
    if (C > 1 || s->n_channels < C) s->n_channels = C;
    int code = cli_tables_read(args, &s->tables);
    if (code == EXIT_DONE && (status = cli_tables_give(&s->tables, &s->model, &err)) != FF_OK) code = cli_failed(status, &err);
    if (code == EXIT_DONE) code = scene_room(args, s);
    if (code == EXIT_DONE) {
        memcpy(s->shape, f->shape, s->model.n_shape * sizeof *s->shape);
        for (size_t c = 0; c < s->n_channels; c++)
            memcpy(s->channel + c * K, f->channel + (c < C ? c : C - 1) * K, K * sizeof *s->channel);
    }
    ff_fit_document_free(d);
    return code;
}

/* Each of "alpha=0.2,f0=1". */
static int assign_own(const char *own, cli_scene *s)
{
    for (const char *word = own; *word;) {
        char one[CLI_NAME];
        ff_error err = {0};
        const size_t n = strcspn(word, ",");
        const int length = snprintf(one, sizeof one, "%.*s", (int)(n < sizeof one ? n : sizeof one), word);
        const ff_status status = length < (int)sizeof one ? ff_model_set(&s->model, s->n_channels, one, s->shape, s->channel, &err)
                                                          : ff_error_set(&err, FF_ERR_SYNTAX, NULL, 0, -1, "expected NAME=VALUE");
        if (status != FF_OK) {
            cli_error("%s: %s", one, err.message);
            return cli_exit_status(status);
        }
        word += n + (word[n] == ',');
    }
    return EXIT_DONE;
}

static int scene_make(const cli_args *args, const char *expression, const char *own, cli_scene s, cli_scene *out)
{
    ff_error err = {0};
    for (const char *word = own; *word; word++)
        if (*word == '=') count_channels(args, word, &s.n_channels);
    int code = expression ? scene_of_expression(args, expression, &s) : scene_of_document(args, &s);
    if (code == EXIT_DONE) code = cli_each_word(args, FLAG_SET, assign, &s);
    if (code == EXIT_DONE) code = assign_own(own, &s);
    if (code == EXIT_DONE) {
        const ff_status status = ff_model_check(&s.model, s.n_channels, s.shape, s.channel, &err);
        if (status != FF_OK) code = cli_failed(status, &err);
    }
    if (code != EXIT_DONE) {
        cli_scene_free(&s);
        return code;
    }
    *out = s;
    out->others = NULL;
    return EXIT_DONE;
}

int cli_scene_make(const cli_args *args, const char *expression, size_t least_channels, cli_scene *out)
{
    return scene_make(args, expression, "", (cli_scene){.n_channels = least_channels}, out);
}

int cli_scene_make_among(const cli_args *args, const char *expression, const char *own, const ff_model *others, size_t n_others,
                         cli_scene *out)
{
    return scene_make(args, expression, own, (cli_scene){.n_channels = 1, .others = others, .n_others = n_others}, out);
}

void cli_scene_free(cli_scene *scene)
{
    free(scene->channel);
    scene->channel = NULL;
    cli_tables_free(&scene->tables);
}

const char *cli_channel_suffix(size_t n_channels, size_t c, char out[24])
{
    static const char *const rgb[] = {"_r", "_g", "_b"};
    if (n_channels == 1) return "";
    if (n_channels == 3) return rgb[c];
    snprintf(out, 24, "_c%zu", c);
    return out;
}
