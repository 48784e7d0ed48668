/* The CSV of an image stack: comments, header line, cells. */
#include "internal_stack.h"
#include "base/internal_number.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

static const double pi = 3.14159265358979323846;
static const double degree = 3.14159265358979323846 / 180;

static const char *const ff_stack_column_name[FF_STACK_COLUMNS] = {"theta_i", "phi_i", "theta_o", "phi_o",  "scale", "exposure",
                                                                   "x",       "y",     "width",   "height", "image", "mask"};
static const char *const quantity_name[3] = {"brdf", "brdf-cos", "reflectance-factor"};

/* ---- comments -------------------------------------------------------------------------------- */

static ff_status bad_comment(const ff_image_stack *f, const char *key, const char *found, const char *expected)
{
    char quoted[FF_QUOTE];
    return ff_error_set(f->err, FF_ERR_FORMAT, f->path, f->lines.line, -1, "'# %s:': found %s, expected %s", key,
                        ff_quote(found, strlen(found), quoted), expected);
}

static ff_status set_version(ff_image_stack *f, const char *key, const char *value)
{
    return strcmp(value, "1") == 0 ? FF_OK : bad_comment(f, key, value, "version 1");
}

static ff_status set_quantity(ff_image_stack *f, const char *key, const char *value)
{
    for (int q = 0; q < 3; q++)
        if (strcasecmp(value, quantity_name[q]) == 0) {
            f->quantity = q;
            return FF_OK;
        }
    return bad_comment(f, key, value, "brdf, brdf-cos or reflectance-factor");
}

static ff_status set_angles(ff_image_stack *f, const char *key, const char *value)
{
    if (strcasecmp(value, "degrees") != 0 && strcasecmp(value, "radians") != 0)
        return bad_comment(f, key, value, "degrees or radians");
    f->radians_per_unit = strcasecmp(value, "radians") == 0 ? 1 : degree;
    return FF_OK;
}

static ff_status set_isotropic(ff_image_stack *f, const char *key, const char *value)
{
    if (strcasecmp(value, "yes") != 0 && strcasecmp(value, "no") != 0) return bad_comment(f, key, value, "yes or no");
    f->isotropic = strcasecmp(value, "yes") == 0;
    return FF_OK;
}

int ff_gamma_is_right(double gamma)
{
    return gamma >= 0.1 && gamma <= 10;
}

ff_encoding ff_encoding_of(const char *word)
{
    ff_encoding e = {FF_CURVE_UNKNOWN, 1};
    if (strcasecmp(word, "linear") == 0 || strcasecmp(word, "scene_linear") == 0 || strncasecmp(word, "lin_", 4) == 0)
        e.curve = FF_CURVE_LINEAR;
    else if (strcasecmp(word, "srgb") == 0)
        e.curve = FF_CURVE_SRGB;
    else if (strcasecmp(word, "rec709") == 0)
        e.curve = FF_CURVE_REC709;
    else if (strncasecmp(word, "gamma", 5) == 0) {
        const char *end = ff_number_read(word + 5 + (word[5] == ':'), &e.gamma);
        if (end && *end == '\0' && ff_gamma_is_right(e.gamma)) e.curve = e.gamma == 1 ? FF_CURVE_LINEAR : FF_CURVE_GAMMA;
    }
    return e;
}

static ff_status set_encoding(ff_image_stack *f, const char *key, const char *value)
{
    f->said = ff_encoding_of(value);
    return f->said.curve ? FF_OK : bad_comment(f, key, value, "linear, srgb, rec709 or gamma:EXPONENT");
}

static int is_whole(double v, double least)
{
    return v >= least && v <= 1e9 && v == floor(v);
}

