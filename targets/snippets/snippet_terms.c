/* The code of the terms, as it is written into snippets. */
#include "internal_snippet_terms.h"
#include <stddef.h>
#include <stdio.h>
#include <string.h>

/* p(q2), the density of slopes, and Smith's Lambda of v = (alpha_o tan theta)^2. */
static const ff_snippet_term ndfs[] = {
    {"ggx",
     "$F facetfit_ggx_p($T q2)\n{\n    return 1.0 / (3.141592653589793 * (1.0 + q2) * (1.0 + q2));\n}\n\n"
     "$F facetfit_ggx_lambda($T v)\n{\n    return 0.5 * (sqrt(1.0 + v) - 1.0);\n}\n\n",
     "ggx", 1},
    {"beckmann",
     "$F facetfit_beckmann_p($T q2)\n{\n    return exp(-q2) / 3.141592653589793;\n}\n\n"
     "$F facetfit_beckmann_lambda($T v)\n{\n    $T a = 1.0 / sqrt($max(v, 1e-30));\n"
     "    return 0.5 * ($erf(a) - 1.0) + exp(-a * a) / (2.0 * a * 1.772453850905516);\n}\n\n",
     "beckmann", 1},
    {"beckmann-walter",
     "$F facetfit_walter_p($T q2)\n{\n    return exp(-q2) / 3.141592653589793;\n}\n\n"
     "$F facetfit_walter_lambda($T v)\n{\n    $T a = 1.0 / sqrt($max(v, 1e-30));\n"
     "    return a < 1.6 ? (1.0 - 1.259 * a + 0.396 * a * a) / (3.535 * a + 2.181 * a * a) : 0.0;\n}\n\n",
     "walter", 1},
};

static const ff_snippet_term maskings[] = {
    {"smith-separable", "", "1.0 / ((1.0 + li) * (1.0 + lo))", 1},
    {"smith-height-correlated", "", "1.0 / (1.0 + li + lo)", 1},
    {"v-cavity", "", "$min(1.0, 2.0 * hz * $min(iz, oz) / c)", 0},
    {"kelemen", "", "iz * oz / (c * c)", 0},
    {"hammon", "", "2.0 * iz * oz / (2.0 * iz * oz + ax * (iz + oz - 2.0 * iz * oz))", 0},
    {"schlick-smith", "", "iz * oz / ((iz + 0.5 * ax * (1.0 - iz)) * (oz + 0.5 * ax * (1.0 - oz)))", 0},
    {"none", "", "1.0", 0},
};

#define FIFTH "$F facetfit_fifth($T x)\n{\n    return x * x * x * x * x;\n}\n\n"
#define DIELECTRIC                                                                                                                 \
    "$F facetfit_dielectric($T c, $T eta)\n{\n    $T w = sqrt($max((eta - 1.0) * (eta + 1.0) + c * c, 0.0));\n"                    \
    "    $T rs = (c - w) / (c + w);\n    $T rp = (eta * eta * c - w) / (eta * eta * c + w);\n"                                     \
    "    return 0.5 * (rs * rs + rp * rp);\n}\n\n"

