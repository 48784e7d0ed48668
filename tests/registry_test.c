/* The registry, the expression language and the setting of parameters: everything that a person types or reads. */
#include "model_samples.h"
#include <ctype.h>

static int same(const char *a, const char *b)
{
    return strcmp(a, b) == 0;
}

/* ---- terms ----------------------------------------------------------------------------------- */

/* Lower case letters, digits and `joint`; starts with a letter. */
static int is_name(const char *name, char joint)
{
    if (!(name[0] >= 'a' && name[0] <= 'z')) return 0;
    for (const char *c = name; *c; c++)
        if (!((*c >= 'a' && *c <= 'z') || (*c >= '0' && *c <= '9') || *c == joint)) return 0;
    return name[strlen(name) - 1] != joint;
}

static void check_param(const ff_term *t, const ff_param *p)
{
    const uint32_t known = FF_PARAM_PER_CHANNEL | FF_PARAM_LINEAR | FF_PARAM_LOG | FF_PARAM_ATANH | FF_PARAM_HELD;
    const int letter = p->name[0] >= 'A' && p->name[0] <= 'Z' && !p->name[1]; /* as its paper has it */
    FF_CHECK((letter || is_name(p->name, '_')) && strlen(p->name) < 20, "%s: parameter '%s'", t->name, p->name);
    FF_CHECK(p->unit && p->unit[0], "%s.%s has no unit", t->name, p->name);
    FF_CHECK(p->meaning && p->meaning[0], "%s.%s has no meaning", t->name, p->name);
    FF_CHECK(p->lo < p->hi && p->lo <= p->init && p->init <= p->hi && isfinite(p->lo) && isfinite(p->hi), "%s.%s: %g <= %g <= %g",
             t->name, p->name, p->lo, p->init, p->hi);
    FF_CHECK((p->flags & ~known) == 0, "%s.%s: flags %x", t->name, p->name, p->flags);
    FF_CHECK(!((p->flags & FF_PARAM_LOG) && (p->flags & FF_PARAM_ATANH)), "%s.%s has two coordinates", t->name, p->name);
    if (p->flags & FF_PARAM_LOG) FF_CHECK(p->lo + p->offset > 0, "%s.%s: ln of %g", t->name, p->name, p->lo + p->offset);
    if (p->flags & FF_PARAM_ATANH) FF_CHECK(p->lo > -1 && p->hi < 1, "%s.%s: atanh of %g, %g", t->name, p->name, p->lo, p->hi);
    const double span = ff_coordinate(p, p->hi) - ff_coordinate(p, p->lo);
    FF_CHECK(isfinite(span) && span > 0, "%s.%s: its coordinate spans %g", t->name, p->name, span);
}

/* However a name is written, in capitals or with '_', and whichever of a term's other names it is, it is that term; of its kind no
 * other has such a name, and no preset. */
static void check_writings(ff_term_kind kind, size_t i)
{
    const ff_term *t = ff_term_at(kind, i);
    char loud[64];
    size_t k = 0;
    for (; t->name[k] && k + 1 < sizeof loud; k++) loud[k] = t->name[k] == '-' ? '_' : (char)toupper((unsigned char)t->name[k]);
    loud[k] = '\0';
    FF_CHECK(ff_term_find(kind, loud) == (int)i, "%s is not found as %s", t->name, loud);
    for (const char *also = t->also; also && *also; also += strcspn(also, ",") + (also[strcspn(also, ",")] == ',')) {
        snprintf(loud, sizeof loud, "%.*s", (int)strcspn(also, ","), also);
        FF_CHECK(is_name(loud, '-') && ff_term_find(kind, loud) == (int)i, "%s is not found as %s", t->name, loud);
        for (size_t o = 0; o < ff_term_count(kind); o++)
            FF_CHECK(!same(ff_term_at(kind, o)->name, loud), "%s is the name of another term", loud);
        FF_CHECK(!ff_preset_find(loud), "%s is a preset", loud);
    }
}

