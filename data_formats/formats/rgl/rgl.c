/* Evaluation of RGL files; format_rgl.c has the layout.
 *
 *     u(direction) = (sqrt(2 theta / pi), (phi + pi) / (2 pi))
 *     m            = half vector; its azimuth is taken from that of wi in an isotropic file
 *     s            = the place of u(m) in the uniform square of the warp by the density of visible normals `vndf`(phi_i, theta_i)
 *     f cos(theta_o) = colour(s; phi_i, theta_i) ndf(u(m)) / (4 sigma(u(wi)))
 *
 * Everything in between is linear: in u for ndf, sigma, vndf, in s for the colours, in phi_i and theta_i between their nodes.
 * Facts from Dupuy and Jakob, "An Adaptive Parameterization for Efficient Material Acquisition and Rendering", ACM ToG 37(6), 2018;
 * from their loader (github.com/rgl-epfl/brdf-loader), which knows RGB and spectral files; and from the plugin `measured` of
 * Mitsuba 3, which also knows the flag `jacobian` and files whose phi_i cover a half or a quarter of the circle: they begin at -pi,
 * and light from elsewhere is turned by 180 degrees (half) or mirrored (quarter) into that part. */
#include "internal_rgl.h"
#include "base/internal_input.h"
#include "base/internal_number.h"
#include "models/model_struct.h"
#include <math.h>
#include <stdatomic.h>
#include <stdlib.h>

static const double pi = 3.14159265358979323846;

/* Incidence nearer to the horizon than 32-bit angles can say (6e-8): the files' last node. */
static const double grazing = 1e-6;

/* ---- opening --------------------------------------------------------------------------------- */

typedef struct opening {
    ff_rgl *r;
    const char *path;
    ff_error *err;
} opening;

static ff_status no_memory(const opening *o)
{
    return ff_error_set(o->err, FF_ERR_MEMORY, o->path, 0, -1, "no memory for an RGL file");
}

static ff_status find(const opening *o, const char *name, unsigned type, size_t n_dims, const ff_tensor **out)
{
    char text[FF_TENSOR_TEXT];
    const ff_tensor *t = ff_tensor_find(&o->r->file, name);
    if (!t)
        return ff_error_set(o->err, FF_ERR_FORMAT, o->path, 0, FF_TENSOR_HEADER,
                            "found no field '%s' in this tensor file, expected those of an RGL material", name);
    if (t->type != type || t->n_dims != n_dims || t->count == 0)
        return ff_error_set(o->err, FF_ERR_FORMAT, o->path, 0, (int64_t)t->header,
                            "found the field '%s' as %s, expected %s of %zu dimensions that are not empty", name,
                            ff_tensor_describe(t, text), ff_tensor_type_name(type), n_dims);
    *out = t;
    return FF_OK;
}

/* The leading dimensions are as expected, the last two at least 2, so that there are cells. */
static ff_status check_shape(const opening *o, const ff_tensor *t, size_t n_leading, const size_t *leading)
{
    char text[FF_TENSOR_TEXT], expected[96] = "";
    size_t used = 0;
    int ok = 1;
    for (size_t k = 0; k < n_leading; k++) {
        ok &= t->shape[k] == leading[k];
        used += (size_t)snprintf(expected + used, sizeof expected - used, "%zu, ", leading[k]);
    }
    for (size_t k = n_leading; k < t->n_dims; k++) ok &= t->shape[k] >= 2;
    if (ok) return FF_OK;
    return ff_error_set(o->err, FF_ERR_FORMAT, o->path, 0, (int64_t)t->header,
                        "found the field '%s' as %s, expected the dimensions [%s2 or more, 2 or more]", t->name,
                        ff_tensor_describe(t, text), expected);
}

static int is_usable(uint32_t bits, int may_be_negative)
{
    return (bits & 0x7F800000u) != 0x7F800000u && (may_be_negative || bits <= 0x80000000u); /* -0 is not negative */
}

