/* What is shown of a radiance: curves, and colours of differences. */
#include "internal_render.h"
#include <math.h>

const char *ff_render_tone_name(int tone)
{
    static const char *const name[FF_TONES] = {"srgb", "linear", "filmic"};
    return tone >= 0 && tone < FF_TONES ? name[tone] : NULL;
}

const char *ff_render_background_name(int background)
{
    static const char *const name[FF_BACKGROUNDS] = {"white", "black", "transparent"};
    return background >= 0 && background < FF_BACKGROUNDS ? name[background] : NULL;
}

static double srgb_curve(double t)
{
    return t <= 0.0031308 ? 12.92 * t : 1.055 * pow(t, 1 / 2.4) - 0.055;
}

/* Narkowicz 2015, "ACES filmic tone mapping curve". */
static double filmic_curve(double e)
{
    return e * (2.51 * e + 0.03) / (e * (2.43 * e + 0.59) + 0.14);
}

double ff_render_tone_of(ff_render_tone tone, double exposed)
{
    const double e = exposed > 0 ? fmin(exposed, 1e6) : 0; /* NaN is not > 0 */
    if (tone == FF_TONE_LINEAR) return fmin(e, 1);
    return srgb_curve(fmin(tone == FF_TONE_FILMIC ? filmic_curve(e) : e, 1));
}
