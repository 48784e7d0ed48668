/* facetfit info FILE: what is in a file. */
#include "internal_cli.h"

typedef struct file {
    const cli_args *args;
    const char *path;
    const ff_table *table;
} file;

static ff_status write_json(const void *context, FILE *out)
{
    const file *f = context;
    return ff_report_table_json(&f->args->head, f->path, f->table, out);
}

static ff_status write_text(const void *context, FILE *out)
{
    const file *f = context;
    const ff_status status = ff_report_table_text(f->path, f->table, &f->args->style, out);
    return status == FF_OK && cli_switch(f->args, FLAG_EXPLAIN, 0) ? ff_report_samples_text(f->table, 8, out) : status;
}

static ff_status write_table(const void *context, ff_table_form form, FILE *out)
{
    return ff_report_channels_table(((const file *)context)->table, form, out);
}

int cmd_info(const cli_args *args)
{
    ff_table table;
    const file f = {args, args->word[0], &table};
    int status = cli_read(args, f.path, 0, &table);
    if (status != EXIT_DONE) return status;
    status = cli_page_table(args, f.path, &table);
    if (status == EXIT_DONE) status = cli_report(args, &(cli_form){write_json, write_text, write_table, NULL}, &f);
    ff_table_clear(&table);
    return status;
}
