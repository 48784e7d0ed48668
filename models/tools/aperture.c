/* Means over an aperture: sums over nodes about each direction, of an order that doubles until it does not matter. */
#include "ff_aperture.h"
#include "base/internal_gauss.h"
#include "models/internal_model.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { MOST_ORDER = 128, LEAST_ORDER = 2, BATCH = 4096, CURVE = 256 };
static const double pi = 3.14159265358979323846;

/* Nodes in the frame of the centre: p along theta, q across, r towards the centre; weights add up to 1. */
typedef struct rule {
    size_t n;
    double *p, *q, *r, *weight;
    double x[2 * MOST_ORDER], w[2 * MOST_ORDER];
    double storage[4 * 4 * MOST_ORDER * MOST_ORDER];
} rule;

/* n points of Gauss and Legendre on [a, b]: a power of 2, in panels from FF_GAUSS on. */
static void points(int n, double a, double b, double *x, double *w)
{
    ff_gauss g;
    if (n >= FF_GAUSS) {
        ff_gauss_panels(a, b, n / FF_GAUSS, x, w);
        return;
    }
    ff_gauss_make(n, &g);
    for (int i = 0; i < n; i++) {
        x[i] = a + 0.5 * (b - a) * (1 + g.x[i]);
        w[i] = 0.5 * (b - a) * g.w[i];
    }
}

static void disc(const ff_aperture *a, int order, rule *r)
{
    const int around = 4 * order;
    points(order, 0, a->half, r->x, r->w);
    for (int i = 0; i < order; i++)
        for (int k = 0; k < around; k++, r->n++) {
            const double phi = 2 * pi * (k + 0.5 * (i % 2)) / around;
            r->p[r->n] = sin(r->x[i]) * cos(phi);
            r->q[r->n] = sin(r->x[i]) * sin(phi);
            r->r[r->n] = cos(r->x[i]);
            r->weight[r->n] = r->w[i] * sin(r->x[i]);
        }
}

static void side(int n, double half, double *x, double *w)
{
    points(n, -1, 1, x, w);
    for (int i = 0; i < n; i++) x[i] *= tan(half);
}

static void rectangle(const ff_aperture *a, int order, rule *r)
{
    const int n = 2 * order;
    double y[2 * MOST_ORDER], v[2 * MOST_ORDER];
    side(n, a->half, r->x, r->w);
    side(n, a->across, y, v);
    for (int i = 0; i < n; i++)
        for (int k = 0; k < n; k++, r->n++) {
            const double inverse = 1 / sqrt(1 + r->x[i] * r->x[i] + y[k] * y[k]);
            r->p[r->n] = r->x[i] * inverse;
            r->q[r->n] = y[k] * inverse;
            r->r[r->n] = inverse;
            r->weight[r->n] = r->w[i] * v[k] * inverse * inverse * inverse;
        }
}

static void make_rule(const ff_aperture *a, int order, rule *r)
{
    const size_t most = (size_t)4 * MOST_ORDER * MOST_ORDER;
    double sum = 0;
    r->n = 0;
    r->p = r->storage;
    r->q = r->p + most;
    r->r = r->q + most;
    r->weight = r->r + most;
    if (a->outline == FF_APERTURE_DISC)
        disc(a, order, r);
    else
        rectangle(a, order, r);
    for (size_t i = 0; i < r->n; i++) sum += r->weight[i];
    for (size_t i = 0; i < r->n; i++) r->weight[i] /= sum;
}

typedef struct averaging {
    const ff_aperture *a;
    const ff_model *m;
    ff_isa isa;
    size_t C, P;
    const double *shape, *channel;
    double width; /* of the narrowest lobe: half the angle of normals at which D is half of that at the normal */
    rule rule;
    double w[6][BATCH];
    double *f, *df;       /* [C][BATCH], [C][P][BATCH] of the nodes; df NULL: values alone */
    double *mean, *dmean; /* [C], [C][P] of the pair */
    double *before;       /* [C] at the order before   */
} averaging;

