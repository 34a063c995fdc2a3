// SPDX-License-Identifier: Apache-2.0
// Children of fork: if the parent has initialised CUDA, every call in the child fails at once, as
// with a GPU's driver; otherwise the child may initialise it.
#include <cuda.h>
#include <gtest/gtest.h>

#include "../main/forked_child.h"
#include "apps/entry_point_names.h"

#include <atomic>
#include <cstdio>
#include <cstdlib>
#include <dlfcn.h>
#include <functional>
#include <string>
#include <thread>
#include <vector>

namespace {

using tests::inChild;

// Functions that need no initialisation: a GPU's driver (580, H200) executes them in a child.
bool needsNothing(const std::string& name) {
    return name == "cuGetErrorName" || name == "cuGetErrorString" || name == "cuDriverGetVersion" ||
           name == "cuGetProcAddress" || name == "cuThreadExchangeStreamCaptureMode";
}

// Calls all functions with zeros as arguments; returns the number of results other than "not
// initialised".
int callAll() {
    using Function =
        int (*)(void*, void*, void*, void*, void*, void*, void*, void*, void*, void*, void*, void*);
    int others = 0;
    for (const char* name : kEntryPointNames)
        for (const char* form : {"", "_v2", "_v3", "_ptsz", "_ptds", "_v2_ptsz", "_v2_ptds"}) {
            const std::string symbol = std::string(name) + form;
            auto* const function = reinterpret_cast<Function>(dlsym(RTLD_DEFAULT, symbol.c_str()));
            if (!function || needsNothing(name))
                continue;
            const int result = function(nullptr, nullptr, nullptr, nullptr, nullptr, nullptr,
                                        nullptr, nullptr, nullptr, nullptr, nullptr, nullptr);
            if (result != CUDA_ERROR_NOT_INITIALIZED) {
                std::fprintf(stderr, "%s: %d\n", symbol.c_str(), result);
                ++others;
            }
        }
    return others > 100 ? 100 : others;
}

class Fork : public testing::Test {
protected:
    void SetUp() override {
        ASSERT_EQ(cuInit(0), CUDA_SUCCESS);
        ASSERT_EQ(cuDevicePrimaryCtxRetain(&context_, 0), CUDA_SUCCESS);
        ASSERT_EQ(cuCtxSetCurrent(context_), CUDA_SUCCESS);
        ASSERT_EQ(cuMemAlloc(&memory_, 4096), CUDA_SUCCESS);
        ASSERT_EQ(cuStreamCreate(&stream_, CU_STREAM_DEFAULT), CUDA_SUCCESS);
        for (const CUstream stream : {stream_, CU_STREAM_LEGACY, CU_STREAM_PER_THREAD})
            ASSERT_EQ(cuMemsetD8Async(memory_, 1, 4096, stream), CUDA_SUCCESS);
        ASSERT_EQ(cuCtxSynchronize(), CUDA_SUCCESS);
    }
    void TearDown() override {
        EXPECT_EQ(cuStreamDestroy(stream_), CUDA_SUCCESS);
        EXPECT_EQ(cuMemFree(memory_), CUDA_SUCCESS);
        EXPECT_EQ(cuCtxSetCurrent(nullptr), CUDA_SUCCESS);
        EXPECT_EQ(cuDevicePrimaryCtxRelease(0), CUDA_SUCCESS);
    }
    // The number of calls on the parent's objects with a result other than "not initialised".
    int useObjects() const {
        CUdeviceptr made = 0;
        const CUresult results[] = {cuInit(0),
                                    cuMemAlloc(&made, 16),
                                    cuMemsetD8Async(memory_, 2, 16, stream_),
                                    cuMemsetD8(memory_, 2, 16),
                                    cuStreamSynchronize(stream_),
                                    cuStreamSynchronize(CU_STREAM_PER_THREAD),
                                    cuCtxSynchronize(),
                                    cuStreamDestroy(stream_)};
        int others = 0;
        for (const CUresult result : results)
            others += result != CUDA_ERROR_NOT_INITIALIZED;
        return others;
    }

