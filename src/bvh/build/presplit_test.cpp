// SPDX-License-Identifier: Apache-2.0
// Builds with PREFER_FAST_TRACE: split triangles give the hits of whole ones, use at most the
// reported memory, and respect the limits with all options.
#include "bvh/input/build_input.h"
#include "bvh/layout.h"
#include "bvh/testing/meshes.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

namespace sunstone::bvh {
namespace {

using namespace testing;

BuildOptions fastTrace(bool vertices = false) {
    BuildOptions options;
    options.preferFastTrace = true;
    options.allowRandomVertexAccess = vertices;
    return options;
}

// How often each triangle is in a leaf.
std::map<uint32_t, uint32_t> occurrences(const Structure& s) {
    std::map<uint32_t, uint32_t> found;
    const auto* bytes = static_cast<const uint8_t*>(s.block());
    const auto visit = [&](auto& self, NodeRef ref) -> void {
        const uint8_t* at = bytes + offsetOf(ref);
        if ((ref & kNodeTagMask) == kInner) {
            const Node& node = *reinterpret_cast<const Node*>(at);
            for (uint32_t c = 0; c < node.numChildren; ++c)
                self(self, node.children[c]);
            return;
        }
        const auto count = [&](const auto& leaf) {
            for (uint32_t i = 0; i < leaf.count; ++i)
                ++found[leaf.primitive[i]];
        };
        if ((ref & kNodeTagMask) == kLeaf)
            count(*reinterpret_cast<const TriangleLeaf<4>*>(at));
        else
            count(*reinterpret_cast<const TriangleLeaf<8>*>(at));
    };
    visit(visit, headerOf(s.block())->root);
    return found;
}

TEST(Presplit, AnswersAreThoseOfWholeTriangles) {
    for (uint32_t count : {1u, 2u, 7u, 100u, 5000u, 40000u}) {
        const Mesh mesh = needles(count, count);
        const Structure split = makeStructure(mesh.input(), fastTrace(true));
        const Structure whole = makeStructure(mesh.input());
        EXPECT_EQ(headerOf(split.block())->numActive, count);
        uint32_t hits = 0;
        Random random(count);
        for (int i = 0; i < 20000; ++i) {
            // Half of the rays aim at triangles, near edges and corners too.
            const Vec3 o = random.point(2);
            Vec3 d = random.unit();
            if (i % 2) {
                const Vec3* v = &mesh.vertices[3 * random.below(count)];
                const float a = random(0, 1), b = i % 4 == 1 ? 0 : random(0, 1 - a);
                d = v[0] * (1 - a - b) + v[1] * a + v[2] * b - o;
            }
            const QueryRay ray = {{o.x, o.y, o.z}, 0, {d.x, d.y, d.z}, 100};
            QueryHit x{}, y{};
            const bool hit = kernels(chosenIsa()).closest(whole.block(), ray, x);
            hits += hit;
            ASSERT_EQ(hit, kernels(chosenIsa()).closest(split.block(), ray, y)) << i;
            ASSERT_EQ(hit, kernels(chosenIsa()).occluded(split.block(), ray)) << i;
            ASSERT_EQ(x.primitive, y.primitive) << i;
            ASSERT_EQ(x.t, y.t) << i;
        }
        EXPECT_GT(hits, 4000u);
        const auto found = occurrences(split);
        EXPECT_EQ(found.size(), count);
        if (count >= 100) {
            uint64_t total = 0;
            for (const auto& [primitive, times] : found)
                total += times;
            EXPECT_GT(total, uint64_t(count) * 5 / 4);
            EXPECT_LE(total, uint64_t(count) * 2);
        }
        for (uint32_t i = 0; i < count; ++i) {
            float v[9];
            ASSERT_TRUE(triangleVertices(split.block(), i, 0, v));
            ASSERT_EQ(std::memcmp(v, &mesh.vertices[3 * i], sizeof v), 0);
        }
    }
}

// Parts overlap by the padding, so that rounding in a ray's box tests loses no point of a triangle.
TEST(Presplit, PartsReachBeyondTheirPointsByThePadding) {
    constexpr uint32_t kCount = 300;
    const Mesh mesh = needles(kCount, 8);
    const Structure s = makeStructure(mesh.input(), fastTrace());
    std::multimap<uint32_t, std::array<float, 6>> boxes; // of leaves, by triangle
    const auto* bytes = static_cast<const uint8_t*>(s.block());
    const auto visit = [&](auto& self, const Node& node) -> void {
        for (uint32_t c = 0; c < node.numChildren; ++c) {
            const uint8_t* at = bytes + offsetOf(node.children[c]);
            if ((node.children[c] & kNodeTagMask) == kInner) {
                self(self, *reinterpret_cast<const Node*>(at));
                continue;
            }
            std::array<float, 6> box;
            for (int plane = 0; plane < 6; ++plane)
                box[plane] = node.planes[plane][c];
            const auto add = [&](const auto& leaf) {
                for (uint32_t i = 0; i < leaf.count; ++i)
                    boxes.emplace(leaf.primitive[i], box);
            };
            if ((node.children[c] & kNodeTagMask) == kLeaf)
                add(*reinterpret_cast<const TriangleLeaf<4>*>(at));
            else
                add(*reinterpret_cast<const TriangleLeaf<8>*>(at));
        }
    };
    visit(visit, *reinterpret_cast<const Node*>(bytes + offsetOf(headerOf(s.block())->root)));
    ASSERT_GT(boxes.size(), kCount * 5 / 4);
    uint32_t bare = 0;
    for (uint32_t t = 0; t < kCount; ++t) {
        const Vec3* v = &mesh.vertices[3 * t];
        float size = 0;
        for (int a = 0; a < 3; ++a)
            size = std::max({size, std::abs(v[1][a] - v[0][a]), std::abs(v[2][a] - v[0][a])});
        const float pad = 0.5f * boxPadding(size);
        for (int i = 0; i <= 1000; ++i) {
            const Vec3 p = v[0] + (v[1] - v[0]) * (float(i) / 1000);
            const auto [begin, end] = boxes.equal_range(t);
            bare += std::none_of(begin, end, [&](const auto& entry) {
                const auto& box = entry.second;
                bool inside = true;
                for (int a = 0; a < 3; ++a)
                    inside &= box[2 * a] <= p[a] - pad && p[a] + pad <= box[2 * a + 1];
                return inside;
            });
        }
    }
    EXPECT_EQ(bare, 0u);
}

TEST(Presplit, SingleAnyHitTrianglesStayWhole) {
    const Mesh mesh = needles(3000, 5);
    const uint32_t flags[2] = {kGeometryRequireSingleAnyHit, 0};
    std::vector<uint8_t> records(3000);
    for (uint32_t i = 0; i < 3000; ++i)
        records[i] = i % 2;
    TriangleInput in = mesh.input();
    in.sbt = {flags, 2, records.data(), 1, 0, 0};
    uint32_t split = 0;
    for (const auto& [primitive, times] : occurrences(makeStructure(in, fastTrace()))) {
        if (primitive % 2 == 0) {
            EXPECT_EQ(times, 1u);
        }
        split += times > 1;
    }
    EXPECT_GT(split, 500u);
}

TEST(Presplit, NeitherWithUpdatesNorForCompactTriangles) {
    const Mesh mesh = needles(1000, 5);
    BuildOptions options = fastTrace();
    options.allowUpdate = true;
    for (const auto& [primitive, times] : occurrences(makeStructure(mesh.input(), options)))
        EXPECT_EQ(times, 1u);
    for (const auto& [primitive, times] :
         occurrences(makeStructure(icosphere(3).input(), fastTrace())))
        EXPECT_EQ(times, 1u);
}

// A height field of steep triangles: ordinary ones, whose boxes splitting cannot improve.
TEST(Presplit, LeavesTerrainAlone) {
    Mesh mesh;
    const uint32_t side = 60;
    for (uint32_t y = 0; y < side; ++y)
        for (uint32_t x = 0; x < side; ++x)
            mesh.vertices.push_back({float(x), float(y), float((x * 7 + y * 13) % 5)});
    for (uint32_t y = 0; y + 1 < side; ++y)
        for (uint32_t x = 0; x + 1 < side; ++x) {
            const uint32_t i = y * side + x;
            mesh.triangles.push_back({i, i + 1, i + side});
            mesh.triangles.push_back({i + side, i + 1, i + side + 1});
        }
    for (const auto& [primitive, times] : occurrences(makeStructure(mesh.input(), fastTrace())))
        EXPECT_EQ(times, 1u);
}

TEST(Presplit, IsTheSameForAnyNumberOfThreads) {
    const Mesh mesh = needles(100000, 3);
    const Structure first = makeStructure(mesh.input(), fastTrace(true));
    for (size_t threads : {1, 2, 5}) {
        tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
        EXPECT_TRUE(makeStructure(mesh.input(), fastTrace(true)) == first) << threads;
    }
}

// The limits that the OptiX shell reports, with each combination of options.
TEST(Limits, HoldForAllOptions) {
    for (uint32_t bits = 0; bits < 32; ++bits) {
        BuildOptions options;
        options.allowUpdate = bits & 1;
        options.allowRandomVertexAccess = bits & 2;
        options.preferFastTrace = bits & 4;
        options.preferFastBuild = (bits & 12) == 8;
        options.allowRandomInstanceAccess = bits & 16;
        TriangleInput triangles;
        triangles.numVertices = 240'000'000;
        CustomInput customs;
        customs.numPrimitives = 80'000'000;
        InstanceInput instances;
        instances.numInstances = 1u << 26;
        BuildInputs inputs;
        inputs.triangles = {&triangles, 1};
        EXPECT_NO_THROW(computeMemoryUsage(inputs, options));
        inputs = {};
        inputs.customs = {&customs, 1};
        EXPECT_NO_THROW(computeMemoryUsage(inputs, options));
        inputs = {};
        inputs.instances = &instances;
        EXPECT_NO_THROW(computeMemoryUsage(inputs, options));
    }
}

} // namespace
} // namespace sunstone::bvh
