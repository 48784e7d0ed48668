/* What is told of fits, for programs that do not see inside: options of any version, what is made behind pointers. */
#include "base/internal_options.h"
#include "trust_struct.h"
#include <stdlib.h>
#include <string.h>

static ff_status no_memory(ff_error *err)
{
    return ff_error_set(err, FF_ERR_MEMORY, NULL, 0, -1, "out of memory");
}

/* ---- places ---------------------------------------------------------------------------------- */

ff_status ff_places_new(const ff_problem *p, const ff_table *t, ff_places **out, ff_error *err)
{
    ff_places *made = malloc(sizeof *made);
    if (!made) return no_memory(err);
    const ff_status status = ff_places_init(p, t, made, err);
    if (status)
        free(made);
    else
        *out = made;
    return status;
}

void ff_places_free(ff_places *places)
{
    if (places) ff_places_clear(places);
    free(places);
}

ff_grouping ff_places_grouping(const ff_places *places)
{
    return places->kind;
}

size_t ff_places_group_count(const ff_places *places)
{
    return places->n_groups;
}

size_t ff_places_direction_count(const ff_places *places)
{
    return places->n_directions;
}

/* ---- values ---------------------------------------------------------------------------------- */

ff_status ff_trust_bands(const ff_problem *p, const ff_places *places, const ff_fit_options *o, const ff_fit_result *fit,
                         ff_bands *out, ff_error *err)
{
    ff_fit_options own;
    o = ff_fit_options_take(o, &own, err);
    return o ? ff_trust_bands_into(p, places, o, fit, out, err) : FF_ERR_RANGE;
}

ff_status ff_trust_residual_table(const ff_problem *p, const ff_table *t, const ff_fit_options *o, const ff_fit_result *fit,
                                  ff_table **out, ff_error *err)
{
    ff_fit_options own;
    ff_table made;
    o = ff_fit_options_take(o, &own, err);
    if (!o) return FF_ERR_RANGE;
    const ff_status status = ff_trust_residual_table_into(p, t, o, fit, &made, err);
    return status ? status : ff_table_move(&made, out, err);
}

ff_status ff_trust_explained(const ff_problem *p, const ff_fit_options *o, const ff_fit_result *fit, ff_explained *out,
                             ff_error *err)
{
    ff_fit_options own;
    ff_explained found;
    ff_status status = ff_record_check("ff_explained", out, FF_END_OF(ff_explained, worst_share), err);
    o = ff_fit_options_take(o, &own, err);
    if (!o) return FF_ERR_RANGE;
    if (!status) status = ff_trust_explained_into(p, o, fit, &found, err);
    if (!status) ff_options_init(out, out->size, &found, sizeof found);
    return status;
}

ff_status ff_trust_outliers(const ff_problem *p, const ff_places *places, const ff_fit_options *o, const ff_fit_result *fit,
                            ff_outliers *out, ff_error *err)
{
    ff_fit_options own;
    ff_outliers found;
    ff_status status = ff_record_check("ff_outliers", out, FF_END_OF(ff_outliers, worst), err);
    o = ff_fit_options_take(o, &own, err);
    if (!o) return FF_ERR_RANGE;
    if (!status) status = ff_trust_outliers_into(p, places, o, fit, &found, err);
    if (!status) ff_options_init(out, out->size, &found, sizeof found);
    return status;
}

ff_status ff_trust_next(const ff_problem *p, const ff_table *t, const ff_places *places, const ff_fit_options *o,
                        const ff_fit_result *fit, const ff_fit_result *rival, double reach, ff_next *out, ff_error *err)
{
    ff_fit_options own;
    ff_next found;
    ff_status status = ff_record_check("ff_next", out, FF_END_OF(ff_next, channel), err);
    o = ff_fit_options_take(o, &own, err);
    if (!o) return FF_ERR_RANGE;
    if (!status) status = ff_trust_next_into(p, t, places, o, fit, rival, reach, &found, err);
    if (!status) ff_options_init(out, out->size, &found, sizeof found);
    return status;
}

