/* The container of tensors: its fields are taken apart, changed, and laid out anew; offsets are true but where they are to be
 * wrong. */
#include "data_formats/formats/rgl/internal_tensor_file.h"
#include "mutate.h"
#include <string.h>

enum { FIELDS = 24, DIMS = 6, NAME = 32, ROOM = 1 << 16 };

typedef struct field {
    char name[NAME];
    size_t n_name, n_dims, n_data;
    unsigned type;
    uint64_t dim[DIMS];
    uint8_t *data;
    int wrong_offset;
    uint64_t offset; /* where it is wrong */
} field;

typedef struct tensors {
    size_t n;
    field of[FIELDS];
    uint8_t room[ROOM]; /* for data */
    size_t used;
} tensors;

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

/* Bytes of the data, as shape and type say; at most what there is room for. */
static size_t bytes_of(const field *f)
{
    uint64_t n = ff_tensor_type_bytes(f->type);
    for (size_t k = 0; k < f->n_dims; k++) {
        if (f->dim[k] == 0 || n == 0) return 0;
        if (f->dim[k] > ROOM / n) return ROOM;
        n *= f->dim[k];
    }
    return (size_t)n;
}

/* Its data has `n` bytes from here on, the old ones again and again. 0: no room. */
static int resize(tensors *t, field *f, size_t n)
{
    if (n > ROOM - t->used) return 0;
    uint8_t *to = t->room + t->used;
    for (size_t i = 0; i < n; i++) to[i] = f->n_data ? f->data[i % f->n_data] : 0;
    t->used += n;
    f->data = to;
    f->n_data = n;
    return 1;
}

/* 0 where the file ends before its descriptions do. */
static int take_field(const mutation *m, size_t *at, field *f)
{
    const uint8_t *d = m->data;
    if (m->size - *at < 2) return 0;
    const size_t n_name = (size_t)get(d + *at, 2);
    *at += 2;
    if (n_name >= NAME || m->size - *at < n_name + 11) return 0;
    *f = (field){.n_name = n_name};
    memcpy(f->name, d + *at, n_name);
    *at += n_name;
    f->n_dims = (size_t)get(d + *at, 2);
    f->type = d[*at + 2];
    f->offset = get(d + *at + 3, 8);
    *at += 11;
    if (f->n_dims > DIMS || m->size - *at < 8 * f->n_dims) return 0;
    for (size_t k = 0; k < f->n_dims; k++) f->dim[k] = get(d + *at + 8 * k, 8);
    *at += 8 * f->n_dims;
    const size_t n = bytes_of(f);
    f->wrong_offset = f->offset > m->size || n > m->size - f->offset;
    f->data = f->wrong_offset ? NULL : m->data + f->offset;
    f->n_data = f->wrong_offset ? 0 : n;
    return 1;
}

static int take_apart(const mutation *m, tensors *t)
{
    size_t at = FF_TENSOR_HEADER;
    t->n = t->used = 0;
    if (m->size < FF_TENSOR_HEADER || memcmp(m->data, ff_tensor_magic, FF_TENSOR_MAGIC)) return 0;
    const uint64_t n = get(m->data + 14, 4);
    while (t->n < n && t->n < FIELDS && take_field(m, &at, &t->of[t->n])) t->n++;
    return t->n > 0;
}

static size_t begin_of_data(const tensors *t)
{
    size_t at = FF_TENSOR_HEADER;
    for (size_t i = 0; i < t->n; i++) at += 13 + t->of[i].n_name + 8 * t->of[i].n_dims;
    return (at + 7) / 8 * 8;
}

static size_t put_field(uint8_t *to, const field *f, size_t place)
{
    put(to, f->n_name, 2);
    memcpy(to + 2, f->name, f->n_name);
    uint8_t *p = to + 2 + f->n_name;
    put(p, f->n_dims, 2);
    p[2] = (uint8_t)f->type;
    put(p + 3, f->wrong_offset ? f->offset : place, 8);
    for (size_t k = 0; k < f->n_dims; k++) put(p + 11 + 8 * k, f->dim[k], 8);
    return 13 + f->n_name + 8 * f->n_dims;
}

