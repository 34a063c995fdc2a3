// SPDX-License-Identifier: Apache-2.0
// Spheres through the API (OptiX 7.5): build inputs and their errors, the built-in intersection
// module, hits on both sides, optixGetSphereData, motion, updates.
#include "spheres.h"
#include "rig.h"
#include "scene.h"

#include <cmath>

namespace tests::api {
namespace {

constexpr unsigned kSphereKind = 0x86, kSphereKindBack = 0x96;

OptixPipelineCompileOptions sphereOptions(bool motion = false) {
    OptixPipelineCompileOptions options = compileOptions(0);
    options.usesPrimitiveTypeFlags = OPTIX_PRIMITIVE_TYPE_FLAGS_SPHERE;
    options.usesMotionBlur = motion;
    return options;
}

// Spheres of radius 1 in a row along x, 4 apart, once for each motion key. Must not move.
struct Row {
    explicit Row(unsigned count, unsigned numKeys = 1) : points(numKeys), widths(numKeys) {
        for (unsigned key = 0; key < numKeys; ++key)
            for (unsigned i = 0; i < count; ++i) {
                points[key].push_back({4.0f * float(i), 4.0f * float(key), 0});
                widths[key].push_back(1.0f + float(key));
            }
        input.type = OPTIX_BUILD_INPUT_TYPE_SPHERES;
        input.sphereArray.numVertices = count;
        input.sphereArray.flags = flags.data();
        input.sphereArray.numSbtRecords = 1;
        upload();
    }
    Row(const Row&) = delete;
    void upload() {
        vertices.clear(), radii.clear(), vertexAddresses.clear(), radiusAddresses.clear();
        for (size_t key = 0; key < points.size(); ++key) {
            vertices.emplace_back(points[key]);
            radii.emplace_back(widths[key]);
            vertexAddresses.push_back(vertices[key].address());
            radiusAddresses.push_back(radii[key].address());
        }
        input.sphereArray.vertexBuffers = vertexAddresses.data();
        input.sphereArray.radiusBuffers = radiusAddresses.data();
    }

    std::vector<std::vector<Vec3>> points;
    std::vector<std::vector<float>> widths;
    std::vector<unsigned> flags = {0, 0, 0};
    std::vector<Buffer> vertices, radii;
    std::vector<CUdeviceptr> vertexAddresses, radiusAddresses;
    OptixBuildInput input{};
};

class SphereTest : public ApiTest {
protected:
    void prepare(bool anyHit, bool motion = false) {
        rig_ = std::make_unique<Rig>(context_, log_, compiledPtx("../api76/spheres", "clang"),
                                     sphereOptions(motion));
        OptixBuiltinISOptions builtin{};
        builtin.builtinISModuleType = OPTIX_PRIMITIVE_TYPE_SPHERE;
        builtin.usesMotionBlur = motion;
        OptixModuleCompileOptions module{};
        const OptixPipelineCompileOptions pipeline = sphereOptions(motion);
        require(optixBuiltinISModuleGet(context_, &module, &pipeline, &builtin, &builtin_),
                "optixBuiltinISModuleGet", log_);
        OptixProgramGroupDesc desc{};
        desc.kind = OPTIX_PROGRAM_GROUP_KIND_HITGROUP;
        desc.hitgroup.moduleCH = rig_->module();
        desc.hitgroup.entryFunctionNameCH = "__closesthit__spheres";
        desc.hitgroup.moduleIS = builtin_;
        if (anyHit) {
            desc.hitgroup.moduleAH = rig_->module();
            desc.hitgroup.entryFunctionNameAH = "__anyhit__spheres";
        }
        rig_->raygenRecord(rig_->raygen("__raygen__spheres"));
        rig_->missRecord(rig_->miss("__miss__spheres"));
        const size_t group = rig_->add(desc);
        for (int i = 0; i < 4; ++i)
            rig_->hitRecord(group);
        rig_->link();
    }
    void TearDown() override {
        rig_.reset();
        if (builtin_)
            EXPECT_EQ(OPTIX_SUCCESS, optixModuleDestroy(builtin_));
        builtin_ = nullptr;
        ApiTest::TearDown();
    }
    std::vector<SphereResult> trace(const std::vector<SphereRay>& rays,
                                    OptixTraversableHandle handle, unsigned ignore = 0,
                                    float time = 0) {
        Buffer in(rays), out(rays.size() * sizeof(SphereResult));
        rig_->run(SphereParams{handle, in.as<SphereRay>(), out.as<SphereResult>(), ignore, time},
                  unsigned(rays.size()));
        return {out.as<SphereResult>(), out.as<SphereResult>() + rays.size()};
    }
    static SphereRay down(float x, float y = 0, float z = 4) {
        return {{x, y, z}, 0, {0, 0, -1}, 1e16f, 0};
    }

