// SPDX-License-Identifier: Apache-2.0
// Calls functions of the driver API on objects of a context while that context is current and while
// none is, and prints both results. The expected output is a driver's.
#include "driver_cases.h"

#include <functional>
#include <utility>

namespace {

const char* const kPtx = R"(
.version 7.0
.target sm_70
.address_size 64
.global .u32 counter;
.global .texref reference;
.global .surfref surface;
.visible .entry kernel(.param .u64 out) {
    .reg .u64 %a;
    ld.param.u64 %a, [out];
    st.global.u32 [%a], 1;
    ret;
}
)";

CUcontext own;
CUdevice device;

void CUDA_CB hostFunction(void*) {}
void CUDA_CB callback(CUstream, CUresult, void*) {}

// Objects of the context `own`.
struct World {
    CUstream stream = nullptr, second = nullptr;
    CUevent event = nullptr, later = nullptr;
    CUdeviceptr memory = 0, managed = 0, ordered = 0;
    void *pinned = nullptr, *registered = nullptr, *unregistered = nullptr;
    CUarray array = nullptr, line = nullptr;
    CUmipmappedArray mipmapped = nullptr;
    CUmodule module = nullptr;
    CUfunction function = nullptr;
    CUtexref reference = nullptr;
    CUsurfref surface = nullptr;
    CUtexObject texture = 0;
    CUsurfObject surfaceObject = 0;
    CUlibrary library = nullptr;
    CUkernel kernel = nullptr;
    CUmemoryPool pool = nullptr;
    CUgraph graph = nullptr, copy = nullptr;
    CUgraphNode empty = nullptr, launch = nullptr, set = nullptr, host = nullptr, record = nullptr,
                wait = nullptr, child = nullptr;
    CUgraphExec exec = nullptr;
    CUuserObject object = nullptr;
    CUgraphNode newNode = nullptr;
    CUDA_KERNEL_NODE_PARAMS launchParams = {};
    CUDA_MEMSET_NODE_PARAMS setParams = {};
    CUDA_HOST_NODE_PARAMS hostParams = {hostFunction, nullptr};
    CUDA_RESOURCE_DESC resource = {};
    CUDA_TEXTURE_DESC sampling = {};
    CUlaunchConfig config = {};
    void* arguments[1] = {&memory};
    char bytes[4096] = {};
    // Where results go.
    int number = 0;
    size_t size = 0;
    unsigned value = 0;
    unsigned long long id = 0;
    float milliseconds = 0;
    void* pointer = nullptr;
    CUdeviceptr address = 0;

    void makeMemory();
    void makeCode();
    void makeGraph();
    World() {
        MUST(cuCtxSetCurrent(own));
        MUST(cuStreamCreate(&stream, CU_STREAM_NON_BLOCKING));
        MUST(cuStreamCreate(&second, CU_STREAM_NON_BLOCKING));
        MUST(cuEventCreate(&event, 0));
        MUST(cuEventCreate(&later, 0));
        MUST(cuEventRecord(event, stream));
        MUST(cuEventRecord(later, stream));
        makeMemory();
        makeCode();
        makeGraph();
        MUST(cuCtxSynchronize());
    }
    ~World() {
        MUST(cuCtxSetCurrent(own));
        CUstreamCaptureStatus status = CU_STREAM_CAPTURE_STATUS_NONE;
        if (cuStreamIsCapturing(stream, &status) == CUDA_SUCCESS && status != 0) {
            CUgraph captured = nullptr;
            cuStreamEndCapture(stream, &captured);
        }
        MUST(cuCtxSynchronize());
        // Drivers crash for handles that are no longer valid.
        if (exec)
            cuGraphExecDestroy(exec);
        if (graph)
            cuGraphDestroy(graph);
        cuGraphDestroy(copy);
        cuStreamDestroy(stream);
        if (second)
            cuStreamDestroy(second);
        if (module)
            cuModuleUnload(module);
        if (library)
            cuLibraryUnload(library);
        if (event)
            cuEventDestroy(event);
        cuEventDestroy(later);
        if (texture)
            cuTexObjectDestroy(texture);
        if (surfaceObject)
            cuSurfObjectDestroy(surfaceObject);
        cuArrayDestroy(array);
        if (line)
            cuArrayDestroy(line);
        if (mipmapped)
            cuMipmappedArrayDestroy(mipmapped);
        if (pool)
            cuMemPoolDestroy(pool);
        cuMemFree(memory);
        cuMemFree(managed);
        cuMemFree(ordered);
        cuMemFreeHost(pinned);
        cuMemHostUnregister(registered);
        cuMemHostUnregister(unregistered);
        std::free(registered);
        std::free(unregistered);
    }
};

