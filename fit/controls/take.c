/* What is set in the renderer after a refit. */
#include "internal_refit.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* The controls inside their ranges; 1 where one of them was not. */
static int take(const ff_refit *r, double *control)
{
    const size_t n = ff_control_count(r->material), C = r->n_channels;
    int cut = 0;
    for (size_t k = 0; k < n; k++)
        for (size_t c = 0; c < C; c++) {
            const ff_control *of = &r->material->control[k];
            const double x = ff_control_value(of, &r->model, r->shape, r->channel, c, NULL, NULL),
                         in = fmin(fmax(x, of->lo), of->hi);
            cut |= in != x && (c == 0 || of->is_color);
            control[k * C + c] = in;
        }
    return cut;
}

ff_status ff_refit_controls(ff_refit *r, double *control)
{
    const size_t C = r->n_channels;
    if (!take(r, control) || r->n_lost == FF_LOST_MOST) return FF_OK;
    double shape[FF_MAX_SHAPE], *channel = malloc((C * r->model.n_channel + 1) * sizeof *channel);
    if (!channel) return FF_ERR_MEMORY;
    memcpy(shape, r->shape, r->model.n_shape * sizeof *shape);
    memcpy(channel, r->channel, C * r->model.n_channel * sizeof *channel);
    ff_material_parameters(r->material, &r->model, C, control, shape, channel);
    const ff_surface before = {&r->model, C, r->shape, r->channel}, after = {&r->model, C, shape, channel};
    ff_lost *lost = &r->lost[r->n_lost++];
    snprintf(lost->what, sizeof lost->what, "controls: beyond what the renderer takes as the nearest that it does");
    lost->share = ff_surface_difference(&before, &after);
    free(channel);
    return FF_OK;
}
