// SPDX-License-Identifier: Apache-2.0
// The CUDA 12 forms of functions whose parameters or structs changed in CUDA 13. They call the
// newer form, which this library has under another name.
#include "api/cuda/runtime/runtime.h"
#include "api/cuda/runtime12/device_properties.h"

#include <cstring>

using namespace sunstone::cudart;

extern "C" {
cudaError_t sunstoneGetDeviceProperties(cudaDeviceProp* properties, int device);
cudaError_t sunstonePointerGetAttributes(cudaPointerAttributes* attributes, const void* address);
cudaError_t cudaMemAdvise_v2(const void* address, size_t bytes, cudaMemoryAdvise advice,
                             cudaMemLocation location);
cudaError_t cudaGraphGetEdges_v2(cudaGraph_t graph, cudaGraphNode_t* from, cudaGraphNode_t* to,
                                 cudaGraphEdgeData* edges, size_t* count);
cudaError_t cudaGraphNodeGetDependencies_v2(cudaGraphNode_t node, cudaGraphNode_t* dependencies,
                                            cudaGraphEdgeData* edges, size_t* count);
cudaError_t cudaGraphNodeGetDependentNodes_v2(cudaGraphNode_t node, cudaGraphNode_t* dependents,
                                              cudaGraphEdgeData* edges, size_t* count);
cudaError_t cudaGraphAddNode_v2(cudaGraphNode_t* node, cudaGraph_t graph,
                                const cudaGraphNode_t* dependencies, const cudaGraphEdgeData* edges,
                                size_t count, cudaGraphNodeParams* params);
cudaError_t cudaGraphAddDependencies_v2(cudaGraph_t graph, const cudaGraphNode_t* from,
                                        const cudaGraphNode_t* to, const cudaGraphEdgeData* edges,
                                        size_t count);
cudaError_t cudaGraphRemoveDependencies_v2(cudaGraph_t graph, const cudaGraphNode_t* from,
                                           const cudaGraphNode_t* to,
                                           const cudaGraphEdgeData* edges, size_t count);
}

namespace {

// Reads the members that CUDA 13 removed, as attributes.
cudaError_t readRemoved(DeviceProperties12& to, int device) {
    const struct {
        cudaDeviceAttr attribute;
        int* value;
    } removed[] = {
        {cudaDevAttrClockRate, &to.clockRate},
        {cudaDevAttrGpuOverlap, &to.deviceOverlap},
        {cudaDevAttrKernelExecTimeout, &to.kernelExecTimeoutEnabled},
        {cudaDevAttrComputeMode, &to.computeMode},
        {cudaDevAttrMemoryClockRate, &to.memoryClockRate},
        {cudaDevAttrSingleToDoublePrecisionPerfRatio, &to.singleToDoublePrecisionPerfRatio},
        {cudaDevAttrMaxTexture1DLinearWidth, &to.maxTexture1DLinear},
    };
    for (const auto& [attribute, value] : removed)
        if (const cudaError_t error = cudaDeviceGetAttribute(value, attribute, device))
            return error;
    return cudaSuccess;
}

cudaError_t properties12(DeviceProperties12& to, int device) {
    cudaDeviceProp from;
    if (const cudaError_t error = sunstoneGetDeviceProperties(&from, device))
        return error;
    std::memset(&to, 0, sizeof to);
    // Both structs have the same members in the same order, except those of readRemoved: runs of
    // members are copied.
#define RUN(first, last)                                                                           \
    {                                                                                              \
        using A = DeviceProperties12;                                                              \
        using B = cudaDeviceProp;                                                                  \
        constexpr size_t toFirst = offsetof(A, first), fromFirst = offsetof(B, first);             \
        constexpr size_t bytes = offsetof(B, last) + sizeof(B::last) - fromFirst;                  \
        static_assert(offsetof(A, last) + sizeof(A::last) - toFirst == bytes,                      \
                      "a member of the run is in one struct only");                                \
        std::memcpy(reinterpret_cast<char*>(&to) + toFirst,                                        \
                    reinterpret_cast<const char*>(&from) + fromFirst, bytes);                      \
    }
    RUN(name, maxGridSize)
    RUN(totalConstMem, texturePitchAlignment)
    RUN(multiProcessorCount, multiProcessorCount)
    RUN(integrated, canMapHostMemory)
    RUN(maxTexture1D, maxTexture1DMipmap)
    RUN(maxTexture2D, unifiedAddressing)
    RUN(memoryBusWidth, localL1CacheSupported)
    RUN(sharedMemPerMultiprocessor, hostNativeAtomicSupported)
    RUN(pageableMemoryAccess, cooperativeLaunch)
    RUN(sharedMemPerBlockOptin, unifiedFunctionPointers)
#undef RUN
    return readRemoved(to, device);
}

} // namespace

