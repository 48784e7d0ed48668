/* The sentences of a verdict, and when each is said. */
#define _GNU_SOURCE
#include "internal_verdict.h"
#include "internal_fits_text.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- how good -------------------------------------------------------------------------------- */

/* 99.97, 99.3, 12: no digits that say nothing, and no 100 of what is less. */
static const char *share_text(double share, char out[FF_TEXT_NUMBER])
{
    if (share <= 0) return "nothing";
    if (share > 0.9999) return strcpy(out, share > 1 - 1e-9 ? "all" : "more than 99.99 %");
    char number[FF_TEXT_NUMBER];
    snprintf(out, FF_TEXT_NUMBER, "%.40s %%", ff_text_fixed(100 * share, share > 0.99 ? 2 : share > 0.9 ? 1 : 0, number));
    return out;
}

static const char *percent(double x, char out[FF_TEXT_NUMBER])
{
    if (fabs(x) < 5e-4) return "0.1";
    return ff_text_fixed(100 * fabs(x), fabs(x) < 0.0995 ? 1 : 0, out);
}

static int say_quality(const ff_report_fits *r, const ff_fit_result *f, ff_verdict *v)
{
    static const char *const word[] = {[FF_QUALITY_POOR] = "A poor", [FF_QUALITY_FAIR] = "A fair", [FF_QUALITY_GOOD] = "A good"};
    const ff_explained *e = ff_verdict_explained(r, f);
    char share[FF_TEXT_NUMBER], error[FF_TEXT_NUMBER], mean[FF_TEXT_NUMBER];
    v->code = FF_VERDICT_QUALITY;
    v->quality = ff_quality_of(e);
    if (v->quality == FF_QUALITY_UNKNOWN) return 0;
    ff_verdict_put(v, "%s fit: it explains %s of the data", word[v->quality], share_text(e->share, share));
    if (e->bright_error > 2)
        ff_verdict_put(v, ", and where they are bright half of the values are off by more than twice as much as they are");
    else if (!isnan(e->bright_error))
        ff_verdict_put(v, ", and where they are bright half of the values are within %s%s %% of it",
                       e->bright_error < 5e-4 ? "less than " : "", percent(e->bright_error, error));
    if (isnan(e->worst_mean) || fabs(e->worst_mean) < 0.005) return 1;
    ff_verdict_put(v, "; it is furthest off at %s %d to %d degrees, %s by %s %% on average", ff_place_name(e->worst_place),
                   e->worst_band * FF_BAND_DEGREES, (e->worst_band + 1) * FF_BAND_DEGREES,
                   e->worst_mean > 0 ? "too bright" : "too dark", percent(e->worst_mean, mean));
    return 1;
}

/* ---- what was found -------------------------------------------------------------------------- */

/* "0.198 (95 %: 0.186 to 0.211)" */
static void put_value(ff_verdict *out, const char *name, const ff_fit_value *v)
{
    char value[FF_TEXT_NUMBER], low[FF_TEXT_NUMBER], high[FF_TEXT_NUMBER];
    const double width = v->interval != FF_INTERVAL_NONE && v->high > v->low ? 0.5 * (v->high - v->low) : NAN;
    if (isnan(width)) {
        ff_verdict_put(out, "%s %s", name, ff_text_number(v->value, 3, value));
        return;
    }
    ff_verdict_put(out, "%s %s (95 %%: %s to %s)", name, ff_text_within(v->value, width, value), ff_text_within(v->low, width, low),
                   ff_text_within(v->high, width, high));
}

static int is_isotropic(const ff_fit_result *f)
{
    return f->shape == FF_SHAPE_ISOTROPIC;
}

/* alpha_x of an isotropic surface is its alpha. */
static const char *shape_name(const ff_fit_result *f, uint32_t k)
{
    const char *name = f->model.shape[k].name;
    return is_isotropic(f) && !strcmp(name, "alpha_x") ? "alpha" : name;
}

