/* A sphere under a few lights, as the data and as a model have it. */
#include "picture_struct.h"
#include "base/internal_options.h"
#include "ff_interpolate.h"
#include "fit/problem/internal_problem.h"
#include "models/tools/internal_sphere.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

static const double pi = 3.14159265358979323846;

enum { FF_PICTURE_PIXELS = FF_PICTURE_SIZE * FF_PICTURE_SIZE, FF_PICTURE_PIECE = 128 /* pixels a thread takes at a time */ };

/* The pixels of all lights that have data, one after another. */
struct ff_picture {
    size_t n, n_channels;
    double *w[6];     /* [n] pairs of directions                       */
    double *radiance; /* [n_channels][n] f cos(theta_i) of the table   */
    double exposure;
    ff_picture_coverage coverage;
    ff_isa isa;
};

/* ---- the scene ------------------------------------------------------------------------------- */

void ff_picture_light(size_t k, double light[3])
{
    const double from_view = (15 + 30 * (double)k) * pi / 180, azimuth = (60 + 72 * (double)k) * pi / 180;
    light[0] = sin(from_view) * cos(azimuth);
    light[1] = sin(from_view) * sin(azimuth);
    light[2] = cos(from_view);
}

size_t ff_picture_directions(const double light[3], double max_theta, double *const w[6], size_t *pixel)
{
    static const double view[3] = {0, 0, 1};
    if (!(max_theta > 0 && max_theta <= FF_HORIZON)) return 0;
    const double cos_max = fmax(cos(max_theta) * (1 - 1e-12), FF_COS_MIN);
    size_t count = 0;
    for (size_t j = 0; j < FF_PICTURE_SIZE; j++)
        for (size_t i = 0; i < FF_PICTURE_SIZE; i++) {
            double n[3], wi[3], wo[3];
            if (!ff_sphere_point(ff_sphere_x(FF_PICTURE_SIZE, i), ff_sphere_y(FF_PICTURE_SIZE, j), n)) continue;
            ff_sphere_to_surface(n, light, wi);
            ff_sphere_to_surface(n, view, wo);
            if (!(wi[2] >= cos_max && wo[2] >= cos_max)) continue;
            for (size_t k = 0; k < 3 && w; k++) w[k][count] = wi[k], w[k + 3][count] = wo[k];
            if (pixel) pixel[count] = j * FF_PICTURE_SIZE + i;
            count++;
        }
    return count;
}

double ff_picture_tone(double exposed)
{
    const double e = fmax(exposed, 0), t = e < 1e300 ? e / (1 + e) : 1;
    return t <= 0.0031308 ? 12.92 * t : 1.055 * pow(t, 1 / 2.4) - 0.055;
}

/* ---- the pictures of a table ----------------------------------------------------------------- */

/* The table at every pixel. */
typedef struct look_up {
    const ff_interpolant *interpolant;
    const ff_fit_options *o;
    const double *const *w;
    size_t n, n_channels;
    double *value; /* [n_channels][n] */
    unsigned char *found;
    double *buffer; /* [threads][n_channels][FF_PICTURE_PIECE] */
} look_up;

static void look_up_piece(void *context, size_t piece, int worker)
{
    const look_up *l = context;
    const size_t first = piece * FF_PICTURE_PIECE, n = l->n - first < FF_PICTURE_PIECE ? l->n - first : FF_PICTURE_PIECE;
    double *values = l->buffer + (size_t)worker * l->n_channels * FF_PICTURE_PIECE;
    const double *w[6];
    if (ff_fit_cancelled(l->o)) return;
    for (size_t k = 0; k < 6; k++) w[k] = l->w[k] + first;
    ff_interpolant_eval_reciprocal(l->interpolant, w, n, values, l->found + first);
    for (size_t c = 0; c < l->n_channels; c++) {
        memcpy(l->value + c * l->n + first, values + c * n, n * sizeof *values);
        for (size_t i = 0; i < n; i++) /* as the fit has it: what is not finite is no measurement */
            if (!isfinite(values[c * n + i])) l->found[first + i] = FF_FOUND_BELOW;
    }
}

