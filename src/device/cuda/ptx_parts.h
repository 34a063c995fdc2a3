// SPDX-License-Identifier: Apache-2.0
// A PTX module in parts that the driver's compiler takes at the same time. Its time grows faster
// than the number of functions of a module, so that the parts of a module with many of them also
// take less time together (docs/notes/compile-time.md has figures).
#pragma once

#include "device/cuda/driver.h"
#include "device/cuda/ptx_compiler.h"

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace sunstone::device::cuda {

// A kernel, a definition or declaration of a function, or the text between two of these. Kernels
// and functions begin at the start of a line, as LLVM writes them.
struct PtxPiece {
    std::string_view text, name; // of a kernel or function
    bool isKernel = false;
    bool isDefinition() const { return !name.empty() && text.find('{') != text.npos; }
};
// `ptx` must outlive the pieces.
std::vector<PtxPiece> ptxPieces(std::string_view ptx);

// The texts of the parts. The first has the kernel and the functions that it calls by name; the
// others have those whose address it takes, with what they call. Empty where that is not worth the
// link, where parts would share memory of a block, where variables hold addresses of functions, and
// where functions by address call others by address or the driver's.
std::vector<std::string> splitPtx(std::string_view ptx);

// Machine code of the parts, linked by the driver. The calling thread has a current context. Empty
// as compilePtx() says, or if the driver does not link.
std::optional<MachineCode> compileParts(const Driver& driver, const std::vector<std::string>& parts,
                                        unsigned computeCapability, unsigned maxRegisters);

} // namespace sunstone::device::cuda
