/* On which side of the surface the data are brightest, and how much they reflect at least. */
#include "ff_brightest.h"
#include "base/internal_options.h"
#include "data_formats/table/table_struct.h"
#include "models/model_struct.h"
#include <math.h>
#include <stdlib.h>

static const double pi = 3.14159265358979323846;

enum { ROWS = FF_BRIGHTEST_ROWS, POLAR = 18, AZIMUTHS = 18, CELLS = POLAR * AZIMUTHS, BLOCK = 256, LOOKED_AT = 200000 };
#define STANDS_OUT 1.5 /* times the brightest sample of any other side */
#define UPRIGHT    5   /* degrees of incidence up to which there are no sides */

typedef struct looker {
    const ff_table *t;
    double cos_max;
    double most[ROWS][FF_SIDES]; /* the largest mean over the channels on each side */
    double theta_i[ROWS];
    double *least; /* [n_channels][ROWS][CELLS]: the least value in each cell of 5 by 10 degrees; infinite: no sample */
} looker;

static int band(double x, double width, int n)
{
    const int k = (int)(x / width + 1e-9);
    return k < 0 ? 0 : k < n ? k : n - 1;
}

static ff_side side_of(double apart)
{
    return apart > 120 ? FF_SIDE_MIRROR : apart < 60 ? FF_SIDE_LIGHT : FF_SIDE_ACROSS;
}

/* One sample with the directions wi, wo. */
static void look(looker *l, size_t i, const double wi[3], const double wo[3])
{
    const ff_table *t = l->t;
    const double degrees = 180 / pi, theta_i = degrees * acos(fmin(wi[2], 1)), theta_o = degrees * acos(fmin(wo[2], 1));
    const double across = wi[0] * wo[1] - wi[1] * wo[0], along = wi[0] * wo[0] + wi[1] * wo[1];
    const double apart = across == 0 && along == 0 ? 0 : degrees * fabs(atan2(across, along));
    const int row = band(theta_i, 5, ROWS), cell = band(theta_o, 5, POLAR) * AZIMUTHS + band(apart, 10, AZIMUTHS);
    double mean = 0;
    for (size_t c = 0; c < t->n_channels; c++) {
        const double v = t->channels[c].scale * t->value[c * t->n + i];
        double *least = &l->least[(c * ROWS + (size_t)row) * CELLS + (size_t)cell];
        *least = fmin(*least, v);
        mean += v / (double)t->n_channels;
    }
    l->theta_i[row] = theta_i;
    if (theta_i <= UPRIGHT || theta_o <= UPRIGHT) return;
    double *most = &l->most[row][side_of(apart)];
    *most = fmax(*most, mean);
}

static void look_at_all(looker *l)
{
    const ff_table *t = l->t;
    const size_t blocks = (t->n + BLOCK - 1) / BLOCK, step = t->n / LOOKED_AT + 1;
    double w[6][BLOCK], *const planes[6] = {w[0], w[1], w[2], w[3], w[4], w[5]};
    for (size_t b = 0; b < blocks; b += step) {
        const size_t first = b * BLOCK, n = t->n - first < BLOCK ? t->n - first : BLOCK;
        ff_table_directions(t, first, n, planes);
        for (size_t k = 0; k < n; k++) {
            const double wi[3] = {w[0][k], w[1][k], w[2][k]}, wo[3] = {w[3][k], w[4][k], w[5][k]};
            if (t->valid[first + k] && wi[2] > FF_COS_MIN && wo[2] > FF_COS_MIN && wi[2] >= l->cos_max && wo[2] >= l->cos_max)
                look(l, first + k, wi, wo);
        }
    }
}

/* Both the side of the light and that of the mirror direction have to be there. */
static ff_side brightest_side(const double most[FF_SIDES])
{
    ff_side best = FF_SIDE_NONE;
    double next = -INFINITY;
    if (!(most[FF_SIDE_MIRROR] > -INFINITY && most[FF_SIDE_LIGHT] > -INFINITY)) return FF_SIDE_NONE;
    for (int s = FF_SIDE_MIRROR; s < FF_SIDES; s++)
        if (best == FF_SIDE_NONE || most[s] > most[best]) best = (ff_side)s;
    for (int s = FF_SIDE_MIRROR; s < FF_SIDES; s++)
        if (s != (int)best) next = fmax(next, most[s]);
    return most[best] > 0 && most[best] > STANDS_OUT * next ? best : FF_SIDE_NONE;
}

