/** @file internal_plots.h  The kinds of figures: what each is made of, and the registry of all.
 *
 *  A kind is one file kind_NAME.c with one descriptor ff_plot_NAME, and one line of plots.def. It gets a subject (data, fits,
 * models) and fills a figure; what page and which form is nothing to it. */
#ifndef FF_INTERNAL_PLOTS_H
#define FF_INTERNAL_PLOTS_H
#include "report/plot/internal_figure.h"
#include "ff_fit_document.h"
#include "fit/interface/fit_struct.h"
#include "fit/trust/trust_struct.h"

/* A model with its values. Borrowed. */
typedef struct ff_plot_model {
    const char *label; /* in the legend */
    const ff_model *model;
    size_t n_channels;
    const double *shape, *channel;               /* as ff_model_eval                     */
    const char (*channel_name)[FF_CHANNEL_NAME]; /* [n_channels]; NULL: they have none    */
    const ff_noise *noise;                       /* of the data it was fitted to; NULL    */
    const char *outcome;                         /* of its fit; NULL                      */
    ff_aperture aperture;                        /* of the data it was fitted to; else a point */
} ff_plot_model;

/* What a figure is made of. What is not there is NULL or 0; a kind says what it needs. */
typedef struct ff_plot_subject {
    const char *path; /* of the data */
    const ff_table *table;
    double max_theta; /* radians: samples beyond were not fitted */
    size_t n_models;
    const ff_plot_model *model;
    const ff_fit_document *document;
    /* A fit of this run, for what is computed anew. */
    ff_problem *problem;
    const ff_places *places;
    const ff_fit_options *options;
    const ff_fit_result *fit;
} ff_plot_subject;

enum { FF_PLOT_LIST = 32 };

/* What a person may choose. */
typedef struct ff_plot_choice {
    size_t n_incidence;
    double incidence[FF_PLOT_LIST]; /* degrees                                                    */
    int log;                        /* 1, 0; -1: as the kind and the data have it                 */
    const char *channel;            /* names, separated by commas; NULL: the middle one           */
    const char *parameter;          /* likewise; NULL: as the kind has it                         */
    size_t n_roughness;
    double roughness[FF_PLOT_LIST]; /* alpha                                                      */
    size_t repeats;                 /* of a bootstrap                                             */
    uint64_t seed;
    ff_isa isa;
} ff_plot_choice;

/* What a kind takes and does. */
enum {
    FF_PLOT_DATA = 1 << 0,     /* reads measured data                                       */
    FF_PLOT_FITS = 1 << 1,     /* and a model of them: a fit, or one that is given          */
    FF_PLOT_COMPARES = 1 << 2, /* of several models where several are named                 */
    FF_PLOT_MODELS = 1 << 3,   /* draws models alone, by expression or of a document        */
    FF_PLOT_RESULTS = 1 << 4,  /* draws the document of a fit or comparison                 */
    FF_PLOT_FRESH = 1 << 5,    /* computes from a fit of this run: a document is not enough */
    FF_PLOT_TERMS = 1 << 6,    /* without a source: terms of the registry                   */
    FF_PLOT_MASKINGS = 1 << 7, /* of these, all maskings rather than all distributions      */
    FF_PLOT_BY_ANGLE = 1 << 8  /* looks at residuals by angle, which take a pass of their own */
};

/* Which choices it looks at; the others would go unnoticed. */
enum {
    FF_PLOT_INCIDENCE = 1 << 0,
    FF_PLOT_LOG = 1 << 1,
    FF_PLOT_CHANNEL = 1 << 2,
    FF_PLOT_PARAMETER = 1 << 3,
    FF_PLOT_ROUGHNESS = 1 << 4, /* of models: a curve for each */
    FF_PLOT_REFITS = 1 << 5,    /* a bootstrap                 */
    FF_PLOT_PROFILE = 1 << 6,   /* intervals by the profile    */
    FF_PLOT_SEVERAL = 1 << 7    /* several models              */
};

typedef struct ff_plot_kind {
    const char *name, *help; /* help: one line, without a full stop */
    unsigned takes, uses;
    /* FF_ERR_UNSUPPORTED and FF_ERR_UNKNOWN for what cannot be drawn or is not there, FF_ERR_DATA for data with nothing to draw.
     * What the figure has no memory for is in out->status. */
    ff_status (*build)(const ff_plot_subject *s, const ff_plot_choice *c, ff_figure *out, ff_error *err);
} ff_plot_kind;

#define FF_PLOT(name) extern const ff_plot_kind ff_plot_##name;
#include "plots.def"
#undef FF_PLOT

const ff_plot_kind *ff_plot_kind_at(size_t i); /* NULL after the last */

#endif
