/* What the uncertainties of an instrument add to the errors of a fit: what they change in the score, J^T r, by H^-1. */
#include "fit/losses/internal_loss.h"
#include "fit/noise/internal_noise.h"
#include "fit/trust/internal_trust.h"
#include "models/tools/internal_aperture.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { MOST_PARAMETERS = 512, DIRECTIONS = 6 };
#define MOST_ANGLE 0.1

const char *ff_budget_source_name(int source)
{
    static const char *const name[FF_BUDGET_SOURCES] = {"scale",      "incidence_offset", "detector_offset",
                                                        "incidences", "readings",         "aperture"};
    return source >= 0 && source < FF_BUDGET_SOURCES ? name[source] : NULL;
}

void ff_budget_clear(ff_budget *b)
{
    for (int s = 0; s < FF_BUDGET_SOURCES; s++) free(b->by[s]);
    free(b->random);
    free(b->combined);
    memset(b, 0, sizeof *b);
}

/* ---- a model that is off ----------------------------------------------------------------------- */

/* w turned by `angle` from the normal towards the horizontal unit vector (x, y) (Rodrigues' formula). */
static void turn(double w[3], double x, double y, double angle)
{
    const double c = cos(angle), s = sin(angle), across = w[1] * x - w[0] * y, along = w[0] * x + w[1] * y, z = w[2];
    w[0] = along * x * c + z * x * s - across * y;
    w[1] = along * y * c + z * y * s + across * x;
    w[2] = z * c - along * s;
}

/* The azimuth of w as a unit vector; where it has none the opposite of that of `other`, or x. */
static void azimuth_of(const double w[3], const double other[3], double out[2])
{
    const double own = hypot(w[0], w[1]), others = hypot(other[0], other[1]);
    out[0] = own > 1e-12 ? w[0] / own : others > 1e-12 ? -other[0] / others : 1;
    out[1] = own > 1e-12 ? w[1] / own : others > 1e-12 ? -other[1] / others : 0;
}

/* The directions of a sample where a source is off by `by`. */
static void put_off(ff_budget_source source, double by, double wi[3], double wo[3])
{
    double i[2], o[2];
    azimuth_of(wi, wo, i);
    azimuth_of(wo, wi, o);
    if (source == FF_BUDGET_INCIDENCE_OFFSET || source == FF_BUDGET_INCIDENCES)
        turn(wi, i[0], i[1], by);
    else if (source == FF_BUDGET_DETECTOR_OFFSET)
        turn(wo, -i[0], -i[1], by);
    else if (source == FF_BUDGET_READINGS)
        turn(wo, o[0], o[1], by);
}

/* ---- the walk ---------------------------------------------------------------------------------- */

/* The model, its derivatives and cos(theta_i) in a block where a source is off. */
typedef struct off {
    double *f, *df; /* [C][FF_BLOCK], [C][columns][FF_BLOCK] */
    double x[FF_BLOCK];
} off;

typedef struct walk {
    const struct ff_problem *p;
    const ff_table *t;
    const ff_places *places;
    const ff_finished *f;
    const ff_aperture *aperture;
    double by[FF_BUDGET_SOURCES]; /* one standard uncertainty; 0: not wanted                            */
    size_t P, m, columns;
    off side[FF_BUDGET_SOURCES][2];     /* too little and too much                                            */
    double *values;                     /* what these point into                                              */
    double (*column)[FF_BLOCK];         /* [free columns] of what is put together here                        */
    double (*row)[FF_BLOCK];            /* [m]                                                                */
    double *gradient;                   /* [sources][P] of what is common                                     */
    double *of_setting;                 /* [directions][P]                                                    */
    double *of_reading;                 /* [FF_BLOCK][P] of the samples of this block                         */
    double *readings;                   /* [P][P] sums of products                                            */
    double plane[DIRECTIONS][FF_BLOCK]; /* of the block as they are                                           */
    ff_status status;
} walk;

