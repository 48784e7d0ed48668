/* coverage: which directions of light and view were measured, on the hemisphere seen from above. */
#include "internal_curves.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { SLAB = 2048, ACROSS = 90, MOST_POINTS = 4000, THETA_STEPS = 360, PHI_STEPS = 1440 };

/* Directions told apart by a quarter of a degree. */
typedef struct seen {
    unsigned *count; /* [THETA_STEPS + 1][PHI_STEPS] samples */
    size_t distinct;
} seen;

static void count(seen *s, const double w[3])
{
    const double theta = atan2(hypot(w[0], w[1]), w[2]) / FF_DEGREE;
    double phi = atan2(w[1], w[0]) / FF_DEGREE;
    if (!(theta <= 90) || w[2] <= 0) return;
    if (phi < 0) phi += 360;
    const size_t a = (size_t)lround(theta * 4), b = theta < 0.05 ? 0 : (size_t)lround(phi * 4) % PHI_STEPS;
    unsigned *cell = &s->count[(a > THETA_STEPS ? THETA_STEPS : a) * PHI_STEPS + b];
    s->distinct += *cell == 0;
    *cell += *cell < 4000000000u;
}

/* Views of isotropic data as their azimuth from the light has it. */
static ff_status look(const ff_table *t, seen *light, seen *view)
{
    double *block = malloc(6 * SLAB * sizeof *block);
    if (!block) return FF_ERR_MEMORY;
    double *const w[6] = {block, block + SLAB, block + 2 * SLAB, block + 3 * SLAB, block + 4 * SLAB, block + 5 * SLAB};
    const size_t step = ff_plot_step(t->n), total = (t->n + step - 1) / step;
    for (size_t first = 0; first < total; first += SLAB) {
        const size_t n = total - first < SLAB ? total - first : SLAB;
        if (step == 1) ff_table_directions(t, first, n, w);
        for (size_t i = 0; i < n; i++) {
            const size_t index = (first + i) * step;
            double *const own[6] = {w[0] + i, w[1] + i, w[2] + i, w[3] + i, w[4] + i, w[5] + i};
            if (!t->valid[index]) continue;
            if (step > 1) ff_table_directions(t, index, 1, own);
            const double across = hypot(w[0][i], w[1][i]), ux = t->isotropic && across > 1e-9 ? w[0][i] / across : 1,
                         uy = t->isotropic && across > 1e-9 ? w[1][i] / across : 0;
            const double wi[3] = {w[0][i] * ux + w[1][i] * uy, w[1][i] * ux - w[0][i] * uy, w[2][i]},
                         wo[3] = {w[3][i] * ux + w[4][i] * uy, w[4][i] * ux - w[3][i] * uy, w[5][i]};
            if (wi[2] <= 0 || wo[2] <= 0) continue;
            count(light, wi);
            count(view, wo);
        }
    }
    free(block);
    return FF_OK;
}

static void add_points(const seen *s, ff_figure *fig, ff_panel *p, const char *name, ff_style style)
{
    ff_series *points = ff_panel_series(fig, p, FF_SERIES_POINTS, name, style, s->distinct, 0);
    size_t n = 0;
    for (size_t k = 0; k < (size_t)(THETA_STEPS + 1) * PHI_STEPS && points; k++) {
        const size_t row = k / PHI_STEPS;
        if (!s->count[k]) continue;
        points->x[n] = (double)(k % PHI_STEPS) / 4;
        points->y[n++] = (double)row / 4;
    }
    ff_series_cut(points, n);
}

/* Too many for points: samples in cells of two degrees, by colour. */
static void add_cells(const seen *s, ff_figure *fig, ff_panel *p, const char *name)
{
    ff_series *cells = ff_panel_image(fig, p, name, ACROSS, ACROSS);
    if (!cells) return;
    ff_image *im = &cells->image;
    im->x_lo = im->y_lo = -90, im->x_hi = im->y_hi = 90, im->log = 1;
    for (size_t k = 0; k < (size_t)(THETA_STEPS + 1) * PHI_STEPS; k++) {
        const size_t row = k / PHI_STEPS;
        if (!s->count[k]) continue;
        const double theta = (double)row / 4, phi = (double)(k % PHI_STEPS) / 4 * FF_DEGREE;
        const double x = fmin(fmax(theta * cos(phi) + 90, 0), 179.9), y = fmin(fmax(theta * sin(phi) + 90, 0), 179.9);
        double *z = &im->z[(size_t)(y / 180 * ACROSS) * ACROSS + (size_t)(x / 180 * ACROSS)];
        *z = isnan(*z) ? s->count[k] : *z + s->count[k];
    }
    ff_axis_say(&p->z, "samples", "1", FF_SCALE_LOG, NAN, NAN);
}

static void add_panel(const seen *s, const char *what, size_t step, ff_style style, ff_figure *fig)
{
    char title[FF_FIGURE_TEXT];
    snprintf(title, sizeof title, "%s: %s%zu direction%s", what, step > 1 ? "at least " : "", s->distinct,
             s->distinct == 1 ? "" : "s");
    ff_panel *p = ff_figure_panel(fig, title);
    if (!p) return;
    p->kind = FF_PANEL_DISC;
    ff_axis_say(&p->x, "φ", "degrees", FF_SCALE_ANGLE, 0, 360);
    ff_axis_say(&p->y, "θ", "degrees", FF_SCALE_ANGLE, 0, 90);
    if (s->distinct <= MOST_POINTS)
        add_points(s, fig, p, "", style);
    else
        add_cells(s, fig, p, "samples");
}

static ff_status build(const ff_plot_subject *s, const ff_plot_choice *c, ff_figure *fig, ff_error *err)
{
    const size_t cells = (size_t)(THETA_STEPS + 1) * PHI_STEPS;
    seen light = {calloc(cells, sizeof(unsigned)), 0}, view = {calloc(cells, sizeof(unsigned)), 0};
    (void)c;
    ff_status status = light.count && view.count ? look(s->table, &light, &view) : FF_ERR_MEMORY;
    if (!status && light.distinct == 0)
        status = ff_error_set(err, FF_ERR_DATA, NULL, 0, -1, "no sample has its directions above the horizon");
    const size_t step = ff_plot_step(s->table->n);
    if (!status) {
        add_panel(&light, "light", step, (ff_style){FF_COLOUR_ORANGE, 0, FF_MARKER_SQUARE}, fig);
        add_panel(&view, "view", step, (ff_style){FF_COLOUR_BLUE, 0, FF_MARKER_DOT}, fig);
        snprintf(fig->title, sizeof fig->title, "Directions measured");
        ff_figure_note(fig, "angles from the normal outwards, azimuths %s; told apart by a quarter of a degree",
                       s->table->isotropic ? "from that of the light" : "on the surface");
        if (step > 1) ff_figure_note(fig, "one of %zu samples is looked at", step);
        fig->columns = 2;
    }
    free(light.count);
    free(view.count);
    return status;
}

const ff_plot_kind ff_plot_coverage = {
    .name = "coverage",
    .help = "directions of light and view that were measured, on the hemisphere",
    .takes = FF_PLOT_DATA,
    .build = build,
};
