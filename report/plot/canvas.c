/* What both backends have in common: numbers, dashes. */
#include "internal_canvas.h"
#include <math.h>

size_t ff_point_text(double x, char out[FF_POINT])
{
    size_t n = 0;
    char digit[FF_POINT];
    size_t digits = 0;
    long long hundredths = llround(fmin(fmax(isfinite(x) ? x : 0, -1e9), 1e9) * 100);
    if (hundredths < 0) {
        out[n++] = '-';
        hundredths = -hundredths;
    }
    for (long long whole = hundredths / 100; whole > 0 || digits == 0; whole /= 10) digit[digits++] = (char)('0' + whole % 10);
    while (digits > 0) out[n++] = digit[--digits];
    const int rest = (int)(hundredths % 100);
    if (rest) {
        out[n++] = '.';
        out[n++] = (char)('0' + rest / 10);
        if (rest % 10) out[n++] = (char)('0' + rest % 10);
    }
    out[n] = '\0';
    return n;
}

size_t ff_dash_lengths(int dash, double out[6])
{
    static const struct {
        size_t n;
        double length[6];
    } dashes[FF_DASH_COUNT] = {{0, {0}}, {2, {6, 2.5}}, {2, {1.2, 2}}, {4, {6, 2, 1.2, 2}}, {2, {3, 1.6}}};
    const int k = dash >= 0 && dash < FF_DASH_COUNT ? dash : 0;
    for (size_t i = 0; i < dashes[k].n; i++) out[i] = dashes[k].length[i];
    return dashes[k].n;
}
