/* The conventions of renderers as functions with derivatives. x and d as ff_formula. */
#ifndef FF_INTERNAL_FORMULAS_H
#define FF_INTERNAL_FORMULAS_H
#include "internal_material.h"

/* ---- one number ------------------------------------------------------------------------------ */

double ff_same(const double *x, double *d);
double ff_square_root(const double *x, double *d); /* roughness of alpha; 0 at 0 has the derivative of 1e-12 */
double ff_squared(const double *x, double *d);
double ff_fourfold(const double *x, double *d); /* clearcoat of ks */
double ff_quarter(const double *x, double *d);

/* R = ((eta - 1) / (eta + 1))^2, and the specular of 0 to 1 that is R / 0.08. */
double ff_f0_of_index(const double *x, double *d);
double ff_index_of_f0(const double *x, double *d);
double ff_specular_of_index(const double *x, double *d);
double ff_index_of_specular(const double *x, double *d);
double ff_specular_of_f0(const double *x, double *d);
double ff_f0_of_specular(const double *x, double *d);
double ff_reflectance_of_f0(const double *x, double *d); /* Filament: F0 = 0.16 reflectance^2 */
double ff_f0_of_reflectance(const double *x, double *d);

/* ---- two numbers ----------------------------------------------------------------------------- */

/* The tint of F82: what F82 is of Schlick's own value there; x = F0, F82 and F0, tint. */
double ff_tint_of_f82(const double *x, double *d);
double ff_f82_of_tint(const double *x, double *d);

/* A conductor by its reflectance r and the edge tint g (Gulbrandsen 2014); x = eta, k and r, g. */
double ff_artistic_r(const double *x, double *d);
double ff_artistic_g(const double *x, double *d);
double ff_artistic_eta(const double *x, double *d);
double ff_artistic_k(const double *x, double *d);

/* ---- the ellipse of alpha_x, alpha_y, r_xy --------------------------------------------------- */

/* Half-axes a1 >= a2, and the angle of the larger in [0, pi), counter-clockwise from x. Where they are equal, 0. */
double ff_alpha_major(const double *x, double *d);
double ff_alpha_minor(const double *x, double *d);
double ff_major_radians(const double *x, double *d);
double ff_major_degrees(const double *x, double *d);
double ff_major_turns(const double *x, double *d);
double ff_minor_turns(const double *x, double *d); /* of the smaller axis, in [0, 1/2) */

double ff_mean_roughness(const double *x, double *d);    /* (a1 a2)^(1/4): Disney, Cycles, standard_surface */
double ff_disney_anisotropy(const double *x, double *d); /* a2 / a1 = 1 - 0.9 an                         */
double ff_glossy_anisotropy(const double *x, double *d); /* a2 / a1 = (1 - an)^2                         */
double ff_aspect_anisotropy(const double *x, double *d); /* a2 / a1 = 1 - an                             */
double ff_gltf_roughness(const double *x, double *d);    /* a2^(1/2)                                     */
double ff_gltf_strength(const double *x, double *d);     /* a1 = a2 + (1 - a2) s^2                       */
double ff_openpbr_roughness(const double *x, double *d); /* ((a1^2 + a2^2) / 2)^(1/4)                    */
double ff_sqrt_major(const double *x, double *d);        /* pbrt's remapped roughness                    */
double ff_sqrt_minor(const double *x, double *d);

/* The ways back: x = roughness, anisotropy, rotation; the last word says which of alpha_x, alpha_y, r_xy. Without derivatives. */
#define FF_WAYS_BACK(convention)                                                                                                   \
    double ff_##convention##_x(const double *x, double *d);                                                                        \
    double ff_##convention##_y(const double *x, double *d);                                                                        \
    double ff_##convention##_r(const double *x, double *d);
FF_WAYS_BACK(disney)
FF_WAYS_BACK(glossy)
FF_WAYS_BACK(aspect)
FF_WAYS_BACK(gltf)
FF_WAYS_BACK(openpbr)
FF_WAYS_BACK(axes)      /* x = a1, a2, degrees                 */
FF_WAYS_BACK(sqrt_axes) /* x = a1^(1/2), a2^(1/2), degrees     */
#undef FF_WAYS_BACK

/* ---- lines that the files of the renderers share ---------------------------------------------- */

#define FF_STRETCH "alpha_x", "alpha_y", "r_xy"
#define FF_COLOR_CONTROL(name, parameter)                                                                                          \
    {                                                                                                                              \
        .made = {name, {parameter}, ff_same}, .hi = 1, .unit = "1", .is_color = 1                                                  \
    }
#define FF_ROUGHNESS_CONTROL(name)                                                                                                 \
    {                                                                                                                              \
        .made = {name, {"alpha"}, ff_square_root}, .hi = 1, .unit = "1"                                                            \
    }
#define FF_TARGET_OF(id, materials) .material = materials, .n_materials = sizeof(materials) / sizeof *(materials)
#endif
