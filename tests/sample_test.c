/* Sampling of models. For every distribution and every diffuse term of the registry, at several widths and views: samples against
 * the density that the sampler states (chi-square over a grid of directions, whose probabilities are integrals of the density),
 * the fraction of samples that is not lost against the integral of the density, the mean weight against the albedo. The
 * significance is corrected for the number of checks (Sidak 1967), and the same checks are shown to fail on densities that are
 * wrong. */
#include "model_samples.h"
#include "ff_albedo.h"
#include "ff_sample.h"
#include "simulate/simulate_struct.h"

enum { N = 100000, THETAS = 24, PHIS = 48, BINS = THETAS * PHIS, LABEL = FF_MODEL_NAME + 200 };
static const double significance = 1e-6; /* chance, over all seeds, that a right sampler fails one of all its checks */

/* ---- chances --------------------------------------------------------------------------------- */

/* Upper tail of the gamma distribution, Q(a, x): series below the mean, continued fraction beyond (Press et al., section 6.2). */
static double gamma_tail(double a, double x)
{
    const double front = exp(a * log(x) - x - lgamma(a));
    if (x < a + 1) {
        double term = 1 / a, sum = term;
        for (int k = 1; k < 10000 && term > 1e-17 * sum; k++) sum += term *= x / (a + k);
        return 1 - front * sum;
    }
    double b = x + 1 - a, c = 1e300, d = 1 / b, h = d;
    for (int k = 1; k < 10000; k++) {
        const double an = k * (a - k);
        b += 2;
        d = 1 / (an * d + b);
        c = b + an / c;
        h *= c * d;
        if (fabs(c * d - 1) < 1e-15) break;
    }
    return front * h;
}

/* Of a deviation as large as this many standard deviations, to either side. */
static double normal_tails(double deviations)
{
    return erfc(fabs(deviations) / sqrt(2));
}

static int by_expected(const void *a, const void *b)
{
    const double x = ((const double *)a)[0], y = ((const double *)b)[0];
    return x < y ? -1 : x > y;
}

/* Chance of counts that deviate from n probability as much; bins that expect less than 5 are put together. Pearson 1900. */
static double chi_square(size_t bins, size_t n, const double *probability, const size_t *count)
{
    static double pair[BINS + 1][2];
    double expected = 0, observed = 0, chi = 0;
    int used = 0;
    for (size_t i = 0; i < bins; i++) pair[i][0] = (double)n * probability[i], pair[i][1] = (double)count[i];
    qsort(pair, bins, sizeof *pair, by_expected);
    for (size_t i = 0; i < bins; i++) {
        expected += pair[i][0];
        observed += pair[i][1];
        if (expected < 5 && i + 1 < bins) continue;
        if (!(expected > 0)) return observed > 0 ? 0 : 1;
        chi += (observed - expected) * (observed - expected) / expected;
        expected = observed = 0;
        used++;
    }
    return used > 1 ? gamma_tail(0.5 * (used - 1), fmax(0.5 * chi, 1e-30)) : 1;
}

static void chances_are_right(void)
{
    /* tables of the chi-square distribution: 5 % and 0.1 % points */
    FF_CHECK_CLOSE(gamma_tail(0.5, 0.5 * 3.841458820694124), 0.05, 1e-12, 0);
    FF_CHECK_CLOSE(gamma_tail(5, 0.5 * 18.307038053275146), 0.05, 1e-12, 0);
    FF_CHECK_CLOSE(gamma_tail(5, 0.5 * 29.58829844507442), 0.001, 1e-12, 0);
    FF_CHECK_CLOSE(gamma_tail(500, 500), 0.49405285382921, 1e-6, 0);
    FF_CHECK_CLOSE(normal_tails(1.959963984540054), 0.05, 1e-12, 0);
    const double probability[] = {0.25, 0.25, 0.5};
    FF_CHECK_CLOSE(chi_square(3, 400, probability, (const size_t[]){100, 100, 200}), 1, 1e-12, 0);
    FF_CHECK_CLOSE(chi_square(3, 400, probability, (const size_t[]){120, 80, 200}), exp(-4), 1e-12, 0); /* chi^2 = 8, 2 degrees */
}

/* ---- scenes ---------------------------------------------------------------------------------- */

typedef struct scene {
    char what[LABEL];
    ff_model model;
    double shape[FF_MAX_SHAPE], channel[FF_MAX_CHANNEL_PARAMS];
    ff_sampler *sampler;
    double theta, phi; /* of the view, degrees */
} scene;

/* Samples of the scene at hand. */
static struct {
    double wo[3][N], u[4][N], wi[3][N], pdf[N], f[N], weight[N];
} draws;

