/* The strategies that draw directions for one part of a model; the method and the notation are at the head of sample.c. */
#ifndef FF_INTERNAL_SAMPLE_H
#define FF_INTERNAL_SAMPLE_H
#include "ff_sample.h"
#include "models/internal_model.h"

enum {
    FF_SAMPLE_VIEWS = 17, /* nodes of the albedo tables, at mu = (j / 16)^2  */
    FF_SAMPLE_MATTE = 65, /* nodes of the matte tables, at mu = (j / 64)^2   */
    FF_SAMPLE_COMPONENTS = FF_MAX_LOBES + FF_MAX_PARTS
};

/* The mass inside q2 = e^y with its first two derivatives by y. */
typedef struct ff_sample_node {
    double y, mass, slope, curve;
} ff_sample_node;

/* The cumulative mass of a radial density w(q2) of u: quintic between its nodes, w constant below the first, q2 w a power law
 * beyond the last. */
typedef struct ff_sample_radial {
    ff_sample_node *node;
    size_t n, room;
    double middle; /* pi w(0)                 */
    double total, fall;
} ff_sample_radial;

typedef enum ff_sample_strategy {
    FF_SAMPLE_VISIBLE_GGX,
    FF_SAMPLE_VISIBLE_GAUSSIAN,
    FF_SAMPLE_NORMALS,
    FF_SAMPLE_MATTE_TABLE,
    FF_SAMPLE_PEAK,
    FF_SAMPLE_COSINE
} ff_sample_strategy;

/* What draws and what it draws for: lobe `at`, or part `at - n_lobes`. */
typedef struct ff_sample_component {
    ff_sample_strategy kind;
    const ff_ndf *ndf; /* of a lobe, else NULL */
    const ff_lobe_pass *pass;
    double l11, l21, l22;
    int unit_area;
    double (*quantile)(const ff_ndf_pass *pass, double u); /* q2 of FF_SAMPLE_NORMALS; NULL: by the table    */
    ff_sample_radial radial;
    double rest[FF_SAMPLE_MATTE], below[FF_SAMPLE_MATTE]; /* ..._MATTE_TABLE: a density of mu^2, and its integral up to a node */
    double width, power;                                  /* FF_SAMPLE_PEAK: (1 + (d / width)^2)^-power */
    double albedo[FF_SAMPLE_VIEWS];
} ff_sample_component;

/* A block of pairs of directions. */
typedef struct ff_sample_pairs {
    size_t n;
    double w[6][FF_BLOCK]; /* wi, wo                                                               */
    double plane[FF_G_COUNT][FF_BLOCK];
    ff_geometry g;
} ff_sample_pairs;

/* Shares of the n strategies for each wo of a block, and the albedo that the tables give. All 0 where nothing can be drawn: at or
 * below the horizon; the share of a lobe is 0 where its mean surface is seen from below. */
typedef struct ff_sample_shares {
    size_t n;
    double of[FF_SAMPLE_COMPONENTS][FF_BLOCK], albedo[FF_BLOCK];
} ff_sample_shares;

/* Those of view `from` also for view `to`. */
static inline void ff_sample_shares_move(ff_sample_shares *s, size_t from, size_t to)
{
    for (size_t k = 0; k < s->n; k++) s->of[k][to] = s->of[k][from];
}

/* ---- sample.c -------------------------------------------------------------------------------- */

/* As ff_sampler_sample, of n <= FF_BLOCK; the shares of its views for ff_sampler_values_block. */
void ff_sampler_sample_block(const ff_sampler *s, size_t n, const double *wo, const double *u, const double *roulette, double *wi,
                             double *pdf, double *f, double *weight, size_t ld, ff_sample_shares *share);

/* The model itself for n <= FF_BLOCK given pairs, f [n_channels][ld], 0 at and below the horizon, and the density as
 * ff_sampler_pdf, by the shares of these views; either may be NULL: what was prepared serves any number of calls. Planes as
 * ff_sampler_pdf. */
void ff_sampler_values_block(const ff_sampler *s, size_t n, const double *wo, const double *wi, const ff_sample_shares *share,
                             double *pdf, double *f, size_t ld);

/* ---- sample_radial.c: normals of any distribution -------------------------------------------- */

/* Makes the table of a lobe: from where 1e-14 of the mass lies inside to where that is left outside. FF_ERR_MEMORY; k->radial.node
 * is the caller's to free, also then. */
ff_status ff_sample_radial_make(ff_sample_component *k);

/* q2 with the fraction u of the mass inside. */
double ff_sample_radial_quantile(const ff_sample_radial *r, double u);

/* ---- sample_closed.c: closed forms of the unit surface --------------------------------------- */

/* Sets kind and quantile of a lobe whose distribution has a closed form; 0 when it has none. */
int ff_sample_closed_form(ff_sample_component *k);

/* The slopes along the view have the density (a + x)+ e^(-x^2); as weights of 1 and x, so that a may be infinite. */
typedef struct ff_gaussian_view {
    double one, x, lowest; /* a / (a + 1), 1 / (a + 1), -a */
} ff_gaussian_view;
ff_gaussian_view ff_gaussian_view_of(double length, double v0);

/* Integral of all of it: N of the head of sample.c is (|l| + v0) / sqrt(pi) times this. */
double ff_gaussian_mass(const ff_gaussian_view *g);

/* The slope with the fraction u of the integral below it. */
double ff_gaussian_quantile(const ff_gaussian_view *g, double u);

/* ---- sample_strategies.c --------------------------------------------------------------------- */

/* Does the component see anything of wo = o: above the horizon and, of a lobe, not behind its mean surface? */
int ff_sample_sees(const ff_sample_component *k, const double o[3]);

/* wi drawn by component k for the view wo = o that it sees; u1 in [0, 1), u2 in [0, 1]. */
void ff_sample_draw(const ff_sample_component *k, const double o[3], double u1, double u2, double wi[3]);

/* Density of wi for component k, wherever both directions are above the horizon; out [b->n]. */
void ff_sample_density(const ff_sample_component *k, const ff_sample_pairs *b, double *out);

/* mu^2 at a node of the matte tables. */
static inline double ff_matte_node(int j)
{
    const double mu = (double)(j * j) * (1.0 / ((FF_SAMPLE_MATTE - 1) * (FF_SAMPLE_MATTE - 1)));
    return mu * mu;
}
#endif
