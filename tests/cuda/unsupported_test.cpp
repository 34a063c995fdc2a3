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

// A module of programs that nvcc compiles with -rdc=true and links with the device run-time.
TEST(Unsupported, KernelsThatLaunchKernels) {
    constexpr char kModule[] = R"(
.version 7.0
.target sm_75
.address_size 64
.extern .func (.param .b64 result) __cuda_syscall_cnpv2GetParameterBufferV2(.param .b64 a);
.func (.param .b64 result) cudaGetParameterBufferV2(.param .b64 a) {
    .reg .b64 %rd<3>;
    ld.param.b64 %rd1, [a];
    {
    .param .b64 p;
    .param .b64 r;
    st.param.b64 [p], %rd1;
    call.uni (r), __cuda_syscall_cnpv2GetParameterBufferV2, (p);
    ld.param.b64 %rd2, [r];
    }
    st.param.b64 [result], %rd2;
    ret;
}
.visible .entry launches() {
    .reg .b64 %rd<2>;
    {
    .param .b64 p;
    .param .b64 r;
    st.param.b64 [p], 0;
    call.uni (r), cudaGetParameterBufferV2, (p);
    ld.param.b64 %rd1, [r];
    }
    ret;
}
.visible .entry writes(.param .u64 to) {
    .reg .b64 %rd<2>;
    ld.param.u64 %rd1, [to];
    st.global.u32 [%rd1], 5;
    ret;
}
)";
    ASSERT_EQ(cuInit(0), CUDA_SUCCESS);
    CUcontext context = nullptr;
    ASSERT_EQ(cuDevicePrimaryCtxRetain(&context, 0), CUDA_SUCCESS);
    ASSERT_EQ(cuCtxSetCurrent(context), CUDA_SUCCESS);
    CUmodule module = nullptr;
    ASSERT_EQ(cuModuleLoadData(&module, kModule), CUDA_SUCCESS);
    CUfunction writes = nullptr, launches = nullptr;
    ASSERT_EQ(cuModuleGetFunction(&writes, module, "writes"), CUDA_SUCCESS);
    CUdeviceptr memory = 0;
    ASSERT_EQ(cuMemAlloc(&memory, 4), CUDA_SUCCESS);
    void* arguments[] = {&memory};
    EXPECT_EQ(cuLaunchKernel(writes, 1, 1, 1, 1, 1, 1, 0, nullptr, arguments, nullptr),
              CUDA_SUCCESS);
    int value = 0;
    EXPECT_EQ(cuMemcpyDtoH(&value, memory, 4), CUDA_SUCCESS);
    EXPECT_EQ(value, 5);
    CUresult result = cuModuleGetFunction(&launches, module, "launches");
    if (result == CUDA_SUCCESS)
        result = cuLaunchKernel(launches, 1, 1, 1, 1, 1, 1, 0, nullptr, nullptr, nullptr);
    EXPECT_EQ(result, CUDA_ERROR_NOT_SUPPORTED);
    EXPECT_EQ(cuCtxSynchronize(), CUDA_SUCCESS);
    EXPECT_EQ(cuMemFree(memory), CUDA_SUCCESS);
    EXPECT_EQ(cuModuleUnload(module), CUDA_SUCCESS);
    cuDevicePrimaryCtxRelease(0);
}

// Instructions of clusters in a launch without clusters, in which each block is a cluster.
TEST(Unsupported, BlocksAreClustersOfTheirOwn) {
    constexpr char kModule[] = R"(
.version 8.0
.target sm_90a
.address_size 64
.visible .entry k(.param .u64 to) {
    .reg .b64 %rd<6>;
    .reg .b32 %r<14>;
    .reg .pred %p<2>;
    .shared .align 4 .b32 words[64];
    setmaxnreg.inc.sync.aligned.u32 40;
    ld.param.u64 %rd1, [to];
    mov.u32 %r1, %tid.x;
    mov.u32 %r2, %cluster_nctaid.x;
    mov.u32 %r3, %cluster_ctarank;
    mov.u32 %r4, %clusterid.x;
    mov.u32 %r5, %nclusterid.x;
    mov.pred %p1, %is_explicit_cluster;
    selp.u32 %r6, 1, 0, %p1;
    mov.u32 %r7, %envreg3;
    mov.u64 %rd2, words;
    mul.wide.u32 %rd3, %r1, 4;
    add.u64 %rd4, %rd2, %rd3;
    st.shared.u32 [%rd4], %r1;
    barrier.cluster.arrive.release.aligned;
    barrier.cluster.wait.acquire.aligned;
    xor.b32 %r8, %r1, 63;
    mul.wide.u32 %rd3, %r8, 4;
    add.u64 %rd4, %rd2, %rd3;
    ld.shared.u32 %r9, [%rd4];
    mad.lo.u32 %r10, %r5, 100, %r4;
    mad.lo.u32 %r10, %r10, 10, %r2;
    add.u32 %r10, %r10, %r3;
    add.u32 %r10, %r10, %r6;
    add.u32 %r10, %r10, %r7;
    mad.lo.u32 %r10, %r10, 100, %r9;
    mov.u32 %r11, %ctaid.x;
    mad.lo.u32 %r12, %r11, 64, %r1;
    mul.wide.u32 %rd3, %r12, 4;
    add.u64 %rd4, %rd1, %rd3;
    st.global.u32 [%rd4], %r10;
    ret;
}
)";
    ASSERT_EQ(cuInit(0), CUDA_SUCCESS);
    CUcontext context = nullptr;
    ASSERT_EQ(cuDevicePrimaryCtxRetain(&context, 0), CUDA_SUCCESS);
    ASSERT_EQ(cuCtxSetCurrent(context), CUDA_SUCCESS);
    CUmodule module = nullptr;
    CUfunction function = nullptr;
    ASSERT_EQ(cuModuleLoadData(&module, kModule), CUDA_SUCCESS);
    ASSERT_EQ(cuModuleGetFunction(&function, module, "k"), CUDA_SUCCESS);
    CUdeviceptr memory = 0;
    ASSERT_EQ(cuMemAlloc(&memory, 128 * 4), CUDA_SUCCESS);
    void* arguments[] = {&memory};
    ASSERT_EQ(cuLaunchKernel(function, 2, 1, 1, 64, 1, 1, 0, nullptr, arguments, nullptr),
              CUDA_SUCCESS);
    unsigned values[128];
    ASSERT_EQ(cuMemcpyDtoH(values, memory, sizeof values), CUDA_SUCCESS);
    for (unsigned i = 0; i < 128; ++i) // two clusters, the number, one block
        EXPECT_EQ(values[i], ((200 + i / 64) * 10 + 1) * 100 + (63 - i % 64)) << i;
    EXPECT_EQ(cuMemFree(memory), CUDA_SUCCESS);
    EXPECT_EQ(cuModuleUnload(module), CUDA_SUCCESS);
    cuDevicePrimaryCtxRelease(0);
}

} // namespace
