/* The JSON of fits read back. */
#include "base/internal_input.h"
#include "base/internal_json.h"
#include "ff_fit_document.h"
#include "models/internal_model.h"
#include "models/tools/internal_aperture.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

static const double degree = 3.14159265358979323846 / 180;
static const char schema_begin[] = "facetfit.fit/";
enum { VERSION_LEAST = 2, VERSION_MOST = 2, MOST_CHANNELS = 100000 };

/* What is being read, for messages. */
typedef struct place {
    const char *path;
    size_t fit; /* 1 ...; 0: the document itself */
    ff_error *err;
} place;

static ff_status wrong(const place *at, const char *what)
{
    if (!at->fit) return ff_error_set(at->err, FF_ERR_DATA, at->path, 0, -1, "a result of fits without %s", what);
    return ff_error_set(at->err, FF_ERR_DATA, at->path, 0, -1, "fit %zu of the document has no %s", at->fit, what);
}

static ff_status no_memory(const place *at)
{
    return ff_error_set(at->err, FF_ERR_MEMORY, at->path, 0, -1, "out of memory");
}

static void take_text(const ff_json_node *node, char *out, size_t size)
{
    const char *text = ff_json_text(node);
    snprintf(out, size, "%s", text ? text : "");
}

/* ---- parameters ------------------------------------------------------------------------------ */

/* The c-th value of a list; a number alone is the first. */
static const ff_json_node *item(const ff_json_node *node, size_t c)
{
    if (ff_json_kind_of(node) != FF_JSON_ARRAY) return c == 0 ? node : NULL;
    const ff_json_node *i = ff_json_first(node);
    while (i && c-- > 0) i = ff_json_next(i);
    return i;
}

/* The values of a per-channel parameter, one list after another, so that no list is walked from its start for each channel. */
static void take_list(const ff_json_node *list, size_t n, size_t stride, size_t offset, ff_fitted_value *out)
{
    const ff_json_node *i = ff_json_kind_of(list) == FF_JSON_ARRAY ? ff_json_first(list) : NULL;
    for (size_t c = 0; c < n && i; c++, i = ff_json_next(i))
        *(double *)(void *)((char *)&out[c * stride] + offset) = ff_json_real(i);
}

static int bound_of(const ff_json_node *node)
{
    const char *side = ff_json_text(node);
    return !side ? 0 : !strcmp(side, "lower") ? -1 : !strcmp(side, "upper") ? 1 : 0;
}

static void take_interval(const ff_json_node *pair, ff_fitted_value *out)
{
    out->low = ff_json_real(item(pair, 0));
    out->high = ff_json_kind_of(pair) == FF_JSON_ARRAY ? ff_json_real(item(pair, 1)) : NAN;
}

static ff_fitted_value begin_value(const ff_json_node *p)
{
    return (ff_fitted_value){.value = NAN,
                             .std_error = NAN,
                             .low = NAN,
                             .high = NAN,
                             .held = ff_json_is_true(ff_json_member(p, "held")),
                             .tied = ff_json_is_true(ff_json_member(p, "tied"))};
}

static ff_status take_shape(const place *at, const ff_json_node *parameters, ff_fitted *f)
{
    for (uint32_t k = 0; k < f->model.n_shape; k++) {
        const ff_json_node *p = ff_json_member(parameters, f->model.shape[k].name);
        ff_fitted_value *v = &f->shape_value[k];
        *v = begin_value(p);
        v->value = f->shape[k] = ff_json_real(ff_json_member(p, "value"));
        v->std_error = ff_json_real(ff_json_member(p, "std_error"));
        v->at_bound = bound_of(ff_json_member(p, "at_bound"));
        take_interval(ff_json_member(p, "interval"), v);
        char what[FF_PARAM_NAME + 32];
        snprintf(what, sizeof what, "value of %s", f->model.shape[k].name);
        if (isnan(v->value)) return wrong(at, what);
    }
    return FF_OK;
}

