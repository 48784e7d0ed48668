/* A file of the RGL format for a table that was not read from one.
 *
 * The format writes f cos(theta_o) = colour ndf / (4 sigma): any positive ndf will do, since the colour takes up what it leaves.
 * What the ndf decides is where the samples lie, since they follow the density of visible normals. So it is estimated from the
 * table.
 *
 *     shape = mean of 4 f cos(theta_i) cos(theta_o), which is D F G of a microfacet model
 *     ndf = 0.9 shape / area(shape) + 0.1 / pi
 *     sigma(wi) = integral of ndf max(wi.m, 0) over the hemisphere of m
 *     vndf(u; wi) = ndf(u) max(wi.m, 0) u sin(theta_m), with the sum 1
 *
 * The mean is over the pairs whose half vector falls into one of 128 rings, away from grazing; a negative mean counts as 0, empty
 * rings are interpolated. In an anisotropic table there are 32 x 32 cells, drawn towards the ring where they have few pairs. The
 * area of D is the integral of D cos(theta_m); the second term sends a tenth of the samples everywhere, so that no direction is
 * without.
 *
 * Nodes of theta_i are those of the table where they are few, else 8, spaced as in the database: 86 degrees (k/7)^0.6. Those of
 * phi_i are -pi..pi, both ends included: the database's own loader knows no other. */
#include "internal_rgl.h"
#include "base/internal_input.h"
#include "base/internal_order.h"
#include <math.h>
#include <stdlib.h>

static const double pi = 3.14159265358979323846;

enum { RINGS = 128, CELLS = 32, VNDF = 128, SIGMA_PHI = 33, SIGMA_THETA = 128 };
enum { THETA_USUAL = 8, PHI_USUAL = 9, RES_USUAL = 32, INCIDENCES_MOST = 4096, NODES_MOST = 512 };
static const double numbers_most = 1 << 28;

/* ---- sizes ----------------------------------------------------------------------------------- */

typedef struct sizes {
    int isotropic, spectral;
    size_t n_phi, n_theta, res, n_colours;
    double *theta; /* [n_theta] */
} sizes;

/* "TxR" or "PxTxR". */
static ff_status parse(const char *text, sizes *z, ff_error *err)
{
    size_t n[3] = {0}, count = 0;
    char quoted[FF_QUOTE];
    const char *at = text;
    for (int more = 1; more && count < 3; more = *at == 'x', at += more) {
        const char *begin = at;
        for (; *at >= '0' && *at <= '9'; at++) n[count] = n[count] < 100000 ? 10 * n[count] + (size_t)(*at - '0') : n[count];
        if (at == begin) break;
        count++;
    }
    if (*at || count < 2 || at[-1] == 'x')
        return ff_error_set(
            err, FF_ERR_SYNTAX, NULL, 0, -1,
            "found the grid %s, expected 'TxR' or 'PxTxR': azimuths and polar angles of incidence, and R x R samples for "
            "each",
            ff_quote(text, strlen(text), quoted));
    if (count == 3) z->n_phi = n[0];
    z->n_theta = n[count - 2], z->res = n[count - 1];
    const int phi_ok = z->isotropic ? z->n_phi == 1 : z->n_phi >= 3 && z->n_phi <= NODES_MOST;
    if (phi_ok && z->n_theta >= 2 && z->n_theta <= NODES_MOST && z->res >= 2 && z->res <= NODES_MOST) return FF_OK;
    return ff_error_set(err, FF_ERR_RANGE, NULL, 0, -1,
                        "found the grid '%s', expected %s, 2 to 512 polar angles and 2 to 512 samples a side", text,
                        z->isotropic ? "1 azimuth for an isotropic table" : "3 to 512 azimuths for an anisotropic table");
}

typedef void visitor(void *context, const double w[6], double f);

/* Every valid pair of directions above the horizon, with the mean of its channels. */
static void visit(const ff_table *t, visitor *to, void *context)
{
    enum { BLOCK = 256 };
    double plane[6][BLOCK], sum[BLOCK], one[BLOCK], *const planes[6] = {plane[0], plane[1], plane[2], plane[3], plane[4], plane[5]};
    for (size_t first = 0; first < t->n; first += BLOCK) {
        const size_t n = t->n - first < BLOCK ? t->n - first : BLOCK;
        ff_table_directions(t, first, n, planes);
        memset(sum, 0, sizeof sum);
        for (size_t c = 0; c < t->n_channels; c++) {
            ff_table_values(t, c, first, n, one);
            for (size_t k = 0; k < n; k++) sum[k] += one[k] / (double)t->n_channels;
        }
        for (size_t k = 0; k < n; k++) {
            const double w[6] = {plane[0][k], plane[1][k], plane[2][k], plane[3][k], plane[4][k], plane[5][k]};
            if (t->valid[first + k] && w[2] > 0 && w[5] > 0 && isfinite(sum[k])) to(context, w, sum[k]);
        }
    }
}

