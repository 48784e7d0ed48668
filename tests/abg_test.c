/* Scatter of a polished surface over eight decades, A / (B + d^g) with A = 3e-7, B = 1e-8, g = 2.2 and 3 % noise, made without this
 * program (abg.csv): the fit finds them, from the default start and by every loss that counts decades alike. */
#include "fit_samples.h"

static const double truth[3] = {3e-7, 1e-8, 2.2};
static const char *const name[3] = {"abg_a", "abg_b", "abg_g"};

static void found(ff_loss loss)
{
    ff_table t;
    ff_model m;
    ff_error err = {0};
    ff_fit_result r;
    ff_fit_options o = fit_options();
    o.loss = loss;
    if (ff_table_read_into(FF_TESTS "/abg.csv", NULL, &t, &err) || ff_model_parse("abg", &m, &err)) {
        printf("the test itself is wrong: %s\n", err.message);
        exit(1);
    }
    if (FF_CHECK(fit_table(&t, &m, &o, &r, NULL, &err) == FF_OK && r.outcome == FF_CONVERGED, "%s: %s", ff_loss_name((int)loss),
                 err.message)) {
        for (int k = 0; k < 3; k++) {
            const ff_fit_value *v = ff_fit_result_find(&r, name[k], 0);
            if (!FF_CHECK(v != NULL, "no %s", name[k])) continue;
            FF_CHECK(!v->at_bound && v->low <= truth[k] && truth[k] <= v->high, "%s, %s: %g, %g to %g, expected %g",
                     ff_loss_name((int)loss), name[k], v->value, v->low, v->high, truth[k]);
            FF_CHECK(fabs(v->value / truth[k] - 1) < 0.05, "%s, %s: %g, expected %g", ff_loss_name((int)loss), name[k], v->value,
                     truth[k]);
        }
        ff_fit_result_clear(&r);
    }
    ff_table_clear(&t);
}

static void eight_decades(void)
{
    found(FF_LOSS_LN);
    found(FF_LOSS_RELATIVE);
    found(FF_LOSS_CUBE_ROOT);
}

FF_TEST_MAIN(FF_TEST(eight_decades))
