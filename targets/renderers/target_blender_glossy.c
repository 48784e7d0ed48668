/* Cycles of Blender 3.4: the Glossy BSDF with the Diffuse BSDF beside it, by an Add Shader.
 *
 * Colour times D G / (4 cos cos) with Smith's separable masking, without a Fresnel term: ks is the colour. GGX, and Beckmann with
 * Walter's rational masking. With an anisotropy above 0 (Anisotropic BSDF) alpha_x = roughness^2 (1 - an) along the tangent,
 * alpha_y = roughness^2 / (1 - an) across it: the rotation is that of the smaller axis. A Diffuse BSDF of roughness 0 is Lambert's.
 */
#include "targets/conventions/internal_formulas.h"

#define CONTROLS                                                                                                                   \
    {                                                                                                                              \
        FF_COLOR_CONTROL("Glossy Color", "ks"), {.made = {"Roughness", {FF_STRETCH}, ff_mean_roughness}, .hi = 1, .unit = "1"},    \
            {.made = {"Anisotropy", {FF_STRETCH}, ff_glossy_anisotropy}, .hi = 0.99, .unit = "1", .is_of_axis = 1},                \
            {.made = {"Rotation", {FF_STRETCH}, ff_minor_turns}, .hi = 1, .unit = "turns", .is_of_axis = 1},                       \
            FF_COLOR_CONTROL("Diffuse Color", "kd")                                                                                \
    }
#define BACK                                                                                                                       \
    {                                                                                                                              \
        {"ks", {"Glossy Color"}, ff_same}, {"alpha_x", {"Roughness", "Anisotropy", "Rotation"}, ff_glossy_x},                      \
            {"alpha_y", {"Roughness", "Anisotropy", "Rotation"}, ff_glossy_y},                                                     \
            {"r_xy", {"Roughness", "Anisotropy", "Rotation"}, ff_glossy_r},                                                        \
        {                                                                                                                          \
            "kd", {"Diffuse Color"}, ff_same                                                                                       \
        }                                                                                                                          \
    }

static const ff_material materials[] = {{.name = "ggx",
                                         .title = "Glossy BSDF, GGX, and Diffuse BSDF",
                                         .expression = "ggx/smith-separable/none+lambert",
                                         .vary = {"ks"},
                                         .bound = {"ks=0:1", "alpha_x=0.0001:1", "alpha_y=0.0001:1"},
                                         .control = CONTROLS,
                                         .parameter = BACK},
                                        {.name = "beckmann",
                                         .title = "Glossy BSDF, Beckmann, and Diffuse BSDF",
                                         .expression = "beckmann-walter/smith-separable/none+lambert",
                                         .vary = {"ks"},
                                         .bound = {"ks=0:1", "alpha_x=0.0001:1", "alpha_y=0.0001:1"},
                                         .control = CONTROLS,
                                         .parameter = BACK}};

const ff_target ff_target_blender_glossy = {
    .name = "blender-glossy",
    .alias = {"cycles-glossy"},
    .title = "Cycles, Glossy BSDF and Diffuse BSDF",
    .version = "Blender 3.4",
    .source = "Blender 3.4 manual, Glossy BSDF, Anisotropic BSDF and Diffuse BSDF; Walter et al. 2007",
    .lacks = "There is no Fresnel term: the colour is the same at every angle. The Diffuse BSDF has the roughness 0.",
    .rendered = "tests/renderers: Cycles of Blender 3.4.1",
    FF_TARGET_OF(blender_glossy, materials)};
