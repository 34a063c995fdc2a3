// SPDX-License-Identifier: Apache-2.0
// The stack limit of a CUDA context, with the CPU device acting as a GPU: calls of several threads
// only raise it.
#include "api/rig.h"

#include "device/cuda/driver.h"

#include <chrono>
#include <condition_variable>
#include <cstdlib>
#include <mutex>
#include <thread>

namespace tests::api {
namespace {

using sunstone::device::cuda::driverForTests;

// The driver is chosen before its first use.
[[maybe_unused]] const bool isGpu = [] {
    setenv("SUNSTONE_GPU_BACK_END", "cpu-device", 1);
    setenv("SUNSTONE_TEST_GPU", "1", 1);
    return true;
}();

// Delays the first thread after its query of the limit, until the other thread has set the limit or
// some time has passed.
struct SlowDriver {
    static inline decltype(driverForTests().ctxGetLimit) originalGet;
    static inline decltype(driverForTests().ctxSetLimit) originalSet;
    static inline std::mutex mutex;
    static inline std::condition_variable changed;
    static inline bool isAsked, isRaised;

    SlowDriver() {
        originalGet = driverForTests().ctxGetLimit;
        originalSet = driverForTests().ctxSetLimit;
        isAsked = isRaised = false;
        driverForTests().ctxGetLimit = get;
        driverForTests().ctxSetLimit = set;
    }
    ~SlowDriver() {
        driverForTests().ctxGetLimit = originalGet;
        driverForTests().ctxSetLimit = originalSet;
    }
    static CUresult get(size_t* value, CUlimit limit) {
        const CUresult result = originalGet(value, limit);
        std::unique_lock lock(mutex);
        if (isAsked)
            return result;
        isAsked = true;
        changed.notify_all();
        changed.wait_for(lock, std::chrono::milliseconds(500), [] { return isRaised; });
        return result;
    }
    static CUresult set(CUlimit limit, size_t value) {
        const CUresult result = originalSet(limit, value);
        std::lock_guard lock(mutex);
        isRaised = true;
        changed.notify_all();
        return result;
    }
    static void awaitQuery() {
        std::unique_lock lock(mutex);
        changed.wait(lock, [] { return isAsked; });
    }
};

using StackLimit = ApiTest;

TEST_F(StackLimit, IsTheLargestThatAnyThreadNeeds) {
    constexpr unsigned kLess = 20'000, kMore = 60'000;
    Rig rig(context_, log_, ptxModule(".visible .entry __raygen__none()\n{ ret; }\n"),
            compileOptions(0));
    rig.raygen("__raygen__none");
    rig.link();
    size_t limit = 0;
    {
        const SlowDriver slow;
        std::thread less(
            [&] { EXPECT_OK(optixPipelineSetStackSize(rig.pipeline(), 0, 0, kLess, 1)); });
        SlowDriver::awaitQuery();
        EXPECT_OK(optixPipelineSetStackSize(rig.pipeline(), 0, 0, kMore, 1));
        less.join();
    }
    ASSERT_EQ(CUDA_SUCCESS, driverForTests().ctxGetLimit(&limit, CU_LIMIT_STACK_SIZE));
    EXPECT_GE(limit, kMore);
}

} // namespace
} // namespace tests::api
