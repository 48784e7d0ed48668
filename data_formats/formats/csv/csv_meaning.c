/* What the names of columns mean. A name is folded (case, accents, Greek letters), cut into words, numbers and units; each word
 * says something (csv_words.def), and the sum decides. */
#define _GNU_SOURCE
#include "internal_csv_meaning.h"
#include "base/internal_number.h"
#include "base/internal_plain.h"
#include <ctype.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum {
    SIDE_I = FF_SAYS_SIDE_I,
    SIDE_O = FF_SAYS_SIDE_O,
    POLAR = FF_SAYS_POLAR,
    AZIMUTH = FF_SAYS_AZIMUTH,
    ELEVATION = FF_SAYS_ELEVATION,
    ANGLE = FF_SAYS_ANGLE,
    HALF = FF_SAYS_HALF,
    DIFFERENCE = FF_SAYS_DIFFERENCE,
    PHASE = FF_SAYS_PHASE,
    AXIS_X = FF_SAYS_AXIS_X,
    AXIS_Y = FF_SAYS_AXIS_Y,
    AXIS_Z = FF_SAYS_AXIS_Z,
    VECTOR = FF_SAYS_VECTOR,
    BRDF = FF_SAYS_BRDF,
    COSINE = FF_SAYS_COSINE,
    REFLECTANCE = FF_SAYS_REFLECTANCE,
    FACTOR = FF_SAYS_FACTOR,
    COUNTS = FF_SAYS_COUNTS,
    PLAIN_VALUE = FF_SAYS_PLAIN_VALUE,
    COLOR = FF_SAYS_COLOR,
    SIGMA = FF_SAYS_SIGMA,
    WEIGHT = FF_SAYS_WEIGHT,
    WAVELENGTH = FF_SAYS_WAVELENGTH,
    FILLER = FF_SAYS_FILLER,
    ANY_VALUE = BRDF | COSINE | REFLECTANCE | FACTOR | COUNTS | PLAIN_VALUE,
    ANY_ANGLE = POLAR | AZIMUTH | ELEVATION | ANGLE | HALF | DIFFERENCE
};

static const struct {
    const char *word;
    int says;
} words[] = {
#define CSV_WORD(word, says) {#word, says},
#include "csv_words.def"
#undef CSV_WORD
};

static int word_says(const char *word)
{
    for (size_t k = 0; k < sizeof words / sizeof words[0]; k++)
        if (strcmp(words[k].word, word) == 0) return words[k].says;
    return 0;
}

/* ---- folding --------------------------------------------------------------------------------- */

/* What a character that is no ASCII stands for in a name. "" for what only separates. */
static const char *letter_of(unsigned c)
{
    static const struct {
        unsigned c;
        const char *as;
    } greek[] = {{0x3B1, "alpha"}, {0x3B8, "theta"}, {0x3D1, "theta"},  {0x398, "theta"},  {0x3C6, "phi"},    {0x3D5, "phi"},
                 {0x3A6, "phi"},   {0x3C3, "sigma"}, {0x3BB, "lambda"}, {0x3C9, "omega"},  {0x394, "delta "}, {0x3B4, "delta "},
                 {0x3BC, "u"},     {0xB5, "u"},      {0xB0, " deg "},   {0x2070, " deg "}, {0xBA, " deg "},   {0x2080, " 0"},
                 {0xDF, "ss"},     {0xC6, "ae"},     {0xE6, "ae"},      {0xD8, "o"},       {0xF8, "o"},       {0x2215, "/"},
                 {0x2044, "/"},    {0x2212, "-"},    {0x207B, "-"},     {0xB9, "1"},       {0xB7, "*"},       {0xD7, "*"},
                 {0x22C5, "*"},    {0x1D62, " i"},   {0x2092, " o"},    {0x1D63, " r"}};
    static const char *const latin[64] = {"a", "a", "a", "a", "a", "a", "ae", "c", "e", "e", "e", "e", "i", "i", "i", "i",
                                          "d", "n", "o", "o", "o", "o", "o",  "*", "o", "u", "u", "u", "u", "y", "t", "ss",
                                          "a", "a", "a", "a", "a", "a", "ae", "c", "e", "e", "e", "e", "i", "i", "i", "i",
                                          "d", "n", "o", "o", "o", "o", "o",  "/", "o", "u", "u", "u", "u", "y", "t", "y"};
    for (size_t k = 0; k < sizeof greek / sizeof greek[0]; k++)
        if (greek[k].c == c) return greek[k].as;
    return c >= 0xC0 && c < 0x100 ? latin[c - 0xC0] : " ";
}

