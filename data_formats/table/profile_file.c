/* Files of a tabulated distribution. */
#define _GNU_SOURCE
#include "profile_file_struct.h"
#include "base/internal_output.h"
#include "base/internal_input.h"
#include "base/internal_number.h"
#include "base/internal_options.h"
#include "internal_table.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

static const double degree = 3.14159265358979323846 / 180;
static const char *const column[2][2] = {[FF_PROFILE_D] = {"theta_deg", "D"}, [FF_PROFILE_P] = {"q2", "p"}};
/* How well D is known: of a table that was retrieved, which no reader needs. */
static const char *const note[2] = {"d_relative_std_error", "known"};
enum { MOST_COLUMNS = 4 };

/* ---- reading --------------------------------------------------------------------------------- */

typedef struct reader {
    ff_lines lines;
    ff_error *err;
    const char *path;
    ff_profile_kind kind;
    size_t n_columns, n, capacity;
    double *x, *y;
    long *line; /* [n] where each point stands */
} reader;

/* The next line that is neither blank nor a comment; *text is NULL at the end. */
static ff_status next_line(reader *r, char **text, size_t *length)
{
    for (;;) {
        const ff_status status = ff_lines_next(&r->lines, text, length, r->err);
        if (status || !*text) return status;
        const char *start = *text + strspn(*text, " \t");
        if (*start && *start != '#') return FF_OK;
    }
}

static int has_notes(const ff_names *names)
{
    return names->n == MOST_COLUMNS && strcmp(names->name[2], note[0]) == 0 && strcmp(names->name[3], note[1]) == 0;
}

static ff_status read_header(reader *r)
{
    char *text, list[FF_NAMES_LIST];
    size_t length;
    ff_names names = {0};
    ff_status status = next_line(r, &text, &length);
    if (status) return status;
    if (!text)
        return ff_error_set(r->err, FF_ERR_READ, r->path, r->lines.line, -1,
                            "found the end of the file, expected a header line theta_deg,D or q2,p");
    status = ff_names_read(text, length, r->path, r->lines.line, &names, r->err);
    if (status) return status;
    int known = 0;
    for (int kind = 0; kind < 2; kind++)
        if (names.n >= 2 && strcmp(names.name[0], column[kind][0]) == 0 && strcmp(names.name[1], column[kind][1]) == 0) {
            r->kind = (ff_profile_kind)kind;
            known = names.n == 2 || has_notes(&names);
        }
    r->n_columns = names.n;
    if (!known)
        status = ff_error_set(r->err, FF_ERR_FORMAT, r->path, r->lines.line, -1,
                              "found the columns %s, expected theta_deg,D or q2,p", ff_names_list(&names, list));
    ff_names_free(&names);
    return status;
}

/* Room for one more point. */
static ff_status grow(reader *r)
{
    if (r->n < r->capacity) return FF_OK;
    const size_t capacity = r->capacity ? 2 * r->capacity : 256;
    double *x = realloc(r->x, capacity * sizeof *x);
    if (x) r->x = x;
    double *y = realloc(r->y, capacity * sizeof *y);
    if (y) r->y = y;
    long *line = realloc(r->line, capacity * sizeof *line);
    if (line) r->line = line;
    if (!x || !y || !line)
        return ff_error_set(r->err, FF_ERR_MEMORY, r->path, r->lines.line, -1, "no memory for %zu points", capacity);
    r->capacity = capacity;
    return FF_OK;
}

static ff_status read_rows(reader *r)
{
    static const size_t slot[MOST_COLUMNS] = {0, 1, 2, 3};
    static const unsigned char may_be_empty[MOST_COLUMNS] = {0, 0, 1, 1};
    char names[MOST_COLUMNS][24], *const name[MOST_COLUMNS] = {names[0], names[1], names[2], names[3]};
    for (int k = 0; k < MOST_COLUMNS; k++) snprintf(names[k], sizeof names[k], "%s", k < 2 ? column[r->kind][k] : note[k - 2]);
    const ff_columns columns = {r->n_columns, name, slot, may_be_empty, NULL};
    for (;;) {
        char *text;
        size_t length;
        double row[MOST_COLUMNS];
        ff_status status = next_line(r, &text, &length);
        if (status || !text) return status;
        status = ff_row_read(text, length, &columns, row, r->path, r->lines.line, r->err);
        if (!status) status = grow(r);
        if (status) return status;
        r->x[r->n] = r->kind == FF_PROFILE_D ? row[0] * degree : row[0];
        r->y[r->n] = row[1];
        r->line[r->n++] = r->lines.line;
    }
}

