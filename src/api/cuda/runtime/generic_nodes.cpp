// SPDX-License-Identifier: Apache-2.0
// Graph nodes of any type with one parameter struct: each call forwards to the type's own function.
#include "api/cuda/runtime/graphs.h"

#include <algorithm>
#include <cstdio>

using namespace sunstone::cudart;

namespace {

cudaError_t refused(const char* function, cudaError_t error, const char* rule, long long value) {
    std::fprintf(stderr, "[sunstone cudart] %s: %s, not %lld\n", function, rule, value);
    return remember(error);
}

// cudaSuccess if the parameters are valid.
cudaError_t check(const char* function, const cudaGraphNodeParams* params) {
    if (!params)
        return refused(function, cudaErrorInvalidValue, "params must be the address of a struct",
                       0);
    if (params->type < cudaGraphNodeTypeKernel || params->type > 13)
        return refused(function, cudaErrorInvalidValue, "params->type must be a type of nodes",
                       params->type);
    if (params->type > cudaGraphNodeTypeEventRecord)
        return refused(function, cudaErrorNotSupported,
                       "nodes of semaphores, memory and conditions are not available; "
                       "params->type must be at most 7",
                       params->type);
    if (params->type == cudaGraphNodeTypeGraph && params->graph.ownership != 0)
        return refused(function, cudaErrorNotSupported,
                       "graphs cannot be moved; params->graph.ownership must be 0",
                       params->graph.ownership);
    return cudaSuccess;
}

bool hasPorts(const cudaGraphEdgeData* edges, size_t count) {
    return edges && std::any_of(edges, edges + count, [](const cudaGraphEdgeData& edge) {
               return edge.from_port || edge.to_port || edge.type;
           });
}

} // namespace

SUNSTONE_CUDART cudaError_t SUNSTONE_SINCE_13(cudaGraphAddNode, cudaGraphAddNode_v2)(
    cudaGraphNode_t* node, cudaGraph_t graph, const cudaGraphNode_t* dependencies,
    const cudaGraphEdgeData* edges, size_t count, cudaGraphNodeParams* params) {
    if (const cudaError_t error = check("cudaGraphAddNode", params))
        return error;
    if (hasPorts(edges, count))
        return refused("cudaGraphAddNode", cudaErrorNotSupported,
                       "edges with ports are not available; from_port must be 0", edges->from_port);
    switch (params->type) {
    case cudaGraphNodeTypeKernel:
        return cudaGraphAddKernelNode(node, graph, dependencies, count, &params->kernel);
    case cudaGraphNodeTypeMemcpy:
        return cudaGraphAddMemcpyNode(node, graph, dependencies, count, &params->memcpy.copyParams);
    case cudaGraphNodeTypeMemset:
        return cudaGraphAddMemsetNode(node, graph, dependencies, count, &params->memset);
    case cudaGraphNodeTypeHost:
        return cudaGraphAddHostNode(node, graph, dependencies, count, &params->host);
    case cudaGraphNodeTypeGraph:
        return cudaGraphAddChildGraphNode(node, graph, dependencies, count, params->graph.graph);
    case cudaGraphNodeTypeWaitEvent:
        return cudaGraphAddEventWaitNode(node, graph, dependencies, count, params->eventWait.event);
    case cudaGraphNodeTypeEventRecord:
        return cudaGraphAddEventRecordNode(node, graph, dependencies, count,
                                           params->eventRecord.event);
    default:
        return cudaGraphAddEmptyNode(node, graph, dependencies, count);
    }
}

SUNSTONE_CUDART cudaError_t cudaGraphNodeSetParams(cudaGraphNode_t node,
                                                   cudaGraphNodeParams* params) {
    if (const cudaError_t error = check("cudaGraphNodeSetParams", params))
        return error;
    switch (params->type) {
    case cudaGraphNodeTypeKernel:
        return cudaGraphKernelNodeSetParams(node, &params->kernel);
    case cudaGraphNodeTypeMemcpy:
        return cudaGraphMemcpyNodeSetParams(node, &params->memcpy.copyParams);
    case cudaGraphNodeTypeMemset:
        return cudaGraphMemsetNodeSetParams(node, &params->memset);
    case cudaGraphNodeTypeHost:
        return cudaGraphHostNodeSetParams(node, &params->host);
    default:
        return refused("cudaGraphNodeSetParams", cudaErrorNotSupported,
                       "nodes of graphs and events cannot change; params->type must be at most 3",
                       params->type);
    }
}

SUNSTONE_CUDART cudaError_t cudaGraphExecNodeSetParams(cudaGraphExec_t exec, cudaGraphNode_t node,
                                                       cudaGraphNodeParams* params) {
    if (const cudaError_t error = check("cudaGraphExecNodeSetParams", params))
        return error;
    switch (params->type) {
    case cudaGraphNodeTypeKernel:
        return cudaGraphExecKernelNodeSetParams(exec, node, &params->kernel);
    case cudaGraphNodeTypeMemcpy:
        return cudaGraphExecMemcpyNodeSetParams(exec, node, &params->memcpy.copyParams);
    case cudaGraphNodeTypeMemset:
        return cudaGraphExecMemsetNodeSetParams(exec, node, &params->memset);
    case cudaGraphNodeTypeHost:
        return cudaGraphExecHostNodeSetParams(exec, node, &params->host);
    default:
        return refused("cudaGraphExecNodeSetParams", cudaErrorNotSupported,
                       "nodes of graphs and events cannot change; params->type must be at most 3",
                       params->type);
    }
}
