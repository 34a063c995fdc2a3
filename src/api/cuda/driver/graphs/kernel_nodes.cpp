// SPDX-License-Identifier: Apache-2.0
// Kernel nodes of graphs: attributes, and the forms with CUfunction parameters only.
#include "api/cuda/driver/graphs/graphs.h"
#include "api/cuda/driver/launch.h"

#include <algorithm>
#include <cstring>

using namespace sunstone;
using namespace sunstone::api::cuda;
using cpu::GraphNode;
using cpu::WorkKind;

namespace {

using AttributeBytes = GraphNode::AttributeBytes;

// The attributes of kernel nodes and their defaults. All except hints have an effect.
struct Attribute {
    int id;
    unsigned char first[16];
};
constexpr Attribute kAttributes[] = {
    {CU_LAUNCH_ATTRIBUTE_ACCESS_POLICY_WINDOW, {}},
    {CU_LAUNCH_ATTRIBUTE_COOPERATIVE, {}},
    {CU_LAUNCH_ATTRIBUTE_CLUSTER_DIMENSION, {}},
    {CU_LAUNCH_ATTRIBUTE_CLUSTER_SCHEDULING_POLICY_PREFERENCE, {}},
    {CU_LAUNCH_ATTRIBUTE_PRIORITY, {}},
    {CU_LAUNCH_ATTRIBUTE_MEM_SYNC_DOMAIN_MAP, {0, 1}}, // of the default and the remote domain
    {CU_LAUNCH_ATTRIBUTE_MEM_SYNC_DOMAIN, {}},
    {CU_LAUNCH_ATTRIBUTE_DEVICE_UPDATABLE_KERNEL_NODE, {}},
    {CU_LAUNCH_ATTRIBUTE_PREFERRED_SHARED_MEMORY_CARVEOUT, {}},
};

const Attribute& attributeOf(CUkernelNodeAttrID id) {
    for (const Attribute& attribute : kAttributes)
        if (attribute.id == int(id))
            return attribute;
    refuse(CUDA_ERROR_INVALID_VALUE, "kernel nodes have no attribute ", int(id));
}

AttributeBytes valueOf(const GraphNode& node, CUkernelNodeAttrID id) {
    const Attribute& attribute = attributeOf(id);
    if (const auto found = node.attributes.find(int(id)); found != node.attributes.end())
        return found->second;
    AttributeBytes bytes{};
    std::copy(std::begin(attribute.first), std::end(attribute.first), bytes.begin());
    return bytes;
}

// Rejects values that are invalid for the attribute, and clamps others.
void check(CUkernelNodeAttrID id, CUlaunchAttributeValue& value) {
    const int number = value.cooperative; // the first four bytes
    switch (int(id)) {
    case CU_LAUNCH_ATTRIBUTE_CLUSTER_DIMENSION:
        if (value.clusterDim.x != 1 || value.clusterDim.y != 1 || value.clusterDim.z != 1)
            refuse(CUDA_ERROR_INVALID_CLUSTER_SIZE, "the device has clusters of 1 block alone");
        break;
    case CU_LAUNCH_ATTRIBUTE_PRIORITY:
        value.priority =
            std::clamp(number, cpu::Streams::kGreatestPriority, cpu::Streams::kLeastPriority);
        break;
    case CU_LAUNCH_ATTRIBUTE_MEM_SYNC_DOMAIN_MAP:
        require((number & 0xFF) < 4 && (number >> 8 & 0xFF) < 4, "there are 4 domains");
        break;
    case CU_LAUNCH_ATTRIBUTE_MEM_SYNC_DOMAIN:
        require(number == 0 || number == 1, "the domain is unknown");
        break;
    case CU_LAUNCH_ATTRIBUTE_DEVICE_UPDATABLE_KERNEL_NODE:
        require(number == 0 || number == 1, "the value must be 0 or 1");
        if (number)
            refuse(CUDA_ERROR_NOT_SUPPORTED, "nodes that device code updates");
        break;
    case CU_LAUNCH_ATTRIBUTE_PREFERRED_SHARED_MEMORY_CARVEOUT:
        require(number >= -1 && number <= 100, "the part must be -1 to 100 per cent");
        break;
    default:
        break;
    }
}

// Replaces the node's work if the attributes change it.
void apply(GraphNode& node) {
    const auto* details = static_cast<const KernelDetails*>(node.details.get());
    const bool cooperative = isCooperative(node);
    if (!details || details->request.cooperative == cooperative)
        return;
    LaunchRequest request = details->request;
    request.cooperative = cooperative;
    PreparedLaunch prepared = prepareLaunch(request);
    node.work = std::move(prepared.work);
    node.details = std::move(prepared.details);
}

// The parameters before CUDA 12: the same up to `extra`.
struct OlderParams {
    CUfunction func;
    unsigned int grid[3], block[3];
    unsigned int sharedMemBytes;
    void** kernelParams;
    void** extra;
};
static_assert(sizeof(OlderParams) == offsetof(CUDA_KERNEL_NODE_PARAMS, kern));

const CUDA_KERNEL_NODE_PARAMS* widen(const OlderParams* params, CUDA_KERNEL_NODE_PARAMS& wide) {
    wide = {};
    if (params)
        std::memcpy(&wide, params, sizeof *params);
    return params ? &wide : nullptr;
}

} // namespace

