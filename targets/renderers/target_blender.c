/* Cycles of Blender 3.4: the Principled BSDF with the distribution GGX.
 *
 * Distribution ggx with Smith's separable masking, roughness = sqrt(alpha), alpha_x and alpha_y = alpha / aspect and alpha aspect
 * with aspect = sqrt(1 - 0.9 anisotropic). The Fresnel term goes from F0 = mix(0.08 specular, base colour, metallic) to 1 along the
 * curve of a dielectric whose own F0 is 0.08 specular: with metallic 0 it is that dielectric. The diffuse part is Disney's, with
 * the roughness of the lobe, times 1 - metallic, and nothing is taken from it for what the lobe reflects. */
#include "targets/conventions/internal_formulas.h"

static const ff_material materials[] = {
    {.name = "dielectric",
     .title = "Principled BSDF, GGX, Metallic 0",
     .expression = "ggx/smith-separable/dielectric+disney-coupled",
     .bound = {"alpha=0.0001:1", "eta=1:1.7888543819998317"},
     .shared = {"eta"},
     .control = {FF_COLOR_CONTROL("Base Color", "kd"),
                 FF_ROUGHNESS_CONTROL("Roughness"),
                 {.made = {"Specular", {"eta"}, ff_specular_of_index}, .hi = 1, .unit = "1"}},
     .parameter = {{"kd", {"Base Color"}, ff_same},
                   {"alpha", {"Roughness"}, ff_squared},
                   {"eta", {"Specular"}, ff_index_of_specular}},
     .setting = {{"Metallic", 0}}},
    {.name = "metal",
     .title = "Principled BSDF, GGX, Metallic 1",
     .expression = "ggx/smith-separable/cycles",
     .bound = {"alpha_x=0.0001:1", "alpha_y=0.0001:1"},
     .control = {FF_COLOR_CONTROL("Base Color", "f0"),
                 {.made = {"Roughness", {FF_STRETCH}, ff_mean_roughness}, .hi = 1, .unit = "1"},
                 {.made = {"Anisotropic", {FF_STRETCH}, ff_disney_anisotropy}, .hi = 1, .unit = "1", .is_of_axis = 1},
                 {.made = {"Anisotropic Rotation", {FF_STRETCH}, ff_major_turns}, .hi = 1, .unit = "turns", .is_of_axis = 1}},
     .parameter = {{"f0", {"Base Color"}, ff_same},
                   {"alpha_x", {"Roughness", "Anisotropic", "Anisotropic Rotation"}, ff_disney_x},
                   {"alpha_y", {"Roughness", "Anisotropic", "Anisotropic Rotation"}, ff_disney_y},
                   {"r_xy", {"Roughness", "Anisotropic", "Anisotropic Rotation"}, ff_disney_r}},
     .setting = {{"Metallic", 1}, {"Specular", 0.5}}}};

const ff_target ff_target_blender = {
    .name = "blender",
    .alias = {"cycles", "blender-3.4", "blender-principled"},
    .title = "Cycles, Principled BSDF",
    .version = "Blender 3.4",
    .source = "Blender 3.4 manual, Principled BSDF; Burley 2012",
    .lacks =
        "Metallic is 0 or 1, not between. Below Metallic 1 an anisotropic lobe is not fitted, since the diffuse part has one "
        "roughness. Sheen, clearcoat, subsurface and transmission are 0, and Specular Tint is 0. The distribution Multiscatter GGX "
        "is another model.",
    .rendered = "tests/renderers: Cycles of Blender 3.4.1",
    FF_TARGET_OF(blender, materials)};
