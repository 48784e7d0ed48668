/* Composition of terms into a model: the expression language, parameter names and boxes, claims. */
#define _GNU_SOURCE /* strtod_l, newlocale */
#include "internal_kernel.h"
#include <locale.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- composition ----------------------------------------------------------------------------- */

static void name_param(ff_model_param *p, const ff_param *info, uint32_t lobe, int prefixed)
{
    p->info = info;
    p->lobe = lobe;
    if (prefixed)
        snprintf(p->name, sizeof p->name, "lobe%u.%.20s", lobe + 1, info->name);
    else
        snprintf(p->name, sizeof p->name, "%.31s", info->name);
}

static ff_status add_params(ff_model *m, const ff_term *term, uint32_t lobe, int prefixed, ff_error *err)
{
    for (uint32_t i = 0; i < term->n_params; i++) {
        const ff_param *info = &term->params[i];
        if (info->flags & FF_PARAM_PER_CHANNEL) {
            if (m->n_channel == FF_MAX_CHANNEL_PARAMS)
                return ff_error_set(err, FF_ERR_UNSUPPORTED, NULL, 0, -1, "the model has too many parameters");
            name_param(&m->channel[m->n_channel++], info, lobe, prefixed);
        } else {
            if (m->n_shape == FF_MAX_SHAPE)
                return ff_error_set(err, FF_ERR_UNSUPPORTED, NULL, 0, -1, "the model has too many parameters");
            name_param(&m->shape[m->n_shape++], info, lobe, prefixed);
        }
    }
    return FF_OK;
}

/* Parameters of lobes and diffuse term in their order; indices are valid. */
static ff_status finish(ff_model *m, ff_error *err)
{
    m->n_shape = m->n_channel = 0;
    for (uint32_t l = 0; l < m->n_lobes; l++) {
        ff_lobe *lobe = &m->lobe[l];
        lobe->shape0 = m->n_shape;
        lobe->channel0 = m->n_channel;
        ff_status s = add_params(m, &ff_ndf_at(lobe->ndf)->term, l, l > 0, err);
        if (!s) s = add_params(m, &ff_masking_at(lobe->masking)->term, l, l > 0, err);
        if (!s) s = add_params(m, &ff_fresnel_at(lobe->fresnel)->term, l, l > 0, err);
        if (s) return s;
        lobe->n_shape = m->n_shape - lobe->shape0;
        lobe->n_channel = m->n_channel - lobe->channel0;
    }
    return m->diffuse >= 0 ? add_params(m, &ff_diffuse_at(m->diffuse)->term, m->n_lobes, 0, err) : FF_OK;
}

ff_status ff_model_compose(int ndf, int masking, int fresnel, int diffuse, ff_model *out, ff_error *err)
{
    const int index[FF_TERM_KINDS] = {ndf, masking, fresnel, diffuse};
    for (int kind = 0; kind < FF_TERM_KINDS; kind++) {
        const int lowest = kind == FF_DIFFUSE ? -1 : 0;
        if (index[kind] < lowest || index[kind] >= (int)ff_term_count((ff_term_kind)kind))
            return ff_error_set(err, FF_ERR_RANGE, NULL, 0, -1, "%s number %d does not exist",
                                ff_term_kind_name((ff_term_kind)kind), index[kind]);
    }
    ff_model m = {.n_lobes = 1, .diffuse = diffuse};
    m.lobe[0] = (ff_lobe){.ndf = ndf, .masking = masking, .fresnel = fresnel};
    const ff_status s = finish(&m, err);
    if (!s) *out = m;
    return s;
}

/* Appends the names of a kind, comma separated, to text [size]. */
static void list_names(ff_term_kind kind, char *text, size_t size)
{
    for (size_t i = 0; i < ff_term_count(kind); i++) {
        const size_t used = strlen(text);
        snprintf(text + used, size - used, "%s%s", used ? ", " : "", ff_term_at(kind, i)->name);
    }
}

static ff_status unknown(ff_term_kind kind, const char *word, ff_error *err)
{
    char names[400] = "";
    list_names(kind, names, sizeof names);
    if (kind == FF_NDF) list_names(FF_DIFFUSE, names, sizeof names); /* a term may be either */
    return ff_error_set(err, FF_ERR_UNKNOWN, NULL, 0, -1, "unknown %s '%s'; known are %s",
                        kind == FF_NDF ? "distribution or diffuse term" : ff_term_kind_name(kind), word, names);
}

