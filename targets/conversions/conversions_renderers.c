/* Roughness, anisotropy and rotation as renderers have them, in terms of the ellipse of slopes. The formulas are those by which a
 * fit is made for a renderer (targets/conventions). Rotations are in the unit that the renderer takes. */
#include "internal_conversions.h"
#include "targets/conventions/internal_formulas.h"
#include <math.h>

#define PI FF_CONVERSION_PI

/* alpha_x, alpha_y, r_xy of three controls, and the controls of these. */
#define CONVENTION(id, x, y, r, first, second, third)                                                                              \
    static const char *id##_to_correlated(const double *in, double *out)                                                           \
    {                                                                                                                              \
        out[0] = x(in, NULL), out[1] = y(in, NULL), out[2] = r(in, NULL) + 0.0;                                                    \
        return fabs(out[2]) < 1 ? NULL : "so flat an ellipse that r_xy rounds to 1, and r_xy must lie in (-1, 1)";                 \
    }                                                                                                                              \
    static const char *id##_of_correlated(const double *in, double *out)                                                           \
    {                                                                                                                              \
        out[0] = first(in, NULL), out[1] = fmax(second(in, NULL), 0), out[2] = third(in, NULL);                                    \
        return NULL;                                                                                                               \
    }
CONVENTION(disney, ff_disney_x, ff_disney_y, ff_disney_r, ff_mean_roughness, ff_disney_anisotropy, ff_major_turns)
CONVENTION(glossy, ff_glossy_x, ff_glossy_y, ff_glossy_r, ff_mean_roughness, ff_glossy_anisotropy, ff_minor_turns)
CONVENTION(aspect, ff_aspect_x, ff_aspect_y, ff_aspect_r, ff_mean_roughness, ff_aspect_anisotropy, ff_major_turns)
CONVENTION(gltf, ff_gltf_x, ff_gltf_y, ff_gltf_r, ff_gltf_roughness, ff_gltf_strength, ff_major_radians)
CONVENTION(openpbr, ff_openpbr_x, ff_openpbr_y, ff_openpbr_r, ff_openpbr_roughness, ff_aspect_anisotropy, ff_major_turns)
CONVENTION(axes, ff_axes_x, ff_axes_y, ff_axes_r, ff_alpha_major, ff_alpha_minor, ff_major_degrees)

/* a1, a2 = roughness^2 (1 +- anisotropy): Kulla and Conty's. */
static const char *filament_to_correlated(const double *in, double *out)
{
    const double alpha = in[0] * in[0], axes[3] = {alpha * (1 + in[1]), alpha * (1 - in[1]), in[2]};
    return axes_to_correlated(axes, out);
}

static const char *filament_of_correlated(const double *in, double *out)
{
    const double a1 = ff_alpha_major(in, NULL), a2 = ff_alpha_minor(in, NULL);
    out[0] = sqrt((a1 + a2) / 2);
    out[1] = fmax((a1 - a2) / (a1 + a2), 0);
    out[2] = ff_major_degrees(in, NULL);
    return NULL;
}

static const char beyond[] = "above 1: the roughness of the renderer ends there";

static const char *doubt_in(const double *in, const double *out)
{
    (void)out;
    return in[0] > 1 ? beyond : NULL;
}

static const char *doubt_out(const double *in, const double *out)
{
    (void)in;
    return out[0] > 1 ? beyond : NULL;
}

static const char *doubt_above_4(const double *in, const double *out)
{
    (void)in;
    return out[0] > 4 ? "above 4: no renderer is that rough" : NULL;
}

/* ---- the table ------------------------------------------------------------------------------- */

#define V_ROUGHNESS(n)                                                                                                             \
    {                                                                                                                              \
        .name = n, .unit = "1", .lo = 0, .hi = INFINITY                                                                            \
    }
/* From 0, which it is where nothing is said, to `most`. */
#define V_SLIDER(n, most)                                                                                                          \
    {                                                                                                                              \
        .name = n, .unit = "1", .lo = 0, .hi = most, .lo_included = 1, .optional = 1                                               \
    }
#define V_ROTATION(n, u)                                                                                                           \
    {                                                                                                                              \
        .name = n, .unit = u, .lo = -INFINITY, .hi = INFINITY, .optional = 1                                                       \
    }
#define V_UP_TO_1 (1 + 0x1p-40) /* 1 itself, and a rounding */
#define V_BELOW_1 1.0

static const char grooves[] =
    "the ellipse of ggx's slopes; grooves run across its major axis, which the rotation turns from the tangent, counter-clockwise";
static const char grooves_along[] =
    "the ellipse of ggx's slopes; grooves run along its minor axis, which the rotation turns from the tangent, counter-clockwise";
