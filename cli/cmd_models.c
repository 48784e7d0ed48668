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

int cmd_models(const cli_args *args)
{
    if (cli_given(args, FLAG_MARKDOWN)) return cli_write("-", write_markdown, &args->head);
    return cli_write_both(args, write_json, write_text, &args->head);
}
