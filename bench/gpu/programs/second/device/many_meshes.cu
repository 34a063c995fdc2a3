// SPDX-License-Identifier: Apache-2.0
// A path tracer of three bounces for a scene of many meshes with records of their own. Payload
// types: of paths, whose words closest-hit programs write; of shadow rays.
#include "many_meshes.h"
#include "tools.h"

extern "C" {
__constant__ CityParams params;
}

constexpr unsigned kRayTypes = 2;

// The words of the payload type of paths.
struct Bounce {
    float3 origin, direction, weight;
    float3 normal; // of the surface
    float matt;    // share of light from the sun; negative: no surface
    unsigned random;
};

DEVICE void setBounce(float3 origin, float3 direction, float3 weight, float3 normal, float matt,
                      unsigned random) {
    optixSetPayload_0(__float_as_uint(origin.x));
    optixSetPayload_1(__float_as_uint(origin.y));
    optixSetPayload_2(__float_as_uint(origin.z));
    optixSetPayload_3(__float_as_uint(direction.x));
    optixSetPayload_4(__float_as_uint(direction.y));
    optixSetPayload_5(__float_as_uint(direction.z));
    optixSetPayload_6(__float_as_uint(weight.x));
    optixSetPayload_7(__float_as_uint(weight.y));
    optixSetPayload_8(__float_as_uint(weight.z));
    optixSetPayload_9(__float_as_uint(normal.x));
    optixSetPayload_10(__float_as_uint(normal.y));
    optixSetPayload_11(__float_as_uint(normal.z));
    optixSetPayload_12(__float_as_uint(matt));
    optixSetPayload_13(random);
}

struct SurfacePoint {
    float3 point, normal, albedo;
};
DEVICE SurfacePoint surfaceOf(const CityRecord& r) {
    const uint3 t = r.indices[optixGetPrimitiveIndex()];
    const float2 b = optixGetTriangleBarycentrics();
    const float3 p0 = r.vertices[t.x], p1 = r.vertices[t.y], p2 = r.vertices[t.z];
    const float3 local = p0 * (1.0f - b.x - b.y) + p1 * b.x + p2 * b.y;
    SurfacePoint s;
    s.normal =
        towardsRay(normalize(optixTransformNormalFromObjectToWorldSpace(cross(p1 - p0, p2 - p0))));
    s.point = optixTransformPointFromObjectToWorldSpace(local) + s.normal * 1e-3f;
    const float4 texel =
        tex2D<float4>(r.albedo, (local.x + local.z) * r.scale, (local.y - local.z) * r.scale);
    s.albedo = r.color * vec(texel.x, texel.y, texel.z);
    return s;
}
DEVICE const CityRecord& cityRecord() {
    return *reinterpret_cast<const CityRecord*>(optixGetSbtDataPointer());
}

extern "C" __global__ void __closesthit__matt() {
    optixSetPayloadTypes(OPTIX_PAYLOAD_TYPE_ID_0);
    const SurfacePoint s = surfaceOf(cityRecord());
    unsigned random = optixGetPayload_13();
    const float u = nextFloat(random), v = nextFloat(random);
    setBounce(s.point, cosineDirection(s.normal, u, v), s.albedo, s.normal, 1.0f, random);
}
extern "C" __global__ void __closesthit__glossy() {
    optixSetPayloadTypes(OPTIX_PAYLOAD_TYPE_ID_0);
    const CityRecord& r = cityRecord();
    const SurfacePoint s = surfaceOf(r);
    unsigned random = optixGetPayload_13();
    const float u = nextFloat(random), v = nextFloat(random);
    const float3 in = optixGetWorldRayDirection();
    const float3 around = cosineDirection(s.normal, u, v);
    const float3 out = normalize(lerp(reflect(in, s.normal), around, r.roughness));
    setBounce(s.point, out, lerp(s.albedo, vec(0.9f), 0.5f), s.normal, 0.3f, random);
}
extern "C" __global__ void __closesthit__coated() {
    optixSetPayloadTypes(OPTIX_PAYLOAD_TYPE_ID_0);
    const SurfacePoint s = surfaceOf(cityRecord());
    unsigned random = optixGetPayload_13();
    const float u = nextFloat(random), v = nextFloat(random), w = nextFloat(random);
    const float3 in = optixGetWorldRayDirection();
    const float edge = 1.0f + dot(in, s.normal);
    const bool isCoat = w < 0.04f + 0.96f * edge * edge * edge * edge * edge;
    setBounce(s.point, isCoat ? reflect(in, s.normal) : cosineDirection(s.normal, u, v),
              isCoat ? vec(1.0f) : s.albedo, s.normal, isCoat ? 0.0f : 1.0f, random);
}
extern "C" __global__ void __miss__path() {
    optixSetPayloadTypes(OPTIX_PAYLOAD_TYPE_ID_0);
    optixSetPayload_12(__float_as_uint(-1.0f));
}
extern "C" __global__ void __miss__shadow() {
    optixSetPayloadTypes(OPTIX_PAYLOAD_TYPE_ID_1);
    optixSetPayload_0(0);
}

