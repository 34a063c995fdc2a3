// SPDX-License-Identifier: Apache-2.0
// Materials as graphs of nodes: each kind of node is a direct callable, which calls the callables
// of its inputs. Closest-hit programs evaluate two graphs, trace a shadow ray and a reflection.
// Payload: colour, depth.
#include "node_graphs.h"
#include "tools.h"

extern "C" {
__constant__ GraphParams params;
}

DEVICE float3 evaluate(unsigned node, const GraphPoint& point) {
    return optixDirectCall<float3, const Node&, const GraphPoint&>(params.nodes[node].kind,
                                                                   params.nodes[node], point);
}
DEVICE float gray(float3 color) {
    return 0.3f * color.x + 0.6f * color.y + 0.1f * color.z;
}

DEVICE float latticeAt(int x, int y, int z) {
    return (hashPcg(static_cast<unsigned>(x * 73856093 ^ y * 19349663 ^ z * 83492791)) >> 8) *
           0x1p-24f;
}
// Smooth noise in [0, 1).
DEVICE float noiseAt(float3 p) {
    const float3 cell = vec(floorf(p.x), floorf(p.y), floorf(p.z)), f = p - cell;
    const float3 s = f * f * (vec(3.0f) - f * 2.0f);
    const int x = static_cast<int>(cell.x), y = static_cast<int>(cell.y),
              z = static_cast<int>(cell.z);
    float sum = 0.0f;
    for (int i = 0; i < 8; ++i) {
        const int dx = i & 1, dy = i >> 1 & 1, dz = i >> 2;
        sum += latticeAt(x + dx, y + dy, z + dz) * (dx ? s.x : 1.0f - s.x) *
               (dy ? s.y : 1.0f - s.y) * (dz ? s.z : 1.0f - s.z);
    }
    return sum;
}
DEVICE float turbulenceAt(float3 p) {
    float sum = 0.0f, size = 0.5f;
    for (int i = 0; i < 4; ++i, size *= 0.5f, p = p * 2.03f)
        sum += size * noiseAt(p);
    return sum;
}

extern "C" __device__ float3 __direct_callable__constant(const Node& n, const GraphPoint&) {
    return n.color;
}
extern "C" __device__ float3 __direct_callable__picture(const Node& n, const GraphPoint& p) {
    const float3 at = p.position * n.scale;
    const float u = at.x + 0.5f * at.y, v = at.z + 0.5f * at.y;
    const float4 texel = tex2D<float4>(params.pictures[n.inputs[0] % 2], u, v);
    return vec(texel.x, texel.y, texel.z);
}
extern "C" __device__ float3 __direct_callable__noise(const Node& n, const GraphPoint& p) {
    return n.color * turbulenceAt(p.position * n.scale);
}
extern "C" __device__ float3 __direct_callable__marble(const Node& n, const GraphPoint& p) {
    const float3 at = p.position * n.scale;
    const float vein = 0.5f + 0.5f * sinf(3.0f * (at.x + at.y) + 9.0f * turbulenceAt(at));
    return lerp(evaluate(n.inputs[0], p), evaluate(n.inputs[1], p), vein * vein);
}
extern "C" __device__ float3 __direct_callable__wood(const Node& n, const GraphPoint& p) {
    const float3 at = p.position * n.scale;
    const float r = sqrtf(at.x * at.x + at.z * at.z) * 4.0f + 0.7f * noiseAt(at * 2.0f);
    return n.color * (0.55f + 0.45f * (r - floorf(r)));
}
extern "C" __device__ float3 __direct_callable__tiles(const Node& n, const GraphPoint& p) {
    const float3 at = p.position * n.scale;
    const float x = at.x - floorf(at.x), z = at.z - floorf(at.z);
    if (x < 0.05f || z < 0.05f)
        return n.color;
    const int odd = static_cast<int>(floorf(at.x)) + static_cast<int>(floorf(at.y)) +
                    static_cast<int>(floorf(at.z));
    return evaluate(n.inputs[odd & 1], p);
}
extern "C" __device__ float3 __direct_callable__spots(const Node& n, const GraphPoint& p) {
    const float3 at = p.position * n.scale;
    const float3 cell = vec(floorf(at.x), floorf(at.y), floorf(at.z)), from = at - cell - vec(0.5f);
    return evaluate(n.inputs[dot(from, from) < 0.14f ? 1 : 0], p);
}
extern "C" __device__ float3 __direct_callable__mix(const Node& n, const GraphPoint& p) {
    return lerp(evaluate(n.inputs[0], p), evaluate(n.inputs[1], p),
                clamp01(gray(evaluate(n.inputs[2], p))));
}
extern "C" __device__ float3 __direct_callable__multiply(const Node& n, const GraphPoint& p) {
    return evaluate(n.inputs[0], p) * evaluate(n.inputs[1], p);
}
extern "C" __device__ float3 __direct_callable__ramp(const Node& n, const GraphPoint& p) {
    const float t = clamp01(n.scale * (gray(evaluate(n.inputs[0], p)) - 0.4f) + 0.5f);
    return lerp(n.color, evaluate(n.inputs[1], p), t * t * (3.0f - 2.0f * t));
}
extern "C" __device__ float3 __direct_callable__facing(const Node& n, const GraphPoint& p) {
    return n.color * (1.0f - fabsf(dot(p.normal, p.eye)));
}
extern "C" __device__ float3 __direct_callable__warp(const Node& n, const GraphPoint& p) {
    GraphPoint moved = p;
    const float3 shift = evaluate(n.inputs[1], p);
    moved.position += (shift - vec(0.4f)) * n.scale;
    return evaluate(n.inputs[0], moved);
}

