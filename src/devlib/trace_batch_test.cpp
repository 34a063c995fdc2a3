// SPDX-License-Identifier: Apache-2.0
// traceBatch against trace: the same programs see the same states, bit for bit.
#include "devlib/trace.h"

#include "bvh/build/build.h"
#include "bvh/layout.h"
#include "bvh/testing/meshes.h"
#include "devlib/flags.h"
#include "devlib/trace_sets.h"

#include <gtest/gtest.h>

#include <cstring>

namespace sunstone::devlib {
namespace {

using bvh::testing::makeStructure;
using bvh::testing::Mesh;
using bvh::testing::Random;
using bvh::testing::Structure;
using math::Vec3;

// The states that the programs of one ray saw.
struct Outcome {
    uint32_t closestHits = 0, misses = 0, anyHits = 0, intersections = 0;
    uint32_t anyHitDigest = 0; // of the candidates in their order
    Hit hit = {};
    float tmax = 0;
    const void* sbtData = nullptr;

    bool operator==(const Outcome& o) const {
        return closestHits == o.closestHits && misses == o.misses && anyHits == o.anyHits &&
               intersections == o.intersections && anyHitDigest == o.anyHitDigest &&
               std::memcmp(&hit, &o.hit, sizeof hit) == 0 &&
               std::memcmp(&tmax, &o.tmax, sizeof tmax) == 0 && sbtData == o.sbtData;
    }
};

std::vector<Outcome>* outcomes = nullptr;
bool isInBatch = false;

Outcome& outcomeOf(RayState* s) {
    EXPECT_FALSE(isInBatch) << "a program runs during traceBatch";
    return (*outcomes)[s->payload[0]];
}

uint32_t bits(float f) {
    uint32_t b;
    std::memcpy(&b, &f, 4);
    return b;
}

uint32_t runClosestHit(RayState* s) {
    Outcome& o = outcomeOf(s);
    ++o.closestHits;
    o.hit = s->hit;
    for (uint32_t i = s->hit.transformCount; i < kMaxGraphDepth; ++i)
        o.hit.transforms[i] = 0; // not in use
    o.tmax = s->tmax;
    o.sbtData = s->sbtData;
    return kAccept;
}
uint32_t runMiss(RayState* s) {
    Outcome& o = outcomeOf(s);
    ++o.misses;
    o.tmax = s->tmax;
    o.sbtData = s->sbtData;
    EXPECT_EQ(s->hit.record, nullptr);
    EXPECT_EQ(s->hit.transformCount, 0u);
    return kAccept;
}
uint32_t runAnyHit(RayState* s) {
    Outcome& o = outcomeOf(s);
    ++o.anyHits;
    o.anyHitDigest = o.anyHitDigest * 31 + bits(s->hit.t);
    return s->hit.primitive % 3 == 0 ? kIgnore : s->hit.primitive % 7 == 0 ? kTerminate : kAccept;
}
uint32_t runIntersection(RayState* s) {
    ++outcomeOf(s).intersections;
    return s->launch->report(s, s->tmin + 1, 3) == kTerminate ? kTerminate : kAccept;
}

struct Record {
    SbtHeader header;
    uint32_t data[4];
};

class TraceBatch : public ::testing::TestWithParam<bvh::Isa> {
protected:
    void SetUp() override {
        if (!bvh::isaSupported(GetParam()))
            GTEST_SKIP() << "[SKIP] this processor has no " << bvh::isaName(GetParam());
        groups_[1].code[kRoleMain] = reinterpret_cast<const void*>(&runClosestHit);
        groups_[1].code[kRoleAnyHit] = reinterpret_cast<const void*>(&runAnyHit);
        groups_[1].code[kRoleIntersection] = reinterpret_cast<const void*>(&runIntersection);
        groups_[2].code[kRoleMain] = reinterpret_cast<const void*>(&runMiss);
        for (uint32_t i = 0; i < 32; ++i) // group 3 has no program
            hit_[i] = {{kSbtMagic, i % 5 == 4 ? 3u : 1u, kGroupHit, {}}, {i, 0, 0, 0}};
        for (uint32_t i = 0; i < 4; ++i)
            miss_[i] = {{kSbtMagic, 2, kGroupMiss, {}}, {100 + i, 0, 0, 0}};
        launch_.maxTraceDepth = 5;
        launch_.maxGraphDepth = kMaxGraphDepth;
        launch_.groups = groups_;
        launch_.groupCount = 4;
        launch_.sbt = {};
        launch_.sbt.hitBase = uint64_t(hit_);
        launch_.sbt.hitStride = sizeof(Record);
        launch_.sbt.hitCount = 32;
        launch_.sbt.missBase = uint64_t(miss_);
        launch_.sbt.missStride = sizeof(Record);
        launch_.sbt.missCount = 4;
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

    RayState ray(uint64_t handle, Vec3 o, Vec3 d, uint32_t index) {
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
        s.sbtOffset = 0;
        s.sbtStride = 1;
        s.missIndex = index % 5;
        s.handle = handle;
        s.launch = &launch_;
        s.thread = &thread_;
        s.depth = 1;
        s.payloadType = 0;
        s.payloadCount = 1;
        s.payload[0] = index;
        return s;
    }

    // Rays towards the middle of the scene with any flags; some are invalid.
    std::vector<RayState> rays(const std::vector<uint64_t>& handles, uint32_t count,
                               Random& random) {
        constexpr uint32_t kFlags[] = {0, 0, 0, 1, 1, 4, 5, 8, 9, 12, 13, 16, 32, 2, 64, 128, 20};
        std::vector<RayState> list;
        for (uint32_t i = 0; i < count; ++i) {
            const Vec3 o = random.unit() * (random.below(2) ? 3.0f : 0.5f);
            const uint64_t handle = handles[random.below(uint32_t(handles.size()))];
            RayState s =
                ray(handle, o, random.below(3) ? random.point(0.8f) - o : random.unit(), i);
            s.rayFlags = kFlags[random.below(std::size(kFlags))];
            s.visibilityMask = random.below(4) ? 255 : 1u << random.below(3);
            if (random.below(6) == 0) {
                s.tmin = random(-1, 1);
                s.tmax = s.tmin + random(0, 3);
            }
            switch (random.below(40)) {
            case 0:
                s.worldOrigin[random.below(3)] = NAN;
                break;
            case 1:
                s.worldDirection[random.below(3)] = INFINITY;
                break;
            case 2:
                s.tmax = s.tmin - 1;
                break;
            case 3:
                std::memset(s.worldDirection, 0, sizeof s.worldDirection);
                break;
            case 4:
                s.depth = 6;
                break;
            case 5:
                s.worldDirection[0] = s.worldDirection[1] = 0;
                break;
            }
            list.push_back(s);
        }
        return list;
    }

    // The same in bundles with one direction, handle and set of flags, but for a few rays.
    std::vector<RayState> bundles(const std::vector<uint64_t>& handles, uint32_t count,
                                  Random& random) {
        constexpr uint32_t kBundle = 64;
        constexpr uint32_t kFlags[] = {0, 0, 1, 5, 12, 12, 13, 16, 32, 44};
        std::vector<RayState> list = rays(handles, count, random);
        RayState like = {};
        Vec3 direction, origin;
        for (uint32_t i = 0; i < count; ++i) {
            if (i % kBundle == 0) {
                like.handle = list[i].handle;
                like.rayFlags = kFlags[random.below(std::size(kFlags))];
                origin = random.unit() * 3.0f;
                direction = random.point(0.5f) - origin;
            }
            RayState& s = list[i];
            if (random.below(20) == 0 || !(s.worldDirection[0] * 0 == 0) || s.depth != 1)
                continue;
            s.handle = like.handle;
            s.rayFlags = like.rayFlags;
            const Vec3 o = origin + random.point(0.3f), d = direction + random.point(0.3f);
            for (int k = 0; k < 3; ++k) {
                s.worldOrigin[k] = o[k];
                s.worldDirection[k] = d[k];
            }
        }
        return list;
    }

    // Returns how many rays the batch walked itself.
    uint32_t compare(const std::vector<RayState>& rays, TraceBatchFn batch,
                     void (*trace)(RayState*)) {
        const size_t count = rays.size();
        std::vector<Outcome> expected(count), got(count);
        std::vector<RayState> states = rays;
        outcomes = &expected;
        for (RayState& s : states)
            trace(&s);
        states = rays;
        outcomes = &got;
        std::vector<RayState*> list;
        for (RayState& s : states)
            list.push_back(&s);
        const ProgramFn untouched = reinterpret_cast<ProgramFn>(uintptr_t(7));
        std::vector<ProgramFn> next(count + 1, untouched);
        isInBatch = true;
        batch(list.data(), next.data(), uint32_t(count));
        isInBatch = false;
        EXPECT_EQ(next[count], untouched);
        uint32_t walked = 0;
        for (size_t i = 0; i < count; ++i) {
            walked += next[i] == nullptr || next[i] == runClosestHit || next[i] == runMiss;
            if (next[i])
                next[i](&states[i]);
        }
        for (size_t i = 0; i < count; ++i)
            if (!(expected[i] == got[i])) {
                ADD_FAILURE() << "ray " << i << " flags " << rays[i].rayFlags << ": t "
                              << expected[i].hit.t << " primitive " << expected[i].hit.primitive
                              << " instance " << expected[i].hit.instanceIndex << "; in the batch "
                              << got[i].hit.t << ' ' << got[i].hit.primitive << ' '
                              << got[i].hit.instanceIndex;
                break;
            }
        return walked;
    }
    uint32_t compare(const std::vector<RayState>& rays) {
        return compare(rays, set().batchGraph, set().traceGraph);
    }

    // Each triangle twice, in shuffled places, so that hits tie.
    static Structure soup(uint32_t count, uint32_t seed, uint32_t flags) {
        Mesh mesh = bvh::testing::soup(count, 0.25f, seed);
        const auto once = mesh.triangles;
        mesh.triangles.insert(mesh.triangles.end(), once.rbegin(), once.rend());
        std::vector<uint32_t> sbt;
        for (uint32_t i = 0; i < mesh.triangles.size(); ++i)
            sbt.push_back(i % 3);
        const uint32_t allFlags[3] = {flags, flags, flags | bvh::kGeometryDisableFaceCulling};
        bvh::TriangleInput in = mesh.input();
        in.sbt = {allFlags, 3, sbt.data(), 4, 0, 0};
        return makeStructure(in);
    }
    static uint64_t handleOf(const Structure& s) { return bvh::traversableHandle(s.block()); }

    static bvh::InstanceDesc instance(uint64_t handle, uint32_t id, Random& random) {
        const Vec3 at = random.point(0.6f);
        bvh::InstanceDesc d = {
            {0.5f, 0, 0, at.x, 0, 0.5f, 0, at.y, 0, 0, 0.5f, at.z}, id, id % 5, 255, 0, handle, {}};
        for (int k = 0; k < 12; ++k)
            if (k % 4 != 3)
                d.transform[k] += random(-0.2f, 0.2f);
        d.visibilityMask = random.below(3) ? 255 : 1 + random.below(7);
        constexpr uint32_t kFlags[] = {0, 0, 1, 2, 4, 8};
        d.flags = kFlags[random.below(std::size(kFlags))];
        return d;
    }
    static Structure instances(const std::vector<bvh::InstanceDesc>& list) {
        bvh::InstanceInput in;
        in.instances = list.data();
        in.numInstances = uint32_t(list.size());
        bvh::BuildInputs inputs;
        inputs.instances = &in;
        return makeStructure(inputs);
    }
    // `count` instances of these, each of every third one twice.
    static Structure instancesOf(const std::vector<uint64_t>& children, uint32_t count,
                                 Random& random) {
        std::vector<bvh::InstanceDesc> list;
        for (uint32_t i = 0; i < count; ++i) {
            list.push_back(instance(children[i % children.size()], i, random));
            if (i % 3 == 0) {
                list.push_back(list.back()); // hits tie
                list.back().instanceId = 1000 + i;
            }
        }
        return instances(list);
    }

    GroupEntry groups_[4] = {};
    Record hit_[32], miss_[4];
    LaunchState launch_{};
    ThreadState thread_{};
};

TEST_P(TraceBatch, TrianglesWithAllFlags) {
    Random random(1);
    const Structure a = soup(400, 1, bvh::kGeometryDisableAnyHit), b = soup(30, 2, 0);
    for (const uint32_t hasAnyHit : {0u, 1u})
        for (const uint32_t count : {0u, 1u, 3u, 5u, 31u, 64u, 128u, 129u, 1000u}) {
            launch_.hasAnyHit = hasAnyHit;
            compare(rays({handleOf(a), handleOf(b), handleOf(a)}, count, random));
        }
    launch_.hasAnyHit = 0;
    std::vector<RayState> list = rays({handleOf(a)}, 1000, random);
    for (RayState& s : list)
        s.rayFlags &= kRayTerminateOnFirstHit | kRayDisableClosestHit | kRayCullBack;
    EXPECT_GT(compare(list), 900u);
    EXPECT_GT(compare(list, set().batchGas, set().traceGas), 900u);
}

TEST_P(TraceBatch, InstancesOnSeveralLevels) {
    Random random(2);
    Mesh none = bvh::testing::cube();
    none.triangles.clear();
    const Structure a = soup(60, 3, bvh::kGeometryDisableAnyHit), b = soup(7, 4, 0),
                    empty = makeStructure(none.input());
    std::vector<Structure> levels = {
        instancesOf({handleOf(a), handleOf(b), handleOf(empty)}, 30, random)};
    for (int depth = 2; depth < 6; ++depth) // the deepest are too deep for the batch
        levels.push_back(instancesOf({handleOf(levels.back()), handleOf(a)}, 6, random));
    std::vector<uint64_t> handles = {handleOf(a)};
    for (const Structure& s : levels)
        handles.push_back(handleOf(s));
    for (const uint32_t hasAnyHit : {0u, 1u})
        for (const uint32_t graphFlags : {0u, uint32_t(kAllowSingleLevelInstancing)}) {
            launch_.hasAnyHit = hasAnyHit;
            launch_.traversableGraphFlags = graphFlags;
            for (const uint64_t handle : handles)
                compare(rays({handle}, 300, random));
            compare(rays(handles, 1000, random));
        }
    launch_.traversableGraphFlags = launch_.hasAnyHit = 0;
    std::vector<RayState> list = rays({handles[1], handles[2]}, 1000, random);
    for (RayState& s : list)
        s.rayFlags &= kRayTerminateOnFirstHit | kRayDisableClosestHit | kRayCullBack;
    EXPECT_GT(compare(list), 900u);
    launch_.maxGraphDepth = 2;
    compare(list);
}

TEST_P(TraceBatch, BundlesThroughTriangles) {
    Random random(4);
    const Structure a = soup(900, 1, bvh::kGeometryDisableAnyHit), b = soup(30, 2, 0);
    for (const uint32_t hasAnyHit : {0u, 1u})
        for (const uint32_t count : {7u, 8u, 63u, 64u, 65u, 128u, 1000u, 4000u}) {
            launch_.hasAnyHit = hasAnyHit;
            compare(bundles({handleOf(a), handleOf(b)}, count, random));
        }
}

TEST_P(TraceBatch, BundlesThroughInstances) {
    Random random(5);
    Mesh none = bvh::testing::cube();
    none.triangles.clear();
    const Structure a = soup(60, 3, bvh::kGeometryDisableAnyHit), b = soup(7, 4, 0),
                    large = soup(900, 6, bvh::kGeometryDisableAnyHit),
                    empty = makeStructure(none.input());
    const Structure one = instancesOf({handleOf(large)}, 1, random),
                    few = instancesOf({handleOf(a), handleOf(large), handleOf(empty)}, 6, random),
                    many = instancesOf({handleOf(a), handleOf(b)}, 60, random),
                    nested = instancesOf({handleOf(few), handleOf(a)}, 6, random);
    for (const uint32_t hasAnyHit : {0u, 1u})
        for (const uint32_t graphFlags : {0u, uint32_t(kAllowSingleLevelInstancing)}) {
            launch_.hasAnyHit = hasAnyHit;
            launch_.traversableGraphFlags = graphFlags;
            for (const Structure* s : {&one, &few, &many, &nested})
                compare(bundles({handleOf(*s)}, 2000, random));
            compare(bundles({handleOf(one), handleOf(many), handleOf(large)}, 2000, random));
        }
    launch_.hasAnyHit = 0;
    groups_[1].kind = kGroupHit;
    groups_[1].code[kRoleIntersection] = nullptr; // it would keep packets from instances
    for (const Structure* s : {&one, &few, &many, &nested})
        compare(bundles({handleOf(*s)}, 2000, random));
    EXPECT_GT(compare(bundles({handleOf(few)}, 2000, random)), 1200u); // some ties are traced alone
    launch_.maxGraphDepth = 1;
    compare(bundles({handleOf(few)}, 500, random));
}

TEST_P(TraceBatch, HandlesOfAllKinds) {
    Random random(3);
    launch_.hasAnyHit = 1;
    const Structure a = soup(60, 5, bvh::kGeometryDisableAnyHit);
    const float boxes[2][6] = {{-1, -1, -1, 0, 0, 0}, {0.1f, 0.1f, 0.1f, 0.9f, 1, 1}};
    bvh::CustomInput custom;
    custom.aabbs = boxes;
    custom.numPrimitives = 2;
    bvh::BuildInputs inputs;
    inputs.customs = {&custom, 1};
    const Structure boxed = makeStructure(inputs);
    alignas(64) bvh::StaticTransform shift = {};
    shift.child = handleOf(a);
    for (int i = 0; i < 3; ++i)
        shift.transform[5 * i] = shift.inverse[5 * i] = 1;
    shift.transform[3] = 0.25f;
    shift.inverse[3] = -0.25f;
    const uint64_t shifted = makeHandle(&shift, kTagStatic);
    const Structure mixed = instancesOf({handleOf(a), handleOf(boxed), shifted}, 9, random);
    alignas(128) static const uint8_t garbage[256] = {1, 2, 3};
    const std::vector<uint64_t> handles = {handleOf(a),
                                           handleOf(boxed),
                                           handleOf(mixed),
                                           shifted,
                                           0,
                                           makeHandle(garbage, kTagGas),
                                           makeHandle(garbage, kTagIas),
                                           ~uint64_t(0)};
    for (int round = 0; round < 5; ++round) {
        compare(rays(handles, 400, random));
        compare(bundles(handles, 400, random));
    }
    EXPECT_EQ(compare(rays({handleOf(boxed)}, 50, random), set().batchClassic, set().traceClassic),
              0u);
}

INSTANTIATE_TEST_SUITE_P(AllSets, TraceBatch,
                         ::testing::Values(bvh::Isa::kBaseline, bvh::Isa::kAvx2, bvh::Isa::kAvx512),
                         [](const auto& info) { return std::string(isaName(info.param)); });

TEST(SelectTraceBatch, LeavesAllRaysOfCheckedAndClassicPipelines) {
    for (const TraceFeatures& features :
         {TraceFeatures{.checked = true}, TraceFeatures{.classic = true}}) {
        RayState ray = {};
        RayState* const rays[2] = {&ray, &ray};
        ProgramFn next[2] = {};
        selectTrace(features).traceBatch(rays, next, 2);
        EXPECT_NE(next[0], nullptr);
        EXPECT_EQ(next[0], next[1]);
    }
}

} // namespace
} // namespace sunstone::devlib