void World::makeMemory() {
    MUST(cuMemAlloc(&memory, kBytes));
    MUST(cuMemAllocManaged(&managed, kBytes, CU_MEM_ATTACH_GLOBAL));
    MUST(cuMemHostAlloc(&pinned, kBytes, CU_MEMHOSTALLOC_DEVICEMAP));
    registered = std::aligned_alloc(4096, 4096);
    MUST(cuMemHostRegister(registered, 4096, 0));
    unregistered = std::aligned_alloc(4096, 4096);
    MUST(cuMemAllocAsync(&ordered, kBytes, stream));
    CUmemPoolProps props = {};
    props.allocType = CU_MEM_ALLOCATION_TYPE_PINNED;
    props.location.type = CU_MEM_LOCATION_TYPE_DEVICE;
    MUST(cuMemPoolCreate(&pool, &props));
    CUDA_ARRAY3D_DESCRIPTOR shape = {};
    shape.Width = shape.Height = 32;
    shape.Format = CU_AD_FORMAT_UNSIGNED_INT8;
    shape.NumChannels = 4;
    shape.Flags = CUDA_ARRAY3D_SURFACE_LDST;
    MUST(cuArray3DCreate(&array, &shape));
    MUST(cuMipmappedArrayCreate(&mipmapped, &shape, 3));
    const CUDA_ARRAY_DESCRIPTOR row = {256, 0, CU_AD_FORMAT_UNSIGNED_INT8, 1};
    MUST(cuArrayCreate(&line, &row));
    resource.resType = CU_RESOURCE_TYPE_ARRAY;
    resource.res.array.hArray = array;
    MUST(cuTexObjectCreate(&texture, &resource, &sampling, nullptr));
    MUST(cuSurfObjectCreate(&surfaceObject, &resource));
}

void World::makeCode() {
    MUST(cuModuleLoadData(&module, kPtx));
    MUST(cuModuleGetFunction(&function, module, "kernel"));
    MUST(cuModuleGetTexRef(&reference, module, "reference"));
    MUST(cuModuleGetSurfRef(&surface, module, "surface"));
    MUST(cuLibraryLoadData(&library, kPtx, nullptr, nullptr, 0, nullptr, nullptr, 0));
    MUST(cuLibraryGetKernel(&kernel, library, "kernel"));
    config.gridDimX = config.gridDimY = config.gridDimZ = 1;
    config.blockDimX = config.blockDimY = config.blockDimZ = 1;
    config.hStream = stream;
}

