/* slice: the plane of incidence along an axis. */
#include "internal_slices.h"

static ff_status build(const ff_plot_subject *s, const ff_plot_choice *c, ff_figure *out, ff_error *err)
{
    return ff_slices_build(s, c, 0, out, err);
}

const ff_plot_kind ff_plot_slice = {
    .name = "slice",
    .help = "f against the angle of the view, in the plane of incidence: data, model, lobe and diffuse apart",
    .takes = FF_PLOT_DATA | FF_PLOT_FITS | FF_PLOT_MODELS,
    .uses = FF_PLOT_INCIDENCE | FF_PLOT_LOG | FF_PLOT_CHANNEL | FF_PLOT_ROUGHNESS | FF_PLOT_SEVERAL,
    .build = build,
};