/* Every element is finite, and not negative where that has no meaning. */
static ff_status check_numbers(const opening *o, const ff_tensor *t, int may_be_negative)
{
    const unsigned char *data = ff_tensor_data(&o->r->file, t);
    int wrong = 0;
    for (size_t i = 0; i < t->count; i++) wrong |= !is_usable(ff_uint32_of(data + 4 * i), may_be_negative);
    for (size_t i = 0; i < t->count && wrong; i++)
        if (!is_usable(ff_uint32_of(data + 4 * i), may_be_negative))
            return ff_error_set(o->err, FF_ERR_DATA, o->path, 0, (int64_t)(t->offset + 4 * i),
                                "element %zu of the field '%s': found %g, expected a finite number%s", i, t->name,
                                (double)ff_float_of(data + 4 * i), may_be_negative ? "" : " >= 0");
    return FF_OK;
}

/* float32 field with checked numbers. */
static ff_status numbers(const opening *o, const char *name, size_t n_dims, int may_be_negative, const ff_tensor **out)
{
    const ff_status status = find(o, name, FF_TENSOR_FLOAT32, n_dims, out);
    return status == FF_OK ? check_numbers(o, *out, may_be_negative) : status;
}

static ff_status copy_floats(const opening *o, const ff_tensor *t, float **out)
{
    if (!(*out = malloc(t->count * sizeof **out))) return no_memory(o);
    ff_floats_from_file(ff_tensor_data(&o->r->file, t), t->count, *out);
    return FF_OK;
}

/* Increasing numbers between lo and hi. */
static ff_status read_nodes(const opening *o, const char *name, double lo, double hi, size_t *n, double **out)
{
    const ff_tensor *t;
    const ff_status status = numbers(o, name, 1, 1, &t);
    if (status != FF_OK) return status;
    if (!(*out = malloc(t->count * sizeof **out))) return no_memory(o);
    *n = t->count;
    for (size_t i = 0; i < t->count; i++) {
        const double v = (double)ff_float_of(ff_tensor_data(&o->r->file, t) + 4 * i);
        (*out)[i] = v;
        if (v >= lo && v <= hi && (i == 0 || v > (*out)[i - 1])) continue;
        return ff_error_set(o->err, FF_ERR_DATA, o->path, 0, (int64_t)(t->offset + 4 * i),
                            "element %zu of the field '%s': found %g, expected increasing numbers from %g to %g", i, name, v, lo,
                            hi);
    }
    return FF_OK;
}

/* The symmetry that makes the measured azimuths of incidence a whole circle. */
static ff_status find_reduction(const opening *o)
{
    ff_rgl *r = o->r;
    r->isotropic = r->n_phi <= 2;
    r->reduction = 1;
    if (r->isotropic) return FF_OK;
    const double covered = r->phi[r->n_phi - 1] - r->phi[0], parts = round(2 * pi / covered);
    r->reduction = (int)fmin(parts, 99);
    if (r->reduction == 1 || ((r->reduction == 2 || r->reduction == 4) && fabs(r->phi[0] + pi) < 1e-3)) return FF_OK;
    return ff_error_set(o->err, FF_ERR_UNSUPPORTED, o->path, 0, (int64_t)ff_tensor_find(&r->file, "phi_i")->offset,
                        "found azimuths of incidence from %g to %g, expected a whole circle, or a half or a quarter from -pi on",
                        r->phi[0], r->phi[r->n_phi - 1]);
}

static ff_status read_grids(const opening *o)
{
    ff_rgl *r = o->r;
    const ff_tensor *ndf, *sigma, *jacobian;
    ff_status status = numbers(o, "ndf", 2, 0, &ndf);
    if (status == FF_OK) status = check_shape(o, ndf, 0, NULL);
    if (status == FF_OK) status = numbers(o, "sigma", 2, 0, &sigma);
    if (status == FF_OK) status = check_shape(o, sigma, 0, NULL);
    if (status == FF_OK) status = copy_floats(o, ndf, &r->ndf);
    if (status == FF_OK) status = copy_floats(o, sigma, &r->sigma);
    if (status == FF_OK) status = find(o, "jacobian", FF_TENSOR_UINT8, 1, &jacobian);
    if (status != FF_OK) return status;
    r->ndf_height = (size_t)ndf->shape[0], r->ndf_width = (size_t)ndf->shape[1];
    r->sigma_height = (size_t)sigma->shape[0], r->sigma_width = (size_t)sigma->shape[1];
    r->jacobian = ff_tensor_data(&r->file, jacobian)[0] != 0;
    return FF_OK;
}

