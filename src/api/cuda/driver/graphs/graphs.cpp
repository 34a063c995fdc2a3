// SPDX-License-Identifier: Apache-2.0
// Graphs: create, query, change. Source: CUDA driver API, graph management.
#include "api/cuda/driver/graphs/graphs.h"

#include "api/cuda/driver/device_faults.h"
#include "api/cuda/driver/launch.h"
#include "api/cuda/driver/memory/copies.h"
#include "base/handles.h"

#include <algorithm>
#include <unordered_map>
#include <unordered_set>

using namespace sunstone;
using namespace sunstone::api::cuda;
using cpu::GraphNode;
using cpu::WorkKind;

namespace {

// All graphs with a handle, including child graphs whose handle has been returned.
std::unordered_map<const cpu::Graph*, std::shared_ptr<cpu::Graph>>& graphs() {
    static auto* table = new std::unordered_map<const cpu::Graph*, std::shared_ptr<cpu::Graph>>;
    return *table; // guarded by graphMutex()
}

// Copies by originals, from clone.
using Twins = std::unordered_map<const GraphNode*, GraphNode*>;
std::unordered_map<const cpu::Graph*, Twins>& twinsOf() {
    static auto* table = new std::unordered_map<const cpu::Graph*, Twins>;
    return *table;
}

std::unordered_set<CUdeviceptr>& ownedMemory() {
    static auto* set = new std::unordered_set<CUdeviceptr>;
    return *set;
}

// Searches a graph and its child graphs.
NodeInGraph findNode(const std::shared_ptr<cpu::Graph>& graph, const GraphNode* wanted) {
    for (const auto& node : graph->nodes()) {
        if (node.get() == wanted)
            return {node.get(), graph};
        if (node->child)
            if (NodeInGraph inner = findNode(node->child, wanted); inner.node)
                return inner;
    }
    return {nullptr, nullptr};
}

CUresult addNode(const char* function, CUgraphNode* handle, CUgraph graph,
                 const CUgraphNode* dependencies, size_t count,
                 const std::function<GraphNode()>& make) {
    return guardedGraph(function, [&] {
        require(handle, "node is null");
        std::shared_ptr<cpu::Graph> owner = graphOf(graph);
        std::vector<GraphNode*> after = nodesOf(*owner, dependencies, count);
        std::unordered_set<GraphNode*> unique(after.begin(), after.end());
        require(unique.size() == after.size(), "a dependency is given twice");
        GraphNode node = make();
        node.after = std::move(after);
        *handle = handleOf(owner->add(std::move(node)));
    });
}

GraphNode eventNode(WorkKind kind, CUevent event) {
    GraphNode node;
    node.kind = kind;
    node.event = eventOf(event);
    return node;
}

// The two-call pattern: the count alone, or as many elements as fit, with null for the excess.
template <class T>
void give(const std::vector<T>& found, T* out, size_t count) {
    for (size_t i = 0; out && i < count; ++i)
        out[i] = i < found.size() ? found[i] : T{};
}
void giveNodes(const std::vector<CUgraphNode>& found, CUgraphNode* nodes, CUgraphEdgeData* edges,
               size_t* count) {
    require(count, "count is null");
    if (!nodes) {
        require(!edges, "edge data without nodes");
        *count = found.size();
        return;
    }
    give(found, nodes, *count);
    for (size_t i = 0; edges && i < *count; ++i)
        edges[i] = {};
    *count = std::min(*count, found.size());
}

template <class Params>
CUresult getParams(const char* function, CUgraphNode handle, WorkKind kind, Params* params) {
    return guardedGraph(function, [&] {
        require(params, "params is null");
        const NodeInGraph found = nodeOf(handle, kind);
        require(found.node->details != nullptr,
                "the node was captured from work without parameters");
        *params = *static_cast<const Params*>(found.node->details.get());
    });
}

template <class Params>
CUresult setParams(const char* function, CUgraphNode handle, WorkKind kind, const Params* params) {
    return guardedGraph(function, [&] {
        GraphNode* node = nodeOf(handle, kind).node;
        GraphNode made = nodeFor(params);
        node->work = std::move(made.work);
        node->details = std::move(made.details);
    });
}

// Whether `wanted` is `from` or comes before it.
bool reaches(const GraphNode* from, const GraphNode* wanted) {
    std::unordered_set<const GraphNode*> seen{from};
    std::vector<const GraphNode*> open{from};
    while (!open.empty()) {
        const GraphNode* node = open.back();
        open.pop_back();
        if (node == wanted)
            return true;
        for (const GraphNode* before : node->after)
            if (seen.insert(before).second)
                open.push_back(before);
    }
    return false;
}

} // namespace