/* Different polar angles of incidence, as long as they are few. */
typedef struct incidences {
    size_t n;
    double theta[NODES_MOST];
} incidences;

static void collect(void *context, const double w[6], double f)
{
    incidences *in = context;
    const double theta = atan2(hypot(w[0], w[1]), w[2]);
    (void)f;
    for (size_t k = 0; k < in->n && in->n < NODES_MOST; k++)
        if (fabs(in->theta[k] - theta) < 1e-4) return;
    if (in->n < NODES_MOST) in->theta[in->n++] = theta;
}

static ff_status choose_theta(const ff_table *t, int asked, sizes *z, ff_error *err)
{
    incidences in = {0};
    if (!asked) visit(t, collect, &in);
    const int few = in.n >= 3 && in.n <= 32;
    if (few) z->n_theta = in.n;
    if (!(z->theta = malloc(z->n_theta * sizeof *z->theta)))
        return ff_error_set(err, FF_ERR_MEMORY, NULL, 0, -1, "no memory for the layout of an RGL file");
    for (size_t k = 0; k < z->n_theta; k++)
        z->theta[k] = few ? in.theta[k] : 86 * pi / 180 * pow((double)k / (double)(z->n_theta - 1), 0.6);
    qsort(z->theta, z->n_theta, sizeof *z->theta, ff_ascending);
    return FF_OK;
}

/* RGB, or one channel per wavelength. */
static ff_status choose_channels(const ff_table *t, sizes *z, ff_error *err)
{
    size_t wavelengths = 0, increasing = 1;
    for (size_t c = 0; c < t->n_channels; c++) {
        wavelengths += t->channels[c].wavelength_nm >= 1 && t->channels[c].wavelength_nm <= 1e6;
        increasing += c > 0 && (float)t->channels[c].wavelength_nm > (float)t->channels[c - 1].wavelength_nm;
    }
    z->spectral = wavelengths == t->n_channels;
    z->n_colours = z->spectral ? t->n_channels : 3;
    if (z->spectral && increasing != t->n_channels)
        return ff_error_set(err, FF_ERR_UNSUPPORTED, NULL, 0, -1,
                            "an RGL file needs wavelengths in increasing order, found others; put the channels in order first");
    if (z->spectral || t->n_channels == 1 || t->n_channels == 3) return FF_OK;
    return ff_error_set(err, FF_ERR_UNSUPPORTED, NULL, 0, -1,
                        "an RGL file has 3 channels or wavelengths, found %zu channels without; reduce them first", t->n_channels);
}

static ff_status choose(const ff_table *t, const char *grid, sizes *z, ff_error *err)
{
    *z = (sizes){.isotropic = t->isotropic || (t->grid && t->grid->isotropic), .n_theta = THETA_USUAL, .res = RES_USUAL};
    z->n_phi = z->isotropic ? 1 : PHI_USUAL;
    ff_status status = choose_channels(t, z, err);
    if (status == FF_OK && grid) status = parse(grid, z, err);
    if (status == FF_OK) status = choose_theta(t, grid != NULL, z, err);
    const double nodes = (double)z->n_phi * (double)z->n_theta;
    if (status == FF_OK &&
        (nodes > INCIDENCES_MOST || nodes * (double)z->res * (double)z->res * (double)(z->n_colours + 1) > numbers_most))
        status = ff_error_set(
            err, FF_ERR_RANGE, NULL, 0, -1,
            "found a grid of %zu x %zu incidences with %zu x %zu samples of %zu channels, expected at most 4096 incidences "
            "and 268435456 numbers",
            z->n_phi, z->n_theta, z->res, z->res, z->n_colours);
    return status;
}

/* ---- the distribution of normals ------------------------------------------------------------- */

typedef struct shape {
    int isotropic;
    double ring[RINGS], ring_count[RINGS];               /* sums, then the distribution at the centres */
    double cell[CELLS][CELLS], cell_count[CELLS][CELLS]; /* [azimuth][polar]                          */
} shape;

