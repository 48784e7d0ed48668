/** @file ff_render.h  Pictures of a lit sphere, as a model or a table reflects light.
 *
 *      ff_render_options o;
 *      ff_render_options_init(&o);
 *      o.pixels = 256;
 *      float *rgba = malloc(4 * o.pixels * o.pixels * sizeof *rgba);
 *      ff_render_model(m, n_channels, shape, channel, &o, rgba, &summary, &err);
 *      ff_render_sheet sheet;
 *      ff_render_sheet_init(&sheet);
 *      sheet.pixels = o.pixels, sheet.n = 1, sheet.cell = &(ff_render_cell){rgba, "alpha = 0.3", FF_CELL_PICTURE};
 *      ff_render_png(&sheet, &png, &n_bytes, &err);                   // ... then ff_render_png_free(png)
 *
 *  Frame      x to the right, y up, the viewer at +z. The unit sphere fills the square picture from edge to edge. The surface's
 *             tangent is the direction of the parallel, towards growing x, its bitangent that of the meridian, towards the pole +y:
 *             a surface that is brushed along its tangent is brushed around the axis of the sphere.
 *  Lights     distant, of irradiance pi at normal incidence: L = pi f cos(theta_i), so that a white Lambertian surface (f = 1/pi)
 *             that faces one has radiance 1. An environment is radiance L(w) from everywhere: a pixel is the integral of
 *             f L cos(theta_i) dwi. Nothing casts a shadow, and light is reflected once.
 *  Pixels     means over their area: under lights of 16 points on a regular lattice, under an environment of the random ones.
 *             Pixel (i, j), j counted from the top, covers x from 2i/pixels - 1 and y from 1 - 2j/pixels on, 2/pixels of each.
 *  Estimate   of every pixel half of the samples are drawn by the model and half by the environment, weighed by the balance
 *             heuristic (Veach and Guibas 1995, eqs. 8 and 14). They are R sets of K points of an additive recurrence (Roberts
 *             2018) in seven dimensions, each set shifted at random (Cranley and Patterson 1976); the sets are independent, and the
 *             spread of their means is the standard error. R = 8, or 2 below 64 samples.
 *  Colour     three channels are red, green and blue, those named r, g, b if there are, of Rec. 709; one channel is grey. Other
 *             numbers of channels are FF_ERR_UNSUPPORTED.
 *  Buffers    rgba [pixels][pixels][4], the first row on top: linear radiance times coverage, then coverage, in [0, 1].
 *  Random     a function of (seed, pixel, set): bits depend neither on the number of threads nor on the machine's load.
 *  Errors     ff_status and ff_error; outputs are written only on FF_OK, but rgba, which may be partly written on FF_ERR_CANCELLED.
 *  Threads    no global state; every function may be called from many threads at once. An environment does not change after it was
 *             made and may be shared. */
