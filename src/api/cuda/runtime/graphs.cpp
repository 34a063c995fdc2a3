// SPDX-License-Identifier: Apache-2.0
// Graphs: create, query, change. The driver does the work; only parameters that name kernels and
// copies are translated.
#include "api/cuda/runtime/graphs.h"

#include "api/cuda/runtime/arrays.h"

using namespace sunstone::cudart;

namespace {

// Translates the runtime's parameters to the driver's.
cudaError_t translate(const cudaKernelNodeParams* from, CUDA_KERNEL_NODE_PARAMS* to) {
    if (!from)
        return cudaErrorInvalidValue;
    *to = {};
    if (const cudaError_t error = findFunction(from->func, &to->func))
        return error;
    to->gridDimX = from->gridDim.x;
    to->gridDimY = from->gridDim.y;
    to->gridDimZ = from->gridDim.z;
    to->blockDimX = from->blockDim.x;
    to->blockDimY = from->blockDim.y;
    to->blockDimZ = from->blockDim.z;
    to->sharedMemBytes = from->sharedMemBytes;
    to->kernelParams = from->kernelParams;
    to->extra = from->extra;
    return cudaSuccess;
}
cudaError_t translate(const cudaMemcpy3DParms* from, CUDA_MEMCPY3D* to) {
    return from ? toDriver(*from, to) : cudaErrorInvalidValue;
}
cudaError_t translate(const cudaMemsetParams* from, CUDA_MEMSET_NODE_PARAMS* to) {
    if (!from)
        return cudaErrorInvalidValue;
    *to = {addressOf(from->dst), from->pitch, from->value,
           from->elementSize,    from->width, from->height};
    return cudaSuccess;
}

// Translates, then calls `body` with the current context, if the driver needs one.
template <class To, class From, class Body>
cudaError_t with(const From* params, Body&& body) {
    return call([&](const Driver& d) {
        To translated;
        if (const cudaError_t error = translate(params, &translated))
            return error;
        CUcontext context = nullptr;
        const CUresult result = d.cuCtxGetCurrent(&context);
        return result ? fromDriver(result) : body(d, &translated, context);
    });
}

cudaMemcpy3DParms linear(void* dst, const void* src, size_t bytes, cudaMemcpyKind kind) {
    cudaMemcpy3DParms parms = {};
    parms.srcPtr = {const_cast<void*>(src), bytes, bytes, 1};
    parms.dstPtr = {dst, bytes, bytes, 1};
    parms.extent = {bytes, 1, 1};
    parms.kind = kind;
    return parms;
}

} // namespace

