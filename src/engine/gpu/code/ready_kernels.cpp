// SPDX-License-Identifier: Apache-2.0
// The kernels of ready_code.h, and which of them serves a pipeline.
#include "base/log.h"
#include "bvh/gpu/layout.h"
#include "compiler/flavor.h"
#include "devlib/gpu/launch_block.h"
#include "devlib/gpu_runtime.h"
#include "engine/gpu/code/machine_code.h"
#include "engine/gpu/code/ready_code.h"

#include <algorithm>

namespace sunstone::engine {

namespace {

// Depths of traces. Up to compiler::kReadyDepth kernels keep the states of all rays of a lane in
// local memory.
constexpr unsigned kFew = 2, kDeep = 31;
static_assert(kDeep > compiler::kReadyDepth);
// Pipelines with more programs take as long in parts as a whole (docs/notes/compile-time.md).
constexpr size_t kMostPrograms = 48;

struct Kind {
    bool isClassic;
    devlib::GraphKind graph;
    bool hasShapes, moves; // custom primitives, curves and spheres; motion
    unsigned depth;
};

// A kernel for all programs of its kind.
compiler::GpuPipelineRequest requestOf(const Kind& kind, const compiler::GpuTarget& target) {
    constexpr uint32_t kAllTypes = ~0u;
    const bool hasCurves = kind.hasShapes && !kind.isClassic;
    const uint32_t shapes =
        hasCurves ? bvh::gpu::shapeBitsOf(kAllTypes) | devlib::kGpuFactOfLaunch : 0;
    compiler::GpuPipelineRequest kernel;
    kernel.part = compiler::GpuPart::kKernel;
    kernel.pipeline.flavor = kind.isClassic ? &compiler::optix6Flavor() : &compiler::optix7Flavor();
    kernel.runtime = kind.isClassic ? devlib::gpuClassicRuntime() : devlib::gpuRuntime();
    kernel.target = target;
    kernel.maxTraceDepth = kind.depth;
    kernel.constants = {
        {"sunstone_gpu_hasAnyHit", devlib::kGpuFactOfLaunch},
        {"sunstone_gpu_hasIntersection", kind.hasShapes},
        {"sunstone_gpu_micromaps", kind.isClassic ? 0 : devlib::kGpuFactOfLaunch},
        {"sunstone_gpu_shapes", shapes},
        {"sunstone_gpu_hasBounds", kind.isClassic},
        {"sunstone_gpu_hasVisits", 0},
        {"sunstone_gpu_hasException", 1},
        {"sunstone_gpu_exceptionFlags", devlib::kGpuFactOfLaunch},
        {kMotionConstant, kind.moves ? devlib::kMotionAll : devlib::kMotionNone},
        {kGraphConstant, kind.graph},
    };
    return kernel;
}

} // namespace

std::vector<compiler::GpuPipelineRequest> readyKernels(const compiler::GpuTarget& target) {
    using namespace devlib;
    std::vector<compiler::GpuPipelineRequest> kernels;
    const auto add = [&](const Kind& kind) { kernels.push_back(requestOf(kind, target)); };
    for (const auto graph : {kGraphGas, kGraphShallow, kGraphAny}) {
        for (const unsigned depth : {kFew, compiler::kReadyDepth}) {
            add({false, graph, false, false, depth});
            add({false, graph, true, false, depth});
            add({false, graph, true, true, depth});
        }
        add({false, graph, true, false, kDeep});
    }
    for (const unsigned depth : {compiler::kReadyDepth, kDeep}) {
        add({true, kGraphShallow, true, false, depth});
        add({true, kGraphAny, true, false, depth});
    }
    add({true, kGraphAny, true, true, compiler::kReadyDepth});
    return kernels;
}

std::string readyKernelId(const compiler::GpuPipelineRequest& kernel) {
    return message("ready, ", kernel.pipeline.flavor->name(), ", graph ",
                   constantOf(kernel, kGraphConstant), ", shapes ",
                   constantOf(kernel, "sunstone_gpu_hasIntersection"), ", motion ",
                   constantOf(kernel, kMotionConstant), ", depth ", kernel.maxTraceDepth);
}

unsigned readyKernelRegisters(const compiler::GpuPipelineRequest& kernel) {
    return registersOf(kernel, true);
}

std::optional<compiler::GpuPipelineRequest>
readyKernelFor(const compiler::GpuPipelineRequest& request) {
    const compiler::Flavor* const flavor = request.pipeline.flavor;
    const bool isClassic = flavor == &compiler::optix6Flavor();
    constexpr uint32_t kServed = devlib::kFlagTraceDepth | devlib::kFlagUser;
    if ((flavor && !isClassic && flavor != &compiler::optix7Flavor()) ||
        (request.pipeline.rules.exceptionFlags & ~kServed) ||
        constantOf(request, "sunstone_gpu_hasVisits") ||
        request.pipeline.programs.size() > kMostPrograms)
        return {};
    const unsigned traces = request.maxTraceDepth;
    if (traces == 0 || traces > kDeep)
        return {};
    const unsigned depth = traces > compiler::kReadyDepth ? kDeep
                           : traces > kFew || isClassic   ? compiler::kReadyDepth
                                                          : kFew;
    const bool moves = constantOf(request, kMotionConstant);
    const bool hasShapes = isClassic || moves || depth == kDeep ||
                           constantOf(request, "sunstone_gpu_hasIntersection") ||
                           constantOf(request, "sunstone_gpu_shapes");
    auto graph = devlib::GraphKind(constantOf(request, kGraphConstant));
    if (graph == devlib::kGraphSingleLevel)
        graph = devlib::kGraphShallow;
    if (isClassic && (moves || graph == devlib::kGraphGas))
        graph = devlib::kGraphAny;
    // Concurrent launches share lane memory, and warps that walk in step must not wait for it.
    if (moves && depth == kDeep)
        return {};
    return requestOf({isClassic, graph, hasShapes, moves, depth}, request.target);
}

} // namespace sunstone::engine
