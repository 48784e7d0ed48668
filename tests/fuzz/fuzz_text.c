/* Texts that are no measurements. What is taken must be sound: it is written and read again where it can be. */
#define _GNU_SOURCE
#include "fuzz_text.h"
#include "base/internal_json.h"
#include "cli/internal_cli.h"
#include "data_formats/formats/csv/internal_csv.h"
#include "report/ff_fit_document.h"
#include "report/ff_json.h"
#include "simulate/ff_simulate.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

static void fail(const char *target, const char *what)
{
    fprintf(stderr, "fuzz_text: %s: %s\n", target, what);
    abort();
}

/* 1 where it was taken; what was not must say why. */
static int taken(const char *target, ff_status status, const ff_error *err)
{
    if (status == FF_OK) return 1;
    if (err->code != status) fail(target, "the error has another code than the call");
    if (status == FF_ERR_INTERNAL) fail(target, err->message);
    if (!err->message[0]) fail(target, "an error without a message");
    return 0;
}

/* ---- JSON -------------------------------------------------------------------------------------- */

/* Levels of the tree, whose members must be as many as it says. */
static int depth_of(const ff_json_node *node)
{
    size_t n = 0;
    int most = 0;
    const int is_object = ff_json_kind_of(node) == FF_JSON_OBJECT;
    for (const ff_json_node *c = ff_json_first(node); c; c = ff_json_next(c), n++) {
        const int depth = depth_of(c);
        if (depth > most) most = depth;
        if (is_object != (ff_json_name(c) != NULL)) fail("json", "a member without a name, or a value with one");
        if (is_object && !ff_json_member(node, ff_json_name(c))) fail("json", "a member that is not found");
    }
    if (n != ff_json_count(node)) fail("json", "another number of values than is counted");
    if (most + 1 > FF_JSON_NESTING + 1) fail("json", "deeper than it may be");
    return most + 1;
}

static void write_node(ff_json *j, const char *key, const ff_json_node *node)
{
    switch (ff_json_kind_of(node)) {
    case FF_JSON_NULL:
        ff_json_null(j, key);
        return;
    case FF_JSON_FALSE:
    case FF_JSON_TRUE:
        ff_json_bool(j, key, ff_json_is_true(node));
        return;
    case FF_JSON_NUMBER:
        if (!isfinite(ff_json_real(node))) fail("json", "a number that is not finite");
        ff_json_number(j, key, ff_json_real(node));
        return;
    case FF_JSON_TEXT:
        ff_json_string(j, key, ff_json_text(node));
        return;
    case FF_JSON_ARRAY:
        ff_json_array(j, key, FF_JSON_LINE);
        break;
    case FF_JSON_OBJECT:
        ff_json_object(j, key, FF_JSON_BLOCK);
        break;
    }
    for (const ff_json_node *c = ff_json_first(node); c; c = ff_json_next(c)) write_node(j, ff_json_name(c), c);
    ff_json_close(j);
}

static int same_text(const char *a, const char *b)
{
    return a && b ? strcmp(a, b) == 0 : a == b;
}

static int same_tree(const ff_json_node *a, const ff_json_node *b)
{
    const double x = ff_json_real(a), y = ff_json_real(b);
    if (ff_json_kind_of(a) != ff_json_kind_of(b) || ff_json_count(a) != ff_json_count(b)) return 0;
    if (!same_text(ff_json_name(a), ff_json_name(b)) || !same_text(ff_json_text(a), ff_json_text(b))) return 0;
    if (!(x == y || (isnan(x) && isnan(y)))) return 0;
    const ff_json_node *c = ff_json_first(a), *d = ff_json_first(b);
    for (; c && d; c = ff_json_next(c), d = ff_json_next(d))
        if (!same_tree(c, d)) return 0;
    return !c && !d;
}

