/* Which light a channel was measured with, as its name says. */
#include "ff_polarization.h"
#include <ctype.h>
#include <math.h>
#include <string.h>

static const struct {
    const char *word;
    double share;
} words[] = {{"s", 1},      {"te", 1},   {"spol", 1}, {"perp", 1},     {"perpendicular", 1}, {"senkrecht", 1},     {"p", 0},
             {"tm", 0},     {"ppol", 0}, {"par", 0},  {"parallel", 0}, {"unpolarized", 0.5}, {"unpolarised", 0.5}, {"mean", 0.5},
             {"unpol", 0.5}};

/* Of n characters, in any case. */
static double share_of(const char *word, size_t n)
{
    for (size_t k = 0; k < sizeof words / sizeof *words; k++) {
        size_t same = 0;
        while (same < n && words[k].word[same] == tolower((unsigned char)word[same])) same++;
        if (same == n && !words[k].word[n]) return words[k].share;
    }
    return NAN;
}

double ff_polarization_of_name(const char *name)
{
    double said = NAN;
    for (const char *at = name; *at;) {
        size_t n = 0;
        while (isalpha((unsigned char)at[n])) n++;
        const double share = share_of(at, n);
        if (!isnan(share) && !isnan(said) && share != said) return NAN;
        if (!isnan(share)) said = share;
        at += n ? n : 1;
    }
    return said;
}
