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

namespace {

// The registers of a kernel that spills much, where more registers are better than more warps.
struct Remedy {
    unsigned spills; // more bytes than these
    unsigned registers;
};

// Measured on an H100 (docs/notes/programs-gpu.md, docs/notes/recursion-gpu.md):
//
//   programs                            registers   bytes spilled   time
//   recurse                                   128   up to 260       longer
//   recurse                                   128   440 to 660      5 to 27 % shorter
//   intersect, a thread for each index         96   up to 312       5 to 11 % longer
//   intersect, a thread for each index         96   376 and 652     10 and 30 % shorter
//   others                                    128   up to 580       longer
//   others                                    128   820             5 % shorter
constexpr unsigned kUsualSpills = 700;
Remedy remedyOf(const compiler::GpuCode& code, const compiler::GpuPipelineRequest& request) {
    if (code.recurses)
        return {400, kMostRegisters};
    if (!code.takesTurns && constantOf(request, "sunstone_gpu_hasIntersection"))
        return {350, 96};
    return {kUsualSpills, kMostRegisters};
}

} // namespace

unsigned betterRegisters(std::string_view log, const compiler::GpuCode& code,
                         const compiler::GpuPipelineRequest& request, unsigned registers) {
    const Remedy remedy = remedyOf(code, request);
    return registers < remedy.registers && compiler::gpuSpillsIn(log) > remedy.spills
               ? remedy.registers
               : 0;
}

// The kernel's machine code with few registers, or with many if it spills much otherwise. If the
// second is often needed and there are enough processors, both are compiled at once: each takes the
// same time.
std::optional<MachineCode> machineCodeOf(const compiler::GpuCode& code,
                                         const compiler::GpuPipelineRequest& request,
                                         unsigned registers, CUcontext context) {
    constexpr unsigned kThreads = 4;
    std::optional<MachineCode> made[2];
    const Remedy remedy = remedyOf(code, request);
    const unsigned most[2] = {registers, remedy.registers};
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
    const bool oftenSpills = remedy.spills < kUsualSpills || (shapes & bvh::gpu::kMeetsCurves);
    if (oftenSpills && registers < remedy.registers && cpuLimit().threads >= kThreads &&
        hasPtxCompiler())
        parallelFor(2, 1, [&](size_t begin, size_t end) {
            for (size_t i = begin; i < end; ++i)
                make(i);
        });
    else
        make(0);
    if (!made[0] || betterRegisters(made[0]->log, code, request, registers) == 0)
        return std::move(made[0]);
    if (!made[1])
        make(1);
    return std::move(made[made[1] ? 1 : 0]);
}

} // namespace sunstone::engine
