// SPDX-License-Identifier: Apache-2.0
// Functions that compiled code calls by name: directed rounding, transcendental functions, half
// conversions, printf, and the way from a kernel to its launcher. They are plain C functions; no
// exception may leave them.
#pragma once

#include <cstdint>
#include <vector>

namespace sunstone::compiler {

struct RuntimeSymbol {
    const char* name;
    const void* address;
};

// Every function, for the linker of compiled code.
const std::vector<RuntimeSymbol>& runtimeSymbols();

// The groups runtimeSymbols() is made of, one per source file.
void addRoundingSymbols(std::vector<RuntimeSymbol>& symbols);
void addMathSymbols(std::vector<RuntimeSymbol>& symbols);
void addKernelSymbols(std::vector<RuntimeSymbol>& symbols);
void addTextureSymbols(std::vector<RuntimeSymbol>& symbols);
void addCheckSymbols(std::vector<RuntimeSymbol>& symbols);
void addSmallFloatSymbols(std::vector<RuntimeSymbol>& symbols);
void addAsyncSymbols(std::vector<RuntimeSymbol>& symbols);
void addAtomicSymbols(std::vector<RuntimeSymbol>& symbols);
void addMatrixSymbols(std::vector<RuntimeSymbol>& symbols);

// What atomics on numbers of 16 bits do.
enum class AtomicOperation : uint32_t { kAdd, kMinimum, kMaximum };

} // namespace sunstone::compiler
