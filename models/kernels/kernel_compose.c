/* A composed model over a block of samples: f = sum over lobes of ks F S + bases, and its derivatives by the product rule.
 * Compiled once per instruction set. */
#include "internal_compose.h"
#include <string.h>

/* ---- what all channels share ----------------------------------------------------------------- */

/* The weighted sum of the lobes that use the Fresnel term of lobe l. */
static const double *group_sum(const ff_prepared *p, uint32_t l, size_t n, ff_block *b)
{
    uint32_t members = 0;
    for (uint32_t k = 0; k < p->m->n_lobes; k++) members += ff_model_group(p->m, k) == l;
    if (members == 1 && p->weight[l] == 1) return b->S[l];
    double *restrict sum = b->sum[l];
    memset(sum, 0, n * sizeof *sum);
    for (uint32_t k = 0; k < p->m->n_lobes; k++) {
        const double *restrict S = b->S[k], weight = p->weight[k];
        if (ff_model_group(p->m, k) == l)
            for (size_t i = 0; i < n; i++) sum[i] += weight * S[i];
    }
    return sum;
}

static void add_scaled(size_t n, double factor, const double *restrict in, double *restrict out)
{
    for (size_t i = 0; i < n; i++) out[i] += factor * in[i];
}

/* d S / d (column k): one of the kernels' planes, or a sum of them. */
static const double *shape_plane(const ff_prepared *p, uint32_t k, size_t n, ff_block *b)
{
    const ff_shape_column *c = &p->shape[k];
    double *out = b->d->combined[k];
    if (c->moves_weights) {
        memset(out, 0, n * sizeof *out);
        for (uint32_t l = 0; l < p->m->n_lobes; l++)
            if (c->weight[l] != 0) add_scaled(n, c->weight[l], b->S[l], out);
        return out;
    }
    if (c->lobe < 0) return NULL;
    int only = -1, count = 0;
    for (int d = 0; d < FF_D_COUNT; d++)
        if (c->d[d] != 0) only = d, count++;
    if (count == 1 && c->d[only] == 1) return b->d->dS[c->lobe][only];
    memset(out, 0, n * sizeof *out);
    for (int d = 0; d < FF_D_COUNT; d++)
        if (c->d[d] != 0) add_scaled(n, c->d[d], b->d->dS[c->lobe][d], out);
    return out;
}

void ff_compose_shape(const ff_prepared *p, const ff_geometry *g, size_t n, ff_block *b)
{
    const ff_model *m = p->m;
    for (uint32_t l = 0; l < m->n_lobes; l++) {
        double *dS[FF_D_COUNT];
        for (int d = 0; d < FF_D_COUNT; d++) dS[d] = p->needs[l] & 1u << d ? b->d->dS[l][d] : NULL;
        p->kernels->lobe(&p->lobe[l], g, n, &b->lobe, p->needs[l] ? &b->d->lobe : NULL, b->S[l], p->needs[l] ? dS : NULL);
    }
    for (uint32_t l = 0; l < m->n_lobes; l++)
        if (ff_model_group(m, l) == l) b->group[l] = group_sum(p, l, n, b);
    for (uint32_t k = 0; k < p->wanted.n_shape; k++) b->d->shape[k] = shape_plane(p, k, n, b);
    if (p->n_parts == 0 || !(p->couples & (FF_COUPLE_ALBEDO | FF_COUPLE_LOSS))) return;
    ff_albedo_place_of(n, g->plane[FF_G_COS_I], &b->place_i);
    ff_albedo_place_of(n, g->plane[FF_G_COS_O], &b->place_o);
}

/* ---- one channel ----------------------------------------------------------------------------- */

static void scale_by(size_t n, double factor, double *restrict v)
{
    for (size_t i = 0; i < n; i++) v[i] *= factor;
}

/* Is the derivative by channel parameter `at` of the model wanted? */
static int is_wanted(const ff_wanted *w, uint32_t at)
{
    for (uint32_t k = 0; k < w->n_channel; k++)
        if (w->channel[k] == at) return 1;
    return 0;
}