/* Of one channel the value and its interval; of several the values, from eight on least and largest. */
static void put_channel_parameter(const ff_fit_result *f, uint32_t k, ff_verdict *v)
{
    const size_t C = f->n_channels, K = f->model.n_channel;
    char number[FF_TEXT_NUMBER], other[FF_TEXT_NUMBER];
    if (C == 1) {
        put_value(v, f->model.channel[k].name, &f->channel_value[k]);
        return;
    }
    ff_verdict_put(v, "%s ", f->model.channel[k].name);
    if (C < FF_REPORT_CHANNELS) {
        for (size_t c = 0; c < C; c++)
            ff_verdict_put(v, "%s%s", c ? "/" : "", ff_text_number(f->channel_value[c * K + k].value, 3, number));
        return;
    }
    double low = INFINITY, high = -INFINITY;
    for (size_t c = 0; c < C; c++) {
        low = fmin(low, f->channel_value[c * K + k].value);
        high = fmax(high, f->channel_value[c * K + k].value);
    }
    ff_verdict_put(v, "%s to %s", ff_text_number(low, 3, number), ff_text_number(high, 3, other));
}

/* The shape, and the first parameter of each channel, its reflectance. */
static int say_found(const ff_report_fits *r, const ff_fit_result *f, ff_verdict *v)
{
    const char *separator = "";
    char expression[FF_MODEL_NAME];
    (void)r;
    v->code = FF_VERDICT_FOUND;
    for (uint32_t k = 0; k < f->model.n_shape; k++) {
        const ff_fit_value *value = &f->shape_value[k];
        if (value->held || value->tied || ff_report_left_alone(value, f->model.shape[k].info)) continue;
        ff_verdict_put(v, "%s", separator);
        put_value(v, shape_name(f, k), value);
        separator = ", ";
    }
    for (uint32_t k = 0; k < f->model.n_channel; k++) {
        if (ff_report_all_held(f, k) || ff_report_all_left_alone(f, k)) continue;
        ff_verdict_put(v, "%s", separator);
        put_channel_parameter(f, k, v);
        separator = ", ";
        break;
    }
    ff_model_expression(&f->model, expression, sizeof expression);
    if (!*separator) return 0;
    ff_verdict_put(v, ": %s", expression);
    return 1;
}

static int say_failure(const ff_fit_result *f, ff_verdict *v)
{
    if (f->outcome != FF_CONVERGED) {
        v->code = FF_VERDICT_NOT_CONVERGED;
        ff_verdict_put(v, "No answer: the fit did not converge (%s)", ff_outcome_name((int)f->outcome));
        return 1;
    }
    if (!ff_verdict_is_of_nothing(f)) return 0;
    v->code = FF_VERDICT_NOTHING_FOUND;
    ff_verdict_put(v, "No answer: these data show no lobe whose roughness could be known");
    return 1;
}

#define MANY_LOST 0.2 /* of all samples */

/* ---- in which unit ---------------------------------------------------------------------------- */

/* Is there a scale that the fit looks for? Then the unit is no matter. */
static int has_free_scale(const ff_fit_result *f)
{
    for (uint32_t k = 0; k < f->model.n_channel; k++) {
        const char *dot = strrchr(f->model.channel[k].name, '.');
        if (!strcmp(dot ? dot + 1 : f->model.channel[k].name, "ks") && !ff_report_all_held(f, k)) return 1;
    }
    return 0;
}

/* More is reflected than arrives: what follows is of values in another unit. */
static int say_unit(const ff_report_fits *r, const ff_fit_result *f, ff_verdict *v)
{
    char number[FF_TEXT_NUMBER];
    ff_selection s;
    ff_problem_selection(r->problem[(size_t)(f - r->fit) / ff_verdict_models(r)], &s);
    const double reflects = s.brightest.reflects;
    v->code = FF_VERDICT_UNIT;
    if (!(reflects > FF_REFLECTS_SOME) || has_free_scale(f)) return 0;
    ff_verdict_put(v, "The values are not in 1/sr: they reflect at least %s times the light that arrives; ",
                   ff_text_number(reflects, 3, number));
    if (reflects > FF_REFLECTS_ODD)
        ff_verdict_put(v, "--scale takes the factor that makes 1/sr of them");
    else if (reflects > FF_REFLECTS_FACTOR)
        ff_verdict_put(v, "if they are in per cent, say --scale 0.01");
    else
        ff_verdict_put(v, "if they are pi times the BRDF, say --quantity reflectance-factor");
    ff_verdict_put(v, ", --free ks fits %s", reflects > FF_REFLECTS_ODD ? "it" : "another scale");
    return 1;
}

