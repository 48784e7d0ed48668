/* The numbers of a WINDOW file. format_window.c has the layout and the conventions. */
#define _GNU_SOURCE
#include "internal_window.h"
#include "base/internal_input.h"
#include "base/internal_number.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

static const double pi = 3.14159265358979323846;
static const double degree = 3.14159265358979323846 / 180;

/* ---- bases ----------------------------------------------------------------------------------- */

/* Klems 1994: upper bound of theta and number of azimuths of each ring. */
static const struct {
    const char *name;
    struct {
        double upper;
        size_t n_phi;
    } ring[10];
} standard[] = {
    {"LBNL/Klems Full", {{5, 1}, {15, 8}, {25, 16}, {35, 20}, {45, 24}, {55, 24}, {65, 24}, {75, 16}, {90, 12}}},
    {"LBNL/Klems Half", {{6.5, 1}, {19.5, 8}, {32.5, 12}, {45.5, 16}, {58.5, 20}, {71.5, 12}, {90, 8}}},
    {"LBNL/Klems Quarter", {{9, 1}, {27, 8}, {45, 12}, {63, 12}, {90, 8}}},
};

int ff_window_standard_basis(ff_window_basis *b)
{
    for (size_t k = 0; k < sizeof standard / sizeof standard[0]; k++) {
        if (strcasecmp(b->name, standard[k].name) != 0) continue;
        double lower = 0;
        b->n_rings = b->n = 0;
        for (size_t j = 0; standard[k].ring[j].n_phi; j++) {
            const double upper = standard[k].ring[j].upper;
            b->ring[b->n_rings++] = (ff_window_ring){j ? (lower + upper) / 2 : 0, lower, upper, standard[k].ring[j].n_phi};
            b->n += standard[k].ring[j].n_phi;
            lower = upper;
        }
        return 1;
    }
    return 0;
}

ff_status ff_window_add_ring(ff_window_basis *b, const ff_window_ring *ring, const char *path, long line, ff_error *err)
{
    const double below = b->n_rings ? b->ring[b->n_rings - 1].upper : 0, close = 1e-6;
    if (b->n_rings == FF_WINDOW_RINGS)
        return ff_error_set(err, FF_ERR_FORMAT, path, line, -1, "found more than %d blocks in the basis '%s', expected fewer",
                            FF_WINDOW_RINGS, b->name);
    if (!(fabs(ring->lower - below) <= close && ring->upper > ring->lower && ring->upper <= 90 + close))
        return ff_error_set(
            err, FF_ERR_DATA, path, line, -1,
            "basis '%s': found a block from theta %g to %g, expected it to begin at %g and to end at most at 90 degrees", b->name,
            ring->lower, ring->upper, below);
    if (!(ring->theta >= ring->lower - close && ring->theta <= ring->upper + close))
        return ff_error_set(err, FF_ERR_DATA, path, line, -1,
                            "basis '%s': found theta %g, expected it between its bounds %g and %g", b->name, ring->theta,
                            ring->lower, ring->upper);
    if (ring->n_phi == 1 && b->n_rings > 0)
        return ff_error_set(
            err, FF_ERR_UNSUPPORTED, path, line, -1,
            "basis '%s': found one patch all around at theta %g to %g, which averages over the azimuth; expected several", b->name,
            ring->lower, ring->upper);
    if (b->n + ring->n_phi > FF_WINDOW_PATCHES)
        return ff_error_set(err, FF_ERR_DATA, path, line, -1, "basis '%s': found more than %d patches, expected fewer", b->name,
                            FF_WINDOW_PATCHES);
    b->ring[b->n_rings++] = *ring;
    b->n += ring->n_phi;
    return FF_OK;
}

void ff_window_patches(const ff_window_basis *b, double *theta, double *phi, double *omega)
{
    size_t at = 0;
    for (size_t j = 0; j < b->n_rings; j++) {
        const ff_window_ring *r = &b->ring[j];
        const double n = (double)r->n_phi;
        for (size_t k = 0; k < r->n_phi; k++, at++) {
            theta[at] = r->theta;
            phi[at] = 360 * (double)k / n;
            omega[at] = 2 * pi * (cos(degree * r->lower) - cos(degree * r->upper)) / n;
        }
    }
}

/* ---- tensor trees ---------------------------------------------------------------------------- */

static long line_of(const ff_scattering *s)
{
    long line = s->first_line;
    for (const char *p = s->buffer; p < s->at; p++) line += *p == '\n';
    return line;
}

/* Centre and solid angle of a cell [x, x+w] x [y, y+w] of the unit square, which Shirley and Chiu 1997 map to the unit disk; the
 * disk stands for (sin theta cos phi, sin theta sin phi). Their map preserves area; sin theta = max(|a|, |b|) makes the integral of
 * dx dy / cos theta over a dyadic cell one of two closed forms. */
