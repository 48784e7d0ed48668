/* Philox4x32-10 of Salmon, Moraes, Dror and Shaw, "Parallel random numbers: as easy as 1, 2, 3" (SC 2011): counter and key in, four
 * words out, no state. */
#ifndef FF_INTERNAL_PHILOX_H
#define FF_INTERNAL_PHILOX_H
#include <stdint.h>
void ff_philox(const uint32_t counter[4], const uint32_t key[2], uint32_t out[4]);
#endif
