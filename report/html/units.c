/* Parameters in the units of renderers: the values of a fit and the ends of their intervals, by the conversions of `convert`. All
 * of these are monotonic, so that an interval stays one. */
#include "ff_convert.h"
#include "internal_html.h"
#include "models/internal_model.h"
#include <math.h>
#include <string.h>

enum { ROWS = 24 };

/* A parameter of a term, the convention whose number it is, and what it is in another. */
typedef struct unit {
    ff_term_kind kind;
    const char *term, *parameters, *from, *to, *by, *label;
} unit;

/* One after the other where the label is the same: a panel. */
static const unit units[] = {
    {FF_NDF, " ggx ", " alpha alpha_x alpha_y ", "ggx", "roughness", NULL, "perceptual roughness"},
    {FF_NDF, " beckmann beckmann-walter ", " alpha alpha_x alpha_y ", "beckmann", "roughness", "peak", "perceptual roughness"},
    {FF_NDF, " phong phong-walter ", " n ", "phong", "roughness", "peak", "perceptual roughness"},
    {FF_NDF, " ggx ", " alpha alpha_x alpha_y ", "ggx", "phong", "peak", "exponent of Phong"},
    {FF_NDF, " beckmann beckmann-walter ", " alpha alpha_x alpha_y ", "beckmann", "phong", NULL, "exponent of Phong"},
    {FF_NDF, " phong phong-walter ", " n ", "phong", "beckmann", NULL, "m of Beckmann"},
    {FF_FRESNEL, " schlick ", " f0 ", "f0", "eta", NULL, "index of refraction"},
    {FF_FRESNEL, " dielectric ", " eta ", "eta", "f0", NULL, "F0"}};
enum { UNITS = sizeof units / sizeof *units };

static int is_word(const char *words, const char *word)
{
    char spaced[64];
    snprintf(spaced, sizeof spaced, " %s ", word);
    return strstr(words, spaced) != NULL;
}

/* Is p such a parameter of m? */
static int is_of(const unit *u, const ff_model *m, const ff_model_param *p)
{
    if (p->lobe >= m->n_lobes || !is_word(u->parameters, p->info->name)) return 0;
    const ff_lobe *lobe = &m->lobe[p->lobe];
    return is_word(u->term, u->kind == FF_NDF ? ff_ndf_at(lobe->ndf)->term.name
                                              : ff_fresnel_at(m->lobe[ff_model_group(m, p->lobe)].fresnel)->term.name);
}

/* NaN where it has none: no number, or outside of the conversion. */
static double converted(const ff_conversion_path *path, double x)
{
    double out[FF_CONVERSION_VALUES];
    const double in[FF_CONVERSION_VALUES] = {x};
    return isfinite(x) && ff_conversion_follow(path, in, 0, out, NULL, NULL) == FF_OK ? out[0] : NAN;
}

/* Numbers of a panel, and their names. */
typedef struct rows {
    size_t n;
    char name[ROWS][FF_REPORT_NAME];
    double value[ROWS], low[ROWS], high[ROWS];
} rows;

static void add_row(rows *r, const ff_conversion_path *path, const char *name, const ff_fit_value *v)
{
    if (r->n == ROWS || v->held || v->tied) return;
    const double x = converted(path, v->value), a = converted(path, v->low), b = converted(path, v->high);
    if (!isfinite(x)) return;
    r->value[r->n] = x;
    r->low[r->n] = a < b ? a : b;
    r->high[r->n] = a < b ? b : a;
    snprintf(r->name[r->n++], FF_REPORT_NAME, "%s", name);
}

static void add_unit(const ff_html_subject *s, const unit *u, const ff_conversion_path *path, rows *r)
{
    const ff_fit_result *f = &s->r->fit[s->shown];
    const ff_model *m = &f->model;
    char name[FF_REPORT_NAME];
    for (uint32_t k = 0; k < m->n_shape; k++)
        if (is_of(u, m, &m->shape[k])) add_row(r, path, m->shape[k].name, &f->shape_value[k]);
    for (uint32_t k = 0; k < m->n_channel; k++)
        for (size_t c = 0; c < f->n_channels && is_of(u, m, &m->channel[k]); c++)
            add_row(r, path, ff_report_channel_param(s->r->problem[s->shown / s->models], f, k, c, name),
                    &f->channel_value[c * m->n_channel + k]);
}

static void add_panel(ff_figure *fig, const char *label, const rows *r)
{
    ff_panel *p = ff_figure_panel(fig, "");
    ff_series *s = p ? ff_panel_series(fig, p, FF_SERIES_POINTS, "", ff_style_data, r->n, FF_WITH_X_ERRORS) : NULL;
    if (!s) return;
    ff_axis_say(&p->x, label, "1", FF_SCALE_LINEAR, NAN, NAN);
    ff_axis_names(fig, &p->y, r->n);
    for (size_t k = 0; k < r->n; k++) {
        char plain[FF_AXIS_NAME];
        s->x[k] = r->value[k];
        s->x_low[k] = r->low[k];
        s->x_high[k] = r->high[k];
        s->y[k] = (double)k;
        ff_axis_name(&p->y, k, ff_figure_plain(r->name[k], plain, sizeof plain));
    }
}

/* How the rows of a unit came about. */
static void add_words(const unit *u, const ff_conversion_path *path, char *out, size_t room)
{
    size_t n = strlen(out);
    n += (size_t)snprintf(out + n, room - n, "%s%s: ", n ? " " : "", u->label);
    for (size_t k = 0; k < path->n && n < room; k++)
        n += (size_t)snprintf(out + n, room - n, "%s%s (%s)", k ? ", then " : "", path->step[k]->formula, path->step[k]->source);
    for (size_t k = 0; k < path->n && n < room; k++)
        if (path->step[k]->matches) n += (size_t)snprintf(out + n, room - n, "; assumes %s", path->step[k]->assumes);
    if (n + 1 < room) memcpy(out + n, ".", 2);
}

void ff_html_units(ff_page *p, const ff_html_subject *s)
{
    char words[FF_WORDS_SENTENCE] = "", caption[FF_MODEL_NAME + 128];
    ff_figure fig;
    rows r;
    ff_figure_init(&fig);
    for (size_t k = 0; k < UNITS; k++) {
        ff_conversion_path path;
        if (k == 0 || strcmp(units[k].label, units[k - 1].label) != 0) r.n = 0;
        const size_t before = r.n;
        if (ff_conversion_paths(units[k].from, units[k].to, units[k].by, 1, &path)) add_unit(s, &units[k], &path, &r);
        if (r.n > before) add_words(&units[k], &path, words, sizeof words);
        if (r.n && (k + 1 == UNITS || strcmp(units[k].label, units[k + 1].label) != 0)) add_panel(&fig, units[k].label, &r);
    }
    if (fig.n_panels == 0 && !fig.status) {
        ff_figure_clear(&fig);
        return;
    }
    fig.columns = fig.n_panels < 2 ? 1 : 2;
    snprintf(caption, sizeof caption, "The same in the units of renderers, with their 95 %% intervals: %s",
             s->model[s->shown].label);
    ff_page_figure(p, "units", caption, &fig, FF_OK, NULL, 1);
    if (!p->status) {
        ff_page_format(p, "<div class=\"note\" id=\"units-by\">");
        ff_page_note(p, "%s", words);
        ff_page_format(p, "</div>\n");
    }
}
