/* Which patch of a matrix, or cell of a tensor tree, a pair of directions is in. format_window.c has the conventions. */
#include "internal_window.h"
#include <math.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

static const double pi = 3.14159265358979323846;
static const double degree = 3.14159265358979323846 / 180;

typedef struct window_cells {
    ff_cells cells; /* first: the table knows no more */
    atomic_int owners;
    int front;
    /* a matrix */
    ff_window_basis *incident, *exit;
    int rows;
    /* a tree */
    int rank, deepest; /* the lowest level */
    size_t n;
    ff_tree_place *place; /* [n] by sample      */
    uint32_t *order;      /* [n] along the curve */
} window_cells;

static const window_cells *inside(const ff_cells *cells)
{
    return (const window_cells *)cells;
}

/* Azimuths of the file, degrees, of those of the table: incidence is where the light goes, and x of a front points the other way.
 */
static double file_phi_i(const window_cells *w, double phi)
{
    return w->front ? -phi : phi - 180;
}

static double file_phi_o(const window_cells *w, double phi)
{
    return w->front ? 180 - phi : phi;
}

static double table_phi_i(const window_cells *w, double phi)
{
    return fmod(w->front ? 720 - phi : phi + 180, 360);
}

static double azimuth(const double v[3])
{
    return v[0] == 0 && v[1] == 0 ? 0 : atan2(v[1], v[0]) / degree;
}

static double polar(const double v[3])
{
    return atan2(hypot(v[0], v[1]), v[2]) / degree;
}

/* ---- patches --------------------------------------------------------------------------------- */

/* The ring of a polar angle, n_rings beyond all; *first: its first patch. */
static size_t ring_of(const ff_window_basis *b, double theta, size_t *first)
{
    size_t j = 0;
    *first = 0;
    while (j < b->n_rings && !(theta < b->ring[j].upper)) *first += b->ring[j++].n_phi;
    return j;
}

static size_t patch_of(const ff_window_basis *b, double theta, double phi)
{
    size_t first;
    const size_t j = ring_of(b, theta, &first);
    if (j == b->n_rings) return SIZE_MAX;
    const double n = (double)b->ring[j].n_phi, turns = phi / 360;
    const double k = floor((turns - floor(turns)) * n + 0.5);
    return first + (k < n ? (size_t)k : 0);
}

static size_t sample_of(const window_cells *w, size_t incident, size_t exit)
{
    return w->rows ? incident * w->exit->n + exit : exit * w->incident->n + incident;
}

static size_t find_patch(const ff_cells *cells, const double wi[3], const double wo[3])
{
    const window_cells *w = inside(cells);
    const size_t i = patch_of(w->incident, polar(wi), file_phi_i(w, azimuth(wi)));
    const size_t o = patch_of(w->exit, polar(wo), file_phi_o(w, azimuth(wo)));
    return i == SIZE_MAX || o == SIZE_MAX ? SIZE_MAX : sample_of(w, i, o);
}

static void visit_patches(const ff_cells *cells, const double wi[3], ff_cells_visitor *visit, void *context)
{
    const window_cells *w = inside(cells);
    const size_t i = patch_of(w->incident, polar(wi), file_phi_i(w, azimuth(wi)));
    if (i == SIZE_MAX) return;
    size_t o = 0;
    for (size_t j = 0; j < w->exit->n_rings; j++) {
        const ff_window_ring *r = &w->exit->ring[j];
        const double lower = sin(degree * r->lower), upper = sin(degree * r->upper), n = (double)r->n_phi;
        for (size_t k = 0; k < r->n_phi; k++) visit(context, sample_of(w, i, o++), pi * (upper * upper - lower * lower) / n);
    }
}

static uint64_t incident_patch(const ff_cells *cells, const double wi[3])
{
    const window_cells *w = inside(cells);
    return patch_of(w->incident, polar(wi), file_phi_i(w, azimuth(wi)));
}

static double ring_theta(const ff_cells *cells, size_t k)
{
    const ff_window_basis *b = inside(cells)->incident;
    return k < b->n_rings ? b->ring[k].theta : NAN;
}

