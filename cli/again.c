/* The command line that a report suggests: the person's own, for another command. What the flags bear on is said where they are
 * defined: what is read and found goes along, what is written does not, and where a flag of the former has no place in the other
 * command there is no command line that does the same. */
#define _GNU_SOURCE
#include "internal_cli.h"
#include "base/internal_kept.h"
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

typedef struct line {
    const cli_args *args;
    const cli_command *to;
    const ff_report_change *change;
    size_t n_changes;
    cli_combinations models; /* that the other command has */
    int where_present;       /* as cli_constraints_read    */
    char *out;
    size_t used, size;
    int is_lost; /* 1: there is no such command line, or no room for it */
} line;

/* ---- words of a shell ------------------------------------------------------------------------ */

static void put(line *l, const char *format, ...) __attribute__((format(printf, 2, 3)));
static void put(line *l, const char *format, ...)
{
    va_list args;
    va_start(args, format);
    const int n = vsnprintf(l->out + l->used, l->size - l->used, format, args);
    va_end(args);
    if (n < 0 || (size_t)n >= l->size - l->used)
        l->is_lost = 1;
    else
        l->used += (size_t)n;
}

/* A word as a shell takes it. */
static void put_word(line *l, const char *word)
{
    static const char plain[] = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_./-+=,:@%";
    if (*word && strspn(word, plain) == strlen(word)) {
        put(l, " %s", word);
        return;
    }
    put(l, " '");
    for (; *word; word++) put(l, *word == '\'' ? "'\\''" : "%c", *word);
    put(l, "'");
}

/* The name of a file that begins with '-' would be a flag. */
static void put_file(line *l, const char *path)
{
    char *other = NULL;
    if (*path != '-' || !path[1]) {
        put_word(l, path);
    } else if (asprintf(&other, "./%s", path) >= 0) {
        put_word(l, other);
        free(other);
    } else {
        l->is_lost = 1;
    }
}

/* ---- what is said of parameters --------------------------------------------------------------- */

static int flag_of(const char *name)
{
    for (int i = 0; i < FLAG_COUNT; i++)
        if (!strcmp(cli_flag_name((cli_flag_id)i), name)) return i;
    return -1;
}

static int is_changed(const line *l, cli_flag_id flag)
{
    for (size_t k = 0; k < l->n_changes; k++)
        if (flag_of(l->change[k].flag) == (int)flag) return 1;
    return 0;
}

/* Do the changes say which models? Then nothing that the person said of that goes along. */
static int chooses_anew(const line *l)
{
    int anew = 0;
    for (size_t k = 0; k < l->n_changes; k++) anew |= cli_flag_at((cli_flag_id)flag_of(l->change[k].flag))->chooses;
    return anew;
}

enum { CHOICES = 16 };

/* What says which models, as if the other command had been given it. */
static void take_choices(const line *l, int flag[CHOICES], const char *value[CHOICES], cli_args *out)
{
    const cli_args *a = l->args;
    *out = (cli_args){.command = l->to, .flag = flag, .value = value, .head = a->head, .style = a->style};
    for (size_t k = 0; k < a->n_given && !chooses_anew(l); k++) {
        const cli_flag *f = cli_flag_at((cli_flag_id)a->flag[k]);
        if (!f->chooses || !cli_flag_has(f, l->to) || out->n_given == CHOICES) continue;
        flag[out->n_given] = a->flag[k];
        value[out->n_given++] = a->value[k];
    }
    for (size_t k = 0; k < l->n_changes && out->n_given < CHOICES; k++) {
        if (!l->change[k].value) continue;
        flag[out->n_given] = flag_of(l->change[k].flag);
        value[out->n_given++] = l->change[k].value;
    }
}

/* The models of the other command, by the functions that will read them there. */
static int find_models(line *l)
{
    int flag[CHOICES];
    const char *value[CHOICES];
    const cli_tables none = {NULL};
    const int compares = l->to->id == COMMAND_compare;
    cli_args args;
    take_choices(l, flag, value, &args);
    l->where_present = compares || cli_given(&args, FLAG_FOR);
    if (cli_given(&args, FLAG_FOR)) return cli_renderers_read(&args, compares, &l->models);
    if (compares) return cli_combine(&args, &none, "all", "all", &l->models);
    l->models.model = malloc(sizeof *l->models.model);
    if (!l->models.model) return EXIT_INTERNAL;
    l->models.n = 1;
    return cli_exit_status(ff_model_parse(cli_value(&args, FLAG_MODEL, "ggx+lambert"), l->models.model, NULL));
}

static int is_taken_in(const line *l, const cli_args *args)
{
    ff_model first = l->models.model[0];
    cli_constraints constraints = {.n_names = 0};
    int status = cli_hold_and_free(args, &first, l->where_present);
    if (status == EXIT_DONE) status = cli_names_known(args, l->models.model, l->models.n);
    if (status == EXIT_DONE) status = cli_constraints_read(args, l->models.model, l->models.n, l->where_present, &constraints);
    cli_constraints_free(&constraints);
    return status == EXIT_DONE;
}