void World::makeGraph() {
    MUST(cuGraphCreate(&graph, 0));
    MUST(cuGraphAddEmptyNode(&empty, graph, nullptr, 0));
    launchParams.func = function;
    launchParams.gridDimX = launchParams.gridDimY = launchParams.gridDimZ = 1;
    launchParams.blockDimX = launchParams.blockDimY = launchParams.blockDimZ = 1;
    launchParams.kernelParams = arguments;
    MUST(cuGraphAddKernelNode(&launch, graph, nullptr, 0, &launchParams));
    setParams.dst = memory;
    setParams.elementSize = 4;
    setParams.width = 16;
    setParams.height = 1;
    MUST(cuGraphAddMemsetNode(&set, graph, nullptr, 0, &setParams, own));
    MUST(cuGraphAddHostNode(&host, graph, nullptr, 0, &hostParams));
    MUST(cuGraphAddEventRecordNode(&record, graph, nullptr, 0, later));
    MUST(cuGraphAddEventWaitNode(&wait, graph, nullptr, 0, event));
    CUgraph inner = nullptr;
    MUST(cuGraphCreate(&inner, 0));
    MUST(cuGraphAddChildGraphNode(&child, graph, nullptr, 0, inner));
    MUST(cuGraphInstantiateWithFlags(&exec, graph, 0));
    MUST(cuGraphClone(&copy, graph));
    MUST(cuUserObjectCreate(&object, nullptr, hostFunction, 1, CU_USER_OBJECT_NO_DESTRUCTOR_SYNC));
}

using Call = std::function<CUresult(World&)>;

std::string resultWhile(CUcontext current, const Call& call) {
    World world;
    MUST(cuCtxSetCurrent(current));
    return nameOf(call(world));
}

void print(const char* name, const Call& call) {
    const std::string mine = resultWhile(own, call);
    const std::string none = resultWhile(nullptr, call);
    std::printf("%s: own %s, none %s\n", name, mine.c_str(), none.c_str());
    std::fflush(stdout);
}

#define TRY(call) print(#call, [](World& w) { return call; })

void tryStreams() {
    TRY(cuStreamQuery(w.stream));
    TRY(cuStreamQuery(nullptr));
    TRY(cuStreamQuery(CU_STREAM_PER_THREAD));
    TRY(cuStreamSynchronize(w.stream));
    TRY(cuStreamSynchronize(nullptr));
    TRY(cuStreamSynchronize(CU_STREAM_PER_THREAD));
    TRY(cuStreamWaitEvent(w.stream, w.event, 0));
    TRY(cuStreamWaitEvent(nullptr, w.event, 0));
    TRY(cuStreamAddCallback(w.stream, callback, nullptr, 0));
    TRY(cuStreamAddCallback(nullptr, callback, nullptr, 0));
    TRY(cuLaunchHostFunc(w.stream, hostFunction, nullptr));
    TRY(cuLaunchHostFunc(nullptr, hostFunction, nullptr));
    TRY(cuStreamGetPriority(w.stream, &w.number));
    TRY(cuStreamGetPriority(nullptr, &w.number));
    TRY(cuStreamGetFlags(w.stream, &w.value));
    TRY(cuStreamGetFlags(nullptr, &w.value));
    TRY(cuStreamGetId(w.stream, &w.id));
    TRY(cuStreamGetId(nullptr, &w.id));
    TRY(cuStreamGetCtx(w.stream, (CUcontext*)&w.pointer));
    TRY(cuStreamGetCtx(nullptr, (CUcontext*)&w.pointer));
    TRY(cuStreamAttachMemAsync(w.stream, w.managed, 0, CU_MEM_ATTACH_GLOBAL));
    TRY(cuStreamAttachMemAsync(nullptr, w.managed, 0, CU_MEM_ATTACH_GLOBAL));
    TRY(cuStreamIsCapturing(w.stream, (CUstreamCaptureStatus*)&w.number));
    TRY(cuStreamIsCapturing(nullptr, (CUstreamCaptureStatus*)&w.number));
    TRY(cuStreamBeginCapture(w.stream, CU_STREAM_CAPTURE_MODE_RELAXED));
    print("cuStreamEndCapture", [](World& w) {
        CUcontext current = nullptr;
        MUST(cuCtxGetCurrent(&current));
        MUST(cuCtxSetCurrent(own));
        MUST(cuStreamBeginCapture(w.stream, CU_STREAM_CAPTURE_MODE_RELAXED));
        MUST(cuCtxSetCurrent(current));
        return cuStreamEndCapture(w.stream, (CUgraph*)&w.pointer);
    });
    TRY(cuStreamCopyAttributes(w.stream, w.second));
    TRY(cuStreamCopyAttributes(w.stream, nullptr));
    TRY(cuStreamCreate((CUstream*)&w.pointer, 0));
    TRY(cuStreamDestroy(std::exchange(w.second, nullptr)));
    TRY(cuStreamWriteValue32(w.stream, w.memory, 1, 0));
    TRY(cuStreamWaitValue32(w.stream, w.memory, 0, CU_STREAM_WAIT_VALUE_GEQ));
    TRY(cuStreamWriteValue32(nullptr, w.memory, 1, 0));
    TRY(cuThreadExchangeStreamCaptureMode((CUstreamCaptureMode*)&w.number));
}

