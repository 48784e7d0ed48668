/* bench_weights MODEL FILE...: does a fit by the noise foretell incidences that it has not seen better than one by the cosine?
 * Every file is fitted five times without every fifth incidence (of three or four, every single one), with either weights, and what
 * was left out is looked at: root mean square of the cosine-weighted and of the logarithmic residual, median of |f - y| / y over
 * values above a thousandth of the largest. A row a file: those of the default weights, and those by the noise over them; below,
 * the geometric means of the ratios. No measurement of time: this is what the default rests on (reports/weights.txt). */
#include "base/internal_order.h"
#include "data_formats/table/table_struct.h"
#include "fit/trust/trust_struct.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { MOST_FOLDS = 5, FEWEST = 3, MEASURES = 3 };
static const char *const measure_name[MEASURES] = {"cosine rmse", "log rmse", "median |f-y|/y"};

/* Sums over what was held out, of all folds. */
typedef struct held_out {
    size_t folds;
    double sum[2], count;
    double *relative; /* of values above the floor */
    size_t n_relative;
} held_out;

/* Adds what the fit leaves at the samples of the fold. */
static void look(const ff_table *t, const ff_places *places, const uint32_t *index, size_t fold, const ff_fit_result *r,
                 double floor, held_out *out)
{
    const size_t C = t->n_channels;
    double shape[FF_MAX_SHAPE], *channel = malloc(C * r->model.n_channel * sizeof *channel), *f = malloc(C * sizeof *f);
    if (!channel || !f) exit(1);
    ff_fit_result_values(r, shape, channel);
    for (size_t i = 0; i < places->n; i++) {
        if (places->direction[i] % out->folds != fold) continue;
        double w[6], y;
        const ff_dirs d = {w, w + 1, w + 2, w + 3, w + 4, w + 5};
        double *const planes[6] = {w, w + 1, w + 2, w + 3, w + 4, w + 5};
        ff_table_directions(t, index[i], 1, planes);
        if (ff_model_eval(&r->model, FF_ISA_BEST, C, shape, channel, &d, 1, f, NULL, 1)) exit(1);
        for (size_t c = 0; c < C; c++) {
            ff_table_values(t, c, index[i], 1, &y);
            const double e = f[c] - y, l = log1p(fmax(f[c], 0) * w[2]) - log1p(fmax(y, 0) * w[2]);
            out->sum[0] += e * e * w[2] * w[2];
            out->sum[1] += l * l;
            out->count++;
            if (y > floor) out->relative[out->n_relative++] = fabs(e) / y;
        }
    }
    free(channel);
    free(f);
}

static int one_fold(ff_table *t, const ff_model *m, const ff_places *places, const uint32_t *index, size_t fold, double floor,
                    held_out out[2])
{
    ff_fit_options o;
    ff_problem *p = NULL;
    ff_fit_result first = {.n_channels = 0}, second = {.n_channels = 0};
    unsigned char *valid = malloc(t->n);
    if (!valid) exit(1);
    ff_fit_options_init(&o);
    o.weighting = FF_WEIGHT_NOISE; /* a column of standard deviations is not looked at */
    memcpy(valid, t->valid, t->n);
    for (size_t i = 0; i < places->n; i++)
        if (places->direction[i] % out->folds == fold) t->valid[index[i]] = 0;
    ff_status status = ff_problem_make(t, m, 1, &o, &p, NULL);
    if (!status) status = ff_problem_fit_into(p, m, &o, &first, NULL);
    if (!status) status = ff_problem_weigh_by_noise(p, &o, &first, NULL);
    if (!status) status = ff_problem_fit_into(p, m, &o, &second, NULL);
    memcpy(t->valid, valid, t->n);
    if (!status) {
        look(t, places, index, fold, &first, floor, &out[0]);
        look(t, places, index, fold, &second, floor, &out[1]);
    }
    ff_fit_result_clear(&first);
    ff_fit_result_clear(&second);
    ff_problem_free(p);
    free(valid);
    return status == FF_OK;
}

