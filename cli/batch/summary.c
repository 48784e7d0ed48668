/* One table of all files: a row for each, for each channel where these were fitted by themselves, and a column for every parameter
 * that any of them has. */
#include "internal_batch.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

const char *batch_order_name(size_t i)
{
    static const char *const names[BATCH_ORDERS] = {"file", "verdict", "residual"};
    return i < BATCH_ORDERS ? names[i] : NULL;
}

/* ---- the order of rows ----------------------------------------------------------------------- */

/* How much a person should look at it: 5 no result, ... 0 good. */
static double badness_of_verdict(const batch_line *l)
{
    static const char *const quality[] = {"good", "fair", "poor"};
    if (!l->row) return l->rows->state == BATCH_FAILED ? 6 : 5;
    if (strcmp(l->row->outcome, "converged") != 0 || strstr(l->row->verdict, "nothing-found")) return 4;
    for (int k = 0; k < 3; k++)
        if (!strcmp(l->row->quality, quality[k])) return k;
    return 3; /* nothing could be said */
}

static double badness_of(const batch_line *l, batch_order order)
{
    if (order == BATCH_BY_VERDICT) return badness_of_verdict(l);
    return !l->row || isnan(l->row->rmse) ? INFINITY : l->row->rmse;
}

static int worst_first(const void *a, const void *b)
{
    const batch_line *p = a, *q = b;
    if (p->badness != q->badness) return p->badness < q->badness ? 1 : -1;
    if (p->job != q->job) return p->job > q->job ? 1 : -1;
    return (p->row > q->row) - (p->row < q->row);
}

/* Of verdicts that say the same the worse described first, of those the order of the files. */
static int worst_verdict_first(const void *a, const void *b)
{
    const batch_line *p = a, *q = b;
    const double x = p->row && !isnan(p->row->explained) ? p->row->explained : -INFINITY;
    const double y = q->row && !isnan(q->row->explained) ? q->row->explained : -INFINITY;
    if (p->badness == q->badness && x != y) return x > y ? 1 : -1;
    return worst_first(a, b);
}

batch_line *batch_lines_of(const batch_summary *s, size_t *n)
{
    size_t most = 0;
    for (size_t i = 0; i < s->inputs->n; i++) most += s->rows[i].n ? s->rows[i].n : 1;
    batch_line *l = malloc((most + 1) * sizeof *l);
    *n = 0;
    for (size_t i = 0; i < s->inputs->n && l; i++) {
        if (!batch_shard_has(s->shard, i)) continue;
        const batch_rows *r = &s->rows[i];
        if (!r->n) l[(*n)++] = (batch_line){i, r, NULL, 0};
        for (size_t k = 0; k < r->n; k++) l[(*n)++] = (batch_line){i, r, &r->row[k], 0};
    }
    if (!l || s->order == BATCH_BY_FILE) return l;
    for (size_t k = 0; k < *n; k++) l[k].badness = badness_of(&l[k], s->order);
    qsort(l, *n, sizeof *l, s->order == BATCH_BY_VERDICT ? worst_verdict_first : worst_first);
    return l;
}

/* ---- columns --------------------------------------------------------------------------------- */

/* The parameters of all rows, in the order in which the jobs bring them. */
typedef struct columns {
    size_t n, room;
    const char **name;
} columns;

/* Rows have them in one order mostly: it is looked for from where the last one was. */
static size_t find_column(const columns *c, const char *name, size_t from)
{
    for (size_t k = 0; k < c->n; k++)
        if (!strcmp(c->name[(from + k) % c->n], name)) return (from + k) % c->n;
    return c->n;
}

static int add_column(columns *c, const char *name)
{
    if (c->n == c->room) {
        const size_t room = 2 * c->room + 32;
        const char **larger = realloc(c->name, room * sizeof *larger);
        if (!larger) return 0;
        c->name = larger;
        c->room = room;
    }
    c->name[c->n++] = name;
    return 1;
}

static int columns_of(const batch_summary *s, columns *c)
{
    for (size_t i = 0; i < s->inputs->n; i++)
        for (size_t k = 0; k < s->rows[i].n && batch_shard_has(s->shard, i); k++) {
            const batch_row *r = &s->rows[i].row[k];
            for (size_t v = 0, at = 0; v < r->n_values; v++, at++) {
                at = find_column(c, r->value[v].name, at);
                if (at == c->n && !add_column(c, r->value[v].name)) return 0;
            }
        }
    return 1;
}

/* ---- CSV ------------------------------------------------------------------------------------- */

/* RFC 4180: in quotes where it has to be, with one line for a message of several. */
static void put_text(const char *text, FILE *out)
{
    const int quoted = text[strcspn(text, ",\"\r\n")] != '\0' || *text == ' ';
    if (quoted) fputc('"', out);
    for (; *text; text++) {
        if (*text == '"') fputc('"', out);
        if (*text == '\n' || *text == '\r')
            fputs(text[1] ? "; " : "", out);
        else
            fputc(*text, out);
    }
    if (quoted) fputc('"', out);
}

static void put_cell(const char *text, FILE *out)
{
    fputc(',', out);
    put_text(text ? text : "", out);
}

static void put_number(double x, FILE *out)
{
    char text[FF_REPORT_NUMBER];
    fputc(',', out);
    if (isfinite(x)) fputs(ff_report_number(x, text), out);
}

