// SPDX-License-Identifier: Apache-2.0
// The runtime API together with calls of the driver API: sticky errors of a context, and other
// errors.
#include "base/error.h"
#include "device/cpu/stream.h"

#include <cuda.h>
#include <cuda_runtime_api.h>
#include <gtest/gtest.h>

#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <cstdlib>
#include <thread>
#include <vector>

namespace {

constexpr char kTrap[] = ".version 7.0\n.target sm_60\n.address_size 64\n"
                         ".visible .entry stop() { trap; }\n";

class Runtime : public testing::Test {
protected:
    void SetUp() override { ASSERT_EQ(cudaDeviceReset(), cudaSuccess); }
    void TearDown() override { EXPECT_EQ(cudaDeviceReset(), cudaSuccess); }

    // Runs failing device code in the current context.
    static void failDeviceCode() {
        CUmodule module = nullptr;
        CUfunction function = nullptr;
        ASSERT_EQ(cudaFree(nullptr), cudaSuccess); // makes the context
        ASSERT_EQ(cuModuleLoadData(&module, kTrap), CUDA_SUCCESS);
        ASSERT_EQ(cuModuleGetFunction(&function, module, "stop"), CUDA_SUCCESS);
        ASSERT_EQ(cuLaunchKernel(function, 1, 1, 1, 1, 1, 1, 0, nullptr, nullptr, nullptr),
                  CUDA_SUCCESS);
    }
};

TEST_F(Runtime, AnErrorOfDeviceCodeStaysAsLongAsItsContext) {
    failDeviceCode();
    EXPECT_EQ(cudaDeviceSynchronize(), cudaErrorLaunchFailure);
    EXPECT_EQ(cudaGetLastError(), cudaErrorLaunchFailure);
    EXPECT_EQ(cudaPeekAtLastError(), cudaErrorLaunchFailure);
    EXPECT_EQ(cudaGetLastError(), cudaErrorLaunchFailure);
    // The driver API ends it without the runtime's knowledge.
    ASSERT_EQ(cuDevicePrimaryCtxReset(0), CUDA_SUCCESS);
    EXPECT_EQ(cudaPeekAtLastError(), cudaSuccess);
    EXPECT_EQ(cudaGetLastError(), cudaSuccess);
    EXPECT_EQ(cudaFree(nullptr), cudaSuccess);
}

// Older programs check the results of these calls, which have no effect on newer GPUs. The results
// are those of the toolkit's runtime with one H100, except for the stored setting.
TEST_F(Runtime, SettingsOfOlderPrograms) {
    cudaSharedMemConfig config{};
    EXPECT_EQ(cudaDeviceSetSharedMemConfig(cudaSharedMemBankSizeEightByte), cudaSuccess);
    EXPECT_EQ(cudaDeviceGetSharedMemConfig(&config), cudaSuccess);
    EXPECT_EQ(cudaDeviceGetSharedMemConfig(nullptr), cudaErrorInvalidValue);
    EXPECT_EQ(cudaDeviceSetSharedMemConfig(cudaSharedMemConfig(9)), cudaErrorInvalidValue);
    EXPECT_EQ(cudaFuncSetSharedMemConfig(nullptr, cudaSharedMemBankSizeFourByte),
              cudaErrorInvalidDeviceFunction);
    EXPECT_EQ(cudaCtxResetPersistingL2Cache(), cudaSuccess);
    int devices[] = {0, 7};
    EXPECT_EQ(cudaSetValidDevices(devices, 1), cudaSuccess);
    EXPECT_EQ(cudaSetValidDevices(nullptr, 0), cudaSuccess);
    EXPECT_EQ(cudaSetValidDevices(devices, 2), cudaErrorInvalidValue);
    EXPECT_EQ(cudaSetValidDevices(devices, -1), cudaErrorInvalidValue);
    EXPECT_EQ(cudaSetValidDevices(nullptr, 1), cudaErrorInvalidValue);
    EXPECT_EQ(cudaSetValidDevices(devices + 1, 1), cudaErrorInvalidDevice);
    int value = 0;
    EXPECT_EQ(cudaDeviceGetP2PAttribute(&value, cudaDevP2PAttrAccessSupported, 0, 0),
              cudaErrorInvalidDevice);
    size_t texels = 0;
    cudaChannelFormatDesc format = cudaCreateChannelDesc(16, 16, 16, 0, cudaChannelFormatKindFloat);
    EXPECT_EQ(cudaDeviceGetTexture1DLinearMaxWidth(&texels, &format, 0),
              cudaErrorInvalidChannelDescriptor);
    format = cudaCreateChannelDesc(32, 0, 0, 0, cudaChannelFormatKindFloat);
    EXPECT_EQ(cudaDeviceGetTexture1DLinearMaxWidth(&texels, &format, 0), cudaSuccess);
    EXPECT_EQ(texels, size_t(1) << 28);
}

TEST_F(Runtime, AResetByAnotherThreadEndsIt) {
    failDeviceCode();
    EXPECT_EQ(cudaDeviceSynchronize(), cudaErrorLaunchFailure);
    std::thread([] { EXPECT_EQ(cudaDeviceReset(), cudaSuccess); }).join();
    EXPECT_EQ(cudaGetLastError(), cudaSuccess);
    void* memory = nullptr;
    EXPECT_EQ(cudaMalloc(&memory, 64), cudaSuccess);
    EXPECT_EQ(cudaGetLastError(), cudaSuccess);
    EXPECT_EQ(cudaFree(memory), cudaSuccess);
}

TEST_F(Runtime, OtherContextsAreNotConcerned) {
    failDeviceCode();
    EXPECT_EQ(cudaDeviceSynchronize(), cudaErrorLaunchFailure);
    CUcontext other = nullptr;
    ASSERT_EQ(cuCtxCreate(&other, nullptr, 0, 0), CUDA_SUCCESS);
    EXPECT_EQ(cudaGetLastError(), cudaSuccess);
    EXPECT_EQ(cudaDeviceSynchronize(), cudaSuccess);
    ASSERT_EQ(cuCtxDestroy(other), CUDA_SUCCESS);
    // Back in the first one, the next call returns the error.
    EXPECT_EQ(cudaDeviceSynchronize(), cudaErrorLaunchFailure);
    EXPECT_EQ(cudaGetLastError(), cudaErrorLaunchFailure);
}

// A failed launch of ray tracing programs is an error of its stream, returned once.
TEST_F(Runtime, AnErrorOfAStreamIsToldOnce) {
    cudaStream_t stream = nullptr;
    ASSERT_EQ(cudaStreamCreate(&stream), cudaSuccess);
    auto& streams = sunstone::device::cpu::streams();
    streams.submit(streams.find(stream), [] {
        throw sunstone::Error(sunstone::Code::kLaunchFailure, "a program threw an exception");
    });
    EXPECT_EQ(cudaStreamSynchronize(stream), cudaErrorLaunchFailure);
    EXPECT_EQ(cudaPeekAtLastError(), cudaErrorLaunchFailure);
    EXPECT_EQ(cudaGetLastError(), cudaErrorLaunchFailure);
    EXPECT_EQ(cudaGetLastError(), cudaSuccess);
    EXPECT_EQ(cudaStreamSynchronize(stream), cudaSuccess);
    EXPECT_EQ(cudaStreamDestroy(stream), cudaSuccess);
}

TEST_F(Runtime, PlacesOfMemoryAreChecked) {
    void* memory = nullptr;
    ASSERT_EQ(cudaMallocManaged(&memory, 4096, cudaMemAttachGlobal), cudaSuccess);
    const cudaMemLocation device = {cudaMemLocationTypeDevice, 0};
    const cudaMemLocation none = {cudaMemLocationTypeDevice, 1};
    const cudaMemLocation negative = {cudaMemLocationTypeDevice, -1};
    const cudaMemLocation host = {cudaMemLocationTypeHost, 0};
    const cudaMemLocation node = {cudaMemLocationTypeHostNuma, 0};
    const cudaMemLocation garbage = {cudaMemLocationType(77), 0};
    const auto advise = [&](cudaMemoryAdvise advice, cudaMemLocation location) {
        return cudaMemAdvise(memory, 4096, advice, location);
    };
    EXPECT_EQ(advise(cudaMemAdviseSetPreferredLocation, device), cudaSuccess);
    EXPECT_EQ(advise(cudaMemAdviseSetPreferredLocation, node), cudaSuccess);
    EXPECT_EQ(advise(cudaMemAdviseSetPreferredLocation, host), cudaSuccess);
    int preferred = 7, accessor = 7;
    void* values[] = {&preferred, &accessor};
    size_t sizes[] = {4, 4};
    cudaMemRangeAttribute names[] = {cudaMemRangeAttributePreferredLocation,
                                     cudaMemRangeAttributeAccessedBy};
    EXPECT_EQ(cudaMemRangeGetAttribute(&preferred, 4, names[0], memory, 4096), cudaSuccess);
    EXPECT_EQ(preferred, cudaCpuDeviceId);
    EXPECT_EQ(cudaMemRangeGetAttributes(values, sizes, names, 2, memory, 4096), cudaSuccess);
    EXPECT_EQ(accessor, cudaInvalidDeviceId);
    EXPECT_EQ(cudaMemRangeGetAttribute(&preferred, 3, names[0], memory, 4096),
              cudaErrorInvalidValue);
    EXPECT_EQ(advise(cudaMemAdviseSetAccessedBy, host), cudaSuccess);
    EXPECT_EQ(advise(cudaMemAdviseSetReadMostly, garbage), cudaSuccess); // names no place
    EXPECT_EQ(advise(cudaMemAdviseSetPreferredLocation, none), cudaErrorInvalidDevice);
    EXPECT_EQ(advise(cudaMemAdviseSetAccessedBy, negative), cudaErrorInvalidDevice);
    EXPECT_EQ(advise(cudaMemAdviseSetAccessedBy, node), cudaErrorInvalidValue);
    EXPECT_EQ(advise(cudaMemAdviseUnsetAccessedBy, garbage), cudaErrorInvalidValue);
    EXPECT_EQ(cudaMemPrefetchAsync(memory, 4096, device, 0, nullptr), cudaSuccess);
    EXPECT_EQ(cudaMemPrefetchAsync(memory, 4096, host, 0, nullptr), cudaSuccess);
    EXPECT_EQ(cudaMemPrefetchAsync(memory, 4096, none, 0, nullptr), cudaErrorInvalidDevice);
    EXPECT_EQ(cudaMemPrefetchAsync(memory, 4096, garbage, 0, nullptr), cudaErrorInvalidValue);
    EXPECT_EQ(cudaFree(memory), cudaSuccess);
}

TEST_F(Runtime, SetsOfThreeDimensions) {
    cudaPitchedPtr memory = {};
    ASSERT_EQ(cudaMalloc3D(&memory, {10, 4, 3}), cudaSuccess);
    const size_t bytes = memory.pitch * 4 * 3;
    ASSERT_EQ(cudaMemset(memory.ptr, 1, bytes), cudaSuccess);
    EXPECT_EQ(cudaMemset3D(memory, 7, {5, 2, 3}), cudaSuccess);
    std::vector<unsigned char> seen(bytes);
    ASSERT_EQ(cudaMemcpy(seen.data(), memory.ptr, bytes, cudaMemcpyDeviceToHost), cudaSuccess);
    for (size_t z = 0; z < 3; ++z)
        for (size_t y = 0; y < 4; ++y)
            for (size_t x = 0; x < memory.pitch; ++x)
                ASSERT_EQ(int(seen[(z * 4 + y) * memory.pitch + x]), x < 5 && y < 2 ? 7 : 1);
    EXPECT_EQ(cudaMemset3D(memory, 7, {5, 2, 4}), cudaErrorInvalidValue);
    EXPECT_EQ(cudaMemset3D(memory, 7, {memory.pitch + 1, 2, 1}), cudaErrorInvalidValue);
    EXPECT_EQ(cudaMemset3D(memory, 7, {0, 2, 1}), cudaSuccess);
    EXPECT_EQ(cudaMemset3D(memory, 7, {0, 2, SIZE_MAX}), cudaSuccess) << "at once";
    const cudaPitchedPtr endless = {memory.ptr, SIZE_MAX / 2 + 1, 10, 2}; // a slice is 2^64 bytes
    EXPECT_EQ(cudaMemset3D(endless, 7, {5, 1, 2}), cudaErrorInvalidValue);
    EXPECT_EQ(cudaFree(memory.ptr), cudaSuccess);
}

TEST_F(Runtime, CopiesOfArraysAndPeers) {
    const cudaChannelFormatDesc format = {32, 0, 0, 0, cudaChannelFormatKindUnsigned};
    cudaArray_t a = nullptr, b = nullptr;
    ASSERT_EQ(cudaMallocArray(&a, &format, 8, 2), cudaSuccess);
    ASSERT_EQ(cudaMallocArray(&b, &format, 8, 2), cudaSuccess);
    const unsigned in[4] = {11, 12, 13, 14};
    unsigned out[4] = {};
    cudaStream_t stream = nullptr;
    ASSERT_EQ(cudaStreamCreate(&stream), cudaSuccess);
    EXPECT_EQ(cudaMemcpyToArrayAsync(a, 8, 1, in, 16, cudaMemcpyHostToDevice, stream), cudaSuccess);
    EXPECT_EQ(cudaStreamSynchronize(stream), cudaSuccess);
    EXPECT_EQ(cudaMemcpyArrayToArray(b, 4, 0, a, 8, 1, 16, cudaMemcpyDeviceToDevice), cudaSuccess);
    EXPECT_EQ(cudaMemcpyFromArrayAsync(out, b, 4, 0, 16, cudaMemcpyDeviceToHost, stream),
              cudaSuccess);
    EXPECT_EQ(cudaStreamSynchronize(stream), cudaSuccess);
    EXPECT_EQ(out[0], 11u);
    EXPECT_EQ(out[3], 14u);
    EXPECT_EQ(cudaMemcpyArrayToArray(b, 4, 0, a, 8, 1, 16, cudaMemcpyHostToDevice),
              cudaErrorInvalidMemcpyDirection);
    EXPECT_EQ(cudaMemcpyToArrayAsync(a, 24, 1, in, 16, cudaMemcpyHostToDevice, stream),
              cudaErrorInvalidValue);

    // Positions count texels of four bytes; their products do not wrap around.
    cudaMemcpy3DParms far = {};
    far.srcArray = b;
    far.dstPtr = {out, 16, 4, 1};
    far.extent = {2, 1, 1};
    far.kind = cudaMemcpyDeviceToHost;
    EXPECT_EQ(cudaMemcpy3D(&far), cudaSuccess);
    far.srcPos.x = SIZE_MAX / 4 + 1;
    EXPECT_EQ(cudaMemcpy3D(&far), cudaErrorInvalidValue);
    cudaMemcpy3DPeerParms copy = {};
    copy.srcArray = b;
    copy.dstPtr = {out, 16, 4, 1}; // neither of a device nor page-locked
    copy.srcPos = {2, 0, 0};
    copy.extent = {2, 1, 1};
    EXPECT_EQ(cudaMemcpy3DPeer(&copy), cudaErrorInvalidValue);
    void* block = nullptr;
    ASSERT_EQ(cudaMalloc(&block, 16), cudaSuccess);
    copy.dstPtr.ptr = block;
    EXPECT_EQ(cudaMemcpy3DPeer(&copy), cudaSuccess);
    EXPECT_EQ(cudaMemcpy(out, block, 8, cudaMemcpyDeviceToHost), cudaSuccess);
    EXPECT_EQ(out[0], 12u);
    EXPECT_EQ(cudaFree(block), cudaSuccess);
    copy.dstDevice = 1;
    EXPECT_EQ(cudaMemcpy3DPeer(&copy), cudaErrorInvalidDevice);
    EXPECT_EQ(cudaMemcpy3DPeerAsync(nullptr, stream), cudaErrorInvalidValue);
    int device = -1;
    EXPECT_EQ(cudaStreamGetDevice(stream, &device), cudaSuccess);
    EXPECT_EQ(device, 0);
    EXPECT_EQ(cudaStreamDestroy(stream), cudaSuccess);
    EXPECT_EQ(cudaFreeArray(a), cudaSuccess);
    EXPECT_EQ(cudaFreeArray(b), cudaSuccess);
}

// Two libraries have the same inline kernel and variable, whose host stub and shadow are one.
TEST_F(Runtime, WhatIsRegisteredTwiceLivesAsLongAsTheLastFile) {
    static char text[] = ".version 7.0\n.target sm_60\n.address_size 64\n"
                         ".visible .global .align 4 .u32 number;\n"
                         ".visible .global .attribute(.managed) .align 4 .u32 shared;\n"
                         ".visible .entry nothing() { ret; }\n";
    static const char stub = 0;
    static char shadow = 0;
    static void* managed = nullptr;
    const auto add = [] {
        void** const file = __cudaRegisterFatBinary(text);
        __cudaRegisterFunction(file, &stub, nullptr, "nothing", -1, nullptr, nullptr, nullptr,
                               nullptr, nullptr);
        __cudaRegisterVar(file, &shadow, nullptr, "number", 0, 4, 0, 0);
        __cudaRegisterManagedVar(file, &managed, nullptr, "shared", 0, 4, 0, 0);
        return file;
    };
    const auto launch = [](const void* kernel) {
        return cudaLaunchKernel(kernel, dim3(1), dim3(1), nullptr, 0, nullptr);
    };
    const auto address = [](const void* host) {
        void* found = nullptr;
        EXPECT_EQ(cudaGetSymbolAddress(&found, host), cudaSuccess);
        return found;
    };
    cudaKernel_t handle = nullptr, again = nullptr;
    void** const first = add();
    ASSERT_EQ(__cudaGetKernel(&handle, &stub), cudaSuccess);
    void* const number = address(&shadow);
    const void* const shared = managed;
    EXPECT_NE(shared, nullptr);
    void** const second = add();
    EXPECT_EQ(address(&shadow), number);
    EXPECT_EQ(__cudaGetKernel(&again, &stub), cudaSuccess);
    EXPECT_EQ(again, handle) << "a program keeps it";
    EXPECT_EQ(launch(handle), cudaSuccess);
    __cudaUnregisterFatBinary(second);
    EXPECT_EQ(launch(&stub), cudaSuccess);
    EXPECT_EQ(address(&shadow), number);
    void** const third = add();
    EXPECT_TRUE(__cudaInitModule(third));
    EXPECT_EQ(managed, shared);
    __cudaUnregisterFatBinary(first);
    EXPECT_EQ(managed, address(&managed)) << "of the third";
    EXPECT_EQ(launch(handle), cudaSuccess);
    EXPECT_NE(address(&shadow), nullptr);
    __cudaUnregisterFatBinary(third);
    void* none = nullptr;
    EXPECT_EQ(cudaGetSymbolAddress(&none, &shadow), cudaErrorInvalidSymbol);
    EXPECT_EQ(launch(&stub), cudaErrorInvalidDeviceFunction);
    EXPECT_EQ(launch(handle), cudaErrorInvalidDeviceFunction);
    EXPECT_EQ(cudaGetLastError(), cudaErrorInvalidDeviceFunction);
}

TEST_F(Runtime, FunctionsOfTheDriverByName) {
    CUresult (*version)(int*) = nullptr;
    cudaDriverEntryPointQueryResult status{};
    EXPECT_EQ(cudaGetDriverEntryPoint("cuDriverGetVersion", reinterpret_cast<void**>(&version),
                                      cudaEnableDefault, &status),
              cudaSuccess);
    EXPECT_EQ(status, cudaDriverEntryPointSuccess);
    int number = 0;
    ASSERT_TRUE(version);
    EXPECT_EQ(version(&number), CUDA_SUCCESS);
    EXPECT_GE(number, 12000);
    void* found = nullptr;
    EXPECT_EQ(cudaGetDriverEntryPointByVersion("cuMemAlloc", &found, 12000, cudaEnableLegacyStream,
                                               nullptr),
              cudaSuccess);
    EXPECT_TRUE(found);
    EXPECT_EQ(cudaGetDriverEntryPoint("cuNoSuchThing", &found, 0, &status), cudaSuccess);
    EXPECT_EQ(status, cudaDriverEntryPointSymbolNotFound);
    EXPECT_EQ(cudaGetDriverEntryPoint("cuInit", &found, 9, &status), cudaErrorInvalidValue);
    EXPECT_EQ(cudaGetDriverEntryPoint(nullptr, &found, 0, &status), cudaErrorInvalidValue);
    const char* name = nullptr;
    size_t offset = 0;
    EXPECT_EQ(cudaFuncGetName(&name, &number), cudaErrorInvalidDeviceFunction);
    EXPECT_EQ(cudaFuncGetParamInfo(&number, 0, &offset, nullptr), cudaErrorInvalidDeviceFunction);
}

// Exit handlers run after the objects of the main thread, including its default stream, are
// destroyed.
TEST_F(Runtime, ExitHandlersHaveADefaultStreamOfTheirThread) {
    testing::GTEST_FLAG(death_test_style) = "threadsafe";
    static std::atomic<int> count = 0;
    static const auto countUp = [] {
        cudaLaunchHostFunc(
            cudaStreamPerThread, [](void*) { ++count; }, nullptr);
        return cudaStreamSynchronize(cudaStreamPerThread) == cudaSuccess;
    };
    static const auto configure = [] {
        dim3 grid, block;
        size_t shared = 0;
        cudaStream_t stream = nullptr;
        return __cudaPushCallConfiguration(dim3(7), dim3(1), 0, nullptr) == 0 &&
               __cudaPopCallConfiguration(&grid, &block, &shared, &stream) == cudaSuccess &&
               grid.x == 7;
    };
    EXPECT_EXIT(
        {
            alarm(60); // a stream without a thread is waited for without end
            std::atexit([] { std::_Exit(countUp() && configure() && count == 2 ? 7 : 1); });
            std::exit(countUp() && configure() ? 2 : 3);
        },
        testing::ExitedWithCode(7), "");
}

TEST(UserObjects, BelongToGraphs) {
    static std::atomic<int> destroyed = 0;
    cudaUserObject_t object = nullptr;
    cudaGraph_t graph = nullptr;
    ASSERT_EQ(cudaGraphCreate(&graph, 0), cudaSuccess);
    ASSERT_EQ(cudaUserObjectCreate(
                  &object, nullptr, [](void*) { ++destroyed; }, 1, cudaUserObjectNoDestructorSync),
              cudaSuccess);
    EXPECT_EQ(cudaUserObjectRetain(object, 1), cudaSuccess);
    EXPECT_EQ(cudaGraphRetainUserObject(graph, object, 1, cudaGraphUserObjectMove), cudaSuccess);
    EXPECT_EQ(cudaGraphRetainUserObject(graph, object, 1, 0), cudaSuccess);
    EXPECT_EQ(cudaGraphReleaseUserObject(graph, object, 1), cudaSuccess);
    EXPECT_EQ(cudaUserObjectRelease(object, 1), cudaSuccess);
    EXPECT_EQ(destroyed, 0);
    EXPECT_EQ(cudaGraphDestroy(graph), cudaSuccess);
    for (int i = 0; i < 5000 && destroyed == 0; ++i)
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
    EXPECT_EQ(destroyed, 1);
}

TEST(Forks, CallsOfChildrenFail) {
    void* memory = nullptr;
    ASSERT_EQ(cudaMalloc(&memory, 64), cudaSuccess);
    ASSERT_EQ(cudaMemset(memory, 1, 64), cudaSuccess);
    const pid_t child = fork();
    if (child == 0) {
        alarm(20);
        constexpr cudaError_t kRefused = cudaErrorInitializationError;
        void* own = nullptr;
        int others = 0;
        for (const cudaError_t result :
             {cudaMalloc(&own, 64), cudaMemset(memory, 1, 64), cudaDeviceSynchronize(),
              cudaStreamSynchronize(cudaStreamPerThread), cudaFree(memory), cudaDeviceReset(),
              cudaSetDevice(0)})
            others += result != kRefused;
        others += cudaGetLastError() != kRefused;
#if !defined(__SANITIZE_ADDRESS__) && !__has_feature(address_sanitizer)
        std::exit(others); // with the handlers that unregister kernels
#endif
        _exit(others); // exit() would report the other threads' objects as leaks
    }
    int status = 0;
    ASSERT_EQ(waitpid(child, &status, 0), child);
    ASSERT_TRUE(WIFEXITED(status)) << "the child hung";
    EXPECT_EQ(WEXITSTATUS(status), 0);
    EXPECT_EQ(cudaFree(memory), cudaSuccess);
}

// A kernel of a library is accepted in place of a host symbol.
TEST(Libraries, KernelsAreLaunched) {
    constexpr const char* kText = R"(
.version 7.0
.target sm_75
.address_size 64
.visible .entry square(.param .u64 out, .param .u32 value) {
    .reg .u64 %rd<2>;
    .reg .u32 %r<3>;
    ld.param.u64 %rd1, [out];
    ld.param.u32 %r1, [value];
    mul.lo.u32 %r2, %r1, %r1;
    st.global.u32 [%rd1], %r2;
    ret;
}
)";
    cudaLibrary_t library = nullptr;
    cudaKernel_t kernel = nullptr;
    unsigned count = 0;
    ASSERT_EQ(cudaLibraryLoadData(&library, kText, nullptr, nullptr, 0, nullptr, nullptr, 0),
              cudaSuccess);
    EXPECT_EQ(cudaLibraryGetKernelCount(&count, library), cudaSuccess);
    EXPECT_EQ(count, 1u);
    ASSERT_EQ(cudaLibraryGetKernel(&kernel, library, "square"), cudaSuccess);
    unsigned* out = nullptr;
    unsigned value = 12;
    ASSERT_EQ(cudaMallocManaged(reinterpret_cast<void**>(&out), 4, cudaMemAttachGlobal), cudaSuccess);
    void* args[] = {&out, &value};
    EXPECT_EQ(cudaLaunchKernel(kernel, dim3(1), dim3(1), args, 0, nullptr), cudaSuccess);
    EXPECT_EQ(cudaDeviceSynchronize(), cudaSuccess);
    EXPECT_EQ(*out, 144u);
    EXPECT_EQ(cudaKernelSetAttributeForDevice(kernel, cudaFuncAttributeMaxDynamicSharedMemorySize,
                                              60000, 0),
              cudaSuccess);
    EXPECT_EQ(cudaLaunchKernel(kernel, dim3(1), dim3(1), args, 60000, nullptr), cudaSuccess);
    EXPECT_EQ(cudaDeviceSynchronize(), cudaSuccess);
    EXPECT_EQ(cudaLibraryUnload(library), cudaSuccess);
    EXPECT_EQ(cudaLaunchKernel(kernel, dim3(1), dim3(1), args, 0, nullptr),
              cudaErrorInvalidDeviceFunction);
    EXPECT_EQ(cudaGetLastError(), cudaErrorInvalidDeviceFunction);
    EXPECT_EQ(cudaFree(out), cudaSuccess);
}

} // namespace
