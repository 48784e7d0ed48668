/* "theta_i=incidence,f=#4:%,phi_i=0": which columns of somebody's CSV are ours.
 *
 *     item      key '=' column [':' unit]              items are separated by commas
 *     key       theta_i phi_i theta_o phi_o f f_NAME sigma sigma_NAME weight wavelength phase; in place of the four angles
 *               theta_h phi_h theta_d phi_d, or wi_x wi_y wi_z wo_x wo_y wo_z
 *     column    NAME, "NAME" (then , : | = # @ and digits are as others), A|B (whichever the file has), #3 (the third),
 *               @NAME (the number behind NAME on the last line that has it alone), or, but for f, a number: the same in every row
 *     unit      deg rad (angles), elevation elevation-rad (theta_i, theta_o: above the surface), nm um m (wavelength), % (f, sigma)
 *
 *     f@ANGLE=5:20:40   columns side by side with values of f, one at each of these theta_i (theta_o, phi_i, phi_o): those that no
 *                       other item names, or with @#2 behind the numbers, from the second on */
#define _GNU_SOURCE
#include "internal_csv.h"
#include "base/internal_input.h"
#include "base/internal_number.h"
#include "base/internal_tokens.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

static const char *const key_name[] = {
    [FF_CSV_THETA_I] = "theta_i", [FF_CSV_PHI_I] = "phi_i",     [FF_CSV_THETA_O] = "theta_o", [FF_CSV_PHI_O] = "phi_o",
    [FF_CSV_VALUE] = "f",         [FF_CSV_SIGMA] = "sigma",     [FF_CSV_WEIGHT] = "weight",   [FF_CSV_WAVELENGTH] = "wavelength",
    [FF_CSV_PHASE] = "phase",     [FF_CSV_THETA_H] = "theta_h", [FF_CSV_PHI_H] = "phi_h",     [FF_CSV_THETA_D] = "theta_d",
    [FF_CSV_PHI_D] = "phi_d",     [FF_CSV_WI_X] = "wi_x",       [FF_CSV_WI_Y] = "wi_y",       [FF_CSV_WI_Z] = "wi_z",
    [FF_CSV_WO_X] = "wo_x",       [FF_CSV_WO_Y] = "wo_y",       [FF_CSV_WO_Z] = "wo_z",
};

static const struct {
    const char *name;
    ff_csv_unit unit;
} units[] = {{"deg", FF_CSV_DEGREES},
             {"rad", FF_CSV_RADIANS},
             {"nm", FF_CSV_NM},
             {"um", FF_CSV_UM},
             {"m", FF_CSV_M},
             {"%", FF_CSV_PERCENT},
             {"elevation", FF_CSV_ELEVATION},
             {"elevation-rad", FF_CSV_ELEVATION_RADIANS}};

typedef struct parser {
    const char *path;
    ff_error *err;
    size_t n_at;
    ff_csv_mapping m;
} parser;

static int is_angle(ff_csv_key key)
{
    return key <= FF_CSV_PHI_O || key == FF_CSV_PHASE || (key >= FF_CSV_THETA_H && key <= FF_CSV_PHI_D);
}

static int unit_fits(ff_csv_key key, ff_csv_unit unit)
{
    if (unit == FF_CSV_PLAIN) return 1;
    if (unit == FF_CSV_ELEVATION || unit == FF_CSV_ELEVATION_RADIANS) return key == FF_CSV_THETA_I || key == FF_CSV_THETA_O;
    if (is_angle(key)) return unit == FF_CSV_DEGREES || unit == FF_CSV_RADIANS;
    if (key == FF_CSV_WAVELENGTH) return unit == FF_CSV_NM || unit == FF_CSV_UM || unit == FF_CSV_M;
    return unit == FF_CSV_PERCENT && (key == FF_CSV_VALUE || key == FF_CSV_SIGMA);
}

static ff_status syntax(const parser *p, const char *item, const char *expected)
{
    char found[FF_QUOTE];
    return ff_error_set(p->err, FF_ERR_SYNTAX, p->path, 0, -1, "columns: found %s, expected %s",
                        ff_quote(item, strlen(item), found), expected);
}

/* Cuts blanks off both ends, in place. */
static char *trim(char *text)
{
    text += strspn(text, " \t");
    for (char *end = text + strlen(text); end > text && (end[-1] == ' ' || end[-1] == '\t');) *--end = '\0';
    return text;
}

