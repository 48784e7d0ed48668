/* OpenPBR 1.1 as MaterialX 1.39 draws it: base metal and dielectric base.
 *
 * alpha_t = roughness^2 sqrt(2 / (1 + (1 - anisotropy)^2)), alpha_b = (1 - anisotropy) alpha_t. ggx with Smith's height-correlated
 * masking; metals with the tint of F82, which is the specular colour; the dielectric layer is put on the diffuse one by its albedo
 * as it is seen. */
#include "targets/conventions/internal_formulas.h"

static const ff_material materials[] = {
    {.name = "dielectric",
     .title = "open_pbr_surface, base_metalness 0, base_diffuse_roughness 0",
     .expression = "ggx/smith-height-correlated/dielectric+albedo-scaled",
     .bound = {"alpha=0.0001:1", "eta=1:3"},
     .shared = {"eta"},
     .control = {FF_COLOR_CONTROL("base_color", "kd"),
                 FF_ROUGHNESS_CONTROL("specular_roughness"),
                 {.made = {"specular_ior", {"eta"}, ff_same}, .lo = 1, .hi = 3, .unit = "1"}},
     .parameter = {{"kd", {"base_color"}, ff_same},
                   {"alpha", {"specular_roughness"}, ff_squared},
                   {"eta", {"specular_ior"}, ff_same}},
     .setting = {{"base_metalness", 0}}},
    {.name = "metal",
     .title = "open_pbr_surface, base_metalness 1",
     .expression = "ggx/smith-height-correlated/schlick-f82",
     .bound = {"alpha_x=0.0001:1", "alpha_y=0.0001:1"},
     .control =
         {FF_COLOR_CONTROL("base_color", "f0"),
          {.made = {"specular_roughness", {FF_STRETCH}, ff_openpbr_roughness}, .hi = 1, .unit = "1"},
          {.made = {"specular_color", {"f0", "f82"}, ff_tint_of_f82}, .hi = 1, .unit = "1", .is_color = 1},
          {.made = {"specular_roughness_anisotropy", {FF_STRETCH}, ff_aspect_anisotropy}, .hi = 1, .unit = "1", .is_of_axis = 1},
          {.made = {"tangent_rotation", {FF_STRETCH}, ff_major_turns}, .hi = 1, .unit = "turns", .is_of_axis = 1}},
     .parameter = {{"f0", {"base_color"}, ff_same},
                   {"f82", {"base_color", "specular_color"}, ff_f82_of_tint},
                   {"alpha_x", {"specular_roughness", "specular_roughness_anisotropy", "tangent_rotation"}, ff_openpbr_x},
                   {"alpha_y", {"specular_roughness", "specular_roughness_anisotropy", "tangent_rotation"}, ff_openpbr_y},
                   {"r_xy", {"specular_roughness", "specular_roughness_anisotropy", "tangent_rotation"}, ff_openpbr_r}},
     .setting = {{"base_metalness", 1}}}};

const ff_target ff_target_openpbr = {.name = "openpbr",
                                     .alias = {"open-pbr", "materialx"},
                                     .title = "OpenPBR surface",
                                     .version = "1.1, MaterialX 1.39",
                                     .source = "Andersson et al. 2024, OpenPBR 1.1; MaterialX 1.39; Kutz et al. 2021",
                                     .lacks = "base_metalness is 0 or 1, not between. MaterialX raises the lobe for multiple "
                                              "scattering and reads albedos from fits; neither "
                                              "is in the model. Coat, fuzz, transmission, subsurface and thin film are 0, "
                                              "base_diffuse_roughness is 0. tangent_rotation is "
                                              "no input of the surface: it turns geometry_tangent.",
                                     FF_TARGET_OF(openpbr, materials)};
