// SPDX-License-Identifier: Apache-2.0
// Forms with constant operands: what a compiler computes or chooses for a constant has the result
// of the same value read from memory, and its code can be linked.
#pragma once

#include <cstdint>
#include <string>

namespace conformance {

// Runs `count` forms, chosen by `seed`, whose names contain `only`; each with the values of one
// vector in some of its operands, once as constants and once loaded. Forms of `gaps` may be
// refused. Prints what differs; false if anything does.
bool checkConstants(uint64_t seed, size_t count, const std::string& only);

} // namespace conformance
