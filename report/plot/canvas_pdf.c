/* A canvas as PDF 1.4: one page, lines and text, Helvetica and Symbol of the fourteen fonts that every reader has. Nothing is
 * compressed and no date is written: the same figure is the same file. */
#include "internal_canvas.h"
#include "report/internal_text.h"
#include <math.h>
#include <stdarg.h>
#include <string.h>

enum { CATALOG = 1, PAGES, PAGE, CONTENT, LENGTH, HELVETICA, SYMBOL, INFO, OBJECTS };

typedef struct pdf {
    FILE *out;
    long at, place[OBJECTS]; /* bytes written; where objects begin */
    double height;
} pdf;

/* ---- bytes ----------------------------------------------------------------------------------- */

static void put_bytes(pdf *p, const char *text, size_t n)
{
    fwrite(text, 1, n, p->out);
    p->at += (long)n;
}

static void put(pdf *p, const char *text)
{
    put_bytes(p, text, strlen(text));
}

static void put_number(pdf *p, double x)
{
    char text[FF_POINT + 1];
    size_t n = ff_point_text(x, text);
    text[n++] = ' ';
    put_bytes(p, text, n);
}

static void put_integer(pdf *p, const char *before, long value, const char *after)
{
    char text[96];
    put_bytes(p, text, (size_t)snprintf(text, sizeof text, "%s%ld%s", before, value, after));
}

static void begin_object(pdf *p, int object)
{
    p->place[object] = p->at;
    put_integer(p, "", object, " 0 obj\n");
}

static void put_colour(pdf *p, uint32_t colour, const char *operator)
{
    for (int shift = 16; shift >= 0; shift -= 8) {
        char text[16];
        const int thousandths = (int)lround((double)((colour >> shift) & 255) / 255 * 1000);
        put_bytes(p, text, (size_t)snprintf(text, sizeof text, "%d.%03d ", thousandths / 1000, thousandths % 1000));
    }
    put(p, operator);
}

/* ---- drawing --------------------------------------------------------------------------------- */

static void put_place(pdf *p, double x, double y, const char *operator)
{
    put_number(p, x);
    put_number(p, p->height - y);
    put(p, operator);
}

static void put_pen(pdf *p, const ff_pen *pen)
{
    double dash[6];
    const size_t n = ff_dash_lengths(pen->dash, dash);
    put_colour(p, pen->colour, "RG ");
    put_number(p, pen->width);
    put(p, "w [");
    for (size_t i = 0; i < n; i++) put_number(p, dash[i] * pen->width);
    put(p, "] 0 d\n");
}

static void path(void *self, size_t n, const double *xy, int closed, const ff_pen *pen, uint32_t fill)
{
    pdf *p = self;
    const int stroked = pen->colour != FF_COLOUR_NONE, filled = fill != FF_COLOUR_NONE;
    int down = 0, any = 0;
    if (!stroked && !filled) return;
    if (stroked) put_pen(p, pen);
    if (filled) put_colour(p, fill, "rg\n");
    for (size_t i = 0; i < n; i++) {
        if (!isfinite(xy[2 * i]) || !isfinite(xy[2 * i + 1])) {
            if (down && closed) put(p, "h ");
            down = 0;
            continue;
        }
        put_place(p, xy[2 * i], xy[2 * i + 1], down ? "l\n" : "m\n");
        down = any = 1;
    }
    if (down && closed) put(p, "h ");
    put(p, !any ? "n\n" : filled && stroked ? "B\n" : filled ? "f\n" : "S\n");
}

static void dots(void *self, size_t n, const double *xy, double radius, uint32_t colour)
{
    pdf *p = self;
    put_pen(p, &(ff_pen){2 * radius, colour, FF_DASH_SOLID});
    put(p, "1 J\n");
    for (size_t i = 0; i < n; i++) {
        if (!isfinite(xy[2 * i]) || !isfinite(xy[2 * i + 1])) continue;
        put_place(p, xy[2 * i], xy[2 * i + 1], "m ");
        put_place(p, xy[2 * i], xy[2 * i + 1], "l\n");
    }
    put(p, "S 0 J\n");
}

/* ---- text ------------------------------------------------------------------------------------ */