/* ks F of lobe l and its derivatives; that by ks is F. */
static void fresnel(const ff_prepared *p, const ff_geometry *g, size_t n, const double *channel, uint32_t l, ff_block *b)
{
    const ff_lobe *lobe = &p->m->lobe[l];
    const ff_fresnel *term = p->kernels->fresnel[lobe->fresnel];
    const uint32_t n_params = term->term.n_params, at = lobe->channel0;
    double *d[FF_FRESNEL_PARAMS];
    for (uint32_t k = 0; k < n_params && p->wanted.n_channel; k++) d[k] = b->d->dF[at + k];
    term->eval(channel + at, g, n, b->F[l], p->wanted.n_channel ? d : NULL);
    const double ks = channel[at + n_params];
    if (is_wanted(&p->wanted, at + n_params)) memcpy(b->d->dF[at + n_params], b->F[l], n * sizeof(double));
    if (ks == 1) return;
    scale_by(n, ks, b->F[l]);
    for (uint32_t k = 0; k < n_params && p->wanted.n_channel; k++) scale_by(n, ks, d[k]);
}

/* Where F at normal incidence stands of the lobe that a part belongs to, or of the first one. */
static size_t f0_at(const ff_prepared *p, size_t c, const ff_part *part)
{
    return (c * p->m->n_lobes + (part->lobe < 0 ? 0 : (size_t)part->lobe)) * (1 + FF_FRESNEL_PARAMS);
}

/* The inputs of part `at` for channel c. */
static void part_input(const ff_prepared *p, size_t n, size_t c, uint32_t at, ff_block *b, ff_diffuse_input *in)
{
    const ff_part *part = &p->part[at];
    const ff_base *base = &p->m->base[part->base];
    const ff_diffuse *term = p->kernels->diffuse[base->diffuse];
    const double *channel = p->channel + c * p->m->n_channel + base->channel0;
    for (uint32_t k = 0; k < term->term.n_params; k++)
        in->params[k] = term->term.params[k].flags & FF_PARAM_PER_CHANNEL ? *channel++ : p->base_param[part->base][k];
    in->alpha = p->alpha;
    in->ndf = p->m->n_lobes ? p->kernels->ndf[p->lobe[part->lobe < 0 ? 0 : part->lobe].ndf] : NULL;
    in->f0 = p->f0 ? p->f0[f0_at(p, c, part)] : 0;
    in->ai = b->ai;
    in->ao = b->ao;
    in->fresnel = b->F[0];
    const ff_albedo_curve *curve = NULL;
    if (term->couples & FF_COUPLE_ALBEDO) curve = &p->albedo[c];
    if (term->couples & FF_COUPLE_LOSS) {
        const uint32_t group = ff_model_group(p->m, (uint32_t)part->lobe);
        curve = &p->loss[part->lobe];
        in->f_average = p->f_average[(c * p->m->n_lobes + group) * (1 + FF_FRESNEL_PARAMS)];
        in->lobe = b->lobe_value;
        if (term->couples & FF_COUPLE_LOBE)
            for (size_t i = 0; i < n; i++) b->lobe_value[i] = b->S[part->lobe][i] * b->F[group][i];
    }
    if (!curve) return;
    ff_albedo_values(curve, 0, n, &b->place_i, b->ai);
    ff_albedo_values(curve, 0, n, &b->place_o, b->ao);
    in->mean = curve->mean[0];
}

/* ks of the lobe that a part belongs to, unless the part has it from the value of the lobe. */
static double part_ks(const ff_prepared *p, size_t c, const ff_part *part)
{
    if (p->kernels->diffuse[p->m->base[part->base].diffuse]->couples & FF_COUPLE_LOBE) return 1;
    const ff_lobe *lobe = &p->m->lobe[ff_model_group(p->m, (uint32_t)part->lobe)];
    return p->channel[c * p->m->n_channel + lobe->channel0 + lobe->n_channel - 1];
}

