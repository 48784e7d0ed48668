/** @file ff_polarization.h  Which light a channel was measured with, as its name says.
 *
 *  A laser is polarized, and a surface reflects light that is polarized across the plane of incidence (s, transverse electric)
 * better than light within it (p, transverse magnetic): at Brewster's angle a dielectric reflects no p light at all. Files of both
 * keep them as channels whose names say which is which. */
#ifndef FF_POLARIZATION_H
#define FF_POLARIZATION_H
#include "ff_api.h"

/** The share of s light of a channel by its name: 1 where one of its words is s, te, perp, perpendicular or senkrecht, 0 for p, tm,
 *  par, parallel, 0.5 for unpolarized or mean; "s-pol", "633nm_p", "TE", "Spol" are such names. NAN when no word says it, or two
 * say different things. Any thread. */
FF_API double ff_polarization_of_name(const char *name);
#endif
