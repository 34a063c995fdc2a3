// SPDX-License-Identifier: Apache-2.0
// Modules and launches through the driver API: PTX text, fat binaries, damaged images, bad
// launches, and the cost of a launch.
#include <cuda.h>
#include <gtest/gtest.h>

#include <sys/mman.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>
#include <thread>
#include <vector>

namespace {

// Before the library reads it: a test checks the log.
[[maybe_unused]] const int kLogged = setenv("SUNSTONE_LOG", "cuda:warning", 1);

const char* const kText = R"(.version 7.0
.target sm_60
.address_size 64
.visible .global .align 4 .u32 total = 3;
.visible .entry fill(.param .u64 out, .param .u32 value)
{
    .reg .b32 %r<6>;
    .reg .b64 %rd<4>;
    ld.param.u64 %rd1, [out];
    ld.param.u32 %r1, [value];
    mov.u32 %r2, %ctaid.x;
    mov.u32 %r3, %ntid.x;
    mov.u32 %r4, %tid.x;
    mad.lo.s32 %r5, %r2, %r3, %r4;
    mul.wide.u32 %rd2, %r5, 4;
    add.s64 %rd3, %rd1, %rd2;
    add.s32 %r1, %r1, %r5;
    st.global.u32 [%rd3], %r1;
    ret;
}
.visible .entry nothing()
{
    ret;
}
)";

class Launch : public testing::Test {
protected:
    void SetUp() override {
        ASSERT_EQ(cuInit(0), CUDA_SUCCESS);
        enter();
    }
    void TearDown() override {
        EXPECT_EQ(cuCtxSetCurrent(nullptr), CUDA_SUCCESS);
        EXPECT_EQ(cuDevicePrimaryCtxRelease(0), CUDA_SUCCESS);
    }
    void enter() {
        ASSERT_EQ(cuDevicePrimaryCtxRetain(&context, 0), CUDA_SUCCESS);
        ASSERT_EQ(cuCtxSetCurrent(context), CUDA_SUCCESS);
    }
    // A program's recovery after device code has failed.
    void reset() {
        ASSERT_EQ(cuCtxSetCurrent(nullptr), CUDA_SUCCESS);
        ASSERT_EQ(cuDevicePrimaryCtxReset(0), CUDA_SUCCESS);
        enter();
    }
    CUfunction load(const std::string& text, const char* kernel) {
        CUmodule module = nullptr;
        CUfunction function = nullptr;
        EXPECT_EQ(cuModuleLoadData(&module, text.c_str()), CUDA_SUCCESS);
        EXPECT_EQ(cuModuleGetFunction(&function, module, kernel), CUDA_SUCCESS);
        return function;
    }
    // Launches `fill` and checks its output.
    void expectFills(CUmodule module) {
        CUfunction fill = nullptr;
        ASSERT_EQ(cuModuleGetFunction(&fill, module, "fill"), CUDA_SUCCESS);
        CUdeviceptr out = 0;
        ASSERT_EQ(cuMemAlloc(&out, 400 * 4), CUDA_SUCCESS);
        unsigned value = 5;
        void* params[] = {&out, &value};
        EXPECT_EQ(cuLaunchKernel(fill, 4, 1, 1, 100, 1, 1, 0, nullptr, params, nullptr),
                  CUDA_SUCCESS);
        std::vector<unsigned> host(400);
        EXPECT_EQ(cuMemcpyDtoH(host.data(), out, 1600), CUDA_SUCCESS);
        for (unsigned i = 0; i < 400; ++i)
            ASSERT_EQ(host[i], 5 + i);
        EXPECT_EQ(cuMemFree(out), CUDA_SUCCESS);
    }
    CUcontext context = nullptr;
};

// A fat binary with the text uncompressed.
std::vector<char> container(const std::string& text) {
    std::vector<char> bytes(16 + 64 + (text.size() + 8) / 8 * 8);
    auto put = [&](size_t at, auto value) { std::memcpy(&bytes[at], &value, sizeof value); };
    put(0, uint32_t(0xBA55ED50));
    put(4, uint16_t(1));
    put(6, uint16_t(16));
    put(8, uint64_t(bytes.size() - 16));
    put(16, uint16_t(1));
    put(18, uint16_t(0x0101));
    put(20, uint32_t(64));
    put(24, uint64_t(bytes.size() - 80));
    put(44, uint32_t(60));
    std::memcpy(&bytes[80], text.data(), text.size());
    return bytes;
}

