/* polar: the plane of incidence as a half disc. */
#include "internal_slices.h"

static ff_status build(const ff_plot_subject *s, const ff_plot_choice *c, ff_figure *out, ff_error *err)
{
    return ff_slices_build(s, c, 1, out, err);
}

const ff_plot_kind ff_plot_polar = {
    .name = "polar",
    .help = "the same, the angle around a half disc",
    .takes = FF_PLOT_DATA | FF_PLOT_FITS | FF_PLOT_MODELS,
    .uses = FF_PLOT_INCIDENCE | FF_PLOT_LOG | FF_PLOT_CHANNEL | FF_PLOT_ROUGHNESS | FF_PLOT_SEVERAL,
    .build = build,
};
