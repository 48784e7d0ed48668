/* What the samples of a table say of themselves. */
#include "survey_struct.h"
#include "ff_interpolate.h"
#include "data_formats/interpolation/internal_reflectance.h"
#include "models/model_struct.h"
#include "base/internal_order.h"
#include "data_formats/table/internal_table.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

static const double degrees = 180 / 3.14159265358979323846;

enum { BLOCK = 512, PAIRS = 2000 };

typedef struct pair {
    double wi[3], wo[3];
} pair;

static pair pair_at(const ff_table *t, size_t i)
{
    pair p;
    double *const planes[6] = {p.wi, p.wi + 1, p.wi + 2, p.wo, p.wo + 1, p.wo + 2};
    ff_table_directions(t, i, 1, planes);
    return p;
}

static double polar(const double w[3])
{
    return degrees * atan2(hypot(w[0], w[1]), w[2]);
}

static int usable(const ff_table *t, size_t i, const pair *p)
{
    return t->valid[i] && p->wi[2] > FF_COS_MIN && p->wo[2] > FF_COS_MIN;
}

/* ---- coverage -------------------------------------------------------------------------------- */

static void widen(double range[2], double x)
{
    if (!(range[0] <= x)) range[0] = x;
    if (!(range[1] >= x)) range[1] = x;
}

static int band(double x, double width, int n)
{
    const int k = (int)(x / width + 1e-9); /* 60 degrees are not 59.99 */
    return k < 0 ? 0 : k < n ? k : n - 1;
}

static void cover(ff_survey *s, unsigned short seen[FF_SURVEY_ROWS][FF_SURVEY_COLUMNS], const pair *p)
{
    static const double within[4] = {1, 2, 5, 10};
    const double theta_i = polar(p->wi), theta_o = polar(p->wo);
    const double across = p->wi[0] * p->wo[1] - p->wi[1] * p->wo[0], along = p->wi[0] * p->wo[0] + p->wi[1] * p->wo[1];
    const double apart = across == 0 && along == 0 ? 0 : degrees * fabs(atan2(across, along));
    const double h[3] = {p->wi[0] + p->wo[0], p->wi[1] + p->wo[1], p->wi[2] + p->wo[2]}, theta_h = polar(h);
    widen(s->theta_i, theta_i);
    widen(s->theta_o, theta_o);
    seen[band(theta_i, 10, FF_SURVEY_ROWS)][band(theta_o, 5, FF_SURVEY_COLUMNS)] |=
        (unsigned short)(1u << band(apart, 15, FF_SURVEY_AZIMUTHS));
    for (int k = 0; k < 4; k++) s->near_mirror[k] += theta_h <= within[k] + 1e-9;
}

static void survey_coverage(const ff_table *t, ff_survey *s)
{
    double plane[6][BLOCK], *const planes[6] = {plane[0], plane[1], plane[2], plane[3], plane[4], plane[5]};
    unsigned short seen[FF_SURVEY_ROWS][FF_SURVEY_COLUMNS] = {{0}};
    for (size_t first = 0; first < t->n; first += BLOCK) {
        const size_t n = t->n - first < BLOCK ? t->n - first : BLOCK;
        ff_table_directions(t, first, n, planes);
        for (size_t k = 0; k < n; k++) {
            const pair p = {{plane[0][k], plane[1][k], plane[2][k]}, {plane[3][k], plane[4][k], plane[5][k]}};
            if (usable(t, first + k, &p))
                cover(s, seen, &p);
            else
                s->below_horizon += t->valid[first + k] != 0;
        }
    }
    for (int i = 0; i < FF_SURVEY_ROWS; i++)
        for (int o = 0; o < FF_SURVEY_COLUMNS; o++)
            for (unsigned short bits = seen[i][o]; bits; bits &= (unsigned short)(bits - 1)) s->azimuths[i][o]++;
}

/* ---- symmetries ------------------------------------------------------------------------------ */

/* Deviations of one kind. */
typedef struct deviations {
    size_t n;
    double *at; /* [PAIRS] */
} deviations;

static double median(deviations *d)
{
    if (d->n == 0) return NAN;
    qsort(d->at, d->n, sizeof *d->at, ff_ascending);
    return (d->at[(d->n - 1) / 2] + d->at[d->n / 2]) / 2;
}

