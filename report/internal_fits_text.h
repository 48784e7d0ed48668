/* Shared by the texts and tables of fits and of comparisons. */
#ifndef FF_INTERNAL_FITS_TEXT_H
#define FF_INTERNAL_FITS_TEXT_H
#include "internal_columns.h"
#include "internal_report.h"
#include "internal_text.h"

const char *ff_report_plural(size_t n); /* "" for one, else "s" */

/* The problem of fit i. */
const ff_problem *ff_report_problem_of(const ff_report_fits *r, size_t i);

/* What was fitted, by which loss, and what was given besides the data. */
void ff_report_selection_text(const ff_report_fits *r, FILE *out);
/* "channel r: " where every channel has its own fit. */
void ff_report_problem_text(const ff_report_fits *r, size_t p, FILE *out);

/* Is a value held where it always is unless someone asks: the mean slope, the scale of a lobe? Are those of all channels? */
int ff_report_left_alone(const ff_fit_value *v, const ff_param *info);
int ff_report_all_left_alone(const ff_fit_result *f, uint32_t k);

/* Free shape parameters: the roughness by its numbers alone, everything else as name=value. "0.2", "0.2/0.45 r=0.4 gamma=2.1" */
void ff_report_shape_cell(ff_cell *out, const ff_fit_result *f);
/* The free channel parameters of the lobes, or of what is under them; each with its name but a lone one called `lone`. */
void ff_report_channel_cells(ff_cell *out, const ff_fit_result *f, int of_lobes, const char *lone);
/* How the fit ended, unless it converged. */
void ff_report_outcome_cell(ff_cell *out, const ff_fit_result *f);

/* Of the first lobe; "-" when there is none. */
const char *ff_report_masking_name(const ff_fit_result *f);
const char *ff_report_ndf_name(const ff_fit_result *f);
void ff_report_base_names(ff_cell *out, const ff_model *m); /* "lambert+..." */
#endif
