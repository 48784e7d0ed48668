/* Text for people: its width on a terminal, numbers with the digits they deserve. Tables are in internal_columns.h. */
#ifndef FF_INTERNAL_TEXT_H
#define FF_INTERNAL_TEXT_H
#include "ff_status.h"
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

enum { FF_TEXT_NUMBER = 48 };

/* Columns that text takes on a terminal: code points, wide ones twice, combining marks and colours (ff_text_ink) none. */
size_t ff_text_width(const char *text);
/* Length in bytes of the most of text that takes no more than `width` columns. */
size_t ff_text_fitting(const char *text, size_t width);

/* What is worth a colour. */
typedef enum ff_ink { FF_INK_PLAIN, FF_INK_HEAD, FF_INK_GOOD, FF_INK_WARNING, FF_INK_BAD, FF_INK_FAINT } ff_ink;
/* The sequence that a terminal obeys (ECMA-48, SGR), "" without colour; FF_INK_PLAIN ends any. */
const char *ff_text_ink(int color, ff_ink ink);

/* Is this code one that a terminal obeys, or that changes the order or the lines of what stands around it? */
int ff_text_is_control(uint32_t code);
/* Prints text that others chose, a name of a file say: controls, and bytes that are no UTF-8, as \xNN each. */
void ff_text_print(const char *text, FILE *out);

/* What write prints, as one string in *text, to be freed whatever the status: that of write, or FF_ERR_MEMORY. */
ff_status ff_text_capture(ff_status (*write)(const void *context, FILE *out), const void *context, char **text);

/* Length of the valid UTF-8 sequence at text, 0 when there is none. */
size_t ff_text_sequence(const char *text, uint32_t *code);

/* `significant` digits, in plain or exponent notation as fits. Independent of the locale, as are the others. */
const char *ff_text_number(double x, int significant, char out[FF_TEXT_NUMBER]);
/* A fixed number of digits after the point. */
const char *ff_text_fixed(double x, int decimals, char out[FF_TEXT_NUMBER]);
/* Value and standard error, both cut at the second digit of the error; six digits and "-" where the error is not known. */
void ff_text_with_error(double value, double error, char out[FF_TEXT_NUMBER], char out_error[FF_TEXT_NUMBER]);
/* An end of an interval, or the value in it, that is `width` away from the other end: as many digits as ff_text_with_error, and
 * more where the number itself is so much smaller that nothing but zeros would be left of it. */
const char *ff_text_within(double x, double width, char out[FF_TEXT_NUMBER]);
/* The shortest text that reads back as the same double; "nan", "inf", "-inf". */
const char *ff_text_exact(double x, char out[FF_TEXT_NUMBER]);

#endif
