/** @file ff_test.h  A C test in one file: checks that count and go on, named test functions, skips that say what is missing.
 *
 *      #include "ff_test.h"
 *      static void sums(void) { FF_CHECK(1 + 1 == 2, "arithmetic is broken"); }
 *      FF_TEST_MAIN(FF_TEST(sums))
 *
 *  The program runs every function, or those named on its command line; it returns 0 when all checks held, 1 when one failed
 *  or a name is unknown, FF_TEST_SKIPPED when every function it ran was skipped. A file tests/NAME_test.c is a test as soon as it
 * exists. */
#ifndef FF_TEST_H
#define FF_TEST_H
#ifndef _GNU_SOURCE
#define _GNU_SOURCE /* mkdtemp, strtok_r, nanosleep: include this file first */
#endif
#include <math.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { FF_TEST_SKIPPED = 77, FF_TEST_SHOWN = 20 };

#ifdef __GNUC__
#define FF_TEST_PRINTF(text, first) __attribute__((format(printf, text, first)))
#else
#define FF_TEST_PRINTF(text, first)
#endif

typedef struct ff_test_case {
    const char *name;
    void (*run)(void);
} ff_test_case;

/** Counters of this program; a test is one file, hence one copy. */
typedef struct ff_test_counts {
    long checks, failures;
    int skipped;     /**< the function that runs now has called FF_SKIP */
    uint64_t random; /**< its stream                                    */
} ff_test_counts;
static ff_test_counts ff_test_count;

/** Where a check stands, and how often it was reached: with $FF_TEST_SITES set the program lists those that no run of it came to,
 * in a loop of no turns or under a condition that never holds. The linker gathers the places; 32 bytes each, without gaps. */
#if defined(__GNUC__) && !defined(__cplusplus) && !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__) &&               \
    defined(__linux__)
typedef struct ff_test_site {
    const char *file;
    long line, reached, unused;
} ff_test_site;
extern ff_test_site __start_ff_test_sites[], __stop_ff_test_sites[];
#define FF_TEST_SITE                                                                                                               \
    __extension__({                                                                                                                \
        static ff_test_site site __attribute__((section("ff_test_sites"), aligned(32))) = {__FILE__, __LINE__, 0, 0};              \
        site.reached++;                                                                                                            \
    })

static inline void ff_test_unreached(void)
{
    for (const ff_test_site *s = __start_ff_test_sites; getenv("FF_TEST_SITES") && s < __stop_ff_test_sites; s++)
        if (s->reached == 0) printf("never reached: %s:%ld\n", s->file, s->line);
}
#else
#define FF_TEST_SITE (void)0
static inline void ff_test_unreached(void)
{
}
#endif

/** Whether the long tier asks, by $FF_TEST_THOROUGH: what an ordinary run draws a part of it then does whole. */
static inline int ff_test_is_thorough(void)
{
    const char *set = getenv("FF_TEST_THOROUGH");
    return set && *set;
}

/** Counts a failure; the first FF_TEST_SHOWN are printed, so that a check inside a loop does not flood the log. */
static inline int ff_test_failed(const char *file, int line, const char *what)
{
    ff_test_count.failures++;
    if (ff_test_count.failures == FF_TEST_SHOWN + 1) printf("  (further failures are counted, not shown)\n");
    if (ff_test_count.failures > FF_TEST_SHOWN) return 0;
    printf("%s:%d: failed: %s\n", file, line, what);
    return 1;
}

/** The two ends of a check: 1, and 0 with the message. */
static inline int ff_test_held(void)
{
    ff_test_count.checks++;
    return 1;
}

FF_TEST_PRINTF(4, 5) static inline int ff_test_broken(const char *file, int line, const char *what, const char *format, ...)
{
    va_list args;
    ff_test_count.checks++;
    if (!ff_test_failed(file, line, what)) return 0;
    va_start(args, format);
    printf("    ");
    vprintf(format, args);
    printf("\n");
    va_end(args);
    return 0;
}

/** FF_CHECK(condition, format, ...): when the condition does not hold, prints it with the message and counts a failure. An
 *  expression, 1 when it holds; the message is not evaluated then. */
#define FF_CHECK(cond, ...) (FF_TEST_SITE, (cond) ? ff_test_held() : ff_test_broken(__FILE__, __LINE__, #cond, __VA_ARGS__))

/** FF_CHECK_CLOSE(a, b, rel, abs): |a - b| <= max(rel |b|, abs). A NaN is close to nothing. */
#define FF_CHECK_CLOSE(a, b, rel, abs) FF_TEST_SITE, ff_test_close(__FILE__, __LINE__, #a " ~ " #b, (a), (b), (rel), (abs))