static void scene_open(scene *s)
{
    ff_error err = {0};
    char expression[FF_MODEL_NAME];
    const ff_status status = ff_sampler_new(&s->model, FF_ISA_BEST, 1, s->shape, s->channel, &s->sampler, &err);
    ff_model_expression(&s->model, expression, sizeof expression);
    size_t used = (size_t)snprintf(s->what, sizeof s->what, "%s", expression);
    for (uint32_t k = 0; k < s->model.n_shape && used < sizeof s->what; k++)
        used += (size_t)snprintf(s->what + used, sizeof s->what - used, " %s=%.4g", s->model.shape[k].name, s->shape[k]);
    if (status) {
        printf("%s: %s\n", s->what, err.message);
        exit(1);
    }
}

static void scene_view(scene *s, double wo[3])
{
    model_direction(s->theta * FIT_DEGREE, s->phi * FIT_DEGREE, wo);
}

static void scene_draw(scene *s, uint64_t seed)
{
    double wo[3];
    scene_view(s, wo);
    for (size_t j = 0; j < 3; j++)
        for (size_t i = 0; i < N; i++) draws.wo[j][i] = wo[j];
    for (uint32_t j = 0; j < 4; j++)
        for (size_t i = 0; i < N; i++) draws.u[j][i] = ff_random_uniform(seed, j, i);
    ff_sampler_sample(s->sampler, N, draws.wo[0], draws.u[0], NULL, draws.wi[0], draws.pdf, draws.f, draws.weight, N);
}

/* ---- integrals of the density ---------------------------------------------------------------- */

/* What is wrong with a density on purpose. */
typedef enum fault { RIGHT, FACTOR, SWAPPED, OTHER_VIEW } fault;

enum { RULE = 5, POINTS = RULE * RULE };

static void density(const scene *s, fault wrong, const double wi[3][POINTS], double *pdf)
{
    double wo[3][POINTS], view[3], swapped[3][POINTS];
    scene_view((scene *)s, view);
    if (wrong == OTHER_VIEW) model_direction((s->theta + 2) * FIT_DEGREE, s->phi * FIT_DEGREE, view);
    for (int j = 0; j < 3; j++)
        for (int i = 0; i < POINTS; i++) {
            const int from = wrong == SWAPPED && j < 2 ? 1 - j : j;
            wo[j][i] = view[from];
            swapped[j][i] = wi[from][i];
        }
    ff_sampler_pdf(s->sampler, POINTS, wo[0], swapped[0], pdf, POINTS);
    for (int i = 0; i < POINTS && wrong == FACTOR; i++) pdf[i] *= 1.04;
}

/* Part of a bin: theta and phi in radians. */
typedef struct cell {
    double theta0, theta1, phi0, phi1;
} cell;

/* Gauss and Legendre. */
static double cell_rule(const scene *s, fault wrong, cell c)
{
    static const double x[RULE] = {-0.906179845938663993, -0.538469310105683091, 0, 0.538469310105683091, 0.906179845938663993};
    static const double w[RULE] = {0.236926885056189088, 0.478628670499366468, 0.568888888888888889, 0.478628670499366468,
                                   0.236926885056189088};
    const double mid_t = 0.5 * (c.theta0 + c.theta1), half_t = 0.5 * (c.theta1 - c.theta0);
    const double mid_p = 0.5 * (c.phi0 + c.phi1), half_p = 0.5 * (c.phi1 - c.phi0);
    double wi[3][POINTS], pdf[POINTS], sum = 0, cosine[RULE], sine[RULE];
    for (int j = 0; j < RULE; j++) cosine[j] = cos(mid_p + half_p * x[j]), sine[j] = sin(mid_p + half_p * x[j]);
    for (int i = 0; i < POINTS; i++) {
        const double t = mid_t + half_t * x[i / RULE], st = sin(t);
        wi[0][i] = st * cosine[i % RULE];
        wi[1][i] = st * sine[i % RULE];
        wi[2][i] = cos(t);
    }
    density(s, wrong, wi, pdf);
    for (int i = 0; i < POINTS; i++) sum += half_t * half_p * w[i / RULE] * w[i % RULE] * hypot(wi[0][i], wi[1][i]) * pdf[i];
    return sum;
}

/* Quarters until they agree with the whole. */
static double cell_integral(const scene *s, fault wrong, cell c, double whole, int depth)
{
    const double t = 0.5 * (c.theta0 + c.theta1), p = 0.5 * (c.phi0 + c.phi1);
    const cell quarter[4] = {
        {c.theta0, t, c.phi0, p}, {c.theta0, t, p, c.phi1}, {t, c.theta1, c.phi0, p}, {t, c.theta1, p, c.phi1}};
    double part[4], sum = 0;
    for (int k = 0; k < 4; k++) sum += part[k] = cell_rule(s, wrong, quarter[k]);
    if (depth == 0 || fabs(sum - whole) < 1e-7) return sum;
    sum = 0;
    for (int k = 0; k < 4; k++) sum += cell_integral(s, wrong, quarter[k], part[k], depth - 1);
    return sum;
}

