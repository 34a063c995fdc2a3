// SPDX-License-Identifier: Apache-2.0
// The driver API without kernels: success, documented errors, null and garbage arguments.
#include <cuda.h>
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <cstring>
#include <thread>
#include <vector>

namespace {

template <class T>
T garbage() {
    // Not a user address on x86-64; low addresses may be mapped (for example by sanitizers).
    return reinterpret_cast<T>(uintptr_t(0xdeadbeefdeadbee8));
}

class Driver : public testing::Test {
protected:
    void SetUp() override {
        ASSERT_EQ(cuInit(0), CUDA_SUCCESS);
        ASSERT_EQ(cuDevicePrimaryCtxRetain(&context, 0), CUDA_SUCCESS);
        ASSERT_EQ(cuCtxSetCurrent(context), CUDA_SUCCESS);
    }
    void TearDown() override {
        EXPECT_EQ(cuCtxSetCurrent(nullptr), CUDA_SUCCESS);
        EXPECT_EQ(cuDevicePrimaryCtxRelease(0), CUDA_SUCCESS);
    }
    CUcontext context = nullptr;
};

TEST_F(Driver, VersionsAndErrors) {
    int version = 0;
    EXPECT_EQ(cuDriverGetVersion(&version), CUDA_SUCCESS);
    EXPECT_EQ(version, 13000);
    EXPECT_EQ(cuDriverGetVersion(nullptr), CUDA_ERROR_INVALID_VALUE);
    EXPECT_EQ(cuInit(1), CUDA_ERROR_INVALID_VALUE);
    const char* text = nullptr;
    EXPECT_EQ(cuGetErrorName(CUDA_ERROR_OUT_OF_MEMORY, &text), CUDA_SUCCESS);
    EXPECT_STREQ(text, "CUDA_ERROR_OUT_OF_MEMORY");
    EXPECT_EQ(cuGetErrorString(CUDA_ERROR_OUT_OF_MEMORY, &text), CUDA_SUCCESS);
    EXPECT_STREQ(text, "out of memory");
    EXPECT_EQ(cuGetErrorName(CUresult(12345), &text), CUDA_ERROR_INVALID_VALUE);
    EXPECT_EQ(text, nullptr);
    EXPECT_EQ(cuGetErrorName(CUDA_SUCCESS, nullptr), CUDA_ERROR_INVALID_VALUE);
}

TEST_F(Driver, Devices) {
    CUdevice device = -1;
    int count = 0, value = 0;
    EXPECT_EQ(cuDeviceGetCount(&count), CUDA_SUCCESS);
    EXPECT_EQ(count, 1);
    EXPECT_EQ(cuDeviceGet(&device, 0), CUDA_SUCCESS);
    EXPECT_EQ(cuDeviceGet(&device, 1), CUDA_ERROR_INVALID_DEVICE);
    EXPECT_EQ(cuDeviceGet(&device, -1), CUDA_ERROR_INVALID_DEVICE);
    EXPECT_EQ(cuDeviceGet(nullptr, 0), CUDA_ERROR_INVALID_VALUE);
    EXPECT_EQ(cuDeviceGetAttribute(&value, CU_DEVICE_ATTRIBUTE_WARP_SIZE, 0), CUDA_SUCCESS);
    EXPECT_EQ(value, 32);
    EXPECT_EQ(cuDeviceGetAttribute(&value, CU_DEVICE_ATTRIBUTE_UNIFIED_ADDRESSING, 0),
              CUDA_SUCCESS);
    EXPECT_EQ(value, 1);
    EXPECT_EQ(cuDeviceGetAttribute(&value, CUdevice_attribute(9999), 0), CUDA_ERROR_INVALID_VALUE);
    EXPECT_EQ(cuDeviceGetAttribute(&value, CU_DEVICE_ATTRIBUTE_WARP_SIZE, 5),
              CUDA_ERROR_INVALID_DEVICE);
    char name[8];
    EXPECT_EQ(cuDeviceGetName(name, sizeof name, 0), CUDA_SUCCESS);
    EXPECT_EQ(std::strlen(name), 7u); // cut off, ended
    EXPECT_EQ(cuDeviceGetName(nullptr, 8, 0), CUDA_ERROR_INVALID_VALUE);
}

int attributeOf(CUdevice_attribute attribute) {
    int value = 0;
    EXPECT_EQ(cuDeviceGetAttribute(&value, attribute, 0), CUDA_SUCCESS) << attribute;
    return value;
}

// Programs refuse images above the limits that the device reports.
TEST_F(Driver, ImageLimits) {
    for (int a = CU_DEVICE_ATTRIBUTE_MAXIMUM_TEXTURE1D_WIDTH;
         a <= CU_DEVICE_ATTRIBUTE_MAXIMUM_TEXTURE2D_LAYERED_LAYERS; ++a)
        EXPECT_GE(attributeOf(CUdevice_attribute(a)), 2048) << a;
    for (int a = CU_DEVICE_ATTRIBUTE_MAXIMUM_TEXTURECUBEMAP_WIDTH;
         a <= CU_DEVICE_ATTRIBUTE_MAXIMUM_TEXTURE2D_MIPMAPPED_HEIGHT; ++a)
        EXPECT_GE(attributeOf(CUdevice_attribute(a)), 2046) << a;
    EXPECT_EQ(attributeOf(CU_DEVICE_ATTRIBUTE_CAN_TEX2D_GATHER), 1);
    using Size = CUDA_ARRAY3D_DESCRIPTOR;
    struct Limit {
        CUdevice_attribute attribute;
        size_t Size::* field;
        size_t others;
        unsigned flags;
    };
    for (const auto& [attribute, field, others, flags] :
         {Limit{CU_DEVICE_ATTRIBUTE_MAXIMUM_TEXTURE1D_WIDTH, &Size::Width, 0, 0},
          Limit{CU_DEVICE_ATTRIBUTE_MAXIMUM_TEXTURE3D_WIDTH, &Size::Width, 2, 0},
          Limit{CU_DEVICE_ATTRIBUTE_MAXIMUM_TEXTURE3D_HEIGHT, &Size::Height, 2, 0},
          Limit{CU_DEVICE_ATTRIBUTE_MAXIMUM_TEXTURE3D_DEPTH, &Size::Depth, 2, 0},
          Limit{CU_DEVICE_ATTRIBUTE_MAXIMUM_TEXTURE3D_DEPTH_ALTERNATE, &Size::Depth, 2, 0},
          Limit{CU_DEVICE_ATTRIBUTE_MAXIMUM_TEXTURE2D_LAYERED_LAYERS, &Size::Depth, 2,
                CUDA_ARRAY3D_LAYERED}}) {
        Size size = {others, others, others, CU_AD_FORMAT_UNSIGNED_INT8, 1, flags};
        size.*field = size_t(attributeOf(attribute));
        CUarray array = nullptr;
        EXPECT_EQ(cuArray3DCreate(&array, &size), CUDA_SUCCESS) << attribute;
        EXPECT_EQ(cuArrayDestroy(array), CUDA_SUCCESS);
    }
}

// The results are those of a driver of version 13.0 with one H100.
TEST_F(Driver, LessCommonQuestions) {
    int value = 77;
    EXPECT_EQ(cuDeviceGetP2PAttribute(&value, CU_DEVICE_P2P_ATTRIBUTE_ACCESS_SUPPORTED, 0, 0),
              CUDA_ERROR_INVALID_DEVICE);
    EXPECT_EQ(cuDeviceGetP2PAttribute(&value, CU_DEVICE_P2P_ATTRIBUTE_ACCESS_SUPPORTED, 0, 5),
              CUDA_ERROR_INVALID_DEVICE);
    EXPECT_EQ(cuDeviceGetP2PAttribute(nullptr, CU_DEVICE_P2P_ATTRIBUTE_ACCESS_SUPPORTED, 0, 0),
              CUDA_ERROR_INVALID_VALUE);
    EXPECT_EQ(value, 77);
    EXPECT_EQ(cuDeviceGetExecAffinitySupport(&value, CU_EXEC_AFFINITY_TYPE_SM_COUNT, 0),
              CUDA_SUCCESS);
    EXPECT_EQ(value, 0);
    EXPECT_EQ(cuCtxResetPersistingL2Cache(), CUDA_SUCCESS);
    size_t texels = 77;
    EXPECT_EQ(cuDeviceGetTexture1DLinearMaxWidth(&texels, CU_AD_FORMAT_FLOAT, 3, 0),
              CUDA_ERROR_INVALID_VALUE);
    EXPECT_EQ(cuDeviceGetTexture1DLinearMaxWidth(&texels, CU_AD_FORMAT_FLOAT, 1, 9),
              CUDA_ERROR_INVALID_DEVICE);
    EXPECT_EQ(cuDeviceGetTexture1DLinearMaxWidth(nullptr, CU_AD_FORMAT_FLOAT, 1, 0),
              CUDA_ERROR_INVALID_VALUE);
    EXPECT_EQ(texels, 77u);
    EXPECT_EQ(cuDeviceGetTexture1DLinearMaxWidth(&texels, CU_AD_FORMAT_FLOAT, 4, 0), CUDA_SUCCESS);
    EXPECT_EQ(texels, size_t(attributeOf(CU_DEVICE_ATTRIBUTE_MAXIMUM_TEXTURE1D_LINEAR_WIDTH)));
}

TEST_F(Driver, Contexts) {
    CUcontext second = nullptr, popped = nullptr, current = nullptr;
    ASSERT_EQ(cuCtxCreate_v2(&second, 0, 0), CUDA_SUCCESS);
    EXPECT_EQ(cuCtxGetCurrent(&current), CUDA_SUCCESS);
    EXPECT_EQ(current, second);
    EXPECT_EQ(cuCtxPopCurrent(&popped), CUDA_SUCCESS);
    EXPECT_EQ(popped, second);
    EXPECT_EQ(cuCtxPushCurrent(second), CUDA_SUCCESS);
    CUdeviceptr memory = 0;
    EXPECT_EQ(cuMemAlloc(&memory, 64), CUDA_SUCCESS);
    EXPECT_EQ(cuCtxDestroy(second), CUDA_SUCCESS);
    EXPECT_EQ(cuCtxDestroy(second), CUDA_ERROR_INVALID_CONTEXT);
    EXPECT_EQ(cuCtxPushCurrent(second), CUDA_ERROR_INVALID_CONTEXT);
    EXPECT_EQ(cuCtxSetCurrent(garbage<CUcontext>()), CUDA_ERROR_INVALID_CONTEXT);
    EXPECT_EQ(cuCtxGetCurrent(&current), CUDA_SUCCESS);
    EXPECT_EQ(current, context);
    EXPECT_EQ(cuMemFree(memory), CUDA_ERROR_INVALID_VALUE); // went with its context
    EXPECT_EQ(cuCtxCreate_v2(&second, 0x1000, 0), CUDA_ERROR_INVALID_VALUE);
    std::thread([] {
        CUdeviceptr p = 0;
        EXPECT_EQ(cuMemAlloc(&p, 16), CUDA_ERROR_INVALID_CONTEXT);
    }).join();
}

TEST_F(Driver, ContextParameters) {
    CUctxCreateParams params{};
    CUcontext made = nullptr;
    ASSERT_EQ(cuCtxCreate(&made, &params, 0, 0), CUDA_SUCCESS) << "all zero asks for nothing";
    EXPECT_EQ(cuCtxDestroy(made), CUDA_SUCCESS);
    params.numExecAffinityParams = 1;
    EXPECT_EQ(cuCtxCreate(&made, &params, 0, 0), CUDA_ERROR_NOT_SUPPORTED);
    params = {};
    params.cigParams = reinterpret_cast<decltype(params.cigParams)>(&params);
    EXPECT_EQ(cuCtxCreate(&made, &params, 0, 0), CUDA_ERROR_NOT_SUPPORTED);
    EXPECT_EQ(cuCtxCreate(&made, garbage<CUctxCreateParams*>(), 0, 0), CUDA_ERROR_INVALID_VALUE);
    CUcontext current = nullptr;
    EXPECT_EQ(cuCtxGetCurrent(&current), CUDA_SUCCESS);
    EXPECT_EQ(current, context) << "refused calls change nothing";
}

TEST_F(Driver, Allocations) {
    CUdeviceptr p = 0;
    EXPECT_EQ(cuMemAlloc(nullptr, 16), CUDA_ERROR_INVALID_VALUE);
    EXPECT_EQ(cuMemAlloc(&p, 0), CUDA_ERROR_INVALID_VALUE);
    EXPECT_EQ(cuMemAlloc(&p, size_t(1) << 60), CUDA_ERROR_OUT_OF_MEMORY);
    ASSERT_EQ(cuMemAlloc(&p, 1000), CUDA_SUCCESS);
    EXPECT_EQ(p % 256, 0u);
    CUdeviceptr base = 0;
    size_t size = 0;
    EXPECT_EQ(cuMemGetAddressRange(&base, &size, p + 999), CUDA_SUCCESS);
    EXPECT_EQ(base, p);
    EXPECT_EQ(size, 1000u);
    EXPECT_EQ(cuMemGetAddressRange(&base, &size, p + 1000), CUDA_ERROR_NOT_FOUND);
    unsigned type = 0;
    EXPECT_EQ(cuPointerGetAttribute(&type, CU_POINTER_ATTRIBUTE_MEMORY_TYPE, p + 5), CUDA_SUCCESS);
    EXPECT_EQ(type, unsigned(CU_MEMORYTYPE_DEVICE));
    EXPECT_EQ(cuPointerGetAttribute(&type, CUpointer_attribute(999), p), CUDA_ERROR_INVALID_VALUE);
    EXPECT_EQ(cuMemFree(p + 1), CUDA_ERROR_INVALID_VALUE);
    EXPECT_EQ(cuMemFree(p), CUDA_SUCCESS);
    EXPECT_EQ(cuMemFree(p), CUDA_ERROR_INVALID_VALUE);
    EXPECT_EQ(cuMemFree(0), CUDA_SUCCESS);
    size_t pitch = 0;
    EXPECT_EQ(cuMemAllocPitch(&p, &pitch, 100, 10, 3), CUDA_ERROR_INVALID_VALUE);
    ASSERT_EQ(cuMemAllocPitch(&p, &pitch, 100, 10, 4), CUDA_SUCCESS);
    EXPECT_GE(pitch, 100u);
    EXPECT_EQ(cuMemFree(p), CUDA_SUCCESS);
    std::vector<char> own(8192);
    EXPECT_EQ(cuMemHostRegister(own.data(), own.size(), 0), CUDA_SUCCESS);
    EXPECT_EQ(cuMemHostRegister(own.data(), 16, 0), CUDA_ERROR_HOST_MEMORY_ALREADY_REGISTERED);
    EXPECT_EQ(cuMemHostUnregister(own.data()), CUDA_SUCCESS);
    EXPECT_EQ(cuMemHostUnregister(own.data()), CUDA_ERROR_HOST_MEMORY_NOT_REGISTERED);
    EXPECT_EQ(cuMemHostRegister(garbage<void*>(), 16, 0), CUDA_ERROR_INVALID_VALUE);
    void* host = nullptr;
    ASSERT_EQ(cuMemHostAlloc(&host, 64, CU_MEMHOSTALLOC_PORTABLE), CUDA_SUCCESS);
    EXPECT_EQ(cuMemFree(CUdeviceptr(host)), CUDA_ERROR_INVALID_VALUE);
    EXPECT_EQ(cuMemFreeHost(host), CUDA_SUCCESS);
    EXPECT_EQ(cuMemFreeHost(host), CUDA_ERROR_INVALID_VALUE);
}

TEST_F(Driver, CopiesAndSets) {
    CUdeviceptr a = 0, b = 0;
    ASSERT_EQ(cuMemAlloc(&a, 256), CUDA_SUCCESS);
    ASSERT_EQ(cuMemAlloc(&b, 256), CUDA_SUCCESS);
    std::vector<unsigned> host(64), back(64, 0u);
    for (unsigned i = 0; i < 64; ++i)
        host[i] = i * 7;
    EXPECT_EQ(cuMemcpyHtoD(a, host.data(), 256), CUDA_SUCCESS);
    EXPECT_EQ(cuMemcpyDtoD(b, a, 256), CUDA_SUCCESS);
    EXPECT_EQ(cuMemcpyDtoH(back.data(), b, 256), CUDA_SUCCESS);
    EXPECT_EQ(back, host);
    EXPECT_EQ(cuMemcpyHtoD(a, host.data(), 257), CUDA_ERROR_INVALID_VALUE);
    EXPECT_EQ(cuMemcpyHtoD(a + 255, host.data(), 2), CUDA_ERROR_INVALID_VALUE);
    EXPECT_EQ(cuMemcpyHtoD(0, host.data(), 4), CUDA_ERROR_INVALID_VALUE);
    EXPECT_EQ(cuMemcpyHtoD(a, nullptr, 4), CUDA_ERROR_INVALID_VALUE);
    EXPECT_EQ(cuMemcpyHtoD(a, garbage<void*>(), 4), CUDA_ERROR_INVALID_VALUE);
    EXPECT_EQ(cuMemcpyHtoD(CUdeviceptr(back.data()), host.data(), 4), CUDA_ERROR_INVALID_VALUE);
    EXPECT_EQ(cuMemcpyHtoD(a, host.data(), ~size_t(0)), CUDA_ERROR_INVALID_VALUE);
    EXPECT_EQ(cuMemcpyHtoDAsync(a, host.data(), 4, garbage<CUstream>()), CUDA_ERROR_INVALID_HANDLE);
    EXPECT_EQ(cuMemcpyHtoD(a, host.data(), 0), CUDA_SUCCESS);
    EXPECT_EQ(cuMemsetD32(a, 0x01020304u, 64), CUDA_SUCCESS);
    EXPECT_EQ(cuMemsetD16(a, 0xffff, 1), CUDA_SUCCESS);
    EXPECT_EQ(cuMemsetD8(a + 255, 9, 1), CUDA_SUCCESS);
    EXPECT_EQ(cuMemsetD32(a + 1, 0, 1), CUDA_ERROR_INVALID_VALUE);
    EXPECT_EQ(cuMemsetD32(a, 0, 65), CUDA_ERROR_INVALID_VALUE);
    EXPECT_EQ(cuMemcpyDtoH(back.data(), a, 256), CUDA_SUCCESS);
    EXPECT_EQ(back[0], 0x0102ffffu);
    EXPECT_EQ(back[1], 0x01020304u);
    EXPECT_EQ(back[63], 0x09020304u);
    CUDA_MEMCPY2D copy = {};
    copy.srcMemoryType = CU_MEMORYTYPE_HOST;
    copy.srcHost = host.data();
    copy.srcPitch = 16;
    copy.dstMemoryType = CU_MEMORYTYPE_DEVICE;
    copy.dstDevice = b;
    copy.dstPitch = 64;
    copy.dstXInBytes = 4;
    copy.WidthInBytes = 8;
    copy.Height = 4;
    EXPECT_EQ(cuMemcpy2D(&copy), CUDA_SUCCESS);
    EXPECT_EQ(cuMemcpyDtoH(back.data(), b, 256), CUDA_SUCCESS);
    EXPECT_EQ(back[16 + 1], host[4]);
    EXPECT_EQ(back[48 + 2], host[13]);
    copy.Height = 5;
    EXPECT_EQ(cuMemcpy2D(&copy), CUDA_ERROR_INVALID_VALUE);
    copy.Height = ~size_t(0);
    EXPECT_EQ(cuMemcpy2D(&copy), CUDA_ERROR_INVALID_VALUE);
    EXPECT_EQ(cuMemcpy2D(nullptr), CUDA_ERROR_INVALID_VALUE);
    EXPECT_EQ(cuMemFree(a), CUDA_SUCCESS);
    EXPECT_EQ(cuMemFree(b), CUDA_SUCCESS);
}

void slowly(void* flag) {
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    static_cast<std::atomic<int>*>(flag)->fetch_add(1);
}

// Blocks a stream until it is released.
class Gate {
public:
    ~Gate() {
        open();
        cuCtxSynchronize(); // the stream has left it
    }
    void open() { isOpen_ = true; }
    static void wait(void* gate) {
        while (!static_cast<Gate*>(gate)->isOpen_)
            std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }

private:
    std::atomic<bool> isOpen_{false};
};

void countUp(void* count) {
    static_cast<std::atomic<int>*>(count)->fetch_add(1);
}

TEST_F(Driver, StreamsAreOrderedAndAsynchronous) {
    std::atomic<int> count{0};
    Gate gate;
    CUstream stream = nullptr, other = nullptr;
    ASSERT_EQ(cuStreamCreate(&stream, CU_STREAM_NON_BLOCKING), CUDA_SUCCESS);
    ASSERT_EQ(cuStreamCreate(&other, CU_STREAM_NON_BLOCKING), CUDA_SUCCESS);
    EXPECT_EQ(cuLaunchHostFunc(stream, Gate::wait, &gate), CUDA_SUCCESS);
    EXPECT_EQ(cuLaunchHostFunc(stream, countUp, &count), CUDA_SUCCESS);
    EXPECT_EQ(count, 0);
    EXPECT_EQ(cuStreamQuery(stream), CUDA_ERROR_NOT_READY);
    EXPECT_EQ(cuStreamSynchronize(nullptr), CUDA_SUCCESS); // non-blocking: not waited for
    EXPECT_EQ(count, 0);
    CUevent event = nullptr, untimed = nullptr;
    ASSERT_EQ(cuEventCreate(&event, 0), CUDA_SUCCESS);
    ASSERT_EQ(cuEventCreate(&untimed, CU_EVENT_DISABLE_TIMING), CUDA_SUCCESS);
    EXPECT_EQ(cuEventQuery(event), CUDA_SUCCESS); // never recorded
    EXPECT_EQ(cuEventRecord(event, stream), CUDA_SUCCESS);
    EXPECT_EQ(cuEventQuery(event), CUDA_ERROR_NOT_READY);
    EXPECT_EQ(cuStreamWaitEvent(other, event, 0), CUDA_SUCCESS);
    EXPECT_EQ(cuStreamQuery(other), CUDA_ERROR_NOT_READY);
    EXPECT_EQ(count, 0);
    gate.open();
    EXPECT_EQ(cuStreamSynchronize(other), CUDA_SUCCESS);
    EXPECT_EQ(count, 1);
    float ms = 0;
    EXPECT_EQ(cuEventElapsedTime(&ms, event, untimed), CUDA_ERROR_INVALID_HANDLE);
    EXPECT_EQ(cuEventElapsedTime(&ms, event, event), CUDA_SUCCESS);
    EXPECT_EQ(ms, 0.0f);
    EXPECT_EQ(cuEventDestroy(event), CUDA_SUCCESS);
    EXPECT_EQ(cuEventDestroy(event), CUDA_ERROR_INVALID_HANDLE);
    EXPECT_EQ(cuEventDestroy(untimed), CUDA_SUCCESS);
    EXPECT_EQ(cuEventRecord(garbage<CUevent>(), stream), CUDA_ERROR_INVALID_HANDLE);
    EXPECT_EQ(cuStreamDestroy(stream), CUDA_SUCCESS);
    EXPECT_EQ(cuStreamDestroy(stream), CUDA_ERROR_INVALID_HANDLE);
    EXPECT_EQ(cuStreamDestroy(other), CUDA_SUCCESS);
    EXPECT_EQ(cuStreamCreate(nullptr, 0), CUDA_ERROR_INVALID_VALUE);
    EXPECT_EQ(cuStreamCreate(&stream, 7), CUDA_ERROR_INVALID_VALUE);
}

// A copy of pageable memory returns only when the application may write to the memory again.
TEST_F(Driver, PageableMemoryIsFreeAfterAnAsynchronousCopy) {
    constexpr size_t kCount = 1000;
    std::atomic<int> count{0};
    CUstream stream = nullptr;
    CUdeviceptr memory = 0;
    std::vector<int> host(kCount, 1), back(kCount);
    ASSERT_EQ(cuStreamCreate(&stream, CU_STREAM_NON_BLOCKING), CUDA_SUCCESS);
    ASSERT_EQ(cuMemAlloc(&memory, kCount * sizeof(int)), CUDA_SUCCESS);
    EXPECT_EQ(cuLaunchHostFunc(stream, slowly, &count), CUDA_SUCCESS);
    EXPECT_EQ(cuMemcpyHtoDAsync(memory, host.data(), kCount * sizeof(int), stream), CUDA_SUCCESS);
    host.assign(kCount, 2);
    EXPECT_EQ(cuStreamSynchronize(stream), CUDA_SUCCESS);
    EXPECT_EQ(cuMemcpyDtoH(back.data(), memory, kCount * sizeof(int)), CUDA_SUCCESS);
    EXPECT_EQ(back, std::vector<int>(kCount, 1));
    EXPECT_EQ(cuMemFree(memory), CUDA_SUCCESS);
    EXPECT_EQ(cuStreamDestroy(stream), CUDA_SUCCESS);
}

// Contexts also wait for the work of destroyed streams, because it may use their memory.
TEST_F(Driver, WorkOfDestroyedStreamsIsWaitedFor) {
    std::atomic<int> count{0};
    for (const bool ends : {false, true}) {
        CUcontext own = nullptr;
        CUstream stream = nullptr;
        ASSERT_EQ(cuCtxCreate_v2(&own, 0, 0), CUDA_SUCCESS);
        ASSERT_EQ(cuStreamCreate(&stream, CU_STREAM_NON_BLOCKING), CUDA_SUCCESS);
        EXPECT_EQ(cuLaunchHostFunc(stream, slowly, &count), CUDA_SUCCESS);
        EXPECT_EQ(cuStreamDestroy(stream), CUDA_SUCCESS);
        EXPECT_EQ(ends ? cuCtxDestroy(own) : cuCtxSynchronize(), CUDA_SUCCESS);
        EXPECT_EQ(count, ends ? 2 : 1);
        if (!ends)
            EXPECT_EQ(cuCtxDestroy(own), CUDA_SUCCESS);
    }
}

TEST_F(Driver, LegacyStreamWaitsForBlockingStreams) {
    std::atomic<int> count{0};
    CUstream stream = nullptr;
    ASSERT_EQ(cuStreamCreate(&stream, CU_STREAM_DEFAULT), CUDA_SUCCESS);
    EXPECT_EQ(cuLaunchHostFunc(stream, slowly, &count), CUDA_SUCCESS);
    CUdeviceptr p = 0;
    ASSERT_EQ(cuMemAlloc(&p, 4), CUDA_SUCCESS);
    EXPECT_EQ(cuMemsetD32(p, 1, 1), CUDA_SUCCESS); // on the legacy stream, synchronous
    EXPECT_EQ(count, 1);
    EXPECT_EQ(cuLaunchHostFunc(nullptr, slowly, &count), CUDA_SUCCESS);
    EXPECT_EQ(cuMemsetD32Async(p, 2, 1, stream), CUDA_SUCCESS); // waits for the legacy stream
    EXPECT_EQ(cuStreamSynchronize(stream), CUDA_SUCCESS);
    EXPECT_EQ(count, 2);
    // The thread's own default stream is a blocking one.
    EXPECT_EQ(cuLaunchHostFunc(CU_STREAM_PER_THREAD, slowly, &count), CUDA_SUCCESS);
    EXPECT_EQ(cuStreamSynchronize(CU_STREAM_LEGACY), CUDA_SUCCESS);
    EXPECT_EQ(count, 3);
    // A destroyed stream finishes its work, and the legacy stream still waits for it.
    EXPECT_EQ(cuLaunchHostFunc(stream, slowly, &count), CUDA_SUCCESS);
    EXPECT_EQ(cuStreamDestroy(stream), CUDA_SUCCESS);
    EXPECT_EQ(cuStreamSynchronize(nullptr), CUDA_SUCCESS);
    EXPECT_EQ(count, 4);
    EXPECT_EQ(cuMemFree(p), CUDA_SUCCESS);
}

TEST_F(Driver, ProcAddresses) {
    void* function = nullptr;
    CUdriverProcAddressQueryResult status;
    EXPECT_EQ(cuGetProcAddress("cuMemAlloc", &function, 12000, 0, &status), CUDA_SUCCESS);
    EXPECT_EQ(function, reinterpret_cast<void*>(&cuMemAlloc));
    EXPECT_EQ(cuGetProcAddress("cuNoSuchThing", &function, 12000, 0, &status), CUDA_SUCCESS);
    EXPECT_EQ(status, CU_GET_PROC_ADDRESS_SYMBOL_NOT_FOUND);
    EXPECT_EQ(function, nullptr);
    EXPECT_EQ(cuGetProcAddress("cuNoSuchThing", &function, 12000, 0, nullptr),
              CUDA_ERROR_NOT_FOUND);
    EXPECT_EQ(cuGetProcAddress(nullptr, &function, 12000, 0, nullptr), CUDA_ERROR_INVALID_VALUE);
    EXPECT_EQ(cuGetProcAddress("cuLaunchKernel", &function, 12000,
                               CU_GET_PROC_ADDRESS_PER_THREAD_DEFAULT_STREAM, nullptr),
              CUDA_SUCCESS);
    EXPECT_NE(function, reinterpret_cast<void*>(&cuLaunchKernel));
}

} // namespace
