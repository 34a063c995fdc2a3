// SPDX-License-Identifier: Apache-2.0
// Advice and prefetches for ranges of memory that host and device share. No data moves, because
// there is one memory; the values are stored for queries.
#pragma once

#include "api/cuda/driver/shell.h"

#include <optional>
#include <set>

namespace sunstone::api::cuda {

struct Advice {
    bool readMostly = false;
    std::optional<CUmemLocation> preferred, lastPrefetch;
    std::set<int> accessedBy; // devices, CU_DEVICE_CPU
};

// Throws Failure: CUDA_ERROR_INVALID_DEVICE for a device that does not exist,
// CUDA_ERROR_INVALID_VALUE for any other invalid location.
void requireLocation(const CUmemLocation& location);
// The location for the number in older functions: a device's, or CU_DEVICE_CPU.
CUmemLocation locationOf(CUdevice device);
// Throws Failure with CUDA_ERROR_INVALID_VALUE unless the range can have advice.
void requireShared(CUdeviceptr address, size_t bytes);
// Applies `change` to the advice of the range.
void advise(CUdeviceptr address, size_t bytes, const std::function<void(Advice&)>& change);

} // namespace sunstone::api::cuda
