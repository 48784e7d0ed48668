/* facetfit models: the registry of terms. */
#include "internal_cli.h"

static ff_status write_json(const void *args, FILE *out)
{
    return ff_report_models_json(&((const cli_args *)args)->head, out);
}

static ff_status write_text(const void *args, FILE *out)
{
    return ff_report_models_text(&((const cli_args *)args)->style, out);
}

static ff_status write_markdown(const void *args, FILE *out)
{
    (void)args;
    return ff_report_models_markdown(out);
}

static ff_status write_table(const void *args, ff_table_form form, FILE *out)
{
    (void)args;
    return ff_report_models_table(form, out);
}

int cmd_models(const cli_args *args)
{
    if (cli_given(args, FLAG_MARKDOWN)) return cli_print(write_markdown, args);
    return cli_report(args, &(cli_form){write_json, write_text, write_table, NULL}, args);
}
