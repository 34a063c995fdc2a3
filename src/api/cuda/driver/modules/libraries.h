// SPDX-License-Identifier: Apache-2.0
// Libraries: code without a context. Each context gets a module of its own at the first use of the
// library. A kernel of a library represents its function in the current context.
#pragma once

#include "api/cuda/driver/modules/module.h"

namespace sunstone::api::cuda {

// The function in the current context; null for handles that are not kernels of libraries.
std::shared_ptr<Function> functionOfKernel(const void* handle);

} // namespace sunstone::api::cuda
