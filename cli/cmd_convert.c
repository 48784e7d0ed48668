/* facetfit convert --from A --to B name=value: roughness of one convention in terms of another. */
#include "internal_cli.h"
#include "ff_convert.h"
#include <stdlib.h>
#include <string.h>

static const double pi = 3.14159265358979323846;

enum { ANSWERS = 16, CHANNELS = 64, TEXT = 1024 };

/* An answer along one way; angles in radians. */
typedef struct answer {
    ff_conversion_path path;
    double in[CHANNELS][FF_CONVERSION_VALUES], out[CHANNELS][FF_CONVERSION_VALUES];
    const char *doubt; /* of the first channel that has one; NULL without */
} answer;

typedef struct answers {
    const cli_args *args;
    const char *from, *to;
    size_t n, n_channels;
    answer *at;
} answers;

static const ff_conversion *first_of(const answer *a)
{
    return a->path.step[0];
}

static const ff_conversion *last_of(const answer *a)
{
    return a->path.step[a->path.n - 1];
}

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

/* What was said of each value of the convention given: one number, or one for each channel. */
typedef struct given {
    size_t n[FF_CONVERSION_VALUES];
    double at[FF_CONVERSION_VALUES][CHANNELS];
} given;

static int read_numbers(const cli_args *args, const char *word, const char *numbers, const ff_conversion_value *v, double *out,
                        size_t *n)
{
    char part[64];
    for (const char *at = numbers; at; at = *at == ':' ? at + 1 : NULL) {
        const size_t length = strcspn(at, ":");
        if (*n == CHANNELS) return cli_usage(args, "%s has more than %d values", v->name, (int)CHANNELS);
        snprintf(part, sizeof part, "%.*s", (int)(length < sizeof part ? length : sizeof part - 1), at);
        if (length >= sizeof part || !cli_number_read(part, &out[*n]))
            return cli_usage(args, "'%s': expected a number, or one for each channel with ':' between", word);
        if (is_angle(v)) out[*n] *= pi / 180;
        at += length;
        (*n)++;
    }
    return EXIT_DONE;
}

/* "a, b or c" of the values of a convention. */
static const char *names_of(const ff_conversion *c, char out[CLI_NAME])
{
    *out = '\0';
    for (uint32_t k = 0; k < c->n_in; k++)
        snprintf(out + strlen(out), CLI_NAME - strlen(out), "%s%s",
                 k == 0            ? ""
                 : k + 1 < c->n_in ? ", "
                                   : " and ",
                 shown_name(&c->in[k]));
    return out;
}

/* The value that a word is for: by its name, or the only one that has to be given where the word is a number alone. n_in: none. */
static uint32_t value_of(const ff_conversion *c, const char *word)
{
    const size_t length = strcspn(word, "=");
    uint32_t k = 0, needed = 0, n_needed = 0;
    if (word[length] == '=') {
        while (k < c->n_in && !is_called(&c->in[k], word, length)) k++;
        return k;
    }
    for (k = 0; k < c->n_in; k++) {
        if (c->in[k].optional) continue;
        needed = k;
        n_needed++;
    }
    return n_needed == 1 && strchr("0123456789.+-", *word) ? needed : c->n_in;
}

static int read_value(const cli_args *args, const ff_conversion *c, const char *word, given *g)
{
    char names[CLI_NAME];
    const size_t length = strcspn(word, "=");
    const uint32_t k = value_of(c, word);
    if (k == c->n_in && word[length] != '=')
        return cli_usage(args, "'%s': expected NAME=VALUE; %s needs %s", word, c->from, names_of(c, names));
    if (k == c->n_in) return cli_usage(args, "%s needs %s, not '%.*s'", c->from, names_of(c, names), (int)length, word);
    if (g->n[k]) return cli_usage(args, "%s is given twice; expected %s=VALUE once", shown_name(&c->in[k]), shown_name(&c->in[k]));
    return read_numbers(args, word, word[length] == '=' ? word + length + 1 : word, &c->in[k], g->at[k], &g->n[k]);
}

