/* Masking, Fresnel and diffuse terms by themselves: values against formulas written down a second time with angles and in long
 * double, derivatives against differences of the values, energy by quadrature, and what happens where a lobe leaves nothing over.
 */
#include "model_samples.h"
#include "models/internal_model.h"

#define PI 3.14159265358979323846L

/* Pairs of directions with the planes that the terms read. */
typedef struct pairs {
    size_t n;
    double dir[6][FF_BLOCK], plane[FF_G_COUNT][FF_BLOCK];
    ff_geometry g;
} pairs;

static const ff_kernels *kernels(void)
{
    return ff_kernels_get(FF_ISA_BEST);
}

static void pair_add(pairs *p, double iz, double oz, double phi)
{
    const double si = sqrt((1 - iz) * (1 + iz)), so = sqrt((1 - oz) * (1 + oz));
    const double d[6] = {si, 0, iz, so * cos(phi), so * sin(phi), oz};
    for (int k = 0; k < 6; k++) p->dir[k][p->n] = d[k];
    p->n++;
}

static void pairs_finish(pairs *p)
{
    const ff_dirs w = {p->dir[0], p->dir[1], p->dir[2], p->dir[3], p->dir[4], p->dir[5]};
    for (int k = 0; k < FF_G_COUNT; k++) p->g.plane[k] = p->plane[k];
    kernels()->geometry(&w, p->n, &p->g);
}

/* From the stream of a case. */
static void pairs_random(pairs *p, uint64_t *state)
{
    static const double few[] = {0.05, 0.4, 0.95};
    p->n = 0;
    for (int i = 0; i < 90; i++) {
        const double iz = 0.02 + 0.98 * fit_uniform(state), oz = 0.02 + 0.98 * fit_uniform(state);
        pair_add(p, iz, oz, 3.14159 * fit_uniform(state));
    }
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) pair_add(p, few[i], few[j], i > j ? 0.3 : 2.9);
    pair_add(p, 1, 0.3, 0);
    pair_add(p, 1, 1, 0);
    pairs_finish(p);
}

static const ff_fresnel *fresnel(const char *name)
{
    return kernels()->fresnel[ff_term_find(FF_FRESNEL, name)];
}

static const ff_diffuse *diffuse(const char *name)
{
    return kernels()->diffuse[ff_term_find(FF_DIFFUSE, name)];
}

static const ff_masking *masking(const char *name)
{
    return kernels()->masking[ff_term_find(FF_MASKING, name)];
}

/* ---- Fresnel --------------------------------------------------------------------------------- */

/* F of one cosine with its derivatives. */
static double fresnel_at(const ff_fresnel *f, const double *params, double c, double *d)
{
    double value, *planes[4] = {d, d + 1, d + 2, d + 3};
    ff_geometry g = {{NULL}};
    g.plane[FF_G_C] = &c;
    f->eval(params, &g, 1, &value, d ? planes : NULL);
    return value;
}

/* By the angle of refraction. */
static long double dielectric(long double c, long double eta)
{
    const long double t = sqrtl(1 - (1 - c * c) / (eta * eta)); /* its cosine */
    const long double rs = (c - eta * t) / (c + eta * t), rp = (eta * c - t) / (eta * c + t);
    return (rs * rs + rp * rp) / 2;
}

/* In real numbers. */
static long double conductor(long double c, long double eta, long double k)
{
    const long double s2 = 1 - c * c, t0 = eta * eta - k * k - s2, ab = sqrtl(t0 * t0 + 4 * eta * eta * k * k),
                      a = sqrtl((ab + t0) / 2);
    const long double Rs = (ab + c * c - 2 * a * c) / (ab + c * c + 2 * a * c);
    return Rs * (1 + (c * c * ab + s2 * s2 - 2 * a * c * s2) / (c * c * ab + s2 * s2 + 2 * a * c * s2)) / 2;
}

static void fresnel_values(void)
{
    static const double etas[] = {1, 1.001, 1.329, 1.5, 2.4, 10, 100}, ks[] = {0, 0.1, 1, 6.08, 50};
    for (double c = 1; c > 1e-6; c *= 0.7) {
        for (size_t i = 0; i < sizeof etas / sizeof etas[0]; i++) {
            const double f = fresnel_at(fresnel("dielectric"), &etas[i], c, NULL);
            FF_CHECK_CLOSE(f, (double)dielectric(c, etas[i]), 1e-12, 1e-15);
            for (size_t j = 0; j < sizeof ks / sizeof ks[0]; j++) {
                const double index[2] = {etas[i] - 0.5, ks[j]};
                if (ks[j] > 0)
                    FF_CHECK_CLOSE(fresnel_at(fresnel("conductor"), index, c, NULL), (double)conductor(c, index[0], ks[j]), 1e-12,
                                   1e-14);
            }
            const double clear[2] = {etas[i], 0};
            FF_CHECK_CLOSE(fresnel_at(fresnel("conductor"), clear, c, NULL), f, 1e-13, 1e-15);
        }
        const double total[2] = {0.5, 0}; /* total reflection below cos = sqrt(3)/2 */
        if (c < 0.86) FF_CHECK_CLOSE(fresnel_at(fresnel("conductor"), total, c, NULL), 1, 1e-15, 0);
    }
    const double aluminium[2] = {0.769, 6.08}; /* at 500 nm, in Mikkelsen 2009 */
    FF_CHECK_CLOSE(fresnel_at(fresnel("conductor"), aluminium, 1, NULL), 0.923283661, 0, 5e-10);
    const double tinted[2] = {0.6, 0.35};
    FF_CHECK_CLOSE(fresnel_at(fresnel("schlick-f82"), tinted, 1.0 / 7, NULL), 0.35, 1e-15, 0);
    FF_CHECK_CLOSE(fresnel_at(fresnel("schlick-f82"), tinted, 1, NULL), 0.6, 1e-15, 0);
    FF_CHECK_CLOSE(fresnel_at(fresnel("schlick-f82"), tinted, 0, NULL), 1, 1e-15, 0);
    const double published[2] = {6, 5};
    FF_CHECK_CLOSE(fresnel_at(fresnel("sgd"), published, 0.25, NULL), 6 - 1.25 - 5 * 243.0 / 1024, 1e-15, 0);
}

