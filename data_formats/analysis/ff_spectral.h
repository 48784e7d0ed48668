/** @file ff_spectral.h  Many wavelengths become a few channels.
 *
 *  Every reduction is linear: channel k of the result is the sum over the channels c of weight[k][c] times f, in 1/sr, and its
 *  variance the sum of the squares of weight times standard deviation (the channels' errors are taken as independent).
 *
 *  Between its wavelengths f is taken to be linear. */
#ifndef FF_SPECTRAL_H
#define FF_SPECTRAL_H
#include "ff_api.h"
#include "ff_table.h"
#ifdef __cplusplus
extern "C" {
#endif

/** Reduces the channels of t; directions, grid, axes, weights, validity and notes stay, what its format kept to write the same file
 * again does not come along.
 *  @param text  one of
 *    "bands:NAME=A-B,NAME=A-B,..."  means over bands from A to B nm, by the trapezoidal rule; a band that the wavelengths cover
 * only in part is the mean over that part, and the table's note says so "srgb", "srgb:d65", "srgb:e"   linear sRGB r, g, b: CIE
 * 1931 2-degree observer, illuminant D65 (also for "srgb") or equal energy. A spectrum that is constant c gives r = g = b = c under
 * either: with D65 since that is sRGB's white, with E by adaptation of E to D65 (Bradford). Beyond the first and last wavelength f
 * stays as it is there (CIE 15); the note says how much of X, Y and Z that concerns. Colours outside of sRGB have a negative
 * channel. "channels:NAME,NAME,..."       those, in this order, to the bit "mean"                         the plain mean of all
 * channels
 *  @param out   written only on FF_OK; release it with ff_table_free.
 *  FF_ERR_SYNTAX, FF_ERR_UNKNOWN (a channel that is not there), FF_ERR_UNSUPPORTED (a channel without wavelength or two of the same
 *  for bands and srgb; a band outside of the wavelengths; wavelengths with less than half of Y), FF_ERR_RANGE (a band that is
 *  none), FF_ERR_DATA (no valid sample), FF_ERR_MEMORY. Any number of threads may reduce a table at once. */
FF_API ff_status ff_table_reduce(const ff_table *t, const char *text, ff_table **out, ff_error *err);

/** How channels make a colour that is shown, linear red, green and blue of Rec. 709: colour k is the sum over the channels c of
 *  matrix[k][c] times f. Channels named r, g and b are these; at least three with wavelengths are seen as "srgb" of ff_table_reduce
 *  sees them; three others are red, green and blue in their order. What is left (one channel, wavelengths that the eye hardly sees)
 * is grey: the mean of all.
 *  @param n        >= 1
 *  @param channel  [n]     names and wavelengths
 *  @param matrix   [3][n]  out
 *  FF_ERR_MEMORY. */
FF_API ff_status ff_spectral_colours(size_t n, const ff_channel *channel, double *matrix, ff_error *err);

#ifdef __cplusplus
}
#endif
#endif
