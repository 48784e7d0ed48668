/* The order of lobes of one kind: the sum reflects as before, the narrower ones come first, and what is held stays where it is. */
#include "model_samples.h"

static double width(const fit_surface *s, uint32_t l)
{
    ff_lobe_pass pass;
    ff_model_lobe(&s->model, l, s->shape, &pass, NULL);
    return pass.s.ax * pass.s.ay * sqrt(1 - pass.s.r * pass.s.r);
}

/* The largest deviation of two surfaces over random pairs. */
static double deviation(const fit_surface *a, const fit_surface *b)
{
    static model_pairs w;
    static double f[2][FIT_CHANNELS * MODEL_PAIRS];
    uint64_t state = ff_test_stream("pairs of the order");
    double worst = 0;
    w.n = 0;
    model_pairs_random(&a->model, a->shape, &state, 300, &w);
    const ff_dirs d = model_dirs(&w);
    for (int i = 0; i < 2; i++) {
        const fit_surface *s = i ? b : a;
        FF_CHECK(ff_model_eval(&s->model, FF_ISA_BEST, s->n_channels, s->shape, s->channel, &d, w.n, f[i], NULL, w.n) == FF_OK,
                 "eval");
    }
    for (size_t i = 0; i < a->n_channels * w.n; i++) worst = fmax(worst, fabs(f[1][i] - f[0][i]) / f[0][i]);
    return worst;
}

static void sums_do_not_change(void)
{
    static const char *const models[] = {
        "ggx+ggx",
        "ggx+ggx+ggx",
        "ggx/v-cavity+beckmann/v-cavity+ggx/v-cavity",
        "student-t+student-t/smith-height-correlated/shared",
        "ggx+ggx/smith-height-correlated/shared+ggx/smith-height-correlated/shared",
        "ggx+beckmann/v-cavity/shared+ggx/smith-height-correlated/shared",
        "ggx/smith-separable/dielectric+ggx/smith-separable/dielectric+lambert",
        "phong+phong+oren-nayar",
    };
    for (size_t k = 0; k < sizeof models / sizeof *models; k++) {
        int moved = 0;
        for (int trial = 0; trial < 30; trial++) {
            uint64_t state = ff_test_stream("order %s %d", models[k], trial);
            fit_surface s = fit_surface_make(models[k], 2, "");
            model_random_parameters(&s.model, 2, (model_freedom)(trial % 2), 0.4, &state, s.shape, s.channel);
            fit_surface sorted = s;
            moved += ff_lobes_order(&s.model, 2, sorted.shape, sorted.channel);
            const double worst = deviation(&s, &sorted);
            FF_CHECK(worst <= 1e-11, "%s: another surface after sorting, by %.3g", models[k], worst);
            FF_CHECK(!ff_lobes_order(&s.model, 2, sorted.shape, sorted.channel), "%s: sorted, and yet not", models[k]);
            for (uint32_t a = 0; a < s.model.n_lobes; a++)
                for (uint32_t b = a + 1; b < s.model.n_lobes; b++) {
                    const ff_lobe *x = &s.model.lobe[a], *y = &s.model.lobe[b];
                    if (x->ndf != y->ndf || x->masking != y->masking || x->isotropic) continue;
                    FF_CHECK(width(&sorted, a) <= width(&sorted, b), "%s: lobe %u is wider than lobe %u", models[k], a + 1, b + 1);
                }
        }
        FF_CHECK(moved > 3, "%s: only %d of 30 trials had something to sort", models[k], moved);
    }
}

static void what_is_held_stays(void)
{
    fit_surface s = fit_surface_make("ggx+ggx", 1, "alpha=0.5 lobe2.alpha=0.1");
    FF_CHECK(ff_model_hold(&s.model, "lobe2.alpha", 0.1, NULL) == FF_OK, "hold");
    FF_CHECK(!ff_lobes_order(&s.model, 1, s.shape, s.channel) && s.shape[0] == 0.5, "a held roughness has moved");
    fit_surface other = fit_surface_make("ggx+ggx/v-cavity+beckmann", 1, "alpha=0.9 lobe2.alpha=0.5 lobe3.alpha=0.1");
    FF_CHECK(!ff_lobes_order(&other.model, 1, other.shape, other.channel), "lobes of different kinds were exchanged");
}

