/* Surfaces: what they can be made of, realisation after realisation with the paths of each shared out among threads, and what the
 * differences between realisations say of errors. */
#include "internal_surface.h"
#include "base/internal_options.h"
#include "base/internal_vector_math.h"
#include "simulate/walk/internal_walk.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { ITEM_PATHS = 16384 };
static const uint32_t kind_point = 0x706f696e;

/* ---- what a surface is made of --------------------------------------------------------------- */

static ff_status refuse(ff_error *err, const char *what)
{
    return ff_error_set(err, FF_ERR_UNSUPPORTED, NULL, 0, -1, "a traced surface %s", what);
}

static ff_status check_model(const ff_model *m, size_t n_channels, const double *shape, const double *channel,
                             const ff_height_field_options *o, ff_error *err)
{
    ff_lobe_pass pass;
    if (m->n_lobes != 1) return refuse(err, "needs a model of one lobe: its facets are of one kind");
    if (strcmp(ff_masking_at(m->lobe[0].masking)->term.name, "smith-height-correlated"))
        return refuse(err, "makes its own masking: leave that of the model out");
    if (!o->map && strcmp(ff_ndf_at(m->lobe[0].ndf)->term.name, "beckmann"))
        return refuse(err, "of Gaussian heights has Gaussian slopes, the distribution beckmann, and no other");
    ff_model_lobe(m, 0, shape, &pass, NULL);
    if (pass.s.x0 != 0 || pass.s.y0 != 0) return refuse(err, "has no mean slope: leave slope_x and slope_y at 0");
    for (size_t c = 0; c < n_channels; c++)
        if (channel[c * m->n_channel + m->lobe[0].channel0 + m->lobe[0].n_channel - 1] != 1)
            return refuse(err, "has no scale: leave ks at 1");
    if (o->facets == FF_FACETS_MIRROR)
        return m->n_bases ? refuse(err, "of mirrors has nothing under them: leave the diffuse term out") : FF_OK;
    if (m->n_bases != 1 || strcmp(ff_diffuse_at(m->base[0].diffuse)->term.name, "lambert"))
        return refuse(err, "whose facets scatter takes their kd from the model's term lambert, and no other: +lambert");
    return FF_OK;
}

static ff_status fill(ff_height_field *s, const double *shape, ff_error *err)
{
    const ff_stretch *t = &s->prepared.lobe[0].s;
    ff_status status = s->o.map ? ff_heights_read(s->o.map, s->o.pitch, s->o.height_unit, &s->map, err) : FF_OK;
    if (!status) status = ff_rays_get(&s->rays, err);
    if (status) return status;
    status = ff_prepare(&s->model, ff_kernels_get(FF_ISA_BEST), FF_CHEAPEST_MODE, s->n_channels, shape, s->channel, NULL, 0,
                        INFINITY, &s->prepared);
    if (status) return ff_error_set(err, status, NULL, 0, -1, "the model cannot be made ready: %s", ff_status_str(status));
    s->fresnel = s->prepared.kernels->fresnel[s->model.lobe[0].fresnel];
    s->l[0] = t->ax;
    s->l[1] = t->r * t->ay;
    s->l[2] = t->ay * sqrt((1 - t->r) * (1 + t->r));
    s->isotropic = !s->o.map && t->ax == t->ay && t->r == 0;
    for (size_t k = 0; k < s->o.n_orders; k++) {
        const uint32_t last = s->o.orders[k].last ? s->o.orders[k].last : FF_WALK_MOST;
        s->last = last > s->last ? last : s->last;
    }
    return FF_OK;
}

