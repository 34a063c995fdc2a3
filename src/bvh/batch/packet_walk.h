// SPDX-License-Identifier: Apache-2.0
// Traverses a structure of triangles or of instances with packets of similar rays. Included by
// files that are compiled once per instruction set (see bvh/simd.h).
//
// A packet has rays whose directions are in one octant. A node is loaded once for all rays that
// meet it, and tested in three steps, from coarse to fine:
//   all rays     The eight children against bounds of the packet (packet_bounds.h).
//   16 rays      Each remaining child against the rays in lanes (8 with AVX2, 4 without).
//   a ray        In place of these, where few rays are left in few lanes, the eight children
//                against each ray, as in the walk of one ray.
// A leaf is tested in the same way: a triangle against the rays in lanes, or its triangles against
// a ray. An instance is left to a policy, which takes the rays into the space of the instance and
// on, for example with a PacketWalk of its own. A stack entry is a node and the set of its rays, a
// bit for each. Several packets take turns, a node each, while the next nodes of the others come
// from memory.
//
// Every test of boxes passes what testNode() passes, and triangles are tested with the operations
// of the walk of one ray, so the hits, which do not depend on the order of visits (see
// ClosestJudge), are those of single rays.
#pragma once

#include "bvh/batch/batch_visitors.h"
#include "bvh/batch/child_rays.h"
#include "bvh/batch/packet_bounds.h"

#include <algorithm>
#include <span>
#include <type_traits>

namespace sunstone::bvh::SUNSTONE_ISA {

// One triangle of a leaf, broadcast to all lanes.
struct TriangleAcross {
    const float* vertices;
    uint32_t stride; // of its coordinates: triangles in the leaf
};
template <class F>
SUNSTONE_INLINE F vertexLanes(const TriangleAcross& t, uint32_t vertex, uint32_t axis, F* f) {
    return splat(t.vertices[(3 * vertex + axis) * t.stride], f);
}

// Of structures of triangles. A policy of instances has
//   uint64_t visit(const InstanceRecord&, const BatchRay* rays, Judge* judges, uint64_t set)
// where `set` has the rays that meet the instance's box. It returns those that have ended.
struct NoInstances {};

template <class Judge, bool kMasked, class Instances = NoInstances>
class PacketWalk {
public:
    static constexpr uint32_t kRays = 512;

    void enter(const BlockHeader* header, const uint32_t* masks, Instances* instances = nullptr) {
        header_ = header;
        block_ = reinterpret_cast<const uint8_t*>(header);
        masks_ = masks;
        instances_ = instances;
    }

    // Whether the directions of these rays are similar.
    static bool isNarrow(const BatchRay* rays, uint32_t count) {
        const float* const d = rays[0].direction;
        const float scale = larger(larger(absolute(d[0]), absolute(d[1])), absolute(d[2]));
        for (uint32_t i = 1; i < count; ++i)
            for (int k = 0; k < 3; ++k)
                if (!(absolute(rays[i].direction[k] - d[k]) <= kSpread * scale))
                    return false;
        return count >= kLeastPacket;
    }

    // Traces rays with similar directions, at most kRays. Returns the numbers of the other rays.
    std::span<const uint16_t> trace(const BatchRay* rays, typename Judge::Hit* hits,
                                    uint32_t count) {
        rays_ = rays;
        numBlocks_ = numPackets_ = numOthers_ = 0;
        for (uint32_t first = 0; first < count; first += RayBlock::kRays) {
            const uint32_t end = std::min(count, first + RayBlock::kRays);
            if (isNarrow(rays + first, end - first))
                startBlock(first, end);
            else
                for (uint32_t i = first; i < end; ++i)
                    others_[numOthers_++] = uint16_t(i);
        }
        walkPackets();
        for (uint32_t b = 0; b < numBlocks_; ++b) {
            const Block& block = blocks_[b];
            for (uint32_t lane = 0; lane < block.count; ++lane)
                hits[block.first + lane] =
                    block.rays.valid >> lane & 1 ? block.judges[lane].hit() : Judge().hit();
        }
        return {others_, numOthers_};
    }

    // Continues rays that have traversed other structures before, at most RayBlock::kRays. Returns
    // the rays that have ended.
    uint64_t goOn(const BatchRay* rays, Judge* judges, uint32_t count) {
        rays_ = rays;
        numBlocks_ = numPackets_ = 0;
        startBlock(0, count, judges);
        walkPackets();
        const Block& block = blocks_[0];
        std::copy_n(block.judges, count, judges);
        return block.rays.valid & ~block.alive;
    }

private:
    static constexpr uint32_t kBlocks = kRays / RayBlock::kRays;
    static constexpr uint32_t kPackets = 8;
    static constexpr uint32_t kLeastPacket = 8;
    // The number of tests of one box against a group of lanes that take as long as one test of all
    // eight boxes against a ray.
    static constexpr uint32_t kTests = 2;
    // The largest difference of a packet's directions along an axis, relative to the longest
    // component.
    static constexpr float kSpread = 0.3f;

