// SPDX-License-Identifier: Apache-2.0
// The first lines of a PTX text, .version and .target. LLVM writes what it knows itself; instructions
// that pass through it as text may need the version and the target that their module declares.
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

// What LLVM writes for this GPU and its driver.
GpuHeader plainHeader(const GpuTarget& target);

// Whether a GPU of this compute capability can be what the module's target demands: sm_90a is 9.0 and
// nothing else, sm_100f is 10.0 and what comes after it up to 10.9. Targets without a letter demand
// features, which is for the driver to judge.
bool runsTarget(std::string_view target, unsigned computeCapability);

// Makes room for the instructions of a module: its version, as far as the driver reads it, and its
// target, as far as this GPU is one.
void widen(GpuHeader& header, const ptx::Module& module, const GpuTarget& target);

// The text with these first lines in place of its own.
std::string withHeader(std::string text, const GpuHeader& header);

// Whether an instruction that passes through LLVM as text may need more than the plain header: true
// where that is not known, which costs no more than a header like that of the module.
bool mayNeedHeader(const ptx::Instruction& instruction);

} // namespace sunstone::compiler
