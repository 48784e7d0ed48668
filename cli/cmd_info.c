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
    return ff_report_table_text(f->path, f->table, out);
}

int cmd_info(const cli_args *args)
{
    ff_table table;
    ff_error err = {0};
    const file f = {args, args->word[0], &table};
    const ff_status failed = ff_table_read(f.path, cli_value(args, FLAG_FORMAT, NULL), &table, &err);
    if (failed != FF_OK) return cli_failed(failed, &err);
    const int status = cli_write_both(args, write_json, write_text, &f);
    ff_table_free(&table);
    return status;
}
