/* replay TARGET FOLDER: the corpus of a fuzzer as an ordinary test, and around every file of it: all prefixes, every single bit of
 * its first bytes flipped, bytes at its end. Each must be refused with a message or give a sound table, within a second and 64 MB.
 */
#define _GNU_SOURCE
#include "data_formats/table/table_struct.h"
#include "fuzz_reader.h"
#include "fuzz_text.h"
#include <dirent.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <time.h>

enum { FLIPPED = 1024, ALL_PREFIXES = 16384, SOME_PREFIXES = 1000, MOST_KIB = 64 * 1024 };

/* OpenImageIO 2.4 loses some thirty bytes with every PNG that ends early. */
const char *__lsan_default_suppressions(void);
const char *__lsan_default_suppressions(void)
{
    return "leak:PNGInput::PngReadCallback\n";
}

static double slowest;
static long n_inputs, n_read;

static double seconds(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static long peak_kib(void)
{
    struct rusage u;
    getrusage(RUSAGE_SELF, &u);
    return u.ru_maxrss;
}

static int read_one(const char *target, const uint8_t *data, size_t size)
{
    const int read = fuzz_text(target, data, size);
    return read < 0 ? fuzz_reader(target, data, size) : read;
}

static void try_input(const char *format, const uint8_t *data, size_t size)
{
    const double begin = seconds();
    n_read += read_one(format, data, size);
    n_inputs++;
    const double took = seconds() - begin;
    if (took > slowest) slowest = took;
}

static uint8_t *slurp(const char *path, size_t *n)
{
    FILE *f = fopen(path, "rb");
    if (!f || fseek(f, 0, SEEK_END) != 0) {
        perror(path);
        exit(1);
    }
    *n = (size_t)ftell(f);
    rewind(f);
    uint8_t *bytes = malloc(*n + 16);
    if (!bytes || fread(bytes, 1, *n, f) != *n) exit(1);
    fclose(f);
    return bytes;
}

static void try_prefixes(const char *format, const uint8_t *bytes, size_t n)
{
    const size_t step = n <= ALL_PREFIXES ? 1 : n / SOME_PREFIXES + 1;
    for (size_t k = 0; k < n; k += step) try_input(format, bytes, k);
}

static void try_around(const char *format, const char *path)
{
    size_t n;
    uint8_t *bytes = slurp(path, &n);
    try_input(format, bytes, n);
    try_prefixes(format, bytes, n);
    for (size_t bit = 0; bit < 8 * (n < FLIPPED ? n : FLIPPED); bit++) {
        bytes[bit / 8] ^= (uint8_t)(1u << bit % 8);
        try_input(format, bytes, n);
        bytes[bit / 8] ^= (uint8_t)(1u << bit % 8);
    }
    static const char *const tail[] = {"\0", "\n\n", "1 2 3\n", "\xFF\xFF\xFF\xFF"};
    for (size_t k = 0; k < 4; k++) {
        const size_t length = k == 0 ? 1 : strlen(tail[k]);
        memcpy(bytes + n, tail[k], length);
        try_input(format, bytes, n + length);
    }
    free(bytes);
}

/* The libraries that the format loads with its first file are no fault of a hostile one. */
static void warm_up(const char *format, const char *path)
{
    size_t n;
    uint8_t *bytes = slurp(path, &n);
    read_one(format, bytes, n);
    free(bytes);
}

int main(int argc, char **argv)
{
    long files = 0;
    if (argc != 3) return 2;
    DIR *folder = opendir(argv[2]);
    try_input(argv[1], (const uint8_t *)"", 0);
    long before = 0;
    for (struct dirent *e; folder && (e = readdir(folder));) {
        char path[1024];
        if (e->d_name[0] == '.') continue;
        snprintf(path, sizeof path, "%s/%s", argv[2], e->d_name);
        if (files == 0) {
            warm_up(argv[1], path);
            before = peak_kib();
        }
        try_around(argv[1], path);
        files++;
    }
    if (folder) closedir(folder);
    const long grown = peak_kib() - before;
    printf("%s: %ld files, %ld inputs, %ld of them read; slowest %.3f s, memory grew by %ld KiB\n", argv[1], files, n_inputs,
           n_read, slowest, grown);
    int failed = 0;
    if (files == 0) failed = printf("no corpus in %s\n", argv[2]);
    if (files && n_read == 0) failed = printf("no file of the corpus can be read: it tests nothing\n");
#if !defined(__SANITIZE_ADDRESS__)
    if (slowest > 1) failed = printf("an input took more than a second\n");
    if (grown > MOST_KIB) failed = printf("the inputs took more than %d KiB\n", MOST_KIB);
#endif
    return failed != 0;
}
