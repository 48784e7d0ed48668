/* facetfit furnace EXPR: directional albedo, or the weak white furnace integral. */
#include "internal_cli.h"
#include "ff_albedo.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { VIEWS = CLI_VALUES };
static const double furnace_tolerance = 1e-6;

typedef struct furnace {
    cli_scene scene;
    ff_isa isa;
    int weak, missed;
    double phi;
    size_t n;
    double mu[VIEWS];
    cli_rows rows;
} furnace;

static int read_mu(const cli_args *args, furnace *u)
{
    const char *text = cli_value(args, FLAG_MU, "1,0.9,0.8,0.7,0.6,0.5,0.4,0.3,0.2,0.1");
    u->n = cli_list_read(text, VIEWS, u->mu);
    for (size_t i = 0; i < u->n; i++)
        if (!(u->mu[i] > FF_COS_MIN)) return cli_usage(args, "--mu %s: a cosine of %g is at the horizon", text, u->mu[i]);
    return EXIT_DONE;
}

static void put_header(furnace *u)
{
    const size_t n = u->weak ? u->scene.model.n_lobes : u->scene.n_channels;
    cli_rows_column(&u->rows, "mu");
    for (size_t k = 0; k < n; k++) {
        char name[64], suffix[24];
        if (u->weak && k > 0) {
            snprintf(name, sizeof name, "lobe%zu.weak_furnace", k + 1);
        } else {
            snprintf(name, sizeof name, "%s%s", u->weak ? "weak_furnace" : "albedo",
                     u->weak ? "" : cli_channel_suffix(n, k, suffix));
        }
        cli_rows_column(&u->rows, name);
    }
    cli_rows_end_header(&u->rows);
}

static ff_status put_weak(furnace *u, const double wo[3], ff_error *err)
{
    const ff_model *m = &u->scene.model;
    ff_status status = FF_OK;
    for (uint32_t l = 0; l < m->n_lobes && status == FF_OK; l++) {
        ff_integral value;
        status = ff_albedo_weak_furnace(m, u->isa, u->scene.shape, l, wo, &value, err);
        if (status == FF_OK && !isfinite(value.value))
            status =
                ff_error_set(err, FF_ERR_UNSUPPORTED, NULL, 0, -1,
                             "the weak white furnace integral of %s does not exist here: the area of its steepest normals grows "
                             "without bound, and with it Smith's Lambda ('facetfit models' says from where)",
                             ff_term_at(FF_NDF, (size_t)m->lobe[l].ndf)->name);
        if (status != FF_OK) break;
        u->missed |= ff_albedo_weak_furnace_claimed(m, l) && !(fabs(value.value - 1) <= furnace_tolerance);
        cli_rows_number(&u->rows, value.value);
    }
    return status;
}

static ff_status put_albedo(furnace *u, const double wo[3], ff_error *err)
{
    const cli_scene *s = &u->scene;
    ff_integral *value = malloc(s->n_channels * sizeof *value);
    if (!value) return ff_error_set(err, FF_ERR_MEMORY, NULL, 0, -1, "no memory for %zu channels", s->n_channels);
    const ff_status status = ff_albedo_directional(&s->model, u->isa, s->n_channels, s->shape, s->channel, wo, value, err);
    for (size_t c = 0; c < s->n_channels && status == FF_OK; c++) cli_rows_number(&u->rows, value[c].value);
    free(value);
    return status;
}

static ff_status put_rows(furnace *u, ff_error *err)
{
    ff_status status = FF_OK;
    for (size_t i = 0; i < u->n && status == FF_OK; i++) {
        const double s = sqrt((1 - u->mu[i]) * (1 + u->mu[i])), wo[3] = {s * cos(u->phi), s * sin(u->phi), u->mu[i]};
        cli_rows_number(&u->rows, u->mu[i]);
        status = u->weak ? put_weak(u, wo, err) : put_albedo(u, wo, err);
        cli_rows_end_row(&u->rows);
    }
    return status;
}

static int integrate(const cli_args *args, furnace *u)
{
    ff_error err = {0};
    int status;
    if (u->weak && u->scene.model.n_lobes == 0)
        return cli_usage(args, "--weak needs a model with a lobe; '%s' has none",
                         args->word[0] ? args->word[0] : cli_value(args, FLAG_FROM, ""));
    if ((status = cli_rows_open(args, &u->rows))) return status;
    put_header(u);
    const ff_status failed = put_rows(u, &err);
    if (failed != FF_OK) {
        cli_rows_abort(&u->rows);
        return cli_failed(failed, &err);
    }
    status = cli_rows_commit(&u->rows);
    if (status != EXIT_DONE || !u->missed) return status;
    cli_message("the weak white furnace integral misses 1 by more than %g", furnace_tolerance);
    return EXIT_ANSWER_IS_NO;
}

int cmd_furnace(const cli_args *args)
{
    furnace *u = calloc(1, sizeof *u);
    if (!u) return cli_failed(FF_ERR_MEMORY, NULL);
    int status = cli_isa(args, &u->isa);
    if (status == EXIT_DONE) status = read_mu(args, u);
    if (status == EXIT_DONE) status = cli_scene_make(args, args->word[0], 1, &u->scene);
    if (status == EXIT_DONE) {
        u->phi = cli_number(args, FLAG_PHI, 0) * 3.14159265358979323846 / 180;
        u->weak = cli_given(args, FLAG_WEAK) > 0;
        status = integrate(args, u);
        cli_scene_free(&u->scene);
    }
    free(u);
    return status;
}
