/** @file ff_albedo.h  Directional albedo of a model, and the weak white furnace test, by quadrature.
 *
 *  Both integrals run over half vectors in the slope space of the lobe, stretched to the unit circle, in polar coordinates. Rays
 *  are split where the integrand has a kink (horizon of wi, branches of the V-cavity), directions where it changes fast, and the
 *  Gauss-Legendre order doubles until two orders agree; their difference is the error that is reported. What the terms under the
 *  lobes add is integrated over the hemisphere of wi in the same way.
 *  Frame, errors  as ff_model.h: outputs are written only on FF_OK. Tables of distributions and of coupled terms are allocated for
 *           the time of a call.
 *  Time     1 to 100 ms a direction, the most at grazing view of strongly anisotropic lobes.
 *  Threads  every function may be called from many threads at once. */
#ifndef FF_ALBEDO_H
#define FF_ALBEDO_H
#include "ff_api.h"
#include "ff_model.h"
#ifdef __cplusplus
extern "C" {
#endif

/** An integral and the estimate of its error: the difference of the two finest quadratures. */
typedef struct ff_integral {
    double value, error;
} ff_integral;

/** Directional albedo rho(wo) = integral over the upper hemisphere of f(wi, wo) cos(theta_i) dwi, one per colour channel.
 *  @param shape    [n_shape]                 see ff_model_check
 *  @param channel  [n_channels][n_channel]
 *  @param wo   unit vector, wo.z > FF_COS_MIN
 *  @param out  [n_channels] out
 *  FF_ERR_RANGE, FF_ERR_UNSUPPORTED as ff_model_check; FF_ERR_RANGE for a wo that is no unit vector above the horizon;
 *  FF_ERR_MEMORY. */
FF_API ff_status ff_albedo_directional(const ff_model *m, ff_isa isa, size_t n_channels, const double *shape, const double *channel,
                                       const double wo[3], ff_integral *out, ff_error *err);

/** Weak white furnace integral of lobe `lobe`: integral of G1(wo) D(h) / (4 |wo.n'|) over all wi, those below the horizon included,
 *  with n' the mesosurface (Heitz 2014, equation 19). G1 is that of the facet for v-cavity, and else the masking's G2 for light
 * along the normal, which casts no shadow: 1 / (1 + Lambda(wo)) for every Smith form, 1 for `none`. Where it is not claimed to be 1
 * (see below) its distance from 1 measures what is missing; it is infinite where the facets are (vmf, whose normals near the
 * horizon have no finite area).
 *  @param shape  [n_shape]
 *  FF_ERR_RANGE also when wo sees the mesosurface from below (wo.z <= slope_x wo.x + slope_y wo.y); FF_ERR_UNSUPPORTED when the
 *  model has no such lobe, or its masking is no product of one direction's by another's (kelemen); FF_ERR_MEMORY. */
FF_API ff_status ff_albedo_weak_furnace(const ff_model *m, ff_isa isa, const double *shape, uint32_t lobe, const double wo[3],
                                        ff_integral *out, ff_error *err);

/** 1 where the model has a lobe `lobe` whose terms claim that its weak furnace integral is 1: v-cavity on a distribution
 * with FF_UNIT_AREA, a Smith form (one that uses the distribution's Lambda) on one with FF_WEAK_FURNACE; else 0. */
FF_API int ff_albedo_weak_furnace_claimed(const ff_model *m, uint32_t lobe);

#ifdef __cplusplus
}
#endif
#endif
