// SPDX-License-Identifier: Apache-2.0
// See virtual_memory.h. Physical memory is a memory file (memfd). A reservation is a range of the
// device's addresses, without access. Mapping places the file there, still inaccessible; setting
// access makes it accessible. Two mappings of one memory therefore have the same bytes, and the
// file's descriptor shares it with other processes. The error codes were recorded on a GPU.
#include "api/cuda/driver/memory/virtual_memory.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <iterator>
#include <map>

using namespace sunstone;
using namespace sunstone::api::cuda;
using cpu::MemoryKind;

namespace {

constexpr size_t kUnit = size_t(2) << 20; // of sizes and addresses

struct Physical {
    int file = -1;
    size_t bytes = 0;
    CUmemGenericAllocationHandle handle = 0; // no address: programs mix the two up
    CUmemAllocationProp properties = {};

    Physical(int opened, size_t size) : file(opened), bytes(size) {}
    Physical(const Physical&) = delete;
    Physical& operator=(const Physical&) = delete;
    ~Physical() { close(file); }
};
using PhysicalPtr = std::shared_ptr<Physical>;

struct Mapping {
    PhysicalPtr memory;
    unsigned access = CU_MEM_ACCESS_FLAGS_PROT_NONE;
};

struct Handle {
    PhysicalPtr memory;
    unsigned count = 0; // references released by cuMemRelease
};

std::mutex mutex; // guards all variables below
std::map<uintptr_t, size_t>& reservations() {
    static auto* all = new std::map<uintptr_t, size_t>;
    return *all;
}
std::map<uintptr_t, Mapping>& mappings() {
    static auto* all = new std::map<uintptr_t, Mapping>;
    return *all;
}
std::map<CUmemGenericAllocationHandle, Handle>& handles() {
    static auto* all = new std::map<CUmemGenericAllocationHandle, Handle>;
    return *all;
}

CUresult guardedHere(const char* function, const std::function<void()>& body) {
    return guarded(function, Needs::kContext, [&] {
        std::lock_guard lock(mutex);
        body();
    });
}

// Changes memory that queued work may use, after the end of that work. Host functions may call the
// API, or wait for threads that do. The wait therefore holds no lock, and `check` runs again after
// it.
CUresult guardedAfterWork(const char* function, const std::function<void()>& check,
                          const std::function<void()>& change) {
    return guarded(function, Needs::kContext, [&] {
        {
            std::lock_guard lock(mutex);
            check();
        }
        cpu::streams().synchronizeAll();
        std::lock_guard lock(mutex);
        check();
        change();
    });
}

void* pointerOf(uintptr_t address) {
    return reinterpret_cast<void*>(address);
}
bool isWhole(size_t bytes) {
    return bytes != 0 && bytes % kUnit == 0;
}

AddressRange findReservation(uintptr_t address) {
    auto next = reservations().upper_bound(address);
    if (next == reservations().begin())
        return {};
    --next;
    return address - next->first < next->second ? AddressRange{next->first, next->second}
                                                : AddressRange{};
}
std::map<uintptr_t, Mapping>::iterator mappingAt(uintptr_t address) {
    auto next = mappings().upper_bound(address);
    if (next == mappings().begin())
        return mappings().end();
    --next;
    return address - next->first < next->second.memory->bytes ? next : mappings().end();
}

Handle& handleOf(CUmemGenericAllocationHandle handle) {
    const auto found = handles().find(handle);
    if (found == handles().end())
        refuse(CUDA_ERROR_INVALID_VALUE, "no memory has the handle ", handle);
    return found->second;
}
// Adds a reference to the memory's handle.
CUmemGenericAllocationHandle retain(const PhysicalPtr& memory) {
    static CUmemGenericAllocationHandle last = 0; // guarded by mutex
    if (memory->handle == 0)
        memory->handle = ++last;
    Handle& handle = handles()[memory->handle];
    handle.memory = memory;
    ++handle.count;
    return memory->handle;
}

// Places a mapping at its address, with its access rights.
void place(uintptr_t address, const Mapping& mapping) {
    const int rights = (mapping.access & CU_MEM_ACCESS_FLAGS_PROT_READ ? PROT_READ : 0) |
                       (mapping.access & 2 ? PROT_WRITE : 0);
    const size_t bytes = mapping.memory->bytes;
    if (mmap(pointerOf(address), bytes, rights, MAP_SHARED | MAP_FIXED, mapping.memory->file, 0) ==
        MAP_FAILED)
        refuse(CUDA_ERROR_OUT_OF_MEMORY, "mapping ", bytes, " bytes: ", std::strerror(errno));
    cpu::memory().release(pointerOf(address), {MemoryKind::kMapped});
    cpu::memory().adopt(pointerOf(address), bytes, MemoryKind::kMapped, mapping.access, nullptr);
}

void checkProperties(const CUmemAllocationProp& p) {
    require(p.type == CU_MEM_ALLOCATION_TYPE_PINNED, "only pinned memory can be created");
    require(p.location.type >= CU_MEM_LOCATION_TYPE_DEVICE &&
                p.location.type <= CU_MEM_LOCATION_TYPE_HOST_NUMA_CURRENT,
            "the location has no known type");
    if (p.location.type == CU_MEM_LOCATION_TYPE_DEVICE)
        requireDevice(p.location.id);
    require((unsigned(p.requestedHandleTypes) &
             (CU_MEM_HANDLE_TYPE_WIN32 | CU_MEM_HANDLE_TYPE_WIN32_KMT)) == 0,
            "handles of another system are asked for");
    if (p.requestedHandleTypes & CU_MEM_HANDLE_TYPE_FABRIC)
        refuse(CUDA_ERROR_NOT_SUPPORTED, "handles for other machines");
    require(p.allocFlags.compressionType <= CU_MEM_ALLOCATION_COMP_GENERIC,
            "the type of compression is unknown");
}

// The mappings that cover a range without gaps; empty if they do not cover it.
using Mappings = std::vector<std::map<uintptr_t, Mapping>::iterator>;
Mappings mappingsOf(uintptr_t address, size_t bytes) {
    Mappings found;
    uintptr_t at = address;
    while (at < address + bytes) {
        const auto next = mappings().find(at);
        if (next == mappings().end())
            return {};
        found.push_back(next);
        at += next->second.memory->bytes;
    }
    return at == address + bytes ? found : Mappings{};
}

} // namespace

