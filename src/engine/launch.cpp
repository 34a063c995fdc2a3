// SPDX-License-Identifier: Apache-2.0
#include "engine/launch.h"

#include "base/error.h"

namespace sunstone::engine {

void launch(const std::shared_ptr<Context>& context, const LaunchRequest& request) {
    context->backend->launch(context, request);
}

void launchBounds(const std::shared_ptr<Context>& context, const BoundsRequest& request) {
    LaunchRequest launch;
    launch.pipeline = request.pipeline;
    launch.limits = request.pipeline->limits.get();
    launch.entryKind = devlib::kGroupBounds;
    launch.sbt = request.sbt;
    launch.boxes = request.boxes;
    launch.firstPrimitive = request.firstPrimitive;
    launch.motionStep = request.motionStep;
    launch.params = request.params;
    launch.paramsSize = request.paramsSize;
    launch.width = request.count;
    launch.height = launch.depth = 1;
    launch.stream = request.stream;
    engine::launch(context, launch);
}

void checkBoundValues(const Pipeline& pipeline, const uint8_t* params) {
    for (const compiler::BoundValue& value : pipeline.boundValues) {
        const uint64_t end = value.offset + value.bytes.size();
        if (end > pipeline.launchParamsSize)
            continue;
        for (size_t i = 0; i < value.bytes.size(); ++i)
            if (params[value.offset + i] != value.bytes[i])
                fail(Code::kLaunchFailure, "byte ", value.offset + i,
                     " of the launch parameters is ", unsigned(params[value.offset + i]),
                     ", but bound value \"", value.annotation, "\" says ",
                     unsigned(value.bytes[i]));
    }
}

} // namespace sunstone::engine
