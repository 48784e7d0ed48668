/* The light that each pixel of a lit sphere sends to the viewer; the method is described in ff_render.h.
 *
 * A thread takes a row at a time and goes through all pairs of directions of all its pixels in one stream of blocks, so that blocks
 * are full however few pairs a pixel has. What is added up where is a matter of the row alone. */
#include "internal_render.h"
#include "base/internal_pool.h"
#include "models/tools/internal_sphere.h"
#include "ff_simulate.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

static const double pi = 3.14159265358979323846;

enum {
    GRID = 4,      /* points of a pixel under lights, along a side */
    SETS_MANY = 8, /* independent sets of points, for the error    */
    SETS_FEW = 2,  /* ... of fewer samples than                    */
    SETS_FROM = 64,
    DIMENSIONS = 7, /* two for the place in the pixel, three for the model, two for the environment */
    STREAM = 1000   /* of the random numbers; dimension d has STREAM + d */
};

typedef struct ff_render_job {
    const ff_surface *s;
    const ff_render_options *o;
    ff_camera camera;
    double light[FF_RENDER_LIGHTS_MAX][3]; /* unit vectors */
    size_t sets, points;                   /* of each pixel, of pairs of samples: one of the model, one of the environment */
    float *rgba;
    struct worker *worker; /* [threads] */
    double *variance;      /* [pixels] of means of pixels, summed over a row and its channels */
    double *light_sum;     /* [pixels][3]: of a row    */
    size_t *count;         /* [pixels] of the sphere in a row */
} ff_render_job;

/* What a thread works with. */
typedef struct worker {
    ff_beams *beams;
    double *sum;                                 /* [pixels][sets][3] of the row        */
    double *drawn, *radiance, *density, *across; /* of the environment: [3][FF_BEAMS], [3][FF_BEAMS], [FF_BEAMS], [FF_BEAMS] */
    size_t n_values, n_guessed, n_unknown;
} worker;

/* ---- lights ---------------------------------------------------------------------------------- */

static void add_lit(const ff_render_job *j, worker *w)
{
    ff_beams *b = w->beams;
    if (b->n == 0) return;
    ff_surface_values(j->s, b, 0);
    for (size_t i = 0; i < b->n; i++)
        for (size_t c = 0; c < 3; c++)
            w->sum[(b->pixel[i] * j->sets) * 3 + c] += b->f[c][i] * b->wi[2][i] * (pi / (GRID * GRID)) * (double)j->points;
    b->n = 0;
}

/* One point under all lights. */
static void light_point(const ff_render_job *j, worker *w, size_t pixel, const double n[3], const double view[3])
{
    for (size_t l = 0; l < j->o->n_lights; l++) {
        ff_beams *b = w->beams;
        double wi[3], wo[3];
        ff_sphere_to_surface(n, j->light[l], wi);
        if (!(wi[2] > FF_COS_MIN)) continue;
        ff_sphere_to_surface(n, view, wo);
        for (size_t k = 0; k < 3; k++) b->wi[k][b->n] = wi[k], b->wo[k][b->n] = wo[k];
        b->pixel[b->n++] = pixel;
        if (b->n == FF_BEAMS) add_lit(j, w);
    }
}

/* Place of point (a, b) of the lattice of pixel (i, row); how much of the pixel is of the sphere. */
static double light_pixel(const ff_render_job *j, worker *w, size_t i, size_t row)
{
    const size_t fine = GRID * j->o->pixels;
    size_t inside = 0;
    for (size_t b = 0; b < GRID; b++)
        for (size_t a = 0; a < GRID; a++) {
            double n[3], view[3];
            if (!ff_camera_look(&j->camera, ff_sphere_x(fine, GRID * i + a), ff_sphere_y(fine, GRID * row + b), n, view)) continue;
            inside++;
            light_point(j, w, i, n, view);
        }
    return (double)inside / (GRID * GRID);
}

/* ---- the environment ------------------------------------------------------------------------- */

