/* The geometry of a block and the pass of one lobe over it. Compiled once per instruction set.
 *
 * Notation (formulas of Heitz 2014): s slope of h, S the 2x2 covariance-like matrix [[ax^2, r ax ay], [r ax ay, ay^2]],
 *   q2 = (s - s0)^T S^-1 (s - s0),   v = t^T S t / (1 - t.s0)^2 with t = (w.x, w.y) / w.z,   so that v = 1 / a^2,
 *   P22 = p(q2) / (ax ay sqrt(1 - r^2)),   D = P22 / hz^4,   lobe S_ = P22 G K / (1 - to.s0),  K = 1 / (4 iz oz hz^4). */
#include "internal_compose.h"
#include "models/terms/internal_terms.h"
#include "base/internal_vector_math.h"

/* A slope is seen from wherever 1 - t.s0 > 0: at or below this the direction lies under the tilted surface. */
#define FF_DEN_MIN 1e-8

static inline double floor_v(double v)
{
    return v > FF_V_MIN ? v : FF_V_MIN;
}

/* 1 above the horizon, else 0. */
static inline double above(double wiz, double woz)
{
    return (wiz > FF_COS_MIN ? 1.0 : 0.0) * (woz > FF_COS_MIN ? 1.0 : 0.0);
}

static void geometry(const ff_dirs *w, size_t n, const ff_geometry *g)
{
    double *const *p = g->plane;
    /* Below the horizon every plane holds what a pair of normals would: finite, and K = 0 makes the lobe vanish. */
    double up[FF_BLOCK], inv_iz[FF_BLOCK], inv_oz[FF_BLOCK], sx[FF_BLOCK], sy[FF_BLOCK], length[FF_BLOCK];
    double tix[FF_BLOCK], tiy[FF_BLOCK], tox[FF_BLOCK], toy[FF_BLOCK];
    for (size_t i = 0; i < n; i++) {
        const double wiz = w->wiz[i], woz = w->woz[i], u = above(wiz, woz);
        const double iz = u > 0 ? wiz : 1, oz = u > 0 ? woz : 1;
        const double inv_i = ff_recip(iz), inv_o = ff_recip(oz), inv_h = ff_recip(iz + oz);
        const double hx = w->wix[i] + w->wox[i], hy = w->wiy[i] + w->woy[i], hz = iz + oz;
        up[i] = u;
        inv_iz[i] = inv_i;
        inv_oz[i] = inv_o;
        sx[i] = -hx * inv_h * u;
        sy[i] = -hy * inv_h * u;
        tix[i] = w->wix[i] * inv_i * u;
        tiy[i] = w->wiy[i] * inv_i * u;
        tox[i] = w->wox[i] * inv_o * u;
        toy[i] = w->woy[i] * inv_o * u;
        const double l2 = hx * hx + hy * hy + hz * hz;
        length[i] = u > 0 ? l2 * ff_rsqrt(l2 > 1e-30 ? l2 : 1e-30) : 2;
    }
    if (p[FF_G_S2])
        for (size_t i = 0; i < n; i++) p[FF_G_S2][i] = sx[i] * sx[i] + sy[i] * sy[i];
    if (p[FF_G_TI2])
        for (size_t i = 0; i < n; i++) p[FF_G_TI2][i] = tix[i] * tix[i] + tiy[i] * tiy[i];
    if (p[FF_G_TO2])
        for (size_t i = 0; i < n; i++) p[FF_G_TO2][i] = tox[i] * tox[i] + toy[i] * toy[i];
    if (p[FF_G_SX]) memcpy(p[FF_G_SX], sx, n * sizeof *sx);
    if (p[FF_G_SY]) memcpy(p[FF_G_SY], sy, n * sizeof *sy);
    if (p[FF_G_TIX]) memcpy(p[FF_G_TIX], tix, n * sizeof *tix);
    if (p[FF_G_TIY]) memcpy(p[FF_G_TIY], tiy, n * sizeof *tiy);
    if (p[FF_G_TOX]) memcpy(p[FF_G_TOX], tox, n * sizeof *tox);
    if (p[FF_G_TOY]) memcpy(p[FF_G_TOY], toy, n * sizeof *toy);
    if (p[FF_G_K])
        for (size_t i = 0; i < n; i++) { /* 1 / (4 cos theta_i cos theta_o cos^4 theta_h), with hz^-2 = 1 + |s|^2 */
            const double inv_hz2 = 1 + sx[i] * sx[i] + sy[i] * sy[i];
            p[FF_G_K][i] = 0.25 * inv_iz[i] * inv_oz[i] * inv_hz2 * inv_hz2 * up[i];
        }
    if (p[FF_G_C])
        for (size_t i = 0; i < n; i++) p[FF_G_C][i] = 0.5 * length[i]; /* |wi + wo| = 2 wi.h */
    if (p[FF_G_COS_I])
        for (size_t i = 0; i < n; i++) p[FF_G_COS_I][i] = up[i] > 0 ? w->wiz[i] : 1;
    if (p[FF_G_COS_O])
        for (size_t i = 0; i < n; i++) p[FF_G_COS_O][i] = up[i] > 0 ? w->woz[i] : 1;
    if (p[FF_G_VCAVITY])
        for (size_t i = 0; i < n; i++) { /* min(1, 2 hz iz / c, 2 hz oz / c), hz = (iz + oz) / |wi + wo|, c = |wi + wo| / 2 */
            const double wiz = w->wiz[i], woz = w->woz[i], iz = up[i] > 0 ? wiz : 1, oz = up[i] > 0 ? woz : 1;
            const double inv = ff_recip(length[i]), low = iz < oz ? iz : oz;
            const double ratio = 4 * (iz + oz) * low * inv * inv;
            p[FF_G_VCAVITY][i] = ratio < 1 ? ratio : 1;
        }
    if (p[FF_G_PHI])
        for (size_t i = 0; i < n; i++) {
            const double dot = tix[i] * tox[i] + tiy[i] * toy[i], cross = fabs(tix[i] * toy[i] - tiy[i] * tox[i]);
            const double some = dot * dot + cross * cross > 0 ? 1 : 0;
            p[FF_G_PHI][i] = ff_angle(some > 0 ? cross : 0, some > 0 ? dot : 1);
        }
}