namespace sunstone::api::cuda {

std::shared_ptr<cpu::Graph> graphOf(CUgraph graph) {
    auto found = graphs().find(reinterpret_cast<cpu::Graph*>(graph));
    if (found == graphs().end())
        refuse(CUDA_ERROR_INVALID_VALUE, static_cast<void*>(graph), " is not a live graph");
    return found->second;
}

CUgraph handleOf(const std::shared_ptr<cpu::Graph>& graph) {
    graphs()[graph.get()] = graph;
    return reinterpret_cast<CUgraph>(graph.get());
}

NodeInGraph nodeOf(CUgraphNode handle) {
    for (const auto& [key, graph] : graphs())
        if (NodeInGraph found = findNode(graph, reinterpret_cast<GraphNode*>(handle)); found.node)
            return found;
    refuse(CUDA_ERROR_INVALID_VALUE, static_cast<void*>(handle), " is not a node of a live graph");
}

NodeInGraph nodeOf(CUgraphNode handle, WorkKind kind) {
    NodeInGraph found = nodeOf(handle);
    if (found.node->kind != kind)
        refuse(CUDA_ERROR_INVALID_VALUE, "the node is of type ", unsigned(found.node->kind),
               ", not ", unsigned(kind));
    return found;
}

std::vector<GraphNode*> nodesOf(const cpu::Graph& graph, const CUgraphNode* handles, size_t count) {
    require(count == 0 || handles, "an array of nodes is null");
    std::vector<GraphNode*> nodes;
    for (size_t i = 0; i < count; ++i) {
        auto* node = reinterpret_cast<GraphNode*>(handles[i]);
        if (!graph.owns(node))
            refuse(CUDA_ERROR_INVALID_VALUE, "node ", i, " is not of this graph");
        nodes.push_back(node);
    }
    return nodes;
}

void requirePlainEdges(const CUgraphEdgeData* edges, size_t count) {
    for (size_t i = 0; edges && i < count; ++i)
        if (edges[i].from_port || edges[i].to_port || edges[i].type)
            refuse(CUDA_ERROR_NOT_SUPPORTED, "edge ", i, " has a port or a type");
}

GraphNode nodeFor(const CUDA_KERNEL_NODE_PARAMS* params, bool cooperative) {
    require(params, "params is null");
    CUfunction function = params->func;
    if (!function)
        function = reinterpret_cast<CUfunction>(params->kern);
    PreparedLaunch prepared =
        prepareLaunch({function,
                       {params->gridDimX, params->gridDimY, params->gridDimZ},
                       {params->blockDimX, params->blockDimY, params->blockDimZ},
                       params->sharedMemBytes,
                       params->kernelParams,
                       params->extra,
                       cooperative});
    GraphNode node;
    node.kind = WorkKind::kKernel;
    node.work = std::move(prepared.work);
    node.details = std::move(prepared.details);
    return node;
}

GraphNode nodeFor(const CUDA_MEMCPY3D* params) {
    require(params, "params is null");
    const Copy copy = copyOf(*params);
    if (!copy.shape.empty())
        copy.check();
    GraphNode node;
    node.kind = WorkKind::kCopy;
    node.work = [copy, home = std::weak_ptr(cpu::contexts().shareCurrent())] {
        runInContext(home, [&] { copy.run(); });
    };
    node.details = std::make_shared<CUDA_MEMCPY3D>(*params);
    return node;
}

GraphNode nodeFor(const CUDA_MEMSET_NODE_PARAMS* params) {
    require(params, "params is null");
    const Set set{{reinterpret_cast<std::byte*>(params->dst), params->pitch},
                  params->width,
                  params->height,
                  params->elementSize,
                  params->value};
    require(!set.empty(), "width or height is 0");
    set.check();
    GraphNode node;
    node.kind = WorkKind::kSet;
    node.work = [set, home = std::weak_ptr(cpu::contexts().shareCurrent())] {
        runInContext(home, [&] { set.run(); });
    };
    node.details = std::make_shared<CUDA_MEMSET_NODE_PARAMS>(*params);
    return node;
}

GraphNode nodeFor(const CUDA_HOST_NODE_PARAMS* params) {
    require(params && params->fn, "params or the function is null");
    GraphNode node;
    node.kind = WorkKind::kHost;
    node.work = [call = *params] { call.fn(call.userData); };
    node.details = std::make_shared<CUDA_HOST_NODE_PARAMS>(*params);
    return node;
}

void ownByGraph(cpu::Graph& graph, CUdeviceptr address) {
    ownedMemory().insert(address);
    graph.keep(std::shared_ptr<void>(reinterpret_cast<void*>(address), [](void* pointer) {
        std::lock_guard lock(cpu::graphMutex());
        ownedMemory().erase(reinterpret_cast<CUdeviceptr>(pointer));
        cpu::memory().release(pointer, {cpu::MemoryKind::kDevice});
    }));
}

bool isOwnedByGraph(CUdeviceptr address) {
    std::lock_guard lock(cpu::graphMutex());
    return ownedMemory().contains(address);
}

} // namespace sunstone::api::cuda

