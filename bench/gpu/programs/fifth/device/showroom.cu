// SPDX-License-Identifier: Apache-2.0
// Goods with textures and finishes. Closest-hit programs read textures and call the continuation
// callable of the finish, which traces short rays and up to two that closest-hit programs shade in
// turn. Payload: colour, depth, random state.
#include "showroom.h"
#include "tools.h"

extern "C" {
__constant__ ShowroomParams params;
}

struct ShowroomPoint {
    float3 at, normal, flat, eye, color;
    unsigned depth, random;
};

DEVICE float3 look(float3 from, float3 direction, unsigned depth, unsigned& random) {
    unsigned r, g, b;
    optixTrace(params.room, from, direction, 1e-3f, 1e16f, 0.0f, OptixVisibilityMask(255),
               OPTIX_RAY_FLAG_DISABLE_ANYHIT, 0, 1, 0, r, g, b, depth, random);
    return vec(__uint_as_float(r), __uint_as_float(g), __uint_as_float(b));
}
DEVICE bool isOpen(float3 from, float3 direction, float distance) {
    unsigned open = 0, unused = 0;
    optixTrace(params.room, from, direction, 1e-3f, distance, 0.0f, OptixVisibilityMask(255),
               OPTIX_RAY_FLAG_DISABLE_ANYHIT | OPTIX_RAY_FLAG_DISABLE_CLOSESTHIT |
                   OPTIX_RAY_FLAG_TERMINATE_ON_FIRST_HIT,
               0, 1, 1, open, unused, unused, unused, unused);
    return open != 0;
}
DEVICE void answer(float3 color, unsigned random) {
    optixSetPayload_0(__float_as_uint(color.x));
    optixSetPayload_1(__float_as_uint(color.y));
    optixSetPayload_2(__float_as_uint(color.z));
    optixSetPayload_4(random);
}
DEVICE float3 hallTowards(float3 direction) {
    const float height = 0.5f + 0.5f * direction.y;
    const float window = fabsf(direction.x) < 0.25f && direction.y > 0.1f ? 0.9f : 0.0f;
    return lerp(vec(0.16f, 0.14f, 0.13f), vec(0.5f, 0.53f, 0.58f), height) + vec(window);
}
// Light of a random point of a lamp; `wrap`: how far it reaches around the edge of the surface.
DEVICE float3 lampAt(ShowroomPoint& p, unsigned number, float wrap) {
    const ShowroomLamp& lamp = params.lamps[number];
    const float u = nextFloat(p.random) - 0.5f, v = nextFloat(p.random) - 0.5f;
    const float3 to = lamp.at + lamp.across * u + lamp.along * v - p.at;
    const float far = length(to);
    const float cosine = (dot(p.normal, to) / far + wrap) / (1.0f + wrap);
    if (cosine <= 0.0f || !isOpen(p.at, to / far, far))
        return vec(0.0f);
    return lamp.power * (cosine / (far * far));
}
DEVICE float3 glintOf(ShowroomPoint& p, float3 direction, float power) {
    const float3 to = normalize(params.lamps[0].at - p.at);
    return vec(powf(fmaxf(dot(direction, to), 0.0f), power));
}
DEVICE float edgeOf(const ShowroomPoint& p) {
    const float edge = clamp01(1.0f - dot(p.eye, p.normal)), squared = edge * edge;
    return squared * squared * edge;
}

