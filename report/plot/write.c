/* A figure as a file: SVG, PDF, or its numbers. */
#include "internal_sheet.h"
#include "report/internal_text.h"
#include <math.h>
#include <string.h>

/* Widths that journals have, in points. */
#define TWO_COLUMNS    (170 * 72 / 25.4)
#define ONE_AND_A_HALF (120 * 72 / 25.4)
#define PANEL          17 /* width of a panel in sizes of the font, at least */

const char *ff_figure_form_name(int form)
{
    static const char *const names[FF_FIGURE_FORMS] = {"svg", "pdf", "csv"};
    return form >= 0 && form < FF_FIGURE_FORMS ? names[form] : NULL;
}

int ff_figure_form_find(const char *path)
{
    const char *dot = strrchr(path, '.');
    for (int form = 0; dot && form < FF_FIGURE_FORMS; form++) {
        const char *name = ff_figure_form_name(form);
        size_t k = 0;
        while (name[k] && (dot[1 + k] | 0x20) == name[k]) k++;
        if (!name[k] && !dot[1 + k]) return form;
    }
    return -1;
}

static double width_of(const ff_figure *fig)
{
    return fig->width > 0 ? fig->width : fig->columns > 1 && fig->n_panels > 1 ? TWO_COLUMNS : ONE_AND_A_HALF;
}

void ff_figure_narrow(ff_figure *fig)
{
    fig->width = width_of(fig);
    while (fig->columns > 1 && fig->width < PANEL * fig->font * (double)fig->columns) fig->columns--;
}

/* ---- numbers --------------------------------------------------------------------------------- */

static void put_text(const char *text, FILE *out)
{
    if (!strpbrk(text, ",\"\r\n")) {
        fputs(text, out);
        return;
    }
    fputc('"', out);
    for (; *text; text++) {
        if (*text == '"') fputc('"', out);
        fputc(*text, out);
    }
    fputc('"', out);
}

static void put_number(const double *x, size_t i, FILE *out)
{
    char text[FF_TEXT_NUMBER];
    fputc(',', out);
    if (x && !isnan(x[i])) fputs(ff_text_exact(x[i], text), out);
}

/* A number, or the name in its place. */
static void put_place(const ff_axis *a, const double *x, size_t i, FILE *out)
{
    const size_t k = x && x[i] >= 0 ? (size_t)(x[i] + 0.5) : a->n_names;
    if (a->scale != FF_SCALE_NAMES || k >= a->n_names) {
        put_number(x, i, out);
        return;
    }
    char whole[2 * FF_AXIS_NAME];
    snprintf(whole, sizeof whole, "%s%s", a->name[k], a->ending);
    fputc(',', out);
    put_text(whole, out);
}

static void put_head(const ff_figure *fig, size_t panel, const ff_series *s, FILE *out)
{
    fprintf(out, "%zu,", panel + 1);
    put_text(fig->panel[panel]->title, out);
    fputc(',', out);
    put_text(s->name, out);
    fprintf(out, ",%s", ff_series_kind_name((int)s->kind));
}

static void put_image(const ff_figure *fig, size_t panel, const ff_series *s, FILE *out)
{
    const ff_panel *p = fig->panel[panel];
    const ff_image *im = &s->image;
    const double dx = (im->x_hi - im->x_lo) / (double)im->nx, dy = (im->y_hi - im->y_lo) / (double)im->ny;
    for (size_t i = 0; i < im->nx * im->ny; i++) {
        const size_t row = i / im->nx;
        const double x = im->x_lo + ((double)(i % im->nx) + 0.5) * dx, y = im->y_lo + ((double)row + 0.5) * dy;
        put_head(fig, panel, s, out);
        put_place(&p->x, &x, 0, out);
        put_place(&p->y, &y, 0, out);
        fputs(",,,,", out);
        put_number(im->z, i, out);
        fputc('\n', out);
    }
}

ff_status ff_figure_csv(const ff_figure *fig, FILE *out)
{
    fputs("panel,title,series,kind,x,y,low,high,x_low,x_high,z\n", out);
    for (size_t i = 0; i < fig->n_panels; i++) {
        const ff_panel *p = fig->panel[i];
        for (size_t k = 0; k < p->n_series; k++) {
            const ff_series *s = p->series[k];
            if (s->kind == FF_SERIES_IMAGE) put_image(fig, i, s, out);
            for (size_t j = 0; j < s->n; j++) {
                put_head(fig, i, s, out);
                put_place(&p->x, s->x, j, out);
                put_place(&p->y, s->y, j, out);
                put_number(s->low, j, out);
                put_number(s->high, j, out);
                put_number(s->x_low, j, out);
                put_number(s->x_high, j, out);
                fputs(",\n", out);
            }
        }
    }
    return FF_OK;
}

ff_status ff_figure_write(const ff_figure *fig, ff_figure_form form, FILE *out, ff_error *err)
{
    ff_sheet sheet;
    ff_figure sized = *fig;
    if (fig->status) return fig->status;
    if (form == FF_FIGURE_CSV) return ff_figure_csv(fig, out);
    sized.width = width_of(fig);
    ff_status status = ff_sheet_make(&sized, &sheet, err);
    if (status) return status;
    status =
        (form == FF_FIGURE_PDF ? ff_canvas_pdf : ff_canvas_svg)(out, sheet.width, sheet.height, fig->title, ff_sheet_draw, &sheet);
    ff_sheet_free(&sheet);
    return status;
}
