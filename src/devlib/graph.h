// SPDX-License-Identifier: Apache-2.0
// Nodes of the traversable graph: handles, the instances of acceleration structures, and the data
// of a hit about its primitive.
#pragma once

#include <cstdint>

namespace sunstone::devlib {

// Traversable handles are addresses with a tag in the low bits (acceleration structures are
// 128-byte aligned, transforms and instance records 64). Zero is the null handle.
enum HandleTag : uint64_t {
    kTagGas = 1,
    kTagIas = 2,
    kTagStatic = 3,       // OptixStaticTransform in user memory
    kTagMatrixMotion = 4, // OptixMatrixMotionTransform
    kTagSrtMotion = 5,    // OptixSRTMotionTransform
    kTagInstance = 6,     // InstanceRecord inside an IAS: only in transform lists
    kTagVisit = 7,        // VisitNode; OptiX 7 has none
    kTagMask = 63,
};
inline uint64_t makeHandle(const void* address, HandleTag tag) {
    return uint64_t(address) | tag;
}
inline HandleTag tagOf(uint64_t handle) {
    return HandleTag(handle & kTagMask);
}
inline uint64_t addressOf(uint64_t handle) {
    return handle & ~uint64_t(kTagMask);
}

// An instance as stored in an instance acceleration structure; 64-byte aligned. A transform-list
// handle points here, and programs read the matrices through it.
struct alignas(64) InstanceRecord {
    float objectToWorld[12]; // rows
    float worldToObject[12];
    uint64_t child;
    uint32_t instanceId;
    uint32_t sbtOffset;
    uint32_t visibilityMask;
    uint32_t flags;
    uint32_t index;
    uint32_t pad;
};
static_assert(sizeof(InstanceRecord) == 128);

// Hit kinds of triangles; custom primitives use 0..127. Curves and spheres have kHitShape and the
// low four bits of the number of their OptixPrimitiveType; spheres seen from within have
// kHitShapeBack too.
enum HitKind : uint32_t {
    kHitShape = 0x80,
    kHitShapeBack = 0x10,
    kHitTriangleFront = 0xFE,
    kHitTriangleBack = 0xFF,
};

} // namespace sunstone::devlib