void tryEvents() {
    TRY(cuEventCreate((CUevent*)&w.pointer, 0));
    TRY(cuEventRecord(w.event, w.stream));
    TRY(cuEventRecord(w.event, nullptr));
    TRY(cuEventRecord(w.event, CU_STREAM_PER_THREAD));
    TRY(cuEventRecordWithFlags(w.event, w.stream, 0));
    TRY(cuEventQuery(w.event));
    TRY(cuEventSynchronize(w.event));
    TRY(cuEventElapsedTime(&w.milliseconds, w.event, w.later));
    TRY(cuEventDestroy(std::exchange(w.event, nullptr)));
}

void tryMemory() {
    TRY(cuMemAlloc(&w.address, 64));
    TRY(cuMemAllocPitch(&w.address, &w.size, 64, 4, 4));
    TRY(cuMemAllocManaged(&w.address, 64, CU_MEM_ATTACH_GLOBAL));
    TRY(cuMemAllocHost(&w.pointer, 64));
    TRY(cuMemHostAlloc(&w.pointer, 64, 0));
    TRY(cuMemFree(w.memory));
    TRY(cuMemFree(w.managed));
    TRY(cuMemFree(0));
    TRY(cuMemFreeHost(w.pinned));
    TRY(cuMemHostRegister(w.unregistered, 4096, 0));
    TRY(cuMemHostUnregister(w.registered));
    TRY(cuMemHostGetDevicePointer(&w.address, w.pinned, 0));
    TRY(cuMemHostGetFlags(&w.value, w.pinned));
    TRY(cuMemGetInfo(&w.size, &w.size));
    TRY(cuMemGetAddressRange(&w.address, &w.size, w.memory));
    TRY(cuPointerGetAttribute(&w.number, CU_POINTER_ATTRIBUTE_MEMORY_TYPE, w.memory));
    TRY(cuPointerSetAttribute(&(w.number = 1), CU_POINTER_ATTRIBUTE_SYNC_MEMOPS, w.memory));
    TRY(cuMemRangeGetAttribute(&w.number, 4, CU_MEM_RANGE_ATTRIBUTE_READ_MOSTLY, w.managed, 64));
    TRY(cuMemAllocAsync(&w.address, 64, w.stream));
    TRY(cuMemAllocAsync(&w.address, 64, nullptr));
    TRY(cuMemAllocAsync(&w.address, 64, CU_STREAM_PER_THREAD));
    TRY(cuMemAllocFromPoolAsync(&w.address, 64, w.pool, w.stream));
    TRY(cuMemAllocFromPoolAsync(&w.address, 64, w.pool, nullptr));
    TRY(cuMemFreeAsync(w.ordered, w.stream));
    TRY(cuMemFreeAsync(w.ordered, nullptr));
    TRY(cuMemFree(w.ordered));
    TRY(cuMemPoolTrimTo(w.pool, 0));
    TRY(cuMemPoolGetAttribute(w.pool, CU_MEMPOOL_ATTR_RELEASE_THRESHOLD, &w.id));
    TRY(cuMemPoolSetAttribute(w.pool, CU_MEMPOOL_ATTR_RELEASE_THRESHOLD, &w.id));
    TRY(cuMemPoolDestroy(std::exchange(w.pool, nullptr)));
}

