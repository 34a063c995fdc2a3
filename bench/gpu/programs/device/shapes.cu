// SPDX-License-Identifier: Apache-2.0
// Hair of curves and particles of spheres, lit by the sun and the sky. Payload: the colour.
#include "common.h"

DEVICE void setColor(float3 color) {
    optixSetPayload_0(__float_as_uint(color.x));
    optixSetPayload_1(__float_as_uint(color.y));
    optixSetPayload_2(__float_as_uint(color.z));
}
DEVICE bool seesSun(float3 origin) {
    unsigned hidden = 1, no = 0;
    optixTrace(params.scene, origin, params.light[0], 0.0f, 1e16f, 0.0f, OptixVisibilityMask(255),
               OPTIX_RAY_FLAG_DISABLE_ANYHIT | OPTIX_RAY_FLAG_TERMINATE_ON_FIRST_HIT |
                   OPTIX_RAY_FLAG_DISABLE_CLOSESTHIT,
               0, 1, 1, hidden, no, no);
    return hidden == 0;
}
extern "C" __global__ void __raygen__camera() {
    float3 sum = vec(0.0f);
    unsigned random = hashPcg(pixelIndex());
    for (unsigned i = 0; i < params.samples; ++i) {
        unsigned r = 0, g = 0, b = 0;
        optixTrace(params.scene, params.camera.eye, cameraRay(random), 0.0f, 1e16f, 0.0f,
                   OptixVisibilityMask(255), OPTIX_RAY_FLAG_DISABLE_ANYHIT, 0, 1, 0, r, g, b);
        sum += asFloats(r, g, b);
    }
    store(sum / float(params.samples));
}
extern "C" __global__ void __miss__sky() {
    setColor(skyColor(optixGetWorldRayDirection()));
}
extern "C" __global__ void __miss__sun() {
    optixSetPayload_0(0);
}

extern "C" __global__ void __closesthit__hair() {
    const float u = optixGetCurveParameter();
    const unsigned primitive = optixGetPrimitiveIndex();
    float4 p[4];
    float3 tangent;
    if (optixGetPrimitiveType() == OPTIX_PRIMITIVE_TYPE_ROUND_LINEAR) {
        optixGetLinearCurveVertexData(optixGetGASTraversableHandle(), primitive, 0, 0.0f, p);
        tangent = vec(p[1].x - p[0].x, p[1].y - p[0].y, p[1].z - p[0].z);
    } else {
        optixGetCubicBSplineVertexData(optixGetGASTraversableHandle(), primitive, 0, 0.0f, p);
        const float v = 1 - u;
        const float a = -v * v, b = u * (3 * u - 4), c = 1 + u * (2 - 3 * u), d = u * u;
        tangent = vec(p[0].x * a + p[1].x * b + p[2].x * c + p[3].x * d,
                      p[0].y * a + p[1].y * b + p[2].y * c + p[3].y * d,
                      p[0].z * a + p[1].z * b + p[2].z * c + p[3].z * d);
    }
    tangent = normalize(tangent);
    const float3 direction = optixGetWorldRayDirection(), point = hitPoint();
    const float cosine = dot(tangent, params.light[0]);
    const float sine = sqrtf(clamp01(1 - cosine * cosine));
    const float eye = dot(tangent, direction);
    float shine = clamp01(sine * sqrtf(clamp01(1 - eye * eye)) + cosine * eye);
    shine *= shine;
    shine *= shine;
    shine *= shine;
    float3 color = vec(0.35f, 0.2f, 0.1f) * 0.4f;
    if (seesSun(point - direction * params.epsilon))
        color += params.emission * (vec(0.35f, 0.2f, 0.1f) * sine + vec(0.2f) * shine);
    setColor(color);
}

extern "C" __global__ void __closesthit__sphere() {
    const Item& item = params.items[optixGetPrimitiveIndex()];
    const float3 point = hitPoint(), normal = normalize(point - item.at);
    const unsigned seed = hashPcg(optixGetPrimitiveIndex());
    const float3 own = vec(0.3f + (seed & 255) / 400.0f, 0.5f, 0.3f + (seed >> 8 & 255) / 400.0f);
    float3 light = skyColor(normal) * 0.4f;
    const float cosine = dot(normal, params.light[0]);
    if (cosine > 0.0f && seesSun(point + normal * params.epsilon))
        light += params.emission * cosine;
    setColor(own * light);
}