DEVICE void answer(float3 color) {
    optixSetPayload_0(__float_as_uint(color.x));
    optixSetPayload_1(__float_as_uint(color.y));
    optixSetPayload_2(__float_as_uint(color.z));
}
DEVICE float3 look(float3 from, float3 direction, unsigned depth) {
    unsigned r, g, b;
    optixTrace(params.scene, from, direction, 0.0f, 1e16f, 0.0f, OptixVisibilityMask(255),
               OPTIX_RAY_FLAG_DISABLE_ANYHIT, 0, 0, 0, r, g, b, depth);
    return vec(__uint_as_float(r), __uint_as_float(g), __uint_as_float(b));
}
DEVICE float3 skyTowards(float3 d) {
    const bool isPanel = d.y > 0.4f && d.y < 0.9f && sinf(4.0f * d.x) > 0.3f;
    return blueSky(d) * 0.75f + vec(isPanel ? 1.2f : 0.0f);
}

extern "C" __global__ void __closesthit__graph() {
    const auto* r = reinterpret_cast<const GraphRecord*>(optixGetSbtDataPointer());
    const float3 local = r->mesh.normal(optixGetPrimitiveIndex());
    const float3 direction = optixGetWorldRayDirection();
    GraphPoint p;
    p.normal = towardsRay(normalize(optixTransformNormalFromObjectToWorldSpace(local)));
    p.position = optixTransformPointFromWorldToObjectSpace(rayPoint());
    p.eye = -direction;
    const float3 albedo = evaluate(r->albedo, p);
    const float gloss = clamp01(gray(evaluate(r->gloss, p)));
    const float3 from = rayPoint() + p.normal * 1e-3f;
    float3 light = blueSky(p.normal) * 0.45f;
    const float cosine = dot(p.normal, params.sun);
    if (cosine > 0.0f) {
        unsigned lit = 0, unused = 0;
        optixTrace(params.scene, from, params.sun, 0.0f, 1e16f, 0.0f, OptixVisibilityMask(255),
                   OPTIX_RAY_FLAG_DISABLE_ANYHIT | OPTIX_RAY_FLAG_DISABLE_CLOSESTHIT |
                       OPTIX_RAY_FLAG_TERMINATE_ON_FIRST_HIT,
                   0, 0, 1, lit, unused, unused, unused);
        light += vec(1.5f, 1.4f, 1.2f) * (lit ? cosine : 0.0f);
    }
    float3 color = albedo * light;
    const unsigned depth = optixGetPayload_3();
    if (gloss > 0.02f && depth < params.maxDepth)
        color = lerp(color, look(from, reflect(direction, p.normal), depth + 1), 0.7f * gloss);
    answer(color);
}
extern "C" __global__ void __miss__sky() {
    answer(skyTowards(optixGetWorldRayDirection()));
}
extern "C" __global__ void __miss__lit() {
    optixSetPayload_0(1);
}

extern "C" __global__ void __raygen__graphs() {
    const uint3 index = optixGetLaunchIndex(), size = optixGetLaunchDimensions();
    const unsigned pixel = index.y * size.x + index.x;
    unsigned random = hashPcg(pixel);
    float3 sum = vec(0.0f);
    for (unsigned i = 0; i < params.samples; ++i) {
        const float x = (index.x + nextFloat(random)) / size.x;
        const float y = (index.y + nextFloat(random)) / size.y;
        sum += look(params.camera.eye, cameraDirection(params.camera, x, y), 0);
    }
    params.image[pixel] = withWeight(sum / float(params.samples), 1.0f);
}
