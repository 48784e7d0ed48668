/* What the headers say of threads: eight of them make eight fits each at the same time, of other models, losses and tables, and ask
 * what may be shared (tables, models, a sampler, an interpolant, a result); a ninth is cancelled by a tenth meanwhile. The results
 * are those of one thread, to the bit. Meant for a build with ThreadSanitizer (the preset tsan), which sees races that do no harm.
 */
#include "ff_test.h"
#include "ff_albedo.h"
#include "ff_fit.h"
#include "ff_interpolate.h"
#include "ff_sample.h"
#include "ff_simulate.h"
#include "ff_survey.h"
#include "ff_words.h"
#include <pthread.h>
#include <semaphore.h>

enum { THREADS = 8, FITS = 8, TABLES = 4, MODELS = 8, MOST = 64, VIEWS = 40, SAMPLES = 64 };

static const char *const expression[MODELS] = {
    "ggx+lambert",        "beckmann+lambert",     "gtr+lambert",           "student-t/v-cavity+oren-nayar",
    "ggx+disney-coupled", "ggx+beckmann+lambert", "phong/kelemen+lambert", "ggx/smith-separable/conductor+lambert"};

/* Shared by all, and read alone. */
static ff_table *table[TABLES];
static ff_model *model[MODELS];
static ff_sampler *sampler;
static ff_interpolant *interpolant;
static ff_fit_result *shared_fit;

/* What a fit says, for comparison by its bytes. */
typedef struct answer {
    ff_status status;
    ff_outcome outcome;
    int iterations, passes;
    double objective, value[MOST], error[MOST];
    size_t n_warnings;
} answer;

/* What one thread has asked of the shared objects. */
typedef struct views {
    double pdf[VIEWS], weight[VIEWS], between[VIEWS], albedo, f[VIEWS], error;
    size_t warnings, samples;
} views;

typedef struct work {
    int number;
    answer fit[FITS];
    views views;
} work;

/* ---- one fit ----------------------------------------------------------------------------------- */

static void take(const ff_fit_result *fit, const ff_model *m, answer *out)
{
    size_t n = 0;
    out->outcome = ff_fit_result_outcome(fit);
    out->iterations = ff_fit_result_iterations(fit);
    out->passes = ff_fit_result_passes(fit);
    out->objective = ff_fit_result_objective(fit);
    out->n_warnings = ff_fit_result_warning_count(fit);
    for (int kind = 0; kind < 2; kind++)
        for (size_t c = 0; c < (kind ? ff_fit_result_channel_count(fit) : 1); c++)
            for (uint32_t k = 0; k < ff_model_param_count(m, kind ? FF_PARAM_CHANNEL : FF_PARAM_SHAPE) && n < MOST; k++, n++) {
                const ff_fit_value *v = ff_fit_result_at(fit, (ff_param_ref){kind ? FF_PARAM_CHANNEL : FF_PARAM_SHAPE, k}, c);
                out->value[n] = v->value;
                out->error[n] = v->std_error;
            }
}

/* The fit number k of a thread; on one thread of its own or on two. */
static void fit_one(int thread, int k, answer *out)
{
    ff_fit_options o;
    ff_problem *problem = NULL;
    ff_fit_result *fit = NULL;
    ff_error err = {0};
    const ff_model *m = model[(3 * thread + k) % MODELS];
    ff_fit_options_init(&o);
    o.threads = 1 + (thread + k) % 2;
    o.loss = (ff_loss)((thread + 2 * k) % FF_LOSS_COUNT);
    if (k % 4 == 3) o.robust = FF_ROBUST_HUBER;
    memset(out, 0, sizeof *out);
    out->status = ff_problem_new(table[(thread + k) % TABLES], &m, 1, &o, &problem, &err);
    if (!out->status && o.robust) out->status = ff_problem_estimate_scale(problem, m, &o, &err);
    if (!out->status) out->status = ff_problem_fit(problem, m, &o, &fit, &err);
    if (!out->status) take(fit, m, out);
    ff_fit_result_free(fit);
    ff_problem_free(problem);
}

/* ---- what is shared ---------------------------------------------------------------------------- */

