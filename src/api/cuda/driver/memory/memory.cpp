// SPDX-License-Identifier: Apache-2.0
// Allocation and pointer queries. Device, pinned and managed memory are all host memory here;
// queries return different values for them.
#include "api/cuda/driver/graphs/graphs.h"
#include "api/cuda/driver/memory/pools.h"
#include "api/cuda/driver/memory/virtual_memory.h"
#include "base/process_end.h"

using namespace sunstone;
using namespace sunstone::api::cuda;
using cpu::MemoryKind;

namespace {

void* pointerOf(CUdeviceptr address) {
    return reinterpret_cast<void*>(address);
}
CUdeviceptr addressOf(const void* pointer) {
    return reinterpret_cast<CUdeviceptr>(pointer);
}

void* allocate(size_t bytes, MemoryKind kind, unsigned flags) {
    cpu::streams().refuseDuringCapture();
    return cpu::memory().allocate(bytes, kind, flags, cpu::contexts().current());
}

CUresult allocateHost(const char* function, void** address, size_t bytes, unsigned flags) {
    return guarded(function, Needs::kContext, [&] {
        require(address, "address is null");
        require((flags & ~7u) == 0, "unknown flags");
        *address = allocate(bytes, MemoryKind::kPinned, flags);
    });
}

cpu::Allocation allocationOf(CUdeviceptr address) {
    auto found = cpu::memory().find(pointerOf(address));
    if (!found)
        refuse(CUDA_ERROR_INVALID_VALUE, "address ", pointerOf(address), " is in no allocation");
    return *found;
}

template <class T>
void store(void* data, T value) {
    *static_cast<T*>(data) = value;
}

// Writes one attribute. False if it does not apply to the memory.
bool pointerAttribute(void* data, CUpointer_attribute attribute, CUdeviceptr address,
                      const cpu::Allocation& memory) {
    const bool host = memory.kind == MemoryKind::kPinned || memory.kind == MemoryKind::kRegistered;
    const bool managed = cpu::isManaged(memory.kind);
    const bool mapped = memory.kind == MemoryKind::kMapped;
    switch (attribute) {
    case CU_POINTER_ATTRIBUTE_CONTEXT:
        store(data, const_cast<void*>(memory.owner));
        return true;
    case CU_POINTER_ATTRIBUTE_MEMORY_TYPE:
        store(data, unsigned(host ? CU_MEMORYTYPE_HOST : CU_MEMORYTYPE_DEVICE));
        return true;
    case CU_POINTER_ATTRIBUTE_DEVICE_POINTER:
        store(data, address);
        return true;
    case CU_POINTER_ATTRIBUTE_HOST_POINTER:
        if (!host && !managed)
            return false;
        store(data, pointerOf(address));
        return true;
    case CU_POINTER_ATTRIBUTE_BUFFER_ID:
        store(data, static_cast<unsigned long long>(memory.id));
        return true;
    case CU_POINTER_ATTRIBUTE_IS_MANAGED:
        store(data, unsigned(managed));
        return true;
    case CU_POINTER_ATTRIBUTE_DEVICE_ORDINAL:
        store(data, 0);
        return true;
    case CU_POINTER_ATTRIBUTE_SYNC_MEMOPS:
    case CU_POINTER_ATTRIBUTE_IS_LEGACY_CUDA_IPC_CAPABLE:
    case CU_POINTER_ATTRIBUTE_IS_GPU_DIRECT_RDMA_CAPABLE:
        store(data, 0u);
        return true;
    case CU_POINTER_ATTRIBUTE_RANGE_START_ADDR:
        store(data, mapped ? reservationOf(address).base : memory.base);
        return true;
    case CU_POINTER_ATTRIBUTE_RANGE_SIZE:
        store(data, mapped ? reservationOf(address).size : memory.size);
        return true;
    case CU_POINTER_ATTRIBUTE_MAPPED:
        store(data, 1u);
        return true;
    case CU_POINTER_ATTRIBUTE_ALLOWED_HANDLE_TYPES:
        store(data, static_cast<unsigned long long>(0));
        return true;
    case CU_POINTER_ATTRIBUTE_ACCESS_FLAGS:
        store(data, mapped ? memory.flags : 3u);
        return true;
    case CU_POINTER_ATTRIBUTE_MEMPOOL_HANDLE:
        store(data, poolOfMemory(memory));
        return true;
    default:
        refuse(CUDA_ERROR_INVALID_VALUE, "pointer attribute ", int(attribute), " is unknown");
    }
}

// The value that cuPointerGetAttributes writes for unknown memory.
void clearAttribute(void* data, CUpointer_attribute attribute) {
    switch (attribute) {
    case CU_POINTER_ATTRIBUTE_MEMORY_TYPE:
    case CU_POINTER_ATTRIBUTE_IS_MANAGED:
    case CU_POINTER_ATTRIBUTE_SYNC_MEMOPS:
    case CU_POINTER_ATTRIBUTE_IS_LEGACY_CUDA_IPC_CAPABLE:
    case CU_POINTER_ATTRIBUTE_IS_GPU_DIRECT_RDMA_CAPABLE:
    case CU_POINTER_ATTRIBUTE_MAPPED:
    case CU_POINTER_ATTRIBUTE_ACCESS_FLAGS:
        store(data, 0u);
        break;
    case CU_POINTER_ATTRIBUTE_DEVICE_ORDINAL:
        store(data, int(CU_DEVICE_INVALID));
        break;
    default:
        store<void*>(data, nullptr);
    }
}

} // namespace

