// SPDX-License-Identifier: Apache-2.0
#include "node_graph.h"

#include <optix.h>
#include <optix_math.h>

using namespace optix;

struct Payload {
    float value;
    int depth;
};

rtDeclareVariable(rtObject, world, , );
rtDeclareVariable(unsigned int, ray_index, rtLaunchIndex, );
rtDeclareVariable(Ray, ray, rtCurrentRay, );
rtDeclareVariable(float, t_hit, rtIntersectionDistance, );
rtDeclareVariable(Payload, payload, rtPayload, );
rtBuffer<float> results;

typedef rtCallableProgramId<float(int, float)> Function;
typedef rtMarkedCallableProgramId<float(int, float)> MarkedFunction;
rtBuffer<Node> nodes;
rtBuffer<Function> functions; // by kind: constants, sums, products, rays
rtDeclareVariable(int, root, , );
rtDeclareVariable(int, evaluator, , ); // an id that no variable of a callable's type holds
rtDeclareVariable(Function, surface_function, , );
rtCallableProgram(float, tone, (float));
rtDeclareVariable(float, gain, , );

// ---- the functions of nodes; each evaluates its inputs by the same way
static __device__ float evaluate(int node, float x) {
    if (node < 0)
        return x;
    return Function(nodes[node].function)(node, x);
}
RT_CALLABLE_PROGRAM float constant(int node, float) {
    return nodes[node].constant * gain;
}
RT_CALLABLE_PROGRAM float sum(int node, float x) {
    return evaluate(nodes[node].left, x) + evaluate(nodes[node].right, x);
}
RT_CALLABLE_PROGRAM float product(int node, float x) {
    return evaluate(nodes[node].left, x) * evaluate(nodes[node].right, x);
}
RT_CALLABLE_PROGRAM float evaluate_marked(int node, float x) {
    return Function(nodes[node].function)(node, x);
}
// Traces a ray, whose closest-hit program evaluates a graph, which may trace rays.
RT_CALLABLE_PROGRAM float look(int node, float x) {
    Payload below;
    below.value = 0;
    below.depth = payload.depth + 1;
    if (below.depth > 3)
        return 100;
    const Ray down = make_Ray(ray.origin + (t_hit + 0.5f) * ray.direction, ray.direction, 0, 0.0f,
                              RT_DEFAULT_MAX);
    rtTrace(world, down, below);
    return below.value + x * nodes[node].constant;
}

RT_CALLABLE_PROGRAM float plain_tone(float x) {
    return x;
}
RT_CALLABLE_PROGRAM float double_tone(float x) {
    return 2 * x + gain;
}

// ---- layers, one below the other
rtDeclareVariable(int, layer, attribute layer, );
RT_PROGRAM void layer_bounds(int i, float result[6]) {
    result[0] = result[1] = -1;
    result[3] = result[4] = 1;
    result[2] = result[5] = -float(i);
}
RT_PROGRAM void layer_intersect(int i) {
    const float t = (-float(i) - ray.origin.z) / ray.direction.z;
    if (rtPotentialIntersection(t)) {
        layer = i;
        rtReportIntersection(0);
    }
}

RT_PROGRAM void shade() {
    // A call through a variable may trace; so may one at a place with a name.
    payload.value = surface_function(root, float(layer));
    payload.value += MarkedFunction(evaluator, "shade")(root, 1.0f);
}
RT_PROGRAM void end() {
    payload.value = 1000;
}
RT_PROGRAM void start() {
    Payload first;
    first.value = 0;
    first.depth = 0;
    rtTrace(world, make_Ray(make_float3(0, 0, 1), make_float3(0, 0, -1), 0, 0.0f, RT_DEFAULT_MAX),
            first);
    results[ray_index] = tone(first.value);
}
