// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace sunstone::bvh::gpu {

// The builder kernels as PTX text, compiled with the library.
const char* builderPtx();

// A PTX module of some kernels of another, with the functions they call and all its variables:
// compiling takes time that grows with the text. Kernels and functions begin at the start of a line,
// as LLVM writes them.
std::string moduleOf(std::string_view ptx, const std::vector<std::string_view>& kernels);

} // namespace sunstone::bvh::gpu