static ff_status take_channels(const place *at, const ff_json_node *parameters, ff_fitted *f)
{
    const size_t n = f->n_channels, stride = f->model.n_channel;
    for (uint32_t k = 0; k < stride; k++) {
        const ff_json_node *p = ff_json_member(parameters, f->model.channel[k].name), *i;
        ff_fitted_value *v = f->channel_value + k;
        for (size_t c = 0; c < n; c++) v[c * stride] = begin_value(p);
        take_list(ff_json_member(p, "value"), n, stride, offsetof(ff_fitted_value, value), v);
        take_list(ff_json_member(p, "std_error"), n, stride, offsetof(ff_fitted_value, std_error), v);
        i = ff_json_first(ff_json_member(p, "at_bound"));
        for (size_t c = 0; c < n && i; c++, i = ff_json_next(i)) v[c * stride].at_bound = bound_of(i);
        i = ff_json_first(ff_json_member(p, "interval"));
        for (size_t c = 0; c < n && i; c++, i = ff_json_next(i)) take_interval(i, &v[c * stride]);
        for (size_t c = 0; c < n; c++) {
            char what[FF_PARAM_NAME + 48];
            snprintf(what, sizeof what, "value of %s in channel %zu", f->model.channel[k].name, c + 1);
            if (isnan(v[c * stride].value)) return wrong(at, what);
            f->channel[c * stride + k] = v[c * stride].value;
        }
    }
    return FF_OK;
}

/* ---- what is known besides ------------------------------------------------------------------- */

static void take_bands(const ff_json_node *bands, ff_fitted *f)
{
    f->has_bands = bands != NULL;
    for (int place = 0; place < FF_PLACE_COUNT && bands; place++) {
        const ff_json_node *b = ff_json_first(ff_json_member(bands, ff_place_name(place)));
        for (size_t k = 0; k < FF_BANDS; k++, b = ff_json_next(b)) {
            const double n = ff_json_real(ff_json_member(b, "n"));
            f->bands.band[place][k] = (ff_band){n > 0 && n < 1e15 ? (size_t)n : 0, ff_json_real(ff_json_member(b, "mean")),
                                                ff_json_real(ff_json_member(b, "rms"))};
        }
    }
}

static double or_zero(double x)
{
    return isnan(x) ? 0 : x;
}

static ff_status take_noise(const place *at, const ff_json_node *noise, ff_fitted *f)
{
    const ff_json_node *levels = ff_json_member(noise, "levels");
    const size_t n = ff_json_count(levels);
    if (n == 0) return FF_OK;
    ff_noise_level *level = calloc(n, sizeof *level);
    if (!level) return no_memory(at);
    const ff_json_node *l = ff_json_first(levels);
    for (size_t k = 0; k < n; k++, l = ff_json_next(l))
        level[k] = (ff_noise_level){or_zero(ff_json_real(ff_json_member(l, "constant"))),
                                    or_zero(ff_json_real(ff_json_member(l, "linear"))),
                                    or_zero(ff_json_real(ff_json_member(l, "square")))};
    const ff_status status = ff_noise_new(level, n, or_zero(ff_json_real(ff_json_member(noise, "cos_i"))),
                                          or_zero(ff_json_real(ff_json_member(noise, "cos_o"))), &f->noise, at->err);
    free(level);
    return status == FF_ERR_RANGE ? FF_OK : status; /* a noise of nothing: exact data */
}

/* Of many channels: a block for each of them. */
static ff_status take_own(const place *at, const ff_json_node *correlation, ff_fitted *f)
{
    const ff_json_node *names = ff_json_member(correlation, "channel_names"), *channels = ff_json_member(correlation, "channels");
    const size_t n = ff_json_count(names), width = f->n_columns + n;
    if (n == 0 || ff_json_count(channels) != f->n_channels) return FF_OK;
    f->own_name = calloc(n, sizeof *f->own_name);
    f->own = calloc(f->n_channels * n, width * sizeof *f->own);
    if (!f->own_name || !f->own) return no_memory(at);
    const ff_json_node *name = ff_json_first(names), *channel = ff_json_first(channels);
    for (size_t k = 0; k < n; k++, name = ff_json_next(name)) take_text(name, f->own_name[k], sizeof f->own_name[k]);
    for (size_t c = 0; c < f->n_channels; c++, channel = ff_json_next(channel)) {
        const ff_json_node *row = ff_json_first(channel);
        for (size_t k = 0; k < n; k++, row = ff_json_next(row)) {
            const ff_json_node *x = ff_json_first(row);
            for (size_t i = 0; i < width; i++, x = ff_json_next(x)) f->own[(c * n + k) * width + i] = ff_json_real(x);
        }
    }
    f->n_own = n;
    return FF_OK;
}

