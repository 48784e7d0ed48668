/* Texts, line by line and word by word; XML by its tags. */
#include "mutate.h"
#include <string.h>

enum { MOST = 512 };

/* Ranges of the data, one after another. */
typedef struct pieces {
    size_t n, at[MOST], length[MOST];
} pieces;

static void add(pieces *p, size_t at, size_t end)
{
    if (p->n == MOST || end < at) return;
    p->at[p->n] = at;
    p->length[p->n++] = end - at;
}

static int is_in(uint8_t c, const char *set)
{
    return c && strchr(set, c) != NULL;
}

/* What stands between characters of `ends`; the longest runs of them. */
static void split(const mutation *m, const char *ends, pieces *out)
{
    out->n = 0;
    for (size_t i = 0; i < m->size;) {
        size_t end = i;
        while (end < m->size && !is_in(m->data[end], ends)) end++;
        if (end > i) add(out, i, end);
        i = end + 1;
    }
}

/* Numbers, by their look. */
static void find_numbers(const mutation *m, pieces *out)
{
    out->n = 0;
    for (size_t i = 0; i < m->size;) {
        size_t end = i;
        while (end < m->size && is_in(m->data[end], "0123456789+-.eE")) end++;
        int digits = 0;
        for (size_t k = i; k < end; k++) digits |= m->data[k] >= '0' && m->data[k] <= '9';
        if (digits) add(out, i, end);
        i = end + 1;
    }
}

/* Swap two, put one over another, double one, or take one away. */
static int rearrange(mutation *m, const pieces *p)
{
    if (p->n == 0) return 0;
    size_t a = mutate_below(m, p->n), b = mutate_below(m, p->n);
    const size_t at = p->at[a], n = p->length[a];
    switch (mutate_below(m, 4)) {
    case 0:
        if (a > b) {
            const size_t c = a;
            a = b;
            b = c;
        }
        return a != b && mutate_swap(m, p->at[a], p->length[a], p->at[b], p->length[b]);
    case 1:
        return a != b && mutate_replace(m, p->at[b], p->length[b], m->data + at, n);
    case 2: /* with what separates it from the next */
        return mutate_replace(m, at, 0, m->data + at, n + (at + n < m->size));
    default:
        return mutate_replace(m, at, n + (at + n < m->size), "", 0);
    }
}

static int replace_number(mutation *m)
{
    static pieces p;
    find_numbers(m, &p);
    if (p.n == 0) return 0;
    const size_t k = mutate_below(m, p.n);
    const char *number = mutate_number(m);
    return mutate_replace(m, p.at[k], p.length[k], number, strlen(number));
}

int mutate_text(mutation *m)
{
    static pieces p;
    switch (mutate_below(m, 4)) {
    case 0:
        split(m, "\r\n", &p);
        return rearrange(m, &p);
    case 1:
        split(m, "\r\n\t ,;=:", &p);
        return rearrange(m, &p);
    case 2: /* of JSON and of expressions */
        split(m, "{}[](),:+/\n", &p);
        return rearrange(m, &p);
    default:
        return replace_number(m);
    }
}

/* ---- XML --------------------------------------------------------------------------------------- */

/* End of the tag that begins at `at`. */
static size_t end_of_tag(const mutation *m, size_t at)
{
    const uint8_t *end = memchr(m->data + at, '>', m->size - at);
    return end ? (size_t)(end - m->data) + 1 : m->size;
}

/* End of the element whose start tag begins at `at`, by counting tags. */
static size_t end_of_element(const mutation *m, size_t at)
{
    long depth = 0;
    while (at < m->size) {
        const uint8_t *tag = memchr(m->data + at, '<', m->size - at);
        if (!tag) return m->size;
        const size_t begin = (size_t)(tag - m->data), end = end_of_tag(m, begin);
        const int closes = begin + 1 < m->size && tag[1] == '/', is_whole = end >= 2 && m->data[end - 2] == '/';
        const int is_note = begin + 1 < m->size && (tag[1] == '!' || tag[1] == '?');
        if (!is_note && !is_whole) depth += closes ? -1 : 1;
        at = end;
        if (depth <= 0) return end;
    }
    return m->size;
}

static void find_elements(const mutation *m, pieces *out)
{
    out->n = 0;
    for (size_t i = 0; i + 1 < m->size; i++)
        if (m->data[i] == '<' && !is_in(m->data[i + 1], "/!?")) add(out, i, end_of_element(m, i));
}

/* name="value" within start tags */
static void find_attributes(const mutation *m, pieces *out)
{
    out->n = 0;
    for (size_t i = 1; i + 1 < m->size; i++) {
        if (m->data[i] != '=' || !is_in(m->data[i + 1], "\"'")) continue;
        size_t begin = i;
        while (begin > 0 && !is_in(m->data[begin - 1], " \t\r\n<")) begin--;
        const uint8_t *end = memchr(m->data + i + 2, m->data[i + 1], m->size - i - 2);
        if (end) add(out, begin, (size_t)(end - m->data) + 1);
    }
}

/* Text between tags. */
static void find_contents(const mutation *m, pieces *out)
{
    out->n = 0;
    for (size_t i = 0; i < m->size; i++) {
        if (m->data[i] != '>') continue;
        const uint8_t *end = memchr(m->data + i, '<', m->size - i);
        if (end) add(out, i + 1, (size_t)(end - m->data));
    }
}

/* Only the names of the tags. */
static void find_names(const mutation *m, pieces *out)
{
    out->n = 0;
    for (size_t i = 0; i + 1 < m->size; i++) {
        if (m->data[i] != '<') continue;
        size_t end = i + 1 + (m->data[i + 1] == '/');
        const size_t begin = end;
        while (end < m->size && !is_in(m->data[end], " \t\r\n/>")) end++;
        add(out, begin, end);
    }
}

int mutate_xml(mutation *m)
{
    static pieces p;
    static void (*const find[])(const mutation *, pieces *) = {find_elements, find_attributes, find_contents, find_names};
    const size_t which = mutate_below(m, 6);
    if (which > 4) return replace_number(m);
    if (which == 4) { /* of a list of numbers within an element */
        split(m, " ,\t\r\n<>", &p);
        return rearrange(m, &p);
    }
    find[which](m, &p);
    return rearrange(m, &p);
}