/* Weights of three lobes: positive, 1 in all, and derivatives by differences. */
static void weights(void)
{
    const fit_surface s =
        fit_surface_make("ggx+beckmann/v-cavity/shared+phong/v-cavity/shared", 1, "lobe2.weight=0.3 lobe3.weight=0.2");
    double w[FF_MAX_LOBES], dw[FF_MAX_LOBES][FF_MAX_LOBES];
    ff_model_weights(&s.model, s.shape, w, dw);
    FF_CHECK_CLOSE(w[0], 0.7 * 0.8, 1e-15, 0);
    FF_CHECK_CLOSE(w[1], 0.3 * 0.8, 1e-15, 0);
    FF_CHECK_CLOSE(w[2], 0.2, 1e-15, 0);
    for (uint32_t k = 1; k < 3; k++) {
        double high[FF_MAX_LOBES], low[FF_MAX_LOBES];
        fit_surface moved = s;
        const uint32_t at = s.model.lobe[k].shape0 + s.model.lobe[k].n_shape - 1;
        moved.shape[at] = s.shape[at] + 1e-3;
        ff_model_weights(&moved.model, moved.shape, high, NULL);
        moved.shape[at] = s.shape[at] - 1e-3;
        ff_model_weights(&moved.model, moved.shape, low, NULL);
        for (uint32_t l = 0; l < 3; l++) FF_CHECK_CLOSE(dw[k][l], (high[l] - low[l]) / 2e-3, 1e-9, 1e-12);
    }
}

/* ---- bounded least squares ------------------------------------------------------------------- */

/* By trying each parameter at either bound and free: exact, and exponential. */
static double by_all_states(const double *gram, size_t n, const double *lo, const double *hi)
{
    double best = HUGE_VAL;
    int count = 1;
    for (size_t i = 0; i < n; i++) count *= 3;
    for (int code = 0; code < count; code++) {
        double q[4], A[4][5];
        int state[4], inside = 1;
        for (size_t i = 0, rest = (size_t)code; i < n; i++, rest /= 3) state[i] = (int)(rest % 3);
        for (size_t r = 0; r < n; r++) { /* a fixed parameter has the equation q = bound */
            for (size_t c = 0; c < n; c++) A[r][c] = state[r] == 2 ? gram[ff_tri(r, c)] : r == c;
            A[r][n] = state[r] == 2 ? -gram[ff_tri(n, r)] : state[r] ? hi[r] : lo[r];
        }
        for (size_t i = 0; i < n; i++) { /* Gauss and Jordan, with pivots */
            size_t pivot = i;
            for (size_t r = i; r < n; r++)
                if (fabs(A[r][i]) > fabs(A[pivot][i])) pivot = r;
            for (size_t c = 0; c <= n; c++) {
                const double t = A[i][c];
                A[i][c] = A[pivot][c];
                A[pivot][c] = t;
            }
            for (size_t r = 0; r < n; r++) {
                const double factor = r == i ? 0 : A[r][i] / A[i][i];
                for (size_t c = i; c <= n; c++) A[r][c] -= factor * A[i][c];
            }
        }
        double value = gram[ff_tri(n, n)];
        for (size_t i = 0; i < n; i++) {
            q[i] = A[i][n] / A[i][i];
            inside &= q[i] >= lo[i] - 1e-12 && q[i] <= hi[i] + 1e-12;
        }
        for (size_t a = 0; a < n; a++) {
            value += 2 * q[a] * gram[ff_tri(n, a)];
            for (size_t b = 0; b < n; b++) value += q[a] * q[b] * gram[ff_tri(a, b)];
        }
        if (inside && value < best) best = value;
    }
    return best;
}

static void active_sets(void)
{
    int on_bound = 0;
    for (int trial = 0; trial < 2000; trial++) {
        uint64_t state = ff_test_stream("active sets %d", trial);
        enum { ROWS = 7 };
        const size_t n = 1 + (size_t)trial % 4;
        double L[ROWS][5], gram[15], lo[4], hi[4], q[4];
        for (size_t r = 0; r < ROWS; r++)
            for (size_t c = 0; c <= n; c++) L[r][c] = fit_normal(&state) + (c < n && trial % 3 == 0 ? 5 * (double)(r + 1) : 0);
        for (size_t a = 0; a <= n; a++)
            for (size_t b = 0; b <= a; b++) {
                double sum = 0;
                for (size_t r = 0; r < ROWS; r++) sum += L[r][a] * L[r][b];
                gram[ff_tri(a, b)] = sum;
            }
        for (size_t i = 0; i < n; i++) {
            lo[i] = -fit_uniform(&state) + 0.3;
            hi[i] = lo[i] + fit_uniform(&state);
        }
        const double found = ff_bounded_least_squares(gram, n, lo, hi, q), exact = by_all_states(gram, n, lo, hi);
        FF_CHECK(fabs(found - exact) <= 1e-9 * gram[ff_tri(n, n)], "trial %d: %.12g, the least is %.12g", trial, found, exact);
        for (size_t i = 0; i < n; i++) {
            FF_CHECK(q[i] >= lo[i] && q[i] <= hi[i], "trial %d: %g outside [%g, %g]", trial, q[i], lo[i], hi[i]);
            on_bound += q[i] == lo[i] || q[i] == hi[i];
        }
    }
    FF_CHECK(on_bound > 1000, "only %d parameters ended on a bound", on_bound);
}

FF_TEST_MAIN(FF_TEST(sums_do_not_change), FF_TEST(what_is_held_stays), FF_TEST(weights), FF_TEST(active_sets))
