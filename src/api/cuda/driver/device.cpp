// SPDX-License-Identifier: Apache-2.0
// The one device: the host processor. Attributes by which programs size their work have the values
// of a mid-sized GPU of compute capability 7.5; attributes of memory are the machine's own.
#include "api/cuda/driver/modules/image_limits.h"
#include "api/cuda/driver/shell.h"
#include "api/cuda/driver/visible_devices.h"

#include "base/threads/threads.h"

#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <cstring>

using namespace sunstone;
using namespace sunstone::api::cuda;

namespace {

constexpr char kBusId[] = "0000:00:00.0";

struct Attribute {
    CUdevice_attribute name;
    int value;
};

// Attributes that are the same on all machines.
constexpr Attribute kAttributes[] = {
    {CU_DEVICE_ATTRIBUTE_MAX_THREADS_PER_BLOCK, kMaxThreads},
    {CU_DEVICE_ATTRIBUTE_MAX_BLOCK_DIM_X, kMaxBlock[0]},
    {CU_DEVICE_ATTRIBUTE_MAX_BLOCK_DIM_Y, kMaxBlock[1]},
    {CU_DEVICE_ATTRIBUTE_MAX_BLOCK_DIM_Z, kMaxBlock[2]},
    {CU_DEVICE_ATTRIBUTE_MAX_GRID_DIM_X, kMaxGrid[0]},
    {CU_DEVICE_ATTRIBUTE_MAX_GRID_DIM_Y, kMaxGrid[1]},
    {CU_DEVICE_ATTRIBUTE_MAX_GRID_DIM_Z, kMaxGrid[2]},
    {CU_DEVICE_ATTRIBUTE_MAX_SHARED_MEMORY_PER_BLOCK, kSharedPerBlock},
    {CU_DEVICE_ATTRIBUTE_MAX_SHARED_MEMORY_PER_BLOCK_OPTIN, kSharedOptin},
    {CU_DEVICE_ATTRIBUTE_MAX_SHARED_MEMORY_PER_MULTIPROCESSOR, kSharedPerProcessor},
    {CU_DEVICE_ATTRIBUTE_RESERVED_SHARED_MEMORY_PER_BLOCK, kReservedShared},
    {CU_DEVICE_ATTRIBUTE_TOTAL_CONSTANT_MEMORY, 65536},
    {CU_DEVICE_ATTRIBUTE_WARP_SIZE, kWarpSize},
    {CU_DEVICE_ATTRIBUTE_MAX_PITCH, kMaxPitch},
    {CU_DEVICE_ATTRIBUTE_MAX_REGISTERS_PER_BLOCK, kRegisters},
    {CU_DEVICE_ATTRIBUTE_MAX_REGISTERS_PER_MULTIPROCESSOR, kRegisters},
    {CU_DEVICE_ATTRIBUTE_CLOCK_RATE, 2000000},          // kHz
    {CU_DEVICE_ATTRIBUTE_MEMORY_CLOCK_RATE, 3200000},   // kHz
    {CU_DEVICE_ATTRIBUTE_GLOBAL_MEMORY_BUS_WIDTH, 128}, // two channels
    {CU_DEVICE_ATTRIBUTE_TEXTURE_ALIGNMENT, kPitchAlignment},
    {CU_DEVICE_ATTRIBUTE_SURFACE_ALIGNMENT, kPitchAlignment},
    {CU_DEVICE_ATTRIBUTE_TEXTURE_PITCH_ALIGNMENT, 32},
    {CU_DEVICE_ATTRIBUTE_MAX_THREADS_PER_MULTIPROCESSOR, kThreadsPerProcessor},
    {CU_DEVICE_ATTRIBUTE_MAX_BLOCKS_PER_MULTIPROCESSOR, kBlocksPerProcessor},
    {CU_DEVICE_ATTRIBUTE_COMPUTE_CAPABILITY_MAJOR, kMajor},
    {CU_DEVICE_ATTRIBUTE_COMPUTE_CAPABILITY_MINOR, kMinor},
    {CU_DEVICE_ATTRIBUTE_SINGLE_TO_DOUBLE_PRECISION_PERF_RATIO, 2},
    {CU_DEVICE_ATTRIBUTE_ASYNC_ENGINE_COUNT, 2},
};

// Attributes whose value is 1.
constexpr CUdevice_attribute kAvailable[] = {
    CU_DEVICE_ATTRIBUTE_GPU_OVERLAP,
    CU_DEVICE_ATTRIBUTE_INTEGRATED, // shares memory with the host
    CU_DEVICE_ATTRIBUTE_CAN_MAP_HOST_MEMORY,
    CU_DEVICE_ATTRIBUTE_CONCURRENT_KERNELS,
    CU_DEVICE_ATTRIBUTE_CAN_TEX2D_GATHER,
    CU_DEVICE_ATTRIBUTE_UNIFIED_ADDRESSING,
    CU_DEVICE_ATTRIBUTE_STREAM_PRIORITIES_SUPPORTED,
    CU_DEVICE_ATTRIBUTE_GLOBAL_L1_CACHE_SUPPORTED,
    CU_DEVICE_ATTRIBUTE_LOCAL_L1_CACHE_SUPPORTED,
    CU_DEVICE_ATTRIBUTE_MANAGED_MEMORY,
    CU_DEVICE_ATTRIBUTE_HOST_NATIVE_ATOMIC_SUPPORTED,
    CU_DEVICE_ATTRIBUTE_PAGEABLE_MEMORY_ACCESS,
    CU_DEVICE_ATTRIBUTE_PAGEABLE_MEMORY_ACCESS_USES_HOST_PAGE_TABLES,
    CU_DEVICE_ATTRIBUTE_CONCURRENT_MANAGED_ACCESS,
    CU_DEVICE_ATTRIBUTE_DIRECT_MANAGED_MEM_ACCESS_FROM_HOST,
    CU_DEVICE_ATTRIBUTE_COMPUTE_PREEMPTION_SUPPORTED,
    CU_DEVICE_ATTRIBUTE_CAN_USE_HOST_POINTER_FOR_REGISTERED_MEM,
    CU_DEVICE_ATTRIBUTE_HOST_REGISTER_SUPPORTED,
    CU_DEVICE_ATTRIBUTE_READ_ONLY_HOST_REGISTER_SUPPORTED,
    CU_DEVICE_ATTRIBUTE_MEMORY_POOLS_SUPPORTED,
    CU_DEVICE_ATTRIBUTE_COOPERATIVE_LAUNCH,
    CU_DEVICE_ATTRIBUTE_VIRTUAL_MEMORY_MANAGEMENT_SUPPORTED,
    CU_DEVICE_ATTRIBUTE_HANDLE_TYPE_POSIX_FILE_DESCRIPTOR_SUPPORTED,
    CU_DEVICE_ATTRIBUTE_CAN_USE_64_BIT_STREAM_MEM_OPS,
    CU_DEVICE_ATTRIBUTE_CAN_USE_STREAM_WAIT_VALUE_NOR,
};

// False if the attribute is unknown. Clusters, interoperation and sparse arrays are not available:
// their attributes are 0.
bool attributeValue(int attribute, int& value) {
    if (attribute < 1 || attribute >= CU_DEVICE_ATTRIBUTE_MAX)
        return false;
    value = 0;
    if (attribute == CU_DEVICE_ATTRIBUTE_MULTIPROCESSOR_COUNT)
        value = int(threadCount());
    else if (attribute == CU_DEVICE_ATTRIBUTE_L2_CACHE_SIZE)
        value = int(std::max(sysconf(_SC_LEVEL3_CACHE_SIZE), 1L << 20));
    else if (std::find(std::begin(kAvailable), std::end(kAvailable), attribute) !=
             std::end(kAvailable))
        value = 1;
    for (const Attribute& each : kAttributes)
        if (each.name == attribute)
            value = each.value;
    for (const ImageLimit& each : kImageLimits)
        if (each.attribute == attribute)
            value = each.value;
    return true;
}

} // namespace