/* Between F0 and 1 along the curve of the dielectric; with its own F0 the dielectric itself. */
static void cycles_draws_the_dielectric(void)
{
    static const double etas[] = {1.05, 1.5, 1.8, 2};
    for (double c = 1; c > 1e-3; c *= 0.8)
        for (size_t i = 0; i < sizeof etas / sizeof etas[0]; i++) {
            const double eta = etas[i], R = (eta - 1) * (eta - 1) / ((eta + 1) * (eta + 1));
            const double exact = (double)dielectric(c, eta), H = (exact - R) / (1 - R);
            FF_CHECK_CLOSE(fresnel_at(fresnel("cycles"), (double[2]){R, eta}, c, NULL), exact, 1e-12, 1e-15);
            FF_CHECK_CLOSE(fresnel_at(fresnel("cycles"), (double[2]){0.7, eta}, c, NULL), 0.7 * (1 - H) + H, 1e-12, 1e-15);
        }
}

/* The distance of schlick-karis from schlick, as its note says. */
static void karis_beside_schlick(void)
{
    const double f0 = 0.2;
    double above = 0, below = 0;
    for (int i = 0; i <= 4000; i++) {
        const double c = i / 4000.0, karis = fresnel_at(fresnel("schlick-karis"), &f0, c, NULL);
        FF_CHECK_CLOSE(karis, f0 + (1 - f0) * pow(2, (-5.55473 * c - 6.98316) * c), 1e-13, 0);
        const double miss = (karis - fresnel_at(fresnel("schlick"), &f0, c, NULL)) / (1 - f0);
        above = fmax(above, miss);
        below = fmin(below, miss);
    }
    FF_CHECK_CLOSE(above, 0.0038, 0, 5e-5);
    FF_CHECK_CLOSE(below, -0.0029, 0, 5e-5);
    FF_CHECK_CLOSE(fresnel_at(fresnel("schlick-karis"), &f0, 1, NULL) - f0, 0.00017 * (1 - f0), 0, 2e-6);
}

/* The largest and the smallest F of schlick-f82 over its box, as its note says. */
static void range_of_f82(void)
{
    const double brightest[2] = {0, 1}, darkest[2] = {0, 0};
    double hi = 0, lo = 1;
    for (int i = 0; i <= 4000; i++) {
        hi = fmax(hi, fresnel_at(fresnel("schlick-f82"), brightest, i / 4000.0, NULL));
        lo = fmin(lo, fresnel_at(fresnel("schlick-f82"), darkest, i / 4000.0, NULL));
    }
    FF_CHECK_CLOSE(hi, 1.127, 0, 5e-4);
    FF_CHECK_CLOSE(lo, -0.127, 0, 5e-4);
}

/* How many derivatives of the case were of each verdict. */
static long judged[3];

static void judge_anew(void)
{
    memset(judged, 0, sizeof judged);
}

/* Most must have been resolved. */
static void check_judged(const char *what)
{
    FF_CHECK(judged[MODEL_RIGHT] > 0 && judged[MODEL_UNRESOLVED] <= judged[MODEL_RIGHT] / 50, "%s: %ld resolved, %ld not", what,
             judged[MODEL_RIGHT], judged[MODEL_UNRESOLVED]);
}

/* A function of one number, and where it may be asked. */
typedef struct slice {
    double (*f)(void *, double);
    void *context;
    double lo, hi;
} slice;

static void judge(const char *what, const model_ridders *r, double x, double analytic, double scale)
{
    const model_verdict v = model_judge(r, analytic, scale);
    judged[v]++;
    FF_CHECK(v != MODEL_WRONG, "%s at %g: %.15g, by differences %.15g +- %.1g", what, x, analytic, r->value, r->error);
}

