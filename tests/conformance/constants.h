// SPDX-License-Identifier: Apache-2.0
// Forms with constant operands: an instruction with a constant must have the result of the same
// value read from memory, and its code must link.
#pragma once

#include <cstdint>
#include <string>

namespace conformance {

// Runs `count` forms, chosen by `seed`, whose names contain `only`; each with the values of one
// vector in some of its operands, once as constants and once loaded. Forms of `gaps` may be
// refused. Prints differences; false if there are any.
bool checkConstants(uint64_t seed, size_t count, const std::string& only);

} // namespace conformance
