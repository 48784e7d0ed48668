/* Light from all directions: a map by latitude and longitude, and a density to draw from it.
 *
 * Cell (r, c) of the map is the solid angle of one pixel, Omega = (2 pi / nx) (cos t_r - cos t_r+1). It is drawn with the
 * probability l Omega / sum(l Omega), l the mean luminance of the 3 x 3 pixels around it, so that the density is > 0 wherever the
 * map, bilinear between the centres of its pixels, is; a direction of the cell evenly by solid angle. */
#include "internal_render.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

static const double pi = 3.14159265358979323846;

enum { SIDE_MAX = 32768 };

#define NARROW 0.03 /* radians */
enum { TEXEL = 4 }; /* red, green, blue; density, 1/sr */

struct ff_environment {
    size_t nx, ny;
    double turn;     /* in parts of a whole one, [0, 1)       */
    float *texel;    /* [ny][nx][TEXEL]                       */
    double *edge;    /* [ny + 1] cosines of the rows' edges   */
    double *below;   /* [ny + 1] probability of the rows above */
    double *row;     /* [ny][nx + 1] within a row             */
    double width;    /* of a column, radians                      */
    double *column;  /* [nx][2] sine and cosine of its left edge  */
    uint16_t *guide; /* [ny][nx] where to begin in a row: the cell in which k/nx is */
};

/* ---- making one ------------------------------------------------------------------------------ */

static double luminance_at(const ff_environment *e, size_t r, size_t c)
{
    const float *p = e->texel + TEXEL * (r * e->nx + c);
    return ff_luminance((double)p[0], (double)p[1], (double)p[2]);
}

/* Mean of a pixel and those around it; across the seam, but not across the poles. */
static double smooth_luminance(const ff_environment *e, size_t r, size_t c)
{
    const size_t left = c ? c - 1 : e->nx - 1, right = c + 1 < e->nx ? c + 1 : 0, above = r ? r - 1 : r,
                 under = r + 1 < e->ny ? r + 1 : r;
    const size_t rows[3] = {above, r, under}, columns[3] = {left, c, right};
    double sum = 0;
    for (int j = 0; j < 3; j++)
        for (int i = 0; i < 3; i++) sum += luminance_at(e, rows[j], columns[i]);
    return sum / 9;
}

static double solid_angle(const ff_environment *e, size_t r)
{
    return 2 * pi / (double)e->nx * (e->edge[r] - e->edge[r + 1]);
}

/* Running sums within the rows, their totals in e->below[r + 1]. */
static void sum_rows(ff_environment *e)
{
    for (size_t r = 0; r < e->ny; r++) {
        double *row = e->row + r * (e->nx + 1);
        row[0] = 0;
        for (size_t c = 0; c < e->nx; c++) row[c + 1] = row[c] + smooth_luminance(e, r, c) * solid_angle(e, r);
        e->below[r + 1] = e->below[r] + row[e->nx];
    }
}

/* The sums as parts of 1, and what is between them as densities. */
static void normalise(ff_environment *e)
{
    const double total = e->below[e->ny];
    for (size_t r = 0; r < e->ny; r++) {
        double *row = e->row + r * (e->nx + 1);
        const double sum = row[e->nx];
        for (size_t c = 0; c < e->nx; c++)
            e->texel[TEXEL * (r * e->nx + c) + 3] = (float)((row[c + 1] - row[c]) / (solid_angle(e, r) * total));
        for (size_t c = 1; c < e->nx && sum > 0; c++) row[c] /= sum;
        row[e->nx] = 1;
        e->below[r + 1] = r + 1 < e->ny ? e->below[r + 1] / total : 1;
    }
}

static void make_guide(const double *row, size_t n, uint16_t *guide)
{
    size_t c = 0;
    for (size_t k = 0; k < n; k++) {
        while (c + 1 < n && row[c + 1] <= (double)k / (double)n) c++;
        guide[k] = (uint16_t)c;
    }
}

static void make_density(ff_environment *e)
{
    for (size_t r = 0; r <= e->ny; r++) e->edge[r] = r == e->ny ? -1 : cos(pi * (double)r / (double)e->ny);
    e->below[0] = 0;
    sum_rows(e);
    normalise(e);
    for (size_t r = 0; r < e->ny; r++) make_guide(e->row + r * (e->nx + 1), e->nx, e->guide + r * e->nx);
}