static ff_status read_vndf(const opening *o, int with_inverse)
{
    ff_rgl *r = o->r;
    const ff_tensor *t;
    float *density;
    ff_status status = numbers(o, "vndf", 4, 0, &t);
    if (status == FF_OK) status = check_shape(o, t, 2, (const size_t[]){r->n_phi, r->n_theta});
    if (status == FF_OK) status = copy_floats(o, t, &density);
    if (status != FF_OK) return status;
    const size_t size = (size_t)(t->shape[2] * t->shape[3]), parts = r->n_phi * r->n_theta;
    for (size_t part = 0, i = 0; part < parts; part++, i += size) {
        size_t k = 0;
        while (k < size && !(density[i + k] > 0)) k++;
        if (k < size) continue;
        free(density);
        return ff_error_set(o->err, FF_ERR_DATA, o->path, 0, (int64_t)(t->offset + 4 * i),
                            "part %zu of the field 'vndf': found zeros alone, expected a density", part);
    }
    return ff_warp2d_new((size_t)t->shape[3], (size_t)t->shape[2], (const size_t[]){r->n_phi, r->n_theta},
                         (const double *const[]){r->phi, r->theta}, density, with_inverse, &r->vndf)
               ? FF_OK
               : no_memory(o);
}

/* The shortest decimal number that is the same as a 32-bit float. */
static double shortest(float v)
{
    static const double units[] = {1, 10, 100, 1e3, 1e4};
    for (size_t k = 0; k < sizeof units / sizeof *units; k++) {
        const double decimal = round((double)v * units[k]) / units[k];
        if ((float)decimal == v) return decimal;
    }
    return (double)v;
}

static ff_status name_channels(const opening *o, const ff_tensor *wavelengths)
{
    static const char *const rgb[3] = {"r", "g", "b"};
    ff_rgl *r = o->r;
    if (!(r->channels = calloc(r->n_channels, sizeof *r->channels))) return no_memory(o);
    for (size_t c = 0; c < r->n_channels; c++) {
        ff_channel *channel = &r->channels[c];
        *channel = (ff_channel){.scale = 1, .wavelength_nm = NAN};
        if (!wavelengths) {
            strcpy(channel->name, rgb[c]);
            continue;
        }
        char text[FF_NUMBER_TEXT];
        channel->wavelength_nm = shortest(ff_float_of(ff_tensor_data(&r->file, wavelengths) + 4 * c));
        const unsigned length = ff_number_write(channel->wavelength_nm, text);
        snprintf(channel->name, sizeof channel->name, "%.*snm", (int)length, text);
    }
    return FF_OK;
}

static ff_status read_colours(const opening *o)
{
    ff_rgl *r = o->r;
    const ff_tensor *wavelengths = NULL;
    double *nm = NULL;
    r->n_channels = 3;
    ff_status status = FF_OK;
    r->spectral = ff_tensor_find(&r->file, "spectra") != NULL;
    if (r->spectral) {
        status = read_nodes(o, "wavelengths", 1, 1e6, &r->n_channels, &nm);
        free(nm);
        wavelengths = ff_tensor_find(&r->file, "wavelengths");
    }
    if (status == FF_OK) status = numbers(o, r->spectral ? "spectra" : "rgb", 5, 1, &r->colour);
    if (status == FF_OK) status = check_shape(o, r->colour, 3, (const size_t[]){r->n_phi, r->n_theta, r->n_channels});
    if (status != FF_OK) return status;
    r->height = (size_t)r->colour->shape[3], r->width = (size_t)r->colour->shape[4];
    status = numbers(o, "luminance", 4, 1, &r->luminance);
    if (status == FF_OK) status = check_shape(o, r->luminance, 2, (const size_t[]){r->n_phi, r->n_theta});
    if (status == FF_OK && (r->luminance->shape[2] != r->height || r->luminance->shape[3] != r->width))
        return ff_error_set(o->err, FF_ERR_FORMAT, o->path, 0, (int64_t)r->luminance->header,
                            "found the field 'luminance' with %llu x %llu samples, expected the %zu x %zu of '%s'",
                            (unsigned long long)r->luminance->shape[2], (unsigned long long)r->luminance->shape[3], r->height,
                            r->width, r->colour->name);
    return status == FF_OK ? name_channels(o, wavelengths) : status;
}

