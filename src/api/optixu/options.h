// SPDX-License-Identifier: Apache-2.0
// Translates options of nvcc to clang's.
#pragma once

#include <string>
#include <vector>

namespace sunstone::optixu {

// Applications pass options of nvcc: beside -I and -D often a target, fast mathematics and options
// of the host compiler. Options without effect on PTX are dropped; unknown options are passed on to
// clang.
std::vector<std::string> clangOptions(const std::vector<std::string>& nvccOptions);

} // namespace sunstone::optixu