// Work belongs to the context of its stream, whichever context is current.
TEST_F(Launch, NamesStayInPlaceWhenAKernelIsCompiled) {
    const std::string name = "a_name_that_a_string_keeps_in_memory_of_its_own";
    const CUfunction function = load(
        ".version 7.0\n.target sm_60\n.address_size 64\n.visible .entry " + name + "() { ret; }",
        name.c_str());
    const char *before = nullptr, *after = nullptr;
    ASSERT_EQ(cuFuncGetName(&before, function), CUDA_SUCCESS);
    ASSERT_EQ(cuLaunchKernel(function, 1, 1, 1, 1, 1, 1, 0, nullptr, nullptr, nullptr),
              CUDA_SUCCESS);
    ASSERT_EQ(cuCtxSynchronize(), CUDA_SUCCESS);
    ASSERT_EQ(cuFuncGetName(&after, function), CUDA_SUCCESS);
    EXPECT_EQ(before, after);
    EXPECT_STREQ(after, name.c_str());
}

TEST_F(Launch, StreamsBringTheirContext) {
    constexpr char kTrap[] = ".version 7.0\n.target sm_60\n.address_size 64\n"
                             ".visible .entry fail() { trap; ret; }\n";
    for (const bool isNone : {true, false}) {
        CUcontext home = nullptr;
        CUstream stream = nullptr;
        CUmodule module = nullptr;
        CUfunction function = nullptr;
        ASSERT_EQ(cuCtxCreate_v2(&home, 0, 0), CUDA_SUCCESS);
        ASSERT_EQ(cuStreamCreate(&stream, CU_STREAM_NON_BLOCKING), CUDA_SUCCESS);
        ASSERT_EQ(cuModuleLoadData(&module, kTrap), CUDA_SUCCESS);
        ASSERT_EQ(cuModuleGetFunction(&function, module, "fail"), CUDA_SUCCESS);
        CUcontext current = nullptr;
        ASSERT_EQ(cuCtxPopCurrent(&current), CUDA_SUCCESS);
        ASSERT_EQ(cuCtxSetCurrent(isNone ? nullptr : context), CUDA_SUCCESS);
        EXPECT_EQ(cuLaunchKernel(function, 1, 1, 1, 1, 1, 1, 0, stream, nullptr, nullptr),
                  CUDA_SUCCESS);
        EXPECT_EQ(cuStreamSynchronize(stream), CUDA_ERROR_LAUNCH_FAILED);
        EXPECT_EQ(cuStreamQuery(stream), CUDA_ERROR_LAUNCH_FAILED) << "for ever";
        EXPECT_EQ(cuCtxGetCurrent(&current), CUDA_SUCCESS);
        EXPECT_EQ(current, isNone ? nullptr : context);
        EXPECT_EQ(cuCtxSetCurrent(context), CUDA_SUCCESS);
        EXPECT_EQ(cuCtxSynchronize(), CUDA_SUCCESS) << "another context";
        EXPECT_EQ(cuCtxDestroy(home), CUDA_SUCCESS);
    }
}

TEST_F(Launch, TextRuns) {
    CUmodule module = nullptr;
    ASSERT_EQ(cuModuleLoadData(&module, kText), CUDA_SUCCESS);
    expectFills(module);
    CUdeviceptr total = 0;
    size_t size = 0;
    EXPECT_EQ(cuModuleGetGlobal(&total, &size, module, "total"), CUDA_SUCCESS);
    EXPECT_EQ(size, 4u);
    unsigned value = 0;
    EXPECT_EQ(cuMemcpyDtoH(&value, total, 4), CUDA_SUCCESS);
    EXPECT_EQ(value, 3u);
    EXPECT_EQ(cuModuleGetGlobal(&total, &size, module, "none"), CUDA_ERROR_NOT_FOUND);
    CUfunction function = nullptr;
    EXPECT_EQ(cuModuleGetFunction(&function, module, "none"), CUDA_ERROR_NOT_FOUND);
    EXPECT_EQ(cuModuleGetFunction(nullptr, module, "fill"), CUDA_ERROR_INVALID_VALUE);
    EXPECT_EQ(cuModuleGetFunction(&function, module, "fill"), CUDA_SUCCESS);
    EXPECT_EQ(cuModuleUnload(module), CUDA_SUCCESS);
    EXPECT_EQ(cuModuleUnload(module), CUDA_ERROR_INVALID_HANDLE);
    EXPECT_EQ(cuLaunchKernel(function, 1, 1, 1, 1, 1, 1, 0, nullptr, nullptr, nullptr),
              CUDA_ERROR_INVALID_HANDLE);
}

