// SPDX-License-Identifier: Apache-2.0
// Libraries and their kernels, memory words that streams write and wait for, attributes of streams.
#include <cuda.h>
#include <gtest/gtest.h>

#include <atomic>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <string>
#include <thread>
#include <vector>

namespace {

constexpr const char* kText = R"(
.version 7.0
.target sm_75
.address_size 64
.visible .global .align 4 .u32 offset = 5;
.visible .global .attribute(.managed) .align 4 .u32 shared_word = 7;
.visible .entry addTo(.param .u64 out, .param .u32 value) {
    .reg .u64 %rd<2>;
    .reg .u32 %r<4>;
    ld.param.u64 %rd1, [out];
    ld.param.u32 %r1, [value];
    ld.global.u32 %r2, [offset];
    add.u32 %r3, %r1, %r2;
    st.global.u32 [%rd1], %r3;
    ret;
}
.visible .entry nothing() {
    .shared .align 4 .b8 room[1024];
    st.shared.u32 [room], 1;
    ret;
}
)";

class Library : public testing::Test {
protected:
    void SetUp() override {
        ASSERT_EQ(cuInit(0), CUDA_SUCCESS);
        ASSERT_EQ(cuDevicePrimaryCtxRetain(&context, 0), CUDA_SUCCESS);
        // Loading needs no context.
        ASSERT_EQ(cuCtxSetCurrent(nullptr), CUDA_SUCCESS);
        ASSERT_EQ(cuLibraryLoadData(&library, kText, nullptr, nullptr, 0, nullptr, nullptr, 0),
                  CUDA_SUCCESS);
        ASSERT_EQ(cuLibraryGetKernel(&kernel, library, "addTo"), CUDA_SUCCESS);
        ASSERT_EQ(cuCtxSetCurrent(context), CUDA_SUCCESS);
        ASSERT_EQ(cuMemAlloc(&out, 4), CUDA_SUCCESS);
    }
    void TearDown() override {
        EXPECT_EQ(cuMemFree(out), CUDA_SUCCESS);
        EXPECT_EQ(cuLibraryUnload(library), CUDA_SUCCESS);
        EXPECT_EQ(cuCtxSetCurrent(nullptr), CUDA_SUCCESS);
        EXPECT_EQ(cuDevicePrimaryCtxRelease(0), CUDA_SUCCESS);
    }
    unsigned run(CUfunction function, unsigned value, CUdeviceptr where) {
        void* params[] = {&where, &value};
        EXPECT_EQ(cuLaunchKernel(function, 1, 1, 1, 1, 1, 1, 0, nullptr, params, nullptr),
                  CUDA_SUCCESS);
        unsigned result = 0;
        EXPECT_EQ(cuMemcpyDtoH(&result, where, 4), CUDA_SUCCESS);
        return result;
    }
    CUcontext context = nullptr;
    CUlibrary library = nullptr;
    CUkernel kernel = nullptr;
    CUdeviceptr out = 0;
};

TEST_F(Library, KernelsRunInTheCurrentContext) {
    EXPECT_EQ(run(reinterpret_cast<CUfunction>(kernel), 10, out), 15u);
    CUfunction function = nullptr;
    ASSERT_EQ(cuKernelGetFunction(&function, kernel), CUDA_SUCCESS);
    EXPECT_EQ(run(function, 1, out), 6u);

    // Each context has its own variable.
    CUdeviceptr offset = 0;
    size_t bytes = 0;
    ASSERT_EQ(cuLibraryGetGlobal(&offset, &bytes, library, "offset"), CUDA_SUCCESS);
    EXPECT_EQ(bytes, 4u);
    ASSERT_EQ(cuMemsetD32(offset, 100, 1), CUDA_SUCCESS);
    EXPECT_EQ(run(reinterpret_cast<CUfunction>(kernel), 1, out), 101u);
    CUcontext second = nullptr;
    ASSERT_EQ(cuCtxCreate_v2(&second, 0, 0), CUDA_SUCCESS);
    CUdeviceptr there = 0, elsewhere = 0;
    ASSERT_EQ(cuMemAlloc(&elsewhere, 4), CUDA_SUCCESS);
    ASSERT_EQ(cuLibraryGetGlobal(&there, nullptr, library, "offset"), CUDA_SUCCESS);
    EXPECT_NE(there, offset);
    EXPECT_EQ(run(reinterpret_cast<CUfunction>(kernel), 1, elsewhere), 6u);
    ASSERT_EQ(cuCtxDestroy(second), CUDA_SUCCESS);
    EXPECT_EQ(run(reinterpret_cast<CUfunction>(kernel), 1, out), 101u);
}

