/* Messages, numbers, models with parameters, outputs, Ctrl-C. */
#define _GNU_SOURCE
#include "internal_cli.h"
#include "ff_profile_file.h"
#include "base/internal_number.h"
#include <math.h>
#include <signal.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

/* ---- messages -------------------------------------------------------------------------------- */

static void put_message(const char *format, va_list args)
{
    fputs("facetfit: ", stderr);
    vfprintf(stderr, format, args);
    fputc('\n', stderr);
}

void cli_message(const char *format, ...)
{
    va_list args;
    va_start(args, format);
    put_message(format, args);
    va_end(args);
}

int cli_usage(const cli_args *args, const char *format, ...)
{
    va_list list;
    va_start(list, format);
    put_message(format, list);
    va_end(list);
    cli_message("see 'facetfit %s --help'", args->command->name);
    return EXIT_USAGE;
}

int cli_exit_status(ff_status status)
{
    switch (status) {
    case FF_OK:
        return EXIT_DONE;
    case FF_ERR_RANGE:
    case FF_ERR_UNKNOWN:
    case FF_ERR_SYNTAX:
    case FF_ERR_UNSUPPORTED:
        return EXIT_USAGE;
    case FF_ERR_OPEN:
    case FF_ERR_READ:
    case FF_ERR_FORMAT:
    case FF_ERR_DATA:
        return EXIT_INPUT;
    case FF_ERR_WRITE:
        return EXIT_OUTPUT;
    case FF_ERR_CANCELLED:
        return 128 + SIGINT;
    default:
        return EXIT_INTERNAL;
    }
}

int cli_failed(ff_status status, const ff_error *err)
{
    char text[FF_ERROR_PATH + FF_ERROR_MESSAGE + 128] = "";
    if (err) {
        ff_error named = *err;
        if (!strcmp(named.path, "-")) strcpy(named.path, status == FF_ERR_WRITE ? "standard output" : "standard input");
        ff_words_error(&named, text, sizeof text);
    }
    cli_message("%s", *text ? text : ff_status_str(status));
    return cli_exit_status(status);
}

void cli_notes(const char *path, const ff_table *t)
{
    char text[FF_WORDS_SENTENCE];
    for (size_t k = 0; ff_words_note(t, k, text); ++k) cli_message("%s: %s", path, text);
}

/* ---- values of flags ------------------------------------------------------------------------- */

int cli_number(const cli_args *args, cli_flag_id flag, double lo, double hi, double *out)
{
    const char *text = cli_value(args, flag, NULL);
    double x = 0;
    if (!text) return EXIT_DONE;
    const char *end = ff_number_read(text, &x);
    if (!end || *end || !(x >= lo && x <= hi)) {
        char a[FF_REPORT_NUMBER], b[FF_REPORT_NUMBER];
        return cli_usage(args, "--%s %s: expected a number from %s to %s", cli_flag_name(flag), text, ff_report_number(lo, a),
                         ff_report_number(hi, b));
    }
    *out = x;
    return EXIT_DONE;
}

int cli_integer(const cli_args *args, cli_flag_id flag, uint64_t hi, uint64_t *out)
{
    const char *text = cli_value(args, flag, NULL);
    uint64_t n = 0;
    int good = text && *text;
    for (const char *p = text; good && *p; ++p) {
        const uint64_t digit = (uint64_t)(*p - '0');
        good = *p >= '0' && *p <= '9' && n <= (hi - digit) / 10;
        n = 10 * n + digit;
    }
    if (!text) return EXIT_DONE;
    if (!good)
        return cli_usage(args, "--%s %s: expected a whole number from 0 to %llu", cli_flag_name(flag), text,
                         (unsigned long long)hi);
    *out = n;
    return EXIT_DONE;
}

