// SPDX-License-Identifier: Apache-2.0
// Machine code of a pipeline's text, by the compiler that comes with the GPU's driver: how many
// registers a thread gets, and whether the text compiles in parts.
#pragma once

#include "compiler/gpu/pipeline.h"
#include "device/cuda/ptx_parts.h"

#include <optional>
#include <string_view>

namespace sunstone::engine {

using compiler::kGraphConstant;
using compiler::kMotionConstant;

constexpr unsigned kMostRegisters = 128;
// Registers of a thread that suit most kernels of this kind.
unsigned registersOf(const compiler::GpuPipelineRequest& request, bool takesTurns);
// A larger number of registers with which the kernel is faster, because it spills much with
// `registers`; 0: none. `log`: the compiler's.
unsigned betterRegisters(std::string_view log, const compiler::GpuCode& code,
                         const compiler::GpuPipelineRequest& request, unsigned registers);

// Machine code with `registers`, or with betterRegisters(). Empty as compilePtx() says.
std::optional<device::cuda::MachineCode> machineCodeOf(const compiler::GpuCode& code,
                                                       const compiler::GpuPipelineRequest& request,
                                                       unsigned registers, CUcontext context);

} // namespace sunstone::engine
