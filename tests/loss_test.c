/* Losses, weights and robust losses on four samples whose numbers were worked out by hand. Of the losses that are named here
 * nothing calls the program's own functions: what is expected is written as arithmetic on the cosines, the data and the one value
 * that the model has everywhere. */
#include "fit_samples.h"
#include "pass_of.h"
#include "loss_samples.h"

static const double pi = 3.14159265358979323846;

/* The model is Lambert's with kd = pi / 4, so that f = 1/4 for every sample. The cosines make f x a cube, the data y x:
 *
 *      x       f x            y x              f x - y x
 *      0.5     0.125 = .5^3   0.064 = .4^3      0.061
 *      0.864   0.216 = .6^3   0.343 = .7^3     -0.127
 *      0.256   0.064 = .4^3   0.064 = .4^3      0
 *      0.108   0.027 = .3^3   0.008 = .2^3      0.019                                                  */
enum { N = 4 };
static const double F = 0.25;
static const double X[N] = {0.5, 0.864, 0.256, 0.108};
static const double YX[N] = {0.064, 0.343, 0.064, 0.008};
static const double SOLID_ANGLE[N] = {1, 2, 3, 2};    /* mean 2: the weights are these by 2 */
static const double SIGMA[N] = {0.1, 0.2, 0.05, 0.1}; /* of y, 1/sr                         */

/* ---- what the program says ------------------------------------------------------------------- */

static ff_table make_table(const double *y, int with_sigma, int with_weight)
{
    ff_table t;
    if (ff_table_init(N, 1, NULL, with_sigma, with_weight, &t, NULL)) {
        printf("out of memory\n");
        exit(1);
    }
    t.radians_per_unit = 1;
    for (int i = 0; i < N; i++) {
        t.angle[0][i] = acos(X[i]);
        t.angle[2][i] = 0.3 * i; /* the exit enters no loss */
        t.value[i] = y[i];
        if (with_sigma) t.sigma[i] = SIGMA[i];
        if (with_weight) t.weight[i] = SOLID_ANGLE[i];
    }
    return t;
}

static ff_table hand_table(void)
{
    double y[N];
    for (int i = 0; i < N; i++) y[i] = YX[i] / X[i];
    return make_table(y, 1, 1);
}

static ff_fit_options options_of(ff_loss loss, ff_weighting weighting)
{
    ff_fit_options o = fit_options();
    o.loss = loss;
    o.weighting = weighting;
    o.max_theta = pi / 2;
    return o;
}

/* Objective and its derivative by f at a value f of the model. */
static double objective(const ff_table *t, const ff_fit_options *o, double f, double *slope)
{
    const fit_surface s = fit_surface_make("lambert", 1, "");
    ff_problem *p = NULL;
    ff_layout layout;
    ff_normal normal = {.cost2 = NAN};
    ff_pass pass;
    ff_error err = {0};
    double kd = pi * f, gram[1] = {0}, by_kd[1] = {NAN};
    ff_status status = ff_problem_make(t, &s.model, 1, o, &p, &err);
    if (!status) status = ff_layout_init(&s.model, 1, FF_SHAPE_ISOTROPIC, 0, &layout, &err);
    if (!status) status = ff_layout_normal(&layout, &normal);
    if (!status) status = pass_of(&layout, p, o, s.shape, &kd, &pass);
    if (!status) {
        status = ff_pass_run(&pass, 0, &normal);
        ff_pass_free(&pass);
        assemble(&layout, &normal, NULL, gram, by_kd);
    }
    FF_CHECK(status == FF_OK, "%s", err.message);
    const double value = normal.cost2 / 2;
    ff_normal_free(&normal);
    ff_problem_free(p);
    if (slope) *slope = pi * by_kd[0];
    return value;
}

/* ---- the same by hand ------------------------------------------------------------------------ */

/* Mean |y|, here of positive data. */
static double mean_by_hand(void)
{
    double sum = 0;
    for (int i = 0; i < N; i++) sum += YX[i] / X[i] / N;
    return sum;
}

/* Residual of sample i before its weight, as in the table of docs/fitting-reference.md. */
static double residual_by_hand(ff_loss loss, int i, double f)
{
    const double y = YX[i] / X[i];
    switch (loss) {
    case FF_LOSS_COSINE:
        return f * X[i] - YX[i];
    case FF_LOSS_LOG:
        return log((1 + f * X[i]) / (1 + YX[i]));
    case FF_LOSS_CUBE_ROOT:
        return cbrt(f * X[i]) - cbrt(YX[i]);
    case FF_LOSS_RELATIVE:
        return f / y - 1;
    case FF_LOSS_PLAIN:
        return f - y;
    default:
        return loss_factor(loss, y, X[i], 0.001 * mean_by_hand()) * (loss_g(loss, f, X[i]) - loss_g(loss, y, X[i]));
    }
}

