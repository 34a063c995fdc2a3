// SPDX-License-Identifier: Apache-2.0
// Motion transforms: nodes of the traversable graph in the caller's memory, with a matrix for each
// key or with its SRT components. Their contents are the caller's responsibility; any bytes are
// safe, but may make rays pass through the transform.
#pragma once

#include "bvh/motion/motion.h"

#include <cstddef>

namespace sunstone::bvh {

// OptixMotionOptions. Fewer than two keys: the first one at all times.
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

// The child of a transform that can be read: the first member of all three.
inline uint64_t childOf(uint64_t transform) {
    return reinterpret_cast<const StaticTransform*>(transform & ~devlib::kTagMask)->child;
}

// The motion of a motion transform that can be read.
inline const MotionRange& motionOf(uint64_t transform) {
    static_assert(offsetof(MatrixMotionTransform, motion) == offsetof(SrtMotionTransform, motion));
    return reinterpret_cast<const MatrixMotionTransform*>(transform & ~devlib::kTagMask)->motion;
}

// Object to world at a key and a fraction of the way to the next, of a motion transform. Numbers
// are interpolated one by one; the quaternion is normalised after.
void transformAt(uint64_t transform, KeySegment at, float objectToWorld[12]);

// World to object at a time; false if the child cannot be entered: vanished, or no inverse.
bool worldToObjectAt(uint64_t transform, float time, float worldToObject[12]);

} // namespace sunstone::bvh