/* Where D towards an azimuth is half of that at the normal, radians; a right angle where it is not. */
static ff_status half_width(const averaging *v, uint32_t lobe, double azimuth, double *out)
{
    double w[3][CURVE], d[CURVE], theta[CURVE];
    for (int i = 0; i < CURVE; i++) {
        theta[i] = i ? atan(1e-5 * pow(1e6, (i - 1) / (CURVE - 2.0))) : 0;
        w[0][i] = sin(theta[i]) * cos(azimuth), w[1][i] = sin(theta[i]) * sin(azimuth), w[2][i] = cos(theta[i]);
    }
    const ff_dirs h = {w[0], w[1], w[2], w[0], w[1], w[2]};
    const ff_status status = ff_model_terms(v->m, v->isa, v->C, v->shape, v->channel, lobe, 0, &h, CURVE, &(ff_terms){.d = d});
    int i = 1;
    while (!status && i < CURVE && d[i] > 0.5 * d[0]) i++;
    *out = i < CURVE ? theta[i] : 0.5 * pi;
    return status;
}

static ff_status find_width(averaging *v)
{
    ff_status status = FF_OK;
    v->width = 0.5 * pi;
    for (uint32_t lobe = 0; lobe < v->m->n_lobes && !status; lobe++)
        for (int k = 0; k < 4 && !status; k++) {
            double width;
            status = half_width(v, lobe, 0.25 * pi * k, &width);
            if (!status) v->width = fmin(v->width, width);
        }
    return status;
}

/* A normal that leans by an angle moves the exit by twice of it, and across the plane by as much as the cosine leaves of that. */
static int first_order(const averaging *v, double wiz, double woz)
{
    const double half = v->a->outline == FF_APERTURE_DISC ? v->a->half : fmax(v->a->half, v->a->across);
    const double widths = half / (v->width * fmax(wiz + woz, 0.05));
    int order = LEAST_ORDER;
    while (order < MOST_ORDER / 2 && order < widths) order *= 2;
    return order;
}

/* Nodes first .. first + n about the centre of pair i. */
static void place_nodes(averaging *v, const ff_dirs *w, size_t i, size_t first, size_t n)
{
    const double c[3] = {w->wox[i], w->woy[i], w->woz[i]}, sine = hypot(c[0], c[1]);
    const double cos_phi = sine > 1e-12 ? c[0] / sine : 1, sin_phi = sine > 1e-12 ? c[1] / sine : 0;
    const rule *r = &v->rule;
    for (size_t k = 0; k < n; k++) {
        const double p = r->p[first + k], q = r->q[first + k], z = r->r[first + k];
        v->w[0][k] = w->wix[i], v->w[1][k] = w->wiy[i], v->w[2][k] = w->wiz[i];
        v->w[3][k] = p * c[2] * cos_phi - q * sin_phi + z * c[0];
        v->w[4][k] = p * c[2] * sin_phi + q * cos_phi + z * c[1];
        v->w[5][k] = -p * sine + z * c[2];
    }
}

static ff_status sum_nodes(averaging *v, const ff_dirs *w, size_t i)
{
    const ff_dirs nodes = {v->w[0], v->w[1], v->w[2], v->w[3], v->w[4], v->w[5]};
    const double inverse = 1 / w->woz[i];
    memset(v->mean, 0, v->C * sizeof *v->mean);
    if (v->df) memset(v->dmean, 0, v->C * v->P * sizeof *v->dmean);
    for (size_t first = 0; first < v->rule.n; first += BATCH) {
        const size_t n = v->rule.n - first < BATCH ? v->rule.n - first : BATCH;
        place_nodes(v, w, i, first, n);
        const ff_status status = ff_model_eval(v->m, v->isa, v->C, v->shape, v->channel, &nodes, n, v->f, v->df, BATCH);
        if (status) return status;
        for (size_t k = 0; k < n; k++) {
            const double weight = v->rule.weight[first + k] * fmax(v->w[5][k], 0) * inverse;
            for (size_t c = 0; c < v->C; c++) v->mean[c] += weight * v->f[c * BATCH + k];
            for (size_t c = 0; v->df && c < v->C * v->P; c++) v->dmean[c] += weight * v->df[c * BATCH + k];
        }
    }
    return FF_OK;
}

