// SPDX-License-Identifier: Apache-2.0
// Sizes of structures, and triangles that several leaves share.
#include "bvh/gpu/build/shared_records.h"
#include "bvh/gpu/testing/device.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>

namespace sunstone::bvh::gpu {
namespace {

using namespace bvh::testing;
using namespace gpu::testing;
using bvh::testing::Mesh;

// Triangles that start anywhere and are so long and wide.
Mesh strips(uint32_t count, float length, float width, uint32_t seed) {
    Mesh mesh;
    Random random(seed);
    for (uint32_t i = 0; i < count; ++i) {
        const Vec3 p = random.point(1), along = random.unit() * random(0.2f * length, length);
        mesh.vertices.insert(mesh.vertices.end(), {p, p + along, p + random.unit() * width});
        mesh.triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
    }
    return mesh;
}

struct Shape {
    const char* name;
    Mesh mesh;
};
std::vector<Shape> shapes(uint32_t count) {
    Mesh mixed = strips(count / 2, 1.0f, 0.002f, 5);
    const Mesh small = soup(count - count / 2, 0.02f, 6);
    for (uint32_t i = 0; i < small.triangles.size(); ++i) {
        const uint32_t first = uint32_t(mixed.vertices.size());
        for (uint32_t k = 0; k < 3; ++k)
            mixed.vertices.push_back(small.vertices[3 * i + k]);
        mixed.triangles.push_back({first, first + 1, first + 2});
    }
    Mesh parallel = strips(count, 0.0f, 0.0f, 7); // one beside the other, none along an axis
    for (uint32_t i = 0; i < count; ++i) {
        const float x = float(i) / float(count);
        parallel.vertices[3 * i + 1] = parallel.vertices[3 * i] + Vec3{1, 1, 1};
        parallel.vertices[3 * i + 2] = parallel.vertices[3 * i] + Vec3{1, 1.001f, 1 + x * 0.001f};
    }
    return {{"needles", strips(count, 1.0f, 1e-4f, 1)},
            {"strips", strips(count, 0.5f, 0.01f, 2)},
            {"short strips", strips(count, 0.05f, 0.002f, 3)},
            {"random", soup(count, 0.1f, 4)},
            {"random, as large as the scene", soup(count, 2.0f, 4)},
            {"half needles", mixed},
            {"parallel needles", parallel},
            {"rough sphere", roughSphere(3, 8)}};
}

void expectWithinPromise(const Shape& shape, const BuildOptions& options) {
    const TriangleInput input = shape.mesh.input();
    BuildInputs inputs;
    inputs.triangles = {&input, 1};
    const double triangles = double(shape.mesh.triangles.size());
    const GpuStructure s = buildOnDevice(inputs, options);
    EXPECT_LE(double(s.memory->size()) / triangles, options.allowRandomVertexAccess ? 80.0 : 60.0);
    EXPECT_LE(double(Builder::computeMemoryUsage(inputs, options).temp) / triangles, 100.0);
    // Triangles are split, and share records, only if rays gain.
    const std::string name = shape.name;
    const bool splits = options.preferFastTrace &&
                        (name.find("needles") != name.npos || name.find("strips") != name.npos);
    EXPECT_EQ(s.header().numLeaves > s.header().numActive, splits);
    EXPECT_EQ(bool(s.header().sharesRecords), splits);
}

// Bytes a triangle of compacted structures, and of scratch memory.
TEST(GpuMemory, IsWithinThePromiseForAllShapes) {
    BuildOptions access, fastTrace;
    access.allowRandomVertexAccess = fastTrace.allowRandomVertexAccess = true;
    fastTrace.preferFastTrace = true;
    for (const Shape& shape : shapes(1000)) {
        SCOPED_TRACE(shape.name);
        expectWithinPromise(shape, {});
        expectWithinPromise(shape, access);
        expectWithinPromise(shape, fastTrace);
    }
    const std::vector<Shape> larger = shapes(4000);
    for (uint32_t i : {0u, 2u}) {
        SCOPED_TRACE(larger[i].name);
        expectWithinPromise(larger[i], fastTrace);
    }
}

// Several inputs with different offsets and SBT records, and inactive triangles.
TEST(GpuMemory, SharedTrianglesTellTheirInputs) {
    std::vector<Mesh> meshes = {strips(700, 1.0f, 0.003f, 11), strips(300, 0.6f, 0.002f, 12)};
    for (uint32_t i = 0; i < 700; i += 9)
        meshes[0].vertices[3 * i + 1] = meshes[0].vertices[3 * i]; // no area
    for (uint32_t i = 0; i < 300; i += 7)
        meshes[1].triangles[i][2] = 100000; // no such vertex
    std::vector<uint8_t> offsets(300);
    for (uint32_t i = 0; i < 300; ++i)
        offsets[i] = uint8_t(i % 3);
    const std::array<uint32_t, 3> flags = {kGeometryDisableAnyHit, 0, 0};
    std::vector<TriangleInput> list = {meshes[0].input(), meshes[1].input()};
    list[0].sbt.primitiveIndexOffset = 5000;
    list[1].sbt.numSbtRecords = 3;
    list[1].sbt.flags = flags.data();
    list[1].sbt.indexOffsets = offsets.data();
    list[1].sbt.indexOffsetSize = 1;
    BuildInputs inputs;
    inputs.triangles = list;
    for (bool access : {false, true}) {
        BuildOptions options;
        options.preferFastTrace = true;
        options.allowRandomVertexAccess = access;
        const GpuStructure gpu = buildOnDevice(inputs, options);
        const Structure cpu = makeStructure(inputs);
        ASSERT_TRUE(gpu.header().sharesRecords);
        EXPECT_GT(gpu.header().numLeaves, gpu.header().numActive * 3 / 2);
        Random random(13);
        uint32_t hits = 0;
        for (uint32_t i = 0; i < 6000; ++i) {
            const Vec3 o = random.point(1), d = random.unit();
            const QueryRay ray{{o.x, o.y, o.z}, 0, {d.x, d.y, d.z}, 1e30f};
            QueryHit a{}, b{};
            const bool found = kernels(chosenIsa()).closest(cpu.block(), ray, a);
            ASSERT_EQ(nearest(gpu.handle(), ray, b), found);
            if (!found)
                continue;
            ++hits;
            ASSERT_EQ(a.primitive, b.primitive);
            ASSERT_EQ(a.sbt, b.sbt);
            ASSERT_EQ(a.t, b.t);
        }
        EXPECT_GT(hits, 100u);
        if (!access)
            continue;
        for (const auto& memory : {gpu.memory, gpu.loose}) {
            const auto* bytes = static_cast<const uint8_t*>(memory->data());
            const BlockHeader& header = *static_cast<const BlockHeader*>(memory->data());
            const auto* table = reinterpret_cast<const uint32_t*>(bytes + header.tableOffset);
            const auto* records =
                reinterpret_cast<const TriangleRecord*>(bytes + header.recordsOffset);
            for (uint32_t i = 0; i < 1000; ++i) {
                const bool active = i < 700 ? i % 9 != 0 : (i - 700) % 7 != 0;
                ASSERT_EQ(table[i] != kNoSlot, active) << i;
                if (active)
                    ASSERT_EQ(records[table[i]].primitive, i < 700 ? 5000 + i : i - 700);
            }
        }
    }
}

} // namespace
} // namespace sunstone::bvh::gpu
