/* The Disney BRDF of 2012 as most renderers took it: the masking with the roughness itself, without the remapping of the course
 * notes.
 *
 * The clear coat is gtr with gamma = 1 between alpha = 0.1 (clearcoatGloss 0) and 0.001 (1), F0 = 0.04, a quarter of the weight,
 * masked as if its alpha were 0.25. */
#include "targets/conventions/internal_formulas.h"

/* alpha = 0.1 - 0.099 gloss */
static double gloss(const double *x, double *d)
{
    if (d) d[0] = -1 / 0.099;
    return (0.1 - x[0]) / 0.099;
}

static double alpha_of_gloss(const double *x, double *d)
{
    if (d) d[0] = -0.099;
    return 0.1 - 0.099 * x[0];
}

#define SPECULAR                                                                                                                   \
    {                                                                                                                              \
        .made = {"specular", {"f0"}, ff_specular_of_f0}, .hi = 1, .unit = "1"                                                      \
    }

static const ff_material materials[] = {
    {.name = "dielectric",
     .title = "metallic 0, clearcoat 0",
     .expression = "ggx/smith-separable/schlick+disney-coupled",
     .bound = {"alpha=0.001:1", "f0=0:0.08"},
     .shared = {"f0"},
     .control = {FF_COLOR_CONTROL("baseColor", "kd"), FF_ROUGHNESS_CONTROL("roughness"), SPECULAR},
     .parameter = {{"kd", {"baseColor"}, ff_same}, {"alpha", {"roughness"}, ff_squared}, {"f0", {"specular"}, ff_f0_of_specular}},
     .setting = {{"metallic", 0}, {"clearcoat", 0}}},
    {.name = "coated",
     .title = "metallic 0, with a clear coat",
     .expression = "ggx/smith-separable/schlick+gtr/disney-clearcoat/schlick+disney-coupled",
     .hold = {"lobe2.gamma=1", "lobe2.f0=0.04"},
     .vary = {"lobe2.ks"},
     .bound = {"alpha=0.001:1", "f0=0:0.08", "lobe2.alpha=0.001:0.1", "lobe2.ks=0:0.25"},
     .shared = {"f0", "lobe2.ks"},
     .control = {FF_COLOR_CONTROL("baseColor", "kd"),
                 FF_ROUGHNESS_CONTROL("roughness"),
                 SPECULAR,
                 {.made = {"clearcoat", {"lobe2.ks"}, ff_fourfold}, .hi = 1, .unit = "1"},
                 {.made = {"clearcoatGloss", {"lobe2.alpha"}, gloss}, .hi = 1, .unit = "1"}},
     .parameter = {{"kd", {"baseColor"}, ff_same},
                   {"alpha", {"roughness"}, ff_squared},
                   {"f0", {"specular"}, ff_f0_of_specular},
                   {"lobe2.ks", {"clearcoat"}, ff_quarter},
                   {"lobe2.alpha", {"clearcoatGloss"}, alpha_of_gloss}},
     .setting = {{"metallic", 0}}},
    {.name = "metal",
     .title = "metallic 1",
     .expression = "ggx/smith-separable/schlick",
     .bound = {"alpha_x=0.0001:1", "alpha_y=0.0001:1"},
     .control = {FF_COLOR_CONTROL("baseColor", "f0"),
                 {.made = {"roughness", {FF_STRETCH}, ff_mean_roughness}, .hi = 1, .unit = "1"},
                 {.made = {"anisotropic", {FF_STRETCH}, ff_disney_anisotropy}, .hi = 1, .unit = "1", .is_of_axis = 1},
                 {.made = {"rotation", {FF_STRETCH}, ff_major_turns}, .hi = 1, .unit = "turns", .is_of_axis = 1}},
     .parameter = {{"f0", {"baseColor"}, ff_same},
                   {"alpha_x", {"roughness", "anisotropic", "rotation"}, ff_disney_x},
                   {"alpha_y", {"roughness", "anisotropic", "rotation"}, ff_disney_y},
                   {"r_xy", {"roughness", "anisotropic", "rotation"}, ff_disney_r}},
     .setting = {{"metallic", 1}, {"clearcoat", 0}}}};

const ff_target ff_target_disney = {
    .name = "disney",
    .alias = {"disney-brdf"},
    .title = "Disney BRDF",
    .version = "2012",
    .source = "Burley 2012, Physically Based Shading at Disney, and its appendix B",
    .lacks = "metallic is 0 or 1, not between. The masking has the roughness itself, not (0.5 + roughness / 2)^2 as in the source. "
             "subsurface, sheen and specularTint are 0. rotation turns the tangents.",
    FF_TARGET_OF(disney, materials)};
