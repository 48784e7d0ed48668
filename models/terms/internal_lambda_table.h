/* Smith's Lambda of any isotropic profile p(q2), where no closed form is to be had (Heitz 2014, section 3.4, "arbitrary
 * shape-invariant distributions"): quadrature into a table that a pass builds for its parameters, and its interpolation.
 *
 *   Lambda(mu) = 2 integral_0^inf (s - atan s) g dy,   y = ln(t / mu),  s = sqrt(e^(2y) - 1),  g = t^2 p(t^2),  mu = cot theta_o
 *   Q(mu)      = 2 integral_0^inf atan(s) g dy,        d Lambda / d ln mu = -(Lambda + Q)
 *   mu P2(mu)  = 2 integral_0^inf g / s dy,            d Q / d ln mu      = -mu P2
 *
 * Q is the tail and P2 the density of the slope along one direction. On a lattice of t that is even in ln t these are
 * convolutions: the profile is asked once for each point, and the trapezoidal rule, corrected near y = 0 where the kernels go as
 * y^(3/2), y^(1/2) and y^(-1/2), has the accuracy of doubles for profiles that are smooth in ln t (no steeper than e^(-q2)).
 *
 * Lambda is then a polynomial of degree 5 in v = 1/mu^2 on each of 16 bins per octave of v, with the values and the first two
 * derivatives above at the ends of the bins. The error is at most 1.5e-10 (1 + Lambda) (1e-10 measured); d Lambda / d v
 * is the derivative of the polynomial, and the derivatives by the distribution's own parameters go through the same
 * linear steps as Lambda itself. The lattice is fixed: what a pass's range of v leaves out does not change what it has.
 *
 * The table holds 2^-40 <= v < 2^60. Below, Lambda goes as v, above Lambda + 1/2 as sqrt(v): a profile must fall at least as q^-4
 * beyond q = 1e6, and the integrals end at q = 2^34. */
#ifndef FF_INTERNAL_LAMBDA_TABLE_H
#define FF_INTERNAL_LAMBDA_TABLE_H
#include "internal_term.h"

enum { FF_LAMBDA_OCTAVE_LO = -40, FF_LAMBDA_OCTAVE_HI = 60, FF_LAMBDA_BINS = 16 * (FF_LAMBDA_OCTAVE_HI - FF_LAMBDA_OCTAVE_LO) };
enum { FF_LAMBDA_C = 11 }; /* the table keeps c[FF_LAMBDA_C] and those behind it for itself */

/* Doubles of a table, and of what it is made from: the lattice, the weights and the nodes, too many for a stack. */
#define FF_LAMBDA_ROWS(n_own) ((size_t)6 * FF_LAMBDA_BINS * (size_t)(1 + (n_own)))
enum { FF_LAMBDA_ROOM = 9056 };

/* ff_ndf.table_size of a distribution that uses the table: the room lies behind it. */
#define FF_LAMBDA_TABLE(n_own) (FF_LAMBDA_ROWS(n_own) + (size_t)FF_LAMBDA_ROOM)

#define ff_lambda_table_build FF_ISA_NAME(ff_lambda_table_build)
#define ff_lambda_table       FF_ISA_NAME(ff_lambda_table)
#define ff_lambda_table_fine  FF_ISA_NAME(ff_lambda_table_fine)
#define ff_lambda_table_whole FF_ISA_NAME(ff_lambda_table_whole)
#define ff_lambda_table_at    FF_ISA_NAME(ff_lambda_table_at)

/* Fills pass->table for v_lo .. v_hi from the kernel `profile`, for which the pass is ready. v_lo > v_hi: Lambda will not be asked
 * for, and there is nothing to do. */
void ff_lambda_table_build(ff_ndf_pass *pass, int n_own,
                           void (*profile)(const ff_ndf_pass *pass, size_t n, const double *restrict q2, double *restrict p,
                                           double *restrict dlnp, double *const *dlnp_own));
/* ff_ndf.lambda from the table. */
void ff_lambda_table(const ff_ndf_pass *pass, size_t n, const double *restrict v, double *restrict lam, double *restrict dlam,
                     double *const *dlam_own);

/* ---- a profile that no parameter changes, and that is not smooth ----------------------------- */

/* Fills rows [FF_LAMBDA_ROWS(0)], the whole table, by a lattice of 1024 points per octave: 65,000 calls of the profile.
 * storage [FF_LAMBDA_FINE]. */
enum { FF_LAMBDA_FINE = 76800 };
void ff_lambda_table_fine(const ff_ndf_pass *pass,
                          void (*profile)(const ff_ndf_pass *pass, size_t n, const double *restrict q2, double *restrict p,
                                          double *restrict dlnp, double *const *dlnp_own),
                          double *storage, double *rows);
/* Makes the pass ready for ff_lambda_table_at with such rows, which is ff_lambda_table but for where they are. */
void ff_lambda_table_whole(ff_ndf_pass *pass);
void ff_lambda_table_at(const ff_ndf_pass *pass, const double *restrict rows, size_t n, const double *restrict v,
                        double *restrict lam, double *restrict dlam, double *const *dlam_own);
#endif
