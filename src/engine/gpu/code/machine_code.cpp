// SPDX-License-Identifier: Apache-2.0
#include "engine/gpu/code/machine_code.h"

#include "base/threads/cpu_limits.h"
#include "base/threads/threads.h"
#include "bvh/gpu/layout.h"

#include <algorithm>

namespace sunstone::engine {

using namespace device::cuda;

// Registers of a thread. Fewer registers allow more warps but spill more. Measured on an H100
// (docs/notes/instances-gpu.md, docs/notes/programs-gpu.md):
//
//   kernel                                               best   faster than
//   no instances                                           72   96 by up to 12 %
//   one level of instances                                 80   96 by up to 6 %
//   nodes with two motion keys                             96   72 by 9 to 19 %
//   motion transforms                                     128   96 by 5 to 7 %
//   takes turns, deep graphs                              128   96 by 6 %
//   takes turns, custom primitives, curves or spheres      80   72 by 6 %
unsigned registersOf(const compiler::GpuPipelineRequest& request, bool takesTurns) {
    constexpr unsigned kStill[] = {72, 80, 80, 80}, kTurns[] = {72, 80, 128, 80},
                       kMoving[] = {96, 128, 128, 128}; // by GraphKind
    const unsigned most = (constantOf(request, kMotionConstant) ? kMoving
                           : takesTurns                         ? kTurns
                                        : kStill)[constantOf(request, kGraphConstant)];
    const bool onlyTriangles = !constantOf(request, "sunstone_gpu_hasIntersection") &&
                               !constantOf(request, "sunstone_gpu_shapes");
    return takesTurns && !onlyTriangles ? std::max(most, 80u) : most;
}

// Whether a kernel spills so much that more registers are better than more warps. Measured with 128
// registers on an H100 (docs/notes/programs-gpu.md, docs/notes/recursion-gpu.md):
//
//   programs   bytes spilled   time
//   recurse    up to 260       longer
//   recurse    440 to 660      5 to 27 % shorter
//   others     up to 580       longer
//   others     820             5 % shorter
bool spills(std::string_view log, bool recurses) {
    return compiler::gpuSpillsIn(log) > (recurses ? 400 : 700);
}

// The kernel's machine code with few registers, or with many if it spills much otherwise. If the
// second is often needed and there are enough processors, both are compiled at once: each takes the
// same time.
std::optional<MachineCode> machineCodeOf(const compiler::GpuCode& code,
                                         const compiler::GpuPipelineRequest& request,
                                         unsigned registers, CUcontext context) {
    constexpr unsigned kThreads = 4;
    std::optional<MachineCode> made[2];
    const unsigned most[2] = {registers, kMostRegisters};
    const std::vector<std::string> parts =
        hasPtxCompiler() ? splitPtx(code.ptx) : std::vector<std::string>();
    const auto make = [&](size_t i) {
        const unsigned capability = request.target.computeCapability;
        if (!parts.empty()) {
            ContextScope scope(context);
            made[i] = compileParts(driver(), parts, capability, most[i]);
        }
        if (!made[i])
            made[i] = compilePtx(code.ptx, capability, most[i]);
    };
    const uint32_t shapes = bvh::gpu::shapeBitsOf(request.pipeline.rules.primitiveTypeFlags);
    const bool oftenSpills = code.recurses || (shapes & bvh::gpu::kMeetsCurves);
    if (oftenSpills && registers < kMostRegisters && cpuLimit().threads >= kThreads &&
        hasPtxCompiler())
        parallelFor(2, 1, [&](size_t begin, size_t end) {
            for (size_t i = begin; i < end; ++i)
                make(i);
        });
    else
        make(0);
    if (!made[0] || registers == kMostRegisters || !spills(made[0]->log, code.recurses))
        return std::move(made[0]);
    if (!made[1])
        make(1);
    return std::move(made[made[1] ? 1 : 0]);
}

} // namespace sunstone::engine