/* What one standard deviation of y makes of g(y) by the first derivative: sigma, sigma x / (1 + y x), sigma x / (3 (y x)^(2/3)).
 * The linear losses are all (f - y) / sigma then. */
static double deviation_by_hand(ff_loss loss, int i)
{
    if (loss == FF_LOSS_LOG) return SIGMA[i] * X[i] / (1 + YX[i]);
    if (loss == FF_LOSS_CUBE_ROOT) return SIGMA[i] * X[i] / (3 * cbrt(YX[i] * YX[i]));
    return SIGMA[i] * loss_slope(loss, YX[i] / X[i], X[i]);
}

static double by_hand(ff_loss loss, ff_weighting weighting, double f)
{
    double sum = 0;
    for (int i = 0; i < N; i++) {
        const double y = YX[i] / X[i], in_sigmas = (loss_g(loss, f, X[i]) - loss_g(loss, y, X[i])) / deviation_by_hand(loss, i),
                     r = weighting == FF_WEIGHT_SIGMA ? in_sigmas : residual_by_hand(loss, i, f);
        sum += (weighting == FF_WEIGHT_SOLID_ANGLE ? SOLID_ANGLE[i] / 2 : 1) * r * r / 2;
    }
    return sum;
}

static double slope_by_hand(ff_loss loss, ff_weighting weighting, double f)
{
    const double h = 1e-4;
    const double wide = (by_hand(loss, weighting, f + 2 * h) - by_hand(loss, weighting, f - 2 * h)) / (4 * h),
                 narrow = (by_hand(loss, weighting, f + h) - by_hand(loss, weighting, f - h)) / (2 * h);
    return (4 * narrow - wide) / 3; /* Richardson */
}

/* ---- the tests ------------------------------------------------------------------------------- */

/* Twice the objective at f = 1/4, term by term. */
static void numbers(void)
{
    static const struct {
        ff_loss loss;
        ff_weighting weighting;
        double term[N];
    } expected[] = {
        /* .061^2, .127^2, 0, .019^2 */
        {FF_LOSS_COSINE, FF_WEIGHT_SAMPLE, {0.003721, 0.016129, 0, 0.000361}},
        {FF_LOSS_COSINE, FF_WEIGHT_SOLID_ANGLE, {0.5 * 0.003721, 0.016129, 0, 0.000361}},
        /* .061/.5/.1 = 1.22; .127/.864/.2; .019/.108/.1 */
        {FF_LOSS_COSINE, FF_WEIGHT_SIGMA, {1.4884, 0.127 * 0.127 / (0.1728 * 0.1728), 0, 0.019 * 0.019 / (0.0108 * 0.0108)}},
        /* ln 1.125 = 0.1177830357, ln 1.064 = 0.0620353909, difference 0.0557476447, squared 0.0031077999;
         * ln 1.216 = 0.1955667835, ln 1.343 = 0.2949059175, difference 0.0993391340, squared 0.0098682635;
         * ln 1.027 = 0.0266419309, ln 1.008 = 0.0079681696, difference 0.0186737613, squared 0.0003487094 */
        {FF_LOSS_LOG, FF_WEIGHT_SAMPLE, {0.0031077999, 0.0098682635, 0, 0.0003487094}},
        /* .1^2, .1^2, 0, .1^2 */
        {FF_LOSS_CUBE_ROOT, FF_WEIGHT_SAMPLE, {0.01, 0.01, 0, 0.01}},
        {FF_LOSS_CUBE_ROOT, FF_WEIGHT_SOLID_ANGLE, {0.005, 0.01, 0, 0.01}},
        /* slope of the cube root at y: .5/(3 .16) = 1.0416667, .864/(3 .49), .108/(3 .04) = .9;
         * .1/(.1 1.0416667) = .96, .1 1.47/(.2 .864) = .8506944, .1/(.1 .9) = 1.1111111 */
        {FF_LOSS_CUBE_ROOT, FF_WEIGHT_SIGMA, {0.9216, 0.147 * 0.147 / (0.1728 * 0.1728), 0, 100.0 / 81}},
        /* .061/.064 = .953125, .127/.343 = .3702624, .019/.008 = 2.375 */
        {FF_LOSS_RELATIVE, FF_WEIGHT_SAMPLE, {0.953125 * 0.953125, 0.127 * 0.127 / (0.343 * 0.343), 0, 5.640625}},
        /* .122, .127/.864, .019/.108 */
        {FF_LOSS_PLAIN, FF_WEIGHT_SAMPLE, {0.014884, 0.127 * 0.127 / (0.864 * 0.864), 0, 0.019 * 0.019 / (0.108 * 0.108)}},
    };
    ff_table t = hand_table();
    for (size_t k = 0; k < sizeof expected / sizeof expected[0]; k++) {
        const ff_fit_options o = options_of(expected[k].loss, expected[k].weighting);
        const double *term = expected[k].term, sum = term[0] + term[1] + term[2] + term[3];
        const double tolerance = expected[k].loss == FF_LOSS_LOG ? 1e-7 : 1e-10; /* of the digits above */
        FF_CHECK_CLOSE(objective(&t, &o, F, NULL), sum / 2, tolerance, 0);
        FF_CHECK_CLOSE(by_hand(expected[k].loss, expected[k].weighting, F), sum / 2, tolerance, 0);
    }
    ff_table_clear(&t);
}

