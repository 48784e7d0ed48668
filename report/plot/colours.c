/* Colours that stay apart for colour-blind people and in grey print. */
#include "internal_canvas.h"
#include <math.h>

/* Okabe and Ito 2008, without the yellow that white paper swallows. */
static const uint32_t palette[FF_COLOUR_COUNT] = {0x0072b2, 0xd55e00, 0x009e73, 0xcc79a7, 0xe69f00,
                                                  0x56b4e9, 0x000000, 0x6f6f6f, 0xd9d9d9};

uint32_t ff_colour_at(int colour)
{
    return palette[colour >= 0 && colour < FF_COLOUR_COUNT ? colour : FF_COLOUR_BLACK];
}

ff_style ff_style_at(size_t k)
{
    static const int cycle[] = {FF_COLOUR_BLUE,   FF_COLOUR_VERMILLION, FF_COLOUR_GREEN, FF_COLOUR_PURPLE,
                                FF_COLOUR_ORANGE, FF_COLOUR_SKY,        FF_COLOUR_BLACK};
    const size_t n = sizeof cycle / sizeof *cycle;
    /* the dash moves on with every turn of the colours, so that a pair comes back after 35 only */
    return (ff_style){cycle[k % n], (int)((k + k / n) % FF_DASH_COUNT), (int)((k + k / n) % FF_MARKER_COUNT)};
}

uint32_t ff_colour_mix(uint32_t a, uint32_t b, double share)
{
    uint32_t out = 0;
    for (int shift = 16; shift >= 0; shift -= 8) {
        const double x = (double)((a >> shift) & 255), y = (double)((b >> shift) & 255);
        out |= (uint32_t)lround(x + (y - x) * share) << shift;
    }
    return out;
}

static uint32_t along(const uint32_t *node, size_t n, double t)
{
    const double at = fmin(fmax(t, 0), 1) * (double)(n - 1);
    const size_t k = at >= (double)(n - 1) ? n - 2 : (size_t)at;
    return ff_colour_mix(node[k], node[k + 1], at - (double)k);
}

/* viridis (van der Walt and Smith 2015, CC0) at 21 places, between which it is nearly straight: its lightness rises evenly. */
static const uint32_t viridis[] = {0x440154, 0x481467, 0x482576, 0x463480, 0x414487, 0x3b528b, 0x355f8d,
                                   0x2f6c8e, 0x2a788e, 0x25848e, 0x21918c, 0x1e9c89, 0x22a884, 0x2fb47c,
                                   0x44bf70, 0x5ec962, 0x7ad151, 0x9bd93c, 0xbddf26, 0xdfe318, 0xfde725};

/* Blue, white, orange: even steps of lightness to both sides (after Brewer's PuOr and RdBu), told apart by the colour-blind. */
static const uint32_t diverging[] = {0x053061, 0x2166ac, 0x4393c3, 0x92c5de, 0xd1e5f0, 0xf7f7f7,
                                     0xfee0b6, 0xfdb863, 0xe08214, 0xb35806, 0x7f3b08};

uint32_t ff_colour_of(ff_map map, double t)
{
    if (!isfinite(t)) return 0xe6e6e6;
    return map == FF_MAP_DIVERGING ? along(diverging, sizeof diverging / sizeof *diverging, t)
                                   : along(viridis, sizeof viridis / sizeof *viridis, t);
}
