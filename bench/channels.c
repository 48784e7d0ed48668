/* How the time of a fit grows with the number of channels: scattered samples of one surface, F0 and kd smooth over the channels,
 * fitted with its own search for a start and from a given one, one thread, errors included. The numbers of channels go by turns, so
 * that a slow minute falls on all.
 *
 *      bench_channels [ROUNDS [SAMPLES [CHANNELS...]]]
 *
 * Prints JSON: for each number of channels the median seconds of both fits, nanoseconds per sample and channel, and passes. */
#define _GNU_SOURCE /* clock_gettime */
#include "fit/interface/fit_struct.h"
#include "models/model_struct.h"
#include "simulate/simulate_struct.h"
#include "data_formats/table/table_struct.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

enum { MAX_ROUNDS = 32, MAX_COUNTS = 32 };

static void give_up(const char *what)
{
    fprintf(stderr, "bench_channels: %s\n", what);
    exit(1);
}

/* Of this process alone: there is one thread, and what else the machine does is not asked. */
static double now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* One number of channels: its data, the surface they are of, and what its rounds took. */
typedef struct workload {
    size_t n_channels, used;
    ff_table table;
    double shape[FF_MAX_SHAPE], *channel;
    double search[MAX_ROUNDS], given[MAX_ROUNDS];
    int search_passes, given_passes;
    double objective;
} workload;

static void make(const ff_model *m, size_t n_samples, workload *w)
{
    ff_simulate_options so;
    ff_error err = {0};
    const size_t C = w->n_channels;
    char grid[64];
    w->channel = malloc(C * m->n_channel * sizeof *w->channel);
    if (!w->channel) give_up("out of memory");
    ff_model_defaults(m, C, w->shape, w->channel);
    ff_simulate_options_init(&so);
    so.relative = 0.02;
    so.seed = 1;
    snprintf(grid, sizeof grid, "scattered:%zu", n_samples);
    if (ff_sampling_parse(grid, &so.sampling, &err) != FF_OK) give_up(err.message);
    w->shape[0] = 0.25, w->shape[1] = 0.4, w->shape[2] = 0.3;
    for (size_t c = 0; c < C; c++) { /* the colours of a copper-like surface under a faint blue base */
        const double t = C > 1 ? (double)c / (double)(C - 1) : 0.5;
        w->channel[c * m->n_channel] = 0.4 + 0.5 / (1 + exp(-12 * (t - 0.5)));
        w->channel[c * m->n_channel + 2] = 0.08 - 0.05 * t;
    }
    if (ff_simulate_into(m, C, w->shape, w->channel, &so, &w->table, &err) != FF_OK) give_up(err.message);
}

/* A new problem and a fit; seconds of the two. */
static double fit_seconds(const ff_model *m, workload *w, ff_fit_options o, int given, int *passes)
{
    ff_problem *p = NULL;
    ff_fit_result r;
    ff_selection used;
    ff_error err = {0};
    double shape[FF_MAX_SHAPE];
    memcpy(shape, w->shape, sizeof shape);
    shape[0] *= 1.2, shape[1] *= 0.9;
    if (given) {
        o.start_shape = shape;
        o.start_channel = w->channel;
    }
    const double begin = now();
    if (ff_problem_make(&w->table, m, 1, &o, &p, &err) != FF_OK) give_up(err.message);
    if (ff_problem_fit_into(p, m, &o, &r, &err) != FF_OK) give_up(err.message);
    const double seconds = now() - begin;
    if (r.outcome != FF_CONVERGED) give_up("a fit did not converge");
    ff_problem_selection(p, &used);
    w->used = used.used;
    w->objective = r.residual.objective;
    *passes = r.passes;
    ff_fit_result_clear(&r);
    ff_problem_free(p);
    return seconds;
}

static int by_size(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static double median(double *v, int n)
{
    qsort(v, (size_t)n, sizeof *v, by_size);
    return v[n / 2];
}

int main(int argc, char **argv)
{
    static const size_t counts[] = {1, 3, 8, 16, 31, 61, 121, 301};
    static workload work[MAX_COUNTS];
    const int rounds = argc > 1 ? atoi(argv[1]) : 3;
    const size_t n_samples = argc > 2 ? (size_t)strtoul(argv[2], NULL, 10) : 5000;
    const int n = argc > 3 ? argc - 3 : (int)(sizeof counts / sizeof *counts);
    ff_model m;
    ff_error err = {0};
    ff_fit_options o;
    if (rounds < 1 || rounds > MAX_ROUNDS || n > MAX_COUNTS || n_samples == 0)
        give_up("usage: bench_channels [ROUNDS [SAMPLES [CHANNELS...]]]");
    if (ff_model_parse("ggx+lambert", &m, &err) != FF_OK) give_up(err.message);
    ff_fit_options_init(&o);
    o.threads = 1;
    o.shape = FF_SHAPE_CORRELATED;
    for (int i = 0; i < n; i++) {
        work[i].n_channels = argc > 3 ? (size_t)strtoul(argv[3 + i], NULL, 10) : counts[i];
        if (work[i].n_channels == 0) give_up("a number of channels is wrong");
        make(&m, n_samples, &work[i]);
    }
    for (int r = 0; r < rounds; r++)
        for (int i = 0; i < n; i++) {
            work[i].search[r] = fit_seconds(&m, &work[i], o, 0, &work[i].search_passes);
            work[i].given[r] = fit_seconds(&m, &work[i], o, 1, &work[i].given_passes);
        }
    printf("{\"samples\": %zu, \"fits\": [", work[0].used);
    for (int i = 0; i < n; i++) {
        workload *w = &work[i];
        const double search = median(w->search, rounds), given = median(w->given, rounds),
                     scale = 1e9 / ((double)w->used * (double)w->n_channels);
        printf("%s\n  {\"channels\": %zu, \"search_s\": %.6f, \"given_s\": %.6f, \"search_ns\": %.2f, \"given_ns\": %.2f, "
               "\"search_passes\": %d, \"given_passes\": %d, \"objective\": %.15g}",
               i ? "," : "", w->n_channels, search, given, search * scale, given * scale, w->search_passes, w->given_passes,
               w->objective);
        ff_table_clear(&w->table);
        free(w->channel);
    }
    printf("\n]}\n");
    return 0;
}
