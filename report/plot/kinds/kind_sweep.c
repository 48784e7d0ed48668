/* sweep: parameters against the angle up to which is fitted, for every loss. A model that holds gives the same everywhere. */
#include "internal_fresh.h"
#include <math.h>
#include <stdlib.h>

enum { MOST = 3, STEPS = 12, FIRST_DEGREES = 30, STEP_DEGREES = 5 };

typedef struct sweep {
    const ff_plot_subject *s;
    size_t n_numbers, n_angles;
    ff_plot_number number[MOST];
    double angle[STEPS]; /* degrees */
    ff_fit_value value[FF_LOSS_COUNT][STEPS][MOST];
    int done[FF_LOSS_COUNT][STEPS];
} sweep;

/* A fit to the samples up to an angle. Too few of them, or a loss that these data have no values for, leave a gap. */
static ff_status fit_one(sweep *w, int loss, size_t k, ff_error *err)
{
    ff_fit_options o = *w->s->options;
    ff_problem *p;
    ff_fit_result fit;
    ff_error reason = {0};
    o.loss = (ff_loss)loss;
    o.max_theta = w->angle[k] * FF_DEGREE;
    o.start_shape = o.start_channel = NULL;
    ff_status status = ff_problem_make(w->s->table, w->s->model[0].model, 1, &o, &p, &reason);
    if (!status) {
        status = ff_problem_fit_into(p, w->s->model[0].model, &o, &fit, &reason);
        ff_problem_free(p);
    }
    if (status == FF_ERR_DATA || status == FF_ERR_UNSUPPORTED || status == FF_ERR_RANGE) return FF_OK;
    if (status) {
        if (err) *err = reason;
        return status;
    }
    w->done[loss][k] = fit.outcome == FF_CONVERGED;
    for (size_t i = 0; i < w->n_numbers; i++)
        w->value[loss][k][i] = *ff_fit_result_at(&fit, w->number[i].ref, w->number[i].channel);
    ff_fit_result_clear(&fit);
    return FF_OK;
}

static void add_loss(const sweep *w, int loss, size_t i, ff_figure *fig, ff_panel *p)
{
    const int middle = FF_LOSS_COUNT / 2;
    size_t n = 0;
    ff_series *line = ff_panel_series(fig, p, FF_SERIES_LINE, ff_loss_name(loss), ff_style_at((size_t)loss), w->n_angles, 0);
    ff_series *points = ff_panel_series(fig, p, FF_SERIES_POINTS, "", ff_style_at((size_t)loss), w->n_angles, FF_WITH_Y_ERRORS);
    for (size_t k = 0; k < w->n_angles && line && points; k++) {
        const ff_fit_value *v = &w->value[loss][k][i];
        if (!w->done[loss][k]) continue;
        line->x[n] = w->angle[k];
        line->y[n] = points->y[n] = v->value;
        points->x[n] = w->angle[k] + 0.3 * (loss - middle); /* beside each other, not on each other */
        points->low[n] = v->low;
        points->high[n++] = v->high;
    }
    ff_series_cut(line, n);
    ff_series_cut(points, n);
}

static ff_status run(sweep *w, ff_error *err)
{
    const double last = w->s->options->max_theta / FF_DEGREE;
    ff_status status = FF_OK;
    for (int degrees = FIRST_DEGREES; degrees < last - 0.5 && w->n_angles + 1 < STEPS; degrees += STEP_DEGREES)
        w->angle[w->n_angles++] = degrees;
    w->angle[w->n_angles++] = last;
    for (int loss = 0; loss < FF_LOSS_COUNT; loss++)
        for (size_t k = 0; k < w->n_angles && !status; k++) status = fit_one(w, loss, k, err);
    return status;
}

static void add_panels(const sweep *w, ff_figure *fig)
{
    for (size_t i = 0; i < w->n_numbers; i++) {
        char name[FF_FIGURE_TEXT];
        ff_panel *p = ff_figure_panel(fig, "");
        if (!p) break;
        for (int loss = 0; loss < FF_LOSS_COUNT; loss++) add_loss(w, loss, i, fig, p);
        ff_axis_say(&p->x, "samples up to", "degrees", FF_SCALE_ANGLE, w->angle[0] - 2.5, w->angle[w->n_angles - 1] + 2.5);
        ff_axis_say(&p->y, ff_figure_plain(w->number[i].name, name, sizeof name), w->number[i].unit, FF_SCALE_LINEAR, NAN, NAN);
        p->aspect = 0.85;
    }
    ff_plot_title(&w->s->model[0], NULL, fig->title, sizeof fig->title);
    ff_figure_note(fig, "bars: 95 %% intervals; fits that did not converge are left out");
    fig->columns = fig->n_panels;
}

static ff_status build(const ff_plot_subject *s, const ff_plot_choice *c, ff_figure *fig, ff_error *err)
{
    if (s->options->weighting == FF_WEIGHT_NOISE)
        return ff_error_set(err, FF_ERR_UNSUPPORTED, NULL, 0, -1,
                            "weights by the noise take the place of the loss: there is none to vary");
    sweep *w = calloc(1, sizeof *w);
    if (!w) return ff_error_set(err, FF_ERR_MEMORY, NULL, 0, -1, "out of memory");
    w->s = s;
    ff_status status = ff_plot_numbers(s, c, MOST, w->number, &w->n_numbers, err);
    if (!status) status = run(w, err);
    if (!status) add_panels(w, fig);
    free(w);
    return status;
}

const ff_plot_kind ff_plot_sweep = {
    .name = "sweep",
    .help = "parameters against the largest angle that is fitted, for every loss, with their intervals",
    .takes = FF_PLOT_DATA | FF_PLOT_FITS | FF_PLOT_FRESH,
    .uses = FF_PLOT_CHANNEL | FF_PLOT_PARAMETER,
    .build = build,
};
