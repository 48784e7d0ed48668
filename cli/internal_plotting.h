/* What `plot` is made of: what may be chosen, and what is drawn. */
#ifndef FF_INTERNAL_PLOTTING_H
#define FF_INTERNAL_PLOTTING_H
#include "internal_cli.h"
#include "report/plot/kinds/internal_plots.h"

/* How the figure is to look, from the flags: its size, and what the kinds ask for. Exit status. */
int cli_figure_read(const cli_args *args, ff_figure *fig, ff_plot_choice *choice);

/* Fits of measured data for a figure. Zero is a legal one to free. */
typedef struct cli_drawn_fits {
    cli_fitting f;
    int is_open;
    cli_tables tables;
    cli_constraints constraints;
    cli_combinations models;
    ff_fit_result *fit;
    size_t n;
    cli_trust trust;
    ff_fit_document *document; /* of them, as --json has it */
} cli_drawn_fits;

/* Reads path and fits what `kind` takes: --model, or every combination where it takes several and --ndf, --masking, --fresnel or
 * --diffuse is given. Intervals and residuals by angle are there only where it draws results. Exit status; to be freed whatever it
 * is. */
int cli_fits_draw(const cli_args *args, const char *path, const ff_plot_kind *kind, cli_drawn_fits *out);
void cli_fits_free(cli_drawn_fits *d);

/* Everything a figure is made of. Zero is a legal one to free. */
typedef struct cli_subject {
    ff_plot_subject subject;
    ff_table table; /* where it is not that of the fits */
    int has_table;
    cli_drawn_fits fits;
    ff_fit_document *document;
    cli_tables tables;
    size_t n_scenes;
    cli_scene *scene;
    ff_plot_model *model;
    ff_aperture aperture; /* of the models to come */
    char (*label)[FF_FIGURE_TEXT];
    int outcome; /* exit status of fits that did not converge */
} cli_subject;

/* The sources of the command line, and what the kind makes of them. Exit status; to be freed whatever it is. */
int cli_subject_gather(const cli_args *args, const ff_plot_kind *kind, const ff_plot_choice *choice, cli_subject *out);
void cli_subject_free(cli_subject *s);

#endif