static ff_status take_correlation(const place *at, const ff_json_node *correlation, ff_fitted *f)
{
    const ff_json_node *names = ff_json_member(correlation, "names"), *rows = ff_json_member(correlation, "matrix");
    const size_t n = ff_json_count(names);
    if (n == 0 || ff_json_count(rows) != n) return FF_OK;
    for (const ff_json_node *row = ff_json_first(rows); row; row = ff_json_next(row))
        if (ff_json_count(row) != n) return wrong(at, "square matrix of correlations");
    f->column_name = calloc(n, sizeof *f->column_name);
    f->correlation = calloc(n * n, sizeof *f->correlation);
    if (!f->column_name || !f->correlation) return no_memory(at);
    f->n_columns = n;
    const ff_json_node *name = ff_json_first(names), *row = ff_json_first(rows);
    for (size_t a = 0; a < n; a++, name = ff_json_next(name), row = ff_json_next(row)) {
        take_text(name, f->column_name[a], sizeof f->column_name[a]);
        const ff_json_node *x = ff_json_first(row);
        for (size_t b = 0; b < n; b++, x = ff_json_next(x)) f->correlation[a * n + b] = ff_json_real(x);
    }
    return take_own(at, correlation, f);
}

/* ---- fits ------------------------------------------------------------------------------------ */

static ff_status take_names(const place *at, const ff_json_node *channels, ff_fitted *f)
{
    f->n_channels = ff_json_count(channels);
    if (f->n_channels == 0 || f->n_channels > MOST_CHANNELS) return wrong(at, "channels");
    f->channel_name = calloc(f->n_channels, sizeof *f->channel_name);
    if (!f->channel_name) return no_memory(at);
    const ff_json_node *c = ff_json_first(channels);
    for (size_t k = 0; k < f->n_channels; k++, c = ff_json_next(c)) take_text(c, f->channel_name[k], sizeof f->channel_name[k]);
    return FF_OK;
}

static ff_status take_fit(const place *at, const ff_json_node *node, ff_fitted *f)
{
    const char *expression = ff_json_text(ff_json_member(node, "model"));
    const ff_json_node *parameters = ff_json_member(node, "parameters"), *residual = ff_json_member(node, "residual");
    if (!expression) return wrong(at, "model");
    ff_status status = ff_model_parse(expression, &f->model, at->err);
    if (status)
        return ff_error_set(at->err, FF_ERR_DATA, at->path, 0, -1,
                            "fit %zu of the document has a model that is not known here: %.200s", at->fit, expression);
    ff_model_expression(&f->model, f->expression, sizeof f->expression);
    take_text(ff_json_member(node, "outcome"), f->outcome, sizeof f->outcome);
    take_text(ff_json_member(node, "shape"), f->shape_name, sizeof f->shape_name);
    if ((status = take_names(at, ff_json_member(node, "channels"), f))) return status;
    f->channel = calloc(f->n_channels * f->model.n_channel + 1, sizeof *f->channel);
    f->shape_value = calloc(f->model.n_shape + 1, sizeof *f->shape_value);
    f->channel_value = calloc(f->n_channels * f->model.n_channel + 1, sizeof *f->channel_value);
    if (!f->channel || !f->shape_value || !f->channel_value) return no_memory(at);
    if ((status = take_shape(at, parameters, f)) || (status = take_channels(at, parameters, f))) return status;
    if (ff_model_check_values(&f->model, f->n_channels, f->shape, f->channel, at->err)) {
        char why[FF_ERROR_MESSAGE / 2];
        snprintf(why, sizeof why, "%.*s", (int)sizeof why - 1, at->err ? at->err->message : "");
        return ff_error_set(at->err, FF_ERR_DATA, at->path, 0, -1,
                            "fit %zu of the document has values that its model cannot have: %s", at->fit, why);
    }
    f->objective = ff_json_real(ff_json_member(residual, "objective"));
    f->rmse = ff_json_real(ff_json_member(residual, "rmse"));
    take_bands(ff_json_member(node, "residual_bands"), f);
    if ((status = take_noise(at, ff_json_member(node, "noise"), f))) return status;
    return take_correlation(at, ff_json_member(node, "correlation"), f);
}