/* S^-1 = 1 / (1 - r^2) [[1/ax^2, -r/(ax ay)], [., 1/ay^2]] */
typedef struct precision {
    double xx, yy, xy;
} precision;

static precision precision_of(const ff_stretch *s)
{
    const double c = 1 / (1 - s->r * s->r);
    return (precision){c / (s->ax * s->ax), c / (s->ay * s->ay), -s->r * c / (s->ax * s->ay)};
}

static void stretch_isotropic(const ff_lobe_pass *pass, const ff_geometry *g, size_t n, ff_lobe_work *t)
{
    const double a2 = pass->s.ax * pass->s.ax, inv_a2 = 1 / a2;
    const double *restrict s2 = g->plane[FF_G_S2], *restrict ti2 = g->plane[FF_G_TI2], *restrict to2 = g->plane[FF_G_TO2];
    for (size_t i = 0; i < n; i++) {
        t->q2[i] = s2[i] * inv_a2;
        t->vi[i] = floor_v(a2 * ti2[i]);
        t->vo[i] = floor_v(a2 * to2[i]);
    }
}

static void stretch_centred(const ff_lobe_pass *pass, const ff_geometry *g, size_t n, ff_lobe_work *t)
{
    const double ax = pass->s.ax, ay = pass->s.ay, r = pass->s.r, xx = ax * ax, yy = ay * ay, xy2 = 2 * r * ax * ay;
    const precision m = precision_of(&pass->s);
    const double *restrict sx = g->plane[FF_G_SX], *restrict sy = g->plane[FF_G_SY];
    const double *restrict tix = g->plane[FF_G_TIX], *restrict tiy = g->plane[FF_G_TIY];
    const double *restrict tox = g->plane[FF_G_TOX], *restrict toy = g->plane[FF_G_TOY];
    for (size_t i = 0; i < n; i++) {
        t->q2[i] = m.xx * sx[i] * sx[i] + m.yy * sy[i] * sy[i] + 2 * m.xy * sx[i] * sy[i];
        t->vi[i] = floor_v(xx * tix[i] * tix[i] + yy * tiy[i] * tiy[i] + xy2 * tix[i] * tiy[i]);
        t->vo[i] = floor_v(xx * tox[i] * tox[i] + yy * toy[i] * toy[i] + xy2 * tox[i] * toy[i]);
    }
}