void tryCopies() {
    TRY(cuMemcpy(w.memory, w.memory + 64, 64));
    TRY(cuMemcpyAsync(w.memory, w.memory + 64, 64, w.stream));
    TRY(cuMemcpyAsync(w.memory, w.memory + 64, 64, nullptr));
    TRY(cuMemcpyHtoD(w.memory, w.bytes, 64));
    TRY(cuMemcpyDtoH(w.bytes, w.memory, 64));
    TRY(cuMemcpyDtoD(w.memory, w.memory + 64, 64));
    TRY(cuMemcpyHtoDAsync(w.memory, w.bytes, 64, w.stream));
    TRY(cuMemcpyHtoDAsync(w.memory, w.bytes, 64, nullptr));
    TRY(cuMemcpyDtoHAsync(w.bytes, w.memory, 64, w.stream));
    TRY(cuMemcpyDtoHAsync(w.bytes, w.memory, 64, nullptr));
    TRY(cuMemcpyDtoHAsync(w.bytes, w.memory, 64, CU_STREAM_PER_THREAD));
    TRY(cuMemcpyDtoDAsync(w.memory, w.memory + 64, 64, w.stream));
    TRY(cuMemcpyDtoA(w.line, 0, w.memory, 64));
    TRY(cuMemcpyAtoD(w.memory, w.line, 0, 64));
    TRY(cuMemcpyHtoA(w.line, 0, w.bytes, 64));
    TRY(cuMemcpyAtoH(w.bytes, w.line, 0, 64));
    TRY(cuMemcpyHtoAAsync(w.line, 0, w.bytes, 64, w.stream));
    TRY(cuMemcpyAtoHAsync(w.bytes, w.line, 0, 64, w.stream));
    TRY(cuMemcpyAtoA(w.line, 0, w.line, 128, 64));
    TRY(cuMemsetD8(w.memory, 1, 64));
    TRY(cuMemsetD16(w.memory, 1, 64));
    TRY(cuMemsetD32(w.memory, 1, 64));
    TRY(cuMemsetD2D8(w.memory, 64, 1, 4, 4));
    TRY(cuMemsetD8Async(w.memory, 1, 64, w.stream));
    TRY(cuMemsetD8Async(w.memory, 1, 64, nullptr));
    TRY(cuMemsetD32Async(w.memory, 1, 64, w.stream));
    TRY(cuMemsetD2D32Async(w.memory, 64, 1, 4, 4, w.stream));
    TRY(cuMemPrefetchAsync(w.managed, 64, (CUmemLocation{CU_MEM_LOCATION_TYPE_DEVICE, 0}), 0,
                           w.stream));
    TRY(cuMemAdvise(w.managed, 64, CU_MEM_ADVISE_SET_READ_MOSTLY,
                    (CUmemLocation{CU_MEM_LOCATION_TYPE_DEVICE, 0})));
}

CUDA_MEMCPY3D flatCopy(World& w) {
    CUDA_MEMCPY3D copy = {};
    copy.srcMemoryType = CU_MEMORYTYPE_DEVICE;
    copy.srcDevice = w.memory;
    copy.dstMemoryType = CU_MEMORYTYPE_ARRAY;
    copy.dstArray = w.array;
    copy.WidthInBytes = 64;
    copy.Height = copy.Depth = 1;
    return copy;
}
CUDA_MEMCPY2D planeCopy(World& w) {
    CUDA_MEMCPY2D copy = {};
    copy.srcMemoryType = CU_MEMORYTYPE_DEVICE;
    copy.srcDevice = w.memory;
    copy.dstMemoryType = CU_MEMORYTYPE_DEVICE;
    copy.dstDevice = w.memory + 1024;
    copy.WidthInBytes = 64;
    copy.Height = 1;
    return copy;
}

