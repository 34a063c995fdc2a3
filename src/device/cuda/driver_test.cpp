// SPDX-License-Identifier: Apache-2.0
// The driver's table: names, detection of a loaded driver, errors without a driver.
#include "device/cuda/driver.h"

#include <gtest/gtest.h>

#include <set>
#include <string>

namespace sunstone::device::cuda {
namespace {

TEST(CudaDriver, NamesAreThoseOfTheCurrentForms) {
    EXPECT_STREQ(DriverNames::memAlloc, "cuMemAlloc_v2");
    EXPECT_STREQ(DriverNames::memcpyHtoDAsync, "cuMemcpyHtoDAsync_v2");
    EXPECT_STREQ(DriverNames::launchKernel, "cuLaunchKernel");
    EXPECT_STREQ(DriverNames::ctxPushCurrent, "cuCtxPushCurrent_v2");
}

// Names that drivers of CUDA 10.2 export. A newer name here would exclude older drivers, so newer
// functions belong in SUNSTONE_CUDA_NEWER_FUNCTIONS.
TEST(CudaDriver, NeedsOnlyFunctionsOfOldDrivers) {
    const std::set<std::string> old = {
        "cuCtxGetCurrent",
        "cuCtxGetDevice",
        "cuCtxGetLimit",
        "cuCtxPopCurrent_v2",
        "cuCtxPushCurrent_v2",
        "cuCtxSetLimit",
        "cuCtxSynchronize",
        "cuDeviceGet",
        "cuDeviceGetAttribute",
        "cuDeviceGetCount",
        "cuDeviceGetName",
        "cuDeviceGetPCIBusId",
        "cuDevicePrimaryCtxRetain",
        "cuDeviceTotalMem_v2",
        "cuDriverGetVersion",
        "cuEventCreate",
        "cuEventDestroy_v2",
        "cuEventQuery",
        "cuEventRecord",
        "cuEventSynchronize",
        "cuFuncGetAttribute",
        "cuFuncSetAttribute",
        "cuGetErrorName",
        "cuGetErrorString",
        "cuInit",
        "cuLaunchHostFunc",
        "cuLaunchKernel",
        "cuLinkAddData_v2",
        "cuLinkComplete",
        "cuLinkCreate_v2",
        "cuLinkDestroy",
        "cuMemAllocHost_v2",
        "cuMemAllocManaged",
        "cuMemAlloc_v2",
        "cuMemFreeHost",
        "cuMemFree_v2",
        "cuMemGetAddressRange_v2",
        "cuMemGetInfo_v2",
        "cuMemcpy3D_v2",
        "cuMemcpyAsync",
        "cuMemcpyDtoDAsync_v2",
        "cuMemcpyDtoHAsync_v2",
        "cuMemcpyDtoH_v2",
        "cuMemcpyHtoDAsync_v2",
        "cuMemcpyHtoD_v2",
        "cuMemsetD32Async",
        "cuMemsetD8Async",
        "cuMipmappedArrayCreate",
        "cuMipmappedArrayDestroy",
        "cuMipmappedArrayGetLevel",
        "cuModuleGetFunction",
        "cuModuleGetGlobal_v2",
        "cuModuleLoadDataEx",
        "cuModuleUnload",
        "cuOccupancyMaxActiveBlocksPerMultiprocessor",
        "cuPointerGetAttribute",
        "cuStreamCreate",
        "cuStreamDestroy_v2",
        "cuStreamGetCtx",
        "cuStreamIsCapturing",
        "cuStreamQuery",
        "cuStreamSynchronize",
        "cuStreamWaitEvent",
        "cuTexObjectCreate",
        "cuTexObjectDestroy",
        "cuThreadExchangeStreamCaptureMode",
    };
#define SUNSTONE_CUDA_EXPECT(member, function)                                                     \
    EXPECT_TRUE(old.contains(DriverNames::member)) << DriverNames::member;
    SUNSTONE_CUDA_FUNCTIONS(SUNSTONE_CUDA_EXPECT)
#undef SUNSTONE_CUDA_EXPECT
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
