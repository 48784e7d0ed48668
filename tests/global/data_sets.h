/* Simulated measurements over the whole range of the models: data set i of a family is a function of (seed, i) alone. */
#ifndef DATA_SETS_H
#define DATA_SETS_H
#include "fit_samples.h"

typedef enum family { ONE_LOBE, TWO_LOBES, FAMILIES } family;

/* How the directions lie. */
typedef enum coverage { SCATTERED, FEW_INCIDENCES, COVERAGES } coverage;

typedef struct data_set {
    fit_surface truth;
    coverage coverage;
    int incidences;   /* of FEW_INCIDENCES                                                     */
    int isotropic;    /* the table says that it shows no direction: AUTO is then isotropic     */
    fit_sampling how; /* n, max_theta, glossy, noise, sigma                                    */
    char model[FF_MODEL_NAME];
} data_set;

data_set data_set_make(family f, uint64_t seed, size_t i);

/* Release the table with ff_table_clear. */
ff_table data_set_measure(const data_set *d);

/* One line: model, how it was measured. */
void data_set_describe(const data_set *d, char *out, size_t size);

/* "alpha_x 0.2, f0 0.9:0.6": the parameters that a fit of shape mode `l` would find. */
struct ff_layout;
void data_set_parameters(const struct ff_layout *l, const double *shape, const double *channel, char *out, size_t size);

#endif
