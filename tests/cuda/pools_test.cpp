// SPDX-License-Identifier: Apache-2.0
// Memory pools through the driver API: counts, limits, the device's current pool, errors.
#include <cuda.h>
#include <gtest/gtest.h>

#include <thread>

namespace {

class Pools : public testing::Test {
protected:
    void SetUp() override {
        ASSERT_EQ(cuInit(0), CUDA_SUCCESS);
        ASSERT_EQ(cuDevicePrimaryCtxRetain(&context, 0), CUDA_SUCCESS);
        ASSERT_EQ(cuCtxSetCurrent(context), CUDA_SUCCESS);
        properties.allocType = CU_MEM_ALLOCATION_TYPE_PINNED;
        properties.location = {CU_MEM_LOCATION_TYPE_DEVICE, 0};
    }
    void TearDown() override {
        EXPECT_EQ(cuCtxSetCurrent(nullptr), CUDA_SUCCESS);
        EXPECT_EQ(cuDevicePrimaryCtxRelease(0), CUDA_SUCCESS);
    }
    static cuuint64_t valueOf(CUmemoryPool pool, CUmemPool_attribute attribute) {
        cuuint64_t value = ~cuuint64_t(0);
        EXPECT_EQ(cuMemPoolGetAttribute(pool, attribute, &value), CUDA_SUCCESS);
        return value;
    }
    CUcontext context = nullptr;
    CUmemPoolProps properties = {};
};

TEST_F(Pools, CountWhatIsInUse) {
    CUmemoryPool pool = nullptr;
    ASSERT_EQ(cuMemPoolCreate(&pool, &properties), CUDA_SUCCESS);
    CUdeviceptr a = 0, b = 0;
    ASSERT_EQ(cuMemAllocFromPoolAsync(&a, 1000, pool, nullptr), CUDA_SUCCESS);
    ASSERT_EQ(cuMemAllocFromPoolAsync(&b, 500, pool, nullptr), CUDA_SUCCESS);
    EXPECT_EQ(valueOf(pool, CU_MEMPOOL_ATTR_USED_MEM_CURRENT), 1500u);
    CUmemoryPool of = nullptr;
    EXPECT_EQ(cuPointerGetAttribute(&of, CU_POINTER_ATTRIBUTE_MEMPOOL_HANDLE, a + 10),
              CUDA_SUCCESS);
    EXPECT_EQ(of, pool);
    EXPECT_EQ(cuMemFree(a), CUDA_SUCCESS);
    EXPECT_EQ(valueOf(pool, CU_MEMPOOL_ATTR_USED_MEM_CURRENT), 500u);
    EXPECT_EQ(valueOf(pool, CU_MEMPOOL_ATTR_USED_MEM_HIGH), 1500u);
    cuuint64_t zero = 0;
    EXPECT_EQ(cuMemPoolSetAttribute(pool, CU_MEMPOOL_ATTR_USED_MEM_HIGH, &zero), CUDA_SUCCESS);
    EXPECT_EQ(valueOf(pool, CU_MEMPOOL_ATTR_USED_MEM_HIGH), 500u);
    EXPECT_EQ(cuMemPoolDestroy(pool), CUDA_SUCCESS); // its memory lives on
    EXPECT_EQ(cuMemPoolDestroy(pool), CUDA_ERROR_INVALID_VALUE);
    EXPECT_EQ(cuMemsetD8(b, 1, 500), CUDA_SUCCESS);
    EXPECT_EQ(cuMemFreeAsync(b, nullptr), CUDA_SUCCESS);
    EXPECT_EQ(cuCtxSynchronize(), CUDA_SUCCESS);
}

// Another thread may allocate an address that one thread has just freed, before the pool records
// the free.
TEST_F(Pools, AddressesAreUsedAgain) {
    CUmemoryPool pool = nullptr;
    ASSERT_EQ(cuMemPoolCreate(&pool, &properties), CUDA_SUCCESS);
    const auto work = [&] {
        CUstream stream = nullptr;
        ASSERT_EQ(cuCtxSetCurrent(context), CUDA_SUCCESS);
        ASSERT_EQ(cuStreamCreate(&stream, CU_STREAM_NON_BLOCKING), CUDA_SUCCESS);
        for (int i = 0; i < 1000; ++i) {
            CUdeviceptr address = 0;
            CUmemoryPool of = nullptr;
            ASSERT_EQ(cuMemAllocFromPoolAsync(&address, 4096, pool, stream), CUDA_SUCCESS);
            for (int k = 0; k < 3; ++k) {
                ASSERT_EQ(cuPointerGetAttribute(&of, CU_POINTER_ATTRIBUTE_MEMPOOL_HANDLE, address),
                          CUDA_SUCCESS);
                ASSERT_EQ(of, pool) << i;
            }
            ASSERT_EQ(cuMemFreeAsync(address, stream), CUDA_SUCCESS);
        }
        EXPECT_EQ(cuStreamSynchronize(stream), CUDA_SUCCESS);
        EXPECT_EQ(cuStreamDestroy(stream), CUDA_SUCCESS);
    };
    std::thread other(work);
    work();
    other.join();
    EXPECT_EQ(valueOf(pool, CU_MEMPOOL_ATTR_USED_MEM_CURRENT), 0u);
    EXPECT_EQ(cuMemPoolDestroy(pool), CUDA_SUCCESS);
}

TEST_F(Pools, KeepTheirLimit) {
    CUmemoryPool pool = nullptr;
    properties.maxSize = 4096;
    ASSERT_EQ(cuMemPoolCreate(&pool, &properties), CUDA_SUCCESS);
    CUdeviceptr a = 0, b = 0;
    ASSERT_EQ(cuMemAllocFromPoolAsync(&a, 3000, pool, nullptr), CUDA_SUCCESS);
    EXPECT_EQ(cuMemAllocFromPoolAsync(&b, 2000, pool, nullptr), CUDA_ERROR_OUT_OF_MEMORY);
    EXPECT_EQ(cuMemAllocFromPoolAsync(&b, ~size_t(0), pool, nullptr), CUDA_ERROR_OUT_OF_MEMORY);
    EXPECT_EQ(cuMemFree(a), CUDA_SUCCESS);
    EXPECT_EQ(cuMemAllocFromPoolAsync(&b, 2000, pool, nullptr), CUDA_SUCCESS);
    EXPECT_EQ(cuMemFree(b), CUDA_SUCCESS);
    EXPECT_EQ(cuMemPoolTrimTo(pool, 0), CUDA_SUCCESS);
    EXPECT_EQ(valueOf(pool, CU_MEMPOOL_ATTR_RESERVED_MEM_CURRENT), 0u);
    EXPECT_EQ(cuMemPoolDestroy(pool), CUDA_SUCCESS);
}

TEST_F(Pools, MemoryOfADeadContextIsNotInUse) {
    CUmemoryPool pool = nullptr;
    ASSERT_EQ(cuMemPoolCreate(&pool, &properties), CUDA_SUCCESS);
    CUcontext other = nullptr;
    ASSERT_EQ(cuCtxCreate(&other, nullptr, 0, 0), CUDA_SUCCESS);
    CUdeviceptr a = 0;
    ASSERT_EQ(cuMemAllocFromPoolAsync(&a, 100, pool, nullptr), CUDA_SUCCESS);
    ASSERT_EQ(cuCtxDestroy(other), CUDA_SUCCESS);
    ASSERT_EQ(cuCtxSetCurrent(context), CUDA_SUCCESS);
    EXPECT_EQ(valueOf(pool, CU_MEMPOOL_ATTR_USED_MEM_CURRENT), 0u);
    EXPECT_EQ(cuMemPoolDestroy(pool), CUDA_SUCCESS);
}

TEST_F(Pools, TheDeviceHasACurrentOne) {
    CUmemoryPool standard = nullptr, pool = nullptr, current = nullptr;
    CUmemLocation location = {CU_MEM_LOCATION_TYPE_DEVICE, 0};
    ASSERT_EQ(cuDeviceGetDefaultMemPool(&standard, 0), CUDA_SUCCESS);
    ASSERT_EQ(cuMemGetDefaultMemPool(&current, &location, CU_MEM_ALLOCATION_TYPE_PINNED),
              CUDA_SUCCESS);
    EXPECT_EQ(current, standard);
    ASSERT_EQ(cuMemPoolCreate(&pool, &properties), CUDA_SUCCESS);
    ASSERT_EQ(cuDeviceSetMemPool(0, pool), CUDA_SUCCESS);
    ASSERT_EQ(cuMemGetMemPool(&current, &location, CU_MEM_ALLOCATION_TYPE_PINNED), CUDA_SUCCESS);
    EXPECT_EQ(current, pool);
    CUdeviceptr a = 0;
    ASSERT_EQ(cuMemAllocAsync(&a, 64, nullptr), CUDA_SUCCESS);
    EXPECT_EQ(valueOf(pool, CU_MEMPOOL_ATTR_USED_MEM_CURRENT), 64u);
    EXPECT_EQ(cuMemFreeAsync(a, nullptr), CUDA_SUCCESS);
    EXPECT_EQ(cuCtxSynchronize(), CUDA_SUCCESS);
    EXPECT_EQ(cuMemPoolDestroy(pool), CUDA_SUCCESS); // the default one takes its place
    ASSERT_EQ(cuDeviceGetMemPool(&current, 0), CUDA_SUCCESS);
    EXPECT_EQ(current, standard);
    EXPECT_EQ(cuMemSetMemPool(&location, CU_MEM_ALLOCATION_TYPE_PINNED, standard), CUDA_SUCCESS);
    EXPECT_EQ(cuMemPoolDestroy(standard), CUDA_ERROR_INVALID_VALUE);
}

TEST_F(Pools, RefuseWhatTheManualForbids) {
    CUmemoryPool pool = nullptr, garbage = reinterpret_cast<CUmemoryPool>(0x1230);
    EXPECT_EQ(cuMemPoolCreate(nullptr, &properties), CUDA_ERROR_INVALID_VALUE);
    EXPECT_EQ(cuMemPoolCreate(&pool, nullptr), CUDA_ERROR_INVALID_VALUE);
    CUmemPoolProps wrong = properties;
    wrong.allocType = CU_MEM_ALLOCATION_TYPE_INVALID;
    EXPECT_EQ(cuMemPoolCreate(&pool, &wrong), CUDA_ERROR_INVALID_VALUE);
    wrong = properties;
    wrong.location.id = 5;
    EXPECT_EQ(cuMemPoolCreate(&pool, &wrong), CUDA_ERROR_INVALID_DEVICE);
    wrong = properties;
    wrong.location.type = CUmemLocationType(77);
    EXPECT_EQ(cuMemPoolCreate(&pool, &wrong), CUDA_ERROR_INVALID_VALUE);
    wrong = properties;
    wrong.handleTypes = CU_MEM_HANDLE_TYPE_POSIX_FILE_DESCRIPTOR;
    EXPECT_EQ(cuMemPoolCreate(&pool, &wrong), CUDA_ERROR_NOT_SUPPORTED);
    wrong = properties;
    wrong.reserved[3] = 1;
    EXPECT_EQ(cuMemPoolCreate(&pool, &wrong), CUDA_ERROR_INVALID_VALUE);

    CUdeviceptr a = 0;
    EXPECT_EQ(cuMemAllocFromPoolAsync(&a, 16, garbage, nullptr), CUDA_ERROR_INVALID_VALUE);
    EXPECT_EQ(cuMemAllocFromPoolAsync(&a, 16, nullptr, nullptr), CUDA_ERROR_INVALID_VALUE);
    EXPECT_EQ(cuMemPoolDestroy(garbage), CUDA_ERROR_INVALID_VALUE);
    EXPECT_EQ(cuMemPoolDestroy(nullptr), CUDA_ERROR_INVALID_VALUE);
    EXPECT_EQ(cuMemPoolTrimTo(garbage, 0), CUDA_ERROR_INVALID_VALUE);
    EXPECT_EQ(cuDeviceSetMemPool(0, garbage), CUDA_ERROR_INVALID_VALUE);
    EXPECT_EQ(cuDeviceSetMemPool(9, garbage), CUDA_ERROR_INVALID_DEVICE);
    EXPECT_EQ(cuDeviceGetMemPool(nullptr, 0), CUDA_ERROR_INVALID_VALUE);

    ASSERT_EQ(cuDeviceGetDefaultMemPool(&pool, 0), CUDA_SUCCESS);
    EXPECT_EQ(cuMemAllocFromPoolAsync(&a, 0, pool, nullptr), CUDA_ERROR_INVALID_VALUE);
    cuuint64_t value = 2;
    int number = 7;
    EXPECT_EQ(cuMemPoolSetAttribute(pool, CU_MEMPOOL_ATTR_USED_MEM_CURRENT, &value),
              CUDA_ERROR_INVALID_VALUE);
    EXPECT_EQ(cuMemPoolSetAttribute(pool, CU_MEMPOOL_ATTR_USED_MEM_HIGH, &value),
              CUDA_ERROR_INVALID_VALUE);
    EXPECT_EQ(cuMemPoolSetAttribute(pool, CU_MEMPOOL_ATTR_REUSE_ALLOW_OPPORTUNISTIC, &number),
              CUDA_ERROR_INVALID_VALUE);
    EXPECT_EQ(cuMemPoolGetAttribute(pool, CUmemPool_attribute(99), &value),
              CUDA_ERROR_INVALID_VALUE);
    EXPECT_EQ(cuMemPoolGetAttribute(pool, CU_MEMPOOL_ATTR_USED_MEM_HIGH, nullptr),
              CUDA_ERROR_INVALID_VALUE);

    CUmemAccessDesc access = {{CU_MEM_LOCATION_TYPE_DEVICE, 0}, CU_MEM_ACCESS_FLAGS_PROT_READWRITE};
    EXPECT_EQ(cuMemPoolSetAccess(pool, &access, 1), CUDA_SUCCESS);
    access.flags = CU_MEM_ACCESS_FLAGS_PROT_NONE;
    EXPECT_EQ(cuMemPoolSetAccess(pool, &access, 1), CUDA_ERROR_INVALID_VALUE);
    EXPECT_EQ(cuMemPoolSetAccess(pool, nullptr, 1), CUDA_ERROR_INVALID_VALUE);
    CUmemAccess_flags flags = CU_MEM_ACCESS_FLAGS_PROT_NONE;
    EXPECT_EQ(cuMemPoolGetAccess(&flags, pool, &access.location), CUDA_SUCCESS);
    EXPECT_EQ(flags, CU_MEM_ACCESS_FLAGS_PROT_READWRITE);
}

} // namespace
