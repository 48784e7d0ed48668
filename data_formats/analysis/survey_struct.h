/* Surveys in memory of the caller's. */
#ifndef FF_SURVEY_STRUCT_H
#define FF_SURVEY_STRUCT_H
#include "data_formats/table/table_struct.h"
#include "ff_survey.h"
#ifdef __cplusplus
extern "C" {
#endif

/* ff_survey_new into a survey of the caller's; and what releases what it owns. */
ff_status ff_survey_init(const ff_table *t, ff_survey *out, ff_error *err);
void ff_survey_clear(ff_survey *s);

/* The reciprocity alone, with and without a cosine, of at most `most` of the samples: nothing else of *out means anything, and it
 * needs not be released. FF_ERR_MEMORY. */
ff_status ff_survey_reciprocity(const ff_table *t, size_t most, ff_survey *out);

#ifdef __cplusplus
}
#endif
#endif
