// SPDX-License-Identifier: Apache-2.0
// Concurrent calls of several threads on shared objects: kernels of libraries, events, words,
// graphs, pools, short-lived contexts. Mainly for the thread sanitizer (scripts/sanitize tsan).
#include <cuda.h>
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <dlfcn.h>
#include <functional>
#include <pthread.h>
#include <thread>
#include <vector>

// Results of the constructor and the destructor of waiting_library.cpp.
int gWaited[2] = {};

namespace {

constexpr unsigned kThreads = 4, kRounds = 40;

constexpr const char* kText = R"(
.version 7.0
.target sm_75
.address_size 64
.visible .global .attribute(.managed) .align 4 .u32 total = 0;
.visible .entry addTo(.param .u64 out, .param .u32 value) {
    .reg .u64 %rd<2>;
    .reg .u32 %r<3>;
    ld.param.u64 %rd1, [out];
    ld.param.u32 %r1, [value];
    atom.global.add.u32 %r2, [%rd1], %r1;
    atom.global.add.u32 %r2, [total], %r1;
    ret;
}
)";

class Threads : public testing::Test {
protected:
    void SetUp() override {
        ASSERT_EQ(cuInit(0), CUDA_SUCCESS);
        ASSERT_EQ(cuDevicePrimaryCtxRetain(&context, 0), CUDA_SUCCESS);
        ASSERT_EQ(cuCtxSetCurrent(context), CUDA_SUCCESS);
        ASSERT_EQ(cuMemAllocManaged(&memory, 4096, CU_MEM_ATTACH_GLOBAL), CUDA_SUCCESS);
        ASSERT_EQ(cuMemsetD8(memory, 0, 4096), CUDA_SUCCESS);
        for (CUstream& stream : streams)
            ASSERT_EQ(cuStreamCreate(&stream, CU_STREAM_NON_BLOCKING), CUDA_SUCCESS);
    }
    void TearDown() override {
        for (CUstream stream : streams)
            EXPECT_EQ(cuStreamDestroy(stream), CUDA_SUCCESS);
        EXPECT_EQ(cuMemFree(memory), CUDA_SUCCESS);
        EXPECT_EQ(cuCtxSetCurrent(nullptr), CUDA_SUCCESS);
        EXPECT_EQ(cuDevicePrimaryCtxRelease(0), CUDA_SUCCESS);
    }
    // Runs the body on all threads, with the number of each.
    void onAll(const std::function<void(unsigned)>& body) {
        std::vector<std::thread> threads;
        for (unsigned i = 0; i < kThreads; ++i)
            threads.emplace_back([&, i] {
                ASSERT_EQ(cuCtxSetCurrent(context), CUDA_SUCCESS);
                body(i);
            });
        for (std::thread& thread : threads)
            thread.join();
    }
    CUdeviceptr wordAt(unsigned index) const { return memory + 4 * index; }
    unsigned word(unsigned index) const { return reinterpret_cast<const unsigned*>(memory)[index]; }
    static CUresult add(CUfunction kernel, CUdeviceptr out, unsigned value, CUstream stream,
                        unsigned shared = 0) {
        void* params[] = {&out, &value};
        return cuLaunchKernel(kernel, 1, 1, 1, 1, 1, 1, shared, stream, params, nullptr);
    }
    static CUlibrary load() {
        CUlibrary library = nullptr;
        EXPECT_EQ(cuLibraryLoadData(&library, kText, nullptr, nullptr, 0, nullptr, nullptr, 0),
                  CUDA_SUCCESS);
        return library;
    }
    static CUfunction kernelOf(CUlibrary library) {
        CUkernel kernel = nullptr;
        EXPECT_EQ(cuLibraryGetKernel(&kernel, library, "addTo"), CUDA_SUCCESS);
        return reinterpret_cast<CUfunction>(kernel);
    }

    CUcontext context = nullptr;
    CUdeviceptr memory = 0;
    CUstream streams[kThreads] = {};
};

