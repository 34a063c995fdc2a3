// SPDX-License-Identifier: Apache-2.0
// The rays of a batch in flight (flight_walk.h): triangles, or one level of instances.
#pragma once

#include "bvh/batch/batch_visitors.h"
#include "bvh/batch/flight_walk.h"

#include <span>

namespace sunstone::bvh::SUNSTONE_ISA {

template <class Judge, bool kMasked>
class BatchFlights {
public:
    // Nearest first also for any hit, because rays then meet a triangle sooner.
    static constexpr bool kOrdered = true;
    struct Data {
        Judge judge;
        uint32_t index; // of the ray and its hit
        uint32_t mask;
        const uint32_t* masks; // of the structure's triangles; null: none
    };
    using Walk = FlightWalk<BatchFlights, 32, 2>;
    using Flight = typename Walk::Flight;

    BatchFlights(Walk& walk, const BatchScene& scene) : walk_(walk), scene_(scene) {}

    // Traces the rays with these numbers.
    void trace(const BatchRay* rays, BatchHit* hits, std::span<const uint16_t> numbers) {
        rays_ = rays;
        hits_ = hits;
        numbers_ = numbers;
        at_ = 0;
        walk_.run(*this);
    }

    bool next(Flight& f) {
        while (at_ < numbers_.size()) {
            const uint32_t index = numbers_[at_++];
            const BatchRay& ray = rays_[index];
            if (!isRay(ray.origin, ray.direction, ray.tmin, ray.tmax)) {
                hits_[index] = kNoBatchHit;
                continue;
            }
            f.data.judge = Judge(ray);
            f.data.index = index;
            f.data.mask = ray.mask;
            f.data.masks = kMasked && !scene_.instances ? scene_.masksOf(0) : nullptr;
            walk_.begin(f, scene_.header,
                        scene_.instances ? Walk::kInstanceLists : Walk::kTriangleLists, ray.origin,
                        ray.direction, ray.tmin, ray.tmax);
            return true;
        }
        return false;
    }

    SUNSTONE_INLINE_MEMBER bool leaf(Flight& f, NodeRef ref) {
        BatchTriangles<Judge, kMasked> triangles(*f.setup, f.data.judge, f.data.masks, f.data.mask);
        const bool ended = triangles.leaf(f.block, ref);
        f.tmax = f.data.judge.tmax;
        return ended;
    }

    bool instance(Flight& f, NodeRef ref) {
        const auto& record = *reinterpret_cast<const InstanceRecord*>(f.block + offsetOf(ref));
        const BatchRay& ray = rays_[f.data.index];
        float origin[3], direction[3];
        toObject(record, ray, origin, direction);
        const BlockHeader* const header = headerOfHandle(record.child);
        if (header->root == kNoNode || !isRay(origin, direction, ray.tmin, f.tmax)) {
            walk_.skip(f);
            return false;
        }
        f.data.judge.instance = record.index;
        f.data.masks = kMasked ? scene_.masksOf(record.index) : nullptr;
        walk_.enter(f, header, Walk::kTriangleLists, origin, direction, ray.tmin);
        return false;
    }

    void end(Flight& f) { hits_[f.data.index] = f.data.judge.hit(); }

private:
    Walk& walk_;
    const BatchScene& scene_;
    const BatchRay* rays_ = nullptr;
    BatchHit* hits_ = nullptr;
    std::span<const uint16_t> numbers_;
    size_t at_ = 0;
};

} // namespace sunstone::bvh::SUNSTONE_ISA
