// SPDX-License-Identifier: Apache-2.0
// Handles that are not what they should be: null, garbage, of another kind, destroyed. Every
// function that takes a handle must recognise them without touching what they point to. And the
// functions this version does not have: each says so by name.
#include "fixture.h"

#include <functional>

namespace tests::api {
namespace {

class Handles : public ApiTest {
protected:
    void SetUp() override {
        ApiTest::SetUp();
        std::string text = ptxModule(".visible .entry __raygen__a() { ret; }\n");
        ASSERT_OK(optixModuleCreateFromPTX(context_, &moduleOptions_, &options_, text.data(),
                                           text.size(), nullptr, nullptr, &module_));
        desc_.kind = OPTIX_PROGRAM_GROUP_KIND_RAYGEN;
        desc_.raygen = {module_, "__raygen__a"};
        ASSERT_OK(optixProgramGroupCreate(context_, &desc_, 1, &groupOptions_, nullptr, nullptr,
                                          &group_));
        ASSERT_OK(optixPipelineCreate(context_, &options_, &link_, &group_, 1, nullptr, nullptr,
                                      &pipeline_));
        input_.type = OPTIX_BUILD_INPUT_TYPE_INSTANCES;
    }

    // Null, garbage, and live handles of every other kind.
    std::vector<void*> notA(void* right) {
        std::vector<void*> all = garbageHandles();
        all.push_back(nullptr);
        for (void* handle : {static_cast<void*>(context_), static_cast<void*>(module_),
                             static_cast<void*>(group_), static_cast<void*>(pipeline_)})
            if (handle != right)
                all.push_back(handle);
        return all;
    }