/* Every loss with every weight, away from the cubes too, and the slope that the solver sees. */
static void slopes(void)
{
    static const ff_weighting weightings[] = {FF_WEIGHT_SAMPLE, FF_WEIGHT_SOLID_ANGLE, FF_WEIGHT_SIGMA};
    static const double at[] = {0.02, 0.1, 0.25, 0.31};
    ff_table t = hand_table();
    for (int loss = 0; loss < FF_LOSS_COUNT; loss++)
        for (int w = 0; w < 3; w++)
            for (int k = 0; k < 4; k++) {
                const ff_fit_options o = options_of((ff_loss)loss, weightings[w]);
                double slope;
                const double value = objective(&t, &o, at[k], &slope);
                FF_CHECK_CLOSE(value, by_hand((ff_loss)loss, weightings[w], at[k]), 1e-10, 1e-14);
                FF_CHECK_CLOSE(slope, slope_by_hand((ff_loss)loss, weightings[w], at[k]), 1e-7, 1e-8);
            }
    ff_table_clear(&t);
}

/* Negative data, 0, and data that a loss has no value for. */
static void corners(void)
{
    /* mean |y| = 1/4, so that the relative loss divides by no less than 0.00025:
     * (.25 - .5)/.5 = -.5; (.25 + .2)/.00025 = 1800; .25/.00025 = 1000; (.25 - .3)/.3 = -1/6 */
    static const double signs[N] = {0.5, -0.2, 0, 0.3};
    ff_table t = make_table(signs, 0, 0);
    ff_fit_options o = options_of(FF_LOSS_RELATIVE, FF_WEIGHT_SAMPLE);
    FF_CHECK_CLOSE(objective(&t, &o, F, NULL), (0.25 + 1800.0 * 1800 + 1000.0 * 1000 + 1 / 36.0) / 2, 1e-10, 0);
    ff_table_clear(&t);

    /* the cube root is odd: y x = -.064 gives -.4, and f x = .125 lies .9 above; at 0 it is 0: .6; then .4 - .4 and .3 + .2 */
    const double odd[N] = {-0.064 / 0.5, 0, 0.25, -0.008 / 0.108};
    t = make_table(odd, 0, 0);
    o.loss = FF_LOSS_CUBE_ROOT;
    FF_CHECK_CLOSE(objective(&t, &o, F, NULL), (0.81 + 0.36 + 0 + 0.25) / 2, 1e-9, 0);
    /* ln(1.125/.936), ln(1.216), 0, ln(1.027/.992) */
    o.loss = FF_LOSS_LOG;
    const double a = log(1.125 / 0.936), b = log(1.216), d = log(1.027 / 0.992);
    FF_CHECK_CLOSE(objective(&t, &o, F, NULL), (a * a + b * b + d * d) / 2, 1e-10, 0);
    ff_table_clear(&t);

    /* y x = -1.25: ln(1 + y x) does not exist, and that sample is left out */
    static const double low[N] = {-2.5, 0.3, 0.3, 0.3};
    t = make_table(low, 0, 0);
    const fit_surface s = fit_surface_make("lambert", 1, "");
    ff_problem *p = NULL;
    ff_selection selection;
    FF_CHECK(ff_problem_make(&t, &s.model, 1, &o, &p, NULL) == FF_OK, "three samples are left");
    ff_problem_selection(p, &selection);
    FF_CHECK(selection.invalid == 1 && selection.used == 3, "%zu invalid, %zu used", selection.invalid, selection.used);
    ff_problem_free(p);
    ff_table_clear(&t);
}