    struct Block {
        RayBlock rays;
        uint64_t alive;        // rays that have not ended
        uint32_t first, count; // range of the rays of trace()
        Judge judges[RayBlock::kRays];
        uint32_t masks[RayBlock::kRays];
    };

    struct Entry {
        uint64_t item; // distance and node, as in traverse.h
        uint64_t rays;
    };

    struct Packet {
        Block* block;
        Entry* top;
        PacketBounds bounds;
        bool sameAxes; // all rays have the same shear axes
        Entry stack[kStackSize];
    };

    static uint32_t lowest(uint64_t set) { return uint32_t(__builtin_ctzll(set)); }

    // Makes packets of these rays. `judges`: their judges, or null for rays that start.
    void startBlock(uint32_t first, uint32_t end, const Judge* judges = nullptr) {
        Block& block = blocks_[numBlocks_++];
        const uint32_t count = end - first;
        block.first = first;
        block.count = count;
        for (uint32_t i = 0; i < count; ++i) {
            const BatchRay& ray = rays_[first + i];
            block.rays.set(i, ray);
            block.judges[i] = judges ? judges[i] : Judge(ray);
            block.masks[i] = ray.mask;
        }
        block.rays.setup(header_, count);
        block.alive = block.rays.valid;
        for (uint64_t left = block.rays.valid; left != 0;) {
            const uint64_t packet = left & sameOctant(block.rays, lowest(left), count);
            left &= ~packet;
            addPacket(block, packet);
        }
    }

    static uint64_t sameOctant(const RayBlock& rays, uint32_t lane, uint32_t count) {
        uint64_t same = 0;
        for (uint32_t i = 0; i < count; ++i)
            same |= uint64_t(rays.octant[i] == rays.octant[lane]) << i;
        return same;
    }

    void addPacket(Block& block, uint64_t rays) {
        if (numPackets_ == kPackets)
            walkPackets();
        Packet& packet = packets_[numPackets_++];
        packet.block = &block;
        packet.bounds.set(block.rays, rays);
        const uint8_t axes = block.rays.axes[lowest(rays)];
        packet.sameAxes = true;
        for (uint64_t set = rays; set; set &= set - 1)
            packet.sameAxes &= block.rays.axes[lowest(set)] == axes;
        packet.stack[0] = {header_->root, rays};
        packet.top = packet.stack + 1;
    }

    // Packets take turns until all have ended.
    void walkPackets() {
        Packet* active[kPackets];
        uint32_t count = 0;
        for (uint32_t i = 0; i < numPackets_; ++i)
            active[count++] = &packets_[i];
        while (count != 0)
            for (uint32_t i = 0; i < count;) {
                if (step(*active[i]))
                    ++i;
                else
                    active[i] = active[--count];
            }
        numPackets_ = 0;
    }

    // Visits the packet's next node; false at the end.
    bool step(Packet& packet) {
        Block& block = *packet.block;
        while (packet.top != packet.stack) {
            const Entry entry = *--packet.top;
            const uint64_t rays = entry.rays & block.alive;
            if (rays == 0)
                continue;
            const int count = __builtin_popcountll(rays);
            const NodeRef ref = NodeRef(entry.item);
            if ((ref & kNodeTagMask) == kInner)
                open(packet, block_ + offsetOf(ref), rays, count);
            else if constexpr (std::is_same_v<Instances, NoInstances>)
                visitLeaf(packet, ref, rays, count);
            else
                visitInstance(block, ref, rays);
            if (packet.top != packet.stack)
                prefetchChild(block_, NodeRef(packet.top[-1].item));
            return true;
        }
        return false;
    }

    void visitInstance(Block& block, NodeRef ref, uint64_t rays) {
        const auto& record = *reinterpret_cast<const InstanceRecord*>(block_ + offsetOf(ref));
        block.alive &= ~instances_->visit(record, rays_ + block.first, block.judges, rays);
        for (uint64_t set = rays; set; set &= set - 1)
            block.rays.tmax[lowest(set)] = block.judges[lowest(set)].tmax;
    }

    void visitLeaf(Packet& packet, NodeRef ref, uint64_t rays, int count) {
        const void* const address = block_ + offsetOf(ref);
        if ((ref & kNodeTagMask) == kLeaf)
            visitTriangles(packet, *static_cast<const TriangleLeaf<4>*>(address), rays, count);
        else
            visitTriangles(packet, *static_cast<const TriangleLeaf<8>*>(address), rays, count);
    }

