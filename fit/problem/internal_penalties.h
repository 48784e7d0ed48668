/* The inside of what is known besides the data: penalties.c adds the terms to the normal equations, penalised.c finds their
 * weights. */
#ifndef FF_INTERNAL_PENALTIES_H
#define FF_INTERNAL_PENALTIES_H
#include "internal_problem.h"

typedef struct ff_prior_term {
    size_t coordinate;
    uint32_t lobe, apart; /* of the parameter that it names, and the lobes that it tells it apart from, bits */
    double mean, sd;
    double noise, weight; /* s2, s2 / sd^2; 0 until the data have been seen       */
    double alone, error;  /* value and standard error by the data alone           */
    double value;         /* with the prior                                       */
} ff_prior_term;

/* A prior and a parameter that it was given to; is_free: it has a term. */
typedef struct ff_named_prior {
    ff_param_ref at;
    int is_free, channel; /* channel -1: all */
    double mean, sd;
} ff_named_prior;

#define FF_ALBEDO_LEFT 5e-5 /* violation that is left                                          */
enum { FF_VIEWS = 64, FF_ALBEDO_ORDER = 6 };

typedef struct ff_energy {
    int wanted, binds;
    size_t n, C;
    double wo[FF_VIEWS][3];
    double *shift;          /* [FF_VIEWS][C] */
    double weight;          /* K; 0 = off */
    double scale;           /* what the data oppose to a change of the albedo: their part of cost2 by its square */
    double alone, alone_mu; /* largest albedo by the data alone, and where                      */
    size_t alone_channel;
    double alone_cost2;
    double left; /* violation at the end                                                  */
    size_t n_rows;
    double *row;         /* [n_rows][n_shared + n_own] gradients of what binds, by parameters          */
    size_t *row_channel; /* [n_rows]                                                            */
} ff_energy;

struct ff_penalties {
    size_t n_priors, n_named;
    ff_prior_term *prior;
    ff_named_prior *named;
    ff_energy energy;
};

/* A direction by the cosine and azimuth of the view. */
void ff_view_at(double mu, double phi, double wo[3]);

/* Albedos of all channels at n views, and with `wanted` their derivatives by its columns: out [n][C][1 + columns]; NULL: values
 * alone. FF_ERR_MEMORY. */
ff_status ff_penalties_albedos(const ff_plan *plan, int parallel, const double *shape, const double *channel,
                               const ff_wanted *wanted, size_t n, const double (*wo)[3], double *out);

/* Gradient row [n_shared + n_own] of an albedo of channel c by coordinates, or by their parameters for slope NULL, from its
 * columns. */
void ff_penalties_gradient(const ff_layout *l, size_t c, const double *column, const double *slope, double *row);

/* The parameter of a coordinate. */
double ff_layout_value(const ff_layout *l, size_t coordinate, const double *shape, const double *channel);
#endif
