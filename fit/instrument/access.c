/* What the instrument adds, for programs that do not see inside: options of any version, what is made behind pointers. */
#include "base/internal_options.h"
#include "fit/trust/trust_struct.h"
#include <stdlib.h>

void ff_budget_options_init_size(ff_budget_options *u, size_t size)
{
    const ff_budget_options none = {0};
    ff_options_init(u, size, &none, sizeof none);
}

ff_status ff_trust_budget(const ff_problem *p, const ff_table *t, const ff_places *places, const ff_fit_options *o,
                          const ff_fit_result *fit, const ff_budget_options *u, ff_budget **out, ff_error *err)
{
    ff_fit_options own;
    ff_budget_options known;
    o = ff_fit_options_take(o, &own, err);
    if (!o) return FF_ERR_RANGE;
    ff_budget_options_init(&known);
    ff_status status = ff_options_take("ff_budget_options", u, FF_END_OF(ff_budget_options, aperture), &known, sizeof known, err);
    if (status) return status;
    ff_budget *made = malloc(sizeof *made);
    if (!made) return ff_error_set(err, FF_ERR_MEMORY, NULL, 0, -1, "out of memory");
    status = ff_trust_budget_into(p, t, places, o, fit, &known, made, err);
    if (status)
        free(made);
    else
        *out = made;
    return status;
}

void ff_budget_free(ff_budget *b)
{
    if (b) ff_budget_clear(b);
    free(b);
}