/* Adds f L cos / (p_model + p_environment) of all pairs; the radiance is in w->radiance. */
static void add_weighted(const ff_render_job *j, worker *w)
{
    ff_beams *b = w->beams;
    for (size_t i = 0; i < b->n; i++) {
        const double density = b->pdf[i] + w->density[i];
        if (!(b->wi[2][i] > FF_COS_MIN && density > 0)) continue;
        const double weight = b->wi[2][i] / density;
        double *sum = w->sum + (b->pixel[i] * j->sets + b->set[i]) * 3;
        for (size_t c = 0; c < 3; c++) sum[c] += b->f[c][i] * w->radiance[c * FF_BEAMS + i] * weight;
    }
}

static void add_drawn_by_model(const ff_render_job *j, worker *w)
{
    ff_beams *b = w->beams;
    ff_surface_draw(j->s, b, b->u[0] + 2 * FF_BEAMS);
    for (size_t i = 0; i < b->n; i++) {
        const double n[3] = {b->normal[0][i], b->normal[1][i], b->normal[2][i]};
        const double wi[3] = {b->wi[0][i], b->wi[1][i], b->wi[2][i]};
        double out[3];
        ff_sphere_from_frame(n, b->axis[i], wi, out);
        for (size_t k = 0; k < 3; k++) w->drawn[k * FF_BEAMS + i] = out[k];
    }
    ff_environment_look(j->o->environment, b->n, w->drawn, w->radiance, w->density, FF_BEAMS);
    add_weighted(j, w);
}

static void add_drawn_by_environment(const ff_render_job *j, worker *w)
{
    ff_beams *b = w->beams;
    size_t kept = 0;
    ff_environment_draw_places(j->o->environment, b->n, b->u[0] + 5 * FF_BEAMS, w->drawn, w->across, w->density, FF_BEAMS);
    for (size_t i = 0; i < b->n; i++) { /* what comes from below the surface is 0 */
        const double n[3] = {b->normal[0][i], b->normal[1][i], b->normal[2][i]};
        const double from[3] = {w->drawn[i], w->drawn[FF_BEAMS + i], w->drawn[2 * FF_BEAMS + i]};
        double wi[3];
        ff_sphere_to_frame(n, b->axis[i], from, wi);
        if (!(wi[2] > FF_COS_MIN)) continue;
        for (size_t k = 0; k < 3; k++) {
            b->wi[k][kept] = wi[k];
            b->wo[k][kept] = b->wo[k][i];
        }
        ff_sample_shares_move(&b->share, i, kept);
        w->density[kept] = w->density[i];
        w->across[kept] = w->across[i];
        w->drawn[FF_BEAMS + kept] = from[1];
        b->pixel[kept] = b->pixel[i];
        b->set[kept++] = b->set[i];
    }
    b->n = kept;
    if (kept == 0) return;
    ff_environment_radiance(j->o->environment, kept, w->across, w->drawn + FF_BEAMS, w->radiance, FF_BEAMS);
    ff_surface_values(j->s, b, 1);
    add_weighted(j, w);
}

static void add_surrounded(const ff_render_job *j, worker *w)
{
    if (w->beams->n == 0) return;
    add_drawn_by_model(j, w);
    add_drawn_by_environment(j, w);
    w->beams->n = 0;
}

/* Multiples of powers of 1/g, g^8 = g + 1 (Roberts 2018), modulo 1. */
static const double step[DIMENSIONS] = {0.9115923534820549, 0.8310006189269519, 0.7575338099526643, 0.6905620286569770,
                                        0.6295110649287560, 0.5738574732213994, 0.5231240845771608};

static void surround_point(const ff_render_job *j, worker *w, size_t i, size_t row, size_t set, const double u[DIMENSIONS])
{
    ff_beams *b = w->beams;
    const double pixels = (double)j->o->pixels;
    double n[3], view[3], wo[3];
    if (!ff_camera_look(&j->camera, 2 * ((double)i + u[0]) / pixels - 1, 1 - 2 * ((double)row + u[1]) / pixels, n, view)) return;
    b->axis[b->n] = ff_sphere_axis(n);
    ff_sphere_to_frame(n, b->axis[b->n], view, wo);
    for (size_t k = 0; k < 3; k++) b->normal[k][b->n] = n[k], b->wo[k][b->n] = wo[k];
    for (size_t d = 0; d < DIMENSIONS; d++) b->u[d][b->n] = u[d];
    b->pixel[b->n] = i;
    b->set[b->n++] = set;
    if (b->n == FF_BEAMS) add_surrounded(j, w);
}

