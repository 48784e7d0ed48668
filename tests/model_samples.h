/** @file model_samples.h  What the tests of models/ share: every combination of registered terms, seeded random parameters and
 * pairs of directions, and derivatives by extrapolated differences. C. */
#ifndef MODEL_SAMPLES_H
#define MODEL_SAMPLES_H
#include "fit_samples.h"
#include "fit/problem/internal_problem.h"

#define MODEL_PI 3.14159265358979323846
enum { MODEL_PAIRS = 1024, MODEL_LABEL = FF_MODEL_NAME + 64 };

/* ---- pairs of directions --------------------------------------------------------------------- */

/** Planes wix wiy wiz wox woy woz of n <= MODEL_PAIRS pairs. */
typedef struct model_pairs {
    size_t n;
    double w[6][MODEL_PAIRS];
} model_pairs;

static inline ff_dirs model_dirs(const model_pairs *p)
{
    return (ff_dirs){p->w[0], p->w[1], p->w[2], p->w[3], p->w[4], p->w[5]};
}

static inline void model_direction(double theta, double phi, double out[3])
{
    out[0] = sin(theta) * cos(phi);
    out[1] = sin(theta) * sin(phi);
    out[2] = cos(theta);
}

static inline void model_pairs_add(model_pairs *p, const double wi[3], const double wo[3])
{
    if (p->n == MODEL_PAIRS) {
        printf("the test itself is wrong: more than %d pairs of directions\n", MODEL_PAIRS);
        exit(1);
    }
    for (size_t k = 0; k < 3; k++) p->w[k][p->n] = wi[k], p->w[k + 3][p->n] = wo[k];
    p->n++;
}

/** A direction uniform in solid angle up to 85 degrees. */
static inline void model_random_direction(uint64_t *state, double out[3])
{
    const double theta = fit_theta(state, cos(85 * FIT_DEGREE));
    model_direction(theta, 2 * MODEL_PI * fit_uniform(state), out);
}

/** Mirror image of wi about the normal of slope s; 0 when it is not well above the horizon. */
static inline int model_mirror(const double wi[3], const double s[2], double wo[3])
{
    const double hz = 1 / sqrt(1 + s[0] * s[0] + s[1] * s[1]), h[3] = {-s[0] * hz, -s[1] * hz, hz};
    const double c = wi[0] * h[0] + wi[1] * h[1] + wi[2] * h[2];
    for (int k = 0; k < 3; k++) wo[k] = 2 * c * h[k] - wi[k];
    const double length = sqrt(wo[0] * wo[0] + wo[1] * wo[1] + wo[2] * wo[2]);
    for (int k = 0; k < 3; k++) wo[k] /= length;
    return wo[2] > cos(85 * FIT_DEGREE);
}

/** Adds n random pairs; every second one mirrors wi about a facet within a few roughnesses of the mean slope of one of the lobes,
 * so that a lobe of any width is met where it is not nothing. */
static inline void model_pairs_random(const ff_model *m, const double *shape, uint64_t *state, size_t n, model_pairs *out)
{
    while (n > 0) {
        double wi[3], wo[3];
        model_random_direction(state, wi);
        model_random_direction(state, wo);
        if (n % 2 && m->n_lobes) {
            ff_lobe_pass pass;
            const uint32_t lobe = (uint32_t)(n / 2) % m->n_lobes;
            ff_model_lobe(m, lobe, shape, &pass, NULL);
            const ff_stretch l = pass.s;
            /* one that is not stretched may have any width */
            const int stretched = ff_ndf_at(m->lobe[lobe].ndf)->alpha_own == 0;
            const double q = stretched ? 0.1 * pow(30, fit_uniform(state)) : 1e-3 * pow(3e3, fit_uniform(state)),
                         phi = 2 * MODEL_PI * fit_uniform(state), u = q * cos(phi), v = q * sin(phi);
            const double s[2] = {l.x0 + l.ax * u, l.y0 + l.ay * (l.r * u + sqrt(1 - l.r * l.r) * v)};
            if (!model_mirror(wi, s, wo)) continue;
        }
        model_pairs_add(out, wi, wo);
        n--;
    }
}