/* What our writer makes of the tree is the same tree for our reader. */
static void write_and_read(const ff_json_tree *tree)
{
    char *text = NULL;
    size_t n = 0;
    ff_json j;
    ff_json_tree *again;
    ff_error err = {0};
    FILE *out = open_memstream(&text, &n);
    if (!out) fail("json", "no memory");
    ff_json_begin(&j, out);
    write_node(&j, NULL, ff_json_root(tree));
    ff_json_end(&j);
    fclose(out);
    if (ff_json_parse(text, n, "again", &again, &err) != FF_OK) fail("json", err.message);
    if (!same_tree(ff_json_root(tree), ff_json_root(again))) fail("json", "another tree when it was written and read again");
    ff_json_free(again);
    free(text);
}

static int fuzz_json(const char *text, size_t n)
{
    ff_json_tree *tree;
    ff_error err = {0};
    if (!taken("json", ff_json_parse(text, n, "input", &tree, &err), &err)) return 0;
    if (depth_of(ff_json_root(tree)) < FF_JSON_DEPTH) write_and_read(tree);
    ff_json_free(tree);
    return 1;
}

/* ---- results of fits --------------------------------------------------------------------------- */

static void check_fitted(const ff_fitted *f)
{
    ff_error err = {0};
    const size_t own = f->n_own;
    if (f->n_channels < 1) fail("fit_document", "no channels");
    if (ff_model_check(&f->model, f->n_channels, f->shape, f->channel, &err) != FF_OK) fail("fit_document", err.message);
    for (size_t k = 0; k < f->n_columns * f->n_columns; k++)
        if (isinf(f->correlation[k])) fail("fit_document", "an infinite correlation");
    for (size_t k = 0; k < f->n_channels * own * (f->n_columns + own); k++)
        if (isinf(f->own[k])) fail("fit_document", "an infinite correlation");
}

static int fuzz_fit_document(const char *text, size_t n)
{
    ff_fit_document *d;
    ff_error err = {0};
    size_t which, sum = 0;
    if (!taken("fit_document", ff_fit_document_parse(text, n, "input", &d, &err), &err)) return 0;
    if (d->n_fits < 1 || d->best >= d->n_fits) fail("fit_document", "no best fit");
    for (size_t i = 0; i < d->n_fits; i++) {
        check_fitted(&d->fit[i]);
        if (d->rank[i] >= d->n_fits) fail("fit_document", "a rank of no fit");
        sum += d->rank[i];
    }
    if (sum != d->n_fits * (d->n_fits - 1) / 2) fail("fit_document", "ranks that are no order");
    if (ff_fit_document_find(d, "", &which, &err) != FF_OK || which != d->best) fail("fit_document", "'' is not the best");
    if (ff_fit_document_find(d, d->fit[0].expression, &which, &err) == FF_OK && which >= d->n_fits)
        fail("fit_document", "found none");
    ff_fit_document_free(d);
    return 1;
}

/* ---- expressions ------------------------------------------------------------------------------- */

/* The full expression of what was read says the same, and an assignment leaves a model that can be evaluated. */
static int fuzz_model(const char *text, const char *assignment)
{
    ff_model m, again;
    char full[FF_MODEL_NAME], twice[FF_MODEL_NAME];
    ff_error err = {0};
    double shape[FF_MAX_SHAPE], channel[2 * FF_MAX_CHANNEL_PARAMS];
    if (!taken("expressions", ff_model_parse(text, &m, &err), &err)) return 0;
    ff_model_expression(&m, full, sizeof full);
    if (ff_model_parse(full, &again, &err) != FF_OK) fail("expressions", err.message);
    ff_model_expression(&again, twice, sizeof twice);
    if (strcmp(full, twice)) fail("expressions", "another expression of what an expression said");
    ff_model_defaults(&m, 2, shape, channel);
    if (ff_model_check(&m, 2, shape, channel, &err) != FF_OK) fail("expressions", "defaults that cannot be");
    err = (ff_error){0};
    if (taken("expressions", ff_model_set(&m, 2, assignment, shape, channel, &err), &err))
        for (uint32_t k = 0; k < m.n_shape; k++)
            if (!isfinite(shape[k])) fail("expressions", "a value that is not finite was set");
    return 1;
}

