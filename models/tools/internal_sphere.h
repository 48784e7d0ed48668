/* The unit sphere of a picture and the frames of its points: what pictures of lit spheres share, whoever compares or shows them.
 *
 * A square picture of size x size pixels covers x, y in [-1, 1], x to the right, y up, the viewer at +z. The surface at a point has
 * the normal n, which is the point itself, the tangent (0, 1, 0) x n scaled to length 1, which is the direction of the parallel,
 * and the bitangent n x tangent, which is that of the meridian. */
#ifndef FF_INTERNAL_SPHERE_H
#define FF_INTERNAL_SPHERE_H
#include <math.h>
#include <stddef.h>

/* Place of a pixel's centre, (i, j) counted from the left and from the top. */
static inline double ff_sphere_x(size_t size, size_t i)
{
    return (2 * (double)i + 1) / (double)size - 1;
}

static inline double ff_sphere_y(size_t size, size_t j)
{
    return 1 - (2 * (double)j + 1) / (double)size;
}

/* The point in front of (x, y), seen from far away; 0 where the sphere is not. */
static inline int ff_sphere_point(double x, double y, double n[3])
{
    const double z2 = 1 - x * x - y * y;
    if (!(z2 > 0)) return 0;
    n[0] = x;
    n[1] = y;
    n[2] = sqrt(z2);
    return 1;
}

/* The distance of the point n from the axis through the poles, which its frame is divided by. */
static inline double ff_sphere_axis(const double n[3])
{
    return sqrt(n[0] * n[0] + n[2] * n[2]);
}

/* v of the picture in the frame of the point n, s = ff_sphere_axis(n); n is no pole, s = 0. */
static inline void ff_sphere_to_frame(const double n[3], double s, const double v[3], double out[3])
{
    const double inv = 1 / s;
    out[0] = (n[2] * v[0] - n[0] * v[2]) * inv;
    out[1] = s * v[1] - n[1] * (n[0] * v[0] + n[2] * v[2]) * inv;
    out[2] = n[0] * v[0] + n[1] * v[1] + n[2] * v[2];
}

static inline void ff_sphere_to_surface(const double n[3], const double v[3], double out[3])
{
    ff_sphere_to_frame(n, ff_sphere_axis(n), v, out);
}

/* And back: v in the frame of the point n, in that of the picture. */
static inline void ff_sphere_from_frame(const double n[3], double s, const double v[3], double out[3])
{
    const double inv = 1 / s;
    out[0] = (n[2] * v[0] - n[1] * n[0] * v[1]) * inv + n[0] * v[2];
    out[1] = s * v[1] + n[1] * v[2];
    out[2] = (-n[0] * v[0] - n[1] * n[2] * v[1]) * inv + n[2] * v[2];
}
#endif
