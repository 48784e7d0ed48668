/* The influence H^-1 s of a score on the parameters of an arrowhead. */
#include "internal_influence.h"

void ff_arrowhead_apply(const ff_arrowhead *a, const double *score, double *influence)
{
    const size_t S = a->S, K = a->K;
    double left[FF_MAX_SHARED];
    for (size_t k = 0; k < S; k++) {
        left[k] = score[k];
        for (size_t q = 0; q < a->C * K; q++) left[k] -= a->follow[q * S + k] * score[S + q];
    }
    for (size_t k = 0; k < S; k++) {
        influence[k] = 0;
        for (size_t q = 0; q < S; q++) influence[k] += a->inverse[k * S + q] * left[q];
    }
    for (size_t k = 0; k < a->C * K; k++) {
        double v = 0;
        for (size_t q = 0; q < K; q++) v += a->own[k * K + q] * score[S + k / K * K + q];
        for (size_t q = 0; q < S; q++) v -= a->follow[k * S + q] * influence[q];
        influence[S + k] = v;
    }
}