/* The derivative at x by the referee of gradient_test; size: what x is measured in. */
static void check_derivative(const char *what, slice s, double x, double analytic, double size)
{
    const double at = s.f(s.context, x);
    double step = fmin(0.1 * size, 0.99 * fmin(s.hi - x, x - s.lo));
    model_ridders r;
    model_ridders_start(&r);
    for (int level = 0; level < MODEL_LEVELS && step > 0; level++, step /= MODEL_RATIO) {
        const double low = s.f(s.context, x - step), high = s.f(s.context, x + step);
        model_ridders_add(&r, (high - low) / (2 * step), 1e-15 * (fabs(at) + fabs(high - low)) / step);
    }
    judge(what, &r, x, analytic, fabs(at) / size + fabs(r.value));
}

typedef struct fresnel_probe {
    const ff_fresnel *f;
    double params[4], c;
    uint32_t k;
} fresnel_probe;

static double probe_fresnel(void *context, double x)
{
    fresnel_probe p = *(const fresnel_probe *)context;
    p.params[p.k] = x;
    return fresnel_at(p.f, p.params, p.c, NULL);
}

static void fresnel_derivatives(void)
{
    for (size_t t = 0; t < ff_term_count(FF_FRESNEL); t++) {
        fresnel_probe p = {.f = kernels()->fresnel[t]};
        const ff_term *term = &p.f->term;
        judge_anew();
        uint64_t seed = ff_test_stream("fresnel %s", term->name);
        for (int i = 0; i < 300; i++) {
            double d[4];
            for (uint32_t k = 0; k < term->n_params; k++) {
                const ff_param *info = &term->params[k];
                const double lo = fmax(info->lo, info->init - 2), hi = fmin(info->hi, info->init + 2);
                p.params[k] = lo + (hi - lo) * (0.02 + 0.96 * fit_uniform(&seed));
            }
            p.c = i < 5 ? 1 : 0.02 + 0.98 * fit_uniform(&seed);
            fresnel_at(p.f, p.params, p.c, d);
            for (p.k = 0; p.k < term->n_params; p.k++) {
                const ff_param *info = &term->params[p.k];
                check_derivative(term->name, (slice){probe_fresnel, &p, info->lo, info->hi}, p.params[p.k], d[p.k], 1);
            }
        }
        if (term->n_params > 0) check_judged(term->name);
    }
}

static void fresnel_starts(void)
{
    for (double f0 = 0.001; f0 < 0.999; f0 += 0.01)
        for (size_t t = 0; t < ff_term_count(FF_FRESNEL); t++) {
            const ff_fresnel *f = kernels()->fresnel[t];
            double params[4];
            if (!f->like_schlick) continue;
            for (uint32_t k = 0; k < f->term.n_params; k++) params[k] = f->term.params[k].init; /* what is held stays */
            f->like_schlick(f0, params);
            for (uint32_t k = 0; k < f->term.n_params; k++)
                FF_CHECK(params[k] >= f->term.params[k].lo && params[k] <= f->term.params[k].hi, "%s: %s = %g", f->term.name,
                         f->term.params[k].name, params[k]);
            if (f0 < 0.95) FF_CHECK_CLOSE(fresnel_at(f, params, 1, NULL), f0, 1e-12, 0);
        }
}

/* ---- masking --------------------------------------------------------------------------------- */

static void kelemen_below_v_cavity(void)
{
    pairs p;
    double G[FF_BLOCK], V[FF_BLOCK];
    uint64_t state = ff_test_stream("kelemen below V-cavity");
    for (int round = 1; round < 50; round++) {
        pairs_random(&p, &state);
        masking("kelemen")->eval(0, &p.g, p.n, NULL, NULL, G, NULL, NULL, NULL);
        masking("v-cavity")->eval(0, &p.g, p.n, NULL, NULL, V, NULL, NULL, NULL);
        for (size_t i = 0; i < p.n; i++) {
            const double iz = p.dir[2][i], oz = p.dir[5][i];
            const double io = p.dir[0][i] * p.dir[3][i] + p.dir[1][i] * p.dir[4][i] + iz * oz;
            FF_CHECK_CLOSE(G[i], 2 * iz * oz / (1 + io), 1e-11, 0);
            FF_CHECK(G[i] <= V[i] * (1 + 1e-14), "kelemen %.17g, V-cavity %.17g", G[i], V[i]);
        }
    }
}

/* ln G of all pairs as a function of the masking's parameter. */
typedef struct masking_probe {
    const ff_masking *m;
    const pairs *p;
    const double *li, *lo;
} masking_probe;

static void probe_masking(const masking_probe *k, double x, double *log_g)
{
    double gi[FF_BLOCK], go[FF_BLOCK];
    k->m->eval(x, &k->p->g, k->p->n, k->li, k->lo, log_g, k->li ? gi : NULL, k->li ? go : NULL, NULL);
    for (size_t i = 0; i < k->p->n; i++) log_g[i] = log(log_g[i]);
}

