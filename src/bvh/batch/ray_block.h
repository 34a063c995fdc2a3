// SPDX-License-Identifier: Apache-2.0
// Up to 64 rays as lanes, with one array per value. setup() computes for all rays the values that
// setupRay() (walk/ray_setup.h) computes for one ray, with the same operations. Included by files
// that are compiled once per instruction set (see bvh/simd.h).
#pragma once

#include "bvh/batch/ray_batch.h"
#include "bvh/walk/traverse.h"
#include "bvh/wide.h"

namespace sunstone::bvh::SUNSTONE_ISA {

struct alignas(64) RayBlock {
    static constexpr uint32_t kRays = 64;

    float org[3][kRays], dir[3][kRays];
    float start[kRays], tmin[kRays], tmax[kRays]; // tmin as given, and at least 0 for boxes
    float nearR[3][kRays], nearC[3][kRays], farR[3][kRays], farC[3][kRays];
    float shear[3][kRays];
    uint8_t axes[kRays];   // in kShearAxes
    uint8_t octant[kRays]; // a bit for each axis with a negative direction
    uint64_t valid;        // isRay()
    uint64_t open;         // rays with an open axis, see setupOpenAxis()

    SUNSTONE_INLINE_MEMBER void set(uint32_t lane, const BatchRay& ray) {
        for (int i = 0; i < 3; ++i) {
            org[i][lane] = ray.origin[i];
            dir[i][lane] = ray.direction[i];
        }
        start[lane] = ray.tmin;
        tmax[lane] = ray.tmax;
    }

    // header: the block whose nodes the first `count` rays visit. All other rays become copies of
    // the first ray, but are not valid.
    void setup(const BlockHeader* header, uint32_t count);