SUNSTONE_CUDART cudaError_t cudaThreadExchangeStreamCaptureMode(enum cudaStreamCaptureMode* mode) {
    return graphCall([&](const Driver& d) { return d.cuThreadExchangeStreamCaptureMode; },
                     reinterpret_cast<CUstreamCaptureMode*>(mode));
}
SUNSTONE_CUDART cudaError_t cudaGraphCreate(cudaGraph_t* graph, unsigned int flags) {
    return graphCall([&](const Driver& d) { return d.cuGraphCreate; }, graph, flags);
}
SUNSTONE_CUDART cudaError_t cudaGraphDestroy(cudaGraph_t graph) {
    return graphCall([&](const Driver& d) { return d.cuGraphDestroy; }, graph);
}
SUNSTONE_CUDART cudaError_t cudaGraphClone(cudaGraph_t* clone, cudaGraph_t original) {
    return graphCall([&](const Driver& d) { return d.cuGraphClone; }, clone, original);
}
SUNSTONE_CUDART cudaError_t cudaUserObjectCreate(cudaUserObject_t* object, void* argument,
                                                 cudaHostFn_t destroy, unsigned int references,
                                                 unsigned int flags) {
    return graphCall([&](const Driver& d) { return d.cuUserObjectCreate; }, object, argument,
                     destroy, references, flags);
}
SUNSTONE_CUDART cudaError_t cudaUserObjectRetain(cudaUserObject_t object, unsigned int count) {
    return graphCall([&](const Driver& d) { return d.cuUserObjectRetain; }, object, count);
}
SUNSTONE_CUDART cudaError_t cudaUserObjectRelease(cudaUserObject_t object, unsigned int count) {
    return graphCall([&](const Driver& d) { return d.cuUserObjectRelease; }, object, count);
}
SUNSTONE_CUDART cudaError_t cudaGraphRetainUserObject(cudaGraph_t graph, cudaUserObject_t object,
                                                      unsigned int count, unsigned int flags) {
    return graphCall([&](const Driver& d) { return d.cuGraphRetainUserObject; }, graph, object,
                     count, flags);
}
SUNSTONE_CUDART cudaError_t cudaGraphReleaseUserObject(cudaGraph_t graph, cudaUserObject_t object,
                                                       unsigned int count) {
    return graphCall([&](const Driver& d) { return d.cuGraphReleaseUserObject; }, graph, object,
                     count);
}
SUNSTONE_CUDART cudaError_t cudaGraphNodeFindInClone(cudaGraphNode_t* node,
                                                     cudaGraphNode_t original, cudaGraph_t clone) {
    return graphCall([&](const Driver& d) { return d.cuGraphNodeFindInClone; }, node, original,
                     clone);
}
SUNSTONE_CUDART cudaError_t cudaGraphDestroyNode(cudaGraphNode_t node) {
    return graphCall([&](const Driver& d) { return d.cuGraphDestroyNode; }, node);
}
SUNSTONE_CUDART cudaError_t cudaGraphAddChildGraphNode(cudaGraphNode_t* node, cudaGraph_t graph,
                                                       const cudaGraphNode_t* dependencies,
                                                       size_t count, cudaGraph_t child) {
    return graphCall([&](const Driver& d) { return d.cuGraphAddChildGraphNode; }, node, graph,
                     dependencies, count, child);
}
SUNSTONE_CUDART cudaError_t cudaGraphAddEmptyNode(cudaGraphNode_t* node, cudaGraph_t graph,
                                                  const cudaGraphNode_t* dependencies,
                                                  size_t count) {
    return graphCall([&](const Driver& d) { return d.cuGraphAddEmptyNode; }, node, graph,
                     dependencies, count);
}
SUNSTONE_CUDART cudaError_t cudaGraphAddEventRecordNode(cudaGraphNode_t* node, cudaGraph_t graph,
                                                        const cudaGraphNode_t* dependencies,
                                                        size_t count, cudaEvent_t event) {
    return graphCall([&](const Driver& d) { return d.cuGraphAddEventRecordNode; }, node, graph,
                     dependencies, count, event);
}
SUNSTONE_CUDART cudaError_t cudaGraphAddEventWaitNode(cudaGraphNode_t* node, cudaGraph_t graph,
                                                      const cudaGraphNode_t* dependencies,
                                                      size_t count, cudaEvent_t event) {
    return graphCall([&](const Driver& d) { return d.cuGraphAddEventWaitNode; }, node, graph,
                     dependencies, count, event);
}
SUNSTONE_CUDART cudaError_t cudaGraphAddHostNode(cudaGraphNode_t* node, cudaGraph_t graph,
                                                 const cudaGraphNode_t* dependencies, size_t count,
                                                 const struct cudaHostNodeParams* params) {
    return graphCall([&](const Driver& d) { return d.cuGraphAddHostNode; }, node, graph,
                     dependencies, count, reinterpret_cast<const CUDA_HOST_NODE_PARAMS*>(params));
}
SUNSTONE_CUDART cudaError_t cudaGraphHostNodeGetParams(cudaGraphNode_t node,
                                                       struct cudaHostNodeParams* params) {
    return graphCall([&](const Driver& d) { return d.cuGraphHostNodeGetParams; }, node,
                     reinterpret_cast<CUDA_HOST_NODE_PARAMS*>(params));
}
SUNSTONE_CUDART cudaError_t cudaGraphHostNodeSetParams(cudaGraphNode_t node,
                                                       const struct cudaHostNodeParams* params) {
    return graphCall([&](const Driver& d) { return d.cuGraphHostNodeSetParams; }, node,
                     reinterpret_cast<const CUDA_HOST_NODE_PARAMS*>(params));
}
SUNSTONE_CUDART cudaError_t cudaGraphChildGraphNodeGetGraph(cudaGraphNode_t node,
                                                            cudaGraph_t* graph) {
    return graphCall([&](const Driver& d) { return d.cuGraphChildGraphNodeGetGraph; }, node, graph);
}
SUNSTONE_CUDART cudaError_t cudaGraphEventRecordNodeGetEvent(cudaGraphNode_t node,
                                                             cudaEvent_t* event) {
    return graphCall([&](const Driver& d) { return d.cuGraphEventRecordNodeGetEvent; }, node,
                     event);
}
SUNSTONE_CUDART cudaError_t cudaGraphEventWaitNodeGetEvent(cudaGraphNode_t node,
                                                           cudaEvent_t* event) {
    return graphCall([&](const Driver& d) { return d.cuGraphEventWaitNodeGetEvent; }, node, event);
}
SUNSTONE_CUDART cudaError_t cudaGraphNodeGetType(cudaGraphNode_t node,
                                                 enum cudaGraphNodeType* type) {
    return graphCall([&](const Driver& d) { return d.cuGraphNodeGetType; }, node,
                     reinterpret_cast<CUgraphNodeType*>(type));
}
SUNSTONE_CUDART cudaError_t cudaGraphGetNodes(cudaGraph_t graph, cudaGraphNode_t* nodes,
                                              size_t* count) {
    return graphCall([&](const Driver& d) { return d.cuGraphGetNodes; }, graph, nodes, count);
}
SUNSTONE_CUDART cudaError_t cudaGraphGetRootNodes(cudaGraph_t graph, cudaGraphNode_t* nodes,
                                                  size_t* count) {
    return graphCall([&](const Driver& d) { return d.cuGraphGetRootNodes; }, graph, nodes, count);
}
SUNSTONE_CUDART cudaError_t SUNSTONE_SINCE_13(cudaGraphGetEdges, cudaGraphGetEdges_v2)(
    cudaGraph_t graph, cudaGraphNode_t* from, cudaGraphNode_t* to, cudaGraphEdgeData* edges,
    size_t* count) {
    return graphCall([&](const Driver& d) { return d.cuGraphGetEdges; }, graph, from, to,
                     reinterpret_cast<CUgraphEdgeData*>(edges), count);
}
SUNSTONE_CUDART cudaError_t SUNSTONE_SINCE_13(cudaGraphNodeGetDependencies,
                                              cudaGraphNodeGetDependencies_v2)(
    cudaGraphNode_t node, cudaGraphNode_t* dependencies, cudaGraphEdgeData* edges, size_t* count) {
    return graphCall([&](const Driver& d) { return d.cuGraphNodeGetDependencies; }, node,
                     dependencies, reinterpret_cast<CUgraphEdgeData*>(edges), count);
}
SUNSTONE_CUDART cudaError_t SUNSTONE_SINCE_13(cudaGraphNodeGetDependentNodes,
                                              cudaGraphNodeGetDependentNodes_v2)(
    cudaGraphNode_t node, cudaGraphNode_t* dependents, cudaGraphEdgeData* edges, size_t* count) {
    return graphCall([&](const Driver& d) { return d.cuGraphNodeGetDependentNodes; }, node,
                     dependents, reinterpret_cast<CUgraphEdgeData*>(edges), count);
}
SUNSTONE_CUDART cudaError_t SUNSTONE_SINCE_13(cudaGraphAddDependencies,
                                              cudaGraphAddDependencies_v2)(
    cudaGraph_t graph, const cudaGraphNode_t* from, const cudaGraphNode_t* to,
    const cudaGraphEdgeData* edges, size_t count) {
    return graphCall([&](const Driver& d) { return d.cuGraphAddDependencies; }, graph, from, to,
                     reinterpret_cast<const CUgraphEdgeData*>(edges), count);
}
SUNSTONE_CUDART cudaError_t SUNSTONE_SINCE_13(cudaGraphRemoveDependencies,
                                              cudaGraphRemoveDependencies_v2)(
    cudaGraph_t graph, const cudaGraphNode_t* from, const cudaGraphNode_t* to,
    const cudaGraphEdgeData* edges, size_t count) {
    return graphCall([&](const Driver& d) { return d.cuGraphRemoveDependencies; }, graph, from, to,
                     reinterpret_cast<const CUgraphEdgeData*>(edges), count);
}
SUNSTONE_CUDART cudaError_t cudaGraphInstantiate(cudaGraphExec_t* exec, cudaGraph_t graph,
                                                 unsigned long long flags) {
    return graphCall([&](const Driver& d) { return d.cuGraphInstantiateWithFlags; }, exec, graph,
                     flags);
}
SUNSTONE_CUDART cudaError_t cudaGraphInstantiateWithFlags(cudaGraphExec_t* exec, cudaGraph_t graph,
                                                          unsigned long long flags) {
    return graphCall([&](const Driver& d) { return d.cuGraphInstantiateWithFlags; }, exec, graph,
                     flags);
}
SUNSTONE_CUDART cudaError_t cudaGraphExecGetFlags(cudaGraphExec_t exec, unsigned long long* flags) {
    return graphCall([&](const Driver& d) { return d.cuGraphExecGetFlags; }, exec,
                     reinterpret_cast<cuuint64_t*>(flags));
}
SUNSTONE_CUDART cudaError_t cudaGraphExecDestroy(cudaGraphExec_t exec) {
    return graphCall([&](const Driver& d) { return d.cuGraphExecDestroy; }, exec);
}
SUNSTONE_CUDART cudaError_t cudaGraphExecUpdate(cudaGraphExec_t exec, cudaGraph_t graph,
                                                cudaGraphExecUpdateResultInfo* info) {
    return graphCall([&](const Driver& d) { return d.cuGraphExecUpdate; }, exec, graph,
                     reinterpret_cast<CUgraphExecUpdateResultInfo*>(info));
}
SUNSTONE_CUDART cudaError_t cudaGraphExecHostNodeSetParams(
    cudaGraphExec_t exec, cudaGraphNode_t node, const struct cudaHostNodeParams* params) {
    return graphCall([&](const Driver& d) { return d.cuGraphExecHostNodeSetParams; }, exec, node,
                     reinterpret_cast<const CUDA_HOST_NODE_PARAMS*>(params));
}
SUNSTONE_CUDART cudaError_t cudaGraphNodeSetEnabled(cudaGraphExec_t exec, cudaGraphNode_t node,
                                                    unsigned int enabled) {
    return graphCall([&](const Driver& d) { return d.cuGraphNodeSetEnabled; }, exec, node, enabled);
}
SUNSTONE_CUDART cudaError_t cudaGraphNodeGetEnabled(cudaGraphExec_t exec, cudaGraphNode_t node,
                                                    unsigned int* enabled) {
    return graphCall([&](const Driver& d) { return d.cuGraphNodeGetEnabled; }, exec, node, enabled);
}

