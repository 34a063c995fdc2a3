// SPDX-License-Identifier: Apache-2.0
// Memory pools: limits, attributes and counts over ordinary allocations. What a pool's owner frees
// goes back to the system at once, so that a pool holds what is in use and nothing else.
#pragma once

#include "api/cuda/driver/shell.h"

namespace sunstone::api::cuda {

// New device memory that counts for the pool; null: the device's current one. Throws Failure with
// CUDA_ERROR_OUT_OF_MEMORY where the pool's size is reached, or CUDA_ERROR_INVALID_VALUE for a
// handle that is no live pool.
void* allocateFromPool(CUmemoryPool pool, size_t bytes);
// Call it when memory is freed, from a pool or not, with the number of the allocation: the address
// may be in use again already.
void forgetPoolMemory(const void* address, uint64_t allocation);
// Null if it comes from none.
CUmemoryPool poolOfMemory(const cpu::Allocation& allocation);

} // namespace sunstone::api::cuda
