// SPDX-License-Identifier: Apache-2.0
// Features that a second API generation needs from the trace run-time: records found by a rule of
// its own, visit programs that choose among children, attributes in blocks of any size, payloads in
// memory.
#include "bvh/build/build.h"
#include "bvh/testing/meshes.h"
#include "devlib/trace_body.h"

#include <gtest/gtest.h>

#include <cstring>
#include <functional>

namespace sunstone::devlib {
namespace {

using bvh::testing::makeStructure;
using bvh::testing::Mesh;
using bvh::testing::Structure;

// One record for all hits and one for all misses, wherever they are.
struct TinyRecords {
    static constexpr bool kVisits = true;
    static constexpr bool kAttributeBlocks = true;
    static constexpr bool kMaterials = false;
    static constexpr bool kAttributePrograms = false;
    static constexpr bool kOwnRecords = true;
    static constexpr unsigned kAttributeWords = 2;
    static uint64_t hitIndex(const RayState&, uint32_t, uint32_t) { return 0; }
    static uint64_t hit(const RayState& ray, uint32_t, uint32_t) { return ray.launch->sbt.hitBase; }
    static uint64_t miss(const RayState& ray) { return ray.launch->sbt.missBase; }
};

struct Programs {
    std::function<uint32_t(RayState*)> closestHit, anyHit, intersection, visit;
    int misses = 0;
} programs;

uint32_t runClosestHit(RayState* s) {
    return programs.closestHit ? programs.closestHit(s) : kAccept;
}
uint32_t runAnyHit(RayState* s) {
    return programs.anyHit ? programs.anyHit(s) : kAccept;
}
uint32_t runIntersection(RayState* s) {
    return programs.intersection(s);
}
uint32_t runVisit(RayState* s) {
    return programs.visit(s);
}
uint32_t runMissProgram(RayState*) {
    return ++programs.misses, kAccept;
}

constexpr uint32_t kFirst = 7, kHits = 7, kMisses = 8, kVisits = 9;
constexpr unsigned kAttributes = 25; // more words than OptiX 7 has

class Generation : public ::testing::Test {
protected:
    struct Record {
        SbtHeader header;
        uint32_t data[4];
    };

    void SetUp() override {
        programs = {};
        const auto set = [&](uint32_t group, GroupKind kind, Role role, ProgramFn program) {
            groups_[group - kFirst].kind = kind;
            groups_[group - kFirst].code[role] = reinterpret_cast<const void*>(program);
        };
        set(kHits, kGroupHit, kRoleMain, runClosestHit);
        set(kHits, kGroupHit, kRoleAnyHit, runAnyHit);
        set(kHits, kGroupHit, kRoleIntersection, runIntersection);
        set(kMisses, kGroupMiss, kRoleMain, runMissProgram);
        set(kVisits, kGroupVisit, kRoleMain, runVisit);
        launch_.groups = groups_;
        launch_.firstGroup = kFirst;
        launch_.groupCount = 3;
        launch_.maxTraceDepth = 1;
        launch_.maxGraphDepth = kMaxGraphDepth;
        launch_.hasAnyHit = 1;
        launch_.attributeBytes = sizeof(blocks_[0]);
        launch_.sbt.hitBase = uint64_t(&hit_);
        launch_.sbt.missBase = uint64_t(&miss_);
        launch_.report = baseline::report<TinyRecords>;
        launch_.visitChild = baseline::visitChild<TinyRecords>;
    }

    // Along -z from z = 10.
    void trace(uint64_t handle, uint32_t flags = 0) {
        std::memset(static_cast<void*>(&ray_), 0xCD, sizeof ray_);
        const float origin[3] = {0.25f, 0.5f, 10}, direction[3] = {0, 0, -1};
        std::copy_n(origin, 3, ray_.worldOrigin);
        std::copy_n(direction, 3, ray_.worldDirection);
        ray_.tmin = ray_.time = 0;
        ray_.tmax = 1e16f;
        ray_.rayFlags = flags;
        ray_.visibilityMask = 255;
        ray_.handle = handle;
        ray_.launch = &launch_;
        ray_.thread = &thread_;
        ray_.depth = 1;
        ray_.payloadMemory = &payload_;
        ray_.attributeBlocks[0] = blocks_[0];
        ray_.attributeBlocks[1] = blocks_[1];
        baseline::trace<TinyRecords, true>(&ray_);
    }

    static Structure squareAt(float z) {
        Mesh m;
        m.vertices = {{-1, -1, z}, {1, -1, z}, {1, 1, z}, {-1, 1, z}};
        m.triangles = {{0, 1, 2}, {0, 2, 3}};
        return makeStructure(m.input());
    }
    struct Box {
        float lower[3], upper[3];
    };
    static Structure boxes(const std::vector<Box>& list) {
        bvh::CustomInput in;
        in.aabbs = list.data();
        in.numPrimitives = uint32_t(list.size());
        bvh::BuildInputs inputs;
        inputs.customs = {&in, 1};
        return makeStructure(inputs);
    }
    static uint64_t handleOf(const Structure& s) { return bvh::traversableHandle(s.block()); }

