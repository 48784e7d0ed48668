/* Figures as SVG for a page. A browser does not blur the cells of an image that says how it is to be enlarged, so that they need
 * not be enlarged here as for other viewers: a figure with images is a tenth as long. */
#include "internal_page.h"
#include "report/plot/internal_png.h"
#include "report/plot/internal_sheet.h"

#define TWO_COLUMNS    (170 * 72 / 25.4)
#define ONE_AND_A_HALF (120 * 72 / 25.4)

/* The canvas that draws everything but images, and where these go. */
typedef struct page_canvas {
    const ff_canvas *inner;
    FILE *out;
} page_canvas;

static void path(void *self, size_t n, const double *xy, int closed, const ff_pen *pen, uint32_t fill)
{
    const ff_canvas *c = ((page_canvas *)self)->inner;
    c->path(c->self, n, xy, closed, pen, fill);
}

static void dots(void *self, size_t n, const double *xy, double radius, uint32_t colour)
{
    const ff_canvas *c = ((page_canvas *)self)->inner;
    c->dots(c->self, n, xy, radius, colour);
}

static void text(void *self, const ff_text *t)
{
    const ff_canvas *c = ((page_canvas *)self)->inner;
    c->text(c->self, t);
}

static void put_attribute(FILE *out, const char *name, double x)
{
    char number[FF_POINT];
    fprintf(out, " %s=\"", name);
    fwrite(number, 1, ff_point_text(x, number), out);
    fputc('"', out);
}

static void image(void *self, const double box[4], size_t nx, size_t ny, const unsigned char *rgb)
{
    static const char *const name[] = {"x", "y", "width", "height"};
    FILE *out = ((page_canvas *)self)->out;
    fputs("<image", out);
    for (int k = 0; k < 4; k++) put_attribute(out, name[k], box[k]);
    fputs(" preserveAspectRatio=\"none\" style=\"image-rendering:pixelated\" xlink:href=\"data:image/png;base64,", out);
    ff_png_base64(nx, ny, rgb, 1, out);
    fputs("\"/>\n", out);
}

static void clip(void *self, const double box[4])
{
    const ff_canvas *c = ((page_canvas *)self)->inner;
    c->clip(c->self, box);
}

static void unclip(void *self)
{
    const ff_canvas *c = ((page_canvas *)self)->inner;
    c->unclip(c->self);
}

typedef struct drawing {
    const ff_sheet *sheet;
    FILE *out;
} drawing;

static ff_status draw(const void *context, const ff_canvas *canvas)
{
    const drawing *d = context;
    page_canvas own = {canvas, d->out};
    const ff_canvas c = {&own, path, dots, text, image, clip, unclip};
    return ff_sheet_draw(d->sheet, &c);
}

ff_status ff_page_svg(const ff_figure *fig, FILE *out, ff_error *err)
{
    ff_sheet sheet;
    ff_figure sized = *fig;
    sized.width = fig->columns > 1 && fig->n_panels > 1 ? TWO_COLUMNS : ONE_AND_A_HALF;
    ff_status status = ff_sheet_make(&sized, &sheet, err);
    if (status) return status;
    status = ff_canvas_svg(out, sheet.width, sheet.height, fig->title, draw, &(drawing){&sheet, out});
    ff_sheet_free(&sheet);
    return status;
}