ff_status ff_height_field_new(const ff_model *m, size_t n_channels, const double *shape, const double *channel,
                              const ff_height_field_options *o, ff_height_field **out, ff_error *err)
{
    ff_height_field_options own;
    ff_height_field_options_init(&own);
    ff_status status = o ? ff_options_take("ff_height_field_options", o, FF_END_OF(ff_height_field_options, progress_context), &own,
                                           sizeof own, err)
                         : FF_OK;
    if (!status) status = ff_height_field_check(&own, err);
    if (!status) status = ff_model_check(m, n_channels, shape, channel, err);
    if (!status) status = check_model(m, n_channels, shape, channel, &own, err);
    if (status) return status;
    ff_height_field *s = calloc(1, sizeof *s);
    if (s) s->channel = malloc((n_channels * m->n_channel + 1) * sizeof *s->channel);
    if (!s || !s->channel) {
        ff_height_field_free(s);
        return ff_error_set(err, FF_ERR_MEMORY, NULL, 0, -1, "no memory for a surface of %zu channels", n_channels);
    }
    s->model = *m;
    s->o = own;
    s->n_channels = n_channels;
    memcpy(s->channel, channel, n_channels * m->n_channel * sizeof *channel);
    status = fill(s, shape, err);
    if (status) {
        ff_height_field_free(s);
        return status;
    }
    s->o.map = own.map ? "" : NULL; /* the name was borrowed; the heights are here */
    *out = s;
    return FF_OK;
}

void ff_height_field_free(ff_height_field *s)
{
    if (!s) return;
    ff_prepared_free(&s->prepared);
    free(s->map.h);
    free(s->channel);
    free(s);
}

int ff_height_field_is_isotropic(const ff_height_field *s)
{
    return s->isotropic;
}

static int is_up(double x, double y, double z)
{
    return z > FF_COS_MIN && fabs(x * x + y * y + z * z - 1) < 1e-8;
}

static ff_status not_up(ff_error *err, size_t k)
{
    return ff_error_set(err, FF_ERR_RANGE, NULL, 0, -1, "direction %zu: expected a unit vector above the horizon", k);
}

/* ---- realisations ---------------------------------------------------------------------------- */

/* What is done with each; part: the number of the realisation. */
typedef struct study study;
typedef ff_status (*study_one)(study *s, const ff_tile *tile, uint64_t part, ff_error *err);
struct study {
    const ff_height_field *s;
    ff_pool *pool;
    study_one each;
    void *own;
};

static ff_status heights_of(const ff_height_field *s, uint64_t part, ff_heights *out, ff_error *err)
{
    if (!s->o.map) return ff_heights_draw(s->rays, &s->o, s->l, part, out, err);
    const size_t n = s->map.nx * s->map.ny;
    *out = s->map;
    out->h = malloc(n * sizeof *out->h);
    if (!out->h) return ff_error_set(err, FF_ERR_MEMORY, NULL, 0, -1, "no memory for %zu heights", n);
    memcpy(out->h, s->map.h, n * sizeof *out->h);
    return FF_OK;
}

static ff_status run(const ff_height_field *s, study_one each, void *own, ff_error *err)
{
    study work = {s, ff_pool_new(s->o.threads ? s->o.threads : ff_threads_default()), each, own};
    ff_tile tile = {.rays = NULL};
    ff_status status = work.pool ? FF_OK : ff_error_set(err, FF_ERR_MEMORY, NULL, 0, -1, "no memory for threads");
    for (uint64_t part = 0; part < s->o.realisations && !status; part++) {
        ff_heights heights;
        if (part == 0 || !s->o.map) {
            ff_tile_clear(&tile);
            status = heights_of(s, part, &heights, err);
            if (!status) status = ff_tile_make(s->rays, &heights, &tile, err);
        }
        if (!status) status = each(&work, &tile, part, err);
        if (!status && s->o.cancel && *s->o.cancel)
            status = ff_error_set(err, FF_ERR_CANCELLED, NULL, 0, -1, "cancelled after realisation %d", (int)part + 1);
        if (!status && s->o.progress) s->o.progress(s->o.progress_context, (double)(part + 1) / (double)s->o.realisations);
    }
    ff_tile_clear(&tile);
    if (work.pool) ff_pool_free(work.pool);
    return status;
}

/* Paths of a direction in a realisation: as even as can be. */
static uint64_t paths_of(const ff_height_field *s, uint64_t part)
{
    return s->o.paths / s->o.realisations + (part < s->o.paths % s->o.realisations);
}

