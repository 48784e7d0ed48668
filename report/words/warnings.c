/* The sentence of every warning. */
#define _GNU_SOURCE
#include "words_struct.h"
#include <locale.h>
#include <stdarg.h>
#include <stdio.h>

/* A sentence in the making. */
typedef struct sentence {
    const ff_words_subject *of;
    const ff_warning *w;
    char *out;
    size_t used;
} sentence;

static void put(sentence *s, const char *fmt, ...) __attribute__((format(printf, 2, 3)));
static void put(sentence *s, const char *fmt, ...)
{
    const size_t left = FF_WORDS_SENTENCE - s->used;
    va_list args;
    va_start(args, fmt);
    const int n = vsnprintf(s->out + s->used, left, fmt, args);
    va_end(args);
    if (n < 0) return;
    s->used += (size_t)n < left ? (size_t)n : left - 1;
}

/* ---- parameters and channels ----------------------------------------------------------------- */

/* Up to this many channels in all, each is named. */
enum { NAMED = 8 };

static size_t channels_in_all(const sentence *s)
{
    return s->of->fit ? s->of->fit->n_channels : s->of->retrieved->n_channels;
}

static const char *channel_name(const sentence *s, size_t c)
{
    return ff_problem_channel_name(s->of->problem, c);
}

static const ff_model_param *param_of(const ff_fit_result *fit, const ff_warning_parameter *p)
{
    return ff_model_param_at(&fit->model, p->parameter);
}

const char *ff_words_parameter(const ff_fit_result *fit, const ff_warning_parameter *p)
{
    return param_of(fit, p)->name;
}

/* "400nm, 410nm", or where there are many, "31 of 121 channels, 400nm to 700nm". */
static void put_channels(sentence *s)
{
    const ff_warning *w = s->w;
    const size_t all = channels_in_all(s);
    if (all > NAMED && w->n_channels > 3) {
        put(s, "%zu of %zu channels, %s to %s", w->n_channels, all, channel_name(s, w->channel[0]),
            channel_name(s, w->channel[w->n_channels - 1]));
        return;
    }
    for (size_t k = 0; k < w->n_channels; k++) put(s, "%s%s", k ? ", " : "", channel_name(s, w->channel[k]));
}

/* "f0", "f0[r]" */
static void put_parameter(sentence *s, size_t k)
{
    const ff_warning_parameter *p = &s->w->parameter[k];
    put(s, "%s", ff_words_parameter(s->of->fit, p));
    if (p->channel != FF_NO_CHANNEL) put(s, "[%s]", channel_name(s, p->channel));
}

/* Those of the warning, with the channels in which it is so. */
static void put_parameters(sentence *s, const char *between)
{
    for (size_t k = 0; k < s->w->n_parameters; k++) {
        if (k) put(s, "%s", between);
        put_parameter(s, k);
    }
    if (s->w->n_channels == 0) return;
    const int one = s->w->n_parameters == 1 && s->w->n_channels == 1; /* as tables have it */
    put(s, one ? "[" : " (");
    put_channels(s);
    put(s, one ? "]" : ")");
}

/* ---- of fits --------------------------------------------------------------------------------- */

static void iteration_limit(sentence *s)
{
    put(s, "stopped after %.0f iterations before it converged; --max-iterations allows more", s->w->value[0]);
}

static void lower_objective(sentence *s)
{
    put(s, "the profile met an objective that is lower by %.2g of itself: the fit is not the best one", s->w->value[0]);
}

static void at_bound(sentence *s)
{
    const double *v = s->w->value;
    put_parameters(s, ", ");
    put(s, " is on %s %s bound, %g", v[2] != 0 ? "the given" : "its", v[1] < 0 ? "lower" : "upper", v[0]);
}

/* A profile is for parameters that are looked at one by one. */
static void not_determined(sentence *s)
{
    const int one = s->w->n_channels == 0 || channels_in_all(s) <= NAMED;
    put_parameters(s, ", ");
    if (s->w->value[0] != 0) {
        put(s, " is not determined by these data: what it belongs to reflects nothing here");
        return;
    }
    put(s, " is not determined by these data%s", one ? "; --profile says how far it may go" : "");
}

