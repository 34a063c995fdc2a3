// SPDX-License-Identifier: Apache-2.0
// Compares the answers of two libraries, case by case, and checks differences against a list of
// known and explained ones.
#pragma once

#include "recording.h"

#include <set>

namespace differential {

// `cases`: names of those of `allCases` that both libraries must have answered. `differences`: a
// file with lines of case, difference, count, digest and reason (see differences.txt). `missing`:
// names of cases that may fail to run ("differential." before the case). Prints a line for each
// case. Returns true if the differences are exactly those of the file.
bool compare(const std::vector<std::string>& cases, const std::vector<std::string>& allCases,
             const std::vector<Answer>& reference, const std::vector<Answer>& ours,
             const std::string& differences, const std::set<std::string>& missing);

} // namespace differential