static void terms(void)
{
    const uint32_t known =
        FF_RECIPROCAL | FF_PASSIVE | FF_ISOTROPIC | FF_WEAK_FURNACE | FF_FURNACE_ONLY | FF_NEEDS_CENTRED | FF_UNIT_AREA;
    for (int kind = 0; kind < FF_TERM_KINDS; kind++) {
        const size_t n = ff_term_count((ff_term_kind)kind);
        FF_CHECK(n > 0 && ff_term_kind_name((ff_term_kind)kind)[0], "kind %d", kind);
        for (size_t i = 0; i < n; i++) {
            const ff_term *t = ff_term_at((ff_term_kind)kind, i);
            FF_CHECK(is_name(t->name, '-'), "'%s'", t->name);
            FF_CHECK(t->title && t->title[0] && t->note, "%s has no title or note", t->name);
            FF_CHECK(t->source && (t->source[0] || same(t->name, "none")), "%s has no source", t->name);
            FF_CHECK((t->claims & ~known) == 0, "%s: claims %x", t->name, t->claims);
            FF_CHECK((t->n_params == 0) == (t->params == NULL), "%s: %u parameters", t->name, t->n_params);
            FF_CHECK(ff_term_find((ff_term_kind)kind, t->name) == (int)i, "%s is not found under its name", t->name);
            for (uint32_t k = 0; k < t->n_params; k++) {
                check_param(t, &t->params[k]);
                for (uint32_t q = 0; q < k; q++)
                    FF_CHECK(!same(t->params[k].name, t->params[q].name), "%s.%s twice", t->name, t->params[k].name);
            }
        }
        FF_CHECK(ff_term_at((ff_term_kind)kind, n) == NULL, "kind %d: a term beyond the last", kind);
        FF_CHECK(ff_term_find((ff_term_kind)kind, "no-such-term") == -1 && ff_term_find((ff_term_kind)kind, "") == -1, "kind %d",
                 kind);
        for (size_t i = 0; i < n; i++) check_writings((ff_term_kind)kind, i);
    }
    FF_CHECK(ff_term_count((ff_term_kind)FF_TERM_KINDS) == 0 && ff_term_at((ff_term_kind)FF_TERM_KINDS, 0) == NULL,
             "a kind that does not exist");
    FF_CHECK(ff_term_find((ff_term_kind)-1, "ggx") == -1, "a kind that does not exist");
    /* a word of an expression is a distribution or a diffuse term: it cannot be both */
    for (size_t i = 0; i < ff_term_count(FF_NDF); i++)
        FF_CHECK(ff_term_find(FF_DIFFUSE, ff_term_at(FF_NDF, i)->name) == -1, "%s is two things", ff_term_at(FF_NDF, i)->name);
}

/* The names that files and commands already use. */
static void promised_names(void)
{
    static const char *const names[FF_TERM_KINDS][8] = {{"beckmann", "ggx", "student-t", "phong"},
                                                        {"smith-masking-only", "smith-separable", "smith-height-correlated",
                                                         "smith-direction-correlated", "smith-height-direction-correlated",
                                                         "v-cavity", "none"},
                                                        {"schlick", "none"},
                                                        {"lambert"}};
    for (int kind = 0; kind < FF_TERM_KINDS; kind++)
        for (int i = 0; i < 8 && names[kind][i]; i++)
            FF_CHECK(ff_term_find((ff_term_kind)kind, names[kind][i]) >= 0, "%s has gone", names[kind][i]);
}

/* ---- expressions ----------------------------------------------------------------------------- */