static ff_status read_key(const parser *p, char *key, ff_csv_item *item)
{
    char found[FF_QUOTE];
    item->text = key;
    item->channel = "";
    for (int k = 0; k < FF_CSV_KEYS; k++) {
        size_t n = strlen(key_name[k]);
        if (strncmp(key, key_name[k], n) != 0) continue;
        if (k == FF_CSV_VALUE && key[n] == '@') {
            item->key = FF_CSV_VALUE;
            for (int a = 0; a < 4; a++)
                if (strcmp(key + n + 1, key_name[a]) == 0) item->at_key = (ff_csv_key)a, item->n_at = 1;
            if (item->n_at) return FF_OK;
        }
        int named = (k == FF_CSV_VALUE || k == FF_CSV_SIGMA) && key[n] == '_' && key[n + 1];
        if (key[n] && !named) continue;
        item->key = (ff_csv_key)k;
        if (named) item->channel = key + n + 1;
        if (strlen(item->channel) >= FF_CHANNEL_NAME) return syntax(p, key, "a channel's name of at most 63 bytes");
        return FF_OK;
    }
    return ff_error_set(
        p->err, FF_ERR_UNKNOWN, p->path, 0, -1,
        "columns: found the key %s, expected theta_i, phi_i, theta_o, phi_o, f, f_NAME, f@ANGLE, sigma, sigma_NAME, "
        "weight, wavelength, phase, theta_h, phi_h, theta_d, phi_d or wi_x to wo_z",
        ff_quote(key, strlen(key), found));
}

/* Cuts ":unit" off, where what follows the last ':' is one. */
static void take_unit(char *text, ff_csv_item *item)
{
    char *colon = strrchr(text, ':');
    for (size_t k = 0; colon && k < sizeof units / sizeof units[0]; k++) {
        if (strcmp(trim(colon + 1), units[k].name) != 0) continue;
        item->unit = units[k].unit;
        *colon = '\0';
        return;
    }
}

/* What can be the same in many rows. */
static int is_constant_key(ff_csv_key key)
{
    return is_angle(key) || key == FF_CSV_WAVELENGTH;
}

/* "5:20:40@#2:rad" of f@theta_i. */
static ff_status read_columns_at(parser *p, char *text, ff_csv_item *item)
{
    static const char expected[] =
        "f@theta_i=5:20:40 (or theta_o, phi_i, phi_o), or f@theta_i=5:20:40@#2 from the second column on";
    char *from = strchr(text, '@');
    uint64_t first;
    item->at = p->m.at + p->n_at;
    if (from) {
        take_unit(from, item);
        *from++ = '\0';
        from = trim(from);
        if (*from != '#' || !ff_whole_number(from + 1, FF_NAMES_MAX, &first) || first == 0) return syntax(p, item->text, expected);
        item->number = (long)first - 1;
    }
    if (item->unit != FF_CSV_PLAIN && item->unit != FF_CSV_DEGREES && item->unit != FF_CSV_RADIANS)
        return syntax(p, item->text, expected);
    for (const char *at = text; at; item->n_at++) {
        at += strspn(at, " \t");
        const char *end = ff_number_read(at, &item->at[item->n_at]);
        if (!end || (*end && *end != ':') || !isfinite(item->at[item->n_at])) return syntax(p, item->text, expected);
        at = *end ? end + 1 : NULL;
    }
    p->n_at += item->n_at;
    return FF_OK;
}

static ff_status read_column(const parser *p, char *text, ff_csv_item *item)
{
    uint64_t number;
    char *close = *text == '"' ? strrchr(text + 1, '"') : NULL;
    if (*text == '"' && !close) return syntax(p, text, "a name that ends in a quote too");
    take_unit(close ? close : text, item);
    text = trim(text);
    if (!*text) return syntax(p, item->text, "'=' and the name of a column after it");
    if (close) {
        if (*trim(close + 1)) return syntax(p, text, "nothing but ':' and a unit after the closing quote");
        *close = '\0';
        item->column = text + 1;
        item->exact = 1;
    } else if (*text == '@' && is_constant_key(item->key)) {
        item->setting = trim(text + 1);
        if (!*item->setting) return syntax(p, item->text, "'@' and the name that stands before a number");
    } else if (*text == '#' && ff_whole_number(text + 1, FF_NAMES_MAX, &number) && number > 0) {
        item->number = (long)number - 1;
    } else if (*text == '#') {
        return syntax(p, text, "'#' and the number of a column, from 1, and behind it no unit but " FF_CSV_UNITS);
    } else {
        const char *end = item->key == FF_CSV_VALUE ? NULL : ff_number_read(text, &item->constant);
        if (end && !*end && isfinite(item->constant)) return FF_OK;
        item->constant = NAN;
        item->column = text;
    }
    return FF_OK;
}

