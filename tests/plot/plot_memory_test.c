/* Every allocation of a figure, and of what it reads, may fail: the status then says so, nothing is lost, nothing crashes. */
#include "ff_test.h"
#include "memory/failing.h"
#include "report/plot/kinds/internal_plots.h"

static const char document[] =
    "{\"schema\": \"facetfit.fit/2\", \"loss\": {\"max_theta_deg\": 70}, \"fits\": [{\"model\": \"ggx/v-cavity/schlick+lambert\", "
    "\"channels\": [\"r\", \"g\"], \"outcome\": \"converged\", \"parameters\": {\"alpha_x\": {\"value\": 0.3, \"interval\": [0.2, "
    "0.4]}, "
    "\"alpha_y\": {\"value\": 0.3, \"tied\": true}, \"r_xy\": {\"value\": 0}, \"slope_x\": {\"value\": 0}, \"slope_y\": "
    "{\"value\": 0}, "
    "\"f0\": {\"value\": [0.5, 0.4]}, \"ks\": {\"value\": [1, 1]}, \"kd\": {\"value\": [0.1, 0.2]}}, "
    "\"noise\": {\"levels\": [{\"square\": 0.01}]}, \"residual_bands\": {\"theta_i\": [{\"n\": 7, \"mean\": -0.5, \"rms\": 1}]}, "
    "\"correlation\": {\"names\": [\"alpha_x\", \"f0[r]\"], \"matrix\": [[1, 0.5], [0.5, 1]]}}]}";

static FILE *nowhere;

/* Reads the document and draws a kind of it, in every form. */
static ff_status draw(const ff_plot_kind *kind, ff_error *err)
{
    ff_fit_document *d;
    ff_figure fig;
    ff_status status = ff_fit_document_parse(document, sizeof document - 1, NULL, &d, err);
    if (status) return status;
    const ff_fitted *f = &d->fit[0];
    const ff_plot_model m = {"model",  &f->model,  f->n_channels,
                             f->shape, f->channel, (const char(*)[FF_CHANNEL_NAME])f->channel_name,
                             f->noise, f->outcome, {0}};
    const ff_plot_subject s = {.max_theta = 1.4, .n_models = 1, .model = &m, .document = d};
    const ff_plot_choice choice = {.log = -1};
    ff_figure_init(&fig);
    status = kind->build(&s, &choice, &fig, err);
    if (!status) status = fig.status;
    for (int form = 0; form < FF_FIGURE_FORMS && !status; form++)
        status = ff_figure_write(&fig, (ff_figure_form)form, nowhere, err);
    ff_figure_clear(&fig);
    ff_fit_document_free(d);
    return status;
}

static void every_allocation(void)
{
    nowhere = fopen("/dev/null", "wb");
    setvbuf(nowhere, NULL, _IONBF, 0); /* its buffer would be an allocation of the first figure */
    int kinds = 0;
    for (size_t k = 0; ff_plot_kind_at(k); k++) {
        const ff_plot_kind *kind = ff_plot_kind_at(k);
        ff_error err = {0};
        if (!(kind->takes & (FF_PLOT_MODELS | FF_PLOT_RESULTS))) continue;
        kinds++;
        failing_begin(-1, 0);
        if (!FF_CHECK(draw(kind, &err) == FF_OK, "%s: %s", kind->name, err.message)) continue;
        const long n = atomic_load(&failing_count);
        FF_CHECK(n > 20, "%s: %ld allocations", kind->name, n);
        for (long at = 0; at < n; at++)
            for (int all = 0; all < 2; all++) {
                const long before = atomic_load(&failing_live);
                failing_begin(at, all);
                const ff_status status = draw(kind, &err);
                const long refused = atomic_load(&failing_refused);
                failing_begin(-1, 0);
                FF_CHECK(refused > 0 && status == FF_ERR_MEMORY, "%s, allocation %ld of %ld: %s", kind->name, at, n,
                         ff_status_str(status));
                FF_CHECK(atomic_load(&failing_live) == before, "%s, allocation %ld: %ld blocks are lost", kind->name, at,
                         atomic_load(&failing_live) - before);
            }
    }
    FF_CHECK(kinds >= 8, "%d kinds", kinds);
    fclose(nowhere);
}

FF_TEST_MAIN(FF_TEST(every_allocation))
