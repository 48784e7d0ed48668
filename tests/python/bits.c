/* python_bits EXPRESSION CHANNELS N ASSIGNMENT... < directions > values: f and its derivatives as ff_model_eval gives them, raw
 * doubles. directions: six planes of N; out: f [CHANNELS][N], then df [CHANNELS][parameters][N]. */
#include "ff_model.h"
#include <stdio.h>
#include <stdlib.h>

static int fail(const char *what)
{
    fprintf(stderr, "%s\n", what);
    return 1;
}

static int write_values(const ff_model *m, size_t channels, size_t n, int argc, char **argv)
{
    const size_t n_shape = ff_model_param_count(m, FF_PARAM_SHAPE), n_channel = ff_model_param_count(m, FF_PARAM_CHANNEL);
    const size_t columns = n_shape + n_channel;
    double *shape = calloc(n_shape + 1, sizeof *shape), *channel = calloc(channels * n_channel + 1, sizeof *channel);
    double *w = calloc(6 * n, sizeof *w), *f = calloc(channels * n, sizeof *f), *df = calloc(channels * columns * n, sizeof *df);
    ff_error err = {0};
    int failed = !shape || !channel || !w || !f || !df || fread(w, sizeof *w, 6 * n, stdin) != 6 * n;
    if (!failed) ff_model_defaults(m, channels, shape, channel);
    for (int k = 4; k < argc && !failed; k++) failed = ff_model_set(m, channels, argv[k], shape, channel, &err) != FF_OK;
    const ff_dirs dirs = {w, w + n, w + 2 * n, w + 3 * n, w + 4 * n, w + 5 * n};
    if (!failed) failed = ff_model_eval(m, FF_ISA_BEST, channels, shape, channel, &dirs, n, f, df, n) != FF_OK;
    if (!failed) failed = fwrite(f, sizeof *f, channels * n, stdout) != channels * n;
    if (!failed) failed = fwrite(df, sizeof *df, channels * columns * n, stdout) != channels * columns * n;
    free(shape), free(channel), free(w), free(f), free(df);
    return failed ? fail(err.message) : 0;
}

int main(int argc, char **argv)
{
    ff_model *m;
    ff_error err = {0};
    if (argc < 4) return fail("usage: python_bits EXPRESSION CHANNELS N ASSIGNMENT...");
    if (ff_model_new(argv[1], &m, &err)) return fail(err.message);
    const int failed = write_values(m, strtoul(argv[2], NULL, 10), strtoul(argv[3], NULL, 10), argc, argv);
    ff_model_free(m);
    return failed;
}
