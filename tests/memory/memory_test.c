/* Every allocation may fail: the status then says that memory was short and nothing else, nothing is lost, nothing hangs.
 *
 *     memory_test [N]     N allocations of each thing that is done, drawn by FF_TEST_SEED; all of them without N
 *
 * Each allocation fails once alone and once with all after it. A process of its own does it, so that one that dies or hangs is
 * seen. */
#include "ff_test.h"
#include "failing.h"
#include "data_formats/analysis/ff_survey.h"
#include "ff_fit.h"
#include "ff_ndf.h"
#include "ff_resample.h"
#include "ff_simulate.h"
#include "ff_trust.h"
#include "fit/minimise/ceres_bridge.h"
#include <dirent.h>
#include <signal.h>
#include <sys/time.h>
#include <sys/wait.h>

enum { PATIENCE = 10, MODELS = 2 };

/* What the process that tries and the one that watches both see. */
typedef struct shared {
    size_t at; /* of the list */
    int and_all_after;
    int in_solver, failed_in_solver;
    long tried, refused, wrong, lost_in_solver;
} shared;
static shared *common;

typedef struct task {
    const char *name;
    ff_status (*run)(const void *context, ff_error *err);
    const void *context;
} task;

/* Ceres ends the process where an allocation fails in what may not throw, and loses one or two where it fails elsewhere: ff_fit.h
 * says so. */
enum { LOST_IN_SOLVER = 4 };

static void notice(void)
{
    if (common->in_solver) common->failed_in_solver = 1;
}

/* zlib asks the C library itself, and OpenEXR does not pass on why it failed. */
static int is_of_zlib(const task *t, ff_status status, const ff_error *err)
{
    return status == FF_ERR_FORMAT && strncmp(t->name, "exr/", 4) == 0 && strstr(err->message, "unable to decompress");
}

ff_status __real_ff_ceres_solve(const ff_ceres_problem *p, double *x, ff_ceres_summary *out, ff_error *err);
ff_status __wrap_ff_ceres_solve(const ff_ceres_problem *p, double *x, ff_ceres_summary *out, ff_error *err);
ff_status __wrap_ff_ceres_solve(const ff_ceres_problem *p, double *x, ff_ceres_summary *out, ff_error *err)
{
    common->in_solver++;
    const ff_status status = __real_ff_ceres_solve(p, x, out, err);
    common->in_solver--;
    return status;
}

/* ---- what is done ---------------------------------------------------------------------------- */

static ff_table *scan, *grid; /* made before anything fails */
static ff_model *model[MODELS];
static char written[256];

static ff_status read_file(const void *path, ff_error *err)
{
    ff_table *t;
    ff_survey *s;
    ff_status status = ff_table_read(path, NULL, &t, err);
    if (status) return status;
    status = ff_survey_new(t, &s, err);
    if (!status) ff_survey_free(s);
    ff_table_free(t);
    return status;
}

static ff_status write_file(const void *format, ff_error *err)
{
    return ff_table_write(written, format, grid, err);
}

/* Into the format's own directions, and into a file. */
static ff_status resample(const void *format, ff_error *err)
{
    ff_resample_options o;
    ff_resample_report report = {.size = sizeof report};
    ff_table *t;
    ff_resample_options_init(&o);
    o.threads = 1;
    ff_status status = ff_resample(scan, ff_format_find(format), &o, &t, &report, err);
    if (status) return status;
    status = ff_table_write(written, format, t, err);
    ff_table_free(t);
    return status;
}

static ff_status simulate(const void *unused, ff_error *err)
{
    (void)unused;
    ff_simulate_options o;
    ff_table *t;
    ff_model *m;
    double shape[16], channel[16];
    ff_status status = ff_model_new("ggx+lambert", &m, err);
    if (status) return status;
    ff_simulate_options_init(&o);
    ff_model_defaults(m, 1, shape, channel);
    status = ff_sampling_parse("goniometer:30", &o.sampling, err);
    if (!status) status = ff_simulate(m, 1, shape, channel, &o, &t, err);
    if (!status) ff_table_free(t);
    ff_model_free(m);
    return status;
}

static void options(ff_fit_options *o)
{
    ff_fit_options_init(o);
    o->threads = 1;
}

static ff_status trust(ff_problem *p, const ff_fit_options *o, ff_fit_result *const fit[MODELS], ff_error *err)
{
    ff_places *places;
    ff_versus versus[MODELS];
    ff_table *residuals;
    ff_status status = ff_places_new(p, scan, &places, err);
    if (status) return status;
    status = ff_trust_compare(p, places, o, (const ff_fit_result *const *)fit, MODELS, 0, 0, versus, err);
    if (!status) status = ff_trust_residual_table(p, scan, o, fit[0], &residuals, err);
    if (!status) ff_table_free(residuals);
    if (!status) status = ff_trust_profile(p, o, fit[0], err);
    ff_places_free(places);
    return status;
}

