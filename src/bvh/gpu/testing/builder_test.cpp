// SPDX-License-Identifier: Apache-2.0
// The GPU's builder kernels, run on the CPU device, and the GPU's traversal, compiled for the host:
// every hit must equal that of the CPU's engine to the bit.
#include "bvh/gpu/build/job.h"
#include "bvh/gpu/kernels_ptx.h"
#include "bvh/gpu/testing/device.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

namespace sunstone::bvh::gpu {
namespace {

using namespace bvh::testing;
using namespace gpu::testing;
using bvh::testing::Mesh;

QueryRay randomRay(Random& random) {
    Vec3 o = random.point(random.below(2) ? 1.0f : 4.0f);
    Vec3 d = random.below(3) ? random.point(1) - o : random.unit();
    switch (random.below(12)) {
    case 0:
        d = {0, 0, random.below(2) ? 1.0f : -1.0f};
        break;
    case 1:
        d = {random.below(2) ? 2.0f : -0.5f, 0, 0};
        break;
    case 2:
        d.y = 0;
        break;
    case 3:
        d = d * 1e-6f;
        break;
    case 4:
        d = d * 1e6f;
        break;
    case 5:
        d.x *= 1e-9f;
        break;
    case 6:
        d = d * (random.below(2) ? 1e-33f : 1e33f);
        break;
    }
    QueryRay ray{{o.x, o.y, o.z}, 0, {d.x, d.y, d.z}, 1e30f};
    if (random.below(4) == 0) {
        ray.tmin = random(0, 1);
        ray.tmax = ray.tmin + random(0, 2);
    }
    return ray;
}

// Checks a tree: every active primitive is in one leaf, every box inside its parent's.
struct TreeCheck {
    const BlockHeader& header;
    std::vector<uint32_t> seen;
    uint32_t nodes = 0, deepest = 0;

