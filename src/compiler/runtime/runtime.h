// SPDX-License-Identifier: Apache-2.0
// Functions that compiled code calls by name: directed rounding, transcendental functions, half
// conversions, printf, and calls of a kernel's launcher. They are plain C functions and must not
// throw.
#pragma once

#include <cstdint>
#include <vector>

namespace sunstone::compiler {

struct RuntimeSymbol {
    const char* name;
    const void* address;
};

// All functions, for the linker of compiled code.
const std::vector<RuntimeSymbol>& runtimeSymbols();

// The groups that make up runtimeSymbols(), one per source file.
void addRoundingSymbols(std::vector<RuntimeSymbol>& symbols);
void addMathSymbols(std::vector<RuntimeSymbol>& symbols);
void addLibrarySymbols(std::vector<RuntimeSymbol>& symbols);
void addKernelSymbols(std::vector<RuntimeSymbol>& symbols);
void addTextureSymbols(std::vector<RuntimeSymbol>& symbols);
void addCheckSymbols(std::vector<RuntimeSymbol>& symbols);
void addSmallFloatSymbols(std::vector<RuntimeSymbol>& symbols);
void addAsyncSymbols(std::vector<RuntimeSymbol>& symbols);
void addAtomicSymbols(std::vector<RuntimeSymbol>& symbols);
void addMatrixSymbols(std::vector<RuntimeSymbol>& symbols);

// The operation of an atomic on 16-bit numbers.
enum class AtomicOperation : uint32_t { kAdd, kMinimum, kMaximum };

} // namespace sunstone::compiler