/* The first line is tried as everything that is an expression, the second as an assignment to the model. */
static int fuzz_expressions(char *text)
{
    char *line = strchr(text, '\n');
    ff_noise *noise;
    ff_sampling sampling;
    ff_csv_mapping mapping;
    ff_error err = {0};
    if (line) *line++ = '\0';
    int n = fuzz_model(text, line ? line : "alpha=0.3");
    if (taken("noise", ff_noise_parse(text, &noise, &err), &err)) {
        ff_noise_free(noise);
        n = 1;
    }
    err = (ff_error){0};
    if (taken("sampling", ff_sampling_parse(text, &sampling, &err), &err)) {
        if (sampling.kind == FF_SAMPLING_SCATTERED && !(sampling.n >= 1 && sampling.specular >= 0 && sampling.specular <= 1))
            fail("sampling", "a number that it does not allow");
        n = 1;
    }
    err = (ff_error){0};
    if (taken("columns", ff_csv_mapping_read(text, "input", &mapping, &err), &err)) {
        ff_csv_mapping_free(&mapping);
        n = 1;
    }
    return n;
}

/* ---- command lines ----------------------------------------------------------------------------- */

/* What is said of the parameters of a fit. */
static int read_constraints(const cli_args *args)
{
    ff_model model;
    ff_error err = {0};
    cli_constraints constraints = {.n_names = 0};
    if (ff_model_parse(cli_value(args, FLAG_MODEL, "ggx+lambert"), &model, &err) != FF_OK) return EXIT_USAGE;
    int status = cli_hold_and_free(args, &model, 0);
    if (status != EXIT_DONE) return status;
    status = cli_constraints_read(args, &model, 1, 0, &constraints);
    for (size_t i = 0; status == EXIT_DONE && i < constraints.c.n_bounds; i++)
        if (!(constraints.bound[i].lo < constraints.bound[i].hi)) fail("words", "bounds that do not rise were taken");
    cli_constraints_free(&constraints);
    return status;
}

static int parse_words(int n, char **word)
{
    const cli_command *command = n ? cli_command_find(word[0]) : NULL;
    cli_args args;
    if (!command) return 0;
    int status = cli_args_parse(command, n, word, &args);
    if (status == EXIT_DONE && (command->id == COMMAND_fit || command->id == COMMAND_ndf)) status = read_constraints(&args);
    cli_args_free(&args);
    if (status != EXIT_DONE && status != EXIT_USAGE) fail("words", "neither taken nor a mistake of the person");
    return status == EXIT_DONE;
}

/* A word to a line, the first one a command. What is said of them goes nowhere. */
static int fuzz_words(char *text)
{
    enum { WORDS = 64 };
    static FILE *nowhere;
    FILE *const messages = stderr;
    char *word[WORDS + 1], *rest = text;
    int n = 0;
    if (!nowhere && !(nowhere = fopen("/dev/null", "w"))) fail("words", "no /dev/null");
    while (n < WORDS && rest) word[n++] = strsep(&rest, "\n");
    word[n] = NULL;
    stderr = nowhere;
    const int read = parse_words(n, word);
    stderr = messages;
    return read;
}

int fuzz_text(const char *target, const uint8_t *data, size_t size)
{
    char *text = malloc(size + 1);
    int read = -1;
    if (!text) fail(target, "no memory");
    if (size) memcpy(text, data, size);
    text[size] = '\0';
    if (strcmp(target, "json") == 0)
        read = fuzz_json(text, size);
    else if (strcmp(target, "fit_document") == 0)
        read = fuzz_fit_document(text, size);
    else if (strcmp(target, "expressions") == 0)
        read = fuzz_expressions(text);
    else if (strcmp(target, "words") == 0)
        read = fuzz_words(text);
    free(text);
    return read;
}
