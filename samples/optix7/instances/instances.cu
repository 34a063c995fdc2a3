// SPDX-License-Identifier: Apache-2.0
// Instances of instances: the geometry is one cube; the closest-hit program reads its place, its
// rotation and the numbers of its copies from the transform list. Payload values: 0 to 2 the
// colour, 3 the number of the bounce and 4 the random state.
#include <optix.h>

#include "params.h"
#include "sampling.h"

extern "C" {
__constant__ Params params;
}

#define DEVICE static __forceinline__ __device__

DEVICE float nextFloat(unsigned& state) {
    unsigned bits = hashPcg(state);
    state = state * 747796405u + 2891336453u;
    return float(bits >> 8) * (1.0f / 16777216.0f);
}

DEVICE float3 skyColor(float3 direction) {
    float height = 0.5f + 0.5f * direction.y;
    return lerp(vec(1.0f, 0.86f, 0.72f), vec(0.3f, 0.5f, 0.9f), sqrtf(height)) * 0.55f;
}

DEVICE float3 trace(float3 origin, float3 direction, unsigned bounce, unsigned random) {
    unsigned red = 0, green = 0, blue = 0;
    optixTrace(params.scene, origin, direction, 0.0f, 1e16f, 0.0f, OptixVisibilityMask(255),
               OPTIX_RAY_FLAG_DISABLE_ANYHIT, 0, 1, 0, red, green, blue, bounce, random);
    return vec(__uint_as_float(red), __uint_as_float(green), __uint_as_float(blue));
}

// Shadow rays keep the payload's first word unless they miss.
DEVICE bool seesSun(float3 origin) {
    unsigned hit = 1, unused = 0;
    optixTrace(params.scene, origin, params.sunDirection, 0.0f, 1e16f, 0.0f,
               OptixVisibilityMask(255),
               OPTIX_RAY_FLAG_DISABLE_ANYHIT | OPTIX_RAY_FLAG_TERMINATE_ON_FIRST_HIT |
                   OPTIX_RAY_FLAG_DISABLE_CLOSESTHIT,
               0, 1, 1, hit, unused, unused, unused, unused);
    return hit == 0;
}

extern "C" __global__ void __raygen__camera() {
    uint3 index = optixGetLaunchIndex();
    uint3 size = optixGetLaunchDimensions();
    unsigned pixel = index.y * size.x + index.x;
    float3 sum = vec(0.0f);
    for (unsigned i = 0; i < params.samples; ++i) {
        unsigned random = hashPcg(pixel) + i * 9781u;
        float x = (index.x + nextFloat(random)) / size.x;
        float y = (index.y + nextFloat(random)) / size.y;
        sum += trace(params.camera.eye, cameraDirection(params.camera, x, y), 0, random);
    }
    float4 color;
    color.x = sum.x / params.samples;
    color.y = sum.y / params.samples;
    color.z = sum.z / params.samples;
    color.w = 1.0f;
    params.image[pixel] = color;
}

DEVICE void setColor(float3 color) {
    optixSetPayload_0(__float_as_uint(color.x));
    optixSetPayload_1(__float_as_uint(color.y));
    optixSetPayload_2(__float_as_uint(color.z));
}

extern "C" __global__ void __miss__sky() {
    setColor(skyColor(optixGetWorldRayDirection()));
}

extern "C" __global__ void __miss__shadow() {
    optixSetPayload_0(0);
}

DEVICE float3 hitPoint() {
    return optixGetWorldRayOrigin() + optixGetWorldRayDirection() * optixGetRayTmax();
}

// Sun, and one diffuse bounce that replaces all others.
DEVICE void shade(float3 color, float3 normal, float3 point) {
    if (dot(normal, optixGetWorldRayDirection()) > 0.0f)
        normal = -normal;
    point += normal * params.epsilon;
    float3 light = vec(0.0f);
    float cosine = dot(normal, params.sunDirection);
    if (cosine > 0.0f && seesSun(point))
        light = vec(1.9f, 1.6f, 1.2f) * cosine;
    unsigned bounce = optixGetPayload_3(), random = optixGetPayload_4();
    if (bounce < 2) {
        float u = nextFloat(random), v = nextFloat(random);
        light += trace(point, cosineDirection(normal, u, v), bounce + 1, random);
    } else {
        light += skyColor(normal) * 0.3f; // in place of all further bounces
    }
    setColor(color * light);
}

// The outermost transforms are first in the list: each level's copy number tints the cube a little.
extern "C" __global__ void __closesthit__cube() {
    float3 tint = vec(0.85f, 0.52f, 0.3f);
    unsigned depth = optixGetTransformListSize();
    for (unsigned level = 0; level < depth; ++level) {
        unsigned copy = optixGetInstanceIdFromHandle(optixGetTransformListHandle(level));
        float share = 0.5f / float((1 + level) * (1 + level));
        float3 own =
            vec(float(copy * 7u % 20u), float(copy * 11u % 20u), float(copy * 3u % 20u)) / 19.0f;
        tint = lerp(tint, own, share);
    }
    // Two triangles a side, in the order -x +x -y +y -z +z.
    unsigned side = optixGetPrimitiveIndex() / 2, axis = side / 2;
    float sign = side & 1 ? 1.0f : -1.0f;
    float3 normal = vec(axis == 0 ? sign : 0.0f, axis == 1 ? sign : 0.0f, axis == 2 ? sign : 0.0f);
    shade(tint * 0.8f, normalize(optixTransformNormalFromObjectToWorldSpace(normal)),
          hitPoint());
}

extern "C" __global__ void __closesthit__ground() {
    // On so large a triangle, the rounding of the hit point exceeds the size of the cubes.
    float3 point = hitPoint();
    point.y = 0.0f;
    shade(vec(0.62f, 0.58f, 0.52f), vec(0.0f, 1.0f, 0.0f), point);
}