/* Probability of each bin, and of being lost as the last. */
static void probabilities(const scene *s, fault wrong, double out[BINS + 1])
{
    double sum = 0;
    for (int t = 0; t < THETAS; t++)
        for (int p = 0; p < PHIS; p++) {
            const double dt = 0.5 * MODEL_PI / THETAS, dp = 2 * MODEL_PI / PHIS;
            const cell c = {t * dt, (t + 1) * dt, p * dp, (p + 1) * dp};
            sum += out[t * PHIS + p] = cell_integral(s, wrong, c, cell_rule(s, wrong, c), 8);
        }
    out[BINS] = 1 - sum;
}

static void count_bins(size_t out[BINS + 1])
{
    memset(out, 0, (BINS + 1) * sizeof *out);
    for (size_t i = 0; i < N; i++) {
        const double x = draws.wi[0][i], y = draws.wi[1][i], z = draws.wi[2][i], turn = atan2(y, x) / (2 * MODEL_PI);
        const int t = (int)(atan2(hypot(x, y), z) / (0.5 * MODEL_PI / THETAS)), p = (int)((turn < 0 ? turn + 1 : turn) * PHIS);
        out[z > FF_COS_MIN && t < THETAS ? t * PHIS + (p < PHIS ? p : 0) : BINS]++;
    }
}

/* ---- the checks of one scene ----------------------------------------------------------------- */

/* Chances of all checks, to be compared when their number is known. */
enum { MOST = 2000 };
static struct {
    int n;
    double chance[MOST];
    char what[MOST][LABEL];
} evidence;

static void settle_later(const char *check, const scene *s, double chance)
{
    if (evidence.n == MOST) {
        printf("the test itself is wrong: more than %d checks\n", MOST);
        exit(1);
    }
    evidence.chance[evidence.n] = chance;
    snprintf(evidence.what[evidence.n++], LABEL, "%s, view %g: %.380s", check, s->theta, s->what);
}

static double least_chance(int checks)
{
    return 1 - pow(1 - significance, 1.0 / checks);
}

static void check_counts(const scene *s)
{
    static double probability[BINS + 1];
    static size_t count[BINS + 1];
    probabilities(s, RIGHT, probability);
    count_bins(count);
    settle_later("chi-square", s, chi_square(BINS + 1, N, probability, count));
    const double lost = probability[BINS], spread = sqrt(fmax(N * lost * (1 - lost), 25));
    FF_CHECK(lost > -1e-6, "%s: the density integrates to %.9f", s->what, 1 - lost);
    settle_later("lost", s, normal_tails(((double)count[BINS] - N * lost) / spread));
}

static void check_weights(const scene *s)
{
    double wo[3], sum = 0, square = 0;
    ff_integral albedo;
    ff_error err = {0};
    size_t strange = 0;
    for (size_t i = 0; i < N; i++) {
        const double x = draws.weight[i], expected = draws.pdf[i] > 0 ? draws.f[i] * draws.wi[2][i] / draws.pdf[i] : 0;
        strange += !(x >= 0 && x < 1e4 && fabs(x - expected) <= 1e-12 * x);
        sum += x;
        square += x * x;
    }
    FF_CHECK(strange == 0, "%s: %zu weights are not f cos / pdf", s->what, strange);
    scene_view((scene *)s, wo);
    FF_CHECK(ff_albedo_directional(&s->model, FF_ISA_BEST, 1, s->shape, s->channel, wo, &albedo, &err) == FF_OK, "%s: %s", s->what,
             err.message);
    /* What happens to a few samples in N at most, as being lost at a narrow lobe, the variance of the others does not know of: a
     * mean that misses some such events is off by 1 / N for each. Five of them are the least spread, as of the counts. */
    const double mean = sum / N, spread = fmax(sqrt(fmax(square / N - mean * mean, 0) / N), 5.0 / N);
    const double excess = fmax(fabs(mean - albedo.value) - albedo.error - 1e-7, 0);
    settle_later("mean weight", s, excess > 0 ? normal_tails(excess / spread) : 1);
}