static void check_round_trip(const ff_model *m, const char *expression)
{
    ff_model again;
    char text[FF_MODEL_NAME];
    ff_error err = {0};
    memset(&again, 0, sizeof again);
    FF_CHECK(ff_model_parse(expression, &again, &err) == FF_OK, "%s: %s", expression, err.message);
    ff_model_expression(&again, text, sizeof text);
    FF_CHECK(same(text, expression), "%s became %s", expression, text);
    FF_CHECK(again.n_lobes == m->n_lobes && again.n_bases == m->n_bases && again.n_shape == m->n_shape &&
                 again.n_channel == m->n_channel,
             "%s", expression);
    for (uint32_t l = 0; l < m->n_lobes; l++)
        FF_CHECK(again.lobe[l].ndf == m->lobe[l].ndf && again.lobe[l].masking == m->lobe[l].masking &&
                     again.lobe[l].fresnel == m->lobe[l].fresnel,
                 "%s, lobe %u", expression, l + 1);
    for (uint32_t k = 0; k < m->n_shape + m->n_channel; k++) {
        const ff_param_ref at =
            k < m->n_shape ? (ff_param_ref){FF_PARAM_SHAPE, k} : (ff_param_ref){FF_PARAM_CHANNEL, k - m->n_shape};
        const ff_model_param *p = ff_model_param_at(m, at);
        const ff_param_ref found = ff_model_param_find(m, p->name);
        FF_CHECK(found.kind == at.kind && found.index == at.index, "%s: %s", expression, p->name);
    }
    FF_CHECK(!ff_model_param_at(m, (ff_param_ref){FF_PARAM_SHAPE, m->n_shape}) &&
                 !ff_model_param_at(m, (ff_param_ref){FF_PARAM_CHANNEL, m->n_channel}) &&
                 !ff_model_param_at(m, (ff_param_ref){FF_PARAM_NONE, 0}),
             "%s: a parameter that it does not have", expression);
}

static void round_trips(void)
{
    for (size_t k = 0; k < model_combination_count(); k++) {
        char label[MODEL_LABEL];
        const ff_model m = model_combination(k, label);
        check_round_trip(&m, label);
    }
    static const char *const longer[] = {"ggx/v-cavity/none+student-t/none/schlick+lambert",
                                         "phong/smith-separable/none+phong/none/none+ggx/v-cavity/schlick", "lambert"};
    for (size_t k = 0; k < sizeof longer / sizeof *longer; k++) {
        const ff_model m = model_parse(longer[k]);
        check_round_trip(&m, longer[k]);
    }
}

static void defaults_of_expressions(void)
{
    static const char *const pairs[][2] = {{"ggx", "ggx/smith-height-correlated/schlick"},
                                           {" ggx / v-cavity+\tlambert ", "ggx/v-cavity/schlick+lambert"},
                                           {"ggx/v-cavity", "ggx/v-cavity/schlick"},
                                           {"lambert+ggx", "ggx/smith-height-correlated/schlick+lambert"},
                                           {"beckmann+ggx/none/none", "beckmann/smith-height-correlated/schlick+ggx/none/none"}};
    for (size_t k = 0; k < sizeof pairs / sizeof *pairs; k++) {
        char text[FF_MODEL_NAME];
        const ff_model m = model_parse(pairs[k][0]);
        ff_model_expression(&m, text, sizeof text);
        FF_CHECK(same(text, pairs[k][1]), "%s became %s", pairs[k][0], text);
    }
    const ff_model m = model_parse("ggx+beckmann+lambert");
    FF_CHECK(same(m.shape[0].name, "alpha_x") && same(m.shape[5].name, "lobe2.alpha_x") && m.shape[5].lobe == 1, "%s %s",
             m.shape[0].name, m.shape[5].name);
    FF_CHECK(same(m.channel[0].name, "f0") && same(m.channel[1].name, "ks") && same(m.channel[2].name, "lobe2.f0") &&
                 same(m.channel[4].name, "kd") && m.channel[4].lobe == 2,
             "%s %s %s %s", m.channel[0].name, m.channel[1].name, m.channel[2].name, m.channel[4].name);
    char small[8];
    memset(small, 'x', sizeof small);
    ff_model_expression(&m, small, 5);
    FF_CHECK(same(small, "ggx/") && small[5] == 'x', "a short buffer holds '%s'", small);
    ff_model_expression(&m, small, 0);
    FF_CHECK(small[0] == 'g' && small[5] == 'x', "a buffer of no size was written");
}

