/* The index of a batch as a page: a row for each file, with a lit sphere, that leads to its own page. It asks for nothing from
 * anywhere, needs no script, and has nothing but what the results have. */
#include "internal_batch.h"
#include "report/internal_text.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

static const char style[] =
    "body{font:15px/1.4 system-ui,sans-serif;margin:2em auto;max-width:70em;padding:0 1em;color:#222;background:#fff}"
    "table{border-collapse:collapse;width:100%}td{overflow-wrap:break-word}td,th{padding:.3em "
    ".6em;text-align:left;vertical-align:top;"
    "border-bottom:1px solid #ddd}td.n{text-align:right;font-variant-numeric:tabular-nums}.failed,.missing,.poor{color:#a11}"
    ".fair{color:#850}.good{color:#161}small{color:#555}"
    "@media(prefers-color-scheme:dark){body{color:#ddd;background:#181818}td,th{border-color:#444}a{color:#8bf}"
    ".failed,.missing,.poor{color:#f88}.fair{color:#fc6}.good{color:#8d8}small{color:#aaa}}";

/* Text that others chose, in text and in attributes; what a terminal would obey is no text. */
static void put_text(const char *text, FILE *out)
{
    for (uint32_t code; *text;) {
        const size_t n = ff_text_sequence(text, &code);
        const char *word = *text == '&' ? "&amp;" : *text == '<' ? "&lt;" : *text == '>' ? "&gt;" : *text == '"' ? "&quot;" : NULL;
        if (word)
            fputs(word, out);
        else if (*text == '\n')
            fputs("; ", out);
        else if (n && !ff_text_is_control(code))
            fwrite(text, 1, n, out);
        else
            fprintf(out, "\\x%02x", (unsigned char)*text);
        text += n ? n : 1;
    }
}

/* As a part of an address: everything but what is plain in all of them as %XX. */
static void put_address(const char *text, FILE *out)
{
    static const char plain[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789-_.~/";
    for (; *text; text++)
        if (strchr(plain, *text))
            fputc(*text, out);
        else
            fprintf(out, "%%%02X", (unsigned char)*text);
}

static void put_link(const batch_index *x, size_t job, FILE *out)
{
    const batch_input *in = &x->s.inputs->at[job];
    const int has_page = x->has_page && x->has_page[job], has_result = x->s.rows[job].n > 0;
    if (has_page || has_result) {
        fputs("<a href=\"", out);
        put_address(x->way, out);
        char *page = has_page ? batch_page_name(in->name) : NULL;
        put_address(page ? page : in->name, out);
        free(page);
        fputs("\">", out);
    }
    put_text(in->path, out);
    if (has_page || has_result) fputs("</a>", out);
}

static void put_values(const batch_row *r, FILE *out)
{
    enum { SHOWN = 8 };
    char value[FF_TEXT_NUMBER], error[FF_TEXT_NUMBER];
    size_t shown = 0, more = 0;
    for (size_t k = 0; k < r->n_values; k++) {
        if (r->value[k].tied) continue; /* it says what another says */
        if (shown == SHOWN) {
            more++;
            continue;
        }
        ff_text_with_error(r->value[k].value, r->value[k].error, value, error);
        fputs(shown++ ? ", " : "", out);
        put_text(r->value[k].name, out);
        fprintf(out, "&nbsp;%s", value);
        if (r->value[k].error > 0) fprintf(out, "&nbsp;±&nbsp;%s", error);
    }
    if (more) fprintf(out, ", and %zu more", more);
}

/* A name that may be wrapped between its terms. */
static void put_model(const char *model, FILE *out)
{
    char term[2] = "";
    for (; *model; model++) {
        term[0] = *model;
        put_text(term, out);
        if (*model == '/' || *model == '+') fputs("<wbr>", out);
    }
}

static void put_row(const batch_index *x, const batch_line *l, FILE *out)
{
    const batch_rows *of = l->rows;
    const batch_row *r = l->row;
    char share[FF_TEXT_NUMBER];
    const char *word = !r ? batch_state_name((int)of->state) : *r->quality ? r->quality : r->outcome;
    fputs("<tr><td>", out);
    if (r && of->picture)
        fprintf(out, "<img width=\"%d\" height=\"%d\" alt=\"lit sphere\" src=\"data:image/png;base64,%s\">", BATCH_THUMBNAIL,
                BATCH_THUMBNAIL, of->picture);
    fputs("</td><td>", out);
    put_link(x, l->job, out);
    if (r) fputs("<br><small>", out);
    if (r) put_model(r->model, out);
    if (r) fputs("</small>", out);
    fprintf(out, "</td><td class=\"%s\">", word);
    put_text(word, out);
    if (r) {
        fprintf(out, "</td><td class=\"n\">%s</td><td>", isfinite(r->explained) ? ff_text_fixed(100 * r->explained, 2, share) : "");
        put_values(r, out);
        fputs("</td><td><small>", out);
        put_text(r->warnings, out);
    } else {
        fputs("</td><td colspan=\"3\"><small>", out); /* a message is long */
    }
    if (of->message) fputs(r && *r->warnings ? "<br>" : "", out);
    put_text(of->message ? of->message : "", out);
    fputs("</small></td></tr>\n", out);
}

ff_status batch_index_html(const void *index, FILE *out)
{
    const batch_index *x = index;
    size_t n = 0;
    const size_t n_files = x->s.inputs->n;
    const char *s = n_files == 1 ? "" : "s";
    batch_line *l = batch_lines_of(&x->s, &n);
    if (!l) return FF_ERR_MEMORY;
    fprintf(
        out,
        "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\n"
        "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; img-src data:; style-src 'unsafe-inline'\">\n"
        "<meta name=\"viewport\" content=\"width=device-width\">\n<title>%zu file%s, by "
        "facetfit</title>\n<style>%s</style></head>\n"
        "<body><h1>%zu file%s</h1>\n<p>The worst first. <code>",
        n_files, s, style, n_files, s);
    for (size_t k = 0; k < x->s.head.n_command; k++) {
        fputs(k ? " " : "", out);
        put_text(x->s.head.command[k], out);
    }
    fputs("</code></p>\n<table><thead><tr><th></th><th>file</th><th>fit</th><th>explained, %</th><th>parameters</th>"
          "<th>warnings</th></tr></thead>\n<tbody>\n",
          out);
    for (size_t k = 0; k < n; k++) put_row(x, &l[k], out);
    fputs("</tbody></table></body></html>\n", out);
    free(l);
    return FF_OK;
}
