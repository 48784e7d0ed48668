/* Where channels differ in what is known of a parameter: a bound of one channel, a value that a parameter is held at in one of
 * them, or another one in each. */
#include "internal_layout.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

void ff_limits_free(ff_limits *limits)
{
    if (limits) free(limits->lo);
    free(limits);
}

/* Those of the model. */
ff_limits *ff_limits_new(const ff_model *m, size_t n_channels)
{
    const size_t n = m->n_channel, size = n_channels * n;
    ff_limits *limits = calloc(1, sizeof *limits);
    double *memory = limits ? malloc((3 * size + 1) * sizeof *memory) : NULL;
    if (!memory) {
        free(limits);
        return NULL;
    }
    *limits = (ff_limits){memory, memory + size, memory + 2 * size};
    for (size_t i = 0; i < size; i++) {
        limits->lo[i] = m->channel[i % n].lo;
        limits->hi[i] = m->channel[i % n].hi;
        limits->init[i] = m->channel[i % n].init;
    }
    return limits;
}

void ff_limits_copy(const ff_limits *from, size_t from_n, size_t from_k, size_t n_channels, ff_limits *to, size_t n, size_t k)
{
    for (size_t c = 0; c < n_channels; c++) {
        to->lo[c * n + k] = from->lo[c * from_n + from_k];
        to->hi[c * n + k] = from->hi[c * from_n + from_k];
        to->init[c * n + k] = from->init[c * from_n + from_k];
    }
}

/* ---- names ----------------------------------------------------------------------------------- */

/* "r, g, b" */
static const char *list_channels(const struct ff_problem *p, char *out, size_t size)
{
    size_t used = 0;
    for (size_t c = 0; c < p->n_table_channels && used < size; c++)
        used += (size_t)snprintf(out + used, size - used, "%s%s", c ? ", " : "", p->table_channel[c]);
    return out;
}

ff_status ff_channel_find(const struct ff_problem *p, const char *name, const char *channel, int *out, ff_error *err)
{
    char known[200];
    int in_table = 0;
    *out = -1;
    for (size_t c = 0; c < p->n_channels; c++)
        if (strcmp(p->channel_name[c], channel) == 0) *out = (int)c;
    for (size_t c = 0; c < p->n_table_channels; c++) in_table |= strcmp(p->table_channel[c], channel) == 0;
    if (*out >= 0 || (in_table && p->only_channel >= 0)) return FF_OK;
    if (in_table)
        return ff_error_set(err, FF_ERR_UNSUPPORTED, NULL, 0, -1, "%s[%s]: the channels are averaged to one, '%s'", name, channel,
                            p->channel_name[0]);
    return ff_error_set(err, FF_ERR_UNKNOWN, NULL, 0, -1, "%s[%s]: there is no channel '%s'; the data have %s", name, channel,
                        channel, list_channels(p, known, sizeof known));
}

/* Index of the per-channel parameter, -1 for one that the model lacks, which ff_constraints_apply has refused or let pass. */
static int parameter(const ff_model *m, const char *name)
{
    const ff_param_ref at = ff_model_param_find(m, name);
    return at.kind == FF_PARAM_CHANNEL ? (int)at.index : -1;
}

/* What is tied has one value where it is. */
static ff_status check_free_of_ties(const ff_model *m, int k, const ff_ties *ties, ff_error *err)
{
    int tied = ties->shared[k] || ties->channel[k] != (uint32_t)k;
    for (uint32_t i = 0; i < m->n_channel; i++) tied |= i != (uint32_t)k && ties->channel[i] == (uint32_t)k;
    if (!tied) return FF_OK;
    return ff_error_set(err, FF_ERR_UNSUPPORTED, NULL, 0, -1, "%s is tied: its channels cannot have bounds or values of their own",
                        m->channel[k].name);
}

/* ---- constraints ----------------------------------------------------------------------------- */