static unsigned code_point(const unsigned char *p, size_t *used)
{
    const size_t n = *p < 0x80 ? 1 : *p < 0xE0 ? 2 : *p < 0xF0 ? 3 : 4;
    unsigned c = n == 1 ? *p : *p & (0xFFu >> (n + 1));
    for (size_t k = 1; k < n && p[k]; k++) c = c << 6 | (p[k] & 0x3Fu);
    *used = n;
    return c;
}

const char *ff_name_utf8(const char *name, char *out, size_t size)
{
    size_t used = 0;
    const int as_is = ff_plain_is_utf8(name, strlen(name));
    for (const char *p = name; *p; p++) {
        char one[4];
        const size_t n = as_is ? 1 : ff_plain_latin((unsigned char)*p, one);
        if (used + n >= size) break;
        if (as_is)
            out[used] = *p;
        else
            memcpy(out + used, one, n);
        used += n;
    }
    while (used && as_is && name[used] && ((unsigned char)name[used] & 0xC0) == 0x80) used--; /* no half of a character */
    out[used] = '\0';
    return out;
}

enum { FOLDED = 256, TOKENS = 24, WORD = 32 };

static void fold(const char *name, char out[FOLDED])
{
    char text[FOLDED];
    size_t used = 0;
    ff_name_utf8(name, text, sizeof text);
    for (const unsigned char *p = (const unsigned char *)text; *p;) {
        size_t n = 1;
        const unsigned c = code_point(p, &n);
        char one[2] = {(char)tolower((int)(c < 0x80 ? c : ' ')), '\0'};
        const char *as = c < 0x80 ? one : letter_of(c);
        if (used + strlen(as) + 1 >= FOLDED) break;
        if ((c == '\'' || c == 0x2019) && used && strchr("dl", out[used - 1]) && (used == 1 || out[used - 2] == ' '))
            out[used - 1] = ' '; /* angle d'incidence */
        used = (size_t)(stpcpy(out + used, as) - out);
        for (; n && *p; n--) p++;
    }
    out[used] = '\0';
}

/* ---- words, numbers, units --------------------------------------------------------------------- */

typedef struct token {
    char word[WORD]; /* of a word; "%" */
    double number;   /* NaN of a word  */
    int says;
    int bracket; /* it stands in brackets */
    const char *start;
} token;

typedef struct tokens {
    size_t n;
    token at[TOKENS];
} tokens;

/* "0,45" and "22.5" are one number each. */
static const char *take_number(const char *p, double *value)
{
    char text[WORD];
    size_t n = 0;
    const char *q = p;
    if (*q == '-' || *q == '+') text[n++] = *q++;
    while (n + 1 < WORD && (isdigit((unsigned char)*q) || ((*q == '.' || *q == ',') && isdigit((unsigned char)q[1]))))
        text[n++] = *q == ',' ? '.' : *q, q++;
    text[n] = '\0';
    const char *end = ff_number_read(text, value);
    return end && !*end ? q : NULL;
}

static int starts_number(const char *p, const char *text)
{
    const int sign = (*p == '-' || *p == '+') && (p == text || !isalnum((unsigned char)p[-1])); /* "sr-1" is no number */
    return isdigit((unsigned char)p[sign]) != 0;
}

/* A digit behind letters is part of their word: theta1. */
static void cut(const char *text, tokens *out)
{
    int depth = 0;
    out->n = 0;
    for (const char *p = text; *p && out->n < TOKENS;) {
        token t = {.number = NAN, .bracket = depth > 0, .start = p};
        if (strchr("([{", *p)) depth++;
        if (strchr(")]}", *p)) depth -= depth > 0;
        const char *end = starts_number(p, text) ? take_number(p, &t.number) : NULL;
        if (end) {
            p = end;
        } else if (*p == '%') {
            strcpy(t.word, "%");
            p++;
        } else if (isalpha((unsigned char)*p)) {
            size_t n = 0;
            while (isalpha((unsigned char)*p)) {
                if (n + 1 < WORD) t.word[n++] = *p;
                p++;
            }
            t.says = word_says(t.word);
        } else {
            p++;
            continue;
        }
        out->at[out->n++] = t;
    }
}

