/* What is said of an optimum: shared by result.c and result_channels.c. */
#ifndef FF_INTERNAL_RESULT_H
#define FF_INTERNAL_RESULT_H
#include "internal_arrow.h"
#include <stdarg.h>
#include <stdio.h>

static inline void warn(ff_fit_result *r, const char *fmt, ...) __attribute__((format(printf, 2, 3)));
static inline void warn(ff_fit_result *r, const char *fmt, ...)
{
    if (r->n_warnings == FF_MAX_WARNINGS) return;
    va_list args;
    va_start(args, fmt);
    vsnprintf(r->warning[r->n_warnings++], FF_WARNING_LENGTH, fmt, args);
    va_end(args);
}

static inline ff_fit_value *value_at(const ff_layout *l, ff_fit_result *r, size_t k)
{
    if (k < l->free.n_shape) return &r->shape_value[l->free.shape[k]];
    const size_t c = (k - l->free.n_shape) / l->free.n_channel, i = (k - l->free.n_shape) % l->free.n_channel;
    return &r->channel_value[c * l->m->n_channel + l->free.channel[i]];
}

/* Up to this many channels, a warning names each that it is about. */
enum { FF_CHANNELS_NAMED = 8 };

/* Of the channels that are marked (mark [n_channels], not all 0): "400, 410, 450", or where there are many, "31 of 121 channels,
 * 400 to 700". Returns out. */
const char *ff_channels_label(const struct ff_problem *p, const unsigned char *mark, char *out, size_t size);

/* Standard errors and correlations of a layout that is an arrow. FF_ERR_MEMORY. */
ff_status ff_result_channel_errors(const ff_layout *l, const ff_arrow *a, ff_fit_result *r);

/* Warnings of what the data do not determine or do not tell apart, for more channels than FF_CHANNELS_NAMED: one for all channels
 * with the same trouble. errors, correlations: which of them. */
void ff_result_warn_undetermined(const ff_layout *l, const struct ff_problem *p, ff_fit_result *r);
void ff_result_warn_channels_correlated(const ff_layout *l, const struct ff_problem *p, ff_fit_result *r);
#endif