static void add_part(const ff_prepared *p, const ff_geometry *g, size_t n, size_t c, uint32_t at, ff_block *b, double *restrict f)
{
    const ff_diffuse *term = p->kernels->diffuse[p->m->base[p->part[at].base].diffuse];
    ff_diffuse_input in = {.mean = 0};
    double *d[FF_DD_COUNT];
    const int derivatives = p->wanted.n_shape + p->wanted.n_channel > 0;
    for (int k = 0; k < FF_DD_COUNT && derivatives; k++) d[k] = b->d->d_part[at][k];
    part_input(p, n, c, at, b, &in);
    if (derivatives) { /* not every coupled term depends on them */
        memset(d[FF_DD_MEAN], 0, n * sizeof(double));
        memset(d[FF_DD_AI], 0, n * sizeof(double));
    }
    term->eval(&in, g, n, b->part[at], derivatives ? d : NULL);
    b->scale[at] = p->part[at].lobe < 0 ? 1 : p->weight[p->part[at].lobe] * part_ks(p, c, &p->part[at]);
    add_scaled(n, b->scale[at], b->part[at], f);
}

void ff_compose_value(const ff_prepared *p, const ff_geometry *g, size_t n, size_t c, ff_block *b, double *restrict f)
{
    const ff_model *m = p->m;
    const double *channel = p->channel + c * m->n_channel;
    for (uint32_t l = 0; l < m->n_lobes; l++) {
        if (ff_model_group(m, l) != l) continue;
        fresnel(p, g, n, channel, l, b);
        const double *restrict S = b->group[l], *restrict F = b->F[l];
        if (l == 0)
            for (size_t i = 0; i < n; i++) f[i] = S[i] * F[i];
        else
            for (size_t i = 0; i < n; i++) f[i] += S[i] * F[i];
    }
    if (m->n_lobes == 0) memset(f, 0, n * sizeof *f);
    for (uint32_t at = 0; at < p->n_parts; at++) add_part(p, g, n, c, at, b, f);
}

/* ---- columns --------------------------------------------------------------------------------- */

static void product(size_t n, const double *restrict a, const double *restrict b, const double *restrict j, double *restrict out)
{
    for (size_t i = 0; i < n; i++) out[i] = a[i] * b[i] * j[i];
}

static void add_product(size_t n, double factor, const double *restrict a, const double *restrict j, double *restrict out)
{
    for (size_t i = 0; i < n; i++) out[i] += factor * a[i] * j[i];
}

static void add_triple(size_t n, double factor, const double *restrict a, const double *restrict b, const double *restrict c,
                       const double *restrict j, double *restrict out)
{
    for (size_t i = 0; i < n; i++) out[i] += factor * a[i] * b[i] * c[i] * j[i];
}

/* Adds what a part changes through the albedo curve when function `function` of it does. */
static void add_through_albedo(size_t n, const ff_albedo_curve *curve, uint32_t function, uint32_t at, const double *restrict j,
                               const ff_block *b, double *restrict out)
{
    double ai[FF_BLOCK], ao[FF_BLOCK];
    ff_albedo_values(curve, function, n, &b->place_i, ai);
    ff_albedo_values(curve, function, n, &b->place_o, ao);
    const double scale = b->scale[at], mean = curve->mean[function];
    const double *restrict di = b->d->d_part[at][FF_DD_AI], *restrict od = b->d->d_part[at][FF_DD_AO],
                           *restrict dm = b->d->d_part[at][FF_DD_MEAN];
    for (size_t i = 0; i < n; i++) out[i] += scale * (di[i] * ai[i] + od[i] * ao[i] + dm[i] * mean) * j[i];
}

/* What the bases feel of shared column k. */
static void add_base_shape(const ff_prepared *p, size_t n, size_t c, uint32_t k, const double *restrict j, const ff_block *b,
                           double *restrict out)
{
    const ff_shape_column *column = &p->shape[k];
    for (uint32_t at = 0; at < p->n_parts; at++) {
        const ff_part *part = &p->part[at];
        const uint32_t couples = p->kernels->diffuse[p->m->base[part->base].diffuse]->couples;
        if (column->base == (int)part->base) add_product(n, b->scale[at], b->d->d_part[at][column->base_param], j, out);
        if (column->base >= 0) continue; /* nothing else depends on it */
        if ((couples & FF_COUPLE_ALPHA) && column->alpha != 0)
            add_product(n, b->scale[at] * column->alpha, b->d->d_part[at][FF_DD_ALPHA], j, out);
        if (couples & FF_COUPLE_ALBEDO) add_through_albedo(n, &p->albedo[c], 1 + k, at, j, b, out);
        if (!(couples & FF_COUPLE_LOSS)) continue;
        if (column->lobe == part->lobe) add_through_albedo(n, &p->loss[part->lobe], 1 + k, at, j, b, out);
        if ((couples & FF_COUPLE_LOBE) && column->lobe == part->lobe && b->d->shape[k])
            add_triple(n, 1, b->d->shape[k], b->F[ff_model_group(p->m, (uint32_t)part->lobe)], b->d->d_part[at][FF_DD_LOBE], j,
                       out);
        if (column->moves_weights) add_product(n, part_ks(p, c, part) * column->weight[part->lobe], b->part[at], j, out);
    }
}