/* ---- models and parameters ------------------------------------------------------------------- */

enum { MODEL_COMBINATIONS = 1024 };
typedef struct model_list {
    size_t n;
    int term[MODEL_COMBINATIONS][FF_TERM_KINDS];
} model_list;

static inline void model_list_add(model_list *l, int ndf, int masking, int fresnel, int diffuse)
{
    ff_model m;
    if (ff_model_compose(ndf, masking, fresnel, diffuse, &m, NULL)) return; /* these do not go together */
    if (l->n == MODEL_COMBINATIONS) {
        printf("the test itself is wrong: more than %d combinations\n", MODEL_COMBINATIONS);
        exit(1);
    }
    const int term[FF_TERM_KINDS] = {ndf, masking, fresnel, diffuse};
    memcpy(l->term[l->n++], term, sizeof term);
}

/** Every distribution under every masking that it goes with, with Schlick's Fresnel term and without any on a matte base; and every
 * Fresnel and diffuse term with three distributions of different kinds. What goes with what is said by name, so that a term more or
 * fewer leaves the other combinations as they are. */
static inline const model_list *model_all(void)
{
    static model_list list;
    const int N = (int)ff_term_count(FF_NDF), G = (int)ff_term_count(FF_MASKING), F = (int)ff_term_count(FF_FRESNEL),
              B = (int)ff_term_count(FF_DIFFUSE), schlick = ff_term_find(FF_FRESNEL, "schlick"),
              none = ff_term_find(FF_FRESNEL, "none"), conductor = ff_term_find(FF_FRESNEL, "conductor"),
              matte[] = {-1, ff_term_find(FF_DIFFUSE, "lambert"), ff_term_find(FF_DIFFUSE, "oren-nayar")};
    const int with[][2] = {{ff_term_find(FF_NDF, "beckmann"), ff_term_find(FF_MASKING, "smith-separable")},
                           {ff_term_find(FF_NDF, "ggx"), ff_term_find(FF_MASKING, "v-cavity")},
                           {ff_term_find(FF_NDF, "phong"), ff_term_find(FF_MASKING, "smith-height-correlated")}};
    if (list.n) return &list;
    for (int d = 0; d < N; d++)
        for (int g = 0; g < G; g++) {
            model_list_add(&list, d, g, schlick, -1);
            model_list_add(&list, d, g, none, matte[1]);
        }
    for (size_t i = 0; i < 3; i++) {
        for (int f = 0; f < F; f++) model_list_add(&list, with[i][0], with[i][1], f, matte[i]);
        for (int b = 0; b < B; b++) model_list_add(&list, with[i][0], with[i][1], i == 2 ? conductor : schlick, b);
    }
    return &list;
}

static inline size_t model_combination_count(void)
{
    return model_all()->n;
}

/** Number k with its name into label [MODEL_LABEL]. */
static inline ff_model model_combination(size_t k, char *label)
{
    ff_model m;
    const int *t = model_all()->term[k];
    if (ff_model_compose(t[0], t[1], t[2], t[3], &m, NULL)) exit(1);
    ff_model_set_table(&m, fit_profile());
    ff_model_expression(&m, label, MODEL_LABEL);
    return m;
}

/** Which of n a case takes where the cases go through them in turn: by the name of the case, not by its number. */
static inline int model_turn(const char *label, int n)
{
    uint64_t state = ff_test_stream("turn of %s", label);
    return (int)(fit_random(&state) % (uint64_t)n);
}

/** One lobe without a diffuse term; 0 when the terms do not go together. */
static inline int model_lobe(size_t ndf, const char *masking, const char *fresnel, ff_model *m)
{
    if (ff_model_compose((int)ndf, ff_term_find(FF_MASKING, masking), ff_term_find(FF_FRESNEL, fresnel), -1, m, NULL)) return 0;
    ff_model_set_table(m, fit_profile());
    return 1;
}

/** Parses an expression that must be right. */
static inline ff_model model_parse(const char *expression)
{
    return fit_surface_make(expression, 1, "").model;
}

/** What rounding may leave in f, 1/sr: a base that is coupled to albedos has factors 1 - a, and those of a nearly perfect mirror
 * are rounding alone. */
