// SPDX-License-Identifier: Apache-2.0
// Build inputs of the GPU's builder (run on the CPU device): vertex and index formats, SBT indices,
// inactive primitives, custom primitives, instances, and refused inputs.
#include "bvh/gpu/testing/device.h"

#include "math/affine.h"

#include <gtest/gtest.h>

namespace sunstone::bvh::gpu {
namespace {

using namespace bvh::testing;
using namespace gpu::testing;
using bvh::testing::Mesh;

// Rays through random points; CPU and GPU must give equal hits.
void expectSame(const BuildInputs& inputs, uint32_t seed, uint32_t leastHits) {
    const Structure cpu = makeStructure(inputs);
    const GpuStructure gpu = buildOnDevice(inputs);
    EXPECT_EQ(gpu.header().numActive, headerOf(cpu.block())->numActive);
    for (int a = 0; a < 3; ++a) {
        EXPECT_EQ(gpu.header().lower[a], headerOf(cpu.block())->lower[a]);
        EXPECT_EQ(gpu.header().upper[a], headerOf(cpu.block())->upper[a]);
    }
    Random random(seed);
    uint32_t hits = 0;
    for (uint32_t i = 0; i < 3000; ++i) {
        const Vec3 o = random.point(3), d = random.point(1) - o;
        const QueryRay ray{{o.x, o.y, o.z}, 0, {d.x, d.y, d.z}, 1e30f};
        QueryHit a{}, b{};
        const bool found = kernels(chosenIsa()).closest(cpu.block(), ray, a);
        ASSERT_EQ(found, nearest(gpu.handle(), ray, b)) << "ray " << i << " seed " << seed;
        hits += found;
        if (found) {
            ASSERT_EQ(a.t, b.t);
            ASSERT_EQ(a.primitive, b.primitive);
            ASSERT_EQ(a.sbt, b.sbt);
        }
    }
    EXPECT_GE(hits, leastHits);
}

void expectSame(const TriangleInput& input, uint32_t seed, uint32_t leastHits) {
    BuildInputs inputs;
    inputs.triangles = {&input, 1};
    expectSame(inputs, seed, leastHits);
}

TEST(GpuInputs, VertexFormats) {
    Random random(5);
    std::vector<uint16_t> words(3000);
    for (uint16_t& w : words)
        w = uint16_t(random.below(65536)) & 0xBFFF; // halves below 2
    std::vector<float> floats(3000);
    for (float& f : floats)
        f = random(-1, 1);
    struct Case {
        VertexFormat format;
        uint32_t stride;
    };
    for (const Case c : {Case{VertexFormat::kFloat3, 0}, Case{VertexFormat::kFloat3, 20},
                         Case{VertexFormat::kFloat2, 0}, Case{VertexFormat::kHalf3, 0},
                         Case{VertexFormat::kHalf3, 8}, Case{VertexFormat::kHalf2, 0},
                         Case{VertexFormat::kSnorm16x3, 0}, Case{VertexFormat::kSnorm16x2, 6}}) {
        SCOPED_TRACE("format " + std::to_string(uint32_t(c.format)) + " stride " +
                     std::to_string(c.stride));
        const bool isFloat = c.format == VertexFormat::kFloat3 || c.format == VertexFormat::kFloat2;
        TriangleInput in;
        in.vertices = isFloat ? static_cast<const void*>(floats.data()) : words.data();
        in.vertexFormat = c.format;
        in.vertexStride = c.stride;
        in.numVertices = 300;
        expectSame(in, 7, 50);
    }
}

TEST(GpuInputs, IndicesAndPreTransform) {
    const Mesh mesh = icosphere(2);
    std::vector<uint16_t> packed, strided;
    for (const auto& t : mesh.triangles) {
        for (uint32_t i : t) {
            packed.push_back(uint16_t(i));
            strided.push_back(uint16_t(i));
        }
        strided.push_back(0xFFFF);
    }
    packed[3] = 60000; // out of range: inactive
    TriangleInput in = mesh.input();
    in.indices = packed.data();
    in.indexFormat = IndexFormat::kUshort3;
    expectSame(in, 1, 500);
    in.indices = strided.data();
    in.indexStride = 8;
    const float transform[12] = {0.9f, 0.3f, 0, 0.1f, -0.2f, 1.1f, 0.1f, 0, 0, 0.2f, 0.7f, -0.3f};
    in.preTransform = transform;
    expectSame(in, 2, 500);
}

TEST(GpuInputs, SbtIndicesOfSeveralInputs) {
    const Mesh a = soup(200, 0.3f, 1), b = soup(100, 0.4f, 2), c = soup(57, 0.5f, 3);
    const uint32_t flags[3] = {1, 0, 2};
    std::vector<uint8_t> bytes(200);
    std::vector<uint32_t> words(2 * 57);
    for (size_t i = 0; i < bytes.size(); ++i)
        bytes[i] = uint8_t(i % 5); // some beyond the records
    for (size_t i = 0; i < words.size(); ++i)
        words[i] = uint32_t(i / 2 % 3);
    TriangleInput inputs[3] = {a.input(), b.input(), c.input()};
    inputs[0].sbt = {flags, 3, bytes.data(), 1, 0, 1000};
    inputs[2].sbt = {flags, 3, words.data(), 4, 8, 5};
    BuildInputs all;
    all.triangles = inputs;
    expectSame(all, 4, 500);
}

TEST(GpuInputs, InactiveTriangles) {
    Mesh mesh = soup(300, 0.4f, 9);
    const float bad[] = {NAN, INFINITY, -INFINITY, 1e38f};
    for (uint32_t i = 0; i < 300; i += 7)
        mesh.vertices[3 * i + i % 3].y = bad[i % 4];
    for (uint32_t i = 1; i < 300; i += 11)
        mesh.vertices[3 * i + 1] = mesh.vertices[3 * i];
    expectSame(mesh.input(), 5, 500);
    for (Vec3& v : mesh.vertices)
        v.x = NAN;
    const GpuStructure empty = buildOnDevice(mesh.input());
    EXPECT_EQ(empty.header().root, kNoNode);
    EXPECT_EQ(empty.header().numActive, 0u);
    QueryHit hit;
    EXPECT_FALSE(nearest(empty.handle(), {{0, 0, -3}, 0, {0, 0, 1}, 1e30f}, hit));
}

TEST(GpuInputs, NoPrimitives) {
    const TriangleInput none;
    const GpuStructure s = buildOnDevice(none);
    EXPECT_EQ(s.header().magic, kGpuBlockMagic);
    EXPECT_EQ(s.header().root, kNoNode);
}

TEST(GpuInputs, EqualPlaces) {
    // Equal Morton codes: the tree must stay shallow.
    Mesh mesh;
    mesh.vertices = {{-1, -1, 0}, {1, -1, 0}, {0, 1, 0}, {50, 50, 50}, {51, 50, 50}, {50, 51, 50}};
    for (uint32_t i = 0; i < 800; ++i)
        mesh.triangles.push_back({0, 1, 2});
    mesh.triangles.push_back({3, 4, 5});
    const GpuStructure s = buildOnDevice(mesh.input());
    QueryHit hit;
    ASSERT_TRUE(nearest(s.handle(), {{0, 0, -3}, 0, {0, 0, 1}, 1e30f}, hit));
    EXPECT_EQ(hit.t, 3.0f);
    EXPECT_EQ(hit.primitive, 0u); // the lowest of equal hits
}

// With all flags, empty and tiny inputs give structures that rays can traverse.
TEST(GpuInputs, DegenerateInputOfAllFlags) {
    const Vec3 corners[3] = {{-1, -1, 0}, {1, -1, 0}, {0, 1, 0}};
    const auto meshOf = [&](uint32_t count, const auto& vertex) {
        Mesh mesh;
        for (uint32_t i = 0; i < count; ++i) {
            for (uint32_t k = 0; k < 3; ++k)
                mesh.vertices.push_back(vertex(i, k));
            mesh.triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
        }
        return mesh;
    };
    const auto equal = [&](uint32_t, uint32_t k) { return corners[k]; };
    const auto nan = [](uint32_t, uint32_t) { return Vec3{NAN, NAN, NAN}; };
    const auto point = [](uint32_t, uint32_t) { return Vec3{2, 2, 2}; };
    const auto oneOfMany = [&](uint32_t i, uint32_t k) {
        return i == 17 ? corners[k] : i & 1 ? Vec3{INFINITY, 0, 0} : Vec3{0, NAN, -INFINITY};
    };
    const auto huge = [&](uint32_t i, uint32_t k) {
        return i == 0 ? corners[k] * 0x1p90f : corners[k];
    };
    const struct {
        Mesh mesh;
        uint32_t active;
    } cases[] = {{meshOf(0, equal), 0},      {meshOf(1, equal), 1}, {meshOf(40, equal), 40},
                 {meshOf(40, nan), 0},       {meshOf(1, nan), 0},   {meshOf(50, point), 0},
                 {meshOf(40, oneOfMany), 1}, {meshOf(30, huge), 30}};
    for (uint32_t bits = 0; bits < 4; ++bits) {
        BuildOptions options;
        options.preferFastTrace = bits == 1;
        options.preferFastBuild = bits == 2;
        options.allowUpdate = bits == 3;
        for (const auto& c : cases) {
            SCOPED_TRACE("options " + std::to_string(bits) + " triangles " +
                         std::to_string(c.mesh.triangles.size()) + " active " +
                         std::to_string(c.active));
            const GpuStructure s = buildOnDevice(c.mesh.input(), options);
            ASSERT_EQ(s.header().magic, kGpuBlockMagic);
            EXPECT_EQ(s.header().numActive, c.active);
            EXPECT_EQ(s.header().root == kNoNode, c.active == 0);
            QueryHit hit{};
            ASSERT_EQ(nearest(s.handle(), {{0, 0, -3}, 0, {0, 0, 1}, 1e30f}, hit), c.active != 0);
            if (c.active)
                EXPECT_EQ(hit.t, 3.0f);
        }
        const Box one{{-1, -1, -1}, {1, 1, 1}};
        CustomInput custom;
        custom.aabbs = &one;
        custom.numPrimitives = 1;
        BuildInputs inputs;
        inputs.customs = {&custom, 1};
        EXPECT_EQ(buildOnDevice(inputs, options).header().numActive, 1u);
        InstanceDesc nothing{};
        InstanceInput instances;
        instances.instances = &nothing;
        instances.numInstances = 1;
        inputs = {};
        inputs.instances = &instances;
        EXPECT_EQ(buildOnDevice(inputs, options).header().root, kNoNode);
        instances.numInstances = 0;
        EXPECT_EQ(buildOnDevice(inputs, options).header().root, kNoNode);
    }
    EXPECT_TRUE(Device::get().builder().takeFailures().empty());
}

TEST(GpuInputs, RandomVertexAccess) {
    const Mesh mesh = soup(500, 0.2f, 3);
    BuildOptions options;
    options.allowRandomVertexAccess = true;
    const GpuStructure s = buildOnDevice(mesh.input(), options);
    const auto* bytes = static_cast<const uint8_t*>(s.memory->data());
    const auto* table = reinterpret_cast<const uint32_t*>(bytes + s.header().tableOffset);
    const auto* records = reinterpret_cast<const TriangleRecord*>(bytes + s.header().recordsOffset);
    for (uint32_t i = 0; i < 500; ++i) {
        ASSERT_LT(table[i], 500u);
        ASSERT_EQ(records[table[i]].primitive, i);
        ASSERT_EQ(std::memcmp(records[table[i]].v0, &mesh.vertices[3 * i], 12), 0);
    }
}

// Collects the boxes that a ray enters.
struct BoxPrograms : NoShapes, NoMotion, OneLane {
    static constexpr bool kTriangles = false, kCustoms = true, kInstances = false;
    static constexpr unsigned kLevels = 0;
    std::vector<uint32_t> seen;
    Visit triangle(gpu::Ray&, const TriangleHit&, uint32_t, uint32_t) { return Visit::kEnd; }
    Visit custom(gpu::Ray&, uint32_t primitive, uint32_t) {
        seen.push_back(primitive);
        return Visit::kContinue;
    }
    void leave(gpu::Ray&) {}
};

TEST(GpuInputs, CustomPrimitives) {
    Random random(8);
    std::vector<Box> boxes(400);
    for (Box& b : boxes) {
        const Vec3 c = random.point(1);
        b.lower = c - Vec3{0.05f, 0.1f, 0.02f};
        b.upper = c + Vec3{0.05f, 0.1f, 0.02f};
    }
    boxes[17].lower.x = boxes[17].upper.x + 1; // inverted
    CustomInput in;
    in.aabbs = boxes.data();
    in.numPrimitives = 400;
    BuildInputs inputs;
    inputs.customs = {&in, 1};
    const GpuStructure s = buildOnDevice(inputs);
    EXPECT_EQ(s.header().numActive, 399u);
    uint32_t shown = 0;
    for (uint32_t i = 0; i < 1000; ++i) {
        const Vec3 o = random.point(3), d = random.point(1) - o;
        gpu::Ray ray{{o.x, o.y, o.z}, 0, {d.x, d.y, d.z}, 1e30f};
        BoxPrograms programs;
        Traversal<BoxPrograms> traversal;
        U2 stack[Traversal<BoxPrograms>::kStackSize];
        if (traversal.start(programs, ray, s.handle(), nullptr))
            traversal.run(programs, ray, stack, nullptr, RunToEnd());
        std::sort(programs.seen.begin(), programs.seen.end());
        EXPECT_EQ(std::adjacent_find(programs.seen.begin(), programs.seen.end()),
                  programs.seen.end());
        shown += uint32_t(programs.seen.size());
        for (uint32_t k = 0; k < 400; ++k) {
            double begin = 0, end = 1e30;
            for (int a = 0; a < 3; ++a) {
                const double x = (double(boxes[k].lower[a]) - o[a]) / d[a];
                const double y = (double(boxes[k].upper[a]) - o[a]) / d[a];
                begin = std::max(begin, std::min(x, y));
                end = std::min(end, std::max(x, y));
            }
            if (begin <= end && k != 17)
                ASSERT_TRUE(std::binary_search(programs.seen.begin(), programs.seen.end(), k));
        }
    }
    EXPECT_LT(shown, 1000u * 40);
}

// Simulates one of many lanes at the start of a step, and one of the last few after the visit of a
// primitive.
struct LastPrograms : BoxPrograms {
    static uint32_t lanes() { return isAlone ? 1 : 32; }
    Visit custom(gpu::Ray& ray, uint32_t primitive, uint32_t sbt) {
        isAlone = true;
        return BoxPrograms::custom(ray, primitive, sbt);
    }
    static inline bool isAlone;
};

// The other primitives of the leaf then wait: each step visits one, and in the end all have been
// visited.
TEST(GpuInputs, FewLanesLetPrimitivesWait) {
    Random random(11);
    std::vector<Box> boxes(3000);
    for (Box& b : boxes) {
        const Vec3 c = random.point(1);
        b = {c - Vec3{0.1f, 0.1f, 0.1f}, c + Vec3{0.1f, 0.1f, 0.1f}};
    }
    CustomInput in;
    in.aabbs = boxes.data();
    in.numPrimitives = uint32_t(boxes.size());
    BuildInputs inputs;
    inputs.customs = {&in, 1};
    const GpuStructure s = buildOnDevice(inputs);
    size_t total = 0, alone = 0;
    for (uint32_t i = 0; i < 300; ++i) {
        const Vec3 o = random.point(3), d = random.point(1) - o;
        const gpu::Ray start{{o.x, o.y, o.z}, 0, {d.x, d.y, d.z}, 1e30f};
        gpu::Ray ray = start;
        BoxPrograms plain;
        Traversal<BoxPrograms> whole;
        U2 stack[Traversal<LastPrograms>::kStackSize];
        if (!whole.start(plain, ray, s.handle(), nullptr))
            continue;
        whole.run(plain, ray, stack, nullptr, RunToEnd());
        ray = start;
        LastPrograms last;
        Traversal<LastPrograms> traversal;
        ASSERT_TRUE(traversal.start(last, ray, s.handle(), nullptr));
        for (bool ended = false; !ended;) {
            LastPrograms::isAlone = false;
            const size_t before = last.seen.size();
            ended = traversal.step(last, ray, stack, nullptr);
            ASSERT_LE(traversal.top, Traversal<LastPrograms>::kStackSize);
            total += last.seen.size() - before;
            alone += last.seen.size() - before == 1;
        }
        std::sort(plain.seen.begin(), plain.seen.end());
        std::sort(last.seen.begin(), last.seen.end());
        ASSERT_EQ(plain.seen, last.seen) << "ray " << i;
    }
    EXPECT_GT(total, 3000u);
    EXPECT_GT(alone * 10, total * 9);
}

// The box around a sphere's rotated box reaches 1.4 radii along x and y.
TEST(GpuInputs, TurnedInstancesHaveTightBoxes) {
    const Mesh mesh = icosphere(3);
    const GpuStructure sphere = buildOnDevice(mesh.input());
    InstanceDesc instance{};
    const float c = 0.70710678f;
    const float turn[12] = {c, -c, 0, 5, c, c, 0, 6, 0, 0, 1, 7};
    std::copy(turn, turn + 12, instance.transform);
    instance.visibilityMask = 255;
    instance.traversableHandle = sphere.handle();
    InstanceInput in;
    in.instances = &instance;
    in.numInstances = 1;
    BuildInputs inputs;
    inputs.instances = &in;
    const GpuStructure top = buildOnDevice(inputs);
    const float radius = sphere.header().upper[2];
    for (int a = 0; a < 3; ++a) {
        const float centre = turn[4 * a + 3];
        float low = centre, high = centre; // of the vertices
        for (const Vec3& v : mesh.vertices) {
            const float x = turn[4 * a] * v.x + turn[4 * a + 1] * v.y + turn[4 * a + 2] * v.z;
            low = std::min(low, centre + x);
            high = std::max(high, centre + x);
        }
        EXPECT_LE(top.header().lower[a], low);
        EXPECT_GE(top.header().upper[a], high);
        EXPECT_GT(top.header().lower[a], centre - 1.35f * radius);
        EXPECT_LT(top.header().upper[a], centre + 1.35f * radius);
    }
}

// A block of threads caches the parts of one structure and reads those of others: the boxes must
// not depend on it.
TEST(GpuInputs, BoxesOfInstancesDoNotDependOnTheirOrder) {
    const GpuStructure children[] = {buildOnDevice(icosphere(3).input()),
                                     buildOnDevice(torus(20, 12).input()),
                                     buildOnDevice(cube().input())};
    Random random(5);
    std::vector<InstanceDesc> list(24);
    for (size_t i = 0; i < list.size(); ++i) {
        const Vec3 p = random.point(2), x = random.point(0.3f), y = random.point(0.3f),
                   z = random.point(0.3f);
        for (int a = 0; a < 3; ++a) {
            list[i].transform[4 * a] = x[a];
            list[i].transform[4 * a + 1] = y[a];
            list[i].transform[4 * a + 2] = z[a];
            list[i].transform[4 * a + 3] = p[a];
        }
        list[i].visibilityMask = 255;
        list[i].traversableHandle = children[i % 3].handle();
    }
    const auto build = [](const InstanceDesc* first, uint32_t count) {
        InstanceInput in;
        in.instances = first;
        in.numInstances = count;
        BuildInputs inputs;
        inputs.instances = &in;
        return buildOnDevice(inputs);
    };
    // The union of the boxes of single instances.
    KeyBounds alone = {{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};
    for (const InstanceDesc& instance : list) {
        const GpuStructure one = build(&instance, 1);
        for (int a = 0; a < 3; ++a) {
            alone.lower[a] = std::min(alone.lower[a], one.header().lower[a]);
            alone.upper[a] = std::max(alone.upper[a], one.header().upper[a]);
        }
    }
    for (int turn = 0; turn < 3; ++turn) {
        const GpuStructure all = build(list.data(), uint32_t(list.size()));
        EXPECT_EQ(all.header().numActive, list.size());
        for (int a = 0; a < 3; ++a) {
            EXPECT_EQ(all.header().lower[a], alone.lower[a]);
            EXPECT_EQ(all.header().upper[a], alone.upper[a]);
        }
        std::rotate(list.begin(), list.begin() + 1, list.end()); // another one comes first
    }
}

GpuStructure instancesOf(uint64_t child, const std::vector<std::array<float, 12>>& transforms) {
    std::vector<InstanceDesc> instances(transforms.size());
    for (size_t i = 0; i < instances.size(); ++i) {
        instances[i] = {};
        std::copy(transforms[i].begin(), transforms[i].end(), instances[i].transform);
        instances[i].visibilityMask = 255;
        instances[i].traversableHandle = child;
    }
    InstanceInput in;
    in.instances = instances.data();
    in.numInstances = uint32_t(instances.size());
    BuildInputs inputs;
    inputs.instances = &in;
    return buildOnDevice(inputs);
}

// Children of nodes of instances wait singly; if too many wait, in groups.
TEST(GpuInputs, ManyWaitingChildren) {
    struct AnyOrder : NearestPrograms {
        bool nearestFirst() const { return false; }
    };
    const Mesh mesh = icosphere(2);
    const GpuStructure sphere = buildOnDevice(mesh.input());
    Random random(42);
    const auto heap = [&](uint64_t child) {
        std::vector<std::array<float, 12>> transforms;
        for (uint32_t i = 0; i < 400; ++i) {
            const Vec3 p = random.point(0.05f);
            const float s = random(0.9f, 1.1f);
            transforms.push_back({s, 0, 0, p.x, 0, s, 0, p.y, 0, 0, s, p.z});
        }
        return instancesOf(child, transforms);
    };
    const GpuStructure inner = heap(sphere.handle()), outer = heap(inner.handle());
    uint32_t hits = 0, most = 0;
    for (uint32_t i = 0; i < 12; ++i) {
        const Vec3 o = random.unit() * 4, d = random.point(1.2f) - o;
        const QueryRay query{{o.x, o.y, o.z}, 0, {d.x, d.y, d.z}, 1e30f};
        AnyOrder anyOrder;
        QueryHit expected;
        const bool isHit = nearestBy(anyOrder, outer.handle(), query, expected);
        NearestPrograms programs;
        gpu::Ray ray{{o.x, o.y, o.z}, 0, {d.x, d.y, d.z}, 1e30f};
        Traversal<NearestPrograms> traversal;
        U2 stack[Traversal<NearestPrograms>::kStackSize];
        Level levels[NearestPrograms::kLevels + 1];
        ASSERT_TRUE(traversal.start(programs, ray, outer.handle(), levels));
        while (!traversal.step(programs, ray, stack, levels)) {
            most = std::max(most, traversal.top);
            ASSERT_LE(traversal.top, Traversal<NearestPrograms>::kStackSize);
        }
        ASSERT_EQ(programs.found, isHit) << "ray " << i;
        if (isHit) {
            ++hits;
            ASSERT_EQ(ray.tmax, expected.t) << "ray " << i;
        }
    }
    EXPECT_GT(hits, 3u);
    EXPECT_GT(most, kWaitingChildren);
}

TEST(GpuInputs, Instances) {
    const Mesh mesh = icosphere(2);
    const GpuStructure sphere = buildOnDevice(mesh.input());
    const Structure sphereCpu = makeStructure(mesh.input());
    Random random(12);
    std::vector<InstanceDesc> instances(150);
    for (InstanceDesc& i : instances) {
        const Vec3 p = random.point(1), x = random.point(0.2f), y = random.point(0.2f),
                   z = random.point(0.2f);
        for (int a = 0; a < 3; ++a) {
            i.transform[4 * a] = x[a];
            i.transform[4 * a + 1] = y[a];
            i.transform[4 * a + 2] = z[a];
            i.transform[4 * a + 3] = p[a];
        }
        i.visibilityMask = 255;
        i.traversableHandle = sphere.handle();
    }
    instances[3].visibilityMask = 0;
    instances[4].traversableHandle = 0;
    InstanceInput in;
    in.instances = instances.data();
    in.numInstances = 150;
    BuildInputs inputs;
    inputs.instances = &in;
    const GpuStructure top = buildOnDevice(inputs);
    EXPECT_EQ(top.header().numActive, 148u);
    std::vector<uint64_t> addresses;
    for (const InstanceDesc& i : instances)
        addresses.push_back(reinterpret_cast<uint64_t>(&i));
    InstanceInput byAddress = in;
    byAddress.instances = nullptr;
    byAddress.instancePointers = addresses.data();
    inputs.instances = &byAddress;
    const GpuStructure same = buildOnDevice(inputs);
    uint32_t hits = 0;
    for (uint32_t i = 0; i < 2000; ++i) {
        const Vec3 o = random.point(3), d = random.point(1) - o;
        const QueryRay ray{{o.x, o.y, o.z}, 0, {d.x, d.y, d.z}, 1e30f};
        float t = 1e30f;
        for (uint32_t k = 0; k < 150; ++k) {
            if (k == 3 || k == 4)
                continue;
            float inverse[12];
            ASSERT_TRUE(math::invert(instances[k].transform, inverse));
            const Vec3 lo = math::transformPoint(inverse, o),
                       ld = math::transformVector(inverse, d);
            QueryHit hit;
            if (kernels(chosenIsa())
                    .closest(sphereCpu.block(), {{lo.x, lo.y, lo.z}, 0, {ld.x, ld.y, ld.z}, t},
                             hit))
                t = hit.t;
        }
        QueryHit hit, again;
        SingleLevelPrograms singleLevel;
        ASSERT_EQ(nearestBy(singleLevel, top.handle(), ray, again), t < 1e30f) << "ray " << i;
        ASSERT_TRUE(t == 1e30f || again.t == t) << "ray " << i;
        ASSERT_EQ(nearest(top.handle(), ray, hit), t < 1e30f) << "ray " << i;
        ASSERT_EQ(nearest(same.handle(), ray, again), t < 1e30f) << "ray " << i;
        if (t < 1e30f) {
            ++hits;
            ASSERT_EQ(hit.t, t);
            ASSERT_EQ(again.t, t);
        }
    }
    EXPECT_GT(hits, 500u);
}

// Triangles of usual size, and some as far away as coordinates may be, so that distances to planes
// of nodes overflow along axes on which a ray hardly moves. Near triangles must be found as if they
// were alone.
TEST(GpuInputs, WideScenesAndSlowRays) {
    const Mesh close = soup(60, 0.5f, 17);
    const Structure alone = makeStructure(close.input());
    for (const float far : {1e3f, 0x1p60f, 0x1p90f, 0x1p97f, 0x1p100f}) {
        Mesh mesh = close;
        const uint32_t first = uint32_t(mesh.vertices.size());
        mesh.vertices.insert(mesh.vertices.end(),
                             {{far, far, far}, {far, -far, far}, {far, 0, -far}});
        mesh.vertices.insert(mesh.vertices.end(), {{-far, 1, 0}, {-far, 0, 1}, {-far, -far, -far}});
        mesh.triangles.push_back({first, first + 1, first + 2});
        mesh.triangles.push_back({first + 3, first + 4, first + 5});
        const GpuStructure gpu = buildOnDevice(mesh.input());
        Random random(18);
        uint32_t hits = 0;
        for (uint32_t i = 0; i < 3000; ++i) {
            const Vec3 o = random.point(1.5f);
            Vec3 d = random.unit();
            const uint32_t axis = random.below(3);
            d[axis] *= i % 3 == 0 ? 0.0f : i % 3 == 1 ? 0x1p-22f : 1.0f;
            if (i % 4 == 0)
                d[(axis + 1) % 3] = 0;
            const float speed = i % 5 == 0 ? 0x1p-30f : i % 5 == 1 ? 0x1p-70f : 1.0f;
            const QueryRay ray{
                {o.x, o.y, o.z}, 0, {d.x * speed, d.y * speed, d.z * speed}, 3 / speed};
            QueryHit a{}, b{};
            if (!kernels(Isa::kBaseline).closest(alone.block(), ray, a))
                continue;
            ++hits;
            ASSERT_TRUE(nearest(gpu.handle(), ray, b)) << "far " << far << " ray " << i;
            ASSERT_EQ(a.t, b.t) << "far " << far << " ray " << i;
        }
        EXPECT_GT(hits, 500u) << far;
    }
}

// The slots on the node's near side, along the ray's longest axis, come first.
TEST(GpuTraversal, RanksOfSlots) {
    for (uint32_t signs = 0; signs < 8; ++signs)
        for (uint32_t axis = 0; axis < 3; ++axis) {
            float d[3];
            for (uint32_t i = 0; i < 3; ++i)
                d[i] = (signs >> i & 1 ? -1.0f : 1.0f) * (i == axis ? 1.0f : 0.9f);
            const uint32_t octant = makeBoxRay(d, 1.0f).octant;
            uint32_t seen = 0;
            for (uint32_t slot = 0; slot < 8; ++slot) {
                const uint32_t rank = rankOf(octant, slot);
                EXPECT_EQ(slotOf(octant, rank), slot);
                EXPECT_EQ(rank >= 4, (slot >> axis & 1) == (signs >> axis & 1))
                    << "slot " << slot << " signs " << signs << " axis " << axis;
                seen |= 1u << rank;
                // As in node tests: four inner children at a time.
                for (uint32_t place = 0; place < 4; ++place)
                    EXPECT_EQ(Slots((1u << 5 | 24 | slot) << 8 * place, octant).hit(place),
                              1u << (24 + rank));
            }
            EXPECT_EQ(seen, 0xFFu);
        }
}

TEST(GpuInputs, NothingIsNoInput) {
    EXPECT_THROW(Builder::computeMemoryUsage({}, {}), Error);
}

TEST(GpuInputs, BuffersMustDo) {
    const Mesh mesh = cube();
    const TriangleInput in = mesh.input();
    BuildInputs inputs;
    inputs.triangles = {&in, 1};
    const MemoryUsage usage = Builder::computeMemoryUsage(inputs, {});
    Buffer temp(usage.temp + 128), output(usage.output + 128);
    const Builder& builder = Device::get().builder();
    const auto build = [&](CUdeviceptr t, size_t ts, CUdeviceptr o, size_t os) {
        builder.build(nullptr, inputs, {}, t, ts, o, os);
    };
    const CUdeviceptr t = (temp.address() + 127) / 128 * 128,
                      o = (output.address() + 127) / 128 * 128;
    EXPECT_THROW(build(0, usage.temp, o, usage.output), Error);
    EXPECT_THROW(build(t, usage.temp, 0, usage.output), Error);
    EXPECT_THROW(build(t + 64, usage.temp, o, usage.output), Error);
    EXPECT_THROW(build(t, usage.temp, o + 8, usage.output), Error);
    EXPECT_THROW(build(t, usage.temp - 1, o, usage.output), Error);
    EXPECT_THROW(build(t, usage.temp, o, usage.output - 1), Error);
    EXPECT_NO_THROW(build(t, usage.temp, o, usage.output));
    EXPECT_EQ(Device::get().driver().ctxSynchronize(), CUDA_SUCCESS);
}

// Scratch memory of at most 100 bytes a primitive whatever the flags; output of one reference for
// each primitive 80 bytes, of two (PREFER_FAST_TRACE) twice as much.
TEST(GpuInputs, MemoryIsWithinThePromise) {
    for (uint32_t count : {10000u, 2000000u, (1u << 29) - 1}) {
        for (uint32_t bits = 0; bits < 16; ++bits) {
            BuildOptions options;
            options.preferFastTrace = bits & 1;
            options.preferFastBuild = bits & 2;
            options.allowUpdate = bits & 4;
            options.allowRandomVertexAccess = bits & 8;
            SCOPED_TRACE("count " + std::to_string(count) + " options " + std::to_string(bits));
            // Counters and alignment add to the bytes per primitive.
            const uint64_t fixed = 24u << 10;
            TriangleInput triangles;
            triangles.numVertices = 3;
            triangles.indexFormat = IndexFormat::kUint3;
            triangles.numTriangles = count;
            BuildInputs inputs;
            inputs.triangles = {&triangles, 1};
            MemoryUsage usage = Builder::computeMemoryUsage(inputs, options);
            const uint64_t parts = options.preferFastTrace && !options.allowUpdate ? 2 : 1;
            EXPECT_LE(usage.temp, 100ull * count + fixed);
            EXPECT_LE(usage.output, (80 * parts) * count + fixed);
            EXPECT_LE(usage.tempUpdate, 100ull * count + fixed);
            CustomInput customs;
            customs.numPrimitives = count;
            inputs = {};
            inputs.customs = {&customs, 1};
            usage = Builder::computeMemoryUsage(inputs, options);
            EXPECT_LE(usage.temp, 100ull * count + fixed);
            EXPECT_LE(usage.tempUpdate, 100ull * count + fixed);
            InstanceInput instances;
            instances.numInstances = count;
            inputs = {};
            inputs.instances = &instances;
            usage = Builder::computeMemoryUsage(inputs, options);
            EXPECT_LE(usage.temp, 100ull * count + fixed);
            EXPECT_LE(usage.tempUpdate, 100ull * count + fixed);
        }
    }
}

} // namespace
} // namespace sunstone::bvh::gpu
