/* The choice of an instruction set, made anew at each call: it costs a few nanoseconds and keeps the library free of state. */
#include "internal_kernel.h"
#include <string.h>

extern const ff_kernels ff_kernels_scalar;
#ifdef FF_HAVE_AVX2
extern const ff_kernels ff_kernels_avx2;
#endif
#ifdef FF_HAVE_AVX512
extern const ff_kernels ff_kernels_avx512;
#endif

int ff_isa_available(ff_isa isa)
{
    switch (isa) {
    case FF_ISA_BEST:
    case FF_ISA_SCALAR:
        return 1;
#ifdef FF_HAVE_AVX2
    case FF_ISA_AVX2:
        return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma");
#endif
#ifdef FF_HAVE_AVX512
    case FF_ISA_AVX512:
        return __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl") &&
               __builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("fma");
#endif
    default:
        return 0;
    }
}

ff_isa ff_isa_resolve(ff_isa isa)
{
    if (isa != FF_ISA_BEST) return isa;
    if (ff_isa_available(FF_ISA_AVX512)) return FF_ISA_AVX512;
    return ff_isa_available(FF_ISA_AVX2) ? FF_ISA_AVX2 : FF_ISA_SCALAR;
}

const char *ff_isa_name(ff_isa isa)
{
    switch (ff_isa_resolve(isa)) {
    case FF_ISA_SCALAR:
        return "scalar";
    case FF_ISA_AVX2:
        return "avx2";
    case FF_ISA_AVX512:
        return "avx512";
    default:
        return "unknown";
    }
}

int ff_isa_find(const char *name)
{
    if (strcmp(name, "best") == 0) return FF_ISA_BEST;
    for (int i = FF_ISA_SCALAR; i <= FF_ISA_AVX512; i++)
        if (strcmp(name, ff_isa_name((ff_isa)i)) == 0) return i;
    return -1;
}

const ff_kernels *ff_kernels_get(ff_isa isa)
{
    return ff_isa_available(isa) ? FF_ISA_PICK(isa, &ff_kernels) : NULL;
}
