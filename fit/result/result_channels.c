/* What is said of many channels: warnings that name channels with the same trouble together. */
#include "internal_result.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

const char *ff_channels_label(const struct ff_problem *p, const unsigned char *mark, char *out, size_t size)
{
    size_t n = 0, first = 0, last = 0, used = 0;
    for (size_t c = 0; c < p->n_channels; c++) {
        if (!mark[c]) continue;
        if (n++ == 0) first = c;
        last = c;
    }
    out[0] = '\0';
    if (p->n_channels > FF_CHANNELS_NAMED && n > 3) {
        snprintf(out, size, "%zu of %zu channels, %.32s to %.32s", n, p->n_channels, p->channel_name[first], p->channel_name[last]);
        return out;
    }
    for (size_t c = 0; c < p->n_channels && used < size; c++)
        if (mark[c]) used += (size_t)snprintf(out + used, size - used, "%s%.32s", used ? ", " : "", p->channel_name[c]);
    return out;
}

/* ---- warnings -------------------------------------------------------------------------------- */

/* Index in the model of a channel's own coordinate k. */
static uint32_t own_index(const ff_layout *l, size_t k)
{
    return (uint32_t)(ff_layout_param(l, l->n_shared + k, NULL) - l->m->channel);
}

void ff_result_warn_undetermined(const ff_layout *l, const struct ff_problem *p, ff_fit_result *r)
{
    char names[120];
    unsigned char *mark = malloc(r->n_channels + 1);
    for (size_t k = 0; k < l->n_own && mark; k++) {
        int any = 0;
        for (size_t c = 0; c < r->n_channels; c++) {
            const ff_fit_value *v = ff_result_value(l, r, l->n_shared + c * l->n_own + k);
            mark[c] = !v->at_bound && !v->held && isnan(v->std_error);
            any |= mark[c];
        }
        if (any)
            ff_result_warn(r, "%s (%s) is not determined by these data", l->m->channel[own_index(l, k)].name,
                           ff_channels_label(p, mark, names, sizeof names));
    }
    free(mark);
}

/* Channels in which a parameter and `other`, a column of the shape or (from n_columns on) a parameter of the channel, cannot be
 * told apart. */
static void warn_pair(const ff_layout *l, const struct ff_problem *p, uint32_t k, size_t other, const char *name,
                      unsigned char *mark, ff_fit_result *r)
{
    const size_t N = l->m->n_channel, width = r->n_columns + N;
    double most = 0;
    char names[120];
    for (size_t c = 0; c < r->n_channels; c++) {
        const double v = r->channel_correlation[(c * N + k) * width + other];
        mark[c] = fabs(v) >= 0.99;
        if (mark[c] && fabs(v) > fabs(most)) most = v;
    }
    if (most != 0)
        ff_result_warn(r, "%s and %s (%s) are correlated by up to %.4f: these data hardly tell them apart", name,
                       l->m->channel[k].name, ff_channels_label(p, mark, names, sizeof names), most);
}

void ff_result_warn_channels_correlated(const ff_layout *l, const struct ff_problem *p, ff_fit_result *r)
{
    unsigned char *mark = malloc(r->n_channels + 1);
    for (size_t i = 0; i < l->n_shared && mark; i++) {
        const ff_fit_value *x = ff_result_value(l, r, i);
        for (size_t j = 0; j < i; j++) {
            const ff_fit_value *y = ff_result_value(l, r, j);
            if (x->column < 0 || y->column < 0) continue;
            const double c = r->correlation[(size_t)x->column * r->n_columns + (size_t)y->column];
            if (fabs(c) >= 0.99)
                ff_result_warn(r, "%s and %s are correlated by %.4f: these data hardly tell them apart",
                               ff_layout_param(l, j, NULL)->name, ff_layout_param(l, i, NULL)->name, c);
        }
    }
    for (size_t k = 0; k < l->n_own && mark; k++) {
        for (size_t j = 0; j < l->n_shared; j++) {
            const ff_fit_value *v = ff_result_value(l, r, j);
            if (v->column >= 0) warn_pair(l, p, own_index(l, k), (size_t)v->column, ff_layout_param(l, j, NULL)->name, mark, r);
        }
        for (size_t j = 0; j < k; j++) {
            const uint32_t with = own_index(l, j);
            warn_pair(l, p, own_index(l, k), r->n_columns + with, l->m->channel[with].name, mark, r);
        }
    }
    free(mark);
}