/* Its derivatives gx at x > 0, by differences of all pairs at once. */
static void check_masking(const masking_probe *k, double x, const double *gx)
{
    double at[FF_BLOCK], low[FF_BLOCK], high[FF_BLOCK], step = 0.1 * x;
    model_ridders r[FF_BLOCK];
    probe_masking(k, x, at);
    for (size_t i = 0; i < k->p->n; i++) model_ridders_start(&r[i]);
    for (int level = 0; level < MODEL_LEVELS; level++, step /= MODEL_RATIO) {
        probe_masking(k, x - step, low);
        probe_masking(k, x + step, high);
        for (size_t i = 0; i < k->p->n; i++) /* the 1: G rounds by parts of itself, its logarithm by as much */
            model_ridders_add(&r[i], (high[i] - low[i]) / (2 * step), 1e-15 * (1 + fabs(at[i])) / step);
    }
    for (size_t i = 0; i < k->p->n; i++) judge(k->m->term.name, &r[i], x, gx[i], (1 + fabs(at[i])) / x + fabs(r[i].value));
}

static double ggx_lambda(double cosine, double alpha)
{
    return 0.5 * (sqrt(1 + alpha * alpha * (1 / (cosine * cosine) - 1)) - 1);
}

/* The distance from the exact forms, as the notes say, and the derivative by alpha. */
static void approximations_of_ggx(void)
{
    double worst[2] = {0, 0};
    judge_anew();
    for (double alpha = 0.1; alpha <= 1.0001; alpha += 0.05)
        for (double iz = 0.02; iz <= 1; iz += 0.02) {
            pairs p = {0};
            double G[2][FF_BLOCK], gx[2][FF_BLOCK];
            for (double oz = 0.02; oz <= 1; oz += 0.02) pair_add(&p, iz, oz, 1);
            pairs_finish(&p);
            for (int k = 0; k < 2; k++) {
                const ff_masking *m = masking(k ? "schlick-smith" : "hammon");
                m->eval(alpha, &p.g, p.n, NULL, NULL, G[k], NULL, NULL, gx[k]);
                check_masking(&(masking_probe){m, &p, NULL, NULL}, alpha, gx[k]);
            }
            for (size_t i = 0; i < p.n; i++) {
                const double li = ggx_lambda(iz, alpha), lo = ggx_lambda(p.dir[5][i], alpha);
                const double exact[2] = {1 / (1 + li + lo), 1 / ((1 + li) * (1 + lo))};
                for (int k = 0; k < 2; k++) {
                    worst[k] = fmax(worst[k], fabs(G[k][i] - exact[k]));
                    if (alpha > 0.99999) FF_CHECK_CLOSE(G[k][i], exact[k], 1e-12, 0);
                }
            }
        }
    check_judged("approximations of ggx");
    FF_CHECK_CLOSE(worst[0], 0.197, 0, 1e-3);
    FF_CHECK_CLOSE(worst[1], 0.223, 0, 1e-3);
}

/* Smith's G1 of ggx at alpha = 0.25 of both directions, whatever is asked for. */
static void clear_coat_masks_at_a_quarter(void)
{
    pairs p;
    double G[FF_BLOCK];
    uint64_t state = ff_test_stream("clear coat");
    pairs_random(&p, &state);
    masking("disney-clearcoat")->eval(0.9, &p.g, p.n, NULL, NULL, G, NULL, NULL, NULL);
    for (size_t i = 0; i < p.n; i++)
        FF_CHECK_CLOSE(G[i], 1 / ((1 + ggx_lambda(p.dir[2][i], 0.25)) * (1 + ggx_lambda(p.dir[5][i], 0.25))), 1e-13, 0);
}

/* phi is 0 where one direction is the normal. */
typedef struct angles {
    long double i, o, phi;
} angles;

static angles angles_of(const pairs *p, size_t i)
{
    const long double ox = p->dir[3][i], oy = p->dir[4][i];
    const long double flat = sqrtl(ox * ox + oy * oy) * fabsl((long double)p->dir[0][i]);
    return (angles){atan2l(fabsl((long double)p->dir[0][i]), p->dir[2][i]), atan2l(sqrtl(ox * ox + oy * oy), p->dir[5][i]),
                    flat > 0 ? atan2l(fabsl(oy), ox) : 0};
}

static void ginneken(void)
{
    const ff_masking *m = masking("smith-height-direction-correlated");
    pairs p;
    double li[FF_BLOCK], lo[FF_BLOCK], G[FF_BLOCK], gi[FF_BLOCK], go[FF_BLOCK], gx[FF_BLOCK];
    uint64_t seed = ff_test_stream("van Ginneken");
    pairs_random(&p, &seed);
    FF_CHECK(m->term.n_params == 1 && m->term.params[0].init == 4.41, "van Ginneken's constant");
    for (size_t i = 0; i < p.n; i++) li[i] = 3 * fit_uniform(&seed), lo[i] = 3 * fit_uniform(&seed);
    judge_anew();
    for (double w = 0.2; w < 90; w *= 2.1) {
        m->eval(w, &p.g, p.n, li, lo, G, gi, go, gx);
        check_masking(&(masking_probe){m, &p, li, lo}, w, gx);
        for (size_t i = 0; i < p.n; i++) {
            const double phi = (double)angles_of(&p, i).phi, k = w * phi / (w * phi + 1);
            FF_CHECK_CLOSE(G[i], 1 / (1 + fmax(li[i], lo[i]) + k * fmin(li[i], lo[i])), 1e-9, 0);
        }
    }
    /* Heitz 2014, eq. 22, with the constant of the paper: between the product and the lesser of the two */
    masking("smith-direction-correlated")->eval(0, &p.g, p.n, li, lo, G, gi, go, NULL);
    for (size_t i = 0; i < p.n; i++) {
        const double phi = (double)angles_of(&p, i).phi, k = 4.41 * phi / (4.41 * phi + 1), i1 = 1 / (1 + li[i]),
                     o1 = 1 / (1 + lo[i]);
        FF_CHECK_CLOSE(G[i], k * i1 * o1 + (1 - k) * fmin(i1, o1), 1e-9, 0);
    }
    check_judged(m->term.name);
}