TEST_F(Threads, LaunchKernelsOfOneLibrary) {
    const CUlibrary library = load();
    const CUfunction kernel = kernelOf(library); // compiled by the first thread
    onAll([&](unsigned thread) {
        for (unsigned round = 0; round < kRounds; ++round) {
            ASSERT_EQ(cuKernelSetAttribute(CU_FUNC_ATTRIBUTE_MAX_DYNAMIC_SHARED_SIZE_BYTES,
                                           int(60000 + 100 * thread), CUkernel(kernel), 0),
                      CUDA_SUCCESS);
            ASSERT_EQ(add(kernel, wordAt(thread), 1, streams[thread], 50000), CUDA_SUCCESS);
            ASSERT_EQ(add(kernel, wordAt(kThreads), 1, streams[(thread + 1) % kThreads]),
                      CUDA_SUCCESS);
        }
        EXPECT_EQ(cuStreamSynchronize(streams[thread]), CUDA_SUCCESS);
        EXPECT_EQ(word(thread), kRounds);
    });
    EXPECT_EQ(cuCtxSynchronize(), CUDA_SUCCESS);
    EXPECT_EQ(word(kThreads), kThreads * kRounds);
    CUdeviceptr total = 0;
    ASSERT_EQ(cuLibraryGetManaged(&total, nullptr, library, "total"), CUDA_SUCCESS);
    EXPECT_EQ(*reinterpret_cast<unsigned*>(total), 2 * kThreads * kRounds);
    EXPECT_EQ(cuLibraryUnload(library), CUDA_SUCCESS);
}

TEST_F(Threads, LoadAndUnload) {
    onAll([&](unsigned thread) {
        for (unsigned round = 0; round < 4; ++round) {
            const CUlibrary library = load();
            ASSERT_EQ(add(kernelOf(library), wordAt(thread), 1, streams[thread]), CUDA_SUCCESS);
            CUdeviceptr total = 0;
            ASSERT_EQ(cuLibraryGetManaged(&total, nullptr, library, "total"), CUDA_SUCCESS);
            ASSERT_EQ(cuMemsetD32Async(total, 7, 1, streams[thread]), CUDA_SUCCESS);
            if (round % 2 == 0) { // else queued work still uses it
                ASSERT_EQ(cuStreamSynchronize(streams[thread]), CUDA_SUCCESS);
                EXPECT_EQ(*reinterpret_cast<unsigned*>(total), 7u);
            }
            ASSERT_EQ(cuLibraryUnload(library), CUDA_SUCCESS);
            EXPECT_EQ(cuLibraryUnload(library), CUDA_ERROR_INVALID_HANDLE);
        }
        EXPECT_EQ(word(thread), 4u);
    });
}

// Each stream writes its word and waits for the word of the next stream; half of the streams do so
// in one batch.
TEST_F(Threads, StreamsWaitForWordsInARing) {
    onAll([&](unsigned thread) {
        const CUdeviceptr mine = wordAt(thread), next = wordAt((thread + 1) % kThreads);
        for (unsigned round = 1; round <= kRounds; ++round) {
            if (round % 2) {
                ASSERT_EQ(cuStreamWriteValue32(streams[thread], mine, round, 0), CUDA_SUCCESS);
                ASSERT_EQ(
                    cuStreamWaitValue32(streams[thread], next, round, CU_STREAM_WAIT_VALUE_GEQ),
                    CUDA_SUCCESS);
            } else {
                CUstreamBatchMemOpParams batch[2] = {};
                batch[0].writeValue = {CU_STREAM_MEM_OP_WRITE_VALUE_32, mine, {round}, 0, 0};
                batch[1].waitValue = {
                    CU_STREAM_MEM_OP_WAIT_VALUE_32, next, {round}, CU_STREAM_WAIT_VALUE_GEQ, 0};
                ASSERT_EQ(cuStreamBatchMemOp(streams[thread], 2, batch, 0), CUDA_SUCCESS);
            }
        }
    });
    EXPECT_EQ(cuCtxSynchronize(), CUDA_SUCCESS);
    for (unsigned i = 0; i < kThreads; ++i)
        EXPECT_EQ(word(i), kRounds);
}

