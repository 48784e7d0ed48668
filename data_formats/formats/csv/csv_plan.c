/* What the columns of somebody's table are, by their names, as a text of the option 'columns': so everything that is assumed can be
 * said, read again, and changed. */
#define _GNU_SOURCE
#include "internal_csv_plan.h"
#include "base/internal_input.h"
#include "base/internal_kept.h"
#include "base/internal_number.h"
#include <ctype.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

static const double small = 1.5709; /* radians of a right angle, as rounded */

/* ---- the columns ---------------------------------------------------------------------------------- */

static void copy_cell(const char *text, size_t length, char separator, size_t k, char out[FF_PLAN_NAME])
{
    size_t n;
    const char *cell = ff_csv_cell(text, length, separator, k, &n);
    if (n >= FF_PLAN_NAME) n = FF_PLAN_NAME - 1;
    memcpy(out, cell, n);
    out[n] = '\0';
}

static double number_of(const ff_csv_line *l, const ff_csv_dialect *d, size_t k)
{
    double value;
    size_t n;
    const char *cell = ff_csv_cell(l->text, l->length, d->separator, k, &n);
    return ff_csv_number(cell, n, d, &value) ? value : NAN;
}

/* Range of the numbers in each column. */
static void measure_columns(ff_planner *p)
{
    for (size_t k = 0; k < p->n; k++) p->column[k].lo = INFINITY, p->column[k].hi = -INFINITY;
    for (size_t j = 0; j < p->look->n_lines; j++) {
        const ff_csv_line *l = &p->look->line[j];
        if (!l->is_row) continue;
        for (size_t k = 0; k < p->n && k < l->cells; k++) {
            const double v = number_of(l, &p->look->dialect, k);
            p->column[k].lo = fmin(p->column[k].lo, v);
            p->column[k].hi = fmax(p->column[k].hi, v);
        }
    }
}

/* Which line and which separator name the columns. */
typedef struct names {
    const ff_csv_line *line;
    const char *text; /* behind the sign of a comment */
    size_t length, cells;
    char separator;
    int score;
} names;

static int score_of(const names *c, size_t wanted)
{
    int score = 0;
    size_t full = 0;
    for (size_t k = 0; k < c->cells && k < FF_PLAN_COLUMNS; k++) {
        char name[FF_PLAN_NAME];
        ff_named named;
        copy_cell(c->text, c->length, c->separator, k, name);
        ff_name_meaning(name, &named);
        if (*name) full = k + 1;
        score += named.meaning == FF_MEANS_NUMBER ? 1 : named.meaning != FF_MEANS_NOTHING ? 4 : *name ? 0 : -1;
    }
    return full == wanted ? score + 2 : full > wanted || c->cells < wanted ? -1 : score;
}

/* The separator of the names may be another than that of the numbers: "# theta_i, f" over columns of blanks. */
static names split_names(const ff_csv_look *look, size_t k, size_t wanted)
{
    const ff_csv_line *l = &look->line[k];
    const char all[] = {look->dialect.separator, ',', ';', '\t', '|', ' ', '\0'};
    const char *text = l->text, *stop = l->text + l->length;
    while (text < stop && (ff_csv_is_blank(*text) || *text == '#' || (l->is_comment && *text == '"')) &&
           *text != look->dialect.separator)
        text++;
    while (l->is_comment && text < stop && (ff_csv_is_blank(*text) || *text == '#')) text++;
    names best = {.score = -1};
    for (const char *s = all; *s; s++) {
        names one = {l, text, (size_t)(stop - text), 0, *s, 0};
        if (one.length == 0 || (*s == ' ' && look->dialect.separator != ' ')) continue; /* names may have blanks in them */
        one.cells = ff_csv_count_cells(text, one.length, *s);
        one.score = one.cells < 2 ? -1 : score_of(&one, wanted);
        if (one.score > best.score) best = one;
    }
    return best;
}