    // Fills the RaySetup of one ray.
    SUNSTONE_INLINE_MEMBER void copyTo(RaySetup& s, uint32_t lane) const {
        for (int i = 0; i < 3; ++i) {
            s.nearR[i] = nearR[i][lane];
            s.nearC[i] = nearC[i][lane];
            s.farR[i] = farR[i][lane];
            s.farC[i] = farC[i][lane];
            s.org[i] = org[i][lane];
        }
        copyWords(s.nearPlanes, kNearPlanes[octant[lane]]);
        copyWords(s.axis, kShearAxes[axes[lane]]);
        s.slope[s.axis[0]] = shear[0][lane];
        s.slope[s.axis[1]] = shear[1][lane];
        s.slope[3] = shear[2][lane];
        s.tmin = start[lane];
    }

private:
    static constexpr uint32_t kLanes = WideLanes::kLanes;
    void setupLanes(const BlockHeader* header, uint32_t first);
    void setupPlanes(const BlockHeader* header, uint32_t first, const WideLanes* speed,
                     WideLanes longest, Mask good);
    void setupRare(const BlockHeader* header, int axis, uint32_t lane, float longest, bool isStill);
};

inline void RayBlock::setup(const BlockHeader* header, uint32_t count) {
    for (uint32_t lane = count; lane < (count + kLanes - 1) / kLanes * kLanes; ++lane) {
        for (int i = 0; i < 3; ++i) {
            org[i][lane] = org[i][0];
            dir[i][lane] = dir[i][0];
        }
        start[lane] = start[0];
        tmax[lane] = tmax[0];
    }
    valid = open = 0;
    for (uint32_t lane = 0; lane < count; lane += kLanes)
        setupLanes(header, lane);
    if (count < kRays)
        valid &= (uint64_t(1) << count) - 1;
}

inline void RayBlock::setupRare(const BlockHeader* header, int axis, uint32_t lane, float longest,
                                bool isStill) {
    RaySetup s;
    const float origin[3] = {org[0][lane], org[1][lane], org[2][lane]};
    if (isStill) {
        setupStillAxis(s, axis, origin[axis], dir[axis][lane], reachOf(header, origin),
                       tmax[lane] * longest);
    } else {
        setupOpenAxis(s, axis, dir[axis][lane]);
        open |= uint64_t(1) << lane;
    }
    nearR[axis][lane] = s.nearR[axis];
    nearC[axis][lane] = s.nearC[axis];
    farR[axis][lane] = s.farR[axis];
    farC[axis][lane] = s.farC[axis];
}

// good: lanes with rays.
inline void RayBlock::setupPlanes(const BlockHeader* header, uint32_t first, const WideLanes* speed,
                                  WideLanes longest, Mask good) {
    WideLanes* const w = nullptr;
    const auto constant = [w](float s) { return splat(s, w); };
    const WideLanes zero = constant(0), one = constant(1);
    const WideLanes margin = longest * constant(0x1p-21f), ulps = constant(0x1p-22f);
    const WideLanes still = max(longest * constant(0x1p-18f), constant(0x1p-100f));
    Mask stillLanes[3], openLanes[3];
    for (int i = 0; i < 3; ++i) {
        const WideLanes o = load(org[i] + first, w), d = load(dir[i] + first, w);
        const WideLanes near = withSign(one / (speed[i] + margin), d);
        const WideLanes far = withSign(one / (speed[i] - margin) * constant(1 + 0x1p-21f), d);
        store(nearR[i] + first, near);
        store(farR[i] + first, far);
        WideLanes n = zero, f = zero, largest = speed[i] * constant(kOpenSpeed);
        if constexpr (kFusedSlab) {
            n = negative(o * near);
            f = negative(o * far);
            largest = max(largest, magnitude(f));
            n = n - magnitude(n) * ulps;
            f = f + magnitude(f) * ulps;
        }
        store(nearC[i] + first, n);
        store(farC[i] + first, f);
        stillLanes[i] = lessEqual(speed[i], still) & good;
        openLanes[i] = ~lessEqual(largest, constant(kLargestProduct)) & good;
    }
    alignas(64) float longestOf[kLanes];
    store(longestOf, longest);
    for (int i = 0; i < 3; ++i)
        for (Mask m = stillLanes[i] | openLanes[i]; __builtin_expect(m != 0, 0); m &= m - 1) {
            const uint32_t k = lowestBit(m);
            setupRare(header, i, first + k, longestOf[k], stillLanes[i] >> k & 1);
        }
}

inline void RayBlock::setupLanes(const BlockHeader* header, uint32_t first) {
    WideLanes* const w = nullptr;
    const auto constant = [w](float s) { return splat(s, w); };
    const WideLanes zero = constant(0), one = constant(1);
    WideLanes o[3], d[3], speed[3];
    for (int i = 0; i < 3; ++i) {
        o[i] = load(org[i] + first, w);
        d[i] = load(dir[i] + first, w);
        speed[i] = magnitude(d[i]);
    }
    const WideLanes begin = load(start + first, w), end = load(tmax + first, w);
    const WideLanes longest = max(max(speed[0], speed[1]), speed[2]);
    const WideLanes sum = magnitude(o[0]) + magnitude(o[1]) + magnitude(o[2]) + speed[0] +
                          speed[1] + speed[2] + magnitude(begin);
    const Mask good = lessEqual(sum, constant(0x1.fffffep127f)) & lessEqual(begin, end) &
                      lessEqual(constant(0x1p-120f), longest);
    valid |= uint64_t(good) << first;
    store(tmin + first, max(begin, zero));
    setupPlanes(header, first, speed, longest, good);
    const Mask yLeads = lessEqual(speed[0], speed[1]); // not x > y
    const Mask zBeatsX = lessEqual(speed[0], speed[2]), zBeatsY = lessEqual(speed[1], speed[2]);
    const Mask alongZ = (yLeads & zBeatsY) | (~yLeads & zBeatsX), alongY = yLeads & ~zBeatsY;
    const Mask signs[3] = {signBits(d[0]), signBits(d[1]), signBits(d[2])};
    alignas(64) float across[2][kLanes], along[kLanes];
    for (uint32_t k = 0; k < kLanes; ++k) {
        const uint32_t z = (alongZ >> k & 1) * 2 + (alongY >> k & 1), lane = first + k;
        const uint32_t code = 2 * z + (dir[z][lane] < 0);
        axes[lane] = uint8_t(code);
        across[0][k] = dir[kShearAxes[code].word[0]][lane];
        across[1][k] = dir[kShearAxes[code].word[1]][lane];
        along[k] = dir[z][lane];
        octant[lane] =
            uint8_t((signs[0] >> k & 1) | (signs[1] >> k & 1) << 1 | (signs[2] >> k & 1) << 2);
    }
    const WideLanes a = load(along, w);
    store(shear[0] + first, load(across[0], w) / a);
    store(shear[1] + first, load(across[1], w) / a);
    store(shear[2] + first, one / a);
}

} // namespace sunstone::bvh::SUNSTONE_ISA
