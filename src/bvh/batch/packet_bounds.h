// SPDX-License-Identifier: Apache-2.0
// Bounds, for all rays of a packet, of the distances at which any of them may meet a box. Included
// by files that are compiled once per instruction set (see bvh/simd.h).
//
// The near plane p of an axis is at (p - origin) / direction. Over all rays of one octant this is
// at least the least product of p - origin and reciprocal direction at the ends of their intervals.
// The slack covers the margins and the rounding of slab(), each below 2^-20 of its term. Therefore
// every child that a ray meets by testNode() passes this test.
#pragma once

#include "bvh/batch/ray_block.h"

namespace sunstone::bvh::SUNSTONE_ISA {

class PacketBounds {
public:
    // Rays of one octant, at least one.
    void set(const RayBlock& block, uint64_t rays) {
        F8* const f = nullptr;
        const Range start = rangeOf(block.tmin, rays);
        farthest = rangeOf(block.tmax, rays).high;
        tmin_ = splat(start.low, f);
        const uint32_t first = uint32_t(__builtin_ctzll(rays));
        const bool isOpen = block.open & rays;
        for (int i = 0; i < 3; ++i) {
            octant[i] = (uint32_t(2 * i) + (block.octant[first] >> i & 1)) * kPlanesSize;
            setAxis(axes_[i], rangeOf(block.nearR[i], rays), rangeOf(block.farR[i], rays),
                    rangeOf(block.org[i], rays), isOpen);
        }
    }

    // Returns the children that some ray may meet, and lower bounds of their distances.
    SUNSTONE_INLINE_MEMBER Mask test(const uint8_t* node, F8& distance) const {
        F8* const f = nullptr;
        F8 begin = tmin_, end = splat(farthest, f);
        for (int i = 0; i < 3; ++i) {
            const Axis& a = axes_[i];
            const auto* const lower = reinterpret_cast<const float*>(node + octant[i]);
            const auto* const upper =
                reinterpret_cast<const float*>(node + (octant[i] ^ kPlanesSize));
            const F8 near = load(lower, f) - a.nearOrg, far = load(upper, f) - a.farOrg;
            // NaN, from infinite planes and slack, selects the second operand.
            begin = max(min(near * a.nearLow, near * a.nearHigh) - a.nearSlack, begin);
            end = min(max(far * a.farLow, far * a.farHigh) + a.farSlack, end);
        }
        distance = begin;
        return lessEqual(begin, end);
    }

    uint32_t octant[3]; // nearPlanes of RaySetup
    float farthest;     // the largest tmax

private:
    struct Range {
        float low, high;
        float reach() const { return larger(absolute(low), absolute(high)); }
    };
    struct Axis {
        F8 nearOrg, farOrg, nearLow, nearHigh, farLow, farHigh, nearSlack, farSlack;
    };

    static Range rangeOf(const float* values, uint64_t rays) {
        Range range;
        if (rays == ~uint64_t(0)) {
            WideLanes* const w = nullptr;
            WideLanes low = load(values, w), high = low;
            for (uint32_t lane = WideLanes::kLanes; lane < RayBlock::kRays;
                 lane += WideLanes::kLanes) {
                low = min(low, load(values + lane, w));
                high = max(high, load(values + lane, w));
            }
            alignas(64) float lows[WideLanes::kLanes], highs[WideLanes::kLanes];
            store(lows, low);
            store(highs, high);
            range = {lows[0], highs[0]};
            for (uint32_t k = 1; k < WideLanes::kLanes; ++k) {
                range.low = smaller(range.low, lows[k]);
                range.high = larger(range.high, highs[k]);
            }
            return range;
        }
        range.low = range.high = values[__builtin_ctzll(rays)];
        for (uint64_t set = rays & (rays - 1); set; set &= set - 1) {
            const float value = values[__builtin_ctzll(set)];
            range.low = smaller(range.low, value);
            range.high = larger(range.high, value);
        }
        return range;
    }

    static void setAxis(Axis& a, Range near, Range far, Range org, bool isOpen) {
        F8* const f = nullptr;
        const bool forwards = near.low >= 0;
        a.nearOrg = splat(forwards ? org.high : org.low, f);
        a.farOrg = splat(forwards ? org.low : org.high, f);
        // An axis is ignored if a ray hardly moves along it, or if the axis is open.
        const bool isIdle = isOpen || larger(near.reach(), far.reach()) > 0x1p60f;
        const auto outward = [f, isIdle](float r, float sign) {
            return splat(isIdle ? 1.0f : r + sign * absolute(r) * 0x1p-20f, f);
        };
        a.nearLow = outward(near.low, -1);
        a.nearHigh = outward(near.high, 1);
        a.farLow = outward(far.low, -1);
        a.farHigh = outward(far.high, 1);
        const float infinity = __builtin_inff();
        a.nearSlack = splat(isIdle ? infinity : org.reach() * near.reach() * 0x1p-20f, f);
        a.farSlack = splat(isIdle ? infinity : org.reach() * far.reach() * 0x1p-20f, f);
    }

    Axis axes_[3];
    F8 tmin_;
};

} // namespace sunstone::bvh::SUNSTONE_ISA
