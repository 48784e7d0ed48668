/** @file internal_scatter_plan.h  The angles of a text file of the family "ScatterAzimuth n, ScatterRadial n" that is to be
 * written: what the person asks for, else what the data have. */
#ifndef FF_INTERNAL_SCATTER_PLAN_H
#define FF_INTERNAL_SCATTER_PLAN_H
#include "internal_scatter_grid.h"

/** The axes that such formats have, some of them each. */
enum { FF_SCATTER_ROTATION, FF_SCATTER_INCIDENCE, FF_SCATTER_AZIMUTH, FF_SCATTER_RADIAL, FF_SCATTER_AXES };

/** What a format may have on its axes, degrees. */
typedef struct ff_scatter_limits {
    unsigned axes;                /**< bit k: it has axis k            */
    double most[FF_SCATTER_AXES]; /**< the largest angle; the least is 0 */
    double end[FF_SCATTER_AXES];  /**< where steps from 0 end          */
} ff_scatter_limits;

/** Ascending degrees of each axis. Zero-initialise; release with ff_scatter_plan_clear. */
typedef struct ff_scatter_plan {
    ff_values axis[FF_SCATTER_AXES];
} ff_scatter_plan;

/** Appends an angle; the n angles; from, from + step .. to. FF_ERR_MEMORY. */
ff_status ff_scatter_plan_add(ff_values *v, double angle, ff_error *err);
ff_status ff_scatter_plan_copy(ff_values *v, size_t n, const double *node, double factor, ff_error *err);
ff_status ff_scatter_plan_steps(ff_values *v, double from, double to, double step, ff_error *err);

/** Fills the axes that a text like "incidence:20,radial:0/2/5/10" names: a number by itself is a step, others are ascending angles.
 *  FF_ERR_SYNTAX, FF_ERR_RANGE, FF_ERR_MEMORY. */
ff_status ff_scatter_plan_parse(const char *grid, const ff_scatter_limits *limits, ff_scatter_plan *p, ff_error *err);

/** Fills axis k, rotation or incidence, with the data's own angles when they are few, else with steps over their range. Rotation 0
 *  comes again as 360: a reader that interpolates needs it. FF_ERR_MEMORY. */
ff_status ff_scatter_plan_from_data(const ff_table *t, int k, ff_scatter_plan *p, ff_error *err);

void ff_scatter_plan_clear(ff_scatter_plan *p);
#endif