// Writes to unmapped memory, by a single thread and by threads that have met at a barrier, return
// an illegal address; the process and the next launch continue.
TEST_F(Launch, WildAddressesAreErrors) {
#if defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
    GTEST_SKIP() << "a sanitizer reports faults";
#endif
#endif
    std::string met = kText;
    met.insert(met.find("    st.global"), "    bar.sync 0;\n");
    for (const std::string& text : {std::string(kText), met}) {
        for (CUdeviceptr out : {CUdeviceptr(0), CUdeviceptr(0xdead000000000000)}) {
            for (const unsigned blocks : {1u, 300u}) {
                CUfunction fill = load(text, "fill");
                unsigned value = 5;
                void* params[] = {&out, &value};
                testing::internal::CaptureStderr();
                CUresult result =
                    cuLaunchKernel(fill, blocks, 1, 1, 100, 1, 1, 0, nullptr, params, nullptr);
                if (result == CUDA_SUCCESS)
                    result = cuCtxSynchronize();
                EXPECT_EQ(result, CUDA_ERROR_ILLEGAL_ADDRESS);
                const std::string log = testing::internal::GetCapturedStderr();
                EXPECT_NE(std::string::npos, log.find("kernel fill: invalid memory access")) << log;
                if (out != 0)
                    EXPECT_NE(std::string::npos, log.find("to address 0xdead00000000")) << log;
                // A warp runs together.
                const char* const first = "block (0, 0, 0), thread (0, 0, 0) to (31, 0, 0)";
                if (blocks == 1)
                    EXPECT_NE(std::string::npos, log.find(first)) << log;
                reset();
            }
        }
        CUmodule module = nullptr;
        ASSERT_EQ(cuModuleLoadData(&module, text.c_str()), CUDA_SUCCESS);
        expectFills(module);
        EXPECT_EQ(cuModuleUnload(module), CUDA_SUCCESS);
    }
}

const char* const kFaults = R"(.version 7.0
.target sm_60
.address_size 64
.visible .entry stop()
{
    trap;
}
.visible .entry mark(.param .u64 out)
{
    .reg .b64 %rd<2>;
    ld.param.u64 %rd1, [out];
    st.global.u32 [%rd1], 1;
    ret;
}
)";

// The log of a trap has the block, the thread and the line.
TEST_F(Launch, TrapsNameTheirPlace) {
#if defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
    GTEST_SKIP() << "a sanitizer reports faults";
#endif
#endif
    const std::string start = ".version 7.0\n.target sm_60\n.address_size 64\n"
                              ".file 1 \"/src/stop.cu\"\n.visible .entry stop()\n{\n"
                              ".reg .pred %p<2>;\n.reg .b32 %r<3>;\n.loc 1 30 1\n"
                              "mov.u32 %r1, %ctaid.x;\nsetp.ne.u32 %p1, %r1, 3;\n@%p1 ret;\n";
    for (const char* barrier : {"", "bar.sync 0;\n"}) { // alone, and with the threads of the block
        CUfunction stop = load(start + barrier + ".loc 1 42 5\ntrap;\n}\n", "stop");
        testing::internal::CaptureStderr();
        CUresult result = cuLaunchKernel(stop, 5, 1, 1, 32, 1, 1, 0, nullptr, nullptr, nullptr);
        if (result == CUDA_SUCCESS)
            result = cuCtxSynchronize();
        EXPECT_EQ(result, CUDA_ERROR_LAUNCH_FAILED);
        const std::string log = testing::internal::GetCapturedStderr();
        EXPECT_NE(std::string::npos, log.find("kernel stop: executed a trap")) << log;
        EXPECT_NE(std::string::npos, log.find("in block (3, 0, 0), thread (0, 0, 0)")) << log;
        EXPECT_NE(std::string::npos, log.find("/src/stop.cu:42")) << log;
        reset();
    }
}