static ff_tree_cell disk_cell(double x, double y, double w)
{
    const double a = 2 * x - 1 + w, b = 2 * y - 1 + w, fa = fabs(a), fb = fabs(b), r = fmax(fa, fb);
    const double from = fmax(r - w, 0), to = fmin(r + w, 1); /* sin theta at the inner and at the outer edge */
    ff_tree_cell c = {.theta = asin(r) / degree};
    if (fa > fb)
        c.phi = 45 * (b / a) + (a < 0 ? 180 : 0);
    else if (r > 0)
        c.phi = 90 - 45 * (a / b) + (b < 0 ? 180 : 0);
    if (w == 1)
        c.omega = 2 * pi;
    else if (fa == fb) /* on a diagonal */
        c.omega = pi / 2 * (sqrt(1 - from * from) - sqrt(1 - to * to) - from * (asin(to) - asin(from)));
    else
        c.omega = pi / 2 * w * (asin(to) - asin(from));
    return c;
}

/* The ring of all directions of incidence whose coordinate (1 - sin theta) / 2 is in [x, x+w]; beyond 1/2 it stands for nothing. */
static ff_tree_cell ring_cell(double x, double w)
{
    const double outer = 1 - 2 * x, inner = fmax(outer - 2 * w, 0);
    if (outer <= 0) return (ff_tree_cell){0, 0, 0};
    const double omega = 2 * pi * (sqrt(1 - inner * inner) - sqrt(1 - outer * outer));
    return (ff_tree_cell){asin((inner + outer) / 2) / degree, 0, omega};
}

static double turned(double phi)
{
    phi = fmod(phi, 360);
    return phi < 0 ? phi + 360 : phi;
}

/* Cells of a leaf: those of incidence, then those of exit, m along each axis. */
static ff_status make_cells(ff_scattering *s, const double *corner, double w, size_t m, size_t n_incident)
{
    const size_t need = n_incident + m * m;
    if (need > s->n_cells) {
        ff_tree_cell *larger = realloc(s->cell, need * sizeof *larger);
        if (!larger) return ff_error_set(s->err, FF_ERR_MEMORY, s->path, line_of(s), -1, "no memory for %zu cells", need);
        s->cell = larger;
        s->n_cells = need;
    }
    for (size_t i = 0; i < n_incident; i++) {
        ff_tree_cell *c = &s->cell[i];
        const size_t row = i / m, column = i % m;
        *c = s->rank == 3 ? ring_cell(corner[0] + w * (double)i, w)
                          : disk_cell(corner[0] + w * (double)row, corner[1] + w * (double)column, w);
        c->phi = turned(s->mirrored ? -c->phi : c->phi + 180);
    }
    for (size_t o = 0; o < m * m; o++) {
        ff_tree_cell *c = &s->cell[n_incident + o];
        const size_t row = o / m, column = o % m;
        *c = disk_cell(corner[s->rank - 2] + w * (double)row, corner[s->rank - 1] + w * (double)column, w);
        c->phi = turned(s->mirrored ? 180 - c->phi : c->phi);
    }
    return FF_OK;
}

/* Index of a cell of a leaf's grid along each axis, the last one fastest. */
static ff_status place_leaf(ff_scattering *s, const double *corner, unsigned level, size_t m, size_t index)
{
    if (s->leaves.n == s->place_room) {
        const size_t room = s->place_room ? 2 * s->place_room : 1 << 10;
        ff_tree_place *larger = realloc(s->place, room * sizeof *larger);
        if (!larger) return ff_error_set(s->err, FF_ERR_MEMORY, s->path, line_of(s), -1, "no memory for %zu leaves", room);
        s->place = larger;
        s->place_room = room;
    }
    ff_tree_place *p = &s->place[s->leaves.n];
    *p = (ff_tree_place){.level = (unsigned char)level};
    for (int axis = s->rank - 1; axis >= 0; axis--, index /= m)
        p->corner[axis] = (uint32_t)ldexp(corner[axis] + ldexp((double)(index % m), -(int)level), FF_TREE_LEVELS);
    return FF_OK;
}

static ff_status take_leaf(ff_scattering *s, const ff_tree_cell *incident, const ff_tree_cell *exit, double value)
{
    double *row = ff_rows_add(&s->leaves);
    if (!row) return ff_error_set(s->err, FF_ERR_MEMORY, s->path, line_of(s), -1, "no memory for leaf %zu", s->leaves.n + 1);
    row[0] = incident->theta;
    row[1] = incident->phi;
    row[2] = exit->theta;
    row[3] = exit->phi;
    row[4] = value;
    row[5] = incident->omega * exit->omega;
    return FF_OK;
}

