// SPDX-License-Identifier: Apache-2.0
#include "bvh/motion/transforms.h"

#include "base/readable.h"
#include "math/affine.h"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace sunstone::bvh {
namespace {

template <class Transform>
const Transform& at(uint64_t handle) {
    return *reinterpret_cast<const Transform*>(handle & ~kTraversableTagMask);
}

size_t tagOf(uint64_t handle) {
    return handle & kTraversableTagMask;
}

void multiplySrt(const SrtKey& k, float m[12]) {
    const float xx = k.qx * k.qx, yy = k.qy * k.qy, zz = k.qz * k.qz, ww = k.qw * k.qw;
    const float xy = k.qx * k.qy, xz = k.qx * k.qz, yz = k.qy * k.qz;
    const float wx = k.qw * k.qx, wy = k.qw * k.qy, wz = k.qw * k.qz;
    const float rotation[12] = {ww + xx - yy - zz, 2 * (xy - wz),     2 * (xz + wy),     k.tx,
                                2 * (xy + wz),     ww - xx + yy - zz, 2 * (yz - wx),     k.ty,
                                2 * (xz - wy),     2 * (yz + wx),     ww - xx - yy + zz, k.tz};
    const float scale[12] = {k.sx, k.a, k.b, k.pvx, 0, k.sy, k.c, k.pvy, 0, 0, k.sz, k.pvz};
    const math::Affine product = math::multiply(rotation, scale);
    std::copy(product.m, product.m + 12, m);
}

} // namespace

bool isReadableTransform(uint64_t handle) {
    const auto* address = reinterpret_cast<const void*>(handle & ~kTraversableTagMask);
    switch (tagOf(handle)) {
    case kStaticTransformTag:
        return isReadable(address, sizeof(StaticTransform));
    case kMatrixMotionTag:
        return isReadable(address, sizeof(MatrixMotionTransform)) &&
               isReadable(address,
                          offsetof(MatrixMotionTransform, matrices) +
                              std::max<size_t>(motionOf(handle).keys, 2) * sizeof(float[12]));
    case kSrtMotionTag:
        return isReadable(address, sizeof(SrtMotionTransform)) &&
               isReadable(address, offsetof(SrtMotionTransform, keys) +
                                       std::max<size_t>(motionOf(handle).keys, 2) * sizeof(SrtKey));
    default:
        return false;
    }
}

// A motion key; the structs declare the two that are always there.
template <class Key>
const Key* keyOf(uint64_t transform, size_t offset, uint32_t key) {
    return reinterpret_cast<const Key*>(&at<unsigned char>(transform) + offset) + key;
}

void transformAt(uint64_t transform, KeySegment segment, float m[12]) {
    const float fraction = segment.fraction;
    if (tagOf(transform) == kMatrixMotionTag) {
        const float* key =
            keyOf<float>(transform, offsetof(MatrixMotionTransform, matrices), 12 * segment.key);
        for (int i = 0; i < 12; ++i)
            m[i] = fraction > 0 ? between(key[i], key[12 + i], fraction) : key[i];
        return;
    }
    const SrtKey* key =
        keyOf<SrtKey>(transform, offsetof(SrtMotionTransform, keys), segment.key);
    float numbers[2][16];
    std::memcpy(numbers[0], key, sizeof(SrtKey));
    if (fraction > 0) {
        std::memcpy(numbers[1], key + 1, sizeof(SrtKey));
        for (int i = 0; i < 16; ++i)
            numbers[0][i] = between(numbers[0][i], numbers[1][i], fraction);
    }
    SrtKey srt;
    std::memcpy(&srt, numbers[0], sizeof(SrtKey));
    const float scale =
        1.0f / std::sqrt(srt.qx * srt.qx + srt.qy * srt.qy + srt.qz * srt.qz + srt.qw * srt.qw);
    srt.qx *= scale;
    srt.qy *= scale;
    srt.qz *= scale;
    srt.qw *= scale;
    multiplySrt(srt, m);
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
