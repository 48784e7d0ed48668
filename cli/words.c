/* Closed lists of words, most of them from the registries of the library, and the nearest word of a list. */
#include "internal_flags.h"
#include "base/internal_name.h"
#include "cli/batch/internal_batch.h"
#include "ff_render.h"
#include "targets/files/internal_files.h"
#include "targets/snippets/internal_snippet.h"
#include "ff_convert.h"
#include "models/model_struct.h"
#include "fit/ndf/ndf_struct.h"
#include "report/plot/kinds/internal_plots.h"
#include <string.h>

/* ---- lists of the library -------------------------------------------------------------------- */

const char *cli_words_loss(size_t i)
{
    return ff_loss_name((int)i);
}

/* "auto", which only `fit` knows, is one more loss. */
const char *cli_words_loss_auto(size_t i)
{
    const size_t n = cli_words_count(cli_words_loss);
    return i == n ? "auto" : i < n ? cli_words_loss(i) : NULL;
}

const char *cli_meaning_loss(size_t i)
{
    const ff_loss_info *loss = ff_loss_at((int)i);
    return loss ? loss->help : "the one whose pictures are nearest to the data's";
}

const char *cli_words_robust(size_t i)
{
    return ff_robust_name((int)i);
}

const char *cli_meaning_robust(size_t i)
{
    return ff_robust_at((int)i)->help;
}

const char *cli_words_weighting(size_t i)
{
    return ff_weighting_name((int)i);
}

const char *cli_words_errors(size_t i)
{
    return ff_error_source_name((int)i);
}

const char *cli_words_polarization(size_t i)
{
    static const char *const words[] = {"s", "p", "both"};
    return i < sizeof words / sizeof *words ? words[i] : NULL;
}

const char *cli_words_shape(size_t i)
{
    return ff_shape_name((int)i);
}

const char *cli_words_channels(size_t i)
{
    return ff_channel_mode_name((int)i);
}

/* What makes one data set of all channels. */
const char *cli_words_channels_one(size_t i)
{
    return i < FF_CHANNELS_EACH ? ff_channel_mode_name((int)i) : NULL;
}

const char *cli_words_quantity(size_t i)
{
    return ff_quantity_name((int)i);
}

const char *cli_words_azimuth(size_t i)
{
    return ff_azimuth_name((int)i + 1);
}

const char *cli_words_phi(size_t i)
{
    return ff_phi_sense_name((int)i + 1);
}

const char *cli_words_angles(size_t i)
{
    return ff_angles_name((int)i + 1);
}

const char *cli_words_monotone(size_t i)
{
    return ff_ndf_monotone_name((int)i);
}

const char *cli_words_table(size_t i)
{
    return ff_table_form_name((int)i);
}

/* In the order that cli_style knows. */
const char *cli_words_color(size_t i)
{
    static const char *const words[] = {"auto", "always", "never"};
    return i < sizeof words / sizeof *words ? words[i] : NULL;
}

const char *cli_words_tone(size_t i)
{
    return ff_render_tone_name((int)i);
}

const char *cli_words_background(size_t i)
{
    return ff_render_background_name((int)i);
}

const char *cli_words_environment(size_t i)
{
    static const char *const words[] = {"uniform", "sky"};
    return i < sizeof words / sizeof *words ? words[i] : NULL;
}

const char *cli_words_sort(size_t i)
{
    return batch_order_name(i);
}

const char *cli_words_plot(size_t i)
{
    const ff_plot_kind *kind = ff_plot_kind_at(i);
    return kind ? kind->name : NULL;
}

const char *cli_meaning_plot(size_t i)
{
    return ff_plot_kind_at(i)->help;
}

/* In the order of ff_isa. */
const char *cli_words_isa(size_t i)
{
    return i == FF_ISA_BEST ? "best" : i <= FF_ISA_AVX512 ? ff_isa_name((ff_isa)i) : NULL;
}

static const char *term(ff_term_kind kind, size_t i)
{
    const ff_term *t = ff_term_at(kind, i);
    return t ? t->name : NULL;
}

/* A word beside the terms of a kind. */
static const char *term_or(ff_term_kind kind, size_t i, const char *first, const char *second)
{
    const size_t n = ff_term_count(kind);
    return i < n ? term(kind, i) : i == n ? first : i == n + 1 ? second : NULL;
}

const char *cli_words_ndf(size_t i)
{
    return term_or(FF_NDF, i, "all", NULL);
}

const char *cli_words_masking(size_t i)
{
    return term_or(FF_MASKING, i, "all", NULL);
}

const char *cli_words_masking_one(size_t i)
{
    return term(FF_MASKING, i);
}

const char *cli_words_fresnel(size_t i)
{
    return term_or(FF_FRESNEL, i, "all", NULL);
}

const char *cli_words_diffuse(size_t i)
{
    return term_or(FF_DIFFUSE, i, "all", "none");
}

