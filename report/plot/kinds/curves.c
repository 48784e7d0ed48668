/* Channels and models for the kinds. */
#include "internal_curves.h"
#include "models/internal_model.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- channels -------------------------------------------------------------------------------- */

static void name_of(const ff_plot_model *m, const ff_table *t, size_t c, char out[FF_CHANNEL_NAME])
{
    static const char *const rgb[] = {"r", "g", "b"};
    const size_t n = m ? m->n_channels : t ? t->n_channels : 1;
    *out = '\0';
    if (m && m->channel_name)
        snprintf(out, FF_CHANNEL_NAME, "%s", m->channel_name[c]);
    else if (t && t->n_channels == n)
        snprintf(out, FF_CHANNEL_NAME, "%s", t->channels[c].name);
    else if (n == 3)
        snprintf(out, FF_CHANNEL_NAME, "%s", rgb[c]);
    else if (n > 1)
        snprintf(out, FF_CHANNEL_NAME, "c%zu", c);
}

/* Of the same name, or place; -1: all of the table's, for a model of their mean. */
static int in_table(const ff_plot_model *m, const ff_table *t, size_t c, const char *name)
{
    const int found = t ? ff_table_channel_find(t, name) : -1;
    if (!t || found >= 0) return found;
    return m && m->n_channels != t->n_channels ? (t->n_channels == 1 ? 0 : -1) : (int)c;
}

static void take(const ff_plot_model *m, const ff_table *t, size_t c, ff_plot_channel *out)
{
    name_of(m, t, c, out->name);
    out->of_table = in_table(m, t, c, out->name);
    out->of_model = c;
}

ff_status ff_plot_channels(const ff_plot_model *m, const ff_table *t, const char *names, ff_plot_channel *out, size_t *n,
                           ff_error *err)
{
    const size_t count = m ? m->n_channels : t->n_channels;
    char known[256] = "", name[FF_CHANNEL_NAME];
    *n = 0;
    if (!names) {
        take(m, t, count / 2, &out[(*n)++]);
        return FF_OK;
    }
    for (const char *word = names;; word++) {
        const size_t length = strcspn(word, ",");
        size_t c = 0;
        for (; c < count; c++) {
            name_of(m, t, c, name);
            if (strlen(name) == length && !strncmp(name, word, length)) break;
        }
        if (c == count) {
            for (size_t k = 0; k < count && strlen(known) < sizeof known - FF_CHANNEL_NAME - 4; k++) {
                name_of(m, t, k, name);
                snprintf(known + strlen(known), sizeof known - strlen(known), "%s%s", k ? ", " : "", name);
            }
            return ff_error_set(err, FF_ERR_UNKNOWN, NULL, 0, -1, "no channel '%.*s'; there are: %s",
                                (int)(length < 64 ? length : 64), word, *known ? known : "one without a name");
        }
        if (*n == FF_PLOT_LIST)
            return ff_error_set(err, FF_ERR_RANGE, NULL, 0, -1, "more than %d channels in one figure", FF_PLOT_LIST);
        take(m, t, c, &out[(*n)++]);
        word += length;
        if (!*word) return FF_OK;
    }
}

double ff_plot_value(const ff_table *t, int channel, size_t i)
{
    double sum = 0;
    if (channel >= 0) return t->value[(size_t)channel * t->n + i] * t->channels[channel].scale;
    for (size_t c = 0; c < t->n_channels; c++) sum += t->value[c * t->n + i] * t->channels[c].scale;
    return sum / (double)t->n_channels;
}

double ff_plot_sigma(const ff_table *t, int channel, size_t i)
{
    if (!t->sigma || (channel < 0 && t->n_channels > 1)) return NAN;
    const size_t c = channel < 0 ? 0 : (size_t)channel;
    return t->sigma[c * t->n + i] * t->channels[c].scale;
}

size_t ff_plot_step(size_t n)
{
    enum { ENOUGH = 150000 };
    static const size_t prime[] = {1, 7, 11, 13, 17, 23, 31, 61, 127, 251, 509};
    size_t k = 0;
    while (k + 1 < sizeof prime / sizeof *prime && n / prime[k] > ENOUGH) k++;
    return prime[k];
}

int ff_plot_names(const char *list, const char *name)
{
    const size_t whole = strlen(name), bare = strcspn(name, "[");
    for (const char *word = list; word; word = strchr(word, ',') ? strchr(word, ',') + 1 : NULL) {
        const size_t n = strcspn(word, ",");
        if ((n == whole || n == bare) && !strncmp(word, name, n)) return 1;
    }
    return list == NULL;
}

/* ---- models ---------------------------------------------------------------------------------- */

