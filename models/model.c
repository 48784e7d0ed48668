/* Composition of terms into a model: the expression language, parameter names and boxes, claims. */
#include "models/kernels/internal_kernel.h"
#include "base/internal_number.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- composition ----------------------------------------------------------------------------- */

/* The parameters that lobes have from being lobes. */
static const ff_param alpha_param = {"alpha", "1", "roughness, the same in every direction", 1e-4, 4, 0.3, FF_PARAM_LOG, 0};
static const ff_param scale_param = {
    "ks", "1", "scale of the lobe", 0, 1e15, 1, FF_PARAM_PER_CHANNEL | FF_PARAM_LINEAR | FF_PARAM_HELD, 0};
static const ff_param weight_param = {"weight", "1", "share of the lobe among those with the same Fresnel term", 0, 1, 0.5, 0, 0};

/* prefix: "lobe2", NULL for none. */
static ff_status add_param(ff_model *m, const ff_param *info, uint32_t lobe, const char *prefix, ff_error *err)
{
    const int per_channel = (info->flags & FF_PARAM_PER_CHANNEL) != 0;
    if (per_channel ? m->n_channel == FF_MAX_CHANNEL_PARAMS : m->n_shape == FF_MAX_SHAPE)
        return ff_error_set(err, FF_ERR_UNSUPPORTED, NULL, 0, -1, "the model has too many parameters");
    ff_model_param *p = per_channel ? &m->channel[m->n_channel++] : &m->shape[m->n_shape++];
    *p = (ff_model_param){.info = info, .lobe = lobe, .init = info->init, .lo = info->lo, .hi = info->hi, .flags = info->flags};
    snprintf(p->name, sizeof p->name, "%.8s%s%.20s", prefix ? prefix : "", prefix ? "." : "", info->name);
    return FF_OK;
}

static ff_status add_params(ff_model *m, const ff_term *term, uint32_t from, uint32_t lobe, const char *prefix, ff_error *err)
{
    ff_status s = FF_OK;
    for (uint32_t i = from; i < term->n_params && !s; i++) s = add_param(m, &term->params[i], lobe, prefix, err);
    return s;
}

/* Does the distribution have the common stretch, so that one alpha may stand for alpha_x ... slope_y? */
static int is_stretched(const ff_ndf *ndf)
{
    return ndf->stretch == NULL;
}

static ff_status add_lobe(ff_model *m, uint32_t l, ff_error *err)
{
    ff_lobe *lobe = &m->lobe[l];
    const ff_ndf *ndf = ff_ndf_at(lobe->ndf);
    ff_status s = FF_OK;
    char number[16];
    snprintf(number, sizeof number, "lobe%u", l + 1);
    const char *prefix = l > 0 ? number : NULL;
    lobe->shape0 = m->n_shape;
    lobe->channel0 = m->n_channel;
    if (lobe->isotropic && is_stretched(ndf)) {
        s = add_param(m, &alpha_param, l, prefix, err);
        if (!s) s = add_params(m, &ndf->term, FF_STRETCH_COUNT, l, prefix, err);
    } else
        s = add_params(m, &ndf->term, 0, l, prefix, err);
    if (!s) s = add_params(m, &ff_masking_at(lobe->masking)->term, 0, l, prefix, err);
    if (!s && lobe->fresnel == FF_FRESNEL_SHARED) s = add_param(m, &weight_param, l, prefix, err);
    if (!s && lobe->fresnel != FF_FRESNEL_SHARED) {
        s = add_params(m, &ff_fresnel_at(lobe->fresnel)->term, 0, l, prefix, err);
        if (!s) s = add_param(m, &scale_param, l, prefix, err);
    }
    lobe->n_shape = m->n_shape - lobe->shape0;
    lobe->n_channel = m->n_channel - lobe->channel0;
    return s;
}

static ff_status add_base(ff_model *m, uint32_t b, ff_error *err)
{
    ff_base *base = &m->base[b];
    base->shape0 = m->n_shape;
    base->channel0 = m->n_channel;
    const ff_term *term = &ff_diffuse_at(base->diffuse)->term;
    int taken = 0; /* a name that the first base has: the second one's say whose they are */
    for (uint32_t i = 0; i < term->n_params; i++) taken |= ff_model_param_find(m, term->params[i].name) != FF_PARAM_NONE;
    const ff_status s = add_params(m, term, 0, m->n_lobes + b, taken ? "base2" : NULL, err);
    base->n_shape = m->n_shape - base->shape0;
    base->n_channel = m->n_channel - base->channel0;
    return s;
}