// The context keeps a failure: every call that needs the context returns the same code, on any
// stream and thread; later queued work does not run; a reset restores the context.
TEST_F(Launch, FailuresStayWithTheContext) {
    CUdeviceptr out = 0;
    ASSERT_EQ(cuMemAlloc(&out, 64), CUDA_SUCCESS);
    unsigned* seen = nullptr;
    ASSERT_EQ(cuMemAllocHost(reinterpret_cast<void**>(&seen), 4), CUDA_SUCCESS);
    *seen = 0;
    CUstream stream = nullptr;
    ASSERT_EQ(cuStreamCreate(&stream, CU_STREAM_NON_BLOCKING), CUDA_SUCCESS);
    CUevent event = nullptr;
    ASSERT_EQ(cuEventCreate(&event, 0), CUDA_SUCCESS);
    CUfunction stop = load(kFaults, "stop"), mark = load(kFaults, "mark");
    void* params[] = {&seen};
    EXPECT_EQ(cuLaunchKernel(stop, 1, 1, 1, 1, 1, 1, 0, stream, nullptr, nullptr), CUDA_SUCCESS);
    const CUresult behind = cuLaunchKernel(mark, 1, 1, 1, 1, 1, 1, 0, stream, params, nullptr);
    EXPECT_TRUE(behind == CUDA_SUCCESS || behind == CUDA_ERROR_LAUNCH_FAILED) << behind;
    EXPECT_EQ(cuStreamSynchronize(stream), CUDA_ERROR_LAUNCH_FAILED);
    EXPECT_EQ(*seen, 0u);
    CUdeviceptr more = 0;
    unsigned value = 0;
    for (int round = 0; round < 2; ++round) {
        EXPECT_EQ(cuCtxSynchronize(), CUDA_ERROR_LAUNCH_FAILED);
        EXPECT_EQ(cuStreamSynchronize(nullptr), CUDA_ERROR_LAUNCH_FAILED);
        EXPECT_EQ(cuStreamQuery(stream), CUDA_ERROR_LAUNCH_FAILED);
        EXPECT_EQ(cuEventRecord(event, stream), CUDA_ERROR_LAUNCH_FAILED);
        EXPECT_EQ(cuEventQuery(event), CUDA_ERROR_LAUNCH_FAILED);
        EXPECT_EQ(cuEventSynchronize(event), CUDA_ERROR_LAUNCH_FAILED);
        EXPECT_EQ(cuMemAlloc(&more, 4), CUDA_ERROR_LAUNCH_FAILED);
        EXPECT_EQ(cuMemcpyDtoH(&value, out, 4), CUDA_ERROR_LAUNCH_FAILED);
        EXPECT_EQ(cuMemFree(out), CUDA_ERROR_LAUNCH_FAILED);
        EXPECT_EQ(cuLaunchKernel(mark, 1, 1, 1, 1, 1, 1, 0, nullptr, params, nullptr),
                  CUDA_ERROR_LAUNCH_FAILED);
    }
    size_t limit = 0;
    int least = 0, greatest = 0;
    EXPECT_EQ(cuCtxGetLimit(&limit, CU_LIMIT_STACK_SIZE), CUDA_ERROR_LAUNCH_FAILED);
    EXPECT_EQ(cuCtxGetStreamPriorityRange(&least, &greatest), CUDA_ERROR_LAUNCH_FAILED);
    CUdevice device = -1;
    EXPECT_EQ(cuCtxGetDevice(&device), CUDA_SUCCESS) << "asks nothing of the device";
    std::thread([&] {
        EXPECT_EQ(cuCtxSetCurrent(context), CUDA_SUCCESS);
        EXPECT_EQ(cuCtxSynchronize(), CUDA_ERROR_LAUNCH_FAILED);
    }).join();

    // Another context works.
    CUcontext other = nullptr;
    ASSERT_EQ(cuCtxCreate(&other, nullptr, 0, 0), CUDA_SUCCESS);
    EXPECT_EQ(cuMemAlloc(&more, 4), CUDA_SUCCESS);
    EXPECT_EQ(cuMemFree(more), CUDA_SUCCESS);
    EXPECT_EQ(cuCtxDestroy(other), CUDA_SUCCESS);

    reset();
    EXPECT_EQ(cuMemFree(out), CUDA_ERROR_INVALID_VALUE) << "went with its context";
    EXPECT_EQ(cuStreamSynchronize(stream), CUDA_ERROR_INVALID_HANDLE);
    EXPECT_EQ(cuLaunchKernel(mark, 1, 1, 1, 1, 1, 1, 0, nullptr, params, nullptr),
              CUDA_ERROR_INVALID_HANDLE);
    EXPECT_EQ(cuStreamSynchronize(nullptr), CUDA_SUCCESS);
    mark = load(kFaults, "mark");
    ASSERT_EQ(cuMemAlloc(&out, 64), CUDA_SUCCESS);
    void* again[] = {&out};
    EXPECT_EQ(cuLaunchKernel(mark, 1, 1, 1, 1, 1, 1, 0, nullptr, again, nullptr), CUDA_SUCCESS);
    EXPECT_EQ(cuMemcpyDtoH(&value, out, 4), CUDA_SUCCESS);
    EXPECT_EQ(value, 1u);
    EXPECT_EQ(cuMemFree(out), CUDA_SUCCESS);
}

