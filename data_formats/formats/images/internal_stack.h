/* An image stack on its way to a table: the list of images, and one image on its way to a sample. The format is described at the
 * head of format_images.c. */
#ifndef FF_INTERNAL_STACK_H
#define FF_INTERNAL_STACK_H
#include "base/internal_input.h"
#include "data_formats/table/internal_table.h"
#include "oiio_bridge.h"

enum {
    FF_STACK_THETA_I,
    FF_STACK_PHI_I,
    FF_STACK_THETA_O,
    FF_STACK_PHI_O,
    FF_STACK_SCALE,
    FF_STACK_EXPOSURE,
    FF_STACK_X,
    FF_STACK_Y,
    FF_STACK_WIDTH,
    FF_STACK_HEIGHT,
    FF_STACK_NUMBERS,
    FF_STACK_IMAGE = FF_STACK_NUMBERS,
    FF_STACK_MASK,
    FF_STACK_COLUMNS
};

/* How numbers of a file become light. */
typedef enum ff_curve { FF_CURVE_UNKNOWN, FF_CURVE_LINEAR, FF_CURVE_SRGB, FF_CURVE_REC709, FF_CURVE_GAMMA } ff_curve;
typedef struct ff_encoding {
    ff_curve curve;
    double gamma;
} ff_encoding;

typedef struct ff_image_stack {
    ff_lines lines;
    ff_error *err;
    const char *path;
    const ff_read_options *options;
    int quantity, isotropic; /* -1 = not said */
    double radians_per_unit;
    ff_encoding said; /* by the comment */
    double region[4];
    int with_region;
    long column[FF_STACK_COLUMNS]; /* where it stands, -1 = not there */
    size_t n_cells;
    char **cell; /* [n_cells] of the line, into its text */
    char first_image[FF_QUOTE];
    ff_image_info first; /* what all images have to agree with */
    size_t n_channels;   /* without alpha */
    const ff_image_reader *reader;
    ff_rows rows;
    double *curve_table; /* [2^bits] light of the integers */
    ff_encoding table_of;
    int table_bits;
    /* for the notes */
    size_t n_images, n_saturated_images, n_linear_by_default, n_with_alpha;
    double pixels_least, pixels_most, n_saturated, n_pixels;
    size_t n_curve[FF_CURVE_GAMMA + 1];
    int no_sigma;
} ff_image_stack;

/* One image on its way to a sample. */
typedef struct ff_image_shot {
    ff_image_stack *f;
    char path[4096];
    char quoted[FF_QUOTE];
    ff_image *image, *mask;
    ff_image_info info, mask_info;
    ff_encoding encoding;
    long x, y, width, height;                                      /* region */
    size_t channel[FF_IMAGE_CHANNELS];                             /* of the file, without alpha */
    double n, mean[FF_IMAGE_CHANNELS], squares[FF_IMAGE_CHANNELS]; /* squares: sum (v - mean)^2 */
    double saturated;
} ff_image_shot;

/* ---- stack_list.c: the CSV ------------------------------------------------------------------- */

/* The header line, and the comments before it. FF_ERR_FORMAT, FF_ERR_READ, FF_ERR_MEMORY. */
ff_status ff_stack_read_header(ff_image_stack *f);

/* The next line that is neither blank nor a comment; *text is NULL at the end. */
ff_status ff_stack_next_line(ff_image_stack *f, char **text, size_t *length);

/* Cuts a line at its commas into f->cell, in place; quotes around a cell are dropped, "" inside them is one. Returns the number of
 * cells. */
size_t ff_stack_cut_cells(ff_image_stack *f, char *p);

/* A cell of the present line by its column, "" where that is not there; and an error about it. */
const char *ff_stack_cell(const ff_image_stack *f, int column);
ff_status ff_stack_bad_cell(const ff_image_stack *f, int column, const char *expected);

/* The numbers of a line; NaN where an optional cell is empty or its column is not there. FF_ERR_DATA. */
ff_status ff_stack_read_numbers(const ff_image_stack *f, double v[FF_STACK_NUMBERS]);

/* The curve that a word names; FF_CURVE_UNKNOWN for others. The words are those of OpenImageIO and of people. */
ff_encoding ff_encoding_of(const char *word);
int ff_gamma_is_right(double gamma);

/* ---- stack_shot.c: one image ----------------------------------------------------------------- */

/* Reads the image (and the mask) that the present line names and adds a row of its mean and spread to f->rows. v: the line's
 * numbers; s: zeroed but for s->f, whose images the caller closes. */
ff_status ff_stack_read_shot(ff_image_shot *s, const double v[FF_STACK_NUMBERS]);
#endif