static ff_status read_description(const opening *o)
{
    const ff_tensor *t = ff_tensor_find(&o->r->file, "description");
    const size_t n = t && t->type == FF_TENSOR_UINT8 ? t->count : 0;
    if (!(o->r->description = calloc(n + 1, 1))) return no_memory(o);
    if (n) memcpy(o->r->description, ff_tensor_data(&o->r->file, t), n);
    return FF_OK;
}

ff_status ff_rgl_of_file(ff_tensor_file *file, const char *path, int with_inverse, ff_rgl **out, ff_error *err)
{
    const opening o = {.r = calloc(1, sizeof *o.r), .path = path, .err = err};
    if (!o.r) {
        ff_tensor_file_free(file);
        return no_memory(&o);
    }
    o.r->file = *file;
    *file = (ff_tensor_file){0};
    ff_status status = read_nodes(&o, "theta_i", 0, pi / 2 + 1e-6, &o.r->n_theta, &o.r->theta);
    if (status == FF_OK) status = read_nodes(&o, "phi_i", -2 * pi - 1e-5, 2 * pi + 1e-5, &o.r->n_phi, &o.r->phi);
    if (status == FF_OK) status = find_reduction(&o);
    if (status == FF_OK) status = read_grids(&o);
    if (status == FF_OK) status = read_colours(&o);
    if (status == FF_OK) status = read_vndf(&o, with_inverse);
    if (status == FF_OK) status = read_description(&o);
    if (status != FF_OK)
        ff_rgl_free(o.r);
    else
        *out = o.r;
    return status;
}

ff_status ff_rgl_open(const char *path, ff_rgl **out, ff_error *err)
{
    ff_tensor_file file;
    const ff_status status = ff_tensor_file_read(path, &file, err);
    return status == FF_OK ? ff_rgl_of_file(&file, path, 1, out, err) : status;
}

void ff_rgl_free(ff_rgl *r)
{
    if (!r || atomic_fetch_sub(&r->owners, 1) > 0) return;
    ff_tensor_file_free(&r->file);
    ff_warp2d_free(&r->vndf);
    free(r->phi);
    free(r->theta);
    free(r->ndf);
    free(r->sigma);
    free(r->channels);
    free(r->description);
    free(r);
}

ff_rgl_info ff_rgl_about(const ff_rgl *r)
{
    return (ff_rgl_info){.n_channels = r->n_channels,
                         .channels = r->channels,
                         .description = r->description,
                         .isotropic = r->isotropic,
                         .n_phi_i = r->n_phi,
                         .n_theta_i = r->n_theta,
                         .width = r->width,
                         .height = r->height};
}

/* ---- evaluation ------------------------------------------------------------------------------ */

/* (phi + pi) / (2 pi), of any phi in [0, 1). */
static double u_of_phi(double phi)
{
    const double u = (phi + pi) / (2 * pi);
    return u - floor(u);
}

/* Projected area of the microsurface seen from the light. */
static double sigma_of(const ff_rgl *r, double theta_i, double phi_i)
{
    const double at[2] = {ff_rgl_u_of_theta(theta_i), u_of_phi(phi_i)};
    return r->jacobian ? ff_bilinear(r->sigma, r->sigma_width, r->sigma_height, at) : 1;
}

double ff_rgl_density(const ff_rgl *r, const double u[2])
{
    return r->jacobian ? ff_bilinear(r->ndf, r->ndf_width, r->ndf_height, u) : 1;
}

static double factor_of(const ff_rgl *r, double sigma, const double u[2])
{
    if (!r->jacobian) return 1;
    const double factor = ff_rgl_density(r, u) / (4 * sigma);
    return isfinite(factor) ? factor : 0;
}

double ff_rgl_factor(const ff_rgl *r, double theta_i, double phi_i, const double u[2])
{
    return factor_of(r, sigma_of(r, theta_i, phi_i), u);
}

