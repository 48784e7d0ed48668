/* Shared by the text and the JSON of fits. */
#ifndef FF_INTERNAL_REPORT_H
#define FF_INTERNAL_REPORT_H
#include "ff_report.h"

enum { FF_REPORT_NAME = FF_PARAM_NAME + FF_CHANNEL_NAME + 4 };

enum { FF_REPORT_KEY = 144 };
/* "f0", or "f0[r]" of a constraint that names a channel. Returns name or out. */
const char *ff_report_key(const char *name, const char *channel, char out[FF_REPORT_KEY]);

/* Is per-channel parameter k held in every channel? */
int ff_report_all_held(const ff_fit_result *f, uint32_t k);

/* From more channels than these on, text has a row for each channel, and a comparison the range of a parameter over them. */
enum { FF_REPORT_CHANNELS = 8 };

/* The fit of problem p with the lowest objective. */
const ff_fit_result *ff_report_best(const ff_report_fits *r, size_t p);
/* What fit f differs from the best by; NULL where that was not asked for. */
const ff_versus *ff_report_versus(const ff_report_fits *r, const ff_fit_result *f);
/* Is f not the best and not told apart from it? */
int ff_report_is_tied(const ff_report_fits *r, const ff_fit_result *f, const ff_fit_result *best);
/* The simplest fit of a problem that is not told apart from the best, the one with the lowest objective of several; best where no
 * test was possible, since being simple is no reason then. */
const ff_fit_result *ff_report_simplest(const ff_report_fits *r, const ff_fit_result *best);

/* Radians as degrees, without the dust of the conversion: 80, not 80.000000000000014. */
double ff_report_degrees(double radians);

/* "alpha_x", "f0[r]": the parameter of a column of the correlation matrix. Returns out. */
const char *ff_report_column_name(const ff_problem *p, const ff_fit_result *f, size_t column, char out[FF_REPORT_NAME]);

/* The parameter that a tied value follows. */
const ff_model_param *ff_report_followed(const ff_fit_result *f, const ff_fit_value *v);

/* "f0[r]", or "f0" when there is one channel. Returns out. */
const char *ff_report_channel_param(const ff_problem *p, const ff_fit_result *f, uint32_t k, size_t c, char out[FF_REPORT_NAME]);

/* Parts of the reports of fits that say how far these can be trusted: trust_text.c, trust_json.c. */
void ff_report_trust_of_fit(const ff_report_fits *r, size_t i, FILE *out);     /* lines under a fit                      */
ff_status ff_report_budget_text(const ff_report_fits *r, size_t i, FILE *out); /* likewise; nothing where there is none      */
void ff_report_outliers_text(const ff_report_fits *r, size_t i, FILE *out);
ff_status ff_report_bands_text(const ff_report_fits *r, const size_t *row, size_t n, FILE *out); /* of the fits row [n] */
void ff_report_trust_json(ff_json *j, const ff_report_fits *r, size_t i); /* keys of a fit's open object            */

/* Lines "note: ..." of a table, and its key "notes": info.c. */
void ff_report_put_notes(const ff_table *t, FILE *out);
void ff_report_notes_json(ff_json *j, const ff_table *t);

/* A deviation of logarithms as a percentage. Returns out [FF_TEXT_NUMBER of internal_text.h]. */
const char *ff_report_percent(double deviation, char *out);
#endif
