/* What the pages of fits and comparisons are made of. */
#ifndef FF_INTERNAL_HTML_H
#define FF_INTERNAL_HTML_H
#include "fit/pass/internal_pass.h"
#include "internal_page.h"
#include "report/internal_report.h"
#include "report/internal_verdict.h"
#include "report/plot/kinds/internal_curves.h"

enum { FF_HTML_CHANNELS = 40, FF_HTML_SLICES = 12 };

/* A channel of the page: one of a problem. */
typedef struct ff_html_channel {
    size_t problem, c;
    int of_table; /* -1: the mean of all */
    const char *name;
} ff_html_channel;

/* Everything about the report that its parts share. */
typedef struct ff_html_subject {
    const ff_report_fits *r;
    const char *sha256;
    ff_isa isa;
    size_t models;             /* of each problem */
    ff_fit_document *document; /* of all fits, in their order */
    ff_plot_model *model;      /* [n_fits] likewise */
    size_t best, shown,
        rival; /* fits of the first problem: the lowest objective, what the verdict is about, the next to be looked at */
    size_t n_channels, skipped; /* of the page, and those that it leaves out */
    ff_html_channel channel[FF_HTML_CHANNELS];
} ff_html_subject;

/* FF_ERR_MEMORY. To be freed whatever it is. */
ff_status ff_html_subject_make(const ff_report_fits *r, const char *sha256, ff_isa isa, ff_html_subject *out, ff_error *err);
void ff_html_subject_free(ff_html_subject *s);
/* For the kinds of figures: the table with one fit, or with n of them. */
ff_plot_subject ff_html_plot_subject(const ff_html_subject *s, const ff_plot_model *model, size_t n);

/* samples.c: those of the table that the page has, with the incidences of the slices. */
typedef struct ff_html_slice {
    double theta_i, phi_i; /* radians */
    size_t first, n;       /* of the samples below */
} ff_html_slice;

typedef struct ff_html_samples {
    size_t n, n_even, step; /* the first n_even are every step-th of the table, the others those of the slices */
    uint32_t *index;        /* [n] of the table                                               */
    double *w;              /* [6][n] directions                                              */
    unsigned char *why;     /* [n] FF_WHY_...                                                 */
    double *weight;         /* [n_channels][n] what multiplies the residual; 0: not fitted     */
    size_t n_slices;
    ff_html_slice slice[FF_HTML_SLICES];
    double width; /* of a slice in theta_i, radians; 0: one incidence each */
} ff_html_samples;
enum { FF_WHY_USED, FF_WHY_INVALID, FF_WHY_HORIZON, FF_WHY_GRAZING, FF_WHY_OTHER };

ff_status ff_html_samples_make(const ff_html_subject *s, ff_html_samples *out, ff_error *err);
void ff_html_samples_free(ff_html_samples *v);
void ff_html_samples_json(ff_json *j, const ff_html_subject *s, const ff_html_samples *v);

/* terms.c: "models" of the open object: of every fit its terms with the names of their parameters, or what it is at the samples
 * where the script has no formula for it. FF_ERR_MEMORY. */
ff_status ff_html_models_json(ff_json *j, const ff_html_subject *s, const ff_html_samples *v);

/* start.c: where the minimisation over all samples began, as "start" of the open object: name -> values by channel. */
ff_status ff_html_start_json(ff_json *j, const ff_html_subject *s);

/* checks.c: the fit at lower limits of theta, and by other losses. */
ff_status ff_html_cut_offs(const ff_html_subject *s, ff_figure *fig, ff_error *err);
ff_status ff_html_losses(const ff_html_subject *s, ff_figure *fig, ff_error *err);

/* spheres.c: pictures of data, of one model or of A and B, and of a difference; "sphere" of the open object: the data over half and
 * difference angle. */
void ff_html_spheres(ff_page *p, const ff_html_subject *s);
ff_status ff_html_sphere_json(ff_json *j, const ff_html_subject *s);

/* differ.c: two models over incidence and view in the plane of incidence, in standard deviations of a sample, or relative. */
ff_status ff_html_differ(const ff_html_subject *s, size_t a, size_t b, ff_figure *fig, ff_error *err);

/* units.c: a figure of the fit that the page is about, roughness and reflectance as renderers count them; none where nothing
 * converts. */
void ff_html_units(ff_page *p, const ff_html_subject *s);

/* references.c: BibTeX of what the terms of the fits name as their sources. */
ff_status ff_html_references(const ff_html_subject *s, FILE *out);

/* tables.c */
void ff_html_verdict(ff_page *p, const ff_html_subject *s);
void ff_html_parameters(ff_page *p, const ff_html_subject *s, size_t fit);
void ff_html_left_out(ff_page *p, const ff_html_subject *s);
void ff_html_reproduce(ff_page *p, const ff_html_subject *s);
void ff_html_ranking(ff_page *p, const ff_html_subject *s);
void ff_html_matrix(ff_page *p, const ff_html_subject *s);

#endif
