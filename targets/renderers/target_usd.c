/* UsdPreviewSurface with the metallic workflow. The specification leaves the lobe to the renderer and says that it is physically
 * plausible; taken here as ggx with Smith's height-correlated masking and Schlick's term, the dielectric leaving 1 - F to
 * Lambert's. */
#include "targets/conventions/internal_formulas.h"

static const ff_material materials[] = {
    {.name = "dielectric",
     .title = "UsdPreviewSurface, metallic 0",
     .expression = "ggx/smith-height-correlated/schlick+fresnel-coupled",
     .hold = {"r_xy=0"},
     .bound = {"alpha_x=0.0001:1", "alpha_y=0.0001:1", "f0=0:0.9"},
     .shared = {"f0", "alpha_y"},
     .control = {FF_COLOR_CONTROL("diffuseColor", "kd"),
                 {.made = {"roughness", {FF_STRETCH}, ff_mean_roughness}, .hi = 1, .unit = "1"},
                 {.made = {"ior", {"f0"}, ff_index_of_f0}, .lo = 1, .hi = 1e9, .unit = "1"}},
     .parameter = {{"kd", {"diffuseColor"}, ff_same},
                   {"f0", {"ior"}, ff_f0_of_index},
                   {"alpha_x", {"roughness"}, ff_squared},
                   {"alpha_y", {"roughness"}, ff_squared}},
     .setting = {{"metallic", 0}, {"useSpecularWorkflow", 0}}},
    {.name = "metal",
     .title = "UsdPreviewSurface, metallic 1",
     .expression = "ggx/smith-height-correlated/schlick",
     .hold = {"r_xy=0"},
     .bound = {"alpha_x=0.0001:1", "alpha_y=0.0001:1"},
     .shared = {"alpha_y"},
     .control = {FF_COLOR_CONTROL("diffuseColor", "f0"),
                 {.made = {"roughness", {FF_STRETCH}, ff_mean_roughness}, .hi = 1, .unit = "1"}},
     .parameter = {{"f0", {"diffuseColor"}, ff_same},
                   {"alpha_x", {"roughness"}, ff_squared},
                   {"alpha_y", {"roughness"}, ff_squared}},
     .setting = {{"metallic", 1}, {"useSpecularWorkflow", 0}}}};

const ff_target ff_target_usd = {
    .name = "usd",
    .alias = {"usd-preview-surface", "UsdPreviewSurface"},
    .title = "USD preview surface",
    .version = "2.6",
    .source = "Pixar 2023, UsdPreviewSurface Specification 2.6",
    .lacks = "metallic is 0 or 1, not between. There is no anisotropy: the two roughnesses are one number. Clearcoat is 0.",
    FF_TARGET_OF(usd, materials)};
