/* std::to_chars, which cannot fail on what it is given here; see number_bridge.h. */
#include "number_bridge.h"
#include <charconv>

extern "C" unsigned ff_number_fixed(double value, char out[FF_NUMBER_FIXED]) noexcept
{
    return (unsigned)(std::to_chars(out, out + FF_NUMBER_FIXED, value, std::chars_format::fixed).ptr - out);
}

extern "C" int ff_number_digits(double value, char digits[FF_NUMBER_DIGITS], int *exponent) noexcept
{
    char text[32]; /* "d.ddddddddddddddddde-ddd" */
    const char *end = std::to_chars(text, text + sizeof text, value, std::chars_format::scientific).ptr;
    const char *p = text;
    int n = 0;
    for (; *p != 'e'; p++)
        if (*p != '.') digits[n++] = *p;
    const bool negative = *++p == '-';
    int size = 0;
    for (p++; p != end; p++) size = 10 * size + (*p - '0');
    *exponent = negative ? -size : size;
    return n;
}
