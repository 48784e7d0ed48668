/* The loss by pictures, for programs that do not see inside. */
#include "picture_struct.h"
#include <math.h>
#include <stdlib.h>

ff_status ff_fit_adaptive(const ff_table *t, const ff_model *m, const ff_fit_options *o, ff_adaptive **out, ff_error *err)
{
    ff_fit_options own;
    o = ff_fit_options_take(o, &own, err);
    if (!o) return FF_ERR_RANGE;
    ff_adaptive *made = malloc(sizeof *made);
    if (!made) return ff_error_set(err, FF_ERR_MEMORY, NULL, 0, -1, "out of memory");
    const ff_status status = ff_fit_adaptive_into(t, m, o, made, err);
    if (status)
        free(made);
    else
        *out = made;
    return status;
}

void ff_adaptive_free(ff_adaptive *a)
{
    if (a) ff_adaptive_clear(a);
    free(a);
}

size_t ff_adaptive_count(const ff_adaptive *a)
{
    return a->n;
}

size_t ff_adaptive_chosen(const ff_adaptive *a)
{
    return a->chosen;
}

ff_loss ff_adaptive_loss(const ff_adaptive *a, size_t k)
{
    return k < ff_adaptive_count(a) ? a->candidate[k].loss : (ff_loss)FF_LOSS_COUNT;
}

double ff_adaptive_difference(const ff_adaptive *a, size_t k)
{
    return k < ff_adaptive_count(a) ? a->candidate[k].difference : NAN;
}

const ff_fit_result *ff_adaptive_fit(const ff_adaptive *a, size_t k)
{
    return k < ff_adaptive_count(a) ? &a->candidate[k].fit : NULL;
}

ff_picture_coverage ff_adaptive_coverage(const ff_adaptive *a)
{
    return a->coverage;
}

const ff_problem *ff_adaptive_problem(const ff_adaptive *a)
{
    return a->problem;
}
