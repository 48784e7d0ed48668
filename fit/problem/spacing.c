/* How far apart exits were measured near the mirror direction: a lobe that is hardly wider is not resolved. */
#include "base/internal_order.h"
#include "internal_problem.h"
#include <math.h>
#include <stdlib.h>

enum { INCIDENCES = 16, MOST = 250000 }; /* of more samples the steps are not looked for: they are fine, or none */
static const double same = 1e-7;         /* as the chord between unit vectors */

/* One of the incident directions that are looked at. */
typedef struct incidence {
    double wi[3], nearest[3]; /* the exit that is nearest to the mirror direction */
    double mirror, neighbour; /* squared chords: from it to that, and to its next neighbour */
} incidence;

static double chord2(const double a[3], const double b[3])
{
    return (a[0] - b[0]) * (a[0] - b[0]) + (a[1] - b[1]) * (a[1] - b[1]) + (a[2] - b[2]) * (a[2] - b[2]);
}

static void look_at_mirror(incidence *at, const double wo[3])
{
    const double mirror[3] = {-at->wi[0], -at->wi[1], at->wi[2]}, d2 = chord2(wo, mirror);
    if (d2 >= at->mirror) return;
    at->mirror = d2;
    for (int k = 0; k < 3; k++) at->nearest[k] = wo[k];
}

static void look_at_neighbour(incidence *at, const double wo[3])
{
    const double d2 = chord2(wo, at->nearest);
    if (d2 > same * same) at->neighbour = fmin(at->neighbour, d2);
}

static void visit(const ff_table *t, const uint32_t *index, size_t n, incidence *at, size_t n_at,
                  void (*look)(incidence *, const double[3]))
{
    double w[6], *const planes[6] = {w, w + 1, w + 2, w + 3, w + 4, w + 5};
    for (size_t i = 0; i < n; i++) {
        ff_table_directions(t, index[i], 1, planes);
        for (size_t k = 0; k < n_at; k++)
            if (chord2(w, at[k].wi) < same * same) look(&at[k], w + 3);
    }
}

/* Incident directions spread over the samples, each once. */
static size_t choose(const ff_table *t, const uint32_t *index, size_t n, incidence *at)
{
    double w[6], *const planes[6] = {w, w + 1, w + 2, w + 3, w + 4, w + 5};
    size_t chosen = 0;
    for (size_t k = 0; k < INCIDENCES && n > 0; k++) {
        size_t known = 0;
        ff_table_directions(t, index[k * n / INCIDENCES], 1, planes);
        while (known < chosen && chord2(w, at[known].wi) >= same * same) known++;
        if (known == chosen) at[chosen++] = (incidence){{w[0], w[1], w[2]}, {0, 0, 0}, INFINITY, INFINITY};
    }
    return chosen;
}

double ff_problem_spacing_of(const ff_table *t, const uint32_t *index, size_t n)
{
    incidence at[INCIDENCES];
    double spacing[INCIDENCES];
    size_t found = 0;
    if (t->grid || n > MOST) return NAN;
    const size_t n_at = choose(t, index, n, at);
    visit(t, index, n, at, n_at, look_at_mirror);
    visit(t, index, n, at, n_at, look_at_neighbour);
    for (size_t k = 0; k < n_at; k++)
        if (isfinite(at[k].neighbour)) spacing[found++] = 2 * asin(fmin(0.5 * sqrt(at[k].neighbour), 1));
    qsort(spacing, found, sizeof *spacing, ff_ascending);
    return 2 * found > n_at ? spacing[found / 2] : NAN;
}
