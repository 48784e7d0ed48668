/* The steps of many paths at once. Compiled once per instruction set.
 *
 * The unit surface: slopes u of density p(|u|^2), s = L u, L L^T = [[ax^2, r ax ay], [r ax ay, ay^2]]. To a ray that comes from w
 * the facet of slope u shows V = w.m / m.z = v0 - l.u, with l = L^T w, v0 = w.z; all facets together N = integral of p V+. That is
 * below
 *
 *   M = v0+ + |l| E[q] / pi,  since (v0 - l.u)+ <= v0+ + |l| q (-cos psi)+
 *
 * psi the angle between u and l. So rays meet candidates at the rate M, drawn from one of the two parts of that bound, and fly past
 * a candidate but for a chance of V+ over the bound (Woodcock, Murphy, Hemmings and Longworth 1965). Per unit of ln C the rate is
 * M / |w.z|: rays that go up rise in C, and leave where C > 1. */
#include "internal_walk.h"
#include "base/internal_philox.h"
#include "base/internal_vector_math.h"

#define ff_walk_run FF_ISA_NAME(ff_walk_run)
static const uint32_t kind_flight = 0x77616c6b, kind_facet = 0x66616365; /* streams of their own beside those of noise */

/* ---- random numbers -------------------------------------------------------------------------- */

/* Four numbers in (0, 1) for each lane of a list, or for all when the list is NULL. */
static void draw(const ff_walk_setting *s, const ff_walk_lanes *l, uint32_t kind, const size_t *lane, size_t n,
                 double (*restrict u)[FF_BLOCK])
{
    const uint32_t key[2] = {(uint32_t)s->seed, (uint32_t)(s->seed >> 32)};
    for (size_t i = 0; i < n; i++) {
        const size_t at = lane ? lane[i] : i;
        const uint32_t counter[4] = {(uint32_t)l->id[at], (uint32_t)(l->id[at] >> 32), l->step[at], kind};
        uint32_t word[4];
        ff_philox(counter, key, word);
        for (int k = 0; k < 4; k++) u[k][i] = ((double)word[k] + 0.5) * 0x1p-32;
    }
}

/* ---- flight ---------------------------------------------------------------------------------- */

/* What the unit surface sees of each ray, and v = (alpha tan theta)^2. */
static void view(const ff_walk_setting *s, ff_walk_lanes *l)
{
    for (size_t i = 0; i < l->n; i++) {
        const double lx = s->l11 * l->w[0][i] + s->l21 * l->w[1][i], ly = s->l22 * l->w[1][i], v0 = l->w[2][i];
        const double l2 = lx * lx + ly * ly, some = l2 > 1e-280 ? l2 : 1e-280, inv = ff_rsqrt(some), len = some * inv;
        const double steep = fabs(v0) > 1e-29 * len ? fabs(v0) : 1e-29 * len, v = some / (steep * steep);
        l->lx[i] = l2 > 1e-280 ? lx * inv : 1;
        l->ly[i] = l2 > 1e-280 ? ly * inv : 0;
        l->len[i] = len;
        l->up[i] = v0 > 0 ? v0 : 0;
        l->v[i] = v < FF_V_MIN ? FF_V_MIN : v > 1e60 ? 1e60 : v;
        l->rate[i] = l->up[i] + len * s->mean;
    }
}

/* Rays that go down after their first facet, as rays that go up: N Lambda / (1 + Lambda) in place of N. */
static void slow_descent(const ff_walk_setting *s, ff_walk_lanes *l)
{
    s->ndf->lambda(s->pass, l->n, l->v, l->lam, l->dlam, NULL);
    for (size_t i = 0; i < l->n; i++) {
        const double part = l->lam[i] / (1 + l->lam[i]);
        if (l->w[2][i] > 0 && l->order[i] > 0) l->rate[i] *= part > 1e-300 ? part : 1e-300;
    }
}

