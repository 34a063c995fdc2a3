// SPDX-License-Identifier: Apache-2.0
// Inputs of the vectors: edge values first, then random values, equal on every machine.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace conformance {

// Operands of one instruction that can have inputs of one type.
constexpr unsigned kOperands = 5;

// Bits that look random.
inline uint64_t scramble(uint64_t x) {
    x += 0x9e3779b97f4a7c15ull;
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ull;
    x = (x ^ (x >> 27)) * 0x94d049bb133111ebull;
    return x ^ (x >> 31);
}

const std::vector<std::string>& inputTypes();
// The number of a type in inputTypes().
unsigned inputNumber(const std::string& type);
// Bits of the input of `type` at operand `position` of vector `index`.
uint64_t inputBits(const std::string& type, unsigned position, unsigned index);
// Where the inputs of `type` at operand `position` start in allInputs(), in bytes.
size_t inputOffset(const std::string& type, unsigned position);
// All of them, as the kernels read them: eight bytes each, by type, position and vector.
std::vector<uint64_t> allInputs();

} // namespace conformance