#ifndef FF_RENDER_H
#define FF_RENDER_H
#include "ff_api.h"
#include "ff_model.h"
#include "ff_table.h"
#ifdef __cplusplus
extern "C" {
#endif

enum { FF_RENDER_PIXELS_MAX = 8192, FF_RENDER_SAMPLES_MAX = 65536, FF_RENDER_LIGHTS_MAX = 64 };

/* ---- environments ---------------------------------------------------------------------------- */

/** Radiance from all directions, bilinear between the pixels of a map by latitude and longitude: a direction (sin t sin a, cos t,
 * -sin t cos a) is at the fraction t/pi from the top and a/(2 pi) + 1/2 from the left. The middle of the map is thus what lies
 * behind the sphere, its left and right edge what is behind the viewer. */
typedef struct ff_environment ff_environment;

/** Makes an environment of a map.
 *  @param rgb   [ny][nx][3]  radiance >= 0 and finite, the first row the zenith (+y); copied
 *  @param turn  by which all is turned about +y, radians, counter-clockwise seen from above
 *  FF_ERR_RANGE: nx or ny not in 1 .. 32768, an infinite turn, a pixel that is negative, infinite or NaN; FF_ERR_DATA: all is
 *  black; FF_ERR_MEMORY. *out is released with ff_environment_free. */
FF_API ff_status ff_environment_new(size_t nx, size_t ny, const float *rgb, double turn, ff_environment **out, ff_error *err);

/** The same of an image file that OpenImageIO reads (OpenEXR, Radiance HDR, ...), linear numbers: one channel or at least three, of
 * which R, G, B are taken by name where there are such. FF_ERR_OPEN, FF_ERR_READ, FF_ERR_FORMAT; FF_ERR_UNSUPPORTED where the
 * module of images is not there, and for integers whose encoding is not linear; FF_ERR_DATA for a pixel that is negative or no
 * number, and black ones; else as ff_environment_new. */
FF_API ff_status ff_environment_read(const char *path, double turn, ff_environment **out, ff_error *err);

/** Clear sky (Preetham, Shirley and Smits 1999, "A practical analytic model for daylight", appendix A.2) above a grey ground.
 *  @param elevation  of the sun above the horizon, radians in [0, pi/2], a rounding more is taken; it stands at the azimuth a = -3
 * pi / 4 before the turn: in front of the sphere, to the left. The sun itself is not in it: a light has to be added
 *  @param turbidity  haze, in [2, 10]; 2 is a very clear sky
 *  @param ground     reflectance of the ground in [0, 1], which is lit by the sky alone
 *  Scaled so that the sky lights a horizontal surface with the irradiance pi (weights of Rec. 709). FF_ERR_RANGE, FF_ERR_MEMORY. */
FF_API ff_status ff_environment_sky(double elevation, double turbidity, double ground, double turn, ff_environment **out,
                                    ff_error *err);

FF_API void ff_environment_free(ff_environment *e); /**< NULL is allowed */

/** Radiance from n directions, and the density with which ff_environment_draw draws them.
 *  @param w    [3][ld]       unit vectors in the frame of the picture
 *  @param rgb  [3][ld] out   NULL = not needed
 *  @param pdf  [n] out       1/sr; NULL = not needed */
FF_API void ff_environment_look(const ff_environment *e, size_t n, const double *w, double *rgb, double *pdf, size_t ld);

/** Draws n directions, in proportion to the luminance of the map smoothed over 3 x 3 pixels.
 *  @param u    [2][ld]       uniform numbers in [0, 1)
 *  @param w    [3][ld] out   unit vectors
 *  @param rgb  [3][ld] out   radiance; NULL = not needed
 *  @param pdf  [n] out       1/sr */
FF_API void ff_environment_draw(const ff_environment *e, size_t n, const double *u, double *w, double *rgb, double *pdf, size_t ld);

/* ---- a picture ------------------------------------------------------------------------------- */

/** Options; fill with ff_render_options_init, then change. */
typedef struct ff_render_options {
    size_t size;                       /**< sizeof(ff_render_options)                                          */
    size_t pixels;                     /**< width and height, 1 .. FF_RENDER_PIXELS_MAX; 512                   */
    double perspective;                /**< angle under which the sphere is seen, radians in [0, 2.9]; 0: from far away */
    size_t n_lights;                   /**< 0 .. FF_RENDER_LIGHTS_MAX; 0                                       */
    const double (*light)[3];          /**< [n_lights] towards them, finite and not 0, of any length; borrowed */
    const ff_environment *environment; /**< NULL: none; borrowed                                               */
    size_t samples;             /**< of each pixel under an environment, 1 .. FF_RENDER_SAMPLES_MAX; 256. Rounded up to R K */
    uint64_t seed;              /**< 1                                                                  */
    int threads;                /**< 0: one per processor                                               */
    ff_isa isa;                 /**< FF_ISA_BEST                                                        */
    const volatile int *cancel; /**< polled; not NULL and != 0 ends with FF_ERR_CANCELLED               */
} ff_render_options;

/** Writes the defaults into options of `size` bytes, the caller's sizeof, and nothing beyond. */
FF_API void ff_render_options_init_size(ff_render_options *o, size_t size);
static inline void ff_render_options_init(ff_render_options *o)
{
    ff_render_options_init_size(o, sizeof *o);
}

/** What came of it. */
typedef struct ff_render_summary {
    size_t samples; /**< of each pixel under the environment, as rounded; 0 without one                      */
    double mean[3]; /**< radiance over the sphere                                                            */
    double error;   /**< standard error of a pixel: root mean square over the sphere and channels; 0 without environment */
    double guessed; /**< of the values of a table that were needed, the share beyond its data (the nearest were taken)   */
    double unknown; /**< and the share that has none: black                                                  */
} ff_render_summary;

/** Renders a model. With neither lights nor environment all is black.
 *  @param shape    [n_shape]                 see ff_model_check
 *  @param channel  [n_channels][n_channel]
 *  @param rgba     [pixels][pixels][4] out
 *  @param out      may be NULL
 *  FF_ERR_RANGE, FF_ERR_UNSUPPORTED (as ff_model_check, numbers of channels, an isa that is not there), FF_ERR_MEMORY,
 *  FF_ERR_CANCELLED. */
FF_API ff_status ff_render_model(const ff_model *m, size_t n_channels, const double *shape, const double *channel,
                                 const ff_render_options *o, float *rgba, ff_render_summary *out, ff_error *err);

/** Renders a table, interpolated as ff_interpolant_eval_reciprocal has it; where it knows nothing the nearest values are taken.
 *  @param by  a model that draws the samples under an environment, with its parameters as above, e.g. the one that was fitted: the
 *             picture of the table and that of the model then have the same directions, and their difference less noise. NULL: two
 *             lobes of ggx, alpha 0.05 and 0.25, and lambert
 *  Errors as ff_render_model; FF_ERR_DATA when no sample lies above the horizon. */
FF_API ff_status ff_render_table(const ff_table *t, const ff_model *by, size_t n_channels, const double *shape,
                                 const double *channel, const ff_render_options *o, float *rgba, ff_render_summary *out,
                                 ff_error *err);

/* ---- a sheet of pictures --------------------------------------------------------------------- */

/** Curves from exposed linear values e = 2^exposure L to what is shown, each channel alone, negative ones as 0. */
typedef enum ff_render_tone {
    FF_TONE_SRGB = 0,   /**< the curve of sRGB (IEC 61966-2-1) of min(e, 1)                                                  */
    FF_TONE_LINEAR = 1, /**< min(e, 1): for programs that expect linear numbers                                              */
    FF_TONE_FILMIC = 2  /**< the curve of sRGB of min(1, e (2.51 e + 0.03) / (e (2.43 e + 0.59) + 0.14)) (Narkowicz 2015)    */
} ff_render_tone;
enum { FF_TONES = 3 };

/** "srgb", "linear", "filmic"; NULL for a number that is none. */
FF_API const char *ff_render_tone_name(int tone);

/** What is shown of an exposed value, in [0, 1]; NaN is 0. */
FF_API double ff_render_tone_of(ff_render_tone tone, double exposed);

typedef enum ff_render_cell_kind {
    FF_CELL_PICTURE = 0,
    FF_CELL_DIFFERENCE = 1 /**< signed; the mean of its channels by a diverging map: blue below 0, white at 0, orange above */
} ff_render_cell_kind;

typedef struct ff_render_cell {
    const float *rgba; /**< [pixels][pixels][4]; borrowed                                                    */
    const char *label; /**< UTF-8 under it; NULL or "": none. What the built-in strokes lack is shown as a box */
    ff_render_cell_kind kind;
} ff_render_cell;

typedef enum ff_render_background {
    FF_BACKGROUND_WHITE = 0,
    FF_BACKGROUND_BLACK = 1,
    FF_BACKGROUND_TRANSPARENT = 2
} ff_render_background;
enum { FF_BACKGROUNDS = 3 };

/** "white", "black", "transparent"; NULL for a number that is none. */
FF_API const char *ff_render_background_name(int background);

/** Pictures beside each other, row by row. */
typedef struct ff_render_sheet {
    size_t size;    /**< sizeof(ff_render_sheet)                                              */
    size_t pixels;  /**< of each                                                              */
    size_t columns; /**< 0: all in one row                                                    */
    size_t n;
    const ff_render_cell *cell; /**< [n] borrowed                                              */
    double exposure;            /**< in stops, finite, within [-64, 64]; 0                     */
    ff_render_tone tone;
    double clip; /**< exposed difference at which the colours end, > 0; 0.25                   */
    ff_render_background background;
} ff_render_sheet;

FF_API void ff_render_sheet_init_size(ff_render_sheet *s, size_t size);
static inline void ff_render_sheet_init(ff_render_sheet *s)
{
    ff_render_sheet_init_size(s, sizeof *s);
}

/** The sheet as the bytes of a PNG: 8 bits, RGB, or RGBA where the background is transparent. *png is released with
 *  ff_render_png_free. FF_ERR_RANGE (sizes, numbers, a sheet of more than 2^28 pixels), FF_ERR_MEMORY. */
FF_API ff_status ff_render_png(const ff_render_sheet *s, unsigned char **png, size_t *n, ff_error *err);
FF_API void ff_render_png_free(unsigned char *png); /**< NULL is allowed */

/** A plane of an OpenEXR image: every fourth number of rgba pictures, or any other. */
typedef struct ff_render_layer {
    const char *name;           /**< "" or e.g. "data": channels R, G, B, A, or data.R, ...              */
    const ff_render_cell *cell; /**< [n] of the sheet's n and columns                            */
} ff_render_layer;

/** The pictures of n_layers sheets of one shape as linear 32-bit floats, no exposure, no tone and no labels, into an OpenEXR image
 * at path ("-" is standard output), which appears whole or not at all. Of s the cells are not looked at. FF_ERR_RANGE (no layer, a
 * sheet of more than 2^28 pixels), FF_ERR_WRITE, FF_ERR_MEMORY. */
FF_API ff_status ff_render_exr(const char *path, const ff_render_sheet *s, size_t n_layers, const ff_render_layer *layer,
                               ff_error *err);

#ifdef __cplusplus
}
#endif
#endif
