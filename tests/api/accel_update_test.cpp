// SPDX-License-Identifier: Apache-2.0
// Updates through the API, tested by rays against a new build of the same input; and refused
// updates.
#include "device/probe.h"
#include "rig.h"
#include "scene.h"

#include <cmath>

namespace tests::api {
namespace {

constexpr unsigned kUpdate = OPTIX_BUILD_FLAG_ALLOW_UPDATE;

class AccelUpdateTest : public ApiTest {
protected:
    void SetUp() override {
        ApiTest::SetUp();
        rig_ =
            std::make_unique<Rig>(context_, log_, compiledPtx("probe", "clang"), compileOptions(4));
        rig_->raygenRecord(rig_->raygen("__raygen__probe"));
        rig_->missRecord(rig_->miss("__miss__probe"), ProbeData{});
        size_t group = rig_->hit("__closesthit__probe", nullptr, "__intersection__probe");
        spheres_ = Buffer(std::vector<float>(4 * 64, 0));
        for (unsigned i = 0; i < 4; ++i)
            rig_->hitRecord(group, ProbeData{i, 0, spheres_.as<float>(), 0, 0});
        rig_->link();
    }
    void TearDown() override {
        rig_.reset();
        ApiTest::TearDown();
    }

    // Primitive index hit by each ray of a grid along z (~0u: none).
    std::vector<unsigned> hits(OptixTraversableHandle handle) {
        std::vector<ProbeRay> list;
        for (unsigned i = 0; i < 900; ++i) {
            const float x = (float(i % 30) + 0.37f) / 7.5f - 2,
                        y = (float(i / 30) + 0.41f) / 7.5f - 2;
            list.push_back({{x, y, -50}, 0, {0, 0, 1}, 1000, 0, 255, 0, 0, 1, 0, handle});
        }
        Buffer in(list), out(list.size() * sizeof(ProbeResult));
        rig_->run(ProbeParams{in.as<ProbeRay>(), out.as<ProbeResult>()}, unsigned(list.size()));
        std::vector<unsigned> found;
        for (size_t i = 0; i < list.size(); ++i) {
            const ProbeResult& r = out.as<ProbeResult>()[i];
            found.push_back(r.closestHits ? r.closestHit.primitive * 16 + r.closestHit.instanceIndex
                                          : ~0u);
        }
        return found;
    }
    static size_t count(const std::vector<unsigned>& found) {
        return found.size() - size_t(std::count(found.begin(), found.end(), ~0u));
    }

    OptixResult update(const OptixBuildInput& input, Accel& accel, unsigned flags = kUpdate,
                       const std::vector<OptixAccelEmitDesc>& emit = {}) {
        OptixAccelBuildOptions options = buildOptions(flags);
        OptixAccelBufferSizes sizes{};
        EXPECT_OK(optixAccelComputeMemoryUsage(context_, &options, &input, 1, &sizes));
        Buffer temp(sizes.tempUpdateSizeInBytes);
        options.operation = OPTIX_BUILD_OPERATION_UPDATE;
        OptixTraversableHandle handle = 0;
        const OptixResult result =
            optixAccelBuild(context_, nullptr, &options, &input, 1, temp.address(), temp.size(),
                            accel.memory.address(), accel.memory.size(), &handle, emit.data(),
                            unsigned(emit.size()));
        waitForDevice();
        if (result == OPTIX_SUCCESS) {
            EXPECT_EQ(accel.handle, handle);
        }
        return result;
    }

    Accel compacted(const Accel& from, uint64_t size) {
        Accel to;
        to.memory = Buffer(size);
        EXPECT_OK(optixAccelCompact(context_, nullptr, from.handle, to.memory.address(), size,
                                    &to.handle));
        waitForDevice();
        return to;
    }

