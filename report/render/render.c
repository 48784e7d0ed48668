/* The functions of ff_render.h that make a picture. */
#include "internal_render.h"
#include "base/internal_options.h"
#include <math.h>

void ff_render_options_init_size(ff_render_options *o, size_t size)
{
    const ff_render_options defaults = {.pixels = 512, .samples = 256, .seed = 1};
    ff_options_init(o, size, &defaults, sizeof defaults);
}

static ff_status check_light(const double v[3], size_t l, ff_error *err)
{
    if (isfinite(v[0]) && isfinite(v[1]) && isfinite(v[2]) && (v[0] != 0 || v[1] != 0 || v[2] != 0)) return FF_OK;
    return ff_error_set(err, FF_ERR_RANGE, NULL, 0, -1, "light %zu: found (%g, %g, %g), expected finite numbers that are not all 0",
                        l + 1, v[0], v[1], v[2]);
}

static ff_status check(const ff_render_options *o, ff_error *err)
{
    if (o->pixels < 1 || o->pixels > FF_RENDER_PIXELS_MAX)
        return ff_error_set(err, FF_ERR_RANGE, NULL, 0, -1, "a picture of %zu pixels a side, expected 1 to %d", o->pixels,
                            FF_RENDER_PIXELS_MAX);
    if (!(o->perspective >= 0 && o->perspective <= 2.9))
        return ff_error_set(err, FF_ERR_RANGE, NULL, 0, -1, "a perspective of %g, expected 0 to 2.9 radians", o->perspective);
    if (o->samples < 1 || o->samples > FF_RENDER_SAMPLES_MAX)
        return ff_error_set(err, FF_ERR_RANGE, NULL, 0, -1, "%zu samples a pixel, expected 1 to %d", o->samples,
                            FF_RENDER_SAMPLES_MAX);
    if (o->threads < 0 || o->threads > 1024)
        return ff_error_set(err, FF_ERR_RANGE, NULL, 0, -1, "%d threads, expected 0 to 1024", o->threads);
    if (o->n_lights > FF_RENDER_LIGHTS_MAX || (o->n_lights && !o->light))
        return ff_error_set(err, FF_ERR_RANGE, NULL, 0, -1, "%zu lights, expected at most %d, and where they are", o->n_lights,
                            FF_RENDER_LIGHTS_MAX);
    if (!ff_isa_available(o->isa))
        return ff_error_set(err, FF_ERR_UNSUPPORTED, NULL, 0, -1, "this processor has no %s", ff_isa_name(o->isa));
    for (size_t l = 0; l < o->n_lights; l++) {
        const ff_status status = check_light(o->light[l], l, err);
        if (status != FF_OK) return status;
    }
    return FF_OK;
}

/* The caller's options over the defaults, checked. */
static ff_status take(const ff_render_options *from, ff_render_options *own, ff_error *err)
{
    ff_render_options_init(own);
    const ff_status status =
        ff_options_take("ff_render_options", from, FF_END_OF(ff_render_options, cancel), own, sizeof *own, err);
    return status == FF_OK ? check(own, err) : status;
}

static ff_status render(const ff_surface *s, const ff_render_options *o, float *rgba, ff_render_summary *out, ff_error *err)
{
    const ff_status status = ff_render_surface(s, o, rgba, out);
    if (status == FF_ERR_CANCELLED) return ff_error_set(err, status, NULL, 0, -1, "cancelled");
    if (status != FF_OK) return ff_error_set(err, status, NULL, 0, -1, "no memory for a picture of %zu pixels a side", o->pixels);
    return FF_OK;
}

ff_status ff_render_model(const ff_model *m, size_t n_channels, const double *shape, const double *channel,
                          const ff_render_options *o, float *rgba, ff_render_summary *out, ff_error *err)
{
    ff_render_options own;
    ff_surface s = {0};
    ff_status status = take(o, &own, err);
    if (status == FF_OK) status = ff_surface_of_model(m, own.isa, n_channels, shape, channel, &s, err);
    if (status == FF_OK) status = render(&s, &own, rgba, out, err);
    ff_surface_clear(&s);
    return status;
}

ff_status ff_render_table(const ff_table *t, const ff_model *by, size_t n_channels, const double *shape, const double *channel,
                          const ff_render_options *o, float *rgba, ff_render_summary *out, ff_error *err)
{
    ff_render_options own;
    ff_surface s = {0};
    ff_status status = take(o, &own, err);
    if (status == FF_OK) status = ff_surface_of_table(t, by, own.isa, n_channels, shape, channel, &s, err);
    if (status == FF_OK) status = render(&s, &own, rgba, out, err);
    ff_surface_clear(&s);
    return status;
}
