/* Speed of the readers: each file in turn read as bytes into fresh memory and as a table, so that a slow minute falls on both.
 * Files are made here, of some ten megabytes, in the folder named on the command line; files named after it are timed as well.
 * Prints JSON: per file its format, bytes, medians of both times and MB/s. For the formats whose values need little arithmetic the
 * bytes are also timed with that arithmetic: a look at every double (merl), floats made doubles (exr), and for a tensor file (rgl)
 * the running sums of its warps and, per sample, the sines, cosines, arc tangents and square roots of its directions and solid
 * angle. */
#define _GNU_SOURCE /* clock_gettime */
#include "data_formats/interpolation/resample_struct.h"
#include "simulate/simulate_struct.h"
#include <fcntl.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

enum { ROUNDS = 9, PATH = 512 };

static void give_up(const char *what)
{
    fprintf(stderr, "bench_readers: %s\n", what);
    exit(1);
}

static double now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* ---- files ----------------------------------------------------------------------------------- */

static FILE *create(const char *folder, const char *name, char path[PATH])
{
    snprintf(path, PATH, "%s/%s", folder, name);
    FILE *f = fopen(path, "w");
    if (!f) give_up(path);
    return f;
}

/* Numbers that look measured, in turn. */
static double value_at(size_t i)
{
    return 0.01 + 5 * exp(-(double)(i % 977) / 60) + 1e-4 * (double)(i % 7919);
}

static void make_text(const char *folder, const char *name, const char *head, size_t rows, void (*row)(FILE *, size_t),
                      const char *tail, char path[PATH])
{
    FILE *f = create(folder, name, path);
    fputs(head, f);
    for (size_t i = 0; i < rows; i++) row(f, i);
    fputs(tail, f);
    if (fclose(f) != 0) give_up(path);
}

static double theta(size_t i)
{
    return (double)(i % 81);
}

static double phi(size_t i)
{
    return (double)(i * 7 % 360);
}

static void cornell_row(FILE *f, size_t i)
{
    fprintf(f, "%.6f %.6f %.6f %.6f", theta(i) / 60, 0.0, theta(3 * i) / 60, phi(i) / 60);
    for (size_t c = 0; c < 31; c++) fprintf(f, " %.6f", value_at(i + 31 * c));
    fputc('\n', f);
}

static void fred_row(FILE *f, size_t i)
{
    fprintf(f, "%g\t%g\t%.6f\n", theta(i), phi(i), value_at(i));
}

static void pgii_row(FILE *f, size_t i)
{
    fprintf(f, "%.5f\t%.5f\t%.3e\n", theta(i) + 0.12345, phi(i) + 0.54321, value_at(i));
}

static void nist_row(FILE *f, size_t i)
{
    fprintf(f, "0.633,%.8f,%.8f,%.8f,%.8f,%.9f", theta(i) + 0.1, phi(i), theta(3 * i) + 0.2, phi(i), value_at(i));
    for (int k = 0; k < 15; k++) fprintf(f, ",%.9f", 1e-3 * value_at(i + 17 * (size_t)k));
    fputc('\n', f);
}

static void planetary_row(FILE *f, size_t i)
{
    fprintf(f, "%06zu, %.2f, %.2f, %.2f, %.2f, %.5f, %.10f, 1.94936, 5, 1584089229.0, 0.0, 450.00, 70.00, 19.40, 20.00, 25.00\n", i,
            (double)(i / 2000 % 8) * 10, theta(i), (double)(i / 81 % 19) * 10, 90.0, value_at(i), 0.01 + 1e-3 * value_at(i));
}

/* A model's values in a format that can be written. */
static void make_table(const char *folder, const char *name, const char *format, const char *sampling, char path[PATH])
{
    ff_model m;
    ff_simulate_options o;
    ff_resample_options ro;
    ff_resample_report report;
    ff_table t, made;
    ff_error err = {0};
    double shape[FF_MAX_SHAPE], channel[3 * FF_MAX_CHANNEL_PARAMS];
    snprintf(path, PATH, "%s/%s", folder, name);
    ff_simulate_options_init(&o);
    ff_resample_options_init(&ro);
    o.relative = 0.01; /* all the digits that measured numbers have */
    o.nonnegative = 1;
    if (ff_model_parse("ggx+lambert", &m, &err) || ff_sampling_parse(sampling, &o.sampling, &err)) give_up(err.message);
    ff_model_defaults(&m, 3, shape, channel);
    if (ff_simulate_into(&m, 3, shape, channel, &o, &t, &err) ||
        ff_resample_into(&t, ff_format_find(format), &ro, &made, &report, &err) || ff_table_write(path, format, &made, &err))
        give_up(err.message);
    ff_table_clear(&t);
    ff_table_clear(&made);
}

