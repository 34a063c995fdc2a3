// SPDX-License-Identifier: Apache-2.0
// Late accesses to freed memory by kernels, copies, graphs and waits of streams return
// CUDA_ERROR_ILLEGAL_ADDRESS, the log names the freed allocation, and the process continues.
#include <cuda.h>
#include <gtest/gtest.h>

#include <sys/mman.h>

#include <cstdlib>
#include <functional>
#include <string>
#include <thread>
#include <vector>

namespace {

[[maybe_unused]] const int kLogged = setenv("SUNSTONE_LOG", "cuda:warning", 1);

const char* const kText = R"(.version 7.0
.target sm_60
.address_size 64
.visible .entry write(.param .u64 out)
{
    .reg .b64 %rd<2>;
    ld.param.u64 %rd1, [out];
    st.global.u32 [%rd1], 1;
    ret;
}
.visible .entry read(.param .u64 out)
{
    .reg .b32 %r<2>;
    .reg .b64 %rd<2>;
    ld.param.u64 %rd1, [out];
    ld.volatile.global.u32 %r1, [%rd1];
    ret;
}
)";

class FreedMemory : public testing::Test {
protected:
    void SetUp() override {
#if defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
        GTEST_SKIP() << "a sanitizer reports faults";
#endif
#endif
        ASSERT_EQ(cuInit(0), CUDA_SUCCESS);
        enter();
    }
    void TearDown() override {
        if (!IsSkipped())
            leave();
    }
    void enter() {
        ASSERT_EQ(cuCtxCreate(&context_, nullptr, 0, 0), CUDA_SUCCESS);
        CUmodule module = nullptr;
        ASSERT_EQ(cuModuleLoadData(&module, kText), CUDA_SUCCESS);
        ASSERT_EQ(cuModuleGetFunction(&write_, module, "write"), CUDA_SUCCESS);
        ASSERT_EQ(cuModuleGetFunction(&read_, module, "read"), CUDA_SUCCESS);
        ASSERT_EQ(cuStreamCreate(&stream_, CU_STREAM_NON_BLOCKING), CUDA_SUCCESS);
    }
    void leave() { EXPECT_EQ(cuCtxDestroy(context_), CUDA_SUCCESS); }

    static CUresult run(CUfunction kernel, CUdeviceptr at) {
        void* params[] = {&at};
        const CUresult result =
            cuLaunchKernel(kernel, 1, 1, 1, 1, 1, 1, 0, nullptr, params, nullptr);
        return result ? result : cuCtxSynchronize();
    }
    // Checks that `access` fails and that the log has "use after free" and `mention`; then replaces
    // the context.
    void expectLate(const std::string& mention, const std::function<CUresult()>& access) {
        SCOPED_TRACE(mention);
        testing::internal::CaptureStderr();
        const CUresult result = access();
        const std::string log = testing::internal::GetCapturedStderr();
        EXPECT_EQ(result, CUDA_ERROR_ILLEGAL_ADDRESS) << log;
        EXPECT_NE(std::string::npos, log.find("use after free: the address is " + mention)) << log;
        EXPECT_EQ(cuCtxSynchronize(), CUDA_ERROR_ILLEGAL_ADDRESS) << "the context has failed";
        leave();
        enter();
    }

    CUcontext context_ = nullptr;
    CUfunction write_ = nullptr, read_ = nullptr;
    CUstream stream_ = nullptr;
};

TEST_F(FreedMemory, OfAllSizes) {
    for (const size_t size : {size_t(256), size_t(64) << 10, size_t(64) << 20})
        for (const bool isWrite : {true, false}) {
            CUdeviceptr memory = 0;
            ASSERT_EQ(cuMemAlloc(&memory, size), CUDA_SUCCESS);
            ASSERT_EQ(run(write_, memory), CUDA_SUCCESS);
            ASSERT_EQ(cuMemFree(memory), CUDA_SUCCESS);
            const std::string of =
                " bytes into " + std::to_string(size) + " bytes of device memory";
            expectLate(std::to_string(size - 8) + of,
                       [&] { return run(isWrite ? write_ : read_, memory + size - 8); });
        }
}

