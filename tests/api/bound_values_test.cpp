// SPDX-License-Identifier: Apache-2.0
// Bound values: loads become constants, loads at unknown offsets read memory, the feedback counts,
// validation mode compares, modules must agree.
#include "device/bound_values.h"
#include "rig.h"

#include <cstddef>

namespace tests::api {
namespace {

class BoundValues : public DeviceTest {
protected:
    OptixResult create(const std::vector<OptixModuleCompileBoundValueEntry>& values,
                       OptixModule& module) {
        OptixModuleCompileOptions options{};
        options.boundValues = values.data();
        options.numBoundValues = unsigned(values.size());
        const OptixPipelineCompileOptions pipeline = compileOptions();
        const std::string ptx = program("bound_values");
        return optixModuleCreateFromPTX(context_, &options, &pipeline, ptx.data(), ptx.size(),
                                        nullptr, nullptr, &module);
    }
    OptixProgramGroup raygen(OptixModule module) {
        OptixProgramGroupDesc desc{};
        desc.kind = OPTIX_PROGRAM_GROUP_KIND_RAYGEN;
        desc.raygen = {module, "__raygen__bound"};
        OptixProgramGroupOptions options{};
        OptixProgramGroup group = nullptr;
        EXPECT_OK(
            optixProgramGroupCreate(context_, &desc, 1, &options, nullptr, nullptr, &group));
        return group;
    }
    OptixResult link(const std::vector<OptixProgramGroup>& groups, OptixPipeline& pipeline) {
        const OptixPipelineCompileOptions options = compileOptions();
        OptixPipelineLinkOptions linkOptions{};
        size_t size = sizeof(feedback_);
        return optixPipelineCreate(context_, &options, &linkOptions, groups.data(),
                                   unsigned(groups.size()), feedback_, &size, &pipeline);
    }
    OptixResult launch(OptixPipeline pipeline, OptixProgramGroup group, const BoundParams& params) {
        record_ = Buffer(OPTIX_SBT_RECORD_HEADER_SIZE);
        EXPECT_OK(optixSbtRecordPackHeader(group, record_.as<void>()));
        params_ = Buffer(sizeof(params));
        *params_.as<BoundParams>() = params;
        OptixShaderBindingTable sbt{};
        sbt.raygenRecord = record_.address();
        const OptixResult result =
            optixLaunch(pipeline, nullptr, params_.address(), sizeof(params), &sbt, 4, 1, 1);
        waitForDevice();
        return result;
    }

    char feedback_[2048] = {};
    Buffer record_, params_;
    const unsigned mode_ = 3, table_[4] = {10, 11, 12, 13};
    const float scale_ = 2.5f;
    const std::vector<OptixModuleCompileBoundValueEntry> values_ = {
        {offsetof(BoundParams, mode), sizeof(mode_), &mode_, "the mode"},
        {offsetof(BoundParams, scale), sizeof(scale_), &scale_, "the scale"},
        {offsetof(BoundParams, table), sizeof(table_), table_, nullptr},
    };
};

TEST_P(BoundValues, LoadsBecomeConstants) {
    OptixModule module = nullptr;
    ASSERT_OK(create(values_, module));
    OptixProgramGroup group = raygen(module);
    OptixPipeline pipeline = nullptr;
    ASSERT_OK(link({group}, pipeline));
    const std::string feedback = feedback_;
    EXPECT_NE(std::string::npos, feedback.find("bound value \"the mode\", bytes 8 to 11: 1 load"))
        << feedback;
    EXPECT_NE(std::string::npos, feedback.find("\"the scale\", bytes 12 to 15: 1 load"))
        << feedback;

    Buffer results(16 * sizeof(unsigned));
    const auto* r = results.as<unsigned>();
    BoundParams params{results.as<unsigned>(), mode_, scale_, {10, 11, 12, 13}, 5};
    ASSERT_OK(launch(pipeline, group, params));
    for (unsigned i = 0; i < 4; ++i) {
        EXPECT_EQ(305u, r[4 * i]);
        EXPECT_EQ(20u, r[4 * i + 1]);
        EXPECT_EQ(10 + i, r[4 * i + 2]);
        EXPECT_EQ(11u, r[4 * i + 3]);
    }
    // A launch with other values shows which loads are constants.
    params.mode = 7;
    params.scale = 100;
    ASSERT_OK(launch(pipeline, group, params));
    EXPECT_EQ(305u, r[0]);
    EXPECT_EQ(20u, r[1]);
    // Loads at computed offsets read memory.
    params.table[2] = 77;
    ASSERT_OK(launch(pipeline, group, params));
    EXPECT_EQ(77u, r[4 * 2 + 2]);
    optixPipelineDestroy(pipeline);
    optixProgramGroupDestroy(group);
    optixModuleDestroy(module);
}

TEST_P(BoundValues, ModulesMustAgree) {
    const unsigned four = 4;
    OptixModule first = nullptr, same = nullptr, other = nullptr, none = nullptr;
    ASSERT_OK(create(values_, first));
    ASSERT_OK(create({values_[0]}, same));
    ASSERT_OK(create({{offsetof(BoundParams, mode), sizeof(four), &four, "four"}}, other));
    ASSERT_OK(create({}, none));
    OptixProgramGroup groups[] = {raygen(first), raygen(same), raygen(other), raygen(none)};
    OptixPipeline pipeline = nullptr;
    ASSERT_OK(link({groups[0], groups[1], groups[3]}, pipeline));
    optixPipelineDestroy(pipeline);
    EXPECT_REJECTED(OPTIX_ERROR_INVALID_VALUE, "optixPipelineCreate", "\"the mode\"",
                    link({groups[0], groups[2]}, pipeline));
    EXPECT_EQ(nullptr, pipeline);
    for (OptixProgramGroup group : groups)
        optixProgramGroupDestroy(group);
    for (OptixModule module : {first, same, other, none})
        optixModuleDestroy(module);
}

TEST_P(BoundValues, ValidationModeCompares) {
    OptixDeviceContextOptions options{};
    options.logCallbackFunction = LogRecord::callback;
    options.logCallbackData = &log_;
    options.logCallbackLevel = 4;
    options.validationMode = OPTIX_DEVICE_CONTEXT_VALIDATION_MODE_ALL;
    OptixDeviceContext plain = context_;
    ASSERT_OK(optixDeviceContextCreate(nullptr, &options, &context_));
    OptixModule module = nullptr;
    ASSERT_OK(create(values_, module));
    OptixProgramGroup group = raygen(module);
    OptixPipeline pipeline = nullptr;
    ASSERT_OK(link({group}, pipeline));
    Buffer results(16 * sizeof(unsigned));
    BoundParams params{results.as<unsigned>(), mode_, scale_, {10, 11, 12, 13}, 5};
    EXPECT_OK(launch(pipeline, group, params));
    params.scale = 100;
    EXPECT_REJECTED(OPTIX_ERROR_VALIDATION_FAILURE, "optixLaunch", "the scale",
                    launch(pipeline, group, params));
    optixPipelineDestroy(pipeline);
    optixProgramGroupDestroy(group);
    optixModuleDestroy(module);
    ASSERT_OK(optixDeviceContextDestroy(context_));
    context_ = plain;
}

INSTANTIATE_DEVICE_TEST(BoundValues);

} // namespace
} // namespace tests::api
