/* The robust losses as people see them, and rho of a single residual: by number and name. */
#include "internal_robust.h"
#include <string.h>

#define FF_ROBUSTS_OF(suffix) extern const ff_robust_descriptor *const ff_robusts_##suffix[FF_ROBUST_COUNT]
FF_ROBUSTS_OF(scalar);
#ifdef FF_HAVE_AVX2
FF_ROBUSTS_OF(avx2);
#endif
#ifdef FF_HAVE_AVX512
FF_ROBUSTS_OF(avx512);
#endif

const ff_robust_descriptor *ff_robust_of(ff_isa isa, ff_robust robust)
{
    return ff_isa_available(isa) ? FF_ISA_PICK(isa, ff_robusts)[robust] : NULL;
}

int ff_robust_count(void)
{
    return FF_ROBUST_COUNT;
}

const ff_robust_info *ff_robust_at(int robust)
{
    return robust >= 0 && robust < FF_ROBUST_COUNT ? &ff_robusts_scalar[robust]->info : NULL;
}

const char *ff_robust_name(int robust)
{
    const ff_robust_info *info = ff_robust_at(robust);
    return info ? info->name : NULL;
}

int ff_robust_find(const char *name)
{
    for (int i = 0; i < FF_ROBUST_COUNT; i++)
        if (strcmp(ff_robusts_scalar[i]->info.name, name) == 0) return i;
    return -1;
}

double ff_robust_rho(ff_robust robust, double b, double r)
{
    return ff_robusts_scalar[robust]->rho(b, r);
}

double ff_robust_tuning(ff_robust robust)
{
    return ff_robust_at((int)robust)->tuning;
}
