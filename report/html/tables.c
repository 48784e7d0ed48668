/* What a page says in words and tables. */
#include "internal_html.h"
#include "report/internal_fits_text.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- verdict --------------------------------------------------------------------------------- */

/* The part of the page that shows what a warning is about; "" for none. */
static const char *place_of(ff_warning_code code)
{
    switch (code) {
    case FF_WARNING_ALBEDO_ABOVE_ONE:
    case FF_WARNING_ENERGY_NOT_CONSERVED:
        return "albedo";
    case FF_WARNING_SATURATED:
    case FF_WARNING_DARK_CHANNEL:
    case FF_WARNING_NEGATIVE_VALUES:
    case FF_WARNING_COPIES:
    case FF_WARNING_NOTHING_TO_FIT:
    case FF_WARNING_BRIGHTEST_ELSEWHERE:
    case FF_WARNING_ONE_INCIDENCE:
        return "coverage";
    case FF_WARNING_NARROW_LOBE:
        return "profile";
    case FF_WARNING_FEW_PIXELS:
        return "spheres";
    default:
        return "parameters";
    }
}

static const char *place_of_verdict(ff_verdict_code code, int compared)
{
    switch (code) {
    case FF_VERDICT_QUALITY:
        return "residuals";
    case FF_VERDICT_PREFERENCE:
    case FF_VERDICT_NO_TEST:
    case FF_VERDICT_NOT_TOLD:
        return compared ? "ranking" : "parameters";
    case FF_VERDICT_MEASURE:
        return compared ? "differ" : "coverage";
    case FF_VERDICT_NEXT:
        return "reproduce";
    default:
        return "parameters";
    }
}

static const char *mood_of(const ff_verdict *v)
{
    static const char *const of[] = {
        [FF_QUALITY_POOR] = "bad", [FF_QUALITY_FAIR] = "warning", [FF_QUALITY_GOOD] = "good", [FF_QUALITY_UNKNOWN] = "plain"};
    if (v->code == FF_VERDICT_NOT_CONVERGED || v->code == FF_VERDICT_NOTHING_FOUND) return "bad";
    return v->code == FF_VERDICT_QUALITY ? of[v->quality] : "plain";
}

static void put_alert(ff_page *p, const char *mood, const char *place, const char *before, const char *text)
{
    static const char *const name[][2] = {{"bad", "Problem: "}, {"warning", "Warning: "}, {"note", "Note: "}};
    ff_page_format(p, "<li class=\"%s\">", mood);
    if (!strcmp(before, "alert"))
        for (size_t k = 0; k < 3; k++)
            if (!strcmp(mood, name[k][0])) ff_page_format(p, "<strong>%s</strong>", name[k][1]);
    if (strcmp(before, "alert")) ff_page_text(p, before);
    ff_page_text(p, text);
    ff_page_format(p, " <a href=\"#%s\">%s</a></li>\n", place, place);
}

static void put_verdicts(ff_page *p, const ff_html_subject *s, size_t problem)
{
    ff_verdict *v = calloc(FF_VERDICT_MOST, sizeof *v);
    char before[FF_CHANNEL_NAME + 16] = "";
    if (!v) {
        ff_page_fail(p, FF_ERR_MEMORY);
        return;
    }
    const size_t n = ff_verdict_of(s->r, problem, v);
    if (s->r->n_problems > 1) snprintf(before, sizeof before, "channel %s: ", ff_problem_channel_name(s->r->problem[problem], 0));
    for (size_t k = 0; k < n; k++) {
        if (problem && v[k].code == FF_VERDICT_NEXT) continue;
        put_alert(p, mood_of(&v[k]), place_of_verdict(v[k].code, s->models > 1), v[k].code == FF_VERDICT_NEXT ? "" : before,
                  v[k].text);
    }
    free(v);
}

static void put_warnings(ff_page *p, const ff_html_subject *s, size_t fit)
{
    const ff_warnings *w = &s->r->fit[fit].warnings;
    const ff_words_subject subject = {.problem = s->r->problem[fit / s->models], .fit = &s->r->fit[fit]};
    char text[FF_WORDS_SENTENCE];
    for (size_t k = 0; k < w->n; k++) {
        const char *mood = w->item[k].severity == FF_SEVERITY_PROBLEM   ? "bad"
                           : w->item[k].severity == FF_SEVERITY_WARNING ? "warning"
                                                                        : "note";
        put_alert(p, mood, place_of(w->item[k].code), "alert", ff_words_warning(&subject, &w->item[k], text));
    }
}

void ff_html_verdict(ff_page *p, const ff_html_subject *s)
{
    ff_page_section(p, "verdict", "Verdict");
    ff_page_format(p, "<ul class=\"alerts\">\n");
    for (size_t k = 0; k < s->r->n_problems; k++) put_verdicts(p, s, k);
    if (s->models <= 1)
        for (size_t k = 0; k < s->r->n_fits; k++) put_warnings(p, s, k);
    else
        put_warnings(p, s, s->shown);
    ff_page_format(p, "</ul>\n");
    ff_page_section_end(p);
}

/* ---- parameters ------------------------------------------------------------------------------ */

static void put_head(ff_page *p, const char *const *head, size_t n)
{
    ff_page_format(p, "<thead><tr>");
    for (size_t k = 0; k < n; k++) {
        ff_page_format(p, "<th scope=\"col\">");
        ff_page_text(p, head[k]);
        ff_page_format(p, "</th>");
    }
    ff_page_format(p, "</tr></thead>\n<tbody>\n");
}

