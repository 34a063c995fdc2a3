// SPDX-License-Identifier: Apache-2.0
// Updates must give the hits of builds of the same input, and must not change the block if nothing
// moved.
#include "base/error.h"
#include "bvh/layout.h"
#include "bvh/refit/instance_paths.h"
#include "bvh/testing/meshes.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

namespace sunstone::bvh {
namespace {

using namespace testing;

BuildOptions updatable(bool fastBuild = false) {
    BuildOptions options;
    options.allowUpdate = true;
    options.preferFastBuild = fastBuild;
    return options;
}

BuildInputs of(const TriangleInput& input) {
    BuildInputs inputs;
    inputs.triangles = {&input, 1};
    return inputs;
}

void updateNow(const Structure& s, const BuildInputs& inputs, const BuildOptions& options) {
    const MemoryUsage usage = computeMemoryUsage(inputs, options);
    ASSERT_GT(usage.tempUpdate, 0u);
    const auto temp = alignedBuffer(usage.tempUpdate);
    update(inputs, options, temp.get(), usage.tempUpdate, s.memory.get(), s.size);
}

// Compares the hits of random rays; returns the number of hits.
uint32_t compareRays(const Structure& a, const Structure& b, uint32_t seed, float extent) {
    Random random(seed);
    uint32_t hits = 0;
    for (int i = 0; i < 3000; ++i) {
        const Vec3 o = random.point(extent), d = random.unit();
        const QueryRay ray = {{o.x, o.y, o.z}, 0, {d.x, d.y, d.z}, 100};
        QueryHit x{}, y{};
        const bool hit = kernels(chosenIsa()).closest(a.block(), ray, x);
        EXPECT_EQ(hit, kernels(chosenIsa()).closest(b.block(), ray, y)) << i;
        EXPECT_EQ(x.primitive, y.primitive) << i;
        EXPECT_EQ(x.t, y.t) << i;
        EXPECT_EQ(x.sbt, y.sbt) << i;
        hits += hit;
    }
    return hits;
}

void expectSameBounds(const Structure& a, const Structure& b) {
    const Box x = bounds(a.block()), y = bounds(b.block());
    for (int i = 0; i < 3; ++i) {
        EXPECT_EQ(x.lower[i], y.lower[i]);
        EXPECT_EQ(x.upper[i], y.upper[i]);
    }
    EXPECT_EQ(headerOf(a.block())->numActive, headerOf(b.block())->numActive);
}

TEST(Update, WithoutChangesLeavesEveryByte) {
    for (bool fast : {false, true})
        for (uint32_t count : {0u, 1u, 3u, 8u, 9u, 700u, 60000u}) {
            Mesh mesh = soup(count, 0.05f, count + 1);
            for (uint32_t i = 0; i < count; i += 7) // some inactive
                mesh.vertices[3 * i + 1] = mesh.vertices[3 * i];
            const TriangleInput in = mesh.input();
            const Structure s = makeStructure(in, updatable(fast));
            const Structure before = makeStructure(in, updatable(fast));
            ASSERT_TRUE(before == s);
            updateNow(s, of(in), updatable(fast));
            EXPECT_TRUE(before == s) << count;
        }
}

TEST(Update, FollowsMovingVertices) {
    for (bool fast : {false, true})
        for (uint32_t count : {1u, 5u, 40u, 3000u, 100000u}) {
            Mesh mesh = soup(count, 0.08f, count);
            const TriangleInput in = mesh.input();
            const Structure s = makeStructure(in, updatable(fast));
            Random random(count);
            for (Vec3& v : mesh.vertices)
                v = Vec3{v.y, v.z, v.x * 1.5f} + random.point(0.02f);
            updateNow(s, of(in), updatable(fast));
            const Structure judge = makeStructure(in);
            expectSameBounds(s, judge);
            EXPECT_EQ(compareRays(s, judge, count, 1.5f) > 100, count >= 3000) << count;
        }
}

TEST(Update, PrimitivesBecomeActiveAndInactive) {
    Mesh mesh = soup(2000, 0.1f, 5);
    const Mesh whole = mesh;
    for (uint32_t i = 0; i < 2000; ++i)
        if (i % 3 == 0 || i < 500)
            mesh.vertices[3 * i] = {NAN, 0, 0};
    const TriangleInput in = mesh.input();
    for (bool fast : {false, true}) {
        BuildOptions options = updatable(fast);
        options.allowRandomVertexAccess = true;
        const Mesh start = mesh;
        const Structure s = makeStructure(in, options);
        expectSameBounds(s, makeStructure(in));
        EXPECT_GT(compareRays(s, makeStructure(in), 7, 1), 300u);
        std::copy(whole.vertices.begin(), whole.vertices.end(), mesh.vertices.begin());
        for (uint32_t i = 0; i < 2000; i += 5)
            mesh.triangles[i][2] = 1u << 30;
        updateNow(s, of(in), options);
        const Structure judge = makeStructure(in);
        EXPECT_EQ(headerOf(s.block())->numActive, 1600u);
        expectSameBounds(s, judge);
        EXPECT_GT(compareRays(s, judge, 8, 1), 300u);
        float v[9];
        ASSERT_TRUE(triangleVertices(s.block(), 5, 0, v));
        EXPECT_TRUE(std::isnan(v[0]));
        ASSERT_TRUE(triangleVertices(s.block(), 6, 0, v));
        EXPECT_EQ(v[4], whole.vertices[19].y);
        std::copy(start.vertices.begin(), start.vertices.end(), mesh.vertices.begin());
        std::copy(start.triangles.begin(), start.triangles.end(), mesh.triangles.begin());
    }
}

TEST(Update, AllInactiveAndBack) {
    Mesh mesh = soup(100, 0.3f, 3);
    const std::vector<Vec3> good = mesh.vertices;
    const TriangleInput in = mesh.input();
    std::fill(mesh.vertices.begin(), mesh.vertices.end(), Vec3{INFINITY, 0, 0});
    const Structure s = makeStructure(in, updatable());
    EXPECT_EQ(headerOf(s.block())->numActive, 0u);
    EXPECT_TRUE(bounds(s.block()).empty());
    EXPECT_EQ(compareRays(s, makeStructure(in), 4, 1), 0u);
    std::copy(good.begin(), good.end(), mesh.vertices.begin());
    updateNow(s, of(in), updatable());
    EXPECT_GT(compareRays(s, makeStructure(in), 4, 1), 300u);
    std::fill(mesh.vertices.begin(), mesh.vertices.end(), Vec3{INFINITY, 0, 0});
    updateNow(s, of(in), updatable());
    EXPECT_TRUE(bounds(s.block()).empty());
    EXPECT_EQ(compareRays(s, makeStructure(in), 4, 1), 0u);
}

TEST(Update, SeveralInputsKeepTheirRecordsAndOffsets) {
    Mesh meshes[3] = {soup(300, 0.1f, 1), soup(50, 0.3f, 2), soup(900, 0.1f, 3)};
    std::vector<uint16_t> records(900);
    for (uint32_t i = 0; i < 900; ++i)
        records[i] = uint16_t(i % 4);
    const uint32_t flags[4] = {0, 1, 2, 1};
    TriangleInput in[3];
    for (uint32_t k = 0; k < 3; ++k) {
        in[k] = meshes[k].input();
        in[k].sbt = {flags, k + 2, nullptr, 0, 0, 5000 * (2 - k)};
    }
    in[2].sbt.indexOffsets = records.data();
    in[2].sbt.indexOffsetSize = 2;
    const float transform[12] = {0.5f, 0, 0, 1, 0, 1, 0, 0, 0, 0, 2, 0};
    BuildInputs inputs;
    inputs.triangles = in;
    const Structure s = makeStructure(inputs, updatable());
    for (Mesh& mesh : meshes)
        for (Vec3& v : mesh.vertices)
            v = {v.z, v.x, v.y};
    for (uint16_t& r : records)
        r = uint16_t(3 - r);
    in[1].preTransform = transform;
    updateNow(s, inputs, updatable());
    const Structure judge = makeStructure(inputs);
    expectSameBounds(s, judge);
    EXPECT_GT(compareRays(s, judge, 9, 1), 300u);
}

TEST(Update, IsTheSameForAnyNumberOfThreads) {
    Mesh mesh = soup(150000, 0.02f, 3);
    const std::vector<Vec3> start = mesh.vertices;
    const TriangleInput in = mesh.input();
    Structure first;
    for (size_t threads : {1, 2, 5}) {
        tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
        std::copy(start.begin(), start.end(), mesh.vertices.begin());
        const Structure s = makeStructure(in, updatable());
        for (Vec3& v : mesh.vertices)
            v = v * 1.25f + Vec3{0, 1, 0};
        updateNow(s, of(in), updatable());
        if (!first.memory)
            first = s;
        EXPECT_TRUE(s == first) << threads;
    }
}

TEST(Update, CustomPrimitives) {
    for (uint32_t count : {1u, 2u, 500u}) {
        Random random(count);
        std::vector<float> boxes(6 * count);
        const auto place = [&](uint32_t dropped) {
            for (uint32_t i = 0; i < count; ++i)
                for (uint32_t a = 0; a < 3; ++a) {
                    boxes[6 * i + a] = random(-5, 5);
                    boxes[6 * i + 3 + a] = boxes[6 * i + a] + (i % 4 == dropped ? -1.0f : 0.2f);
                }
        };
        CustomInput in;
        in.aabbs = boxes.data();
        in.numPrimitives = count;
        in.sbt.primitiveIndexOffset = 77;
        BuildInputs inputs;
        inputs.customs = {&in, 1};
        place(0);
        const Structure s = makeStructure(inputs, updatable());
        for (uint32_t dropped : {1u, 9u, 0u}) {
            place(dropped);
            updateNow(s, inputs, updatable());
            expectSameBounds(s, makeStructure(inputs));
            if (headerOf(s.block())->numActive == 0) {
                EXPECT_EQ(headerOf(s.block())->root, kNoNode);
            }
            // Every primitive is in one leaf, inside the boxes above it.
            std::vector<uint32_t> found(count);
            const auto* bytes = static_cast<const uint8_t*>(s.block());
            const auto visit = [&](auto& self, NodeRef ref, const float* box) -> void {
                if ((ref & kNodeTagMask) == kInner) {
                    const Node& node = *reinterpret_cast<const Node*>(bytes + offsetOf(ref));
                    for (uint32_t c = 0; c < node.numChildren; ++c) {
                        float child[6];
                        for (int k = 0; k < 6; ++k)
                            child[k] = node.planes[k][c];
                        self(self, node.children[c], child);
                    }
                    return;
                }
                const auto& leaf = *reinterpret_cast<const CustomLeaf*>(bytes + offsetOf(ref));
                const uint32_t i = leaf.primitive - 77;
                ASSERT_LT(i, count);
                ++found[i];
                if (i % 4 == dropped) {
                    EXPECT_TRUE(!box || box[0] > box[1]);
                    return;
                }
                for (uint32_t a = 0; a < 3; ++a) {
                    EXPECT_EQ(leaf.lower[a], boxes[6 * i + a]);
                    if (box) {
                        EXPECT_LE(box[2 * a], boxes[6 * i + a]);
                        EXPECT_GE(box[2 * a + 1], boxes[6 * i + 3 + a]);
                    }
                }
            };
            visit(visit, headerOf(s.block())->wholeRoot, nullptr);
            EXPECT_EQ(std::count(found.begin(), found.end(), 1u), ptrdiff_t(count));
        }
    }
}

TEST(Update, Instances) {
    const Structure child = makeStructure(cube().input()),
                    other = makeStructure(icosphere(1).input());
    for (uint32_t count : {1u, 3u, 400u}) {
        Random random(count);
        std::vector<InstanceDesc> list(count);
        const auto place = [&](uint32_t hidden) {
            for (uint32_t i = 0; i < count; ++i) {
                const Vec3 at = random.point(50);
                list[i] = {{1, 0, 0, at.x, 0, random(1, 2), 0, at.y, 0, 0, 1, at.z},
                           100 + i,
                           i,
                           i % 4 == hidden ? 0u : 255u,
                           0,
                           traversableHandle(random(0, 1) < 0.5f ? child.block() : other.block()),
                           {}};
            }
        };
        place(2);
        InstanceInput in;
        in.instances = list.data();
        in.numInstances = count;
        BuildInputs inputs;
        inputs.instances = &in;
        const Structure s = makeStructure(inputs, updatable());
        for (uint32_t hidden : {1u, 0u, 9u}) {
            place(hidden);
            updateNow(s, inputs, updatable());
            const Structure judge = makeStructure(inputs);
            expectSameBounds(s, judge);
            for (uint32_t i = 0; i < count; ++i)
                EXPECT_EQ(std::memcmp(instanceRecord(s.block(), i),
                                      instanceRecord(judge.block(), i), sizeof(InstanceRecord)),
                          0);
        }
    }
}

InstanceDesc placed(const Structure& child, const Vec3& at, uint32_t mask = 255) {
    return {{1, 0, 0, at.x, 0, 1, 0, at.y, 0, 0, 1, at.z},
            0,
            0,
            mask,
            0,
            traversableHandle(child.block()),
            {}};
}

TEST(InstancePaths, LeaveTheBytesOfAWholeUpdate) {
    const Structure child = makeStructure(cube().input());
    for (const uint32_t count : {1u, 2u, 9u, 3000u}) {
        Random random(count);
        std::vector<InstanceDesc> list;
        for (uint32_t i = 0; i < count; ++i)
            list.push_back(placed(child, random.point(50), i % 5 == 4 ? 0u : 255u));
        InstanceInput in;
        in.instances = list.data();
        in.numInstances = count;
        BuildInputs inputs;
        inputs.instances = &in;
        const Structure few = makeStructure(inputs, updatable());
        const Structure whole = makeStructure(inputs, updatable());
        InstancePaths paths(few.block());
        for (int round = 0; round < 20; ++round) {
            std::vector<uint32_t> changed;
            for (int i = 0; i < 3; ++i) {
                changed.push_back(random.below(count));
                list[changed.back()] =
                    placed(child, random.point(80), random.below(3) == 0 ? 0u : 255u);
            }
            paths.refit(few.memory.get(), in, changed);
            updateNow(whole, inputs, updatable());
            const BlockHeader &a = *headerOf(few.block()), &b = *headerOf(whole.block());
            const auto* bytesOfFew = static_cast<const uint8_t*>(few.block());
            const auto* bytesOfWhole = static_cast<const uint8_t*>(whole.block());
            EXPECT_EQ(std::memcmp(bytesOfFew + sizeof(BlockHeader),
                                  bytesOfWhole + sizeof(BlockHeader),
                                  few.size - sizeof(BlockHeader)),
                      0);
            EXPECT_EQ(a.root, b.root);
            EXPECT_EQ(a.numActive, b.numActive);
            for (int axis = 0; b.numActive && axis < 3; ++axis) {
                EXPECT_LE(a.lower[axis], b.lower[axis]);
                EXPECT_GE(a.upper[axis], b.upper[axis]);
                EXPECT_NEAR(a.lower[axis], b.lower[axis], 1e-3);
                EXPECT_NEAR(a.upper[axis], b.upper[axis], 1e-3);
            }
        }
    }
}

TEST(InstancePaths, MeasureHowTheTreeDegrades) {
    const Structure child = makeStructure(cube().input());
    Random random(3);
    std::vector<InstanceDesc> list;
    for (uint32_t i = 0; i < 1000; ++i)
        list.push_back(placed(child, random.point(50)));
    InstanceInput in;
    in.instances = list.data();
    in.numInstances = 1000;
    BuildInputs inputs;
    inputs.instances = &in;
    const Structure s = makeStructure(inputs, updatable());
    InstancePaths paths(s.block());
    EXPECT_EQ(paths.degradation(), 1);
    std::vector<uint32_t> all;
    for (uint32_t i = 0; i < 1000; ++i) {
        all.push_back(i);
        list[i].transform[3] += 5; // as a whole
    }
    paths.refit(s.memory.get(), in, all);
    EXPECT_NEAR(paths.degradation(), 1, 1e-3);
    for (uint32_t i = 0; i < 1000; ++i)
        list[i] = placed(child, random.point(50));
    paths.refit(s.memory.get(), in, all);
    EXPECT_GT(paths.degradation(), 2);
    const Structure still = makeStructure(inputs);
    EXPECT_THROW(InstancePaths{still.block()}, Error);
    EXPECT_THROW(InstancePaths{child.block()}, Error);
}

template <class Body>
std::string errorOf(const Body& body) {
    try {
        body();
    } catch (const Error& error) {
        EXPECT_EQ(error.code(), Code::kInvalidValue);
        return error.what();
    }
    return "";
}

TEST(Update, OtherShapesAreErrors) {
    const Mesh mesh = soup(10, 0.1f, 8);
    const TriangleInput good = mesh.input();
    const Structure s = makeStructure(good, updatable());
    const auto temp = alignedBuffer(4096);
    const auto attempt = [&](const TriangleInput& in, const BuildOptions& options,
                             const Structure& target, size_t tempSize, size_t size) {
        return errorOf(
            [&] { update(of(in), options, temp.get(), tempSize, target.memory.get(), size); });
    };
    EXPECT_EQ(attempt(good, updatable(), s, 4096, s.size), "");
    EXPECT_NE(attempt(good, updatable(), s, 0, s.size), "");
    EXPECT_NE(attempt(good, updatable(), s, 4096, s.size - 1), "");
    EXPECT_NE(attempt(good, {}, s, 4096, s.size), "");
    EXPECT_NE(attempt(good, updatable(true), s, 4096, s.size), "");
    const Structure fixed = makeStructure(good);
    EXPECT_NE(attempt(good, updatable(), fixed, 4096, fixed.size), "");
    TriangleInput bad = good;
    bad.numTriangles = 9;
    EXPECT_NE(attempt(bad, updatable(), s, 4096, s.size), "");
    bad = good;
    bad.numVertices = 29;
    EXPECT_NE(attempt(bad, updatable(), s, 4096, s.size), "");
    bad = good;
    bad.vertexFormat = VertexFormat::kFloat2;
    EXPECT_NE(attempt(bad, updatable(), s, 4096, s.size), "");
    const uint32_t flags[2] = {1, 1};
    bad = good;
    bad.sbt.flags = flags;
    EXPECT_NE(attempt(bad, updatable(), s, 4096, s.size), "");
    bad.sbt = {nullptr, 2, nullptr, 0, 0, 0};
    EXPECT_NE(attempt(bad, updatable(), s, 4096, s.size), "");
    bad.sbt = {nullptr, 1, nullptr, 0, 0, 3};
    EXPECT_NE(attempt(bad, updatable(), s, 4096, s.size), "");
    CustomInput custom;
    custom.numPrimitives = 10;
    BuildInputs customs;
    customs.customs = {&custom, 1};
    EXPECT_NE(
        errorOf([&] { update(customs, updatable(), temp.get(), 4096, s.memory.get(), s.size); }),
        "");
    const auto nothing = alignedBuffer(4096);
    std::memset(nothing.get(), 0, 4096);
    EXPECT_NE(
        errorOf([&] { update(of(good), updatable(), temp.get(), 4096, nothing.get(), 4096); }), "");
    EXPECT_EQ(computeMemoryUsage(of(good), {}).tempUpdate, 0u);
}

} // namespace
} // namespace sunstone::bvh