/* The depth of the next candidate; above 0 the ray has left. Then which part of the bound it is of, as the number of its table. */
static void fly(const ff_walk_setting *s, ff_walk_lanes *l)
{
    const double least = 0x1p-34;
    for (size_t i = 0; i < l->n; i++) {
        const double whole = l->up[i] + l->len[i] * s->mean, at = l->u[1][i] * whole, along = whole - l->up[i];
        const int second = at >= l->up[i];
        double u = second ? (at - l->up[i]) / along : at / l->up[i];
        l->next[i] = l->depth[i] + l->w[2][i] * ff_log(l->u[0][i]) / l->rate[i];
        u = u > least ? u : least;
        u = u < 1 - least ? u : 1 - least;
        double t = (ff_log(u) - ff_log(1 - u) + FF_WALK_T) * (FF_WALK_BINS / (2 * FF_WALK_T));
        t = t > 0 ? t : 0;
        t = t < FF_WALK_BINS - 1e-9 ? t : FF_WALK_BINS - 1e-9;
        l->met[i] = second;
        l->q[i] = t;
    }
}

static void radius(const ff_walk_setting *s, ff_walk_lanes *l)
{
    const double *c = s->radial[0].c[0];
    for (size_t i = 0; i < l->n; i++) {
        const int32_t bin = (int32_t)l->q[i], from = bin + (l->met[i] > 0 ? 4 * FF_WALK_BINS : 0);
        const double x = l->q[i] - bin;
        l->q[i] = c[from] + x * (c[from + FF_WALK_BINS] + x * (c[from + 2 * FF_WALK_BINS] + x * c[from + 3 * FF_WALK_BINS]));
    }
    for (size_t i = 0; i < l->n; i++) l->q[i] = ff_exp(l->q[i]);
}

/* The slope of the candidate, and whether the ray meets it. */
static void candidate(const ff_walk_setting *s, ff_walk_lanes *l)
{
    for (size_t i = 0; i < l->n; i++) {
        double sine, cosine;
        ff_sincos(2 * FF_PI * l->u[2][i], &sine, &cosine);
        const double side = 2 * l->u[2][i] - 1, rest = 1 - side * side, inv = ff_rsqrt(rest > 1e-30 ? rest : 1e-30);
        const int second = l->met[i] > 0;
        const double y = second ? side : sine, x = second ? -rest * inv : cosine;
        const double q = l->q[i], lq = l->len[i] * q, seen = l->w[2][i] - lq * x, bound = l->up[i] + (x < 0 ? -lq * x : 0);
        const double ux = q * (x * l->lx[i] - y * l->ly[i]), uy = q * (x * l->ly[i] + y * l->lx[i]);
        l->sx[i] = s->l11 * ux;
        l->sy[i] = s->l21 * ux + s->l22 * uy;
        l->met[i] = l->next[i] <= 0 && l->u[3][i] * bound < seen;
    }
}

/* ---- facets that were met -------------------------------------------------------------------- */

/* Their normals, and where each ray came from. */
static void gather(ff_walk_lanes *l)
{
    size_t n = 0;
    for (size_t i = 0; i < l->n; i++) {
        l->lane[n] = i;
        n += l->met[i] > 0;
    }
    l->n_met = n;
    for (size_t k = 0; k < n; k++) {
        const size_t i = l->lane[k];
        const double inv = ff_rsqrt(1 + l->sx[i] * l->sx[i] + l->sy[i] * l->sy[i]);
        l->h[0][k] = -l->sx[i] * inv;
        l->h[1][k] = -l->sy[i] * inv;
        l->h[2][k] = inv;
        for (int j = 0; j < 3; j++) l->from[j][k] = l->w[j][i];
        const double c = l->from[0][k] * l->h[0][k] + l->from[1][k] * l->h[1][k] + l->from[2][k] * l->h[2][k];
        l->c[k] = c < 1 ? c : 1;
    }
}

