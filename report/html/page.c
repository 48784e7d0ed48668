/* The frame of a page, and what is safe in it. */
#include "internal_page.h"
#include <math.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

static const char *const kind_name[] = {[FF_PAGE_FIT] = "fit", [FF_PAGE_COMPARISON] = "comparison", [FF_PAGE_TABLE] = "table"};

void ff_page_fail(ff_page *p, ff_status status)
{
    if (!p->status) p->status = status;
}

/* ---- text ------------------------------------------------------------------------------------ */

void ff_page_text(ff_page *p, const char *text)
{
    while (*text) {
        uint32_t code = 0;
        const size_t n = ff_text_sequence(text, &code);
        if (code == '\n' && n)
            fputc('\n', p->out);
        else if (n == 0 || ff_text_is_control(code) || code == 0xfffe || code == 0xffff)
            fputs("\xef\xbf\xbd", p->out);
        else if (strchr("<>&\"'", (int)code) && code < 128)
            fprintf(p->out, "&#%u;", (unsigned)code);
        else
            fwrite(text, 1, n, p->out);
        text += n ? n : 1;
    }
}

void ff_page_format(ff_page *p, const char *format, ...)
{
    va_list args;
    va_start(args, format);
    vfprintf(p->out, format, args);
    va_end(args);
}

void ff_page_note(ff_page *p, const char *format, ...)
{
    char text[FF_WORDS_SENTENCE];
    va_list args;
    va_start(args, format);
    vsnprintf(text, sizeof text, format, args);
    va_end(args);
    fputs("<p>", p->out);
    ff_page_text(p, text);
    fputs("</p>\n", p->out);
}

/* A word as a shell takes it. */
static void put_word(FILE *out, const char *word)
{
    static const char plain[] = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_./-+=,:@%";
    if (*word && strspn(word, plain) == strlen(word)) {
        fputs(word, out);
        return;
    }
    fputc('\'', out);
    for (; *word; word++) {
        if (*word == '\'')
            fputs("'\\''", out);
        else
            fputc(*word, out);
    }
    fputc('\'', out);
}

void ff_page_put_command(const ff_report_head *head, const char *sha256, FILE *out)
{
    for (size_t i = 0; i < head->n_command; i++) {
        if (i) fputc(' ', out);
        put_word(out, head->command[i]);
    }
    fprintf(out, "\n# version %s\n", head->version);
    if (sha256) fprintf(out, "# SHA-256 of the input %s\n", sha256);
}

/* ---- the frame ------------------------------------------------------------------------------- */

void ff_page_begin(ff_page *p, ff_page_kind kind, const char *title, const char *subtitle)
{
    fputs("<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
          "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; style-src 'unsafe-inline'; script-src "
          "'unsafe-inline'; img-src data: blob:; base-uri 'none'; form-action 'none'\">\n"
          "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<meta name=\"color-scheme\" content=\"light "
          "dark\">\n<title>",
          p->out);
    ff_page_text(p, title);
    fputs("</title>\n<style>\n", p->out);
    ff_page_put_style(p->out);
    fprintf(p->out, "</style>\n</head>\n<body data-kind=\"%s\">\n<header>\n<h1>", kind_name[kind]);
    ff_page_text(p, title);
    fputs("</h1>\n<p>", p->out);
    ff_page_text(p, subtitle);
    fputs("</p>\n</header>\n<main>\n", p->out);
}

void ff_page_end(ff_page *p, ff_page_kind kind)
{
    fputs("</main>\n<p id=\"said\" role=\"status\" class=\"quiet\"></p>\n<script>\n", p->out);
    ff_page_put_scripts(kind, p->out);
    fputs("</script>\n</body>\n</html>\n", p->out);
}

void ff_page_section(ff_page *p, const char *id, const char *heading)
{
    fprintf(p->out, "<section id=\"%s\" aria-labelledby=\"%s-heading\">\n<h2 id=\"%s-heading\">", id, id, id);
    ff_page_text(p, heading);
    fputs("</h2>\n", p->out);
}

void ff_page_section_end(ff_page *p)
{
    fputs("</section>\n", p->out);
}

/* ---- JSON ------------------------------------------------------------------------------------ */

