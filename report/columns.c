/* Tables in their written forms. All cells are made before the first is printed: text needs the widths. */
#define _GNU_SOURCE
#include "internal_columns.h"
#include "base/internal_kept.h"
#include <ctype.h>
#include <math.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

/* ---- cells ----------------------------------------------------------------------------------- */

void ff_cell_text(ff_cell *cell, const char *format, ...)
{
    va_list args;
    va_start(args, format);
    vsnprintf(cell->text, sizeof cell->text, format, args);
    va_end(args);
}

void ff_cell_rounded(ff_cell *cell, double x, const char *text)
{
    snprintf(cell->text, sizeof cell->text, "%s", text);
    cell->number = x;
    cell->is_number = 1;
}

void ff_cell_number(ff_cell *cell, double x, int significant)
{
    char text[FF_TEXT_NUMBER];
    ff_cell_rounded(cell, x, ff_text_number(x, significant, text));
}

void ff_cell_fixed(ff_cell *cell, double x, int decimals)
{
    char text[FF_TEXT_NUMBER];
    ff_cell_rounded(cell, x, ff_text_fixed(x, decimals, text));
}

void ff_cell_exact(ff_cell *cell, double x)
{
    char text[FF_TEXT_NUMBER];
    ff_cell_rounded(cell, x, ff_text_exact(x, text));
}

/* ---- forms ----------------------------------------------------------------------------------- */

/* A cell that is ready to be printed: its characters in the form of the table. */
typedef struct grid {
    size_t columns, rows; /* the head is row 0                        */
    char **cell;          /* [rows][columns]                          */
    ff_ink *ink;          /* [rows][columns]                          */
    ff_align *align;      /* [columns]                                */
    size_t *width;        /* [columns], for text                      */
    const ff_column **of; /* [columns]                                */
    ff_report_style style;
} grid;

typedef struct form {
    const char *name;
    const char *remark; /* what a line under the table begins with; NULL: it has none */
    int exact;
    /* The characters of a cell, to be freed; NULL: no memory. */
    char *(*written)(const ff_cell *cell);
    void (*print)(grid *g, const char *indent, FILE *out);
} form;

/* Copies text, with escape(c) instead of a character c for which that is not NULL. */
static char *escaped(const char *text, const char *(*escape)(char c))
{
    ff_kept out;
    FILE *memory = ff_kept_open(&out);
    if (!memory) return NULL;
    for (; *text; text++) {
        const char *other = escape(*text);
        if (other)
            fputs(other, memory);
        else
            fputc(*text, memory);
    }
    ff_kept_close(&out, memory);
    return out.text;
}

/* ---- text ------------------------------------------------------------------------------------ */

static char *text_written(const ff_cell *cell)
{
    ff_kept out;
    FILE *memory = ff_kept_open(&out);
    if (!memory) return NULL;
    ff_text_print(cell->text, memory);
    ff_kept_close(&out, memory);
    return out.text;
}

/* The end of a cell that there is no room for. */
static const char cut[] = "..";

static void text_cell(const grid *g, size_t at, size_t width, FILE *out)
{
    const char *text = g->cell[at], *ink = ff_text_ink(g->style.color, g->ink[at]);
    const int whole = ff_text_width(text) <= width;
    const size_t n = whole ? strlen(text) : ff_text_fitting(text, width - (sizeof cut - 1));
    fprintf(out, "%s%.*s%s%s", ink, (int)n, text, whole ? "" : cut, *ink ? ff_text_ink(1, FF_INK_PLAIN) : "");
}

/* The last cell of a row that goes on below itself, words whole where they fit; `start`: its first column. */
static void wrapped_cell(const grid *g, size_t at, size_t start, size_t width, FILE *out)
{
    const char *text = g->cell[at];
    for (;;) {
        size_t n = ff_text_fitting(text, width);
        const int rest = text[n] != '\0';
        for (size_t k = n; rest && k > 0 && text[n] != ' '; k--)
            if (text[k - 1] == ' ') n = k - 1;
        fprintf(out, "%.*s", (int)n, text);
        text += n;
        while (*text == ' ') text++;
        if (!*text) return;
        fprintf(out, "\n%*s", (int)start, "");
    }
}

