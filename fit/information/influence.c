/* What a sample, or a cluster of them, moves the parameters by. */
#include "internal_storage.h"

void ff_information_influence(const ff_information *info, const ff_normal *n, const double *score, double *influence)
{
    double *scaled = influence + info->P; /* the caller's influences have room for two */
    for (size_t k = 0; k < info->P; k++) scaled[k] = n->diagonal ? score[k] : score[k] * info->scale[k];
    info->storage->apply(info, scaled, influence);
}