TEST_F(FreedMemory, OfAllKinds) {
    CUdeviceptr memory = 0;
    ASSERT_EQ(cuMemAllocManaged(&memory, 4096, CU_MEM_ATTACH_GLOBAL), CUDA_SUCCESS);
    ASSERT_EQ(cuMemFree(memory), CUDA_SUCCESS);
    expectLate("0 bytes into 4096 bytes of managed memory", [&] { return run(write_, memory); });

    void* pinned = nullptr;
    ASSERT_EQ(cuMemAllocHost(&pinned, 4096), CUDA_SUCCESS);
    ASSERT_EQ(cuMemFreeHost(pinned), CUDA_SUCCESS);
    expectLate("4 bytes into 4096 bytes of page-locked host memory",
               [&] { return run(write_, CUdeviceptr(pinned) + 4); });

    ASSERT_EQ(cuMemAllocAsync(&memory, 5000, stream_), CUDA_SUCCESS);
    ASSERT_EQ(cuMemFreeAsync(memory, stream_), CUDA_SUCCESS);
    ASSERT_EQ(cuStreamSynchronize(stream_), CUDA_SUCCESS);
    expectLate("0 bytes into 5000 bytes of device memory", [&] { return run(write_, memory); });

    ASSERT_EQ(cuMemAlloc(&memory, 300), CUDA_SUCCESS);
    leave();
    enter();
    expectLate("0 bytes into 300 bytes of device memory", [&] { return run(write_, memory); });

    constexpr size_t kUnit = size_t(2) << 20;
    ASSERT_EQ(cuMemAddressReserve(&memory, kUnit, 0, 0, 0), CUDA_SUCCESS);
    ASSERT_EQ(cuMemAddressFree(memory, kUnit), CUDA_SUCCESS);
    expectLate("16 bytes into 2097152 bytes of mapped device memory",
               [&] { return run(write_, memory + 16); });
}

// Freed in the order of a stream, right before the kernel.
TEST_F(FreedMemory, OfTheSameStream) {
    CUdeviceptr memory = 0;
    ASSERT_EQ(cuMemAllocAsync(&memory, 256, stream_), CUDA_SUCCESS);
    void* params[] = {&memory};
    expectLate("0 bytes into 256 bytes of device memory", [&] {
        EXPECT_EQ(cuMemFreeAsync(memory, stream_), CUDA_SUCCESS);
        EXPECT_EQ(cuLaunchKernel(write_, 1, 1, 1, 1, 1, 1, 0, stream_, params, nullptr),
                  CUDA_SUCCESS);
        return cuStreamSynchronize(stream_);
    });
}

