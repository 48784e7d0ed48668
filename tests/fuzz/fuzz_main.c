/* The entry of libFuzzer, for the target FF_FUZZ_TARGET. With FF_FUZZ_PLAIN in the environment its own mutators alone. */
#include "fuzz_reader.h"
#include "fuzz_text.h"
#include "mutate.h"
#include <stdlib.h>

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);
size_t LLVMFuzzerMutate(uint8_t *data, size_t size, size_t most);
size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t most, unsigned seed);

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    if (fuzz_text(FF_FUZZ_TARGET, data, size) < 0) fuzz_reader(FF_FUZZ_TARGET, data, size);
    return 0;
}

/* One half of the inputs by structure, the other by bytes; libFuzzer does several of either in a row. */
size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t most, unsigned seed)
{
    static int plain = -1;
    if (plain < 0) plain = getenv("FF_FUZZ_PLAIN") != NULL;
    const size_t n = !plain && seed % 2 ? mutate_structure(FF_FUZZ_TARGET, data, size, most, seed / 2, LLVMFuzzerMutate) : 0;
    return n ? n : LLVMFuzzerMutate(data, size, most);
}
