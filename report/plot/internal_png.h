/* PNG without compression, of few cells: one IDAT of stored deflate blocks, colours by a palette where 256 do. */
#ifndef FF_INTERNAL_PNG_H
#define FF_INTERNAL_PNG_H
#include <stddef.h>
#include <stdio.h>

/* rgb [ny][nx][3], 8 bits, as base64; a cell becomes times x times pixels, so that viewers that blur blur its edge alone. */
void ff_png_base64(size_t nx, size_t ny, const unsigned char *rgb, size_t times, FILE *out);

#endif
