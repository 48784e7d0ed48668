/* Where two models differ, over incidence and view in the plane of incidence: what is measured there tells them apart. */
#include "internal_html.h"
#include <math.h>
#include <stdlib.h>

enum { INCIDENCES = 29, VIEWS = 60 }; /* cells of 3 degrees */
#define CLIP_SIGMAS   10.0
#define CLIP_RELATIVE 0.5

static ff_status evaluate(const ff_html_subject *s, size_t fit, size_t c, const ff_directions *d, double *out, ff_error *err)
{
    const ff_plot_model *m = &s->model[fit];
    return ff_plot_evaluate(m, s->isa, c < m->n_channels ? c : 0, &d->w, d->n, out, NULL, NULL, err);
}

static void set_directions(ff_directions *d)
{
    for (size_t k = 0; k < d->n; k++) {
        const size_t row = k / VIEWS, column = k % VIEWS;
        const double ti = (3 * (double)row + 1.5) * FF_DEGREE, to = (3 * (double)column - 88.5) * FF_DEGREE;
        ff_directions_set(d, k, ti, 0, to, 180 * FF_DEGREE);
    }
}

/* In standard deviations of one sample by the noise of a, else relative to it. */
static void compare(const ff_html_subject *s, size_t a, size_t c, const ff_directions *d, const double *fa, const double *fb,
                    double *z)
{
    const ff_noise *noise = s->model[a].noise;
    for (size_t k = 0; k < d->n; k++) {
        const double sd = noise ? ff_noise_sd(noise, c, fa[k], d->plane[2][k], d->plane[5][k]) : fa[k];
        z[k] = sd > 0 ? (fb[k] - fa[k]) / sd : NAN;
    }
}

ff_status ff_html_differ(const ff_html_subject *s, size_t a, size_t b, ff_figure *fig, ff_error *err)
{
    const size_t c = s->model[a].n_channels / 2;
    ff_panel *p = ff_figure_panel(fig, "");
    ff_series *image = ff_panel_image(fig, p, "difference", VIEWS, INCIDENCES);
    ff_directions d;
    if (!image) return FF_OK;
    ff_status status = ff_directions_new((size_t)VIEWS * INCIDENCES, &d);
    if (status) return status;
    double *fa = malloc(2 * d.n * sizeof *fa), *fb = fa + d.n;
    set_directions(&d);
    status = fa ? evaluate(s, a, c, &d, fa, err) : FF_ERR_MEMORY;
    if (!status) status = evaluate(s, b, c, &d, fb, err);
    if (!status) compare(s, a, c, &d, fa, fb, image->image.z);
    free(fa);
    ff_directions_free(&d);
    if (status) return status;
    const int by_noise = s->model[a].noise != NULL;
    ff_axis_say(&p->x, "θ_{o}", "degrees", FF_SCALE_ANGLE, -90, 90);
    ff_axis_say(&p->y, "θ_{i}", "degrees", FF_SCALE_ANGLE, 0, 87);
    ff_axis_say(&p->z, by_noise ? "(B − A) / σ" : "(B − A) / A", "1", FF_SCALE_LINEAR, NAN, NAN);
    image->image.x_lo = -90, image->image.x_hi = 90, image->image.y_lo = 0, image->image.y_hi = 87;
    image->image.map = FF_MAP_DIVERGING;
    image->image.clip = by_noise ? CLIP_SIGMAS : CLIP_RELATIVE;
    p->aspect = 0.5;
    ff_figure_note(fig, "A: %s, B: %s", s->model[a].label, s->model[b].label);
    ff_figure_note(fig,
                   by_noise ? "σ: standard deviation of one sample by the noise of A; colours end at ±%g"
                            : "relative to A, whose noise is not known; colours end at ±%g",
                   image->image.clip);
    return FF_OK;
}
