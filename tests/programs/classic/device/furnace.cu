// SPDX-License-Identifier: Apache-2.0
#include <optix.h>

#include "furnace.h"

using namespace optix;

// What scattering programs get and change. Its first word is at an odd place of the stack as soon
// as a program calls another.
struct Scatter {
    float3 way, normal;
    float u, v, weight;
};
typedef rtCallableProgramId<Scatter(Scatter)> ScatterProgram;

struct Path {
    float3 origin, way;
    unsigned seed;
    float weight, sum;
};

rtDeclareVariable(uint2, launch_index, rtLaunchIndex, );
rtDeclareVariable(uint2, launch_dim, rtLaunchDim, );
rtDeclareVariable(optix::Ray, ray, rtCurrentRay, );
rtDeclareVariable(float, t_hit, rtIntersectionDistance, );
rtDeclareVariable(Path, path, rtPayload, );
rtDeclareVariable(int, wall, attribute wall, );
rtDeclareVariable(rtObject, top_object, , );
rtDeclareVariable(unsigned, max_depth, , );
rtDeclareVariable(int, picture, , "id of a buffer");
rtBuffer<rtBufferId<MaterialRecord>, 1> directory;

RT_PROGRAM void trace_paths() {
    Path p;
    p.origin = make_float3(0.1f, 0.2f, 0.3f);
    p.way = normalize(make_float3((launch_index.x + 0.5f) / launch_dim.x * 2 - 1,
                                  (launch_index.y + 0.5f) / launch_dim.y * 2 - 1, -0.7f));
    p.seed = launch_index.y * launch_dim.x + launch_index.x;
    p.weight = 1.0f;
    p.sum = 0.0f;
    for (unsigned depth = 0; depth < max_depth; ++depth)
        rtTrace(top_object, make_Ray(p.origin, p.way, 0, 0.0f, RT_DEFAULT_MAX), p);
    rtBufferId<float, 2> target(picture);
    target[launch_index] = p.sum;
}

static __device__ float axisOf(const float3& v, int axis) {
    return axis == 0 ? v.x : axis == 1 ? v.y : v.z;
}

RT_PROGRAM void hit_wall() {
    const float3 point = ray.origin + t_hit * ray.direction;
    const int axis = wall / 2;
    const float side = wall % 2 ? -1.0f : 1.0f;
    Scatter scatter;
    scatter.normal = make_float3(axis == 0 ? side : 0, axis == 1 ? side : 0, axis == 2 ? side : 0);
    const float2 place = make_float2((axisOf(point, (axis + 1) % 3) + 1) / 2,
                                     (axisOf(point, (axis + 2) % 3) + 1) / 2);
    rtBufferId<MaterialRecord> records = directory[0];
    const MaterialRecord record = records[wall];
    const rtBufferId<float> light(record.light);
    path.sum += path.weight * light[place.x < 0.5f ? 0 : int(light.size()) - 1];
    scatter.u = furnaceRandom(path.seed);
    scatter.v = furnaceRandom(path.seed);
    scatter.way = ray.direction;
    scatter.weight = 1.0f;
    const ScatterProgram program(record.scatter);
    const Scatter next = program(scatter);
    path.weight *= next.weight * rtTex2D<float>(record.texture, place.x, place.y);
    path.way = next.way;
    path.origin = point * 0.999f;
}

RT_CALLABLE_PROGRAM Scatter scatter_diffuse(Scatter s) {
    s.way = furnaceScatter(s.normal, s.u, s.v);
    return s;
}

rtDeclareVariable(float, loss, , );
RT_CALLABLE_PROGRAM Scatter scatter_mirror(Scatter s) {
    s.way = reflect(s.way, s.normal);
    s.weight = loss;
    return s;
}

rtDeclareVariable(ScatterProgram, other, , );
rtDeclareVariable(ScatterProgram, mirror, , );
RT_CALLABLE_PROGRAM Scatter scatter_both(Scatter s) {
    return s.u < 0.5f ? mirror(s) : other(s);
}

// The walls of the cube from -1 to 1: two for each axis, the one at -1 first.
RT_PROGRAM void wall_intersect(int primitive) {
    const int axis = primitive / 2;
    const float place = primitive % 2 ? 1.0f : -1.0f, way = axisOf(ray.direction, axis);
    if (way * place <= 0.0f)
        return; // seen from outside
    const float t = (place - axisOf(ray.origin, axis)) / way;
    if (rtPotentialIntersection(t)) {
        wall = primitive;
        rtReportIntersection(0);
    }
}
RT_PROGRAM void wall_bounds(int primitive, float result[6]) {
    for (int i = 0; i < 3; ++i) {
        const bool flat = i == primitive / 2;
        result[i] = flat ? (primitive % 2 ? 1.0f : -1.0f) - 1e-4f : -1.0001f;
        result[i + 3] = flat ? (primitive % 2 ? 1.0f : -1.0f) + 1e-4f : 1.0001f;
    }
}
