/* A fitted model as source code. */
#include "internal_snippet.h"
#include "base/internal_number.h"
#include "internal_snippet_terms.h"
#include "models/internal_model.h"
#include <stdlib.h>
#include <string.h>

/* ---- languages ------------------------------------------------------------------------------- */

typedef struct language {
    const char *name, *type, *function, *min, *max, *abs, *erf, *head;
} language;

/* Abramowitz and Stegun 7.1.26: to 1.5e-7. */
static const char own_erf[] =
    "float facetfit_erf(float x)\n{\n    float t = 1.0 / (1.0 + 0.3275911 * x);\n"
    "    return 1.0 - ((((1.061405429 * t - 1.453152027) * t + 1.421413741) * t - 0.284496736) * t + 0.254829592) * t * "
    "exp(-x * x);\n}\n\n";

static const language languages[] = {
    {"c", "double", "static inline double", "fmin", "fmax", "fabs", "erf", "#include <math.h>\n\n"},
    {"glsl", "float", "float", "min", "max", "abs", "facetfit_erf", own_erf},
    {"hlsl", "float", "float", "min", "max", "abs", "facetfit_erf", own_erf},
    {"osl", "float", "float", "min", "max", "abs", "erf", ""}};

size_t ff_snippet_count(void)
{
    return sizeof languages / sizeof *languages;
}

const char *ff_snippet_name(size_t i)
{
    return i < ff_snippet_count() ? languages[i].name : NULL;
}

int ff_snippet_find(const char *name)
{
    for (size_t i = 0; i < ff_snippet_count(); i++)
        if (!strcmp(languages[i].name, name)) return (int)i;
    return -1;
}

/* Writes code with the words of the language. */
static void put(const language *l, const char *code, FILE *out)
{
    const struct {
        const char *word, *as;
    } words[] = {{"$T", l->type}, {"$F", l->function}, {"$min", l->min}, {"$max", l->max}, {"$abs", l->abs}, {"$erf", l->erf}};
    while (*code) {
        size_t taken = 0;
        for (size_t k = 0; k < sizeof words / sizeof *words && !taken; k++) {
            const size_t n = strlen(words[k].word);
            if (strncmp(code, words[k].word, n) != 0) continue;
            fputs(words[k].as, out);
            taken = n;
        }
        if (!taken) fputc(*code, out);
        code += taken ? taken : 1;
    }
}

/* Always with a point or an exponent: GLSL takes 1 for an integer. */
static void put_number(double x, FILE *out)
{
    char text[FF_NUMBER_TEXT + 1];
    text[ff_number_write(x, text)] = '\0';
    fprintf(out, "%s%s", text, strpbrk(text, ".e") ? "" : ".0");
}

/* ---- terms ----------------------------------------------------------------------------------- */

static ff_status no_code(int kind, const char *what, const char *name, ff_error *err)
{
    char known[300];
    ff_snippet_known(kind, known, sizeof known);
    return ff_error_set(err, FF_ERR_UNSUPPORTED, NULL, 0, -1, "there is no code for the %s %s; there is for %s", what, name, known);
}

static const char *fresnel_name(const ff_model *m, uint32_t l)
{
    return ff_fresnel_at(m->lobe[ff_model_group(m, l)].fresnel)->term.name;
}

static ff_status check_lobe(const ff_model *m, uint32_t l, const double *shape, ff_error *err)
{
    const char *ndf = ff_ndf_at(m->lobe[l].ndf)->term.name, *masking = ff_masking_at(m->lobe[l].masking)->term.name;
    ff_lobe_pass pass;
    ff_model_lobe(m, l, shape, &pass, NULL);
    if (!ff_snippet_ndf(ndf)) return no_code(0, "distribution", ndf, err);
    if (!ff_snippet_masking(masking)) return no_code(1, "masking", masking, err);
    if (!ff_snippet_fresnel(fresnel_name(m, l))) return no_code(2, "Fresnel term", fresnel_name(m, l), err);
    if (pass.s.x0 != 0 || pass.s.y0 != 0)
        return ff_error_set(err, FF_ERR_UNSUPPORTED, NULL, 0, -1, "there is no code for a mean slope (found %g, %g)", pass.s.x0,
                            pass.s.y0);
    return FF_OK;
}

static ff_status check(const ff_model *m, const double *shape, ff_error *err)
{
    ff_status status = FF_OK;
    for (uint32_t l = 0; l < m->n_lobes && status == FF_OK; l++) status = check_lobe(m, l, shape, err);
    for (uint32_t b = 0; b < m->n_bases && status == FF_OK; b++) {
        const char *name = ff_diffuse_at(m->base[b].diffuse)->term.name;
        if (!ff_snippet_base(name)) status = no_code(3, "term under the lobes", name, err);
    }
    return status;
}

/* The code of each once, also where it is part of another one's. */
static void put_once(const language *l, const char *code, const char **done, size_t *n, FILE *out)
{
    for (size_t i = 0; i < *n; i++)
        if (done[i] == code) return;
    done[(*n)++] = code;
    put(l, code, out);
}