static size_t ring_azimuths(const ff_cells *cells, double theta_i, double *phi_i)
{
    const window_cells *w = inside(cells);
    size_t first;
    const size_t j = ring_of(w->incident, theta_i, &first);
    if (j == w->incident->n_rings) return 0;
    const size_t patches = w->incident->ring[j].n_phi, n = patches < FF_CELLS_AZIMUTHS ? patches : FF_CELLS_AZIMUTHS;
    for (size_t k = 0; k < n; k++) {
        const size_t patch = k * patches / n;
        phi_i[k] = table_phi_i(w, 360 * (double)patch / (double)patches);
    }
    return n;
}

/* ---- trees ----------------------------------------------------------------------------------- */

static uint32_t whole(double x)
{
    const double cells = ldexp(1, FF_TREE_LEVELS), at = floor(x * cells);
    return at < 0 ? 0 : at < cells ? (uint32_t)at : (uint32_t)cells - 1;
}

/* The point of the unit square that Shirley and Chiu's map takes to a direction of this azimuth. */
static void square_of(double sine, double phi, uint32_t out[2])
{
    const double turned = phi + 45 - 360 * floor((phi + 45) / 360) - 45; /* -45 .. 315 */
    double a, b;
    if (turned < 45) {
        a = sine, b = turned / 45 * a;
    } else if (turned < 135) {
        b = sine, a = (90 - turned) / 45 * b;
    } else if (turned < 225) {
        a = -sine, b = (turned - 180) / 45 * a;
    } else {
        b = -sine, a = (270 - turned) / 45 * b;
    }
    out[0] = whole((a + 1) / 2);
    out[1] = whole((b + 1) / 2);
}

static void incident_point(const window_cells *w, const double wi[3], uint32_t point[4])
{
    const double sine = hypot(wi[0], wi[1]);
    if (w->rank == 3)
        point[0] = whole((1 - sine) / 2 - 1e-12); /* the normal belongs to the half that stands for something */
    else
        square_of(sine, file_phi_i(w, azimuth(wi)), point);
}

static void point_of(const window_cells *w, const double wi[3], const double wo[3], uint32_t point[4])
{
    const double sine = hypot(wo[0], wo[1]);
    incident_point(w, wi, point);
    if (w->rank == 3) { /* azimuths from that of the incidence, which the file has at 0 */
        const double apart = azimuth(wo) - azimuth(wi);
        square_of(sine, w->front ? 180 - apart : apart + 180, point + 1);
    } else {
        square_of(sine, file_phi_o(w, azimuth(wo)), point + 2);
    }
}

/* Morton's order of the corners: by the axis whose coordinates differ in the highest bit. Cells are contiguous in it. */
static int before(int rank, const uint32_t *a, const uint32_t *b)
{
    int axis = 0;
    uint32_t highest = 0;
    for (int k = 0; k < rank; k++) {
        const uint32_t differ = a[k] ^ b[k];
        if (!(highest < differ && highest < (highest ^ differ))) continue;
        highest = differ;
        axis = k;
    }
    return a[axis] < b[axis];
}

static int holds(const ff_tree_place *p, int axis, uint32_t x)
{
    return x >= p->corner[axis] && x - p->corner[axis] < (uint32_t)1 << (FF_TREE_LEVELS - p->level);
}

static size_t find_leaf(const ff_cells *cells, const double wi[3], const double wo[3])
{
    const window_cells *w = inside(cells);
    uint32_t point[4] = {0};
    point_of(w, wi, wo, point);
    size_t lo = 0, hi = w->n; /* those before lo begin at the point or before */
    while (lo < hi) {
        const size_t middle = lo + (hi - lo) / 2;
        if (before(w->rank, point, w->place[w->order[middle]].corner))
            hi = middle;
        else
            lo = middle + 1;
    }
    if (lo == 0) return SIZE_MAX;
    const ff_tree_place *p = &w->place[w->order[lo - 1]];
    for (int k = 0; k < w->rank; k++)
        if (!holds(p, k, point[k])) return SIZE_MAX;
    return w->order[lo - 1];
}

/* Shirley and Chiu's map preserves area, and that of the disk is the projected solid angle. */
static void visit_leaves(const ff_cells *cells, const double wi[3], ff_cells_visitor *visit, void *context)
{
    const window_cells *w = inside(cells);
    uint32_t point[4] = {0};
    incident_point(w, wi, point);
    for (size_t i = 0; i < w->n; i++) {
        const ff_tree_place *p = &w->place[i];
        if (holds(p, 0, point[0]) && (w->rank == 3 || holds(p, 1, point[1]))) visit(context, i, pi * ldexp(1, -2 * p->level));
    }
}

