// SPDX-License-Identifier: Apache-2.0
// The driver's table: names, detection of a loaded driver, errors without a driver.
#include "device/cuda/driver.h"

#include <gtest/gtest.h>

#include <string>

namespace sunstone::device::cuda {
namespace {

TEST(CudaDriver, NamesAreThoseOfTheCurrentForms) {
    EXPECT_STREQ(DriverNames::memAlloc, "cuMemAlloc_v2");
    EXPECT_STREQ(DriverNames::memcpyHtoDAsync, "cuMemcpyHtoDAsync_v2");
    EXPECT_STREQ(DriverNames::launchKernel, "cuLaunchKernel");
    EXPECT_STREQ(DriverNames::ctxPushCurrent, "cuCtxPushCurrent_v2");
}

TEST(CudaDriver, NoneIsLoadedUnlessTheProcessDoes) {
    EXPECT_EQ(loadedDriver(), LoadedDriver::kNone);
}

// Without a driver, opening fails with the reason. With a driver, the table is complete and errors
// have the names of function and code.
TEST(CudaDriver, IsOpenedOrRefusedWithAReason) {
    try {
        const Driver& opened = driver();
        ASSERT_NE(opened.launchKernel, nullptr);
        check(CUDA_SUCCESS, "cuInit");
        try {
            check(CUDA_ERROR_INVALID_VALUE, DriverNames::memFree);
            FAIL() << "no error";
        } catch (const Error& error) {
            EXPECT_EQ(error.code(), Code::kCudaError);
            EXPECT_NE(std::string(error.what()).find("cuMemFree_v2: CUDA_ERROR_INVALID_VALUE"),
                      std::string::npos);
        }
    } catch (const Error& error) {
        EXPECT_TRUE(error.code() == Code::kNotInitialized || error.code() == Code::kNotSupported);
        EXPECT_NE(std::string(error.what()).find("libcuda.so.1"), std::string::npos);
    }
}

} // namespace
} // namespace sunstone::device::cuda
