// SPDX-License-Identifier: Apache-2.0
// The programs of OptiX 7. Payload values of radiance rays: colour, distance, bounce; of shadow
// rays: the light that arrives.
#include <optix.h>

#include "modern.h"
#include "shade.h"

extern "C" {
__constant__ Params params;
}

static __device__ __forceinline__ float3 trace(float3 origin, float3 d, unsigned bounce,
                                               float& distance) {
    unsigned r = 0, g = 0, b = 0, t = __float_as_uint(-1.0f);
    optixTrace(params.scene, origin, d, shade::kEpsilon, shade::kFar, 0.0f, 255,
               OPTIX_RAY_FLAG_NONE, shade::kRadiance, shade::kRayTypes, shade::kRadiance, r, g, b,
               t, bounce);
    distance = __uint_as_float(t);
    return shade::vec(__uint_as_float(r), __uint_as_float(g), __uint_as_float(b));
}
static __device__ __forceinline__ float lightAt(float3 point) {
    unsigned light = __float_as_uint(1.0f);
    optixTrace(params.scene, point, shade::toSun(), shade::kEpsilon, shade::kFar, 0.0f, 255,
               OPTIX_RAY_FLAG_NONE, shade::kShadow, shade::kRayTypes, shade::kShadow, light);
    return __uint_as_float(light);
}
static __device__ __forceinline__ void give(float3 color) {
    optixSetPayload_0(__float_as_uint(color.x));
    optixSetPayload_1(__float_as_uint(color.y));
    optixSetPayload_2(__float_as_uint(color.z));
}
static __device__ __forceinline__ float3 hitPoint() {
    return shade::plus(optixGetWorldRayOrigin(),
                       shade::times(optixGetWorldRayDirection(), optixGetRayTmax()));
}
static __device__ __forceinline__ float3 albedo() {
    return reinterpret_cast<const HitData*>(optixGetSbtDataPointer())->albedo;
}

extern "C" __global__ void __raygen__draw() {
    const uint3 i = optixGetLaunchIndex(), size = optixGetLaunchDimensions();
    float4 pixel;
    const float3 color =
        trace(shade::eye(), shade::direction(i.x, i.y, size.x, size.y), 0, pixel.w);
    pixel.x = color.x;
    pixel.y = color.y;
    pixel.z = color.z;
    params.picture[i.y * size.x + i.x] = pixel;
}
extern "C" __global__ void __miss__radiance() {
    give(shade::sky(optixGetWorldRayDirection()));
}
extern "C" __global__ void __miss__shadow() {}

extern "C" __global__ void __closesthit__triangle() {
    const uint3 t = params.triangles[optixGetPrimitiveIndex()];
    const float3 a = params.vertices[t.x], b = params.vertices[t.y], c = params.vertices[t.z];
    const float3 face = shade::outer(shade::minus(b, a), shade::minus(c, a));
    const float3 world = shade::unit(optixTransformNormalFromObjectToWorldSpace(face));
    const float3 n = shade::facing(world, optixGetWorldRayDirection());
    give(shade::diffuse(albedo(), n, lightAt(hitPoint())));
    optixSetPayload_3(__float_as_uint(optixGetRayTmax()));
}
extern "C" __global__ void __closesthit__sphere() {
    const float3 normal =
        shade::vec(__uint_as_float(optixGetAttribute_0()), __uint_as_float(optixGetAttribute_1()),
                   __uint_as_float(optixGetAttribute_2()));
    const float3 world = shade::unit(optixTransformNormalFromObjectToWorldSpace(normal));
    const float3 n = shade::facing(world, optixGetWorldRayDirection());
    float3 color = shade::diffuse(albedo(), n, lightAt(hitPoint()));
    const unsigned bounce = optixGetPayload_4();
    if (bounce < shade::kMaxBounce) {
        float distance;
        const float3 next =
            trace(hitPoint(), shade::mirror(optixGetWorldRayDirection(), n), bounce + 1, distance);
        color = shade::plus(color, shade::times(next, 0.4f));
    }
    give(color);
    optixSetPayload_3(__float_as_uint(optixGetRayTmax()));
}

extern "C" __global__ void __anyhit__block() {
    optixSetPayload_0(__float_as_uint(0.0f));
    optixTerminateRay();
}
extern "C" __global__ void __anyhit__cut() {
    if (shade::isHole(optixGetPrimitiveIndex(), optixGetTriangleBarycentrics()))
        optixIgnoreIntersection();
}
extern "C" __global__ void __anyhit__dim() {
    if (!shade::isHole(optixGetPrimitiveIndex(), optixGetTriangleBarycentrics()))
        optixSetPayload_0(__float_as_uint(__uint_as_float(optixGetPayload_0()) * 0.5f));
    optixIgnoreIntersection();
}

static __device__ __forceinline__ bool report(float3 origin, float3 d, float4 sphere, float t) {
    const float3 n = shade::sphereNormal(origin, d, sphere, t);
    return optixReportIntersection(t, 0, __float_as_uint(n.x), __float_as_uint(n.y),
                                   __float_as_uint(n.z));
}
extern "C" __global__ void __intersection__sphere() {
    const float4 sphere = params.spheres[optixGetPrimitiveIndex()];
    const float3 origin = optixGetObjectRayOrigin(), d = optixGetObjectRayDirection();
    float near, far;
    if (shade::hitSphere(origin, d, sphere, near, far) && !report(origin, d, sphere, near))
        report(origin, d, sphere, far);
}