/* The least of a cell and those about it, so that a peak that few samples have met does not count for a cell: where there is no
 * sample, the least of all. */
static double least_about(const double *least, int cell, double floor)
{
    const int polar = cell / AZIMUTHS, azimuth = cell % AZIMUTHS;
    double value = INFINITY;
    for (int i = polar - 1; i <= polar + 1; i++)
        for (int k = azimuth - 1; k <= azimuth + 1; k++) {
            if (i < 0 || i >= POLAR || k < 0 || k >= AZIMUTHS) continue;
            const double one = least[i * AZIMUTHS + k];
            value = fmin(value, isinf(one) ? floor : one);
        }
    return value;
}

/* Samples about a peak alone say nothing of what lies elsewhere, whose least is taken where there are none: an incidence has to be
 * seen over at least 40 degrees, across the normal or along one side. */
static int is_spread(const double *least)
{
    enum { FEWEST = 5, WIDE = 8 };
    int first = POLAR, last = -POLAR, seen = 0;
    for (int cell = 0; cell < CELLS; cell++) {
        if (isinf(least[cell])) continue;
        const int band = cell / AZIMUTHS, signed_band = cell % AZIMUTHS < AZIMUTHS / 2 ? -band : band;
        first = signed_band < first ? signed_band : first;
        last = signed_band > last ? signed_band : last;
        seen++;
    }
    return seen >= FEWEST && last - first >= WIDE;
}

/* Integral of the least values times the cosine. NaN: there is no sample. */
static double least_reflectance(const double *least)
{
    const double step = pi / 36, turn = 2 * pi / AZIMUTHS; /* a cell stands for both signs of the azimuth */
    double sum = 0, floor = INFINITY;
    for (int k = 0; k < CELLS; k++) floor = fmin(floor, least[k]);
    if (isinf(floor)) return NAN;
    for (int row = 0; row < POLAR; row++) {
        const double a = row * step, b = a + step, solid = 0.5 * (sin(b) * sin(b) - sin(a) * sin(a)) * turn;
        for (int k = row * AZIMUTHS; k < (row + 1) * AZIMUTHS; k++) sum += solid * least_about(least, k, floor);
    }
    return sum;
}

ff_status ff_brightest_find(const ff_table *t, double max_theta, ff_brightest *out)
{
    if (!(max_theta > 0 && max_theta <= FF_HORIZON)) return FF_ERR_RANGE;
    const size_t cells = t->n_channels * ROWS * CELLS;
    looker l = {.t = t, .cos_max = max_theta >= pi / 2 ? 0 : cos(max_theta) * (1 - 1e-12)};
    ff_brightest b = {.reflects = NAN};
    l.least = malloc(cells * sizeof *l.least);
    if (!l.least) return FF_ERR_MEMORY;
    for (size_t k = 0; k < cells; k++) l.least[k] = INFINITY;
    for (int row = 0; row < ROWS; row++) {
        l.theta_i[row] = NAN;
        for (int s = 0; s < FF_SIDES; s++) l.most[row][s] = -INFINITY;
    }
    look_at_all(&l);
    for (int row = 0; row < ROWS; row++) {
        b.side[row] = brightest_side(l.most[row]);
        b.theta_i[row] = l.theta_i[row];
        b.count[b.side[row]]++;
    }
    for (size_t k = 0; k < t->n_channels * ROWS; k++)
        if (!isnan(l.theta_i[k % ROWS]) && is_spread(l.least + k * CELLS))
            b.reflects = fmax(b.reflects, least_reflectance(l.least + k * CELLS));
    free(l.least);
    *out = b;
    return FF_OK;
}

ff_side ff_brightest_odd(const ff_brightest *b)
{
    if (b->count[FF_SIDE_MIRROR] > 0) return FF_SIDE_NONE;
    if (b->count[FF_SIDE_LIGHT] >= 2 && b->count[FF_SIDE_ACROSS] == 0) return FF_SIDE_LIGHT;
    return b->count[FF_SIDE_ACROSS] >= 2 && b->count[FF_SIDE_LIGHT] == 0 ? FF_SIDE_ACROSS : FF_SIDE_NONE;
}
