// SPDX-License-Identifier: Apache-2.0
// Managed memory through the driver API: queries of advice for ranges, in the forms of CUDA 12 and
// 13; refused calls. Also copies between contexts and the loading of functions.
#include <cuda.h>
#include <gtest/gtest.h>

#include <vector>

namespace {

constexpr size_t kPart = 4096, kBytes = 4 * kPart;
const CUmemLocation kDevice = {CU_MEM_LOCATION_TYPE_DEVICE, 0};
const CUmemLocation kHost = {CU_MEM_LOCATION_TYPE_HOST, 0};
const CUmemLocation kNode = {CU_MEM_LOCATION_TYPE_HOST_NUMA, 0};

class Managed : public testing::Test {
protected:
    void SetUp() override {
        ASSERT_EQ(cuInit(0), CUDA_SUCCESS);
        ASSERT_EQ(cuDevicePrimaryCtxRetain(&context, 0), CUDA_SUCCESS);
        ASSERT_EQ(cuCtxSetCurrent(context), CUDA_SUCCESS);
        ASSERT_EQ(cuMemAllocManaged(&memory, kBytes, CU_MEM_ATTACH_GLOBAL), CUDA_SUCCESS);
    }
    void TearDown() override {
        EXPECT_EQ(cuMemFree(memory), CUDA_SUCCESS);
        EXPECT_EQ(cuCtxSetCurrent(nullptr), CUDA_SUCCESS);
        EXPECT_EQ(cuDevicePrimaryCtxRelease(0), CUDA_SUCCESS);
    }
    static int ask(CUmem_range_attribute attribute, CUdeviceptr address, size_t bytes) {
        int value = 12345;
        EXPECT_EQ(cuMemRangeGetAttribute(&value, 4, attribute, address, bytes), CUDA_SUCCESS);
        return value;
    }
    CUcontext context = nullptr;
    CUdeviceptr memory = 0;
};

TEST_F(Managed, RangesRememberAdvice) {
    EXPECT_EQ(ask(CU_MEM_RANGE_ATTRIBUTE_READ_MOSTLY, memory, kBytes), 0);
    EXPECT_EQ(ask(CU_MEM_RANGE_ATTRIBUTE_PREFERRED_LOCATION, memory, kBytes), CU_DEVICE_INVALID);
    const CUdeviceptr middle = memory + kPart;
    ASSERT_EQ(cuMemAdvise(middle, 2 * kPart, CU_MEM_ADVISE_SET_READ_MOSTLY, {}), CUDA_SUCCESS);
    EXPECT_EQ(ask(CU_MEM_RANGE_ATTRIBUTE_READ_MOSTLY, middle, 2 * kPart), 1);
    EXPECT_EQ(ask(CU_MEM_RANGE_ATTRIBUTE_READ_MOSTLY, middle + 100, 50), 1);
    EXPECT_EQ(ask(CU_MEM_RANGE_ATTRIBUTE_READ_MOSTLY, memory, 2 * kPart), 0);
    EXPECT_EQ(ask(CU_MEM_RANGE_ATTRIBUTE_READ_MOSTLY, middle, 3 * kPart), 0);
    ASSERT_EQ(cuMemAdvise(middle, kPart, CU_MEM_ADVISE_UNSET_READ_MOSTLY, {}), CUDA_SUCCESS);
    EXPECT_EQ(ask(CU_MEM_RANGE_ATTRIBUTE_READ_MOSTLY, middle, kPart), 0);
    EXPECT_EQ(ask(CU_MEM_RANGE_ATTRIBUTE_READ_MOSTLY, middle + kPart, kPart), 1);

    ASSERT_EQ(cuMemAdvise(memory, kBytes, CU_MEM_ADVISE_SET_PREFERRED_LOCATION, kHost),
              CUDA_SUCCESS);
    EXPECT_EQ(ask(CU_MEM_RANGE_ATTRIBUTE_PREFERRED_LOCATION, memory, kBytes), CU_DEVICE_CPU);
    EXPECT_EQ(ask(CU_MEM_RANGE_ATTRIBUTE_PREFERRED_LOCATION_TYPE, memory, kBytes),
              CU_MEM_LOCATION_TYPE_HOST);
    ASSERT_EQ(cuMemAdvise(middle, 1, CU_MEM_ADVISE_SET_PREFERRED_LOCATION, kDevice), CUDA_SUCCESS);
    EXPECT_EQ(ask(CU_MEM_RANGE_ATTRIBUTE_PREFERRED_LOCATION, memory, kBytes), CU_DEVICE_INVALID);
    EXPECT_EQ(ask(CU_MEM_RANGE_ATTRIBUTE_PREFERRED_LOCATION, middle, 1), 0);
    ASSERT_EQ(cuMemAdvise(memory, kBytes, CU_MEM_ADVISE_UNSET_PREFERRED_LOCATION, {}),
              CUDA_SUCCESS);
    EXPECT_EQ(ask(CU_MEM_RANGE_ATTRIBUTE_PREFERRED_LOCATION_TYPE, memory, kBytes),
              CU_MEM_LOCATION_TYPE_INVALID);

    int accessors[3] = {};
    ASSERT_EQ(cuMemAdvise(memory, kBytes, CU_MEM_ADVISE_SET_ACCESSED_BY, kDevice), CUDA_SUCCESS);
    ASSERT_EQ(cuMemAdvise(memory, kPart, CU_MEM_ADVISE_SET_ACCESSED_BY, kHost), CUDA_SUCCESS);
    EXPECT_EQ(
        cuMemRangeGetAttribute(accessors, 12, CU_MEM_RANGE_ATTRIBUTE_ACCESSED_BY, memory, kBytes),
        CUDA_SUCCESS);
    EXPECT_EQ(std::vector<int>(accessors, accessors + 3), std::vector<int>({0, -2, -2}));
    EXPECT_EQ(
        cuMemRangeGetAttribute(accessors, 8, CU_MEM_RANGE_ATTRIBUTE_ACCESSED_BY, memory, kPart),
        CUDA_SUCCESS);
    EXPECT_EQ(std::vector<int>(accessors, accessors + 2), std::vector<int>({-1, 0}));
}

TEST_F(Managed, PrefetchesAreKnownOnceTheyWereMade) {
    CUstream stream = nullptr;
    ASSERT_EQ(cuStreamCreate(&stream, CU_STREAM_NON_BLOCKING), CUDA_SUCCESS);
    EXPECT_EQ(cuMemPrefetchAsync(memory, kBytes, kDevice, 0, stream), CUDA_SUCCESS);
    EXPECT_EQ(cuStreamSynchronize(stream), CUDA_SUCCESS);
    int place = -7, type = -7;
    void* values[] = {&place, &type};
    size_t sizes[] = {4, 4};
    CUmem_range_attribute names[] = {CU_MEM_RANGE_ATTRIBUTE_LAST_PREFETCH_LOCATION,
                                     CU_MEM_RANGE_ATTRIBUTE_LAST_PREFETCH_LOCATION_TYPE};
    EXPECT_EQ(cuMemRangeGetAttributes(values, sizes, names, 2, memory, kBytes), CUDA_SUCCESS);
    EXPECT_EQ(place, 0);
    EXPECT_EQ(type, CU_MEM_LOCATION_TYPE_DEVICE);
    EXPECT_EQ(cuStreamDestroy(stream), CUDA_SUCCESS);
}

TEST_F(Managed, NewMemoryKnowsNothingOfTheOld) {
    for (int i = 0; i < 20; ++i) { // the same address is returned
        CUdeviceptr some = 0;
        ASSERT_EQ(cuMemAllocManaged(&some, kBytes, CU_MEM_ATTACH_GLOBAL), CUDA_SUCCESS);
        EXPECT_EQ(ask(CU_MEM_RANGE_ATTRIBUTE_READ_MOSTLY, some, kBytes), 0);
        EXPECT_EQ(cuMemAdvise(some, kBytes, CU_MEM_ADVISE_SET_READ_MOSTLY, {}), CUDA_SUCCESS);
        EXPECT_EQ(cuMemFree(some), CUDA_SUCCESS);
    }
}

TEST_F(Managed, OlderFormsTakeADevice) {
    CUresult (*advise)(CUdeviceptr, size_t, CUmem_advise, CUdevice) = nullptr;
    CUresult (*prefetch)(CUdeviceptr, size_t, CUdevice, CUstream) = nullptr;
    ASSERT_EQ(cuGetProcAddress("cuMemAdvise", reinterpret_cast<void**>(&advise), 12000, 0, nullptr),
              CUDA_SUCCESS);
    ASSERT_EQ(cuGetProcAddress("cuMemPrefetchAsync", reinterpret_cast<void**>(&prefetch), 12000,
                               CU_GET_PROC_ADDRESS_PER_THREAD_DEFAULT_STREAM, nullptr),
              CUDA_SUCCESS);
    EXPECT_EQ(advise(memory, kBytes, CU_MEM_ADVISE_SET_PREFERRED_LOCATION, CU_DEVICE_CPU),
              CUDA_SUCCESS);
    EXPECT_EQ(ask(CU_MEM_RANGE_ATTRIBUTE_PREFERRED_LOCATION, memory, kBytes), CU_DEVICE_CPU);
    EXPECT_EQ(advise(memory, kBytes, CU_MEM_ADVISE_SET_PREFERRED_LOCATION, 1),
              CUDA_ERROR_INVALID_DEVICE);
    EXPECT_EQ(prefetch(memory, kBytes, 0, nullptr), CUDA_SUCCESS);
    EXPECT_EQ(cuCtxSynchronize(), CUDA_SUCCESS);
    EXPECT_EQ(ask(CU_MEM_RANGE_ATTRIBUTE_LAST_PREFETCH_LOCATION, memory, kBytes), 0);
    EXPECT_EQ(prefetch(memory, kBytes, 5, nullptr), CUDA_ERROR_INVALID_DEVICE);
    // The newer form under the plain name for newer callers.
    CUresult (*advise13)(CUdeviceptr, size_t, CUmem_advise, CUmemLocation) = nullptr;
    ASSERT_EQ(
        cuGetProcAddress("cuMemAdvise", reinterpret_cast<void**>(&advise13), 13000, 0, nullptr),
        CUDA_SUCCESS);
    EXPECT_EQ(advise13(memory, kBytes, CU_MEM_ADVISE_SET_PREFERRED_LOCATION, kNode), CUDA_SUCCESS);
}

TEST_F(Managed, WhatCannotBeAdvised) {
    CUdeviceptr device = 0;
    ASSERT_EQ(cuMemAlloc(&device, 64), CUDA_SUCCESS);
    char ordinary[64] = {};
    const auto readMostly = [](CUdeviceptr address, size_t bytes) {
        return cuMemAdvise(address, bytes, CU_MEM_ADVISE_SET_READ_MOSTLY, {});
    };
    EXPECT_EQ(readMostly(reinterpret_cast<CUdeviceptr>(ordinary), 64), CUDA_SUCCESS);
    EXPECT_EQ(readMostly(device, 64), CUDA_ERROR_INVALID_VALUE);
    EXPECT_EQ(readMostly(memory, kBytes + 1), CUDA_ERROR_INVALID_VALUE);
    EXPECT_EQ(readMostly(memory, ~size_t(0)), CUDA_ERROR_INVALID_VALUE);
    EXPECT_EQ(readMostly(memory, 0), CUDA_ERROR_INVALID_VALUE);
    EXPECT_EQ(readMostly(0, 64), CUDA_ERROR_INVALID_VALUE);
    EXPECT_EQ(readMostly(64, 64), CUDA_ERROR_INVALID_VALUE);
    EXPECT_EQ(cuMemAdvise(memory, 4, CUmem_advise(9), kDevice), CUDA_ERROR_INVALID_VALUE);
    EXPECT_EQ(cuMemAdvise(memory, 4, CU_MEM_ADVISE_SET_ACCESSED_BY, kNode),
              CUDA_ERROR_INVALID_VALUE);
    EXPECT_EQ(cuMemAdvise(memory, 4, CU_MEM_ADVISE_SET_ACCESSED_BY, {}), CUDA_ERROR_INVALID_VALUE);
    EXPECT_EQ(cuMemPrefetchAsync(memory, 4, kDevice, 1, nullptr), CUDA_ERROR_INVALID_VALUE);
    EXPECT_EQ(cuMemPrefetchAsync(memory, 4, {CU_MEM_LOCATION_TYPE_DEVICE, 3}, 0, nullptr),
              CUDA_ERROR_INVALID_DEVICE);
    EXPECT_EQ(cuMemPrefetchAsync(memory, 4, kDevice, 0, reinterpret_cast<CUstream>(0x5550)),
              CUDA_ERROR_INVALID_HANDLE);
    int value = 0;
    const auto ask = [&](void* data, size_t size, int attribute) {
        return cuMemRangeGetAttribute(data, size, CUmem_range_attribute(attribute), memory, 4);
    };
    EXPECT_EQ(ask(nullptr, 4, 1), CUDA_ERROR_INVALID_VALUE);
    EXPECT_EQ(ask(&value, 8, 1), CUDA_ERROR_INVALID_VALUE);
    EXPECT_EQ(ask(&value, 0, 3), CUDA_ERROR_INVALID_VALUE);
    EXPECT_EQ(ask(&value, 4, 99), CUDA_ERROR_INVALID_VALUE);
    EXPECT_EQ(cuMemRangeGetAttributes(nullptr, nullptr, nullptr, 1, memory, 4),
              CUDA_ERROR_INVALID_VALUE);
    EXPECT_EQ(cuMemFree(device), CUDA_SUCCESS);
}

TEST_F(Managed, CopiesBetweenContexts) {
    CUcontext other = nullptr;
    ASSERT_EQ(cuCtxCreate(&other, nullptr, 0, 0), CUDA_SUCCESS);
    ASSERT_EQ(cuCtxPopCurrent(nullptr), CUDA_SUCCESS);
    std::vector<unsigned char> in(60), out(60);
    for (size_t i = 0; i < in.size(); ++i)
        in[i] = static_cast<unsigned char>(i * 3);
    CUDA_MEMCPY3D_PEER copy = {};
    copy.srcMemoryType = CU_MEMORYTYPE_HOST;
    copy.srcHost = in.data();
    copy.srcContext = context;
    copy.dstMemoryType = CU_MEMORYTYPE_DEVICE;
    copy.dstDevice = memory;
    copy.dstContext = other;
    copy.dstPitch = 10;
    copy.WidthInBytes = 5;
    copy.Height = 4;
    copy.Depth = 3;
    EXPECT_EQ(cuMemcpy3DPeer(&copy), CUDA_SUCCESS);
    CUDA_MEMCPY3D_PEER back = copy;
    std::swap(back.srcContext, back.dstContext);
    back.srcMemoryType = CU_MEMORYTYPE_DEVICE;
    back.srcDevice = memory;
    back.srcPitch = 10;
    back.dstMemoryType = CU_MEMORYTYPE_HOST;
    back.dstHost = out.data();
    back.dstPitch = 0;
    EXPECT_EQ(cuMemcpy3DPeerAsync(&back, nullptr), CUDA_SUCCESS);
    EXPECT_EQ(cuCtxSynchronize(), CUDA_SUCCESS);
    EXPECT_EQ(in, out);
    copy.dstContext = reinterpret_cast<CUcontext>(0x1230);
    EXPECT_EQ(cuMemcpy3DPeer(&copy), CUDA_ERROR_INVALID_CONTEXT);
    EXPECT_EQ(cuMemcpy3DPeer(nullptr), CUDA_ERROR_INVALID_VALUE);

    CUdevice device = -1;
    EXPECT_EQ(cuStreamGetDevice(nullptr, &device), CUDA_SUCCESS);
    EXPECT_EQ(device, 0);
    EXPECT_EQ(cuStreamGetDevice(nullptr, nullptr), CUDA_ERROR_INVALID_VALUE);
    EXPECT_EQ(cuCtxGetDevice_v2(&device, other), CUDA_SUCCESS);
    EXPECT_EQ(cuCtxSynchronize_v2(other), CUDA_SUCCESS);
    EXPECT_EQ(cuCtxSynchronize_v2(nullptr), CUDA_SUCCESS);
    EXPECT_EQ(cuCtxDestroy(other), CUDA_SUCCESS);
    EXPECT_EQ(cuCtxGetDevice_v2(&device, other), CUDA_ERROR_INVALID_CONTEXT);
    EXPECT_EQ(cuCtxSynchronize_v2(other), CUDA_ERROR_INVALID_CONTEXT);
}

TEST_F(Managed, FunctionsAreLoadedWhenTheyAreUsed) {
    constexpr char kText[] = ".version 7.0\n.target sm_60\n.address_size 64\n"
                             ".visible .entry a() { ret; }\n.visible .entry b() { ret; }\n";
    CUmoduleLoadingMode mode{};
    EXPECT_EQ(cuModuleGetLoadingMode(&mode), CUDA_SUCCESS);
    EXPECT_EQ(mode, CU_MODULE_LAZY_LOADING);
    EXPECT_EQ(cuModuleGetLoadingMode(nullptr), CUDA_ERROR_INVALID_VALUE);
    CUmodule module = nullptr;
    CUfunction functions[2] = {};
    ASSERT_EQ(cuModuleLoadData(&module, kText), CUDA_SUCCESS);
    ASSERT_EQ(cuModuleEnumerateFunctions(functions, 2, module), CUDA_SUCCESS);
    CUfunctionLoadingState state{};
    EXPECT_EQ(cuFuncIsLoaded(&state, functions[1]), CUDA_SUCCESS);
    EXPECT_EQ(state, CU_FUNCTION_LOADING_STATE_UNLOADED);
    EXPECT_EQ(cuFuncLoad(functions[1]), CUDA_SUCCESS);
    EXPECT_EQ(cuFuncIsLoaded(&state, functions[1]), CUDA_SUCCESS);
    EXPECT_EQ(state, CU_FUNCTION_LOADING_STATE_LOADED);
    EXPECT_EQ(cuFuncIsLoaded(&state, functions[0]), CUDA_SUCCESS);
    EXPECT_EQ(state, CU_FUNCTION_LOADING_STATE_UNLOADED);
    EXPECT_EQ(cuFuncIsLoaded(nullptr, functions[0]), CUDA_ERROR_INVALID_VALUE);
    EXPECT_EQ(cuModuleUnload(module), CUDA_SUCCESS);
    EXPECT_EQ(cuFuncLoad(functions[0]), CUDA_ERROR_INVALID_HANDLE);
}

// Looking up a function does not compile it, because programs look up hundreds of kernels at their
// start.
TEST_F(Managed, LookingUpAFunctionDoesNotCompileIt) {
    constexpr char kText[] = ".version 7.0\n.target sm_60\n.address_size 64\n"
                             ".visible .entry a(.param .u32 x) { ret; }\n";
    CUmodule module = nullptr;
    CUfunction function = nullptr;
    ASSERT_EQ(cuModuleLoadData(&module, kText), CUDA_SUCCESS);
    ASSERT_EQ(cuModuleGetFunction(&function, module, "a"), CUDA_SUCCESS);
    const char* name = nullptr;
    size_t offset = 0, size = 0;
    int value = 0;
    EXPECT_EQ(cuFuncGetName(&name, function), CUDA_SUCCESS);
    EXPECT_EQ(cuFuncGetParamInfo(function, 0, &offset, &size), CUDA_SUCCESS);
    EXPECT_EQ(cuFuncSetCacheConfig(function, CU_FUNC_CACHE_PREFER_L1), CUDA_SUCCESS);
    EXPECT_EQ(cuFuncGetAttribute(&value, CU_FUNC_ATTRIBUTE_MAX_THREADS_PER_BLOCK, function),
              CUDA_SUCCESS);
    CUfunctionLoadingState state{};
    EXPECT_EQ(cuFuncIsLoaded(&state, function), CUDA_SUCCESS);
    EXPECT_EQ(state, CU_FUNCTION_LOADING_STATE_UNLOADED);
    unsigned x = 0;
    void* parameters[] = {&x};
    EXPECT_EQ(cuLaunchKernel(function, 1, 1, 1, 1, 1, 1, 0, nullptr, parameters, nullptr),
              CUDA_SUCCESS);
    EXPECT_EQ(cuFuncIsLoaded(&state, function), CUDA_SUCCESS);
    EXPECT_EQ(state, CU_FUNCTION_LOADING_STATE_LOADED);
    EXPECT_EQ(cuModuleUnload(module), CUDA_SUCCESS);
}

} // namespace
