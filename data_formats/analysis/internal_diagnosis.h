/* What a finding is about. */
#ifndef FF_INTERNAL_DIAGNOSIS_H
#define FF_INTERNAL_DIAGNOSIS_H
#include "ff_diagnosis.h"

/* 1: what the values are, not how the angles are counted. */
int ff_diagnosis_is_of_values(const ff_finding *finding);

#endif
