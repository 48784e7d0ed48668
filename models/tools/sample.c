/* Directions drawn in proportion to a model; the strategies are listed in ff_sample.h.
 *
 *   s = s0 + L u       slope of the normal h, L L^T = [[ax^2, r ax ay], [r ax ay, ay^2]]; the density of u is p(|u|^2)
 *   V = wo.h / h.z = v0 - l.u,    v0 = wo.z - wo.s0,  l = L^T wo: what a unit surface without mean slope shows to the view (l, v0)
 *   dwi = 4 (wo.h) dh,  dh = h.z^3 ds
 *
 *   visible normals    density of u: p V+ / N,  N = integral of p V+ = v0 (1 + Lambda);  of wi: D / (4 N)
 *   normals            density of u: p,                                                  of wi: D h.z / (4 wo.h)
 *   normals, no unit area    density of u: p / h.z over its integral,                    of wi: D / (4 wo.h), likewise
 *
 * Shear and stretch carry the visible normals of any ellipse and mean slope over to those of the unit surface seen from (l, v0).
 * There ggx is the uniform hemisphere, whose mirror images of a view fill a cap of the sphere evenly (Dupuy and Benyoub 2023; the
 * normals are those of Heitz 2018), and beckmann has Gaussian slopes: independent across the view, and along it of density
 * (a + x)+ exp(-x^2), a = v0 / |l| (Heitz and d'Eon 2014), whose integral is inverted here by Halley's iteration. */
#define FF_ISA_SUFFIX scalar
#include "internal_sample.h"
#include "models/terms/internal_isotropic.h"
#include <stdlib.h>

static const double least_share = 0.01;

/* ---- the sampler ----------------------------------------------------------------------------- */

struct ff_sampler {
    ff_model model;
    double *channel;
    ff_prepared prepared;
    uint32_t planes; /* of geometry */
    size_t n;
    ff_sample_component part[FF_SAMPLE_COMPONENTS];
};

static void pairs_geometry(const ff_sampler *s, ff_sample_pairs *b)
{
    const ff_dirs w = {b->w[0], b->w[1], b->w[2], b->w[3], b->w[4], b->w[5]};
    for (int k = 0; k < FF_G_COUNT; k++) b->g.plane[k] = s->planes & 1u << k ? b->plane[k] : NULL;
    s->prepared.kernels->geometry(&w, b->n, &b->g);
}

/* ---- the mixture ----------------------------------------------------------------------------- */

/* x: the place of a view between the nodes. */
static double table_at(const double albedo[FF_SAMPLE_VIEWS], double x)
{
    const int j = x < FF_SAMPLE_VIEWS - 2 ? (int)x : FF_SAMPLE_VIEWS - 2;
    return albedo[j] + (x - j) * (albedo[j + 1] - albedo[j]);
}

static void shares_of(const ff_sampler *s, const ff_sample_pairs *b, ff_sample_shares *out)
{
    out->n = s->n;
    for (size_t i = 0; i < b->n; i++) {
        const double o[3] = {b->w[3][i], b->w[4][i], b->w[5][i]};
        const double x = o[2] > 0 ? sqrt(o[2] < 1 ? o[2] : 1) * (FF_SAMPLE_VIEWS - 1) : 0;
        double a[FF_SAMPLE_COMPONENTS], sum = 0, all = 0;
        for (size_t k = 0; k < s->n; k++) {
            a[k] = ff_sample_sees(&s->part[k], o) ? table_at(s->part[k].albedo, x) : -1;
            if (a[k] > 0) sum += a[k];
        }
        const double least = least_share * sum + 1e-300;
        for (size_t k = 0; k < s->n; k++) {
            a[k] = a[k] < 0 ? 0 : a[k] > least ? a[k] : least;
            all += a[k];
        }
        for (size_t k = 0; k < s->n; k++) out->of[k][i] = all > 0 ? a[k] / all : 0;
        out->albedo[i] = sum;
    }
}

static void mixture(const ff_sampler *s, const ff_sample_pairs *b, const ff_sample_shares *share, double *pdf)
{
    double one[FF_BLOCK];
    memset(pdf, 0, b->n * sizeof *pdf);
    for (size_t k = 0; k < s->n; k++) {
        ff_sample_density(&s->part[k], b, one);
        for (size_t i = 0; i < b->n; i++) pdf[i] += share->of[k][i] * one[i];
    }
    for (size_t i = 0; i < b->n; i++)
        if (!(b->plane[FF_G_K][i] > 0)) pdf[i] = 0;
}

/* The strategy in whose share u lies; the last that has one where rounding leaves a gap. */
static size_t choose(const ff_sampler *s, const ff_sample_shares *share, size_t i, double u)
{
    size_t last = s->n;
    double below = 0;
    for (size_t k = 0; k < s->n; k++) {
        if (share->of[k][i] == 0) continue;
        below += share->of[k][i];
        last = k;
        if (u < below) break;
    }
    return last;
}

