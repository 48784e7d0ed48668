/* RGL files: made here and read, evaluated against a second implementation by plain integration, written, and spoilt; real files
 * against the output of the database's own loader. `test_formats_rgl --corpus DIR` writes the files of tests/fuzz/corpus/rgl. */
#include "check_table.h"
#include "data_formats/formats/rgl/internal_rgl.h"
#include "data_formats/analysis/survey_struct.h"
#include "data_formats/analysis/spectral_struct.h"
#include <dirent.h>

static const double pi = 3.14159265358979323846;

/* ---- making files ---------------------------------------------------------------------------- */

enum { FIELDS = 16, BIG = 1 << 22 };

typedef struct field {
    const char *name;
    unsigned type; /* 1 uint8, 5 uint32, 10 float32 */
    size_t n_dims, shape[5];
    const void *data;
} field;

/* What a test file consists of; numbers are for the second implementation as well. */
typedef struct material {
    size_t P, T, C, H, W, vh, vw, nh, nw, sh, sw;
    float phi[16], theta[8], nm[40], *ndf, *sigma, *vndf, *colour, *luminance;
    unsigned char jacobian[1];
    int spectral, reduction;
} material;

static void put(unsigned char *b, uint64_t v, unsigned n)
{
    for (unsigned k = 0; k < n; k++) b[k] = (unsigned char)(v >> 8 * k);
}

static size_t bytes_of(const field *f)
{
    size_t n = f->type == 1 ? 1 : f->type == 11 ? 8 : 4;
    for (size_t d = 0; d < f->n_dims; d++) n *= f->shape[d];
    return n;
}

/* The container, as its description says; returns its size. header[k]: where the description of field k stands, offset[k]: its
 * data. */
static size_t write_tensors(unsigned char *b, const field *f, size_t n, size_t *header, size_t *offset)
{
    size_t at = 18;
    memcpy(b, "tensor_file\0\1\0", 14);
    put(b + 14, n, 4);
    for (size_t k = 0; k < n; k++) {
        header[k] = at;
        at += 13 + strlen(f[k].name) + 8 * f[k].n_dims;
    }
    for (size_t k = 0; k < n; k++) {
        at = (at + 7) / 8 * 8;
        offset[k] = at;
        memcpy(b + at, f[k].data, bytes_of(&f[k]));
        at += bytes_of(&f[k]);
        unsigned char *h = b + header[k];
        size_t length = strlen(f[k].name);
        put(h, length, 2);
        memcpy(h + 2, f[k].name, length);
        h += 2 + length;
        put(h, f[k].n_dims, 2);
        h[2] = (unsigned char)f[k].type;
        put(h + 3, offset[k], 8);
        for (size_t d = 0; d < f[k].n_dims; d++) put(h + 11 + 8 * d, f[k].shape[d], 8);
    }
    return at;
}

static float *filled(size_t n, double lo, double hi)
{
    float *v = malloc(n * sizeof *v);
    if (!v) exit(1);
    for (size_t i = 0; i < n; i++) v[i] = (float)(lo + (hi - lo) * ff_test_uniform());
    return v;
}

static void repeat_first(float *v, size_t rows, size_t row)
{
    memcpy(v + (rows - 1) * row, v, row * sizeof *v);
}

/* P azimuths from -pi over 1/reduction of the circle (1: isotropic). */
static material make(size_t P, int reduction, size_t C, int spectral)
{
    material m = {
        .P = P, .T = 4, .C = C, .H = 6, .W = 5, .vh = 9, .vw = 8, .nh = P > 2 ? 7 : 2, .nw = 8, .sh = P > 2 ? 5 : 2, .sw = 6};
    m.spectral = spectral, m.reduction = reduction, m.jacobian[0] = 1;
    for (size_t p = 0; p < P; p++) m.phi[p] = (float)(P > 1 ? -pi + 2 * pi / reduction * (double)p / (double)(P - 1) : 0);
    const float theta[4] = {0, 0.4f, 0.9f, 1.3f};
    memcpy(m.theta, theta, sizeof theta);
    for (size_t c = 0; c < C; c++) m.nm[c] = (float)(400.1 + 10.25 * (double)c);
    m.ndf = filled(m.nh * m.nw, 0.5, 2);
    m.sigma = filled(m.sh * m.sw, 0.5, 1);
    m.vndf = filled(P * m.T * m.vh * m.vw, 0.1, 1);
    m.colour = filled(P * m.T * C * m.H * m.W, -0.2, 1);
    m.luminance = filled(P * m.T * m.H * m.W, 0, 1);
    /* Azimuths go around. */
    repeat_first(m.ndf, m.nh, m.nw);
    repeat_first(m.sigma, m.sh, m.sw);
    for (size_t k = 0; k < P * m.T; k++) {
        float *v = m.vndf + k * m.vh * m.vw;
        for (size_t y = 0; y < m.vh; y++) v[y * m.vw] = 0; /* no area at the normal */
        repeat_first(v, m.vh, m.vw);
    }
    if (reduction == 1 && P > 2) {
        repeat_first(m.vndf, P, m.T * m.vh * m.vw);
        repeat_first(m.colour, P, m.T * C * m.H * m.W);
    }
    return m;
}

static void unmake(material *m)
{
    free(m->ndf), free(m->sigma), free(m->vndf), free(m->colour), free(m->luminance);
}

static const unsigned char valid_bits[4] = {255, 254, 1, 0};
enum { PHI, THETA, SIGMA, NDF, VNDF, LUMINANCE, COLOUR, JACOBIAN, DESCRIPTION, EXTRA, WAVELENGTHS, N_FIELDS };

static size_t fields_of(const material *m, field *f)
{
    static const char text[] = "Made \xC2\xB5 here";
    f[PHI] = (field){"phi_i", 10, 1, {m->P}, m->phi};
    f[THETA] = (field){"theta_i", 10, 1, {m->T}, m->theta};
    f[SIGMA] = (field){"sigma", 10, 2, {m->sh, m->sw}, m->sigma};
    f[NDF] = (field){"ndf", 10, 2, {m->nh, m->nw}, m->ndf};
    f[VNDF] = (field){"vndf", 10, 4, {m->P, m->T, m->vh, m->vw}, m->vndf};
    f[LUMINANCE] = (field){"luminance", 10, 4, {m->P, m->T, m->H, m->W}, m->luminance};
    f[COLOUR] = (field){m->spectral ? "spectra" : "rgb", 10, 5, {m->P, m->T, m->C, m->H, m->W}, m->colour};
    f[JACOBIAN] = (field){"jacobian", 1, 1, {1}, m->jacobian};
    f[DESCRIPTION] = (field){"description", 1, 1, {sizeof text - 1}, text};
    f[EXTRA] = (field){"valid", 1, 1, {4}, valid_bits};
    f[WAVELENGTHS] = (field){"wavelengths", 10, 1, {m->C}, m->nm};
    return m->spectral ? N_FIELDS : N_FIELDS - 1;
}

static size_t header_at[FIELDS], data_at[FIELDS];
static unsigned char file_bytes[BIG];

static size_t file_of(const material *m)
{
    field f[FIELDS];
    const size_t n = fields_of(m, f);
    return write_tensors(file_bytes, f, n, header_at, data_at);
}

/* ---- a second implementation ----------------------------------------------------------------- */

static double grid_at(const float *g, size_t h, size_t w, double x, double y)
{
    x = fmax(x, 0) * (double)(w - 1), y = fmax(y, 0) * (double)(h - 1);
    size_t a = (size_t)fmin(floor(x), (double)w - 2), b = (size_t)fmin(floor(y), (double)h - 2);
    double p = x - (double)a, q = y - (double)b;
    return (double)g[b * w + a] * (1 - p) * (1 - q) + (double)g[b * w + a + 1] * p * (1 - q) +
           (double)g[(b + 1) * w + a] * (1 - p) * q + (double)g[(b + 1) * w + a + 1] * p * q;
}

/* Integral over [0, x] x [0, y], cell by cell: of a bilinear function that is the value at the middle times the area. */
static double integral(const float *g, size_t h, size_t w, double x, double y)
{
    double sum = 0;
    for (size_t b = 0; b + 1 < h; b++)
        for (size_t a = 0; a + 1 < w; a++) {
            double x0 = (double)a / (double)(w - 1), x1 = fmin((double)(a + 1) / (double)(w - 1), x);
            double y0 = (double)b / (double)(h - 1), y1 = fmin((double)(b + 1) / (double)(h - 1), y);
            if (x1 > x0 && y1 > y0) sum += (x1 - x0) * (y1 - y0) * grid_at(g, h, w, (x0 + x1) / 2, (y0 + y1) / 2);
        }
    return sum;
}

static double line_integral(const float *g, size_t h, size_t w, double x, double y)
{
    double sum = 0;
    for (size_t a = 0; a + 1 < w; a++) {
        double x0 = (double)a / (double)(w - 1), x1 = fmin((double)(a + 1) / (double)(w - 1), x);
        if (x1 > x0) sum += (x1 - x0) * grid_at(g, h, w, (x0 + x1) / 2, y);
    }
    return sum;
}

static size_t place(const float *node, size_t n, double v, double *t)
{
    size_t k = 0;
    *t = 0;
    if (n == 1) return 0;
    while (k + 2 < n && v >= (double)node[k + 1]) k++;
    *t = fmin(fmax((v - (double)node[k]) / ((double)node[k + 1] - (double)node[k]), 0), 1);
    return k;
}

/* Slices and weights at an incidence. */
static void blend(const material *m, double phi, double theta, size_t slice[4], double weight[4])
{
    double a, b;
    size_t p = place(m->phi, m->P, phi, &a), t = place(m->theta, m->T, theta, &b);
    for (size_t k = 0; k < 4; k++) {
        slice[k] = (k / 2 && m->P > 1 ? p + 1 : p) * m->T + t + k % 2;
        weight[k] = (k / 2 ? a : 1 - a) * (k % 2 ? b : 1 - b);
    }
}

static void uniform_of(const material *m, const size_t slice[4], const double weight[4], double x, double y, double s[2])
{
    double below = 0, left = 0, whole = 0;
    for (size_t k = 0; k < 4; k++) {
        const float *g = m->vndf + slice[k] * m->vh * m->vw;
        double w = weight[k] / integral(g, m->vh, m->vw, 1, 1);
        below += w * integral(g, m->vh, m->vw, 1, y);
        left += w * line_integral(g, m->vh, m->vw, x, y);
        whole += w * line_integral(g, m->vh, m->vw, 1, y);
    }
    s[0] = left / whole, s[1] = below;
}

/* u of a half vector of unit length, relative to phi_i of an isotropic material. */
static void square_of(const material *m, const double h[3], double phi_i, double u[2])
{
    double phi = atan2(h[1], h[0]) - (m->P <= 2 ? phi_i : 0);
    u[0] = sqrt(2 * acos(fmin(h[2], 1)) / pi), u[1] = (phi + pi) / (2 * pi);
    u[1] -= floor(u[1]);
}

