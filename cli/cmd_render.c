/* facetfit render SOURCE... -o FILE: pictures of a lit sphere. */
#include "internal_rendering.h"
#include "report/render/render_struct.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

typedef enum form { FORM_NONE, FORM_PNG, FORM_EXR } form;

typedef struct rendering {
    cli_light light;
    cli_sweep across, down;
    cli_balls balls;
    ff_render_sheet sheet;
    size_t n;                   /* pictures, the difference included */
    float **picture;            /* [n] */
    ff_render_summary *summary; /* [balls.n] */
    ff_render_cell *cell;       /* [n] */
    char difference_label[CLI_LABEL];
} rendering;

/* ---- what is wanted -------------------------------------------------------------------------- */

static form form_of(const char *path)
{
    const size_t n = strlen(path);
    if (n < 5) return FORM_NONE;
    return !strcmp(path + n - 4, ".png") ? FORM_PNG : !strcmp(path + n - 4, ".exr") ? FORM_EXR : FORM_NONE;
}

/* What an image of linear numbers would not show. */
static int check_form(const cli_args *args, form to)
{
    static const cli_flag_id of_png[] = {FLAG_TONE, FLAG_EXPOSURE, FLAG_CLIP, FLAG_BACKGROUND, FLAG_LABELS};
    const char *path = cli_value(args, FLAG_OUTPUT, NULL);
    if (!path) return cli_usage(args, "-o is missing: where to write, NAME.png or NAME.exr");
    if (to == FORM_NONE) return cli_usage(args, "-o %s: expected a name that ends in .png or .exr", path);
    for (size_t k = 0; k < sizeof of_png / sizeof *of_png && to == FORM_EXR; k++)
        if (cli_given(args, of_png[k]))
            return cli_usage(args, "--%s has no effect on OpenEXR, which holds linear radiance: leave it out",
                             cli_flag_name(of_png[k]));
    return EXIT_DONE;
}

static void read_sheet(const cli_args *args, rendering *r)
{
    ff_render_sheet *s = &r->sheet;
    ff_render_sheet_init(s);
    s->pixels = r->light.options.pixels;
    s->exposure = cli_number(args, FLAG_EXPOSURE, s->exposure);
    s->clip = cli_number(args, FLAG_CLIP, s->clip);
    s->tone = (ff_render_tone)cli_word(args, FLAG_TONE, (int)s->tone);
    s->background = (ff_render_background)cli_word(args, FLAG_BACKGROUND, (int)s->background);
}

/* ---- pictures -------------------------------------------------------------------------------- */

static int make_room(const cli_args *args, rendering *r)
{
    const size_t n = r->balls.n + (size_t)r->balls.differ, pixels = r->sheet.pixels * r->sheet.pixels;
    if ((double)n * (double)pixels > 0x1p27)
        return cli_usage(args, "%zu pictures of %zu pixels a side are more than 2^27 pixels: give a smaller --size", n,
                         r->sheet.pixels);
    r->picture = calloc(n, sizeof *r->picture);
    r->summary = calloc(n, sizeof *r->summary);
    r->cell = calloc(n, sizeof *r->cell);
    if (!r->picture || !r->summary || !r->cell) return cli_failed(FF_ERR_MEMORY, NULL);
    r->n = n;
    for (size_t k = 0; k < n; k++)
        if (!(r->picture[k] = malloc(4 * pixels * sizeof **r->picture))) return cli_failed(FF_ERR_MEMORY, NULL);
    return EXIT_DONE;
}

static ff_status render(const rendering *r, const cli_ball *b, float *rgba, ff_render_summary *out, ff_error *err)
{
    ff_render_options o = r->light.options;
    o.colours = b->colours;
    if (b->table) return ff_render_table(b->table, b->model, b->n_channels, b->shape, b->channel, &o, rgba, out, err);
    return ff_render_model(b->model, b->n_channels, b->shape, b->channel, &o, rgba, out, err);
}

static void subtract(const float *from, const float *less, size_t n, float *out)
{
    // NOLINTNEXTLINE(clang-analyzer-core.NullDereference): all pictures were allocated before one was rendered
    for (size_t k = 0; k < 4 * n; k++) out[k] = k % 4 == 3 ? from[k] : from[k] - less[k];
}

/* What a picture of data does not say by itself. */
static void say_guesses(const cli_args *args, const ff_render_summary *s)
{
    if (s->guessed > 0.005)
        cli_note("%s: %.0f %% of the values of the picture lie beyond the data; the nearest were taken", args->word[0],
                 100 * s->guessed);
    if (s->unknown > 0)
        cli_note("%s: %.2g %% of the values of the picture are not known; they are black", args->word[0], 100 * s->unknown);
}

static int render_all(const cli_args *args, rendering *r)
{
    const cli_balls *b = &r->balls;
    ff_error err = {0};
    for (size_t k = 0; k < b->n; k++) {
        const ff_status failed = render(r, &b->ball[k], r->picture[k], &r->summary[k], &err);
        if (failed != FF_OK) {
            if (b->ball[k].table && !err.path[0]) snprintf(err.path, sizeof err.path, "%s", args->word[0]);
            return cli_failed(failed, &err);
        }
        if (b->ball[k].table) say_guesses(args, &r->summary[k]);
    }
    if (b->differ) subtract(r->picture[1], r->picture[0], r->sheet.pixels * r->sheet.pixels, r->picture[2]);
    return EXIT_DONE;
}

