// SPDX-License-Identifier: Apache-2.0
// traceBatch (trace.h) on the CPU, compiled once per instruction set by trace_*.cpp.
//
// Rays that meet only triangles without motion and run no programs on the way, below any number of
// instances, are traversed together: as packets and streams where that is faster
// (trace_packets_body.h), else in flight (bvh/batch/flight_walk.h). The caller traces all other
// rays: their traversal may run programs or raise exceptions, and both belong on the stack of the
// launch index. A ray that reaches such a part of its graph on the way is also left to the caller;
// until then its traversal has no visible effect.
//
// Order matters where a ray ends at its first hit and where instances meet at one distance. Rays in
// flight visit the same nodes as Tracer, in the same order, so every hit is that of trace().
#pragma once

#include "base/threads/worker_object.h"
#include "bvh/batch/flight_walk.h"
#include "devlib/trace_packets_body.h"

namespace sunstone::devlib::SUNSTONE_TRACE_SPACE {

// A top-level structure and ray flags that lead to programs deep in the graph: rays with both are
// left to the caller at once. Forgotten now and then, because structures change.
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

// Moves a hit into the state like Tracer::commit, except the transforms on its path. `record`: the
// innermost instance, or null. Returns the closest-hit program.
static ProgramFn commitHit(RayState& state, const FoundTriangle& found, uint64_t gas,
                           const InstanceRecord* record, uint32_t instanceFlags,
                           uint32_t sbtOffset) {
    Hit& hit = state.hit;
    hit.t = found.t;
    hit.kind = triangleKind(found.det, instanceFlags);
    hit.primitive = found.primitive;
    hit.sbtGasIndex = found.sbt & bvh::kSbtIndexMask;
    hit.instanceIndex = record ? record->index : 0;
    hit.instanceId = record ? record->instanceId : ~0u;
    hit.instanceSbtOffset = sbtOffset;
    hit.gas = gas;
    setBarycentrics<SbtRecords>(hit.attributes, found.v, found.w, found.det);
    state.tmax = found.t;
    const ResolvedRecord r = resolve(
        *state.launch, SbtRecords::hit(state, hit.sbtGasIndex, hit.instanceSbtOffset), kGroupHit);
    noteRecord<SbtRecords>(*state.launch, r, NeededProgram::kHit,
                           SbtRecords::hitIndex(state, hit.sbtGasIndex, hit.instanceSbtOffset));
    hit.record = r.record;
    state.sbtData = dataOf(uint64_t(r.record));
    return r.group ? r.group->program(kRoleMain) : nullptr;
}

// The rays of one batch. kNearest: rays that need their nearest hit, or only whether there is one;
// else rays that end at the first hit they find.
template <bool kNearest>
class RayFlights {
public:
    static constexpr bool kOrdered = kNearest;
    static constexpr uint32_t kLevels = 4;
    // The space of a level of the graph, and the instance above it.
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

    // Walks the rays with these numbers.
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
    using Kind = StructureKind;

    static bool leave(Flight& f) {
        f.data.left = true;
        return true;
    }

    // The kind of the level's handle.
    Kind kindOf(const Flight& f, const Level& level) const {
        const RayState& state = *f.data.state;
        const Kind kind = structureKind(*state.launch, state.rayFlags, level.flags, level.handle);
        const bool enters = kind == Kind::kTriangles || kind == Kind::kInstances;
        return enters && !isa::isRay(level.origin, level.direction, state.tmin, f.tmax)
                   ? Kind::kNothing
                   : kind;
    }

    // Whether the ray has to be walked; else its result is known.
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

