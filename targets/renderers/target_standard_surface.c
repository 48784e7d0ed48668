/* Autodesk Standard Surface, which Arnold and MaterialX have.
 *
 * aspect = sqrt(1 - anisotropy), alpha = roughness^2 / aspect and roughness^2 aspect. Metals are conductors whose index is made of
 * the base colour and the specular colour as reflectance and edge tint (Gulbrandsen 2014); the dielectric layer is put on the
 * diffuse one by its albedo as it is seen. */
#include "targets/conventions/internal_formulas.h"

static const ff_material materials[] = {
    {.name = "dielectric",
     .title = "standard_surface, metalness 0, diffuse_roughness 0",
     .expression = "ggx/smith-height-correlated/dielectric+albedo-scaled",
     .bound = {"alpha=0.0001:1", "eta=1:3"},
     .shared = {"eta"},
     .control = {FF_COLOR_CONTROL("base_color", "kd"),
                 FF_ROUGHNESS_CONTROL("specular_roughness"),
                 {.made = {"specular_IOR", {"eta"}, ff_same}, .lo = 1, .hi = 3, .unit = "1"}},
     .parameter = {{"kd", {"base_color"}, ff_same},
                   {"alpha", {"specular_roughness"}, ff_squared},
                   {"eta", {"specular_IOR"}, ff_same}},
     .setting = {{"metalness", 0}, {"base", 1}}},
    {.name = "metal",
     .title = "standard_surface, metalness 1",
     .expression = "ggx/smith-height-correlated/conductor",
     .bound = {"alpha_x=0.0001:1", "alpha_y=0.0001:1"},
     .control = {{.made = {"base_color", {"eta", "k"}, ff_artistic_r}, .hi = 1, .unit = "1", .is_color = 1},
                 {.made = {"specular_color", {"eta", "k"}, ff_artistic_g}, .hi = 1, .unit = "1", .is_color = 1},
                 {.made = {"specular_roughness", {FF_STRETCH}, ff_mean_roughness}, .hi = 1, .unit = "1"},
                 {.made = {"specular_anisotropy", {FF_STRETCH}, ff_aspect_anisotropy}, .hi = 1, .unit = "1", .is_of_axis = 1},
                 {.made = {"specular_rotation", {FF_STRETCH}, ff_major_turns}, .hi = 1, .unit = "turns", .is_of_axis = 1}},
     .parameter = {{"eta", {"base_color", "specular_color"}, ff_artistic_eta},
                   {"k", {"base_color", "specular_color"}, ff_artistic_k},
                   {"alpha_x", {"specular_roughness", "specular_anisotropy", "specular_rotation"}, ff_aspect_x},
                   {"alpha_y", {"specular_roughness", "specular_anisotropy", "specular_rotation"}, ff_aspect_y},
                   {"r_xy", {"specular_roughness", "specular_anisotropy", "specular_rotation"}, ff_aspect_r}},
     .setting = {{"metalness", 1}, {"base", 1}}}};

const ff_target ff_target_standard_surface = {
    .name = "standard-surface",
    .alias = {"standard_surface", "arnold"},
    .title = "Autodesk Standard Surface",
    .version = "1.0.1, MaterialX 1.39",
    .source = "Georgiev et al. 2019, Autodesk Standard Surface; MaterialX 1.39; Gulbrandsen 2014",
    .lacks = "metalness is 0 or 1, not between. MaterialX raises the lobe for multiple scattering, Arnold scatters more than once: "
             "neither is "
             "in the model. Coat, sheen, transmission, subsurface and thin film are 0, diffuse_roughness is 0.",
    FF_TARGET_OF(standard_surface, materials)};
