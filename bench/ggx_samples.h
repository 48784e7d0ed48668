/** @file ggx_samples.h  The one data set of the solver benchmarks, the same for the plain Ceres program and for facetfit.
 *
 *  Scattered pairs of directions, uniform over the solid angle within 85 degrees, with the reflectance of a correlated GGX
 *  (height-correlated Smith, Schlick) and multiplicative Gaussian noise, from a fixed seed. Written on its own, without the
 *  library it measures, so that the comparison of the two optima is a check as well. */
#ifndef GGX_SAMPLES_H
#define GGX_SAMPLES_H
#include <cmath>
#include <cstddef>
#include <cstdint>

/** Parameters in the order both programs report them. */
enum { ALPHA_X = 0, ALPHA_Y = 1, R_XY = 2, F0 = 3, N_PARAMS = 4 };
static const double kTruth[N_PARAMS] = {0.2, 0.45, 0.4, 0.9};
static const double kStart[N_PARAMS] = {0.3, 0.3, 0.0, 0.5};
static const double kNoise = 0.02;
static const std::size_t kSamples = 1458000; /* cells of a MERL file */

/** Directions in degrees and the measured value in 1/sr. */
struct Sample {
    double theta_i, phi_i, theta_o, phi_o, value;
};

struct Vec3 {
    double x, y, z;
};

inline Vec3 direction(double theta_deg, double phi_deg)
{
    const double theta = theta_deg * M_PI / 180, phi = phi_deg * M_PI / 180;
    return {std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta)};
}

/** Smith's Lambda of GGX for direction w (heitz 2014, eq. 72 with the projected roughness of eq. 80). */
template <typename T>
T smith_lambda(const T &ax, const T &ay, const T &r, const Vec3 &w)
{
    using std::sqrt;
    const T a2_sin2 = ax * ax * (w.x * w.x) + ay * ay * (w.y * w.y) + r * ax * ay * (2 * w.x * w.y);
    return (sqrt(1.0 + a2_sin2 / (w.z * w.z)) - 1.0) * 0.5;
}

/** f = D F G2 / (4 iz oz), 1/sr, for p = alpha_x, alpha_y, r_xy, F0. */
template <typename T>
T ggx(const T *p, const Vec3 &i, const Vec3 &o)
{
    using std::sqrt;
    const Vec3 sum = {i.x + o.x, i.y + o.y, i.z + o.z};
    const double length = std::sqrt(sum.x * sum.x + sum.y * sum.y + sum.z * sum.z);
    const double hz = sum.z / length, cos_ih = (i.x * sum.x + i.y * sum.y + i.z * sum.z) / length;
    const double mirror = 1 - cos_ih, schlick = mirror * mirror * mirror * mirror * mirror;
    const T &ax = p[ALPHA_X], &ay = p[ALPHA_Y], &r = p[R_XY];
    const T u = (-sum.x / sum.z) / ax, v = (-sum.y / sum.z) / ay;
    const T one_r2 = 1.0 - r * r, q2 = (u * u + v * v - 2.0 * r * u * v) / one_r2, one_q2 = 1.0 + q2;
    const T d = 1.0 / (M_PI * one_q2 * one_q2 * ax * ay * sqrt(one_r2) * (hz * hz * hz * hz));
    const T g = 1.0 / (1.0 + smith_lambda(ax, ay, r, i) + smith_lambda(ax, ay, r, o));
    const T fresnel = p[F0] + (1.0 - p[F0]) * schlick;
    return d * g * fresnel / (4.0 * i.z * o.z);
}

/** The kSamples samples of the surface kTruth with F0 = f0, one after the other: always the same ones. */
class SampleSource
{
  public:
    explicit SampleSource(double f0);
    Sample next();

  private:
    double uniform(); /* in (0, 1] */
    double normal();
    std::uint64_t state_;
    double p_[N_PARAMS];
};

#endif