SUNSTONE_EXPORT CUresult cuGraphCreate(CUgraph* graph, unsigned int flags) {
    return guardedGraph("cuGraphCreate", [&] {
        require(graph && flags == 0, "graph is null or flags not 0");
        *graph = handleOf(std::make_shared<cpu::Graph>());
    });
}

SUNSTONE_EXPORT CUresult cuGraphDestroy(CUgraph graph) {
    return guardedGraph("cuGraphDestroy", [&] {
        std::shared_ptr<cpu::Graph> dead = graphOf(graph);
        const auto forget = [](auto& self, const cpu::Graph& tree) -> void {
            for (const auto& node : tree.nodes())
                if (node->child) {
                    self(self, *node->child);
                    graphs().erase(node->child.get());
                }
        };
        forget(forget, *dead);
        twinsOf().erase(dead.get());
        graphs().erase(dead.get());
    });
}

SUNSTONE_EXPORT CUresult cuGraphClone(CUgraph* clone, CUgraph original) {
    return guardedGraph("cuGraphClone", [&] {
        require(clone, "clone is null");
        Twins twins;
        std::shared_ptr<cpu::Graph> copy = graphOf(original)->clone(&twins);
        twinsOf()[copy.get()] = std::move(twins);
        *clone = handleOf(copy);
    });
}

SUNSTONE_EXPORT CUresult cuGraphNodeFindInClone(CUgraphNode* node, CUgraphNode original,
                                                CUgraph clone) {
    return guardedGraph("cuGraphNodeFindInClone", [&] {
        require(node, "node is null");
        std::shared_ptr<cpu::Graph> graph = graphOf(clone);
        const auto twins = twinsOf().find(graph.get());
        require(twins != twinsOf().end(), "clone was not made by cuGraphClone");
        const auto twin = twins->second.find(reinterpret_cast<GraphNode*>(original));
        require(twin != twins->second.end() && graph->owns(twin->second),
                "no such node in the clone");
        *node = handleOf(twin->second);
    });
}

SUNSTONE_EXPORT CUresult cuGraphDestroyNode(CUgraphNode node) {
    return guardedGraph("cuGraphDestroyNode", [&] {
        const NodeInGraph found = nodeOf(node);
        found.graph->remove(found.node);
    });
}

