/* facetfit furnace EXPR: directional albedo, by quadrature or by paths of light, or the weak white furnace integral. */
#include "internal_walking.h"
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
    ff_walk_options walk;
    ff_height_field_options surface;
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

/* ---- by paths of light ----------------------------------------------------------------------- */

static void put_walk_header(furnace *u)
{
    static const char *const of_channel[] = {"albedo", "albedo_error", "x", "x_error", "y", "y_error", "z", "z_error"};
    cli_rows_column(&u->rows, "mu");
    cli_rows_column(&u->rows, "first");
    cli_rows_column(&u->rows, "last");
    for (size_t c = 0; c < u->scene.n_channels; c++)
        for (size_t k = 0; k < sizeof of_channel / sizeof of_channel[0]; k++) {
            char name[64], suffix[24];
            snprintf(name, sizeof name, "%s%s", of_channel[k], cli_channel_suffix(u->scene.n_channels, c, suffix));
            cli_rows_column(&u->rows, name);
        }
    cli_rows_end_header(&u->rows);
}

/* A row for each group of orders; 0 as its last order: without an end. */
static void put_lobes(furnace *u, double mu, const ff_lobe_mean *lobe)
{
    for (size_t g = 0; g < u->walk.n_orders; g++) {
        cli_rows_number(&u->rows, mu);
        cli_rows_number(&u->rows, u->walk.orders[g].first);
        cli_rows_number(&u->rows, u->walk.orders[g].last);
        for (size_t c = 0; c < u->scene.n_channels; c++) {
            const ff_lobe_mean *l = &lobe[g * u->scene.n_channels + c];
            cli_rows_number(&u->rows, l->albedo);
            cli_rows_number(&u->rows, l->albedo_error);
            for (int j = 0; j < 3; j++) {
                cli_rows_number(&u->rows, l->mean[j]);
                cli_rows_number(&u->rows, l->mean_error[j]);
            }
        }
        cli_rows_end_row(&u->rows);
    }
}

static ff_status put_walks(furnace *u, ff_error *err)
{
    const cli_scene *s = &u->scene;
    ff_lobe_mean *lobe = malloc(u->walk.n_orders * s->n_channels * sizeof *lobe);
    ff_walk *walk = NULL;
    ff_status status = lobe ? ff_walk_new(&s->model, s->n_channels, s->shape, s->channel, &u->walk, &walk, err)
                            : ff_error_set(err, FF_ERR_MEMORY, NULL, 0, -1, "no memory for %zu channels", s->n_channels);
    for (size_t i = 0; i < u->n && !status; i++) {
        const double side = sqrt((1 - u->mu[i]) * (1 + u->mu[i])), wi[3] = {side * cos(u->phi), side * sin(u->phi), u->mu[i]};
        double lost;
        status = ff_walk_lobe(walk, wi, lobe, &lost, err);
        if (!status) put_lobes(u, u->mu[i], lobe);
        if (!status && lost > 1e-6) cli_warning("paths from mu = %g were ended with %.2g of the light", u->mu[i], lost);
    }
    if (u->walk.progress) cli_progress_end();
    ff_walk_free(walk);
    free(lobe);
    return status;
}

/* Unit vectors [3][n] of the cosines asked for. */
static void directions(const furnace *u, double *w)
{
    for (size_t i = 0; i < u->n; i++) {
        const double side = sqrt((1 - u->mu[i]) * (1 + u->mu[i]));
        w[i] = side * cos(u->phi);
        w[u->n + i] = side * sin(u->phi);
        w[2 * u->n + i] = u->mu[i];
    }
}

static ff_status put_traced(furnace *u, const ff_height_field *s, const double *w, ff_error *err)
{
    const size_t planes = u->walk.n_orders * u->scene.n_channels;
    ff_lobe_mean *lobe = malloc(u->n * planes * sizeof *lobe);
    double *lost = malloc(u->n * sizeof *lost);
    const ff_status status = lobe && lost ? ff_height_field_lobes(s, w, u->n, lobe, lost, err)
                                          : ff_error_set(err, FF_ERR_MEMORY, NULL, 0, -1, "no memory for %zu directions", u->n);
    for (size_t i = 0; i < u->n && !status; i++) {
        put_lobes(u, u->mu[i], lobe + i * planes);
        if (lost[i] > 1e-4) cli_warning("%.2g of the paths from mu = %g were lost at edges", lost[i], u->mu[i]);
    }
    free(lost);
    free(lobe);
    return status;
}