    std::unique_ptr<Rig> rig_;
    Buffer spheres_;
};

std::vector<Vec3> randomTriangles(unsigned count, unsigned seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<float> at(-2, 2), to(-0.4f, 0.4f);
    std::vector<Vec3> vertices;
    for (unsigned i = 0; i < count; ++i) {
        const Vec3 c{at(random), at(random), at(random)};
        for (int k = 0; k < 3; ++k)
            vertices.push_back({c.x + to(random), c.y + to(random), c.z + to(random)});
    }
    return vertices;
}

std::vector<uint32_t> ascending(unsigned count) {
    std::vector<uint32_t> indices(count);
    for (unsigned i = 0; i < count; ++i)
        indices[i] = i;
    return indices;
}

TEST_F(AccelUpdateTest, TrianglesFollowTheirVerticesAlsoWhenCompacted) {
    const std::vector<Vec3> first = randomTriangles(500, 1), second = randomTriangles(500, 2);
    TriangleMesh mesh(first, ascending(1500));
    TriangleMesh moved(second, ascending(1500));
    Buffer size(8), boxes(sizeof(OptixAabb));
    const unsigned flags = kUpdate | OPTIX_BUILD_FLAG_ALLOW_COMPACTION;
    Accel accel = buildAccel(context_, log_, {mesh.input}, flags,
                             {{size.address(), OPTIX_PROPERTY_TYPE_COMPACTED_SIZE}});
    Accel small = compacted(accel, *size.as<uint64_t>());
    EXPECT_LT(small.memory.size(), accel.memory.size());
    const Accel judge = buildAccel(context_, log_, {moved.input});
    const std::vector<unsigned> expected = hits(judge.handle);
    EXPECT_GT(count(expected), 300u);
    EXPECT_NE(expected, hits(accel.handle));
    EXPECT_OK(update(moved.input, accel, flags, {{boxes.address(), OPTIX_PROPERTY_TYPE_AABBS}}));
    EXPECT_EQ(expected, hits(accel.handle));
    float low = 100;
    for (const Vec3& v : second)
        low = std::min(low, v.y);
    EXPECT_EQ(low, boxes.as<OptixAabb>()->minY);
    EXPECT_NE(expected, hits(small.handle));
    EXPECT_OK(update(moved.input, small, flags));
    EXPECT_EQ(expected, hits(small.handle));
    // And back, from the same buffers with other contents.
    std::memcpy(moved.vertices.as<void>(), first.data(), first.size() * sizeof(Vec3));
    EXPECT_OK(update(moved.input, small, flags));
    EXPECT_EQ(hits(buildAccel(context_, log_, {mesh.input}).handle), hits(small.handle));
}

TEST_F(AccelUpdateTest, CustomPrimitivesAndInstances) {
    std::vector<OptixAabb> list;
    for (unsigned i = 0; i < 8; ++i)
        list.push_back({float(i) / 2 - 2, -2, 0, float(i) / 2 - 1.6f, 2, 1});
    for (unsigned i = 0; i < 8; ++i) {
        float* sphere = spheres_.as<float>() + 4 * i;
        sphere[0] = float(i) / 2 - 1.8f, sphere[1] = 0.3f, sphere[2] = 0.5f, sphere[3] = 0.3f;
    }
    CustomBoxes boxes(list);
    Accel customs = buildAccel(context_, log_, {boxes.input}, kUpdate);
    const std::vector<unsigned> before = hits(customs.handle);
    EXPECT_GT(count(before), 20u);
    for (unsigned i = 0; i < 8; ++i) {
        spheres_.as<float>()[4 * i + 1] = -1.2f;
        boxes.memory.as<OptixAabb>()[i].minZ = -1;
    }
    EXPECT_OK(update(boxes.input, customs));
    EXPECT_EQ(hits(buildAccel(context_, log_, {boxes.input}).handle), hits(customs.handle));
    EXPECT_NE(before, hits(customs.handle));

    TriangleMesh mesh(randomTriangles(50, 3), ascending(150));
    Accel child = buildAccel(context_, log_, {mesh.input}, kUpdate);
    std::vector<OptixInstance> instances;
    for (unsigned i = 0; i < 6; ++i)
        instances.push_back(instanceOf(child.handle, translation(float(i), 0, 0), i));
    InstanceList top(instances);
    Accel ias = buildAccel(context_, log_, {top.input}, kUpdate);
    for (unsigned i = 0; i < 6; ++i)
        top.memory.as<OptixInstance>()[i] =
            instanceOf(child.handle, translation(-0.7f * float(i), 0.2f * float(i), 0), i, 0,
                       i == 2 ? 0 : 255);
    EXPECT_OK(update(top.input, ias));
    const std::vector<unsigned> expected = hits(buildAccel(context_, log_, {top.input}).handle);
    EXPECT_GT(count(expected), 200u);
    EXPECT_EQ(expected, hits(ias.handle));
    // A child that moves, then its parent's boxes.
    const std::vector<Vec3> grown = randomTriangles(50, 4);
    std::memcpy(mesh.vertices.as<void>(), grown.data(), grown.size() * sizeof(Vec3));
    EXPECT_OK(update(mesh.input, child));
    EXPECT_OK(update(top.input, ias));
    EXPECT_EQ(hits(buildAccel(context_, log_, {top.input}).handle), hits(ias.handle));
}

TEST_F(AccelUpdateTest, WhatIsNoUpdateOfTheStructureIsRefused) {
    TriangleMesh mesh(randomTriangles(20, 1), ascending(60));
    Accel accel = buildAccel(context_, log_, {mesh.input}, kUpdate);
    Accel fixed = buildAccel(context_, log_, {mesh.input});
    const auto refuse = [&](const OptixBuildInput& input, Accel& target, unsigned flags,
                            const char* mention) {
        EXPECT_REJECTED(OPTIX_ERROR_INVALID_VALUE, "optixAccelBuild", mention,
                        update(input, target, flags));
    };
    refuse(mesh.input, accel, 0, "ALLOW_UPDATE");
    refuse(mesh.input, accel, kUpdate | OPTIX_BUILD_FLAG_PREFER_FAST_BUILD, "build flags");
    refuse(mesh.input, fixed, kUpdate, "ALLOW_UPDATE");
    Accel nothing;
    nothing.memory = Buffer(accel.memory.size());
    refuse(mesh.input, nothing, kUpdate, "acceleration structure");
    OptixBuildInput other = mesh.input;
    other.triangleArray.numIndexTriplets = 19;
    refuse(other, accel, kUpdate, "primitives");
    other = mesh.input;
    other.triangleArray.numVertices = 59;
    refuse(other, accel, kUpdate, "vertices");
    const unsigned geometryFlags[1] = {OPTIX_GEOMETRY_FLAG_DISABLE_ANYHIT};
    other = mesh.input;
    other.triangleArray.flags = geometryFlags;
    refuse(other, accel, kUpdate, "flags");
    CustomBoxes boxes(std::vector<OptixAabb>(20, OptixAabb{0, 0, 0, 1, 1, 1}));
    refuse(boxes.input, accel, kUpdate, "type");
    // Buffers.
    OptixAccelBuildOptions options = buildOptions(kUpdate);
    OptixAccelBufferSizes sizes{};
    ASSERT_OK(optixAccelComputeMemoryUsage(context_, &options, &mesh.input, 1, &sizes));
    EXPECT_LT(sizes.tempUpdateSizeInBytes, sizes.tempSizeInBytes);
    ASSERT_GT(sizes.tempUpdateSizeInBytes, 0u);
    options.operation = OPTIX_BUILD_OPERATION_UPDATE;
    Buffer temp(sizes.tempUpdateSizeInBytes);
    OptixTraversableHandle handle = 0;
    EXPECT_REJECTED(OPTIX_ERROR_INVALID_VALUE, "optixAccelBuild", "tempBuffer",
                    optixAccelBuild(context_, nullptr, &options, &mesh.input, 1, temp.address(),
                                    temp.size() - 1, accel.memory.address(), accel.memory.size(),
                                    &handle, nullptr, 0));
    EXPECT_REJECTED(OPTIX_ERROR_INVALID_VALUE, "optixAccelBuild", "output buffer",
                    optixAccelBuild(context_, nullptr, &options, &mesh.input, 1, temp.address(),
                                    temp.size(), accel.memory.address(), 256, &handle, nullptr, 0));
    EXPECT_OK(update(mesh.input, accel));
}

} // namespace
} // namespace tests::api
