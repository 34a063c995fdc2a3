// SPDX-License-Identifier: Apache-2.0
// Graph nodes that copy to and from variables of the program, and attributes of kernel nodes.
#include "api/cuda/runtime/graphs.h"

using namespace sunstone::cudart;

namespace {

// Calls `body` with the address of the part of the variable that the node copies.
template <class Body>
cudaError_t withSymbol(const void* symbol, size_t bytes, size_t offset, cudaMemcpyKind kind,
                       cudaMemcpyKind hostKind, Body&& body) {
    if (kind != hostKind && kind != cudaMemcpyDeviceToDevice && kind != cudaMemcpyDefault)
        return remember(cudaErrorInvalidMemcpyDirection);
    void* address = nullptr;
    const cudaError_t error = findInVariable(symbol, bytes, offset, &address);
    return error ? error : body(address);
}

} // namespace

SUNSTONE_CUDART cudaError_t cudaGraphAddMemcpyNodeToSymbol(
    cudaGraphNode_t* node, cudaGraph_t graph, const cudaGraphNode_t* dependencies, size_t count,
    const void* symbol, const void* src, size_t bytes, size_t offset, enum cudaMemcpyKind kind) {
    return withSymbol(symbol, bytes, offset, kind, cudaMemcpyHostToDevice, [&](void* address) {
        return cudaGraphAddMemcpyNode1D(node, graph, dependencies, count, address, src, bytes,
                                        kind);
    });
}
SUNSTONE_CUDART cudaError_t cudaGraphAddMemcpyNodeFromSymbol(
    cudaGraphNode_t* node, cudaGraph_t graph, const cudaGraphNode_t* dependencies, size_t count,
    void* dst, const void* symbol, size_t bytes, size_t offset, enum cudaMemcpyKind kind) {
    return withSymbol(symbol, bytes, offset, kind, cudaMemcpyDeviceToHost, [&](void* address) {
        return cudaGraphAddMemcpyNode1D(node, graph, dependencies, count, dst, address, bytes,
                                        kind);
    });
}
SUNSTONE_CUDART cudaError_t cudaGraphMemcpyNodeSetParamsToSymbol(cudaGraphNode_t node,
                                                                 const void* symbol,
                                                                 const void* src, size_t bytes,
                                                                 size_t offset,
                                                                 enum cudaMemcpyKind kind) {
    return withSymbol(symbol, bytes, offset, kind, cudaMemcpyHostToDevice, [&](void* address) {
        return cudaGraphMemcpyNodeSetParams1D(node, address, src, bytes, kind);
    });
}
SUNSTONE_CUDART cudaError_t cudaGraphMemcpyNodeSetParamsFromSymbol(cudaGraphNode_t node, void* dst,
                                                                   const void* symbol, size_t bytes,
                                                                   size_t offset,
                                                                   enum cudaMemcpyKind kind) {
    return withSymbol(symbol, bytes, offset, kind, cudaMemcpyDeviceToHost, [&](void* address) {
        return cudaGraphMemcpyNodeSetParams1D(node, dst, address, bytes, kind);
    });
}
SUNSTONE_CUDART cudaError_t cudaGraphExecMemcpyNodeSetParamsToSymbol(
    cudaGraphExec_t exec, cudaGraphNode_t node, const void* symbol, const void* src, size_t bytes,
    size_t offset, enum cudaMemcpyKind kind) {
    return withSymbol(symbol, bytes, offset, kind, cudaMemcpyHostToDevice, [&](void* address) {
        return cudaGraphExecMemcpyNodeSetParams1D(exec, node, address, src, bytes, kind);
    });
}
SUNSTONE_CUDART cudaError_t cudaGraphExecMemcpyNodeSetParamsFromSymbol(
    cudaGraphExec_t exec, cudaGraphNode_t node, void* dst, const void* symbol, size_t bytes,
    size_t offset, enum cudaMemcpyKind kind) {
    return withSymbol(symbol, bytes, offset, kind, cudaMemcpyDeviceToHost, [&](void* address) {
        return cudaGraphExecMemcpyNodeSetParams1D(exec, node, dst, address, bytes, kind);
    });
}

static_assert(sizeof(cudaLaunchAttributeValue) == sizeof(CUkernelNodeAttrValue));

SUNSTONE_CUDART cudaError_t cudaGraphKernelNodeGetAttribute(cudaGraphNode_t node,
                                                            enum cudaLaunchAttributeID id,
                                                            union cudaLaunchAttributeValue* value) {
    return graphCall([](const Driver& d) { return d.cuGraphKernelNodeGetAttribute; }, node,
                     static_cast<CUkernelNodeAttrID>(id),
                     reinterpret_cast<CUkernelNodeAttrValue*>(value));
}
SUNSTONE_CUDART cudaError_t
cudaGraphKernelNodeSetAttribute(cudaGraphNode_t node, enum cudaLaunchAttributeID id,
                                const union cudaLaunchAttributeValue* value) {
    return graphCall([](const Driver& d) { return d.cuGraphKernelNodeSetAttribute; }, node,
                     static_cast<CUkernelNodeAttrID>(id),
                     reinterpret_cast<const CUkernelNodeAttrValue*>(value));
}
SUNSTONE_CUDART cudaError_t cudaGraphKernelNodeCopyAttributes(cudaGraphNode_t target,
                                                              cudaGraphNode_t source) {
    return graphCall([](const Driver& d) { return d.cuGraphKernelNodeCopyAttributes; }, target,
                     source);
}
