/* facetfit convert --from A --to B name=value: roughness of one convention in terms of another. */
#include "internal_cli.h"
#include "ff_convert.h"
#include <math.h>
#include <string.h>

static const double pi = 3.14159265358979323846;

/* An answer of one conversion; angles in degrees. */
typedef struct answer {
    const ff_conversion *c;
    double in[FF_CONVERSION_VALUES], out[FF_CONVERSION_VALUES];
    const char *doubt;
} answer;

enum { ANSWERS = 8 };

typedef struct answers {
    const cli_args *args;
    size_t n;
    answer at[ANSWERS];
} answers;

static int is_angle(const ff_conversion_value *v)
{
    return !strcmp(v->unit, "rad");
}

/* Name of a value on the command line: an angle says its unit. */
static const char *shown_name(const ff_conversion_value *v)
{
    return is_angle(v) ? "phi_deg" : v->name;
}

/* Half a turn is the same axis; 180 itself is 0. */
static double shown(const ff_conversion_value *v, double x)
{
    if (!is_angle(v)) return x;
    const double degrees = x * 180 / pi;
    return degrees < 180 ? degrees : 0;
}

/* ---- arguments ------------------------------------------------------------------------------- */

static int is_called(const ff_conversion_value *v, const char *word, size_t length)
{
    const char *names[] = {v->name, v->alias, shown_name(v)};
    for (int i = 0; i < 3; i++)
        if (names[i] && strlen(names[i]) == length && !strncmp(names[i], word, length)) return 1;
    return 0;
}

static int read_value(const cli_args *args, const ff_conversion *c, const char *word, double *in, int *given)
{
    const size_t length = strcspn(word, "=");
    if (word[length] != '=') return cli_usage(args, "'%s': expected NAME=VALUE", word);
    for (uint32_t k = 0; k < c->n_in; k++) {
        if (!is_called(&c->in[k], word, length)) continue;
        if (!cli_number_read(word + length + 1, &in[k])) return cli_usage(args, "'%s': expected a number after '='", word);
        if (is_angle(&c->in[k])) in[k] *= pi / 180;
        given[k]++;
        return EXIT_DONE;
    }
    return cli_usage(args, "%s needs %s, not '%.*s'", c->from, shown_name(&c->in[0]), (int)length, word);
}

static int read_values(const cli_args *args, const ff_conversion *c, double *in)
{
    int given[FF_CONVERSION_VALUES] = {0}, status = EXIT_DONE;
    for (size_t i = 0; i < args->n_words && status == EXIT_DONE; i++) status = read_value(args, c, args->word[i], in, given);
    for (uint32_t k = 0; k < c->n_in && status == EXIT_DONE; k++)
        if (given[k] != 1)
            status = cli_usage(args, "%s is %s; expected %s=VALUE once", shown_name(&c->in[k]),
                               given[k] ? "given twice" : "missing", shown_name(&c->in[k]));
    return status;
}

/* ---- answers --------------------------------------------------------------------------------- */

/* What the conversions from `from` (to `to` when that is not NULL) lead to, or are named by, in `out`; 0 when there is none. */
static int list_choices(const char *from, const char *to, char *out, size_t size)
{
    int found = 0;
    *out = '\0';
    for (size_t i = 0; i < ff_conversion_count(); i++) {
        const ff_conversion *c = ff_conversion_at(i);
        if (strcmp(c->from, from) || (to && strcmp(c->to, to))) continue;
        const char *word = to ? c->by : c->to;
        found = 1;
        if (!strstr(out, word)) snprintf(out + strlen(out), size - strlen(out), "%s%s", *out ? ", " : "", word);
    }
    return found;
}

/* "; did you mean 'ggx'?" when a word of the list is near. */
static const char *meant(cli_words *words, const char *word, char out[CLI_NAME])
{
    const char *nearest = cli_words_nearest(words, word, strlen(word));
    snprintf(out, CLI_NAME, "%s%s%s", nearest ? "; did you mean '" : "", nearest ? nearest : "", nearest ? "'?" : "");
    return out;
}

static int unknown_conversion(const cli_args *args, const char *from, const char *to, const char *by)
{
    char names[256], hint[CLI_NAME];
    if (list_choices(from, to, names, sizeof names))
        return *names ? cli_usage(args, "from %s to %s there is no criterion '%s'; known are %s%s", from, to, by, names,
                                  meant(cli_words_by, by, hint))
                      : cli_usage(args, "from %s to %s there is one way only: leave out --by", from, to);
    if (list_choices(from, NULL, names, sizeof names))
        return cli_usage(args, "no conversion from %s to '%s'; %s converts to %s%s", from, to, from, names,
                         meant(cli_words_to, to, hint));
    return cli_usage(args, "no conversion from '%s'; 'facetfit convert --list' shows what there is%s", from,
                     meant(cli_words_from, from, hint));
}

