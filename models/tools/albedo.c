/* Directional albedo and weak white furnace of a model; internal_integral.h has the integrals. */
#include "internal_integral.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

static const double nu_least = 3.01; /* of a tail q^-nu whose facets have a finite area           */

/* ---- parts of a model ------------------------------------------------------------------------ */

static ff_status part_make(const ff_model *m, uint32_t lobe, const ff_kernels *kernels, size_t n_channels, const double *shape,
                           const double *channel, ff_albedo_part *p)
{
    p->n_channels = n_channels;
    ff_model_lobe_alone(m, lobe, n_channels, shape, channel, &p->model, p->shape, p->channel);
    return ff_prepare(&p->model, kernels, FF_CHEAPEST_MODE, n_channels, p->shape, p->channel, NULL, 0, INFINITY, &p->prepared);
}

/* A part and its integral: too much for a stack. */
typedef struct quadrature {
    ff_albedo_part part;
    ff_prepared whole;
    ff_integrand k;
    ff_block_work *work;
} quadrature;

static quadrature *quadrature_new(void)
{
    quadrature *q = malloc(sizeof *q);
    if (q) q->work = ff_block_work_new(1);
    if (q && q->work) return q;
    free(q);
    return NULL;
}

static void quadrature_free(quadrature *q)
{
    if (q) free(q->work);
    free(q);
}

static ff_status check_view(const double wo[3], ff_isa isa, ff_error *err)
{
    const double norm = sqrt(wo[0] * wo[0] + wo[1] * wo[1] + wo[2] * wo[2]);
    if (!(fabs(norm - 1) < 1e-9))
        return ff_error_set(err, FF_ERR_RANGE, NULL, 0, -1, "the view has length %g, expected a unit vector", norm);
    if (!(wo[2] > FF_COS_MIN))
        return ff_error_set(err, FF_ERR_RANGE, NULL, 0, -1, "the view has cosine %g, expected one above the horizon", wo[2]);
    if (!ff_isa_available(isa))
        return ff_error_set(err, FF_ERR_UNSUPPORTED, NULL, 0, -1, "this processor has no %s", ff_isa_name(isa));
    return FF_OK;
}

static ff_status out_of_memory(ff_error *err)
{
    return ff_error_set(err, FF_ERR_MEMORY, NULL, 0, -1, "no memory for the tables of the model");
}

/* ---- albedo ---------------------------------------------------------------------------------- */

/* Number of the base that is a multiple of a lobe, by a function of the view alone; n_bases: there is none. */
static uint32_t multiple_of_lobes(const ff_model *m)
{
    for (uint32_t b = 0; b < m->n_bases; b++)
        if (ff_diffuse_at(m->base[b].diffuse)->couples & FF_COUPLE_LOBE) return b;
    return m->n_bases;
}

/* m without that base. */
static ff_model without_multiple(const ff_model *m)
{
    ff_model rest = *m;
    const uint32_t at = multiple_of_lobes(m);
    if (at == m->n_bases) return rest;
    rest.n_bases--; /* it has no parameters, so that those of the others stay where they are */
    if (at == 0) rest.base[0] = rest.base[1];
    return rest;
}

/* What such a base makes of the lobe in q->part, by channel: their sum over the lobe, seen at a pair whose half vector is the
 * normal.
 */
static ff_status raise_lobe(quadrature *q, const ff_model *m, ff_isa isa, const double wo[3], double factor[FF_INTEGRAL_GROUP])
{
    ff_albedo_part *p = &q->part;
    double lobe[FF_INTEGRAL_GROUP], sum[FF_INTEGRAL_GROUP];
    const double x = -wo[0], y = -wo[1];
    const ff_dirs w = {&x, &y, &wo[2], &wo[0], &wo[1], &wo[2]};
    const uint32_t at = multiple_of_lobes(m);
    for (size_t c = 0; c < p->n_channels; c++) factor[c] = 1;
    if (at == m->n_bases) return FF_OK;
    ff_model with = p->model;
    with.n_bases = 1;
    with.base[0] = (ff_base){.diffuse = m->base[at].diffuse};
    ff_status status = ff_model_finish(&with, NULL);
    if (status == FF_OK) status = ff_model_eval(&p->model, isa, p->n_channels, p->shape, p->channel, &w, 1, lobe, NULL, 1);
    if (status == FF_OK) status = ff_model_eval(&with, isa, p->n_channels, p->shape, p->channel, &w, 1, sum, NULL, 1);
    for (size_t c = 0; c < p->n_channels && status == FF_OK; c++)
        if (lobe[c] > 0) factor[c] = sum[c] / lobe[c];
    return status;
}