static inline void ff_test_close(const char *file, int line, const char *what, double a, double b, double rel, double abs)
{
    const double error = fabs(a - b);
    ff_test_count.checks++;
    if (error <= fmax(rel * fabs(b), abs) || (isinf(a) && a == b)) return;
    if (ff_test_failed(file, line, what))
        printf("    %.17g and %.17g differ by %.3g, allowed are %.3g relative, %.3g absolute\n", a, b, error, rel, abs);
}

/** FF_SKIP(format, ...): leaves the test function; the message says what is missing. */
#define FF_SKIP(...)                                                                                                               \
    do {                                                                                                                           \
        printf("skipped: ");                                                                                                       \
        printf(__VA_ARGS__);                                                                                                       \
        printf("\n");                                                                                                              \
        ff_test_count.skipped = 1;                                                                                                 \
        return;                                                                                                                    \
    } while (0)

/* ---- random numbers -------------------------------------------------------------------------- */

/** The seed of this run, $FF_TEST_SEED: 0 when it is not set. */
static inline uint64_t ff_test_seed(void)
{
    const char *seed = getenv("FF_TEST_SEED");
    return seed ? strtoull(seed, NULL, 10) : 0;
}

/** A state that a test has chosen, moved by the seed of the run; with seed 0 it stays what it is. */
static inline uint64_t ff_test_seeded(uint64_t state)
{
    uint64_t z = ff_test_seed() * UINT64_C(0x9e3779b97f4a7c15);
    z = (z ^ (z >> 30)) * UINT64_C(0xbf58476d1ce4e5b9);
    z = (z ^ (z >> 27)) * UINT64_C(0x94d049bb133111eb);
    return state + (z ^ (z >> 31));
}

/** ff_test_stream(format, ...): where the random numbers of the case of that name start. A function of the name and of the seed
 *  of the run alone: what is registered, what ran before and in which order change nothing. FNV-1a, 64 bits. */
FF_TEST_PRINTF(1, 2) static inline uint64_t ff_test_stream(const char *format, ...)
{
    char name[1024];
    uint64_t h = UINT64_C(0xcbf29ce484222325);
    va_list args;
    va_start(args, format);
    vsnprintf(name, sizeof name, format, args);
    va_end(args);
    for (const char *c = name; *c; c++) h = (h ^ (unsigned char)*c) * UINT64_C(0x100000001b3);
    return ff_test_seeded(h);
}

/** The next number of the stream of the test function that runs now, which is named by it. SplitMix64 (Steele, Lea and Flood 2014).
 */
static inline uint64_t ff_test_next(uint64_t *state)
{
    uint64_t z = *state += UINT64_C(0x9e3779b97f4a7c15);
    z = (z ^ (z >> 30)) * UINT64_C(0xbf58476d1ce4e5b9);
    z = (z ^ (z >> 27)) * UINT64_C(0x94d049bb133111eb);
    return z ^ (z >> 31);
}
static inline uint64_t ff_test_random(void)
{
    return ff_test_next(&ff_test_count.random);
}

/** ff_test_drawn(one_in, format, ...): whether the case of that name, of many alike, is tried: one in so many, by its name and the
 *  seed of the run; every one in the long tier. */
FF_TEST_PRINTF(2, 3) static inline int ff_test_drawn(unsigned one_in, const char *format, ...)
{
    char name[1024];
    va_list args;
    va_start(args, format);
    vsnprintf(name, sizeof name, format, args);
    va_end(args);
    uint64_t state = ff_test_stream("drawn %s", name);
    return ff_test_is_thorough() || ff_test_next(&state) % one_in == 0;
}

/** ff_test_turn(one_in, k, name): whether the k-th of a list of cases is tried: one of every so many that follow each other, of
 * which the name and the seed of the run say which; every one in the long tier. */
static inline int ff_test_turn(unsigned one_in, size_t k, const char *name)
{
    uint64_t state = ff_test_stream("turn of %s", name);
    return ff_test_is_thorough() || k % one_in == ff_test_next(&state) % one_in;
}

/** In [0, 1). */
static inline double ff_test_uniform(void)
{
    return (double)(ff_test_random() >> 11) * 0x1p-53;
}

/* ---- files ----------------------------------------------------------------------------------- */

/** The directory of this program's files, which goes away with it; made by the first ff_test_path. */
static char ff_test_dir[64];

