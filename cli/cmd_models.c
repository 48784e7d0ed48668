/* facetfit models: the registry of terms. */
#include "internal_cli.h"

static ff_status write_json(const void *head, FILE *out)
{
    return ff_report_models_json(head, out);
}

static ff_status write_text(const void *head, FILE *out)
{
    (void)head;
    return ff_report_models_text(out);
}

static ff_status write_markdown(const void *head, FILE *out)
{
    (void)head;
    return ff_report_models_markdown(out);
}

static ff_status write_table(const void *head, ff_table_form form, FILE *out)
{
    (void)head;
    return ff_report_models_table(form, out);
}

int cmd_models(const cli_args *args)
{
    if (cli_given(args, FLAG_MARKDOWN)) return cli_write("-", write_markdown, &args->head);
    return cli_report(args, &(cli_form){write_json, write_text, write_table, NULL}, &args->head);
}