/* The order of the document's own ranking, or that of the document. */
static void take_ranking(const ff_json_node *ranking, ff_fit_document *d)
{
    size_t k = 0;
    for (const ff_json_node *i = ff_json_first(ranking); i && k < d->n_fits; i = ff_json_next(i)) {
        const double x = ff_json_real(i);
        if (x >= 0 && x < (double)d->n_fits) d->rank[k++] = (size_t)x;
    }
    for (size_t i = 0; i < d->n_fits && k < d->n_fits; i++) d->rank[i] = i;
    d->best = d->rank[0];
}

/* A point where there is none. FF_ERR_DATA where it is none. */
static ff_status take_aperture(place *at, const ff_json_node *n, ff_aperture *out)
{
    ff_aperture a = {.outline = FF_APERTURE_DISC};
    const char *outline = ff_json_text(ff_json_member(n, "outline"));
    *out = a;
    if (!n) return FF_OK;
    if (outline && !strcmp(outline, "rectangle")) a.outline = FF_APERTURE_RECTANGLE;
    a.half = ff_json_real(ff_json_member(n, "half_deg")) * degree;
    a.across = ff_json_real(ff_json_member(n, "across_deg")) * degree;
    a.source = ff_json_real(ff_json_member(n, "source_deg")) * degree;
    if (!outline || (a.outline == FF_APERTURE_DISC && strcmp(outline, "disc")) || !ff_aperture_valid(&a))
        return wrong(at, "loss.aperture");
    *out = a;
    return FF_OK;
}

static ff_status take_document(place *at, const ff_json_node *root, ff_fit_document *d)
{
    const ff_json_node *data = ff_json_member(root, "data"), *loss = ff_json_member(root, "loss"),
                       *fits = ff_json_member(root, "fits");
    const double max_theta = ff_json_real(ff_json_member(loss, "max_theta_deg"));
    take_text(ff_json_member(data, "path"), d->path, sizeof d->path);
    take_text(ff_json_member(data, "format"), d->format, sizeof d->format);
    take_text(ff_json_member(loss, "name"), d->loss, sizeof d->loss);
    d->max_theta = max_theta > 0 && max_theta <= 90 ? max_theta * degree : 90 * degree;
    const size_t n = ff_json_count(fits);
    if (n == 0) return wrong(at, "fits");
    const ff_status aperture = take_aperture(at, ff_json_member(loss, "aperture"), &d->aperture);
    if (aperture) return aperture;
    d->fit = calloc(n, sizeof *d->fit);
    d->rank = calloc(n, sizeof *d->rank);
    if (!d->fit || !d->rank) return no_memory(at);
    for (const ff_json_node *f = ff_json_first(fits); f; f = ff_json_next(f)) {
        at->fit = ++d->n_fits;
        const ff_status status = take_fit(at, f, &d->fit[d->n_fits - 1]);
        if (status) return status;
    }
    take_ranking(ff_json_member(root, "ranking"), d);
    return FF_OK;
}

/* ---- documents ------------------------------------------------------------------------------- */

static ff_status check_schema(const place *at, const ff_json_node *root)
{
    const char *schema = ff_json_text(ff_json_member(root, "schema"));
    const size_t n = sizeof schema_begin - 1;
    if (!schema || strncmp(schema, schema_begin, n))
        return ff_error_set(at->err, FF_ERR_FORMAT, at->path, 0, -1, "JSON, but not the result of a fit or a comparison%s%.40s%s",
                            schema ? ": its schema is '" : "", schema ? schema : "", schema ? "'" : "");
    const long version = strtol(schema + n, NULL, 10);
    if (version < VERSION_LEAST || version > VERSION_MOST)
        return ff_error_set(at->err, FF_ERR_FORMAT, at->path, 0, -1,
                            "a result of version '%.20s', which is not known here; expected %s%d", schema + n, schema_begin,
                            (int)VERSION_MOST);
    return FF_OK;
}

