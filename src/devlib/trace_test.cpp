// SPDX-License-Identifier: Apache-2.0
// The trace run-time with programs written in C++: the order and the state in which programs run,
// and the effects of flags, masks, instances and malformed shader binding tables.
#include "devlib/trace.h"

#include "bvh/build/build.h"
#include "bvh/layout.h"
#include "bvh/testing/meshes.h"
#include "devlib/checks.h"
#include "devlib/flags.h"
#include "devlib/launch_notes.h"
#include "devlib/records.h"
#include "devlib/trace_sets.h"
#include "math/affine.h"

#include <gtest/gtest.h>

#include <cstring>
#include <functional>
#include <set>
#include <tuple>

namespace sunstone::devlib {
namespace {

using bvh::testing::makeStructure;
using bvh::testing::Mesh;
using bvh::testing::Random;
using bvh::testing::Structure;
using math::Vec3;

// The programs call these; each test sets what it needs.
struct Programs {
    std::function<uint32_t(RayState*)> closestHit, anyHit, intersection, miss;
} programs;

uint32_t runClosestHit(RayState* s) {
    return programs.closestHit ? programs.closestHit(s) : kAccept;
}
uint32_t runAnyHit(RayState* s) {
    return programs.anyHit ? programs.anyHit(s) : kAccept;
}
uint32_t runIntersection(RayState* s) {
    return programs.intersection ? programs.intersection(s) : kAccept;
}
uint32_t runMiss(RayState* s) {
    return programs.miss ? programs.miss(s) : kAccept;
}
uint32_t addOne(RayState*, uint32_t x) {
    return x + 1;
}

struct Record {
    SbtHeader header;
    uint32_t data[4];
};
static_assert(sizeof(Record) == 48);

class Trace : public ::testing::TestWithParam<bvh::Isa> {
protected:
    static constexpr uint32_t kHitGroup = 1, kMissGroup = 2, kCallableGroup = 3, kEmptyGroup = 4;

    void SetUp() override {
        programs = {};
        GroupEntry& hitGroup = groups_[kHitGroup];
        hitGroup.code[kRoleMain] = reinterpret_cast<const void*>(&runClosestHit);
        hitGroup.code[kRoleAnyHit] = reinterpret_cast<const void*>(&runAnyHit);
        hitGroup.code[kRoleIntersection] = reinterpret_cast<const void*>(&runIntersection);
        groups_[kMissGroup].code[kRoleMain] = reinterpret_cast<const void*>(&runMiss);
        groups_[kCallableGroup].code[kRoleDirect] = reinterpret_cast<const void*>(&addOne);
        for (uint32_t i = 0; i < 32; ++i)
            hit_[i] = {{kSbtMagic, kHitGroup, kGroupHit, {}}, {i, 0, 0, 0}};
        for (uint32_t i = 0; i < 4; ++i)
            miss_[i] = {{kSbtMagic, kMissGroup, kGroupMiss, {}}, {100 + i, 0, 0, 0}};
        callable_[0] = {{kSbtMagic, kCallableGroup, kGroupCallables, {}}, {7, 0, 0, 0}};
        launch_ = {};
        launch_.exceptionFlags = kHasNotes;
        launch_.maxTraceDepth = 5;
        launch_.maxGraphDepth = kMaxGraphDepth;
        launch_.groups = groups_;
        launch_.groupCount = 5;
        launch_.hasAnyHit = 1;
        launch_.sbt.hitBase = uint64_t(hit_);
        launch_.sbt.hitStride = sizeof(Record);
        launch_.sbt.hitCount = 32;
        launch_.sbt.missBase = uint64_t(miss_);
        launch_.sbt.missStride = sizeof(Record);
        launch_.sbt.missCount = 4;
        launch_.sbt.callableBase = uint64_t(callable_);
        launch_.sbt.callableStride = sizeof(Record);
        launch_.sbt.callableCount = 1;
        if (!bvh::isaSupported(GetParam()))
            GTEST_SKIP() << "[SKIP] this processor has no " << bvh::isaName(GetParam());
        bindTrace(launch_, {});
        launch_.trace = set().traceGraph;
        launch_.report = set().report;
    }

