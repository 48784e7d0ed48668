/* What a lit sphere is made of: a model, or a table between whose samples is interpolated. */
#include "internal_render.h"
#include "data_formats/interpolation/internal_interpolate.h"
#include "data_formats/table/table_struct.h"
#include "models/model_struct.h"
#include "models/tools/internal_sample.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

static ff_status not_a_colour(size_t n, ff_error *err)
{
    return ff_error_set(err, FF_ERR_UNSUPPORTED, NULL, 0, -1,
                        "found %zu channels, expected 3 for a picture in colour or 1 for a grey one", n);
}

ff_status ff_surface_of_model(const ff_model *m, ff_isa isa, size_t n_channels, const double *shape, const double *channel,
                              ff_surface *out, ff_error *err)
{
    *out = (ff_surface){.n_channels = n_channels, .n_drawn = n_channels};
    if (n_channels != 1 && n_channels != 3) return not_a_colour(n_channels, err);
    for (size_t c = 0; c < 3; c++) out->channel[c] = n_channels == 3 ? c : 0;
    return ff_sampler_new(m, isa, n_channels, shape, channel, &out->sampler, err);
}

/* Two lobes and a diffuse term that meet most surfaces somewhere. */
static ff_status usual_sampler(ff_isa isa, ff_sampler **out, ff_error *err)
{
    static const char *const values[] = {"alpha=0.05", "lobe2.alpha=0.25", "f0=0.3", "lobe2.f0=0.3", "kd=0.3"};
    ff_model *m = malloc(sizeof *m);
    double shape[FF_MAX_SHAPE], channel[FF_MAX_CHANNEL_PARAMS];
    ff_status status = m ? ff_model_parse("ggx+ggx+lambert", m, err) : FF_ERR_MEMORY;
    if (status == FF_OK) ff_model_defaults(m, 1, shape, channel);
    for (size_t k = 0; k < sizeof values / sizeof *values && status == FF_OK; k++)
        status = ff_model_set(m, 1, values[k], shape, channel, err);
    if (status == FF_OK) status = ff_sampler_new(m, isa, 1, shape, channel, out, err);
    if (!m) ff_error_set(err, FF_ERR_MEMORY, NULL, 0, -1, "out of memory");
    free(m);
    return status;
}

/* By their names, where these are r, g and b. */
static void find_colours(const ff_table *t, size_t channel[3])
{
    static const char *const name[3] = {"r", "g", "b"};
    int at[3];
    for (int c = 0; c < 3; c++) at[c] = ff_table_channel_find(t, name[c]);
    for (size_t c = 0; c < 3; c++) {
        if (t->n_channels == 1)
            channel[c] = 0;
        else
            channel[c] = at[0] >= 0 && at[1] >= 0 && at[2] >= 0 ? (size_t)at[c] : c;
    }
}

ff_status ff_surface_of_table(const ff_table *t, const ff_model *by, ff_isa isa, size_t n_channels, const double *shape,
                              const double *channel, ff_surface *out, ff_error *err)
{
    *out = (ff_surface){.n_channels = t->n_channels, .n_drawn = by ? n_channels : 1};
    if (t->n_channels != 1 && t->n_channels != 3) return not_a_colour(t->n_channels, err);
    find_colours(t, out->channel);
    const ff_status status =
        by ? ff_sampler_new(by, isa, n_channels, shape, channel, &out->sampler, err) : usual_sampler(isa, &out->sampler, err);
    return status == FF_OK ? ff_interpolant_new(t, 0, &out->data, err) : status;
}

void ff_surface_clear(ff_surface *s)
{
    ff_sampler_free(s->sampler);
    ff_interpolant_free(s->data);
    *s = (ff_surface){0};
}

/* ---- values ---------------------------------------------------------------------------------- */

/* Of the surface's channels in b->values [channels][ld]; black where there is none. */
static void take_colours(const ff_surface *s, ff_beams *b, size_t ld)
{
    for (size_t c = 0; c < 3; c++)
        for (size_t i = 0; i < b->n; i++) {
            const double f = b->values[s->channel[c] * ld + i];
            b->f[c][i] = isfinite(f) ? f : 0;
        }
}

static void look_up(const ff_surface *s, ff_beams *b)
{
    const double *const w[6] = {b->wi[0], b->wi[1], b->wi[2], b->wo[0], b->wo[1], b->wo[2]};
    ff_interpolant_eval_reciprocal(s->data, w, b->n, b->values, b->found);
    take_colours(s, b, b->n);
    for (size_t i = 0; i < b->n; i++) {
        if (!(b->wi[2][i] > FF_COS_MIN && b->wo[2][i] > FF_COS_MIN)) continue;
        int known = b->found[i] != FF_FOUND_BELOW;
        for (size_t c = 0; c < s->n_channels; c++) known &= isfinite(b->values[c * b->n + i]) != 0;
        b->n_values++;
        b->n_guessed += b->found[i] == FF_FOUND_BEYOND;
        b->n_unknown += !known;
    }
}

void ff_surface_values(const ff_surface *s, ff_beams *b, int with_pdf)
{
    double *pdf = with_pdf ? b->pdf : NULL;
    if (s->data) {
        if (pdf) ff_sampler_values(s->sampler, b->n, b->wo[0], b->wi[0], pdf, NULL, FF_BEAMS);
        look_up(s, b);
        return;
    }
    ff_sampler_values(s->sampler, b->n, b->wo[0], b->wi[0], pdf, b->values, FF_BEAMS);
    take_colours(s, b, FF_BEAMS);
}

void ff_surface_draw(const ff_surface *s, ff_beams *b, const double *u)
{
    double *f = b->values, *weight = b->values + s->n_drawn * FF_BEAMS;
    ff_sampler_sample(s->sampler, b->n, b->wo[0], u, NULL, b->wi[0], b->pdf, s->data ? NULL : f, weight, FF_BEAMS);
    if (s->data)
        look_up(s, b);
    else
        take_colours(s, b, FF_BEAMS);
}