SUNSTONE_EXPORT CUresult cuGraphAddKernelNode(CUgraphNode* node, CUgraph graph,
                                              const CUgraphNode* dependencies, size_t count,
                                              const CUDA_KERNEL_NODE_PARAMS* params) {
    return addNode("cuGraphAddKernelNode", node, graph, dependencies, count,
                   [&] { return nodeFor(params); });
}
SUNSTONE_EXPORT CUresult cuGraphAddMemcpyNode(CUgraphNode* node, CUgraph graph,
                                              const CUgraphNode* dependencies, size_t count,
                                              const CUDA_MEMCPY3D* params, CUcontext context) {
    return addNode("cuGraphAddMemcpyNode", node, graph, dependencies, count, [&] {
        const ContextScope scope(requireContext(context));
        return nodeFor(params);
    });
}
SUNSTONE_EXPORT CUresult cuGraphAddMemsetNode(CUgraphNode* node, CUgraph graph,
                                              const CUgraphNode* dependencies, size_t count,
                                              const CUDA_MEMSET_NODE_PARAMS* params,
                                              CUcontext context) {
    return addNode("cuGraphAddMemsetNode", node, graph, dependencies, count, [&] {
        const ContextScope scope(requireContext(context));
        return nodeFor(params);
    });
}
SUNSTONE_EXPORT CUresult cuGraphAddHostNode(CUgraphNode* node, CUgraph graph,
                                            const CUgraphNode* dependencies, size_t count,
                                            const CUDA_HOST_NODE_PARAMS* params) {
    return addNode("cuGraphAddHostNode", node, graph, dependencies, count,
                   [&] { return nodeFor(params); });
}
SUNSTONE_EXPORT CUresult cuGraphAddChildGraphNode(CUgraphNode* node, CUgraph graph,
                                                  const CUgraphNode* dependencies, size_t count,
                                                  CUgraph child) {
    return addNode("cuGraphAddChildGraphNode", node, graph, dependencies, count, [&] {
        GraphNode made;
        made.kind = WorkKind::kGraph;
        made.child = graphOf(child)->clone(nullptr);
        return made;
    });
}
SUNSTONE_EXPORT CUresult cuGraphAddEmptyNode(CUgraphNode* node, CUgraph graph,
                                             const CUgraphNode* dependencies, size_t count) {
    return addNode("cuGraphAddEmptyNode", node, graph, dependencies, count,
                   [] { return GraphNode{}; });
}
SUNSTONE_EXPORT CUresult cuGraphAddEventRecordNode(CUgraphNode* node, CUgraph graph,
                                                   const CUgraphNode* dependencies, size_t count,
                                                   CUevent event) {
    return addNode("cuGraphAddEventRecordNode", node, graph, dependencies, count,
                   [&] { return eventNode(WorkKind::kRecordEvent, event); });
}
SUNSTONE_EXPORT CUresult cuGraphAddEventWaitNode(CUgraphNode* node, CUgraph graph,
                                                 const CUgraphNode* dependencies, size_t count,
                                                 CUevent event) {
    return addNode("cuGraphAddEventWaitNode", node, graph, dependencies, count,
                   [&] { return eventNode(WorkKind::kWaitEvent, event); });
}

SUNSTONE_EXPORT CUresult cuGraphKernelNodeGetParams(CUgraphNode node,
                                                    CUDA_KERNEL_NODE_PARAMS* params) {
    return guardedGraph("cuGraphKernelNodeGetParams", [&] {
        require(params, "params is null");
        const auto* details =
            static_cast<const KernelDetails*>(nodeOf(node, WorkKind::kKernel).node->details.get());
        require(details, "the node was captured from work that is no kernel of a module");
        const LaunchRequest& r = details->request;
        *params = {r.function, r.grid[0],     r.grid[1], r.grid[2], r.block[0], r.block[1],
                   r.block[2], r.sharedBytes, r.params,  nullptr,   nullptr,    nullptr};
    });
}
SUNSTONE_EXPORT CUresult cuGraphKernelNodeSetParams(CUgraphNode node,
                                                    const CUDA_KERNEL_NODE_PARAMS* params) {
    return guardedGraph("cuGraphKernelNodeSetParams", [&] {
        GraphNode* target = nodeOf(node, WorkKind::kKernel).node;
        GraphNode made = nodeFor(params, isCooperative(*target));
        target->work = std::move(made.work);
        target->details = std::move(made.details);
    });
}
SUNSTONE_EXPORT CUresult cuGraphMemcpyNodeGetParams(CUgraphNode node, CUDA_MEMCPY3D* params) {
    return getParams("cuGraphMemcpyNodeGetParams", node, WorkKind::kCopy, params);
}
SUNSTONE_EXPORT CUresult cuGraphMemcpyNodeSetParams(CUgraphNode node, const CUDA_MEMCPY3D* params) {
    return setParams("cuGraphMemcpyNodeSetParams", node, WorkKind::kCopy, params);
}
SUNSTONE_EXPORT CUresult cuGraphMemsetNodeGetParams(CUgraphNode node,
                                                    CUDA_MEMSET_NODE_PARAMS* params) {
    return getParams("cuGraphMemsetNodeGetParams", node, WorkKind::kSet, params);
}
SUNSTONE_EXPORT CUresult cuGraphMemsetNodeSetParams(CUgraphNode node,
                                                    const CUDA_MEMSET_NODE_PARAMS* params) {
    return setParams("cuGraphMemsetNodeSetParams", node, WorkKind::kSet, params);
}
SUNSTONE_EXPORT CUresult cuGraphHostNodeGetParams(CUgraphNode node, CUDA_HOST_NODE_PARAMS* params) {
    return getParams("cuGraphHostNodeGetParams", node, WorkKind::kHost, params);
}
SUNSTONE_EXPORT CUresult cuGraphHostNodeSetParams(CUgraphNode node,
                                                  const CUDA_HOST_NODE_PARAMS* params) {
    return setParams("cuGraphHostNodeSetParams", node, WorkKind::kHost, params);
}
SUNSTONE_EXPORT CUresult cuGraphChildGraphNodeGetGraph(CUgraphNode node, CUgraph* graph) {
    return guardedGraph("cuGraphChildGraphNodeGetGraph", [&] {
        require(graph, "graph is null");
        const GraphNode* found = nodeOf(node, WorkKind::kGraph).node;
        require(found->child != nullptr, "the node was captured from a launch of a graph");
        *graph = handleOf(found->child);
    });
}

