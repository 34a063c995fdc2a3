// SPDX-License-Identifier: Apache-2.0
// The trace functions of each instruction set; trace.cpp chooses.
#pragma once

#include "devlib/trace.h"

namespace sunstone::devlib {

struct TraceSet {
    void (*traceGraph)(RayState*); // any traversable
    void (*traceGas)(RayState*);   // geometry acceleration structures only
    uint32_t (*report)(RayState*, float t, uint32_t kind);
    // The same for programs of the classic API; null in the checked set.
    void (*traceClassic)(RayState*);
    uint32_t (*reportClassic)(RayState*, float t, uint32_t material);
    uint32_t (*visitChild)(RayState*, uint32_t index);
    // The same for many rays; see traceBatch in trace.h. The checked set has the first alone.
    TraceBatchFn batchGraph, batchGas, batchClassic;
};

extern const TraceSet kTraceBaseline, kTraceAvx2, kTraceAvx512, kTraceChecked;

} // namespace sunstone::devlib