static void set(ff_limits *limits, const ff_model *m, size_t c, int k, double lo, double hi)
{
    const size_t i = c * m->n_channel + (size_t)k;
    limits->lo[i] = lo;
    limits->hi[i] = hi;
    if (limits->init[i] < lo) limits->init[i] = lo;
    if (limits->init[i] > hi) limits->init[i] = hi;
}

static ff_status add_bound(const struct ff_problem *p, const ff_model *m, const ff_ties *ties, const ff_bound *b, ff_limits *limits,
                           ff_error *err)
{
    const int k = parameter(m, b->name);
    int c;
    if (!b->channel || k < 0) return FF_OK;
    const ff_status status = ff_channel_find(p, b->name, b->channel, &c, err);
    if (status || c < 0) return status;
    if (m->channel[k].flags & FF_PARAM_HELD)
        return ff_error_set(err, FF_ERR_UNSUPPORTED, NULL, 0, -1, "%s is held: a bound of its channel %s says nothing", b->name,
                            b->channel);
    set(limits, m, (size_t)c, k, b->lo, b->hi);
    return check_free_of_ties(m, k, ties, err);
}

/* Values by channel: as many as the table has, of which the problem may take one. */
static ff_status add_values(const struct ff_problem *p, const ff_model *m, int k, const ff_fixed *f, ff_limits *limits,
                            ff_error *err)
{
    const size_t expected = p->only_channel >= 0 ? p->n_table_channels : p->n_channels;
    char known[200];
    if (f->n != 1 && f->n != expected && expected == 1)
        return ff_error_set(err, FF_ERR_RANGE, NULL, 0, -1, "%s is held at %zu values; expected 1, there is one channel, '%s'",
                            f->name, f->n, p->channel_name[0]);
    if (f->n != 1 && f->n != expected)
        return ff_error_set(err, FF_ERR_RANGE, NULL, 0, -1, "%s is held at %zu values; expected %zu, one for each channel (%s)",
                            f->name, f->n, expected, list_channels(p, known, sizeof known));
    for (size_t c = 0; c < p->n_channels; c++) {
        const double v = f->value[f->n == 1 ? 0 : p->only_channel >= 0 ? (size_t)p->only_channel : c];
        set(limits, m, c, k, v, v);
    }
    return FF_OK;
}

static ff_status add_fixed(const struct ff_problem *p, const ff_model *m, const ff_ties *ties, const ff_fixed *f, ff_limits *limits,
                           ff_error *err)
{
    const int k = parameter(m, f->name);
    if (k < 0) return FF_OK;
    if (!f->channel) {
        const ff_status status = add_values(p, m, k, f, limits, err);
        return status ? status : check_free_of_ties(m, k, ties, err);
    }
    int c;
    const ff_status status = ff_channel_find(p, f->name, f->channel, &c, err);
    if (status || c < 0) return status;
    set(limits, m, (size_t)c, k, f->value[0], f->value[0]);
    return check_free_of_ties(m, k, ties, err);
}

/* Values of all channels first, so that those of one stand. */
ff_status ff_limits_of(const ff_constraints *c, const struct ff_problem *p, const ff_model *m, const ff_ties *ties, ff_limits **out,
                       ff_error *err)
{
    size_t wanted = c ? c->n_fixed : 0;
    *out = NULL;
    for (size_t i = 0; c && i < c->n_bounds; i++) wanted += c->bound[i].channel != NULL;
    if (wanted == 0) return FF_OK;
    ff_limits *limits = ff_limits_new(m, p->n_channels);
    if (!limits) return ff_error_set(err, FF_ERR_MEMORY, NULL, 0, -1, "out of memory");
    ff_status status = FF_OK;
    for (size_t i = 0; i < c->n_bounds && !status; i++) status = add_bound(p, m, ties, &c->bound[i], limits, err);
    for (int named = 0; named < 2; named++)
        for (size_t i = 0; i < c->n_fixed && !status; i++)
            if ((c->fixed[i].channel != NULL) == named) status = add_fixed(p, m, ties, &c->fixed[i], limits, err);
    if (status)
        ff_limits_free(limits);
    else
        *out = limits;
    return status;
}
