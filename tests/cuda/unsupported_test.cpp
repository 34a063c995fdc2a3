// SPDX-License-Identifier: Apache-2.0
// Unimplemented functions are exported, report that they are unsupported, and hide no implemented
// function.
#include <cuda.h>
#include <dlfcn.h>
#include <gtest/gtest.h>

namespace {

TEST(Unsupported, FunctionsSaySo) {
    ASSERT_EQ(cuInit(0), CUDA_SUCCESS);
    for (const char* name :
         {"cuGraphAddMemAllocNode", "cuIpcGetMemHandle", "cuGreenCtxCreate",
          "cuGraphicsMapResources_ptsz", "cuMulticastCreate", "cuGetExportTable"}) {
        auto* function =
            reinterpret_cast<CUresult (*)(void*, void*, void*)>(dlsym(RTLD_DEFAULT, name));
        ASSERT_TRUE(function) << name;
        EXPECT_EQ(function(nullptr, nullptr, nullptr), CUDA_ERROR_NOT_SUPPORTED) << name;
    }
    for (const char* name : {"cuGraphAddMemAllocNode", "cuIpcGetMemHandle", "cuMulticastCreate"}) {
        void* found = nullptr;
        EXPECT_EQ(cuGetProcAddress(name, &found, 13000, 0, nullptr), CUDA_SUCCESS) << name;
        EXPECT_TRUE(found) << name;
    }
}

} // namespace
