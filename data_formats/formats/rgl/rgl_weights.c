/* What the samples of an RGL file weigh.
 *
 * Between the samples the colours are bilinear in s: each spreads as a hat over the four cells around it. What a sample stands for
 * is therefore not the solid angle of a part of the square, where the density of normals may fall by orders of magnitude, but
 *
 *     integral of hat(s) ndf(m) dwo over the directions above the horizon
 *
 * and the sum of colours times that, over 4 sigma, is the reflectance of the function exactly. With m = (theta_m, phi_m) of u,
 * dwo = 4 (wi.m) sin(theta_m) pi u.x du.x dphi_m.
 *
 * In u.x the integrand has kinks at the nodes of the vndf and where s.x meets a column: two Gauss nodes from one to the next.
 * Between two rows of samples two lines at Gauss nodes of s.y do, as everything varies slowly with the azimuth.
 *
 * Most pieces are whole cells of the vndf, whose nodes are the same on every line: sines, cosines and densities there are tables,
 * and a line begins with all its whole cells. Where a column cuts a cell, one part is integrated and the other is the rest. The
 * integrand is there u^3, as that of a smooth density at the normal, times what goes in a straight line through the two nodes: the
 * tables serve again. */
#include "internal_rgl.h"
#include <math.h>
#include <stdlib.h>

static const double pi = 3.14159265358979323846;

/* Incidence nearer to the horizon than 32-bit angles can say (6e-8): no sample of it is valid. */
static const double grazing = 1e-6;

static const double gauss[2] = {0.21132486540518712, 0.78867513459481288};

struct ff_rgl_weights {
    size_t cells;                /* of a row of the vndf                                                             */
    double *cosine[2], *sine[2]; /* [cells] at both nodes of a cell: cos and sin of theta_m, times sin(theta_m) u du */
    double *cube[2];             /* [cells] 1 / u^3                                                                  */
    double *density[2];          /* [ndf_height][cells] there                                                        */
    double *value[2];            /* [cells] of a line: the integrand, times half the width of a cell                 */
    double *placed;              /* [cells] the integral over a cell of the integrand times the column               */
    double *row;                 /* [2 vndf.width] of the warp                                                       */
    double *memory;              /* all of them                                                                      */
};

/* Sine and cosine of 0..pi/2 within 3e-8, which weights do not notice: series about pi/4. */
static void sine_cosine(double theta, double *sine, double *cosine)
{
    const double y = theta - pi / 4, q = y * y, half = sqrt(0.5);
    const double s = y * (1 + q * (-1.0 / 6 + q * (1.0 / 120 + q * (-1.0 / 5040 + q * (1.0 / 362880)))));
    const double c = 1 + q * (-1.0 / 2 + q * (1.0 / 24 + q * (-1.0 / 720 + q * (1.0 / 40320))));
    *sine = half * (c + s), *cosine = half * (c - s);
}

static void fill_tables(const ff_rgl *r, ff_rgl_weights *w)
{
    const double cells = (double)w->cells;
    for (int k = 0; k < 2; k++)
        for (size_t i = 0; i < w->cells; i++) {
            const double u = ((double)i + gauss[k]) / cells;
            double s, c;
            sine_cosine(ff_rgl_theta(u), &s, &c);
            w->cube[k][i] = 1 / (u * u * u);
            w->cosine[k][i] = c * s * u / (2 * cells), w->sine[k][i] = s * s * u / (2 * cells);
            for (size_t y = 0; y < r->ndf_height; y++)
                w->density[k][y * w->cells + i] = ff_rgl_density(r, (const double[]){u, (double)y / (double)(r->ndf_height - 1)});
        }
}

ff_rgl_weights *ff_rgl_weights_new(const ff_rgl *r)
{
    const size_t cells = r->vndf.width - 1, densities = r->ndf_height * cells;
    ff_rgl_weights *w = malloc(sizeof *w);
    double *memory = malloc((9 * cells + 2 * densities + 2 * r->vndf.width) * sizeof *memory), *at = memory;
    if (!w || !memory) {
        free(w);
        free(memory);
        return NULL;
    }
    *w = (ff_rgl_weights){.cells = cells, .memory = memory};
    for (int k = 0; k < 2; k++) {
        w->cosine[k] = at, w->sine[k] = at + cells, w->cube[k] = at + 2 * cells, w->value[k] = at + 3 * cells;
        w->density[k] = at + 4 * cells, at += 4 * cells + densities;
    }
    w->placed = at, w->row = at + cells;
    fill_tables(r, w);
    return w;
}

void ff_rgl_weights_free(ff_rgl_weights *w)
{
    if (w) free(w->memory);
    free(w);
}

/* Half vectors of one azimuth between two rows of samples. */
typedef struct line {
    const ff_rgl *r;
    ff_rgl_weights *w;
    double v;             /* azimuth in the square                               */
    double along, across; /* wi.m = along cos(theta_m) + across sin(theta_m)     */
    double to_columns;    /* columns of samples in a unit of the warp's integral */
    double measure[2];    /* what the integral counts for the row on either side */
    double *mass[2];      /* [width] of these rows                               */
} line;

/* An integral, and the same with the integrand times the column where it lies. */
typedef struct piece {
    double whole, placed;
} piece;