static void run_item(void *context, size_t k, int worker)
{
    (void)worker;
    ff_paths_run((ff_paths *)context + k);
}

/* Runs `all` paths like p, adding `n` sums of p->sum and what is lost. id: of the first path. */
static ff_status run_paths(const study *work, const ff_paths *p, uint64_t id, uint64_t all, size_t n, double *lost, ff_error *err)
{
    const size_t items = (size_t)((all + ITEM_PATHS - 1) / ITEM_PATHS), round = (size_t)ff_pool_threads(work->pool) * 4;
    double *sums = malloc(round * n * sizeof *sums);
    ff_paths *item = malloc(round * sizeof *item);
    ff_status status = sums && item ? FF_OK : ff_error_set(err, FF_ERR_MEMORY, NULL, 0, -1, "no memory for %zu sums", n);
    for (size_t at = 0; at < items && !status; at += round) {
        const size_t count = items - at < round ? items - at : round;
        memset(sums, 0, count * n * sizeof *sums);
        for (size_t k = 0; k < count; k++) {
            const uint64_t first = (uint64_t)(at + k) * ITEM_PATHS;
            item[k] = *p;
            item[k].first = id + first;
            item[k].n = all - first < ITEM_PATHS ? all - first : ITEM_PATHS;
            item[k].sum = sums + k * n;
        }
        ff_pool_run(work->pool, count, run_item, item);
        for (size_t k = 0; k < count; k++) {
            if (isinf(item[k].lost)) status = ff_error_set(err, FF_ERR_MEMORY, NULL, 0, -1, "no memory for paths");
            for (size_t i = 0; i < n; i++) p->sum[i] += sums[k * n + i];
            *lost += item[k].lost;
        }
    }
    free(item);
    free(sums);
    return status;
}

/* Standard error of the mean of n numbers by their sum and that of their squares. */
static double error_of(double sum, double square, double n)
{
    return sqrt(fmax(square / n - sum / n * (sum / n), 0) / (n - 1));
}

/* ---- lobes ----------------------------------------------------------------------------------- */

/* own: sums of each realisation, [realisations][n directions][planes][FF_SURFACE_SUMS], then what is lost [n] */
typedef struct lobes {
    const double *wi;
    size_t n, each;
    double *sum, *lost;
} lobes;

static ff_status lobes_one(study *work, const ff_tile *tile, uint64_t part, ff_error *err)
{
    lobes *own = work->own;
    ff_status status = FF_OK;
    for (size_t k = 0; k < own->n && !status; k++) {
        ff_paths p = {work->s, tile, {own->wi[k], own->wi[own->n + k], own->wi[2 * own->n + k]}, 0, 0, 0, NULL, NULL, 0};
        const uint64_t paths = paths_of(work->s, part);
        p.sum = own->sum + (part * own->n + k) * own->each;
        status = run_paths(work, &p, (part * own->n + k) * (work->s->o.paths / work->s->o.realisations + 1), paths, own->each,
                           &own->lost[k], err);
        for (size_t i = 0; i < own->each; i++) p.sum[i] /= (double)paths;
    }
    return status;
}

/* Of one direction and plane: sums a stride apart. The mean direction is a ratio, whose error is that of its numerator less the
 * mean times the denominator. */
static ff_lobe_mean lobe_of(const double *sum, size_t stride, size_t parts)
{
    ff_lobe_mean out;
    double w = 0, ww = 0, r[3] = {0}, rest = 0;
    for (size_t p = 0; p < parts; p++) {
        const double *s = sum + p * stride;
        w += s[FF_SURFACE_W];
        ww += s[FF_SURFACE_W] * s[FF_SURFACE_W];
        for (int j = 0; j < 3; j++) r[j] += s[FF_SURFACE_WR + j];
    }
    out.albedo = w / (double)parts;
    out.albedo_error = error_of(w, ww, (double)parts);
    for (int j = 0; j < 3; j++) {
        out.mean[j] = w > 0 ? r[j] / w : NAN;
        rest = 0;
        for (size_t p = 0; p < parts; p++)
            rest += pow(sum[p * stride + FF_SURFACE_WR + (size_t)j] - out.mean[j] * sum[p * stride], 2);
        out.mean_error[j] = w > 0 ? sqrt(rest * (double)parts / (double)(parts - 1)) / w : NAN;
    }
    return out;
}

