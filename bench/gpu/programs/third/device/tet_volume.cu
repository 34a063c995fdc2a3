// SPDX-License-Identifier: Apache-2.0
// Point location with rays: a ray from a sample in any direction meets a face of the tetrahedron
// that contains the sample, and the side of the face names it. Payload: the tetrahedron.
#include "tet_volume.h"
#include "tools.h"

extern "C" __constant__ TetParams lp;

extern "C" __global__ void __closesthit__face() {
    const int2 sides = lp.sides[optixGetPrimitiveIndex()];
    optixSetPayload_0(static_cast<unsigned>(optixIsTriangleFrontFaceHit() ? sides.x : sides.y));
}
extern "C" __global__ void __miss__outside() {
    optixSetPayload_0(~0u);
}

DEVICE int locate(float3 point) {
    unsigned tetrahedron;
    optixTrace(lp.faces, point, vec(1e-3f, 1.0f, 2e-3f), 0.0f, 1.0f, 0.0f, OptixVisibilityMask(1),
               OPTIX_RAY_FLAG_NONE, 0, 1, 0, tetrahedron);
    return static_cast<int>(tetrahedron);
}

DEVICE float3 xyz(float4 p) {
    return vec(p.x, p.y, p.z);
}
// The value at a point of a tetrahedron, linear between its corners.
DEVICE float valueAt(float3 point, int tetrahedron) {
    const uint4 t = lp.tetrahedra[tetrahedron];
    const float4 a = lp.points[t.x], b = lp.points[t.y], c = lp.points[t.z], d = lp.points[t.w];
    const float3 p = point - xyz(a), ab = xyz(b) - xyz(a), ac = xyz(c) - xyz(a),
                 ad = xyz(d) - xyz(a);
    const float volume = 1.0f / dot(ab, cross(ac, ad));
    const float v = dot(p, cross(ac, ad)) * volume, w = dot(ab, cross(p, ad)) * volume,
                x = dot(ab, cross(ac, p)) * volume;
    return a.w + v * (b.w - a.w) + w * (c.w - a.w) + x * (d.w - a.w);
}

// Colour and extinction.
DEVICE float4 transfer(float value) {
    const float shell = expf(-300.0f * (value - 0.62f) * (value - 0.62f));
    const float core = expf(-120.0f * (value - 0.3f) * (value - 0.3f));
    const float3 color = vec(0.95f, 0.55f, 0.2f) * shell + vec(0.15f, 0.4f, 0.9f) * core;
    return withWeight(color, 9.0f * shell + 2.5f * core);
}

// Entry and exit of the unit ball, or none.
DEVICE bool enterBall(float3 origin, float3 direction, float& enter, float& leave) {
    const float middle = -dot(origin, direction);
    const float under = middle * middle - dot(origin, origin) + 1.0f;
    if (under <= 0.0f)
        return false;
    enter = fmaxf(0.0f, middle - sqrtf(under));
    leave = middle + sqrtf(under);
    return leave > enter;
}

extern "C" __global__ void __raygen__volume() {
    const uint3 index = optixGetLaunchIndex(), size = optixGetLaunchDimensions();
    const unsigned pixel = index.y * size.x + index.x;
    unsigned random = hashPcg(pixel);
    const float3 origin = lp.camera.eye;
    const float3 direction =
        cameraDirection(lp.camera, (index.x + 0.5f) / size.x, (index.y + 0.5f) / size.y);
    float3 color = vec(0.0f);
    float passes = 1.0f, enter, leave;
    if (enterBall(origin, direction, enter, leave)) {
        const float step = 2.0f / lp.steps;
        for (float t = enter + step * nextFloat(random); t < leave && passes > 0.02f; t += step) {
            const float3 point = origin + direction * t;
            const int tetrahedron = locate(point);
            if (tetrahedron < 0)
                continue;
            const float4 here = transfer(valueAt(point, tetrahedron));
            const float share = 1.0f - expf(-here.w * step);
            color += xyz(here) * (passes * share);
            passes *= 1.0f - share;
        }
    }
    lp.image[pixel] = withWeight(color + vec(0.08f, 0.09f, 0.12f) * passes, 1.0f);
}
