/* Interpolation between the samples of a table: which method, and what all share. ff_interpolate.h describes them. */
#include "models/model_struct.h"
#include "internal_interpolate.h"
#include "data_formats/table/internal_table.h"
#include <math.h>
#include <stdlib.h>

static const double degrees = 180 / 3.14159265358979323846;

/* ---- samples ---------------------------------------------------------------------------------- */

/* The sides of the plane of incidence that have samples. */
typedef struct sides {
    int left, right;
} sides;

static void look_aside(void *context, size_t i, const double wi[3], const double wo[3])
{
    sides *s = context;
    const double across = wi[0] * wo[1] - wi[1] * wo[0];
    (void)i;
    s->left |= across > 1e-6;
    s->right |= across < -1e-6;
}

static int is_one_sided(const ff_table *t)
{
    sides s = {0, 0};
    if (!t->isotropic) return 0;
    ff_each_usable(t, look_aside, &s);
    return s.left != s.right;
}

/* ---- all methods ----------------------------------------------------------------------------- */

/* The first method that fits the table. */
static ff_status choose(ff_interpolant *p, int scattered, ff_error *err)
{
    if (p->t->n > UINT32_MAX / FF_SCATTERED_COPIES)
        return ff_error_set(err, FF_ERR_UNSUPPORTED, NULL, 0, -1, "found %zu samples, expected at most %u to interpolate between",
                            p->t->n, UINT32_MAX / FF_SCATTERED_COPIES);
    p->method = FF_CELLS;
    if (p->t->cells && !scattered) return FF_OK;
    int found = scattered ? 0 : ff_product_find(p);
    p->method = FF_PRODUCT;
    p->mirrored = found == 0 && is_one_sided(p->t);
    if (found == 0) {
        p->method = FF_SLICES;
        found = ff_slices_find(p);
    }
    if (found == 0) {
        p->method = FF_SCATTERED;
        found = ff_scattered_find(p);
    }
    if (p->method != FF_PRODUCT) ff_plane_find(p);
    if (found == 0)
        return ff_error_set(err, FF_ERR_DATA, NULL, 0, -1,
                            "found no measured sample above the horizon, expected at least one to interpolate from");
    return found > 0 ? FF_OK : ff_error_set(err, FF_ERR_MEMORY, NULL, 0, -1, "no memory to interpolate");
}

ff_status ff_interpolant_new(const ff_table *t, int scattered, ff_interpolant **out, ff_error *err)
{
    ff_interpolant *p = calloc(1, sizeof *p);
    if (!p) return ff_error_set(err, FF_ERR_MEMORY, NULL, 0, -1, "no memory to interpolate");
    p->t = t;
    const ff_status status = choose(p, scattered, err);
    if (status == FF_OK)
        *out = p;
    else
        ff_interpolant_free(p);
    return status;
}

void ff_interpolant_free(ff_interpolant *p)
{
    if (!p) return;
    for (int k = 0; k < 4; k++) free(p->axis[k].node);
    for (size_t j = 0; j < p->n_slices; j++) ff_neighbours_free(p->slice[j].tree);
    free(p->slice);
    ff_neighbours_free(p->tree);
    free(p);
}

int ff_interpolant_regresses(const ff_interpolant *p)
{
    return p->method == FF_SLICES || p->method == FF_SCATTERED;
}

int ff_interpolant_is_in_plane(const ff_interpolant *p)
{
    return p->plane.all_in;
}

const char *ff_interpolant_method(const ff_interpolant *p)
{
    return p->method == FF_CELLS     ? "constant over each cell, as the data are"
           : p->method == FF_PRODUCT ? "linear along the axes of the grid"
           : p->method == FF_SLICES  ? "local regression over half vectors at each incidence, linear between incidences"
                                     : "local regression over the nearest samples";
}

static ff_found regressed_at(const ff_interpolant *p, const double wi[3], const double wo[3], uint32_t without, double *value,
                             size_t stride)
{
    return p->method == FF_SLICES ? ff_slices_at(p, wi, wo, without, value, stride)
                                  : ff_scattered_at(p, wi, wo, without, value, stride);
}

/* Beside the plane that all samples are in: the value of half vectors that lean as far within it, as if normals leaned to all sides
 * alike. A guess, and called so. */
