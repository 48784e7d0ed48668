/* Mitsuba 3: the principled BSDF, after Burley 2012 and 2015. ggx with Smith's separable masking; the dielectric's Fresnel is
 * exact, that of metals Schlick's from the base colour; the diffuse part is Disney's. */
#include "targets/conventions/internal_formulas.h"

static const ff_material materials[] = {
    {.name = "dielectric",
     .title = "principled, metallic 0",
     .expression = "ggx/smith-separable/dielectric+disney-coupled",
     .bound = {"alpha=0.0001:1", "eta=1:3"},
     .shared = {"eta"},
     .control = {FF_COLOR_CONTROL("base_color", "kd"),
                 FF_ROUGHNESS_CONTROL("roughness"),
                 {.made = {"eta", {"eta"}, ff_same}, .lo = 1, .hi = 3, .unit = "1"}},
     .parameter = {{"kd", {"base_color"}, ff_same}, {"alpha", {"roughness"}, ff_squared}, {"eta", {"eta"}, ff_same}},
     .setting = {{"metallic", 0}}},
    {.name = "metal",
     .title = "principled, metallic 1",
     .expression = "ggx/smith-separable/schlick",
     .bound = {"alpha_x=0.0001:1", "alpha_y=0.0001:1"},
     .control = {FF_COLOR_CONTROL("base_color", "f0"),
                 {.made = {"roughness", {FF_STRETCH}, ff_mean_roughness}, .hi = 1, .unit = "1"},
                 {.made = {"anisotropic", {FF_STRETCH}, ff_disney_anisotropy}, .hi = 1, .unit = "1", .is_of_axis = 1},
                 {.made = {"rotation", {FF_STRETCH}, ff_major_turns}, .hi = 1, .unit = "turns", .is_of_axis = 1}},
     .parameter = {{"f0", {"base_color"}, ff_same},
                   {"alpha_x", {"roughness", "anisotropic", "rotation"}, ff_disney_x},
                   {"alpha_y", {"roughness", "anisotropic", "rotation"}, ff_disney_y},
                   {"r_xy", {"roughness", "anisotropic", "rotation"}, ff_disney_r}},
     .setting = {{"metallic", 1}}}};

const ff_target ff_target_mitsuba_principled = {.name = "mitsuba-principled",
                                                .title = "Mitsuba 3, principled",
                                                .version = "3.5",
                                                .source = "Mitsuba 3 documentation, principled; Burley 2012 and 2015",
                                                .lacks = "metallic is 0 or 1, not between. rotation is no parameter of the plugin: "
                                                         "the tangents of the mesh have it. flatness, sheen, "
                                                         "clearcoat and transmission are 0.",
                                                FF_TARGET_OF(mitsuba_principled, materials)};