/* A character of a string of the document. */
static size_t put_string_part(const char *text, FILE *out)
{
    const unsigned char *u = (const unsigned char *)text;
    if (*u == '<' || *u == '>' || *u == '&') {
        fprintf(out, "\\u%04x", (unsigned)*u);
        return 1;
    }
    if (u[0] == 0xe2 && u[1] == 0x80 && (u[2] == 0xa8 || u[2] == 0xa9)) {
        fprintf(out, "\\u202%c", u[2] == 0xa8 ? '8' : '9');
        return 3;
    }
    if (*u == '\\' && u[1]) {
        fwrite(text, 1, 2, out);
        return 2;
    }
    fputc(*u, out);
    return 1;
}

static void put_compact(const char *json, FILE *out)
{
    int inside = 0;
    while (*json) {
        if (*json == '"') {
            inside = !inside;
            fputc(*json++, out);
        } else if (inside) {
            json += put_string_part(json, out);
        } else {
            if (!strchr(" \n\t\r", *json)) fputc(*json, out);
            json++;
        }
    }
}

void ff_page_json(ff_page *p, const char *id, ff_status (*write)(const void *context, FILE *out), const void *context)
{
    char *text = NULL;
    if (p->status) return;
    ff_page_fail(p, ff_text_capture(write, context, &text));
    if (!p->status) {
        fprintf(p->out, "<script type=\"application/json\" id=\"%s\">", id);
        put_compact(text, p->out);
        fputs("</script>\n", p->out);
    }
    free(text);
}

void ff_page_block(ff_page *p, const char *label, ff_status (*write)(const void *context, FILE *out), const void *context)
{
    char *text = NULL;
    if (p->status) return;
    ff_page_fail(p, ff_text_capture(write, context, &text));
    if (!p->status) {
        fputs("<pre tabindex=\"0\" role=\"region\" aria-label=\"", p->out);
        ff_page_text(p, label);
        fputs("\">", p->out);
        ff_page_text(p, text);
        fputs("</pre>\n", p->out);
    }
    free(text);
}

double ff_page_rounded(double x, int digits)
{
    if (!isfinite(x) || x == 0) return x;
    const int up = digits - 1 - (int)floor(log10(fabs(x)));
    const double scale = pow(10, abs(up)), rounded = up >= 0 ? round(x * scale) / scale : round(x / scale) * scale;
    return isfinite(rounded) ? rounded : x; /* beyond 1e308 / scale */
}

void ff_page_numbers(ff_json *j, const char *key, size_t n, const double *x, size_t stride, int digits)
{
    ff_json_array(j, key, FF_JSON_LINE);
    for (size_t i = 0; i < n; i++) ff_json_number(j, NULL, ff_page_rounded(x[i * stride], digits));
    ff_json_close(j);
}

/* ---- figures --------------------------------------------------------------------------------- */

typedef struct figure_json {
    const ff_figure *fig;
} figure_json;

static void put_axis(ff_json *j, const char *key, const ff_axis *a)
{
    static const char *const scale[] = {"linear", "log", "angle", "names"};
    ff_json_object(j, key, FF_JSON_LINE);
    ff_json_string(j, "label", a->label);
    ff_json_string(j, "unit", a->unit);
    ff_json_string(j, "scale", scale[a->scale]);
    ff_json_number(j, "lo", a->lo);
    ff_json_number(j, "hi", a->hi);
    if (a->n_names) {
        ff_json_array(j, "names", FF_JSON_LINE);
        for (size_t k = 0; k < a->n_names; k++) ff_json_string(j, NULL, a->name[k]);
        ff_json_close(j);
    }
    ff_json_close(j);
}

