/* What the flags of the program can say where the library cannot know. */
#include "words_struct.h"
#include <math.h>
#include <stdio.h>
#include <string.h>

const char *ff_words_hint(ff_hint hint)
{
    switch (hint) {
    case FF_HINT_SCALE:
        return "; say --scale, the 1/sr of one of them";
    case FF_HINT_QUANTITY:
        return "; --quantity says what the values are";
    case FF_HINT_QUANTITY_BRDF:
        return "; --quantity brdf says otherwise";
    case FF_HINT_QUANTITY_BRDF_COS:
        return "; --quantity brdf-cos says otherwise";
    case FF_HINT_RESULT:
        return "; 'facetfit plot' draws it, 'facetfit export' writes it for a renderer, and --from takes its model";
    default:
        return "";
    }
}

/* Where "say OPTION " stands before an option of ff_read_options, a clause of its own; NULL. */
static char *clause_after(char *text, char *from)
{
    static const char *const option[] = {"columns ", "angles ", "quantity ", "dialect ", "format "};
    for (char *at = from; (at = strstr(at, "say ")); at += 4) {
        if (at - text < 2 || at[-1] != ' ' || !strchr(";:,?", at[-2])) continue;
        for (size_t k = 0; k < sizeof option / sizeof option[0]; k++)
            if (!strncmp(at + 4, option[k], strlen(option[k]))) return at;
    }
    return NULL;
}

/* "...; say columns 'x'" of the library is "...; say --columns 'x'" of the program, once: the names of columns that a sentence
 * quotes may have these words too. They stand before the clause, so it is the last; or in its value, which then ends the sentence.
 */
static void say_flags(char *text, size_t size)
{
    static const char with_value[] = "say columns '";
    const size_t n = strlen(text);
    char *say = NULL;
    for (char *at = text; (at = clause_after(text, at)); at += 4) {
        say = at;
        if (n && text[n - 1] == '\'' && !strncmp(at, with_value, sizeof with_value - 1)) break;
    }
    if (!say || n + 3 > size) return;
    memmove(say + 6, say + 4, strlen(say + 4) + 1);
    say[4] = say[5] = '-';
}

/* "the option 'columns'" of the library is --columns of the program. */
static void name_flags(char *text)
{
    static const char words[] = "the option '";
    for (char *at = text; (at = strstr(at, words));) {
        const size_t n = strspn(at + sizeof words - 1, "abcdefghijklmnopqrstuvwxyz-");
        char *after = at + sizeof words - 1 + n;
        if (!n || *after != '\'') {
            at = after;
            continue;
        }
        at[0] = at[1] = '-';
        memmove(at + 2, at + sizeof words - 1, n);
        memmove(at + 2 + n, after + 1, strlen(after + 1) + 1);
    }
}

void ff_words_error(const ff_error *err, char *out, size_t size)
{
    if (size == 0) return;
    ff_error_format(err, out, size);
    const size_t used = strlen(out);
    snprintf(out + used, size - used, "%s", ff_words_hint(err->hint));
    if (err->hint == FF_HINT_SAY) say_flags(out, size);
    name_flags(out);
}

const char *ff_words_note(const ff_table *t, size_t k, char out[FF_WORDS_SENTENCE])
{
    ff_hint hint;
    if (!ff_table_assumption(t, k, out, FF_WORDS_SENTENCE, &hint)) return NULL;
    const size_t used = strlen(out);
    snprintf(out + used, FF_WORDS_SENTENCE - used, "%s", ff_words_hint(hint));
    if (hint == FF_HINT_SAY) say_flags(out, FF_WORDS_SENTENCE);
    name_flags(out);
    return out;
}

const char *ff_words_side(ff_side side)
{
    static const char *const of[FF_SIDES] = {"nowhere in particular", "about the mirror direction", "on the side of the light",
                                             "across the plane of incidence"};
    return (int)side < FF_SIDES ? of[side] : "";
}

const char *ff_words_side_hint(ff_side side)
{
    switch (side) {
    case FF_SIDE_LIGHT:
        return "is the mirror direction azimuth 0 in this file? --azimuth mirror says so";
    case FF_SIDE_ACROSS:
        return "--columns says which column is which angle";
    default:
        return "";
    }
}