typedef struct surveyor {
    const ff_table *t;
    const ff_interpolant *p; /* by regression */
    double *value;           /* [n_channels]  */
    size_t most;             /* pairs, PAIRS at the most */
    deviations pairs, with_cosine, without_cosine, alone;
} surveyor;

static double channel_mean(const ff_table *t, const double *value)
{
    double sum = 0;
    for (size_t c = 0; c < t->n_channels; c++) sum += value[c];
    return sum / (double)t->n_channels;
}

static double sample_mean(const ff_table *t, size_t i)
{
    double sum = 0;
    for (size_t c = 0; c < t->n_channels; c++) sum += t->channels[c].scale * t->value[c * t->n + i];
    return sum / (double)t->n_channels;
}

/* The channel mean for a pair, NaN where the data do not reach it. */
static double mean_at(surveyor *s, const double wi[3], const double wo[3])
{
    unsigned char found;
    const double *const w[6] = {&wi[0], &wi[1], &wi[2], &wo[0], &wo[1], &wo[2]};
    ff_interpolant_eval(s->p, w, 1, s->value, &found);
    return found == FF_FOUND_SAMPLE || found == FF_FOUND_BETWEEN ? channel_mean(s->t, s->value) : NAN;
}

static void record(deviations *d, double a, double b)
{
    if (d->n < PAIRS && a > 0 && b > 0) d->at[d->n++] = fabs(log(a / b));
}

static void record_alone(surveyor *s, size_t i, double f)
{
    const ff_found found = ff_interpolant_without(s->p, i, s->value);
    if (found == FF_FOUND_SAMPLE || found == FF_FOUND_BETWEEN) record(&s->alone, f, channel_mean(s->t, s->value));
}

static void start(surveyor *s)
{
    s->pairs.n = s->with_cosine.n = s->without_cosine.n = s->alone.n = 0;
}

/* Every so many samples are enough. */
static size_t stride_of(const surveyor *s)
{
    return s->t->n / (4 * s->most) + 1;
}

/* The exchanged pair is best compared where its incidence is one that was measured: then only the exits are interpolated. */
static void compare_exchanged(surveyor *s, int only_measured)
{
    const size_t stride = only_measured && s->most == PAIRS ? 1 : stride_of(s);
    start(s);
    for (size_t i = 0; i < s->t->n && s->pairs.n < s->most; i += stride) {
        const pair p = pair_at(s->t, i);
        if (!usable(s->t, i, &p)) continue;
        const double theta_i = polar(p.wi), theta_o = polar(p.wo), f = sample_mean(s->t, i);
        if (fabs(theta_i - theta_o) < 10 || fmax(theta_i, theta_o) > 80 || !(f > 0)) continue;
        if (only_measured && !ff_interpolant_is_incidence(s->p, p.wo, 0.05)) continue;
        const double g = mean_at(s, p.wo, p.wi);
        if (!(g > 0)) continue;
        record(&s->pairs, f, g);
        record(&s->with_cosine, f / p.wo[2], g / p.wi[2]);
        record(&s->without_cosine, f * p.wo[2], g * p.wi[2]);
        record_alone(s, i, f);
    }
}

static void survey_reciprocity(surveyor *s, ff_survey *out)
{
    enum { ENOUGH = 20 };
    compare_exchanged(s, 1);
    if (s->pairs.n < ENOUGH) compare_exchanged(s, 0);
    out->reciprocity = (ff_symmetry){0, s->pairs.n, median(&s->pairs), median(&s->alone)};
    out->with_cosine = median(&s->with_cosine);
    out->without_cosine = median(&s->without_cosine);
}

static void turn(double angle, const double w[3], double out[3])
{
    out[0] = cos(angle) * w[0] - sin(angle) * w[1];
    out[1] = sin(angle) * w[0] + cos(angle) * w[1];
    out[2] = w[2];
}