/* Names of the maskings that need no Lambda, for the message below. */
static void list_lambda_free(char *text, size_t size)
{
    for (size_t i = 0; i < ff_term_count(FF_MASKING); i++) {
        const ff_masking *k = ff_masking_at((int)i);
        const size_t used = strlen(text);
        if (!k->uses_lambda && !k->only) snprintf(text + used, size - used, "%s%s", used ? ", " : "", k->term.name);
    }
}

/* Do the terms of a lobe go together? */
static ff_status check_lobe(const ff_lobe *lobe, ff_error *err)
{
    const ff_ndf *ndf = ff_ndf_at(lobe->ndf);
    const ff_masking *masking = ff_masking_at(lobe->masking);
    if (masking->only && strcmp(masking->only, ndf->term.name) != 0)
        return ff_error_set(err, FF_ERR_UNSUPPORTED, NULL, 0, -1, "the masking %s is made for %s, not for %s", masking->term.name,
                            masking->only, ndf->term.name);
    if (masking->uses_lambda && !ndf->lambda) {
        char names[200] = "";
        list_lambda_free(names, sizeof names);
        return ff_error_set(err, FF_ERR_UNSUPPORTED, NULL, 0, -1,
                            "%s is no distribution over a unit area, so that %s has no meaning for it; allowed are %s",
                            ndf->term.name, masking->term.name, names);
    }
    return FF_OK;
}

/* Does a base have what it is coupled to? */
static ff_status check_base(const ff_model *m, const ff_diffuse *base, ff_error *err)
{
    if (base->couples && m->n_lobes == 0)
        return ff_error_set(err, FF_ERR_UNSUPPORTED, NULL, 0, -1, "%s is coupled to the lobes above it: the model needs one",
                            base->term.name);
    if ((base->couples & FF_COUPLE_ALPHA) && ff_ndf_at(m->lobe[0].ndf)->alpha_own < 0)
        return ff_error_set(err, FF_ERR_UNSUPPORTED, NULL, 0, -1, "%s reads the roughness alpha of the first lobe, and %s has none",
                            base->term.name, ff_ndf_at(m->lobe[0].ndf)->term.name);
    return FF_OK;
}

/* Checks that the terms go together and lists the parameters of lobes and bases in their order; indices are valid. */
static ff_status finish(ff_model *m, ff_error *err)
{
    ff_status s = FF_OK;
    int isotropic = 0;
    m->n_shape = m->n_channel = 0;
    for (uint32_t b = 0; b < m->n_bases && !s; b++) {
        const ff_diffuse *base = ff_diffuse_at(m->base[b].diffuse);
        isotropic |= (base->couples & ~(uint32_t)FF_COUPLE_F0) != 0;
        s = check_base(m, base, err);
    }
    for (uint32_t l = 0; l < m->n_lobes && !s; l++) {
        ff_lobe *lobe = &m->lobe[l];
        lobe->isotropic = lobe->isotropic || isotropic || (ff_ndf_at(lobe->ndf)->term.claims & FF_ISOTROPIC) ||
                          (ff_masking_at(lobe->masking)->term.claims & FF_ISOTROPIC);
        s = check_lobe(lobe, err);
        if (!s) s = add_lobe(m, l, err);
    }
    for (uint32_t b = 0; b < m->n_bases && !s; b++) s = add_base(m, b, err);
    return s;
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
    ff_model m = {.n_lobes = 1, .n_bases = diffuse >= 0};
    m.lobe[0] = (ff_lobe){.ndf = ndf, .masking = masking, .fresnel = fresnel};
    m.base[0].diffuse = diffuse;
    const ff_status s = finish(&m, err);
    if (!s) *out = m;
    return s;
}

void ff_model_lobe_alone(const ff_model *m, uint32_t l, size_t n_channels, const double *shape, const double *channel,
                         ff_model *out, double *out_shape, double *out_channel)
{
    const ff_lobe *lobe = &m->lobe[l], *group = &m->lobe[ff_model_group(m, l)];
    ff_model alone = {.n_lobes = 1};
    alone.lobe[0] = *lobe;
    alone.lobe[0].fresnel = group->fresnel;
    (void)finish(&alone, NULL); /* its terms went together before */
    *out = alone;
    memcpy(out_shape, shape + lobe->shape0, alone.n_shape * sizeof *shape);
    for (size_t c = 0; c < n_channels; c++)
        memcpy(out_channel + c * alone.n_channel, channel + c * m->n_channel + group->channel0, alone.n_channel * sizeof *channel);
}