static ff_status add_lobe(quadrature *q, const ff_model *m, uint32_t lobe, ff_isa isa, size_t n, const double *shape,
                          const double *channel, const double wo[3], ff_integral total[FF_INTEGRAL_GROUP])
{
    ff_integral one[FF_INTEGRAL_GROUP];
    double weight[FF_MAX_LOBES], factor[FF_INTEGRAL_GROUP];
    ff_status status = part_make(m, lobe, ff_kernels_get(isa), n, shape, channel, &q->part);
    if (status != FF_OK) return status;
    status = raise_lobe(q, m, isa, wo, factor);
    if (status != FF_OK) {
        ff_prepared_free(&q->part.prepared);
        return status;
    }
    ff_model_weights(m, shape, weight, NULL);
    ff_integrand_make(FF_INTEGRAL_LOBES, &q->part.prepared, wo, q->work, &q->k);
    ff_integrand_integrate(&q->k, one);
    ff_prepared_free(&q->part.prepared);
    for (size_t c = 0; c < n; c++) {
        total[c].value += weight[lobe] * factor[c] * one[c].value;
        total[c].error += weight[lobe] * factor[c] * one[c].error;
    }
    return FF_OK;
}

static ff_status add_bases(quadrature *q, const ff_model *m, const ff_kernels *kernels, size_t n, const double *shape,
                           const double *channel, const double wo[3], ff_integral total[FF_INTEGRAL_GROUP])
{
    ff_integral one[FF_INTEGRAL_GROUP];
    const ff_status status = ff_prepare(m, kernels, FF_CHEAPEST_MODE, n, shape, channel, NULL, 0, INFINITY, &q->whole);
    if (status != FF_OK) return status;
    ff_integrand_make(FF_INTEGRAL_BASES, &q->whole, wo, q->work, &q->k);
    ff_integrand_integrate(&q->k, one);
    ff_prepared_free(&q->whole);
    for (size_t c = 0; c < n; c++) {
        total[c].value += one[c].value;
        total[c].error += one[c].error;
    }
    return FF_OK;
}

ff_status ff_albedo_directional(const ff_model *m, ff_isa isa, size_t n_channels, const double *shape, const double *channel,
                                const double wo[3], ff_integral *out, ff_error *err)
{
    ff_status status = ff_model_check(m, n_channels, shape, channel, err);
    if (status == FF_OK) status = check_view(wo, isa, err);
    if (status != FF_OK) return status;
    const ff_kernels *kernels = ff_kernels_get(isa);
    const ff_model bases = without_multiple(m);
    quadrature *q = quadrature_new();
    if (!q) status = FF_ERR_MEMORY;
    for (size_t first = 0; first < n_channels && status == FF_OK; first += FF_INTEGRAL_GROUP) {
        const size_t n = n_channels - first < FF_INTEGRAL_GROUP ? n_channels - first : FF_INTEGRAL_GROUP;
        const double *group = channel + first * m->n_channel;
        ff_integral total[FF_INTEGRAL_GROUP] = {{0, 0}};
        for (uint32_t l = 0; l < m->n_lobes && status == FF_OK; l++) status = add_lobe(q, m, l, isa, n, shape, group, wo, total);
        if (bases.n_bases && status == FF_OK) status = add_bases(q, &bases, kernels, n, shape, group, wo, total);
        if (status == FF_OK) memcpy(out + first, total, n * sizeof *out);
    }
    quadrature_free(q);
    return status == FF_OK ? FF_OK : out_of_memory(err);
}

/* ---- weak white furnace ---------------------------------------------------------------------- */