/* ---- diffuse --------------------------------------------------------------------------------- */

static long double oren_nayar(angles w, const double *params)
{
    const long double rho = params[0], v = (long double)params[1] * params[1], al = fmaxl(w.i, w.o), be = fminl(w.i, w.o);
    const long double c = cosl(w.phi), b = 2 * be / PI;
    const long double C2 = 0.45L * v / (v + 0.09L) * (c >= 0 ? sinl(al) : sinl(al) - b * b * b);
    const long double C3 = 0.125L * v / (v + 0.09L) * powl(4 * al * be / (PI * PI), 2);
    const long double first = 1 - 0.5L * v / (v + 0.33L) + c * C2 * tanl(be) + (1 - fabsl(c)) * C3 * tanl((al + be) / 2);
    return fmaxl(0, rho / PI * first + rho * rho / PI * 0.17L * v / (v + 0.13L) * (1 - c * b * b));
}

static long double oren_nayar_qualitative(angles w, const double *params)
{
    const long double v = (long double)params[1] * params[1], al = fmaxl(w.i, w.o), be = fminl(w.i, w.o);
    return params[0] / PI * (1 - 0.5L * v / (v + 0.33L) + 0.45L * v / (v + 0.09L) * fmaxl(0, cosl(w.phi)) * sinl(al) * tanl(be));
}

static long double fujii_albedo(long double t, long double r)
{
    const long double s = sinl(t), G = s * (t - s * cosl(t)) + 2 * (tanl(t) * (1 - s * s * s) - s) / 3;
    return (1 + r * G / PI) / (1 + (0.5L - 2 / (3 * PI)) * r);
}

static long double eon(angles w, const double *params)
{
    const long double rho = params[0], r = params[1], A = 1 / (1 + (0.5L - 2 / (3 * PI)) * r);
    const long double s = cosl(w.phi) * sinl(w.i) * sinl(w.o), mean = A * (1 + (2 / 3.0L - 28 / (15 * PI)) * r);
    const long double single = rho / PI * A * (1 + r * (s > 0 ? s / cosl(fminl(w.i, w.o)) : s));
    if (r == 0) return single;
    return single +
           rho * rho * mean / (1 - rho * (1 - mean)) / PI * (1 - fujii_albedo(w.i, r)) * (1 - fujii_albedo(w.o, r)) / (1 - mean);
}

static long double between(angles w)
{
    return cosl(w.i) * cosl(w.o) + sinl(w.i) * sinl(w.o) * cosl(w.phi);
}

static long double disney(angles w, const double *params)
{
    const long double rise = params[1] * (1 + between(w)) - 0.5L;
    return params[0] / PI * (1 + rise * powl(1 - cosl(w.i), 5)) * (1 + rise * powl(1 - cosl(w.o), 5));
}

static long double smooth(angles w)
{
    return 1.05L * (1 - powl(1 - cosl(w.i), 5)) * (1 - powl(1 - cosl(w.o), 5));
}

static long double hammon(angles w, long double albedo, long double alpha)
{
    const long double facing = (1 + between(w)) / 2, hz = (cosl(w.i) + cosl(w.o)) / sqrtl(2 + 2 * between(w));
    const long double rough = facing * (0.9L - 0.4L * facing) * (0.5L + hz) / hz;
    return albedo * ((smooth(w) * (1 - alpha) + rough * alpha) / PI + albedo * 0.1159L * alpha);
}

/* By the vectors: the projection of wi + wo. */
static long double abg(angles w, const double *params)
{
    const long double x = sinl(w.i) + sinl(w.o) * cosl(w.phi), y = sinl(w.o) * sinl(w.phi);
    return params[0] / (params[1] + powl(hypotl(x, y), params[2]));
}

/* x, y as of abg. */
static long double harvey_shack(angles w, const double *params)
{
    const long double x = sinl(w.i) + sinl(w.o) * cosl(w.phi), y = sinl(w.o) * sinl(w.phi);
    return params[0] * powl(1 + (x * x + y * y) / ((long double)params[1] * params[1]), params[2] / 2.0L);
}

static long double k_correlation(angles w, const double *params)
{
    const double as_slope[3] = {params[0], params[1], -(params[2] + 1)};
    return cosl(w.i) * cosl(w.o) * harvey_shack(w, as_slope);
}

static void eval_diffuse(const ff_diffuse *t, const ff_diffuse_input *in, const pairs *p, double *f)
{
    t->eval(in, &p->g, p->n, f, NULL);
}

