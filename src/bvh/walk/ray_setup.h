// SPDX-License-Identifier: Apache-2.0
// Values that traversal computes once per ray and per entered space. Included through traverse.h.
//
// Box test. The primitive test (walk/ray_triangle.h) works on vertices rounded relative to the ray
// origin: it accepts a ray as if each vertex v were displaced by up to 5 * 2^-24 * |v - origin|.
// Culling must never lose such a hit, so boxes are tested with a ray that widens with distance, a
// cone of slope w = 2^-21 * max|direction|: its speed is |d| + w to the near planes and |d| - w to
// the far planes. (The part of the displacement due to the triangle's own size is in the padding of
// its box.) With r = 1 / speed both planes are one multiply-add, plane * r - origin * r; the
// rounding of origin * r is at most 2^-24 |origin * r| and moves into the constants, to the safe
// side. Margins thus cost nothing per node.
//
// If |d| of an axis is within 8 w of zero, the ray is between the planes for all its length or
// never: r becomes huge, and the planes move by the distance that the ray may drift on its path
// through the structure.
//
// If origin * r overflows, or |d| is so large that r is subnormal, the axis cannot cull. The
// constants are then larger than all distances, so the axis culls only the box of unused children.
// Infinite constants would not cull that box: infinity minus infinity is NaN, which testNode()
// ignores.
//
// Triangle test: the shear of Woop, Benthin and Wald, "Watertight Ray/Triangle Intersection"
// (JCGT 2013): axes permuted so that z is the longest of the direction, winding kept.
#pragma once

#include "bvh/layout.h"
#include "bvh/scalars.h"

namespace sunstone::bvh::SUNSTONE_ISA {

struct RaySetup {
    // Planes of axis i: distance = plane * r[i] + c[i].
    alignas(16) float nearR[4];
    float nearC[4], farR[4], farC[4], org[4]; // the fourth is undefined
    // Shear: direction[i] / direction[kz], and last 1 / direction[kz].
    float slope[4];
    uint32_t axis[4];       // kx, ky, kz
    uint32_t nearPlanes[4]; // byte offset of the near planes in a node
    float tmin;