/* Reads the decimal number that stands from text to `end`. */
static ff_status read_number(const char *text, const char *end, double *out, ff_error *err)
{
    const size_t length = (size_t)(end - text);
    if (ff_number_read(text, out) == end) return FF_OK; /* what is too large is outside every box */
    return ff_error_set(err, FF_ERR_SYNTAX, NULL, 0, -1, "'%.*s' is not a number", (int)(length < 60 ? length : 60), text);
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
    char names[500] = "";
    list_names(kind, names, sizeof names);
    if (kind != FF_NDF)
        return ff_error_set(err, FF_ERR_UNKNOWN, NULL, 0, -1, "unknown %s '%s'; known are %s", ff_term_kind_name(kind), word,
                            names);
    char bases[300] = "";
    list_names(FF_DIFFUSE, bases, sizeof bases); /* a term may be either */
    return ff_error_set(err, FF_ERR_UNKNOWN, NULL, 0, -1,
                        "unknown distribution or diffuse term '%s'; known are the distributions %s; the diffuse terms %s", word,
                        names, bases);
}

/* The Fresnel term of a later lobe that is the first one's. */
static const char shared_name[] = "shared";

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
        for (uint32_t b = 0; b < m->n_bases; b++)
            if (m->base[b].diffuse == diffuse)
                return ff_error_set(err, FF_ERR_UNSUPPORTED, NULL, 0, -1, "the term '%s' appears twice", part[0]);
        if (m->n_bases == FF_MAX_BASES)
            return ff_error_set(err, FF_ERR_UNSUPPORTED, NULL, 0, -1, "a model has at most %d diffuse terms", FF_MAX_BASES);
        m->base[m->n_bases++].diffuse = diffuse;
        return FF_OK;
    }
    if (m->n_lobes == FF_MAX_LOBES)
        return ff_error_set(err, FF_ERR_UNSUPPORTED, NULL, 0, -1, "a model has at most %d lobes", FF_MAX_LOBES);
    const char *word[3] = {part[0], parts > 1 ? part[1] : "smith-height-correlated", parts > 2 ? part[2] : "schlick"};
    int index[3];
    for (int kind = FF_NDF; kind <= FF_FRESNEL; kind++) {
        index[kind] = ff_term_find((ff_term_kind)kind, word[kind]);
        if (kind == FF_FRESNEL && strcmp(word[kind], shared_name) == 0) {
            if (m->n_lobes == 0)
                return ff_error_set(err, FF_ERR_UNSUPPORTED, NULL, 0, -1,
                                    "the first lobe has a Fresnel term of its own; later ones may have '%s'", shared_name);
            index[kind] = FF_FRESNEL_SHARED;
        } else if (index[kind] < 0)
            return unknown((ff_term_kind)kind, word[kind], err);
    }
    m->lobe[m->n_lobes++] = (ff_lobe){.ndf = index[0], .masking = index[1], .fresnel = index[2]};
    return FF_OK;
}

static ff_status parse_preset(const ff_preset *preset, ff_model *out, ff_error *err)
{
    ff_model m;
    ff_status s = ff_model_parse(preset->expression, &m, err);
    for (size_t i = 0; i < sizeof preset->hold / sizeof *preset->hold && preset->hold[i] && !s; i++) {
        char name[FF_PARAM_NAME];
        double value = 0;
        const char *equals = strchr(preset->hold[i], '=');
        snprintf(name, sizeof name, "%.*s", (int)(equals - preset->hold[i]), preset->hold[i]);
        s = read_number(equals + 1, equals + strlen(equals), &value, err);
        if (!s) s = ff_model_hold(&m, name, value, err);
    }
    if (!s) *out = m;
    return s;
}

