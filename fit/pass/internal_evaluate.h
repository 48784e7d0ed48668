/* The model over a block of samples, at points or as means over the aperture: what every pass sees of it. */
#ifndef FF_INTERNAL_EVALUATE_H
#define FF_INTERNAL_EVALUATE_H
#include "internal_pass.h"
#include <string.h>

/* The means of a block, all channels with their derivatives: into `work`. Where the centres suffice nothing is made; returns
 * whether that is so. */
int ff_evaluate_means(const ff_pass *pass, size_t block, ff_average_work *work);

/* What all channels share. b and work: of the thread; work NULL where samples are points. Returns what the values at the centres
 * are to be multiplied by, 0 where they are not to be used: work holds the means. */
static inline double ff_evaluate_begin(const ff_pass *pass, size_t block, const ff_geometry *g, ff_block *b, ff_average_work *work)
{
    if (work && !ff_evaluate_means(pass, block, work)) return 0;
    pass->prepared.kernels->block_shape(&pass->prepared, g, FF_BLOCK, b);
    return work ? pass->averaging->rules->detector[FF_LEVEL_CENTRE].weight[0] : 1;
}

/* f of channel c. */
static inline void ff_evaluate_value(const ff_pass *pass, const ff_geometry *g, size_t c, double centre, ff_block *b,
                                     const ff_average_work *work, double *restrict f)
{
    if (centre == 0) {
        memcpy(f, work->f + c * FF_BLOCK, FF_BLOCK * sizeof *f);
        return;
    }
    pass->prepared.kernels->block_value(&pass->prepared, g, FF_BLOCK, c, b, f);
    if (work)
        for (int i = 0; i < FF_BLOCK; i++) f[i] *= centre;
}

/* j times the derivatives of f by the columns of channel c. */
static inline void ff_evaluate_columns(const ff_pass *pass, size_t c, const double *restrict j, double centre, ff_block *b,
                                       const ff_average_work *work, double (*restrict column)[FF_BLOCK])
{
    const size_t P = pass->prepared.wanted.n_shape + pass->prepared.wanted.n_channel;
    if (centre != 0) pass->prepared.kernels->block_columns(&pass->prepared, FF_BLOCK, c, j, b, column);
    if (!work) return;
    for (size_t k = 0; k < P; k++) {
        const double *df = work->df + (c * work->n_columns + k) * FF_BLOCK;
        for (int i = 0; i < FF_BLOCK; i++) column[k][i] = centre == 0 ? j[i] * df[i] : centre * column[k][i];
    }
}

/* Room for as many threads where a pass needs it, else *out = NULL. FF_ERR_MEMORY. Released with ff_average_works_free. */
ff_status ff_evaluate_works(const ff_pass *pass, size_t threads, ff_average_work ***out);

/* The levels that samples need at parameters; parallel as ff_pass_run. NULL without memory. Released with free. */
ff_levels *ff_levels_new(const ff_pass *pass, int parallel);
#endif