/* One term of an expression, "ggx/v-cavity/schlick" or "lambert", cut apart in place. */
static ff_status parse_term(char *term, ff_model *m, ff_error *err)
{
    char *part[4] = {term, NULL, NULL, NULL};
    int parts = 1;
    for (char *slash = strchr(term, '/'); slash; slash = strchr(slash, '/')) {
        *slash++ = 0;
        if (parts == 3)
            return ff_error_set(err, FF_ERR_SYNTAX, NULL, 0, -1, "a lobe is NDF[/MASKING[/FRESNEL]]; found a third '/' before '%s'",
                                slash);
        part[parts++] = slash;
    }
    for (int k = 0; k < parts; k++)
        if (!*part[k]) return ff_error_set(err, FF_ERR_SYNTAX, NULL, 0, -1, "an empty name in the model expression");
    const int diffuse = ff_term_find(FF_DIFFUSE, part[0]);
    if (diffuse >= 0) {
        if (parts > 1)
            return ff_error_set(err, FF_ERR_SYNTAX, NULL, 0, -1, "the diffuse term '%s' takes no masking or Fresnel term", part[0]);
        if (m->diffuse >= 0) return ff_error_set(err, FF_ERR_UNSUPPORTED, NULL, 0, -1, "a model has at most one diffuse term");
        m->diffuse = diffuse;
        return FF_OK;
    }
    if (m->n_lobes == FF_MAX_LOBES)
        return ff_error_set(err, FF_ERR_UNSUPPORTED, NULL, 0, -1, "a model has at most %d lobes", FF_MAX_LOBES);
    const char *word[3] = {part[0], parts > 1 ? part[1] : "smith-height-correlated", parts > 2 ? part[2] : "schlick"};
    int index[3];
    for (int kind = FF_NDF; kind <= FF_FRESNEL; kind++) {
        index[kind] = ff_term_find((ff_term_kind)kind, word[kind]);
        if (index[kind] < 0) return unknown((ff_term_kind)kind, word[kind], err);
    }
    m->lobe[m->n_lobes++] = (ff_lobe){.ndf = index[0], .masking = index[1], .fresnel = index[2]};
    return FF_OK;
}

ff_status ff_model_parse(const char *expr, ff_model *out, ff_error *err)
{
    char text[FF_MODEL_NAME];
    if (!*expr) return ff_error_set(err, FF_ERR_SYNTAX, NULL, 0, -1, "the model expression is empty");
    if (strlen(expr) >= sizeof text)
        return ff_error_set(err, FF_ERR_SYNTAX, NULL, 0, -1, "the model expression is longer than %d characters",
                            FF_MODEL_NAME - 1);
    memcpy(text, expr, strlen(expr) + 1);
    ff_model m = {.diffuse = -1};
    for (char *term = text, *next; term; term = next) {
        next = strchr(term, '+');
        if (next) *next++ = 0;
        const ff_status s = parse_term(term, &m, err);
        if (s) return s;
    }
    const ff_status s = finish(&m, err);
    if (!s) *out = m;
    return s;
}

void ff_model_expression(const ff_model *m, char *out, size_t size)
{
    size_t used = 0;
    if (size) out[0] = 0;
    for (uint32_t l = 0; l < m->n_lobes && used < size; l++)
        used += (size_t)snprintf(out + used, size - used, "%s%s/%s/%s", l ? "+" : "", ff_ndf_at(m->lobe[l].ndf)->term.name,
                                 ff_masking_at(m->lobe[l].masking)->term.name, ff_fresnel_at(m->lobe[l].fresnel)->term.name);
    if (m->diffuse >= 0 && used < size)
        snprintf(out + used, size - used, "%s%s", used ? "+" : "", ff_diffuse_at(m->diffuse)->term.name);
}

/* ---- parameters ------------------------------------------------------------------------------ */

void ff_model_defaults(const ff_model *m, size_t n_channels, double *shape, double *channel)
{
    if (shape)
        for (uint32_t k = 0; k < m->n_shape; k++) shape[k] = m->shape[k].info->init;
    if (channel)
        for (size_t c = 0; c < n_channels; c++)
            for (uint32_t k = 0; k < m->n_channel; k++) channel[c * m->n_channel + k] = m->channel[k].info->init;
}

int ff_model_param_find(const ff_model *m, const char *name)
{
    for (uint32_t k = 0; k < m->n_shape; k++)
        if (strcmp(m->shape[k].name, name) == 0) return (int)k;
    for (uint32_t k = 0; k < m->n_channel; k++)
        if (strcmp(m->channel[k].name, name) == 0) return -1 - (int)k;
    return FF_PARAM_NONE;
}

static ff_status out_of_box(const ff_model_param *p, double value, ff_error *err)
{
    return ff_error_set(err, FF_ERR_RANGE, NULL, 0, -1, "%s = %g lies outside [%g, %g]", p->name, value, p->info->lo, p->info->hi);
}

