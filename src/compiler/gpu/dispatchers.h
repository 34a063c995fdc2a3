// SPDX-License-Identifier: Apache-2.0
// The functions by which the run-time of a GPU pipeline calls programs: switches over the group
// number. LLVM may inline the programs, except those that are too long
// (GpuPipelineRequest::mostInlined).
#pragma once

#include "compiler/gpu/programs.h"
#include "compiler/gpu/resumable.h"

namespace sunstone::compiler {

// Declares the dispatchers of a part of a pipeline (GpuPart).
void declareDispatchers(llvm::Module& module, GpuPart part);
// Whether a kernel that is compiled without programs calls a function of this name.
bool isDispatcher(llvm::StringRef name);

// Defines the dispatchers that the linked run-time declares (GpuCode, pipeline.h).
void defineDispatchers(llvm::Module& module, const GpuPipelineRequest& request,
                       const std::vector<llvm::Function*>& programs, const CutPrograms& cuts);

// For debug exceptions: facts of callables, by 2 * group + continuation, and of built-in
// intersections.
void defineGroupFacts(llvm::Module& module, const std::vector<GpuGroup>& groups);

} // namespace sunstone::compiler