static void put_values(const batch_row *r, const columns *c, const batch_value **room, FILE *out)
{
    for (size_t k = 0; k < c->n; k++) room[k] = NULL;
    for (size_t v = 0, at = 0; r && v < r->n_values; v++, at++) room[at = find_column(c, r->value[v].name, at)] = &r->value[v];
    for (size_t k = 0; k < c->n; k++) {
        put_number(room[k] ? room[k]->value : NAN, out);
        put_number(room[k] ? room[k]->error : NAN, out);
    }
}

static void put_line(const batch_summary *s, const batch_line *l, FILE *out)
{
    static const batch_row nothing = {.samples = NAN, .explained = NAN, .objective = NAN, .rmse = NAN};
    const batch_row *r = l->row ? l->row : &nothing;
    put_text(s->inputs->at[l->job].path, out);
    put_cell(l->rows->state == BATCH_DONE ? s->inputs->at[l->job].name : "", out); /* what failed has no result */
    put_cell(batch_state_name((int)l->rows->state), out);
    put_cell(r->model, out);
    put_cell(r->channels, out);
    put_cell(r->outcome, out);
    put_cell(r->quality, out);
    put_cell(r->verdict, out);
    put_cell(r->warnings, out);
    put_cell(l->rows->message, out);
    put_number(r->samples, out);
    put_number(r->explained, out);
    put_number(r->objective, out);
    put_number(r->rmse, out);
}

static void put_heads(const columns *c, FILE *out)
{
    fputs("file,json,state,model,channels,outcome,quality,verdict,warnings,message,samples,explained,objective,rmse", out);
    for (size_t k = 0; k < c->n; k++) {
        char error[sizeof "_error" + FF_PARAM_NAME + FF_CHANNEL_NAME + 4];
        snprintf(error, sizeof error, "%s_error", c->name[k]);
        put_cell(c->name[k], out);
        put_cell(error, out);
    }
    fputc('\n', out);
}

ff_status batch_summary_csv(const void *summary, FILE *out)
{
    const batch_summary *s = summary;
    columns c = {.n = 0};
    size_t n = 0;
    batch_line *l = batch_lines_of(s, &n);
    const int there = l && columns_of(s, &c);
    const batch_value **room = malloc((c.n + 1) * sizeof *room);
    if (there && room) put_heads(&c, out);
    for (size_t k = 0; k < n && there && room; k++) {
        put_line(s, &l[k], out);
        put_values(l[k].row, &c, room, out);
        fputc('\n', out);
    }
    free(room);
    free(l);
    free(c.name);
    return there && room ? FF_OK : FF_ERR_MEMORY;
}

/* ---- JSON ------------------------------------------------------------------------------------ */

/* An array of the words that have blanks between. */
static void put_words(ff_json *j, const char *key, const char *words)
{
    char word[128];
    ff_json_array(j, key, FF_JSON_LINE);
    while (*words) {
        const size_t n = strcspn(words, " ");
        snprintf(word, sizeof word, "%.*s", (int)n, words);
        ff_json_string(j, NULL, word);
        words += n + (words[n] == ' ');
    }
    ff_json_close(j);
}

static void put_row(ff_json *j, const batch_row *r)
{
    ff_json_string(j, "model", r->model);
    ff_json_string(j, "channels", r->channels);
    ff_json_string(j, "outcome", r->outcome);
    ff_json_string(j, "quality", *r->quality ? r->quality : NULL);
    put_words(j, "verdict", r->verdict);
    put_words(j, "warnings", r->warnings);
    ff_json_number(j, "samples", r->samples);
    ff_json_number(j, "explained", r->explained);
    ff_json_number(j, "objective", r->objective);
    ff_json_number(j, "rmse", r->rmse);
    ff_json_object(j, "parameters", FF_JSON_BLOCK);
    for (size_t v = 0; v < r->n_values; v++) {
        ff_json_object(j, r->value[v].name, FF_JSON_LINE);
        ff_json_number(j, "value", r->value[v].value);
        ff_json_number(j, "std_error", r->value[v].error);
        ff_json_close(j);
    }
    ff_json_close(j);
}

ff_status batch_summary_json(const void *summary, FILE *out)
{
    const batch_summary *s = summary;
    ff_json j;
    size_t n = 0;
    batch_line *l = batch_lines_of(s, &n);
    if (!l) return FF_ERR_MEMORY;
    ff_json_begin(&j, out);
    ff_json_object(&j, NULL, FF_JSON_BLOCK);
    ff_report_head_json(&j, FF_SCHEMA_SUMMARY, &s->head);
    ff_json_array(&j, "files", FF_JSON_BLOCK);
    for (size_t k = 0; k < n; k++) {
        ff_json_object(&j, NULL, FF_JSON_BLOCK);
        ff_json_string(&j, "file", s->inputs->at[l[k].job].path);
        ff_json_string(&j, "json", l[k].rows->state == BATCH_DONE ? s->inputs->at[l[k].job].name : NULL);
        ff_json_string(&j, "state", batch_state_name((int)l[k].rows->state));
        ff_json_string(&j, "message", l[k].rows->message);
        if (l[k].row) put_row(&j, l[k].row);
        ff_json_close(&j);
    }
    ff_json_close(&j);
    ff_json_close(&j);
    ff_json_end(&j);
    free(l);
    return FF_OK;
}