    SUNSTONE_INLINE_MEMBER uint32_t farPlanes(int i) const { return nearPlanes[i] ^ kPlanesSize; }
    SUNSTONE_INLINE_MEMBER bool isBackwards(int i) const { return nearPlanes[i] & kPlanesSize; }
};

// The set-up behind an address that hides its origin: the compiler reads the values from memory
// where they are used. Otherwise it reads and duplicates them once per ray and keeps the vectors on
// the stack.
SUNSTONE_INLINE const RaySetup& reloaded(const RaySetup& setup) {
    const RaySetup* address = &setup;
    asm volatile("" : "+r"(address));
    return *address;
}

// False for rays that cannot hit: NaN, infinity or a zero direction.
SUNSTONE_INLINE bool isRay(const float org[3], const float dir[3], float tmin, float tmax) {
    const float longest = larger(larger(absolute(dir[0]), absolute(dir[1])), absolute(dir[2]));
    if (!(tmin <= tmax && longest >= 0x1p-120f))
        return false;
    // The sum of the magnitudes is finite only if all are finite. Rays whose sum overflows are
    // useless, too. No sum of numbers as small as these overflows.
    const __m128 signBit = _mm_set1_ps(-0.0f), small = _mm_set1_ps(0x1p120f);
    const __m128 o = _mm_andnot_ps(signBit, _mm_setr_ps(org[0], org[1], org[2], tmin)),
                 d = _mm_andnot_ps(signBit, _mm_setr_ps(dir[0], dir[1], dir[2], 0));
    if (_mm_movemask_ps(_mm_and_ps(_mm_cmplt_ps(o, small), _mm_cmplt_ps(d, small))) == 15)
        return true;
    return finite(absolute(org[0]) + absolute(org[1]) + absolute(org[2]) + absolute(dir[0]) +
                  absolute(dir[1]) + absolute(dir[2]) + absolute(tmin));
}

struct alignas(16) FourWords {
    uint32_t word[4];
};

// Axes kx, ky and kz of RaySetup. The index is 2 kz, plus 1 if the ray's direction along kz is
// negative.
constexpr FourWords kShearAxes[6] = {{{1, 2, 0}}, {{2, 1, 0}}, {{2, 0, 1}},
                                     {{0, 2, 1}}, {{0, 1, 2}}, {{1, 0, 2}}};

// RaySetup::nearPlanes. The index has a bit for each axis with a negative direction.
constexpr FourWords nearPlanesOf(uint32_t signs) {
    FourWords planes{};
    for (uint32_t i = 0; i < 3; ++i)
        planes.word[i] = (2 * i + (signs >> i & 1)) * kPlanesSize;
    return planes;
}
constexpr FourWords kNearPlanes[8] = {nearPlanesOf(0), nearPlanesOf(1), nearPlanesOf(2),
                                      nearPlanesOf(3), nearPlanesOf(4), nearPlanesOf(5),
                                      nearPlanesOf(6), nearPlanesOf(7)};

SUNSTONE_INLINE void copyWords(uint32_t to[4], const FourWords& from) {
    _mm_store_si128(reinterpret_cast<__m128i*>(to),
                    _mm_load_si128(reinterpret_cast<const __m128i*>(from.word)));
}

// The longest axis of a direction with these magnitudes; the later one of equal ones.
SUNSTONE_INLINE uint32_t longestAxis(__m128 speed) {
    const int greater = _mm_movemask_ps(_mm_cmpgt_ps(_mm_shuffle_ps(speed, speed, 0xd0),   // x x y
                                                     _mm_shuffle_ps(speed, speed, 0xe9))); // y z z
    // Two bits for each set of x > y, x > z and y > z.
    constexpr uint32_t kAxes = 2 | 2 << 2 | 2 << 4 | 0 << 6 | 1 << 8 | 2 << 10 | 1 << 12 | 0 << 14;
    return kAxes >> (greater & 7) * 2 & 3;
}

// d: the direction and 1; signs: a bit for each axis with a negative direction.
SUNSTONE_INLINE void setupShear(RaySetup& s, const float dir[3], __m128 d, __m128 speed,
                                uint32_t signs) {
    const uint32_t kz = longestAxis(speed);
    copyWords(s.axis, kShearAxes[2 * kz + (signs >> kz & 1)]);
    _mm_store_ps(s.slope, _mm_div_ps(d, _mm_set1_ps(dir[kz])));
}

// The planes of an axis along which the ray hardly moves.
SUNSTONE_INLINE void setupStillAxis(RaySetup& s, int i, float org, float dir, float reach,
                                    float travel) {
    const float far = larger(absolute(org), reach);
    const float r = far > 0x1p26f ? 0x1p126f / far : 0x1p100f;
    const float drift = smaller(travel, reach) * 0x1p-17f + absolute(org) * 0x1p-22f + 0x1p-60f;
    const float signedR = bitsOf(dir) >> 31 ? -r : r;
    s.nearR[i] = s.farR[i] = signedR;
    const float c = kFusedSlab ? -org * signedR : 0.0f;
    s.nearC[i] = c - drift * r;
    s.farC[i] = c + drift * r;
}

// The planes of an axis that culls only unused children: the product of their infinite planes, or
// of kFar, is at least kOpenReach.
constexpr float kOpenScale = 4, kOpenReach = 0x1.8p127f;
static_assert(kFar * double(kOpenScale) > kOpenReach);
SUNSTONE_INLINE void setupOpenAxis(RaySetup& s, int i, float dir) {
    s.nearR[i] = s.farR[i] = bitsOf(dir) >> 31 ? -kOpenScale : kOpenScale;
    s.nearC[i] = -kOpenReach;
    s.farC[i] = kOpenReach;
}
// An axis is open if -origin * r exceeds this, or its speed times kOpenSpeed does.
constexpr float kLargestProduct = 0x1p127f, kOpenSpeed = 8;

// The largest distance of the structure from the origin along an axis.
SUNSTONE_INLINE float reachOf(const BlockHeader* header, const float org[3]) {
    float reach = 0;
    for (int i = 0; i < 3; ++i)
        reach = larger(reach, larger(absolute(header->lower[i] - org[i]),
                                     absolute(header->upper[i] - org[i])));
    return reach;
}

// Sets up the axes in these sets.
SUNSTONE_INLINE void setupRareAxes(RaySetup& s, const BlockHeader* header, const float org[3],
                                   const float dir[3], float travel, int stillAxes, int openAxes) {
    const float reach = reachOf(header, org);
    for (int i = 0; i < 3; ++i) {
        if (stillAxes >> i & 1)
            setupStillAxis(s, i, org[i], dir[i], reach, travel);
        else if (openAxes >> i & 1)
            setupOpenAxis(s, i, dir[i]);
    }
}

// The ray must satisfy isRay(). header: the block whose nodes will be visited.
SUNSTONE_INLINE void setupRay(RaySetup& s, const BlockHeader* header, const float org[3],
                              const float dir[3], float tmin, float tmax) {
    const float longest = larger(larger(absolute(dir[0]), absolute(dir[1])), absolute(dir[2]));
    const __m128 o = _mm_setr_ps(org[0], org[1], org[2], 0),
                 d = _mm_setr_ps(dir[0], dir[1], dir[2], 1);
    const __m128 signBit = _mm_set1_ps(-0.0f);
    const __m128 sign = _mm_and_ps(d, signBit), speed = _mm_andnot_ps(signBit, d);
    const __m128 w = _mm_set1_ps(longest * 0x1p-21f), one = _mm_set1_ps(1);
    const __m128 nearR = _mm_or_ps(_mm_div_ps(one, _mm_add_ps(speed, w)), sign);
    const __m128 farR = _mm_or_ps(
        _mm_mul_ps(_mm_div_ps(one, _mm_sub_ps(speed, w)), _mm_set1_ps(1 + 0x1p-21f)), sign);
    __m128 nearC = _mm_setzero_ps(), farC = _mm_setzero_ps();
    __m128 largest = _mm_mul_ps(speed, _mm_set1_ps(kOpenSpeed));
    if constexpr (kFusedSlab) {
        const __m128 n = _mm_xor_ps(_mm_mul_ps(o, nearR), signBit);
        const __m128 f = _mm_xor_ps(_mm_mul_ps(o, farR), signBit);
        const __m128 ulps = _mm_set1_ps(0x1p-22f);
        nearC = _mm_sub_ps(n, _mm_mul_ps(_mm_andnot_ps(signBit, n), ulps));
        farC = _mm_add_ps(f, _mm_mul_ps(_mm_andnot_ps(signBit, f), ulps));
        largest = _mm_max_ps(largest, _mm_andnot_ps(signBit, f));
    }
    _mm_store_ps(s.nearR, nearR);
    _mm_store_ps(s.nearC, nearC);
    _mm_store_ps(s.farR, farR);
    _mm_store_ps(s.farC, farC);
    _mm_store_ps(s.org, o);
    const auto signs = uint32_t(_mm_movemask_ps(d));
    copyWords(s.nearPlanes, kNearPlanes[signs & 7]);
    const float still = larger(longest * 0x1p-18f, 0x1p-100f);
    const __m128 isStill = _mm_cmple_ps(speed, _mm_set1_ps(still)),
                 isOpen = _mm_cmpgt_ps(largest, _mm_set1_ps(kLargestProduct));
    if (__builtin_expect((_mm_movemask_ps(_mm_or_ps(isStill, isOpen)) & 7) != 0, 0))
        setupRareAxes(s, header, org, dir, tmax * longest, _mm_movemask_ps(isStill),
                      _mm_movemask_ps(isOpen));
    s.tmin = tmin;
    setupShear(s, dir, d, speed, signs);
}

} // namespace sunstone::bvh::SUNSTONE_ISA
