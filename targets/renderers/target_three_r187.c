/* three.js r187, as from r186 on: the lobe of r170 times Turquin's 1 + F0 (1/E - 1), the diffuse part times 1 - F.
 *
 * E is read from a table of 16 by 16 there and exact here. */
#include "gltf_controls.h"

static const ff_material materials[] = {
    {.name = "dielectric",
     .title = "pbrMetallicRoughness, metallicFactor 0, KHR_materials_ior",
     .expression = "ggx/smith-height-correlated/schlick-karis+fresnel-coupled+turquin",
     .bound = {"alpha=0.0001:1", "f0=0:0.9"},
     .shared = {"f0"},
     .control = {FF_COLOR_CONTROL("baseColorFactor", "kd"), FF_ROUGHNESS_CONTROL("roughnessFactor"), FF_GLTF_INDEX},
     .parameter = {{"kd", {"baseColorFactor"}, ff_same},
                   {"alpha", {"roughnessFactor"}, ff_squared},
                   {"f0", {"ior"}, ff_f0_of_index}},
     .setting = {{"metallicFactor", 0}}},
    {.name = "metal",
     .title = "pbrMetallicRoughness, metallicFactor 1",
     .expression = "ggx/smith-height-correlated/schlick-karis+turquin",
     .bound = {"alpha=0.0001:1"},
     .control = {FF_COLOR_CONTROL("baseColorFactor", "f0"), FF_ROUGHNESS_CONTROL("roughnessFactor")},
     .parameter = {{"f0", {"baseColorFactor"}, ff_same}, {"alpha", {"roughnessFactor"}, ff_squared}},
     .setting = {{"metallicFactor", 1}}}};

const ff_target ff_target_three_r187 = {
    .name = "three-r187",
    .alias = {"three", "three-0.187.0", "three-r186"},
    .title = "three.js, a glTF material under lights",
    .version = "r186 and r187",
    .source = "three.js r187, lights_physical_pars_fragment; Turquin 2019; Karis 2013",
    .lacks =
        "metalness is 0 or 1, not between. Anisotropy is not fitted, since E is that of an isotropic lobe. A roughness below 0.045 "
        "is raised to it, and one of a curved mesh by how its normals turn; E is read from a small table, which is off by up to "
        "1.1 % at roughness 0.9, seen along the normal. Light from an "
        "environment "
        "is computed otherwise. Clearcoat, sheen, iridescence and transmission are not fitted. r181 to r185 add a term instead.",
    .rendered = "tests/renderers: three.js 0.187.0 in Chromium",
    FF_TARGET_OF(three_r187, materials)};
