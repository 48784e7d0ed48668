/* Whether angles and values are what they were taken for. Each way of taking the angles is tried: that share of the differences of
 * ln f within an incidence which theta_h explains says how well it does. */
#include "internal_diagnosis.h"
#include "ff_brightest.h"
#include "survey_struct.h"
#include "data_formats/table/internal_table.h"
#include "models/model_struct.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const double pi = 3.14159265358979323846;

enum { BANDS = 18, HALVES = 45, SECTORS = 4, GROUPS = BANDS * HALVES * SECTORS, LOOKED_AT = 20000, FEWEST = 40 };
#define EXPLAINS 0.8  /* of the differences, when it is right */
#define LEAVES   0.35 /* of what is left as it is, at the most */

/* A direction: its polar angle in radians, and the sines and cosines of both. */
typedef struct direction {
    double theta, sin_theta, cos_theta, sin_phi, cos_phi;
} direction;

/* One sample. y: ln f. */
typedef struct sample {
    direction i, o;
    double y;
} sample;

typedef struct looker {
    size_t n;
    sample *at;
    int turns; /* light from several azimuths: the half vector's counts too */
} looker;

typedef struct share {
    size_t n, bands;
    double explained; /* adjusted for the number of groups; -infinity where too few samples share one */
    double slope;     /* of y along theta_h: negative for a lobe */
} share;

/* ---- samples ---------------------------------------------------------------------------------- */

static double mean_value(const ff_table *t, size_t i)
{
    double mean = 0;
    for (size_t c = 0; c < t->n_channels; c++) mean += t->channels[c].scale * t->value[c * t->n + i] / (double)t->n_channels;
    return mean;
}

static direction direction_of(double theta, double phi)
{
    return (direction){theta, sin(theta), cos(theta), sin(phi), cos(phi)};
}

static int take(const ff_table *t, looker *l)
{
    const size_t step = t->n / LOOKED_AT + 1;
    l->at = malloc((t->n / step + 1) * sizeof *l->at);
    if (!l->at) return 0;
    for (size_t i = 0; i < t->n; i += step) {
        const double u = t->radians_per_unit, v = mean_value(t, i);
        if (!t->valid[i] || !(v > 0)) continue;
        l->at[l->n++] = (sample){direction_of(u * t->angle[0][i], u * t->angle[1][i]),
                                 direction_of(u * t->angle[2][i], u * t->angle[3][i]), log(v)};
    }
    return 1;
}

/* ---- taking the angles otherwise ---------------------------------------------------------------- */

/* From the surface instead of its normal. */
static direction elevated(direction d)
{
    return (direction){pi / 2 - d.theta, d.cos_theta, d.sin_theta, d.sin_phi, d.cos_phi};
}

static sample taken_as(const sample *as_is, int kind)
{
    sample s = *as_is;
    if (kind == FF_DIAGNOSIS_ELEVATION || kind == FF_DIAGNOSIS_ELEVATION_IN) s.i = elevated(s.i);
    if (kind == FF_DIAGNOSIS_ELEVATION || kind == FF_DIAGNOSIS_ELEVATION_OUT) s.o = elevated(s.o);
    if (kind == FF_DIAGNOSIS_TURNED) s.o.cos_phi = -s.o.cos_phi;
    if (kind == FF_DIAGNOSIS_TURNED || kind == FF_DIAGNOSIS_CLOCKWISE) s.o.sin_phi = -s.o.sin_phi;
    return s;
}

/* The half vector; with_phi also its azimuth in [0, pi), in which a surface of two roughnesses repeats. */
static void half_of(const sample *s, int with_phi, double *theta, double *phi)
{
    const double x = s->i.sin_theta * s->i.cos_phi + s->o.sin_theta * s->o.cos_phi;
    const double y = s->i.sin_theta * s->i.sin_phi + s->o.sin_theta * s->o.sin_phi, z = s->i.cos_theta + s->o.cos_theta;
    const double across = sqrt(x * x + y * y);
    *theta = atan2(across, z);
    *phi = with_phi && across > 1e-9 ? atan2(y, x) : 0;
    if (*phi < 0) *phi += pi;
}

static int band_of(double x, double width, int n)
{
    const int k = (int)(x / width + 1e-9);
    return k < 0 ? 0 : k < n ? k : n - 1;
}

/* Sums of a group of samples. */
typedef struct group {
    double n, y, yy;
} group;

static void add(group *g, double y)
{
    g->n++;
    g->y += y;
    g->yy += y * y;
}

static double within(const group *g)
{
    return g->n > 0 ? fmax(0, g->yy - g->y * g->y / g->n) : 0;
}

static int usable(const sample *s, double max_theta)
{
    return s->i.cos_theta > FF_COS_MIN && s->o.cos_theta > FF_COS_MIN && fabs(s->i.theta) <= max_theta &&
           fabs(s->o.theta) <= max_theta;
}

