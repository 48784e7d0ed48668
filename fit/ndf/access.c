/* Retrievals for programs that do not see inside. */
#include "ndf_struct.h"
#include "base/internal_options.h"
#include <stdlib.h>

/* Options as long as they are here, those of the fits included. */
typedef struct whole_options {
    ff_ndf_options ndf;
    ff_fit_options fit;
} whole_options;

static ff_status take(const ff_ndf_options *o, whole_options *out, ff_error *err)
{
    ff_ndf_options_init(&out->ndf);
    ff_fit_options_init(&out->fit);
    out->fit.shape = FF_SHAPE_ISOTROPIC;
    const ff_status status =
        ff_options_take("ff_ndf_options", o, FF_END_OF(ff_ndf_options, nodes), &out->ndf, sizeof out->ndf, err);
    if (status) return status;
    const ff_fit_options *fit = out->ndf.fit ? ff_fit_options_take(out->ndf.fit, &out->fit, err) : &out->fit;
    out->ndf.fit = fit;
    return fit ? ff_ndf_options_check(&out->ndf, err) : FF_ERR_RANGE;
}

ff_status ff_ndf_problem_new(const ff_table *t, const ff_ndf_options *o, ff_problem **out, ff_error *err)
{
    whole_options own;
    ff_model models[FF_NDF_MODELS];
    ff_status status = take(o, &own, err);
    if (!status) status = ff_ndf_models(own.ndf.masking, models, err);
    return status ? status : ff_problem_make(t, models, FF_NDF_MODELS, own.ndf.fit, out, err);
}

ff_status ff_ndf_retrieve(const ff_problem *p, const ff_ndf_options *o, ff_ndf_result **out, ff_error *err)
{
    whole_options own;
    ff_status status = take(o, &own, err);
    if (status) return status;
    ff_ndf_result *made = malloc(sizeof *made);
    if (!made) return ff_error_set(err, FF_ERR_MEMORY, NULL, 0, -1, "out of memory");
    status = ff_ndf_retrieve_into(p, &own.ndf, made, err);
    if (status)
        free(made);
    else
        *out = made;
    return status;
}

void ff_ndf_result_free(ff_ndf_result *r)
{
    ff_ndf_result_clear(r);
    free(r);
}

size_t ff_ndf_result_row_count(const ff_ndf_result *r)
{
    return r->n_rows;
}

const ff_ndf_row *ff_ndf_result_row(const ff_ndf_result *r, size_t k)
{
    return k < r->n_rows ? &r->row[k] : NULL;
}

size_t ff_ndf_result_channel_count(const ff_ndf_result *r)
{
    return r->n_channels;
}

const ff_ndf_channel *ff_ndf_result_channel(const ff_ndf_result *r, size_t c)
{
    return c < r->n_channels ? &r->channel[c] : NULL;
}

const ff_ndf_measures *ff_ndf_result_measures(const ff_ndf_result *r)
{
    return &r->measures;
}

const ff_profile_table *ff_ndf_result_profile(const ff_ndf_result *r)
{
    return r->profile;
}

const ff_fit_result *ff_ndf_result_fit(const ff_ndf_result *r, int fit)
{
    return fit >= 0 && fit < FF_NDF_FITS ? &r->fit[fit] : NULL;
}

int ff_ndf_result_reference(const ff_ndf_result *r)
{
    return r->reference;
}

double ff_ndf_result_first(const ff_ndf_result *r)
{
    return r->first;
}

double ff_ndf_result_reach(const ff_ndf_result *r)
{
    return r->reach;
}

double ff_ndf_result_sure(const ff_ndf_result *r)
{
    return r->sure;
}

double ff_ndf_result_smooth(const ff_ndf_result *r)
{
    return r->smooth;
}

double ff_ndf_result_effective(const ff_ndf_result *r)
{
    return r->effective;
}

int ff_ndf_result_is_scaled(const ff_ndf_result *r)
{
    return r->scaled;
}

int ff_ndf_result_from_back_scatter(const ff_ndf_result *r)
{
    return r->from_back_scatter;
}

double ff_ndf_result_objective(const ff_ndf_result *r)
{
    return r->objective;
}

ff_outcome ff_ndf_result_outcome(const ff_ndf_result *r)
{
    return r->outcome;
}

double ff_ndf_result_seconds(const ff_ndf_result *r)
{
    return r->time_s;
}

size_t ff_ndf_result_warning_count(const ff_ndf_result *r)
{
    return r->warnings.n;
}

const ff_warning *ff_ndf_result_warning(const ff_ndf_result *r, size_t i)
{
    return i < r->warnings.n ? &r->warnings.item[i] : NULL;
}
