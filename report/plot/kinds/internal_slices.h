/* The plane of incidence, for the two kinds that show it. */
#ifndef FF_INTERNAL_SLICES_H
#define FF_INTERNAL_SLICES_H
#include "internal_curves.h"

/* A panel an incidence; polar: angles round a half disc, else along an axis. */
ff_status ff_slices_build(const ff_plot_subject *s, const ff_plot_choice *c, int polar, ff_figure *out, ff_error *err);

#endif
