// SPDX-License-Identifier: Apache-2.0
// Traverses a structure of triangles with the rays of a piece together. Included by files that are
// compiled once per instruction set (see bvh/simd.h).
//
// The traversal of a single ray waits: each node depends on the test of the node before it, and
// nodes of large structures come from memory. Two phases avoid this.
//   together   A node is loaded once for all rays that meet it: Barringer and Akenine-Moeller,
//              "Dynamic Ray Stream Traversal" (ACM Transactions on Graphics 33, 2014). The tests of
//              rays do not depend on one another, so the processor overlaps them. A stack entry is
//              a node and the set of its rays, a bit for each ray.
//   apart      Where few rays are left together, the node goes to a stack of each. These walks run
//              in turn, a node at a time, while the next nodes of the others come from memory.
// The hits do not depend on the order of visits (see ClosestJudge), so they are those of single
// rays.
#pragma once

#include "bvh/batch/batch_visitors.h"
#include "bvh/batch/child_rays.h"

#include <algorithm>

namespace sunstone::bvh::SUNSTONE_ISA {

// A node's planes in registers, for many rays of one octant. The test equals testNode() of
// traverse.h.
struct OctantPlanes {
    F8 nearPlanes[3], farPlanes[3];

    SUNSTONE_INLINE_MEMBER OctantPlanes(const uint8_t* node, const uint32_t* octant) {
        F8* const f = nullptr;
        for (int i = 0; i < 3; ++i) {
            nearPlanes[i] = load(reinterpret_cast<const float*>(node + octant[i]), f);
            farPlanes[i] =
                load(reinterpret_cast<const float*>(node + (octant[i] ^ kPlanesSize)), f);
        }
    }
    SUNSTONE_INLINE_MEMBER Mask test(const RaySetup& s, float tmax, F8& distance) const {
        F8* const f = nullptr;
        const SlabLanes r(s);
        F8 begin[3], end[3];
        for (int i = 0; i < 3; ++i) {
            begin[i] = slab(nearPlanes[i], r.org[i], r.nearR[i], r.nearC[i]);
            end[i] = slab(farPlanes[i], r.org[i], r.farR[i], r.farC[i]);
        }
        distance = max(max(begin[0], begin[1]), max(begin[2], r.tmin));
        return lessEqual(distance, min(min(end[0], end[1]), min(end[2], splat(tmax, f))));
    }
};

template <class Judge>
struct StreamRay {
    RaySetup setup;
    Judge judge;
    uint32_t mask;
    NodeRef ref;
    uint32_t top; // entries on its own stack
};

template <class Judge, bool kMasked>
class StreamWalk {
public:
    static constexpr uint32_t kRays = 64;

    // masks: of triangles, or null.
    void enter(const BlockHeader* header, const uint32_t* masks) {
        header_ = header;
        block_ = reinterpret_cast<const uint8_t*>(header);
        masks_ = masks;
    }

    // Traces the rays, at most kRays.
    void trace(const BatchRay* rays, typename Judge::Hit* hits, uint32_t count) {
        uint64_t valid = 0;
        for (uint32_t i = 0; i < count; ++i) {
            const BatchRay& from = rays[i];
            StreamRay<Judge>& ray = rays_[i];
            ray.judge = Judge(from);
            ray.mask = from.mask;
            ray.top = 0;
            if (!isRay(from.origin, from.direction, from.tmin, from.tmax))
                continue;
            setupRay(ray.setup, header_, from.origin, from.direction, from.tmin, from.tmax);
            if (valid == 0) {
                octant_ = ray.setup.nearPlanes;
                oneOctant_ = true;
            }
            for (int k = 0; k < 3; ++k)
                oneOctant_ &= ray.setup.nearPlanes[k] == octant_[k];
            valid |= uint64_t(1) << i;
        }
        alive_ = valid;
        walkTogether();
        walkApart();
        for (uint32_t i = 0; i < count; ++i)
            hits[i] = valid >> i & 1 ? rays_[i].judge.hit() : Judge().hit();
    }

private:
    // Sets of at most so many rays traverse singly.
    static constexpr int kFew = Judge::kOrdered ? 2 : 1;
    static constexpr uint32_t kInFlight = 32;
    // Room on a ray's own stack for nodes from the first phase.
    static constexpr uint32_t kGiven = 96;
    static constexpr uint32_t kOwnStack = kGiven + kStackSize;

    struct Entry {
        uint64_t item; // distance and node, as in traverse.h
        uint64_t rays;
    };

    // No prefetch at a push: a node is prefetched when it is the ray's next, while other rays take
    // their turns.
    struct NoPrefetch {
        static void prefetch(const uint8_t*, uint64_t) {}
    };

    static uint32_t lowest(uint64_t set) { return uint32_t(__builtin_ctzll(set)); }

    SUNSTONE_INLINE_MEMBER Mask test(const uint8_t* node, const StreamRay<Judge>& ray,
                                     F8& distance) const {
        return testNode(node, ray.setup.nearPlanes, SlabLanes(ray.setup), ray.judge.tmax, distance);
    }

    // Whether the ray has ended.
    SUNSTONE_INLINE_MEMBER bool visitLeaf(NodeRef ref, StreamRay<Judge>& ray) const {
        BatchTriangles<Judge, kMasked> triangles(ray.setup, ray.judge, masks_, ray.mask);
        return triangles.leaf(block_, ref);
    }

