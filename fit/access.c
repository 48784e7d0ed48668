/* Fits for programs that do not see inside: models and results behind pointers, options of any version. */
#include "fit/interface/fit_struct.h"
#include <stdlib.h>

ff_status ff_problem_new(const ff_table *t, const ff_model *const *models, size_t n_models, const ff_fit_options *o,
                         ff_problem **out, ff_error *err)
{
    ff_fit_options own;
    o = ff_fit_options_take(o, &own, err);
    if (!o) return FF_ERR_RANGE;
    ff_model *all = malloc((n_models + 1) * sizeof *all);
    if (!all) return ff_error_set(err, FF_ERR_MEMORY, NULL, 0, -1, "out of memory");
    for (size_t k = 0; k < n_models; k++) all[k] = *models[k];
    const ff_status status = ff_problem_make(t, all, n_models, o, out, err);
    free(all);
    return status;
}

ff_status ff_problem_fit(const ff_problem *p, const ff_model *m, const ff_fit_options *o, ff_fit_result **out, ff_error *err)
{
    ff_fit_options own;
    o = ff_fit_options_take(o, &own, err);
    if (!o) return FF_ERR_RANGE;
    ff_fit_result *made = malloc(sizeof *made);
    if (!made) return ff_error_set(err, FF_ERR_MEMORY, NULL, 0, -1, "out of memory");
    const ff_status status = ff_problem_fit_into(p, m, o, made, err);
    if (status)
        free(made);
    else
        *out = made;
    return status;
}