    // Moves the hit into the state. Returns its closest-hit program.
    static ProgramFn commit(const Flight& f) {
        const Data& d = f.data;
        RayState& state = *d.state;
        const Level& level = d.hitPath[d.hitLevel];
        state.hit.transformCount = d.hitLevel;
        for (uint32_t i = 0; i < d.hitLevel; ++i)
            state.hit.transforms[i] = makeHandle(d.hitPath[i + 1].record, kTagInstance);
        return commitHit(state, {true, f.tmax, d.v, d.w, d.det, d.primitive, d.sbt}, level.handle,
                         level.record, level.flags, level.sbtOffset);
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
    uint8_t nearest[kMostRays], first[kMostRays];
    uint32_t numNearest = 0, numFirst = 0;
};

// Fewer rays are faster alone.
constexpr uint32_t kLeastFlights = 4;

template <bool kNearest>
static void traceFlights(Reluctance& reluctance, RayState* const* states, ProgramFn* next,
                         ProgramFn whole, const uint8_t* rays, uint32_t count) {
    if (count < kLeastFlights) {
        for (uint32_t i = 0; i < count; ++i)
            next[rays[i]] = whole;
        return;
    }
    auto& walk = workerObject<typename RayFlights<kNearest>::Walk>();
    RayFlights<kNearest>(walk, reluctance, states, next, whole).trace(rays, count);
}

// The program to run for a ray that packets have traversed.
static ProgramFn afterPackets(RayState& state, const FoundTriangle& hit) {
    if (!hit.found)
        return startMiss<SbtRecords>(&state);
    if (state.rayFlags & kRayDisableClosestHit)
        return nullptr;
    const InstanceRecord* const record = hit.record;
    state.hit.transformCount = record ? 1 : 0;
    if (!record)
        return commitHit(state, hit, state.handle, nullptr, 0, 0);
    state.hit.transforms[0] = makeHandle(record, kTagInstance);
    return commitHit(state, hit, record->child, record, record->flags, record->sbtOffset);
}

// Traverses the rays with these numbers, which differ only in origins, directions, ranges and
// visibility masks. Returns the new length of `numbers`: rays left for flights.
template <bool kAny, bool kInstances>
static uint32_t tracePackets(Reluctance& reluctance, RayState* const* states, ProgramFn* next,
                             ProgramFn whole, uint8_t* numbers, uint32_t count) {
    auto& packets = workerObject<RayPackets<kAny>>();
    for (uint32_t i = 0; i < count; ++i)
        packets.set(i, *states[numbers[i]]);
    const RayState& like = *states[numbers[0]];
    const std::span<const uint16_t> others =
        kInstances ? packets.traceInstances(like, count) : packets.traceTriangles(like, count);
    uint32_t left = 0;
    for (uint32_t i = 0; i < count; ++i) {
        const uint8_t number = numbers[i];
        if (left < others.size() && others[left] == i) {
            numbers[left++] = number;
        } else if (packets.hits[i].isAlone) {
            next[number] = whole;
            if (packets.hits[i].meetsOther)
                reluctance.note(*states[number]);
        } else {
            next[number] = afterPackets(*states[number], packets.hits[i]);
        }
    }
    return left;
}

// Whether a traversal of instances may run programs. Packets do not take such rays, because their
// order of visits would run other programs.
static bool hasTraversalPrograms(const LaunchState& launch) {
    constexpr uint32_t kMostGroups = 64; // bounds the cost of this test for each batch
    if (launch.hasAnyHit || launch.groupCount > kMostGroups)
        return true;
    for (uint32_t i = 0; i < launch.groupCount; ++i)
        if (launch.groups[i].kind == kGroupHit && launch.groups[i].code[kRoleIntersection])
            return true;
    return false;
}

// Traces rays with one launch, set of flags and structure as packets if the structure allows it.
// Returns the new length of `numbers`: rays left for flights.
template <bool kInstancing>
static uint32_t traceAlike(Reluctance& reluctance, RayState* const* states, ProgramFn* next,
                           ProgramFn whole, uint8_t* numbers, uint32_t count) {
    const RayState& like = *states[numbers[0]];
    const StructureKind kind = structureKind(*like.launch, like.rayFlags, 0, like.handle);
    const auto trace = [&](auto any, auto nearest) {
        return (like.rayFlags & kRayTerminateOnFirstHit ? any : nearest)(reluctance, states, next,
                                                                         whole, numbers, count);
    };
    if (kind == StructureKind::kTriangles)
        return trace(tracePackets<true, false>, tracePackets<false, false>);
    if constexpr (kInstancing)
        if (kind == StructureKind::kInstances && like.launch->maxGraphDepth >= 2 &&
            !hasTraversalPrograms(*like.launch))
            return trace(tracePackets<true, true>, tracePackets<false, true>);
    return count;
}

// Traces rays that need their nearest hit, or only whether there is one, grouped by what they
// share. Returns the number of rays left for flights.
template <bool kInstancing>
static uint32_t traceNearest(Reluctance& reluctance, RayState* const* states, ProgramFn* next,
                             ProgramFn whole, uint8_t* numbers, uint32_t count) {
    constexpr uint32_t kLeastAlike = 8, kMostKinds = 4;
    uint8_t alike[kMostRays], left[kMostRays];
    uint32_t numLeft = 0;
    for (uint32_t kinds = 0; count >= kLeastAlike && kinds < kMostKinds; ++kinds) {
        const RayState& like = *states[numbers[0]];
        uint32_t numAlike = 0, numOthers = 0;
        for (uint32_t i = 0; i < count; ++i) {
            const RayState& state = *states[numbers[i]];
            if (state.handle == like.handle && state.rayFlags == like.rayFlags &&
                state.launch == like.launch)
                alike[numAlike++] = numbers[i];
            else
                numbers[numOthers++] = numbers[i];
        }
        if (numAlike >= kLeastAlike)
            numAlike = traceAlike<kInstancing>(reluctance, states, next, whole, alike, numAlike);
        std::copy_n(alike, numAlike, left + numLeft);
        numLeft += numAlike;
        count = numOthers;
    }
    std::copy_n(left, numLeft, numbers + count);
    return count + numLeft;
}

template <bool kInstancing>
static void traceBatch(RayState* const* states, ProgramFn* next, uint32_t count) {
    constexpr ProgramFn whole = traceWhole<SbtRecords, kInstancing>;
    Reluctance& reluctance = workerObject<Reluctance>();
    for (uint32_t first = 0; first < count; first += kMostRays) {
        const uint32_t end = std::min(count - first, kMostRays);
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
        order.numNearest = traceNearest<kInstancing>(reluctance, states + first, next + first,
                                                     whole, order.nearest, order.numNearest);
        traceFlights<true>(reluctance, states + first, next + first, whole, order.nearest,
                           order.numNearest);
        traceFlights<false>(reluctance, states + first, next + first, whole, order.first,
                            order.numFirst);
    }
}

} // namespace sunstone::devlib::SUNSTONE_TRACE_SPACE
