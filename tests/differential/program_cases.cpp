// SPDX-License-Identifier: Apache-2.0
// Exceptions and callables.
#include "lab.h"

namespace differential {
namespace {

Pipeline withExceptions(unsigned flags) {
    Pipeline pipeline;
    pipeline.exceptions = true;
    pipeline.exceptionFlags = flags;
    return pipeline;
}

void thrownByRaygen(const Lab& lab, Answer& answer) {
    const Accel mesh = lab.triangles(randomTriangles(200, 0.4f, 301));
    Pipeline pipeline = withExceptions(OPTIX_EXCEPTION_FLAG_USER);
    pipeline.raygen = "__raygen__throw";
    pipeline.hits = {HitRecord()};
    answer.seen = lab.trace(pipeline, randomRays(200, 3, 302), mesh.handle);
}

void thrownByClosestHit(const Lab& lab, Answer& answer) {
    const Accel mesh = lab.triangles(randomTriangles(200, 0.4f, 303));
    Pipeline pipeline = withExceptions(OPTIX_EXCEPTION_FLAG_USER);
    HitRecord hit;
    hit.closestHit = "__closesthit__throw";
    pipeline.hits = {hit};
    answer.seen = lab.trace(pipeline, randomRays(200, 3, 304), mesh.handle);
}

void traceDepth(const Lab& lab, Answer& answer, unsigned depth) {
    const Accel mesh = lab.triangles(randomTriangles(200, 0.4f, 305));
    Pipeline pipeline = withExceptions(OPTIX_EXCEPTION_FLAG_TRACE_DEPTH);
    pipeline.traceDepth = depth;
    HitRecord hit;
    hit.closestHit = "__closesthit__again";
    pipeline.hits = {hit};
    answer.seen = lab.trace(pipeline, randomRays(200, 3, 306), mesh.handle);
}

void callables(const Lab& lab, Answer& answer) {
    Pipeline pipeline;
    pipeline.raygen = "__raygen__callables";
    pipeline.callables = true;
    pipeline.hits = {HitRecord()};
    answer.seen = lab.trace(pipeline, randomRays(100, 3, 307), 0);
}

} // namespace

std::vector<Case> programCases() {
    return {{"exceptions.thrown_by_raygen", thrownByRaygen},
            {"exceptions.thrown_by_closest_hit", thrownByClosestHit},
            {"exceptions.trace_depth_1",
             [](const Lab& lab, Answer& answer) { traceDepth(lab, answer, 1); }},
            {"exceptions.trace_depth_3",
             [](const Lab& lab, Answer& answer) { traceDepth(lab, answer, 3); }},
            {"callables", callables}};
}

} // namespace differential