static int inside(const ff_param *p, double v)
{
    return v >= p->lo && v <= p->hi; /* false for NaN */
}

/* Reads one number of the C locale up to `end`. */
static ff_status read_number(const char *text, const char *end, double *out, ff_error *err)
{
    char buffer[64];
    const size_t length = (size_t)(end - text);
    if (length && length < sizeof buffer) {
        memcpy(buffer, text, length);
        buffer[length] = 0;
        char *stop = NULL;
        locale_t c = newlocale(LC_ALL_MASK, "C", (locale_t)0);
        const double value = c ? strtod_l(buffer, &stop, c) : strtod(buffer, &stop);
        if (c) freelocale(c);
        if (stop == buffer + length && buffer[0] != ' ') {
            *out = value;
            return FF_OK;
        }
    }
    return ff_error_set(err, FF_ERR_SYNTAX, NULL, 0, -1, "'%.*s' is not a number", (int)(length < 60 ? length : 60), text);
}

static ff_status unknown_param(const ff_model *m, const char *name, ff_error *err)
{
    char known[500] = "";
    for (uint32_t k = 0; k < m->n_shape + m->n_channel; k++) {
        const size_t used = strlen(known);
        snprintf(known + used, sizeof known - used, "%s%s", used ? ", " : "",
                 k < m->n_shape ? m->shape[k].name : m->channel[k - m->n_shape].name);
    }
    return ff_error_set(err, FF_ERR_UNKNOWN, NULL, 0, -1, "the model has no parameter '%s'; it has %s", name,
                        known[0] ? known : "none");
}

/* "alpha" or "lobe2.alpha" stands for alpha_x and alpha_y: writes the name of that axis. 0 when name is not such a word. */
static int alpha_axis(const char *name, char axis, char *out, size_t size)
{
    const size_t length = strlen(name);
    if (length < 5 || strcmp(name + length - 5, "alpha") != 0 || (length > 5 && name[length - 6] != '.')) return 0;
    snprintf(out, size, "%s_%c", name, axis);
    return 1;
}

static ff_status set_one(const ff_model *m, size_t n_channels, const char *name, const double *values, size_t n_values,
                         double *shape, double *channel, ff_error *err)
{
    const int k = ff_model_param_find(m, name);
    if (k == FF_PARAM_NONE) return unknown_param(m, name, err);
    const ff_model_param *p = k >= 0 ? &m->shape[k] : &m->channel[-1 - k];
    if (k >= 0 && n_values != 1)
        return ff_error_set(err, FF_ERR_SYNTAX, NULL, 0, -1, "%s takes one value, found %zu", name, n_values);
    if (k < 0 && n_values != 1 && n_values != n_channels)
        return ff_error_set(err, FF_ERR_SYNTAX, NULL, 0, -1, "%s takes one value or one per channel (%zu), found %zu", name,
                            n_channels, n_values);
    for (size_t i = 0; i < n_values; i++)
        if (!inside(p->info, values[i])) return out_of_box(p, values[i], err);
    if (k >= 0)
        shape[k] = values[0];
    else
        for (size_t c = 0; c < n_channels; c++) channel[c * m->n_channel + (size_t)(-1 - k)] = values[n_values == 1 ? 0 : c];
    return FF_OK;
}

ff_status ff_model_set(const ff_model *m, size_t n_channels, const char *assignment, double *shape, double *channel, ff_error *err)
{
    enum { MAX_VALUES = 256 };
    double values[MAX_VALUES];
    size_t n_values = 0;
    char name[FF_PARAM_NAME * 2], axis[FF_PARAM_NAME * 2 + 2];
    const char *equals = strchr(assignment, '=');
    if (!equals || equals == assignment || (size_t)(equals - assignment) >= sizeof name)
        return ff_error_set(err, FF_ERR_SYNTAX, NULL, 0, -1, "expected NAME=VALUE, found '%.80s'", assignment);
    memcpy(name, assignment, (size_t)(equals - assignment));
    name[equals - assignment] = 0;
    for (const char *text = equals + 1; text;) {
        const char *colon = strchr(text, ':'), *end = colon ? colon : text + strlen(text);
        if (n_values == MAX_VALUES)
            return ff_error_set(err, FF_ERR_SYNTAX, NULL, 0, -1, "%s has more than %d values", name, MAX_VALUES);
        const ff_status s = read_number(text, end, &values[n_values++], err);
        if (s) return s;
        text = colon ? colon + 1 : NULL;
    }
    if (!alpha_axis(name, 'x', axis, sizeof axis)) return set_one(m, n_channels, name, values, n_values, shape, channel, err);
    /* both axes or, when one is refused, neither: they have the same box and the same number of values */
    ff_status s = set_one(m, n_channels, axis, values, n_values, shape, channel, err);
    if (!s && alpha_axis(name, 'y', axis, sizeof axis)) s = set_one(m, n_channels, axis, values, n_values, shape, channel, err);
    return s;
}

