/* What the uncertainties of an instrument add to each parameter, as people read it. */
#include "internal_columns.h"
#include "internal_report.h"
#include <string.h>

typedef struct budget_table {
    const ff_problem *p;
    const ff_fit_result *f;
    const ff_budget *b;
} budget_table;

enum { RANDOM = FF_BUDGET_SOURCES, COMBINED };

static void parameter_cell(ff_cell *out, ff_where w)
{
    const budget_table *t = w.of;
    char name[FF_REPORT_NAME];
    ff_cell_text(out, "%s", ff_report_column_name(t->p, t->f, w.row, name));
}

static void number_cell(ff_cell *out, ff_where w)
{
    const budget_table *t = w.of;
    const double *of = w.index == RANDOM ? t->b->random : w.index == COMBINED ? t->b->combined : t->b->by[w.index];
    ff_cell_number(out, of[w.row], 2);
}

/* The sources that were stated, between the random error and the whole. The whole is to be seen to be their sum: only what it does
 * not count, each reading, is left out where there is no room. */
static size_t put_columns(const ff_budget *b, ff_column *out)
{
    static const char *const head[FF_BUDGET_SOURCES] = {"scale", "zero i", "zero o", "each i", "each o", "aperture"};
    size_t n = 0;
    out[n++] = (ff_column){.head = "", .cell = parameter_cell};
    out[n++] = (ff_column){.head = "random", .align = FF_RIGHT, .cell = number_cell, .index = RANDOM};
    for (size_t s = 0; s < FF_BUDGET_SOURCES; s++)
        if (b->by[s])
            out[n++] =
                (ff_column){.head = head[s], .align = FF_RIGHT, .cell = number_cell, .index = s, .drop = s == FF_BUDGET_READINGS};
    out[n++] = (ff_column){.head = "combined", .align = FF_RIGHT, .cell = number_cell, .index = COMBINED};
    return n;
}

static void put_angle(const char *what, double radians, const char **separator, FILE *out)
{
    char number[FF_TEXT_NUMBER];
    if (!(radians > 0)) return;
    fprintf(out, "%s%s %s deg", *separator, what, ff_text_number(ff_report_degrees(radians), 3, number));
    *separator = ", ";
}

/* "standard uncertainties, of what was stated: scale 2 %, each angle 0.05 deg" */
static void put_stated(const ff_budget_options *u, FILE *out)
{
    char number[FF_TEXT_NUMBER];
    const char *separator = "";
    fputs("\n  standard uncertainties, of what was stated: ", out);
    if (u->scale > 0) {
        fprintf(out, "scale %s %%", ff_text_number(100 * u->scale, 3, number));
        separator = ", ";
    }
    put_angle("zero of theta_i and of theta_o", u->offset, &separator, out);
    put_angle("each theta_i and theta_o", u->angle, &separator, out);
    put_angle("aperture", u->aperture, &separator, out);
    fputc('\n', out);
}

ff_status ff_report_budget_text(const ff_report_fits *r, size_t i, FILE *out)
{
    const ff_fit_trust *trust = r->trust ? &r->trust[i] : NULL;
    if (!trust || !trust->has_budget) return FF_OK;
    const budget_table t = {r->problem[i / (r->n_fits / r->n_problems)], &r->fit[i], &trust->budget};
    ff_column column[FF_BUDGET_SOURCES + 3];
    put_stated(&trust->uncertainties, out);
    const ff_status status =
        ff_columns_print(column, put_columns(t.b, column), &t, t.b->n_columns, FF_TABLE_TEXT, "  ", r->style, out);
    if (t.b->by[FF_BUDGET_READINGS])
        fputs("  each theta_o scatters the data: it is part of the random error, and is not added again\n", out);
    return status;
}
