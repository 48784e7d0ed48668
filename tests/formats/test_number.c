/* Numbers: reading is correctly rounded (the C library is the second source), writing reads back as the same bits and is short. */
#include "check_table.h"
#include "base/internal_number.h"
#include "base/internal_tokens.h"

static void compare(const char *text)
{
    double mine = -99, theirs = strtod(text, NULL); /* the program runs in the C locale */
    const char *end = ff_number_read(text, &mine);
    FF_CHECK(end && *end == '\0', "'%s' is not read to its end", text);
    FF_CHECK(check_same_bits(&mine, &theirs, 1), "'%s': %.17g, expected %.17g", text, mine, theirs);
}

static void test_reading(void)
{
    static const char *const texts[] = {"0",
                                        "-0",
                                        "1",
                                        "+1",
                                        "00012",
                                        "1.",
                                        ".5",
                                        "-.5",
                                        "1e5",
                                        "1E-5",
                                        "1e+05",
                                        "0.1",
                                        "123456789012345678",
                                        "9007199254740993",
                                        "9007199254740992.5",
                                        "18446744073709551615",
                                        "18446744073709551616",
                                        "0.00000000000000000000000001",
                                        "1e22",
                                        "1e23",
                                        "8.5e22",
                                        "1e27",
                                        "1e28",
                                        "1e308",
                                        "1e309",
                                        "-1e400",
                                        "1e-320",
                                        "4.9e-324",
                                        "2.4703282292062327e-324",
                                        "1e-400",
                                        "0e99999999999",
                                        "1e99999999999",
                                        "0.000000000000000000000000000000000000000000000000001e51",
                                        "179769313486231580793728971405301e276",
                                        "1.00000000000000011102230246251565",
                                        "1.000000000000000111022302462515654042363166809082031250000000001",
                                        "9214843084008499",
                                        "30078505129381147446200",
                                        "7.2057594037927933e16",
                                        "0.500000000000000166533453693773481063544750213623046875"};
    for (size_t k = 0; k < sizeof texts / sizeof texts[0]; k++) compare(texts[k]);
    char text[64];
    for (int k = 0; k < 400000; k++) {
        unsigned digits = 1 + (unsigned)(ff_test_random() % 21);
        size_t n = 0;
        unsigned point = (unsigned)(ff_test_random() % (digits + 1));
        for (unsigned d = 0; d < digits; d++) {
            if (d == point) text[n++] = '.';
            text[n++] = (char)('0' + ff_test_random() % 10);
        }
        text[n] = '\0';
        if (ff_test_random() % 2) snprintf(text + n, 8, "e%d", (int)(ff_test_random() % 70) - 35);
        compare(text);
    }
    for (int k = 0; k < 200000; k++) { /* 17 digits of any double, and the middle between two doubles, cut at 19 digits */
        snprintf(text, sizeof text, "%.17g", ldexp(0.5 + ff_test_uniform(), (int)(ff_test_random() % 140) - 70));
        compare(text);
        double x = 0.5 + ff_test_uniform();
        snprintf(text, sizeof text, "%.18Lf", ((long double)x + (long double)nextafter(x, 2)) / 2);
        compare(text);
    }
}