SUNSTONE_EXPORT CUresult cuDeviceGet(CUdevice* device, int ordinal) {
    return guarded("cuDeviceGet", Needs::kInit, [&] {
        require(device, "device is null");
        requireDevice(ordinal);
        *device = ordinal;
    });
}

SUNSTONE_EXPORT CUresult cuDeviceGetCount(int* count) {
    return guarded("cuDeviceGetCount", Needs::kInit, [&] {
        require(count, "count is null");
        *count = 1;
    });
}

SUNSTONE_EXPORT CUresult cuDeviceGetName(char* name, int length, CUdevice device) {
    return guarded("cuDeviceGetName", Needs::kInit, [&] {
        require(name && length > 0, "name is null or its length not positive");
        requireDevice(device);
        std::snprintf(name, size_t(length), "Sunstone CPU (%u threads)", threadCount());
    });
}

SUNSTONE_EXPORT CUresult cuDeviceGetUuid(CUuuid* uuid, CUdevice device) {
    return guarded("cuDeviceGetUuid", Needs::kInit, [&] {
        require(uuid, "uuid is null");
        requireDevice(device);
        std::memcpy(uuid->bytes, kDeviceUuid, 16);
    });
}
SUNSTONE_EXPORT CUresult cuDeviceGetLuid(char*, unsigned int*, CUdevice) {
    return guarded("cuDeviceGetLuid", Needs::kInit, [] {
        refuse(CUDA_ERROR_NOT_SUPPORTED, "locally unique ids exist on Windows only");
    });
}

