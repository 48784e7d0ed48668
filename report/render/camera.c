/* Where a ray of the viewer meets the unit sphere. */
#include "internal_render.h"
#include "models/tools/internal_sphere.h"

/* The cone that touches the sphere has the half angle b: from the distance 1 / sin b. */
ff_camera ff_camera_of(double perspective)
{
    const double half = 0.5 * perspective;
    return perspective > 0 ? (ff_camera){tan(half), 1 / sin(half)} : (ff_camera){0, 0};
}

int ff_camera_look(const ff_camera *c, double x, double y, double n[3], double view[3])
{
    if (!(c->tangent > 0)) {
        view[0] = view[1] = 0;
        view[2] = 1;
        return ff_sphere_point(x, y, n);
    }
    const double r2 = x * x + y * y, dx = x * c->tangent, dy = y * c->tangent, inv = 1 / sqrt(1 + dx * dx + dy * dy);
    if (!(r2 < 1)) return 0;
    view[0] = -dx * inv;
    view[1] = -dy * inv;
    view[2] = inv;
    /* |c - t view| = 1 for c = (0, 0, distance); what is under the root is distance^2 inv^2 - distance^2 + 1 = (1 - r2) inv^2 */
    const double t = c->distance * inv - inv * sqrt(1 - r2);
    n[0] = -t * view[0];
    n[1] = -t * view[1];
    n[2] = c->distance - t * inv;
    return 1;
}
