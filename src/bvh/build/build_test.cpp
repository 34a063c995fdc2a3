// SPDX-License-Identifier: Apache-2.0
// Builders: all vertex and index formats, SBT data, inactive primitives, sizes, compaction,
// determinism, several inputs, custom primitives, instances, bad arguments.
#include "bvh/build/build.h"

#include "base/error.h"
#include "bvh/layout.h"
#include "bvh/testing/meshes.h"
#include "math/affine.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <set>

namespace sunstone::bvh {
namespace {

using namespace testing;

QueryRay down(float x, float y) {
    return {{x, y, 10}, 0, {0, 0, -1}, 100};
}

bool hitAt(const Structure& s, float x, float y, QueryHit* hit = nullptr) {
    QueryHit h{};
    const bool found = kernels(chosenIsa()).closest(s.block(), down(x, y), h);
    if (hit)
        *hit = h;
    return found;
}

// Checks that every primitive of the block is in exactly one leaf, that children are inside their
// boxes, and that the depth is bounded.
struct Walk {
    const uint8_t* block;
    std::multiset<uint32_t> primitives;
    uint32_t nodes = 0, depth = 0;

    void leafTriangles(NodeRef ref, Box box) {
        const bool wide = (ref & kNodeTagMask) == kWideLeaf;
        const auto* data = block + offsetOf(ref);
        const uint32_t lanes = wide ? 8 : 4;
        const auto* v = reinterpret_cast<const float*>(data);
        const auto* prim = reinterpret_cast<const uint32_t*>(data) + 9 * lanes;
        const uint32_t count = prim[2 * lanes];
        EXPECT_LE(count, lanes);
        for (uint32_t i = 0; i < count; ++i) {
            primitives.insert(prim[i]);
            for (uint32_t k = 0; k < 9; ++k) {
                EXPECT_GE(v[k * lanes + i], box.lower[int(k % 3)]);
                EXPECT_LE(v[k * lanes + i], box.upper[int(k % 3)]);
            }
        }
    }
    void visit(NodeRef ref, Box box, uint32_t level) {
        depth = std::max(depth, level);
        if ((ref & kNodeTagMask) != kInner) {
            leafTriangles(ref, box);
            return;
        }
        ++nodes;
        const Node& node = *reinterpret_cast<const Node*>(block + offsetOf(ref));
        for (uint32_t i = 0; i < 8; ++i) {
            if (i >= node.numChildren) {
                EXPECT_EQ(node.children[i], kNoNode);
                EXPECT_GT(node.planes[0][i], node.planes[1][i]);
                continue;
            }
            Box child;
            for (int a = 0; a < 3; ++a) {
                child.lower[a] = node.planes[2 * a][i];
                child.upper[a] = node.planes[2 * a + 1][i];
                EXPECT_GE(child.lower[a], box.lower[a]);
                EXPECT_LE(child.upper[a], box.upper[a]);
            }
            visit(node.children[i], child, level + 1);
        }
    }
};

Walk walk(const Structure& s) {
    Walk w{static_cast<const uint8_t*>(s.block()), {}, 0, 0};
    const BlockHeader& header = *headerOf(s.block());
    Box all;
    all.lower = {-1e37f, -1e37f, -1e37f};
    all.upper = {1e37f, 1e37f, 1e37f};
    if (header.root != kNoNode)
        w.visit(header.root, all, 1);
    EXPECT_EQ(w.primitives.size(), header.numActive);
    EXPECT_LE(w.depth, kMaxDepth);
    return w;
}

TEST(Build, TreesHoldEveryPrimitiveOnce) {
    for (bool fast : {false, true})
        for (uint32_t count : {1u, 2u, 3u, 4u, 5u, 7u, 8u, 9u, 16u, 33u, 1000u, 20000u, 150000u}) {
            BuildOptions options;
            options.preferFastBuild = fast;
            const Structure s = makeStructure(soup(count, 0.05f, count).input(), options);
            const Walk w = walk(s);
            ASSERT_EQ(w.primitives.size(), count);
            ASSERT_EQ(std::set<uint32_t>(w.primitives.begin(), w.primitives.end()).size(), count);
            EXPECT_EQ(w.nodes, headerOf(s.block())->numNodes);
        }
}

// Input that defeats splitting: equal centroids, exponential spacing, one line.
TEST(Build, PathologicalInputStaysShallowAndWithinBounds) {
    std::vector<Mesh> meshes(4);
    for (uint32_t i = 0; i < 5000; ++i) {
        const float grow = std::exp2(float(i % 180) - 90), at = float(i);
        const Vec3 shapes[4][3] = {{{-1, -1, 0}, {1, -1, 0}, {0, 1, 0}},
                                   {{-grow, -grow, 0}, {grow, -grow, 0}, {0, grow, 0}},
                                   {{grow, 0, 0}, {grow * 1.5f, grow, 0}, {grow, 0, grow}},
                                   {{at, 0, 0}, {at + 5000, 0, 0}, {at, 1, 0}}};
        for (int m = 0; m < 4; ++m) {
            for (const Vec3& v : shapes[m])
                meshes[size_t(m)].vertices.push_back(v);
            meshes[size_t(m)].triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
        }
    }
    for (const Mesh& mesh : meshes)
        for (bool fast : {false, true}) {
            BuildOptions options;
            options.preferFastBuild = fast;
            const Structure s = makeStructure(mesh.input(), options);
            EXPECT_EQ(walk(s).primitives.size(), 5000u);
        }
}

TEST(Build, IsTheSameForAnyNumberOfThreads) {
    const Mesh mesh = soup(200000, 0.02f, 3);
    for (bool fast : {false, true}) {
        BuildOptions options;
        options.preferFastBuild = fast;
        options.allowRandomVertexAccess = true;
        const Structure first = makeStructure(mesh.input(), options);
        for (size_t threads : {1, 2, 5}) {
            tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
            EXPECT_TRUE(makeStructure(mesh.input(), options) == first) << threads;
        }
    }
}

TEST(Build, VertexFormats) {
    // A triangle with corners (0,0), (1,0), (0,1) in the plane z = 0.5 (or 0).
    const float f3[] = {0, 0, 0.5f, 1, 0, 0.5f, 0, 1, 0.5f}, f2[] = {0, 0, 1, 0, 0, 1};
    const uint16_t one = 0x3C00, half = 0x3800;
    const uint16_t h3[] = {0, 0, half, one, 0, half, 0, one, half}, h2[] = {0, 0, one, 0, 0, one};
    const int16_t s3[] = {0, 0, 16384, 32767, 0, 16384, 0, 32767, 16384};
    const int16_t s2[] = {0, 0, 32767, 0, 0, 32767};
    const struct {
        VertexFormat format;
        const void* data;
        float z;
    } cases[] = {{VertexFormat::kFloat3, f3, 0.5f},    {VertexFormat::kFloat2, f2, 0},
                 {VertexFormat::kHalf3, h3, 0.5f},     {VertexFormat::kHalf2, h2, 0},
                 {VertexFormat::kSnorm16x3, s3, 0.5f}, {VertexFormat::kSnorm16x2, s2, 0}};
    for (const auto& c : cases) {
        TriangleInput in;
        in.vertices = c.data;
        in.vertexFormat = c.format;
        in.numVertices = 3;
        const Structure s = makeStructure(in);
        QueryHit hit;
        ASSERT_TRUE(hitAt(s, 0.25f, 0.5f, &hit)) << uint32_t(c.format);
        EXPECT_NEAR(10 - hit.t, c.z, 1e-4f);
        EXPECT_NEAR(hit.u, 0.25f, 1e-5f);
        EXPECT_NEAR(hit.v, 0.5f, 1e-5f);
        EXPECT_FALSE(hitAt(s, 0.6f, 0.6f));
    }
}

TEST(Build, HalfSpecialsAndSnormMinimum) {
    const uint16_t inf = 0x7C00, nan = 0x7E01, minusTwo = 0xC000, tiny = 0x0001;
    const uint16_t words[] = {inf, 0,      0, 0,    0,      nan, 0,    0, minusTwo,
                              0,   0x4000, 0, tiny, 0x4000, 0,   tiny, 0, 0};
    TriangleInput in;
    in.vertices = words;
    in.vertexFormat = VertexFormat::kHalf3;
    in.numVertices = 6;
    EXPECT_EQ(headerOf(makeStructure(in).block())->numActive, 1u);
    const int16_t lowest[] = {-32768, 0, 0, 32767, -32767, 0, 0, 32767, 0};
    in.vertices = lowest;
    in.vertexFormat = VertexFormat::kSnorm16x3;
    in.numVertices = 3;
    EXPECT_EQ(bounds(makeStructure(in).block()).lower.x, -1.0f);
}

TEST(Build, IndicesStridesAndTransform) {
    struct Vertex {
        uint8_t head[8];
        float p[3];
        uint8_t tail[4];
    } vertices[4] = {
        {{}, {0, 0, 0}, {}}, {{}, {1, 0, 0}, {}}, {{}, {0, 1, 0}, {}}, {{}, {1, 1, 0}, {}}};
    const uint16_t shorts[] = {0, 1, 2, 99, 1, 3, 2, 99};
    TriangleInput in;
    in.vertices = vertices[0].p;
    in.vertexStride = sizeof(Vertex);
    in.numVertices = 4;
    in.indices = shorts;
    in.indexFormat = IndexFormat::kUshort3;
    in.indexStride = 8;
    in.numTriangles = 2;
    const float transform[12] = {2, 0, 0, 10, 0, 1, 0, 0, 0, 0, 1, 3};
    for (const float* m : {static_cast<const float*>(nullptr), transform}) {
        in.preTransform = m;
        const Structure s = makeStructure(in);
        QueryHit hit;
        ASSERT_TRUE(hitAt(s, m ? 10.4f : 0.2f, 0.2f, &hit));
        EXPECT_EQ(hit.primitive, 0u);
        EXPECT_FLOAT_EQ(hit.t, m ? 7 : 10);
        ASSERT_TRUE(hitAt(s, m ? 11.8f : 0.9f, 0.9f, &hit));
        EXPECT_EQ(hit.primitive, 1u);
        EXPECT_EQ(bounds(s.block()).upper.x, m ? 12 : 1);
    }
}

TEST(Build, SbtIndicesFlagsAndOffsets) {
    const Mesh mesh = soup(64, 0.5f, 12);
    std::vector<uint8_t> small(64 * 3);
    std::vector<uint16_t> medium(64);
    std::vector<uint32_t> large(64);
    for (uint32_t i = 0; i < 64; ++i) {
        small[3 * i] = uint8_t(i % 5);
        medium[i] = uint16_t(i % 5);
        large[i] = i % 5;
    }
    const uint32_t flags[5] = {0, 1, 2, 3, 0};
    TriangleInput in[3] = {mesh.input(), mesh.input(), mesh.input()};
    const void* offsets[3] = {small.data(), medium.data(), large.data()};
    for (uint32_t k = 0; k < 3; ++k) {
        in[k].sbt.flags = flags;
        in[k].sbt.numSbtRecords = 5;
        in[k].sbt.indexOffsets = offsets[k];
        in[k].sbt.indexOffsetSize = 1u << k;
        in[k].sbt.indexOffsetStride = k == 0 ? 3 : 0;
        in[k].sbt.primitiveIndexOffset = 1000 * k;
    }
    BuildInputs inputs;
    inputs.triangles = in;
    BuildOptions options;
    options.allowRandomVertexAccess = true;
    const Structure s = makeStructure(inputs, options);
    Random random(4);
    uint32_t hits = 0;
    std::set<uint32_t> seen;
    for (int i = 0; i < 3000; ++i) {
        const Vec3 o = random.point(1), d = random.unit();
        QueryHit hit;
        if (!kernels(chosenIsa())
                 .closest(s.block(), {{o.x, o.y, o.z}, 0, {d.x, d.y, d.z}, 10}, hit))
            continue;
        ++hits;
        const uint32_t input = hit.primitive / 1000, local = hit.primitive % 1000;
        seen.insert(input);
        ASSERT_LT(local, 64u);
        EXPECT_EQ(hit.sbt & kSbtIndexMask, 5 * input + local % 5);
        EXPECT_EQ(hit.sbt >> kGeometryFlagShift, flags[local % 5]);
        float v[9];
        ASSERT_TRUE(triangleVertices(s.block(), hit.primitive, hit.sbt & kSbtIndexMask, v));
        for (int k = 0; k < 9; ++k)
            EXPECT_EQ(v[k], mesh.vertices[3 * local + uint32_t(k) / 3][k % 3]);
    }
    EXPECT_GT(hits, 500u);
    EXPECT_EQ(seen.count(0), 1u); // of equal hits the lowest primitive index is reported
    EXPECT_EQ(headerOf(s.block())->numSbtRecords, 15u);
    float v[9];
    EXPECT_FALSE(triangleVertices(s.block(), 64, 0, v));
    EXPECT_FALSE(triangleVertices(s.block(), 999, 5, v));
    EXPECT_FALSE(triangleVertices(s.block(), 0, 15, v));
    EXPECT_FALSE(triangleVertices(makeStructure(mesh.input()).block(), 0, 0, v));
}

TEST(Build, SbtIndexBeyondTheRecordsIsHarmless) {
    const Mesh mesh = soup(4, 0.5f, 12);
    const uint32_t wild[4] = {0, 7, ~0u, 1}, flags[2] = {0, 1};
    TriangleInput in = mesh.input();
    in.sbt = {flags, 2, wild, 4, 0, 0};
    EXPECT_EQ(walk(makeStructure(in)).primitives.size(), 4u);
}

TEST(Build, BadTrianglesAreInactive) {
    Mesh m;
    m.vertices = {{0, 0, 0},        {1, 0, 0}, {0, 1, 0},    {NAN, 0, 0},
                  {0, INFINITY, 0}, {2, 0, 0}, {3e38f, 0, 0}};
    m.triangles = {{0, 1, 2},  {0, 1, 3},   {0, 1, 4}, {0, 1, 5}, {0, 0, 1},
                   {0, 1, 99}, {~0u, 1, 2}, {2, 2, 2}, {0, 2, 6}};
    BuildOptions options;
    options.allowRandomVertexAccess = true;
    for (bool fast : {false, true}) {
        options.preferFastBuild = fast;
        const Structure s = makeStructure(m.input(), options);
        EXPECT_EQ(headerOf(s.block())->numActive, 1u);
        EXPECT_TRUE(hitAt(s, 0.2f, 0.2f));
        const Box box = bounds(s.block());
        EXPECT_EQ(box.lower.x, 0);
        EXPECT_EQ(box.upper.x, 1);
        float v[9];
        EXPECT_TRUE(triangleVertices(s.block(), 1, 0, v));
        EXPECT_TRUE(std::isnan(v[0]));
        EXPECT_TRUE(triangleVertices(s.block(), 0, 0, v));
        EXPECT_EQ(v[3], 1);
    }
}

TEST(Build, EmptyStructuresMiss) {
    TriangleInput none;
    Mesh bad = soup(100, 0.1f, 1);
    for (auto& t : bad.triangles)
        t[1] = 1u << 30;
    for (bool fast : {false, true}) {
        BuildOptions options;
        options.preferFastBuild = fast;
        for (const TriangleInput& in : {none, bad.input()}) {
            const Structure s = makeStructure(in, options);
            EXPECT_FALSE(hitAt(s, 0, 0));
            EXPECT_TRUE(bounds(s.block()).empty());
            EXPECT_TRUE(isBlock(s.block()));
        }
    }
}

TEST(Build, MemoryUsageIsAMonotoneBound) {
    MemoryUsage last;
    for (uint32_t count = 0; count < 400; ++count) {
        TriangleInput in;
        in.numVertices = 3 * count;
        BuildInputs inputs;
        inputs.triangles = {&in, 1};
        const MemoryUsage usage = computeMemoryUsage(inputs, {});
        EXPECT_GE(usage.output, last.output);
        EXPECT_GE(usage.temp, last.temp);
        EXPECT_EQ(usage.output % 128, 0u);
        last = usage;
        const Structure s = makeStructure(soup(count, 0.3f, count).input());
        EXPECT_LE(s.size, usage.output);
    }
    EXPECT_EQ(last.tempUpdate, 0u);
}

TEST(Build, CompactedCopiesAreTheSameAnywhere) {
    const Mesh mesh = soup(3000, 0.1f, 8);
    const Structure s = makeStructure(mesh.input());
    const auto other = alignedBuffer(s.size);
    std::memcpy(other.get(), s.block(), s.size);
    Random random(6);
    for (int i = 0; i < 500; ++i) {
        const Vec3 o = random.point(1), d = random.unit();
        const QueryRay ray = {{o.x, o.y, o.z}, 0, {d.x, d.y, d.z}, 10};
        QueryHit a{}, b{};
        EXPECT_EQ(kernels(chosenIsa()).closest(s.block(), ray, a),
                  kernels(chosenIsa()).closest(other.get(), ray, b));
        EXPECT_EQ(a.primitive, b.primitive);
    }
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

TEST(Build, BadArgumentsAreErrors) {
    const Mesh mesh = soup(10, 0.1f, 8);
    const TriangleInput in = mesh.input();
    BuildInputs inputs;
    EXPECT_NE(errorOf([&] { computeMemoryUsage(inputs, {}); }), "");
    inputs.triangles = {&in, 1};
    const MemoryUsage usage = computeMemoryUsage(inputs, {});
    const auto temp = alignedBuffer(usage.temp), out = alignedBuffer(usage.output);
    const auto attempt = [&](void* t, size_t ts, void* o, size_t os) {
        return errorOf([&] { build(inputs, {}, t, ts, o, os); });
    };
    EXPECT_NE(attempt(nullptr, usage.temp, out.get(), usage.output), "");
    EXPECT_NE(attempt(temp.get(), usage.temp, nullptr, usage.output), "");
    EXPECT_NE(attempt(temp.get(), usage.temp - 1, out.get(), usage.output), "");
    EXPECT_NE(attempt(temp.get(), usage.temp, out.get(), usage.output - 1), "");
    EXPECT_NE(attempt(static_cast<char*>(temp.get()) + 64, usage.temp, out.get(), usage.output),
              "");
    std::memset(out.get(), 0xAB, usage.output);
    EXPECT_NE(errorOf([&] { compactedSize(out.get()); }), "");
    EXPECT_NE(errorOf([&] { bounds(nullptr); }), "");
    EXPECT_EQ(attempt(temp.get(), usage.temp, out.get(), usage.output), "");
    const uint64_t size = compactedSize(out.get());
    const auto small = alignedBuffer(size);
    EXPECT_NE(errorOf([&] { compact(out.get(), small.get(), size - 1); }), "");
    EXPECT_NE(errorOf([&] { compact(out.get(), out.get(), size); }), "");
    EXPECT_NE(errorOf([&] { compact(small.get(), out.get(), size); }), "");
    TriangleInput huge;
    huge.indexFormat = IndexFormat::kUint3;
    huge.numTriangles = ~0u;
    inputs.triangles = {&huge, 1};
    EXPECT_NE(errorOf([&] { computeMemoryUsage(inputs, {}); }), "");
}

TEST(Build, NullBuffersMakeEverythingInactive) {
    TriangleInput in;
    in.numVertices = 30;
    in.indexFormat = IndexFormat::kUint3;
    in.numTriangles = 10;
    EXPECT_FALSE(hitAt(makeStructure(in), 0, 0));
    CustomInput custom;
    custom.numPrimitives = 10;
    BuildInputs inputs;
    inputs.customs = {&custom, 1};
    EXPECT_TRUE(bounds(makeStructure(inputs).block()).empty());
}

TEST(Build, CustomPrimitives) {
    std::vector<std::array<float, 8>> boxes; // stride 32
    Random random(3);
    for (int i = 0; i < 1000; ++i) {
        const Vec3 p = random.point(10);
        boxes.push_back({p.x, p.y, p.z, p.x + 1, p.y + 1, p.z + 1, 0, 0});
    }
    boxes[5][0] = NAN;
    boxes[6][3] = boxes[6][0] - 1;
    boxes[7][4] = INFINITY;
    CustomInput in;
    in.aabbs = boxes.data();
    in.stride = 32;
    in.numPrimitives = 1000;
    in.sbt.primitiveIndexOffset = 7;
    BuildInputs inputs;
    inputs.customs = {&in, 1};
    const Structure s = makeStructure(inputs);
    EXPECT_EQ(headerOf(s.block())->numActive, 997u);
    EXPECT_EQ(traversableHandle(s.block()) & 63, devlib::kTagGas);
    EXPECT_LE(bounds(s.block()).upper.x, 11);
    EXPECT_FALSE(hitAt(s, 0, 0)); // no triangles in it
}

TEST(Build, Instances) {
    const Structure child = makeStructure(cube().input());
    std::vector<InstanceDesc> list(5);
    for (uint32_t i = 0; i < 5; ++i) {
        list[i] = {{1, 0, 0, 10.0f * float(i), 0, 2, 0, 0, 0, 0, 1, 0},
                   100 + i,
                   i,
                   255,
                   0,
                   traversableHandle(child.block()),
                   {}};
    }
    list[1].traversableHandle = 0;
    list[2].visibilityMask = 0;
    list[3].transform[0] = 0; // singular
    InstanceInput in;
    in.instances = list.data();
    in.numInstances = 5;
    BuildInputs inputs;
    inputs.instances = &in;
    const Structure s = makeStructure(inputs);
    const BlockHeader& header = *headerOf(s.block());
    EXPECT_EQ(header.numActive, 2u);
    EXPECT_EQ(header.numPrimitives, 5u);
    EXPECT_EQ(traversableHandle(s.block()) & 63, devlib::kTagIas);
    EXPECT_NEAR(bounds(s.block()).upper.x, 41, 1e-3);
    EXPECT_NEAR(bounds(s.block()).lower.y, -2, 1e-3);
    for (uint32_t i = 0; i < 5; ++i) {
        const auto* record = static_cast<const InstanceRecord*>(instanceRecord(s.block(), i));
        ASSERT_NE(record, nullptr);
        EXPECT_EQ(record->instanceId, 100 + i);
        EXPECT_EQ(record->index, i);
        EXPECT_EQ(uint64_t(record) % 64, 0u);
    }
    const auto* last = static_cast<const InstanceRecord*>(instanceRecord(s.block(), 4));
    EXPECT_FLOAT_EQ(last->worldToObject[3], -40);
    EXPECT_FLOAT_EQ(last->worldToObject[5], 0.5f);
    EXPECT_EQ(instanceRecord(s.block(), 5), nullptr);
    EXPECT_EQ(instanceRecord(child.block(), 0), nullptr);
    // The same by pointers.
    std::vector<uint64_t> pointers;
    for (const InstanceDesc& d : list)
        pointers.push_back(uint64_t(&d));
    InstanceInput byPointer;
    byPointer.instancePointers = pointers.data();
    byPointer.numInstances = 5;
    inputs.instances = &byPointer;
    EXPECT_TRUE(makeStructure(inputs) == s);
}

TEST(Math, InverseAndProduct) {
    const float m[12] = {1, 2, 0, 3, 0, 1, 4, -2, 5, 0, 1, 7};
    float inverse[12];
    ASSERT_TRUE(math::invert(m, inverse));
    const math::Affine product = math::multiply(m, inverse);
    for (int i = 0; i < 12; ++i)
        EXPECT_NEAR(product.m[i], math::Affine{}.m[i], 1e-5f);
    const float singular[12] = {1, 0, 0, 0, 2, 0, 0, 0, 0, 0, 1, 0};
    EXPECT_FALSE(math::invert(singular, inverse));
}

} // namespace
} // namespace sunstone::bvh