/* ---- tables of a new sampler ----------------------------------------------------------------- */

/* wo of a pair of the block. */
static void set_view(ff_sample_pairs *b, size_t i, double mu, double turn)
{
    const double side = sqrt((1 - mu) * (1 + mu));
    b->w[3][i] = side * cos(turn);
    b->w[4][i] = side * sin(turn);
    b->w[5][i] = mu;
}

/* What component `at` alone reflects, summed over channels. */
static void value_of(const ff_sampler *s, const ff_sample_pairs *b, size_t at, double *out)
{
    const ff_prepared *p = &s->prepared;
    double f[FF_BLOCK];
    ff_block t;
    t.d = NULL;
    memset(out, 0, b->n * sizeof *out);
    p->kernels->block_shape(p, &b->g, b->n, &t);
    for (size_t c = 0; c < p->n_channels; c++) {
        p->kernels->block_value(p, &b->g, b->n, c, &t, f);
        const int lobe = at < p->m->n_lobes;
        const double *x = lobe ? t.S[at] : t.part[at - p->m->n_lobes], *F = t.F[lobe ? ff_model_group(p->m, (uint32_t)at) : 0];
        const double scale = lobe ? p->weight[at] : t.scale[at - p->m->n_lobes];
        for (size_t i = 0; i < b->n; i++) out[i] += scale * x[i] * (lobe ? F[i] : 1);
    }
}

/* As a function of wi.z; it is a product with one of wo.z, so that any views will do. At least a hundredth of its maximum, lest a
 * direction be left out. */
static void matte_make(ff_sampler *s, size_t at)
{
    static const double views[] = {0.1, 0.4, 0.7, 1};
    ff_sample_component *k = &s->part[at];
    double most = 0, f[FF_BLOCK];
    ff_sample_pairs b = {.n = FF_SAMPLE_MATTE};
    for (size_t v = 0; v < sizeof views / sizeof views[0]; v++) {
        for (size_t j = 0; j < FF_SAMPLE_MATTE; j++) {
            const double mu = fmax(sqrt(ff_matte_node((int)j)), 1e-6), side = sqrt((1 - mu) * (1 + mu));
            b.w[0][j] = side, b.w[1][j] = 0, b.w[2][j] = mu;
            set_view(&b, j, views[v], 0);
        }
        pairs_geometry(s, &b);
        value_of(s, &b, at, f);
        for (size_t j = 0; j < FF_SAMPLE_MATTE; j++) k->rest[j] += f[j];
    }
    for (size_t j = 0; j < FF_SAMPLE_MATTE; j++) most = fmax(most, k->rest[j]);
    for (size_t j = 0; j < FF_SAMPLE_MATTE; j++) k->rest[j] = most > 0 ? fmax(k->rest[j], least_share * most) : 1;
    for (int j = 0; j + 1 < FF_SAMPLE_MATTE; j++)
        k->below[j + 1] = k->below[j] + 0.5 * (ff_matte_node(j + 1) - ff_matte_node(j)) * (k->rest[j] + k->rest[j + 1]);
}

/* The mean over azimuths and channels by the component's own samples, at the points of a lattice in place of random numbers
 * (Roberts 2018: the multiples of powers of 1/g, g^4 = g + 1). */
static void albedo_make(ff_sampler *s, size_t at)
{
    static const double step[3] = {0.8191725133961645, 0.6710436067037893, 0.5497004779019703};
    ff_sample_component *k = &s->part[at];
    for (int j = 0; j < FF_SAMPLE_VIEWS; j++) {
        const double x = (double)j / (FF_SAMPLE_VIEWS - 1);
        double pdf[FF_BLOCK], f[FF_BLOCK], sum = 0;
        ff_sample_pairs b = {.n = FF_BLOCK};
        for (size_t i = 0; i < b.n; i++) {
            double u[3], o[3], wi[3] = {0, 0, -1};
            for (int d = 0; d < 3; d++) u[d] = fmod(0.5 + (double)(i + 1) * step[d], 1);
            set_view(&b, i, fmax(x * x, 1e-3), 2 * FF_PI * u[0]);
            for (int d = 0; d < 3; d++) o[d] = b.w[3 + d][i];
            if (ff_sample_sees(k, o)) ff_sample_draw(k, o, u[1], u[2], wi);
            for (int d = 0; d < 3; d++) b.w[d][i] = wi[d];
        }
        pairs_geometry(s, &b);
        ff_sample_density(k, &b, pdf);
        value_of(s, &b, at, f);
        for (size_t i = 0; i < b.n; i++)
            if (b.plane[FF_G_K][i] > 0 && pdf[i] > 0) sum += f[i] * b.w[2][i] / pdf[i];
        k->albedo[j] = sum / ((double)b.n * (double)s->prepared.n_channels);
    }
}

