// SPDX-License-Identifier: Apache-2.0
// The floating-point mode of a thread does not reach the kernels that it launches: they round to
// nearest and keep subnormal numbers, and a division by zero is no fault.
#include <cuda.h>
#include <gtest/gtest.h>

#include <cfenv>
#include <vector>
#include <xmmintrin.h>

namespace {

constexpr unsigned kBlocks = 4096, kWidth = 64;

// Each thread writes half of a subnormal number, 1 / 0, and 1 + 2^-31.
constexpr const char* kText = R"(
.version 7.0
.target sm_75
.address_size 64
.visible .entry compute(.param .u64 out, .param .f32 small, .param .f32 one, .param .f32 zero) {
    .reg .u64 %rd<3>;
    .reg .u32 %r<4>;
    .reg .f32 %f<7>;
    ld.param.u64 %rd1, [out];
    ld.param.f32 %f1, [small];
    ld.param.f32 %f2, [one];
    ld.param.f32 %f3, [zero];
    mov.u32 %r1, %ctaid.x;
    mov.u32 %r2, %tid.x;
    mad.lo.u32 %r3, %r1, 64, %r2;
    mul.wide.u32 %rd2, %r3, 12;
    add.u64 %rd1, %rd1, %rd2;
    mul.f32 %f4, %f1, 0f3F000000;
    div.rn.f32 %f5, %f2, %f3;
    add.rn.f32 %f6, %f2, 0f30000000;
    st.global.f32 [%rd1], %f4;
    st.global.f32 [%rd1+4], %f5;
    st.global.f32 [%rd1+8], %f6;
    ret;
}
)";

enum class Mode { kFlush, kUpward, kTraps };

void setMode(Mode mode) {
    switch (mode) {
    case Mode::kFlush:
        _mm_setcsr(_mm_getcsr() | 0x8040);
        break;
    case Mode::kUpward:
        fesetround(FE_UPWARD);
        break;
    case Mode::kTraps:
        feenableexcept(FE_DIVBYZERO | FE_INVALID | FE_OVERFLOW);
        break;
    }
}

class FloatMode : public testing::TestWithParam<Mode> {};

TEST_P(FloatMode, DoesNotReachKernels) {
    setMode(GetParam());
    const unsigned mode = _mm_getcsr() & ~0x3Fu;
    CUcontext context;
    CUmodule module;
    CUfunction kernel;
    CUstream stream;
    CUdeviceptr memory;
    ASSERT_EQ(cuInit(0), CUDA_SUCCESS);
    ASSERT_EQ(cuDevicePrimaryCtxRetain(&context, 0), CUDA_SUCCESS);
    ASSERT_EQ(cuCtxSetCurrent(context), CUDA_SUCCESS);
    ASSERT_EQ(cuModuleLoadData(&module, kText), CUDA_SUCCESS);
    ASSERT_EQ(cuModuleGetFunction(&kernel, module, "compute"), CUDA_SUCCESS);
    ASSERT_EQ(cuStreamCreate(&stream, CU_STREAM_NON_BLOCKING), CUDA_SUCCESS);
    std::vector<unsigned> values(size_t(kBlocks) * kWidth * 3);
    ASSERT_EQ(cuMemAlloc(&memory, values.size() * 4), CUDA_SUCCESS);
    unsigned small = 0x400, one = 0x3F800000, zero = 0;
    void* arguments[] = {&memory, &small, &one, &zero};
    ASSERT_EQ(cuLaunchKernel(kernel, kBlocks, 1, 1, kWidth, 1, 1, 0, stream, arguments, nullptr),
              CUDA_SUCCESS);
    ASSERT_EQ(cuStreamSynchronize(stream), CUDA_SUCCESS);
    ASSERT_EQ(cuMemcpyDtoH(values.data(), memory, values.size() * 4), CUDA_SUCCESS);
    EXPECT_EQ(_mm_getcsr() & ~0x3Fu, mode);
    fesetenv(FE_DFL_ENV);
    for (size_t i = 0; i < values.size(); i += 3) {
        ASSERT_EQ(values[i], 0x200u) << i;
        ASSERT_EQ(values[i + 1], 0x7F800000u) << i;
        ASSERT_EQ(values[i + 2], 0x3F800000u) << i;
    }
    EXPECT_EQ(cuStreamDestroy(stream), CUDA_SUCCESS);
    EXPECT_EQ(cuMemFree(memory), CUDA_SUCCESS);
    EXPECT_EQ(cuModuleUnload(module), CUDA_SUCCESS);
    EXPECT_EQ(cuCtxSetCurrent(nullptr), CUDA_SUCCESS);
    EXPECT_EQ(cuDevicePrimaryCtxRelease(0), CUDA_SUCCESS);
}

INSTANTIATE_TEST_SUITE_P(Modes, FloatMode,
                         testing::Values(Mode::kFlush, Mode::kUpward, Mode::kTraps));

} // namespace
