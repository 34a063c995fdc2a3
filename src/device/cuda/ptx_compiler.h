// SPDX-License-Identifier: Apache-2.0
// The compiler of PTX that comes with a GPU's driver, opened at run time. It gives machine code that
// can be kept, and compiles a text as a whole: the driver's linker (cuLink*) gives some, too, but
// takes each text for a part of more, which costs registers at every division.
#pragma once

#include <optional>
#include <string>

namespace sunstone::device::cuda {

struct MachineCode {
    std::string cubin;
    std::string log; // what the compiler tells of frames, spills and registers of each function
};

// The name under which the driver installs it, beside libcuda.so.1.
constexpr const char* kPtxCompilerLibrary = "libnvidia-ptxjitcompiler.so.1";

// Whether there is one. A first call opens it.
bool hasPtxCompiler();

// Machine code of a text for GPUs of a compute capability (90 is 9.0), with so many registers a
// thread; 0: as many as it takes. Any thread may call. Nothing where the driver has no such
// library, where it lacks the functions of the PTX Compiler API, or where it refuses the text: then
// it is for cuModuleLoadDataEx to say what is wrong. (PTX Compiler API reference, 12.0)
std::optional<MachineCode> compilePtx(const std::string& ptx, unsigned computeCapability,
                                      unsigned maxRegisters);

} // namespace sunstone::device::cuda
