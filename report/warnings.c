/* The warnings of a result as people and as programs read them. */
#include "ff_report.h"
#include "internal_text.h"
#include <stdio.h>

/* "f0[r]" where it is of several channels' own. */
static const char *parameter_name(const ff_words_subject *s, const ff_warning_parameter *p,
                                  char own[FF_PARAM_NAME + FF_CHANNEL_NAME + 4])
{
    const char *name = ff_words_parameter(s->fit, p);
    if (p->channel == FF_NO_CHANNEL) return name;
    snprintf(own, FF_PARAM_NAME + FF_CHANNEL_NAME + 4, "%s[%s]", name, ff_problem_channel_name(s->problem, p->channel));
    return own;
}

/* How many warnings from the k-th on are pairs that the data hardly tell apart: more than two of them are said in one line. */
static size_t count_pairs(const ff_warnings *w, size_t k)
{
    size_t n = 0;
    while (k + n < w->n && w->item[k + n].code == FF_WARNING_CORRELATED && w->item[k + n].n_parameters == 2) n++;
    return n;
}

static void put_pairs(const ff_words_subject *s, const ff_warning *w, size_t n, FILE *out)
{
    char a[FF_PARAM_NAME + FF_CHANNEL_NAME + 4], b[FF_PARAM_NAME + FF_CHANNEL_NAME + 4], number[FF_TEXT_NUMBER];
    fprintf(out, "  %s: %zu pairs of parameters are hardly told apart by these data (correlations of their errors):",
            ff_severity_name((int)w->severity), n);
    for (size_t k = 0; k < n; k++) {
        fputs(k ? ", " : " ", out);
        ff_text_print(parameter_name(s, &w[k].parameter[0], a), out);
        fputs(" and ", out);
        ff_text_print(parameter_name(s, &w[k].parameter[1], b), out);
        fprintf(out, " %s", ff_text_fixed(w[k].value[0], 3, number));
    }
    fputc('\n', out);
}

void ff_report_warnings_text(const ff_words_subject *s, const ff_warnings *w, FILE *out)
{
    enum { MANY = 3 };
    char text[FF_WORDS_SENTENCE];
    for (size_t k = 0; k < w->n; k++) {
        const size_t pairs = count_pairs(w, k);
        if (pairs >= MANY) {
            put_pairs(s, &w->item[k], pairs, out);
            k += pairs - 1;
            continue;
        }
        fputs("  warning: ", out);
        ff_text_print(ff_words_warning(s, &w->item[k], text), out);
        fputc('\n', out);
    }
}

static void put_parameter(ff_json *j, const char *key, const ff_words_subject *s, const ff_warning_parameter *p)
{
    char own[FF_PARAM_NAME + FF_CHANNEL_NAME + 4];
    ff_json_string(j, key, parameter_name(s, p, own));
}

static void put_parameters(ff_json *j, const ff_words_subject *s, const ff_warning *w)
{
    if (w->n_parameters == 1) put_parameter(j, "parameter", s, &w->parameter[0]);
    if (w->n_parameters < 2) return;
    ff_json_array(j, "parameters", FF_JSON_LINE);
    for (size_t k = 0; k < w->n_parameters; k++) put_parameter(j, NULL, s, &w->parameter[k]);
    ff_json_close(j);
}

static void put_channels(ff_json *j, const ff_words_subject *s, const ff_warning *w)
{
    if (w->n_channels == 1) ff_json_string(j, "channel", ff_problem_channel_name(s->problem, w->channel[0]));
    if (w->n_channels < 2) return;
    ff_json_array(j, "channels", FF_JSON_LINE);
    for (size_t k = 0; k < w->n_channels; k++) ff_json_string(j, NULL, ff_problem_channel_name(s->problem, w->channel[k]));
    ff_json_close(j);
}

static void put_warning(ff_json *j, const ff_words_subject *s, const ff_warning *w)
{
    const ff_warning_kind *kind = ff_warning_kind_of((int)w->code);
    char text[FF_WORDS_SENTENCE];
    ff_json_object(j, NULL, FF_JSON_LINE);
    ff_json_string(j, "code", kind->name);
    ff_json_string(j, "severity", ff_severity_name((int)w->severity));
    put_parameters(j, s, w);
    put_channels(j, s, w);
    ff_json_object(j, "values", FF_JSON_LINE);
    for (size_t k = 0; k < FF_WARNING_VALUES && kind->value[k]; k++) ff_json_number(j, kind->value[k], w->value[k]);
    ff_json_close(j);
    ff_json_string(j, "text", ff_words_warning(s, w, text));
    ff_json_close(j);
}

void ff_report_warnings_json(ff_json *j, const ff_words_subject *s, const ff_warnings *w)
{
    ff_json_array(j, "warnings", FF_JSON_BLOCK);
    for (size_t k = 0; k < w->n; k++) put_warning(j, s, &w->item[k]);
    ff_json_close(j);
}