// Copies and frees beyond allocations.
TEST_F(Launch, BadMemoryCalls) {
    CUdeviceptr a = 0, b = 0;
    ASSERT_EQ(cuMemAlloc(&a, 100), CUDA_SUCCESS);
    ASSERT_EQ(cuMemAlloc(&b, 100), CUDA_SUCCESS);
    char host[256] = {};
    EXPECT_EQ(cuMemcpyHtoD(a, host, 101), CUDA_ERROR_INVALID_VALUE);
    EXPECT_EQ(cuMemcpyHtoD(a + 1, host, 100), CUDA_ERROR_INVALID_VALUE);
    EXPECT_EQ(cuMemcpyDtoH(host, a, 101), CUDA_ERROR_INVALID_VALUE);
    EXPECT_EQ(cuMemcpyDtoD(b, a, 101), CUDA_ERROR_INVALID_VALUE);
    EXPECT_EQ(cuMemcpyDtoD(b, 0, 4), CUDA_ERROR_INVALID_VALUE);
    EXPECT_EQ(cuMemsetD8(a, 0, 101), CUDA_ERROR_INVALID_VALUE);
    EXPECT_EQ(cuMemsetD32(a, 0, 26), CUDA_ERROR_INVALID_VALUE);
    EXPECT_EQ(cuMemcpyHtoD(a, host, SIZE_MAX), CUDA_ERROR_INVALID_VALUE);
    EXPECT_EQ(cuMemFree(a + 4), CUDA_ERROR_INVALID_VALUE);
    EXPECT_EQ(cuMemFree(a), CUDA_SUCCESS);
    EXPECT_EQ(cuMemFree(a), CUDA_ERROR_INVALID_VALUE) << "freed twice";
    EXPECT_EQ(cuMemcpyDtoH(host, a, 4), CUDA_ERROR_INVALID_VALUE) << "used after it was freed";
    EXPECT_EQ(cuMemFreeHost(host), CUDA_ERROR_INVALID_VALUE);
    EXPECT_EQ(cuMemFree(0), CUDA_SUCCESS) << "as documented";
    EXPECT_EQ(cuMemAlloc(&a, 0), CUDA_ERROR_INVALID_VALUE);
    EXPECT_EQ(cuMemAlloc(&a, size_t(1) << 50), CUDA_ERROR_OUT_OF_MEMORY);
    EXPECT_EQ(cuMemFree(b), CUDA_SUCCESS) << "none of this is sticky";
}

// Texts cut at any place: an error, or a module with the remaining contents.
TEST_F(Launch, CutTexts) {
    const std::string text = kText;
    for (size_t length = 0; length < text.size(); length += 7) {
        CUmodule module = nullptr;
        const std::string cut = text.substr(0, length);
        const CUresult result = cuModuleLoadData(&module, cut.c_str());
        EXPECT_TRUE(result == CUDA_SUCCESS || result == CUDA_ERROR_INVALID_PTX ||
                    result == CUDA_ERROR_INVALID_IMAGE || result == CUDA_ERROR_NO_BINARY_FOR_GPU)
            << result << " at " << length;
        if (result == CUDA_SUCCESS)
            EXPECT_EQ(cuModuleUnload(module), CUDA_SUCCESS);
    }
}

