/* What the parts of csv_assign.c share: the option as it grows, what it assumes, and refusals that say it. */
#define _GNU_SOURCE
#include "internal_csv_plan.h"
#include "base/internal_input.h"
#include "base/internal_number.h"
#include <math.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

void ff_plan_assume(ff_planner *p, const char *fmt, ...)
{
    va_list args;
    const size_t used = strlen(p->plan.notes), room = sizeof p->plan.notes - used;
    va_start(args, fmt);
    const int n = vsnprintf(p->plan.notes + used, room, fmt, args);
    va_end(args);
    if (n < 0 || (size_t)n + 2 > room)
        p->plan.notes[used] = '\0';
    else
        strcpy(p->plan.notes + used + n, "\n");
}

const char *ff_plan_unit_text(ff_csv_unit unit)
{
    switch (unit) {
    case FF_CSV_RADIANS:
        return ":rad";
    case FF_CSV_NM:
        return ":nm";
    case FF_CSV_UM:
        return ":um";
    case FF_CSV_M:
        return ":m";
    case FF_CSV_PERCENT:
        return ":%";
    default:
        return "";
    }
}

void ff_plan_put_number(FILE *out, double v)
{
    char text[FF_NUMBER_TEXT];
    fwrite(text, 1, ff_number_write(v, text), out);
}

void ff_plan_put_separator(ff_planner *p)
{
    fflush(p->text);
    if (p->kept.n > 0) fputc(',', p->text);
}

void ff_plan_put_column(ff_planner *p, const char *key, size_t k, const char *unit)
{
    ff_plan_put_separator(p);
    fprintf(p->text, "%s=#%zu%s", key, k + 1, unit);
    p->column[k].used = 1;
}

void ff_plan_put_constant(ff_planner *p, const char *key, double v)
{
    ff_plan_put_separator(p);
    fprintf(p->text, "%s=", key);
    ff_plan_put_number(p->text, v);
}

void ff_plan_put_setting(ff_planner *p, const char *key, ff_meaning meaning)
{
    const ff_plan_setting *s = &p->setting[meaning];
    ff_plan_put_separator(p);
    fprintf(p->text, "%s=@%s%s", key, s->name, ff_plan_unit_text(s->unit));
}

/* The option so far, ending what is written: for messages. */
const char *ff_plan_so_far(ff_planner *p)
{
    return fflush(p->text) == 0 ? p->kept.text : "";
}

/* ---- refusing ------------------------------------------------------------------------------------ */

const char *ff_plan_list_names(const ff_planner *p, char out[FF_NAMES_LIST])
{
    size_t used = 0;
    out[0] = '\0';
    for (size_t k = 0; k < p->n; k++) {
        const size_t n = strlen(p->column[k].name);
        if (used + n + 8 > FF_NAMES_LIST) {
            strcpy(out + used, ", ...");
            break;
        }
        used = (size_t)(stpcpy(stpcpy(out + used, used ? ", " : ""), p->column[k].name) - out);
    }
    return out;
}

ff_status ff_plan_refuse(ff_planner *p, const char *why, const char *say)
{
    char names[FF_NAMES_LIST];
    return ff_error_hint(p->err,
                         ff_error_set(p->err, FF_ERR_FORMAT, p->path, (long)(p->header_line ? p->header_line : p->look->first_row),
                                      -1, "found the columns %s; %s; say columns '%s'", ff_plan_list_names(p, names), why, say),
                         FF_HINT_SAY);
}

/* Azimuths are what goes beyond a right angle. */
static int is_wide(const ff_plan_column *c)
{
    return c->hi > 90.01 || c->lo < -90.01;
}

/* The unit of column k as the option has it, as far as its name or its numbers say it; an elevation is one of theta. */
static const char *unit_of(const ff_planner *p, size_t k, int theta, int radians)
{
    const ff_named *one = &p->column[k].named;
    const int rad = one->unit == FF_CSV_RADIANS || (one->unit == FF_CSV_PLAIN && radians);
    if (theta && one->is_elevation) return rad ? ":elevation-rad" : ":elevation";
    return rad ? ":rad" : "";
}

/* The first columns in the order that most tables have, for those whose names say nothing. */
void ff_plan_guess(const ff_planner *p, char *out, size_t size)
{
    static const char *const usual[6] = {"",
                                         "",
                                         "theta_i=20,phi_i=0,theta_o=#1,phi_o=180,f=#2",
                                         "theta_i=#1,phi_i=0,theta_o=#2,phi_o=180,f=#3",
                                         "theta_i=#1,phi_i=0,theta_o=#2,phi_o=#3,f=#4",
                                         "theta_i=#1,phi_i=#2,theta_o=#3,phi_o=#4,f=#5"};
    static const char by_light[] = "theta_i=#1,theta_o=#2,phi_i=#3,phi_o=#4,f=#5";
    size_t n = p->n, used = 0;
    double largest = 0;
    for (size_t k = 0; k + 1 < n; k++) largest = fmax(largest, fmax(fabs(p->column[k].lo), fabs(p->column[k].hi)));
    const int radians = largest <= 6.2832;
    if (n > 5) n = 5;
    const char *item = n == 5 && is_wide(&p->column[2]) && !is_wide(&p->column[1]) ? by_light : usual[n];
    for (out[0] = '\0'; *item && used < size;) {
        const size_t length = strcspn(item, ","), sign = strcspn(item, "#");
        const int goes_by_number = sign < length && *item != 'f';
        const char *unit = goes_by_number ? unit_of(p, (size_t)(item[sign + 1] - '1'), *item == 't', radians) : "";
        used += (size_t)snprintf(out + used, size - used, "%s%.*s%s", used ? "," : "", (int)length, item, unit);
        item += length + (item[length] == ',');
    }
}

/* The last line of words above the rows, as many cells as these have; 0: none. */
static size_t line_of_words(const ff_planner *p)
{
    for (size_t k = p->look->first_row - 1; k-- > 0;) {
        const ff_csv_line *l = &p->look->line[k];
        if (!l->is_comment && !l->is_row && l->full >= 2 && l->full == p->n) return k + 1;
    }
    return 0;
}

ff_status ff_plan_refuse_unnamed(ff_planner *p)
{
    char say[256], words[FF_QUOTE];
    ff_plan_guess(p, say, sizeof say);
    const size_t line = line_of_words(p);
    const ff_csv_line *l = line ? &p->look->line[line - 1] : NULL;
    if (l)
        return ff_error_hint(
            p->err,
            ff_error_set(p->err, FF_ERR_FORMAT, p->path, (long)line, -1,
                         "found the names %s, none of which says which angle it is; if the columns are in the usual "
                         "order, say columns '%s'",
                         ff_quote(l->text, l->length, words), say),
            FF_HINT_SAY);
    return ff_error_hint(
        p->err,
        ff_error_set(p->err, FF_ERR_FORMAT, p->path, (long)p->look->first_row, -1,
                     "found %zu columns and no line of names above them that says which angle is which, expected one as "
                     "theta_i,phi_i,theta_o,phi_o,f; if they are in this order, say columns '%s'",
                     p->n, say),
        FF_HINT_SAY);
}

/* ---- looking for columns ----------------------------------------------------------------------------- */

/* The column of a meaning, without a number in its name; FF_PLAN_NONE. */
long ff_plan_find(const ff_planner *p, ff_meaning meaning)
{
    for (size_t k = 0; k < p->n; k++)
        if (p->column[k].named.meaning == meaning && isnan(p->column[k].named.number) && isfinite(p->column[k].lo)) return (long)k;
    return FF_PLAN_NONE;
}
