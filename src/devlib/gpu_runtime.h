// SPDX-License-Identifier: Apache-2.0
// The LLVM bitcode of the run-times of device programs on GPUs (devlib/gpu/runtime.cpp and
// runtime_classic.cpp), as the build made it.
#pragma once

#include <string_view>

namespace sunstone::devlib {

std::string_view gpuRuntime();        // of OptiX 7
std::string_view gpuClassicRuntime(); // of the classic API

} // namespace sunstone::devlib