/* rho of r = .061, -.127, 0, .019 with a scale of .05, that is of s = .003721, .016129, 0, .000361 with b^2 = .0025. */
static void robust(void)
{
    ff_table t = hand_table();
    ff_fit_options o = options_of(FF_LOSS_COSINE, FF_WEIGHT_SAMPLE);
    o.robust_scale = 0.05;
    o.robust = FF_ROBUST_HUBER; /* 2 b |r| - b^2 beyond b: .0061 - .0025, .0127 - .0025 */
    FF_CHECK_CLOSE(objective(&t, &o, F, NULL), (0.0036 + 0.0102 + 0 + 0.000361) / 2, 1e-12, 0);
    o.robust = FF_ROBUST_CAUCHY; /* b^2 ln(1 + s/b^2): s/b^2 = 1.4884, 6.4516, 0, .1444 */
    FF_CHECK_CLOSE(objective(&t, &o, F, NULL), 0.0025 * (log(2.4884) + log(7.4516) + log(1.1444)) / 2, 1e-10, 0);
    o.robust = FF_ROBUST_TUKEY; /* b^2/3 (1 - (1 - s/b^2)^3) up to b, b^2/3 beyond: 1, 1, 0, 1 - .8556^3 */
    FF_CHECK_CLOSE(objective(&t, &o, F, NULL), 0.0025 / 3 * (3 - 0.8556 * 0.8556 * 0.8556) / 2, 1e-12, 0);
    /* Slopes by f, sum of rho'(s) r x with rho' = b/|r| or 1; 1/(1 + s/b^2); (1 - s/b^2)^2 or 0. */
    double slope;
    o.robust = FF_ROBUST_HUBER;
    (void)objective(&t, &o, F, &slope);
    FF_CHECK_CLOSE(slope, 0.05 * 0.5 - 0.05 * 0.864 + 0.019 * 0.108, 1e-12, 0);
    o.robust = FF_ROBUST_CAUCHY;
    (void)objective(&t, &o, F, &slope);
    FF_CHECK_CLOSE(slope, 0.061 * 0.5 / 2.4884 - 0.127 * 0.864 / 7.4516 + 0.019 * 0.108 / 1.1444, 1e-12, 0);
    o.robust = FF_ROBUST_TUKEY;
    (void)objective(&t, &o, F, &slope);
    FF_CHECK_CLOSE(slope, 0.8556 * 0.8556 * 0.019 * 0.108, 1e-12, 0);
    /* The weight is inside: with solid angles the first residual is .061/sqrt(2) = .0431, below the scale. */
    o = options_of(FF_LOSS_COSINE, FF_WEIGHT_SOLID_ANGLE);
    o.robust_scale = 0.05;
    o.robust = FF_ROBUST_HUBER;
    FF_CHECK_CLOSE(objective(&t, &o, F, NULL), (0.0018605 + 0.0102 + 0 + 0.000361) / 2, 1e-12, 0);
    /* Around a curved loss: residuals .1, .1, 0, .1. */
    o = options_of(FF_LOSS_CUBE_ROOT, FF_WEIGHT_SAMPLE);
    o.robust_scale = 0.1; /* s/b^2 = 1, 1, 0, 1 */
    o.robust = FF_ROBUST_CAUCHY;
    FF_CHECK_CLOSE(objective(&t, &o, F, NULL), 0.01 * 3 * log(2) / 2, 1e-9, 0);
    ff_table_clear(&t);
}

