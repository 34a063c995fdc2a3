// SPDX-License-Identifier: Apache-2.0
// Runs launch indices side by side, so that their rays are walked together.
//
// A thread gives each of up to kFibers launch indices a stack of its own. An index that traces a
// ray waits, and the next one runs. When all wait, TraceVariant::traceBatch walks their rays; then
// each index continues with its closest-hit or miss program. Programs run exactly as they do alone,
// recursion and exceptions included; only the order among launch indices differs. Walks of several
// rays hide memory latency and use vector lanes, see src/bvh/batch.
#pragma once

#include "devlib/trace.h"
#include "engine/cpu/runner.h"

namespace sunstone::engine::cpu {

// The data of a launch that keeps rays in flight.
struct InFlightLaunch {
    const devlib::LaunchState& launch; // the runner's, with traceInFlight as `trace`
    devlib::TraceBatchFn traceBatch;
};

// Runs the tiles from `first` to before `end`. False if there is no memory for stacks; no tile has
// run then.
bool runInFlight(Runner& runner, const InFlightLaunch& inFlight, const Tiling& tiling,
                 uint64_t first, uint64_t end);

// LaunchState::trace of such launches.
void traceInFlight(devlib::RayState* ray);

} // namespace sunstone::engine::cpu
