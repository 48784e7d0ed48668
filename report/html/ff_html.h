/** @file ff_html.h  A fit, a comparison or a table as one page that a browser opens from disk: HTML with its style, its script and
 *  its numbers inside.
 *
 *  The page asks for nothing from anywhere: a Content-Security-Policy in it forbids that. Without script it has the verdict,
 * figures as SVG, tables and the text of the report; the script (assets/) makes figures that can be handled of the numbers that are
 * in it. Numbers  samples are thinned so that the page stays within FF_HTML_FIT_MOST or FF_HTML_COMPARISON_MOST bytes, and the page
 * says by how much; figures that the script does not draw are of all samples. Text     what others named (files, channels) is
 * escaped in text, attributes and JSON. Errors   ff_status; FF_ERR_MEMORY. What went to the stream before is then incomplete, and
 * errors of the stream stay in it. Threads  no global state; the problems of the report belong to the caller's thread, as
 * ff_trust.h has it. */
#ifndef FF_HTML_H
#define FF_HTML_H
#include "ff_isa.h"
#include "report/ff_report.h"

enum { FF_HTML_FIT_MOST = 1000000, FF_HTML_COMPARISON_MOST = 2000000 };

/** Writes the page of a fit, or of a comparison where the report has several models.
 *  @param r       as for ff_report_fits_json; its table still has its samples
 *  @param sha256  of the file that was read, 64 hexadecimal digits; NULL: not known, as of standard input
 *  @param isa     of evaluations */
ff_status ff_html_fits_write(const ff_report_fits *r, const char *sha256, ff_isa isa, FILE *out, ff_error *err);

/** Writes the core of such a page as a part of another one: verdict, ranking of a comparison, parameters. It has no script and no
 * style but its own few lines. */
ff_status ff_html_summary_write(const ff_report_fits *r, ff_isa isa, FILE *out, ff_error *err);

/** Writes the page of a table. */
ff_status ff_html_table_write(const ff_report_head *head, const char *path, const ff_table *t, const char *sha256, FILE *out,
                              ff_error *err);

#endif