static void survey_isotropy(surveyor *s, ff_survey *out)
{
    static const double angle[3] = {0.6457718232379019, 1.5707963267948966, 2.4958208303518914}; /* 37, 90, 143 degrees */
    start(s);
    for (size_t i = 0, k = 0; i < s->t->n && s->pairs.n < PAIRS; i += stride_of(s), k++) {
        const pair p = pair_at(s->t, i);
        double wi[3], wo[3];
        if (!usable(s->t, i, &p) || polar(p.wi) < 5 || fmax(polar(p.wi), polar(p.wo)) > 80) continue;
        turn(angle[k % 3], p.wi, wi);
        turn(angle[k % 3], p.wo, wo);
        const double f = sample_mean(s->t, i), g = mean_at(s, wi, wo);
        if (!(g > 0) || !(f > 0)) continue;
        record(&s->pairs, f, g);
        record_alone(s, i, f);
    }
    out->isotropy = (ff_symmetry){0, s->pairs.n, median(&s->pairs), median(&s->alone)};
}

/* Of so many pairs; fewer than PAIRS are of reciprocity alone. */
static ff_status survey_symmetries(const ff_table *t, const ff_interpolant *p, size_t most, ff_survey *out, ff_error *err)
{
    surveyor s = {.t = t, .p = p, .most = most};
    double *room = malloc((4 * PAIRS + t->n_channels) * sizeof *room);
    if (!room) return ff_error_set(err, FF_ERR_MEMORY, NULL, 0, -1, "no memory for %zu channels", t->n_channels);
    deviations *const all[4] = {&s.pairs, &s.with_cosine, &s.without_cosine, &s.alone};
    for (int k = 0; k < 4; k++) all[k]->at = room + k * PAIRS;
    s.value = room + 4 * PAIRS;
    survey_reciprocity(&s, out);
    if (!t->isotropic && most == PAIRS) survey_isotropy(&s, out);
    free(room);
    return FF_OK;
}

int ff_survey_cosine(const ff_survey *s)
{
    enum { ENOUGH = 20 };
    const ff_symmetry *r = &s->reciprocity;
    if (r->pairs < ENOUGH || !(r->deviation > 2 * r->interpolation) || !(r->deviation > 0.02)) return 0;
    if (s->with_cosine < 0.25 * r->deviation && s->with_cosine <= s->without_cosine) return 1;
    return s->without_cosine < 0.25 * r->deviation ? -1 : 0;
}

/* ---- reflectance ----------------------------------------------------------------------------- */

static ff_status survey_reflectance(const ff_table *t, const ff_interpolant *p, ff_survey *s, ff_error *err)
{
    double theta[FF_SURVEY_INCIDENCES], phi[FF_SURVEY_INCIDENCES];
    const size_t n = t->n_channels;
    s->albedo = malloc(2 * FF_SURVEY_INCIDENCES * n * sizeof *s->albedo);
    if (!s->albedo) return ff_error_set(err, FF_ERR_MEMORY, NULL, 0, -1, "no memory for %zu channels", n);
    s->albedo_raised = s->albedo + FF_SURVEY_INCIDENCES * n;
    s->method = t->cells            ? "exact sums over the cells of the data"
                : t->kept_incidence ? "sums over the samples, whose weights are those of the file's function"
                                    : ff_interpolant_method(p);
    s->in_plane = ff_interpolant_is_in_plane(p);
    s->n_reflectances = ff_reflectance_incidences(t, p, FF_SURVEY_INCIDENCES, theta, phi);
    for (size_t k = 0; k < s->n_reflectances; k++) {
        ff_reflected r;
        const ff_status status = ff_reflectance_find(t, p, theta[k], phi[k], &r, s->albedo + k * n, s->albedo_raised + k * n, err);
        if (status != FF_OK) return status;
        s->reflectance[k] = (ff_reflectance){r.theta_i, r.phi_i, r.covered};
        s->azimuths_of[k] = r.azimuths;
        s->over_azimuths[k][0] = r.range[0], s->over_azimuths[k][1] = r.range[1];
    }
    return FF_OK;
}

/* Reflectance by the best interpolation there is, or the quadrature of all samples; symmetries by regression, whose error can be
 * measured. t: as many samples as interpolation may have of all. */
