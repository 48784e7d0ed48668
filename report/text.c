#include "internal_text.h"
#include "base/internal_kept.h"
#include "base/internal_number.h"
#include <math.h>
#include <stdio.h>
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
    for (size_t i = 1; i < n; i++) {
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

/* A colour: ESC [ digits m. */
static size_t ink_length(const char *text)
{
    if (text[0] != '\x1b' || text[1] != '[') return 0;
    const size_t digits = strspn(text + 2, "0123456789;");
    return text[2 + digits] == 'm' ? digits + 3 : 0;
}

/* Length of what comes next, and its columns. */
static size_t next_code(const char *text, size_t *width)
{
    uint32_t code = 'x';
    const size_t ink = ink_length(text), n = ink ? ink : ff_text_sequence(text, &code);
    *width = ink ? 0 : code_width(code);
    return n ? n : 1;
}

size_t ff_text_width(const char *text)
{
    size_t width = 0, one;
    while (*text) {
        text += next_code(text, &one);
        width += one;
    }
    return width;
}

size_t ff_text_fitting(const char *text, size_t width)
{
    size_t at = 0, used = 0, one;
    while (text[at]) {
        const size_t n = next_code(text + at, &one);
        if (used + one > width) break;
        at += n;
        used += one;
    }
    return at;
}

/* ---- colours --------------------------------------------------------------------------------- */

const char *ff_text_ink(int color, ff_ink ink)
{
    static const char *const of[] = {[FF_INK_PLAIN] = "\x1b[0m",    [FF_INK_HEAD] = "\x1b[1m",   [FF_INK_GOOD] = "\x1b[1;32m",
                                     [FF_INK_WARNING] = "\x1b[33m", [FF_INK_BAD] = "\x1b[1;31m", [FF_INK_FAINT] = "\x1b[2m"};
    return color ? of[ink] : "";
}

/* ---- text of others -------------------------------------------------------------------------- */

/* C0, DEL, C1 (Unicode 15, 23.1); line and paragraph separator (23.2); marks, embeddings, overrides and isolates of UAX #9. */
int ff_text_is_control(uint32_t c)
{
    return c < 0x20 || (c >= 0x7f && c < 0xa0) || c == 0x61c || c == 0x200e || c == 0x200f || (c >= 0x2028 && c <= 0x202e) ||
           (c >= 0x2066 && c <= 0x2069);
}

void ff_text_print(const char *text, FILE *out)
{
    while (*text) {
        uint32_t code;
        const size_t valid = ff_text_sequence(text, &code), n = valid ? valid : 1;
        if (valid && !ff_text_is_control(code))
            fwrite(text, 1, n, out);
        else
            for (size_t i = 0; i < n; i++) fprintf(out, "\\x%02x", (unsigned char)text[i]);
        text += n;
    }
}

/* ---- text that is kept ------------------------------------------------------------------------ */

ff_status ff_text_capture(ff_status (*write)(const void *context, FILE *out), const void *context, char **text)
{
    ff_kept k;
    FILE *stream = ff_kept_open(&k);
    ff_status status = stream ? write(context, stream) : FF_ERR_MEMORY;
    const ff_status closed = ff_kept_close(&k, stream);
    *text = k.text;
    return status ? status : closed;
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

const char *ff_text_within(double x, double width, char out[FF_TEXT_NUMBER])
{
    char rest[FF_TEXT_NUMBER];
    ff_text_with_error(x, x != 0 ? fmin(width, fabs(x)) : width, out, rest);
    return out;
}
