// SPDX-License-Identifier: Apache-2.0
// The LLVM bitcode of the run-time of device programs on GPUs (devlib/gpu/runtime.cpp), as the
// build made it.
#pragma once

#include <string_view>

namespace sunstone::devlib {

std::string_view gpuRuntime();

} // namespace sunstone::devlib
