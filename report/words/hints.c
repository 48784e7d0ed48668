/* What the flags of the program can say where the library cannot know. */
#include "words_struct.h"
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
    default:
        return "";
    }
}

/* "...; say columns 'x'" of the library is "...; say --columns 'x'" of the program. */
static void say_flags(char *text, size_t size)
{
    for (char *at = text; (at = strstr(at, "say ")); at += 4)
        if (strlen(text) + 3 < size) {
            memmove(at + 6, at + 4, strlen(at + 4) + 1);
            memcpy(at + 4, "--", 2);
        }
}

void ff_words_error(const ff_error *err, char *out, size_t size)
{
    if (size == 0) return;
    ff_error_format(err, out, size);
    const size_t used = strlen(out);
    snprintf(out + used, size - used, "%s", ff_words_hint(err->hint));
    if (err->hint == FF_HINT_SAY) say_flags(out, size);
}

const char *ff_words_note(const ff_table *t, size_t k, char out[FF_WORDS_SENTENCE])
{
    ff_hint hint;
    if (!ff_table_assumption(t, k, out, FF_WORDS_SENTENCE, &hint)) return NULL;
    const size_t used = strlen(out);
    snprintf(out + used, FF_WORDS_SENTENCE - used, "%s", ff_words_hint(hint));
    if (hint == FF_HINT_SAY) say_flags(out, FF_WORDS_SENTENCE);
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
        return "is the mirror direction azimuth 0 in this file? --columns with phi_i=180 says so";
    case FF_SIDE_ACROSS:
        return "--columns says which column is which angle";
    default:
        return "";
    }
}
