// SPDX-License-Identifier: Apache-2.0
// Opacity micromap arrays in stream order; see accel.h.
#pragma once

#include "bvh/micromap/micromap_array.h"
#include "engine/context.h"

#include <memory>
#include <vector>

namespace sunstone::engine {

struct MicromapArrayBuild {
    std::vector<bvh::MicromapHistogramEntry> histogram;
    const void* states = nullptr;
    const void* descriptions = nullptr;
    uint32_t descriptionStride = 0;
    void* output = nullptr;
    size_t outputSize = 0;
    void* stream = nullptr;
};

// Queues the build. Descriptions and states are read when it runs; invalid ones are errors of the
// stream.
void buildMicromapArray(const std::shared_ptr<Context>& context, MicromapArrayBuild request);

// The relocation info of the array; waits for all streams.
bvh::RelocationInfo micromapRelocationInfo(const std::shared_ptr<Context>& context,
                                           const void* array);

// Queues the relocation of the copy at `array`.
void relocateMicromapArray(const std::shared_ptr<Context>& context, void* stream,
                           const bvh::RelocationInfo& info, void* array);

} // namespace sunstone::engine