extern "C" __device__ float3 __continuation_callable__enamel(ShowroomPoint& p) {
    const float3 away = reflect(-p.eye, p.normal);
    float3 sum = p.color * (lampAt(p, 0, 0.0f) + lampAt(p, 1, 0.0f) + hallTowards(p.normal) * 0.3f);
    if (p.depth < params.maxDepth)
        sum = lerp(sum, look(p.at, away, p.depth + 1, p.random), 0.06f + 0.94f * edgeOf(p));
    return sum + glintOf(p, away, 400.0f) * 2.0f;
}
// Two reflections that are rough along one direction.
extern "C" __device__ float3 __continuation_callable__brushed(ShowroomPoint& p) {
    float3 sum = vec(0.0f);
    const float3 around = normalize(cross(p.normal, vec(0.01f, 1.0f, 0.02f)));
    for (int i = 0; i < 2; ++i) {
        const float lean = 0.4f * (nextFloat(p.random) - 0.5f);
        const float3 away = reflect(-p.eye, normalize(p.normal + around * lean));
        sum += p.depth < params.maxDepth && dot(away, p.flat) > 0.0f
                   ? look(p.at, away, p.depth + 1, p.random)
                   : hallTowards(away);
    }
    return p.color * (sum * 0.5f + lampAt(p, 0, 0.0f) * 0.25f);
}
extern "C" __device__ float3 __continuation_callable__cloth(ShowroomPoint& p) {
    float open = 0.0f;
    for (int i = 0; i < 2; ++i) {
        const float u = nextFloat(p.random), v = nextFloat(p.random);
        open += isOpen(p.at, cosineDirection(p.flat, u, v), 0.6f) ? 0.5f : 0.0f;
    }
    const float edge = 1.0f - fabsf(dot(p.eye, p.normal));
    const float3 light = lampAt(p, 0, 0.3f) + lampAt(p, 1, 0.3f) + vec(0.35f * open);
    return (p.color + vec(0.25f * edge * edge * edge)) * light;
}
// What is behind, through a rough wall, and a reflection.
extern "C" __device__ float3 __continuation_callable__frosted(ShowroomPoint& p) {
    const float3 light = lampAt(p, 0, 0.6f);
    float3 behind = hallTowards(-p.eye), before = hallTowards(p.normal);
    if (p.depth < params.maxDepth) {
        const float u = nextFloat(p.random), v = nextFloat(p.random);
        const float3 through = normalize(cosineDirection(-p.flat, u, v) * 0.25f - p.eye);
        behind = look(p.at - p.flat * 4e-3f, through, p.depth + 1, p.random);
        before = look(p.at, reflect(-p.eye, p.flat), p.depth + 1, p.random);
    }
    const float3 sum = lerp(behind, light, 0.3f) * p.color;
    return lerp(sum, before, 0.05f + 0.95f * edgeOf(p));
}
extern "C" __device__ float3 __continuation_callable__plaster(ShowroomPoint& p) {
    const float u = nextFloat(p.random), v = nextFloat(p.random);
    const float open = isOpen(p.at, cosineDirection(p.flat, u, v), 1.5f) ? 1.0f : 0.0f;
    return p.color *
           (lampAt(p, 0, 0.0f) + lampAt(p, 1, 0.0f) + hallTowards(p.normal) * 0.4f * open);
}

extern "C" __global__ void __closesthit__goods() {
    const auto* r = reinterpret_cast<const ShowroomRecord*>(optixGetSbtDataPointer());
    const uint3 t = r->mesh.indices[optixGetPrimitiveIndex()];
    const float2 b = optixGetTriangleBarycentrics();
    const float3 face = r->mesh.normal(optixGetPrimitiveIndex());
    const float3 smooth = r->normals ? r->normals[t.x] * (1.0f - b.x - b.y) +
                                           r->normals[t.y] * b.x + r->normals[t.z] * b.y
                                     : face;
    const float3 local = optixTransformPointFromWorldToObjectSpace(rayPoint());
    const float u = r->repeats * atan2f(local.z, local.x) * (0.5f / kPi),
                v = 0.5f * r->repeats * (local.y + 0.3f * (fabsf(local.x) + fabsf(local.z)));
    const float4 texel = tex2D<float4>(r->color, u, v);
    const float relief = tex2D<float>(r->relief, 4.0f * u, 4.0f * v);
    const float slopeU = tex2D<float>(r->relief, 4.0f * u + 0.01f, 4.0f * v) - relief,
                slopeV = tex2D<float>(r->relief, 4.0f * u, 4.0f * v + 0.01f) - relief;
    ShowroomPoint p;
    p.flat = towardsRay(normalize(optixTransformNormalFromObjectToWorldSpace(face)));
    const float3 bent = towardsRay(normalize(optixTransformNormalFromObjectToWorldSpace(smooth)));
    float3 x, y;
    makeBasis(bent, x, y);
    p.normal = normalize(bent - x * slopeU - y * slopeV);
    p.at = rayPoint() + p.flat * 2e-3f;
    p.eye = -optixGetWorldRayDirection();
    p.color = r->tint * vec(texel.x, texel.y, texel.z);
    p.depth = optixGetPayload_3();
    p.random = optixGetPayload_4();
    const float3 color = optixContinuationCall<float3, ShowroomPoint&>(r->finish, p);
    answer(color, p.random);
}
extern "C" __global__ void __miss__hall() {
    answer(hallTowards(optixGetWorldRayDirection()), optixGetPayload_4());
}
extern "C" __global__ void __miss__open() {
    optixSetPayload_0(1);
}

extern "C" __global__ void __raygen__showroom() {
    const uint3 index = optixGetLaunchIndex(), size = optixGetLaunchDimensions();
    const unsigned pixel = index.y * size.x + index.x;
    unsigned random = hashPcg(pixel);
    float3 sum = vec(0.0f);
    for (unsigned i = 0; i < params.samples; ++i) {
        const float x = (index.x + nextFloat(random)) / size.x;
        const float y = (index.y + nextFloat(random)) / size.y;
        sum += look(params.camera.eye, cameraDirection(params.camera, x, y), 0, random);
    }
    params.image[pixel] = withWeight(sum / float(params.samples), 1.0f);
}
