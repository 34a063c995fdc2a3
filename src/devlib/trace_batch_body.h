// SPDX-License-Identifier: Apache-2.0
// traceBatch (trace.h) on the CPU, compiled once per instruction set by trace_*.cpp.
//
// Rays that meet triangles without motion and without programs to ask, below any number of
// instances, walk together in flight (bvh/batch/flight_walk.h). The others are left to the caller:
// their walk may run programs or raise exceptions, and both belong on the stack of the launch
// index. A ray whose graph turns out to need one of them on the way is left, too; until then its
// walk has changed nothing that anyone sees.
//
// Order matters where a ray ends at its first hit and where instances meet at one distance. The
// walks visit what Tracer visits, in the same order, so every hit is that of trace().
#pragma once

#include "base/thread_object.h"
#include "bvh/batch/flight_walk.h"
#include "devlib/trace_none.h"

namespace sunstone::devlib::SUNSTONE_TRACE_SPACE {

// A top-level structure and ray flags that lead to programs deep in the graph: rays with both are
// left at once. Forgotten now and then, because structures change.
class Reluctance {
public:
    bool holds(const RayState& ray) {
        if (ray.handle != handle_ || ray.rayFlags != flags_ || ray.launch != launch_)
            return false;
        if (++asked_ % 4096 == 0)
            handle_ = 0;
        return true;
    }
    void note(const RayState& ray) {
        handle_ = ray.handle;
        flags_ = ray.rayFlags;
        launch_ = ray.launch;
    }

private:
    uint64_t handle_ = 0;
    const LaunchState* launch_ = nullptr;
    uint32_t flags_ = 0, asked_ = 0;
};

// The rays of one batch. kNearest: rays that look for their nearest hit, or only for whether there
// is one; else rays that end at the first hit they find.
template <bool kNearest>
class RayFlights {
public:
    static constexpr bool kOrdered = kNearest;
    static constexpr uint32_t kLevels = 4;
    // The space that a level of the graph is in, and the instance above it.
    struct Level {
        float origin[3], direction[3];
        uint64_t handle;
        const InstanceRecord* record; // null at the top
        uint32_t sbtOffset, flags;    // of all instances above
    };
    struct Data {
        RayState* state;
        uint32_t index;
        bool left, found;
        bool foundHere; // in the structure that the ray is in
        isa::Culling culling;
        float v, w, det;
        uint32_t primitive, sbt;
        uint32_t hitLevel; // of the path to the hit
        Level levels[kLevels];
        Level hitPath[kLevels];
    };
    static constexpr uint32_t kRays = 32;
    using Walk = isa::FlightWalk<RayFlights, kRays, kLevels>;
    using Flight = typename Walk::Flight;

    RayFlights(Walk& walk, Reluctance& reluctance, RayState* const* states, ProgramFn* next,
               ProgramFn whole)
        : walk_(walk), reluctance_(reluctance), states_(states), next_(next), whole_(whole) {}

    // Answers the rays with these numbers.
    void trace(const uint8_t* rays, uint32_t count) {
        rays_ = rays;
        count_ = count;
        walk_.run(*this);
    }

    bool next(Flight& f) {
        while (at_ < count_) {
            const uint32_t index = rays_[at_++];
            if (start(f, index))
                return true;
        }
        return false;
    }

    SUNSTONE_INLINE_MEMBER bool leaf(Flight& f, bvh::NodeRef ref) {
        Data& d = f.data;
        isa::ClosestTriangle visitor(*f.setup, f.tmax, d.culling);
        visitor.found = d.foundHere;
        visitor.primitive = d.primitive;
        visitor.det = 0; // as no hit has
        visitor.leaf(f.block, ref);
        if (visitor.det == 0)
            return false;
        f.tmax = visitor.tmax;
        d.found = d.foundHere = true;
        d.v = visitor.v;
        d.w = visitor.w;
        d.det = visitor.det;
        d.primitive = visitor.primitive;
        d.sbt = visitor.sbt;
        d.hitLevel = f.level;
        for (uint32_t i = 0; i <= f.level; ++i)
            d.hitPath[i] = d.levels[i];
        return d.state->rayFlags & kRayTerminateOnFirstHit;
    }