static void add_pair(void *context, const double w[6], double f)
{
    shape *s = context;
    const double m[3] = {w[0] + w[3], w[1] + w[4], w[2] + w[5]}, least = 0.17; /* cosine of 80 degrees */
    if (w[2] < least || w[5] < least) return;
    const double u = sqrt(2 / pi * atan2(hypot(m[0], m[1]), m[2])), v = (atan2(m[1], m[0]) + pi) / (2 * pi);
    const double value = 4 * f * w[2] * w[5];
    const size_t ring = (size_t)fmin(u * RINGS, RINGS - 1), a = (size_t)fmin(v * CELLS, CELLS - 1), b = ring / (RINGS / CELLS);
    s->ring[ring] += value;
    s->ring_count[ring]++;
    s->cell[a][b] += value;
    s->cell_count[a][b]++;
}

/* Means of the rings; empty ones between their neighbours. */
static void finish_rings(shape *s)
{
    size_t last = RINGS;
    for (size_t k = 0; k < RINGS; k++) {
        if (s->ring_count[k] <= 0) continue;
        s->ring[k] = fmax(s->ring[k] / s->ring_count[k], 0);
        const size_t from = last == RINGS ? 0 : last + 1;
        for (size_t i = from; i < k; i++) {
            const double t = last == RINGS ? 1 : (double)(i - last) / (double)(k - last);
            s->ring[i] = t * s->ring[k] + (1 - t) * (last == RINGS ? 0 : s->ring[last]);
        }
        last = k;
    }
    for (size_t i = last == RINGS ? 0 : last + 1; i < RINGS; i++) s->ring[i] = last == RINGS ? 1 : s->ring[last];
}

static void finish_cells(shape *s)
{
    enum { DRAWN = 4, RINGS_OF_CELL = RINGS / CELLS }; /* the ring counts as so many pairs */
    for (size_t b = 0; b < CELLS; b++) {
        double ring = 0;
        for (size_t k = 0; k < RINGS_OF_CELL; k++) ring += s->ring[b * RINGS_OF_CELL + k] / RINGS_OF_CELL;
        for (size_t a = 0; a < CELLS; a++) s->cell[a][b] = fmax((s->cell[a][b] + DRAWN * ring) / (s->cell_count[a][b] + DRAWN), 0);
    }
}

/* Between centres, in both directions; the azimuth goes around. */
static double shape_at(const shape *s, double u, double v)
{
    const size_t n = s->isotropic ? RINGS : CELLS;
    const double x = fmin(fmax(u * (double)n - 0.5, 0), (double)(n - 1) - 1e-9), p = x - floor(x);
    const size_t b = (size_t)x;
    if (s->isotropic) return (1 - p) * s->ring[b] + p * s->ring[b + 1];
    const double y = v * CELLS - 0.5 + CELLS, q = y - floor(y);
    const double *lo = s->cell[(size_t)y % CELLS], *hi = s->cell[((size_t)y + 1) % CELLS];
    return (1 - q) * ((1 - p) * lo[b] + p * lo[b + 1]) + q * ((1 - p) * hi[b] + p * hi[b + 1]);
}

/* ---- the fields ------------------------------------------------------------------------------ */

/* Normals of a grid over u and what they weigh: ndf times the solid angle of the cell. */
typedef struct normals {
    size_t width, height;
    double *ndf;                   /* [height][width]                    */
    double *sine, *cosine, *theta; /* [width] of theta_m; [width] theta_m */
    double *cos_phi, *sin_phi;     /* [height]                           */
} normals;

static int normals_new(size_t width, size_t height, normals *n)
{
    double *memory = calloc(width * height + 3 * width + 2 * height, sizeof *memory);
    if (!memory) return 0;
    *n = (normals){.width = width, .height = height, .ndf = memory, .sine = memory + width * height};
    n->cosine = n->sine + width, n->theta = n->cosine + width, n->cos_phi = n->theta + width, n->sin_phi = n->cos_phi + height;
    for (size_t x = 0; x < width; x++) {
        n->theta[x] = ff_rgl_theta((double)x / (double)(width - 1));
        n->sine[x] = sin(n->theta[x]), n->cosine[x] = fmax(cos(n->theta[x]), 0);
    }
    for (size_t y = 0; y < height; y++) {
        const double phi = ff_rgl_phi((double)y / (double)(height - 1));
        n->cos_phi[y] = cos(phi), n->sin_phi[y] = sin(phi);
    }
    return 1;
}

