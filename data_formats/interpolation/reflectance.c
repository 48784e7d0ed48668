/* Reflectances: by the table's own quadrature, or by interpolation. */
#include "models/model_struct.h"
#include "internal_interpolate.h"
#include "internal_reflectance.h"
#include "data_formats/table/internal_table.h"
#include <math.h>
#include <stdlib.h>

static const double pi = 3.14159265358979323846;
static const double degrees = 180 / 3.14159265358979323846;

enum { MOST_THETAS = 4096 };

/* The sums of one incidence, and where they go. */
typedef struct sums {
    const ff_table *t;
    double *albedo, *raised; /* [n_channels] */
    double covered;          /* sr            */
} sums;

static void clear(sums *s)
{
    s->covered = 0;
    for (size_t c = 0; c < s->t->n_channels; c++) s->albedo[c] = s->raised[c] = 0;
}

static void add(sums *s, size_t c, double weight, double f)
{
    s->albedo[c] += weight * f;
    s->raised[c] += weight * fmax(f, 0);
}

static void add_sample(sums *s, size_t i, double weight)
{
    const ff_table *t = s->t;
    for (size_t c = 0; c < t->n_channels; c++) add(s, c, weight, t->channels[c].scale * t->value[c * t->n + i]);
}

static double mean(const double *x, size_t n)
{
    double sum = 0;
    for (size_t c = 0; c < n; c++) sum += x[c];
    return sum / (double)n;
}

static void direction(double theta, double phi, double w[3])
{
    w[0] = sin(theta / degrees) * cos(phi / degrees);
    w[1] = sin(theta / degrees) * sin(phi / degrees);
    w[2] = cos(theta / degrees);
}

/* ---- means over azimuths --------------------------------------------------------------------- */

typedef struct ring {
    ff_reflected *r;
    double weight, *albedo, *raised; /* of all so far, [n_channels] */
} ring;

/* One azimuth more, with its weight. */
static void add_azimuth(ring *all, const sums *s, double phi_i, double weight)
{
    const size_t n = s->t->n_channels;
    const double one = mean(s->albedo, n);
    ff_reflected *r = all->r;
    if (r->azimuths++ == 0) {
        for (size_t c = 0; c < n; c++) all->albedo[c] = all->raised[c] = 0;
        *r = (ff_reflected){r->theta_i, phi_i, 1, 0, {one, one}};
    } else {
        r->phi_i = NAN;
    }
    r->range[0] = fmin(r->range[0], one);
    r->range[1] = fmax(r->range[1], one);
    r->covered += weight * s->covered / pi;
    all->weight += weight;
    for (size_t c = 0; c < n; c++) all->albedo[c] += weight * s->albedo[c], all->raised[c] += weight * s->raised[c];
}

static void end_ring(ring *all, size_t n_channels)
{
    if (!(all->weight > 0)) return;
    all->r->covered /= all->weight;
    for (size_t c = 0; c < n_channels; c++) all->albedo[c] /= all->weight, all->raised[c] /= all->weight;
}

/* ---- cells ----------------------------------------------------------------------------------- */

/* The sums, and what the side of the incidence that is added weighs. */
typedef struct sums_of_side {
    sums *s;
    double weight;
} sums_of_side;

static void add_cell(void *context, size_t i, double projected)
{
    const sums_of_side *side = context;
    if (!ff_table_is_measured(side->s->t, i)) return;
    side->s->covered += side->weight * projected;
    add_sample(side->s, i, side->weight * projected);
}

/* On a border between cells of incidence the mean over its sides. */
static void sum_cells(sums *s, double theta_i, double phi_i)
{
    const ff_cells *cells = s->t->cells;
    ff_cells_side side[FF_CELLS_SIDES];
    double wi[3];
    direction(theta_i, phi_i, wi);
    clear(s);
    const size_t n = ff_cells_sides(cells, wi, side);
    for (size_t k = 0; k < n; k++) cells->visit(cells, side[k].wi, add_cell, &(sums_of_side){s, side[k].weight});
}

static void ring_of_cells(sums *s, ring *all)
{
    double phi[FF_CELLS_AZIMUTHS];
    const size_t n = s->t->cells->azimuths(s->t->cells, all->r->theta_i, phi);
    for (size_t k = 0; k < n; k++) {
        sum_cells(s, all->r->theta_i, phi[k]);
        add_azimuth(all, s, phi[k], 1);
    }
}

/* ---- samples whose weights are those of the file's function ----------------------------------- */

static double theta_of(const ff_table *t, size_t i)
{
    return t->angle[0][i] * t->radians_per_unit * degrees;
}

static double phi_of(const ff_table *t, size_t i)
{
    return t->angle[1][i] * t->radians_per_unit * degrees;
}