static void fresnel_at(const ff_walk_setting *s, size_t channel, double *c, size_t n, double *F)
{
    ff_geometry g = {{NULL}};
    g.plane[FF_G_C] = c;
    s->fresnel->eval(s->channel + channel * s->stride, &g, n, F, NULL);
}

static void add(const ff_walk_setting *s, ff_walk_lanes *l, size_t channel, const double *restrict value)
{
    for (size_t k = 0; k < l->n_met; k++) {
        const size_t i = l->lane[k];
        const double x = l->weight[channel * FF_BLOCK + i] * value[k];
        for (size_t g = 0; g < s->n_orders; g++)
            if (l->order[i] >= s->orders[g].first && (s->orders[g].last == 0 || l->order[i] <= s->orders[g].last))
                l->sum[(g * s->n_channels + channel) * FF_BLOCK + i] += x;
    }
}

/* wo of the pair of each facet, and C^Lambda(wo) / wo.z: the part of it that leaves. */
static void outwards(const ff_walk_item *item, ff_walk_lanes *l)
{
    for (size_t k = 0; k < l->n_met; k++) {
        const size_t i = l->lane[k], pair = item->pair + l->pair[i];
        l->to[0][k] = item->w->wox[pair];
        l->to[1][k] = item->w->woy[pair];
        l->to[2][k] = item->w->woz[pair];
        l->leave[k] = ff_exp(l->next[i] * l->lambda_o[l->pair[i]]) / l->to[2][k];
    }
}

/* F D(h) / (4 N) for the h between a ray and wo. */
static void mirror_to(const ff_walk_setting *s, ff_walk_lanes *l)
{
    const double inv11 = 1 / s->l11, inv22 = 1 / s->l22, inv_det = inv11 * inv22;
    double half[FF_BLOCK], shown[FF_BLOCK], area[FF_BLOCK];
    for (size_t k = 0; k < l->n_met; k++) l->g[k] = l->v[l->lane[k]];
    s->ndf->lambda(s->pass, l->n_met, l->g, l->lam, l->dlam, NULL);
    for (size_t k = 0; k < l->n_met; k++) {
        const double hx = l->from[0][k] + l->to[0][k], hy = l->from[1][k] + l->to[1][k], hz = l->from[2][k] + l->to[2][k];
        const double up = hz > 1e-100 ? 1 / hz : 0, sx = -hx * up, sy = -hy * up;
        const double ux = sx * inv11, uy = (sy - s->l21 * ux) * inv22, inv_hz2 = 1 + sx * sx + sy * sy;
        l->q2[k] = ux * ux + uy * uy;
        const double length2 = hx * hx + hy * hy + hz * hz;
        half[k] = 0.5 * length2 * ff_rsqrt(length2 > 1e-200 ? length2 : 1e-200);
        half[k] = half[k] < 1 ? half[k] : 1;
        const double wz = l->from[2][k], N = wz > 0 ? wz * (1 + l->lam[k]) : -wz * l->lam[k];
        area[k] = hz > 1e-100 ? 0.25 * inv_det * inv_hz2 * inv_hz2 : 0;
        shown[k] = N > 1e-290 ? l->leave[k] / N : 0;
    }
    s->ndf->profile(s->pass, l->n_met, l->q2, l->p, l->dlnp, NULL);
    for (size_t c = 0; c < s->n_channels; c++) {
        fresnel_at(s, c, half, l->n_met, l->F);
        for (size_t k = 0; k < l->n_met; k++) l->g[k] = l->F[k] * l->p[k] * area[k] * shown[k];
        add(s, l, c, l->g);
    }
}

