/* likelihood: the least objective for every value of a parameter, and where its 95 % interval ends. */
#include "internal_fresh.h"
#include <math.h>

enum { POINTS = 25, MOST = 6 };

static ff_status add_panel(const ff_plot_subject *s, const ff_plot_number *number, ff_figure *fig, ff_error *err)
{
    static const ff_style interval = {FF_COLOUR_BLUE, FF_DASH_LONG, FF_MARKER_DOT};
    ff_curve curve;
    char name[FF_FIGURE_TEXT];
    const ff_status status = ff_trust_curve_into(s->problem, s->options, s->fit, number->ref, number->channel, POINTS, &curve, err);
    if (status) return status;
    ff_panel *p = ff_figure_panel(fig, "");
    ff_series *line = ff_panel_series(fig, p, FF_SERIES_LINE, "least objective of all others", ff_style_model, curve.n, 0);
    for (size_t i = 0; i < curve.n && line; i++) {
        line->x[i] = curve.value[i];
        line->y[i] = curve.objective[i];
    }
    if (p) {
        ff_panel_rule_y(fig, p, "rise that 95 % allow", ff_style_mark, curve.limit);
        ff_panel_rule_x(fig, p, "95 % interval", interval, curve.low);
        ff_panel_rule_x(fig, p, "95 % interval", interval, curve.high);
        ff_series *best = ff_panel_series(fig, p, FF_SERIES_POINTS, "fit", ff_style_data, 1, 0);
        if (best) best->x[0] = curve.best, best->y[0] = s->fit->residual.objective;
        ff_axis_say(&p->x, ff_figure_plain(number->name, name, sizeof name), number->unit, FF_SCALE_LINEAR, NAN, NAN);
        ff_axis_say(&p->y, "objective", "1", FF_SCALE_LINEAR, NAN, NAN);
        p->aspect = 0.75;
    }
    ff_curve_clear(&curve);
    return FF_OK;
}

static ff_status build(const ff_plot_subject *s, const ff_plot_choice *c, ff_figure *fig, ff_error *err)
{
    ff_plot_number number[MOST];
    size_t n;
    ff_status status = ff_plot_numbers(s, c, MOST, number, &n, err);
    for (size_t k = 0; k < n && !status; k++) status = add_panel(s, &number[k], fig, err);
    if (status) return status;
    ff_plot_title(&s->model[0], NULL, fig->title, sizeof fig->title);
    ff_plot_note_outcome(fig, &s->model[0]);
    fig->columns = n < 3 ? n : 3;
    return FF_OK;
}

const ff_plot_kind ff_plot_likelihood = {
    .name = "likelihood",
    .help = "profiles of the objective: its least value for every value of a parameter, with the 95 % interval",
    .takes = FF_PLOT_DATA | FF_PLOT_FITS | FF_PLOT_FRESH,
    .uses = FF_PLOT_CHANNEL | FF_PLOT_PARAMETER,
    .build = build,
};
