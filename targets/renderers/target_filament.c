/* Filament: the standard lit material. ggx with Smith's height-correlated masking, Schlick's term, Turquin's 1 + F0 (1/E - 1) on
 * the lobe, and Lambert's whole beside it; F0 = 0.16 reflectance^2. */
#include "targets/conventions/internal_formulas.h"

static const ff_material materials[] = {{.name = "dielectric",
                                         .title = "lit, metallic 0",
                                         .expression = "ggx/smith-height-correlated/schlick+lambert+turquin",
                                         .bound = {"alpha=0.0001:1", "f0=0:0.16"},
                                         .shared = {"f0"},
                                         .control = {FF_COLOR_CONTROL("baseColor", "kd"),
                                                     FF_ROUGHNESS_CONTROL("roughness"),
                                                     {.made = {"reflectance", {"f0"}, ff_reflectance_of_f0}, .hi = 1, .unit = "1"}},
                                         .parameter = {{"kd", {"baseColor"}, ff_same},
                                                       {"alpha", {"roughness"}, ff_squared},
                                                       {"f0", {"reflectance"}, ff_f0_of_reflectance}},
                                         .setting = {{"metallic", 0}}},
                                        {.name = "metal",
                                         .title = "lit, metallic 1",
                                         .expression = "ggx/smith-height-correlated/schlick+turquin",
                                         .bound = {"alpha=0.0001:1"},
                                         .control = {FF_COLOR_CONTROL("baseColor", "f0"), FF_ROUGHNESS_CONTROL("roughness")},
                                         .parameter = {{"f0", {"baseColor"}, ff_same}, {"alpha", {"roughness"}, ff_squared}},
                                         .setting = {{"metallic", 1}}}};

const ff_target ff_target_filament = {.name = "filament",
                                      .title = "Filament, the standard lit material",
                                      .version = "1.5x",
                                      .source = "Guy and Agopian 2018, Physically Based Rendering in Filament; Turquin 2019",
                                      .lacks = "metallic is 0 or 1, not between. Anisotropy is not fitted, since E is that of an "
                                               "isotropic lobe. A roughness below 0.045 is "
                                               "raised to it. On mobile devices the masking is an approximation.",
                                      FF_TARGET_OF(filament, materials)};
