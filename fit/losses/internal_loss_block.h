/* Losses over a block of samples, for files that are compiled once per instruction set. */
#ifndef FF_INTERNAL_LOSS_BLOCK_H
#define FF_INTERNAL_LOSS_BLOCK_H
#include "internal_loss.h"
#include "models/internal_model.h"

#define FF_LOSS_ENTRY(NAME, id) extern const ff_loss_descriptor FF_ISA_NAME(ff_loss_##id);
#include "ff_losses.def"
extern const ff_loss_descriptor *const FF_ISA_NAME(ff_losses)[FF_LOSS_COUNT];

/* r = w (g(f) - t) and j = dr/df. surrogate: the loss is linear whichever it was, see ff_problem_subsample. */
static inline void ff_loss_residuals(ff_loss loss, int linearised, const ff_loss_planes *l, const double *restrict f,
                                     double *restrict r, double *restrict j)
{
    const ff_loss_descriptor *d = FF_ISA_NAME(ff_losses)[loss];
    if (d->residuals && !linearised) {
        d->residuals(l, f, r, j);
        return;
    }
    for (int i = 0; i < FF_BLOCK; i++) {
        r[i] = l->w[i] * (f[i] - l->t[i]);
        j[i] = l->w[i];
    }
}

#endif
