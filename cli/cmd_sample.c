/* facetfit sample EXPR: directions of light drawn in proportion to a model, for one view. */
#include "internal_cli.h"
#include "ff_sample.h"
#include "simulate/simulate_struct.h"
#include <math.h>
#include <stdlib.h>

enum { BLOCK = 512 };
static const double degree = 3.14159265358979323846 / 180;

typedef struct drawing {
    cli_scene scene;
    ff_isa isa;
    double theta, phi; /* degrees */
    uint64_t n, seed;
    ff_sampler *sampler;
    double wo[3][BLOCK], u[3][BLOCK], wi[3][BLOCK], pdf[BLOCK];
    double *f, *weight; /* [n_channels][BLOCK] */
    cli_rows rows;
} drawing;

static void put_columns(drawing *d, const char *name)
{
    for (size_t c = 0; c < d->scene.n_channels; c++) {
        char column[64], suffix[24];
        snprintf(column, sizeof column, "%s%s", name, cli_channel_suffix(d->scene.n_channels, c, suffix));
        cli_rows_column(&d->rows, column);
    }
}

static void put_header(drawing *d)
{
    cli_rows_column(&d->rows, "theta_i");
    cli_rows_column(&d->rows, "phi_i");
    cli_rows_column(&d->rows, "pdf");
    put_columns(d, "f");
    put_columns(d, "weight");
    cli_rows_end_header(&d->rows);
}

static void put_row(drawing *d, size_t i)
{
    const double x = d->wi[0][i], y = d->wi[1][i], phi = atan2(y, x) / degree;
    cli_rows_number(&d->rows, atan2(hypot(x, y), d->wi[2][i]) / degree);
    cli_rows_number(&d->rows, phi < 0 ? phi + 360 : phi);
    cli_rows_number(&d->rows, d->pdf[i]);
    for (size_t c = 0; c < d->scene.n_channels; c++) cli_rows_number(&d->rows, d->f[c * BLOCK + i]);
    for (size_t c = 0; c < d->scene.n_channels; c++) cli_rows_number(&d->rows, d->weight[c * BLOCK + i]);
    cli_rows_end_row(&d->rows);
}

static void set_view(drawing *d)
{
    const double t = d->theta * degree, p = d->phi * degree;
    for (size_t i = 0; i < BLOCK; i++) {
        d->wo[0][i] = sin(t) * cos(p);
        d->wo[1][i] = sin(t) * sin(p);
        d->wo[2][i] = cos(t);
    }
}

static void put_rows(drawing *d)
{
    for (uint64_t first = 0; first < d->n; first += BLOCK) {
        const size_t n = d->n - first < BLOCK ? (size_t)(d->n - first) : BLOCK;
        for (uint32_t k = 0; k < 3; k++)
            for (size_t i = 0; i < n; i++) d->u[k][i] = ff_random_uniform(d->seed, k, first + i);
        ff_sampler_sample(d->sampler, n, d->wo[0], d->u[0], NULL, d->wi[0], d->pdf, d->f, d->weight, BLOCK);
        for (size_t i = 0; i < n; i++) put_row(d, i);
    }
}

static int put(const cli_args *args, drawing *d)
{
    ff_error err = {0};
    const cli_scene *s = &d->scene;
    ff_status failed = ff_sampler_new(&s->model, d->isa, s->n_channels, s->shape, s->channel, &d->sampler, &err);
    if (failed != FF_OK) return cli_failed(failed, &err);
    d->f = malloc(s->n_channels * BLOCK * sizeof *d->f);
    d->weight = malloc(s->n_channels * BLOCK * sizeof *d->weight);
    if (!d->f || !d->weight) return cli_failed(FF_ERR_MEMORY, NULL);
    set_view(d);
    const int status = cli_rows_open(args, &d->rows);
    if (status != EXIT_DONE) return status;
    put_header(d);
    put_rows(d);
    return cli_rows_commit(&d->rows);
}

int cmd_sample(const cli_args *args)
{
    drawing *d = calloc(1, sizeof *d);
    if (!d) return cli_failed(FF_ERR_MEMORY, NULL);
    int status = cli_isa(args, &d->isa);
    if (status == EXIT_DONE) {
        d->n = cli_integer(args, FLAG_SAMPLES, 1000);
        d->seed = cli_integer(args, FLAG_SEED, 1);
        d->theta = cli_number(args, FLAG_THETA, 0);
        d->phi = cli_number(args, FLAG_PHI, 0);
        status = cli_scene_make(args, args->word[0], 1, &d->scene);
    }
    if (status == EXIT_DONE) {
        status = put(args, d);
        ff_sampler_free(d->sampler);
        free(d->f);
        free(d->weight);
        cli_scene_free(&d->scene);
    }
    free(d);
    return status;
}
