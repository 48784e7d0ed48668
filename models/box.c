/* Where the values of a parameter have a meaning, beyond its box too.
 *
 * The box of a reflectance ends at 1, which is right for a surface and calibrated data. In linear sRGB the red of a gold is 1.06,
 * and what instruments count is in units of its own. A model that is affine in a reflectance is valid there; one whose base lowers
 * what the lobes leave over is not. */
#include "internal_model.h"
#include <string.h>

#define LINEAR (FF_PARAM_PER_CHANNEL | FF_PARAM_LINEAR)
#define MOST   1e15 /* as that of the scale of a lobe */

static const ff_param wide[] = {
    {"f0", "1", "reflectance at normal incidence, F0", 0, MOST, 0.5, LINEAR, 0},
    {"f82", "1", "reflectance at cos = 1/7 (82 degrees), F82", 0, MOST, 0.7, LINEAR, 0},
    {"kd", "1", "diffuse albedo, kd", 0, MOST, 0.1, LINEAR, 0},
};
enum { N_WIDE = sizeof wide / sizeof *wide };

/* Is info one of those that end at 1, or one of these? */
static int is_reflectance(const ff_param *info)
{
    return info->flags == LINEAR && info->lo == 0 && (info->hi == 1 || info->hi == MOST);
}

/* Does a base of m depend on what its lobes reflect? */
static int is_coupled(const ff_model *m)
{
    uint32_t couples = 0;
    for (uint32_t b = 0; b < m->n_bases; b++) couples |= ff_diffuse_at(m->base[b].diffuse)->couples;
    return (couples & FF_COUPLES_CURVED) != 0;
}

const ff_param *ff_model_param_domain(const ff_model *m, const ff_model_param *p)
{
    if (!is_reflectance(p->info) || (p->lobe < m->n_lobes && is_coupled(m))) return p->info;
    for (int k = 0; k < N_WIDE; k++)
        if (strcmp(wide[k].name, p->info->name) == 0) return &wide[k];
    return p->info;
}

double ff_param_box_end(const ff_param *info)
{
    return info >= wide && info < wide + N_WIDE ? 1 : info->hi;
}