/* So many scattered samples below the horizon are angles that were taken for something else. Grids have corners there. */
static int say_lost(const ff_report_fits *r, const ff_fit_result *f, ff_verdict *v)
{
    ff_selection s;
    ff_problem_selection(r->problem[(size_t)(f - r->fit) / ff_verdict_models(r)], &s);
    v->code = FF_VERDICT_LOST;
    if (r->table->grid || !((double)s.below_horizon > MANY_LOST * (double)s.samples)) return 0;
    ff_verdict_put(
        v,
        "%zu of %zu samples lie below the horizon by their angles, and are left out: are these in degrees and counted from "
        "the normal? --angles says otherwise",
        s.below_horizon, s.samples);
    return 1;
}

/* ---- what cannot be told --------------------------------------------------------------------- */

/* A roughness that may be three times as much or as little. */
static const ff_fit_value *hardly_known(const ff_fit_result *f, uint32_t *at)
{
    for (uint32_t k = 0; k < f->model.n_shape; k++) {
        const ff_fit_value *v = &f->shape_value[k];
        if (strncmp(f->model.shape[k].name, "alpha", 5) != 0 || v->held || v->tied || v->interval == FF_INTERVAL_NONE) continue;
        *at = k;
        if (v->high > 9 * v->low) return v;
    }
    return NULL;
}

/* The first warning that says so. */
static int say_not_told(const ff_report_fits *r, const ff_fit_result *f, ff_verdict *v)
{
    static const ff_warning_code codes[] = {FF_WARNING_NOT_DETERMINED, FF_WARNING_COMBINATION_NOT_DETERMINED, FF_WARNING_TRADE_OFF,
                                            FF_WARNING_CORRELATED, FF_WARNING_ONE_INCIDENCE};
    const ff_words_subject subject = {.problem = r->problem[(size_t)(f - r->fit) / ff_verdict_models(r)], .fit = f};
    char text[FF_WORDS_SENTENCE];
    uint32_t of = 0;
    const ff_fit_value *wide = hardly_known(f, &of);
    char low[FF_TEXT_NUMBER], high[FF_TEXT_NUMBER];
    v->code = FF_VERDICT_NOT_TOLD;
    if (wide) {
        ff_verdict_put(v, "Not known: %s may be anything from %s to %s", shape_name(f, of), ff_text_number(wide->low, 2, low),
                       ff_text_number(wide->high, 2, high));
        return 1;
    }
    for (size_t k = 0; k < FF_COUNT(codes); k++) {
        for (size_t i = 0; i < f->warnings.n; i++) {
            if (f->warnings.item[i].code != codes[k]) continue;
            ff_verdict_put(v, "Not known: %.2000s", ff_words_warning(&subject, &f->warnings.item[i], text));
            return 1;
        }
    }
    return 0;
}

/* ---- what a comparison prefers --------------------------------------------------------------- */

/* Names, each once, in the order in which they came. */
typedef struct names {
    const char *name[64];
    size_t n;
} names;

static void add_name(names *to, const char *name)
{
    for (size_t k = 0; k < to->n; k++)
        if (!strcmp(to->name[k], name)) return;
    if (to->n < FF_COUNT(to->name)) to->name[to->n++] = name;
}

enum { NAMED = 5 };

/* "a, b and c"; of more than fit into a sentence how many: "13 of the 14 distributions". */
static void put_names(ff_verdict *v, const names *of, size_t all, const char *what)
{
    if (of->n > NAMED && of->n < all) ff_verdict_put(v, "%zu of the %zu %s", of->n, all, what);
    if (of->n > NAMED && of->n >= all) ff_verdict_put(v, "the %zu %s", of->n, what);
    for (size_t k = 0; k < of->n && of->n <= NAMED; k++)
        ff_verdict_put(v, "%s%s", k == 0 ? "" : k + 1 == of->n ? " and " : ", ", of->name[k]);
}

/* The masking functions of Smith, whatever they are correlated with, are one family. */
static const char *family_of(const ff_fit_result *f)
{
    const char *name = ff_report_masking_name(f);
    return strncmp(name, "smith-", 6) == 0 ? "Smith" : name;
}

