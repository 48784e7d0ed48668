/* The cells that the nodes of a grid about the specular direction stand for, and integrals over them. */
#include "internal_zemax.h"
#include <math.h>
#include <stdlib.h>

static const double degree = 3.14159265358979323846 / 180;

int ff_zemax_has_cells(const size_t n[FF_ZEMAX_AXES], const double *const node[FF_ZEMAX_AXES])
{
    return n[FF_ZEMAX_AZIMUTH] > 1 && ff_largest_gap(node[FF_ZEMAX_AZIMUTH], n[FF_ZEMAX_AZIMUTH]) <= 45 && n[FF_ZEMAX_RADIAL] > 1;
}

ff_status ff_zemax_cells_make(const size_t n[FF_ZEMAX_AXES], const double *const node[FF_ZEMAX_AXES], int symmetry,
                              ff_zemax_cells *c, ff_error *err)
{
    size_t all = 0;
    for (int k = 0; k < FF_ZEMAX_AXES; k++) all += n[k];
    double *p = malloc(3 * all * sizeof *p);
    if (!p) return ff_error_set(err, FF_ERR_MEMORY, NULL, 0, -1, "no memory for the cells of %zu angles", all);
    c->memory = p;
    for (int k = 0; k < FF_ZEMAX_AXES; k++) {
        c->of[k] = p, c->cosine[k] = p + n[k], c->sine[k] = p + 2 * n[k];
        p += 3 * n[k];
        for (size_t i = 0; i < n[k]; i++) {
            c->cosine[k][i] = cos(node[k][i] * degree);
            c->sine[k][i] = sin(node[k][i] * degree);
        }
    }
    ff_cells_circle(node[FF_ZEMAX_ROTATION], n[FF_ZEMAX_ROTATION], 0, c->of[FF_ZEMAX_ROTATION]);
    ff_cells_polar(node[FF_ZEMAX_INCIDENCE], n[FF_ZEMAX_INCIDENCE], 90, c->of[FF_ZEMAX_INCIDENCE]);
    ff_cells_circle(node[FF_ZEMAX_AZIMUTH], n[FF_ZEMAX_AZIMUTH], symmetry == FF_ZEMAX_PLANE_SYMMETRICAL, c->of[FF_ZEMAX_AZIMUTH]);
    ff_cells_polar(node[FF_ZEMAX_RADIAL], n[FF_ZEMAX_RADIAL], -1, c->of[FF_ZEMAX_RADIAL]);
    return FF_OK;
}

double ff_zemax_block_integral(const ff_zemax_cells *c, const size_t n[FF_ZEMAX_AXES], size_t i, const double *v,
                               const unsigned char *valid)
{
    double sum = 0;
    for (size_t a = 0; a < n[FF_ZEMAX_AZIMUTH]; a++) {
        double row = 0;
        for (size_t r = 0; r < n[FF_ZEMAX_RADIAL]; r++, v++, valid++) {
            const double z = c->cosine[FF_ZEMAX_INCIDENCE][i] * c->cosine[FF_ZEMAX_RADIAL][r] +
                             c->sine[FF_ZEMAX_INCIDENCE][i] * c->sine[FF_ZEMAX_RADIAL][r] * c->cosine[FF_ZEMAX_AZIMUTH][a];
            if (*valid && z > 0) row += *v * z * c->of[FF_ZEMAX_RADIAL][r];
        }
        sum += row * c->of[FF_ZEMAX_AZIMUTH][a];
    }
    return sum;
}
