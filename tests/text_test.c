/* Numbers as the reports print them: as many digits as the standard error has something to say about. Names as they may be printed.
 */
#include "ff_test.h"
#include "report/internal_text.h"

typedef struct pair {
    double value, error;
    const char *printed, *printed_error;
} pair;

static void check(const pair *p, size_t n)
{
    char value[FF_TEXT_NUMBER], error[FF_TEXT_NUMBER];
    for (size_t i = 0; i < n; i++) {
        ff_text_with_error(p[i].value, p[i].error, value, error);
        FF_CHECK(!strcmp(value, p[i].printed) && !strcmp(error, p[i].printed_error),
                 "%.17g +- %.17g: found %s +- %s, expected %s +- %s", p[i].value, p[i].error, value, error, p[i].printed,
                 p[i].printed_error);
    }
}

/* Two digits of the error, and the value to the second of them. */
static void errors_decide(void)
{
    static const pair of[] = {
        {0.412345, 0.00123, "0.4123", "0.0012"}, {-0.412345, 0.0123, "-0.412", "0.012"},
        {12.3456, 1.23, "12.3", "1.2"},          {123.456, 12.3, "123", "12"},
        {0, 0.0123, "0.000", "0.012"},           {1, 1e-10, "1.00000000000", "1e-10"},
    };
    check(of, sizeof of / sizeof *of);
}

/* A carry into one more digit in front of the point changes none of those behind it. */
static void rounding_carries(void)
{
    static const pair of[] = {
        {9.99996, 0.0123, "10.000", "0.012"},  {0.99996, 0.0123, "1.000", "0.012"}, {99.96, 1.23, "100.0", "1.2"},
        {999999.96, 1.23, "1000000.0", "1.2"}, {9999996, 12.3, "9999996", "12"},
    };
    check(of, sizeof of / sizeof *of);
}

/* Too large or too small for a point: the same digits with an exponent, and never fewer than one nor more than twelve. */
static void exponents(void)
{
    static const pair of[] = {
        {1234567, 2345, "1.2346e+06", "2.3e+03"},
        {-1234567, 234567, "-1.23e+06", "2.3e+05"},
        {3.45678e-5, 1.2e-7, "3.457e-05", "1.2e-07"},
        {123456.789, 1234, "1.235e+05", "1.2e+03"},
        {3e-5, 12, "3e-05", "12"},
        {1.0 / 3, 1e-15, "0.333333333333", "1e-15"},
        {1.0 / 3 * 1e7, 1e-15, "3333333.33333", "1e-15"},
    };
    check(of, sizeof of / sizeof *of);
}

/* Without an error, or with one that is none. */
static void no_error(void)
{
    static const pair of[] = {
        {0.123456789, NAN, "0.123457", "-"},
        {0.123456789, INFINITY, "0.123457", "-"},
        {0.123456789, -1, "0.123457", "-"},
        {0.123456789, 0, "0.123457", "0"},
        {NAN, 0.1, "nan", "0.1"},
    };
    check(of, sizeof of / sizeof *of);
}

/* What speaks to a terminal, breaks a line or turns the reading about; and all else as it is. */
static void text_of_others(void)
{
    static const char *const of[][2] = {
        {"a b.csv", "a b.csv"},
        {"caf\xc3\xa9 \xe6\xb8\xac \xf0\x9f\x98\x80", "caf\xc3\xa9 \xe6\xb8\xac \xf0\x9f\x98\x80"},
        {"\x1b[31m", "\\x1b[31m"},
        {"a\nb\r\t\x7f", "a\\x0ab\\x0d\\x09\\x7f"},
        {"\xc2\x80\xc2\x9b\xc2\x9f\xc2\xa0", "\\xc2\\x80\\xc2\\x9b\\xc2\\x9f\xc2\xa0"},
        {"\xe2\x80\xa8\xe2\x80\xae\xe2\x81\xa9", "\\xe2\\x80\\xa8\\xe2\\x80\\xae\\xe2\\x81\\xa9"},
        {"\xff\xc3", "\\xff\\xc3"},
        {"\xc0\x9b\xed\xa0\x80", "\\xc0\\x9b\\xed\\xa0\\x80"},
        {"", ""},
    };
    for (size_t i = 0; i < sizeof of / sizeof *of; i++) {
        char out[128] = "";
        FILE *memory = fmemopen(out, sizeof out, "w");
        if (!FF_CHECK(memory != NULL, "fmemopen")) return;
        ff_text_print(of[i][0], memory);
        fclose(memory);
        FF_CHECK(!strcmp(out, of[i][1]), "%zu: found %s, expected %s", i, out, of[i][1]);
    }
}

FF_TEST_MAIN(FF_TEST(errors_decide), FF_TEST(rounding_carries), FF_TEST(exponents), FF_TEST(no_error), FF_TEST(text_of_others))
