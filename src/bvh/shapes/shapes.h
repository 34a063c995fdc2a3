// SPDX-License-Identifier: Apache-2.0
// Ray queries on structures of curves and spheres: primitives whose intersection test is built in,
// but no triangles. The OptiX run-time calls these kernels when a ray enters such a structure;
// tests and benchmarks use them directly. Compiled once per instruction set.
#pragma once

#include "bvh/walk/kernels.h"

#include <cstdint>

namespace sunstone::bvh {

struct ShapeRay {
    float origin[3];
    float tmin;
    float direction[3];
    float tmax;
    float time;
};

struct ShapeHit {
    float t;
    float u; // place on a curve's segment; 0 for spheres
    uint32_t primitive;
    uint32_t sbt;  // index and geometry flags, see layout.h
    uint32_t kind; // devlib::HitKind
};

// Judges hits one by one.
struct ShapeFilter {
    enum Answer : uint32_t { kIgnore = 0, kAccept = 1, kEnd = 2 };
    Answer (*offer)(void* context, const ShapeHit& hit);
    void* context;
};

// The block must be one of curves or spheres.
struct ShapeKernels {
    // The nearest hit; false (hit untouched) if there is none.
    bool (*closest)(const void* block, const ShapeRay& ray, ShapeHit& hit);
    // Any hit, if one exists.
    bool (*any)(const void* block, const ShapeRay& ray, ShapeHit& hit);
    // Offers hits in any order, but never behind an accepted one.
    void (*filtered)(const void* block, const ShapeRay& ray, const ShapeFilter& filter);
};

namespace baseline {
extern const ShapeKernels kShapes;
}
namespace avx2 {
extern const ShapeKernels kShapes;
}
namespace avx512 {
extern const ShapeKernels kShapes;
}

// The kernels of a set, which must be supported.
const ShapeKernels& shapeKernels(Isa isa);

} // namespace sunstone::bvh