static void ask(int thread, views *out)
{
    static const double zero = 0, side = 0.6, up = 0.8;
    const ff_dirs w = {&side, &zero, &up, &zero, &side, &up};
    const ff_model *m = model[thread % MODELS];
    double shape[MOST], channel[MOST], values[1];
    ff_integral albedo;
    ff_survey *survey;
    memset(out, 0, sizeof *out);
    ff_model_defaults(m, 1, shape, channel);
    ff_albedo_directional(m, FF_ISA_BEST, 1, shape, channel, (const double[]){0.6, 0, 0.8}, &albedo, NULL);
    out->albedo = albedo.value;
    for (int i = 0; i < VIEWS; i++) {
        const double mu = 0.1 + 0.02 * i, wo[3] = {sqrt(1 - mu * mu), 0, mu}, u[3] = {(i + 0.5) / VIEWS, 0.3, 0.7};
        double wi[3];
        ff_sampler_sample(sampler, 1, wo, u, NULL, wi, &out->pdf[i], NULL, &out->weight[i], 1);
        unsigned char found;
        const double *const planes[6] = {&side, &zero, &up, &wo[0], &wo[1], &wo[2]};
        ff_interpolant_eval(interpolant, planes, 1, values, &found);
        out->between[i] = values[0];
        ff_model_eval(m, FF_ISA_BEST, 1, shape, channel, &w, 1, &out->f[i], NULL, 1);
    }
    out->error = ff_fit_result_find(shared_fit, "alpha_x", 0)->std_error;
    out->warnings = ff_fit_result_warning_count(shared_fit);
    if (ff_survey_new(table[thread % TABLES], &survey, NULL) == FF_OK) {
        out->samples = ff_table_samples(table[thread % TABLES]);
        ff_survey_free(survey);
    }
}

static void *run(void *argument)
{
    work *w = argument;
    for (int k = 0; k < FITS; k++) fit_one(w->number, k, &w->fit[k]);
    ask(w->number, &w->views);
    return NULL;
}

/* ---- one that is cancelled --------------------------------------------------------------------- */

typedef struct cancelled {
    volatile int cancel;
    sem_t begun, done;
    int waited;
    ff_status status;
    ff_outcome outcome;
} cancelled;

/* At its first iteration the fit waits until somebody has cancelled it. */
static void wait_for_cancel(void *context, int iteration, double objective)
{
    cancelled *c = context;
    (void)iteration;
    (void)objective;
    if (c->waited++) return;
    sem_post(&c->begun);
    sem_wait(&c->done);
}

static void *fit_cancelled(void *argument)
{
    cancelled *c = argument;
    ff_fit_options o;
    ff_problem *problem = NULL;
    ff_fit_result *fit = NULL;
    ff_fit_options_init(&o);
    o.threads = 2;
    o.cancel = &c->cancel;
    o.progress = wait_for_cancel;
    o.progress_context = c;
    c->status = ff_problem_new(table[0], (const ff_model *const *)&model[5], 1, &o, &problem, NULL);
    if (!c->status) c->status = ff_problem_fit(problem, model[5], &o, &fit, NULL);
    if (!c->status) c->outcome = ff_fit_result_outcome(fit);
    if (!c->waited) sem_post(&c->begun);
    ff_fit_result_free(fit);
    ff_problem_free(problem);
    return NULL;
}

static void *cancel(void *argument)
{
    cancelled *c = argument;
    sem_wait(&c->begun);
    __atomic_store_n(&c->cancel, 1, __ATOMIC_RELAXED);
    sem_post(&c->done);
    return NULL;
}

/* ---- the test ---------------------------------------------------------------------------------- */

