/* Lit spheres: a picture for readers without script, and what the script needs to light the data from elsewhere.
 *
 * Of an isotropic table that is its interpolation over theta_h, theta_d and phi_d (Rusinkiewicz 1998), phi_d over half a turn,
 * since light and view may be exchanged; theta_h in steps that grow with it, as peaks want it. */
#include "ff_interpolate.h"
#include "ff_render.h"
#include "ff_spectral.h"
#include "internal_html.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { HALF = 32, DIFFERENCE = 16, AZIMUTHS = 12, NODES = HALF * DIFFERENCE * AZIMUTHS, PIXELS = 128, PIXELS_OF_REGRESSION = 48 };

/* Which channels of the page make the colour, all three of them, or the one that is grey. */
static size_t choose_channels(const ff_html_subject *s, size_t out[3])
{
    const int all = s->n_channels == 3 && !s->skipped && s->r->table->n_channels == 3;
    for (size_t c = 0; c < 3; c++) out[c] = all ? c : s->n_channels / 2;
    return all ? 3 : 1;
}

/* ---- the data as a table over half and difference angle --------------------------------------------------------------------- */

static double half_angle(size_t k)
{
    return 90 * FF_DEGREE * pow((double)k / HALF, 2);
}

/* h in the plane phi = 0, the difference turned about it by phi_d. */
static void set_node(size_t at, double *const w[6], size_t i)
{
    const double th = half_angle(at / (DIFFERENCE * AZIMUTHS)),
                 td = 90 * FF_DEGREE * (double)(at / AZIMUTHS % DIFFERENCE) / DIFFERENCE,
                 pd = 180 * FF_DEGREE * (double)(at % AZIMUTHS) / AZIMUTHS;
    for (int side = 0; side < 2; side++) {
        const double x = (side ? -1 : 1) * sin(td) * cos(pd), y = (side ? -1 : 1) * sin(td) * sin(pd), z = cos(td);
        w[3 * side][i] = x * cos(th) + z * sin(th);
        w[3 * side + 1][i] = y;
        w[3 * side + 2][i] = z * cos(th) - x * sin(th);
    }
}

static double node_value(const ff_html_subject *s, size_t channel, const double *value, size_t n, size_t i)
{
    const int c = s->channel[channel].of_table;
    double sum = 0;
    if (c >= 0) return value[(size_t)c * n + i];
    for (size_t k = 0; k < s->r->table->n_channels; k++) sum += value[k * n + i];
    return sum / (double)s->r->table->n_channels;
}

/* out [n][NODES]; NaN below the horizon. */
static ff_status interpolate(const ff_html_subject *s, size_t n, const size_t *channel, double *out)
{
    enum { SLAB = 128 };
    ff_interpolant *p;
    ff_error unsaid = {0};
    ff_status status = ff_interpolant_new(s->r->table, 0, &p, &unsaid);
    if (status) return status;
    double *memory = malloc((6 + s->r->table->n_channels) * SLAB * sizeof *memory);
    unsigned char found[SLAB];
    for (size_t first = 0; first < NODES && memory; first += SLAB) {
        double *const w[6] = {memory, memory + SLAB, memory + 2 * SLAB, memory + 3 * SLAB, memory + 4 * SLAB, memory + 5 * SLAB};
        for (size_t i = 0; i < SLAB; i++) set_node(first + i, w, i);
        ff_interpolant_eval_reciprocal(p, (const double *const *)w, SLAB, memory + 6 * SLAB, found);
        for (size_t c = 0; c < n; c++)
            for (size_t i = 0; i < SLAB; i++)
                out[c * NODES + first + i] =
                    found[i] == FF_FOUND_BELOW ? NAN : node_value(s, channel[c], memory + 6 * SLAB, SLAB, i);
    }
    ff_interpolant_free(p);
    status = memory ? FF_OK : FF_ERR_MEMORY;
    free(memory);
    return status;
}