ff_status ff_model_check(const ff_model *m, size_t n_channels, const double *shape, const double *channel, ff_error *err)
{
    for (uint32_t k = 0; k < m->n_shape; k++)
        if (!inside(m->shape[k].info, shape[k])) return out_of_box(&m->shape[k], shape[k], err);
    for (size_t i = 0; i < n_channels * m->n_channel; i++) {
        const ff_model_param *p = &m->channel[i % m->n_channel];
        if (!inside(p->info, channel[i])) return out_of_box(p, channel[i], err);
    }
    for (uint32_t l = 0; l < m->n_lobes; l++) {
        ff_stretch s;
        ff_model_stretch(m, l, shape, &s, NULL);
        const ff_term *masking = &ff_masking_at(m->lobe[l].masking)->term;
        if ((masking->claims & FF_NEEDS_CENTRED) && (s.x0 != 0 || s.y0 != 0))
            return ff_error_set(err, FF_ERR_UNSUPPORTED, NULL, 0, -1,
                                "%s is undefined with a mean slope (found %g, %g); use a Smith form or slope_x = slope_y = 0",
                                masking->name, s.x0, s.y0);
    }
    return FF_OK;
}

void ff_model_stretch(const ff_model *m, uint32_t l, const double *shape, ff_stretch *s, double jac[][FF_D_COUNT])
{
    const ff_ndf *ndf = ff_ndf_at(m->lobe[l].ndf);
    const double *p = shape + m->lobe[l].shape0;
    if (ndf->stretch) {
        ndf->stretch(p, s, jac);
        return;
    }
    *s = (ff_stretch){.ax = p[0], .ay = p[1], .r = p[2], .x0 = p[3], .y0 = p[4], .own = ndf->has_own ? p[5] : 0};
    if (jac)
        for (uint32_t k = 0; k < ndf->term.n_params; k++)
            for (uint32_t d = 0; d < FF_D_COUNT; d++) jac[k][d] = k == d;
}

uint32_t ff_model_claims(const ff_model *m, const double *shape)
{
    uint32_t claims = FF_RECIPROCAL | FF_ISOTROPIC | (m->n_lobes + (m->diffuse >= 0) <= 1 ? FF_PASSIVE : 0u);
    for (uint32_t l = 0; l < m->n_lobes; l++) {
        const ff_lobe *lobe = &m->lobe[l];
        const uint32_t masking = ff_masking_at(lobe->masking)->term.claims, fresnel = ff_fresnel_at(lobe->fresnel)->term.claims;
        ff_stretch s;
        ff_model_stretch(m, l, shape, &s, NULL);
        const int tilted = s.x0 != 0 || s.y0 != 0;
        uint32_t c = ff_ndf_at(lobe->ndf)->term.claims & masking & fresnel & (FF_RECIPROCAL | FF_PASSIVE);
        if (tilted) c &= ~(uint32_t)(FF_RECIPROCAL | FF_PASSIVE);
        if (s.ax == s.ay && s.r == 0 && !tilted) c |= FF_ISOTROPIC;
        claims &= c;
    }
    if (m->diffuse >= 0) claims &= ff_diffuse_at(m->diffuse)->term.claims;
    return claims;
}

/* ---- passes ---------------------------------------------------------------------------------- */

void ff_lobe_pass_prepare(const ff_kernels *k, ff_lobe_pass *pass)
{
    const ff_ndf *ndf = k->ndf[pass->ndf];
    pass->ndf_pass.own = pass->s.own;
    if (ndf->prepare) ndf->prepare(&pass->ndf_pass);
}

uint32_t ff_model_planes(const ff_model *m, ff_stretch_mode mode)
{
    const uint32_t isotropic = 1u << FF_G_S2 | 1u << FF_G_TI2 | 1u << FF_G_TO2;
    const uint32_t vectors = 1u << FF_G_SX | 1u << FF_G_SY | 1u << FF_G_TIX | 1u << FF_G_TIY | 1u << FF_G_TOX | 1u << FF_G_TOY;
    uint32_t planes = 0;
    for (uint32_t l = 0; l < m->n_lobes; l++)
        planes |= 1u << FF_G_K | (mode == FF_ISOTROPIC_MODE ? isotropic : vectors) | ff_masking_at(m->lobe[l].masking)->planes |
                  ff_fresnel_at(m->lobe[l].fresnel)->planes;
    if (m->diffuse >= 0) planes |= ff_diffuse_at(m->diffuse)->planes;
    return planes;
}
