// SPDX-License-Identifier: Apache-2.0
// LLVM's code generator for CUDA GPUs: target machine, optimisation, PTX text.
#pragma once

#include "compiler/gpu/pipeline.h"

#include <llvm/IR/Module.h>
#include <llvm/Target/TargetMachine.h>

namespace sunstone::compiler {

std::unique_ptr<llvm::TargetMachine> createGpuMachine(const GpuTarget& target);

// LLVM's O1 or O3.
enum class GpuEffort { kLittle, kMuch };

// Optimises the whole module, in which only the kernel is visible.
void optimizeForGpu(llvm::Module& module, llvm::TargetMachine& machine, GpuEffort effort);
// Optimises a function again after a change.
void simplifyForGpu(llvm::Function& function, llvm::TargetMachine& machine, GpuEffort effort);

std::string emitGpuText(llvm::Module& module, llvm::TargetMachine& machine);

} // namespace sunstone::compiler
