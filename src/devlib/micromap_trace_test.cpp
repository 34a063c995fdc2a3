// SPDX-License-Identifier: Apache-2.0
// Rays through triangles with opacity micromaps: the programs that run, and the hits, by state and
// by the flags of geometry, instance and ray. References: the rules written out, any-hit programs
// that decide the same, and, for moving triangles, the same triangles without motion.
#include "bvh/micromap/micromap_array.h"
#include "bvh/motion/motion.h"
#include "bvh/testing/meshes.h"
#include "devlib/flags.h"
#include "devlib/trace.h"
#include "devlib/trace_sets.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <functional>

namespace sunstone::devlib {
namespace {

using bvh::MicromapFormat;
using bvh::testing::alignedBuffer;
using bvh::testing::makeStructure;
using bvh::testing::Mesh;
using bvh::testing::Random;
using bvh::testing::Structure;
using math::Vec3;

std::function<uint32_t(RayState*)> anyHitProgram;
int anyHitCalls;
uint32_t runAnyHit(RayState* s) {
    ++anyHitCalls;
    return anyHitProgram ? anyHitProgram(s) : kAccept;
}
uint32_t runClosestHit(RayState* s) {
    s->payload[0] = 1;
    return kAccept;
}
uint32_t runMiss(RayState* s) {
    s->payload[0] = 0;
    return kAccept;
}

class MicromapTrace : public ::testing::TestWithParam<bvh::Isa> {
protected:
    void SetUp() override {
        if (!bvh::isaSupported(GetParam()))
            GTEST_SKIP() << "[SKIP] this processor has no " << bvh::isaName(GetParam());
        anyHitProgram = {};
        groups_[1].code[kRoleMain] = reinterpret_cast<const void*>(&runClosestHit);
        groups_[1].code[kRoleAnyHit] = reinterpret_cast<const void*>(&runAnyHit);
        groups_[2].code[kRoleMain] = reinterpret_cast<const void*>(&runMiss);
        for (SbtHeader& record : hit_)
            record = {kSbtMagic, 1, kGroupHit, {}};
        miss_ = {kSbtMagic, 2, kGroupMiss, {}};
        launch_ = {};
        launch_.maxTraceDepth = 1;
        launch_.maxGraphDepth = kMaxGraphDepth;
        launch_.groups = groups_;
        launch_.groupCount = 3;
        launch_.hasAnyHit = 1;
        launch_.opacityMicromaps = 1;
        launch_.motion = 1;
        launch_.sbt.hitBase = uint64_t(hit_);
        launch_.sbt.hitStride = sizeof(SbtHeader);
        launch_.sbt.hitCount = 2;
        launch_.sbt.missBase = uint64_t(&miss_);
        launch_.sbt.missStride = sizeof(SbtHeader);
        launch_.sbt.missCount = 1;
        bindTrace(launch_, {});
        const TraceSet& set = GetParam() == bvh::Isa::kAvx512 ? kTraceAvx512
                              : GetParam() == bvh::Isa::kAvx2 ? kTraceAvx2
                                                              : kTraceBaseline;
        launch_.trace = set.traceGraph;
        launch_.report = set.report;
    }

    struct Answer {
        bool hit;
        int anyHits;
        RayState state;
    };
    Answer trace(uint64_t handle, Vec3 o, Vec3 d, uint32_t flags = 0, float time = 0) {
        Answer a{};
        RayState& s = a.state;
        std::memset(static_cast<void*>(&s), 0xCD, sizeof s);
        for (int i = 0; i < 3; ++i) {
            s.worldOrigin[i] = o[i];
            s.worldDirection[i] = d[i];
        }
        s.tmin = 0;
        s.tmax = 1e16f;
        s.time = time;
        s.rayFlags = flags;
        s.visibilityMask = 255;
        s.sbtOffset = s.missIndex = 0;
        s.sbtStride = 1;
        s.handle = handle;
        s.launch = &launch_;
        s.thread = &thread_;
        s.depth = 1;
        s.payloadType = 0;
        s.payloadCount = 1;
        s.payload[0] = 7;
        anyHitCalls = 0;
        launch_.trace(&s);
        a.hit = s.payload[0] == 1;
        a.anyHits = anyHitCalls;
        return a;
    }

    static uint64_t handleOf(const Structure& s) { return bvh::traversableHandle(s.block()); }

