/* Unreal Engine: the shading model Default Lit. ggx with the joint Smith masking without roots, Schlick's term with F0 = 0.08
 * specular, and Lambert's whole beside it. */
#include "targets/conventions/internal_formulas.h"

static const ff_material materials[] = {
    {.name = "dielectric",
     .title = "Default Lit, Metallic 0",
     .expression = "ggx/hammon/schlick+lambert",
     .bound = {"alpha=0.0001:1", "f0=0:0.08"},
     .shared = {"f0"},
     .control = {FF_COLOR_CONTROL("Base Color", "kd"),
                 FF_ROUGHNESS_CONTROL("Roughness"),
                 {.made = {"Specular", {"f0"}, ff_specular_of_f0}, .hi = 1, .unit = "1"}},
     .parameter = {{"kd", {"Base Color"}, ff_same}, {"alpha", {"Roughness"}, ff_squared}, {"f0", {"Specular"}, ff_f0_of_specular}},
     .setting = {{"Metallic", 0}}},
    {.name = "metal",
     .title = "Default Lit, Metallic 1",
     .expression = "ggx/hammon/schlick",
     .bound = {"alpha=0.0001:1"},
     .control = {FF_COLOR_CONTROL("Base Color", "f0"), FF_ROUGHNESS_CONTROL("Roughness")},
     .parameter = {{"f0", {"Base Color"}, ff_same}, {"alpha", {"Roughness"}, ff_squared}},
     .setting = {{"Metallic", 1}}}};

const ff_target ff_target_unreal = {.name = "unreal",
                                    .alias = {"ue", "ue4", "ue5"},
                                    .title = "Unreal Engine, Default Lit",
                                    .version = "4.20 to 5.4",
                                    .source = "Karis 2013, Real Shading in Unreal Engine 4; Hammon 2017 (the masking)",
                                    .lacks = "Metallic is 0 or 1, not between. Anisotropy has another shader and is not fitted. An "
                                             "F0 below 0.02 darkens the edge there. "
                                             "Substrate and r.Material.EnergyConservation are other models.",
                                    FF_TARGET_OF(unreal, materials)};
