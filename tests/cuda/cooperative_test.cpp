// SPDX-License-Identifier: Apache-2.0
// Cooperative launches through the driver API: barriers over the whole grid, their limits, the
// attributes of extended launches; and threads of a block that wait for one another by polling.
#include <cuda.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

namespace {

// barrier: the word at the address in %envreg1 and %envreg2 counts the blocks, once for each round.
// pair: thread 0 waits for thread 1 of its block, which starts later in every order of execution.
const char* const kText = R"(.version 7.0
.target sm_70
.address_size 64
.visible .entry rounds(.param .u64 out, .param .u32 rounds)
{
    .reg .pred %p<4>;
    .reg .b32 %r<16>;
    .reg .b64 %rd<8>;
    ld.param.u64 %rd1, [out];
    ld.param.u32 %r1, [rounds];
    mov.u32 %r2, %envreg2;
    mov.u32 %r3, %envreg1;
    mov.b64 %rd2, {%r2, %r3};
    mov.u32 %r4, %nctaid.x;
    mov.u32 %r5, %ctaid.x;
    mov.u32 %r6, %tid.x;
    mov.u32 %r7, 0;
    mul.wide.u32 %rd3, %r5, 4;
    add.s64 %rd3, %rd1, %rd3;
again:
    setp.ne.u32 %p1, %r6, 0;
    @%p1 bra wait;
    st.volatile.global.u32 [%rd3], %r7;
    atom.add.release.gpu.global.u32 %r8, [%rd2+4], 1;
    add.u32 %r9, %r7, 1;
    mul.lo.u32 %r9, %r9, %r4;
spin:
    ld.acquire.gpu.u32 %r10, [%rd2+4];
    setp.lt.u32 %p2, %r10, %r9;
    @%p2 bra spin;
wait:
    bar.sync 0;
    add.u32 %r7, %r7, 1;
    setp.lt.u32 %p3, %r7, %r1;
    @%p3 bra again;
    @%p1 bra done;
    st.global.u32 [%rd3], %r10;
done:
    ret;
}
.visible .entry pair(.param .u64 out)
{
    .reg .pred %p<3>;
    .reg .b32 %r<4>;
    .reg .b64 %rd<2>;
    ld.param.u64 %rd1, [out];
    mov.u32 %r1, %tid.x;
    setp.ne.u32 %p1, %r1, 0;
    @%p1 bra second;
first:
    ld.volatile.global.u32 %r2, [%rd1];
    setp.eq.u32 %p2, %r2, 0;
    @%p2 bra first;
    bra.uni meet;
second:
    st.volatile.global.u32 [%rd1], 7;
meet:
    bar.sync 0;
    ret;
}
.visible .entry leave(.param .u64 out)
{
    .reg .pred %p<3>;
    .reg .b32 %r<4>;
    .reg .b64 %rd<2>;
    ld.param.u64 %rd1, [out];
    mov.u32 %r1, %tid.x;
    and.b32 %r2, %r1, 1;
    setp.eq.u32 %p1, %r2, 0;
    setp.lt.and.u32 %p2, %r1, 5, %p1;
    @%p2 exit;
    red.global.add.u32 [%rd1], 1;
    ret;
}
.visible .entry fails()
{
    .reg .pred %p<2>;
    .reg .b32 %r<4>;
    .reg .b64 %rd<2>;
    mov.u32 %r1, %ctaid.x;
    mov.u32 %r2, %envreg2;
    mov.u32 %r3, %envreg1;
    mov.b64 %rd1, {%r2, %r3};
    setp.eq.u32 %p1, %r1, 0;
    @%p1 trap;
forever:
    ld.acquire.gpu.u32 %r2, [%rd1+4];
    bra.uni forever;
}
)";