ff_status ff_environment_of(size_t nx, size_t ny, const float *rgb, double turn, ff_environment **out, ff_error *err)
{
    ff_environment *e = calloc(1, sizeof *e);
    if (e) {
        const double part = -turn / (2 * pi); /* counter-clockwise from above is towards smaller a */
        *e = (ff_environment){.nx = nx, .ny = ny, .turn = part - floor(part), .width = 2 * pi / (double)nx};
        e->texel = malloc(TEXEL * nx * ny * sizeof *e->texel);
        e->edge = malloc((ny + 1) * sizeof *e->edge);
        e->below = malloc((ny + 1) * sizeof *e->below);
        e->row = malloc(ny * (nx + 1) * sizeof *e->row);
        e->guide = malloc(ny * nx * sizeof *e->guide);
        e->column = malloc(2 * nx * sizeof *e->column);
    }
    if (!e || !e->column || !e->texel || !e->edge || !e->below || !e->row || !e->guide) {
        ff_environment_free(e);
        return ff_error_set(err, FF_ERR_MEMORY, NULL, 0, -1, "no memory for an environment of %zu x %zu pixels", nx, ny);
    }
    for (size_t k = 0; k < 3 * nx * ny; k++) e->texel[k / 3 * TEXEL + k % 3] = rgb[k];
    for (size_t c = 0; c < nx; c++) {
        const double a = 2 * pi * ((double)c / (double)nx + e->turn - 0.5);
        e->column[2 * c] = sin(a);
        e->column[2 * c + 1] = cos(a);
    }
    make_density(e);
    *out = e;
    return FF_OK;
}

static ff_status check_map(size_t nx, size_t ny, const float *rgb, ff_error *err)
{
    double sum = 0;
    for (size_t k = 0; k < 3 * nx * ny; k++) {
        if (!(rgb[k] >= 0 && isfinite(rgb[k])))
            return ff_error_set(err, FF_ERR_RANGE, NULL, 0, -1,
                                "pixel (%zu, %zu) of the environment: found %g, expected a radiance of 0 or more", k / 3 % nx,
                                k / 3 / nx, (double)rgb[k]);
        sum += rgb[k];
    }
    return sum > 0 ? FF_OK : ff_error_set(err, FF_ERR_DATA, NULL, 0, -1, "the environment is black everywhere");
}

ff_status ff_environment_new(size_t nx, size_t ny, const float *rgb, double turn, ff_environment **out, ff_error *err)
{
    if (nx < 1 || ny < 1 || nx > SIDE_MAX || ny > SIDE_MAX)
        return ff_error_set(err, FF_ERR_RANGE, NULL, 0, -1, "an environment of %zu x %zu pixels, expected 1 to %d", nx, ny,
                            SIDE_MAX);
    if (!(fabs(turn) <= 1e9)) return ff_error_set(err, FF_ERR_RANGE, NULL, 0, -1, "a turn of %g, expected -1e9 to 1e9", turn);
    const ff_status status = check_map(nx, ny, rgb, err);
    return status != FF_OK ? status : ff_environment_of(nx, ny, rgb, turn, out, err);
}

void ff_environment_free(ff_environment *e)
{
    if (!e) return;
    free(e->texel);
    free(e->edge);
    free(e->below);
    free(e->row);
    free(e->guide);
    free(e->column);
    free(e);
}

/* ---- looking --------------------------------------------------------------------------------- */

/* The four numbers of a pixel, as one. */
typedef float texel __attribute__((vector_size(TEXEL * sizeof(float))));

static inline texel texel_at(const ff_environment *e, size_t r, size_t c)
{
    texel out;
    memcpy(&out, e->texel + TEXEL * (r * e->nx + c), sizeof out);
    return out;
}

/* x in [0, 1) across, y in [0, 1] down. */
static inline texel radiance_at(const ff_environment *e, double x, double y)
{
    const double u = x * (double)e->nx + 0.5, v = y * (double)e->ny + 0.5; /* centres at 1, 2, ... */
    const size_t c = (size_t)u, r = (size_t)v;
    const float a = (float)(u - (double)c), b = (float)(v - (double)r);
    const size_t c0 = c ? c - 1 : e->nx - 1, c1 = c < e->nx ? c : 0, r0 = r ? r - 1 : 0, r1 = r < e->ny ? r : e->ny - 1;
    const texel p00 = texel_at(e, r0, c0), p01 = texel_at(e, r0, c1), p10 = texel_at(e, r1, c0), p11 = texel_at(e, r1, c1);
    const float w00 = (1 - a) * (1 - b), w01 = a * (1 - b), w10 = (1 - a) * b, w11 = a * b;
    return w00 * p00 + w01 * p01 + w10 * p10 + w11 * p11;
}

/* The angle from the top in parts of that to the bottom. */
static inline double down_to(double cosine)
{
    const double mu = cosine < -1 ? -1 : cosine < 1 ? cosine : 1;
    return acos(mu) * (1 / pi);
}

static size_t cell_of(double x, size_t n)
{
    const size_t k = (size_t)x;
    return k < n ? k : n - 1;
}

static double density_at(const ff_environment *e, size_t r, size_t c)
{
    return (double)e->texel[TEXEL * (r * e->nx + c) + 3];
}

