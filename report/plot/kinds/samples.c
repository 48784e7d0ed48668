/* Samples by half angle and difference angle (Rusinkiewicz 1998). */
#include "internal_samples.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { SLAB = 1024, PLANES = 7 };

void ff_samples_free(ff_samples *s)
{
    free(s->theta_h);
    *s = (ff_samples){.n = 0};
}

static ff_status make_room(size_t n, int with_model, ff_samples *out)
{
    double *all = n < SIZE_MAX / (PLANES * sizeof *all) ? malloc((PLANES * n + 1) * sizeof *all) : NULL;
    if (!all) return FF_ERR_MEMORY;
    *out = (ff_samples){.theta_h = all, .theta_d = all + n, .value = all + 2 * n};
    if (with_model) out->total = all + 3 * n, out->lobe = all + 4 * n, out->base = all + 5 * n, out->d = all + 6 * n;
    return FF_OK;
}

/* Those of a slab that count, their directions packed to the front of the planes. */
static size_t take_slab(const ff_plot_subject *s, int channel, size_t first, size_t n, size_t step, double *const plane[6],
                        ff_samples *out)
{
    const double least = cos(s->max_theta) - 1e-9;
    size_t kept = 0;
    if (step == 1) ff_table_directions(s->table, first, n, plane);
    for (size_t i = 0; i < n; i++) {
        double *const own[6] = {plane[0] + i, plane[1] + i, plane[2] + i, plane[3] + i, plane[4] + i, plane[5] + i};
        const size_t index = first + i * step;
        if (step > 1) ff_table_directions(s->table, index, 1, own);
        const double zi = plane[2][i], zo = plane[5][i];
        if (!s->table->valid[index] || !(zi > fmax(least, 1e-6)) || !(zo > fmax(least, 1e-6))) continue;
        for (int k = 0; k < 6; k++) plane[k][kept] = plane[k][i];
        const double io = plane[0][kept] * plane[3][kept] + plane[1][kept] * plane[4][kept] + zi * zo,
                     length = sqrt(fmax(2 + 2 * io, 1e-300));
        const size_t at = out->n + kept++;
        out->theta_h[at] = acos(fmin((zi + zo) / length, 1));
        out->theta_d[at] = acos(fmin(0.5 * length, 1));
        out->value[at] = ff_plot_value(s->table, channel, index);
    }
    return kept;
}

static ff_status evaluate(const ff_plot_model *m, ff_isa isa, size_t channel, const ff_dirs *w, size_t n, ff_samples *out,
                          ff_error *err)
{
    double other[(FF_MAX_LOBES - 1) * SLAB], *const lobes[FF_MAX_LOBES] = {out->lobe + out->n, other, other + SLAB};
    const size_t c = channel < m->n_channels ? channel : 0, at = out->n;
    ff_status status = ff_plot_evaluate(m, isa, c, w, n, out->total + at, lobes, NULL, err);
    if (!status && m->model->n_lobes)
        status = ff_model_terms(m->model, isa, m->n_channels, m->shape, m->channel, 0, c, w, n, &(ff_terms){.d = out->d + at});
    for (size_t i = at; i < at + n && !status; i++) {
        if (!m->model->n_lobes) out->lobe[i] = 0, out->d[i] = NAN;
        out->base[i] = out->total[i] - out->lobe[i];
    }
    return status;
}

ff_status ff_samples_make(const ff_plot_subject *s, const ff_plot_channel *channel, ff_isa isa, ff_samples *out, ff_error *err)
{
    ff_directions d;
    ff_samples made;
    const size_t step = ff_plot_step(s->table->n), total = (s->table->n + step - 1) / step;
    ff_status status = make_room(total, s->n_models > 0, &made);
    if (status) return status;
    if ((status = ff_directions_new(SLAB, &d))) {
        ff_samples_free(&made);
        return status;
    }
    for (size_t first = 0; first < total && !status; first += SLAB) {
        const size_t n =
            take_slab(s, channel->of_table, first * step, total - first < SLAB ? total - first : SLAB, step, d.plane, &made);
        if (s->n_models && n) status = evaluate(&s->model[0], isa, channel->of_model, &d.w, n, &made, err);
        made.n += n;
    }
    ff_directions_free(&d);
    if (!status && made.n == 0) status = ff_error_set(err, FF_ERR_DATA, NULL, 0, -1, "no sample is left to draw");
    if (status)
        ff_samples_free(&made);
    else
        made.step = step, *out = made;
    return status;
}
