// SPDX-License-Identifier: Apache-2.0
// Shared by the calls of fuzz_cuda: a stream of random numbers, handles made so far, and arguments
// made from their types. Read main.cpp first.
#pragma once

#include <cuda.h>

#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <map>
#include <memory>
#include <random>
#include <string>
#include <tuple>
#include <type_traits>
#include <vector>

namespace {

const char* const kText = R"(.version 7.0
.target sm_60
.address_size 64
.visible .global .align 4 .u32 total = 3;
.const .align 4 .b32 table[16];
.global .texref image;
.global .surfref canvas;
.visible .entry nothing() { ret; }
.visible .entry numbers(.param .u32 a, .param .align 8 .b8 b[24], .param .u64 c)
{
    .reg .b32 %r<4>;
    .shared .align 4 .b32 mine[8];
    ld.param.u32 %r1, [a];
    st.shared.u32 [mine], %r1;
    bar.sync 0;
    ld.shared.u32 %r2, [mine];
    st.global.u32 [total], %r2;
    ret;
}
)";

constexpr size_t kBytes = 1 << 16; // of the memory that lives as long as a sequence

std::atomic<unsigned long> gSequence{0};
std::atomic<const char*> gCall{"none"};
bool gPrints = false;

void tellWhere() {
    char text[200];
    const int size = std::snprintf(text, sizeof text, "\nfuzz_cuda: in %s; repeat with --sequence %lu\n",
                                   gCall.load(), gSequence.load());
    if (write(STDERR_FILENO, text, size_t(size)) < 0)
        _exit(3);
}

void hostFunction(void* data) {
    __atomic_add_fetch(static_cast<int*>(data), 1, __ATOMIC_RELAXED);
}
void callback(CUstream, CUresult, void* data) {
    hostFunction(data);
}
size_t sharedBytesOf(int threads) {
    return size_t(threads);
}
int gCalled = 0;

template <class T>
struct Kept {
    std::vector<T> live, dead;
};

class World {
public:
    explicit World(unsigned long number) : random_(number * 0x9E3779B97F4A7C15ull + 1) {
        host = guarded(kBytes) - kBytes;
        must(cuDevicePrimaryCtxRetain(&primary, 0));
        must(cuCtxSetCurrent(primary));
        keep(primary);
        must(cuMemAlloc(&device, kBytes));
        must(cuMemsetD8(device, 0, kBytes));
        addresses.live.push_back(device);
        CUDA_ARRAY3D_DESCRIPTOR shape{16, 16, 4, CU_AD_FORMAT_FLOAT, 2, CUDA_ARRAY3D_SURFACE_LDST};
        must(cuArray3DCreate(&array, &shape));
        keep(array);
        CUmodule module = nullptr;
        must(cuModuleLoadData(&module, kText));
        keep(module);
        for (const char* name : {"nothing", "numbers"}) {
            CUfunction function = nullptr;
            must(cuModuleGetFunction(&function, module, name));
            keep(function);
        }
        CUstream stream = nullptr;
        must(cuStreamCreate(&stream, CU_STREAM_NON_BLOCKING));
        keep(stream);
    }
    World(const World&) = delete;

    // Contexts destroy the objects of a sequence; the others are destroyed here.
    ~World() {
        must(cuCtxSetCurrent(primary));
        const auto endCapture = [&](CUstream stream) {
            CUgraph graph = nullptr;
            cuStreamEndCapture(stream, &graph);
            keep(graph);
        };
        for (CUstream stream : all<CUstream>().live)
            endCapture(stream);
        endCapture(CU_STREAM_PER_THREAD); // outlives its context, with its captured objects
        for (CUgraphExec exec : all<CUgraphExec>().live)
            cuGraphExecDestroy(exec);
        for (CUgraph graph : all<CUgraph>().live)
            cuGraphDestroy(graph);
        for (CUlibrary library : all<CUlibrary>().live)
            cuLibraryUnload(library);
        for (CUmemoryPool pool : all<CUmemoryPool>().live)
            cuMemPoolDestroy(pool);
        for (CUlinkState link : all<CUlinkState>().live)
            cuLinkDestroy(link);
        for (CUcontext context : all<CUcontext>().live)
            if (context != primary)
                cuCtxDestroy(context);
        CUcontext popped = nullptr;
        while (cuCtxPopCurrent(&popped) == CUDA_SUCCESS && popped) {
        }
        must(cuCtxSetCurrent(primary));
        // Queued work may have accessed freed memory or freed it again.
        const CUresult last = cuCtxSynchronize();
        const bool isLate = last == CUDA_ERROR_ILLEGAL_ADDRESS || last == CUDA_ERROR_INVALID_VALUE;
        if (!isLate || !mayBeLate)
            must(last);
        must(cuDevicePrimaryCtxReset(0));
        for (const auto& [base, size] : mappings_)
            munmap(base, size);
    }