TEST_F(Library, WhatIsAskedOfThem) {
    unsigned count = 0;
    ASSERT_EQ(cuLibraryGetKernelCount(&count, library), CUDA_SUCCESS);
    EXPECT_EQ(count, 2u);
    std::vector<CUkernel> all(3, nullptr);
    ASSERT_EQ(cuLibraryEnumerateKernels(all.data(), 3, library), CUDA_SUCCESS);
    EXPECT_TRUE(all[0] == kernel || all[1] == kernel);
    EXPECT_EQ(all[2], nullptr);
    const char* name = nullptr;
    ASSERT_EQ(cuKernelGetName(&name, kernel), CUDA_SUCCESS);
    EXPECT_STREQ(name, "addTo");
    CUlibrary owner = nullptr;
    ASSERT_EQ(cuKernelGetLibrary(&owner, kernel), CUDA_SUCCESS);
    EXPECT_EQ(owner, library);
    size_t offset = 99, size = 0;
    ASSERT_EQ(cuKernelGetParamInfo(kernel, 1, &offset, &size), CUDA_SUCCESS);
    EXPECT_EQ(offset, 8u);
    EXPECT_EQ(size, 4u);
    EXPECT_EQ(cuKernelGetParamInfo(kernel, 2, &offset, &size), CUDA_ERROR_INVALID_VALUE);
    CUmodule module = nullptr;
    ASSERT_EQ(cuLibraryGetModule(&module, library), CUDA_SUCCESS);
    CUfunction function = nullptr;
    EXPECT_EQ(cuModuleGetFunction(&function, module, "nothing"), CUDA_SUCCESS);

    CUkernel nothing = nullptr;
    ASSERT_EQ(cuLibraryGetKernel(&nothing, library, "nothing"), CUDA_SUCCESS);
    int value = 0;
    ASSERT_EQ(cuKernelGetAttribute(&value, CU_FUNC_ATTRIBUTE_SHARED_SIZE_BYTES, nothing, 0),
              CUDA_SUCCESS);
    EXPECT_EQ(value, 1024);
    ASSERT_EQ(cuKernelSetAttribute(CU_FUNC_ATTRIBUTE_MAX_DYNAMIC_SHARED_SIZE_BYTES, 60000, nothing, 0),
              CUDA_SUCCESS);
    EXPECT_EQ(cuLaunchKernel(reinterpret_cast<CUfunction>(nothing), 1, 1, 1, 1, 1, 1, 60000, nullptr,
                             nullptr, nullptr),
              CUDA_SUCCESS);
    EXPECT_EQ(cuKernelSetAttribute(CU_FUNC_ATTRIBUTE_NUM_REGS, 1, nothing, 0),
              CUDA_ERROR_INVALID_VALUE);
    EXPECT_EQ(cuKernelSetAttribute(CU_FUNC_ATTRIBUTE_MAX_DYNAMIC_SHARED_SIZE_BYTES, 1, nothing, 3),
              CUDA_ERROR_INVALID_DEVICE);
    int blocks = 0;
    EXPECT_EQ(cuOccupancyMaxActiveBlocksPerMultiprocessor(
                  &blocks, reinterpret_cast<CUfunction>(kernel), 256, 0),
              CUDA_SUCCESS);
    EXPECT_GT(blocks, 0);
    EXPECT_EQ(cuOccupancyMaxActiveBlocksPerMultiprocessor(
                  &blocks, reinterpret_cast<CUfunction>(nothing), 256, SIZE_MAX),
              CUDA_SUCCESS);
    EXPECT_EQ(blocks, 0) << "with its static shared memory the sum wraps around";
}

