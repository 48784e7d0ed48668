/* pbrt-v4: conductor, and coateddiffuse by its mean.
 *
 * ggx with Smith's height-correlated masking; with remaproughness, which is what it does unless told, alpha = sqrt(roughness). The
 * coated diffuse material is a random walk between its layers there; what it is on average is taken here as what the rough
 * dielectric leaves over, as Kelemen couples a matte part. */
#include "targets/conventions/internal_formulas.h"

static const ff_material materials[] = {
    {.name = "coated",
     .title = "coateddiffuse, remaproughness false",
     .expression = "ggx/smith-height-correlated/dielectric+kelemen-matte",
     .bound = {"alpha=0.0001:1", "eta=1:3"},
     .shared = {"eta"},
     .control = {FF_COLOR_CONTROL("reflectance", "kd"),
                 {.made = {"roughness", {"alpha"}, ff_same}, .hi = 1, .unit = "1"},
                 {.made = {"eta", {"eta"}, ff_same}, .lo = 1, .hi = 3, .unit = "1"}},
     .parameter = {{"kd", {"reflectance"}, ff_same}, {"alpha", {"roughness"}, ff_same}, {"eta", {"eta"}, ff_same}}},
    {.name = "conductor",
     .title = "conductor, remaproughness false",
     .expression = "ggx/smith-height-correlated/conductor",
     .bound = {"alpha_x=0.0001:1", "alpha_y=0.0001:1"},
     .control = {{.made = {"eta", {"eta"}, ff_same}, .lo = 0.01, .hi = 100, .unit = "1", .is_color = 1},
                 {.made = {"k", {"k"}, ff_same}, .lo = 0, .hi = 100, .unit = "1", .is_color = 1},
                 {.made = {"uroughness", {FF_STRETCH}, ff_alpha_major}, .hi = 1, .unit = "1"},
                 {.made = {"vroughness", {FF_STRETCH}, ff_alpha_minor}, .hi = 1, .unit = "1"},
                 {.made = {"rotation", {FF_STRETCH}, ff_major_degrees}, .hi = 180, .unit = "deg", .is_of_axis = 1}},
     .parameter = {{"eta", {"eta"}, ff_same},
                   {"k", {"k"}, ff_same},
                   {"alpha_x", {"uroughness", "vroughness", "rotation"}, ff_axes_x},
                   {"alpha_y", {"uroughness", "vroughness", "rotation"}, ff_axes_y},
                   {"r_xy", {"uroughness", "vroughness", "rotation"}, ff_axes_r}}}};

const ff_target ff_target_pbrt = {
    .name = "pbrt",
    .alias = {"pbrt-v4"},
    .title = "pbrt-v4, conductor and coateddiffuse",
    .version = "4",
    .source = "Pharr, Jakob and Humphreys 2023, Physically Based Rendering, sections 9.6 and 14.3; Kelemen and Szirmay-Kalos 2001",
    .lacks = "rotation is no parameter of the material: the uv of the shape have it. coateddiffuse is evaluated by a random walk "
             "there; its "
             "mean is not exactly the model's, and how far it is off was not measured.",
    FF_TARGET_OF(pbrt, materials)};
