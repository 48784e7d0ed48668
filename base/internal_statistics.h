/* Distributions that intervals and tests need. Closed forms and continued fractions, 1e-10 relative or better. */
#ifndef FF_INTERNAL_STATISTICS_H
#define FF_INTERNAL_STATISTICS_H

#define FF_NORMAL_975 1.959963984540054 /* quantiles of the standard normal distribution */
#define FF_NORMAL_95  1.644853626951472

/* P(|Z| > z) of a standard normal Z, z >= 0. */
double ff_normal_two_sided(double z);

/* P(X > x) of chi^2 with `dof` > 0 degrees of freedom (DLMF 8.2: the regularised incomplete gamma function Q). */
double ff_chi2_tail(double x, double dof);

/* P(|T| > t) of Student's t with `dof` > 0 degrees of freedom, t >= 0; of the normal distribution for dof = INFINITY. */
double ff_student_two_sided(double t, double dof);

/* The t with P(|T| <= t) = p of Student's t with `dof` > 0 degrees of freedom, p in (0, 1); the normal quantile for dof = INFINITY.
 */
double ff_student_quantile(double p, double dof);

/* Its inverse: the `dof` whose quantile at p is t; INFINITY for a t that is no larger than the normal distribution's. */
double ff_student_degrees(double p, double t);

/* P(X > x) of F with `dof` and `of_error` > 0 degrees of freedom; of chi^2 / dof for of_error = INFINITY. */
double ff_f_tail(double x, double dof, double of_error);

#endif