static void check_values(const char *name, const ff_diffuse_input *in, long double (*reference)(angles, const double *))
{
    pairs p;
    double f[FF_BLOCK];
    uint64_t state = ff_test_stream("values of %s %g %g", name, in->params[0], in->params[1]);
    pairs_random(&p, &state);
    eval_diffuse(diffuse(name), in, &p, f);
    for (size_t i = 0; i < p.n; i++) FF_CHECK_CLOSE(f[i], (double)reference(angles_of(&p, i), in->params), 1e-12, 1e-13);
}

static void diffuse_values(void)
{
    static const double shapes[] = {0, 0.1, 0.3, 0.5, 1};
    for (size_t i = 0; i < sizeof shapes / sizeof shapes[0]; i++)
        for (double kd = 0; kd <= 1; kd += 0.25) {
            const double s = shapes[i];
            check_values("oren-nayar", &(ff_diffuse_input){.params = {kd, 1.5 * s}}, oren_nayar);
            check_values("oren-nayar-qualitative", &(ff_diffuse_input){.params = {kd, 1.5 * s}}, oren_nayar_qualitative);
            check_values("eon", &(ff_diffuse_input){.params = {kd, s}}, eon);
            check_values("disney", &(ff_diffuse_input){.params = {kd, s}}, disney);
            check_values("abg", &(ff_diffuse_input){.params = {kd, 1e-6 + s, 1 + 3 * s}}, abg);
            check_values("harvey-shack", &(ff_diffuse_input){.params = {kd, 1e-3 + s, -0.1 - 3 * s}}, harvey_shack);
            check_values("k-correlation", &(ff_diffuse_input){.params = {kd, 1e-3 + s, 0.1 + 3 * s}}, k_correlation);

            pairs p;
            double f[FF_BLOCK], own[FF_BLOCK];
            uint64_t state = ff_test_stream("values of coupled terms %g %g", kd, s);
            pairs_random(&p, &state);
            eval_diffuse(diffuse("hammon"), &(ff_diffuse_input){.params = {kd}, .alpha = s}, &p, f);
            for (size_t j = 0; j < p.n; j++) FF_CHECK_CLOSE(f[j], (double)hammon(angles_of(&p, j), kd, s), 1e-12, 1e-14);
            eval_diffuse(diffuse("shirley-coupled"), &(ff_diffuse_input){.params = {kd}, .f0 = s}, &p, f);
            for (size_t j = 0; j < p.n; j++)
                FF_CHECK_CLOSE(f[j], (double)(kd * (1 - s) / PI * smooth(angles_of(&p, j))), 1e-12, 1e-14);
            eval_diffuse(diffuse("disney-coupled"), &(ff_diffuse_input){.params = {kd}, .alpha = s * s}, &p, f);
            eval_diffuse(diffuse("disney"), &(ff_diffuse_input){.params = {kd, s}}, &p, own);
            for (size_t j = 0; j < p.n; j++) FF_CHECK_CLOSE(f[j], own[j], 1e-14, 0);
        }
}

typedef struct diffuse_probe {
    const ff_diffuse *t;
    const pairs *p;
    ff_diffuse_input in;
    double *x; /* the input that moves, inside `in` or one of the planes */
    size_t at;
} diffuse_probe;

static double probe_diffuse(void *context, double x)
{
    diffuse_probe *p = context;
    const double kept = *p->x;
    double f[FF_BLOCK];
    *p->x = x;
    eval_diffuse(p->t, &p->in, p->p, f);
    *p->x = kept;
    return f[p->at];
}