    template <unsigned N>
    SUNSTONE_INLINE_MEMBER void visitTriangles(Packet& packet, const TriangleLeaf<N>& leaf,
                                               uint64_t rays, int count) {
        if (packet.sameAxes && uint32_t(count) > kLeafCost * groupsOf(rays) * leaf.count)
            visitAcross(packet, leaf, rays);
        else
            visitSingle(*packet.block, leaf, rays);
    }

    template <unsigned N>
    void visitSingle(Block& block, const TriangleLeaf<N>& leaf, uint64_t rays) {
        using F = std::conditional_t<N == 4, F4, F8>;
        F* const f = nullptr;
        for (uint64_t set = rays; set; set &= set - 1) {
            const uint32_t lane = lowest(set);
            const RayBlock& r = block.rays;
            const uint32_t* const axes = kShearAxes[r.axes[lane]].word;
            const ShearLanes<F> shear = {
                splat(r.org[axes[0]][lane], f), splat(r.org[axes[1]][lane], f),
                splat(r.org[axes[2]][lane], f), splat(r.shear[0][lane], f),
                splat(r.shear[1][lane], f),     splat(r.shear[2][lane], f)};
            TriangleCandidates<N> c;
            for (Mask m = testTriangles<N, F>(leaf, axes, shear, splat(r.start[lane], f),
                                              splat(r.tmax[lane], f), c);
                 m; m &= m - 1) {
                const unsigned i = lowestBit(m);
                if (take(block, lane, leaf.primitive[i], leaf.sbt[i], c.t[i], c.v[i], c.w[i],
                         c.det[i]))
                    break;
            }
        }
    }

    // Passes a candidate to the ray's judge; true if the ray ends.
    SUNSTONE_INLINE_MEMBER bool take(Block& block, uint32_t lane, uint32_t triangle, uint32_t sbt,
                                     float t, float v, float w, float det) {
        if (kMasked && masks_ && !(masks_[triangle] & block.masks[lane]))
            return false;
        Judge& judge = block.judges[lane];
        const bool ends = judge.take(t, v, w, det, triangle, sbt);
        block.rays.tmax[lane] = judge.tmax;
        block.alive &= ~(uint64_t(ends) << lane);
        return ends;
    }

    template <unsigned N>
    void visitAcross(Packet& packet, const TriangleLeaf<N>& leaf, uint64_t rays) {
        constexpr uint32_t kLanes = WideLanes::kLanes;
        WideLanes* const w = nullptr;
        Block& block = *packet.block;
        const RayBlock& r = block.rays;
        const uint32_t* const axes = kShearAxes[r.axes[lowest(rays)]].word;
        for (uint32_t lane = 0; lane < RayBlock::kRays; lane += kLanes) {
            const Mask group = Mask(rays >> lane & kGroup);
            if (group == 0)
                continue;
            const ShearLanes<WideLanes> shear = {
                load(r.org[axes[0]] + lane, w), load(r.org[axes[1]] + lane, w),
                load(r.org[axes[2]] + lane, w), load(r.shear[0] + lane, w),
                load(r.shear[1] + lane, w),     load(r.shear[2] + lane, w)};
            for (uint32_t i = 0; i < leaf.count && (group & block.alive >> lane); ++i) {
                TriangleCandidates<kLanes> c;
                const Mask hits = testTriangles<kLanes, WideLanes>(
                    TriangleAcross{leaf.vertices + i, N}, axes, shear, load(r.start + lane, w),
                    load(r.tmax + lane, w), c);
                for (Mask m = hits & group & Mask(block.alive >> lane); m; m &= m - 1) {
                    const uint32_t k = lowestBit(m);
                    take(block, lane + k, leaf.primitive[i], leaf.sbt[i], c.t[k], c.v[k], c.w[k],
                         c.det[k]);
                }
            }
        }
    }

    // The groups of lanes with a ray of the set.
    static uint32_t groupsOf(uint64_t rays) {
        uint32_t groups = 0;
        for (uint32_t lane = 0; lane < RayBlock::kRays; lane += WideLanes::kLanes)
            groups += (rays >> lane & kGroup) != 0;
        return groups;
    }

    void open(Packet& packet, const uint8_t* node, uint64_t rays, int count) {
        F8 nearest;
        const Mask some = packet.bounds.test(node, nearest);
        if (some == 0)
            return;
        alignas(64) uint64_t sets[8];
        const RayBlock& r = packet.block->rays;
        const uint32_t tests = groupsOf(rays) * uint32_t(__builtin_popcount(some));
        const Mask any = tests > kTests * uint32_t(count)
                             ? testSingle(packet, r, node, rays, sets)
                             : testLanes(packet, r, node, rays, some, sets);
        alignas(32) float distance[8];
        store(distance, nearest);
        const NodeRef* const children = reinterpret_cast<const Node*>(node)->children;
        Entry* const first = packet.top;
        Entry* top = first;
        for (Mask m = any; m; m &= m - 1) {
            const uint32_t child = lowestBit(m);
            const Entry entry = {uint64_t(bitsOf(distance[child])) << 32 | children[child],
                                 sets[child]};
            Entry* place = top++;
            for (; place > first && place[-1].item < entry.item; --place)
                *place = place[-1];
            *place = entry;
            prefetchChild(block_, children[child]);
        }
        packet.top = top;
    }