/* The pair at one order after the other; *error: what the last two differ by. */
static ff_status average(averaging *v, const ff_dirs *w, size_t i, double *error)
{
    int order = first_order(v, w->wiz[i], w->woz[i]);
    *error = INFINITY;
    for (int begun = 0; order <= MOST_ORDER && *error > FF_APERTURE_TOLERANCE; order *= 2, begun = 1) {
        make_rule(v->a, order, &v->rule);
        const ff_status status = sum_nodes(v, w, i);
        if (status) return status;
        double most = 0;
        for (size_t c = 0; c < v->C; c++)
            if (v->mean[c] != v->before[c]) most = fmax(most, fabs(v->mean[c] - v->before[c]) / fabs(v->mean[c]));
        if (begun) *error = most;
        memcpy(v->before, v->mean, v->C * sizeof *v->before);
    }
    return FF_OK;
}

static int is_aperture(const ff_aperture *a)
{
    const int disc = a->outline == FF_APERTURE_DISC;
    if (!disc && a->outline != FF_APERTURE_RECTANGLE) return 0;
    return a->half >= 0 && a->half <= FF_APERTURE_MOST && (disc || (a->across >= 0 && a->across <= FF_APERTURE_MOST));
}

static ff_status average_all(averaging *v, const ff_dirs *w, size_t n, double *f, double *df, double *error, size_t ld)
{
    ff_status status = find_width(v);
    for (size_t i = 0; i < n && !status; i++) {
        const int up = w->wiz[i] > FF_COS_MIN && w->woz[i] > FF_COS_MIN;
        double left = 0;
        if (up) status = average(v, w, i, &left);
        for (size_t c = 0; c < v->C && !status; c++) f[c * ld + i] = up ? v->mean[c] : 0;
        for (size_t k = 0; df && k < v->C * v->P && !status; k++) df[k * ld + i] = up ? v->dmean[k] : 0;
        if (error) error[i] = left;
    }
    return status;
}

ff_status ff_aperture_eval(const ff_aperture *a, const ff_model *m, ff_isa isa, size_t n_channels, const double *shape,
                           const double *channel, const ff_dirs *w, size_t n, double *f, double *df, double *error, size_t ld)
{
    ff_status status = ff_model_check(m, n_channels, shape, channel, NULL);
    if (status) return status;
    if (!is_aperture(a) || ld < n) return FF_ERR_RANGE;
    if (a->half == 0 && (a->outline == FF_APERTURE_DISC || a->across == 0)) {
        for (size_t i = 0; error && i < n; i++) error[i] = 0;
        return ff_model_eval(m, isa, n_channels, shape, channel, w, n, f, df, ld);
    }
    const size_t P = m->n_shape + m->n_channel;
    averaging *v = malloc(sizeof *v);
    double *sums = malloc(n_channels * (2 + P) * sizeof *sums),
           *nodes = malloc(n_channels * BATCH * (df ? 1 + P : 1) * sizeof *nodes);
    status = v && sums && nodes ? FF_OK : FF_ERR_MEMORY;
    if (!status) {
        v->a = a, v->m = m, v->isa = isa, v->C = n_channels, v->P = P, v->shape = shape, v->channel = channel;
        v->f = nodes, v->df = df ? nodes + n_channels * BATCH : NULL;
        v->mean = sums, v->before = sums + n_channels, v->dmean = sums + 2 * n_channels;
        memset(v->before, 0, n_channels * sizeof *v->before);
        status = average_all(v, w, n, f, df, error, ld);
    }
    free(v);
    free(sums);
    free(nodes);
    return status;
}
