/* facetfit eval EXPR [FILE]: values of a model for directions in CSV. */
#include "internal_cli.h"
#include "base/internal_input.h"
#include "base/internal_number.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { BLOCK = 512, COLUMNS = 256, TERMS = 4 }; /* d, lambda_i, lambda_o, g; fresnel is per channel */
static const double pi = 3.14159265358979323846;
static const char *const angle_name[4] = {"theta_i", "phi_i", "theta_o", "phi_o"};
static const char *const term_name[TERMS] = {"d", "lambda_i", "lambda_o", "g"};

typedef struct evaluation {
    const char *path;
    ff_lines lines;
    size_t n_columns;
    int column[4]; /* where the four angles stand in a row, from 0 */
    cli_scene scene;
    ff_isa isa;
    ff_aperture aperture;
    double error[BLOCK]; /* of the means, and what came of those that are not known as well as they should be */
    double worst;
    size_t n_rough, n_rows;
    int terms;
    size_t n;       /* rows that wait */
    ff_table table; /* BLOCK rows, in degrees: directions come from angles as they do in a data file */
    double direction[6][BLOCK];
    double *f;    /* [n_channels][BLOCK] */
    double *term; /* [n_lobes][TERMS + n_channels][BLOCK], NULL without --terms */
    cli_rows rows;
} evaluation;

/* ---- reading --------------------------------------------------------------------------------- */

/* One cell without surrounding blanks; *next is where the following one starts, NULL after the last. */
static size_t cell_cut(const char **text, const char **next)
{
    const char *p = *text + strspn(*text, " \t");
    size_t n = strcspn(p, ",");
    *next = p[n] == ',' ? p + n + 1 : NULL;
    while (n > 0 && (p[n - 1] == ' ' || p[n - 1] == '\t')) n--;
    *text = p;
    return n;
}

static ff_status read_header(evaluation *e, const char *line, ff_error *err)
{
    char quoted[FF_QUOTE];
    for (int k = 0; k < 4; k++) e->column[k] = -1;
    e->n_columns = 0;
    for (const char *cell = line, *next; cell; cell = next) {
        const size_t n = cell_cut(&cell, &next);
        for (int k = 0; k < 4; k++) {
            if (strlen(angle_name[k]) != n || strncmp(angle_name[k], cell, n)) continue;
            if (e->column[k] >= 0)
                return ff_error_set(err, FF_ERR_FORMAT, e->path, e->lines.line, -1, "the column %s stands there twice",
                                    angle_name[k]);
            e->column[k] = (int)e->n_columns;
        }
        if (++e->n_columns > COLUMNS)
            return ff_error_set(err, FF_ERR_FORMAT, e->path, e->lines.line, -1, "more than %d columns", COLUMNS);
    }
    for (int k = 0; k < 4; k++)
        if (e->column[k] < 0)
            return ff_error_set(err, FF_ERR_FORMAT, e->path, e->lines.line, -1,
                                "found the header %s, expected the columns theta_i,phi_i,theta_o,phi_o (%s is missing)",
                                ff_quote(line, strlen(line), quoted), angle_name[k]);
    return FF_OK;
}

static ff_status read_row(evaluation *e, const char *line, ff_error *err)
{
    char quoted[FF_QUOTE];
    size_t c = 0;
    for (const char *cell = line, *next; cell; cell = next, c++) {
        const size_t n = cell_cut(&cell, &next);
        for (int k = 0; k < 4; k++) {
            double x;
            if (e->column[k] != (int)c) continue;
            const char *end = ff_number_read(cell, &x);
            if (end != cell + n || !isfinite(x))
                return ff_error_set(err, FF_ERR_FORMAT, e->path, e->lines.line, -1,
                                    "column %zu (%s): found %s, expected a number of degrees", c + 1, angle_name[k],
                                    ff_quote(cell, n, quoted));
            e->table.angle[k][e->n] = x;
        }
    }
    if (c != e->n_columns)
        return ff_error_set(err, FF_ERR_FORMAT, e->path, e->lines.line, -1, "found %zu columns, expected %zu", c, e->n_columns);
    e->n++;
    return FF_OK;
}

/* The next line that is neither blank nor a comment; NULL at the end. */
static ff_status next_line(evaluation *e, char **line, ff_error *err)
{
    for (;;) {
        size_t n;
        const ff_status status = ff_lines_next(&e->lines, line, &n, err);
        if (status != FF_OK || !*line) return status;
        const char first = (*line)[strspn(*line, " \t")];
        if (first && first != '#') return FF_OK;
    }
}

/* ---- evaluating ------------------------------------------------------------------------------ */

static double *term_plane(const evaluation *e, uint32_t lobe, size_t which)
{
    return e->term + (lobe * (TERMS + e->scene.n_channels) + which) * BLOCK;
}

static ff_status evaluate_terms(const evaluation *e, const ff_dirs *w)
{
    const cli_scene *s = &e->scene;
    ff_status status = FF_OK;
    for (uint32_t l = 0; l < s->model.n_lobes; l++)
        for (size_t c = 0; c < s->n_channels && status == FF_OK; c++) {
            const ff_terms t = {term_plane(e, l, 0), term_plane(e, l, 1), term_plane(e, l, 2), term_plane(e, l, 3),
                                term_plane(e, l, TERMS + c)};
            status = ff_model_terms(&s->model, e->isa, s->n_channels, s->shape, s->channel, l, c, w, e->n, &t);
        }
    return status;
}

