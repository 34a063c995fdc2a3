// SPDX-License-Identifier: Apache-2.0
// Clipping planes in an any-hit program: hits in the part that is cut away are ignored. A back face
// behind the cut stands for the inside of a solid and is hatched. Rays around the pixel find
// outlines, and glass lets the ray go on. Payload: distance, part, normal, colour.
#include "section_view.h"
#include "tools.h"

extern "C" {
__constant__ SectionParams params;
}

struct Layer {
    float distance; // negative: nothing
    unsigned part;  // 0: nothing
    float3 normal, color;
    float alpha;
};

DEVICE bool isCutAway(float3 p) {
    for (int i = 0; i < kPlanes; ++i) {
        const float4 plane = params.planes[i];
        if (dot(vec(plane.x, plane.y, plane.z), p) + plane.w < 0.0f)
            return false;
    }
    return true;
}

extern "C" __global__ void __anyhit__clip() {
    const SectionRecord* part = reinterpret_cast<const SectionRecord*>(optixGetSbtDataPointer());
    if (part->isClipped && isCutAway(rayPoint()))
        optixIgnoreIntersection();
}

extern "C" __global__ void __closesthit__part() {
    const SectionRecord* part = reinterpret_cast<const SectionRecord*>(optixGetSbtDataPointer());
    const float3 local = part->mesh.normal(optixGetPrimitiveIndex());
    float3 normal = normalize(optixTransformNormalFromObjectToWorldSpace(local));
    float3 color = part->color;
    float alpha = part->alpha;
    if (optixIsTriangleBackFaceHit()) {
        const float2 axis = circlePoint(part->hatchTurn);
        const uint3 pixel = optixGetLaunchIndex();
        const float line = (axis.x * pixel.x + axis.y * pixel.y) * part->hatchStep * 0.5f;
        color = line - floorf(line) < 0.3f ? vec(0.15f) : part->capColor;
        normal = -normal;
        alpha = 1.0f;
    }
    if (!(optixGetRayTmax() >= 0.0f))
        optixThrowException(7, __float_as_uint(optixGetRayTmax()));
    const float shine =
        part->specular *
        powf(fmaxf(dot(reflect(optixGetWorldRayDirection(), normal), params.sun), 0.0f), 30.0f);
    color = color * (0.45f + 0.55f * fmaxf(dot(normal, params.sun), 0.0f)) + vec(shine);
    optixSetPayload_0(__float_as_uint(optixGetRayTmax()));
    optixSetPayload_1(optixGetInstanceId());
    optixSetPayload_2(__float_as_uint(normal.x));
    optixSetPayload_3(__float_as_uint(normal.y));
    optixSetPayload_4(__float_as_uint(color.x));
    optixSetPayload_5(__float_as_uint(color.y));
    optixSetPayload_6(__float_as_uint(color.z));
    optixSetPayload_7(__float_as_uint(alpha));
}
extern "C" __global__ void __miss__nothing() {
    optixSetPayload_1(0);
}

DEVICE Layer findLayer(float3 direction, float from) {
    unsigned p[8] = {__float_as_uint(-1.0f)};
    optixTrace(params.assembly, params.camera.eye, direction, from, 1e16f, 0.0f,
               OptixVisibilityMask(255), OPTIX_RAY_FLAG_NONE, 0, 1, 0, p[0], p[1], p[2], p[3], p[4],
               p[5], p[6], p[7]);
    return {__uint_as_float(p[0]), p[1], vec(__uint_as_float(p[2]), __uint_as_float(p[3]), 0.0f),
            vec(__uint_as_float(p[4]), __uint_as_float(p[5]), __uint_as_float(p[6])),
            __uint_as_float(p[7])};
}

// The share of rays around the pixel that see another part or an edge.
DEVICE float findOutline(const Layer& middle, float x, float y) {
    const uint3 size = optixGetLaunchDimensions();
    int others = 0;
    for (int i = 0; i < 8; ++i) {
        const float2 c = circlePoint(i / 8.0f);
        const Layer l = findLayer(
            cameraDirection(params.camera, (x + 1.2f * c.x) / size.x, (y + 1.2f * c.y) / size.y),
            0.0f);
        const float3 turn = l.normal - middle.normal;
        others += l.part != middle.part || dot(turn, turn) > 0.1f ||
                  fabsf(l.distance - middle.distance) > 0.3f;
    }
    return others / 8.0f;
}

extern "C" __global__ void __raygen__view() {
    const uint3 index = optixGetLaunchIndex(), size = optixGetLaunchDimensions();
    const float x = index.x + 0.5f, y = index.y + 0.5f;
    const float3 direction = cameraDirection(params.camera, x / size.x, y / size.y);
    const float3 ground = lerp(vec(0.93f, 0.94f, 0.96f), vec(0.6f, 0.66f, 0.75f), y / size.y);
    float3 color = vec(0.0f);
    float passes = 1.0f, from = 0.0f, outline = 0.0f;
    for (int i = 0; i < params.maxLayers && passes > 0.05f; ++i) {
        const Layer layer = findLayer(direction, from);
        if (i == 0)
            outline = findOutline(layer, x, y);
        if (layer.part == 0)
            break;
        color += layer.color * (passes * layer.alpha);
        passes *= 1.0f - layer.alpha;
        from = layer.distance + 1e-3f;
    }
    color = (color + ground * passes) * (1.0f - 0.9f * clamp01(1.6f * outline));
    params.image[index.y * params.width + index.x] = withWeight(color, 1.0f);
}