static void check_derivatives(const ff_diffuse *t, uint64_t *seed)
{
    pairs p;
    static double planes[FF_DD_COUNT][FF_BLOCK];
    double f[FF_BLOCK], plain[FF_BLOCK], ai[FF_BLOCK], ao[FF_BLOCK], F[FF_BLOCK], lobe[FF_BLOCK], *d[FF_DD_COUNT] = {NULL};
    pairs_random(&p, seed);
    for (size_t i = 0; i < p.n; i++) ai[i] = 0.9 * fit_uniform(seed), ao[i] = 0.1 + 0.8 * fit_uniform(seed);
    for (size_t i = 0; i < p.n; i++) F[i] = 0.9 * fit_uniform(seed), lobe[i] = 3 * fit_uniform(seed);
    diffuse_probe probe = {.t = t,
                           .p = &p,
                           .in = {.alpha = 0.05 + 0.9 * fit_uniform(seed),
                                  .f0 = 0.9 * fit_uniform(seed),
                                  .ai = ai,
                                  .ao = ao,
                                  .fresnel = F,
                                  .lobe = lobe}};
    probe.in.mean = 0.1 + 0.8 * fit_uniform(seed);
    probe.in.f_average = 0.1 + 0.8 * fit_uniform(seed);
    for (uint32_t k = 0; k < t->term.n_params; k++) {
        const ff_param *info = &t->term.params[k];
        probe.in.params[k] = info->lo + (info->hi - info->lo) * (0.02 + (k ? 0.38 : 0.9) * fit_uniform(seed));
    }
    const int albedo = (t->couples & (FF_COUPLE_ALBEDO | FF_COUPLE_LOSS)) != 0;
    const ff_param *own = t->term.params;
    struct {
        int k, wanted;
        double *x, lo, hi;
    } input[] = {
        {0, t->term.n_params > 0, &probe.in.params[0], t->term.n_params > 0 ? own[0].lo : 0, t->term.n_params > 0 ? own[0].hi : 0},
        {1, t->term.n_params > 1, &probe.in.params[1], t->term.n_params > 1 ? own[1].lo : 0, t->term.n_params > 1 ? own[1].hi : 0},
        {FF_DD_ALPHA, (t->couples & FF_COUPLE_ALPHA) != 0, &probe.in.alpha, 0, 1},
        {FF_DD_F0, (t->couples & FF_COUPLE_F0) != 0, &probe.in.f0, 0, 1},
        {FF_DD_AI, albedo, ai, 0, 1},
        {FF_DD_AO, albedo, ao, 0.01, 1},
        {FF_DD_MEAN,
         strcmp(t->term.name, "kelemen-matte") == 0 || strcmp(t->term.name, "kulla-conty") == 0 ||
             strcmp(t->term.name, "multiple-scattering") == 0,
         &probe.in.mean, 0, 1},
        {FF_DD_F_AVERAGE, (t->couples & FF_COUPLE_LOSS) != 0, &probe.in.f_average, 0, 1},
        {FF_DD_FRESNEL, (t->couples & FF_COUPLE_FRESNEL) != 0, F, 0, 1},
        {FF_DD_LOBE, (t->couples & FF_COUPLE_LOBE) != 0, lobe, 0, 10}};
    for (size_t j = 0; j < sizeof input / sizeof input[0]; j++)
        if (input[j].wanted) d[input[j].k] = planes[input[j].k];
    eval_diffuse(t, &probe.in, &p, plain);
    t->eval(&probe.in, &p.g, p.n, f, d);
    for (probe.at = 0; probe.at < p.n; probe.at++) {
        FF_CHECK(f[probe.at] == plain[probe.at], "%s: the value depends on the derivatives", t->term.name);
        for (size_t j = 0; j < sizeof input / sizeof input[0]; j++) {
            const int k = input[j].k;
            if (!input[j].wanted) continue;
            probe.x = k == FF_DD_AI || k == FF_DD_AO || k == FF_DD_FRESNEL || k == FF_DD_LOBE ? input[j].x + probe.at : input[j].x;
            check_derivative(t->term.name, (slice){probe_diffuse, &probe, input[j].lo, input[j].hi}, *probe.x, planes[k][probe.at],
                             1);
        }
    }
}

static void diffuse_derivatives(void)
{
    for (size_t t = 0; t < ff_term_count(FF_DIFFUSE); t++) {
        const char *name = ff_term_at(FF_DIFFUSE, t)->name;
        uint64_t seed = ff_test_stream("diffuse %s", name);
        judge_anew();
        for (int i = 0; i < 20; i++) check_derivatives(kernels()->diffuse[t], &seed);
        check_judged(name);
    }
}

/* ---- energy ---------------------------------------------------------------------------------- */

enum { NODES = 64 };

/* Gauss-Legendre on [a, b] by Newton. */
static void gauss(double a, double b, double *x, double *w)
{
    for (int i = 0; i < NODES; i++) {
        double z = cos(3.14159265358979 * (i + 0.75) / (NODES + 0.5)), slope = 1;
        for (int step = 0; step < 50; step++) {
            double p = 1, before = 0;
            for (int k = 0; k < NODES; k++) {
                const double next = ((2 * k + 1) * z * p - k * before) / (k + 1);
                before = p;
                p = next;
            }
            slope = NODES * (z * p - before) / (z * z - 1);
            z -= p / slope;
        }
        x[i] = (a + b) / 2 + (b - a) / 2 * z;
        w[i] = (b - a) / ((1 - z * z) * slope * slope);
    }
}

/* Directional albedo; kinks at mu = oz and phi = pi/2 are ends of intervals. a: albedo of the lobes above, NULL where none. */
static double albedo_of(const ff_diffuse *t, ff_diffuse_input in, double oz, double (*a)(double))
{
    double sum = 0, mu[NODES], w_mu[NODES], phi[NODES], w_phi[NODES], ai[FF_BLOCK], ao[FF_BLOCK], f[FF_BLOCK];
    const double cut[] = {0, oz / 2, oz, (1 + oz) / 2, 1}, half[] = {0, 3.14159265358979 / 2, 3.14159265358979};
    in.ai = ai;
    in.ao = ao;
    for (int c = 0; c < 4; c++)
        for (int h = 0; h < 2; h++) {
            gauss(cut[c], cut[c + 1], mu, w_mu);
            gauss(half[h], half[h + 1], phi, w_phi);
            for (int i = 0; i < NODES; i++) {
                pairs p = {0};
                for (int j = 0; j < NODES; j++) pair_add(&p, mu[i], oz, phi[j]);
                pairs_finish(&p);
                for (int j = 0; j < NODES; j++) ai[j] = a ? a(mu[i]) : 0, ao[j] = a ? a(oz) : 0;
                eval_diffuse(t, &in, &p, f);
                for (int j = 0; j < NODES; j++) sum += 2 * mu[i] * w_mu[i] * w_phi[j] * f[j];
            }
        }
    return sum;
}