/* The words of the command line as values of each channel. */
static int read_values(answers *all, const ff_conversion *c, double in[CHANNELS][FF_CONVERSION_VALUES])
{
    const cli_args *args = all->args;
    given g = {{0}, {{0}}};
    int status = EXIT_DONE;
    for (size_t i = 0; i < args->n_words && status == EXIT_DONE; i++) status = read_value(args, c, args->word[i], &g);
    all->n_channels = 1;
    for (uint32_t k = 0; k < c->n_in && status == EXIT_DONE; k++) {
        const ff_conversion_value *v = &c->in[k];
        if (!g.n[k] && v->optional) g.at[k][g.n[k]++] = v->initial;
        if (!g.n[k]) return cli_usage(args, "%s is missing; expected %s=VALUE once", shown_name(v), shown_name(v));
        if (g.n[k] > 1 && all->n_channels > 1 && g.n[k] != all->n_channels)
            return cli_usage(args, "%s has %zu values and another %zu; expected one, or the same number", shown_name(v), g.n[k],
                             all->n_channels);
        if (g.n[k] > 1) all->n_channels = g.n[k];
    }
    for (size_t i = 0; i < all->n_channels && status == EXIT_DONE; i++)
        for (uint32_t k = 0; k < c->n_in; k++) in[i][k] = g.at[k][g.n[k] > 1 ? i : 0];
    return status;
}

/* ---- answers --------------------------------------------------------------------------------- */

/* Criteria of the conversions that leave `from` for `to`; 0 when there is none. */
static int list_criteria(const char *from, const char *to, char *out, size_t size)
{
    *out = '\0';
    for (int i = ff_conversion_find(from, to, NULL, 0); i >= 0; i = ff_conversion_find(from, to, NULL, (size_t)i + 1)) {
        const char *by = ff_conversion_at((size_t)i)->by;
        if (*by) snprintf(out + strlen(out), size - strlen(out), "%s%s", *out ? ", " : "", by);
    }
    return *out != '\0';
}

/* Conventions that a way leads to; 0 when there is none. */
static int list_reached(const char *from, char *out, size_t size)
{
    const char *to;
    ff_conversion_path path;
    *out = '\0';
    for (size_t i = 0; (to = cli_words_to(i)); i++)
        if (ff_conversion_paths(from, to, NULL, 1, &path))
            snprintf(out + strlen(out), size - strlen(out), "%s%s", *out ? ", " : "", to);
    return *out != '\0';
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
    char names[TEXT], hint[CLI_NAME];
    ff_conversion_path path;
    if (!strcmp(from, to)) return cli_usage(args, "--from and --to are both %s", from);
    if (ff_conversion_paths(from, to, NULL, 1, &path)) {
        for (size_t k = 0; k < path.n; k++)
            if (list_criteria(path.step[k]->from, path.step[k]->to, names, sizeof names))
                return cli_usage(args, "from %s to %s there is no criterion '%s'; known are %s%s", path.step[k]->from,
                                 path.step[k]->to, by, names, meant(cli_words_by, by, hint));
        return cli_usage(args, "from %s to %s there is one way only: leave out --by", from, to);
    }
    if (list_reached(from, names, sizeof names) && ff_conversion_name(to))
        return cli_usage(args, "%s and %s are different things: no way leads from one to the other; %s converts to %s", from, to,
                         from, names);
    if (*names)
        return cli_usage(args, "no conversion from %s to '%s'; %s converts to %s%s", from, to, from, names,
                         meant(cli_words_to, to, hint));
    return cli_usage(args, "no conversion from '%s'; 'facetfit convert --list' shows what there is%s", from,
                     meant(cli_words_from, from, hint));
}

/* Each channel along the way, and what is doubtful of the first that has a doubt. */
static ff_status follow(const answers *all, answer *a, double theta, ff_error *err)
{
    ff_status status = FF_OK;
    for (size_t c = 0; c < all->n_channels && !status; c++) {
        const char *doubt = NULL;
        status = ff_conversion_follow(&a->path, a->in[c], theta, a->out[c], &doubt, err);
        if (doubt && !a->doubt) a->doubt = doubt;
    }
    return status;
}

/* The criteria of a way, "" where it has none. */
static const char *criteria(const answer *a, char out[CLI_NAME])
{
    *out = '\0';
    for (size_t k = 0; k < a->path.n; k++) {
        const char *by = a->path.step[k]->by;
        if (*by) snprintf(out + strlen(out), CLI_NAME - strlen(out), "%s%s", *out ? "+" : "", by);
    }
    return out;
}

/* Along each of n ways. One that has no answer is told, and fails the command where no other has one. */
static int follow_all(answers *all, size_t n, const ff_conversion_path *path, double theta)
{
    double in[CHANNELS][FF_CONVERSION_VALUES];
    char by[CLI_NAME];
    ff_error err = {0};
    ff_status failed = FF_OK;
    memcpy(in, all->at[0].in, sizeof in);
    for (size_t i = 0; i < n; i++) {
        answer *a = &all->at[all->n];
        *a = (answer){.path = path[i]};
        memcpy(a->in, in, sizeof in);
        failed = follow(all, a, theta, &err);
        if (failed != FF_OK && (failed != FF_ERR_RANGE || n == 1)) return cli_failed(failed, &err);
        if (failed != FF_OK)
            cli_warning("%s: %s", criteria(a, by), err.message);
        else
            all->n++;
    }
    return all->n ? EXIT_DONE : cli_failed(failed, &err);
}

