/* bootstrap: refits as a cloud over two parameters, beside the ellipse that the standard errors draw. */
#include "internal_fresh.h"
#include <math.h>

enum { MOST = 3, CURVE = 121 };
#define WORTH_A_WORD 1.05              /* a factor that can be seen */
#define CHI2_95_OF_2 5.991464547107979 /* 95 % of a normal distribution of two dimensions lie within */

/* Of the standard errors and the correlation of both; 0 where one of them has none. */
static int add_ellipse(const ff_plot_subject *s, const ff_plot_number *a, const ff_plot_number *b, ff_figure *fig, ff_panel *p)
{
    const double sa = a->value->std_error, sb = b->value->std_error,
                 r = ff_fit_result_correlation(s->fit, a->ref, a->channel, b->ref, b->channel);
    if (!(sa > 0) || !(sb > 0) || isnan(r)) return 0;
    ff_series *e = ff_panel_series(fig, p, FF_SERIES_LINE, "95 % by standard errors", ff_style_model, CURVE, 0);
    for (size_t i = 0; i < CURVE && e; i++) {
        const double t = 360 * FF_DEGREE * (double)i / (CURVE - 1), q = sqrt(CHI2_95_OF_2);
        e->x[i] = a->value->value + q * sa * cos(t);
        e->y[i] = b->value->value + q * sb * (r * cos(t) + sqrt(fmax(1 - r * r, 0)) * sin(t));
    }
    return 1;
}

/* 0: without an ellipse. */
static int add_panel(const ff_plot_subject *s, const ff_plot_number *number, const ff_refits *refits, size_t a, size_t b,
                     ff_figure *fig)
{
    char name[FF_FIGURE_TEXT];
    ff_panel *p = ff_figure_panel(fig, "");
    ff_series *cloud =
        ff_panel_series(fig, p, FF_SERIES_POINTS, "refits", (ff_style){FF_COLOUR_BLUE, 0, FF_MARKER_DOT}, refits->n, 0);
    for (size_t i = 0; i < refits->n && cloud; i++) {
        cloud->x[i] = refits->value[i * refits->n_wanted + a];
        cloud->y[i] = refits->value[i * refits->n_wanted + b];
    }
    if (!p) return 1;
    const int has_ellipse = add_ellipse(s, &number[a], &number[b], fig, p);
    ff_series *best = ff_panel_series(fig, p, FF_SERIES_POINTS, "fit", (ff_style){FF_COLOUR_BLACK, 0, FF_MARKER_PLUS}, 1, 0);
    if (best) best->x[0] = number[a].value->value, best->y[0] = number[b].value->value;
    ff_axis_say(&p->x, ff_figure_plain(number[a].name, name, sizeof name), number[a].unit, FF_SCALE_LINEAR, NAN, NAN);
    ff_axis_say(&p->y, ff_figure_plain(number[b].name, name, sizeof name), number[b].unit, FF_SCALE_LINEAR, NAN, NAN);
    p->aspect = 0.85;
    return has_ellipse;
}

static void add_notes(const ff_refits *refits, int without, ff_figure *fig)
{
    ff_figure_note(fig, "%zu refits to %s drawn anew", refits->n, ff_grouping_name((int)refits->made.kind));
    if (refits->widened > WORTH_A_WORD)
        ff_figure_note(fig, "drawn up to %.2g times as far apart: %s", refits->widened,
                       refits->made.kind == FF_GROUP_VALUES ? "errors of neighbouring values go together"
                                                            : "groups are few, and some say more than others");
    if (refits->made.failed) ff_figure_note(fig, "%zu more did not converge", refits->made.failed);
    if (without) ff_figure_note(fig, "no ellipse where a value is on its bound: it has no standard error");
}

static ff_status build(const ff_plot_subject *s, const ff_plot_choice *c, ff_figure *fig, ff_error *err)
{
    ff_plot_number number[MOST];
    ff_param_ref ref[MOST];
    size_t channel[MOST], n;
    ff_refits refits;
    ff_status status = ff_plot_numbers(s, c, MOST, number, &n, err);
    if (status) return status;
    if (n < 2)
        return ff_error_set(err, FF_ERR_UNSUPPORTED, NULL, 0, -1, "a cloud needs two free parameters, found %s alone",
                            number[0].name);
    for (size_t k = 0; k < n; k++) ref[k] = number[k].ref, channel[k] = number[k].channel;
    status = ff_trust_refits_into(s->problem, s->places, s->options, c->repeats, c->seed, s->fit, n, ref, channel, &refits, err);
    if (status) return status;
    int without = 0;
    for (size_t a = 0; a < n; a++)
        for (size_t b = a + 1; b < n; b++) without |= !add_panel(s, number, &refits, a, b, fig);
    ff_plot_title(&s->model[0], NULL, fig->title, sizeof fig->title);
    add_notes(&refits, without, fig);
    ff_plot_note_outcome(fig, &s->model[0]);
    fig->columns = fig->n_panels;
    ff_refits_clear(&refits);
    return FF_OK;
}

const ff_plot_kind ff_plot_bootstrap = {
    .name = "bootstrap",
    .help = "refits to data drawn anew, a cloud over each pair of parameters, with the ellipse of the standard errors",
    .takes = FF_PLOT_DATA | FF_PLOT_FITS | FF_PLOT_FRESH,
    .uses = FF_PLOT_CHANNEL | FF_PLOT_PARAMETER | FF_PLOT_REFITS,
    .build = build,
};