#define SUNSTONE_ADD(Kind, driverFunction, From, To, ...)                                          \
    SUNSTONE_CUDART cudaError_t cudaGraphAdd##Kind##Node(                                          \
        cudaGraphNode_t* node, cudaGraph_t graph, const cudaGraphNode_t* dependencies,             \
        size_t count, const struct From* params) {                                                 \
        return with<To>(params, [&](const Driver& d, To* p, CUcontext context) {                   \
            (void)context;                                                                         \
            return present(d.driverFunction, node, graph, dependencies, count,                     \
                           p __VA_OPT__(, ) __VA_ARGS__);                                          \
        });                                                                                        \
    }
SUNSTONE_ADD(Kernel, cuGraphAddKernelNode, cudaKernelNodeParams, CUDA_KERNEL_NODE_PARAMS)
SUNSTONE_ADD(Memcpy, cuGraphAddMemcpyNode, cudaMemcpy3DParms, CUDA_MEMCPY3D, context)
SUNSTONE_ADD(Memset, cuGraphAddMemsetNode, cudaMemsetParams, CUDA_MEMSET_NODE_PARAMS, context)

#define SUNSTONE_SET(Kind, From, To, ...)                                                          \
    SUNSTONE_CUDART cudaError_t cudaGraph##Kind##NodeSetParams(cudaGraphNode_t node,               \
                                                               const struct From* params) {        \
        return with<To>(params, [&](const Driver& d, To* p, CUcontext) {                           \
            return present(d.cuGraph##Kind##NodeSetParams, node, p);                               \
        });                                                                                        \
    }                                                                                              \
    SUNSTONE_CUDART cudaError_t cudaGraphExec##Kind##NodeSetParams(                                \
        cudaGraphExec_t exec, cudaGraphNode_t node, const struct From* params) {                   \
        return with<To>(params, [&](const Driver& d, To* p, CUcontext context) {                   \
            (void)context;                                                                         \
            return present(d.cuGraphExec##Kind##NodeSetParams, exec, node,                         \
                           p __VA_OPT__(, ) __VA_ARGS__);                                          \
        });                                                                                        \
    }