/* The table; what it refuses is said with the line of the point. */
static ff_status make(const reader *r, ff_profile_table *out)
{
    ff_error why = {0};
    size_t bad = r->n;
    const ff_status status = ff_profile_make(r->kind, r->n, r->x, r->y, out, &bad, &why);
    if (status == FF_OK) return status;
    const long line = bad < r->n ? r->line[bad] : 0;
    return ff_error_set(r->err, status, r->path, line, -1, "%s", why.message);
}

ff_status ff_profile_read_into(const char *path, ff_profile_table *out, ff_error *err)
{
    reader r = {.err = err, .path = path};
    ff_status status = ff_lines_open(path, &r.lines, err);
    if (status) return status;
    status = read_header(&r);
    if (!status) status = read_rows(&r);
    if (!status) status = make(&r, out);
    ff_lines_close(&r.lines);
    free(r.x);
    free(r.y);
    free(r.line);
    return status;
}

/* ---- writing --------------------------------------------------------------------------------- */

static void write_comment(const char *comment, FILE *file)
{
    while (comment && *comment) {
        const size_t length = strcspn(comment, "\n");
        fprintf(file, "# %.*s\n", (int)length, comment);
        comment += length + (comment[length] == '\n');
    }
}

static void write_number(double v, FILE *file)
{
    char number[FF_NUMBER_TEXT];
    fwrite(number, 1, ff_number_write(v, number), file);
}

ff_status ff_profile_write_noted(const char *path, ff_profile_kind kind, size_t n, const double *x, const double *y,
                                 const double *error, const unsigned char *known, const char *comment, ff_outputs *with,
                                 ff_error *err)
{
    if (kind != FF_PROFILE_D && kind != FF_PROFILE_P)
        return ff_error_set(err, FF_ERR_RANGE, path, 0, -1, "a profile of kind %d, expected %d or %d", (int)kind, (int)FF_PROFILE_D,
                            (int)FF_PROFILE_P);
    const double most = kind == FF_PROFILE_D ? FF_HORIZON : INFINITY;
    for (size_t i = 0; i < n; i++)
        if (!(x[i] >= 0 && x[i] <= most) || !isfinite(x[i]) || !isfinite(y[i]))
            return ff_error_set(err, FF_ERR_DATA, path, 0, -1,
                                "point %zu: found %s = %g, %s = %g, expected finite numbers, the first at or above 0%s", i,
                                kind == FF_PROFILE_D ? "theta" : column[kind][0], x[i], column[kind][1], y[i],
                                kind == FF_PROFILE_D ? " and up to pi/2" : "");
    ff_output out;
    const ff_status status = ff_output_open_with(path, with, &out, err);
    if (status) return status;
    write_comment(comment, out.file);
    fprintf(out.file, "%s,%s", column[kind][0], column[kind][1]);
    if (error) fprintf(out.file, ",%s,%s", note[0], note[1]);
    putc('\n', out.file);
    for (size_t i = 0; i < n; i++) { /* degrees to 1e-12, so that round ones stay round */
        write_number(kind == FF_PROFILE_D ? round(x[i] / degree * 1e12) / 1e12 : x[i], out.file);
        putc(',', out.file);
        write_number(y[i], out.file);
        if (error) {
            putc(',', out.file);
            write_number(error[i], out.file);
            fputs(known[i] ? ",1" : ",0", out.file);
        }
        putc('\n', out.file);
    }
    return ff_output_commit(&out, err);
}

ff_status ff_profile_write(const char *path, ff_profile_kind kind, size_t n, const double *x, const double *y, const char *comment,
                           ff_error *err)
{
    return ff_profile_write_noted(path, kind, n, x, y, NULL, NULL, comment, NULL, err);
}

ff_status ff_profile_read(const char *path, ff_profile_table **out, ff_error *err)
{
    ff_profile_table *made = malloc(sizeof *made);
    if (!made) return ff_error_set(err, FF_ERR_MEMORY, NULL, 0, -1, "out of memory");
    const ff_status status = ff_profile_read_into(path, made, err);
    if (status)
        ff_profile_free(made);
    else
        *out = made;
    return status;
}