void tryArrays() {
    print("cuMemcpy2D", [](World& w) {
        const CUDA_MEMCPY2D copy = planeCopy(w);
        return cuMemcpy2D(&copy);
    });
    print("cuMemcpy2DAsync", [](World& w) {
        const CUDA_MEMCPY2D copy = planeCopy(w);
        return cuMemcpy2DAsync(&copy, w.stream);
    });
    print("cuMemcpy3D", [](World& w) {
        const CUDA_MEMCPY3D copy = flatCopy(w);
        return cuMemcpy3D(&copy);
    });
    print("cuMemcpy3DAsync", [](World& w) {
        const CUDA_MEMCPY3D copy = flatCopy(w);
        return cuMemcpy3DAsync(&copy, w.stream);
    });
    print("cuArrayCreate", [](World& w) {
        const CUDA_ARRAY_DESCRIPTOR shape = {16, 16, CU_AD_FORMAT_FLOAT, 1};
        return cuArrayCreate((CUarray*)&w.pointer, &shape);
    });
    print("cuArray3DGetDescriptor", [](World& w) {
        CUDA_ARRAY3D_DESCRIPTOR shape;
        return cuArray3DGetDescriptor(&shape, w.array);
    });
    print("cuArrayGetDescriptor", [](World& w) {
        CUDA_ARRAY_DESCRIPTOR shape;
        return cuArrayGetDescriptor(&shape, w.array);
    });
    TRY(cuMipmappedArrayGetLevel((CUarray*)&w.pointer, w.mipmapped, 1));
    TRY(cuMipmappedArrayDestroy(std::exchange(w.mipmapped, nullptr)));
    TRY(cuArrayDestroy(std::exchange(w.line, nullptr)));
    TRY(cuTexObjectCreate((CUtexObject*)&w.id, &w.resource, &w.sampling, nullptr));
    TRY(cuTexObjectGetResourceDesc(&w.resource, w.texture));
    TRY(cuTexObjectGetTextureDesc(&w.sampling, w.texture));
    TRY(cuTexObjectDestroy(std::exchange(w.texture, 0)));
    TRY(cuSurfObjectCreate((CUsurfObject*)&w.id, &w.resource));
    TRY(cuSurfObjectGetResourceDesc(&w.resource, w.surfaceObject));
    TRY(cuSurfObjectDestroy(std::exchange(w.surfaceObject, 0)));
    TRY(cuTexRefSetArray(w.reference, w.array, CU_TRSA_OVERRIDE_FORMAT));
    TRY(cuTexRefSetFilterMode(w.reference, CU_TR_FILTER_MODE_LINEAR));
    TRY(cuTexRefSetFlags(w.reference, 0));
    TRY(cuTexRefGetFlags(&w.value, w.reference));
    TRY(cuTexRefSetAddress(&w.size, w.reference, w.memory, 64));
    TRY(cuSurfRefSetArray(w.surface, w.array, 0));
}