/* The line of units below the names: nothing but units. */
static int is_units(const ff_csv_look *look, const ff_csv_line *l)
{
    size_t n = 0;
    for (size_t k = 0; k < l->full; k++) {
        char text[FF_PLAN_NAME];
        copy_cell(l->text, l->length, look->dialect.separator, k, text);
        if (*text && ff_name_unit(text) < 0) return 0;
        n += *text != '\0';
    }
    return n >= 2;
}

static size_t cells_of_rows(const ff_csv_look *look)
{
    size_t most = 0;
    for (size_t k = 0; k < look->n_lines; k++)
        if (look->line[k].is_row && look->line[k].full > most) most = look->line[k].full;
    return most;
}

static ff_status name_columns(ff_planner *p)
{
    const ff_csv_look *look = p->look;
    const size_t wanted = cells_of_rows(look), first = look->first_row;
    const ff_csv_line *units = NULL;
    names best = {.score = -1};
    for (size_t k = first - 1; k-- > 0 && k + 30 > first;) {
        const ff_csv_line *l = &look->line[k];
        if (l->full == 0 && !l->is_comment) continue;
        if (!units && is_units(look, l)) {
            units = l;
            continue;
        }
        const names one = split_names(look, k, wanted);
        if (one.score > best.score) {
            best = one;
            p->header_line = k + 1;
        }
        if (best.score >= 10) break; /* two names that are known, as many as the rows have cells */
    }
    p->n = wanted;
    if (wanted > FF_PLAN_COLUMNS) return FF_ERR_FORMAT;
    if (best.score < 4) p->header_line = 0;
    p->column = calloc(wanted + 1, sizeof *p->column);
    if (!p->column) return FF_ERR_MEMORY;
    for (size_t k = 0; k < wanted && p->header_line; k++) {
        ff_plan_column *c = &p->column[k];
        char text[FF_PLAN_NAME];
        copy_cell(best.text, best.length, best.separator, k, text);
        ff_name_utf8(text, c->name, sizeof c->name);
        ff_name_meaning(text, &c->named);
        if (!units) continue;
        copy_cell(units->text, units->length, look->dialect.separator, k, text);
        const int unit = *text ? ff_name_unit(text) : -1;
        if (unit > 0 && c->named.unit == FF_CSV_PLAIN) c->named.unit = (ff_csv_unit)unit;
    }
    measure_columns(p);
    return FF_OK;
}

/* ---- settings ---------------------------------------------------------------------------------------- */

/* "Angle of incidence (deg): 20": the name before the number; 0 when it is none that could stand in the option. */
static size_t name_before_number(const char *text, size_t length)
{
    size_t n = 0;
    while (n < length && !strchr("=:,;\t([{\"|#", text[n])) {
        const int number =
            isdigit((unsigned char)text[n]) || (strchr("+-.", text[n]) && n + 1 < length && isdigit((unsigned char)text[n + 1]));
        if (number && n > 0 && ff_csv_is_blank(text[n - 1])) break;
        n++;
    }
    while (n && ff_csv_is_blank(text[n - 1])) n--;
    return n < FF_PLAN_NAME ? n : 0;
}

static void take_setting(ff_planner *p, const char *text, size_t length)
{
    while (length && strchr(" \t#\"%*/", *text)) text++, length--;
    char all[FF_PLAN_NAME], name[FF_PLAN_NAME];
    ff_named named;
    const size_t n = name_before_number(text, length);
    if (n == 0 || length >= sizeof all) return;
    memcpy(all, text, length);
    all[length] = '\0';
    ff_name_meaning(all, &named);
    if (isnan(named.number) || named.meaning == FF_MEANS_VALUE || named.meaning == FF_MEANS_NUMBER) return;
    memcpy(name, text, n);
    name[n] = '\0';
    double value;
    if (!ff_csv_setting(text, length, name, &p->look->dialect, &value)) return;
    ff_plan_setting *s = &p->setting[named.meaning];
    if (s->count == 0) {
        strcpy(s->name, name);
        s->unit = named.number_unit ? named.number_unit : named.unit;
        s->value = value;
    } else if (strcmp(s->name, name) != 0) {
        return;
    }
    s->changes |= value != s->value;
    s->count++;
}

