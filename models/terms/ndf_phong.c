/* phong: D = (n + 2) / (2 pi) mz^n, isotropic. Walter et al. 2007, eq. 30.
 *
 * Its slopes are student-t with gamma = n/2 + 2 and alpha = sqrt(2 / (n + 2)), so that Smith's Lambda is exact in closed form
 * and not borrowed from beckmann as in the source (which is off by 0.125 in G1 at n = 1). */
#include "internal_terms.h"
#include "internal_student_t.h"

static void stretch(const double *params, ff_stretch *s, double jac[][FF_D_COUNT])
{
    const double n = params[0], alpha = sqrt(2 / (n + 2));
    *s = (ff_stretch){.ax = alpha, .ay = alpha, .own = {n / 2 + 2}};
    if (jac) {
        jac[0][FF_D_AX] = jac[0][FF_D_AY] = -alpha / (2 * (n + 2));
        jac[0][FF_D_OWN] = 0.5;
    }
}

static const ff_param params[] = {{"n", "1", "exponent n of (h.z)^n", 0, 2e6, 20, FF_PARAM_LOG, 2}};

const ff_ndf FF_ISA_NAME(ff_ndf_phong) = {
    .term = {.name = "phong",
             .also = "blinn-phong,blinn",
             .title = "power of the cosine of the half vector",
             .source = "Walter et al. 2007, eq. 30; Heitz 2014, section 7; Lambda of student-t with gamma = n/2 + 2",
             .note = "isotropic; D = (n+2)/(2 pi) cos^n, the normalisation for distributions of normals",
             .claims = FF_RECIPROCAL | FF_PASSIVE | FF_ISOTROPIC | FF_UNIT_AREA | FF_WEAK_FURNACE,
             .n_params = 1,
             .params = params},
    .stretch = stretch,
    .n_own = 1,
    .table_size = FF_STUDENT_T_TABLE,
    .prepare = ff_student_t_prepare,
    .profile = ff_student_t_profile,
    .lambda = ff_student_t_lambda,
};