static ff_status set_region(ff_image_stack *f, const char *key, const char *value)
{
    const char *p = value;
    for (int k = 0; k < 4; k++) {
        const char *end = ff_number_read(p + strspn(p, " \t"), &f->region[k]);
        if (end) end += strspn(end, " \t");
        if (!end || *end != (k < 3 ? ',' : '\0') || !is_whole(f->region[k], k < 2 ? 0 : 1))
            return bad_comment(f, key, value, "x,y,width,height: whole numbers of pixels");
        p = end + 1;
    }
    f->with_region = 1;
    return FF_OK;
}

/* "# key: value"; other comments say nothing to us. */
static ff_status read_comment(ff_image_stack *f, char *text)
{
    static const struct {
        const char *key;
        ff_status (*set)(ff_image_stack *, const char *, const char *);
    } known[] = {{"quantity", set_quantity}, {"angles", set_angles},           {"isotropic", set_isotropic},
                 {"encoding", set_encoding}, {"facetfit-images", set_version}, {"region", set_region}};
    char *key = text + strspn(text, "# \t"), *colon = strchr(key, ':');
    if (!colon) return FF_OK;
    char *value = colon + 1 + strspn(colon + 1, " \t"), *end = value + strlen(value);
    while (end > value && strchr(", \t\"", end[-1])) end--; /* commas at the end are what a spreadsheet adds */
    *end = '\0';
    for (*colon-- = '\0'; colon >= key && (*colon == ' ' || *colon == '\t'); colon--) *colon = '\0';
    for (size_t k = 0; k < sizeof known / sizeof known[0]; k++) {
        if (strcasecmp(key, known[k].key) != 0) continue;
        if (f->n_cells)
            return ff_error_set(f->err, FF_ERR_FORMAT, f->path, f->lines.line, -1,
                                "found '# %s:' after the header, expected it before", known[k].key);
        return known[k].set(f, known[k].key, value);
    }
    return FF_OK;
}

ff_status ff_stack_next_line(ff_image_stack *f, char **text, size_t *length)
{
    for (;;) {
        ff_status status = ff_lines_next(&f->lines, text, length, f->err);
        if (status != FF_OK || !*text) return status;
        char *start = *text + strspn(*text, " \t");
        if (*start == '"' && start[1] == '#') start++; /* a comment that a spreadsheet has quoted */
        if (*start == '#' && (status = read_comment(f, start)) != FF_OK) return status;
        if (*start != '#' && *start != '\0') return FF_OK;
    }
}

/* ---- header ---------------------------------------------------------------------------------- */

static ff_status bad_header(const ff_image_stack *f, const ff_names *names, const char *name, const char *why)
{
    char found[FF_NAMES_LIST], quoted[FF_QUOTE];
    return ff_error_set(f->err, FF_ERR_FORMAT, f->path, f->lines.line, -1, "column %s %s; found the columns %s",
                        ff_quote(name, strlen(name), quoted), why, ff_names_list(names, found));
}

static ff_status place_columns(ff_image_stack *f, const ff_names *names)
{
    for (size_t k = 0; k < names->n; k++) {
        int c = 0;
        while (c < FF_STACK_COLUMNS && strcmp(names->name[k], ff_stack_column_name[c]) != 0) c++;
        if (c == FF_STACK_COLUMNS)
            return bad_header(f, names, names->name[k],
                              "is none of image, theta_i, phi_i, theta_o, phi_o, scale, exposure, mask, x, y, width, height");
        f->column[c] = (long)k;
    }
    static const int needed[] = {FF_STACK_IMAGE, FF_STACK_THETA_I, FF_STACK_PHI_I, FF_STACK_THETA_O, FF_STACK_PHI_O};
    for (size_t k = 0; k < sizeof needed / sizeof needed[0]; k++)
        if (f->column[needed[k]] < 0) return bad_header(f, names, ff_stack_column_name[needed[k]], "is missing");
    for (int c = FF_STACK_X; c <= FF_STACK_HEIGHT; c++)
        if ((f->column[c] < 0) != (f->column[FF_STACK_X] < 0))
            return bad_header(f, names, ff_stack_column_name[f->column[FF_STACK_X] < 0 ? FF_STACK_X : c],
                              "is missing: a region has x, y, width and height");
    f->n_cells = names->n;
    f->cell = calloc(names->n, sizeof *f->cell);
    return f->cell ? FF_OK : ff_error_set(f->err, FF_ERR_MEMORY, f->path, f->lines.line, -1, "no memory for %zu columns", names->n);
}

