// SPDX-License-Identifier: Apache-2.0
// Reserved address ranges, and memory that is created, mapped there and opened for access, step by
// step, with the errors of every step.
#include "driver_cases.h"

#include <unistd.h>

namespace {

Cases cases;

template <class Call>
void run(const std::string& name, Call&& call) {
    cases.run(name, nullptr, 1, [&](int) { return call(); });
}

CUmemAllocationProp onDevice() {
    CUmemAllocationProp properties = {};
    properties.type = CU_MEM_ALLOCATION_TYPE_PINNED;
    properties.location = {CU_MEM_LOCATION_TYPE_DEVICE, 0};
    return properties;
}

struct PropertyChange {
    const char* name;
    void (*apply)(CUmemAllocationProp&);
};
using P = CUmemAllocationProp;
const PropertyChange kProperties[] = {
    {"as it is", [](P&) {}},
    {"type 0", [](P& p) { p.type = CUmemAllocationType(0); }},
    {"type 2", [](P& p) { p.type = CUmemAllocationType(2); }},
    {"type 77", [](P& p) { p.type = CUmemAllocationType(77); }},
    {"no place", [](P& p) { p.location.type = CUmemLocationType(0); }},
    {"place 9", [](P& p) { p.location.type = CUmemLocationType(9); }},
    {"device 1", [](P& p) { p.location.id = 1; }},
    {"device -1", [](P& p) { p.location.id = -1; }},
    {"the host", [](P& p) { p.location.type = CUmemLocationType(2), p.location.id = 0; }},
    {"file descriptors",
     [](P& p) { p.requestedHandleTypes = CU_MEM_HANDLE_TYPE_POSIX_FILE_DESCRIPTOR; }},
    {"handle types 2", [](P& p) { p.requestedHandleTypes = CUmemAllocationHandleType(2); }},
    {"handle types 64", [](P& p) { p.requestedHandleTypes = CUmemAllocationHandleType(64); }},
    {"compressed", [](P& p) { p.allocFlags.compressionType = 1; }},
    {"compression 7", [](P& p) { p.allocFlags.compressionType = 7; }},
    {"usage 1", [](P& p) { p.allocFlags.usage = 1; }},
    {"usage 8", [](P& p) { p.allocFlags.usage = 8; }},
    {"remote access", [](P& p) { p.allocFlags.gpuDirectRDMACapable = 1; }},
};

size_t unit;

void creation() {
    for (const PropertyChange& change : kProperties) {
        P p = onDevice();
        change.apply(p);
        size_t least = 77, advised = 77;
        run(std::string("granularity ") + change.name, [&] {
            const CUresult first =
                cuMemGetAllocationGranularity(&least, &p, CU_MEM_ALLOC_GRANULARITY_MINIMUM);
            const CUresult second =
                cuMemGetAllocationGranularity(&advised, &p, CU_MEM_ALLOC_GRANULARITY_RECOMMENDED);
            std::printf("(%zu %s %zu) ", least, nameOf(second).c_str(), advised);
            return first;
        });
        CUmemGenericAllocationHandle handle = 0;
        run(std::string("create ") + change.name, [&] {
            const CUresult result = cuMemCreate(&handle, unit, &p, 0);
            if (!result) {
                P q = {};
                const CUresult asked = cuMemGetAllocationPropertiesFromHandle(&q, handle);
                std::printf("(%s type %d, place %d %d, handles %d, flags %d %d %d) ",
                            nameOf(asked).c_str(), q.type, q.location.type, q.location.id,
                            q.requestedHandleTypes, q.allocFlags.compressionType,
                            q.allocFlags.gpuDirectRDMACapable, q.allocFlags.usage);
                MUST(cuMemRelease(handle));
            }
            return result;
        });
    }
    P p = onDevice();
    size_t value = 0;
    CUmemGenericAllocationHandle handle = 0;
    run("granularity null", [&] {
        return cuMemGetAllocationGranularity(nullptr, &p, CU_MEM_ALLOC_GRANULARITY_MINIMUM);
    });
    run("granularity null properties", [&] {
        return cuMemGetAllocationGranularity(&value, nullptr, CU_MEM_ALLOC_GRANULARITY_MINIMUM);
    });
    run("granularity option 7", [&] {
        return cuMemGetAllocationGranularity(&value, &p, CUmemAllocationGranularity_flags(7));
    });
    struct {
        const char* name;
        size_t bytes;
        unsigned long long flags;
    } const sizes[] = {{"0", 0, 0},           {"1", 1, 0},
                       {"half", unit / 2, 0}, {"one and a half", unit * 3 / 2, 0},
                       {"flags 1", unit, 1},  {"2^50", size_t(1) << 50, 0},
                       {"most", SIZE_MAX, 0}, {"most units", SIZE_MAX / unit * unit, 0}};
    for (const auto& s : sizes)
        run(std::string("create of size ") + s.name,
            [&] { return cuMemCreate(&handle, s.bytes, &p, s.flags); });
    run("create null", [&] { return cuMemCreate(nullptr, unit, &p, 0); });
    run("create null properties", [&] { return cuMemCreate(&handle, unit, nullptr, 0); });
}

void reservation() {
    CUdeviceptr address = 0;
    struct {
        const char* name;
        size_t bytes, alignment;
        CUdeviceptr hint;
        unsigned long long flags;
    } const all[] = {{"unit", unit, 0, 0, 0},
                     {"0", 0, 0, 0, 0},
                     {"half", unit / 2, 0, 0, 0},
                     {"4096", 4096, 0, 0, 0},
                     {"1000", 1000, 0, 0, 0},
                     {"one and a half", unit * 3 / 2, 0, 0, 0},
                     {"alignment unit", unit, unit, 0, 0},
                     {"alignment 4096", unit, 4096, 0, 0},
                     {"alignment 3", unit, 3, 0, 0},
                     {"alignment 3 units", unit, 3 * unit, 0, 0},
                     {"alignment 2^32", unit, size_t(1) << 32, 0, 0},
                     {"flags 1", unit, 0, 0, 1},
                     {"flags 8", unit, 0, 0, 8},
                     {"hint", unit, 0, CUdeviceptr(0x600000000000), 0},
                     {"hint 12345", unit, 0, 12345, 0},
                     {"64 GiB", size_t(64) << 30, 0, 0, 0},
                     {"2^60", size_t(1) << 60, 0, 0, 0},
                     {"most", SIZE_MAX, 0, 0, 0}};
    for (const auto& r : all)
        run(std::string("reserve ") + r.name, [&] {
            const CUresult result =
                cuMemAddressReserve(&address, r.bytes, r.alignment, r.hint, r.flags);
            if (!result) {
                std::printf("(%s, free %s) ",
                            address % (r.alignment ? r.alignment : unit) == 0 ? "aligned"
                                                                              : "not aligned",
                            nameOf(cuMemAddressFree(address, r.bytes)).c_str());
            }
            return result;
        });
    run("reserve null", [&] { return cuMemAddressReserve(nullptr, unit, 0, 0, 0); });
    MUST(cuMemAddressReserve(&address, 4 * unit, 0, 0, 0));
    run("free of another size", [&] { return cuMemAddressFree(address, unit); });
    run("free from the middle", [&] { return cuMemAddressFree(address + unit, 3 * unit); });
    run("free of size 0", [&] { return cuMemAddressFree(address, 0); });
    run("free of null", [&] { return cuMemAddressFree(0, unit); });
    run("free", [&] { return cuMemAddressFree(address, 4 * unit); });
    run("free again", [&] { return cuMemAddressFree(address, 4 * unit); });
    CUdeviceptr plain = 0;
    MUST(cuMemAlloc(&plain, unit));
    run("free of an allocation", [&] { return cuMemAddressFree(plain, unit); });
    MUST(cuMemFree(plain));
}

void mapping() {
    const P p = onDevice();
    CUdeviceptr space = 0;
    CUmemGenericAllocationHandle one = 0, two = 0;
    MUST(cuMemAddressReserve(&space, 8 * unit, 0, 0, 0));
    MUST(cuMemCreate(&one, unit, &p, 0));
    MUST(cuMemCreate(&two, 2 * unit, &p, 0));
    CUmemAccessDesc access = {{CU_MEM_LOCATION_TYPE_DEVICE, 0}, CU_MEM_ACCESS_FLAGS_PROT_READWRITE};
    unsigned long long seen = 77;
    const auto getAccess = [&](const char* name, CUdeviceptr at) {
        run(std::string("get access ") + name, [&] {
            seen = 77;
            const CUresult result = cuMemGetAccess(&seen, &access.location, at);
            std::printf("(%llu) ", seen);
            return result;
        });
    };
    const auto attributes = [&](const char* name, CUdeviceptr at) {
        run(std::string("attributes ") + name, [&] {
            unsigned type = 77, managed = 77, mapped = 77, rights = 77;
            CUdeviceptr base = 77, start = 77;
            size_t bytes = 77, range = 77;
            int device = 77;
            const CUresult result =
                cuPointerGetAttribute(&type, CU_POINTER_ATTRIBUTE_MEMORY_TYPE, at);
            const CUresult more[] = {
                cuPointerGetAttribute(&managed, CU_POINTER_ATTRIBUTE_IS_MANAGED, at),
                cuPointerGetAttribute(&mapped, CU_POINTER_ATTRIBUTE_MAPPED, at),
                cuPointerGetAttribute(&start, CU_POINTER_ATTRIBUTE_RANGE_START_ADDR, at),
                cuPointerGetAttribute(&range, CU_POINTER_ATTRIBUTE_RANGE_SIZE, at),
                cuPointerGetAttribute(&device, CU_POINTER_ATTRIBUTE_DEVICE_ORDINAL, at),
                cuPointerGetAttribute(&rights, CU_POINTER_ATTRIBUTE_ACCESS_FLAGS, at),
                cuMemGetAddressRange(&base, &bytes, at)};
            std::printf("(");
            for (CUresult r : more)
                std::printf("%s ", nameOf(r).c_str());
            std::printf("type %u managed %u mapped %u start %lld of %zu, device %d, rights %u, "
                        "range %lld of %zu) ",
                        type, managed, mapped, start == 77 ? 77 : (long long)(start - space), range,
                        device, rights,
                        base == 77 ? 77
                        : base     ? (long long)(base - space)
                                   : -1,
                        bytes);
            return result;
        });
    };
    attributes("of reserved addresses", space);
    run("set of reserved addresses", [&] { return cuMemsetD8(space, 1, 16); });
    getAccess("of reserved addresses", space);
    run("access of reserved addresses", [&] { return cuMemSetAccess(space, unit, &access, 1); });
    run("map with flags", [&] { return cuMemMap(space, unit, 0, one, 1); });
    run("map at an offset", [&] { return cuMemMap(space, unit, unit, two, 0); });
    run("map half", [&] { return cuMemMap(space, unit / 2, 0, one, 0); });
    run("map of size 0", [&] { return cuMemMap(space, 0, 0, one, 0); });
    run("map more than there is", [&] { return cuMemMap(space, 2 * unit, 0, one, 0); });
    run("map part of it", [&] { return cuMemMap(space, unit, 0, two, 0); });
    run("map off the grid", [&] { return cuMemMap(space + 4096, unit, 0, one, 0); });
    run("map what is not reserved", [&] { return cuMemMap(space + 8 * unit, unit, 0, one, 0); });
    run("map at null", [&] { return cuMemMap(0, unit, 0, one, 0); });
    run("map", [&] { return cuMemMap(space + unit, unit, 0, one, 0); });
    run("map there again", [&] { return cuMemMap(space + unit, unit, 0, one, 0); });
    run("map over it", [&] { return cuMemMap(space, 2 * unit, 0, two, 0); });
    run("map it elsewhere too", [&] { return cuMemMap(space + 4 * unit, unit, 0, one, 0); });
    run("map two", [&] { return cuMemMap(space + 2 * unit, 2 * unit, 0, two, 0); });
    getAccess("before access is set", space + unit);
    attributes("before access is set", space + unit);
    run("set before access is set", [&] { return cuMemsetD8(space + unit, 1, 16); });
    unsigned char host[64] = {};
    run("copy before access is set", [&] { return cuMemcpyDtoH(host, space + unit, 16); });
    const auto setAccess = [&](const char* name, CUdeviceptr at, size_t bytes, CUmemAccessDesc how,
                               size_t count = 1) {
        run(std::string("set access ") + name,
            [&] { return cuMemSetAccess(at, bytes, &how, count); });
    };
    CUmemAccessDesc bad = access;
    setAccess("of count 0", space + unit, unit, access, 0);
    setAccess("of size 0", space + unit, 0, access);
    setAccess("over a gap", space, 2 * unit, access);
    setAccess("half", space + unit, unit / 2, access);
    setAccess("of half of two", space + 2 * unit, unit, access);
    bad.flags = CUmemAccess_flags(2);
    setAccess("flags 2", space + unit, unit, bad);
    bad.flags = CUmemAccess_flags(7);
    setAccess("flags 7", space + unit, unit, bad);
    bad = access, bad.location.id = 1;
    setAccess("device 1", space + unit, unit, bad);
    bad = access, bad.location.type = CUmemLocationType(0);
    setAccess("no place", space + unit, unit, bad);
    bad = access, bad.location = {CUmemLocationType(2), 0};
    setAccess("the host", space + unit, unit, bad);
    run("set access null", [&] { return cuMemSetAccess(space + unit, unit, nullptr, 1); });
    bad = access, bad.flags = CU_MEM_ACCESS_FLAGS_PROT_READ;
    setAccess("read only", space + unit, unit, bad);
    getAccess("read only", space + unit);
    attributes("read only", space + unit);
    setAccess("of three", space + unit, 3 * unit, access);
    getAccess("of three", space + 3 * unit);
    getAccess("off the grid", space + unit + 5);
    run("get access null", [&] { return cuMemGetAccess(nullptr, &access.location, space + unit); });
    run("get access null place", [&] { return cuMemGetAccess(&seen, nullptr, space + unit); });
    attributes("of the first", space + unit);
    attributes("of the second", space + 2 * unit + 100);
    run("set over both", [&] { return cuMemsetD32(space + 2 * unit - 64, 0x01020304, 32); });
    run("copy over both", [&] {
        const CUresult result = cuMemcpyDtoH(host, space + 2 * unit - 32, 64);
        std::printf("(%08x) ", unsigned(sumOf(host, 64)));
        return result;
    });
    run("set over the gap", [&] { return cuMemsetD8(space + 4 * unit - 16, 1, 32); });
    run("cuMemFree", [&] { return cuMemFree(space + unit); });
    setAccess("of the other place", space + 4 * unit, unit, access);
    run("the same memory at two places", [&] {
        MUST(cuMemsetD8(space + unit, 5, 64));
        const CUresult result = cuMemcpyDtoH(host, space + 4 * unit, 64);
        std::printf("(%d) ", host[63]);
        return result;
    });
    CUmemGenericAllocationHandle again = 0;
    run("retain", [&] {
        const CUresult result =
            cuMemRetainAllocationHandle(&again, reinterpret_cast<void*>(space + unit + 5));
        std::printf("(%s) ", again == one ? "the same" : "another");
        return result;
    });
    run("release of what was retained", [&] { return cuMemRelease(again); });
    run("retain reserved",
        [&] { return cuMemRetainAllocationHandle(&again, reinterpret_cast<void*>(space)); });
    run("retain null", [&] {
        return cuMemRetainAllocationHandle(nullptr, reinterpret_cast<void*>(space + unit));
    });
    run("release while mapped", [&] { return cuMemRelease(one); });
    run("copy after release", [&] {
        const CUresult result = cuMemcpyDtoH(host, space + unit, 64);
        std::printf("(%d) ", host[63]);
        return result;
    });
    int file = -1;
    run("export of what was not made for it", [&] {
        return cuMemExportToShareableHandle(&file, two, CU_MEM_HANDLE_TYPE_POSIX_FILE_DESCRIPTOR,
                                            0);
    });
    run("free while mapped", [&] { return cuMemAddressFree(space, 8 * unit); });
    run("unmap half", [&] { return cuMemUnmap(space + unit, unit / 2); });
    run("unmap half of two", [&] { return cuMemUnmap(space + 2 * unit, unit); });
    run("unmap a gap", [&] { return cuMemUnmap(space, unit); });
    run("unmap over a gap", [&] { return cuMemUnmap(space, 2 * unit); });
    run("unmap of size 0", [&] { return cuMemUnmap(space + unit, 0); });
    run("unmap both", [&] { return cuMemUnmap(space + unit, 3 * unit); });
    run("unmap again", [&] { return cuMemUnmap(space + unit, unit); });
    run("unmap the other place", [&] { return cuMemUnmap(space + 4 * unit, unit); });
    run("set after that", [&] { return cuMemsetD8(space + unit, 1, 16); });
    run("map after release", [&] { return cuMemMap(space, 2 * unit, 0, two, 0); });
    run("unmap it", [&] { return cuMemUnmap(space, 2 * unit); });
    run("release", [&] { return cuMemRelease(two); });
    run("free", [&] { return cuMemAddressFree(space, 8 * unit); });
}

void sharing() {
    P p = onDevice();
    p.requestedHandleTypes = CU_MEM_HANDLE_TYPE_POSIX_FILE_DESCRIPTOR;
    CUmemGenericAllocationHandle memory = 0, imported = 0;
    CUdeviceptr space = 0;
    int file = -1;
    CUmemAccessDesc access = {{CU_MEM_LOCATION_TYPE_DEVICE, 0}, CU_MEM_ACCESS_FLAGS_PROT_READWRITE};
    MUST(cuMemAddressReserve(&space, 2 * unit, 0, 0, 0));
    run("create to share", [&] { return cuMemCreate(&memory, unit, &p, 0); });
    if (!memory)
        return;
    run("export flags 1", [&] {
        return cuMemExportToShareableHandle(&file, memory, CU_MEM_HANDLE_TYPE_POSIX_FILE_DESCRIPTOR,
                                            1);
    });
    run("export type 2", [&] {
        return cuMemExportToShareableHandle(&file, memory, CUmemAllocationHandleType(2), 0);
    });
    run("export null", [&] {
        return cuMemExportToShareableHandle(nullptr, memory,
                                            CU_MEM_HANDLE_TYPE_POSIX_FILE_DESCRIPTOR, 0);
    });
    run("export", [&] {
        return cuMemExportToShareableHandle(&file, memory, CU_MEM_HANDLE_TYPE_POSIX_FILE_DESCRIPTOR,
                                            0);
    });
    run("import null", [&] {
        return cuMemImportFromShareableHandle(nullptr, reinterpret_cast<void*>(size_t(file)),
                                              CU_MEM_HANDLE_TYPE_POSIX_FILE_DESCRIPTOR);
    });
    run("import 9999", [&] {
        return cuMemImportFromShareableHandle(&imported, reinterpret_cast<void*>(size_t(9999)),
                                              CU_MEM_HANDLE_TYPE_POSIX_FILE_DESCRIPTOR);
    });
    run("import type 2", [&] {
        return cuMemImportFromShareableHandle(&imported, reinterpret_cast<void*>(size_t(file)),
                                              CUmemAllocationHandleType(2));
    });
    run("import", [&] {
        return cuMemImportFromShareableHandle(&imported, reinterpret_cast<void*>(size_t(file)),
                                              CU_MEM_HANDLE_TYPE_POSIX_FILE_DESCRIPTOR);
    });
    if (!imported)
        return;
    close(file);
    MUST(cuMemMap(space, unit, 0, memory, 0));
    MUST(cuMemMap(space + unit, unit, 0, imported, 0));
    MUST(cuMemSetAccess(space, 2 * unit, &access, 1));
    MUST(cuMemsetD8(space, 9, 64));
    unsigned char host[64] = {};
    run("one memory", [&] {
        const CUresult result = cuMemcpyDtoH(host, space + unit, 64);
        std::printf("(%d) ", host[63]);
        return result;
    });
    MUST(cuMemUnmap(space, unit));
    MUST(cuMemUnmap(space + unit, unit));
    MUST(cuMemRelease(memory));
    MUST(cuMemRelease(imported));
    MUST(cuMemAddressFree(space, 2 * unit));
}

// A value that is never a handle; drivers read others unchecked.
void noHandle() {
    CUdeviceptr space = 0;
    P properties = {};
    int file = -1;
    MUST(cuMemAddressReserve(&space, unit, 0, 0, 0));
    run("release 0", [&] { return cuMemRelease(0); });
    run("map 0", [&] { return cuMemMap(space, unit, 0, 0, 0); });
    run("properties of 0", [&] { return cuMemGetAllocationPropertiesFromHandle(&properties, 0); });
    run("export 0", [&] {
        return cuMemExportToShareableHandle(&file, 0, CU_MEM_HANDLE_TYPE_POSIX_FILE_DESCRIPTOR, 0);
    });
    run("properties null", [&] { return cuMemGetAllocationPropertiesFromHandle(nullptr, 0); });
    MUST(cuMemAddressFree(space, unit));
}

} // namespace

int main() {
    CUcontext context = nullptr;
    int supported = 0;
    MUST(cuInit(0));
    MUST(cuDevicePrimaryCtxRetain(&context, 0));
    MUST(cuCtxSetCurrent(context));
    MUST(cuDeviceGetAttribute(&supported, CU_DEVICE_ATTRIBUTE_VIRTUAL_MEMORY_MANAGEMENT_SUPPORTED,
                              0));
    const P p = onDevice();
    MUST(cuMemGetAllocationGranularity(&unit, &p, CU_MEM_ALLOC_GRANULARITY_MINIMUM));
    std::printf("supported %d, unit %zu\n", supported, unit);
    creation();
    reservation();
    mapping();
    sharing();
    noHandle();
    return 0;
}
