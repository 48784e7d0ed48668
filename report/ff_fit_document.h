/** @file ff_fit_document.h  A result of `fit` or `compare` read back: models with the values that were found, how sure they are.
 *
 *  The document is JSON of FF_SCHEMA_FIT (docs/schema/fit.schema.json). What is needed of it is checked: a model that parses, a
 * value in its box for every parameter; what is missing besides, as a document of an older version lacks it, is NaN or 0.
 *
 *      ff_fit_document *d;
 *      if ((status = ff_fit_document_read("fit.json", &d, err)) != FF_OK) return status;
 *      const ff_fitted *best = &d->fit[d->best];
 *      ff_model_eval(&best->model, isa, best->n_channels, best->shape, best->channel, ...);
 *      ff_fit_document_free(d);
 *
 *  Tables   a `tabulated` lobe has no profile in the document: ff_model_set_table before it is evaluated.
 *  Memory   everything belongs to the document.
 *  Errors   FF_ERR_FORMAT for what is no such document, FF_ERR_DATA for one whose content makes no sense, with path, line or the
 * key; ff_json_read's. Outputs are written only on FF_OK. Threads  a document may be read from many threads at once. */
#ifndef FF_FIT_DOCUMENT_H
#define FF_FIT_DOCUMENT_H
#include "data_formats/table/ff_table.h"
#include "models/model_struct.h"
#include "ff_noise.h"
#include "ff_trust.h"

/** One number of a fit. */
typedef struct ff_fitted_value {
    double value, std_error, low, high; /**< NaN where there is none                                   */
    int at_bound;                       /**< -1 lower, 1 upper, 0 none                                 */
    int held, tied;
} ff_fitted_value;

typedef struct ff_fitted {
    ff_model model;
    char expression[FF_MODEL_NAME];
    char outcome[24], shape_name[24]; /**< "converged", "isotropic"                                  */
    size_t n_channels;
    char (*channel_name)[FF_CHANNEL_NAME]; /**< [n_channels]                                           */
    double shape[FF_MAX_SHAPE];
    double *channel;                /**< [n_channels][model.n_channel]                             */
    ff_fitted_value *shape_value;   /**< [model.n_shape]                                           */
    ff_fitted_value *channel_value; /**< [n_channels][model.n_channel]                             */
    double objective, rmse;
    ff_noise *noise; /**< of the data; NULL                                         */
    int has_bands;
    ff_bands bands;
    size_t n_columns;                                         /**< of the correlations; 0: none                              */
    char (*column_name)[FF_PARAM_NAME + FF_CHANNEL_NAME + 4]; /**< [n_columns]                         */
    double *correlation;                                      /**< [n_columns][n_columns]                                    */
    /** Of many channels the columns above are those of the shape; then also, for every channel, its own parameters: [n_channels]
     *  [n_own][n_columns + n_own], with the columns, then with each other. */
    size_t n_own;
    char (*own_name)[FF_PARAM_NAME]; /**< [n_own] */
    double *own;
} ff_fitted;

typedef struct ff_fit_document {
    char path[512], format[32]; /**< of the data                                               */
    char loss[24];
    double max_theta;     /**< radians                                                   */
    ff_aperture aperture; /**< what the data are means over; a point where it says nothing */
    size_t n_fits, best;  /**< at least one; the best of the first data set              */
    ff_fitted *fit;
    size_t *rank; /**< [n_fits], best first of each choice of channels           */
} ff_fit_document;

/** Is the file a JSON document of ours, by its beginning? 0 also where it cannot be opened. "-" is looked at and left as it was. */
int ff_fit_document_probe(const char *path);

ff_status ff_fit_document_read(const char *path, ff_fit_document **out, ff_error *err);
/** The same of text [n]; path is for messages, NULL allowed. */
ff_status ff_fit_document_parse(const char *text, size_t n, const char *path, ff_fit_document **out, ff_error *err);
void ff_fit_document_free(ff_fit_document *d); /**< NULL is allowed */

/** Number of the fit called `name`: "" the best, a number from 1 on in the order of the document, or an expression, also the
 * beginning of one that only one has. FF_ERR_UNKNOWN says which there are. */
ff_status ff_fit_document_find(const ff_fit_document *d, const char *name, size_t *out, ff_error *err);

#endif