class Cooperative : public testing::Test {
protected:
    void SetUp() override {
        ASSERT_EQ(cuInit(0), CUDA_SUCCESS);
        ASSERT_EQ(cuDevicePrimaryCtxRetain(&context, 0), CUDA_SUCCESS);
        ASSERT_EQ(cuCtxSetCurrent(context), CUDA_SUCCESS);
        ASSERT_EQ(cuModuleLoadData(&module, kText), CUDA_SUCCESS);
        ASSERT_EQ(cuModuleGetFunction(&rounds, module, "rounds"), CUDA_SUCCESS);
        ASSERT_EQ(cuMemAlloc(&out, 4096), CUDA_SUCCESS);
        ASSERT_EQ(cuMemsetD8(out, 0, 4096), CUDA_SUCCESS);
        int processors = 0, each = 0;
        ASSERT_EQ(cuDeviceGetAttribute(&processors, CU_DEVICE_ATTRIBUTE_MULTIPROCESSOR_COUNT, 0),
                  CUDA_SUCCESS);
        ASSERT_EQ(cuOccupancyMaxActiveBlocksPerMultiprocessor(&each, rounds, 64, 0), CUDA_SUCCESS);
        most = unsigned(processors * each);
    }
    void TearDown() override {
        EXPECT_EQ(cuMemFree(out), CUDA_SUCCESS);
        EXPECT_EQ(cuModuleUnload(module), CUDA_SUCCESS);
        EXPECT_EQ(cuCtxSetCurrent(nullptr), CUDA_SUCCESS);
        EXPECT_EQ(cuDevicePrimaryCtxRelease(0), CUDA_SUCCESS);
    }
    CUresult launchRounds(unsigned blocks, unsigned count) {
        void* params[] = {&out, &count};
        return cuLaunchCooperativeKernel(rounds, blocks, 1, 1, 64, 1, 1, 0, nullptr, params);
    }
    CUcontext context = nullptr;
    CUmodule module = nullptr;
    CUfunction rounds = nullptr;
    CUdeviceptr out = 0;
    unsigned most = 0; // blocks of 64 threads that are resident at once
};

TEST_F(Cooperative, AllBlocksMeetInEveryRound) {
    int supported = 0;
    EXPECT_EQ(cuDeviceGetAttribute(&supported, CU_DEVICE_ATTRIBUTE_COOPERATIVE_LAUNCH, 0),
              CUDA_SUCCESS);
    EXPECT_EQ(supported, 1);
    const unsigned blocks = std::min(most, 16u), count = 20;
    ASSERT_EQ(launchRounds(blocks, count), CUDA_SUCCESS);
    ASSERT_EQ(cuCtxSynchronize(), CUDA_SUCCESS);
    std::vector<unsigned> host(blocks);
    ASSERT_EQ(cuMemcpyDtoH(host.data(), out, blocks * 4), CUDA_SUCCESS);
    for (unsigned value : host)
        EXPECT_EQ(value, blocks * count);
}

TEST_F(Cooperative, OccupancyIsTheLimit) {
    EXPECT_EQ(launchRounds(most, 2), CUDA_SUCCESS);
    EXPECT_EQ(cuCtxSynchronize(), CUDA_SUCCESS);
    EXPECT_EQ(launchRounds(most + 1, 2), CUDA_ERROR_COOPERATIVE_LAUNCH_TOO_LARGE);
    EXPECT_EQ(launchRounds(0, 2), CUDA_ERROR_INVALID_VALUE);
    EXPECT_EQ(cuLaunchCooperativeKernel(nullptr, 1, 1, 1, 1, 1, 1, 0, nullptr, nullptr),
              CUDA_ERROR_INVALID_HANDLE);
    EXPECT_EQ(cuLaunchCooperativeKernel(rounds, 1, 1, 1, 64, 1, 1, 0,
                                        reinterpret_cast<CUstream>(0x1234567), nullptr),
              CUDA_ERROR_INVALID_HANDLE);
}

TEST_F(Cooperative, AFaultEndsAllBlocks) {
    CUfunction fails = nullptr;
    ASSERT_EQ(cuModuleGetFunction(&fails, module, "fails"), CUDA_SUCCESS);
    ASSERT_EQ(cuLaunchCooperativeKernel(fails, 4, 1, 1, 32, 1, 1, 0, nullptr, nullptr),
              CUDA_SUCCESS);
    EXPECT_EQ(cuCtxSynchronize(), CUDA_ERROR_LAUNCH_FAILED);
    // The context has failed, too.
    ASSERT_EQ(cuCtxSetCurrent(nullptr), CUDA_SUCCESS);
    ASSERT_EQ(cuDevicePrimaryCtxReset(0), CUDA_SUCCESS);
    SetUp();
}

