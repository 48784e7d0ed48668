/* The choice of an instruction set, made anew at each call: it costs a few nanoseconds and keeps the library free of state. */
#include "internal_isa.h"
#include <string.h>

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