/* ---- timing ---------------------------------------------------------------------------------- */

static size_t file_size(const char *path)
{
    struct stat st;
    if (stat(path, &st) != 0) give_up(path);
    return (size_t)st.st_size;
}

static unsigned char *read_bytes(const char *path, size_t n)
{
    unsigned char *bytes = malloc(n);
    const int fd = open(path, O_RDONLY);
    size_t done = 0;
    if (!bytes || fd < 0) give_up(path);
    while (done < n) {
        const ssize_t got = read(fd, bytes + done, n - done);
        if (got <= 0) give_up(path);
        done += (size_t)got;
    }
    close(fd);
    return bytes;
}

static volatile double sink; /* keeps the compiler from leaving the arithmetic out */

/* Bits of numbers that are none, and signs. */
static void look_at_doubles(const unsigned char *bytes, size_t n)
{
    uint64_t any = 0, sign = 0;
    for (size_t i = 12; i + 8 <= n; i += 8) {
        uint64_t u;
        memcpy(&u, bytes + i, 8);
        any |= (u & UINT64_C(0x7FFFFFFFFFFFFFFF)) + UINT64_C(0x0010000000000000);
        sign += u >> 63;
    }
    sink = (double)(any + sign);
}

static void make_doubles(const unsigned char *bytes, size_t n)
{
    double *v = malloc(n / 4 * sizeof *v);
    if (!v) give_up("no memory");
    for (size_t i = 0; i < n / 4; i++) {
        float x;
        memcpy(&x, bytes + 4 * i, 4);
        v[i] = x;
    }
    sink = v[n / 8];
    free(v);
}

static void warp(const unsigned char *bytes, size_t n, size_t samples)
{
    double sum = 0, *running = malloc(n / 4 * sizeof *running);
    if (!running) give_up("no memory");
    for (size_t i = 0; i < n / 4; i++) {
        float x;
        memcpy(&x, bytes + 4 * i, 4);
        sum += fabsf(x);
        running[i] = sum;
    }
    for (size_t i = 0; i < samples; i++) {
        const double u = (double)i / (double)samples, x = sqrt(u) + sqrt(1 - u), theta = 1.5 * x * x, phi = 6 * u;
        const double y = sin(theta) * cos(phi), z = sin(theta) * sin(phi);
        const double edge = theta + 0.01; /* of the sample's solid angle */
        sum += atan2(sqrt(y * y + z * z), cos(theta)) + atan2(z, y) + edge - sin(edge) * cos(edge);
    }
    sink = sum + running[n / 8];
    free(running);
}

/* What cannot be left out. */
static void arithmetic(const char *format, const unsigned char *bytes, size_t n, size_t samples)
{
    if (strcmp(format, "merl") == 0) look_at_doubles(bytes, n);
    if (strcmp(format, "exr") == 0) make_doubles(bytes, n);
    if (strcmp(format, "rgl") == 0) warp(bytes, n, samples);
}

static double bytes_seconds(const char *path, size_t n, const char *format, size_t samples)
{
    const double begin = now();
    unsigned char *bytes = read_bytes(path, n);
    if (format) arithmetic(format, bytes, n, samples);
    free(bytes);
    return now() - begin;
}

static double table_seconds(const char *path, const char *format, size_t *samples)
{
    ff_table t;
    ff_read_options o;
    ff_error err = {0};
    const double begin = now();
    ff_read_options_init(&o);
    o.format = format;
    if (format && strcmp(format, "pgii") == 0) o.scale = 1;
    if (ff_table_read_with_into(path, &o, &t, &err) != FF_OK) give_up(err.message);
    *samples = t.n;
    ff_table_clear(&t);
    return now() - begin;
}