static inline double model_floor(const ff_model *m)
{
    uint32_t couples = 0;
    for (uint32_t b = 0; b < m->n_bases; b++) couples |= ff_diffuse_at(m->base[b].diffuse)->couples;
    return couples & (FF_COUPLE_ALBEDO | FF_COUPLE_LOSS) ? 1e-3 : 0;
}

/** Must every lobe be without a mean slope? */
static inline int model_needs_centred(const ff_model *m)
{
    for (uint32_t l = 0; l < m->n_lobes; l++)
        if (ff_term_at(FF_MASKING, (size_t)m->lobe[l].masking)->claims & FF_NEEDS_CENTRED) return 1;
    return 0;
}

/** What random parameters may be: equal roughness along both axes, any ellipse, any ellipse with a mean slope. */
typedef enum model_freedom { MODEL_ROUND = 0, MODEL_CENTRED = 1, MODEL_TILTED = 2 } model_freedom;

/** A value strictly inside the box, uniform in the coordinate that the parameter is fitted in; reach in (0, 1]: fraction of the box
 *  about the initial value that is used. */
static inline double model_random_value(const ff_param *p, double reach, uint64_t *state)
{
    const double lo = ff_coordinate(p, p->lo), hi = ff_coordinate(p, p->hi), init = ff_coordinate(p, p->init),
                 u = 2 * fit_uniform(state) - 1;
    const double x = init + 0.98 * reach * (u > 0 ? hi - init : init - lo) * u;
    return p->flags & FF_PARAM_LOG ? exp(x) - p->offset : p->flags & FF_PARAM_ATANH ? tanh(x) : x;
}

/** Is it one of the two mean slopes? */
static inline int model_is_slope(const ff_param *p)
{
    return strncmp(p->name, "slope_", 6) == 0;
}

static inline void model_random_parameters(const ff_model *m, size_t n_channels, model_freedom freedom, double reach,
                                           uint64_t *state, double *shape, double *channel)
{
    for (uint32_t k = 0; k < m->n_shape; k++) {
        const ff_param *p = m->shape[k].info;
        shape[k] = model_random_value(p, reach, state);
        if (model_is_slope(p) && (freedom != MODEL_TILTED || model_needs_centred(m))) shape[k] = 0;
        if (freedom != MODEL_ROUND) continue;
        if (strcmp(p->name, "alpha_y") == 0) shape[k] = shape[k - 1];
        if (strcmp(p->name, "r_xy") == 0) shape[k] = 0;
    }
    for (size_t i = 0; i < n_channels * m->n_channel; i++) {
        const ff_param *p = m->channel[i % m->n_channel].info;
        channel[i] = strcmp(p->name, "ks") == 0 && (p->flags & FF_PARAM_HELD) ? 0.5 + 0.5 * fit_uniform(state)
                                                                              : model_random_value(p, reach, state);
    }
}

/* ---- derivatives by differences -------------------------------------------------------------- */

/** Ridders' extrapolation (Ridders 1982; Press et al., Numerical Recipes, section 5.7) of central differences at steps h,
 * h/MODEL_RATIO, h/MODEL_RATIO^2 ... Every run of up to MODEL_TABLEAU successive steps is extrapolated and the one of least
 * estimated error is kept, so that a function with a kink inside the first steps, or one that changes faster than they can see, is
 * still resolved by later ones. Steps that leap over all that happens find a plateau without any error: when MODEL_AGAINST shorter
 * steps after each other contradict, these are believed. */
#define MODEL_RATIO 1.6
enum { MODEL_TABLEAU = 9, MODEL_LEVELS = 34, MODEL_AGAINST = 3 };
typedef struct model_ridders {
    double row[3][MODEL_TABLEAU]; /**< the last rows of the tableau, latest first: extrapolations that end at a step */
    int n;                        /**< entries of the latest                                                         */
    int against;                  /**< steps after each other that contradict the best                               */
    double value, error;          /**< best so far; error infinite when there is none                                */
} model_ridders;

static inline void model_ridders_start(model_ridders *r)
{
    r->n = r->against = 0;
    r->value = NAN;
    r->error = HUGE_VAL;
}