static void second(const material *m, const double *wi, const double *wo, double *f)
{
    double h[3], length = 0, u[2], s[2], weight[4];
    size_t slice[4];
    for (int k = 0; k < 3; k++) h[k] = wi[k] + wo[k], length += h[k] * h[k];
    for (int k = 0; k < 3; k++) h[k] /= sqrt(length);
    const double theta = acos(fmin(wi[2], 1)), phi = atan2(wi[1], wi[0]);
    square_of(m, h, phi, u);
    blend(m, phi < (double)m->phi[0] ? phi + 2 * pi : phi > (double)m->phi[0] + 2 * pi ? phi - 2 * pi : phi, theta, slice, weight);
    uniform_of(m, slice, weight, u[0], u[1], s);
    const double factor = m->jacobian[0] ? grid_at(m->ndf, m->nh, m->nw, u[0], u[1]) / 4 /
                                               grid_at(m->sigma, m->sh, m->sw, sqrt(2 * theta / pi), (phi + pi) / (2 * pi))
                                         : 1;
    for (size_t c = 0; c < m->C; c++) {
        f[c] = 0;
        for (size_t k = 0; k < 4; k++)
            f[c] += weight[k] * grid_at(m->colour + (slice[k] * m->C + c) * m->H * m->W, m->H, m->W, s[0], s[1]) * factor / wo[2];
    }
}

static void unit(double theta, double phi, double w[3])
{
    w[0] = sin(theta) * cos(phi), w[1] = sin(theta) * sin(phi), w[2] = cos(theta);
}

static int open_bytes(const unsigned char *bytes, size_t n, ff_rgl **r, ff_error *err)
{
    const char *path = ff_test_path("made.bsdf");
    ff_test_write(path, bytes, n);
    return ff_rgl_open(path, r, err) == FF_OK;
}

static void eval_one(const ff_rgl *r, const double wi[3], const double wo[3], double *f, unsigned char *valid)
{
    const double *const w[6] = {wi, wi + 1, wi + 2, wo, wo + 1, wo + 2};
    ff_rgl_eval(r, w, 1, f, 1, valid);
}

/* ---- evaluation ------------------------------------------------------------------------------ */

static void test_evaluator(const char *label, size_t P, int reduction, size_t C, int spectral, int jacobian, double turn)
{
    material m = make(P, reduction, C, spectral);
    for (size_t p = 0; p < P; p++) m.phi[p] = (float)((double)m.phi[p] + turn);
    m.jacobian[0] = (unsigned char)jacobian;
    ff_rgl *r;
    ff_error err = {0};
    if (!FF_CHECK(open_bytes(file_bytes, file_of(&m), &r, &err), "%s: %s", label, err.message)) return;
    const ff_rgl_info info = ff_rgl_about(r);
    FF_CHECK(info.n_channels == C && info.isotropic == (P <= 2) && info.n_phi_i == P && info.n_theta_i == 4 && info.height == 6 &&
                 info.width == 5 && strcmp(info.description, "Made \xC2\xB5 here") == 0,
             "%s: %zu %d %s", label, info.n_channels, info.isotropic, info.description);
    FF_CHECK(strcmp(info.channels[0].name, spectral ? "400.1nm" : "r") == 0, "%s: channel %s", label, info.channels[0].name);
    double worst = 0;
    for (int trial = 0; trial < 400; trial++) {
        double wi[3], wo[3], f[40], expected[40], largest = 0;
        unsigned char valid;
        unit(1.5 * ff_test_uniform(), 2 * pi * ff_test_uniform() - pi, wi);
        unit(1.5 * ff_test_uniform(), 2 * pi * ff_test_uniform() - pi, wo);
        eval_one(r, wi, wo, f, &valid);
        double a[3] = {wi[0], wi[1], wi[2]}, b[3] = {wo[0], wo[1], wo[2]};
        int back = reduction == 2 && wi[1] > 0, x = back || (reduction == 4 && wi[0] > 0),
            y = back || (reduction == 4 && wi[1] > 0);
        if (x) a[0] = -a[0], b[0] = -b[0];
        if (y) a[1] = -a[1], b[1] = -b[1];
        second(&m, a, b, expected);
        for (size_t c = 0; c < C; c++) largest = fmax(largest, fabs(expected[c]));
        for (size_t c = 0; c < C; c++) worst = fmax(worst, fabs(f[c] - expected[c]) / largest);
        FF_CHECK(valid == 1, "%s: trial %d is not valid", label, trial);
    }
    FF_CHECK(worst < 2e-6, "%s: %g from plain integration", label, worst);
    double down[3] = {0, 0.6, -0.8}, up[3] = {0, 0, 1}, f[40];
    unsigned char valid = 1;
    eval_one(r, down, up, f, &valid);
    FF_CHECK(valid == 0 && f[0] == 0, "%s: light from below", label);
    eval_one(r, up, down, f, NULL);
    FF_CHECK(f[0] == 0 && f[C - 1] == 0, "%s: seen from below", label);
    ff_rgl_free(r);
    unmake(&m);
}

static void evaluators(void)
{
    test_evaluator("isotropic rgb", 1, 1, 3, 0, 1, 0);
    test_evaluator("isotropic rgb, two azimuths", 2, 1, 3, 0, 1, 0);
    test_evaluator("isotropic spectral", 1, 1, 7, 1, 1, 0);
    test_evaluator("anisotropic rgb", 5, 1, 3, 0, 1, 0);
    test_evaluator("anisotropic spectral", 9, 1, 4, 1, 1, 0);
    test_evaluator("half a circle", 4, 2, 3, 0, 1, 0);
    test_evaluator("a quarter", 3, 4, 3, 0, 1, 0);
    test_evaluator("no jacobian", 1, 1, 3, 0, 0, 0);
    test_evaluator("azimuths from 0 to 2 pi", 5, 1, 3, 0, 1, pi);
    test_evaluator("azimuths from -2 pi to 0", 5, 1, 3, 0, 1, -pi);
    ff_rgl_free(NULL);
}

/* ---- reading --------------------------------------------------------------------------------- */

static int read_bytes(const unsigned char *bytes, size_t n, const char *grid, ff_table *t, ff_error *err)
{
    const char *path = ff_test_path("read.bsdf");
    ff_test_write(path, bytes, n);
    ff_read_options o;
    ff_read_options_init(&o);
    o.grid = grid;
    return ff_table_read_with_into(path, &o, t, err) == FF_OK;
}

/* Every sample lies where the warp of its node puts it, has the file's own number, and weighs its part of the sphere. */
static void check_samples(const char *label, const material *m, const ff_table *t)
{
    double worst_s = 0, worst_f = 0;
    for (size_t i = 0; i < t->n; i++) {
        const size_t x = i % m->W, y = i / m->W % m->H, slice = i / m->W / m->H, p = slice / m->T, k = slice % m->T;
        double wi[3], wo[3], h[3], length = 0, u[2], s[2];
        unit(t->angle[0][i], t->angle[1][i], wi);
        unit(t->angle[2][i], t->angle[3][i], wo);
        FF_CHECK(t->angle[0][i] == (double)m->theta[k] && t->angle[1][i] == (double)m->phi[p], "%s: incidence of %zu", label, i);
        FF_CHECK(t->valid[i] == (wo[2] > 1e-6), "%s: sample %zu, cos %g, valid %d", label, i, wo[2], t->valid[i]);
        for (int q = 0; q < 3; q++) h[q] = wi[q] + wo[q], length += h[q] * h[q];
        for (int q = 0; q < 3; q++) h[q] /= sqrt(length);
        if (h[2] <= 0 || length < 1e-12) continue; /* m is not in between */
        square_of(m, h, t->angle[1][i], u);
        const size_t slices[4] = {slice, slice, slice, slice};
        const double weight[4] = {1, 0, 0, 0};
        uniform_of(m, slices, weight, u[0], u[1], s);
        if (wo[2] > 1e-3) {
            worst_s = fmax(worst_s, fabs(s[0] - (double)x / (double)(m->W - 1)));
            double dy = fabs(s[1] - (double)y / (double)(m->H - 1));
            if (x > 0) worst_s = fmax(worst_s, fmin(dy, 1 - dy)); /* -pi is pi */
        }
        for (size_t c = 0; c < m->C && t->valid[i] && x > 0; c++) {
            const double sigma = grid_at(m->sigma, m->sh, m->sw, sqrt(2 * t->angle[0][i] / pi), (t->angle[1][i] + pi) / (2 * pi));
            double stored = (double)m->colour[((slice * m->C + c) * m->H + y) * m->W + x];
            double expected = stored * grid_at(m->ndf, m->nh, m->nw, u[0], u[1]) / (4 * sigma) / wo[2];
            worst_f = fmax(worst_f, fabs(t->value[c * t->n + i] - expected) / (fabs(expected) + 1e-9));
        }
    }
    FF_CHECK(worst_s < 2e-6, "%s: samples are %g from their place", label, worst_s);
    FF_CHECK(worst_f < 1e-6, "%s: values differ by %g", label, worst_f);
}

static void check_weights(const char *label, const ff_table *t)
{
    for (size_t i = 0; i < t->n; i++)
        FF_CHECK(t->weight[i] >= 0 && isfinite(t->weight[i]) && (t->valid[i] || t->weight[i] == 0), "%s: weight %zu is %g", label,
                 i, t->weight[i]);
}

/* ---- reflectance ----------------------------------------------------------------------------- */

/* Integral of f cos(theta_o) over the hemisphere by the midpoint rule, per channel, from values of the function alone. It goes over
 * half vectors, which are dense where lobes are: dwo = 4 (wi.m) sin(theta_m) dtheta_m dphi_m, theta_m = pi/2 u^2. */
static void reflectance(const ff_rgl *r, double theta, double phi, int n, double *sum)
{
    const size_t C = ff_rgl_about(r).n_channels;
    const int around = n / 2;
    double wi[3], wo[3], m[3], f[40];
    unit(theta, phi, wi);
    for (size_t c = 0; c < C; c++) sum[c] = 0;
    for (int b = 0; b < around; b++)
        for (int a = 0; a < n; a++) {
            const double u = (a + 0.5) / n, theta_m = pi / 2 * u * u;
            unit(theta_m, phi + 2 * pi * (b + 0.5) / around, m);
            const double along = wi[0] * m[0] + wi[1] * m[1] + wi[2] * m[2];
            for (int k = 0; k < 3; k++) wo[k] = 2 * along * m[k] - wi[k];
            if (along <= 0 || wo[2] <= 1e-6) continue;
            eval_one(r, wi, wo, f, NULL);
            for (size_t c = 0; c < C; c++) sum[c] += f[c] * wo[2] * 4 * along * sin(theta_m) * pi * u / n * 2 * pi / around;
        }
}

/* How far a sum is from the reflectance, relative to the largest of a channel, beyond what halving the steps still changes. */
static double apart(const ff_rgl *r, double theta, double phi, int n, const double *sum, double *uncertain)
{
    const size_t C = ff_rgl_about(r).n_channels;
    double fine[40], coarse[40], largest = 0, worst = 0;
    *uncertain = 0;
    reflectance(r, theta, phi, n, fine);
    reflectance(r, theta, phi, n / 2, coarse);
    for (size_t c = 0; c < C; c++) largest = fmax(largest, fabs(fine[c]));
    for (size_t c = 0; c < C; c++) {
        *uncertain = fmax(*uncertain, fabs(fine[c] - coarse[c]) / largest);
        worst = fmax(worst, fabs(sum[c] - fine[c]) / largest);
    }
    return worst;
}

static void weigh(const ff_rgl *r, size_t p, size_t t, double *mass)
{
    ff_rgl_weights *w = ff_rgl_weights_new(r);
    if (!w) exit(1);
    ff_rgl_weigh(r, w, p, t, mass);
    ff_rgl_weights_free(w);
}

/* ---- the rule of the weights ----------------------------------------------------------------- */

/* A line of half vectors of one azimuth, from the normal to the horizon. */
typedef struct half_line {
    const ff_rgl *r;
    double wi[3], phi_m;
} half_line;