static void put_terms(const language *l, const ff_model *m, FILE *out)
{
    const char *done[3 * FF_MAX_LOBES + 1];
    size_t n = 0;
    int dielectric = 0;
    put(l, "$F facetfit_fifth($T x)\n{\n    return x * x * x * x * x;\n}\n\n", out);
    for (uint32_t k = 0; k < m->n_lobes; k++) {
        const char *fresnel = ff_snippet_fresnel(fresnel_name(m, k))->code, *part = ff_snippet_fresnel("dielectric")->code;
        const size_t shared = strlen(part);
        put_once(l, ff_snippet_ndf(ff_ndf_at(m->lobe[k].ndf)->term.name)->code, done, &n, out);
        if (strncmp(fresnel, part, shared) == 0) { /* cycles goes on from dielectric */
            if (!dielectric++) put(l, part, out);
            fresnel += shared;
        }
        put_once(l, fresnel, done, &n, out);
    }
}

/* ---- the sum --------------------------------------------------------------------------------- */

typedef struct source {
    const language *l;
    const ff_model *m;
    size_t n_channels;
    const double *shape, *channel;
    FILE *out;
} source;

static void put_constant(const source *s, const char *name, double x)
{
    fprintf(s->out, "        %s %s = ", s->l->type, name);
    put_number(x, s->out);
    fputs(";\n", s->out);
}

/* A per-channel parameter by the number of its channel. */
static void put_channel(const source *s, const char *name, uint32_t k)
{
    fprintf(s->out, "        %s %s = ", s->l->type, name);
    for (size_t c = 0; c + 1 < s->n_channels; c++) {
        fprintf(s->out, "channel == %zu ? ", c);
        put_number(s->channel[c * s->m->n_channel + k], s->out);
        fputs(" : ", s->out);
    }
    put_number(s->channel[(s->n_channels - 1) * s->m->n_channel + k], s->out);
    fputs(";\n", s->out);
}

/* "f0" of "lobe2.f0" */
static const char *bare(const ff_model_param *p)
{
    return p->info->name;
}

static void put_fresnel_params(const source *s, uint32_t l, int with_scale)
{
    const ff_lobe *lobe = &s->m->lobe[ff_model_group(s->m, l)];
    for (uint32_t k = lobe->channel0; k + !with_scale < lobe->channel0 + lobe->n_channel; k++)
        put_channel(s, bare(&s->m->channel[k]), k); /* the scale is the last */
}

/* Does a name stand by itself in code? */
static int has_word(const char *code, const char *word)
{
    static const char letters[] = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_";
    const size_t n = strlen(word);
    for (const char *at = strstr(code, word); at; at = strstr(at + 1, word))
        if ((at == code || !strchr(letters, at[-1])) && (!at[n] || !strchr(letters, at[n]))) return 1;
    return 0;
}

/* Does the code of a term under the lobes read a name? */
static int is_read(const source *s, const char *name)
{
    for (uint32_t b = 0; b < s->m->n_bases; b++)
        if (has_word(ff_snippet_base(ff_diffuse_at(s->m->base[b].diffuse)->term.name)->call, name)) return 1;
    return 0;
}

/* Does any term read the cosine of the half vector? */
static int reads_cosine(const source *s)
{
    int any = is_read(s, "c");
    for (uint32_t l = 0; l < s->m->n_lobes; l++)
        any |= has_word(ff_snippet_masking(ff_masking_at(s->m->lobe[l].masking)->term.name)->call, "c") ||
               has_word(ff_snippet_fresnel(fresnel_name(s->m, l))->call, "c");
    return any;
}

static void put_lobe(const source *s, uint32_t l, double weight)
{
    const ff_lobe *lobe = &s->m->lobe[l];
    const char *ndf = ff_snippet_ndf(ff_ndf_at(lobe->ndf)->term.name)->call;
    const ff_snippet_term *masking = ff_snippet_masking(ff_masking_at(lobe->masking)->term.name);
    ff_lobe_pass pass;
    ff_model_lobe(s->m, l, s->shape, &pass, NULL);
    fprintf(s->out, "    { /* %s, %s, %s */\n", ff_ndf_at(lobe->ndf)->term.name, masking->name, fresnel_name(s->m, l));
    put_constant(s, "ax", pass.s.ax);
    put_constant(s, "ay", pass.s.ay);
    put_constant(s, "r", pass.s.r);
    put_fresnel_params(s, l, 1);
    put(s->l,
        "        $T u = hx / (hz * ax);\n        $T v = hy / (hz * ay);\n        $T left = 1.0 - r * r;\n"
        "        $T q2 = (u * u + v * v - 2.0 * r * u * v) / left;\n",
        s->out);
    fprintf(s->out, "        %s d = facetfit_%s_p(q2) / (ax * ay * sqrt(left) * hz * hz * hz * hz);\n", s->l->type, ndf);
    if (masking->needs_lambda) {
        fprintf(s->out,
                "        %s li = facetfit_%s_lambda((ax * ax * ix * ix + ay * ay * iy * iy + 2.0 * r * ax * ay * ix * iy) / (iz * "
                "iz));\n",
                s->l->type, ndf);
        fprintf(s->out,
                "        %s lo = facetfit_%s_lambda((ax * ax * ox * ox + ay * ay * oy * oy + 2.0 * r * ax * ay * ox * oy) / (oz * "
                "oz));\n",
                s->l->type, ndf);
    }
    put(s->l, "        $T g = ", s->out);
    put(s->l, masking->call, s->out);
    put(s->l, ";\n        $T fresnel = ks * ", s->out);
    put(s->l, ff_snippet_fresnel(fresnel_name(s->m, l))->call, s->out);
    fputs(";\n", s->out);
    if (l == 0 && is_read(s, "first")) fputs("        first = fresnel;\n", s->out);
    fputs("        f += ", s->out);
    if (weight != 1) {
        put_number(weight, s->out);
        fputs(" * ", s->out);
    }
    fputs("d * g * fresnel / (4.0 * iz * oz);\n    }\n", s->out);
}

