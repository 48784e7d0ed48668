/* Ticks at numbers that people like, as many as their labels leave room for. */
#include "internal_sheet.h"
#include "report/internal_text.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { LONG = 3 }; /* so many decimals of small numbers are written out, not more */

double ff_scale_place(ff_scale scale, double lo, double hi, double x)
{
    if (scale != FF_SCALE_LOG) return (x - lo) / (hi - lo);
    return x > 0 ? log(x / lo) / log(hi / lo) : NAN;
}

double ff_ticks_widest(const ff_ticks *t, double size)
{
    double widest = 0;
    for (size_t k = 0; k < t->n; k++) widest = fmax(widest, ff_text_points(t->tick[k].label, size));
    return widest;
}

const char *ff_axis_text(const ff_axis *a, const ff_ticks *t, char *out, size_t size)
{
    char factor[32] = "";
    if (t->power) snprintf(factor, sizeof factor, "10^{%s%d}", t->power < 0 ? "−" : "", abs(t->power));
    const int has_unit = a->unit[0] || *factor;
    snprintf(out, size, "%s%s%s%s%s%s", a->label, has_unit ? (a->label[0] ? " (" : "(") : "", factor,
             *factor && a->unit[0] ? " " : "", a->unit, has_unit ? ")" : "");
    return out;
}

/* ---- labels ---------------------------------------------------------------------------------- */

/* A minus as long as a plus, in place of the hyphen. */
static void with_minus(const char *number, char out[FF_TICK_LABEL])
{
    snprintf(out, FF_TICK_LABEL, "%s%s", *number == '-' ? "−" : "", number + (*number == '-'));
}

static void label_power(double mantissa, int power, char out[FF_TICK_LABEL])
{
    char exponent[16], number[FF_TEXT_NUMBER], text[FF_TICK_LABEL];
    snprintf(exponent, sizeof exponent, "%s%d", power < 0 ? "−" : "", power < 0 ? -power : power);
    if (mantissa == 1) {
        snprintf(out, FF_TICK_LABEL, "10^{%s}", exponent);
        return;
    }
    with_minus(ff_text_number(mantissa, 4, number), text);
    snprintf(out, FF_TICK_LABEL, "%.40s·10^{%s}", text, exponent);
}

/* So many that ticks `step` apart differ. */
static int decimals_of(double step)
{
    int decimals = 0;
    while (decimals < 12 && fabs(step * pow(10, decimals) - round(step * pow(10, decimals))) > 1e-6 * step * pow(10, decimals))
        decimals++;
    return decimals;
}

/* The power of ten that the numbers of an axis leave to its label: of large and small ones, and of those that would have many zeros
 * before their digits begin. */
static int power_of(double step, double most)
{
    const int power = (int)floor(log10(most) + 1e-9);
    return power >= 5 || power <= -4 || (power < -1 && decimals_of(step) > LONG) ? power : 0;
}

/* Of a tick on an axis whose ticks are `step` apart. */
static void label_linear(double x, double step, int power, char out[FF_TICK_LABEL])
{
    char number[FF_TEXT_NUMBER];
    const double unit = pow(10, power);
    if (fabs(x) < step * 1e-6) x = 0;
    with_minus(ff_text_fixed(x / unit, decimals_of(step / unit), number), out);
}

/* plain: without powers, of an axis whose ends are short so. */
static void label_log(double x, int plain, char out[FF_TICK_LABEL])
{
    char number[FF_TEXT_NUMBER];
    const int power = (int)floor(log10(x) + 1e-9);
    if (!plain) {
        label_power(round(x / pow(10, power) * 1e6) / 1e6, power, out);
        return;
    }
    with_minus(ff_text_number(x, 6, number), out);
}

/* ---- linear ---------------------------------------------------------------------------------- */

static void add(ff_ticks *t, double at)
{
    if (t->n < FF_TICKS) t->tick[t->n++] = (ff_tick){.at = at};
}

static void every(double lo, double hi, double step, ff_ticks *out)
{
    const double first = ceil(lo / step - 1e-6);
    out->n = 0;
    out->power = power_of(step, fmax(fabs(lo), fabs(hi)));
    for (double k = first; k * step <= hi + 1e-6 * step && out->n < FF_TICKS; k++) {
        add(out, k * step);
        label_linear(k * step, step, out->power, out->tick[out->n - 1].label);
    }
}