/* f and pdf are those of ff_model_eval and ff_sampler_pdf, and pdf > 0 where f > 0, also where samples do not go. */
static void check_support(const scene *s, uint64_t seed)
{
    enum { PAIRS = 500 };
    double f[PAIRS], pdf[PAIRS], wi[3][PAIRS];
    const ff_dirs drawn = {draws.wi[0], draws.wi[1], draws.wi[2], draws.wo[0], draws.wo[1], draws.wo[2]};
    const ff_dirs any = {wi[0], wi[1], wi[2], draws.wo[0], draws.wo[1], draws.wo[2]};
    size_t different = 0, missed = 0;
    FF_CHECK(ff_model_eval(&s->model, FF_ISA_BEST, 1, s->shape, s->channel, &drawn, PAIRS, f, NULL, PAIRS) == FF_OK, "eval");
    ff_sampler_pdf(s->sampler, PAIRS, draws.wo[0], draws.wi[0], pdf, N);
    for (size_t i = 0; i < PAIRS; i++) {
        const int lost = draws.wi[2][i] <= FF_COS_MIN;
        different += !(fabs(f[i] - draws.f[i]) <= 1e-11 * f[i]) || pdf[i] != draws.pdf[i] || (pdf[i] > 0) == lost;
    }
    FF_CHECK(different == 0, "%s: %zu samples whose f or pdf differ", s->what, different);
    for (size_t i = 0; i < PAIRS; i++) { /* a fifth of them near the horizon, the pole, the view and its mirror image */
        double d[3];
        const double z = pow(fit_uniform(&seed), 1 + (double)(i % 5)), phi = 2 * MODEL_PI * fit_uniform(&seed);
        model_direction(acos(z), phi, d);
        for (size_t j = 0; j < 3; j++) wi[j][i] = d[j];
    }
    for (size_t j = 0; j < 3; j++)
        wi[j][0] = draws.wo[j][0], wi[j][1] = j == 2, wi[j][2] = j < 2 ? -draws.wo[j][0] : draws.wo[j][0];
    double around[3][PAIRS];
    for (size_t j = 0; j < 3; j++) memcpy(around[j], draws.wo[j], sizeof around[j]);
    FF_CHECK(ff_model_eval(&s->model, FF_ISA_BEST, 1, s->shape, s->channel, &any, PAIRS, f, NULL, PAIRS) == FF_OK, "eval");
    ff_sampler_pdf(s->sampler, PAIRS, around[0], wi[0], pdf, PAIRS);
    for (size_t i = 0; i < PAIRS; i++) missed += f[i] > 0 && !(pdf[i] > 0);
    FF_CHECK(missed == 0, "%s: %zu directions with f > 0 are never drawn", s->what, missed);
}

/* From a scene whose model and parameters are set: everything, at several views. */
static void check_scene(scene *s)
{
    static const double thetas[] = {0, 40, 80};
    scene_open(s);
    for (size_t v = 0; v < sizeof thetas / sizeof thetas[0]; v++) {
        s->theta = thetas[v];
        s->phi = 40;
        const uint64_t seed = ff_test_stream("scene %s, view %g", s->what, s->theta);
        scene_draw(s, seed);
        check_counts(s);
        check_weights(s);
        check_support(s, seed + 1);
    }
    ff_sampler_free(s->sampler);
}

/* ---- what is checked ------------------------------------------------------------------------- */

/* Parameters as they start, but each by this fraction of the way to the end of its box, in the coordinate that it is fitted in. */
static void move_parameters(scene *s, double fraction)
{
    ff_model_defaults(&s->model, 1, s->shape, s->channel);
    for (uint32_t k = 0; k < s->model.n_shape; k++) {
        const ff_param *p = s->model.shape[k].info;
        const double init = ff_coordinate(p, s->shape[k]), end = ff_coordinate(p, fraction < 0 ? p->lo : p->hi);
        if (!(p->flags & FF_PARAM_HELD) && strcmp(p->name, "r_xy"))
            s->shape[k] = ff_coordinate_value(p, init + fabs(fraction) * (end - init));
    }
}

static void set(scene *s, const char *assignment)
{
    ff_error err = {0};
    FF_CHECK(ff_model_set(&s->model, 1, assignment, s->shape, s->channel, &err) == FF_OK, "%s", err.message);
}

static void every_distribution(void)
{
    static const double fractions[] = {-0.3, 0, 0.3};
    static scene s;
    for (size_t d = 0; d < ff_term_count(FF_NDF); d++) {
        if (!model_lobe(d, "smith-height-correlated", "none", &s.model) && !model_lobe(d, "kelemen", "none", &s.model)) {
            FF_CHECK(0, "%s goes with neither masking", ff_term_at(FF_NDF, d)->name);
            continue;
        }
        for (size_t k = 0; k < sizeof fractions / sizeof fractions[0]; k++) {
            move_parameters(&s, fractions[k]);
            check_scene(&s);
        }
        if (ff_model_param_find(&s.model, "r_xy").kind == FF_PARAM_NONE) continue;
        ff_model_defaults(&s.model, 1, s.shape, s.channel);
        set(&s, "alpha_x=0.15"), set(&s, "alpha_y=0.6"), set(&s, "r_xy=0.7");
        check_scene(&s);
        set(&s, "slope_x=0.15"), set(&s, "slope_y=-0.1"), set(&s, "r_xy=-0.4");
        check_scene(&s);
    }
}

/* The value of its linear parameter with which a term that nothing bounds reflects 0.9 of what comes along the normal: the end of
 * its box is a reflectance of thousands. */
static double bright_as_a_wall(size_t diffuse)
{
    const double normal[3] = {0, 0, 1};
    ff_model m = model_parse(ff_term_at(FF_DIFFUSE, diffuse)->name);
    double shape[FF_MAX_SHAPE], channel[FF_MAX_CHANNEL_PARAMS];
    ff_integral all;
    ff_model_defaults(&m, 1, shape, channel);
    channel[0] = 1;
    FF_CHECK(m.n_channel == 1 && ff_albedo_directional(&m, FF_ISA_BEST, 1, shape, channel, normal, &all, NULL) == FF_OK, "albedo");
    return 0.9 / all.value;
}