TEST_F(Library, ManagedVariablesAreManagedMemory) {
    CUdeviceptr word = 0;
    size_t bytes = 0;
    ASSERT_EQ(cuLibraryGetManaged(&word, &bytes, library, "shared_word"), CUDA_SUCCESS);
    EXPECT_EQ(bytes, 4u);
    EXPECT_EQ(*reinterpret_cast<unsigned*>(word), 7u);
    EXPECT_EQ(cuLibraryGetManaged(&word, &bytes, library, "offset"), CUDA_ERROR_NOT_FOUND);
    unsigned managed = 0;
    EXPECT_EQ(cuPointerGetAttribute(&managed, CU_POINTER_ATTRIBUTE_IS_MANAGED, word), CUDA_SUCCESS);
    EXPECT_EQ(managed, 1u);
    CUmemLocation device = {CU_MEM_LOCATION_TYPE_DEVICE, 0};
    EXPECT_EQ(cuMemPrefetchAsync(word, 4, device, 0, nullptr), CUDA_SUCCESS);
    EXPECT_EQ(cuMemFree(word), CUDA_ERROR_INVALID_VALUE);
}

TEST_F(Library, BadInput) {
    CUlibrary other = nullptr;
    CUkernel found = nullptr;
    EXPECT_EQ(cuLibraryLoadData(nullptr, kText, nullptr, nullptr, 0, nullptr, nullptr, 0),
              CUDA_ERROR_INVALID_VALUE);
    EXPECT_EQ(cuLibraryLoadData(&other, nullptr, nullptr, nullptr, 0, nullptr, nullptr, 0),
              CUDA_ERROR_INVALID_VALUE);
    EXPECT_EQ(cuLibraryLoadData(&other, ".version nonsense", nullptr, nullptr, 0, nullptr, nullptr, 0),
              CUDA_ERROR_INVALID_PTX);
    EXPECT_EQ(cuLibraryLoadFromFile(&other, "/nonexistent", nullptr, nullptr, 0, nullptr, nullptr, 0),
              CUDA_ERROR_FILE_NOT_FOUND);
    CUlibraryOption option = CUlibraryOption(77);
    void* value = nullptr;
    EXPECT_EQ(cuLibraryLoadData(&other, kText, nullptr, nullptr, 0, &option, &value, 1),
              CUDA_ERROR_INVALID_VALUE);
    option = CU_LIBRARY_BINARY_IS_PRESERVED;
    ASSERT_EQ(cuLibraryLoadData(&other, kText, nullptr, nullptr, 0, &option, &value, 1), CUDA_SUCCESS);
    ASSERT_EQ(cuLibraryGetKernel(&found, other, "addTo"), CUDA_SUCCESS);
    EXPECT_EQ(cuLibraryGetKernel(&found, other, "missing"), CUDA_ERROR_NOT_FOUND);
    EXPECT_EQ(cuLibraryUnload(other), CUDA_SUCCESS);
    EXPECT_EQ(cuLibraryUnload(other), CUDA_ERROR_INVALID_HANDLE);
    unsigned one = 1;
    void* params[] = {&out, &one};
    EXPECT_EQ(cuLaunchKernel(reinterpret_cast<CUfunction>(found), 1, 1, 1, 1, 1, 1, 0, nullptr, params,
                             nullptr),
              CUDA_ERROR_INVALID_HANDLE);
    EXPECT_EQ(cuLibraryGetKernel(&found, other, "addTo"), CUDA_ERROR_INVALID_HANDLE);
    void* unified = nullptr;
    EXPECT_EQ(cuLibraryGetUnifiedFunction(&unified, library, "addTo"), CUDA_ERROR_NOT_FOUND);
    EXPECT_EQ(cuLibraryGetGlobal(&out, nullptr, library, "missing"), CUDA_ERROR_NOT_FOUND);
}

class StreamMemory : public testing::Test {
protected:
    void SetUp() override {
        ASSERT_EQ(cuInit(0), CUDA_SUCCESS);
        ASSERT_EQ(cuDevicePrimaryCtxRetain(&context, 0), CUDA_SUCCESS);
        ASSERT_EQ(cuCtxSetCurrent(context), CUDA_SUCCESS);
        ASSERT_EQ(cuStreamCreate(&stream, CU_STREAM_NON_BLOCKING), CUDA_SUCCESS);
        ASSERT_EQ(cuMemAlloc(&memory, 64), CUDA_SUCCESS);
        ASSERT_EQ(cuMemsetD8(memory, 0, 64), CUDA_SUCCESS);
    }
    void TearDown() override {
        EXPECT_EQ(cuStreamDestroy(stream), CUDA_SUCCESS);
        EXPECT_EQ(cuMemFree(memory), CUDA_SUCCESS);
        EXPECT_EQ(cuDevicePrimaryCtxRelease(0), CUDA_SUCCESS);
    }
    unsigned word(size_t index) {
        unsigned value = 0;
        EXPECT_EQ(cuMemcpyDtoH(&value, memory + 4 * index, 4), CUDA_SUCCESS);
        return value;
    }
    CUcontext context = nullptr;
    CUstream stream = nullptr;
    CUdeviceptr memory = 0;
};

