/* Rows that differ by wavelength become samples with one channel per wavelength.
 *
 * Rows of the same four angles (to the bit) and different wavelengths are one sample; measured twice at one wavelength, they are
 * two. A table knows validity per sample only, so a pair of directions that lacks one of its wavelengths is of no use and is left
 * out. Where that would leave out more than half of the samples (a random choice of directions at each wavelength), the wavelength
 * with the most rows is read alone. `part` names the wavelengths instead. What is left out is noted. */
#define _GNU_SOURCE
#include "internal_csv.h"
#include "base/internal_input.h"
#include "base/internal_number.h"
#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

enum { WAVELENGTHS_MAX = 4096, LIST = 400 };
static const size_t none = SIZE_MAX;

typedef struct pivot {
    const ff_table *rows;
    const char *path;
    ff_error *err;
    size_t n_nm;         /* wavelengths in the file, ascending */
    double *nm;          /* [n_nm]                             */
    size_t *count;       /* [n_nm] rows of each                */
    size_t *of_row;      /* [n] wavelength of a row            */
    size_t *place;       /* [n_nm] of each, in what is filled  */
    unsigned char *used; /* [n_nm]                             */
    size_t n_used;
    size_t *order; /* [n] rows of the wavelengths used, by wavelength, then as in the file */
    size_t n_order, n_samples, n_complete;
    size_t *sample_of;     /* [n] sample of a row                                           */
    size_t *first;         /* [n] first row of a sample                                     */
    size_t *filled;        /* [n] wavelengths that a sample has                             */
    size_t *next;          /* [n] sample of the same pair of directions, measured again     */
    size_t *cursor;        /* [n] of the first sample of a pair: sample filled last         */
    size_t *last;          /* [n] wavelength + 1 that a sample was filled with last         */
    size_t *slot, n_slots; /* hash table of the first samples                              */
} pivot;

static ff_status no_memory(const pivot *p)
{
    return ff_error_set(p->err, FF_ERR_MEMORY, p->path, 0, -1, "no memory to sort %zu rows by wavelength", p->rows->n);
}

void ff_csv_wavelength_name(double nm, char out[FF_CHANNEL_NAME])
{
    char number[FF_NUMBER_TEXT];
    unsigned n = ff_number_write(round(nm * 1e6) / 1e6, number);
    memcpy(out, number, n);
    strcpy(out + n, "nm");
}

/* ---- the wavelengths ------------------------------------------------------------------------- */

static size_t lower_bound(const pivot *p, double nm)
{
    size_t low = 0, high = p->n_nm;
    while (low < high) {
        size_t middle = low + (high - low) / 2;
        if (p->nm[middle] < nm)
            low = middle + 1;
        else
            high = middle;
    }
    return low;
}

/* To 1e-6 nm: what units made of a number does not tell wavelengths apart. */
static double rounded(double nm)
{
    return nm < 1e9 ? round(nm * 1e6) / 1e6 : nm;
}

static ff_status collect_wavelengths(pivot *p)
{
    const double *nm = p->rows->value + p->rows->n;
    double previous = NAN;
    for (size_t i = 0; i < p->rows->n; i++) {
        double v = rounded(nm[i]);
        if (v == previous) continue;
        previous = v;
        size_t at = lower_bound(p, v);
        if (at < p->n_nm && p->nm[at] == v) continue;
        if (p->n_nm == WAVELENGTHS_MAX)
            return ff_error_set(p->err, FF_ERR_DATA, p->path, 0, -1,
                                "found more than %d different wavelengths, expected fewer: is that column the wavelength?",
                                WAVELENGTHS_MAX);
        memmove(p->nm + at + 1, p->nm + at, (p->n_nm - at) * sizeof *p->nm);
        p->nm[at] = v;
        p->n_nm++;
    }
    size_t at = 0;
    for (size_t i = 0; i < p->rows->n; i++) {
        double v = rounded(nm[i]);
        if (p->nm[at] != v) at = lower_bound(p, v);
        p->of_row[i] = at;
        p->count[at]++;
    }
    return FF_OK;
}

/* "351nm, 532nm, ...": those that are used, or not, or (-1) all. */
static const char *list(const pivot *p, int used, char out[LIST])
{
    size_t at = 0;
    out[0] = '\0';
    for (size_t w = 0; w < p->n_nm; w++) {
        char name[FF_CHANNEL_NAME];
        if (used >= 0 && p->used[w] != used) continue;
        ff_csv_wavelength_name(p->nm[w], name);
        if (at + strlen(name) + 8 > LIST) {
            strcpy(out + at, ", ...");
            break;
        }
        at = (size_t)(stpcpy(stpcpy(out + at, at ? ", " : ""), name) - out);
    }
    return out;
}