static double measure(held_out *h, int k)
{
    if (k < 2) return sqrt(h->sum[k] / h->count);
    qsort(h->relative, h->n_relative, sizeof *h->relative, ff_ascending);
    return h->n_relative ? h->relative[h->n_relative / 2] : NAN;
}

/* The ratios, NaN where there is none. */
static void one_file(const char *path, const ff_model *m, double ratio[MEASURES])
{
    ff_table t;
    ff_places places;
    ff_error err = {0};
    ff_fit_options o;
    ff_problem *p = NULL;
    held_out out[2];
    const char *slash = strrchr(path, '/');
    memset(out, 0, sizeof out);
    for (int k = 0; k < MEASURES; k++) ratio[k] = NAN;
    if (ff_table_read_into(path, NULL, &t, &err)) {
        printf("%-32s %s\n", slash ? slash + 1 : path, err.message);
        return;
    }
    ff_fit_options_init(&o);
    ff_status status = ff_problem_make(&t, m, 1, &o, &p, &err);
    if (!status) status = ff_places_init(p, &t, &places, &err);
    double largest = 0;
    for (size_t c = 0; c < t.n_channels && !status; c++)
        for (size_t i = 0; i < places.n; i++) {
            double y;
            ff_table_values(&t, c, ff_problem_index(p)[i], 1, &y);
            largest = fmax(largest, y);
        }
    if (!status && places.n_directions >= FEWEST) {
        int done = 1;
        for (int k = 0; k < 2; k++) out[k].folds = places.n_directions < MOST_FOLDS ? places.n_directions : MOST_FOLDS;
        for (int k = 0; k < 2; k++) out[k].relative = malloc(places.n * t.n_channels * sizeof(double));
        if (!out[0].relative || !out[1].relative) exit(1);
        for (size_t fold = 0; fold < out->folds && done; fold++)
            done = one_fold(&t, m, &places, ff_problem_index(p), fold, 1e-3 * largest, out);
        if (done) {
            printf("%-32s %9zu %5zu %4zu", slash ? slash + 1 : path, places.n, places.n_directions, t.n_channels);
            for (int k = 0; k < MEASURES; k++) {
                const double a = measure(&out[0], k), b = measure(&out[1], k);
                ratio[k] = b / a;
                printf("  %10.4g %7.3f", a, ratio[k]);
            }
            printf("\n");
        }
        if (!done) printf("%-32s a fold could not be fitted\n", slash ? slash + 1 : path);
        free(out[0].relative);
        free(out[1].relative);
    } else {
        printf("%-32s %s\n", slash ? slash + 1 : path, status ? err.message : "too few incidences");
    }
    fflush(stdout);
    if (!status) ff_places_clear(&places);
    ff_problem_free(p);
    ff_table_clear(&t);
}

int main(int argc, char **argv)
{
    ff_model m;
    ff_error err = {0};
    double sum[MEASURES] = {0}, ratio[MEASURES];
    int better[MEASURES] = {0}, n = 0;
    if (argc < 3 || ff_model_parse(argv[1], &m, &err)) {
        fprintf(stderr, "usage: bench_weights MODEL FILE...\n");
        return 2;
    }
    printf("%s, held-out incidences: default weights, and weights by the noise over them\n", argv[1]);
    printf("%-32s %9s %5s %4s", "file", "samples", "inc.", "ch.");
    for (int k = 0; k < MEASURES; k++) printf("  %18s", measure_name[k]);
    printf("\n");
    for (int i = 2; i < argc; i++) {
        one_file(argv[i], &m, ratio);
        if (isnan(ratio[0] + ratio[1] + ratio[2])) continue;
        n++;
        for (int k = 0; k < MEASURES; k++) {
            sum[k] += log(ratio[k]);
            better[k] += ratio[k] < 1;
        }
    }
    printf("%-32s %21s", "geometric mean", "");
    for (int k = 0; k < MEASURES; k++) printf("  %18.3f", n ? exp(sum[k] / n) : NAN);
    printf("\n%-32s %21s", "files better by the noise", "");
    for (int k = 0; k < MEASURES; k++) printf("  %11d of %3d", better[k], n);
    printf("\n");
    return 0;
}