    GroupEntry groups_[3] = {};
    Record hit_ = {{kSbtMagic, kHits, kGroupHit, {}}, {1, 0, 0, 0}};
    Record miss_ = {{kSbtMagic, kMisses, kGroupMiss, {}}, {2, 0, 0, 0}};
    Record visit_ = {{kSbtMagic, kVisits, kGroupVisit, {}}, {3, 0, 0, 0}};
    LaunchState launch_{};
    ThreadState thread_{};
    RayState ray_;
    double payload_[40] = {};
    uint32_t blocks_[2][kAttributes] = {};
};

TEST_F(Generation, VisitProgramsChooseChildren) {
    const Structure near = squareAt(5), far = squareAt(1), middle = squareAt(3);
    const uint64_t children[3] = {handleOf(near), handleOf(far), handleOf(middle)};
    const VisitNode node = {uint64_t(&visit_), children, 3, 0};
    const uint64_t handle = makeHandle(&node, kTagVisit);
    std::vector<uint32_t> wanted;
    programs.visit = [&](RayState* s) {
        EXPECT_EQ(s->visited, &node);
        for (const uint32_t child : wanted) {
            EXPECT_EQ(static_cast<const uint32_t*>(s->sbtData)[0], 3u);
            EXPECT_EQ(s->objectOrigin[2], 10);
            if (s->launch->visitChild(s, child) == kTerminate)
                return kTerminate;
        }
        return kAccept;
    };
    float t = 0;
    programs.closestHit = [&](RayState* s) { return t = s->hit.t, kAccept; };
    const auto hitAt = [&](std::vector<uint32_t> list) {
        wanted = std::move(list);
        t = 0;
        trace(handle);
        return t;
    };
    EXPECT_FLOAT_EQ(hitAt({0}), 5);
    EXPECT_FLOAT_EQ(hitAt({1}), 9);
    EXPECT_FLOAT_EQ(hitAt({1, 2}), 7);
    EXPECT_FLOAT_EQ(hitAt({0, 1, 2}), 5);
    EXPECT_EQ(programs.misses, 0);
    EXPECT_FLOAT_EQ(hitAt({}), 0);
    EXPECT_FLOAT_EQ(hitAt({3}), 0) << "there is no such child";
    EXPECT_EQ(programs.misses, 2);
    // An any-hit program that ends the ray ends the visit.
    int visits = 0;
    programs.anyHit = [&](RayState*) { return ++visits, kTerminate; };
    EXPECT_FLOAT_EQ(hitAt({1, 0}), 9);
    EXPECT_EQ(visits, 1);
}

TEST_F(Generation, VisitNodesMayNest) {
    const Structure square = squareAt(5);
    const uint64_t inner[1] = {handleOf(square)};
    const VisitNode below = {uint64_t(&visit_), inner, 1, 0};
    const uint64_t outer[2] = {makeHandle(&below, kTagVisit), handleOf(square)};
    const VisitNode above = {uint64_t(&visit_), outer, 2, 0};
    std::vector<const VisitNode*> seen;
    programs.visit = [&](RayState* s) {
        const VisitNode* const here = s->visited;
        seen.push_back(here);
        s->launch->visitChild(s, 0);
        EXPECT_EQ(s->visited, here);
        return kAccept;
    };
    trace(makeHandle(&above, kTagVisit));
    EXPECT_EQ(seen, (std::vector<const VisitNode*>{&above, &below}));
    EXPECT_EQ(programs.misses, 0);
}

// Closest-hit sees the attributes of the accepted hit, not those that rejected candidates have
// written.
TEST_F(Generation, AttributeBlocksFollowTheAcceptedHit) {
    const Structure structure =
        boxes({{{-1, -1, 4}, {1, 1, 5}}, {{-1, -1, 2}, {1, 1, 3}}, {{-1, -1, 7}, {1, 1, 8}}});
    programs.intersection = [&](RayState* s) {
        auto* block = static_cast<uint32_t*>(s->attributeBlocks[0]);
        for (unsigned i = 0; i < kAttributes; ++i)
            block[i] = 100 * s->hit.primitive + i;
        const float t[] = {5, 7, 2};
        return s->launch->report(s, t[s->hit.primitive], 0);
    };
    programs.anyHit = [&](RayState* s) {
        const auto* block = static_cast<const uint32_t*>(s->attributeBlocks[0]);
        EXPECT_EQ(block[kAttributes - 1], 100 * s->hit.primitive + kAttributes - 1);
        return s->hit.primitive == 2 ? kIgnore : kAccept; // the nearest one is rejected
    };
    int calls = 0;
    programs.closestHit = [&](RayState* s) {
        ++calls;
        EXPECT_EQ(s->hit.primitive, 0u);
        const auto* block = static_cast<const uint32_t*>(s->attributeBlocks[0]);
        for (unsigned i = 0; i < kAttributes; ++i)
            EXPECT_EQ(block[i], i);
        static_cast<double*>(s->payloadMemory)[39] = 6.5;
        return kAccept;
    };
    trace(handleOf(structure));
    EXPECT_EQ(calls, 1);
    EXPECT_EQ(payload_[39], 6.5);
}

TEST_F(Generation, Optix7HasNoVisitNodes) {
    const Structure square = squareAt(5);
    const uint64_t children[1] = {handleOf(square)};
    const VisitNode node = {uint64_t(&visit_), children, 1, 0};
    programs.visit = [&](RayState*) {
        ADD_FAILURE();
        return kAccept;
    };
    std::memset(static_cast<void*>(&ray_), 0, sizeof ray_);
    ray_.worldDirection[2] = -1;
    ray_.worldOrigin[2] = 10;
    ray_.tmax = 100;
    ray_.handle = makeHandle(&node, kTagVisit);
    ray_.launch = &launch_;
    ray_.thread = &thread_;
    launch_.sbt.missStride = sizeof(Record);
    launch_.sbt.missCount = 1;
    baseline::trace<SbtRecords, true>(&ray_);
    EXPECT_EQ(programs.misses, 1);
}

} // namespace
} // namespace sunstone::devlib