static const ff_snippet_term fresnels[] = {
    {"schlick", "$F facetfit_schlick($T c, $T f0)\n{\n    return f0 + (1.0 - f0) * facetfit_fifth(1.0 - c);\n}\n\n",
     "facetfit_schlick(c, f0)", 0},
    {"schlick-karis",
     "$F facetfit_schlick_karis($T c, $T f0)\n{\n    return f0 + (1.0 - f0) * exp(0.6931471805599453 * (-5.55473 * c - 6.98316) * "
     "c);\n}\n\n",
     "facetfit_schlick_karis(c, f0)", 0},
    {"schlick-f82",
     "$F facetfit_schlick_f82($T c, $T f0, $T f82)\n{\n    $T at = 0.4626643660379008 + (1.0 - 0.4626643660379008) * f0 - f82;\n"
     "    $T dip = c * (1.0 - c) * facetfit_fifth(1.0 - c) / (0.1428571428571429 * 0.8571428571428571 * 0.4626643660379008);\n"
     "    return f0 + (1.0 - f0) * facetfit_fifth(1.0 - c) - dip * at;\n}\n\n",
     "facetfit_schlick_f82(c, f0, f82)", 0},
    {"dielectric", DIELECTRIC, "facetfit_dielectric(c, eta)", 0},
    {"cycles",
     DIELECTRIC "$F facetfit_cycles($T c, $T f0, $T eta)\n{\n    $T r = (eta - 1.0) / (eta + 1.0);\n"
                "    return 1.0 - (1.0 - f0) * (1.0 - facetfit_dielectric(c, eta)) / (1.0 - r * r);\n}\n\n",
     "facetfit_cycles(c, f0, eta)", 0},
    {"conductor",
     "$F facetfit_conductor($T c, $T eta, $T k)\n{\n    $T s2 = 1.0 - c * c;\n    $T t0 = eta * eta - k * k - s2;\n"
     "    $T ab = sqrt(t0 * t0 + 4.0 * eta * eta * k * k);\n    $T a = sqrt($max(0.5 * (ab + t0), 0.0));\n"
     "    $T rs = (ab + c * c - 2.0 * a * c) / (ab + c * c + 2.0 * a * c);\n"
     "    $T rp = rs * (c * c * ab + s2 * s2 - 2.0 * a * c * s2) / (c * c * ab + s2 * s2 + 2.0 * a * c * s2);\n"
     "    return 0.5 * (rs + rp);\n}\n\n",
     "facetfit_conductor(c, eta, k)", 0},
    {"none", "", "1.0", 0},
};

#define ENTERS "(1.0 - facetfit_fifth(1.0 - iz)) * (1.0 - facetfit_fifth(1.0 - oz))"
#define BURLEY(rough)                                                                                                              \
    "kd / 3.141592653589793 * (1.0 + (2.0 * (" rough ") * c * c - 0.5) * facetfit_fifth(1.0 - iz)) * (1.0 + (2.0 * (" rough        \
    ") * c * c - 0.5) * facetfit_fifth(1.0 - oz))"

static const ff_snippet_term bases[] = {
    {"lambert", "", "kd / 3.141592653589793", 0},
    {"disney", "", BURLEY("rough"), 0},
    {"disney-coupled", "", BURLEY("sqrt(ax)"), 0},
    {"fresnel-coupled", "", "kd / 3.141592653589793 * $max(1.0 - first, 0.0)", 0},
    {"shirley-coupled", "", "1.05 * kd / 3.141592653589793 * $max(1.0 - normal, 0.0) * " ENTERS, 0},
};

typedef struct kind {
    const ff_snippet_term *term;
    size_t n;
} kind;
static const kind kinds[] = {{ndfs, sizeof ndfs / sizeof *ndfs},
                             {maskings, sizeof maskings / sizeof *maskings},
                             {fresnels, sizeof fresnels / sizeof *fresnels},
                             {bases, sizeof bases / sizeof *bases}};

static const ff_snippet_term *find(int k, const char *name)
{
    for (size_t i = 0; i < kinds[k].n; i++)
        if (!strcmp(kinds[k].term[i].name, name)) return &kinds[k].term[i];
    return NULL;
}

const ff_snippet_term *ff_snippet_ndf(const char *name)
{
    return find(0, name);
}

const ff_snippet_term *ff_snippet_masking(const char *name)
{
    return find(1, name);
}

const ff_snippet_term *ff_snippet_fresnel(const char *name)
{
    return find(2, name);
}

const ff_snippet_term *ff_snippet_base(const char *name)
{
    return find(3, name);
}

void ff_snippet_known(int k, char *out, unsigned size)
{
    out[0] = '\0';
    for (size_t i = 0; i < kinds[k].n; i++) {
        const size_t used = strlen(out);
        snprintf(out + used, size - used, "%s%s", used ? ", " : "", kinds[k].term[i].name);
    }
}
