// SPDX-License-Identifier: Apache-2.0
// The runtime API over the driver API, which it opens at run time: the same objects make the shared
// library and the static archive, and they work with any libcuda. Uses nothing of the engine.
//
// Sources *_streams.cpp are compiled twice: with __CUDA_API_PER_THREAD_DEFAULT_STREAM the header
// gives their functions the _ptsz and _ptds names, and null streams mean the calling thread's.
#pragma once

#include <cuda.h>
#include <cuda_runtime_api.h>

#define SUNSTONE_CUDART extern "C" __attribute__((visibility("default")))

// These sources make two libraries: for programs of CUDA 13, whose headers are ours, and of CUDA
// 12. If a function's parameters differ, the library for 12 has the newer form under another name,
// and also the older form (runtime12/).
#ifdef SUNSTONE_CUDART_12
#define SUNSTONE_SINCE_13(name, nameIn12) nameIn12
#ifdef __CUDA_API_PER_THREAD_DEFAULT_STREAM
#define cudaMemPrefetchAsync_v2 cudaMemPrefetchAsync_v2_ptsz
#define cudaStreamGetCaptureInfo_v2 cudaStreamGetCaptureInfo_v2_ptsz
#define cudaStreamGetCaptureInfo_v3 cudaStreamGetCaptureInfo_v3_ptsz
#define cudaStreamUpdateCaptureDependencies_v2 cudaStreamUpdateCaptureDependencies_v2_ptsz
#endif
#else
#define SUNSTONE_SINCE_13(name, nameIn12) name
#endif

