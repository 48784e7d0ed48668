/* ALTA's coordinates as pairs of directions; which meaning is read where its code has two is at the head of format_alta.c. */
#include "internal_alta.h"
#include "data_formats/table/internal_table.h"
#include <math.h>
#include <string.h>

static const double pi = 3.14159265358979323846;
static const double theta_max = 3.14159265358979323846 + 1e-6; /* files round pi to the digits they have */

static ff_alta_conversion thetas(double a, double b)
{
    return fabs(a) <= theta_max && fabs(b) <= theta_max ? FF_ALTA_PAIR : FF_ALTA_WRONG;
}

static void set_direction(double x, double y, double z, double angle[2])
{
    angle[0] = atan2(hypot(x, y), z);
    angle[1] = atan2(y, x);
}

static void set_pair(double theta_l, double phi_l, double theta_v, double phi_v, double angle[4])
{
    angle[0] = theta_l, angle[1] = phi_l, angle[2] = theta_v, angle[3] = phi_v;
}

/* The half vector, and V as it is seen from there. */
static void set_half_difference(double theta_h, double phi_h, double theta_d, double phi_d, double angle[4])
{
    const double q[4] = {theta_h, phi_h, theta_d, phi_d + pi}; /* of L, which is on the other side of the half vector */
    ff_axes_angles(FF_AXES_HALF_DIFFERENCE, 1, q, angle);
}

static ff_alta_conversion rusin_th_ph_td_pd(const double *x, double *angle)
{
    set_half_difference(x[0], x[1], x[2], x[3], angle);
    return thetas(x[0], x[2]);
}

static ff_alta_conversion rusin_th_ph_td(const double *x, double *angle)
{
    set_half_difference(x[0], x[1], x[2], pi / 2, angle);
    return thetas(x[0], x[2]);
}

static ff_alta_conversion rusin_th_td_pd(const double *x, double *angle)
{
    set_half_difference(x[0], 0, x[1], x[2], angle);
    return thetas(x[0], x[1]);
}

static ff_alta_conversion rusin_th_td(const double *x, double *angle)
{
    set_half_difference(x[0], 0, x[1], pi / 2, angle);
    return thetas(x[0], x[1]);
}

static ff_alta_conversion cos_th_td(const double *x, double *angle)
{
    if (!(fabs(x[0]) <= 1 && fabs(x[1]) <= 1)) return FF_ALTA_WRONG;
    set_half_difference(acos(x[0]), 0, acos(x[1]), pi / 2, angle);
    return FF_ALTA_PAIR;
}

static int is_unit(const double *v)
{
    return fabs(hypot(hypot(v[0], v[1]), v[2]) - 1) <= 0.01;
}

static ff_alta_conversion rusin_vh_vd(const double *x, double *angle)
{
    if (!is_unit(x) || !is_unit(x + 3)) return FF_ALTA_WRONG;
    double h[2], d[2];
    set_direction(x[0], x[1], x[2], h);
    set_direction(x[3], x[4], x[5], d);
    set_half_difference(h[0], h[1], d[0], d[1], angle);
    return FF_ALTA_PAIR;
}

static ff_alta_conversion spherical(const double *x, double *angle)
{
    set_pair(x[0], x[1], x[2], x[3], angle);
    return thetas(x[0], x[2]);
}

static ff_alta_conversion tv_tl_dphi(const double *x, double *angle)
{
    set_pair(x[1], x[2], x[0], 0, angle);
    return thetas(x[0], x[1]);
}

static ff_alta_conversion tl_tv_proj_dphi(const double *x, double *angle)
{
    set_pair(x[0], 0, hypot(x[1], x[2]), atan2(x[2], x[1]), angle);
    return thetas(x[0], angle[2]);
}

/* V is the mirror direction of L, reflected about the back vector K. */
static ff_alta_conversion tl_tk_proj_dphi(const double *x, double *angle)
{
    const double theta = hypot(x[1], x[2]), s = theta > 0 ? sin(theta) / theta : 1;
    const double k[3] = {x[1] * s, x[2] * s, cos(theta)}, l[2] = {sin(x[0]), cos(x[0])}, twice = 2 * (l[1] * k[2] - l[0] * k[0]);
    set_pair(x[0], 0, 0, 0, angle);
    set_direction(twice * k[0] + l[0], twice * k[1], twice * k[2] - l[1], angle + 2);
    return thetas(x[0], theta);
}

