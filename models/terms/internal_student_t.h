/* Kernels of Student's t slopes, shared by student-t and phong.
 *
 *   nu = gamma - 1 > 1/2,  A = 1 + a^2 / nu,  E = A^-nu
 *   Q(a)      = tail of the 1D slope distribution = I_{1/A}(nu, 1/2) / 2 = E m(a)
 *   Lambda(a) = E (K sqrt(A) / a - m(a)),  K = nu^(3/2) Gamma(nu + 1/2) / (sqrt(pi) Gamma(nu + 1) (2 nu - 1))
 *
 * m is smooth and positive; only nu enters it. A pass fixes nu, so m and d m / d nu become polynomials in
 * t = 2 s / s_max - 1 with s = 1 / (1 + c R), R = sqrt(1 + nu / a^2), c = 3 / sqrt(max(nu, 1)): m is analytic in s but for a point
 * far from [0, s_max], and 20 coefficients leave an error of 1e-15. They are made by interpolation at Chebyshev nodes where the
 * incomplete beta function is evaluated by its continued fraction with a complex nu: the imaginary part of a tiny step is the
 * exact derivative. */
#ifndef FF_INTERNAL_STUDENT_T_H
#define FF_INTERNAL_STUDENT_T_H
#include "internal_term.h"
#include "base/internal_vector_math.h"

enum { FF_POLY = 20, FF_STUDENT_T_TABLE = 2 * FF_POLY }; /* coefficients of m and of d m / d nu by rising power of t */

#define ff_student_t_prepare         FF_ISA_NAME(ff_student_t_prepare)
#define ff_student_t_prepare_profile FF_ISA_NAME(ff_student_t_prepare_profile)
#define ff_student_t_profile         FF_ISA_NAME(ff_student_t_profile)
#define ff_student_t_lambda          FF_ISA_NAME(ff_student_t_lambda)

void ff_student_t_prepare(ff_ndf_pass *pass);
void ff_student_t_prepare_profile(ff_ndf_pass *pass); /* for the profile alone */
void ff_student_t_profile(const ff_ndf_pass *pass, size_t n, const double *restrict q2, double *restrict p, double *restrict dlnp,
                          double *const *dlnp_own);
void ff_student_t_lambda(const ff_ndf_pass *pass, size_t n, const double *restrict v, double *restrict lam, double *restrict dlam,
                         double *const *dlam_own);
#endif