static void stretch_tilted(const ff_lobe_pass *pass, const ff_geometry *g, size_t n, ff_lobe_work *t)
{
    const double ax = pass->s.ax, ay = pass->s.ay, r = pass->s.r, xx = ax * ax, yy = ay * ay, xy2 = 2 * r * ax * ay;
    const double x0 = pass->s.x0, y0 = pass->s.y0;
    const precision m = precision_of(&pass->s);
    const double *restrict sx = g->plane[FF_G_SX], *restrict sy = g->plane[FF_G_SY];
    const double *restrict tix = g->plane[FF_G_TIX], *restrict tiy = g->plane[FF_G_TIY];
    const double *restrict tox = g->plane[FF_G_TOX], *restrict toy = g->plane[FF_G_TOY];
    for (size_t i = 0; i < n; i++) {
        const double x = sx[i] - x0, y = sy[i] - y0;
        t->q2[i] = m.xx * x * x + m.yy * y * y + 2 * m.xy * x * y;
        const double deni = 1 - (tix[i] * x0 + tiy[i] * y0), deno = 1 - (tox[i] * x0 + toy[i] * y0);
        const double idi = ff_recip(deni > FF_DEN_MIN ? deni : FF_DEN_MIN), ido = ff_recip(deno > FF_DEN_MIN ? deno : FF_DEN_MIN);
        t->seen[i] = deni > FF_DEN_MIN && deno > FF_DEN_MIN ? 1 : 0;
        t->inv_deni[i] = idi;
        t->inv_deno[i] = ido;
        t->vi[i] = floor_v((xx * tix[i] * tix[i] + yy * tiy[i] * tiy[i] + xy2 * tix[i] * tiy[i]) * idi * idi);
        t->vo[i] = floor_v((xx * tox[i] * tox[i] + yy * toy[i] * toy[i] + xy2 * tox[i] * toy[i]) * ido * ido);
    }
}

static const ff_ndf *const ndf_table[] = {
#define FF_NDF_ENTRY(id) &FF_ISA_NAME(ff_ndf_##id),
#include "models/terms/models.def"
};
static const ff_masking *const masking_table[] = {
#define FF_MASKING_ENTRY(id) &FF_ISA_NAME(ff_masking_##id),
#include "models/terms/models.def"
};
static const ff_fresnel *const fresnel_table[] = {
#define FF_FRESNEL_ENTRY(id) &FF_ISA_NAME(ff_fresnel_##id),
#include "models/terms/models.def"
};
static const ff_diffuse *const diffuse_table[] = {
#define FF_DIFFUSE_ENTRY(id) &FF_ISA_NAME(ff_diffuse_##id),
#include "models/terms/models.def"
};

/* Fills q2 ... go of the work; own, NULL: not wanted: also the derivatives by the distribution's own parameters; x: also gx. */
static void lobe_stages(const ff_lobe_pass *pass, const ff_geometry *g, size_t n, ff_lobe_slopes *own, int x, ff_lobe_work *t)
{
    double *dlnp_own[FF_MAX_OWN], *dli_own[FF_MAX_OWN], *dlo_own[FF_MAX_OWN];
    for (int k = 0; k < FF_MAX_OWN && own; k++)
        dlnp_own[k] = own->dlnp_own[k], dli_own[k] = own->dli_own[k], dlo_own[k] = own->dlo_own[k];
    const ff_ndf *ndf = ndf_table[pass->ndf];
    const ff_masking *masking = masking_table[pass->masking];
    switch (pass->mode) {
    case FF_ISOTROPIC_MODE:
        stretch_isotropic(pass, g, n, t);
        break;
    case FF_CENTRED_MODE:
        stretch_centred(pass, g, n, t);
        break;
    default:
        stretch_tilted(pass, g, n, t);
    }
    ndf->profile(&pass->ndf_pass, n, t->q2, t->p, t->dlnp, own ? dlnp_own : NULL);
    if (masking->uses_lambda) {
        ndf->lambda(&pass->ndf_pass, n, t->vi, t->li, t->dli, own ? dli_own : NULL);
        ndf->lambda(&pass->ndf_pass, n, t->vo, t->lo, t->dlo, own ? dlo_own : NULL);
    }
    masking->eval(masking->uses_alpha ? pass->s.ax : pass->masking_own, g, n, t->li, t->lo, t->G, t->gi, t->go, x ? t->gx : NULL);
}

static double norm_of(const ff_stretch *s)
{
    return 1 / (s->ax * s->ay * sqrt(1 - s->r * s->r));
}

/* ei = d ln G / d vi, eo = d ln G / d vo over the work's gi, go (which are no longer needed once `own` has been served). */
static void chain_to_v(size_t n, int uses_lambda, ff_lobe_work *t, double *restrict ei, double *restrict eo)
{
    for (size_t i = 0; i < n; i++) {
        ei[i] = uses_lambda ? t->gi[i] * t->dli[i] : 0;
        eo[i] = uses_lambda ? t->go[i] * t->dlo[i] : 0;
    }
}