static void surround_pixel(const ff_render_job *j, worker *w, size_t i, size_t row)
{
    for (size_t set = 0; set < j->sets; set++) {
        double u[DIMENSIONS];
        const uint64_t index = (uint64_t)(row * j->o->pixels + i) * SETS_MANY + set;
        for (unsigned d = 0; d < DIMENSIONS; d++) u[d] = ff_random_uniform(j->o->seed, STREAM + d, index);
        for (size_t p = 0; p < j->points; p++) {
            surround_point(j, w, i, row, set, u);
            for (size_t d = 0; d < DIMENSIONS; d++) {
                u[d] += step[d];
                u[d] -= u[d] >= 1;
            }
        }
    }
}

/* ---- a row ----------------------------------------------------------------------------------- */

/* Mean over the sets; their spread. */
static void finish_pixel(ff_render_job *j, const worker *w, size_t i, size_t row, double coverage)
{
    const double *sum = w->sum + i * j->sets * 3, n = (double)j->sets;
    float *to = j->rgba + 4 * (row * j->o->pixels + i);
    for (size_t c = 0; c < 3; c++) {
        double mean = 0, squares = 0;
        for (size_t r = 0; r < j->sets; r++) mean += sum[3 * r + c] / (double)j->points;
        mean /= n;
        for (size_t r = 0; r < j->sets; r++) {
            const double d = sum[3 * r + c] / (double)j->points - mean;
            squares += d * d;
        }
        to[c] = (float)mean;
        j->light_sum[3 * row + c] += mean;
        if (j->sets > 1) j->variance[row] += squares / (n * (n - 1));
    }
    to[3] = (float)coverage;
    j->count[row]++;
}

static void render_row(void *context, size_t row, int index)
{
    ff_render_job *j = context;
    worker *w = &j->worker[index];
    const ff_render_options *o = j->o;
    float *coverage = j->rgba + 4 * row * o->pixels;
    if (o->cancel && *o->cancel) return;
    memset(w->sum, 0, o->pixels * j->sets * 3 * sizeof *w->sum);
    memset(coverage, 0, 4 * o->pixels * sizeof *coverage);
    for (size_t i = 0; i < o->pixels; i++) coverage[4 * i + 3] = (float)light_pixel(j, w, i, row);
    add_lit(j, w);
    if (o->environment) {
        for (size_t r = 1; r < j->sets; r++) /* lights are the same in every set */
            for (size_t i = 0; i < o->pixels; i++)
                memcpy(w->sum + (i * j->sets + r) * 3, w->sum + i * j->sets * 3, 3 * sizeof *w->sum);
        for (size_t i = 0; i < o->pixels; i++)
            if (coverage[4 * i + 3] > 0) surround_pixel(j, w, i, row);
        add_surrounded(j, w);
    }
    for (size_t i = 0; i < o->pixels; i++)
        if (coverage[4 * i + 3] > 0) finish_pixel(j, w, i, row, (double)coverage[4 * i + 3]);
}

/* ---- all ------------------------------------------------------------------------------------- */