enum { SLOPES = 320 }; /* 0, then from LEAST_SLOPE on, each larger by SLOPE_STEP */
#define LEAST_SLOPE 1e-4
#define SLOPE_STEP  1.05

static double slope_at(size_t k)
{
    return k ? LEAST_SLOPE * pow(SLOPE_STEP, (double)(k - 1)) : 0;
}

/* The density of slopes of the first lobe along x, relative to that at 0. */
static ff_status slope_densities(const ff_fit_result *f, double density[SLOPES])
{
    double x[SLOPES], y[SLOPES] = {0}, z[SLOPES], shape[FF_MAX_SHAPE];
    const ff_dirs normal = {x, y, z, x, y, z};
    double *channel = malloc((f->n_channels * f->model.n_channel + 1) * sizeof *channel);
    if (!channel) return FF_ERR_MEMORY;
    for (size_t k = 0; k < SLOPES; k++) {
        z[k] = 1 / sqrt(1 + slope_at(k) * slope_at(k));
        x[k] = slope_at(k) * z[k];
    }
    for (uint32_t k = 0; k < f->model.n_shape; k++) shape[k] = f->shape_value[k].value;
    for (size_t k = 0; k < f->n_channels * f->model.n_channel; k++) channel[k] = f->channel_value[k].value;
    const ff_status status =
        ff_model_terms(&f->model, FF_ISA_BEST, f->n_channels, shape, channel, 0, 0, &normal, SLOPES, &(ff_terms){.d = density});
    free(channel);
    for (size_t k = SLOPES; k-- > 0 && !status;) density[k] *= pow(z[k], 4) / density[0];
    return status;
}

/* Does the density of slopes still have a ten-thousandth of its peak at six times the slope where it has half? That of GGX has 40
 * times as much there, that of Beckmann 1e-7 times. */
static int has_long_tails(const ff_fit_result *f)
{
    const size_t further = (size_t)lround(log(6) / log(SLOPE_STEP));
    double density[SLOPES];
    size_t half = 0;
    if (f->model.n_lobes == 0 || slope_densities(f, density) || !isfinite(density[SLOPES - 1])) return 0;
    while (half < SLOPES && density[half] > 0.5) half++;
    return half + further < SLOPES && density[half + further] > 1e-4;
}

/* What those that are not told apart from the best have, and what the others do. */
typedef struct leaders {
    size_t n, others;
    names ndf, family, masking;
    int long_tails, short_tails;             /* among the leaders  */
    int other_long_tails, other_short_tails; /* among the others   */
    names other_family, other_ndf, any_family, any_ndf;
} leaders;

static void look_at_model(const ff_report_fits *r, const ff_fit_result *f, const ff_fit_result *best, leaders *out)
{
    const int leads = f == best || ff_report_is_tied(r, f, best), has_long = has_long_tails(f);
    out->n += leads != 0;
    out->others += leads == 0;
    add_name(leads ? &out->ndf : &out->other_ndf, ff_report_ndf_name(f));
    add_name(leads ? &out->family : &out->other_family, family_of(f));
    if (leads) add_name(&out->masking, ff_report_masking_name(f));
    add_name(&out->any_ndf, ff_report_ndf_name(f));
    add_name(&out->any_family, family_of(f));
    if (leads) *(has_long ? &out->long_tails : &out->short_tails) = 1;
    if (!leads) *(has_long ? &out->other_long_tails : &out->other_short_tails) = 1;
}

/* Is there a name among `of` that is not among `than`? */
static int has_other(const names *of, const names *than)
{
    for (size_t i = 0; i < of->n; i++) {
        int found = 0;
        for (size_t k = 0; k < than->n; k++) found |= !strcmp(of->name[i], than->name[k]);
        if (!found) return 1;
    }
    return 0;
}

