/* facetfit formats: the registry of file formats. */
#include "internal_cli.h"

static ff_status write_json(const void *args, FILE *out)
{
    return ff_report_formats_json(&((const cli_args *)args)->head, out);
}

static ff_status write_text(const void *args, FILE *out)
{
    return ff_report_formats_text(&((const cli_args *)args)->style, out);
}

static ff_status write_table(const void *args, ff_table_form form, FILE *out)
{
    (void)args;
    return ff_report_formats_table(form, out);
}

int cmd_formats(const cli_args *args)
{
    return cli_report(args, &(cli_form){write_json, write_text, write_table, NULL}, args);
}
