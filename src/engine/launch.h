// SPDX-License-Identifier: Apache-2.0
// Launches: the ray generation program runs once for each launch index; tiles of indices are spread
// over the worker threads.
#pragma once

#include "engine/pipeline.h"

namespace sunstone::engine {

struct LaunchRequest {
    std::shared_ptr<const Pipeline> pipeline;
    PipelineLimits limits; // as they are when the launch is made
    devlib::SbtView sbt{};
    const void* params = nullptr; // device address, read in stream order
    uint64_t paramsSize = 0;
    uint32_t width = 0, height = 0, depth = 0;
    void* stream = nullptr;
    bool validation = false; // exceptions of the run-time make the launch fail
};

// Queues the launch on its stream and returns. Faults found when it runs (a record of another
// pipeline, say) are logged and become the stream's error. Programs of one pipeline may run in
// several launches at once.
void launch(const std::shared_ptr<Context>& context, const LaunchRequest& request);

// For validation mode: the launch parameters must hold what the code is specialised to.
void checkBoundValues(const Pipeline& pipeline, const uint8_t* params);

} // namespace sunstone::engine
