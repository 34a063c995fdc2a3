// SPDX-License-Identifier: Apache-2.0
// Memory pools: limits, attributes and counts over ordinary allocations. Freed memory returns to
// the system at once, so a pool holds only memory in use.
#pragma once

#include "api/cuda/driver/shell.h"

namespace sunstone::api::cuda {

// Allocates device memory from a pool; null: the device's current pool. Throws Failure:
// CUDA_ERROR_OUT_OF_MEMORY if the pool's limit is reached, CUDA_ERROR_INVALID_VALUE if the handle
// is not a live pool.
void* allocateFromPool(CUmemoryPool pool, size_t bytes);
// Call when memory is freed, from a pool or not, with the id of the allocation, because the address
// may already be in use again.
void forgetPoolMemory(const void* address, uint64_t allocation);
// Null for memory that is not from a pool.
CUmemoryPool poolOfMemory(const cpu::Allocation& allocation);

} // namespace sunstone::api::cuda