/* A refusal: the status, a word of the message, and an untouched output. */
static void refuse(const char *expression, ff_status expected, const char *word)
{
    ff_model m, before;
    ff_error err = {0};
    memset(&m, 0x5a, sizeof m);
    before = m;
    const ff_status status = ff_model_parse(expression, &m, &err);
    FF_CHECK(status == expected && err.code == status, "'%s': %s", expression, ff_status_str(status));
    FF_CHECK(strstr(err.message, word) != NULL, "'%s': '%s' does not mention '%s'", expression, err.message, word);
    FF_CHECK(memcmp(&m, &before, sizeof m) == 0, "'%s' was refused, yet wrote its output", expression);
    FF_CHECK(ff_model_parse(expression, &m, NULL) == expected, "'%s' without an error object", expression);
}

static void refused_expressions(void)
{
    char longer[600];
    memset(longer, 'x', sizeof longer);
    longer[sizeof longer - 1] = 0;
    refuse("", FF_ERR_SYNTAX, "empty");
    refuse("ggx//", FF_ERR_SYNTAX, "empty");
    refuse("/v-cavity", FF_ERR_SYNTAX, "empty");
    refuse("ggx/v-cavity/", FF_ERR_SYNTAX, "empty");
    refuse("+ggx", FF_ERR_SYNTAX, "empty");
    refuse("ggx+", FF_ERR_SYNTAX, "empty");
    refuse("ggx++lambert", FF_ERR_SYNTAX, "empty");
    refuse("ggx/v-cavity/schlick/x", FF_ERR_SYNTAX, "'x'");
    refuse("lambert/v-cavity", FF_ERR_SYNTAX, "lambert");
    refuse("gxx", FF_ERR_UNKNOWN, "'gxx'");
    refuse("gxx", FF_ERR_UNKNOWN, "beckmann");
    refuse("gxx", FF_ERR_UNKNOWN, "lambert");
    refuse("gg x", FF_ERR_UNKNOWN, "'gg x'");
    refuse("GGXX", FF_ERR_UNKNOWN, "'GGXX'");
    refuse("ggx/smith", FF_ERR_UNKNOWN, "v-cavity");
    refuse("ggx/v-cavity/fresnel", FF_ERR_UNKNOWN, "schlick");
    refuse("ggx+ggx+ggx+ggx", FF_ERR_UNSUPPORTED, "lobes");
    refuse("lambert+lambert", FF_ERR_UNSUPPORTED, "twice");
    refuse("lambert+disney+oren-nayar", FF_ERR_UNSUPPORTED, "diffuse");
    refuse("beckmann/hammon", FF_ERR_UNSUPPORTED, "ggx");
    refuse("kelemen-ward", FF_ERR_UNSUPPORTED, "v-cavity");
    refuse("kelemen-matte", FF_ERR_UNSUPPORTED, "lobe");
    refuse("ggx/v-cavity/shared", FF_ERR_UNSUPPORTED, "shared");
    refuse(longer, FF_ERR_SYNTAX, "longer");
}

static void compositions(void)
{
    ff_model m, before;
    ff_error err = {0};
    const int n[FF_TERM_KINDS] = {(int)ff_term_count(FF_NDF), (int)ff_term_count(FF_MASKING), (int)ff_term_count(FF_FRESNEL),
                                  (int)ff_term_count(FF_DIFFUSE)};
    memset(&m, 0x5a, sizeof m);
    before = m;
    for (int kind = 0; kind < FF_TERM_KINDS; kind++)
        for (int bad = 0; bad < 2; bad++) {
            int index[FF_TERM_KINDS] = {0, 0, 0, -1};
            index[kind] = bad ? n[kind] : kind == FF_DIFFUSE ? -2 : -1;
            FF_CHECK(ff_model_compose(index[0], index[1], index[2], index[3], &m, &err) == FF_ERR_RANGE, "%s number %d",
                     ff_term_kind_name((ff_term_kind)kind), index[kind]);
            FF_CHECK(strstr(err.message, ff_term_kind_name((ff_term_kind)kind)) != NULL, "%s", err.message);
        }
    FF_CHECK(memcmp(&m, &before, sizeof m) == 0, "a refused composition was written");
}

