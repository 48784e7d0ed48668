/* The lattice from which the distribution `tabulated` takes its profile, closed to others; ff_profile.h makes one. It is not
 * changed any more once it is made, and may be read from many threads. */
#ifndef FF_PROFILE_TABLE_STRUCT_H
#define FF_PROFILE_TABLE_STRUCT_H

enum {
    FF_PROFILE_OCTAVE_LO = -40, /**< the lattice covers q2 = 2^-40 .. 2^40, with 32 bins per octave */
    FF_PROFILE_OCTAVE_HI = 40,
    FF_PROFILE_BINS = 32 * (FF_PROFILE_OCTAVE_HI - FF_PROFILE_OCTAVE_LO),
    FF_PROFILE_LAMBDA = 9600
};

typedef struct ff_profile_table ff_profile_table;

/** The lattice: ln p = c0 + c1 u + c2 u^2 + c3 u^3 in each bin, u in [0, 1] even in q2. 155 KiB; a plain value. */
struct ff_profile_table {
    double c[4][FF_PROFILE_BINS];
    double lambda[FF_PROFILE_LAMBDA]; /**< Smith's Lambda, see internal_lambda_table.h                    */
    double area;                      /**< projected area of the values as they were given: the factor that was taken out      */
    double half_q2;                   /**< s of the file's head: about the square of the roughness                             */
};
#endif
