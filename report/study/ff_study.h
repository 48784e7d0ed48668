/** @file ff_study.h  Fits of a data set with everything that the program says of them: reports, pages, figures, renderers' files.
 *
 *  ff_fit.h finds parameters. A study does what the commands `fit` and `compare` do around that: it fits a model, or many, to all
 *  channels or to each alone, asks how far the fits can be trusted, and writes what was found in every form that the program has.
 *
 *      ff_study_options s;
 *      ff_study_options_init(&s);
 *      ff_study *study;
 *      ff_content json;
 *      if (ff_study_new(table, (const ff_model *[]){model}, 1, &fit_options, &s, &study, &err)) ...
 *      if (ff_study_write(study, "json", &json, &err)) ...
 *      fwrite(json.text, 1, json.n, stdout);
 *      ff_content_clear(&json);
 *      ff_study_free(study);
 *
 *  Numbers  are those of ff_problem_fit to the last bit, and of the command with the same options.
 *  Memory   a study owns its problems and fits. It borrows the table, and what the options of the fit borrow (constraints, noise,
 *           an aperture): these outlive it unchanged. So do the tables of `tabulated` lobes.
 *  Errors   ff_status and ff_error; outputs are written only on FF_OK.
 *  Threads  no global state; one call at a time on a study. */
