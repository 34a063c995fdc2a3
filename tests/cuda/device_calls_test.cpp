// SPDX-License-Identifier: Apache-2.0
// Functions that device code calls, with bad arguments: the launch fails, and the process continues
// with all its resources. The kernels run thread by thread, with barriers on fibers.
#include <cuda.h>
#include <gtest/gtest.h>

#include <malloc.h>

#include <cstdio>
#include <string>
#include <vector>

namespace {

constexpr const char* kHead = R"(
.version 7.0
.target sm_75
.address_size 64
.extern .func (.param .b32 result) vprintf(.param .b64 format, .param .b64 values);
.extern .func (.param .b64 block) malloc(.param .b64 size);
.extern .func free(.param .b64 block);
.visible .entry kernel(.param .u64 first, .param .u64 second) {
    .local .align 8 .b8 values[8];
    .reg .u64 %rd<8>;
    .reg .u32 %r<3>;
    .reg .pred %p<2>;
    ld.param.u64 %rd1, [first];
    ld.param.u64 %rd2, [second];
    mov.u32 %r1, %tid.x;
)";

// Calls of the kernel's first thread.
const std::string kFree = "{ .param .b64 p0; st.param.b64 [p0], %rd3; call.uni free, (p0); }\n";
const std::string kMalloc = "{ .param .b64 p0; .param .b64 out; st.param.b64 [p0], 40;"
                            "call.uni (out), malloc, (p0); ld.param.b64 %rd3, [out]; }\n";
const std::string kPrint =
    "mov.u64 %rd4, values; cvta.local.u64 %rd5, %rd4; st.local.u64 [%rd4], %rd2;"
    "{ .param .b64 p0; .param .b64 p1; .param .b32 out; st.param.b64 [p0], %rd1;"
    "st.param.b64 [p1], %rd5; call.uni (out), vprintf, (p0, p1); }\n";
const std::string kMeet = "bar.sync 0;\n";

bool isSanitized() {
#if defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
    return true;
#endif
#endif
    return false;
}

class DeviceCalls : public testing::Test {
protected:
    void SetUp() override { ASSERT_EQ(cuInit(0), CUDA_SUCCESS); }

    // The outcome of a launch of 64 threads, of which the first runs the body, in a context of its
    // own.
    static CUresult run(const std::string& body, uint64_t first = 0, uint64_t second = 0,
                        bool meets = false) {
        CUcontext context = nullptr;
        CUmodule module = nullptr;
        CUfunction kernel = nullptr;
        EXPECT_EQ(cuCtxCreate_v2(&context, 0, 0), CUDA_SUCCESS);
        const std::string text = kHead + std::string("setp.ne.u32 %p1, %r1, 0;\n@%p1 bra end;\n") +
                                 body + "end:\n" + (meets ? kMeet : "") + "ret;\n}\n";
        EXPECT_EQ(cuModuleLoadData(&module, text.c_str()), CUDA_SUCCESS);
        EXPECT_EQ(cuModuleGetFunction(&kernel, module, "kernel"), CUDA_SUCCESS);
        void* params[] = {&first, &second};
        EXPECT_EQ(cuLaunchKernel(kernel, 1, 1, 1, 64, 1, 1, 0, nullptr, params, nullptr),
                  CUDA_SUCCESS);
        const CUresult result = cuCtxSynchronize();
        EXPECT_EQ(cuCtxDestroy(context), CUDA_SUCCESS);
        return result;
    }
};

TEST_F(DeviceCalls, FreeOfABlock) {
    for (const bool meets : {false, true})
        EXPECT_EQ(run(kMalloc + "st.u64 [%rd3], 5; st.u64 [%rd3+32], 5;\n" + kFree, 0, 0, meets),
                  CUDA_SUCCESS);
    EXPECT_EQ(run("mov.u64 %rd3, 0;\n" + kFree), CUDA_SUCCESS) << "null";
}

TEST_F(DeviceCalls, FreeOfWhatIsNoBlock) {
    const std::vector<uint64_t> memory(64, 7);
    const auto inside = reinterpret_cast<uint64_t>(&memory[32]);
    for (const bool meets : {false, true}) {
        EXPECT_EQ(run("mov.u64 %rd3, %rd1;\n" + kFree, inside, 0, meets), CUDA_ERROR_LAUNCH_FAILED);
        EXPECT_EQ(run("mov.u64 %rd3, %rd1;\n" + kFree, inside + 1, 0, meets),
                  CUDA_ERROR_LAUNCH_FAILED);
        uint64_t block = 0;
        EXPECT_EQ(run(kMalloc + "st.u64 [%rd2], %rd3; add.u64 %rd3, %rd3, 16;\n" + kFree, 0,
                      reinterpret_cast<uint64_t>(&block), meets),
                  CUDA_ERROR_LAUNCH_FAILED);
        EXPECT_EQ(run("mov.u64 %rd3, %rd1;\n" + kFree, block, 0, meets), CUDA_SUCCESS)
            << "it is still a block";
        EXPECT_EQ(run(kMalloc + kFree + kFree, 0, 0, meets), CUDA_ERROR_LAUNCH_FAILED) << "twice";
        if (!isSanitized()) {
            EXPECT_EQ(run("mov.u64 %rd3, 0x123450;\n" + kFree, 0, 0, meets),
                      CUDA_ERROR_ILLEGAL_ADDRESS);
        }
    }
}

TEST_F(DeviceCalls, BadStringsToPrintLeaveNothingBehind) {
    if (isSanitized())
        GTEST_SKIP() << "a sanitizer reports faults";
    constexpr size_t kLength = 1 << 20, kRounds = 16;
    const std::string format = std::string(kLength, 'x') + "%s\n";
    const auto inUse = [] {
        const struct mallinfo2 info = mallinfo2();
        return info.uordblks + info.hblkhd;
    };
    const auto fail = [&](bool meets) {
        EXPECT_EQ(run(kPrint, reinterpret_cast<uint64_t>(format.c_str()), 0x123450, meets),
                  CUDA_ERROR_ILLEGAL_ADDRESS);
    };
    fail(false);
    fail(true);
    const size_t before = inUse();
    for (size_t i = 0; i < kRounds; ++i)
        fail(i % 2);
    EXPECT_LT(inUse(), before + kRounds * kLength / 2);
}

TEST_F(DeviceCalls, LongTextsArePrintedWhole) {
    const std::string text(3000, 'y');
    testing::internal::CaptureStdout();
    EXPECT_EQ(run(kPrint, reinterpret_cast<uint64_t>("<%s>%% %q\n"),
                  reinterpret_cast<uint64_t>(text.c_str())),
              CUDA_SUCCESS);
    std::fflush(stdout);
    EXPECT_EQ(testing::internal::GetCapturedStdout(), "<" + text + ">% %q\n");
}

} // namespace
