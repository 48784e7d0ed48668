/* Which parameters are free, and the coordinates they are searched in. */
#include "internal_fit.h"
#include <math.h>
#include <string.h>

double ff_coordinate(const ff_param *info, double value)
{
    if (info->flags & FF_PARAM_LOG) return log(value + info->offset);
    return info->flags & FF_PARAM_ATANH ? atanh(value) : value;
}

double ff_coordinate_value(const ff_param *info, double coordinate)
{
    double v = coordinate;
    if (info->flags & FF_PARAM_LOG) v = exp(coordinate) - info->offset;
    if (info->flags & FF_PARAM_ATANH) v = tanh(coordinate);
    return fmin(fmax(v, info->lo), info->hi); /* rounding at the box */
}

double ff_coordinate_slope(const ff_param *info, double value)
{
    if (info->flags & FF_PARAM_LOG) return value + info->offset;
    return info->flags & FF_PARAM_ATANH ? 1 - value * value : 1;
}

/* Is the shape parameter of this name free? */
static int is_free(const char *name, ff_shape shape, int mean_slope, const ff_param *info)
{
    if (strcmp(name, "alpha_y") == 0) return shape != FF_SHAPE_ISOTROPIC;
    if (strcmp(name, "r_xy") == 0) return shape == FF_SHAPE_CORRELATED;
    if (info->flags & FF_PARAM_HELD) return mean_slope;
    return 1;
}

static int has_parameter(const ff_model *m, uint32_t lobe, const char *name)
{
    const ff_term *t = &ff_ndf_at(m->lobe[lobe].ndf)->term;
    for (uint32_t k = 0; k < t->n_params; k++)
        if (strcmp(t->params[k].name, name) == 0) return 1;
    return 0;
}

ff_status ff_layout_init(const ff_model *m, size_t n_channels, ff_shape shape, int mean_slope, ff_layout *out, ff_error *err)
{
    ff_layout l = {.m = m, .mode = FF_ISOTROPIC_MODE, .n_channels = n_channels};
    for (uint32_t k = 0; k < m->n_lobes; k++) {
        const ff_term *ndf = &ff_ndf_at(m->lobe[k].ndf)->term, *masking = &ff_masking_at(m->lobe[k].masking)->term;
        if (shape != FF_SHAPE_ISOTROPIC && !has_parameter(m, k, "alpha_y"))
            return ff_error_set(err, FF_ERR_UNSUPPORTED, NULL, 0, -1, "%s is isotropic: it cannot be fitted with the shape '%s'",
                                ndf->name, ff_shape_name((int)shape));
        if (mean_slope && (masking->claims & FF_NEEDS_CENTRED))
            return ff_error_set(err, FF_ERR_UNSUPPORTED, NULL, 0, -1, "%s is undefined with a mean slope", masking->name);
        if (mean_slope && !has_parameter(m, k, "slope_x"))
            return ff_error_set(err, FF_ERR_UNSUPPORTED, NULL, 0, -1, "%s has no mean slope", ndf->name);
    }
    if (shape != FF_SHAPE_ISOTROPIC) l.mode = FF_CENTRED_MODE;
    if (mean_slope) l.mode = FF_TILTED_MODE;
    for (uint32_t k = 0; k < m->n_shape; k++) {
        const char *name = m->shape[k].info->name;
        if (!is_free(name, shape, mean_slope, m->shape[k].info)) continue;
        l.tied[l.n_free] = shape == FF_SHAPE_ISOTROPIC && strcmp(name, "alpha_x") == 0;
        l.index[l.n_free++] = k;
    }
    l.P = l.n_free + n_channels * m->n_channel;
    *out = l;
    return FF_OK;
}

void ff_layout_pack(const ff_layout *l, const double *shape, double *x)
{
    for (uint32_t k = 0; k < l->n_free; k++) x[k] = ff_coordinate(l->m->shape[l->index[k]].info, shape[l->index[k]]);
}

void ff_layout_unpack(const ff_layout *l, const double *x, double *shape)
{
    for (uint32_t k = 0; k < l->n_free; k++) {
        const uint32_t i = l->index[k];
        shape[i] = ff_coordinate_value(l->m->shape[i].info, x[k]);
        if (l->tied[k]) shape[i + 1] = shape[i]; /* alpha_y follows alpha_x */
    }
}

void ff_layout_pass(const ff_layout *l, const struct ff_problem *p, const ff_fit_options *o, const double *shape,
                    const double *channel, ff_pass *pass)
{
    const ff_model *m = l->m;
    memset(pass, 0, sizeof *pass);
    pass->kernels = ff_kernels_get(p->isa);
    pass->p = p;
    pass->m = m;
    pass->channel = channel;
    pass->robust = p->surrogate ? FF_ROBUST_NONE : o->robust;
    pass->robust_scale = o->robust_scale;
    double jac[FF_MAX_LOBES][FF_MAX_SHAPE][FF_D_COUNT];
    for (uint32_t k = 0; k < m->n_lobes; k++) {
        ff_lobe_pass *lobe = &pass->lobe[k];
        lobe->ndf = m->lobe[k].ndf;
        lobe->masking = m->lobe[k].masking;
        lobe->mode = ff_ndf_at(lobe->ndf)->term.claims & FF_ISOTROPIC ? FF_ISOTROPIC_MODE : l->mode;
        ff_model_stretch(m, k, shape, &lobe->s, jac[k]);
        ff_lobe_pass_prepare(pass->kernels, lobe);
    }
    pass->n_shape = l->n_free;
    for (uint32_t k = 0; k < l->n_free; k++) {
        ff_shape_column *c = &pass->shape[k];
        c->lobe = m->shape[l->index[k]].lobe;
        memcpy(c->d, jac[c->lobe][l->index[k] - m->lobe[c->lobe].shape0], sizeof c->d);
        if (pass->lobe[c->lobe].mode == FF_ISOTROPIC_MODE)
            c->d[FF_D_AY] = 0; /* FF_D_AX is the derivative by both */
        else if (l->tied[k])
            c->d[FF_D_AY] = 1;
    }
}
