/* Roughness and gloss as renderers name them: each is a scale of its own of alpha or of an exponent. */
#include "internal_conversions.h"
#include <math.h>

static const char *square(const double *in, double *out)
{
    out[0] = in[0] * in[0];
    return NULL;
}

static const char *square_root(const double *in, double *out)
{
    out[0] = sqrt(in[0]);
    return NULL;
}

static const char *doubt_roughness(const double *in, const double *out)
{
    (void)out;
    if (in[0] > 1) return "above 1: the roughness of most renderers ends at 1";
    return in[0] > 0 ? NULL : "0 is a perfect mirror, which no slope distribution describes";
}

static const char *one_less(const double *in, double *out)
{
    out[0] = 1 - in[0];
    return NULL;
}

/* n = 8192^g, n = 2^(10 g + 1), and back. */
static const char *gloss_8192_to_n(const double *in, double *out)
{
    out[0] = exp2(13 * in[0]);
    return NULL;
}

static const char *n_to_gloss_8192(const double *in, double *out)
{
    if (in[0] < 1) return "an exponent below 1 has no gloss on this scale";
    out[0] = log2(in[0]) / 13;
    return NULL;
}

static const char *gloss_2048_to_n(const double *in, double *out)
{
    out[0] = exp2(10 * in[0] + 1);
    return NULL;
}

static const char *n_to_gloss_2048(const double *in, double *out)
{
    if (in[0] < 2) return "an exponent below 2 has no gloss on this scale";
    out[0] = (log2(in[0]) - 1) / 10;
    return NULL;
}

static const char above_1[] = "above 1: the scale ends there";

static const char *doubt_gloss_in(const double *in, const double *out)
{
    (void)out;
    return in[0] > 1 ? above_1 : NULL;
}

static const char *doubt_gloss_out(const double *in, const double *out)
{
    (void)in;
    return out[0] > 1 ? above_1 : NULL;
}

/* ---- the table ------------------------------------------------------------------------------- */

static const char burley[] = "Burley 2012, section 5.4";
static const char burley_assumes[] = "the renderer squares its roughness (Disney, UE4, glTF, Filament); some take alpha itself";
static const char burley_limits[] = "exact for 0 < roughness <= 1";
static const char renderers[] = "what renderers mean by alpha";
static const char is_ggx[] = "the renderer's distribution is ggx, as that of nearly all is";
static const char unity[] = "Unity's manual, Standard Shader: smoothness";
static const char complement[] = "a scale from 0, rough, to 1, smooth, that is linear in the roughness that is squared";
static const char khronos[] = "KHR_materials_pbrSpecularGlossiness (Khronos 2017)";
static const char lazarov[] = "Lazarov 2011, Physically-based lighting in Call of Duty: Black Ops";
static const char lazarov_assumes[] = "gloss 0 to 1 is n of 1 to 8192, evenly in its logarithm";
static const char lagarde[] = "Lagarde 2012, Adopting a physically based shading model";
static const char lagarde_assumes[] = "gloss 0 to 1 is n of 2 to 2048, evenly in its logarithm";
static const char exact[] = "exact";
static const char exact_in_01[] = "exact for 0 to 1";

#define V_01(n)                                                                                                                    \
    {                                                                                                                              \
        .name = n, .unit = "1", .lo = 0, .hi = 1 + 0x1p-52, .lo_included = 1                                                       \
    }