/* V at the arc theta_VL from L, the angle phi away from the arc to the normal. */
static ff_alta_conversion tl_tvl_proj_dphi(const double *x, double *angle)
{
    const double arc = hypot(x[1], x[2]), s = arc > 0 ? sin(arc) / arc : 1;
    const double to_normal = x[1] * s, aside = x[2] * s, along = cos(arc), sine = sin(x[0]), cosine = cos(x[0]);
    set_pair(x[0], 0, 0, 0, angle);
    set_direction(along * sine - to_normal * cosine, aside, along * cosine + to_normal * sine, angle + 2);
    return thetas(x[0], arc);
}

static void set_stereographic(const double *u, double angle[2])
{
    const double r = hypot(u[0], u[1]);
    angle[0] = 2 * atan(r);
    angle[1] = atan2(u[1], u[0]);
}

static ff_alta_conversion stereographic(const double *x, double *angle)
{
    set_stereographic(x, angle + 2);
    set_stereographic(x + 2, angle);
    return FF_ALTA_PAIR;
}

static ff_alta_conversion no_pair(double *angle)
{
    set_pair(pi, 0, pi, 0, angle); /* both below the surface, as ALTA has it */
    return FF_ALTA_NO_PAIR;
}

/* L = H + B, V = H - B with |H|^2 + |B|^2 = 1, H orthogonal to B. |x and y of H|, |B|, and the azimuth from H to B. */
static ff_alta_conversion set_stark(double h, double b, double phi, double *angle)
{
    if (!(h >= 0 && b >= 0)) return FF_ALTA_WRONG;
    if (!(h * h + b * b <= 1)) return no_pair(angle);
    const double hz = sqrt(1 - h * h - b * b), n = hypot(hz, h * cos(phi));
    const double sine = n > 0 ? hz / n : 1, bx = b * sine * cos(phi), by = b * sine * sin(phi),
                 bz = n > 0 ? -b * h * cos(phi) / n : 0;
    set_direction(h + bx, by, hz + bz, angle);
    set_direction(h - bx, -by, hz - bz, angle + 2);
    return FF_ALTA_PAIR;
}

static ff_alta_conversion stark_2d(const double *x, double *angle)
{
    return set_stark(x[0], x[1], pi / 2, angle);
}

static ff_alta_conversion stark_3d(const double *x, double *angle)
{
    return set_stark(x[0], x[1], x[2], angle);
}

/* The same with the projections of L and V on the surface. */
static ff_alta_conversion set_neumann(double h, double b, double phi, double *angle)
{
    if (!(h >= 0 && b >= 0)) return FF_ALTA_WRONG;
    const double bx = b * cos(phi), by = b * sin(phi), l = hypot(h + bx, by), v = hypot(h - bx, by);
    if (!(l <= 1 && v <= 1)) return no_pair(angle);
    set_pair(asin(l), atan2(by, h + bx), asin(v), atan2(-by, h - bx), angle);
    return FF_ALTA_PAIR;
}

static ff_alta_conversion neumann_2d(const double *x, double *angle)
{
    return set_neumann(x[0], x[1], pi / 2, angle);
}

static ff_alta_conversion neumann_3d(const double *x, double *angle)
{
    return set_neumann(x[0], x[1], x[2], angle);
}

static ff_alta_conversion cartesian(const double *x, double *angle)
{
    if (!is_unit(x) || !is_unit(x + 3)) return FF_ALTA_WRONG;
    set_direction(x[3], x[4], x[5], angle);
    set_direction(x[0], x[1], x[2], angle + 2);
    return FF_ALTA_PAIR;
}

#define PHI_D_CHOSEN "%s leaves phi_d open: 90 degrees are taken, where both directions have the same polar angle"
#define AZIMUTH_CHOSEN                                                                                                             \
    "%s leaves the azimuth between half and back vector open: 90 degrees are taken, where both directions have the same polar "    \
    "angle"

