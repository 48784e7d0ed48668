/* Names of what is compiled once per instruction set, and the choice among them. */
#ifndef FF_INTERNAL_ISA_H
#define FF_INTERNAL_ISA_H
#include "ff_isa.h"

#define FF_CONCAT_(a, b) a##_##b
#define FF_CONCAT(a, b)  FF_CONCAT_(a, b)
/* name_scalar, name_avx2, name_avx512 in sources that are compiled once per instruction set */
#define FF_ISA_NAME(name) FF_CONCAT(name, FF_ISA_SUFFIX)

/* The one of three copies that stands for an available isa (FF_ISA_BEST included). */
#if defined(FF_HAVE_AVX2) && defined(FF_HAVE_AVX512)
#define FF_ISA_PICK(isa, name)                                                                                                     \
    (ff_isa_resolve(isa) == FF_ISA_AVX512 ? name##_avx512 : ff_isa_resolve(isa) == FF_ISA_AVX2 ? name##_avx2 : name##_scalar)
#else
#define FF_ISA_PICK(isa, name) ((void)(isa), name##_scalar)
#endif

/* FF_ISA_BEST -> the widest available one; others unchanged. */
ff_isa ff_isa_resolve(ff_isa isa);

#endif
