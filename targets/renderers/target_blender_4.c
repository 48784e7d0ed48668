/* Cycles of Blender 4: the Principled BSDF of version 2.
 *
 * ggx with Smith's height-correlated masking, roughness and anisotropy as before. Metals have Schlick's term with the tint of F82,
 * the specular tint; the dielectric layer is put on the diffuse one by its albedo as it is seen. */
#include "targets/conventions/internal_formulas.h"

static const ff_material materials[] = {
    {.name = "dielectric",
     .title = "Principled BSDF, GGX, Metallic 0, Diffuse Roughness 0",
     .expression = "ggx/smith-height-correlated/dielectric+albedo-scaled",
     .bound = {"alpha=0.0001:1", "eta=1:4"},
     .shared = {"eta"},
     .control = {FF_COLOR_CONTROL("Base Color", "kd"),
                 FF_ROUGHNESS_CONTROL("Roughness"),
                 {.made = {"IOR", {"eta"}, ff_same}, .lo = 1, .hi = 1000, .unit = "1"}},
     .parameter = {{"kd", {"Base Color"}, ff_same}, {"alpha", {"Roughness"}, ff_squared}, {"eta", {"IOR"}, ff_same}},
     .setting = {{"Metallic", 0}, {"Specular IOR Level", 0.5}}},
    {.name = "metal",
     .title = "Principled BSDF, GGX, Metallic 1",
     .expression = "ggx/smith-height-correlated/schlick-f82",
     .bound = {"alpha_x=0.0001:1", "alpha_y=0.0001:1"},
     .control = {FF_COLOR_CONTROL("Base Color", "f0"),
                 {.made = {"Roughness", {FF_STRETCH}, ff_mean_roughness}, .hi = 1, .unit = "1"},
                 {.made = {"Specular Tint", {"f0", "f82"}, ff_tint_of_f82}, .hi = 1, .unit = "1", .is_color = 1},
                 {.made = {"Anisotropic", {FF_STRETCH}, ff_disney_anisotropy}, .hi = 1, .unit = "1", .is_of_axis = 1},
                 {.made = {"Anisotropic Rotation", {FF_STRETCH}, ff_major_turns}, .hi = 1, .unit = "turns", .is_of_axis = 1}},
     .parameter = {{"f0", {"Base Color"}, ff_same},
                   {"f82", {"Base Color", "Specular Tint"}, ff_f82_of_tint},
                   {"alpha_x", {"Roughness", "Anisotropic", "Anisotropic Rotation"}, ff_disney_x},
                   {"alpha_y", {"Roughness", "Anisotropic", "Anisotropic Rotation"}, ff_disney_y},
                   {"r_xy", {"Roughness", "Anisotropic", "Anisotropic Rotation"}, ff_disney_r}},
     .setting = {{"Metallic", 1}}}};

const ff_target ff_target_blender_4 = {
    .name = "blender-4",
    .alias = {"cycles-4", "blender-4.2"},
    .title = "Cycles, Principled BSDF of version 2",
    .version = "Blender 4.0 to 4.5",
    .source = "Blender 4.2 manual, Principled BSDF; Kutz et al. 2021; Heitz 2014",
    .lacks =
        "Metallic is 0 or 1, not between. The albedo that scales the diffuse layer is exact here and tabulated there. Sheen, coat, "
        "subsurface and transmission are 0. The distribution Multiscatter GGX, which is what new materials have, is another model.",
    FF_TARGET_OF(blender_4, materials)};