/* Up to 45 digits of any size, and numbers that agree with a half-way point in their first 17 to 50 digits. */
static void long_numbers(void)
{
    static const char *const texts[] = {"0.00000000000000000000000000000000",
                                        "-0.00000000000000000000000000000000",
                                        "0.26179938779914940782944654529274",
                                        "-1.57079632679489655799898173427209",
                                        "0.00000000000000019236706937217898",
                                        "0.50000000000000000000000000000000",
                                        "0000000000000000000000000000000001",
                                        "100000000000000000000000000000000000000000",
                                        "2.2250738585072011e-308",
                                        "2.22507385850720113605740979670913197593e-308",
                                        "2.4703282292062327208299439643e-324",
                                        "1.7976931348623158079372897140530341507e308",
                                        "9007199254740993.00000000000000000",
                                        "9007199254740993.00000000000000001",
                                        "9007199254740992.99999999999999999",
                                        "0.1e-330",
                                        "12345678901234567890e-345",
                                        "1e-342",
                                        "123456789e300",
                                        "1.e-28"};
    for (size_t k = 0; k < sizeof texts / sizeof texts[0]; k++) compare(texts[k]);
    char text[1200];
    for (int k = 0; k < 200000; k++) {
        unsigned digits = 1 + (unsigned)(ff_test_random() % 45);
        size_t n = 0;
        unsigned point = (unsigned)(ff_test_random() % (digits + 1));
        for (unsigned d = 0; d < digits; d++) {
            if (d == point) text[n++] = '.';
            text[n++] = (char)(k % 3 == 0 && d < digits / 2 ? '0' : '0' + ff_test_random() % 10);
        }
        text[n] = '\0';
        if (ff_test_random() % 2) snprintf(text + n, 8, "e%d", (int)(ff_test_random() % 700) - 350);
        compare(text);
    }
    for (int k = 0; k < 200000; k++) {
        double x = ldexp(0.5 + ff_test_uniform() / 2, (int)(ff_test_random() % 2000) - 1000);
        snprintf(text, sizeof text, "%.*e", 25 + (int)(ff_test_random() % 20), x);
        compare(text);
        snprintf(text, sizeof text, "%.32f", ff_test_uniform());
        compare(text);
        long double half_way = ((long double)x + (long double)nextafter(x, INFINITY)) / 2;
        snprintf(text, sizeof text, "%.*Le", 16 + (int)(ff_test_random() % 34), half_way);
        compare(text);
    }
}

static void refusing(void)
{
    static const char *const texts[] = {"", "-", "+", ".", "e5", "-e", "nan", "inf", "-inf", "1e", "1e+", "x", " 1", "--1"};
    double v;
    for (size_t k = 0; k < sizeof texts / sizeof texts[0]; k++) FF_CHECK(!ff_number_read(texts[k], &v), "'%s' was read", texts[k]);
    const char *hex = "0x10";
    FF_CHECK(ff_number_read(hex, &v) == hex + 1 && v == 0, "hexadecimal");
    const char *comma = "1,5";
    FF_CHECK(ff_number_read(comma, &v) == comma + 1 && v == 1, "decimal comma");
}

static void round_trip(double v)
{
    char text[FF_NUMBER_TEXT + 1], shortest[40];
    double back;
    unsigned n = ff_number_write(v, text);
    FF_CHECK(n < FF_NUMBER_TEXT, "%u characters", n);
    text[n] = '\0';
    back = strtod(text, NULL);
    FF_CHECK(check_same_bits(&v, &back, 1), "%.17g was written as '%s'", v, text);
    int digits = 0, precision = 15;
    for (const char *p = text; *p && *p != 'e'; p++) digits += *p >= '0' && *p <= '9' && (digits || *p != '0');
    for (; precision < 17; precision++) {
        snprintf(shortest, sizeof shortest, "%.*e", precision - 1, v);
        if (strtod(shortest, NULL) == v) break;
    }
    if (fabs(v) < 1e15) FF_CHECK(digits <= precision, "%.17g was written as '%s', %d digits suffice", v, text, precision);
    while (digits > 1 && strchr(text, '.') == NULL && text[n - 1] == '0') n--, digits--; /* zeros up to the point are no digits */
    if (digits < 2) return;
    snprintf(shortest, sizeof shortest, "%.*e", digits - 2, v);
    FF_CHECK(strtod(shortest, NULL) != v, "%.17g was written as '%s', '%s' suffices", v, text, shortest);
}

static void written(double v, const char *expected)
{
    char text[FF_NUMBER_TEXT + 1];
    text[ff_number_write(v, text)] = '\0';
    FF_CHECK(strcmp(text, expected) == 0, "%.17g was written as '%s', expected '%s'", v, text, expected);
}

