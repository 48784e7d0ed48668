/* multiple-scattering: what a surface of Smith's facets reflects after two of them and more, from random walks on it (Heitz,
 * Hanika, d'Eon and Dachsbacher 2016). With a the directional albedo of the lobe at F = 1, E its mean, and w(mu) = 2 mu (1 - a) /
 * (1 - E),
 *
 *   f = (1 - a_i)(1 - a_o) / (pi (1 - E)) A(phi) sum over orders k >= 2 of F^k P_k(mu_i, mu_o),  P_k symmetric polynomials
 *   A(phi) = (1 - rho^2) / (1 - 2 rho cos(phi) + rho^2),  rho = sin theta_i sin theta_o R(mu_i, mu_o) the mean of cos(phi)
 *
 * Kulla and Conty 2017 have T = 1 for the sum of all T_k, which is made here so that its mean over mu_o with weight w is 1 for
 * every mu_i: at F = 1 lobe and term reflect all light. What orders share is not the same in all directions; 2 and 3 have
 * polynomials of their own, those from 4 on are alike, each the q-th part of the one before. F is the average of the lobe's Fresnel
 * term.
 *
 * The coefficients are functions of alpha: cubic between the nodes of a table, constant below and above. Made by
 * bench/multiple_scattering; docs/masking.md has how far they are from the walks. */
#include "internal_terms.h"
#include "internal_optics.h"
#include <string.h>

/* Of P_k: mu_i^a mu_o^b, b <= a <= 3; of R: up to 2. Of a node: q, the P of all orders, of 2, of 3, then R. */
enum { FF_SCATTERING_LIST = 10, FF_SCATTERING_TURN = 6, FF_SCATTERING_TERMS = 1 + 3 * FF_SCATTERING_LIST + FF_SCATTERING_TURN };
#include "multiple_scattering_table.h"

/* Coefficients of one alpha, or their derivatives by it. */
typedef struct coefficients {
    double q, all[FF_SCATTERING_LIST], two[FF_SCATTERING_LIST], three[FF_SCATTERING_LIST], turn[FF_SCATTERING_TURN];
} coefficients;

/* The slope at a node: of the parabola through it and its neighbours. */
static double slope_at(const double (*table)[FF_SCATTERING_TERMS], int k, int term)
{
    if (k == 0 || k == FF_SCATTERING_NODES - 1) return 0;
    const double left = node[k] - node[k - 1], right = node[k + 1] - node[k];
    const double before = (table[k][term] - table[k - 1][term]) / left, after = (table[k + 1][term] - table[k][term]) / right;
    return (before * right + after * left) / (left + right);
}

static void coefficients_at(const double (*table)[FF_SCATTERING_TERMS], double alpha, coefficients *value, coefficients *slope)
{
    double v[FF_SCATTERING_TERMS], s[FF_SCATTERING_TERMS];
    const double inside = alpha < node[0] ? node[0] : alpha > node[FF_SCATTERING_NODES - 1] ? node[FF_SCATTERING_NODES - 1] : alpha;
    int k = 0;
    while (k < FF_SCATTERING_NODES - 2 && node[k + 1] <= inside) k++;
    const double h = node[k + 1] - node[k], x = (inside - node[k]) / h;
    for (int t = 0; t < FF_SCATTERING_TERMS; t++) {
        const double rise = table[k + 1][t] - table[k][t], s0 = h * slope_at(table, k, t), s1 = h * slope_at(table, k + 1, t);
        const double c2 = 3 * rise - 2 * s0 - s1, c3 = s0 + s1 - 2 * rise;
        v[t] = table[k][t] + x * (s0 + x * (c2 + x * c3));
        s[t] = inside == alpha ? (s0 + x * (2 * c2 + 3 * x * c3)) / h : 0;
    }
    const double *const from[2] = {v, s};
    coefficients *const to[2] = {value, slope};
    for (int j = 0; j < 2; j++) {
        to[j]->q = from[j][0];
        memcpy(to[j]->all, from[j] + 1, sizeof to[j]->all);
        memcpy(to[j]->two, from[j] + 1 + FF_SCATTERING_LIST, sizeof to[j]->two);
        memcpy(to[j]->three, from[j] + 1 + 2 * FF_SCATTERING_LIST, sizeof to[j]->three);
        memcpy(to[j]->turn, from[j] + 1 + 3 * FF_SCATTERING_LIST, sizeof to[j]->turn);
    }
}

