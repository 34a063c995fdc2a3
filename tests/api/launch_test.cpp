// SPDX-License-Identifier: Apache-2.0
// optixLaunch, launch parameters and the shader binding table (OptiX 7.4, sections 3.9, 5.33).
#include "device/launch.h"
#include "device_memory.h"
#include "rig.h"
#include "scene.h"

namespace tests::api {
namespace {

constexpr const char* kFunction = "optixLaunch";

class Launch : public DeviceTest {
protected:
    void SetUp() override {
        DeviceTest::SetUp();
        seen_ = Buffer(kIndices * sizeof(LaunchSeen));
        params_.seen = seen_.as<LaunchSeen>();
        for (unsigned i = 0; i < 4; ++i)
            params_.tail[i] = 70 + i;
    }
    // A rig with the given raygen program and record value 9.
    std::unique_ptr<Rig> rigWith(const char* raygen) {
        auto r = rig("launch", compileOptions(1));
        r->raygenRecord(r->raygen(raygen), 9u);
        return r;
    }
    const LaunchSeen& seen(size_t i) const { return seen_.as<LaunchSeen>()[i]; }

    static constexpr size_t kIndices = 200000;
    Buffer seen_;
    LaunchParams params_{};
};

TEST_P(Launch, EveryIndexOnce) {
    auto r = rigWith("__raygen__shape");
    r->link();
    struct {
        unsigned width, height, depth;
    } const shapes[] = {{1, 1, 1},    {7, 1, 1},    {256, 1, 1},  {257, 1, 1},   {100003, 1, 1},
                        {1, 300, 1},  {1, 1, 77},   {17, 33, 1},  {64, 48, 1},   {1, 20, 30},
                        {13, 1, 11},  {19, 23, 29}, {16, 16, 16}, {333, 500, 1}, {3, 2, 1000}};
    for (const auto& shape : shapes) {
        SCOPED_TRACE(std::to_string(shape.width) + " x " + std::to_string(shape.height) + " x " +
                     std::to_string(shape.depth));
        seen_.fill(0);
        r->run(params_, shape.width, shape.height, shape.depth);
        size_t count = size_t(shape.width) * shape.height * shape.depth;
        size_t wrong = 0;
        for (size_t i = 0; i < count; ++i) {
            const LaunchSeen& s = seen(i);
            bool good = s.runs == 1 && s.index[0] == i % shape.width &&
                        s.index[1] == i / shape.width % shape.height &&
                        s.index[2] == i / shape.width / shape.height && s.size[0] == shape.width &&
                        s.size[1] == shape.height && s.size[2] == shape.depth && s.record == 9 &&
                        s.tail == 73;
            wrong += !good;
        }
        EXPECT_EQ(0u, wrong);
        EXPECT_EQ(0u, seen(count).runs);
    }
}

TEST_P(Launch, Dimensions) {
    auto r = rigWith("__raygen__shape");
    r->link();
    OptixShaderBindingTable sbt = r->table();
    Buffer params(sizeof(params_));
    struct {
        unsigned width, height, depth;
    } const wrong[] = {{0, 1, 1}, {1, 0, 1}, {1, 1, 0}, {0, 0, 0}, {1u << 30, 2, 1},
                       {(1u << 30) + 1, 1, 1}, {1u << 16, 1u << 16, 1u << 16}, {~0u, ~0u, ~0u},
                       {1024, 1024, 1025}, {1, ~0u, 1}, {1, 1, ~0u}};
    for (const auto& w : wrong)
        EXPECT_REJECTED(OPTIX_ERROR_INVALID_VALUE, kFunction, "dimensions",
                        optixLaunch(r->pipeline(), nullptr, params.address(), params.size(), &sbt,
                                    w.width, w.height, w.depth));
}

TEST_P(Launch, ParameterSizes) {
    auto r = rigWith("__raygen__shape");
    r->link();
    OptixShaderBindingTable sbt = r->table();
    Buffer params(sizeof(params_) + 16);
    std::memcpy(params.as<void>(), &params_, sizeof(params_));
    auto launch = [&](CUdeviceptr address, size_t size) {
        return optixLaunch(r->pipeline(), nullptr, address, size, &sbt, 1, 1, 1);
    };
    for (size_t size : {sizeof(params_) + 1, sizeof(params_) + 16, ~size_t(0)})
        EXPECT_REJECTED(OPTIX_ERROR_INVALID_VALUE, kFunction, "pipelineParamsSize",
                        launch(params.address(), size));
    EXPECT_REJECTED(OPTIX_ERROR_INVALID_VALUE, kFunction, "pipelineParams",
                    launch(0, sizeof(params_)));
    // The program reads the given part; the caller may omit parts that it does not use.
    EXPECT_OK(launch(params.address(), sizeof(params_)));
    EXPECT_OK(launch(params.address(), sizeof(params_) - 4));
    waitForDevice();
    EXPECT_EQ(2u, seen(0).runs);
}

TEST_P(Launch, ParametersAreIgnoredWhereNoProgramHasThem) {
    OptixPipelineCompileOptions options = compileOptions();
    options.pipelineLaunchParamsVariableName = nullptr;
    Rig r(context_, log_, ptxModule(".visible .entry __raygen__a() { ret; }\n"), options);
    r.raygenRecord(r.raygen("__raygen__a"));
    r.link();
    OptixShaderBindingTable sbt = r.table();
    EXPECT_OK(optixLaunch(r.pipeline(), nullptr, 0, 1000, &sbt, 1, 1, 1));
    EXPECT_OK(optixLaunch(r.pipeline(), nullptr, 12345, 1000, &sbt, 1, 1, 1));
    EXPECT_OK(optixLaunch(r.pipeline(), nullptr, 0, 0, &sbt, 4, 4, 4));
    waitForDevice();
}

TEST_P(Launch, ParametersAreReadInStreamOrder) {
    auto r = rigWith("__raygen__shape");
    r->link();
    OptixShaderBindingTable sbt = r->table();
    Buffer first(sizeof(params_)), second(sizeof(params_));
    std::memcpy(first.as<void>(), &params_, sizeof(params_));
    params_.seen += 1000;
    params_.tail[3] = 99;
    std::memcpy(second.as<void>(), &params_, sizeof(params_));
    for (int i = 0; i < 20; ++i) {
        ASSERT_OK(optixLaunch(r->pipeline(), nullptr, first.address(), first.size(), &sbt, 100, 1, 1));
        ASSERT_OK(optixLaunch(r->pipeline(), nullptr, second.address(), second.size(), &sbt, 50, 1, 1));
    }
    waitForDevice();
    for (size_t i = 0; i < 100; ++i) {
        EXPECT_EQ(20u, seen(i).runs);
        EXPECT_EQ(73u, seen(i).tail);
    }
    for (size_t i = 0; i < 50; ++i) {
        EXPECT_EQ(20u, seen(1000 + i).runs);
        EXPECT_EQ(99u, seen(1000 + i).tail);
    }
}

TEST_P(Launch, RecordsMayBeCopiedAndSharedByPipelines) {
    auto r = rig("launch", compileOptions(1));
    size_t shape = r->raygen("__raygen__shape");
    size_t other = r->raygen("__raygen__other");
    // Packed before any pipeline exists.
    r->raygenRecord(shape, 9u);
    OptixShaderBindingTable sbt = r->table();
    r->link();
    OptixPipelineCompileOptions options = compileOptions(1);
    OptixPipelineLinkOptions link{1, OPTIX_COMPILE_DEBUG_LEVEL_DEFAULT};
    OptixProgramGroup both[] = {r->group(other), r->group(shape)};
    OptixPipeline second = nullptr;
    ASSERT_OK(optixPipelineCreate(context_, &options, &link, both, 2, nullptr, nullptr, &second));
    Buffer copy(64, 16);
    std::memcpy(copy.as<void>(), reinterpret_cast<void*>(sbt.raygenRecord), 36);
    *(copy.as<unsigned>() + 8) = 10; // other data after the same header
    Buffer params(sizeof(params_));
    std::memcpy(params.as<void>(), &params_, sizeof(params_));
    auto run = [&](OptixPipeline pipeline, CUdeviceptr record) {
        sbt.raygenRecord = record;
        ASSERT_OK(optixLaunch(pipeline, nullptr, params.address(), params.size(), &sbt, 1, 1, 1));
        waitForDevice();
    };
    CUdeviceptr original = sbt.raygenRecord;
    run(r->pipeline(), original);
    EXPECT_EQ(9u, seen(0).record);
    run(r->pipeline(), copy.address());
    EXPECT_EQ(10u, seen(0).record);
    run(second, original);
    EXPECT_EQ(9u, seen(0).record);
    run(second, copy.address());
    EXPECT_EQ(10u, seen(0).record);
    EXPECT_EQ(4u, seen(0).runs);
    // The record decides which raygen program of the pipeline runs.
    ASSERT_OK(optixSbtRecordPackHeader(r->group(other), copy.as<void>()));
    run(second, copy.address());
    EXPECT_EQ(104u, seen(0).runs);
    EXPECT_OK(optixPipelineDestroy(second));
}

TEST_P(Launch, BindingTableArguments) {
    auto r = rigWith("__raygen__shape");
    size_t miss = r->miss("__miss__value");
    r->missRecord(miss, 1u);
    r->missRecord(miss, 2u);
    size_t hit = r->hit("__closesthit__value");
    r->hitRecord(hit, 3u);
    r->hitRecord(hit, 4u);
    size_t callable = r->callables("__direct_callable__value");
    r->callableRecord(callable, 5u);
    r->callableRecord(callable, 6u);
    r->link();
    const OptixShaderBindingTable good = r->table();
    Buffer params(sizeof(params_));
    std::memcpy(params.as<void>(), &params_, sizeof(params_));
    auto launch = [&](const OptixShaderBindingTable* sbt) {
        return optixLaunch(r->pipeline(), nullptr, params.address(), params.size(), sbt, 1, 1, 1);
    };
    EXPECT_REJECTED(OPTIX_ERROR_INVALID_VALUE, kFunction, "sbt", launch(nullptr));
    OptixShaderBindingTable sbt{};
    EXPECT_REJECTED(OPTIX_ERROR_INVALID_VALUE, kFunction, "raygenRecord", launch(&sbt));
    auto expectBad = [&](const char* mention, auto change) {
        OptixShaderBindingTable table = good;
        change(table);
        EXPECT_REJECTED(OPTIX_ERROR_INVALID_VALUE, kFunction, mention, launch(&table));
    };
    using Table = OptixShaderBindingTable;
    expectBad("raygenRecord", [](Table& t) { t.raygenRecord += 8; });
    expectBad("exceptionRecord", [](Table& t) { t.exceptionRecord = t.raygenRecord + 4; });
    expectBad("missRecordBase", [](Table& t) { t.missRecordBase += 8; });
    expectBad("missRecordBase", [](Table& t) { t.missRecordBase = 0; });
    expectBad("missRecordStride", [](Table& t) { t.missRecordStrideInBytes = 0; });
    expectBad("missRecordStride", [](Table& t) { t.missRecordStrideInBytes = 40; });
    expectBad("missRecordStride", [](Table& t) { t.missRecordStrideInBytes = 16; });
    expectBad("hitgroupRecordBase", [](Table& t) { t.hitgroupRecordBase += 4; });
    expectBad("hitgroupRecordBase", [](Table& t) { t.hitgroupRecordBase = 0; });
    expectBad("hitgroupRecordStride", [](Table& t) { t.hitgroupRecordStrideInBytes = 0; });
    expectBad("hitgroupRecordStride", [](Table& t) { t.hitgroupRecordStrideInBytes = 47; });
    expectBad("callablesRecordBase", [](Table& t) { t.callablesRecordBase += 1; });
    expectBad("callablesRecordBase", [](Table& t) { t.callablesRecordBase = 0; });
    expectBad("callablesRecordStride", [](Table& t) { t.callablesRecordStrideInBytes = 0; });
    // One miss or hit record needs no stride.
    sbt = good;
    sbt.missRecordStrideInBytes = 0;
    sbt.missRecordCount = 1;
    EXPECT_OK(launch(&sbt));
    // Only a raygen record.
    sbt = {};
    sbt.raygenRecord = good.raygenRecord;
    EXPECT_OK(launch(&sbt));
    waitForDevice();
    EXPECT_EQ(2u, seen(0).runs);
}

// Faults found in stream order: the launch does not run, and an error is logged.
TEST_P(Launch, RecordsThatAreNoRaygenRecords) {
    auto r = rigWith("__raygen__shape");
    size_t miss = r->miss("__miss__value");
    r->link();
    auto stranger = rigWith("__raygen__shape"); // has its own pipeline
    stranger->link();
    OptixShaderBindingTable foreign = stranger->table();
    Buffer params(sizeof(params_));
    std::memcpy(params.as<void>(), &params_, sizeof(params_));
    Buffer zeros(64, 16), noise(64, 16), wrongKind(64, 16);
    noise.fill(0xA5);
    ASSERT_OK(optixSbtRecordPackHeader(r->group(miss), wrongKind.as<void>()));
    for (CUdeviceptr record :
         {zeros.address(), noise.address(), wrongKind.address(), foreign.raygenRecord}) {
        log_.clear();
        OptixShaderBindingTable sbt{};
        sbt.raygenRecord = record;
        OptixResult result =
            optixLaunch(r->pipeline(), nullptr, params.address(), params.size(), &sbt, 4, 1, 1);
        if (result == OPTIX_SUCCESS) {
            waitForDevice(); // must not fail for errors of the stream
        } else {
            EXPECT_EQ(OPTIX_ERROR_LAUNCH_FAILURE, result);
        }
        EXPECT_TRUE(log_.hasError("record", "")) << log_.all();
        EXPECT_EQ(0u, seen(0).runs);
    }
}

// Not promised by the manual; other launch indices of the thread must not spin on a lock whose
// owner waits at its trace.
TEST_P(Launch, LocksAcrossTracesEnd) {
    if (onGpu())
        GTEST_SKIP() << "lanes of a warp that spin keep the owner of the lock from going on";
    auto r = rig("locks", compileOptions(1));
    r->raygenRecord(r->raygen("__raygen__locked"));
    r->missRecord(r->miss("__miss__answer"));
    r->link();
    constexpr unsigned kWaiting = 20000;
    r->run(params_, kWaiting);
    EXPECT_EQ(3 * kWaiting, seen(0).record);
}

class LaunchRecords : public Launch {
protected:
    // A ray along z hits the square at z = 0.
    void SetUp() override {
        Launch::SetUp();
        mesh_ = std::make_unique<TriangleMesh>(
            std::vector<Vec3>{{-1, -1, 0}, {3, -1, 0}, {-1, 3, 0}}, std::vector<uint32_t>{0, 1, 2});
        accel_ = buildAccel(context_, log_, {mesh_->input});
        // Most tests use records that are missing or wrong.
        log_.expect("(in validation mode the log names the launch index)");
    }
    unsigned answer(Rig& r) {
        seen_.fill(0);
        r.run(params_, 3);
        for (size_t i = 0; i < 3; ++i) {
            EXPECT_EQ(1u, seen(i).runs);
            EXPECT_EQ(seen(0).record, seen(i).record);
        }
        return seen(0).record;
    }
    std::unique_ptr<TriangleMesh> mesh_;
    Accel accel_;
};

TEST_P(LaunchRecords, MissIndexPicksTheRecord) {
    auto r = rigWith("__raygen__trace");
    size_t miss = r->miss("__miss__value");
    size_t nothing = r->miss(nullptr);
    for (unsigned value : {10u, 11u, 12u})
        r->missRecord(miss, value);
    r->missRecord(nothing);
    r->link();
    for (unsigned i = 0; i < 3; ++i) {
        params_.missIndex = i;
        EXPECT_EQ(10 + i, answer(*r));
    }
    params_.missIndex = 3; // a group without program: the payload stays
    EXPECT_EQ(5u, answer(*r));
    for (unsigned beyond : {4u, 1000u, 0x7FFFFFFFu, ~0u}) {
        params_.missIndex = beyond;
        EXPECT_EQ(5u, answer(*r)) << "no program runs beyond the last record";
    }
}

TEST_P(LaunchRecords, WithoutMissRecords) {
    auto r = rigWith("__raygen__trace");
    r->link();
    EXPECT_EQ(5u, answer(*r));
}

TEST_P(LaunchRecords, HitIndexPicksTheRecord) {
    params_.handle = accel_.handle;
    auto r = rigWith("__raygen__trace");
    size_t hit = r->hit("__closesthit__value");
    size_t nothing = r->hit(nullptr);
    for (unsigned value : {20u, 21u})
        r->hitRecord(hit, value);
    r->hitRecord(nothing);
    r->link();
    params_.hitIndex = 0;
    EXPECT_EQ(20u, answer(*r));
    params_.hitIndex = 1;
    EXPECT_EQ(21u, answer(*r));
    params_.hitIndex = 2;
    EXPECT_EQ(5u, answer(*r));
    for (unsigned beyond : {3u, 200u, 255u}) {
        params_.hitIndex = beyond;
        EXPECT_EQ(5u, answer(*r)) << beyond;
    }
}

TEST_P(LaunchRecords, WithoutHitRecords) {
    params_.handle = accel_.handle;
    auto r = rigWith("__raygen__trace");
    r->missRecord(r->miss("__miss__value"), 33u);
    r->link();
    EXPECT_EQ(5u, answer(*r)) << "the triangle is hit, but has no program";
}

TEST_P(LaunchRecords, RecordsOfOtherKindsAndRubbish) {
    params_.handle = accel_.handle;
    auto r = rigWith("__raygen__trace");
    size_t hit = r->hit("__closesthit__value");
    size_t miss = r->miss("__miss__value");
    r->hitRecord(miss, 50u); // a miss group among the hit records
    r->hitRecord(hit, 51u);
    r->missRecord(hit, 52u);
    r->link();
    EXPECT_EQ(5u, answer(*r));
    params_.hitIndex = 1;
    EXPECT_EQ(51u, answer(*r));
    params_.handle = 0;
    EXPECT_EQ(5u, answer(*r));
}

TEST_P(LaunchRecords, CallableIndices) {
    auto r = rigWith("__raygen__call");
    size_t callable = r->callables("__direct_callable__value");
    for (unsigned value : {60u, 61u})
        r->callableRecord(callable, value);
    r->link();
    for (unsigned i = 0; i < 2; ++i) {
        params_.missIndex = i;
        EXPECT_EQ(60 + i, answer(*r));
    }
    // A call beyond the last record returns an undefined value; the launch continues.
    for (unsigned beyond : {2u, 0x10000000u, ~0u}) {
        params_.missIndex = beyond;
        answer(*r);
    }
}

TEST_P(LaunchRecords, NullHandleMisses) {
    params_.handle = 0;
    auto r = rigWith("__raygen__trace");
    r->missRecord(r->miss("__miss__value"), 44u);
    r->hitRecord(r->hit("__closesthit__value"), 45u);
    r->link();
    EXPECT_EQ(44u, answer(*r));
}

INSTANTIATE_DEVICE_TEST(Launch);
INSTANTIATE_DEVICE_TEST(LaunchRecords);

} // namespace
} // namespace tests::api