int cli_choice(const cli_args *args, cli_flag_id flag, int (*find)(const char *), const char *(*name)(int), int count, int *out)
{
    const char *text = cli_value(args, flag, NULL);
    char known[256] = "";
    if (!text) return EXIT_DONE;
    const int found = find(text);
    if (found >= 0) {
        *out = found;
        return EXIT_DONE;
    }
    for (int i = 0; i < count; ++i) snprintf(known + strlen(known), sizeof known - strlen(known), "%s%s", i ? ", " : "", name(i));
    return cli_usage(args, "--%s %s: expected one of %s", cli_flag_name(flag), text, known);
}

static const char *isa_name(int isa)
{
    return isa == FF_ISA_BEST ? "best" : ff_isa_name((ff_isa)isa);
}

int cli_isa(const cli_args *args, ff_isa *out)
{
    int isa = FF_ISA_BEST;
    const int status = cli_choice(args, FLAG_ISA, ff_isa_find, isa_name, 4, &isa);
    if (status != EXIT_DONE) return status;
    if (!ff_isa_available((ff_isa)isa))
        return cli_usage(args, "--isa %s: this processor or this build does not have it", isa_name(isa));
    *out = (ff_isa)isa;
    return EXIT_DONE;
}

/* ---- a model and its parameters -------------------------------------------------------------- */

int cli_each_word(const cli_args *args, cli_flag_id flag, int (*apply)(const cli_args *args, const char *word, void *context),
                  void *context)
{
    int status = EXIT_DONE;
    for (size_t i = 0; i < args->n_given && status == EXIT_DONE; ++i) {
        if (args->flag[i] != (int)flag) continue;
        char *copy = strdup(args->value[i]), *rest = copy, *one;
        if (!copy) return cli_failed(FF_ERR_MEMORY, NULL);
        while (status == EXIT_DONE && (one = strsep(&rest, ",")))
            if (*one) status = apply(args, one, context);
        free(copy);
    }
    return status;
}

/* ---- tables ---------------------------------------------------------------------------------- */

int cli_tables_read(const cli_args *args, cli_tables *out)
{
    const char *path = cli_value(args, FLAG_TABLE, NULL);
    ff_error err = {0};
    *out = (cli_tables){NULL};
    if (!path) return EXIT_DONE;
    ff_profile_table *profile = malloc(sizeof *profile);
    const ff_status status = profile ? ff_profile_read(path, profile, &err) : FF_ERR_MEMORY;
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
    return ff_error_set(err, FF_ERR_UNSUPPORTED, NULL, 0, -1, "tabulated needs the table of its profile: --table FILE");
}

/* ---- parameters that are held or free -------------------------------------------------------- */

typedef struct holding {
    ff_model *m;
    int where_present;
} holding;

static int said(const cli_args *args, cli_flag_id flag, const char *word, const holding *h, ff_status status, const ff_error *err)
{
    (void)args;
    if (status == FF_OK || (status == FF_ERR_UNKNOWN && h->where_present)) return EXIT_DONE;
    cli_message("--%s %s: %s", cli_flag_name(flag), word, err->message);
    return cli_exit_status(status);
}

static int free_one(const cli_args *args, const char *word, void *context)
{
    const holding *h = context;
    ff_error err = {0};
    return said(args, FLAG_FREE, word, h, ff_model_free(h->m, word, &err), &err);
}

static int fix_one(const cli_args *args, const char *word, void *context)
{
    const holding *h = context;
    ff_error err = {0};
    double value;
    char name[64];
    const char *equals = strchr(word, '='), *end = equals ? ff_number_read(equals + 1, &value) : NULL;
    if (!end || *end || (size_t)(equals - word) >= sizeof name) return cli_usage(args, "--fix %s: expected NAME=VALUE", word);
    snprintf(name, sizeof name, "%.*s", (int)(equals - word), word);
    return said(args, FLAG_FIX, word, h, ff_model_hold(h->m, name, value, &err), &err);
}

int cli_hold_and_free(const cli_args *args, ff_model *m, int where_present)
{
    holding h = {m, where_present};
    const int status = cli_each_word(args, FLAG_FREE, free_one, &h);
    return status == EXIT_DONE ? cli_each_word(args, FLAG_FIX, fix_one, &h) : status;
}

