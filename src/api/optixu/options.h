// SPDX-License-Identifier: Apache-2.0
// Options of nvcc in clang's words.
#pragma once

#include <string>
#include <vector>

namespace sunstone::optixu {

// Applications pass what they wrote for nvcc: beside -I and -D often a target, fast mathematics and
// options of the host compiler. Options that do not matter for PTX are left out; clang judges
// options that are not nvcc's.
std::vector<std::string> clangOptions(const std::vector<std::string>& nvccOptions);

} // namespace sunstone::optixu