static void put_series(ff_json *j, const ff_series *s)
{
    static const char *const plane[] = {"x", "y", "low", "high", "x_low", "x_high"};
    const double *const values[] = {s->x, s->y, s->low, s->high, s->x_low, s->x_high};
    ff_json_object(j, NULL, FF_JSON_LINE);
    ff_json_string(j, "kind", ff_series_kind_name((int)s->kind));
    ff_json_string(j, "name", s->name);
    ff_json_integer(j, "colour", s->style.colour);
    ff_json_integer(j, "dash", s->style.dash);
    for (size_t k = 0; k < 6; k++)
        if (values[k]) ff_page_numbers(j, plane[k], s->n, values[k], 1, 6);
    if (s->kind == FF_SERIES_IMAGE) {
        ff_json_integer(j, "nx", (int64_t)s->image.nx);
        ff_json_integer(j, "ny", (int64_t)s->image.ny);
        const double box[] = {s->image.x_lo, s->image.x_hi, s->image.y_lo, s->image.y_hi};
        ff_page_numbers(j, "box", 4, box, 1, 6);
        ff_page_numbers(j, "z", s->image.nx * s->image.ny, s->image.z, 1, 5);
    }
    ff_json_close(j);
}

static ff_status write_figure_json(const void *context, FILE *out)
{
    const ff_figure *fig = ((const figure_json *)context)->fig;
    ff_json j;
    ff_json_begin(&j, out);
    ff_json_object(&j, NULL, FF_JSON_LINE);
    ff_json_string(&j, "title", fig->title);
    ff_json_string(&j, "note", fig->note);
    ff_json_array(&j, "panels", FF_JSON_LINE);
    for (size_t i = 0; i < fig->n_panels; i++) {
        const ff_panel *p = fig->panel[i];
        ff_json_object(&j, NULL, FF_JSON_LINE);
        ff_json_string(&j, "title", p->title);
        put_axis(&j, "x", &p->x);
        put_axis(&j, "y", &p->y);
        ff_json_array(&j, "series", FF_JSON_LINE);
        for (size_t k = 0; k < p->n_series; k++) put_series(&j, p->series[k]);
        ff_json_close(&j);
        ff_json_close(&j);
    }
    ff_json_close(&j);
    ff_json_close(&j);
    return FF_OK;
}

typedef struct drawn {
    const ff_figure *fig;
    ff_error *err;
} drawn;

static ff_status write_svg(const void *context, FILE *out)
{
    const drawn *d = context;
    return ff_page_svg(d->fig, out, d->err);
}

/* The element `svg` without what stands before it; its clip paths have names of their own on the page. */
static void put_svg(ff_page *p, const char *svg, const char *label)
{
    static const char *const names[] = {"<clipPath id=\"", "clip-path=\"url(#"};
    svg = strstr(svg, "<svg");
    if (!svg) return;
    fputs("<svg role=\"img\" aria-label=\"", p->out);
    ff_page_text(p, label);
    fputc('"', p->out);
    svg += 4;
    while (*svg) {
        size_t length = 0;
        for (size_t k = 0; k < 2; k++)
            if (!strncmp(svg, names[k], strlen(names[k]))) length = strlen(names[k]);
        if (length) fprintf(p->out, "%.*sf%zu-", (int)length, svg, p->figures);
        if (!length) fputc(*svg, p->out);
        svg += length ? length : 1;
    }
}

void ff_page_figure(ff_page *p, const char *id, const char *caption, ff_figure *fig, ff_status status, const ff_error *reason,
                    int with_numbers)
{
    char *svg = NULL, name[64];
    ff_error unsaid = {0};
    if (!status) status = fig->status;
    if (!status) status = ff_text_capture(write_svg, &(drawn){fig, &unsaid}, &svg);
    if (status == FF_ERR_MEMORY) ff_page_fail(p, status);
    p->figures++;
    if (!p->status) {
        fprintf(p->out, "<figure id=\"%s\" class=\"plot\">\n<div class=\"drawn\">", id);
        if (!status) {
            put_svg(p, svg, caption);
        } else {
            const char *message = unsaid.message[0] ? unsaid.message : reason ? reason->message : "";
            ff_page_note(p, "Not drawn: %s.", *message ? message : ff_status_str(status));
        }
        fputs("</div>\n<figcaption>", p->out);
        ff_page_text(p, caption);
        fputs("</figcaption>\n</figure>\n", p->out);
        snprintf(name, sizeof name, "%s-numbers", id);
        if (!status && with_numbers) ff_page_json(p, name, write_figure_json, &(figure_json){fig});
    }
    free(svg);
    ff_figure_clear(fig);
}