/* ---- intervals ------------------------------------------------------------------------------- */

ff_status ff_trust_bootstrap(const ff_problem *p, const ff_places *places, const ff_fit_options *o, size_t repeats, uint64_t seed,
                             ff_fit_result *fit, ff_bootstrap *out, ff_error *err)
{
    ff_fit_options own;
    ff_bootstrap made;
    ff_status status = ff_record_check("ff_bootstrap", out, FF_END_OF(ff_bootstrap, kind), err);
    o = ff_fit_options_take(o, &own, err);
    if (!o) return FF_ERR_RANGE;
    if (!status) status = ff_trust_bootstrap_into(p, places, o, repeats, seed, fit, &made, err);
    if (!status) ff_options_init(out, out->size, &made, sizeof made);
    return status;
}

ff_status ff_trust_cut_off(const ff_problem *p, const ff_fit_options *o, const ff_fit_result *fit, double max_theta,
                           ff_cut_off **out, ff_error *err)
{
    ff_fit_options own;
    o = ff_fit_options_take(o, &own, err);
    if (!o) return FF_ERR_RANGE;
    if (!(max_theta > 0 && max_theta <= FF_HORIZON))
        return ff_error_set(err, FF_ERR_RANGE, NULL, 0, -1, "the largest angle must lie in (0, 90] degrees, found %g",
                            max_theta / FF_DEGREES);
    ff_cut_off *made = malloc(sizeof *made);
    if (!made) return no_memory(err);
    const ff_status status = ff_trust_cut_off_into(p, o, fit, max_theta, made, err);
    if (status)
        free(made);
    else
        *out = made;
    return status;
}

void ff_cut_off_free(ff_cut_off *c)
{
    if (c) ff_cut_off_clear(c);
    free(c);
}

/* ---- comparison ------------------------------------------------------------------------------ */

/* The results side by side; they share what they own. */
static ff_fit_result *side_by_side(const ff_fit_result *const *fits, size_t n)
{
    ff_fit_result *all = malloc((n + 1) * sizeof *all);
    for (size_t k = 0; all && k < n; k++) all[k] = *fits[k];
    return all;
}

ff_status ff_trust_compare(const ff_problem *p, const ff_places *places, const ff_fit_options *o, const ff_fit_result *const *fits,
                           size_t n, size_t winner, size_t folds, ff_versus *out, ff_error *err)
{
    ff_fit_options own;
    o = ff_fit_options_take(o, &own, err);
    if (!o) return FF_ERR_RANGE;
    ff_fit_result *all = side_by_side(fits, n);
    if (!all) return no_memory(err);
    const ff_status status = ff_trust_compare_into(p, places, o, all, n, winner, folds, out, err);
    free(all);
    return status;
}

ff_status ff_trust_likeliest(const ff_problem *p, const ff_fit_options *o, const ff_fit_result *const *fits, size_t n, size_t *out,
                             ff_error *err)
{
    ff_fit_options own;
    o = ff_fit_options_take(o, &own, err);
    if (!o) return FF_ERR_RANGE;
    ff_fit_result *all = side_by_side(fits, n);
    if (!all) return no_memory(err);
    size_t found = 0;
    ff_status status = n ? FF_OK : ff_error_set(err, FF_ERR_RANGE, NULL, 0, -1, "none of no fits is the likeliest");
    if (!status) status = ff_trust_likeliest_into(p, o, all, n, &found, err);
    free(all);
    if (!status) *out = found;
    return status;
}

ff_status ff_trust_channels_differ(const ff_fit_result *const *fits, size_t n, ff_difference *out, ff_error *err)
{
    ff_fit_result *all = side_by_side(fits, n);
    if (!all) return no_memory(err);
    const ff_status status = ff_trust_channels_differ_into(all, n, out, err);
    free(all);
    return status;
}