    bool instance(Flight& f, bvh::NodeRef ref) {
        const auto& record = *reinterpret_cast<const InstanceRecord*>(f.block + bvh::offsetOf(ref));
        const RayState& state = *f.data.state;
        if ((record.visibilityMask & state.visibilityMask & 0xFF) == 0) {
            walk_.skip(f);
            return false;
        }
        const LaunchState& launch = *state.launch;
        const bool isNested = f.level != 0;
        if ((isNested && (launch.traversableGraphFlags & kAllowSingleLevelInstancing)) ||
            f.level + 2 > launch.maxGraphDepth || !walk_.canEnter(f))
            return leave(f);
        const Level& above = f.data.levels[f.level];
        Level& below = f.data.levels[f.level + 1];
        transformRay(record.worldToObject, above.origin, above.direction, below.origin,
                     below.direction);
        below.handle = record.child;
        below.record = &record;
        below.sbtOffset = above.sbtOffset + record.sbtOffset;
        below.flags = record.flags;
        switch (kindOf(f, below)) {
        case Kind::kNothing:
            walk_.skip(f);
            return false;
        case Kind::kTriangles:
            f.data.foundHere = false;
            f.data.culling = cullingOf(state.rayFlags, record.flags);
            walk_.enter(f, blockOf(record.child), Walk::kTriangleLists, below.origin,
                        below.direction, state.tmin);
            return false;
        case Kind::kInstances:
            for (uint32_t i = 0; i <= f.level; ++i)
                if (f.data.levels[i].handle == record.child)
                    return leave(f); // a cycle
            walk_.enter(f, blockOf(record.child), Walk::kInstanceLists, below.origin,
                        below.direction, state.tmin);
            return false;
        default:
            return leave(f);
        }
    }

    void end(Flight& f) {
        const Data& d = f.data;
        RayState* const state = d.state;
        if (d.left) {
            next_[d.index] = whole_;
            reluctance_.note(*state);
        } else if (!d.found) {
            next_[d.index] = startMiss<SbtRecords>(state);
        } else if (state->rayFlags & kRayDisableClosestHit) {
            next_[d.index] = nullptr;
        } else {
            next_[d.index] = commit(f);
        }
    }

private:
    enum class Kind { kNothing, kTriangles, kInstances, kOther };

    static bool leave(Flight& f) {
        f.data.left = true;
        return true;
    }

    // What the level's handle leads to.
    Kind kindOf(const Flight& f, const Level& level) const {
        const RayState& state = *f.data.state;
        const uint64_t tag = tagOf(level.handle);
        if (tag != kTagGas && tag != kTagIas)
            return Kind::kOther;
        const bvh::BlockHeader* const block = blockOf(level.handle);
        if (!block || !isa::isRay(level.origin, level.direction, state.tmin, f.tmax))
            return Kind::kNothing;
        const LaunchState& launch = *state.launch;
        if (tag == kTagIas) {
            if (block->type != bvh::BlockType::kInstances)
                return Kind::kOther;
            return block->root == bvh::kNoNode ? Kind::kNothing : Kind::kInstances;
        }
        const bool micromapsCount =
            launch.opacityMicromaps && !(level.flags & kInstanceDisableMicromaps);
        if (block->type != bvh::BlockType::kTriangles &&
            (micromapsCount || block->type != bvh::withMicromaps(bvh::BlockType::kTriangles)))
            return Kind::kOther;
        if (programsMayRun(launch, state.rayFlags, level.flags, block->geometryFlagsAnd))
            return Kind::kOther;
        return block->root == bvh::kNoNode ? Kind::kNothing : Kind::kTriangles;
    }

    // Whether the ray has to be walked; else its outcome is known.
    bool start(Flight& f, uint32_t index) {
        RayState* const state = states_[index];
        Data& d = f.data;
        d.state = state;
        d.index = index;
        d.left = d.found = d.foundHere = false;
        d.culling = cullingOf(state->rayFlags, 0);
        d.primitive = ~0u;
        f.tmax = state->tmax;
        Level& top = d.levels[0];
        for (int i = 0; i < 3; ++i) {
            top.origin[i] = state->worldOrigin[i];
            top.direction[i] = state->worldDirection[i];
        }
        top.handle = state->handle;
        top.record = nullptr;
        top.sbtOffset = top.flags = 0;
        switch (kindOf(f, top)) {
        case Kind::kNothing:
            next_[index] = startMiss<SbtRecords>(state);
            return false;
        case Kind::kOther:
            next_[index] = whole_;
            return false;
        case Kind::kTriangles:
            walk_.begin(f, blockOf(top.handle), Walk::kTriangleLists, top.origin, top.direction,
                        state->tmin, state->tmax);
            return true;
        default:
            walk_.begin(f, blockOf(top.handle), Walk::kInstanceLists, top.origin, top.direction,
                        state->tmin, state->tmax);
            return true;
        }
    }