/* F of the first lobe at normal incidence. */
static void put_normal(const source *s)
{
    put(s->l, "        $T c = 1.0;\n", s->out);
    put_fresnel_params(s, 0, 0);
    put(s->l, "        normal = ", s->out);
    put(s->l, ff_snippet_fresnel(fresnel_name(s->m, 0))->call, s->out);
    fputs(";\n", s->out);
}

static void put_base(const source *s, uint32_t b)
{
    const ff_base *base = &s->m->base[b];
    const ff_term *term = &ff_diffuse_at(base->diffuse)->term;
    fprintf(s->out, "    { /* %s */\n", term->name);
    for (uint32_t k = base->shape0; k < base->shape0 + base->n_shape; k++) put_constant(s, bare(&s->m->shape[k]), s->shape[k]);
    for (uint32_t k = base->channel0; k < base->channel0 + base->n_channel; k++) put_channel(s, bare(&s->m->channel[k]), k);
    if (s->m->n_lobes && has_word(ff_snippet_base(term->name)->call, "ax")) {
        ff_lobe_pass pass;
        ff_model_lobe(s->m, 0, s->shape, &pass, NULL);
        put_constant(s, "ax", pass.s.ax);
    }
    fputs("        f += ", s->out);
    put(s->l, ff_snippet_base(term->name)->call, s->out);
    fputs(";\n    }\n", s->out);
}

static void put_sum(const source *s)
{
    double weight[FF_MAX_LOBES];
    ff_model_weights(s->m, s->shape, weight, NULL);
    put(s->l,
        "$F facetfit_brdf($T ix, $T iy, $T iz, $T ox, $T oy, $T oz, int channel)\n{\n"
        "    if (iz <= 0.0 || oz <= 0.0) return 0.0;\n"
        "    $T hx = ix + ox;\n    $T hy = iy + oy;\n    $T hz = iz + oz;\n    $T size = sqrt(hx * hx + hy * hy + hz * hz);\n"
        "    hx /= size;\n    hy /= size;\n    hz /= size;\n"
        "    $T f = 0.0;\n",
        s->out);
    if (s->n_channels == 1 && !strcmp(s->l->name, "c")) fputs("    (void)channel;\n", s->out);
    if (reads_cosine(s)) put(s->l, "    $T c = 0.5 * size;\n", s->out);
    if (is_read(s, "first")) put(s->l, "    $T first = 0.0;\n", s->out);
    if (is_read(s, "normal")) put(s->l, "    $T normal = 0.0;\n", s->out);
    for (uint32_t l = 0; l < s->m->n_lobes; l++) put_lobe(s, l, weight[l]);
    if (is_read(s, "normal")) {
        fputs("    {\n", s->out);
        put_normal(s);
        fputs("    }\n", s->out);
    }
    for (uint32_t b = 0; b < s->m->n_bases; b++) put_base(s, b);
    fputs("    return f;\n}\n", s->out);
}

ff_status ff_snippet_write(int l, const ff_model *m, size_t n_channels, const double *shape, const double *channel,
                           const char *version, FILE *out, ff_error *err)
{
    const source s = {&languages[l], m, n_channels, shape, channel, out};
    char expression[FF_MODEL_NAME];
    const ff_status status = check(m, shape, err);
    if (status != FF_OK) return status;
    ff_model_expression(m, expression, sizeof expression);
    fprintf(out, "/* %s, written by facetfit %s.\n", expression, version);
    fprintf(out,
            " * f in 1/sr for unit vectors towards light (i) and view (o) in the frame of the surface: x along the tangent, z "
            "along the\n"
            " * normal. The cosine is not in it. channel: 0 to %zu. */\n",
            n_channels - 1);
    fputs(s.l->head, out);
    put_terms(s.l, m, out);
    put_sum(&s);
    return FF_OK;
}
