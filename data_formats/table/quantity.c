/* What the numbers of a file stand for. */
#include "internal_table.h"
#include "models/model_struct.h"

static const double pi = 3.14159265358979323846;

const char *ff_quantity_name(int quantity)
{
    static const char *const name[3] = {"brdf", "brdf-cos", "reflectance-factor"};
    return quantity >= 0 && quantity < 3 ? name[quantity] : NULL;
}

ff_quantity ff_read_quantity(const ff_read_options *o, ff_quantity in_file)
{
    return o->quantity >= 0 ? (ff_quantity)o->quantity : in_file;
}

static void divide_by_cosine(ff_table *t)
{
    enum { BLOCK = 512 };
    double plane[6][BLOCK], *const planes[6] = {plane[0], plane[1], plane[2], plane[3], plane[4], plane[5]};
    for (size_t first = 0; first < t->n; first += BLOCK) {
        const size_t n = t->n - first < BLOCK ? t->n - first : BLOCK;
        ff_table_directions(t, first, n, planes);
        for (size_t k = 0; k < n; k++) {
            const int gone = !(plane[5][k] > FF_COS_MIN);
            if (gone) t->valid[first + k] = 0;
            for (size_t c = 0; c < t->n_channels; c++) {
                double *v = t->value + c * t->n + first + k, *s = t->sigma ? t->sigma + c * t->n + first + k : v;
                *v = gone ? 0 : *v / plane[5][k];
                if (s != v) *s = gone ? 0 : *s / plane[5][k];
            }
        }
    }
}

static void multiply_by_cosine(ff_table *t)
{
    enum { BLOCK = 512 };
    double plane[6][BLOCK], *const planes[6] = {plane[0], plane[1], plane[2], plane[3], plane[4], plane[5]};
    for (size_t first = 0; first < t->n; first += BLOCK) {
        const size_t n = t->n - first < BLOCK ? t->n - first : BLOCK;
        ff_table_directions(t, first, n, planes);
        for (size_t k = 0; k < n; k++)
            for (size_t c = 0; c < t->n_channels; c++) {
                const size_t at = c * t->n + first + k;
                t->value[at] *= plane[5][k];
                if (t->sigma) t->sigma[at] *= plane[5][k];
            }
    }
}

void ff_table_unset_quantity(ff_table *t)
{
    if (t->quantity == FF_BRDF_COS) multiply_by_cosine(t);
    for (size_t c = 0; c < t->n_channels && t->quantity == FF_REFLECTANCE_FACTOR; c++) t->channels[c].scale *= pi;
    t->quantity = FF_BRDF;
}

void ff_table_set_quantity(ff_table *t, ff_quantity quantity)
{
    t->quantity = quantity;
    if (quantity == FF_BRDF_COS) divide_by_cosine(t);
    for (size_t c = 0; c < t->n_channels && quantity == FF_REFLECTANCE_FACTOR; c++) t->channels[c].scale /= pi;
}