/* Would the other command take this word of this flag? It is asked: for the word alone, and beside all that is said of other flags,
 * since a bound may allow a value. */
static int is_taken(const line *l, cli_flag_id flag, const char *word)
{
    const cli_args *given = l->args;
    int id = (int)flag, *ids = malloc((given->n_given + 1) * sizeof *ids);
    const char **values = malloc((given->n_given + 1) * sizeof *values);
    cli_args args = {.command = l->to, .n_given = 1, .flag = &id, .value = &word, .head = given->head};
    int taken = is_taken_in(l, &args);
    if (!taken && ids && values) {
        args.flag = ids;
        args.value = values;
        for (size_t k = 0; k < given->n_given; k++) {
            if (given->flag[k] == id) continue;
            ids[args.n_given] = given->flag[k];
            values[args.n_given++] = given->value[k];
        }
        ids[0] = id;
        values[0] = word;
        taken = is_taken_in(l, &args);
    }
    free(values);
    free(ids);
    return taken;
}

typedef struct words {
    const line *l;
    cli_flag_id flag;
    FILE *out;
    size_t n;
} words;

static int keep_word(const cli_args *args, const char *word, void *context)
{
    words *w = context;
    (void)args;
    if (is_taken(w->l, w->flag, word)) fprintf(w->out, "%s%s", w->n++ ? "," : "", word);
    return EXIT_DONE;
}

/* Of "alpha=0.2,gamma=2" what the other command has. */
static void put_assignments(line *l, cli_flag_id flag, const char *value)
{
    int id = (int)flag;
    const cli_args one = {.command = l->args->command, .n_given = 1, .flag = &id, .value = &value};
    ff_kept kept;
    words w = {l, flag, ff_kept_open(&kept), 0};
    if (w.out) cli_each_word(&one, flag, keep_word, &w);
    if (ff_kept_close(&kept, w.out) != FF_OK) {
        l->is_lost = 1;
        return;
    }
    if (w.n) {
        put(l, " --%s", cli_flag_name(flag));
        put_word(l, kept.text);
    }
    free(kept.text);
}

/* ---- flags ----------------------------------------------------------------------------------- */

/* Does what a flag bears on go along? A figure answers no questions. */
static int goes_along(const line *l, const cli_flag *f)
{
    const cli_bearing bearing = cli_flag_bearing(f);
    if (f->chooses) return !chooses_anew(l) && cli_flag_has(f, l->to);
    return bearing != BEARS_OUTPUT && (bearing != BEARS_QUESTION || l->to->schema);
}

static void put_flag(line *l, cli_flag_id flag, const char *value)
{
    const cli_flag own = cli_flag_of(flag, l->args->command), other = cli_flag_of(flag, l->to);
    if (!goes_along(l, &own) || is_changed(l, flag)) return;
    const int has = cli_flag_has(&other, l->to), matters = cli_flag_bearing(&own) == BEARS_RESULT;
    const int means = has && (other.kind != KIND_WORD || cli_words_find(other.words, value, strlen(value)) >= 0);
    l->is_lost |= matters && !means;
    if (!means) return;
    if (other.kind == KIND_ASSIGNMENTS && other.group == GROUP_MODEL) {
        put_assignments(l, flag, value);
        return;
    }
    put(l, " --%s%s", value && other.kind == KIND_SWITCH ? "no-" : "", other.name);
    if (other.kind != KIND_SWITCH) put_word(l, value);
}

static void put_changes(line *l)
{
    for (size_t k = 0; k < l->n_changes; k++) {
        if (!l->change[k].value) continue;
        put(l, " --%s", l->change[k].flag);
        put_word(l, l->change[k].value);
    }
}

/* ---- all ------------------------------------------------------------------------------------- */

static void put_line(line *l, const char *command)
{
    const cli_args *a = l->args;
    put(l, "facetfit %s", command);
    l->is_lost |= a->n_words > 1 && !cli_joins_files(l->to);
    for (size_t k = 0; k < a->n_words; k++) put_file(l, a->word[k]);
    for (size_t k = 0; k < a->n_given; k++) put_flag(l, (cli_flag_id)a->flag[k], a->value[k]);
    put_changes(l);
}

int cli_again(const void *args, const char *command, const ff_report_change *change, size_t n, char *out, size_t size)
{
    char name[CLI_NAME];
    line l = {.args = args, .change = change, .n_changes = n, .out = out, .size = size};
    ff_kept unsaid;
    FILE *stream = ff_kept_open(&unsaid), *before = cli_messages_into(stream);
    snprintf(name, sizeof name, "%.*s", (int)strcspn(command, " "), command);
    l.to = cli_command_find(name);
    l.is_lost = !stream || !l.to || find_models(&l) != EXIT_DONE;
    if (!l.is_lost) put_line(&l, command);
    free(l.models.model);
    free(l.models.target);
    (void)cli_messages_into(before);
    if (ff_kept_close(&unsaid, stream) == FF_OK) free(unsaid.text);
    return !l.is_lost;
}