/* G1(wo) of a form that is a function of wi and wo alone: its G2 with the light at the normal, where nothing is in shadow. */
static double g1_of(const ff_albedo_part *p, const double wo[3])
{
    static const double none = 0, up = 1;
    double d, lambda[2], g2, planes[FF_G_COUNT][1];
    ff_lobe_work work;
    const ff_dirs w = {&none, &none, &up, &wo[0], &wo[1], &wo[2]};
    ff_geometry g = {{NULL}};
    for (int k = 0; k < FF_G_COUNT; k++) g.plane[k] = planes[k];
    p->prepared.kernels->geometry(&w, 1, &g);
    p->prepared.kernels->lobe_terms(&p->prepared.lobe[0], &g, 1, &work, &d, &lambda[0], &lambda[1], &g2);
    return g2;
}

/* Is there a G1 of this masking, and does it depend on the facet? */
static ff_status check_g1(const ff_masking *masking, int *own, ff_error *err)
{
    *own = (masking->planes & 1u << FF_G_VCAVITY) != 0;
    if (*own || masking->uses_lambda || masking->uses_alpha || !masking->planes) return FF_OK;
    return ff_error_set(err, FF_ERR_UNSUPPORTED, NULL, 0, -1,
                        "%s is a factor of both directions together: there is no masking of one to test", masking->term.name);
}

static ff_status weak_furnace(quadrature *q, const ff_model *m, ff_isa isa, const double *shape, uint32_t lobe, const double wo[3],
                              int own_g1, ff_integral *out, ff_error *err)
{
    double channel[FF_MAX_CHANNEL_PARAMS];
    ff_integrand *k = &q->k;
    ff_integral result[FF_INTEGRAL_GROUP];
    ff_model_defaults(m, 1, NULL, channel);
    if (part_make(m, lobe, ff_kernels_get(isa), 1, shape, channel, &q->part) != FF_OK) return out_of_memory(err);
    q->part.prepared.lobe[0].mode = FF_TILTED_MODE; /* the one that has D by itself */
    ff_integrand_make(FF_INTEGRAL_FURNACE, &q->part.prepared, wo, q->work, k);
    if (!(k->v0 > 0)) {
        ff_prepared_free(&q->part.prepared);
        return ff_error_set(err, FF_ERR_RANGE, NULL, 0, -1,
                            "the mean slope turns the surface away from the view (projected cosine %g)", k->v0);
    }
    k->own_g1 = own_g1;
    k->g1 = own_g1 ? 1 : g1_of(&q->part, wo);
    ff_integrand_tail(k);
    if (!own_g1 && k->nu < nu_least)
        result[0] = (ff_integral){INFINITY, 0};
    else
        ff_integrand_integrate(k, result);
    ff_prepared_free(&q->part.prepared);
    *out = result[0];
    return FF_OK;
}

ff_status ff_albedo_weak_furnace(const ff_model *m, ff_isa isa, const double *shape, uint32_t lobe, const double wo[3],
                                 ff_integral *out, ff_error *err)
{
    double channel[FF_MAX_CHANNEL_PARAMS];
    int own_g1 = 0;
    ff_model_defaults(m, 1, NULL, channel);
    ff_status status = ff_model_check(m, 1, shape, channel, err);
    if (status == FF_OK) status = check_view(wo, isa, err);
    if (status != FF_OK) return status;
    if (lobe >= m->n_lobes)
        return ff_error_set(err, FF_ERR_UNSUPPORTED, NULL, 0, -1, "the model has %u lobes, the furnace test asks for lobe %u",
                            m->n_lobes, lobe + 1);
    status = check_g1(ff_masking_at(m->lobe[lobe].masking), &own_g1, err);
    if (status != FF_OK) return status;
    quadrature *q = quadrature_new();
    status = q ? weak_furnace(q, m, isa, shape, lobe, wo, own_g1, out, err) : out_of_memory(err);
    quadrature_free(q);
    return status;
}

int ff_albedo_weak_furnace_claimed(const ff_model *m, uint32_t lobe)
{
    if (lobe >= m->n_lobes) return 0;
    const uint32_t ndf = ff_ndf_at(m->lobe[lobe].ndf)->term.claims;
    const ff_masking *masking = ff_masking_at(m->lobe[lobe].masking);
    if (masking->uses_lambda) return (ndf & FF_WEAK_FURNACE) != 0;
    return (masking->term.claims & FF_WEAK_FURNACE) && (ndf & FF_UNIT_AREA);
}