/* The column at t of a cell: how much of the density lies before. */
static inline double column_at(const double *row, const double *before, size_t cell, double t, double to_columns)
{
    return (before[cell] + t * (row[cell] + 0.5 * t * (row[cell + 1] - row[cell]))) * to_columns;
}

static void whole_cells(const line *l)
{
    ff_rgl_weights *w = l->w;
    const size_t n = w->cells, height = l->r->ndf_height;
    const double at = l->v * (double)(height - 1), *row = w->row, *before = row + n + 1;
    const size_t y = at < (double)(height - 2) ? (size_t)at : height - 2;
    const double below = at - (double)y, above = 1 - below, along = l->along, across = l->across, to_columns = l->to_columns;
    double *restrict placed = w->placed;
    for (int k = 0; k < 2; k++) {
        const double *d0 = w->density[k] + y * n, *d1 = d0 + n, *c = w->cosine[k], *s = w->sine[k], t = gauss[k];
        double *restrict value = w->value[k];
        for (size_t i = 0; i < n; i++) {
            const double f = (above * d0[i] + below * d1[i]) * (along * c[i] + across * s[i]);
            const double column = column_at(row, before, i, t, to_columns);
            value[i] = f;
            placed[i] = k ? placed[i] + f * column : f * column;
        }
    }
}

static piece whole_cell(const ff_rgl_weights *w, size_t cell)
{
    return (piece){w->value[0][cell] + w->value[1][cell], w->placed[cell]};
}

/* From u.x = lo to hi, in one cell. */
static piece part_of_cell(const line *l, double lo, double hi, size_t cell)
{
    const ff_rgl_weights *w = l->w;
    const double *before = w->row + w->cells + 1, cells = (double)w->cells, width = (hi - lo) * cells;
    const double first = w->value[0][cell] * w->cube[0][cell], last = w->value[1][cell] * w->cube[1][cell];
    const double slope = (last - first) / (gauss[1] - gauss[0]);
    piece p = {0};
    for (int k = 0; k < 2; k++) {
        const double u = lo + (hi - lo) * gauss[k], t = u * cells - (double)cell;
        const double f = (first + slope * (t - gauss[0])) * u * u * u * width;
        p.whole += f;
        p.placed += f * column_at(w->row, before, cell, t, l->to_columns);
    }
    return p;
}

/* From the normal to the horizon: wo.z = along cos(2 theta_m) + across sin(2 theta_m). Beyond the last column the colours are those
 * of that column. */
static void add_line(const line *l)
{
    const double cells = (double)l->w->cells, columns = (double)(l->r->width - 1);
    const double horizon = ff_rgl_u_of_theta(fmin(fmax(0.5 * atan2(l->across, l->along) + pi / 4, 0), pi / 2));
    size_t hint = 0, cell = 0;
    double lo = 0;
    whole_cells(l);
    piece rest = whole_cell(l->w, 0);
    for (size_t x = 0; x + 1 < l->r->width && lo < horizon; x++) {
        const double column = x + 2 < l->r->width ? ff_warp2d_along(&l->r->vndf, l->w->row, (double)(x + 1) / columns, &hint) : 1;
        const double end = column < horizon ? column : horizon;
        piece sum = {0};
        while (lo < end) {
            const double border = (double)(cell + 1) / cells;
            piece add = rest;
            if (border <= end) {
                lo = border;
                if (++cell < l->w->cells) rest = whole_cell(l->w, cell);
            } else {
                add = part_of_cell(l, lo, end, cell);
                lo = end;
                rest.whole -= add.whole, rest.placed -= add.placed;
            }
            sum.whole += add.whole, sum.placed += add.placed;
        }
        const double right = sum.placed - (double)x * sum.whole, share[2] = {fmax(sum.whole - right, 0), fmax(right, 0)};
        for (int k = 0; k < 4; k++) l->mass[k / 2][x + (size_t)(k % 2)] += l->measure[k / 2] * share[k % 2];
    }
}

void ff_rgl_weigh(const ff_rgl *r, ff_rgl_weights *w, size_t p, size_t t, double *mass)
{
    const ff_warp2d_mix mix = {.n = 1, .slice = {p * r->n_theta + t}, .weight = {1}};
    const double theta = r->theta[t], phi = r->phi[p], turn = r->isotropic ? phi : 0, rows = (double)(r->height - 1);
    memset(mass, 0, r->width * r->height * sizeof *mass);
    if (cos(theta) <= grazing) return; /* no sample is valid */
    for (size_t k = 0; k < 2 * (r->height - 1); k++) {
        const size_t y = k / 2;
        const double g = gauss[k % 2], v = ff_warp2d_row(&r->vndf, &mix, ((double)y + g) / rows, w->row);
        const double in_row = w->row[2 * r->vndf.width - 1], marginal = in_row * (double)(r->vndf.height - 1);
        if (!(marginal > 0)) continue;
        const double all = 4 * pi * pi / (marginal * rows); /* 4 pi 2 pi, and half a step for each of two nodes */
        add_line(&(line){.r = r,
                         .w = w,
                         .v = v - floor(v),
                         .along = cos(theta),
                         .across = sin(theta) * cos(ff_rgl_phi(v) + turn - phi),
                         .to_columns = (double)(r->width - 1) / in_row,
                         .measure = {all * (1 - g), all * g},
                         .mass = {mass + y * r->width, mass + (y + 1) * r->width}});
    }
}