TEST_F(Threads, ShareEventsAndTheLegacyStream) {
    CUevent events[2] = {};
    for (CUevent& event : events)
        ASSERT_EQ(cuEventCreate(&event, 0), CUDA_SUCCESS);
    onAll([&](unsigned thread) {
        for (unsigned round = 0; round < kRounds; ++round) {
            const CUevent event = events[round % 2], other = events[1 - round % 2];
            ASSERT_EQ(cuMemsetD32Async(wordAt(thread), round + 1, 1, streams[thread]),
                      CUDA_SUCCESS);
            ASSERT_EQ(cuEventRecord(event, streams[thread]), CUDA_SUCCESS);
            ASSERT_EQ(cuStreamWaitEvent(streams[thread], other, 0), CUDA_SUCCESS);
            ASSERT_EQ(cuStreamWaitEvent(thread % 2 ? nullptr : CU_STREAM_PER_THREAD, event, 0),
                      CUDA_SUCCESS);
            float milliseconds = 0;
            const CUresult state = cuEventQuery(other),
                           time = cuEventElapsedTime(&milliseconds, other, event);
            EXPECT_TRUE(state == CUDA_SUCCESS || state == CUDA_ERROR_NOT_READY) << state;
            EXPECT_TRUE(time == CUDA_SUCCESS || time == CUDA_ERROR_NOT_READY ||
                        time == CUDA_ERROR_INVALID_HANDLE) // not recorded yet
                << time;
            if (round % 8 == 0) {
                ASSERT_EQ(cuEventSynchronize(event), CUDA_SUCCESS);
            }
        }
        ASSERT_EQ(cuStreamSynchronize(streams[thread]), CUDA_SUCCESS);
        EXPECT_EQ(word(thread), kRounds);
    });
    EXPECT_EQ(cuCtxSynchronize(), CUDA_SUCCESS);
    for (CUevent event : events)
        EXPECT_EQ(cuEventDestroy(event), CUDA_SUCCESS);
}

TEST_F(Threads, CaptureAndLaunchGraphs) {
    const CUlibrary library = load();
    const CUfunction kernel = kernelOf(library);
    CUgraphExec shared = nullptr;
    const auto capture = [&](CUstream stream, unsigned index) {
        CUgraph graph = nullptr;
        CUgraphExec exec = nullptr;
        EXPECT_EQ(cuStreamBeginCapture(stream, CU_STREAM_CAPTURE_MODE_THREAD_LOCAL), CUDA_SUCCESS);
        EXPECT_EQ(add(kernel, wordAt(index), 1, stream), CUDA_SUCCESS);
        EXPECT_EQ(cuMemcpyAsync(wordAt(100 + index), wordAt(index), 4, stream), CUDA_SUCCESS);
        EXPECT_EQ(cuStreamEndCapture(stream, &graph), CUDA_SUCCESS);
        EXPECT_EQ(cuGraphInstantiate(&exec, graph, 0), CUDA_SUCCESS);
        EXPECT_EQ(cuGraphDestroy(graph), CUDA_SUCCESS);
        return exec;
    };
    ASSERT_EQ(add(kernel, wordAt(50), 1, nullptr), CUDA_SUCCESS); // compiles
    shared = capture(streams[0], kThreads);
    onAll([&](unsigned thread) {
        for (unsigned round = 0; round < kRounds / 4; ++round) {
            const CUgraphExec exec = capture(streams[thread], thread);
            ASSERT_EQ(cuGraphLaunch(exec, streams[thread]), CUDA_SUCCESS);
            ASSERT_EQ(cuGraphLaunch(shared, streams[thread]), CUDA_SUCCESS);
            ASSERT_EQ(cuGraphExecDestroy(exec), CUDA_SUCCESS); // runs all the same
        }
    });
    EXPECT_EQ(cuCtxSynchronize(), CUDA_SUCCESS);
    for (unsigned i = 0; i < kThreads; ++i)
        EXPECT_EQ(word(100 + i), kRounds / 4);
    EXPECT_EQ(word(kThreads), kThreads * (kRounds / 4));
    EXPECT_EQ(cuGraphExecDestroy(shared), CUDA_SUCCESS);
    EXPECT_EQ(cuLibraryUnload(library), CUDA_SUCCESS);
}

