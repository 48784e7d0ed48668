/* Time of one pass over all samples with derivatives, one thread, for every term of the registry: each model in turn with the ggx
 * pass, so that a slow minute falls on both. Prints JSON: seconds of both and the median of their ratios. */
#define _GNU_SOURCE /* clock_gettime */
#include "models/tools/profile_struct.h"
#include "simulate/simulate_struct.h"
#include "fit/problem/internal_problem.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

enum { ROUNDS = 7 };

static void give_up(const char *what)
{
    fprintf(stderr, "bench_passes: %s\n", what);
    exit(1);
}

static double now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* A model with its problem, ready for passes. */
typedef struct workload {
    ff_model model;
    ff_problem *problem;
    ff_layout layout;
    ff_normal normal;
    double shape[FF_MAX_SHAPE], channel[FF_MAX_CHANNEL_PARAMS];
} workload;

static const ff_profile_table *profile;

static int make(const char *expression, const ff_table *t, const ff_fit_options *o, workload *w)
{
    ff_error err = {0};
    memset(w, 0, sizeof *w);
    if (ff_model_parse(expression, &w->model, &err) != FF_OK) return 0;
    ff_model_set_table(&w->model, profile);
    if (ff_problem_make(t, &w->model, 1, o, &w->problem, &err) != FF_OK) give_up(err.message);
    if (ff_layout_init(&w->model, 1, o->shape, 0, &w->layout, &err) != FF_OK || ff_layout_normal(&w->layout, &w->normal) != FF_OK)
        give_up(err.message);
    ff_layout_defaults(&w->layout, w->shape, w->channel);
    return 1;
}

static void done(workload *w)
{
    ff_problem_free(w->problem);
    ff_normal_free(&w->normal);
}

/* One pass, the making of its tables included. */
static double pass_seconds(workload *w, const ff_fit_options *o)
{
    ff_pass pass;
    const double begin = now();
    const ff_plan plan = ff_plan_with(&w->layout, w->problem, o);
    if (ff_plan_pass(&plan, w->shape, w->channel, &pass) != FF_OK) give_up("a pass cannot be made ready");
    if (ff_pass_run(&pass, 0, &w->normal) != FF_OK) give_up("a pass failed");
    ff_pass_free(&pass);
    return now() - begin;
}

static int by_size(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static void measure(const char *kind, const char *name, const char *expression, const ff_table *t, const ff_fit_options *o,
                    workload *ggx)
{
    static int first = 1;
    workload w;
    double ratio[ROUNDS], own[ROUNDS];
    if (!make(expression, t, o, &w)) return; /* the terms do not go together */
    pass_seconds(&w, o);
    for (int i = 0; i < ROUNDS; i++) {
        const double before = pass_seconds(ggx, o);
        own[i] = pass_seconds(&w, o);
        ratio[i] = 2 * own[i] / (before + pass_seconds(ggx, o));
    }
    qsort(ratio, ROUNDS, sizeof *ratio, by_size);
    qsort(own, ROUNDS, sizeof *own, by_size);
    printf("%s\n  {\"kind\": \"%s\", \"name\": \"%s\", \"model\": \"%s\", \"ratio\": %.3f, \"seconds\": %.5f}", first ? "" : ",",
           kind, name, expression, ratio[ROUNDS / 2], own[ROUNDS / 2]);
    fflush(stdout);
    first = 0;
    done(&w);
}

int main(void)
{
    ff_simulate_options so;
    ff_fit_options o;
    ff_table t;
    ff_model truth;
    ff_error err = {0};
    double shape[FF_MAX_SHAPE], channel[FF_MAX_CHANNEL_PARAMS];
    enum { POINTS = 40 };
    double q2[POINTS], p[POINTS];
    for (int i = 0; i < POINTS; i++) {
        q2[i] = i == 0 ? 0 : 1e-3 * pow(1e8, (i - 1) / (POINTS - 2.0));
        p[i] = pow(1 + q2[i] / 2, -3);
    }
    static ff_profile_table table;
    if (ff_profile_make(FF_PROFILE_P, POINTS, q2, p, &table, NULL, &err) != FF_OK) give_up(err.message);
    profile = &table;
    ff_simulate_options_init(&so);
    so.sampling.kind = FF_SAMPLING_MERL;
    if (ff_model_parse("ggx+lambert", &truth, &err) != FF_OK) give_up(err.message);
    ff_model_defaults(&truth, 1, shape, channel);
    if (ff_simulate_into(&truth, 1, shape, channel, &so, &t, &err) != FF_OK) give_up(err.message);
    ff_fit_options_init(&o);
    o.threads = 1;
    o.shape = FF_SHAPE_ISOTROPIC;
    o.max_theta = 1.5707963267948966;
    workload ggx;
    if (!make("ggx", &t, &o, &ggx)) give_up("no ggx");
    ff_selection used;
    ff_problem_selection(ggx.problem, &used);
    printf("{\"samples\": %zu, \"passes\": [", used.used);
    char text[256];
    for (size_t i = 0; i < ff_term_count(FF_NDF); i++) {
        const char *name = ff_term_at(FF_NDF, i)->name;
        snprintf(text, sizeof text, "%s/%s", name, ff_ndf_at((int)i)->lambda ? "smith-height-correlated" : "kelemen");
        measure("distribution", name, text, &t, &o, &ggx);
    }
    for (size_t i = 0; i < ff_term_count(FF_MASKING); i++) {
        snprintf(text, sizeof text, "ggx/%s", ff_term_at(FF_MASKING, i)->name);
        measure("masking", ff_term_at(FF_MASKING, i)->name, text, &t, &o, &ggx);
    }
    for (size_t i = 0; i < ff_term_count(FF_FRESNEL); i++) {
        snprintf(text, sizeof text, "ggx/smith-height-correlated/%s", ff_term_at(FF_FRESNEL, i)->name);
        measure("fresnel", ff_term_at(FF_FRESNEL, i)->name, text, &t, &o, &ggx);
    }
    for (size_t i = 0; i < ff_term_count(FF_DIFFUSE); i++) {
        snprintf(text, sizeof text, "ggx+%s", ff_term_at(FF_DIFFUSE, i)->name);
        measure("diffuse", ff_term_at(FF_DIFFUSE, i)->name, text, &t, &o, &ggx);
    }
    printf("\n]}\n");
    done(&ggx);
    ff_table_clear(&t);
    return 0;
}