static void every_diffuse_term(void)
{
    static scene s;
    ff_error err = {0};
    const int ggx = ff_term_find(FF_NDF, "ggx"), smith = ff_term_find(FF_MASKING, "smith-height-correlated"),
              schlick = ff_term_find(FF_FRESNEL, "schlick");
    for (size_t b = 0; b < ff_term_count(FF_DIFFUSE); b++) {
        FF_CHECK(ff_model_compose(ggx, smith, schlick, (int)b, &s.model, &err) == FF_OK, "%s", err.message);
        ff_model_defaults(&s.model, 1, s.shape, s.channel);
        set(&s, "f0=0.05");
        for (uint32_t k = 0; k < s.model.n_channel; k++) /* bright, so that most samples are its own */
            if (s.model.channel[k].lobe >= s.model.n_lobes) s.channel[k] = 0.9 * s.model.channel[k].info->hi;
        const ff_term *term = ff_term_at(FF_DIFFUSE, b);
        for (uint32_t k = 0; k < s.model.n_channel && term->n_params && !(term->claims & FF_PASSIVE); k++)
            if (strcmp(s.model.channel[k].info->name, term->params[0].name) == 0 && term->params[0].hi > 1)
                s.channel[k] = bright_as_a_wall(b);
        check_scene(&s);
    }
}

static void several_lobes(void)
{
    static scene s;
    s.model = model_parse("ggx+beckmann/v-cavity/shared+phong/smith-separable+lambert+kulla-conty");
    ff_model_defaults(&s.model, 1, s.shape, s.channel);
    set(&s, "alpha=0.2"), set(&s, "lobe2.alpha=0.7"), set(&s, "lobe2.weight=0.3"), set(&s, "lobe3.n=200"), set(&s, "f0=0.2");
    check_scene(&s);
    s.model = model_parse("vmf/v-cavity/schlick+mikkelsen-coupled");
    ff_model_defaults(&s.model, 1, s.shape, s.channel);
    check_scene(&s);
    s.model = model_parse("lambert");
    ff_model_defaults(&s.model, 1, s.shape, s.channel);
    check_scene(&s);
    s.model = model_parse("harvey-shack");
    ff_model_defaults(&s.model, 1, s.shape, s.channel);
    set(&s, "hs_l=0.004"), set(&s, "hs_s=-3.5"), set(&s, "hs_b0=5000");
    check_scene(&s);
}

/* Sidak's correction: each of m independent checks may fail by chance with 1 - (1 - significance)^(1/m). */
static void samples_follow_their_densities(void)
{
    evidence.n = 0;
    every_distribution();
    every_diffuse_term();
    several_lobes();
    const double least = least_chance(evidence.n);
    int worst = 0;
    for (int i = 0; i < evidence.n; i++) {
        FF_CHECK(evidence.chance[i] >= least, "%s: a chance of %.3g, allowed is %.3g", evidence.what[i], evidence.chance[i], least);
        if (evidence.chance[i] < evidence.chance[worst]) worst = i;
    }
    FF_CHECK(evidence.n > 300, "only %d checks", evidence.n);
    printf("  %d checks, least chance %.3g (allowed %.3g): %s\n", evidence.n, evidence.chance[worst], least, evidence.what[worst]);
}

/* ---- the checks can fail --------------------------------------------------------------------- */

static void wrong_densities_are_caught(void)
{
    static const fault faults[] = {FACTOR, SWAPPED, OTHER_VIEW};
    static const char *const models[] = {"ggx", "beckmann", "student-t", "ggx+lambert"};
    static double probability[BINS + 1];
    static size_t count[BINS + 1];
    static scene s;
    for (size_t m = 0; m < sizeof models / sizeof models[0]; m++) {
        s.model = model_parse(models[m]);
        ff_model_defaults(&s.model, 1, s.shape, s.channel);
        set(&s, "alpha_x=0.2"), set(&s, "alpha_y=0.4"), set(&s, "r_xy=0.5"), set(&s, "f0=0.3");
        scene_open(&s);
        s.theta = 40, s.phi = 20;
        scene_draw(&s, ff_test_stream("wrong densities %s", s.what));
        count_bins(count);
        probabilities(&s, RIGHT, probability);
        FF_CHECK(chi_square(BINS + 1, N, probability, count) > least_chance(MOST), "%s", s.what);
        for (size_t k = 0; k < sizeof faults / sizeof faults[0]; k++) {
            probabilities(&s, faults[k], probability);
            const double chance = chi_square(BINS + 1, N, probability, count);
            FF_CHECK(chance < least_chance(MOST), "fault %d in the density of %s has a chance of %g", faults[k], s.what, chance);
        }
        ff_sampler_free(s.sampler);
    }
}

/* ---- accuracy of the radial inversion -------------------------------------------------------- */