/* The values of a leaf: a grid of m = 2^k cells along each axis, the last axis fastest. */
static ff_status close_leaf(ff_scattering *s, const ff_tree_node *node)
{
    const unsigned rank = (unsigned)s->rank, above = s->depth - 1;
    unsigned k = 0;
    while (rank * k < 63 && (UINT64_C(1) << (rank * k)) < s->n) k++;
    if (rank * k >= 63 || (UINT64_C(1) << (rank * k)) != s->n)
        return ff_error_set(s->err, FF_ERR_FORMAT, s->path, line_of(s), -1,
                            "found %zu values in a leaf of the tree, expected a power of %u of them", s->n, 1u << rank);
    if (above + k > FF_TREE_LEVELS)
        return ff_error_set(s->err, FF_ERR_FORMAT, s->path, line_of(s), -1, "found a tree of more than %d levels, expected fewer",
                            FF_TREE_LEVELS);
    const size_t m = (size_t)1 << k, n_incident = rank == 3 ? m : m * m, n_exit = m * m;
    ff_status status = make_cells(s, node->corner, ldexp(1, -(int)(above + k)), m, n_incident);
    for (size_t i = 0; i < n_incident && status == FF_OK; i++) {
        if (s->cell[i].omega == 0) continue;
        for (size_t o = 0; o < n_exit && status == FF_OK; o++) {
            status = place_leaf(s, node->corner, above + k, m, i * n_exit + o);
            if (status == FF_OK) status = take_leaf(s, &s->cell[i], &s->cell[n_incident + o], s->value[i * n_exit + o]);
        }
    }
    s->n = 0;
    return status;
}

static ff_status open_node(ff_scattering *s)
{
    ff_tree_node *parent = s->depth ? &s->node[s->depth - 1] : NULL;
    if (s->closed || s->n > 0 || (parent && parent->children == 1u << s->rank))
        return ff_error_set(s->err, FF_ERR_FORMAT, s->path, line_of(s), -1, "found '{' %s, expected %s",
                            s->closed  ? "after the tree"
                            : s->n > 0 ? "among the values of a leaf"
                                       : "after all branches of a node",
                            s->closed ? "nothing more" : "'}'");
    if (s->depth > FF_TREE_LEVELS)
        return ff_error_set(s->err, FF_ERR_FORMAT, s->path, line_of(s), -1, "found a tree of more than %d levels, expected fewer",
                            FF_TREE_LEVELS);
    ff_tree_node *node = &s->node[s->depth];
    *node = (ff_tree_node){.children = 0};
    const double w = ldexp(1, -(int)s->depth);
    for (int axis = 0; axis < s->rank && parent; axis++)
        node->corner[axis] = parent->corner[axis] + (parent->children >> axis & 1 ? w : 0);
    s->depth++;
    s->comma_may_follow = 0;
    return FF_OK;
}

static ff_status close_node(ff_scattering *s)
{
    if (s->depth == 0)
        return ff_error_set(s->err, FF_ERR_FORMAT, s->path, line_of(s), -1, "found '}' without a '{', expected %s",
                            s->closed ? "nothing more after the tree" : "a tree");
    const ff_tree_node *node = &s->node[s->depth - 1];
    if (s->n == 0 && node->children != 1u << s->rank)
        return ff_error_set(s->err, FF_ERR_FORMAT, s->path, line_of(s), -1,
                            "found a node of %u branches, expected values or %u branches", node->children, 1u << s->rank);
    if (s->n > 0) {
        const ff_status status = close_leaf(s, node);
        if (status != FF_OK) return status;
    }
    s->depth--;
    if (s->depth > 0)
        s->node[s->depth - 1].children++;
    else
        s->closed = 1;
    s->comma_may_follow = 1;
    return FF_OK;
}

/* ---- words ----------------------------------------------------------------------------------- */

static int is_blank(char c)
{
    return c == ' ' || c == '\t' || c == '\n' || c == '\r';
}

static int ends_number(const ff_scattering *s, char c)
{
    return is_blank(c) || c == ',' || (s->rank && (c == '{' || c == '}'));
}

static ff_status bad_word(const ff_scattering *s, const char *word, const char *stop)
{
    char found[FF_QUOTE];
    const char *end = word;
    while (end < stop && !ends_number(s, *end)) end++;
    return ff_error_set(s->err, FF_ERR_DATA, s->path, line_of(s), -1, "value %zu: found %s, expected a finite number",
                        s->leaves.n + s->n + 1, ff_quote(word, (size_t)(end - word), found));
}

