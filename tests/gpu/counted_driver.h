// SPDX-License-Identifier: Apache-2.0
// A fixture for tests of cached machine code, with the CPU device acting as a GPU. Calls of the
// driver are counted, and may fail.
#pragma once

#include "api/fixture.h"

#include "device/cuda/driver.h"

#include <atomic>
#include <cstdlib>
#include <filesystem>
#include <string>

namespace tests::api {

// The driver is chosen before its first use.
[[maybe_unused]] inline const bool isGpuTest = [] {
    setenv("SUNSTONE_GPU_BACK_END", "cpu-device", 1);
    setenv("SUNSTONE_TEST_GPU", "1", 1);
    return true;
}();

// Modules that the driver loads and unloads; how many of the next loads and look-ups of kernels
// fail.
inline std::atomic<unsigned> loads, unloads, refusals, lacks;

inline void countCalls() {
    using sunstone::device::cuda::Driver;
    static const bool isDone = [] {
        static Driver original = sunstone::device::cuda::driverForTests();
        Driver& driver = sunstone::device::cuda::driverForTests();
        driver.moduleLoadDataEx = [](CUmodule* module, const void* image, unsigned count,
                                     CUjit_option* options, void** values) {
            if (refusals > 0 && refusals-- > 0)
                return CUDA_ERROR_NO_BINARY_FOR_GPU;
            ++loads;
            return original.moduleLoadDataEx(module, image, count, options, values);
        };
        driver.moduleGetFunction = [](CUfunction* function, CUmodule module, const char* name) {
            if (lacks > 0 && lacks-- > 0)
                return CUDA_ERROR_NOT_FOUND;
            return original.moduleGetFunction(function, module, name);
        };
        driver.moduleUnload = [](CUmodule module) {
            ++unloads;
            return original.moduleUnload(module);
        };
        return true;
    }();
    (void)isDone;
}

// The disk cache is a folder of the test.
class CachedGpuTest : public ApiTest {
protected:
    void SetUp() override {
        std::string name = testing::TempDir() + "sunstone_gpu_cache_XXXXXX";
        ASSERT_NE(nullptr, mkdtemp(name.data()));
        folder_ = name;
        unsetenv("OPTIX_CACHE_MAXSIZE");
        setenv("OPTIX_CACHE_PATH", folder_.c_str(), 1);
        setenv("SUNSTONE_GPU_CODE", "whole", 1); // else another thread uses the cache, too
        ApiTest::SetUp();
        countCalls();
        loads = unloads = refusals = lacks = 0;
    }
    void TearDown() override {
        ApiTest::TearDown();
        unsetenv("SUNSTONE_GPU_CODE");
        unsetenv("OPTIX_CACHE_PATH");
        setenv("OPTIX_CACHE_MAXSIZE", "0", 1);
        std::filesystem::remove_all(folder_);
    }
    std::string folder_;
};

} // namespace tests::api
