// SPDX-License-Identifier: Apache-2.0
// What is not implemented is exported, says so, and hides nothing that is.
#include <cuda.h>
#include <dlfcn.h>
#include <gtest/gtest.h>

namespace {

TEST(Unsupported, FunctionsSaySo) {
    ASSERT_EQ(cuInit(0), CUDA_SUCCESS);
    for (const char* name : {"cuModuleGetTexRef", "cuIpcGetMemHandle", "cuGreenCtxCreate",
                             "cuGraphicsMapResources_ptsz", "cuMemCreate", "cuGetExportTable"}) {
        auto* function =
            reinterpret_cast<CUresult (*)(void*, void*, void*)>(dlsym(RTLD_DEFAULT, name));
        ASSERT_TRUE(function) << name;
        EXPECT_EQ(function(nullptr, nullptr, nullptr), CUDA_ERROR_NOT_SUPPORTED) << name;
    }
    for (const char* name : {"cuModuleGetTexRef", "cuIpcGetMemHandle", "cuMemCreate"}) {
        void* found = nullptr;
        EXPECT_EQ(cuGetProcAddress(name, &found, 12000, 0, nullptr), CUDA_SUCCESS) << name;
        EXPECT_TRUE(found) << name;
    }
}

TEST(Unsupported, TheyDoNotHideOtherForms) {
    ASSERT_EQ(cuInit(0), CUDA_SUCCESS);
    // Of these, newer or older forms are not there.
    for (const char* name : {"cuStreamGetCtx", "cuCtxSynchronize", "cuCtxGetDevice", "cuMemAlloc",
                             "cuMemcpyHtoD", "cuArray3DCreate", "cuCtxCreate"}) {
        for (cuuint64_t flags :
             {CU_GET_PROC_ADDRESS_DEFAULT, CU_GET_PROC_ADDRESS_PER_THREAD_DEFAULT_STREAM}) {
            void* found = nullptr;
            ASSERT_EQ(cuGetProcAddress(name, &found, 13000, flags, nullptr), CUDA_SUCCESS) << name;
            Dl_info info = {};
            ASSERT_NE(dladdr(found, &info), 0);
            ASSERT_TRUE(info.dli_sname);
            EXPECT_EQ(std::string(info.dli_sname).find(name), 0u);
            EXPECT_NE(std::string(info.dli_sname), "cuStreamGetCtx_v2");
            EXPECT_NE(std::string(info.dli_sname), "cuStreamGetCtx_v2_ptsz");
            EXPECT_NE(std::string(info.dli_sname), "cuCtxSynchronize_v2");
            EXPECT_NE(std::string(info.dli_sname), "cuCtxGetDevice_v2");
            EXPECT_NE(std::string(info.dli_sname), "cuMemAlloc");
        }
    }
}

} // namespace