/* How the next character is to be set. */
typedef struct setting {
    int symbol;
    double size, rise;
} setting;

static void put_setting(pdf *p, const setting *s)
{
    put(p, s->symbol ? "/S " : "/H ");
    put_number(p, s->size);
    put(p, "Tf ");
    put_number(p, s->rise);
    put(p, "Ts ");
}

static void put_hex(pdf *p, unsigned byte)
{
    char hex[4];
    snprintf(hex, sizeof hex, "%02x", byte);
    put_bytes(p, hex, 2);
}

/* n digits between two shifts, in thousandths: [-before <..> -after] TJ */
static void put_digits(pdf *p, const char *digits, size_t n, double before, double after)
{
    put(p, "[");
    put_number(p, -before);
    put(p, "<");
    for (size_t i = 0; i < n; i++) put_hex(p, (unsigned char)digits[i]);
    put(p, "> ");
    put_number(p, -after);
    put(p, "] TJ ");
}

/* A character that neither font has: the digits of its code in two lines, in the width that the layout keeps for it. */
static void put_code(pdf *p, uint32_t code, const setting *at)
{
    char digits[12];
    const double small = 0.45, room = 1000 / small;
    const size_t n = (size_t)snprintf(digits, sizeof digits, "%04X", (unsigned)code), above = (n + 1) / 2;
    for (int line = 0; line < 2; line++) {
        const char *from = digits + (line ? above : 0);
        const size_t count = line ? n - above : above;
        const double width = ff_run_points(from, count, 1000), side = (room - width) / 2;
        put_setting(p, &(setting){0, small * at->size, at->rise + (line ? -0.05 : 0.38) * at->size});
        put_digits(p, from, count, side, line ? side : -side - width);
    }
}

/* Characters of one setting after another as strings in hexadecimal. */
static void put_run(pdf *p, const ff_run *run, double size, double rise)
{
    setting now = {-1, 0, 0};
    int is_open = 0;
    for (size_t i = 0; i < run->length;) {
        uint32_t code = '?';
        const size_t n = ff_text_sequence(run->text + i, &code);
        const ff_glyph g = ff_glyph_of(n ? code : '?');
        const int is_known = g.latin || g.symbol;
        const setting next = {g.symbol != 0, g.level ? FF_RUN_SIZE * size : size, rise + ff_run_rise(g.level) * size};
        if (is_open && (!is_known || next.symbol != now.symbol || g.level || now.size < size)) {
            put(p, "> Tj ");
            is_open = 0;
        }
        if (!is_known) put_code(p, n ? code : '?', &next);
        if (is_known && !is_open) {
            put_setting(p, &next);
            put(p, "<");
            now = next;
            is_open = 1;
        }
        if (is_known) put_hex(p, g.symbol ? g.symbol : g.latin);
        i += n ? n : 1;
    }
    put(p, is_open ? "> Tj\n" : "\n");
}

static void text(void *self, const ff_text *t)
{
    pdf *p = self;
    const char *rest = t->text;
    const double width = ff_text_points(t->text, t->size), back = t->anchor == FF_ANCHOR_LEFT     ? 0
                                                                  : t->anchor == FF_ANCHOR_MIDDLE ? width / 2
                                                                                                  : width;
    ff_run run;
    if (!*t->text) return;
    put(p, "BT ");
    put_colour(p, t->colour, "rg ");
    put(p, t->upwards ? "0 1 -1 0 " : "1 0 0 1 ");
    put_place(p, t->upwards ? t->x : t->x - back, t->upwards ? t->y + back : t->y, "Tm\n");
    while (ff_run_next(&rest, &run))
        put_run(p, &run, run.level ? FF_RUN_SIZE * t->size : t->size, ff_run_rise(run.level) * t->size);
    put(p, "0 Ts ET\n");
}

/* ---- images, clipping ------------------------------------------------------------------------ */