SUNSTONE_SET(Memcpy, cudaMemcpy3DParms, CUDA_MEMCPY3D, context)
SUNSTONE_SET(Memset, cudaMemsetParams, CUDA_MEMSET_NODE_PARAMS, context)

SUNSTONE_CUDART cudaError_t
cudaGraphKernelNodeSetParams(cudaGraphNode_t node, const struct cudaKernelNodeParams* params) {
    return with<CUDA_KERNEL_NODE_PARAMS>(
        params, [&](const Driver& d, CUDA_KERNEL_NODE_PARAMS* p, CUcontext) {
            return present(d.cuGraphKernelNodeSetParams, node, p);
        });
}
SUNSTONE_CUDART cudaError_t cudaGraphExecKernelNodeSetParams(
    cudaGraphExec_t exec, cudaGraphNode_t node, const struct cudaKernelNodeParams* params) {
    return with<CUDA_KERNEL_NODE_PARAMS>(
        params, [&](const Driver& d, CUDA_KERNEL_NODE_PARAMS* p, CUcontext) {
            return present(d.cuGraphExecKernelNodeSetParams, exec, node, p);
        });
}
SUNSTONE_CUDART cudaError_t cudaGraphKernelNodeGetParams(cudaGraphNode_t node,
                                                         struct cudaKernelNodeParams* params) {
    return call([&](const Driver& d) {
        if (!params)
            return cudaErrorInvalidValue;
        CUDA_KERNEL_NODE_PARAMS p = {};
        if (const cudaError_t error = present(d.cuGraphKernelNodeGetParams, node, &p))
            return error;
        const void* symbol = symbolOf(p.func);
        if (!symbol)
            return cudaErrorInvalidDeviceFunction; // a kernel the runtime did not register
        *params = {const_cast<void*>(symbol),
                   {p.gridDimX, p.gridDimY, p.gridDimZ},
                   {p.blockDimX, p.blockDimY, p.blockDimZ},
                   p.sharedMemBytes,
                   p.kernelParams,
                   p.extra};
        return cudaSuccess;
    });
}
SUNSTONE_CUDART cudaError_t cudaGraphMemsetNodeGetParams(cudaGraphNode_t node,
                                                         struct cudaMemsetParams* params) {
    return call([&](const Driver& d) {
        if (!params)
            return cudaErrorInvalidValue;
        CUDA_MEMSET_NODE_PARAMS p = {};
        if (const cudaError_t error = present(d.cuGraphMemsetNodeGetParams, node, &p))
            return error;
        *params = {
            reinterpret_cast<void*>(p.dst), p.pitch, p.value, p.elementSize, p.width, p.height};
        return cudaSuccess;
    });
}