/* "These data prefer long tails (student-t and gtr)"; where there is a choice between kinds of tails and they have made it. */
static void put_distributions(const leaders *l, ff_verdict *v)
{
    const int of_tails =
        l->long_tails != l->short_tails && l->ndf.n > 1 && (l->long_tails ? l->other_short_tails : l->other_long_tails);
    if (of_tails)
        ff_verdict_put(v, "These data prefer %s tails (", l->long_tails ? "long" : "short");
    else
        ff_verdict_put(v, has_other(&l->other_ndf, &l->ndf) ? "These data prefer " : "These data do not tell apart ");
    put_names(v, &l->ndf, l->any_ndf.n, "distributions");
    if (of_tails) ff_verdict_put(v, ")");
}

/* "... with the masking v-cavity", "...; they do not tell apart Smith and v-cavity" */
static void put_maskings(const leaders *l, ff_verdict *v)
{
    if (l->family.n == 1 && has_other(&l->other_family, &l->family)) ff_verdict_put(v, " with the masking %s", l->family.name[0]);
    if (l->family.n > 1) {
        ff_verdict_put(v, "; they do not tell apart ");
        put_names(v, &l->family, l->any_family.n, "maskings");
    }
    if (l->family.n == 1 && l->masking.n > 1)
        ff_verdict_put(v, "; they do not tell apart %zu forms of Smith's masking", l->masking.n);
}

/* Where only one distribution was tried. */
static void put_of_one_distribution(const leaders *l, ff_verdict *v)
{
    ff_verdict_put(v, "These data ");
    if (l->family.n > 1) {
        ff_verdict_put(v, "do not tell apart ");
        put_names(v, &l->family, l->any_family.n, "maskings");
    } else if (has_other(&l->other_family, &l->family)) {
        ff_verdict_put(v, "prefer the masking %s", l->family.name[0]);
    } else if (l->masking.n > 1) {
        ff_verdict_put(v, "do not tell apart %zu forms of Smith's masking", l->masking.n);
    } else {
        ff_verdict_put(v, "do not tell apart %zu of %zu models with %s/%s", l->n, l->n + l->others, l->ndf.name[0],
                       l->masking.name[0]);
    }
}

/* "...; they do not tell apart Smith and v-cavity; simplest adequate: ggx/smith-separable". */
static int say_preference(const ff_report_fits *r, size_t p, ff_verdict *v)
{
    const ff_fit_result *best = ff_report_best(r, p), *simplest = ff_report_simplest(r, best);
    const ff_versus *versus = ff_report_versus(r, best);
    leaders *l = calloc(1, sizeof *l);
    v->code = FF_VERDICT_PREFERENCE;
    if (!l || !versus || ff_verdict_models(r) < 2) {
        free(l);
        return 0;
    }
    for (size_t i = p * ff_verdict_models(r); i < (p + 1) * ff_verdict_models(r); i++) look_at_model(r, &r->fit[i], best, l);
    if (l->n == 1) {
        ff_verdict_put(v, "These data tell %s/%s from the %zu other%s", ff_report_ndf_name(best), ff_report_masking_name(best),
                       l->others, ff_report_plural(l->others));
        free(l);
        return 1;
    }
    if (l->any_ndf.n > 1)
        put_distributions(l, v);
    else
        put_of_one_distribution(l, v);
    if (l->any_ndf.n > 1) put_maskings(l, v);
    ff_verdict_put(v, "; simplest adequate: %s/%s", ff_report_ndf_name(simplest), ff_report_masking_name(simplest));
    free(l);
    return 1;
}

/* Are there too few incidences for any test? */
static int say_no_test(const ff_report_fits *r, size_t p, ff_verdict *v)
{
    const ff_fit_result *best = ff_report_best(r, p);
    const ff_versus *versus = ff_report_versus(r, best);
    if (!versus || !versus->weighted || versus->incidences >= 3) return 0;
    v->code = FF_VERDICT_NO_TEST;
    ff_verdict_put(v, "Lowest residuals: %s/%s; from %zu incidence%s no model can be ruled out", ff_report_ndf_name(best),
                   ff_report_masking_name(best), versus->incidences, ff_report_plural(versus->incidences));
    return 1;
}

/* ---- what to measure next -------------------------------------------------------------------- */