static const ff_conversion gloss[] = {
    {.from = "roughness",
     .to = "alpha",
     .by = "",
     .formula = "alpha = roughness^2",
     .source = burley,
     .assumes = burley_assumes,
     .limits = burley_limits,
     .n_in = 1,
     .n_out = 1,
     .in = {V_FROM("roughness", 0)},
     .out = {V_FROM("alpha", 0)},
     .apply = square,
     .doubt = doubt_roughness},
    {.from = "alpha",
     .to = "roughness",
     .by = "",
     .formula = "roughness = sqrt(alpha)",
     .source = burley,
     .assumes = burley_assumes,
     .limits = burley_limits,
     .n_in = 1,
     .n_out = 1,
     .in = {V_FROM("alpha", 0)},
     .out = {V_FROM("roughness", 0)},
     .apply = square_root,
     .doubt = doubt_roughness},
    {.from = "alpha",
     .to = "ggx",
     .by = "",
     .formula = "alpha_ggx = alpha",
     .source = renderers,
     .assumes = is_ggx,
     .limits = exact,
     .n_in = 1,
     .n_out = 1,
     .in = {V_FROM("alpha", 0)},
     .out = {V_ALPHA},
     .apply = ff_conversion_same},
    {.from = "ggx",
     .to = "alpha",
     .by = "",
     .formula = "alpha = alpha_ggx",
     .source = renderers,
     .assumes = is_ggx,
     .limits = exact,
     .n_in = 1,
     .n_out = 1,
     .in = {V_ALPHA},
     .out = {V_FROM("alpha", 0)},
     .apply = ff_conversion_same},
    {.from = "smoothness",
     .to = "roughness",
     .by = "",
     .formula = "roughness = 1 - smoothness",
     .source = unity,
     .assumes = complement,
     .limits = exact_in_01,
     .n_in = 1,
     .n_out = 1,
     .in = {V_01("smoothness")},
     .out = {V_FROM("roughness", 0)},
     .apply = one_less},
    {.from = "roughness",
     .to = "smoothness",
     .by = "",
     .formula = "smoothness = 1 - roughness",
     .source = unity,
     .assumes = complement,
     .limits = exact_in_01,
     .n_in = 1,
     .n_out = 1,
     .in = {V_FROM("roughness", 0)},
     .out = {V_01("smoothness")},
     .apply = one_less},
    {.from = "glossiness",
     .to = "roughness",
     .by = "",
     .formula = "roughness = 1 - glossiness",
     .source = khronos,
     .assumes = complement,
     .limits = exact_in_01,
     .n_in = 1,
     .n_out = 1,
     .in = {V_01("glossiness")},
     .out = {V_FROM("roughness", 0)},
     .apply = one_less},
    {.from = "roughness",
     .to = "glossiness",
     .by = "",
     .formula = "glossiness = 1 - roughness",
     .source = khronos,
     .assumes = complement,
     .limits = exact_in_01,
     .n_in = 1,
     .n_out = 1,
     .in = {V_FROM("roughness", 0)},
     .out = {V_01("glossiness")},
     .apply = one_less},
    {.from = "gloss-8192",
     .to = "phong",
     .by = "",
     .formula = "n = 8192^gloss",
     .source = lazarov,
     .assumes = lazarov_assumes,
     .limits = exact,
     .n_in = 1,
     .n_out = 1,
     .in = {V_FROM("gloss", 0)},
     .out = {V_N(0)},
     .apply = gloss_8192_to_n,
     .doubt = doubt_gloss_in},
    {.from = "phong",
     .to = "gloss-8192",
     .by = "",
     .formula = "gloss = log2(n)/13",
     .source = lazarov,
     .assumes = lazarov_assumes,
     .limits = exact,
     .n_in = 1,
     .n_out = 1,
     .in = {V_N(0)},
     .out = {V_FROM("gloss", 0)},
     .apply = n_to_gloss_8192,
     .doubt = doubt_gloss_out},
    {.from = "gloss-2048",
     .to = "phong",
     .by = "",
     .formula = "n = 2^(10 gloss + 1)",
     .source = lagarde,
     .assumes = lagarde_assumes,
     .limits = exact,
     .n_in = 1,
     .n_out = 1,
     .in = {V_FROM("gloss", 0)},
     .out = {V_N(0)},
     .apply = gloss_2048_to_n,
     .doubt = doubt_gloss_in},
    {.from = "phong",
     .to = "gloss-2048",
     .by = "",
     .formula = "gloss = (log2(n) - 1)/10",
     .source = lagarde,
     .assumes = lagarde_assumes,
     .limits = exact,
     .n_in = 1,
     .n_out = 1,
     .in = {V_N(0)},
     .out = {V_FROM("gloss", 0)},
     .apply = n_to_gloss_2048,
     .doubt = doubt_gloss_out},
};

FF_CONVERSION_GROUP(gloss, gloss);
