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
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { FF_TEST_SKIPPED = 77, FF_TEST_SHOWN = 20 };

typedef struct ff_test_case {
    const char *name;
    void (*run)(void);
} ff_test_case;

/** Counters of this program; a test is one file, hence one copy. */
typedef struct ff_test_counts {
    long checks, failures;
    int skipped; /**< the function that runs now has called FF_SKIP */
} ff_test_counts;
static ff_test_counts ff_test_count;

/** Counts a failure; the first FF_TEST_SHOWN are printed, so that a check inside a loop does not flood the log. */
static inline int ff_test_failed(const char *file, int line, const char *what)
{
    ff_test_count.failures++;
    if (ff_test_count.failures == FF_TEST_SHOWN + 1) printf("  (further failures are counted, not shown)\n");
    if (ff_test_count.failures > FF_TEST_SHOWN) return 0;
    printf("%s:%d: failed: %s\n", file, line, what);
    return 1;
}

/** FF_CHECK(condition, format, ...): when the condition does not hold, prints it with the message and counts a failure. */
#define FF_CHECK(cond, ...)                                                                                                        \
    do {                                                                                                                           \
        ff_test_count.checks++;                                                                                                    \
        if (!(cond) && ff_test_failed(__FILE__, __LINE__, #cond)) {                                                                \
            printf("    ");                                                                                                        \
            printf(__VA_ARGS__);                                                                                                   \
            printf("\n");                                                                                                          \
        }                                                                                                                          \
    } while (0)

/** FF_CHECK_CLOSE(a, b, rel, abs): |a - b| <= max(rel |b|, abs). A NaN is close to nothing. */
#define FF_CHECK_CLOSE(a, b, rel, abs) ff_test_close(__FILE__, __LINE__, #a " ~ " #b, (a), (b), (rel), (abs))

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
