/* What the renderers of glTF have in common: roughness^2 = alpha, an index or the base colour for F0, and KHR_materials_anisotropy,
 * which only raises the roughness along one direction: alpha_t = mix(alpha, 1, strength^2), rotated counter-clockwise from the
 * tangent. */
#ifndef FF_GLTF_CONTROLS_H
#define FF_GLTF_CONTROLS_H
#include "targets/conventions/internal_formulas.h"

#define FF_GLTF_STRETCH                                                                                                            \
    {.made = {"anisotropyStrength", {FF_STRETCH}, ff_gltf_strength}, .hi = 1, .unit = "1", .is_of_axis = 1},                       \
    {                                                                                                                              \
        .made = {"anisotropyRotation", {FF_STRETCH}, ff_major_radians}, .hi = 6.2831853071795862, .unit = "rad", .is_of_axis = 1   \
    }
#define FF_GLTF_BACK                                                                                                               \
    {"alpha_x", {"roughnessFactor", "anisotropyStrength", "anisotropyRotation"}, ff_gltf_x},                                       \
        {"alpha_y", {"roughnessFactor", "anisotropyStrength", "anisotropyRotation"}, ff_gltf_y},                                   \
    {                                                                                                                              \
        "r_xy", {"roughnessFactor", "anisotropyStrength", "anisotropyRotation"}, ff_gltf_r                                         \
    }
#define FF_GLTF_ROUGHNESS                                                                                                          \
    {                                                                                                                              \
        .made = {"roughnessFactor", {FF_STRETCH}, ff_gltf_roughness}, .hi = 1, .unit = "1"                                         \
    }
#define FF_GLTF_INDEX                                                                                                              \
    {                                                                                                                              \
        .made = {"ior", {"f0"}, ff_index_of_f0}, .lo = 1, .hi = 1e9, .unit = "1"                                                   \
    }

/* A material with a stretched lobe: what stands under the lobe is in the expression. */
#define FF_GLTF_DIELECTRIC(model)                                                                                                  \
    {                                                                                                                              \
        .name = "dielectric", .title = "pbrMetallicRoughness, metallicFactor 0, KHR_materials_ior", .expression = model,           \
        .bound = {"alpha_x=0.0001:1", "alpha_y=0.0001:1", "f0=0:0.9"}, .shared = {"f0"},                                           \
        .control = {FF_COLOR_CONTROL("baseColorFactor", "kd"), FF_GLTF_ROUGHNESS, FF_GLTF_INDEX, FF_GLTF_STRETCH},                 \
        .parameter = {{"kd", {"baseColorFactor"}, ff_same}, {"f0", {"ior"}, ff_f0_of_index}, FF_GLTF_BACK}, .setting = {           \
            {"metallicFactor", 0}                                                                                                  \
        }                                                                                                                          \
    }
#define FF_GLTF_METAL(model)                                                                                                       \
    {                                                                                                                              \
        .name = "metal", .title = "pbrMetallicRoughness, metallicFactor 1", .expression = model,                                   \
        .bound = {"alpha_x=0.0001:1", "alpha_y=0.0001:1"},                                                                         \
        .control = {FF_COLOR_CONTROL("baseColorFactor", "f0"), FF_GLTF_ROUGHNESS, FF_GLTF_STRETCH},                                \
        .parameter = {{"f0", {"baseColorFactor"}, ff_same}, FF_GLTF_BACK}, .setting = {                                            \
            {"metallicFactor", 1}                                                                                                  \
        }                                                                                                                          \
    }
#endif