/* The direction that the half vector at u mirrors the light into; returns wi.m. */
static double mirrored(const half_line *l, double u, double wo[3])
{
    double m[3], along = 0;
    unit(pi / 2 * u * u, l->phi_m, m);
    for (int k = 0; k < 3; k++) along += l->wi[k] * m[k];
    for (int k = 0; k < 3; k++) wo[k] = 2 * along * m[k] - l->wi[k];
    return along;
}

/* Adds the integral of f cos(theta_o) dwo over u = lo..hi, a unit of phi_m, times scale: Gauss's rule of three nodes. */
static void add_piece(const half_line *l, double lo, double hi, double scale, double *sum)
{
    static const double node[3] = {-0.7745966692414834, 0, 0.7745966692414834}, weight[3] = {5.0 / 18, 8.0 / 18, 5.0 / 18};
    for (int k = 0; k < 3; k++) {
        const double u = (lo + hi) / 2 + (hi - lo) / 2 * node[k];
        double wo[3], f[40];
        const double along = mirrored(l, u, wo);
        if (wo[2] <= 0) continue;
        eval_one(l->r, l->wi, wo, f, NULL);
        for (size_t c = 0; c < l->r->n_channels; c++)
            sum[c] += scale * (hi - lo) * weight[k] * f[c] * wo[2] * 4 * along * sin(pi / 2 * u * u) * pi * u;
    }
}

