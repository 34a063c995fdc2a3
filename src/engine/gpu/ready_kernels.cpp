// SPDX-License-Identifier: Apache-2.0
// The kernels of ready_code.h, and which of them serves a pipeline.
#include "base/log.h"
#include "bvh/gpu/layout.h"
#include "compiler/flavor.h"
#include "devlib/gpu/launch_block.h"
#include "engine/gpu/machine_code.h"
#include "engine/gpu/ready_code.h"

#include <algorithm>

namespace sunstone::engine {

namespace {

// Kernels keep the states of all rays of a lane in local memory, for traces of these depths.
constexpr unsigned kDepths[] = {2, 6};
// Pipelines with more programs take as long in parts as a whole (docs/notes/compile-time.md).
constexpr size_t kMostPrograms = 48;

struct Kind {
    std::string_view runtime;
    compiler::GpuTarget target;
    devlib::GraphKind graph;
    bool hasShapes, moves; // custom primitives, curves and spheres; motion
    unsigned depth;
};

// A kernel for all programs of its kind.
compiler::GpuPipelineRequest requestOf(const Kind& kind) {
    constexpr uint32_t kAllTypes = ~0u;
    const uint32_t shapes =
        kind.hasShapes ? bvh::gpu::shapeBitsOf(kAllTypes) | devlib::kGpuFactOfLaunch : 0;
    compiler::GpuPipelineRequest kernel;
    kernel.part = compiler::GpuPart::kKernel;
    kernel.pipeline.rules.motionBlur = kind.moves;
    kernel.runtime = kind.runtime;
    kernel.target = kind.target;
    kernel.maxTraceDepth = kind.depth;
    kernel.constants = {
        {"sunstone_gpu_hasAnyHit", devlib::kGpuFactOfLaunch},
        {"sunstone_gpu_hasIntersection", kind.hasShapes},
        {"sunstone_gpu_micromaps", devlib::kGpuFactOfLaunch},
        {"sunstone_gpu_shapes", shapes},
        {"sunstone_gpu_hasBounds", 0},
        {"sunstone_gpu_hasVisits", 0},
        {"sunstone_gpu_hasException", 1},
        {"sunstone_gpu_exceptionFlags", 0},
        {"sunstone_gpu_motion", kind.moves},
        {kGraphConstant, kind.graph},
    };
    return kernel;
}

} // namespace

std::vector<compiler::GpuPipelineRequest> readyKernels(std::string_view runtime,
                                                       const compiler::GpuTarget& target) {
    std::vector<compiler::GpuPipelineRequest> kernels;
    for (const auto graph : {devlib::kGraphGas, devlib::kGraphShallow, devlib::kGraphAny})
        for (const unsigned depth : kDepths) {
            kernels.push_back(requestOf({runtime, target, graph, false, false, depth}));
            kernels.push_back(requestOf({runtime, target, graph, true, false, depth}));
            kernels.push_back(requestOf({runtime, target, graph, true, true, depth}));
        }
    return kernels;
}

std::string readyKernelId(const compiler::GpuPipelineRequest& kernel) {
    return message("ready, graph ", constantOf(kernel, kGraphConstant), ", shapes ",
                   constantOf(kernel, "sunstone_gpu_hasIntersection"), ", motion ",
                   constantOf(kernel, "sunstone_gpu_motion"), ", depth ", kernel.maxTraceDepth);
}

unsigned readyKernelRegisters(const compiler::GpuPipelineRequest& kernel) {
    return registersOf(kernel, true);
}

std::optional<compiler::GpuPipelineRequest>
readyKernelFor(const compiler::GpuPipelineRequest& request) {
    const auto* const depth =
        std::ranges::find_if(kDepths, [&](unsigned most) { return request.maxTraceDepth <= most; });
    const bool isClassic =
        request.pipeline.flavor && request.pipeline.flavor != &compiler::optix7Flavor();
    if (isClassic || request.maxTraceDepth == 0 || depth == std::end(kDepths) ||
        request.pipeline.rules.exceptionFlags != 0 ||
        request.pipeline.programs.size() > kMostPrograms)
        return {};
    const auto graph = devlib::GraphKind(constantOf(request, kGraphConstant));
    const bool moves = constantOf(request, "sunstone_gpu_motion");
    const bool hasShapes = moves || constantOf(request, "sunstone_gpu_hasIntersection") ||
                           constantOf(request, "sunstone_gpu_shapes");
    return requestOf({request.runtime, request.target,
                      graph == devlib::kGraphSingleLevel ? devlib::kGraphShallow : graph, hasShapes,
                      moves, *depth});
}

} // namespace sunstone::engine
