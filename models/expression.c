/* Models as people write them: terms joined by '+', or the name of a preset. */
#include "internal_model.h"
#include <stdio.h>
#include <string.h>

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
    static const char *const a[] = {"a distribution", "a masking", "a Fresnel term", "a diffuse term"};
    char names[500] = "";
    for (int other = FF_NDF; other <= FF_DIFFUSE; other++)
        if (other != (int)kind && ff_term_find((ff_term_kind)other, word) >= 0 && !(kind == FF_NDF && other == FF_DIFFUSE))
            return ff_error_set(
                err, FF_ERR_UNKNOWN, NULL, 0, -1,
                "'%s' is %s and stands where %s is expected; a lobe is NDF[/MASKING[/FRESNEL]], a diffuse term is added "
                "with '+'",
                word, a[other], a[kind]);
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
    ff_status status = ff_model_parse(preset->expression, &m, err);
    for (size_t i = 0; i < sizeof preset->hold / sizeof *preset->hold && preset->hold[i] && !status; i++) {
        char name[FF_PARAM_NAME];
        double value = 0;
        const char *equals = strchr(preset->hold[i], '=');
        snprintf(name, sizeof name, "%.*s", (int)(equals - preset->hold[i]), preset->hold[i]);
        status = ff_model_number(equals + 1, equals + strlen(equals), &value, err);
        if (!status) status = ff_model_hold(&m, name, value, err);
    }
    if (!status) *out = m;
    return status;
}

/* Blanks at the ends and about '/' and '+' are none. */
static void drop_blanks(char *text)
{
    char *to = text;
    for (const char *from = text; *from; from++) {
        const size_t blanks = strspn(from, " \t");
        const int at_edge = to == text || strchr("/+", to[-1]) || !from[blanks] || strchr("/+", from[blanks]);
        if (blanks && at_edge) from += blanks;
        if (!*from) break;
        *to++ = *from;
    }
    *to = '\0';
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
    drop_blanks(text);
    if ((preset = ff_preset_find(text))) return parse_preset(preset, out, err);
    if (!*text) return ff_error_set(err, FF_ERR_SYNTAX, NULL, 0, -1, "the model expression is empty");
    ff_model m = {.n_lobes = 0};
    for (char *term = text, *next; term; term = next) {
        next = strchr(term, '+');
        if (next) *next++ = 0;
        const ff_status status = parse_term(term, &m, err);
        if (status) return status;
    }
    const ff_status status = ff_model_finish(&m, err);
    if (!status) *out = m;
    return status;
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
