// SPDX-License-Identifier: Apache-2.0
// A graph as a text for Graphviz. The text has no fixed form, because users look at the picture.
#include "api/cuda/runtime/graphs.h"

#include <cstdio>
#include <fstream>
#include <locale>
#include <map>
#include <sstream>
#include <string>
#include <vector>

using namespace sunstone::cudart;

namespace {

constexpr const char* kTypes[] = {"kernel", "memcpy", "memset", "host",       "graph",
                                  "empty",  "wait",   "record", "signal",     "wait for signal",
                                  "alloc",  "free",   "batch",  "conditional"};

constexpr unsigned kWithParams =
    cudaGraphDebugDotFlagsVerbose | cudaGraphDebugDotFlagsKernelNodeParams;

cudaError_t describeKernel(const Driver& d, CUgraphNode node, unsigned flags, std::ostream& text) {
    CUDA_KERNEL_NODE_PARAMS p = {};
    const char* name = nullptr;
    if (const cudaError_t error = present(d.cuGraphKernelNodeGetParams, node, &p))
        return error;
    if (d.cuFuncGetName && d.cuFuncGetName(&name, p.func) == CUDA_SUCCESS && name)
        text << "\\n" << name;
    if (flags & kWithParams)
        text << "\\n<<<(" << p.gridDimX << ", " << p.gridDimY << ", " << p.gridDimZ << "), ("
             << p.blockDimX << ", " << p.blockDimY << ", " << p.blockDimZ << "), "
             << p.sharedMemBytes << ">>>";
    return cudaSuccess;
}

// Writes nodes and edges of a graph whose nodes' names begin with `prefix`.
cudaError_t describe(const Driver& d, CUgraph graph, const std::string& prefix, unsigned flags,
                     std::ostream& text) {
    size_t count = 0, edgeCount = 0;
    if (const cudaError_t error = present(d.cuGraphGetNodes, graph, nullptr, &count))
        return error;
    std::vector<CUgraphNode> nodes(count);
    if (count)
        if (const cudaError_t error = present(d.cuGraphGetNodes, graph, nodes.data(), &count))
            return error;
    std::map<CUgraphNode, std::string> names;
    for (const CUgraphNode node : nodes) {
        CUgraphNodeType type{};
        if (const cudaError_t error = present(d.cuGraphNodeGetType, node, &type))
            return error;
        const std::string name = names[node] = prefix + std::to_string(names.size());
        const bool isKnown = size_t(type) < std::size(kTypes);
        text << "    " << name << " [label=\"" << (isKnown ? kTypes[type] : "node");
        if (flags & cudaGraphDebugDotFlagsHandles)
            text << "\\n" << node;
        if (type == CU_GRAPH_NODE_TYPE_KERNEL)
            if (const cudaError_t error = describeKernel(d, node, flags, text))
                return error;
        text << "\"];\n";
        CUgraph child = nullptr;
        if (type == CU_GRAPH_NODE_TYPE_GRAPH &&
            !present(d.cuGraphChildGraphNodeGetGraph, node, &child)) {
            text << "    subgraph cluster_" << name << " {\n";
            if (const cudaError_t error = describe(d, child, name + "_", flags, text))
                return error;
            text << "    }\n";
        }
    }
    if (const cudaError_t error =
            present(d.cuGraphGetEdges, graph, nullptr, nullptr, nullptr, &edgeCount))
        return error;
    std::vector<CUgraphNode> from(edgeCount), to(edgeCount);
    if (edgeCount)
        if (const cudaError_t error =
                present(d.cuGraphGetEdges, graph, from.data(), to.data(), nullptr, &edgeCount))
            return error;
    for (size_t i = 0; i < edgeCount; ++i)
        text << "    " << names[from[i]] << " -> " << names[to[i]] << ";\n";
    return cudaSuccess;
}

} // namespace

SUNSTONE_CUDART cudaError_t cudaGraphDebugDotPrint(cudaGraph_t graph, const char* path,
                                                   unsigned int flags) {
    return call([&](const Driver& d) {
        if (!path)
            return cudaErrorInvalidValue;
        std::ostringstream text;
        text.imbue(std::locale::classic());
        text << "digraph graph_ {\n";
        if (const cudaError_t error = describe(d, graph, "node", flags, text))
            return error;
        text << "}\n";
        std::ofstream file(path);
        return file << text.str() << std::flush ? cudaSuccess : cudaErrorOperatingSystem;
    });
}