ff_status ff_model_parse(const char *expr, ff_model *out, ff_error *err)
{
    char text[FF_MODEL_NAME];
    const ff_preset *preset = ff_preset_find(expr);
    if (preset) return parse_preset(preset, out, err);
    if (!*expr) return ff_error_set(err, FF_ERR_SYNTAX, NULL, 0, -1, "the model expression is empty");
    if (strlen(expr) >= sizeof text)
        return ff_error_set(err, FF_ERR_SYNTAX, NULL, 0, -1, "the model expression is longer than %d characters",
                            FF_MODEL_NAME - 1);
    memcpy(text, expr, strlen(expr) + 1);
    ff_model m = {.n_lobes = 0};
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
    for (uint32_t l = 0; l < m->n_lobes && used < size; l++) {
        const ff_lobe *lobe = &m->lobe[l];
        used += (size_t)snprintf(out + used, size - used, "%s%s/%s/%s", l ? "+" : "", ff_ndf_at(lobe->ndf)->term.name,
                                 ff_masking_at(lobe->masking)->term.name,
                                 lobe->fresnel == FF_FRESNEL_SHARED ? shared_name : ff_fresnel_at(lobe->fresnel)->term.name);
    }
    for (uint32_t b = 0; b < m->n_bases && used < size; b++)
        used += (size_t)snprintf(out + used, size - used, "%s%s", used ? "+" : "", ff_diffuse_at(m->base[b].diffuse)->term.name);
}

/* ---- parameters ------------------------------------------------------------------------------ */

void ff_model_defaults(const ff_model *m, size_t n_channels, double *shape, double *channel)
{
    if (shape)
        for (uint32_t k = 0; k < m->n_shape; k++) shape[k] = m->shape[k].init;
    if (channel)
        for (size_t c = 0; c < n_channels; c++)
            for (uint32_t k = 0; k < m->n_channel; k++) channel[c * m->n_channel + k] = m->channel[k].init;
}

uint32_t ff_model_set_table(ff_model *m, const struct ff_profile_table *table)
{
    uint32_t count = 0;
    for (uint32_t l = 0; l < m->n_lobes; l++)
        if (ff_ndf_at(m->lobe[l].ndf)->needs_values) {
            m->lobe[l].table = table;
            count++;
        }
    return count;
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

ff_status ff_model_unknown_param(const ff_model *m, const char *name, ff_error *err)
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

int ff_model_alpha_axes(const ff_model *m, const char *name, char x[FF_PARAM_NAME], char y[FF_PARAM_NAME])
{
    if (strlen(name) >= FF_PARAM_NAME - 2 || ff_model_param_find(m, name) != FF_PARAM_NONE) return 0;
    return alpha_axis(name, 'x', x, FF_PARAM_NAME) && alpha_axis(name, 'y', y, FF_PARAM_NAME) &&
           ff_model_param_find(m, x) != FF_PARAM_NONE;
}

static ff_status hold_one(ff_model *m, const char *name, int held, double value, ff_error *err)
{
    const int k = ff_model_param_find(m, name);
    if (k == FF_PARAM_NONE) return ff_model_unknown_param(m, name, err);
    ff_model_param *p = k >= 0 ? &m->shape[k] : &m->channel[-1 - k];
    if (held && !inside(p->info, value)) return out_of_box(p, value, err);
    if (held) p->init = value;
    p->flags = held ? p->flags | FF_PARAM_HELD : p->flags & ~(uint32_t)FF_PARAM_HELD;
    return FF_OK;
}

/* A name, or where the model has none of that name "alpha" for the two axes. */
static ff_status hold(ff_model *m, const char *name, int held, double value, ff_error *err)
{
    char x[FF_PARAM_NAME], y[FF_PARAM_NAME];
    if (!ff_model_alpha_axes(m, name, x, y)) return hold_one(m, name, held, value, err);
    const ff_status s = hold_one(m, x, held, value, err);
    return s ? s : hold_one(m, y, held, value, err);
}

ff_status ff_model_hold(ff_model *m, const char *name, double value, ff_error *err)
{
    return hold(m, name, 1, value, err);
}

ff_status ff_model_free(ff_model *m, const char *name, ff_error *err)
{
    return hold(m, name, 0, 0, err);
}

static ff_status bound_one(ff_model *m, const char *name, double lo, double hi, ff_error *err)
{
    const int k = ff_model_param_find(m, name);
    if (k == FF_PARAM_NONE) return ff_model_unknown_param(m, name, err);
    ff_model_param *p = k >= 0 ? &m->shape[k] : &m->channel[-1 - k];
    if (!(lo < hi))
        return ff_error_set(err, FF_ERR_RANGE, NULL, 0, -1, "the bounds of %s must rise, found %g and %g", p->name, lo, hi);
    if (!inside(p->info, lo) || !inside(p->info, hi))
        return ff_error_set(err, FF_ERR_RANGE, NULL, 0, -1, "the bounds of %s, %g and %g, must lie inside [%g, %g]", p->name, lo,
                            hi, p->info->lo, p->info->hi);
    const double start = fmin(fmax(p->init, lo), hi);
    if ((p->flags & FF_PARAM_HELD) && start != p->init)
        return ff_error_set(err, FF_ERR_RANGE, NULL, 0, -1, "%s is held at %g, outside its bounds [%g, %g]", p->name, p->init, lo,
                            hi);
    p->init = start;
    p->lo = lo;
    p->hi = hi;
    return FF_OK;
}

ff_status ff_model_bound(ff_model *m, const char *name, double lo, double hi, ff_error *err)
{
    char x[FF_PARAM_NAME], y[FF_PARAM_NAME];
    if (!ff_model_alpha_axes(m, name, x, y)) return bound_one(m, name, lo, hi, err);
    ff_model both = *m; /* both axes or, when one is refused, neither */
    ff_status s = bound_one(&both, x, lo, hi, err);
    if (!s) s = bound_one(&both, y, lo, hi, err);
    if (!s) *m = both;
    return s;
}

static ff_status set_one(const ff_model *m, size_t n_channels, const char *name, const double *values, size_t n_values,
                         double *shape, double *channel, ff_error *err)
{
    const int k = ff_model_param_find(m, name);
    if (k == FF_PARAM_NONE) return ff_model_unknown_param(m, name, err);
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
    if (ff_model_param_find(m, name) != FF_PARAM_NONE || !alpha_axis(name, 'x', axis, sizeof axis))
        return set_one(m, n_channels, name, values, n_values, shape, channel, err);
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
        ff_lobe_pass pass;
        ff_model_lobe(m, l, shape, &pass, NULL);
        const ff_term *masking = &ff_masking_at(m->lobe[l].masking)->term;
        if ((masking->claims & FF_NEEDS_CENTRED) && (pass.s.x0 != 0 || pass.s.y0 != 0))
            return ff_error_set(err, FF_ERR_UNSUPPORTED, NULL, 0, -1,
                                "%s is undefined with a mean slope (found %g, %g); use a Smith form or slope_x = slope_y = 0",
                                masking->name, pass.s.x0, pass.s.y0);
        if (ff_ndf_at(m->lobe[l].ndf)->needs_values && !m->lobe[l].table)
            return ff_error_set(err, FF_ERR_UNSUPPORTED, NULL, 0, -1, "%s needs the table of its profile",
                                ff_ndf_at(m->lobe[l].ndf)->term.name);
    }
    return FF_OK;
}

