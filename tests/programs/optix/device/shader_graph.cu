// SPDX-License-Identifier: Apache-2.0
// Materials as graphs of callables, each of which evaluates its children.
#include <optix.h>

#include "shader_graph.h"

extern "C" __constant__ Params params;

struct Surface {
    float u, v;
    const MaterialData* material;
};

static __forceinline__ __device__ float evaluate(int node, const Surface* surface) {
    const Node& n = surface->material->nodes[node];
    return optixDirectCall<float, const Node*, const Surface*>(
        surface->material->first + n.operation, &n, surface);
}

extern "C" __device__ float __direct_callable__constant(const Node* n, const Surface*) {
    return n->constant;
}
extern "C" __device__ float __direct_callable__u(const Node*, const Surface* s) {
    return s->u;
}
extern "C" __device__ float __direct_callable__v(const Node*, const Surface* s) {
    return s->v;
}
extern "C" __device__ float __direct_callable__add(const Node* n, const Surface* s) {
    return evaluate(n->left, s) + evaluate(n->right, s);
}
extern "C" __device__ float __direct_callable__multiply(const Node* n, const Surface* s) {
    return evaluate(n->left, s) * evaluate(n->right, s);
}
extern "C" __device__ float __direct_callable__scaled(const Node* n, const Surface* s) {
    // Its record has a scale.
    return *reinterpret_cast<const float*>(optixGetSbtDataPointer()) * evaluate(n->left, s);
}
// May trace: how much lies above the point.
extern "C" __device__ float __continuation_callable__shade(float base, float3 from) {
    unsigned above = 0;
    optixTrace(params.scene, from, make_float3(0, 0, 1), 1e-3f, 100, 0, 255,
               OPTIX_RAY_FLAG_DISABLE_CLOSESTHIT | OPTIX_RAY_FLAG_TERMINATE_ON_FIRST_HIT, 0, 1, 1,
               above);
    return above ? base : -base;
}

extern "C" __global__ void __raygen__grid() {
    const uint3 at = optixGetLaunchIndex(), size = optixGetLaunchDimensions();
    unsigned value = 0;
    optixTrace(params.scene, make_float3((at.x + 0.5f) / size.x * 4, (at.y + 0.5f) / size.y, -1),
               make_float3(0, 0, 1), 0, 100, 0, 255, OPTIX_RAY_FLAG_NONE, 0, 1, 0, value);
    params.out[at.y * size.x + at.x] = __uint_as_float(value);
}
extern "C" __global__ void __closesthit__graph() {
    const MaterialData& material = *reinterpret_cast<const MaterialData*>(optixGetSbtDataPointer());
    const float3 o = optixGetWorldRayOrigin();
    Surface surface;
    surface.u = o.x;
    surface.v = o.y;
    surface.material = &material;
    const float base = evaluate(material.root, &surface);
    const float t = optixGetRayTmax();
    optixSetPayload_0(__float_as_uint(
        optixContinuationCall<float, float, float3>(6, base, make_float3(o.x, o.y, o.z + t))));
}
extern "C" __global__ void __miss__grid() {
    optixSetPayload_0(__float_as_uint(-1000.0f));
}
extern "C" __global__ void __miss__shadow() {
    optixSetPayload_0(1);
}
