// SPDX-License-Identifier: Apache-2.0
// The PTX compiler that comes with a GPU's driver, opened at run time. Its machine code can be
// stored, and it compiles a text as a whole program.
#pragma once

#include <optional>
#include <string>

namespace sunstone::device::cuda {

struct MachineCode {
    std::string cubin;
    std::string log; // frames, spills and registers of each function
};

// The library's name as the driver installs it, beside libcuda.so.1.
constexpr const char* kPtxCompilerLibrary = "libnvidia-ptxjitcompiler.so.1";

// Whether the library is present. The first call opens it.
bool hasPtxCompiler();

// A whole program, or a part that the driver links with others. ptxas implements rare operands of
// divisions with a call; in parts the called function is elsewhere.
enum class PtxUse { kProgram, kPart };

// Machine code of a text for GPUs of a compute capability (90 is 9.0), with at most maxRegisters
// registers a thread; 0: no limit. Any thread may call. Empty if the driver lacks the library or
// the functions of the PTX Compiler API, or if the compiler refuses the text; cuModuleLoadDataEx
// then reports the fault. Source: PTX Compiler API reference, 12.0.
std::optional<MachineCode> compilePtx(const std::string& ptx, unsigned computeCapability,
                                      unsigned maxRegisters, PtxUse use = PtxUse::kProgram);

} // namespace sunstone::device::cuda