/* Two channels are two sums; the relative floor is each channel's own. */
static void channels(void)
{
    ff_table t;
    FF_CHECK(ff_table_init(2, 2, NULL, 0, 0, &t, NULL) == FF_OK, "no memory");
    t.radians_per_unit = 1;
    static const double x[2] = {0.5, 0.8}, y[4] = {0.1, 0.2, 4, 0}; /* means .15 and 2, floors .00015 and .002 */
    for (int i = 0; i < 2; i++) t.angle[0][i] = acos(x[i]);
    memcpy(t.value, y, sizeof y);
    const fit_surface s = fit_surface_make("lambert", 2, "kd=0.3:0.6");
    ff_fit_result r;
    ff_fit_options o = options_of(FF_LOSS_COSINE, FF_WEIGHT_SAMPLE);
    FF_CHECK(fit_table(&t, &s.model, &o, &r, NULL, NULL) == FF_OK, "no fit");
    /* sum x^2 y / sum x^2: (.25 .1 + .64 .2)/.89, and (.25 4)/.89 = 1.12 is above what kd <= 1 allows */
    FF_CHECK_CLOSE(r.channel_value[0].value, pi * 0.153 / 0.89, 1e-9, 0);
    FF_CHECK(r.channel_value[1].value == 1 && r.channel_value[1].at_bound == 1, "%g", r.channel_value[1].value);
    /* f = .153/.89 and 1/pi; the residuals of the report by sample weight, over four values */
    const double f0 = 0.153 / 0.89, f1 = 1 / pi;
    const double e[4] = {f0 - 0.1, f0 - 0.2, f1 - 4, f1};
    FF_CHECK_CLOSE(r.residual.rmse, sqrt((e[0] * e[0] + e[1] * e[1] + e[2] * e[2] + e[3] * e[3]) / 4), 1e-9, 0);
    FF_CHECK_CLOSE(r.residual.cosine_rmse,
                   sqrt((0.25 * e[0] * e[0] + 0.64 * e[1] * e[1] + 0.25 * e[2] * e[2] + 0.64 * e[3] * e[3]) / 4), 1e-9, 0);
    FF_CHECK_CLOSE(r.residual.objective, 2 * r.residual.cosine_rmse * r.residual.cosine_rmse, 1e-9, 0);
    FF_CHECK_CLOSE(r.residual.max_abs, 4 - 1 / pi, 1e-9, 0);
    const double l[4] = {log((1 + 0.5 * f0) / 1.05), log((1 + 0.8 * f0) / 1.16), log((1 + 0.5 * f1) / 3), log(1 + 0.8 * f1)};
    FF_CHECK_CLOSE(r.residual.log_rmse, sqrt((l[0] * l[0] + l[1] * l[1] + l[2] * l[2] + l[3] * l[3]) / 4), 1e-9, 0);
    const double c[4] = {cbrt(0.5 * f0) - cbrt(0.05), cbrt(0.8 * f0) - cbrt(0.16), cbrt(0.5 * f1) - cbrt(2), cbrt(0.8 * f1)};
    FF_CHECK_CLOSE(r.residual.cube_root_rmse, sqrt((c[0] * c[0] + c[1] * c[1] + c[2] * c[2] + c[3] * c[3]) / 4), 1e-9, 0);
    ff_fit_result_clear(&r);

    o.loss = FF_LOSS_RELATIVE;
    FF_CHECK(fit_table(&t, &s.model, &o, &r, NULL, NULL) == FF_OK, "no fit");
    /* sum (1/y) / sum (1/y^2) = (10 + 5)/(100 + 25); with the floor: (4/16)/(1/16 + 1/.002^2) */
    FF_CHECK_CLOSE(r.channel_value[0].value, pi * 15 / 125, 1e-9, 0);
    FF_CHECK_CLOSE(r.channel_value[1].value, pi * 0.25 / (0.0625 + 250000), 1e-6, 0);
    ff_fit_result_clear(&r);
    ff_table_clear(&t);
}

/* Where each fit ends, the slope of the objective by hand is 0; or kd is 1 and the objective falls further beyond. */
static void minima(void)
{
    static const ff_weighting weightings[] = {FF_WEIGHT_SAMPLE, FF_WEIGHT_SOLID_ANGLE, FF_WEIGHT_SIGMA};
    ff_table t = hand_table();
    const fit_surface s = fit_surface_make("lambert", 1, "");
    int inside = 0;
    for (int loss = 0; loss < FF_LOSS_COUNT; loss++)
        for (int w = 0; w < 3; w++) {
            const ff_fit_options o = options_of((ff_loss)loss, weightings[w]);
            ff_fit_result r;
            FF_CHECK(fit_table(&t, &s.model, &o, &r, NULL, NULL) == FF_OK, "no fit");
            const double f = r.channel_value[0].value / pi, slope = slope_by_hand((ff_loss)loss, weightings[w], f),
                         curvature = slope_by_hand((ff_loss)loss, weightings[w], f + 0.01) - slope;
            FF_CHECK(fabs(slope) < 1e-4 * curvature || (r.channel_value[0].at_bound == 1 && slope < 0), "%s, %s: f = %g, slope %g",
                     ff_loss_name(loss), ff_weighting_name((int)weightings[w]), f, slope);
            FF_CHECK_CLOSE(r.residual.objective, by_hand((ff_loss)loss, weightings[w], f), 1e-9, 0);
            inside += r.channel_value[0].at_bound == 0;
            ff_fit_result_clear(&r);
        }
    FF_CHECK(inside >= 10, "only %d of 15 fits end inside", inside);
    ff_table_clear(&t);
}

FF_TEST_MAIN(FF_TEST(numbers), FF_TEST(slopes), FF_TEST(corners), FF_TEST(robust), FF_TEST(channels), FF_TEST(minima))