static int find_answers(const cli_args *args, answers *all)
{
    const char *from = cli_value(args, FLAG_FROM, NULL), *to = cli_value(args, FLAG_TO, NULL), *by = cli_value(args, FLAG_BY, NULL);
    if (!from || !to) return cli_usage(args, "--%s is missing", from ? "to" : "from");
    for (int i = ff_conversion_find(from, to, by, 0); i >= 0 && all->n < ANSWERS;
         i = ff_conversion_find(from, to, by, (size_t)i + 1)) {
        answer *a = &all->at[all->n];
        ff_error err = {0};
        a->c = ff_conversion_at((size_t)i);
        const int status = read_values(args, a->c, a->in);
        if (status != EXIT_DONE) return status;
        const ff_status failed = ff_conversion_apply(a->c, a->in, a->out, &err);
        if (failed != FF_OK) return cli_failed(failed, &err);
        a->doubt = ff_conversion_doubt(a->c, a->in, a->out);
        all->n++;
    }
    return all->n ? EXIT_DONE : unknown_conversion(args, from, to, by);
}

static void say_what_it_means(const answers *all)
{
    for (size_t i = 0; i < all->n; i++) {
        const answer *a = &all->at[i];
        cli_message("%s%s%s (%s)", a->c->by, *a->c->by ? ": " : "", a->c->formula, a->c->source);
        cli_message("  assumes: %s", a->c->assumes);
        cli_message("  valid: %s", a->c->limits);
        if (a->doubt) cli_message("  doubtful here: %s", a->doubt);
    }
}

static ff_status write_text(const void *context, FILE *out)
{
    const answers *all = context;
    for (size_t i = 0; i < all->n; i++)
        for (uint32_t k = 0; k < all->at[i].c->n_out; k++) {
            const ff_conversion *c = all->at[i].c;
            char number[FF_REPORT_NUMBER];
            fprintf(out, "%s %s%s%s\n", shown_name(&c->out[k]), ff_report_number(shown(&c->out[k], all->at[i].out[k]), number),
                    all->n > 1 ? " " : "", all->n > 1 ? c->by : "");
        }
    return FF_OK;
}

static void put_values(ff_json *j, const char *key, const ff_conversion_value *v, const double *x, uint32_t n)
{
    ff_json_object(j, key, FF_JSON_LINE);
    for (uint32_t k = 0; k < n; k++) ff_json_number(j, shown_name(&v[k]), shown(&v[k], x[k]));
    ff_json_close(j);
}

static void put_conversion(ff_json *j, const ff_conversion *c)
{
    ff_json_string(j, "from", c->from);
    ff_json_string(j, "to", c->to);
    ff_json_string(j, "by", *c->by ? c->by : NULL);
    ff_json_string(j, "formula", c->formula);
    ff_json_string(j, "source", c->source);
    ff_json_string(j, "assumes", c->assumes);
    ff_json_string(j, "limits", c->limits);
}

static ff_status write_json(const void *context, FILE *out)
{
    const answers *all = context;
    ff_json j;
    ff_json_begin(&j, out);
    ff_json_object(&j, NULL, FF_JSON_BLOCK);
    ff_report_head_json(&j, all->args->command->schema, &all->args->head);
    ff_json_array(&j, "conversions", FF_JSON_BLOCK);
    for (size_t i = 0; i < all->n; i++) {
        const answer *a = &all->at[i];
        ff_json_object(&j, NULL, FF_JSON_BLOCK);
        put_conversion(&j, a->c);
        put_values(&j, "input", a->c->in, a->in, a->c->n_in);
        put_values(&j, "output", a->c->out, a->out, a->c->n_out);
        ff_json_string(&j, "doubt", a->doubt);
        ff_json_close(&j);
    }
    ff_json_close(&j);
    ff_json_close(&j);
    ff_json_end(&j);
    return FF_OK;
}

/* ---- the list -------------------------------------------------------------------------------- */

static ff_status write_list(const void *context, FILE *out)
{
    (void)context;
    for (size_t i = 0; i < ff_conversion_count(); i++) {
        const ff_conversion *c = ff_conversion_at(i);
        fprintf(out, "--from %s --to %s%s%s", c->from, c->to, *c->by ? " --by " : "", c->by);
        for (uint32_t k = 0; k < c->n_in; k++) fprintf(out, " %s=...", shown_name(&c->in[k]));
        fprintf(out, "\n    %s (%s)\n    assumes: %s\n    valid: %s\n", c->formula, c->source, c->assumes, c->limits);
    }
    return FF_OK;
}

static ff_status write_list_json(const void *context, FILE *out)
{
    const cli_args *args = context;
    ff_json j;
    ff_json_begin(&j, out);
    ff_json_object(&j, NULL, FF_JSON_BLOCK);
    ff_report_head_json(&j, args->command->listed, &args->head);
    ff_json_array(&j, "conversions", FF_JSON_BLOCK);
    for (size_t i = 0; i < ff_conversion_count(); i++) {
        ff_json_object(&j, NULL, FF_JSON_BLOCK);
        put_conversion(&j, ff_conversion_at(i));
        ff_json_close(&j);
    }
    ff_json_close(&j);
    ff_json_close(&j);
    ff_json_end(&j);
    return FF_OK;
}

int cmd_convert(const cli_args *args)
{
    answers all = {.args = args};
    if (cli_switch(args, FLAG_LIST, 0) || (args->n_words == 0 && !cli_given(args, FLAG_FROM) && !cli_given(args, FLAG_TO)))
        return cli_write_both(args, write_list_json, write_list, args);
    int status = find_answers(args, &all);
    if (status == EXIT_DONE) status = cli_write_both(args, write_json, write_text, &all);
    if (status == EXIT_DONE) say_what_it_means(&all);
    return status;
}
