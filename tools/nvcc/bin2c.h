// SPDX-License-Identifier: Apache-2.0
// The toolkit's bin2c, which embeds files (often PTX) in programs as C arrays.
#pragma once

#include <string>
#include <vector>

namespace sunstone::nvcc {

// Prints the array; returns the exit code. Throws std::runtime_error for bad options and files.
int runBin2c(const std::vector<std::string>& words);

} // namespace sunstone::nvcc
