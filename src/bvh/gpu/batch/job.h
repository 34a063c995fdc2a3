// SPDX-License-Identifier: Apache-2.0
// The parameter of the batch kernels, shared by host and device.
#pragma once

#include "bvh/batch/ray_batch.h"

namespace sunstone::bvh::gpu {

// The most rays of a launch; longer batches take several launches.
constexpr uint64_t kLaunchRays = uint64_t(1) << 30;

struct BatchJob {
    RayBatch batch;
    uint64_t counter;     // uint32_t: rays given out; zero before the launch
    uint64_t found;       // for HitFormat::kBit: a byte for each ray
    uint32_t aligned;     // rays of 32 bytes at multiples of 16
    uint32_t wantedLanes; // with fewer busy lanes, idle lanes take new rays
};

} // namespace sunstone::bvh::gpu