void ff_environment_look(const ff_environment *e, size_t n, const double *w, double *rgb, double *pdf, size_t ld)
{
    for (size_t i = 0; i < n; i++) {
        const double wx = w[i], wy = w[ld + i], wz = w[2 * ld + i];
        double across = atan2(wx, -wz) * (0.5 / pi) + 0.5 - e->turn;
        const double down = down_to(wy);
        across += across < 0;
        if (!(across >= 0 && across < 1)) across = 0;
        if (rgb) {
            const texel L = radiance_at(e, across, down);
            for (size_t k = 0; k < 3; k++) rgb[k * ld + i] = (double)L[k];
        }
        if (pdf) pdf[i] = density_at(e, cell_of(down * (double)e->ny, e->ny), cell_of(across * (double)e->nx, e->nx));
    }
}

/* ---- drawing --------------------------------------------------------------------------------- */

/* The k with below[k] <= u < below[k + 1], k < n, of rising numbers from 0 to 1; never one without probability. */
static size_t find(const double *below, size_t n, double u)
{
    size_t lo = 0; /* below[lo] <= u, and that is not so of below[lo + left] */
    for (size_t left = n; left > 1;) {
        const size_t half = left / 2;
        lo = below[lo + half] <= u ? lo + half : lo; /* without a branch that nobody can foresee */
        left -= half;
    }
    while (lo > 0 && !(below[lo + 1] > below[lo])) lo--;
    return lo;
}

/* The same within a row, from where its guide says: one step on average. The first two are without a branch; row[n] = 1 > u. */
static size_t find_guided(const double *row, const uint16_t *guide, size_t n, double u)
{
    size_t c = guide[cell_of(u * (double)n, n)];
    c += row[c + 1] <= u;
    c += row[c + 1] <= u;
    while (c + 1 < n && row[c + 1] <= u) c++;
    while (c > 0 && (row[c] > u || !(row[c + 1] > row[c]))) c--;
    return c;
}

/* Where u lies between below[k] and below[k + 1], [0, 1]. */
static double within(const double *below, size_t k, double u)
{
    const double width = below[k + 1] - below[k];
    return width > 0 ? fmin(fmax((u - below[k]) / width, 0), 1) : 0.5;
}

/* Sine and cosine of the azimuth at a fraction of a column: of narrow columns a few terms are exact. */
static void turn_of(const ff_environment *e, size_t c, double within_cell, double out[2])
{
    const double d = within_cell * e->width, d2 = d * d;
    if (e->width > NARROW) {
        const double a = 2 * pi * (((double)c + within_cell) / (double)e->nx + e->turn - 0.5);
        out[0] = sin(a);
        out[1] = cos(a);
        return;
    }
    const double s = d * (1 - d2 * (1.0 / 6 - d2 * (1.0 / 120 - d2 * (1.0 / 5040)))),
                 k = 1 - d2 * (0.5 - d2 * (1.0 / 24 - d2 * (1.0 / 720)));
    out[0] = e->column[2 * c] * k + e->column[2 * c + 1] * s;
    out[1] = e->column[2 * c + 1] * k - e->column[2 * c] * s;
}

void ff_environment_draw_places(const ff_environment *e, size_t n, const double *u, double *w, double *across, double *pdf,
                                size_t ld)
{
    for (size_t i = 0; i < n; i++) {
        const double u0 = fmin(fmax(u[i], 0), 1 - 0x1p-53), u1 = fmin(fmax(u[ld + i], 0), 1 - 0x1p-53);
        const size_t r = find(e->below, e->ny, u0);
        const double *row = e->row + r * (e->nx + 1);
        const size_t c = find_guided(row, e->guide + r * e->nx, e->nx, u1);
        const double mu = e->edge[r] + (e->edge[r + 1] - e->edge[r]) * within(e->below, r, u0), x = within(row, c, u1);
        const double s = sqrt(fmax((1 - mu) * (1 + mu), 0));
        double turn[2];
        turn_of(e, c, x, turn);
        w[i] = s * turn[0];
        w[ld + i] = mu;
        w[2 * ld + i] = -s * turn[1];
        pdf[i] = density_at(e, r, c);
        across[i] = ((double)c + x) / (double)e->nx;
    }
}

void ff_environment_radiance(const ff_environment *e, size_t n, const double *across, const double *mu, double *rgb, size_t ld)
{
    for (size_t i = 0; i < n; i++) {
        const texel L = radiance_at(e, across[i] < 1 ? across[i] : 0, down_to(mu[i]));
        for (size_t k = 0; k < 3; k++) rgb[k * ld + i] = (double)L[k];
    }
}

void ff_environment_draw(const ff_environment *e, size_t n, const double *u, double *w, double *rgb, double *pdf, size_t ld)
{
    double across[FF_BEAMS];
    for (size_t first = 0; first < n; first += FF_BEAMS) {
        const size_t count = n - first < FF_BEAMS ? n - first : FF_BEAMS;
        ff_environment_draw_places(e, count, u + first, w + first, across, pdf + first, ld);
        if (rgb) ff_environment_radiance(e, count, across, w + ld + first, rgb + first, ld);
    }
}
