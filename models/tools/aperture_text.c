/* Apertures in words. */
#include "internal_averaging.h"
#include "base/internal_number.h"
#include <math.h>
#include <stdio.h>
#include <string.h>

static const double degree = 3.14159265358979323846 / 180;

ff_status ff_aperture_parse(const char *text, ff_aperture *out)
{
    double x, y = 0;
    const char *end = ff_number_read(text, &x);
    if (!end) return FF_ERR_SYNTAX;
    const int square = !strcmp(end, ":square"), sides = *end == 'x', disc = !*end || !strcmp(end, ":disc");
    if (sides) end = ff_number_read(end + 1, &y);
    if (!disc && !square && !(sides && end && !*end)) return FF_ERR_SYNTAX;
    const ff_aperture a = {disc ? FF_APERTURE_DISC : FF_APERTURE_RECTANGLE, x * degree, (square ? x : y) * degree, out->source};
    if (!ff_aperture_valid(&a)) return FF_ERR_RANGE;
    *out = a;
    return FF_OK;
}

/* To a millionth of a degree, below which the product with pi leaves digits of its own. */
static void put_degrees(double radians, char out[FF_NUMBER_TEXT + 1])
{
    out[ff_number_write(round(1e6 * radians / degree) / 1e6, out)] = '\0';
}

char *ff_aperture_text(const ff_aperture *a, char out[FF_APERTURE_TEXT])
{
    char half[FF_NUMBER_TEXT + 1], across[FF_NUMBER_TEXT + 1];
    put_degrees(a->half, half);
    put_degrees(a->across, across);
    if (a->outline == FF_APERTURE_DISC)
        snprintf(out, FF_APERTURE_TEXT, "%s", half);
    else if (a->half == a->across)
        snprintf(out, FF_APERTURE_TEXT, "%s:square", half);
    else
        snprintf(out, FF_APERTURE_TEXT, "%sx%s", half, across);
    return out;
}