static ff_status make_workers(ff_render_job *j, int threads)
{
    const size_t channels = j->s->n_channels > 2 * j->s->n_drawn ? j->s->n_channels : 2 * j->s->n_drawn;
    j->worker = calloc((size_t)threads, sizeof *j->worker);
    for (int t = 0; t < threads && j->worker; t++) {
        worker *w = &j->worker[t];
        w->beams = calloc(1, sizeof *w->beams);
        if (w->beams) w->beams->values = malloc(channels * FF_BEAMS * sizeof *w->beams->values);
        w->sum = malloc(j->o->pixels * j->sets * 3 * sizeof *w->sum);
        w->drawn = malloc(8 * FF_BEAMS * sizeof *w->drawn);
        if (!w->beams || !w->beams->values || !w->sum || !w->drawn) return FF_ERR_MEMORY;
        w->radiance = w->drawn + 3 * FF_BEAMS;
        w->density = w->drawn + 6 * FF_BEAMS;
        w->across = w->drawn + 7 * FF_BEAMS;
    }
    j->variance = calloc(j->o->pixels, sizeof *j->variance);
    j->light_sum = calloc(3 * j->o->pixels, sizeof *j->light_sum);
    j->count = calloc(j->o->pixels, sizeof *j->count);
    return j->worker && j->variance && j->light_sum && j->count ? FF_OK : FF_ERR_MEMORY;
}

static void free_job(ff_render_job *j, int threads)
{
    for (int t = 0; t < threads && j->worker; t++) {
        if (j->worker[t].beams) free(j->worker[t].beams->values);
        free(j->worker[t].beams);
        free(j->worker[t].sum);
        free(j->worker[t].drawn);
    }
    free(j->worker);
    free(j->variance);
    free(j->light_sum);
    free(j->count);
}

static void summarise(const ff_render_job *j, int threads, ff_render_summary *out)
{
    double variance = 0, n = 0;
    size_t values = 0, guessed = 0, unknown = 0;
    *out = (ff_render_summary){.samples = j->o->environment ? 2 * j->sets * j->points : 0};
    for (size_t row = 0; row < j->o->pixels; row++) {
        variance += j->variance[row];
        n += (double)j->count[row];
        for (size_t c = 0; c < 3; c++) out->mean[c] += j->light_sum[3 * row + c];
    }
    for (int t = 0; t < threads; t++) {
        values += j->worker[t].beams->n_values;
        guessed += j->worker[t].beams->n_guessed;
        unknown += j->worker[t].beams->n_unknown;
    }
    double coverage = 0;
    for (size_t k = 0; k < j->o->pixels * j->o->pixels; k++) coverage += (double)j->rgba[4 * k + 3];
    for (size_t c = 0; c < 3; c++) out->mean[c] = coverage > 0 ? out->mean[c] / coverage : 0;
    out->error = n > 0 ? sqrt(variance / (3 * n)) : 0;
    out->guessed = values ? (double)guessed / (double)values : 0;
    out->unknown = values ? (double)unknown / (double)values : 0;
}

static void choose_points(ff_render_job *j)
{
    const size_t pairs = (j->o->samples + 1) / 2;
    j->sets = j->o->environment ? (j->o->samples < SETS_FROM ? SETS_FEW : SETS_MANY) : 1;
    j->points = j->o->environment ? (pairs + j->sets - 1) / j->sets : 1;
}

ff_status ff_render_surface(const ff_surface *s, const ff_render_options *o, float *rgba, ff_render_summary *out)
{
    const int threads = o->threads ? o->threads : ff_threads_default();
    ff_pool *pool = ff_pool_new(threads);
    ff_render_job j = {.s = s, .o = o, .camera = ff_camera_of(o->perspective), .rgba = rgba};
    choose_points(&j);
    for (size_t l = 0; l < o->n_lights; l++) {
        const double *v = o->light[l], most = fmax(fabs(v[0]), fmax(fabs(v[1]), fabs(v[2])));
        const double x = v[0] / most, y = v[1] / most, z = v[2] / most, length = sqrt(x * x + y * y + z * z);
        j.light[l][0] = x / length, j.light[l][1] = y / length, j.light[l][2] = z / length;
    }
    ff_status status = pool ? make_workers(&j, threads) : FF_ERR_MEMORY;
    if (status == FF_OK) ff_pool_run(pool, o->pixels, render_row, &j);
    if (status == FF_OK && o->cancel && *o->cancel) status = FF_ERR_CANCELLED;
    if (status == FF_OK && out) summarise(&j, threads, out);
    free_job(&j, threads);
    ff_pool_free(pool);
    return status;
}