    OptixModuleCompileOptions moduleOptions_{};
    OptixPipelineCompileOptions options_ = compileOptions();
    OptixPipelineLinkOptions link_{1, OPTIX_COMPILE_DEBUG_LEVEL_DEFAULT};
    OptixProgramGroupOptions groupOptions_{};
    OptixProgramGroupDesc desc_{};
    OptixModule module_ = nullptr;
    OptixProgramGroup group_ = nullptr;
    OptixPipeline pipeline_ = nullptr;
    OptixBuildInput input_{};
    OptixAccelBuildOptions build_{OPTIX_BUILD_FLAG_NONE, OPTIX_BUILD_OPERATION_BUILD, {}};
};

TEST_F(Handles, NotAContext) {
    for (void* handle : notA(context_)) {
        SCOPED_TRACE(handle);
        auto bad = static_cast<OptixDeviceContext>(handle);
        auto refused = OPTIX_ERROR_INVALID_DEVICE_CONTEXT;
        unsigned value = 7;
        EXPECT_EQ(refused, optixDeviceContextGetProperty(
                               bad, OPTIX_DEVICE_PROPERTY_LIMIT_MAX_TRACE_DEPTH, &value, 4));
        EXPECT_EQ(7u, value);
        EXPECT_EQ(refused, optixDeviceContextSetLogCallback(bad, LogRecord::callback, &log_, 4));
        EXPECT_EQ(refused, optixDeviceContextDestroy(bad));
        std::string text = ptxModule("");
        OptixModule module = nullptr;
        EXPECT_EQ(refused, optixModuleCreateFromPTX(bad, &moduleOptions_, &options_, text.data(),
                                                    text.size(), nullptr, nullptr, &module));
        EXPECT_EQ(nullptr, module);
        OptixProgramGroup group = nullptr;
        EXPECT_EQ(refused, optixProgramGroupCreate(bad, &desc_, 1, &groupOptions_, nullptr, nullptr,
                                                   &group));
        OptixPipeline pipeline = nullptr;
        EXPECT_EQ(refused, optixPipelineCreate(bad, &options_, &link_, &group_, 1, nullptr, nullptr,
                                               &pipeline));
        OptixAccelBufferSizes sizes{};
        EXPECT_EQ(refused, optixAccelComputeMemoryUsage(bad, &build_, &input_, 1, &sizes));
        OptixTraversableHandle traversable = 0;
        Buffer memory(4096);
        EXPECT_EQ(refused, optixAccelBuild(bad, nullptr, &build_, &input_, 1, memory.address(), 2048,
                                           memory.address() + 2048, 2048, &traversable, nullptr, 0));
        EXPECT_EQ(refused, optixAccelCompact(bad, nullptr, 1, memory.address(), 4096, &traversable));
        EXPECT_EQ(0u, traversable);
    }
}

TEST_F(Handles, NotAModule) {
    for (void* handle : notA(module_)) {
        SCOPED_TRACE(handle);
        EXPECT_EQ(OPTIX_ERROR_INVALID_VALUE, optixModuleDestroy(static_cast<OptixModule>(handle)));
        OptixProgramGroupDesc desc = desc_;
        desc.raygen.module = static_cast<OptixModule>(handle);
        auto group = reinterpret_cast<OptixProgramGroup>(1);
        EXPECT_REJECTED(OPTIX_ERROR_INVALID_VALUE, "optixProgramGroupCreate", "raygen",
                        optixProgramGroupCreate(context_, &desc, 1, &groupOptions_, nullptr,
                                                nullptr, &group));
        EXPECT_EQ(nullptr, group);
    }
}

TEST_F(Handles, NotAProgramGroup) {
    for (void* handle : notA(group_)) {
        SCOPED_TRACE(handle);
        auto bad = static_cast<OptixProgramGroup>(handle);
        EXPECT_EQ(OPTIX_ERROR_INVALID_VALUE, optixProgramGroupDestroy(bad));
        OptixStackSizes sizes{};
        EXPECT_EQ(OPTIX_ERROR_INVALID_VALUE, optixProgramGroupGetStackSize(bad, &sizes));
        char header[OPTIX_SBT_RECORD_HEADER_SIZE] = {};
        EXPECT_EQ(OPTIX_ERROR_INVALID_VALUE, optixSbtRecordPackHeader(bad, header));
        OptixProgramGroup both[] = {group_, bad};
        auto pipeline = reinterpret_cast<OptixPipeline>(1);
        EXPECT_REJECTED(OPTIX_ERROR_INVALID_VALUE, "optixPipelineCreate", "programGroups[1]",
                        optixPipelineCreate(context_, &options_, &link_, both, 2, nullptr, nullptr,
                                            &pipeline));
        EXPECT_EQ(nullptr, pipeline);
    }
}

TEST_F(Handles, NotAPipeline) {
    Buffer record(OPTIX_SBT_RECORD_HEADER_SIZE, 16);
    ASSERT_OK(optixSbtRecordPackHeader(group_, record.as<void>()));
    OptixShaderBindingTable sbt{};
    sbt.raygenRecord = record.address();
    for (void* handle : notA(pipeline_)) {
        SCOPED_TRACE(handle);
        auto bad = static_cast<OptixPipeline>(handle);
        EXPECT_EQ(OPTIX_ERROR_INVALID_VALUE, optixPipelineDestroy(bad));
        EXPECT_EQ(OPTIX_ERROR_INVALID_VALUE, optixPipelineSetStackSize(bad, 0, 0, 1024, 1));
        EXPECT_EQ(OPTIX_ERROR_INVALID_VALUE, optixLaunch(bad, nullptr, 0, 0, &sbt, 1, 1, 1));
    }
}

TEST_F(Handles, DestroyedObjectsAreDead) {
    ASSERT_OK(optixPipelineDestroy(pipeline_));
    EXPECT_EQ(OPTIX_ERROR_INVALID_VALUE, optixPipelineDestroy(pipeline_));
    EXPECT_EQ(OPTIX_ERROR_INVALID_VALUE, optixPipelineSetStackSize(pipeline_, 0, 0, 1024, 1));
    ASSERT_OK(optixProgramGroupDestroy(group_));
    EXPECT_EQ(OPTIX_ERROR_INVALID_VALUE, optixProgramGroupDestroy(group_));
    OptixStackSizes sizes{};
    EXPECT_EQ(OPTIX_ERROR_INVALID_VALUE, optixProgramGroupGetStackSize(group_, &sizes));
    ASSERT_OK(optixModuleDestroy(module_));
    EXPECT_EQ(OPTIX_ERROR_INVALID_VALUE, optixModuleDestroy(module_));
}

TEST_F(Handles, ObjectsOfAnotherContext) {
    LogRecord record;
    OptixDeviceContext other = nullptr;
    ASSERT_OK(optixDeviceContextCreate(nullptr, nullptr, &other));
    ASSERT_OK(optixDeviceContextSetLogCallback(other, LogRecord::callback, &record, 4));
    OptixProgramGroup group = nullptr;
    EXPECT_EQ(OPTIX_ERROR_INVALID_VALUE,
              optixProgramGroupCreate(other, &desc_, 1, &groupOptions_, nullptr, nullptr, &group));
    EXPECT_TRUE(record.hasError("raygen", "another device context")) << record.all();
    OptixPipeline pipeline = nullptr;
    record.clear();
    EXPECT_EQ(OPTIX_ERROR_INVALID_VALUE,
              optixPipelineCreate(other, &options_, &link_, &group_, 1, nullptr, nullptr, &pipeline));
    EXPECT_TRUE(record.hasError("programGroups[0]", "another device context")) << record.all();
    ASSERT_OK(optixDeviceContextDestroy(other));
}

} // namespace
} // namespace tests::api
