/** Rates of ff_model_eval on one thread: four models, every instruction set this processor has, value alone and with all
 *  derivatives, on a block of directions that fits in the cache of a core and on a set that does not.
 *
 *      bench_kernels
 *
 *  Prints one JSON object with the rates of every repeat in samples per second. */
#define _GNU_SOURCE
#include "models/model_struct.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

enum { REPEATS = 7, IN_CACHE = 1024, IN_MEMORY = 1 << 21, PLANES = 6 };
static const double REPEAT_SECONDS = 0.04;

typedef struct workload {
    ff_model model;
    double shape[FF_MAX_SHAPE], channel[FF_MAX_CHANNEL_PARAMS];
    ff_isa isa;
    ff_dirs dirs;
    size_t n;
    double *f, *df; /* df is NULL when only the value is asked for */
} workload;

static double now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static _Noreturn void give_up(const char *what)
{
    fprintf(stderr, "bench_kernels: %s\n", what);
    exit(1);
}

static double *allocate(size_t n)
{
    double *p = aligned_alloc(64, n * sizeof *p);
    if (p == NULL) give_up("out of memory");
    return p;
}

/* Pairs of directions spread over the hemisphere down to 85 degrees by the additive recurrence of irrational steps. */
static void fill(double *planes, size_t n)
{
    const double step[4] = {0.7548776662466927, 0.5698402909980532, 0.8191725133961645, 0.6710436067037893};
    const double cos_limit = cos(85 * M_PI / 180);
    for (size_t i = 0; i < n; i++) {
        for (size_t w = 0; w < 2; w++) {
            const double z = 1 - fmod((double)(i + 1) * step[2 * w], 1) * (1 - cos_limit), sine = sqrt(1 - z * z);
            const double phi = 2 * M_PI * fmod((double)(i + 1) * step[2 * w + 1], 1);
            planes[(3 * w + 0) * n + i] = sine * cos(phi);
            planes[(3 * w + 1) * n + i] = sine * sin(phi);
            planes[(3 * w + 2) * n + i] = z;
        }
    }
}

static ff_dirs directions(const double *planes, size_t n)
{
    return (ff_dirs){planes, planes + n, planes + 2 * n, planes + 3 * n, planes + 4 * n, planes + 5 * n};
}

/* Samples per second over at least REPEAT_SECONDS. */
static double rate(const workload *w)
{
    size_t done = 0;
    const double begin = now();
    double end;
    do {
        for (size_t batch = 0; batch < 1 + 65536 / w->n; batch++, done += w->n) {
            if (ff_model_eval(&w->model, w->isa, 1, w->shape, w->channel, &w->dirs, w->n, w->f, w->df, w->n) != FF_OK) {
                give_up("evaluation failed");
            }
        }
        end = now();
    } while (end - begin < REPEAT_SECONDS);
    return (double)done / (end - begin);
}

static void print_rates(const workload *w, const char *name, int first)
{
    rate(w);
    printf("%s\n  {\"model\": \"%s\", \"isa\": \"%s\", \"where\": \"%s\", \"derivatives\": %s, \"rate\": [", first ? "" : ",", name,
           ff_isa_name(w->isa), w->n == IN_CACHE ? "cache" : "memory", w->df != NULL ? "true" : "false");
    for (int i = 0; i < REPEATS; i++) printf("%s%.4g", i > 0 ? ", " : "", rate(w));
    printf("]}");
}

static void set_model(workload *w, const char *expression, const char *assignment)
{
    ff_error error = {0};
    if (ff_model_parse(expression, &w->model, &error) != FF_OK) give_up(error.message);
    ff_model_defaults(&w->model, 1, w->shape, w->channel);
    if (ff_model_set(&w->model, 1, assignment, w->shape, w->channel, &error) != FF_OK) give_up(error.message);
}

int main(void)
{
    static const char *const models[][3] = {
        {"ggx", "ggx/smith-height-correlated/schlick", "alpha=0.3"},
        {"beckmann", "beckmann/smith-height-correlated/schlick", "alpha=0.3"},
        {"student-t", "student-t/smith-height-correlated/schlick", "gamma=3"},
        {"phong", "phong/smith-height-correlated/schlick", "n=20"},
    };
    double *planes[2] = {allocate(PLANES * (size_t)IN_CACHE), allocate(PLANES * (size_t)IN_MEMORY)};
    double *f = allocate(IN_MEMORY), *df = allocate((size_t)IN_MEMORY * 8);
    const size_t sizes[2] = {IN_CACHE, IN_MEMORY};
    int first = 1;
    for (int where = 0; where < 2; where++) fill(planes[where], sizes[where]);
    printf("{\"compiler\": \"%s\", \"best_isa\": \"%s\", \"kernels\": [", __VERSION__, ff_isa_name(FF_ISA_BEST));
    for (size_t m = 0; m < sizeof models / sizeof models[0]; m++) {
        workload w = {.f = f};
        set_model(&w, models[m][1], models[m][2]);
        if (w.model.n_shape + w.model.n_channel > 8) give_up("more parameters than planes for derivatives");
        for (int isa = FF_ISA_SCALAR; isa <= FF_ISA_AVX512; isa++) {
            w.isa = (ff_isa)isa;
            for (int k = 0; k < 4 && ff_isa_available(w.isa); k++, first = 0) {
                w.n = sizes[k / 2];
                w.dirs = directions(planes[k / 2], w.n);
                w.df = k % 2 == 1 ? df : NULL;
                print_rates(&w, models[m][0], first);
            }
        }
    }
    printf("\n]}\n");
    for (int where = 0; where < 2; where++) free(planes[where]);
    free(f);
    free(df);
    return 0;
}
