/* How far two surfaces are apart. */
#include "internal_refit.h"
#include "simulate/simulate_struct.h"
#include <math.h>
#include <stdlib.h>

/* Values times cos(theta_i) at the directions of a goniometer, in steps of 15 degrees. */
static ff_status values_of(const ff_surface *s, ff_table *out)
{
    ff_simulate_options o;
    ff_simulate_options_init(&o);
    o.sampling.step_deg = 5;
    return ff_simulate_into(s->model, s->n_channels, s->shape, s->channel, &o, out, NULL);
}

double ff_surface_difference(const ff_surface *a, const ff_surface *b)
{
    enum { BLOCK = 256 };
    ff_table t;
    double planes[6][BLOCK], *const w[6] = {planes[0], planes[1], planes[2], planes[3], planes[4], planes[5]}, difference = 0,
                                    all = 0;
    if (a->n_channels != b->n_channels || values_of(a, &t) != FF_OK) return NAN;
    double *f = malloc(b->n_channels * BLOCK * sizeof *f);
    ff_status status = f ? FF_OK : FF_ERR_MEMORY;
    for (size_t first = 0; first < t.n && status == FF_OK; first += BLOCK) {
        const size_t n = t.n - first < BLOCK ? t.n - first : BLOCK;
        const ff_dirs dirs = {w[0], w[1], w[2], w[3], w[4], w[5]};
        ff_table_directions(&t, first, n, w);
        status = ff_model_eval(b->model, FF_ISA_BEST, b->n_channels, b->shape, b->channel, &dirs, n, f, NULL, BLOCK);
        for (size_t c = 0; c < b->n_channels && status == FF_OK; c++)
            for (size_t i = 0; i < n; i++) {
                const double y = t.value[c * t.n + first + i] * planes[2][i], x = f[c * BLOCK + i] * planes[2][i];
                if (!t.valid[first + i]) continue;
                difference += (x - y) * (x - y);
                all += y * y;
            }
    }
    free(f);
    ff_table_clear(&t);
    return status == FF_OK && all > 0 ? sqrt(difference / all) : NAN;
}
