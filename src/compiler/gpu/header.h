// SPDX-License-Identifier: Apache-2.0
// The first lines of a PTX text, .version and .target. LLVM writes the values that its own code
// needs; instructions that pass through LLVM as text may need the version and target of their
// module.
#pragma once

#include "compiler/gpu/pipeline.h"
#include "ptx/ast.h"

#include <string>

namespace sunstone::compiler {

struct GpuHeader {
    unsigned version = 0; // 10 * major + minor
    std::string target;   // sm_90, sm_90a, sm_100f
    bool operator==(const GpuHeader&) const = default;
};

// The header that LLVM writes for this GPU and its driver.
GpuHeader plainHeader(const GpuTarget& target);

// Whether a GPU of this compute capability runs a module's target: sm_90a is 9.0 only, sm_100f is
// 10.0 up to 10.9. Targets without a letter require features, which the driver checks.
bool runsTarget(std::string_view target, unsigned computeCapability);

// Raises version and target for the instructions of a module: up to the driver's newest version,
// and to the module's target if this GPU runs it.
void widen(GpuHeader& header, const ptx::Module& module, const GpuTarget& target);

// Returns the text with this header in place of its own.
std::string withHeader(std::string text, const GpuHeader& header);

// Whether an instruction that passes through LLVM as text may need more than the plain header. True
// if unknown, which costs only a header like that of the module.
bool mayNeedHeader(const ptx::Instruction& instruction);

} // namespace sunstone::compiler