/* "20, 55 and 75", with "at phi_i ..." where azimuths differ. */
static void put_incidences(const ff_next *next, ff_verdict *v)
{
    int turned = 0;
    char number[FF_TEXT_NUMBER];
    for (size_t k = 0; k < next->n; k++) turned |= fabs(next->at[k].phi_i - next->at[0].phi_i) > 1e-6;
    for (size_t k = 0; k < next->n; k++) {
        ff_verdict_put(v, "%s%s",
                       k == 0             ? ""
                       : k + 1 == next->n ? " and "
                                          : ", ",
                       ff_text_number(ff_report_degrees(next->at[k].theta_i), 3, number));
        if (turned) ff_verdict_put(v, " (phi_i %s)", ff_text_number(ff_report_degrees(next->at[k].phi_i), 4, number));
    }
}

#define TELLS       2    /* the z that tells two models apart at several incidences       */
#define WORTH_WHILE 0.7  /* of a standard error that new incidences leave                */
#define KNOWN_WELL  0.03 /* of a value: its error needs no more measurements             */

/* "A from B": by distribution and masking, or where these are the same with the other terms. */
static void put_rivals(const ff_fit_result *a, const ff_fit_result *b, ff_verdict *v)
{
    char whole[2][FF_MODEL_NAME];
    if (strcmp(ff_report_ndf_name(a), ff_report_ndf_name(b)) || strcmp(ff_report_masking_name(a), ff_report_masking_name(b))) {
        ff_verdict_put(v, "%s/%s from %s/%s", ff_report_ndf_name(a), ff_report_masking_name(a), ff_report_ndf_name(b),
                       ff_report_masking_name(b));
        return;
    }
    ff_model_expression(&a->model, whole[0], sizeof whole[0]);
    ff_model_expression(&b->model, whole[1], sizeof whole[1]);
    ff_verdict_put(v, "%s from %s", whole[0], whole[1]);
}

static int say_measure(const ff_report_fits *r, const ff_fit_result *f, ff_verdict *v)
{
    const ff_fit_result *best = ff_report_best(r, (size_t)(f - r->fit) / ff_verdict_models(r));
    const ff_fit_trust *t = r->trust ? &r->trust[best - r->fit] : NULL;
    char now[FF_TEXT_NUMBER], then[FF_TEXT_NUMBER];
    v->code = FF_VERDICT_MEASURE;
    if (!t || !t->has_next || t->next.n == 0) return 0;
    const ff_next *next = &t->next;
    const ff_fit_result *rival = &r->fit[t->next_rival];
    if (rival != best) {
        const int tells = next->then >= TELLS;
        ff_verdict_put(v, tells ? "To tell " : "No three incidences up to theta_i %s degrees would tell ",
                       ff_text_number(ff_report_degrees(next->reach), 3, then));
        put_rivals(best, rival, v);
        if (!tells) ff_verdict_put(v, "; --reach says how far the instrument goes");
        if (!tells) return 1;
        ff_verdict_put(v, ", measure at theta_i ");
        put_incidences(next, v);
        ff_verdict_put(v, " degrees: z is expected to be %s then, now %s", ff_text_number(next->then, 2, then),
                       ff_text_number(next->now, 2, now));
        return 1;
    }
    const int of_shape = next->parameter.kind == FF_PARAM_SHAPE;
    const ff_fit_value *value = of_shape ? &best->shape_value[next->parameter.index]
                                         : &best->channel_value[next->channel * best->model.n_channel + next->parameter.index];
    if (!(next->then < WORTH_WHILE * next->now) || !(next->now > KNOWN_WELL * fabs(value->value))) return 0;
    ff_verdict_put(v, "To know %s better, measure at theta_i ", ff_model_param_at(&best->model, next->parameter)->name);
    put_incidences(next, v);
    ff_verdict_put(v, " degrees: its error would be %s of what it is", ff_text_number(next->then / next->now, 2, then));
    return 1;
}

/* ---- the whole ------------------------------------------------------------------------------- */

typedef int (*sayer)(const ff_report_fits *r, const ff_fit_result *f, ff_verdict *v);

static void say(sayer one, const ff_report_fits *r, const ff_fit_result *f, ff_verdict *out, size_t *n)
{
    out[*n] = (ff_verdict){.quality = FF_QUALITY_UNKNOWN};
    *n += one(r, f, &out[*n]) != 0;
}

