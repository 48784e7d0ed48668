/* What must hold of every table that a reader hands out. */
#ifndef FF_SOUND_TABLE_H
#define FF_SOUND_TABLE_H
#include "data_formats/table/table_struct.h"
#include <math.h>
#include <stdio.h>
#include <string.h>

/* NULL, or what is wrong. The text is overwritten by the next call. */
static inline const char *unsound_table(const ff_table *t, const char *format)
{
    static char why[256];
#define UNSOUND(...) return snprintf(why, sizeof why, __VA_ARGS__), why
    if (strcmp(t->format, format)) UNSOUND("format '%s', expected '%s'", t->format, format);
    if (t->n == 0 || t->n_channels == 0 || !t->channels || !t->value || !t->valid)
        UNSOUND("%zu samples, %zu channels", t->n, t->n_channels);
    if (!memchr(t->note, '\0', sizeof t->note)) UNSOUND("the note has no end");
    for (size_t k = 0; k < FF_TABLE_NOTES; k++)
        if (t->note_hint[k] >= FF_HINT_COUNT) UNSOUND("note %zu has no such hint", k);
    size_t invalid = 0, negative = 0;
    for (size_t i = 0; i < t->n; i++) {
        int below_zero = 0;
        for (int k = 0; k < 4 && !t->grid; k++)
            if (!isfinite(t->angle[k][i])) UNSOUND("sample %zu: angle %d is %g", i, k, t->angle[k][i]);
        if (t->weight && !(isfinite(t->weight[i]) && t->weight[i] >= 0)) UNSOUND("sample %zu: weight %g", i, t->weight[i]);
        for (size_t c = 0; c < t->n_channels; c++) {
            const double v = t->value[c * t->n + i] * t->channels[c].scale;
            if (t->valid[i] && !isfinite(v)) UNSOUND("sample %zu, channel %zu: %g", i, c, v);
            if (t->valid[i] && t->sigma && !(t->sigma[c * t->n + i] > 0 && isfinite(t->sigma[c * t->n + i])))
                UNSOUND("sample %zu, channel %zu: sigma %g", i, c, t->sigma[c * t->n + i]);
            below_zero |= t->value[c * t->n + i] < 0;
        }
        invalid += t->valid[i] == 0;
        negative += t->valid[i] && below_zero;
    }
    if (invalid == t->n) UNSOUND("no sample is valid");
    if (invalid != t->n_invalid || negative != t->n_negative)
        UNSOUND("counted %zu invalid, %zu negative; the table says %zu, %zu", invalid, negative, t->n_invalid, t->n_negative);
    for (size_t c = 0; c < t->n_channels; c++) {
        if (!memchr(t->channels[c].name, '\0', FF_CHANNEL_NAME) || !t->channels[c].name[0]) UNSOUND("channel %zu has no name", c);
        if (!(t->channels[c].scale > 0) || !isfinite(t->channels[c].scale))
            UNSOUND("channel %zu: scale %g", c, t->channels[c].scale);
        if (ff_table_channel_find(t, t->channels[c].name) != (int)c) UNSOUND("two channels are called '%s'", t->channels[c].name);
    }
    size_t product = 1;
    for (int k = 0; k < 4 && t->axes.kind; k++) {
        product *= t->axes.n[k];
        for (size_t i = 0; i < t->axes.n[k]; i++)
            if (!isfinite(t->axes.node[k][i])) UNSOUND("axis %d: node %zu is %g", k, i, t->axes.node[k][i]);
    }
    if (t->axes.kind && product != t->n) UNSOUND("axes of %zu points, %zu samples", product, t->n);
    double w[6], *const planes[6] = {w, w + 1, w + 2, w + 3, w + 4, w + 5};
    for (size_t i = 0; i < t->n; i += t->n / 64 + 1) {
        ff_table_directions(t, i, 1, planes);
        for (int side = 0; side < 2; side++) {
            const double *v = w + 3 * side, length = sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
            if (!(fabs(length - 1) < 1e-6)) UNSOUND("sample %zu: direction %d has length %g", i, side, length);
        }
    }
#undef UNSOUND
    return NULL;
}
#endif