    static const TraceSet& set() {
        switch (GetParam()) {
        case bvh::Isa::kAvx512:
            return kTraceAvx512;
        case bvh::Isa::kAvx2:
            return kTraceAvx2;
        default:
            return kTraceBaseline;
        }
    }

    RayState ray(uint64_t handle, Vec3 o, Vec3 d) {
        RayState s;
        std::memset(static_cast<void*>(&s), 0xCD, sizeof s); // as an uninitialised frame
        for (int i = 0; i < 3; ++i) {
            s.worldOrigin[i] = o[i];
            s.worldDirection[i] = d[i];
        }
        s.tmin = 0;
        s.tmax = 1e16f;
        s.time = 0;
        s.rayFlags = 0;
        s.visibilityMask = 255;
        s.sbtOffset = s.sbtStride = s.missIndex = 0;
        s.handle = handle;
        s.launch = &launch_;
        s.thread = &thread_;
        s.depth = 1;
        s.payloadType = 0;
        s.payloadCount = 1;
        s.payload[0] = 0;
        return s;
    }

    // Squares of side 2 in planes z = 0, 1, 2 ... with one SBT record each, seen by rays along -z.
    static Structure squares(uint32_t count, uint32_t flags = 0) {
        Mesh m;
        std::vector<uint32_t> sbt;
        for (uint32_t i = 0; i < count; ++i) {
            const float z = float(i);
            const uint32_t b = 4 * i;
            m.vertices.insert(m.vertices.end(), {{-1, -1, z}, {1, -1, z}, {1, 1, z}, {-1, 1, z}});
            m.triangles.push_back({b, b + 1, b + 2});
            m.triangles.push_back({b, b + 2, b + 3});
            sbt.insert(sbt.end(), {i, i});
        }
        std::vector<uint32_t> allFlags(count, flags);
        bvh::TriangleInput in = m.input();
        in.sbt = {allFlags.data(), count, sbt.data(), 4, 0, 0};
        return makeStructure(in);
    }

    static Structure instances(const std::vector<bvh::InstanceDesc>& list) {
        bvh::InstanceInput in;
        in.instances = list.data();
        in.numInstances = uint32_t(list.size());
        bvh::BuildInputs inputs;
        inputs.instances = &in;
        return bvh::testing::makeStructure(inputs);
    }
    static bvh::InstanceDesc instance(uint64_t handle, uint32_t id, Vec3 at, float scale = 1) {
        return {
            {scale, 0, 0, at.x, 0, scale, 0, at.y, 0, 0, scale, at.z}, id, 0, 255, 0, handle, {}};
    }
    static uint64_t handleOf(const Structure& s) { return bvh::traversableHandle(s.block()); }
    static uint32_t dataWord(const RayState* s) {
        return s->sbtData ? static_cast<const uint32_t*>(s->sbtData)[0] : ~0u;
    }

