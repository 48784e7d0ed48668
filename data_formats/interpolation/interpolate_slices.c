/* Interpolation between samples that come in slices of one incident direction each. */
#include "internal_interpolate.h"
#include "data_formats/table/internal_table.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

static const double degrees = 180 / 3.14159265358979323846;

enum { LEAST_IN_SLICE = 12, MOST_SLICES = 4096 };

/* Half vector seen from an incident direction at azimuth 0 where the table is isotropic, else as it is. */
static void in_slice(int isotropic, const double wi[3], const double wo[3], double *theta_i, double *phi_i, double x[2])
{
    double q[4];
    const double h[3] = {wi[0] + wo[0], wi[1] + wo[1], wi[2] + wo[2]};
    ff_axes_point(FF_AXES_INCIDENT_EXIT, wi, h, q);
    const double turn = isotropic ? q[1] : 0;
    *theta_i = degrees * q[0];
    *phi_i = isotropic ? 0 : degrees * q[1];
    x[0] = degrees * q[2] * cos(q[3] - turn);
    x[1] = degrees * q[2] * sin(q[3] - turn);
}

/* ---- cutting slices -------------------------------------------------------------------------- */

/* A sample on its way into a slice. */
typedef struct placed {
    double theta_i, phi_i, x[2];
    uint32_t sample;
} placed;

typedef struct placing {
    int isotropic, mirrored;
    size_t n;
    placed *at;
} placing;

static void place(void *context, size_t i, const double wi[3], const double wo[3])
{
    placing *p = context;
    placed *s = &p->at[p->n++];
    in_slice(p->isotropic, wi, wo, &s->theta_i, &s->phi_i, s->x);
    if (s->theta_i < ff_same_incidence) s->phi_i = 0; /* the same direction at every azimuth */
    s->theta_i = round(s->theta_i / ff_same_incidence) * ff_same_incidence;
    s->phi_i = round(s->phi_i / ff_same_incidence) * ff_same_incidence;
    if (s->phi_i <= -180) s->phi_i += 360;
    s->sample = (uint32_t)i;
    if (!p->mirrored) return;
    p->at[p->n] = *s;
    p->at[p->n++].x[1] *= -1;
}

static int by_incidence(const void *a, const void *b)
{
    const placed *p = a, *q = b;
    if (p->theta_i != q->theta_i) return p->theta_i < q->theta_i ? -1 : 1;
    if (p->phi_i != q->phi_i) return p->phi_i < q->phi_i ? -1 : 1;
    return (p->sample > q->sample) - (p->sample < q->sample);
}

static size_t slice_end(const placing *p, size_t first)
{
    size_t end = first;
    while (end < p->n && p->at[end].theta_i == p->at[first].theta_i && p->at[end].phi_i == p->at[first].phi_i) end++;
    return end;
}

static int new_slice(ff_slice *s, const placed *at, size_t n)
{
    double *point = malloc(2 * n * sizeof *point);
    uint32_t *sample = malloc(n * sizeof *sample);
    *s = (ff_slice){at->theta_i, at->phi_i, NULL};
    if (point && sample) {
        for (size_t j = 0; j < n; j++) {
            memcpy(point + 2 * j, at[j].x, sizeof at[j].x);
            sample[j] = at[j].sample;
        }
        s->tree = ff_neighbours_new(2, n, point, sample);
    } else {
        free(point);
        free(sample);
    }
    return s->tree != NULL;
}

/* 1 when the samples come in slices, which p then has; 0 when not; -1 without memory. */
static int cut_slices(ff_interpolant *p, const placing *all)
{
    size_t slices = 0, thin = 0;
    for (size_t i = 0, end; i < all->n; i = end, slices++) {
        end = slice_end(all, i);
        if (end - i < LEAST_IN_SLICE) thin += end - i;
    }
    if (slices == 0 || slices > MOST_SLICES || thin > all->n / 20) return 0;
    p->slice = calloc(slices, sizeof *p->slice);
    if (!p->slice) return -1;
    for (size_t i = 0, end; i < all->n; i = end) {
        end = slice_end(all, i);
        if (end - i >= LEAST_IN_SLICE && !new_slice(&p->slice[p->n_slices++], all->at + i, end - i)) return -1;
    }
    return 1;
}

int ff_slices_find(ff_interpolant *p)
{
    placing all = {p->t->isotropic, p->mirrored, 0, malloc((p->mirrored ? 2 : 1) * p->t->n * sizeof *all.at)};
    if (!all.at) return -1;
    ff_each_usable(p->t, place, &all);
    qsort(all.at, all.n, sizeof *all.at, by_incidence);
    const int found = cut_slices(p, &all);
    free(all.at);
    return found;
}

/* ---- between slices -------------------------------------------------------------------------- */

/* Slices beside an incident direction with their shares. */
typedef struct beside {
    size_t n, index[4];
    double share[4];
    int outside; /* the direction is beyond all of them */
} beside;