/* Presets: names of their own, expressions that parse, values that are held. */
static void presets(void)
{
    FF_CHECK(ff_preset_count() >= 8 && ff_preset_at(ff_preset_count()) == NULL && ff_preset_find("no-such-preset") == NULL, "%zu",
             ff_preset_count());
    for (size_t i = 0; i < ff_preset_count(); i++) {
        const ff_preset *p = ff_preset_at(i);
        ff_error err = {0};
        ff_model m, plain;
        FF_CHECK(is_name(p->name, '-') && ff_preset_find(p->name) == p && p->title[0] && p->source[0] && p->note, "%s", p->name);
        for (int kind = 0; kind < FF_TERM_KINDS; kind++)
            FF_CHECK(ff_term_find((ff_term_kind)kind, p->name) < 0, "%s is two things", p->name);
        FF_CHECK(ff_model_parse(p->name, &m, &err) == FF_OK, "%s: %s", p->name, err.message);
        FF_CHECK(ff_model_parse(p->expression, &plain, &err) == FF_OK, "%s: %s", p->name, err.message);
        FF_CHECK(m.n_shape == plain.n_shape && m.n_channel == plain.n_channel, "%s", p->name);
        int held = 0, expected = 0;
        for (int k = 0; k < 3 && p->hold[k]; k++) expected++;
        for (uint32_t k = 0; k < m.n_shape; k++)
            held += m.shape[k].flags != plain.shape[k].flags || m.shape[k].init != plain.shape[k].init;
        for (uint32_t k = 0; k < m.n_channel; k++)
            held += m.channel[k].flags != plain.channel[k].flags || m.channel[k].init != plain.channel[k].init;
        FF_CHECK(held == expected, "%s holds %d parameters, %d of them make a difference", p->name, expected, held);
    }
    refuse("cook-torrance+lambert", FF_ERR_UNKNOWN, "cook-torrance"); /* a preset is a whole */
}

/* Cook and Torrance's own formula: F D G / (pi iz oz) with D = exp(-tan^2 / m^2) / (m^2 cos^4), G of the V-cavity. */
static void cook_torrance_as_published(void)
{
    const fit_surface s = fit_surface_make("cook-torrance", 1, "alpha=0.35 eta=1.7 kd=0");
    static model_pairs w;
    static double f[MODEL_PAIRS];
    uint64_t state = ff_test_stream("cook-torrance");
    w.n = 0;
    model_pairs_random(&s.model, s.shape, &state, 200, &w);
    const ff_dirs d = model_dirs(&w);
    FF_CHECK(ff_model_eval(&s.model, FF_ISA_BEST, 1, s.shape, s.channel, &d, w.n, f, NULL, w.n) == FF_OK, "eval");
    for (size_t i = 0; i < w.n; i++) {
        const double iz = w.w[2][i], oz = w.w[5][i], io = w.w[0][i] * w.w[3][i] + w.w[1][i] * w.w[4][i] + iz * oz;
        const double c = sqrt((1 + io) / 2), hz = (iz + oz) / (2 * c), m = 0.35, n = 1.7;
        const double D = exp((1 - 1 / (hz * hz)) / (m * m)) / (m * m * pow(hz, 4));
        const double G = fmin(1, 2 * hz * fmin(iz, oz) / c), g = sqrt(n * n + c * c - 1);
        const double ratio = (c * (g + c) - 1) / (c * (g - c) + 1);
        const double F = 0.5 * pow((g - c) / (g + c), 2) * (1 + ratio * ratio);
        FF_CHECK_CLOSE(f[i], F * D * G / (MODEL_PI * iz * oz), 1e-10, 1e-300);
    }
}

/* ---- parameters ------------------------------------------------------------------------------ */

enum { CHANNELS = 3 };

