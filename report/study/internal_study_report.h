/* What the parts of a study share. */
#ifndef FF_INTERNAL_STUDY_REPORT_H
#define FF_INTERNAL_STUDY_REPORT_H
#include "ff_study.h"
#include "report/ff_report.h"

struct ff_study {
    const ff_table *table;
    char *path, *command;
    const char *words[1]; /* of the command */
    ff_fit_options options;
    int compares;
    ff_model *model; /* [n_models], which the fits have copies of */
    size_t n_models;
    size_t n_problems;
    ff_problem **problem;
    size_t n_fits;
    ff_fit_result *fit; /* [n_fits] */
    ff_looks looks;
    ff_adaptive *adaptive; /* how the loss was chosen; then problem and fit are its own */
    ff_problem *adaptive_problem[1];
    size_t n_notes;
    char **note;
    int no_memory; /* 1: a note could not be kept */
    void (*busy)(void *context, const char *what);
    void *busy_context;
};

/* For the functions of ff_report.h; it borrows s. */
ff_report_fits ff_study_report(const ff_study *s);

/* What `write` writes, kept. */
ff_status ff_content_keep(ff_status (*write)(const void *context, FILE *out), const void *context, ff_content *out);

/* Is fit i there? FF_ERR_RANGE. */
ff_status ff_study_check_fit(const ff_study *s, size_t i, ff_error *err);

#endif
