// SPDX-License-Identifier: Apache-2.0
// The largest errors of a device's .approx functions over all arguments. Recorded vectors only
// compare two devices with each other; this compares a device with the exact function. A list has a
// GPU's largest errors. If the PTX ISA manual states no bound, a device may have the errors of that
// GPU, or those of the format.
#pragma once

#include <string>

namespace conformance {

// Measures all functions on `samples` arguments each, spread evenly over all bit patterns, and
// writes the list.
int recordErrors(const std::string& file, unsigned samples, const std::string& only);
// Measures all functions and prints the errors that exceed their bounds.
int checkErrors(const std::string& file, unsigned samples, const std::string& only);

} // namespace conformance
