/* How wide text is: the advance widths of Helvetica and Symbol that Adobe published for the standard fonts of PDF, in thousandths
 * of the size. What people see in place of Helvetica (Arial, Liberation Sans, Nimbus Sans) has the same. */
#include "internal_canvas.h"
#include "report/internal_text.h"
#include <math.h>
#include <string.h>

/* U+0020 to U+007E */
static const short ascii[] = {278, 278, 355, 556, 556, 889, 667, 191, 333, 333, 389, 584, 278, 333,  278, 278, 556, 556, 556,
                              556, 556, 556, 556, 556, 556, 556, 278, 278, 584, 584, 584, 556, 1015, 667, 667, 722, 722, 667,
                              611, 778, 722, 278, 500, 667, 556, 833, 722, 778, 667, 778, 722, 667,  611, 722, 667, 944, 667,
                              667, 611, 278, 278, 278, 469, 556, 333, 556, 556, 500, 556, 556, 278,  556, 556, 222, 222, 500,
                              222, 833, 556, 556, 556, 556, 333, 500, 278, 556, 500, 722, 500, 500,  500, 334, 260, 334, 584};

/* U+00A0 to U+00FF */
static const short latin1[] = {278, 333, 556, 556, 556, 556, 260, 556, 333, 737, 370, 556, 584, 333, 737, 333, 400, 584, 333,  333,
                               333, 556, 537, 278, 333, 333, 365, 556, 834, 834, 834, 611, 667, 667, 667, 667, 667, 667, 1000, 722,
                               667, 667, 667, 667, 278, 278, 278, 278, 722, 722, 778, 778, 778, 778, 778, 584, 778, 722, 722,  722,
                               722, 667, 667, 611, 556, 556, 556, 556, 556, 556, 889, 500, 556, 556, 556, 556, 278, 278, 278,  278,
                               556, 556, 556, 556, 556, 556, 556, 584, 611, 556, 556, 556, 556, 500, 556, 500};

/* What reflectance is written with and neither of them has. */
static const struct {
    uint32_t code;
    short width;
    unsigned char latin, symbol;
} others[] = {
    {0x2013, 556, 0x96, 0}, {0x2026, 1000, 0x85, 0}, {0x2212, 584, 0, 0x2d}, {0x0394, 612, 0, 'D'}, {0x039b, 686, 0, 'L'},
    {0x03a3, 592, 0, 'S'},  {0x03a9, 768, 0, 'W'},   {0x03b1, 631, 0, 'a'},  {0x03b2, 549, 0, 'b'}, {0x03b3, 411, 0, 'g'},
    {0x03b4, 494, 0, 'd'},  {0x03b5, 439, 0, 'e'},   {0x03b7, 603, 0, 'h'},  {0x03b8, 521, 0, 'q'}, {0x03ba, 549, 0, 'k'},
    {0x03bb, 549, 0, 'l'},  {0x03bc, 576, 0, 'm'},   {0x03c0, 549, 0, 'p'},  {0x03c1, 549, 0, 'r'}, {0x03c3, 603, 0, 's'},
    {0x03c4, 439, 0, 't'},  {0x03c6, 521, 0, 'f'},   {0x03c7, 549, 0, 'c'},  {0x03c9, 686, 0, 'w'}, {0x2264, 549, 0, 0xa3},
    {0x2265, 549, 0, 0xb3}, {0x221e, 713, 0, 0xa5},
};

int ff_glyph(uint32_t code, unsigned char *latin, unsigned char *symbol)
{
    *symbol = 0;
    *latin = (unsigned char)((code >= 0x20 && code <= 0x7e) || (code >= 0xa0 && code <= 0xff) ? code : 0);
    if (code >= 0x20 && code <= 0x7e) return ascii[code - 0x20];
    if (code >= 0xa0 && code <= 0xff) return latin1[code - 0xa0];
    for (size_t k = 0; k < sizeof others / sizeof *others; k++) {
        if (others[k].code != code) continue;
        *latin = others[k].latin;
        *symbol = others[k].symbol;
        return others[k].width;
    }
    return 1000; /* a script that Helvetica has not: the widest that it is likely to be */
}

double ff_run_points(const char *text, size_t length, double size)
{
    double width = 0;
    for (size_t i = 0; i < length;) {
        uint32_t code = '?';
        unsigned char latin, symbol;
        const size_t n = ff_text_sequence(text + i, &code);
        width += ff_glyph(n ? code : '?', &latin, &symbol);
        i += n ? n : 1;
    }
    return width * size / 1000;
}

/* ---- runs ------------------------------------------------------------------------------------ */

int ff_run_next(const char **text, ff_run *out)
{
    const char *t = *text;
    if (*t == '\0') return 0;
    const int raised = *t == '^' && t[1] == '{', lowered = *t == '_' && t[1] == '{';
    if (raised || lowered) {
        const size_t n = strcspn(t + 2, "}");
        *out = (ff_run){t + 2, n, raised ? 1 : -1};
        *text = t + 2 + n + (t[2 + n] == '}');
        return 1;
    }
    size_t n = 1;
    while (t[n] && !((t[n] == '^' || t[n] == '_') && t[n + 1] == '{')) n++;
    *out = (ff_run){t, n, 0};
    *text = t + n;
    return 1;
}

double ff_text_points(const char *text, double size)
{
    double width = 0;
    ff_run run;
    while (ff_run_next(&text, &run)) width += ff_run_points(run.text, run.length, run.level ? FF_RUN_SIZE * size : size);
    return width;
}

const char *ff_text_fit(const char *text, double size, double points, char *out, size_t room)
{
    static const char ellipsis[] = "…";
    size_t keep = strlen(text);
    snprintf(out, room, "%s", text);
    if (ff_text_points(text, size) <= points) return out;
    while (keep > 0) {
        keep--;
        while (keep > 0 && ((unsigned char)text[keep] & 0xc0) == 0x80) keep--;
        if (keep + sizeof ellipsis > room) continue;
        memcpy(out, text, keep);
        const char *open = NULL; /* of a subscript that is cut */
        for (size_t i = 0; i + 1 < keep; i++) {
            if ((text[i] == '_' || text[i] == '^') && text[i + 1] == '{') open = text + i;
            if (text[i] == '}') open = NULL;
        }
        if (open) continue;
        memcpy(out + keep, ellipsis, sizeof ellipsis);
        if (ff_text_points(out, size) <= points) return out;
    }
    *out = '\0';
    return out;
}
