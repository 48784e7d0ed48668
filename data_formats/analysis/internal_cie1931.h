/** @file internal_cie1931.h  CIE 1931 2-degree observer and illuminant D65 at 360, 365, ..., 830 nm. */
#ifndef FF_INTERNAL_CIE1931_H
#define FF_INTERNAL_CIE1931_H

enum { FF_CIE_FIRST_NM = 360, FF_CIE_STEP_NM = 5, FF_CIE_N = 95 };

extern const double ff_cie1931[FF_CIE_N][3]; /**< colour-matching functions x, y, z            */
extern const double ff_cie_d65[FF_CIE_N];    /**< relative spectral power, 100 at 560 nm       */

#endif