static void put_row(evaluation *e, size_t i)
{
    const size_t n_channels = e->scene.n_channels;
    for (int k = 0; k < 4; k++) cli_rows_number(&e->rows, e->table.angle[k][i]);
    for (size_t c = 0; c < n_channels; c++) cli_rows_number(&e->rows, e->f[c * BLOCK + i]);
    for (uint32_t l = 0; e->terms && l < e->scene.model.n_lobes; l++)
        for (size_t t = 0; t < TERMS + n_channels; t++) cli_rows_number(&e->rows, term_plane(e, l, t)[i]);
    cli_rows_end_row(&e->rows);
}

static ff_status flush(evaluation *e, ff_error *err)
{
    const cli_scene *s = &e->scene;
    double(*d)[BLOCK] = e->direction;
    const ff_dirs w = {d[0], d[1], d[2], d[3], d[4], d[5]};
    ff_table_directions(&e->table, 0, e->n, (double *const[6]){d[0], d[1], d[2], d[3], d[4], d[5]});
    ff_status status = ff_aperture_eval(&e->aperture, &s->model, e->isa, s->n_channels, s->shape, s->channel, &w, e->n, e->f, NULL,
                                        e->error, BLOCK);
    if (status == FF_OK && e->terms) status = evaluate_terms(e, &w);
    if (status != FF_OK) return ff_error_set(err, status, NULL, 0, -1, "the model cannot be evaluated");
    for (size_t i = 0; i < e->n; i++) {
        put_row(e, i);
        e->n_rough += e->error[i] > FF_APERTURE_TOLERANCE;
        e->worst = fmax(e->worst, e->error[i]);
    }
    e->n_rows += e->n;
    e->n = 0;
    return FF_OK;
}

static void put_header(evaluation *e)
{
    char name[64], suffix[24];
    const size_t n = e->scene.n_channels;
    for (int k = 0; k < 4; k++) cli_rows_column(&e->rows, angle_name[k]);
    for (size_t c = 0; c < n; c++) {
        snprintf(name, sizeof name, "f%s", cli_channel_suffix(n, c, suffix));
        cli_rows_column(&e->rows, name);
    }
    for (uint32_t l = 0; e->terms && l < e->scene.model.n_lobes; l++) {
        char lobe[24] = "";
        if (l > 0) snprintf(lobe, sizeof lobe, "lobe%u.", l + 1);
        for (int t = 0; t < TERMS; t++) {
            snprintf(name, sizeof name, "%s%s", lobe, term_name[t]);
            cli_rows_column(&e->rows, name);
        }
        for (size_t c = 0; c < n; c++) {
            snprintf(name, sizeof name, "%sfresnel%s", lobe, cli_channel_suffix(n, c, suffix));
            cli_rows_column(&e->rows, name);
        }
    }
    cli_rows_end_header(&e->rows);
}

static ff_status evaluate_all(evaluation *e, ff_error *err)
{
    char *line;
    ff_status status;
    while ((status = next_line(e, &line, err)) == FF_OK && line) {
        status = read_row(e, line, err);
        if (status == FF_OK && e->n == BLOCK) status = flush(e, err);
        if (status != FF_OK) return status;
    }
    return status == FF_OK ? flush(e, err) : status;
}

static int evaluate(const cli_args *args, evaluation *e)
{
    ff_error err = {0};
    char *line;
    ff_status failed = next_line(e, &line, &err);
    if (failed == FF_OK && !line)
        failed =
            ff_error_set(&err, FF_ERR_FORMAT, e->path, 0, -1, "is empty, expected a header theta_i,phi_i,theta_o,phi_o and rows");
    if (failed == FF_OK) failed = read_header(e, line, &err);
    if (failed != FF_OK) return cli_failed(failed, &err);
    const int status = cli_rows_open(args, &e->rows);
    if (status != EXIT_DONE) return status;
    put_header(e);
    failed = evaluate_all(e, &err);
    if (failed == FF_OK && e->n_rough)
        cli_note("%zu of %zu means over the aperture are not known to %g of their value; the worst to %.1g", e->n_rough, e->n_rows,
                 FF_APERTURE_TOLERANCE, e->worst);
    if (failed == FF_OK) return cli_rows_commit(&e->rows);
    cli_rows_abort(&e->rows);
    return cli_failed(failed, &err);
}

int cmd_eval(const cli_args *args)
{
    evaluation *e = calloc(1, sizeof *e);
    ff_error err = {0};
    if (!e) return cli_failed(FF_ERR_MEMORY, NULL);
    int status = cli_isa(args, &e->isa);
    if (status == EXIT_DONE) status = cli_scene_make(args, args->word[0], 1, &e->scene);
    if (status == EXIT_DONE && (status = cli_aperture(args, &e->scene.aperture, &e->aperture)) != EXIT_DONE)
        cli_scene_free(&e->scene);
    if (status != EXIT_DONE) {
        free(e);
        return status;
    }
    const size_t n = e->scene.n_channels;
    e->terms = cli_given(args, FLAG_TERMS) > 0;
    e->path = args->n_words > 1 && strcmp(args->word[1], "-") ? args->word[1] : "-";
    e->f = malloc(n * BLOCK * sizeof *e->f);
    e->term = e->terms ? malloc((e->scene.model.n_lobes * (TERMS + n) * BLOCK + 1) * sizeof *e->term) : NULL;
    ff_status failed = e->f && (!e->terms || e->term) ? FF_OK : FF_ERR_MEMORY;
    if (failed == FF_OK) failed = ff_table_init(BLOCK, 1, NULL, 0, 0, &e->table, &err);
    e->table.radians_per_unit = pi / 180;
    if (failed == FF_OK) failed = ff_lines_open(e->path, &e->lines, &err);
    if (failed == FF_OK) {
        status = evaluate(args, e);
        ff_lines_close(&e->lines);
    } else {
        status = cli_failed(failed, &err);
    }
    cli_scene_free(&e->scene);
    ff_table_clear(&e->table);
    free(e->term);
    free(e->f);
    free(e);
    return status;
}
