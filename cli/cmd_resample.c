/* facetfit resample IN OUT: measured data in another format. */
#include "internal_cli.h"
#include "data_formats/interpolation/resample_struct.h"
#include <string.h>

typedef struct result {
    const cli_args *args;
    const ff_table *in, *out;
    const ff_format *to;
    const ff_resample_report *report;
} result;

static ff_status write_json(const void *context, FILE *out)
{
    const result *r = context;
    return ff_report_resample_json(&r->args->head, r->args->word[0], r->args->word[1], r->to, r->in, r->out, r->report, out);
}

static ff_status write_text(const void *context, FILE *out)
{
    const result *r = context;
    return ff_report_resample_text(r->args->word[0], r->args->word[1], r->to, r->in, r->out, r->report, out);
}

/* Where the data go to stdout, what was lost of them goes to stderr, and the rest to the file of --json alone. */
static int report_conversion(const result *r)
{
    const char *json = cli_value(r->args, FLAG_JSON, NULL);
    if (strcmp(r->args->word[1], "-")) return cli_write_both(r->args, write_json, write_text, r);
    char warning[FF_WORDS_SENTENCE];
    int status = json ? cli_write(r->args, json, write_json, r) : EXIT_DONE;
    if (status == EXIT_DONE) status = cli_outputs_commit(r->args);
    if (status != EXIT_DONE) return status;
    ff_report_resample_warning(r->report, warning);
    if (warning[0]) cli_warning("%s: %s", r->args->word[0], warning);
    cli_notes(r->args->word[0], r->out);
    return EXIT_DONE;
}

int cmd_resample(const cli_args *args)
{
    ff_table in, out;
    ff_resample_options o;
    ff_resample_report report;
    ff_error err = {0};
    const ff_format *to = NULL;
    int status = cli_format_for_writing(args, FLAG_TO, args->word[1], &to);
    if (status == EXIT_DONE) status = cli_read(args, args->word[0], 1, &in);
    if (status != EXIT_DONE) return status;
    ff_resample_options_init(&o);
    o.grid = cli_value(args, FLAG_GRID, NULL);
    o.beyond = cli_given(args, FLAG_EXTRAPOLATE) > 0;
    o.threads = (int)cli_integer(args, FLAG_THREADS, 0);
    ff_status failed = ff_resample_into(&in, to, &o, &out, &report, &err);
    if (failed == FF_OK) {
        failed = to->write(args->word[1], &out, args->outputs, &err);
        const result r = {args, &in, &out, to, &report};
        if (failed == FF_OK) status = report_conversion(&r);
        ff_table_clear(&out);
    }
    ff_table_clear(&in);
    return failed == FF_OK ? status : cli_failed(failed, &err);
}