/* The place of the light among cells of the lowest level that there is. */
static uint64_t incident_leaves(const ff_cells *cells, const double wi[3])
{
    const window_cells *w = inside(cells);
    uint32_t point[4] = {0};
    incident_point(w, wi, point);
    const uint64_t x = point[0] >> (FF_TREE_LEVELS - w->deepest);
    return w->rank == 3 ? x : x << 32 | point[1] >> (FF_TREE_LEVELS - w->deepest);
}

/* None on a border between cells, as the normal and the sine of 30 degrees are. */
static double tree_theta(const ff_cells *cells, size_t k)
{
    static const double theta[] = {5, 15, 25, 45, 60, 75, 82.5};
    (void)cells;
    return k < sizeof theta / sizeof theta[0] ? theta[k] : NAN;
}

/* Half way between borders that cells of all levels have. */
static size_t tree_azimuths(const ff_cells *cells, double theta_i, double *phi_i)
{
    enum { AZIMUTHS = 24 };
    (void)theta_i;
    const size_t n = inside(cells)->rank == 3 ? 1 : AZIMUTHS;
    for (size_t k = 0; k < n; k++) phi_i[k] = n == 1 ? 0 : 360 * ((double)k + 0.5) / AZIMUTHS;
    return n;
}

/* Merges: the leaves come nearly in order. */
static void sort_places(const window_cells *w, uint32_t *order, uint32_t *room, size_t n)
{
    if (n < 2) return;
    const size_t half = n / 2;
    sort_places(w, order, room, half);
    sort_places(w, order + half, room, n - half);
    if (!before(w->rank, w->place[order[half]].corner, w->place[order[half - 1]].corner)) return;
    size_t a = 0, b = half, k = 0;
    while (a < half || b < n) {
        const int second = a == half || (b < n && before(w->rank, w->place[order[b]].corner, w->place[order[a]].corner));
        room[k++] = order[second ? b++ : a++];
    }
    memcpy(order, room, n * sizeof *order);
}

/* ---- owners ---------------------------------------------------------------------------------- */

static ff_cells *share(ff_cells *cells)
{
    ((window_cells *)cells)->owners++;
    return cells;
}

static void destroy(window_cells *w)
{
    free(w->incident);
    free(w->exit);
    free(w->place);
    free(w->order);
    free(w);
}

static void release(ff_cells *cells)
{
    window_cells *w = (window_cells *)cells;
    if (w->owners-- == 0) destroy(w);
}

static ff_window_basis *copy_of(const ff_window_basis *b)
{
    ff_window_basis *copy = malloc(sizeof *copy);
    if (copy) *copy = *b;
    return copy;
}

ff_cells *ff_window_matrix_cells(const ff_window_basis *incident, const ff_window_basis *exit, int rows, int front)
{
    window_cells *w = calloc(1, sizeof *w);
    if (!w) return NULL;
    w->cells = (ff_cells){find_patch, visit_patches, incident_patch, ring_theta, ring_azimuths, share, release};
    w->front = front;
    w->rows = rows;
    w->incident = copy_of(incident);
    w->exit = copy_of(exit);
    if (w->incident && w->exit) return &w->cells;
    destroy(w);
    return NULL;
}

ff_cells *ff_window_tree_cells(int rank, int front, size_t n, ff_tree_place *place)
{
    window_cells *w = calloc(1, sizeof *w);
    uint32_t *room = n <= UINT32_MAX ? malloc((n + 1) * sizeof *room) : NULL;
    if (!w || !room) {
        free(w);
        free(room);
        free(place);
        return NULL;
    }
    w->cells = (ff_cells){find_leaf, visit_leaves, incident_leaves, tree_theta, tree_azimuths, share, release};
    w->front = front;
    w->rank = rank;
    w->n = n;
    w->place = place;
    for (size_t i = 0; i < n; i++) w->deepest = place[i].level > w->deepest ? place[i].level : w->deepest;
    w->order = malloc((n + 1) * sizeof *w->order);
    for (size_t i = 0; i < n && w->order; i++) w->order[i] = (uint32_t)i;
    if (w->order) sort_places(w, w->order, room, n);
    free(room);
    if (w->order) return &w->cells;
    destroy(w);
    return NULL;
}
