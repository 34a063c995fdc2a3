// SPDX-License-Identifier: Apache-2.0
// Launch parameters of line_of_sight.cu.
#pragma once

#include <cuda_runtime.h>

#include <optix.h>

constexpr unsigned kWatchers = 32;

struct SightParams {
    OptixTraversableHandle world;
    const float4* targets;
    const float4* watchers;
    unsigned* seenBy; // a bit for each watcher
    unsigned numTargets;
};
