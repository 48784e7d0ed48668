/* One ray at one triangle: it must be hit at the distance and the place that the coordinates say, and missed beside it. */
#if __has_include(<embree4/rtcore.h>)
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif
#include <math.h>
#include <stdio.h>

static struct RTCRayHit cast(RTCScene scene, float x, float y)
{
    struct RTCRayHit r = {.ray = {.org_x = x, .org_y = y, .org_z = 3, .dir_z = -1, .tfar = INFINITY, .mask = -1u},
                          .hit = {.geomID = RTC_INVALID_GEOMETRY_ID}};
#if RTC_VERSION_MAJOR >= 4
    rtcIntersect1(scene, &r, NULL);
#else
    struct RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    rtcIntersect1(scene, &context, &r);
#endif
    return r;
}

int main(void)
{
    static const float corner[9] = {0, 0, 1, 4, 0, 1, 0, 4, 1};
    RTCDevice device = rtcNewDevice("threads=1");
    if (!device) {
        printf("no device: error %d\n", (int)rtcGetDeviceError(NULL));
        return 1;
    }
    RTCScene scene = rtcNewScene(device);
    RTCGeometry triangle = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    float *v = rtcSetNewGeometryBuffer(triangle, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 3 * sizeof(float), 3);
    unsigned *index = rtcSetNewGeometryBuffer(triangle, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 3 * sizeof(unsigned), 1);
    for (unsigned k = 0; k < 9; k++) v[k] = corner[k];
    for (unsigned k = 0; k < 3; k++) index[k] = k;
    rtcCommitGeometry(triangle);
    rtcAttachGeometry(scene, triangle);
    rtcCommitScene(scene);
    const struct RTCRayHit at = cast(scene, 1, 2), beside = cast(scene, 3, 3);
    printf("embree %s: distance %g, u %g, v %g; beside it %s\n", RTC_VERSION_STRING, at.ray.tfar, at.hit.u, at.hit.v,
           beside.hit.geomID == RTC_INVALID_GEOMETRY_ID ? "nothing" : "a hit");
    const int right = at.hit.geomID == 0 && fabsf(at.ray.tfar - 2) < 1e-5f && fabsf(at.hit.u - 0.25f) < 1e-5f &&
                      fabsf(at.hit.v - 0.5f) < 1e-5f && beside.hit.geomID == RTC_INVALID_GEOMETRY_ID;
    rtcReleaseGeometry(triangle);
    rtcReleaseScene(scene);
    rtcReleaseDevice(device);
    return !right;
}