size_t ff_verdict_of(const ff_report_fits *r, size_t p, ff_verdict out[FF_VERDICT_MOST])
{
    const int compared = ff_verdict_models(r) > 1;
    const ff_fit_result *best = ff_report_best(r, p), *f = compared ? ff_report_simplest(r, best) : best;
    size_t n = 0;
    say(say_unit, r, f, out, &n);
    say(say_lost, r, f, out, &n);
    out[n] = (ff_verdict){.quality = FF_QUALITY_UNKNOWN};
    if (say_failure(f, &out[n])) {
        n++;
    } else {
        if (compared) {
            out[n] = (ff_verdict){.quality = FF_QUALITY_UNKNOWN};
            n += (say_no_test(r, p, &out[n]) || say_preference(r, p, &out[n])) != 0;
        }
        say(say_found, r, f, out, &n);
        say(say_quality, r, f, out, &n);
        say(say_not_told, r, f, out, &n);
        say(say_measure, r, f, out, &n);
    }
    say(compared ? ff_verdict_next_of_comparison : ff_verdict_next_of_fit, r, f, out, &n);
    say(ff_verdict_look, r, f, out, &n);
    return n;
}

static int is_command(const ff_verdict *v)
{
    return v->code == FF_VERDICT_NEXT || v->code == FF_VERDICT_LOOK;
}

static ff_ink ink_of(const ff_verdict *v)
{
    static const ff_ink of[] = {
        [FF_QUALITY_POOR] = FF_INK_BAD, [FF_QUALITY_FAIR] = FF_INK_WARNING, [FF_QUALITY_GOOD] = FF_INK_GOOD};
    if (v->code == FF_VERDICT_NOT_CONVERGED || v->code == FF_VERDICT_NOTHING_FOUND || v->code == FF_VERDICT_UNIT ||
        v->code == FF_VERDICT_LOST)
        return FF_INK_BAD;
    if (v->code == FF_VERDICT_QUALITY) return of[v->quality];
    return is_command(v) ? FF_INK_FAINT : FF_INK_PLAIN;
}

ff_status ff_report_verdict_text(const ff_report_fits *r, FILE *out)
{
    const int color = r->style && r->style->color;
    ff_verdict *v = calloc(FF_VERDICT_MOST, sizeof *v);
    if (!v) return FF_ERR_MEMORY;
    for (size_t p = 0; p < r->n_problems; p++) {
        const size_t n = ff_verdict_of(r, p, v);
        for (size_t k = 0; k < n; k++) {
            const ff_ink ink = ink_of(&v[k]);
            if (p && is_command(&v[k])) continue; /* once is enough */
            if (ink != FF_INK_PLAIN) fputs(ff_text_ink(color, ink), out);
            if (!is_command(&v[k])) ff_report_problem_text(r, p, out);
            ff_text_print(v[k].text, out);
            if (!is_command(&v[k])) fputc('.', out);
            if (ink != FF_INK_PLAIN) fputs(ff_text_ink(color, FF_INK_PLAIN), out);
            fputc('\n', out);
        }
        fputc('\n', out);
    }
    free(v);
    return FF_OK;
}

ff_status ff_report_verdict_json(ff_json *j, const ff_report_fits *r)
{
    static const char *const name[] = {
#define FF_VERDICT(ID, text) text,
#include "ff_verdicts.def"
#undef FF_VERDICT
    };
    static const char *const quality[] = {NULL, "poor", "fair", "good"};
    ff_verdict *v = calloc(FF_VERDICT_MOST, sizeof *v);
    if (!v) return FF_ERR_MEMORY;
    ff_json_array(j, "verdict", FF_JSON_BLOCK);
    for (size_t p = 0; p < r->n_problems; p++) {
        const size_t n = ff_verdict_of(r, p, v);
        for (size_t k = 0; k < n; k++) {
            ff_json_object(j, NULL, FF_JSON_LINE);
            ff_json_integer(j, "problem", (int64_t)p);
            ff_json_string(j, "code", name[v[k].code]);
            if (v[k].code == FF_VERDICT_QUALITY) ff_json_string(j, "quality", quality[v[k].quality]);
            ff_json_string(j, "text", v[k].text);
            ff_json_close(j);
        }
    }
    ff_json_close(j);
    free(v);
    return FF_OK;
}