AddressRange sunstone::api::cuda::reservationOf(CUdeviceptr address) {
    std::lock_guard lock(mutex);
    return findReservation(address);
}

SUNSTONE_EXPORT CUresult cuMemGetAllocationGranularity(size_t* bytes,
                                                       const CUmemAllocationProp* properties,
                                                       CUmemAllocationGranularity_flags option) {
    return guarded("cuMemGetAllocationGranularity", Needs::kInit, [&] {
        require(bytes && properties, "bytes or properties is null");
        require(unsigned(option) <= CU_MEM_ALLOC_GRANULARITY_RECOMMENDED, "unknown option");
        *bytes = kUnit;
    });
}

SUNSTONE_EXPORT CUresult cuMemAddressReserve(CUdeviceptr* address, size_t bytes, size_t alignment,
                                             CUdeviceptr hint, unsigned long long flags) {
    return guardedHere("cuMemAddressReserve", [&] {
        require(address && flags == 0, "address is null or flags not 0");
        require(isWhole(bytes), "the size is no multiple of the granularity");
        require((alignment & (alignment - 1)) == 0, "the alignment is no power of two");
        alignment = std::max(alignment, kUnit);
        require(hint % kUnit == 0, "the wanted address is not aligned");
        const uintptr_t base = cpu::memory().reserveAddresses(bytes, alignment, hint);
        reservations()[base] = bytes;
        *address = base;
    });
}

SUNSTONE_EXPORT CUresult cuMemAddressFree(CUdeviceptr address, size_t bytes) {
    return guardedHere("cuMemAddressFree", [&] {
        const auto found = reservations().find(address);
        require(found != reservations().end() && found->second == bytes,
                "no range of this size was reserved there");
        const auto mapped = mappings().lower_bound(address);
        require(mapped == mappings().end() || mapped->first >= address + bytes,
                "memory is mapped in the range");
        reservations().erase(found);
        cpu::memory().freeAddresses(address, bytes);
    });
}

