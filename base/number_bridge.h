/* The only door to the number conversions of the C++ library, which know nothing of locales. */
#ifndef FF_NUMBER_BRIDGE_H
#define FF_NUMBER_BRIDGE_H
#ifdef __cplusplus
extern "C" {
#define FF_NOEXCEPT noexcept
#else
#define FF_NOEXCEPT
#endif

enum { FF_NUMBER_DIGITS = 17, FF_NUMBER_FIXED = 24 };

/* Writes a number of 1e-5 <= value < 1e15 without an exponent, in the fewest digits that read back as the same double and of those
 * the nearest to it. Returns the length (no '\0'). Any thread. */
unsigned ff_number_fixed(double value, char out[FF_NUMBER_FIXED]) FF_NOEXCEPT;

/* The fewest decimal digits of any value > 0, chosen likewise: digits[0] . digits[1] ... 10^exponent. Returns how many; the last
 * one is not 0. Any thread. */
int ff_number_digits(double value, char digits[FF_NUMBER_DIGITS], int *exponent) FF_NOEXCEPT;

#undef FF_NOEXCEPT

#ifdef __cplusplus
}
#endif
#endif