SUNSTONE_CUDART cudaError_t cudaGraphAddMemcpyNode1D(cudaGraphNode_t* node, cudaGraph_t graph,
                                                     const cudaGraphNode_t* dependencies,
                                                     size_t count, void* dst, const void* src,
                                                     size_t bytes, enum cudaMemcpyKind kind) {
    const cudaMemcpy3DParms parms = linear(dst, src, bytes, kind);
    return cudaGraphAddMemcpyNode(node, graph, dependencies, count, &parms);
}
SUNSTONE_CUDART cudaError_t cudaGraphMemcpyNodeSetParams1D(cudaGraphNode_t node, void* dst,
                                                           const void* src, size_t bytes,
                                                           enum cudaMemcpyKind kind) {
    const cudaMemcpy3DParms parms = linear(dst, src, bytes, kind);
    return cudaGraphMemcpyNodeSetParams(node, &parms);
}
SUNSTONE_CUDART cudaError_t cudaGraphExecMemcpyNodeSetParams1D(cudaGraphExec_t exec,
                                                               cudaGraphNode_t node, void* dst,
                                                               const void* src, size_t bytes,
                                                               enum cudaMemcpyKind kind) {
    const cudaMemcpy3DParms parms = linear(dst, src, bytes, kind);
    return cudaGraphExecMemcpyNodeSetParams(exec, node, &parms);
}