/* Models of a comparison. */
typedef struct model_set {
    const ff_model *model;
    size_t n;
} model_set;

static int known_to_any(const cli_args *args, const char *word, void *context)
{
    const model_set *set = context;
    ff_error err = {0};
    char name[64];
    snprintf(name, sizeof name, "%.*s", (int)strcspn(word, "="), word);
    for (size_t i = 0; i < set->n; ++i) {
        ff_model m = set->model[i];
        if (ff_model_free(&m, name, &err) == FF_OK) return EXIT_DONE;
    }
    return cli_usage(args, "none of the models has a parameter '%s'", name);
}

int cli_names_known(const cli_args *args, const ff_model *model, size_t n)
{
    model_set set = {model, n};
    const int status = cli_each_word(args, FLAG_FREE, known_to_any, &set);
    return status == EXIT_DONE ? cli_each_word(args, FLAG_FIX, known_to_any, &set) : status;
}

/* ---- scenes ---------------------------------------------------------------------------------- */

static int count_channels(const cli_args *args, const char *assignment, void *context)
{
    size_t n = 1, *most = context;
    (void)args;
    for (const char *p = assignment; *p; ++p) n += *p == ':';
    if (n > *most) *most = n;
    return EXIT_DONE;
}

static int assign(const cli_args *args, const char *assignment, void *context)
{
    cli_scene *s = context;
    ff_error err = {0};
    const ff_status status = ff_model_set(&s->model, s->n_channels, assignment, s->shape, s->channel, &err);
    if (status == FF_OK) return EXIT_DONE;
    cli_message("--set %s: %s", assignment, err.message);
    (void)args;
    return cli_exit_status(status);
}

