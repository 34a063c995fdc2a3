// SPDX-License-Identifier: Apache-2.0
// Splits a PTX module into parts that the driver's compiler compiles at the same time. Compile time
// grows faster than the number of functions of a module, so the parts of a large module also take
// less time in total (docs/notes/compile-time.md has figures).
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

// The texts of the parts. The first has the kernel and its callees by name; the others have the
// functions whose address it takes, with their callees. Empty if
//   - the gain is too small for a link;
//   - parts would share memory of a block;
//   - variables hold addresses of functions;
//   - functions called by address call others by address or the driver's.
std::vector<std::string> splitPtx(std::string_view ptx);

// Machine code of the parts, linked by the driver. The calling thread has a current context. Empty
// under the conditions of compilePtx(), or if the driver does not link.
std::optional<MachineCode> compileParts(const Driver& driver, const std::vector<std::string>& parts,
                                        unsigned computeCapability, unsigned maxRegisters);

// Machine code or a text of a part of a program.
struct LinkPart {
    CUjitInputType type;
    const std::string& bytes;
};
// The program of the parts. The calling thread has a current context. Empty if the driver refuses.
std::optional<std::string> linkParts(const Driver& driver, const std::vector<LinkPart>& parts);

} // namespace sunstone::device::cuda
