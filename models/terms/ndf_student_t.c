/* student-t: slopes of a Student's t distribution of shape gamma. Ribardiere et al. 2017.
 *
 *   p(q2) = (1 + q2 / nu)^-(nu + 1) / pi,  nu = gamma - 1
 *
 * gamma = 2 is ggx, gamma -> infinity is beckmann. Lambda is exact here (see internal_student_t.h); the source has a rational
 * fit whose G1 is off by up to 0.007 and exceeds 1. */
#include "internal_terms.h"
#include "internal_student_t.h"

static const ff_param params[] = {
    FF_STRETCH_PARAMS, {"gamma", "1", "shape of the tails, gamma: 2 is ggx, large is beckmann", 1.51, 100, 3, FF_PARAM_LOG, -1}};

const ff_ndf FF_ISA_NAME(ff_ndf_student_t) = {
    .term = {.name = "student-t",
             .also = "student",
             .title = "Student's t slopes: from longer tails than ggx to beckmann",
             .source = "Ribardiere et al. 2017 (the distribution); Lambda exact by the incomplete beta function",
             .note = "gamma = 2 is ggx; above 40 hardly to be told from beckmann",
             .claims = FF_RECIPROCAL | FF_PASSIVE | FF_UNIT_AREA | FF_WEAK_FURNACE,
             .n_params = 6,
             .params = params,
             .contains = {"ggx", "gamma", 2}},
    .n_own = 1,
    .table_size = FF_STUDENT_T_TABLE,
    .prepare = ff_student_t_prepare,
    .profile = ff_student_t_profile,
    .lambda = ff_student_t_lambda,
};