static beside beside_theta(const ff_interpolant *p, double theta_i)
{
    size_t hi = 0;
    while (hi < p->n_slices && p->slice[hi].theta_i < theta_i - ff_same_incidence) hi++;
    if (hi < p->n_slices && fabs(p->slice[hi].theta_i - theta_i) <= ff_same_incidence) return (beside){1, {hi}, {1}, 0};
    if (hi == 0 || hi == p->n_slices) return (beside){1, {hi ? hi - 1 : 0}, {1}, 1};
    const double lower = p->slice[hi - 1].theta_i, u = (theta_i - lower) / (p->slice[hi].theta_i - lower);
    return (beside){2, {hi - 1, hi}, {1 - u, u}, 0};
}

/* One past the slices that have the theta_i of slice `first`: a ring. */
static size_t ring_end(const ff_interpolant *p, size_t first)
{
    size_t end = first;
    while (end < p->n_slices && p->slice[end].theta_i == p->slice[first].theta_i) end++;
    return end;
}

/* Adds the slices of a ring on both sides of an azimuth, linear in it; 0 when the azimuth lies in a gap of the ring. */
static int add_from_ring(const ff_interpolant *p, size_t first, size_t end, double phi_i, double share, beside *out)
{
    static const double widest_gap = 100; /* degrees */
    if (end - first == 1) {               /* the normal, or not a ring */
        out->index[out->n] = first;
        out->share[out->n++] = share;
        return p->slice[first].theta_i < ff_same_incidence;
    }
    double below = INFINITY, above = INFINITY;
    size_t lo = first, hi = first;
    for (size_t j = first; j < end; j++) {
        double up = fmod(p->slice[j].phi_i - phi_i, 360);
        if (up < 0) up += 360;
        const double down = up > 0 ? 360 - up : 0;
        if (up < above) above = up, hi = j;
        if (down < below) below = down, lo = j;
    }
    if (fmin(below, above) < ff_same_incidence) {
        out->index[out->n] = below < above ? lo : hi;
        out->share[out->n++] = share;
        return 1;
    }
    const int gap = below + above > widest_gap;
    const double u = gap ? (double)(above < below) : below / (below + above);
    const size_t side[2] = {lo, hi};
    for (int k = 0; k < 2; k++)
        if ((k ? u : 1 - u) > 0) {
            out->index[out->n] = side[k];
            out->share[out->n++] = share * (k ? u : 1 - u);
        }
    return !gap;
}

/* The slices of the rings below and above theta_i; 0 when the incident directions do not come in rings there. */
static int beside_rings(const ff_interpolant *p, double theta_i, double phi_i, beside *out)
{
    size_t lower = 0, upper = 0;
    while (ring_end(p, upper) < p->n_slices && p->slice[upper].theta_i < theta_i - ff_same_incidence) {
        lower = upper;
        upper = ring_end(p, upper);
    }
    const double a = p->slice[lower].theta_i, b = p->slice[upper].theta_i;
    const size_t lower_end = ring_end(p, lower), upper_end = ring_end(p, upper);
    const int is_upper = upper_end - upper >= 3 || b < ff_same_incidence,
              is_lower = lower_end - lower >= 3 || a < ff_same_incidence;
    *out = (beside){0};
    if (fabs(b - theta_i) <= ff_same_incidence || b < theta_i || a >= theta_i) { /* on a ring, or outside of them all */
        if (!is_upper) return 0;
        out->outside = !add_from_ring(p, upper, upper_end, phi_i, 1, out) || fabs(b - theta_i) > ff_same_incidence;
        return 1;
    }
    if (!is_upper || !is_lower) return 0;
    const double u = (theta_i - a) / (b - a);
    const int inside = add_from_ring(p, lower, lower_end, phi_i, 1 - u, out) & add_from_ring(p, upper, upper_end, phi_i, u, out);
    out->outside = !inside;
    return 1;
}

/* The nearest slice in each quadrant, seen from the direction along its meridian and across; inverse distances. Outside when one of
 * the outer quadrants is empty. */
static beside beside_quadrants(const ff_interpolant *p, double theta_i, double phi_i)
{
    double nearest[4] = {INFINITY, INFINITY, INFINITY, INFINITY};
    size_t index[4] = {0};
    const double a = phi_i / degrees;
    for (size_t j = 0; j < p->n_slices; j++) {
        const double b = p->slice[j].phi_i / degrees, r = p->slice[j].theta_i;
        const double along = r * cos(b - a) - theta_i, across = r * sin(b - a), d = hypot(along, across);
        if (d < 2 * ff_same_incidence) return (beside){1, {j}, {1}, 0};
        const int quadrant = (along >= 0) + 2 * (across >= 0);
        if (d < nearest[quadrant]) nearest[quadrant] = d, index[quadrant] = j;
    }
    beside out = {0};
    double sum = 0;
    for (int k = 0; k < 4; k++)
        if (isfinite(nearest[k])) {
            out.index[out.n] = index[k];
            out.share[out.n++] = 1 / nearest[k];
            sum += 1 / nearest[k];
        }
    for (size_t k = 0; k < out.n; k++) out.share[k] /= sum;
    out.outside = !isfinite(nearest[1]) && !isfinite(nearest[3]);
    return out;
}

