/* How much light a table has lost in being made of another. */
#include "internal_reflectance.h"
#include <math.h>

enum { THETAS = 8, AZIMUTHS = 4, ALL_AZIMUTHS = 48 };

typedef struct comparison {
    const ff_table *t, *made, *own; /* own: of the two, whose directions are looked at */
    int has_own;                    /* it has directions of its own                    */
    const ff_interpolant *p, *q;    /* of t, of made */
    double before, after;           /* sums          */
    ff_energy *out;
} comparison;

/* 1 where made has one value for all azimuths of incidence. */
static int is_turned(const ff_table *made)
{
    return made->isotropic || (made->grid && made->grid->isotropic);
}

/* Adds one polar angle: the mean over a few of the azimuths, where there are several; over all of cells where made has one. */
static ff_status compare_theta(comparison *c, double theta_i, double phi_i, ff_error *err)
{
    double phi[ALL_AZIMUTHS] = {phi_i}, before = 0, after = 0;
    const int turned = c->t->cells && is_turned(c->made);
    const size_t found = turned       ? ff_reflectance_azimuths(c->t, theta_i, ALL_AZIMUTHS, phi)
                         : c->has_own ? ff_reflectance_azimuths(c->own, theta_i, AZIMUTHS, phi)
                                      : 0;
    const size_t n = found ? found : 1;
    for (size_t k = 0; k < n; k++) {
        double a, b = 0;
        ff_status status = ff_reflectance_mean(c->t, c->p, NULL, theta_i, phi[k], &a, err);
        if (status == FF_OK && !(turned && k)) status = ff_reflectance_mean(c->made, c->q, c->p, theta_i, phi[k], &b, err);
        if (status != FF_OK) return status;
        before += a / (double)n;
        after += turned ? b : b / (double)n;
    }
    if (!(before > 0)) return FF_OK;
    if (after == 0) {
        c->out->missed++;
        return FF_OK;
    }
    const double lost = 1 - after / before;
    if (c->out->incidences++ == 0 || fabs(lost) > fabs(c->out->most)) c->out->most = lost, c->out->at = theta_i;
    c->before += before;
    c->after += after;
    return FF_OK;
}

ff_status ff_energy_compare(const ff_table *t, const ff_interpolant *p, const ff_table *made, ff_energy *out, ff_error *err)
{
    ff_interpolant *q = NULL;
    double theta[THETAS], phi[THETAS];
    const ff_table *own = ff_reflectance_is_own(made) ? made : t;
    *out = (ff_energy){0, 0, NAN, NAN, NAN};
    ff_status status = ff_interpolant_new(made, 0, &q, err);
    if (status == FF_ERR_DATA) return FF_OK; /* nothing in it, which others say */
    comparison c = {t, made, own, ff_reflectance_is_own(own), p, q, 0, 0, out};
    const size_t n = status ? 0 : ff_reflectance_incidences(own, p, THETAS, theta, phi);
    for (size_t k = 0; k < n && status == FF_OK; k++) status = compare_theta(&c, theta[k], phi[k], err);
    if (status == FF_OK && c.before > 0) out->lost = 1 - c.after / c.before;
    ff_interpolant_free(q);
    return status;
}
