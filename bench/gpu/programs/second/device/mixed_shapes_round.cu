// SPDX-License-Identifier: Apache-2.0
// Hits of curves and spheres, which OptiX intersects; mixed_shapes.cu has the rays.
#include "mixed_payload.h"

extern "C" __global__ void __closesthit__ball() {
    const MixedRecord* r = mixedRecord();
    const float4 ball = r->balls[optixGetPrimitiveIndex()];
    const float3 point = optixTransformPointFromWorldToObjectSpace(rayPoint());
    setMixedHit(point - vec(ball.x, ball.y, ball.z), r->color);
}

// The normal of a curve: from the nearest point of its axis.
extern "C" __global__ void __closesthit__strand() {
    float4 p[4];
    optixGetCubicBSplineVertexData(optixGetGASTraversableHandle(), optixGetPrimitiveIndex(),
                                   optixGetSbtGASIndex(), optixGetRayTime(), p);
    const float u = optixGetCurveParameter(), v = 1.0f - u;
    const float a = v * v * v / 6.0f, b = (3.0f * u * u * u - 6.0f * u * u + 4.0f) / 6.0f;
    const float c = (3.0f * v * v * v - 6.0f * v * v + 4.0f) / 6.0f, d = u * u * u / 6.0f;
    const float3 axis = vec(a * p[0].x + b * p[1].x + c * p[2].x + d * p[3].x,
                            a * p[0].y + b * p[1].y + c * p[2].y + d * p[3].y,
                            a * p[0].z + b * p[1].z + c * p[2].z + d * p[3].z);
    const float3 point = optixTransformPointFromWorldToObjectSpace(rayPoint());
    setMixedHit(point - axis, mixedRecord()->color * (0.7f + 0.3f * u));
}
