// SPDX-License-Identifier: Apache-2.0
// Shading networks: a material is a tree of nodes, which are continuation callables. Nodes trace
// rays for shadows, ambient occlusion, reflections and the spheres of influence around a point, and
// call other nodes. Payload: colour and depth; the sum of influences; for shadow rays one word.
#include "ray_packets_in_callables.h"
#include "tools.h"

extern "C" {
__constant__ NetworkParams params;
}

struct Shade {
    float3 point, normal, incoming;
    unsigned random, depth;
};

DEVICE float3 callNode(unsigned node, Shade* at) {
    return optixContinuationCall<float3, unsigned, Shade*>(params.nodes[node].kind, node, at);
}
DEVICE float3 traceColor(float3 origin, float3 direction, unsigned depth) {
    unsigned r = 0, g = 0, b = 0;
    optixTrace(params.scene, origin, direction, 1e-3f, 1e16f, 0.0f, OptixVisibilityMask(255),
               OPTIX_RAY_FLAG_DISABLE_ANYHIT, 0, 1, 0, r, g, b, depth);
    return vec(__uint_as_float(r), __uint_as_float(g), __uint_as_float(b));
}
DEVICE bool isOpen(float3 origin, float3 direction, float reach) {
    unsigned open = 0, unused = 0;
    optixTrace(params.scene, origin, direction, 1e-3f, reach, 0.0f, OptixVisibilityMask(255),
               OPTIX_RAY_FLAG_DISABLE_ANYHIT | OPTIX_RAY_FLAG_TERMINATE_ON_FIRST_HIT |
                   OPTIX_RAY_FLAG_DISABLE_CLOSESTHIT,
               0, 1, 1, open, unused, unused, unused);
    return open != 0;
}

// ---- Nodes --------------------------------------------------------------------------------------

extern "C" __device__ float3 __continuation_callable__light(unsigned node, Shade* at) {
    const NetworkNode& n = params.nodes[node];
    const float cosine = dot(at->normal, params.sun);
    if (cosine <= 0.0f || !isOpen(at->point, params.sun, 1e16f))
        return vec(0.0f);
    return n.color * vec(1.4f, 1.3f, 1.1f) * cosine;
}
// A packet of rays over the hemisphere.
extern "C" __device__ float3 __continuation_callable__ambient(unsigned node, Shade* at) {
    const NetworkNode& n = params.nodes[node];
    constexpr unsigned kRays = 4;
    float3 light = vec(0.0f);
    for (unsigned i = 0; i < kRays; ++i) {
        const float u = nextFloat(at->random), v = nextFloat(at->random);
        const float3 direction = cosineDirection(at->normal, u, v);
        if (isOpen(at->point, direction, params.reach))
            light += blueSky(direction);
    }
    return n.color * light * (n.value / kRays);
}
extern "C" __device__ float3 __continuation_callable__mirror(unsigned node, Shade* at) {
    const NetworkNode& n = params.nodes[node];
    const float3 direction = reflect(at->incoming, at->normal);
    if (at->depth >= params.maxDepth)
        return n.color * blueSky(direction);
    return n.color * traceColor(at->point, direction, at->depth + 1) * n.value;
}
// Colours of the balls around the point, by weight.
extern "C" __device__ float3 __continuation_callable__influence(unsigned node, Shade* at) {
    const NetworkNode& n = params.nodes[node];
    unsigned r = 0, g = 0, b = 0, weight = 0;
    optixTrace(params.influences, at->point, vec(0.0f, 1.0f, 0.0f), 0.0f, 1e-6f, 0.0f,
               OptixVisibilityMask(255), OPTIX_RAY_FLAG_DISABLE_CLOSESTHIT, 1, 1, 2, r, g, b,
               weight);
    const float total = __uint_as_float(weight);
    if (total <= 0.0f)
        return n.color * 0.2f;
    return vec(__uint_as_float(r), __uint_as_float(g), __uint_as_float(b)) * (n.value / total);
}
extern "C" __device__ float3 __continuation_callable__sum(unsigned node, Shade* at) {
    const NetworkNode& n = params.nodes[node];
    const float3 a = callNode(n.a, at);
    return a * n.value + callNode(n.b, at) * (1.0f - n.value);
}
extern "C" __device__ float __direct_callable__pattern(float3 p, float scale) {
    const float3 q = p * scale;
    return sinf(q.x) * sinf(q.y + 1.3f) * sinf(q.z + 2.1f);
}
extern "C" __device__ float3 __continuation_callable__choice(unsigned node, Shade* at) {
    const NetworkNode& n = params.nodes[node];
    const float pattern =
        optixDirectCall<float, float3, float>(kPatternCallable, at->point, n.value);
    return callNode(pattern > 0.0f ? n.a : n.b, at);
}

// ---- Programs -----------------------------------------------------------------------------------

extern "C" __global__ void __intersection__influence() {
    const InfluenceBall& ball = params.balls[optixGetPrimitiveIndex()];
    const float3 away = optixGetObjectRayOrigin() - ball.center;
    const float share = 1.0f - dot(away, away) / (ball.radius * ball.radius);
    if (share > 0.0f)
        optixReportIntersection(optixGetRayTmin(), 1, __float_as_uint(share * share));
}
extern "C" __global__ void __anyhit__influence() {
    const InfluenceBall& ball = params.balls[optixGetPrimitiveIndex()];
    const float weight = __uint_as_float(optixGetAttribute_0());
    const auto sum = [&](unsigned old, float more) {
        return __float_as_uint(__uint_as_float(old) + more * weight);
    };
    optixSetPayload_0(sum(optixGetPayload_0(), ball.color.x));
    optixSetPayload_1(sum(optixGetPayload_1(), ball.color.y));
    optixSetPayload_2(sum(optixGetPayload_2(), ball.color.z));
    optixSetPayload_3(sum(optixGetPayload_3(), 1.0f));
    optixIgnoreIntersection();
}

DEVICE void setColor(float3 c) {
    optixSetPayload_0(__float_as_uint(c.x));
    optixSetPayload_1(__float_as_uint(c.y));
    optixSetPayload_2(__float_as_uint(c.z));
}
extern "C" __global__ void __closesthit__network() {
    const NetworkRecord* r = reinterpret_cast<const NetworkRecord*>(optixGetSbtDataPointer());
    const uint3 t = r->indices[optixGetPrimitiveIndex()];
    const float3 a = r->vertices[t.x];
    Shade at;
    at.normal = towardsRay(normalize(cross(r->vertices[t.y] - a, r->vertices[t.z] - a)));
    at.point = rayPoint() + at.normal * 1e-3f;
    at.incoming = optixGetWorldRayDirection();
    at.depth = optixGetPayload_3();
    const uint3 index = optixGetLaunchIndex();
    at.random = hashPcg(index.y * 8192u + index.x + at.depth * 0x3c6ef372u);
    setColor(callNode(r->root, &at));
}
extern "C" __global__ void __miss__sky() {
    setColor(blueSky(optixGetWorldRayDirection()));
}
extern "C" __global__ void __miss__open() {
    optixSetPayload_0(1);
}
extern "C" __global__ void __miss__influence() {}

extern "C" __global__ void __raygen__network() {
    const uint3 index = optixGetLaunchIndex(), size = optixGetLaunchDimensions();
    const float3 direction =
        cameraDirection(params.camera, (index.x + 0.5f) / size.x, (index.y + 0.5f) / size.y);
    params.image[index.y * size.x + index.x] =
        withWeight(traceColor(params.camera.eye, direction, 1), 1.0f);
}
