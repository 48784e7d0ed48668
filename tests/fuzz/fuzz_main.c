/* The entry of libFuzzer, for the format FF_FUZZ_FORMAT. */
#include "fuzz_reader.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);
int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    fuzz_reader(FF_FUZZ_FORMAT, data, size);
    return 0;
}