    // Moves the hit into the state, as Tracer::commit does. Returns its closest-hit program.
    static ProgramFn commit(const Flight& f) {
        const Data& d = f.data;
        RayState& state = *d.state;
        const Level& level = d.hitPath[d.hitLevel];
        Hit& hit = state.hit;
        hit.t = f.tmax;
        hit.kind = triangleKind(d.det, level.flags);
        hit.primitive = d.primitive;
        hit.sbtGasIndex = d.sbt & bvh::kSbtIndexMask;
        hit.instanceIndex = level.record ? level.record->index : 0;
        hit.instanceId = level.record ? level.record->instanceId : ~0u;
        hit.instanceSbtOffset = level.sbtOffset;
        hit.gas = level.handle;
        setBarycentrics<SbtRecords>(hit.attributes, d.v, d.w, d.det);
        hit.transformCount = d.hitLevel;
        for (uint32_t i = 0; i < d.hitLevel; ++i)
            hit.transforms[i] = makeHandle(d.hitPath[i + 1].record, kTagInstance);
        state.tmax = f.tmax;
        const ResolvedRecord r =
            resolve(*state.launch, SbtRecords::hit(state, hit.sbtGasIndex, hit.instanceSbtOffset),
                    kGroupHit);
        hit.record = r.record;
        state.sbtData = dataOf(uint64_t(r.record));
        return r.group ? r.group->program(kRoleMain) : nullptr;
    }

    Walk& walk_;
    Reluctance& reluctance_;
    RayState* const* const states_;
    ProgramFn* const next_;
    const ProgramFn whole_;
    const uint8_t* rays_ = nullptr;
    uint32_t count_ = 0, at_ = 0;
};

// Rays of one call, sorted by the way they walk.
struct BatchOrder {
    static constexpr uint32_t kMost = 128;
    uint8_t nearest[kMost], first[kMost];
    uint32_t numNearest = 0, numFirst = 0;
};

// A few rays walk faster alone.
constexpr uint32_t kLeastFlights = 4;

template <bool kNearest>
static void traceFlights(Reluctance& reluctance, RayState* const* states, ProgramFn* next,
                         ProgramFn whole, const uint8_t* rays, uint32_t count) {
    if (count < kLeastFlights) {
        for (uint32_t i = 0; i < count; ++i)
            next[rays[i]] = whole;
        return;
    }
    auto& walk = threadObject<typename RayFlights<kNearest>::Walk>();
    RayFlights<kNearest>(walk, reluctance, states, next, whole).trace(rays, count);
}

template <bool kInstancing>
static void traceBatch(RayState* const* states, ProgramFn* next, uint32_t count) {
    constexpr ProgramFn whole = traceWhole<SbtRecords, kInstancing>;
    Reluctance& reluctance = threadObject<Reluctance>();
    for (uint32_t first = 0; first < count; first += BatchOrder::kMost) {
        const uint32_t end = std::min(count - first, BatchOrder::kMost);
        BatchOrder order;
        for (uint32_t i = 0; i < end; ++i) {
            RayState* const state = states[first + i];
            const bool isPlain =
                reinterpret_cast<uint64_t>(state) >= state->thread->stackLimit &&
                state->depth <= state->launch->maxTraceDepth && isKnown(state, state->handle) &&
                (kInstancing || tagOf(state->handle) == kTagGas) && !reluctance.holds(*state);
            if (!isPlain)
                next[first + i] = whole;
            else if ((state->rayFlags & (kRayTerminateOnFirstHit | kRayDisableClosestHit)) ==
                     kRayTerminateOnFirstHit)
                order.first[order.numFirst++] = uint8_t(i);
            else
                order.nearest[order.numNearest++] = uint8_t(i);
        }
        traceFlights<true>(reluctance, states + first, next + first, whole, order.nearest,
                           order.numNearest);
        traceFlights<false>(reluctance, states + first, next + first, whole, order.first,
                            order.numFirst);
    }
}

} // namespace sunstone::devlib::SUNSTONE_TRACE_SPACE
