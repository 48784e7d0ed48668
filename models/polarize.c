/* Models of polarized light: every Fresnel factor becomes that of a source of which a share is s polarized. */
#include "internal_model.h"
#include <math.h>
#include <stdio.h>
#include <string.h>

/* The Fresnel term of polarized light that a term is the mean of: its own name and "-polarized", or itself. -1 when there is none.
 */
static int polarized(int fresnel)
{
    static const char end[] = "-polarized";
    const char *plain = ff_fresnel_at(fresnel)->term.name;
    for (size_t k = 0; k < ff_term_count(FF_FRESNEL); k++) {
        const char *name = ff_term_at(FF_FRESNEL, k)->name;
        const size_t n = strlen(name), tail = sizeof end - 1;
        if (n <= tail || strcmp(name + n - tail, end) != 0) continue;
        if (!strcmp(name, plain) || (strlen(plain) == n - tail && !strncmp(name, plain, n - tail))) return (int)k;
    }
    return -1;
}

/* What was said of the parameters of `from` holds in `to`, which has them all. */
static void keep(const ff_model *from, ff_model *to)
{
    memcpy(to->shape, from->shape, sizeof to->shape);
    for (uint32_t k = 0; k < from->n_channel; k++) {
        const ff_model_param *old = &from->channel[k];
        ff_model_param *p = ff_model_param_of(to, ff_model_param_find(to, old->name));
        p->init = old->init, p->lo = old->lo, p->hi = old->hi, p->flags = old->flags;
    }
}

ff_status ff_model_polarize(ff_model *m, double s_share, ff_error *err)
{
    if (!(s_share >= 0 && s_share <= 1))
        return ff_error_set(err, FF_ERR_RANGE, NULL, 0, -1, "a share of s light of %g; expected 0 to 1", s_share);
    ff_model out = *m;
    int some = 0;
    for (uint32_t l = 0; l < m->n_lobes; l++) {
        if (m->lobe[l].fresnel == FF_FRESNEL_SHARED) continue;
        const int fresnel = polarized(m->lobe[l].fresnel);
        if (fresnel < 0)
            return ff_error_set(err, FF_ERR_UNSUPPORTED, NULL, 0, -1,
                                "%s says nothing of polarized light; the Fresnel terms dielectric and conductor do",
                                ff_fresnel_at(m->lobe[l].fresnel)->term.name);
        out.lobe[l].fresnel = fresnel;
        some = 1;
    }
    if (!some) return ff_error_set(err, FF_ERR_UNSUPPORTED, NULL, 0, -1, "polarized light: the model has no Fresnel factor");
    ff_status status = ff_model_finish(&out, err);
    if (status) return status;
    keep(m, &out);
    for (uint32_t l = 0; l < out.n_lobes && !status; l++) {
        char name[32];
        if (out.lobe[l].fresnel == FF_FRESNEL_SHARED) continue;
        if (l)
            snprintf(name, sizeof name, "lobe%u.s_share", l + 1);
        else
            snprintf(name, sizeof name, "s_share");
        status = ff_model_hold(&out, name, s_share, err);
    }
    if (!status) *m = out;
    return status;
}