TEST_F(StreamMemory, StreamsWaitForEachOther) {
    CUstream other = nullptr;
    ASSERT_EQ(cuStreamCreate(&other, CU_STREAM_NON_BLOCKING), CUDA_SUCCESS);
    ASSERT_EQ(cuStreamWaitValue32(stream, memory, 3, CU_STREAM_WAIT_VALUE_GEQ), CUDA_SUCCESS);
    ASSERT_EQ(cuStreamWriteValue32(stream, memory + 4, 42, CU_STREAM_WRITE_VALUE_DEFAULT),
              CUDA_SUCCESS);
    EXPECT_EQ(cuStreamQuery(stream), CUDA_ERROR_NOT_READY);
    EXPECT_EQ(*reinterpret_cast<volatile unsigned*>(memory + 4), 0u);
    ASSERT_EQ(cuStreamWriteValue32(other, memory, 2, 0), CUDA_SUCCESS);
    ASSERT_EQ(cuStreamSynchronize(other), CUDA_SUCCESS);
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
    EXPECT_EQ(cuStreamQuery(stream), CUDA_ERROR_NOT_READY);
    ASSERT_EQ(cuStreamWriteValue32(other, memory, 3, 0), CUDA_SUCCESS);
    ASSERT_EQ(cuStreamSynchronize(stream), CUDA_SUCCESS);
    EXPECT_EQ(word(1), 42u);

    // Satisfied conditions on words of either size; the order of GEQ wraps around.
    ASSERT_EQ(cuStreamWriteValue64(stream, memory + 16, 0xf000000000000005ull, 0), CUDA_SUCCESS);
    ASSERT_EQ(cuStreamWaitValue64(stream, memory + 16, 0xf000000000000005ull, CU_STREAM_WAIT_VALUE_EQ),
              CUDA_SUCCESS);
    ASSERT_EQ(cuStreamWaitValue64(stream, memory + 16, 4, CU_STREAM_WAIT_VALUE_AND), CUDA_SUCCESS);
    ASSERT_EQ(cuStreamWaitValue64(stream, memory + 16, 2, CU_STREAM_WAIT_VALUE_NOR), CUDA_SUCCESS);
    ASSERT_EQ(cuStreamWaitValue32(stream, memory, 0xfffffff0u, CU_STREAM_WAIT_VALUE_GEQ),
              CUDA_SUCCESS);
    CUstreamBatchMemOpParams batch[3] = {};
    batch[0].writeValue = {CU_STREAM_MEM_OP_WRITE_VALUE_32, memory + 8, {7}, 0, 0};
    batch[1].memoryBarrier = {CU_STREAM_MEM_OP_BARRIER, 0};
    batch[2].waitValue = {CU_STREAM_MEM_OP_WAIT_VALUE_32, memory + 8, {7}, CU_STREAM_WAIT_VALUE_EQ, 0};
    ASSERT_EQ(cuStreamBatchMemOp(stream, 3, batch, 0), CUDA_SUCCESS);
    ASSERT_EQ(cuStreamSynchronize(stream), CUDA_SUCCESS);
    EXPECT_EQ(word(2), 7u);
    EXPECT_EQ(cuStreamDestroy(other), CUDA_SUCCESS);
}

// At the end of a process, runtimes unload their modules, which waits for all streams.
TEST_F(StreamMemory, AWordThatNeverComesLetsTheProcessEnd) {
    testing::GTEST_FLAG(death_test_style) = "threadsafe";
    EXPECT_EXIT(
        {
            std::atexit([] { cuCtxSynchronize(); });
            if (cuStreamWaitValue32(stream, memory, 1, CU_STREAM_WAIT_VALUE_EQ) == CUDA_SUCCESS)
                std::exit(7);
        },
        testing::ExitedWithCode(7), "");
}