static share explain(const looker *l, int kind, double max_theta, group *groups)
{
    group of_band[BANDS] = {{0}};
    double between = 0, left = 0, n = 0, free = 0, xy = 0, x_sum = 0;
    size_t used = 0, bands = 0;
    memset(groups, 0, GROUPS * sizeof *groups);
    for (size_t i = 0; i < l->n; i++) {
        const sample s = taken_as(&l->at[i], kind);
        if (!usable(&s, max_theta)) continue;
        double half, phi;
        half_of(&s, l->turns, &half, &phi);
        const int band = band_of(fabs(s.i.theta), pi / 36, BANDS), sector = l->turns ? band_of(phi, pi / SECTORS, SECTORS) : 0;
        add(&of_band[band], s.y);
        add(&groups[(band * HALVES + band_of(half, pi / 90, HALVES)) * SECTORS + sector], s.y);
        x_sum += half;
        xy += half * s.y;
        n++;
    }
    double y_sum = 0;
    for (int b = 0; b < BANDS; b++) {
        if (of_band[b].n == 0) continue;
        between += within(&of_band[b]);
        y_sum += of_band[b].y;
        free += 1;
        bands++;
    }
    for (int k = 0; k < GROUPS; k++) {
        left += within(&groups[k]);
        used += groups[k].n > 0;
    }
    share s = {(size_t)n, bands, -INFINITY, n > 0 ? xy - x_sum * y_sum / n : 0};
    if (n - (double)used >= FEWEST / 2.0 && n - free > 0 && between > 0)
        s.explained = 1 - left / (n - (double)used) / (between / (n - free));
    return s;
}

/* ---- findings ------------------------------------------------------------------------------------- */

static void put(ff_diagnosis *g, ff_diagnosis_kind kind, int sure, double a, double b)
{
    if (g->n < FF_DIAGNOSIS_FINDINGS) g->finding[g->n++] = (ff_finding){kind, sure, {a, b}};
}

static int has_two_azimuths(const ff_table *t)
{
    for (size_t i = 1; i < t->n; i++)
        if (t->angle[1][i] != t->angle[1][0]) return 1;
    return 0;
}

static void look_at_unit(const ff_table *t, ff_diagnosis *g)
{
    double largest = 0;
    if (t->radians_per_unit == 1 || t->n < 3) return;
    for (size_t i = 0; i < t->n; i++) largest = fmax(largest, fmax(fabs(t->angle[0][i]), fabs(t->angle[2][i])));
    if (largest > 0 && largest <= pi / 2 + 1e-4) put(g, FF_DIAGNOSIS_RADIANS, ff_table_has_radian_azimuths(t), largest, 0);
}

/* The way of taking the angles that explains clearly more. A lobe falls along theta_h. */
static ff_status look_at_angles(const ff_table *t, double max_theta, ff_diagnosis *g)
{
    looker l = {.turns = has_two_azimuths(t)};
    group *groups = malloc(GROUPS * sizeof *groups);
    if (!groups || !take(t, &l)) {
        free(groups);
        return FF_ERR_MEMORY;
    }
    const share as_is = explain(&l, -1, max_theta, groups);
    share best = as_is;
    int kind = -1;
    for (int k = FF_DIAGNOSIS_TURNED; k <= FF_DIAGNOSIS_CLOCKWISE; k++) {
        if (k == FF_DIAGNOSIS_UNTURNED || (k == FF_DIAGNOSIS_CLOCKWISE && !l.turns)) continue;
        const share s = explain(&l, k, max_theta, groups);
        if (s.n < FEWEST || s.bands < 2 || s.slope >= 0 || !(s.explained > best.explained + 1e-3)) continue;
        best = s;
        kind = k;
    }
    if (kind >= 0 && best.explained > EXPLAINS && as_is.n >= FEWEST && 1 - best.explained < LEAVES * (1 - as_is.explained))
        put(g, kind == FF_DIAGNOSIS_TURNED && t->azimuth_from_mirror ? FF_DIAGNOSIS_UNTURNED : (ff_diagnosis_kind)kind, 1,
            as_is.explained, best.explained);
    free(groups);
    free(l.at);
    return FF_OK;
}

static void look_at_side(const ff_table *t, const ff_brightest *b, ff_diagnosis *g)
{
    if (ff_brightest_odd(b) != FF_SIDE_LIGHT) return;
    for (size_t k = 0; k < g->n; k++)
        if (g->finding[k].kind <= FF_DIAGNOSIS_CLOCKWISE) return;
    put(g, t->azimuth_from_mirror ? FF_DIAGNOSIS_UNTURNED : FF_DIAGNOSIS_TURNED, 1, NAN, NAN);
}

