/* Whether a table is in our own words: the four angles by their names, commas between them, and no column whose meaning must be
 * found. */
#define _GNU_SOURCE
#include "internal_csv_look.h"
#include "internal_csv_meaning.h"
#include "base/internal_plain.h"
#include <math.h>
#include <string.h>

enum { NAME = 96, ROWS = 20 };

static void copy_name(const char *text, size_t length, size_t k, char out[NAME])
{
    size_t n;
    const char *cell = ff_csv_cell(text, length, ',', k, &n);
    if (n >= NAME) n = NAME - 1;
    memcpy(out, cell, n);
    out[n] = '\0';
}

static int is_our_angle(const char *name)
{
    return strcmp(name, "theta_i") == 0 || strcmp(name, "phi_i") == 0 || strcmp(name, "theta_o") == 0 || strcmp(name, "phi_o") == 0;
}

/* Does the name of a value say more than that it is the BRDF: another quantity, a unit, something that may be another? */
static int says_what(const ff_named *named)
{
    return named->meaning == FF_MEANS_VALUE && (named->quantity != FF_BRDF || named->unit == FF_CSV_PERCENT ||
                                                (named->rank != FF_RANK_BRDF && named->rank != FF_RANK_PLAIN));
}

/* Names of ours, values that are known and strangers beside them. *says: one of the values says what it is. */
static int are_our_names(const char *text, size_t length, int *says)
{
    size_t angles = 0, known = 0, strangers = 0;
    const size_t cells = ff_csv_count_cells(text, length, ',');
    for (size_t k = 0; k < cells && k < FF_NAMES_MAX; k++) {
        char name[NAME];
        ff_named named;
        copy_name(text, length, k, name);
        if (is_our_angle(name)) {
            angles++;
        } else if (strncmp(name, "f_", 2) == 0 || strcmp(name, "f") == 0 || !isnan(ff_wavelength_of(name))) {
            known++;
        } else if (*name) {
            ff_name_meaning(name, &named);
            *says |= says_what(&named);
            const int beside =
                named.meaning == FF_MEANS_SIGMA || named.meaning == FF_MEANS_WEIGHT || named.meaning == FF_MEANS_WAVELENGTH;
            if (named.meaning == FF_MEANS_VALUE && named.rank > FF_RANK_COUNTS)
                known++;
            else if (!beside)
                strangers++;
        }
    }
    return angles == 4 && !(known && strangers);
}

static int is_names_behind_comment(const char *text, size_t length)
{
    return memmem(text, length, "theta_i", 7) && memmem(text, length, "theta_o", 7) && memchr(text, ',', length) &&
           !memchr(text, ':', length);
}

/* A row that the reader of our own files would misread: a decimal comma in quotes, units below the names. */
static int is_foreign_row(const char *text, size_t length)
{
    size_t commas = 1, units = 0;
    for (size_t k = 0; k < length; k++) commas += text[k] == ',';
    const size_t cells = ff_csv_count_cells(text, length, ',');
    if (cells != commas) return 1;
    for (size_t k = 0; k < cells && k < 8; k++) {
        char name[NAME];
        copy_name(text, length, k, name);
        units += *name && ff_name_unit(name) > 0;
    }
    return units >= 2;
}

/* 1: our names and rows; 2: but for the names of values. */
static int words_of(const ff_csv_look *look)
{
    size_t k = 0, rows = 0;
    int says = 0;
    for (; k < look->n_lines; k++) {
        const ff_csv_line *l = &look->line[k];
        const char *p = l->text, *stop = l->text + l->length;
        while (p < stop && ff_csv_is_blank(*p)) p++;
        if (l->is_comment && memmem(p, (size_t)(stop - p), "facetfit-csv:", 13)) return 1;
        if (p == stop || (l->is_comment && !is_names_behind_comment(p, (size_t)(stop - p)))) continue;
        while (p < stop && (*p == '#' || ff_csv_is_blank(*p))) p++;
        if (!are_our_names(p, (size_t)(stop - p), &says) || !ff_plain_is_utf8(p, (size_t)(stop - p))) return 0;
        break;
    }
    if (k == look->n_lines) return 0;
    for (k++; k < look->n_lines && rows < ROWS; k++) {
        if (look->line[k].is_comment || look->line[k].length == 0) continue;
        if (is_foreign_row(look->line[k].text, look->line[k].length)) return 0;
        rows++;
    }
    return says ? 2 : 1;
}

void ff_csv_look_for_ours(ff_csv_look *look)
{
    const int words = words_of(look);
    look->is_ours = words == 1;
    look->our_angles = words == 2;
}