    GroupEntry groups_[5] = {};
    Record hit_[32], miss_[4], callable_[1];
    NotedLaunch launch_;
    ThreadState thread_{};
};

constexpr Vec3 kEye = {0.25f, 0.5f, 10}, kDown = {0, 0, -1};

TEST_P(Trace, ClosestHitSeesTheHit) {
    const Structure s = squares(3);
    for (uint32_t anyHit : {0u, 1u}) {
        launch_.hasAnyHit = anyHit;
        int calls = 0;
        programs.closestHit = [&](RayState* r) {
            ++calls;
            EXPECT_FLOAT_EQ(r->tmax, 8);
            EXPECT_FLOAT_EQ(r->hit.t, 8);
            EXPECT_EQ(r->hit.kind, uint32_t(kHitTriangleFront));
            EXPECT_EQ(r->hit.sbtGasIndex, 2u);
            EXPECT_EQ(r->hit.primitive, 5u);
            EXPECT_EQ(r->hit.instanceId, ~0u);
            EXPECT_EQ(r->hit.instanceIndex, 0u);
            EXPECT_EQ(r->hit.transformCount, 0u);
            EXPECT_EQ(r->hit.gas, handleOf(s));
            EXPECT_EQ(dataWord(r), 2u * 4 + 3);
            float u, v;
            std::memcpy(&u, &r->hit.attributes[0], 4);
            std::memcpy(&v, &r->hit.attributes[1], 4);
            EXPECT_NEAR(-1 + 2 * u, 0.25f, 1e-6f); // vertices (-1,-1), (1,1), (-1,1)
            EXPECT_NEAR(-1 + 2 * u + 2 * v, 0.5f, 1e-6f);
            r->payload[0] = 42;
            return kAccept;
        };
        RayState r = ray(handleOf(s), kEye, kDown);
        r.sbtStride = 4;
        r.sbtOffset = 3;
        launch_.trace(&r);
        EXPECT_EQ(calls, 1);
        EXPECT_EQ(r.payload[0], 42u);
    }
}

TEST_P(Trace, MissSeesTheWholeRay) {
    const Structure s = squares(3);
    int calls = 0;
    programs.anyHit = [](RayState*) { return kIgnore; };
    programs.miss = [&](RayState* r) {
        ++calls;
        EXPECT_EQ(r->tmax, 1e16f);
        EXPECT_EQ(dataWord(r), 102u);
        return kAccept;
    };
    programs.closestHit = [&](RayState*) {
        ADD_FAILURE();
        return kAccept;
    };
    RayState r = ray(handleOf(s), kEye, kDown);
    r.missIndex = 2;
    launch_.trace(&r); // every hit ignored
    RayState beside = ray(handleOf(s), {5, 5, 10}, kDown);
    beside.missIndex = 2;
    launch_.trace(&beside);
    EXPECT_EQ(calls, 2);
    RayState badIndex = ray(handleOf(s), {5, 5, 10}, kDown);
    badIndex.missIndex = 4;
    launch_.trace(&badIndex);
    badIndex.missIndex = ~0u;
    launch_.trace(&badIndex);
    EXPECT_EQ(calls, 2);
}

TEST_P(Trace, HandlesThatAreNoneMiss) {
    int calls = 0;
    programs.miss = [&](RayState*) {
        ++calls;
        return kAccept;
    };
    alignas(128) static const uint8_t garbage[256] = {1, 2, 3};
    for (uint64_t handle :
         {uint64_t(0), uint64_t(kTagGas), uint64_t(kTagStatic), makeHandle(garbage, kTagGas),
          makeHandle(garbage, kTagIas), makeHandle(garbage, HandleTag(0)),
          makeHandle(garbage, kTagMatrixMotion), makeHandle(garbage, HandleTag(40)), ~uint64_t(0),
          uint64_t(1) << 50 | kTagGas}) {
        RayState r = ray(handle, kEye, kDown);
        launch_.trace(&r);
    }
    EXPECT_EQ(calls, 10);
    const Structure s = squares(1);
    RayState nan = ray(handleOf(s), {NAN, 0, 1}, kDown);
    launch_.trace(&nan);
    EXPECT_EQ(calls, 11);
}

TEST_P(Trace, AnyHitSeesCandidatesAndDecides) {
    const Structure s = squares(8);
    std::multiset<float> seen;
    programs.anyHit = [&](RayState* r) {
        EXPECT_EQ(r->tmax, r->hit.t);
        EXPECT_FLOAT_EQ(r->objectOrigin[2], 10);
        EXPECT_EQ(dataWord(r), r->hit.sbtGasIndex);
        seen.insert(r->hit.t);
        return r->hit.t < 4.5f ? kIgnore : kAccept; // z = 7, 6 are transparent (t = 3, 4)
    };
    float t = 0;
    programs.closestHit = [&](RayState* r) {
        t = r->tmax;
        return kAccept;
    };
    RayState r = ray(handleOf(s), kEye, kDown);
    r.sbtStride = 1;
    launch_.trace(&r);
    EXPECT_FLOAT_EQ(t, 5);
    EXPECT_EQ(seen.count(3), 1u);
    EXPECT_EQ(seen.count(4), 1u);
    EXPECT_EQ(seen.count(5), 1u);
    // Ending the ray keeps the hit it was called for, whichever that is.
    float ended = 0;
    programs.anyHit = [&](RayState* c) {
        ended = c->hit.t;
        return kTerminate;
    };
    launch_.trace(&(r = ray(handleOf(s), kEye, kDown)));
    EXPECT_EQ(t, ended);
}

TEST_P(Trace, RayFlags) {
    const Structure s = squares(4), opaque = squares(4, bvh::kGeometryDisableAnyHit);
    int anyHits = 0, closest = 0, misses = 0;
    programs.anyHit = [&](RayState*) { return ++anyHits, kAccept; };
    programs.closestHit = [&](RayState*) { return ++closest, kAccept; };
    programs.miss = [&](RayState*) { return ++misses, kAccept; };
    const auto run = [&](const Structure& structure, uint32_t flags, Vec3 d = kDown) {
        anyHits = closest = misses = 0;
        RayState r = ray(handleOf(structure), d.z < 0 ? kEye : Vec3{0.25f, 0.5f, -10}, d);
        r.rayFlags = flags;
        launch_.trace(&r);
        return std::array<int, 3>{std::min(anyHits, 1), closest, misses};
    };
    using Counts = std::array<int, 3>;
    EXPECT_EQ(run(s, 0), (Counts{1, 1, 0}));
    EXPECT_EQ(run(opaque, 0), (Counts{0, 1, 0}));
    EXPECT_EQ(run(s, 1), (Counts{0, 1, 0}));      // disable any-hit
    EXPECT_EQ(run(opaque, 2), (Counts{1, 1, 0})); // enforce any-hit
    run(s, 4);
    EXPECT_EQ(anyHits, 1); // first hit only
    EXPECT_EQ(closest, 1);
    EXPECT_EQ(run(s, 4 | 1), (Counts{0, 1, 0}));
    EXPECT_EQ(run(s, 8), (Counts{1, 0, 0})); // disable closest-hit
    EXPECT_EQ(run(s, 8 | 4 | 1), (Counts{0, 0, 0}));
    EXPECT_EQ(run(s, 32), (Counts{0, 0, 1})); // cull front
    EXPECT_EQ(run(s, 16), (Counts{1, 1, 0})); // cull back
    EXPECT_EQ(run(s, 16 | 1, {0, 0, 1}), (Counts{0, 0, 1}));
    EXPECT_EQ(run(s, 32 | 1 | 4 | 8), (Counts{0, 0, 1}));
    EXPECT_EQ(run(s, 128), (Counts{0, 0, 1})); // cull enforced
    EXPECT_EQ(run(opaque, 128), (Counts{0, 1, 0}));
    EXPECT_EQ(run(s, 64), (Counts{1, 1, 0})); // cull disabled
    EXPECT_EQ(run(opaque, 64), (Counts{0, 0, 1}));
    launch_.hasAnyHit = 0;
    EXPECT_EQ(run(opaque, 64), (Counts{0, 0, 1}));
    EXPECT_EQ(run(s, 0), (Counts{0, 1, 0}));
}

TEST_P(Trace, DepthLimitAndRecursion) {
    const Structure s = squares(2);
    uint32_t deepest = 0, misses = 0;
    programs.miss = [&](RayState*) { return ++misses, kAccept; };
    programs.closestHit = [&](RayState* r) {
        deepest = std::max(deepest, r->depth);
        RayState next = ray(handleOf(s), kEye, kDown);
        next.depth = r->depth + 1;
        launch_.trace(&next);
        return kAccept;
    };
    RayState r = ray(handleOf(s), kEye, kDown);
    launch_.trace(&r);
    EXPECT_EQ(deepest, 5u);
    EXPECT_EQ(misses, 0u);
    EXPECT_EQ(launch_.notes.deepTrace, 1u);
    static int32_t thrown;
    thrown = 0;
    launch_.exceptionFlags = kFlagTraceDepth;
    launch_.raise = [](RayState*, int32_t code, const ExceptionInfo*) { thrown = code; };
    launch_.trace(&r);
    EXPECT_EQ(thrown, -2);
}

TEST_P(Trace, BrokenTablesActAsNoProgram) {
    const Structure s = squares(2);
    int calls = 0, misses = 0;
    programs.closestHit = programs.anyHit = [&](RayState*) { return ++calls, kAccept; };
    programs.miss = [&](RayState*) { return ++misses, kAccept; };
    const auto run = [&](uint32_t offset, uint32_t flags = 0) { // returns what is logged
        launch_.notes = {};
        RayState r = ray(handleOf(s), kEye, kDown);
        r.sbtOffset = offset;
        r.rayFlags = flags;
        launch_.trace(&r);
        return launch_.notes.record;
    };
    const auto missing = [](uint64_t index) { return recordNote(NeededProgram::kHit, index); };
    EXPECT_EQ(run(40), missing(40));
    // Nothing is missing where no program would run.
    EXPECT_EQ(run(40, kRayDisableAnyHit | kRayDisableClosestHit), 0u);
    hit_[0].header.group = 77;
    EXPECT_EQ(run(0), missing(0));
    EXPECT_EQ(run(0, kRayDisableAnyHit), missing(0));
    hit_[0].header.group = kMissGroup;
    hit_[0].header.kind = kGroupMiss;
    EXPECT_EQ(run(0), missing(0));
    hit_[0].header.magic = 0;
    EXPECT_EQ(run(0), missing(0));
    hit_[0] = {{kSbtMagic, kEmptyGroup, kGroupHit, {}}, {}};
    EXPECT_EQ(run(0), 0u);
    launch_.sbt.hitBase = 0;
    EXPECT_EQ(run(0), missing(0));
    EXPECT_EQ(calls, 0);
    EXPECT_EQ(misses, 0); // the surface is hit all the same
}

TEST_P(Trace, MissesWithoutRecordsAreNoted) {
    const Structure s = squares(2);
    const auto run = [&](uint32_t index) {
        launch_.notes = {};
        RayState r = ray(handleOf(s), kEye, {0, 0, 1});
        r.missIndex = index;
        launch_.trace(&r);
        return launch_.notes.record;
    };
    EXPECT_EQ(run(3), 0u);
    EXPECT_EQ(run(4), recordNote(NeededProgram::kMiss, 4));
    miss_[1].header.magic = 0;
    EXPECT_EQ(run(1), recordNote(NeededProgram::kMiss, 1));
}

TEST_P(Trace, CustomPrimitives) {
    // Spheres of radius 0.5 at z = 0, 2, 4.
    std::vector<std::array<float, 6>> boxes;
    for (int i = 0; i < 3; ++i)
        boxes.push_back({-0.5f, -0.5f, 2 * float(i) - 0.5f, 0.5f, 0.5f, 2 * float(i) + 0.5f});
    bvh::CustomInput in;
    in.aabbs = boxes.data();
    in.numPrimitives = 3;
    in.sbt.primitiveIndexOffset = 10;
    bvh::BuildInputs inputs;
    inputs.customs = {&in, 1};
    const Structure s = bvh::testing::makeStructure(inputs);
    std::multiset<uint32_t> tested;
    programs.intersection = [&](RayState* r) {
        tested.insert(r->hit.primitive);
        const float center = 2 * float(r->hit.primitive - 10);
        EXPECT_EQ(r->objectDirection[2], -1);
        EXPECT_EQ(launch_.report(r, -1, 3), kIgnore);
        EXPECT_EQ(launch_.report(r, 1e20f, 3), kIgnore);
        EXPECT_EQ(launch_.report(r, NAN, 3), kIgnore);
        for (float side : {-0.5f, 0.5f}) { // the far point first
            r->reportAttributes[0] = r->hit.primitive;
            r->reportAttributes[7] = side > 0;
            const float before = r->tmax;
            const uint32_t result = launch_.report(r, r->objectOrigin[2] - (center + side), 5);
            EXPECT_EQ(r->tmax, result == kIgnore ? before : 10 - (center + side));
            if (result == kTerminate)
                return kTerminate;
        }
        return kAccept;
    };
    int anyHits = 0;
    programs.anyHit = [&](RayState* r) {
        ++anyHits;
        EXPECT_EQ(r->hit.kind, 5u);
        EXPECT_EQ(r->tmax, r->hit.t);
        return r->hit.primitive == 12 ? kIgnore : kAccept;
    };
    int hits = 0;
    programs.closestHit = [&](RayState* r) {
        ++hits;
        EXPECT_FLOAT_EQ(r->tmax, 7.5f);
        EXPECT_EQ(r->hit.kind, 5u);
        EXPECT_EQ(r->hit.primitive, 11u);
        EXPECT_EQ(r->hit.attributes[0], 11u);
        EXPECT_EQ(r->hit.attributes[7], 1u);
        return kAccept;
    };
    RayState r = ray(handleOf(s), {0, 0, 10}, kDown);
    launch_.trace(&r);
    EXPECT_EQ(hits, 1);
    EXPECT_EQ(anyHits, 4);
    EXPECT_EQ(tested.count(12), 1u);
    EXPECT_EQ(tested.count(11), 1u);
    EXPECT_EQ(tested.count(10), 0u); // behind the hit
    // First hit ends: report does not go on.
    anyHits = hits = 0;
    tested.clear();
    programs.closestHit = [&](RayState*) { return ++hits, kAccept; };
    programs.anyHit = [&](RayState*) { return ++anyHits, kAccept; };
    RayState first = ray(handleOf(s), {0, 0, 10}, kDown);
    first.rayFlags = 4;
    launch_.trace(&first);
    EXPECT_EQ(anyHits, 1);
    EXPECT_EQ(hits, 1);
    EXPECT_EQ(tested.size(), 1u);
    // No intersection program: never hit.
    groups_[kHitGroup].code[kRoleIntersection] = nullptr;
    int misses = 0;
    programs.miss = [&](RayState*) { return ++misses, kAccept; };
    launch_.trace(&(r = ray(handleOf(s), {0, 0, 10}, kDown)));
    EXPECT_EQ(misses, 1);
}

TEST_P(Trace, Instances) {
    const Structure s = squares(1);
    std::vector<bvh::InstanceDesc> list = {instance(handleOf(s), 70, {0, 0, 1}),
                                           instance(handleOf(s), 71, {0, 0, 4}, 2),
                                           instance(handleOf(s), 72, {0, 0, 6})};
    list[0].sbtOffset = 10;
    list[1].sbtOffset = 20;
    list[2].visibilityMask = 2;
    const Structure ias = instances(list);
    int hits = 0;
    for (uint32_t hasAnyHit : {0u, 1u}) {
        launch_.hasAnyHit = hasAnyHit;
        programs.anyHit = [&](RayState* r) {
            EXPECT_EQ(r->hit.transformCount, 1u);
            if (r->hit.instanceIndex == 1) {
                EXPECT_FLOAT_EQ(r->objectOrigin[2], 3); // (10 - 4) / 2
                EXPECT_FLOAT_EQ(r->objectDirection[2], -0.5f);
            }
            return kAccept;
        };
        programs.closestHit = [&](RayState* r) {
            ++hits;
            EXPECT_FLOAT_EQ(r->tmax, 6);
            EXPECT_EQ(r->hit.instanceId, 71u);
            EXPECT_EQ(r->hit.instanceIndex, 1u);
            EXPECT_EQ(r->hit.transformCount, 1u);
            EXPECT_EQ(tagOf(r->hit.transforms[0]), kTagInstance);
            const auto* record =
                reinterpret_cast<const InstanceRecord*>(addressOf(r->hit.transforms[0]));
            EXPECT_EQ(record->instanceId, 71u);
            EXPECT_EQ(dataWord(r), 23u);
            EXPECT_EQ(r->hit.gas, handleOf(s));
            return kAccept;
        };
        RayState r = ray(handleOf(ias), kEye, kDown);
        r.visibilityMask = 1;
        r.sbtOffset = 3;
        launch_.trace(&r);
    }
    EXPECT_EQ(hits, 2);
}

TEST_P(Trace, InstanceFlags) {
    const Structure s = squares(1), opaque = squares(1, bvh::kGeometryDisableAnyHit);
    int anyHits = 0;
    uint32_t kind = 0;
    programs.anyHit = [&](RayState*) { return ++anyHits, kAccept; };
    programs.closestHit = [&](RayState* r) { return kind = r->hit.kind, kAccept; };
    const auto run = [&](const Structure& child, uint32_t instanceFlags, uint32_t rayFlags) {
        bvh::InstanceDesc d = instance(handleOf(child), 0, {0, 0, 0});
        d.flags = instanceFlags;
        const Structure ias = instances({d});
        anyHits = 0;
        kind = 0;
        RayState r = ray(handleOf(ias), kEye, kDown);
        r.rayFlags = rayFlags;
        launch_.trace(&r);
        return kind;
    };
    EXPECT_EQ(run(s, 0, 0), uint32_t(kHitTriangleFront));
    EXPECT_EQ(anyHits, 1);
    EXPECT_EQ(run(s, 2, 0), uint32_t(kHitTriangleBack)); // flipped
    EXPECT_EQ(run(s, 2, 16), 0u);
    EXPECT_EQ(run(s, 2, 32), uint32_t(kHitTriangleBack));
    EXPECT_EQ(run(s, 0, 32), 0u);
    EXPECT_EQ(run(s, 1, 32), uint32_t(kHitTriangleFront)); // culling disabled
    run(s, 4, 0);
    EXPECT_EQ(anyHits, 0); // any-hit disabled
    run(opaque, 8, 0);
    EXPECT_EQ(anyHits, 1); // enforced
    run(opaque, 0, 0);
    EXPECT_EQ(anyHits, 0);
    run(opaque, 8, 1);
    EXPECT_EQ(anyHits, 0); // the ray's flag is stronger
    run(s, 4, 2);
    EXPECT_EQ(anyHits, 1);
    EXPECT_EQ(run(s, 4, 64), 0u);
    EXPECT_EQ(run(opaque, 8, 128), 0u);
}

TEST_P(Trace, NestedInstancesAndStaticTransforms) {
    const Structure s = squares(1);
    alignas(64) bvh::StaticTransform shift = {};
    shift.child = handleOf(s);
    for (int i = 0; i < 3; ++i)
        shift.transform[5 * i] = shift.inverse[5 * i] = 1;
    shift.transform[3] = 100;
    shift.inverse[3] = -100;
    bvh::InstanceDesc inner = instance(makeHandle(&shift, kTagStatic), 5, {-50, 0, 0});
    inner.sbtOffset = 1;
    const Structure low = instances({instance(handleOf(s), 4, {0, 0, 0}), inner});
    bvh::InstanceDesc outer = instance(handleOf(low), 6, {0, 0, 3}, 2);
    outer.sbtOffset = 2;
    const Structure high = instances({outer});
    int hits = 0;
    programs.closestHit = [&](RayState* r) {
        ++hits;
        EXPECT_FLOAT_EQ(r->tmax, 7);
        EXPECT_EQ(r->hit.transformCount, 3u);
        EXPECT_EQ(tagOf(r->hit.transforms[0]), kTagInstance);
        EXPECT_EQ(r->hit.transforms[2], makeHandle(&shift, kTagStatic));
        EXPECT_EQ(r->hit.instanceId, 5u);
        EXPECT_EQ(dataWord(r), 3u);
        return kAccept;
    };
    // x = 100: (100 / 2 + 50 - 100) = 0 in the square's space.
    RayState r = ray(handleOf(high), {100.5f, 0.25f, 10}, kDown);
    launch_.trace(&r);
    EXPECT_EQ(hits, 1);
    // A transform as root, and one that leads to itself.
    programs.closestHit = [&](RayState*) { return ++hits, kAccept; };
    RayState rooted = ray(makeHandle(&shift, kTagStatic), {100.5f, 0.25f, 10}, kDown);
    launch_.trace(&rooted);
    EXPECT_EQ(hits, 2);
    int misses = 0;
    programs.miss = [&](RayState*) { return ++misses, kAccept; };
    shift.child = makeHandle(&shift, kTagStatic);
    launch_.trace(&(rooted = ray(makeHandle(&shift, kTagStatic), {100.5f, 0.25f, 10}, kDown)));
    EXPECT_EQ(misses, 1);
}

TEST_P(Trace, ManyRandomInstancesAgreeWithTransformedTriangles) {
    const Mesh mesh = bvh::testing::icosphere(2);
    const Structure s = makeStructure(mesh.input());
    Random random(77);
    std::vector<bvh::InstanceDesc> list;
    Mesh flat;
    for (uint32_t i = 0; i < 60; ++i) {
        bvh::InstanceDesc d = instance(handleOf(s), i, random.point(5));
        for (int k = 0; k < 12; ++k)
            if (k % 4 != 3)
                d.transform[k] = random(-0.6f, 0.6f) + (k % 5 == 0 ? 0.7f : 0.0f);
        list.push_back(d);
        for (const auto& t : mesh.triangles)
            for (uint32_t corner : t) {
                flat.triangles.resize(flat.vertices.size() / 3 + 1);
                flat.triangles.back()[flat.vertices.size() % 3] = uint32_t(flat.vertices.size());
                flat.vertices.push_back(math::transformPoint(d.transform, mesh.vertices[corner]));
            }
    }
    const Structure ias = instances(list), whole = makeStructure(flat.input());
    float t = 0;
    uint32_t id = 0, disagree = 0, hits = 0;
    programs.closestHit = [&](RayState* r) {
        t = r->tmax;
        id = r->hit.instanceId;
        return kAccept;
    };
    for (int i = 0; i < 20000; ++i) {
        const Vec3 o = random.unit() * 12.0f, d = random.point(4) - o;
        t = -1;
        RayState r = ray(handleOf(ias), o, d);
        r.rayFlags = i % 2; // with and without any-hit
        launch_.trace(&r);
        bvh::QueryHit hit{};
        const bool found =
            kernels(bvh::chosenIsa())
                .closest(whole.block(), {{o.x, o.y, o.z}, 0, {d.x, d.y, d.z}, 1e16f}, hit);
        hits += found;
        disagree += found != (t >= 0) || (found && std::fabs(t - hit.t) > 1e-4f);
    }
    EXPECT_GT(hits, 5000u);
    EXPECT_LT(disagree, 20u); // rounding at silhouettes
}

TEST_P(Trace, Callables) {
    RayState r = ray(0, kEye, kDown);
    const void* code = launch_.callable(&r, 0, 0);
    ASSERT_EQ(code, reinterpret_cast<const void*>(&addOne));
    EXPECT_EQ(static_cast<const uint32_t*>(r.callableData)[0], 7u);
    using Callable = uint32_t (*)(RayState*, uint32_t);
    for (auto [index, continuation] : {std::pair{1u, 0u}, {~0u, 0u}, {0u, 1u}}) {
        const auto harmless = reinterpret_cast<Callable>(
            const_cast<void*>(launch_.callable(&r, index, continuation)));
        ASSERT_NE(harmless, nullptr);
        EXPECT_EQ(harmless(&r, 41), 0u);
    }
}

TEST_P(Trace, VariantsWithoutFeatures) {
    const Structure s = squares(2);
    int hits = 0, misses = 0;
    programs.closestHit = [&](RayState*) { return ++hits, kAccept; };
    programs.miss = [&](RayState*) { return ++misses, kAccept; };
    launch_.trace = set().traceGas;
    launch_.hasAnyHit = 0;
    RayState r = ray(handleOf(s), kEye, kDown);
    launch_.trace(&r);
    const Structure ias = instances({instance(handleOf(s), 0, {0, 0, 0})});
    launch_.trace(&(r = ray(handleOf(ias), kEye, kDown)));
    EXPECT_EQ(hits, 1);
    EXPECT_EQ(misses, 1);
}

INSTANTIATE_TEST_SUITE_P(AllSets, Trace,
                         ::testing::Values(bvh::Isa::kBaseline, bvh::Isa::kAvx2, bvh::Isa::kAvx512),
                         [](const auto& info) { return std::string(isaName(info.param)); });

// Either of them alone is logged.
TEST(CheckRay, NotesOffsetsAndStridesAbove15) {
    for (const auto& [offset, stride, isNoted] :
         {std::tuple{15u, 15u, false}, {16u, 0u, true}, {0u, 16u, true}, {255u, 255u, true}}) {
        NotedLaunch launch{};
        launch.exceptionFlags = kFlagDebug | kHasNotes;
        RayState ray{};
        ray.launch = &launch;
        ray.worldDirection[2] = ray.tmax = 1;
        ray.sbtOffset = offset;
        ray.sbtStride = stride;
        checkRay(&ray);
        EXPECT_EQ(isNoted, launch.notes.wideSbt == 1) << offset << " " << stride;
    }
}

TEST(SelectTrace, TakesTheBestSetAndTheFeaturesIntoAccount) {
    const TraceVariant all = selectTrace({}), gas = selectTrace({false, false, false});
    EXPECT_NE(all.trace, gas.trace);
    EXPECT_EQ(all.report, gas.report);
    LaunchState launch = {};
    bindTrace(launch, {});
    EXPECT_EQ(launch.trace, all.trace);
    EXPECT_EQ(launch.callable, all.callable);
}

} // namespace
} // namespace sunstone::devlib