int cli_scene_make(const cli_args *args, const char *expression, size_t least_channels, cli_scene *out)
{
    ff_error err = {0};
    cli_scene s = {.n_channels = least_channels};
    ff_status status = ff_model_parse(expression, &s.model, &err);
    if (status != FF_OK) return cli_failed(status, &err);
    int code = cli_tables_read(args, &s.tables);
    if (code != EXIT_DONE) return code;
    if ((status = cli_tables_give(&s.tables, &s.model, &err)) != FF_OK) return cli_failed(status, &err);
    cli_each_word(args, FLAG_SET, count_channels, &s.n_channels);
    s.channel = malloc((s.n_channels * s.model.n_channel + 1) * sizeof *s.channel);
    if (s.channel) ff_model_defaults(&s.model, s.n_channels, s.shape, s.channel);
    code = s.channel ? cli_each_word(args, FLAG_SET, assign, &s) : cli_failed(FF_ERR_MEMORY, NULL);
    if (code == EXIT_DONE && (status = ff_model_check(&s.model, s.n_channels, s.shape, s.channel, &err)) != FF_OK)
        code = cli_failed(status, &err);
    if (code != EXIT_DONE) {
        cli_scene_free(&s);
        return code;
    }
    *out = s;
    return EXIT_DONE;
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

/* ---- outputs --------------------------------------------------------------------------------- */

int cli_write(const char *path, cli_writer write, const void *context)
{
    ff_output out;
    ff_error err = {0};
    ff_status status = ff_output_open(path, &out, &err);
    if (status != FF_OK) return cli_failed(status, &err);
    status = write(context, out.file);
    if (status != FF_OK) {
        ff_output_abort(&out);
        return cli_failed(status, NULL);
    }
    status = ff_output_commit(&out, &err);
    return status == FF_OK ? EXIT_DONE : cli_failed(status, &err);
}

int cli_write_both(const cli_args *args, cli_writer json, cli_writer text, const void *context)
{
    const char *path = cli_value(args, FLAG_JSON, NULL);
    const int status = path ? cli_write(path, json, context) : EXIT_DONE;
    if (status != EXIT_DONE || (path && !strcmp(path, "-"))) return status;
    return cli_write("-", text, context);
}

int cli_rows_open(const cli_args *args, const char *schema, cli_rows *rows)
{
    const char *path = cli_value(args, FLAG_JSON, NULL);
    ff_error err = {0};
    ff_status status = FF_OK;
    memset(rows, 0, sizeof *rows);
    if (path) status = ff_output_open(path, &rows->json, &err);
    if (status != FF_OK) return cli_failed(status, &err);
    rows->with_json = path != NULL;
    if (!path || strcmp(path, "-")) status = ff_output_open("-", &rows->csv, &err);
    if (status != FF_OK) {
        cli_rows_abort(rows);
        return cli_failed(status, &err);
    }
    rows->with_csv = !path || strcmp(path, "-");
    if (!rows->with_json) return EXIT_DONE;
    ff_json_begin(&rows->writer, rows->json.file);
    ff_json_object(&rows->writer, NULL, FF_JSON_BLOCK);
    ff_report_head_json(&rows->writer, schema, &args->head);
    ff_json_array(&rows->writer, "columns", FF_JSON_LINE);
    return EXIT_DONE;
}

void cli_rows_column(cli_rows *rows, const char *name)
{
    if (rows->with_csv) fprintf(rows->csv.file, "%s%s", rows->column ? "," : "", name);
    if (rows->with_json) ff_json_string(&rows->writer, NULL, name);
    rows->column++;
}

void cli_rows_end_header(cli_rows *rows)
{
    if (rows->with_csv) fputc('\n', rows->csv.file);
    if (rows->with_json) {
        ff_json_close(&rows->writer);
        ff_json_array(&rows->writer, "rows", FF_JSON_BLOCK);
    }
    rows->column = 0;
}

void cli_rows_number(cli_rows *rows, double x)
{
    char text[FF_REPORT_NUMBER];
    if (rows->with_csv) {
        if (rows->column) fputc(',', rows->csv.file);
        fputs(ff_report_number(x, text), rows->csv.file);
    }
    if (rows->with_json) {
        if (!rows->column) ff_json_array(&rows->writer, NULL, FF_JSON_LINE);
        ff_json_number(&rows->writer, NULL, x);
    }
    rows->column++;
}

void cli_rows_end_row(cli_rows *rows)
{
    if (rows->with_csv) fputc('\n', rows->csv.file);
    if (rows->with_json) ff_json_close(&rows->writer);
    rows->column = 0;
}

int cli_rows_commit(cli_rows *rows)
{
    ff_error err = {0};
    ff_status status = FF_OK;
    if (rows->with_json) {
        ff_json_close(&rows->writer);
        ff_json_close(&rows->writer);
        ff_json_end(&rows->writer);
        status = ff_output_commit(&rows->json, &err);
        rows->with_json = 0;
    }
    if (status == FF_OK && rows->with_csv) {
        status = ff_output_commit(&rows->csv, &err);
        rows->with_csv = 0;
    }
    cli_rows_abort(rows);
    return status == FF_OK ? EXIT_DONE : cli_failed(status, &err);
}

void cli_rows_abort(cli_rows *rows)
{
    if (rows->with_json) ff_output_abort(&rows->json);
    if (rows->with_csv) ff_output_abort(&rows->csv);
    rows->with_json = rows->with_csv = 0;
}

/* ---- Ctrl-C ---------------------------------------------------------------------------------- */

/* The one thing a handler may touch. */
static volatile int cancelled;

static void on_signal(int signal_number)
{
    (void)signal_number;
    cancelled = 1;
}

const volatile int *cli_catch_signals(void)
{
    struct sigaction action = {.sa_handler = on_signal, .sa_flags = (int)SA_RESETHAND};
    sigemptyset(&action.sa_mask);
    sigaction(SIGINT, &action, NULL);
    sigaction(SIGTERM, &action, NULL);
    return &cancelled;
}
