// SPDX-License-Identifier: Apache-2.0
// Motion transforms: nodes of the traversable graph in the caller's memory, with a matrix for each
// key or with its SRT components. The caller is responsible for their contents. All bytes are safe,
// but with some of them rays miss the transform.
#pragma once

#include "bvh/motion/motion.h"

#include <cstddef>

namespace sunstone::bvh {

// OptixMotionOptions. With fewer than two keys, the first key applies at all times.
struct MotionRange {
    uint16_t keys;
    uint16_t flags; // MotionFlag
    float begin, end;
};

struct MatrixMotionTransform {
    uint64_t child;
    MotionRange motion;
    uint32_t pad[3];
    float matrices[2][12]; // object to world; more behind if there are more keys
};
static_assert(sizeof(MatrixMotionTransform) == 128);

// Scale and shear with a pivot, rotation, translation: the transform is T * R * S, with
// S = (sx a b pvx, 0 sy c pvy, 0 0 sz pvz) and R the rotation of the normalised quaternion.
struct SrtKey {
    float sx, a, b, pvx, sy, c, pvy, sz, pvz, qx, qy, qz, qw, tx, ty, tz;
};

struct SrtMotionTransform {
    uint64_t child;
    MotionRange motion;
    uint32_t pad[3];
    SrtKey keys[2]; // more behind if there are more keys
};
static_assert(sizeof(SrtMotionTransform) == 160);

// Longer chains of transforms are invalid.
constexpr int kMaxTransformChain = 32;

// Whether the tag is that of a transform in the caller's memory.
inline bool isTransformTag(uint64_t tag) {
    return tag == devlib::kTagStatic || tag == devlib::kTagMatrixMotion ||
           tag == devlib::kTagSrtMotion;
}

// Whether all of a transform, with all its keys, can be read. Never faults.
bool isReadableTransform(uint64_t handle);

// The child of a readable transform: the first member of all three structs.
inline uint64_t childOf(uint64_t transform) {
    return reinterpret_cast<const StaticTransform*>(transform & ~devlib::kTagMask)->child;
}

// The motion of a readable motion transform.
inline const MotionRange& motionOf(uint64_t transform) {
    static_assert(offsetof(MatrixMotionTransform, motion) == offsetof(SrtMotionTransform, motion));
    return reinterpret_cast<const MatrixMotionTransform*>(transform & ~devlib::kTagMask)->motion;
}

// The object-to-world matrix of a motion transform at a place between two keys. Numbers are
// interpolated one by one; then the quaternion is normalised.
void transformAt(uint64_t transform, KeySegment at, float objectToWorld[12]);

// The world-to-object matrix at a time. False if the child cannot be entered: it has vanished, or
// the matrix has no inverse.
bool worldToObjectAt(uint64_t transform, float time, float worldToObject[12]);

} // namespace sunstone::bvh
