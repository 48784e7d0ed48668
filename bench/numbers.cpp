/** Numbers in text, the project's way and the C++ library's, on the kinds of numbers that files of measured reflectance hold.
 *
 *      bench_numbers [ROUNDS]
 *
 *  Reading: ff_number_read; std::from_chars behind the scan that it needs here (it takes no '+', takes "inf", reads "1e" as 1, and
 * has to be told where the text ends); std::from_chars alone, told the end of all the text. Writing: ff_number_write, and
 * std::to_chars in whatever notation is shorter. All by turns in each round; medians over the rounds of the time of this thread. */
extern "C" {
#include "base/internal_number.h"
}
#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <time.h>
#include <vector>

namespace
{

constexpr int kNumbers = 100000;

double now()
{
    timespec t;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

double uniform()
{
    static std::uint64_t state = 88172645463325252u;
    state ^= state << 13, state ^= state >> 7, state ^= state << 17;
    return static_cast<double>(state >> 11) * 0x1p-53;
}

/* A number and how many digits a file gives it; 0: as many as it takes. */
double angle()
{
    return std::floor(uniform() * 36000) / 100;
}
double random_value()
{
    return std::exp(-9 * uniform()) * uniform();
}
double single()
{
    return static_cast<float>(random_value());
}
const struct {
    const char *name;
    double (*draw)();
    int digits;
} kinds[] = {{"angles of two decimals", angle, 0},
             {"values, 6 digits", random_value, 6},
             {"values, all digits", random_value, 0},
             {"floats, 9 digits", single, 9}};

bool is_a_digit(char c)
{
    return static_cast<unsigned>(c - '0') < 10u;
}

/* Where the number ends, nullptr when it is none: what ff_number_read accepts. */
const char *scanned(const char *p)
{
    if (*p == '-' || *p == '+') p++;
    const char *first = p;
    while (is_a_digit(*p)) p++;
    long digits = p - first;
    if (*p == '.') {
        const char *fraction = ++p;
        while (is_a_digit(*p)) p++;
        digits += p - fraction;
    }
    if (digits == 0) return nullptr;
    if (*p != 'e' && *p != 'E') return p;
    p += p[1] == '-' || p[1] == '+' ? 2 : 1;
    if (!is_a_digit(*p)) return nullptr;
    while (is_a_digit(*p)) p++;
    return p;
}

struct Text {
    std::string text;
    std::vector<double> number;
};

Text make(double (*draw)(), int digits)
{
    Text t;
    for (int i = 0; i < kNumbers; i++) {
        char word[FF_NUMBER_TEXT + 1];
        double v = draw();
        const int n = digits ? std::snprintf(word, sizeof word, "%.*g", digits, v) : static_cast<int>(ff_number_write(v, word));
        t.text.append(word, static_cast<std::size_t>(n)).append(",");
        word[n] = '\0';
        ff_number_read(word, &v);
        t.number.push_back(v);
    }
    return t;
}

template <class Read>
double reading(const Text &t, double *sum, Read &&read)
{
    const double begin = now();
    *sum = 0;
    for (const char *p = t.text.c_str(); *p; p++) {
        double v = 0;
        p = read(p, &v);
        *sum += v;
    }
    return now() - begin;
}

template <class Write>
double writing(const Text &t, double *sum, Write &&write)
{
    char word[FF_NUMBER_TEXT];
    const double begin = now();
    *sum = 0;
    for (double v : t.number) *sum += static_cast<double>(write(v, word)) + word[0];
    return now() - begin;
}

double median(std::vector<double> &v)
{
    std::sort(v.begin(), v.end());
    return v[v.size() / 2];
}

} // namespace

int main(int argc, char **argv)
{
    const int rounds = argc > 1 ? std::max(1, std::atoi(argv[1])) : 31;
    for (const auto &kind : kinds) {
        const Text t = make(kind.draw, kind.digits);
        const char *const end = t.text.c_str() + t.text.size();
        std::vector<double> time[5];
        for (int r = 0; r < rounds; r++) {
            double sum[5];
            time[0].push_back(reading(t, &sum[0], [](const char *p, double *v) { return ff_number_read(p, v); }));
            time[1].push_back(reading(t, &sum[1], [](const char *p, double *v) {
                const char *stop = scanned(p);
                std::from_chars(*p == '+' ? p + 1 : p, stop, *v);
                return stop;
            }));
            time[2].push_back(reading(t, &sum[2], [end](const char *p, double *v) { return std::from_chars(p, end, *v).ptr; }));
            time[3].push_back(writing(t, &sum[3], [](double v, char *out) { return ff_number_write(v, out); }));
            time[4].push_back(
                writing(t, &sum[4], [](double v, char *out) { return std::to_chars(out, out + FF_NUMBER_TEXT, v).ptr - out; }));
            if (sum[0] != sum[1] || sum[0] != sum[2]) return std::fprintf(stderr, "the readers differ\n"), 1;
        }
        double ns[5];
        for (int k = 0; k < 5; k++) ns[k] = median(time[k]) / kNumbers * 1e9;
        const double bytes = static_cast<double>(t.text.size()) / kNumbers;
        std::printf("%-23s read GB/s: %.2f ours, %.2f scan and from_chars, %.2f from_chars; write ns: %.0f ours, %.0f to_chars\n",
                    kind.name, bytes / ns[0], bytes / ns[1], bytes / ns[2], ns[3], ns[4]);
    }
    return 0;
}