ff_status ff_html_sphere_json(ff_json *j, const ff_html_subject *s)
{
    _Static_assert(NODES % 128 == 0, "whole slabs");
    size_t channel[3];
    const size_t n = choose_channels(s, channel);
    ff_json_object(j, "sphere", FF_JSON_LINE);
    ff_json_array(j, "channels", FF_JSON_LINE);
    for (size_t c = 0; c < n; c++) ff_json_integer(j, NULL, (int64_t)channel[c]);
    ff_json_close(j);
    double colours[9];
    ff_status status = n == 3 ? ff_spectral_colours(n, s->r->table->channels, colours, NULL) : FF_OK;
    if (n == 3 && !status) { /* rows: red, green and blue of the three */
        ff_json_array(j, "colours", FF_JSON_LINE);
        for (size_t k = 0; k < 9; k++) ff_json_number(j, NULL, colours[k]);
        ff_json_close(j);
    }
    if (s->r->table->isotropic && !status) {
        double *value = malloc(3 * (size_t)NODES * sizeof *value);
        status = value ? interpolate(s, n, channel, value) : FF_ERR_MEMORY;
        if (!status) {
            ff_json_integer(j, "theta_h", HALF);
            ff_json_integer(j, "theta_d", DIFFERENCE);
            ff_json_integer(j, "phi_d", AZIMUTHS);
            ff_json_array(j, "values", FF_JSON_LINE);
            for (size_t c = 0; c < n; c++) ff_page_numbers(j, NULL, NODES, value + c * NODES, 1, 4);
            ff_json_close(j);
        }
        free(value);
        if (status != FF_ERR_MEMORY) status = FF_OK;
    }
    ff_json_close(j);
    return status;
}

/* ---- the picture ------------------------------------------------------------------------------------------------------------ */

/* Data, one model or two, and a difference: of the model to the data, or of the second model to the first. */
typedef struct pictures {
    size_t pixels, n_models;
    float *rgba[4];
    unsigned char *png;
    size_t n;
} pictures;

static ff_status draw_models(const ff_html_subject *s, const ff_render_options *o, pictures *p, ff_error *err)
{
    ff_status status = FF_OK;
    for (size_t k = 0; k < p->n_models && !status; k++) {
        const ff_plot_model *m = &s->model[k ? s->rival : s->shown];
        status = ff_render_model(m->model, m->n_channels, m->shape, m->channel, o, p->rgba[1 + k], NULL, err);
    }
    return status;
}

static ff_status write_png(pictures *p, ff_error *err)
{
    ff_render_cell cell[4];
    ff_render_sheet sheet;
    for (size_t k = 0; k <= p->n_models; k++) cell[k] = (ff_render_cell){p->rgba[k], NULL, FF_CELL_PICTURE};
    cell[p->n_models + 1] = (ff_render_cell){p->rgba[p->n_models + 1], NULL, FF_CELL_DIFFERENCE};
    ff_render_sheet_init(&sheet);
    sheet.pixels = p->pixels;
    sheet.n = p->n_models + 2;
    sheet.cell = cell;
    sheet.background = FF_BACKGROUND_TRANSPARENT;
    return ff_render_png(&sheet, &p->png, &p->n, err);
}

/* Of a table with one or three channels that were fitted together. */
static ff_status render(const ff_html_subject *s, pictures *p, ff_error *err)
{
    static const double light[1][3] = {{-0.5, 0.5, 0.70710678118654752}}; /* 45 degrees from the view, up to the left */
    const ff_plot_model *m = &s->model[s->shown];
    const float *less = p->rgba[p->n_models - 1], *from = p->rgba[p->n_models];
    ff_render_options o;
    ff_render_options_init(&o);
    o.pixels = p->pixels;
    o.n_lights = 1;
    o.light = light;
    o.threads = s->r->options->threads;
    o.isa = s->isa;
    double colours[9];
    ff_status status = FF_OK;
    if (m->n_channels == 3) {
        status = ff_spectral_colours(3, s->r->table->channels, colours, err);
        o.colours = colours;
    }
    if (!status) status = draw_models(s, &o, p, err);
    if (!status) status = ff_render_table(s->r->table, m->model, m->n_channels, m->shape, m->channel, &o, p->rgba[0], NULL, err);
    if (status) return status;
    for (size_t k = 0; k < 4 * p->pixels * p->pixels; k++) p->rgba[p->n_models + 1][k] = k % 4 == 3 ? less[k] : from[k] - less[k];
    return write_png(p, err);
}