static beside beside_direction(const ff_interpolant *p, double theta_i, double phi_i)
{
    beside out;
    return beside_rings(p, theta_i, phi_i, &out) ? out : beside_quadrants(p, theta_i, phi_i);
}

/* Mean of the slices' values at the half vector, by logarithms where they are positive. Slices whose own data do not reach that
 * half vector step back for those whose data do. */
static ff_found across_slices(const ff_interpolant *p, const beside *b, const double x[2], uint32_t without, double *value,
                              size_t stride)
{
    enum { CHANNELS = 64 };
    const size_t channels = p->t->n_channels;
    double one[4 * CHANNELS], *many = channels <= CHANNELS ? one : malloc(4 * channels * sizeof *many);
    if (!many) return FF_FOUND_BEYOND;
    ff_found how[4];
    double reached = 0;
    int all_samples = 1;
    for (size_t k = 0; k < b->n; k++) {
        how[k] = ff_regress(p->t, p->slice[b->index[k]].tree, 2, x, without, many + k * channels, 1);
        if (how[k] != FF_FOUND_BEYOND) reached += b->share[k];
        all_samples &= how[k] == FF_FOUND_SAMPLE;
    }
    const int use_all = reached < 0.5;
    for (size_t c = 0; c < channels; c++) {
        double plain = 0, logs = 0, lo = INFINITY;
        for (size_t k = 0; k < b->n; k++) {
            if (!use_all && how[k] == FF_FOUND_BEYOND) continue;
            const double share = b->share[k] / (use_all ? 1 : reached), v = many[k * channels + c];
            lo = fmin(lo, v);
            plain += share * v;
            if (lo > 0) logs += share * log(v);
        }
        value[c * stride] = b->n == 1 || !(lo > 0) ? plain : exp(logs);
    }
    if (many != one) free(many);
    if (use_all || b->outside) return FF_FOUND_BEYOND;
    return b->n == 1 && all_samples ? FF_FOUND_SAMPLE : FF_FOUND_BETWEEN;
}

ff_found ff_slices_at(const ff_interpolant *p, const double wi[3], const double wo[3], uint32_t without, double *value,
                      size_t stride)
{
    double theta_i, phi_i, x[2];
    in_slice(p->t->isotropic, wi, wo, &theta_i, &phi_i, x);
    const beside b = p->t->isotropic ? beside_theta(p, theta_i) : beside_direction(p, theta_i, phi_i);
    return across_slices(p, &b, x, without, value, stride);
}

ff_found ff_interpolant_without_incidence(const ff_interpolant *p, size_t i, double *value)
{
    double w[6], theta_i, phi_i, x[2], *const planes[6] = {w, w + 1, w + 2, w + 3, w + 4, w + 5};
    if (p->method != FF_SLICES || !p->t->isotropic) return FF_FOUND_BEYOND;
    ff_table_directions(p->t, i, 1, planes);
    in_slice(1, w, w + 3, &theta_i, &phi_i, x);
    size_t own = 0;
    while (own < p->n_slices && fabs(p->slice[own].theta_i - theta_i) > ff_same_incidence) own++;
    if (own == 0 || own + 1 >= p->n_slices) return FF_FOUND_BEYOND;
    const double lower = p->slice[own - 1].theta_i, u = (theta_i - lower) / (p->slice[own + 1].theta_i - lower);
    const beside b = {2, {own - 1, own + 1}, {1 - u, u}, 0};
    return across_slices(p, &b, x, UINT32_MAX, value, 1);
}

/* ---- incidences ------------------------------------------------------------------------------ */

/* First slices of each theta_i, spread evenly when there are more than asked for. */
size_t ff_slices_incidences(const ff_interpolant *p, size_t most, double *theta_i, double *phi_i)
{
    size_t distinct = 0, taken = 0, seen = 0;
    for (size_t j = 0; j < p->n_slices; j++) distinct += j == 0 || p->slice[j].theta_i != p->slice[j - 1].theta_i;
    for (size_t j = 0; j < p->n_slices; j++) {
        if (j > 0 && p->slice[j].theta_i == p->slice[j - 1].theta_i) continue;
        const size_t wanted = distinct <= most ? seen : taken * (distinct - 1) / (most - 1);
        if (seen++ != wanted || taken == most) continue;
        theta_i[taken] = p->slice[j].theta_i;
        phi_i[taken++] = p->slice[j].phi_i;
    }
    return taken;
}

int ff_interpolant_is_incidence(const ff_interpolant *p, const double wi[3], double within)
{
    const double theta_i = degrees * atan2(hypot(wi[0], wi[1]), wi[2]);
    for (size_t j = 0; j < p->n_slices; j++) {
        const ff_slice *s = &p->slice[j];
        if (fabs(s->theta_i - theta_i) > within) continue;
        const double a = s->theta_i / degrees, b = s->phi_i / degrees;
        const double apart = hypot(wi[0] - sin(a) * cos(b), wi[1] - sin(a) * sin(b));
        if (p->t->isotropic || apart * degrees <= within) return 1;
    }
    return 0;
}