ff_status ff_height_field_lobes(const ff_height_field *s, const double *wi, size_t n, ff_lobe_mean *lobe, double *lost,
                                ff_error *err)
{
    const size_t planes = s->o.n_orders * s->n_channels, parts = s->o.realisations, each = planes * FF_SURFACE_SUMS;
    for (size_t k = 0; k < n; k++)
        if (!is_up(wi[k], wi[n + k], wi[2 * n + k])) return not_up(err, k);
    lobes own = {wi, n, each, calloc(parts * n * each + n + 1, sizeof *own.sum), NULL};
    if (!own.sum) return ff_error_set(err, FF_ERR_MEMORY, NULL, 0, -1, "no memory for %zu directions", n);
    own.lost = own.sum + parts * n * each;
    const ff_status status = run(s, lobes_one, &own, err);
    for (size_t k = 0; k < n && !status; k++) {
        for (size_t g = 0; g < planes; g++)
            lobe[k * planes + g] = lobe_of(own.sum + k * each + g * FF_SURFACE_SUMS, n * each, parts);
        if (lost) lost[k] = own.lost[k] / (double)s->o.paths;
    }
    free(own.sum);
    return status;
}

/* ---- values ---------------------------------------------------------------------------------- */

typedef struct values {
    const ff_dirs *w;
    size_t n, planes;
    int isotropic;
    double *one, *sum, *square; /* [planes][n]; one: of the realisation at hand */
    uint64_t groups;
} values;

/* The end of the pairs from `at` on that have the same wi. */
static size_t same_light(const ff_dirs *w, size_t n, size_t at)
{
    size_t end = at + 1;
    while (end < n && w->wix[end] == w->wix[at] && w->wiy[end] == w->wiy[at] && w->wiz[end] == w->wiz[at]) end++;
    return end;
}

static ff_status values_of_light(study *work, const ff_tile *tile, uint64_t part, size_t at, size_t end, uint64_t group,
                                 ff_error *err)
{
    values *own = work->own;
    const ff_height_field *s = work->s;
    const double *wo[3] = {own->w->wox + at, own->w->woy + at, own->w->woz + at},
                 solid = 4 * FF_PI * pow(sin(0.5 * s->o.aperture), 2);
    const size_t n = end - at;
    const uint64_t paths = paths_of(s, part);
    double lost = 0;
    ff_cones *cones = ff_cones_new(n, wo, s->o.aperture);
    double *sum = calloc(own->planes * n, sizeof *sum);
    ff_paths p = {s,   tile, {own->w->wix[at], own->w->wiy[at], own->w->wiz[at]}, own->isotropic && s->isotropic, 0, 0, cones,
                  sum, 0};
    ff_status status = cones && sum ? run_paths(work, &p, (part * own->groups + group) * (s->o.paths / s->o.realisations + 1),
                                                paths, own->planes * n, &lost, err)
                                    : ff_error_set(err, FF_ERR_MEMORY, NULL, 0, -1, "no memory for %zu pairs", n);
    for (size_t k = 0; k < own->planes && !status; k++)
        for (size_t i = 0; i < n; i++) {
            const double f = sum[k * n + i] / ((double)paths * solid * wo[2][i]);
            own->sum[k * own->n + at + i] += f;
            own->square[k * own->n + at + i] += f * f;
        }
    free(sum);
    ff_cones_free(cones);
    return status;
}

static ff_status values_one(study *work, const ff_tile *tile, uint64_t part, ff_error *err)
{
    const values *own = work->own;
    ff_status status = FF_OK;
    uint64_t group = 0;
    for (size_t at = 0, end; at < own->n && !status; at = end) {
        end = same_light(own->w, own->n, at);
        status = values_of_light(work, tile, part, at, end, group++, err);
    }
    return status;
}