static void put_base64(const unsigned char *bytes, size_t n, FILE *out)
{
    static const char digit[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    for (size_t i = 0; i < n; i += 3) {
        const unsigned more =
            (unsigned)bytes[i] << 16 | (i + 1 < n ? (unsigned)bytes[i + 1] << 8 : 0u) | (i + 2 < n ? bytes[i + 2] : 0u);
        fputc(digit[more >> 18], out);
        fputc(digit[more >> 12 & 63], out);
        fputc(i + 1 < n ? digit[more >> 6 & 63] : '=', out);
        fputc(i + 2 < n ? digit[more & 63] : '=', out);
    }
}

static ff_status make(const ff_html_subject *s, pictures *p, ff_error *err)
{
    ff_interpolant *of;
    if (s->r->n_problems > 1 || s->model[s->shown].n_channels != s->r->table->n_channels)
        return ff_error_set(err, FF_ERR_UNSUPPORTED, NULL, 0, -1, "the channels were not fitted as they are in the file");
    if (s->r->table->n_channels != 1 && s->r->table->n_channels != 3)
        return ff_error_set(err, FF_ERR_UNSUPPORTED, NULL, 0, -1, "a picture has one channel or three, these data have %zu",
                            s->r->table->n_channels);
    ff_status status = ff_interpolant_new(s->r->table, 0, &of, err);
    if (status) return status;
    p->pixels = ff_interpolant_regresses(of) ? PIXELS_OF_REGRESSION : PIXELS;
    ff_interpolant_free(of);
    p->n_models = s->models > 1 ? 2 : 1;
    for (size_t k = 0; k < p->n_models + 2; k++) {
        p->rgba[k] = malloc(4 * p->pixels * p->pixels * sizeof *p->rgba[k]);
        if (!p->rgba[k]) return FF_ERR_MEMORY;
    }
    return render(s, p, err);
}

void ff_html_spheres(ff_page *p, const ff_html_subject *s)
{
    const char *const said = s->models > 1 ? "data, A, B, and B less A" : "data, model, and model less data";
    pictures made = {.pixels = PIXELS};
    ff_error reason = {0};
    if (p->status) return;
    ff_page_section(p, "spheres", "Lit spheres");
    const ff_status status = make(s, &made, &reason);
    if (status == FF_ERR_MEMORY) ff_page_fail(p, status);
    ff_page_format(p, "<figure id=\"sphere-pictures\">\n<div class=\"drawn\">");
    if (!status) {
        ff_page_format(p,
                       "<img width=\"%zu\" style=\"image-rendering:auto\" alt=\"Spheres lit from up to the left: %s\" "
                       "src=\"data:image/png;base64,",
                       200 * (made.n_models + 2), said);
        put_base64(made.png, made.n, p->out);
        ff_page_format(p, "\">");
    } else {
        ff_page_note(p, "Not drawn: %s.", reason.message[0] ? reason.message : ff_status_str(status));
    }
    ff_page_format(p,
                   "</div>\n<figcaption>Spheres: %s. Light of irradiance π from 45° up to the left; the difference is blue where "
                   "%s is too dark</figcaption></figure>\n",
                   said, s->models > 1 ? "B" : "the model");
    ff_page_section_end(p);
    for (int k = 0; k < 4; k++) free(made.rgba[k]);
    ff_render_png_free(made.png);
}