static void make(void)
{
    static const char *const truth[TABLES] = {"ggx+lambert", "beckmann+lambert", "ggx+lambert", "student-t+lambert"};
    static const char *const set[TABLES] = {"alpha=0.3", "alpha=0.15", "alpha_x=0.5", "alpha=0.25"};
    ff_error err = {0};
    ff_fit_options o;
    ff_problem *problem = NULL;
    double shape[MOST], channel[MOST];
    ff_status status = FF_OK;
    for (int k = 0; k < MODELS && !status; k++) status = ff_model_new(expression[k], &model[k], &err);
    for (int k = 0; k < TABLES && !status; k++) {
        ff_simulate_options made;
        ff_model *m = NULL;
        const size_t channels = k % 2 ? 3 : 1;
        ff_simulate_options_init(&made);
        made.sampling.step_deg = 15;
        made.relative = 0.02;
        made.seed = (uint64_t)k + 1;
        status = ff_model_new(truth[k], &m, &err);
        if (!status) ff_model_defaults(m, channels, shape, channel);
        if (!status) status = ff_model_set(m, channels, set[k], shape, channel, &err);
        if (!status) status = ff_simulate(m, channels, shape, channel, &made, &table[k], &err);
        ff_model_free(m);
    }
    ff_model_defaults(model[0], 1, shape, channel);
    if (!status) status = ff_sampler_new(model[0], FF_ISA_BEST, 1, shape, channel, &sampler, &err);
    if (!status) status = ff_interpolant_new(table[0], 1, &interpolant, &err);
    ff_fit_options_init(&o);
    if (!status) status = ff_problem_new(table[0], (const ff_model *const *)&model[0], 1, &o, &problem, &err);
    if (!status) status = ff_problem_fit(problem, model[0], &o, &shared_fit, &err);
    ff_problem_free(problem);
    if (!FF_CHECK(status == FF_OK, "%s", err.message)) exit(1);
}

static void release(void)
{
    ff_fit_result_free(shared_fit);
    ff_interpolant_free(interpolant);
    ff_sampler_free(sampler);
    for (int k = 0; k < TABLES; k++) ff_table_free(table[k]);
    for (int k = 0; k < MODELS; k++) ff_model_free(model[k]);
}

static void compare(const work *alone, const work *together, int *good)
{
    for (int t = 0; t < THREADS; t++) {
        for (int k = 0; k < FITS; k++) {
            const answer *a = &alone[t].fit[k], *b = &together[t].fit[k];
            *good += a->status == FF_OK;
            FF_CHECK(!memcmp(a, b, sizeof *a), "thread %d, fit %d: status %d and %d, objective %.17g and %.17g", t, k, a->status,
                     b->status, a->objective, b->objective);
        }
        FF_CHECK(!memcmp(&alone[t].views, &together[t].views, sizeof alone[t].views), "thread %d: shared objects answer otherwise",
                 t);
    }
}

static void together(void)
{
    static work alone[THREADS], at_once[THREADS];
    cancelled c = {.cancel = 0};
    pthread_t thread[THREADS], ends, canceller;
    int good = 0;
    make();
    sem_init(&c.begun, 0, 0);
    sem_init(&c.done, 0, 0);
    for (int t = 0; t < THREADS; t++) {
        alone[t].number = at_once[t].number = t;
        run(&alone[t]);
    }
    FF_CHECK(pthread_create(&canceller, NULL, cancel, &c) == 0 && pthread_create(&ends, NULL, fit_cancelled, &c) == 0, "threads");
    for (int t = 0; t < THREADS; t++) FF_CHECK(pthread_create(&thread[t], NULL, run, &at_once[t]) == 0, "thread %d", t);
    for (int t = 0; t < THREADS; t++) pthread_join(thread[t], NULL);
    pthread_join(ends, NULL);
    pthread_join(canceller, NULL);
    compare(alone, at_once, &good);
    printf("  %d fits of %d end with a result\n", good, THREADS * FITS);
    FF_CHECK(good >= THREADS * FITS * 3 / 4, "only %d fits end with a result", good);
    FF_CHECK(c.waited > 0, "the fit that is cancelled never iterated");
    FF_CHECK(c.status == FF_ERR_CANCELLED || (c.status == FF_OK && c.outcome == FF_CANCELLED), "cancelled: %s, %s",
             ff_status_str(c.status), ff_outcome_name((int)c.outcome));
    sem_destroy(&c.begun);
    sem_destroy(&c.done);
    release();
}

FF_TEST_MAIN(FF_TEST(together))
