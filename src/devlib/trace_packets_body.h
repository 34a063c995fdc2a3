// SPDX-License-Identifier: Apache-2.0
// Rays of several launch indices as packets and streams (bvh/batch), through a structure of
// triangles or of instances of these: part of traceBatch, compiled once per instruction set.
//
// The rays share a launch, flags and a structure, and no program runs on the way. Packets visit
// nodes in another order than single rays. That matters in two cases:
//   - A ray ends at its first hit, and its closest-hit program sees that hit. Such rays do not come
//     here.
//   - Triangles of two instances are at one distance. Such rays are traversed again, alone.
#pragma once

#include "base/threads/worker_object.h"
#include "bvh/batch/packet_walk.h"
#include "bvh/batch/stream_walk.h"
#include "devlib/trace_none.h"

namespace sunstone::devlib::SUNSTONE_TRACE_SPACE {

// A hit that a traversal has found.
struct FoundTriangle {
    bool found = false;
    float t = 0, v = 0, w = 0, det = 1;
    uint32_t primitive = ~0u, sbt = 0;
    const InstanceRecord* record = nullptr; // null without instance
};

// What rays with the same flags can do in a structure without programs.
enum class StructureKind { kNothing, kTriangles, kInstances, kOther };

// The kind of the handle's structure for rays with these flags, below an instance with these.
static StructureKind structureKind(const LaunchState& launch, uint32_t rayFlags,
                                   uint32_t instanceFlags, uint64_t handle) {
    using Kind = StructureKind;
    const uint64_t tag = tagOf(handle);
    if (tag != kTagGas && tag != kTagIas)
        return Kind::kOther;
    const bvh::BlockHeader* const block = blockOf(handle);
    if (!block)
        return Kind::kNothing;
    if (tag == kTagIas) {
        if (block->type != bvh::BlockType::kInstances)
            return Kind::kOther;
        return block->root == bvh::kNoNode ? Kind::kNothing : Kind::kInstances;
    }
    const bool micromapsCount =
        launch.opacityMicromaps && !(instanceFlags & kInstanceDisableMicromaps);
    if (block->type != bvh::BlockType::kTriangles &&
        (micromapsCount || block->type != bvh::withMicromaps(bvh::BlockType::kTriangles)))
        return Kind::kOther;
    if (programsMayRun(launch, rayFlags, instanceFlags, block->geometryFlagsAnd))
        return Kind::kOther;
    return block->root == bvh::kNoNode ? Kind::kNothing : Kind::kTriangles;
}

// Accepts the candidates of bvh/batch like bvh::ClosestTriangle; kAny: like bvh::AnyTriangle.
// BatchRay::mask has the visibility mask and the sides that the ray passes.
template <bool kAny>
struct LaunchJudge {
    static constexpr bool kOrdered = !kAny;
    static constexpr uint32_t kNoFront = 1 << 8, kNoBack = 1 << 9; // above the visibility mask
    struct Hit : FoundTriangle {
        bool isAlone = false;    // the ray must be traversed alone,
        bool meetsOther = false; // because it meets a structure that packets do not enter
    };
    float tmax = 0;
    isa::Culling culling;
    const InstanceRecord* record = nullptr; // of the candidates that come
    Hit best;

    LaunchJudge() = default;
    SUNSTONE_INLINE_MEMBER explicit LaunchJudge(const bvh::BatchRay& ray)
        : tmax(ray.tmax), culling{(ray.mask & kNoFront) != 0, (ray.mask & kNoBack) != 0} {}
    SUNSTONE_INLINE_MEMBER bool take(float t, float v, float w, float det, uint32_t primitive,
                                     uint32_t sbt) {
        if (t > tmax || culling.drops(det, sbt))
            return false;
        if (t == tmax && best.found) {
            if (record != best.record) // the order of visits decides
                best.isAlone = true;
            if (record != best.record || primitive > best.primitive)
                return false;
        }
        best = {{true, t, v, w, det, primitive, sbt, record}, t == tmax && best.isAlone};
        tmax = t;
        return kAny;
    }
    SUNSTONE_INLINE_MEMBER Hit hit() const { return best; }
};

// Takes the rays of packets into instances of structures of triangles. Rays that meet another
// structure end here and must be traversed alone.
template <bool kAny>
class InstancePackets {
public:
    using Judge = LaunchJudge<kAny>;

    void begin(const LaunchState& launch, uint32_t rayFlags) {
        launch_ = &launch;
        rayFlags_ = rayFlags;
    }

    uint64_t visit(const InstanceRecord& record, const bvh::BatchRay* rays, Judge* judges,
                   uint64_t set) {
        uint32_t count = 0;
        for (; set; set &= set - 1) {
            const uint32_t lane = uint32_t(__builtin_ctzll(set));
            if (record.visibilityMask & rays[lane].mask & 0xFF)
                lanes_[count++] = uint8_t(lane);
        }
        if (count == 0)
            return 0;
        switch (structureKind(*launch_, rayFlags_, record.flags, record.child)) {
        case StructureKind::kNothing:
            return 0;
        case StructureKind::kTriangles:
            return enter(record, rays, judges, count);
        default:
            return leave(judges, count);
        }
    }

private:
    // Fewer rays are traversed one by one.
    static constexpr uint32_t kLeastPacket = 4;
    static constexpr uint32_t kMost = isa::RayBlock::kRays;