    size_t below(size_t limit) { return limit ? random_() % limit : 0; }
    bool chance(unsigned percent) { return below(100) < percent; }
    template <class T>
    T oneOf(std::initializer_list<T> values) {
        return values.begin()[below(values.size())];
    }
    uint32_t any32() {
        switch (below(8)) {
        case 0:
            return ~uint32_t(below(4));
        case 1:
            return (1u << below(32)) + uint32_t(below(3)) - 1;
        case 2:
            return uint32_t(random_());
        default:
            return uint32_t(below(10));
        }
    }
    // A small size, or far more than any machine has.
    size_t size() {
        switch (below(10)) {
        case 0:
            return ~below(300);
        case 1:
            return (size_t(1) << (45 + below(19))) + below(3) - 1;
        case 2:
            return below(kBytes + 100);
        default:
            return below(70);
        }
    }
    float number() {
        const uint32_t bits = any32();
        float value = 0;
        std::memcpy(&value, &bits, sizeof value);
        return chance(70) ? float(below(100)) / 10 : value;
    }

    template <class T>
    Kept<T>& all() {
        static Kept<T>* kept = new Kept<T>;
        static unsigned long of = 0;
        if (of != gSequence) {
            *kept = {};
            of = gSequence;
        }
        return *kept;
    }
    template <class T>
    void keep(T handle) {
        auto& live = all<T>().live;
        if (handle && std::find(live.begin(), live.end(), handle) == live.end())
            live.push_back(handle);
    }
    template <class T>
    T handle() {
        auto& kept = all<T>();
        if (!kept.live.empty() && chance(88))
            return kept.live[below(kept.live.size())];
        if (!kept.dead.empty() && chance(50))
            return kept.dead[below(kept.dead.size())];
        return reinterpret_cast<T>(chance(60) ? below(4) : size() | size_t(1) << 63);
    }
    template <class T>
    void died(T handle) {
        auto& kept = all<T>();
        std::erase(kept.live, handle);
        kept.dead.push_back(handle);
    }

    // An address in memory that lives as long as the sequence, with or without room for small
    // sizes. For calls that also accept host memory, such as cuMemcpy, addresses beside an
    // allocation are host memory.
    CUdeviceptr lasting() {
        return chance(90) ? device + below(chance(80) ? 64 : kBytes / 4) * 4
                          : oneOf<CUdeviceptr>({0, 1, size() | 1ull << 63});
    }
    // After an allocation or a free in the order of a stream: waits for it, because a later call
    // uses the address, live or dead. Memory of a captured one is freed with the graph's last
    // launch, at any time; calls that use it fail.
    void afterOrdered(CUstream stream) {
        CUstreamCaptureStatus status = CU_STREAM_CAPTURE_STATUS_NONE;
        if (cuStreamIsCapturing(stream, &status) != CUDA_SUCCESS ||
            status != CU_STREAM_CAPTURE_STATUS_NONE || cuStreamSynchronize(stream) != CUDA_SUCCESS)
            mayBeLate = true;
    }
    CUdeviceptr wrongAddress() {
        return oneOf<CUdeviceptr>({0, 1, size() | 1ull << 63, device + kBytes, device - 1});
    }
    // For calls that accept only device memory.
    CUdeviceptr address() {
        if (chance(60))
            return addresses.live[below(addresses.live.size())] + (chance(70) ? 0 : below(40) * 4);
        if (!addresses.dead.empty() && chance(40))
            return addresses.dead[below(addresses.dead.size())];
        return chance(30) ? below(30) : wrongAddress();
    }
    // Host memory that ends after this many bytes; null if it has fewer.
    char* hostMemory(size_t bytes) { return bytes > kBytes ? nullptr : host + kBytes - bytes; }

    // Memory of exactly the size of a result: a sanitizer sees writes beside it.
    template <class T>
    T* result(size_t count = 1) {
        results_.push_back(std::make_unique<char[]>(std::max<size_t>(1, count) * sizeof(T)));
        return reinterpret_cast<T*>(results_.back().get());
    }
    void forgetResults() { results_.clear(); }

    CUcontext primary = nullptr;
    CUdeviceptr device = 0;
    CUarray array = nullptr;
    char* host = nullptr;
    Kept<CUdeviceptr> addresses;
    bool mayBeLate = false; // an access to freed memory