static int lay_out(mutation *m, const tensors *t)
{
    static uint8_t out[ROOM];
    size_t at = FF_TENSOR_HEADER, place = begin_of_data(t), whole = place;
    for (size_t i = 0; i < t->n; i++) whole += (t->of[i].n_data + 7) / 8 * 8;
    if (whole > m->most || whole > ROOM) return 0;
    memset(out, 0, whole);
    memcpy(out, m->data, 14);
    put(out + 14, t->n, 4);
    for (size_t i = 0; i < t->n; i++) {
        const field *f = &t->of[i];
        at += put_field(out + at, f, place);
        if (f->n_data) memcpy(out + place, f->data, f->n_data);
        place += (f->n_data + 7) / 8 * 8;
    }
    memcpy(m->data, out, whole);
    m->size = whole;
    return 1;
}

/* ---- changes ------------------------------------------------------------------------------------ */

static void swap_fields(mutation *m, tensors *t, field *a)
{
    field *b = &t->of[mutate_below(m, t->n)], old = *a;
    const size_t how = mutate_below(m, 3);
    if (how == 0) { /* of one name with the other's data */
        memcpy(a->name, b->name, NAME);
        memcpy(b->name, old.name, NAME);
        a->n_name = b->n_name;
        b->n_name = old.n_name;
    } else if (how == 1) { /* of one shape with the other's */
        memcpy(a->dim, b->dim, sizeof a->dim);
        memcpy(b->dim, old.dim, sizeof b->dim);
        a->n_dims = b->n_dims;
        b->n_dims = old.n_dims;
    } else {
        *a = *b;
        *b = old;
    }
}

static void remove_field(tensors *t, field *f)
{
    const size_t k = (size_t)(f - t->of);
    memmove(f, f + 1, (t->n - k - 1) * sizeof *f);
    t->n--;
}

static void permute_axes(mutation *m, field *f)
{
    for (size_t k = f->n_dims; k > 1; k--) {
        const size_t other = mutate_below(m, k);
        const uint64_t d = f->dim[k - 1];
        f->dim[k - 1] = f->dim[other];
        f->dim[other] = d;
    }
}

static void change_rank(mutation *m, field *f)
{
    if (mutate_below(m, 2) && f->n_dims < DIMS)
        f->dim[f->n_dims++] = mutate_below(m, 3);
    else if (f->n_dims > 0)
        f->n_dims--;
}

/* One element of the data: a number that no angle, wavelength or density is. */
static void change_value(mutation *m, tensors *t, field *f)
{
    static const float odd[] = {0, -0.0f, -1, 1, 2, 1e38f, -1e38f, 1e-45f, 1.5707964f, 3.1415927f, 6.2831855f};
    float v = odd[mutate_below(m, sizeof odd / sizeof *odd)];
    const uint32_t bits[] = {0x7f800000, 0xff800000, 0x7fc00000};
    if (mutate_below(m, 4) == 0) memcpy(&v, &bits[mutate_below(m, 3)], sizeof v);
    if (f->n_data < sizeof v || !resize(t, f, f->n_data)) return;
    memcpy(f->data + mutate_below(m, f->n_data / sizeof v) * sizeof v, &v, sizeof v);
}

int mutate_tensors(mutation *m)
{
    static tensors t;
    if (!take_apart(m, &t)) return 0;
    field *f = &t.of[mutate_below(m, t.n)];
    switch (mutate_below(m, 9)) {
    case 0:
        swap_fields(m, &t, f);
        break;
    case 1:
        if (t.n < FIELDS) t.of[t.n++] = *f;
        break;
    case 2:
        remove_field(&t, f);
        break;
    case 3: /* the data go with it, or stay */
        if (f->n_dims) f->dim[mutate_below(m, f->n_dims)] = mutate_integer(m, f->dim[0]);
        if (mutate_below(m, 4)) resize(&t, f, bytes_of(f));
        break;
    case 4:
        f->type = 1 + (unsigned)mutate_below(m, FF_TENSOR_FLOAT64);
        if (mutate_below(m, 4)) resize(&t, f, bytes_of(f));
        break;
    case 5:
        permute_axes(m, f);
        break;
    case 6:
        f->wrong_offset = 1;
        f->offset = mutate_integer(m, t.of[mutate_below(m, t.n)].offset);
        break;
    case 7:
        change_rank(m, f);
        if (mutate_below(m, 4)) resize(&t, f, bytes_of(f));
        break;
    default:
        change_value(m, &t, f);
    }
    return lay_out(m, &t);
}