static size_t wavelength_named(const pivot *p, const char *text, size_t length)
{
    double nm;
    char word[FF_NUMBER_TEXT * 2];
    if (length >= sizeof word) return none;
    memcpy(word, text, length);
    word[length] = '\0';
    const char *end = ff_number_read(word, &nm);
    if (!end || (*end && strcmp(end + (*end == ' '), "nm") != 0)) return none;
    size_t at = lower_bound(p, rounded(nm));
    return at < p->n_nm && p->nm[at] == rounded(nm) ? at : none;
}

static ff_status use_named(pivot *p, const char *part)
{
    for (const char *at = part; at; at = *at == ',' ? at + 1 : NULL) {
        at += strspn(at, " \t");
        size_t length = strcspn(at, ","), bare = length;
        while (bare && (at[bare - 1] == ' ' || at[bare - 1] == '\t')) bare--;
        size_t w = wavelength_named(p, at, bare);
        if (w == none) {
            char found[FF_QUOTE], names[LIST];
            return ff_error_set(p->err, FF_ERR_UNKNOWN, p->path, 0, -1,
                                "found the part %s, expected wavelengths of the file, separated by commas: %s",
                                ff_quote(at, bare, found), list(p, -1, names));
        }
        p->n_used += !p->used[w];
        p->used[w] = 1;
        at += length;
    }
    return FF_OK;
}

static void use_most_frequent(pivot *p)
{
    size_t best = 0;
    for (size_t w = 1; w < p->n_nm; w++)
        if (p->count[w] > p->count[best]) best = w;
    memset(p->used, 0, p->n_nm);
    p->used[best] = 1;
    p->n_used = 1;
}

/* ---- samples --------------------------------------------------------------------------------- */

static uint64_t angle_bits(const pivot *p, int k, size_t row)
{
    double v = p->rows->angle[k][row] + 0.0; /* -0 is 0 */
    uint64_t u;
    memcpy(&u, &v, sizeof u);
    return u;
}

static size_t hash_of(const pivot *p, size_t row)
{
    uint64_t h = 0;
    for (int k = 0; k < 4; k++) {
        h = (h ^ angle_bits(p, k, row)) * 0x9E3779B97F4A7C15u;
        h ^= h >> 32;
    }
    return (size_t)h & (p->n_slots - 1);
}

static int same_directions(const pivot *p, size_t a, size_t b)
{
    for (int k = 0; k < 4; k++)
        if (angle_bits(p, k, a) != angle_bits(p, k, b)) return 0;
    return 1;
}

static size_t add_sample(pivot *p, size_t row)
{
    size_t s = p->n_samples++;
    p->first[s] = row;
    p->filled[s] = p->last[s] = 0;
    p->next[s] = none;
    p->cursor[s] = s;
    return s;
}

/* The first sample of a row's pair of directions. */
static size_t head_of(pivot *p, size_t row)
{
    size_t at = hash_of(p, row);
    for (; p->slot[at] != none; at = (at + 1) & (p->n_slots - 1))
        if (same_directions(p, p->first[p->slot[at]], row)) return p->slot[at];
    return p->slot[at] = add_sample(p, row);
}

/* The row's sample is the first of its pair that has no value at this wavelength yet. Rows come by wavelength, so that the cursor
 * moves along the samples of a pair once for each. */
static void place_row(pivot *p, size_t row)
{
    size_t w = p->of_row[row], head = head_of(p, row);
    size_t s = p->last[head] == w + 1 ? p->cursor[head] : none;
    if (s == none) {
        s = head;
    } else {
        if (p->next[s] == none) {
            size_t added = add_sample(p, row);
            p->next[s] = added;
        }
        s = p->next[s];
    }
    p->cursor[head] = s;
    p->last[s] = p->last[head] = w + 1;
    p->filled[s]++;
    p->sample_of[row] = s;
}

static void sort_rows(pivot *p)
{
    size_t *from = p->place, at = 0;
    for (size_t w = 0; w < p->n_nm; w++) {
        from[w] = at;
        at += p->used[w] ? p->count[w] : 0;
    }
    p->n_order = at;
    for (size_t i = 0; i < p->rows->n; i++)
        if (p->used[p->of_row[i]]) p->order[from[p->of_row[i]]++] = i;
}

static void make_samples(pivot *p)
{
    sort_rows(p);
    memset(p->slot, 0xFF, p->n_slots * sizeof *p->slot);
    p->n_samples = p->n_complete = 0;
    for (size_t k = 0; k < p->n_order; k++) place_row(p, p->order[k]);
    for (size_t s = 0; s < p->n_samples; s++) p->n_complete += p->filled[s] == p->n_used;
}

