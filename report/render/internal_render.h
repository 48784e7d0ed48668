/* What the files of this folder share. */
#ifndef FF_INTERNAL_RENDER_H
#define FF_INTERNAL_RENDER_H
#include "ff_render.h"
#include "ff_interpolate.h"
#include "models/tools/internal_sample.h"

enum { FF_BEAMS = FF_BLOCK }; /* pairs of directions that are looked at together */

/* ---- environment.c --------------------------------------------------------------------------- */

/* Rec. 709 */
static inline double ff_luminance(double r, double g, double b)
{
    return 0.2126 * r + 0.7152 * g + 0.0722 * b;
}

/* Of rgb [ny][nx][3] that is checked already. FF_ERR_MEMORY. */
ff_status ff_environment_of(size_t nx, size_t ny, const float *rgb, double turn, ff_environment **out, ff_error *err);

/* ff_environment_draw in two parts: directions, with where they are across the map; and then the radiance from those that are still
 * wanted, mu their second coordinate. */
void ff_environment_draw_places(const ff_environment *e, size_t n, const double *u, double *w, double *across, double *pdf,
                                size_t ld);
void ff_environment_radiance(const ff_environment *e, size_t n, const double *across, const double *mu, double *rgb, size_t ld);

/* ---- surface.c: what is lit ------------------------------------------------------------------ */

/* A model or a table. Immutable. */
typedef struct ff_surface {
    ff_sampler *sampler;  /* draws; of a model also its values */
    size_t n_drawn;       /* channels of the sampler            */
    ff_interpolant *data; /* NULL: a model                     */
    size_t n_channels;    /* of the values                      */
    double *colours;      /* [3][n_channels] of which red, green and blue are made */
} ff_surface;

/* colours NULL: as ff_spectral_colours has them. FF_ERR_UNSUPPORTED for numbers of channels whose colours are not told;
 * FF_ERR_MEMORY; else as ff_sampler_new and ff_interpolant_new. To be freed whatever it is. */
ff_status ff_surface_of_model(const ff_model *m, ff_isa isa, size_t n_channels, const double *shape, const double *channel,
                              const double *colours, ff_surface *out, ff_error *err);
ff_status ff_surface_of_table(const ff_table *t, const ff_model *by, ff_isa isa, size_t n_channels, const double *shape,
                              const double *channel, const double *colours, ff_surface *out, ff_error *err);
void ff_surface_clear(ff_surface *s);

/* Pairs of directions of points of the sphere, in the frames of these, and what is found there. */
typedef struct ff_beams {
    size_t n;
    size_t pixel[FF_BEAMS], set[FF_BEAMS];      /* whose they are */
    double normal[3][FF_BEAMS], axis[FF_BEAMS]; /* of environments: ff_sphere_axis */
    double wo[3][FF_BEAMS], wi[3][FF_BEAMS];
    double f[3][FF_BEAMS], pdf[FF_BEAMS]; /* red, green, blue; density of the sampler */
    double u[7][FF_BEAMS];
    ff_sample_shares share;                /* of the views, once ff_surface_draw was there */
    unsigned char found[FF_BEAMS];         /* ff_found */
    double *values;                        /* [channels of the surface or of its sampler, the larger][FF_BEAMS] */
    size_t n_values, n_guessed, n_unknown; /* so far, of a table */
} ff_beams;

/* f, and pdf where it is wanted, of all pairs; the pdf after ff_surface_draw, for whose views it is. */
void ff_surface_values(const ff_surface *s, ff_beams *b, int with_pdf);
/* Draws wi by the numbers u [3][FF_BEAMS]; f, pdf. */
void ff_surface_draw(const ff_surface *s, ff_beams *b, const double *u);

/* ---- camera.c -------------------------------------------------------------------------------- */

/* Point of the sphere in front of (x, y) of the picture, and the unit vector towards the viewer; 0 where the sphere is not. */
typedef struct ff_camera {
    double tangent, distance; /* of half the angle of the perspective; 0: from far away */
} ff_camera;
ff_camera ff_camera_of(double perspective);
int ff_camera_look(const ff_camera *c, double x, double y, double n[3], double view[3]);

/* ---- integrate.c ----------------------------------------------------------------------------- */

/* FF_ERR_MEMORY, FF_ERR_CANCELLED. Options are checked. */
ff_status ff_render_surface(const ff_surface *s, const ff_render_options *o, float *rgba, ff_render_summary *out);

/* ---- strokes.c: text without a font ---------------------------------------------------------- */

/* Width of UTF-8 text of a size (height of a capital), in pixels. */
double ff_strokes_width(const char *text, double size);
/* Adds text to coverage [ny][nx], values 0 to 1; (x, y) the left end of the baseline, y downwards. */
void ff_strokes_draw(const char *text, double size, double x, double y, size_t nx, size_t ny, float *coverage);

/* ---- png.c ----------------------------------------------------------------------------------- */

/* pixels [ny][nx][channels], 3 or 4 of 8 bits. FF_ERR_MEMORY. */
ff_status ff_png_encode(size_t nx, size_t ny, size_t channels, const unsigned char *pixels, unsigned char **png, size_t *n);

#endif