// Allocations that threads have made since have other addresses, so no memory of the process is
// overwritten.
TEST_F(FreedMemory, IsNoOthersMemory) {
    constexpr size_t kSize = size_t(1) << 20;
    std::vector<CUdeviceptr> all(100);
    for (CUdeviceptr& memory : all)
        ASSERT_EQ(cuMemAlloc(&memory, kSize), CUDA_SUCCESS);
    for (const CUdeviceptr memory : all)
        ASSERT_EQ(cuMemFree(memory), CUDA_SUCCESS);
    const auto isFreed = [&](const void* address) {
        for (const CUdeviceptr memory : all)
            if (CUdeviceptr(address) - memory < kSize)
                return true;
        return false;
    };
    for (int i = 0; i < 50; ++i) {
        std::thread([&] { EXPECT_FALSE(isFreed(__builtin_frame_address(0))); }).join();
        void* const page = mmap(nullptr, kSize, PROT_READ, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
        EXPECT_FALSE(isFreed(page));
        const std::vector<char> heap(size_t(1) << (i % 21));
        EXPECT_FALSE(isFreed(heap.data()));
        munmap(page, kSize);
    }
}

// A graph that was made while the memory lived.
TEST_F(FreedMemory, OfGraphs) {
    CUDA_MEMCPY3D copy = {};
    copy.srcMemoryType = copy.dstMemoryType = CU_MEMORYTYPE_DEVICE;
    copy.WidthInBytes = 64;
    copy.Height = copy.Depth = 1;
    CUDA_ARRAY3D_DESCRIPTOR shape = {64, 4, 0, CU_AD_FORMAT_FLOAT, 1, 0};
    for (const int kind : {0, 1, 2}) {
        SCOPED_TRACE(kind);
        CUdeviceptr memory = 0, other = 0;
        CUarray array = nullptr;
        ASSERT_EQ(cuMemAlloc(&memory, 1000), CUDA_SUCCESS);
        ASSERT_EQ(cuMemAlloc(&other, 1000), CUDA_SUCCESS);
        ASSERT_EQ(cuArray3DCreate(&array, &shape), CUDA_SUCCESS);
        CUgraph graph = nullptr;
        CUgraphNode node = nullptr;
        CUgraphExec exec = nullptr;
        ASSERT_EQ(cuGraphCreate(&graph, 0), CUDA_SUCCESS);
        if (kind == 0) {
            const CUDA_MEMSET_NODE_PARAMS set = {memory, 0, 1, 4, 16, 1};
            ASSERT_EQ(cuGraphAddMemsetNode(&node, graph, nullptr, 0, &set, context_), CUDA_SUCCESS);
        } else {
            copy.dstMemoryType = kind == 1 ? CU_MEMORYTYPE_DEVICE : CU_MEMORYTYPE_ARRAY;
            copy.dstDevice = memory;
            copy.dstArray = array;
            copy.srcDevice = other;
            ASSERT_EQ(cuGraphAddMemcpyNode(&node, graph, nullptr, 0, &copy, context_),
                      CUDA_SUCCESS);
        }
        ASSERT_EQ(cuGraphInstantiate(&exec, graph, 0), CUDA_SUCCESS);
        ASSERT_EQ(cuGraphLaunch(exec, stream_), CUDA_SUCCESS);
        ASSERT_EQ(cuStreamSynchronize(stream_), CUDA_SUCCESS);
        ASSERT_EQ(cuMemFree(memory), CUDA_SUCCESS);
        ASSERT_EQ(cuArrayDestroy(array), CUDA_SUCCESS);
        expectLate(kind == 2 ? "0 bytes into 1" : "0 bytes into 1000 bytes of device memory", [&] {
            const CUresult result = cuGraphLaunch(exec, stream_);
            return result ? result : cuStreamSynchronize(stream_);
        });
        EXPECT_EQ(cuGraphExecDestroy(exec), CUDA_SUCCESS);
        EXPECT_EQ(cuGraphDestroy(graph), CUDA_SUCCESS);
    }
}

// Copies of freed device memory as host memory, and words that streams write.
TEST_F(FreedMemory, OfCopiesAndWords) {
    CUdeviceptr memory = 0, live = 0;
    ASSERT_EQ(cuMemAlloc(&memory, 256), CUDA_SUCCESS);
    ASSERT_EQ(cuMemAlloc(&live, 256), CUDA_SUCCESS);
    ASSERT_EQ(cuMemFree(memory), CUDA_SUCCESS);
    auto* const host = reinterpret_cast<char*>(memory);
    EXPECT_EQ(cuMemcpyHtoD(live, host, 256), CUDA_ERROR_INVALID_VALUE);
    EXPECT_EQ(cuMemcpyDtoH(host, live, 256), CUDA_ERROR_INVALID_VALUE);
    EXPECT_EQ(cuMemcpyDtoD(live, memory, 256), CUDA_ERROR_INVALID_VALUE);
    EXPECT_EQ(cuMemHostRegister(host, 256, 0), CUDA_ERROR_INVALID_VALUE);
    EXPECT_EQ(cuStreamWriteValue32(stream_, memory, 1, 0), CUDA_ERROR_INVALID_VALUE);
    // Queued before it is freed, run after it.
    ASSERT_EQ(cuMemAllocAsync(&memory, 256, stream_), CUDA_SUCCESS);
    expectLate("0 bytes into 256 bytes", [&] {
        EXPECT_EQ(cuMemFreeAsync(memory, nullptr), CUDA_SUCCESS);
        const CUresult queued = cuStreamWaitValue32(stream_, memory, 1, CU_STREAM_WAIT_VALUE_EQ);
        EXPECT_TRUE(queued == CUDA_SUCCESS || queued == CUDA_ERROR_INVALID_VALUE) << queued;
        const CUresult freed = cuStreamSynchronize(nullptr); // the wait may have ended before
        EXPECT_TRUE(freed == CUDA_SUCCESS || freed == CUDA_ERROR_ILLEGAL_ADDRESS) << freed;
        return queued ? run(write_, memory) : cuStreamSynchronize(stream_);
    });
}

// Only memory that the process may access can be registered.
TEST_F(FreedMemory, InaccessibleMemoryIsNotRegistered) {
    constexpr size_t kSize = 1 << 16;
    void* const pages = mmap(nullptr, kSize, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    ASSERT_NE(MAP_FAILED, pages);
    EXPECT_EQ(cuMemHostRegister(pages, kSize, 0), CUDA_ERROR_INVALID_VALUE);
    ASSERT_EQ(mprotect(pages, kSize, PROT_READ), 0);
    EXPECT_EQ(cuMemHostRegister(pages, kSize, 0), CUDA_ERROR_INVALID_VALUE);
    EXPECT_EQ(cuMemHostRegister(pages, kSize, CU_MEMHOSTREGISTER_READ_ONLY), CUDA_SUCCESS);
    EXPECT_EQ(cuMemHostUnregister(pages), CUDA_SUCCESS);
    munmap(pages, kSize);
    constexpr size_t kUnit = size_t(2) << 20;
    CUdeviceptr space = 0;
    ASSERT_EQ(cuMemAddressReserve(&space, kUnit, 0, 0, 0), CUDA_SUCCESS);
    EXPECT_EQ(cuMemHostRegister(reinterpret_cast<void*>(space), 4096, 0), CUDA_ERROR_INVALID_VALUE);
    EXPECT_EQ(cuMemAddressFree(space, kUnit), CUDA_SUCCESS);
}

} // namespace
