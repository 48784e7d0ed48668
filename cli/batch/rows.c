/* What the table of a batch says of a file: taken from its JSON, whoever wrote that and when. */
#define _GNU_SOURCE /* asprintf */
#include "internal_batch.h"
#include "base/internal_json.h"
#include "base/internal_kept.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

const char *batch_state_name(int state)
{
    static const char *const names[BATCH_STATES] = {"done", "failed", "missing"};
    return state >= 0 && state < BATCH_STATES ? names[state] : NULL;
}

static void row_free(batch_row *r)
{
    for (size_t k = 0; k < r->n_values; k++) free(r->value[k].name);
    free(r->value);
    free(r->model);
    free(r->channels);
    free(r->outcome);
    free(r->quality);
    free(r->verdict);
    free(r->warnings);
}

void batch_rows_free(batch_rows *r)
{
    for (size_t i = 0; i < r->n; i++) row_free(&r->row[i]);
    free(r->row);
    free(r->message);
    free(r->picture);
    *r = (batch_rows){.n = 0};
}

/* ---- texts ----------------------------------------------------------------------------------- */

static char *text_of(const ff_json_node *node)
{
    const char *text = ff_json_text(node);
    return strdup(text ? text : "");
}

/* Which items of a list count, and what is told of them. */
typedef const char *tells(const ff_json_node *item, size_t problem);

/* With blanks between, each once where they follow each other; NULL: no memory. */
static char *join(const ff_json_node *list, tells *tell, size_t problem)
{
    ff_kept kept;
    FILE *stream = ff_kept_open(&kept);
    const char *last = NULL;
    for (const ff_json_node *i = stream ? ff_json_first(list) : NULL; i; i = ff_json_next(i)) {
        const char *text = tell(i, problem);
        if (!text || (last && !strcmp(last, text))) continue;
        fprintf(stream, "%s%s", last ? " " : "", text);
        last = text;
    }
    if (ff_kept_close(&kept, stream) != FF_OK) return NULL;
    char *text = strdup(kept.text); /* of thousands of rows: no longer than it has to be */
    free(kept.text);
    return text;
}

static const char *tell_channel(const ff_json_node *item, size_t problem)
{
    (void)problem;
    return ff_json_text(item);
}

static const char *tell_warning(const ff_json_node *item, size_t problem)
{
    (void)problem;
    return ff_json_text(ff_json_member(item, "code"));
}

/* Of a verdict only what is said of this problem. */
static int is_of(const ff_json_node *sentence, size_t problem)
{
    return ff_json_real(ff_json_member(sentence, "problem")) == (double)problem;
}

static const char *tell_verdict(const ff_json_node *item, size_t problem)
{
    return is_of(item, problem) ? ff_json_text(ff_json_member(item, "code")) : NULL;
}

static const char *tell_quality(const ff_json_node *item, size_t problem)
{
    return is_of(item, problem) ? ff_json_text(ff_json_member(item, "quality")) : NULL;
}

/* ---- parameters ------------------------------------------------------------------------------ */

static const ff_json_node *next_of(const ff_json_node *item)
{
    return item ? ff_json_next(item) : NULL;
}

/* What is held says nothing of the data. */
static int is_held(const ff_json_node *parameter)
{
    return ff_json_is_true(ff_json_member(parameter, "held"));
}

static int add_value(batch_row *r, char *name, const ff_json_node *value, const ff_json_node *error)
{
    r->value[r->n_values++] = (batch_value){name, ff_json_real(value), ff_json_real(error), 0};
    return name != NULL;
}

/* One of every channel, named by it where there are several. 0: no memory. */
static int add_channels(batch_row *r, const char *name, const ff_json_node *values, const ff_json_node *errors,
                        const ff_json_node *channels)
{
    const ff_json_node *v = ff_json_first(values), *e = ff_json_first(errors), *c = ff_json_first(channels);
    const int several = ff_json_count(channels) > 1;
    for (; v; v = next_of(v), e = next_of(e), c = next_of(c)) {
        char *full = NULL;
        if (asprintf(&full, several ? "%s[%s]" : "%s", name, ff_json_text(c) ? ff_json_text(c) : "") < 0) full = NULL;
        if (!add_value(r, full, v, e)) return 0;
    }
    return 1;
}

static size_t count_values(const ff_json_node *parameters)
{
    size_t n = 0;
    for (const ff_json_node *p = ff_json_first(parameters); p; p = ff_json_next(p)) {
        const ff_json_node *v = ff_json_member(p, "value");
        n += is_held(p) ? 0 : ff_json_kind_of(v) == FF_JSON_ARRAY ? ff_json_count(v) : 1;
    }
    return n;
}

