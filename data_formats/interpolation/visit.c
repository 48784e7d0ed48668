/* The samples that can be interpolated between: measured, and above the horizon with both directions. */
#include "models/model_struct.h"
#include "internal_interpolate.h"
#include "data_formats/table/internal_table.h"

void ff_each_usable(const ff_table *t, ff_visitor *visit, void *context)
{
    enum { BLOCK = 512 };
    double plane[6][BLOCK], *const planes[6] = {plane[0], plane[1], plane[2], plane[3], plane[4], plane[5]};
    for (size_t first = 0; first < t->n; first += BLOCK) {
        const size_t count = t->n - first < BLOCK ? t->n - first : BLOCK;
        ff_table_directions(t, first, count, planes);
        for (size_t k = 0; k < count; k++) {
            const double wi[3] = {plane[0][k], plane[1][k], plane[2][k]}, wo[3] = {plane[3][k], plane[4][k], plane[5][k]};
            if (ff_table_is_measured(t, first + k) && wi[2] > FF_COS_MIN && wo[2] > FF_COS_MIN) visit(context, first + k, wi, wo);
        }
    }
}