/* Turns or mirrors a pair of directions into the part of the circle that the file has. */
static void fold(const ff_rgl *r, double wi[3], double wo[3])
{
    if (r->reduction < 2) return;
    const double y = wi[1] > 0 ? -1 : 1, x = r->reduction == 4 ? (wi[0] > 0 ? -1 : 1) : y;
    wi[0] *= x, wo[0] *= x;
    wi[1] *= y, wo[1] *= y;
}

/* The same azimuth within the circle that begins at the first node. */
static double into_circle(const ff_rgl *r, double phi)
{
    if (phi < r->phi[0]) return phi + 2 * pi;
    return phi > r->phi[0] + 2 * pi ? phi - 2 * pi : phi;
}

/* Colours at s between the nodes of incidence that the mix names, times factor. */
static void colours_at(const ff_rgl *r, const ff_warp2d_mix *mix, const double s[2], double factor, double *f, size_t ld)
{
    const size_t size = r->width * r->height;
    const double x = fmin(s[0] * (double)(r->width - 1), (double)(r->width - 1)), y = s[1] * (double)(r->height - 1);
    const size_t column = (size_t)fmin(x, (double)(r->width - 2)), row = (size_t)fmin(y, (double)(r->height - 2));
    const double a = x - (double)column, b = y - (double)row;
    const double weight[4] = {(1 - a) * (1 - b), a * (1 - b), (1 - a) * b, a * b};
    const size_t corner[4] = {0, 1, r->width, r->width + 1};
    const unsigned char *data = ff_tensor_data(&r->file, r->colour) + 4 * (row * r->width + column);
    for (size_t c = 0; c < r->n_channels; c++) f[c * ld] = 0;
    for (int k = 0; k < mix->n; k++)
        for (size_t c = 0; c < r->n_channels; c++) {
            const unsigned char *d = data + 4 * size * (mix->slice[k] * r->n_channels + c);
            double sum = 0;
            for (int q = 0; q < 4; q++) sum += weight[q] * (double)ff_float_of(d + 4 * corner[q]);
            f[c * ld] += factor * mix->weight[k] * sum;
        }
}

/* 1 when f is defined, else it is left alone. */
static int evaluate(const ff_rgl *r, double wi[3], double wo[3], double *f, size_t ld)
{
    if (!(wi[2] > FF_COS_MIN && wo[2] > FF_COS_MIN)) return 0;
    fold(r, wi, wo);
    const double m[3] = {wi[0] + wo[0], wi[1] + wo[1], wi[2] + wo[2]};
    const double theta_i = atan2(hypot(wi[0], wi[1]), wi[2]), phi_i = into_circle(r, atan2(wi[1], wi[0]));
    const double theta_m = atan2(hypot(m[0], m[1]), m[2]), phi_m = atan2(m[1], m[0]);
    const double u[2] = {ff_rgl_u_of_theta(theta_m), u_of_phi(r->isotropic ? phi_m - phi_i : phi_m)};
    const double factor = ff_rgl_factor(r, theta_i, phi_i, u);
    if (!(factor > 0)) return 0;
    const ff_warp2d_mix mix = ff_warp2d_at(&r->vndf, (const double[]){phi_i, theta_i});
    double s[2];
    ff_warp2d_invert(&r->vndf, &mix, u, s);
    colours_at(r, &mix, s, factor / wo[2], f, ld);
    return 1;
}

void ff_rgl_eval(const ff_rgl *r, const double *const w[6], size_t n, double *f, size_t ld, unsigned char *valid)
{
    for (size_t i = 0; i < n; i++) {
        double wi[3] = {w[0][i], w[1][i], w[2][i]}, wo[3] = {w[3][i], w[4][i], w[5][i]};
        const int defined = evaluate(r, wi, wo, f + i, ld);
        for (size_t c = 0; c < r->n_channels && !defined; c++) f[c * ld + i] = 0;
        if (valid) valid[i] = (unsigned char)defined;
    }
}

/* ---- the measured grid ----------------------------------------------------------------------- */

double ff_rgl_incidence_weight(const ff_rgl *r, size_t p, size_t t)
{
    const double *theta = r->theta, *phi = r->phi;
    const double lo = t > 0 ? 0.5 * (theta[t - 1] + theta[t]) : 0;
    const double hi = t + 1 < r->n_theta ? 0.5 * (theta[t] + theta[t + 1]) : pi / 2;
    double part = 1;
    if (r->n_phi > 1) {
        const double before = phi[p > 0 ? p - 1 : p], after = phi[p + 1 < r->n_phi ? p + 1 : p];
        part = 0.5 * (after - before) / (phi[r->n_phi - 1] - phi[0]);
    }
    return 2 * pi * part * (cos(lo) - cos(hi));
}

