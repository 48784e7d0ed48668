/* Options of a fit: names as on the command line, defaults, ranges. */
#include "internal_interface.h"
#include "base/internal_options.h"
#include <math.h>
#include <string.h>

static const char *const weightings[FF_WEIGHT_COUNT] = {"auto", "solid-angle", "sample", "sigma", "noise"};
static const char *const shapes[FF_SHAPE_COUNT] = {"auto", "isotropic", "axis", "correlated"};
static const char *const modes[FF_CHANNELS_COUNT] = {"rgb", "mean", "each"};
static const char *const intervals[FF_INTERVAL_COUNT] = {"none",    "standard-error", "one-sided",
                                                         "profile", "bootstrap",      "jackknife"};
static const char *const sources[FF_ERROR_SOURCE_COUNT] = {"noise", "residuals", "incidences"};
static const char *const outcomes[] = {"converged", "stalled", "limit", "cancelled"};

static const char *name_of(const char *const *names, int count, int i)
{
    return i >= 0 && i < count ? names[i] : NULL;
}

static int find_in(const char *const *names, int count, const char *name)
{
    for (int i = 0; i < count; i++)
        if (strcmp(names[i], name) == 0) return i;
    return -1;
}

const char *ff_weighting_name(int weighting)
{
    return name_of(weightings, FF_WEIGHT_COUNT, weighting);
}

const char *ff_shape_name(int shape)
{
    return name_of(shapes, FF_SHAPE_COUNT, shape);
}

const char *ff_channel_mode_name(int mode)
{
    return name_of(modes, FF_CHANNELS_COUNT, mode);
}

const char *ff_interval_name(int interval)
{
    return name_of(intervals, FF_INTERVAL_COUNT, interval);
}

const char *ff_error_source_name(int source)
{
    return name_of(sources, FF_ERROR_SOURCE_COUNT, source);
}

int ff_error_source_find(const char *name)
{
    return find_in(sources, FF_ERROR_SOURCE_COUNT, name);
}

const char *ff_outcome_name(int outcome)
{
    return name_of(outcomes, 4, outcome);
}

int ff_weighting_find(const char *name)
{
    return find_in(weightings, FF_WEIGHT_COUNT, name);
}

int ff_shape_find(const char *name)
{
    return find_in(shapes, FF_SHAPE_COUNT, name);
}

int ff_channel_mode_find(const char *name)
{
    return find_in(modes, FF_CHANNELS_COUNT, name);
}

void ff_fit_options_init_size(ff_fit_options *o, size_t size)
{
    const ff_fit_options defaults = {.saturation = INFINITY,
                                     .noise_floor = -INFINITY,
                                     .max_theta = 80 * (3.14159265358979323846 / 180),
                                     .only_channel = -1,
                                     .max_iterations = 100,
                                     .std_errors = 1,
                                     .errors = FF_ERRORS_NOISE,
                                     .dense_channels = FF_DENSE_CHANNELS};
    ff_options_init(o, size, &defaults, sizeof defaults);
}

/* The first version had everything up to progress_context. */
const ff_fit_options *ff_fit_options_take(const ff_fit_options *o, ff_fit_options *own, ff_error *err)
{
    if (o->size != sizeof *o) {
        ff_fit_options_init(own);
        const size_t first = FF_END_OF(ff_fit_options, progress_context);
        if (ff_options_take("ff_fit_options", o, first, own, sizeof *own, err)) return NULL;
        o = own;
    }
    return ff_fit_options_check(o, err) ? NULL : o;
}

ff_status ff_fit_options_check(const ff_fit_options *o, ff_error *err)
{
    if (o->size != sizeof *o)
        return ff_error_set(err, FF_ERR_RANGE, NULL, 0, -1, "the options were not initialised by ff_fit_options_init");
    if (!ff_loss_name((int)o->loss) || !ff_robust_name((int)o->robust) || !ff_weighting_name((int)o->weighting) ||
        !ff_shape_name((int)o->shape) || !ff_channel_mode_name((int)o->channels) || !ff_error_source_name((int)o->errors))
        return ff_error_set(err, FF_ERR_RANGE, NULL, 0, -1,
                            "an option names no known loss, robust loss, weighting, shape, mode of channels or source of errors");
    if (!(o->max_theta > 0 && o->max_theta <= FF_HORIZON))
        return ff_error_set(err, FF_ERR_RANGE, NULL, 0, -1, "the largest angle must lie in (0, 90] degrees, found %g",
                            o->max_theta * (180 / 3.14159265358979323846));
    if (!(o->robust_scale >= 0 && isfinite(o->robust_scale)))
        return ff_error_set(err, FF_ERR_RANGE, NULL, 0, -1,
                            "the scale of a robust loss must be positive, or 0 to be estimated, found %g", o->robust_scale);
    if (!(o->noise_floor < o->saturation) || !(o->saturation > 0) || !(o->noise_sigmas >= 0) || !isfinite(o->noise_sigmas))
        return ff_error_set(
            err, FF_ERR_RANGE, NULL, 0, -1,
            "values are known between the noise floor and the saturation, which must be above it and positive: found %g and "
            "%g, and %g standard deviations",
            o->noise_floor, o->saturation, o->noise_sigmas);
    if (o->threads < 0 || o->threads > FF_THREADS_MOST || o->max_iterations < 0)
        return ff_error_set(err, FF_ERR_RANGE, NULL, 0, -1,
                            "0 to %d threads and at least 0 iterations can be asked for, found %d and %d", (int)FF_THREADS_MOST,
                            o->threads, o->max_iterations);
    if ((unsigned)o->isa > FF_ISA_AVX512)
        return ff_error_set(err, FF_ERR_RANGE, NULL, 0, -1, "%d is the number of no instruction set", (int)o->isa);
    if (o->only_channel < -1)
        return ff_error_set(err, FF_ERR_RANGE, NULL, 0, -1, "channel %d does not exist; -1 stands for all", o->only_channel);
    return FF_OK;
}

int ff_fit_cancelled(const ff_fit_options *o)
{
    return o->cancel && __atomic_load_n(o->cancel, __ATOMIC_RELAXED);
}
