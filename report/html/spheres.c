/* Lit spheres: a picture for readers without script, and what the script needs to light the data from elsewhere.
 *
 * That is the table's interpolation over theta_h, theta_d and phi_d (Rusinkiewicz 1998), or over the half vector's x and y, theta_d
 * and phi_d + phi_h where the table knows a direction of the surface. Azimuths are over half a turn, since light and view may be
 * exchanged; half vectors are close to each other about the normal, as peaks want it. */
#include "ff_interpolate.h"
#include "ff_render.h"
#include "ff_spectral.h"
#include "internal_html.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { PIXELS = 128, PIXELS_OF_REGRESSION = 48, SLAB = 128 };

/* Nodes. Of an isotropic table those of theta_h, theta_d, phi_d; else side x side half vectors, and phi_d + phi_h, which does not
 * jump where the half vector passes the normal. */
typedef struct grid {
    size_t half, difference, azimuths, side;
} grid;

static grid grid_of(const ff_html_subject *s, size_t n_channels)
{
    if (s->r->table->isotropic) return (grid){32, 16, 12, 0};
    const size_t side = n_channels == 1 ? 31 : 25;
    return (grid){side * side, 8, 6, side};
}

static size_t nodes_of(const grid *g)
{
    return g->half * g->difference * g->azimuths;
}

/* Which channels of the page make the colour, all three of them, or the one that is grey. */
static size_t choose_channels(const ff_html_subject *s, size_t out[3])
{
    const int all = s->n_channels == 3 && !s->skipped && s->r->table->n_channels == 3;
    for (size_t c = 0; c < 3; c++) out[c] = all ? c : s->n_channels / 2;
    return all ? 3 : 1;
}

/* ---- the data as a table over half and difference angle --------------------------------------------------------------------- */

/* Sine and cosine of an angle. */
typedef struct turn {
    double s, c;
} turn;

static turn turn_of(double angle)
{
    return (turn){sin(angle), cos(angle)};
}

/* -1 to 1, close to each other about 0, as peaks want it. */
static double side_place(const grid *g, size_t k)
{
    const size_t middle = g->side / 2;
    const double x = ((double)k - (double)middle) / (double)middle;
    return x * fabs(x);
}

/* Half vector, its azimuth and phi_d at a node; 0 where there is none. */
static int half_of(const grid *g, size_t at, turn *th, turn *ph, turn *pd)
{
    const size_t k = at / (g->difference * g->azimuths);
    const double psi = 180 * FF_DEGREE * (double)(at % g->azimuths) / (double)g->azimuths;
    if (g->side == 0) {
        const double share = (double)k / (double)g->half;
        *th = turn_of(90 * FF_DEGREE * share * share);
        *ph = turn_of(0);
        *pd = turn_of(psi);
        return 1;
    }
    const double x = side_place(g, k / g->side), y = side_place(g, k % g->side), r2 = x * x + y * y;
    if (!(r2 < 1)) return 0;
    const double azimuth = r2 > 0 ? atan2(y, x) : 0;
    *th = (turn){sqrt(r2), sqrt(1 - r2)};
    *ph = turn_of(azimuth);
    *pd = turn_of(psi - azimuth);
    return 1;
}

