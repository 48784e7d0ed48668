/* Lobes that are not resolved: as narrow as the steps between samples, or as detectors whose aperture nobody has named. */
#include "internal_result.h"
#include <math.h>
#include <stdlib.h>

#define DEGREE     0.017453292519943295
#define DETECTOR   (1.5 * DEGREE) /* as many goniometers have                                                   */
#define RESOLVED   2.5            /* widths of a detector: it broadens such a lobe by 5 %                       */
#define WELL_STEPS 2.0            /* steps between samples: each sees the lobe but for its flanks               */
#define FINE_STEPS 25             /* steps that no one makes with a detector so wide                            */

/* A lobe by itself, as the fit has it in its first channel. */
typedef struct alone {
    ff_model model;
    double shape[FF_MAX_SHAPE], channel[FF_MAX_CHANNEL_PARAMS];
} alone;

static void take_lobe(const ff_fit_result *r, uint32_t lobe, alone *out)
{
    double shape[FF_MAX_SHAPE], channel[FF_MAX_CHANNEL_PARAMS];
    for (uint32_t k = 0; k < r->model.n_shape; k++) shape[k] = r->shape_value[k].value;
    for (uint32_t k = 0; k < r->model.n_channel; k++) channel[k] = r->channel_value[k].value;
    ff_model_lobe_alone(&r->model, lobe, 1, shape, channel, &out->model, out->shape, out->channel);
}

/* The narrowest half width of the lobe's normals at half of its peak, radians; azimuth: across which. FF_ERR_MEMORY. */
static ff_status half_width(const alone *a, double *out, double *azimuth)
{
    ff_prepared p;
    ff_needles needles;
    const ff_status status =
        ff_prepare(&a->model, ff_kernels_get(FF_ISA_BEST), FF_CHEAPEST_MODE, 1, a->shape, a->channel, NULL, 0, INFINITY, &p);
    if (status) return status;
    ff_needles_find(&p, &needles);
    const double x = ff_needle_width(&needles.needle[0], 0), y = ff_needle_width(&needles.needle[0], 0.5 * 3.14159265358979323846);
    *out = fmin(x, y);
    *azimuth = x <= y ? 0 : 0.5 * 3.14159265358979323846;
    ff_prepared_free(&p);
    return FF_OK;
}

enum { CURVE = 96 };
#define INCIDENCE (20 * DEGREE)

/* Where values seen through an aperture are half of that in the mirror direction, in exits of the plane at an azimuth. */
static double seen_width(const alone *a, const ff_aperture *aperture, double azimuth, double reach)
{
    double w[6][CURVE], f[CURVE];
    const double c = cos(azimuth), s = sin(azimuth);
    for (int i = 0; i < CURVE; i++) {
        const double theta = INCIDENCE + reach * i / (CURVE - 1);
        w[0][i] = -sin(INCIDENCE) * c, w[1][i] = -sin(INCIDENCE) * s, w[2][i] = cos(INCIDENCE);
        w[3][i] = sin(theta) * c, w[4][i] = sin(theta) * s, w[5][i] = cos(theta);
    }
    const ff_dirs dirs = {w[0], w[1], w[2], w[3], w[4], w[5]};
    if (ff_aperture_eval(aperture, &a->model, FF_ISA_BEST, 1, a->shape, a->channel, &dirs, CURVE, f, NULL, NULL, CURVE)) return NAN;
    int i = 1;
    while (i < CURVE && f[i] > 0.5 * f[0]) i++;
    return i < CURVE ? i - (0.5 * f[0] - f[i]) / (f[i - 1] - f[i]) : NAN;
}

/* How much of the width a detector makes that is DETECTOR wide. */
static double part_of_detector(const alone *a, double azimuth, double half)
{
    const ff_aperture point = {.outline = FF_APERTURE_DISC}, disc = {.outline = FF_APERTURE_DISC, .half = 0.5 * DETECTOR};
    const double reach = fmin(6 * half + DETECTOR, 60 * DEGREE);
    return 1 - seen_width(a, &point, azimuth, reach) / seen_width(a, &disc, azimuth, reach);
}

/* The first parameter of a lobe's shape that was fitted; n_shape: none. */
static uint32_t fitted_shape(const ff_fit_result *r, const ff_lobe *lobe)
{
    for (uint32_t k = lobe->shape0; k < lobe->shape0 + lobe->n_shape; k++)
        if (!r->shape_value[k].held && !r->shape_value[k].weightless && !isnan(r->shape_value[k].std_error)) return k;
    return r->model.n_shape;
}

static ff_status warn_of(const struct ff_problem *p, uint32_t lobe, const ff_warning_parameter *named, alone *a, ff_fit_result *r)
{
    double half = 0, azimuth = 0;
    take_lobe(r, lobe, a);
    const ff_status status = half_width(a, &half, &azimuth);
    if (status) return status;
    /* a normal that leans by an angle moves the exit by twice of it, to either side */
    const double width = 4 * half, step = p->spacing;
    const int by_steps = width < WELL_STEPS * step,
              by_detector = !p->rules && width < RESOLVED * DETECTOR && !(width > FINE_STEPS * step);
    if (!by_steps && !by_detector) return FF_OK;
    const ff_warning w = {.code = FF_WARNING_NARROW_LOBE,
                          .n_parameters = 1,
                          .parameter = named,
                          .value = {width / DEGREE, step / DEGREE, by_detector ? part_of_detector(a, azimuth, half) : 0}};
    return ff_warnings_add(&r->warnings, &w);
}

ff_status ff_result_warn_of_narrow_lobes(const struct ff_problem *p, ff_fit_result *r)
{
    alone *a = malloc(sizeof *a);
    ff_status status = a ? FF_OK : FF_ERR_MEMORY;
    for (uint32_t lobe = 0; lobe < r->model.n_lobes && !status; lobe++) {
        const ff_warning_parameter named = {{FF_PARAM_SHAPE, fitted_shape(r, &r->model.lobe[lobe])}, FF_NO_CHANNEL};
        if (named.parameter.index < r->model.n_shape) status = warn_of(p, lobe, &named, a, r);
    }
    free(a);
    return status;
}