/* Does any of the ways read the angle of incidence? */
static int has_angle(const ff_conversion_path *path, size_t n)
{
    for (size_t i = 0; i < n; i++)
        for (size_t k = 0; k < path[i].n; k++)
            if (path[i].step[k]->apply_at) return 1;
    return 0;
}

static int find_answers(const cli_args *args, answers *all)
{
    const char *from = cli_value(args, FLAG_FROM, NULL), *to = cli_value(args, FLAG_TO, NULL), *by = cli_value(args, FLAG_BY, NULL);
    ff_conversion_path path[ANSWERS];
    if (!from || !to) return cli_usage(args, "--%s is missing", from ? "to" : "from");
    all->from = ff_conversion_name(from) ? ff_conversion_name(from) : from;
    all->to = ff_conversion_name(to) ? ff_conversion_name(to) : to;
    const size_t n = ff_conversion_paths(all->from, all->to, by, ANSWERS, path);
    if (!n) return unknown_conversion(args, all->from, all->to, by);
    if (cli_given(args, FLAG_THETA) && !has_angle(path, n))
        return cli_usage(args, "--theta is of the criterion lobe, which is not on the way from %s to %s: leave it out", all->from,
                         all->to);
    all->at = calloc(n, sizeof *all->at);
    if (!all->at) return cli_failed(FF_ERR_MEMORY, NULL);
    const double theta = cli_number(args, FLAG_THETA, 45) * pi / 180;
    int status = read_values(all, path[0].step[0], all->at[0].in);
    return status == EXIT_DONE ? follow_all(all, n, path, theta) : status;
}

/* Is it a step of a way before the n-th? Then it was said there. */
static int was_said(const answers *all, size_t n, const ff_conversion *step)
{
    for (size_t i = 0; i < n; i++)
        for (size_t k = 0; k < all->at[i].path.n; k++)
            if (all->at[i].path.step[k] == step) return 1;
    return 0;
}

static void say_what_it_means(const answers *all)
{
    for (size_t i = 0; i < all->n; i++) {
        const answer *a = &all->at[i];
        char by[CLI_NAME], way[TEXT];
        const int several = a->path.n > 1;
        criteria(a, by);
        snprintf(way, sizeof way, "%s", first_of(a)->from);
        for (size_t k = 0; k < a->path.n; k++) snprintf(way + strlen(way), sizeof way - strlen(way), " -> %s", a->path.step[k]->to);
        if (several) cli_message("%s%s%s", by, *by ? ": " : "", way);
        for (size_t k = 0; k < a->path.n; k++) {
            const ff_conversion *c = a->path.step[k];
            if (was_said(all, i, c)) continue;
            cli_message("%s%s%s%s (%s)", several ? "  " : "", several ? "" : by, *by && !several ? ": " : "", c->formula,
                        c->source);
            cli_message("%s  assumes: %s", several ? "  " : "", c->assumes);
            cli_message("%s  valid: %s", several ? "  " : "", c->limits);
        }
        if (a->doubt) cli_warning("doubtful here: %s", a->doubt);
    }
}

static ff_status write_text(const void *context, FILE *out)
{
    const answers *all = context;
    char number[FF_REPORT_NUMBER], by[CLI_NAME];
    for (size_t i = 0; i < all->n; i++) {
        const ff_conversion *c = last_of(&all->at[i]);
        for (uint32_t k = 0; k < c->n_out; k++) {
            fprintf(out, "%s", shown_name(&c->out[k]));
            for (size_t n = 0; n < all->n_channels; n++)
                fprintf(out, " %s", ff_report_number(shown(&c->out[k], all->at[i].out[n][k]), number));
            fprintf(out, "%s%s\n", all->n > 1 ? " " : "", all->n > 1 ? criteria(&all->at[i], by) : "");
        }
    }
    return FF_OK;
}

