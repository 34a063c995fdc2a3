// SPDX-License-Identifier: Apache-2.0
// Libraries: code without a context. Each context that uses one gets a module of its own when it first
// does. A kernel of a library stands for its function in the context that is current.
#pragma once

#include "api/cuda/driver/module.h"

namespace sunstone::api::cuda {

// The function in the current context; null for handles that are no kernels of libraries.
std::shared_ptr<Function> functionOfKernel(const void* handle);

} // namespace sunstone::api::cuda