ff_status ff_stack_read_header(ff_image_stack *f)
{
    char *text;
    size_t length;
    ff_names names;
    ff_status status = ff_stack_next_line(f, &text, &length);
    if (status != FF_OK) return status;
    if (!text)
        return ff_error_set(f->err, FF_ERR_READ, f->path, f->lines.line, -1,
                            "found the end of the file, expected a header line image,theta_i,phi_i,theta_o,phi_o");
    status = ff_names_read(text, length, f->path, f->lines.line, &names, f->err);
    if (status != FF_OK) return status;
    status = place_columns(f, &names);
    ff_names_free(&names);
    return status;
}

/* ---- cells ----------------------------------------------------------------------------------- */

size_t ff_stack_cut_cells(ff_image_stack *f, char *p)
{
    size_t n = 0;
    for (;;) {
        p += strspn(p, " \t");
        char *start = p, *to = p;
        if (*p == '"') {
            for (p++; *p && (*p != '"' || p[1] == '"'); p++) {
                if (*p == '"') p++;
                *to++ = *p;
            }
            p += strcspn(p, ",");
        } else {
            while (*p && *p != ',') *to++ = *p++;
            while (to > start && (to[-1] == ' ' || to[-1] == '\t')) to--;
        }
        const int last = *p == '\0';
        *to = '\0';
        if (n < f->n_cells) f->cell[n] = start;
        n++;
        if (last) return n;
        p++;
    }
}

const char *ff_stack_cell(const ff_image_stack *f, int column)
{
    return f->column[column] >= 0 ? f->cell[f->column[column]] : "";
}

ff_status ff_stack_bad_cell(const ff_image_stack *f, int column, const char *expected)
{
    char found[FF_QUOTE];
    const char *text = ff_stack_cell(f, column);
    return ff_error_set(f->err, FF_ERR_DATA, f->path, f->lines.line, -1, "column '%s': found %s, expected %s",
                        ff_stack_column_name[column], *text ? ff_quote(text, strlen(text), found) : "an empty cell", expected);
}

ff_status ff_stack_read_numbers(const ff_image_stack *f, double v[FF_STACK_NUMBERS])
{
    const int radians = f->radians_per_unit == 1;
    for (int c = 0; c < FF_STACK_NUMBERS; c++) {
        const char *text = ff_stack_cell(f, c);
        v[c] = NAN;
        if (*text == '\0' && c > FF_STACK_PHI_O) continue;
        const char *end = ff_number_read(text, &v[c]);
        if (!end || *end || !isfinite(v[c])) return ff_stack_bad_cell(f, c, "a finite number");
        if ((c == FF_STACK_THETA_I || c == FF_STACK_THETA_O) && fabs(v[c]) > (radians ? pi + 1e-9 : 180))
            return ff_stack_bad_cell(f, c, radians ? "radians from -pi to pi" : "degrees from -180 to 180");
        if ((c == FF_STACK_SCALE || c == FF_STACK_EXPOSURE) && !(v[c] > 0)) return ff_stack_bad_cell(f, c, "a number > 0");
        if (c >= FF_STACK_X && !is_whole(v[c], c < FF_STACK_WIDTH ? 0 : 1))
            return ff_stack_bad_cell(f, c, "a whole number of pixels");
    }
    for (int c = FF_STACK_X; c <= FF_STACK_HEIGHT; c++)
        if (isnan(v[c]) != isnan(v[FF_STACK_X]))
            return ff_stack_bad_cell(f, isnan(v[c]) ? c : FF_STACK_X, "a region of x, y, width and height");
    return FF_OK;
}
