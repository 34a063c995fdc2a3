// SPDX-License-Identifier: Apache-2.0
// What programs said of ranges of memory that host and device share: advice and prefetches. Nothing
// moves, since there is one memory; what was said can be asked.
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
// CUDA_ERROR_INVALID_VALUE for other places that are none.
void requireLocation(const CUmemLocation& location);
// A place by the number that older functions take: a device's, or CU_DEVICE_CPU.
CUmemLocation locationOf(CUdevice device);
// Throws Failure unless advice can be given on the range: CUDA_ERROR_INVALID_VALUE.
void requireShared(CUdeviceptr address, size_t bytes);
// Changes what is known of the range.
void advise(CUdeviceptr address, size_t bytes, const std::function<void(Advice&)>& change);

} // namespace sunstone::api::cuda
