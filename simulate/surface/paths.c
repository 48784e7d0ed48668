/* Paths of light on a tile, and the cones that count where they go. */
#include "internal_surface.h"
#include "base/internal_vector_math.h"
#include "simulate/walk/internal_walk.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

static const uint32_t kind_begin = 0x73757266, kind_scatter = 0x73636174;
enum { MOST_STEPS = 1 << 20 };

/* ---- cones ----------------------------------------------------------------------------------- */

enum { GRID = 64 };
struct ff_cones {
    size_t n, begin[GRID * GRID + 1], *cone; /* those of a cell of the grid, cell after cell */
    const double *const *wo;
    double least; /* cosine of the half angle */
};

static int cell_at(double x)
{
    const int c = (int)floor((x + 1) * (0.5 * GRID));
    return c < 0 ? 0 : c < GRID ? c : GRID - 1;
}

/* Calls for every cell that a cone may reach: counts it, or puts it there. */
static void sort_in(ff_cones *c, const double *const wo[3], double reach, size_t *place)
{
    for (size_t k = 0; k < c->n; k++)
        for (int y = cell_at(wo[1][k] - reach); y <= cell_at(wo[1][k] + reach); y++)
            for (int x = cell_at(wo[0][k] - reach); x <= cell_at(wo[0][k] + reach); x++) {
                size_t *at = &place[y * GRID + x];
                if (c->cone) c->cone[*at] = k;
                (*at)++;
            }
}

ff_cones *ff_cones_new(size_t n, const double *const wo[3], double half_angle)
{
    const double reach = 2 * sin(0.5 * half_angle) + 1e-9;
    ff_cones *c = calloc(1, sizeof *c);
    size_t *place = calloc(GRID * GRID, sizeof *place), sum = 0;
    if (c && place) {
        c->n = n;
        c->wo = wo;
        c->least = cos(half_angle);
        sort_in(c, wo, reach, place);
        for (size_t k = 0; k < GRID * GRID; k++) {
            c->begin[k] = sum;
            sum += place[k];
            place[k] = c->begin[k];
        }
        c->begin[GRID * GRID] = sum;
        c->cone = malloc((sum + 1) * sizeof *c->cone);
        if (c->cone) sort_in(c, wo, reach, place);
    }
    free(place);
    if (c && c->cone) return c;
    free(c);
    return NULL;
}

void ff_cones_free(ff_cones *c)
{
    if (c) free(c->cone);
    free(c);
}

void ff_cones_add(const ff_cones *c, const double r[3], size_t n_channels, const double *weight, size_t stride, double *sum)
{
    const size_t cell = (size_t)(cell_at(r[1]) * GRID + cell_at(r[0]));
    for (size_t k = c->begin[cell]; k < c->begin[cell + 1]; k++) {
        const size_t i = c->cone[k];
        if (r[0] * c->wo[0][i] + r[1] * c->wo[1][i] + r[2] * c->wo[2][i] < c->least) continue;
        for (size_t ch = 0; ch < n_channels; ch++) sum[ch * c->n + i] += weight[ch * stride];
    }
}

/* ---- paths ----------------------------------------------------------------------------------- */

typedef struct lanes {
    ff_flights f;
    uint64_t id[FF_BLOCK];
    uint32_t step[FF_BLOCK], order[FF_BLOCK];
    double turn[2][FF_BLOCK]; /* cosine and sine of the azimuth that the light was turned by */
    double c[FF_BLOCK], F[FF_BLOCK];
    size_t met[FF_BLOCK];
    double *weight; /* [n_channels][FF_BLOCK] */
} lanes;

static void begin(const ff_paths *p, lanes *l, size_t k, uint64_t begun)
{
    double u[4];
    ff_height_field_random(p->s->o.seed, p->first + begun, 0, kind_begin, u);
    const double turn = p->turned ? 2 * FF_PI * u[2] : 0, c = cos(turn), s = sin(turn);
    l->f.p[0][k] = u[0] * p->tile->length[0];
    l->f.p[1][k] = u[1] * p->tile->length[1];
    l->f.p[2][k] = p->tile->highest + p->tile->skin;
    l->f.r[0][k] = -(c * p->wi[0] - s * p->wi[1]);
    l->f.r[1][k] = -(s * p->wi[0] + c * p->wi[1]);
    l->f.r[2][k] = -p->wi[2];
    l->f.fate[k] = FF_FLIES;
    l->turn[0][k] = c;
    l->turn[1][k] = s;
    l->id[k] = p->first + begun;
    l->step[k] = l->order[k] = 0;
    for (size_t ch = 0; ch < p->s->n_channels; ch++) l->weight[ch * FF_BLOCK + k] = 1;
}

/* Evenly about m, density cosine over pi (the basis of Duff et al. 2017). */
static void scatter(const ff_paths *p, lanes *l, size_t k)
{
    double u[4];
    ff_height_field_random(p->s->o.seed, l->id[k], l->order[k], kind_scatter, u);
    const double side = sqrt(u[0]), x = side * cos(2 * FF_PI * u[1]), y = side * sin(2 * FF_PI * u[1]), high = sqrt(1 - u[0]);
    const double mx = l->f.m[0][k], my = l->f.m[1][k], mz = l->f.m[2][k], a = -1 / (1 + mz), b = mx * my * a;
    l->f.r[0][k] = x * (1 + mx * mx * a) + y * b + high * mx;
    l->f.r[1][k] = x * b + y * (1 + my * my * a) + high * my;
    l->f.r[2][k] = -x * mx - y * my + high * mz;
}

