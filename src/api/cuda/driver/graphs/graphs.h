// SPDX-License-Identifier: Apache-2.0
// Graph handles of the driver API, and conversion of node parameters to work.
#pragma once

#include "api/cuda/driver/shell.h"
#include "device/cpu/graph.h"

namespace sunstone::api::cuda {

// The live graph of a handle; throws CUDA_ERROR_INVALID_VALUE, like all functions here.
std::shared_ptr<cpu::Graph> graphOf(CUgraph graph);
CUgraph handleOf(const std::shared_ptr<cpu::Graph>& graph); // registers a new graph
std::shared_ptr<cpu::ExecutableGraph> execOf(CUgraphExec exec);
CUresult instantiateWith(CUgraphExec* exec, CUgraph graph, CUDA_GRAPH_INSTANTIATE_PARAMS* params);
// A node and its graph; checks the node's kind if one is given.
struct NodeInGraph {
    cpu::GraphNode* node;
    std::shared_ptr<cpu::Graph> graph;
};
NodeInGraph nodeOf(CUgraphNode handle);
NodeInGraph nodeOf(CUgraphNode handle, cpu::WorkKind kind);
inline CUgraphNode handleOf(const cpu::GraphNode* node) {
    return reinterpret_cast<CUgraphNode>(const_cast<cpu::GraphNode*>(node));
}
// The nodes of `handles`, which must be nodes of this graph.
std::vector<cpu::GraphNode*> nodesOf(const cpu::Graph& graph, const CUgraphNode* handles,
                                     size_t count);
// Edges here have no ports or types.
void requirePlainEdges(const CUgraphEdgeData* edges, size_t count);

// Checks parameters and makes a node's kind, work and details from them.
cpu::GraphNode nodeFor(const CUDA_KERNEL_NODE_PARAMS* params, bool cooperative = false);
cpu::GraphNode nodeFor(const CUDA_MEMCPY3D* params);
cpu::GraphNode nodeFor(const CUDA_MEMSET_NODE_PARAMS* params);
cpu::GraphNode nodeFor(const CUDA_HOST_NODE_PARAMS* params);

// Whether the attributes of a kernel node make it cooperative.
bool isCooperative(const cpu::GraphNode& node);

// Makes memory allocated in a capture live as long as its graph.
void ownByGraph(cpu::Graph& graph, CUdeviceptr address);
bool isOwnedByGraph(CUdeviceptr address);

// Like guarded(), for functions that access graphs.
template <class Body>
CUresult guardedGraph(const char* function, Precondition needs, Body&& body) {
    return guarded(function, needs, [&] {
        std::lock_guard lock(cpu::graphMutex());
        return body();
    });
}
template <class Body>
CUresult guardedGraph(const char* function, Body&& body) {
    return guardedGraph(function, Needs::kObject, body);
}

} // namespace sunstone::api::cuda
