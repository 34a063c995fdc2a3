// SPDX-License-Identifier: Apache-2.0
// User exceptions from every program kind end only their launch index and reach the exception
// program with code, details and its own record; continuation callables trace.
#include "device/exceptions.h"
#include "rig.h"
#include "scene.h"

namespace tests::api {
namespace {

class Exceptions : public DeviceTest {};

TEST_P(Exceptions, ThrownFromEveryProgramKind) {
    TriangleMesh mesh({{-50, -50, 1}, {50, -50, 1}, {0, 80, 1}}, {0, 1, 2});
    Accel accel = buildAccel(context_, log_, {mesh.input});
    OptixPipelineCompileOptions options = compileOptions(2);
    options.exceptionFlags = OPTIX_EXCEPTION_FLAG_USER;
    auto r = rig("exceptions", options);
    r->raygenRecord(r->raygen("__raygen__exceptions"));
    r->missRecord(r->miss("__miss__exceptions"));
    r->hitRecord(r->hit("__closesthit__exceptions", "__anyhit__exceptions"));
    r->callableRecord(r->callables(nullptr, "__continuation_callable__trace"));
    OptixProgramGroupDesc desc{};
    desc.kind = OPTIX_PROGRAM_GROUP_KIND_EXCEPTION;
    desc.exception.module = r->module();
    desc.exception.entryFunctionName = "__exception__store";
    const size_t exception = r->add(desc);
    r->link();

    Buffer record(OPTIX_SBT_RECORD_HEADER_SIZE + 16);
    ASSERT_OK(optixSbtRecordPackHeader(r->group(exception), record.as<void>()));
    record.as<unsigned>()[OPTIX_SBT_RECORD_HEADER_SIZE / 4] = 4711;
    constexpr unsigned kIndices = 6 * 200;
    Buffer results(kIndices * sizeof(ExceptionResult)), params(sizeof(ExceptionParams));
    auto* result = results.as<ExceptionResult>();
    for (unsigned i = 0; i < kIndices; ++i)
        result[i] = {0, 0, -77, {0, 0, 0}, 0};
    *params.as<ExceptionParams>() = {result, accel.handle};
    OptixShaderBindingTable sbt = r->table();
    sbt.exceptionRecord = record.address();
    testing::internal::CaptureStdout(); // index 1 prints its exception
    EXPECT_OK(optixLaunch(r->pipeline(), nullptr, params.address(), sizeof(ExceptionParams), &sbt,
                          kIndices, 1, 1));
    waitForDevice();
    std::fflush(stdout);
    const std::string printed = testing::internal::GetCapturedStdout();
    EXPECT_NE(std::string::npos, printed.find("OptiX exception 100 (user exception)")) << printed;
    for (unsigned i = 0; i < kIndices; ++i) {
        SCOPED_TRACE(i);
        const ExceptionResult& e = result[i];
        const unsigned kind = i % kKinds;
        if (kind == kNone) {
            ASSERT_EQ(2u, e.reached);
            ASSERT_EQ(1077u, e.value);
            ASSERT_EQ(-77, e.code);
            continue;
        }
        ASSERT_EQ(1u, e.reached) << "an exception ends the launch index";
        ASSERT_EQ(4711u, e.record);
        const int codes[] = {0, 100, 200, 0, (1 << 30) - 1, 200};
        ASSERT_EQ(codes[kind], e.code);
        if (kind != kFromAnyHit)
            ASSERT_EQ(i, e.details[0]);
        if (kind == kFromRaygen) {
            ASSERT_EQ(2u, e.details[1]);
            ASSERT_EQ(8u, e.details[2]);
            ASSERT_EQ(76543u, e.value);
        }
        if (kind == kFromMiss)
            ASSERT_EQ(9u, e.details[1]);
    }
}

// Without an exception record the index just ends.
TEST_P(Exceptions, NoExceptionProgram) {
    TriangleMesh mesh({{-50, -50, 1}, {50, -50, 1}, {0, 80, 1}}, {0, 1, 2});
    Accel accel = buildAccel(context_, log_, {mesh.input});
    OptixPipelineCompileOptions options = compileOptions(2);
    options.exceptionFlags = OPTIX_EXCEPTION_FLAG_USER;
    auto r = rig("exceptions", options);
    r->raygenRecord(r->raygen("__raygen__exceptions"));
    r->missRecord(r->miss("__miss__exceptions"));
    r->hitRecord(r->hit("__closesthit__exceptions", "__anyhit__exceptions"));
    r->callableRecord(r->callables(nullptr, "__continuation_callable__trace"));
    r->link();
    Buffer results(60 * sizeof(ExceptionResult));
    results.fill(0);
    r->run(ExceptionParams{results.as<ExceptionResult>(), accel.handle}, 60);
    for (unsigned i = 0; i < 60; ++i)
        ASSERT_EQ(i % kKinds == kNone ? 2u : 1u, results.as<ExceptionResult>()[i].reached) << i;
}

// Destroying a context logs the reports of its last launches.
TEST_P(Exceptions, LastReportsAreTold) {
    auto r = rig("exceptions", compileOptions(2));
    r->raygenRecord(r->raygen("__raygen__exceptions"));
    r->missRecord(r->miss("__miss__exceptions"));
    r->hitRecord(r->hit("__closesthit__exceptions", "__anyhit__exceptions"));
    r->callableRecord(r->callables(nullptr, "__continuation_callable__trace"));
    r->link();
    Buffer results(sizeof(ExceptionResult)), params(sizeof(ExceptionParams));
    *params.as<ExceptionParams>() = {results.as<ExceptionResult>(), 0};
    OptixShaderBindingTable sbt = r->table();
    log_.clear();
    ASSERT_OK(optixLaunch(r->pipeline(), nullptr, params.address(), params.size(), &sbt, 1, 1, 1));
    ASSERT_OK(optixDeviceContextDestroy(context_));
    context_ = nullptr; // its objects are destroyed with it
    const std::string all = log_.all();
    const size_t found = all.find("no exception program saw: user exception 1073741823");
    ASSERT_NE(std::string::npos, found) << all;
    EXPECT_NE(std::string::npos, all.find(", at launch index (0, 0, 0)", found)) << all;
}

// The manual requires the flag USER if programs throw. Without the flag exceptions work, and the
// log has a warning.
TEST_P(Exceptions, WithoutTheUserFlag) {
    log_.clear();
    auto r = rig("exceptions", compileOptions(2));
    EXPECT_NE(std::string::npos, log_.all().find("calls optixThrowException, but the exception "
                                                 "flags lack USER"))
        << log_.all();
    log_.clear();
    OptixPipelineCompileOptions options = compileOptions(2);
    options.exceptionFlags = OPTIX_EXCEPTION_FLAG_USER;
    auto with = rig("exceptions", options);
    EXPECT_EQ(std::string::npos, log_.all().find("lack USER")) << log_.all();
}

INSTANTIATE_DEVICE_TEST(Exceptions);

} // namespace
} // namespace tests::api