/* Probability between two angles, seen along the normal; Gauss and Legendre. */
static double ring_between(const scene *s, double theta0, double theta1)
{
    enum { GAUSS = 8 };
    static const double x[GAUSS / 2] = {0.183434642495649805, 0.525532409916328986, 0.796666477413626740, 0.960289856497536232};
    static const double w[GAUSS / 2] = {0.362683783378361983, 0.313706645877887287, 0.222381034453374471, 0.101228536290376259};
    const double mid = 0.5 * (theta0 + theta1), half = 0.5 * (theta1 - theta0);
    double up[3][GAUSS] = {{0}}, at[3][GAUSS] = {{0}}, pdf[GAUSS], sum = 0;
    for (int k = 0; k < GAUSS; k++) {
        const double t = mid + half * (k % 2 ? x[k / 2] : -x[k / 2]);
        up[2][k] = 1;
        at[0][k] = sin(t), at[2][k] = cos(t);
    }
    ff_sampler_pdf(s->sampler, GAUSS, up[0], at[0], pdf, GAUSS);
    for (int k = 0; k < GAUSS; k++) sum += 2 * MODEL_PI * half * w[k / 2] * at[0][k] * pdf[k];
    return sum;
}

/* Seen along the normal a lobe is drawn by rings: u[1] is the probability inside theta_i. That is the integral of the density; 0
 * where the distribution is not drawn by rings. */
static double worst_ring(const scene *s)
{
    enum { RINGS = 1000 };
    static double wo[3][RINGS], u[3][RINGS], wi[3][RINGS], pdf[RINGS], weight[RINGS];
    double inside = 0, before = 0, worst = 0;
    for (int turn = 0; turn < 2; turn++) {
        const double last = wi[2][RINGS / 2];
        for (int i = 0; i < RINGS; i++) {
            wo[2][i] = 1;
            u[1][i] = (double)i / RINGS;
            u[2][i] = turn ? 0.1 : 0.2;
        }
        ff_sampler_sample(s->sampler, RINGS, wo[0], u[0], NULL, wi[0], pdf, NULL, weight, RINGS);
        if (turn && fabs(wi[2][RINGS / 2] - last) > 1e-9) return 0;
    }
    for (int i = 1; i < RINGS && wi[2][i] > 0.01; i++) {
        const double theta = atan2(hypot(wi[0][i], wi[1][i]), wi[2][i]);
        if (i == 1) before = ldexp(theta, -20); /* a peak may be sharper than the first ring is wide */
        for (int halved = i == 1 ? 20 : 1; halved-- > 0;) {
            inside += ring_between(s, before, ldexp(theta, -halved));
            before = ldexp(theta, -halved);
        }
        worst = fmax(worst, fabs(inside - u[1][i]));
    }
    return worst;
}

static void rings_hold_their_probability(void)
{
    static scene s;
    double worst = 0;
    int by_rings = 0;
    for (size_t d = 0; d < ff_term_count(FF_NDF); d++)
        for (int k = -4; k <= 4; k++) {
            if (!model_lobe(d, "smith-height-correlated", "none", &s.model) && !model_lobe(d, "kelemen", "none", &s.model))
                continue;
            move_parameters(&s, 0.2 * k);
            scene_open(&s);
            const double error = worst_ring(&s);
            FF_CHECK(error < 1e-9, "%s: off by %g in probability", s.what, error);
            worst = fmax(worst, error);
            by_rings += error > 0;
            ff_sampler_free(s.sampler);
        }
    FF_CHECK(by_rings > 40, "only %d were drawn by rings", by_rings);
    printf("  %d distributions by rings, off by at most %.2g in probability\n", by_rings, worst);
}

/* What the lobes leave over: away from the mirror direction, where a narrow lobe sends nothing, the density is that of (1 - a(mu))
 * mu up to the share. */
static void matte_follows_the_albedo(void)
{
    static const double mus[] = {0.02, 0.07, 0.15, 0.3, 0.5, 0.75, 0.97};
    static const char *const models[] = {"beckmann+kelemen-matte", "beckmann/v-cavity+mikkelsen-coupled", "beckmann+kulla-conty"};
    for (size_t m = 0; m < sizeof models / sizeof models[0]; m++) {
        static scene s;
        ff_model lobe = model_parse(m == 1 ? "beckmann/v-cavity" : m == 2 ? "beckmann/smith-height-correlated/none" : "beckmann");
        double wo[3], lobe_shape[FF_MAX_SHAPE], lobe_channel[FF_MAX_CHANNEL_PARAMS], first = 0, most = 0;
        s.model = model_parse(models[m]);
        ff_model_defaults(&s.model, 1, s.shape, s.channel);
        ff_model_defaults(&lobe, 1, lobe_shape, lobe_channel);
        set(&s, "alpha=0.1");
        FF_CHECK(ff_model_set(&lobe, 1, "alpha=0.1", lobe_shape, lobe_channel, NULL) == FF_OK, "alpha");
        scene_open(&s);
        model_direction(35 * FIT_DEGREE, 0, wo);
        for (size_t k = 0; k < sizeof mus / sizeof mus[0]; k++) {
            double wi[3], pdf;
            ff_integral a;
            model_direction(acos(mus[k]), 0, wi); /* on the side of the view */
            FF_CHECK(ff_albedo_directional(&lobe, FF_ISA_BEST, 1, lobe_shape, lobe_channel, wi, &a, NULL) == FF_OK, "albedo");
            ff_sampler_pdf(s.sampler, 1, wo, wi, &pdf, 1);
            const double ratio = pdf / ((1 - a.value) * mus[k]);
            if (k == 0) first = ratio, most = 1 - a.value;
            if (1 - a.value < 0.05 * most) break; /* the table does not go below a hundredth of its maximum */
            FF_CHECK_CLOSE(ratio, first, 5e-3, 0);
        }
        ff_sampler_free(s.sampler);
    }
}

