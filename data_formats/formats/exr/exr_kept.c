/* The names of the layout, and what a table that was read from an image keeps of it so that writing gives the same file. */
#include "internal_exr.h"
#include <stdio.h>
#include <stdlib.h>

const char *const ff_exr_direction[4] = {"direction.theta_i", "direction.phi_i", "direction.theta_o", "direction.phi_o"};
const char *const ff_exr_parametrisation[4] = {"list", "half-difference", "incident-exit", "specular"};
const char *const ff_exr_axis_name[4][4] = {
    {NULL},
    {FF_EXR_A("theta_h"), FF_EXR_A("phi_h"), FF_EXR_A("theta_d"), FF_EXR_A("phi_d")},
    {FF_EXR_A("theta_i"), FF_EXR_A("phi_i"), FF_EXR_A("theta_o"), FF_EXR_A("phi_o")},
    {FF_EXR_A("rotation"), FF_EXR_A("incidence"), FF_EXR_A("azimuth"), FF_EXR_A("radial")},
};

void ff_exr_kept_free(void *kept)
{
    free(kept);
}

static void *kept_copy(void *kept)
{
    ff_exr_kept *copy = malloc(sizeof *copy);
    if (copy) *copy = *(const ff_exr_kept *)kept;
    return copy;
}

ff_status ff_exr_keep(ff_table *t, int doubles, const char *source, ff_error *err)
{
    ff_exr_kept *kept = calloc(1, sizeof *kept);
    if (!kept) return ff_error_set(err, FF_ERR_MEMORY, NULL, 0, -1, "no memory for a table");
    kept->doubles = doubles;
    snprintf(kept->source, sizeof kept->source, "%s", source);
    t->kept = kept;
    t->kept_free = ff_exr_kept_free;
    t->kept_share = kept_copy;
    return FF_OK;
}

const ff_exr_kept *ff_exr_kept_of(const ff_table *t)
{
    return t->kept && t->kept_free == ff_exr_kept_free ? t->kept : NULL;
}