SUNSTONE_EXPORT CUresult cuGraphEventRecordNodeGetEvent(CUgraphNode node, CUevent* event) {
    return guardedGraph("cuGraphEventRecordNodeGetEvent", [&] {
        require(event, "event is null");
        *event = static_cast<CUevent>(nodeOf(node, WorkKind::kRecordEvent).node->event->handle());
    });
}
SUNSTONE_EXPORT CUresult cuGraphEventWaitNodeGetEvent(CUgraphNode node, CUevent* event) {
    return guardedGraph("cuGraphEventWaitNodeGetEvent", [&] {
        require(event, "event is null");
        *event = static_cast<CUevent>(nodeOf(node, WorkKind::kWaitEvent).node->event->handle());
    });
}

SUNSTONE_EXPORT CUresult cuGraphNodeGetType(CUgraphNode node, CUgraphNodeType* type) {
    return guardedGraph("cuGraphNodeGetType", [&] {
        require(type, "type is null");
        *type = CUgraphNodeType(nodeOf(node).node->kind);
    });
}

SUNSTONE_EXPORT CUresult cuGraphGetNodes(CUgraph graph, CUgraphNode* nodes, size_t* count) {
    return guardedGraph("cuGraphGetNodes", [&] {
        std::vector<CUgraphNode> all;
        for (const auto& node : graphOf(graph)->nodes())
            all.push_back(handleOf(node.get()));
        giveNodes(all, nodes, nullptr, count);
    });
}
SUNSTONE_EXPORT CUresult cuGraphGetRootNodes(CUgraph graph, CUgraphNode* nodes, size_t* count) {
    return guardedGraph("cuGraphGetRootNodes", [&] {
        std::vector<CUgraphNode> roots;
        for (const auto& node : graphOf(graph)->nodes())
            if (node->after.empty())
                roots.push_back(handleOf(node.get()));
        giveNodes(roots, nodes, nullptr, count);
    });
}

namespace {

CUresult getEdges(CUgraph graph, CUgraphNode* from, CUgraphNode* to, CUgraphEdgeData* edges,
                  size_t* count) {
    return guardedGraph("cuGraphGetEdges", [&] {
        require(count && (from != nullptr) == (to != nullptr), "only one of from and to is null");
        std::vector<CUgraphNode> begins, ends;
        for (const auto& node : graphOf(graph)->nodes())
            for (const GraphNode* before : node->after) {
                begins.push_back(handleOf(before));
                ends.push_back(handleOf(node.get()));
            }
        give(begins, from, *count);
        giveNodes(ends, to, edges, count);
    });
}
CUresult getDependencies(CUgraphNode node, CUgraphNode* dependencies, CUgraphEdgeData* edges,
                         size_t* count) {
    return guardedGraph("cuGraphNodeGetDependencies", [&] {
        std::vector<CUgraphNode> before;
        for (const GraphNode* other : nodeOf(node).node->after)
            before.push_back(handleOf(other));
        giveNodes(before, dependencies, edges, count);
    });
}
CUresult getDependents(CUgraphNode node, CUgraphNode* dependents, CUgraphEdgeData* edges,
                       size_t* count) {
    return guardedGraph("cuGraphNodeGetDependentNodes", [&] {
        const NodeInGraph found = nodeOf(node);
        std::vector<CUgraphNode> later;
        for (const auto& other : found.graph->nodes())
            if (std::find(other->after.begin(), other->after.end(), found.node) !=
                other->after.end())
                later.push_back(handleOf(other.get()));
        giveNodes(later, dependents, edges, count);
    });
}
CUresult addEdges(CUgraph graph, const CUgraphNode* from, const CUgraphNode* to,
                  const CUgraphEdgeData* edges, size_t count) {
    return guardedGraph("cuGraphAddDependencies", [&] {
        std::shared_ptr<cpu::Graph> owner = graphOf(graph);
        const std::vector<GraphNode*> begins = nodesOf(*owner, from, count);
        const std::vector<GraphNode*> ends = nodesOf(*owner, to, count);
        requirePlainEdges(edges, count);
        for (size_t i = 0; i < count; ++i)
            require(std::find(ends[i]->after.begin(), ends[i]->after.end(), begins[i]) ==
                        ends[i]->after.end(),
                    "an edge exists already");
        for (size_t i = 0; i < count; ++i)
            require(!reaches(begins[i], ends[i]), "an edge would close a cycle");
        for (size_t i = 0; i < count; ++i)
            ends[i]->after.push_back(begins[i]);
    });
}
CUresult removeEdges(CUgraph graph, const CUgraphNode* from, const CUgraphNode* to,
                     const CUgraphEdgeData* edges, size_t count) {
    return guardedGraph("cuGraphRemoveDependencies", [&] {
        std::shared_ptr<cpu::Graph> owner = graphOf(graph);
        const std::vector<GraphNode*> begins = nodesOf(*owner, from, count);
        const std::vector<GraphNode*> ends = nodesOf(*owner, to, count);
        requirePlainEdges(edges, count);
        for (size_t i = 0; i < count; ++i)
            require(std::find(ends[i]->after.begin(), ends[i]->after.end(), begins[i]) !=
                        ends[i]->after.end(),
                    "there is no such edge");
        for (size_t i = 0; i < count; ++i)
            std::erase(ends[i]->after, begins[i]);
    });
}

} // namespace