    void combineStatesAndFlags(bool moving);
    void compareWithAnyHitPrograms(uint32_t motionKeys);

    GroupEntry groups_[3] = {};
    SbtHeader hit_[2], miss_;
    LaunchState launch_;
    ThreadState thread_{};
};

// An array with one micromap for each list of states (all of one level).
std::shared_ptr<void> makeArray(unsigned level, MicromapFormat format,
                                const std::vector<std::vector<uint8_t>>& maps) {
    const uint64_t bytes = bvh::micromapBytes(level, format);
    const unsigned bits = format == MicromapFormat::kTwoState ? 1 : 2;
    std::vector<uint8_t> states(bytes * maps.size());
    std::vector<bvh::MicromapDesc> descs;
    for (size_t m = 0; m < maps.size(); ++m) {
        descs.push_back({uint32_t(m * bytes), uint16_t(level), uint16_t(format)});
        for (size_t i = 0; i < maps[m].size(); ++i)
            states[m * bytes + i * bits / 8] |= uint8_t(maps[m][i] << (i * bits % 8));
    }
    const bvh::MicromapHistogramEntry entry{uint32_t(maps.size()), level, format};
    const size_t size = bvh::micromapArraySizes({&entry, 1}).output;
    auto array = alignedBuffer(size);
    bvh::buildMicromapArray({{&entry, 1}, states.data(), descs.data(), 0}, array.get(), size);
    return array;
}

Mesh oneTriangle() {
    Mesh m;
    m.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    m.triangles = {{0, 1, 2}};
    return m;
}

// The mesh at each motion key, its vertices wandering.
std::vector<Mesh> movedMeshes(const Mesh& mesh, uint32_t keys) {
    std::vector<Mesh> meshes = {mesh};
    Random random(31);
    for (uint32_t k = 1; k < keys; ++k) {
        meshes.push_back(meshes.back());
        for (Vec3& v : meshes.back().vertices)
            v = v + random.point(0.2f);
    }
    return meshes;
}
std::vector<const void*> addressesOf(const std::vector<Mesh>& keys) {
    std::vector<const void*> addresses;
    for (const Mesh& key : keys)
        addresses.push_back(key.vertices.data());
    return addresses;
}

// The expected outcome at a point with this state (kNoMicromap: none): the rules in their order.
struct Expected {
    bool hit, anyHit;
};
Expected expectedFor(uint32_t state, uint32_t geometryFlags, uint32_t instanceFlags,
                     uint32_t rayFlags) {
    bool enabled = !(geometryFlags & bvh::kGeometryDisableAnyHit);
    if (instanceFlags & kInstanceDisableMicromaps)
        state = bvh::kNoMicromap;
    if (state != bvh::kNoMicromap) {
        if ((rayFlags & kRayForceMicromap2State) || (instanceFlags & kInstanceForceMicromap2State))
            state = state == bvh::kUnknownTransparent ? uint32_t(bvh::kTransparent)
                    : state == bvh::kUnknownOpaque    ? uint32_t(bvh::kOpaque)
                                                      : state;
        if (state == bvh::kTransparent)
            return {false, false};
        enabled = state != bvh::kOpaque;
    }
    if (instanceFlags & kInstanceDisableAnyHit)
        enabled = false;
    if (instanceFlags & kInstanceEnforceAnyHit)
        enabled = true;
    if (rayFlags & (enabled ? kRayCullEnforcedAnyHit : kRayCullDisabledAnyHit))
        return {false, false};
    if (rayFlags & kRayDisableAnyHit)
        enabled = false;
    if (rayFlags & kRayEnforceAnyHit)
        enabled = true;
    return {true, enabled};
}

// Checks all combinations; in a structure with two motion keys if the triangle moves.
void MicromapTrace::combineStatesAndFlags(bool moving) {
    // Micro-triangle i of the map has state i; also by predefined index, and without micromaps.
    const auto array = makeArray(1, MicromapFormat::kFourState, {{0, 1, 2, 3}});
    const Vec3 inside[4] = {{0.1f, 0.1f, 5}, {0.3f, 0.3f, 5}, {0.8f, 0.1f, 5}, {0.1f, 0.8f, 5}};
    const Mesh mesh = oneTriangle();
    Mesh later = mesh;
    for (Vec3& v : later.vertices)
        v.z += 2;
    const void* const keys[2] = {mesh.vertices.data(), later.vertices.data()};
    bvh::BuildOptions options;
    if (moving)
        options.motion = {2, 0, 0, 1};
    const float time = 0.3f;
    for (const uint32_t geometryFlags : {0u, uint32_t(bvh::kGeometryDisableAnyHit)})
        for (int index = -5; index <= 0; ++index) {
            bvh::TriangleInput in = mesh.input();
            in.sbt.flags = &geometryFlags;
            in.keyVertices = moving ? keys : nullptr;
            if (index > -5)
                in.micromaps = {bvh::MicromapIndexing::kIndexed, array.get(), &index, 4, 0, 0};
            const Structure gas = makeStructure(in, options);
            for (uint32_t instanceFlags :
                 {0u, 4u, 8u, 16u, 32u, 4u | 16, 8u | 16, 4u | 32, 8u | 32, 16u | 32}) {
                const bvh::InstanceDesc desc{{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0},
                                             0,
                                             0,
                                             255,
                                             instanceFlags,
                                             handleOf(gas),
                                             {}};
                bvh::InstanceInput instances;
                instances.instances = &desc;
                instances.numInstances = 1;
                bvh::BuildInputs inputs;
                inputs.instances = &instances;
                const Structure ias = makeStructure(inputs);
                for (uint32_t base : {0u, 1u, 2u, 64u, 128u})
                    for (uint32_t more : {0u, 1024u, 4u, 4u | 8, 4u | 8 | 1024})
                        for (uint32_t place = 0; place < 4; ++place) {
                            const uint32_t state = index == 0    ? place
                                                   : index == -5 ? uint32_t(bvh::kNoMicromap)
                                                                 : uint32_t(-1 - index);
                            const uint32_t flags = base | more;
                            const Expected e =
                                expectedFor(state, geometryFlags, instanceFlags, flags);
                            SCOPED_TRACE(::testing::Message()
                                         << "index " << index << ", state " << state
                                         << ", geometry " << geometryFlags << ", instance "
                                         << instanceFlags << ", ray " << flags);
                            const Answer a =
                                trace(handleOf(ias), inside[place], {0, 0, -1}, flags, time);
                            // Without closest-hit program a hit shows only in the absence of a
                            // miss.
                            ASSERT_EQ(flags & kRayDisableClosestHit ? a.state.payload[0] == 7
                                                                    : a.hit,
                                      e.hit);
                            ASSERT_EQ(a.anyHits, e.anyHit ? 1 : 0);
                            // A program that ignores the hit makes it a miss.
                            anyHitProgram = [](RayState*) -> uint32_t { return kIgnore; };
                            const Answer b =
                                trace(handleOf(ias), inside[place], {0, 0, -1}, flags, time);
                            ASSERT_EQ(b.state.payload[0] == 0, !e.hit || e.anyHit);
                            anyHitProgram = {};
                            // Without any-hit programs only flags and transparency matter.
                            launch_.hasAnyHit = 0;
                            const Answer c =
                                trace(handleOf(ias), inside[place], {0, 0, -1}, flags, time);
                            ASSERT_EQ(c.state.payload[0] != 0, e.hit);
                            launch_.hasAnyHit = 1;
                        }
            }
        }
}

TEST_P(MicromapTrace, StatesAndFlagsCombine) {
    combineStatesAndFlags(false);
}

TEST_P(MicromapTrace, StatesAndFlagsCombineInMotion) {
    combineStatesAndFlags(true);
}

// A pile of triangles with random micromaps, the states decided once by micromap and once by an
// any-hit program that reads the same states from the barycentrics.
void MicromapTrace::compareWithAnyHitPrograms(uint32_t motionKeys) {
    const Mesh mesh = bvh::testing::soup(600, 0.5f, 11);
    const std::vector<Mesh> keys = movedMeshes(mesh, motionKeys);
    const std::vector<const void*> vertices = addressesOf(keys);
    const uint32_t half = 300;
    Random random(12);
    for (unsigned level : {0u, 2u, 5u}) {
        std::vector<std::vector<uint8_t>> states(40);
        for (auto& map : states)
            for (uint64_t i = 0; i < bvh::microTriangleCount(level); ++i)
                map.push_back(uint8_t(random.below(2)));
        const auto array = makeArray(level, MicromapFormat::kTwoState, states);
        // Two build inputs, of which the first one has index offsets and the second one none.
        std::vector<int16_t> indices;
        for (uint32_t i = 0; i < half; ++i)
            indices.push_back(int16_t(random.below(42)) - 2);
        bvh::TriangleInput with[2] = {mesh.input(), mesh.input()};
        if (motionKeys > 1)
            with[0].keyVertices = with[1].keyVertices = vertices.data();
        with[0].numTriangles = half;
        with[0].sbt.primitiveIndexOffset = 1000;
        with[1].indices = mesh.triangles.data() + half;
        with[1].numTriangles = half;
        bvh::TriangleInput without[2] = {with[0], with[1]};
        with[0].micromaps = {bvh::MicromapIndexing::kIndexed, array.get(), indices.data(), 2, 0, 0};
        bvh::BuildInputs all;
        all.triangles = with;
        bvh::BuildOptions options;
        options.preferFastTrace = true; // splits triangles
        options.motion = {motionKeys, 0, 0, 1};
        const Structure maps = makeStructure(all, options);
        all.triangles = without;
        const Structure plain = makeStructure(all, options);
        const auto decide = [&](RayState* s) -> uint32_t {
            if (s->hit.sbtGasIndex == 1)
                return kAccept;
            const int index = indices[s->hit.primitive - 1000];
            float u, v;
            std::memcpy(&u, &s->hit.attributes[0], 4);
            std::memcpy(&v, &s->hit.attributes[1], 4);
            const bool opaque = index < 0
                                    ? index == -2
                                    : states[size_t(index)][bvh::microTriangleAt(u, v, level)] == 1;
            return opaque ? kAccept : kIgnore;
        };
        int hits = 0;
        for (int i = 0; i < 3000; ++i) {
            const Vec3 o = random.unit() * 3, d = random.point(1) - o;
            const uint32_t flags = i % 3 == 2 ? uint32_t(kRayTerminateOnFirstHit) : 0u;
            const float time = motionKeys > 1 ? random(0, 1) : 0;
            anyHitProgram = decide;
            const Answer expected = trace(handleOf(plain), o, d, flags, time);
            anyHitProgram = {};
            const Answer a = trace(handleOf(maps), o, d, flags, time);
            ASSERT_EQ(a.hit, expected.hit) << "ray " << i;
            // Any-hit programs run for triangles that have no micromap, and only for those.
            launch_.hasAnyHit = 0;
            const Answer b = trace(handleOf(maps), o, d, flags, time);
            launch_.hasAnyHit = 1;
            ASSERT_EQ(b.hit, expected.hit) << "ray " << i;
            hits += a.hit;
            if (!a.hit || flags)
                continue;
            EXPECT_EQ(a.state.hit.t, expected.state.hit.t);
            EXPECT_EQ(a.state.hit.primitive, expected.state.hit.primitive);
            EXPECT_EQ(a.state.hit.kind, expected.state.hit.kind);
            EXPECT_EQ(a.state.hit.attributes[0], expected.state.hit.attributes[0]);
            EXPECT_EQ(b.state.hit.t, expected.state.hit.t);
            EXPECT_EQ(b.state.hit.primitive, expected.state.hit.primitive);
            EXPECT_EQ(b.state.hit.attributes[1], expected.state.hit.attributes[1]);
        }
        EXPECT_GT(hits, 500);
        EXPECT_LT(hits, 3000);
    }
}

TEST_P(MicromapTrace, AgreesWithAnyHitPrograms) {
    compareWithAnyHitPrograms(1);
}

TEST_P(MicromapTrace, AgreesWithAnyHitProgramsInMotion) {
    compareWithAnyHitPrograms(3);
}

// Moving triangles against a structure of the triangles at that time: all equal to the last bit.
// Then the same after an update that exchanges the keys and the micromaps.
TEST_P(MicromapTrace, MovingTrianglesAreLikeStill) {
    std::vector<Mesh> keys = movedMeshes(bvh::testing::soup(500, 0.5f, 21), 3);
    Random random(22);
    std::vector<std::vector<uint8_t>> states(30);
    for (auto& map : states)
        for (uint64_t i = 0; i < bvh::microTriangleCount(4); ++i)
            map.push_back(uint8_t(random.below(4)));
    const auto array = makeArray(4, MicromapFormat::kFourState, states);
    std::vector<int32_t> indices;
    for (int i = 0; i < 500; ++i)
        indices.push_back(int32_t(random.below(34)) - 4);
    std::vector<const void*> vertices = addressesOf(keys);
    bvh::TriangleInput in = keys[0].input();
    in.keyVertices = vertices.data();
    in.micromaps = {bvh::MicromapIndexing::kIndexed, array.get(), indices.data(), 4, 0, 0};
    bvh::BuildOptions options;
    options.allowUpdate = options.allowMicromapUpdate = true;
    options.motion = {3, 0, 0, 1};
    const Structure moving = makeStructure(in, options);
    for (bool updated : {false, true}) {
        if (updated) {
            std::swap(keys[0], keys[2]);
            std::reverse(indices.begin(), indices.end());
            vertices = addressesOf(keys);
            in.keyVertices = vertices.data();
            bvh::BuildInputs inputs;
            inputs.triangles = {&in, 1};
            const auto temp = alignedBuffer(256);
            bvh::update(inputs, options, temp.get(), 256, moving.memory.get(), moving.size);
        }
        int hits = 0, anyHits = 0;
        for (float time : {0.0f, 0.1f, 1.0f / 3, 0.5f, 0.77f, 1.0f}) {
            const bvh::KeySegment at = bvh::keySegment(3, 0, 1, time);
            Mesh mesh = keys[at.key];
            for (size_t i = 0; i < mesh.vertices.size(); ++i)
                for (int a = 0; a < 3; ++a)
                    mesh.vertices[i][a] = bvh::between(
                        mesh.vertices[i][a], keys[at.key + 1].vertices[i][a], at.fraction);
            bvh::TriangleInput stillInput = mesh.input();
            stillInput.micromaps = in.micromaps;
            const Structure still = makeStructure(stillInput);
            for (int i = 0; i < 400; ++i) {
                const Vec3 o = random.unit() * 3, d = random.point(1) - o;
                const uint32_t flags = i % 3 == 2 ? uint32_t(kRayForceMicromap2State) : 0u;
                const Answer expected = trace(handleOf(still), o, d, flags);
                const Answer a = trace(handleOf(moving), o, d, flags, time);
                ASSERT_EQ(a.hit, expected.hit) << "time " << time << ", ray " << i;
                hits += a.hit;
                anyHits += a.anyHits;
                if (!a.hit)
                    continue;
                EXPECT_EQ(a.state.hit.t, expected.state.hit.t);
                EXPECT_EQ(a.state.hit.primitive, expected.state.hit.primitive);
                EXPECT_EQ(a.state.hit.attributes[0], expected.state.hit.attributes[0]);
                EXPECT_EQ(a.state.hit.attributes[1], expected.state.hit.attributes[1]);
            }
        }
        EXPECT_GT(hits, 400);
        EXPECT_LT(hits, 2400);
        EXPECT_GT(anyHits, 200);
    }
}

// A pipeline without the micromap option treats triangles as if they had no micromaps.
TEST_P(MicromapTrace, PipelinesMustAskForThem) {
    const auto array = makeArray(0, MicromapFormat::kTwoState, {{0}});
    const Mesh mesh = oneTriangle();
    const void* const keys[2] = {mesh.vertices.data(), mesh.vertices.data()};
    for (uint32_t motionKeys : {1u, 2u}) {
        bvh::TriangleInput in = mesh.input();
        in.keyVertices = motionKeys > 1 ? keys : nullptr;
        in.micromaps.indexing = bvh::MicromapIndexing::kLinear;
        in.micromaps.array = array.get();
        bvh::BuildOptions options;
        options.motion = {motionKeys, 0, 0, 1};
        const Structure gas = makeStructure(in, options);
        for (uint32_t ask : {0u, 1u}) {
            launch_.opacityMicromaps = ask;
            const Answer a = trace(handleOf(gas), {0.2f, 0.2f, 1}, {0, 0, -1});
            EXPECT_EQ(a.hit, ask == 0);
            EXPECT_EQ(a.anyHits, ask ? 0 : 1);
        }
    }
}

INSTANTIATE_TEST_SUITE_P(Sets, MicromapTrace,
                         ::testing::Values(bvh::Isa::kBaseline, bvh::Isa::kAvx2, bvh::Isa::kAvx512),
                         [](const auto& info) { return std::string(bvh::isaName(info.param)); });

} // namespace
} // namespace sunstone::devlib
