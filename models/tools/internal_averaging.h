/* Means of a composed model over an aperture and a source, block by block: what ff_aperture.h and fits are made of. */
#ifndef FF_INTERNAL_AVERAGING_H
#define FF_INTERNAL_AVERAGING_H
#include "internal_aperture.h"
#include "models/internal_model.h"

/* ---- nodes ------------------------------------------------------------------------------------ */

/* Orders of quadrature, each more exact than the one before: the centre alone; nodes of an aperture that serve every pair; nodes
 * that crowd where a narrow lobe is, of each pair by itself. */
enum { FF_LEVEL_CENTRE = 0, FF_LEVEL_MAPPED = 6, FF_LEVELS = 14 };

/* Nodes in the frame of a centre: p along theta, q across, r towards the centre; weights add up to 1, that of the centre alone to
 * the mean of r. degree: of the polynomials of p and q that come out exactly. */
typedef struct ff_rule {
    size_t n;
    int degree;
    double *p, *q, *r, *weight;
} ff_rule;

enum { FF_MAPPED_MOST = 96 }; /* nodes along a side at the last level */

/* n nodes and weights on [-1, 1] along a side of those that crowd. */
typedef struct ff_line {
    int n;
    double x[FF_MAPPED_MOST], w[FF_MAPPED_MOST];
} ff_line;

/* The rules of an aperture and of the cone of its source. */
typedef struct ff_rules {
    ff_aperture a;
    double tolerance; /* of a mean, between a rule and the next */
    double reach;     /* radians: how far the two take a pair from its centres at most */
    ff_rule detector[FF_LEVEL_MAPPED], source[FF_LEVEL_MAPPED];
    /* of each level that serves all pairs: the rules of the two; the smaller cone needs fewer nodes */
    int of_detector[FF_LEVEL_MAPPED], of_source[FF_LEVEL_MAPPED];
    /* of the levels whose nodes crowd: they do over the larger cone; a rule of the smaller one goes with each */
    int crowds; /* 0: that of the source, 1: the detector */
    ff_aperture larger;
    const ff_rule *smaller[FF_LEVELS];
    int n_levels; /* up to which the nodes of both are few enough */
    ff_line side[FF_LEVELS - FF_LEVEL_MAPPED];
    double storage[];
} ff_rules;

/* NULL without memory. Released with free. */
ff_rules *ff_rules_new(const ff_aperture *a, double tolerance);

/* ---- narrow lobes ------------------------------------------------------------------------------ */

/* A peak of a model: where it is, and how it is stretched. Distances are in half widths at half of the peak. */
typedef struct ff_needle {
    double at[2], inverse[3]; /* centre and inverse square of its ellipse: xx, xy, yy */
    int of_cosines;           /* 1: a peak in the sum of direction cosines, not in slopes of the half vector */
} ff_needle;

typedef struct ff_needles {
    uint32_t n;
    ff_needle needle[FF_MAX_LOBES + FF_MAX_BASES];
} ff_needles;

/* The peaks of a model made ready: one of each lobe, and of each base that has one. */
void ff_needles_find(const ff_prepared *p, ff_needles *out);

/* Half width at half of the peak along an azimuth, radians of the normal's angle. */
double ff_needle_width(const ff_needle *needle, double azimuth);

/* How a needle looks from the centre of an exit: the square of the distance from it, in half widths, is c + 2 b.x + x.M x at x =
 * (p, q). */
typedef struct ff_needle_view {
    double c, b[2], m[3];
} ff_needle_view;

/* wi, wo: unit vectors; e [2][3]: the directions of p and q. */
void ff_needle_look(const ff_needle *needle, const double wi[3], const double wo[3], double e[2][3], ff_needle_view *out);

/* The square of the aperture's radius in half widths of the needle. */
double ff_needle_stretch(const ff_needle_view *v, double radius);

/* ---- means over a block ------------------------------------------------------------------------- */

/* What a thread works in. Planes are [FF_BLOCK]. */
typedef struct ff_average_work {
    size_t n_channels, n_columns;
    double *f, *df;                /* [C], [C][columns] the means and their derivatives                             */
    double error[FF_BLOCK];        /* largest difference, by the mean, to the next level; 0 where a bound says it is below */
    unsigned char level[FF_BLOCK]; /* at which each was made                                                        */
    double *now, *dnow, *before;   /* [C], [C][columns], [C] of a group of lanes                                    */
    double *least, *most;          /* [C] of the values at the nodes                                                */
    double centre[6][FF_BLOCK], node[6][FF_BLOCK], weight[FF_BLOCK], value[FF_BLOCK], inverse[FF_BLOCK];
    double other[3];              /* the direction about which the nodes of one pair are not */
    double frame[2][2][FF_BLOCK]; /* cosine and sine of the azimuth, of both directions                            */
    double ratio[FF_BLOCK];       /* the aperture's reach in distances over which the narrowest lobe varies */
    unsigned char lane[FF_BLOCK], start[FF_BLOCK], done[FF_BLOCK], cut[FF_BLOCK]; /* cut: the horizon is near the aperture */
    double t[3][FF_MAPPED_MOST], tw[3][FF_MAPPED_MOST];
    double *p, *q, *r, *w; /* [FF_MAPPED_MOST^2] nodes of one pair                                          */
    ff_block_work *block;
    double storage[];
} ff_average_work;

/* [count], for as many threads, in one piece each; NULL without memory. Released with ff_average_works_free. */
ff_average_work **ff_average_works_new(size_t count, size_t n_channels, size_t n_columns);
void ff_average_works_free(ff_average_work **works);

/* A model made ready and how its means are made. */
typedef struct ff_averaging {
    const ff_rules *rules; /* NULL: a point */
    const ff_prepared *prepared;
    ff_prepared values; /* without derivatives; borrows from prepared */
    ff_needles needles;
} ff_averaging;

/* needles NULL: those of prepared, which must outlive it. */
void ff_averaging_make(const ff_rules *rules, const ff_prepared *prepared, const ff_needles *needles, ff_averaging *out);

/* Does a bound say that the centres of all n pairs suffice? */
int ff_average_centres_do(const ff_averaging *a, const ff_dirs *w, size_t n, ff_average_work *work);

/* Chooses the level of each of n pairs, into work->level and work->error, and leaves the means in work->f. */
void ff_average_choose(const ff_averaging *a, const ff_dirs *w, size_t n, ff_average_work *work);

/* The means of n pairs and their derivatives by all columns of the model made ready, at these levels [n]. A pair at or below the
 * horizon has 0. */
void ff_average_at(const ff_averaging *a, const ff_dirs *w, size_t n, const unsigned char *level, ff_average_work *work);
#endif