/* ---- writing --------------------------------------------------------------------------------- */

static void make_cells(const cli_args *args, rendering *r)
{
    char clip[FF_REPORT_NUMBER];
    const int labels = cli_switch(args, FLAG_LABELS, r->n > 1);
    snprintf(r->difference_label, sizeof r->difference_label, "%s, ±%s", r->balls.with_data ? "model − data" : "second − first",
             ff_report_number(r->sheet.clip, clip));
    for (size_t k = 0; k < r->n; k++) {
        const int differs = k == r->balls.n;
        r->cell[k] = (ff_render_cell){r->picture[k], differs ? r->difference_label : r->balls.ball[k].label,
                                      differs ? FF_CELL_DIFFERENCE : FF_CELL_PICTURE};
        if (!labels) r->cell[k].label = NULL;
    }
    r->sheet.n = r->n;
    r->sheet.columns = r->balls.columns + (size_t)r->balls.differ;
    r->sheet.cell = r->cell;
}

static int write_png(const cli_args *args, const char *path, const rendering *r)
{
    unsigned char *png;
    size_t n;
    ff_output out;
    ff_error err = {0};
    ff_status status = ff_render_png(&r->sheet, &png, &n, &err);
    if (status != FF_OK) return cli_failed(status, &err);
    status = ff_output_open_with(path, args->outputs, &out, &err);
    if (status == FF_OK) {
        fwrite(png, 1, n, out.file);
        status = ff_output_commit(&out, &err);
    }
    ff_render_png_free(png);
    return status == FF_OK ? EXIT_DONE : cli_failed(status, &err);
}

/* Data, model and difference are layers; else all pictures are one, beside each other. */
static int write_exr(const cli_args *args, const char *path, const rendering *r)
{
    const char *const name[3] = {r->balls.with_data ? "data" : "first", r->balls.with_data ? "model" : "second", "difference"};
    ff_render_layer layer[3] = {{"", r->cell}};
    ff_render_sheet sheet = r->sheet;
    ff_error err = {0};
    const int layers = r->balls.with_data || r->balls.differ;
    for (size_t k = 0; k < r->n && layers; k++) layer[k] = (ff_render_layer){name[k], &r->cell[k]};
    if (layers) sheet.n = sheet.columns = 1;
    const ff_status status = ff_render_exr_with(path, &sheet, layers ? r->n : 1, layer, args->outputs, &err);
    return status == FF_OK ? EXIT_DONE : cli_failed(status, &err);
}

static int write_rows(const cli_args *args, const rendering *r)
{
    static const char *const columns[] = {"picture", "mean_r", "mean_g", "mean_b", "error", "samples", "guessed", "unknown"};
    cli_rows rows;
    const int status = cli_rows_open(args, &rows);
    if (status != EXIT_DONE) return status;
    for (size_t k = 0; k < sizeof columns / sizeof *columns; k++) cli_rows_column(&rows, columns[k]);
    cli_rows_end_header(&rows);
    for (size_t k = 0; k < r->balls.n; k++) {
        const ff_render_summary *s = &r->summary[k];
        const double cells[] = {(double)k + 1, s->mean[0],         s->mean[1], s->mean[2],
                                s->error,      (double)s->samples, s->guessed, s->unknown};
        for (size_t c = 0; c < sizeof cells / sizeof *cells; c++) cli_rows_number(&rows, cells[c]);
        cli_rows_end_row(&rows);
    }
    return cli_rows_commit(&rows);
}

/* ---- all ------------------------------------------------------------------------------------- */

static void free_rendering(rendering *r)
{
    for (size_t k = 0; k < r->n; k++) free(r->picture[k]);
    free(r->picture);
    free(r->summary);
    free(r->cell);
    cli_balls_free(&r->balls);
    cli_light_free(&r->light);
    free(r);
}

int cmd_render(const cli_args *args)
{
    const char *path = cli_value(args, FLAG_OUTPUT, "");
    const form to = form_of(path);
    rendering *r = calloc(1, sizeof *r);
    if (!r) return cli_failed(FF_ERR_MEMORY, NULL);
    int status = check_form(args, to);
    if (status == EXIT_DONE) status = cli_sweep_read(args, FLAG_ACROSS, &r->across);
    if (status == EXIT_DONE) status = cli_sweep_read(args, FLAG_DOWN, &r->down);
    if (status == EXIT_DONE) status = cli_light_read(args, &r->light);
    if (status == EXIT_DONE) status = cli_balls_gather(args, &r->across, &r->down, &r->balls);
    if (status == EXIT_DONE) {
        read_sheet(args, r);
        if (cli_given(args, FLAG_CLIP) && !r->balls.differ)
            status = cli_usage(args, "--clip is of the difference of two pictures, and there is none");
    }
    if (status == EXIT_DONE) status = make_room(args, r);
    if (status == EXIT_DONE) status = render_all(args, r);
    if (status == EXIT_DONE) {
        make_cells(args, r);
        status = to == FORM_PNG ? write_png(args, path, r) : write_exr(args, path, r);
    }
    if (status == EXIT_DONE) status = write_rows(args, r);
    free_rendering(r);
    return status;
}
