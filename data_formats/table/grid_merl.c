/* The grid of Matusik, Pfister, Brand, McMillan: A Data-Driven Reflectance Model (SIGGRAPH 2003), in the angles of Rusinkiewicz
 * 1998.
 *
 * Sample phi_d + 180 (theta_d + 90 theta_h). Node i of theta_h covers [i^2/90, (i+1)^2/90) degrees and has its sample at
 * (i+1/2)^2/90; theta_d and phi_d have cells of one degree with the sample in the middle. The half vector lies at phi_h = 0, since
 * the parametrisation is isotropic; phi_d and phi_d + 180 degrees are the same cell, by reciprocity.
 *
 *     d  = (sin theta_d cos phi_d, sin theta_d sin phi_d, cos theta_d)         wi seen from the half vector
 *     wi = Ry(theta_h) d,   wo = 2 (h.wi) h - wi = Ry(theta_h) (-dx, -dy, dz)
 *     d wi d wo = 4 cos theta_d dOmega_h dOmega_d                                (the reflection's 4 (h.wi)) */
#include "table_struct.h"
#include <math.h>

enum { N_THETA_H = 90, N_THETA_D = 90, N_PHI_D = 180, N_SAMPLES = N_THETA_H * N_THETA_D * N_PHI_D };

static const double pi = 3.14159265358979323846;
static const double degree = 3.14159265358979323846 / 180;

/* sin((i + 1/2) degrees): every sine and cosine of theta_d and phi_d is one of these. */
static const double sine[N_THETA_D] = {
    0.008726535498373935, 0.026176948307873153, 0.043619387365336,   0.06104853953485687, 0.07845909572784494, 0.095845752520224,
    0.11320321376790672,  0.1305261922200516,   0.14780941112961063, 0.16504760586067765, 0.18223552549214744, 0.1993679344171972,
    0.21643961393810288,  0.23344536385590542,  0.25038000405444144, 0.2672383760782569,  0.2840153447039226,  0.3007057995042731,
    0.31730465640509214,  0.3338068592337709,   0.3502073812594675,  0.3665012267242973,  0.3826834323650898,  0.3987490689252462,
    0.414693242656239,    0.43051109680829514,  0.44619781310980877, 0.4617486132350339,  0.4771587602596084,  0.4924235601034671,
    0.5075383629607042,   0.5224985647159489,   0.5372996083468239,  0.5519369853120581,  0.5664062369248328,  0.5807029557109398,
    0.5948227867513413,   0.6087614290087207,   0.6225146366376195,  0.636078220277764,   0.6494480483301837,  0.6626200482157375,
    0.6755902076156602,   0.688354575693754,    0.7009092642998509,  0.7132504491541816,  0.7253743710122876,  0.7372773368101241,
    0.7489557207890022,   0.7604059656000309,   0.77162458338772,    0.7826081568524139,  0.7933533402912352,  0.8038568606172173,
    0.8141155183563192,   0.8241261886220157,   0.8338858220671682,  0.8433914458128857,  0.8526401643540922,  0.8616291604415257,
    0.8703556959398997,   0.8788171126619654,   0.8870108331782217,  0.8949343616020251,  0.9025852843498606,  0.9099612708765432,
    0.917060074385124,    0.9238795325112867,   0.9304175679820246,  0.9366721892483976,  0.9426414910921784,  0.9483236552061993,
    0.9537169507482269,   0.958819734868193,    0.963630453208623,   0.9681476403781077,  0.9723699203976766,  0.9762960071199334,
    0.9799247046208296,   0.9832549075639546,   0.9862856015372314,  0.9890158633619168,  0.9914448613738104,  0.9935718556765875,
    0.9953961983671789,   0.996917333733128,    0.9981347984218669,  0.9990482215818578,  0.9996573249755573,  0.9999619230641713,
};

/* Lower edge of node i of theta_h, radians; at i = n + 1/2 the sample of node n. */
static double theta_h_at(double i)
{
    return i * i / 90 * degree;
}

/* Directions of the samples [phi0, phi1) of one row: fixed theta_h (sine sh, cosine ch) and theta_d (sd, cd). */
static void row_directions(double sh, double ch, double sd, double cd, const double *cos_phi, const double *sin_phi, size_t count,
                           double *const planes[6], size_t at)
{
    double *wix = planes[0] + at, *wiy = planes[1] + at, *wiz = planes[2] + at;
    double *wox = planes[3] + at, *woy = planes[4] + at, *woz = planes[5] + at;
    double along_x = sh * cd, along_z = ch * cd; /* the part of both directions along h */
    for (size_t k = 0; k < count; k++) {
        double dx = sd * cos_phi[k], dy = sd * sin_phi[k];
        wix[k] = along_x + ch * dx;
        wiy[k] = dy;
        wiz[k] = along_z - sh * dx;
        wox[k] = along_x - ch * dx;
        woy[k] = -dy;
        woz[k] = along_z + sh * dx;
    }
}

static void merl_directions(size_t first, size_t count, double *const planes[6])
{
    double cos_phi[N_PHI_D], sin_phi[N_PHI_D];
    for (int p = 0; p < N_PHI_D / 2; p++) {
        sin_phi[p] = sin_phi[N_PHI_D - 1 - p] = sine[p];
        cos_phi[p] = sine[N_THETA_D - 1 - p];
        cos_phi[N_PHI_D - 1 - p] = -cos_phi[p];
    }
    size_t current_h = N_THETA_H;
    double sh = 0, ch = 1;
    for (size_t done = 0; done < count;) {
        size_t i = first + done;
        size_t p = i % N_PHI_D, d = i / N_PHI_D % N_THETA_D, h = i / N_PHI_D / N_THETA_D;
        size_t row = N_PHI_D - p < count - done ? N_PHI_D - p : count - done;
        if (h != current_h) {
            sh = sin(theta_h_at((double)h + 0.5));
            ch = cos(theta_h_at((double)h + 0.5));
            current_h = h;
        }
        row_directions(sh, ch, sine[d], sine[N_THETA_D - 1 - d], cos_phi + p, sin_phi + p, row, planes, done);
        done += row;
    }
}

/* 4 cos theta_d dOmega_h dOmega_d, integrated exactly over the cell and over the azimuth of h, which the grid leaves open:
 * 4 x 2 pi (cos lo - cos hi) x (sin^2 hi - sin^2 lo)/2 x 2 degrees, the 2 for the folded phi_d. All cells add up to 8 pi^2, the
 * pairs whose half vector is above the horizon. */
static double cell_weight(size_t h, size_t d)
{
    double omega_h = 2 * pi * (cos(theta_h_at((double)h)) - cos(theta_h_at((double)h + 1)));
    double lo = sin((double)d * degree), hi = sin((double)(d + 1) * degree);
    return 4 * omega_h * (hi - lo) * (hi + lo) / 2 * (2 * degree);
}

static void merl_weights(size_t first, size_t count, double *w)
{
    for (size_t done = 0; done < count;) {
        size_t i = first + done;
        size_t p = i % N_PHI_D, d = i / N_PHI_D % N_THETA_D, h = i / N_PHI_D / N_THETA_D;
        size_t row = N_PHI_D - p < count - done ? N_PHI_D - p : count - done;
        double cell = cell_weight(h, d);
        for (size_t k = 0; k < row; k++) w[done + k] = cell;
        done += row;
    }
}

const ff_grid ff_grid_merl = {
    .name = "merl",
    .n = N_SAMPLES,
    .isotropic = 1,
    .directions = merl_directions,
    .weights = merl_weights,
};
