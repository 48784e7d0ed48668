/* The verdict: what a person wants to read first, in a few sentences. Each has a code; its numbers stand in the report beneath. */
#ifndef FF_INTERNAL_VERDICT_H
#define FF_INTERNAL_VERDICT_H
#include "ff_report.h"

typedef enum ff_verdict_code {
#define FF_VERDICT(ID, name) FF_VERDICT_##ID,
#include "ff_verdicts.def"
#undef FF_VERDICT
    FF_VERDICT_COUNT
} ff_verdict_code;

/* How well the model describes the data. */
typedef enum ff_quality { FF_QUALITY_UNKNOWN, FF_QUALITY_POOR, FF_QUALITY_FAIR, FF_QUALITY_GOOD } ff_quality;
/* Good: 98 % explained, bright values within 10 %, no band of angles off by 10 %. Fair: 90 %, 30 %, 30 %. */
ff_quality ff_quality_of(const ff_explained *e);

typedef struct ff_verdict {
    ff_verdict_code code;
    ff_quality quality; /* of FF_VERDICT_QUALITY */
    char text[FF_WORDS_SENTENCE];
} ff_verdict;

enum { FF_VERDICT_MOST = 10 };
/* The sentences about problem p: of a fit, or of a comparison. Returns how many. */
size_t ff_verdict_of(const ff_report_fits *r, size_t p, ff_verdict out[FF_VERDICT_MOST]);

/* ---- for the files of the sentences ---------------------------------------------------------- */

/* Adds to the text of v. */
void ff_verdict_put(ff_verdict *v, const char *format, ...) __attribute__((format(printf, 2, 3)));
size_t ff_verdict_models(const ff_report_fits *r);                                         /* of a problem                */
const ff_explained *ff_verdict_explained(const ff_report_fits *r, const ff_fit_result *f); /* NULL: nobody has looked     */
int ff_verdict_has_warning(const ff_fit_result *f, ff_warning_code code);
int ff_verdict_is_of_nothing(const ff_fit_result *f); /* 1: a lobe or base came out as nothing */

/* A command to try next, of a fit and of a comparison; and a figure of where a fit is off that is fair or poor. 0: none. */
int ff_verdict_next_of_fit(const ff_report_fits *r, const ff_fit_result *f, ff_verdict *v);
int ff_verdict_next_of_comparison(const ff_report_fits *r, const ff_fit_result *f, ff_verdict *v);
int ff_verdict_look(const ff_report_fits *r, const ff_fit_result *f, ff_verdict *v);

/* ---- out ------------------------------------------------------------------------------------- */

/* All of them as lines of text, or as "verdict" of the open object of j. FF_ERR_MEMORY. */
ff_status ff_report_verdict_text(const ff_report_fits *r, FILE *out);
ff_status ff_report_verdict_json(ff_json *j, const ff_report_fits *r);

#endif