ff_status ff_height_field_values(const ff_height_field *s, const ff_dirs *w, size_t n, int isotropic, double *f, double *error,
                                 size_t ld, ff_error *err)
{
    const size_t planes = s->o.n_orders * s->n_channels;
    if (ld < n) return ff_error_set(err, FF_ERR_RANGE, NULL, 0, -1, "planes of %zu values for %zu pairs", ld, n);
    for (size_t k = 0; k < n; k++)
        if (!is_up(w->wix[k], w->wiy[k], w->wiz[k]) || !is_up(w->wox[k], w->woy[k], w->woz[k])) return not_up(err, k);
    values own = {w, n, planes, isotropic, NULL, calloc(2 * planes * n + 1, sizeof *own.sum), NULL, 0};
    if (!own.sum) return ff_error_set(err, FF_ERR_MEMORY, NULL, 0, -1, "no memory for %zu values", planes * n);
    own.square = own.sum + planes * n;
    for (size_t at = 0; at < n; at = same_light(w, n, at)) own.groups++;
    const ff_status status = run(s, values_one, &own, err);
    const double parts = (double)s->o.realisations;
    for (size_t k = 0; k < planes && !status; k++)
        for (size_t i = 0; i < n; i++) {
            f[k * ld + i] = own.sum[k * n + i] / parts;
            error[k * ld + i] = error_of(own.sum[k * n + i], own.square[k * n + i], parts);
        }
    free(own.sum);
    return status;
}

/* ---- what is seen ---------------------------------------------------------------------------- */

enum { SEEN_FACING, SEEN_ONE, SEEN_BOTH_FACING, SEEN_BOTH, SEEN_SUMS };
typedef struct looks {
    const double *w;
    size_t n;
    double *sum; /* [realisations][n][SEEN_SUMS] */
} looks;

/* Points of one direction, a block of them. */
typedef struct look {
    const ff_height_field *s;
    const ff_tile *tile;
    double w[3], sum[SEEN_SUMS];
    uint64_t id;
    size_t n;
} look;

/* Which of the rays of f leave; all are followed to their ends. */
static void follow(const ff_tile *tile, ff_flights *f, size_t n, int *left)
{
    size_t who[FF_BLOCK];
    for (size_t k = 0; k < n; k++) who[k] = k, left[k] = 0;
    for (f->n = n; f->n > 0;) {
        ff_tile_trace(tile, f);
        for (size_t k = f->n; k-- > 0;) {
            if (f->fate[k] == FF_FLIES) continue;
            left[who[k]] = f->fate[k] == FF_LEAVES;
            f->n--;
            who[k] = who[f->n];
            for (int j = 0; j < 3; j++) f->p[j][k] = f->p[j][f->n], f->r[j][k] = f->r[j][f->n];
            f->fate[k] = f->fate[f->n];
        }
    }
}

static void look_at_block(look *l, size_t first, size_t n, ff_flights *f)
{
    double area[FF_BLOCK], p[3][FF_BLOCK], m[3];
    int faces[2][FF_BLOCK], left[2][FF_BLOCK];
    for (size_t k = 0; k < n; k++) {
        double u[4], at[3];
        ff_height_field_random(l->s->o.seed, l->id + first + k, 0, kind_point, u);
        const double x = u[0] * (double)l->tile->heights.nx, y = u[1] * (double)l->tile->heights.ny;
        const size_t i = (size_t)x, j = (size_t)y;
        const int upper = u[2] >= 0.5, over = u[3] + (x - (double)i) > 1;
        const double a = over ? 1 - u[3] : u[3], b = over ? 1 - (x - (double)i) : x - (double)i;
        ff_tile_point(l->tile, i < l->tile->heights.nx ? i : 0, j < l->tile->heights.ny ? j : 0, upper, a, b, at, m);
        area[k] = 1 / m[2];
        faces[0][k] = m[0] * l->w[0] + m[1] * l->w[1] + m[2] * l->w[2] > 0;
        faces[1][k] = -m[0] * l->w[0] - m[1] * l->w[1] + m[2] * l->w[2] > 0;
        for (int c = 0; c < 3; c++) p[c][k] = at[c];
    }
    for (int side = 0; side < 2; side++) {
        for (int c = 0; c < 3; c++)
            for (size_t k = 0; k < n; k++) {
                f->p[c][k] = p[c][k];
                f->r[c][k] = side && c < 2 ? -l->w[c] : l->w[c];
            }
        follow(l->tile, f, n, left[side]);
    }
    for (size_t k = 0; k < n; k++) {
        const int both = faces[0][k] && faces[1][k];
        l->sum[SEEN_FACING] += area[k] * faces[0][k];
        l->sum[SEEN_ONE] += area[k] * (faces[0][k] && left[0][k]);
        l->sum[SEEN_BOTH_FACING] += area[k] * both;
        l->sum[SEEN_BOTH] += area[k] * (both && left[0][k] && left[1][k]);
    }
}