static const char tenth[] = "exact; ellipses flatter than 1 to 10 have no number";
static const char exact[] = "exact";

#define BOTH(id, called, formula_text, source_text, assumes_text, limits_text, doubtful_in, doubtful_out, ...)                     \
    {.from = called,                                                                                                               \
     .to = "correlated",                                                                                                           \
     .by = "",                                                                                                                     \
     .formula = formula_text,                                                                                                      \
     .source = source_text,                                                                                                        \
     .assumes = assumes_text,                                                                                                      \
     .limits = limits_text,                                                                                                        \
     .n_in = 3,                                                                                                                    \
     .n_out = 3,                                                                                                                   \
     .in = {__VA_ARGS__},                                                                                                          \
     .out = {V_POSITIVE("alpha_x"), V_POSITIVE("alpha_y"), V_R},                                                                   \
     .apply = id##_to_correlated,                                                                                                  \
     .doubt = doubtful_in},                                                                                                        \
    {                                                                                                                              \
        .from = "correlated", .to = called, .by = "", .formula = "the inverse of: " formula_text, .source = source_text,           \
        .assumes = assumes_text, .limits = limits_text, .n_in = 3, .n_out = 3,                                                     \
        .in = {V_POSITIVE("alpha_x"), V_POSITIVE("alpha_y"), V_R}, .out = {__VA_ARGS__}, .apply = id##_of_correlated,              \
        .doubt = doubtful_out                                                                                                      \
    }

static const ff_conversion renderers[] = {
    BOTH(disney, "disney",
         "alpha_major, alpha_minor = roughness^2 / aspect, roughness^2 aspect; aspect = sqrt(1 - 0.9 anisotropic)",
         "Burley 2012, section 5.4; Blender's and Mitsuba's Principled", grooves, tenth, doubt_in, doubt_out,
         V_ROUGHNESS("roughness"), V_SLIDER("anisotropic", V_UP_TO_1), V_ROTATION("rotation", "turns")),
    BOTH(glossy, "blender-glossy", "alpha_major, alpha_minor = roughness^2 / (1 - anisotropy), roughness^2 (1 - anisotropy)",
         "Blender 3.4, Glossy and Anisotropic BSDF", grooves_along, exact, doubt_in, doubt_out, V_ROUGHNESS("roughness"),
         V_SLIDER("anisotropy", V_BELOW_1), V_ROTATION("rotation", "turns")),
    BOTH(gltf, "gltf", "alpha_minor = roughness^2, alpha_major = alpha_minor + (1 - alpha_minor) strength^2",
         "glTF 2.0; KHR_materials_anisotropy (Khronos 2023)", grooves, "exact for roughness below 1", doubt_in, doubt_out,
         V_ROUGHNESS("roughness"), V_SLIDER("strength", V_UP_TO_1), V_ROTATION("rotation", "radians")),
    BOTH(filament, "filament", "alpha_major, alpha_minor = roughness^2 (1 + anisotropy), roughness^2 (1 - anisotropy)",
         "Kulla and Conty 2017; Filament and Unreal Engine", grooves, exact, doubt_in, doubt_out, V_ROUGHNESS("roughness"),
         V_SLIDER("anisotropy", V_BELOW_1), V_ROTATION("rotation", "degrees")),
    BOTH(openpbr, "openpbr",
         "alpha_major = roughness^2 sqrt(2 / (1 + (1 - anisotropy)^2)), alpha_minor = (1 - anisotropy) alpha_major",
         "OpenPBR 1.1; MaterialX 1.39", grooves, exact, doubt_in, doubt_out, V_ROUGHNESS("roughness"),
         V_SLIDER("anisotropy", V_BELOW_1), V_ROTATION("rotation", "turns")),
    BOTH(aspect, "standard-surface",
         "alpha_major, alpha_minor = roughness^2 / aspect, roughness^2 aspect; aspect = sqrt(1 - anisotropy)",
         "Autodesk Standard Surface; MaterialX 1.38", grooves, exact, doubt_in, doubt_out, V_ROUGHNESS("roughness"),
         V_SLIDER("anisotropy", V_BELOW_1), V_ROTATION("rotation", "turns")),
    BOTH(axes, "mitsuba", "alpha_major = alpha_u, alpha_minor = alpha_v",
         "Mitsuba 3, roughconductor; pbrt-v4 with remaproughness false", grooves, exact, NULL, doubt_above_4, V_POSITIVE("alpha_u"),
         V_POSITIVE("alpha_v"), V_ROTATION("rotation", "degrees")),
};

FF_CONVERSION_GROUP(renderers, renderers);
