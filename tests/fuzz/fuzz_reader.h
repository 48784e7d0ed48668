/* One input for the reader of one format. */
#ifndef FF_FUZZ_READER_H
#define FF_FUZZ_READER_H
#include <stddef.h>
#include <stdint.h>

/** Reads `data` as a file of `format` and, where it is one, checks the table and writes it again where the format can be written.
 *  Whatever is wrong ends the program with a message (abort), as a crash would. Returns 1 when it was read, 0 when refused. */
int fuzz_reader(const char *format, const uint8_t *data, size_t size);
#endif