TEST_F(Threads, MakeAndDestroyContextsStreamsAndMemory) {
    onAll([&](unsigned thread) {
        for (unsigned round = 0; round < kRounds / 4; ++round) {
            CUcontext own = nullptr;
            CUstream stream = nullptr;
            CUdeviceptr pooled = 0, plain = 0;
            ASSERT_EQ(cuCtxCreate_v2(&own, 0, 0), CUDA_SUCCESS);
            ASSERT_EQ(cuStreamCreateWithPriority(&stream, round % 2, -1), CUDA_SUCCESS);
            ASSERT_EQ(cuMemAllocAsync(&pooled, 1000 + thread, stream), CUDA_SUCCESS);
            ASSERT_EQ(cuMemAlloc(&plain, 1000), CUDA_SUCCESS);
            ASSERT_EQ(cuMemsetD8Async(pooled, 3, 1000, stream), CUDA_SUCCESS);
            ASSERT_EQ(cuMemcpyDtoDAsync(plain, pooled, 1000, stream), CUDA_SUCCESS);
            ASSERT_EQ(cuMemFreeAsync(pooled, stream), CUDA_SUCCESS);
            unsigned char last = 0;
            ASSERT_EQ(cuStreamSynchronize(stream), CUDA_SUCCESS);
            ASSERT_EQ(cuMemcpyDtoH(&last, plain + 999, 1), CUDA_SUCCESS);
            EXPECT_EQ(last, 3);
            ASSERT_EQ(cuMemsetD8Async(plain, 4, 1000, stream), CUDA_SUCCESS);
            if (round % 2) {
                ASSERT_EQ(cuStreamDestroy(stream), CUDA_SUCCESS);
            }
            ASSERT_EQ(cuCtxDestroy(own), CUDA_SUCCESS); // with the rest
            CUcontext current = nullptr;
            ASSERT_EQ(cuCtxGetCurrent(&current), CUDA_SUCCESS);
            EXPECT_EQ(current, context);
        }
    });
}

// A thread's default stream may have the address of a destroyed stream, whose handle must stay
// invalid.
TEST_F(Threads, DefaultStreamsHaveNoHandles) {
    std::thread([&] {
        ASSERT_EQ(cuCtxSetCurrent(context), CUDA_SUCCESS);
        CUstream made[8] = {};
        for (CUstream& stream : made)
            ASSERT_EQ(cuStreamCreate(&stream, 0), CUDA_SUCCESS);
        for (const CUstream stream : made)
            ASSERT_EQ(cuStreamDestroy(stream), CUDA_SUCCESS);
        EXPECT_EQ(cuStreamSynchronize(CU_STREAM_PER_THREAD), CUDA_SUCCESS);
        for (const CUstream stream : made) {
            EXPECT_NE(cuStreamQuery(stream), CUDA_SUCCESS);
            EXPECT_NE(cuStreamDestroy(stream), CUDA_SUCCESS);
        }
        EXPECT_EQ(cuMemsetD32Async(memory, 7, 1, CU_STREAM_PER_THREAD), CUDA_SUCCESS);
        EXPECT_EQ(cuStreamSynchronize(CU_STREAM_PER_THREAD), CUDA_SUCCESS);
    }).join();
}

// During its lifetime, the system cannot create threads: the default stack is larger than the
// address space.
class NoThreads {
public:
    NoThreads() {
        pthread_attr_init(&before_);
        pthread_getattr_default_np(&before_);
        pthread_attr_t attributes = before_;
        EXPECT_EQ(pthread_attr_setstacksize(&attributes, size_t(1) << 50), 0);
        EXPECT_EQ(pthread_setattr_default_np(&attributes), 0);
    }
    ~NoThreads() {
        EXPECT_EQ(pthread_setattr_default_np(&before_), 0);
        pthread_attr_destroy(&before_);
    }
    NoThreads(const NoThreads&) = delete;
    NoThreads& operator=(const NoThreads&) = delete;

private:
    pthread_attr_t before_;
};

TEST_F(Threads, WorkOfAStreamWithoutAThreadIsRefused) {
    CUstream stream = nullptr;
    ASSERT_EQ(cuStreamCreate(&stream, CU_STREAM_DEFAULT), CUDA_SUCCESS);
    {
        const NoThreads none;
        EXPECT_EQ(cuMemsetD8Async(memory, 1, 16, stream), CUDA_ERROR_OUT_OF_MEMORY);
        ASSERT_EQ(cuStreamQuery(stream), CUDA_SUCCESS) << "the stream would wait for ever";
    }
    EXPECT_EQ(cuStreamSynchronize(stream), CUDA_SUCCESS);
    EXPECT_EQ(word(0), 0u) << "the refused work ran";
    EXPECT_EQ(cuMemsetD8Async(memory, 2, 4, stream), CUDA_SUCCESS);
    EXPECT_EQ(cuStreamSynchronize(stream), CUDA_SUCCESS);
    EXPECT_EQ(word(0), 0x02020202u);
    EXPECT_EQ(cuStreamDestroy(stream), CUDA_SUCCESS);
}