SUNSTONE_EXPORT CUresult cuMemGetInfo(size_t* freeBytes, size_t* total) {
    return guarded("cuMemGetInfo", Needs::kContext, [&] {
        if (freeBytes)
            *freeBytes = cpu::availableMemory();
        if (total)
            *total = cpu::totalMemory();
    });
}

SUNSTONE_EXPORT CUresult cuMemAlloc(CUdeviceptr* address, size_t bytes) {
    return guarded("cuMemAlloc", Needs::kContext, [&] {
        require(address, "address is null");
        *address = addressOf(allocate(bytes, MemoryKind::kDevice, 0));
    });
}

SUNSTONE_EXPORT CUresult cuMemAllocPitch(CUdeviceptr* address, size_t* pitch, size_t widthInBytes,
                                         size_t height, unsigned int elementBytes) {
    return guarded("cuMemAllocPitch", Needs::kContext, [&] {
        require(address && pitch, "address or pitch is null");
        require(elementBytes == 4 || elementBytes == 8 || elementBytes == 16,
                "elementBytes must be 4, 8 or 16");
        require(widthInBytes != 0 && height != 0, "width or height is 0");
        require(widthInBytes <= kMaxPitch, "the width exceeds the largest pitch");
        const size_t row = (widthInBytes + kPitchAlignment - 1) & ~(kPitchAlignment - 1);
        if (height > SIZE_MAX / row)
            refuse(CUDA_ERROR_OUT_OF_MEMORY, height, " rows of ", row, " bytes");
        *address = addressOf(allocate(row * height, MemoryKind::kDevice, 0));
        *pitch = row;
    });
}

SUNSTONE_EXPORT CUresult cuMemFree(CUdeviceptr address) {
    return guarded("cuMemFree", Needs::kObject, [&] {
        if (!address)
            return;
        auto found = cpu::memory().find(pointerOf(address));
        if (!found || found->base != address ||
            (found->kind != MemoryKind::kDevice && found->kind != MemoryKind::kManaged))
            refuse(CUDA_ERROR_INVALID_VALUE, pointerOf(address),
                   " is not the start of a live device allocation");
        cpu::streams().refuseDuringCapture();
        if (isOwnedByGraph(address))
            return;
        const auto free = [&] {
            const bool released = cpu::memory().release(
                pointerOf(address), {MemoryKind::kDevice, MemoryKind::kManaged}, found->id);
            forgetPoolMemory(pointerOf(address), found->id);
            return released;
        };
        // Queued work may still use it: freeing waits for the device, as with a GPU's driver.
        try {
            cpu::streams().synchronizeAll();
        } catch (const ProcessEnds&) {
            throw;
        } catch (...) {
            free();
            throw;
        }
        require(free(), "freed by another thread meanwhile");
    });
}

SUNSTONE_EXPORT CUresult cuMemGetAddressRange(CUdeviceptr* base, size_t* size,
                                              CUdeviceptr address) {
    return guarded("cuMemGetAddressRange", Needs::kContext, [&] {
        auto memory = cpu::memory().find(pointerOf(address));
        if (base)
            *base = 0;
        if (size)
            *size = 0;
        if (!memory || (memory->kind == MemoryKind::kMapped && memory->flags == 0))
            refuse(CUDA_ERROR_NOT_FOUND, pointerOf(address), " is in no allocation");
        if (base)
            *base = memory->base;
        if (size)
            *size = memory->size;
    });
}

SUNSTONE_EXPORT CUresult cuMemAllocHost(void** address, size_t bytes) {
    return allocateHost("cuMemAllocHost", address, bytes, 0);
}
SUNSTONE_EXPORT CUresult cuMemHostAlloc(void** address, size_t bytes, unsigned int flags) {
    return allocateHost("cuMemHostAlloc", address, bytes, flags);
}
SUNSTONE_EXPORT CUresult cuMemFreeHost(void* address) {
    return guarded("cuMemFreeHost", Needs::kObject, [&] {
        auto found = cpu::memory().find(address);
        require(found && found->base == uintptr_t(address) && found->kind == MemoryKind::kPinned,
                "not the start of live page-locked memory");
        cpu::streams().synchronizeAll();
        require(cpu::memory().release(address, {MemoryKind::kPinned}),
                "freed by another thread meanwhile");
    });
}

