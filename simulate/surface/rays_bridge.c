#include "rays_bridge.h"
#if __has_include(<embree4/rtcore.h>)
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif
#include <fftw3.h>
#include <math.h>
#include <pthread.h>
#include <stdlib.h>
#include <string.h>

/* ---- FFTW ------------------------------------------------------------------------------------ */

static pthread_mutex_t planner = PTHREAD_MUTEX_INITIALIZER; /* FFTW makes and destroys plans in one thread at a time */

static ff_status transform(size_t nx, size_t ny, double *a, double *h, ff_error *err)
{
    pthread_mutex_lock(&planner);
    fftw_plan plan = fftw_plan_dft_c2r_2d((int)ny, (int)nx, (fftw_complex *)a, h, FFTW_ESTIMATE);
    pthread_mutex_unlock(&planner);
    if (!plan) return ff_error_set(err, FF_ERR_MEMORY, NULL, 0, -1, "no memory for a transform of %zu x %zu heights", nx, ny);
    fftw_execute(plan);
    pthread_mutex_lock(&planner);
    fftw_destroy_plan(plan);
    pthread_mutex_unlock(&planner);
    return FF_OK;
}

/* ---- Embree ---------------------------------------------------------------------------------- */

struct ff_mesh {
    RTCDevice device;
    RTCScene scene;
};

static void mesh_free(ff_mesh *mesh)
{
    if (!mesh) return;
    if (mesh->scene) rtcReleaseScene(mesh->scene);
    if (mesh->device) rtcReleaseDevice(mesh->device);
    free(mesh);
}

static void fill(size_t nx, size_t ny, const double *h, double x0, double y0, double dx, double dy, float *vertex, uint32_t *index)
{
    for (size_t j = 0; j < ny; j++)
        for (size_t i = 0; i < nx; i++) {
            float *v = vertex + 3 * (j * nx + i);
            v[0] = (float)(x0 + dx * (double)i);
            v[1] = (float)(y0 + dy * (double)j);
            v[2] = (float)h[j * nx + i];
        }
    for (size_t j = 0; j + 1 < ny; j++)
        for (size_t i = 0; i + 1 < nx; i++) {
            uint32_t *t = index + 6 * (j * (nx - 1) + i);
            const uint32_t a = (uint32_t)(j * nx + i), b = a + 1, c = a + (uint32_t)nx, d = c + 1;
            t[0] = a, t[1] = b, t[2] = c;
            t[3] = d, t[4] = c, t[5] = b;
        }
}

static ff_status build(ff_mesh *mesh, size_t nx, size_t ny, const double *h, double x0, double y0, double dx, double dy)
{
    const size_t triangles = 2 * (nx - 1) * (ny - 1);
    mesh->device = rtcNewDevice("threads=1,set_affinity=0");
    if (!mesh->device) return FF_ERR_INTERNAL;
    mesh->scene = rtcNewScene(mesh->device);
    RTCGeometry geometry = rtcNewGeometry(mesh->device, RTC_GEOMETRY_TYPE_TRIANGLE);
    if (!mesh->scene || !geometry) return FF_ERR_MEMORY;
    float *vertex = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 3 * sizeof *vertex, nx * ny);
    uint32_t *index = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 3 * sizeof *index, triangles);
    if (vertex && index) {
        fill(nx, ny, h, x0, y0, dx, dy, vertex, index);
        rtcCommitGeometry(geometry);
        rtcAttachGeometry(mesh->scene, geometry);
    }
    rtcReleaseGeometry(geometry);
    if (!vertex || !index) return FF_ERR_MEMORY;
    rtcSetSceneFlags(mesh->scene, RTC_SCENE_FLAG_ROBUST);
    rtcCommitScene(mesh->scene);
    const enum RTCError error = rtcGetDeviceError(mesh->device);
    return error == RTC_ERROR_NONE ? FF_OK : error == RTC_ERROR_OUT_OF_MEMORY ? FF_ERR_MEMORY : FF_ERR_INTERNAL;
}

static ff_status mesh_new(size_t nx, size_t ny, const double *h, double x0, double y0, double dx, double dy, ff_mesh **out,
                          ff_error *err)
{
    ff_mesh *mesh = calloc(1, sizeof *mesh);
    const ff_status status = mesh ? build(mesh, nx, ny, h, x0, y0, dx, dy) : FF_ERR_MEMORY;
    if (status == FF_OK) {
        *out = mesh;
        return FF_OK;
    }
    mesh_free(mesh);
    return ff_error_set(err, status, NULL, 0, -1, "%s of %zu x %zu heights",
                        status == FF_ERR_MEMORY ? "no memory for a mesh" : "Embree makes no mesh", nx, ny);
}

static void trace(const ff_mesh *mesh, size_t n, ff_ray *ray)
{
#if RTC_VERSION_MAJOR >= 4
    RTCIntersectArguments how;
    rtcInitIntersectArguments(&how);
#else
    struct RTCIntersectContext how;
    rtcInitIntersectContext(&how);
#endif
    for (size_t k = 0; k < n; k++) {
        struct RTCRayHit at;
        memset(&at, 0, sizeof at);
        at.ray.org_x = ray[k].o[0], at.ray.org_y = ray[k].o[1], at.ray.org_z = ray[k].o[2];
        at.ray.dir_x = ray[k].d[0], at.ray.dir_y = ray[k].d[1], at.ray.dir_z = ray[k].d[2];
        at.ray.tfar = ray[k].far;
        at.ray.mask = 0xffffffffu;
        at.hit.geomID = at.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
#if RTC_VERSION_MAJOR >= 4
        rtcIntersect1(mesh->scene, &at, &how);
#else
        rtcIntersect1(mesh->scene, &how, &at);
#endif
        const int met = at.hit.geomID != RTC_INVALID_GEOMETRY_ID;
        ray[k].t = met ? at.ray.tfar : -1;
        ray[k].triangle = met ? at.hit.primID : 0;
    }
}

__attribute__((visibility("default"))) const ff_rays ff_rays_v1 = {FF_RAYS, transform, mesh_new, mesh_free, trace};