static int by_size(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* The u below which a function is less than `value`: it rises. */
static double where(double (*rising)(const void *, double), const void *context, double value)
{
    double lo = 0, hi = 1;
    for (int k = 0; k < 60; k++) *(rising(context, (lo + hi) / 2) < value ? &lo : &hi) = (lo + hi) / 2;
    return (lo + hi) / 2;
}

static double sinking(const void *line, double u)
{
    double wo[3];
    mirrored(line, u, wo);
    return -wo[2];
}

/* A density of the warp, and a row of it. */
typedef struct warped {
    const material *m;
    const float *vndf;
    double v;
} warped;

static double rows_before(const void *context, double v)
{
    const warped *w = context;
    return integral(w->vndf, w->m->vh, w->m->vw, 1, v) / integral(w->vndf, w->m->vh, w->m->vw, 1, 1);
}

static double columns_before(const void *context, double u)
{
    const warped *w = context;
    return line_integral(w->vndf, w->m->vh, w->m->vw, u, w->v) / line_integral(w->vndf, w->m->vh, w->m->vw, 1, w->v);
}

/* Adds a line times scale, from kink to kink: the nodes of the densities, which have the same, the columns of samples, the horizon.
 */
static void add_line(const half_line *l, const warped *w, double scale, double *sum)
{

    const material *m = w->m;
    double kink[256];
    size_t n = 0;
    for (size_t x = 0; x < m->vw; x++) kink[n++] = (double)x / (double)(m->vw - 1);
    for (size_t x = 1; x + 1 < m->W; x++) kink[n++] = where(columns_before, w, (double)x / (double)(m->W - 1));
    kink[n++] = where(sinking, l, 0);
    qsort(kink, n, sizeof *kink, by_size);
    for (size_t k = 0; k + 1 < n; k++) add_piece(l, kink[k], kink[k + 1], scale, sum);
}

/* The reflectance by the rule of the weights, from values of the function alone: between two rows of samples two lines at the nodes
 * of Gauss, each as it is. */
static void reflectance_of_lines(const ff_rgl *r, const material *m, size_t p, size_t k, double *sum)
{
    const double gauss[2] = {0.5 - sqrt(1.0 / 12), 0.5 + sqrt(1.0 / 12)}, rows = (double)(m->H - 1);
    warped w = {m, m->vndf + (p * m->T + k) * m->vh * m->vw, 0};
    half_line l = {.r = r};
    unit(r->theta[k], r->phi[p], l.wi);
    for (size_t c = 0; c < m->C; c++) sum[c] = 0;
    for (size_t line = 0; line < 2 * (m->H - 1); line++) {
        w.v = where(rows_before, &w, ((double)(line / 2) + gauss[line % 2]) / rows);
        l.phi_m = (2 * w.v - 1) * pi + (r->isotropic ? r->phi[p] : 0);
        const double density = line_integral(w.vndf, m->vh, m->vw, 1, w.v) / integral(w.vndf, m->vh, m->vw, 1, 1);
        add_line(&l, &w, 2 * pi / density / (2 * rows), sum);
    }
}

/* The reflectance from values of the function alone: lines between its kinks in azimuth, the rows of either density and of samples,
 * at three nodes of Gauss in each of two parts. */
static void reflectance_between_kinks(const ff_rgl *r, const material *m, size_t p, size_t k, double *sum)
{
    static const double node[3] = {-0.7745966692414834, 0, 0.7745966692414834}, weight[3] = {5.0 / 18, 8.0 / 18, 5.0 / 18};
    enum { PARTS = 2 };
    warped w = {m, m->vndf + (p * m->T + k) * m->vh * m->vw, 0};
    half_line l = {.r = r};
    double kink[64];
    size_t n = 0;
    unit(r->theta[k], r->phi[p], l.wi);
    for (size_t y = 0; y < m->vh; y++) kink[n++] = (double)y / (double)(m->vh - 1);
    for (size_t y = 1; y + 1 < m->nh; y++) kink[n++] = (double)y / (double)(m->nh - 1);
    for (size_t y = 1; y + 1 < m->H; y++) kink[n++] = where(rows_before, &w, (double)y / (double)(m->H - 1));
    qsort(kink, n, sizeof *kink, by_size);
    for (size_t c = 0; c < m->C; c++) sum[c] = 0;
    for (size_t i = 0; i < 3 * PARTS * (n - 1); i++) {
        const size_t part = i / 3 % PARTS, at = i / 3 / PARTS;
        const double wide = (kink[at + 1] - kink[at]) / PARTS;
        w.v = kink[at] + wide * ((double)part + 0.5 + 0.5 * node[i % 3]);
        l.phi_m = (2 * w.v - 1) * pi + (r->isotropic ? r->phi[p] : 0);
        add_line(&l, &w, 2 * pi * wide * weight[i % 3], sum);
    }
}

/* The columns of a grid [rows][width] with `parts` cells for each: the same function. */
static float *with_columns(float *g, size_t rows, size_t *width, size_t parts)
{
    const size_t w = *width, n = (w - 1) * parts + 1;
    float *fine = malloc(rows * n * sizeof *fine);
    if (!fine) exit(1);
    for (size_t y = 0; y < rows; y++)
        for (size_t x = 0; x < n; x++) {
            const size_t a = x / parts < w - 2 ? x / parts : w - 2;
            const double t = (double)(x - a * parts) / (double)parts;
            fine[y * n + x] = (float)((1 - t) * (double)g[y * w + a] + t * (double)g[y * w + a + 1]);
        }
    free(g);
    *width = n;
    return fine;
}

/* The same of its rows: a grid [slices][height][width]. */
static float *with_rows(const float *g, size_t slices, size_t height, size_t width, size_t parts)
{
    const size_t n = (height - 1) * parts + 1;
    float *fine = malloc(slices * n * width * sizeof *fine);
    if (!fine) exit(1);
    for (size_t i = 0; i < slices * n; i++) {
        const size_t y = i % n, a = y / parts < height - 2 ? y / parts : height - 2;
        const double t = (double)(y - a * parts) / (double)parts;
        const float *row = g + (i / n * height + a) * width;
        for (size_t x = 0; x < width; x++) fine[i * width + x] = (float)((1 - t) * (double)row[x] + t * (double)row[width + x]);
    }
    return fine;
}

/* All colours of a node, those below the horizon included, with the shares that they have in the function. */
static void sum_over_colours(const ff_rgl *r, size_t p, size_t k, double *sum)
{
    const size_t n = r->width * r->height, slice = p * r->n_theta + k;
    double *memory = malloc((5 * n + 2 * r->vndf.width) * sizeof *memory);
    if (!memory) exit(1);
    const ff_rgl_slice s = {memory, memory + n, memory + 2 * n, memory + 3 * n};
    double *mass = memory + 4 * n;
    ff_rgl_sample_slice(r, p, k, memory + 5 * n, &s);
    weigh(r, p, k, mass);
    size_t seen = 0;
    while (!(s.factor[seen] > 0)) seen++;
    const double per_density = s.factor[seen] * cos(s.theta_o[seen]) / s.density[seen]; /* 1 / (4 sigma) */
    for (size_t c = 0; c < r->n_channels; c++) {
        sum[c] = 0;
        for (size_t i = 0; i < n; i++)
            sum[c] += mass[i] * per_density *
                      (double)ff_float_of(ff_tensor_data(&r->file, r->colour) + 4 * ((slice * r->n_channels + c) * n + i));
    }
    free(memory);
}

enum { FINER = 16, FINER_ROWS = 32 };

/* Noise in every number: the two lines between rows are a rule that no longer gives the reflectance (it is up to 6 % off, seeds 0
 * to 2), but the sum must still be what the lines are.
 *
 * Along a line the program is off by O(h^4) of the cell h of the warp; m has the same function in cells of 1/7 / FINER. With u^3 q
 * d the integrand, q smooth (|q'| < 3.5, |q''| < 10) and d linear between numbers of 0.5..2 at steps of 1/7 (|d'| < 10.5): where a
 * column cuts a cell, u^3 (g - line through the nodes of Gauss) of g = q d is at most u^3 |g''| h^2 / 12, g'' < 94, and counts by
 * its distance from the cut in columns, at most 7.3 h, times the change of the slope of the colours there, at most 2.4: 69 h^4 with
 * u^3 < 0.5, for three columns 206 h^4; whole cells: h^4 / 4320 times the fourth derivative of the integrand times column (9.8e4)
 * times the slope 1.2: 27 h^4. A line adds up to about 0.04, colours of 0.4 times 0.09 of the densities: 6e3 h^4 of it. Numbers of
 * 32 bits do the rest: the evaluator is 2e-6 from plain integration. */
static void check_mass(const char *label, const ff_rgl *r, const material *m, size_t p, size_t k)
{
    const double h = 1 / (7.0 * FINER), most = 6e3 * pow(h, 4) + 1e-5;
    double sum[40], lines[40], largest = 0, worst = 0;
    sum_over_colours(r, p, k, sum);
    reflectance_of_lines(r, m, p, k, lines);
    for (size_t c = 0; c < m->C; c++) largest = fmax(largest, fabs(lines[c]));
    for (size_t c = 0; c < m->C; c++) worst = fmax(worst, fabs(sum[c] - lines[c]) / largest);
    printf("%s: incidence %zu %zu: sum over colours %.2g from that of the lines\n", label, p, k, worst);
    FF_CHECK(worst < most, "%s: incidence %zu %zu: sum over colours is %g from that of the lines", label, p, k, worst);
}

/* With more rows of samples of the same function the sum becomes the reflectance. Of an interval h of s.y that has a kink in it,
 * the rule of two nodes of Gauss misses at most 0.0223 h^2 times the jump of the slope (its kernel of Peano, largest at the nodes).
 * Kinks are at the inner rows of the densities, at most 14, whose numbers change by less than 0.9 of 0.55 in 1/8: slopes of 13,
 * where a row has half the mean density 26 in s.y, jumps of 52. */
static void check_reflectance(const char *label, const ff_rgl *r, const material *m, size_t p, size_t k)
{
    const double h = 1 / (5.0 * FINER_ROWS), most = 14 * 52 * 0.0223 * h * h;
    double sum[40], whole[40], largest = 0, worst = 0;
    sum_over_colours(r, p, k, sum);
    reflectance_between_kinks(r, m, p, k, whole);
    for (size_t c = 0; c < m->C; c++) largest = fmax(largest, fabs(whole[c]));
    for (size_t c = 0; c < m->C; c++) worst = fmax(worst, fabs(sum[c] - whole[c]) / largest);
    printf("%s: incidence %zu %zu: sum over colours %.2g from the reflectance\n", label, p, k, worst);
    FF_CHECK(worst < most, "%s: incidence %zu %zu: sum over colours is %g from the reflectance", label, p, k, worst);
}

static void check_masses(const char *label, material *m)
{
    ff_rgl *r;
    ff_error err = {0};
    m->vndf = with_columns(m->vndf, m->P * m->T * m->vh, &m->vw, FINER);
    m->ndf = with_columns(m->ndf, m->nh, &m->nw, FINER);
    material rows = *m;
    rows.colour = with_rows(m->colour, m->P * m->T * m->C, m->H, m->W, FINER_ROWS);
    rows.luminance = with_rows(m->luminance, m->P * m->T, m->H, m->W, FINER_ROWS);
    rows.H = (m->H - 1) * FINER_ROWS + 1;
    for (int finer = 0; finer < 2; finer++) {
        if (!FF_CHECK(open_bytes(file_bytes, file_of(finer ? &rows : m), &r, &err), "%s: %s", label, err.message)) break;
        for (size_t k = m->P > 2 ? 1 : 0; k < 4; k++) /* light from the normal has any azimuth */
            (finer ? check_reflectance : check_mass)(label, r, m, m->P > 2 ? 1 : 0, k);
        ff_rgl_free(r);
    }
    free(rows.colour), free(rows.luminance);
}

/* The samples of each incidence, with their weights. */
static double check_sums(const char *label, const ff_table *t, const ff_rgl *r, double most)
{
    const size_t n = r->width * r->height;
    double worst = 0;
    for (size_t slice = 0; slice < r->n_phi * r->n_theta; slice++) {
        const size_t p = slice / r->n_theta, k = slice % r->n_theta;
        double sum[40] = {0}, uncertain;
        if (cos(r->theta[k]) < 1e-6 || (r->n_phi > 1 && (p % 5 != 1 || k % 3 != 2))) continue;
        for (size_t c = 0; c < t->n_channels; c++)
            for (size_t i = slice * n; i < (slice + 1) * n; i++)
                sum[c] += t->valid[i] ? t->value[c * t->n + i] * cos(t->angle[2][i]) * t->weight[i] : 0;
        for (size_t c = 0; c < t->n_channels; c++) sum[c] /= ff_rgl_incidence_weight(r, p, k);
        const double e = apart(r, r->theta[k], r->phi[p], 400, sum, &uncertain);
        FF_CHECK(e < most + uncertain, "%s: at %g degrees samples add up to a reflectance that is %g off (known within %g)", label,
                 r->theta[k] * 180 / pi, e, uncertain);
        worst = fmax(worst, e);
    }
    return worst;
}

/* ---- reading, all of it ---------------------------------------------------------------------- */

static void test_reading(void)
{
    static const struct {
        size_t P, C;
        int reduction, spectral;
    } cases[] = {{1, 3, 1, 0}, {1, 5, 1, 1}, {5, 3, 1, 0}, {4, 4, 2, 1}, {3, 3, 4, 0}};
    for (size_t k = 0; k < sizeof cases / sizeof cases[0]; k++) {
        char label[40];
        snprintf(label, sizeof label, "case %zu", k);
        material m = make(cases[k].P, cases[k].reduction, cases[k].C, cases[k].spectral);
        ff_table t;
        ff_error err = {0};
        if (!FF_CHECK(read_bytes(file_bytes, file_of(&m), NULL, &t, &err), "%s: %s", label, err.message)) continue;
        FF_CHECK(strcmp(t.format, "rgl") == 0 && t.n == m.P * m.T * m.H * m.W && t.n_channels == m.C && t.radians_per_unit == 1 &&
                     t.isotropic == (m.P == 1) && t.quantity == FF_BRDF_COS && t.weight && t.kept,
                 "%s: %zu x %zu", label, t.n, t.n_channels);
        FF_CHECK(t.n_negative > 0 && strstr(t.note, "negative channel") && strstr(t.note, "the file's own") &&
                     strstr(t.note, "Made \\xc2"),
                 "%s: %s", label, t.note);
        FF_CHECK(!strstr(t.note, "symmetry") == (m.reduction == 1), "%s: %s", label, t.note);
        if (m.spectral)
            FF_CHECK(t.channels[1].wavelength_nm == 410.35 && strcmp(t.channels[1].name, "410.35nm") == 0, "%s %.17g",
                     t.channels[1].name, t.channels[1].wavelength_nm);
        check_samples(label, &m, &t);
        check_weights(label, &t);
        check_masses(label, &m);
        ff_table_clear(&t);
        unmake(&m);
    }
}

/* What the file says was not measured; light at 90 degrees; no density of normals. */
static void test_validity(void)
{
    material m = make(1, 1, 3, 0);
    ff_table t;
    ff_error err = {0};
    m.theta[3] = 1.5707963f;
    const size_t at = (1 * m.H + 2) * m.W + 1, black = at + 1, size = m.H * m.W;
    for (size_t c = 0; c < 3; c++) m.colour[(1 * 3 + c) * size + at % size] = m.colour[(1 * 3 + c) * size + black % size] = 0;
    m.luminance[at] = 0, m.luminance[black] = 1e-20f;
    if (FF_CHECK(read_bytes(file_bytes, file_of(&m), NULL, &t, &err), "%s", err.message)) {
        FF_CHECK(!t.valid[at] && t.valid[black] && t.value[black] == 0, "unmeasured and black");
        for (size_t i = 3 * size; i < 4 * size; i++) FF_CHECK(!t.valid[i] && t.value[i] == 0, "light at 90 degrees");
        FF_CHECK(strstr(t.note, "1 samples have no colour") && strstr(t.note, "30 samples of light at 90 degrees"), "%s", t.note);
        ff_table_clear(&t);
    }
    memset(m.ndf, 0, 2 * m.nw * sizeof *m.ndf);
    FF_CHECK(!read_bytes(file_bytes, file_of(&m), NULL, &t, &err) && err.code == FF_ERR_DATA && strstr(err.message, "not measured"),
             "%s", err.message);
    m.ndf[m.nw - 1] = m.ndf[2 * m.nw - 1] = m.ndf[m.nw - 2] = m.ndf[2 * m.nw - 2] = m.ndf[m.nw - 3] = m.ndf[2 * m.nw - 3] = 1;
    if (FF_CHECK(read_bytes(file_bytes, file_of(&m), NULL, &t, &err), "%s", err.message)) {
        FF_CHECK(!t.valid[0] && strstr(t.note, "no density of normals"), "%s", t.note);
        ff_table_clear(&t);
    }
    m.jacobian[0] = 0;
    if (FF_CHECK(read_bytes(file_bytes, file_of(&m), NULL, &t, &err), "%s", err.message)) {
        FF_CHECK(t.valid[0] && strstr(t.note, "not relative") &&
                     fabs(t.value[1] / (double)m.colour[1] * cos(t.angle[2][1]) - 1) < 1e-12,
                 "%s", t.note);
        ff_table_clear(&t);
    }
    unmake(&m);
}

/* ---- grids ----------------------------------------------------------------------------------- */

static void check_grid(const char *label, const material *m, const char *grid, const size_t n[4], double first, double step)
{
    ff_table t;
    ff_error err = {0};
    if (!FF_CHECK(read_bytes(file_bytes, file_of(m), grid, &t, &err), "%s: %s", label, err.message)) return;
    FF_CHECK(t.axes.kind == FF_AXES_INCIDENT_EXIT && t.axes.n[0] == n[0] && t.axes.n[1] == n[1] && t.axes.n[2] == n[2] &&
                 t.axes.n[3] == n[3] && t.axes.node[0][0] == first && t.axes.node[0][1] == first + step && t.axes.node[3][0] == 0,
             "%s: %zu %zu %zu %zu", label, t.axes.n[0], t.axes.n[1], t.axes.n[2], t.axes.n[3]);
    FF_CHECK(t.isotropic == (m->P <= 2) && !t.kept && t.weight && strstr(t.note, grid) && strcmp(t.format, "rgl") == 0, "%s: %s",
             label, t.note);
    double worst = 0, sum = 0;
    for (size_t i = 0; i < t.n; i++) sum += t.weight[i];
    FF_CHECK(fabs(sum / (4 * pi * pi) - 1) < 1e-12, "%s: weights %g", label, sum / (4 * pi * pi));
    for (size_t i = 0; i < t.n; i += 1 + t.n / 500) {
        double wi[3], wo[3], f[8];
        unit(t.angle[0][i] * pi / 180, t.angle[1][i] * pi / 180, wi);
        unit(t.angle[2][i] * pi / 180, t.angle[3][i] * pi / 180, wo);
        if (hypot(wi[0] + wo[0], wi[1] + wo[1]) < 1e-6) continue; /* a normal half vector has any azimuth */
        second(m, wi, wo, f);
        for (size_t c = 0; c < m->C; c++) worst = fmax(worst, fabs(t.value[c * t.n + i] - f[c]) * wo[2]);
    }
    FF_CHECK(worst < 1e-5, "%s: %g", label, worst);
    ff_table_clear(&t);
}

static void test_grids(void)
{
    material iso = make(1, 1, 3, 0), aniso = make(5, 1, 3, 0);
    check_grid("step 15", &iso, "goniometer:15", (size_t[]){6, 1, 6, 24}, 0, 15);
    check_grid("step 22.5", &aniso, "goniometer:22.5", (size_t[]){4, 16, 4, 16}, 0, 22.5);
    check_grid("numbers", &iso, "9x10x12", (size_t[]){9, 1, 10, 12}, 5, 10);
    check_grid("numbers, anisotropic", &aniso, "9x10x6", (size_t[]){9, 6, 10, 6}, 5, 10);
    check_grid("four numbers", &aniso, "9x3x10x6", (size_t[]){9, 3, 10, 6}, 5, 10);
    ff_table t;
    ff_error err = {0};
    if (FF_CHECK(read_bytes(file_bytes, file_of(&iso), "merl", &t, &err), "%s", err.message)) {
        FF_CHECK(t.grid == &ff_grid_merl && t.n == 1458000 && !t.kept && t.isotropic == 1, "merl");
        for (size_t i = 0; i < t.n; i += 40009) {
            double w[6], f[3], *const planes[6] = {w, w + 1, w + 2, w + 3, w + 4, w + 5};
            ff_table_directions(&t, i, 1, planes);
            FF_CHECK(t.valid[i] == (w[2] > 1e-8 && w[5] > 1e-8), "merl: validity of %zu", i);
            if (!t.valid[i]) continue;
            second(&iso, w, w + 3, f);
            FF_CHECK(fabs(t.value[t.n + i] - f[1]) * w[5] < 1e-5, "merl: %zu: %g %g", i, t.value[t.n + i], f[1]);
        }
        ff_table_clear(&t);
    }
    static const struct {
        const char *grid;
        ff_status code;
        const char *word;
    } bad[] = {{"", FF_ERR_SYNTAX, "expected 'merl'"},
               {"utia", FF_ERR_SYNTAX, "'utia'"},
               {"goniometer:", FF_ERR_SYNTAX, "goniometer"},
               {"goniometer:5x", FF_ERR_SYNTAX, "goniometer"},
               {"goniometer:0", FF_ERR_RANGE, "0.25 to 45"},
               {"goniometer:-5", FF_ERR_RANGE, "0.25 to 45"},
               {"goniometer:7", FF_ERR_RANGE, "divides 360"},
               {"goniometer:1e300", FF_ERR_RANGE, "0.25 to 45"},
               {"9x9", FF_ERR_SYNTAX, "'9x9'"},
               {"9x9x9x", FF_ERR_SYNTAX, "expected"},
               {"1x2x3x4x5", FF_ERR_SYNTAX, "expected"},
               {"0x9x9", FF_ERR_RANGE, "at least one"},
               {"99999999999999999999x9x9", FF_ERR_RANGE, "33554432"},
               {"1000x1000x1000", FF_ERR_RANGE, "33554432"}};
    for (size_t k = 0; k < sizeof bad / sizeof bad[0]; k++)
        FF_CHECK(!read_bytes(file_bytes, file_of(&iso), bad[k].grid, &t, &err) && err.code == bad[k].code &&
                     strstr(err.message, bad[k].word),
                 "%s: %d %s", bad[k].grid, err.code, err.message);
    FF_CHECK(!read_bytes(file_bytes, file_of(&aniso), "merl", &t, &err) && err.code == FF_ERR_UNSUPPORTED &&
                 strstr(err.message, "anisotropic"),
             "%s", err.message);
    unmake(&iso);
    unmake(&aniso);
}

/* ---- spoilt files ---------------------------------------------------------------------------- */

static void expect_bad(const char *label, const unsigned char *bytes, size_t n, ff_status code, size_t byte,
                       const char *const *words)
{
    const char *path = ff_test_path("bad.bsdf");
    ff_table t;
    ff_error err = {0};
    memset(&t, 0x5A, sizeof t);
    ff_test_write(path, bytes, n);
    const ff_status status = ff_table_read_into(path, "rgl", &t, &err);
    FF_CHECK(status == code && err.byte == (int64_t)byte && err.line == 0 && strcmp(err.path, path) == 0,
             "%s: %d at byte %lld, expected %d at %zu: %s", label, status, (long long)err.byte, code, byte, err.message);
    for (; *words; words++) FF_CHECK(strstr(err.message, *words), "%s: no '%s' in: %s", label, *words, err.message);
    if (status == FF_OK) ff_table_clear(&t);
}

static unsigned char spoilt[BIG];

/* Fresh copy of the file of m in `spoilt`. */
static size_t fresh(const material *m)
{
    const size_t n = file_of(m);
    memcpy(spoilt, file_bytes, n);
    return n;
}

static void test_container(void)
{
    material m = make(1, 1, 3, 0);
    size_t n = fresh(&m), h = header_at[VNDF], dims = h + 2 + 4; /* number of dimensions; then type, offset, shape */
    spoilt[3] = 'S';
    expect_bad("magic", spoilt, n, FF_ERR_FORMAT, 0, WORDS("'tenSor_file", "expected 'tensor_file'"));
    fresh(&m), spoilt[12] = 2;
    expect_bad("version", spoilt, n, FF_ERR_FORMAT, 12, WORDS("version 2.0", "1.0"));
    fresh(&m), put(spoilt + 14, 0, 4);
    expect_bad("no fields", spoilt, n, FF_ERR_FORMAT, 14, WORDS("0 fields"));
    fresh(&m), put(spoilt + 14, 0xFFFFFFFF, 4);
    expect_bad("many fields", spoilt, n, FF_ERR_FORMAT, 14, WORDS("4294967295 fields", "256"));
    fresh(&m), put(spoilt + h, 0, 2);
    expect_bad("no name", spoilt, n, FF_ERR_FORMAT, h, WORDS("without a name"));
    fresh(&m), put(spoilt + h, 65535, 2);
    expect_bad("long name", spoilt, n, FF_ERR_READ, n, WORDS("the end of the file", "description of a field"));
    fresh(&m), spoilt[h + 3] = 0;
    expect_bad("zero in a name", spoilt, n, FF_ERR_FORMAT, h, WORDS("zero byte"));
    fresh(&m), memcpy(spoilt + h + 2, "rgb\xFF", 4);
    expect_bad("other name", spoilt, n, FF_ERR_FORMAT, 18, WORDS("no field 'vndf'"));
    fresh(&m), memcpy(spoilt + header_at[EXTRA] + 2, "sigma", 5);
    expect_bad("name twice", spoilt, n, FF_ERR_FORMAT, header_at[EXTRA], WORDS("'sigma'", "no field before"));
    fresh(&m), put(spoilt + dims, 17, 2);
    expect_bad("dimensions", spoilt, n, FF_ERR_FORMAT, dims, WORDS("17 dimensions"));
    for (int type = 0; type <= 255; type += type ? 243 / 9 : 1) {
        fresh(&m), spoilt[dims + 2] = (unsigned char)type;
        if (type == 0 || type > 11) expect_bad("type", spoilt, n, FF_ERR_FORMAT, dims + 2, WORDS("the type", "1 (uint8) to 11"));
    }
    fresh(&m), put(spoilt + dims + 3, n - 4, 8);
    expect_bad("offset near the end", spoilt, n, FF_ERR_READ, dims + 3, WORDS("'vndf'", "inside the file"));
    fresh(&m), put(spoilt + dims + 3, UINT64_MAX - 3, 8);
    expect_bad("huge offset", spoilt, n, FF_ERR_READ, dims + 3, WORDS("18446744073709551612"));
    fresh(&m), put(spoilt + dims + 3, 0, 8);
    expect_bad("offset in the header", spoilt, n, FF_ERR_FORMAT, h, WORDS("'vndf' at byte 0", "descriptions end"));
    fresh(&m), put(spoilt + dims + 3, data_at[VNDF] - 8, 8);
    expect_bad("overlap", spoilt, n, FF_ERR_FORMAT, h, WORDS("'vndf'", "the one before"));
    fresh(&m), put(spoilt + dims + 11, (uint64_t)1 << 60, 8);
    expect_bad("2^60 elements", spoilt, n, FF_ERR_FORMAT, dims + 11, WORDS("1152921504606846976", "than the file has bytes"));
    fresh(&m);
    for (size_t k = 0; k < 4; k++) put(spoilt + dims + 11 + 8 * k, (uint64_t)1 << 16, 8);
    expect_bad("a product that overflows", spoilt, n, FF_ERR_FORMAT, dims + 11, WORDS("65536"));
    fresh(&m), put(spoilt + dims + 11, 0, 8);
    expect_bad("nothing", spoilt, n, FF_ERR_FORMAT, header_at[LUMINANCE], WORDS("'luminance'", "or up to 7 bytes later"));
    for (size_t more = 1; more < 40; more += 6) {
        fresh(&m), memset(spoilt + n, 0, more);
        if (more >= 8)
            expect_bad("more bytes", spoilt, n + more, FF_ERR_FORMAT, n, WORDS("after the last field", "end of the file"));
    }
    unmake(&m);
}

/* Changes one field of the description and expects the complaint. */
static void bad_field(const char *label, size_t which, field change, ff_status code, int at_data, const char *const *words)
{
    material m = make(1, 1, 3, 0);
    field f[FIELDS];
    const size_t n_fields = fields_of(&m, f);
    static float zeros[4096];
    if (!change.data) change.data = zeros;
    f[which] = change;
    const size_t n = write_tensors(spoilt, f, n_fields, header_at, data_at);
    expect_bad(label, spoilt, n, code, at_data ? data_at[which] : header_at[which], words);
    unmake(&m);
}

static void bad_number(const char *label, size_t which, size_t element, float v, const char *const *words)
{
    material m = make(1, 1, 3, 0);
    const size_t n = fresh(&m);
    uint32_t bits;
    memcpy(&bits, &v, 4);
    put(spoilt + data_at[which] + 4 * element, bits, 4);
    expect_bad(label, spoilt, n, FF_ERR_DATA, data_at[which] + 4 * element, words);
    unmake(&m);
}

static void content(void)
{
    static const float turning[5] = {-3.14159265f, -2.5f, -2, -1.5f, -1}, half[3] = {0, 1.5f, 3.14159265f};
    bad_field("type of ndf", NDF, (field){"ndf", 5, 2, {2, 8}, NULL}, FF_ERR_FORMAT, 0, WORDS("uint32 [2, 8]", "expected float32"));
    bad_field("ndf of one row", NDF, (field){"ndf", 10, 2, {1, 8}, NULL}, FF_ERR_FORMAT, 0, WORDS("[1, 8]", "2 or more"));
    bad_field("flat ndf", NDF, (field){"ndf", 10, 1, {8}, NULL}, FF_ERR_FORMAT, 0, WORDS("[8]", "of 2 dimensions"));
    bad_field("vndf of other incidences", VNDF, (field){"vndf", 10, 4, {1, 3, 9, 8}, NULL}, FF_ERR_FORMAT, 0,
              WORDS("[1, 3, 9, 8]", "[1, 4, 2 or more"));
    bad_field("vndf of zeros", VNDF, (field){"vndf", 10, 4, {1, 4, 9, 8}, NULL}, FF_ERR_DATA, 1, WORDS("zeros alone"));
    bad_field("four colours", COLOUR, (field){"rgb", 10, 5, {1, 4, 4, 6, 5}, NULL}, FF_ERR_FORMAT, 0,
              WORDS("'rgb'", "[1, 4, 3, 2 or"));
    bad_field("luminance", LUMINANCE, (field){"luminance", 10, 4, {1, 4, 5, 5}, NULL}, FF_ERR_FORMAT, 0, WORDS("5 x 5", "6 x 5"));
    bad_field("jacobian", JACOBIAN, (field){"jacobian", 10, 1, {1}, NULL}, FF_ERR_FORMAT, 0, WORDS("'jacobian'", "uint8"));
    bad_field("an eighth of the circle", PHI, (field){"phi_i", 10, 1, {5}, turning}, FF_ERR_UNSUPPORTED, 1,
              WORDS("-3.14159 to -1", "a quarter from -pi on"));
    bad_field("another half", PHI, (field){"phi_i", 10, 1, {3}, half}, FF_ERR_UNSUPPORTED, 1, WORDS("0 to 3.14159"));
    bad_number("nan colour", COLOUR, 17, NAN, WORDS("element 17", "'rgb'", "nan", "a finite number"));
    bad_number("infinite ndf", NDF, 3, INFINITY, WORDS("element 3", "inf"));
    bad_number("negative vndf", VNDF, 5, -1e-9f, WORDS("-1e-09", ">= 0"));
    bad_number("negative sigma", SIGMA, 0, -1, WORDS("'sigma'", ">= 0"));
    bad_number("theta order", THETA, 2, 0.3f, WORDS("0.3", "increasing"));
    bad_number("theta beyond", THETA, 3, 1.6f, WORDS("1.6", "1.5708"));
    bad_number("nan phi", PHI, 0, NAN, WORDS("'phi_i'"));
    material m = make(1, 1, 4, 1);
    size_t n = fresh(&m);
    spoilt[header_at[THETA] + 8] = 'o';
    expect_bad("no theta_i", spoilt, n, FF_ERR_FORMAT, 18, WORDS("no field 'theta_i'"));
    fresh(&m), put(spoilt + data_at[WAVELENGTHS] + 8, 0, 4);
    expect_bad("wavelengths", spoilt, n, FF_ERR_DATA, data_at[WAVELENGTHS] + 8, WORDS("'wavelengths'", "increasing"));
    unmake(&m);
    FF_CHECK(ff_table_read_into(ff_test_path("none.bsdf"), "rgl", NULL, &(ff_error){0}) == FF_ERR_OPEN, "missing file");
}

/* Every prefix fails; a flipped bit of the descriptions gives an error or a table that can be used. */
static void mutations(void)
{
    material m = make(1, 1, 3, 0);
    const size_t n = fresh(&m);
    const char *path = ff_test_path("cut.bsdf");
    ff_test_write(path, spoilt, n);
    for (size_t k = n; k-- > 0;) {
        ff_table t;
        ff_error err = {0};
        if (truncate(path, (off_t)k) != 0) exit(1);
        const ff_status status = ff_table_read_into(path, "rgl", &t, &err);
        FF_CHECK(status == FF_ERR_READ || status == FF_ERR_FORMAT, "%zu bytes: %d %s", k, status, err.message);
        if (status == FF_OK) ff_table_clear(&t);
    }
    size_t read = 0;
    for (size_t bit = 0; bit < 8 * data_at[PHI]; bit++) {
        ff_table t;
        ff_error err = {0};
        fresh(&m);
        spoilt[bit / 8] = (unsigned char)(spoilt[bit / 8] ^ 1u << bit % 8);
        ff_test_write(path, spoilt, n);
        if (ff_table_read_into(path, "rgl", &t, &err) != FF_OK) {
            FF_CHECK(err.message[0] != 0, "bit %zu: no message", bit);
            continue;
        }
        read++;
        FF_CHECK(t.n == 120 && t.n_channels == 3 && ff_table_write(ff_test_path("flip.bsdf"), NULL, &t, &err) == FF_OK,
                 "bit %zu: %s", bit, err.message);
        ff_table_clear(&t);
    }
    FF_CHECK(read > 0 && read < 8 * data_at[PHI] / 4, "%zu of %zu flipped bits do not matter", read, 8 * data_at[PHI]);
    unmake(&m);
}

/* ---- writing --------------------------------------------------------------------------------- */

static void test_round_trip(size_t P, int reduction, size_t C, int spectral)
{
    material m = make(P, reduction, C, spectral);
    const char *copy = ff_test_path("copy.bsdf");
    ff_table t, back;
    ff_error err = {0};
    size_t n = file_of(&m), written;
    for (size_t c = 0; c < C; c++) m.colour[c * m.H * m.W + 6] = m.colour[c * m.H * m.W + 11] = 0; /* unmeasured; black */
    m.colour[6] = -0.0f;
    m.colour[7] = -0.0f, m.colour[10] = 1e-42f, m.luminance[6] = 0;
    file_of(&m);
    if (!FF_CHECK(read_bytes(file_bytes, n, NULL, &t, &err), "%s", err.message)) return;
    FF_CHECK(ff_table_write(copy, NULL, &t, &err) == FF_OK, "%s", err.message);
    char *bytes = ff_test_slurp(copy, &written);
    FF_CHECK(written == n && memcmp(bytes, file_bytes, n) == 0, "P = %zu, C = %zu: the copy differs", P, C);
    free(bytes);
    /* Changed values come back as 32-bit floats, and nothing else changes. */
    size_t changed = 0;
    for (size_t i = 0; i < t.n; i++) changed += t.valid[i] && i % 3 == 0;
    for (size_t c = 0; c < C; c++)
        for (size_t i = 0; i < t.n; i += 3) t.value[c * t.n + i] = 0.3 * ff_test_uniform() + (double)c;
    for (size_t c = 0; c < C; c++) t.value[c * t.n + 15] = 0; /* black */
    FF_CHECK(t.valid[15] && !t.valid[6] && t.valid[11], "the samples that this is about");
    size_t gone = t.n / 2;
    while (!t.valid[gone]) gone++;
    t.valid[gone] = 0;
    FF_CHECK(ff_table_write(copy, "rgl", &t, &err) == FF_OK && changed > 0, "%s", err.message);
    if (FF_CHECK(ff_table_read_into(copy, NULL, &back, &err) == FF_OK, "%s", err.message)) {
        FF_CHECK(memcmp(t.valid, back.valid, t.n) == 0, "validity");
        check_same_angles("round trip", &t, &back);
        double worst = 0;
        for (size_t c = 0; c < C; c++)
            for (size_t i = 0; i < t.n; i++) {
                const double a = t.value[c * t.n + i], b = back.value[c * t.n + i];
                if (!t.valid[i]) continue;
                if (i % 3 || a == 0)
                    FF_CHECK(a == b, "sample %zu has changed", i);
                else
                    worst = fmax(worst, fabs(b - a) / fabs(a));
            }
        FF_CHECK(worst < 6.1e-8, "changed values differ by %g", worst);
        ff_table_clear(&back);
    }
    /* What cannot be written. */
    const char *never = ff_test_path("never.bsdf");
    t.angle[3][4] += 1e-12;
    FF_CHECK(ff_table_write(never, NULL, &t, &err) == FF_ERR_UNSUPPORTED && strstr(err.message, "other directions"), "%s",
             err.message);
    t.angle[3][4] = 1;
    t.value[t.n + gone + 1] = 1e300, t.valid[gone + 1] = 1;
    FF_CHECK(ff_table_write(never, NULL, &t, &err) != FF_OK && access(never, F_OK) != 0, "too large");
    ff_table_clear(&t);
    if (FF_CHECK(read_bytes(file_bytes, n, NULL, &t, &err), "%s", err.message)) {
        size_t at = 1;
        while (!t.valid[at]) at++;
        t.value[at] = 1e60;
        FF_CHECK(ff_table_write(never, NULL, &t, &err) == FF_ERR_DATA && strstr(err.message, "too large for 32 bits"), "%s",
                 err.message);
        ff_table_clear(&t);
    }
    if (P == 1 && FF_CHECK(read_bytes(file_bytes, n, "9x9x9", &t, &err), "%s", err.message)) {
        FF_CHECK(ff_table_write(never, NULL, &t, &err) == FF_ERR_UNSUPPORTED && strstr(err.message, "resample"), "%s", err.message);
        ff_table_clear(&t);
    }
    FF_CHECK(access(never, F_OK) != 0 && check_leftovers() == 0, "something was left behind");
    unmake(&m);
}

/* A lobe: GGX with its separable masking, F = 1. */
static double lobe(double ax, double ay, const double *wi, const double *wo)
{
    if (wi[2] <= 0 || wo[2] <= 0) return 0;
    double h[3], length = 0;
    for (int k = 0; k < 3; k++) h[k] = wi[k] + wo[k], length += h[k] * h[k];
    for (int k = 0; k < 3; k++) h[k] /= sqrt(length);
    const double e = h[0] * h[0] / ax / ax + h[1] * h[1] / ay / ay + h[2] * h[2], d = 1 / (pi * ax * ay * e * e);
    double g = 1;
    const double *const w[2] = {wi, wo};
    for (int k = 0; k < 2; k++) {
        const double *v = w[k];
        g *= 2 / (1 + sqrt(1 + (ax * ax * v[0] * v[0] + ay * ay * v[1] * v[1]) / v[2] / v[2]));
    }
    return d * g / (4 * wi[2] * wo[2]);
}

static void fill_lobe(double ax, double ay, ff_table *t)
{
    for (size_t i = 0; i < t->n; i++) {
        double w[6], *const planes[6] = {w, w + 1, w + 2, w + 3, w + 4, w + 5};
        ff_table_directions(t, i, 1, planes);
        for (size_t c = 0; c < t->n_channels; c++) t->value[c * t->n + i] = (double)(c + 1) * lobe(ax, ay, w, w + 3);
    }
}

static void check_parts(const char *label, const ff_table *t, size_t incidence);
static double check_horizon(const char *label, const ff_rgl *r, double ax, double ay);

/* Through a layout and a file: at the samples to float precision, between them as the worst and the mean say. Returns the error
 * near the horizon, INFINITY where there was no file. */
static double test_layout(const char *label, const ff_table *from, const char *grid, double ax, double ay, double mean_most)
{
    const ff_format *rgl = ff_format_find("rgl");
    const char *path = ff_test_path("lobe.bsdf");
    ff_table t, back;
    ff_rgl *r;
    ff_error err = {0};
    if (!FF_CHECK(rgl->layout(from, grid, &t, &err) == FF_OK, "%s: %s", label, err.message)) return INFINITY;
    for (size_t i = 0; i < t.n; i++) FF_CHECK(t.valid[i] == 1 && t.value[i] == 0, "%s: an empty table", label);
    check_parts(label, &t, 2);
    fill_lobe(ax, ay, &t);
    FF_CHECK(ff_table_write(path, NULL, &t, &err) == FF_OK, "%s: %s", label, err.message);
    if (!FF_CHECK(ff_table_read_into(path, NULL, &back, &err) == FF_OK, "%s: %s", label, err.message)) return INFINITY;
    check_same_angles(label, &t, &back);
    size_t above = 0;
    double worst = 0, covered = 0;
    for (size_t i = 0; i < t.n; i++) {
        const int up = cos(t.angle[2][i]) > 1e-6;
        FF_CHECK(back.valid[i] == up, "%s: validity of %zu", label, i);
        above += (size_t)up;
        covered += t.weight[i];
        for (size_t c = 0; c < t.n_channels && up; c++)
            worst = fmax(worst, fabs(back.value[c * t.n + i] / t.value[c * t.n + i] - 1));
    }
    FF_CHECK(worst < 6.1e-8, "%s: samples differ by %g", label, worst);
    /* Near the horizon a part goes to the colours below it, which are 0. */
    FF_CHECK(above > 0.8 * (double)t.n && fabs(covered / (4 * pi * pi) - 1) < 0.03, "%s: %zu of %zu above the horizon, weights %g",
             label, above, t.n, covered / (4 * pi * pi));
    if (!FF_CHECK(ff_rgl_open(path, &r, &err) == FF_OK, "%s: %s", label, err.message)) return INFINITY;
    const double at_horizon = check_horizon(label, r, ax, ay);
    check_weights(label, &back);
    printf("%s: samples add up to reflectances within %.2g\n", label, check_sums(label, &back, r, 1e-3));
    double between = 0, mean = 0;
    enum { TRIALS = 20000 };
    for (int k = 0; k < TRIALS; k++) {
        double wi[3], wo[3], f[40];
        unit(70 * pi / 180 * ff_test_uniform(), 2 * pi * ff_test_uniform(), wi);
        unit(70 * pi / 180 * ff_test_uniform(), 2 * pi * ff_test_uniform(), wo);
        eval_one(r, wi, wo, f, NULL);
        const double e = fabs(f[0] / lobe(ax, ay, wi, wo) - 1);
        between = fmax(between, e);
        mean += e / TRIALS;
    }
    printf("%s: %zu samples; between them, up to 70 degrees, %.3g relative at worst, %.3g in the mean\n", label, t.n, between,
           mean);
    FF_CHECK(mean < mean_most, "%s: %g in the mean between samples", label, mean);
    ff_rgl_free(r);
    ff_table_clear(&back);
    ff_table_clear(&t);
    return at_horizon;
}

/* Each cell of a layout has the same part of the visible normals: (H-1) (W-1) times its solid angle times ndf / (4 sigma) is 1. */
static void check_parts(const char *label, const ff_table *t, size_t incidence)
{
    const ff_rgl *r = t->kept;
    const size_t n = r->width * r->height;
    double *memory = malloc((5 * n + 2 * r->vndf.width) * sizeof *memory), mean = 0, square = 0, count = 0, widest = 0;
    if (!memory) exit(1);
    const ff_rgl_slice s = {memory, memory + n, memory + 2 * n, memory + 3 * n};
    double *mass = memory + 4 * n;
    ff_rgl_sample_slice(r, 0, incidence, memory + 5 * n, &s);
    weigh(r, 0, incidence, mass);
    for (size_t y = 1; y + 1 < r->height; y++)
        for (size_t x = 1; x + 1 < r->width; x++) {
            const size_t i = y * r->width + x;
            if (s.factor[i + 1] <= 0) continue;
            const double part =
                (double)((r->width - 1) * (r->height - 1)) * mass[i] / s.density[i] * s.factor[i] * cos(s.theta_o[i]);
            mean += part, square += part * part, count++;
        }
    for (size_t i = 0; i < n; i++) widest = s.factor[i] > 0 ? fmax(widest, s.theta_o[i]) : widest;
    mean /= count;
    const double spread = sqrt(square / count - mean * mean);
    FF_CHECK(fabs(mean - 1) < 0.05 && spread < 0.2, "%s: parts of %g +- %g", label, mean, spread);
    FF_CHECK(widest > 70 * pi / 180, "%s: samples up to %g degrees", label, widest * 180 / pi);
    free(memory);
}

/* Near the horizon the function goes on instead of falling to what lies below: nowhere to less than half. Returns how far it is
 * off in the mean. */
static double check_horizon(const char *label, const ff_rgl *r, double ax, double ay)
{
    enum { ELEVATIONS = 20, AZIMUTHS = 180 };
    double mean = 0;
    int fallen = 0;
    for (int k = 0; k < ELEVATIONS * AZIMUTHS; k++) {
        double wi[3], wo[3], f[40];
        unit(40 * pi / 180, 0.3, wi);
        unit((84 + 5 * (k / AZIMUTHS + 0.5) / ELEVATIONS) * pi / 180, 2 * pi * (k % AZIMUTHS + 0.5) / AZIMUTHS, wo);
        eval_one(r, wi, wo, f, NULL);
        mean += fabs(f[0] / lobe(ax, ay, wi, wo) - 1) / (ELEVATIONS * AZIMUTHS);
        fallen += f[0] < lobe(ax, ay, wi, wo) / 2;
    }
    printf("%s: %.3g in the mean near the horizon, %d directions fallen\n", label, mean, fallen);
    FF_CHECK(fallen == 0, "%s: %d directions fallen", label, fallen);
    return mean;
}

/* A table to lay out for: pairs of directions all over. */
static void scattered(double ax, double ay, size_t n_channels, ff_table *t)
{
    ff_error err;
    if (ff_table_init(20000, n_channels, NULL, 0, 0, t, &err) != FF_OK) exit(1);
    for (size_t i = 0; i < t->n; i++)
        for (int k = 0; k < 4; k++) t->angle[k][i] = (k % 2 ? 2 * pi : pi / 2) * ff_test_uniform();
    t->isotropic = ax == ay;
    fill_lobe(ax, ay, t);
}

static void layouts(void)
{
    const ff_format *rgl = ff_format_find("rgl");
    ff_table t, out;
    ff_error err = {0};
    scattered(0.3, 0.3, 3, &t);
    const double near = test_layout("ggx 0.3", &t, NULL, 0.3, 0.3, 0.05),
                 nearer = test_layout("ggx 0.3, 24x64", &t, "24x64", 0.3, 0.3, 0.01);
    FF_CHECK(near < 0.25 && nearer < near / 2, "%g near the horizon, %g on a finer grid", near, nearer);
    static const struct {
        const char *grid;
        ff_status code;
        const char *word;
    } bad[] = {{"", FF_ERR_SYNTAX, "expected 'TxR'"}, {"8", FF_ERR_SYNTAX, "'8'"},
               {"8x", FF_ERR_SYNTAX, "'8x'"},         {"8x32x", FF_ERR_SYNTAX, "'8x32x'"},
               {"1x8x9x9", FF_ERR_SYNTAX, "'1x8"},    {"axb", FF_ERR_SYNTAX, "'axb'"},
               {"1x32", FF_ERR_RANGE, "2 to 512"},    {"8x1", FF_ERR_RANGE, "2 to 512"},
               {"5x8x32", FF_ERR_RANGE, "1 azimuth"}, {"8x99999999999999999999", FF_ERR_RANGE, "2 to 512"},
               {"512x512", FF_ERR_RANGE, "268435456"}};
    for (size_t k = 0; k < sizeof bad / sizeof bad[0]; k++) {
        const ff_status status = rgl->layout(&t, bad[k].grid, &out, &err);
        FF_CHECK(status == bad[k].code && strstr(err.message, bad[k].word), "%s: %d %s", bad[k].grid, status, err.message);
    }
    if (FF_CHECK(rgl->layout(&t, "4x3", &out, &err) == FF_OK, "%s", err.message)) {
        const char *path = ff_test_path("black.bsdf");
        ff_table black;
        FF_CHECK(ff_table_write(path, NULL, &out, &err) == FF_OK, "zeros: %s", err.message);
        ff_table_clear(&out);
        if (FF_CHECK(ff_table_read_into(path, NULL, &black, &err) == FF_OK, "black: %s", err.message)) {
            FF_CHECK(black.n == 36 && black.n_invalid < 20 && black.valid[0] && black.value[0] == 0, "%zu invalid",
                     black.n_invalid);
            ff_table_clear(&black);
        }
    }
    for (size_t i = 0; i < t.n; i++) t.value[i] = t.value[t.n + i] = t.value[2 * t.n + i] *= t.value[i] > 0.5;
    if (FF_CHECK(rgl->layout(&t, NULL, &out, &err) == FF_OK, "%s", err.message)) {
        check_parts("nothing beside the lobe", &out, 0);
        ff_table_clear(&out);
    }
    ff_table_clear(&t);

    scattered(0.25, 0.5, 1, &t);
    /* what is linear between nodes is off by the square of their distance: a quarter on half of it */
    const double coarse = test_layout("anisotropic ggx 0.25, 0.5, 17x10x32", &t, "17x10x32", 0.25, 0.5, 0.05),
                 fine = test_layout("anisotropic ggx 0.25, 0.5, 33x20x64", &t, "33x20x64", 0.25, 0.5, 0.02);
    FF_CHECK(fine < 0.1 && coarse < 4 * 0.1 && fine < coarse / 2, "%g near the horizon, %g on a grid twice as fine", coarse, fine);
    FF_CHECK(rgl->layout(&t, "2x8x32", &out, &err) == FF_ERR_RANGE && strstr(err.message, "3 to 512 azimuths"), "%s", err.message);
    ff_table_clear(&t);

    scattered(0.4, 0.4, 4, &t);
    FF_CHECK(rgl->layout(&t, NULL, &out, &err) == FF_ERR_UNSUPPORTED && strstr(err.message, "4 channels"), "%s", err.message);
    for (size_t c = 0; c < 4; c++) t.channels[c].wavelength_nm = 400 + 50.5 * (double)c;
    const double four = test_layout("four wavelengths", &t, "8x32", 0.4, 0.4, 0.05);
    FF_CHECK(four < 0.25, "%g near the horizon", four);
    if (FF_CHECK(rgl->layout(&t, "8x32", &out, &err) == FF_OK, "%s", err.message)) {
        FF_CHECK(out.n_channels == 4 && strcmp(out.channels[1].name, "450.5nm") == 0 && out.channels[3].wavelength_nm == 551.5,
                 "%s", out.channels[1].name);
        ff_table_clear(&out);
    }
    t.channels[2].wavelength_nm = 410;
    FF_CHECK(rgl->layout(&t, NULL, &out, &err) == FF_ERR_UNSUPPORTED && strstr(err.message, "increasing"), "%s", err.message);
    for (size_t i = 0; i < t.n; i++) t.angle[0][i] = (double)(10 * (1 + i % 5)) * pi / 180;
    for (size_t c = 0; c < 4; c++) t.channels[c].wavelength_nm = 400 + 50 * (double)c;
    if (FF_CHECK(rgl->layout(&t, NULL, &out, &err) == FF_OK, "%s", err.message)) {
        FF_CHECK(out.n == 5 * 32 * 32 && fabs(out.angle[0][2 * 1024] - pi / 6) < 1e-6, "incidences of the table: %zu", out.n);
        ff_table_clear(&out);
    }
    ff_table_clear(&t);
}

/* Mean over the azimuths of incidence of the function's own reflectance, and their range, of the mean of the channels. */
static double mean_reflectance(const ff_rgl *r, size_t theta, double range[2])
{
    double sum = 0, weight = 0, one[40];
    range[0] = INFINITY, range[1] = -INFINITY;
    for (size_t p = 0; p < r->n_phi; p++) {
        const double w = ff_rgl_incidence_weight(r, p, theta);
        reflectance(r, r->theta[theta], r->phi[p], 300, one);
        const double mean = (one[0] + one[1] + one[2]) / 3;
        sum += w * mean, weight += w;
        range[0] = fmin(range[0], mean), range[1] = fmax(range[1], mean);
    }
    return sum / weight;
}

static void check_surveyed(const char *label, const ff_table *t, const ff_rgl *r)
{
    ff_survey s;
    if (!FF_CHECK(ff_survey_init(t, &s, NULL) == FF_OK && s.n_reflectances == r->n_theta, "%s: no survey", label)) return;
    for (size_t k = 0; k < s.n_reflectances; k++) {
        double range[2];
        const double expected = mean_reflectance(r, k, range), *found = s.over_azimuths[k];
        double mean = 0;
        for (size_t c = 0; c < t->n_channels; c++) mean += s.albedo[k * t->n_channels + c] / (double)t->n_channels;
        FF_CHECK(fabs(mean - expected) < 0.002 + 0.005 * expected, "%s: at %g degrees %g, expected %g", label,
                 s.reflectance[k].theta_i, mean, expected);
        FF_CHECK(s.azimuths_of[k] == r->n_phi && isnan(s.reflectance[k].phi_i), "%s: %zu azimuths", label, s.azimuths_of[k]);
        FF_CHECK(fabs(found[0] - range[0]) < 0.01 && fabs(found[1] - range[1]) < 0.01, "%s: %g to %g, expected %g to %g", label,
                 found[0], found[1], range[0], range[1]);
    }
    ff_survey_clear(&s);
}

/* `info` of an anisotropic file, which has several azimuths for each angle of incidence; of channels that were made of others; and
 * with a narrow peak, between whose samples regression finds another reflectance. */
static void surveys(void)
{
    const ff_format *rgl = ff_format_find("rgl");
    const char *path = ff_test_path("survey.bsdf");
    ff_table t, made, mean;
    ff_rgl *r;
    ff_error err = {0};
    scattered(0.03, 0.06, 3, &t);
    if (!FF_CHECK(rgl->layout(&t, "9x6x32", &made, &err) == FF_OK, "%s", err.message)) exit(1);
    fill_lobe(0.03, 0.06, &made);
    FF_CHECK(ff_table_write(path, NULL, &made, &err) == FF_OK, "%s", err.message);
    ff_table_clear(&made);
    ff_table_clear(&t);
    if (!FF_CHECK(ff_table_read_into(path, NULL, &t, &err) == FF_OK && ff_rgl_open(path, &r, &err) == FF_OK, "%s", err.message))
        exit(1);
    check_surveyed("as it is", &t, r);
    if (FF_CHECK(ff_table_reduce_into(&t, "mean", &mean, &err) == FF_OK, "%s", err.message)) {
        check_surveyed("mean", &mean, r);
        ff_table_clear(&mean);
    }
    ff_rgl_free(r);
    ff_table_clear(&t);
}

/* ---- real files ------------------------------------------------------------------------------ */

static const char *data_dir(void)
{
    const char *set = getenv("FACETFIT_DATA");
    return set ? set : FF_SOURCE_DIR "/../shared/data";
}

static void test_real_file(const char *path)
{
    ff_table t;
    ff_error err = {0};
    if (!FF_CHECK(ff_table_read_into(path, NULL, &t, &err) == FF_OK, "%s: %s", path, err.message)) return;
    FF_CHECK(strcmp(t.format, "rgl") == 0 && t.n == 8192 && t.n_channels == 3 && t.isotropic == 1 && t.n_invalid > 1024 &&
                 t.n_invalid < 2500,
             "%s: %zu x %zu, %zu invalid", path, t.n, t.n_channels, t.n_invalid);
    size_t n, written;
    const char *copy = ff_test_path("real.bsdf");
    char *bytes = ff_test_slurp(path, &n);
    FF_CHECK(ff_table_write(copy, NULL, &t, &err) == FF_OK, "%s: %s", path, err.message);
    char *again = ff_test_slurp(copy, &written);
    FF_CHECK(n == written && memcmp(bytes, again, n) == 0, "%s: the copy differs", path);
    /* Sample against function: they meet at the samples. */
    ff_rgl *r;
    if (FF_CHECK(ff_rgl_open(path, &r, &err) == FF_OK, "%s: %s", path, err.message)) {
        double worst = 0;
        for (size_t i = 0; i < t.n; i++) {
            double w[6], f[3], largest = 1e-6, *const planes[6] = {w, w + 1, w + 2, w + 3, w + 4, w + 5};
            if (!t.valid[i] || i % 32 == 0 || i / 32 % 31 == 0)
                continue; /* several samples share the mirror direction, and two pi */
            ff_table_directions(&t, i, 1, planes);
            eval_one(r, w, w + 3, f, NULL);
            for (size_t c = 0; c < 3; c++) largest = fmax(largest, fabs(t.value[c * t.n + i]));
            for (size_t c = 0; c < 3; c++) worst = fmax(worst, fabs(f[c] - t.value[c * t.n + i]) / largest);
        }
        FF_CHECK(worst < 1e-2, "%s: samples and function differ by %g", path, worst);
        ff_rgl_free(r);
    }
    free(bytes);
    free(again);
    ff_table_clear(&t);
}

/* The loader's albedos were made by a sum over 0.5 x 1 degrees, too coarse for the sharp lobes: repeated, not improved. */
static void albedo_of(const ff_rgl *r, double theta, double sum[3])
{
    double wi[3], wo[3], f[3];
    unit(theta, 0, wi);
    sum[0] = sum[1] = sum[2] = 0;
    for (int a = 0; a < 180; a++)
        for (int b = 0; b < 360; b++) {
            unit((a + 0.5) * pi / 360, (b + 0.5) * pi / 180, wo);
            eval_one(r, wi, wo, f, NULL);
            for (int c = 0; c < 3; c++) sum[c] += fmax(f[c], 0) * wo[2] * sqrt(1 - wo[2] * wo[2]) * pi / 360 * pi / 180;
        }
}

static int test_real(void)
{
    char path[700], line[256];
    snprintf(path, sizeof path, "%s/rgl/rgl_reference_values.txt", data_dir());
    FILE *reference = fopen(path, "r");
    if (!reference) return 0;
    ff_rgl *r = NULL;
    ff_error err = {0};
    int files = 0, values = 0, albedos = 0;
    double worst = 0, worst_albedo = 0;
    while (fgets(line, sizeof line, reference)) {
        double a[4], v[3];
        line[strcspn(line, "\n")] = '\0';
        if (line[0] != '#' && line[0] != ' ') {
            ff_rgl_free(r);
            r = NULL;
            snprintf(path, sizeof path, "%s/rgl/%s", data_dir(), line);
            test_real_file(path);
            if (!FF_CHECK(ff_rgl_open(path, &r, &err) == FF_OK, "%s: %s", path, err.message)) break;
            files++;
        } else if (sscanf(line, " wi(%lf,%lf) wo(%lf,%lf): %lf %lf %lf", a, a + 1, a + 2, a + 3, v, v + 1, v + 2) == 7) {
            double wi[3], wo[3], f[3];
            unit(a[0] * pi / 180, a[1] * pi / 180, wi);
            unit(a[2] * pi / 180, a[3] * pi / 180, wo);
            eval_one(r, wi, wo, f, NULL);
            for (int c = 0; c < 3; c++, values++) {
                const double e = fabs(fmax(f[c], 0) * wo[2] - v[c]) / fmax(v[c], 1e-9);
                FF_CHECK(e < 5.1e-6, "%s: %s: channel %d is %.8g", path, line, c, f[c] * wo[2]);
                worst = fmax(worst, e);
            }
        } else if (sscanf(line, " albedo(theta_i=%lf; integral of eval() dw, eval already has cos_o) %lf %lf %lf", a, v, v + 1,
                          v + 2) == 4) {
            double sum[3];
            albedo_of(r, a[0] * pi / 180, sum);
            for (int c = 0; c < 3; c++, albedos++) {
                worst_albedo = fmax(worst_albedo, fabs(sum[c] - v[c]));
                FF_CHECK(fabs(sum[c] - v[c]) < 0.9e-4, "%s: %s: channel %d is %.6f", path, line, c, sum[c]);
            }
        }
    }
    fclose(reference);
    ff_rgl_free(r);
    FF_CHECK(files == 10 && values == 210 && albedos == 150, "%d files, %d values, %d albedos", files, values, albedos);
    printf("%d files: %d values within %.2g relative of the loader's, %d albedos within %.2g\n", files, values, worst, albedos,
           worst_albedo);
    return 1;
}

/* With negative values as 0 they are what the loader's f cos(theta_o) adds up to. */
static void check_raised(const char *path, const ff_rgl *r, const ff_reflectance *at, const double *raised)
{
    double sum[3] = {0}, wi[3], wo[3], m[3], f[3];
    const int n = 400, around = 200;
    unit(at->theta_i * pi / 180, at->phi_i * pi / 180, wi);
    for (int k = 0; k < n * around; k++) {
        const double u = (k % n + 0.5) / n, theta_m = pi / 2 * u * u;
        unit(theta_m, at->phi_i * pi / 180 + 2 * pi * (k / n + 0.5) / around, m);
        const double along = wi[0] * m[0] + wi[1] * m[1] + wi[2] * m[2];
        for (int j = 0; j < 3; j++) wo[j] = 2 * along * m[j] - wi[j];
        if (along <= 0 || wo[2] <= 1e-6) continue;
        eval_one(r, wi, wo, f, NULL);
        for (int c = 0; c < 3; c++) sum[c] += fmax(f[c], 0) * wo[2] * 4 * along * sin(theta_m) * pi * u / n * 2 * pi / around;
    }
    for (int c = 0; c < 3; c++)
        FF_CHECK(fabs(raised[c] - sum[c]) < fmax(0.002, 0.02 * sum[c]), "%s: at %g degrees, channel %d: %g, the loader's %g", path,
                 at->theta_i, c, raised[c], sum[c]);
}

/* `info` has the same reflectances. */
static void check_survey(const char *path, const ff_table *t, const ff_rgl *r)
{
    ff_survey v;
    ff_error err = {0};
    if (!FF_CHECK(ff_survey_init(t, &v, &err) == FF_OK, "%s: %s", path, err.message)) return;
    FF_CHECK(v.n_reflectances >= 6, "%s: %zu incidences", path, v.n_reflectances);
    for (size_t k = 0; k < v.n_reflectances; k++) {
        double uncertain;
        const double theta = v.reflectance[k].theta_i * pi / 180;
        const double e = apart(r, theta, v.reflectance[k].phi_i * pi / 180, 400, v.albedo + k * t->n_channels, &uncertain);
        FF_CHECK(e < 1e-3 + uncertain, "%s: at %g degrees the survey's reflectance is %g off", path, v.reflectance[k].theta_i, e);
        check_raised(path, r, &v.reflectance[k], v.albedo_raised + k * t->n_channels);
    }
    ff_survey_clear(&v);
}

static int test_reflectances(void)
{
    char path[700];
    snprintf(path, sizeof path, "%s/rgl", data_dir());
    DIR *dir = opendir(path);
    int files = 0;
    double worst = 0;
    for (const struct dirent *e; dir && (e = readdir(dir));) {
        const char *dot = strrchr(e->d_name, '.');
        ff_table t;
        ff_rgl *r;
        ff_error err = {0};
        if (!dot || strcmp(dot, ".bsdf") != 0) continue;
        snprintf(path, sizeof path, "%s/rgl/%s", data_dir(), e->d_name);
        if (!FF_CHECK(ff_table_read_into(path, NULL, &t, &err) == FF_OK && ff_rgl_open(path, &r, &err) == FF_OK, "%s", err.message))
            continue;
        check_weights(path, &t);
        worst = fmax(worst, check_sums(path, &t, r, 1e-3));
        check_survey(path, &t, r);
        ff_rgl_free(r);
        ff_table_clear(&t);
        files++;
    }
    if (dir) closedir(dir);
    printf("%d files: samples add up to reflectances within %.2g of the largest channel\n", files, worst);
    return files;
}

/* ---- corpus ---------------------------------------------------------------------------------- */

static void shrink(material *m)
{
    m->T = 2, m->H = 3, m->W = 3, m->vh = 3, m->vw = 4, m->nw = 3, m->sw = 3;
}

static void write_corpus(const char *dir)
{
    char path[600];
    static const struct {
        const char *name;
        size_t P, C;
        int reduction, spectral, cut, bad;
    } all[] = {{"rgb", 1, 3, 1, 0, 0, 0},     {"spectral", 1, 2, 1, 1, 0, 0}, {"anisotropic", 3, 3, 1, 0, 0, 0},
               {"quarter", 3, 1, 4, 1, 0, 0}, {"cut", 1, 3, 1, 0, 37, 0},     {"claims", 1, 3, 1, 0, 0, 1}};
    for (size_t k = 0; k < sizeof all / sizeof all[0]; k++) {
        material m = make(all[k].P, all[k].reduction, all[k].C, all[k].spectral);
        shrink(&m);
        const size_t n = file_of(&m);
        if (all[k].bad) put(file_bytes + header_at[COLOUR] + 2 + 3 + 11, (uint64_t)1 << 60, 8);
        snprintf(path, sizeof path, "%s/%s.bsdf", dir, all[k].name);
        ff_test_write(path, file_bytes, n - (size_t)all[k].cut);
        unmake(&m);
    }
}

static void round_trips(void)
{
    test_round_trip(1, 1, 3, 0);
    test_round_trip(1, 1, 5, 1);
    test_round_trip(5, 1, 3, 0);
    test_round_trip(3, 4, 2, 1);
}

static void reflectances(void)
{
    if (!test_reflectances()) FF_SKIP("no files in %s/rgl", data_dir());
}

static void measured(void)
{
    if (!test_real()) FF_SKIP("no rgl_reference_values.txt in %s/rgl", data_dir());
}

static const ff_test_case cases[] = {FF_TEST(evaluators),     FF_TEST(test_reading), FF_TEST(test_validity), FF_TEST(test_grids),
                                     FF_TEST(test_container), FF_TEST(content),      FF_TEST(mutations),     FF_TEST(round_trips),
                                     FF_TEST(layouts),        FF_TEST(surveys),      FF_TEST(reflectances),  FF_TEST(measured)};

int main(int argc, char **argv)
{
    if (argc == 3 && strcmp(argv[1], "--corpus") == 0) {
        write_corpus(argv[2]);
        return 0;
    }
    return ff_test_main(cases, sizeof cases / sizeof *cases, argc, argv);
}