SUNSTONE_EXPORT CUresult cuMemHostGetDevicePointer(CUdeviceptr* device, void* host,
                                                   unsigned int flags) {
    return guarded("cuMemHostGetDevicePointer", Needs::kContext, [&] {
        require(device && flags == 0, "device is null or flags not 0");
        const cpu::Allocation memory = allocationOf(addressOf(host));
        require(memory.kind == MemoryKind::kPinned || memory.kind == MemoryKind::kRegistered,
                "not page-locked memory");
        *device = addressOf(host);
    });
}

SUNSTONE_EXPORT CUresult cuMemHostGetFlags(unsigned int* flags, void* address) {
    return guarded("cuMemHostGetFlags", Needs::kContext, [&] {
        require(flags, "flags is null");
        const cpu::Allocation memory = allocationOf(addressOf(address));
        require(memory.kind == MemoryKind::kPinned, "not memory of cuMemHostAlloc");
        // All of it is mapped, regardless of the requested flags.
        *flags = memory.flags | CU_MEMHOSTALLOC_DEVICEMAP;
    });
}

SUNSTONE_EXPORT CUresult cuMemHostRegister(void* address, size_t bytes, unsigned int flags) {
    return guarded("cuMemHostRegister", Needs::kContext, [&] {
        require(address && bytes != 0 && (flags & ~15u) == 0,
                "address null, size 0 or unknown flags");
        const bool isReadOnly = flags & CU_MEMHOSTREGISTER_READ_ONLY;
        require(isReadOnly ? cpu::isMappedReadable(address, bytes)
                           : cpu::isMappedReadWrite(address, bytes),
                "the range is not memory of this process with the access asked for");
        if (!cpu::memory().adopt(address, bytes, MemoryKind::kRegistered, flags,
                                 cpu::contexts().current()))
            refuse(CUDA_ERROR_HOST_MEMORY_ALREADY_REGISTERED, address, " + ", bytes,
                   " overlaps known memory");
    });
}
SUNSTONE_EXPORT CUresult cuMemHostUnregister(void* address) {
    return guarded("cuMemHostUnregister", Needs::kObject, [&] {
        require(address, "address is null");
        cpu::streams().synchronizeAll();
        if (!cpu::memory().release(address, {MemoryKind::kRegistered}))
            refuse(CUDA_ERROR_HOST_MEMORY_NOT_REGISTERED, address, " was not registered");
    });
}

SUNSTONE_EXPORT CUresult cuMemAllocManaged(CUdeviceptr* address, size_t bytes, unsigned int flags) {
    return guarded("cuMemAllocManaged", Needs::kContext, [&] {
        require(address, "address is null");
        require(flags == CU_MEM_ATTACH_GLOBAL || flags == CU_MEM_ATTACH_HOST,
                "flags must be CU_MEM_ATTACH_GLOBAL or CU_MEM_ATTACH_HOST");
        *address = addressOf(allocate(bytes, MemoryKind::kManaged, flags));
    });
}

SUNSTONE_EXPORT CUresult cuPointerGetAttribute(void* data, CUpointer_attribute attribute,
                                               CUdeviceptr address) {
    return guarded("cuPointerGetAttribute", Needs::kInit, [&] {
        require(data, "data is null");
        require(pointerAttribute(data, attribute, address, allocationOf(address)),
                "the attribute does not apply to this memory");
    });
}
SUNSTONE_EXPORT CUresult cuPointerGetAttributes(unsigned int count, CUpointer_attribute* attributes,
                                                void** data, CUdeviceptr address) {
    return guarded("cuPointerGetAttributes", Needs::kInit, [&] {
        require(count != 0 && attributes && data, "no attributes, or null arrays");
        auto memory = cpu::memory().find(pointerOf(address));
        for (unsigned i = 0; i < count; ++i) {
            require(data[i], "a data pointer is null");
            if (!memory || !pointerAttribute(data[i], attributes[i], address, *memory))
                clearAttribute(data[i], attributes[i]);
        }
    });
}
SUNSTONE_EXPORT CUresult cuPointerSetAttribute(const void* value, CUpointer_attribute attribute,
                                               CUdeviceptr address) {
    return guarded("cuPointerSetAttribute", Needs::kInit, [&] {
        require(value && attribute == CU_POINTER_ATTRIBUTE_SYNC_MEMOPS,
                "only SYNC_MEMOPS can be set");
        allocationOf(address); // copies are in order anyway, so only check
    });
}