    void walkTogether() {
        Entry* top = stack_;
        *top++ = {header_->root, alive_};
        while (top != stack_) {
            const Entry entry = *--top;
            const uint64_t rays = entry.rays & alive_;
            const NodeRef ref = NodeRef(entry.item);
            if (rays == 0)
                continue;
            if (__builtin_popcountll(rays) <= kFew && give(entry.item, rays))
                continue;
            if ((ref & kNodeTagMask) == kInner) {
                top = openTogether(block_ + offsetOf(ref), rays, top);
                continue;
            }
            for (uint64_t set = rays; set; set &= set - 1) {
                const uint32_t i = lowest(set);
                if (visitLeaf(ref, rays_[i]))
                    alive_ &= ~(uint64_t(1) << i);
            }
        }
    }

    // Puts the node on the stacks of these rays; false if one of them is full.
    bool give(uint64_t item, uint64_t rays) {
        for (uint64_t set = rays; set; set &= set - 1)
            if (rays_[lowest(set)].top >= kGiven)
                return false;
        for (uint64_t set = rays; set; set &= set - 1) {
            const uint32_t i = lowest(set);
            own_[i][rays_[i].top++] = item;
        }
        return true;
    }

    Entry* openTogether(const uint8_t* node, uint64_t rays, Entry* top) {
        ChildRays childRays;
        F8* const f = nullptr;
        F8 nearest = splat(__builtin_inff(), f);
        Mask any = 0;
        const auto testAll = [&](const auto& testRay) {
            for (uint64_t set = rays; set; set &= set - 1) {
                const uint32_t i = lowest(set);
                F8 distance;
                const Mask hits = testRay(rays_[i], distance);
                childRays.add(i, hits);
                any |= hits;
                // Includes the distances of missed children, so the result is a lower bound.
                nearest = min(distance, nearest);
            }
        };
        if (oneOctant_) {
            const OctantPlanes planes(node, octant_);
            testAll([&](const StreamRay<Judge>& ray, F8& distance) {
                return planes.test(ray.setup, ray.judge.tmax, distance);
            });
        } else {
            testAll([&](const StreamRay<Judge>& ray, F8& distance) {
                return test(node, ray, distance);
            });
        }
        if (any == 0)
            return top;
        alignas(64) uint64_t sets[8];
        childRays.finish(sets);
        alignas(32) float distance[8];
        store(distance, nearest);
        const NodeRef* const children = reinterpret_cast<const Node*>(node)->children;
        Entry* const first = top;
        for (Mask m = any; m; m &= m - 1) {
            const uint32_t child = lowestBit(m);
            const NodeRef ref = children[child];
            const Entry entry = {uint64_t(bitsOf(distance[child])) << 32 | ref, sets[child]};
            Entry* place = top++;
            if (Judge::kOrdered)
                for (; place > first && place[-1].item < entry.item; --place)
                    *place = place[-1];
            *place = entry;
            prefetchNode(block_, offsetOf(ref));
        }
        return top;
    }

    // Traverses singly; the nearest of a ray's nodes comes last on its stack.
    void walkApart() {
        uint64_t waiting = 0;
        for (uint64_t set = alive_; set; set &= set - 1) {
            const uint32_t i = lowest(set);
            if (rays_[i].top == 0)
                continue;
            waiting |= uint64_t(1) << i;
            if (Judge::kOrdered) {
                std::reverse(own_[i], own_[i] + rays_[i].top);
                sortEntries(own_[i], rays_[i].top);
            }
        }
        uint8_t flying[kInFlight];
        uint32_t count = 0;
        const auto refill = [&] {
            while (count < kInFlight && waiting) {
                const uint32_t i = lowest(waiting);
                waiting &= waiting - 1;
                if (pop(i))
                    flying[count++] = uint8_t(i);
            }
        };
        for (refill(); count != 0; refill())
            for (uint32_t k = 0; k < count;) {
                if (step(flying[k]))
                    ++k;
                else
                    flying[k] = flying[--count];
            }
    }

    // The ray's next node; false at the end.
    SUNSTONE_INLINE_MEMBER bool pop(uint32_t i) {
        StreamRay<Judge>& ray = rays_[i];
        while (ray.top != 0) {
            const uint64_t entry = own_[i][--ray.top];
            if (!Judge::kOrdered ||
                __builtin_bit_cast(float, uint32_t(entry >> 32)) <= ray.judge.tmax) {
                ray.ref = NodeRef(entry);
                prefetchNode(block_, offsetOf(ray.ref));
                return true;
            }
        }
        return false;
    }

    // Visits the ray's node; false at the end.
    SUNSTONE_INLINE_MEMBER bool step(uint32_t i) {
        StreamRay<Judge>& ray = rays_[i];
        if ((ray.ref & kNodeTagMask) != kInner)
            return !visitLeaf(ray.ref, ray) && pop(i);
        const uint8_t* const node = block_ + offsetOf(ray.ref);
        const NodeRef* const children = reinterpret_cast<const Node*>(node)->children;
        F8 distances;
        const Mask hits = test(node, ray, distances);
        if (hits == 0)
            return pop(i);
        uint64_t* top = own_[i] + ray.top;
        ray.ref =
            pushChildren<Judge::kOrdered>(NoPrefetch(), block_, children, hits, distances, top);
        ray.top = uint32_t(top - own_[i]);
        prefetchNode(block_, offsetOf(ray.ref));
        return true;
    }

    const BlockHeader* header_ = nullptr;
    const uint8_t* block_ = nullptr;
    const uint32_t* masks_ = nullptr;
    uint64_t alive_ = 0;
    bool oneOctant_ = false;           // of all rays
    const uint32_t* octant_ = nullptr; // the first ray's nearPlanes
    alignas(64) StreamRay<Judge> rays_[kRays];
    Entry stack_[kStackSize];
    uint64_t own_[kRays][kOwnStack];
};

} // namespace sunstone::bvh::SUNSTONE_ISA