static void look_at_values(const ff_brightest *b, ff_diagnosis *g)
{
    if (b->reflects > FF_REFLECTS_ODD)
        put(g, FF_DIAGNOSIS_UNIT, 0, b->reflects, 0);
    else if (b->reflects > FF_REFLECTS_FACTOR)
        put(g, FF_DIAGNOSIS_PERCENT, 0, b->reflects, 0);
    else if (b->reflects > FF_REFLECTS_SOME)
        put(g, FF_DIAGNOSIS_FACTOR, 0, b->reflects, 0);
}

/* Reciprocity says whether a cosine is counted, where the angles are not in doubt. Sure of much that nearly all of goes. It is
 * looked at through so few samples that a fit takes no longer for it. */
static ff_status look_at_cosine(const ff_table *t, ff_diagnosis *g)
{
    enum { LOOKED_AT_HERE = 1500 };
    ff_survey s;
    if (t->grid || g->n) return FF_OK;
    const ff_status status = ff_survey_reciprocity(t, LOOKED_AT_HERE, &s);
    const int cosine = status == FF_OK ? ff_survey_cosine(&s) : 0;
    const double mended = cosine > 0 ? s.with_cosine : s.without_cosine;
    if (cosine)
        put(g, cosine > 0 ? FF_DIAGNOSIS_COSINE : FF_DIAGNOSIS_NO_COSINE, s.reciprocity.deviation > 0.1, s.reciprocity.deviation,
            mended);
    return status;
}

int ff_diagnosis_is_of_values(const ff_finding *f)
{
    return f->kind == FF_DIAGNOSIS_PERCENT || f->kind == FF_DIAGNOSIS_FACTOR || f->kind == FF_DIAGNOSIS_UNIT ||
           f->kind == FF_DIAGNOSIS_COSINE || f->kind == FF_DIAGNOSIS_NO_COSINE;
}

/* The least largest angle that a sample has, or one that is within max_theta; infinite where none is above the horizon. */
static double least_angle(const ff_table *t, double max_theta)
{
    double w[6], *const planes[6] = {w, w + 1, w + 2, w + 3, w + 4, w + 5}, least = INFINITY;
    for (size_t i = 0; i < t->n; i++) {
        if (!t->valid[i]) continue;
        ff_table_directions(t, i, 1, planes);
        if (w[2] > FF_COS_MIN && w[5] > FF_COS_MIN) least = fmin(least, acos(fmin(fmin(w[2], w[5]), 1)));
        if (least <= max_theta) break;
    }
    return least;
}

ff_status ff_diagnosis_find(const ff_table *t, double max_theta, ff_diagnosis *out)
{
    ff_brightest b;
    ff_diagnosis g = {.open = t->angles_are_open, .quantity_open = t->quantity_is_open};
    ff_status status = ff_brightest_find(t, max_theta, &b);
    if (status != FF_OK) return status;
    if (!t->grid) {
        look_at_unit(t, &g);
        if (g.n == 0) status = look_at_angles(t, max_theta, &g);
        if (status != FF_OK) return status;
    }
    if (g.n == 0) look_at_side(t, &b, &g);
    status = look_at_cosine(t, &g);
    if (status != FF_OK) return status;
    const double least = least_angle(t, max_theta);
    if (isfinite(least) && least > max_theta * (1 + 1e-12)) put(&g, FF_DIAGNOSIS_BEYOND, 1, least * 180 / pi, 0);
    look_at_values(&b, &g);
    *out = g;
    return FF_OK;
}

const char *ff_diagnosis_option(const ff_finding *f, char value[32])
{
    static const struct {
        const char *option, *value;
    } of[FF_DIAGNOSIS_KINDS] = {[FF_DIAGNOSIS_TURNED] = {"azimuth", "mirror"},
                                [FF_DIAGNOSIS_UNTURNED] = {"azimuth", "light"},
                                [FF_DIAGNOSIS_ELEVATION] = {"angles", "elevation"},
                                [FF_DIAGNOSIS_ELEVATION_IN] = {"angles", "elevation-in"},
                                [FF_DIAGNOSIS_ELEVATION_OUT] = {"angles", "elevation-out"},
                                [FF_DIAGNOSIS_CLOCKWISE] = {"phi", "clockwise-out"},
                                [FF_DIAGNOSIS_RADIANS] = {"angles", "radians"},
                                [FF_DIAGNOSIS_PERCENT] = {"scale", "0.01"},
                                [FF_DIAGNOSIS_FACTOR] = {"quantity", "reflectance-factor"},
                                [FF_DIAGNOSIS_BEYOND] = {"max-theta", ""},
                                [FF_DIAGNOSIS_COSINE] = {"quantity", "brdf-cos"},
                                [FF_DIAGNOSIS_NO_COSINE] = {"quantity", "brdf"}};
    if ((unsigned)f->kind >= FF_DIAGNOSIS_KINDS || !of[f->kind].option) return NULL;
    strcpy(value, of[f->kind].value);
    if (f->kind == FF_DIAGNOSIS_BEYOND) snprintf(value, 32, "%g", fmin(90, ceil(f->value[0]) + 5));
    return of[f->kind].option;
}
