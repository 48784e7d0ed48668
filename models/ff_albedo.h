/** @file ff_albedo.h  Directional albedo of a model, and the weak white furnace test, by quadrature.
 *
 *  Both integrals run over half vectors in the slope space of the lobe, stretched to the unit circle, in polar coordinates. Rays
 *  are split where the integrand has a kink (horizon of wi, branches of the V-cavity), directions where it changes fast, and the
 *  Gauss-Legendre order doubles until two orders agree; their difference is the error that is reported.
 *  Frame, errors  as ff_model.h: outputs are written only on FF_OK. Nothing allocates; the stack use is below 256 KiB.
 *  Time     1 to 100 ms a direction, the most at grazing view of strongly anisotropic lobes.
 *  Threads  every function may be called from many threads at once. */
#ifndef FF_ALBEDO_H
#define FF_ALBEDO_H
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
 *  FF_ERR_RANGE, FF_ERR_UNSUPPORTED as ff_model_check; FF_ERR_RANGE for a wo that is no unit vector above the horizon. */
ff_status ff_albedo_directional(const ff_model *m, ff_isa isa, size_t n_channels, const double *shape, const double *channel,
                                const double wo[3], ff_integral *out, ff_error *err);

/** Weak white furnace integral of lobe `lobe`: integral of G1(wo) D(h) / (4 |wo.n'|) over all wi, those below the horizon included,
 *  with n' the mesosurface (Heitz 2014, equation 19). It is 1 for a masking that claims FF_WEAK_FURNACE. G1 is the lobe's own for
 *  smith-masking-only and v-cavity; 1 / (1 + Lambda(wo)) for the other Smith forms; 1 for the masking `none`.
 *  @param shape  [n_shape]
 *  FF_ERR_RANGE also when wo sees the mesosurface from below (wo.z <= slope_x wo.x + slope_y wo.y); FF_ERR_UNSUPPORTED when the
 *  model has no such lobe. */
ff_status ff_albedo_weak_furnace(const ff_model *m, ff_isa isa, const double *shape, uint32_t lobe, const double wo[3],
                                 ff_integral *out, ff_error *err);

#ifdef __cplusplus
}
#endif
#endif
