/* What an aperture is. */
#ifndef FF_INTERNAL_APERTURE_H
#define FF_INTERNAL_APERTURE_H
#include "ff_aperture.h"

/* Is it one, and is it more than a point? */
int ff_aperture_valid(const ff_aperture *a);
int ff_aperture_extended(const ff_aperture *a);
#endif
