/* The curve of a distribution of normals, its area and its Lambda, with their derivatives by the coefficients.
 *
 *   A      = 2 pi integral e^psi / (1 + q^2)^2 q dq
 *   Lambda = (2 / mu) integral_mu^inf (sqrt(t^2 - mu^2) - mu acos(mu / t)) t P22(t) dt       Heitz 2014, section 3.4
 *          = 2 integral (s - atan s) t^2 P22(t) d ln t,  s = sqrt(t^2 / mu^2 - 1),  mu = cot theta
 *
 * Both are sums over one lattice that is even in ln t, where the trapezoidal rule is good to 1e-6 and better: the integrands are
 * smooth but for the y^(3/2) with which the second one begins. Lambda is linear in P22, so that its derivatives are those of the
 * sum exactly. */
#include "internal_ndf.h"
#include "base/internal_vector_math.h"
#include <stdlib.h>

enum { PER_OCTAVE = 32, OCTAVES_BELOW = 14, OCTAVES_ABOVE = 20 };
#define LAMBDA_STEP 0.05
enum { MOST_LAMBDA = 160 };

/* ---- stencils -------------------------------------------------------------------------------- */

ff_stencil ff_curve_stencil(const ff_curve *curve, double q)
{
    const double x = q / curve->scale;
    return ff_curve_stencil_at(curve->top, fmin(ff_log(x + sqrt(1 + x * x)) / curve->step, curve->end));
}

double ff_curve_node(const ff_curve *curve, int k)
{
    return curve->scale * sinh(k * curve->step);
}

void ff_curve_interpolate(const ff_curve *curve, const double *value, double *c)
{
    const int top = curve->top;
    double pivot[FF_NDF_MOST_TOP + 1];
    /* (c[k-1] + 4 c[k] + c[k+1]) / 6 = value[k], c[-1] = c[1]; the last coefficient is the last value */
    c[top] = value[top];
    pivot[0] = 2; /* of the first row over 2 */
    c[0] = 3 * value[0];
    for (int k = 1; k < top; k++) {
        const double factor = 1 / pivot[k - 1];
        pivot[k] = 4 - factor;
        c[k] = 6 * value[k] - factor * c[k - 1];
    }
    for (int k = top - 1; k >= 0; k--) c[k] = (c[k] - c[k + 1]) / pivot[k];
}

/* ---- lattices -------------------------------------------------------------------------------- */

/* Row of Lambda's integral for the direction of cotangent mu: what multiplies e^psi. */
static void fill_kernel(const ff_curve *curve, double mu, double *row)
{
    for (size_t l = 0; l < curve->n_slopes; l++) {
        const double ratio = curve->slope[l] / mu, s = ratio > 1 ? sqrt(ratio * ratio - 1) : 0;
        row[l] = (s - atan(s)) * curve->measure[l] / FF_PI;
    }
}

ff_status ff_curve_new(double scale, double step, int top, int lambda, double tan_max, ff_curve *out)
{
    const double end = asinh(tan_max), ln_step = log(2) / PER_OCTAVE;
    ff_curve c = {.top = top, .scale = scale, .step = step};
    c.end = asinh(tan(FF_NDF_END) / scale) / c.step;
    if (lambda) {
        c.lambda_step = fmax(LAMBDA_STEP, end / (MOST_LAMBDA - 1));
        c.n_lambda = (int)fmax(ceil(end / c.lambda_step), 3) + 1;
        c.lambda_tan = sinh((c.n_lambda - 1) * c.lambda_step);
    }
    const double first = fmin(log2(scale) - OCTAVES_BELOW, -log2(tan_max) - 1);
    c.n_slopes = (size_t)((OCTAVES_ABOVE - first) * PER_OCTAVE) + 1;
    c.slope = malloc(c.n_slopes * sizeof *c.slope);
    c.measure = malloc(c.n_slopes * sizeof *c.measure);
    c.stencil = malloc(c.n_slopes * sizeof *c.stencil);
    c.kernel = malloc(((size_t)c.n_lambda * c.n_slopes + 1) * sizeof *c.kernel);
    if (!c.slope || !c.measure || !c.stencil || !c.kernel) {
        ff_curve_free(&c);
        return FF_ERR_MEMORY;
    }
    for (size_t l = 0; l < c.n_slopes; l++) {
        const double t = exp2(first + (double)l / PER_OCTAVE), inv_cos2 = 1 + t * t;
        c.slope[l] = t;
        c.measure[l] = 2 * FF_PI * ln_step * t * t / (inv_cos2 * inv_cos2);
        c.stencil[l] = ff_curve_stencil(&c, t);
    }
    for (int j = 0; j < c.n_lambda; j++) /* node 0 looks along the normal: Lambda = 0 */
        fill_kernel(&c, j ? 1 / sinh(j * c.lambda_step) : INFINITY, c.kernel + (size_t)j * c.n_slopes);
    *out = c;
    return FF_OK;
}

void ff_curve_free(ff_curve *curve)
{
    free(curve->slope);
    free(curve->measure);
    free(curve->stencil);
    free(curve->kernel);
    *curve = (ff_curve){.top = 0};
}

/* ---- what follows from coefficients ---------------------------------------------------------- */

ff_status ff_curve_state_new(const ff_curve *curve, ff_curve_state *out)
{
    const size_t n = (size_t)curve->top + 1, J = (size_t)curve->n_lambda;
    ff_curve_state s = {.c = calloc(2 * n + J + J * n + curve->n_slopes, sizeof *s.c)};
    if (!s.c) return FF_ERR_MEMORY;
    s.d_area = s.c + n;
    s.lambda = s.d_area + n;
    s.d_lambda = s.lambda + J;
    s.exp_psi = s.d_lambda + J * n;
    *out = s;
    return FF_OK;
}

void ff_curve_state_free(ff_curve_state *state)
{
    free(state->c);
    *state = (ff_curve_state){.c = NULL};
}

/* sum = sum over slopes of row e^psi; d [top + 1] its derivatives by the coefficients. */
static double integrate(const ff_curve *curve, const double *row, const double *exp_psi, double *d)
{
    double sum = 0;
    for (int k = 0; k <= curve->top; k++) d[k] = 0;
    for (size_t l = 0; l < curve->n_slopes; l++) {
        const double x = row[l] * exp_psi[l];
        const ff_stencil *s = &curve->stencil[l];
        sum += x;
        for (int i = 0; i < 4; i++) d[s->first + i] += x * s->w[i];
    }
    return sum;
}

void ff_curve_evaluate(const ff_curve *curve, ff_curve_state *state)
{
    const size_t n = (size_t)curve->top + 1;
    for (size_t l = 0; l < curve->n_slopes; l++) state->exp_psi[l] = ff_exp(ff_stencil_apply(&curve->stencil[l], state->c));
    state->area = integrate(curve, curve->measure, state->exp_psi, state->d_area);
    for (size_t k = 0; k < n; k++) state->d_area[k] /= state->area;
    for (int j = 0; j < curve->n_lambda; j++) {
        double *d = state->d_lambda + (size_t)j * n;
        state->lambda[j] = integrate(curve, curve->kernel + (size_t)j * curve->n_slopes, state->exp_psi, d) / state->area;
        for (size_t k = 0; k < n; k++) d[k] = d[k] / state->area - state->lambda[j] * state->d_area[k];
    }
}

double ff_curve_ln_d(const ff_curve *curve, const ff_curve_state *state, double q)
{
    const ff_stencil s = ff_curve_stencil(curve, q);
    return ff_stencil_apply(&s, state->c) - log(state->area);
}