static ff_status evaluate(walk *w, ff_budget_source source, double by, size_t n, off *out)
{
    double d[DIRECTIONS][FF_BLOCK];
    ff_aperture a = *w->aperture;
    for (size_t k = 0; k < n; k++) {
        double wi[3], wo[3];
        for (int q = 0; q < 3; q++) wi[q] = w->plane[q][k], wo[q] = w->plane[3 + q][k];
        put_off(source, by, wi, wo);
        for (int q = 0; q < 3; q++) d[q][k] = wi[q], d[3 + q][k] = wo[q];
        out->x[k] = wi[2];
    }
    if (source == FF_BUDGET_APERTURE) {
        a.half = fmax(a.half + by, 0);
        if (a.outline == FF_APERTURE_RECTANGLE) a.across = fmax(a.across + by, 0);
    }
    const ff_dirs dirs = {d[0], d[1], d[2], d[3], d[4], d[5]};
    return ff_aperture_eval(&a, w->f->plan.l.m, w->p->isa, w->p->n_channels, w->f->at.shape, w->f->at.channel, &dirs, n, out->f,
                            out->df, NULL, FF_BLOCK);
}

/* Of the samples of v, all channels. */
static ff_status evaluate_all(walk *w, const ff_visited *v)
{
    for (size_t k = 0; k < v->n; k++) {
        double *one[DIRECTIONS];
        for (int q = 0; q < DIRECTIONS; q++) one[q] = w->plane[q] + k;
        ff_table_directions(w->t, w->p->index[v->first + k], 1, one);
    }
    for (int s = FF_BUDGET_SCALE + 1; s < FF_BUDGET_SOURCES; s++)
        for (int side = 0; side < 2 && w->by[s] > 0; side++) {
            const ff_status status = evaluate(w, (ff_budget_source)s, side ? w->by[s] : -w->by[s], v->n, &w->side[s][side]);
            if (status) return status;
        }
    return FF_OK;
}

/* r dr/df of the samples of v where a source is off: residual and slope there, weighed as they are in v. */
static void products_there(const walk *w, const ff_visited *v, const off *there, double *out)
{
    const double *f = there->f + v->c * FF_BLOCK;
    double before[FF_BLOCK], slope[FF_BLOCK], model[FF_BLOCK], datum[FF_BLOCK], as_is[FF_BLOCK];
    for (size_t i = 0; i < v->n; i++) as_is[i] = w->plane[2][i];
    ff_loss_slopes(w->p->loss, v->n, v->f, as_is, before);
    ff_loss_slopes(w->p->loss, v->n, f, there->x, slope);
    ff_loss_targets(w->p->loss, v->n, f, there->x, model);
    ff_loss_targets(w->p->loss, v->n, v->y, there->x, datum);
    for (size_t i = 0; i < v->n; i++) {
        const double weight = before[i] != 0 ? v->j[i] / before[i] : 0;
        out[i] = weight != 0 ? weight * weight * (model[i] - datum[i]) * slope[i] : 0;
    }
}

/* Rows of what source s changes in r dr/dp of the samples of v by one standard uncertainty. */
static void find_rows(walk *w, const ff_visited *v, int s)
{
    const ff_wanted *free = &w->f->plan.l.free;
    const size_t shapes = w->f->plan.l.m->n_shape, n = (size_t)free->n_shape + free->n_channel;
    double product[2][FF_BLOCK];
    for (int side = 0; side < 2; side++) products_there(w, v, &w->side[s][side], product[side]);
    for (size_t k = 0; k < n; k++) {
        const int tied = k < free->n_shape && free->tied[k];
        const size_t at = k < free->n_shape ? free->shape[k] : shapes + free->channel[k - free->n_shape];
        memset(w->column[k], 0, sizeof w->column[k]);
        for (int side = 0; side < 2; side++) {
            const double *df = w->side[s][side].df + (v->c * w->columns + at) * FF_BLOCK, half = side ? 0.5 : -0.5;
            for (size_t i = 0; i < v->n; i++)
                w->column[k][i] += half * product[side][i] * (df[i] + (tied ? df[FF_BLOCK + i] : 0)); /* alpha_y is the next one */
        }
    }
    ff_visited changed = *v;
    changed.column = w->column;
    ff_noise_rows(&w->f->plan.l, &changed, w->row);
}