    uint64_t leave(Judge* judges, uint32_t count) const {
        uint64_t left = 0;
        for (uint32_t i = 0; i < count; ++i) {
            judges[lanes_[i]].best.isAlone = judges[lanes_[i]].best.meetsOther = true;
            left |= uint64_t(1) << lanes_[i];
        }
        return left;
    }

    uint64_t enter(const InstanceRecord& record, const bvh::BatchRay* rays, Judge* judges,
                   uint32_t count) {
        for (uint32_t i = 0; i < count; ++i) {
            const bvh::BatchRay& ray = rays[lanes_[i]];
            const Judge& judge = judges[lanes_[i]];
            transformRay(record.worldToObject, ray.origin, ray.direction, rays_[i].origin,
                         rays_[i].direction);
            rays_[i].tmin = ray.tmin;
            rays_[i].tmax = judge.tmax;
            judges_[i] = judge;
            judges_[i].record = &record;
            judges_[i].culling = cullingOf(rayFlags_, record.flags);
        }
        const bvh::BlockHeader* const block = blockOf(record.child);
        uint64_t ended = 0;
        if (count < kLeastPacket) {
            for (uint32_t i = 0; i < count; ++i)
                ended |= uint64_t(walkAlone(*block, rays_[i], judges_[i])) << i;
        } else {
            packets_.enter(block, nullptr);
            ended = packets_.goOn(rays_, judges_, count);
        }
        uint64_t endedLanes = 0;
        for (uint32_t i = 0; i < count; ++i) {
            judges[lanes_[i]] = judges_[i];
            endedLanes |= (ended >> i & 1) << lanes_[i];
        }
        return endedLanes;
    }

    static bool walkAlone(const bvh::BlockHeader& block, const bvh::BatchRay& ray, Judge& judge) {
        if (!isa::isRay(ray.origin, ray.direction, ray.tmin, ray.tmax))
            return false;
        isa::RaySetup setup;
        isa::setupRay(setup, &block, ray.origin, ray.direction, ray.tmin, ray.tmax);
        isa::BatchTriangles<Judge, false> triangles(setup, judge, nullptr, 0);
        isa::traverse(&block, setup, triangles);
        return kAny && judge.best.found;
    }

    const LaunchState* launch_ = nullptr;
    uint32_t rayFlags_ = 0;
    uint8_t lanes_[kMost];
    bvh::BatchRay rays_[kMost];
    Judge judges_[kMost];
    isa::PacketWalk<Judge, false> packets_;
};

// The most rays of one call.
constexpr uint32_t kMostRays = 128;

template <bool kAny>
struct RayPackets {
    using Judge = LaunchJudge<kAny>;
    using Packets = isa::PacketWalk<Judge, false>;
    using Stream = isa::StreamWalk<Judge, false>;
    using Instances = InstancePackets<kAny>;
    using TopPackets = isa::PacketWalk<Judge, false, Instances>;
    bvh::BatchRay rays[kMostRays];
    typename Judge::Hit hits[kMostRays];

    void set(uint32_t i, const RayState& state) {
        bvh::BatchRay& ray = rays[i];
        for (int k = 0; k < 3; ++k) {
            ray.origin[k] = state.worldOrigin[k];
            ray.direction[k] = state.worldDirection[k];
        }
        ray.tmin = state.tmin;
        ray.tmax = state.tmax;
        const isa::Culling culling = cullingOf(state.rayFlags, 0);
        ray.mask = (state.visibilityMask & 0xFF) | (culling.front ? Judge::kNoFront : 0) |
                   (culling.back ? Judge::kNoBack : 0);
    }

    // Traces the first `count` rays through a structure of instances. Returns the numbers of the
    // rays that are faster in flight.
    std::span<const uint16_t> traceInstances(const RayState& like, uint32_t count) {
        auto& instances = workerObject<Instances>();
        instances.begin(*like.launch, like.rayFlags);
        auto& packets = workerObject<TopPackets>();
        packets.enter(blockOf(like.handle), nullptr, &instances);
        return packets.trace(rays, hits, count);
    }

    // The same for a structure of triangles.
    std::span<const uint16_t> traceTriangles(const RayState& like, uint32_t count) {
        const bvh::BlockHeader* const block = blockOf(like.handle);
        auto& packets = workerObject<Packets>();
        packets.enter(block, nullptr);
        const std::span<const uint16_t> others = packets.trace(rays, hits, count);
        if constexpr (!kAny)
            return others;
        auto& stream = workerObject<Stream>();
        stream.enter(block, nullptr);
        for (size_t i = 0; i < others.size(); i += stream.kRays) // whole blocks of the packets
            stream.trace(rays + others[i], hits + others[i],
                         uint32_t(std::min<size_t>(stream.kRays, others.size() - i)));
        return {};
    }
};

} // namespace sunstone::devlib::SUNSTONE_TRACE_SPACE
