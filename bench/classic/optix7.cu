// SPDX-License-Identifier: Apache-2.0
// The path tracer as OptiX 7 programs.
#include <optix.h>

#include "tracer_math.h"

using namespace twin;

extern "C" {
__constant__ Params params;
}

static __device__ __forceinline__ void* unpack() {
    return reinterpret_cast<void*>(static_cast<unsigned long long>(optixGetPayload_0()) << 32 |
                                   optixGetPayload_1());
}
static __device__ __forceinline__ void trace(V3 origin, V3 direction, unsigned type,
                                             void* payload) {
    const auto address = reinterpret_cast<unsigned long long>(payload);
    unsigned high = unsigned(address >> 32), low = unsigned(address);
    optixTrace(params.traversable, make_float3(origin.x, origin.y, origin.z),
               make_float3(direction.x, direction.y, direction.z), kEpsilon, kFar, 0.0f,
               OptixVisibilityMask(255), OPTIX_RAY_FLAG_NONE, type, kRayTypes, type, high, low);
}

extern "C" __global__ void __raygen__paths() {
    const uint3 index = optixGetLaunchIndex(), size = optixGetLaunchDimensions();
    unsigned seed = hash(index.x + size.x * index.y);
    V3 sum = vec(0, 0, 0);
    for (unsigned i = 0; i < params.samples; ++i) {
        Path p = cameraPath(params.camera, seed, index.x, index.y, size.x, size.y);
        for (unsigned depth = 0; depth < kSegments && !p.done; ++depth)
            trace(p.origin, p.direction, kPathRay, &p);
        sum = sum + p.light;
        seed = p.seed;
    }
    float* pixel = params.picture + 4 * (index.y * size.x + index.x);
    pixel[0] = sum.x / params.samples;
    pixel[1] = sum.y / params.samples;
    pixel[2] = sum.z / params.samples;
    pixel[3] = 1.0f;
}

extern "C" __global__ void __miss__path() {
    meetSky(*static_cast<Path*>(unpack()));
}
extern "C" __global__ void __miss__shadow() {}

static __device__ __forceinline__ void shade(V3 object) {
    const HitData& data = *reinterpret_cast<const HitData*>(optixGetSbtDataPointer());
    Path& path = *static_cast<Path*>(unpack());
    const float3 world =
        optixTransformNormalFromObjectToWorldSpace(make_float3(object.x, object.y, object.z));
    const V3 normal = facing(normalize(vec(world.x, world.y, world.z)), path.direction);
    const V3 point = path.origin + path.direction * optixGetRayTmax();
    path.weight = path.weight * vec(data.albedo);
    const float cosine = sunCosine(normal);
    if (cosine > 0) {
        int blocked = 0;
        trace(point, toSun(), kShadowRay, &blocked);
        if (!blocked)
            addSun(path, cosine);
    }
    scatter(path, point, normal);
}

extern "C" __global__ void __closesthit__mesh() {
    const HitData& data = *reinterpret_cast<const HitData*>(optixGetSbtDataPointer());
    shade(triangleNormal(data.vertices, data.indices, optixGetPrimitiveIndex()));
}
extern "C" __global__ void __closesthit__sphere() {
    shade(vec(__uint_as_float(optixGetAttribute_0()), __uint_as_float(optixGetAttribute_1()),
              __uint_as_float(optixGetAttribute_2())));
}
extern "C" __global__ void __anyhit__shadow() {
    *static_cast<int*>(unpack()) = 1;
    optixTerminateRay();
}

extern "C" __global__ void __intersection__sphere() {
    const HitData& data = *reinterpret_cast<const HitData*>(optixGetSbtDataPointer());
    const float* sphere = data.spheres + 4 * optixGetPrimitiveIndex();
    const float3 o = optixGetObjectRayOrigin(), d = optixGetObjectRayDirection();
    const V3 origin = vec(o.x, o.y, o.z), direction = vec(d.x, d.y, d.z);
    const float tmin = optixGetRayTmin();
    const float t = meetSphere(origin, direction, sphere, tmin, optixGetRayTmax());
    if (t > tmin) {
        const V3 n = origin + direction * t - vec(sphere);
        optixReportIntersection(t, 0, __float_as_uint(n.x), __float_as_uint(n.y),
                                __float_as_uint(n.z));
    }
}
