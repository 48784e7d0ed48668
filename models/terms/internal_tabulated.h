/* The kernels of `tabulated` that make its table. */
#ifndef FF_INTERNAL_TABULATED_H
#define FF_INTERNAL_TABULATED_H
#include "internal_term.h"

#define ff_tabulated_lambda FF_ISA_NAME(ff_tabulated_lambda)

/* Fills t->lambda from t->c. storage [FF_LAMBDA_FINE]. */
void ff_tabulated_lambda(ff_profile_table *t, double *storage);
#endif