/* A lobe alone with its weight, added to sum. */
static ff_status one_lobe(const ff_plot_model *m, ff_isa isa, uint32_t l, size_t channel, const ff_dirs *w, size_t n,
                          double *planes, double *own, ff_error *err)
{
    double shape[FF_MAX_SHAPE], weight[FF_MAX_LOBES];
    ff_model alone;
    double *values = malloc((m->n_channels * FF_MAX_CHANNEL_PARAMS + 1) * sizeof *values);
    if (!values) return FF_ERR_MEMORY;
    ff_model_lobe_alone(m->model, l, m->n_channels, m->shape, m->channel, &alone, shape, values);
    ff_model_weights(m->model, m->shape, weight, NULL);
    const ff_status status = ff_aperture_eval(&m->aperture, &alone, isa, m->n_channels, shape, values, w, n, planes, NULL, NULL, n);
    for (size_t i = 0; i < n && !status; i++) own[i] = weight[l] * planes[channel * n + i];
    if (status) ff_error_set(err, status, NULL, 0, -1, "the lobe cannot be evaluated by itself: %s", ff_status_str(status));
    free(values);
    return status;
}

ff_status ff_plot_evaluate(const ff_plot_model *m, ff_isa isa, size_t channel, const ff_dirs *w, size_t n, double *total,
                           double *const *lobes, double *base, ff_error *err)
{
    double *planes = malloc((m->n_channels * n + 1) * sizeof *planes), *own = malloc((n + 1) * sizeof *own);
    ff_status status = planes && own ? ff_aperture_eval(&m->aperture, m->model, isa, m->n_channels, m->shape, m->channel, w, n,
                                                        planes, NULL, NULL, n)
                                     : FF_ERR_MEMORY;
    if (status && status != FF_ERR_MEMORY)
        ff_error_set(err, status, NULL, 0, -1, "%s cannot be evaluated: %s", m->label, ff_status_str(status));
    for (size_t i = 0; i < n && !status; i++) {
        if (total) total[i] = planes[channel * n + i];
        if (base) base[i] = planes[channel * n + i];
    }
    for (uint32_t l = 0; l < m->model->n_lobes && !status && (lobes || base); l++) {
        status = one_lobe(m, isa, l, channel, w, n, planes, own, err);
        for (size_t i = 0; i < n && !status; i++) {
            if (lobes) lobes[l][i] = own[i];
            if (base) base[i] -= own[i];
        }
    }
    free(planes);
    free(own);
    return status;
}

ff_status ff_directions_new(size_t n, ff_directions *out)
{
    double *all = malloc((6 * n + 1) * sizeof *all);
    if (!all) return FF_ERR_MEMORY;
    *out = (ff_directions){.n = n};
    for (size_t k = 0; k < 6; k++) out->plane[k] = all + k * n;
    out->w = (ff_dirs){out->plane[0], out->plane[1], out->plane[2], out->plane[3], out->plane[4], out->plane[5]};
    return FF_OK;
}

void ff_directions_free(ff_directions *d)
{
    free(d->plane[0]);
    d->plane[0] = NULL;
}

void ff_directions_set(ff_directions *d, size_t i, double theta_i, double phi_i, double theta_o, double phi_o)
{
    d->plane[0][i] = sin(theta_i) * cos(phi_i);
    d->plane[1][i] = sin(theta_i) * sin(phi_i);
    d->plane[2][i] = cos(theta_i);
    d->plane[3][i] = sin(theta_o) * cos(phi_o);
    d->plane[4][i] = sin(theta_o) * sin(phi_o);
    d->plane[5][i] = cos(theta_o);
}

void ff_plot_title(const ff_plot_model *m, const ff_plot_channel *c, char *out, size_t size)
{
    char label[FF_FIGURE_TEXT / 2], channel[FF_CHANNEL_NAME + 8];
    ff_figure_plain(m ? m->label : "", label, sizeof label);
    ff_figure_plain(c ? c->name : "", channel, sizeof channel);
    snprintf(out, size, "%s%s%s%s", label, *channel ? (*label ? ", channel " : "channel ") : "", channel, "");
}

void ff_plot_note_failed(ff_figure *fig, const char *of, const char *outcome)
{
    if (!outcome || !strcmp(outcome, "converged")) return;
    ff_figure_note(fig, "%s did not converge%s%s", of ? of : "the fit", strcmp(outcome, "limit") ? ": " : " within its iterations",
                   strcmp(outcome, "limit") ? outcome : "");
}

void ff_plot_note_outcome(ff_figure *fig, const ff_plot_model *m)
{
    if (m) ff_plot_note_failed(fig, NULL, m->outcome);
}