/* What an expression may begin with. */
const char *cli_words_model(size_t i)
{
    const size_t n = ff_term_count(FF_NDF), m = n + ff_term_count(FF_DIFFUSE);
    if (i < n) return term(FF_NDF, i);
    if (i < m) return term(FF_DIFFUSE, i - n);
    return i - m < ff_preset_count() ? ff_preset_at(i - m)->name : NULL;
}

/* Terms of all kinds, and presets. */
const char *cli_words_term(size_t i)
{
    for (int kind = 0; kind < FF_TERM_KINDS; kind++) {
        if (i < ff_term_count((ff_term_kind)kind)) return term((ff_term_kind)kind, i);
        i -= ff_term_count((ff_term_kind)kind);
    }
    return i < ff_preset_count() ? ff_preset_at(i)->name : NULL;
}

const char *cli_words_for(size_t i)
{
    return i < ff_target_count() ? ff_target_at(i)->name : NULL;
}

static const char *format(size_t i, int written);

/* Renderers that have a file, languages, and formats. */
const char *cli_words_export(size_t i)
{
    for (size_t k = 0; k < ff_target_count(); k++)
        if (ff_scene_file_find(ff_target_at(k), "", 1) && i-- == 0) return ff_target_at(k)->name;
    if (i < ff_snippet_count()) return ff_snippet_name(i);
    return format(i - ff_snippet_count(), 1);
}

static const char *format(size_t i, int written)
{
    for (size_t k = 0; k < ff_format_count(); k++) {
        const ff_format *f = ff_format_at(k);
        if ((written ? f->write != NULL : f->read != NULL) && i-- == 0) return f->name;
    }
    return NULL;
}

const char *cli_words_read(size_t i)
{
    return format(i, 0);
}

const char *cli_words_written(size_t i)
{
    return format(i, 1);
}

/* A word of conversion c. */
static const char *conversion(size_t c, int which)
{
    const ff_conversion *v = ff_conversion_at(c);
    return which == 0 ? v->from : which == 1 ? v->to : v->by;
}

/* Each once. */
static const char *of_conversions(size_t i, int which)
{
    for (size_t k = 0; k < ff_conversion_count(); k++) {
        int seen = *conversion(k, which) == '\0';
        for (size_t j = 0; j < k && !seen; j++) seen = !strcmp(conversion(j, which), conversion(k, which));
        if (!seen && i-- == 0) return conversion(k, which);
    }
    return NULL;
}

const char *cli_words_from(size_t i)
{
    return of_conversions(i, 0);
}

const char *cli_words_to(size_t i)
{
    return of_conversions(i, 1);
}

const char *cli_words_by(size_t i)
{
    return of_conversions(i, 2);
}

/* ---- lists of the program -------------------------------------------------------------------- */

#define OWN_WORDS(name, ...)                                                                                                       \
    const char *cli_words_##name(size_t i)                                                                                         \
    {                                                                                                                              \
        static const char *const words[] = {__VA_ARGS__};                                                                          \
        return i < sizeof words / sizeof *words ? words[i] : NULL;                                                                 \
    }
OWN_WORDS(negative, "keep", "drop")
OWN_WORDS(grid, "merl", "goniometer", "scattered")
OWN_WORDS(reduce, "srgb", "bands", "channels", "mean")
OWN_WORDS(names, "file", "path")
OWN_WORDS(surface, "gaussian", "exponential", "power-law")
OWN_WORDS(facets, "mirror", "lambert", "coupled")
OWN_WORDS(descent, "projected", "symmetric")
OWN_WORDS(shell, "bash", "zsh", "fish")

/* ---- looking words up ------------------------------------------------------------------------ */

size_t cli_words_count(cli_words *words)
{
    size_t n = 0;
    while (words(n)) n++;
    return n;
}

/* The name of the term that a word is another name of, as "trowbridge-reitz" is one of ggx; NULL: of none. */
static const char *another_name(const char *word, size_t length)
{
    char bare[CLI_NAME];
    if (length >= sizeof bare) return NULL;
    snprintf(bare, sizeof bare, "%.*s", (int)length, word);
    for (int kind = 0; kind < FF_TERM_KINDS; kind++) {
        const int term = ff_term_find((ff_term_kind)kind, bare);
        if (term >= 0) return ff_term_at((ff_term_kind)kind, (size_t)term)->name;
    }
    return NULL;
}

int cli_words_find(cli_words *words, const char *word, size_t length)
{
    for (size_t i = 0; words(i); i++)
        if (ff_name_is(words(i), word, length)) return (int)i;
    const char *known = another_name(word, length);
    for (size_t i = 0; known && words(i); i++)
        if (!strcmp(words(i), known)) return (int)i;
    return -1;
}

/* Is it a masking that `all` leaves out? */
static int is_for_furnace(const char *name)
{
    const int masking = ff_term_find(FF_MASKING, name);
    return masking >= 0 && ff_term_at(FF_MASKING, (size_t)masking)->claims & FF_FURNACE_ONLY;
}

/* The k-th word of those that begin with this one and a hyphen, as "smith" begins several maskings; NULL: there are not so many. */
static const char *begun_at(cli_words *words, const char *word, size_t length, size_t k)
{
    for (size_t i = 0; words(i); i++) {
        const char *name = words(i);
        if (strlen(name) <= length || name[length] != '-' || !ff_name_begins(name, word, length) || is_for_furnace(name)) continue;
        if (k-- == 0) return name;
    }
    return NULL;
}

