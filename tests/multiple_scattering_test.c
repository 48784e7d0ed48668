/* The term multiple-scattering: at F = 1 it leaves nothing of the light, it is reciprocal and nowhere negative, it is nearer to
 * walks on Smith's surface than Kulla and Conty's, in shape and where facets absorb, and it is refused where it was not made for.
 */
#include "model_samples.h"
#include "ff_albedo.h"
#include "ff_walk.h"

#define SMITH "/smith-height-correlated"
static const char *const ndfs[] = {"beckmann", "ggx"};

typedef struct scene {
    ff_model model;
    double shape[FF_MAX_SHAPE], channel[FF_MAX_CHANNEL_PARAMS];
} scene;

static scene scene_make(const char *ndf, const char *rest, const char *set)
{
    scene s;
    ff_error err = {0};
    char words[200];
    snprintf(words, sizeof words, "%s%s", ndf, rest);
    FF_CHECK(ff_model_parse(words, &s.model, &err) == FF_OK, "%s", err.message);
    ff_model_defaults(&s.model, 1, s.shape, s.channel);
    snprintf(words, sizeof words, "%s", set);
    for (char *word = strtok(words, " "); word; word = strtok(NULL, " "))
        FF_CHECK(ff_model_set(&s.model, 1, word, s.shape, s.channel, &err) == FF_OK, "%s", err.message);
    return s;
}

static double albedo(const scene *s, double mu)
{
    ff_integral a;
    ff_error err = {0};
    const double wo[3] = {sqrt(1 - mu * mu), 0, mu};
    FF_CHECK(ff_albedo_directional(&s->model, FF_ISA_BEST, 1, s->shape, s->channel, wo, &a, &err) == FF_OK, "%s", err.message);
    return a.value;
}

/* Between the nodes of the table, at them, and beyond. */
static void nothing_is_lost(void)
{
    static const double alphas[] = {0.02, 0.1, 0.14, 0.25, 0.33, 0.5, 0.57, 0.78, 1, 1.1, 1.7, 2.4, 4},
                        mus[] = {1, 0.7, 0.4, 0.2, 0.05};
    double most = 0;
    for (int k = 0; k < 2; k++)
        for (size_t a = 0; a < sizeof alphas / sizeof alphas[0]; a++) {
            char set[32];
            snprintf(set, sizeof set, "alpha=%g", alphas[a]);
            const scene s = scene_make(ndfs[k], SMITH "/none+multiple-scattering", set),
                        bare = scene_make(ndfs[k], SMITH "/none", set);
            for (size_t m = 0; m < sizeof mus / sizeof mus[0]; m++) {
                FF_CHECK(fabs(albedo(&s, mus[m]) - 1) < 1e-3, "%s, alpha %g, mu %g: %.6f", ndfs[k], alphas[a], mus[m],
                         albedo(&s, mus[m]));
                most = fmax(most, 1 - albedo(&bare, mus[m]));
            }
        }
    FF_CHECK(most > 0.5, "without the term %g is lost at most", most);
}

static void both_ways_and_not_negative(void)
{
    for (int k = 0; k < 2; k++)
        for (double alpha = 0.1; alpha < 4; alpha *= 1.23)
            for (int f0 = 0; f0 < 3; f0++) {
                enum { PAIRS = 400 };
                double f[PAIRS], back[PAIRS], d[2][3], lobe[PAIRS];
                char set[64];
                uint64_t state = ff_test_stream("pairs");
                model_pairs p = {0}, q = {0};
                snprintf(set, sizeof set, "alpha=%g f0=%g", alpha, 0.1 + 0.4 * f0);
                const scene s = scene_make(ndfs[k], "+multiple-scattering", set), bare = scene_make(ndfs[k], "", set);
                while (p.n < PAIRS) {
                    model_random_direction(&state, d[0]);
                    model_random_direction(&state, d[1]);
                    model_pairs_add(&p, d[0], d[1]);
                    model_pairs_add(&q, d[1], d[0]);
                }
                const ff_dirs w = model_dirs(&p), v = model_dirs(&q);
                FF_CHECK(!ff_model_eval(&s.model, FF_ISA_BEST, 1, s.shape, s.channel, &w, PAIRS, f, NULL, PAIRS), "eval");
                FF_CHECK(!ff_model_eval(&s.model, FF_ISA_BEST, 1, s.shape, s.channel, &v, PAIRS, back, NULL, PAIRS), "eval");
                FF_CHECK(!ff_model_eval(&bare.model, FF_ISA_BEST, 1, bare.shape, bare.channel, &w, PAIRS, lobe, NULL, PAIRS),
                         "eval");
                for (int i = 0; i < PAIRS; i++) {
                    FF_CHECK_CLOSE(f[i], back[i], 1e-11, 1e-14);
                    FF_CHECK(f[i] - lobe[i] > -1e-12 * lobe[i], "%s %s: %g", ndfs[k], set, f[i] - lobe[i]);
                }
            }
}

