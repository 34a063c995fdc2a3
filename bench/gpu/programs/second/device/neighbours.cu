// SPDX-License-Identifier: Apache-2.0
// The eight nearest points within a radius. A query is a ray of almost no length; the boxes around
// it are those of the points within the radius. The intersection program keeps the list in the
// caller's memory and reports no hit. Payload: the address of the list.
#include "neighbours.h"
#include "tools.h"

extern "C" __constant__ NeighbourParams params;

struct Candidates {
    float3 center;
    float squared[kNeighbours];
    unsigned id[kNeighbours];
    unsigned tested;
};

extern "C" __global__ void __intersection__point() {
    Candidates* list = reinterpret_cast<Candidates*>((unsigned long long)optixGetPayload_1() << 32 |
                                                     optixGetPayload_0());
    const unsigned id = optixGetPrimitiveIndex();
    const float3 p = params.points[id];
    const float dx = p.x - list->center.x, dy = p.y - list->center.y, dz = p.z - list->center.z;
    const float squared = dx * dx + dy * dy + dz * dz;
    list->tested++;
    if (squared >= params.radius * params.radius || squared > list->squared[kNeighbours - 1])
        return;
    int at = kNeighbours - 1;
    while (at > 0 && (list->squared[at - 1] > squared ||
                      (list->squared[at - 1] == squared && list->id[at - 1] > id))) {
        list->squared[at] = list->squared[at - 1];
        list->id[at] = list->id[at - 1];
        --at;
    }
    if (list->squared[at] < squared || (list->squared[at] == squared && list->id[at] < id))
        return; // the last of a full list, at the same distance
    list->squared[at] = squared;
    list->id[at] = id;
}

extern "C" __global__ void __raygen__query() {
    const unsigned query = optixGetLaunchIndex().x;
    if (query >= params.numQueries)
        return;
    Candidates list;
    list.center = params.queries[query];
    list.tested = 0;
    for (unsigned i = 0; i < kNeighbours; ++i) {
        list.squared[i] = 1e30f;
        list.id[i] = 0xffffffffu;
    }
    unsigned long long pointer = reinterpret_cast<unsigned long long>(&list);
    unsigned p0 = unsigned(pointer), p1 = unsigned(pointer >> 32);
    optixTrace(params.index, list.center, make_float3(1.0f, 0.0f, 0.0f), 0.0f, 1e-16f, 0.0f, 255,
               OPTIX_RAY_FLAG_DISABLE_ANYHIT | OPTIX_RAY_FLAG_DISABLE_CLOSESTHIT, 0, 0, 0, p0, p1);
    float sum = 0.0f, last = 0.0f;
    unsigned found = 0;
    for (unsigned i = 0; i < kNeighbours; ++i) {
        params.neighbours[query * kNeighbours + i] = list.id[i];
        if (list.id[i] == 0xffffffffu)
            continue;
        ++found;
        last = sqrtf(list.squared[i]);
        sum += last;
    }
    params.summary[query] = make_float4(sum / params.radius, last / params.radius,
                                        float(found) / kNeighbours, float(list.tested));
}
