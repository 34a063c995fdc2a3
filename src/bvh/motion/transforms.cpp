// SPDX-License-Identifier: Apache-2.0
#include "bvh/motion/transforms.h"

#include "base/readable.h"
#include "math/matrix.h"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace sunstone::bvh {
namespace {

template <class Transform>
const Transform& at(uint64_t handle) {
    return *reinterpret_cast<const Transform*>(handle & ~devlib::kTagMask);
}

size_t tagOf(uint64_t handle) {
    return handle & devlib::kTagMask;
}

} // namespace

bool isReadableTransform(uint64_t handle) {
    const auto* address = reinterpret_cast<const void*>(handle & ~devlib::kTagMask);
    switch (tagOf(handle)) {
    case devlib::kTagStatic:
        return isReadableNearby(address, sizeof(StaticTransform));
    case devlib::kTagMatrixMotion:
        return isReadableNearby(address, sizeof(MatrixMotionTransform)) &&
               isReadableNearby(address,
                                offsetof(MatrixMotionTransform, matrices) +
                                    std::max<size_t>(motionOf(handle).keys, 2) * sizeof(float[12]));
    case devlib::kTagSrtMotion:
        return isReadableNearby(address, sizeof(SrtMotionTransform)) &&
               isReadableNearby(address,
                                offsetof(SrtMotionTransform, keys) +
                                    std::max<size_t>(motionOf(handle).keys, 2) * sizeof(SrtKey));
    default:
        return false;
    }
}

// Returns a motion key; the structs declare only the first two.
template <class Key>
const Key* keyOf(uint64_t transform, size_t offset, uint32_t key) {
    return reinterpret_cast<const Key*>(&at<unsigned char>(transform) + offset) + key;
}

void transformAt(uint64_t transform, KeySegment segment, float m[12]) {
    const float fraction = segment.fraction;
    if (tagOf(transform) == devlib::kTagMatrixMotion) {
        const float* key =
            keyOf<float>(transform, offsetof(MatrixMotionTransform, matrices), 12 * segment.key);
        for (int i = 0; i < 12; ++i)
            m[i] = fraction > 0 ? between(key[i], key[12 + i], fraction) : key[i];
        return;
    }
    const SrtKey* key = keyOf<SrtKey>(transform, offsetof(SrtMotionTransform, keys), segment.key);
    float numbers[2][16];
    std::memcpy(numbers[0], key, sizeof(SrtKey));
    if (fraction > 0) {
        std::memcpy(numbers[1], key + 1, sizeof(SrtKey));
        for (int i = 0; i < 16; ++i)
            numbers[0][i] = between(numbers[0][i], numbers[1][i], fraction);
    }
    float* const k = numbers[0];
    const float scale =
        1.0f / std::sqrt(k[9] * k[9] + k[10] * k[10] + k[11] * k[11] + k[12] * k[12]);
    for (int i = 9; i < 13; ++i)
        k[i] *= scale;
    math::multiplySrt(k, m);
}

bool worldToObjectAt(uint64_t transform, float time, float worldToObject[12]) {
    const MotionRange& motion = motionOf(transform);
    float m[12];
    if (motion.keys < 2) {
        transformAt(transform, {0, 0.0f}, m);
    } else {
        if (hasVanished(motion.flags, motion.begin, motion.end, time))
            return false;
        transformAt(transform, keySegment(motion.keys, motion.begin, motion.end, time), m);
    }
    return math::invert(m, worldToObject);
}

} // namespace sunstone::bvh