/* The factor of all orders from 4 on together, F^4 (1 - q) / (1 - F q), and its derivatives. */
typedef struct later {
    double value, by_F, by_q;
} later;

static later later_orders(double F, double q)
{
    const double inv = 1 / (1 - F * q), F3 = F * F * F, F4 = F3 * F;
    return (later){F4 * (1 - q) * inv, F3 * (1 - q) * (4 - 3 * F * q) * inv * inv, F4 * (F - 1) * inv * inv};
}

/* The lists of all orders put together: sum, by F, by alpha. */
static void combine(const coefficients *c, const coefficients *s, double F, double *sum, double *by_F, double *by_alpha)
{
    const later l = later_orders(F, c->q);
    for (int t = 0; t < FF_SCATTERING_LIST; t++) {
        const double rest = c->all[t] - c->two[t] - c->three[t];
        sum[t] = F * F * c->two[t] + F * F * F * c->three[t] + l.value * rest;
        by_F[t] = 2 * F * c->two[t] + 3 * F * F * c->three[t] + l.by_F * rest;
        by_alpha[t] =
            F * F * s->two[t] + F * F * F * s->three[t] + l.value * (s->all[t] - s->two[t] - s->three[t]) + l.by_q * s->q * rest;
    }
}

/* sum of c[a, b] (x^a y^b + y^a x^b), the diagonal once; n powers. */
static inline double symmetric(const double *c, int n, double x, double y)
{
    double sum = 0, xa = 1, ya = 1;
    for (int a = 0, t = 0; a < n; a++, xa *= x, ya *= y) {
        double xb = 1, yb = 1;
        for (int b = 0; b < a; b++, t++, xb *= x, yb *= y) sum += c[t] * (xa * yb + ya * xb);
        sum += c[t++] * xa * ya;
    }
    return sum;
}

static void shape(const double *c, int powers, const double *restrict iz, const double *restrict oz, size_t n, double *restrict out)
{
    for (size_t i = 0; i < n; i++) out[i] = symmetric(c, powers, iz[i] < 1 ? iz[i] : 1, oz[i] < 1 ? oz[i] : 1);
}

/* A and, where it is wanted, d ln A by alpha. rho keeps away from 1, where A is a needle. */
static void azimuths(const coefficients *c, const coefficients *s, const ff_geometry *g, size_t n, double *restrict A,
                     double *restrict d)
{
    const double *restrict iz = g->plane[FF_G_COS_I], *restrict oz = g->plane[FF_G_COS_O], most = 0.9;
    double R[FF_BLOCK], dR[FF_BLOCK];
    shape(c->turn, 3, iz, oz, n, R);
    if (d) shape(s->turn, 3, iz, oz, n, dR);
    for (size_t i = 0; i < n; i++) {
        const double x = iz[i] < 1 ? iz[i] : 1, y = oz[i] < 1 ? oz[i] : 1, both = sqrt((1 - x * x) * (1 - y * y)),
                     free_rho = both * R[i];
        const double rho = free_rho > most ? most : free_rho < -most ? -most : free_rho;
        double sine, cosine;
        ff_sincos(g->plane[FF_G_PHI][i], &sine, &cosine);
        const double bottom = 1 - 2 * rho * cosine + rho * rho, top = 1 - rho * rho;
        A[i] = top / bottom;
        if (d) d[i] = rho == free_rho ? (-2 * rho / top - 2 * (rho - cosine) / bottom) * both * dR[i] : 0;
    }
}