/* A column that was left out has no width. */
static void text_row(const grid *g, size_t row, const char *indent, FILE *out)
{
    size_t last = 0, pending = 0, column = strlen(indent);
    for (size_t c = 0; c < g->columns; c++)
        if (g->width[c] && g->cell[row * g->columns + c][0]) last = c + 1;
    fputs(indent, out);
    for (size_t c = 0; c < last; c++) { /* no spaces at the end of a line */
        const size_t at = row * g->columns + c, w = ff_text_width(g->cell[at]), fill = w < g->width[c] ? g->width[c] - w : 0;
        if (!g->width[c]) continue;
        fprintf(out, "%*s", (int)(pending + (g->align[c] == FF_RIGHT ? fill : 0)), "");
        if (g->of[c]->wraps && w > g->width[c])
            wrapped_cell(g, at, column, g->width[c], out);
        else
            text_cell(g, at, g->width[c], out);
        pending = 2 + (g->align[c] == FF_RIGHT ? 0 : fill);
        column += g->width[c] + 2;
    }
    fputc('\n', out);
}

static size_t text_total(const grid *g, const char *indent)
{
    size_t total = strlen(indent), shown = 0;
    for (size_t c = 0; c < g->columns; c++)
        if (g->width[c]) total += g->width[c] + (shown++ ? 2 : 0);
    return total;
}

/* Leaves out one column, of those that may go the one that goes first; 0: none may. */
static int leave_out_one(grid *g)
{
    size_t found = g->columns;
    for (size_t c = 0; c < g->columns; c++)
        if (g->width[c] && g->of[c]->drop && (found == g->columns || g->of[c]->drop >= g->of[found]->drop)) found = c;
    if (found == g->columns) return 0;
    g->width[found] = 0;
    return 1;
}

/* Takes one column of the terminal from the widest that may be cut; 0: none may. */
static int cut_one(grid *g)
{
    size_t found = g->columns;
    for (size_t c = 0; c < g->columns; c++)
        if (g->of[c]->least && g->width[c] > g->of[c]->least && (found == g->columns || g->width[c] > g->width[found])) found = c;
    if (found == g->columns) return 0;
    g->width[found]--;
    return 1;
}

static void text_print(grid *g, const char *indent, FILE *out)
{
    for (size_t k = 0; k < g->rows * g->columns; k++) {
        const size_t w = ff_text_width(g->cell[k]);
        if (w > g->width[k % g->columns]) g->width[k % g->columns] = w;
    }
    while (g->style.width && text_total(g, indent) > g->style.width && (leave_out_one(g) || cut_one(g))) continue;
    size_t first = 1; /* a head of nothing is left out */
    for (size_t c = 0; c < g->columns; c++)
        if (g->cell[c][0]) first = 0;
    for (size_t i = first; i < g->rows; i++) text_row(g, i, indent, out);
}

/* ---- CSV and TSV ----------------------------------------------------------------------------- */

static char *number_written(const ff_cell *cell)
{
    char number[FF_TEXT_NUMBER];
    return strdup(isnan(cell->number) ? "" : ff_text_exact(cell->number, number));
}

static const char *csv_escape(char c)
{
    return c == '"' ? "\"\"" : NULL;
}

/* RFC 4180: in quotes where there is a comma, a quote or a line end. */
static char *csv_written(const ff_cell *cell)
{
    if (cell->is_number) return number_written(cell);
    if (!strpbrk(cell->text, ",\"\r\n")) return strdup(cell->text);
    char *inside = escaped(cell->text, csv_escape), *out = NULL;
    if (inside && asprintf(&out, "\"%s\"", inside) < 0) out = NULL;
    free(inside);
    return out;
}