/* The difference turned about h by phi_d from the plane of h; below the horizon where there is no node. */
static void set_node(const grid *g, size_t at, double *const w[6], size_t i)
{
    const turn td = turn_of(90 * FF_DEGREE * (double)(at / g->azimuths % g->difference) / (double)g->difference);
    turn th, ph, pd;
    if (!half_of(g, at, &th, &ph, &pd)) {
        for (int k = 0; k < 6; k++) w[k][i] = k % 3 == 2 ? -1 : 0;
        return;
    }
    for (int side = 0; side < 2; side++) {
        const double sign = side ? -1 : 1, u = sign * td.s * pd.c, y = sign * td.s * pd.s, v = td.c;
        const double x = u * th.c + v * th.s;
        w[3 * side][i] = x * ph.c - y * ph.s;
        w[3 * side + 1][i] = x * ph.s + y * ph.c;
        w[3 * side + 2][i] = v * th.c - u * th.s;
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

/* out [n][nodes]; NaN below the horizon. */
static ff_status interpolate(const ff_html_subject *s, const grid *g, size_t n, const size_t *channel, double *out)
{
    const size_t nodes = nodes_of(g);
    ff_interpolant *p;
    ff_error unsaid = {0};
    ff_status status = ff_interpolant_new(s->r->table, 0, &p, &unsaid);
    if (status) return status;
    double *memory = malloc((6 + s->r->table->n_channels) * SLAB * sizeof *memory);
    unsigned char found[SLAB];
    for (size_t first = 0; first < nodes && memory; first += SLAB) {
        const size_t m = nodes - first < SLAB ? nodes - first : SLAB;
        double *const w[6] = {memory, memory + SLAB, memory + 2 * SLAB, memory + 3 * SLAB, memory + 4 * SLAB, memory + 5 * SLAB};
        double *value = memory + 6 * SLAB;
        for (size_t i = 0; i < m; i++) set_node(g, first + i, w, i);
        ff_interpolant_eval_reciprocal(p, (const double *const *)w, m, value, found);
        for (size_t c = 0; c < n; c++)
            for (size_t i = 0; i < m; i++)
                out[c * nodes + first + i] = found[i] == FF_FOUND_BELOW ? NAN : node_value(s, channel[c], value, m, i);
    }
    ff_interpolant_free(p);
    status = memory ? FF_OK : FF_ERR_MEMORY;
    free(memory);
    return status;
}

/* ---- values in 16 bits ------------------------------------------------------------------------------------------------------ */

/* A sign and 15 bits of a logarithm: of m from 1 to LARGEST the size is
 * top e^(-SPAN (LARGEST - m) / (LARGEST - 1)), off by 3e-4 of itself; m = 0 is 0, or with the sign unknown. SPAN: what is smaller
 * than 1e-9 of the top is 0. */
#define SPAN 20.723265836946411
enum { LARGEST = 0x7fff, NEGATIVE = 0x8000 };

static unsigned code_of(double x, double top)
{
    if (!isfinite(x)) return NEGATIVE;
    const double m = LARGEST + (LARGEST - 1) / SPAN * log(fabs(x) / top);
    return m < 1 || x == 0 ? 0 : (x < 0 ? NEGATIVE : 0u) | (unsigned)lround(m < LARGEST ? m : LARGEST);
}

static size_t base64_length(size_t n)
{
    return (n + 2) / 3 * 4;
}

/* out [base64_length(n)] */
static void to_base64(const unsigned char *bytes, size_t n, char *out)
{
    static const char digit[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    for (size_t i = 0; i < n; i += 3) {
        const unsigned more =
            (unsigned)bytes[i] << 16 | (i + 1 < n ? (unsigned)bytes[i + 1] << 8 : 0u) | (i + 2 < n ? bytes[i + 2] : 0u);
        *out++ = digit[more >> 18];
        *out++ = digit[more >> 12 & 63];
        *out++ = i + 1 < n ? digit[more >> 6 & 63] : '=';
        *out++ = i + 2 < n ? digit[more & 63] : '=';
    }
}

/* {"top": ..., "codes": base64 of 16 bits each, the higher 8 first} */
static ff_status put_codes(ff_json *j, size_t n, const double *x)
{
    double top = 0;
    unsigned char *bytes = malloc(2 * n);
    char *text = calloc(1, base64_length(2 * n) + 1);
    const ff_status status = bytes && text ? FF_OK : FF_ERR_MEMORY;
    for (size_t i = 0; i < n; i++) top = isfinite(x[i]) && fabs(x[i]) > top ? fabs(x[i]) : top;
    for (size_t i = 0; i < n && !status; i++) {
        const unsigned code = code_of(x[i], top);
        bytes[2 * i] = (unsigned char)(code >> 8);
        bytes[2 * i + 1] = (unsigned char)(code & 255);
    }
    if (!status) {
        to_base64(bytes, 2 * n, text);
        ff_json_object(j, NULL, FF_JSON_LINE);
        ff_json_number(j, "top", top);
        ff_json_string(j, "codes", text);
        ff_json_close(j);
    }
    free(bytes);
    free(text);
    return status;
}

static ff_status put_values(ff_json *j, const ff_html_subject *s, size_t n, const size_t *channel)
{
    const grid g = grid_of(s, n);
    const size_t nodes = nodes_of(&g);
    double *value = malloc(n * nodes * sizeof *value);
    ff_status status = value ? interpolate(s, &g, n, channel, value) : FF_ERR_MEMORY;
    if (!status) {
        ff_json_integer(j, "theta_h", (int64_t)g.half);
        ff_json_integer(j, "theta_d", (int64_t)g.difference);
        ff_json_integer(j, "phi_d", (int64_t)g.azimuths);
        ff_json_integer(j, "side", (int64_t)g.side);
        ff_json_number(j, "span", SPAN);
        ff_json_array(j, "values", FF_JSON_LINE);
        for (size_t c = 0; c < n && !status; c++) status = put_codes(j, nodes, value + c * nodes);
        ff_json_close(j);
    }
    free(value);
    return status == FF_ERR_MEMORY ? status : FF_OK;
}

ff_status ff_html_sphere_json(ff_json *j, const ff_html_subject *s)
{
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
    if (!status) status = put_values(j, s, n, channel);
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

static void put_base64(ff_page *p, const unsigned char *bytes, size_t n)
{
    char *text = calloc(1, base64_length(n) + 1);
    if (!text) {
        ff_page_fail(p, FF_ERR_MEMORY);
        return;
    }
    to_base64(bytes, n, text);
    fputs(text, p->out);
    free(text);
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
        put_base64(p, made.png, made.n);
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