static int unit_of_word(const char *word)
{
    static const struct {
        const char *word;
        int unit;
    } units[] = {{"deg", FF_CSV_DEGREES},    {"degree", FF_CSV_DEGREES},  {"degrees", FF_CSV_DEGREES},
                 {"grad", FF_CSV_DEGREES},   {"grd", FF_CSV_DEGREES},     {"degre", FF_CSV_DEGREES},
                 {"degres", FF_CSV_DEGREES}, {"gradi", FF_CSV_DEGREES},   {"grados", FF_CSV_DEGREES},
                 {"rad", FF_CSV_RADIANS},    {"radian", FF_CSV_RADIANS},  {"radians", FF_CSV_RADIANS},
                 {"nm", FF_CSV_NM},          {"nanometer", FF_CSV_NM},    {"nanometers", FF_CSV_NM},
                 {"um", FF_CSV_UM},          {"micron", FF_CSV_UM},       {"microns", FF_CSV_UM},
                 {"micrometer", FF_CSV_UM},  {"micrometers", FF_CSV_UM},  {"m", FF_CSV_M},
                 {"%", FF_CSV_PERCENT},      {"percent", FF_CSV_PERCENT}, {"prozent", FF_CSV_PERCENT},
                 {"sr", FF_CSV_PLAIN},       {"steradian", FF_CSV_PLAIN}, {"au", FF_CSV_PLAIN}};
    for (size_t k = 0; k < sizeof units / sizeof units[0]; k++)
        if (strcmp(units[k].word, word) == 0) return units[k].unit;
    return -1;
}

int ff_name_unit(const char *text)
{
    char folded[FOLDED];
    tokens t;
    int unit = -1;
    fold(text, folded);
    cut(folded, &t);
    if (t.n == 1 && t.at[0].number == 1 && !strpbrk(folded, "/")) return FF_CSV_PLAIN;
    for (size_t k = 0; k < t.n; k++) {
        if (t.at[k].number == 1 || t.at[k].number == -1) continue; /* of 1/sr, sr-1 */
        const int one = isnan(t.at[k].number) ? unit_of_word(t.at[k].word) : -1;
        if (one < 0) return -1;
        unit = unit < 0 || unit == FF_CSV_PLAIN ? one : unit;
    }
    return t.n == 0 && strpbrk(folded, "-") ? FF_CSV_PLAIN : unit;
}

/* ---- putting it together ------------------------------------------------------------------------ */

static int has(int says, int all)
{
    return (says & all) == all;
}

static ff_meaning vector_meaning(int says)
{
    const int axis = says & AXIS_X ? 0 : says & AXIS_Y ? 1 : 2;
    if (!(says & (SIDE_I | SIDE_O)) || has(says, SIDE_I | SIDE_O)) return FF_MEANS_NOTHING;
    return (ff_meaning)((says & SIDE_I ? FF_MEANS_WI_X : FF_MEANS_WO_X) + axis);
}

static ff_meaning angle_meaning(int says)
{
    const int i = (says & SIDE_I) != 0, o = (says & SIDE_O) != 0;
    if (says & PHASE) return i || o ? FF_MEANS_NOTHING : FF_MEANS_PHASE;
    if (i && o) return FF_MEANS_NOTHING;
    if (says & HALF) return says & AZIMUTH ? FF_MEANS_PHI_H : FF_MEANS_THETA_H;
    if (says & AZIMUTH) return i ? FF_MEANS_PHI_I : o ? FF_MEANS_PHI_O : says & DIFFERENCE ? FF_MEANS_PHI_D : FF_MEANS_PHI;
    if (says & DIFFERENCE) return i || o || !(says & POLAR) ? FF_MEANS_NOTHING : FF_MEANS_THETA_D;
    if (says & ELEVATION) return i ? FF_MEANS_ELEVATION_I : o ? FF_MEANS_ELEVATION_O : FF_MEANS_NOTHING;
    return i ? FF_MEANS_THETA_I : o ? FF_MEANS_THETA_O : FF_MEANS_THETA;
}