static void put_values(ff_json *j, const char *key, const ff_conversion_value *v, uint32_t n,
                       double x[CHANNELS][FF_CONVERSION_VALUES], size_t n_channels)
{
    ff_json_object(j, key, FF_JSON_LINE);
    for (uint32_t k = 0; k < n; k++) {
        if (n_channels == 1) {
            ff_json_number(j, shown_name(&v[k]), shown(&v[k], x[0][k]));
            continue;
        }
        ff_json_array(j, shown_name(&v[k]), FF_JSON_LINE);
        for (size_t c = 0; c < n_channels; c++) ff_json_number(j, NULL, shown(&v[k], x[c][k]));
        ff_json_close(j);
    }
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

/* What each step says, with "; " between, each once. */
static void put_joined(ff_json *j, const char *key, const ff_conversion_path *path, const char *(*word)(const ff_conversion *))
{
    char text[4 * TEXT] = "";
    for (size_t k = 0; k < path->n; k++)
        if (!strstr(text, word(path->step[k])))
            snprintf(text + strlen(text), sizeof text - strlen(text), "%s%s", *text ? "; " : "", word(path->step[k]));
    ff_json_string(j, key, text);
}

#define WORD(name)                                                                                                                 \
    static const char *name##_of(const ff_conversion *c)                                                                           \
    {                                                                                                                              \
        return c->name;                                                                                                            \
    }
WORD(formula)
WORD(source)
WORD(assumes)
WORD(limits)

static void put_answer(ff_json *j, const answers *all, answer *a)
{
    char by[CLI_NAME];
    ff_json_object(j, NULL, FF_JSON_BLOCK);
    ff_json_string(j, "from", all->from);
    ff_json_string(j, "to", all->to);
    ff_json_string(j, "by", *criteria(a, by) ? by : NULL);
    ff_json_array(j, "path", FF_JSON_LINE);
    ff_json_string(j, NULL, first_of(a)->from);
    for (size_t k = 0; k < a->path.n; k++) ff_json_string(j, NULL, a->path.step[k]->to);
    ff_json_close(j);
    put_joined(j, "formula", &a->path, formula_of);
    put_joined(j, "source", &a->path, source_of);
    put_joined(j, "assumes", &a->path, assumes_of);
    put_joined(j, "limits", &a->path, limits_of);
    put_values(j, "input", first_of(a)->in, first_of(a)->n_in, a->in, all->n_channels);
    put_values(j, "output", last_of(a)->out, last_of(a)->n_out, a->out, all->n_channels);
    ff_json_string(j, "doubt", a->doubt);
    ff_json_close(j);
}

static ff_status write_json(const void *context, FILE *out)
{
    const answers *all = context;
    ff_json j;
    ff_json_begin(&j, out);
    ff_json_object(&j, NULL, FF_JSON_BLOCK);
    ff_report_head_json(&j, all->args->command->schema, &all->args->head);
    ff_json_array(&j, "conversions", FF_JSON_BLOCK);
    for (size_t i = 0; i < all->n; i++) put_answer(&j, all, &all->at[i]);
    ff_json_close(&j);
    ff_json_close(&j);
    ff_json_end(&j);
    return FF_OK;
}

/* ---- the list -------------------------------------------------------------------------------- */

/* The values of a convention, as some conversion takes or gives them. */
static const ff_conversion_value *values_of(const char *name, uint32_t *n)
{
    const ff_conversion *c;
    for (size_t i = 0; (c = ff_conversion_at(i)); i++) {
        if (strcmp(c->from, name) && strcmp(c->to, name)) continue;
        *n = strcmp(c->from, name) ? c->n_out : c->n_in;
        return strcmp(c->from, name) ? c->out : c->in;
    }
    return NULL;
}

/* The conventions that a way leads to from `first`, and itself, with their values; those before it have been printed. */
static void write_connected(const char *first, FILE *out)
{
    const char *name;
    ff_conversion_path path;
    fprintf(out, "Any of these in terms of any other:\n");
    for (size_t i = 0; (name = cli_words_from(i)); i++) {
        uint32_t n = 0;
        if (strcmp(name, first) && !ff_conversion_paths(first, name, NULL, 1, &path)) continue;
        const ff_conversion_value *v = values_of(name, &n);
        fprintf(out, "  %-15s", name);
        for (uint32_t k = 0; k < n; k++) fprintf(out, " %s", shown_name(&v[k]));
        fputc('\n', out);
    }
    fputc('\n', out);
}

static void write_conventions(FILE *out)
{
    const char *name, *before;
    ff_conversion_path path;
    for (size_t i = 0; (name = cli_words_from(i)); i++) {
        int known = 0;
        for (size_t k = 0; k < i && !known; k++)
            known = (before = cli_words_from(k)) && ff_conversion_paths(before, name, NULL, 1, &path);
        if (!known) write_connected(name, out);
    }
}

static ff_status write_list(const void *context, FILE *out)
{
    (void)context;
    write_conventions(out);
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
    if (status == EXIT_DONE && !cli_given(args, FLAG_QUIET)) say_what_it_means(&all);
    free(all.at);
    return status;
}
