/* One input for what reads texts that are no measurements: JSON, results of fits, expressions, command lines. */
#ifndef FF_FUZZ_TEXT_H
#define FF_FUZZ_TEXT_H
#include <stddef.h>
#include <stdint.h>

/** As fuzz_reader, for the target of this name: json, fit_document, expressions, words. -1 when there is none. */
int fuzz_text(const char *target, const uint8_t *data, size_t size);
#endif