// The forms with edge data, and the older ones without.
SUNSTONE_EXPORT CUresult cuGraphGetEdges(CUgraph graph, CUgraphNode* from, CUgraphNode* to,
                                         CUgraphEdgeData* edges, size_t* count) {
    return getEdges(graph, from, to, edges, count);
}
SUNSTONE_EXPORT CUresult cuGraphNodeGetDependencies(CUgraphNode node, CUgraphNode* dependencies,
                                                    CUgraphEdgeData* edges, size_t* count) {
    return getDependencies(node, dependencies, edges, count);
}
SUNSTONE_EXPORT CUresult cuGraphNodeGetDependentNodes(CUgraphNode node, CUgraphNode* dependents,
                                                      CUgraphEdgeData* edges, size_t* count) {
    return getDependents(node, dependents, edges, count);
}
SUNSTONE_EXPORT CUresult cuGraphAddDependencies(CUgraph graph, const CUgraphNode* from,
                                                const CUgraphNode* to, const CUgraphEdgeData* edges,
                                                size_t count) {
    return addEdges(graph, from, to, edges, count);
}
SUNSTONE_EXPORT CUresult cuGraphRemoveDependencies(CUgraph graph, const CUgraphNode* from,
                                                   const CUgraphNode* to,
                                                   const CUgraphEdgeData* edges, size_t count) {
    return removeEdges(graph, from, to, edges, count);
}
#undef cuGraphGetEdges
#undef cuGraphNodeGetDependencies
#undef cuGraphNodeGetDependentNodes
#undef cuGraphAddDependencies
#undef cuGraphRemoveDependencies
SUNSTONE_EXPORT CUresult cuGraphGetEdges(CUgraph graph, CUgraphNode* from, CUgraphNode* to,
                                         size_t* count) {
    return getEdges(graph, from, to, nullptr, count);
}
SUNSTONE_EXPORT CUresult cuGraphNodeGetDependencies(CUgraphNode node, CUgraphNode* dependencies,
                                                    size_t* count) {
    return getDependencies(node, dependencies, nullptr, count);
}
SUNSTONE_EXPORT CUresult cuGraphNodeGetDependentNodes(CUgraphNode node, CUgraphNode* dependents,
                                                      size_t* count) {
    return getDependents(node, dependents, nullptr, count);
}
SUNSTONE_EXPORT CUresult cuGraphAddDependencies(CUgraph graph, const CUgraphNode* from,
                                                const CUgraphNode* to, size_t count) {
    return addEdges(graph, from, to, nullptr, count);
}
SUNSTONE_EXPORT CUresult cuGraphRemoveDependencies(CUgraph graph, const CUgraphNode* from,
                                                   const CUgraphNode* to, size_t count) {
    return removeEdges(graph, from, to, nullptr, count);
}