namespace sunstone::cudart {

#define SUNSTONE_DRIVER_FUNCTIONS(X)                                                                          \
    X(cuInit)                                                                                                 \
    X(cuDriverGetVersion) X(cuDeviceGetCount) X(cuDeviceGetName) X(cuDeviceGetUuid) X(                        \
        cuDeviceTotalMem) X(cuDeviceGetAttribute) X(cuDeviceGetPCIBusId) X(cuDeviceGetByPCIBusId)             \
        X(cuDeviceCanAccessPeer) X(cuDevicePrimaryCtxRetain) X(cuDevicePrimaryCtxReset) X(                    \
            cuDevicePrimaryCtxSetFlags) X(cuDevicePrimaryCtxGetState) X(cuCtxSetCurrent)                      \
            X(cuCtxGetCurrent) X(cuCtxGetDevice) X(cuCtxSynchronize) X(cuCtxSetLimit) X(                      \
                cuCtxGetLimit) X(cuCtxGetCacheConfig) X(cuCtxSetCacheConfig)                                  \
                X(cuCtxGetStreamPriorityRange) X(cuModuleLoadData) X(cuModuleUnload) X(                       \
                    cuModuleGetFunction) X(cuModuleGetGlobal) X(cuMemGetInfo) X(cuMemAlloc)                   \
                    X(cuMemAllocPitch) X(cuMemFree) X(cuMemHostAlloc) X(cuMemFreeHost) X(                     \
                        cuMemHostGetDevicePointer) X(cuMemHostGetFlags) X(cuMemHostRegister)                  \
                        X(cuMemHostUnregister) X(cuMemAllocManaged) X(cuMemAllocAsync) X(                     \
                            cuMemFreeAsync) X(cuPointerGetAttributes) X(cuMemcpyAsync)                        \
                            X(cuMemcpyHtoDAsync) X(cuMemcpyDtoHAsync) X(cuMemcpyDtoDAsync) X(                 \
                                cuMemcpy2DAsync) X(cuMemcpy3DAsync) X(cuMemsetD8Async)                        \
                                X(cuMemsetD2D8Async) X(cuStreamCreateWithPriority) X(                         \
                                    cuStreamDestroy) X(cuStreamGetPriority) X(cuStreamGetFlags)               \
                                    X(cuStreamGetId) X(cuStreamWaitEvent) X(cuStreamAddCallback) X(           \
                                        cuStreamQuery) X(cuStreamSynchronize)                                 \
                                        X(cuStreamIsCapturing) X(cuStreamAttachMemAsync) X(                   \
                                            cuLaunchHostFunc) X(cuEventCreate)                                \
                                            X(cuEventRecordWithFlags) X(cuEventQuery) X(                      \
                                                cuEventSynchronize) X(cuEventDestroy)                         \
                                                X(cuEventElapsedTime) X(cuFuncGetAttribute) X(                \
                                                    cuFuncSetAttribute) X(cuFuncSetCacheConfig)               \
                                                    X(cuLaunchKernel) X(cuLaunchKernelEx) X(                  \
                                                        cuOccupancyMaxActiveBlocksPerMultiprocessorWithFlags) \
                                                        X(cuOccupancyAvailableDynamicSMemPerBlock)                                                     \
    X(cuArray3DCreate) X(cuArray3DGetDescriptor) X(cuArrayDestroy) X(cuMipmappedArrayCreate)       \
    X(cuMipmappedArrayGetLevel) X(cuMipmappedArrayDestroy) X(cuTexObjectCreate)                    \
    X(cuTexObjectDestroy) X(cuTexObjectGetResourceDesc) X(cuTexObjectGetTextureDesc)               \
    X(cuSurfObjectCreate) X(cuSurfObjectDestroy) X(cuSurfObjectGetResourceDesc)

// Functions that older drivers lack; null then.
#define SUNSTONE_OPTIONAL_DRIVER_FUNCTIONS(X) \
    X(cuTexObjectGetResourceViewDesc) \
    X(cuCtxGetSharedMemConfig) \
    X(cuCtxResetPersistingL2Cache) \
    X(cuCtxSetSharedMemConfig) \
    X(cuDeviceGetP2PAttribute) \
    X(cuDeviceGetTexture1DLinearMaxWidth) \
    X(cuFuncSetSharedMemConfig) \
    X(cuLibraryLoadData) \
    X(cuLibraryLoadFromFile) \
    X(cuLibraryUnload) \
    X(cuLibraryGetKernel) \
    X(cuLibraryGetKernelCount) \
    X(cuLibraryEnumerateKernels) \
    X(cuLibraryGetGlobal) \
    X(cuLibraryGetManaged) \
    X(cuLibraryGetUnifiedFunction) \
    X(cuKernelGetFunction) \
    X(cuKernelSetAttribute) \
    X(cuStreamGetAttribute) \
    X(cuStreamSetAttribute) \
    X(cuStreamCopyAttributes) \
    X(cuLinkCreate) \
    X(cuLinkAddData) \
    X(cuLinkComplete) \
    X(cuLinkDestroy) \
    X(cuLaunchCooperativeKernel) \
    X(cuMemPoolCreate) \
    X(cuMemPoolDestroy) \
    X(cuMemPoolTrimTo) \
    X(cuMemPoolSetAttribute) \
    X(cuMemPoolGetAttribute) \
    X(cuMemPoolSetAccess) \
    X(cuMemPoolGetAccess) \
    X(cuDeviceGetDefaultMemPool) \
    X(cuDeviceGetMemPool) \
    X(cuDeviceSetMemPool) \
    X(cuMemAllocFromPoolAsync) \
    X(cuMemAdvise) \
    X(cuStreamGetDevice) \
    X(cuFuncGetName) \
    X(cuFuncGetParamInfo) \
    X(cuGetProcAddress) \
    X(cuMemPrefetchAsync) \
    X(cuMemRangeGetAttribute) \
    X(cuMemRangeGetAttributes) \
    X(cuGraphAddChildGraphNode) \
    X(cuGraphAddDependencies) \
    X(cuGraphAddEmptyNode) \
    X(cuGraphAddEventRecordNode) \
    X(cuGraphAddEventWaitNode) \
    X(cuGraphAddHostNode) \
    X(cuGraphAddKernelNode) \
    X(cuGraphAddMemcpyNode) \
    X(cuGraphAddMemsetNode) \
    X(cuGraphChildGraphNodeGetGraph) \
    X(cuGraphClone) \
    X(cuGraphCreate) \
    X(cuGraphDestroy) \
    X(cuGraphDestroyNode) \
    X(cuGraphEventRecordNodeGetEvent) \
    X(cuGraphEventWaitNodeGetEvent) \
    X(cuGraphExecDestroy) \
    X(cuGraphExecGetFlags) \
    X(cuGraphExecHostNodeSetParams) \
    X(cuGraphExecKernelNodeSetParams) \
    X(cuGraphExecMemcpyNodeSetParams) \
    X(cuGraphExecMemsetNodeSetParams) \
    X(cuGraphExecUpdate) \
    X(cuGraphGetEdges) \
    X(cuGraphGetNodes) \
    X(cuGraphGetRootNodes) \
    X(cuGraphHostNodeGetParams) \
    X(cuGraphHostNodeSetParams) \
    X(cuGraphInstantiateWithFlags) \
    X(cuGraphInstantiateWithParams) \
    X(cuGraphKernelNodeCopyAttributes) \
    X(cuGraphKernelNodeGetAttribute) \
    X(cuGraphKernelNodeGetParams) \
    X(cuGraphKernelNodeSetAttribute) \
    X(cuGraphKernelNodeSetParams) \
    X(cuGraphLaunch) \
    X(cuGraphMemcpyNodeSetParams) \
    X(cuGraphMemsetNodeGetParams) \
    X(cuGraphMemsetNodeSetParams) \
    X(cuGraphNodeFindInClone) \
    X(cuGraphNodeGetDependencies) \
    X(cuGraphNodeGetDependentNodes) \
    X(cuGraphNodeGetEnabled) \
    X(cuGraphNodeGetType) \
    X(cuGraphNodeSetEnabled) \
    X(cuGraphRemoveDependencies) \
    X(cuGraphUpload) \
    X(cuStreamBeginCapture) \
    X(cuStreamBeginCaptureToGraph) \
    X(cuStreamEndCapture) \
    X(cuStreamGetCaptureInfo) \
    X(cuStreamUpdateCaptureDependencies) \
    X(cuThreadExchangeStreamCaptureMode) \
    X(cuUserObjectCreate) \
    X(cuUserObjectRetain) \
    X(cuUserObjectRelease) \
    X(cuGraphRetainUserObject) \
    X(cuGraphReleaseUserObject)

// The driver's functions. If `status` is success, all except the optional ones are present.
struct Driver {
    cudaError_t status = cudaErrorInsufficientDriver;
    bool isCpuDevice = false;
#define SUNSTONE_MEMBER(name) decltype(&::name) name = nullptr;
    SUNSTONE_DRIVER_FUNCTIONS(SUNSTONE_MEMBER)
    SUNSTONE_OPTIONAL_DRIVER_FUNCTIONS(SUNSTONE_MEMBER)
#undef SUNSTONE_MEMBER
};
const Driver& driver();
// Whether this process is the child, by fork, of one in which the driver was initialised. The driver
// refuses all its calls, and another thread of the parent may have held our locks.
bool isForkedChild();

// The device of threads that have chosen none.
void setFirstDevice(int device);
// Makes the first device's primary context current on this thread if none is.
cudaError_t ensureContext();

cudaError_t fromDriver(CUresult result);
// Calls a driver function that older drivers may lack.
template <class Function, class... Args>
cudaError_t present(Function function, Args... args) {
    return function ? fromDriver(function(args...)) : cudaErrorCallRequiresNewerDriver;
}
// Stores an error for cudaGetLastError and returns it.
cudaError_t remember(cudaError_t error);
// Called after the device has been reset.
void forgetLastError();

// The usual steps of an entry point: context, driver call, error.
template <class Body>
cudaError_t call(Body&& body) {
    cudaError_t error = ensureContext();
    if (error == cudaSuccess) {
        if constexpr (__is_same(decltype(body(driver())), CUresult))
            error = fromDriver(body(driver()));
        else
            error = body(driver());
    }
    return remember(error);
}

inline CUstream streamOf(cudaStream_t stream) {
#ifdef __CUDA_API_PER_THREAD_DEFAULT_STREAM
    if (!stream)
        stream = cudaStreamPerThread;
#endif
    return stream;
}
inline CUdeviceptr addressOf(const void* pointer) {
    return reinterpret_cast<CUdeviceptr>(pointer);
}

// ---- registrations by compilers: registration.cpp ----
// The driver's function for a kernel's host stub, a handle of __cudaGetKernel or a kernel of a library.
cudaError_t findFunction(const void* symbol, CUfunction* function);
// Records a kernel of a library, which we returned to the program, until the library is unloaded.
void keepLibraryKernel(cudaKernel_t kernel, cudaLibrary_t library);
void forgetLibrary(cudaLibrary_t library);
bool isLibraryKernel(const void* symbol, CUkernel* kernel);
// The host stub of a function found before; null for other functions.
const void* symbolOf(CUfunction function);
cudaError_t findVariable(const void* symbol, CUdeviceptr* address, size_t* size);
// The address of [offset, offset + bytes) in a variable.
cudaError_t findInVariable(const void* symbol, size_t bytes, size_t offset, void** address);
// Forgets loaded modules, after their context was destroyed.
void forgetModules();

} // namespace sunstone::cudart
