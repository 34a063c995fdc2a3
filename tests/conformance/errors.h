// SPDX-License-Identifier: Apache-2.0
// The largest errors of a device's .approx functions over all arguments. Recorded vectors only
// compare two devices with each other; this compares each with the exact function. A list holds a
// GPU's largest errors. Where the PTX ISA manual states no bound, a device may be as inexact as
// that GPU, or as the format requires.
#pragma once

#include <string>

namespace conformance {

// Measures all functions on `samples` arguments each, spread evenly over all bit patterns, and
// writes the list.
int recordErrors(const std::string& file, unsigned samples, const std::string& only);
// Measures the same and prints the errors that exceed their bounds.
int checkErrors(const std::string& file, unsigned samples, const std::string& only);

} // namespace conformance