    explicit TreeCheck(const BlockHeader& h) : header(h), seen(h.numLeaves) {
        if (h.root != kNoNode)
            visit(0, 1);
    }
    void visit(uint32_t index, uint32_t depth) {
        ASSERT_LT(index, header.numNodes);
        ++nodes;
        deepest = std::max(deepest, depth);
        const auto& node = reinterpret_cast<const WideNode*>(
            reinterpret_cast<const uint8_t*>(&header) + header.nodesOffset)[index];
        uint32_t inner = 0;
        for (uint32_t s = 0; s < 8; ++s) {
            if (node.innerMask >> s & 1) {
                EXPECT_EQ(node.meta[s], 1u << 5 | (24 + s));
                visit(node.childBase + inner++, depth + 1);
            } else if (node.meta[s]) {
                const uint32_t count = uint32_t(__builtin_popcount(node.meta[s] >> 5));
                for (uint32_t k = 0; k < count; ++k)
                    ++seen.at(node.primitiveBase + (node.meta[s] & 31u) + k);
            }
        }
    }
};

void expectSound(const BlockHeader& header) {
    ASSERT_EQ(header.magic, kGpuBlockMagic);
    const TreeCheck check(header);
    EXPECT_EQ(check.nodes, header.numNodes);
    EXPECT_LE(check.deepest, kMaxWideDepth);
    for (uint32_t count : check.seen)
        ASSERT_EQ(count, 1u);
}

void expectSameHits(const Structure& cpu, const GpuStructure& gpu, uint32_t rays, uint32_t seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Random random(seed);
    uint32_t hits = 0, wrong = 0;
    for (uint32_t i = 0; i < rays; ++i) {
        const QueryRay ray = randomRay(random);
        QueryHit a{}, b{};
        const bool foundA = kernels(chosenIsa()).closest(cpu.block(), ray, a);
        const bool foundB = nearest(gpu.handle(), ray, b);
        hits += foundA;
        const bool same = foundA == foundB && (!foundA || (a.t == b.t && a.u == b.u && a.v == b.v &&
                                                           a.primitive == b.primitive &&
                                                           a.sbt == b.sbt && a.front == b.front));
        if (!same && wrong++ == 0)
            ADD_FAILURE() << "ray " << i << " CPU " << foundA << " t " << a.t << " primitive "
                          << a.primitive << " GPU " << foundB << " t " << b.t << " primitive "
                          << b.primitive;
    }
    EXPECT_EQ(wrong, 0u);
    EXPECT_GT(hits, rays / 100);
}

void compareMesh(const Mesh& mesh, uint32_t rays, uint32_t seed, const BuildOptions& options = {}) {
    const Structure cpu = makeStructure(mesh.input());
    const GpuStructure gpu = buildOnDevice(mesh.input(), options);
    expectSound(gpu.header());
    expectSameHits(cpu, gpu, rays, seed);
}

TEST(GpuBuild, FindsTheHitsOfTheCpu) {
    compareMesh(cube(), 4000, 1);
    compareMesh(icosphere(2), 10000, 2);
    compareMesh(soup(1000, 0.1f, 3), 10000, 3);
}

TEST(GpuBuild, FastBuild) {
    BuildOptions options;
    options.preferFastBuild = true;
    compareMesh(icosphere(2), 5000, 4, options);
    compareMesh(soup(1200, 0.1f, 5), 10000, 5, options);
    for (uint32_t count : {1u, 2u, 9u})
        compareMesh(soup(count, 0.7f, count), 1000, count, options);
}

TEST(GpuBuild, FewTriangles) {
    for (uint32_t count : {1u, 2u, 3u, 4u, 5u, 8u, 9u, 16u, 17u, 33u, 100u})
        compareMesh(soup(count, 0.7f, count), 2000, count);
}

void addBox(Mesh& mesh, const Vec3& centre, float half) { // a triangle with this box
    const uint32_t first = uint32_t(mesh.vertices.size());
    mesh.vertices.insert(mesh.vertices.end(),
                         {centre + Vec3{-half, -half, -half}, centre + Vec3{half, -half, half},
                          centre + Vec3{half, half, half}});
    mesh.triangles.push_back({first, first + 1, first + 2});
}

// Each triangle is slightly larger than the previous one, so that clusters grow by one at a time.
// The codes of each further sixteen triangles differ from all earlier codes in one higher bit.
TEST(GpuBuild, TreesThatWouldBeTooDeep) {
    Mesh mesh;
    const float cell = 4;
    for (uint32_t i = 0; i < 42 * 16; ++i) {
        const uint32_t bit = i / 16;
        Vec3 centre{0.5f * cell, 0.5f * cell, 0.5f * cell};
        centre[2 - bit % 3] += cell * float(1u << bit / 3);
        addBox(mesh, centre, 1.2f * cell * std::exp2(float(i) / 48));
    }
    addBox(mesh, {0, 0, 0}, 32768 * cell); // so that a cell is one of the codes
    const Structure cpu = makeStructure(mesh.input());
    for (const bool asLarge : {false, true}) {
        Device::get().buildAsLarge(asLarge);
        const GpuStructure gpu = buildOnDevice(mesh.input());
        Device::get().buildAsLarge(false);
        expectSound(gpu.header());
        EXPECT_EQ(gpu.header().treeTooDeep, 1u);
        expectSameHits(cpu, gpu, 1000, 1);
    }
}

// Nested triangles around one point, of many sizes.
TEST(GpuBuild, NestedTriangles) {
    Mesh mesh;
    double size = 0x1p-90;
    for (uint32_t i = 0; i < 900; ++i, size *= 1.12) {
        const float s = float(size);
        mesh.vertices.insert(mesh.vertices.end(), {{0, 0, 0}, {s, 0, 0}, {0, s, s}});
        mesh.triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
    }
    const GpuStructure gpu = buildOnDevice(mesh.input());
    expectSound(gpu.header());
    const Structure cpu = makeStructure(mesh.input());
    expectSameHits(cpu, gpu, 1000, 1);
}

struct CountSteps {
    uint64_t& steps;
    bool stop() const {
        ++steps;
        return false;
    }
};

// The number of nodes that rays through the mesh visit.
uint64_t stepsThrough(const GpuStructure& gpu) {
    Random random(1);
    uint64_t steps = 0;
    for (uint32_t i = 0; i < 4000; ++i) {
        const Vec3 o = random.point(2), d = random.point(1) - o;
        gpu::Ray ray{{o.x, o.y, o.z}, 0, {d.x, d.y, d.z}, 1e30f};
        FlatPrograms programs; // whose steps are nodes
        Traversal<FlatPrograms> traversal;
        U2 stack[Traversal<FlatPrograms>::kStackSize];
        Level levels[FlatPrograms::kLevels + 1];
        if (traversal.start(programs, ray, gpu.handle(), levels))
            traversal.run(programs, ray, stack, levels, CountSteps{steps});
    }
    return steps;
}

// The clustered tree must need about as many steps as the tree of PREFER_FAST_BUILD, or fewer, for
// overlapping triangles and for surfaces.
TEST(GpuBuild, ClustersBeatTheRadixTree) {
    BuildOptions fast;
    fast.preferFastBuild = true;
    const struct {
        const char* name;
        Mesh mesh;
        double share; // of the steps, at most
    } scenes[] = {{"soup", soup(9000, 0.03f, 1), 1.06},
                  {"dense soup", soup(9000, 0.15f, 2), 1.02},
                  {"rough sphere", roughSphere(4, 3), 0.97},
                  {"torus", torus(100, 40), 0.97}};
    for (const auto& scene : scenes) {
        const uint64_t clustered = stepsThrough(buildOnDevice(scene.mesh.input())),
                       radix = stepsThrough(buildOnDevice(scene.mesh.input(), fast));
        std::printf("%s: %.2f steps a ray, radix tree %.2f\n", scene.name, double(clustered) / 4000,
                    double(radix) / 4000);
        EXPECT_LE(double(clustered), scene.share * double(radix)) << scene.name;
    }
}

TEST(GpuBuild, SplitsLongThinTriangles) {
    Mesh mesh;
    Random random(31);
    for (uint32_t i = 0; i < 400; ++i) {
        const Vec3 p = random.point(1), along = random.unit() * random(0.1f, 1.2f);
        mesh.vertices.insert(mesh.vertices.end(), {p, p + along, p + random.unit() * 0.004f});
        mesh.triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
    }
    BuildOptions options;
    options.preferFastTrace = options.allowRandomVertexAccess = true;
    const GpuStructure gpu = buildOnDevice(mesh.input(), options);
    expectSound(gpu.header());
    EXPECT_EQ(gpu.header().numActive, 400u);
    EXPECT_GT(gpu.header().numLeaves, 600u);
    EXPECT_LE(gpu.header().numLeaves, 840u);
    const Structure cpu = makeStructure(mesh.input());
    expectSameHits(cpu, gpu, 20000, 4);
    const auto* bytes = static_cast<const uint8_t*>(gpu.memory->data());
    const auto* table = reinterpret_cast<const uint32_t*>(bytes + gpu.header().tableOffset);
    const auto* records =
        reinterpret_cast<const TriangleRecord*>(bytes + gpu.header().recordsOffset);
    for (uint32_t i = 0; i < 400; ++i)
        EXPECT_EQ(records[table[i]].primitive, i);
    // Ordinary triangles, and triangles that programs may see only once, stay whole.
    EXPECT_EQ(buildOnDevice(icosphere(1).input(), options).header().numLeaves, 80u);
    const uint32_t once = kGeometryRequireSingleAnyHit;
    TriangleInput single = mesh.input();
    single.sbt.flags = &once;
    EXPECT_EQ(buildOnDevice(single, options).header().numLeaves, 400u);
}

// Builds end for any binary tree: here a tree whose nodes are their own children, and a tree with
// too many primitives; also with wrong parents written into the wide tree during the build. The
// test launches kernels as the builder does.
TEST(GpuBuild, BrokenTreesAreReportedAndNeverWaitedFor) {
    const auto& driver = Device::get().driver();
    CUmodule module = nullptr;
    CUfunction collapse = nullptr, subtrees = nullptr, arrange = nullptr, records = nullptr;
    ASSERT_EQ(driver.moduleLoadDataEx(&module, builderPtx(), 0, nullptr, nullptr), CUDA_SUCCESS);
    ASSERT_EQ(driver.moduleGetFunction(&collapse, module, "sunstone_collapse"), CUDA_SUCCESS);
    ASSERT_EQ(driver.moduleGetFunction(&subtrees, module, "sunstone_subtrees"), CUDA_SUCCESS);
    ASSERT_EQ(driver.moduleGetFunction(&arrange, module, "sunstone_arrange"), CUDA_SUCCESS);
    ASSERT_EQ(driver.moduleGetFunction(&records, module, "sunstone_records"), CUDA_SUCCESS);
    constexpr uint32_t kCount = 40, kWide = 12;
    enum Fault { kCyclic, kTooMany, kWrongParent, kNoParent };
    for (const Fault fault : {kCyclic, kTooMany, kWrongParent, kNoParent}) {
        SCOPED_TRACE(fault);
        const bool cyclic = fault == kCyclic, broken = cyclic || fault == kTooMany;
        Buffer output(sizeof(BlockHeader) + 4096, 0), counters(sizeof(Counters), 0),
            boxes(kCount * 24, 0), binary(kCount * sizeof(BinaryNode), 0), costs(kCount * 8, 0),
            tasks(kWide * 8, 0xFF), order(kCount * 4, 0), links(kWide * 4),
            newNodes(kWide * sizeof(WideNode)), newOrder(kCount * 4),
            report(sizeof(BuildReport), 0);
        auto* const nodes = static_cast<BinaryNode*>(binary.data());
        for (uint32_t i = 0; i < kCount; ++i) { // else a list of primitives
            const uint32_t first = i | 1u << kRefCountShift;
            nodes[i] = {{0, 0, 0}, cyclic ? i : first, {1, 1, 1}, cyclic ? i : i + 1};
        }
        nodes[kCount - 2].right = (kCount - 1) | 1u << kRefCountShift;
        auto& c = *static_cast<Counters*>(counters.data());
        c.numActive = c.numTreeReferences = broken ? kCount - 5 : kCount;
        c.allocated = 1;
        *static_cast<uint64_t*>(tasks.data()) = 0;
        BuildJob job{};
        job.output = output.address();
        job.counters = counters.address();
        job.boxes = boxes.address();
        job.binary = binary.address();
        job.savings = costs.address();
        job.tasks = tasks.address();
        job.order = order.address();
        job.links = links.address();
        job.newNodes = newNodes.address();
        job.newOrder = newOrder.address();
        job.nodes = output.address() + sizeof(BlockHeader);
        job.report = report.address();
        job.numPrimitives = job.maxReferences = kCount;
        job.maxWide = kWide;
        job.type = BlockType::kCustom;
        TreeMode mode = kRadix;
        void* arguments[] = {&job, &mode};
        ASSERT_EQ(driver.launchKernel(collapse, 1, 1, 1, 128, 1, 1, 0, nullptr, arguments, nullptr),
                  CUDA_SUCCESS);
        ASSERT_EQ(driver.ctxSynchronize(), CUDA_SUCCESS);
        EXPECT_EQ(c.finished == uint32_t(c.allocated) && c.allocated >> 32 == c.numTreeReferences,
                  !broken);
        if (!broken) // each of six nodes has the next one
            static_cast<uint32_t*>(links.data())[3] = fault == kWrongParent ? 1 : kWide;
        for (CUfunction next : {subtrees, arrange, records})
            ASSERT_EQ(driver.launchKernel(next, 1, 1, 1, 32, 1, 1, 0, nullptr, arguments, nullptr),
                      CUDA_SUCCESS);
        ASSERT_EQ(driver.ctxSynchronize(), CUDA_SUCCESS);
        const auto& told = *static_cast<const BuildReport*>(report.data());
        EXPECT_EQ(told.count, 1u);
        EXPECT_EQ(told.entries[0].number, 1u);
        EXPECT_EQ(told.entries[0].failure, uint32_t(kTreeBroken));
        EXPECT_EQ(told.entries[0].block, output.address());
        EXPECT_EQ(static_cast<const BlockHeader*>(output.data())->magic, 0u);
    }
    driver.moduleUnload(module);
    EXPECT_TRUE(Device::get().builder().takeFailures().empty());
}

} // namespace
} // namespace sunstone::bvh::gpu