static ff_status look_up_all(look_up *l)
{
    const int threads = l->o->threads ? l->o->threads : ff_threads_default();
    ff_pool *pool = ff_pool_new(threads);
    l->buffer = malloc((size_t)threads * l->n_channels * FF_PICTURE_PIECE * sizeof *l->buffer);
    if (pool && l->buffer) ff_pool_run(pool, (l->n + FF_PICTURE_PIECE - 1) / FF_PICTURE_PIECE, look_up_piece, l);
    const ff_status status = !pool || !l->buffer ? FF_ERR_MEMORY : ff_fit_cancelled(l->o) ? FF_ERR_CANCELLED : FF_OK;
    free(l->buffer);
    ff_pool_free(pool);
    return status;
}

/* Of a scan in the plane of incidence nothing is known beside it, and nearly all of a picture is: what the interpolant makes of the
 * scan there serves every loss alike. */
static int has_data(const look_up *l, unsigned char found)
{
    return found != FF_FOUND_BELOW && (found != FF_FOUND_BEYOND || ff_interpolant_is_in_plane(l->interpolant));
}

/* Channel c of the picture at pixel i of the table's values [n_channels][n]: one of the table's, or their mean. */
static double pixel_value(const double *value, size_t n, size_t n_channels, const ff_fit_options *o, size_t c, size_t i)
{
    double sum = 0;
    if (o->only_channel >= 0) return value[(size_t)o->only_channel * n + i];
    if (o->channels != FF_CHANNELS_MEAN) return value[c * n + i];
    for (size_t k = 0; k < n_channels; k++) sum += value[k * n + i];
    return sum / (double)n_channels;
}

/* Keeps the pixels that have data. */
static ff_status keep_measured(ff_picture *p, const look_up *l)
{
    size_t n = 0;
    for (size_t i = 0; i < l->n; i++) p->n += (size_t)has_data(l, l->found[i]);
    p->coverage = (ff_picture_coverage){l->n, p->n};
    for (size_t k = 0; k < 6; k++)
        if (!(p->w[k] = malloc((p->n + 1) * sizeof *p->w[k]))) return FF_ERR_MEMORY;
    p->radiance = malloc((p->n * p->n_channels + 1) * sizeof *p->radiance);
    if (!p->radiance) return FF_ERR_MEMORY;
    for (size_t i = 0; i < l->n; i++) {
        if (!has_data(l, l->found[i])) continue;
        for (size_t k = 0; k < 6; k++) p->w[k][n] = l->w[k][i];
        for (size_t c = 0; c < p->n_channels; c++)
            p->radiance[c * p->n + n] = pixel_value(l->value, l->n, l->n_channels, l->o, c, i) * l->w[2][i];
        n++;
    }
    return FF_OK;
}

