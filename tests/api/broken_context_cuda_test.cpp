// SPDX-License-Identifier: Apache-2.0
// After a kernel of the application has broken the CUDA context, each call that needs the context
// returns an error, no call ends the process or hangs, and all objects can be destroyed.
#include "device/launch.h"
#include "device_memory.h"
#include "process_end.h"
#include "rig.h"
#include "scene.h"

namespace tests::api {
namespace {

class BrokenContext : public testing::Test {
protected:
    static void SetUpTestSuite() {
        loadLibrary();
        ASSERT_EQ(CUDA_SUCCESS, cuInit(0));
    }
    // A separate context, so that other tests keep theirs.
    void SetUp() override {
        ASSERT_EQ(CUDA_SUCCESS, cuCtxGetCurrent(&before_));
        ASSERT_EQ(CUDA_SUCCESS, cuCtxCreate_v2(&cuda_, 0, 0));
        options_.logCallbackFunction = LogRecord::callback;
        options_.logCallbackData = &log_;
        options_.logCallbackLevel = 4;
        ASSERT_OK(optixDeviceContextCreate(cuda_, &options_, &context_));
    }
    void TearDown() override {
        cuCtxDestroy(cuda_);
        cuCtxSetCurrent(before_);
    }
    void breakContext() {
        mayLoseContext(); // it also destroys that of the other tests
        CUmodule module = nullptr;
        CUfunction kernel = nullptr;
        const std::string text = ptxModule(".visible .entry stop()\n{ trap; }\n");
        ASSERT_EQ(CUDA_SUCCESS, cuModuleLoadData(&module, text.c_str()));
        ASSERT_EQ(CUDA_SUCCESS, cuModuleGetFunction(&kernel, module, "stop"));
        ASSERT_EQ(CUDA_SUCCESS,
                  cuLaunchKernel(kernel, 1, 1, 1, 1, 1, 1, 0, nullptr, nullptr, nullptr));
        ASSERT_NE(CUDA_SUCCESS, cuCtxSynchronize());
        ASSERT_NE(CUDA_SUCCESS, cuCtxSynchronize()) << "for good";
    }
    // This memory is never freed, because memory of the broken context cannot be freed.
    static CUdeviceptr memoryOf(size_t size) {
        CUdeviceptr memory = 0;
        EXPECT_EQ(CUDA_SUCCESS, cuMemAlloc(&memory, size ? size : 1));
        return memory;
    }

    CUcontext before_ = nullptr, cuda_ = nullptr;
    LogRecord log_;
    OptixDeviceContextOptions options_{};
    OptixDeviceContext context_ = nullptr;
};

#define EXPECT_REFUSED(call)                                                                       \
    do {                                                                                           \
        log_.clear();                                                                              \
        EXPECT_NE(OPTIX_SUCCESS, (call));                                                          \
        EXPECT_TRUE(log_.hasError("", "")) << "no line in the log";                                \
    } while (false)

TEST_F(BrokenContext, EveryCallAnswers) {
    Rig rig(context_, log_, compiledPtx("launch", "clang"), compileOptions(1));
    rig.raygen("__raygen__trace");
    rig.link();
    std::vector<char> record(OPTIX_SBT_RECORD_HEADER_SIZE);
    ASSERT_OK(optixSbtRecordPackHeader(rig.group(0), record.data()));
    OptixShaderBindingTable sbt{};
    sbt.raygenRecord = memoryOf(record.size());
    ASSERT_EQ(CUDA_SUCCESS, cuMemcpyHtoD(sbt.raygenRecord, record.data(), record.size()));
    const CUdeviceptr params = memoryOf(sizeof(LaunchParams));

    const Vec3 corners[] = {{-9, -9, 0}, {9, -9, 0}, {0, 9, 0}};
    const CUdeviceptr vertices = memoryOf(sizeof(corners));
    ASSERT_EQ(CUDA_SUCCESS, cuMemcpyHtoD(vertices, corners, sizeof(corners)));
    const unsigned flags = 0;
    OptixBuildInput input{};
    input.type = OPTIX_BUILD_INPUT_TYPE_TRIANGLES;
    input.triangleArray.vertexBuffers = &vertices;
    input.triangleArray.numVertices = 3;
    input.triangleArray.vertexFormat = OPTIX_VERTEX_FORMAT_FLOAT3;
    input.triangleArray.flags = &flags;
    input.triangleArray.numSbtRecords = 1;
    OptixAccelBuildOptions build = buildOptions(OPTIX_BUILD_FLAG_ALLOW_COMPACTION);
    OptixAccelBufferSizes sizes{};
    ASSERT_OK(optixAccelComputeMemoryUsage(context_, &build, &input, 1, &sizes));
    const CUdeviceptr temp = memoryOf(sizes.tempSizeInBytes),
                      output = memoryOf(sizes.outputSizeInBytes),
                      compacted = memoryOf(sizes.outputSizeInBytes);
    OptixTraversableHandle handle = 0, other = 0;
    const auto buildIt = [&] {
        return optixAccelBuild(context_, nullptr, &build, &input, 1, temp, sizes.tempSizeInBytes,
                               output, sizes.outputSizeInBytes, &handle, nullptr, 0);
    };
    ASSERT_OK(buildIt());
    OptixAccelRelocationInfo info{};
    ASSERT_OK(optixAccelGetRelocationInfo(context_, handle, &info));

    OptixDenoiserOptions guides{};
    OptixDenoiser denoiser = nullptr;
    ASSERT_OK(optixDenoiserCreate(context_, OPTIX_DENOISER_MODEL_KIND_HDR, &guides, &denoiser));
    OptixDenoiserSizes denoising{};
    ASSERT_OK(optixDenoiserComputeMemoryResources(denoiser, 16, 16, &denoising));
    const CUdeviceptr state = memoryOf(denoising.stateSizeInBytes),
                      scratch = memoryOf(denoising.withOverlapScratchSizeInBytes);

    breakContext();

    EXPECT_REFUSED(
        optixLaunch(rig.pipeline(), nullptr, params, sizeof(LaunchParams), &sbt, 9, 9, 1));
    EXPECT_REFUSED(buildIt());
    EXPECT_REFUSED(
        optixAccelCompact(context_, nullptr, handle, compacted, sizes.outputSizeInBytes, &other));
    EXPECT_REFUSED(optixAccelRelocate(context_, nullptr, &info, 0, 0, output,
                                      sizes.outputSizeInBytes, &other));
    EXPECT_REFUSED(optixDenoiserSetup(denoiser, nullptr, 16, 16, state, denoising.stateSizeInBytes,
                                      scratch, denoising.withOverlapScratchSizeInBytes));
    // These calls hardly use the context, and may succeed or fail.
    (void)optixAccelGetRelocationInfo(context_, handle, &info);
    (void)optixPipelineSetStackSize(rig.pipeline(), 0, 0, 2000, 1);
    (void)rig.tryLink(1);
    EXPECT_OK(optixDeviceContextSetLogCallback(context_, LogRecord::callback, &log_, 4));
    EXPECT_OK(optixDenoiserDestroy(denoiser));
    log_.clear();
    const OptixResult destroyed = optixDeviceContextDestroy(context_);
    if (onGpu()) // where a context of the CPU device is idle
        EXPECT_EQ(OPTIX_ERROR_CUDA_ERROR, destroyed) << log_.all();
    EXPECT_EQ(OPTIX_ERROR_INVALID_DEVICE_CONTEXT, optixDeviceContextDestroy(context_));
}

} // namespace
} // namespace tests::api