static ff_status put_seen(furnace *u, const ff_height_field *s, const double *w, ff_error *err)
{
    ff_seen *seen = malloc(u->n * sizeof *seen);
    const ff_status status = seen ? ff_height_field_seen(s, w, u->n, seen, err)
                                  : ff_error_set(err, FF_ERR_MEMORY, NULL, 0, -1, "no memory for %zu directions", u->n);
    for (size_t i = 0; i < u->n && !status; i++) {
        const double cells[5] = {u->mu[i], seen[i].g1, seen[i].g1_error, seen[i].g2, seen[i].g2_error};
        for (int k = 0; k < 5; k++) cli_rows_number(&u->rows, cells[k]);
        cli_rows_end_row(&u->rows);
    }
    free(seen);
    return status;
}

static ff_status put_normals(const cli_args *args, furnace *u, const ff_height_field *s, ff_error *err)
{
    double d[900], error[900];
    ff_slopes a;
    const size_t n = (size_t)cli_integer(args, FLAG_NORMALS, 1);
    const ff_status status = ff_height_field_slopes(s, &a, n, d, error, err);
    for (size_t i = 0; i < n && !status; i++) {
        cli_rows_number(&u->rows, 90 * ((double)i + 0.5) / (double)n);
        cli_rows_number(&u->rows, d[i]);
        cli_rows_number(&u->rows, error[i]);
        cli_rows_end_row(&u->rows);
    }
    if (!status)
        cli_message("alpha_x %.6g (%.1g), alpha_y %.6g (%.1g), r_xy %.4f (%.1g), kurtosis %.4g", a.alpha_x, a.alpha_x_error,
                    a.alpha_y, a.alpha_y_error, a.r_xy, a.r_xy_error, a.kurtosis);
    return status;
}

static void put_surface_header(const cli_args *args, furnace *u)
{
    static const char *const seen[] = {"mu", "g1", "g1_error", "g2", "g2_error", NULL}, *const normals[] = {"theta", "d", "d_error",
                                                                                                            NULL};
    const char *const *names = cli_given(args, FLAG_VISIBLE) ? seen : cli_given(args, FLAG_NORMALS) ? normals : NULL;
    if (!names) {
        put_walk_header(u);
        return;
    }
    for (size_t k = 0; names[k]; k++) cli_rows_column(&u->rows, names[k]);
    cli_rows_end_header(&u->rows);
}

static ff_status put_surface(const cli_args *args, furnace *u, ff_error *err)
{
    const cli_scene *c = &u->scene;
    ff_height_field *s = NULL;
    double *w = malloc(3 * u->n * sizeof *w);
    ff_status status = w ? ff_height_field_new(&c->model, c->n_channels, c->shape, c->channel, &u->surface, &s, err)
                         : ff_error_set(err, FF_ERR_MEMORY, NULL, 0, -1, "no memory for %zu directions", u->n);
    if (!status) {
        directions(u, w);
        status = cli_given(args, FLAG_VISIBLE)   ? put_seen(u, s, w, err)
                 : cli_given(args, FLAG_NORMALS) ? put_normals(args, u, s, err)
                                                 : put_traced(u, s, w, err);
    }
    if (u->surface.progress) cli_progress_end();
    ff_height_field_free(s);
    free(w);
    return status;
}

/* ---- by quadrature --------------------------------------------------------------------------- */

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
    const int walks = cli_given(args, FLAG_WALK) > 0, traced = cli_given(args, FLAG_SURFACE) > 0;
    if (traced)
        put_surface_header(args, u);
    else if (walks)
        put_walk_header(u);
    else
        put_header(u);
    const ff_status failed = traced ? put_surface(args, u, &err) : walks ? put_walks(u, &err) : put_rows(u, &err);
    if (failed != FF_OK) {
        cli_rows_abort(&u->rows);
        return cli_failed(failed, &err);
    }
    status = cli_rows_commit(&u->rows);
    if (status != EXIT_DONE || !u->missed) return status;
    cli_error("the weak white furnace integral misses 1 by more than %g", furnace_tolerance);
    return EXIT_ANSWER_IS_NO;
}

int cmd_furnace(const cli_args *args)
{
    furnace *u = calloc(1, sizeof *u);
    if (!u) return cli_failed(FF_ERR_MEMORY, NULL);
    int status = cli_isa(args, &u->isa);
    if (status == EXIT_DONE) status = read_mu(args, u);
    if (status == EXIT_DONE) status = cli_walk_read(args, 1000000, "all,1,2,3,4,5+", &u->walk);
    if (status == EXIT_DONE) status = cli_surface_read(args, &u->walk, &u->surface);
    if (status == EXIT_DONE && (cli_given(args, FLAG_WALK) || cli_given(args, FLAG_SURFACE)) && cli_given(args, FLAG_WEAK))
        status = cli_usage(args, "--weak is an integral of the model, and --walk and --surface follow paths: one of them");
    if (status == EXIT_DONE && cli_given(args, FLAG_VISIBLE) && cli_given(args, FLAG_NORMALS))
        status = cli_usage(args, "--visible and --normals are two tables: one of them");
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
