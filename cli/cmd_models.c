/* facetfit models: the registry of terms. */
#include "internal_cli.h"
#include <string.h>

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

static ff_status write_one(const void *context, FILE *out)
{
    const cli_args *args = context;
    return ff_report_model_text(args->word[0], &args->style, out);
}

/* Looked up before anything is printed. */
static int show_one(const cli_args *args)
{
    const char *name = args->word[0];
    int known = ff_preset_find(name) != NULL;
    for (int kind = 0; kind < FF_TERM_KINDS; kind++) known |= ff_term_find((ff_term_kind)kind, name) >= 0;
    if (known) return cli_print(write_one, args);
    const char *nearest = cli_words_nearest(cli_words_term, name, strlen(name));
    return cli_usage(args, "%s: no term and no preset is called so%s%s%s", name, nearest ? "; did you mean '" : "",
                     nearest ? nearest : "", nearest ? "'?" : "");
}

int cmd_models(const cli_args *args)
{
    if (args->n_words && (cli_given(args, FLAG_MARKDOWN) || cli_given(args, FLAG_JSON) || cli_given(args, FLAG_TABLE)))
        return cli_usage(args, "one term is text: leave out '%s', or --json, --table and --markdown", args->word[0]);
    if (args->n_words) return show_one(args);
    if (cli_given(args, FLAG_MARKDOWN)) return cli_print(write_markdown, args);
    return cli_report(args, &(cli_form){write_json, write_text, write_table, NULL}, args);
}