typedef struct values {
    double shape[FF_MAX_SHAPE], channel[CHANNELS * FF_MAX_CHANNEL_PARAMS];
} values;

static values defaults(const ff_model *m)
{
    values v;
    memset(&v, 0, sizeof v);
    ff_model_defaults(m, CHANNELS, v.shape, v.channel);
    return v;
}

static void assigned(const ff_model *m, values *v, const char *assignment)
{
    ff_error err = {0};
    FF_CHECK(ff_model_set(m, CHANNELS, assignment, v->shape, v->channel, &err) == FF_OK, "%s: %s", assignment, err.message);
}

static void assignments(void)
{
    const ff_model m = model_parse("ggx+student-t/v-cavity/schlick+lambert");
    values v = defaults(&m);
    for (uint32_t k = 0; k < m.n_shape; k++) FF_CHECK(v.shape[k] == m.shape[k].info->init, "%s", m.shape[k].name);
    for (size_t i = 0; i < CHANNELS * m.n_channel; i++)
        FF_CHECK(v.channel[i] == m.channel[i % m.n_channel].info->init, "channel parameter %zu", i);
    ff_model_defaults(&m, CHANNELS, NULL, NULL); /* either may be left out */
    const values initial = v;
    assigned(&m, &v, "alpha=0.25");
    FF_CHECK(v.shape[0] == 0.25 && v.shape[1] == 0.25, "alpha is %g, %g", v.shape[0], v.shape[1]);
    assigned(&m, &v, "lobe2.alpha=0.75");
    FF_CHECK(v.shape[5] == 0.75 && v.shape[6] == 0.75, "lobe2.alpha is %g, %g", v.shape[5], v.shape[6]);
    assigned(&m, &v, "lobe2.gamma=2.5e0");
    FF_CHECK(v.shape[10] == 2.5, "lobe2.gamma is %g", v.shape[10]);
    assigned(&m, &v, "r_xy=-.5");
    FF_CHECK(v.shape[2] == -0.5, "r_xy is %g", v.shape[2]);
    assigned(&m, &v, "kd=0.3");
    assigned(&m, &v, "f0=0.9:0.6:0.3");
    assigned(&m, &v, "lobe2.f0=0:1:0.5");
    for (size_t c = 0; c < CHANNELS; c++) {
        static const double f0[] = {0.9, 0.6, 0.3}, second[] = {0, 1, 0.5};
        const double *q = v.channel + c * m.n_channel;
        FF_CHECK(q[0] == f0[c] && q[2] == second[c] && q[4] == 0.3, "channel %zu: %g %g %g", c, q[0], q[2], q[4]);
    }
    FF_CHECK(v.shape[3] == initial.shape[3] && v.shape[7] == initial.shape[7], "a parameter was changed that nobody named");
    for (uint32_t k = 0; k < m.n_shape; k++) /* the box is closed */
        for (int side = 0; side < 2; side++) {
            char text[96];
            const double bound = side ? m.shape[k].info->hi : m.shape[k].info->lo;
            snprintf(text, sizeof text, "%s=%.17g", m.shape[k].name, bound);
            assigned(&m, &v, text);
            FF_CHECK(v.shape[k] == bound, "%s gave %.17g", text, v.shape[k]);
        }
}

static void refuse_assignment(const ff_model *m, const char *assignment, ff_status expected, const char *word)
{
    values v = defaults(m);
    const values before = v;
    ff_error err = {0};
    const ff_status status = ff_model_set(m, CHANNELS, assignment, v.shape, v.channel, &err);
    FF_CHECK(status == expected, "'%s': %s, expected %s", assignment, ff_status_str(status), ff_status_str(expected));
    FF_CHECK(strstr(err.message, word) != NULL, "'%s': '%s' does not mention '%s'", assignment, err.message, word);
    FF_CHECK(memcmp(&v, &before, sizeof v) == 0, "'%s' was refused, yet changed a value", assignment);
}

