/* What the flags of the program can say where the library cannot know. */
#include "ff_words.h"
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

void ff_words_error(const ff_error *err, char *out, size_t size)
{
    if (size == 0) return;
    ff_error_format(err, out, size);
    const size_t used = strlen(out);
    snprintf(out + used, size - used, "%s", ff_words_hint(err->hint));
}

const char *ff_words_note(const ff_table *t, size_t k, char out[FF_WORDS_SENTENCE])
{
    const char *line = t->note;
    for (size_t i = 0; i < k && line; i++) {
        const char *end = strchr(line, '\n');
        line = end ? end + 1 : NULL;
    }
    if (!line || !*line) return NULL;
    const ff_hint hint = k < FF_TABLE_NOTES ? (ff_hint)t->note_hint[k] : FF_HINT_NONE;
    snprintf(out, FF_WORDS_SENTENCE, "%.*s%s", (int)strcspn(line, "\n"), line, ff_words_hint(hint));
    return out;
}
