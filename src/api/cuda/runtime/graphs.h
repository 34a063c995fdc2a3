// SPDX-License-Identifier: Apache-2.0
// Shared by the graph functions of the runtime.
#pragma once

#include "api/cuda/runtime/runtime.h"

namespace sunstone::cudart {

// An entry point that passes its arguments to the driver function that `select` picks.
template <class Select, class... Args>
cudaError_t graphCall(Select&& select, Args... args) {
    return call([&](const Driver& d) { return present(select(d), args...); });
}

// Runtime and driver enumerations and structs have the same numbers and layouts.
static_assert(sizeof(cudaGraphExecUpdateResultInfo) == sizeof(CUgraphExecUpdateResultInfo));
static_assert(sizeof(cudaGraphInstantiateParams) == sizeof(CUDA_GRAPH_INSTANTIATE_PARAMS));
static_assert(sizeof(cudaGraphEdgeData) == 8 && sizeof(CUgraphEdgeData) == 8);
static_assert(sizeof(cudaKernelNodeParams) == 56 && sizeof(CUDA_KERNEL_NODE_PARAMS) == 72);

} // namespace sunstone::cudart
