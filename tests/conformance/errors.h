// SPDX-License-Identifier: Apache-2.0
// How far the .approx functions of a device are from the truth. Recorded vectors say that two
// devices are near each other; this says that each is near the function, over all its arguments. A
// list has what a GPU's largest errors are. Where the PTX ISA manual states no bound, a device may
// be as far from the truth as that GPU, or as the format makes it.
#pragma once

#include <string>

namespace conformance {

// Measures all functions on `samples` arguments each, spread evenly over all bit patterns, and
// writes the list.
int recordErrors(const std::string& file, unsigned samples, const std::string& only);
// Measures the same and says what exceeds its bound.
int checkErrors(const std::string& file, unsigned samples, const std::string& only);

} // namespace conformance