static void derivatives_isotropic(const ff_lobe_pass *pass, size_t n, const ff_lobe_work *restrict t, const double *restrict ei,
                                  const double *restrict eo, const double *restrict S, double *const *dS)
{
    const double two_over_a = 2 / pass->s.ax;
    double *restrict da = dS[FF_D_AX];
    if (!da) return;
    for (size_t i = 0; i < n; i++) da[i] = S[i] * two_over_a * (ei[i] * t->vi[i] + eo[i] * t->vo[i] - 1 - t->q2[i] * t->dlnp[i]);
}

/* With u = S^-1 (s - s0): d q2/d ax = -2 ux (ax ux + r ay uy), d q2/d r = -2 ax ay ux uy, d q2/d s0 = -2 u; and v = t^T S t /
 * den^2. */
static void derivatives_anisotropic(const ff_lobe_pass *pass, const ff_geometry *g, size_t n, const ff_lobe_work *restrict t,
                                    const double *restrict ei, const double *restrict eo, const double *restrict S,
                                    double *const *dS)
{
    const ff_stretch *s = &pass->s;
    const double ax = s->ax, ay = s->ay, r = s->r, axay = ax * ay;
    const double x0 = pass->mode == FF_TILTED_MODE ? s->x0 : 0, y0 = pass->mode == FF_TILTED_MODE ? s->y0 : 0;
    const precision m = precision_of(s);
    const double *restrict sx = g->plane[FF_G_SX], *restrict sy = g->plane[FF_G_SY];
    const double *restrict tix = g->plane[FF_G_TIX], *restrict tiy = g->plane[FF_G_TIY];
    const double *restrict tox = g->plane[FF_G_TOX], *restrict toy = g->plane[FF_G_TOY];
    double *restrict dax = dS[FF_D_AX], *restrict day = dS[FF_D_AY], *restrict dr = dS[FF_D_R];
    const double inv_ax = 1 / ax, inv_ay = 1 / ay, dln_norm = r / (1 - r * r);
    if (dax && day && dr)
#pragma omp simd /* more planes than the compiler cares to check for overlap at run time */
        for (size_t i = 0; i < n; i++) {
            const double x = sx[i] - x0, y = sy[i] - y0;
            const double ux = m.xx * x + m.xy * y, uy = m.xy * x + m.yy * y, twice = 2 * S[i];
            const double dp = t->dlnp[i];
            dax[i] = twice * (ei[i] * tix[i] * (ax * tix[i] + r * ay * tiy[i]) + eo[i] * tox[i] * (ax * tox[i] + r * ay * toy[i]) -
                              dp * ux * (ax * ux + r * ay * uy)) -
                     S[i] * inv_ax;
            day[i] = twice * (ei[i] * tiy[i] * (ay * tiy[i] + r * ax * tix[i]) + eo[i] * toy[i] * (ay * toy[i] + r * ax * tox[i]) -
                              dp * uy * (ay * uy + r * ax * ux)) -
                     S[i] * inv_ay;
            dr[i] = twice * axay * (ei[i] * tix[i] * tiy[i] + eo[i] * tox[i] * toy[i] - dp * ux * uy) + S[i] * dln_norm;
        }
    double *restrict dx0 = dS[FF_D_X0], *restrict dy0 = dS[FF_D_Y0];
    if (pass->mode != FF_TILTED_MODE || !dx0 || !dy0) return;
#pragma omp simd
    for (size_t i = 0; i < n; i++) {
        const double x = sx[i] - x0, y = sy[i] - y0;
        const double ux = m.xx * x + m.xy * y, uy = m.xy * x + m.yy * y;
        /* d v / d x0 = 2 v tx / den; the scaled ei already holds one 1/den^2 too many for v, which vi undoes */
        const double gi = 2 * t->gi[i] * t->dli[i] * t->vi[i] * t->inv_deni[i],
                     go = 2 * t->go[i] * t->dlo[i] * t->vo[i] * t->inv_deno[i];
        const double area = t->inv_deno[i]; /* of 1 / (1 - to.s0) itself */
        dx0[i] = S[i] * (gi * tix[i] + (go + area) * tox[i] - 2 * t->dlnp[i] * ux);
        dy0[i] = S[i] * (gi * tiy[i] + (go + area) * toy[i] - 2 * t->dlnp[i] * uy);
    }
}

