// SPDX-License-Identifier: Apache-2.0
#include <optix_world.h>

using namespace optix;

struct Seen {
    int mark;
};

rtDeclareVariable(unsigned, launch_index, rtLaunchIndex, );
rtDeclareVariable(optix::Ray, ray, rtCurrentRay, );
rtDeclareVariable(Seen, prd, rtPayload, );
rtDeclareVariable(rtObject, top_object, , );
rtDeclareVariable(int, mark, , "of an instance");
rtDeclareVariable(int, nothing_seen, , );
rtDeclareVariable(int, chosen, , "of a selector");
rtBuffer<int> seen;

RT_PROGRAM void look() {
    Seen data;
    data.mark = -100;
    const float3 from = make_float3(float(launch_index) + 0.5f, 0.5f, 200.0f);
    rtTrace(top_object, make_Ray(from, make_float3(0, 0, -1), 0, 0.0f, RT_DEFAULT_MAX), data);
    seen[launch_index] = data.mark;
}
RT_PROGRAM void nothing() {
    prd.mark = nothing_seen;
}
RT_PROGRAM void show_mark() {
    prd.mark = mark;
}
// Children behind the number are none.
RT_PROGRAM void visit_one() {
    rtIntersectChild(chosen);
}

// A square of side 1 whose height is the mark.
RT_PROGRAM void tile_intersect(int) {
    const float t = (float(mark) - ray.origin.z) / ray.direction.z;
    const float3 p = ray.origin + t * ray.direction;
    if (p.x >= 0 && p.x < 1 && p.y >= 0 && p.y < 1 && rtPotentialIntersection(t))
        rtReportIntersection(0);
}
RT_PROGRAM void tile_bounds(int, float result[6]) {
    result[0] = result[1] = 0.0f;
    result[3] = result[4] = 1.0f;
    result[2] = mark - 0.01f;
    result[5] = mark + 0.01f;
}
