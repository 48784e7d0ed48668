/* tabulated: a profile of the user's, see ff_profile.h; stretched and masked as any other (Heitz 2014, section 3.4).
 *
 *   p(q2) = exp(cubic of the bin),  Lambda by quadrature, once for the table: no parameter but the stretch changes it
 *
 * The bins are even in q2 within an octave, so that the bits of q2 name the bin and the place in it. */
#include "internal_lambda_table.h"
#include "internal_tabulated.h"
#include "internal_terms.h"
#include "base/internal_vector_math.h"

static void profile(const ff_ndf_pass *pass, size_t n, const double *restrict q2, double *restrict p, double *restrict dlnp,
                    double *const *dlnp_own)
{
    (void)dlnp_own;
    const double lo = 0x1p-40, hi = 0x1p40 * (1 - 0x1p-53);
    const double *restrict c0 = pass->values->c[0], *restrict c1 = pass->values->c[1], *restrict c2 = pass->values->c[2],
                           *restrict c3 = pass->values->c[3];
    const int64_t first = (int64_t)(ff_bits(lo) >> 47);
    double log_p[FF_BLOCK];
    int64_t above = 0;
    for (size_t i = 0; i < n; i++) {
        const double x = q2[i] < lo ? lo : q2[i] > hi ? hi : q2[i];
        const uint64_t b = ff_bits(x);
        const int64_t k = (int64_t)(b >> 47) - first;
        const double u = ff_from_bits((b << 5 & UINT64_C(0x000fffffffffffff)) | UINT64_C(0x3ff0000000000000)) - 1;
        const double inv_width = ff_from_bits((UINT64_C(2051) - (b >> 52)) << 52); /* 32 / 2^e */
        const double s3 = c3[k], s2 = s3 * u + c2[k], s1 = s2 * u + c1[k];
        log_p[i] = s1 * u + c0[k];
        dlnp[i] = ((s3 * u + s2) * u + s1) * inv_width;
        above += q2[i] > hi ? 1 : 0;
    }
    for (size_t i = 0; i < n; i++) p[i] = ff_exp(log_p[i]);
    if (above == 0) return;
    for (size_t i = 0; i < n; i++) { /* q2^-2 */
        const double ratio = q2[i] > hi ? hi / q2[i] : 1;
        p[i] *= ratio * ratio;
        dlnp[i] = q2[i] > hi ? -2 / q2[i] : dlnp[i];
    }
}

_Static_assert(FF_LAMBDA_ROWS(0) == FF_PROFILE_LAMBDA, "the table of Lambda");

void ff_tabulated_lambda(ff_profile_table *t, double *storage)
{
    const ff_ndf_pass pass = {.values = t};
    ff_lambda_table_fine(&pass, profile, storage, t->lambda);
}

static void lambda(const ff_ndf_pass *pass, size_t n, const double *restrict v, double *restrict lam, double *restrict dlam,
                   double *const *dlam_own)
{
    ff_lambda_table_at(pass, pass->values->lambda, n, v, lam, dlam, dlam_own);
}

static const ff_param params[] = {
    {"alpha_x", "1", "stretch of the table along the tangent; 1 is the table itself", 1e-3, 100, 1, FF_PARAM_LOG, 0},
    {"alpha_y", "1", "stretch of the table across the tangent", 1e-3, 100, 1, FF_PARAM_LOG, 0},
    {"r_xy", "1", "correlation of the slopes, r_xy", -0.999, 0.999, 0, FF_PARAM_ATANH, 0},
    {"slope_x", "1", "mean slope of the surface along x", -1, 1, 0, FF_PARAM_HELD, 0},
    {"slope_y", "1", "mean slope of the surface along y", -1, 1, 0, FF_PARAM_HELD, 0},
};

const ff_ndf FF_ISA_NAME(ff_ndf_tabulated) = {
    .term = {.name = "tabulated",
             .title = "a table of D or of the slopes' density",
             .source = "Heitz 2014, section 3.4, arbitrary shape-invariant distributions",
             .note = "takes a file of two columns; alpha = 1 is the table itself, scaled to a projected area of 1",
             .claims = FF_RECIPROCAL | FF_PASSIVE | FF_UNIT_AREA | FF_WEAK_FURNACE,
             .n_params = FF_STRETCH_COUNT,
             .params = params},
    .needs_values = 1,
    .prepare = ff_lambda_table_whole,
    .profile = profile,
    .lambda = lambda,
};