/* All values are higher by a share: r changes by j f times it, as good as j y at the optimum. */
static void scale_rows(walk *w, const ff_visited *v)
{
    ff_noise_rows(&w->f->plan.l, v, w->row);
    for (size_t k = 0; k < w->m; k++)
        for (size_t i = 0; i < v->n; i++) w->row[k][i] *= v->j[i] * v->f[i] * w->by[FF_BUDGET_SCALE];
}

/* Adds the rows of source s to one vector, or to that of each setting or reading. */
static void add_scores(walk *w, const ff_visited *v, int s)
{
    const size_t S = w->f->plan.l.n_shared, K = w->f->plan.l.n_own;
    for (size_t i = 0; i < v->n; i++) {
        double *to = s == FF_BUDGET_INCIDENCES ? w->of_setting + w->places->direction[v->first + i] * w->P
                     : s == FF_BUDGET_READINGS ? w->of_reading + i * w->P
                                               : w->gradient + (size_t)s * w->P;
        for (size_t k = 0; k < w->m; k++) to[k < S ? k : k + v->c * K] += w->row[k][i];
    }
}

/* vectors [n][P] */
static void add_products(size_t n, size_t P, const double *vectors, double *sums)
{
    for (size_t i = 0; i < n; i++)
        for (size_t a = 0; a < P; a++)
            for (size_t b = 0; b < P; b++) sums[a * P + b] += vectors[i * P + a] * vectors[i * P + b];
}

static void visit(void *context, const ff_visited *v)
{
    walk *w = context;
    if (w->status) return;
    if (v->c == 0) {
        w->status = evaluate_all(w, v);
        if (w->of_reading) memset(w->of_reading, 0, FF_BLOCK * w->P * sizeof *w->of_reading);
    }
    for (int s = 0; s < FF_BUDGET_SOURCES && !w->status; s++) {
        if (!(w->by[s] > 0)) continue;
        if (s == FF_BUDGET_SCALE)
            scale_rows(w, v);
        else
            find_rows(w, v, s);
        add_scores(w, v, s);
    }
    if (w->of_reading && v->c + 1 == w->p->n_channels) add_products(v->n, w->P, w->of_reading, w->readings);
}

/* ---- the table --------------------------------------------------------------------------------- */

/* |H^-1 gradient|, by column. */
static ff_status put_common(const walk *w, const ff_information *info, const double *gradient, const size_t *column, double *moved,
                            double *out)
{
    const ff_status status = ff_information_solve(info, gradient, moved);
    for (size_t k = 0; k < w->P && !status; k++)
        if (column[k] < w->P) out[column[k]] = fabs(moved[k]);
    return status;
}

/* Roots of the diagonal of H^-1 M H^-1 with M [P][P]. */
static ff_status put_scattered(const walk *w, const ff_information *info, const double *M, const size_t *column, double *moved,
                               double *out)
{
    double *unit = calloc(w->P + 1, sizeof *unit);
    ff_status status = unit ? FF_OK : FF_ERR_MEMORY;
    for (size_t k = 0; k < w->P && !status; k++) {
        if (column[k] >= w->P) continue;
        unit[k] = 1;
        status = ff_information_solve(info, unit, moved);
        unit[k] = 0;
        double sum = 0;
        for (size_t a = 0; a < w->P && !status; a++)
            for (size_t b = 0; b < w->P; b++) sum += moved[a] * M[a * w->P + b] * moved[b];
        out[column[k]] = sqrt(fmax(sum, 0));
    }
    free(unit);
    return status;
}