static void look_item(void *context, size_t k, int worker)
{
    (void)worker;
    look *l = (look *)context + k;
    ff_flights *f = malloc(sizeof *f);
    for (size_t at = 0; f && at < l->n; at += FF_BLOCK) look_at_block(l, at, l->n - at < FF_BLOCK ? l->n - at : FF_BLOCK, f);
    if (!f) l->sum[0] = NAN;
    free(f);
}

static ff_status looks_one(study *work, const ff_tile *tile, uint64_t part, ff_error *err)
{
    const looks *own = work->own;
    const uint64_t all = paths_of(work->s, part);
    const size_t items = (size_t)((all + ITEM_PATHS - 1) / ITEM_PATHS);
    ff_status status = FF_OK;
    look *item = malloc(items * sizeof *item);
    if (!item) return ff_error_set(err, FF_ERR_MEMORY, NULL, 0, -1, "no memory for %zu parts", items);
    for (size_t k = 0; k < own->n && !status; k++) {
        for (size_t i = 0; i < items; i++) {
            const uint64_t first = (uint64_t)i * ITEM_PATHS, left = all - first;
            item[i] = (look){work->s, tile, {own->w[k], own->w[own->n + k], own->w[2 * own->n + k]}, {0}, 0, 0};
            item[i].id = (part * own->n + k) * (work->s->o.paths / work->s->o.realisations + 1) + first;
            item[i].n = (size_t)(left < ITEM_PATHS ? left : ITEM_PATHS);
        }
        ff_pool_run(work->pool, items, look_item, item);
        for (size_t i = 0; i < items; i++) {
            if (isnan(item[i].sum[0])) status = ff_error_set(err, FF_ERR_MEMORY, NULL, 0, -1, "no memory for rays");
            for (int c = 0; c < SEEN_SUMS; c++) own->sum[(part * own->n + k) * SEEN_SUMS + (size_t)c] += item[i].sum[c];
        }
    }
    free(item);
    return status;
}

/* A ratio of sums over realisations, and its error. */
static void ratio(const double *top, const double *bottom, size_t stride, size_t parts, double *value, double *error)
{
    double a = 0, b = 0, rest = 0;
    for (size_t p = 0; p < parts; p++) a += top[p * stride], b += bottom[p * stride];
    *value = b > 0 ? a / b : NAN;
    for (size_t p = 0; p < parts; p++) rest += pow(top[p * stride] - *value * bottom[p * stride], 2);
    *error = b > 0 ? sqrt(rest * (double)parts / (double)(parts - 1)) / b : NAN;
}

ff_status ff_height_field_seen(const ff_height_field *s, const double *w, size_t n, ff_seen *seen, ff_error *err)
{
    const size_t parts = s->o.realisations;
    for (size_t k = 0; k < n; k++)
        if (!is_up(w[k], w[n + k], w[2 * n + k])) return not_up(err, k);
    looks own = {w, n, calloc(parts * n * SEEN_SUMS + 1, sizeof *own.sum)};
    if (!own.sum) return ff_error_set(err, FF_ERR_MEMORY, NULL, 0, -1, "no memory for %zu directions", n);
    const ff_status status = run(s, looks_one, &own, err);
    for (size_t k = 0; k < n && !status; k++) {
        const double *sum = own.sum + k * SEEN_SUMS;
        ratio(sum + SEEN_ONE, sum + SEEN_FACING, n * SEEN_SUMS, parts, &seen[k].g1, &seen[k].g1_error);
        ratio(sum + SEEN_BOTH, sum + SEEN_BOTH_FACING, n * SEEN_SUMS, parts, &seen[k].g2, &seen[k].g2_error);
    }
    free(own.sum);
    return status;
}

