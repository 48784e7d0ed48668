/* What a command writes. All outputs of one command, standard output among them, are one: where one fails none changes. */
#include "internal_cli.h"
#include <string.h>

/* Through `write` into one of `with`; NULL: alone. */
static int put(const char *path, cli_writer write, const void *context, ff_outputs *with)
{
    ff_output out;
    ff_error err = {0};
    ff_status status = ff_output_open_with(path, with, &out, &err);
    if (status != FF_OK) return cli_failed(status, &err);
    status = write(context, out.file);
    if (status != FF_OK) {
        ff_output_abort(&out);
        return cli_failed(status, NULL);
    }
    status = ff_output_commit(&out, &err);
    return status == FF_OK ? EXIT_DONE : cli_failed(status, &err);
}

int cli_print(cli_writer write, const void *context)
{
    return put("-", write, context, NULL);
}

int cli_write(const cli_args *args, const char *path, cli_writer write, const void *context)
{
    return put(path, write, context, args->outputs);
}

/* ---- all of a command ------------------------------------------------------------------------ */

int cli_outputs_commit(const cli_args *args)
{
    ff_error err = {0};
    const ff_status status = ff_outputs_commit(args->outputs, &err);
    return status == FF_OK ? EXIT_DONE : cli_failed(status, &err);
}

int cli_outputs_end(const cli_args *args, int status)
{
    const int failed = status == EXIT_DONE || status == EXIT_ANSWER_IS_NO ? cli_outputs_commit(args) : EXIT_DONE;
    ff_outputs_abort(args->outputs);
    return failed ? failed : status;
}

/* ---- reports --------------------------------------------------------------------------------- */

typedef struct text_job {
    cli_writer write;
    const void *context;
    const ff_report_style *style;
} text_job;

static ff_status write_folded(const void *context, FILE *out)
{
    const text_job *job = context;
    return ff_report_fold(job->write, job->context, job->style, out);
}

int cli_write_both(const cli_args *args, cli_writer json, cli_writer text, const void *context)
{
    const char *path = cli_value(args, FLAG_JSON, NULL);
    int status = path ? cli_write(args, path, json, context) : EXIT_DONE;
    if (status == EXIT_DONE && (!path || strcmp(path, "-")))
        status = cli_write(args, "-", write_folded, &(text_job){text, context, &args->style});
    return status == EXIT_DONE ? cli_outputs_commit(args) : status;
}

typedef struct table_job {
    const cli_form *form;
    ff_table_form as;
    const void *context;
} table_job;

static ff_status write_table(const void *context, FILE *out)
{
    const table_job *job = context;
    return job->form->table(job->context, job->as, out);
}

int cli_report(const cli_args *args, const cli_form *form, const void *context)
{
    const table_job job = {form, (ff_table_form)cli_word(args, FLAG_TABLE, FF_TABLE_TEXT), context};
    if (args->job) {
        const ff_status failed = form->json(context, args->job->json);
        return failed == FF_OK ? EXIT_DONE : cli_failed(failed, NULL);
    }
    if (job.as == FF_TABLE_TEXT) return cli_write_both(args, form->json, form->text, context);
    const char *path = cli_value(args, FLAG_JSON, NULL);
    int status = path ? cli_write(args, path, form->json, context) : EXIT_DONE;
    if (form->warnings) form->warnings(context, stderr);
    if (status == EXIT_DONE) status = cli_write(args, "-", write_table, &job);
    return status == EXIT_DONE ? cli_outputs_commit(args) : status;
}

/* ---- rows ------------------------------------------------------------------------------------ */

int cli_rows_open(const cli_args *args, cli_rows *rows)
{
    const char *path = cli_value(args, FLAG_JSON, NULL);
    ff_error err = {0};
    ff_status status = FF_OK;
    memset(rows, 0, sizeof *rows);
    rows->args = args;
    if (path) status = ff_output_open_with(path, args->outputs, &rows->json, &err);
    if (status != FF_OK) return cli_failed(status, &err);
    rows->with_json = path != NULL;
    if (!path || strcmp(path, "-")) status = ff_output_open_with("-", args->outputs, &rows->csv, &err);
    if (status != FF_OK) {
        cli_rows_abort(rows);
        return cli_failed(status, &err);
    }
    rows->with_csv = !path || strcmp(path, "-");
    if (!rows->with_json) return EXIT_DONE;
    ff_json_begin(&rows->writer, rows->json.file);
    ff_json_object(&rows->writer, NULL, FF_JSON_BLOCK);
    ff_report_head_json(&rows->writer, args->command->schema, &args->head);
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
    return status == FF_OK ? cli_outputs_commit(rows->args) : cli_failed(status, &err);
}

void cli_rows_abort(cli_rows *rows)
{
    if (rows->with_json) ff_output_abort(&rows->json);
    if (rows->with_csv) ff_output_abort(&rows->csv);
    rows->with_json = rows->with_csv = 0;
}