static void value_meaning(int says, ff_named *out)
{
    out->meaning = FF_MEANS_VALUE;
    out->rank = says & BRDF                       ? FF_RANK_BRDF
                : has(says, REFLECTANCE | FACTOR) ? FF_RANK_FACTOR
                : says & REFLECTANCE              ? FF_RANK_REFLECTANCE
                : says & COUNTS                   ? FF_RANK_COUNTS
                                                  : FF_RANK_PLAIN;
    out->quantity = says & COSINE ? FF_BRDF_COS : out->rank == FF_RANK_FACTOR ? FF_REFLECTANCE_FACTOR : FF_BRDF;
}

static int unit_goes_with(ff_meaning meaning, int unit)
{
    if (unit == FF_CSV_PLAIN) return 1;
    if (meaning == FF_MEANS_WAVELENGTH) return unit == FF_CSV_NM || unit == FF_CSV_UM || unit == FF_CSV_M;
    if (meaning == FF_MEANS_VALUE || meaning == FF_MEANS_SIGMA) return unit == FF_CSV_PERCENT;
    return unit == FF_CSV_DEGREES || unit == FF_CSV_RADIANS;
}

/* What a name of a value has beside the words that say so: the name of its channel, as in the file. */
static void take_channel(const char *folded, const token *t, const char *name, ff_named *out)
{
    const size_t n = strspn(t->start, "abcdefghijklmnopqrstuvwxyz");
    if (strlen(folded) == strlen(name) && n < FF_CHANNEL_NAME) {
        memcpy(out->channel, name + (t->start - folded), n);
        out->channel[n] = '\0';
    } else {
        strncat(out->channel, t->word, FF_CHANNEL_NAME - 1);
    }
}

typedef struct sum {
    int says, strangers, unit;
    const token *stranger;
    size_t numbers;
} sum;

/* Units count at the end of a name, in brackets, and behind a number. */
static void add_up(const tokens *t, sum *s, ff_named *out)
{
    *s = (sum){.unit = -1};
    for (size_t k = 0; k < t->n; k++) {
        const token *one = &t->at[k];
        const int unit = isnan(one->number) ? unit_of_word(one->word) : -1;
        if (!isnan(one->number)) {
            const int of_sr = one->number == 1 && k + 1 < t->n && strcmp(t->at[k + 1].word, "sr") == 0;
            const int sr_to = fabs(one->number) == 1 && k > 0 && strcmp(t->at[k - 1].word, "sr") == 0;
            if (of_sr || sr_to) continue;
            out->number = one->number;
            s->numbers++;
        } else if (unit >= 0 && (k > 0 || one->bracket) && !(one->says && !one->bracket && k + 1 < t->n)) {
            if (k > 0 && !isnan(t->at[k - 1].number) && t->at[k - 1].number == out->number && unit != FF_CSV_PLAIN)
                out->number_unit = (ff_csv_unit)unit;
            else if (s->unit < 0 || s->unit == FF_CSV_PLAIN)
                s->unit = unit;
        } else if (one->bracket && !one->says) {
            continue; /* remarks */
        } else if (one->says) {
            s->says |= one->says;
        } else {
            s->strangers++;
            s->stranger = one;
        }
    }
}

/* A single letter alone means what it does in formulas. */
static int says_alone(const tokens *t, int says)
{
    const char *word = t->n ? t->at[0].word : "";
    if (strcmp(word, "r") == 0) return REFLECTANCE;
    if (strcmp(word, "i") == 0) return SIDE_I | POLAR;
    if (strcmp(word, "e") == 0) return SIDE_O | POLAR;
    return strlen(word) == 1 && !(says & (BRDF | COLOR)) ? 0 : says;
}

/* The words of a value and others that say nothing of one: "BRDF_R", "f_b": these name the channel. */
static void look_for_channel(const tokens *t, const char *folded, const char *name, sum *s, ff_named *out)
{
    for (size_t k = 0; k < t->n; k++) {
        const token *one = &t->at[k];
        if (one->bracket || !isnan(one->number) || one->says & (ANY_VALUE | SIGMA | FILLER)) continue;
        if (one->says && s->says & COSINE) continue; /* f cos theta_o */
        if (unit_of_word(one->word) >= 0) continue;
        take_channel(folded, one, name, out);
        s->says &= ~one->says | ANY_VALUE | SIGMA;
        s->strangers = 0;
        return;
    }
}

