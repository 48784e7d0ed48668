/* A pass over a layout by itself, as the tests of its numbers make one. */
#ifndef FF_PASS_OF_H
#define FF_PASS_OF_H
#include "fit/problem/internal_problem.h"
#include <stdlib.h>

static inline ff_status pass_of(const ff_layout *l, const ff_problem *p, const ff_fit_options *o, const double *shape,
                                const double *channel, ff_pass *pass)
{
    const ff_plan plan = ff_plan_with(l, p, o);
    return ff_plan_pass(&plan, shape, channel, pass);
}

/* J^T J [P][P] and J^T r [P] of a pass; slope as ff_gram_fill. */
static inline void assemble(const ff_layout *l, const ff_normal *n, const double *slope, double *H, double *g)
{
    ff_gram gram;
    if (ff_gram_new(l, &gram)) abort();
    ff_gram_fill(l, n, slope, &gram);
    ff_gram_dense(&gram, H, g);
    ff_gram_free(&gram);
}
#endif