/* Mean square of the difference between a term and the walk's orders from 2 on, times both cosines; the walk's own noise taken out.
 */
static double residual(const scene *with, const scene *bare, const ff_dirs *w, size_t n, const double *walk, const double *error)
{
    double f[MODEL_PAIRS], lobe[MODEL_PAIRS], sum = 0;
    FF_CHECK(!ff_model_eval(&with->model, FF_ISA_BEST, 1, with->shape, with->channel, w, n, f, NULL, n), "eval");
    FF_CHECK(!ff_model_eval(&bare->model, FF_ISA_BEST, 1, bare->shape, bare->channel, w, n, lobe, NULL, n), "eval");
    for (size_t i = 0; i < n; i++) {
        const double c = w->wiz[i] * w->woz[i];
        sum += (pow((f[i] - lobe[i] - walk[i]) * c, 2) - pow(error[i] * c, 2)) / (double)n;
    }
    return sum;
}

/* Root mean squares: of the term, and of Kulla and Conty's. */
static void compare_with_walk(const char *ndf, const char *set, double *term, double *kulla_conty)
{
    const scene bare = scene_make(ndf, "", set), ms = scene_make(ndf, "+multiple-scattering", set),
                kc = scene_make(ndf, "+kulla-conty", set);
    static double walk[MODEL_PAIRS], error[MODEL_PAIRS];
    model_pairs p = {0};
    ff_walk_options o;
    ff_walk *made;
    ff_error err = {0};
    double d[2][3];
    uint64_t state = ff_test_stream("compared pairs");
    while (p.n < MODEL_PAIRS) {
        model_random_direction(&state, d[0]);
        model_random_direction(&state, d[1]);
        model_pairs_add(&p, d[0], d[1]);
    }
    const ff_dirs w = model_dirs(&p);
    ff_walk_options_init(&o);
    o.orders[0].first = 2;
    o.paths = 3000;
    o.seed = ff_test_stream("walk of %s %s", ndf, set);
    if (!FF_CHECK(!ff_walk_new(&bare.model, 1, bare.shape, bare.channel, &o, &made, &err), "%s", err.message)) exit(1);
    FF_CHECK(!ff_walk_values(made, &w, p.n, 0, walk, error, p.n, &err), "%s", err.message);
    ff_walk_free(made);
    *term = sqrt(fmax(residual(&ms, &bare, &w, p.n, walk, error), 0));
    *kulla_conty = sqrt(fmax(residual(&kc, &bare, &w, p.n, walk, error), 0));
    printf("%s %s: rms against the walk %.2e, of kulla-conty %.2e\n", ndf, set, *term, *kulla_conty);
}

static void nearer_than_kulla_conty(void)
{
    static const double alphas[] = {0.5, 0.75, 1, 1.4, 2}, f0s[] = {1, 0.5};
    for (int k = 0; k < 2; k++)
        for (size_t a = 0; a < 5; a++)
            for (int f = 0; f < 2; f++) {
                char set[64];
                double term, kc;
                snprintf(set, sizeof set, "alpha=%g f0=%g", alphas[a], f0s[f]);
                compare_with_walk(ndfs[k], set, &term, &kc);
                /* where facets absorb both take the average of F for all facets, which is not what steep ones see */
                FF_CHECK(term < (f ? 2. / 3 : 0.5) * kc, "%s %s: %g, of kulla-conty %g", ndfs[k], set, term, kc);
            }
}

static void refusals(void)
{
    static const char *const bad[] = {"student-t+multiple-scattering", "ggx/v-cavity+multiple-scattering",
                                      "ggx+beckmann+multiple-scattering", "vmf+multiple-scattering", "multiple-scattering"};
    for (size_t k = 0; k < sizeof bad / sizeof bad[0]; k++) {
        ff_model m;
        ff_error err = {0};
        FF_CHECK(ff_model_parse(bad[k], &m, &err) == FF_ERR_UNSUPPORTED && strstr(err.message, "multiple-scattering"), "%s: %s",
                 bad[k], err.message);
    }
}

FF_TEST_MAIN(FF_TEST(nothing_is_lost), FF_TEST(both_ways_and_not_negative), FF_TEST(nearer_than_kulla_conty), FF_TEST(refusals))