void ff_model_lobe(const ff_model *m, uint32_t l, const double *shape, ff_lobe_pass *pass, double jac[][FF_D_COUNT])
{
    const ff_lobe *lobe = &m->lobe[l];
    const ff_ndf *ndf = ff_ndf_at(lobe->ndf);
    const double *p = shape + lobe->shape0;
    ff_stretch *s = &pass->s;
    uint32_t k = ndf->term.n_params; /* the masking's parameter follows those of the distribution */
    *pass = (ff_lobe_pass){.ndf = lobe->ndf, .masking = lobe->masking};
    pass->ndf_pass.values = lobe->table;
    if (jac) memset(jac, 0, lobe->n_shape * sizeof *jac);
    if (!is_stretched(ndf)) {
        ndf->stretch(p, s, jac);
    } else if (lobe->isotropic) {
        s->ax = s->ay = p[0];
        k -= FF_STRETCH_COUNT - 1;
        if (jac) jac[0][FF_D_AX] = jac[0][FF_D_AY] = 1;
        for (uint32_t i = 1; i < k; i++) {
            s->own[i - 1] = p[i];
            if (jac) jac[i][FF_D_OWN + i - 1] = 1;
        }
    } else {
        *s = (ff_stretch){.ax = p[0], .ay = p[1], .r = p[2], .x0 = p[3], .y0 = p[4]};
        for (uint32_t i = FF_STRETCH_COUNT; i < k; i++) s->own[i - FF_STRETCH_COUNT] = p[i];
        if (jac)
            for (uint32_t i = 0; i < k; i++) jac[i][i] = 1; /* own parameters follow the stretch in FF_D_... too */
    }
    if (ff_masking_at(lobe->masking)->term.n_params) {
        pass->masking_own = p[k];
        if (jac) jac[k][FF_D_MASKING] = 1;
    }
}