    SUNSTONE_INLINE_MEMBER static Mask testSingle(const Packet& packet, const RayBlock& r,
                                                  const uint8_t* node, uint64_t rays,
                                                  uint64_t* sets) {
        F8* const f = nullptr;
        ChildRays childRays;
        F8 near[3], far[3];
        for (int i = 0; i < 3; ++i) {
            const uint32_t place = packet.bounds.octant[i];
            near[i] = load(reinterpret_cast<const float*>(node + place), f);
            far[i] = load(reinterpret_cast<const float*>(node + (place ^ kPlanesSize)), f);
        }
        Mask any = 0;
        for (uint64_t set = rays; set; set &= set - 1) {
            const uint32_t k = lowest(set);
            F8 begin[3], end[3];
            for (int i = 0; i < 3; ++i) {
                const F8 org = splat(r.org[i][k], f);
                begin[i] = slab(near[i], org, splat(r.nearR[i][k], f), splat(r.nearC[i][k], f));
                end[i] = slab(far[i], org, splat(r.farR[i][k], f), splat(r.farC[i][k], f));
            }
            const F8 distance = max(max(begin[0], begin[1]), max(begin[2], splat(r.tmin[k], f)));
            const Mask hits =
                lessEqual(distance, min(min(end[0], end[1]), min(end[2], splat(r.tmax[k], f))));
            any |= hits;
            childRays.add(k, hits);
        }
        childRays.finish(sets);
        return any;
    }

    SUNSTONE_INLINE_MEMBER static Mask testLanes(const Packet& packet, const RayBlock& r,
                                                 const uint8_t* node, uint64_t rays, Mask some,
                                                 uint64_t* sets) {
        WideLanes* const w = nullptr;
        for (int child = 0; child < 8; ++child)
            sets[child] = 0;
        for (uint32_t lane = 0; lane < RayBlock::kRays; lane += WideLanes::kLanes) {
            const uint64_t group = rays >> lane & kGroup;
            if (group == 0)
                continue;
            WideLanes nearR[3], nearC[3], farR[3], farC[3], org[3];
            for (int i = 0; i < 3; ++i) {
                nearR[i] = load(r.nearR[i] + lane, w);
                nearC[i] = load(r.nearC[i] + lane, w);
                farR[i] = load(r.farR[i] + lane, w);
                farC[i] = load(r.farC[i] + lane, w);
                org[i] = load(r.org[i] + lane, w);
            }
            const WideLanes tmin = load(r.tmin + lane, w), tmax = load(r.tmax + lane, w);
            for (Mask m = some; m; m &= m - 1) {
                const uint32_t child = lowestBit(m);
                WideLanes begin[3], end[3];
                for (int i = 0; i < 3; ++i) {
                    const uint32_t place = packet.bounds.octant[i];
                    const auto* const near = reinterpret_cast<const float*>(node + place);
                    const auto* const far =
                        reinterpret_cast<const float*>(node + (place ^ kPlanesSize));
                    begin[i] = slab(splat(near[child], w), org[i], nearR[i], nearC[i]);
                    end[i] = slab(splat(far[child], w), org[i], farR[i], farC[i]);
                }
                const WideLanes distance = max(max(begin[0], begin[1]), max(begin[2], tmin));
                const uint64_t hits =
                    lessEqual(distance, min(min(end[0], end[1]), min(end[2], tmax)));
                sets[child] |= (hits & group) << lane;
            }
        }
        Mask any = 0;
        for (Mask m = some; m; m &= m - 1)
            any |= Mask(sets[lowestBit(m)] != 0) << lowestBit(m);
        return any;
    }

    static constexpr uint64_t kGroup = (uint64_t(1) << WideLanes::kLanes) - 1;
    // The number of rays whose tests of a leaf take as long as one test of a triangle against a
    // group of lanes.
    static constexpr uint32_t kLeafCost = 1;

    const BlockHeader* header_ = nullptr;
    const uint8_t* block_ = nullptr;
    const uint32_t* masks_ = nullptr;
    Instances* instances_ = nullptr;
    const BatchRay* rays_ = nullptr;
    uint32_t numBlocks_ = 0, numPackets_ = 0, numOthers_ = 0;
    uint16_t others_[kRays];
    Packet packets_[kPackets];
    Block blocks_[kBlocks];
};

} // namespace sunstone::bvh::SUNSTONE_ISA
