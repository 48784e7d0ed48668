/* What a fit explains of its data, and where it fails: the few numbers that a person wants first. */
#include "fit/losses/internal_loss.h"
#include "internal_trust.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* More samples than that are looked at through those that the search of starts uses, each for as many as it stands for. */
enum { LOOKED_AT = 20000, FEWEST_IN_BAND = 5 };
#define BRIGHT     0.1  /* of the largest f cos(theta_i) cos(theta_o) */
#define EDGE       1e-3 /* degrees: an angle of a grid that rounding has put below the edge of its band is in it */
#define BAND_SHARE 0.01 /* of the samples, and of the light, that a band has at least */

typedef struct deviation {
    double size, weight;
} deviation;

/* One look: the samples, the whole that they stand for, model and weighted residuals [n_channels][n]. */
typedef struct look {
    const struct ff_problem *p, *whole;
    double *model, *residual;
} look;

static size_t place_of(const look *l, size_t i)
{
    return l->p == l->whole ? i : l->p->index[i];
}

static double plane_at(const struct ff_problem *p, int plane, size_t i)
{
    return ff_problem_plane(p, i / FF_BLOCK, plane)[i % FF_BLOCK];
}

/* What multiplies g(f) - g(y) in a residual. */
static double weight_at(const struct ff_problem *p, size_t c, size_t i)
{
    const double w = plane_at(p, p->weight + p->weight_stride * (int)c, i);
    return p->factor ? w * (double)p->factor[c * p->n_blocks * FF_BLOCK + i] : w;
}

static int is_of_one_side(const struct ff_problem *p, size_t c, size_t i)
{
    return p->side >= 0 && plane_at(p, p->side + (int)c, i) != 0;
}

/* ---- the share ------------------------------------------------------------------------------- */

/* Is g(0) = 0? Then a black surface is what every model is compared with; else, as with logarithms, one that is the same
 * everywhere. */
static int has_black(const struct ff_problem *p)
{
    const double zero = 0, one = 1;
    double g = NAN;
    ff_loss_targets(p->loss, 1, &zero, &one, &g);
    return g == 0;
}

/* The mean of the targets of a channel. */
static double mean_of(const look *l, size_t c)
{
    double sum = 0, weights = 0;
    for (size_t i = 0; i < l->p->n; i++) {
        const double w = is_of_one_side(l->p, c, i) ? 0 : weight_at(l->p, c, i);
        sum += w * w * plane_at(l->p, l->p->target + (int)c, i);
        weights += w * w;
    }
    return weights > 0 ? sum / weights : 0;
}

/* One less the squares that the model leaves over those of the data, as the objective counts them. */
static double share_of(const look *l)
{
    const int black = has_black(l->p);
    double left = 0, all = 0;
    for (size_t c = 0; c < l->p->n_channels; c++) {
        const double from = black ? 0 : mean_of(l, c);
        for (size_t i = 0; i < l->p->n; i++) {
            if (is_of_one_side(l->p, c, i)) continue;
            const double w = weight_at(l->p, c, i), r = l->residual[c * l->p->n + i],
                         apart = plane_at(l->p, l->p->target + (int)c, i) - from;
            left += r * r;
            all += w * w * apart * apart;
        }
    }
    return all > 0 ? 1 - left / all : NAN;
}

/* ---- within the lobe ------------------------------------------------------------------------- */

static int by_size(const void *a, const void *b)
{
    const double x = ((const deviation *)a)->size, y = ((const deviation *)b)->size;
    return (x > y) - (x < y);
}

/* Half of the weight lies below. */
static double median_of(deviation *d, size_t n)
{
    double all = 0, below = 0;
    qsort(d, n, sizeof *d, by_size);
    for (size_t k = 0; k < n; k++) all += d[k].weight;
    for (size_t k = 0; k < n; k++)
        if ((below += d[k].weight) >= 0.5 * all) return d[k].size;
    return NAN;
}

static double brightness(const look *l, size_t c, size_t i)
{
    const size_t at = place_of(l, i);
    return l->model[c * l->p->n + i] * (double)l->whole->cosine[0][at] * (double)l->whole->cosine[1][at];
}

static ff_status look_at_lobe(const look *l, ff_explained *out)
{
    const size_t C = l->p->n_channels, n = l->p->n;
    deviation *d = malloc((C * n + 1) * sizeof *d);
    size_t found = 0;
    if (!d) return FF_ERR_MEMORY;
    for (size_t c = 0; c < C; c++) {
        double most = 0;
        for (size_t i = 0; i < n; i++) most = fmax(most, brightness(l, c, i));
        for (size_t i = 0; i < n; i++) {
            const double f = l->model[c * n + i], y = plane_at(l->p, l->p->value + (int)c, i);
            if (!(brightness(l, c, i) >= BRIGHT * most && f > 0) || is_of_one_side(l->p, c, i)) continue;
            d[found++] = (deviation){fabs(y - f) / f, ff_problem_stands_for(l->p, l->whole, i)};
        }
    }
    out->bright_error = median_of(d, found);
    for (size_t k = 0; k < found; k++) out->bright_values += (size_t)lrint(d[k].weight);
    free(d);
    return FF_OK;
}