const char *ff_words_finding_kind(int kind)
{
    static const char *const name[FF_DIAGNOSIS_KINDS] = {"turned",    "unturned",  "elevation", "elevation-in", "elevation-out",
                                                         "clockwise", "radians",   "percent",   "factor",       "beyond",
                                                         "cosine",    "no-cosine", "unit"};
    return kind >= 0 && kind < FF_DIAGNOSIS_KINDS ? name[kind] : NULL;
}

/* The beginning, to which the flag is added. */
static void put_finding(const ff_finding *f, char *out, size_t size)
{
    switch (f->kind) {
    case FF_DIAGNOSIS_TURNED:
        snprintf(out, size,
                 "the brightest samples lie on the side of the light, as of a retro-reflector; where azimuth 0 is the mirror "
                 "direction instead");
        break;
    case FF_DIAGNOSIS_UNTURNED:
        snprintf(out, size,
                 "the brightest samples lie on the side that was taken for that of the light; where azimuth 0, or the positive "
                 "angles of a scan, are on the side of the light");
        break;
    case FF_DIAGNOSIS_ELEVATION:
    case FF_DIAGNOSIS_ELEVATION_IN:
    case FF_DIAGNOSIS_ELEVATION_OUT:
        snprintf(
            out, size,
            "taken as elevations above the surface, the polar angles%s explain %.0f %% of the differences, taken from the normal "
            "%.0f %%; if so they are",
            f->kind == FF_DIAGNOSIS_ELEVATION      ? ""
            : f->kind == FF_DIAGNOSIS_ELEVATION_IN ? " of the light"
                                                   : " of the detector",
            100 * f->value[1], 100 * fmax(0, f->value[0]));
        break;
    case FF_DIAGNOSIS_CLOCKWISE:
        snprintf(out, size,
                 "with the azimuth of the detector the other way round the angles explain %.0f %% of the differences, as it is "
                 "%.0f %%; if so "
                 "it is",
                 100 * f->value[1], 100 * fmax(0, f->value[0]));
        break;
    case FF_DIAGNOSIS_RADIANS:
        snprintf(out, size, "the largest polar angle is %.4g; if the angles are in radians", f->value[0]);
        break;
    case FF_DIAGNOSIS_PERCENT:
        snprintf(out, size, "at least %.3g times the light would be reflected; if the values are in per cent", f->value[0]);
        break;
    case FF_DIAGNOSIS_FACTOR:
        snprintf(out, size, "at least %.3g times the light would be reflected; if the values are pi times the BRDF", f->value[0]);
        break;
    case FF_DIAGNOSIS_UNIT:
        snprintf(out, size,
                 "at least %.3g times the light would be reflected: the values are not in 1/sr; --scale takes what makes "
                 "1/sr of them, --quantity what they are",
                 f->value[0]);
        break;
    case FF_DIAGNOSIS_COSINE:
        snprintf(out, size,
                 "light and detector exchanged the values differ by %.0f %%, taken as f cos(theta_o) by %.1f %%; if they are",
                 100 * expm1(f->value[0]), 100 * expm1(f->value[1]));
        break;
    case FF_DIAGNOSIS_NO_COSINE:
        snprintf(out, size,
                 "light and detector exchanged the values differ by %.0f %%, taken without a cosine in them by %.1f %%; if there "
                 "is none",
                 100 * expm1(f->value[0]), 100 * expm1(f->value[1]));
        break;
    default:
        snprintf(out, size, "every sample has an angle of %.4g degrees or more; to fit them", f->value[0]);
        break;
    }
}

const char *ff_words_finding(const ff_finding *finding, char out[FF_WORDS_SENTENCE])
{
    char value[32];
    put_finding(finding, out, FF_WORDS_SENTENCE);
    const size_t used = strlen(out);
    const char *option = ff_diagnosis_option(finding, value);
    if (option) snprintf(out + used, FF_WORDS_SENTENCE - used, ", say --%s %s", option, value);
    return out;
}
