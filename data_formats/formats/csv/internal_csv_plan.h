/** @file internal_csv_plan.h  What csv_plan.c finds in a table and csv_assign.c decides about. */
#ifndef FF_INTERNAL_CSV_PLAN_H
#define FF_INTERNAL_CSV_PLAN_H
#include "internal_csv_look.h"
#include "internal_csv_meaning.h"
#include "base/internal_kept.h"
#include <stdio.h>

enum { FF_PLAN_NAME = 96, FF_PLAN_COLUMNS = 4096 };

typedef struct ff_plan_column {
    char name[FF_PLAN_NAME]; /**< in UTF-8                                  */
    ff_named named;
    double lo, hi; /**< of its numbers in the first rows; infinite: none  */
    int used;
} ff_plan_column;

/** A line of its own with a number: "Angle of incidence: 20 deg". */
typedef struct ff_plan_setting {
    char name[FF_PLAN_NAME];
    ff_csv_unit unit;
    double value; /**< the first           */
    size_t count;
    int changes; /**< others differ        */
} ff_plan_setting;

typedef struct ff_planner {
    const ff_csv_look *look;
    const char *path;
    ff_error *err;
    double small;
    int angles;       /**< ff_angles: what the person says of them, else the file's own comments */
    ff_csv_head head; /**< what these say                           */
    size_t header_line, n;
    ff_plan_column *column;                       /**< [n]                                       */
    ff_plan_setting setting[FF_MEANS_NUMBER + 1]; /**< by meaning                                */
    FILE *text;                                   /**< the option as it grows                */
    ff_kept kept;                                 /**< what was written to it                */
    ff_csv_plan plan;
} ff_planner;

/** Writes the option into p->text and says what it assumes. FF_ERR_FORMAT. */
ff_status ff_plan_assign(ff_planner *p);

/* ---- csv_option.c: the option as it grows -------------------------------------------------------- */

enum { FF_PLAN_NONE = -1 };

/** Adds a sentence to what had to be assumed; what does not fit is left out. */
void ff_plan_assume(ff_planner *p, const char *fmt, ...) __attribute__((format(printf, 2, 3)));

/** ":rad", ":nm", ...; "" for degrees and what needs none. */
const char *ff_plan_unit_text(ff_csv_unit unit);

void ff_plan_put_number(FILE *out, double v);
void ff_plan_put_separator(ff_planner *p);
void ff_plan_put_column(ff_planner *p, const char *key, size_t k, const char *unit);
void ff_plan_put_constant(ff_planner *p, const char *key, double v);
void ff_plan_put_setting(ff_planner *p, const char *key, ff_meaning meaning);

/** The option so far, for messages. */
const char *ff_plan_so_far(ff_planner *p);

const char *ff_plan_list_names(const ff_planner *p, char out[FF_NAMES_LIST]);
/** FF_ERR_FORMAT: the columns, why they are not read, and the option that would read them. */
ff_status ff_plan_refuse(ff_planner *p, const char *why, const char *say);
ff_status ff_plan_refuse_unnamed(ff_planner *p);

/** The option for columns in the order that most tables have. */
void ff_plan_guess(const ff_planner *p, char *out, size_t size);

/** The column of a meaning, without a number in its name; FF_PLAN_NONE. */
long ff_plan_find(const ff_planner *p, ff_meaning meaning);

#endif
