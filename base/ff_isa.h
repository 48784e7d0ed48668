/** @file ff_isa.h  The instruction sets that the inner loops are built for.
 *
 *  Threads  every function may be called from many threads at once. */
#ifndef FF_ISA_H
#define FF_ISA_H
#include "ff_api.h"
#ifdef __cplusplus
extern "C" {
#endif

/** Instruction sets the kernels are built for; FF_ISA_BEST is the widest this processor has. Results of two sets differ by
 * rounding. */
typedef enum ff_isa { FF_ISA_BEST = 0, FF_ISA_SCALAR = 1, FF_ISA_AVX2 = 2, FF_ISA_AVX512 = 3 } ff_isa;
FF_API int ff_isa_available(ff_isa isa);    /**< 1 when built in and supported by this processor, else 0 */
FF_API const char *ff_isa_name(ff_isa isa); /**< "scalar", "avx2", "avx512"; for FF_ISA_BEST the one it stands for */
FF_API int ff_isa_find(const char *name);   /**< the ff_isa of a name ("best" included), -1 when unknown */

#ifdef __cplusplus
}
#endif
#endif
