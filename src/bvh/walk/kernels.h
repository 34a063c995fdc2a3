// SPDX-License-Identifier: Apache-2.0
// The instruction sets of this machine, and ray queries on a single structure of triangles for
// tests and benchmarks. The OptiX run-time (devlib) compiles the same loop with its own visitors.
#pragma once

#include <cstdint>

namespace sunstone::bvh {

enum class Isa : uint32_t { kBaseline = 0, kAvx2 = 1, kAvx512 = 2 };

const char* isaName(Isa isa);

// Whether this processor (and its operating system) runs the set.
bool isaSupported(Isa isa);

// The best supported set that SUNSTONE_ISA allows. An unknown value is logged and ignored.
Isa chosenIsa();

struct QueryRay {
    float origin[3];
    float tmin;
    float direction[3];
    float tmax;
};

struct QueryHit {
    float t, u, v; // u at vertex 1, v at vertex 2
    uint32_t primitive;
    uint32_t sbt; // index and geometry flags, see layout.h
    bool front;
};

struct Kernels {
    // The nearest hit; false (hit untouched) if there is none. Blocks without triangles count as
    // empty.
    bool (*closest)(const void* block, const QueryRay& ray, QueryHit& hit);
    bool (*occluded)(const void* block, const QueryRay& ray);
    // Whether the ray meets the front (or the back) of some triangle.
    bool (*meetsSide)(const void* block, const QueryRay& ray, bool front);
    // closest and any for triangles with motion keys; any other block counts as empty.
    bool (*closestAt)(const void* block, const QueryRay& ray, float time, QueryHit& hit);
    bool (*occludedAt)(const void* block, const QueryRay& ray, float time);
};

// The kernels of a set, which must be supported.
const Kernels& kernels(Isa isa);

extern const Kernels kKernelsBaseline, kKernelsAvx2, kKernelsAvx512;

} // namespace sunstone::bvh