SUNSTONE_CUDART cudaError_t cudaGetDeviceProperties_v2(DeviceProperties12* properties, int device) {
    if (!properties)
        return remember(cudaErrorInvalidValue);
    DeviceProperties12 result;
    if (const cudaError_t error = properties12(result, device))
        return error;
    *properties = result;
    return cudaSuccess;
}
// The name used by programs of CUDA 11, whose struct ends earlier.
#undef cudaGetDeviceProperties
SUNSTONE_CUDART cudaError_t sunstoneDeviceProperties11(void* properties,
                                                       int device) asm("cudaGetDeviceProperties");
SUNSTONE_CUDART cudaError_t sunstoneDeviceProperties11(void* properties, int device) {
    if (!properties)
        return remember(cudaErrorInvalidValue);
    DeviceProperties12 result;
    if (const cudaError_t error = properties12(result, device))
        return error;
    std::memcpy(properties, &result, kPropertyBytes11);
    return cudaSuccess;
}

// Our headers declare these functions with the parameters of CUDA 13: asm labels give the names to
// functions with other parameters.
#define SUNSTONE_OLDER(name, params)                                                               \
    SUNSTONE_CUDART cudaError_t older_##name params asm(#name);                                    \
    SUNSTONE_CUDART cudaError_t older_##name params

SUNSTONE_OLDER(cudaPointerGetAttributes, (void* attributes, const void* address)) {
    if (!attributes)
        return remember(cudaErrorInvalidValue);
    cudaPointerAttributes result = {};
    const cudaError_t error = sunstonePointerGetAttributes(&result, address);
    if (error == cudaSuccess)
        std::memcpy(attributes, &result, offsetof(cudaPointerAttributes, reserved));
    return error;
}
SUNSTONE_OLDER(cudaMemAdvise,
               (const void* address, size_t bytes, cudaMemoryAdvise advice, int device)) {
    return cudaMemAdvise_v2(
        address, bytes, advice,
        {device == cudaCpuDeviceId ? cudaMemLocationTypeHost : cudaMemLocationTypeDevice, device});
}
SUNSTONE_OLDER(cudaGraphGetEdges,
               (cudaGraph_t graph, cudaGraphNode_t* from, cudaGraphNode_t* to, size_t* count)) {
    return cudaGraphGetEdges_v2(graph, from, to, nullptr, count);
}
SUNSTONE_OLDER(cudaGraphNodeGetDependencies,
               (cudaGraphNode_t node, cudaGraphNode_t* dependencies, size_t* count)) {
    return cudaGraphNodeGetDependencies_v2(node, dependencies, nullptr, count);
}
SUNSTONE_OLDER(cudaGraphNodeGetDependentNodes,
               (cudaGraphNode_t node, cudaGraphNode_t* dependents, size_t* count)) {
    return cudaGraphNodeGetDependentNodes_v2(node, dependents, nullptr, count);
}
SUNSTONE_OLDER(cudaGraphAddDependencies, (cudaGraph_t graph, const cudaGraphNode_t* from,
                                          const cudaGraphNode_t* to, size_t count)) {
    return cudaGraphAddDependencies_v2(graph, from, to, nullptr, count);
}
SUNSTONE_OLDER(cudaGraphAddNode,
               (cudaGraphNode_t * node, cudaGraph_t graph, const cudaGraphNode_t* dependencies,
                size_t count, cudaGraphNodeParams* params)) {
    return cudaGraphAddNode_v2(node, graph, dependencies, nullptr, count, params);
}
SUNSTONE_OLDER(cudaGraphRemoveDependencies, (cudaGraph_t graph, const cudaGraphNode_t* from,
                                             const cudaGraphNode_t* to, size_t count)) {
    return cudaGraphRemoveDependencies_v2(graph, from, to, nullptr, count);
}
