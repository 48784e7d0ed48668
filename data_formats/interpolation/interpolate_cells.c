/* Values that are constant within cells. */
#include "internal_interpolate.h"
#include "data_formats/table/internal_table.h"
#include <math.h>

static const double degrees = 180 / 3.14159265358979323846;

/* 1 when the pair is where the sample stands. */
static int is_centre(const ff_table *t, size_t i, const double wi[3], const double wo[3])
{
    double w[6], apart = 0, *const planes[6] = {w, w + 1, w + 2, w + 3, w + 4, w + 5};
    ff_table_directions(t, i, 1, planes);
    for (int k = 0; k < 3; k++) apart = fmax(apart, fmax(fabs(w[k] - wi[k]), fabs(w[3 + k] - wo[k])));
    return apart * degrees < ff_same_place;
}

ff_found ff_cells_at(const ff_interpolant *p, const double wi[3], const double wo[3], double *value, size_t stride)
{
    const ff_table *t = p->t;
    const size_t i = t->cells->find(t->cells, wi, wo);
    const int known = i != SIZE_MAX && ff_table_is_measured(t, i);
    for (size_t c = 0; c < t->n_channels; c++) value[c * stride] = known ? t->channels[c].scale * t->value[c * t->n + i] : 0;
    return !known ? FF_FOUND_BEYOND : is_centre(t, i, wi, wo) ? FF_FOUND_SAMPLE : FF_FOUND_BETWEEN;
}
