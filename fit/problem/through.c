/* Data that are means over an aperture: the directions that these are made about, and how far they reach. */
#include "internal_problem.h"
#include <stdlib.h>
#include <string.h>

/* tan^2 of directions that an aperture reaches beyond those of the samples: lower and higher by its radius. */
static void widen(struct ff_problem *p, double reach)
{
    const double lo = atan(sqrt(p->tan2_lo)) - reach, hi = atan(sqrt(p->tan2_hi)) + reach;
    p->tan2_lo = lo > 0 ? tan(lo) * tan(lo) : 0;
    p->tan2_hi = hi < 0.5 * 3.14159265358979323846 ? tan(hi) * tan(hi) : INFINITY;
}

ff_status ff_problem_see_through(struct ff_problem *p, const ff_aperture *a, ff_error *err)
{
    if (!a) return FF_OK;
    if (!ff_aperture_valid(a))
        return ff_error_set(err, FF_ERR_RANGE, NULL, 0, -1,
                            "an aperture has half angles of 0 to %.3g degrees, found %g, %g and a source of %g",
                            FF_APERTURE_MOST / 0.017453292519943295, a->half / 0.017453292519943295,
                            a->across / 0.017453292519943295, a->source / 0.017453292519943295);
    if (!ff_aperture_extended(a)) return FF_OK;
    p->rules = ff_rules_new(a, FF_APERTURE_OF_FITS);
    if (!p->rules) return ff_error_set(err, FF_ERR_MEMORY, NULL, 0, -1, "out of memory");
    widen(p, p->rules->reach);
    return FF_OK;
}

void ff_problem_put_directions(struct ff_problem *p, size_t block, const ff_dirs *w)
{
    const double *const from[6] = {w->wix, w->wiy, w->wiz, w->wox, w->woy, w->woz};
    for (int d = 0; d < 6; d++) memcpy(ff_problem_plane(p, block, p->direction + d), from[d], FF_BLOCK * sizeof(double));
}