static void multiple_scattering(const ff_diffuse_input *in, const ff_geometry *g, size_t n, double *restrict f, double *const *d)
{
    const double edge = 1e-6, F = in->f_average < 0 ? 0 : in->f_average < 1 ? in->f_average : 1;
    const double mean = in->mean < edge ? edge : in->mean > 1 - edge ? 1 - edge : in->mean, inv = 1 / (FF_PI * (1 - mean));
    const double *restrict ai = in->ai, *restrict ao = in->ao, *restrict iz = g->plane[FF_G_COS_I],
                           *restrict oz = g->plane[FF_G_COS_O];
    double sum[FF_SCATTERING_LIST], by_F[FF_SCATTERING_LIST], by_alpha[FF_SCATTERING_LIST];
    double P[FF_BLOCK], A[FF_BLOCK], turning[FF_BLOCK], change[FF_BLOCK];
    double *restrict dai = ff_wanted_plane(d, FF_DD_AI), *restrict dao = ff_wanted_plane(d, FF_DD_AO);
    double *restrict dmean = ff_wanted_plane(d, FF_DD_MEAN), *restrict dF = ff_wanted_plane(d, FF_DD_F_AVERAGE);
    double *restrict dalpha = ff_wanted_plane(d, FF_DD_ALPHA);
    coefficients c, s;
    coefficients_at(in->ndf && !strcmp(in->ndf->term.name, "beckmann") ? of_beckmann : of_ggx, in->alpha, &c, &s);
    combine(&c, &s, F, sum, by_F, by_alpha);
    shape(sum, 4, iz, oz, n, P);
    azimuths(&c, &s, g, n, A, dalpha ? turning : NULL);
    for (size_t i = 0; i < n; i++) {
        const double li = ai[i] < 1 ? 1 - ai[i] : 0, lo = ao[i] < 1 ? 1 - ao[i] : 0, t = P[i] > 0 ? P[i] * A[i] : 0;
        f[i] = inv * li * lo * t;
        if (dai) dai[i] = ai[i] < 1 ? -inv * lo * t : 0;
        if (dao) dao[i] = ao[i] < 1 ? -inv * li * t : 0;
        if (dmean) dmean[i] = in->mean > edge && in->mean < 1 - edge ? f[i] / (1 - mean) : 0;
        A[i] = P[i] > 0 ? inv * li * lo * A[i] : 0; /* d f / d P */
    }
    if (dF) {
        const double inside = in->f_average > 0 && in->f_average <= 1 ? 1 : 0;
        shape(by_F, 4, iz, oz, n, change);
        for (size_t i = 0; i < n; i++) dF[i] = inside * A[i] * change[i];
    }
    if (dalpha) {
        shape(by_alpha, 4, iz, oz, n, change);
        for (size_t i = 0; i < n; i++) dalpha[i] = A[i] * change[i] + f[i] * turning[i];
    }
}

static const char *const of_these[] = {"beckmann", "ggx", NULL};

const ff_diffuse FF_ISA_NAME(ff_diffuse_multiple_scattering) = {
    .term =
        {.name = "multiple-scattering",
         .title = "what Smith's facets reflect after two of them and more, from random walks",
         .source = "Heitz et al. 2016, Multiple-scattering microfacet BSDFs with the Smith model (the walks); tables of our own",
         .note = "of one lobe of beckmann or ggx with the masking smith-height-correlated; an average Fresnel above 1 counts as 1",
         .claims = FF_RECIPROCAL | FF_PASSIVE | FF_ISOTROPIC},
    .planes = 1u << FF_G_COS_I | 1u << FF_G_COS_O | 1u << FF_G_PHI,
    .couples = FF_COUPLE_LOSS | FF_COUPLE_ALPHA,
    .only = of_these,
    .eval = multiple_scattering};