static void lobe(const ff_lobe_pass *pass, const ff_geometry *g, size_t n, ff_lobe_work *restrict t, ff_lobe_slopes *restrict d,
                 double *restrict S, double *const *dS)
{
    const ff_masking *masking = masking_table[pass->masking];
    const int own = dS && dS[FF_D_OWN] && ndf_table[pass->ndf]->n_own, uses_lambda = masking->uses_lambda;
    /* where the derivative by the masking's x goes: to alpha, or to a parameter of its own */
    double *restrict dx = !dS ? NULL : masking->uses_alpha ? dS[FF_D_AX] : masking->term.n_params ? dS[FF_D_MASKING] : NULL;
    lobe_stages(pass, g, n, own ? d : NULL, dx != NULL, t);
    const double norm = norm_of(&pass->s), *restrict K = g->plane[FF_G_K];
    for (size_t i = 0; i < n; i++) S[i] = norm * t->p[i] * t->G[i] * K[i]; /* D G / (4 cos cos); D = norm p cos^-4 theta_h */
    if (pass->mode == FF_TILTED_MODE)
        for (size_t i = 0; i < n; i++) S[i] = S[i] * t->seen[i] * t->inv_deno[i];
    if (!dS || !d) return; /* derivatives come with the work that they need */
    double *restrict ei = d->ei, *restrict eo = d->eo;
    for (int k = 0; own && k < ndf_table[pass->ndf]->n_own; k++) {
        double *restrict out = dS[FF_D_OWN + k];
        const double *restrict dp = d->dlnp_own[k], *restrict di = d->dli_own[k], *restrict od = d->dlo_own[k];
        if (uses_lambda)
            for (size_t i = 0; i < n; i++) out[i] = S[i] * (dp[i] + t->gi[i] * di[i] + t->go[i] * od[i]);
        else
            for (size_t i = 0; i < n; i++) out[i] = S[i] * dp[i];
    }
    if (dx && !masking->uses_alpha)
        for (size_t i = 0; i < n; i++) dx[i] = S[i] * t->gx[i];
    chain_to_v(n, uses_lambda, t, ei, eo);
    if (pass->mode == FF_ISOTROPIC_MODE) {
        derivatives_isotropic(pass, n, t, ei, eo, S, dS);
        if (dx && masking->uses_alpha)
            for (size_t i = 0; i < n; i++) dx[i] += S[i] * t->gx[i];
        return;
    }
    if (pass->mode == FF_TILTED_MODE) {
        if (!uses_lambda) { /* the slope derivatives read these */
            memset(t->gi, 0, sizeof t->gi), memset(t->go, 0, sizeof t->go), memset(t->dli, 0, sizeof t->dli),
                memset(t->dlo, 0, sizeof t->dlo);
        }
        for (size_t i = 0; i < n; i++) {
            ei[i] *= t->inv_deni[i] * t->inv_deni[i];
            eo[i] *= t->inv_deno[i] * t->inv_deno[i];
        }
    }
    derivatives_anisotropic(pass, g, n, t, ei, eo, S, dS);
}

static void lobe_terms(const ff_lobe_pass *pass, const ff_geometry *g, size_t n, ff_lobe_work *t, double *restrict d,
                       double *restrict li, double *restrict lo, double *restrict gg)
{
    lobe_stages(pass, g, n, NULL, 0, t);
    const double norm = norm_of(&pass->s), *restrict sx = g->plane[FF_G_SX], *restrict sy = g->plane[FF_G_SY];
    const double *restrict K = g->plane[FF_G_K];
    const int uses_lambda = masking_table[pass->masking]->uses_lambda;
    for (size_t i = 0; i < n; i++) {
        const double inv_hz2 = 1 + sx[i] * sx[i] + sy[i] * sy[i], up = K[i] > 0 ? 1 : 0;
        d[i] = up * norm * t->p[i] * inv_hz2 * inv_hz2;
        li[i] = uses_lambda ? up * t->li[i] : 0;
        lo[i] = uses_lambda ? up * t->lo[i] : 0;
        gg[i] = up * t->seen[i] * t->G[i];
    }
}

extern const ff_kernels FF_ISA_NAME(ff_kernels);
const ff_kernels FF_ISA_NAME(ff_kernels) = {
    .ndf = ndf_table,
    .masking = masking_table,
    .fresnel = fresnel_table,
    .diffuse = diffuse_table,
    .geometry = geometry,
    .lobe = lobe,
    .lobe_terms = lobe_terms,
    .block_shape = ff_compose_shape,
    .block_value = ff_compose_value,
    .block_columns = ff_compose_columns,
    .albedo_add = ff_albedo_add,
    .albedo_at = ff_albedo_at,
};