void tryCode() {
    TRY(cuModuleLoadData((CUmodule*)&w.pointer, kPtx));
    TRY(cuModuleGetFunction((CUfunction*)&w.pointer, w.module, "kernel"));
    TRY(cuModuleGetGlobal(&w.address, &w.size, w.module, "counter"));
    TRY(cuModuleGetTexRef((CUtexref*)&w.pointer, w.module, "reference"));
    TRY(cuModuleGetFunctionCount(&w.value, w.module));
    TRY(cuModuleEnumerateFunctions((CUfunction*)&w.pointer, 1, w.module));
    TRY(cuModuleGetLoadingMode((CUmoduleLoadingMode*)&w.number));
    TRY(cuModuleUnload(std::exchange(w.module, nullptr)));
    TRY(cuFuncGetAttribute(&w.number, CU_FUNC_ATTRIBUTE_MAX_THREADS_PER_BLOCK, w.function));
    TRY(cuFuncSetAttribute(w.function, CU_FUNC_ATTRIBUTE_MAX_DYNAMIC_SHARED_SIZE_BYTES, 64));
    TRY(cuFuncSetCacheConfig(w.function, CU_FUNC_CACHE_PREFER_L1));
    TRY(cuFuncGetModule((CUmodule*)&w.pointer, w.function));
    TRY(cuFuncGetName((const char**)&w.pointer, w.function));
    TRY(cuFuncGetParamInfo(w.function, 0, &w.size, &w.size));
    TRY(cuFuncIsLoaded((CUfunctionLoadingState*)&w.number, w.function));
    TRY(cuFuncLoad(w.function));
    TRY(cuLaunchKernel(w.function, 1, 1, 1, 1, 1, 1, 0, w.stream, w.arguments, nullptr));
    TRY(cuLaunchKernel(w.function, 1, 1, 1, 1, 1, 1, 0, nullptr, w.arguments, nullptr));
    TRY(cuLaunchKernel((CUfunction)w.kernel, 1, 1, 1, 1, 1, 1, 0, w.stream, w.arguments, nullptr));
    TRY(cuLaunchKernel((CUfunction)w.kernel, 1, 1, 1, 1, 1, 1, 0, nullptr, w.arguments, nullptr));
    TRY(cuLaunchKernelEx(&w.config, w.function, w.arguments, nullptr));
    TRY(cuLaunchCooperativeKernel(w.function, 1, 1, 1, 1, 1, 1, 0, w.stream, w.arguments));
    TRY(cuOccupancyMaxActiveBlocksPerMultiprocessor(&w.number, w.function, 32, 0));
    TRY(cuOccupancyAvailableDynamicSMemPerBlock(&w.size, w.function, 1, 32));
    TRY(cuLibraryLoadData((CUlibrary*)&w.pointer, kPtx, nullptr, nullptr, 0, nullptr, nullptr, 0));
    TRY(cuLibraryGetKernel((CUkernel*)&w.pointer, w.library, "kernel"));
    TRY(cuLibraryGetGlobal(&w.address, &w.size, w.library, "counter"));
    TRY(cuLibraryGetModule((CUmodule*)&w.pointer, w.library));
    TRY(cuLibraryGetKernelCount(&w.value, w.library));
    TRY(cuLibraryUnload(std::exchange(w.library, nullptr)));
    TRY(cuKernelGetFunction((CUfunction*)&w.pointer, w.kernel));
    TRY(cuKernelGetAttribute(&w.number, CU_FUNC_ATTRIBUTE_MAX_THREADS_PER_BLOCK, w.kernel, 0));
    TRY(cuKernelSetCacheConfig(w.kernel, CU_FUNC_CACHE_PREFER_L1, 0));
    TRY(cuKernelGetName((const char**)&w.pointer, w.kernel));
    TRY(cuLinkCreate(0, nullptr, nullptr, (CUlinkState*)&w.pointer));
}

