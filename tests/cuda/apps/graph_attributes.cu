// SPDX-License-Identifier: Apache-2.0
// Attributes of kernel nodes of graphs: the attributes, their initial values and the values they
// accept.
#include "driver_cases.h"

namespace {

const char* const kModule = R"(
.version 6.5
.target sm_70
.address_size 64
.visible .entry nothing() { ret; }
)";

std::string bytesOf(const CUkernelNodeAttrValue& value) {
    std::string text;
    const auto* bytes = reinterpret_cast<const unsigned char*>(&value);
    for (int i = 0; i < 4; ++i) {
        char hex[4];
        std::snprintf(hex, sizeof hex, "%02x", bytes[i]);
        text += hex;
    }
    return text;
}

} // namespace

int main() {
    CUcontext context = nullptr;
    MUST(cuInit(0));
    MUST(cuDevicePrimaryCtxRetain(&context, 0));
    MUST(cuCtxSetCurrent(context));
    CUmodule module = nullptr;
    CUDA_KERNEL_NODE_PARAMS kernel = {};
    MUST(cuModuleLoadData(&module, kModule));
    MUST(cuModuleGetFunction(&kernel.func, module, "nothing"));
    kernel.gridDimX = kernel.gridDimY = kernel.gridDimZ = 1;
    kernel.blockDimX = kernel.blockDimY = kernel.blockDimZ = 1;
    CUgraph graph = nullptr;
    CUgraphNode node = nullptr, other = nullptr, empty = nullptr;
    MUST(cuGraphCreate(&graph, 0));
    MUST(cuGraphAddKernelNode(&node, graph, nullptr, 0, &kernel));
    MUST(cuGraphAddKernelNode(&other, graph, nullptr, 0, &kernel));
    MUST(cuGraphAddEmptyNode(&empty, graph, nullptr, 0));
    for (int id = 0; id <= 18; ++id) {
        if (id == 13 || id == 16) // nodes that device code updates, links between devices
            continue;
        const auto attribute = CUkernelNodeAttrID(id);
        CUkernelNodeAttrValue value;
        const auto get = [&] {
            std::memset(&value, 0, sizeof value);
            const CUresult result = cuGraphKernelNodeGetAttribute(node, attribute, &value);
            return result ? nameOf(result) : bytesOf(value);
        };
        std::printf("%d: at first %s", id, get().c_str());
        for (int number : {0, 1, 2, 1000}) {
            std::memset(&value, 0, sizeof value);
            std::memcpy(&value, &number, sizeof number);
            if (id == 4) // cluster dimensions
                value.clusterDim.y = value.clusterDim.z = 1;
            std::printf(", %d %s", number,
                        nameOf(cuGraphKernelNodeSetAttribute(node, attribute, &value)).c_str());
            std::printf(" then %s", get().c_str());
        }
        std::printf("\n");
        std::fflush(stdout);
    }
    CUkernelNodeAttrValue value = {};
    value.priority = -1;
    MUST(cuGraphKernelNodeSetAttribute(node, CU_LAUNCH_ATTRIBUTE_PRIORITY, &value));
    MUST(cuGraphKernelNodeCopyAttributes(other, node));
    MUST(cuGraphKernelNodeGetAttribute(other, CU_LAUNCH_ATTRIBUTE_PRIORITY, &value));
    if (value.priority != -1)
        std::printf("the copy has priority %d\n", value.priority);
    std::printf(
        "empty node %s",
        nameOf(cuGraphKernelNodeGetAttribute(empty, CU_LAUNCH_ATTRIBUTE_PRIORITY, &value)).c_str());
    std::printf(", copy to empty node %s\n",
                nameOf(cuGraphKernelNodeCopyAttributes(empty, node)).c_str());
    // A graph whose only kernel is cooperative runs.
    value.cooperative = 1;
    std::printf("cooperative %s",
                nameOf(cuGraphKernelNodeSetAttribute(node, CU_LAUNCH_ATTRIBUTE_COOPERATIVE, &value))
                    .c_str());
    CUgraphExec exec = nullptr;
    std::printf(", instantiated %s", nameOf(cuGraphInstantiate(&exec, graph, 0)).c_str());
    std::printf(", launched %s", nameOf(cuGraphLaunch(exec, nullptr)).c_str());
    std::printf(", done %s\n", nameOf(cuCtxSynchronize()).c_str());
    return 0;
}
