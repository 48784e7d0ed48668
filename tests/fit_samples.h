/** @file fit_samples.h  Measurements made in memory for the tests of fit/: directions and noise from a generator of its own, values
 *  from ff_model_eval. C and C++. */
#ifndef FIT_SAMPLES_H
#define FIT_SAMPLES_H
#ifndef _GNU_SOURCE
#define _GNU_SOURCE /* strtok_r, nanosleep: include this file first */
#endif
#include "fit/interface/fit_struct.h"
#include "models/tools/profile_struct.h"
#include "ff_test.h"

#define FIT_DEGREE (3.14159265358979323846 / 180)

/* ---- numbers --------------------------------------------------------------------------------- */

/** The next number of a stream. */
static inline uint64_t fit_random(uint64_t *state)
{
    return ff_test_next(state);
}

/** In (0, 1). */
static inline double fit_uniform(uint64_t *state)
{
    return ((double)(fit_random(state) >> 12) + 0.5) / 4503599627370496.0;
}

/** Standard normal, by Box and Muller. */
static inline double fit_normal(uint64_t *state)
{
    const double r = sqrt(-2 * log(fit_uniform(state)));
    return r * cos(2 * 180 * FIT_DEGREE * fit_uniform(state));
}

/* ---- what is measured ------------------------------------------------------------------------ */

enum { FIT_CHANNELS = 32 };

/** A surface: a model and its parameters. */
typedef struct fit_surface {
    ff_model model;
    size_t n_channels;
    double shape[FF_MAX_SHAPE], channel[FIT_CHANNELS * FF_MAX_CHANNEL_PARAMS];
} fit_surface;

/** How it is measured. What is left 0: no noise, uniform directions, no sigma, scattered samples. */
typedef struct fit_sampling {
    size_t n;
    double max_theta;    /**< degrees; both directions are uniform in solid angle up to it                        */
    double glossy;       /**< fraction of samples whose half vector is near the normal: slope log-uniform in 0.002 .. 1 */
    double noise;        /**< standard deviation relative to the value                                            */
    int sigma;           /**< 1: the table carries the standard deviations                                        */
    uint64_t seed;       /**< of this measurement; the seed of the run is added to it                              */
    const ff_grid *grid; /**< instead of random directions; n is the grid's                                       */
} fit_sampling;

/** The profile that `tabulated` lobes of the tests have: Student's t of gamma = 3 at 40 points. Static storage. */
static inline const ff_profile_table *fit_profile(void)
{
    enum { POINTS = 40 };
    static ff_profile_table table;
    static int made;
    double q2[POINTS], p[POINTS];
    if (made) return &table;
    for (int i = 0; i < POINTS; i++) {
        q2[i] = i == 0 ? 0 : 1e-3 * pow(1e8, (i - 1) / (POINTS - 2.0));
        p[i] = pow(1 + q2[i] / 2, -3);
    }
    if (ff_profile_make(FF_PROFILE_P, POINTS, q2, p, &table, NULL, NULL)) exit(1);
    made = 1;
    return &table;
}

/** Parses an expression and a list of assignments separated by spaces; a word that is wrong ends the program. */
static inline fit_surface fit_surface_make(const char *expression, size_t n_channels, const char *assignments)
{
    fit_surface s;
    ff_error err;
    char words[512], *save = NULL;
    memset(&s, 0, sizeof s);
    memset(&err, 0, sizeof err);
    s.n_channels = n_channels;
    snprintf(words, sizeof words, "%s", assignments);
    ff_status status = n_channels <= FIT_CHANNELS ? ff_model_parse(expression, &s.model, &err) : FF_ERR_RANGE;
    if (!status) ff_model_set_table(&s.model, fit_profile());
    if (!status) ff_model_defaults(&s.model, n_channels, s.shape, s.channel);
    for (char *word = strtok_r(words, " ", &save); word && !status; word = strtok_r(NULL, " ", &save))
        status = ff_model_set(&s.model, n_channels, word, s.shape, s.channel, &err);
    if (status) {
        printf("the test itself is wrong: %s, %s: %s\n", expression, assignments, err.message);
        exit(1);
    }
    return s;
}

/** Polar angle of a direction that is uniform in solid angle up to cos_max. */
static inline double fit_theta(uint64_t *state, double cos_max)
{
    return acos(1 - fit_uniform(state) * (1 - cos_max));
}

/** Replaces wo (theta, phi in a[2], a[3]) by the mirror image of wi about a half vector near the normal, unless that is beyond
 * cos_max. */
static inline void fit_mirror(uint64_t *state, double cos_max, double a[4])
{
    const double slope = 0.002 * pow(500, fit_uniform(state)), phi = 360 * FIT_DEGREE * fit_uniform(state),
                 hz = 1 / sqrt(1 + slope * slope);
    const double hx = slope * hz * cos(phi), hy = slope * hz * sin(phi);
    const double ix = sin(a[0]) * cos(a[1]), iy = sin(a[0]) * sin(a[1]), iz = cos(a[0]), ih = ix * hx + iy * hy + iz * hz;
    const double ox = 2 * ih * hx - ix, oy = 2 * ih * hy - iy, oz = 2 * ih * hz - iz;
    if (ih <= 0 || oz < cos_max) return;
    a[2] = acos(fmin(oz, 1));
    a[3] = atan2(oy, ox);
}