/* column [P]: of each parameter, P where it has none. */
static ff_status fill(const walk *w, const ff_information *info, const ff_fit_result *fit, const size_t *column, double *moved,
                      ff_budget *out)
{
    ff_status status = FF_OK;
    double *of_settings = w->of_setting ? calloc(w->P * w->P + 1, sizeof *of_settings) : NULL;
    if (w->of_setting && !of_settings) return FF_ERR_MEMORY;
    if (w->of_setting) add_products(w->places->n_directions, w->P, w->of_setting, of_settings);
    for (int s = 0; s < FF_BUDGET_SOURCES && !status; s++) {
        if (!(w->by[s] > 0)) continue;
        out->by[s] = calloc(out->n_columns + 1, sizeof *out->by[s]);
        if (!out->by[s])
            status = FF_ERR_MEMORY;
        else if (s == FF_BUDGET_INCIDENCES || s == FF_BUDGET_READINGS)
            status = put_scattered(w, info, s == FF_BUDGET_READINGS ? w->readings : of_settings, column, moved, out->by[s]);
        else
            status = put_common(w, info, w->gradient + (size_t)s * w->P, column, moved, out->by[s]);
    }
    free(of_settings);
    for (size_t k = 0; k < w->P && !status; k++) {
        if (column[k] >= w->P) continue;
        const double random = ff_result_value(&w->f->plan.l, (ff_fit_result *)(uintptr_t)fit, k)->std_error;
        double sum = random * random;
        out->random[column[k]] = random;
        for (int s = 0; s < FF_BUDGET_SOURCES; s++)
            if (out->by[s] && s != FF_BUDGET_READINGS) sum += out->by[s][column[k]] * out->by[s][column[k]];
        out->combined[column[k]] = sqrt(sum);
    }
    return status;
}

static ff_status make_room(walk *w)
{
    const size_t C = w->p->n_channels, f = C * FF_BLOCK, each = f * (1 + w->columns);
    const ff_wanted *free = &w->f->plan.l.free;
    w->values = calloc(FF_BUDGET_SOURCES * 2 * each, sizeof *w->values);
    w->column = calloc((size_t)free->n_shape + free->n_channel + 1, sizeof *w->column);
    w->row = calloc(w->m + 1, sizeof *w->row);
    w->gradient = calloc(FF_BUDGET_SOURCES * w->P + 1, sizeof *w->gradient);
    if (w->by[FF_BUDGET_INCIDENCES] > 0) w->of_setting = calloc(w->places->n_directions * w->P + 1, sizeof *w->of_setting);
    if (w->by[FF_BUDGET_READINGS] > 0) {
        w->of_reading = calloc(FF_BLOCK * w->P + 1, sizeof *w->of_reading);
        w->readings = calloc(w->P * w->P + 1, sizeof *w->readings);
    }
    for (size_t k = 0; w->values && k < 2 * FF_BUDGET_SOURCES; k++) {
        w->side[k / 2][k % 2].f = w->values + k * each;
        w->side[k / 2][k % 2].df = w->values + k * each + f;
    }
    return w->values && w->column && w->row && w->gradient && (w->of_setting || !(w->by[FF_BUDGET_INCIDENCES] > 0)) &&
                   ((w->of_reading && w->readings) || !(w->by[FF_BUDGET_READINGS] > 0))
               ? FF_OK
               : FF_ERR_MEMORY;
}

static void leave_room(walk *w)
{
    free(w->values);
    free(w->column);
    free(w->row);
    free(w->gradient);
    free(w->of_setting);
    free(w->of_reading);
    free(w->readings);
}

