/* beckmann-walter: Gaussian slopes with the rational masking that many renderers have. Walter et al. 2007, eq. 25 and 27.
 *
 *   p(q2) = exp(-q2) / pi,   Lambda: see internal_walter.h */
#include "internal_terms.h"
#include "internal_walter.h"

static void lambda(const ff_ndf_pass *pass, size_t n, const double *restrict v, double *restrict lam, double *restrict dlam,
                   double *const *dlam_own)
{
    (void)pass, (void)dlam_own;
    ff_walter_lambda(n, v, lam, dlam);
}

static const ff_param params[] = {FF_STRETCH_PARAMS};

const ff_ndf FF_ISA_NAME(ff_ndf_beckmann_walter) = {
    .term = {.name = "beckmann-walter",
             .title = "Gaussian slopes, Walter's rational masking",
             .source = "Walter et al. 2007, eq. 25 and the rational approximation of eq. 27",
             .note = "for comparison with renderers that use it; its masking has a kink at tan theta = 1 / (1.6 alpha), where G "
                     "exceeds 1 by 6e-5, and fits may stick: prefer beckmann",
             .claims = FF_RECIPROCAL | FF_UNIT_AREA,
             .n_params = FF_STRETCH_COUNT,
             .params = params},
    .profile = ff_beckmann_profile,
    .lambda = lambda,
};