static inline void fit_directions(const fit_sampling *how, ff_table *t, uint64_t *state)
{
    const double cos_max = cos(how->max_theta * FIT_DEGREE);
    t->radians_per_unit = 1;
    for (size_t i = 0; i < t->n; i++) {
        double a[4];
        for (int k = 0; k < 4; k++) a[k] = k % 2 ? 360 * FIT_DEGREE * fit_uniform(state) : fit_theta(state, cos_max);
        if (fit_uniform(state) < how->glossy) fit_mirror(state, cos_max, a);
        for (int k = 0; k < 4; k++) t->angle[k][i] = a[k];
    }
}

/** Model values of samples into the table's planes; samples below the horizon become invalid. */
static inline void fit_evaluate(const fit_surface *s, ff_table *t)
{
    double *planes[6], *w = (double *)malloc(6 * t->n * sizeof *w);
    if (!w) exit(1);
    for (size_t k = 0; k < 6; k++) planes[k] = w + k * t->n;
    ff_table_directions(t, 0, t->n, planes);
    ff_dirs dirs;
    dirs.wix = planes[0], dirs.wiy = planes[1], dirs.wiz = planes[2];
    dirs.wox = planes[3], dirs.woy = planes[4], dirs.woz = planes[5];
    if (ff_model_eval(&s->model, FF_ISA_BEST, s->n_channels, s->shape, s->channel, &dirs, t->n, t->value, NULL, t->n)) {
        printf("the test itself is wrong: the surface cannot be evaluated\n");
        exit(1);
    }
    for (size_t i = 0; i < t->n; i++) {
        t->valid[i] = dirs.wiz[i] > FF_COS_MIN && dirs.woz[i] > FF_COS_MIN;
        t->n_invalid += !t->valid[i];
    }
    free(w);
}

/** Measures the surface. Release the table with ff_table_clear. */
static inline ff_table fit_measure(const fit_surface *s, const fit_sampling *how)
{
    ff_table t;
    uint64_t state = ff_test_seeded(how->seed * UINT64_C(0xd1342543de82ef95) + 1);
    if (ff_table_init(how->grid ? how->grid->n : how->n, s->n_channels, how->grid, how->sigma, 0, &t, NULL)) {
        printf("out of memory for the test's samples\n");
        exit(1);
    }
    if (!how->grid) fit_directions(how, &t, &state);
    t.isotropic = how->grid ? how->grid->isotropic : 0;
    fit_evaluate(s, &t);
    for (size_t k = 0; k < t.n * t.n_channels; k++) {
        if (how->sigma) t.sigma[k] = how->noise * t.value[k];
        if (how->noise > 0) t.value[k] *= 1 + how->noise * fit_normal(&state);
    }
    return t;
}

/* ---- fits ------------------------------------------------------------------------------------ */

static inline ff_fit_options fit_options(void)
{
    ff_fit_options o;
    ff_fit_options_init(&o);
    o.threads = 2;
    return o;
}

/** A problem of its own and one fit. selection may be NULL. */
static inline ff_status fit_table(const ff_table *t, const ff_model *m, const ff_fit_options *o, ff_fit_result *r,
                                  ff_selection *selection, ff_error *err)
{
    ff_problem *p = NULL;
    const ff_status status = ff_problem_make(t, m, 1, o, &p, err);
    if (status) return status;
    if (selection) ff_problem_selection(p, selection);
    const ff_status end = ff_problem_fit_into(p, m, o, r, err);
    ff_problem_free(p);
    return end;
}

/** Number of fitted parameters of a result, and one of them: name into out [64], value, truth. NULL when it is held or tied. */
static inline size_t fit_parameter_count(const ff_fit_result *r)
{
    return r->model.n_shape + r->n_channels * r->model.n_channel;
}

static inline const ff_fit_value *fit_parameter(const ff_fit_result *r, size_t k, const fit_surface *s, double *truth, char *name)
{
    const ff_model *m = &r->model;
    const ff_fit_value *v;
    if (k < m->n_shape) {
        v = &r->shape_value[k];
        *truth = s ? s->shape[k] : NAN;
        snprintf(name, 64, "%s", m->shape[k].name);
    } else {
        const size_t i = k - m->n_shape;
        v = &r->channel_value[i];
        *truth = s ? s->channel[i] : NAN;
        snprintf(name, 64, "%s[%d]", m->channel[i % m->n_channel].name, (int)(i / m->n_channel));
    }
    return v->held || v->tied ? NULL : v;
}

/* How often a measurement is repeated where errors are judged by their scatter: as often, or $FACETFIT_REPEATS, of which a slow
 * build may have fewer. */
static inline int fit_repeats(int ordinary, int thorough)
{
    const char *set = getenv("FACETFIT_REPEATS");
    const int n = set ? atoi(set) : 0;
    return n > 0 ? n : ff_test_is_thorough() ? thorough : ordinary;
}

#endif