/* ---- the interface --------------------------------------------------------------------------- */

/* A path goes on with the albedo's probability, and the mean weight stays. */
static void roulette_keeps_the_mean(void)
{
    static scene s;
    static double weight[N];
    s.model = model_parse("ggx+lambert");
    ff_model_defaults(&s.model, 1, s.shape, s.channel);
    set(&s, "f0=0.04"), set(&s, "kd=0.2");
    scene_open(&s);
    s.theta = 50;
    scene_draw(&s, ff_test_stream("roulette"));
    memcpy(weight, draws.weight, sizeof weight);
    ff_sampler_sample(s.sampler, N, draws.wo[0], draws.u[0], draws.u[3], draws.wi[0], draws.pdf, draws.f, draws.weight, N);
    double q = 0, plain = 0, mean = 0, square = 0, alive = 0;
    for (size_t i = 0; i < N; i++) {
        if (draws.weight[i] > 0) q = weight[i] / draws.weight[i];
        plain += weight[i] / N;
        mean += draws.weight[i] / N;
        square += draws.weight[i] * draws.weight[i] / N;
    }
    for (size_t i = 0; i < N; i++) {
        FF_CHECK((draws.weight[i] > 0) == (weight[i] > 0 && draws.u[3][i] < q), "sample %zu at q = %g", i, q);
        if (draws.weight[i] > 0) FF_CHECK_CLOSE(weight[i] / draws.weight[i], q, 1e-12, 0);
        alive += draws.u[3][i] < q;
    }
    FF_CHECK_CLOSE(q, plain, 0.05, 0);
    FF_CHECK(fabs(mean - plain) < 4 * sqrt((square - mean * mean) / N), "means %g and %g", mean, plain);
    FF_CHECK(alive > 0 && alive < N, "%g samples go on", alive);
    ff_sampler_free(s.sampler);
}

/* The same bits one at a time as in blocks, for views that change from sample to sample, and for several channels. */
static void one_at_a_time(void)
{
    enum { COUNT = 300, LD = 310, CHANNELS = 3 };
    static double wo[3][LD], u[3][LD], wi[3][LD], pdf[LD], f[CHANNELS][LD], weight[CHANNELS][LD];
    fit_surface surface =
        fit_surface_make("ggx+beckmann+lambert", CHANNELS, "f0=0.9:0.5:0.1 kd=0.1:0.2:0.3 alpha=0.2 lobe2.alpha=0.6");
    ff_sampler *s = NULL;
    uint64_t state = ff_test_stream("one at a time");
    FF_CHECK(ff_sampler_new(&surface.model, FF_ISA_BEST, CHANNELS, surface.shape, surface.channel, &s, NULL) == FF_OK, "new");
    for (size_t i = 0; i < COUNT; i++) {
        double o[3];
        model_random_direction(&state, o);
        for (size_t j = 0; j < 3; j++) wo[j][i] = o[j], u[j][i] = fit_uniform(&state);
    }
    ff_sampler_sample(s, COUNT, wo[0], u[0], NULL, wi[0], pdf, f[0], weight[0], LD);
    for (size_t i = 0; i < COUNT; i++) {
        double one_wi[3], one_pdf, one_weight[CHANNELS], density;
        const double o[3] = {wo[0][i], wo[1][i], wo[2][i]}, one_u[3] = {u[0][i], u[1][i], u[2][i]};
        ff_sampler_sample(s, 1, o, one_u, NULL, one_wi, &one_pdf, NULL, one_weight, 1);
        ff_sampler_pdf(s, 1, o, one_wi, &density, 1);
        for (size_t j = 0; j < 3; j++) FF_CHECK(one_wi[j] == wi[j][i], "sample %zu: wi differs", i);
        for (size_t c = 0; c < CHANNELS; c++) FF_CHECK(one_weight[c] == weight[c][i], "sample %zu: weight differs", i);
        FF_CHECK(one_pdf == pdf[i] && density == pdf[i], "sample %zu: densities %g, %g and %g", i, one_pdf, pdf[i], density);
    }
    ff_sampler_free(s);
}

