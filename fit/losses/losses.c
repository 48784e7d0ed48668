/* The losses as people see them, and what is computed of them once: by number and name. */
#include "internal_loss.h"
#include <string.h>

#define FF_LOSSES_OF(suffix) extern const ff_loss_descriptor *const ff_losses_##suffix[FF_LOSS_COUNT]
FF_LOSSES_OF(scalar);
#ifdef FF_HAVE_AVX2
FF_LOSSES_OF(avx2);
#endif
#ifdef FF_HAVE_AVX512
FF_LOSSES_OF(avx512);
#endif

const ff_loss_descriptor *ff_loss_of(ff_isa isa, ff_loss loss)
{
    return ff_isa_available(isa) ? FF_ISA_PICK(isa, ff_losses)[loss] : NULL;
}

/* ---- names ----------------------------------------------------------------------------------- */

int ff_loss_count(void)
{
    return FF_LOSS_COUNT;
}

const ff_loss_info *ff_loss_at(int loss)
{
    return loss >= 0 && loss < FF_LOSS_COUNT ? &ff_losses_scalar[loss]->info : NULL;
}

const char *ff_loss_name(int loss)
{
    const ff_loss_info *info = ff_loss_at(loss);
    return info ? info->name : NULL;
}

int ff_loss_find(const char *name)
{
    for (int i = 0; i < FF_LOSS_COUNT; i++)
        if (strcmp(ff_losses_scalar[i]->info.name, name) == 0) return i;
    return -1;
}

/* ---- of the baseline ------------------------------------------------------------------------- */

int ff_loss_is_curved(ff_loss loss)
{
    return ff_losses_scalar[loss]->residuals != NULL;
}

int ff_loss_reads_cosine(ff_loss loss)
{
    return ff_losses_scalar[loss]->reads_cosine;
}

int ff_loss_weighs_data(ff_loss loss)
{
    return ff_losses_scalar[loss]->factor_of_datum != NULL;
}

int ff_loss_has_value(ff_loss loss, double y, double x)
{
    const ff_loss_descriptor *d = ff_losses_scalar[loss];
    return !d->has_value || d->has_value(y, x);
}

void ff_loss_targets(ff_loss loss, size_t n, const double *y, const double *x, double *g)
{
    if (ff_loss_is_curved(loss))
        ff_losses_scalar[loss]->target(n, y, x, g);
    else if (g != y)
        memcpy(g, y, n * sizeof *g);
}

static void ones(size_t n, double *out)
{
    for (size_t i = 0; i < n; i++) out[i] = 1;
}

void ff_loss_slopes(ff_loss loss, size_t n, const double *y, const double *x, double *slope)
{
    if (ff_loss_is_curved(loss))
        ff_losses_scalar[loss]->slope(n, y, x, slope);
    else
        ones(n, slope);
}

void ff_loss_factors(ff_loss loss, size_t n, const double *y, const double *x, double least, double *factor)
{
    const ff_loss_descriptor *d = ff_losses_scalar[loss];
    if (d->factor)
        d->factor(n, x, factor);
    else if (d->factor_of_datum)
        d->factor_of_datum(n, y, x, least, factor);
    else
        ones(n, factor);
}
