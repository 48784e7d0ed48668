/* Parts of the reports of fits that were made for a renderer. */
#ifndef FF_INTERNAL_CONTROLS_REPORT_H
#define FF_INTERNAL_CONTROLS_REPORT_H
#include "ff_report.h"
#include "fit/controls/internal_controls.h"

/* For how many channels control k is shown: 0 of one that says nothing of an isotropic fit. */
size_t ff_report_control_shown(const ff_report_target *t, const ff_fit_result *f, size_t k);

ff_status ff_report_controls_text(const ff_report_fits *r, size_t i, FILE *out); /* under fit i                    */
void ff_report_controls_json(ff_json *j, const ff_report_fits *r, size_t i);     /* a key of the open object of it */
#endif