SUNSTONE_EXPORT CUresult cuDeviceTotalMem(size_t* bytes, CUdevice device) {
    return guarded("cuDeviceTotalMem", Needs::kInit, [&] {
        require(bytes, "bytes is null");
        requireDevice(device);
        *bytes = cpu::totalMemory();
    });
}

SUNSTONE_EXPORT CUresult cuDeviceGetAttribute(int* value, CUdevice_attribute attribute,
                                              CUdevice device) {
    return guarded("cuDeviceGetAttribute", Needs::kInit, [&] {
        require(value, "value is null");
        requireDevice(device);
        int result = 0;
        if (!attributeValue(int(attribute), result))
            refuse(CUDA_ERROR_INVALID_VALUE, "there is no device attribute ", int(attribute));
        *value = result;
    });
}

SUNSTONE_EXPORT CUresult cuDeviceGetProperties(CUdevprop* properties, CUdevice device) {
    return guarded("cuDeviceGetProperties", Needs::kInit, [&] {
        require(properties, "properties is null");
        requireDevice(device);
        *properties = {};
        properties->maxThreadsPerBlock = kMaxThreads;
        for (int i = 0; i < 3; ++i) {
            properties->maxThreadsDim[i] = int(kMaxBlock[i]);
            properties->maxGridSize[i] = int(kMaxGrid[i]);
        }
        properties->sharedMemPerBlock = kSharedPerBlock;
        properties->totalConstantMemory = 65536;
        properties->SIMDWidth = kWarpSize;
        properties->memPitch = int(kMaxPitch);
        properties->regsPerBlock = kRegisters;
        properties->clockRate = 2000000;
        properties->textureAlign = int(kPitchAlignment);
    });
}

SUNSTONE_EXPORT CUresult cuDeviceComputeCapability(int* major, int* minor, CUdevice device) {
    return guarded("cuDeviceComputeCapability", Needs::kInit, [&] {
        require(major && minor, "major or minor is null");
        requireDevice(device);
        *major = kMajor;
        *minor = kMinor;
    });
}

SUNSTONE_EXPORT CUresult cuDeviceGetPCIBusId(char* id, int length, CUdevice device) {
    return guarded("cuDeviceGetPCIBusId", Needs::kInit, [&] {
        require(id && length >= int(sizeof kBusId), "id is null or too short");
        requireDevice(device);
        std::memcpy(id, kBusId, sizeof kBusId);
    });
}

SUNSTONE_EXPORT CUresult cuDeviceGetByPCIBusId(CUdevice* device, const char* id) {
    return guarded("cuDeviceGetByPCIBusId", Needs::kInit, [&] {
        require(device && id, "device or id is null");
        if (std::strcmp(id, kBusId) != 0 && std::strcmp(id, kBusId + 5) != 0)
            refuse(CUDA_ERROR_INVALID_DEVICE, "no device has the bus id ", id);
        *device = 0;
    });
}

SUNSTONE_EXPORT CUresult cuDeviceCanAccessPeer(int* canAccess, CUdevice device, CUdevice peer) {
    return guarded("cuDeviceCanAccessPeer", Needs::kInit, [&] {
        require(canAccess, "canAccess is null");
        requireDevice(device);
        requireDevice(peer);
        *canAccess = 0; // a device is not its own peer
    });
}