// The default stream waits for the work of a destroyed blocking stream, and needs no thread for it.
TEST_F(Threads, StreamsAreDestroyedWithoutAThreadOfTheDefaultStream) {
    CUstream stream = nullptr;
    ASSERT_EQ(cuStreamCreate(&stream, CU_STREAM_DEFAULT), CUDA_SUCCESS);
    std::atomic<bool> goesOn{false};
    const auto wait = [](void* flag) {
        while (!static_cast<std::atomic<bool>*>(flag)->load())
            std::this_thread::yield();
    };
    ASSERT_EQ(cuLaunchHostFunc(stream, wait, &goesOn), CUDA_SUCCESS);
    ASSERT_EQ(cuMemsetD8Async(memory, 3, 4, stream), CUDA_SUCCESS);
    {
        const NoThreads none;
        EXPECT_EQ(cuStreamDestroy(stream), CUDA_SUCCESS);
    }
    EXPECT_EQ(cuStreamQuery(nullptr), CUDA_ERROR_NOT_READY);
    goesOn = true;
    EXPECT_EQ(cuStreamSynchronize(nullptr), CUDA_SUCCESS);
    EXPECT_EQ(word(0), 0x03030303u);
}

// Changes of mapped memory wait for queued work, which may wait for another thread's call.
TEST_F(Threads, ChangesOfMappedMemoryLetOtherThreadsCall) {
    constexpr size_t kUnit = size_t(2) << 20;
    CUmemAllocationProp properties = {};
    properties.type = CU_MEM_ALLOCATION_TYPE_PINNED;
    properties.location = {CU_MEM_LOCATION_TYPE_DEVICE, 0};
    CUdeviceptr space = 0;
    CUmemGenericAllocationHandle handle = 0;
    ASSERT_EQ(cuMemAddressReserve(&space, kUnit, 0, 0, 0), CUDA_SUCCESS);
    ASSERT_EQ(cuMemCreate(&handle, kUnit, &properties, 0), CUDA_SUCCESS);
    ASSERT_EQ(cuMemMap(space, kUnit, 0, handle, 0), CUDA_SUCCESS);
    struct {
        std::atomic<bool> waits{false}, isAnswered{false}, isInTime{false};
    } state;
    const auto wait = [](void* data) {
        auto& s = *static_cast<decltype(state)*>(data);
        s.waits = true;
        for (int i = 0; i < 5000 && !s.isAnswered; ++i)
            std::this_thread::sleep_for(std::chrono::milliseconds(1));
        s.isInTime = s.isAnswered.load();
    };
    ASSERT_EQ(cuLaunchHostFunc(streams[0], wait, &state), CUDA_SUCCESS);
    std::thread other([&] {
        EXPECT_EQ(cuCtxSetCurrent(context), CUDA_SUCCESS);
        while (!state.waits)
            std::this_thread::yield();
        std::this_thread::sleep_for(std::chrono::milliseconds(50)); // the other call has begun
        CUmemGenericAllocationHandle second = 0;
        EXPECT_EQ(cuMemCreate(&second, kUnit, &properties, 0), CUDA_SUCCESS);
        EXPECT_EQ(cuMemRelease(second), CUDA_SUCCESS);
        state.isAnswered = true;
    });
    EXPECT_EQ(cuMemUnmap(space, kUnit), CUDA_SUCCESS);
    other.join();
    EXPECT_TRUE(state.isInTime);
    EXPECT_EQ(cuMemRelease(handle), CUDA_SUCCESS);
    EXPECT_EQ(cuMemAddressFree(space, kUnit), CUDA_SUCCESS);
}

// The dynamic loader holds its lock meanwhile.
TEST(ThreadsOfLibraries, StaticObjectsLaunchAndWait) {
    void* const library = dlopen(WAITING_LIBRARY, RTLD_NOW | RTLD_LOCAL);
    ASSERT_NE(library, nullptr) << dlerror();
    EXPECT_EQ(gWaited[0], 64 + 6400);
    EXPECT_EQ(dlclose(library), 0);
    EXPECT_EQ(gWaited[1], 64 + 6400);
}

} // namespace