#ifndef FF_STUDY_H
#define FF_STUDY_H
#include "ff_api.h"
#include "ff_fit.h"
#include "ff_trust.h"
#ifdef __cplusplus
extern "C" {
#endif

/** Something written: n bytes and a 0 behind them. Release with ff_content_clear. */
typedef struct ff_content {
    char *text;
    size_t n;
} ff_content;
FF_API void ff_content_clear(ff_content *c); /**< what it holds; a zeroed one and NULL are allowed */

/* ---- studies --------------------------------------------------------------------------------- */

/** What is asked beyond the fits. Fill with ff_study_options_init, then change. */
typedef struct ff_study_options {
    size_t size;         /**< sizeof(ff_study_options)                                                             */
    const char *path;    /**< of the data, as reports name them; copied; NULL: "data"                               */
    const char *command; /**< how the study can be made again, as reports say it; copied; NULL: not said             */
    int compare;         /**< 1: the models are tested against the best, as `compare` does it, also where there is one */
    int choose_loss;     /**< 1: of one model, with the loss by which its pictures come closest (ff_picture.h)       */
    size_t bootstrap;    /**< refits, >= 20; 0: none. Of one model                                                  */
    uint64_t seed;       /**< of the bootstrap; 1                                                                   */
    int profile;         /**< 1: intervals by the profile of the objective; not with a bootstrap. Of one model         */
    size_t folds;        /**< >= 2: cross-validation of a comparison; 0: none                                        */
    double cut_off;      /**< a lower limit of theta at which parameters are looked at again, radians, in (0, max_theta);
                              NaN: 10 degrees below max_theta where that can be; 0: none. Of one model               */
    double reach;        /**< up to which theta_i an instrument can measure next, radians, in [0, pi/2), 0: that of the data;
                              NaN: nobody asks. A comparison always says it                                         */
    int errors_asked;    /**< 1: the errors of the fit options were asked for: what cannot be had is an error         */
    /** What is being done, for a person who waits: "3 of 28: ggx/...", "bootstrap", "" at its end. Called on the thread of the
     *  study; may be NULL. */
    void (*busy)(void *context, const char *what);
    void *busy_context;
} ff_study_options;

/** Writes the defaults into options of `size` bytes, the caller's sizeof, and nothing beyond. */
FF_API void ff_study_options_init_size(ff_study_options *o, size_t size);
static inline void ff_study_options_init(ff_study_options *o)
{
    ff_study_options_init_size(o, sizeof *o);
}

/** A finished study. Closed. */
typedef struct ff_study ff_study;

/** Fits n_models (>= 1) models to t: each channel by itself where fit->channels is FF_CHANNELS_EACH. Models that the options rule
 * out are left out of several, with a note. fit NULL: the defaults. Errors as ff_problem_new, ff_problem_fit and the functions of
 *  ff_trust.h; FF_ERR_RANGE for options; FF_ERR_UNSUPPORTED for what is of one model and asked of several, and for a loss to be
 * chosen for each channel or for robust forms. *out is written only on FF_OK; release it with ff_study_free. */
FF_API ff_status ff_study_new(const ff_table *t, const ff_model *const *models, size_t n_models, const ff_fit_options *fit,
                              const ff_study_options *o, ff_study **out, ff_error *err);
FF_API void ff_study_free(ff_study *s); /**< NULL is allowed */

/** Problems: one, or one for each channel. Fit k belongs to problem k / (ff_study_fit_count / ff_study_problem_count). What they
 * hand out belongs to the study; NULL when there are not so many. */
FF_API size_t ff_study_problem_count(const ff_study *s);
FF_API const ff_problem *ff_study_problem(const ff_study *s, size_t i);
FF_API size_t ff_study_fit_count(const ff_study *s);
FF_API const ff_fit_result *ff_study_fit(const ff_study *s, size_t i);

/** The number of the fit that comes `rank`-th among those of a problem, the best first (rank 0). (size_t)-1 for one that is none.
 */
FF_API size_t ff_study_ranked(const ff_study *s, size_t problem, size_t rank);

/** What fit i differs from the best of its problem by; NULL where that was not asked, or there is no such fit. */
FF_API const ff_versus *ff_study_versus(const ff_study *s, size_t i);

/** The options of the fits, with the loss that was chosen. They belong to the study. */
FF_API const ff_fit_options *ff_study_fit_options(const ff_study *s);

/** What a person should know though nothing failed, as a model that was left out: a sentence. NULL when there are not so many. */
FF_API const char *ff_study_note(const ff_study *s, size_t i);

/** Writes the study in a form: "text" (the report), "json" (docs/schema/fit.schema.json), "html" (the page), "summary" (verdict,
 *  ranking and parameters as a part of a page, without script), and the main table as "csv", "tsv", "md" or "latex".
 *  FF_ERR_UNKNOWN for another form; FF_ERR_MEMORY. */
FF_API ff_status ff_study_write(const ff_study *s, const char *form, ff_content *out, ff_error *err);

/** The same of a table: what is in it, as "text", "json" (docs/schema/info.schema.json) or "html". path is what it is called; NULL:
 *  "data". */
FF_API ff_status ff_table_describe(const ff_table *t, const char *path, const char *form, ff_content *out, ff_error *err);

/* ---- figures --------------------------------------------------------------------------------- */

/** Kinds of figures: "slice", "residuals", ...; NULL when there are not so many. */
FF_API const char *ff_plot_name(size_t i);

/** How a figure looks and what it shows; docs/plot.md says which kind looks at what. Fill with ff_plot_options_init, then change.
 */
typedef struct ff_plot_options {
    size_t size;             /**< sizeof(ff_plot_options)                                              */
    const char *form;        /**< "svg", "pdf" or "csv"; "svg"                                          */
    const char *title;       /**< NULL: that of the kind                                                */
    const char *channel;     /**< names, separated by commas; NULL: the middle one                       */
    const char *parameter;   /**< likewise; NULL: as the kind has it                                    */
    const double *incidence; /**< [n_incidence] degrees; borrowed                                        */
    size_t n_incidence;      /**< at most 32; 0: as the data have it                                    */
    int log;                 /**< 1, 0; -1 (as initialised): as the kind and the data have it            */
    size_t repeats;          /**< of a bootstrap; 200                                                   */
    uint64_t seed;           /**< 1                                                                    */
    double width, height;    /**< millimetres, 20 to 2000 and 15 to 2000; NaN: as is usual                */
    double font;             /**< points, 3 to 72; NaN: as is usual                                     */
    size_t per_row;          /**< panels side by side, at most 12; 0: as is usual                        */
    ff_isa isa;              /**< FF_ISA_BEST                                                          */
} ff_plot_options;
FF_API void ff_plot_options_init_size(ff_plot_options *o, size_t size);
static inline void ff_plot_options_init(ff_plot_options *o)
{
    ff_plot_options_init_size(o, sizeof *o);
}

/** Draws a kind of figure of a study's first problem: of its best fit, of its best ones where the kind shows several. o NULL: the
 *  defaults. FF_ERR_UNKNOWN for a kind, a form, a channel or a parameter that is none, FF_ERR_UNSUPPORTED for a kind that is not
 * drawn of this, FF_ERR_RANGE, FF_ERR_DATA where there is nothing to draw, FF_ERR_MEMORY. */
FF_API ff_status ff_study_plot(const ff_study *s, const char *kind, const ff_plot_options *o, ff_content *out, ff_error *err);

/** The same of a table alone. */
FF_API ff_status ff_table_plot(const ff_table *t, const char *kind, const ff_plot_options *o, ff_content *out, ff_error *err);

/** A model with its parameters as ff_model_eval takes them, and what a legend calls it. */
typedef struct ff_plotted {
    const char *label;
    const ff_model *model;
    size_t n_channels;
    const double *shape, *channel;
} ff_plotted;

/** The same of n (>= 1) models. */
FF_API ff_status ff_models_plot(const ff_plotted *m, size_t n, const char *kind, const ff_plot_options *o, ff_content *out,
                                ff_error *err);

/* ---- exports --------------------------------------------------------------------------------- */

/** What ff_study_export takes: renderers, languages, formats that can be written; NULL when there are not so many. */
FF_API const char *ff_export_name(size_t i);

/** Writes fit i for somebody else.
 *  @param to     a renderer ("blender") or one of its materials ("blender:metal"), a language ("c", "glsl", "hlsl", "osl"), a
 * format
 *  @param path   the file, which appears whole or not at all; the end of its name chooses among the files of a renderer. NULL: into
 *                *file, which a format cannot
 *  @param file   what would be in the file, with path NULL; else NULL
 *  @param about  what was written, the controls of the renderer and what was lost: JSON (docs/schema/export.schema.json); NULL: not
 *                needed
 *  FF_ERR_UNKNOWN for a name that is none; FF_ERR_UNSUPPORTED for what cannot be written (the message says why), FF_ERR_RANGE for a
 *  fit that is none, FF_ERR_WRITE, FF_ERR_MEMORY; else as ff_problem_fit, where the renderer's material has to be fitted. */
FF_API ff_status ff_study_export(const ff_study *s, size_t i, const char *to, const char *path, ff_content *file, ff_content *about,
                                 ff_error *err);

#ifdef __cplusplus
}
#endif
#endif
