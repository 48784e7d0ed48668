/* Controls of renderers with the errors of a fit. */
#include "internal_controls.h"
#include <math.h>
#include <string.h>

/* The parameters that a control rests on, each once: what follows another one counts as that one. */
typedef struct sources {
    size_t n;
    ff_param_ref ref[FF_FORMULA_INPUTS];
    size_t channel[FF_FORMULA_INPUTS];
    const ff_fit_value *value[FF_FORMULA_INPUTS];
    double slope[FF_FORMULA_INPUTS];
    size_t of_input[FF_FORMULA_INPUTS]; /* number of the source of each input; n: it is held */
} sources;

static void add_source(sources *s, const ff_fit_result *fit, size_t input, ff_param_ref ref, size_t c, double slope)
{
    const ff_fit_value *v = ff_fit_result_at(fit, ref, c);
    if (v->tied) {
        ref = v->follows;
        c = v->follows_channel;
        v = ff_fit_result_at(fit, ref, c);
    }
    s->of_input[input] = FF_FORMULA_INPUTS;
    if (v->held) return;
    for (size_t i = 0; i < s->n; i++)
        if (s->value[i] == v) {
            s->slope[i] += slope;
            s->of_input[input] = i;
            return;
        }
    s->of_input[input] = s->n;
    s->ref[s->n] = ref;
    s->channel[s->n] = c;
    s->value[s->n] = v;
    s->slope[s->n++] = slope;
}

static sources sources_of(const ff_control *k, const ff_fit_result *fit, size_t c, const ff_param_ref *ref, const double *d)
{
    sources s = {.n = 0};
    for (size_t i = 0; i < FF_FORMULA_INPUTS && k->made.of[i]; i++) add_source(&s, fit, i, ref[i], k->is_color ? c : 0, d[i]);
    return s;
}

/* NaN where one that counts has no error. */
static double error_of(const sources *s, const ff_fit_result *fit)
{
    double variance = 0;
    size_t n = 0;
    for (size_t i = 0; i < s->n; i++) {
        if (s->slope[i] == 0) continue;
        n++;
        for (size_t j = 0; j < s->n; j++) {
            if (s->slope[j] == 0) continue;
            const double both = i == j ? 1 : ff_fit_result_correlation(fit, s->ref[i], s->channel[i], s->ref[j], s->channel[j]);
            variance += s->slope[i] * s->slope[j] * s->value[i]->std_error * s->value[j]->std_error * both;
        }
    }
    return n ? sqrt(fmax(variance, 0) + (isnan(variance) ? NAN : 0)) : NAN;
}

/* The control with its one source at x. */
static double value_with(const ff_control *k, const ff_fit_result *fit, size_t c, const sources *s, const ff_param_ref *ref,
                         double x)
{
    double input[FF_FORMULA_INPUTS] = {0};
    for (size_t i = 0; i < FF_FORMULA_INPUTS && k->made.of[i]; i++)
        input[i] = s->of_input[i] < s->n ? x : ff_fit_result_at(fit, ref[i], k->is_color ? c : 0)->value;
    return k->made.value(input, NULL);
}

static void set_interval(const ff_control *k, const ff_fit_result *fit, size_t c, const sources *s, const ff_param_ref *ref,
                         ff_control_estimate *e)
{
    e->low = e->high = NAN;
    if (s->n == 1 && s->value[0]->interval != FF_INTERVAL_NONE) {
        const double a = value_with(k, fit, c, s, ref, s->value[0]->low), b = value_with(k, fit, c, s, ref, s->value[0]->high);
        e->low = fmin(a, b);
        e->high = fmax(a, b);
        return;
    }
    double t = 0;
    for (size_t i = 0; i < s->n; i++) t = fmax(t, s->value[i]->student_t);
    if (isnan(e->std_error) || t <= 0) return;
    e->low = e->value - t * e->std_error;
    e->high = e->value + t * e->std_error;
}

ff_control_estimate ff_control_estimate_of(const ff_control *k, const ff_fit_result *fit, size_t c)
{
    ff_param_ref ref[FF_FORMULA_INPUTS];
    double d[FF_FORMULA_INPUTS], x[FF_FORMULA_INPUTS] = {0};
    for (size_t i = 0; i < FF_FORMULA_INPUTS; i++) {
        ref[i] = k->made.of[i] ? ff_model_param_find(&fit->model, k->made.of[i]) : (ff_param_ref){FF_PARAM_NONE, 0};
        d[i] = 0;
        if (ref[i].kind != FF_PARAM_NONE) x[i] = ff_fit_result_at(fit, ref[i], k->is_color ? c : 0)->value;
    }
    ff_control_estimate e = {.value = k->made.value(x, d)};
    const sources s = sources_of(k, fit, c, ref, d);
    const double slack = 1e-9 * (k->hi - k->lo < 1e6 ? k->hi - k->lo : 1);
    e.held = s.n == 0;
    e.at_bound = s.n == 1 ? s.value[0]->at_bound : 0;
    e.std_error = e.at_bound ? NAN : error_of(&s, fit);
    e.beyond = e.value < k->lo - slack ? -1 : e.value > k->hi + slack ? 1 : 0;
    set_interval(k, fit, c, &s, ref, &e);
    return e;
}

/* ---- where it falls short --------------------------------------------------------------------- */

size_t ff_shortfalls_find(const ff_bands *fit, const ff_bands *other, double least, size_t most, ff_shortfall *out)
{
    static const int places[] = {FF_PLACE_THETA_I, FF_PLACE_THETA_H};
    size_t n = 0;
    for (size_t p = 0; p < sizeof places / sizeof *places; p++)
        for (int b = 0; b < FF_BANDS; b++) {
            const ff_band *x = &fit->band[places[p]][b], *y = &other->band[places[p]][b];
            const ff_shortfall found = {places[p], b, x->mean, x->rms, y->rms};
            size_t at = n < most ? n : most;
            if (!(x->n && x->rms - y->rms > least)) continue;
            while (at > 0 && out[at - 1].rms - out[at - 1].free_rms < x->rms - y->rms) {
                if (at < most) out[at] = out[at - 1];
                at--;
            }
            if (at < most) out[at] = found;
            if (n < most) n++;
        }
    return n;
}
