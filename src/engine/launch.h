// SPDX-License-Identifier: Apache-2.0
// Launches: an entry program runs once for each launch index.
#pragma once

#include "engine/pipeline.h"

namespace sunstone::engine {

struct LaunchRequest {
    std::shared_ptr<const Pipeline> pipeline;
    PipelineLimits limits; // as they are when the launch is made
    // The program that runs for each index: the main program of the group that sbt.entryRecord
    // names, which is of this kind. Generations with several entry points keep a record for each.
    devlib::GroupKind entryKind = devlib::kGroupRaygen;
    devlib::SbtView sbt{};
    float* boxes = nullptr; // of bounds programs; see BoundsRequest
    uint32_t firstPrimitive = 0, motionStep = 0;
    const void* params = nullptr; // device address, read in stream order
    uint64_t paramsSize = 0;
    uint32_t width = 0, height = 0, depth = 0;
    void* stream = nullptr;
    bool validation = false; // exceptions of the run-time make the launch fail
    bool waits = false; // on GPUs: the call returns at the end of the launch and throws its failure
};

// Queues the launch on its stream and returns. Faults found when it runs (a record of another
// pipeline, say) are logged and become the stream's error. Programs of one pipeline may run in
// several launches at once.
void launch(const std::shared_ptr<Context>& context, const LaunchRequest& request);

// A launch of a bounds program (kGroupBounds) for `count` primitives. Each writes its box: six
// floats, lower x y z, upper x y z. The boxes follow one another in device memory.
struct BoundsRequest {
    std::shared_ptr<const Pipeline> pipeline;
    devlib::SbtView sbt{}; // entryRecord: of the program's group
    uint32_t count = 0;
    uint32_t firstPrimitive = 0; // index of the first one
    uint32_t motionStep = 0;     // given to programs that take one
    float* boxes = nullptr;
    const void* params = nullptr;
    uint64_t paramsSize = 0;
    void* stream = nullptr;
};
void launchBounds(const std::shared_ptr<Context>& context, const BoundsRequest& request);

// For validation mode: the launch parameters must have the values to which code is specialised.
void checkBoundValues(const Pipeline& pipeline, const uint8_t* params);

} // namespace sunstone::engine