static const char *tsv_escape(char c)
{
    return c == '\t' || c == '\n' || c == '\r' ? " " : NULL;
}

static char *tsv_written(const ff_cell *cell)
{
    return cell->is_number ? number_written(cell) : escaped(cell->text, tsv_escape);
}

static void print_separated(const grid *g, const char *before, const char *between, const char *after, size_t row, FILE *out)
{
    fputs(before, out);
    for (size_t c = 0; c < g->columns; c++) fprintf(out, "%s%s", c ? between : "", g->cell[row * g->columns + c]);
    fputs(after, out);
}

static void csv_print(grid *g, const char *indent, FILE *out)
{
    (void)indent;
    for (size_t i = 0; i < g->rows; i++) print_separated(g, "", ",", "\n", i, out);
}

static void tsv_print(grid *g, const char *indent, FILE *out)
{
    (void)indent;
    for (size_t i = 0; i < g->rows; i++) print_separated(g, "", "\t", "\n", i, out);
}

/* ---- Markdown -------------------------------------------------------------------------------- */

static const char *markdown_escape(char c)
{
    return c == '|' ? "\\|" : c == '*' ? "\\*" : c == '~' ? "\\~" : c == '_' ? "\\_" : c == '<' ? "\\<" : c == '\n' ? " " : NULL;
}

static char *markdown_written(const ff_cell *cell)
{
    return escaped(cell->text, markdown_escape);
}

static void markdown_print(grid *g, const char *indent, FILE *out)
{
    (void)indent;
    for (size_t i = 0; i < g->rows; i++) {
        print_separated(g, "| ", " | ", " |\n", i, out);
        if (i) continue;
        for (size_t c = 0; c < g->columns; c++) fputs(g->align[c] == FF_RIGHT ? "|---:" : "|---", out);
        fputs("|\n", out);
    }
}

/* ---- LaTeX ----------------------------------------------------------------------------------- */

static const char *latex_escape(char c)
{
    switch (c) {
    case '&':
        return "\\&";
    case '%':
        return "\\%";
    case '$':
        return "\\$";
    case '#':
        return "\\#";
    case '_':
        return "\\_";
    case '{':
        return "\\{";
    case '}':
        return "\\}";
    case '~':
        return "$\\sim$";
    case '^':
        return "\\^{}";
    case '\\':
        return "\\textbackslash{}";
    case '<':
        return "$<$";
    case '>':
        return "$>$";
    case '|':
        return "$|$";
    case '\n':
        return " ";
    default:
        return NULL;
    }
}

/* "4.91e-06" as $4.91\times10^{-6}$, the minus as it should be. */
static char *latex_number(const char *text)
{
    const char *e = strchr(text, 'e');
    char *out = NULL;
    const int n = e ? asprintf(&out, "$%.*s\\times10^{%d}$", (int)(e - text), text, atoi(e + 1)) : asprintf(&out, "$%s$", text);
    return n < 0 ? NULL : out;
}

static char *latex_written(const ff_cell *cell)
{
    if (!cell->is_number) return escaped(cell->text, latex_escape);
    if (!isfinite(cell->number)) return strdup(isnan(cell->number) ? "" : cell->number > 0 ? "$\\infty$" : "$-\\infty$");
    return latex_number(cell->text);
}

static void latex_print(grid *g, const char *indent, FILE *out)
{
    (void)indent;
    fputs("\\begin{tabular}{", out);
    for (size_t c = 0; c < g->columns; c++) fputc(g->align[c] == FF_RIGHT ? 'r' : 'l', out);
    fputs("}\n\\hline\n", out);
    for (size_t i = 0; i < g->rows; i++) {
        print_separated(g, "", " & ", " \\\\\n", i, out);
        if (i == 0) fputs("\\hline\n", out);
    }
    fputs("\\hline\n\\end{tabular}\n", out);
}

/* ---- all forms ------------------------------------------------------------------------------- */