static void refused_assignments(void)
{
    const ff_model m = model_parse("student-t+ggx+lambert"), isotropic = model_parse("phong/v-cavity/none");
    static const char *const syntax[] = {"alpha",
                                         "=1",
                                         "",
                                         "alpha=",
                                         "alpha_x=x",
                                         "alpha_x=1,5",
                                         "alpha_x=0.5 ",
                                         "alpha_x= 0.5",
                                         "alpha_x=0.5x",
                                         "alpha_x=0x",
                                         "alpha_x=0x1p-2",
                                         "alpha_x=nan",
                                         "alpha_x=inf",
                                         "kd=NaN",
                                         "f0=0.5:",
                                         "f0=:0.5",
                                         "f0=0.5::0.5",
                                         "f0=0.1:0.2",
                                         "f0=0.1:0.2:0.3:0.4",
                                         "alpha_x=0.1:0.2:0.3",
                                         "alpha=0.1:0.2",
                                         "f0=0.1;0.2;0.3"};
    for (size_t k = 0; k < sizeof syntax / sizeof *syntax; k++) refuse_assignment(&m, syntax[k], FF_ERR_SYNTAX, "");
    refuse_assignment(&m, "alpha_x=1,5", FF_ERR_SYNTAX, "1,5");
    refuse_assignment(&m, "f0=0.1:0.2", FF_ERR_SYNTAX, "(3)");
    static const char *const range[] = {"alpha_x=0", "alpha=5",  "alpha=-0.3", "r_xy=1",          "r_xy=-0.9991",  "gamma=1.5",
                                        "gamma=101", "f0=-0.01", "f0=-0.01",   "f0=0.5:0.5:2e15", "slope_x=1e300", "gamma=1e999"};
    for (size_t k = 0; k < sizeof range / sizeof *range; k++) refuse_assignment(&m, range[k], FF_ERR_RANGE, "[");
    refuse_assignment(&m, "gamma=1.5", FF_ERR_RANGE, "[1.51, 100]");
    static const char *const unknown[] = {
        "n=3", "lobe2.gamma=3", "lobe3.alpha=1", "lobe1.alpha_x=1", "Alpha=1", "alpha_z=1", "lobe2.kd=0.1", "f=1", "f0 =1"};
    for (size_t k = 0; k < sizeof unknown / sizeof *unknown; k++)
        refuse_assignment(&m, unknown[k], FF_ERR_UNKNOWN, "lobe2.alpha_x");
    refuse_assignment(&isotropic, "alpha=0.3", FF_ERR_UNKNOWN, "n");
    refuse_assignment(&isotropic, "f0=0.3", FF_ERR_UNKNOWN, "n");
    FF_CHECK(ff_model_param_find(&m, "alpha").kind == FF_PARAM_NONE && ff_model_param_find(&m, "").kind == FF_PARAM_NONE,
             "alpha is not a parameter");
}

