// SPDX-License-Identifier: Apache-2.0
// Inputs that crash GPU drivers (so that no recording has their answers) are errors here, and
// read-only memory is not written.
#include <cuda.h>
#include <gtest/gtest.h>

#include <cstdint>

namespace {

constexpr size_t kUnit = size_t(2) << 20;

class BadInput : public testing::Test {
protected:
    void SetUp() override {
        ASSERT_EQ(cuInit(0), CUDA_SUCCESS);
        ASSERT_EQ(cuCtxCreate(&context, nullptr, 0, 0), CUDA_SUCCESS);
        ASSERT_EQ(cuMemAlloc(&memory, 4096), CUDA_SUCCESS);
    }
    void TearDown() override { EXPECT_EQ(cuCtxDestroy(context), CUDA_SUCCESS); }

    CUcontext context = nullptr;
    CUdeviceptr memory = 0;
};

TEST_F(BadInput, Copies) {
    EXPECT_EQ(cuMemcpy3DPeer(nullptr), CUDA_ERROR_INVALID_VALUE);
    EXPECT_EQ(cuMemcpy3DPeerAsync(nullptr, nullptr), CUDA_ERROR_INVALID_VALUE);
    EXPECT_EQ(cuMemcpyPeer(memory, context, memory, reinterpret_cast<CUcontext>(12345), 16),
              CUDA_ERROR_INVALID_CONTEXT);
    EXPECT_EQ(cuMemcpy(0, 0, 0), CUDA_SUCCESS);
    EXPECT_EQ(cuMemcpyAsync(0, 0, 0, nullptr), CUDA_SUCCESS);
    EXPECT_EQ(cuMemsetD2D8(memory, 64, 1, 10, SIZE_MAX), CUDA_ERROR_INVALID_VALUE);
    EXPECT_EQ(cuMemsetD32(memory, 1, SIZE_MAX), CUDA_ERROR_INVALID_VALUE);
    CUDA_MEMCPY3D copy = {};
    copy.srcMemoryType = copy.dstMemoryType = CU_MEMORYTYPE_DEVICE;
    copy.srcDevice = copy.dstDevice = memory;
    copy.WidthInBytes = 16;
    copy.Height = copy.Depth = 2;
    copy.srcHeight = SIZE_MAX;
    EXPECT_EQ(cuMemcpy3D(&copy), CUDA_ERROR_INVALID_VALUE);
    copy.srcHeight = 2;
    copy.srcZ = SIZE_MAX;
    EXPECT_EQ(cuMemcpy3D(&copy), CUDA_ERROR_INVALID_VALUE);
    copy.srcZ = 0;
    // An offset beyond an allocation does not access host memory, whatever is mapped there.
    for (const CUmemorytype type : {CU_MEMORYTYPE_UNIFIED, CU_MEMORYTYPE_HOST}) {
        static char host[64] = {};
        void* pinned = nullptr;
        ASSERT_EQ(cuMemAllocHost(&pinned, 4096), CUDA_SUCCESS);
        CUDA_MEMCPY3D outside = {};
        outside.srcMemoryType = outside.dstMemoryType = type;
        outside.srcDevice = memory;
        outside.srcHost = pinned;
        outside.dstHost = host;
        outside.dstDevice = reinterpret_cast<CUdeviceptr>(host);
        outside.WidthInBytes = 16;
        outside.Height = outside.Depth = 1;
        outside.srcXInBytes = 4096;
        EXPECT_EQ(cuMemcpy3D(&outside), CUDA_ERROR_INVALID_VALUE) << type;
        outside.srcXInBytes = 4096 - 16;
        EXPECT_EQ(cuMemcpy3D(&outside), CUDA_SUCCESS) << type;
        EXPECT_EQ(cuMemFreeHost(pinned), CUDA_SUCCESS);
    }
    copy.srcMemoryType = CU_MEMORYTYPE_ARRAY;
    copy.srcArray = reinterpret_cast<CUarray>(&copy);
    EXPECT_EQ(cuMemcpy3D(&copy), CUDA_ERROR_INVALID_HANDLE);
}

TEST_F(BadInput, Names) {
    void* function = nullptr;
    CUdriverProcAddressQueryResult status;
    EXPECT_EQ(cuGetProcAddress(nullptr, &function, 12000, 0, &status), CUDA_ERROR_INVALID_VALUE);
    EXPECT_EQ(cuGetProcAddress("cuInit", nullptr, 12000, 0, &status), CUDA_ERROR_INVALID_VALUE);
}

TEST_F(BadInput, MappedMemory) {
    CUmemAllocationProp properties = {};
    properties.type = CU_MEM_ALLOCATION_TYPE_PINNED;
    properties.location = {CU_MEM_LOCATION_TYPE_DEVICE, 0};
    CUdeviceptr space = 0;
    CUmemGenericAllocationHandle handle = 0;
    ASSERT_EQ(cuMemAddressReserve(&space, kUnit, 0, 0, 0), CUDA_SUCCESS);
    ASSERT_EQ(cuMemCreate(&handle, kUnit, &properties, 0), CUDA_SUCCESS);
    ASSERT_EQ(cuMemMap(space, kUnit, 0, handle, 0), CUDA_SUCCESS);
    CUmemAccessDesc access = {{CU_MEM_LOCATION_TYPE_DEVICE, 0}, CU_MEM_ACCESS_FLAGS_PROT_READWRITE};
    EXPECT_EQ(cuMemSetAccess(space, kUnit, &access, 1), CUDA_SUCCESS);
    EXPECT_EQ(cuMemsetD8(space, 7, kUnit), CUDA_SUCCESS);
    access.flags = CU_MEM_ACCESS_FLAGS_PROT_READ;
    EXPECT_EQ(cuMemSetAccess(space, kUnit, &access, 1), CUDA_SUCCESS);
    EXPECT_EQ(cuMemsetD8(space, 8, 16), CUDA_ERROR_INVALID_VALUE);
    EXPECT_EQ(cuMemcpyDtoD(space, memory, 16), CUDA_ERROR_INVALID_VALUE);
    EXPECT_EQ(cuMemcpyDtoD(memory, space + kUnit - 16, 16), CUDA_SUCCESS);
    unsigned char byte = 0;
    EXPECT_EQ(cuMemcpyDtoH(&byte, memory, 1), CUDA_SUCCESS);
    EXPECT_EQ(byte, 7);
    CUdeviceptr wide = 0;
    ASSERT_EQ(cuMemAddressReserve(&wide, 4 * kUnit, 0, 0, 0), CUDA_SUCCESS);
    ASSERT_EQ(cuMemMap(wide + kUnit, kUnit, 0, handle, 0), CUDA_SUCCESS);
    EXPECT_EQ(cuMemUnmap(wide + 1, 2 * kUnit), CUDA_ERROR_INVALID_VALUE);
    EXPECT_EQ(cuMemUnmap(wide, 2 * kUnit), CUDA_SUCCESS);
    EXPECT_EQ(cuMemAddressFree(wide, 4 * kUnit), CUDA_SUCCESS);
    EXPECT_EQ(cuMemUnmap(space, kUnit), CUDA_SUCCESS);
    EXPECT_EQ(cuMemcpyDtoH(&byte, space, 1), CUDA_ERROR_INVALID_VALUE);
    EXPECT_EQ(cuMemRelease(handle), CUDA_SUCCESS);
    for (CUmemGenericAllocationHandle dead : {handle, CUmemGenericAllocationHandle(12345)}) {
        EXPECT_EQ(cuMemMap(space, kUnit, 0, dead, 0), CUDA_ERROR_INVALID_VALUE);
        EXPECT_EQ(cuMemRelease(dead), CUDA_ERROR_INVALID_VALUE);
        EXPECT_EQ(cuMemGetAllocationPropertiesFromHandle(&properties, dead),
                  CUDA_ERROR_INVALID_VALUE);
    }
    EXPECT_EQ(cuMemAddressFree(space, kUnit), CUDA_SUCCESS);
}

// A program may keep the handle of a destroyed object, whose memory the next object may get.
TEST_F(BadInput, StaleHandles) {
    CUevent stale = nullptr, event = nullptr;
    ASSERT_EQ(cuEventCreate(&stale, 0), CUDA_SUCCESS);
    ASSERT_EQ(cuEventDestroy(stale), CUDA_SUCCESS);
    CUDA_ARRAY_DESCRIPTOR shape = {16, 16, CU_AD_FORMAT_FLOAT, 1};
    CUarray staleArray = nullptr, array = nullptr;
    ASSERT_EQ(cuArrayCreate(&staleArray, &shape), CUDA_SUCCESS);
    ASSERT_EQ(cuArrayDestroy(staleArray), CUDA_SUCCESS);
    CUstream staleStream = nullptr, stream = nullptr;
    ASSERT_EQ(cuStreamCreate(&staleStream, 0), CUDA_SUCCESS);
    ASSERT_EQ(cuStreamDestroy(staleStream), CUDA_SUCCESS);
    for (int i = 0; i < 100; ++i) {
        ASSERT_EQ(cuStreamCreate(&stream, 0), CUDA_SUCCESS);
        ASSERT_NE(cuStreamQuery(staleStream), CUDA_SUCCESS) << i;
        ASSERT_NE(cuStreamDestroy(staleStream), CUDA_SUCCESS) << i;
        ASSERT_EQ(cuStreamDestroy(stream), CUDA_SUCCESS);
        ASSERT_EQ(cuEventCreate(&event, 0), CUDA_SUCCESS);
        ASSERT_EQ(cuArrayCreate(&array, &shape), CUDA_SUCCESS);
        ASSERT_EQ(cuEventQuery(stale), CUDA_ERROR_INVALID_HANDLE) << i;
        ASSERT_EQ(cuEventDestroy(stale), CUDA_ERROR_INVALID_HANDLE) << i;
        ASSERT_EQ(cuArrayGetDescriptor(&shape, staleArray), CUDA_ERROR_INVALID_HANDLE) << i;
        ASSERT_EQ(cuArrayDestroy(array), CUDA_SUCCESS);
        ASSERT_EQ(cuEventDestroy(event), CUDA_SUCCESS);
    }
}

TEST_F(BadInput, References) {
    auto* const reference = reinterpret_cast<CUtexref>(&context);
    EXPECT_EQ(cuTexRefSetFlags(reference, 0), CUDA_ERROR_INVALID_HANDLE);
    EXPECT_EQ(cuTexRefSetArray(reference, nullptr, 0), CUDA_ERROR_INVALID_HANDLE);
    EXPECT_EQ(cuTexRefDestroy(reference), CUDA_ERROR_INVALID_HANDLE);
    EXPECT_EQ(cuSurfRefSetArray(reinterpret_cast<CUsurfref>(&context), nullptr, 0),
              CUDA_ERROR_INVALID_HANDLE);
}

TEST_F(BadInput, NodeAttributes) {
    CUkernelNodeAttrValue value = {};
    EXPECT_EQ(cuGraphKernelNodeSetAttribute(nullptr, CU_LAUNCH_ATTRIBUTE_PRIORITY, &value),
              CUDA_ERROR_INVALID_VALUE);
    EXPECT_EQ(cuGraphKernelNodeGetAttribute(nullptr, CU_LAUNCH_ATTRIBUTE_PRIORITY, nullptr),
              CUDA_ERROR_INVALID_VALUE);
}

} // namespace