/* Lines that are neither names nor rows, each alone and in pieces. */
static void look_for_settings(ff_planner *p)
{
    for (size_t k = 0; k < p->look->n_lines; k++) {
        const ff_csv_line *l = &p->look->line[k];
        const ff_csv_line *names = &p->look->line[p->header_line - 1];
        if (l->is_row || l->length == 0 || (l->length == names->length && memcmp(l->text, names->text, l->length) == 0)) continue;
        size_t length = l->length;
        while (length && strchr(" \t,;|", l->text[length - 1])) length--;
        const char *stop = l->text + length;
        take_setting(p, l->text, length);
        for (const char *piece = l->text; piece < stop;) {
            const char *end = piece;
            while (end < stop && *end != ';' && *end != p->look->dialect.separator &&
                   !(*end == ',' && end + 1 < stop && end[1] == ' '))
                end++;
            if (end - piece < stop - l->text) take_setting(p, piece, (size_t)(end - piece));
            piece = end + 1;
        }
    }
}

/* Comments in our words, where the angles are too. */
static ff_status read_comments(ff_planner *p)
{
    for (size_t k = 0; k < p->look->n_lines && k + 1 < p->look->first_row && p->look->our_angles; k++) {
        const ff_csv_line *l = &p->look->line[k];
        if (!l->is_comment) continue;
        char *text = strndup(l->text, l->length);
        if (!text) return ff_error_set(p->err, FF_ERR_MEMORY, p->path, 0, -1, "no memory for a comment");
        const ff_status status = ff_csv_comment(&p->head, text, 0, p->path, (long)k + 1, p->err);
        free(text);
        if (status != FF_OK) return status;
    }
    if (p->head.angles_are_said && p->angles == FF_ANGLES_AS_FORMAT)
        p->angles = p->head.radians_per_unit == 1 ? FF_ANGLES_RADIANS : FF_ANGLES_DEGREES;
    return FF_OK;
}

/* ---- making it -------------------------------------------------------------------------------------- */

void ff_csv_plan_clear(ff_csv_plan *plan)
{
    free(plan->columns);
    *plan = (ff_csv_plan){0};
}

static ff_status make(ff_planner *p)
{
    ff_status status = name_columns(p);
    if (status == FF_ERR_FORMAT)
        return ff_error_set(p->err, FF_ERR_FORMAT, p->path, (long)p->look->first_row, -1, "found %zu columns, expected at most %d",
                            p->n, FF_PLAN_COLUMNS);
    if (status != FF_OK) return ff_error_set(p->err, status, p->path, 0, -1, "no memory for %zu columns", p->n);
    if (p->header_line) look_for_settings(p);
    status = read_comments(p);
    return status == FF_OK ? ff_plan_assign(p) : status;
}

ff_status ff_csv_plan_make(const ff_csv_look *look, const char *path, int angles, ff_csv_plan *out, ff_error *err)
{
    ff_planner p = {.look = look, .path = path, .err = err, .small = small, .angles = angles};
    if (!look->first_row)
        return ff_error_set(err, FF_ERR_FORMAT, path, look->n_lines ? 1 : 0, -1,
                            "found no line with two numbers or more among the first %zu, expected a table of angles and values",
                            look->n_lines);
    if (look->mixed)
        return ff_error_hint(
            err,
            ff_error_set(err, FF_ERR_DATA, path, look->mixed, -1,
                         "found numbers with decimal points and here one with a comma: which is the decimal mark? The other "
                         "then separates thousands; say dialect decimal=comma (or point)"),
            FF_HINT_SAY);
    p.text = ff_kept_open(&p.kept);
    ff_status status = p.text ? make(&p) : FF_OK;
    if (ff_kept_close(&p.kept, p.text) != FF_OK && status == FF_OK)
        status = ff_error_set(err, FF_ERR_MEMORY, path, 0, -1, "no memory for the names of columns");
    p.plan.columns = p.kept.text;
    p.plan.header_line = p.header_line;
    p.plan.first_row = look->first_row;
    free(p.column);
    if (status == FF_OK)
        *out = p.plan;
    else
        free(p.plan.columns);
    return status;
}