int cli_words_is_group(cli_words *words, const char *word, size_t length)
{
    return length && cli_words_find(words, word, length) < 0 && begun_at(words, word, length, 1);
}

/* One word as the list has it, or the words of a group with commas between; the rest of a WORD:DETAIL stays. */
static size_t put_known(const cli_flag *f, const char *word, size_t length, char *out, size_t size)
{
    const int i = cli_words_find(f->words, word, length);
    size_t used = 0;
    const char *name;
    if (i >= 0) return (size_t)snprintf(out, size, "%s", f->words((size_t)i));
    for (size_t k = 0; (name = begun_at(f->words, word, length, k)) != NULL; k++)
        used += (size_t)snprintf(out + used, used < size ? size - used : 0, "%s%s", k ? "," : "", name);
    return used;
}

int cli_words_known(const cli_flag *f, const char *value, char *out, size_t size)
{
    const char *ends = f->kind == KIND_WORDS ? "," : f->kind == KIND_WORD_DETAIL ? ":" : "";
    size_t used = 0;
    for (const char *word = value;; word++) {
        const size_t n = *ends ? strcspn(word, ends) : strlen(word);
        used += put_known(f, word, n, out + used, size - used);
        if (used >= size) return 0;
        word += n;
        if (!*word) return 1;
        used += (size_t)snprintf(out + used, size - used, "%s", f->kind == KIND_WORD_DETAIL ? word : ",");
        if (used >= size || f->kind == KIND_WORD_DETAIL) return used < size;
    }
}

const char *cli_words_list(cli_words *words, char *out, size_t size)
{
    size_t used = 0;
    *out = '\0';
    for (size_t i = 0; words(i) && used < size; i++)
        used += (size_t)snprintf(out + used, size - used, "%s%s", i ? ", " : "", words(i));
    return out;
}

/* Levenshtein's distance of two short words, where two letters that have changed places are one slip (Damerau); long ones are not
 * near. */
static size_t distance(const char *a, const char *b)
{
    enum { LONGEST = 40 };
    const size_t na = strlen(a), nb = strlen(b);
    size_t row[LONGEST + 1], above[LONGEST + 1], higher[LONGEST + 1];
    if (na > LONGEST || nb > LONGEST) return LONGEST;
    for (size_t j = 0; j <= nb; j++) row[j] = j;
    for (size_t i = 1; i <= na; i++) {
        size_t diagonal = row[0];
        memcpy(higher, above, sizeof higher);
        memcpy(above, row, sizeof above);
        row[0] = i;
        for (size_t j = 1; j <= nb; j++) {
            const size_t replace = diagonal + (a[i - 1] != b[j - 1]), insert = row[j] + 1, drop = row[j - 1] + 1;
            diagonal = row[j];
            row[j] = replace < insert ? replace : insert;
            if (drop < row[j]) row[j] = drop;
            const int swapped = i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1];
            if (swapped && higher[j - 2] + 1 < row[j]) row[j] = higher[j - 2] + 1;
        }
    }
    return row[nb];
}

const char *cli_nearest(const char *word, const char *const *names, size_t n)
{
    const char *nearest = NULL;
    size_t least = strlen(word) < 4 ? 2 : 3 + strlen(word) / 8; /* one slip in a short word, two in a long one */
    for (size_t i = 0; i < n; i++) {
        const size_t d = distance(word, names[i]);
        if (d >= least) continue;
        least = d;
        nearest = names[i];
    }
    return nearest;
}

/* The names that a word begins, as "smith" begins several: "A' or 'B", of one call at a time. NULL when none does, or too many. */
static const char *begun_by(const char *word, const char *const *names, size_t n)
{
    enum { MOST = 6 };
    static char out[MOST * CLI_NAME];
    const size_t length = strlen(word);
    size_t found = 0, used = 0;
    for (size_t i = 0; i < n && length >= 3; i++) {
        // NOLINTNEXTLINE(clang-analyzer-core.NonNullParamChecker): names holds only words that there are
        if (strncmp(names[i], word, length) != 0) continue;
        if (++found > MOST || used + strlen(names[i]) + sizeof "' or '" > sizeof out) return NULL;
        used += (size_t)snprintf(out + used, sizeof out - used, "%s%s", used ? "' or '" : "", names[i]);
    }
    return found ? out : NULL;
}

const char *cli_words_nearest(cli_words *words, const char *word, size_t length)
{
    enum { MANY = 128 };
    const char *names[MANY];
    char bare[CLI_NAME];
    size_t n = 0;
    for (; n < MANY && words(n); n++) names[n] = words(n);
    snprintf(bare, sizeof bare, "%.*s", (int)length, word);
    for (char *c = bare; *c; c++) *c = ff_name_char(*c);
    const char *nearest = cli_nearest(bare, names, n);
    return nearest ? nearest : begun_by(bare, names, n);
}
