/* correlation: which parameters the data cannot tell apart. */
#include "internal_curves.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { MOST = 60, WRITTEN = 14 };

static ff_status build(const ff_plot_subject *s, const ff_plot_choice *c, ff_figure *fig, ff_error *err)
{
    const ff_fitted *f = &s->document->fit[s->document->best];
    size_t column[MOST], n = 0, left_out = 0;
    for (size_t k = 0; k < f->n_columns; k++) {
        if (!ff_plot_names(c->parameter, f->column_name[k])) continue;
        if (n < MOST)
            column[n++] = k;
        else
            left_out++;
    }
    if (n == 0)
        return ff_error_set(err, f->n_columns ? FF_ERR_UNKNOWN : FF_ERR_DATA, NULL, 0, -1,
                            f->n_columns ? "none of the parameters '%.200s' has correlations"
                                         : "the result has no correlations%.0s",
                            c->parameter ? c->parameter : "");
    ff_panel *p = ff_figure_panel(fig, "");
    ff_series *image = ff_panel_image(fig, p, "correlation", n, n);
    if (!image) return FF_OK;
    ff_axis_names(fig, &p->x, n);
    ff_axis_names(fig, &p->y, n);
    ff_axis_say(&p->z, "correlation", "1", FF_SCALE_LINEAR, -1, 1);
    p->equal_cells = 1;
    image->image = (ff_image){.nx = n,
                              .ny = n,
                              .x_lo = -0.5,
                              .x_hi = (double)n - 0.5,
                              .y_lo = -0.5,
                              .y_hi = (double)n - 0.5,
                              .z = image->image.z,
                              .map = FF_MAP_DIVERGING,
                              .clip = 1,
                              .written = n <= WRITTEN};
    for (size_t a = 0; a < n; a++) {
        char name[FF_AXIS_NAME];
        ff_figure_plain(f->column_name[column[a]], name, sizeof name);
        ff_axis_name(&p->x, a, name);
        ff_axis_name(&p->y, a, name);
        for (size_t b = 0; b < n; b++) image->image.z[a * n + b] = f->correlation[column[a] * f->n_columns + column[b]];
    }
    snprintf(fig->title, sizeof fig->title, "%s", f->expression);
    if (left_out) ff_figure_note(fig, "%zu more parameters are not drawn", left_out);
    if (strcmp(f->outcome, "converged")) ff_figure_note(fig, "the fit did not converge: %s", f->outcome);
    return FF_OK;
}

const ff_plot_kind ff_plot_correlation = {
    .name = "correlation",
    .help = "correlations of the parameters of a fit",
    .takes = FF_PLOT_FITS | FF_PLOT_RESULTS,
    .build = build,
};
