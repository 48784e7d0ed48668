/* facetfit diff OLD NEW: what moved between two summaries. */
#include "internal_batching.h"

typedef struct difference {
    const cli_args *args;
    batch_table before, after;
    batch_changes changes;
} difference;

static void put_counts(const difference *d, FILE *out)
{
    const size_t rows = d->changes.n_rows, n = d->changes.n;
    fprintf(out, "%zu row%s in both, %zu change%s\n", rows, rows == 1 ? "" : "s", n, n == 1 ? "" : "s");
}

static ff_status write_changes(const void *context, FILE *out)
{
    const difference *d = context;
    const ff_table_form form = (ff_table_form)cli_word(d->args, FLAG_TABLE, FF_TABLE_TEXT);
    const ff_status status = batch_changes_table(&d->changes, form, &d->args->style, out);
    if (form == FF_TABLE_TEXT) put_counts(d, out);
    return status;
}

static int compare(difference *d)
{
    ff_error err = {0};
    ff_status failed = batch_table_read(d->args->word[0], &d->before, &err);
    if (failed == FF_OK) failed = batch_table_read(d->args->word[1], &d->after, &err);
    if (failed == FF_OK) failed = batch_changes_find(&d->before, &d->after, cli_number(d->args, FLAG_LIMIT, 1), &d->changes);
    if (failed != FF_OK) return cli_failed(failed, &err);
    const int status = cli_write(d->args, "-", write_changes, d);
    if (status != EXIT_DONE) return status;
    return d->changes.n ? EXIT_ANSWER_IS_NO : EXIT_DONE;
}

int cmd_diff(const cli_args *args)
{
    difference d = {.args = args};
    const int status = compare(&d);
    batch_changes_free(&d.changes);
    batch_table_free(&d.before);
    batch_table_free(&d.after);
    return status;
}