static ff_found beside_at(const ff_interpolant *p, const double wi[3], const double wo[3], double *value, size_t stride)
{
    enum { FEW = 256 }; /* channels without an allocation for every direction */
    double to[2][3], share[2], few[FEW];
    const size_t n = p->t->n_channels;
    if (!ff_plane_turn(&p->plane, wi, wo, to, share)) {
        regressed_at(p, wi, wo, UINT32_MAX, value, stride);
        return FF_FOUND_BEYOND;
    }
    const int first = share[0] > 0 ? 0 : 1;
    regressed_at(p, wi, to[first], UINT32_MAX, value, stride);
    if (first == 1 || !(share[1] > 0)) return FF_FOUND_BEYOND;
    double *second = n <= FEW ? few : malloc(n * sizeof *second);
    if (!second) return FF_FOUND_BEYOND; /* of one side alone: a guess as well */
    regressed_at(p, wi, to[1], UINT32_MAX, second, 1);
    for (size_t c = 0; c < n; c++) value[c * stride] = share[0] * value[c * stride] + share[1] * second[c];
    if (second != few) free(second);
    return FF_FOUND_BEYOND;
}

static ff_found value_at(const ff_interpolant *p, const double wi[3], const double wo[3], uint32_t without, double *value,
                         size_t stride)
{
    if (!(wi[2] > FF_COS_MIN) || !(wo[2] > FF_COS_MIN)) {
        for (size_t c = 0; c < p->t->n_channels; c++) value[c * stride] = 0;
        return FF_FOUND_BELOW;
    }
    return p->method == FF_CELLS                   ? ff_cells_at(p, wi, wo, value, stride)
           : p->method == FF_PRODUCT               ? ff_product_at(p, wi, wo, value, stride)
           : ff_plane_is_beside(&p->plane, wi, wo) ? beside_at(p, wi, wo, value, stride)
                                                   : regressed_at(p, wi, wo, without, value, stride);
}

ff_found ff_interpolant_without(const ff_interpolant *p, size_t i, double *value)
{
    double w[6], *const planes[6] = {w, w + 1, w + 2, w + 3, w + 4, w + 5};
    ff_table_directions(p->t, i, 1, planes);
    return value_at(p, w, w + 3, (uint32_t)i, value, 1);
}

/* The range of theta_i in the data. */
typedef struct theta_range {
    double lo, hi;
} theta_range;

static void widen(void *context, size_t i, const double wi[3], const double wo[3])
{
    theta_range *r = context;
    const double theta = degrees * atan2(hypot(wi[0], wi[1]), wi[2]);
    (void)i, (void)wo;
    r->lo = fmin(r->lo, theta);
    r->hi = fmax(r->hi, theta);
}

size_t ff_interpolant_incidences(const ff_interpolant *p, size_t most, double *theta_i, double *phi_i)
{
    static const double round_ones[] = {5, 15, 30, 45, 60, 75};
    theta_range r = {INFINITY, -INFINITY};
    size_t n = 0;
    if (p->method == FF_SLICES) return ff_slices_incidences(p, most, theta_i, phi_i);
    if (p->method == FF_PRODUCT && p->kind == FF_AXES_SPECULAR) {
        for (; n < most && n < p->axis[1].n; n++) {
            theta_i[n] = degrees * p->axis[1].node[n];
            phi_i[n] = -90 - degrees * p->axis[0].node[0];
        }
        return n;
    }
    ff_each_usable(p->t, widen, &r);
    for (size_t k = 0; k < sizeof round_ones / sizeof round_ones[0] && n < most; k++)
        if (round_ones[k] >= r.lo && round_ones[k] <= r.hi) {
            theta_i[n] = round_ones[k];
            phi_i[n++] = 0;
        }
    return n;
}

static void eval(const ff_interpolant *p, const double *const w[6], size_t n, int reciprocal, double *value, unsigned char *found)
{
    for (size_t i = 0; i < n; i++) {
        const double wi[3] = {w[0][i], w[1][i], w[2][i]}, wo[3] = {w[3][i], w[4][i], w[5][i]};
        ff_found how = value_at(p, wi, wo, UINT32_MAX, value + i, n);
        if (reciprocal && how == FF_FOUND_BEYOND) {
            how = value_at(p, wo, wi, UINT32_MAX, value + i, n);
            if (how == FF_FOUND_BEYOND)
                value_at(p, wi, wo, UINT32_MAX, value + i, n);
            else
                how = FF_FOUND_RECIPROCAL;
        }
        if (found) found[i] = (unsigned char)how;
    }
}

void ff_interpolant_eval(const ff_interpolant *p, const double *const w[6], size_t n, double *value, unsigned char *found)
{
    eval(p, w, n, 0, value, found);
}

void ff_interpolant_eval_reciprocal(const ff_interpolant *p, const double *const w[6], size_t n, double *value,
                                    unsigned char *found)
{
    eval(p, w, n, 1, value, found);
}
