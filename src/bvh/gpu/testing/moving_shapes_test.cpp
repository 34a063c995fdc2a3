// SPDX-License-Identifier: Apache-2.0
// Curves and spheres with motion keys on the GPU's builder (run on the CPU device) and by its
// traversal: bounds equal those of the CPU's structures to the bit, and so do answers, except for
// the last digits of hits on bent curves, which depend on the piece tested first.
#include "bvh/gpu/testing/device.h"
#include "bvh/testing/moving_shapes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

namespace sunstone::bvh::gpu {
namespace {

using namespace bvh::testing;
using namespace gpu::testing;

GpuStructure onDevice(const MovingShapes& scene, BuildOptions options) {
    options.motion = scene.motion;
    return scene.with([&](const BuildInputs& inputs) { return buildOnDevice(inputs, options); });
}

const KeyBounds* keyBounds(const BlockHeader& header) {
    return reinterpret_cast<const KeyBounds*>(reinterpret_cast<const uint8_t*>(&header) +
                                              header.keyBoundsOffset);
}

void expectSameBounds(const BlockHeader& gpu, const BlockHeader& cpu) {
    EXPECT_EQ(gpu.type, cpu.type);
    EXPECT_EQ(gpu.shape, cpu.shape);
    EXPECT_EQ(gpu.numActive, cpu.numActive);
    ASSERT_EQ(gpu.motionKeys, cpu.motionKeys);
    for (int a = 0; a < 3; ++a) {
        EXPECT_EQ(gpu.lower[a], cpu.lower[a]);
        EXPECT_EQ(gpu.upper[a], cpu.upper[a]);
        for (uint32_t k = 0; k < cpu.motionKeys; ++k) {
            EXPECT_EQ(keyBounds(gpu)[k].lower[a], keyBounds(cpu)[k].lower[a]) << "key " << k;
            EXPECT_EQ(keyBounds(gpu)[k].upper[a], keyBounds(cpu)[k].upper[a]) << "key " << k;
        }
    }
}

constexpr float kTimes[] = {-2, -1, -0.99999f, 0.3f, 1, 2.2f, 3, 7, NAN};

// Compares hits at all times; returns the number of hits.
uint32_t expectSameHits(const void* cpu, uint64_t handle, uint32_t seed) {
    const uint32_t shape = headerOf(cpu)->shape;
    const bool exact = shape == kSphereShape || CurveBasis(shape) == CurveBasis::kLinear;
    Random random(seed);
    uint32_t hits = 0;
    for (const float time : kTimes)
        for (int i = 0; i < 300; ++i) {
            const ShapeRay ray = randomShapeRay(random, time);
            ShapeHit a{}, b{};
            const bool found = shapeKernels(Isa::kBaseline).closest(cpu, ray, a);
            EXPECT_EQ(found, nearestShapeAt(handle, ray, b)) << "ray " << i << " time " << time;
            hits += found;
            if (!found)
                continue;
            EXPECT_NEAR(a.t, b.t, exact ? 0 : 1e-5f * a.t) << "ray " << i << " time " << time;
            EXPECT_NEAR(a.u, b.u, exact ? 0 : 1e-3f) << "ray " << i << " time " << time;
            EXPECT_EQ(a.primitive, b.primitive);
            EXPECT_EQ(a.sbt, b.sbt);
            EXPECT_EQ(a.kind, b.kind);
            if (::testing::Test::HasFailure())
                return hits;
        }
    return hits;
}

TEST(GpuMovingShapes, AreWhereTheCpuHasThem) {
    std::vector<BuildOptions> variants(3);
    variants[1].preferFastTrace = true;
    variants[2].preferFastBuild = variants[2].allowRandomVertexAccess = true;
    for (const uint32_t shape : kMovingKinds)
        for (const uint32_t keys : {2u, 3u, 5u}) {
            SCOPED_TRACE(std::to_string(shape) + " keys " + std::to_string(keys));
            const MovingShapes scene(shape, keys, shape + keys);
            const BuildOptions& options = variants[keys == 5 ? 2 : keys - 2];
            const Structure cpu = scene.structure(options);
            const GpuStructure gpu = onDevice(scene, options);
            expectSameBounds(gpu.header(), *headerOf(cpu.block()));
            const uint32_t hits = expectSameHits(cpu.block(), gpu.handle(), shape ^ keys);
            EXPECT_GT(hits, 150u);
            EXPECT_EQ(hits, expectSameHits(cpu.block(), gpu.loose->address() | devlib::kTagGas,
                                           shape ^ keys));
            if (HasFailure())
                return;
        }
}

TEST(GpuMovingShapes, VanishOutsideOfTheirTime) {
    for (const uint32_t shape : kMovingKinds)
        for (const uint32_t flags : {1u, 2u, 3u}) {
            MovingShapes scene(shape, 2, 77);
            scene.motion.flags = flags;
            const Structure cpu = scene.structure({});
            EXPECT_GT(expectSameHits(cpu.block(), onDevice(scene, {}).handle(), flags), 50u);
        }
}

// Radii that cross zero between keys, and primitives without any surface at one key.
TEST(GpuMovingShapes, RadiiBelowZeroAndInactiveOnes) {
    for (const uint32_t shape : kMovingKinds) {
        SCOPED_TRACE(shape);
        MovingShapes scene(shape, 3, 21);
        const float nan = std::numeric_limits<float>::quiet_NaN();
        const uint32_t points = uint32_t(scene.radii[0].size()) / kMovingCount;
        for (uint32_t i = 0; i < kMovingCount; ++i) {
            const uint32_t first = scene.indices[i];
            if (i % 5 == 1)
                scene.positions[i % 3][first].x = nan;
            if (i % 5 == 2)
                for (uint32_t k = 0; k < points; ++k)
                    scene.radii[i % 3][first + k] = -0.02f; // no surface
            if (i % 5 == 3 && points > 1)
                scene.radii[i % 3][first + i % points] = -0.05f;
        }
        const Structure cpu = scene.structure({});
        const GpuStructure gpu = onDevice(scene, {});
        expectSameBounds(gpu.header(), *headerOf(cpu.block()));
        EXPECT_EQ(gpu.header().numActive, kMovingCount / 5 * 3);
        EXPECT_GT(expectSameHits(cpu.block(), gpu.handle(), 4), 50u);
        for (Vec3& p : scene.positions[1])
            p.y = std::numeric_limits<float>::infinity();
        EXPECT_EQ(onDevice(scene, {}).header().root, kNoNode);
    }
}

// After an update, hits equal those of a structure built from the new input.
TEST(GpuMovingShapes, UpdatesFollow) {
    for (const uint32_t shape : kMovingKinds) {
        SCOPED_TRACE(shape);
        MovingShapes first(shape, 3, 5), second(shape, 3, 6);
        first.positions[1][first.indices[9]].x = NAN; // becomes active
        second.radii[2][second.indices[20]] = NAN;
        BuildOptions options;
        options.allowUpdate = options.allowRandomVertexAccess = true;
        const GpuStructure s = onDevice(first, options);
        options.motion = second.motion;
        second.with([&](const BuildInputs& inputs) {
            const Device& device = Device::get();
            Buffer temp(Builder::computeMemoryUsage(inputs, options).tempUpdate);
            BuildOptions wrong = options;
            wrong.motion.end += 1;
            const auto update = [&](const BuildOptions& with) {
                device.builder().update(nullptr, inputs, with, temp.address(), temp.size(),
                                        s.memory->address(), s.memory->size());
            };
            EXPECT_THROW(update(wrong), Error);
            update(options);
            update(options); // queued behind the first
            ASSERT_EQ(device.driver().ctxSynchronize(), CUDA_SUCCESS);
            EXPECT_TRUE(device.builder().takeFailures().empty());
        });
        const Structure cpu = second.structure({});
        expectSameBounds(s.header(), *headerOf(cpu.block()));
        EXPECT_GT(expectSameHits(cpu.block(), s.handle(), 9), 150u);
        // The points are those of the new keys, in order.
        const uint32_t points = uint32_t(second.radii[0].size()) / kMovingCount;
        const float* const at = reinterpret_cast<const float*>(
            static_cast<const uint8_t*>(s.memory->data()) + s.header().pointsOffset);
        for (uint32_t key = 0; key < 3; ++key) {
            const float* const p = at + (17 * 3 + key) * 4 * points;
            EXPECT_EQ(p[1], second.positions[key][second.indices[17]].y);
            EXPECT_EQ(p[3], second.radii[key][second.indices[17]]);
        }
    }
}

// An update from the input of the build equals the build, which also has places for inactive
// primitives.
TEST(GpuMovingShapes, UpdatesFromTheSameInputChangeNothing) {
    for (const uint32_t shape : kMovingKinds) {
        MovingShapes scene(shape, 2, 31);
        scene.positions[1][scene.indices[3]].z = NAN;
        BuildOptions options;
        options.allowUpdate = true;
        options.motion = scene.motion;
        const GpuStructure s = onDevice(scene, options);
        const auto* const bytes = static_cast<const uint8_t*>(s.memory->data());
        const std::vector<uint8_t> before(bytes, bytes + s.memory->size());
        scene.with([&](const BuildInputs& inputs) {
            const Device& device = Device::get();
            Buffer temp(Builder::computeMemoryUsage(inputs, options).tempUpdate);
            device.builder().update(nullptr, inputs, options, temp.address(), temp.size(),
                                    s.memory->address(), s.memory->size());
            ASSERT_EQ(device.driver().ctxSynchronize(), CUDA_SUCCESS);
        });
        EXPECT_TRUE(std::equal(before.begin(), before.end(), bytes)) << shape;
    }
}

} // namespace
} // namespace sunstone::bvh::gpu