TEST_F(Launch, FatBinaryRunsAndDamageIsFound) {
    const std::vector<char> good = container(kText);
    CUmodule module = nullptr;
    ASSERT_EQ(cuModuleLoadData(&module, good.data()), CUDA_SUCCESS);
    expectFills(module);
    EXPECT_EQ(cuModuleUnload(module), CUDA_SUCCESS);
    // Any byte of the headers changed: an error or a module, never a crash. The call takes no size,
    // so a larger size in a header is accepted; zeros follow the container here.
    for (size_t at = 0; at < 80; ++at) {
        for (unsigned char flip : {0x01, 0x80, 0xff}) {
            std::vector<char> bad = good;
            bad.resize(good.size() + (size_t(1) << 20));
            bad[at] = char(bad[at] ^ flip);
            if (cuModuleLoadData(&module, bad.data()) == CUDA_SUCCESS)
                EXPECT_EQ(cuModuleUnload(module), CUDA_SUCCESS);
        }
    }
    EXPECT_EQ(cuModuleLoadData(&module, nullptr), CUDA_ERROR_INVALID_VALUE);
    EXPECT_EQ(cuModuleLoadData(&module, reinterpret_cast<void*>(8)), CUDA_ERROR_INVALID_VALUE);
    EXPECT_EQ(cuModuleLoadData(&module, "\x7f"
                                        "ELF...."),
              CUDA_ERROR_NO_BINARY_FOR_GPU);
    EXPECT_EQ(cuModuleLoad(&module, "/no/such/file"), CUDA_ERROR_FILE_NOT_FOUND);
}