DEVICE Bounce traceBounce(float3 origin, float3 direction, unsigned random) {
    unsigned p[14] = {};
    p[13] = random;
    optixTrace(OPTIX_PAYLOAD_TYPE_ID_0, params.world, origin, direction, 1e-4f, 1e16f, 0.0f,
               OptixVisibilityMask(255), OPTIX_RAY_FLAG_DISABLE_ANYHIT, 0, kRayTypes, 0, p[0], p[1],
               p[2], p[3], p[4], p[5], p[6], p[7], p[8], p[9], p[10], p[11], p[12], p[13]);
    Bounce b;
    b.origin = vec(__uint_as_float(p[0]), __uint_as_float(p[1]), __uint_as_float(p[2]));
    b.direction = vec(__uint_as_float(p[3]), __uint_as_float(p[4]), __uint_as_float(p[5]));
    b.weight = vec(__uint_as_float(p[6]), __uint_as_float(p[7]), __uint_as_float(p[8]));
    b.normal = vec(__uint_as_float(p[9]), __uint_as_float(p[10]), __uint_as_float(p[11]));
    b.matt = __uint_as_float(p[12]);
    b.random = p[13];
    return b;
}
DEVICE bool seesSun(float3 origin) {
    unsigned hidden = 1;
    optixTrace(OPTIX_PAYLOAD_TYPE_ID_1, params.world, origin, params.sun, 1e-4f, 1e16f, 0.0f,
               OptixVisibilityMask(255),
               OPTIX_RAY_FLAG_DISABLE_ANYHIT | OPTIX_RAY_FLAG_TERMINATE_ON_FIRST_HIT |
                   OPTIX_RAY_FLAG_DISABLE_CLOSESTHIT,
               1, kRayTypes, 1, hidden);
    return hidden == 0;
}

extern "C" __global__ void __raygen__city() {
    const uint3 index = optixGetLaunchIndex(), size = optixGetLaunchDimensions();
    const unsigned pixel = index.y * size.x + index.x;
    unsigned random = hashPcg(pixel);
    float3 light = vec(0.0f);
    for (unsigned i = 0; i < params.samples; ++i) {
        float3 origin = params.camera.eye, throughput = vec(1.0f);
        float3 direction = cameraDirection(params.camera, (index.x + nextFloat(random)) / size.x,
                                           (index.y + nextFloat(random)) / size.y);
        for (unsigned depth = 0; depth < params.maxDepth; ++depth) {
            const Bounce b = traceBounce(origin, direction, random);
            if (b.matt < 0.0f) {
                light += throughput * blueSky(direction);
                break;
            }
            random = b.random;
            throughput *= b.weight;
            const float cosine = dot(b.normal, params.sun);
            if (b.matt > 0.0f && cosine > 0.0f && seesSun(b.origin))
                light += throughput * vec(1.5f, 1.4f, 1.2f) * (cosine * b.matt);
            origin = b.origin;
            direction = b.direction;
        }
    }
    params.image[pixel] = withWeight(light / float(params.samples), 1.0f);
}
