/* residuals: where the model is too high or too low, by bands of every angle; of a comparison the best fit under every masking. */
#include "internal_curves.h"
#include <math.h>
#include <string.h>

enum { MOST = 12 };

/* The best fit of each masking, by rank; how many. */
static size_t choose(const ff_fit_document *d, size_t *out)
{
    int seen[64] = {0};
    size_t n = 0;
    for (size_t k = 0; k < d->n_fits && n < MOST; k++) {
        const ff_fitted *f = &d->fit[d->rank[k]];
        const int masking = f->model.n_lobes ? f->model.lobe[0].masking : 63;
        if (!f->has_bands || masking < 0 || masking > 63 || seen[masking]++) continue;
        out[n++] = d->rank[k];
    }
    return n;
}

static void name_of(const ff_fitted *f, int several, char out[FF_FIGURE_TEXT])
{
    if (!several || !f->model.n_lobes) {
        snprintf(out, FF_FIGURE_TEXT, "%s", several ? f->expression : "mean, bars: root mean square");
        return;
    }
    snprintf(out, FF_FIGURE_TEXT, "%s, %s", ff_term_at(FF_MASKING, (size_t)f->model.lobe[0].masking)->name,
             ff_term_at(FF_NDF, (size_t)f->model.lobe[0].ndf)->name);
}

static void add_fit(const ff_fitted *f, int place, size_t style, int several, ff_figure *fig, ff_panel *p)
{
    char name[FF_FIGURE_TEXT];
    double x[FF_BANDS], y[FF_BANDS], rms[FF_BANDS];
    size_t n = 0;
    for (size_t b = 0; b < FF_BANDS; b++) {
        const ff_band *band = &f->bands.band[place][b];
        if (band->n == 0 || !isfinite(band->mean)) continue;
        x[n] = ((double)b + 0.5) * FF_BAND_DEGREES;
        y[n] = 100 * band->mean;
        rms[n++] = 100 * band->rms;
    }
    name_of(f, several, name);
    ff_series *line =
        ff_panel_series(fig, p, FF_SERIES_LINE, several ? name : "", several ? ff_style_at(style) : ff_style_model, n, 0);
    ff_series *points = ff_panel_series(fig, p, FF_SERIES_POINTS, several ? "" : name,
                                        several ? ff_style_at(style) : ff_style_model, n, several ? 0 : FF_WITH_Y_ERRORS);
    for (size_t i = 0; i < n && line && points; i++) {
        line->x[i] = points->x[i] = x[i];
        line->y[i] = points->y[i] = y[i];
        if (points->low) points->low[i] = y[i] - rms[i], points->high[i] = y[i] + rms[i];
    }
}

static ff_status build(const ff_plot_subject *s, const ff_plot_choice *c, ff_figure *fig, ff_error *err)
{
    static const char *const label[FF_PLACE_COUNT] = {"θ_{i}", "θ_{h}", "θ_{d}"};
    const ff_fit_document *d = s->document;
    size_t fit[MOST];
    const size_t n = choose(d, fit);
    (void)c;
    if (n == 0) return ff_error_set(err, FF_ERR_DATA, NULL, 0, -1, "the result says nothing of residuals by angle");
    for (int place = 0; place < FF_PLACE_COUNT; place++) {
        ff_panel *p = ff_figure_panel(fig, "");
        if (!p) break;
        ff_panel_rule_y(fig, p, "", ff_style_zero, 0);
        for (size_t k = 0; k < n; k++) add_fit(&d->fit[fit[k]], place, k, n > 1, fig, p);
        ff_axis_say(&p->x, label[place], "degrees", FF_SCALE_ANGLE, 0, 90);
        ff_axis_say(&p->y, place == 0 ? "model − data" : "", place == 0 ? "% of data" : "", FF_SCALE_LINEAR, NAN, NAN);
        p->aspect = 0.9;
    }
    fig->columns = FF_PLACE_COUNT;
    snprintf(fig->title, sizeof fig->title, "%s",
             n > 1 ? "Residuals by angle, best fit of every masking" : d->fit[fit[0]].expression);
    ff_figure_note(fig, "cos θ_{i} (model − data) over the mean of cos θ_{i} |data| in bands of %d°, all channels",
                   (int)FF_BAND_DEGREES);
    if (n == 1) ff_plot_note_failed(fig, NULL, d->fit[fit[0]].outcome);
    return FF_OK;
}

const ff_plot_kind ff_plot_residuals = {
    .name = "residuals",
    .help = "mean of model - data by incidence, half angle and difference angle, of a fit or for every masking of a comparison",
    .takes = FF_PLOT_FITS | FF_PLOT_COMPARES | FF_PLOT_RESULTS | FF_PLOT_BY_ANGLE,
    .build = build,
};