SUNSTONE_EXPORT CUresult cuMemCreate(CUmemGenericAllocationHandle* handle, size_t bytes,
                                     const CUmemAllocationProp* properties,
                                     unsigned long long flags) {
    return guardedHere("cuMemCreate", [&] {
        require(handle && properties && flags == 0, "a pointer is null or flags not 0");
        require(isWhole(bytes), "the size is no multiple of the granularity");
        checkProperties(*properties);
        if (bytes > cpu::totalMemory())
            refuse(CUDA_ERROR_OUT_OF_MEMORY, bytes, " bytes: the device has ", cpu::totalMemory());
        const int file = memfd_create("sunstone memory", MFD_CLOEXEC);
        if (file < 0)
            refuse(CUDA_ERROR_OUT_OF_MEMORY, "a file in memory: ", std::strerror(errno));
        auto memory = std::make_shared<Physical>(file, bytes);
        if (ftruncate(file, off_t(bytes)) != 0)
            refuse(CUDA_ERROR_OUT_OF_MEMORY, bytes, " bytes: ", std::strerror(errno));
        memory->properties = *properties;
        memory->properties.requestedHandleTypes = CUmemAllocationHandleType(
            properties->requestedHandleTypes & CU_MEM_HANDLE_TYPE_POSIX_FILE_DESCRIPTOR);
        memory->properties.allocFlags.usage = 0;
        if (properties->location.type != CU_MEM_LOCATION_TYPE_DEVICE)
            memory->properties.location = {CU_MEM_LOCATION_TYPE_HOST_NUMA, 0};
        *handle = retain(memory);
    });
}

SUNSTONE_EXPORT CUresult cuMemRelease(CUmemGenericAllocationHandle handle) {
    return guardedHere("cuMemRelease", [&] {
        if (--handleOf(handle).count == 0)
            handles().erase(handle);
    });
}

SUNSTONE_EXPORT CUresult cuMemRetainAllocationHandle(CUmemGenericAllocationHandle* handle,
                                                     void* address) {
    return guardedHere("cuMemRetainAllocationHandle", [&] {
        require(handle, "handle is null");
        const auto found = mappingAt(uintptr_t(address));
        require(found != mappings().end(), "nothing is mapped at the address");
        *handle = retain(found->second.memory);
    });
}

SUNSTONE_EXPORT CUresult cuMemGetAllocationPropertiesFromHandle(
    CUmemAllocationProp* properties, CUmemGenericAllocationHandle handle) {
    return guardedHere("cuMemGetAllocationPropertiesFromHandle", [&] {
        require(properties, "properties is null");
        *properties = handleOf(handle).memory->properties;
    });
}

SUNSTONE_EXPORT CUresult cuMemMap(CUdeviceptr address, size_t bytes, size_t offset,
                                  CUmemGenericAllocationHandle handle, unsigned long long flags) {
    return guardedHere("cuMemMap", [&] {
        require(flags == 0 && bytes != 0, "flags are not 0, or the size is");
        const PhysicalPtr memory = handleOf(handle).memory;
        if (offset != 0 || bytes != memory->bytes)
            refuse(CUDA_ERROR_NOT_SUPPORTED, "memory can only be mapped as a whole: ", bytes,
                   " bytes from ", offset, " of ", memory->bytes);
        const AddressRange room = findReservation(address);
        require(address % kUnit == 0, "the address is not aligned to the granularity");
        require(bytes <= room.size && address - room.base <= room.size - bytes,
                "the range is not reserved");
        const auto next = mappings().lower_bound(address);
        require(mappingAt(address) == mappings().end() &&
                    (next == mappings().end() || next->first >= address + bytes),
                "something is mapped in the range");
        const Mapping mapping{memory};
        place(address, mapping);
        mappings()[address] = mapping;
    });
}

SUNSTONE_EXPORT CUresult cuMemUnmap(CUdeviceptr address, size_t bytes) {
    const auto check = [&] {
        const AddressRange room = findReservation(address);
        require(address % kUnit == 0, "the address is not aligned to the granularity");
        require(isWhole(bytes) && bytes <= room.size && address - room.base <= room.size - bytes,
                "the range is not reserved, or no multiple of the granularity");
        // Only whole mappings can be unmapped; gaps between them are ignored.
        const auto cut = [](uintptr_t at) {
            const auto found = mappingAt(at);
            return found != mappings().end() && found->first != at;
        };
        require(!cut(address) && !cut(address + bytes), "the range cuts a mapping");
    };
    return guardedAfterWork("cuMemUnmap", check, [&] {
        mmap(pointerOf(address), bytes, PROT_NONE,
             MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE | MAP_FIXED, -1, 0);
        for (auto it = mappings().lower_bound(address);
             it != mappings().end() && it->first < address + bytes; it = mappings().erase(it))
            cpu::memory().release(pointerOf(it->first), {MemoryKind::kMapped});
    });
}