static ff_status lobe_make(const ff_prepared *p, uint32_t l, ff_sample_component *k)
{
    const ff_stretch *t = &p->lobe[l].s;
    k->ndf = p->kernels->ndf[p->lobe[l].ndf];
    k->pass = &p->lobe[l];
    k->l11 = t->ax;
    k->l21 = t->r * t->ay;
    k->l22 = t->ay * sqrt((1 - t->r) * (1 + t->r));
    k->unit_area = (k->ndf->term.claims & FF_UNIT_AREA) != 0;
    k->kind = FF_SAMPLE_NORMALS;
    k->radial.total = 1;
    return ff_sample_closed_form(k) ? FF_OK : ff_sample_radial_make(k);
}

static ff_status sampler_fill(ff_sampler *s, const ff_kernels *kernels, size_t n_channels, const double *shape)
{
    ff_prepared *p = &s->prepared;
    ff_status status = ff_prepare(&s->model, kernels, FF_CHEAPEST_MODE, n_channels, shape, s->channel, NULL, 0, INFINITY, p);
    if (status) return status;
    s->planes = ff_prepared_planes(p) | 1u << FF_G_K | 1u << FF_G_SX | 1u << FF_G_SY | 1u << FF_G_C;
    s->n = p->m->n_lobes + p->n_parts;
    for (uint32_t l = 0; l < p->m->n_lobes && !status; l++) status = lobe_make(p, l, &s->part[l]);
    for (uint32_t at = p->m->n_lobes; at < s->n && !status; at++) {
        const ff_part *part = &p->part[at - p->m->n_lobes];
        const uint32_t couples = kernels->diffuse[p->m->base[part->base].diffuse]->couples;
        const int left_over = (couples & (FF_COUPLE_ALBEDO | FF_COUPLE_LOSS)) != 0;
        if (couples & FF_COUPLE_LOBE) { /* it goes where the lobe goes */
            status = lobe_make(p, (uint32_t)part->lobe, &s->part[at]);
            continue;
        }
        if (kernels->diffuse[p->m->base[part->base].diffuse]->peak) {
            s->part[at].kind = FF_SAMPLE_PEAK;
            kernels->diffuse[p->m->base[part->base].diffuse]->peak(p->base_param[part->base], &s->part[at].width,
                                                                   &s->part[at].power);
            continue;
        }
        s->part[at].kind = left_over ? FF_SAMPLE_MATTE_TABLE : FF_SAMPLE_COSINE;
        if (left_over) matte_make(s, at);
    }
    for (size_t at = 0; at < s->n && !status; at++) albedo_make(s, at);
    return status;
}

/* ---- public ---------------------------------------------------------------------------------- */

ff_status ff_sampler_new(const ff_model *m, ff_isa isa, size_t n_channels, const double *shape, const double *channel,
                         ff_sampler **out, ff_error *err)
{
    const ff_kernels *kernels = ff_kernels_get(isa);
    ff_status status = ff_model_check(m, n_channels, shape, channel, err);
    if (status) return status;
    if (!kernels) return ff_error_set(err, FF_ERR_UNSUPPORTED, NULL, 0, -1, "this processor has no %s", ff_isa_name(isa));
    ff_sampler *s = calloc(1, sizeof *s);
    if (s) s->channel = malloc((n_channels * m->n_channel + 1) * sizeof *channel);
    if (!s || !s->channel) {
        free(s);
        return ff_error_set(err, FF_ERR_MEMORY, NULL, 0, -1, "no memory for a sampler of %zu channels", n_channels);
    }
    s->model = *m;
    memcpy(s->channel, channel, n_channels * m->n_channel * sizeof *channel);
    status = sampler_fill(s, kernels, n_channels, shape);
    if (status) {
        ff_sampler_free(s);
        return ff_error_set(err, status, NULL, 0, -1, "no sampler can be made of this model: %s", ff_status_str(status));
    }
    *out = s;
    return FF_OK;
}

void ff_sampler_free(ff_sampler *s)
{
    if (!s) return;
    for (size_t k = 0; k < FF_SAMPLE_COMPONENTS; k++) free(s->part[k].radial.node);
    ff_prepared_free(&s->prepared);
    free(s->channel);
    free(s);
}

/* Pairs first ... of [3][ld] planes. */
static void load(ff_sample_pairs *b, int from, const double *v, size_t first, size_t ld)
{
    for (size_t j = 0; j < 3; j++) memcpy(b->w[(size_t)from + j], v + j * ld + first, b->n * sizeof *v);
}