void ff_name_meaning(const char *name, ff_named *out)
{
    char folded[FOLDED];
    tokens t;
    sum s;
    *out = (ff_named){.number = NAN};
    fold(name, folded);
    cut(folded, &t);
    add_up(&t, &s, out);
    size_t n_words = 0;
    for (size_t k = 0; k < t.n; k++) n_words += isnan(t.at[k].number) && unit_of_word(t.at[k].word) < 0 && !t.at[k].bracket;
    if (n_words == 1) s.says = says_alone(&t, s.says);
    out->is_elevation = (s.says & ELEVATION) != 0;
    if (s.numbers > 1) return;
    const int valued = s.says & (ANY_VALUE & ~(COSINE | FACTOR));
    if (valued || (s.says & SIGMA)) look_for_channel(&t, folded, name, &s, out);
    const int says = s.says & ~FILLER, strange = s.strangers > 0;
    if (says & SIGMA && !(says & ANY_ANGLE) && !strange)
        out->meaning = FF_MEANS_SIGMA;
    else if (valued && !(says & (WAVELENGTH | WEIGHT | VECTOR)) && !strange)
        value_meaning(says, out);
    else if (strange || says & COSINE)
        return;
    else if (says == 0 && s.numbers == 1)
        out->meaning = FF_MEANS_NUMBER;
    else if (says == WEIGHT)
        out->meaning = FF_MEANS_WEIGHT;
    else if (says == WAVELENGTH)
        out->meaning = FF_MEANS_WAVELENGTH;
    else if (says == COLOR) {
        value_meaning(PLAIN_VALUE, out);
        ff_name_utf8(name, out->channel, sizeof out->channel);
    } else if (says & (AXIS_X | AXIS_Y | AXIS_Z) && says & (SIDE_I | SIDE_O) && !(says & ANY_ANGLE))
        out->meaning = vector_meaning(says);
    else if (says & (ANY_ANGLE | SIDE_I | SIDE_O | PHASE) &&
             !(says & (AXIS_X | AXIS_Y | AXIS_Z | VECTOR | COLOR | WEIGHT | WAVELENGTH)))
        out->meaning = angle_meaning(says);
    if (s.numbers == 1 && out->meaning != FF_MEANS_VALUE && out->meaning != FF_MEANS_NUMBER && out->meaning != FF_MEANS_SIGMA) {
        if (out->meaning != FF_MEANS_THETA_I && out->meaning != FF_MEANS_WAVELENGTH && out->meaning != FF_MEANS_PHI &&
            out->meaning != FF_MEANS_THETA_O && out->meaning != FF_MEANS_PHI_O)
            out->meaning = FF_MEANS_NOTHING;
    }
    if (out->meaning != FF_MEANS_NOTHING && s.unit >= 0) {
        if (unit_goes_with(out->meaning, s.unit))
            out->unit = (ff_csv_unit)s.unit;
        else if (out->meaning != FF_MEANS_NUMBER)
            out->meaning = FF_MEANS_NOTHING;
    }
}

int ff_csv_names_brdf(const char *name)
{
    return strcasestr(name, "brdf") || strcasestr(name, "bsdf");
}

int ff_name_incidence(const char *path, double *degrees)
{
    char name[FOLDED], folded[FOLDED];
    tokens t;
    size_t found = 0;
    const char *slash = strrchr(path, '/');
    snprintf(name, sizeof name, "%s", slash ? slash + 1 : path);
    char *dot = strrchr(name, '.');
    if (dot && strcmp(dot, ".gz") == 0) *dot = '\0', dot = strrchr(name, '.');
    if (dot && !isdigit((unsigned char)dot[1])) *dot = '\0';
    fold(name, folded);
    cut(folded, &t);
    for (size_t k = 0; k < t.n; k++) {
        if (isnan(t.at[k].number)) continue;
        const int before = k > 0 ? t.at[k - 1].says : 0;
        const int unit = k + 1 < t.n && isnan(t.at[k + 1].number) ? unit_of_word(t.at[k + 1].word) : -1;
        const int of_other = before & (SIDE_O | AZIMUTH | WAVELENGTH);
        if (of_other || !(unit == FF_CSV_DEGREES || before & (SIDE_I | POLAR))) continue;
        if (found++ == 0) *degrees = t.at[k].number;
    }
    return found == 1 && *degrees >= 0 && *degrees <= 90;
}