/* What the bases feel of channel column k, which is function `function` of the albedo curves. */
static void add_base_channel(const ff_prepared *p, size_t n, size_t c, uint32_t k, const double *restrict j, const ff_block *b,
                             double *restrict out)
{
    const ff_channel_column *column = &p->column[k];
    for (uint32_t at = 0; at < p->n_parts; at++) {
        const ff_part *part = &p->part[at];
        const uint32_t couples = p->kernels->diffuse[p->m->base[part->base].diffuse]->couples;
        if (column->base == (int)part->base) add_product(n, b->scale[at], b->d->d_part[at][column->param], j, out);
        if (column->group < 0) continue;
        const uint32_t group = part->lobe < 0 ? 0 : ff_model_group(p->m, (uint32_t)part->lobe);
        const double *plane = b->d->dF[p->wanted.channel[k]];
        if ((couples & FF_COUPLE_F0) && (uint32_t)column->group == group && !column->is_scale)
            add_product(n, b->scale[at] * p->f0[f0_at(p, c, part) + 1 + column->param], b->d->d_part[at][FF_DD_F0], j, out);
        if ((couples & FF_COUPLE_FRESNEL) && column->group == 0)
            for (size_t i = 0; i < n; i++) out[i] += plane[i] * b->d->d_part[at][FF_DD_FRESNEL][i] * j[i];
        if (couples & FF_COUPLE_ALBEDO) add_through_albedo(n, &p->albedo[c], 1 + p->wanted.n_shape + k, at, j, b, out);
        if (!(couples & FF_COUPLE_LOSS) || group != (uint32_t)column->group) continue;
        if (couples & FF_COUPLE_LOBE) {
            add_triple(n, b->scale[at], b->S[part->lobe], plane, b->d->d_part[at][FF_DD_LOBE], j, out);
            continue;
        }
        if (column->is_scale) {
            add_product(n, p->weight[part->lobe], b->part[at], j, out);
            continue;
        }
        const double *average = p->f_average + (c * p->m->n_lobes + (size_t)column->group) * (1 + FF_FRESNEL_PARAMS);
        add_product(n, b->scale[at] * average[1 + column->param], b->d->d_part[at][FF_DD_F_AVERAGE], j, out);
    }
}

void ff_compose_columns(const ff_prepared *p, size_t n, size_t c, const double *restrict j, ff_block *b,
                        double (*restrict df)[FF_BLOCK])
{
    const ff_wanted *w = &p->wanted;
    for (uint32_t k = 0; k < w->n_shape; k++) {
        const uint32_t lobe = p->shape[k].lobe < 0 ? 0 : (uint32_t)p->shape[k].lobe;
        if (b->d->shape[k])
            product(n, b->d->shape[k], b->F[ff_model_group(p->m, lobe)], j, df[k]);
        else
            memset(df[k], 0, n * sizeof **df);
        if (p->n_parts) add_base_shape(p, n, c, k, j, b, df[k]);
    }
    df += w->n_shape;
    for (uint32_t k = 0; k < w->n_channel; k++) {
        if (p->column[k].group >= 0)
            product(n, b->group[p->column[k].group], b->d->dF[w->channel[k]], j, df[k]);
        else
            memset(df[k], 0, n * sizeof **df);
        if (p->n_parts) add_base_channel(p, n, c, k, j, b, df[k]);
    }
}
