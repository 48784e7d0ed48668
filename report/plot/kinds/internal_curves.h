/* What kinds share: channels by name, models along a line of directions, samples in a plane. */
#ifndef FF_INTERNAL_CURVES_H
#define FF_INTERNAL_CURVES_H
#include "internal_plots.h"

#define FF_DEGREE 0.017453292519943295

/* Styles of what every figure of data and model has. */
static const ff_style ff_style_data = {FF_COLOUR_BLACK, FF_DASH_SOLID, FF_MARKER_DOT},
                      ff_style_unused = {FF_COLOUR_GREY, FF_DASH_SOLID, FF_MARKER_CROSS},
                      ff_style_model = {FF_COLOUR_VERMILLION, FF_DASH_SOLID, FF_MARKER_DOT},
                      ff_style_lobe = {FF_COLOUR_BLUE, FF_DASH_LONG, FF_MARKER_DOT},
                      ff_style_diffuse = {FF_COLOUR_GREEN, FF_DASH_DOT, FF_MARKER_DOT},
                      ff_style_mark = {FF_COLOUR_GREY, FF_DASH_DOTTED, FF_MARKER_DOT},
                      ff_style_zero = {FF_COLOUR_GREY, FF_DASH_SOLID, FF_MARKER_DOT};

/* ---- channels -------------------------------------------------------------------------------- */

/* A channel to be drawn: of the model, of the table (-1: the mean of all), and its name, "" where there is one alone. */
typedef struct ff_plot_channel {
    size_t of_model;
    int of_table;
    char name[FF_CHANNEL_NAME];
} ff_plot_channel;

/* Those that `names` lists, or the middle one. *n: how many, at most FF_PLOT_LIST. Either of model and table may be NULL.
 * FF_ERR_UNKNOWN with the names that there are. */
ff_status ff_plot_channels(const ff_plot_model *m, const ff_table *t, const char *names, ff_plot_channel *out, size_t *n,
                           ff_error *err);
/* Value and standard deviation (NaN without) of sample i, 1/sr. */
double ff_plot_value(const ff_table *t, int channel, size_t i);
double ff_plot_sigma(const ff_table *t, int channel, size_t i);

/* Of a million samples a figure looks at one of so many; the step shares no factor with the sizes of grids. */
size_t ff_plot_step(size_t n);

/* Is `name` in the list, of which every entry stands for itself, and one without "[...]" for all channels? NULL: all are. */
int ff_plot_names(const char *list, const char *name);

/* ---- models ---------------------------------------------------------------------------------- */

/* f of one channel for n pairs of directions: of all, of its lobes and of what lies under them; any of total, lobes [n_lobes] and
 * base may be NULL. */
ff_status ff_plot_evaluate(const ff_plot_model *m, ff_isa isa, size_t channel, const ff_dirs *w, size_t n, double *total,
                           double *const *lobes, double *base, ff_error *err);

/* n pairs of directions, all owned by `plane[0]`. */
typedef struct ff_directions {
    ff_dirs w;
    double *plane[6];
    size_t n;
} ff_directions;
ff_status ff_directions_new(size_t n, ff_directions *out);
void ff_directions_free(ff_directions *d);
void ff_directions_set(ff_directions *d, size_t i, double theta_i, double phi_i, double theta_o, double phi_o); /* radians */

/* A title: the label of m, and the channel where there are several. */
void ff_plot_title(const ff_plot_model *m, const ff_plot_channel *c, char *out, size_t size);
/* Says in the figure's note that a fit did not converge; of: which, NULL where there is one. */
void ff_plot_note_failed(ff_figure *fig, const char *of, const char *outcome);
void ff_plot_note_outcome(ff_figure *fig, const ff_plot_model *m);

/* ---- samples in the plane of incidence ------------------------------------------------------- */

typedef struct ff_plane_sample {
    double theta_i, phi_i, theta_o; /* radians; theta_o > 0 on the side of the mirror direction */
    double across;                  /* sine of the angle of wo from the plane                   */
    uint32_t index;
    int32_t group;
} ff_plane_sample;

/* The samples near the plane of incidence of a table, by incident direction. */
typedef struct ff_planes {
    size_t n_samples, n_groups;
    ff_plane_sample *sample; /* ordered by group, then theta_o  */
    size_t *first;           /* [n_groups + 1]                  */
    double tolerance;        /* largest `across`                */
    size_t step;             /* one of `step` samples was looked at  */
    double width;            /* of a group in theta_i, radians; 0: one incidence each */
} ff_planes;
/* FF_ERR_DATA where there are none, FF_ERR_MEMORY. */
ff_status ff_planes_find(const ff_table *t, ff_planes *out, ff_error *err);
void ff_planes_free(ff_planes *p);
/* The groups to be drawn: nearest to each asked incidence, or `most` spread over all. Indices into out [FF_PLOT_LIST], the count.
 */
size_t ff_planes_choose(const ff_planes *p, const ff_plot_choice *c, size_t most, size_t *out);
double ff_planes_theta(const ff_planes *p, size_t group); /* mean theta_i */

#endif