/* Solid angle per node by the trapezoid rule over u: 2 pi^2 u sin(theta) du dv. */
static double node_angle(const normals *n, size_t x, size_t y)
{
    const double du = (x + 1 < n->width ? 1 : 0.5) / (double)(n->width - 1), dv = (y > 0 && y + 1 < n->height ? 1 : 0.5);
    return 2 * pi * pi * (double)x / (double)(n->width - 1) * n->sine[x] * du * dv / (double)(n->height - 1);
}

static double along(const normals *n, double sine, double cosine, double cos_phi, double sin_phi, size_t x, size_t y)
{
    return fmax(cosine * n->cosine[x] + sine * n->sine[x] * (cos_phi * n->cos_phi[y] + sin_phi * n->sin_phi[y]), 0);
}

static void fill_ndf(const shape *s, normals *n)
{
    double area = 0;
    for (size_t y = 0; y < n->height; y++)
        for (size_t x = 0; x < n->width; x++) {
            n->ndf[y * n->width + x] = shape_at(s, (double)x / (double)(n->width - 1), (double)y / (double)(n->height - 1));
            area += n->ndf[y * n->width + x] * n->cosine[x] * node_angle(n, x, y);
        }
    for (size_t k = 0; k < n->width * n->height; k++)
        n->ndf[k] = area > 0 && isfinite(area) ? 0.9 * n->ndf[k] / area + 0.1 / pi : 1 / pi;
}

static double projected_area(const normals *n, double theta, double phi)
{
    const double s = sin(theta), c = cos(theta), cp = cos(phi), sp = sin(phi);
    double sum = 0;
    for (size_t y = 0; y < n->height; y++)
        for (size_t x = 0; x < n->width; x++) sum += n->ndf[y * n->width + x] * along(n, s, c, cp, sp, x, y) * node_angle(n, x, y);
    return sum;
}

static unsigned char *field(const ff_tensor_file *f, const char *name)
{
    return ff_tensor_data(f, ff_tensor_find(f, name));
}

static void put_sigma(const normals *n, size_t height, unsigned char *to)
{
    for (size_t x = 0; x < SIGMA_THETA; x++)
        for (size_t y = 0; y < height; y++) {
            const double theta = ff_rgl_theta((double)x / (SIGMA_THETA - 1)), phi = ff_rgl_phi((double)y / (double)(height - 1));
            unsigned char *at = to + 4 * (y * SIGMA_THETA + x);
            if (height == 2 && y == 1) /* isotropic */
                memcpy(at, at - 4 * SIGMA_THETA, 4);
            else
                ff_bytes_of_float((float)projected_area(n, theta, phi), at);
        }
}

/* The density of visible normals of one incidence, with the sum 1. */
static void put_vndf(const normals *n, double theta, double phi, unsigned char *to)
{
    const double s = sin(theta), c = cos(theta), cp = cos(phi), sp = sin(phi);
    double sum = 0;
    for (int pass = 0; pass < 2; pass++)
        for (size_t y = 0; y < n->height; y++)
            for (size_t x = 0; x < n->width; x++) {
                const double d = n->ndf[y * n->width + x] * along(n, s, c, cp, sp, x, y) * (double)x * n->sine[x];
                if (pass == 0)
                    sum += d;
                else
                    ff_bytes_of_float((float)(d / sum), to + 4 * (y * n->width + x));
            }
}

static double phi_node(const sizes *z, size_t p)
{
    return z->isotropic ? 0 : ff_rgl_phi((double)p / (double)(z->n_phi - 1));
}

