/* Parts that every page is made of: text that is safe in HTML, JSON that is safe in a script element, figures. */
#ifndef FF_INTERNAL_PAGE_H
#define FF_INTERNAL_PAGE_H
#include "ff_html.h"
#include "report/internal_text.h"
#include "report/plot/internal_figure.h"

/* A page that is being written. The first error stays; what follows one does nothing. */
typedef struct ff_page {
    FILE *out;
    ff_status status;
    ff_error *err;
    size_t figures; /* so far */
} ff_page;

typedef enum ff_page_kind { FF_PAGE_FIT, FF_PAGE_COMPARISON, FF_PAGE_TABLE } ff_page_kind;

/* Title is text. The script follows the JSON, at the end. */
void ff_page_begin(ff_page *p, ff_page_kind kind, const char *title, const char *subtitle);
void ff_page_end(ff_page *p, ff_page_kind kind);

/* Text with '<', '>', '&', quotes as references, controls and what is no UTF-8 as U+FFFD. */
void ff_page_text(ff_page *p, const char *text);
void ff_page_format(ff_page *p, const char *format, ...) __attribute__((format(printf, 2, 3))); /* as it is */
void ff_page_note(ff_page *p, const char *format, ...) __attribute__((format(printf, 2, 3)));   /* a paragraph of text */

/* The command as a shell takes it, the version, and which file it was; sha256 may be NULL. */
void ff_page_put_command(const ff_report_head *head, const char *sha256, FILE *out);

/* A section with its heading, of which the table of contents knows by its id. */
void ff_page_section(ff_page *p, const char *id, const char *heading);
void ff_page_section_end(ff_page *p);

/* What `write` writes, JSON, inside a script element that is not run: without white space, '<', '>', '&' and the line separators
 * of Unicode as escapes. */
void ff_page_json(ff_page *p, const char *id, ff_status (*write)(const void *context, FILE *out), const void *context);
/* What `write` writes, text, in a block that keeps its lines. */
void ff_page_block(ff_page *p, const char *label, ff_status (*write)(const void *context, FILE *out), const void *context);

/* The figure as SVG, in a `figure` element with this id; what the script draws in its place is its own matter, but where
 * with_numbers its series are there for it as JSON. Empties fig. A figure that could not be built is said: status, reason. */
void ff_page_figure(ff_page *p, const char *id, const char *caption, ff_figure *fig, ff_status status, const ff_error *reason,
                    int with_numbers);

/* svg.c: the figure as an SVG document. As ff_figure_write. */
ff_status ff_page_svg(const ff_figure *fig, FILE *out, ff_error *err);

/* Keeps the first status that is not FF_OK. */
void ff_page_fail(ff_page *p, ff_status status);

/* x with so many significant digits, so that it is short in JSON. */
double ff_page_rounded(double x, int digits);
/* An array of n numbers with stride, digits significant ones each. */
void ff_page_numbers(ff_json *j, const char *key, size_t n, const double *x, size_t stride, int digits);

/* assets.c: style and scripts as they lie in assets/. */
void ff_page_put_style(FILE *out);
void ff_page_put_scripts(ff_page_kind kind, FILE *out);

#endif