bool sunstone::api::cuda::isCooperative(const GraphNode& node) {
    const auto found = node.attributes.find(CU_LAUNCH_ATTRIBUTE_COOPERATIVE);
    int value = 0;
    if (found != node.attributes.end())
        std::memcpy(&value, found->second.data(), sizeof value);
    return value != 0;
}

SUNSTONE_EXPORT CUresult cuGraphKernelNodeGetAttribute(CUgraphNode node, CUkernelNodeAttrID id,
                                                       CUkernelNodeAttrValue* value) {
    return guardedGraph("cuGraphKernelNodeGetAttribute", [&] {
        require(value, "value is null");
        const AttributeBytes bytes = valueOf(*nodeOf(node, WorkKind::kKernel).node, id);
        static_assert(sizeof(CUkernelNodeAttrValue) == sizeof(AttributeBytes));
        std::memcpy(value, bytes.data(), bytes.size());
    });
}
SUNSTONE_EXPORT CUresult cuGraphKernelNodeSetAttribute(CUgraphNode node, CUkernelNodeAttrID id,
                                                       const CUkernelNodeAttrValue* value) {
    return guardedGraph("cuGraphKernelNodeSetAttribute", [&] {
        require(value, "value is null");
        GraphNode& target = *nodeOf(node, WorkKind::kKernel).node;
        attributeOf(id);
        CUlaunchAttributeValue checked = *value;
        check(id, checked);
        AttributeBytes bytes{};
        std::memcpy(bytes.data(), &checked, bytes.size());
        GraphNode changed = target;
        changed.attributes[int(id)] = bytes;
        apply(changed);
        target = std::move(changed);
    });
}
SUNSTONE_EXPORT CUresult cuGraphKernelNodeCopyAttributes(CUgraphNode dst, CUgraphNode src) {
    return guardedGraph("cuGraphKernelNodeCopyAttributes", [&] {
        GraphNode& target = *nodeOf(dst, WorkKind::kKernel).node;
        GraphNode changed = target;
        changed.attributes = nodeOf(src, WorkKind::kKernel).node->attributes;
        apply(changed);
        target = std::move(changed);
    });
}

#undef cuGraphAddKernelNode
#undef cuGraphKernelNodeGetParams
#undef cuGraphKernelNodeSetParams
#undef cuGraphExecKernelNodeSetParams
SUNSTONE_EXPORT CUresult cuGraphAddKernelNode(CUgraphNode* node, CUgraph graph,
                                              const CUgraphNode* dependencies, size_t count,
                                              const OlderParams* params) {
    CUDA_KERNEL_NODE_PARAMS wide;
    return cuGraphAddKernelNode_v2(node, graph, dependencies, count, widen(params, wide));
}
SUNSTONE_EXPORT CUresult cuGraphKernelNodeGetParams(CUgraphNode node, OlderParams* params) {
    CUDA_KERNEL_NODE_PARAMS wide = {};
    const CUresult result = cuGraphKernelNodeGetParams_v2(node, params ? &wide : nullptr);
    if (result == CUDA_SUCCESS)
        std::memcpy(params, &wide, sizeof *params);
    return result;
}
SUNSTONE_EXPORT CUresult cuGraphKernelNodeSetParams(CUgraphNode node, const OlderParams* params) {
    CUDA_KERNEL_NODE_PARAMS wide;
    return cuGraphKernelNodeSetParams_v2(node, widen(params, wide));
}
SUNSTONE_EXPORT CUresult cuGraphExecKernelNodeSetParams(CUgraphExec exec, CUgraphNode node,
                                                        const OlderParams* params) {
    CUDA_KERNEL_NODE_PARAMS wide;
    return cuGraphExecKernelNodeSetParams_v2(exec, node, widen(params, wide));
}