static void put_fields(const ff_table *t, const sizes *z, const normals *coarse, const normals *fine, const ff_tensor_file *f)
{
    static const char text[] = "written by facetfit";
    unsigned char *to = field(f, "ndf");
    memcpy(field(f, "description"), text, sizeof text - 1);
    field(f, "version")[0] = 1;
    field(f, "jacobian")[0] = 1;
    const normals *ndf = z->isotropic ? coarse : fine;
    for (size_t k = 0; k < ndf->width * ndf->height; k++) ff_bytes_of_float((float)ndf->ndf[k], to + 4 * k);
    put_sigma(z->isotropic ? fine : coarse, z->isotropic ? 2 : SIGMA_PHI, field(f, "sigma"));
    for (size_t k = 0; k < z->n_theta; k++) ff_bytes_of_float((float)z->theta[k], field(f, "theta_i") + 4 * k);
    for (size_t p = 0; p < z->n_phi; p++) {
        ff_bytes_of_float((float)phi_node(z, p), field(f, "phi_i") + 4 * p);
        for (size_t k = 0; k < z->n_theta; k++)
            put_vndf(fine, z->theta[k], phi_node(z, p), field(f, "vndf") + 4 * (p * z->n_theta + k) * VNDF * VNDF);
    }
    for (size_t c = 0; c < z->n_colours && z->spectral; c++)
        ff_bytes_of_float((float)t->channels[c].wavelength_nm, field(f, "wavelengths") + 4 * c);
}

/* The fields in the order of the database's files. */
static ff_status make_fields(const sizes *z, ff_tensor_file *out, ff_error *err)
{
    uint64_t version[1] = {2}, text[1] = {19}, phi[1] = {z->n_phi}, theta[1] = {z->n_theta}, one[1] = {1}, nm[1] = {z->n_colours};
    uint64_t ndf[2] = {z->isotropic ? 2 : VNDF, VNDF}, sigma[2] = {z->isotropic ? 2 : SIGMA_PHI, SIGMA_THETA};
    uint64_t vndf[4] = {z->n_phi, z->n_theta, VNDF, VNDF}, luminance[4] = {z->n_phi, z->n_theta, z->res, z->res};
    uint64_t colours[5] = {z->n_phi, z->n_theta, z->n_colours, z->res, z->res};
    const ff_tensor fields[] = {
        {.name = (char[]){"version"}, .type = FF_TENSOR_UINT32, .n_dims = 1, .shape = version},
        {.name = (char[]){"description"}, .type = FF_TENSOR_UINT8, .n_dims = 1, .shape = text},
        {.name = (char[]){"phi_i"}, .type = FF_TENSOR_FLOAT32, .n_dims = 1, .shape = phi},
        {.name = (char[]){"theta_i"}, .type = FF_TENSOR_FLOAT32, .n_dims = 1, .shape = theta},
        {.name = (char[]){"sigma"}, .type = FF_TENSOR_FLOAT32, .n_dims = 2, .shape = sigma},
        {.name = (char[]){"ndf"}, .type = FF_TENSOR_FLOAT32, .n_dims = 2, .shape = ndf},
        {.name = (char[]){"vndf"}, .type = FF_TENSOR_FLOAT32, .n_dims = 4, .shape = vndf},
        {.name = (char[]){"luminance"}, .type = FF_TENSOR_FLOAT32, .n_dims = 4, .shape = luminance},
        {.name = z->spectral ? (char[]){"spectra"} : (char[]){"rgb"}, .type = FF_TENSOR_FLOAT32, .n_dims = 5, .shape = colours},
        {.name = (char[]){"jacobian"}, .type = FF_TENSOR_UINT8, .n_dims = 1, .shape = one},
        {.name = (char[]){"wavelengths"}, .type = FF_TENSOR_FLOAT32, .n_dims = 1, .shape = nm},
    };
    return ff_tensor_file_make(fields, sizeof fields / sizeof fields[0] - (z->spectral ? 0 : 1), out, err);
}

ff_status ff_rgl_make(const ff_table *t, const char *grid, ff_tensor_file *out, ff_error *err)
{
    sizes z;
    normals coarse = {0}, fine = {0};
    shape *s = calloc(1, sizeof *s);
    ff_status status = choose(t, grid, &z, err);
    if (status == FF_OK && (!s || !normals_new(VNDF, z.isotropic ? 2 : SIGMA_PHI, &coarse) || !normals_new(VNDF, VNDF, &fine)))
        status = ff_error_set(err, FF_ERR_MEMORY, NULL, 0, -1, "no memory for the layout of an RGL file");
    if (status == FF_OK) status = make_fields(&z, out, err);
    if (status == FF_OK) {
        s->isotropic = z.isotropic;
        visit(t, add_pair, s);
        finish_rings(s);
        finish_cells(s);
        fill_ndf(s, &coarse);
        fill_ndf(s, &fine);
        put_fields(t, &z, &coarse, &fine, out);
    }
    free(z.theta);
    free(coarse.ndf);
    free(fine.ndf);
    free(s);
    return status;
}