/* kd <wo, m> / pi, with what the ways in and out of a coupled facet let through. */
static void scatter_to(const ff_walk_setting *s, ff_walk_lanes *l)
{
    double out[FF_BLOCK], cosine[FF_BLOCK];
    for (size_t k = 0; k < l->n_met; k++) {
        const double c = l->to[0][k] * l->h[0][k] + l->to[1][k] * l->h[1][k] + l->to[2][k] * l->h[2][k];
        cosine[k] = c > 0 ? (c < 1 ? c : 1) : 0;
    }
    for (size_t c = 0; c < s->n_channels; c++) {
        for (size_t k = 0; k < l->n_met; k++) out[k] = s->kd[c] * (1 / FF_PI) * cosine[k] * l->leave[k];
        if (s->facets == FF_FACETS_COUPLED) {
            fresnel_at(s, c, cosine, l->n_met, l->F);
            for (size_t k = 0; k < l->n_met; k++) out[k] *= cosine[k] > 0 ? s->share[c] * (1 - l->F[k]) : 0;
            fresnel_at(s, c, l->c, l->n_met, l->F);
            for (size_t k = 0; k < l->n_met; k++) out[k] *= 1 - l->F[k];
        }
        add(s, l, c, out);
    }
}

/* ---- where a ray goes ------------------------------------------------------------------------ */

/* Mirrored, r = 2 (w.m) m - w; in `to`. */
static void mirror(ff_walk_lanes *l)
{
    for (size_t k = 0; k < l->n_met; k++)
        for (int j = 0; j < 3; j++) l->to[j][k] = 2 * l->c[k] * l->h[j][k] - l->from[j][k];
}

/* Evenly about the normal, where the facet does not mirror: the density is the cosine over pi (Pixar's basis about m, Duff et al.
 * 2017; m.z > 0). */
static void scatter(ff_walk_lanes *l, double (*u)[FF_BLOCK])
{
    for (size_t k = 0; k < l->n_met; k++) {
        double sine, cosine;
        ff_sincos(2 * FF_PI * u[1][k], &sine, &cosine);
        const double side = sqrt(u[0][k]), high = sqrt(1 - u[0][k]), x = side * cosine, y = side * sine;
        const double mx = l->h[0][k], my = l->h[1][k], mz = l->h[2][k], a = -1 / (1 + mz), b = mx * my * a;
        if (l->mirrored[k] > 0) continue;
        l->to[0][k] = x * (1 + mx * mx * a) + y * b + high * mx;
        l->to[1][k] = x * b + y * (1 + my * my * a) + high * my;
        l->to[2][k] = -x * mx - y * my + high * mz;
    }
}

/* What a channel still has after the facet; chance: of what the path did. */
static void weigh(const ff_walk_setting *s, ff_walk_lanes *l, size_t c)
{
    double *weight = l->weight + c * FF_BLOCK, *back = l->q2; /* cosine of the way out */
    if (s->facets == FF_FACETS_LAMBERT) {
        for (size_t k = 0; k < l->n_met; k++) weight[l->lane[k]] *= s->kd[c];
        return;
    }
    fresnel_at(s, c, l->c, l->n_met, l->F);
    if (s->facets == FF_FACETS_MIRROR) {
        for (size_t k = 0; k < l->n_met; k++) weight[l->lane[k]] *= l->F[k];
        return;
    }
    for (size_t k = 0; k < l->n_met; k++) {
        const double cosine = l->to[0][k] * l->h[0][k] + l->to[1][k] * l->h[1][k] + l->to[2][k] * l->h[2][k];
        back[k] = cosine > 0 ? (cosine < 1 ? cosine : 1) : 0;
    }
    fresnel_at(s, c, back, l->n_met, l->p);
    for (size_t k = 0; k < l->n_met; k++) {
        const double scattered = (1 - l->F[k]) * (1 - l->p[k]) * s->share[c] * s->kd[c];
        weight[l->lane[k]] *= (l->mirrored[k] > 0 ? l->F[k] : scattered) / l->chance[k];
    }
}