/* ---- slopes ---------------------------------------------------------------------------------- */

typedef struct slopes {
    size_t n;
    double *ring, *moments; /* [realisations][n], [realisations][4] */
} slopes;

/* D of a ring is the area of the facets whose normals lie in it, over the plane and the ring's solid angle. */
static ff_status slopes_one(study *work, const ff_tile *tile, uint64_t part, ff_error *err)
{
    const slopes *own = work->own;
    const ff_heights *h = &tile->heights;
    double *ring = own->ring + part * own->n;
    (void)err;
    ff_heights_moments(h, own->moments + 4 * part);
    for (size_t j = 0; j < h->ny && own->n; j++)
        for (size_t i = 0; i < h->nx; i++)
            for (int k = 0; k < 2; k++) {
                double x, y;
                ff_heights_slopes(h, i, j, k, &x, &y);
                const double tan2 = x * x + y * y;
                const size_t at = (size_t)(atan(sqrt(tan2)) * (2 / FF_PI) * (double)own->n);
                ring[at < own->n ? at : own->n - 1] += sqrt(1 + tan2) / (2 * (double)h->nx * (double)h->ny);
            }
    return FF_OK;
}

/* A number of each realisation: their mean and its error. */
static void mean_of(const double *x, size_t stride, size_t parts, double *mean, double *error)
{
    double sum = 0, square = 0;
    for (size_t p = 0; p < parts; p++) sum += x[p * stride], square += x[p * stride] * x[p * stride];
    *mean = sum / (double)parts;
    *error = error_of(sum, square, (double)parts);
}

ff_status ff_height_field_slopes(const ff_height_field *s, ff_slopes *out, size_t n, double *d, double *d_error, ff_error *err)
{
    const size_t parts = s->o.realisations;
    if (d && (n < 1 || n > 900)) return ff_error_set(err, FF_ERR_RANGE, NULL, 0, -1, "rings: %zu, expected 1 to 900", n);
    slopes own = {d ? n : 0, calloc(parts * ((d ? n : 0) + 4), sizeof *own.ring), NULL};
    if (!own.ring) return ff_error_set(err, FF_ERR_MEMORY, NULL, 0, -1, "no memory for %zu rings", n);
    own.moments = own.ring + parts * own.n;
    const ff_status status = run(s, slopes_one, &own, err);
    double fourth = 0, second = 0, ignored;
    for (size_t p = 0; p < parts && !status; p++) { /* of each realisation: alpha_x, alpha_y, r_xy */
        double *m = own.moments + 4 * p;
        fourth += m[3];
        second += m[0];
        m[2] /= sqrt(m[0] * m[1]);
        m[0] = sqrt(2 * m[0]);
        m[1] = sqrt(2 * m[1]);
    }
    if (!status) {
        mean_of(own.moments, 4, parts, &out->alpha_x, &out->alpha_x_error);
        mean_of(own.moments + 1, 4, parts, &out->alpha_y, &out->alpha_y_error);
        mean_of(own.moments + 2, 4, parts, &out->r_xy, &out->r_xy_error);
        out->kurtosis = fourth * (double)parts / (second * second);
    }
    for (size_t k = 0; k < own.n && !status; k++) {
        const double solid =
            2 * FF_PI * (cos(0.5 * FF_PI * (double)k / (double)n) - cos(0.5 * FF_PI * (double)(k + 1) / (double)n));
        mean_of(own.ring + k, own.n, parts, &d[k], d_error ? &d_error[k] : &ignored);
        d[k] /= solid;
        if (d_error) d_error[k] /= solid;
    }
    free(own.ring);
    return status;
}