/* Samples come incidence by incidence; azimuths do not matter to an isotropic file. only: NaN, or the azimuth that counts. */
static void ring_of_samples(sums *s, ring *all, double only)
{
    const ff_table *t = s->t;
    const double theta = all->r->theta_i;
    for (size_t i = 0, end; i < t->n; i = end) {
        int any = 0;
        for (end = i; end < t->n && t->angle[0][end] == t->angle[0][i] && t->angle[1][end] == t->angle[1][i];) end++;
        if (fabs(theta_of(t, i) - theta) > 1e-4) continue;
        if (isfinite(only) && fabs(remainder(phi_of(t, i) - only, 360)) > 1e-4) continue;
        clear(s);
        const double incidence = t->kept_incidence(t->kept, i);
        if (!(incidence > 0)) continue;
        for (size_t k = i; k < end; k++) {
            if (!ff_table_is_measured(t, k)) continue;
            add_sample(s, k, t->weight[k] * cos(t->angle[2][k] * t->radians_per_unit) / incidence);
            any = 1;
        }
        if (any) add_azimuth(all, s, phi_of(t, i), incidence);
    }
    if (t->isotropic && all->r->azimuths > 1) { /* the same incidence twice */
        all->r->azimuths = 1;
        all->r->phi_i = 0;
    }
}

/* ---- by interpolation ------------------------------------------------------------------------ */

typedef void node_visitor(void *context, const double wi[3], const double wo[3], double measure);

/* Nodes of the midpoint rule in polar angles about the mirror direction, denser near it. */
static void each_node(double theta_i, double phi_i, node_visitor *visit, void *context)
{
    enum { RADII = 96, TURNS = 48 };
    double wi[3];
    direction(theta_i, phi_i, wi);
    for (int a = 0; a < RADII; a++)
        for (int b = 0; b < TURNS; b++) {
            const double x = (a + 0.5) / RADII, radius = pi * x * x, measure = sin(radius) * 2 * pi * x / RADII * 2 * pi / TURNS;
            const double q[4] = {-pi / 2 - phi_i / degrees, theta_i / degrees, 2 * pi * (b + 0.5) / TURNS, radius};
            double angle[4];
            ff_axes_angles(FF_AXES_SPECULAR, 1, q, angle);
            const double wo[3] = {sin(angle[2]) * cos(angle[3]), sin(angle[2]) * sin(angle[3]), cos(angle[2])};
            if (wo[2] > FF_COS_MIN) visit(context, wi, wo, measure * wo[2]);
        }
}

typedef struct integral {
    sums *s;
    const ff_interpolant *p, *within; /* within: only where that has values; NULL: everywhere */
    double *value;                    /* [n_channels of each] */
    double all;
} integral;

static int is_inside(const ff_interpolant *p, const double wi[3], const double wo[3], double *value)
{
    const double *const w[6] = {&wi[0], &wi[1], &wi[2], &wo[0], &wo[1], &wo[2]};
    unsigned char found;
    ff_interpolant_eval(p, w, 1, value, &found);
    return found == FF_FOUND_SAMPLE || found == FF_FOUND_BETWEEN;
}

static void add_node(void *context, const double wi[3], const double wo[3], double measure)
{
    integral *n = context;
    n->all += measure;
    if ((n->within && !is_inside(n->within, wi, wo, n->value)) || !is_inside(n->p, wi, wo, n->value)) return;
    n->s->covered += measure;
    for (size_t c = 0; c < n->s->t->n_channels; c++) add(n->s, c, measure, n->value[c]);
}

/* s->t: the table of p. */
static void integrate(sums *s, const ff_interpolant *p, const ff_interpolant *within, double *value, double theta_i, double phi_i)
{
    integral n = {s, p, within, value, 0};
    clear(s);
    each_node(theta_i, phi_i, add_node, &n);
    s->covered *= pi / n.all;
}

/* ---- incidences ------------------------------------------------------------------------------ */

int ff_reflectance_is_own(const ff_table *t)
{
    return t->cells || t->kept_incidence;
}

static size_t all_thetas(const ff_table *t, double *theta)
{
    size_t n = 0;
    if (t->cells) {
        for (; n < MOST_THETAS && isfinite(theta[n] = t->cells->theta(t->cells, n));) n++;
        return n;
    }
    for (size_t i = 0; i < t->n && n < MOST_THETAS; i++) {
        size_t k = 0;
        if (!ff_table_is_measured(t, i) || (n && fabs(theta_of(t, i) - theta[n - 1]) < 1e-4)) continue;
        while (k < n && fabs(theta_of(t, i) - theta[k]) > 1e-4) k++;
        if (k == n) theta[n++] = theta_of(t, i);
    }
    return n;
}

