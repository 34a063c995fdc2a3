// SPDX-License-Identifier: Apache-2.0
// One ray for each pixel. The closest-hit and miss programs return their colour through three
// payload values.
#include <optix.h>

#include "params.h"

extern "C" {
__constant__ Params params;
}

static __forceinline__ __device__ void setColor(float3 color) {
    optixSetPayload_0(__float_as_uint(color.x));
    optixSetPayload_1(__float_as_uint(color.y));
    optixSetPayload_2(__float_as_uint(color.z));
}

extern "C" __global__ void __raygen__camera() {
    uint3 index = optixGetLaunchIndex();
    uint3 size = optixGetLaunchDimensions();
    float3 direction =
        cameraDirection(params.camera, (index.x + 0.5f) / size.x, (index.y + 0.5f) / size.y);
    unsigned red = 0, green = 0, blue = 0;
    optixTrace(params.scene, params.camera.eye, direction,
               0.0f,  // nearest hit that counts
               1e16f, // farthest
               0.0f,  // time, for motion blur
               OptixVisibilityMask(255), OPTIX_RAY_FLAG_NONE,
               0, // SBT offset,
               1, // SBT stride
               0, // and miss record
               red, green, blue);
    float4 color;
    color.x = __uint_as_float(red);
    color.y = __uint_as_float(green);
    color.z = __uint_as_float(blue);
    color.w = 1.0f;
    params.image[index.y * size.x + index.x] = color;
}

extern "C" __global__ void __miss__background() {
    const MissData* data = reinterpret_cast<const MissData*>(optixGetSbtDataPointer());
    setColor(data->color);
}

// Barycentric coordinates are the weights of the second and third corner at a hit.
extern "C" __global__ void __closesthit__triangle() {
    const TriangleData* data = reinterpret_cast<const TriangleData*>(optixGetSbtDataPointer());
    float2 weights = optixGetTriangleBarycentrics();
    setColor(data->corners[0] * (1.0f - weights.x - weights.y) + data->corners[1] * weights.x +
             data->corners[2] * weights.y);
}