/* Two models, and what tells them apart. */
static ff_status compare(const void *unused, ff_error *err)
{
    (void)unused;
    ff_fit_options o;
    ff_problem *p;
    ff_fit_result *fit[MODELS] = {NULL};
    options(&o);
    ff_status status = ff_problem_new(scan, (const ff_model *const *)model, MODELS, &o, &p, err);
    if (status) return status;
    for (int k = 0; k < MODELS && !status; k++) status = ff_problem_fit(p, model[k], &o, &fit[k], err);
    if (!status) status = trust(p, &o, fit, err);
    for (int k = 0; k < MODELS; k++) ff_fit_result_free(fit[k]);
    ff_problem_free(p);
    return status;
}

static ff_status fit(const void *robust, ff_error *err)
{
    ff_fit_options o;
    ff_problem *p;
    ff_fit_result *r;
    options(&o);
    if (robust) o.robust = FF_ROBUST_HUBER, o.robust_scale = 0.1;
    ff_status status = ff_problem_new(scan, (const ff_model *const *)model, 1, &o, &p, err);
    if (status) return status;
    status = ff_problem_fit(p, model[0], &o, &r, err);
    if (!status) ff_fit_result_free(r);
    ff_problem_free(p);
    return status;
}

static ff_status retrieve(const void *unused, ff_error *err)
{
    (void)unused;
    ff_fit_options fit_options;
    ff_ndf_options o;
    ff_problem *p;
    ff_ndf_result *r;
    options(&fit_options);
    fit_options.shape = FF_SHAPE_ISOTROPIC;
    ff_ndf_options_init(&o);
    o.fit = &fit_options;
    ff_status status = ff_ndf_problem_new(scan, &o, &p, err);
    if (status) return status;
    status = ff_ndf_retrieve(p, &o, &r, err);
    if (!status) ff_ndf_result_free(r);
    ff_problem_free(p);
    return status;
}

/* ---- with allocations that fail ---------------------------------------------------------------- */

/* One thing with one failure: 1 when it went as it should. */
static int try_one(const task *t, long number, int and_all_after, ff_status usual)
{
    ff_error err = {0};
    const long before = atomic_load(&failing_live);
    common->failed_in_solver = 0;
    failing_begin(number, and_all_after);
    const ff_status status = t->run(t->context, &err);
    const long refused_here = atomic_load(&failing_refused), lost = atomic_load(&failing_live) - before;
    failing_begin(-1, 0);
    common->tried++;
    common->refused += refused_here > 0;
    const int is_clean = status == FF_ERR_MEMORY || status == usual || is_of_zlib(t, status, &err);
    const int is_theirs = common->failed_in_solver && lost > 0 && lost <= LOST_IN_SOLVER;
    common->lost_in_solver += is_theirs;
    if (is_clean && (lost == 0 || is_theirs)) return 1;
    common->wrong++;
    printf("%s, allocation %ld%s: status %d (%s), usually %d, %ld lost: %s\n", t->name, number,
           and_all_after ? " and all after" : "", status, ff_status_str(status), usual, lost, err.message);
    return 0;
}

/* What computes without end is ended by the processor's time; what waits without end, by the clock. */
static void wait_no_longer(void)
{
    const struct itimerval limit = {.it_value = {.tv_sec = PATIENCE}};
    setitimer(ITIMER_PROF, &limit, NULL);
    alarm(20 * PATIENCE);
}

static void try_from(const task *t, const long *number, size_t n, ff_status usual)
{
    for (; common->at < n; common->at++)
        for (common->and_all_after = 0; common->and_all_after < 2; common->and_all_after++) {
            wait_no_longer();
            try_one(t, number[common->at], common->and_all_after, usual);
        }
    fflush(NULL);
}

/* Tries all of them in children; returns how many died within the solver. */
static long try_all(const task *t, const long *number, size_t n, ff_status usual)
{
    long in_solver = 0;
    common->at = 0;
    while (common->at < n) {
        fflush(NULL);
        common->in_solver = 0;
        const pid_t child = fork();
        if (child == 0) {
            const ff_status unused = t->run(t->context, NULL); /* what is allocated once and kept */
            (void)unused;
            try_from(t, number, n, usual);
            _exit(0);
        }
        int how = 0;
        waitpid(child, &how, 0);
        if (WIFEXITED(how)) {
            FF_CHECK(WEXITSTATUS(how) == 0, "%s: exit status %d", t->name, WEXITSTATUS(how));
            continue;
        }
        const int allowed = common->in_solver > 0 && WTERMSIG(how) == SIGABRT;
        in_solver += allowed;
        FF_CHECK(allowed, "%s, allocation %ld: ended by signal %d", t->name, number[common->at], WTERMSIG(how));
        common->at++;
    }
    return in_solver;
}