static int ascending(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static double median(double *x)
{
    qsort(x, ROUNDS, sizeof *x, ascending);
    return x[ROUNDS / 2];
}

static void time_file(const char *path, int first)
{
    const ff_format *f = NULL;
    ff_error err = {0};
    double bytes[ROUNDS], with_arithmetic[ROUNDS], table[ROUNDS];
    if (ff_format_detect(path, &f, &err) != FF_OK) give_up(err.message);
    const size_t n = file_size(path);
    size_t samples;
    table_seconds(path, f->name, &samples); /* once to warm up */
    for (int k = 0; k < ROUNDS; k++) {
        bytes[k] = bytes_seconds(path, n, NULL, 0);
        with_arithmetic[k] = bytes_seconds(path, n, f->name, samples);
        table[k] = table_seconds(path, f->name, &samples);
    }
    const double b = median(bytes), a = median(with_arithmetic), t = median(table);
    printf("%s\n  {\"file\": \"%s\", \"format\": \"%s\", \"bytes\": %zu, \"read_bytes_s\": %.6g, \"with_arithmetic_s\": %.6g, "
           "\"table_s\": %.6g, "
           "\"mb_per_s\": %.1f}",
           first ? "" : ",", strrchr(path, '/') ? strrchr(path, '/') + 1 : path, f->name, n, b, a, t, (double)n / t / 1e6);
    fflush(stdout);
}

int main(int argc, char **argv)
{
    static const struct {
        const char *name, *head, *tail;
        size_t rows;
        void (*row)(FILE *, size_t);
    } texts[] = {
        {"bench.brdf",
         "31\n400 410 420 430 440 450 460 470 480 490 500 510 520 530 540 550 560 570 580 590 600 610 620 630 640 650 660 670 680 "
         "690 "
         "700\n",
         "", 60000, cornell_row},
        {"bench_fred.txt", "type bsdf_data\nformat angles=deg bsdf=value scale=1\n10\t0\n", "", 1000000, fred_row},
        {"bench_pgii.txt", "#pgII data\n#incident_angle\t30\t0\n#intheta\t30\n#inphi\t0\n#format: theta\tphi\tBSDF\n", "", 600000,
         pgii_row},
        {"bench_nist.csv",
         "lambda,thetai,phii,thetar,phir,f_r11,f_r12/f_r11,f_r13/f_r11,f_r14/f_r11,f_r21/f_r11,f_r22/f_r11,f_r23/f_r11,f_r24/f_r11,"
         "f_r31/f_r11,f_r32/f_r11,f_r33/f_r11,f_r34/f_r11,f_r41/f_r11,f_r42/f_r11,f_r43/f_r11,f_r44/f_r11\n",
         "", 80000, nist_row},
        {"bench_planetary.csv",
         "# 'counter', 'incidence', 'emission', 'azimuth', 'phase', 'reflectance_factor', 'standard_deviation', 'error_estimate', "
         "'quality_flag', 'absolute_time', 'relative_time', 'bandpass_central', 'bandpass_FWHM', 'sample_temperature', "
         "'monochromator_temperature', 'humidity'\n",
         "", 120000, planetary_row},
    };
    static const struct {
        const char *name, *format, *sampling;
    } tables[] = {{"bench.binary", "merl", "merl"},
                  {"bench.exr", "exr", "merl"},
                  {"bench.csv", "csv", "scattered:150000"},
                  {"bench.astm", "astm", "scattered:150000"},
                  {"bench.alta", "alta", "scattered:150000"}};
    char path[PATH];
    if (argc < 2) give_up("usage: bench_readers FOLDER [FILE ...]");
    printf("{\"files\": [");
    for (size_t k = 0; k < sizeof tables / sizeof tables[0]; k++) {
        make_table(argv[1], tables[k].name, tables[k].format, tables[k].sampling, path);
        time_file(path, k == 0);
        unlink(path);
    }
    for (size_t k = 0; k < sizeof texts / sizeof texts[0]; k++) {
        make_text(argv[1], texts[k].name, texts[k].head, texts[k].rows, texts[k].row, texts[k].tail, path);
        time_file(path, 0);
        unlink(path);
    }
    for (int k = 2; k < argc; k++) time_file(argv[k], 0);
    printf("\n]}\n");
    return 0;
}
