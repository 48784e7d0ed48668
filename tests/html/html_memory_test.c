/* Every allocation of a page of a comparison, and of a table, may fail: the status then says so, nothing is lost, nothing crashes.
 * The page of a fit fits anew, and the solver does not bear what fails in it: ff_fit.h. A figure that cannot be built for another
 * reason than memory is said on the page, so that a failure may also pass as such; it must then be no memory that was asked for by
 * us. */
#include "fit_samples.h"
#include "memory/failing.h"
#include "report/html/ff_html.h"

enum { MODELS = 2 };

typedef struct made {
    ff_table table;
    ff_problem *problem;
    ff_fit_result fit[MODELS];
    ff_fit_options options;
    ff_places places;
    ff_fit_trust trust[MODELS];
    ff_report_fits report;
} made;

static int tried(void)
{
    return ff_test_is_thorough() ? 120 : 40;
}

/* What is written is counted and summed up (FNV-1a), and kept nowhere. */
static FILE *nowhere;
static uint64_t sum;

static ssize_t take(void *cookie, const char *bytes, size_t n)
{
    (void)cookie;
    for (size_t i = 0; i < n; i++) sum = (sum ^ (unsigned char)bytes[i]) * UINT64_C(0x100000001b3);
    return (ssize_t)n;
}

static const char *const words[] = {"facetfit", "compare", "a.csv"};

static void make(made *m)
{
    const fit_surface surface = fit_surface_make("ggx+lambert", 1, "alpha=0.3 f0=0.5 kd=0.2");
    const fit_sampling sampling = {.n = 300, .max_theta = 75, .glossy = 0.5, .noise = 0.02, .seed = 7};
    ff_model model[MODELS];
    ff_error err = {0};
    memset(m, 0, sizeof *m);
    m->table = fit_measure(&surface, &sampling);
    if (!FF_CHECK(ff_model_parse("ggx+lambert", &model[0], &err) == FF_OK, "%s", err.message)) return;
    if (!FF_CHECK(ff_model_parse("beckmann/v-cavity+kelemen-matte", &model[1], &err) == FF_OK, "%s", err.message)) return;
    ff_fit_options_init(&m->options);
    m->options.threads = 1;
    if (!FF_CHECK(ff_problem_make(&m->table, model, MODELS, &m->options, &m->problem, &err) == FF_OK, "%s", err.message)) return;
    for (int k = 0; k < MODELS; k++)
        FF_CHECK(ff_problem_fit_into(m->problem, &model[k], &m->options, &m->fit[k], &err) == FF_OK, "%s", err.message);
    FF_CHECK(ff_places_init(m->problem, &m->table, &m->places, &err) == FF_OK, "%s", err.message);
    for (int k = 0; k < MODELS; k++)
        m->trust[k].has_bands =
            ff_trust_bands_into(m->problem, &m->places, &m->options, &m->fit[k], &m->trust[k].bands, &err) == FF_OK;
    m->report = (ff_report_fits){.head = {"0", 3, words},
                                 .path = "a.csv",
                                 .table = &m->table,
                                 .options = &m->options,
                                 .n_problems = 1,
                                 .problem = (const ff_problem *const *)&m->problem,
                                 .n_fits = MODELS,
                                 .fit = m->fit,
                                 .trust = m->trust,
                                 .places = &m->places};
}

static void release(made *m)
{
    for (int k = 0; k < MODELS; k++) ff_fit_result_clear(&m->fit[k]);
    ff_places_clear(&m->places);
    ff_problem_free(m->problem);
    ff_table_clear(&m->table);
}

/* The sum of what was written since. */
static uint64_t ended(void)
{
    fflush(nowhere);
    const uint64_t all = sum;
    sum = UINT64_C(0xcbf29ce484222325);
    return all;
}

static ff_status write_comparison(const made *m, ff_error *err)
{
    return ff_html_fits_write(&m->report, "0", FF_ISA_SCALAR, nowhere, err);
}

static ff_status write_table(const made *m, ff_error *err)
{
    return ff_html_table_write(&m->report.head, "a.csv", &m->table, NULL, nowhere, err);
}

/* A few of them drawn by the seed. */
static void fail_some(const made *m, const char *name, ff_status (*write)(const made *, ff_error *))
{
    uint64_t state = ff_test_seeded(11);
    ff_error err = {0};
    long refusals = 0;
    (void)ended();
    failing_begin(-1, 0);
    if (!FF_CHECK(write(m, &err) == FF_OK, "%s: %s", name, err.message)) return;
    const uint64_t whole = ended();
    const long n = atomic_load(&failing_count);
    FF_CHECK(n > 100, "%s: %ld allocations", name, n);
    for (int k = 0; k < tried(); k++) {
        const long at = k < 20 ? k : (long)(ff_test_next(&state) % (uint64_t)n), before = atomic_load(&failing_live);
        memset(&err, 0, sizeof err);
        failing_begin(at, k % 2);
        const ff_status status = write(m, &err);
        const long refused_here = atomic_load(&failing_refused);
        failing_begin(-1, 0);
        refusals += status == FF_ERR_MEMORY;
        const int same = ended() == whole;
        FF_CHECK(refused_here > 0 && (status == FF_ERR_MEMORY || (status == FF_OK && same)),
                 "%s, allocation %ld of %ld: %s, and %s page", name, at, n, ff_status_str(status), same ? "the same" : "another");
        FF_CHECK(atomic_load(&failing_live) == before, "%s, allocation %ld: %ld blocks are lost", name, at,
                 atomic_load(&failing_live) - before);
    }
    FF_CHECK(refusals > tried() / 2, "%s: %ld of %d were refused", name, refusals, tried());
}

static void every_allocation(void)
{
    made m;
    make(&m);
    static char buffer[1 << 16];
    nowhere = fopencookie(NULL, "w", (cookie_io_functions_t){.write = take});
    if (!FF_CHECK(nowhere != NULL, "no stream")) return;
    setvbuf(nowhere, buffer, _IOFBF, sizeof buffer); /* else it would be an allocation of the first page */
    fail_some(&m, "a comparison", write_comparison);
    fail_some(&m, "a table", write_table);
    fclose(nowhere);
    release(&m);
}

FF_TEST_MAIN(FF_TEST(every_allocation))