size_t ff_reflectance_incidences(const ff_table *t, const ff_interpolant *p, size_t most, double *theta_i, double *phi_i)
{
    if (!ff_reflectance_is_own(t)) return ff_interpolant_incidences(p, most, theta_i, phi_i);
    double *theta = malloc((MOST_THETAS + 1) * sizeof *theta);
    if (!theta) return 0;
    const size_t all = all_thetas(t, theta), n = all < most ? all : most;
    for (size_t k = 0; k < n; k++) {
        theta_i[k] = theta[all <= most || most < 2 ? k : k * (all - 1) / (most - 1)];
        phi_i[k] = 0;
    }
    free(theta);
    return n;
}

/* Distinct azimuths of samples at a polar angle, in their order. */
static size_t azimuths_of_samples(const ff_table *t, double theta_i, double *phi)
{
    size_t n = 0;
    for (size_t i = 0; i < t->n && n < FF_CELLS_AZIMUTHS; i++) {
        if (fabs(theta_of(t, i) - theta_i) > 1e-4 || (n && fabs(phi_of(t, i) - phi[n - 1]) < 1e-4)) continue;
        phi[n++] = phi_of(t, i);
    }
    return n;
}

size_t ff_reflectance_azimuths(const ff_table *t, double theta_i, size_t most, double *phi_i)
{
    double phi[FF_CELLS_AZIMUTHS];
    const size_t all = t->cells ? t->cells->azimuths(t->cells, theta_i, phi) : azimuths_of_samples(t, theta_i, phi);
    const size_t n = t->isotropic && all ? 1 : all < most ? all : most;
    for (size_t k = 0; k < n; k++) phi_i[k] = phi[k * all / n];
    return n;
}

/* ---- one polar angle ------------------------------------------------------------------------- */

static void not_covered(ff_reflected *r, size_t n, double *albedo, double *raised)
{
    if (r->covered >= ff_reflectance_least_covered) return;
    for (size_t c = 0; c < n; c++) albedo[c] = raised[c] = NAN;
    r->range[0] = r->range[1] = NAN;
}

/* room: [3 n_channels] */
static void find(const ff_table *t, const ff_interpolant *p, ff_reflected *r, double *albedo, double *raised, double *room)
{
    sums s = {t, room, room + t->n_channels, 0};
    ring all = {r, 0, albedo, raised};
    const double phi_i = r->phi_i;
    double *value = room + 2 * t->n_channels;
    if (t->cells)
        ring_of_cells(&s, &all);
    else if (t->kept_incidence)
        ring_of_samples(&s, &all, NAN);
    if (r->azimuths == 0) {
        integrate(&s, p, NULL, value, r->theta_i, phi_i);
        add_azimuth(&all, &s, phi_i, 1);
    }
    end_ring(&all, t->n_channels);
    if (t->kept_incidence && !t->cells) { /* the weights do not say what was not measured */
        integrate(&s, p, NULL, value, r->theta_i, isfinite(r->phi_i) ? r->phi_i : phi_i);
        r->covered = s.covered / pi;
    }
    not_covered(r, t->n_channels, albedo, raised);
}

ff_status ff_reflectance_find(const ff_table *t, const ff_interpolant *p, double theta_i, double phi_i, ff_reflected *r,
                              double *albedo, double *raised, ff_error *err)
{
    double *room = malloc(3 * t->n_channels * sizeof *room);
    if (!room) return ff_error_set(err, FF_ERR_MEMORY, NULL, 0, -1, "no memory for %zu channels", t->n_channels);
    *r = (ff_reflected){theta_i, phi_i, 0, 0, {NAN, NAN}};
    find(t, p, r, albedo, raised, room);
    free(room);
    return FF_OK;
}

/* ---- one incidence --------------------------------------------------------------------------- */

ff_status ff_reflectance_mean(const ff_table *t, const ff_interpolant *p, const ff_interpolant *within, double theta_i,
                              double phi_i, double *out, ff_error *err)
{
    const size_t n = t->n_channels;
    const size_t widest = within && within->t->n_channels > n ? within->t->n_channels : n;
    double *room = malloc((4 * n + widest) * sizeof *room);
    if (!room) return ff_error_set(err, FF_ERR_MEMORY, NULL, 0, -1, "no memory for %zu channels", n);
    sums s = {t, room, room + n, 0};
    ff_reflected r = {.theta_i = theta_i};
    ring all = {&r, 0, room + 2 * n, room + 3 * n};
    if (t->cells)
        sum_cells(&s, theta_i, phi_i);
    else if (t->kept_incidence)
        ring_of_samples(&s, &all, t->isotropic ? NAN : phi_i);
    end_ring(&all, n);
    if (!t->cells && r.azimuths == 0) integrate(&s, p, within, room + 4 * n, theta_i, phi_i);
    *out = mean(r.azimuths ? all.albedo : s.albedo, n);
    free(room);
    return FF_OK;
}