static int ascending(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* The quantile of the largest channel becomes 1; the brightest pixel does where so much of the pictures is black. */
static ff_status expose(ff_picture *p, ff_error *err)
{
    double *largest = malloc(p->n * sizeof *largest);
    if (!largest) return FF_ERR_MEMORY;
    for (size_t i = 0; i < p->n; i++) {
        largest[i] = p->radiance[i];
        for (size_t c = 1; c < p->n_channels; c++) largest[i] = fmax(largest[i], p->radiance[c * p->n + i]);
    }
    qsort(largest, p->n, sizeof *largest, ascending);
    double white = largest[(size_t)(FF_PICTURE_QUANTILE * (double)(p->n - 1))];
    if (!(white > 0)) white = largest[p->n - 1];
    free(largest);
    if (!(white > 0))
        return ff_error_set(err, FF_ERR_DATA, NULL, 0, -1,
                            "no pixel of the pictures that choose the loss is brighter than 0: name a loss instead of auto");
    p->exposure = 1 / white;
    return FF_OK;
}

/* w [6][FF_PICTURE_LIGHTS FF_PICTURE_PIXELS], planes; how many pixels. */
static size_t all_lights(double max_theta, double *const w[6])
{
    size_t n = 0;
    for (size_t k = 0; k < FF_PICTURE_LIGHTS; k++) {
        double light[3], *at[6];
        for (size_t plane = 0; plane < 6; plane++) at[plane] = w[plane] + n;
        ff_picture_light(k, light);
        n += ff_picture_directions(light, max_theta, at, NULL);
    }
    return n;
}

static ff_status look_at_table(ff_picture *p, const ff_table *t, const ff_fit_options *o, ff_error *err)
{
    const size_t most = FF_PICTURE_LIGHTS * FF_PICTURE_PIXELS;
    double *planes = malloc(6 * most * sizeof *planes), *w[6];
    ff_interpolant *interpolant = NULL;
    look_up l = {.o = o, .w = (const double *const *)w, .n_channels = t->n_channels};
    ff_status status = planes ? ff_interpolant_new(t, 0, &interpolant, err) : FF_ERR_MEMORY;
    if (!status) {
        for (size_t k = 0; k < 6; k++) w[k] = planes + k * most;
        l.n = all_lights(o->max_theta, w);
        l.interpolant = interpolant;
        l.value = malloc((l.n * l.n_channels + 1) * sizeof *l.value);
        l.found = malloc(l.n + 1);
        status = l.value && l.found ? look_up_all(&l) : FF_ERR_MEMORY;
    }
    if (!status) status = keep_measured(p, &l);
    free(l.value);
    free(l.found);
    free(planes);
    ff_interpolant_free(interpolant);
    if (!status && p->n == 0)
        return ff_error_set(
            err, FF_ERR_DATA, NULL, 0, -1,
            "the data say nothing of any pixel of the pictures that choose the loss (a sphere under %d lights, angles "
            "up to %g degrees): name a loss instead of auto",
            FF_PICTURE_LIGHTS, round(o->max_theta * 180 / pi * 1e6) / 1e6);
    return status ? status : expose(p, err);
}

ff_status ff_picture_new(const ff_table *t, const ff_fit_options *o, ff_picture **out, ff_error *err)
{
    ff_fit_options own;
    o = ff_fit_options_take(o, &own, err);
    ff_status status = o ? ff_fit_options_check(o, err) : FF_ERR_RANGE;
    if (status) return status;
    if (o->only_channel >= 0 && (size_t)o->only_channel >= t->n_channels)
        return ff_error_set(err, FF_ERR_RANGE, NULL, 0, -1, "channel %d does not exist: the data have %zu", o->only_channel,
                            t->n_channels);
    ff_picture *p = calloc(1, sizeof *p);
    if (!p) return ff_error_set(err, FF_ERR_MEMORY, NULL, 0, -1, "out of memory");
    p->n_channels = o->only_channel >= 0 || o->channels == FF_CHANNELS_MEAN ? 1 : t->n_channels;
    p->isa = o->isa;
    status = look_at_table(p, t, o, err);
    if (status == FF_ERR_MEMORY) ff_error_set(err, status, NULL, 0, -1, "out of memory");
    if (status == FF_ERR_CANCELLED) ff_error_set(err, status, NULL, 0, -1, "cancelled");
    if (status)
        ff_picture_free(p);
    else
        *out = p;
    return status;
}

void ff_picture_free(ff_picture *p)
{
    if (!p) return;
    for (size_t k = 0; k < 6; k++) free(p->w[k]);
    free(p->radiance);
    free(p);
}

ff_picture_coverage ff_picture_covered(const ff_picture *p)
{
    return p->coverage;
}

size_t ff_picture_channels(const ff_picture *p)
{
    return p->n_channels;
}

double ff_picture_exposure(const ff_picture *p)
{
    return p->exposure;
}

double ff_picture_black(const ff_picture *p)
{
    const size_t total = p->n * p->n_channels;
    double sum = 0;
    for (size_t k = 0; k < total; k++) {
        const double d = ff_picture_tone(p->exposure * p->radiance[k]);
        sum += d * d;
    }
    return sqrt(sum / (double)total);
}

/* ---- and of a model -------------------------------------------------------------------------- */

ff_status ff_picture_difference(const ff_picture *p, const ff_model *m, const double *shape, const double *channel, double *out,
                                ff_error *err)
{
    const size_t n = p->n, total = n * p->n_channels;
    const ff_dirs w = {p->w[0], p->w[1], p->w[2], p->w[3], p->w[4], p->w[5]};
    double *f = malloc(total * sizeof *f), sum = 0;
    if (!f) return ff_error_set(err, FF_ERR_MEMORY, NULL, 0, -1, "out of memory");
    ff_status status = ff_model_check(m, p->n_channels, shape, channel, err);
    if (!status && (status = ff_model_eval(m, p->isa, p->n_channels, shape, channel, &w, n, f, NULL, n)))
        ff_error_set(err, status, NULL, 0, -1, "the model's picture failed: %s", ff_status_str(status));
    for (size_t k = 0; k < total && !status; k++) {
        const double d = ff_picture_tone(p->exposure * f[k] * p->w[2][k % n]) - ff_picture_tone(p->exposure * p->radiance[k]);
        sum += d * d;
    }
    free(f);
    if (!status) *out = sqrt(sum / (double)total);
    return status;
}
