// SPDX-License-Identifier: Apache-2.0
// Launches whose programs access CUDA memory after it was freed: the launch fails, and the log
// names the freed allocation.
#include "device/faults.h"
#include "device_memory.h"
#include "rig.h"

#include <cuda.h>

namespace tests::api {
namespace {

class FreedMemory : public ApiTest {
protected:
    void SetUp() override {
        if (onGpu())
            GTEST_SKIP() << "a GPU loses its context";
        ASSERT_EQ(CUDA_SUCCESS, cuInit(0));
        ASSERT_EQ(CUDA_SUCCESS, cuCtxCreate(&cuda_, nullptr, 0, 0));
        ApiTest::SetUp();
    }
    void TearDown() override {
        ApiTest::TearDown();
        if (cuda_)
            EXPECT_EQ(CUDA_SUCCESS, cuCtxDestroy(cuda_));
    }

private:
    CUcontext cuda_ = nullptr;
};

TEST_F(FreedMemory, EndsTheLaunch) {
#if defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
    GTEST_SKIP() << "a sanitizer reports faults";
#endif
#endif
    Rig rig(context_, log_, compiledPtx("faults", "clang"), compileOptions(0));
    rig.raygenRecord(rig.raygen("__raygen__faults"));
    rig.link();
    const OptixShaderBindingTable sbt = rig.table();
    constexpr unsigned kIndices = 64;
    Buffer results(kIndices * 4), params(sizeof(FaultParams));
    for (const size_t size : {size_t(256), size_t(64) << 10, size_t(64) << 20})
        for (const unsigned writes : {0u, 1u}) {
            SCOPED_TRACE(testing::Message() << size << " writes " << writes);
            CUdeviceptr memory = 0;
            ASSERT_EQ(CUDA_SUCCESS, cuMemAlloc(&memory, size));
            const auto launch = [&](CUdeviceptr wild) {
                *params.as<FaultParams>() = {results.as<unsigned>(), wild, 7, writes};
                const OptixResult result = optixLaunch(rig.pipeline(), nullptr, params.address(),
                                                       sizeof(FaultParams), &sbt, kIndices, 1, 1);
                waitForDevice();
                return result;
            };
            EXPECT_OK(launch(memory + 16));
            ASSERT_EQ(CUDA_SUCCESS, cuMemFree(memory));
            log_.clear();
            (void)launch(memory + 16);
            const std::string freed = "use after free: the address is 16 bytes into " +
                                      std::to_string(size) + " bytes of device memory";
            EXPECT_TRUE(log_.hasError(freed, "launch index (7, 0, 0)")) << log_.all();
            EXPECT_EQ(OPTIX_ERROR_LAUNCH_FAILURE, launch(0)) << "the stream's pending error";
            EXPECT_OK(launch(0));
        }
}

} // namespace
} // namespace tests::api