static void reflect(const ff_paths *p, lanes *l)
{
    const ff_height_field *s = p->s;
    ff_geometry g = {{NULL}};
    size_t n = 0;
    for (size_t k = 0; k < l->f.n; k++) {
        if (l->f.fate[k] != FF_MEETS) continue;
        const double c = -(l->f.r[0][k] * l->f.m[0][k] + l->f.r[1][k] * l->f.m[1][k] + l->f.r[2][k] * l->f.m[2][k]);
        l->met[n] = k;
        l->c[n++] = c < 1 ? c : 1;
        l->order[k]++;
        if (s->o.facets == FF_FACETS_LAMBERT) {
            scatter(p, l, k);
            continue;
        }
        for (int j = 0; j < 3; j++) l->f.r[j][k] += 2 * c * l->f.m[j][k];
        const double inv = 1 / sqrt(pow(l->f.r[0][k], 2) + pow(l->f.r[1][k], 2) + pow(l->f.r[2][k], 2));
        for (int j = 0; j < 3; j++) l->f.r[j][k] *= inv;
    }
    g.plane[FF_G_C] = l->c;
    for (size_t ch = 0; ch < s->n_channels && n; ch++) {
        const double *own = s->channel + ch * s->model.n_channel;
        if (s->o.facets == FF_FACETS_LAMBERT)
            for (size_t i = 0; i < n; i++) l->F[i] = own[s->model.base[0].channel0];
        else
            s->fresnel->eval(own + s->model.lobe[0].channel0, &g, n, l->F, NULL);
        for (size_t i = 0; i < n; i++) l->weight[ch * FF_BLOCK + l->met[i]] *= l->F[i];
    }
}

static void leave(ff_paths *p, const lanes *l, size_t k)
{
    const ff_height_field *s = p->s;
    const double c = l->turn[0][k], sine = l->turn[1][k], x = l->f.r[0][k], y = l->f.r[1][k];
    const double r[3] = {c * x + sine * y, c * y - sine * x, l->f.r[2][k]};
    for (size_t g = 0; g < s->o.n_orders; g++) {
        const ff_orders o = s->o.orders[g];
        if (l->order[k] < o.first || (o.last && l->order[k] > o.last)) continue;
        if (p->cones) {
            ff_cones_add(p->cones, r, s->n_channels, l->weight + k, FF_BLOCK, p->sum + g * s->n_channels * p->cones->n);
            continue;
        }
        for (size_t ch = 0; ch < s->n_channels; ch++) {
            double *sum = p->sum + (g * s->n_channels + ch) * FF_SURFACE_SUMS;
            const double weight = l->weight[ch * FF_BLOCK + k];
            sum[FF_SURFACE_W] += weight;
            for (int j = 0; j < 3; j++) sum[FF_SURFACE_WR + j] += weight * r[j];
        }
    }
}

static int is_over(ff_paths *p, lanes *l, size_t k)
{
    double most = 0;
    if (l->f.fate[k] == FF_LEAVES) leave(p, l, k);
    if (l->f.fate[k] == FF_LEAVES) return 1;
    if (l->f.fate[k] == FF_MEETS && l->order[k] > p->s->last && l->order[k] <= FF_WALK_MOST) return 1; /* nothing asks for it */
    for (size_t ch = 0; ch < p->s->n_channels; ch++) most = fmax(most, l->weight[ch * FF_BLOCK + k]);
    if (!(most > FF_WALK_LEAST)) return 1;
    if (l->f.fate[k] != FF_IS_LOST && l->order[k] <= FF_WALK_MOST && ++l->step[k] < MOST_STEPS) return 0;
    p->lost += most;
    return 1;
}

static void move(const ff_paths *p, lanes *l, size_t from, size_t to)
{
    if (from == to) return;
    for (int j = 0; j < 3; j++) {
        l->f.p[j][to] = l->f.p[j][from];
        l->f.r[j][to] = l->f.r[j][from];
    }
    for (int j = 0; j < 2; j++) l->turn[j][to] = l->turn[j][from];
    l->f.fate[to] = l->f.fate[from];
    l->id[to] = l->id[from];
    l->step[to] = l->step[from];
    l->order[to] = l->order[from];
    for (size_t ch = 0; ch < p->s->n_channels; ch++) l->weight[ch * FF_BLOCK + to] = l->weight[ch * FF_BLOCK + from];
}

static void run(ff_paths *p, lanes *l)
{
    uint64_t begun = 0;
    l->f.n = 0;
    for (;;) {
        while (l->f.n < FF_BLOCK && begun < p->n) begin(p, l, l->f.n++, begun++);
        if (l->f.n == 0) break;
        ff_tile_trace(p->tile, &l->f);
        reflect(p, l);
        for (size_t k = l->f.n; k-- > 0;)
            if (is_over(p, l, k)) move(p, l, --l->f.n, k);
    }
}

/* Without memory for its lanes a part of the paths is lost, which is said. */
void ff_paths_run(ff_paths *p)
{
    lanes *l = malloc(sizeof *l + p->s->n_channels * FF_BLOCK * sizeof(double));
    if (!l) {
        p->lost = INFINITY;
        return;
    }
    l->weight = (double *)(l + 1);
    run(p, l);
    free(l);
}