static ff_status read_item(parser *p, char *text)
{
    ff_csv_item item = {.number = -1, .constant = NAN};
    char *equals = strchr(text, '=');
    if (!equals) return syntax(p, trim(text), "key=column, as in theta_i=incidence");
    *equals = '\0';
    ff_status status = read_key(p, trim(text), &item);
    const int many = item.n_at > 0;
    item.n_at = 0;
    if (status == FF_OK) status = many ? read_columns_at(p, trim(equals + 1), &item) : read_column(p, trim(equals + 1), &item);
    if (status != FF_OK) return status;
    if (!unit_fits(item.key, item.unit))
        return syntax(p, item.text, "a unit of its own: deg or rad of an angle, nm, um or m of a wavelength, % of f and sigma");
    for (size_t k = 0; k < p->m.n; k++) {
        const ff_csv_item *other = &p->m.item[k];
        const char *mine = *item.channel ? item.channel : "f", *theirs = *other->channel ? other->channel : "f";
        if (other->key == item.key && strcmp(mine, theirs) == 0) return syntax(p, item.text, "this key only once");
    }
    p->m.item[p->m.n++] = item;
    return FF_OK;
}

/* Angles that are not named have our own names in the file. */
static void add_angles(ff_csv_mapping *m)
{
    for (size_t k = 0; k < m->n; k++)
        if (m->item[k].key >= FF_CSV_THETA_H) return;
    for (int a = 0; a < 4; a++) {
        int there = 0;
        for (size_t k = 0; k < m->n; k++)
            there |= m->item[k].key == (ff_csv_key)a || (m->item[k].n_at && m->item[k].at_key == (ff_csv_key)a);
        if (there) continue;
        m->item[m->n++] = (ff_csv_item){.key = (ff_csv_key)a,
                                        .text = key_name[a],
                                        .channel = "",
                                        .column = key_name[a],
                                        .exact = 1,
                                        .number = -1,
                                        .constant = NAN};
    }
}

static ff_status read_items(parser *p)
{
    for (char *at = p->m.text; at;) {
        char *end = at;
        for (int quoted = 0; *end && (quoted || *end != ','); end++) quoted ^= *end == '"';
        char *next = *end ? end + 1 : NULL;
        *end = '\0';
        ff_status status = read_item(p, at);
        if (status != FF_OK) return status;
        at = next;
    }
    add_angles(&p->m);
    return FF_OK;
}

ff_status ff_csv_mapping_read(const char *text, const char *path, ff_csv_mapping *out, ff_error *err)
{
    size_t most = 1;
    for (const char *c = text; *c; c++) most += *c == ',';
    if (most > FF_NAMES_MAX)
        return ff_error_set(err, FF_ERR_SYNTAX, path, 0, -1, "columns: found %zu keys, expected at most %d", most, FF_NAMES_MAX);
    size_t colons = most + 1;
    for (const char *c = text; *c; c++) colons += *c == ':';
    parser p = {.path = path,
                .err = err,
                .m = {.text = strdup(text), .item = calloc(most + 4, sizeof(ff_csv_item)), .at = malloc(colons * sizeof(double))}};
    ff_status status =
        p.m.text && p.m.item && p.m.at ? read_items(&p) : ff_error_set(err, FF_ERR_MEMORY, path, 0, -1, "no memory for columns");
    if (status == FF_OK)
        *out = p.m;
    else
        ff_csv_mapping_free(&p.m);
    return status;
}

void ff_csv_mapping_free(ff_csv_mapping *m)
{
    free(m->item);
    free(m->text);
    free(m->at);
    *m = (ff_csv_mapping){0};
}

static size_t find(const char *name, size_t length, const ff_names *names, int *twice)
{
    size_t found = SIZE_MAX;
    for (size_t k = 0; k < names->n; k++) {
        if (strncmp(names->name[k], name, length) != 0 || names->name[k][length]) continue;
        *twice |= found != SIZE_MAX;
        if (found == SIZE_MAX) found = k;
    }
    return found;
}

size_t ff_csv_item_find(const ff_csv_item *item, const ff_names *names, int *twice)
{
    *twice = 0;
    if (item->number >= 0) return (size_t)item->number < names->n ? (size_t)item->number : SIZE_MAX;
    if (!item->column) return SIZE_MAX;
    for (const char *name = item->column;;) {
        size_t length = item->exact ? strlen(name) : strcspn(name, "|");
        size_t k = find(name, length, names, twice);
        if (k != SIZE_MAX || !name[length]) return k;
        name += length + 1;
    }
}
