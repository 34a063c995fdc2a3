// SPDX-License-Identifier: Apache-2.0
// Equal inputs give equal bytes on the GPU's builder (run on the CPU device, which runs blocks in
// the order its threads take them), whatever the buffers held before.
#include "bvh/gpu/testing/device.h"
#include "bvh/micromap/micromap_array.h"
#include "bvh/motion/transforms.h"
#include "bvh/testing/moving_shapes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace sunstone::bvh::gpu {
namespace {

using namespace bvh::testing;
using namespace gpu::testing;
using bvh::testing::Mesh;

// The result of a build in a buffer filled with a byte, and its compacted copy in another buffer.
struct Built {
    std::vector<uint8_t> loose, compacted;
    const BlockHeader& header() const {
        return *reinterpret_cast<const BlockHeader*>(compacted.data());
    }
};

std::vector<uint8_t> bytesOf(const Buffer& buffer) {
    const auto* const data = static_cast<const uint8_t*>(buffer.data());
    return {data, data + buffer.size()};
}

Built buildOver(int fill, const BuildInputs& inputs, const BuildOptions& options) {
    const Device& device = Device::get();
    const MemoryUsage usage = Builder::computeMemoryUsage(inputs, options);
    const Buffer temp(usage.temp, fill), output(usage.output, fill), size(8);
    device.builder().build(nullptr, inputs, options, temp.address(), usage.temp, output.address(),
                           usage.output);
    device.builder().emitCompactedSize(nullptr, output.address(), size.address());
    EXPECT_EQ(device.driver().ctxSynchronize(), CUDA_SUCCESS);
    const Buffer copy(*static_cast<const uint64_t*>(size.data()), fill);
    device.builder().compact(nullptr, output.address(), copy.address(), copy.size());
    EXPECT_EQ(device.driver().ctxSynchronize(), CUDA_SUCCESS);
    return {bytesOf(output), bytesOf(copy)};
}

// The first difference of two structures.
void expectSame(const std::vector<uint8_t>& a, const std::vector<uint8_t>& b, const char* what) {
    ASSERT_EQ(a.size(), b.size()) << what;
    const auto at = std::mismatch(a.begin(), a.end(), b.begin()).first;
    if (at == a.end())
        return;
    const auto& header = *reinterpret_cast<const BlockHeader*>(a.data());
    ADD_FAILURE() << what << ": byte " << at - a.begin() << " of " << a.size() << "; instances at "
                  << header.instancesOffset << ", points at " << header.pointsOffset
                  << ", bounds at keys at " << header.keyBoundsOffset << ", records at "
                  << header.recordsOffset << ", nodes at " << header.nodesOffset;
}

void expectRepeatable(const BuildInputs& inputs, const BuildOptions& options, uint32_t leastNodes) {
    constexpr int kFills[] = {0, 0xFF, 0};
    std::vector<Built> builds;
    for (const int fill : kFills)
        builds.push_back(buildOver(fill, inputs, options));
    EXPECT_EQ(builds[0].header().magic, kGpuBlockMagic);
    EXPECT_GE(builds[0].header().numNodes, leastNodes);
    for (size_t i = 1; i < builds.size(); ++i)
        expectSame(builds[0].compacted, builds[i].compacted, "copies");
    expectSame(builds[0].loose, builds[2].loose, "structures");
    Device::get().buildAsLarge(true);
    expectSame(builds[0].compacted, buildOver(0xFF, inputs, options).compacted,
               "builds in one block and in many");
    Device::get().buildAsLarge(false);
}

// Long thin triangles, some of them inactive.
Mesh splinters(uint32_t count) {
    Mesh mesh;
    Random random(31);
    for (uint32_t i = 0; i < count; ++i) {
        const Vec3 p = random.point(1), along = random.unit() * random(0.1f, 1.2f);
        mesh.vertices.insert(mesh.vertices.end(), {p, p + along, p + random.unit() * 0.004f});
        if (i % 10 == 3)
            mesh.vertices.back() = p;
        mesh.triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
    }
    return mesh;
}

// All options that affect the tree.
std::vector<BuildOptions> modes() {
    std::vector<BuildOptions> modes(5);
    modes[1].preferFastBuild = true;
    modes[2].preferFastTrace = true;
    modes[3].allowUpdate = true;
    modes[4].allowRandomVertexAccess = modes[4].preferFastTrace = true;
    return modes;
}

TEST(GpuRepeat, Triangles) {
    const Mesh dense = soup(600, 0.1f, 3), thin = splinters(300);
    const TriangleInput list[] = {dense.input(), thin.input()};
    BuildInputs inputs;
    inputs.triangles = list;
    for (const BuildOptions& options : modes())
        expectRepeatable(inputs, options, 60);
}

TEST(GpuRepeat, FewTriangles) {
    for (uint32_t count : {0u, 1u, 3u, 9u, 30u}) {
        SCOPED_TRACE(count);
        const Mesh mesh = soup(count, 0.7f, count);
        const TriangleInput input = mesh.input();
        BuildInputs inputs;
        inputs.triangles = {&input, 1};
        BuildOptions options;
        options.allowRandomVertexAccess = true;
        expectRepeatable(inputs, options, count != 0);
    }
}

TEST(GpuRepeat, TriangleMicromaps) {
    const MicromapHistogramEntry histogram = {2, 2, MicromapFormat::kTwoState};
    const MicromapDesc descriptions[] = {{0, 2, 1}, {2, 2, 1}};
    const uint8_t states[] = {0x5A, 0x31, 0x66, 0x99};
    const MicromapArrayInput array = {{&histogram, 1}, states, descriptions, 0};
    std::vector<uint8_t> first;
    for (int fill : {0, 0xFF}) {
        const Buffer memory(micromapArraySizes(array.histogram).output, fill);
        Device::get().builder().buildMicromapArray(nullptr, array, sizeof states, memory.address(),
                                                   memory.size());
        ASSERT_EQ(Device::get().driver().ctxSynchronize(), CUDA_SUCCESS);
        ASSERT_TRUE(isMicromapArray(memory.data()));
        if (first.empty())
            first = bytesOf(memory);
        expectSame(first, bytesOf(memory), "arrays");
        const Mesh mesh = soup(201, 0.1f, 8);
        std::vector<int32_t> indices;
        for (int32_t i = 0; i < 201; ++i)
            indices.push_back(i % 4 - 2);
        TriangleInput list[] = {mesh.input(), mesh.input()};
        list[1].micromaps = {MicromapIndexing::kIndexed, memory.data(), indices.data(), 4, 0, 0};
        BuildInputs inputs;
        inputs.triangles = list;
        BuildOptions options;
        options.allowRandomVertexAccess = true;
        expectRepeatable(inputs, options, 20);
    }
}

TEST(GpuRepeat, CustomPrimitives) {
    Random random(8);
    std::vector<Box> boxes(400);
    for (Box& b : boxes) {
        const Vec3 c = random.point(1);
        b.lower = c - Vec3{0.05f, 0.1f, 0.02f};
        b.upper = c + Vec3{0.05f, 0.1f, 0.02f};
    }
    boxes[17].lower.x = NAN;
    CustomInput input;
    input.aabbs = boxes.data();
    input.numPrimitives = uint32_t(boxes.size());
    const void* const keys[] = {boxes.data(), boxes.data(), boxes.data()};
    input.keyAabbs = keys;
    BuildInputs inputs;
    inputs.customs = {&input, 1};
    for (uint32_t numKeys : {1u, 3u}) {
        BuildOptions options;
        options.allowUpdate = numKeys == 3;
        options.motion = {numKeys, 0, 0, 1};
        expectRepeatable(inputs, options, 50);
    }
}

TEST(GpuRepeat, CurvesAndSpheres) {
    for (const uint32_t shape : kMovingKinds)
        for (const uint32_t keys : {1u, 3u}) {
            SCOPED_TRACE(std::to_string(shape) + " keys " + std::to_string(keys));
            const MovingShapes scene(shape, keys, 5);
            BuildOptions options;
            options.preferFastTrace = true; // in pieces
            options.motion = scene.motion;
            scene.with([&](const BuildInputs& inputs) { expectRepeatable(inputs, options, 20); });
        }
}

TEST(GpuRepeat, MovingTriangles) {
    const Mesh first = soup(400, 0.1f, 1);
    Mesh second = first;
    Random random(2);
    for (Vec3& v : second.vertices)
        v = v + random.point(0.3f);
    const void* const keys[] = {first.vertices.data(), second.vertices.data()};
    TriangleInput input = first.input();
    input.keyVertices = keys;
    BuildInputs inputs;
    inputs.triangles = {&input, 1};
    BuildOptions options;
    options.motion = {2, 0, 0, 1};
    expectRepeatable(inputs, options, 40);
}

// Some with invalid children, some through motion transforms.
TEST(GpuRepeat, Instances) {
    const GpuStructure child = buildOnDevice(icosphere(2).input());
    Random random(12);
    MatrixMotionTransform transform{};
    transform.child = child.handle();
    transform.motion = {2, 0, 0, 1};
    for (auto& matrix : transform.matrices)
        for (int a = 0; a < 3; ++a) {
            matrix[5 * a] = 1;
            matrix[4 * a + 3] = random(-1, 1);
        }
    std::vector<InstanceDesc> list(300);
    std::vector<uint64_t> addresses;
    for (InstanceDesc& instance : list) {
        const Vec3 place = random.point(1);
        instance = {};
        for (int a = 0; a < 3; ++a) {
            for (int b = 0; b < 3; ++b)
                instance.transform[4 * a + b] = random(-0.1f, 0.1f);
            instance.transform[4 * a + 3] = place[a];
        }
        instance.visibilityMask = 255;
        instance.traversableHandle = child.handle();
        addresses.push_back(uint64_t(&instance));
    }
    addresses[5] += 4; // no address of an instance
    list[7].visibilityMask = 0;
    InstanceInput input;
    input.instancePointers = addresses.data();
    input.numInstances = uint32_t(list.size());
    BuildInputs inputs;
    inputs.instances = &input;
    for (const bool moves : {false, true}) {
        for (size_t i = 0; moves && i < list.size(); i += 3)
            list[i].traversableHandle = uint64_t(&transform) | devlib::kTagMatrixMotion;
        for (uint32_t numKeys : {1u, 2u}) {
            SCOPED_TRACE(numKeys);
            BuildOptions options;
            options.preferFastBuild = !moves;
            options.motion = {numKeys, 0, 0, 1};
            expectRepeatable(inputs, options, 40);
        }
    }
}

} // namespace
} // namespace sunstone::bvh::gpu