TEST_F(StreamMemory, BadInput) {
    EXPECT_EQ(cuStreamWriteValue32(stream, 0, 1, 0), CUDA_ERROR_INVALID_VALUE);
    EXPECT_EQ(cuStreamWriteValue32(stream, memory + 2, 1, 0), CUDA_ERROR_INVALID_VALUE);
    EXPECT_EQ(cuStreamWriteValue64(stream, memory + 4, 1, 0), CUDA_ERROR_INVALID_VALUE);
    EXPECT_EQ(cuStreamWriteValue32(stream, memory, 1, 2), CUDA_ERROR_INVALID_VALUE);
    EXPECT_EQ(cuStreamWaitValue32(stream, memory, 1, 4), CUDA_ERROR_INVALID_VALUE);
    EXPECT_EQ(cuStreamWaitValue32(stream, 0xdead0000, 1, 0), CUDA_ERROR_INVALID_VALUE);
    CUdeviceptr half = 0; // of a word of eight bytes
    ASSERT_EQ(cuMemAlloc(&half, 4), CUDA_SUCCESS);
    EXPECT_EQ(cuStreamWriteValue64(stream, half, 1, 0), CUDA_ERROR_INVALID_VALUE);
    EXPECT_EQ(cuStreamWaitValue64(stream, half, 0, 0), CUDA_ERROR_INVALID_VALUE);
    EXPECT_EQ(cuStreamWriteValue32(stream, half, 1, 0), CUDA_SUCCESS);
    EXPECT_EQ(cuMemFree(half), CUDA_SUCCESS);
    CUstreamBatchMemOpParams op = {};
    EXPECT_EQ(cuStreamBatchMemOp(stream, 1, &op, 0), CUDA_ERROR_INVALID_VALUE);
    op.flushRemoteWrites = {CU_STREAM_MEM_OP_FLUSH_REMOTE_WRITES, 0};
    EXPECT_EQ(cuStreamBatchMemOp(stream, 1, &op, 0), CUDA_ERROR_NOT_SUPPORTED);
    EXPECT_EQ(cuStreamBatchMemOp(stream, 0, &op, 0), CUDA_ERROR_INVALID_VALUE);
    EXPECT_EQ(cuStreamBatchMemOp(stream, 1, nullptr, 0), CUDA_ERROR_INVALID_VALUE);
    EXPECT_EQ(cuStreamQuery(stream), CUDA_SUCCESS);
}

TEST_F(StreamMemory, Attributes) {
    CUstreamAttrValue value = {};
    ASSERT_EQ(cuStreamGetAttribute(stream, CU_STREAM_ATTRIBUTE_PRIORITY, &value), CUDA_SUCCESS);
    EXPECT_EQ(value.priority, 0);
    value.priority = -3;
    ASSERT_EQ(cuStreamSetAttribute(stream, CU_STREAM_ATTRIBUTE_PRIORITY, &value), CUDA_SUCCESS);
    int priority = 0;
    ASSERT_EQ(cuStreamGetPriority(stream, &priority), CUDA_SUCCESS);
    EXPECT_EQ(priority, -3);
    value.syncPolicy = CU_SYNC_POLICY_YIELD;
    ASSERT_EQ(cuStreamSetAttribute(stream, CU_STREAM_ATTRIBUTE_SYNCHRONIZATION_POLICY, &value),
              CUDA_SUCCESS);
    CUstream other = nullptr;
    ASSERT_EQ(cuStreamCreate(&other, 0), CUDA_SUCCESS);
    ASSERT_EQ(cuStreamCopyAttributes(other, stream), CUDA_SUCCESS);
    ASSERT_EQ(cuStreamGetAttribute(other, CU_STREAM_ATTRIBUTE_SYNCHRONIZATION_POLICY, &value),
              CUDA_SUCCESS);
    EXPECT_EQ(value.syncPolicy, CU_SYNC_POLICY_YIELD);
    ASSERT_EQ(cuStreamGetPriority(other, &priority), CUDA_SUCCESS);
    EXPECT_EQ(priority, -3);
    EXPECT_EQ(cuStreamDestroy(other), CUDA_SUCCESS);
    EXPECT_EQ(cuStreamSetAttribute(stream, CU_LAUNCH_ATTRIBUTE_COOPERATIVE, &value),
              CUDA_ERROR_INVALID_VALUE);
    EXPECT_EQ(cuStreamGetAttribute(stream, CU_STREAM_ATTRIBUTE_PRIORITY, nullptr),
              CUDA_ERROR_INVALID_VALUE);
    EXPECT_EQ(cuStreamGetAttribute(other, CU_STREAM_ATTRIBUTE_PRIORITY, &value),
              CUDA_ERROR_INVALID_HANDLE);
}

} // namespace