    static void must(CUresult result) {
        if (result == CUDA_SUCCESS)
            return;
        std::fprintf(stderr, "a call that has to succeed gave %d\n", int(result));
        std::abort();
    }

private:
    static constexpr size_t kPage = 4096;

    // Memory whose end is followed by pages without access.
    char* guarded(size_t bytes) {
        void* const base =
            mmap(nullptr, bytes + kPage, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
        if (base == MAP_FAILED || mprotect(static_cast<char*>(base) + bytes, kPage, PROT_NONE))
            std::abort();
        mappings_.push_back({base, bytes + kPage});
        return static_cast<char*>(base) + bytes;
    }

    std::mt19937_64 random_;
    std::vector<std::unique_ptr<char[]>> results_;
    std::vector<std::pair<void*, size_t>> mappings_;
};

// ---- Structs ----

void fill(World& w, CUDA_ARRAY_DESCRIPTOR& d) {
    const auto side = [&] { return w.chance(90) ? w.below(40) : w.size(); };
    d = {side(), side(),
         CUarray_format(w.chance(90) ? w.oneOf({1, 2, 3, 8, 9, 10, 16, 32}) : int(w.any32())),
         unsigned(w.chance(90) ? w.oneOf({1, 2, 4}) : int(w.any32()))};
}
void fill(World& w, CUDA_ARRAY3D_DESCRIPTOR& d) {
    CUDA_ARRAY_DESCRIPTOR flat;
    fill(w, flat);
    d = {flat.Width, flat.Height, w.chance(90) ? w.below(13) : w.size(), flat.Format,
         flat.NumChannels, w.chance(90) ? unsigned(w.below(64)) : w.any32()};
    if (w.chance(30))
        d.Flags = 0;
}
// One side of a copy. Queued copies use memory that lives as long as the sequence.
template <class Copy>
void fillCopy(World& w, Copy& c, bool lasts) {
    const size_t host = size_t(1) << 12; // may be used
    const auto small = [&] { return w.chance(93) ? w.below(8) : w.size(); };
    c.WidthInBytes = small() * 4;
    c.Height = small();
    const auto type = [&] {
        return CUmemorytype(w.chance(95) ? 1 + w.below(4) : size_t(w.any32()));
    };
    c.srcMemoryType = type();
    c.dstMemoryType = type();
    const auto device = [&](CUmemorytype kind) {
        return lasts || kind != CU_MEMORYTYPE_DEVICE ? w.lasting() : w.address();
    };
    c.srcDevice = device(c.srcMemoryType);
    c.dstDevice = device(c.dstMemoryType);
    c.srcArray = lasts ? w.array : w.handle<CUarray>();
    c.dstArray = lasts ? w.array : w.handle<CUarray>();
    c.srcHost = w.host;
    c.dstHost = w.host + host;
    c.srcXInBytes = w.chance(70) ? 0 : small() * 4;
    c.dstXInBytes = w.chance(70) ? 0 : small() * 4;
    c.srcY = w.chance(70) ? 0 : small();
    c.dstY = w.chance(70) ? 0 : small();
    c.srcPitch = w.chance(60) ? 64 : small() * 8;
    c.dstPitch = w.chance(60) ? 64 : small() * 8;
    if constexpr (requires { c.Depth; }) {
        c.Depth = small();
        c.srcZ = w.chance(70) ? 0 : small();
        c.dstZ = w.chance(70) ? 0 : small();
        c.srcHeight = w.chance(60) ? 8 : small();
        c.dstHeight = w.chance(60) ? 8 : small();
        c.srcLOD = w.chance(95) ? 0 : w.size();
        c.dstLOD = w.chance(95) ? 0 : w.size();
    }
    // Host memory is as large as the copy needs, or null.
    unsigned __int128 reach = 0;
    if constexpr (requires { c.Depth; })
        for (const auto& [x, y, z, pitch, height] :
             {std::tuple{c.srcXInBytes, c.srcY, c.srcZ, c.srcPitch, c.srcHeight},
              std::tuple{c.dstXInBytes, c.dstY, c.dstZ, c.dstPitch, c.dstHeight}}) {
            using Wide = unsigned __int128;
            const Wide row = std::max<Wide>(pitch, Wide(x) + c.WidthInBytes);
            const Wide slice = std::max<Wide>(height, Wide(y) + c.Height);
            reach = std::max({reach, (Wide(z) + c.Depth) > host ? Wide(kBytes) : Wide(0),
                              slice > host || row > kBytes ? Wide(kBytes)
                                                           : row * slice * (Wide(z) + c.Depth)});
        }
    else
        for (const auto& [x, y, pitch] : {std::tuple{c.srcXInBytes, c.srcY, c.srcPitch},
                                          std::tuple{c.dstXInBytes, c.dstY, c.dstPitch}}) {
            using Wide = unsigned __int128;
            const Wide row = std::max<Wide>(pitch, Wide(x) + c.WidthInBytes);
            const Wide rows = Wide(y) + c.Height;
            reach = std::max(reach, rows > host || row > kBytes ? Wide(kBytes) : row * rows);
        }
    if (reach > kBytes - host)
        c.srcHost = c.dstHost = nullptr;
}
template <class Copy>
    requires requires(Copy c) { c.WidthInBytes; }
void fill(World& w, Copy& c) {
    fillCopy(w, c, false);
    if constexpr (requires { c.srcContext; }) {
        c.srcContext = w.handle<CUcontext>();
        c.dstContext = w.handle<CUcontext>();
    }
}
void fill(World& w, CUDA_RESOURCE_DESC& d) {
    d.resType = CUresourcetype(w.chance(95) ? w.below(4) : size_t(w.any32()));
    CUDA_ARRAY_DESCRIPTOR shape;
    fill(w, shape);
    switch (d.resType) {
    case CU_RESOURCE_TYPE_ARRAY:
        d.res.array.hArray = w.handle<CUarray>();
        break;
    case CU_RESOURCE_TYPE_MIPMAPPED_ARRAY:
        d.res.mipmap.hMipmappedArray = w.handle<CUmipmappedArray>();
        break;
    case CU_RESOURCE_TYPE_LINEAR:
        d.res.linear = {w.address(), shape.Format, shape.NumChannels, w.size()};
        break;
    default:
        d.res.pitch2D = {w.address(), shape.Format, shape.NumChannels, shape.Width, shape.Height,
                         w.chance(60) ? 512 : w.size()};
    }
    d.flags = w.chance(95) ? 0 : w.any32();
}
void fill(World& w, CUDA_TEXTURE_DESC& d) {
    for (CUaddress_mode& mode : d.addressMode)
        mode = CUaddress_mode(w.chance(95) ? w.below(4) : size_t(w.any32()));
    d.filterMode = CUfilter_mode(w.chance(95) ? w.below(2) : size_t(w.any32()));
    d.mipmapFilterMode = CUfilter_mode(w.chance(95) ? w.below(2) : size_t(w.any32()));
    d.flags = w.chance(80) ? w.oneOf({0u, 1u, 2u, 3u, 0x10u, 0x40u}) : w.any32();
    d.maxAnisotropy = w.any32();
    d.mipmapLevelBias = w.number();
    d.minMipmapLevelClamp = w.number();
    d.maxMipmapLevelClamp = w.number();
    for (float& channel : d.borderColor)
        channel = w.number();
}
void fill(World& w, CUDA_RESOURCE_VIEW_DESC& d) {
    d.format = CUresourceViewFormat(w.chance(95) ? w.below(36) : size_t(w.any32()));
    for (size_t* side : {&d.width, &d.height, &d.depth})
        *side = w.chance(90) ? w.below(40) : w.size();
    for (unsigned* limit : {&d.firstMipmapLevel, &d.lastMipmapLevel, &d.firstLayer, &d.lastLayer})
        *limit = w.any32();
}
void fill(World& w, CUmemLocation& l) {
    l = {CUmemLocationType(w.chance(90) ? 1 : w.any32()), int(w.chance(90) ? 0 : w.any32())};
}
void fill(World& w, CUmemAccessDesc& d) {
    fill(w, d.location);
    d.flags = CUmemAccess_flags(w.chance(90) ? w.oneOf({0u, 1u, 3u}) : w.any32());
}
void fill(World& w, CUmemPoolProps& p) {
    p.allocType = CUmemAllocationType(w.chance(90) ? 1 : w.any32());
    p.handleTypes = CUmemAllocationHandleType(w.chance(90) ? w.below(2) : size_t(w.any32()));
    fill(w, p.location);
    p.maxSize = w.chance(60) ? 0 : w.size();
    p.usage = uint16_t(w.chance(90) ? 0 : w.any32());
}
void fill(World& w, CUmemAllocationProp& p) {
    p.type = CUmemAllocationType(w.chance(90) ? 1 : w.any32());
    p.requestedHandleTypes =
        CUmemAllocationHandleType(w.chance(90) ? w.below(2) : size_t(w.any32()));
    fill(w, p.location);
    p.allocFlags.compressionType = uint8_t(w.chance(90) ? 0 : w.any32());
}
void fill(World& w, CUDA_MEMSET_NODE_PARAMS& p) {
    p = {w.lasting(), w.chance(80) ? 256 : w.size(), w.any32(), w.oneOf({1u, 2u, 4u, w.any32()}),
         w.chance(90) ? w.below(40) : w.size(), w.chance(90) ? w.below(6) : w.size()};
}
void fill(World& w, CUDA_HOST_NODE_PARAMS& p) {
    p = {w.chance(95) ? hostFunction : nullptr, &gCalled};
}
void fill(World& w, CUlaunchAttributeValue& v) {
    for (char& byte : v.pad)
        byte = char(w.chance(70) ? 0 : w.any32());
}
void fill(World& w, CUDA_GRAPH_INSTANTIATE_PARAMS& p) {
    p.flags = w.chance(90) ? w.below(16) : w.size();
    p.hUploadStream = w.handle<CUstream>();
}
unsigned dimension(World& w) {
    return w.chance(94) ? 1 + unsigned(w.below(3)) : w.chance(50) ? 0 : w.any32() | 1u << 31;
}
// Arguments for the larger kernel, which do for both.
void** parameters(World& w) {
    static uint64_t values[4] = {1, 2, 3, 4};
    static void* pointers[3] = {values, values + 1, values};
    return w.chance(95) ? pointers : nullptr;
}
void fill(World& w, CUDA_KERNEL_NODE_PARAMS& p) {
    p.func = w.handle<CUfunction>();
    p.gridDimX = dimension(w), p.gridDimY = dimension(w), p.gridDimZ = dimension(w);
    p.blockDimX = dimension(w), p.blockDimY = dimension(w), p.blockDimZ = dimension(w);
    p.sharedMemBytes = w.chance(90) ? 0 : w.any32();
    p.kernelParams = parameters(w);
    if (w.chance(10)) {
        p.func = nullptr;
        p.kern = w.handle<CUkernel>();
    }
    p.ctx = w.chance(80) ? nullptr : w.handle<CUcontext>();
}

// ---- Arguments by type ----

template <class T>
constexpr bool kIsHandle = false;
#define HANDLE(type)                                                                               \
    template <>                                                                                    \
    constexpr bool kIsHandle<type> = true;
HANDLE(CUcontext)
HANDLE(CUmodule)
HANDLE(CUfunction)
HANDLE(CUlibrary)
HANDLE(CUkernel)
HANDLE(CUarray)
HANDLE(CUmipmappedArray)
HANDLE(CUtexref)
HANDLE(CUsurfref)
HANDLE(CUevent)
HANDLE(CUstream)
HANDLE(CUlinkState)
HANDLE(CUgraph)
HANDLE(CUgraphNode)
HANDLE(CUgraphExec)
HANDLE(CUmemoryPool)

template <class T>
T argument(World& w) {
    if constexpr (kIsHandle<T>)
        return w.handle<T>();
    else if constexpr (std::is_same_v<T, const char*>)
        return w.oneOf<const char*>(
            {"nothing", "numbers", "total", "table", "image", "canvas", "", "none", nullptr});
    else if constexpr (std::is_pointer_v<T>) {
        using Pointed = std::remove_pointer_t<T>;
        using Value = std::remove_const_t<Pointed>;
        if (w.chance(4))
            return nullptr;
        Value* const place = w.result<Value>();
        if constexpr (std::is_class_v<Value> || std::is_union_v<Value>)
            if constexpr (requires { fill(w, *place); })
                fill(w, *place);
        if constexpr (std::is_const_v<Pointed> && !std::is_class_v<Value> && !std::is_union_v<Value>)
            static_assert(!sizeof(T), "an array: such calls are written by hand");
        return place;
    } else if constexpr (std::is_enum_v<T>)
        return T(w.chance(92) ? w.below(20) : size_t(w.any32()));
    else if constexpr (std::is_class_v<T>) {
        T value{};
        fill(w, value);
        return value;
    } else if constexpr (std::is_same_v<T, unsigned long long>)
        return w.address();
    else if constexpr (std::is_same_v<T, float>)
        return w.number();
    else if constexpr (sizeof(T) == 8)
        return T(w.size());
    else if constexpr (std::is_same_v<T, CUdevice>)
        return w.chance(85) ? 0 : int(w.any32());
    else
        return T(w.any32());
}

// The result that a successful call has stored.
template <class T>
void harvest(World& w, T value) {
    if constexpr (std::is_pointer_v<T>) {
        using Value = std::remove_pointer_t<T>;
        if constexpr (kIsHandle<Value>) {
            if (value)
                w.keep(*value);
        } else if constexpr (std::is_same_v<Value, unsigned long long>) {
            if (value && *value && w.addresses.live.size() < 100)
                w.addresses.live.push_back(*value);
        }
    }
}

} // namespace