/* Light of one node of incidence. */
typedef struct light {
    double sine, cosine, cos_phi, sin_phi, sigma;
} light;

/* The direction seen with the half vector at u, whose azimuth has this sine and cosine; f per colour there. */
static double seen_at(const ff_rgl *r, const light *l, const double u[2], double cos_phi, double sin_phi, double wo[3])
{
    const double theta_m = ff_rgl_theta(u[0]), z = cos(theta_m), across = sin(theta_m);
    const double wi[3] = {l->sine * l->cos_phi, l->sine * l->sin_phi, l->cosine};
    const double m[3] = {across * cos_phi, across * sin_phi, z};
    const double along = wi[0] * m[0] + wi[1] * m[1] + wi[2] * m[2];
    for (int k = 0; k < 3; k++) wo[k] = 2 * along * m[k] - wi[k];
    return l->cosine > grazing && wo[2] > grazing ? factor_of(r, l->sigma, u) / wo[2] : 0;
}

/* The sample with the half vector at u: sine and cosine of its azimuth are given, as they are those of the row. */
static void sample(const ff_rgl *r, const light *l, const double u[2], double cos_phi, double sin_phi, size_t i,
                   const ff_rgl_slice *out)
{
    double wo[3];
    out->factor[i] = seen_at(r, l, u, cos_phi, sin_phi, wo);
    out->theta_o[i] = atan2(sqrt(wo[0] * wo[0] + wo[1] * wo[1]), wo[2]);
    out->phi_o[i] = atan2(wo[1], wo[0]);
}

/* Places the samples of row y, and says how dense normals are there. */
static void sample_row(const ff_rgl *r, const light *l, const ff_warp2d_mix *mix, double phi, size_t y, double *row,
                       const ff_rgl_slice *out)
{
    const double v = ff_warp2d_row(&r->vndf, mix, (double)y / (double)(r->height - 1), row);
    const double phi_m = ff_rgl_phi(v) + phi, c = cos(phi_m), s = sin(phi_m);
    size_t cell = 0, i = y * r->width;
    for (size_t x = 0; x < r->width; x++, i++) {
        const double s_x = (double)x / (double)(r->width - 1);
        const double u[2] = {ff_warp2d_along(&r->vndf, row, s_x, &cell), v - floor(v)};
        sample(r, l, u, c, s, i, out);
        if (out->density) out->density[i] = ff_rgl_density(r, u);
    }
}

static light light_of(const ff_rgl *r, size_t p, size_t t)
{
    const double theta = r->theta[t], phi = r->phi[p];
    return (light){sin(theta), cos(theta), cos(phi), sin(phi), sigma_of(r, theta, phi)};
}

void ff_rgl_place(const ff_rgl *r, size_t p, size_t t, const double s[2], double *row, double wo[3], double *factor)
{
    const ff_warp2d_mix mix = {.n = 1, .slice = {p * r->n_theta + t}, .weight = {1}};
    const light l = light_of(r, p, t);
    const double v = ff_warp2d_row(&r->vndf, &mix, s[1], row), phi_m = ff_rgl_phi(v) + (r->isotropic ? r->phi[p] : 0);
    size_t cell = 0;
    const double u[2] = {ff_warp2d_along(&r->vndf, row, s[0], &cell), v - floor(v)};
    *factor = seen_at(r, &l, u, cos(phi_m), sin(phi_m), wo);
}

void ff_rgl_sample_slice(const ff_rgl *r, size_t p, size_t t, double *row, const ff_rgl_slice *out)
{
    const ff_warp2d_mix mix = {.n = 1, .slice = {p * r->n_theta + t}, .weight = {1}};
    const double turn = r->isotropic ? r->phi[p] : 0;
    const light l = light_of(r, p, t);
    for (size_t y = 0; y < r->height; y++) sample_row(r, &l, &mix, turn, y, row, out);
}
