/* The kernels of the instruction set that is asked for. */
#include "internal_kernel.h"
#include <stdlib.h>

extern const ff_kernels ff_kernels_scalar;
#ifdef FF_HAVE_AVX2
extern const ff_kernels ff_kernels_avx2;
#endif
#ifdef FF_HAVE_AVX512
extern const ff_kernels ff_kernels_avx512;
#endif

const ff_kernels *ff_kernels_get(ff_isa isa)
{
    return ff_isa_available(isa) ? FF_ISA_PICK(isa, &ff_kernels) : NULL;
}

ff_block_work *ff_block_work_new(size_t count)
{
    ff_block_work *work = aligned_alloc(64, (count ? count : 1) * sizeof *work);
    for (size_t i = 0; work && i < count; i++) work[i].block.d = &work[i].slopes;
    return work;
}
