/* The coordinates in which ALTA's files name pairs of directions. */
#ifndef FF_INTERNAL_ALTA_H
#define FF_INTERNAL_ALTA_H
#include <stddef.h>

/* Angles: theta_l, phi_l, theta_v, phi_v in radians. */
typedef enum ff_alta_conversion {
    FF_ALTA_PAIR,    /* angle is a pair of directions                                */
    FF_ALTA_NO_PAIR, /* the coordinates are of no pair: a corner of a grid           */
    FF_ALTA_WRONG    /* they are not such coordinates at all: degrees, most probably */
} ff_alta_conversion;

typedef struct ff_alta_parametrisation {
    const char *name;
    size_t dimension;
    int isotropic;
    ff_alta_conversion (*convert)(const double *x, double angle[4]); /* NULL: the coordinates leave the pair open */
    const char *expected; /* the coordinates, or what they tell where that is not enough */
    const char *note;     /* what was chosen; NULL = nothing */
} ff_alta_parametrisation;

/* One of ALTA's parametrisations by its name in #PARAM_IN; NULL when there is none of it. */
const ff_alta_parametrisation *ff_alta_parametrisation_find(const char *name);
#endif
