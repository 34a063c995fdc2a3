// SPDX-License-Identifier: Apache-2.0
// Hits of strands, which are Catmull-Rom curves.
#include "fur.h"

constexpr unsigned kLobes = 3;

// Tangent and axis at a parameter.
DEVICE void strandAt(float u, float3& tangent, float3& axis) {
    float4 p[4];
    optixGetCatmullRomVertexData(optixGetGASTraversableHandle(), optixGetPrimitiveIndex(),
                                 optixGetSbtGASIndex(), 0.0f, p);
    const float weights[4] = {0.5f * (-u + 2 * u * u - u * u * u),
                              0.5f * (2 - 5 * u * u + 3 * u * u * u),
                              0.5f * (u + 4 * u * u - 3 * u * u * u), 0.5f * (u * u * u - u * u)};
    const float slopes[4] = {0.5f * (-1 + 4 * u - 3 * u * u), 0.5f * (-10 * u + 9 * u * u),
                             0.5f * (1 + 8 * u - 9 * u * u), 0.5f * (3 * u * u - 2 * u)};
    tangent = axis = vec(0.0f);
    for (unsigned i = 0; i < 4; ++i) {
        const float3 point = vec(p[i].x, p[i].y, p[i].z);
        axis += point * weights[i];
        tangent += point * slopes[i];
    }
    tangent = normalize(tangent);
}

// A strand takes a third of the light; at five, hardly any is left.
extern "C" __global__ void __anyhit__veil() {
    const float left = __uint_as_float(optixGetPayload_0()) * 0.66f;
    optixSetPayload_0(__float_as_uint(left < 0.1f ? 0.0f : left));
    if (left < 0.1f)
        optixTerminateRay();
    else
        optixIgnoreIntersection();
}

extern "C" __global__ void __closesthit__strand() {
    const FurRecord* r = reinterpret_cast<const FurRecord*>(optixGetSbtDataPointer());
    float3 tangent, axis;
    strandAt(optixGetCurveParameter(), tangent, axis);
    const float3 point = rayPoint(), eye = -optixGetWorldRayDirection();
    const float3 side = normalize(cross(tangent, eye));
    FurAngles angles;
    angles.sinEye = dot(eye, tangent);
    angles.offset = fmaxf(-1.0f, fminf(1.0f, dot(normalize(point - axis), side)));
    angles.roughness = r->roughness;
    angles.absorption = r->absorption;
    const float3 across = normalize(eye - tangent * angles.sinEye);
    float3 sum = vec(0.02f, 0.015f, 0.01f);
    for (const FurLight& lamp : params.lights) {
        const float share = veilTowards(point, lamp.direction);
        if (share <= 0.0f)
            continue;
        angles.sinLight = dot(lamp.direction, tangent);
        const float cosLight = sqrtf(fmaxf(1e-6f, 1.0f - angles.sinLight * angles.sinLight));
        angles.cosAround = dot(lamp.direction - tangent * angles.sinLight, across) / cosLight;
        float3 lobes = vec(0.0f);
        for (unsigned i = 0; i < kLobes; ++i)
            lobes += optixDirectCall<float3, const FurAngles&>(i, angles);
        sum += lamp.power * lobes * (share * cosLight);
    }
    setFurColor(sum);
}