    CUcontext context_ = nullptr;
    CUdeviceptr memory_ = 0;
    CUstream stream_ = nullptr;
};

TEST_F(Fork, ChildrenAreRefused) {
    for (const bool exits : {false, true})
        EXPECT_EQ(inChild([&] { return useObjects(); }, exits), 0);
    // The parent goes on.
    EXPECT_EQ(cuMemsetD8Async(memory_, 3, 16, stream_), CUDA_SUCCESS);
    EXPECT_EQ(cuCtxSynchronize(), CUDA_SUCCESS);
}

TEST_F(Fork, ByEveryFunction) {
    EXPECT_EQ(inChild(callAll), 0);
}

TEST_F(Fork, FunctionsWithoutInitialisationGoOn) {
    EXPECT_EQ(inChild([] {
                  int version = 0;
                  const char* name = nullptr;
                  void* function = nullptr;
                  CUstreamCaptureMode mode = CU_STREAM_CAPTURE_MODE_RELAXED;
                  const bool go =
                      cuDriverGetVersion(&version) == CUDA_SUCCESS && version != 0 &&
                      cuGetErrorName(CUDA_ERROR_NOT_INITIALIZED, &name) == CUDA_SUCCESS &&
                      cuGetProcAddress("cuInit", &function, 12000, 0, nullptr) == CUDA_SUCCESS &&
                      cuThreadExchangeStreamCaptureMode(&mode) == CUDA_SUCCESS;
                  return go ? 0 : 1;
              }),
              0);
}

TEST_F(Fork, ChildrenOfChildrenToo) {
    EXPECT_EQ(inChild([&] { return inChild([&] { return useObjects(); }); }), 0);
}

// Another thread may hold any lock at the time of the fork.
TEST_F(Fork, WhileOtherThreadsCall) {
    std::atomic<bool> ends{false};
    std::vector<std::thread> threads;
    for (unsigned i = 0; i < 3; ++i)
        threads.emplace_back([&] {
            cuCtxSetCurrent(context_);
            while (!ends) {
                CUdeviceptr own = 0;
                CUstream stream = nullptr;
                CUgraph graph = nullptr;
                cuMemAlloc(&own, 64);
                cuStreamCreate(&stream, CU_STREAM_DEFAULT);
                cuMemsetD8Async(own, 1, 64, stream);
                cuGraphCreate(&graph, 0);
                cuGraphDestroy(graph);
                cuStreamDestroy(stream);
                cuMemFree(own);
            }
        });
    constexpr unsigned kForks = 40;
    for (unsigned i = 0; i < kForks; ++i)
        ASSERT_EQ(inChild([&] { return useObjects(); }, i % 2), 0) << i;
    ends = true;
    for (std::thread& thread : threads)
        thread.join();
}

TEST(ForkFirst, ChildrenMayInitialise) {
    CUcontext context = nullptr;
    if (cuCtxGetCurrent(&context) != CUDA_ERROR_NOT_INITIALIZED)
        GTEST_SKIP() << "another test has initialised CUDA";
    const auto work = [] {
        CUcontext own = nullptr;
        CUdeviceptr memory = 0;
        unsigned char value = 0;
        const bool works =
            cuInit(0) == CUDA_SUCCESS && cuDevicePrimaryCtxRetain(&own, 0) == CUDA_SUCCESS &&
            cuCtxSetCurrent(own) == CUDA_SUCCESS && cuMemAlloc(&memory, 16) == CUDA_SUCCESS &&
            cuMemsetD8(memory, 7, 16) == CUDA_SUCCESS &&
            cuMemcpyDtoH(&value, memory, 1) == CUDA_SUCCESS && value == 7;
        return works ? 0 : 1;
    };
    EXPECT_EQ(inChild(work), 0);
    EXPECT_EQ(work(), 0);
}

} // namespace
