/** @file internal_name.h  Names as people type them: "GGX" and "v_cavity" are ggx and v-cavity. */
#ifndef FF_INTERNAL_NAME_H
#define FF_INTERNAL_NAME_H
#include <stddef.h>
#include <string.h>

/** The character of a name that c stands for: small letters, '-' for '_' and a blank. Of ASCII alone, in any locale. */
static inline char ff_name_char(char c)
{
    return c >= 'A' && c <= 'Z' ? (char)(c - 'A' + 'a') : c == '_' || c == ' ' ? '-' : c;
}

/** Are the first n characters of word the whole of `name`? */
static inline int ff_name_is(const char *name, const char *word, size_t n)
{
    size_t k = 0;
    while (k < n && name[k] && ff_name_char(name[k]) == ff_name_char(word[k])) k++;
    return k == n && !name[k];
}

/** Does `name` begin with the first n characters of word? */
static inline int ff_name_begins(const char *name, const char *word, size_t n)
{
    for (size_t k = 0; k < n; k++)
        if (!name[k] || ff_name_char(name[k]) != ff_name_char(word[k])) return 0;
    return 1;
}

/** The same of one of several names, separated by commas; NULL: there are none. */
static inline int ff_name_is_one_of(const char *names, const char *word, size_t n)
{
    while (names && *names) {
        const size_t length = strcspn(names, ",");
        size_t k = 0;
        while (k < n && k < length && ff_name_char(names[k]) == ff_name_char(word[k])) k++;
        if (k == n && k == length) return 1;
        names += length + (names[length] == ',');
    }
    return 0;
}
#endif
