// SPDX-License-Identifier: Apache-2.0
// A picture, depths and labels for each view; the launch index has the view in z. Payload: distance
// (negative: none), label, normal.
#include "tools.h"
#include "training_views.h"

extern "C" {
__constant__ ViewParams params;
}

static __forceinline__ __device__ void trace(OptixTraversableHandle handle, float3 ray_origin,
                                             float3 ray_direction, float tmax, unsigned flags,
                                             float& t, unsigned& label, float3& normal) {
    unsigned p0 = __float_as_uint(0.0f), p1 = 0, p2 = 0, p3 = 0, p4 = 0;
    optixTrace(handle, ray_origin, ray_direction, 1e-3f, tmax, 0.0f, OptixVisibilityMask(255),
               flags, 0, 0, 0, p0, p1, p2, p3, p4);
    t = __uint_as_float(p0);
    label = p1;
    normal = make_float3(__uint_as_float(p2), __uint_as_float(p3), __uint_as_float(p4));
}

extern "C" __global__ void __closesthit__ch() {
    const ViewRecord* rt = reinterpret_cast<ViewRecord*>(optixGetSbtDataPointer());
    const float3 local = rt->mesh.normal(optixGetPrimitiveIndex());
    const float3 n = towardsRay(normalize(optixTransformNormalFromObjectToWorldSpace(local)));
    optixSetPayload_0(__float_as_uint(optixGetRayTmax()));
    optixSetPayload_1(optixGetInstanceId());
    optixSetPayload_2(__float_as_uint(n.x));
    optixSetPayload_3(__float_as_uint(n.y));
    optixSetPayload_4(__float_as_uint(n.z));
}
extern "C" __global__ void __miss__ms() {
    optixSetPayload_0(__float_as_uint(-1.0f));
}

DEVICE bool isFree(float3 from, float3 direction, float reach) {
    float t;
    unsigned label;
    float3 normal;
    trace(params.world, from, direction, reach,
          OPTIX_RAY_FLAG_TERMINATE_ON_FIRST_HIT | OPTIX_RAY_FLAG_DISABLE_CLOSESTHIT, t, label,
          normal);
    return t < 0.0f;
}

extern "C" __global__ void __raygen__rg() {
    const uint3 idx = optixGetLaunchIndex();
    const unsigned view = params.firstView + idx.z;
    const unsigned x = view % params.across * params.viewWidth + idx.x;
    const unsigned y = view / params.across * params.viewHeight + idx.y;
    const unsigned pixel = y * params.across * params.viewWidth + x;
    const Camera& camera = params.cameras[view];
    const float3 direction = cameraDirection(camera, (idx.x + 0.5f) / params.viewWidth,
                                             (idx.y + 0.5f) / params.viewHeight);
    float t;
    unsigned label;
    float3 normal;
    trace(params.world, camera.eye, direction, 1e16f, OPTIX_RAY_FLAG_NONE, t, label, normal);
    const unsigned at = (view * params.viewHeight + idx.y) * params.viewWidth + idx.x;
    params.depths[at] = t;
    params.labels[at] = label;
    if (t < 0.0f) {
        params.image[pixel] = withWeight(blueSky(direction), 1.0f);
        return;
    }
    const float3 point = camera.eye + direction * t + normal * 1e-3f;
    unsigned random = hashPcg(at), open = 0;
    constexpr unsigned kRays = 4;
    for (unsigned i = 0; i < kRays; ++i) {
        const float u = nextFloat(random), v = nextFloat(random);
        open += isFree(point, cosineDirection(normal, u, v), 3.0f);
    }
    float3 light = blueSky(normal) * (0.6f * open / kRays);
    const float cosine = dot(normal, params.sun);
    if (cosine > 0.0f && isFree(point, params.sun, 1e16f))
        light += vec(1.2f, 1.1f, 0.95f) * cosine;
    const unsigned paint = hashPcg(label);
    const float3 color = vec(0.3f + (paint & 255u) / 400.0f, 0.3f + (paint >> 8 & 255u) / 400.0f,
                             0.3f + (paint >> 16 & 255u) / 400.0f);
    params.image[pixel] = withWeight((label == 0 ? vec(0.5f) : color) * light, 1.0f);
}