static void image(void *self, const double box[4], size_t nx, size_t ny, const unsigned char *rgb)
{
    pdf *p = self;
    put(p, "q ");
    put_number(p, box[2]);
    put(p, "0 0 ");
    put_number(p, box[3]);
    put_place(p, box[0], box[1] + box[3], "cm\n");
    put_integer(p, "BI /W ", (long)nx, "");
    put_integer(p, " /H ", (long)ny, " /BPC 8 /CS /RGB /I false /F /AHx ID\n");
    for (size_t i = 0; i < 3 * nx * ny; i++) {
        char hex[4];
        snprintf(hex, sizeof hex, "%02x", rgb[i]);
        put_bytes(p, hex, 2);
        if (i % 48 == 47) put(p, "\n");
    }
    put(p, ">\nEI Q\n");
}

static void clip(void *self, const double box[4])
{
    pdf *p = self;
    put(p, "q ");
    put_number(p, box[0]);
    put_number(p, p->height - box[1] - box[3]);
    put_number(p, box[2]);
    put_number(p, box[3]);
    put(p, "re W n\n");
}

static void unclip(void *self)
{
    put(self, "Q\n");
}

/* ---- the file -------------------------------------------------------------------------------- */

static void put_head(pdf *p, double width, double height)
{
    put(p, "%PDF-1.4\n%\xe2\xe3\xcf\xd3\n");
    begin_object(p, CATALOG);
    put(p, "<< /Type /Catalog /Pages 2 0 R >>\nendobj\n");
    begin_object(p, PAGES);
    put(p, "<< /Type /Pages /Kids [3 0 R] /Count 1 >>\nendobj\n");
    begin_object(p, PAGE);
    put(p, "<< /Type /Page /Parent 2 0 R /MediaBox [0 0 ");
    put_number(p, width);
    put_number(p, height);
    put(p, "] /Contents 4 0 R /Resources << /Font << /H 6 0 R /S 7 0 R >> >> >>\nendobj\n");
    begin_object(p, HELVETICA);
    put(p, "<< /Type /Font /Subtype /Type1 /BaseFont /Helvetica /Encoding /WinAnsiEncoding >>\nendobj\n");
    begin_object(p, SYMBOL);
    put(p, "<< /Type /Font /Subtype /Type1 /BaseFont /Symbol >>\nendobj\n");
}

/* UTF-16 with its mark, in hexadecimal. */
static void put_title(pdf *p, const char *title)
{
    begin_object(p, INFO);
    put(p, "<< /Producer (facetfit) /Title <feff");
    while (*title) {
        uint32_t code = '?';
        char hex[12];
        const size_t n = ff_text_sequence(title, &code);
        if (n == 0) code = '?';
        if (code >= 0x10000)
            snprintf(hex, sizeof hex, "%04x%04x", (unsigned)(0xd800 + ((code - 0x10000) >> 10)),
                     (unsigned)(0xdc00 + ((code - 0x10000) & 0x3ff)));
        else
            snprintf(hex, sizeof hex, "%04x", (unsigned)code);
        put(p, hex);
        title += n ? n : 1;
    }
    put(p, "> >>\nendobj\n");
}

static void put_tail(pdf *p)
{
    char line[32];
    const long start = p->at;
    put_integer(p, "xref\n0 ", OBJECTS, "\n0000000000 65535 f \n");
    for (int k = 1; k < OBJECTS; k++) {
        snprintf(line, sizeof line, "%010ld 00000 n \n", p->place[k]);
        put(p, line);
    }
    put_integer(p, "trailer\n<< /Size ", OBJECTS, " /Root 1 0 R /Info 8 0 R >>\nstartxref\n");
    put_integer(p, "", start, "\n%%EOF\n");
}

ff_status ff_canvas_pdf(FILE *out, double width, double height, const char *title, ff_drawing draw, const void *figure)
{
    pdf p = {.out = out, .height = height};
    const ff_canvas canvas = {&p, path, dots, text, image, clip, unclip};
    put_head(&p, width, height);
    put_title(&p, title);
    begin_object(&p, CONTENT);
    put(&p, "<< /Length 5 0 R >>\nstream\n");
    const long start = p.at;
    put(&p, "1 j\n");
    const ff_status status = draw(figure, &canvas);
    const long length = p.at - start;
    put(&p, "endstream\nendobj\n");
    begin_object(&p, LENGTH);
    put_integer(&p, "", length, "\nendobj\n");
    put_tail(&p);
    return status;
}
