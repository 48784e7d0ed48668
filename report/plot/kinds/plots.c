/* The registry. */
#include "internal_plots.h"

static const ff_plot_kind *const kinds[] = {
#define FF_PLOT(name) &ff_plot_##name,
#include "plots.def"
#undef FF_PLOT
};

const ff_plot_kind *ff_plot_kind_at(size_t i)
{
    return i < sizeof kinds / sizeof *kinds ? kinds[i] : NULL;
}
