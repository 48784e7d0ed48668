/* phong-walter: phong with beckmann's rational masking, as many renderers have it. Walter et al. 2007, eq. 30, and eq. 27 with
 * a = sqrt(n/2 + 1) / tan theta.
 *
 * With the stretch alpha = sqrt(2 / (n + 2)) of phong that is 1 / (alpha tan theta), so that Lambda does not depend on n otherwise.
 */
#include "internal_student_t.h"
#include "internal_terms.h"
#include "internal_walter.h"

static void stretch(const double *params, ff_stretch *s, double jac[][FF_D_COUNT])
{
    const double n = params[0], alpha = sqrt(2 / (n + 2));
    *s = (ff_stretch){.ax = alpha, .ay = alpha, .own = {n / 2 + 2}};
    if (jac) {
        jac[0][FF_D_AX] = jac[0][FF_D_AY] = -alpha / (2 * (n + 2));
        jac[0][FF_D_OWN] = 0.5;
    }
}

static void lambda(const ff_ndf_pass *pass, size_t n, const double *restrict v, double *restrict lam, double *restrict dlam,
                   double *const *dlam_own)
{
    (void)pass;
    ff_walter_lambda(n, v, lam, dlam);
    if (dlam_own) memset(dlam_own[0], 0, n * sizeof **dlam_own);
}

static const ff_param params[] = {{"n", "1", "exponent n of (h.z)^n", 0, 2e6, 20, FF_PARAM_LOG, 2}};

const ff_ndf FF_ISA_NAME(ff_ndf_phong_walter) = {
    .term =
        {.name = "phong-walter",
         .title = "power of the cosine, Walter's rational masking",
         .source = "Walter et al. 2007, eq. 30 and the rational approximation of eq. 27",
         .note =
             "isotropic; for comparison with renderers that use it: G1 is off by 0.125 at n = 1, 0.014 at n = 20, and has a kink. "
             "Prefer phong",
         .claims = FF_RECIPROCAL | FF_ISOTROPIC | FF_UNIT_AREA,
         .n_params = 1,
         .params = params},
    .stretch = stretch,
    .n_own = 1,
    .prepare = ff_student_t_prepare_profile,
    .profile = ff_student_t_profile,
    .lambda = lambda,
};