/* At the point of f, whose sums are made for it. */
static ff_status walk_through(walk *w, ff_finished *f, const ff_fit_result *fit, ff_budget *out)
{
    ff_information *info = NULL;
    size_t *column = malloc((w->P + 1) * sizeof *column);
    double *moved = malloc((w->P + 1) * sizeof *moved);
    ff_status status = column && moved ? make_room(w) : FF_ERR_MEMORY;
    if (!status) status = ff_point_pass(&f->plan, &f->at);
    if (!status) status = ff_information_new(&f->plan, &f->at.normal, f->at.at_bound, &info);
    if (!status) status = ff_point_visit(&f->plan, &f->at, visit, w);
    if (!status) status = w->status;
    for (size_t k = 0; k < w->P && !status; k++) {
        const int number = ff_result_value(&f->plan.l, (ff_fit_result *)(uintptr_t)fit, k)->column;
        column[k] = number < 0 ? w->P : (size_t)number;
    }
    if (!status) status = fill(w, info, fit, column, moved, out);
    leave_room(w);
    free(info);
    free(column);
    free(moved);
    return status;
}

/* ---- for others -------------------------------------------------------------------------------- */

static ff_status check(const ff_budget_options *u, const ff_fit_options *o, size_t P, ff_error *err)
{
    const double angle[] = {u->offset, u->angle, u->aperture};
    if (!(u->scale >= 0 && u->scale <= 1))
        return ff_error_set(err, FF_ERR_RANGE, NULL, 0, -1, "the uncertainty of the scale must lie in [0, 1], found %g", u->scale);
    for (size_t k = 0; k < sizeof angle / sizeof *angle; k++)
        if (!(angle[k] >= 0 && angle[k] <= MOST_ANGLE))
            return ff_error_set(err, FF_ERR_RANGE, NULL, 0, -1, "the uncertainty of an angle must lie in [0, %g] degrees, found %g",
                                MOST_ANGLE / FF_DEGREES, angle[k] / FF_DEGREES);
    if (u->aperture > 0 && !(o->aperture && ff_aperture_extended(o->aperture) && o->aperture->half > 0))
        return ff_error_set(err, FF_ERR_UNSUPPORTED, NULL, 0, -1,
                            "the values are of single directions: there is no aperture that could be uncertain");
    if (o->robust != FF_ROBUST_NONE)
        return ff_error_set(err, FF_ERR_UNSUPPORTED, NULL, 0, -1,
                            "what an instrument adds is found for sums of squares, not for a robust loss");
    if (u->angle > 0 && P > MOST_PARAMETERS)
        return ff_error_set(err, FF_ERR_UNSUPPORTED, NULL, 0, -1,
                            "what single angles add is found for up to %d parameters: this fit has %zu", MOST_PARAMETERS, P);
    return FF_OK;
}

ff_status ff_trust_budget_into(const ff_problem *p, const ff_table *t, const ff_places *places, const ff_fit_options *o,
                               const ff_fit_result *fit, const ff_budget_options *u, ff_budget *out, ff_error *err)
{
    static const ff_aperture point = {0};
    ff_finished f;
    ff_budget b = {.n_columns = fit->n_columns};
    ff_status status = ff_finished_open(p, o, fit, &f, err);
    if (status) return status;
    walk w = {.p = p,
              .t = t,
              .places = places,
              .f = &f,
              .aperture = o->aperture ? o->aperture : &point,
              .by = {u->scale, u->offset, u->offset, u->angle, u->angle, u->aperture},
              .P = f.plan.l.P,
              .m = f.plan.l.n_shared + f.plan.l.n_own,
              .columns = (size_t)f.plan.l.m->n_shape + f.plan.l.m->n_channel};
    status = check(u, o, w.P, err);
    if (!status) b.random = calloc(b.n_columns + 1, sizeof *b.random);
    if (!status) b.combined = calloc(b.n_columns + 1, sizeof *b.combined);
    if (!status) status = b.random && b.combined ? walk_through(&w, &f, fit, &b) : FF_ERR_MEMORY;
    if (status == FF_ERR_MEMORY) ff_error_set(err, status, NULL, 0, -1, "out of memory");
    ff_finished_close(&f);
    if (status)
        ff_budget_clear(&b);
    else
        *out = b;
    return status;
}