/* ---- where it fails -------------------------------------------------------------------------- */

typedef struct band_sum {
    double weight, signed_sum, square, data, count;
} band_sum;

/* theta_h from whichever plane has the slope of h, degrees; NaN: none. */
static double theta_h_of(const struct ff_problem *p, size_t i)
{
    const double degree = 3.14159265358979323846 / 180;
    if (p->geometry[FF_G_S2] >= 0) return atan(sqrt(plane_at(p, p->geometry[FF_G_S2], i))) / degree;
    if (p->geometry[FF_G_SX] < 0 || p->geometry[FF_G_SY] < 0) return NAN;
    return atan(hypot(plane_at(p, p->geometry[FF_G_SX], i), plane_at(p, p->geometry[FF_G_SY], i))) / degree;
}

static void add_sample(const look *l, size_t i, double degrees, band_sum band[FF_BANDS])
{
    const size_t n = l->p->n, at = (size_t)((degrees + EDGE) / FF_BAND_DEGREES), b = at < FF_BANDS ? at : FF_BANDS - 1;
    const double root = plane_at(l->p, l->p->sample_weight, i), w = root * root, x = (double)l->whole->cosine[0][place_of(l, i)];
    for (size_t c = 0; c < l->p->n_channels; c++) {
        const double y = plane_at(l->p, l->p->value + (int)c, i), e = (l->model[c * n + i] - y) * x;
        if (is_of_one_side(l->p, c, i)) continue;
        band[b].weight += w;
        band[b].signed_sum += w * e;
        band[b].square += w * e * e;
        band[b].data += w * fabs(y) * x;
    }
    band[b].count += ff_problem_stands_for(l->p, l->whole, i);
}

/* The mean that is furthest from 0, of bands that have samples enough to say so beyond their scatter. */
static void find_worst(const band_sum band[FF_BANDS], int place, double samples, ff_explained *out)
{
    double data = 0;
    for (int b = 0; b < FF_BANDS; b++) data += band[b].data;
    for (int b = 0; b < FF_BANDS; b++) {
        const double mean = band[b].signed_sum / band[b].data,
                     scatter = sqrt(band[b].square * band[b].weight / band[b].count) / band[b].data;
        if (!(band[b].data > 0) || band[b].count < fmax(FEWEST_IN_BAND, BAND_SHARE * samples) || fabs(mean) < 2 * scatter ||
            band[b].data < BAND_SHARE * data)
            continue;
        if (!isnan(out->worst_mean) && fabs(mean) <= fabs(out->worst_mean)) continue;
        out->worst_place = place;
        out->worst_band = b;
        out->worst_mean = mean;
        out->worst_share = band[b].data / data;
    }
}

static void look_by_angle(const look *l, ff_explained *out)
{
    band_sum by_i[FF_BANDS] = {{0}}, by_h[FF_BANDS] = {{0}};
    for (size_t i = 0; i < l->p->n; i++) {
        const double theta_h = theta_h_of(l->p, i);
        add_sample(l, i, acos(fmin((double)l->whole->cosine[0][place_of(l, i)], 1)) * (180 / 3.14159265358979323846), by_i);
        if (!isnan(theta_h)) add_sample(l, i, theta_h, by_h);
    }
    find_worst(by_i, FF_PLACE_THETA_I, (double)l->whole->n, out);
    find_worst(by_h, FF_PLACE_THETA_H, (double)l->whole->n, out);
}

/* ---- the whole ------------------------------------------------------------------------------- */

static ff_status look_at(const ff_finished *f, const look *l, ff_explained *out)
{
    const ff_plan plan = ff_plan_on(&f->plan, l->p);
    const ff_status status = ff_point_evaluate(&plan, &f->at, 1, l->model, l->residual, NULL);
    if (status) return status;
    out->share = share_of(l);
    look_by_angle(l, out);
    return look_at_lobe(l, out);
}

ff_status ff_trust_explained_into(const ff_problem *p, const ff_fit_options *o, const ff_fit_result *fit, ff_explained *out,
                                  ff_error *err)
{
    ff_explained e = {.size = sizeof e, .share = NAN, .bright_error = NAN, .worst_mean = NAN, .worst_share = NAN};
    ff_finished f;
    ff_status status = ff_finished_open(p, o, fit, &f, err);
    if (status) return status;
    look l = {.p = p->n > LOOKED_AT ? p->subsample : p, .whole = p};
    const size_t values = p->n_channels * l.p->n + 1;
    l.model = malloc(2 * values * sizeof *l.model);
    l.residual = l.model ? l.model + values : NULL;
    status = l.model ? look_at(&f, &l, &e) : FF_ERR_MEMORY;
    free(l.model);
    ff_finished_close(&f);
    if (status) return ff_error_set(err, status, NULL, 0, -1, "the model could not be evaluated: %s", ff_status_str(status));
    *out = e;
    return FF_OK;
}
