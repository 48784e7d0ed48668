/* Mitsuba 3: roughconductor and roughplastic.
 *
 * Both have Smith's separable masking, beckmann with Walter's rational form, and alpha itself. The plastic's diffuse part is what
 * the rough dielectric lets in and out again, (1 - a_i)(1 - a_o) / (1 - its mean), of the linear form (nonlinear = false). */
#include "targets/conventions/internal_formulas.h"

#define AXES                                                                                                                       \
    {.made = {"alpha_u", {FF_STRETCH}, ff_alpha_major}, .lo = 1e-4, .hi = 4, .unit = "1"},                                         \
        {.made = {"alpha_v", {FF_STRETCH}, ff_alpha_minor}, .lo = 1e-4, .hi = 4, .unit = "1"},                                     \
    {                                                                                                                              \
        .made = {"rotation", {FF_STRETCH}, ff_major_degrees}, .hi = 180, .unit = "deg", .is_of_axis = 1                            \
    }
#define AXES_BACK                                                                                                                  \
    {"alpha_x", {"alpha_u", "alpha_v", "rotation"}, ff_axes_x}, {"alpha_y", {"alpha_u", "alpha_v", "rotation"}, ff_axes_y},        \
    {                                                                                                                              \
        "r_xy", {"alpha_u", "alpha_v", "rotation"}, ff_axes_r                                                                      \
    }
#define INDEX                                                                                                                      \
    {.made = {"eta", {"eta"}, ff_same}, .lo = 0.01, .hi = 100, .unit = "1", .is_color = 1},                                        \
    {                                                                                                                              \
        .made = {"k", {"k"}, ff_same}, .lo = 0, .hi = 100, .unit = "1", .is_color = 1                                              \
    }

static const ff_material materials[] = {
    {.name = "plastic",
     .title = "roughplastic, ggx, nonlinear false",
     .expression = "ggx/smith-separable/dielectric+kelemen-matte",
     .shared = {"eta"},
     .control = {FF_COLOR_CONTROL("diffuse_reflectance", "kd"),
                 {.made = {"alpha", {"alpha"}, ff_same}, .lo = 1e-4, .hi = 4, .unit = "1"},
                 {.made = {"int_ior", {"eta"}, ff_same}, .lo = 1, .hi = 100, .unit = "1"}},
     .parameter = {{"kd", {"diffuse_reflectance"}, ff_same}, {"alpha", {"alpha"}, ff_same}, {"eta", {"int_ior"}, ff_same}}},
    {.name = "conductor",
     .title = "roughconductor, ggx",
     .expression = "ggx/smith-separable/conductor",
     .control = {INDEX, AXES},
     .parameter = {{"eta", {"eta"}, ff_same}, {"k", {"k"}, ff_same}, AXES_BACK}},
    {.name = "conductor-beckmann",
     .title = "roughconductor, beckmann",
     .expression = "beckmann-walter/smith-separable/conductor",
     .control = {INDEX, AXES},
     .parameter = {{"eta", {"eta"}, ff_same}, {"k", {"k"}, ff_same}, AXES_BACK}}};

const ff_target ff_target_mitsuba = {
    .name = "mitsuba",
    .alias = {"mitsuba-3"},
    .title = "Mitsuba 3, roughconductor and roughplastic",
    .version = "3.5",
    .source = "Mitsuba 3 documentation, roughconductor and roughplastic; Walter et al. 2007",
    .lacks =
        "rotation is no parameter of the plugin: the tangents of the mesh, or to_world of the shape, have it. The plastic's "
        "transmittances "
        "are tabulated there and exact here. There is one file of its own for measured data, `measured`, which needs no model.",
    FF_TARGET_OF(mitsuba, materials)};