static ff_status take_parameters(const ff_json_node *fit, batch_row *r)
{
    const ff_json_node *parameters = ff_json_member(fit, "parameters"), *channels = ff_json_member(fit, "channels");
    int there = 1;
    r->value = calloc(count_values(parameters) + 1, sizeof *r->value);
    for (const ff_json_node *p = r->value ? ff_json_first(parameters) : NULL; p && there; p = ff_json_next(p)) {
        const ff_json_node *value = ff_json_member(p, "value"), *error = ff_json_member(p, "std_error");
        if (is_held(p)) continue;
        there = ff_json_kind_of(value) == FF_JSON_ARRAY ? add_channels(r, ff_json_name(p), value, error, channels)
                                                        : add_value(r, strdup(ff_json_name(p)), value, error);
        if (r->n_values) r->value[r->n_values - 1].tied = ff_json_is_true(ff_json_member(p, "tied"));
    }
    return r->value && there ? FF_OK : FF_ERR_MEMORY;
}

/* ---- a row ----------------------------------------------------------------------------------- */

static ff_status take_row(const ff_json_node *root, const ff_json_node *fit, size_t problem, batch_row *r)
{
    const ff_json_node *residual = ff_json_member(fit, "residual"), *verdict = ff_json_member(root, "verdict");
    r->model = text_of(ff_json_member(fit, "model"));
    r->outcome = text_of(ff_json_member(fit, "outcome"));
    r->channels = join(ff_json_member(fit, "channels"), tell_channel, problem);
    r->quality = join(verdict, tell_quality, problem);
    r->verdict = join(verdict, tell_verdict, problem);
    r->warnings = join(ff_json_member(fit, "warnings"), tell_warning, problem);
    r->samples = ff_json_real(ff_json_member(ff_json_member(root, "data"), "used"));
    r->explained = ff_json_real(ff_json_member(ff_json_member(fit, "explained"), "share"));
    r->objective = ff_json_real(ff_json_member(residual, "objective"));
    r->rmse = ff_json_real(ff_json_member(residual, "rmse"));
    if (!r->model || !r->outcome || !r->channels || !r->quality || !r->verdict || !r->warnings) return FF_ERR_MEMORY;
    return take_parameters(fit, r);
}

static const ff_json_node *item_at(const ff_json_node *list, double index)
{
    const ff_json_node *i = ff_json_first(list);
    while (i && index-- > 0) i = ff_json_next(i);
    return i;
}

/* A choice of channels is a problem: all of them, or each by itself. */
static size_t count_problems(const ff_json_node *root, const ff_json_node *fits)
{
    const size_t all = ff_json_count(ff_json_member(ff_json_member(root, "data"), "channels"));
    const size_t each = ff_json_count(ff_json_member(ff_json_first(fits), "channels"));
    return each && all % each == 0 ? all / each : 0;
}

static ff_status take_rows(const ff_json_node *root, const char *path, batch_rows *out, ff_error *err)
{
    const ff_json_node *fits = ff_json_member(root, "fits"), *ranking = ff_json_member(root, "ranking");
    const size_t n_fits = ff_json_count(fits), n = count_problems(root, fits);
    if (!n || n_fits % n || ff_json_count(ranking) != n_fits)
        return ff_error_set(err, FF_ERR_DATA, path, 0, -1, "is no whole result of fits: found %zu of them and %zu ranks", n_fits,
                            ff_json_count(ranking));
    out->row = calloc(n, sizeof *out->row);
    if (!out->row) return FF_ERR_MEMORY;
    const ff_json_node *rank = ff_json_first(ranking);
    for (size_t k = 0; k < n_fits; k++, rank = ff_json_next(rank)) {
        if (k % (n_fits / n)) continue; /* the first of each problem is its best */
        const ff_json_node *fit = item_at(fits, ff_json_real(rank));
        const ff_status status = take_row(root, fit, out->n, &out->row[out->n]);
        out->n++;
        if (status != FF_OK) return status;
    }
    return FF_OK;
}

ff_status batch_rows_of(const char *text, size_t n, const char *path, batch_rows *out, ff_error *err)
{
    ff_json_tree *tree;
    ff_status status = ff_json_parse(text, n, path, &tree, err);
    *out = (batch_rows){.state = BATCH_DONE};
    if (status != FF_OK) return status;
    const ff_json_node *root = ff_json_root(tree);
    const char *schema = ff_json_text(ff_json_member(root, "schema"));
    if (!schema || strcmp(schema, ff_schema_name(FF_SCHEMA_FIT)) != 0)
        status = ff_error_set(err, FF_ERR_FORMAT, path, 0, -1, "found the schema '%s', expected %s", schema ? schema : "",
                              ff_schema_name(FF_SCHEMA_FIT));
    else
        status = take_rows(root, path, out, err);
    ff_json_free(tree);
    if (status == FF_OK) return FF_OK;
    batch_rows_free(out);
    return status == FF_ERR_MEMORY ? ff_error_set(err, status, path, 0, -1, "no memory for a row of the summary") : status;
}