static void test_writing(void)
{
    static const double values[] = {0.0,
                                    -0.0,
                                    1,
                                    -1,
                                    0.1,
                                    0.3,
                                    1.0 / 3,
                                    100,
                                    1e15,
                                    1e16,
                                    123456789,
                                    1e17,
                                    1e21,
                                    1e22,
                                    1e23,
                                    1e-4,
                                    1e-5,
                                    1e-10,
                                    1e-11,
                                    0.999999999999999999,
                                    9.9999999999999995e-8,
                                    3.14159265358979323846,
                                    57.29577951308232,
                                    5e-324,
                                    1.7976931348623157e308,
                                    2.2250738585072014e-308,
                                    9007199254740994,
                                    4503599627370497.5};
    for (size_t k = 0; k < sizeof values / sizeof values[0]; k++) round_trip(values[k]);
    for (int k = 0; k < 200000; k++) {
        uint64_t u = ff_test_random();
        double v;
        memcpy(&v, &u, 8);
        if (isfinite(v)) round_trip(v);
        round_trip(ldexp(0.5 + ff_test_uniform(), (int)(ff_test_random() % 100) - 40));
        round_trip((double)(ff_test_random() % 100000) / 1000);
    }
    written(0.1, "0.1");
    written(-250, "-250");
    written(0, "0");
    written(-0.0, "-0");
    written(1.5e-9, "1.5e-09");
    written(9.999999999999999e-6, "9.999999999999999e-06"); /* the ends of where there is no exponent */
    written(1e-5, "0.00001");
    written(-1.2345678901234568e-5, "-0.000012345678901234568");
    written(999999999999999.9, "999999999999999.9");
    written(1e15, "1000000000000000");
    written(1234567890123456.5, "1234567890123456.5");
    written(12345678901234568, "12345678901234568");
    written(1e16, "10000000000000000");
    written(9.9e16, "99000000000000000");
    written(1e17, "1e+17");
    written(1.5e300, "1.5e+300");
    written(2e-308, "2e-308");
    written(5e-324, "5e-324");                           /* it has no more digits than this one */
    written(0.24101638793945313, "0.24101638793945312"); /* half-way between two of 17 digits: the even one, as printf has it */
}

/* Whole numbers up to a limit, which may be one digit or all that 64 bits hold. */
static void whole_numbers(void)
{
    static const struct {
        const char *text;
        uint64_t most, value;
        int good;
    } cases[] = {{"0", 0, 0, 1},
                 {"1", 0, 0, 0},
                 {"3", 3, 3, 1},
                 {"4", 3, 0, 0},
                 {"7", 3, 0, 0},
                 {"12", 12, 12, 1},
                 {"13", 12, 0, 0},
                 {"20", 12, 0, 0},
                 {"007", 7, 7, 1},
                 {"", 9, 0, 0},
                 {"-1", 9, 0, 0},
                 {"1a", 99, 0, 0},
                 {"+1", 9, 0, 0},
                 {"1 ", 9, 0, 0},
                 {"18446744073709551615", UINT64_MAX, UINT64_MAX, 1},
                 {"18446744073709551616", UINT64_MAX, 0, 0},
                 {"18446744073709551625", UINT64_MAX, 0, 0}};
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
        uint64_t n = 4711;
        const int good = ff_whole_number(cases[k].text, cases[k].most, &n);
        FF_CHECK(good == cases[k].good && n == (good ? cases[k].value : 4711), "'%s' of at most %llu: %d, %llu", cases[k].text,
                 (unsigned long long)cases[k].most, good, (unsigned long long)n);
    }
}

/* Every kind of blank stands between two numbers, a carriage return in the middle of a line too. */
static void blanks_between_numbers(void)
{
    static const char *const texts[] = {"1 2 3", "1\t2\t3", "1,2,3", "1\r2\r3", " 1 , 2\t,\r3 # 4"};
    for (size_t k = 0; k < sizeof texts / sizeof *texts; k++) {
        double v[3] = {0};
        size_t n = 0;
        ff_error err = {0};
        FF_CHECK(ff_line_numbers(texts[k], v, 3, &n, "path", 1, "three numbers", &err) == FF_OK, "%zu: %s", k, err.message);
        FF_CHECK(n == 3 && v[0] == 1 && v[1] == 2 && v[2] == 3, "%zu: %zu numbers, %g %g %g", k, n, v[0], v[1], v[2]);
    }
}

FF_TEST_MAIN(FF_TEST(whole_numbers), FF_TEST(blanks_between_numbers), FF_TEST(test_reading), FF_TEST(long_numbers),
             FF_TEST(refusing), FF_TEST(test_writing))
