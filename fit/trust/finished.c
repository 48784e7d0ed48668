/* A finished fit taken up again where it ended: its plan and its point. */
#include "internal_trust.h"

ff_status ff_finished_open(const struct ff_problem *p, const ff_fit_options *o, const ff_fit_result *fit, ff_finished *out,
                           ff_error *err)
{
    ff_status status = ff_plan_of_result(p, o, fit, &out->plan, err);
    if (!status && ff_point_of_result(&out->plan, fit, &out->at)) {
        ff_plan_free(&out->plan);
        status = ff_error_set(err, FF_ERR_MEMORY, NULL, 0, -1, "out of memory");
    }
    if (!status && fit->noise && !(out->at.noise = ff_noise_found_copy(fit->noise))) {
        ff_finished_close(out);
        status = ff_error_set(err, FF_ERR_MEMORY, NULL, 0, -1, "out of memory");
    }
    return status;
}

ff_status ff_finished_open_data(const struct ff_problem *p, const ff_fit_options *o, const ff_fit_result *fit, const char *what,
                                ff_finished *out, ff_error *err)
{
    if (o->constraints && (o->constraints->n_priors || o->constraints->energy_conserving))
        return ff_error_set(err, FF_ERR_UNSUPPORTED, NULL, 0, -1,
                            "%s fits to the samples alone and knows no priors nor conserved energy", what);
    return ff_finished_open(p, o, fit, out, err);
}

void ff_finished_close(ff_finished *f)
{
    ff_point_free(&f->at);
    ff_plan_free(&f->plan);
}

ff_status ff_trust_ended(ff_status status, const char *what, ff_error *err)
{
    if (status == FF_ERR_CANCELLED) return ff_error_set(err, status, NULL, 0, -1, "cancelled");
    return ff_error_set(err, status, NULL, 0, -1, "%s ended early: %s", what, ff_status_str(status));
}
