// SPDX-License-Identifier: Apache-2.0
// Executable graphs: instantiate, update, destroy. Source: CUDA driver API, graph management.
#include "api/cuda/driver/graphs/graphs.h"

#include "base/handles.h"

using namespace sunstone;
using namespace sunstone::api::cuda;
using cpu::ExecutableGraph;
using cpu::WorkKind;

namespace {

struct Exec {
    std::shared_ptr<ExecutableGraph> graph;
    unsigned long long flags = 0;
};

HandleTable<Exec>& execs() {
    static auto* table = new HandleTable<Exec>;
    return *table;
}

std::shared_ptr<Exec> liveExec(CUgraphExec handle) {
    std::shared_ptr<Exec> found = execs().find(handle);
    if (!found)
        refuse(CUDA_ERROR_INVALID_VALUE, static_cast<void*>(handle),
               " is not a live executable graph");
    return found;
}

void instantiate(CUgraphExec* exec, CUgraph graph, unsigned long long flags) {
    require(exec, "exec is null");
    constexpr unsigned long long kKnown =
        CUDA_GRAPH_INSTANTIATE_FLAG_AUTO_FREE_ON_LAUNCH | CUDA_GRAPH_INSTANTIATE_FLAG_UPLOAD |
        CUDA_GRAPH_INSTANTIATE_FLAG_DEVICE_LAUNCH | CUDA_GRAPH_INSTANTIATE_FLAG_USE_NODE_PRIORITY;
    require((flags & ~kKnown) == 0, "unknown flags");
    if (flags & CUDA_GRAPH_INSTANTIATE_FLAG_DEVICE_LAUNCH)
        refuse(CUDA_ERROR_NOT_SUPPORTED, "launching a graph from device code");
    auto made = std::make_shared<Exec>();
    made->graph = std::make_shared<ExecutableGraph>(*graphOf(graph));
    made->flags = flags;
    *exec = static_cast<CUgraphExec>(execs().add(std::move(made)));
}

template <class Params>
CUresult setParams(const char* function, CUgraphExec exec, CUgraphNode node, WorkKind kind,
                   const Params* params) {
    return guardedGraph(function, [&] {
        std::shared_ptr<ExecutableGraph> graph = execOf(exec);
        cpu::GraphNode made = nodeFor(params);
        require(graph->replace(reinterpret_cast<cpu::GraphNode*>(node), kind, std::move(made.work)),
                "the executable graph was not made from this node, or it is of another type");
    });
}

CUresult update(CUgraphExec exec, CUgraph graph, CUgraphExecUpdateResultInfo& info) {
    return guardedGraph("cuGraphExecUpdate", [&] {
        info = {CU_GRAPH_EXEC_UPDATE_ERROR, nullptr, nullptr};
        const ExecutableGraph::Difference difference = execOf(exec)->update(*graphOf(graph));
        if (difference.kind == ExecutableGraph::Difference::kNone) {
            info.result = CU_GRAPH_EXEC_UPDATE_SUCCESS;
            return;
        }
        info.result = difference.kind == ExecutableGraph::Difference::kTopology
                          ? CU_GRAPH_EXEC_UPDATE_ERROR_TOPOLOGY_CHANGED
                          : CU_GRAPH_EXEC_UPDATE_ERROR_NODE_TYPE_CHANGED;
        info.errorNode = handleOf(difference.other);
        refuse(CUDA_ERROR_GRAPH_EXEC_UPDATE_FAILURE, "the graph has another ",
               info.result == CU_GRAPH_EXEC_UPDATE_ERROR_TOPOLOGY_CHANGED ? "topology"
                                                                          : "type of node");
    });
}

} // namespace

namespace sunstone::api::cuda {

std::shared_ptr<ExecutableGraph> execOf(CUgraphExec exec) {
    return liveExec(exec)->graph;
}

CUresult instantiateWith(CUgraphExec* exec, CUgraph graph, CUDA_GRAPH_INSTANTIATE_PARAMS* params) {
    return guardedGraph("cuGraphInstantiateWithParams", Needs::kContext, [&] {
        require(params, "params is null");
        params->hErrNode_out = nullptr;
        params->result_out = CUDA_GRAPH_INSTANTIATE_ERROR;
        if (params->flags & CUDA_GRAPH_INSTANTIATE_FLAG_UPLOAD)
            streamOf(params->hUploadStream);
        try {
            instantiate(exec, graph, params->flags);
        } catch (const cpu::CaptureError&) {
            params->result_out = CUDA_GRAPH_INSTANTIATE_INVALID_STRUCTURE;
            throw;
        }
        params->result_out = CUDA_GRAPH_INSTANTIATE_SUCCESS;
    });
}

} // namespace sunstone::api::cuda