TEST_F(Cooperative, ThreadsOfABlockMayWaitByReading) {
    CUfunction pair = nullptr;
    ASSERT_EQ(cuModuleGetFunction(&pair, module, "pair"), CUDA_SUCCESS);
    void* params[] = {&out};
    ASSERT_EQ(cuLaunchKernel(pair, 1, 1, 1, 2, 1, 1, 0, nullptr, params, nullptr), CUDA_SUCCESS);
    EXPECT_EQ(cuCtxSynchronize(), CUDA_SUCCESS);
}

// The early end of a thread does not affect other threads, at any place in the block.
TEST_F(Cooperative, ThreadsThatExitLeaveTheOthers) {
    CUfunction leave = nullptr;
    ASSERT_EQ(cuModuleGetFunction(&leave, module, "leave"), CUDA_SUCCESS);
    void* params[] = {&out};
    ASSERT_EQ(cuLaunchKernel(leave, 3, 1, 1, 8, 4, 2, 0, nullptr, params, nullptr), CUDA_SUCCESS);
    ASSERT_EQ(cuCtxSynchronize(), CUDA_SUCCESS);
    unsigned stayed = 0;
    ASSERT_EQ(cuMemcpyDtoH(&stayed, out, 4), CUDA_SUCCESS);
    EXPECT_EQ(stayed, 3u * 5 * 4 * 2); // x = 0, 2, 4 leave
}

TEST_F(Cooperative, ExtendedLaunchesReadTheirAttributes) {
    unsigned count = 3;
    void* params[] = {&out, &count};
    CUlaunchAttribute attribute = {};
    CUlaunchConfig config = {};
    config.gridDimX = std::min(most, 4u);
    config.gridDimY = config.gridDimZ = config.blockDimY = config.blockDimZ = 1;
    config.blockDimX = 64;
    config.attrs = &attribute;
    config.numAttrs = 1;
    attribute.id = CU_LAUNCH_ATTRIBUTE_COOPERATIVE;
    attribute.value.cooperative = 1;
    EXPECT_EQ(cuLaunchKernelEx(&config, rounds, params, nullptr), CUDA_SUCCESS);
    EXPECT_EQ(cuCtxSynchronize(), CUDA_SUCCESS);
    config.gridDimX = most + 1;
    EXPECT_EQ(cuLaunchKernelEx(&config, rounds, params, nullptr),
              CUDA_ERROR_COOPERATIVE_LAUNCH_TOO_LARGE);

    CUfunction pair = nullptr;
    ASSERT_EQ(cuModuleGetFunction(&pair, module, "pair"), CUDA_SUCCESS);
    config.gridDimX = 1;
    config.blockDimX = 2;
    const auto tryAttribute = [&](unsigned id) {
        attribute.id = id;
        return cuLaunchKernelEx(&config, pair, params, nullptr);
    };
    attribute.value.clusterDim = {1, 1, 1};
    EXPECT_EQ(tryAttribute(CU_LAUNCH_ATTRIBUTE_CLUSTER_DIMENSION), CUDA_SUCCESS);
    attribute.value.clusterDim = {2, 1, 1};
    EXPECT_EQ(tryAttribute(CU_LAUNCH_ATTRIBUTE_CLUSTER_DIMENSION), CUDA_ERROR_NOT_SUPPORTED);
    attribute.value.clusterDim = {0, 1, 1};
    EXPECT_EQ(tryAttribute(CU_LAUNCH_ATTRIBUTE_CLUSTER_DIMENSION), CUDA_ERROR_INVALID_VALUE);
    EXPECT_EQ(tryAttribute(CU_LAUNCH_ATTRIBUTE_PRIORITY), CUDA_SUCCESS);
    EXPECT_EQ(tryAttribute(CU_LAUNCH_ATTRIBUTE_PROGRAMMATIC_EVENT), CUDA_ERROR_NOT_SUPPORTED);
    EXPECT_EQ(tryAttribute(99), CUDA_ERROR_NOT_SUPPORTED);
    config.attrs = nullptr;
    EXPECT_EQ(cuLaunchKernelEx(&config, pair, params, nullptr), CUDA_ERROR_INVALID_VALUE);
    EXPECT_EQ(cuLaunchKernelEx(nullptr, pair, params, nullptr), CUDA_ERROR_INVALID_VALUE);
    EXPECT_EQ(cuCtxSynchronize(), CUDA_SUCCESS);
}

} // namespace
