// SPDX-License-Identifier: Apache-2.0
// Invalid handles: null, garbage, of another kind, destroyed. Every function recognises invalid
// handles without reading the memory at their addresses. Missing functions log their names.
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
        OptixAccelRelocationInfo info{};
        int fits = 7;
        EXPECT_EQ(refused, optixAccelGetRelocationInfo(bad, 1, &info));
        EXPECT_EQ(refused, optixAccelCheckRelocationCompatibility(bad, &info, &fits));
        EXPECT_EQ(7, fits);
        EXPECT_EQ(refused, optixAccelRelocate(bad, nullptr, &info, 0, 0, memory.address(), 4096,
                                              &traversable));
        EXPECT_EQ(refused, optixConvertPointerToTraversableHandle(
                               bad, memory.address(), OPTIX_TRAVERSABLE_TYPE_STATIC_TRANSFORM,
                               &traversable));
        EXPECT_EQ(0u, traversable);
        OptixTask task = nullptr;
        EXPECT_EQ(refused,
                  optixModuleCreateFromPTXWithTasks(bad, &moduleOptions_, &options_, text.data(),
                                                    text.size(), nullptr, nullptr, &module, &task));
        EXPECT_EQ(nullptr, module);
        EXPECT_EQ(nullptr, task);
        const OptixBuiltinISOptions builtin{OPTIX_PRIMITIVE_TYPE_TRIANGLE};
        EXPECT_EQ(refused,
                  optixBuiltinISModuleGet(bad, &moduleOptions_, &options_, &builtin, &module));
        OptixDenoiser denoiser = nullptr;
        const OptixDenoiserOptions guides{};
        EXPECT_EQ(refused,
                  optixDenoiserCreate(bad, OPTIX_DENOISER_MODEL_KIND_LDR, &guides, &denoiser));
        EXPECT_EQ(refused, optixDenoiserCreateWithUserModel(bad, text.data(), 16, &denoiser));
        EXPECT_EQ(nullptr, denoiser);
        int enabled = 7;
        size_t low = 7, high = 7;
        char path[8] = "old";
        EXPECT_EQ(refused, optixDeviceContextSetCacheEnabled(bad, 1));
        EXPECT_EQ(refused, optixDeviceContextSetCacheLocation(bad, "/tmp"));
        EXPECT_EQ(refused, optixDeviceContextSetCacheDatabaseSizes(bad, 1, 2));
        EXPECT_EQ(refused, optixDeviceContextGetCacheEnabled(bad, &enabled));
        EXPECT_EQ(refused, optixDeviceContextGetCacheLocation(bad, path, sizeof(path)));
        EXPECT_EQ(refused, optixDeviceContextGetCacheDatabaseSizes(bad, &low, &high));
        EXPECT_EQ(7, enabled);
        EXPECT_EQ(7u, low + high - 7);
        EXPECT_STREQ("old", path);
    }
}

TEST_F(Handles, NotAModule) {
    for (void* handle : notA(module_)) {
        SCOPED_TRACE(handle);
        EXPECT_EQ(OPTIX_ERROR_INVALID_VALUE, optixModuleDestroy(static_cast<OptixModule>(handle)));
        OptixModuleCompileState state{};
        EXPECT_EQ(OPTIX_ERROR_INVALID_VALUE,
                  optixModuleGetCompilationState(static_cast<OptixModule>(handle), &state));
        OptixProgramGroupDesc desc = desc_;
        desc.raygen.module = static_cast<OptixModule>(handle);
        auto group = reinterpret_cast<OptixProgramGroup>(1);
        EXPECT_REJECTED(OPTIX_ERROR_INVALID_VALUE, "optixProgramGroupCreate", "raygen",
                        optixProgramGroupCreate(context_, &desc, 1, &groupOptions_, nullptr,
                                                nullptr, &group));
        EXPECT_EQ(nullptr, group);
    }
}

// "Modules must not be destroyed while they are still used by any program group": Sunstone allows
// it, and validation mode notes it.
TEST_F(Handles, ModulesMayGoBeforeTheirGroups) {
    for (const bool validation : {false, true}) {
        OptixDeviceContextOptions contextOptions{};
        contextOptions.logCallbackFunction = LogRecord::callback;
        contextOptions.logCallbackData = &log_;
        contextOptions.logCallbackLevel = 4;
        if (validation)
            contextOptions.validationMode = OPTIX_DEVICE_CONTEXT_VALIDATION_MODE_ALL;
        OptixDeviceContext context = nullptr;
        ASSERT_OK(optixDeviceContextCreate(nullptr, &contextOptions, &context));
        const std::string text = ptxModule(".visible .entry __raygen__a() { ret; }\n");
        OptixModule module = nullptr, unused = nullptr;
        for (OptixModule* each : {&module, &unused})
            ASSERT_OK(optixModuleCreateFromPTX(context, &moduleOptions_, &options_, text.data(),
                                               text.size(), nullptr, nullptr, each));
        OptixProgramGroupDesc desc = desc_;
        desc.raygen.module = module;
        OptixProgramGroup group = nullptr;
        ASSERT_OK(
            optixProgramGroupCreate(context, &desc, 1, &groupOptions_, nullptr, nullptr, &group));
        log_.clear();
        ASSERT_OK(optixModuleDestroy(unused));
        EXPECT_EQ(std::string::npos, log_.all().find("groups")) << log_.all();
        ASSERT_OK(optixModuleDestroy(module));
        EXPECT_EQ(validation,
                  log_.all().find("program groups of the module are alive") != std::string::npos)
            << log_.all();
        OptixPipeline pipeline = nullptr;
        ASSERT_OK(optixPipelineCreate(context, &options_, &link_, &group, 1, nullptr, nullptr,
                                      &pipeline));
        ASSERT_OK(optixDeviceContextDestroy(context));
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