static ff_status grow(ff_scattering *s)
{
    const size_t capacity = s->capacity ? 2 * s->capacity : 1 << 12;
    double *larger = realloc(s->value, capacity * sizeof *larger);
    if (!larger) return ff_error_set(s->err, FF_ERR_MEMORY, s->path, line_of(s), -1, "no memory for %zu values", capacity);
    s->value = larger;
    s->capacity = capacity;
    return FF_OK;
}

static ff_status take_number(ff_scattering *s, double value)
{
    if (s->rank == 0 && s->n == s->expected)
        return ff_error_set(s->err, FF_ERR_FORMAT, s->path, line_of(s), -1, "found more numbers, expected %s", s->what);
    if (s->rank && (s->depth == 0 || s->node[s->depth - 1].children > 0))
        return ff_error_set(s->err, FF_ERR_FORMAT, s->path, line_of(s), -1, "found the number %g %s, expected %s", value,
                            s->depth ? "among the branches of a node" : "outside of the tree", s->depth ? "'{' or '}'" : "'{'");
    if (s->n == s->capacity) {
        const ff_status status = grow(s);
        if (status != FF_OK) return status;
    }
    s->value[s->n++] = value;
    s->comma_may_follow = 1;
    return FF_OK;
}

static ff_status take_mark(ff_scattering *s, char c)
{
    if (c == '{') return open_node(s);
    if (c == '}') return close_node(s);
    if (!s->comma_may_follow)
        return ff_error_set(s->err, FF_ERR_DATA, s->path, line_of(s), -1, "value %zu: found ',', expected a finite number",
                            s->leaves.n + s->n + 1);
    s->comma_may_follow = 0;
    return FF_OK;
}

/* Words and marks of text that ends behind one of them. */
static ff_status scan(ff_scattering *s, const char *p, const char *stop)
{
    ff_status status = FF_OK;
    while (p < stop && status == FF_OK) {
        double value;
        s->at = p;
        if (is_blank(*p)) {
            p++;
        } else if (ends_number(s, *p)) {
            status = take_mark(s, *p++);
        } else {
            const char *end = ff_number_read(p, &value);
            if (!end || !ends_number(s, *end) || !isfinite(value)) return bad_word(s, p, stop);
            status = take_number(s, value);
            p = end;
        }
    }
    return status;
}

/* Reads the buffer up to the last blank or mark; the word that is not complete moves to its front. */
static ff_status flush(ff_scattering *s)
{
    const char *stop = s->buffer + s->n_buffer, *last = stop;
    while (last > s->buffer && !ends_number(s, last[-1])) last--;
    s->at = s->buffer;
    if (last == s->buffer && s->n_buffer == FF_SCATTERING_BUFFER) return bad_word(s, s->buffer, stop);
    const ff_status status = scan(s, s->buffer, last);
    s->n_buffer = (size_t)(stop - last);
    memmove(s->buffer, last, s->n_buffer);
    s->first_line = s->line(s->user); /* a piece of more than one character has no end of line in it */
    return status;
}

ff_status ff_scattering_text(ff_scattering *s, const char *text, size_t n)
{
    if (s->n_buffer == 0) s->first_line = s->line(s->user);
    while (n > 0) {
        const size_t room = FF_SCATTERING_BUFFER - s->n_buffer, part = n < room ? n : room;
        memcpy(s->buffer + s->n_buffer, text, part);
        s->n_buffer += part;
        text += part;
        n -= part;
        if (s->n_buffer < FF_SCATTERING_BUFFER) return FF_OK;
        const ff_status status = flush(s);
        if (status != FF_OK) return status;
    }
    return FF_OK;
}

ff_status ff_scattering_end(ff_scattering *s)
{
    ff_status status = ff_scattering_text(s, " ", 1);
    if (status == FF_OK) status = flush(s);
    if (status != FF_OK) return status;
    s->at = s->buffer;
    if (s->rank == 0 && s->n < s->expected)
        return ff_error_set(s->err, FF_ERR_FORMAT, s->path, line_of(s), -1, "found %zu numbers in ScatteringData, expected %s",
                            s->n, s->what);
    if (s->rank && !s->closed)
        return ff_error_set(s->err, FF_ERR_FORMAT, s->path, line_of(s), -1,
                            "found the end of ScatteringData within its tree, expected %s", s->depth ? "'}'" : "'{'");
    if (s->rank) { /* the leaves are all that remains */
        free(s->value);
        free(s->cell);
        s->value = NULL;
        s->cell = NULL;
        s->capacity = s->n_cells = 0;
    }
    return FF_OK;
}

void ff_scattering_free(ff_scattering *s)
{
    free(s->value);
    free(s->cell);
    free(s->place);
    s->value = NULL;
    s->cell = NULL;
    s->place = NULL;
    ff_rows_free(&s->leaves);
}