static void put_number(ff_page *p, double x, int digits)
{
    char text[FF_TEXT_NUMBER];
    if (isfinite(x)) ff_page_text(p, ff_text_number(x, digits, text));
}

static const char *remark(const ff_fit_value *v)
{
    return v->tied         ? "tied"
           : v->weightless ? "not determined"
           : v->at_bound   ? (v->at_bound < 0 ? "on its lower bound" : "on its upper bound")
           : v->held       ? "held"
                           : "";
}

static void put_parameter(ff_page *p, const char *name, const ff_model_param *param, const ff_fit_value *v, size_t channel)
{
    char value[FF_TEXT_NUMBER], error[FF_TEXT_NUMBER];
    ff_text_with_error(v->value, v->held || v->tied || v->at_bound ? NAN : v->std_error, value, error);
    ff_page_format(p, "<tr data-name=\"");
    ff_page_text(p, param->name);
    ff_page_format(p, "\" data-channel=\"%zu\"><th scope=\"row\">", channel);
    ff_page_text(p, name);
    ff_page_format(p, "</th><td>%s</td><td>%s</td><td>", value, error);
    if (isfinite(v->low)) {
        put_number(p, v->low, 4);
        ff_page_format(p, " to ");
        put_number(p, v->high, 4);
    }
    ff_page_format(p, "</td><td>");
    put_number(p, param->lo, 4);
    ff_page_format(p, " to ");
    put_number(p, param->hi, 4);
    ff_page_format(p, "</td><td class=\"start\"></td><td>");
    ff_page_text(p, strcmp(param->info->unit, "1") ? param->info->unit : "");
    ff_page_format(p, "</td><td>%s</td><td>", remark(v));
    ff_page_text(p, param->info->meaning);
    ff_page_format(p, "</td></tr>\n");
}

void ff_html_parameters(ff_page *p, const ff_html_subject *s, size_t fit)
{
    static const char *const head[] = {"parameter", "value", "standard error", "95 % interval", "bounds",
                                       "start",     "unit",  "remark",         "meaning"};
    const ff_fit_result *f = &s->r->fit[fit];
    char name[FF_REPORT_NAME];
    ff_page_format(p,
                   "<div class=\"scroll\" tabindex=\"0\" role=\"region\" aria-label=\"Values of fit %zu\"><table "
                   "class=\"parameters\"><caption>",
                   fit + 1);
    ff_page_text(p, s->model[fit].label);
    ff_page_format(p, "</caption>\n");
    put_head(p, head, sizeof head / sizeof *head);
    for (uint32_t k = 0; k < f->model.n_shape; k++)
        if (!ff_report_left_alone(&f->shape_value[k], f->model.shape[k].info))
            put_parameter(p, f->model.shape[k].name, &f->model.shape[k], &f->shape_value[k], 0);
    for (uint32_t k = 0; k < f->model.n_channel; k++)
        for (size_t c = 0; c < f->n_channels; c++) {
            const ff_fit_value *v = &f->channel_value[c * f->model.n_channel + k];
            if (!ff_report_left_alone(v, f->model.channel[k].info))
                put_parameter(p, ff_report_channel_param(s->r->problem[fit / s->models], f, k, c, name), &f->model.channel[k], v,
                              c);
        }
    ff_page_format(p, "</tbody></table></div>\n");
}

/* ---- data ------------------------------------------------------------------------------------ */

static void put_count(ff_page *p, const char *what, size_t n, const char *why)
{
    if (!n) return;
    ff_page_format(p, "<tr><th scope=\"row\">%s</th><td>%zu</td><td>", what, n);
    ff_page_text(p, why);
    ff_page_format(p, "</td></tr>\n");
}

void ff_html_left_out(ff_page *p, const ff_html_subject *s)
{
    const ff_selection *of = ff_problem_selected(s->r->problem[0]);
    static const char *const head[] = {"samples", "number", "why"};
    char limit[FF_TEXT_NUMBER], why[128];
    snprintf(why, sizeof why, "light or view is further than %s degrees from the normal: --max-theta",
             ff_text_number(ff_report_degrees(s->r->options->max_theta), 4, limit));
    ff_page_format(p, "<table class=\"left-out\"><caption>Samples, and why some were left out</caption>\n");
    put_head(p, head, 3);
    put_count(p, "in the file", of->samples, "");
    put_count(p, "used", of->used, "");
    put_count(p, "invalid", of->invalid, "the file marks them, or they are not finite");
    put_count(p, "below the horizon", of->below_horizon, "light or view is at or under it");
    put_count(p, "grazing", of->grazing, why);
    put_count(p, "negative", of->dropped, "--negative drop");
    put_count(p, "copies", of->copies, "the directions and values of another sample");
    put_count(p, "saturated values", of->saturated, "used as at least so much: --saturation");
    put_count(p, "values below the noise", of->below_noise, "used as at most so much: --noise-floor");
    ff_page_format(p, "</tbody></table>\n");
}

static ff_status write_references(const void *s, FILE *out)
{
    return ff_html_references(s, out);
}

static ff_status write_command(const void *context, FILE *out)
{
    const ff_html_subject *s = context;
    ff_page_put_command(&s->r->head, s->sha256, out);
    return FF_OK;
}

void ff_html_reproduce(ff_page *p, const ff_html_subject *s)
{
    ff_page_section(p, "reproduce", "Reproduce");
    ff_page_block(p, "Command", write_command, s);
    ff_html_left_out(p, s);
    ff_page_format(p, "<h3>References of the models</h3>\n");
    ff_page_block(p, "BibTeX", write_references, s);
    ff_page_section_end(p);
}