/* Every value out of its box, one at a time; a mean slope where it has no meaning. */
static void checks(void)
{
    const ff_model m = model_parse("student-t+phong+lambert");
    const double bad[] = {NAN, HUGE_VAL, -HUGE_VAL};
    values v = defaults(&m);
    FF_CHECK(ff_model_check(&m, CHANNELS, v.shape, v.channel, NULL) == FF_OK, "the initial values");
    for (size_t k = 0; k < m.n_shape + CHANNELS * m.n_channel; k++) {
        double *x = k < m.n_shape ? &v.shape[k] : &v.channel[k - m.n_shape];
        const ff_model_param *p = k < m.n_shape ? &m.shape[k] : &m.channel[(k - m.n_shape) % m.n_channel];
        const double kept = *x;
        for (int i = 0; i < 5; i++) {
            ff_error err = {0};
            const ff_param *domain = ff_model_param_domain(&m, p);
            *x = i < 3 ? bad[i] : i == 3 ? nextafter(domain->lo, -HUGE_VAL) : nextafter(domain->hi, HUGE_VAL);
            FF_CHECK(ff_model_check(&m, CHANNELS, v.shape, v.channel, &err) == FF_ERR_RANGE, "%s = %g", p->name, *x);
            FF_CHECK(strstr(err.message, p->name) != NULL, "'%s' does not name %s", err.message, p->name);
        }
        *x = kept;
    }
    for (size_t i = 0; i < ff_term_count(FF_MASKING); i++) {
        const ff_term *masking = ff_term_at(FF_MASKING, i);
        char expression[FF_MODEL_NAME];
        if (ff_masking_at((int)i)->only && strcmp(ff_masking_at((int)i)->only, "ggx")) continue;
        snprintf(expression, sizeof expression, "phong+ggx/%s", masking->name);
        const ff_model tilted = model_parse(expression);
        if (tilted.lobe[1].isotropic) continue; /* it has no mean slope */
        const ff_status expected = masking->claims & FF_NEEDS_CENTRED ? FF_ERR_UNSUPPORTED : FF_OK;
        for (int axis = 0; axis < 2; axis++) {
            ff_error err = {0};
            double f, df[FF_MAX_SHAPE + FF_MAX_CHANNEL_PARAMS];
            const double up = 1, zero = 0;
            const ff_dirs w = {&zero, &zero, &up, &zero, &zero, &up};
            v = defaults(&tilted);
            assigned(&tilted, &v, axis ? "lobe2.slope_y=0.1" : "lobe2.slope_x=-1e-300");
            const ff_status status = ff_model_check(&tilted, CHANNELS, v.shape, v.channel, &err);
            FF_CHECK(status == expected && (status == FF_OK || strstr(err.message, masking->name) != NULL), "%s: %s, %s",
                     expression, ff_status_str(status), err.message);
            FF_CHECK(ff_model_eval(&tilted, FF_ISA_BEST, 1, v.shape, v.channel, &w, 1, &f, df, 1) == expected, "%s", expression);
        }
    }
}

/* ---- claims ---------------------------------------------------------------------------------- */

static void claims_of_models(void)
{
    for (size_t k = 0; k < model_combination_count(); k++) {
        char label[MODEL_LABEL];
        const ff_model m = model_combination(k, label);
        uint32_t both = ff_term_at(FF_NDF, (size_t)m.lobe[0].ndf)->claims &
                        ff_term_at(FF_MASKING, (size_t)m.lobe[0].masking)->claims &
                        ff_term_at(FF_FRESNEL, (size_t)m.lobe[0].fresnel)->claims;
        for (uint32_t b = 0; b < m.n_bases; b++) both &= ff_term_at(FF_DIFFUSE, (size_t)m.base[b].diffuse)->claims;
        values v = defaults(&m);
        const uint32_t centred = ff_model_claims(&m, v.shape);
        FF_CHECK((centred & FF_RECIPROCAL) == (both & FF_RECIPROCAL), "%s", label);
        FF_CHECK(!(centred & FF_PASSIVE) || (both & FF_PASSIVE), "%s", label);
        FF_CHECK(centred & FF_ISOTROPIC, "%s: initially round", label);
        if (ff_model_param_find(&m, "slope_x").kind != FF_PARAM_SHAPE) continue;
        assigned(&m, &v, "slope_x=0.1");
        FF_CHECK((ff_model_claims(&m, v.shape) & (FF_RECIPROCAL | FF_PASSIVE | FF_ISOTROPIC)) == 0, "%s: a mean slope", label);
        v = defaults(&m);
        assigned(&m, &v, "r_xy=0.1");
        FF_CHECK(!(ff_model_claims(&m, v.shape) & FF_ISOTROPIC), "%s: correlated", label);
    }
}

FF_TEST_MAIN(FF_TEST(terms), FF_TEST(promised_names), FF_TEST(round_trips), FF_TEST(defaults_of_expressions),
             FF_TEST(refused_expressions), FF_TEST(compositions), FF_TEST(presets), FF_TEST(cook_torrance_as_published),
             FF_TEST(assignments), FF_TEST(refused_assignments), FF_TEST(checks), FF_TEST(claims_of_models))
