#include "compressed_point.h"
#include "pass_of.h"

ff_status compressed_point(const ff_problem *p, const ff_model *m, const ff_fit_options *o, size_t n_channels, const double *shape,
                           const double *channel, double *cost, double *gradient, double *gram)
{
    ff_layout layout;
    ff_pass pass;
    ff_normal normal;
    ff_status status = ff_layout_init(m, n_channels, FF_SHAPE_CORRELATED, 0, &layout, NULL);
    if (!status) status = ff_layout_normal(&layout, &normal);
    if (status) return status;
    status = pass_of(&layout, p, o, shape, channel, &pass);
    if (!status) {
        status = ff_pass_run(&pass, 1, &normal);
        ff_pass_free(&pass);
    }
    if (!status) {
        *cost = 0.5 * normal.cost2;
        assemble(&layout, &normal, NULL, gram, gradient);
    }
    ff_normal_free(&normal);
    return status;
}
