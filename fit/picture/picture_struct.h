/* Fits with every loss as plain values: what ff_picture.h closes to others. */
#ifndef FF_PICTURE_STRUCT_H
#define FF_PICTURE_STRUCT_H
#include "ff_picture.h"
#include "fit/interface/fit_struct.h"
#ifdef __cplusplus
extern "C" {
#endif

/** A fit with one of the losses. */
typedef struct ff_adaptive_candidate {
    ff_loss loss;
    double difference; /**< as ff_picture_difference */
    ff_fit_result fit;
} ff_adaptive_candidate;

struct ff_adaptive {
    size_t n; /**< candidates, in the order of ff_loss                                    */
    ff_adaptive_candidate candidate[FF_LOSS_COUNT];
    size_t chosen; /**< index of the one that was chosen                                       */
    ff_picture_coverage coverage;
    ff_problem *problem; /**< the samples as the chosen loss has them                                */
};

/* What a black picture differs from those of the table by. */
double ff_picture_black(const ff_picture *p);

/* ff_fit_adaptive into what is the caller's; and what releases what it owns. The options are as long as they are here. */
ff_status ff_fit_adaptive_into(const ff_table *t, const ff_model *m, const ff_fit_options *o, ff_adaptive *out, ff_error *err);
void ff_adaptive_clear(ff_adaptive *a);

#ifdef __cplusplus
}
#endif
#endif
