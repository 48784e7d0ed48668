/* three.js r170: MeshStandardMaterial and MeshPhysicalMaterial under lights.
 *
 * ggx with Smith's height-correlated masking, Karis' form of Schlick's term, and Lambert's whole beside it. Roughness below 0.0525
 * is raised to it, and what the normals of a curved mesh turn by in a pixel is added. */
#include "gltf_controls.h"

static const ff_material materials[] = {FF_GLTF_DIELECTRIC("ggx/smith-height-correlated/schlick-karis+lambert"),
                                        FF_GLTF_METAL("ggx/smith-height-correlated/schlick-karis")};

const ff_target ff_target_three_r170 = {
    .name = "three-r170",
    .alias = {"three-0.170.0"},
    .title = "three.js, a glTF material under lights",
    .version = "r170",
    .source = "three.js r170, lights_physical_pars_fragment; Karis 2013",
    .lacks =
        "metalness is 0 or 1, not between. A roughness below 0.0525 is raised to it, and one of a curved mesh by how its normals "
        "turn. Of a stretched lobe G / (4 cos cos) is cut at 1, towards grazing angles. Light from an "
        "environment is computed otherwise. Clearcoat, sheen, iridescence and transmission are not fitted.",
    .rendered = "tests/renderers: three.js 0.170.0 in Chromium",
    FF_TARGET_OF(three_r170, materials)};
