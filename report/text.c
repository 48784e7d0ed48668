#define _GNU_SOURCE
#include "internal_text.h"
#include "base/internal_number.h"
#include <math.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

/* ---- width of UTF-8 -------------------------------------------------------------------------- */

size_t ff_text_sequence(const char *text, uint32_t *code)
{
    const unsigned char *s = (const unsigned char *)text;
    const size_t n = s[0] < 0x80 ? 1 : s[0] < 0xc2 ? 0 : s[0] < 0xe0 ? 2 : s[0] < 0xf0 ? 3 : s[0] < 0xf5 ? 4 : 0;
    static const uint32_t least[] = {0, 0, 0x80, 0x800, 0x10000};
    if (n == 0) return 0;
    uint32_t c = n == 1 ? s[0] : s[0] & (0x7fu >> n);
    for (size_t i = 1; i < n; ++i) {
        if ((s[i] & 0xc0) != 0x80) return 0;
        c = c << 6 | (s[i] & 0x3f);
    }
    if (c < least[n] || (c >= 0xd800 && c < 0xe000) || c > 0x10ffff) return 0;
    *code = c;
    return n;
}

/* The East Asian wide and the combining blocks that file names are made of. */
static size_t code_width(uint32_t c)
{
    if ((c >= 0x300 && c < 0x370) || (c >= 0x200b && c < 0x2010) || (c >= 0x20d0 && c < 0x2100) || (c >= 0xfe00 && c < 0xfe10))
        return 0;
    if ((c >= 0x1100 && c < 0x1160) || (c >= 0x2e80 && c < 0xa4d0) || (c >= 0xac00 && c < 0xd7a4) || (c >= 0xf900 && c < 0xfb00) ||
        (c >= 0xfe30 && c < 0xfe70) || (c >= 0xff00 && c < 0xff61) || (c >= 0x1f300 && c < 0x1f650) ||
        (c >= 0x20000 && c < 0x40000))
        return 2;
    return 1;
}

size_t ff_text_width(const char *text)
{
    size_t width = 0;
    while (*text) {
        uint32_t code = 'x';
        const size_t n = ff_text_sequence(text, &code);
        width += code_width(code);
        text += n ? n : 1;
    }
    return width;
}

/* ---- tables ---------------------------------------------------------------------------------- */

void ff_text_row(ff_text_table *t)
{
    if (t->rows == t->capacity) {
        const size_t capacity = t->capacity ? 2 * t->capacity : 16;
        char **cell = realloc(t->cell, capacity * FF_TEXT_COLUMNS * sizeof *cell);
        if (!cell) {
            t->failed = 1;
            return;
        }
        memset(cell + t->capacity * FF_TEXT_COLUMNS, 0, (capacity - t->capacity) * FF_TEXT_COLUMNS * sizeof *cell);
        t->cell = cell;
        t->capacity = capacity;
    }
    t->rows++;
}

void ff_text_cell(ff_text_table *t, const char *format, ...)
{
    if (t->failed || t->rows == 0) return;
    char text[FF_TEXT_CELL], **row = t->cell + (t->rows - 1) * FF_TEXT_COLUMNS;
    size_t c = 0;
    va_list args;
    va_start(args, format);
    vsnprintf(text, sizeof text, format, args);
    va_end(args);
    while (c < FF_TEXT_COLUMNS && row[c]) ++c;
    if (c == FF_TEXT_COLUMNS) return;
    row[c] = strdup(text);
    if (!row[c]) t->failed = 1;
    if (c + 1 > t->columns) t->columns = c + 1;
}

static void put_spaces(FILE *out, size_t n)
{
    for (; n > 0; --n) fputc(' ', out);
}

static void print_row(const ff_text_table *t, char *const *row, const size_t *width, FILE *out, const char *indent)
{
    size_t last = 0, pending = 0;
    for (size_t c = 0; c < t->columns; ++c)
        if (row[c] && row[c][0]) last = c + 1;
    fputs(indent, out);
    for (size_t c = 0; c < last; ++c) { /* no spaces at the end of a line */
        const char *text = row[c] ? row[c] : "";
        const size_t fill = width[c] - ff_text_width(text);
        put_spaces(out, pending + (t->right[c] ? fill : 0));
        fputs(text, out);
        pending = 2 + (t->right[c] ? 0 : fill);
    }
    fputc('\n', out);
}

ff_status ff_text_print(ff_text_table *t, FILE *out, const char *indent)
{
    size_t width[FF_TEXT_COLUMNS] = {0};
    const ff_status status = t->failed ? FF_ERR_MEMORY : FF_OK;
    for (size_t i = 0; i < t->rows; ++i)
        for (size_t c = 0; c < t->columns; ++c) {
            const char *text = t->cell[i * FF_TEXT_COLUMNS + c];
            const size_t w = text ? ff_text_width(text) : 0;
            if (w > width[c]) width[c] = w;
        }
    for (size_t i = 0; i < t->rows && status == FF_OK; ++i) print_row(t, t->cell + i * FF_TEXT_COLUMNS, width, out, indent);
    for (size_t i = 0; i < t->rows * FF_TEXT_COLUMNS; ++i) free(t->cell[i]);
    free(t->cell);
    memset(t, 0, sizeof *t);
    return status;
}

/* ---- numbers --------------------------------------------------------------------------------- */

/* Whatever a locale puts between the digits (',' or several bytes) becomes a point. */
static void to_point(char *text)
{
    const size_t whole = strspn(text, "+-0123456789"), gap = strcspn(text + whole, "0123456789e");
    if (text[whole] == '\0' || text[whole] == 'e' || text[whole] == 'n' || text[whole] == 'i') return;
    text[whole] = '.';
    memmove(text + whole + 1, text + whole + gap, strlen(text + whole + gap) + 1);
}

const char *ff_text_number(double x, int significant, char out[FF_TEXT_NUMBER])
{
    snprintf(out, FF_TEXT_NUMBER, "%.*g", significant, x);
    to_point(out);
    return out;
}

const char *ff_text_fixed(double x, int decimals, char out[FF_TEXT_NUMBER])
{
    if (fabs(x) >= 1e15) return ff_text_number(x, 6, out);
    snprintf(out, FF_TEXT_NUMBER, "%.*f", decimals, x);
    to_point(out);
    return out;
}

const char *ff_text_exact(double x, char out[FF_TEXT_NUMBER])
{
    if (isfinite(x)) {
        out[ff_number_write(x, out)] = '\0';
    } else {
        strcpy(out, isnan(x) ? "nan" : x > 0 ? "inf" : "-inf");
    }
    return out;
}

void ff_text_with_error(double value, double error, char out[FF_TEXT_NUMBER], char out_error[FF_TEXT_NUMBER])
{
    if (!isfinite(error) || error < 0) {
        ff_text_number(value, 6, out);
        strcpy(out_error, "-");
        return;
    }
    ff_text_number(error, 2, out_error);
    if (error == 0 || !isfinite(value)) {
        ff_text_number(value, 6, out);
        return;
    }
    const int decimals = 1 - (int)floor(log10(error));                      /* of the error's second digit        */
    const int before = value != 0 ? (int)floor(log10(fabs(value))) + 1 : 1; /* digits in front of the point        */
    const int digits = decimals + before;
    if (decimals < 0 || decimals > 12 || digits > 12 || fabs(value) >= 1e6 || (fabs(value) < 1e-4 && value != 0)) {
        ff_text_number(value, digits < 1 ? 1 : digits > 12 ? 12 : digits, out);
        return;
    }
    ff_text_fixed(value, decimals, out);
}