static const form forms[] = {[FF_TABLE_TEXT] = {"text", "   ", 0, text_written, text_print},
                             [FF_TABLE_CSV] = {"csv", NULL, 1, csv_written, csv_print},
                             [FF_TABLE_TSV] = {"tsv", NULL, 1, tsv_written, tsv_print},
                             [FF_TABLE_MARKDOWN] = {"md", "\n", 0, markdown_written, markdown_print},
                             [FF_TABLE_LATEX] = {"latex", "% ", 0, latex_written, latex_print}};

const char *ff_table_form_name(int form)
{
    return form >= 0 && form < (int)FF_COUNT(forms) ? forms[form].name : NULL;
}

int ff_table_form_exact(ff_table_form form)
{
    return forms[form].exact;
}

/* ---- printing -------------------------------------------------------------------------------- */

static int is_wanted(const ff_column *c, const void *of, int exact)
{
    return (c->audience == FF_EVERYBODY || (c->audience == FF_PROGRAMS) == exact) && (!c->wanted || c->wanted(of));
}

/* "std error" as std_error where programs read it. */
static void head_cell(const ff_column *c, int exact, ff_cell *out)
{
    snprintf(out->text, sizeof out->text, "%s", exact && c->key ? c->key : c->head);
    if (!exact || c->key) return;
    for (char *s = out->text; *s; s++)
        if (isspace((unsigned char)*s)) *s = '_';
}

static void grid_free(grid *g)
{
    for (size_t i = 0; g->cell && i < g->rows * g->columns; i++) free(g->cell[i]);
    free(g->cell);
    free(g->ink);
    free(g->align);
    free(g->width);
    free(g->of);
}

/* Fills the g->columns wanted columns. */
static ff_status grid_fill(grid *g, const ff_column *column, size_t n, const void *of, const form *f)
{
    size_t at = 0;
    for (size_t c = 0; c < n; c++) {
        if (!is_wanted(&column[c], of, f->exact)) continue;
        g->align[at] = column[c].align;
        g->of[at] = &column[c];
        for (size_t i = 0; i < g->rows; i++) {
            ff_cell cell = {.is_number = 0};
            if (i == 0) {
                head_cell(&column[c], f->exact, &cell);
                cell.ink = FF_INK_HEAD;
            } else
                column[c].cell(&cell, (ff_where){of, i - 1, column[c].index});
            g->ink[i * g->columns + at] = cell.ink;
            char *written = f->written(&cell);
            if (!written) return FF_ERR_MEMORY;
            g->cell[i * g->columns + at] = written;
        }
        at++;
    }
    return FF_OK;
}

ff_status ff_columns_print(const ff_column *column, size_t n_columns, const void *of, size_t rows, ff_table_form form,
                           const char *indent, const ff_report_style *style, FILE *out)
{
    grid g = {.rows = rows + 1, .style = style ? *style : (ff_report_style){0}};
    for (size_t c = 0; c < n_columns; c++) g.columns += is_wanted(&column[c], of, forms[form].exact) != 0;
    g.cell = calloc(g.rows * g.columns + 1, sizeof *g.cell);
    g.ink = calloc(g.rows * g.columns + 1, sizeof *g.ink);
    g.align = calloc(g.columns + 1, sizeof *g.align);
    g.width = calloc(g.columns + 1, sizeof *g.width);
    g.of = calloc(g.columns + 1, sizeof *g.of);
    ff_status status =
        g.cell && g.ink && g.align && g.width && g.of ? grid_fill(&g, column, n_columns, of, &forms[form]) : FF_ERR_MEMORY;
    if (status == FF_OK) forms[form].print(&g, indent, out);
    grid_free(&g);
    return status;
}

void ff_columns_remark(ff_table_form form, FILE *out, const char *format, ...)
{
    va_list args;
    if (!forms[form].remark) return;
    fputs(forms[form].remark, out);
    va_start(args, format);
    vfprintf(out, format, args);
    va_end(args);
    fputc('\n', out);
}
