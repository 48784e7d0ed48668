/** @file ff_report.h  What a person or a program reads about fits, tables and the registries: text and JSON.
 *
 *  Everything goes to a stream of the caller's, whose errors stay in the stream (ferror; ff_output_commit looks). The _text
 *  functions are for people: aligned columns, units, the digits that the standard errors allow. The _json functions write one
 *  document whose "schema" names its shape; keys are never removed or changed in meaning within a version, only added.
 *  Numbers  do not depend on the locale.
 *  Errors   ff_status: FF_ERR_MEMORY; the text is then incomplete.
 *  Threads  no global state. */
#ifndef FF_REPORT_H
#define FF_REPORT_H
#include "fit/interface/fit_struct.h"
#include "targets/internal_target.h"
#include "ff_json.h"
#include "fit/ndf/ndf_struct.h"
#include "fit/picture/picture_struct.h"
#include "fit/fitting/internal_fitting.h"
#include "data_formats/interpolation/resample_struct.h"
#include "fit/trust/trust_struct.h"
#include "report/words/words_struct.h"
#ifdef __cplusplus
extern "C" {
#endif

/** The JSON documents. Of each the program knows the JSON Schema, which docs/schema/ and an installation have as files too. */
typedef enum ff_schema {
    FF_SCHEMA_NONE = 0,
#define FF_SCHEMA(ID) FF_SCHEMA_##ID,
#include "ff_schemas.def"
#undef FF_SCHEMA
    FF_SCHEMA_COUNT
} ff_schema;
/** Name and version, "facetfit.fit/2": what the document says under "schema". NULL for a number that is none. */
const char *ff_schema_name(ff_schema schema);
/** Writes the schema itself, of draft 2020-12. FF_ERR_RANGE for a number that is none. */
ff_status ff_report_schema_json(ff_schema schema, FILE *out);

/** What was asked, for the head of every JSON document. */
typedef struct ff_report_head {
    const char *version;
    size_t n_command;
    const char *const *command; /**< [n_command] words of the command line                      */
} ff_report_head;

/** Writes "schema", "version" and "command" into the open object of j. */
void ff_report_head_json(ff_json *j, ff_schema schema, const ff_report_head *head);

/** How text for people is laid out. All 0, or a NULL in its place: lines as long as they are, no colours. Whatever the style, a
 * line of text has the same beginning. */
typedef struct ff_report_style {
    size_t width; /**< columns of the terminal: tables leave out what there is no room for; 0 = any   */
    int color;    /**< 1: with colours (ECMA-48)                                                        */
} ff_report_style;

/** Passes on what `write` writes, text, with lines that are longer than style->width broken between words; what a line continues
 *  with is indented further than the line. style NULL: as it is.
 *  @return the status of write, or FF_ERR_MEMORY */
ff_status ff_report_fold(ff_status (*write)(const void *context, FILE *out), const void *context, const ff_report_style *style,
                         FILE *out);

/** For which renderer a fit was made. */
typedef struct ff_report_target {
    const ff_target *target;
    const ff_material *material;
    const ff_fit_result *free;  /**< a fit of a free model to the same problem; NULL: there is none */
    const ff_bands *free_bands; /**< its residuals by angle; NULL                                   */
} ff_report_target;

/** Written forms of the main table of a report, for --table: text as in the report; CSV (RFC 4180) and TSV for programs, with a
 *  name for every column, all digits, and empty cells where there is no number; Markdown and LaTeX (tabular) to be pasted. */
typedef enum ff_table_form {
    FF_TABLE_TEXT = 0,
    FF_TABLE_CSV = 1,
    FF_TABLE_TSV = 2,
    FF_TABLE_MARKDOWN = 3,
    FF_TABLE_LATEX = 4
} ff_table_form;
const char *ff_table_form_name(int form); /**< "text", "csv", "tsv", "md", "latex"; NULL for a number that is none */

/** A flag of a command that is suggested: another value than the person's own, a flag that was not given, or none of it. */
typedef struct ff_report_change {
    const char *flag;  /**< its name without dashes                 */
    const char *value; /**< NULL: the flag is left out               */
} ff_report_change;

/** The person's own command line for another command, "plot residuals", on the same data read in the same way: with the changes
 * [n], without what only writes. The model is that of a change: flags that choose models do not go along. Into out [size], quoted
 * for a shell. 0: there is no such command line. */
typedef int ff_report_again(const void *context, const char *command, const ff_report_change *change, size_t n, char *out,
                            size_t size);

/** Fits of one data set. A problem is a choice of channels: one for rgb and mean, one per channel for each. Every model is fitted
 *  to every problem; fit k belongs to problem k / (n_fits / n_problems). */
typedef struct ff_report_fits {
    ff_report_head head;
    const char *path;      /**< of the data                                       */
    const ff_table *table; /**< format and notes                                  */
    const ff_fit_options *options;
    size_t n_problems;
    const ff_problem *const *problem; /**< [n_problems]                                      */
    size_t n_fits;                    /**< a multiple of n_problems                          */
    const ff_fit_result *fit;         /**< [n_fits]                                          */
    const ff_fit_trust *trust;        /**< [n_fits], NULL = none                              */
    const ff_report_target *target;   /**< [n_fits], NULL: for none                           */
    size_t folds;                     /**< of the cross-validation; 0 = none                  */
    const ff_places *places;          /**< [n_problems], NULL where nothing needed them        */
    const ff_difference *difference;  /**< between the channels, each fitted alone; NULL       */
    const ff_adaptive *adaptive;      /**< how the loss was chosen, where it was; else NULL; fit is its chosen one */
    size_t rows;                      /**< of a comparison's text, at most; 0 = all            */
    const ff_report_style *style;     /**< of text; NULL = plain                               */
    ff_report_again *again;           /**< the command lines that it suggests; NULL: none      */
    const void *again_context;        /**< of again                                            */
    int without_times;                /**< 1: the JSON says nothing of how long it took: equal fits, equal bytes */
} ff_report_fits;

/** As ff_fits_rank, of the fits of problem p: their numbers among all, into rank [n_fits / n_problems]. */
void ff_report_rank(const ff_report_fits *r, size_t p, size_t *rank);

/** The fits of problem p that are the best of their masking, the best of all first: their numbers among all, *row [*n], which the
 *  caller frees.
 *  @returns FF_OK, or FF_ERR_MEMORY with *row NULL. */
ff_status ff_report_best_of_maskings(const ff_report_fits *r, size_t p, size_t **row, size_t *n);

/** Warnings of s: a line each, "  warning: ...", or the key "warnings" of the open object of j, an array of {"code", "severity",
 *  "parameter" or "parameters", "channel" or "channels", "values": {name: number}, "text"}; those that do not apply are absent. */
void ff_report_warnings_text(const ff_words_subject *s, const ff_warnings *w, FILE *out);
void ff_report_warnings_json(ff_json *j, const ff_words_subject *s, const ff_warnings *w);

/** The lines of the warnings of fit i. */
void ff_report_fit_warnings(const ff_report_fits *r, size_t i, FILE *out);

/** The verdict, then fits one after another: parameters, ellipse, residuals, warnings. */
ff_status ff_report_fit_text(const ff_report_fits *r, FILE *out);

/** The verdict, then fits as rows, best first and marked '*', at most r->rows of them, then the best objective of every masking. */
ff_status ff_report_compare_text(const ff_report_fits *r, FILE *out);

/** Writes the root mean squares of r into the open object of j, a key for every loss that has one: "cosine_rmse", "cube_root_rmse".
 */
void ff_report_rmses_json(ff_json *j, const ff_residual *r);

/** The main table alone: a row for every parameter of every fit; a row for every fit, by problem and rank. In CSV and TSV of a
 *  comparison all of them, and a column for every parameter. */
ff_status ff_report_fit_table(const ff_report_fits *r, ff_table_form form, FILE *out);
ff_status ff_report_compare_table(const ff_report_fits *r, ff_table_form form, FILE *out);

/** FF_SCHEMA_FIT, of `fit` and `compare`. */
ff_status ff_report_fits_json(const ff_report_fits *r, FILE *out);

/** Residuals of a fit, a row a sample that it used, as CSV: angles in degrees (theta_i, phi_i, theta_o, phi_o, theta_h, theta_d),
 * then for every channel f_NAME (datum), model_NAME and residual_NAME = model - datum, 1/sr. residuals: ff_trust_residual_table of
 * t and the problem's channels; t must have as many channels, or else their mean is the datum. */
ff_status ff_report_residuals_csv(const ff_table *t, const ff_table *residuals, const char *title, FILE *out);

/** What was written for a renderer, or as code or a table. */
typedef struct ff_report_export {
    ff_report_head head;
    const char *from, *expression; /**< the document of the fit, and its model                               */
    const char *path, *as, *title; /**< of what was written: its name, its kind, in words                   */
    const ff_target *target;       /**< NULL: code or a table                                               */
    const ff_material *material;
    size_t n_channels;
    const double *control; /**< [ff_control_count][n_channels]                                      */
    int is_own;            /**< 1: nothing had to be fitted                                         */
    double left;           /**< as ff_refit                                                         */
    size_t n_lost;
    const struct ff_lost *lost; /**< [n_lost]                                                             */
} ff_report_export;
struct ff_refit;
/** Sets what a material's fit says, which it borrows, as control [ff_control_count][n_channels]. */
void ff_report_export_take(const ff_target *target, const struct ff_refit *r, const double *control, ff_report_export *out);
ff_status ff_report_export_text(const ff_report_export *r, FILE *out);
ff_status ff_report_export_json(const ff_report_export *r, FILE *out); /**< FF_SCHEMA_EXPORT */

/** A retrieved distribution of normals. */
typedef struct ff_report_ndf {
    const char *path;      /**< of the data                     */
    const ff_table *table; /**< its format                      */
    const ff_problem *problem;
    const ff_ndf_options *options; /**< those of the fit among them     */
    const ff_ndf_result *result;
    const ff_report_style *style; /**< of text; NULL = plain           */
} ff_report_ndf;

/** How it was retrieved, its roughness in several measures, the parameters, and its residuals beside those of the formulas. */
ff_status ff_report_ndf_text(const ff_report_ndf *n, FILE *out);
ff_status ff_report_ndf_table(const ff_report_ndf *n, ff_table_form form, FILE *out); /**< a row for every measure and parameter */

/** What is in a table: size, channels, range of angles and values, coverage, reflectance, symmetries as ff_survey_new measures
 * them. */
ff_status ff_report_table_text(const char *path, const ff_table *t, const ff_report_style *style, FILE *out);
ff_status ff_report_table_json(const ff_report_head *head, const char *path, const ff_table *t, FILE *out); /**< FF_SCHEMA_INFO */
/** The first `most` samples of a table, a line each. */
ff_status ff_report_samples_text(const ff_table *t, size_t most, FILE *out);

ff_status ff_report_channels_table(const ff_table *t, ff_table_form form, FILE *out); /**< a row for every channel */

/** What a conversion did: `made` was written to out_path. */
ff_status ff_report_resample_text(const char *in, const char *out_path, const ff_format *to, const ff_table *t,
                                  const ff_table *made, const ff_resample_report *r, FILE *out);
ff_status ff_report_resample_json(const ff_report_head *head, const char *in, const char *out_path, const ff_format *to,
                                  const ff_table *t, const ff_table *made, const ff_resample_report *r,
                                  FILE *out); /**< FF_SCHEMA_RESAMPLE */
/** A sentence about energy that was lost or gained; "" where that is little. */
void ff_report_resample_warning(const ff_resample_report *r, char out[FF_WORDS_SENTENCE]);

/** The registries. */
ff_status ff_report_models_text(const ff_report_style *style, FILE *out);
/** Those that are called so, of every kind; FF_ERR_UNKNOWN where there is none, and nothing was printed. */
ff_status ff_report_model_text(const char *name, const ff_report_style *style, FILE *out);
ff_status ff_report_models_markdown(FILE *out);                         /**< docs/models.md */
ff_status ff_report_models_table(ff_table_form form, FILE *out);        /**< a row for every term */
ff_status ff_report_models_json(const ff_report_head *head, FILE *out); /**< FF_SCHEMA_MODELS */
ff_status ff_report_formats_text(const ff_report_style *style, FILE *out);
ff_status ff_report_formats_table(ff_table_form form, FILE *out);
ff_status ff_report_formats_json(const ff_report_head *head, FILE *out); /**< FF_SCHEMA_FORMATS */

/** Passes on what `write` writes, a page of Markdown, with its prose broken into lines of at most 100 columns; tables, headings and
 *  indented code stay as they are.
 *  @return the status of write, or FF_ERR_MEMORY */
ff_status ff_report_page(ff_status (*write)(const void *context, FILE *out), const void *context, FILE *out);

/** Text that is independent of the locale and reads back as the same double ("nan", "inf" where not finite).
 *  @param out  [FF_REPORT_NUMBER] */
enum { FF_REPORT_NUMBER = 48 };
const char *ff_report_number(double x, char *out);

#ifdef __cplusplus
}
#endif
#endif
