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
    const file f = {args, args->word[0], &table};
    int status = cli_read(args, f.path, 0, &table);
    if (status != EXIT_DONE) return status;
    status = cli_write_both(args, write_json, write_text, &f);
    ff_table_clear(&table);
    return status;
}
