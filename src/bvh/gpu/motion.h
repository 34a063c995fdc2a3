// SPDX-License-Identifier: Apache-2.0
// Times and motion transforms on GPUs, with the operations of the CPU (bvh/motion/motion.h,
// bvh/motion/transforms.cpp, math/affine.h), so that both transform a ray to the same bits.
#pragma once

#if defined(__CUDA__)
#pragma clang force_cuda_host_device begin
#endif

#include "bvh/gpu/portable.h"
#include "bvh/motion/transforms.h"

namespace sunstone::bvh::gpu {

// One number between two keys: bvh::between.
SUNSTONE_GPU_INLINE float mix(float a, float b, float fraction) {
    return add(mul(a, sub(1.0f, fraction)), mul(b, fraction));
}

// math::invert.
SUNSTONE_GPU_INLINE bool invert(const float m[12], float inverse[12]) {
    const double a = m[0], b = m[1], c = m[2], d = m[4], e = m[5], f = m[6];
    const double g = m[8], h = m[9], i = m[10];
    const double c0 = sub(mul(e, i), mul(f, h)), c1 = sub(mul(f, g), mul(d, i)),
                 c2 = sub(mul(d, h), mul(e, g));
    const double det = add(add(mul(a, c0), mul(b, c1)), mul(c, c2));
    const double s = 1.0 / det;
    const double r[9] = {
        mul(c0, s), mul(sub(mul(c, h), mul(b, i)), s), mul(sub(mul(b, f), mul(c, e)), s),
        mul(c1, s), mul(sub(mul(a, i), mul(c, g)), s), mul(sub(mul(c, d), mul(a, f)), s),
        mul(c2, s), mul(sub(mul(b, g), mul(a, h)), s), mul(sub(mul(a, e), mul(b, d)), s)};
    bool finite = det != 0;
    for (int row = 0; row < 3; ++row) {
        const double* const q = r + 3 * row;
        const double t =
            -add(add(mul(q[0], double(m[3])), mul(q[1], double(m[7]))), mul(q[2], double(m[11])));
        for (int j = 0; j < 4; ++j) {
            const float value = float(j < 3 ? q[j] : t);
            inverse[4 * row + j] = value;
            finite = finite && (bitsOf(value) & 0x7F800000u) != 0x7F800000u;
        }
    }
    if (!finite)
        for (int k = 0; k < 12; ++k)
            inverse[k] = 0;
    return finite;
}

// T * R * S of a key with a normalised quaternion.
SUNSTONE_GPU_INLINE void multiplySrt(const float k[16], float m[12]) {
    const float qx = k[9], qy = k[10], qz = k[11], qw = k[12];
    const float xx = mul(qx, qx), yy = mul(qy, qy), zz = mul(qz, qz), ww = mul(qw, qw);
    const float xy = mul(qx, qy), xz = mul(qx, qz), yz = mul(qy, qz);
    const float wx = mul(qw, qx), wy = mul(qw, qy), wz = mul(qw, qz);
    const float r[12] = {sub(sub(add(ww, xx), yy), zz),
                         2 * sub(xy, wz),
                         2 * add(xz, wy),
                         k[13],
                         2 * add(xy, wz),
                         sub(add(sub(ww, xx), yy), zz),
                         2 * sub(yz, wx),
                         k[14],
                         2 * sub(xz, wy),
                         2 * add(yz, wx),
                         add(sub(sub(ww, xx), yy), zz),
                         k[15]};
    const float s[12] = {k[0], k[1], k[2], k[3], 0, k[4], k[5], k[6], 0, 0, k[7], k[8]};
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 4; ++j)
            m[4 * i + j] = add(add(add(mul(r[4 * i], s[j]), mul(r[4 * i + 1], s[4 + j])),
                                   mul(r[4 * i + 2], s[8 + j])),
                               j == 3 ? r[4 * i + 3] : 0.0f);
}

// The key segment of the motion transform entered last. Transforms of a scene tend to have the same
// range of time.
struct KnownSegment {
    uint32_t keysAndFlags = 0, begin = 0, end = 0; // of its MotionRange, floats as bits
    KeySegment at = {0, 0.0f};
};

// bvh::worldToObjectAt: world to object of a motion transform at a time, and its child; false if it
// cannot be entered. `known` is of the same time. Matrices and SRT components share the
// interpolation of the first twelve numbers and one inversion, so that lanes with either stay
// together; at a key, that key also serves as the next one.
SUNSTONE_GPU_INLINE bool worldToObjectOf(uint64_t transform, float time, KnownSegment& known,
                                         uint64_t& child, float worldToObject[12]) {
    const U4* const words = reinterpret_cast<const U4*>(transform & ~kTraversableTagMask);
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
    const bool factors = (transform & kTraversableTagMask) == kSrtMotionTag;
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
        const float scale = divide(
            1.0f, root(add(add(add(mul(k[9], k[9]), mul(k[10], k[10])), mul(k[11], k[11])),
                           mul(k[12], k[12]))));
        for (int i = 9; i < 13; ++i)
            k[i] = mul(k[i], scale);
        multiplySrt(k, m);
    }
    return invert(m, worldToObject);
}
static_assert(offsetof(MatrixMotionTransform, motion) == 8 && offsetof(MotionRange, flags) == 2 &&
              offsetof(MotionRange, begin) == 4 && offsetof(MotionRange, end) == 8 &&
              offsetof(MatrixMotionTransform, matrices) == 32 &&
              offsetof(SrtMotionTransform, keys) == 32 && sizeof(SrtKey) % 16 == 0);

} // namespace sunstone::bvh::gpu

#if defined(__CUDA__)
#pragma clang force_cuda_host_device end
#endif