/* Do neighbouring labels keep their distance? */
static int have_room(const ff_ticks *t, ff_scale scale, double lo, double hi, double length, double size, int stacked)
{
    double end = -INFINITY;
    for (size_t k = 0; k < t->n; k++) {
        if (!t->tick[k].label[0]) continue;
        const double at = ff_scale_place(scale, lo, hi, t->tick[k].at) * length,
                     half = stacked ? 0.62 * size : ff_text_points(t->tick[k].label, size) / 2 + 0.35 * size;
        if (at - half < end) return 0;
        end = at + half;
    }
    return 1;
}

/* At most so many; a stacked axis is short. */
static int few(const ff_ticks *t, int stacked)
{
    return t->n <= (stacked ? 7u : 8u);
}

static void linear(ff_scale scale, double lo, double hi, double length, double size, int stacked, ff_ticks *out)
{
    static const double decimal[] = {1, 2, 2.5, 5}, degrees[] = {0.1, 0.2, 0.5, 1, 2, 5, 10, 15, 30, 45, 90, 180};
    const double range = hi - lo;
    if (scale == FF_SCALE_ANGLE && range > 0.4)
        for (size_t k = 0; k < sizeof degrees / sizeof *degrees; k++) {
            if (range / degrees[k] > FF_TICKS) continue;
            every(lo, hi, degrees[k], out);
            if (few(out, stacked) && have_room(out, scale, lo, hi, length, size, stacked)) return;
        }
    for (int power = (int)floor(log10(range)) - 2; power < (int)floor(log10(range)) + 2; power++)
        for (size_t k = 0; k < 4; k++) {
            const double step = decimal[k] * pow(10, power);
            if (range / step > FF_TICKS) continue;
            every(lo, hi, step, out);
            if (few(out, stacked) && have_room(out, scale, lo, hi, length, size, stacked)) return;
        }
    out->n = 0;
}

/* ---- logarithmic ----------------------------------------------------------------------------- */

/* Numbers m 10^p for the mantissas of a mask (bit m); labels at those of `labelled`, every stride-th power. */
static void powers(double lo, double hi, unsigned mask, unsigned labelled, int stride, ff_ticks *out)
{
    const int first = (int)floor(log10(lo) - 1e-9), last = (int)ceil(log10(hi));
    const int plain = lo > 0.0009 && hi < 99999;
    out->n = 0;
    out->power = 0;
    for (int p = first; p <= last; p++)
        for (int m = 1; m <= 9; m++) {
            const double x = m * pow(10, p);
            if (!(mask >> m & 1u) || x < lo * (1 - 1e-9) || x > hi * (1 + 1e-9) || out->n == FF_TICKS) continue;
            add(out, x);
            if ((labelled >> m & 1u) && (stride == 1 || ((p % stride) + stride) % stride == 0))
                label_log(x, plain, out->tick[out->n - 1].label);
        }
}

static size_t count_labels(const ff_ticks *t)
{
    size_t n = 0;
    for (size_t k = 0; k < t->n; k++) n += t->tick[k].label[0] != '\0';
    return n;
}

static void logarithmic(double lo, double hi, double length, double size, int stacked, ff_ticks *out)
{
    static const struct {
        unsigned mask, labelled;
    } fine[] = {{0x3fe, 0x3fe}, {0x3fe, 0x2e}, {0x3fe, 0x26}, {0x3fe, 0x0a}, {0x3fe, 0x02}};
    const double decades = log10(hi / lo);
    for (size_t k = decades > 1.5 ? 4 : 0; k < 5 && decades < 6; k++) {
        powers(lo, hi, fine[k].mask, fine[k].labelled, 1, out);
        if (count_labels(out) >= 2 && count_labels(out) <= 8 && have_room(out, FF_SCALE_LOG, lo, hi, length, size, stacked)) return;
    }
    for (int stride = 1; stride < 300; stride++) {
        powers(lo, hi, 2, 2, stride, out);
        if (count_labels(out) <= 8 && count_labels(out) >= 1 && have_room(out, FF_SCALE_LOG, lo, hi, length, size, stacked)) return;
    }
    linear(FF_SCALE_LINEAR, lo, hi, length, size, stacked, out);
}

void ff_ticks_make(ff_scale scale, double lo, double hi, double length, double size, int stacked, ff_ticks *out)
{
    out->n = 0;
    out->power = 0;
    if (!(hi > lo) || !isfinite(hi - lo) || scale == FF_SCALE_NAMES || !(length > 0)) return;
    if (scale == FF_SCALE_LOG)
        logarithmic(lo, hi, length, size, stacked, out);
    else
        linear(scale, lo, hi, length, size, stacked, out);
}
