/** @file internal_number.h  Numbers in text, whatever the locale of the program is. */
#ifndef FF_INTERNAL_NUMBER_H
#define FF_INTERNAL_NUMBER_H
#include <stddef.h>

/** Reads a decimal number [+-]digits[.digits][e[+-]digits] at text, correctly rounded, and returns where it ends; NULL when none
 *  stands there (nan, inf and hexadecimal are none). Text must end in a character that cannot continue a number, e.g. '\0'.
 *  A number too large for a double gives an infinity: the caller decides. */
const char *ff_number_read(const char *text, double *value);

/** Reads text [length] as a number with an exponent after D, as Fortran writes it: 1.5D-03. 0 when it is none that is finite. */
int ff_number_read_fortran(const char *text, size_t length, double *value);

enum { FF_NUMBER_TEXT = 32 };
/** Writes the fewest digits that read back as the same double; returns the length (no '\0'). The value must be finite. */
unsigned ff_number_write(double value, char out[FF_NUMBER_TEXT]);
#endif