/* Of a coupled facet: mirrored with a chance that is about its part of the light, neither way below a tenth. */
static void choose(const ff_walk_setting *s, ff_walk_lanes *l, double (*u)[FF_BLOCK])
{
    double mirrored[FF_BLOCK] = {0}, scattered[FF_BLOCK] = {0};
    for (size_t k = 0; k < l->n_met; k++) {
        l->mirrored[k] = 0;
        l->chance[k] = 1;
    }
    if (s->facets == FF_FACETS_LAMBERT) return;
    for (size_t c = 0; c < s->n_channels; c++) {
        fresnel_at(s, c, l->c, l->n_met, l->F);
        for (size_t k = 0; k < l->n_met; k++) {
            mirrored[k] += l->F[k];
            scattered[k] += (1 - l->F[k]) * s->kd[c];
        }
    }
    for (size_t k = 0; k < l->n_met; k++) {
        const double all = mirrored[k] + scattered[k], part = all > 0 ? mirrored[k] / all : 0.5;
        const double chance = part < 0.1 ? 0.1 : part > 0.9 ? 0.9 : part;
        l->mirrored[k] = u[2][k] < chance;
        l->chance[k] = l->mirrored[k] > 0 ? chance : 1 - chance;
    }
}

static void reflect(const ff_walk_setting *s, const ff_walk_item *item, ff_walk_lanes *l)
{
    for (size_t k = 0; k < l->n_met; k++) l->order[l->lane[k]]++;
    if (item->sum) {
        outwards(item, l);
        if (s->facets != FF_FACETS_LAMBERT) mirror_to(s, l);
        if (s->facets != FF_FACETS_MIRROR) scatter_to(s, l);
    }
    mirror(l);
    if (s->facets != FF_FACETS_MIRROR) {
        double u[4][FF_BLOCK];
        draw(s, l, kind_facet, l->lane, l->n_met, u);
        choose(s, l, u);
        scatter(l, u);
    }
    for (size_t c = 0; c < s->n_channels; c++) weigh(s, l, c);
    for (size_t k = 0; k < l->n_met; k++) {
        const size_t i = l->lane[k];
        const double x = l->to[0][k], y = l->to[1][k], z = l->to[2][k], inv = ff_rsqrt(x * x + y * y + z * z);
        l->w[0][i] = -x * inv; /* roundings of a thousand facets would add up */
        l->w[1][i] = -y * inv;
        l->w[2][i] = -z * inv;
    }
}

/* ---- the life of a path ---------------------------------------------------------------------- */

static void begin(const ff_walk_setting *s, const ff_walk_item *item, ff_walk_lanes *l, size_t i, uint64_t begun)
{
    const size_t at = (size_t)(begun / item->n_paths), pair = item->pair + at;
    l->w[0][i] = item->w->wix[pair];
    l->w[1][i] = item->w->wiy[pair];
    l->w[2][i] = item->w->wiz[pair];
    l->depth[i] = 0;
    l->id[i] = (item->number + pair) * s->paths + item->path + begun % item->n_paths;
    l->step[i] = l->order[i] = 0;
    l->pair[i] = at;
    for (size_t c = 0; c < s->n_channels; c++) l->weight[c * FF_BLOCK + i] = 1;
    for (size_t k = 0; k < s->n_orders * s->n_channels; k++) l->sum[k * FF_BLOCK + i] = 0;
}

static void leave(const ff_walk_setting *s, const ff_walk_item *item, ff_walk_lanes *l, size_t i)
{
    const double r[3] = {-l->w[0][i], -l->w[1][i], -l->w[2][i]};
    for (size_t g = 0; g < s->n_orders && item->moments; g++) {
        if (l->order[i] < s->orders[g].first || (s->orders[g].last && l->order[i] > s->orders[g].last)) continue;
        for (size_t c = 0; c < s->n_channels; c++) {
            double *m = item->moments + (g * s->n_channels + c) * FF_WALK_SUMS;
            const double weight = l->weight[c * FF_BLOCK + i], square = weight * weight;
            m[FF_WALK_W] += weight;
            m[FF_WALK_WW] += square;
            for (int j = 0; j < 3; j++) {
                m[FF_WALK_WR + j] += weight * r[j];
                m[FF_WALK_WWR + j] += square * r[j];
                m[FF_WALK_WWRR + j] += square * r[j] * r[j];
            }
        }
    }
    if (item->leaves) item->leaves(item->context, l->order[i], r, l->weight + i);
}