static void correlated(sentence *s)
{
    put_parameters(s, " and ");
    put(s, " are correlated by %s%.4f: these data hardly tell them apart", s->w->n_channels ? "up to " : "", s->w->value[0]);
}

static void trade_off(sentence *s)
{
    put_parameters(s, ", ");
    put(s, " trade off: along one combination of them the data say %.0f times less than of each alone", s->w->value[0]);
}

static void few_carriers(sentence *s)
{
    put_parameters(s, ", ");
    put(s,
        " rest%s on fewer than three values (N): where one of these is wrong, so are they; by the residuals alone (HC3) the "
        "standard error of ",
        s->w->n_parameters == 1 ? "s" : "");
    if (s->w->n_parameters > 0) put_parameter(s, 0);
    put(s, " is %.2g%s", s->w->value[1], s->w->value[2] > 0 ? "" : "; --weight noise lets all values have a say");
}

static void one_incidence(sentence *s)
{
    put_parameters(s, ", ");
    put(s, " rest%s on one incident direction alone: without it the data do not determine %s, and no error can be given",
        s->w->n_parameters == 1 ? "s" : "", s->w->n_parameters == 1 ? "it" : "them");
}

static void combination_not_determined(sentence *s)
{
    put_parameters(s, ", ");
    put(s, " trade off: of one combination of them the data say nothing");
}

static void prior_without_effect(sentence *s)
{
    put(s, "the prior of ");
    put_parameters(s, ", ");
    put(s, " has no effect: it is held");
}

static void prior_disagrees(sentence *s)
{
    const double *v = s->w->value;
    put(s, "data and prior disagree about ");
    put_parameters(s, ", ");
    put(s, ": by the data alone it is %.5g +- %.2g, the prior says %.5g +- %.2g", v[0], v[1], v[2], v[3]);
}

static void albedo_above_one(sentence *s)
{
    const double *v = s->w->value;
    put(s, "the data alone ask for an albedo");
    if (s->w->n_channels) put(s, " of channel %s", channel_name(s, s->w->channel[0]));
    put(s, " of %.4g at %.3g degrees; conserving energy makes the objective %.4g times theirs", v[0], v[1], v[2]);
}

static void energy_not_conserved(sentence *s)
{
    put(s, "the albedo still exceeds 1 by %.2g: no parameters in their bounds were found that conserve energy", s->w->value[0]);
}

static void errors_too_small(sentence *s)
{
    put(s,
        "the residuals go together over more than %.0f neighbouring samples, as far as can be seen: the true errors are larger "
        "than "
        "the standard errors",
        s->w->value[0]);
}

static void saturated(sentence *s)
{
    const double *v = s->w->value;
    put(s, "%.0f samples at different places share the largest value, %g: is the detector saturated? --saturation %g says so", v[0],
        v[1], v[1]);
}

static void dark_channel(sentence *s)
{
    const int one = channels_in_all(s) <= NAMED;
    put(s, one ? "channel " : "channels that are zero everywhere (");
    put_channels(s);
    put(s, one ? " is zero everywhere, which no lobe is: it pulls the shape of the others; --channels each keeps them apart"
               : "), which no lobe is, pull the shape of the others; --channels each keeps them apart");
}

static void negative_values(sentence *s)
{
    put(s, "%.0f of the samples have negative values; they are kept as noise", s->w->value[0]);
}

static void copies(sentence *s)
{
    put(s,
        "%.0f samples repeat another one, directions and values to the last digit: a copy is no measurement, and they are left out",
        s->w->value[0]);
}

static void brightest_elsewhere(sentence *s)
{
    put(s, "the brightest samples lie %s, at %.0f incidences and at none about the mirror direction: %s",
        ff_words_side((ff_side)s->w->value[1]), s->w->value[0], ff_words_side_hint((ff_side)s->w->value[1]));
}

static void sigma_mismatch(sentence *s)
{
    put(s,
        "chi^2 per degree of freedom is %.3g: the standard deviations of the data do not match the residuals, and the standard "
        "errors follow them",
        s->w->value[0]);
}

