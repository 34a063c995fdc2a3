// SPDX-License-Identifier: Apache-2.0
// Subsurface scattering by random walks. Steps below a surface are rays as long as the free path,
// which see only wax. Payload: distance, normal, albedo, reach; of shadow rays the first word.
#include "subsurface.h"
#include "tools.h"

extern "C" __constant__ SubsurfaceParams optixLaunchParams;

enum { RADIANCE_RAY_TYPE = 0, SHADOW_RAY_TYPE, RAY_TYPE_COUNT };
constexpr unsigned kAll = 255, kWax = 2, kMaxVertices = 4;

struct Hit {
    float t; // negative: none
    float3 normal, albedo;
    float reach;
};

extern "C" __global__ void __closesthit__radiance() {
    const SubsurfaceRecord& sbt = *(const SubsurfaceRecord*)optixGetSbtDataPointer();
    const uint3 index = sbt.mesh.indices[optixGetPrimitiveIndex()];
    const float u = optixGetTriangleBarycentrics().x;
    const float v = optixGetTriangleBarycentrics().y;
    float3 N = sbt.mesh.normal(optixGetPrimitiveIndex());
    if (sbt.reach > 0.0f)
        N = (1.0f - u - v) * sbt.normals[index.x] + u * sbt.normals[index.y] +
            v * sbt.normals[index.z];
    N = normalize(optixTransformNormalFromObjectToWorldSpace(N));
    optixSetPayload_0(__float_as_uint(optixGetRayTmax()));
    optixSetPayload_1(__float_as_uint(N.x));
    optixSetPayload_2(__float_as_uint(N.y));
    optixSetPayload_3(__float_as_uint(N.z));
    optixSetPayload_4(__float_as_uint(sbt.albedo.x));
    optixSetPayload_5(__float_as_uint(sbt.albedo.y));
    optixSetPayload_6(__float_as_uint(sbt.albedo.z));
    optixSetPayload_7(__float_as_uint(sbt.reach));
}
extern "C" __global__ void __closesthit__shadow() {}
extern "C" __global__ void __miss__radiance() {
    optixSetPayload_0(__float_as_uint(-1.0f));
}
extern "C" __global__ void __miss__shadow() {
    optixSetPayload_0(1u);
}

DEVICE Hit traceRadiance(float3 origin, float3 direction, float tmax, unsigned mask) {
    unsigned p0, p1, p2, p3, p4, p5, p6, p7;
    optixTrace(optixLaunchParams.world, origin, direction, 1e-4f, tmax, 0.0f, mask,
               OPTIX_RAY_FLAG_DISABLE_ANYHIT, RADIANCE_RAY_TYPE, RAY_TYPE_COUNT, RADIANCE_RAY_TYPE,
               p0, p1, p2, p3, p4, p5, p6, p7);
    Hit hit;
    hit.t = __uint_as_float(p0);
    hit.normal = vec(__uint_as_float(p1), __uint_as_float(p2), __uint_as_float(p3));
    hit.albedo = vec(__uint_as_float(p4), __uint_as_float(p5), __uint_as_float(p6));
    hit.reach = __uint_as_float(p7);
    return hit;
}

DEVICE float3 directLight(float3 point, float3 normal) {
    const float cosine = dot(normal, optixLaunchParams.sun);
    if (cosine <= 0.0f)
        return vec(0.0f);
    unsigned visible = 0u;
    optixTrace(optixLaunchParams.world, point + normal * 1e-3f, optixLaunchParams.sun, 0.0f, 1e20f,
               0.0f, kAll,
               OPTIX_RAY_FLAG_DISABLE_ANYHIT | OPTIX_RAY_FLAG_TERMINATE_ON_FIRST_HIT |
                   OPTIX_RAY_FLAG_DISABLE_CLOSESTHIT,
               SHADOW_RAY_TYPE, RAY_TYPE_COUNT, SHADOW_RAY_TYPE, visible);
    return visible ? optixLaunchParams.sunlight * (cosine / kPi) : vec(0.0f);
}

DEVICE float3 onSphere(unsigned& random) {
    const float z = 2.0f * nextFloat(random) - 1.0f, r = sqrtf(fmaxf(0.0f, 1.0f - z * z));
    const float2 c = circlePoint(nextFloat(random));
    return vec(r * c.x, r * c.y, z);
}

// Moves `point` to where the walk leaves the wax; false if it ends inside.
DEVICE bool walk(float3& point, float3& normal, float3& throughput, const Hit& entry,
                 unsigned& random) {
    const float s = nextFloat(random), t = nextFloat(random);
    float3 direction = cosineDirection(-entry.normal, s, t);
    point = point - entry.normal * 1e-3f;
    for (unsigned step = 0; step < optixLaunchParams.maxSteps; ++step) {
        const float length = -entry.reach * logf(1.0f - nextFloat(random));
        const Hit hit = traceRadiance(point, direction, length, kWax);
        if (hit.t >= 0.0f) {
            point = point + direction * hit.t;
            normal = dot(hit.normal, direction) < 0.0f ? -hit.normal : hit.normal;
            return true;
        }
        point = point + direction * length;
        throughput *= entry.albedo;
        if (maxComponent(throughput) < 0.02f)
            return false;
        direction = onSphere(random);
    }
    return false;
}

DEVICE float3 findLight(float3 origin, float3 direction, unsigned& random) {
    float3 light = vec(0.0f), throughput = vec(1.0f);
    for (unsigned vertex = 0; vertex < kMaxVertices; ++vertex) {
        const Hit hit = traceRadiance(origin, direction, 1e20f, kAll);
        if (hit.t < 0.0f)
            return light + throughput * blueSky(direction) * 0.5f;
        float3 point = origin + direction * hit.t, normal = hit.normal;
        if (dot(normal, direction) > 0.0f)
            normal = -normal;
        const float edge = 1.0f + dot(normal, direction);
        const float gloss = 0.04f + 0.96f * edge * edge * edge * edge * edge;
        if (hit.reach > 0.0f && nextFloat(random) < gloss) {
            origin = point + normal * 1e-3f;
            direction = reflect(direction, normal);
            continue;
        }
        if (hit.reach == 0.0f)
            throughput *= hit.albedo;
        else if (!walk(point, normal, throughput, hit, random))
            break;
        light += throughput * directLight(point, normal);
        origin = point + normal * 1e-3f;
        const float s = nextFloat(random), t = nextFloat(random);
        direction = cosineDirection(normal, s, t);
    }
    return light;
}

extern "C" __global__ void __raygen__renderFrame() {
    const uint3 index = optixGetLaunchIndex(), size = optixGetLaunchDimensions();
    const unsigned pixel = index.x + index.y * size.x;
    unsigned random = hashPcg(pixel);
    float3 sum = vec(0.0f);
    for (unsigned i = 0; i < optixLaunchParams.samples; ++i) {
        const float x = (index.x + nextFloat(random)) / size.x;
        const float y = (index.y + nextFloat(random)) / size.y;
        sum += findLight(optixLaunchParams.camera.eye,
                         cameraDirection(optixLaunchParams.camera, x, y), random);
    }
    optixLaunchParams.image[pixel] = withWeight(sum / float(optixLaunchParams.samples), 1.0f);
}