uint32_t ff_model_group(const ff_model *m, uint32_t l)
{
    return m->lobe[l].fresnel == FF_FRESNEL_SHARED ? 0 : l;
}

void ff_model_weights(const ff_model *m, const double *shape, double *weight, double dw[][FF_MAX_LOBES])
{
    double w[FF_MAX_LOBES]; /* own shares */
    for (uint32_t l = 0; l < m->n_lobes; l++) {
        const ff_lobe *lobe = &m->lobe[l];
        w[l] = lobe->fresnel == FF_FRESNEL_SHARED ? shape[lobe->shape0 + lobe->n_shape - 1] : 0;
    }
    for (uint32_t l = 0; l < m->n_lobes; l++) {
        const int shares = m->lobe[l].fresnel == FF_FRESNEL_SHARED;
        weight[l] = shares ? w[l] : 1;
        for (uint32_t k = 0; dw && k < m->n_lobes; k++) dw[k][l] = shares && k == l ? 1 : 0;
        if (l > 0 && !shares) continue;
        for (uint32_t later = l + 1; later < m->n_lobes; later++) { /* each later one takes its share of what is there */
            if (m->lobe[later].fresnel != FF_FRESNEL_SHARED) continue;
            for (uint32_t k = 0; dw && k < m->n_lobes; k++) dw[k][l] = dw[k][l] * (1 - w[later]) - (k == later ? weight[l] : 0);
            weight[l] *= 1 - w[later];
        }
    }
}

uint32_t ff_model_claims(const ff_model *m, const double *shape)
{
    uint32_t claims = FF_RECIPROCAL | FF_ISOTROPIC | (m->n_lobes + m->n_bases <= 1 ? FF_PASSIVE : 0u);
    for (uint32_t l = 0; l < m->n_lobes; l++) {
        const ff_lobe *lobe = &m->lobe[l];
        const uint32_t masking = ff_masking_at(lobe->masking)->term.claims,
                       fresnel = ff_fresnel_at(m->lobe[ff_model_group(m, l)].fresnel)->term.claims;
        ff_lobe_pass pass;
        ff_model_lobe(m, l, shape, &pass, NULL);
        const ff_stretch *s = &pass.s;
        const int tilted = s->x0 != 0 || s->y0 != 0;
        uint32_t c = ff_ndf_at(lobe->ndf)->term.claims & masking & fresnel & (FF_RECIPROCAL | FF_PASSIVE);
        if (tilted) c &= ~(uint32_t)(FF_RECIPROCAL | FF_PASSIVE);
        if (s->ax == s->ay && s->r == 0 && !tilted) c |= FF_ISOTROPIC;
        claims &= c;
    }
    for (uint32_t b = 0; b < m->n_bases; b++) claims &= ff_diffuse_at(m->base[b].diffuse)->term.claims;
    return claims;
}

/* ---- passes ---------------------------------------------------------------------------------- */

uint32_t ff_model_planes(const ff_model *m, ff_stretch_mode mode)
{
    const uint32_t isotropic = 1u << FF_G_S2 | 1u << FF_G_TI2 | 1u << FF_G_TO2;
    const uint32_t vectors = 1u << FF_G_SX | 1u << FF_G_SY | 1u << FF_G_TIX | 1u << FF_G_TIY | 1u << FF_G_TOX | 1u << FF_G_TOY;
    uint32_t planes = 0;
    for (uint32_t l = 0; l < m->n_lobes; l++)
        planes |= 1u << FF_G_K | (m->lobe[l].isotropic || mode == FF_ISOTROPIC_MODE ? isotropic : vectors) |
                  ff_masking_at(m->lobe[l].masking)->planes | ff_fresnel_at(m->lobe[ff_model_group(m, l)].fresnel)->planes;
    for (uint32_t b = 0; b < m->n_bases; b++) {
        const ff_diffuse *base = ff_diffuse_at(m->base[b].diffuse);
        planes |= base->planes;
        if (base->couples & (FF_COUPLE_ALBEDO | FF_COUPLE_LOSS)) planes |= 1u << FF_G_COS_I | 1u << FF_G_COS_O;
    }
    return planes;
}