SUNSTONE_EXPORT CUresult cuGraphInstantiateWithFlags(CUgraphExec* exec, CUgraph graph,
                                                     unsigned long long flags) {
    return guardedGraph("cuGraphInstantiateWithFlags", Needs::kContext,
                        [&] { instantiate(exec, graph, flags); });
}

// The older forms, which return a node and a text for errors.
#undef cuGraphInstantiate
SUNSTONE_EXPORT CUresult cuGraphInstantiate(CUgraphExec* exec, CUgraph graph, CUgraphNode* node,
                                            char* log, size_t size) {
    if (node)
        *node = nullptr;
    if (log && size)
        log[0] = 0;
    return guardedGraph("cuGraphInstantiate", Needs::kContext,
                        [&] { instantiate(exec, graph, 0); });
}
SUNSTONE_EXPORT CUresult cuGraphInstantiate_v2(CUgraphExec* exec, CUgraph graph, CUgraphNode* node,
                                               char* log, size_t size) {
    return cuGraphInstantiate(exec, graph, node, log, size);
}

SUNSTONE_EXPORT CUresult cuGraphExecGetFlags(CUgraphExec exec, cuuint64_t* flags) {
    return guardedGraph("cuGraphExecGetFlags", [&] {
        require(flags, "flags is null");
        *flags = liveExec(exec)->flags;
    });
}

SUNSTONE_EXPORT CUresult cuGraphExecDestroy(CUgraphExec exec) {
    return guardedGraph("cuGraphExecDestroy", [&] {
        liveExec(exec);
        execs().remove(exec); // a launch in progress owns what it uses
    });
}

SUNSTONE_EXPORT CUresult cuGraphExecUpdate(CUgraphExec exec, CUgraph graph,
                                           CUgraphExecUpdateResultInfo* info) {
    CUgraphExecUpdateResultInfo result = {};
    const CUresult error = update(exec, graph, result);
    if (info)
        *info = result;
    return error;
}
#undef cuGraphExecUpdate
SUNSTONE_EXPORT CUresult cuGraphExecUpdate(CUgraphExec exec, CUgraph graph, CUgraphNode* errorNode,
                                           CUgraphExecUpdateResult* result) {
    CUgraphExecUpdateResultInfo info = {};
    const CUresult error = update(exec, graph, info);
    if (errorNode)
        *errorNode = info.errorNode;
    if (result)
        *result = info.result;
    return error;
}

SUNSTONE_EXPORT CUresult cuGraphExecKernelNodeSetParams(CUgraphExec exec, CUgraphNode node,
                                                        const CUDA_KERNEL_NODE_PARAMS* params) {
    return setParams("cuGraphExecKernelNodeSetParams", exec, node, WorkKind::kKernel, params);
}
SUNSTONE_EXPORT CUresult cuGraphExecMemcpyNodeSetParams(CUgraphExec exec, CUgraphNode node,
                                                        const CUDA_MEMCPY3D* params,
                                                        CUcontext context) {
    (void)context;
    return setParams("cuGraphExecMemcpyNodeSetParams", exec, node, WorkKind::kCopy, params);
}
SUNSTONE_EXPORT CUresult cuGraphExecMemsetNodeSetParams(CUgraphExec exec, CUgraphNode node,
                                                        const CUDA_MEMSET_NODE_PARAMS* params,
                                                        CUcontext context) {
    (void)context;
    return setParams("cuGraphExecMemsetNodeSetParams", exec, node, WorkKind::kSet, params);
}
SUNSTONE_EXPORT CUresult cuGraphExecHostNodeSetParams(CUgraphExec exec, CUgraphNode node,
                                                      const CUDA_HOST_NODE_PARAMS* params) {
    return setParams("cuGraphExecHostNodeSetParams", exec, node, WorkKind::kHost, params);
}

SUNSTONE_EXPORT CUresult cuGraphNodeSetEnabled(CUgraphExec exec, CUgraphNode node,
                                               unsigned int enabled) {
    return guardedGraph("cuGraphNodeSetEnabled", [&] {
        require(execOf(exec)->setEnabled(reinterpret_cast<cpu::GraphNode*>(node), enabled != 0),
                "the executable graph was not made from this node");
    });
}
SUNSTONE_EXPORT CUresult cuGraphNodeGetEnabled(CUgraphExec exec, CUgraphNode node,
                                               unsigned int* enabled) {
    return guardedGraph("cuGraphNodeGetEnabled", [&] {
        require(enabled, "enabled is null");
        bool is = false;
        require(execOf(exec)->isEnabled(reinterpret_cast<cpu::GraphNode*>(node), is),
                "the executable graph was not made from this node");
        *enabled = is;
    });
}