static inline void ff_test_remove_dir(void)
{
    char command[96];
    snprintf(command, sizeof command, "rm -rf '%s'", ff_test_dir);
    if (system(command) != 0) fprintf(stderr, "%s is left behind\n", ff_test_dir);
}

/** Path of a file in it; one of a few rotating buffers. */
static inline const char *ff_test_path(const char *name)
{
    static char paths[8][160];
    static int next;
    if (!ff_test_dir[0]) {
        strcpy(ff_test_dir, "/tmp/facetfit-test-XXXXXX");
        if (!mkdtemp(ff_test_dir)) {
            perror(ff_test_dir);
            exit(1);
        }
        atexit(ff_test_remove_dir);
    }
    char *path = paths[next++ % 8];
    snprintf(path, sizeof paths[0], "%s/%s", ff_test_dir, name);
    return path;
}

static inline void ff_test_write(const char *path, const void *bytes, size_t n)
{
    FILE *f = fopen(path, "wb");
    if (!f || fwrite(bytes, 1, n, f) != n || fclose(f) != 0) {
        perror(path);
        exit(1);
    }
}

/** The whole file, malloc'ed and '\0'-terminated. */
static inline char *ff_test_slurp(const char *path, size_t *n)
{
    FILE *f = fopen(path, "rb");
    if (!f) {
        perror(path);
        exit(1);
    }
    fseek(f, 0, SEEK_END);
    *n = (size_t)ftell(f);
    rewind(f);
    char *bytes = (char *)malloc(*n + 1);
    if (!bytes || fread(bytes, 1, *n, f) != *n) exit(1);
    bytes[*n] = '\0';
    fclose(f);
    return bytes;
}

/* ---- material -------------------------------------------------------------------------------- */

/** Path of a file of the shared material into out [size]: "data/astm/C9_Gold.astm", "golden/specular.csv", "tools/make_merl.py".
 *  It lies beside the project (FF_SHARED, a compile definition); when $FACETFIT_DATA is set, that is the data directory and the
 *  others are its neighbours. Returns 1 when it can be read, else 0: the test is skipped then. */
static inline int ff_test_shared(const char *name, char *out, size_t size)
{
    const char *data = getenv("FACETFIT_DATA");
    if (data == NULL || data[0] == '\0') {
        snprintf(out, size, "%s/%s", FF_SHARED, name);
    } else if (strncmp(name, "data/", 5) == 0) {
        snprintf(out, size, "%s/%s", data, name + 5);
    } else {
        snprintf(out, size, "%s/../%s", data, name);
    }
    return access(out, R_OK) == 0;
}

static inline int ff_test_wanted(const char *name, int argc, char **argv)
{
    for (int i = 1; i < argc; i++) {
        if (strcmp(argv[i], name) == 0) return 1;
    }
    return argc < 2;
}

static inline int ff_test_main(const ff_test_case *cases, size_t n, int argc, char **argv)
{
    size_t run = 0, skipped = 0;
    setvbuf(stdout, NULL, _IOLBF, 0); /* what was printed before a crash is in the log */
    for (size_t i = 0; i < n; i++) {
        const long failures = ff_test_count.failures, checks = ff_test_count.checks;
        if (!ff_test_wanted(cases[i].name, argc, argv)) continue;
        ff_test_count.skipped = 0;
        ff_test_count.random = ff_test_stream("%s", cases[i].name);
        cases[i].run();
        run++;
        skipped += (size_t)ff_test_count.skipped;
        if (!ff_test_count.skipped && ff_test_count.checks == checks)
            ff_test_failed(cases[i].name, 0, "a test that checks nothing");
        printf("%-9s %s (%ld checks)\n",
               ff_test_count.failures > failures ? "FAILED"
               : ff_test_count.skipped           ? "skipped"
                                                 : "passed",
               cases[i].name, ff_test_count.checks - checks);
    }
    ff_test_unreached();
    printf("%ld checks, %ld failures\n", ff_test_count.checks, ff_test_count.failures);
    if (run == 0) {
        printf("no test of that name\n");
        return 1;
    }
    if (ff_test_count.failures > 0) return 1;
    return skipped == run ? FF_TEST_SKIPPED : 0;
}

#define FF_TEST(function)                                                                                                          \
    {                                                                                                                              \
#function, function                                                                                                        \
    }
#define FF_TEST_MAIN(...)                                                                                                          \
    static const ff_test_case ff_test_cases[] = {__VA_ARGS__};                                                                     \
    int main(int argc, char **argv)                                                                                                \
    {                                                                                                                              \
        return ff_test_main(ff_test_cases, sizeof ff_test_cases / sizeof ff_test_cases[0], argc, argv);                            \
    }
#endif
