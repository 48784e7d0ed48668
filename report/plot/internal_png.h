/* PNG without compression, of few cells: one IDAT of stored deflate blocks. */
#ifndef FF_INTERNAL_PNG_H
#define FF_INTERNAL_PNG_H
#include <stddef.h>
#include <stdio.h>

/* rgb [ny][nx][3], 8 bits, as base64. */
void ff_png_base64(size_t nx, size_t ny, const unsigned char *rgb, FILE *out);

#endif