static ff_status from_tree(const ff_json_tree *tree, const char *path, ff_fit_document **out, ff_error *err)
{
    place at = {path, 0, err};
    ff_status status = check_schema(&at, ff_json_root(tree));
    if (status) return status;
    ff_fit_document *d = calloc(1, sizeof *d);
    if (!d) return no_memory(&at);
    status = take_document(&at, ff_json_root(tree), d);
    if (status)
        ff_fit_document_free(d);
    else
        *out = d;
    return status;
}

ff_status ff_fit_document_read(const char *path, ff_fit_document **out, ff_error *err)
{
    ff_json_tree *tree;
    ff_status status = ff_json_read(path, &tree, err);
    if (status) return status;
    status = from_tree(tree, path, out, err);
    ff_json_free(tree);
    return status;
}

ff_status ff_fit_document_parse(const char *text, size_t n, const char *path, ff_fit_document **out, ff_error *err)
{
    ff_json_tree *tree;
    ff_status status = ff_json_parse(text, n, path, &tree, err);
    if (status) return status;
    status = from_tree(tree, path, out, err);
    ff_json_free(tree);
    return status;
}

void ff_fit_document_free(ff_fit_document *d)
{
    if (!d) return;
    for (size_t i = 0; i < d->n_fits; i++) {
        ff_fitted *f = &d->fit[i];
        free(f->channel_name);
        free(f->channel);
        free(f->shape_value);
        free(f->channel_value);
        ff_noise_free(f->noise);
        free(f->column_name);
        free(f->correlation);
        free(f->own_name);
        free(f->own);
    }
    free(d->fit);
    free(d->rank);
    free(d);
}

static int ends_in_json(const char *path)
{
    const size_t n = strlen(path);
    return n > 5 && !strcasecmp(path + n - 5, ".json");
}

int ff_fit_document_probe(const char *path)
{
    char head[2048];
    int fd;
    int64_t size;
    size_t got = 0;
    if (ff_input_look(path, &fd, &size, NULL)) return 0;
    const ff_status status = size < 0 ? FF_ERR_READ : ff_input_read(fd, path, 0, head, sizeof head - 1, &got, NULL);
    ff_input_unlook(path, fd, got);
    head[got] = '\0';
    const char *text = head + ff_byte_order_mark(head, got);
    text += strspn(text, " \t\r\n");
    return !status && *text == '{' && (ends_in_json(path) || strstr(text, "\"facetfit."));
}

/* ---- finding --------------------------------------------------------------------------------- */

static ff_status unknown(const ff_fit_document *d, const char *name, ff_error *err)
{
    return ff_error_set(err, FF_ERR_UNKNOWN, NULL, 0, -1,
                        "no fit '%.200s' among the %zu of the document: expected a number from 1 to %zu, or a "
                        "model as %s",
                        name, d->n_fits, d->n_fits, d->fit[d->best].expression);
}

ff_status ff_fit_document_find(const ff_fit_document *d, const char *name, size_t *out, ff_error *err)
{
    const size_t digits = strspn(name, "0123456789");
    size_t found = 0;
    if (!*name) {
        *out = d->best;
        return FF_OK;
    }
    if (digits && !name[digits]) {
        const unsigned long k = digits < 9 ? strtoul(name, NULL, 10) : 0;
        if (k < 1 || k > d->n_fits) return unknown(d, name, err);
        *out = k - 1;
        return FF_OK;
    }
    for (size_t i = 0; i < d->n_fits; i++) {
        if (strncmp(d->fit[i].expression, name, strlen(name))) continue;
        if (!d->fit[i].expression[strlen(name)]) {
            *out = i;
            return FF_OK;
        }
        *out = i;
        found++;
    }
    return found == 1 ? FF_OK : unknown(d, name, err);
}