static void draw_block(const ff_sampler *s, const ff_sample_shares *share, const double *u, size_t ld, ff_sample_pairs *b)
{
    for (size_t i = 0; i < b->n; i++) {
        const double o[3] = {b->w[3][i], b->w[4][i], b->w[5][i]}, most = 1 - 0x1p-53;
        const size_t k = choose(s, share, i, u[i]);
        double wi[3] = {0, 0, -1};
        if (k < s->n) ff_sample_draw(&s->part[k], o, fmin(u[ld + i], most), u[2 * ld + i], wi);
        for (size_t j = 0; j < 3; j++) b->w[j][i] = wi[j];
    }
}

/* With f wi.z / pdf over `goes_on`, 0 where the path ends. Not a part of its caller, which has the pairs on its stack. */
static __attribute__((noinline)) void weigh_block(const ff_sampler *s, const ff_sample_pairs *b, const double *pdf,
                                                  const double *goes_on, double *f, double *weight, size_t ld)
{
    const ff_prepared *p = &s->prepared;
    double value[FF_BLOCK];
    ff_block t;
    t.d = NULL;
    p->kernels->block_shape(p, &b->g, b->n, &t);
    for (size_t c = 0; c < p->n_channels; c++) {
        p->kernels->block_value(p, &b->g, b->n, c, &t, value);
        for (size_t i = 0; i < b->n; i++) {
            if (!(b->plane[FF_G_K][i] > 0)) value[i] = 0;
            weight[c * ld + i] = pdf[i] > 0 && goes_on[i] > 0 ? value[i] * b->w[2][i] / (pdf[i] * goes_on[i]) : 0;
        }
        if (f) memcpy(f + c * ld, value, b->n * sizeof *f);
    }
}

void ff_sampler_sample_block(const ff_sampler *s, size_t n, const double *wo, const double *u, const double *roulette, double *wi,
                             double *pdf, double *f, double *weight, size_t ld, ff_sample_shares *share)
{
    double goes_on[FF_BLOCK];
    ff_sample_pairs b;
    b.n = n;
    load(&b, 3, wo, 0, ld);
    shares_of(s, &b, share);
    draw_block(s, share, u, ld, &b);
    pairs_geometry(s, &b);
    mixture(s, &b, share, pdf);
    for (size_t i = 0; i < n; i++) {
        const double q = roulette ? fmax(fmin(share->albedo[i], 1), least_share) : 1;
        goes_on[i] = !roulette || roulette[i] < q ? q : 0;
    }
    weigh_block(s, &b, pdf, goes_on, f, weight, ld);
    for (size_t j = 0; j < 3; j++) memcpy(wi + j * ld, b.w[j], n * sizeof *wi);
}

void ff_sampler_sample(const ff_sampler *s, size_t n, const double *wo, const double *u, const double *roulette, double *wi,
                       double *pdf, double *f, double *weight, size_t ld)
{
    for (size_t first = 0; first < n; first += FF_BLOCK) {
        ff_sample_shares share;
        ff_sampler_sample_block(s, n - first < FF_BLOCK ? n - first : FF_BLOCK, wo + first, u + first,
                                roulette ? roulette + first : NULL, wi + first, pdf + first, f ? f + first : NULL, weight + first,
                                ld, &share);
    }
}

void ff_sampler_pdf(const ff_sampler *s, size_t n, const double *wo, const double *wi, double *pdf, size_t ld)
{
    for (size_t first = 0; first < n; first += FF_BLOCK) {
        ff_sample_shares share;
        ff_sample_pairs b;
        b.n = n - first < FF_BLOCK ? n - first : FF_BLOCK;
        load(&b, 3, wo, first, ld);
        load(&b, 0, wi, first, ld);
        shares_of(s, &b, &share);
        pairs_geometry(s, &b);
        mixture(s, &b, &share, pdf + first);
    }
}

/* Not a part of its caller, which has the pairs on its stack. */
static __attribute__((noinline)) void values_of_block(const ff_sampler *s, const ff_sample_pairs *b, double *f, size_t ld)
{
    const ff_prepared *p = &s->prepared;
    ff_block t;
    t.d = NULL;
    p->kernels->block_shape(p, &b->g, b->n, &t);
    for (size_t c = 0; c < p->n_channels; c++) {
        p->kernels->block_value(p, &b->g, b->n, c, &t, f + c * ld);
        for (size_t i = 0; i < b->n; i++)
            if (!(b->w[2][i] > FF_COS_MIN && b->w[5][i] > FF_COS_MIN)) f[c * ld + i] = 0;
    }
}

void ff_sampler_values_block(const ff_sampler *s, size_t n, const double *wo, const double *wi, const ff_sample_shares *share,
                             double *pdf, double *f, size_t ld)
{
    ff_sample_pairs b;
    b.n = n;
    load(&b, 3, wo, 0, ld);
    load(&b, 0, wi, 0, ld);
    pairs_geometry(s, &b);
    if (pdf) mixture(s, &b, share, pdf);
    if (f) values_of_block(s, &b, f, ld);
}
