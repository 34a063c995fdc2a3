// SPDX-License-Identifier: Apache-2.0
// Compares the answers of two libraries, case by case, and holds what differs against a list of
// what is known and explained.
#pragma once

#include "recording.h"

#include <set>

namespace differential {

// `cases`: names of all, which both have to have answered. `differences`: a file with lines of
// case, what differs, at most how often, and why (see differences.txt). `missing`: names of cases
// that may fail to run ("differential." before the case). Prints a line for each case. Returns
// whether nothing unexplained differs.
bool compare(const std::vector<std::string>& cases, const std::vector<Answer>& reference,
             const std::vector<Answer>& ours, const std::string& differences,
             const std::set<std::string>& missing);

} // namespace differential