/* A path that is over goes into the sums of its pair. */
static void finish(const ff_walk_setting *s, const ff_walk_item *item, const ff_walk_lanes *l, size_t i)
{
    for (size_t k = 0; k < s->n_orders * s->n_channels && item->sum; k++) {
        const double x = l->sum[k * FF_BLOCK + i];
        item->sum[k * item->n_pairs + l->pair[i]] += x;
        item->sum2[k * item->n_pairs + l->pair[i]] += x * x;
    }
}

/* What is in lane `from` also in lane `to`. */
static void move(const ff_walk_setting *s, ff_walk_lanes *l, size_t from, size_t to)
{
    if (from == to) return;
    for (int j = 0; j < 3; j++) l->w[j][to] = l->w[j][from];
    l->depth[to] = l->depth[from];
    l->id[to] = l->id[from];
    l->step[to] = l->step[from];
    l->order[to] = l->order[from];
    l->pair[to] = l->pair[from];
    for (size_t c = 0; c < s->n_channels; c++) l->weight[c * FF_BLOCK + to] = l->weight[c * FF_BLOCK + from];
    for (size_t k = 0; k < s->n_orders * s->n_channels; k++) l->sum[k * FF_BLOCK + to] = l->sum[k * FF_BLOCK + from];
}

static int is_over(const ff_walk_setting *s, const ff_walk_item *item, ff_walk_lanes *l, size_t i)
{
    double most = 0;
    if (l->next[i] > 0) {
        leave(s, item, l, i);
        return 1;
    }
    l->depth[i] = l->next[i];
    l->step[i]++;
    if (!(l->met[i] > 0)) return 0;
    for (size_t c = 0; c < s->n_channels; c++) most = fmax(most, l->weight[c * FF_BLOCK + i]);
    const int ended = !(most > FF_WALK_LEAST) || l->order[i] >= FF_WALK_MOST;
    for (size_t c = 0; c < s->n_channels && ended && item->lost; c++) item->lost[c] += l->weight[c * FF_BLOCK + i];
    return ended || l->order[i] >= s->last + (item->sum == NULL); /* of a direction the last order has to leave yet */
}

static void lambda_of_pairs(const ff_walk_setting *s, const ff_walk_item *item, ff_walk_lanes *l)
{
    for (size_t k = 0; k < item->n_pairs; k++) {
        const size_t pair = item->pair + k;
        const double lx = s->l11 * item->w->wox[pair] + s->l21 * item->w->woy[pair], ly = s->l22 * item->w->woy[pair];
        const double v = (lx * lx + ly * ly) / (item->w->woz[pair] * item->w->woz[pair]);
        l->v[k] = v < FF_V_MIN ? FF_V_MIN : v;
    }
    s->ndf->lambda(s->pass, item->n_pairs, l->v, l->lambda_o, l->dlam, NULL);
}

void ff_walk_run(const ff_walk_setting *s, const ff_walk_item *item, ff_walk_lanes *l)
{
    const uint64_t all = item->n_pairs * item->n_paths;
    uint64_t begun = 0;
    if (item->sum) lambda_of_pairs(s, item, l);
    l->n = 0;
    for (;;) {
        while (l->n < FF_BLOCK && begun < all) begin(s, item, l, l->n++, begun++);
        if (l->n == 0) break;
        draw(s, l, kind_flight, NULL, l->n, l->u);
        view(s, l);
        if (s->descent == FF_DESCENT_SYMMETRIC) slow_descent(s, l);
        fly(s, l);
        radius(s, l);
        candidate(s, l);
        gather(l);
        if (l->n_met > 0) reflect(s, item, l);
        for (size_t i = l->n; i-- > 0;) {
            if (!is_over(s, item, l, i)) continue;
            finish(s, item, l, i);
            move(s, l, --l->n, i);
        }
    }
}
