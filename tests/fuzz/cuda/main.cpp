// SPDX-License-Identifier: Apache-2.0
// Fuzzes the CUDA driver's host API: sequences of random calls with valid and invalid arguments. A
// sequence is determined by its number alone: `fuzz_cuda --sequence NUMBER` repeats it.
//   fuzz_cuda [--seconds N] [--start N] [--sequence N] [--calls N]
// With --start, too, it first runs the sequences from there on, for a failure that needs them.
//
// Most functions are called through CALL, which makes every argument from its type: a handle of its
// kind (live, dead, null, garbage), an address, a small or an absurd number, a struct of such, or a
// place for a result. Functions with host memory, or with arrays whose length another argument
// gives, are written by hand.
//
// The caller's obligations are kept: host pointers are null or long enough, and memory and arrays
// that queued work and graphs use live as long as the sequence.
#include "../last_words.h"
#include "../options.h"
#include "arguments.h"

namespace {

// ---- Calls ----

struct Call {
    const char* name;
    int weight;
    CUresult (*run)(World&);
};

std::map<std::string, std::array<unsigned long, 2>> gCounts;

template <auto kFunction, class... Args>
CUresult callWith(World& w, CUresult (*)(Args...)) {
    // In braces arguments are evaluated in this order.
    std::tuple<Args...> arguments{argument<Args>(w)...};
    const CUresult result = std::apply(kFunction, arguments);
    if (result == CUDA_SUCCESS)
        std::apply([&](auto... values) { (harvest(w, values), ...); }, arguments);
    return result;
}
template <auto kFunction>
CUresult call(World& w) {
    return callWith<kFunction>(w, kFunction);
}
// Ends a handle.
template <auto kFunction, class T>
CUresult endWith(World& w, CUresult (*)(T)) {
    if (w.chance(60)) // live ones are worth more
        return CUDA_ERROR_NOT_READY;
    const T handle = w.handle<T>();
    const CUresult result = kFunction(handle);
    if (result == CUDA_SUCCESS)
        w.died(handle);
    return result;
}
template <auto kFunction>
CUresult end(World& w) {
    return endWith<kFunction>(w, kFunction);
}

// A few nodes and their number.
struct Nodes {
    explicit Nodes(World& w) : count(w.chance(60) ? 0 : w.below(4)) {
        list = w.chance(96) ? w.result<CUgraphNode>(count) : nullptr;
        for (size_t i = 0; list && i < count; ++i)
            list[i] = w.handle<CUgraphNode>();
    }
    CUgraphNode* list;
    size_t count;
};
template <auto kFunction, class... More>
CUresult addNodeWith(World& w, CUresult (*)(CUgraphNode*, CUgraph, const CUgraphNode*, size_t,
                                            More...)) {
    CUgraphNode* const node = argument<CUgraphNode*>(w);
    const Nodes before(w);
    std::tuple<More...> more{argument<More>(w)...};
    const CUgraph graph = w.handle<CUgraph>();
    const CUresult result = std::apply(
        [&](auto... values) { return kFunction(node, graph, before.list, before.count, values...); },
        more);
    if (result == CUDA_SUCCESS)
        w.keep(*node);
    return result;
}
template <auto kFunction>
CUresult addNode(World& w) {
    return addNodeWith<kFunction>(w, kFunction);
}
// Lists nodes of a graph or of a node.
template <auto kFunction, class Of, bool kHasEdges>
CUresult listNodes(World& w) {
    size_t* const count = w.result<size_t>();
    *count = w.below(5);
    CUgraphNode* const nodes = w.chance(60) ? w.result<CUgraphNode>(*count) : nullptr;
    const Of of = w.handle<Of>();
    if constexpr (kHasEdges) {
        CUgraphEdgeData* const edges =
            w.chance(60) ? w.result<CUgraphEdgeData>(*count) : nullptr;
        return kFunction(of, nodes, edges, count);
    } else
        return kFunction(of, nodes, count);
}
template <auto kFunction>
CUresult changeEdges(World& w) {
    const Nodes from(w), to(w);
    const size_t count = std::min(from.count, to.count);
    return kFunction(w.handle<CUgraph>(), from.list, to.list,
                     w.chance(80) ? nullptr : w.result<CUgraphEdgeData>(count), count);
}
CUDA_MEMCPY3D lastingCopy(World& w) {
    CUDA_MEMCPY3D copy{};
    fillCopy(w, copy, true);
    return copy;
}
CUresult addCopy(World& w) {
    const CUDA_MEMCPY3D copy = lastingCopy(w);
    CUgraphNode* const node = argument<CUgraphNode*>(w);
    const Nodes before(w);
    const CUresult result =
        cuGraphAddMemcpyNode(node, w.handle<CUgraph>(), before.list, before.count,
                             w.chance(97) ? &copy : nullptr, w.handle<CUcontext>());
    if (result == CUDA_SUCCESS)
        w.keep(*node);
    return result;
}
// With host memory of that size.
template <auto kFunction>
CUresult copyDown(World& w) {
    const size_t size = w.size();
    return kFunction(w.hostMemory(size), w.address(), size);
}
template <auto kFunction>
CUresult copyUp(World& w) {
    const size_t size = w.size();
    return kFunction(w.address(), w.hostMemory(size), size);
}
template <auto kFunction>
CUresult text(World& w) {
    const int length = w.chance(80) ? int(w.below(100)) : -int(w.below(100));
    return kFunction(w.chance(95) ? w.result<char>(size_t(std::max(0, length))) : nullptr, length,
                     argument<CUdevice>(w));
}
CUresult jit(World& w, auto load) {
    const unsigned count = unsigned(w.below(4));
    auto* const options = w.result<CUjit_option>(count);
    auto* const values = w.result<void*>(count);
    for (unsigned i = 0; i < count; ++i) {
        options[i] = CUjit_option(w.chance(90) ? w.below(20) : size_t(w.any32()));
        values[i] = reinterpret_cast<void*>(w.below(64));
        if (options[i] == CU_JIT_INFO_LOG_BUFFER || options[i] == CU_JIT_ERROR_LOG_BUFFER)
            values[i] = w.result<char>(64); // at most as long as any size passed
    }
    return load(count, w.chance(90) ? options : nullptr, w.chance(90) ? values : nullptr);
}

// The size of each pointer attribute's value is at most this.
struct Widest {
    char bytes[16];
};

#define CALL(name, weight) {#name, weight, call<name>}
#define END(name) {#name, 2, end<name>}
#define NODE(name) {#name, 3, addNode<name>}

const Call kCalls[] = {
    CALL(cuDriverGetVersion, 1),
    CALL(cuGetErrorString, 1),
    CALL(cuGetErrorName, 1),
    CALL(cuDeviceGet, 1),
    CALL(cuDeviceGetCount, 1),
    {"cuDeviceGetName", 1, text<cuDeviceGetName>},
    {"cuDeviceGetPCIBusId", 1, text<cuDeviceGetPCIBusId>},
    CALL(cuDeviceGetByPCIBusId, 1),
    CALL(cuDeviceGetUuid, 1),
    CALL(cuDeviceTotalMem, 1),
    CALL(cuDeviceGetAttribute, 1),
    CALL(cuDeviceGetProperties, 1),
    CALL(cuDeviceComputeCapability, 1),
    CALL(cuDeviceCanAccessPeer, 1),
    CALL(cuDeviceGetP2PAttribute, 1),
    CALL(cuDeviceGetTexture1DLinearMaxWidth, 1),
    CALL(cuDeviceGetExecAffinitySupport, 1),
    CALL(cuDevicePrimaryCtxSetFlags, 1),
    CALL(cuDevicePrimaryCtxGetState, 1),
    {"cuCtxCreate", 2,
     [](World& w) {
         auto* const context = argument<CUcontext*>(w);
         if (w.all<CUcontext>().live.size() > 3)
             return CUDA_ERROR_NOT_READY;
         const CUresult result = cuCtxCreate(
             context, nullptr, w.chance(90) ? 0 : w.any32(), argument<CUdevice>(w));
         if (result == CUDA_SUCCESS)
             w.keep(*context);
         return result;
     }},
    {"cuCtxDestroy", 1,
     [](World& w) {
         const auto context = w.handle<CUcontext>();
         if (context == w.primary)
             return CUDA_ERROR_NOT_READY;
         const CUresult result = cuCtxDestroy(context);
         if (result == CUDA_SUCCESS)
             w.died(context);
         return result;
     }},
    CALL(cuCtxPushCurrent, 1),
    CALL(cuCtxPopCurrent, 1),
    // A high weight: few calls work without a current context.
    {"cuCtxSetCurrent", 10,
     [](World& w) { return cuCtxSetCurrent(w.chance(90) ? w.primary : w.handle<CUcontext>()); }},
    CALL(cuCtxGetCurrent, 1),
    CALL(cuCtxGetDevice, 1),
    CALL(cuCtxGetFlags, 1),
    CALL(cuCtxSetFlags, 1),
    CALL(cuCtxGetId, 1),
    CALL(cuCtxSynchronize, 1),
    CALL(cuCtxGetApiVersion, 1),
    {"cuCtxSetLimit", 1,
     [](World& w) { // a stack of any size is mapped, but not of any number of threads
         const auto limit = argument<CUlimit>(w);
         return cuCtxSetLimit(limit, limit == CU_LIMIT_STACK_SIZE ? w.below(5000) : w.size());
     }},
    CALL(cuCtxGetLimit, 1),
    CALL(cuCtxGetCacheConfig, 1),
    CALL(cuCtxSetCacheConfig, 1),
    CALL(cuCtxGetSharedMemConfig, 1),
    CALL(cuCtxSetSharedMemConfig, 1),
    CALL(cuCtxResetPersistingL2Cache, 1),
    CALL(cuCtxGetStreamPriorityRange, 1),
    CALL(cuCtxEnablePeerAccess, 1),
    CALL(cuCtxDisablePeerAccess, 1),

    {"cuModuleLoadDataEx", 2,
     [](World& w) {
         CUmodule* const module = argument<CUmodule*>(w);
         const CUresult result = jit(w, [&](unsigned count, CUjit_option* options, void** values) {
             return cuModuleLoadDataEx(module, w.chance(95) ? kText : nullptr, count, options,
                                       values);
         });
         if (result == CUDA_SUCCESS)
             w.keep(*module);
         return result;
     }},
    END(cuModuleUnload),
    CALL(cuModuleGetFunction, 5),
    CALL(cuModuleGetFunctionCount, 1),
    {"cuModuleEnumerateFunctions", 1,
     [](World& w) {
         const unsigned count = unsigned(w.below(4));
         return cuModuleEnumerateFunctions(w.result<CUfunction>(count), count,
                                           w.handle<CUmodule>());
     }},
    CALL(cuModuleGetGlobal, 2),
    CALL(cuModuleGetTexRef, 2),
    CALL(cuModuleGetSurfRef, 2),
    CALL(cuModuleGetLoadingMode, 1),
    CALL(cuModuleLoad, 1),
    {"cuLinkCreate", 1,
     [](World& w) {
         CUlinkState* const link = argument<CUlinkState*>(w);
         const CUresult result = jit(w, [&](unsigned count, CUjit_option* options, void** values) {
             // The link writes to the options' targets until it ends.
             return cuLinkCreate(w.chance(70) ? 0 : count, w.chance(70) ? nullptr : options, nullptr,
                                 (void(values), link));
         });
         if (result == CUDA_SUCCESS)
             w.keep(*link);
         return result;
     }},
    {"cuLinkAddData", 2,
     [](World& w) {
         static std::string image = kText;
         return cuLinkAddData(w.handle<CUlinkState>(), argument<CUjitInputType>(w),
                              w.chance(95) ? image.data() : nullptr, w.below(image.size() + 2),
                              w.chance(90) ? "name" : nullptr, 0, nullptr, nullptr);
     }},
    CALL(cuLinkComplete, 1),
    END(cuLinkDestroy),
    CALL(cuFuncGetAttribute, 2),
    CALL(cuFuncSetAttribute, 2),
    CALL(cuFuncSetCacheConfig, 1),
    CALL(cuFuncSetSharedMemConfig, 1),
    CALL(cuFuncGetModule, 1),
    CALL(cuFuncGetName, 1),
    CALL(cuFuncGetParamInfo, 1),
    CALL(cuFuncIsLoaded, 1),
    CALL(cuFuncLoad, 2),
    {"cuLaunchKernel", 8,
     [](World& w) {
         uint64_t buffer[5] = {};
         size_t size = w.chance(80) ? sizeof buffer : w.below(sizeof buffer);
         void* extra[] = {CU_LAUNCH_PARAM_BUFFER_POINTER, buffer, CU_LAUNCH_PARAM_BUFFER_SIZE,
                          &size, CU_LAUNCH_PARAM_END};
         const bool packs = w.chance(20);
         return cuLaunchKernel(w.handle<CUfunction>(), dimension(w), dimension(w), dimension(w),
                               dimension(w), dimension(w), dimension(w),
                               w.chance(90) ? 0 : w.any32(), w.handle<CUstream>(),
                               packs ? nullptr : parameters(w), packs ? extra : nullptr);
     }},
    {"cuLaunchKernelEx", 3,
     [](World& w) {
         const unsigned count = unsigned(w.below(4));
         auto* const attributes = w.result<CUlaunchAttribute>(count);
         for (unsigned i = 0; i < count; ++i) {
             attributes[i].id = unsigned(w.chance(95) ? w.below(20) : size_t(w.any32()));
             fill(w, attributes[i].value);
         }
         const CUlaunchConfig config{dimension(w), dimension(w), dimension(w),
                                     dimension(w), dimension(w), dimension(w),
                                     w.chance(90) ? 0 : w.any32(), w.handle<CUstream>(),
                                     w.chance(95) ? attributes : nullptr, count};
         return cuLaunchKernelEx(w.chance(97) ? &config : nullptr, w.handle<CUfunction>(),
                                 parameters(w), nullptr);
     }},
    {"cuLaunchCooperativeKernel", 2,
     [](World& w) {
         return cuLaunchCooperativeKernel(w.handle<CUfunction>(), dimension(w), dimension(w),
                                          dimension(w), dimension(w), dimension(w), dimension(w),
                                          w.chance(90) ? 0 : w.any32(), w.handle<CUstream>(),
                                          parameters(w));
     }},
    CALL(cuOccupancyMaxActiveBlocksPerMultiprocessor, 1),
    CALL(cuOccupancyMaxActiveBlocksPerMultiprocessorWithFlags, 1),
    {"cuOccupancyMaxPotentialBlockSize", 1,
     [](World& w) {
         return cuOccupancyMaxPotentialBlockSize(argument<int*>(w), argument<int*>(w),
                                                 w.handle<CUfunction>(),
                                                 w.chance(50) ? sharedBytesOf : nullptr, w.size(),
                                                 int(w.any32()));
     }},
    CALL(cuOccupancyAvailableDynamicSMemPerBlock, 1),
    {"cuLibraryLoadData", 2,
     [](World& w) {
         CUlibrary* const library = argument<CUlibrary*>(w);
         CUlibraryOption option = argument<CUlibraryOption>(w);
         void* value = reinterpret_cast<void*>(w.below(3));
         const bool has = option != CU_LIBRARY_HOST_UNIVERSAL_FUNCTION_AND_DATA_TABLE && w.chance(20);
         const CUresult result = cuLibraryLoadData(library, w.chance(95) ? kText : nullptr, nullptr,
                                                   nullptr, 0, &option, &value, has);
         if (result == CUDA_SUCCESS)
             w.keep(*library);
         return result;
     }},
    END(cuLibraryUnload),
    CALL(cuLibraryGetKernel, 2),
    CALL(cuLibraryGetKernelCount, 1),
    {"cuLibraryEnumerateKernels", 1,
     [](World& w) {
         const unsigned count = unsigned(w.below(4));
         return cuLibraryEnumerateKernels(w.result<CUkernel>(count), count, w.handle<CUlibrary>());
     }},
    CALL(cuLibraryGetModule, 1),
    CALL(cuLibraryGetGlobal, 1),
    CALL(cuLibraryGetManaged, 1),
    CALL(cuLibraryGetUnifiedFunction, 1),
    CALL(cuKernelGetFunction, 2),
    CALL(cuKernelGetLibrary, 1),
    CALL(cuKernelGetName, 1),
    CALL(cuKernelGetParamInfo, 1),
    CALL(cuKernelGetAttribute, 1),
    CALL(cuKernelSetAttribute, 1),
    CALL(cuKernelSetCacheConfig, 1),

    CALL(cuMemGetInfo, 1),
    CALL(cuMemAlloc, 5),
    CALL(cuMemAllocPitch, 2),
    CALL(cuMemAllocManaged, 3),
    {"cuMemFree", 3,
     [](World& w) {
         const CUdeviceptr address = w.address();
         if (address == w.device)
             return CUDA_ERROR_NOT_READY;
         const CUresult result = cuMemFree(address);
         if (result == CUDA_SUCCESS && std::erase(w.addresses.live, address))
             w.addresses.dead.push_back(address);
         return result;
     }},
    CALL(cuMemGetAddressRange, 2),
    {"cuMemHostAlloc", 1,
     [](World& w) {
         void** const place = argument<void**>(w);
         const CUresult result = cuMemHostAlloc(place, w.size(), w.any32());
         if (result == CUDA_SUCCESS)
             w.addresses.live.push_back(reinterpret_cast<CUdeviceptr>(*place));
         return result;
     }},
    {"cuMemFreeHost", 1,
     [](World& w) { return cuMemFreeHost(reinterpret_cast<void*>(w.address())); }},
    {"cuMemHostGetDevicePointer", 1,
     [](World& w) {
         return cuMemHostGetDevicePointer(argument<CUdeviceptr*>(w),
                                          w.chance(50) ? reinterpret_cast<void*>(w.address())
                                                       : w.host,
                                          w.chance(90) ? 0 : w.any32());
     }},
    {"cuMemHostGetFlags", 1,
     [](World& w) {
         return cuMemHostGetFlags(argument<unsigned*>(w), reinterpret_cast<void*>(w.address()));
     }},
    {"cuMemHostRegister", 1,
     [](World& w) {
         // Handles are among the addresses: memory of the library must not be registered.
         return cuMemHostRegister(w.chance(80) ? w.host + w.below(3) * 4096
                                               : reinterpret_cast<char*>(w.wrongAddress()),
                                  w.size(), w.chance(80) ? w.below(4) : w.any32());
     }},
    {"cuMemHostUnregister", 1,
     [](World& w) { return cuMemHostUnregister(w.host + w.below(3) * 4096); }},
    {"cuPointerGetAttribute", 3,
     [](World& w) {
         return cuPointerGetAttribute(w.chance(97) ? w.result<Widest>() : nullptr,
                                      argument<CUpointer_attribute>(w), w.address());
     }},
    {"cuPointerGetAttributes", 2,
     [](World& w) {
         const unsigned count = unsigned(w.below(5));
         auto* const attributes = w.result<CUpointer_attribute>(count);
         auto* const places = w.result<void*>(count);
         for (unsigned i = 0; i < count; ++i) {
             attributes[i] = argument<CUpointer_attribute>(w);
             places[i] = w.chance(95) ? w.result<Widest>() : nullptr;
         }
         return cuPointerGetAttributes(count, w.chance(97) ? attributes : nullptr,
                                       w.chance(97) ? places : nullptr, w.address());
     }},
    {"cuPointerSetAttribute", 1,
     [](World& w) {
         return cuPointerSetAttribute(w.chance(97) ? w.result<Widest>() : nullptr,
                                      argument<CUpointer_attribute>(w), w.address());
     }},
    {"cuMemRangeGetAttribute", 2,
     [](World& w) {
         const size_t size = w.chance(70) ? 4 : w.below(20);
         return cuMemRangeGetAttribute(w.result<char>(size), size,
                                       argument<CUmem_range_attribute>(w), w.address(), w.size());
     }},
    {"cuMemRangeGetAttributes", 1,
     [](World& w) {
         const size_t count = w.below(4);
         auto* const attributes = w.result<CUmem_range_attribute>(count);
         auto* const places = w.result<void*>(count);
         auto* const sizes = w.result<size_t>(count);
         for (size_t i = 0; i < count; ++i) {
             attributes[i] = argument<CUmem_range_attribute>(w);
             sizes[i] = w.chance(70) ? 4 : w.below(20);
             places[i] = w.chance(95) ? w.result<char>(sizes[i]) : nullptr;
         }
         return cuMemRangeGetAttributes(places, sizes, attributes, count, w.address(), w.size());
     }},
    CALL(cuMemAdvise, 3),
    {"cuMemPrefetchAsync", 2,
     [](World& w) {
         return cuMemPrefetchAsync(w.lasting(), w.size(), argument<CUmemLocation>(w),
                                   w.chance(90) ? 0 : w.any32(), w.handle<CUstream>());
     }},
    {"cuMemAllocAsync", 2,
     [](World& w) {
         auto* const place = argument<CUdeviceptr*>(w);
         const size_t size = w.size();
         const auto stream = w.handle<CUstream>();
         const CUresult result = cuMemAllocAsync(place, size, stream);
         if (result == CUDA_SUCCESS)
             harvest(w, place), w.afterOrdered(stream);
         return result;
     }},
    {"cuMemAllocFromPoolAsync", 2,
     [](World& w) {
         auto* const place = argument<CUdeviceptr*>(w);
         const size_t size = w.size();
         const auto pool = w.handle<CUmemoryPool>();
         const auto stream = w.handle<CUstream>();
         const CUresult result = cuMemAllocFromPoolAsync(place, size, pool, stream);
         if (result == CUDA_SUCCESS)
             harvest(w, place), w.afterOrdered(stream);
         return result;
     }},
    {"cuMemFreeAsync", 2,
     [](World& w) {
         const CUdeviceptr address = w.address();
         if (address == w.device)
             return CUDA_ERROR_NOT_READY;
         const auto stream = w.handle<CUstream>();
         const CUresult result = cuMemFreeAsync(address, stream);
         if (result == CUDA_SUCCESS)
             w.afterOrdered(stream);
         if (result == CUDA_SUCCESS && std::erase(w.addresses.live, address))
             w.addresses.dead.push_back(address);
         return result;
     }},
    CALL(cuMemPoolCreate, 2),
    END(cuMemPoolDestroy),
    CALL(cuMemPoolTrimTo, 1),
    {"cuMemPoolSetAttribute", 1,
     [](World& w) {
         auto* const value = w.result<uint64_t>();
         *value = w.size();
         return cuMemPoolSetAttribute(w.handle<CUmemoryPool>(), argument<CUmemPool_attribute>(w),
                                      w.chance(97) ? value : nullptr);
     }},
    {"cuMemPoolGetAttribute", 1,
     [](World& w) {
         return cuMemPoolGetAttribute(w.handle<CUmemoryPool>(), argument<CUmemPool_attribute>(w),
                                      w.chance(97) ? w.result<uint64_t>() : nullptr);
     }},
    {"cuMemPoolSetAccess", 1,
     [](World& w) {
         const size_t count = w.below(3);
         auto* const map = w.result<CUmemAccessDesc>(count);
         for (size_t i = 0; i < count; ++i)
             fill(w, map[i]);
         return cuMemPoolSetAccess(w.handle<CUmemoryPool>(), map, count);
     }},
    CALL(cuMemPoolGetAccess, 1),
    CALL(cuDeviceGetDefaultMemPool, 1),
    CALL(cuDeviceGetMemPool, 1),
    CALL(cuDeviceSetMemPool, 1),
    CALL(cuMemGetDefaultMemPool, 1),
    CALL(cuMemGetMemPool, 1),
    CALL(cuMemSetMemPool, 1),
    {"cuMemAddressReserve", 3,
     [](World& w) {
         CUdeviceptr* const place = argument<CUdeviceptr*>(w);
         const CUresult result = cuMemAddressReserve(
             place, w.chance(80) ? (1 + w.below(3)) << 21 : w.size(), w.chance(80) ? 0 : w.size(),
             w.chance(70) ? 0 : w.address(), w.chance(90) ? 0 : w.any32());
         harvest(w, result == CUDA_SUCCESS ? place : nullptr);
         return result;
     }},
    {"cuMemCreate", 3,
     [](World& w) {
         auto* const handle = argument<CUmemGenericAllocationHandle*>(w);
         const auto* const properties = argument<const CUmemAllocationProp*>(w);
         const CUresult result =
             cuMemCreate(handle, w.chance(80) ? (1 + w.below(3)) << 21 : w.size(), properties,
                         w.chance(90) ? 0 : w.any32());
         harvest(w, result == CUDA_SUCCESS ? handle : nullptr);
         return result;
     }},
    {"cuMemMap", 6,
     [](World& w) {
         return cuMemMap(w.address(), w.chance(80) ? (1 + w.below(3)) << 21 : w.size(),
                         w.chance(80) ? 0 : w.size(), w.address(), w.chance(90) ? 0 : w.any32());
     }},
    {"cuMemUnmap", 2,
     [](World& w) {
         return cuMemUnmap(w.address(), w.chance(80) ? (1 + w.below(3)) << 21 : w.size());
     }},
    {"cuMemAddressFree", 2,
     [](World& w) {
         return cuMemAddressFree(w.address(), w.chance(80) ? (1 + w.below(3)) << 21 : w.size());
     }},
    {"cuMemSetAccess", 3,
     [](World& w) {
         const size_t count = w.below(3);
         auto* const map = w.result<CUmemAccessDesc>(count);
         for (size_t i = 0; i < count; ++i)
             fill(w, map[i]);
         return cuMemSetAccess(w.address(), w.chance(80) ? (1 + w.below(3)) << 21 : w.size(), map,
                               count);
     }},
    CALL(cuMemGetAllocationGranularity, 1),
    CALL(cuMemRelease, 1),
    {"cuMemRetainAllocationHandle", 1,
     [](World& w) {
         auto* const handle = argument<CUmemGenericAllocationHandle*>(w);
         const CUresult result =
             cuMemRetainAllocationHandle(handle, reinterpret_cast<void*>(w.address()));
         harvest(w, result == CUDA_SUCCESS ? handle : nullptr);
         return result;
     }},
    CALL(cuMemGetAllocationPropertiesFromHandle, 1),
    CALL(cuMemGetAccess, 1),

    {"cuMemcpy", 2,
     [](World& w) { // any memory of the process will do: freed memory must not be used
         return cuMemcpy(w.lasting(), w.lasting(), w.size());
     }},
    {"cuMemcpyAsync", 2,
     [](World& w) {
         return cuMemcpyAsync(w.lasting(), w.lasting(), w.size(), w.handle<CUstream>());
     }},
    {"cuMemcpyPeer", 1,
     [](World& w) {
         return cuMemcpyPeer(w.lasting(), w.handle<CUcontext>(), w.lasting(),
                             w.handle<CUcontext>(), w.size());
     }},
    {"cuMemcpyHtoD", 3, copyUp<cuMemcpyHtoD>},
    {"cuMemcpyDtoH", 3, copyDown<cuMemcpyDtoH>},
    CALL(cuMemcpyDtoD, 3),
    {"cuMemcpyHtoDAsync", 2,
     [](World& w) {
         const size_t size = w.size();
         return cuMemcpyHtoDAsync(w.lasting(), w.hostMemory(size), size, w.handle<CUstream>());
     }},
    {"cuMemcpyDtoHAsync", 2,
     [](World& w) {
         const size_t size = w.size();
         return cuMemcpyDtoHAsync(w.hostMemory(size), w.lasting(), size, w.handle<CUstream>());
     }},
    CALL(cuMemcpyDtoA, 2),
    CALL(cuMemcpyAtoD, 2),
    CALL(cuMemcpyAtoA, 2),
    {"cuMemcpyHtoA", 2,
     [](World& w) {
         const size_t size = w.size();
         return cuMemcpyHtoA(w.handle<CUarray>(), w.below(2) * 8 * w.below(10), w.hostMemory(size),
                             size);
     }},
    {"cuMemcpyAtoH", 2,
     [](World& w) {
         const size_t size = w.size();
         return cuMemcpyAtoH(w.hostMemory(size), w.handle<CUarray>(), w.size(), size);
     }},
    CALL(cuMemcpy2D, 6),
    CALL(cuMemcpy2DUnaligned, 2),
    CALL(cuMemcpy3D, 8),
    CALL(cuMemcpy3DPeer, 2),
    {"cuMemcpy3DAsync", 4,
     [](World& w) {
         const CUDA_MEMCPY3D copy = lastingCopy(w);
         return cuMemcpy3DAsync(&copy, w.handle<CUstream>());
     }},
    CALL(cuMemsetD8, 2),
    CALL(cuMemsetD16, 2),
    CALL(cuMemsetD32, 2),
    CALL(cuMemsetD2D8, 2),
    CALL(cuMemsetD2D16, 2),
    CALL(cuMemsetD2D32, 2),
    {"cuMemsetD32Async", 2,
     [](World& w) {
         return cuMemsetD32Async(w.lasting(), w.any32(), w.size(), w.handle<CUstream>());
     }},
    {"cuMemsetD2D16Async", 2,
     [](World& w) {
         return cuMemsetD2D16Async(w.lasting(), w.size(), uint16_t(w.any32()), w.size(), w.size(),
                                   w.handle<CUstream>());
     }},

    CALL(cuArrayCreate, 3),
    CALL(cuArray3DCreate, 4),
    CALL(cuArrayGetDescriptor, 1),
    CALL(cuArray3DGetDescriptor, 1),
    {"cuArrayDestroy", 2,
     [](World& w) {
         const auto array = w.handle<CUarray>();
         if (array == w.array)
             return CUDA_ERROR_NOT_READY;
         const CUresult result = cuArrayDestroy(array);
         if (result == CUDA_SUCCESS)
             w.died(array);
         return result;
     }},
    CALL(cuMipmappedArrayCreate, 3),
    CALL(cuMipmappedArrayGetLevel, 2),
    END(cuMipmappedArrayDestroy),
    CALL(cuTexObjectCreate, 8),
    CALL(cuTexObjectDestroy, 1),
    CALL(cuTexObjectGetResourceDesc, 1),
    CALL(cuTexObjectGetTextureDesc, 1),
    CALL(cuTexObjectGetResourceViewDesc, 1),
    CALL(cuSurfObjectCreate, 3),
    CALL(cuSurfObjectDestroy, 1),
    CALL(cuSurfObjectGetResourceDesc, 1),
    CALL(cuTexRefCreate, 1),
    END(cuTexRefDestroy),
    CALL(cuTexRefSetArray, 2),
    CALL(cuTexRefSetMipmappedArray, 2),
    CALL(cuTexRefSetAddress, 2),
    CALL(cuTexRefSetAddress2D, 2),
    CALL(cuTexRefSetFormat, 1),
    CALL(cuTexRefSetAddressMode, 1),
    CALL(cuTexRefSetFilterMode, 1),
    CALL(cuTexRefSetMipmapFilterMode, 1),
    CALL(cuTexRefSetMipmapLevelBias, 1),
    CALL(cuTexRefSetMipmapLevelClamp, 1),
    CALL(cuTexRefSetMaxAnisotropy, 1),
    CALL(cuTexRefSetFlags, 1),
    {"cuTexRefSetBorderColor", 1,
     [](World& w) {
         return cuTexRefSetBorderColor(w.handle<CUtexref>(),
                                       w.chance(95) ? w.result<float>(4) : nullptr);
     }},
    {"cuTexRefGetBorderColor", 1,
     [](World& w) {
         return cuTexRefGetBorderColor(w.chance(95) ? w.result<float>(4) : nullptr,
                                       w.handle<CUtexref>());
     }},
    CALL(cuTexRefGetAddress, 1),
    CALL(cuTexRefGetArray, 1),
    CALL(cuTexRefGetMipmappedArray, 1),
    CALL(cuTexRefGetFormat, 1),
    CALL(cuTexRefGetAddressMode, 1),
    CALL(cuTexRefGetFilterMode, 1),
    CALL(cuTexRefGetMipmapFilterMode, 1),
    CALL(cuTexRefGetMipmapLevelBias, 1),
    CALL(cuTexRefGetMipmapLevelClamp, 1),
    CALL(cuTexRefGetMaxAnisotropy, 1),
    CALL(cuTexRefGetFlags, 1),
    CALL(cuSurfRefSetArray, 1),
    CALL(cuSurfRefGetArray, 1),
    CALL(cuParamSetTexRef, 1),

    CALL(cuStreamCreate, 2),
    CALL(cuStreamCreateWithPriority, 1),
    END(cuStreamDestroy),
    CALL(cuStreamGetPriority, 1),
    CALL(cuStreamGetFlags, 1),
    CALL(cuStreamGetId, 1),
    CALL(cuStreamGetCtx, 1),
    CALL(cuStreamGetDevice, 1),
    CALL(cuStreamWaitEvent, 3),
    {"cuStreamAddCallback", 1,
     [](World& w) {
         return cuStreamAddCallback(w.handle<CUstream>(), w.chance(95) ? callback : nullptr,
                                    &gCalled, w.chance(90) ? 0 : w.any32());
     }},
    {"cuLaunchHostFunc", 2,
     [](World& w) {
         return cuLaunchHostFunc(w.handle<CUstream>(), w.chance(95) ? hostFunction : nullptr,
                                 &gCalled);
     }},
    CALL(cuStreamQuery, 1),
    CALL(cuStreamSynchronize, 1),
    CALL(cuStreamIsCapturing, 1),
    {"cuStreamAttachMemAsync", 1,
     [](World& w) {
         return cuStreamAttachMemAsync(w.handle<CUstream>(), w.address(), w.size(), w.any32());
     }},
    {"cuStreamWriteValue32", 1,
     [](World& w) {
         return cuStreamWriteValue32(w.handle<CUstream>(), w.lasting(), w.any32(),
                                     w.chance(90) ? 0 : w.any32());
     }},
    {"cuStreamWriteValue64", 1,
     [](World& w) {
         return cuStreamWriteValue64(w.handle<CUstream>(), w.lasting(), w.any32(),
                                     w.chance(90) ? 0 : w.any32());
     }},
    {"cuStreamBatchMemOp", 2,
     [](World& w) {
         const unsigned count = unsigned(w.below(4));
         auto* const list = w.result<CUstreamBatchMemOpParams>(count);
         for (unsigned i = 0; i < count; ++i) {
             list[i].operation = CUstreamBatchMemOpType(w.below(8));
             list[i].writeValue.address = w.lasting();
             list[i].writeValue.flags = w.chance(90) ? 0 : w.any32();
             // Such a wait might never end.
             if (list[i].operation == CU_STREAM_MEM_OP_WAIT_VALUE_32 ||
                 list[i].operation == CU_STREAM_MEM_OP_WAIT_VALUE_64)
                 list[i].operation = CU_STREAM_MEM_OP_BARRIER;
         }
         return cuStreamBatchMemOp(w.handle<CUstream>(), count, w.chance(97) ? list : nullptr,
                                   w.chance(90) ? 0 : w.any32());
     }},
    CALL(cuStreamGetAttribute, 1),
    CALL(cuStreamSetAttribute, 1),
    CALL(cuStreamCopyAttributes, 1),
    CALL(cuEventCreate, 2),
    CALL(cuEventRecord, 3),
    CALL(cuEventRecordWithFlags, 1),
    CALL(cuEventQuery, 1),
    CALL(cuEventSynchronize, 1),
    END(cuEventDestroy),
    CALL(cuEventElapsedTime, 1),

    CALL(cuStreamBeginCapture, 3),
    CALL(cuStreamEndCapture, 6),
    {"cuStreamBeginCaptureToGraph", 1,
     [](World& w) {
         const Nodes before(w);
         return cuStreamBeginCaptureToGraph(w.handle<CUstream>(), w.handle<CUgraph>(), before.list,
                                            nullptr, before.count,
                                            argument<CUstreamCaptureMode>(w));
     }},
    {"cuStreamGetCaptureInfo", 2,
     [](World& w) {
         const auto place = [&](auto value) {
             return w.chance(70) ? w.result<decltype(value)>() : nullptr;
         };
         return cuStreamGetCaptureInfo(
             w.handle<CUstream>(), place(CUstreamCaptureStatus{}), place(cuuint64_t{}),
             place(CUgraph{}), place(static_cast<const CUgraphNode*>(nullptr)),
             place(static_cast<const CUgraphEdgeData*>(nullptr)), place(size_t{}));
     }},
    {"cuStreamUpdateCaptureDependencies", 2,
     [](World& w) {
         const Nodes nodes(w);
         return cuStreamUpdateCaptureDependencies(w.handle<CUstream>(), nodes.list, nullptr,
                                                  nodes.count,
                                                  unsigned(w.chance(90) ? w.below(2) : 7));
     }},
    CALL(cuThreadExchangeStreamCaptureMode, 1),
    CALL(cuGraphCreate, 4),
    END(cuGraphDestroy),
    CALL(cuGraphClone, 2),
    CALL(cuGraphNodeFindInClone, 1),
    END(cuGraphDestroyNode),
    NODE(cuGraphAddKernelNode),
    {"cuGraphAddMemcpyNode", 3, addCopy},
    NODE(cuGraphAddMemsetNode),
    NODE(cuGraphAddHostNode),
    NODE(cuGraphAddChildGraphNode),
    NODE(cuGraphAddEmptyNode),
    NODE(cuGraphAddEventRecordNode),
    NODE(cuGraphAddEventWaitNode),
    CALL(cuGraphKernelNodeGetAttribute, 1),
    CALL(cuGraphKernelNodeSetAttribute, 1),
    CALL(cuGraphKernelNodeCopyAttributes, 1),
    CALL(cuGraphKernelNodeGetParams, 1),
    CALL(cuGraphKernelNodeSetParams, 2),
    CALL(cuGraphMemcpyNodeGetParams, 1),
    {"cuGraphMemcpyNodeSetParams", 2,
     [](World& w) {
         const CUDA_MEMCPY3D copy = lastingCopy(w);
         return cuGraphMemcpyNodeSetParams(w.handle<CUgraphNode>(), &copy);
     }},
    CALL(cuGraphMemsetNodeGetParams, 1),
    CALL(cuGraphMemsetNodeSetParams, 1),
    CALL(cuGraphHostNodeGetParams, 1),
    CALL(cuGraphHostNodeSetParams, 1),
    CALL(cuGraphChildGraphNodeGetGraph, 1),
    CALL(cuGraphEventRecordNodeGetEvent, 1),
    CALL(cuGraphEventWaitNodeGetEvent, 1),
    CALL(cuGraphNodeGetType, 1),
    {"cuGraphGetNodes", 1, listNodes<cuGraphGetNodes, CUgraph, false>},
    {"cuGraphGetRootNodes", 1, listNodes<cuGraphGetRootNodes, CUgraph, false>},
    {"cuGraphNodeGetDependencies", 1, listNodes<cuGraphNodeGetDependencies, CUgraphNode, true>},
    {"cuGraphNodeGetDependentNodes", 1, listNodes<cuGraphNodeGetDependentNodes, CUgraphNode, true>},
    {"cuGraphGetEdges", 1,
     [](World& w) {
         size_t* const count = w.result<size_t>();
         *count = w.below(5);
         const bool asks = w.chance(60);
         return cuGraphGetEdges(w.handle<CUgraph>(), asks ? w.result<CUgraphNode>(*count) : nullptr,
                                asks ? w.result<CUgraphNode>(*count) : nullptr, nullptr, count);
     }},
    {"cuGraphAddDependencies", 3, changeEdges<cuGraphAddDependencies>},
    {"cuGraphRemoveDependencies", 1, changeEdges<cuGraphRemoveDependencies>},
    {"cuGraphInstantiate", 6,
     [](World& w) {
         CUgraphExec* const exec = argument<CUgraphExec*>(w);
         const CUresult result = cuGraphInstantiate(exec, w.handle<CUgraph>(),
                                                    w.chance(90) ? w.below(3) : w.any32());
         if (result == CUDA_SUCCESS)
             w.keep(*exec);
         return result;
     }},
    CALL(cuGraphInstantiateWithParams, 2),
    CALL(cuGraphExecGetFlags, 1),
    CALL(cuGraphUpload, 1),
    CALL(cuGraphLaunch, 8),
    END(cuGraphExecDestroy),
    CALL(cuGraphExecUpdate, 3),
    CALL(cuGraphExecKernelNodeSetParams, 2),
    {"cuGraphExecMemcpyNodeSetParams", 2,
     [](World& w) {
         const CUDA_MEMCPY3D copy = lastingCopy(w);
         return cuGraphExecMemcpyNodeSetParams(w.handle<CUgraphExec>(), w.handle<CUgraphNode>(),
                                               &copy, w.handle<CUcontext>());
     }},
    CALL(cuGraphExecMemsetNodeSetParams, 2),
    CALL(cuGraphExecHostNodeSetParams, 1),
    CALL(cuGraphNodeSetEnabled, 1),
    CALL(cuGraphNodeGetEnabled, 1),
};

void runSequence(unsigned long number, unsigned count) {
    gSequence = number;
    gCall = "the start of the sequence";
    World w(number);
    size_t total = 0;
    for (const Call& call : kCalls)
        total += size_t(call.weight);
    for (unsigned i = 0; i < count; ++i) {
        size_t at = w.below(total);
        const Call* call = kCalls;
        for (; at >= size_t(call->weight); ++call)
            at -= size_t(call->weight);
        gCall = call->name;
        if (gPrints) {
            std::printf("%u: %s", i, call->name);
            std::fflush(stdout);
        }
        alarm(120); // no call takes that long
        const CUresult result = call->run(w);
        alarm(0);
        const char* name = nullptr;
        if (cuGetErrorName(result, &name) != CUDA_SUCCESS || !name) {
            std::fprintf(stderr, "%s gave %d, which is no result\n", call->name, int(result));
            std::abort();
        }
        if (gPrints)
            std::printf(" = %s\n", name);
        ++gCounts[call->name][result == CUDA_SUCCESS];
        w.forgetResults();
    }
    gCall = "the end of the sequence";
    alarm(120);
}

} // namespace