    std::unique_ptr<Rig> rig_;
    OptixModule builtin_ = nullptr;
};

TEST_F(SphereTest, HitsFromOutsideAndWithin) {
    prepare(false);
    Row row(3);
    row.input.sphereArray.primitiveIndexOffset = 50;
    const Accel accel = buildAccel(context_, log_, {row.input},
                                   OPTIX_BUILD_FLAG_ALLOW_RANDOM_VERTEX_ACCESS);
    const auto results =
        trace({down(4, 0.6f), down(8, 0, 0), down(2), down(0, 0, -2)}, accel.handle);
    const SphereResult &front = results[0], &back = results[1];
    ASSERT_EQ(1u, front.closestHits);
    EXPECT_NEAR(3.2f, front.t, 1e-5f);
    EXPECT_EQ(51u, front.primitive);
    EXPECT_EQ(kSphereKind, front.hitKind);
    EXPECT_EQ(unsigned(OPTIX_PRIMITIVE_TYPE_SPHERE), front.primitiveType);
    EXPECT_EQ(1u, front.isFront);
    EXPECT_EQ(0u, front.isBack + front.isTriangle);
    const float expected[4] = {4, 0, 0, 1};
    for (int i = 0; i < 4; ++i)
        EXPECT_EQ(expected[i], front.data[i]);
    ASSERT_EQ(1u, back.closestHits);
    EXPECT_NEAR(1.0f, back.t, 1e-5f);
    EXPECT_EQ(kSphereKindBack, back.hitKind);
    EXPECT_EQ(1u, back.isBack);
    EXPECT_EQ(0u, back.isFront);
    EXPECT_EQ(52u, back.primitive);
    EXPECT_EQ(1u, results[2].misses);
    EXPECT_EQ(1u, results[3].misses);
    // Without the flag there is no data.
    const Accel closed = buildAccel(context_, log_, {row.input});
    EXPECT_TRUE(std::isnan(trace({down(4)}, closed.handle)[0].data[0]));
}

TEST_F(SphereTest, AnyHitSeesTheFirstAcceptedAndMayIgnore) {
    prepare(true);
    Row row(3);
    const Accel accel = buildAccel(context_, log_, {row.input});
    const SphereRay along = {{-4, 0, 0}, 0, {1, 0, 0}, 1e16f, 0};
    const auto all = trace({along}, accel.handle);
    EXPECT_EQ(0u, all[0].primitive);
    EXPECT_GE(all[0].anyHits, 1u);
    const auto none = trace({along}, accel.handle, 1000);
    EXPECT_EQ(1u, none[0].misses);
    EXPECT_EQ(3u, none[0].anyHits);
    row.flags[0] = OPTIX_GEOMETRY_FLAG_DISABLE_ANYHIT;
    const Accel silent = buildAccel(context_, log_, {row.input});
    EXPECT_EQ(0u, trace({along}, silent.handle)[0].anyHits);
}

TEST_F(SphereTest, SingleRadiusStridesAndSbtIndices) {
    prepare(false);
    Row row(3);
    auto& array = row.input.sphereArray;
    std::vector<float> wide;
    for (const Vec3& p : row.points[0])
        wide.insert(wide.end(), {p.x, p.y, p.z, 99, 99});
    const Buffer vertices(wide), radius(std::vector<float>{0.5f});
    const Buffer sbt(std::vector<uint32_t>{2, 7, 0, 7, 1, 7});
    const CUdeviceptr vertexAddress = vertices.address(), radiusAddress = radius.address();
    array.vertexBuffers = &vertexAddress;
    array.vertexStrideInBytes = 20;
    array.radiusBuffers = &radiusAddress;
    array.singleRadius = 1;
    array.numSbtRecords = 3;
    array.sbtIndexOffsetBuffer = sbt.address();
    array.sbtIndexOffsetSizeInBytes = 4;
    array.sbtIndexOffsetStrideInBytes = 8;
    const Accel accel = buildAccel(context_, log_, {row.input});
    const auto results = trace({down(0), down(4), down(8), down(0, 0.6f)}, accel.handle);
    const unsigned records[] = {2, 0, 1};
    for (size_t i = 0; i < 3; ++i) {
        ASSERT_EQ(1u, results[i].closestHits);
        EXPECT_NEAR(3.5f, results[i].t, 1e-5f);
        EXPECT_EQ(records[i], results[i].sbtGasIndex);
    }
    EXPECT_EQ(1u, results[3].misses);
    // One radius for each, strided.
    Row other(2);
    const Buffer radii(std::vector<float>{0.5f, 99, 2.0f, 99});
    const CUdeviceptr address = radii.address();
    other.input.sphereArray.radiusBuffers = &address;
    other.input.sphereArray.radiusStrideInBytes = 8;
    const Accel strided = buildAccel(context_, log_, {other.input});
    const auto sized = trace({down(0), down(4)}, strided.handle);
    EXPECT_NEAR(3.5f, sized[0].t, 1e-5f);
    EXPECT_NEAR(2.0f, sized[1].t, 1e-5f);
}

TEST_F(SphereTest, MoveAndGrow) {
    prepare(false, true);
    Row row(3, 2);
    OptixAccelBuildOptions options = buildOptions(OPTIX_BUILD_FLAG_ALLOW_RANDOM_VERTEX_ACCESS |
                                                  OPTIX_BUILD_FLAG_ALLOW_UPDATE);
    options.motionOptions = {2, OPTIX_MOTION_FLAG_END_VANISH, 1, 3};
    const Accel accel = buildAccel(context_, log_, {row.input}, options, {});
    for (const float time : {0.0f, 1.0f, 1.5f, 2.0f, 3.0f}) {
        const float f = time < 1 ? 0 : (time - 1) / 2;
        const auto results = trace({down(4, 4 * f)}, accel.handle, 0, time);
        ASSERT_EQ(1u, results[0].closestHits) << time;
        EXPECT_NEAR(4 - (1 + f), results[0].t, 1e-5f) << time;
        EXPECT_NEAR(4 * f, results[0].data[1], 1e-6f);
        EXPECT_NEAR(1 + f, results[0].data[3], 1e-6f);
    }
    EXPECT_EQ(1u, trace({down(4, 4)}, accel.handle, 0, 3.5f)[0].misses);
    // Through an instance too.
    InstanceList list({instanceOf(accel.handle, translation(0, 0, 1))});
    const Accel scene = buildAccel(context_, log_, {list.input});
    EXPECT_NEAR(1.5f, trace({down(4, 2)}, scene.handle, 0, 2)[0].t, 1e-5f);
    // An update moves the second key.
    for (Vec3& p : row.points[1])
        p.y = -4;
    row.upload();
    OptixAccelBufferSizes sizes{};
    ASSERT_OK(optixAccelComputeMemoryUsage(context_, &options, &row.input, 1, &sizes));
    const Buffer temp(sizes.tempUpdateSizeInBytes);
    options.operation = OPTIX_BUILD_OPERATION_UPDATE;
    OptixTraversableHandle handle = 0;
    ASSERT_OK(optixAccelBuild(context_, nullptr, &options, &row.input, 1, temp.address(),
                              temp.size(), accel.memory.address(), accel.memory.size(), &handle,
                              nullptr, 0));
    waitForDevice();
    const auto moved = trace({down(4, -4), down(4, 4)}, handle, 0, 3);
    EXPECT_NEAR(2.0f, moved[0].t, 1e-5f);
    EXPECT_EQ(1u, moved[1].misses);
}

TEST_F(SphereTest, BuildInputErrors) {
    Row row(3);
    OptixAccelBuildOptions options = buildOptions();
    OptixAccelBufferSizes sizes{};
    ASSERT_OK(optixAccelComputeMemoryUsage(context_, &options, &row.input, 1, &sizes));
    const Buffer temp(sizes.tempSizeInBytes), output(sizes.outputSizeInBytes);
    using Array = OptixBuildInputSphereArray;
    const auto rejected = [&](const char* word, auto&& change) {
        OptixBuildInput input = row.input;
        change(input.sphereArray);
        OptixTraversableHandle handle = 0;
        EXPECT_REJECTED(OPTIX_ERROR_INVALID_VALUE, "optixAccelBuild", word,
                        optixAccelBuild(context_, nullptr, &options, &input, 1, temp.address(),
                                        temp.size(), output.address(), output.size(), &handle,
                                        nullptr, 0));
    };
    const CUdeviceptr none = 0, odd = row.vertexAddresses[0] + 2;
    rejected("vertexStrideInBytes", [](Array& s) { s.vertexStrideInBytes = 8; });
    rejected("vertexStrideInBytes", [](Array& s) { s.vertexStrideInBytes = 14; });
    rejected("radiusStrideInBytes", [](Array& s) { s.radiusStrideInBytes = 2; });
    rejected("vertexBuffers", [](Array& s) { s.vertexBuffers = nullptr; });
    rejected("vertexBuffers", [&](Array& s) { s.vertexBuffers = &none; });
    rejected("vertexBuffers", [&](Array& s) { s.vertexBuffers = &odd; });
    rejected("radiusBuffers", [](Array& s) { s.radiusBuffers = nullptr; });
    rejected("radiusBuffers", [&](Array& s) { s.radiusBuffers = &odd; });
    rejected("device memory", [](Array& s) { s.numVertices = 0x4000000; });
    rejected("numSbtRecords", [](Array& s) { s.numSbtRecords = 0; });
    rejected("flags", [](Array& s) { s.flags = nullptr; });
    rejected("primitiveIndexOffset", [](Array& s) { s.primitiveIndexOffset = 0xFFFFFFFEu; });
    rejected("sbtIndexOffsetSizeInBytes", [](Array& s) { s.sbtIndexOffsetSizeInBytes = 3; });
    const std::vector<unsigned> unknown = {0x10000};
    rejected("flags", [&](Array& s) { s.flags = unknown.data(); });
}

TEST_F(SphereTest, BuiltinModuleErrors) {
    OptixModuleCompileOptions module{};
    OptixPipelineCompileOptions pipeline = sphereOptions();
    OptixBuiltinISOptions options{};
    options.builtinISModuleType = OPTIX_PRIMITIVE_TYPE_SPHERE;
    OptixModule out = nullptr;
    options.buildFlags = 0x10000;
    EXPECT_REJECTED(OPTIX_ERROR_INVALID_VALUE, "optixBuiltinISModuleGet", "buildFlags",
                    optixBuiltinISModuleGet(context_, &module, &pipeline, &options, &out));
    options.buildFlags = 0;
    ASSERT_OK(optixBuiltinISModuleGet(context_, &module, &pipeline, &options, &out));
    EXPECT_OK(optixModuleDestroy(out));
}

} // namespace
} // namespace tests::api
