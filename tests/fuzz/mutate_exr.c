/* Images of OpenEXR: a header of attributes, a table with the place of each chunk, the chunks. What changes its length takes the
 * places of the chunks along, so that the file is still whole. */
#include "mutate.h"
#include <string.h>

enum { HEAD = 8, ATTRIBUTES = 64, CHUNKS = 256 };

typedef struct attribute {
    size_t at, value, size, end; /* of the name; of the value; bytes of it; behind it */
} attribute;

typedef struct image {
    size_t n;
    attribute of[ATTRIBUTES];
    size_t table, n_chunks; /* where it stands, behind the zero that ends the header */
} image;

static uint64_t get(const uint8_t *p, int n)
{
    uint64_t v = 0;
    while (n-- > 0) v = v << 8 | p[n];
    return v;
}

static void put(uint8_t *p, uint64_t v, int n)
{
    for (int i = 0; i < n; i++) p[i] = (uint8_t)(v >> 8 * i);
}

/* Behind the text at `at`; 0: it does not end. */
static size_t behind_text(const mutation *m, size_t at)
{
    const uint8_t *end = at < m->size ? memchr(m->data + at, 0, m->size - at) : NULL;
    return end ? (size_t)(end - m->data) + 1 : 0;
}

static int take_apart(const mutation *m, image *out)
{
    size_t at = HEAD;
    *out = (image){0};
    if (m->size < HEAD || get(m->data, 4) != 20000630) return 0;
    while (at < m->size && m->data[at] && out->n < ATTRIBUTES) {
        attribute a = {.at = at};
        const size_t type = behind_text(m, at), size = type ? behind_text(m, type) : 0;
        if (!size || size + 4 > m->size) return 0;
        a.value = size + 4;
        a.size = (size_t)get(m->data + size, 4);
        if (a.size > m->size - a.value) return 0;
        at = a.end = a.value + a.size;
        out->of[out->n++] = a;
    }
    if (at >= m->size || m->data[at]) return 0;
    out->table = at + 1;
    const uint64_t first = out->table + 8 <= m->size ? get(m->data + out->table, 8) : 0;
    if (first > out->table && first < m->size && (first - out->table) / 8 <= CHUNKS)
        out->n_chunks = (size_t)(first - out->table) / 8;
    return out->n > 0;
}

static attribute *find(mutation *m, image *f, const char *name)
{
    for (size_t i = 0; i < f->n; i++)
        if (strcmp((const char *)m->data + f->of[i].at, name) == 0) return &f->of[i];
    return NULL;
}

/* The chunks went `by` bytes further. */
static void move_chunks(mutation *m, const image *f, long by)
{
    for (size_t k = 0; k < f->n_chunks; k++) {
        uint8_t *p = m->data + f->table + by + 8 * (long)k;
        put(p, get(p, 8) + (uint64_t)by, 8);
    }
}

/* As mutate_replace, within the header. */
static int replace(mutation *m, const image *f, size_t at, size_t n, const void *with, size_t n_with)
{
    if (!mutate_replace(m, at, n, with, n_with)) return 0;
    move_chunks(m, f, (long)n_with - (long)n);
    return 1;
}

static int change_attributes(mutation *m, image *f)
{
    size_t i = mutate_below(m, f->n), j = mutate_below(m, f->n);
    if (i > j) {
        const size_t k = i;
        i = j;
        j = k;
    }
    const attribute *a = &f->of[i], *b = &f->of[j];
    switch (mutate_below(m, 6)) {
    case 0:
        return i != j && mutate_swap(m, a->at, a->end - a->at, b->at, b->end - b->at);
    case 1:
        return replace(m, f, b->end, 0, m->data + a->at, a->end - a->at);
    case 2:
        return replace(m, f, a->at, a->end - a->at, "", 0);
    case 3: /* one value under the other's name */
        return i != j && replace(m, f, b->value - 4, b->size + 4, m->data + a->value - 4, a->size + 4);
    case 4:
        put(m->data + a->value - 4, mutate_integer(m, a->size), 4);
        return 1;
    default:
        mutate_same_size(m, a->value, a->size);
        return 1;
    }
}

static int change_compression(mutation *m, image *f)
{
    const attribute *a = find(m, f, mutate_below(m, 4) ? "compression" : "lineOrder");
    if (a && a->size) m->data[a->value] = (uint8_t)mutate_below(m, 11);
    return a != NULL;
}

/* Four corners, or as many numbers as there are. */
static int change_window(mutation *m, image *f)
{
    static const char *const names[] = {"dataWindow", "displayWindow", "tiles", "channels"};
    const attribute *a = find(m, f, names[mutate_below(m, 4)]);
    if (!a || a->size < 4) return 0;
    uint8_t *p = m->data + a->value + 4 * mutate_below(m, a->size / 4);
    put(p, mutate_integer(m, get(p, 4)), 4);
    return 1;
}

/* One byte of the list of channels that is a kind of pixel, or a letter of a name. */
static int change_channel(mutation *m, image *f)
{
    const attribute *a = find(m, f, "channels");
    if (!a || a->size < 18) return 0;
    const size_t name = a->value, behind = behind_text(m, name);
    if (!behind || behind + 16 > a->value + a->size) return 0;
    if (mutate_below(m, 2))
        put(m->data + behind, mutate_below(m, 4), 4);
    else if (mutate_below(m, 2))
        return replace(m, f, a->value, behind + 16 - name, "", 0);
    else
        put(m->data + behind + 8 + 4 * mutate_below(m, 2), mutate_integer(m, 1), 4);
    return 1;
}

static int change_table(mutation *m, const image *f)
{
    if (f->n_chunks == 0) return 0;
    uint8_t *a = m->data + f->table + 8 * mutate_below(m, f->n_chunks), *b = m->data + f->table + 8 * mutate_below(m, f->n_chunks);
    const uint64_t x = get(a, 8), y = get(b, 8);
    if (mutate_below(m, 2)) {
        put(a, y, 8);
        put(b, x, 8);
    } else {
        put(a, mutate_below(m, 2) ? y : mutate_integer(m, x), 8);
    }
    return 1;
}

/* Its line, its size, or what it holds. */
static int change_chunk(mutation *m, const image *f)
{
    if (f->n_chunks == 0) return 0;
    const uint64_t at = get(m->data + f->table + 8 * mutate_below(m, f->n_chunks), 8);
    if (at > m->size || m->size - at < 8) return 0;
    uint8_t *p = m->data + at;
    const size_t left = m->size - (size_t)at - 8, n = (size_t)get(p + 4, 4);
    switch (mutate_below(m, 3)) {
    case 0:
        put(p, mutate_integer(m, get(p, 4)), 4);
        return 1;
    case 1:
        put(p + 4, mutate_integer(m, n), 4);
        return 1;
    default:
        mutate_same_size(m, (size_t)at + 8, n < left ? n : left);
        return 1;
    }
}

int mutate_exr(mutation *m)
{
    static image f;
    if (!take_apart(m, &f)) return 0;
    switch (mutate_below(m, 8)) {
    case 0:
        return change_compression(m, &f);
    case 1:
        return change_window(m, &f);
    case 2:
        return change_channel(m, &f);
    case 3:
        return change_table(m, &f);
    case 4:
        return change_chunk(m, &f);
    case 5:
        m->data[4 + mutate_below(m, 2)] ^= (uint8_t)(1u << mutate_below(m, 8)); /* version; tiles, long names, parts, depth */
        return 1;
    default:
        return change_attributes(m, &f);
    }
}
