/* --html: a report as a page. */
#include "internal_cli.h"
#include "base/internal_sha256.h"
#include "report/html/ff_html.h"

/* What the page is of: fits, or where that is NULL a table. */
typedef struct page {
    const cli_args *args;
    const ff_report_fits *fits;
    const char *path;
    const ff_table *table;
} page;

/* Says itself what went wrong, which the writer of a document cannot. */
static ff_status write_page(const void *context, FILE *out)
{
    const page *p = context;
    char digits[FF_SHA256_TEXT];
    ff_error err = {0};
    ff_isa isa = FF_ISA_BEST;
    const char *sha256 = ff_sha256_file(p->path, digits) ? digits : NULL;
    if (p->fits && cli_isa(p->args, &isa) != EXIT_DONE) return FF_ERR_UNSUPPORTED;
    return p->fits ? ff_html_fits_write(p->fits, sha256, isa, out, &err)
                   : ff_html_table_write(&p->args->head, p->path, p->table, sha256, out, &err);
}

static int write_where_asked(const page *p)
{
    const char *path = cli_value(p->args, FLAG_HTML, NULL);
    if (path && p->args->job) return write_page(p, p->args->job->html) == FF_OK ? EXIT_DONE : EXIT_INTERNAL;
    return path ? cli_write(p->args, path, write_page, p) : EXIT_DONE;
}

int cli_page_fits(const cli_args *args, const ff_report_fits *report)
{
    return write_where_asked(&(page){args, report, report->path, NULL});
}

int cli_page_table(const cli_args *args, const char *path, const ff_table *t)
{
    return write_where_asked(&(page){args, NULL, path, t});
}