static double some_albedo(double mu)
{
    return 0.9 - 0.5 * mu; /* mean 0.9 - 1/3 */
}

static void energy(void)
{
    const double mean = 0.9 - 1 / 3.0;
    for (double oz = 1; oz > 1e-2; oz *= 0.6) {
        for (double r = 0; r <= 1; r += 0.25)
            FF_CHECK_CLOSE(albedo_of(diffuse("eon"), (ff_diffuse_input){.params = {1, r}}, oz, NULL), 1, 1e-9, 0);
        const double enters = albedo_of(diffuse("shirley-coupled"), (ff_diffuse_input){.params = {1}, .f0 = 0.04}, oz, NULL);
        FF_CHECK_CLOSE(enters, 0.96 * (1 - pow(1 - oz, 5)), 1e-9, 0);
        const ff_diffuse_input lossless = {.params = {1}, .mean = mean, .f_average = 1};
        const double left = 1 - some_albedo(oz);
        FF_CHECK_CLOSE(albedo_of(diffuse("kelemen-matte"), lossless, oz, some_albedo), left, 1e-9, 0);
        FF_CHECK_CLOSE(albedo_of(diffuse("kulla-conty"), lossless, oz, some_albedo), left, 1e-9, 0);
        FF_CHECK_CLOSE(albedo_of(diffuse("mikkelsen-coupled"), lossless, oz, some_albedo), left * (1 - mean), 1e-9, 0);
        FF_CHECK_CLOSE(albedo_of(diffuse("albedo-scaled"), lossless, oz, some_albedo), left, 1e-9, 0);
    }
    /* a lobe that reflects F each time: what it does not let out at once comes back later */
    double total = 0, inside = 1;
    const double F = 0.6;
    for (int bounce = 0; bounce < 200; bounce++) {
        inside *= F;
        if (bounce > 0) total += inside * mean;
        inside *= 1 - mean;
    }
    const double later = albedo_of(diffuse("kulla-conty"), (ff_diffuse_input){.mean = mean, .f_average = F}, 0.5, some_albedo);
    FF_CHECK_CLOSE(later, total * (1 - some_albedo(0.5)) / (1 - mean), 1e-9, 0);
}

/* A perfect mirror, a lobe that gives more than it gets, one that gives nothing: finite and not negative. */
static void nothing_left_over(void)
{
    static const double edges[] = {-1, 0, 1e-9, 0.5, 1 - 1e-9, 1, 1.2};
    static double planes[FF_DD_COUNT][FF_BLOCK];
    double f[FF_BLOCK], *d[FF_DD_COUNT];
    pairs p = {0};
    pair_add(&p, 0.5, 0.5, 1);
    pairs_finish(&p);
    for (size_t t = 0; t < ff_term_count(FF_DIFFUSE); t++)
        for (size_t i = 0; i < 7 * 7 * 7 * 7; i++) {
            const double a = edges[i % 7], b = edges[i / 7 % 7], lobe = (double)(i % 3);
            const ff_diffuse_input in = {.params = {1},
                                         .alpha = 1,
                                         .f0 = a,
                                         .ai = &a,
                                         .ao = &b,
                                         .mean = edges[i / 49 % 7],
                                         .f_average = edges[i / 343],
                                         .fresnel = &a,
                                         .lobe = &lobe};
            for (int k = 0; k < FF_DD_COUNT; k++) d[k] = planes[k], planes[k][0] = 0;
            kernels()->diffuse[t]->eval(&in, &p.g, 1, f, d);
            FF_CHECK(isfinite(f[0]) && f[0] >= 0, "%s: %g", ff_term_at(FF_DIFFUSE, t)->name, f[0]);
            for (int k = 0; k < FF_DD_COUNT; k++)
                FF_CHECK(isfinite(planes[k][0]), "%s: derivative %d", ff_term_at(FF_DIFFUSE, t)->name, k);
        }
    const double mirror[FF_BLOCK] = {1};
    const ff_diffuse_input all = {.params = {1}, .ai = mirror, .ao = mirror, .mean = 1, .f_average = 1};
    kernels()->diffuse[ff_term_find(FF_DIFFUSE, "kelemen-matte")]->eval(&all, &p.g, 1, f, NULL);
    FF_CHECK(f[0] == 0, "a mirror leaves %g", f[0]);
}

FF_TEST_MAIN(FF_TEST(fresnel_values), FF_TEST(cycles_draws_the_dielectric), FF_TEST(karis_beside_schlick),
             FF_TEST(clear_coat_masks_at_a_quarter), FF_TEST(range_of_f82), FF_TEST(fresnel_derivatives), FF_TEST(fresnel_starts),
             FF_TEST(kelemen_below_v_cavity), FF_TEST(approximations_of_ggx), FF_TEST(ginneken), FF_TEST(diffuse_values),
             FF_TEST(diffuse_derivatives), FF_TEST(energy), FF_TEST(nothing_left_over))