SUNSTONE_EXPORT CUresult cuMemSetAccess(CUdeviceptr address, size_t bytes,
                                        const CUmemAccessDesc* access, size_t count) {
    Mappings found;
    const auto check = [&] {
        require(access && count != 0 && bytes != 0, "no access descriptions, or size 0");
        found = mappingsOf(address, bytes);
        require(!found.empty(), "the range is not made of whole mappings");
        for (size_t i = 0; i < count; ++i) {
            const CUmemAccessDesc& a = access[i];
            require(a.flags == CU_MEM_ACCESS_FLAGS_PROT_NONE ||
                        a.flags == CU_MEM_ACCESS_FLAGS_PROT_READ ||
                        a.flags == CU_MEM_ACCESS_FLAGS_PROT_READWRITE,
                    "unknown access flags");
            require(a.location.type >= CU_MEM_LOCATION_TYPE_DEVICE &&
                        a.location.type <= CU_MEM_LOCATION_TYPE_HOST_NUMA_CURRENT,
                    "the location has no known type");
            if (a.location.type != CU_MEM_LOCATION_TYPE_DEVICE)
                refuse(CUDA_ERROR_NOT_SUPPORTED, "access by the host");
            require(a.location.id == 0, "there is no such device");
        }
    };
    return guardedAfterWork("cuMemSetAccess", check, [&] {
        for (const auto& mapping : found) {
            mapping->second.access = access[count - 1].flags;
            place(mapping->first, mapping->second);
        }
    });
}

SUNSTONE_EXPORT CUresult cuMemGetAccess(unsigned long long* flags, const CUmemLocation* location,
                                        CUdeviceptr address) {
    return guardedHere("cuMemGetAccess", [&] {
        require(flags && location, "flags or location is null");
        *flags = 0;
        const auto found = mappingAt(address);
        require(found != mappings().end(), "nothing is mapped at the address");
        require(location->type == CU_MEM_LOCATION_TYPE_DEVICE && location->id == 0,
                "there is no such device");
        *flags = found->second.access;
    });
}

SUNSTONE_EXPORT CUresult cuMemExportToShareableHandle(void* shareable,
                                                      CUmemGenericAllocationHandle handle,
                                                      CUmemAllocationHandleType type,
                                                      unsigned long long flags) {
    return guardedHere("cuMemExportToShareableHandle", [&] {
        require(shareable && flags == 0, "shareable is null or flags not 0");
        const PhysicalPtr memory = handleOf(handle).memory;
        require(type == CU_MEM_HANDLE_TYPE_POSIX_FILE_DESCRIPTOR &&
                    (memory->properties.requestedHandleTypes & type),
                "the memory was not created for handles of this type");
        const int file = fcntl(memory->file, F_DUPFD_CLOEXEC, 0);
        if (file < 0)
            refuse(CUDA_ERROR_OUT_OF_MEMORY, "a file descriptor: ", std::strerror(errno));
        *static_cast<int*>(shareable) = file;
    });
}

SUNSTONE_EXPORT CUresult cuMemImportFromShareableHandle(CUmemGenericAllocationHandle* handle,
                                                        void* shareable,
                                                        CUmemAllocationHandleType type) {
    return guardedHere("cuMemImportFromShareableHandle", [&] {
        require(handle, "handle is null");
        if (type != CU_MEM_HANDLE_TYPE_POSIX_FILE_DESCRIPTOR)
            refuse(CUDA_ERROR_NOT_SUPPORTED, "handles of type ", int(type));
        const auto given = int(reinterpret_cast<intptr_t>(shareable));
        struct stat state{};
        // Accepts only files in memory, as exported: no other files have seals.
        if (fcntl(given, F_GET_SEALS) < 0 || fstat(given, &state) != 0 ||
            !isWhole(size_t(state.st_size)))
            refuse(CUDA_ERROR_UNKNOWN, "descriptor ", given, " is not of exported memory");
        for (const auto& [number, known] : handles()) { // already open in this process
            struct stat own{};
            if (fstat(known.memory->file, &own) == 0 && own.st_ino == state.st_ino &&
                own.st_dev == state.st_dev) {
                *handle = retain(known.memory);
                return;
            }
        }
        const int file = fcntl(given, F_DUPFD_CLOEXEC, 0);
        if (file < 0)
            refuse(CUDA_ERROR_OUT_OF_MEMORY, "a file descriptor: ", std::strerror(errno));
        auto memory = std::make_shared<Physical>(file, size_t(state.st_size));
        memory->properties.type = CU_MEM_ALLOCATION_TYPE_PINNED;
        memory->properties.location = {CU_MEM_LOCATION_TYPE_DEVICE, 0};
        memory->properties.requestedHandleTypes = CU_MEM_HANDLE_TYPE_POSIX_FILE_DESCRIPTOR;
        *handle = retain(memory);
    });
}