// Without parameters of kernels: drivers crash for them if no context is current.
void tryGraphs() {
    TRY(cuGraphCreate((CUgraph*)&w.pointer, 0));
    TRY(cuGraphClone((CUgraph*)&w.pointer, w.graph));
    TRY(cuGraphAddEmptyNode(&w.newNode, w.graph, nullptr, 0));
    TRY(cuGraphAddMemsetNode(&w.newNode, w.graph, nullptr, 0, &w.setParams, own));
    TRY(cuGraphAddHostNode(&w.newNode, w.graph, nullptr, 0, &w.hostParams));
    TRY(cuGraphAddEventRecordNode(&w.newNode, w.graph, nullptr, 0, w.event));
    TRY(cuGraphAddEventWaitNode(&w.newNode, w.graph, nullptr, 0, w.event));
    TRY(cuGraphAddChildGraphNode(&w.newNode, w.graph, nullptr, 0, w.copy));
    TRY(cuGraphKernelNodeGetParams(w.launch, &w.launchParams));
    TRY(cuGraphMemsetNodeGetParams(w.set, &w.setParams));
    TRY(cuGraphMemsetNodeSetParams(w.set, &w.setParams));
    TRY(cuGraphHostNodeGetParams(w.host, &w.hostParams));
    TRY(cuGraphHostNodeSetParams(w.host, &w.hostParams));
    TRY(cuGraphEventRecordNodeGetEvent(w.record, (CUevent*)&w.pointer));
    TRY(cuGraphChildGraphNodeGetGraph(w.child, (CUgraph*)&w.pointer));
    TRY(cuGraphGetNodes(w.graph, nullptr, &w.size));
    TRY(cuGraphGetRootNodes(w.graph, nullptr, &w.size));
    TRY(cuGraphNodeGetType(w.launch, (CUgraphNodeType*)&w.number));
    TRY(cuGraphDestroyNode(w.host));
    TRY(cuGraphInstantiateWithFlags((CUgraphExec*)&w.pointer, w.graph, 0));
    TRY(cuGraphExecMemsetNodeSetParams(w.exec, w.set, &w.setParams, own));
    TRY(cuGraphExecHostNodeSetParams(w.exec, w.host, &w.hostParams));
    TRY(cuGraphNodeSetEnabled(w.exec, w.launch, 0));
    TRY(cuGraphNodeGetEnabled(w.exec, w.launch, &w.value));
    TRY(cuGraphExecGetFlags(w.exec, (cuuint64_t*)&w.id));
    print("cuGraphExecUpdate", [](World& w) {
        CUgraphExecUpdateResultInfo info = {};
        return cuGraphExecUpdate(w.exec, w.graph, &info);
    });
    TRY(cuGraphUpload(w.exec, w.stream));
    TRY(cuGraphUpload(w.exec, nullptr));
    TRY(cuGraphLaunch(w.exec, w.stream));
    TRY(cuGraphLaunch(w.exec, nullptr));
    TRY(cuGraphLaunch(w.exec, CU_STREAM_PER_THREAD));
    TRY(cuGraphExecDestroy(std::exchange(w.exec, nullptr)));
    TRY(cuGraphDestroy(std::exchange(w.graph, nullptr)));
    TRY(cuUserObjectCreate((CUuserObject*)&w.pointer, nullptr, hostFunction, 1,
                           CU_USER_OBJECT_NO_DESTRUCTOR_SYNC));
    TRY(cuUserObjectRetain(w.object, 1));
    TRY(cuGraphRetainUserObject(w.graph, w.object, 1, 0));
    TRY(cuUserObjectRelease(w.object, 1));
}

void tryContexts() {
    TRY(cuCtxGetDevice(&w.number));
    TRY(cuCtxGetFlags(&w.value));
    TRY(cuCtxGetId(nullptr, &w.id));
    TRY(cuCtxGetId(own, &w.id));
    TRY(cuCtxGetApiVersion(nullptr, &w.value));
    TRY(cuCtxGetApiVersion(own, &w.value));
    TRY(cuCtxGetLimit(&w.size, CU_LIMIT_STACK_SIZE));
    TRY(cuCtxSetLimit(CU_LIMIT_STACK_SIZE, 1024));
    TRY(cuCtxGetCacheConfig((CUfunc_cache*)&w.number));
    TRY(cuCtxGetStreamPriorityRange(&w.number, &w.number));
    TRY(cuDeviceGetAttribute(&w.number, CU_DEVICE_ATTRIBUTE_WARP_SIZE, device));
    TRY(cuDeviceGetDefaultMemPool((CUmemoryPool*)&w.pointer, device));
    TRY(cuDeviceGetMemPool((CUmemoryPool*)&w.pointer, device));
    print("cuCtxSynchronize", [](World&) { return cuCtxSynchronize(); });
}

} // namespace

int main() {
    MUST(cuInit(0));
    MUST(cuDeviceGet(&device, 0));
    MUST(cuDevicePrimaryCtxRetain(&own, device));
    tryContexts();
    tryStreams();
    tryEvents();
    tryMemory();
    tryCopies();
    tryArrays();
    tryCode();
    tryGraphs();
    return 0;
}