static void instruction_sets_agree(void)
{
    enum { COUNT = 1000 };
    static double wi[2][3][COUNT], pdf[2][COUNT], weight[2][COUNT];
    static const ff_isa isas[] = {FF_ISA_SCALAR, FF_ISA_AVX2, FF_ISA_AVX512};
    static scene s;
    s.model = model_parse("gaussian+beckmann+kelemen-matte");
    ff_model_defaults(&s.model, 1, s.shape, s.channel);
    s.theta = 50;
    scene_open(&s);
    scene_draw(&s, ff_test_stream("instruction sets"));
    for (size_t k = 0; k < sizeof isas / sizeof isas[0]; k++) {
        ff_sampler *other = NULL;
        const size_t at = k > 0;
        if (!ff_isa_available(isas[k])) continue;
        FF_CHECK(ff_sampler_new(&s.model, isas[k], 1, s.shape, s.channel, &other, NULL) == FF_OK, "%s", ff_isa_name(isas[k]));
        double wo[3][COUNT], u[3][COUNT];
        for (size_t j = 0; j < 3; j++) memcpy(wo[j], draws.wo[j], sizeof wo[j]), memcpy(u[j], draws.u[j], sizeof u[j]);
        ff_sampler_sample(other, COUNT, wo[0], u[0], NULL, wi[at][0], pdf[at], NULL, weight[at], COUNT);
        ff_sampler_free(other);
        for (size_t i = 0; at && i < COUNT; i++) {
            FF_CHECK_CLOSE(pdf[1][i], pdf[0][i], 1e-9, 0);
            FF_CHECK_CLOSE(weight[1][i], weight[0][i], 1e-9, 0);
        }
    }
    ff_sampler_free(s.sampler);
    FF_CHECK(pdf[0][0] + pdf[0][1] + pdf[0][2] > 0, "nothing was drawn");
}

/* Ends of the uniform numbers, views at and below the horizon, a mean surface seen from below: finite, and lost where they must be.
 */
static void ends(void)
{
    static const double ends_of_u[] = {0, 1e-300, 1e-17, 0.5, 1 - 0x1p-53, 1};
    static const double thetas[] = {0, 30, 89.9999, 90, 120};
    static const char *const models[] = {"ggx", "beckmann", "student-t", "phong",
                                         "vmf", "gaussian", "lambert",   "ggx+kelemen-matte"};
    for (size_t m = 0; m < sizeof models / sizeof models[0]; m++) {
        static scene s;
        s.model = model_parse(models[m]);
        ff_model_defaults(&s.model, 1, s.shape, s.channel);
        if (m < 3) set(&s, "slope_x=1");
        scene_open(&s);
        for (size_t t = 0; t < sizeof thetas / sizeof thetas[0]; t++)
            for (int k = 0; k < 6 * 6 * 6; k++) {
                const double u[3] = {ends_of_u[k % 6], ends_of_u[k / 6 % 6], ends_of_u[k / 36]};
                double wo[3], wi[3], pdf, f, weight;
                model_direction(thetas[t] * FIT_DEGREE, 0, wo);
                ff_sampler_sample(s.sampler, 1, wo, u, NULL, wi, &pdf, &f, &weight, 1);
                FF_CHECK(pdf >= 0 && pdf < 1e300 && f >= 0 && weight >= 0 && weight < 1e6, "%s, view %g, u %g %g %g: %g %g %g",
                         s.what, thetas[t], u[0], u[1], u[2], pdf, f, weight);
                FF_CHECK_CLOSE(wi[0] * wi[0] + wi[1] * wi[1] + wi[2] * wi[2], 1, 1e-12, 0);
                if (thetas[t] >= 90 || (m < 3 && thetas[t] > 45)) FF_CHECK(pdf == 0 && weight == 0 && wi[2] == -1, "%s", s.what);
            }
        ff_sampler_free(s.sampler);
    }
}

static void refusals(void)
{
    fit_surface surface = fit_surface_make("ggx+lambert", 1, "");
    ff_sampler *s = NULL;
    ff_error err = {0};
    surface.shape[0] = NAN;
    FF_CHECK(ff_sampler_new(&surface.model, FF_ISA_BEST, 1, surface.shape, surface.channel, &s, &err) == FF_ERR_RANGE, "NaN");
    FF_CHECK(strstr(err.message, "alpha_x") != NULL, "%s", err.message);
    surface.shape[0] = 0.3;
    for (int isa = 0; isa < 8; isa++)
        if (!ff_isa_available((ff_isa)isa))
            FF_CHECK(ff_sampler_new(&surface.model, (ff_isa)isa, 1, surface.shape, surface.channel, &s, &err) == FF_ERR_UNSUPPORTED,
                     "isa %d", isa);
    FF_CHECK(s == NULL, "a refusal wrote its output");
    ff_sampler_free(NULL);
}

FF_TEST_MAIN(FF_TEST(chances_are_right), FF_TEST(samples_follow_their_densities), FF_TEST(wrong_densities_are_caught),
             FF_TEST(rings_hold_their_probability), FF_TEST(matte_follows_the_albedo), FF_TEST(roulette_keeps_the_mean),
             FF_TEST(one_at_a_time), FF_TEST(instruction_sets_agree), FF_TEST(ends), FF_TEST(refusals))
