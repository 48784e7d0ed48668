/* Where the brightest samples lie, and how much data reflect at least: of surfaces turned and scaled as files have them. */
#include "fit_samples.h"
#include "warnings.h"
#include "ff_brightest.h"

enum { INCIDENCES = 5, POLAR = 16, AZIMUTHS = 12 };

/* A goniometer: phi_o from 0 to 330 degrees plus `turn`, phi_i = 0. */
static ff_table scanned(const char *expression, const char *set, double turn, double scale)
{
    static const double theta_i[INCIDENCES] = {10, 25, 40, 55, 70};
    const fit_surface s = fit_surface_make(expression, 2, set);
    ff_table t;
    if (ff_table_init(INCIDENCES * POLAR * AZIMUTHS, 2, NULL, 0, 0, &t, NULL)) exit(1);
    t.radians_per_unit = 1;
    for (size_t i = 0; i < t.n; i++) {
        t.angle[0][i] = theta_i[i / (POLAR * AZIMUTHS)] * FIT_DEGREE;
        t.angle[2][i] = (2.5 + 5 * (double)(i / AZIMUTHS % POLAR)) * FIT_DEGREE;
        t.angle[3][i] = (double)(i % AZIMUTHS) * 30 * FIT_DEGREE;
    }
    fit_evaluate(&s, &t);
    for (size_t k = 0; k < t.n * 2; k++) t.value[k] *= scale;
    for (size_t i = 0; i < t.n; i++) t.angle[3][i] += turn * FIT_DEGREE;
    return t;
}

static ff_brightest look(const ff_table *t)
{
    ff_brightest b = {0};
    FF_CHECK(ff_brightest_find(t, 80 * FIT_DEGREE, &b) == FF_OK, "no memory");
    return b;
}

static void sides(void)
{
    static const struct {
        const char *expression, *set;
        double turn;
        ff_side most, odd;
    } trials[] = {{"ggx+lambert", "alpha=0.25 f0=0.3 kd=0.2", 0, FF_SIDE_MIRROR, FF_SIDE_NONE},
                  {"ggx+lambert", "alpha=0.25 f0=0.3 kd=0.2", 180, FF_SIDE_LIGHT, FF_SIDE_LIGHT},
                  {"ggx+lambert", "alpha=0.25 f0=0.3 kd=0.2", 90, FF_SIDE_ACROSS, FF_SIDE_ACROSS},
                  {"beckmann", "alpha=0.1 f0=0.8", 180, FF_SIDE_LIGHT, FF_SIDE_LIGHT},
                  {"lambert", "kd=0.5", 0, FF_SIDE_NONE, FF_SIDE_NONE}};
    for (size_t k = 0; k < sizeof trials / sizeof *trials; k++) {
        ff_table t = scanned(trials[k].expression, trials[k].set, trials[k].turn, 1);
        const ff_brightest b = look(&t);
        FF_CHECK(ff_brightest_odd(&b) == trials[k].odd, "%s turned by %g: %d", trials[k].expression, trials[k].turn,
                 (int)ff_brightest_odd(&b));
        if (trials[k].most != FF_SIDE_NONE)
            FF_CHECK(b.count[trials[k].most] >= 3, "%s turned by %g: %zu", trials[k].expression, trials[k].turn,
                     b.count[trials[k].most]);
        ff_table_clear(&t);
    }
}

/* A lower bound of the albedo, near it where the surface is matt. */
static void reflects(void)
{
    static const struct {
        const char *expression, *set;
        double scale, lo, hi;
    } trials[] = {{"lambert", "kd=0.5:0.4", 1, 0.49, 0.5001},
                  {"lambert", "kd=0.5:0.4", 3.14159265, 1.5, 1.5709},
                  {"ggx+lambert", "alpha=0.25 f0=0.3 kd=0.2", 1, 0.2, 0.7},
                  {"ggx", "alpha=0.1 f0=1", 1, 0, 1},
                  {"ggx", "alpha=0.03 f0=1", 1, 0, 1},
                  {"ggx+lambert", "alpha=0.25 f0=0.3 kd=0.2", 1e4, 2000, 7000}};
    for (size_t k = 0; k < sizeof trials / sizeof *trials; k++) {
        ff_table t = scanned(trials[k].expression, trials[k].set, 0, trials[k].scale);
        const ff_brightest b = look(&t);
        FF_CHECK(b.reflects >= trials[k].lo && b.reflects <= trials[k].hi, "%s %s: %g", trials[k].expression, trials[k].set,
                 b.reflects);
        ff_table_clear(&t);
    }
}

/* The warning of a fit: not of data as they should be. */
static void warned(void)
{
    for (int turned = 0; turned < 2; turned++) {
        ff_table t = scanned("ggx+lambert", "alpha=0.25 f0=0.3 kd=0.2", turned ? 180 : 0, 1);
        ff_model m;
        ff_fit_result r;
        ff_error err = {0};
        const ff_fit_options o = fit_options();
        FF_CHECK(!ff_model_parse("ggx+lambert", &m, &err) && !fit_table(&t, &m, &o, &r, NULL, &err), "%s", err.message);
        const ff_warning *w = find_warning(&r, FF_WARNING_BRIGHTEST_ELSEWHERE, NULL),
                         *on = find_warning(&r, FF_WARNING_AT_BOUND, NULL);
        FF_CHECK((w != NULL) == turned && (!w || (w->value[0] >= 4 && (int)w->value[1] == FF_SIDE_LIGHT)), "turned %d", turned);
        FF_CHECK(!on || on->value[3] < 1, "the data reflect %g", on ? on->value[3] : 0);
        ff_fit_result_clear(&r);
        ff_table_clear(&t);
    }
}

FF_TEST_MAIN(FF_TEST(sides), FF_TEST(reflects), FF_TEST(warned))