/* ---- the table ------------------------------------------------------------------------------- */

static void fill(const pivot *p, ff_table *t)
{
    size_t *channel = p->place, c = 0, i = 0;
    for (size_t w = 0; w < p->n_nm; w++) {
        if (!p->used[w]) continue;
        channel[w] = c;
        ff_csv_wavelength_name(p->nm[w], t->channels[c].name);
        t->channels[c++].wavelength_nm = p->nm[w];
    }
    for (size_t s = 0; s < p->n_samples; s++) { /* p->last becomes the place of a sample in the table */
        p->last[s] = p->filled[s] == p->n_used ? i++ : none;
        if (p->last[s] == none) continue;
        for (int k = 0; k < 4; k++) t->angle[k][p->last[s]] = p->rows->angle[k][p->first[s]];
        if (t->weight) t->weight[p->last[s]] = p->rows->weight[p->first[s]];
    }
    for (size_t k = 0; k < p->n_order; k++) {
        size_t row = p->order[k], place = p->last[p->sample_of[row]];
        if (place == none) continue;
        size_t cell = channel[p->of_row[row]] * t->n + place;
        t->value[cell] = p->rows->value[row];
        if (t->sigma) t->sigma[cell] = p->rows->sigma[row];
        if (!p->rows->valid[row]) t->valid[place] = 0;
    }
}

static void describe(const pivot *p, const char *part, size_t n_pairs_of_all, ff_table *t)
{
    char used[LIST], others[LIST];
    t->radians_per_unit = p->rows->radians_per_unit;
    if (n_pairs_of_all)
        ff_table_note(t,
                      "the directions differ between wavelengths (%zu samples, few of them with all %zu): %s alone is read, "
                      "without %s; the option 'part' chooses others",
                      n_pairs_of_all, p->n_nm, list(p, 1, used), list(p, 0, others));
    else if (p->n_used < p->n_nm && part)
        ff_table_note(t, "read are the rows of %s, as asked, without those of %s", list(p, 1, used), list(p, 0, others));
    if (p->n_complete < p->n_samples)
        ff_table_note(t, "%zu of %zu samples lack one of the %zu wavelengths and are left out", p->n_samples - p->n_complete,
                      p->n_samples, p->n_used);
}

static ff_status run(pivot *p, const char *part, ff_table *out)
{
    ff_table t;
    char names[LIST];
    size_t differing = 0;
    ff_status status = collect_wavelengths(p);
    if (status != FF_OK) return status;
    if (part) {
        status = use_named(p, part);
        if (status != FF_OK) return status;
    } else {
        memset(p->used, 1, p->n_nm);
        p->n_used = p->n_nm;
    }
    make_samples(p);
    if (!part && 2 * p->n_complete < p->n_samples) {
        differing = p->n_samples;
        use_most_frequent(p);
        make_samples(p);
    }
    if (p->n_complete == 0)
        return ff_error_set(p->err, FF_ERR_DATA, p->path, 0, -1,
                            "found no pair of directions measured at all of %s, expected one; choose a single wavelength",
                            list(p, 1, names));
    status = ff_table_init(p->n_complete, p->n_used, NULL, p->rows->sigma != NULL, p->rows->weight != NULL, &t, p->err);
    if (status != FF_OK) return status;
    fill(p, &t);
    describe(p, part, differing, &t);
    *out = t;
    return FF_OK;
}

ff_status ff_csv_pivot(const ff_table *rows, const char *part, const char *path, ff_table *out, ff_error *err)
{
    pivot p = {.rows = rows, .path = path, .err = err, .n_slots = 16};
    while (p.n_slots < 2 * rows->n) p.n_slots *= 2;
    size_t **const arrays[] = {&p.of_row, &p.order, &p.sample_of, &p.first, &p.filled, &p.next, &p.cursor, &p.last};
    int there = (p.nm = malloc(WAVELENGTHS_MAX * sizeof *p.nm)) && (p.used = calloc(WAVELENGTHS_MAX, 1)) &&
                (p.count = calloc(WAVELENGTHS_MAX, sizeof *p.count)) && (p.place = malloc(WAVELENGTHS_MAX * sizeof *p.place)) &&
                (p.slot = malloc(p.n_slots * sizeof *p.slot));
    for (size_t k = 0; k < sizeof arrays / sizeof arrays[0] && there; k++)
        there = (*arrays[k] = malloc(rows->n * sizeof(size_t))) != NULL;
    ff_status status = there ? run(&p, part, out) : no_memory(&p);
    for (size_t k = 0; k < sizeof arrays / sizeof arrays[0]; k++) free(*arrays[k]);
    free(p.nm);
    free(p.used);
    free(p.count);
    free(p.place);
    free(p.slot);
    return status;
}