static ff_status survey_values(const ff_table *all, const ff_table *t, ff_survey *s, ff_error *err)
{
    ff_interpolant *best = NULL, *regression = NULL;
    ff_status status = ff_interpolant_new(all->cells ? all : t, 0, &best, err);
    if (status == FF_OK) status = survey_reflectance(ff_reflectance_is_own(all) ? all : t, best, s, err);
    if (status == FF_OK && !s->reciprocity.given) {
        if (!ff_interpolant_regresses(best)) status = ff_interpolant_new(t, 1, &regression, err);
        if (status == FF_OK) status = survey_symmetries(t, regression ? regression : best, PAIRS, s, err);
    }
    ff_interpolant_free(best);
    ff_interpolant_free(regression);
    return status;
}

/* ---- long lists ------------------------------------------------------------------------------ */

/* Every so many samples of t. */
static ff_status thin_out(const ff_table *t, size_t every, ff_table *out, ff_error *err)
{
    const size_t n = (t->n + every - 1) / every;
    const ff_status status = ff_table_init(n, t->n_channels, NULL, 0, 0, out, err);
    if (status != FF_OK) return status;
    out->radians_per_unit = t->radians_per_unit;
    out->isotropic = t->isotropic;
    memcpy(out->channels, t->channels, t->n_channels * sizeof *t->channels);
    for (size_t i = 0; i < n; i++) {
        for (int k = 0; k < 4; k++) out->angle[k][i] = t->angle[k][i * every];
        for (size_t c = 0; c < t->n_channels; c++) out->value[c * n + i] = t->value[c * t->n + i * every];
        out->valid[i] = t->valid[i * every];
    }
    return FF_OK;
}

/* ---- all of it ------------------------------------------------------------------------------- */

ff_status ff_survey_init(const ff_table *t, ff_survey *out, ff_error *err)
{
    ff_survey s = {.theta_i = {NAN, NAN}, .theta_o = {NAN, NAN}, .method = "", .with_cosine = NAN, .without_cosine = NAN};
    s.isotropy = (ff_symmetry){t->isotropic, 0, NAN, NAN};
    s.reciprocity = (ff_symmetry){t->grid == &ff_grid_merl, 0, NAN, NAN};
    survey_coverage(t, &s);
    ff_status status = FF_OK;
    ff_table few = {0};
    s.every = t->grid ? 1 : (t->n - 1) / FF_SURVEY_SAMPLES + 1;
    if (s.every > 1) status = thin_out(t, s.every, &few, err);
    const ff_table *of = s.every > 1 ? &few : t;
    if (isfinite(s.theta_i[0]) && status == FF_OK) status = survey_values(t, of, &s, err);
    if (status == FF_ERR_DATA) status = FF_OK; /* none of the few is usable: an empty survey */
    ff_table_clear(&few);
    if (status == FF_OK)
        *out = s;
    else
        ff_survey_clear(&s);
    return status;
}

ff_status ff_survey_reciprocity(const ff_table *t, size_t most, ff_survey *out)
{
    enum { FEWER = 200 };
    ff_survey s = {.with_cosine = NAN, .without_cosine = NAN, .reciprocity = {t->grid == &ff_grid_merl, 0, NAN, NAN}};
    ff_interpolant *p = NULL;
    ff_table few = {0};
    s.every = t->n > most ? (t->n - 1) / most + 1 : 1;
    ff_status status = s.every > 1 ? thin_out(t, s.every, &few, NULL) : FF_OK;
    if (status == FF_OK && !s.reciprocity.given) status = ff_interpolant_new(s.every > 1 ? &few : t, 1, &p, NULL);
    if (status == FF_OK && p) status = survey_symmetries(s.every > 1 ? &few : t, p, FEWER, &s, NULL);
    if (status == FF_ERR_DATA) status = FF_OK;
    ff_interpolant_free(p);
    ff_table_clear(&few);
    if (status == FF_OK) *out = s;
    return status;
}

void ff_survey_clear(ff_survey *s)
{
    free(s->albedo);
    s->albedo = NULL;
}

ff_status ff_survey_new(const ff_table *t, ff_survey **out, ff_error *err)
{
    ff_survey *made = malloc(sizeof *made);
    if (!made) return ff_error_set(err, FF_ERR_MEMORY, NULL, 0, -1, "out of memory");
    const ff_status status = ff_survey_init(t, made, err);
    if (status)
        free(made);
    else
        *out = made;
    return status;
}

void ff_survey_free(ff_survey *s)
{
    if (s) ff_survey_clear(s);
    free(s);
}