static void few_pixels(sentence *s)
{
    const double *v = s->w->value;
    put(s, "the loss was chosen by few pixels: the data cover %.0f of %.0f of the pictures of a lit sphere", v[0], v[1]);
}

/* ---- of retrieved distributions -------------------------------------------------------------- */

static void parametric_start(sentence *s)
{
    put(s,
        "these data have %.0f samples that look back along the light, too few for the power iteration: the start is the best "
        "parametric fit",
        s->w->value[0]);
}

static void peak_continued(sentence *s)
{
    put(s, "no half vector is nearer to the normal than %.3g degrees: the peak of D is the smooth continuation to there",
        s->w->value[0]);
}

/* What D is where it is not known. */
static void put_guess(sentence *s)
{
    const ff_ndf_result *r = s->of->retrieved;
    put(s, " (standard error above %.0f %%): it follows %s as far as the data let it", 100 * FF_NDF_KNOWN,
        ff_term_at(FF_NDF, (size_t)r->fit[r->reference].model.lobe[0].ndf)->name);
}

static void tail_uncertain(sentence *s)
{
    put(s, "beyond %.3g degrees D is not known", s->w->value[0]);
    put_guess(s);
}

static void d_not_known(sentence *s)
{
    put(s, "from %.3g to %.3g degrees D is not known", s->w->value[0], s->w->value[1]);
    put_guess(s);
}

static void tail_continued(sentence *s)
{
    const double *v = s->w->value;
    put(s, "no half vector lies beyond %.3g degrees: D goes on ", v[0]);
    if (v[1] != 0)
        put(s, "from there as tan(theta)^%.3g", v[1]);
    else
        put(s, "level from there");
    if (!(v[2] > 0.01)) put(s, ", with less than 1 %% of the area");
}

static void area_beyond_data(sentence *s)
{
    put(s, "%.2g %% of the projected area lies beyond the data: F0 and the masking depend on that continuation",
        100 * s->w->value[0]);
}

static void narrow_lobe(sentence *s)
{
    const double *v = s->w->value;
    put_parameters(s, ", ");
    put(s, ": the lobe is %.2g degrees wide at half its height, ", v[0]);
    if (v[1] > 0 && v[0] < 2 * v[1])
        put(s, "and samples are %.2g degrees apart there", v[1]);
    else
        put(s, "of which a detector of 1.5 degrees across makes %.2g %%; name yours by half its angle, as in --aperture 0.75",
            100 * v[2]);
    put(s, ": the roughness is an upper bound");
}

static void slopes_kept_level(sentence *s)
{
    const double *v = s->w->value;
    put(s, "the data would have the density of slopes rise from %.3g to %.3g degrees; it is kept level there", v[0], v[1]);
}

static void d_kept_level(sentence *s)
{
    const double *v = s->w->value;
    put(s,
        "the data would have D rise from %.3g to %.3g degrees; it is kept level there (the default, --monotone slopes, lets D "
        "rise)",
        v[0], v[1]);
}

/* ---- all ------------------------------------------------------------------------------------- */

/* Either a sentence that is always the same, or what makes it. */
typedef struct words {
    const char *same;
    void (*say)(sentence *s);
} words;

