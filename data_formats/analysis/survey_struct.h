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

#ifdef __cplusplus
}
#endif
#endif
