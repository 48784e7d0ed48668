/* glTF 2.0: the metallic-roughness material as appendix B of the specification has it, with KHR_materials_ior and _anisotropy.
 *
 * ggx with Smith's height-correlated masking and Schlick's term; the dielectric leaves 1 - F of the light to Lambert's. */
#include "gltf_controls.h"

static const ff_material materials[] = {FF_GLTF_DIELECTRIC("ggx/smith-height-correlated/schlick+fresnel-coupled"),
                                        FF_GLTF_METAL("ggx/smith-height-correlated/schlick")};

const ff_target ff_target_gltf = {
    .name = "gltf",
    .alias = {"gltf-2.0", "khr", "metallic-roughness"},
    .title = "glTF 2.0 metallic-roughness",
    .version = "2.0",
    .source = "Khronos Group 2021, glTF 2.0, appendix B; KHR_materials_ior, KHR_materials_anisotropy",
    .lacks =
        "metallicFactor is 0 or 1, not between. The specification leaves viewers free to do otherwise, and most do: three-r170, "
        "three-r187 and filament are targets of their own. Clearcoat, sheen, transmission and the colour of KHR_materials_specular "
        "are not fitted.",
    FF_TARGET_OF(gltf, materials)};
