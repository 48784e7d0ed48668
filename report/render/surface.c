/* What a lit sphere is made of: a model, or a table between whose samples is interpolated. */
#include "internal_render.h"
#include "ff_spectral.h"
#include "data_formats/interpolation/internal_interpolate.h"
#include "data_formats/table/table_struct.h"
#include "models/model_struct.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

static ff_status no_memory(ff_error *err)
{
    return ff_error_set(err, FF_ERR_MEMORY, NULL, 0, -1, "no memory for the colours of the channels");
}

/* How the channels of out make colours: as the caller says, or as they do by themselves. */
static ff_status take_matrix(const double *colours, const ff_channel *channels, ff_surface *out, ff_error *err)
{
    const size_t n = out->n_channels;
    out->colours = malloc(3 * n * sizeof *colours);
    if (!out->colours) return no_memory(err);
    if (!colours) return ff_spectral_colours(n, channels, out->colours, err);
    memcpy(out->colours, colours, 3 * n * sizeof *colours);
    return FF_OK;
}

ff_status ff_surface_of_model(const ff_model *m, ff_isa isa, size_t n_channels, const double *shape, const double *channel,
                              const double *colours, ff_surface *out, ff_error *err)
{
    const ff_channel unnamed[3] = {{.wavelength_nm = NAN}, {.wavelength_nm = NAN}, {.wavelength_nm = NAN}};
    *out = (ff_surface){.n_channels = n_channels, .n_drawn = n_channels};
    if (!colours && n_channels != 1 && n_channels != 3)
        return ff_error_set(err, FF_ERR_UNSUPPORTED, NULL, 0, -1,
                            "found %zu channels, expected 3 for a picture in colour, 1 for a grey one, or how they make colours",
                            n_channels);
    const ff_status status = take_matrix(colours, unnamed, out, err);
    return status == FF_OK ? ff_sampler_new(m, isa, n_channels, shape, channel, &out->sampler, err) : status;
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

ff_status ff_surface_of_table(const ff_table *t, const ff_model *by, ff_isa isa, size_t n_channels, const double *shape,
                              const double *channel, const double *colours, ff_surface *out, ff_error *err)
{
    *out = (ff_surface){.n_channels = t->n_channels, .n_drawn = by ? n_channels : 1};
    ff_status status = take_matrix(colours, t->channels, out, err);
    if (status == FF_OK)
        status =
            by ? ff_sampler_new(by, isa, n_channels, shape, channel, &out->sampler, err) : usual_sampler(isa, &out->sampler, err);
    return status == FF_OK ? ff_interpolant_new(t, 0, &out->data, err) : status;
}

void ff_surface_clear(ff_surface *s)
{
    ff_sampler_free(s->sampler);
    ff_interpolant_free(s->data);
    free(s->colours);
    *s = (ff_surface){0};
}

/* ---- values ---------------------------------------------------------------------------------- */

/* Of the surface's channels in b->values [channels][ld]; what is not known is black. */
static void take_colours(const ff_surface *s, ff_beams *b, size_t ld)
{
    memset(b->f, 0, sizeof b->f);
    for (size_t k = 0; k < 3; k++)
        for (size_t c = 0; c < s->n_channels; c++) {
            const double part = s->colours[k * s->n_channels + c], *f = b->values + c * ld;
            if (part == 0) continue;
            for (size_t i = 0; i < b->n; i++) b->f[k][i] += isfinite(f[i]) ? part * f[i] : 0;
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
        if (pdf) ff_sampler_values_block(s->sampler, b->n, b->wo[0], b->wi[0], &b->share, pdf, NULL, FF_BEAMS);
        look_up(s, b);
        return;
    }
    ff_sampler_values_block(s->sampler, b->n, b->wo[0], b->wi[0], &b->share, pdf, b->values, FF_BEAMS);
    take_colours(s, b, FF_BEAMS);
}

void ff_surface_draw(const ff_surface *s, ff_beams *b, const double *u)
{
    double *f = b->values, *weight = b->values + s->n_drawn * FF_BEAMS;
    ff_sampler_sample_block(s->sampler, b->n, b->wo[0], u, NULL, b->wi[0], b->pdf, s->data ? NULL : f, weight, FF_BEAMS, &b->share);
    if (s->data)
        look_up(s, b);
    else
        take_colours(s, b, FF_BEAMS);
}