// Images have no size, so reading stops before mapped but unreadable memory, which allocators
// create.
TEST_F(Launch, ImagesThatEndWhereMemoryDoes) {
    constexpr size_t kPart = 1 << 16;
    void* const area =
        mmap(nullptr, 2 * kPart, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    ASSERT_NE(area, MAP_FAILED);
    char* const end = static_cast<char*>(area) + kPart;
    ASSERT_EQ(mprotect(end, kPart, PROT_NONE), 0);
    const std::vector<char> whole = container(kText);
    CUmodule module = nullptr;
    const auto load = [&](const char* bytes, size_t size) {
        std::memcpy(end - size, bytes, size);
        return cuModuleLoadData(&module, end - size);
    };
    ASSERT_EQ(load(whole.data(), whole.size()), CUDA_SUCCESS);
    expectFills(module);
    EXPECT_EQ(cuModuleUnload(module), CUDA_SUCCESS);
    for (const size_t size :
         {whole.size() - 1, size_t(81), size_t(80), size_t(79), size_t(17), size_t(15)})
        EXPECT_EQ(load(whole.data(), size), CUDA_ERROR_INVALID_IMAGE) << size;
    EXPECT_EQ(load(kText, std::strlen(kText)), CUDA_ERROR_INVALID_IMAGE) << "has no end";
    EXPECT_EQ(cuModuleLoadData(&module, end), CUDA_ERROR_INVALID_VALUE);
    EXPECT_EQ(munmap(area, 2 * kPart), 0);
}

// Memory beyond a gap does not belong to the image, even if a size in a header extends there.
TEST_F(Launch, ImagesEndAtGaps) {
    constexpr size_t kPart = 1 << 16;
    void* const area =
        mmap(nullptr, 3 * kPart, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    ASSERT_NE(area, MAP_FAILED);
    char* const end = static_cast<char*>(area) + kPart;
    const std::vector<char> whole = container(kText);
    constexpr size_t kHeaders = 80;
    char* const image = end - kHeaders;
    std::memcpy(image, whole.data(), kHeaders);
    std::memcpy(end + kPart, whole.data() + kHeaders, whole.size() - kHeaders);
    const auto size = uint64_t(whole.size() - 16 + kPart);
    const auto header = uint32_t(64 + kPart);
    std::memcpy(image + 8, &size, sizeof size);
    std::memcpy(image + 20, &header, sizeof header);
    CUmodule module = nullptr;
    ASSERT_EQ(cuModuleLoadData(&module, image), CUDA_SUCCESS) << "while there is no gap";
    EXPECT_EQ(cuModuleUnload(module), CUDA_SUCCESS);
    ASSERT_EQ(mprotect(end, kPart, PROT_NONE), 0);
    EXPECT_EQ(cuModuleLoadData(&module, image), CUDA_ERROR_INVALID_IMAGE);
    EXPECT_EQ(munmap(area, 3 * kPart), 0);
}

TEST_F(Launch, BadTextFillsTheLog) {
    char log[256] = "";
    CUjit_option options[] = {CU_JIT_ERROR_LOG_BUFFER, CU_JIT_ERROR_LOG_BUFFER_SIZE_BYTES};
    void* values[] = {log, reinterpret_cast<void*>(sizeof log)};
    CUmodule module = nullptr;
    EXPECT_EQ(cuModuleLoadDataEx(&module, "nonsense", 2, options, values), CUDA_ERROR_INVALID_PTX);
    EXPECT_GT(size_t(values[1]), 1u);
    EXPECT_NE(std::strstr(log, "line"), nullptr) << log;
    EXPECT_EQ(cuModuleLoadDataEx(&module, kText, 2, nullptr, nullptr), CUDA_ERROR_INVALID_VALUE);
}

TEST_F(Launch, BadLaunches) {
    CUmodule module = nullptr;
    CUfunction fill = nullptr;
    ASSERT_EQ(cuModuleLoadData(&module, kText), CUDA_SUCCESS);
    ASSERT_EQ(cuModuleGetFunction(&fill, module, "fill"), CUDA_SUCCESS);
    CUdeviceptr out = 0;
    ASSERT_EQ(cuMemAlloc(&out, 4096), CUDA_SUCCESS);
    unsigned value = 1;
    void* params[] = {&out, &value};
    auto launch = [&](unsigned grid, unsigned block, unsigned shared, void** p, void** extra) {
        return cuLaunchKernel(fill, grid, 1, 1, block, 1, 1, shared, nullptr, p, extra);
    };
    EXPECT_EQ(launch(0, 1, 0, params, nullptr), CUDA_ERROR_INVALID_VALUE);
    EXPECT_EQ(launch(1, 0, 0, params, nullptr), CUDA_ERROR_INVALID_VALUE);
    EXPECT_EQ(launch(1, 1025, 0, params, nullptr), CUDA_ERROR_INVALID_VALUE);
    EXPECT_EQ(launch(1, 1, 1 << 20, params, nullptr), CUDA_ERROR_INVALID_VALUE);
    EXPECT_EQ(launch(1, 1, 0, nullptr, nullptr), CUDA_ERROR_INVALID_VALUE);
    void* holes[] = {&out, nullptr};
    EXPECT_EQ(launch(1, 1, 0, holes, nullptr), CUDA_ERROR_INVALID_VALUE);
    EXPECT_EQ(cuLaunchKernel(nullptr, 1, 1, 1, 1, 1, 1, 0, nullptr, params, nullptr),
              CUDA_ERROR_INVALID_HANDLE);
    struct {
        CUdeviceptr out;
        unsigned value;
    } block = {out, 41};
    size_t size = 12;
    void* extra[] = {CU_LAUNCH_PARAM_BUFFER_POINTER, &block, CU_LAUNCH_PARAM_BUFFER_SIZE, &size,
                     CU_LAUNCH_PARAM_END};
    EXPECT_EQ(launch(1, 2, 0, params, extra), CUDA_ERROR_INVALID_VALUE);
    EXPECT_EQ(launch(1, 2, 0, nullptr, extra), CUDA_SUCCESS);
    unsigned got = 0;
    EXPECT_EQ(cuMemcpyDtoH(&got, out + 4, 4), CUDA_SUCCESS);
    EXPECT_EQ(got, 42u);
    size = 8;
    EXPECT_EQ(launch(1, 2, 0, nullptr, extra), CUDA_ERROR_INVALID_VALUE);
    int blocks = 0;
    EXPECT_EQ(cuOccupancyMaxActiveBlocksPerMultiprocessor(&blocks, fill, 256, 0), CUDA_SUCCESS);
    EXPECT_EQ(blocks, 4);
    EXPECT_EQ(cuOccupancyMaxActiveBlocksPerMultiprocessor(&blocks, fill, 0, 0),
              CUDA_ERROR_INVALID_VALUE);
    EXPECT_EQ(cuMemFree(out), CUDA_SUCCESS);
    EXPECT_EQ(cuModuleUnload(module), CUDA_SUCCESS);
}

// Kernels of two streams, and of the default streams of two threads, run at the same time: each
// continues when the other has arrived.
TEST_F(Launch, KernelsOfTwoStreamsMeet) {
    CUfunction meet = load(R"(.version 7.0
.target sm_70
.address_size 64
.visible .entry meet(.param .u64 words)
{
    .reg .b64 %rd<2>;
    .reg .b32 %r<4>;
    .reg .pred %p<2>;
    ld.param.u64 %rd1, [words];
    atom.global.add.u32 %r1, [%rd1], 1;
again:
    ld.volatile.global.u32 %r2, [%rd1];
    ld.volatile.global.u32 %r3, [%rd1+4];
    add.u32 %r2, %r2, %r3;
    setp.lt.u32 %p1, %r2, 2;
    @%p1 bra again;
    ret;
}
)",
                           "meet");
    unsigned* words = nullptr; // number of arrivals; whether to give up
    ASSERT_EQ(cuMemAllocHost(reinterpret_cast<void**>(&words), 8), CUDA_SUCCESS);
    void* params[] = {&words};
    const auto runTwo = [&](CUstream first, CUstream second, bool inThread) {
        words[0] = words[1] = 0;
        EXPECT_EQ(cuLaunchKernel(meet, 1, 1, 1, 1, 1, 1, 0, first, params, nullptr), CUDA_SUCCESS);
        const auto rest = [&] {
            EXPECT_EQ(cuCtxSetCurrent(context), CUDA_SUCCESS);
            EXPECT_EQ(cuLaunchKernel(meet, 1, 1, 1, 1, 1, 1, 0, second, params, nullptr),
                      CUDA_SUCCESS);
            const auto start = std::chrono::steady_clock::now();
            while (cuStreamQuery(second) == CUDA_ERROR_NOT_READY &&
                   std::chrono::steady_clock::now() - start < std::chrono::seconds(30))
                std::this_thread::sleep_for(std::chrono::milliseconds(1));
            EXPECT_EQ(cuStreamQuery(second), CUDA_SUCCESS) << "they wait for one another";
            __atomic_store_n(&words[1], 2, __ATOMIC_RELEASE);
        };
        if (inThread)
            std::thread(rest).join();
        else
            rest();
        EXPECT_EQ(cuStreamSynchronize(first), CUDA_SUCCESS);
    };
    CUstream streams[2] = {};
    for (CUstream& stream : streams)
        ASSERT_EQ(cuStreamCreate(&stream, CU_STREAM_DEFAULT), CUDA_SUCCESS);
    runTwo(streams[0], streams[1], false);
    runTwo(CU_STREAM_PER_THREAD, CU_STREAM_PER_THREAD, true);
    for (CUstream stream : streams)
        EXPECT_EQ(cuStreamDestroy(stream), CUDA_SUCCESS);
    EXPECT_EQ(cuMemFreeHost(words), CUDA_SUCCESS);
}

TEST_F(Launch, SmallLaunchesAreCheap) {
    CUmodule module = nullptr;
    CUfunction nothing = nullptr;
    ASSERT_EQ(cuModuleLoadData(&module, kText), CUDA_SUCCESS);
    ASSERT_EQ(cuModuleGetFunction(&nothing, module, "nothing"), CUDA_SUCCESS);
    // The best of many short rounds, because other programs interrupt only some of them.
    constexpr int kLaunches = 20, kRounds = 300;
    double best = 1e9;
    for (int round = 0; round < kRounds; ++round) {
        const auto start = std::chrono::steady_clock::now();
        for (int i = 0; i < kLaunches; ++i) {
            ASSERT_EQ(cuLaunchKernel(nothing, 1, 1, 1, 32, 1, 1, 0, nullptr, nullptr, nullptr),
                      CUDA_SUCCESS);
            ASSERT_EQ(cuStreamSynchronize(nullptr), CUDA_SUCCESS);
        }
        const std::chrono::duration<double, std::micro> time =
            std::chrono::steady_clock::now() - start;
        best = std::min(best, time.count() / kLaunches);
    }
    std::printf("launch and wait: %.1f microseconds\n", best);
    RecordProperty("microseconds", std::to_string(best));
    EXPECT_LT(best, 500); // ten times the value measured on a busy machine
    EXPECT_EQ(cuModuleUnload(module), CUDA_SUCCESS);
}

} // namespace