int main(int argc, char** argv) {
    uint64_t seconds = 10, start = 0, sequence = 0, calls = 150;
    fuzz::readOptions(argc, argv, "fuzz_cuda [--seconds N] [--start N] [--sequence N] [--calls N]",
                      {{"--seconds", &seconds},
                       {"--start", &start},
                       {"--sequence", &sequence},
                       {"--calls", &calls}});
    fuzz::setLastWords(tellWhere, SIGALRM);
    setenv("OPTIX_CACHE_MAXSIZE", "0", 1);
    setenv("SUNSTONE_LOG", sequence ? "error" : "off", 0);
    if (cuInit(0) != CUDA_SUCCESS) {
        std::fprintf(stderr, "no driver\n");
        return 1;
    }
    if (sequence) {
        for (uint64_t number = start ? start : sequence; number < sequence; ++number)
            runSequence(number, unsigned(calls));
        gPrints = true;
        runSequence(sequence, unsigned(calls));
        return 0;
    }
    start = std::max<uint64_t>(start, 1);
    const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(seconds);
    unsigned long ran = 0;
    for (; std::chrono::steady_clock::now() < end; ++ran)
        runSequence(start + ran, unsigned(calls));
    std::printf("%-55s %10s %10s\n", "function", "success", "refused");
    for (const auto& [name, count] : gCounts)
        std::printf("%-55s %10lu %10lu\n", name.c_str(), count[1], count[0]);
    std::printf("%lu sequences\n", ran);
    return 0;
}