static long most_tried; /* of each task; 0: all */

static void check(const char *name, ff_status (*run)(const void *, ff_error *), const void *context)
{
    const task t = {name, run, context};
    ff_error err = {0};
    run(context, &err); /* what is allocated once and kept */
    failing_begin(-1, 0);
    const ff_status usual = run(context, &err);
    const long all = atomic_load(&failing_count), n = most_tried && most_tried < all ? most_tried : all;
    long *number = calloc((size_t)n + 1, sizeof *number);
    if (all == 0) printf("%s: usually %s, no allocations: %s\n", name, ff_status_str(usual), err.message);
    if (all == 0) return;
    if (!FF_CHECK(number != NULL, "no memory")) return;
    for (long i = 0; i < n; i++) number[i] = n == all ? i : (long)((double)all * (((double)i + ff_test_uniform()) / (double)n));
    *common = (shared){0};
    const long died = try_all(&t, number, (size_t)n, usual);
    FF_CHECK(common->wrong == 0, "%s: %ld went wrong", name, common->wrong);
    FF_CHECK(common->refused > 0 || died > 0, "%s: no allocation failed", name);
    printf("%s: usually %s, %ld allocations; %ld runs, %ld of them with a failure; %ld ended in the solver, %ld lost something "
           "there\n",
           name, ff_status_str(usual), all, common->tried + died, common->refused + died, died, common->lost_in_solver);
    free(number);
}

/* ---- tests ------------------------------------------------------------------------------------ */

static void check_corpus(const char *format)
{
    char folder[512], path[1024];
    snprintf(folder, sizeof folder, FF_SOURCE_DIR "/tests/fuzz/corpus/%s", format);
    DIR *d = opendir(folder);
    if (!FF_CHECK(d != NULL, "%s", folder)) return;
    for (struct dirent *e; (e = readdir(d));) {
        if (e->d_name[0] == '.' || strstr(e->d_name, "picture")) continue;
        snprintf(path, sizeof path, "%s/%s", folder, e->d_name);
        check(path + strlen(FF_SOURCE_DIR "/tests/fuzz/corpus/"), read_file, path);
    }
    closedir(d);
}

static void reading(void)
{
    for (size_t i = 0; i < ff_format_count(); i++) check_corpus(ff_format_name(ff_format_at(i)));
}

static void writing(void)
{
    for (size_t i = 0; i < ff_format_count(); i++)
        if (ff_format_can_write(ff_format_at(i)))
            check(ff_format_name(ff_format_at(i)), write_file, ff_format_name(ff_format_at(i)));
}

static void making(void)
{
    check("simulate", simulate, NULL);
    for (size_t i = 0; i < ff_format_count(); i++) { /* a MERL file is 35 MB */
        const char *name = ff_format_name(ff_format_at(i));
        char label[64];
        snprintf(label, sizeof label, "resample to %s", name);
        if (ff_format_can_write(ff_format_at(i)) && strcmp(name, "merl")) check(label, resample, name);
    }
}

static void fitting(void)
{
    check("fit", fit, NULL);
    check("robust fit", fit, "");
    check("compare", compare, NULL);
    check("ndf", retrieve, NULL);
}

static ff_table *simulated(const char *sampling, double noise)
{
    ff_simulate_options o;
    ff_table *t = NULL;
    double shape[16], channel[16];
    ff_simulate_options_init(&o);
    o.relative = noise;
    ff_model_defaults(model[0], 1, shape, channel);
    if (ff_sampling_parse(sampling, &o.sampling, NULL) || ff_simulate(model[0], 1, shape, channel, &o, &t, NULL)) return NULL;
    return t;
}

int main(int argc, char **argv)
{
    const ff_test_case cases[] = {FF_TEST(reading), FF_TEST(writing), FF_TEST(making), FF_TEST(fitting)};
    most_tried = argc > 1 ? strtol(argv[1], NULL, 10) : 0;
    common = mmap(NULL, sizeof *common, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    snprintf(written, sizeof written, "%s", ff_test_path("written"));
    if (common == MAP_FAILED || ff_model_new("ggx+lambert", &model[0], NULL) || ff_model_new("beckmann+lambert", &model[1], NULL))
        return 2;
    failing_noticed = notice;
    scan = simulated("goniometer:15", 0.02);
    grid = simulated("goniometer:30", 0.02);
    if (!scan || !grid) return 2;
    const int status = ff_test_main(cases, sizeof cases / sizeof *cases, argc - (argc > 1), argv + (argc > 1)); /* from "N" on */
    ff_table_free(scan);
    ff_table_free(grid);
    for (int k = 0; k < MODELS; k++) ff_model_free(model[k]);
    return status;
}