static const words of[FF_WARNING_COUNT] = {
    [FF_WARNING_ITERATION_LIMIT] = {NULL, iteration_limit},
    [FF_WARNING_STALLED] = {"the solver found no step that lowers the objective; the parameters may not be the best ones", NULL},
    [FF_WARNING_LOWER_OBJECTIVE] = {NULL, lower_objective},
    [FF_WARNING_AT_BOUND] = {NULL, at_bound},
    [FF_WARNING_NOT_DETERMINED] = {NULL, not_determined},
    [FF_WARNING_CORRELATED] = {NULL, correlated},
    [FF_WARNING_TRADE_OFF] = {NULL, trade_off},
    [FF_WARNING_FEW_CARRIERS] = {NULL, few_carriers},
    [FF_WARNING_ONE_INCIDENCE] = {NULL, one_incidence},
    [FF_WARNING_COMBINATION_NOT_DETERMINED] = {NULL, combination_not_determined},
    [FF_WARNING_ORIENTATION_NOT_DETERMINED] =
        {"the two roughness axes differ by less than their error: the orientation is undetermined", NULL},
    [FF_WARNING_PRIOR_WITHOUT_EFFECT] = {NULL, prior_without_effect},
    [FF_WARNING_PRIOR_DISAGREES] = {NULL, prior_disagrees},
    [FF_WARNING_ALBEDO_ABOVE_ONE] = {NULL, albedo_above_one},
    [FF_WARNING_ENERGY_NOT_CONSERVED] = {NULL, energy_not_conserved},
    [FF_WARNING_ERRORS_TOO_SMALL] = {NULL, errors_too_small},
    [FF_WARNING_SATURATED] = {NULL, saturated},
    [FF_WARNING_DARK_CHANNEL] = {NULL, dark_channel},
    [FF_WARNING_NEGATIVE_VALUES] = {NULL, negative_values},
    [FF_WARNING_SIGMA_MISMATCH] = {NULL, sigma_mismatch},
    [FF_WARNING_FEW_PIXELS] = {NULL, few_pixels},
    [FF_WARNING_RETRIEVAL_NOT_CONVERGED] = {"the minimisation stopped before it converged: D may not be the best one", NULL},
    [FF_WARNING_PARAMETRIC_START] = {NULL, parametric_start},
    [FF_WARNING_PEAK_CONTINUED] = {NULL, peak_continued},
    [FF_WARNING_TAIL_UNCERTAIN] = {NULL, tail_uncertain},
    [FF_WARNING_NARROW_LOBE] = {NULL, narrow_lobe},
    [FF_WARNING_D_NOT_KNOWN] = {NULL, d_not_known},
    [FF_WARNING_TAIL_CONTINUED] = {NULL, tail_continued},
    [FF_WARNING_AREA_BEYOND_DATA] = {NULL, area_beyond_data},
    [FF_WARNING_SLOPES_KEPT_LEVEL] = {NULL, slopes_kept_level},
    [FF_WARNING_D_KEPT_LEVEL] = {NULL, d_kept_level},
    [FF_WARNING_SCALE_ABOVE_ONE] = {"the data ask for F0 > 1: F = 1 and a scale ks instead, in all fits; are the data in 1/sr?",
                                    NULL},
    [FF_WARNING_BRIGHTEST_ELSEWHERE] = {NULL, brightest_elsewhere},
    [FF_WARNING_COPIES] = {NULL, copies},
    [FF_WARNING_NOTHING_TO_FIT] = {"all data are 0: there is nothing to fit", NULL},
    [FF_WARNING_DIRECTION_AVERAGED] =
        {"these data may show a direction; D is isotropic, the mean over the azimuths as the samples have them", NULL},
};

/* With a decimal point whatever the program's locale is. */
const char *ff_words_warning(const ff_words_subject *s, const ff_warning *w, char out[FF_WORDS_SENTENCE])
{
    sentence made = {s, w, out, 0};
    const locale_t c_locale = newlocale(LC_ALL_MASK, "C", (locale_t)0);
    const locale_t previous = c_locale ? uselocale(c_locale) : (locale_t)0;
    out[0] = '\0';
    if (of[w->code].say)
        of[w->code].say(&made);
    else
        put(&made, "%s", of[w->code].same);
    if (c_locale) {
        uselocale(previous);
        freelocale(c_locale);
    }
    return out;
}

static size_t say(const ff_words_subject *s, const ff_warning *w, char *out, size_t size)
{
    char whole[FF_WORDS_SENTENCE];
    ff_words_warning(s, w, whole);
    return (size_t)snprintf(out, size, "%s", whole);
}

size_t ff_words_fit_warning(const ff_problem *p, const ff_fit_result *fit, const ff_warning *w, char *out, size_t size)
{
    return say(&(ff_words_subject){.problem = p, .fit = fit}, w, out, size);
}

size_t ff_words_ndf_warning(const ff_problem *p, const ff_ndf_result *retrieved, const ff_warning *w, char *out, size_t size)
{
    return say(&(ff_words_subject){.problem = p, .retrieved = retrieved}, w, out, size);
}