static const ff_alta_parametrisation parametrisations[] = {
    {"SPHERICAL_TL_PL_TV_PV", 4, 0, spherical, "theta_l, phi_l, theta_v, phi_v in radians", NULL},
    {"ISOTROPIC_TV_TL_DPHI", 3, 1, tv_tl_dphi, "theta_v, theta_l, phi_l - phi_v in radians", NULL},
    {"ISOTROPIC_TL_TV_PROJ_DPHI", 3, 1, tl_tv_proj_dphi, "theta_l, theta_v cos(dphi), theta_v sin(dphi) in radians", NULL},
    {"SCHLICK_TL_TK_PROJ_DPHI", 3, 1, tl_tk_proj_dphi, "theta_l, theta_k cos(phi_k), theta_k sin(phi_k) in radians", NULL},
    {"RETRO_TL_TVL_PROJ_DPHI", 3, 1, tl_tvl_proj_dphi, "theta_l, theta_vl cos(dphi), theta_vl sin(dphi) in radians", NULL},
    {"RUSIN_TH_PH_TD_PD", 4, 0, rusin_th_ph_td_pd, "theta_h, phi_h, theta_d, phi_d in radians", NULL},
    {"RUSIN_TH_PH_TD", 3, 0, rusin_th_ph_td, "theta_h, phi_h, theta_d in radians", PHI_D_CHOSEN},
    {"RUSIN_TH_TD_PD", 3, 1, rusin_th_td_pd, "theta_h, theta_d, phi_d in radians", NULL},
    {"RUSIN_TH_TD", 2, 1, rusin_th_td, "theta_h, theta_d in radians", PHI_D_CHOSEN},
    {"RUSIN_VH_VD", 6, 0, rusin_vh_vd, "two unit vectors", NULL},
    {"COS_TH_TD", 2, 1, cos_th_td, "two cosines", PHI_D_CHOSEN},
    {"STEREOGRAPHIC", 4, 0, stereographic, "two points of the plane", NULL},
    {"STARK_2D", 2, 1, stark_2d, "two lengths >= 0", AZIMUTH_CHOSEN},
    {"STARK_3D", 3, 1, stark_3d, "two lengths >= 0 and an angle", NULL},
    {"NEUMANN_2D", 2, 1, neumann_2d, "two lengths >= 0", AZIMUTH_CHOSEN},
    {"NEUMANN_3D", 3, 1, neumann_3d, "two lengths >= 0 and an angle", NULL},
    {"CARTESIAN", 6, 0, cartesian, "two unit vectors", NULL},
    {"RUSIN_VH", 3, 0, NULL, "the half vector", NULL},
    {"COS_TH", 1, 1, NULL, "the angle between half vector and normal", NULL},
    {"SCHLICK_TK_PK", 2, 0, NULL, "the back vector", NULL},
    {"SCHLICK_VK", 3, 0, NULL, "the back vector", NULL},
    {"SCHLICK_VH", 3, 0, NULL, "the back vector", NULL}, /* ALTA's own misspelling of SCHLICK_VK */
    {"COS_TK", 1, 1, NULL, "the angle between back vector and normal", NULL},
    {"COS_TLV", 1, 1, NULL, "the angle between light and view", NULL},
    {"COS_TLR", 1, 1, NULL, "the angle between light and mirrored view", NULL},
    {"ISOTROPIC_TV_TL", 2, 1, NULL, "the two polar angles", NULL},
    {"ISOTROPIC_TV_PROJ_DPHI", 2, 1, NULL, "the view seen from the azimuth of the light", NULL},
    {"ISOTROPIC_TD_PD", 2, 1, NULL, "the difference of two directions", NULL},
};

const ff_alta_parametrisation *ff_alta_parametrisation_find(const char *name)
{
    for (size_t k = 0; k < sizeof parametrisations / sizeof parametrisations[0]; k++)
        if (strcmp(parametrisations[k].name, name) == 0) return &parametrisations[k];
    return NULL;
}