/** The differences so far say nothing about the derivative: the steps were too long. */
static inline void model_ridders_drop(model_ridders *r)
{
    r->n = 0;
}

/** The central difference at the next step. noise: what rounding may have done to it. */
static inline void model_ridders_add(model_ridders *r, double difference, double noise)
{
    double(*row)[MODEL_TABLEAU] = r->row, factor = 1, value = NAN, least = HUGE_VAL;
    const int n = r->n < MODEL_TABLEAU - 1 ? r->n : MODEL_TABLEAU - 1;
    memmove(row[1], row[0], 2 * sizeof *row);
    row[0][0] = difference;
    for (int k = 1; k <= n; k++) {
        factor *= MODEL_RATIO * MODEL_RATIO;
        row[0][k] = (factor * row[0][k - 1] - row[1][k - 1]) / (factor - 1);
        if (k < 2) continue;
        /* agreement along two steps of the diagonal: among thousands of derivatives two estimates agree by chance now and then */
        const double along = fmax(fabs(row[0][k] - row[1][k - 1]), fabs(row[1][k - 1] - row[2][k - 2]));
        const double error = fmax(noise, fmax(along, fabs(row[0][k] - row[0][k - 1])));
        if (error < least) value = row[0][k], least = error;
    }
    r->n = n + 1;
    r->against = fabs(value - r->value) > 10 * (least + r->error) ? r->against + 1 : 0;
    if (least < r->error || r->against == MODEL_AGAINST) r->value = value, r->error = least, r->against = 0;
}

/** What a comparison of an analytic derivative with its differences says. */
typedef enum model_verdict { MODEL_RIGHT, MODEL_WRONG, MODEL_UNRESOLVED } model_verdict;
#define MODEL_TOLERANCE 1e-8  /* relative error that a derivative may have */
#define MODEL_RESOLVED  1e-9  /* of the scale: differences with a larger error say nothing */
#define MODEL_ANALYTIC  1e-12 /* of the scale: rounding of the analytic derivative */

/** The analytic derivative may be off by
 *      10 times the error of the differences, which is an estimate (the change along the diagonal, and at least their rounding),
 *      1e-8 of the derivative itself, and
 *      1e-12 of the scale, value / size of the parameter: a derivative is a sum of terms about that large, a few thousand
 * roundings. Not by a fraction of the scale that the differences can see through: where a function is nearly flat its derivative is
 * far below the scale, and 0 would pass. A 0 against differences that are mostly noise passes neither: it is not resolved. */
static inline model_verdict model_judge_to(const model_ridders *r, double analytic, double scale, double accuracy)
{
    const double noise = 10 * r->error + accuracy * scale;
    if (!(r->error <= MODEL_RESOLVED * scale)) return MODEL_UNRESOLVED;
    if (!(fabs(analytic - r->value) <= MODEL_TOLERANCE * fabs(r->value) + noise)) return MODEL_WRONG;
    return analytic == 0 && r->value != 0 ? MODEL_UNRESOLVED : MODEL_RIGHT;
}

static inline model_verdict model_judge(const model_ridders *r, double analytic, double scale)
{
    return model_judge_to(r, analytic, scale, MODEL_ANALYTIC);
}

/** What an analytic derivative is right to, of the scale. An albedo and its derivatives are quadratures of their own, each to 1e-9
 * (models/tools/albedo_integral.c): those of a base that is coupled to one are no better. */
static inline double model_accuracy(const ff_model *m)
{
    uint32_t couples = 0;
    for (uint32_t b = 0; b < m->n_bases; b++) couples |= ff_diffuse_at(m->base[b].diffuse)->couples;
    return couples ? 1e-9 : MODEL_ANALYTIC;
}

/** The first step for a parameter at v: a tenth of its natural size, inside its box. That of a linear one is its value, where that
 * is large: a step of 0.1 from 1e7 is lost in the rounding. */
static inline double model_first_step(const ff_param *p, double v)
{
    const double size = p->flags & FF_PARAM_LOG ? v + p->offset : p->flags & FF_PARAM_ATANH ? 1 - v * v : fmax(1, fabs(v));
    return fmin(0.1 * size, 0.99 * fmin(p->hi - v, v - p->lo));
}

#endif
