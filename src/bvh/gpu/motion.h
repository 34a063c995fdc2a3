// SPDX-License-Identifier: Apache-2.0
// Times and motion transforms on GPUs, with the operations of the CPU (bvh/motion/motion.h,
// bvh/motion/transforms.cpp), so that both transform a ray to the same bits.
#pragma once

#if defined(__CUDA__)
#pragma clang force_cuda_host_device begin
#endif

#include "bvh/gpu/portable.h"
#include "bvh/motion/transforms.h"
#include "math/matrix.h"

namespace sunstone::bvh::gpu {

// Interpolation of geometry that programs read, as bvh::vertexBetween and bvh::pointBetween.
SUNSTONE_INLINE float mixVertex(float a, float b, float fraction) {
    return fused(sub(1.0f, fraction), a, mul(fraction, b));
}
SUNSTONE_INLINE float mixPoint(float a, float b, float fraction) {
    return fused(fraction, sub(b, a), a);
}

// The key segment of the motion transform entered last. Transforms of a scene tend to have the same
// range of time.
struct KnownSegment {
    uint32_t keysAndFlags = 0, begin = 0, end = 0; // of its MotionRange, floats as bits
    KeySegment at = {0, 0.0f};
};

// As bvh::worldToObjectAt: the world-to-object matrix of a motion transform at a time, and its
// child. False if the transform cannot be entered. `known` belongs to the same time. Matrices and
// SRT components share the interpolation of the first twelve numbers and one inversion, so that
// lanes with either kind stay together. At a key, that key also serves as the next key.
SUNSTONE_INLINE bool worldToObjectOf(uint64_t transform, float time, KnownSegment& known,
                                     uint64_t& child, float worldToObject[12]) {
    const U4* const words = reinterpret_cast<const U4*>(transform & ~devlib::kTagMask);
    const U4 head = loadConstant(words);
    const uint32_t end = loadConstant(reinterpret_cast<const uint32_t*>(words + 1));
    child = uint64_t(head.y) << 32 | head.x;
    if (head.z != known.keysAndFlags || head.w != known.begin || end != known.end) {
        const uint32_t keys = head.z & 0xFFFFu;
        KeySegment at = {0, 0.0f};
        if (keys >= 2) {
            if (hasVanished(head.z >> 16, floatOf(head.w), floatOf(end), time))
                return false;
            at = keySegment(keys, floatOf(head.w), floatOf(end), time);
        }
        known = {head.z, head.w, end, at};
    }
    const bool factors = (transform & devlib::kTagMask) == devlib::kTagSrtMotion;
    const uint32_t size = factors ? sizeof(SrtKey) / 16 : 3;
    const float second = known.at.fraction, first = sub(1.0f, second);
    const U4* const key = words + 2 + size * known.at.key;
    const U4* const next = key + (second > 0 ? size : 0);
    float k[16];
    const auto load = [&](uint32_t i) {
        const U4 a = loadConstant(key + i), b = loadConstant(next + i);
        const auto one = [&](uint32_t x, uint32_t y) {
            return add(mul(floatOf(x), first), mul(floatOf(y), second));
        };
        k[4 * i] = one(a.x, b.x), k[4 * i + 1] = one(a.y, b.y);
        k[4 * i + 2] = one(a.z, b.z), k[4 * i + 3] = one(a.w, b.w);
    };
    for (uint32_t i = 0; i < 3; ++i)
        load(i);
    float m[12];
    for (int i = 0; i < 12; ++i)
        m[i] = k[i];
    if (factors) {
        load(3);
        const float scale =
            divide(1.0f, root(add(add(add(mul(k[9], k[9]), mul(k[10], k[10])), mul(k[11], k[11])),
                                  mul(k[12], k[12]))));
        for (int i = 9; i < 13; ++i)
            k[i] = mul(k[i], scale);
        math::multiplySrt(k, m);
    }
    return math::invert(m, worldToObject);
}
static_assert(offsetof(MatrixMotionTransform, motion) == 8 && offsetof(MotionRange, flags) == 2 &&
              offsetof(MotionRange, begin) == 4 && offsetof(MotionRange, end) == 8 &&
              offsetof(MatrixMotionTransform, matrices) == 32 &&
              offsetof(SrtMotionTransform, keys) == 32 && sizeof(SrtKey) % 16 == 0);

} // namespace sunstone::bvh::gpu

#if defined(__CUDA__)
#pragma clang force_cuda_host_device end
#endif
